/* Friction along the rod: laws beside the built-in one.
   test: a law beside friction acts by its place and speed, and its slope is that of differences */
#include "harness.h"
#include "world/load.h"

/* phi = 1 + v^4 */
static int Stiffens(void *ctx, const TendrilPlace *at, double value[]) {
  value[0] = 1 + at->speed2 * at->speed2;
  value[1] = 2 * at->speed2;
  return 0;
}

/* A load with that law in the place of the built-in one. */
static Load Create(const char *options, OwnLaw *own) {
  Load load = {.law = {{NULL}}};

  SetOptions("-friction_mu 0 %s", options);
  CHECK(LoadSetFromOptions(&load));
  load.radius = load.arm = 0.3;
  load.friction.viscous = 0;
  load.law[load.laws++] = (LoadLaw){&friction_own, own};
  return load;
}

static void TestIsLaw(void **state) {
  OwnLaw own = {.value = Stiffens};
  Load load = Create("", &own);
  const Place at = {.axes = {{1}}, .v = {0, 2, 0, 0}};
  FrictionDual dual = {.v = {0}};
  PetscReal f[RUBS];

  LoadForce(2, &load, &at, &dual, f);
  EXPECT(f[0] == 0 && f[1] == 17 * 2, "force %g %g", f[0], f[1]);
  LoadSeen(2, &load, &at, f);
  EXPECT(f[0] == 0 && f[1] == 17 * 2, "force as an observer sees it %g %g", f[0], f[1]);
  EXPECT(LoadAxialDrag(&load, &at, 2) == 17, "drag %g", LoadAxialDrag(&load, &at, 2));
  EXPECT(PetscAbsReal(LoadAxialBetween(&load, 0, 2) - (2 + 64 / 6.)) < 1e-12, "axial load %g",
         LoadAxialBetween(&load, 0, 2));
  EXPECT(!LoadIsLinear(&load) && LoadHas(&load, &friction_own) && !LoadAlong(&load), "what it is");
  CHECK(LoadDestroy(&load));
}

/* |F(W + e w) - F(W) - e F'(W) w| falls fourfold when e is halved. */
static void TestSlope(void **state) {
  static const char *const more[] = {"", "-friction_across 0.4 -friction_layers 0:1,1:3"};
  const PetscReal w[RUBS] = {0.7, 0.4, -0.3, 0.2};
  OwnLaw own = {.value = Stiffens};

  for (int k = 0; k < 4; k++) {
    const int dims = 2 + k / 2, rubs = LoadRubs(dims);
    Load load = Create(more[k % 2], &own);
    Place at = {.x = {0.9}, .axes = {{0.6, 0.8}}, .v = {1, 2, 0, 0}}, moved;
    FrictionDual dual = {.v = {0}};
    PetscReal f[RUBS], to[RUBS], error[] = {0, 0};
    LoadSlope slope;

    load.lab[0][0] = load.lab[1][1] = load.lab[2][2] = 1;
    if (dims == 3) at.v[2] = -0.5, at.v[SPIN] = 0.8;
    LoadForce(dims, &load, &at, &dual, f);
    LoadLinearise(dims, &load, &at, PETSC_TRUE, &dual, &slope);
    for (int half = 0; half < 2; half++) {
      const PetscReal e = 1e-3 / (1 << half);
      moved = at;
      for (int c = 0; c < rubs; c++) moved.v[c] += e * w[c];
      LoadForce(dims, &load, &moved, &dual, to);
      for (int d = 0; d < rubs; d++) {
        PetscReal off = to[d] - f[d];
        for (int c = 0; c < rubs; c++) off -= e * slope.W[d][c] * w[c];
        error[half] += PetscAbsReal(off);
      }
    }
    EXPECT(PetscAbsReal(error[0] / error[1] - 4) < 0.05, "%d dimensions, %s: ratio %g", dims,
           more[k % 2], error[0] / error[1]);
    CHECK(LoadDestroy(&load));
  }
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestIsLaw), cmocka_unit_test(TestSlope)};
MAIN(tests)
