#include "base/root.h"

enum { MOST_STEPS = 200, PATIENCE = 8 };

/* From here on a value is as good as minus infinity, and says nothing of where the root is. */
static const PetscReal bottomless = -1e300;

/* Two places that follow each other closely are at the root if the straight line from the other end
   says so, too: if it is not farther than this part of the place. (A scaled end draws places to the
   other.) */
static const PetscReal near = 1e-6;

/* What a stale end's value is scaled by: f now, of the side that moves, before it was f_old. */
static PetscReal Scaled(PetscReal f, PetscReal f_old) {
  return f / f_old < 1 ? 1 - f / f_old : 0.5;
}

/*
  RootFind - a root in [a, b] by false position, the stale end's value scaled down (Anderson and
  Bjoerck); by halves where f(a) is not finite, and where so many steps do not halve what is left.

  fa, fb     f(a) < 0 <= f(b), known already
  precision  of the root, as a part of it
  root       the place that was asked for last, or b where none was

  Collective if the function is.
*/
PetscErrorCode RootFind(RootFunction function, void *ctx, PetscReal a, PetscReal fa, PetscReal b,
                        PetscReal fb, PetscReal precision, PetscReal *root) {
  PetscReal f = 0, t = b, end[2] = {fa, fb}, width = b - a; /* end: fa and fb as they are */

  PetscFunctionBegin;
  for (int k = 0; k < MOST_STEPS && fb != 0; k++) {
    const PetscReal old = t;
    const PetscBool slow = (PetscBool)(k > 0 && k % PATIENCE == 0 && b - a > width / 2);
    if (k % PATIENCE == 0) width = b - a;
    t = fa > bottomless && !slow ? (a * fb - b * fa) / (fb - fa) : (a + b) / 2;
    if (!(t > a && t < b)) t = (a + b) / 2;
    PetscCall(function(ctx, t, &f));
    if (f == 0 ||
        (PetscAbsReal(t - old) <= precision * PetscAbsReal(t) &&
         PetscAbsReal(f * (f < 0 ? b - t : t - a) / (f - end[f < 0])) <= near * PetscAbsReal(t)))
      break;
    if (f < 0) { /* b is stale if it was kept before too */
      if (fb > 0 && fa > bottomless && old <= a) fb *= Scaled(f, fa);
      a = t;
      fa = end[0] = f;
    } else {
      if (old >= b && fa > bottomless) fa *= Scaled(f, fb);
      b = t;
      fb = end[1] = f;
    }
    if (b - a <= precision * PetscAbsReal(b)) break;
  }
  *root = t;
  PetscFunctionReturn(0);
}
