/* Where tables bend: a polygon through the bends is as near to what was given as was asked.
   test: a polygon through the bends of a table is as near as asked */
#include "base/bends.h"
#include "harness.h"

typedef struct {
  PetscReal (*value)(PetscReal), (*slope)(PetscReal);
} Given;

static PetscReal Wave(PetscReal x) {
  return 2 + PetscSinReal(3 * x);
}

static PetscReal WaveSlope(PetscReal x) {
  return 3 * PetscCosReal(3 * x);
}

/* A cubic between its rows 0, 1, 2, ... that is steepest in the middle, as a step is. */
static PetscReal Step(PetscReal x) {
  const PetscReal z = x - PetscFloorReal(x);
  return x < 3 ? 1 : x > 4 ? 2 : 1 + z * z * (3 - 2 * z) + (x == 4);
}

static PetscReal StepSlope(PetscReal x) {
  const PetscReal z = x - PetscFloorReal(x);
  return x < 3 || x > 4 ? 0 : 6 * z * (1 - z);
}

static PetscReal Level(PetscReal x) {
  return 5 + 1e-13 * PetscSinReal(1e4 * x);
}

static PetscReal LevelSlope(PetscReal x) {
  return 1e-12 * PetscCosReal(1e4 * x);
}

static PetscErrorCode Curve(const void *table, PetscReal at, PetscReal value[], PetscReal slope[]) {
  const Given *given = (const Given *)table;

  PetscFunctionBegin;
  value[0] = given->value(at);
  slope[0] = given->slope(at);
  PetscFunctionReturn(0);
}

static void Find(const Given *given, PetscInt n, PetscReal tolerance, Bends *bends) {
  PetscReal *row;

  CHECK(PetscMalloc1(n, &row));
  for (PetscInt k = 0; k < n; k++) row[k] = 10. * k / (n - 1);
  CHECK(BendsFind(n, row, 1, Curve, given, tolerance, bends));
  CHECK(BendsSort(bends, -1, 11));
  CHECK(PetscFree(row));
}

/* How far a polygon through the bends is from what is given, values and slopes, at most. */
static PetscReal Off(const Given *given, const Bends *bends, PetscReal tolerance) {
  PetscReal worst = 0;

  for (PetscInt k = 0; k + 1 < bends->n; k++)
    for (int i = 1; i < 20; i++) {
      const PetscReal a = bends->at[k], b = bends->at[k + 1], z = i / 20., x = a + z * (b - a);
      PetscReal (*const f[2])(PetscReal) = {given->value, given->slope};
      for (int d = 0; d < 2; d++) {
        const PetscReal size = PetscMax(PetscAbsReal(f[d](x)), 1e-3);
        worst = PetscMax(worst, PetscAbsReal((1 - z) * f[d](a) + z * f[d](b) - f[d](x)) /
                                    (tolerance * size));
      }
    }
  return worst;
}

static void EnoughAndNotMore(void **state) {
  const Given wave = {Wave, WaveSlope};

  (void)state;
  for (int k = 0; k < 3; k++) {
    const PetscReal tolerance = PetscPowReal(10, -1 - k);
    Bends bends = {0};
    PetscReal off;
    Find(&wave, 10001, tolerance, &bends);
    off = Off(&wave, &bends, tolerance);
    EXPECT(off < 2.5, "tolerance %g: off by %g of it", (double)tolerance, (double)off);
    EXPECT(bends.n > 20 && bends.n < 400 / PetscSqrtReal(tolerance), "tolerance %g: %d bends",
           (double)tolerance, (int)bends.n);
    EXPECT(bends.at[0] == 0 && bends.at[bends.n - 1] == 10, "ends %g %g", (double)bends.at[0],
           (double)bends.at[bends.n - 1]);
    CHECK(BendsDestroy(&bends));
  }
}

static void BetweenRows(void **state) {
  const Given step = {Step, StepSlope};
  Bends bends = {0};

  (void)state;
  Find(&step, 11, 1e-3, &bends);
  EXPECT(PetscAbsReal(BendsNext(&bends, 2) - 3) < 1e-12, "begins at %g",
         (double)BendsNext(&bends, 2));
  EXPECT(PetscAbsReal(BendsNext(&bends, 3.4) - 3.5) < 1e-12, "steepest at %g",
         (double)BendsNext(&bends, 3.4));
  EXPECT(BendsNext(&bends, 4.5) == 10, "then at %g", (double)BendsNext(&bends, 4.5));
  EXPECT(BendsNext(&bends, 10) == PETSC_MAX_REAL, "behind the end");
  CHECK(BendsDestroy(&bends));
}

/* A cubic that turns at 2.3 and 7.1, within one row. */
static PetscReal Turning(PetscReal x) {
  return x * x * x / 3 - (2.3 + 7.1) / 2 * x * x + 2.3 * 7.1 * x;
}

static PetscReal TurningSlope(PetscReal x) {
  return (x - 2.3) * (x - 7.1);
}

static void TurnsAreBends(void **state) {
  const Given turning = {Turning, TurningSlope};
  Bends bends = {0};

  (void)state;
  Find(&turning, 2, 1e9, &bends);
  for (int k = 0; k < 2; k++) {
    const PetscReal at = k ? 7.1 : 2.3, found = BendsNext(&bends, at - 0.1);
    EXPECT(PetscAbsReal(found - at) < 1e-12, "turns at %g, found %g", (double)at, (double)found);
  }
  CHECK(BendsDestroy(&bends));
}

static void RoundOffIsLevel(void **state) {
  const Given level = {Level, LevelSlope};
  Bends bends = {0};

  (void)state;
  Find(&level, 1001, 1e-3, &bends);
  EXPECT(bends.n == 2, "%d bends", (int)bends.n);
  CHECK(BendsSort(&bends, 0, 10));
  EXPECT(bends.n == 0, "%d within", (int)bends.n);
  CHECK(BendsDestroy(&bends));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(EnoughAndNotMore), cmocka_unit_test(BetweenRows),
    cmocka_unit_test(TurnsAreBends), cmocka_unit_test(RoundOffIsLevel)};
MAIN(tests)
