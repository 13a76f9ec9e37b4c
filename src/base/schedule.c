#include "base/schedule.h"
#include "base/hermite.h"
#include "base/knots.h"
#include "base/monotone.h"
#include "base/table.h"
#include "base/turns.h"

struct _Schedule {
  PetscInt n;
  PetscReal *t, *value, *slope; /* of the rate, or of where it is */
  PetscReal *turned;            /* of a rate: where it is at the rows, from the first; else NULL */
  PetscReal start;              /* where it is at t = 0, which is taken off */
  PetscInt turns;
  PetscReal *turn; /* see FindTurns() */
};

/* How far a cubic rate leads from the row lo on, to z of the way to the next. */
static PetscReal LedSince(Schedule self, PetscInt lo, PetscReal z) {
  const PetscReal h = self->t[lo + 1] - self->t[lo], zz = z * z,
                  w[] = {z - zz * z + zz * zz / 2, zz * (0.5 - 2 * z / 3 + zz / 4),
                         zz * z - zz * zz / 2, zz * (zz / 4 - z / 3)};
  return h * (w[0] * self->value[lo] + w[1] * h * self->slope[lo] + w[2] * self->value[lo + 1] +
              w[3] * h * self->slope[lo + 1]);
}

/* Where rows say that it is; where it rests, to the bit: a rod that is bent feels round-off in the
   angle of its clamp as something that drives it out of its plane. */
static PetscReal PlaceSaid(Schedule self, PetscReal t) {
  const PetscInt last = self->n - 1;
  PetscReal w[4], by[4], bend[4], h;
  PetscInt lo;

  if (t <= self->t[0]) return self->value[0];
  if (t >= self->t[last]) return self->value[last];
  lo = KnotBefore(self->n, self->t, t);
  h = self->t[lo + 1] - self->t[lo];
  Hermite((t - self->t[lo]) / h, w, by, bend);
  return self->value[lo] + (w[2] * (self->value[lo + 1] - self->value[lo]) +
                            h * (w[1] * self->slope[lo] + w[3] * self->slope[lo + 1]));
}

/* Where it is at a time, counted from the rows' own 0. */
static PetscReal Place(Schedule self, PetscReal t) {
  const PetscInt last = self->n - 1;
  PetscInt lo;

  if (!self->turned) return PlaceSaid(self, t);
  if (t <= self->t[0]) return (t - self->t[0]) * self->value[0];
  if (t >= self->t[last]) return self->turned[last] + (t - self->t[last]) * self->value[last];
  lo = KnotBefore(self->n, self->t, t);
  return self->turned[lo] + LedSince(self, lo, (t - self->t[lo]) / (self->t[lo + 1] - self->t[lo]));
}

/*
  ScheduleCreate - a schedule of so many rows, two at least, which are to be set by ScheduleSetRow()
  before ScheduleSetUp(). The caller destroys it with ScheduleDestroy(), also after an error.
*/
PetscErrorCode ScheduleCreate(PetscInt n, Schedule *path) {
  PetscFunctionBegin;
  PetscCall(PetscNew(path));
  (*path)->n = n;
  PetscCall(PetscCalloc1(n, &(*path)->t));
  PetscCall(PetscCalloc1(n, &(*path)->value));
  PetscFunctionReturn(0);
}

/* ScheduleSetRow - says what it is at a time: its rate, or where it is. */
void ScheduleSetRow(Schedule self, PetscInt row, PetscReal t, PetscReal value) {
  self->t[row] = t;
  self->value[row] = value;
}

/* Where between two rows, of rates with unlike signs, the rate is 0: there it turns back. */
static PetscReal TurnsBack(Schedule self, PetscInt lo) {
  PetscReal low = self->t[lo], high = self->t[lo + 1], mid = (low + high) / 2;

  for (; mid > low && mid < high; mid = (low + high) / 2)
    if (TurnsSign(MonotoneValue(self->n, self->t, self->value, self->slope, mid)) ==
        TurnsSign(self->value[lo]))
      low = mid;
    else
      high = mid;
  return mid;
}

/* When it sets out, stops or turns back (base/turns.h), and where a rate is 0. */
static PetscErrorCode FindTurns(Schedule self) {
  PetscBool *at;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(self->n, &at));
  TurnsMark(self->n, self->value, 1, at);
  PetscCall(PetscMalloc1(2 * self->n, &self->turn));
  for (PetscInt i = 0; i < self->n; i++) {
    if (at[i] || (self->turned && self->value[i] == 0)) self->turn[self->turns++] = self->t[i];
    if (self->turned && i + 1 < self->n && self->value[i] * self->value[i + 1] < 0)
      self->turn[self->turns++] = TurnsBack(self, i);
  }
  PetscCall(PetscFree(at));
  PetscFunctionReturn(0);
}

/*
  ScheduleSetUp - checks the rows and lays the curve through them. Collective on OptionsComm().

  what  names it where it is refused: t must increase
  rate  do the rows say its rate, or where it is?
*/
PetscErrorCode ScheduleSetUp(const char *what, PetscBool rate, Schedule self) {
  PetscFunctionBegin;
  for (PetscInt i = 1; i < self->n; i++)
    UserCheck(self->t[i] > self->t[i - 1], OptionsComm(), "%s: t must increase", what);
  PetscCall(PetscMalloc1(self->n, &self->slope));
  MonotoneSlopes(self->n, self->t, self->value, self->slope);
  if (rate) PetscCall(PetscCalloc1(self->n, &self->turned));
  for (PetscInt i = 0; rate && i + 1 < self->n; i++)
    self->turned[i + 1] = self->turned[i] + LedSince(self, i, 1);
  self->start = Place(self, 0);
  PetscCall(FindTurns(self));
  PetscFunctionReturn(0);
}

/* ---- tables ---- */

static PetscErrorCode CheckRows(const char *option, const char *file, Table table) {
  PetscFunctionBegin;
  UserCheck(TableRows(table) >= 2, OptionsComm(), "%s %s: needs two rows at least", option, file);
  PetscFunctionReturn(0);
}

/* Rate or place from a table, its rows in self. */
static PetscErrorCode Columns(const char *option, const char *file, const ScheduleWords *words,
                              Table table, Schedule self, PetscBool *rate) {
  PetscBool timed = PETSC_FALSE, said = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < TableColumns(table); c++) {
    const char *name = TableName(table, c);
    const PetscBool time = (PetscBool)!strcmp(name, "t"),
                    fast = (PetscBool)!strcmp(name, words->rate);
    PetscBool *given = time ? &timed : &said;

    UserCheck(time || fast || !strcmp(name, words->place), OptionsComm(),
              "%s %s: column %s: how %s is given by t and %s, or t and %s", option, file, name,
              words->what, words->rate, words->place);
    UserCheck(!*given || !time, OptionsComm(), "%s %s: has t twice", option, file);
    UserCheck(!*given, OptionsComm(), "%s %s: has more than one of %s and %s; leave one out",
              option, file, words->rate, words->place);
    *given = PETSC_TRUE;
    PetscCall(TableQuantities(option, file, table, c,
                              time   ? UNIT_TIME
                              : fast ? words->rate_in
                                     : words->place_in,
                              time ? self->t : self->value));
    if (fast) *rate = PETSC_TRUE;
  }
  UserCheck(timed, OptionsComm(), "%s %s: has no column t", option, file);
  UserCheck(said, OptionsComm(), "%s %s: has neither %s nor %s", option, file, words->rate,
            words->place);
  PetscFunctionReturn(0);
}

static PetscErrorCode OfTable(const char *option, const char *file, const ScheduleWords *words,
                              Table table, Schedule *path) {
  char what[PETSC_MAX_PATH_LEN];
  PetscBool rate = PETSC_FALSE;

  PetscFunctionBegin;
  (void)snprintf(what, sizeof(what), "%s %s", option, file);
  PetscCall(CheckRows(option, file, table));
  PetscCall(ScheduleCreate(TableRows(table), path));
  PetscCall(Columns(option, file, words, table, *path, &rate));
  PetscCall(ScheduleSetUp(what, rate, *path));
  PetscFunctionReturn(0);
}

/*
  ScheduleReadAs - reads how something moves from a table, CSV or HDF5, with t and its rate, or
  where it is. Collective on OptionsComm(); the caller destroys it with ScheduleDestroy(), also
  after an error.

  option, file  which, and the option that named it
  words         names of the columns, and what they are measured in
*/
PetscErrorCode ScheduleReadAs(const char *option, const char *file, const ScheduleWords *words,
                              Schedule *path) {
  PetscErrorCode error;
  Table table = NULL;

  PetscFunctionBegin;
  *path = NULL;
  error = TableReadPlain(option, file, &table);
  if (!error) error = OfTable(option, file, words, table, path);
  PetscCall(TableDestroy(&table));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/*
  ScheduleRead - the same of what turns, with spin (radians per unit of time) or turn (radians; what
  it is at t = 0 is taken off).

  who   turns, for what is said of a table that is none: "a clamp"
*/
PetscErrorCode ScheduleRead(const char *option, const char *file, const char *who, Schedule *path) {
  char what[64];
  const ScheduleWords words = {what, "spin", "turn", UNIT_ANGLE, UNIT_ANGLE};

  PetscFunctionBegin;
  (void)snprintf(what, sizeof(what), "%s turns", who);
  PetscCall(ScheduleReadAs(option, file, &words, path));
  PetscFunctionReturn(0);
}

/* The columns of a table of places, by number, -1: there is none: of t and of x1, x2, x3. */
static PetscErrorCode PlaceColumns(const char *option, const char *file, Table table,
                                   PetscInt column[4]) {
  static const char *const name[4] = {"t", "x1", "x2", "x3"};

  PetscFunctionBegin;
  for (int d = 0; d < 4; d++) column[d] = -1;
  for (PetscInt c = 0; c < TableColumns(table); c++) {
    int d = 0;
    while (d < 4 && strcmp(TableName(table, c), name[d])) d++;
    UserCheck(d < 4, OptionsComm(),
              "%s %s: column %s: how a surface moves is given by t and x1, x2, x3", option, file,
              TableName(table, c));
    UserCheck(column[d] < 0, OptionsComm(), "%s %s: has %s twice", option, file, name[d]);
    column[d] = c;
  }
  UserCheck(column[0] >= 0, OptionsComm(), "%s %s: has no column t", option, file);
  UserCheck(TableColumns(table) > 1, OptionsComm(), "%s %s: has none of x1, x2, x3", option, file);
  PetscFunctionReturn(0);
}

static PetscErrorCode PlaceOfTable(const char *option, const char *file, Table table,
                                   Schedule place[3]) {
  char what[PETSC_MAX_PATH_LEN];
  PetscInt column[4];

  PetscFunctionBegin;
  (void)snprintf(what, sizeof(what), "%s %s", option, file);
  PetscCall(CheckRows(option, file, table));
  PetscCall(PlaceColumns(option, file, table, column));
  for (int d = 0; d < 3; d++) {
    if (column[1 + d] < 0) continue;
    PetscCall(ScheduleCreate(TableRows(table), &place[d]));
    PetscCall(TableQuantities(option, file, table, column[0], UNIT_TIME, place[d]->t));
    PetscCall(TableQuantities(option, file, table, column[1 + d], UNIT_LENGTH, place[d]->value));
    PetscCall(ScheduleSetUp(what, PETSC_FALSE, place[d]));
  }
  PetscFunctionReturn(0);
}

/*
  ScheduleReadPlace - reads how something is displaced from a table, CSV or HDF5, with t and x1, x2,
  x3 (what they are at t = 0 is taken off). Collective on OptionsComm(); the caller destroys each
  with ScheduleDestroy(), also after an error.

  option, file  which, and the option that named it
  place         along x1, x2, x3; NULL where there is no such column: not at all
*/
PetscErrorCode ScheduleReadPlace(const char *option, const char *file, Schedule place[3]) {
  PetscErrorCode error;
  Table table = NULL;

  PetscFunctionBegin;
  place[0] = place[1] = place[2] = NULL;
  error = TableReadPlain(option, file, &table);
  if (!error) error = PlaceOfTable(option, file, table, place);
  PetscCall(TableDestroy(&table));
  PetscCall(error);
  PetscFunctionReturn(0);
}

PetscErrorCode ScheduleDestroy(Schedule *path) {
  PetscFunctionBegin;
  if (!*path) PetscFunctionReturn(0);
  PetscCall(PetscFree((*path)->t));
  PetscCall(PetscFree((*path)->value));
  PetscCall(PetscFree((*path)->slope));
  PetscCall(PetscFree((*path)->turned));
  PetscCall(PetscFree((*path)->turn));
  PetscCall(PetscFree(*path));
  PetscFunctionReturn(0);
}

/* ScheduleValue - how far it has moved, or turned, since t = 0. */
PetscReal ScheduleValue(Schedule self, PetscReal t) {
  return Place(self, t) - self->start;
}

/* ScheduleStart - where its rows say that it is at t = 0. */
PetscReal ScheduleStart(Schedule self) {
  return self->start;
}

/* ScheduleRate - how fast it moves. At the last row, where it may stop at once, as it has moved; at
   the first as if at rest, but at t = 0, where no step ends. */
PetscReal ScheduleRate(Schedule self, PetscReal t) {
  PetscReal w[4], by[4], bend[4], h;
  PetscInt lo;

  if (self->turned) return MonotoneValue(self->n, self->t, self->value, self->slope, t);
  if (t < self->t[0] || t > self->t[self->n - 1] || (t == self->t[0] && t > 0)) return 0;
  lo = KnotBefore(self->n, self->t, t);
  h = self->t[lo + 1] - self->t[lo];
  Hermite((t - self->t[lo]) / h, w, by, bend);
  return (by[0] * self->value[lo] + by[2] * self->value[lo + 1]) / h + by[1] * self->slope[lo] +
         by[3] * self->slope[lo + 1];
}

/* ScheduleFastest - how fast it moves at most, at the rows and half way between them; 0: never. */
PetscReal ScheduleFastest(Schedule self) {
  PetscReal fastest = 0;

  for (PetscInt i = 0; i < self->n; i++) {
    fastest = PetscMax(fastest, PetscAbsReal(self->turned ? self->value[i] : self->slope[i]));
    if (i > 0)
      fastest =
          PetscMax(fastest, PetscAbsReal(ScheduleRate(self, (self->t[i - 1] + self->t[i]) / 2)));
  }
  return fastest;
}

/* ScheduleJerks - does what is led by where it is set out or stop at once between two times? */
PetscBool ScheduleJerks(Schedule self, PetscReal t0, PetscReal t1) {
  for (PetscInt i = 0; i < self->n && !self->turned; i += self->n - 1)
    if (self->t[i] >= t0 && self->t[i] < t1 && self->slope[i] != 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ScheduleNextTurn - the first time behind t at which it sets out, stops or turns back:
   PETSC_MAX_REAL if it does not. Steps that end there cannot leave out that it came and went. */
PetscReal ScheduleNextTurn(Schedule self, PetscReal t) {
  const PetscInt k = KnotBehind(self->turns, self->turn, t);

  return k < self->turns ? self->turn[k] : PETSC_MAX_REAL;
}

/* A BendsCurve. */
static PetscErrorCode InTime(const void *table, PetscReal t, PetscReal value[], PetscReal slope[]) {
  const Schedule self = (const Schedule)table;

  PetscFunctionBegin;
  value[0] = ScheduleValue(self, t);
  slope[0] = ScheduleRate(self, t);
  PetscFunctionReturn(0);
}

/* ScheduleBends - adds the times at which it bends (base/bends.h), and at which it turns back. */
PetscErrorCode ScheduleBends(Schedule self, PetscReal tolerance, Bends *bends) {
  PetscFunctionBegin;
  PetscCall(BendsFind(self->n, self->t, 1, InTime, self, tolerance, bends));
  for (PetscInt k = 0; k < self->turns; k++) PetscCall(BendsAdd(bends, self->turn[k]));
  PetscFunctionReturn(0);
}

PetscInt ScheduleRows(Schedule self) {
  return self->n;
}

/* ScheduleIsRate - do its rows say its rate, or where it is? */
PetscBool ScheduleIsRate(Schedule self) {
  return (PetscBool)(self->turned != NULL);
}

/* ScheduleGetRow - what a row says, as it was given. */
void ScheduleGetRow(Schedule self, PetscInt row, PetscReal *t, PetscReal *value) {
  *t = self->t[row];
  *value = self->value[row];
}
