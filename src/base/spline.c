#include "base/spline.h"
#include "base/band.h"
#include "base/knots.h"

/*
  SplineSecondDerivatives - second derivatives at the knots of the cubic splines through many rows.

  n, x         the knots, increasing, n >= 4
  rows         how many splines; entry j of row r is f[r * row_stride + j * stride]
  f2           second derivatives in the same layout as f, allocated by the caller

  End conditions: not-a-knot (third derivative continuous across the first and last inner knot), so
  the spline is fourth order up to the ends and exact for cubics.
*/
PetscErrorCode SplineSecondDerivatives(PetscInt n, const PetscReal x[], PetscInt rows,
                                       PetscInt row_stride, PetscInt stride, const PetscReal f[],
                                       PetscReal f2[]) {
  PetscReal *b;
  Band A; /* three diagonals, and two more in the corners */

  PetscFunctionBegin;
  PetscCall(BandCreate(n, 2, 2, &A));
  PetscCall(PetscMalloc1(n, &b));
  for (PetscInt i = 1; i < n - 1; i++) {
    *BandAt(&A, i, i - 1) = (x[i] - x[i - 1]) / 6;
    *BandAt(&A, i, i) = (x[i + 1] - x[i - 1]) / 3;
    *BandAt(&A, i, i + 1) = (x[i + 1] - x[i]) / 6;
  }
  *BandAt(&A, 0, 0) = x[2] - x[1];
  *BandAt(&A, 0, 1) = x[0] - x[2];
  *BandAt(&A, 0, 2) = x[1] - x[0];
  *BandAt(&A, n - 1, n - 3) = x[n - 1] - x[n - 2];
  *BandAt(&A, n - 1, n - 2) = x[n - 3] - x[n - 1];
  *BandAt(&A, n - 1, n - 1) = x[n - 2] - x[n - 3];
  PetscCall(BandFactor(&A));
  for (PetscInt r = 0; r < rows; r++) {
    const PetscReal *y = f + r * row_stride;
    b[0] = b[n - 1] = 0;
    for (PetscInt i = 1; i < n - 1; i++)
      b[i] = (y[(i + 1) * stride] - y[i * stride]) / (x[i + 1] - x[i]) -
             (y[i * stride] - y[(i - 1) * stride]) / (x[i] - x[i - 1]);
    PetscCall(BandSolve(&A, PETSC_FALSE, 1, b));
    for (PetscInt i = 0; i < n; i++) f2[r * row_stride + i * stride] = b[i];
  }
  PetscCall(BandDestroy(&A));
  PetscCall(PetscFree(b));
  PetscFunctionReturn(0);
}

/*
  SplineWeights - the weights of f_i, f_{i+1}, f2_i, f2_{i+1} in the spline's value, slope and
  integral from x_i at a point; i is the knot left of it. Outside the knots the end cubics go on.
  Any of the three may be NULL.
*/
void SplineWeights(PetscInt n, const PetscReal x[], PetscReal at, PetscInt *i, PetscReal value[4],
                   PetscReal slope[4], PetscReal integral[4]) {
  const PetscInt lo = KnotBefore(n, x, at);
  PetscReal h, a, b;

  *i = lo;
  h = x[lo + 1] - x[lo];
  b = (at - x[lo]) / h;
  a = 1 - b;
  if (value) {
    value[0] = a, value[1] = b;
    value[2] = (a * a * a - a) * h * h / 6, value[3] = (b * b * b - b) * h * h / 6;
  }
  if (slope) {
    slope[0] = -1 / h, slope[1] = 1 / h;
    slope[2] = -(3 * a * a - 1) * h / 6, slope[3] = (3 * b * b - 1) * h / 6;
  }
  if (integral) {
    integral[0] = h * (1 - a * a) / 2, integral[1] = h * b * b / 2;
    integral[2] = h * h * h / 6 * ((1 - a * a * a * a) / 4 - (1 - a * a) / 2);
    integral[3] = h * h * h / 6 * (b * b * b * b / 4 - b * b / 2);
  }
}

/* SplineSteepest - the least length, in entries that begin before an end, over which values above 0
   change by as much as they are; none is as long as PETSC_MAX_REAL. */
PetscReal SplineSteepest(PetscInt n, const PetscReal x[], const PetscReal f[], PetscReal end) {
  PetscReal least = PETSC_MAX_REAL;

  for (PetscInt i = 0; i + 1 < n && x[i] < end; i++) {
    const PetscReal change = PetscAbsReal(f[i + 1] - f[i]), size = PetscMax(f[i], f[i + 1]);
    if (change > 0) least = PetscMin(least, (x[i + 1] - x[i]) * size / change);
  }
  return least;
}
