/* What is seen of one of several rods before it is born, and at its birth. */
#ifndef TENDRIL_TASKS_BIRTHS_H
#define TENDRIL_TASKS_BIRTHS_H

#include "tasks/growing.h"

PetscErrorCode GrowUnseen(Grow *self, PetscReal t);
PetscErrorCode GrowNoShape(Grow *self, PetscReal t, Vec U);
PetscErrorCode GrowBorn(Grow *self, PetscReal t);

#endif
