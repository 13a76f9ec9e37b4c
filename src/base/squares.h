/* What stands still in the plane, found by squares: of each square that is looked from it is kept
   which items of trees (blocks.h) are within reach of it, so that a place looks at a few of them
   and searches no tree. */
#ifndef TENDRIL_SQUARES_H
#define TENDRIL_SQUARES_H

#include "base/blocks.h"

typedef struct _Squares *Squares;

PetscErrorCode SquaresCreate(PetscReal size, PetscInt n, const Blocks trees[],
                             const PetscReal reach[], Squares *squares);
PetscErrorCode SquaresDestroy(Squares *squares);
const int *SquaresAt(Squares squares, const PetscReal x[2]);
PetscReal SquaresReach(Squares squares, PetscInt tree);

/* The next list behind one. */
static inline const int *SquaresNext(const int *list) {
  return list + *list + 1;
}

#endif
