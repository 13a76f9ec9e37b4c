/* A binary tree over blocks in the plane or in space, which finds those near a place without
   looking at all of them: over any that stand still, sorted; or over the segments of a line in
   their order, of which it finds the pairs that are near each other. */
#ifndef TENDRIL_BLOCKS_H
#define TENDRIL_BLOCKS_H

#include <petscsys.h>

/* From low to high; in the plane the third is of no account. */
typedef struct {
  PetscReal low[3], high[3];
} Block;

typedef struct _Blocks *Blocks;

/* Told of a block that is within reach; returns how far the search is to reach from now on. */
typedef PetscReal (*BlocksMeet)(PetscInt item, PetscReal reach, void *ctx);

/* Told of segments first .. last - 1 of each of two blocks of a line: may they be left out? */
typedef PetscBool (*BlocksSkip)(const Block *a, PetscInt first_a, PetscInt last_a, const Block *b,
                                PetscInt first_b, PetscInt last_b, void *ctx);
/* Told of two segments i < j. */
typedef void (*BlocksMeetPair)(PetscInt i, PetscInt j, void *ctx);

PetscErrorCode BlocksCreate(int dims, PetscInt n, const Block block[], Blocks *blocks);
PetscErrorCode BlocksOfLine(int dims, PetscInt segments, PetscInt stride, const PetscReal *x,
                            const PetscReal *angle, const PetscInt *of, Blocks *line);
PetscErrorCode BlocksDestroy(Blocks *blocks);
void BlocksNearBehind(Blocks blocks, PetscInt before, const Block *place, PetscReal reach,
                      BlocksMeet meet, void *ctx);
void BlocksNear(Blocks blocks, const Block *place, PetscReal reach, BlocksMeet meet, void *ctx);
void BlocksPairs(Blocks line, PetscReal reach, BlocksSkip skip, BlocksMeetPair meet, void *ctx);

/* A block that holds nothing yet. */
static inline Block BlockEmpty(int dims) {
  Block block = {{0}, {0}};
  for (int d = 0; d < dims; d++) {
    block.low[d] = PETSC_MAX_REAL;
    block.high[d] = -PETSC_MAX_REAL;
  }
  return block;
}

/* One that is a point. */
static inline Block BlockAt(int dims, const PetscReal x[]) {
  Block block = {{0}, {0}};
  for (int d = 0; d < dims; d++) block.low[d] = block.high[d] = x[d];
  return block;
}

/* Makes it hold a point, too. */
static inline void BlockHold(int dims, Block *block, const PetscReal x[]) {
  for (int d = 0; d < dims; d++) {
    block->low[d] = PetscMin(block->low[d], x[d]);
    block->high[d] = PetscMax(block->high[d], x[d]);
  }
}

/* A block of a binary tree, with the leaves it holds. */
typedef struct {
  PetscInt first, last, k;
} Branch;

static inline Branch BranchHalf(Branch b, int which) {
  PetscInt mid = (b.first + b.last) / 2;
  if (which) return (Branch){mid, b.last, 2 * b.k + 2};
  return (Branch){b.first, mid, 2 * b.k + 1};
}

#endif
