/* How a run depends on the numbers of its scene: the derivatives of its states, carried along with
   them (forward sensitivities). */
#ifndef TENDRIL_TANGENT_H
#define TENDRIL_TANGENT_H

#include "stepping/leg.h"

/* A number p of the scene, by two rods of the run's model in scenes that differ from the run's by p
   alone: low and high, by apart. Borrowed. */
typedef struct {
  Rod low, high;
  PetscReal apart;
} TangentOf;

typedef struct _Tangents *Tangents;

PetscErrorCode TangentsCreate(Leg *leg, PetscInt n, const TangentOf of[], Tangents *tangents);
PetscErrorCode TangentsDestroy(Tangents *tangents);
PetscErrorCode TangentsBegin(Tangents tangents);
PetscErrorCode TangentsStep(Tangents tangents, PetscReal t);
PetscErrorCode TangentsAt(Tangents tangents, PetscInt k, PetscReal t, Vec S, Vec S_t);
PetscBool TangentsLost(Tangents tangents);

#endif
