/* A rod that is coupled: parts that are far from each other along it meet. Every rank knows all of
   its nodes, and the matrix has room for pairs of cells that are near to touching. */
#ifndef TENDRIL_COUPLED_H
#define TENDRIL_COUPLED_H

#include "rod/rod.h"
#include "rod/strands.h"

typedef struct _Coupled *Coupled;

PetscErrorCode CoupledCreate(Rod rod, Coupled *coupled);
PetscErrorCode CoupledDestroy(Coupled *coupled);
PetscErrorCode CoupledOpen(Coupled self, Vec U, Vec U_t, const PetscReal *u[2]);
PetscErrorCode CoupledClose(Coupled self, Vec U, Vec U_t);
PetscErrorCode CoupledPattern(Rod rod, Coupled self, PetscBool fresh, PetscInt n, CellPair *near,
                              Mat J);

#endif
