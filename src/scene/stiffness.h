/* The bending stiffness B of the rod, over that of the unit of force and length: 1. */
#ifndef TENDRIL_STIFFNESS_H
#define TENDRIL_STIFFNESS_H

#include "scene/growth.h"

typedef struct {
  PetscBool varies; /* B is not 1 everywhere */
} Stiffness;

/* B at the label s and time t. */
static inline PetscReal StiffnessAt(const Stiffness *stiffness, Growth growth, PetscReal s,
                                    PetscReal t) {
  return 1;
}

#endif
