/* Passing: has the rod gone through a wall from one state to the next? What is asked is where its
   curve is, the cubic of each cell, and what that has swept: nodes may step over what is thin. */
#ifndef TENDRIL_PASSING_H
#define TENDRIL_PASSING_H

#include "rod/feet.h"
#include "rod/rod.h"

PetscErrorCode RodPassesWalls(Rod rod, PetscReal t0, PetscReal t1, Vec U0, Vec U1,
                              PetscBool *passes);

/* The cells of a rank in two states, with the times of these: what walls are asked about. */
typedef struct {
  PetscReal t0;
  PetscInt n;
  FootCell *before, *now;
} Passing;

/* passing_plane.c, passing_space.c: has the rod passed through a wall? Collective. */
PetscErrorCode PassingTellPlane(Rod rod, const Passing *passing, PetscBool *passes);
PetscErrorCode PassingTellSpace(Rod rod, const Passing *passing, PetscBool *passes);
PetscErrorCode RodRefuseFeet(Rod rod, PetscReal t, PetscBool crowded);
PetscErrorCode RodFootCells(Rod rod, PetscReal t, Vec U, PetscInt n, FootCell cell[]);

#endif
