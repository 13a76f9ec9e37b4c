/* -task grow of several rods: what is changed in a run, of one of them or of all, by their
   -change_file or by who takes it step by step. */
#include "scene/change.h"
#include "tasks/grow_rules.h"
#include "tasks/several_run.h"

enum { ALL = -1 };

static PetscBool IsOf(PetscInt which, PetscInt k) {
  return (PetscBool)(which == ALL || which == k);
}

/* What a change does to one rod. */
typedef PetscErrorCode Act(Run *self, PetscInt k, const char *name, const char *value, PetscReal t);

static PetscErrorCode May(Run *self, PetscInt k, const char *name, const char *value, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(LegPartFollow(self->each[k].now));
  PetscCall(GrowMayChange(&self->each[k], name, value, t));
  PetscFunctionReturn(0);
}

static PetscErrorCode Do(Run *self, PetscInt k, const char *name, const char *value, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(SceneChange(self->scene[k], name, value, t));
  PetscCall(EstimateSceneChanged(self->each[k].estimate));
  PetscFunctionReturn(0);
}

/* ... to those that are meant, whose options have the value meanwhile. */
static PetscErrorCode ActOn(Run *self, PetscInt which, Act act, const char *name, const char *value,
                            PetscReal t) {
  char before[PETSC_MAX_PATH_LEN];
  PetscErrorCode error;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    if (!IsOf(which, k)) continue;
    PetscCall(RodsEnter(self->rods, k));
    PetscCall(GrowPutOption(name, value, before));
    error = act(self, k, name, value, t);
    PetscCall(GrowPutBack(name, before, (PetscBool)(error != 0)));
    PetscCall(error);
    PetscCall(RodsLeave(self->rods));
  }
  PetscFunctionReturn(0);
}

/* Steps begin anew, short. */
static PetscErrorCode BeginAnew(Run *self) {
  PetscFunctionBegin;
  PetscCall(TSSetMaxTime(self->leg.ts, self->end));
  PetscCall(LegEndAtTurns(&self->leg));
  for (PetscInt k = 0; k < self->n; k++) {
    self->each[k].end = self->end;
    self->each[k].reach = self->scene[k]->reach;
    self->each[k].kept.changed = PETSC_TRUE;
  }
  PetscCall(VBDFBeginAnew(self->leg.ts));
  PetscCall(TSSetTimeStep(self->leg.ts, grow_rule.again_step * self->end));
  PetscFunctionReturn(0);
}

/* A run by steps goes on from a time within the step that waits, as if that had ended there. */
static PetscErrorCode Settle(Run *self, PetscReal t) {
  Vec V[2];

  PetscFunctionBegin;
  if (!self->waits) PetscFunctionReturn(0);
  PetscCall(RunWithin(self, t, V));
  self->waits = PETSC_FALSE;
  self->U = V[0];
  self->U_t = V[1];
  PetscCall(RunLook(self, t, PETSC_FALSE));
  PetscCall(RunStoreDue(self, t));
  PetscCall(VecCopy(V[0], self->leg.U));
  PetscCall(TSSetTime(self->leg.ts, t));
  for (int i = 0; i < 2; i++) {
    PetscCall(VecDestroy(&self->here[i]));
    self->here[i] = V[i];
  }
  PetscFunctionReturn(0);
}

/*
  RunApply - a new value from the present time on: the run ends its step there, and goes on in short
  ones. What is refused has changed nothing.

  which  the rod; -1: all of them
  name   with its dash
  t      the present time: that of the latest step, or one within the step that waits
*/
PetscErrorCode RunApply(Run *self, PetscInt which, const char *name, const char *value,
                        PetscReal t) {
  const PetscBool ends = (PetscBool)!strcmp(name, "-ts_max_time");

  PetscFunctionBegin;
  if (ends) which = ALL; /* that is the scene's */
  PetscCall(ActOn(self, which, May, name, value, t));
  PetscCall(Settle(self, t));
  PetscCall(ActOn(self, which, Do, name, value, t));
  if (self->estimate) PetscCall(EstimateSceneChanged(self->estimate));
  if (ends) {
    self->end = self->scene[0]->end_time;
    self->over = PETSC_FALSE;
    PetscCall(OptionPut(name, value));
  }
  PetscCall(BeginAnew(self));
  PetscFunctionReturn(0);
}

/* RunRecord - keeps it with what was changed in the run. */
PetscErrorCode RunRecord(Run *self, PetscInt which, const char *name, const char *value,
                         PetscReal t) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++)
    if (IsOf(which, k)) PetscCall(ChangesDo(&self->scene[k]->changes, t, name, value));
  PetscFunctionReturn(0);
}

/* When the next change is due, and of which rod. */
static PetscReal Next(const Run *self, PetscInt *which) {
  PetscReal next = PETSC_MAX_REAL;

  for (PetscInt k = 0; k < self->n; k++) {
    const PetscReal own = ChangesNext(self->scene[k]->changes);
    if (own >= next) continue;
    next = own;
    *which = k;
  }
  return next;
}

/* RunIsChanged - is anything to be changed in the run? */
PetscBool RunIsChanged(const Run *self) {
  for (PetscInt k = 0; k < self->n; k++)
    if (self->scene[k]->changes) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* What is due at t. */
static PetscErrorCode TakeDue(Run *self, PetscReal t) {
  PetscInt which = 0;
  char name[128];

  PetscFunctionBegin;
  PetscCall(Settle(self, t));
  while (Next(self, &which) <= t * (1 + grow_rule.same_time)) {
    Changes list = self->scene[which]->changes;
    const ChangeRow *row = &list->row[list->done];
    (void)snprintf(name, sizeof(name), "-%s", row->what);
    SceneChangeAbout(row);
    PetscCall(RunApply(self, which, name, row->value, t));
    SceneChangeAbout(NULL);
    list->done++;
  }
  PetscFunctionReturn(0);
}

/* RunStepOn - as RunStep(), but that what -change_file says is done when it is due. */
PetscErrorCode RunStepOn(Run *self, PetscReal until) {
  PetscInt which = 0;
  const PetscReal next = Next(self, &which);

  PetscFunctionBegin;
  if (next <= self->t * (1 + grow_rule.same_time)) {
    PetscCall(TakeDue(self, self->t));
    PetscFunctionReturn(0);
  }
  PetscCall(RunStep(self, PetscMin(until, next)));
  if (self->over || until < next) PetscFunctionReturn(0);
  if (self->waits || self->t >= next * (1 - grow_rule.same_time))
    PetscCall(TakeDue(self, self->waits ? next : self->t));
  PetscFunctionReturn(0);
}

/* RunTellNotReached - says it where the run has ended before what a -change_file says was due. */
PetscErrorCode RunTellNotReached(Run *self) {
  char text[64];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n && !self->quiet; k++) {
    const PetscReal next = ChangesNext(self->scene[k]->changes);
    if (next == PETSC_MAX_REAL) continue;
    PetscCall(PetscPrintf(PETSC_COMM_SELF,
                          "%s: -change_file: the run ended before what changes from t = %s on\n",
                          RodsName(self->rods, k), OptionBoth(next, UNIT_TIME, text)));
  }
  PetscFunctionReturn(0);
}

/* RunTakeChanges - what the file that is gone on with had changed is so again, and what is to be is
   looked at. */
PetscErrorCode RunTakeChanges(Run *self) {
  const PetscReal from = self->restart[0] ? self->from.t * (1 - grow_rule.same_time) : 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    PetscCall(RodsEnter(self->rods, k));
    if (self->restart[0])
      PetscCall(RestartChange(self->restart, RodsName(self->rods, k), self->scene[k]));
    PetscCall(SceneChangesCheck(self->scene[k], from));
    PetscCall(RodsLeave(self->rods));
  }
  if (self->restart[0]) PetscCall(LegEndAtTurns(&self->leg));
  PetscFunctionReturn(0);
}
