/* The straight rod whose growth feels force (material/growth_yield.c): how fast its material moves
   at each length, and so how long it is at each time. */
#ifndef TENDRIL_YIELDING_H
#define TENDRIL_YIELDING_H

#include "scene/scene.h"

PetscErrorCode YieldingFollow(Scene scene);
PetscErrorCode YieldingAt(Scene scene, PetscReal t);

#endif
