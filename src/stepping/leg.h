/* A model at work: its rod, its stepper, and the tolerances of a step. */
#ifndef TENDRIL_LEG_H
#define TENDRIL_LEG_H

#include "stepping/newton.h"
#include "stepping/vbdf.h"

/* The tolerance of steps, as it follows the estimate: see tolerance.c. */
typedef struct {
  PetscReal most;   /* so many times rtol it may be; 1: it is that */
  PetscReal wants;  /* so many times it is to be */
  PetscReal times;  /* so many times it is, one of few levels */
  PetscReal others; /* by how much contact puts the rod off */
  PetscBool holds;  /* walls and dry friction may hold it at once, as chattering forces decide */
} Ease;

/* What errors of one of its rods are measured against. */
typedef struct {
  PetscReal size[MAX_FIELDS];  /* of the fields, to which the tolerance of this step refers */
  PetscReal tried[MAX_FIELDS]; /* where its latest try has led */
  Vector2 axis;                /* along which those of this step are (rod/sizes.c) */
  PetscReal onset[MAX_FIELDS], onset_ends; /* least sizes, up to this time: see leg.c */
  PetscReal eased; /* so many times the tolerance of all is that of its own fields */
} LegMeasure;

typedef struct Leg {
  Rod rod;
  TS ts; /* its application context is the leg; of a part that of all */
  Newton newton;
  Vec U;               /* the state */
  Vec held;            /* tolerance, without turns; NULL: VBDFSetHeld() is not told */
  Vec tolerance, none; /* none: 0, the part of the tolerance relative to each entry */
  PetscReal rtol;
  Ease ease;
  LegMeasure *of;    /* of each rod */
  PetscBool turns;   /* axes follow the rod */
  PetscInt jumps;    /* so far, VBDFGetJumps(); kept by the owner */
  PetscBool passes;  /* the latest try of a step ended beyond a wall, or with the rod crossed */
  PetscBool passed;  /* ... or an earlier one of the same step, */
  PetscInt tried;    /* this one */
  PetscBool crosses; /* it was cut, or not taken, for a mode that grows faster than the step sees */
  void *owner;
  struct Leg *whole; /* of the leg of one rod of several: that of all; NULL: it is whole */
  PetscInt from;     /* its first real among those of all */
} Leg;

PetscErrorCode LegCreate(Scene scene, const RodModel *model, PetscReal rtol, Leg *leg);
PetscErrorCode LegCreateOf(Rod rod, PetscReal rtol, Leg *leg);
PetscErrorCode LegEndAtTurns(Leg *leg);
PetscErrorCode LegSpeed(Leg *leg, PetscReal *speed, PetscBool *begins);
PetscErrorCode LegDestroy(Leg *leg);

/* leg_modes.c */
PetscErrorCode LegCrossesMode(TS ts, Vec U, VBDFSight sight, PetscBool *crosses);
PetscErrorCode LegCrossesSlippery(Leg *leg, Vec U, PetscBool *crosses);
PetscErrorCode LegCrosses(Leg *leg, Vec U, PetscBool *crosses);
PetscErrorCode LegLeavesPlane(Leg *leg, Vec U, PetscReal within, PetscBool *leaves);

/* leg_part.c */
PetscErrorCode LegWithin(Leg *leg, PetscReal t, Vec U, Vec U_t, PetscBool *known);
PetscErrorCode LegInterpolate(Leg *leg, PetscReal t, PetscReal end, PetscReal h, Vec U, Vec U_t);
PetscErrorCode LegPart(Leg *whole, PetscInt k, Leg *leg);
PetscErrorCode LegPartFollow(Leg *leg);
PetscErrorCode LegPartEnd(Leg *leg);

#endif
