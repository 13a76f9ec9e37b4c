/* Rods that come out in a run: until then they are in the vector of all, stay as they are, and
   nothing is asked of them (SceneRests()). */
#ifndef TENDRIL_BIRTHS_H
#define TENDRIL_BIRTHS_H

#include "system/joints.h"

PetscErrorCode BirthPlace(Rod all, Joints joints, PetscInt k, PetscReal t, Vec U);

#endif
