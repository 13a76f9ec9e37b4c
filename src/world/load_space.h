/* The load on a rod in space: what the world exerts per length at a place, a direction, a velocity
   and a spin, with its derivatives. The world is load.h's; its vectors are in the clamp's frame.

   A rod that slides at v and spins at omega about its tangent q in an even grip rubs at W = (v, r
   omega), r the radius at which friction feels the spin:

     F = N M f - weight,  M = q q^T + a (I - q q^T),      couple about q:  N r f_spin,
     f = phi(|W|) W  (friction.h).

   Walls that press on the rod take their force and couple off these (contact_space.h). Where the
   friction along the rod does not feel the spin, but that of walls does, r is half of the diameter.
 */
#ifndef TENDRIL_LOAD_SPACE_H
#define TENDRIL_LOAD_SPACE_H

#include "world/contact_space.h"
#include "world/load.h"

/* The derivatives of the force and, last, of the couple: by W, q and x. */
typedef struct {
  PetscReal W[RUBS][RUBS], q[RUBS][3], x[RUBS][3];
} LoadSlope3;

void LoadSetArm(Load *load);

void LoadForce3(const Load *load, const Place *at, const FrictionDual4 *dual, PetscReal f[RUBS]);
void LoadLinearise3(const Load *load, const Place *at, PetscBool fresh, FrictionDual4 *dual,
                    LoadSlope3 *slope);
PetscReal LoadHold3(const Load *load, const Place *at, PetscReal seen, FrictionDual4 dual[]);
void LoadParts3(const Load *load, const Place *at, const FrictionDual4 *dual, PetscReal friction[3],
                PetscReal walls[3], PetscReal *moved);
void LoadSeen3(const Load *load, const Place *at, PetscReal f[RUBS]);
PetscBool LoadInSpace(const Load *load);

/* Do force and couple depend on place and direction? */
static inline PetscBool LoadPlaced(const Load *load) {
  return (PetscBool)(load->varied || load->walls);
}

/* What walls see of a place. */
static inline Rubbed LoadRubbed(const Load *load, const Place *at) {
  return (Rubbed){at->x, at->q, at->v, load->arm > 0 ? at->v[SPIN] / load->arm : 0};
}

#endif
