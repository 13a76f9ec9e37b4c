/* When a rod in dry friction is followed in a fast time.
   test: a rod that is far faster than it grows snaps until it is no faster */
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

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestSnaps),
                                          cmocka_unit_test(TestViscous)};
MAIN(tests)
