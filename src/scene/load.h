/* The load density: what the world exerts on the rod per length, at a place and a velocity. Models
   ask it alone; no one else knows of what terms it is made. Its sign is that of the equation
   n' = g F: F is what the rod overcomes. */
#ifndef TENDRIL_LOAD_H
#define TENDRIL_LOAD_H

#include "scene/friction.h"

typedef struct {
  Friction friction;
} Load;

/* Where on the rod, and how fast. */
typedef struct {
  PetscReal s, t, x[2], q[2], v[2]; /* label, time, position, tangent, velocity of the material */
} Place;

typedef FrictionDual LoadDual; /* what Newton's method remembers of a place */

PetscErrorCode LoadSetFromOptions(Load *load);

/* F */
static inline void LoadForce(const Load *load, const Place *at, const LoadDual *dual,
                             PetscReal f[2]) {
  FrictionForce(&load->friction, at->v, dual, f);
}

/* The slope dF/dv for Newton's method, the dual brought up to the present velocity first; fresh: a
   Newton solve begins. */
static inline void LoadLinearise(const Load *load, const Place *at, PetscBool fresh, LoadDual *dual,
                                 PetscReal slope[2][2]) {
  if (fresh)
    FrictionDualReset(&load->friction, at->v, dual);
  else
    FrictionDualAdvance(&load->friction, at->v, dual);
  FrictionLinearise(&load->friction, at->v, dual, slope);
}

/* Does a place stick or slide, without anything between (exact Coulomb friction)? */
static inline PetscBool LoadSticks(const Load *load) {
  return (PetscBool)(load->friction.beta == 0);
}

/* Moves what holds a sticking place; returns how much its force would change if it moved on so. */
static inline PetscReal LoadHold(const Load *load, const Place *at, LoadDual *dual) {
  return FrictionDualHold(&load->friction, at->v, dual);
}

/* The drag F/v where F is along v, of the velocity v. */
static inline PetscReal LoadDrag(const Load *load, const PetscReal v[2]) {
  return FrictionPhi(&load->friction, v[0] * v[0] + v[1] * v[1]);
}

/* The drag on the straight rod, which moves along itself at this speed. */
static inline PetscReal LoadAxialDrag(const Load *load, PetscReal speed) {
  return FrictionPhi(&load->friction, speed * speed);
}

/* The axial load on a piece of straight rod of unit length, whose speed rises evenly from a to b,
   times b - a. */
static inline PetscReal LoadAxialBetween(const Load *load, PetscReal a, PetscReal b) {
  return FrictionBetween(&load->friction, a, b);
}

PetscErrorCode LoadInFastTime(const Load *load, Load *fast, PetscBool *dry);

#endif
