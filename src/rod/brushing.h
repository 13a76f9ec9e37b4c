/* Brushing: has a rod touched a wall on its way from one state to the next, and left it again? What
   is in touch neither before nor now was pushed by nothing, and no error sees that. */
#ifndef TENDRIL_BRUSHING_H
#define TENDRIL_BRUSHING_H

#include "rod/rod.h"

/* What may have been brushed, and where. */
typedef struct {
  PetscBool any;
  char *node; /* of each owned node: may it have brushed a wall? */
  char *wall; /* of each wall of the plane and surface: it is in touch before or now */
} Brush;

PetscErrorCode BrushBegin(Rod rod, PetscReal t0, PetscReal t1, Vec U0, Vec U1, Brush *brush);
PetscErrorCode BrushDepth(Rod rod, PetscReal t, Vec U, const Brush *brush, PetscReal *depth);
PetscErrorCode BrushEnd(Brush *brush);

#endif
