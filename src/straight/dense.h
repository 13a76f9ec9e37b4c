/* Dense matrices that are not symmetric, by LAPACK. */
#ifndef TENDRIL_DENSE_H
#define TENDRIL_DENSE_H

#include <petscsys.h>

PetscErrorCode DenseEigenvalues(PetscInt n, PetscReal T[], PetscReal re[], PetscReal im[],
                                PetscReal *VL);
PetscErrorCode DenseSolve(PetscInt n, PetscReal A[], PetscReal b[]);

#endif
