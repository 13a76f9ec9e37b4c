/* The whole program as a library. What it runs is said by PETSc's options, from the command line or
   set with PetscOptionsSetValue() before TendrilRun(). */
#ifndef TENDRIL_TENDRIL_H
#define TENDRIL_TENDRIL_H

#include <petscsys.h>

int TendrilInitialize(int *argc, char ***argv, PetscBool *done);
int TendrilFinalize(void);
PetscErrorCode TendrilRun(void);
void TendrilVersion(FILE *file);

#endif
