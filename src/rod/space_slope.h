/* The derivatives of a cell of a rod in space: what space_slope.c finds and space_matrix.c takes.
 */
#ifndef TENDRIL_SPACE_SLOPE_H
#define TENDRIL_SPACE_SLOPE_H

#include "rod/space_cells.h"

/* The derivatives of f at a point by its unknowns, the velocity and the spin held, and by these. */
typedef struct {
  PetscReal d1[3][4], u_p[3][4], u_m[3][3];
  PetscReal f[FIELDS][FIELDS];
  LoadSlope load;
} Slope;

/* The slopes at the three points of a cell: that of its first node is the last of the cell before.
 */
typedef struct {
  Slope a, mid, b;
} Slopes;

void SpaceKinkSlope(const Cell *cell, PetscReal by_p[4][4], PetscReal by_w[4][3]);
void SpaceCellBlocks(Cell *cell, PetscInt i, PetscBool first, const PetscReal shift[],
                     Slopes *slopes, PetscReal left[FIELDS][FIELDS],
                     PetscReal right[FIELDS][FIELDS]);
void SpaceTipBlock(const Cell *cell, const Slope *slope, const PetscReal shift[],
                   PetscReal by[RIGHT][FIELDS]);
void SpaceMidTurns(const Cell *cell, const Slope *mid, PetscReal turn[RUBS][FIELDS]);

/* space_matrix.c */
void SpaceLearnedCell(const Cell *cell, PetscInt i, const Slopes *slopes, PetscBool at_a,
                      PetscBool at_b, LearnedCell *learned);

#endif
