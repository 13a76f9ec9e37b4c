/* A cell of a rod's centre line, whatever the model: the cubic through place and slope at both its
   ends, how that moves, and how it changes with the unknowns there. Vectors have three components;
   in the plane the third is 0. */
#ifndef TENDRIL_CURVE_CELL_H
#define TENDRIL_CURVE_CELL_H

#include "base/hermite.h"
#include "base/vectors.h"

/*
  CurveParabola - the parts that values at both ends of a cell and between them have in a place z of
  the parabola through them, and in its slope by z; either may be NULL.
*/
static inline void CurveParabola(PetscReal z, PetscReal value[3], PetscReal slope[3]) {
  if (value) {
    value[0] = (1 - z) * (1 - 2 * z);
    value[1] = 4 * z * (1 - z);
    value[2] = z * (2 * z - 1);
  }
  if (slope) {
    slope[0] = 4 * z - 3;
    slope[1] = 4 - 8 * z;
    slope[2] = 4 * z - 1;
  }
}

/* CurveSum - of the values, those of a law at the three points of a cell, by their parts. */
static inline PetscReal CurveSum(const PetscReal part[3], const PetscReal at[3]) {
  return part[0] * at[0] + part[1] * at[1] + part[2] * at[2];
}

/* CurveBetween - the parabola at z. */
static inline PetscReal CurveBetween(const PetscReal at[3], PetscReal z) {
  PetscReal part[3];
  CurveParabola(z, part, NULL);
  return CurveSum(part, at);
}

/* CurveBetweenSlope - ... and its derivative by z. */
static inline PetscReal CurveBetweenSlope(const PetscReal at[3], PetscReal z) {
  PetscReal part[3];
  CurveParabola(z, NULL, part);
  return CurveSum(part, at);
}

/*
  CurveMid - the middle of the cubic from a to b, of the slopes a', b' by the label:

    y_mid = (y_a + y_b)/2 + k (y'_a - y'_b),    k = h/8, or 0 in a formula of order 2
*/
static inline PetscReal CurveMid(PetscReal k, PetscReal a, PetscReal slope_a, PetscReal b,
                                 PetscReal slope_b) {
  return (a + b) / 2 + k * (slope_a - slope_b);
}

/* CurveMidOf - what one end gives to that, where it is summed up end by end; k is -h/8 of b. */
static inline PetscReal CurveMidOf(PetscReal k, PetscReal a, PetscReal slope_a) {
  return a / 2 + k * slope_a;
}

#endif
