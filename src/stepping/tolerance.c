/* The tolerance of steps follows the estimate: where a rod touches, contact that is not rigid puts
   it off by what no step can mend, and steps that are right to a thousandth of that are wasted. */
#include "stepping/tolerance.h"

/* Errors of steps are to be that part of what contact puts the rod off by, and go with this power
   of the tolerance (tasks/accuracy.c). They are taken for no less than that part of it, however
   small they seem: what is not seen, forces, say, is off by as much. */
static const PetscReal part_of_contact = 0.3, power = 6. / 7;
/* It is not eased by more from one step to the next, up and down: errors swing, and those that are
   to come of a tolerance are not seen yet when it changes. What contact had put the rod off by is
   forgotten as slowly, for errors pass through 0. */
static const PetscReal rises = 1.15, falls = 0.9, forgets = 0.95;
/* The tolerance has that many levels in each factor of 10: errors that differ by round-off, on
   other numbers of ranks, are to give the same steps. */
enum { LEVELS = 4 };
/* Errors as large as that grow no more (estimate.c): which of them is the largest is not known. */
static const PetscReal too_large = 0.002;

/* The largest of a part's errors in what is seen. */
static PetscReal Largest(const PetscReal error[ESTIMATE_SEEN]) {
  PetscReal most = 0;

  for (int k = 0; k < ESTIMATE_SEEN; k++) most = PetscMax(most, error[k]);
  return most;
}

/*
  ToleranceFollow - goes on to what the errors of the latest state say. The same on every rank.

  rtol  the tolerance that is eased
  part  errors of each part in each of what is seen
*/
void ToleranceFollow(PetscReal rtol, const PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN],
                     Ease *ease) {
  const PetscReal seen = Largest(part[ESTIMATE_TIME]), soft = Largest(part[ESTIMATE_SOFT]),
                  time = PetscMax(seen, part_of_contact * ease->times * rtol);
  PetscReal times;

  ease->others = PetscMax(soft, forgets * ease->others);
  if (PetscMax(seen, soft) > too_large) return;
  times = PetscPowReal(part_of_contact * ease->others / time, 1 / power);
  ease->wants *= PetscMax(falls, PetscMin(rises, times));
  ease->wants = PetscMax(1, PetscMin(ease->most, ease->wants));
  ease->times = PetscPowReal(10, floor(LEVELS * log10(ease->wants)) / LEVELS);
}
