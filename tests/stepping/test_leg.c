/* The first step of a run, and when a rod in dry friction is followed in a fast time.
   test: steps begin short and a rod that is far faster than it grows snaps */
#include "harness.h"
#include "stepping/leg.h"

/* The rod moves so many times as fast as it grows: does it snap, does that begin now? */
static PetscBool Snaps(Leg *leg, PetscReal times, PetscBool *begins) {
  PetscScalar *v;
  PetscReal speed;
  Vec U_t;

  CHECK(VecDuplicate(leg->U, &U_t));
  CHECK(VecGetArray(U_t, &v));
  v[leg->rod->model->fields * leg->rod->last + 1] = times * leg->rod->scene->units.speed;
  CHECK(VecRestoreArray(U_t, &v));
  leg->newton.latest.U_t = U_t;
  CHECK(LegSpeed(leg, &speed, begins));
  leg->newton.latest.U_t = NULL;
  CHECK(VecDestroy(&U_t));
  EXPECT(PetscAbsReal(speed - times) < 1e-12 * times, "%g times as fast: %g", times, speed);
  return (PetscBool)(leg->rod->scene->falls > 0);
}

static void Create(const char *friction, Scene *scene, Leg *leg) {
  SetOptions("-growth_type feed -growth_initial_length 1 -rod_cells 8 -ts_max_time 1 %s", friction);
  CHECK(SceneCreate(scene));
  CHECK(LegCreate(*scene, &rod_frame, 1e-6, leg));
}

static void Destroy(Scene *scene, Leg *leg) {
  CHECK(LegDestroy(leg));
  CHECK(SceneDestroy(scene));
}

/* What moves ten times as fast as it grows bends, and does not snap; what moves ten thousand times
   as fast does, until it is as slow as it grows; and is then as it was. */
static void TestSnaps(void **state) {
  PetscBool begins;
  Scene scene;
  Leg leg;

  (void)state;
  Create("", &scene, &leg);
  EXPECT(!Snaps(&leg, 100, &begins) && !begins, "100 times");
  EXPECT(Snaps(&leg, 1e4, &begins) && begins, "ten thousand times");
  EXPECT(Snaps(&leg, 10, &begins) && !begins, "goes on at 10 times");
  EXPECT(!Snaps(&leg, 1.01, &begins) && !begins, "ends where it hardly moves");
  EXPECT(!Snaps(&leg, 10, &begins), "does not begin at 10 times");
  Destroy(&scene, &leg);
}

/* Viscous friction says itself how fast it goes. */
static void TestViscous(void **state) {
  PetscBool begins;
  Scene scene;
  Leg leg;

  (void)state;
  Create("-friction_mu 0.5", &scene, &leg);
  EXPECT(!Snaps(&leg, 1e6, &begins) && !begins, "a million times");
  Destroy(&scene, &leg);
}

/* The first step of a rod's run, and what its scene makes units of. */
static PetscReal First(const char *options, SceneUnits *units) {
  PetscReal first;
  Scene scene;
  Leg leg;

  SetOptions("-rod_cells 8 -ts_max_time 1 -growth_type feed %s", options);
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &rod_frame, 1e-6, &leg));
  CHECK(TSGetTimeStep(leg.ts, &first));
  *units = scene->units;
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
  return first;
}

/* Dry friction does little in the time in which the rod grows by a small part of what it bends
   over; a viscous rod that begins out of balance gives way in a small part of its own time, which
   is to be seen; one that is straight does nothing before that has passed, nearly. And a step that
   turns out to be too long can be shorter still, a thousandfold and more. */
static void TestFirst(void **state) {
  const PetscReal round_off = PETSC_MACHINE_EPSILON;
  SceneUnits units;
  PetscReal first = First("-growth_initial_length 1", &units);

  (void)state;
  EXPECT(first > 1e-5 * units.time && first < 1e-3 * units.time, "dry: %g of %g", first,
         units.time);
  first = First("-growth_initial_length 1 -friction_mu 0", &units);
  EXPECT(first > 1e-7 * units.own && first < 1e-5 * units.own, "bent: %g of %g", first, units.own);
  first = First("-growth_initial_length 0.1 -friction_mu 0 -shape_type straight", &units);
  EXPECT(first > 0.02 * units.own && first < 0.5 * units.own, "straight: %g of %g", first,
         units.own);
  first = First("-growth_initial_length 1e-3 -friction_mu 0 -contact_self true "
                "-contact_diameter 1e-5",
                &units);
  EXPECT(first > 1e2 * round_off * units.brief && first < 1e4 * round_off * units.brief,
         "short: %g of %g", first, units.brief);
}

/* What decays in viscous friction is smooth, and steps of a high order follow it to a tight
   tolerance: far fewer than a low one would take. */
static void TestOrder(void **state) {
  TSConvergedReason reason;
  PetscInt steps;
  Scene scene;
  Leg leg;

  (void)state;
  SetOptions("-growth_type uniform -growth_initial_length 1 -friction_mu 0 -rod_cells 8 "
             "-ts_max_time 0.2");
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &rod_frame, 1e-8, &leg));
  CHECK(RodBegin(leg.rod, leg.U));
  CHECK(TSSetMaxSteps(leg.ts, 600));
  CHECK(TSSolve(leg.ts, leg.U));
  CHECK(TSGetConvergedReason(leg.ts, &reason));
  CHECK(TSGetStepNumber(leg.ts, &steps));
  EXPECT(reason == TS_CONVERGED_TIME && steps < 230, "%d steps, %s", (int)steps,
         TSConvergedReasons[reason]);
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestSnaps),
                                          cmocka_unit_test(TestViscous),
                                          cmocka_unit_test(TestFirst), cmocka_unit_test(TestOrder)};
MAIN(tests)
