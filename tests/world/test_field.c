/* Fields and layers: the interpolant has continuous slopes, which its derivatives are, also at the
   entries and the edges; its order; layers are what they are asked to be. And the stiffness.
   test: fields are met with their slopes | ranks 1 2 */
#include "harness.h"
#include "world/field.h"
#include "material/stiffness.h"

static PetscReal Wavy(PetscReal x1, PetscReal x2, PetscReal t) {
  return 3 + PetscSinReal(x1 + 0.3 * t) * PetscCosReal(0.7 * x2) + 0.2 * t;
}

/* n entries along each of x1, x2 in [-2, 2] and, if timed, t in [0, 2] */
static Field Tabulated(PetscInt n, PetscBool timed) {
  PetscInt nt = timed ? n : 1, dims[3] = {nt, n, n};
  PetscReal *x, *t, *factor;
  char path[64];
  Field field;
  CHECK(PetscMalloc3(n, &x, nt, &t, nt * n * n, &factor));
  for (PetscInt i = 0; i < n; i++) x[i] = -2 + 4. * i / (n - 1);
  for (PetscInt k = 0; k < nt; k++) t[k] = timed ? 2. * k / (n - 1) : 0;
  for (PetscInt k = 0; k < nt; k++)
    for (PetscInt j = 0; j < n; j++)
      for (PetscInt i = 0; i < n; i++) factor[(k * n + j) * n + i] = Wavy(x[i], x[j], t[k]);
  OpenScratch(path);
  WriteScratch(path, timed ? 4 : 3, (const char *[]){"/x1", "/x2", "/factor", "/t"},
               (int[]){1, 1, timed ? 3 : 2, 1},
               (const PetscInt *[]){dims + 2, dims + 1, timed ? dims : dims + 1, dims},
               (const PetscReal *[]){x, x, factor, t});
  CHECK(FieldFromFile("-friction_field", path, &field));
  RemoveFile(path);
  CHECK(PetscFree3(x, t, factor));
  return field;
}

static PetscReal At(Field field, PetscReal x1, PetscReal x2, PetscReal t, PetscReal slope[2]) {
  PetscReal factor, all[3];
  FieldAt(field, (PetscReal[]){x1, x2, 0}, t, &factor, all);
  slope[0] = all[0];
  slope[1] = all[1];
  return factor;
}

/* Values and slopes do not jump, and slopes are the difference quotients, on a walk through it and
   beyond its edges. */
static void Smooth(const char *what, Field field, PetscReal t, PetscReal size) {
  PetscReal jump = 0, bend = 0, off = 0;
  const PetscReal h = 1e-5, tiny = 1e-11;
  for (int i = 0; i <= 600; i++) { /* every fifth is an entry of a table, an edge of a layer */
    PetscReal x1 = -3 + 0.01 * i, x2 = -2.5 + 0.009 * i, a[2], b[2], c[2];
    PetscReal before = At(field, x1 - tiny, x2 - tiny, t, a),
              after = At(field, x1 + tiny, x2 + tiny, t, b);
    jump = PetscMax(jump, PetscAbsReal(after - before));
    bend = PetscMax(bend, PetscMax(PetscAbsReal(b[0] - a[0]), PetscAbsReal(b[1] - a[1])));
    for (int d = 0; d < 2; d++) {
      PetscReal e1 = d ? 0 : h, e2 = d ? h : 0;
      PetscReal by =
          (At(field, x1 + e1, x2 + e2, t, c) - At(field, x1 - e1, x2 - e2, t, c)) / (2 * h);
      (void)At(field, x1, x2, t, c);
      off = PetscMax(off, PetscAbsReal(by - c[d]));
    }
  }
  print_message("%s: jumps %.1e, of slopes %.1e, slopes off by %.1e\n", what, jump, bend, off);
  EXPECT(jump < 1e-9 * size, "%s: jumps by %g", what, jump);
  EXPECT(bend < 1e-8 * size, "%s: slopes jump by %g", what, bend);
  EXPECT(off < 3e-5 * size, "%s: slopes off by %g", what, off);
}

static void TestSmooth(void **state) {
  Field field = Tabulated(9, PETSC_TRUE);
  PetscReal slope[2], edge[2], beyond[2];
  for (PetscReal t = -0.3; t < 2.5; t += 0.25) Smooth("table", field, t, 3);
  for (int i = 0; i < 9; i++)
    for (int k = 0; k < 9; k++)
      EXPECT(PetscAbsReal(At(field, -2 + 0.5 * i, 0.5, 0.25 * k, slope) -
                          Wavy(-2 + 0.5 * i, 0.5, 0.25 * k)) < 1e-13,
             "not the entry at %d, time %d", i, k);
  EXPECT(At(field, 2, 0.3, 1, edge) == At(field, 7, 0.3, 1, beyond) && beyond[0] == 0,
         "not constant beyond the edge");
  EXPECT(At(field, 0.4, 0.3, 2, edge) == At(field, 0.4, 0.3, 9, beyond), "not constant in the end");
  CHECK(FieldDestroy(&field));
  field = Tabulated(9, PETSC_FALSE);
  Smooth("table without time", field, 5, 3);
  CHECK(FieldDestroy(&field));
}

static void TestOrder(void **state) {
  PetscReal error[3] = {0}, slope[2];
  for (int k = 0; k < 3; k++) {
    Field field = Tabulated((16 << k) + 1, PETSC_FALSE);
    for (PetscReal x = -1; x < 1; x += 0.0137) /* away from the edges, where it is flat */
      error[k] =
          PetscMax(error[k], PetscAbsReal(At(field, x, 0.5 * x, 0, slope) - Wavy(x, 0.5 * x, 0)));
    CHECK(FieldDestroy(&field));
  }
  print_message("field: errors %.2e %.2e %.2e, order %.2f\n", error[0], error[1], error[2],
                Order(error[1], error[2]));
  EXPECT(Order(error[1], error[2]) > 3.7, "order %g", Order(error[1], error[2]));
}

static void TestLayers(void **state) {
  Field field;
  PetscReal slope[2], sum = 0;
  CHECK(FieldFromLayers("-friction_layers", "-1:1,0.5:2.5,2:0.4", 0.2, &field));
  Smooth("layers", field, 0, 50);
  EXPECT(At(field, -5, 3, 1, slope) == 1 && slope[0] == 0, "the first layer");
  EXPECT(At(field, 0.39, 3, 1, slope) == 1 && At(field, 0.61, 0, 0, slope) == 2.5, "the second");
  EXPECT(PetscAbsReal(At(field, 0.5, 0, 0, slope) - 1.75) < 1e-15, "half way");
  EXPECT(PetscAbsReal(At(field, 9, 0, 0, slope) - 0.4) < 1e-15, "the last");
  for (int i = 0; i < 4000; i++) sum += At(field, 1 + 0.0005 * (i + 0.5), 0, 0, slope) * 0.0005;
  EXPECT(PetscAbsReal(sum - (2.5 + 0.4)) < 1e-6, "int %g from 1 to 3", sum);
  CHECK(FieldDestroy(&field));
}

/* B over the distance from the tip, its rate for the material. */
static void TestStiffness(void **state) {
  enum { N = 9 };
  const char *const laws[] = {"uniform", "gaussian", "feed", "apical"};
  PetscInt n = N;
  PetscReal distance[N], factor[N];
  char path[64];
  OpenScratch(path);
  for (int i = 0; i < N; i++) {
    distance[i] = 0.25 * i;
    factor[i] = 1 + 0.5 * distance[i] * (4 - distance[i]); /* slope 0 at its end, 2 */
  }
  WriteScratch(path, 2, (const char *[]){"/distance", "/factor"}, (int[]){1, 1},
               (const PetscInt *[]){&n, &n}, (const PetscReal *[]){distance, factor});
  for (int k = 0; k < 4; k++) {
    Growth growth;
    Stiffness stiffness;
    SetOptions("-growth_type %s -growth_initial_length 1.5 -rod_stiffness_file %s", laws[k], path);
    CHECK(GrowthCreate(&growth));
    CHECK(StiffnessSetFromOptions(&stiffness));
    for (int i = 0; i <= 20; i++) {
      PetscReal s = i / 20., t = 1.2, p, L, B, B_t, d, h = 1e-5, by[2];
      CHECK(GrowthArc(growth, 1, &s, t, &p, NULL));
      CHECK(GrowthLength(growth, t, &L, NULL));
      d = PetscMin(L - p, 2);
      CHECK(StiffnessTable(&stiffness, growth, s, t, &B, &B_t));
      EXPECT(PetscAbsReal(B - (1 + 0.5 * d * (4 - d))) < 1e-13, "%s: B %.15g at distance %g",
             laws[k], B, d);
      if (i == 0 || i == 20 || PetscAbsReal(L - p - 2) < 0.01) continue;
      for (int e = 0; e < 2; e++) { /* the material moves on among the labels: s_t = c / g */
        PetscReal step = e ? h : -h, g;
        CHECK(GrowthStretch(growth, 1, &s, t, &g, NULL, NULL));
        CHECK(StiffnessTable(&stiffness, growth, s + step * GrowthSlide(growth, s, t) / g, t + step,
                             &by[e], NULL));
      }
      EXPECT(PetscAbsReal((by[1] - by[0]) / (2 * h) - B_t) < 1e-8, "%s: B_t %g, not %g, at s %g",
             laws[k], B_t, (by[1] - by[0]) / (2 * h), s);
    }
    CHECK(StiffnessDestroy(&stiffness));
    CHECK(GrowthDestroy(&growth));
  }
  RemoveFile(path);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestSmooth), cmocka_unit_test(TestOrder),
                                          cmocka_unit_test(TestLayers),
                                          cmocka_unit_test(TestStiffness)};
MAIN(tests)
