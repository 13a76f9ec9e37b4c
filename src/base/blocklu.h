/* A matrix of blocks, one for each pair of nodes that depend on each other, and its factors: of a
   rod that touches itself, whose nodes depend on their neighbours and on whom they touch. For one
   rank. PETSc sees a shell matrix and a shell preconditioner. */
#ifndef TENDRIL_BLOCKLU_H
#define TENDRIL_BLOCKLU_H

#include <petscksp.h>

PetscBool BlockLUCan(PetscInt nodes, PetscInt fields);
PetscErrorCode BlockLUCreate(PetscInt nodes, PetscInt fields, PetscInt n_late,
                             const PetscInt late[], Mat *J);
PetscErrorCode BlockLUSetSolver(KSP ksp);

#endif
