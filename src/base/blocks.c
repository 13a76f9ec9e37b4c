#include "base/blocks.h"

struct _Blocks {
  int dims;
  PetscInt n;
  PetscInt *item; /* as they stand in the leaves, from left to right; of a line NULL: in order */
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

/* A line whose tree is made. */
typedef struct {
  PetscInt stride;
  const PetscReal *x, *angle;
  const PetscInt *of;
} Line;

/* The block of a branch of a line: its leaves follow each other as they are, and need no sorting.
 */
static Block Along(Blocks self, const Line *line, Branch b) {
  Block all;

  if (b.last - b.first == 1 && line->of && line->of[b.first] != line->of[b.last])
    all = BlockEmpty(3);
  else if (b.last - b.first == 1)
    for (int d = 0; d < 3; d++) {
      const PetscReal *x = d < self->dims ? line->x + d : line->angle;
      const PetscReal from = x ? x[b.first * line->stride] : 0;
      const PetscReal to = x ? x[b.last * line->stride] : 0;
      all.low[d] = PetscMin(from, to);
      all.high[d] = PetscMax(from, to);
    }
  else {
    const Block half[2] = {Along(self, line, BranchHalf(b, 0)),
                           Along(self, line, BranchHalf(b, 1))};
    for (int d = 0; d < 3; d++) {
      all.low[d] = PetscMin(half[0].low[d], half[1].low[d]);
      all.high[d] = PetscMax(half[0].high[d], half[1].high[d]);
    }
  }
  return self->block[b.k] = all;
}

/*
  BlocksOfLine - the tree over the segments of a polygon of segments + 1 points, for BlocksPairs().
  Not collective; the caller destroys it with BlocksDestroy().

  x      dims coordinates of point i at x[i * stride]
  angle  in the plane, of point i at angle[i * stride]: the third side of each block; or NULL
  of     several lines, one behind the other: that of each point, between two of which there is no
         segment; NULL: it is one
*/
PetscErrorCode BlocksOfLine(int dims, PetscInt segments, PetscInt stride, const PetscReal *x,
                            const PetscReal *angle, const PetscInt *of, Blocks *blocks) {
  const Line line = {stride, x, angle, of};
  PetscInt size = 1;

  PetscFunctionBegin;
  PetscCall(PetscNew(blocks));
  (*blocks)->dims = dims;
  (*blocks)->n = segments;
  while (size < segments) size *= 2;
  PetscCall(PetscMalloc1(2 * size, &(*blocks)->block));
  (void)Along(*blocks, &line, (Branch){0, segments, 0});
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

/* ---- pairs of a line ---- */

/* A search for pairs. */
typedef struct {
  const struct _Blocks *tree;
  PetscReal reach;
  BlocksSkip skip;
  BlocksMeetPair meet;
  void *ctx;
} PairSearch;

/* Pairs of a segment of a and one of b; a is b, or lies before it. */
static void Pairs(const PairSearch *search, Branch a, Branch b) {
  const Block *of_a = &search->tree->block[a.k], *of_b = &search->tree->block[b.k];
  PetscInt in_a = a.last - a.first, in_b = b.last - b.first;

  for (int d = 0; d < search->tree->dims; d++)
    if (of_a->low[d] > of_b->high[d] + search->reach ||
        of_b->low[d] > of_a->high[d] + search->reach)
      return;
  if (search->skip && search->skip(of_a, a.first, a.last, of_b, b.first, b.last, search->ctx))
    return;
  if (in_a == 1 && in_b == 1) {
    if (a.k != b.k) search->meet(a.first, b.first, search->ctx);
  } else if (a.k == b.k) {
    Pairs(search, BranchHalf(a, 0), BranchHalf(a, 0));
    Pairs(search, BranchHalf(a, 1), BranchHalf(a, 1));
    Pairs(search, BranchHalf(a, 0), BranchHalf(a, 1));
  } else if (in_a >= in_b) {
    for (int w = 0; w < 2; w++) Pairs(search, BranchHalf(a, w), b);
  } else
    for (int w = 0; w < 2; w++) Pairs(search, a, BranchHalf(b, w));
}

/*
  BlocksPairs - tells of all pairs of segments of a line whose blocks are within reach of each
  other, and of some more.

  skip   leaves out two blocks and all in them, or NULL
*/
void BlocksPairs(Blocks line, PetscReal reach, BlocksSkip skip, BlocksMeetPair meet, void *ctx) {
  PairSearch search = {line, reach, skip, meet, ctx};
  Branch all = {0, line->n, 0};

  Pairs(&search, all, all);
}
