/* What steppers ask of a rod is answered for several at once; one does not notice.
   test: several rods answer together, and one as its scene says | ranks 1 2 */
#include "harness.h"
#include "rod/ask.h"

static void Create(const char *options, Scene *scene, Rod *rod) {
  SetOptions("-rod_cells 12 -ts_max_time 2 %s", options);
  CHECK(SceneCreate(scene));
  CHECK(RodCreate(*scene, &rod_frame, rod));
}

/* The first is dry, short, free at its tip, and touches nothing. */
static void Answers(Rod rod, PetscBool dry, PetscBool touches, PetscBool tip_held,
                    PetscReal length) {
  const RodEnds ends = RodEndsOf(rod);
  PetscReal long_;

  CHECK(RodLength(rod, 0, &long_));
  EXPECT(RodIsDry(rod) == dry, "dry: %d", RodIsDry(rod));
  EXPECT(RodTouches(rod) == touches, "touches: %d", RodTouches(rod));
  EXPECT(RodMeetsStrands(rod) == touches, "itself: %d", RodMeetsStrands(rod));
  EXPECT(!RodMeetsWalls(rod), "walls");
  EXPECT(ends.tip_held == tip_held && ends.tip_rests == tip_held, "tip: %d", ends.tip_held);
  EXPECT(ends.clamped && !ends.begins_free, "beginning");
  EXPECT(long_ == length, "length %g", (double)long_);
}

static void TestTogether(void **state) {
  Scene scene[2];
  Rod rod[2];
  struct _Rod both;

  (void)state;
  Create("-growth_type feed -growth_initial_length 1 -friction_mu 1", &scene[0], &rod[0]);
  Create("-growth_type uniform -growth_initial_length 2 -friction_mu 0 -tip_type pinned "
         "-contact_self true -contact_diameter 0.01",
         &scene[1], &rod[1]);
  both = *rod[0];
  both.rods = 2;
  both.each = rod;
  Answers(rod[0], PETSC_TRUE, PETSC_FALSE, PETSC_FALSE, 1);
  Answers(rod[1], PETSC_FALSE, PETSC_TRUE, PETSC_TRUE, 2);
  Answers(&both, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, 2);
  RodAtSpeed(&both, 7);
  for (int k = 0; k < 2; k++) EXPECT(RodFalls(rod[k]) == 7, "rod %d", k);
  for (int k = 0; k < 2; k++) CHECK(RodDestroy(&rod[k]));
  for (int k = 0; k < 2; k++) CHECK(SceneDestroy(&scene[k]));
}

/* What is the most, the least and the next of several; what is done to one is done to all. */
static void TestAll(void **state) {
  FrictionNewton slope[2] = {NEWTON_PRIMAL_DUAL, NEWTON_PRIMAL_DUAL};
  char path[64], more[256];
  Scene scene[2];
  Rod rod[2];
  struct _Rod both;

  (void)state;
  WriteWalls(path, "t,speed\n0,1\n0.5,0\n1,1\n");
  Create("-growth_type feed -growth_initial_length 1 -contact_self true -contact_diameter 0.02 "
         "-contact_stiffness 10",
         &scene[0], &rod[0]);
  (void)snprintf(more, sizeof(more),
                 "-growth_type feed -growth_initial_length 3 -growth_path %s -contact_self true "
                 "-contact_diameter 0.01",
                 path);
  Create(more, &scene[1], &rod[1]);
  both = *rod[0];
  both.rods = 2;
  both.each = rod;
  EXPECT(RodLongest(&both) == scene[1]->reach && scene[0]->reach < scene[1]->reach, "reach");
  CHECK(RodContactAt(&both, 0.25));
  EXPECT(RodLayer(&both) == scene[1]->contact.tip && RodLayer(rod[0]) > RodLayer(&both), "layer");
  EXPECT(RodNextTurn(rod[0], 0) == PETSC_MAX_REAL && RodNextTurn(&both, 0) == 0.5, "next turn");
  scene[0]->load.friction.newton = scene[1]->load.friction.newton = NEWTON_PRIMAL;
  RodSwapSlopes(&both, slope);
  EXPECT(slope[0] == NEWTON_PRIMAL, "not the slope that it had");
  RodMakeSlippery(&both, PETSC_TRUE);
  RodStaysFirm(&both); /* the first has a stiffness that is given */
  EXPECT(!scene[0]->contact.firm && scene[1]->contact.firm, "firm");
  for (int k = 0; k < 2; k++) {
    EXPECT(scene[k]->contact.time == 0.25, "rod %d: contact at %g", k, scene[k]->contact.time);
    EXPECT(scene[k]->load.friction.newton == NEWTON_PRIMAL_DUAL, "slope of rod %d", k);
    EXPECT(scene[k]->contact.slippery, "rod %d: friction", k);
  }
  for (int k = 0; k < 2; k++) CHECK(RodDestroy(&rod[k]));
  for (int k = 0; k < 2; k++) CHECK(SceneDestroy(&scene[k]));
  RemoveFile(path);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestTogether),
                                          cmocka_unit_test(TestAll)};
MAIN(tests)
