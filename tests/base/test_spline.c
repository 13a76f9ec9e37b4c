/* Not-a-knot splines: exact for cubics on any knots, fourth order for smooth functions up to the
   ends, rows and strides kept apart.
   test: splines are exact for cubics and of order 4 */
#include "harness.h"
#include "base/lagrange.h"
#include "base/spline.h"
#include <petscdt.h>

static PetscReal Cubic(PetscReal x) {
  return 1 - 2 * x + 3 * x * x - 0.7 * x * x * x;
}

static PetscReal CubicSlope(PetscReal x) {
  return -2 + 6 * x - 2.1 * x * x;
}

static PetscReal CubicIntegral(PetscReal x) {
  return x - x * x + x * x * x - 0.175 * x * x * x * x;
}

static PetscReal Apply(const PetscReal w[4], const PetscReal *f, const PetscReal *f2, PetscInt i) {
  return w[0] * f[i] + w[1] * f[i + 1] + w[2] * f2[i] + w[3] * f2[i + 1];
}

static void TestExactForCubics(void **state) {
  const PetscReal x[7] = {-0.3, 0, 0.1, 0.5, 0.55, 1.3, 2};
  PetscReal f[7], f2[7], value[4], slope[4], integral[4];
  PetscInt i;
  for (int k = 0; k < 7; k++) f[k] = Cubic(x[k]);
  CHECK(SplineSecondDerivatives(7, x, 1, 7, 1, f, f2));
  for (PetscReal at = -0.5; at < 2.2; at += 0.0377) { /* a little beyond both ends as well */
    SplineWeights(7, x, at, &i, value, slope, integral);
    EXPECT(i >= 0 && i < 6 && (at < x[0] || x[i] <= at) && (at > x[6] || at < x[i + 1]),
           "%g is not in interval %d", at, (int)i);
    EXPECT(PetscAbsReal(Apply(value, f, f2, i) - Cubic(at)) < 1e-13, "value at %g", at);
    EXPECT(PetscAbsReal(Apply(slope, f, f2, i) - CubicSlope(at)) < 1e-12, "slope at %g", at);
    EXPECT(PetscAbsReal(Apply(integral, f, f2, i) - CubicIntegral(at) + CubicIntegral(x[i])) <
               1e-13,
           "integral at %g", at);
  }
}

/* Two rows, interleaved: the row stride is 1, the stride 2. */
static void TestStrides(void **state) {
  const PetscReal x[5] = {0, 1, 1.5, 3, 4};
  PetscReal f[10], f2[10];
  for (int k = 0; k < 5; k++) {
    f[2 * k] = Cubic(x[k]);
    f[2 * k + 1] = x[k] * x[k];
  }
  CHECK(SplineSecondDerivatives(5, x, 2, 1, 2, f, f2));
  for (int k = 0; k < 5; k++) {
    EXPECT(PetscAbsReal(f2[2 * k] - (6 - 4.2 * x[k])) < 1e-12, "row 0, knot %d: %g", k, f2[2 * k]);
    EXPECT(PetscAbsReal(f2[2 * k + 1] - 2) < 1e-12, "row 1, knot %d: %g", k, f2[2 * k + 1]);
  }
}

/* The steepest of the entries before an end: 2 -> 1 over 0.1 is 0.2, and what does not change is
 * long. */
static void TestSteepest(void **state) {
  const PetscReal x[5] = {0, 1, 1.5, 1.6, 1.61}, f[5] = {2, 2, 2, 1, 5};
  EXPECT(PetscAbsReal(SplineSteepest(5, x, f, 1.6) - 0.2) < 1e-14, "%g",
         SplineSteepest(5, x, f, 1.6));
  EXPECT(PetscAbsReal(SplineSteepest(5, x, f, 2) - 0.0125) < 1e-14, "%g",
         SplineSteepest(5, x, f, 2));
  EXPECT(SplineSteepest(5, x, f, 1.5) == PETSC_MAX_REAL, "%g", SplineSteepest(5, x, f, 1.5));
}

static void TestOrder(void **state) {
  PetscReal error[3] = {0}, slope_error[3] = {0};
  for (int k = 0; k < 3; k++) {
    const PetscInt n = (20 << k) + 1;
    PetscReal x[81], f[81], f2[81], value[4], slope[4];
    PetscInt i;
    for (PetscInt j = 0; j < n; j++) {
      x[j] = (PetscReal)j / (n - 1);
      x[j] += 0.2 * x[j] * (1 - x[j]); /* uneven */
      f[j] = PetscExpReal(PetscSinReal(4 * x[j]));
    }
    CHECK(SplineSecondDerivatives(n, x, 1, n, 1, f, f2));
    for (PetscReal at = 0; at <= 1; at += 0.00137) {
      PetscReal exact = PetscExpReal(PetscSinReal(4 * at));
      SplineWeights(n, x, at, &i, value, slope, NULL);
      error[k] = PetscMax(error[k], PetscAbsReal(Apply(value, f, f2, i) - exact));
      slope_error[k] = PetscMax(
          slope_error[k], PetscAbsReal(Apply(slope, f, f2, i) - 4 * PetscCosReal(4 * at) * exact));
    }
  }
  print_message("spline: order %.2f, of the slope %.2f\n", Order(error[1], error[2]),
                Order(slope_error[1], slope_error[2]));
  EXPECT(Order(error[1], error[2]) > 3.7, "order %g", Order(error[1], error[2]));
  EXPECT(Order(slope_error[1], slope_error[2]) > 2.7, "order of the slope %g",
         Order(slope_error[1], slope_error[2]));
}

/* The table of Gauss's points is that of PETSc, on [0,1]. */
static void TestGauss(void **state) {
  PetscReal x[GAUSS], w[GAUSS];

  (void)state;
  CHECK(PetscDTGaussQuadrature(GAUSS, 0, 1, x, w));
  for (int q = 0; q < GAUSS; q++) {
    EXPECT(PetscAbsReal(x[q] - gauss_point[q]) < 1e-15, "point %d is %.17g", q, gauss_point[q]);
    EXPECT(PetscAbsReal(w[q] - gauss_weight[q]) < 1e-15, "weight %d is %.17g", q, gauss_weight[q]);
  }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestGauss), cmocka_unit_test(TestExactForCubics),
    cmocka_unit_test(TestStrides), cmocka_unit_test(TestSteepest), cmocka_unit_test(TestOrder)};
MAIN(tests)
