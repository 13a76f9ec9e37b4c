/* Not-a-knot cubic splines: smooth interpolation of the tables that a user gives. */
#ifndef TENDRIL_SPLINE_H
#define TENDRIL_SPLINE_H

#include <petscsys.h>

PetscErrorCode SplineSecondDerivatives(PetscInt n, const PetscReal x[], PetscInt rows,
                                       PetscInt row_stride, PetscInt stride, const PetscReal f[],
                                       PetscReal f2[]);
void SplineWeights(PetscInt n, const PetscReal x[], PetscReal at, PetscInt *i, PetscReal value[4],
                   PetscReal slope[4], PetscReal integral[4]);
PetscReal SplineSteepest(PetscInt n, const PetscReal x[], const PetscReal f[], PetscReal end);

#endif
