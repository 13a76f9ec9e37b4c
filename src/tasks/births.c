/* Rods that come out in a run of several: what is seen of them before and at their births, and what
   these do to the run. */
#include "system/births.h"
#include "tasks/several_run.h"

/* RunAnyBorn - is any rod to come out in the run? Then all are looked at together. */
PetscBool RunAnyBorn(const Run *self) {
  for (PetscInt k = 0; k < self->n; k++)
    if (self->scene[k]->born > 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* RunCheckSteps - refuses births with steps that do not end at them. */
PetscErrorCode RunCheckSteps(const Run *self) {
  PetscBool vbdf, fixed;
  TSAdapt adapt;

  PetscFunctionBegin;
  if (!RunAnyBorn(self)) PetscFunctionReturn(0);
  PetscCall(TSGetAdapt(self->leg.ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)self->leg.ts, TSVBDF, &vbdf));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &fixed));
  UserCheck(
      vbdf && !fixed, OptionsComm(),
      "-born: ends a step, and with -ts_type or -ts_adapt_type none steps end elsewhere; take "
      "these out");
  PetscFunctionReturn(0);
}

/* RunBirths - rods whose time has come are there from now on. All go on from that one point, in
   steps that the error allows: in shorter ones what places are off by, within the tolerance, would
   be put right at a speed without measure. */
PetscErrorCode RunBirths(Run *self, PetscReal t) {
  PetscFunctionBegin;
  self->bears = PETSC_FALSE;
  for (PetscInt k = 0; k < self->n; k++) {
    if (!self->to_come[k] || SceneToCome(self->scene[k], t)) continue;
    PetscCall(BirthPlace(self->leg.rod, self->joints, k, t, self->U));
    self->bears = PETSC_TRUE;
  }
  if (!self->bears) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < self->n; k++) self->each[k].kept.changed = PETSC_TRUE;
  PetscCall(VBDFBeginAnew(self->leg.ts));
  PetscFunctionReturn(0);
}

/* The rod is not there yet: nothing is observed of it but when. */
static PetscErrorCode Unseen(Grow *grow, PetscReal t) {
  PetscReal *value = (PetscReal *)&grow->seen;

  PetscFunctionBegin;
  for (int i = 0; i < OBSERVED; i++) value[i] = NAN;
  grow->seen.t = t;
  PetscCall(OutputSeries(grow->output, &grow->seen));
  PetscFunctionReturn(0);
}

/* What is observed of it at its birth. It is at rest, for how fast its carrier moves it is not
   known before the step behind; its energy is summed up from there. */
static PetscErrorCode Born(Grow *grow, PetscReal t, Vec U) {
  PetscFunctionBegin;
  PetscCall(ObserverMeasure(grow->observer, grow->now->rod, t, U, NULL, NULL, &grow->seen));
  grow->seen.step = grow->seen.newton_iterations = 0;
  grow->seen.model = (PetscReal)grow->model;
  PetscCall(OutputSeries(grow->output, &grow->seen));
  PetscFunctionReturn(0);
}

/* RunLookAt - looks at one of the rods, in its own state; U NULL: as it begins. */
PetscErrorCode RunLookAt(Run *self, PetscInt k, PetscReal t, Vec U, Vec U_t) {
  Grow *grow = &self->each[k];

  PetscFunctionBegin;
  PetscCall(LegPartFollow(grow->now));
  if (SceneToCome(self->scene[k], t))
    PetscCall(Unseen(grow, t));
  else if (self->to_come[k])
    PetscCall(Born(grow, t, U));
  else
    PetscCall(GrowObserve(grow, t, U, U_t));
  self->to_come[k] = SceneToCome(self->scene[k], t);
  PetscFunctionReturn(0);
}

/* RunShapeOf - hands the shape of one to its output: none, if it is still to come. U: its own;
   NULL: as it begins. */
PetscErrorCode RunShapeOf(Run *self, PetscInt k, PetscReal t, Vec U) {
  PetscFunctionBegin;
  PetscCall(GrowStoreShape(&self->each[k], t, U));
  if (SceneToCome(self->scene[k], t)) PetscCall(OutputBlank(self->output[k]));
  PetscFunctionReturn(0);
}
