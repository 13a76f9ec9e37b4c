#include "base/blocks.h"

struct _Blocks {
  int dims;
  PetscInt n;
  PetscInt *item; /* as they stand in the leaves, from left to right */
  Block *block;   /* the children of block k are 2 k + 1 and 2 k + 2 */
};

static int LongestSide(int dims, const Block *block) {
  int longest = 0;
  for (int d = 1; d < dims; d++)
    if (block->high[d] - block->low[d] > block->high[longest] - block->low[longest]) longest = d;
  return longest;
}

/* Divides the items of a branch along the longest side of its block, by their middles. */
static PetscErrorCode Build(Blocks self, const Block block[], PetscReal key[], Branch b) {
  Block *all = &self->block[b.k];
  int d;

  PetscFunctionBegin;
  *all = BlockEmpty(self->dims);
  for (PetscInt i = b.first; i < b.last; i++) {
    BlockHold(self->dims, all, block[self->item[i]].low);
    BlockHold(self->dims, all, block[self->item[i]].high);
  }
  if (b.last - b.first == 1) PetscFunctionReturn(0);
  d = LongestSide(self->dims, all);
  for (PetscInt i = b.first; i < b.last; i++)
    key[i] = block[self->item[i]].low[d] + block[self->item[i]].high[d];
  PetscCall(PetscSortRealWithArrayInt(b.last - b.first, key + b.first, self->item + b.first));
  for (int w = 0; w < 2; w++) PetscCall(Build(self, block, key, BranchHalf(b, w)));
  PetscFunctionReturn(0);
}

/* BlocksCreate - the tree over n blocks of 2 or 3 dimensions, which are not needed any more
   afterwards; n may be 0. Not collective; the caller destroys it with BlocksDestroy(). */
PetscErrorCode BlocksCreate(int dims, PetscInt n, const Block block[], Blocks *blocks) {
  PetscInt size = 1;
  PetscReal *key;

  PetscFunctionBegin;
  PetscCall(PetscNew(blocks));
  (*blocks)->dims = dims;
  (*blocks)->n = n;
  if (!n) PetscFunctionReturn(0);
  while (size < n) size *= 2;
  PetscCall(PetscMalloc1(2 * size, &(*blocks)->block));
  PetscCall(PetscMalloc1(n, &(*blocks)->item));
  for (PetscInt i = 0; i < n; i++) (*blocks)->item[i] = i;
  PetscCall(PetscMalloc1(n, &key));
  PetscCall(Build(*blocks, block, key, (Branch){0, n, 0}));
  PetscCall(PetscFree(key));
  PetscFunctionReturn(0);
}

PetscErrorCode BlocksDestroy(Blocks *blocks) {
  PetscFunctionBegin;
  if (!*blocks) PetscFunctionReturn(0);
  PetscCall(PetscFree((*blocks)->block));
  PetscCall(PetscFree((*blocks)->item));
  PetscCall(PetscFree(*blocks));
  PetscFunctionReturn(0);
}

/* How far two blocks are from each other; 0: they meet. One that is farther than the reach is only
   known to be so. */
static inline PetscReal Apart(int dims, const Block *a, const Block *b, PetscReal reach) {
  PetscReal sum = 0, most = 0;

  for (int d = 0; d < dims; d++) {
    const PetscReal o = PetscMax(0, PetscMax(a->low[d] - b->high[d], b->low[d] - a->high[d]));
    sum += o * o;
    most = PetscMax(most, o);
  }
  if (most > reach || sum == most * most) return most; /* a square may overflow */
  return PetscSqrtReal(sum);
}

enum { DEEP = 64 }; /* more than a tree of PetscInt has levels */

/* The search from the root on: of two halves the nearer first, the other waits. (The dimensions are
   a constant where it is called: most of the time goes into Apart().) */
static inline void Search(int dims, const struct _Blocks *self, const Block *place, PetscReal reach,
                          BlocksMeet meet, void *ctx) {
  Branch waits[DEEP], b = {0, self->n, 0};
  PetscReal away[DEEP], apart = Apart(dims, &self->block[0], place, reach);
  int n = 0;

  for (;;) {
    if (apart <= reach && b.last - b.first > 1) {
      const Branch left = BranchHalf(b, 0), right = BranchHalf(b, 1);
      const PetscReal by_left = Apart(dims, &self->block[left.k], place, reach);
      const PetscReal by_right = Apart(dims, &self->block[right.k], place, reach);
      const PetscBool swap = (PetscBool)(by_right < by_left);
      b = swap ? right : left;
      apart = swap ? by_right : by_left;
      waits[n] = swap ? left : right;
      away[n] = swap ? by_left : by_right;
      if (away[n] <= reach) n++;
      continue;
    }
    if (apart <= reach) reach = meet(self->item[b.first], reach, ctx);
    if (!n) return;
    b = waits[--n];
    apart = away[n];
  }
}

/*
  BlocksNear - tells of all blocks within reach of a place, in no particular order.

  place  a block of the same dimensions, BlockAt() that of a point
  meet   may lessen the reach as it learns more: so the nearest is found
*/
void BlocksNear(Blocks blocks, const Block *place, PetscReal reach, BlocksMeet meet, void *ctx) {
  if (!blocks->n) return;
  if (blocks->dims == 2)
    Search(2, blocks, place, reach, meet, ctx);
  else
    Search(3, blocks, place, reach, meet, ctx);
}

/* A search of which items are counted behind others. */
typedef struct {
  PetscInt before;
  BlocksMeet meet;
  void *ctx;
} Behind;

static PetscReal MeetBehind(PetscInt item, PetscReal reach, void *ctx) {
  const Behind *behind = (const Behind *)ctx;
  return behind->meet(behind->before + item, reach, behind->ctx);
}

/* BlocksNearBehind - as BlocksNear(), where item k is told as before + k: behind others. */
void BlocksNearBehind(Blocks blocks, PetscInt before, const Block *place, PetscReal reach,
                      BlocksMeet meet, void *ctx) {
  Behind behind = {before, meet, ctx};

  BlocksNear(blocks, place, reach, MeetBehind, &behind);
}
