/* The tolerance of steps follows the estimate: where a rod touches, mesh and contact put it off by
   what no step can mend, and steps that are right to a thousandth of that are wasted. */
#include "stepping/tolerance.h"

/* Errors of steps are to be that part of those of mesh and contact, and go with this power of the
   tolerance (tasks/accuracy.c). */
static const PetscReal part_of_others = 0.3, power = 6. / 7;
/* It is not eased by more from one step to the next, up and down: errors swing, and those that are
   to come of a tolerance are not seen yet when it changes. What others there were is forgotten as
   slowly, for errors pass through 0. */
static const PetscReal rises = 1.15, falls = 0.9, forgets = 0.95;
/* Errors as large as that grow no more (estimate.c): which of them is the largest is not known. */
static const PetscReal too_large = 0.02;

/* The largest of a part's errors in what is seen. */
static PetscReal Largest(const PetscReal error[ESTIMATE_SEEN]) {
  PetscReal most = 0;

  for (int k = 0; k < ESTIMATE_SEEN; k++) most = PetscMax(most, error[k]);
  return most;
}

/*
  ToleranceFollow - goes on to what the errors of the latest state say. The same on every rank.

  ease  of the tolerance: from 1 times what it would be otherwise on
  part  errors of each part in each of what is seen
*/
void ToleranceFollow(Ease *ease, const PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN]) {
  const PetscReal time = Largest(part[ESTIMATE_TIME]),
                  others = Largest(part[ESTIMATE_SPACE]) + Largest(part[ESTIMATE_SOFT]);
  PetscReal times = rises;

  ease->others = PetscMax(others, forgets * ease->others);
  if (PetscMax(time, others) > too_large) return;
  if (time > 0) times = PetscPowReal(part_of_others * ease->others / time, 1 / power);
  ease->times *= PetscMax(falls, PetscMin(rises, times));
  ease->times = PetscMax(1, PetscMin(ease->most, ease->times));
}
