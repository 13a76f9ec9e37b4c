/* What is changed in a run. */
#include "library/simulation.h"
#include "scene/change.h"

/* The value that the options have of a name; "" if none. */
static PetscErrorCode ValueOf(Tendril self, const char *name, char value[PETSC_MAX_PATH_LEN]) {
  PetscFunctionBegin;
  value[0] = 0;
  PetscCall(PetscOptionsGetString(self->options, NULL, name, value, PETSC_MAX_PATH_LEN, NULL));
  PetscFunctionReturn(0);
}

/* What must be known before the state is touched. */
static PetscErrorCode Check(Tendril self, const char *name) {
  PetscFunctionBegin;
  UserCheck(!self->failed, self->comm, "%s: the run has given up; nothing can be changed any more",
            name);
  UserCheck(!self->ended || (!strcmp(name, "-ts_max_time") && !self->grow->event.kind), self->comm,
            "%s: the run is at its end; nothing can be changed any more", name);
  UserCheck(self->grow->model != LINEAR, self->comm,
            "%s: cannot be changed with -rod_model linear; take frame or auto", name);
  PetscFunctionReturn(0);
}

/* Puts a value back, also for the record. */
static PetscErrorCode PutBack(Tendril self, const char *name, const char *value) {
  const OptionRow *row = OptionFind(name);
  char text[PETSC_MAX_PATH_LEN];
  PetscReal real;

  PetscFunctionBegin;
  if (value[0])
    PetscCall(PetscOptionsSetValue(self->options, name, value));
  else
    PetscCall(PetscOptionsClearValue(self->options, name));
  if (row && row->kind == KIND_REAL)
    PetscCall(OptionReal(name, &real, NULL));
  else if (row && row->kind == KIND_TEXT && value[0])
    PetscCall(OptionText(name, text, NULL));
  PetscFunctionReturn(0);
}

/*
  SimulationChange - a new value of an option from the present time on: the run ends its step there,
  and goes on in short ones. What is refused has changed nothing. Collective.
*/
PetscErrorCode SimulationChange(Tendril self, const char *name, const char *value) {
  char before[PETSC_MAX_PATH_LEN];
  PetscErrorCode error;
  PetscBool acts;

  PetscFunctionBegin;
  PetscCall(Check(self, name));
  PetscCall(ValueOf(self, name, before));
  PetscCall(PetscOptionsSetValue(self->options, name, value));
  error = SceneMayChange(self->scene, name, self->at);
  if (error) PetscCall(PutBack(self, name, before));
  PetscCall(error);
  acts = (PetscBool)(strcmp(name, "-ts_max_time") != 0 || self->grow->waits);
  PetscCall(GrowSettle(self->grow, self->at));
  PetscCall(SceneChange(self->scene, name, self->at));
  PetscCall(GrowChange(self->grow, acts));
  self->changes++;
  self->ended = self->grow->over = PETSC_FALSE;
  PetscCall(SimulationLook(self));
  PetscFunctionReturn(0);
}
