/* Friction: the law, its primal slope by rate, and the dual of Chan, Golub and Mulet.
   test: friction and its derivative are those of its law */
#include "harness.h"
#include "world/friction.h"

static Friction Create(const char *options) {
  Friction law;
  SetOptions("%s", options);
  CHECK(FrictionSetFromOptions(&law));
  return law;
}

static void Force(const Friction *law, const PetscReal v[2], PetscReal f[2]) {
  PetscReal phi = FrictionPhi(law, v[0] * v[0] + v[1] * v[1]);
  for (int d = 0; d < 2; d++) f[d] = phi * v[d];
}

/* phi = (1 - mu) + mu / sqrt(v^2 + beta), as docs/theory/friction.md has it. */
static void TestLaw(void **state) {
  Friction law = Create("-friction_mu 0.3 -friction_beta 0.21");
  EXPECT(PetscAbsReal(FrictionPhi(&law, 4) - (0.7 + 0.3 / PetscSqrtReal(4.21))) < 1e-15, "phi %g",
         FrictionPhi(&law, 4));
  law = Create("-friction_mu 0");
  EXPECT(FrictionPhi(&law, 9) == 1, "viscous: phi %g", FrictionPhi(&law, 9));
  law = Create("");
  EXPECT(law.mu == 1 && law.beta == 1e-3 && law.newton == NEWTON_PRIMAL_DUAL, "defaults");
}

/* The dual that belongs to v. */
static void Settle(const Friction *law, const PetscReal v[2], FrictionDual *dual) {
  FrictionFollow(2, law, v, PETSC_TRUE, dual);
  FrictionFollow(2, law, v, PETSC_FALSE, dual);
}

/* |f(v + e w) - f(v) - e f'(v) w| falls fourfold when e is halved. */
static void TestPrimalSlope(void **state) {
  const char *laws[] = {"-friction_newton primal",
                        "-friction_newton primal -friction_mu 0.4 -friction_beta 0.1"};
  const PetscReal points[][2] = {{0.3, -0.2}, {1, 2}, {-0.01, 0.02}, {1e-3, 0}};
  for (int l = 0; l < 2; l++)
    for (int p = 0; p < 4; p++) {
      Friction law = Create(laws[l]);
      const PetscReal *v = points[p], w[2] = {0.7, 0.4}, size = hypot(v[0], v[1]);
      PetscReal f[2], slope[RUBS][RUBS], error[2];
      FrictionDual dual = {0};
      Force(&law, v, f);
      FrictionFollow(2, &law, v, PETSC_TRUE, &dual);
      FrictionSlope(2, &law, v, &dual, slope);
      for (int k = 0; k < 2; k++) {
        PetscReal e = 1e-3 * size / (1 << k), moved[2] = {v[0] + e * w[0], v[1] + e * w[1]}, fm[2];
        Force(&law, moved, fm);
        error[k] = hypot(fm[0] - f[0] - e * (slope[0][0] * w[0] + slope[0][1] * w[1]),
                         fm[1] - f[1] - e * (slope[1][0] * w[0] + slope[1][1] * w[1]));
      }
      EXPECT(error[0] / error[1] > 3.9 && error[0] / error[1] < 4.1, "law %d, point %d: ratio %g",
             l, p, error[0] / error[1]);
    }
}

/* A reset near the dual of before makes Newton's own slope; elsewhere the old dual is kept. */
static void TestDualAfterReset(void **state) {
  Friction primal = Create("-friction_newton primal -friction_mu 0.8"), dual_law = primal;
  const PetscReal v[2] = {0.02, -0.5}, before[2] = {0.05, -0.48}, away[2] = {0.5, 0.1};
  PetscReal a[RUBS][RUBS], b[RUBS][RUBS];
  FrictionDual dual = {0};
  dual_law.newton = NEWTON_PRIMAL_DUAL;
  Settle(&dual_law, before, &dual);
  FrictionFollow(2, &dual_law, v, PETSC_TRUE, &dual);
  FrictionSlope(2, &primal, v, &dual, a);
  FrictionSlope(2, &dual_law, v, &dual, b);
  for (int i = 0; i < 4; i++)
    EXPECT(PetscAbsReal(a[i / 2][i % 2] - b[i / 2][i % 2]) < 1e-13, "entry %d: %g, %g", i,
           a[i / 2][i % 2], b[i / 2][i % 2]);
  FrictionFollow(2, &dual_law, away, PETSC_TRUE, &dual);
  EXPECT(hypot(dual.w[0] - 0.02 / 0.5014, dual.w[1] + 0.5 / 0.5014) < 2e-3,
         "the dual (%g, %g) was thrown away", dual.w[0], dual.w[1]);
  EXPECT(dual.v[0] == away[0] && dual.v[1] == away[1], "the point is not the new one");
}

/* A step that ends where it began makes w = v/r at once; a short step keeps it to second order. */
static void TestDualFollows(void **state) {
  Friction law = Create("-friction_beta 0.05");
  const PetscReal v[2] = {0.2, -0.1}, w[2] = {0.3, 0.7};
  PetscReal error[2], r = PetscSqrtReal(0.05 + 0.05);
  FrictionDual dual = {0};
  Settle(&law, v, &dual);
  dual.w[0] = -0.9;
  dual.w[1] = 0.1;
  FrictionFollow(2, &law, v, PETSC_FALSE, &dual);
  EXPECT(hypot(dual.w[0] - v[0] / r, dual.w[1] - v[1] / r) < 1e-15, "dual (%g, %g)", dual.w[0],
         dual.w[1]);
  for (int k = 0; k < 2; k++) {
    PetscReal e = 1e-4 / (1 << k), moved[2] = {v[0] + e * w[0], v[1] + e * w[1]};
    Settle(&law, v, &dual);
    FrictionFollow(2, &law, moved, PETSC_FALSE, &dual);
    EXPECT(dual.v[0] == moved[0] && dual.v[1] == moved[1], "the point is not the new one");
    r = PetscSqrtReal(moved[0] * moved[0] + moved[1] * moved[1] + 0.05);
    error[k] = hypot(dual.w[0] - moved[0] / r, dual.w[1] - moved[1] / r);
  }
  EXPECT(error[0] / error[1] > 3.8 && error[0] / error[1] < 4.2, "ratio %g", error[0] / error[1]);
}

static void TestDualStaysInDisc(void **state) {
  Friction law = Create("-friction_beta 1e-9");
  const PetscReal start[2] = {1e-5, 1};
  PetscReal most = 0;
  FrictionDual dual = {0};
  Settle(&law, start, &dual);
  for (int k = 0; k < 1000; k++) {
    PetscReal size = PetscPowReal(10, 4 * Scatter(2, k)), v[2];
    v[0] = size * Scatter(0, k);
    v[1] = size * Scatter(1, k);
    FrictionFollow(2, &law, v, PETSC_FALSE, &dual);
    most = PetscMax(most, hypot(dual.w[0], dual.w[1]));
  }
  EXPECT(most <= 1 + 1e-14 && most > 0.999, "largest dual %.17g", most);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestLaw), cmocka_unit_test(TestPrimalSlope),
    cmocka_unit_test(TestDualAfterReset), cmocka_unit_test(TestDualFollows),
    cmocka_unit_test(TestDualStaysInDisc)};
MAIN(tests)
