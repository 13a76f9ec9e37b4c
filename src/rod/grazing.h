/* Grazing: has a rod touched a wall on its way from one state to the next, and left it again? What
   is in touch neither before nor now was pushed by nothing, and no error sees that. */
#ifndef TENDRIL_GRAZING_H
#define TENDRIL_GRAZING_H

#include "rod/rod.h"

/* What may have been grazed, and where. */
typedef struct {
  PetscBool any;
  char *node; /* of each owned node: may it have grazed a wall? */
  char *wall; /* of each wall of the plane and surface: it is in touch before or now */
} Graze;

PetscErrorCode GrazeBegin(Rod rod, PetscReal t0, PetscReal t1, Vec U0, Vec U1, Graze *graze);
PetscErrorCode GrazeDepth(Rod rod, PetscReal t, Vec U, const Graze *graze, PetscReal *depth);
PetscErrorCode GrazeEnd(Graze *graze);

#endif
