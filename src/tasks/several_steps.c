/* -task grow of several rods: a run by steps, as grow.c has that of one. */
#include "tasks/grow_rules.h"
#include "tasks/several_run.h"

/* RunStep - as GrowStep(): takes one step or, if that has led beyond a time, lets it wait. */
PetscErrorCode RunStep(Run *self, PetscReal until) {
  TS ts = self->leg.ts;
  PetscReal t;

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &t));
  self->until = until;
  if (self->over || (self->waits && t > until)) PetscFunctionReturn(0);
  if (self->waits) {
    PetscCall(TSSetConvergedReason(ts, self->reason));
    PetscCall(RunAfterStep(ts));
  } else if (self->enters)
    PetscCall(TSSolve(ts, self->leg.U));
  else
    PetscCall(GrowStepOnce(ts));
  if (!self->waits) PetscCall(RunAfterSolve(self));
  PetscFunctionReturn(0);
}

/* RunWithin - the state of all and its rate at a time within the latest step, or within the
   one that waits.

   V  made here: the caller destroys them */
PetscErrorCode RunWithin(Run *self, PetscReal t, Vec V[2]) {
  PetscReal end = self->t, h = self->each[0].seen.step;

  PetscFunctionBegin;
  if (self->waits) {
    PetscCall(TSGetTime(self->leg.ts, &end));
    h = end - self->t;
  }
  for (int k = 0; k < 2; k++) PetscCall(VecDuplicate(self->leg.U, &V[k]));
  PetscCall(LegInterpolate(&self->leg, t, end, h, V[0], V[1]));
  PetscFunctionReturn(0);
}

/* The present shapes are there, too. */
static PetscErrorCode SaveNow(Run *self, const char *path) {
  const PetscReal stored = self->stored_shape;
  PetscErrorCode error;

  PetscFunctionBegin;
  if (stored != self->t) PetscCall(RunStoreShape(self, self->t, self->leg.U));
  error = SeveralSave(
      &self->file, path, self->t,
      (PetscBool)(self->over && (self->reason == TS_CONVERGED_TIME || self->stopped_by >= 0)));
  if (stored != self->t) SeveralDropShape(&self->file);
  self->stored_shape = stored;
  PetscCall(error);
  PetscFunctionReturn(0);
}

/*
  RunSave - writes a result file of a run by steps as of now, behind a step.

  now  the present time
*/
PetscErrorCode RunSave(Run *self, const char *path, PetscReal t, PetscReal now) {
  PetscFunctionBegin;
  UserCheck(PetscAbsReal(t - now) <= grow_rule.same_time * now && !(self->waits && now > self->t),
            OptionsComm(),
            "save: of several rods the present state is saved, behind a step in this version");
  PetscCall(SaveNow(self, path));
  PetscFunctionReturn(0);
}
