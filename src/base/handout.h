/* Jobs handed out to teams of ranks as they fall free. */
#ifndef TENDRIL_HANDOUT_H
#define TENDRIL_HANDOUT_H

#include <petscsys.h>

typedef struct _Handout *Handout;

/* On rank 0: what a team has left; what is to be done now and then. */
typedef PetscErrorCode (*HandoutTake)(void *ctx, size_t bytes, const void *result);
typedef PetscErrorCode (*HandoutTick)(void *ctx);

PetscErrorCode HandoutCreate(MPI_Comm comm, PetscInt each, PetscInt n, const PetscInt jobs[],
                             HandoutTake take, HandoutTick tick, void *ctx, Handout *handout);
MPI_Comm HandoutTeam(Handout handout);
PetscErrorCode HandoutNext(Handout handout, PetscInt *job);
PetscErrorCode HandoutReturn(Handout handout, size_t bytes, const void *result);
PetscErrorCode HandoutMeanwhile(Handout handout, PetscBool *stop);
PetscErrorCode HandoutStop(Handout handout);
PetscErrorCode HandoutEnd(Handout *handout);

#endif
