/* Snaps: dry friction gives way, and a rod without inertia is elsewhere at once. */
#ifndef TENDRIL_SNAP_H
#define TENDRIL_SNAP_H

#include <petscts.h>

PetscErrorCode SnapFollow(TS ts, PetscReal t, Vec U, PetscBool *done);

#endif
