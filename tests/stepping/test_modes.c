/* Modes of a rod are counted as if its walls had no friction: they have it again behind that.
   test: walls have their friction again where a count of modes fails */
#include "harness.h"
#include "stepping/leg.h"

static PetscBool slippery; /* were they, when they were to be counted? */

/* An elimination that fails, as one without memory would. */
static PetscErrorCode Fails(Rod rod, const RodState *at, Elimination elimination) {
  (void)at;
  (void)elimination;
  slippery = rod->scene->contact.slippery;
  return PETSC_ERR_MEM;
}

static void TestFails(void **state) {
  PetscBool crosses = PETSC_TRUE;
  PetscErrorCode error;
  RodModel model = rod_frame;
  char wall[64];
  Scene scene;
  Leg leg;

  (void)state;
  WriteWalls(wall, "plane 0 0.5 0 -1 friction 0.5\n");
  SetOptions("-growth_type feed -growth_initial_length 1 -rod_cells 8 -ts_max_time 1 "
             "-wall_file %s",
             wall);
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &model, 1e-4, &leg));
  EXPECT(leg.newton.elimination, "nothing is eliminated");
  model.eliminate = Fails;
  CHECK(PetscPushErrorHandler(PetscIgnoreErrorHandler, NULL));
  error = LegCrossesSlippery(&leg, leg.U, &crosses);
  CHECK(PetscPopErrorHandler());
  EXPECT(error == PETSC_ERR_MEM && slippery, "error %d, slippery %d", (int)error, slippery);
  EXPECT(!scene->contact.slippery, "walls stay slippery");
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
  RemoveFile(wall);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestFails)};
MAIN(tests)
