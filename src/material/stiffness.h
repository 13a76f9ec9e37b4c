/* The bending stiffness B of the rod over that of the unit of force and length: 1, or given by a
   table over the distance from the tip. */
#ifndef TENDRIL_STIFFNESS_H
#define TENDRIL_STIFFNESS_H

#include "material/growth.h"

typedef struct {
  PetscBool varies; /* B is not the same everywhere */
  PetscReal all;    /* what all of it is multiplied by, of one of several rods; else 1 */
  PetscInt n;
  PetscReal *distance, *factor, *factor2; /* knots of the spline, values, second derivatives */
  PetscReal most;                         /* the largest of the values; `all` without them */
} Stiffness;

extern const OptionGroup stiffness_options;

PetscErrorCode StiffnessSetFromOptions(Stiffness *stiffness);
PetscErrorCode StiffnessDestroy(Stiffness *stiffness);
PetscReal StiffnessFinest(const Stiffness *stiffness, PetscReal length);
PetscErrorCode StiffnessTable(const Stiffness *stiffness, Growth growth, PetscReal s, PetscReal t,
                              PetscReal *B, PetscReal *B_t);

#endif
