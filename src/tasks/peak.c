#include "tasks/peak.h"

enum { MOST_LOOKS = 40 };

/* Can what peaks between three places come up to 0? Not if it would have to rise there by more
   than it falls to both sides. (A peak rises by a quarter of that, where it is a parabola.) */
static PetscBool Possible(const PeakPlace at[3]) {
  const PetscReal falls = at[1].level - PetscMin(at[0].level, at[2].level);
  return (PetscBool)(at[1].level >= at[0].level && at[1].level >= at[2].level &&
                     at[1].level + falls >= 0 && falls > 0);
}

/* Where the parabola through them has its peak; well within, and not too near to the middle. */
static PetscReal Guess(const PeakPlace at[3]) {
  const PetscReal a = at[1].t - at[0].t, b = at[2].t - at[1].t,
                  up = (at[1].level - at[0].level) / a, down = (at[2].level - at[1].level) / b,
                  bend = (down - up) / (a + b), larger = PetscMax(a, b),
                  off = bend < 0 ? -(up * b + down * a) / (2 * bend * (a + b)) : 0;

  if (!(PetscAbsReal(off) > 0.02 * larger) || off >= b || -off >= a)
    return at[1].t + (b > a ? b : -a) / 2;
  return at[1].t + off;
}

/*
  PeakFind - looks for a place between three at which a level is not below 0, as it is at all of
  them.

  above    is there one?
  across   then a place below 0, and one that is not, behind it
*/
PetscErrorCode PeakFind(PeakLevel level, void *of, const PeakPlace at[3], PeakPlace across[2],
                        PetscBool *above) {
  PeakPlace by[3] = {at[0], at[1], at[2]}, here;

  PetscFunctionBegin;
  *above = PETSC_FALSE;
  for (int k = 0; k < MOST_LOOKS && Possible(by); k++) {
    PetscBool late;
    here.t = Guess(by);
    if (!(here.t > by[0].t && here.t < by[2].t) || here.t == by[1].t) break;
    PetscCall(level(of, here.t, &here.level));
    late = (PetscBool)(here.t > by[1].t);
    if (here.level >= 0) {
      across[0] = by[late ? 1 : 0];
      across[1] = here;
      *above = PETSC_TRUE;
      break;
    }
    if (here.level > by[1].level) {
      by[late ? 0 : 2] = by[1];
      by[1] = here;
    } else
      by[late ? 2 : 0] = here;
  }
  PetscFunctionReturn(0);
}
