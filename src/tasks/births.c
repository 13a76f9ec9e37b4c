#include "tasks/births.h"

/* GrowUnseen - the rod is not there yet: nothing is observed of it but when. */
PetscErrorCode GrowUnseen(Grow *self, PetscReal t) {
  PetscReal *value = (PetscReal *)&self->seen;

  PetscFunctionBegin;
  for (int i = 0; i < OBSERVED; i++) value[i] = NAN;
  self->seen.t = t;
  PetscCall(OutputSeries(self->output, &self->seen));
  PetscFunctionReturn(0);
}

/* GrowNoShape - nor has it a shape, whatever its part of a state is. */
PetscErrorCode GrowNoShape(Grow *self, PetscReal t, Vec U) {
  PetscFunctionBegin;
  PetscCall(GrowStoreShape(self, t, U));
  PetscCall(OutputBlank(self->output));
  PetscFunctionReturn(0);
}

/* GrowBorn - the rod is there from now on: what is observed of it at its birth. It is at rest, for
   how fast its carrier moves it is not known before the step behind; its energy is summed up from
   there. */
PetscErrorCode GrowBorn(Grow *self, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(
      ObserverMeasure(self->observer, self->now->rod, t, self->now->U, NULL, NULL, &self->seen));
  self->seen.step = self->seen.newton_iterations = 0;
  self->seen.model = (PetscReal)self->model;
  PetscCall(OutputSeries(self->output, &self->seen));
  PetscFunctionReturn(0);
}
