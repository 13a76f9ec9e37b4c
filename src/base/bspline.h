/* B-splines up to the third degree on the open knot vector of a mesh: its ends repeat. */
#ifndef TENDRIL_BSPLINE_H
#define TENDRIL_BSPLINE_H

#include <petscsys.h>

enum { CUBIC = 3 };

/* The splines of each degree p that are not 0 on one cell: value[p][k] and slope[p][k], k = 0 .. p,
   spline k counting from cell - p. */
typedef struct {
  PetscReal value[CUBIC + 1][CUBIC + 1], slope[CUBIC + 1][CUBIC + 1], curve[CUBIC + 1];
} BSplines;

/* Knot j. */
static inline PetscReal BSplineKnot(PetscInt cells, const PetscReal s[], PetscInt j) {
  return s[PetscMax(0, PetscMin(j, cells))];
}

void BSplineEvaluate(PetscInt cells, const PetscReal s[], PetscInt cell, PetscReal at,
                     BSplines *splines);

#endif
