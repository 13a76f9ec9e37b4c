#include "base/squares.h"
#include <stdint.h>

typedef struct {
  int64_t key[2]; /* which square */
  PetscInt from;  /* where its lists begin, one for each tree; below 0: no square */
} Square;

struct _Squares {
  PetscReal size, *reach; /* of a square; of each list */
  PetscInt n;             /* trees */
  Blocks *tree;           /* borrowed */
  PetscInt room, filled;  /* a table of 2^k places, by key; how many are taken */
  PetscInt latest;
  Square *square;
  PetscBool full; /* there is no memory for more */
  PetscInt items, items_room;
  int *item; /* lists one behind the other: how many items, and which */
};

enum { FIRST_ROOM = 256, MOST_FILLED = 1 << 20 };

/* An empty table. */
static PetscErrorCode MakeTable(Squares self, PetscInt room) {
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(room, &self->square));
  self->room = room;
  for (PetscInt k = 0; k < room; k++) self->square[k].from = -1;
  PetscFunctionReturn(0);
}

/*
  SquaresCreate - squares over trees of the plane, none of which has been looked from. Not
  collective; the caller ends it with SquaresDestroy().

  size   of a square
  trees  [n], borrowed; their items stand still
  reach  [n], how far from a square its list of that tree reaches
*/
PetscErrorCode SquaresCreate(PetscReal size, PetscInt n, const Blocks trees[],
                             const PetscReal reach[], Squares *squares) {
  Squares self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *squares = self;
  self->size = size;
  self->n = n;
  PetscCall(PetscMalloc2(n, &self->tree, n, &self->reach));
  PetscCall(PetscArraycpy(self->tree, trees, n));
  PetscCall(PetscArraycpy(self->reach, reach, n));
  PetscCall(MakeTable(self, FIRST_ROOM));
  PetscFunctionReturn(0);
}

PetscErrorCode SquaresDestroy(Squares *squares) {
  PetscFunctionBegin;
  if (!*squares) PetscFunctionReturn(0);
  PetscCall(PetscFree2((*squares)->tree, (*squares)->reach));
  PetscCall(PetscFree((*squares)->square));
  PetscCall(PetscFree((*squares)->item));
  PetscCall(PetscFree(*squares));
  PetscFunctionReturn(0);
}

/* SquaresReach - how far a list of that tree reaches from its square. */
PetscReal SquaresReach(Squares self, PetscInt tree) {
  return self->reach[tree];
}

/* Room for one more item; false: there is none to be had. */
static PetscBool HasRoom(Squares self) {
  const PetscInt room = 2 * self->items_room + 1024;

  if (self->items < self->items_room) return PETSC_TRUE;
  if (PetscRealloc((size_t)room * sizeof(int), &self->item)) return PETSC_FALSE;
  self->items_room = room;
  return PETSC_TRUE;
}

static PetscReal Gather(PetscInt item, PetscReal reach, void *ctx) {
  Squares self = (Squares)ctx;

  if (!HasRoom(self)) {
    self->full = PETSC_TRUE;
    return -1;
  }
  self->item[self->items++] = (int)item;
  return reach;
}

/* Where a square is in the table, or would be. */
static PetscInt PlaceOf(const Squares self, const int64_t key[2]) {
  const uint64_t hash =
      (uint64_t)key[0] * 0x9E3779B97F4A7C15u ^ (uint64_t)key[1] * 0xC2B2AE3D27D4EB4Fu;
  PetscInt k = (PetscInt)((hash ^ hash >> 29) & (uint64_t)(self->room - 1));

  while (self->square[k].from >= 0 &&
         (self->square[k].key[0] != key[0] || self->square[k].key[1] != key[1]))
    k = (k + 1) & (self->room - 1);
  return k;
}

static PetscErrorCode Widen(Squares self) {
  const PetscInt room = self->room;
  Square *old = self->square;

  PetscFunctionBegin;
  PetscCall(MakeTable(self, 2 * room));
  for (PetscInt k = 0; k < room; k++)
    if (old[k].from >= 0) self->square[PlaceOf(self, old[k].key)] = old[k];
  PetscCall(PetscFree(old));
  PetscFunctionReturn(0);
}

/* Looks from a square for the first time: whatever is within reach of any of its places, and a
   little more, for round-off. */
static PetscErrorCode Enter(Squares self, const int64_t key[2], PetscInt *at) {
  const PetscReal round_off = 1e-6;
  const PetscInt from = self->items;
  Block place = BlockEmpty(2);

  PetscFunctionBegin;
  if (2 * self->filled >= self->room) PetscCall(Widen(self));
  *at = PlaceOf(self, key);
  for (int d = 0; d < 2; d++) {
    place.low[d] = ((PetscReal)key[d] - round_off) * self->size;
    place.high[d] = ((PetscReal)key[d] + 1 + round_off) * self->size;
  }
  for (PetscInt k = 0; k < self->n; k++) {
    const PetscInt head = self->items;
    PetscCheck(HasRoom(self), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for squares");
    self->items++;
    BlocksNear(self->tree[k], &place, self->reach[k], Gather, self);
    self->item[head] = (int)(self->items - head - 1);
  }
  PetscCheck(!self->full, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for squares");
  self->square[*at] = (Square){{key[0], key[1]}, from};
  self->filled++;
  PetscFunctionReturn(0);
}

/* SquaresAt - the lists of the square that a place is in, one for each tree, one behind the other
   (SquaresNext()): how many items, and which. NULL: too far, or too many squares; search the
   trees. */
const int *SquaresAt(Squares self, const PetscReal x[2]) {
  const PetscReal far = 1e9;
  const Square *latest = &self->square[self->latest];
  int64_t key[2];
  PetscInt k;

  for (int d = 0; d < 2; d++) {
    const PetscReal z = PetscFloorReal(x[d] / self->size);
    if (!(PetscAbsReal(z) < far)) return NULL;
    key[d] = (int64_t)z;
  }
  if (latest->from >= 0 && latest->key[0] == key[0] && latest->key[1] == key[1])
    return self->item + latest->from;
  k = PlaceOf(self, key);
  if (self->square[k].from < 0 && (self->filled >= MOST_FILLED || Enter(self, key, &k)))
    return NULL;
  self->latest = k;
  return self->item + self->square[k].from;
}
