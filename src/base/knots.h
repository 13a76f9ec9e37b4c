/* Knots: the cell of a row of increasing places in which another lies. */
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
    if (k + 1 < n && x[k] <= at && at < x[k + 1]) return k;
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

#endif
