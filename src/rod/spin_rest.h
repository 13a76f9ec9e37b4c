/* How a rod in space whose spin nothing holds back turns about its own tangent, where the curve
   that it lies on is given. */
#ifndef TENDRIL_SPIN_REST_H
#define TENDRIL_SPIN_REST_H

#include <petscsys.h>

/* At a place on the curve: label, stretch, stiffnesses, natural twist and bends, and those that it
   has, per length. */
typedef struct {
  PetscReal s, g, S[3], u0[3], u[3];
} SpinPlace;

PetscErrorCode SpinRest(PetscInt n, const SpinPlace place[], PetscReal torque, PetscBool held,
                        PetscReal turn[]);
void SpinTurn(const SpinPlace *place, PetscReal turn, PetscReal slope, PetscReal u[3]);

#endif
