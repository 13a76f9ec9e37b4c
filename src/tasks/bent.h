/* -task critical of a rod that is bent: when its shape of the moment stops being stable. */
#ifndef TENDRIL_BENT_H
#define TENDRIL_BENT_H

#include "tasks/critical.h"

PetscErrorCode BentAsked(Scene scene, PetscBool *bent);
PetscErrorCode BentReadOptions(Scene scene);
PetscErrorCode BentFind(Scene scene, PetscBool quiet, Critical *critical);

#endif
