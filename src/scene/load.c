#include "scene/load.h"

/* LoadSetFromOptions - reads and checks the options of all terms. Collective. */
PetscErrorCode LoadSetFromOptions(Load *load) {
  PetscFunctionBegin;
  PetscCall(FrictionSetFromOptions(&load->friction));
  PetscFunctionReturn(0);
}

static const PetscReal nearly_dry = 1e-4; /* 1 - mu up to here: growth waits meanwhile */
/* It must rest a little below the limit of friction, or it would snap again at once. */
static const PetscReal slack = 1e-5;
static const PetscReal tiny_beta = 1e-18; /* of velocities in fast time, which begin near 1 */

/* LoadInFastTime - the load in the fast time of a snap (stepping/snap.c): dry friction as it is,
   but for a little slack, and viscous friction of strength 1 beside it. dry: false if this load is
   not dry, so that nothing snaps. */
PetscErrorCode LoadInFastTime(const Load *load, Load *fast, PetscBool *dry) {
  Friction *friction = &fast->friction;

  PetscFunctionBegin;
  *dry = (PetscBool)(1 - load->friction.mu <= nearly_dry);
  *fast = *load;
  friction->beta = tiny_beta;
  friction->mu *= 1 - slack;
  friction->more = friction->mu; /* 1 - mu + more = 1 */
  PetscFunctionReturn(0);
}
