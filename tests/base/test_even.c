/* Splines on even knots: through their values, exact for cubics up to the ends, of order 4 there,
   too.
   test: splines on even knots have order 4 up to the ends */
#include "harness.h"
#include "base/even.h"

static PetscReal Value(PetscInt n, const PetscReal c[], PetscReal at, PetscReal *slope,
                       PetscReal *curve) {
  EvenSplines e;
  PetscReal value = 0;
  EvenEvaluate(n, at, &e);
  *slope = *curve = 0;
  for (int k = 0; k < 4; k++) {
    value += e.value[k] * c[e.first + k];
    *slope += e.slope[k] * c[e.first + k];
    *curve += e.curve[k] * c[e.first + k];
  }
  return value;
}

static void TestCubic(void **state) {
  enum { MOST = 12 };
  for (PetscInt n = EVEN_LEAST; n < MOST; n++) {
    PetscReal f[MOST], work[MOST], c[MOST + 2], slope, curve;
    for (PetscInt i = 0; i < n; i++) f[i] = ((0.3 * i - 1) * i + 2) * i - 5;
    EvenCoefficients(n, f, work, c);
    for (PetscReal z = -0.5; z < n; z += 0.17) {
      EXPECT(PetscAbsReal(Value(n, c, z, &slope, &curve) - (((0.3 * z - 1) * z + 2) * z - 5)) <
                 1e-11,
             "n %d, at %g", (int)n, z);
      EXPECT(PetscAbsReal(slope - ((0.9 * z - 2) * z + 2)) < 1e-11, "slope at %g", z);
      EXPECT(PetscAbsReal(curve - (1.8 * z - 2)) < 1e-11, "curve at %g", z);
    }
  }
}

static void TestOrder(void **state) {
  enum { MOST = 65 };
  PetscReal error[3] = {0};
  for (int m = 0; m < 3; m++) {
    PetscInt n = (16 << m) + 1;
    PetscReal f[MOST], work[MOST], c[MOST + 2], slope, curve, h = 4. / (n - 1);
    for (PetscInt i = 0; i < n; i++) f[i] = PetscSinReal(1.3 * i * h);
    EvenCoefficients(n, f, work, c);
    for (PetscReal x = 0; x <= 4; x += 0.0113)
      error[m] = PetscMax(error[m],
                          PetscAbsReal(Value(n, c, x / h, &slope, &curve) - PetscSinReal(1.3 * x)));
  }
  print_message("even splines: errors %.2e %.2e %.2e\n", error[0], error[1], error[2]);
  EXPECT(Order(error[1], error[2]) > 3.7, "order %g", Order(error[1], error[2]));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestCubic), cmocka_unit_test(TestOrder)};
MAIN(tests)
