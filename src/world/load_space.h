/* The load on a rod in space: what the world exerts per length at a place, a direction, a velocity
   and a spin, with its derivatives. The world is load.h's; its vectors are in the clamp's frame.

   A rod that slides at v and spins at omega about its tangent q in an even grip rubs at W = (v, r
   omega), r the radius at which friction feels the spin:

     F = N M f - weight,  M = q q^T + a (I - q q^T),      couple about q:  N r f_spin,
     f = phi(|W|) W  (friction.h). */
#ifndef TENDRIL_LOAD_SPACE_H
#define TENDRIL_LOAD_SPACE_H

#include "world/load.h"

enum { SPIN = 3, RUBS = 4 }; /* the components of W */

typedef struct {
  PetscReal t, x[3], q[3]; /* time, position, tangent */
  PetscReal W[RUBS];       /* velocity of the material, and r omega */
} Place3;

/* The derivatives of the force and, last, of the couple: by W, q and x. */
typedef struct {
  PetscReal W[RUBS][RUBS], q[3][3], x[RUBS][3];
} LoadSlope3;

void LoadForce3(const Load *load, const Place3 *at, const FrictionDual4 *dual, PetscReal f[RUBS]);
void LoadLinearise3(const Load *load, const Place3 *at, PetscBool fresh, FrictionDual4 *dual,
                    LoadSlope3 *slope);
void LoadSeen3(const Load *load, const Place3 *at, PetscReal f[RUBS]);
PetscBool LoadInSpace(const Load *load);

#endif
