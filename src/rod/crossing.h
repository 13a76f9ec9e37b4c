/* Where the centre line of a rod crosses itself. */
#ifndef TENDRIL_CROSSING_H
#define TENDRIL_CROSSING_H

#include "rod/rod.h"

PetscErrorCode RodPassesItself(PetscInt n, const PetscInt *of, const Node *from, const Node *to,
                               PetscBool *passes);
PetscErrorCode RodCrossings(PetscInt n, const Node *nodes, PetscInt *count);

#endif
