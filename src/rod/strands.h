/* Strands: the rod touches itself. Every collocation point (nodes and middles of cells,
   docs/theory/cells.md) looks for the nearest place of another strand on the smooth curve of the
   rod, at most one on either side. With W its share of the rod's length, twice halved because both
   strands look,

     E = sum_i W_i U(gamma_i),   gamma = |x_i - x(foot)| - D,   foot: (x_i - x(foot)).x' = 0,

   and the forces are those of this energy: p W n on the point, the opposite on the foot, handed to
   the four points around it. So they cancel, and do no work in a circle. Friction acts likewise, on
   point and foot, against their relative velocity. */
#ifndef TENDRIL_STRANDS_H
#define TENDRIL_STRANDS_H

#include "scene/scene.h"

typedef struct _Strands *Strands;

/* The state of the rod at its nodes: unknowns and rates as the frame model has them. */
typedef struct {
  PetscReal t;
  PetscInt stride;          /* from node to node */
  const PetscReal *u, *u_t; /* x1, x2, theta of node i at u[i * stride]; rates likewise */
} StrandState;

enum { STRAND_UNKNOWNS = 12, STRAND_TAKERS = 6 };

/* One contact: the unknowns it depends on are x1, x2, theta of nodes a and b of two cells, that of
   the point and that of the foot; the points that take its force: n' = -load of point k changes by
   `by` times them. */
typedef struct {
  PetscInt cell[2]; /* of the point, of the foot */
  PetscInt takers;
  PetscInt taker[STRAND_TAKERS]; /* points: node i is 2 i, the middle behind it 2 i + 1; the force
                                    on the tip is 2 cells + 1 */
  PetscReal by[STRAND_TAKERS][2][STRAND_UNKNOWNS];
} StrandSlope;

/* What all contacts amount to. */
typedef struct {
  PetscReal energy, loss; /* int U, power lost to friction */
  PetscReal normal;       /* sum of normal forces */
  PetscReal clamp[2];     /* what the clamp of a rod that is fed in bears of them */
  PetscReal sum[2];       /* of all forces, with that: 0 */
  PetscReal strain;       /* power of material that is laid down where it is pressed, and of a law
                             that changes in time */
  PetscReal nearest;      /* the smallest gap, if any is small */
  PetscReal at[2], x[2];  /* the labels where it is, and the place between them */
} StrandSum;

PetscErrorCode StrandsCreate(Scene scene, Strands *strands);
PetscErrorCode StrandsDestroy(Strands *strands);
PetscErrorCode StrandsSearch(Strands strands, const StrandState *state);
PetscErrorCode StrandsLoad(Strands strands, const StrandState *state);
const PetscReal (*StrandsForces(Strands strands))[2];
PetscErrorCode StrandsLinearise(Strands strands, const StrandState *state, const PetscReal shift[3],
                                PetscBool fresh, PetscInt *n, const StrandSlope **slopes);
PetscErrorCode StrandsHold(Strands strands, PetscReal seen, PetscReal *creep);
void StrandsSum(Strands strands, StrandSum *sum);
PetscInt StrandsZones(Strands strands);
PetscInt StrandsDuals(Strands strands, FrictionDual **duals);
PetscErrorCode StrandsNear(Strands strands, PetscInt *n, PetscInt (**cells)[2]);

#endif
