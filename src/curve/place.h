/* A place on the rod, as laws are told of it: which piece of the material is there, where it is,
   how it is turned and how it moves. Vectors are in the clamp's frame; in the plane x3 is 0, and
   the last axis e3. */
#ifndef TENDRIL_CURVE_PLACE_H
#define TENDRIL_CURVE_PLACE_H

#include "base/plane.h"

/* Components of what rubs, at most: a velocity and, times a radius, a spin; and which that is. */
enum { RUBS = 4, SPIN = 3 };

typedef struct {
  PetscReal s, t;              /* label and time */
  PetscReal from_base, to_tip; /* lengths of rod on both sides, where a law asks: ScenePlace() */
  PetscReal x[3], axes[3][3];  /* position; tangent, and the two axes across */
  PetscReal v[RUBS];           /* velocity of the material, and in space Load.arm times its spin */
} Place;

/* PlaceTurn2 - the axes of a place in the plane, of its tangent. */
static inline void PlaceTurn2(Vector2 q, Place *at) {
  Put2(q, at->axes[0]);
  Put2(Left2(q), at->axes[1]);
  at->axes[2][2] = 1;
}

#endif
