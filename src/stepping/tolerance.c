/* The tolerance of steps follows the estimate: where a rod touches, contact that is not rigid puts
   it off by what no step can mend, and steps that are right to a thousandth of that are wasted. */
#include "stepping/tolerance.h"
#include "stepping/rules.h"

/* The largest of a part's errors in what is seen. */
static PetscReal Largest(const PetscReal error[ESTIMATE_SEEN]) {
  PetscReal most = 0;

  for (int k = 0; k < ESTIMATE_SEEN; k++) most = PetscMax(most, error[k]);
  return most;
}

/* What steps put the rod off by was made by those of some tolerance: of what comes to it, or was the
   first of it, by that of now. */
static void Weigh(PetscReal seen, Ease *ease) {
  const PetscReal before = PetscMin(ease->seen, seen);

  ease->made = seen > 0 ? (before * ease->made + (seen - before) * ease->times) / seen : ease->times;
  ease->seen = seen;
}

/*
  ToleranceFollow - goes on to what the errors of the latest state say. The same on every rank.

  rtol  the tolerance that is eased
  part  errors of each part in each of what is seen

  Steps of rtol times m have put the rod off by e; it is to be a part of what contact does, c. Errors
  go with a power of the tolerance, so m (part c/e)^(1/power) would have done that. Steps of now make
  no error of before less: only what the tolerance was then can tell what it is to be.
*/
void ToleranceFollow(PetscReal rtol, const PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN],
                     Ease *ease) {
  const PetscReal seen = Largest(part[ESTIMATE_TIME]), soft = Largest(part[ESTIMATE_SOFT]);
  PetscReal least, to;

  ease->others = PetscMax(soft, step_rule.contact_forgotten * ease->others);
  Weigh(seen, ease);
  const PetscBool unknown = (PetscBool)(PetscMax(seen, soft) > step_rule.error_unknown);
  if (unknown && soft < seen) return;
  least = PetscMax(seen, step_rule.part_of_contact * ease->made * rtol);
  to = ease->made * PetscPowReal(step_rule.part_of_contact * ease->others / least, 1 / step_rule.tolerance_power);
  if (unknown) to = ease->most;
  ease->wants *= PetscMax(step_rule.tolerance_falls,
                          PetscMin(step_rule.tolerance_rises, to / ease->wants));
  ease->wants = PetscMax(1, PetscMin(ease->most, ease->wants));
  ease->times = PetscPowReal(10, floor(step_rule.tolerance_levels * log10(ease->wants)) /
                                     step_rule.tolerance_levels);
}
