/* The straight rod: its force, and the matrices D and K against integrals taken exactly.
   test: matrices of the straight rod are exact integrals | ranks 1 2 3 */
#include "harness.h"
#include "straight/pencil.h"
#include "straight/straight.h"
#include <petscblaslapack.h>

static const char *const laws[] = {"-growth_type uniform",
                                   "-growth_type gaussian -growth_width 0.4", "-growth_type feed"};
enum { LAWS = 3, FINE = 4000 };

static void Setup(Scene *scene, Straight *straight, const char *law, PetscReal mu, int cells) {
  SetOptions("%s -friction_mu %g -rod_cells %d -rod_grading uniform", law, mu, cells);
  CHECK(SceneCreate(scene));
  CHECK(StraightCreate(*scene, &(*scene)->mesh, WAY_X2, straight));
}

static void Teardown(Scene *scene, Straight *straight) {
  CHECK(StraightDestroy(straight));
  CHECK(SceneDestroy(scene));
}

/* V is s for uniform growth and 1 for feed; the force at the clamp is that of
   docs/notes/exact-answers.md. */
static void TestForce(void **state) {
  const PetscReal ends[2] = {0, 1}, t = 1.3, L = 1.8, b = 1e-3;
  StraightMotion at;
  PetscReal P[2];
  Scene scene;
  Straight straight;

  for (int k = 0; k < 3; k++) {
    PetscReal mu = k / 2.;
    Setup(&scene, &straight, laws[0], mu, 10);
    CHECK(StraightForce(scene, 2, ends, t, P));
    EXPECT(PetscAbsReal(
               P[0] - L * (mu * (PetscSqrtReal(1 + b) - PetscSqrtReal(b)) + (1 - mu) / 2)) < 1e-14,
           "mu %g: clamp force %g", (double)mu, (double)P[0]);
    CHECK(StraightAt(scene, 0.3, t, &at));
    EXPECT(PetscAbsReal(at.V - 0.3) < 1e-15, "V %g", (double)at.V);
    Teardown(&scene, &straight);
  }
  Setup(&scene, &straight, laws[2], 1, 10);
  for (int k = 0; k <= 10; k++) {
    CHECK(StraightAt(scene, k / 10., t, &at));
    EXPECT(PetscAbsReal(at.V - 1) < 1e-15, "feed: V %g at %d/10", (double)at.V, k);
  }
  CHECK(StraightForce(scene, 2, ends, t, P));
  EXPECT(PetscAbsReal(P[0] - L / PetscSqrtReal(1 + b)) < 1e-14, "feed: force %g", (double)P[0]);
  Teardown(&scene, &straight);
}

/* The force by labels far apart and close together agree: gaussian growth is integrated, not known.
 */
static void TestForceIntegrated(void **state) {
  static PetscReal s[FINE + 1], P[FINE + 1], Q[101];
  Scene scene;
  Straight straight;

  Setup(&scene, &straight, laws[1], 0.5, 10);
  for (int i = 0; i <= FINE; i++) s[i] = (PetscReal)i / FINE;
  CHECK(StraightForce(scene, FINE + 1, s, 1.3, P));
  for (int i = 0; i <= 100; i++) s[i] = i / 100.;
  CHECK(StraightForce(scene, 101, s, 1.3, Q));
  for (int i = 0; i <= 100; i++)
    EXPECT(PetscAbsReal(Q[i] - P[i * FINE / 100]) < 1e-8, "at %d: %.12g %.12g", i, (double)Q[i],
           (double)P[i * FINE / 100]);
  Teardown(&scene, &straight);
}

/* Coefficients of y = s^2 and s^3 in the splines, by their polar forms. */
static void Coefficients(const Mesh *mesh, int power, PetscReal c[]) {
  for (PetscInt j = 0; j <= mesh->cells; j++) {
    PetscReal k[3];
    for (int m = 0; m < 3; m++) k[m] = mesh->s[PetscMax(0, PetscMin(j + m, mesh->cells))];
    c[j] = power == 2 ? (k[0] * k[1] + k[0] * k[2] + k[1] * k[2]) / 3 : k[0] * k[1] * k[2];
  }
}

/* <a, K b> and <a, D b> for a = s^i, b = s^j by Gauss quadrature in many small cells. */
static void Integrals(Scene scene, PetscReal t, int i, int j, PetscReal *K, PetscReal *D) {
  PetscInt n = FINE * GAUSS;
  PetscReal *s, *P;

  CHECK(PetscMalloc2(n + 1, &s, n + 1, &P));
  for (PetscInt k = 0; k < n; k++) s[k] = (k / GAUSS + gauss_point[k % GAUSS]) / FINE;
  s[n] = 1;
  CHECK(StraightForce(scene, n + 1, s, t, P));
  *K = *D = 0;
  for (PetscInt k = 0; k < n; k++) {
    PetscReal z = s[k], ds = gauss_weight[k % GAUSS] / FINE, g, g_s, p, v, phi;
    PetscReal a = PetscPowReal(z, i), a1 = i * PetscPowReal(z, i - 1),
              a2 = i * (i - 1) * PetscPowReal(z, i - 2), b = PetscPowReal(z, j),
              b1 = j * PetscPowReal(z, j - 1), b2 = j * (j - 1) * PetscPowReal(z, j - 2);
    CHECK(GrowthStretch(scene->growth, 1, &z, t, &g, NULL, &g_s));
    CHECK(GrowthArc(scene->growth, 1, &z, t, &p, &v));
    v += GrowthSlide(scene->growth, z, 1);
    phi = LoadAxialDrag(&scene->load, &(Place){.s = z, .t = t}, v);
    *K += ds * (-(a2 / g - a1 * g_s / (g * g)) * (b2 / g - b1 * g_s / (g * g)) / g +
                P[k] / g * a1 * b1 - phi * GrowthSlide(scene->growth, z, 1) * a * b1);
    *D += ds * g * phi * a * b;
  }
  CHECK(PetscFree2(s, P));
}

static PetscReal Product(PetscInt n, const PetscReal *band, const PetscReal *a,
                         const PetscReal *b) {
  PetscReal sum = 0;
  for (PetscInt i = 0; i < n; i++)
    for (int k = 0; k < BAND; k++) {
      PetscInt j = i - 3 + k;
      if (j >= 0 && j < n) sum += a[i] * band[i * BAND + k] * b[j];
    }
  return sum;
}

static void TestBands(void **state) {
  for (int l = 0; l < LAWS; l++) {
    PetscReal *K, *D, *c[4], want[2];
    Scene scene;
    Straight straight;
    PetscInt n;
    Setup(&scene, &straight, laws[l], 0.7, 60);
    n = straight->n;
    CHECK(PetscMalloc4(n * BAND, &K, n * BAND, &D, n, &c[2], n, &c[3]));
    CHECK(StraightBands(straight, 1.3, 0, n, K, D));
    for (int i = 2; i <= 3; i++) Coefficients(&scene->mesh, i, c[i]);
    for (int i = 2; i <= 3; i++)
      for (int j = 2; j <= 3; j++) {
        Integrals(scene, 1.3, i, j, &want[0], &want[1]);
        EXPECT(PetscAbsReal(Product(n, K, c[i], c[j]) - want[0]) < 1e-8,
               "%s: <s^%d, K s^%d> %.12g, not %.12g", laws[l], i, j,
               (double)Product(n, K, c[i], c[j]), (double)want[0]);
        EXPECT(PetscAbsReal(Product(n, D, c[i], c[j]) - want[1]) < 1e-8,
               "%s: <s^%d, D s^%d> %.12g, not %.12g", laws[l], i, j,
               (double)Product(n, D, c[i], c[j]), (double)want[1]);
      }
    CHECK(PetscFree4(K, D, c[2], c[3]));
    Teardown(&scene, &straight);
  }
}

/* Any rows can be had alone, and they are those of the whole. */
static void TestRows(void **state) {
  PetscReal *K, *D, k[5 * BAND], d[5 * BAND];
  Scene scene;
  Straight straight;
  PetscInt n;

  Setup(&scene, &straight, laws[1], 1, 20);
  n = straight->n;
  CHECK(PetscMalloc2(n * BAND, &K, n * BAND, &D));
  CHECK(StraightBands(straight, 0.9, 0, n, K, D));
  for (PetscInt first = 0; first + 5 <= n; first++) {
    CHECK(StraightBands(straight, 0.9, first, first + 5, k, d));
    for (int i = 0; i < 5 * BAND; i++)
      EXPECT(k[i] == K[first * BAND + i] && d[i] == D[first * BAND + i], "row %d", (int)first);
  }
  CHECK(PetscFree2(K, D));
  Teardown(&scene, &straight);
}

static PetscReal LargestOfK(Straight straight, PetscReal t) {
  PetscInt n = straight->n;
  PetscBLASInt nb = (PetscBLASInt)n, lwork = 10 * nb, info;
  PetscReal *K, *D, *A, *values, *work, most;

  CHECK(PetscCalloc5(n * BAND, &K, n * BAND, &D, n * n, &A, n, &values, 10 * n, &work));
  CHECK(StraightBands(straight, t, 0, n, K, D));
  for (PetscInt i = 0; i < n; i++)
    for (int b = 0; b < BAND; b++)
      if (i - 3 + b >= 0 && i - 3 + b < n) A[i * n + i - 3 + b] = K[i * BAND + b];
  LAPACKsyev_("N", "U", &nb, A, &nb, values, work, &lwork, &info);
  assert_int_equal(info, 0);
  most = values[n - 1];
  CHECK(PetscFree5(K, D, A, values, work));
  return most;
}

/* K turns indefinite at the critical length of docs/notes/exact-answers.md. */
static void TestCritical(void **state) {
  const struct {
    PetscReal mu, beta, length;
  } rows[] = {{1, 1e-6, 1.9863534938},
              {1, 1e-3, 1.9871337245},
              {1, 1e-2, 1.9938850326},
              {0.5, 1e-3, 2.0717173057},
              {0, 1e-3, 2.17177006749}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) {
    Scene scene;
    Straight straight;
    Setup(&scene, &straight, laws[0], rows[k].mu, 64);
    scene->load.friction.beta = rows[k].beta;
    EXPECT(LargestOfK(straight, rows[k].length - 0.5 - 1e-6) < 0, "mu %g: unstable too early",
           (double)rows[k].mu);
    EXPECT(LargestOfK(straight, rows[k].length - 0.5 + 1e-6) > 0, "mu %g: stable too long",
           (double)rows[k].mu);
    Teardown(&scene, &straight);
  }
}

/* The accurate form of the same matrices (pencil.h): K = C^-T K_w C^-1 + X C^-1. */
static void TestPencil(void **state) {
  for (int l = 0; l < LAWS; l += 2) {
    PetscReal *K, *D, size, difference;
    Mat A = NULL, Kw = NULL, X = NULL, Dc = NULL, E;
    Vec c, w, a, b;
    Scene scene;
    Straight straight;
    Pencil pencil;
    Setup(&scene, &straight, laws[l], 0.7, 40);
    CHECK(PencilCreate(PETSC_COMM_WORLD, scene, &scene->mesh, 1.3, WAY_X2, &pencil));
    CHECK(PencilSetTime(pencil, 1.3, FRAME_LABEL));
    CHECK(PencilMatrix(pencil, FORM_STIFF, &Kw));
    CHECK(PencilMatrix(pencil, FORM_SLIDE, &X));
    CHECK(PencilMatrix(pencil, FORM_DRAG, &Dc));
    CHECK(PencilDifference(pencil, &E));
    CHECK(PetscMalloc2((pencil->last - pencil->first) * BAND, &K,
                       (pencil->last - pencil->first) * BAND, &D));
    CHECK(StraightBands(straight, 1.3, pencil->first, pencil->last, K, D));
    CHECK(PencilMatrixFromBand(pencil, K, &A));
    CHECK(MatCreateVecs(A, &c, &w));
    CHECK(VecDuplicate(c, &a));
    CHECK(VecDuplicate(c, &b));
    for (PetscInt i = pencil->first; i < pencil->last; i++)
      CHECK(VecSetValue(w, i, Scatter(1, (uint64_t)i), INSERT_VALUES));
    CHECK(VecAssemblyBegin(w));
    CHECK(VecAssemblyEnd(w));
    CHECK(PencilSum(pencil, w, c));
    CHECK(MatMult(A, c, a));
    CHECK(VecNorm(a, NORM_2, &size));
    CHECK(MatMult(X, w, b));
    CHECK(VecAXPY(a, -1, b));
    CHECK(MatMult(Kw, w, b));
    CHECK(PencilUnsumTranspose(pencil, E, b, c));
    CHECK(VecAXPY(a, -1, c));
    CHECK(VecNorm(a, NORM_2, &difference));
    EXPECT(difference < 1e-11 * size, "%s: %g of %g", laws[l], (double)difference, (double)size);
    CHECK(PencilMatrixFromBand(pencil, D, &A));
    CHECK(MatAXPY(A, -1, Dc, SAME_NONZERO_PATTERN));
    CHECK(MatNorm(A, NORM_FROBENIUS, &difference));
    EXPECT(difference < 1e-14, "%s: D off by %g", laws[l], (double)difference);
    CHECK(PetscFree2(K, D));
    CHECK(MatDestroy(&A));
    CHECK(MatDestroy(&Kw));
    CHECK(MatDestroy(&X));
    CHECK(MatDestroy(&Dc));
    CHECK(MatDestroy(&E));
    CHECK(VecDestroy(&a));
    CHECK(VecDestroy(&b));
    CHECK(VecDestroy(&c));
    CHECK(VecDestroy(&w));
    CHECK(PencilDestroy(&pencil));
    Teardown(&scene, &straight);
  }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestForce),    cmocka_unit_test(TestForceIntegrated),
    cmocka_unit_test(TestBands),    cmocka_unit_test(TestRows),
    cmocka_unit_test(TestCritical), cmocka_unit_test(TestPencil)};

MAIN(tests)
