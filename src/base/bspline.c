#include "base/bspline.h"

/* One step of a derivative: p/(x_{j+p} - x_j) left - p/(x_{j+p+1} - x_{j+1}) right, with left and
   right (splines k - 1 and k of degree p - 1, or derivatives of them) where they exist. */
static PetscReal Derive(PetscInt cells, const PetscReal s[], PetscInt cell, PetscInt p, PetscInt k,
                        const PetscReal *lower) {
  PetscInt j = cell - p + k;
  PetscReal d = 0;
  if (k > 0) d += p / (BSplineKnot(cells, s, j + p) - BSplineKnot(cells, s, j)) * lower[k - 1];
  if (k < p) d -= p / (BSplineKnot(cells, s, j + p + 1) - BSplineKnot(cells, s, j + 1)) * lower[k];
  return d;
}

/*
  BSplineEvaluate - all splines at one place, by de Boor's recursion.

  s     cells + 1 nodes, increasing
  at    a place in the cell
*/
void BSplineEvaluate(PetscInt cells, const PetscReal s[], PetscInt cell, PetscReal at,
                     BSplines *b) {
  b->value[0][0] = 1;
  for (PetscInt p = 1; p <= CUBIC; p++)
    for (PetscInt k = 0; k <= p; k++) {
      PetscInt j = cell - p + k; /* support: knots j .. j + p + 1 */
      PetscReal a = BSplineKnot(cells, s, j), z = BSplineKnot(cells, s, j + p + 1), N = 0;
      if (k > 0) N += (at - a) / (BSplineKnot(cells, s, j + p) - a) * b->value[p - 1][k - 1];
      if (k < p) N += (z - at) / (z - BSplineKnot(cells, s, j + 1)) * b->value[p - 1][k];
      b->value[p][k] = N;
    }
  for (PetscInt p = 1; p <= CUBIC; p++)
    for (PetscInt k = 0; k <= p; k++)
      b->slope[p][k] = Derive(cells, s, cell, p, k, b->value[p - 1]);
  for (PetscInt k = 0; k <= CUBIC; k++)
    b->curve[k] = Derive(cells, s, cell, CUBIC, k, b->slope[CUBIC - 1]);
}
