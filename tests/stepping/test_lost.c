/* What comes out of the equations is no number, or far too large a one, in a single look at them
   and on one rank alone: all ranks reject the step, also one in a snap, and the run comes to where
   it should.
   test: a step that is no number is rejected by all ranks | ranks 1 2 3 */
#include "harness.h"
#include "stepping/leg.h"
#include "stepping/vbdf.h"

/* A model, and the same but for one look. */
static RodModel sound, faulty;
static PetscInt looks, bad_look;
static PetscReal bad;

static PetscErrorCode FaultyResidual(Rod rod, const RodState *at, Vec F) {
  PetscScalar *f;

  PetscFunctionBegin;
  PetscCall(sound.residual(rod, at, F));
  if (++looks != bad_look) PetscFunctionReturn(0);
  PetscCall(VecGetArray(F, &f));
  if (rod->end == rod->last + 1) f[0] = bad;
  PetscCall(VecRestoreArray(F, &f));
  PetscFunctionReturn(0);
}

/* x2 of the tip at the end of a run, one look of which is bad, if that is not 0. */
static PetscReal TipBehind(const char *options, PetscInt look, PetscReal value) {
  TSConvergedReason reason;
  PetscReal tip = -PETSC_MAX_REAL;
  Scene scene;
  Node *nodes;
  Leg leg;

  SetOptions("%s", options);
  faulty = sound;
  faulty.residual = FaultyResidual;
  bad_look = 0;
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &faulty, 1e-5, &leg));
  CHECK(RodBegin(leg.rod, leg.U));
  looks = 0;
  bad_look = look;
  bad = value;
  CHECK(TSSolve(leg.ts, leg.U));
  CHECK(TSGetConvergedReason(leg.ts, &reason));
  EXPECT(reason > 0, "look %d is %g: %s", (int)look, value, TSConvergedReasons[reason]);
  CHECK(PetscMalloc1(leg.rod->end - leg.rod->first, &nodes));
  CHECK(leg.rod->model->get(leg.rod, scene->end_time, leg.U, NULL, nodes));
  if (leg.rod->end == leg.rod->last + 1) tip = nodes[leg.rod->last - leg.rod->first].x[1];
  CHECK(PetscFree(nodes));
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
  return AllMax(tip);
}

static void Lose(const RodModel *model, const char *options) {
  const PetscReal values[] = {NAN, INFINITY, 1e200};
  const PetscInt apart = 17;
  PetscReal tip, other;
  PetscInt all;

  sound = *model;
  tip = TipBehind(options, 0, 0);
  all = looks;
  for (int k = 0; k < 3; k++)
    for (PetscInt look = 1 + k; look <= all; look += apart) {
      other = TipBehind(options, look, values[k]);
      EXPECT(PetscAbsReal(other - tip) < 1e-4 * PetscAbsReal(tip),
             "look %d of %d is %g: the tip is at %g, not %g", (int)look, (int)all, values[k], other,
             tip);
    }
}

static void TestStep(void **state) {
  Lose(&rod_frame, "-growth_initial_length 2 -shape_amplitude 0.1 -rod_cells 20 -ts_max_time 0.3");
}

/* One Newton step solves it, and looks no more at what it has found. */
static void TestLinear(void **state) {
  Lose(&rod_linear, "-growth_initial_length 2 -shape_amplitude 0.1 -rod_cells 20 -ts_max_time 0.3");
}

static void TestSnap(void **state) {
  Lose(&rod_frame, "-growth_type uniform -rod_curvature 0.2 -growth_initial_length 1.1 "
                   "-tip_force 0.3 -rod_cells 20 -ts_max_time 0.01");
}

/* A place that is no number, on one rank, is seen by all. */
static void TestSizes(void **state) {
  const RodModel *models[] = {&rod_frame, &rod_space};
  const Vector2 axis = {0.8, 0.6};
  PetscReal size[MAX_FIELDS];
  PetscScalar *u;
  Scene scene;
  Rod rod;
  Vec U;

  for (int k = 0; k < 2; k++) {
    SetOptions("-rod_cells 12");
    CHECK(SceneCreate(&scene));
    CHECK(RodCreate(scene, models[k], &rod));
    CHECK(DMCreateGlobalVector(rod->da, &U));
    for (PetscInt place = 0; place <= rod->last; place += rod->last) {
      CHECK(VecSet(U, 1));
      CHECK(VecGetArray(U, &u));
      if (rod->first <= place && place < rod->end)
        u[(place - rod->first) * rod->model->fields + 1] = NAN;
      CHECK(VecRestoreArray(U, &u));
      CHECK(RodFieldSizes(rod, U, size));
      EXPECT(size[0] == 1 && PetscIsInfOrNanReal(size[1]), "sizes %g, %g", size[0], size[1]);
      CHECK(RodSizesAlong(rod, U, axis, size));
      EXPECT(size[0] == 1 && PetscIsInfOrNanReal(size[1]), "sizes %g, %g", size[0], size[1]);
    }
    CHECK(VecDestroy(&U));
    CHECK(RodDestroy(&rod));
    CHECK(SceneDestroy(&scene));
  }
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestStep), cmocka_unit_test(TestLinear),
                                          cmocka_unit_test(TestSnap), cmocka_unit_test(TestSizes)};
MAIN(tests)
