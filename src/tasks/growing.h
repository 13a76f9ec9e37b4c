/* A run that is under way: what the files of -task grow share. */
#ifndef TENDRIL_GROWING_H
#define TENDRIL_GROWING_H

#include "stepping/estimate.h"
#include "stepping/tolerance.h"
#include "tasks/crawl.h"
#include "tasks/member.h"

enum {
  LINEAR,
  FRAME,
  MIXED,
  SPACE,
  AUTO,
  MODELS = AUTO
}; /* as -rod_model and the series `model` say */

typedef struct _Sensitivities *Sensitivities;

/* When lines of progress are printed. */
typedef struct {
  PetscLogDouble begin, reported; /* the run, and the latest of them, by the clock */
  PetscReal next;                 /* time of the run at which one is due */
} Pace;

typedef struct {
  Scene scene;
  Member *member;           /* NULL: the run is no sweep's */
  PetscBool by_steps;       /* a host program asks for one step after the other: GrowStep() */
  PetscReal until;          /* ... and what is beyond waits to be looked at */
  PetscBool waits;          /* the step that was taken last does */
  PetscBool enters;         /* the stepper begins to solve: at the start, and with another model */
  PetscBool over;           /* no step follows, */
  TSConvergedReason reason; /* for this reason */
  PetscReal balance[BALANCE_STATE]; /* of energy, of a run by steps, as the latest one began */
  PetscInt marks;
  struct GrowMark *mark; /* of a run by steps, at the times of its stored shapes: grow_keep.c */
  Load load;             /* as the run began: it may give friction a viscous share */
  PetscInt model;        /* as asked for */
  PetscBool can[MODELS]; /* which models can be of this scene */
  Leg leg[MODELS];       /* by model; those not in use are empty; auto has two, taking turns */
  Leg *now;
  Observer observer;
  Estimate estimate; /* of the frame model's errors; NULL: it is not in use */
  Output output;
  Sensitivities sensitivities; /* NULL: none are asked for */
  Observation seen;            /* of the latest step */
  PetscReal rtol, output_interval, next_output;
  PetscReal eased;        /* what rtol may be at most, as the estimate says */
  PetscReal stored_shape; /* time of the latest shape handed to the output */
  PetscInt iterations;    /* of the leg so far */
  PetscReal counted[2];   /* iterations and rejected tries of the runs that it goes on with */
  PetscReal neglects;     /* part that the linear model leaves out, or would, now */
  ErrorEstimate error; /* as GrowErrors() has found it; when and why of what was largest so far */
  Remembered kept;     /* what who goes on with the run must know, besides */
  PetscBool quiet, beyond; /* beyond: the linear model has left its range */
  int stopped;             /* the signal that all ranks have agreed to stop on */
  Pace pace;
  Watch watch;
  PetscReal shared;  /* viscous share of friction that has been told, see LoadShareMore() */
  PetscBool slips;   /* it does all the same, without end: the run ends for that */
  PetscBool jammed;  /* the run ends for that */
  PetscReal to_lamp; /* how near the tip has come to the lamp in the latest step */
  PetscBool blinded; /* nearer than it can be sensed: the run ends for that */
  Crawl crawl;
  PetscReal force_before; /* on the clamp, of the state before that which was seen last */
  PetscBool crawls;       /* the run ends for that */
  Event event;            /* that ended the run */
  PetscReal start;        /* t at which this run began: 0, or a restart's */
  PetscReal end, reach;   /* t and length at its end, if nothing but -stop_length ends it before */
} Grow;

extern const RodModel *const grow_models[MODELS];

/* grow_keep.c */
PetscErrorCode GrowKeep(Grow *self, RestartState *state, Vec points[], Vec errors[]);
PetscErrorCode GrowMark(Grow *self, PetscReal t);
PetscErrorCode GrowMarksDestroy(Grow *self);
PetscErrorCode GrowSave(Grow *self, const char *path, PetscReal t, PetscReal now);

/* grow_begin.c */
PetscErrorCode GrowCreate(Grow *self, const char *output, const char *restart);
PetscErrorCode GrowDestroy(Grow *self);
PetscErrorCode GrowTolerance(PetscBool touches, PetscReal *rtol, PetscReal *most);

/* grow_start.c */
PetscErrorCode GrowCheckStart(Grow *self);

/* grow_model.c */
const RodModel *GrowModelOf(const Grow *self, PetscInt model);
PetscInt GrowWholeModel(const Grow *self);
PetscInt GrowBetterModel(const Grow *self);
Leg *GrowOwnLeg(Grow *self);
PetscErrorCode GrowAddLeg(Grow *self, PetscInt model);
PetscErrorCode GrowHandOver(Grow *self, Leg *to);
PetscErrorCode GrowNeglect(Grow *self, Vec U_t);
void GrowWeigh(Grow *self, const Observation *last, PetscReal folds);

/* grow.c: the loop, and a run by steps */
PetscErrorCode GrowObserve(Grow *self, PetscReal t, Vec U, Vec U_t);
PetscErrorCode GrowStore(Grow *self, PetscBool finished);
PetscErrorCode GrowStoreShape(Grow *self, PetscReal t, Vec U);
PetscErrorCode GrowAfterStep(TS ts);
PetscErrorCode GrowStepOnce(TS ts);
PetscErrorCode GrowStep(Grow *self, PetscReal until);
PetscErrorCode GrowWithin(Grow *self, PetscReal t, Vec V[2], PetscReal *begin);
PetscErrorCode GrowSettle(Grow *self, PetscReal t);
PetscErrorCode GrowChange(Grow *self, PetscBool acts);
PetscErrorCode GrowStartOver(Grow *self);

/* grow_end.c */
PetscReal GrowBaseForce(const Observation *seen);
PetscErrorCode GrowEnd(Grow *self, PetscBool finished);
PetscErrorCode GrowFinish(Grow *self, PetscBool *again);

/* grow_changes.c */
PetscErrorCode GrowMayChange(Grow *self, const char *name, const char *value, PetscReal t);
PetscErrorCode GrowPutOption(const char *name, const char *value, char before[PETSC_MAX_PATH_LEN]);
PetscErrorCode GrowPutBack(const char *name, const char *before, PetscBool failed);
PetscErrorCode GrowApply(Grow *self, const char *name, const char *value, PetscReal t);
PetscErrorCode GrowStepOn(Grow *self, PetscReal until);
PetscErrorCode GrowTellNotReached(Grow *self);

/* grow_errors.c */
void GrowCross(Grow *self, const Observation *last, PetscReal before, PetscBool layered);
PetscBool GrowFollowsErrors(const Grow *self);
void GrowFollowErrors(Grow *self, const Observation *last, PetscBool jumped);
PetscErrorCode GrowErrors(Grow *self);

/* grow_events.c */
PetscErrorCode GrowLookForEvent(Grow *self, PetscReal t, Vec U, Event *event);
PetscErrorCode GrowLocateEvent(Grow *self, PetscReal *t, Vec U, Vec U_t);

/* grow_jam.c */
PetscBool GrowPressedHard(const Grow *self);
PetscBool GrowStalls(const Grow *self);
PetscBool GrowIsJammed(Grow *self);
PetscBool GrowSlips(Grow *self);
PetscBool GrowHeldTwice(const Grow *self);
PetscBool GrowCrawls(Grow *self);
PetscBool GrowFindsNoWay(const Grow *self);
void GrowFollowLamp(Grow *self, const Observation *last);
PetscErrorCode GrowTellLamp(const Grow *self, const char *kept);
PetscErrorCode GrowTellJam(Grow *self, PetscBool gave_up, char line[], size_t room);

/* grow_report.c */
PetscErrorCode GrowFindEnd(Grow *self);
PetscErrorCode GrowHeading(Grow *self);
PetscErrorCode GrowShared(Grow *self, PetscReal t);
PetscErrorCode GrowPaceBegin(Pace *pace);
PetscBool GrowPaceDue(Pace *pace, PetscReal start, PetscReal t, PetscReal end, PetscBool last,
                      char left[32]);
PetscErrorCode GrowProgress(Grow *self, PetscBool last);
PetscErrorCode GrowCount(const Grow *self, PetscReal counted[2]);
PetscErrorCode GrowTellEvents(const Grow *self, const char *rod);
PetscErrorCode GrowSummary(Grow *self);

/* grow_sensitivity.c */
PetscErrorCode GrowSensitivitiesCreate(Grow *self, const char *output, const char *restart);
PetscErrorCode GrowSensitivitiesDestroy(Grow *self);
PetscErrorCode GrowSensitivitiesStep(Grow *self, PetscReal t);
PetscErrorCode GrowSensitivitiesObserve(Grow *self, PetscReal t, Vec U, Vec U_t);
PetscErrorCode GrowSensitivitiesShape(Grow *self, PetscReal t, Vec U);
PetscErrorCode GrowSensitivitiesKeep(Grow *self);

#endif
