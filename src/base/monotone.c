#include "base/monotone.h"
#include "base/hermite.h"
#include "base/knots.h"

/* The slope at an end, of the parabola through three entries, whose distances are h and whose
   differences over them are d; within what keeps the curve monotone. */
static PetscReal EndSlope(const PetscReal h[2], const PetscReal d[2]) {
  const PetscReal slope = ((2 * h[0] + h[1]) * d[0] - h[0] * d[1]) / (h[0] + h[1]);

  if (slope * d[0] <= 0) return 0;
  if (d[0] * d[1] <= 0 && PetscAbsReal(slope) > 3 * PetscAbsReal(d[0])) return 3 * d[0];
  return slope;
}

/*
  MonotoneSlopes - the slopes at the entries.

  n, x, f  the entries, x increasing, n >= 2
  slope    n, the caller's
*/
void MonotoneSlopes(PetscInt n, const PetscReal x[], const PetscReal f[], PetscReal slope[]) {
  PetscReal h[2], d[2];

  if (n == 2) {
    slope[0] = slope[1] = (f[1] - f[0]) / (x[1] - x[0]);
    return;
  }
  for (PetscInt i = 1; i + 1 < n; i++) {
    for (int k = 0; k < 2; k++) {
      h[k] = x[i + k] - x[i + k - 1];
      d[k] = (f[i + k] - f[i + k - 1]) / h[k];
    }
    slope[i] = d[0] * d[1] <= 0
                   ? 0
                   : 3 * (h[0] + h[1]) / ((2 * h[1] + h[0]) / d[0] + (h[1] + 2 * h[0]) / d[1]);
    if (i == 1) slope[0] = EndSlope(h, d);
    if (i + 2 == n) slope[n - 1] = EndSlope((PetscReal[]){h[1], h[0]}, (PetscReal[]){d[1], d[0]});
  }
}

/* MonotoneValue - the curve's value at a place; beyond the ends those of the ends. */
PetscReal MonotoneValue(PetscInt n, const PetscReal x[], const PetscReal f[],
                        const PetscReal slope[], PetscReal at) {
  PetscReal w[4], w1[4], w2[4], h;
  PetscInt lo;

  if (at <= x[0]) return f[0];
  if (at >= x[n - 1]) return f[n - 1];
  lo = KnotBefore(n, x, at);
  h = x[lo + 1] - x[lo];
  Hermite((at - x[lo]) / h, w, w1, w2);
  return w[0] * f[lo] + w[1] * h * slope[lo] + w[2] * f[lo + 1] + w[3] * h * slope[lo + 1];
}

/* MonotoneRate - its slope at a place; 0 beyond the ends. */
PetscReal MonotoneRate(PetscInt n, const PetscReal x[], const PetscReal f[],
                       const PetscReal slope[], PetscReal at) {
  PetscReal w[4], w1[4], w2[4], h;
  PetscInt lo;

  if (at < x[0] || at > x[n - 1]) return 0;
  lo = KnotBefore(n, x, at);
  h = x[lo + 1] - x[lo];
  Hermite((at - x[lo]) / h, w, w1, w2);
  return (w1[0] * f[lo] + w1[2] * f[lo + 1]) / h + w1[1] * slope[lo] + w1[3] * slope[lo + 1];
}
