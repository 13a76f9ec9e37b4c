/* Blocks in a tree, in the plane and in space: those within reach of a place, and the nearest, as
   when all are looked at.
   test: the nearest blocks of a tree are the nearest of all */
#include "base/blocks.h"
#include "base/squares.h"
#include "harness.h"

enum { MOST = 300 };

typedef struct {
  int dims;
  const Block *block;
  PetscReal x[3], nearest;
  PetscInt n, met[MOST];
} Seen;

static PetscReal Away(int dims, const Block *block, const PetscReal x[3]) {
  PetscReal o[3] = {0};
  for (int d = 0; d < dims; d++)
    o[d] = PetscMax(0, PetscMax(block->low[d] - x[d], x[d] - block->high[d]));
  return hypot(hypot(o[0], o[1]), o[2]);
}

static PetscReal Count(PetscInt item, PetscReal reach, void *ctx) {
  Seen *seen = (Seen *)ctx;
  seen->met[item]++;
  seen->n++;
  return reach;
}

static PetscReal Lessen(PetscInt item, PetscReal reach, void *ctx) {
  Seen *seen = (Seen *)ctx;
  seen->n++;
  seen->nearest = PetscMin(seen->nearest, Away(seen->dims, &seen->block[item], seen->x));
  return PetscMin(reach, seen->nearest);
}

static void Look(int dims, PetscInt n) {
  PetscInt looked = 0;
  Block block[MOST];
  Blocks blocks;

  for (PetscInt i = 0; i < n; i++)
    for (int d = 0; d < dims; d++) {
      block[i].low[d] = 5 * Scatter(i, d);
      block[i].high[d] = block[i].low[d] + 0.3 * PetscAbsReal(Scatter(i, 3 + d));
    }
  CHECK(BlocksCreate(dims, n, block, &blocks));
  for (int k = 0; k < 200; k++) {
    const PetscReal reach = 0.5 * PetscAbsReal(Scatter(k, 11));
    Seen seen = {.dims = dims,
                 .block = block,
                 .x = {6 * Scatter(k, 9), 6 * Scatter(k, 10), 6 * Scatter(k, 12)}};
    const Block place = BlockAt(dims, seen.x);
    PetscReal nearest = PETSC_MAX_REAL;
    BlocksNear(blocks, &place, reach, Count, &seen);
    for (PetscInt i = 0; i < n; i++) {
      PetscReal away = Away(dims, &block[i], seen.x);
      nearest = PetscMin(nearest, away);
      EXPECT(seen.met[i] == (away <= reach), "%d met %d times, %g away, reach %g", (int)i,
             (int)seen.met[i], away, reach);
    }
    seen.n = 0;
    seen.nearest = PETSC_MAX_REAL;
    BlocksNear(blocks, &place, PETSC_MAX_REAL, Lessen, &seen);
    EXPECT(seen.nearest == nearest, "nearest %g, not %g", seen.nearest, nearest);
    looked += seen.n;
  }
  EXPECT(n < 100 || looked < 200 * n / (dims == 2 ? 10 : 5), "looked at %d of %d", (int)looked,
         200 * (int)n);
  CHECK(BlocksDestroy(&blocks));
}

static void TestNear(void **state) {
  for (int dims = 2; dims <= 3; dims++) {
    Look(dims, 1);
    Look(dims, 2);
    Look(dims, 7);
    Look(dims, MOST);
  }
}

static void TestNone(void **state) {
  const Block place = {{0}, {0}};
  Blocks blocks;
  Seen seen = {.n = 0};
  CHECK(BlocksCreate(2, 0, NULL, &blocks));
  BlocksNear(blocks, &place, 1e9, Count, &seen);
  EXPECT(seen.n == 0, "met %d", (int)seen.n);
  CHECK(BlocksDestroy(&blocks));
}

/* The list of a square has all that is within its reach of a place there, once, for each tree,
   however many squares are looked from; far out there is none. */
static void TestSquares(void **state) {
  enum { TREES = 2, N = 120 };
  const PetscReal reach[TREES] = {0.4, 1.5}, size = 0.3;
  Block block[TREES][N];
  Blocks tree[TREES];
  Squares squares;

  for (int t = 0; t < TREES; t++) {
    for (PetscInt i = 0; i < N; i++)
      for (int d = 0; d < 2; d++) {
        block[t][i].low[d] = 5 * Scatter(i, d + 20 * t);
        block[t][i].high[d] = block[t][i].low[d] + 0.3 * PetscAbsReal(Scatter(i, 3 + d + 20 * t));
      }
    CHECK(BlocksCreate(2, N, block[t], &tree[t]));
  }
  CHECK(SquaresCreate(size, TREES, tree, reach, &squares));
  for (int k = 0; k < 1000; k++) {
    const PetscReal x[3] = {6 * Scatter(k, 9), 6 * Scatter(k, 10), 0};
    const int *list = SquaresAt(squares, x);
    for (int t = 0; t < TREES; t++, list = SquaresNext(list)) {
      int met[N] = {0}, wrong = 0;
      for (int j = 1; j <= *list; j++) met[list[j]]++;
      for (PetscInt i = 0; i < N; i++) {
        const PetscReal away = Away(2, &block[t][i], x);
        wrong += met[i] > 1 || (!met[i] && away <= SquaresReach(squares, t)) ||
                 (met[i] && away > reach[t] + 1.5 * size);
      }
      EXPECT(!wrong, "at %g, %g of tree %d: %d items are missing, or there too often", x[0], x[1],
             t, wrong);
    }
  }
  EXPECT(!SquaresAt(squares, (const PetscReal[2]){1e12, 0}), "squares without an end");
  CHECK(SquaresDestroy(&squares));
  for (int t = 0; t < TREES; t++) CHECK(BlocksDestroy(&tree[t]));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestNear), cmocka_unit_test(TestNone),
                                          cmocka_unit_test(TestSquares)};
MAIN(tests)
