/* -task grow: what is changed in a run, by -change_file or by who takes it step by step. */
#include "scene/change.h"
#include "tasks/grow_rules.h"
#include "tasks/growing.h"

/* The value that the options have of a name; "" if none. */
static PetscErrorCode ValueOf(const char *name, char value[PETSC_MAX_PATH_LEN]) {
  PetscFunctionBegin;
  value[0] = 0;
  PetscCall(PetscOptionsGetString(NULL, NULL, name, value, PETSC_MAX_PATH_LEN, NULL));
  PetscFunctionReturn(0);
}

/* Refuses a wall, or a lamp, that would be put where the rod is. */
static PetscErrorCode CheckRoom(Grow *self, const char *name, const char *value, PetscReal t) {
  const PetscInt n = self->scene->mesh.cells + 1;
  const PetscBool lamp = (PetscBool)!strcmp(name, "-tropism_source");
  const Node *nodes;
  PetscReal(*x)[3];
  PetscBool room;

  PetscFunctionBegin;
  if (!lamp && strcmp(name, "-wall_at") != 0) PetscFunctionReturn(0);
  PetscCall(ObserverGather(self->observer, self->now->rod, t,
                           self->seen.t > 0 ? self->now->U : NULL, NULL, &nodes));
  PetscCall(PetscMalloc1(n, &x));
  for (PetscInt i = 0; nodes && i < n; i++)
    for (int d = 0; d < 3; d++) x[i][d] = nodes[i].x[d];
  PetscCall((lamp ? SceneLampHasRoom : SceneHasRoom)(self->scene, value, t, nodes ? n : 0,
                                                     (const PetscReal(*)[3])x, &room));
  PetscCall(PetscFree(x));
  PetscCallMPI(MPI_Bcast(&room, 1, MPIU_BOOL, 0, self->scene->comm));
  UserCheck(room || !lamp, self->scene->comm,
            "-tropism_source %s: the rod is there, and has no direction to a lamp; put it beside",
            value);
  UserCheck(room, self->scene->comm, "-wall_at %s: the rod is there", value);
  PetscFunctionReturn(0);
}

/* What must be known before the state is touched. */
static PetscErrorCode Check(Grow *self, const char *name) {
  PetscFunctionBegin;
  UserCheck(self->model != LINEAR, self->scene->comm,
            "%s: cannot be changed with -rod_model linear; take frame or auto", name);
  UserCheck(!self->sensitivities, self->scene->comm,
            "-sensitivity: is not known of a run in which something is changed; take it out");
  UserCheck(strcmp(name, "-rod_weight") != 0 || self->scene->load.weighs || self->by_steps,
            self->scene->comm,
            "-rod_weight: begin the run with one, however small, if it is to change");
  PetscFunctionReturn(0);
}

/* GrowMayChange - refuses what cannot be changed at t; the options have the value. Collective. */
PetscErrorCode GrowMayChange(Grow *self, const char *name, const char *value, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(Check(self, name));
  PetscCall(SceneMayChange(self->scene, name, value, t));
  PetscCall(CheckRoom(self, name, value, t));
  PetscFunctionReturn(0);
}

/* In force from t on; the options have the value. */
static PetscErrorCode Apply(Grow *self, const char *name, const char *value, PetscReal t) {
  const PetscBool acts = (PetscBool)(strcmp(name, "-ts_max_time") != 0 || self->waits);
  const PetscReal end = self->scene->end_time;

  PetscFunctionBegin;
  PetscCall(GrowMayChange(self, name, value, t));
  PetscCall(GrowSettle(self, t));
  PetscCall(SceneChange(self->scene, name, value, t));
  PetscCall(EstimateSceneChanged(self->estimate));
  PetscCall(GrowChange(self, acts));
  if (self->scene->end_time > end) self->over = PETSC_FALSE;
  PetscFunctionReturn(0);
}

/* GrowPutOption - an option has a value; before: what it had. Words that are no
   option have none. */
PetscErrorCode GrowPutOption(const char *name, const char *value, char before[PETSC_MAX_PATH_LEN]) {
  PetscFunctionBegin;
  if (!SceneChangedOption(name)) PetscFunctionReturn(0);
  PetscCall(ValueOf(name, before));
  PetscCall(PetscOptionsSetValue(NULL, name, value));
  PetscFunctionReturn(0);
}

/* GrowPutBack - options are those with which the run began: from these, and what was changed,
   another one gets to where it is. */
PetscErrorCode GrowPutBack(const char *name, const char *before, PetscBool failed) {
  PetscFunctionBegin;
  if (SceneChangedOption(name) && (failed || strcmp(name, "-ts_max_time") != 0))
    PetscCall(OptionPut(name, before));
  PetscFunctionReturn(0);
}

/*
  GrowApply - a new value from the present time on: the run ends its step there, and goes on in
  short ones. What is refused has changed nothing. Collective.

  name  with its dash
  t     the present time: that of the latest step, or one within the step that waits
*/
PetscErrorCode GrowApply(Grow *self, const char *name, const char *value, PetscReal t) {
  char before[PETSC_MAX_PATH_LEN];
  PetscErrorCode error;

  PetscFunctionBegin;
  PetscCall(GrowPutOption(name, value, before));
  error = Apply(self, name, value, t);
  PetscCall(GrowPutBack(name, before, (PetscBool)(error != 0)));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* What is due at t. */
static PetscErrorCode TakeDue(Grow *self, PetscReal t) {
  Changes list = self->scene->changes;
  char name[128];

  PetscFunctionBegin;
  PetscCall(GrowSettle(self, t)); /* what is kept of a run that a row ends can be gone on with */
  while (ChangesNext(list) <= t * (1 + grow_rule.same_time)) {
    const ChangeRow *row = &list->row[list->done];
    (void)snprintf(name, sizeof(name), "-%s", row->what);
    SceneChangeAbout(row);
    PetscCall(GrowApply(self, name, row->value, t));
    SceneChangeAbout(NULL);
    list->done++;
  }
  PetscFunctionReturn(0);
}

/* GrowTellNotReached - says it where the run has ended before what -change_file says was due.
   Collective. */
PetscErrorCode GrowTellNotReached(Grow *self) {
  const PetscReal next = ChangesNext(self->scene->changes);
  char text[64];

  PetscFunctionBegin;
  if (next == PETSC_MAX_REAL || self->quiet) PetscFunctionReturn(0);
  PetscCall(PetscPrintf(self->scene->comm,
                        "-change_file: the run ended before what changes from t = %s on\n",
                        OptionBoth(next, UNIT_TIME, text)));
  PetscFunctionReturn(0);
}

/*
  GrowStepOn - as GrowStep(), but that what -change_file says is done when it is due: at the end of
  a step, which it makes end there. Steps before it are those of a run that knows nothing of it.
  Collective.
*/
PetscErrorCode GrowStepOn(Grow *self, PetscReal until) {
  const PetscReal next = ChangesNext(self->scene->changes);

  PetscFunctionBegin;
  if (next <= self->seen.t * (1 + grow_rule.same_time)) {
    PetscCall(TakeDue(self, self->seen.t));
    PetscFunctionReturn(0);
  }
  PetscCall(GrowStep(self, PetscMin(until, next)));
  if (self->over || until < next) PetscFunctionReturn(0);
  if (self->waits || self->seen.t >= next * (1 - grow_rule.same_time))
    PetscCall(TakeDue(self, self->waits ? next : self->seen.t));
  PetscFunctionReturn(0);
}
