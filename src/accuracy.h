/* One knob for model, mesh and tolerances. */
#ifndef TENDRIL_ACCURACY_H
#define TENDRIL_ACCURACY_H

#include <petscsys.h>

PetscErrorCode AccuracyApply(void);
PetscReal AccuracyEstimate(PetscInt steps, PetscReal rtol, PetscReal h, PetscInt order);

#endif
