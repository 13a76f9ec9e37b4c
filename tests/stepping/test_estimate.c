/* How often, and on which mesh, the errors of a run are followed.
   test: errors are followed as often as the rod changes */
#include "harness.h"
#include "stepping/estimating.h"

static RodModel model; /* the frame, whose defects are counted */
static Estimate estimate;
static PetscInt steps, times, defects;
static PetscBool touches, smooth; /* the rod; all steps are taken for smooth ones */
static PetscReal energy;          /* the largest error of it that was told */

static PetscErrorCode CountedDefect(Rod rod, const RodState *at, PetscReal (*defect)[MAX_FIELDS]) {
  PetscFunctionBegin;
  defects++;
  PetscCall(rod_frame.defect(rod, at, defect));
  PetscFunctionReturn(0);
}

static PetscErrorCode Follow(TS ts) {
  const PetscReal before = estimate->before;

  PetscFunctionBegin;
  if (smooth) PetscCall(TSGetStepRejections(ts, &estimate->rejected));
  PetscCall(EstimateStep(estimate, PETSC_FALSE, touches));
  steps++;
  times += estimate->before > before;
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    energy = PetscMax(energy, estimate->now[part][ESTIMATE_ENERGY]);
  PetscFunctionReturn(0);
}

/* Follows the errors of a run in so many steps of one length. */
static void Run(const char *options) {
  Scene scene;
  Leg leg;

  steps = times = defects = 0;
  energy = 0;
  model = rod_frame;
  model.defect = CountedDefect;
  SetOptions("-growth_type feed -growth_initial_length 1 -friction_mu 0.5 -rod_cells 16 "
             "-ts_max_time 1 -ts_dt 0.02 -ts_adapt_type none %s",
             options);
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &model, 1e-6, &leg));
  CHECK(EstimateCreate(&leg, &estimate));
  CHECK(RodBegin(leg.rod, leg.U));
  CHECK(TSSetPostStep(leg.ts, Follow));
  CHECK(TSSolve(leg.ts, leg.U));
  CHECK(EstimateDestroy(&estimate));
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
}

/* Those of a rod that is all but straight change with all of it, and are taken on every few steps;
   of one that is bent each step turns them. Defects are measured less often still. */
static void TestOften(void **state) {
  (void)state;
  Run("-shape_amplitude 0.1");
  EXPECT(times < steps / 2 && times > steps / 9, "all but straight: %d of %d steps", (int)times,
         (int)steps);
  EXPECT(defects < 3 * times / 4 && defects > times / 4, "%d measurements in %d times",
         (int)defects, (int)times);
  Run("-rod_curvature 3");
  EXPECT(times > 3 * steps / 4, "bent: %d of %d steps", (int)times, (int)steps);
}

/* A step that was rejected has something in it that is not smooth, as where dry friction sets in
   on a rod that nothing has bent yet: it is looked at by itself, not spread over four steps, and
   differences tell too little of its error, by no more than a factor. */
static void TestKinks(void **state) {
  const char *const sets_in = "-rod_curvature 0.2 -friction_mu 1 -friction_beta 0 -rod_cells 30 "
                              "-ts_adapt_type basic -ts_dt 1e-4";
  PetscReal as_smooth;

  (void)state;
  smooth = PETSC_TRUE;
  Run(sets_in);
  as_smooth = energy;
  smooth = PETSC_FALSE;
  Run(sets_in);
  print_message("told %.2e, as of smooth steps %.2e\n", (double)energy, (double)as_smooth);
  EXPECT(energy > 8 * as_smooth && energy < 60 * as_smooth, "told %g, as of smooth steps %g",
         (double)energy, (double)as_smooth);
}

/* The coarse mesh of a rod of so many cells and this length: cells, 0: there is none. */
static PetscInt Coarse(PetscInt cells, PetscReal length) {
  PetscInt n;
  Scene scene;
  Leg leg;

  SetOptions("-growth_type none -growth_initial_length %g -rod_cells %d -ts_max_time 1 "
             "-friction_mu 0.5",
             (double)length, (int)cells);
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &rod_frame, 1e-6, &leg));
  CHECK(EstimateCreate(&leg, &estimate));
  n = estimate ? estimate->nodes - 1 : 0;
  CHECK(EstimateDestroy(&estimate));
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
  return n;
}

/* Errors are smooth along the rod, and need few cells however fine the run's own are; unless the
   rod is so long that they would be long beside what bends it. */
static void TestMesh(void **state) {
  PetscInt n = Coarse(4, 1);

  (void)state;
  EXPECT(n == 0, "of 4 cells: %d", (int)n);
  n = Coarse(16, 1);
  EXPECT(n == 8, "of 16: %d", (int)n);
  n = Coarse(1000, 1);
  EXPECT(n >= 40 && n <= 100, "of 1000: %d", (int)n);
}

/* A rod that grows has a unit of length of its own; a coarse cell is no longer. */
static void TestLong(void **state) {
  PetscReal length = 300;
  PetscInt n;
  Scene scene;
  Leg leg;

  (void)state;
  SetOptions("-growth_type feed -growth_initial_length 300 -rod_cells 2000 -ts_max_time 1e-3");
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &rod_frame, 1e-6, &leg));
  CHECK(EstimateCreate(&leg, &estimate));
  n = estimate->nodes - 1;
  length /= scene->units.length * (PetscReal)n;
  EXPECT(length > 0.1 && length <= 1, "%d coarse cells of %g units", (int)n, (double)length);
  CHECK(EstimateDestroy(&estimate));
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
}

/* What the start does is early for a small part of the run. */
static void TestEarly(void **state) {
  Scene scene;
  Leg leg;

  (void)state;
  SetOptions("-growth_type feed -growth_initial_length 1 -rod_cells 16 -ts_max_time 10");
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &rod_frame, 1e-6, &leg));
  CHECK(EstimateCreate(&leg, &estimate));
  EXPECT(EstimateIsEarly(estimate, 0.01, ESTIMATE_TIP), "a thousandth of it");
  EXPECT(!EstimateIsEarly(estimate, 1, ESTIMATE_TIP), "a tenth");
  CHECK(EstimateDestroy(&estimate));
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestOften), cmocka_unit_test(TestKinks),
                                          cmocka_unit_test(TestMesh), cmocka_unit_test(TestLong),
                                          cmocka_unit_test(TestEarly)};
MAIN(tests)
