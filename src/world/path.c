#include "world/path.h"
#include "base/vectors.h"
#include "base/knots.h"
#include "base/monotone.h"
#include "base/quaternion.h"
#include "base/table.h"
#include "base/turns.h"

static const struct {
  const char *name;
  Dimension dimension;
} columns[PATH_COLUMNS] = {{"x1", UNIT_LENGTH},   {"x2", UNIT_LENGTH}, {"x3", UNIT_LENGTH},
                           {"angle", UNIT_ANGLE}, {"q0", UNIT_NONE},   {"q1", UNIT_NONE},
                           {"q2", UNIT_NONE},     {"q3", UNIT_NONE},   {"turn", UNIT_ANGLE}};

/* What the tip is off the path at the start fades along it. */
struct _Path {
  PetscInt n;
  PetscReal *t, *value[PATH_COLUMNS], *slope[PATH_COLUMNS]; /* NULL: not said */
  PetscBool *turns;                                         /* at which rows (base/turns.h) */
  PetscReal lab[3][3], clamp[4]; /* from the frame of the clamp to the laboratory */
  PetscReal begin;               /* of the run, or the first row */
  PetscReal turned;              /* what PATH_TURN is then: turns are counted from there */
  PathPlace start, off;          /* of the tip; of it against the path there, off.p by a turn */
};

/* Makes the quaternions of a path unit ones, of which neighbours are on one side. */
static PetscErrorCode Frames(const char *option, const char *file, Path self) {
  PetscFunctionBegin;
  for (PetscInt i = 0; i < self->n; i++) {
    PetscReal size = 0, before = 0;
    for (int k = 0; k < 4; k++) size += PetscSqr(self->value[PATH_FRAME + k][i]);
    UserCheck(size > 1e-12, OptionsComm(), "%s %s: q0 to q3 of row %d are all 0", option, file,
              (int)i + 1);
    for (int k = 0; k < 4 && i; k++)
      before += self->value[PATH_FRAME + k][i] * self->value[PATH_FRAME + k][i - 1];
    for (int k = 0; k < 4; k++)
      self->value[PATH_FRAME + k][i] *= (before < 0 ? -1 : 1) / PetscSqrtReal(size);
  }
  PetscFunctionReturn(0);
}

/* Which column has this name? -1: that of time, PATH_COLUMNS: none. */
static int ColumnOf(const char *name) {
  int k = 0;
  if (!strcmp(name, "t")) return -1;
  while (k < PATH_COLUMNS && strcmp(name, columns[k].name)) k++;
  return k;
}

static PetscErrorCode Columns(const char *option, const char *file, Table table, Path self) {
  PetscFunctionBegin;
  self->n = TableRows(table);
  UserCheck(self->n >= 2, OptionsComm(), "%s %s: needs two rows at least", option, file);
  for (PetscInt c = 0; c < TableColumns(table); c++) {
    int k = ColumnOf(TableName(table, c));
    PetscReal **value = k < 0 ? &self->t : k < PATH_COLUMNS ? &self->value[k] : NULL;
    UserCheck(value, OptionsComm(),
              "%s %s: column %s: a path has t and some of x1, x2, x3, angle (or q0, q1, q2, q3) "
              "and turn",
              option, file, TableName(table, c));
    UserCheck(!*value, OptionsComm(), "%s %s: has %s twice", option, file, TableName(table, c));
    PetscCall(PetscMalloc1(self->n, value));
    PetscCall(
        TableQuantities(option, file, table, c, k < 0 ? UNIT_TIME : columns[k].dimension, *value));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Check(const char *option, const char *file, Path self) {
  PetscFunctionBegin;
  UserCheck(self->t, OptionsComm(), "%s %s: has no column t", option, file);
  for (PetscInt i = 1; i < self->n; i++)
    UserCheck(self->t[i] > self->t[i - 1], OptionsComm(), "%s %s: t must increase", option, file);
  UserCheck(self->t[self->n - 1] > 0, OptionsComm(), "%s %s: ends before the run begins, at t = 0",
            option, file);
  for (int k = 1; k < 4; k++)
    UserCheck(!self->value[PATH_FRAME] == !self->value[PATH_FRAME + k], OptionsComm(),
              "%s %s: give all of q0, q1, q2, q3, or none", option, file);
  UserCheck(!self->value[PATH_ANGLE] || !self->value[PATH_FRAME], OptionsComm(),
            "%s %s: angle and q0 to q3 both say where the tip points; leave one out", option, file);
  if (self->value[PATH_FRAME]) PetscCall(Frames(option, file, self));
  PetscFunctionReturn(0);
}

/*
  PathRead - reads a path from a table, CSV or HDF5. Collective on OptionsComm(); the caller
  destroys it with PathDestroy(), also after an error. PathBegin() comes before PathAt().

  option, file  which, and the option that named it
*/
PetscErrorCode PathRead(const char *option, const char *file, Path *path) {
  Table table = NULL;
  Path self;

  PetscFunctionBegin;
  PetscCall(PetscNew(path));
  self = *path;
  PetscCall(TableReadPlain(option, file, &table));
  PetscCall(Columns(option, file, table, self));
  PetscCall(TableDestroy(&table));
  PetscCall(Check(option, file, self));
  PetscCall(PetscCalloc1(self->n, &self->turns));
  for (int k = 0; k < PATH_COLUMNS; k++) {
    if (!self->value[k]) continue;
    PetscCall(PetscMalloc1(self->n, &self->slope[k]));
    MonotoneSlopes(self->n, self->t, self->value[k], self->slope[k]);
    TurnsMark(self->n, self->value[k], 1, self->turns);
  }
  PetscFunctionReturn(0);
}

PetscErrorCode PathDestroy(Path *path) {
  PetscFunctionBegin;
  if (!*path) PetscFunctionReturn(0);
  PetscCall(PetscFree((*path)->t));
  PetscCall(PetscFree((*path)->turns));
  for (int k = 0; k < PATH_COLUMNS; k++) {
    PetscCall(PetscFree((*path)->value[k]));
    PetscCall(PetscFree((*path)->slope[k]));
  }
  PetscCall(PetscFree(*path));
  PetscFunctionReturn(0);
}

/* PathSays - does it say anything of a column? */
PetscBool PathSays(Path path, int column) {
  return (PetscBool)(path->value[column] != NULL);
}

/* PathRange - by how much a column changes; 0 if it is not said. */
PetscReal PathRange(Path path, int column) {
  PetscReal least = PETSC_MAX_REAL, most = -PETSC_MAX_REAL;

  if (!path->value[column]) return 0;
  for (PetscInt i = 0; i < path->n; i++) {
    least = PetscMin(least, path->value[column][i]);
    most = PetscMax(most, path->value[column][i]);
  }
  return most - least;
}

/* PathInSpace - does it lead out of the plane of x1 and x2? */
PetscBool PathInSpace(Path path) {
  PetscBool out = (PetscBool)(path->value[PATH_FRAME] || PathRange(path, PATH_TURN) > 0);

  for (PetscInt i = 0; i < path->n && path->value[PATH_X3]; i++)
    if (path->value[PATH_X3][i] != 0) out = PETSC_TRUE;
  return out;
}

/* PathTurnsCorner - does a tip that follows it set out or stop at once between two times? */
PetscBool PathTurnsCorner(Path path, PetscReal t0, PetscReal t1) {
  for (PetscInt i = 0; i < path->n; i += path->n - 1)
    for (int k = 0; k < PATH_COLUMNS; k++)
      if (path->t[i] >= t0 && path->t[i] < t1 && path->slope[k] && path->slope[k][i] != 0)
        return PETSC_TRUE;
  return PETSC_FALSE;
}

/* PathNextTurn - the first time behind t at which it sets out, stops or turns back, in any way;
   PETSC_MAX_REAL if it does not. */
PetscReal PathNextTurn(Path path, PetscReal t) {
  return TurnsNext(path->n, path->t, path->turns, t);
}

/* One column of a path. */
typedef struct {
  Path path;
  int column;
} Column;

/* A BendsCurve. */
static PetscErrorCode InTime(const void *table, PetscReal t, PetscReal value[], PetscReal slope[]) {
  const Column *column = (const Column *)table;
  const Path path = column->path;
  const PetscReal *f = path->value[column->column], *f_t = path->slope[column->column];

  PetscFunctionBegin;
  value[0] = MonotoneValue(path->n, path->t, f, f_t, t);
  slope[0] = MonotoneRate(path->n, path->t, f, f_t, t);
  PetscFunctionReturn(0);
}

/* PathBends - adds the times at which what it says bends (base/bends.h). */
PetscErrorCode PathBends(Path path, PetscReal tolerance, Bends *bends) {
  PetscFunctionBegin;
  for (int k = 0; k < PATH_COLUMNS; k++) {
    const Column column = {path, k};
    if (path->value[k])
      PetscCall(BendsFind(path->n, path->t, 1, InTime, &column, tolerance, bends));
  }
  PetscFunctionReturn(0);
}

PetscInt PathRows(Path path) {
  return path->n;
}

PetscReal PathTime(Path path, PetscInt row) {
  return path->t[row];
}

static PetscReal Value(const Path self, int column, PetscReal t) {
  return MonotoneValue(self->n, self->t, self->value[column], self->slope[column], t);
}

/* What the table says, in the frame of the clamp, and that of the start where it says nothing. */
static void Said(const Path self, PetscReal t, PathPlace *place) {
  const PetscReal turn = self->value[PATH_TURN] ? Value(self, PATH_TURN, t) - self->turned : 0,
                  about[4] = {PetscCosReal(turn / 2), PetscSinReal(turn / 2), 0, 0};
  const PetscReal(*lab)[3] = (const PetscReal(*)[3])self->lab;
  PetscReal x[3], q[4] = {1, 0, 0, 0}, p[4];

  for (int d = 0; d < 3; d++) {
    x[d] = Dot3(lab[d], self->start.x);
    if (self->value[PATH_X1 + d]) x[d] = Value(self, PATH_X1 + d, t);
  }
  *place = (PathPlace){.angle = self->start.angle};
  TurnBack3(lab, x, place->x);
  if (self->value[PATH_ANGLE]) {
    PetscReal angle = Value(self, PATH_ANGLE, t);
    place->angle = angle - atan2(lab[1][0], lab[0][0]);
    q[0] = PetscCosReal(angle / 2);
    q[3] = PetscSinReal(angle / 2);
  }
  for (int k = 0; k < 4 && self->value[PATH_FRAME]; k++) q[k] = Value(self, PATH_FRAME + k, t);
  if (self->value[PATH_ANGLE] || self->value[PATH_FRAME]) {
    QuaternionNormalise(q);
    QuaternionFrom(self->clamp, q, p);
  } else
    for (int k = 0; k < 4; k++) p[k] = self->start.p[k];
  QuaternionTimes(p, about, place->p);
}

/* The quaternion of a rotation. */
static void QuaternionOf(const PetscReal R[3][3], PetscReal p[4]) {
  const PetscReal trace = R[0][0] + R[1][1] + R[2][2];
  int i = R[1][1] > R[0][0] ? 1 : 0, j, k;

  if (R[2][2] > R[i][i]) i = 2;
  j = (i + 1) % 3;
  k = (i + 2) % 3;
  if (trace > R[i][i]) {
    p[0] = 1 + trace;
    p[1] = R[2][1] - R[1][2];
    p[2] = R[0][2] - R[2][0];
    p[3] = R[1][0] - R[0][1];
  } else {
    p[0] = R[k][j] - R[j][k];
    p[1 + i] = 1 + R[i][i] - R[j][j] - R[k][k];
    p[1 + j] = R[j][i] + R[i][j];
    p[1 + k] = R[k][i] + R[i][k];
  }
  QuaternionNormalise(p);
}

/*
  PathBegin - tells a path where the clamp is, and where the tip is at the start, from where it
  begins: what the two are apart fades along the path.

  lab    from the frame of the clamp to the laboratory
  start  of the tip, in the frame of the clamp
  apart  on exit the distance, the angle between the frames, and that in the plane, which are to
         be small
*/
void PathBegin(Path self, const PetscReal lab[3][3], const PathPlace *start, PetscReal apart[3]) {
  PathPlace said;
  PetscReal p[4], away = 0;

  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) self->lab[i][j] = lab[i][j];
  QuaternionOf(lab, self->clamp);
  self->start = *start;
  QuaternionNormalise(self->start.p);
  self->begin = PetscMax(0, self->t[0]);
  if (self->value[PATH_TURN]) self->turned = Value(self, PATH_TURN, self->begin);
  Said(self, self->begin, &said);
  QuaternionFrom(said.p, self->start.p, p);
  self->off.angle = start->angle - said.angle;
  for (int d = 0; d < 3; d++) {
    self->off.x[d] = start->x[d] - said.x[d];
    away += PetscSqr(self->off.x[d]);
  }
  for (int k = 0; k < 4; k++) self->off.p[k] = p[0] < 0 ? -p[k] : p[k];
  apart[0] = PetscSqrtReal(away);
  apart[1] = 2 * PetscAcosReal(PetscMin(1, PetscAbsReal(p[0])));
  apart[2] = PetscAbsReal(self->off.angle);
}

/* PathAt - where the tip is held at a time. */
void PathAt(Path self, PetscReal t, PathPlace *place) {
  const PetscReal last = self->t[self->n - 1],
                  z = PetscMax(0, PetscMin(1, (t - self->begin) / (last - self->begin))),
                  left = (1 - z) * (1 - z) * (1 + 2 * z);
  PetscReal turn[4], p[4];

  Said(self, t, place);
  place->angle += left * self->off.angle;
  for (int d = 0; d < 3; d++) place->x[d] += left * self->off.x[d];
  for (int k = 0; k < 4; k++) turn[k] = left * self->off.p[k] + (k ? 0 : 1 - left);
  QuaternionNormalise(turn);
  for (int k = 0; k < 4; k++) p[k] = place->p[k];
  QuaternionTimes(p, turn, place->p);
}

/* Are two places apart? */
static PetscBool Apart(PetscReal a, PetscReal b) {
  return (PetscBool)(PetscAbsReal(b - a) > 8 * PETSC_MACHINE_EPSILON * (1 + PetscAbsReal(a)));
}

/* PathLeads - does it move the tip along an axis of the clamp's frame, in a step that ends at a
   time? Not up to its first row, behind its last, and between two that agree. (Up to the last it
   does: a tip that stops there at once has moved until then.) */
PetscBool PathLeads(Path self, PetscReal t, int axis) {
  const PetscReal *start = self->start.x, *off = self->off.x, last = self->t[self->n - 1];
  PetscInt row = KnotBefore(self->n, self->t, t);

  if (t <= self->t[0] || (t > last && Apart(last, t))) return PETSC_FALSE;
  for (int d = 0; d < 3; d++) {
    const PetscReal *x = self->value[PATH_X1 + d];
    if (x && Apart(0, self->lab[d][axis]) && Apart(x[row], x[row + 1])) return PETSC_TRUE;
  }
  return Apart(start[axis], start[axis] + off[axis]);
}
