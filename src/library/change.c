/* What is changed in a run. */
#include "library/simulation.h"

/* What must be known before the run is touched. */
static PetscErrorCode Check(Tendril self, const char *name) {
  PetscFunctionBegin;
  UserCheck(!self->failed, self->comm, "%s: the run has given up; nothing can be changed any more",
            name);
  UserCheck(!self->ended || (!strcmp(name, "-ts_max_time") && CourseMayGoOn(self)), self->comm,
            "%s: the run is at its end; nothing can be changed any more", name);
  PetscFunctionReturn(0);
}

/*
  SimulationChange - a new value from the present time on: the run ends its step there, and goes on
  in short ones. What is refused has changed nothing. Collective.
*/
PetscErrorCode SimulationChange(Tendril self, const char *name, const char *value) {
  PetscFunctionBegin;
  PetscCall(Check(self, name));
  PetscCall(CourseChange(self, name, value));
  self->ended = PETSC_FALSE;
  PetscCall(SimulationLook(self));
  PetscFunctionReturn(0);
}
