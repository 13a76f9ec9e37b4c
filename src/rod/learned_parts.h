/* What the files of learned.h share: where its states are, and products of the mechanics'
   unknowns. */
#ifndef TENDRIL_LEARNED_PARTS_H
#define TENDRIL_LEARNED_PARTS_H

#include "base/clones.h"
#include "rod/learned.h"
#include <string.h>

PetscErrorCode LearnedPart(Rod rod, Vec V, PetscReal *mech, PetscReal *w, PetscReal *states);
PetscErrorCode LearnedPut(Rod rod, const PetscReal *mech, const PetscReal *states, Vec V);
PetscErrorCode LearnedFromLastRank(const Rod rod, PetscReal signal[]);
LearnedKind LearnedKindOf(const Rod rod);
PetscErrorCode LearnedShareSignal(Rod rod, const PetscReal *states, PetscReal signal[]);

/* The place where the last node has the tip's own signal. */
static inline PetscInt LearnedSignalPlace(const Rod rod) {
  return 2 * (rod->last - rod->first + 1) + 1;
}

/* Is a place that where material comes in? */
static inline PetscBool LearnedIsBorn(const Rod rod, PetscInt place) {
  return (PetscBool)(rod->learned->born && place == 2);
}

/* Is an equation of a cell a row of the node behind it? V's is. */
ALWAYS_INLINE PetscBool LearnedIsBefore(const Rod rod, PetscInt row) {
  const struct Learned_ *self = rod->learned;

  return (PetscBool)(row < rod->model->halves[0] || (self->extra && row == self->lead));
}

/* y += s x, of the mechanics' unknowns. */
ALWAYS_INLINE void LearnedAdd(PetscInt n, PetscReal s, const PetscReal x[], PetscReal y[]) {
  for (PetscInt f = 0; f < n; f++) y[f] += s * x[f];
}

ALWAYS_INLINE PetscReal LearnedTimes(PetscInt n, const PetscReal x[], const PetscReal y[]) {
  PetscReal sum = 0;

  for (PetscInt f = 0; f < n; f++) sum += x[f] * y[f];
  return sum;
}

#endif
