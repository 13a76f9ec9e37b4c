/* A run of several rods that is under way: what the files of -task grow of several rods share. */
#ifndef TENDRIL_SEVERAL_RUN_H
#define TENDRIL_SEVERAL_RUN_H

#include "record/several.h"
#include "tasks/growing.h"

typedef struct {
  Rods rods;
  Joints joints;
  PetscInt n;
  Scene *scene;
  Leg leg;              /* of all */
  Estimate estimate;    /* of rods that hold each other; NULL: each has its own */
  Strands strands[2];   /* of those that may touch, for the stepper and for who looks; NULL: none */
  RodSeen looked;       /* the state that the latter know, */
  PetscBool with_rates; /* ... and whether with its rates */
  Grow *each;           /* what is seen of each */
  Output *output;
  Several file;
  const char *restart; /* the file to go on from; empty: none */
  RestartState from;   /* of all, there, */
  RestartState *own;   /* and of each */
  OptionWords words;   /* the sections of that file */
  PetscReal end, rtol, eased, start, interval, next_output, stored_shape, t;
  PetscBool *to_come, bears;     /* rods that are not born yet; some are with the latest step */
  PetscBool quiet, begun, ready; /* ready: what there is may be stored */
  PetscInt snaps;
  PetscReal counted[2]; /* iterations and rejected tries of the runs that it goes on with */
  int stopped;
  TSConvergedReason reason;
  Pace pace;
} Run;

/* several.c */
PetscErrorCode RunLook(Run *self, PetscReal t, PetscBool begins);
PetscErrorCode RunStoreShape(Run *self, PetscReal t, Vec U);
PetscErrorCode RunAfterStep(TS ts);

/* births.c */
PetscBool RunAnyBorn(const Run *self);
PetscErrorCode RunCheckSteps(const Run *self);
PetscErrorCode RunBirths(Run *self, PetscReal t);
PetscErrorCode RunLookAt(Run *self, PetscInt k, PetscReal t, PetscBool begins);
PetscErrorCode RunShapeOf(Run *self, PetscInt k, PetscReal t, Vec U);

/* several_begin.c */
PetscErrorCode RunBegin(Run *self);

/* several_strands.c */
PetscErrorCode RunMakeStrands(Run *self);
PetscErrorCode RunKnowStrands(Run *self, PetscReal t, PetscBool moves);
PetscErrorCode RunTellStrands(void *ctx, PetscInt k, PetscReal t, PetscBool moves, StrandsOn *on);

/* several_keep.c */
PetscErrorCode RunKeep(void *ctx, HdfFile file);
PetscErrorCode RunReadRestart(Run *self);
PetscErrorCode RunCheckSame(const Run *self);
PetscErrorCode RunReadEach(Run *self);
void RunEaseEach(Run *self, PetscReal finest);
PetscErrorCode RunGoOn(Run *self);

/* several_report.c */
PetscErrorCode RunHeading(Run *self);
PetscErrorCode RunProgress(Run *self, PetscBool last);
PetscErrorCode RunSummary(Run *self);
PetscErrorCode RunVerdict(Run *self);

#endif
