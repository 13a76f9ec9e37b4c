/* The place of a rod's curve that is nearest to another place: cell and 0 <= z <= 1 in it. */
#ifndef TENDRIL_NEAREST_H
#define TENDRIL_NEAREST_H

#include <petscsys.h>

/* Iterations to the nearest place, and the change of z at which it is found. */
enum { CURVE_MOST = 40 };
static const PetscReal curve_enough = 1e-14;

typedef enum { CURVE_ARRIVED, CURVE_ON, CURVE_NEXT } CurveWay;

/*
  CurveStep - a step of Newton's method on f = (x - y(z)).y_z = 0, the place y of the curve that is
  nearest to x: not over more than a cell, nor towards a place that is farthest.

  square  y_z.y_z      bend  (x - y).y_zz
*/
static inline PetscReal CurveStep(PetscReal f, PetscReal square, PetscReal bend) {
  return PetscMax(-1, PetscMin(1, f / PetscMax(square - bend, 0.2 * square)));
}

/* CurveGo - takes a place z of a cell on to the place "to", beyond 0 or 1 in the cell beside it.
   Whether it was there already (it is then left), has stayed in its cell, or is in the next one;
   ends: it was there already, at an end of the rod, beyond which "to" is. */
static inline CurveWay CurveGo(PetscInt cells, PetscReal to, PetscInt *cell, PetscReal *z,
                               PetscBool *ends) {
  CurveWay way = CURVE_ON;

  if ((to < 0 && *cell == 0) || (to > 1 && *cell == cells - 1)) {
    to = to < 0 ? 0 : 1;
    *ends = (PetscBool)(*z == to);
    if (*ends) return CURVE_ARRIVED;
  } else if (to < 0 || to > 1) {
    *cell += to < 0 ? -1 : 1;
    to = to < 0 ? PetscMax(0, 1 + to) : PetscMin(1, to - 1);
    way = CURVE_NEXT;
  } else if (PetscAbsReal(to - *z) < curve_enough)
    return CURVE_ARRIVED;
  *z = to;
  return way;
}

/* CurveWeights - the parts of the rod's labels that its points (nodes and mids, alternating) stand
   for, by Simpson's rule; weight: 2 cells + 1, 0 on entry. */
static inline void CurveWeights(PetscInt cells, const PetscReal s[], PetscReal weight[]) {
  for (PetscInt i = 0; i < cells; i++) {
    PetscReal h = s[i + 1] - s[i];
    weight[2 * i] += h / 6;
    weight[2 * i + 1] += 4 * h / 6;
    weight[2 * i + 2] += h / 6;
  }
}

#endif
