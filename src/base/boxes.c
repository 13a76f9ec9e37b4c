#include "base/boxes.h"

struct _Boxes {
  PetscInt segments, stride;
  int dimensions;
  const PetscReal *x, *angle; /* of point i at i * stride */
  Block *box;                 /* the children of box k are 2 k + 1 and 2 k + 2 */
};

/* One search. */
typedef struct {
  const struct _Boxes *tree;
  PetscReal reach;
  BoxesSkip skip;
  BoxesMeet meet;
  void *ctx;
} Search;

static Block Build(Boxes self, Branch branch) {
  Block box, half[2];

  if (branch.last - branch.first == 1) {
    for (int d = 0; d < 3; d++) {
      const PetscReal *x = d < self->dimensions ? self->x + d : self->angle;
      PetscReal a = x ? x[branch.first * self->stride] : 0,
                b = x ? x[branch.last * self->stride] : 0;
      box.low[d] = PetscMin(a, b);
      box.high[d] = PetscMax(a, b);
    }
  } else {
    for (int w = 0; w < 2; w++) half[w] = Build(self, BranchHalf(branch, w));
    for (int d = 0; d < 3; d++) {
      box.low[d] = PetscMin(half[0].low[d], half[1].low[d]);
      box.high[d] = PetscMax(half[0].high[d], half[1].high[d]);
    }
  }
  return self->box[branch.k] = box;
}

static PetscErrorCode Create(PetscInt segments, int dimensions, PetscInt stride, const PetscReal *x,
                             const PetscReal *angle, Boxes *boxes) {
  PetscInt size = 1;

  PetscFunctionBegin;
  PetscCall(PetscNew(boxes));
  (*boxes)->segments = segments;
  (*boxes)->dimensions = dimensions;
  (*boxes)->stride = stride;
  (*boxes)->x = x;
  (*boxes)->angle = angle;
  while (size < segments) size *= 2;
  PetscCall(PetscMalloc1(2 * size, &(*boxes)->box));
  (void)Build(*boxes, (Branch){0, segments, 0});
  PetscFunctionReturn(0);
}

/*
  BoxesCreate - the tree over a polygon of segments + 1 points. Not collective; the caller destroys
  it with BoxesDestroy().

  x       two coordinates of point i at x[i * stride]; borrowed
  angle   of point i at angle[i * stride], borrowed; or NULL
*/
PetscErrorCode BoxesCreate(PetscInt segments, PetscInt stride, const PetscReal *x,
                           const PetscReal *angle, Boxes *boxes) {
  return Create(segments, 2, stride, x, angle, boxes);
}

/* BoxesCreate3 - as BoxesCreate(), of points of three coordinates. */
PetscErrorCode BoxesCreate3(PetscInt segments, PetscInt stride, const PetscReal *x, Boxes *boxes) {
  return Create(segments, 3, stride, x, NULL, boxes);
}

PetscErrorCode BoxesDestroy(Boxes *boxes) {
  PetscFunctionBegin;
  if (!*boxes) PetscFunctionReturn(0);
  PetscCall(PetscFree((*boxes)->box));
  PetscCall(PetscFree(*boxes));
  PetscFunctionReturn(0);
}

/* Pairs of a segment of a and one of b; a is b, or lies before it. */
static void Pairs(const Search *search, Branch a, Branch b) {
  const Block *box_a = &search->tree->box[a.k], *box_b = &search->tree->box[b.k];
  PetscInt in_a = a.last - a.first, in_b = b.last - b.first;

  for (int d = 0; d < search->tree->dimensions; d++)
    if (box_a->low[d] > box_b->high[d] + search->reach ||
        box_b->low[d] > box_a->high[d] + search->reach)
      return;
  if (search->skip && search->skip(box_a, a.first, a.last, box_b, b.first, b.last, search->ctx))
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
  BoxesPairs - tells of all pairs of segments whose boxes are within reach of each other, and of
  some more.

  skip   leaves out two boxes and all in them, or NULL
*/
void BoxesPairs(Boxes boxes, PetscReal reach, BoxesSkip skip, BoxesMeet meet, void *ctx) {
  Search search = {boxes, reach, skip, meet, ctx};
  Branch all = {0, boxes->segments, 0};
  Pairs(&search, all, all);
}
