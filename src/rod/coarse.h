/* A rod beside another one on a mesh of every few of its nodes, for who follows its errors: the
   same laws, and numbers of them that may be nudged. */
#ifndef TENDRIL_COARSE_H
#define TENDRIL_COARSE_H

#include "rod/rod.h"

/* What is exact in the limit: beta -> 0 of friction; 1/k -> 0 of contact. */
typedef enum { COARSE_BETA, COARSE_STIFFNESS } CoarseNumber;

PetscErrorCode RodCoarsen(Rod rod, PetscInt nodes, PetscInt stride, PetscBool meets, Rod *coarse);
PetscErrorCode RodCoarseEnd(Rod *coarse);
void RodCoarseTake(Rod coarse, Rod rod, PetscBool meets);
void RodCoarseFollow(Rod coarse, Rod rod);
void RodCoarseSet(Rod coarse, CoarseNumber number, PetscReal value);
PetscReal RodCoarseGet(const Rod coarse, CoarseNumber number);

#endif
