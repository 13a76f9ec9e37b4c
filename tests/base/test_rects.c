/* Rectangles in a tree: those within reach of a place, and the nearest, as when all are looked at.
 */
#include "base/rects.h"
#include "harness.h"

enum { MOST = 300 };

typedef struct {
  const Rect *rect;
  PetscReal x[2], nearest;
  PetscInt n, met[MOST];
} Seen;

static PetscReal Away(const Rect *rect, const PetscReal x[2]) {
  PetscReal o[2];
  for (int d = 0; d < 2; d++)
    o[d] = PetscMax(0, PetscMax(rect->low[d] - x[d], x[d] - rect->high[d]));
  return hypot(o[0], o[1]);
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
  seen->nearest = PetscMin(seen->nearest, Away(&seen->rect[item], seen->x));
  return PetscMin(reach, seen->nearest);
}

static void Look(PetscInt n) {
  PetscInt looked = 0;
  Rect rect[MOST];
  Rects rects;

  for (PetscInt i = 0; i < n; i++)
    for (int d = 0; d < 2; d++) {
      rect[i].low[d] = 5 * Scatter(i, d);
      rect[i].high[d] = rect[i].low[d] + 0.3 * PetscAbsReal(Scatter(i, 2 + d));
    }
  CHECK(RectsCreate(n, rect, &rects));
  for (int k = 0; k < 200; k++) {
    const PetscReal reach = 0.5 * PetscAbsReal(Scatter(k, 11));
    Seen seen = {.rect = rect, .x = {6 * Scatter(k, 9), 6 * Scatter(k, 10)}};
    const Rect place = {{seen.x[0], seen.x[1]}, {seen.x[0], seen.x[1]}};
    PetscReal nearest = PETSC_MAX_REAL;
    RectsNear(rects, &place, reach, Count, &seen);
    for (PetscInt i = 0; i < n; i++) {
      PetscReal away = Away(&rect[i], seen.x);
      nearest = PetscMin(nearest, away);
      EXPECT(seen.met[i] == (away <= reach), "%d met %d times, %g away, reach %g", (int)i,
             (int)seen.met[i], away, reach);
    }
    seen.n = 0;
    seen.nearest = PETSC_MAX_REAL;
    RectsNear(rects, &place, PETSC_MAX_REAL, Lessen, &seen);
    EXPECT(seen.nearest == nearest, "nearest %g, not %g", seen.nearest, nearest);
    looked += seen.n;
  }
  EXPECT(n < 100 || looked < 200 * n / 10, "looked at %d of %d", (int)looked, 200 * (int)n);
  CHECK(RectsDestroy(&rects));
}

static void TestNear(void **state) {
  Look(1);
  Look(2);
  Look(7);
  Look(MOST);
}

static void TestNone(void **state) {
  const Rect place = {{0, 0}, {0, 0}};
  Rects rects;
  Seen seen = {.n = 0};
  CHECK(RectsCreate(0, NULL, &rects));
  RectsNear(rects, &place, 1e9, Count, &seen);
  EXPECT(seen.n == 0, "met %d", (int)seen.n);
  CHECK(RectsDestroy(&rects));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestNear), cmocka_unit_test(TestNone)};
MAIN(tests)
