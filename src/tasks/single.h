/* One run, from its options to its result. */
#ifndef TENDRIL_SINGLE_H
#define TENDRIL_SINGLE_H

#include "tasks/member.h"

enum { TASK_GROW, TASK_STABILITY, TASK_CRITICAL, TASK_UNITS, TASK_SWEEP }; /* as -task has them */

PetscErrorCode SingleRun(PetscInt task, const char *output, Member *member);

#endif
