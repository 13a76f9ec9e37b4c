#include "base/rects.h"

struct _Rects {
  PetscInt n;
  PetscInt *item; /* as they stand in the leaves, from left to right */
  Rect *box;      /* the children of box k are 2 k + 1 and 2 k + 2 */
};

/* A box of the tree, with the leaves it holds. */
typedef struct {
  PetscInt first, last, k;
} Branch;

static Branch Half(Branch b, int which) {
  PetscInt mid = (b.first + b.last) / 2;
  if (which) return (Branch){mid, b.last, 2 * b.k + 2};
  return (Branch){b.first, mid, 2 * b.k + 1};
}

/* Divides the items of a branch along the longer side of its box, by their middles. */
static PetscErrorCode Build(Rects self, const Rect rect[], PetscReal key[], Branch b) {
  Rect *box = &self->box[b.k];
  int d;

  PetscFunctionBegin;
  *box = RectEmpty();
  for (PetscInt i = b.first; i < b.last; i++) {
    RectHold(box, rect[self->item[i]].low);
    RectHold(box, rect[self->item[i]].high);
  }
  if (b.last - b.first == 1) PetscFunctionReturn(0);
  d = box->high[1] - box->low[1] > box->high[0] - box->low[0];
  for (PetscInt i = b.first; i < b.last; i++)
    key[i] = rect[self->item[i]].low[d] + rect[self->item[i]].high[d];
  PetscCall(PetscSortRealWithArrayInt(b.last - b.first, key + b.first, self->item + b.first));
  for (int w = 0; w < 2; w++) PetscCall(Build(self, rect, key, Half(b, w)));
  PetscFunctionReturn(0);
}

/* RectsCreate - the tree over n rectangles, which are not needed any more afterwards; n may be 0.
   Not collective; the caller destroys it with RectsDestroy(). */
PetscErrorCode RectsCreate(PetscInt n, const Rect rect[], Rects *rects) {
  PetscInt size = 1;
  PetscReal *key;

  PetscFunctionBegin;
  PetscCall(PetscNew(rects));
  (*rects)->n = n;
  if (!n) PetscFunctionReturn(0);
  while (size < n) size *= 2;
  PetscCall(PetscMalloc1(2 * size, &(*rects)->box));
  PetscCall(PetscMalloc1(n, &(*rects)->item));
  for (PetscInt i = 0; i < n; i++) (*rects)->item[i] = i;
  PetscCall(PetscMalloc1(n, &key));
  PetscCall(Build(*rects, rect, key, (Branch){0, n, 0}));
  PetscCall(PetscFree(key));
  PetscFunctionReturn(0);
}

PetscErrorCode RectsDestroy(Rects *rects) {
  PetscFunctionBegin;
  if (!*rects) PetscFunctionReturn(0);
  PetscCall(PetscFree((*rects)->box));
  PetscCall(PetscFree((*rects)->item));
  PetscCall(PetscFree(*rects));
  PetscFunctionReturn(0);
}

/* How far two rectangles are from each other. */
static PetscReal Apart(const Rect *a, const Rect *b) {
  PetscReal o[2];
  for (int d = 0; d < 2; d++)
    o[d] = PetscMax(0, PetscMax(a->low[d] - b->high[d], b->low[d] - a->high[d]));
  return o[0] == 0 ? o[1] : o[1] == 0 ? o[0] : PetscSqrtReal(o[0] * o[0] + o[1] * o[1]);
}

/* The search in a branch that is `apart` from the place, the nearer half first. */
static PetscReal Search(const struct _Rects *self, Branch b, PetscReal apart, const Rect *place,
                        PetscReal reach, RectsMeet meet, void *ctx) {
  Branch half[2];
  PetscReal far[2];
  int first;

  if (apart > reach) return reach;
  if (b.last - b.first == 1) return meet(self->item[b.first], reach, ctx);
  for (int w = 0; w < 2; w++) {
    half[w] = Half(b, w);
    far[w] = Apart(&self->box[half[w].k], place);
  }
  first = far[1] < far[0];
  reach = Search(self, half[first], far[first], place, reach, meet, ctx);
  return Search(self, half[!first], far[!first], place, reach, meet, ctx);
}

/*
  RectsNear - tells of all rectangles within reach of a place, in no particular order.

  meet  may lessen the reach as it learns more: so the nearest is found
*/
void RectsNear(Rects rects, const Rect *place, PetscReal reach, RectsMeet meet, void *ctx) {
  const Branch all = {0, rects->n, 0};

  if (rects->n) (void)Search(rects, all, Apart(&rects->box[0], place), place, reach, meet, ctx);
}
