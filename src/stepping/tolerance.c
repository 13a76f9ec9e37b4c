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

/*
  ToleranceFollow - goes on to what the errors of the latest state say. The same on every rank.

  rtol  the tolerance that is eased
  part  errors of each part in each of what is seen

  Errors so large that they grow no more tell no ratio. Where contact's are such, and no less than
  those of steps, coarser steps are the smaller part: behind a snap, say.
*/
void ToleranceFollow(PetscReal rtol, const PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN],
                     Ease *ease) {
  const PetscReal seen = Largest(part[ESTIMATE_TIME]), soft = Largest(part[ESTIMATE_SOFT]),
                  time = PetscMax(seen, step_rule.part_of_contact * ease->times * rtol);
  PetscReal times;

  ease->others = PetscMax(soft, step_rule.contact_forgotten * ease->others);
  times =
      PetscPowReal(step_rule.part_of_contact * ease->others / time, 1 / step_rule.tolerance_power);
  if (PetscMax(seen, soft) > step_rule.error_unknown) {
    if (ease->holds || seen > soft) return;
    times = step_rule.tolerance_rises;
  }
  ease->wants *= PetscMax(step_rule.tolerance_falls, PetscMin(step_rule.tolerance_rises, times));
  ease->wants = PetscMax(1, PetscMin(ease->most, ease->wants));
  ease->times = PetscPowReal(10, floor(step_rule.tolerance_levels * log10(ease->wants)) /
                                     step_rule.tolerance_levels);
}
