/* One process at a time writes a file: locks, which end with the process however it ends. */
#ifndef TENDRIL_LOCK_H
#define TENDRIL_LOCK_H

#include "base/errors.h"

PetscErrorCode LockTake(MPI_Comm comm, const char *option, const char *path);
PetscErrorCode LockGive(const char *path);
void LocksEnd(void);

#endif
