/* Knots: where in a row of increasing places another lies. */
#ifndef TENDRIL_KNOTS_H
#define TENDRIL_KNOTS_H

#include <petscsys.h>

/* KnotBefore - the last of n places x, but for the one at the end, that is not behind `at`; 0 where
   all are. */
static inline PetscInt KnotBefore(PetscInt n, const PetscReal x[], PetscReal at) {
  const PetscReal even = (at - x[0]) / (x[n - 1] - x[0]) * (PetscReal)(n - 1);
  PetscInt low = 0, high = n - 1;

  if (even >= 0 && even < (PetscReal)(n - 1)) { /* most tables have even rows: at once */
    const PetscInt k = (PetscInt)even;
    PetscInt step = 1;
    if (k + 1 < n && x[k] <= at && at < x[k + 1]) return k;
    if (x[k] <= at) { /* others are near there, as a rule */
      for (low = k; low + step < n - 1 && x[low + step] <= at; step *= 2) low += step;
      high = PetscMin(n - 1, low + step);
    } else {
      for (high = k; high - step > 0 && x[high - step] > at; step *= 2) high -= step;
      low = PetscMax(0, high - step);
    }
  }

  while (high - low > 1) {
    const PetscInt mid = (low + high) / 2;
    if (x[mid] > at)
      high = mid;
    else
      low = mid;
  }
  return low;
}

/* KnotBehind - the first of n places x that is behind `at`; n if none is. */
static inline PetscInt KnotBehind(PetscInt n, const PetscReal x[], PetscReal at) {
  PetscInt low = 0, high = n;

  while (low < high) {
    const PetscInt mid = (low + high) / 2;
    if (x[mid] > at)
      high = mid;
    else
      low = mid + 1;
  }
  return low;
}

#endif
