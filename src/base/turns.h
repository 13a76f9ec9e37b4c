/* What is given in time by rows of a table: at which of them it sets out, stops or turns back.
   Between two of these it goes one way only; so steps that end there cannot leave out that it came
   and went. */
#ifndef TENDRIL_TURNS_H
#define TENDRIL_TURNS_H

#include "base/knots.h"

static inline int TurnsSign(PetscReal x) {
  return (x > 0) - (x < 0);
}

/* TurnsMark - marks the rows of n at which the differences of neighbours change their sign: all are
   0 before the first row and behind the last. Rows that are marked stay so.

   f, stride  values, of which row k has f[k * stride] */
static inline void TurnsMark(PetscInt n, const PetscReal f[], PetscInt stride, PetscBool at[]) {
  int before = 0, behind;

  for (PetscInt k = 0; k < n; k++, before = behind) {
    behind = k + 1 < n ? TurnsSign(f[(k + 1) * stride] - f[k * stride]) : 0;
    if (behind != before) at[k] = PETSC_TRUE;
  }
}

/* TurnsNext - the first time behind `after` at which a row is marked, PETSC_MAX_REAL if none is. */
static inline PetscReal TurnsNext(PetscInt n, const PetscReal t[], const PetscBool at[],
                                  PetscReal after) {
  PetscInt row = KnotBehind(n, t, after);

  while (row < n && !at[row]) row++;
  return row < n ? t[row] : PETSC_MAX_REAL;
}

#endif
