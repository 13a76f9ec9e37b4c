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

/* RunMarkShape - keeps what is needed to go on from the time of a shape that is stored. */
PetscErrorCode RunMarkShape(Run *self, PetscReal t) {
  PetscFunctionBegin;
  if (!self->by_steps || !(self->each[0].seen.step > 0)) PetscFunctionReturn(0);
  PetscCall(PetscRealloc((size_t)(self->marks + 1) * sizeof(*self->mark), &self->mark));
  PetscCall(RunMarkAt(self, PetscMin(t, self->t), &self->mark[self->marks]));
  self->marks++;
  PetscFunctionReturn(0);
}

PetscErrorCode RunMarksEnd(Run *self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->marks; k++) PetscCall(RunMarkEnd(&self->mark[k]));
  PetscCall(PetscFree(self->mark));
  self->marks = 0;
  PetscFunctionReturn(0);
}

/* Behind a step; the present shapes are there, too. */
static PetscErrorCode SaveNow(Run *self, const char *path) {
  const PetscReal stored = self->stored_shape;
  PetscErrorCode error;

  PetscFunctionBegin;
  if (stored != self->t) PetscCall(RunStoreShape(self, self->t, self->leg.U));
  error = SeveralSave(
      &self->file, path, self->t, NULL,
      (PetscBool)(self->over && (self->reason == TS_CONVERGED_TIME || self->stopped_by >= 0)));
  if (stored != self->t) SeveralDropShape(&self->file);
  self->stored_shape = stored;
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* As of a mark. A row of the series at its time goes with it, unless there is one. */
static PetscErrorCode SaveMark(Run *self, const char *path, RunMark *mark) {
  const PetscReal t = mark->state.t;
  const Observation **last, *row;
  PetscErrorCode error;
  PetscBool has = PETSC_FALSE;
  PetscInt n;

  PetscFunctionBegin;
  OutputRows(self->output[0], &n, &row);
  for (PetscInt i = 0; i < n && !has; i++)
    has = (PetscBool)(PetscAbsReal(row[i].t - t) <= grow_rule.same_time * t);
  PetscCall(PetscMalloc1(self->n, &last));
  for (PetscInt k = 0; k < self->n; k++) last[k] = &mark->own[k].seen;
  self->saved = mark;
  error = SeveralSave(&self->file, path, t, has ? NULL : last, PETSC_FALSE);
  self->saved = NULL;
  PetscCall(PetscFree(last));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* Within the step that waits. */
static PetscErrorCode SaveWithin(Run *self, const char *path, PetscReal t) {
  const PetscReal stored = self->stored_shape;
  PetscErrorCode error;
  RunMark mark;

  PetscFunctionBegin;
  PetscCall(RunMarkAt(self, t, &mark));
  PetscCall(RunStoreShape(self, t, mark.U));
  error = SaveMark(self, path, &mark);
  SeveralDropShape(&self->file);
  self->stored_shape = stored;
  PetscCall(RunMarkEnd(&mark));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/*
  RunSave - writes a result file of a run by steps, as of a time at which shapes were stored, or as
  of now: as GrowSave() has it.

  now  the present time
*/
PetscErrorCode RunSave(Run *self, const char *path, PetscReal t, PetscReal now) {
  char text[2][64];

  PetscFunctionBegin;
  if (PetscAbsReal(t - now) <= grow_rule.same_time * now) {
    PetscCall(self->waits && now > self->t ? SaveWithin(self, path, now) : SaveNow(self, path));
    PetscFunctionReturn(0);
  }
  for (PetscInt k = 0; k < self->marks; k++)
    if (PetscAbsReal(t - self->mark[k].state.t) <= grow_rule.same_time * t) {
      PetscCall(SaveMark(self, path, &self->mark[k]));
      PetscFunctionReturn(0);
    }
  UserCheck(PETSC_FALSE, OptionsComm(),
            "save: no shape of this run was stored at t = %s; times are multiples of %s "
            "(-output_interval, -output_shapes)",
            OptionBoth(t, UNIT_TIME, text[0]), OptionBoth(self->interval, UNIT_TIME, text[1]));
  PetscFunctionReturn(0);
}
