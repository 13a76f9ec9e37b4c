/* Where what tables give bends: between two of these places all of it goes on straight, to a
   tolerance. Who looks at them all cannot miss what comes and goes in between. */
#ifndef TENDRIL_BENDS_H
#define TENDRIL_BENDS_H

#include <petscsys.h>

typedef struct {
  PetscInt n, room;
  PetscReal *at; /* increasing after BendsSort() */
} Bends;

/* What the columns of a table, interpolated, are at a place, and their slopes there. */
typedef PetscErrorCode (*BendsCurve)(const void *table, PetscReal at, PetscReal value[],
                                     PetscReal slope[]);

PetscErrorCode BendsAdd(Bends *bends, PetscReal at);
PetscErrorCode BendsFind(PetscInt n, const PetscReal row[], PetscInt columns, BendsCurve curve,
                         const void *table, PetscReal tolerance, Bends *bends);
PetscErrorCode BendsSort(Bends *bends, PetscReal from, PetscReal to);
PetscReal BendsNext(const Bends *bends, PetscReal after);
PetscErrorCode BendsDestroy(Bends *bends);

#endif
