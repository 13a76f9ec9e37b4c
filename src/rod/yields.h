/* What the models share of a rod whose growth feels the force along it (material/growth_yield.c).
   Beside the others it has the unknowns V and L of each node, and the equations

     V' = g e,   L' = 0,      s = 0: V = 0, of a rod that is fed y;      s = 1: L_t = V,

   with g = L, c = V - s L_t, and g e = w y, y = (1 + n.q/Pi)_+, w that of the law without force.
   along, below, is n.q. */
#ifndef TENDRIL_YIELDS_H
#define TENDRIL_YIELDS_H

#include "rod/learned.h"

/* V and L, in arrays of both. */
enum { YIELDS_V, YIELDS_L, YIELDS };

/* n.q at a node, of which these are the unknowns. */
typedef PetscReal (*YieldsAlong)(const PetscReal u[]);

/* How V, V' and g at a node change, and g in the middle of a cell beside it. */
typedef struct {
  PetscReal V, slope, g, g_mid;
} YieldsChange;

PetscReal YieldsPart(const Rod rod, PetscReal along, PetscReal *slope);
PetscReal YieldsSlope(const Rod rod, PetscReal s, PetscReal length, PetscReal along);
PetscErrorCode YieldsSee(Rod rod, PetscReal t, Vec U, YieldsAlong along);
void YieldsLaws(Rod rod, PetscReal bow, YieldsAlong along);
void YieldsResidual(Rod rod, PetscInt i, PetscReal integral);
void YieldsEnds(Rod rod, PetscInt i, PetscReal along);
void YieldsEnd(const Rod rod, const PetscReal shift[], PetscReal by[]);
void YieldsClocks(const Rod rod, PetscInt place, int e, PetscInt unknown, PetscReal h,
                  const YieldsChange *d, PetscReal clock[3][2][LEARNED_MOST]);

#endif
