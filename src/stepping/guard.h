/* A step after which the rod has passed through itself or a wall is not taken. */
#ifndef TENDRIL_GUARD_H
#define TENDRIL_GUARD_H

#include <petscts.h>

PetscErrorCode GuardPasses(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1, PetscBool *passes);

#endif
