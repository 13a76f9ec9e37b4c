/* The nodes: even where growth is, and where it is not, equidistant in int (g/L + 1/2) ds; behind a
   narrow zone cells become longer by little from one to the next.
   test: nodes are even where growth is and where it is not */
#include "harness.h"
#include "material/mesh.h"

static void Create(const char *options, PetscInt cells, PetscBool graded, PetscReal end,
                   Growth *growth, Mesh *mesh) {
  SetOptions("%s", options);
  CHECK(GrowthCreate(growth));
  CHECK(MeshCreate(cells, graded, *growth, end, mesh));
  EXPECT(mesh->cells == cells && mesh->s[0] == 0 && mesh->s[cells] == 1, "ends");
  for (PetscInt i = 1; i <= cells; i++)
    EXPECT(mesh->s[i] > mesh->s[i - 1], "node %d is not right of its neighbour", (int)i);
}

static void Destroy(Growth *growth, Mesh *mesh) {
  CHECK(GrowthDestroy(growth));
  CHECK(MeshDestroy(mesh));
}

static void TestEven(void **state) {
  const char *laws[] = {"-growth_type gaussian", "-growth_type uniform", "-growth_type feed"};
  for (int l = 0; l < 3; l++) { /* graded makes no difference to laws without a place */
    Growth growth;
    Mesh mesh;
    Create(laws[l], 37, (PetscBool)(l > 0), 20, &growth, &mesh);
    for (PetscInt i = 0; i <= 37; i++)
      EXPECT(PetscAbsReal(mesh.s[i] - i / 37.) < 1e-15, "%s: node %d at %g", laws[l], (int)i,
             mesh.s[i]);
    Destroy(&growth, &mesh);
  }
}

static void TestGraded(void **state) {
  const PetscReal widths[] = {5, 0.5, 0.05, 0.005, 1e-4};
  for (int w = 0; w < 5; w++) {
    char options[80];
    const PetscInt n = 200;
    PetscReal L, p[201];
    Growth growth;
    Mesh mesh;
    snprintf(options, sizeof(options), "-growth_type gaussian -growth_width %g", widths[w]);
    Create(options, n, PETSC_TRUE, 20, &growth, &mesh);
    CHECK(GrowthLength(growth, 20, &L, NULL));
    CHECK(GrowthArc(growth, n + 1, mesh.s, 20, p, NULL));
    for (PetscInt i = 0; i < n; i++) {
      PetscReal a = widths[w], all = a < 0.02 ? 2.25 : 1.5,
                share = (p[i + 1] - p[i]) / L + (mesh.s[i + 1] - mesh.s[i]) / 2;
      if (a < 0.02)
        share += 0.75 * (asinh(mesh.s[i + 1] / a) - asinh(mesh.s[i] / a)) / asinh(1 / a);
      EXPECT(PetscAbsReal(share * n / all - 1) < 1e-9, "width %g, cell %d: %g of its share",
             widths[w], (int)i, share * n / all);
      EXPECT(i == 0 || mesh.s[i + 1] - mesh.s[i] < 1.5 * (mesh.s[i] - mesh.s[i - 1]),
             "width %g, cell %d is much longer than the one before", widths[w], (int)i);
      EXPECT(p[i + 1] - p[i] < 1.0001 * all * L / n, "width %g, cell %d is %g long", widths[w],
             (int)i, p[i + 1] - p[i]);
    }
    Destroy(&growth, &mesh);
  }
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestEven), cmocka_unit_test(TestGraded)};
MAIN(tests)
