/* A run that is a member of a sweep: it prints nothing and leaves what it has found in memory. */
#ifndef TENDRIL_MEMBER_H
#define TENDRIL_MEMBER_H

#include "record/output.h"

typedef struct {
  PetscErrorCode (*meanwhile)(void *ctx, PetscBool *drop); /* after every step; drop: end at once */
  void *ctx;
  PetscInt values;          /* how many of the observed are wanted */
  PetscBool space;          /* those of a rod in space may be among them */
  PetscBool series, shapes; /* wanted beside the last values */
  PetscBool stopped;        /* out: by a signal, or by meanwhile */
  Harvest harvest;          /* out, on the first rank of a run that has come to its end */
} Member;

#endif
