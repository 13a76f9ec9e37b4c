/* One run, from its options to its result. */
#ifndef TENDRIL_SINGLE_H
#define TENDRIL_SINGLE_H

#include "tasks/member.h"

enum { TASK_GROW, TASK_STABILITY, TASK_CRITICAL, TASK_UNITS, TASK_SWEEP }; /* as -task has them */

/* What is asked for, as far as it concerns no one else. */
typedef struct {
  PetscInt task;
  char output[PETSC_MAX_PATH_LEN], restart[PETSC_MAX_PATH_LEN];
} Single;

PetscErrorCode SingleAsked(PetscInt task, const char *output, Single *asked);
PetscErrorCode SingleShape(Scene scene);
PetscErrorCode SingleScene(PetscInt task, const char *output, Single *asked, Scene *scene);
PetscErrorCode SingleRun(PetscInt task, const char *output, Member *member);

#endif
