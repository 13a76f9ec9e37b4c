#include "base/bends.h"
#include "base/knots.h"

/* A slope is as good as 0 if it changes the largest value by this part of it over all rows: spline
   of equal entries have round-off for slopes. */
static const PetscReal level = 1e-9;

/* Places between two rows: so many even ones, and where the leading column turns or is steepest. */
enum { PLACES = 4, MOST_PLACES = PLACES + 3 };

PetscErrorCode BendsAdd(Bends *self, PetscReal at) {
  PetscFunctionBegin;
  if (self->n == self->room) {
    self->room = PetscMax(64, 2 * self->room);
    PetscCall(PetscRealloc(sizeof(*self->at) * self->room, &self->at));
  }
  self->at[self->n++] = at;
  PetscFunctionReturn(0);
}

/* A polygon from bend to bend that leaves no place by more than its tolerance: lines from the
   latest bend have to pass through the gates of all places behind it. */
typedef struct {
  PetscInt columns;       /* values, then slopes */
  PetscReal from, before; /* the latest bend, and the latest place behind it */
  PetscReal *start, *latest, *now, *low, *high; /* what they are there; slopes of the lines */
  PetscReal *floor, tolerance;
} Polygon;

static PetscErrorCode PolygonCreate(PetscInt columns, PetscReal tolerance, Polygon *self) {
  PetscFunctionBegin;
  self->columns = 2 * columns;
  self->tolerance = tolerance;
  PetscCall(PetscMalloc6(2 * columns, &self->start, 2 * columns, &self->latest, 2 * columns,
                         &self->now, 2 * columns, &self->low, 2 * columns, &self->high, 2 * columns,
                         &self->floor));
  PetscFunctionReturn(0);
}

static PetscErrorCode PolygonDestroy(Polygon *self) {
  PetscFunctionBegin;
  PetscCall(PetscFree6(self->start, self->latest, self->now, self->low, self->high, self->floor));
  PetscFunctionReturn(0);
}

/* A bend is where the latest place is: no gates yet. */
static void PolygonBegin(Polygon *self) {
  self->from = self->before;
  for (PetscInt c = 0; c < self->columns; c++) {
    self->start[c] = self->latest[c];
    self->low[c] = PETSC_MIN_REAL;
    self->high[c] = PETSC_MAX_REAL;
  }
}

/* Does a line from the latest bend to what is now pass all gates? */
static PetscBool PolygonPasses(const Polygon *self, PetscReal at) {
  for (PetscInt c = 0; c < self->columns; c++) {
    const PetscReal slope = (self->now[c] - self->start[c]) / (at - self->from);
    if (slope < self->low[c] || slope > self->high[c]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Sets the gates of what is now, which becomes the latest place. */
static void PolygonGate(Polygon *self, PetscReal at) {
  const PetscReal h = at - self->from;

  for (PetscInt c = 0; c < self->columns; c++) {
    const PetscReal free = PetscMax(self->tolerance * PetscAbsReal(self->now[c]), self->floor[c]),
                    rise = self->now[c] - self->start[c];
    self->low[c] = PetscMax(self->low[c], (rise - free) / h);
    self->high[c] = PetscMin(self->high[c], (rise + free) / h);
    self->latest[c] = self->now[c];
  }
  self->before = at;
}

/* The next place; turns: a bend in any case. */
static PetscErrorCode PolygonGo(Polygon *self, PetscReal at, PetscBool turns, Bends *bends) {
  PetscFunctionBegin;
  if (!PolygonPasses(self, at)) {
    PetscCall(BendsAdd(bends, self->before));
    PolygonBegin(self);
  }
  PolygonGate(self, at);
  if (!turns) PetscFunctionReturn(0);
  PetscCall(BendsAdd(bends, at));
  PolygonBegin(self);
  PetscFunctionReturn(0);
}

/* What counts as 0, of values and of slopes: from the rows. */
static PetscErrorCode Floors(PetscInt n, const PetscReal row[], BendsCurve curve, const void *table,
                             Polygon *self) {
  const PetscInt columns = self->columns / 2;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < columns; c++) self->floor[c] = 0;
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(curve(table, row[k], self->now, self->now + columns));
    for (PetscInt c = 0; c < columns; c++)
      self->floor[c] = PetscMax(self->floor[c], level * PetscAbsReal(self->now[c]));
  }
  for (PetscInt c = 0; c < columns; c++)
    self->floor[columns + c] =
        PetscMax(self->floor[c] / (row[n - 1] - row[0]), PETSC_MACHINE_EPSILON);
  PetscFunctionReturn(0);
}

/* Where between two rows, at z of the way, what goes by a cubic turns (its slope, a parabola, is 0)
   or is steepest, from its slopes in the beginning, the middle and the end; returns how many. */
static int Turns(const PetscReal f[3], PetscReal floor, PetscReal z[3], PetscBool turns[3]) {
  const PetscReal a = 2 * (f[0] - 2 * f[1] + f[2]), b = f[2] - f[0] - a,
                  most = PetscMax(PetscAbsReal(f[0]),
                                  PetscMax(PetscAbsReal(f[1]), PetscAbsReal(f[2])));
  const PetscReal root = b * b - 4 * a * f[0];
  int n = 0;

  if (most <= floor) return 0;
  if (PetscAbsReal(a) > level * most) z[n++] = -b / (2 * a);
  turns[0] = PETSC_FALSE;
  if (root > 0) {
    const PetscReal q = -(b + PetscCopysignReal(PetscSqrtReal(root), b)) / 2;
    for (int k = 0; k < 2; k++) {
      if ((k ? q : a) == 0) continue;
      z[n] = k ? f[0] / q : q / a;
      turns[n++] = PETSC_TRUE;
    }
  }
  return n;
}

/* The places between two rows to be looked at, in order, the first row left out; returns how many.
 */
static PetscErrorCode PlacesBetween(PetscReal a, PetscReal b, PetscInt columns, BendsCurve curve,
                                    const void *table, Polygon *self, PetscReal z[MOST_PLACES],
                                    PetscBool turns[MOST_PLACES], int *n) {
  PetscReal slope[3], more[3];
  PetscBool turn[3];
  int extra;

  PetscFunctionBegin;
  for (int k = 0; k < 3; k++) {
    PetscCall(curve(table, a + (b - a) * k / 2, self->now, self->now + columns));
    slope[k] = self->now[2 * columns - 1];
  }
  for (*n = 0; *n < PLACES; (*n)++) {
    z[*n] = (PetscReal)(*n + 1) / PLACES;
    turns[*n] = PETSC_FALSE;
  }
  extra = Turns(slope, self->floor[2 * columns - 1], more, turn);
  for (int k = 0; k < extra; k++) {
    int at = *n;
    if (!(more[k] > 0 && more[k] < 1)) continue;
    for (; at > 0 && z[at - 1] > more[k]; at--) {
      z[at] = z[at - 1];
      turns[at] = turns[at - 1];
    }
    z[at] = more[k];
    turns[at] = turn[k];
    (*n)++;
  }
  PetscFunctionReturn(0);
}

/*
  BendsFind - adds the places at which what a table gives, or its slope, bends: between them no
  column, and no slope of one, is farther from a straight line than the tolerance times its own
  size. Looked at are the rows and places between them, and where the last column turns, which is
  always one of the bends. First and last row are, too.

  row   n places, increasing
*/
PetscErrorCode BendsFind(PetscInt n, const PetscReal row[], PetscInt columns, BendsCurve curve,
                         const void *table, PetscReal tolerance, Bends *bends) {
  Polygon self;

  PetscFunctionBegin;
  if (n < 2) PetscFunctionReturn(0);
  PetscCall(PolygonCreate(columns, tolerance, &self));
  PetscCall(Floors(n, row, curve, table, &self));
  PetscCall(curve(table, row[0], self.latest, self.latest + columns));
  self.before = row[0];
  PolygonBegin(&self);
  PetscCall(BendsAdd(bends, row[0]));
  for (PetscInt k = 0; k + 1 < n; k++) {
    PetscReal z[MOST_PLACES];
    PetscBool turns[MOST_PLACES];
    int places = 0;
    PetscCall(PlacesBetween(row[k], row[k + 1], columns, curve, table, &self, z, turns, &places));
    for (int i = 0; i < places; i++) {
      const PetscReal at = z[i] < 1 ? row[k] + z[i] * (row[k + 1] - row[k]) : row[k + 1];
      if (at <= self.before) continue;
      PetscCall(curve(table, at, self.now, self.now + columns));
      PetscCall(PolygonGo(&self, at, turns[i], bends));
    }
  }
  PetscCall(BendsAdd(bends, row[n - 1]));
  PetscCall(PolygonDestroy(&self));
  PetscFunctionReturn(0);
}

/* BendsSort - puts them in order, each once, and drops those that are not between two places. */
PetscErrorCode BendsSort(Bends *self, PetscReal from, PetscReal to) {
  const PetscReal apart =
      4 * PETSC_MACHINE_EPSILON * PetscMax(PetscAbsReal(from), PetscAbsReal(to));
  PetscInt n = 0;

  PetscFunctionBegin;
  PetscCall(PetscSortReal(self->n, self->at));
  for (PetscInt k = 0; k < self->n; k++) {
    const PetscReal at = self->at[k];
    if (at > from && at < to && (!n || at - self->at[n - 1] > apart)) self->at[n++] = at;
  }
  self->n = n;
  PetscFunctionReturn(0);
}

/* BendsNext - the first behind a place, PETSC_MAX_REAL if there is none. */
PetscReal BendsNext(const Bends *self, PetscReal after) {
  const PetscInt k = KnotBehind(self->n, self->at, after);

  return k < self->n ? self->at[k] : PETSC_MAX_REAL;
}

PetscErrorCode BendsDestroy(Bends *self) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->at));
  self->n = self->room = 0;
  PetscFunctionReturn(0);
}
