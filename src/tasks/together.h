/* Several rods under way: what the files of their -task grow share. */
#ifndef TENDRIL_TOGETHER_H
#define TENDRIL_TOGETHER_H

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
  Vec here[2]; /* of an event within a step */
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
  PetscBool by_steps; /* a host program asks for one step after the other: TogetherStep() */
  PetscReal until;    /* ... and what is beyond waits to be looked at */
  PetscBool waits;    /* the step that was taken last does */
  PetscBool enters;   /* the stepper begins to solve */
  PetscBool over;     /* no step follows */
  PetscBool quiet, begun, ready; /* ready: what there is may be stored */
  PetscInt snaps;
  PetscReal counted[2]; /* iterations and rejected tries of the runs that it goes on with */
  int stopped;
  TSConvergedReason reason;
  Pace pace;
} Together;

/* several.c: the loop */
PetscErrorCode TogetherAfterStep(TS ts);
PetscErrorCode TogetherAfterSolve(Together *self);

/* together_steps.c: a run by steps */
PetscErrorCode TogetherStep(Together *self, PetscReal until);
PetscErrorCode TogetherWithin(Together *self, PetscReal t, Vec V[2]);
PetscErrorCode TogetherSave(Together *self, const char *path, PetscReal t, PetscReal now);

/* together_events.c */
PetscErrorCode TogetherRefuseEvents(Together *self);
PetscErrorCode TogetherLocateEvent(Together *self, PetscReal *t);
PetscErrorCode TogetherEndHere(Together *self);

/* together_begin.c */
PetscErrorCode TogetherBegin(Together *self);
PetscErrorCode TogetherEnd(Together *self);

/* together_accuracy.c */
PetscErrorCode TogetherAccuracy(Together *self, PetscBool touches);
PetscErrorCode TogetherRefine(Together *self, PetscBool *again);
PetscErrorCode TogetherStartOver(Together *self);

/* together_keep.c */
PetscErrorCode TogetherKeep(void *ctx, HdfFile file);
PetscErrorCode TogetherReadRestart(Together *self);
PetscErrorCode TogetherCheckSame(const Together *self);
PetscErrorCode TogetherReadEach(Together *self);
PetscErrorCode TogetherGoOn(Together *self);

/* together_look.c */
PetscErrorCode TogetherStrands(Together *self, PetscReal t, PetscBool moves);
PetscErrorCode TogetherTellStrands(void *ctx, PetscInt k, PetscReal t, PetscBool moves,
                                   StrandsOn *on);
void TogetherEase(Together *self, PetscReal finest);
PetscErrorCode TogetherLook(Together *self, PetscReal t, PetscBool begins);
PetscErrorCode TogetherShape(Together *self, PetscReal t, Vec U);
PetscErrorCode TogetherDue(Together *self, PetscReal t);
PetscBool TogetherShare(Together *self, PetscBool again);

/* together_report.c */
PetscErrorCode TogetherHeading(Together *self);
PetscErrorCode TogetherProgress(Together *self, PetscBool last);
PetscErrorCode TogetherFinish(Together *self, PetscBool *again);

#endif
