/* A binary tree over blocks in space that stand still: finds those near a point without looking at
   all of them (in the plane: rects.h). */
#ifndef TENDRIL_BLOCKS_H
#define TENDRIL_BLOCKS_H

#include <petscsys.h>

typedef struct {
  PetscReal low[3], high[3];
} Block;

typedef struct _Blocks *Blocks;

/* Told of a block that is within reach; returns how far the search is to reach from now on. */
typedef PetscReal (*BlocksMeet)(PetscInt item, PetscReal reach, void *ctx);

PetscErrorCode BlocksCreate(PetscInt n, const Block block[], Blocks *blocks);
PetscErrorCode BlocksDestroy(Blocks *blocks);
void BlocksNear(Blocks blocks, const PetscReal x[3], PetscReal reach, BlocksMeet meet, void *ctx);

/* A block that holds nothing yet. */
static inline Block BlockEmpty(void) {
  const PetscReal far = PETSC_MAX_REAL;
  return (Block){{far, far, far}, {-far, -far, -far}};
}

/* Makes it hold a point, too. */
static inline void BlockHold(Block *block, const PetscReal x[3]) {
  for (int d = 0; d < 3; d++) {
    block->low[d] = PetscMin(block->low[d], x[d]);
    block->high[d] = PetscMax(block->high[d], x[d]);
  }
}

/* How far a point is from it; 0: within. */
static inline PetscReal BlockApart(const Block *block, const PetscReal x[3]) {
  PetscReal sum = 0;
  for (int d = 0; d < 3; d++) {
    PetscReal o = PetscMax(0, PetscMax(block->low[d] - x[d], x[d] - block->high[d]));
    sum += o * o;
  }
  return PetscSqrtReal(sum);
}

#endif
