/* A model at work: its rod, its stepper, and the tolerances of a step. */
#ifndef TENDRIL_LEG_H
#define TENDRIL_LEG_H

#include "stepping/newton.h"

/* The tolerance of steps, as it follows the estimate: see tolerance.c. */
typedef struct {
  PetscReal most;   /* so many times rtol it may be; 1: it is that */
  PetscReal wants;  /* so many times it is to be */
  PetscReal times;  /* so many times it is, one of few levels */
  PetscReal others; /* by how much contact puts the rod off */
} Ease;

typedef struct {
  Rod rod;
  TS ts; /* its application context is the leg */
  Newton newton;
  Vec U;               /* the state */
  Vec tolerance, none; /* none: 0, the part of the tolerance relative to each entry */
  PetscReal rtol;
  Ease ease;
  PetscReal size[MAX_FIELDS]; /* of the fields, to which the tolerance of this step refers */
  PetscBool turns;            /* along axes that follow the rod (rod/sizes.c) */
  PetscReal axes[2];          /* those of this step */
  PetscReal kick[MAX_FIELDS], kick_ends; /* least sizes, up to this time: see leg.c */
  PetscInt jumps, blind;                 /* so far, VBDFGetJumps(); kept by the owner */
  PetscBool passes;  /* the latest try of a step ended beyond a wall, or with the rod crossed */
  PetscBool crosses; /* it was cut, or not taken, for a mode that grows faster than the step sees */
  PetscBool spins;   /* in a snap that was followed the rod turned about itself, held by nothing */
  PetscInt nested;   /* Newton iterations of snaps that were followed, or tried, so far */
  PetscReal speed;   /* of a snap, at its latest step */
  PetscReal turning; /* likewise, about itself, if nothing holds it */
  int interrupted;   /* the signal that came while a snap was followed; 0: none */
  void *owner;
} Leg;

PetscErrorCode LegCreate(Scene scene, const RodModel *model, PetscReal rtol, const char *prefix,
                         Leg *leg);
PetscErrorCode LegEndAtTurns(Leg *leg);
PetscErrorCode LegDestroy(Leg *leg);
PetscErrorCode LegIterations(const Leg *leg, PetscInt *iterations);
PetscErrorCode LegCrosses(Leg *leg, Vec U, PetscBool *crosses);
PetscErrorCode LegLeavesPlane(Leg *leg, Vec U, PetscReal within, PetscBool *leaves);
PetscErrorCode LegInterpolate(Leg *leg, PetscReal t, PetscReal end, PetscReal h, Vec U, Vec U_t);

#endif
