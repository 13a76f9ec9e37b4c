/* What contact amounts to on a rod that is known node by node: what is measured of it, stored and
   watched for. On one rank. */
#ifndef TENDRIL_TOUCHING_H
#define TENDRIL_TOUCHING_H

#include "rod/feet.h"
#include "rod/rod.h"
#include "rod/strands.h"
#include "record/sample_space.h"

typedef struct {
  PetscReal energy, loss, strain; /* int U, power lost to friction, power of growth where pressed
                                     and of a law that changes in time */
  PetscReal moved;                /* power of walls that move, */
  PetscReal given;                /* and of other rods */
  PetscReal normal, wall[3];      /* sum of normal forces; force of the walls on the rod */
  PetscInt zones;
  PetscReal tip[PUSH]; /* force of contact on the tip */
  PetscReal clamp[3];  /* force of strands on the clamp of a rod that is fed in */
  PetscReal nearest;   /* the smallest gap */
  PetscReal at[2];     /* labels of where it is; the second is that of the other strand, or -1 */
  PetscReal x[3];      /* and the place, of the centre line; in the plane the third are 0 */
} TouchSum;

/* What feet add to n', in space and to m', at the points of one cell alone. */
typedef struct {
  PetscInt cell;
  FootLoad load;
} TouchFeet;

/* TouchNearest - takes note of a gap at a label, if it is the smallest so far. */
static inline void TouchNearest(TouchSum *sum, PetscReal gap, PetscReal s, const PetscReal x[3]) {
  if (gap >= sum->nearest) return;
  sum->nearest = gap;
  sum->at[0] = s;
  sum->at[1] = -1;
  for (int d = 0; d < 3; d++) sum->x[d] = x[d];
}

/* A point that is looked at: the length of rod that it stands for, and what comes to that in a unit
   of time. */
typedef struct {
  Rubbed at;
  PetscReal s, length, length_t;
  PetscBool tip;
} WallSpot;

typedef struct _Touching *Touching;

/* What strands do to a rod: in all, and at its points (rod/strands.h). */
typedef struct {
  StrandSum sum;
  const PetscReal (*force)[3], (*couple)[3]; /* borrowed */
} StrandsOn;

/* Who knows all of several rods tells of one what strands do to it at a time; moves: rates are
   known. */
typedef PetscErrorCode (*TouchingTell)(void *ctx, PetscInt rod, PetscReal t, PetscBool moves,
                                       StrandsOn *on);

PetscErrorCode TouchingCreate(Scene scene, Touching *touching);
PetscErrorCode TouchingDestroy(Touching *touching);
void TouchingAmong(Touching touching, TouchingTell tell, void *ctx, PetscInt rod);
/* What is asked of a look: all; or powers alone, of a state beside the one that was looked at last:
   not what is nearest, how deep, and where. */
typedef enum { TOUCHING_ALL, TOUCHING_POWERS } TouchingAsks;

PetscErrorCode TouchingLook(Touching touching, PetscReal t, const Node *nodes, PetscBool moves,
                            TouchingAsks asks, TouchSum *sum, const PetscReal (**force)[PUSH]);
PetscInt TouchingFeet(Touching touching, const TouchFeet **feet);
const SampleLaw *TouchingLaws(Touching touching);
PetscErrorCode TouchingCell(Touching touching, PetscInt i, const FootCell *cell, TouchSum *sum,
                            PetscBool *touches, const PetscReal (**load)[FOOT_LOAD]);
PetscBool TouchingWalls(int dims, const Contact *contact, const WallSpot *spot, PetscReal bound,
                        PetscReal force[PUSH], TouchSum *sum);
PetscErrorCode TouchingWalls3(Touching touching, Scene scene, PetscReal t, const Node *nodes,
                              PetscBool moves, PetscInt likely, const SampleLaw law[],
                              PetscReal (*force)[PUSH], TouchSum *sum);
PetscErrorCode TouchingShow(Touching touching, PetscReal t, const Node *nodes);

#endif
