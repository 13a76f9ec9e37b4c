/* -task grow of several rods: one run, with one clock. */
#ifndef TENDRIL_TASKS_SEVERAL_H
#define TENDRIL_TASKS_SEVERAL_H

#include "tasks/single.h"

PetscErrorCode SeveralAsked(PetscBool *asked);
PetscErrorCode SeveralRun(const Single *asked);

#endif
