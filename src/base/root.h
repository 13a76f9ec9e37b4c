/* Where a function of one variable, dear to ask, goes from below 0 to above. (PETSc solves systems,
   and brackets nothing.) */
#ifndef TENDRIL_ROOT_H
#define TENDRIL_ROOT_H

#include <petscsys.h>

typedef PetscErrorCode (*RootFunction)(void *ctx, PetscReal t, PetscReal *f);

PetscErrorCode RootFind(RootFunction function, void *ctx, PetscReal a, PetscReal fa, PetscReal b,
                        PetscReal fb, PetscReal precision, PetscReal *root);

#endif
