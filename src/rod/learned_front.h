/* The front in a rod that is fed and learns (learned_front.c). */
#ifndef TENDRIL_LEARNED_FRONT_H
#define TENDRIL_LEARNED_FRONT_H

#include "rod/learned_parts.h"

/* What places have learned, on both sides of the front. */
typedef struct {
  PetscInt per, places, behind; /* places that what has come in is at: 0 .. behind - 1 */
  const PetscReal *label, *all, *inflow;
  PetscReal at;                       /* the front's label */
  PetscReal front[2 * TROPISM_BENDS]; /* ... and what there is at it */
} LearnedSides;

void LearnedFrontFind(const Rod rod, PetscReal t, const PetscReal *label, const PetscReal *all,
                      const PetscReal *inflow, LearnedSides *sides);
void LearnedFrontStates(const LearnedSides *sides, PetscReal at, PetscReal k[]);

void LearnedFrontTurns(const LearnedSides *sides, LearnedCorner *corner);

#endif
