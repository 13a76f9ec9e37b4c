/* The model of space of a rod that touches itself: what rod/strands_space.h finds goes into the
   equations and into their derivatives. Every rank knows the whole rod and finds the same. */
#ifndef TENDRIL_SPACE_STRANDS_H
#define TENDRIL_SPACE_STRANDS_H

#include "rod/rod.h"

typedef struct _SpaceStrands *SpaceStrands;

/* Of the cell behind an owned node, in the equations of the model (rod/space.c): its length, the
   weights of its ends and its middle times that, bow times that, stretch and tangent at the middle,
   and how p' there changes with m. */
typedef struct {
  PetscReal end_weight, mid_weight, bow, g, q[3], p_m[4][3];
} SpaceCell;

PetscErrorCode SpaceStrandsCreate(Rod rod, SpaceStrands *strands);
PetscErrorCode SpaceStrandsDestroy(SpaceStrands *strands);
PetscErrorCode SpaceStrandsLoad(Rod rod, SpaceStrands self, const RodState *at,
                                const PetscReal (**force)[3], const PetscReal (**couple)[3]);
PetscErrorCode SpaceStrandsPattern(Rod rod, SpaceStrands self, PetscBool fresh, Mat J);
PetscErrorCode SpaceStrandsJacobian(Rod rod, SpaceStrands self, const RodState *at,
                                    const SpaceCell *cells, Mat J);

#endif
