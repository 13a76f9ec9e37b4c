#include "world/schedule.h"
#include "base/hermite.h"
#include "base/knots.h"
#include "base/monotone.h"
#include "base/table.h"

struct _Schedule {
  PetscInt n;
  PetscReal *t, *value, *slope; /* of the rate, or of the angle */
  PetscReal *turned;            /* of a rate: the angle at the rows, from the first; else NULL */
  PetscReal start;              /* the angle at t = 0, which is taken off */
};

/* The angle by which a cubic rate turns from the row lo on, to z of the way to the next. */
static PetscReal TurnedSince(Schedule self, PetscInt lo, PetscReal z) {
  const PetscReal h = self->t[lo + 1] - self->t[lo], zz = z * z,
                  w[] = {z - zz * z + zz * zz / 2, zz * (0.5 - 2 * z / 3 + zz / 4),
                         zz * z - zz * zz / 2, zz * (zz / 4 - z / 3)};
  return h * (w[0] * self->value[lo] + w[1] * h * self->slope[lo] + w[2] * self->value[lo + 1] +
              w[3] * h * self->slope[lo + 1]);
}

/* What a table of angles says; where it rests, to the bit: a rod that is bent feels round-off in
   the angle of its clamp as something that drives it out of its plane. */
static PetscReal AngleSaid(Schedule self, PetscReal t) {
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

/* The angle at a time, counted from the table's own 0. */
static PetscReal Angle(Schedule self, PetscReal t) {
  const PetscInt last = self->n - 1;
  PetscInt lo;

  if (!self->turned) return AngleSaid(self, t);
  if (t <= self->t[0]) return (t - self->t[0]) * self->value[0];
  if (t >= self->t[last]) return self->turned[last] + (t - self->t[last]) * self->value[last];
  lo = KnotBefore(self->n, self->t, t);
  return self->turned[lo] +
         TurnedSince(self, lo, (t - self->t[lo]) / (self->t[lo + 1] - self->t[lo]));
}

static PetscErrorCode Columns(const char *option, const char *file, Table table, Schedule self,
                              PetscBool *rate) {
  PetscFunctionBegin;
  self->n = TableRows(table);
  UserCheck(self->n >= 2, OptionsComm(), "%s %s: needs two rows at least", option, file);
  for (PetscInt c = 0; c < TableColumns(table); c++) {
    const char *name = TableName(table, c);
    const PetscBool time = (PetscBool)!strcmp(name, "t");
    PetscReal **value = time ? &self->t : &self->value;

    UserCheck(time || !strcmp(name, "spin") || !strcmp(name, "turn"), OptionsComm(),
              "%s %s: column %s: how a clamp turns is told by t and spin, or t and turn", option,
              file, name);
    UserCheck(!*value, OptionsComm(), "%s %s: has %s", option, file,
              time ? "t twice" : "more than one of spin and turn; leave one out");
    PetscCall(PetscMalloc1(self->n, value));
    PetscCall(TableQuantities(option, file, table, c, time ? UNIT_TIME : UNIT_ANGLE, *value));
    if (!time) *rate = (PetscBool)!strcmp(name, "spin");
  }
  UserCheck(self->t, OptionsComm(), "%s %s: has no column t", option, file);
  UserCheck(self->value, OptionsComm(), "%s %s: has neither spin nor turn", option, file);
  for (PetscInt i = 1; i < self->n; i++)
    UserCheck(self->t[i] > self->t[i - 1], OptionsComm(), "%s %s: t must increase", option, file);
  PetscFunctionReturn(0);
}

/*
  ScheduleRead - reads how a clamp turns from a table, CSV or HDF5, with t and spin (radians per
  unit of time) or turn (radians; what it is at t = 0 is taken off). Collective on OptionsComm();
  the caller destroys it with ScheduleDestroy(), also after an error.

  option, file  which, and the option that named it
*/
PetscErrorCode ScheduleRead(const char *option, const char *file, Schedule *path) {
  PetscBool rate = PETSC_FALSE;
  Table table = NULL;
  Schedule self;

  PetscFunctionBegin;
  PetscCall(PetscNew(path));
  self = *path;
  PetscCall(TableReadPlain(option, file, &table));
  PetscCall(Columns(option, file, table, self, &rate));
  PetscCall(TableDestroy(&table));
  PetscCall(PetscMalloc1(self->n, &self->slope));
  MonotoneSlopes(self->n, self->t, self->value, self->slope);
  if (rate) PetscCall(PetscCalloc1(self->n, &self->turned));
  for (PetscInt i = 0; rate && i + 1 < self->n; i++)
    self->turned[i + 1] = self->turned[i] + TurnedSince(self, i, 1);
  self->start = Angle(self, 0);
  PetscFunctionReturn(0);
}

PetscErrorCode ScheduleDestroy(Schedule *path) {
  PetscFunctionBegin;
  if (!*path) PetscFunctionReturn(0);
  PetscCall(PetscFree((*path)->t));
  PetscCall(PetscFree((*path)->value));
  PetscCall(PetscFree((*path)->slope));
  PetscCall(PetscFree((*path)->turned));
  PetscCall(PetscFree(*path));
  PetscFunctionReturn(0);
}

/* ScheduleAngle - by how much the clamp has turned since t = 0. */
PetscReal ScheduleAngle(Schedule self, PetscReal t) {
  return Angle(self, t) - self->start;
}

/* ScheduleRate - how fast it turns. */
PetscReal ScheduleRate(Schedule self, PetscReal t) {
  PetscReal w[4], by[4], bend[4], h;
  PetscInt lo;

  if (self->turned) return MonotoneValue(self->n, self->t, self->value, self->slope, t);
  if (t < self->t[0] || t > self->t[self->n - 1]) return 0;
  lo = KnotBefore(self->n, self->t, t);
  h = self->t[lo + 1] - self->t[lo];
  Hermite((t - self->t[lo]) / h, w, by, bend);
  return (by[0] * self->value[lo] + by[2] * self->value[lo + 1]) / h + by[1] * self->slope[lo] +
         by[3] * self->slope[lo + 1];
}

/* ScheduleFastest - how fast it turns at most, at the rows and half way between them; 0: never. */
PetscReal ScheduleFastest(Schedule self) {
  PetscReal fastest = 0;

  for (PetscInt i = 0; i < self->n; i++) {
    fastest = PetscMax(fastest, PetscAbsReal(ScheduleRate(self, self->t[i])));
    if (i > 0)
      fastest =
          PetscMax(fastest, PetscAbsReal(ScheduleRate(self, (self->t[i - 1] + self->t[i]) / 2)));
  }
  return fastest;
}

/* ScheduleJerks - does a clamp that an angle leads set out or stop at once between two times? */
PetscBool ScheduleJerks(Schedule self, PetscReal t0, PetscReal t1) {
  for (PetscInt i = 0; i < self->n && !self->turned; i += self->n - 1)
    if (self->t[i] >= t0 && self->t[i] < t1 && self->slope[i] != 0) return PETSC_TRUE;
  return PETSC_FALSE;
}
