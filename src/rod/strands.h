/* Strands: the rod touches itself. Samples of it look for the nearest places of other strands on
   its smooth curve. With W a sample's share of the rod's length, halved because both strands look,

     E = sum_i W_i U(gamma_i),   gamma = |x_i - x(foot)| - D,   foot: (x_i - x(foot)).x' = 0,

   and the forces are those of this energy: p W n on the sample, the opposite on the foot, each
   handed to points of the rod (curve/spread.h). So they cancel, in force and moment, and do no work
   in a circle. Friction acts likewise, against the velocity at which the strands slip by each other
   (strand_friction.c); in space it bears couples about the tangents, too.

   Of several rods each looks at the others as at itself, all in the laboratory's frame, with

     gamma = |x_i - x(foot)| - (D_a + D_b)/2,   1/k = (1/k_a + 1/k_b)/2,

   and what is asked and told of a rod is in its own frame, that of its clamp. What a pair has,
   energy, loss, counts for the rod that the sample is of.

   What differs is the sampling. In the plane samples are the collocation points (nodes and middles
   of cells, docs/theory/cells.md), each with one foot at most on either side. In space they are
   spread evenly over each cell, close enough for strands that cross, and each has a foot on every
   other strand. */
#ifndef TENDRIL_STRANDS_H
#define TENDRIL_STRANDS_H

#include "scene/scene.h"

typedef struct _Strands *Strands;

/* How two of several rods meet: can they touch? Their friction, below 0: the mean of both rods'; k
   if it is given, 0: it follows from both. */
typedef struct {
  PetscBool touch;
  PetscReal friction, stiffness;
} StrandMeeting;
typedef PetscErrorCode (*StrandsMeet)(void *ctx, PetscInt a, PetscInt b, StrandMeeting *how);

/* The state of the whole rod, or of several, one behind the other: of node i, at u[i * stride], its
   place and what turns it (x1, x2, theta in the plane; x and the quaternion in space); rates
   likewise, or NULL. */
typedef struct {
  PetscReal t;
  PetscInt stride;
  PetscInt between; /* reals between the place and what turns it: 0, but of nodes in the plane */
  const PetscReal *u, *u_t;
} StrandState;

/* Of these at a node, and of both nodes of two cells: at most, as in space. */
enum { STRAND_NODE = 7, STRAND_UNKNOWNS = 4 * STRAND_NODE, STRAND_TAKERS = 8 };
typedef PetscReal StrandBy[3][STRAND_UNKNOWNS];

/* One contact: it depends on the unknowns of nodes a and b of two cells, that of the sample and
   that of the foot; the points that take its force: n' = -load of point k changes by `by` times
   them. */
typedef struct {
  PetscInt cell[2]; /* of the sample, of the foot */
  PetscInt takers;
  PetscInt taker[STRAND_TAKERS]; /* points: node i is 2 i, the middle behind it 2 i + 1; the force
                                    on the tip is 2 cells + 1 */
  StrandBy by[STRAND_TAKERS];
  PetscBool couples; /* there are: m' changes likewise */
  StrandBy couple_by[STRAND_TAKERS];
} StrandSlope;

/* Two cells that are near to touching. */
typedef struct {
  PetscInt sample, foot;
} CellPair;

/* What all contacts amount to. */
typedef struct {
  PetscReal energy, loss; /* int U, power lost to friction */
  PetscReal normal;       /* sum of normal forces */
  PetscReal clamp[3];     /* what the clamp of a rod that is fed in bears of them */
  PetscReal sum[3];       /* of all forces, with that: 0; of several rods what others do to it */
  PetscReal moved;        /* power that it has from other rods: of all together 0 */
  PetscReal strain;       /* power of material that is laid down where it is pressed, and of a law
                             that changes in time */
  PetscReal nearest;      /* the smallest gap, if any is small */
  PetscReal at[2], x[3];  /* the labels where it is, and the place between them, */
  PetscInt rod;           /* the rod that the second label is on */
  PetscReal gives;        /* how far contact that is not rigid may put its tip off */
  PetscInt zones;         /* stretches of the rod that touch what lies farther along it */
} StrandSum;

/* A zone where two rods touch: which, the labels of its middle on them, the force on the first, in
   the laboratory, and the smallest gap. */
typedef struct {
  PetscInt rod[2];
  PetscReal s[2], force[3], gap;
} StrandPlace;

PetscErrorCode StrandsCreate(Scene scene, Strands *strands);
PetscErrorCode StrandsCreateSeveral(PetscInt n, const Scene scene[], StrandsMeet meet, void *ctx,
                                    Strands *strands);
PetscErrorCode StrandsJoin(Strands strands, const PetscInt rod[2], const PetscInt node[2]);
PetscErrorCode StrandsDestroy(Strands *strands);
PetscErrorCode StrandsSearch(Strands strands, const StrandState *state);
PetscErrorCode StrandsLoad(Strands strands, const StrandState *state);
const PetscReal (*StrandsForces(Strands strands))[3];
const PetscReal (*StrandsCouples(Strands strands))[3];
PetscErrorCode StrandsLinearise(Strands strands, const StrandState *state, const PetscReal shift[],
                                PetscBool fresh, PetscInt *n, StrandSlope **slopes);
PetscErrorCode StrandsHold(Strands strands, PetscReal seen, PetscReal *creep);
void StrandsSum(Strands strands, PetscInt rod, StrandSum *sum);
PetscErrorCode StrandsPlaces(Strands strands, PetscInt *n, StrandPlace **places);
PetscInt StrandsFirst(Strands strands, PetscInt rod);
PetscInt StrandsRod(Strands strands, PetscInt node);
PetscInt StrandsDuals(Strands strands, FrictionDual **duals);
PetscErrorCode StrandsNear(Strands strands, PetscInt *n, CellPair **cells);

#endif
