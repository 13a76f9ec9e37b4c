/* The whole program as a library. What it runs is said by PETSc's options, from the command line or
   set with PetscOptionsSetValue() before ProgramRun(). */
#ifndef TENDRIL_PROGRAM_H
#define TENDRIL_PROGRAM_H

#include "base/options.h"

/* A process of it. */
typedef struct {
  ErrorState errors;
  CommandLine line;
  PetscBool began_mpi;
} Program;

int ProgramBegin(Program *program, int *argc, char ***argv, PetscBool *done);
int ProgramEnd(Program *program);
PetscErrorCode ProgramRun(void);
void ProgramSetTable(void);
int ProgramBeginMpi(int *argc, char ***argv, PetscBool tidy);
void ProgramVersion(FILE *file);

#endif
