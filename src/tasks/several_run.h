/* Several rods under way: what the files of their -task grow share. */
#ifndef TENDRIL_SEVERAL_RUN_H
#define TENDRIL_SEVERAL_RUN_H

#include "record/several.h"
#include "tasks/growing.h"

/* A rod that is run again, finer: what it has, and what is given and stays. */
typedef struct {
  PetscInt cells;
  PetscBool cells_given, stiffness_given;
} Finer;

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
  Vec U, U_t;  /* the state that was come to, and its rate: those of the leg, or of an event */
  Vec here[2]; /* ... or of a change, within a step */
  PetscInt stopped_by; /* the rod whose event ends the run; -1: none has */
  const char *restart; /* the file to go on from; empty: none */
  RestartState from;   /* of all, there, */
  RestartState *own;   /* and of each */
  OptionWords words;   /* the sections of that file */
  PetscReal end, rtol, eased, start, interval, next_output, stored_shape, t;
  PetscReal accuracy; /* as asked for; 0: none is */
  PetscInt runs;      /* that were not as accurate, */
  PetscReal before;   /* and the error estimate of the latest of them */
  Finer *finer;       /* [n], of -accuracy; NULL: not */
  PetscBool rtol_given;
  PetscBool by_steps;            /* a host program asks for one step after the other: RunStep() */
  PetscReal until;               /* ... and what is beyond waits to be looked at */
  PetscBool waits;               /* the step that was taken last does */
  PetscBool enters;              /* the stepper begins to solve */
  PetscBool over;                /* no step follows */
  PetscBool quiet, begun, ready; /* ready: what there is may be stored */
  PetscInt snaps;
  PetscReal counted[2]; /* iterations and rejected tries of the runs that it goes on with */
  int stopped;
  TSConvergedReason reason;
  Pace pace;
} Run;

/* several.c: the loop */
PetscErrorCode RunAfterStep(TS ts);
PetscErrorCode RunAfterSolve(Run *self);

/* several_steps.c: a run by steps */
PetscErrorCode RunStep(Run *self, PetscReal until);
PetscErrorCode RunWithin(Run *self, PetscReal t, Vec V[2]);
PetscErrorCode RunSave(Run *self, const char *path, PetscReal t, PetscReal now);

/* several_events.c */
PetscErrorCode RunRefuseEvents(Run *self);
PetscErrorCode RunLocateEvent(Run *self, PetscReal *t);
PetscErrorCode RunEndHere(Run *self);

/* several_begin.c */
PetscErrorCode RunBegin(Run *self);
PetscErrorCode RunEnd(Run *self);

/* several_changes.c */
PetscErrorCode RunApply(Run *self, PetscInt which, const char *name, const char *value,
                        PetscReal t);
PetscErrorCode RunRecord(Run *self, PetscInt which, const char *name, const char *value,
                         PetscReal t);
PetscBool RunIsChanged(const Run *self);
PetscErrorCode RunStepOn(Run *self, PetscReal until);
PetscErrorCode RunTellNotReached(Run *self);
PetscErrorCode RunTakeChanges(Run *self);

/* several_accuracy.c */
PetscErrorCode RunAccuracy(Run *self, PetscBool touches);
PetscErrorCode RunRefine(Run *self, PetscBool *again);
PetscErrorCode RunStartOver(Run *self);

/* several_keep.c */
PetscErrorCode RunKeep(void *ctx, HdfFile file);
PetscErrorCode RunReadRestart(Run *self);
PetscErrorCode RunCheckSame(const Run *self);
PetscErrorCode RunReadEach(Run *self);
PetscErrorCode RunGoOn(Run *self);

/* several_strands.c */
PetscErrorCode RunMakeStrands(Run *self);
PetscErrorCode RunKnowStrands(Run *self, PetscReal t, PetscBool moves);
PetscErrorCode RunTellStrands(void *ctx, PetscInt k, PetscReal t, PetscBool moves, StrandsOn *on);

/* several_look.c */
void RunEaseEach(Run *self, PetscReal finest);
PetscErrorCode RunLook(Run *self, PetscReal t, PetscBool begins);
PetscErrorCode RunStoreShape(Run *self, PetscReal t, Vec U);
PetscErrorCode RunStoreDue(Run *self, PetscReal t);
PetscBool RunShareMore(Run *self, PetscBool again);

/* several_report.c */
PetscErrorCode RunHeading(Run *self);
PetscErrorCode RunProgress(Run *self, PetscBool last);
PetscErrorCode RunFinish(Run *self, PetscBool *again);

#endif
