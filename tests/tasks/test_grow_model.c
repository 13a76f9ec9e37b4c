/* Which model goes on, how energies weigh, and what tolerances are.
   test: models take turns by what the linear one leaves out */
#include "harness.h"
#include "tasks/growing.h"

static const PetscReal rtol = 1e-6;

/* The model that -rod_model auto goes on with where the linear one leaves out so much. */
static PetscInt Better(PetscInt now, PetscReal neglects) {
  struct _Scene scene = {.end_time = 1};
  Grow self = {.scene = &scene, .model = AUTO, .rtol = rtol, .neglects = neglects};

  self.can[LINEAR] = PETSC_TRUE;
  self.now = &self.leg[now];
  return GrowBetterModel(&self);
}

/* It is left where that is no more below the tolerance, and not taken up again until it is well
   below: between the two neither model gives way to the other, so that none flickers. */
static void TestTurns(void **state) {
  (void)state;
  EXPECT(Better(LINEAR, 10 * rtol) == FRAME, "leaves out more than the tolerance");
  EXPECT(Better(FRAME, 1e-3 * rtol) == LINEAR, "next to nothing");
  for (PetscReal part = 0.06; part < 0.2; part *= 1.5)
    EXPECT(Better(LINEAR, part * rtol) == LINEAR && Better(FRAME, part * rtol) == FRAME,
           "%g of the tolerance", (double)part);
}

/* How many e-foldings are counted of an energy that halves. */
static PetscReal Folds(PetscReal energy) {
  Grow self = {.seen = {.norm_x2 = 1e-3, .energy = energy / 2}};
  const Observation last = {.norm_x2 = 1e-3, .energy = energy};

  self.now = &self.leg[LINEAR];
  GrowWeigh(&self, &last, 0);
  return self.kept.energy_folds;
}

/* An energy tells how the rod has decayed as long as it has all its digits. */
static void TestEnergies(void **state) {
  (void)state;
  EXPECT(PetscAbsReal(Folds(1) - PetscLogReal(2)) < 1e-12, "of 1");
  EXPECT(PetscAbsReal(Folds(1e-299) - PetscLogReal(2)) < 1e-12, "of 1e-299");
  EXPECT(Folds(1e-310) == 0, "of 1e-310, which has lost digits");
}

/* The tolerance of a rod that touches may be eased, tenfold about, unless it is asked for. */
static void TestTolerance(void **state) {
  PetscReal least, most;

  (void)state;
  SetOptions("-growth_type feed -growth_initial_length 1");
  CHECK(GrowTolerance(PETSC_TRUE, &least, &most));
  EXPECT(most > 5 * least && most < 50 * least, "from %g to %g", (double)least, (double)most);
  SetOptions("-growth_type feed -growth_initial_length 1 -ts_rtol 1e-5");
  CHECK(GrowTolerance(PETSC_TRUE, &least, &most));
  EXPECT(most == least, "asked for: from %g to %g", (double)least, (double)most);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestTurns), cmocka_unit_test(TestEnergies), cmocka_unit_test(TestTolerance)};
MAIN(tests)
