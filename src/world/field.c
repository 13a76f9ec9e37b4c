#include "world/field.h"
#include "base/vectors.h"
#include "base/band.h"
#include "base/bspline.h"
#include "base/hdf.h"
#include "base/hermite.h"
#include "base/knots.h"
#include "base/turns.h"

/* A table is interpolated by a cubic spline (C2) in each of t, x3, x2 and x1, with slope 0 at both
   ends, so that it goes on beyond its edges as a constant without a kink. Its coefficients are
   those of B-splines: n knots have n + 2, of which the first two and the last two are equal. */
enum { TIME, HIGH, ACROSS, ALONG, AXES };

typedef struct {
  PetscInt n;    /* knots; 1: nothing varies along this axis */
  PetscReal *at; /* their places */
} Axis;

struct _Field {
  /* layers along x1: factor[k] from start[k] on, joined over width */
  PetscInt layers;
  PetscReal *start, *factor, width;
  /* or a table */
  Axis axis[AXES];
  PetscReal *c;     /* coefficients [t][x3][x2][x1] */
  PetscBool *turns; /* at which times, at any place (base/turns.h) */
};

/* How many coefficients an axis has. */
static PetscInt Size(const Axis *axis) {
  return axis->n > 1 ? axis->n + 2 : 1;
}

/* ---- layers ---- */

static PetscErrorCode BadLayers(const char *option, const char *text) {
  PetscFunctionBegin;
  UserCheck(PETSC_FALSE, OptionsComm(),
            "%s %s: give START:FACTOR,START:FACTOR,... with starts that increase and factors of at "
            "least 0",
            option, text);
  PetscFunctionReturn(0);
}

/*
  FieldFromLayers - a factor in layers along x1, from "0:1,3:2.5,6:0.4": the start of each layer and
  its factor; the first goes on to the left. Collective on OptionsComm(); the caller destroys it.

  width  neighbours are joined over this length, smoothly (C2), half of it on either side
*/
PetscErrorCode FieldFromLayers(const char *option, const char *text, PetscReal width,
                               Field *field) {
  const char *at = text;
  PetscInt n = 1;
  Field self;

  PetscFunctionBegin;
  for (const char *c = text; *c; c++) n += *c == ',';
  PetscCall(PetscNew(&self));
  *field = self;
  self->width = width;
  PetscCall(PetscMalloc2(n, &self->start, n, &self->factor));
  for (PetscInt k = 0; k < n; k++) {
    size_t length = strcspn(at, ",");
    char layer[80], *colon;
    if (length == 0 || length >= sizeof(layer)) PetscCall(BadLayers(option, text));
    PetscCall(PetscStrncpy(layer, at, length + 1));
    colon = strchr(layer, ':');
    if (!colon) PetscCall(BadLayers(option, text));
    *colon = 0;
    PetscCall(OptionQuantity(option, layer, UNIT_LENGTH, &self->start[k]));
    PetscCall(OptionQuantity(option, colon + 1, UNIT_NONE, &self->factor[k]));
    if (self->factor[k] < 0 || (k && self->start[k] <= self->start[k - 1]))
      PetscCall(BadLayers(option, text));
    UserCheck(!k || self->start[k] - self->start[k - 1] >= width || k == 1, OptionsComm(),
              "%s %s: a layer is thinner than the width over which layers are joined; lower "
              "-friction_layer_width",
              option, text);
    at += length + 1;
  }
  self->layers = n;
  PetscFunctionReturn(0);
}

/* The smooth step from 0 to 1 between -1/2 and 1/2 with two derivatives, and its slope. */
static PetscReal SmoothStep(PetscReal u, PetscReal *slope) {
  PetscReal z = PetscMax(0, PetscMin(1, u + 0.5));
  *slope = HermiteRiseSlope(z);
  return HermiteRise(z);
}

static void LayersAt(Field self, PetscReal x1, PetscReal *factor, PetscReal slope[3]) {
  *factor = self->factor[0];
  Zero3(slope);
  for (PetscInt k = 1; k < self->layers; k++) {
    PetscReal step, rise = self->factor[k] - self->factor[k - 1];
    *factor += rise * SmoothStep((x1 - self->start[k]) / self->width, &step);
    slope[0] += rise * step / self->width;
  }
}

/* ---- tables ---- */

/* The coefficients of the splines along one axis: from values [before][n][after] to
   [before][n + 2][after]. */
static PetscErrorCode Interpolate(const Axis *axis, PetscInt before, PetscInt after,
                                  const PetscReal *values, PetscReal **c) {
  PetscInt n = axis->n, m = Size(axis);
  PetscReal *b;
  BSplines splines;
  Band A;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(before * m * after, c));
  if (n == 1) {
    PetscCall(PetscArraycpy(*c, values, before * after));
    PetscFunctionReturn(0);
  }
  PetscCall(BandCreate(m, 2, 2, &A));
  for (PetscInt i = 0; i < n; i++) { /* values at the knots: rows 1 .. n */
    PetscInt cell = PetscMin(i, n - 2);
    BSplineEvaluate(n - 1, axis->at, cell, axis->at[i], &splines);
    for (PetscInt k = 0; k <= CUBIC; k++)
      if (splines.value[CUBIC][k] != 0) *BandAt(&A, i + 1, cell + k) = splines.value[CUBIC][k];
  }
  *BandAt(&A, 0, 0) = *BandAt(&A, m - 1, m - 1) = 1; /* slope 0 at the ends */
  *BandAt(&A, 0, 1) = *BandAt(&A, m - 1, m - 2) = -1;
  PetscCall(BandFactor(&A));
  PetscCall(PetscMalloc1(m, &b));
  for (PetscInt i = 0; i < before; i++)
    for (PetscInt j = 0; j < after; j++) {
      b[0] = b[m - 1] = 0;
      for (PetscInt k = 0; k < n; k++) b[k + 1] = values[(i * n + k) * after + j];
      PetscCall(BandSolve(&A, PETSC_FALSE, 1, b));
      for (PetscInt k = 0; k < m; k++) (*c)[(i * m + k) * after + j] = b[k];
    }
  PetscCall(PetscFree(b));
  PetscCall(BandDestroy(&A));
  PetscFunctionReturn(0);
}

/* The splines that are not 0 at a place: which is the first, how many, their values and slopes. */
typedef struct {
  PetscInt first, n;
  PetscReal value[CUBIC + 1], slope[CUBIC + 1];
} Weights;

static void WeightsAt(const Axis *axis, PetscReal at, Weights *w) {
  PetscInt low;
  BSplines splines;

  w->first = 0;
  w->n = 1;
  w->value[0] = 1;
  w->slope[0] = 0;
  if (axis->n == 1) return;
  if (at <= axis->at[0] || at >= axis->at[axis->n - 1]) { /* constant beyond */
    if (at > axis->at[0]) w->first = axis->n + 1;
    return;
  }
  low = KnotBefore(axis->n, axis->at, at);
  BSplineEvaluate(axis->n - 1, axis->at, low, at, &splines);
  w->first = low;
  w->n = CUBIC + 1;
  for (int k = 0; k <= CUBIC; k++) {
    w->value[k] = splines.value[CUBIC][k];
    w->slope[k] = splines.slope[CUBIC][k];
  }
}

static void TableAt(Field self, const PetscReal x[3], PetscReal t, PetscReal *factor,
                    PetscReal slope[3]) {
  const PetscReal at[AXES] = {t, x[2], x[1], x[0]};
  PetscInt m[AXES];
  Weights w[AXES];

  for (int a = 0; a < AXES; a++) {
    m[a] = Size(&self->axis[a]);
    WeightsAt(&self->axis[a], at[a], &w[a]);
  }
  *factor = 0;
  Zero3(slope);
  for (PetscInt i = 0; i < w[TIME].n * w[HIGH].n; i++) {
    const PetscInt in_time = i / w[HIGH].n, high = i % w[HIGH].n;
    const PetscReal both = w[TIME].value[in_time] * w[HIGH].value[high];
    for (PetscInt j = 0; j < w[ACROSS].n; j++) {
      const PetscReal *row =
          self->c +
          (((w[TIME].first + in_time) * m[HIGH] + w[HIGH].first + high) * m[ACROSS] +
           w[ACROSS].first + j) *
              m[ALONG] +
          w[ALONG].first;
      PetscReal value = 0, along = 0;
      for (PetscInt k = 0; k < w[ALONG].n; k++) {
        value += w[ALONG].value[k] * row[k];
        along += w[ALONG].slope[k] * row[k];
      }
      *factor += both * w[ACROSS].value[j] * value;
      slope[0] += both * w[ACROSS].value[j] * along;
      slope[1] += both * w[ACROSS].slope[j] * value;
      slope[2] += w[TIME].value[in_time] * w[HIGH].slope[high] * w[ACROSS].value[j] * value;
    }
  }
}

/* FieldInSpace - does it vary over x3? */
PetscBool FieldInSpace(Field self) {
  return (PetscBool)(self && self->axis[HIGH].n > 1);
}

static PetscErrorCode ReadAxis(const char *option, const char *file, const char *name,
                               Dimension dimension, Axis *axis) {
  PetscFunctionBegin;
  PetscCall(HdfReadQuantity(option, file, name, dimension, 1, &axis->n, &axis->at));
  UserCheck(axis->n == 1 || axis->n >= 3, OptionsComm(), "%s %s: %s needs 1 entry, or 3 at least",
            option, file, name);
  for (PetscInt i = 1; i < axis->n; i++)
    UserCheck(axis->at[i] > axis->at[i - 1], OptionsComm(), "%s %s: %s must increase", option, file,
              name);
  PetscFunctionReturn(0);
}

/* Splines may dip below 0 between entries that do not: looks at a few places between each two. */
static PetscErrorCode CheckSign(const char *option, const char *file, Field self) {
  enum { PLACES = 2 };
  PetscInt count[AXES], total = 1;
  char text[4][64];

  PetscFunctionBegin;
  for (int a = 0; a < AXES; a++)
    total *= count[a] = self->axis[a].n > 1 ? PLACES * (self->axis[a].n - 1) + 1 : 1;
  for (PetscInt k = 0; k < total; k++) {
    PetscInt place[AXES] = {k / (count[HIGH] * count[ACROSS] * count[ALONG]),
                            k / (count[ACROSS] * count[ALONG]) % count[HIGH],
                            k / count[ALONG] % count[ACROSS], k % count[ALONG]};
    PetscReal at[AXES], factor, slope[3];
    for (int a = 0; a < AXES; a++) {
      const Axis *axis = &self->axis[a];
      PetscInt i = PetscMin(place[a] / PLACES, axis->n - 2);
      PetscReal z = (PetscReal)(place[a] - i * PLACES) / PLACES;
      at[a] = axis->n > 1 ? (1 - z) * axis->at[i] + z * axis->at[i + 1] : 0;
    }
    TableAt(self, (PetscReal[]){at[ALONG], at[ACROSS], at[HIGH]}, at[TIME], &factor, slope);
    UserCheck(
        factor >= -1e-12, OptionsComm(),
        "%s %s: the factor is %s at x1 = %s, x2 = %s, t = %s; it must not fall below 0, between "
        "the entries neither (give more of them where it changes)",
        option, file, OptionNumber(factor, text[0]), OptionBoth(at[ALONG], UNIT_LENGTH, text[1]),
        OptionBoth(at[ACROSS], UNIT_LENGTH, text[2]), OptionBoth(at[TIME], UNIT_TIME, text[3]));
  }
  PetscFunctionReturn(0);
}

/* From the values [nt][n3][n2][n1] to the coefficients, axis by axis. */
static PetscErrorCode SetValues(Field self, const PetscReal *values) {
  const Axis *axis = self->axis;
  PetscReal *along, *across, *high;

  PetscFunctionBegin;
  PetscCall(
      Interpolate(&axis[ALONG], axis[TIME].n * axis[HIGH].n * axis[ACROSS].n, 1, values, &along));
  PetscCall(
      Interpolate(&axis[ACROSS], axis[TIME].n * axis[HIGH].n, Size(&axis[ALONG]), along, &across));
  PetscCall(Interpolate(&axis[HIGH], axis[TIME].n, Size(&axis[ACROSS]) * Size(&axis[ALONG]), across,
                        &high));
  PetscCall(Interpolate(&axis[TIME], 1,
                        Size(&axis[HIGH]) * Size(&axis[ACROSS]) * Size(&axis[ALONG]), high,
                        &self->c));
  PetscCall(PetscFree(along));
  PetscCall(PetscFree(across));
  PetscCall(PetscFree(high));
  PetscFunctionReturn(0);
}

/* When values [nt][...] set out, stop or turn back. */
static PetscErrorCode FindTurns(Field self, PetscInt places, const PetscReal *values) {
  PetscFunctionBegin;
  PetscCall(PetscCalloc1(self->axis[TIME].n, &self->turns));
  for (PetscInt k = 0; k < places; k++)
    TurnsMark(self->axis[TIME].n, values + k, places, self->turns);
  PetscFunctionReturn(0);
}

/*
  FieldFromFile - a factor from a table in HDF5: /x1 [n1], /x2 [n2], if it changes with x3, too,
  /x3 [n3] and, if it changes in time, /t [nt]; /factor [n2, n1], [n3, n2, n1], with [nt, ...]
  before them. An axis along which nothing changes has one entry. Collective on OptionsComm(); the
  caller destroys it, also after an error.

  Places and times have no dimension, or that of their attribute `units`.
*/
PetscErrorCode FieldFromFile(const char *option, const char *file, Field *field) {
  PetscReal *values = NULL;
  PetscInt dims[AXES];
  PetscErrorCode error;
  PetscBool timed, high;
  PetscInt first;
  Field self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *field = self;
  PetscCall(ReadAxis(option, file, "/x1", UNIT_LENGTH, &self->axis[ALONG]));
  PetscCall(ReadAxis(option, file, "/x2", UNIT_LENGTH, &self->axis[ACROSS]));
  self->axis[TIME].n = self->axis[HIGH].n = 1;
  PetscCall(HdfHas(file, "/t", &timed));
  if (timed) PetscCall(ReadAxis(option, file, "/t", UNIT_TIME, &self->axis[TIME]));
  PetscCall(HdfHas(file, "/x3", &high));
  if (high) PetscCall(ReadAxis(option, file, "/x3", UNIT_LENGTH, &self->axis[HIGH]));
  first = timed + high;
  PetscCall(HdfReadQuantity(option, file, "/factor", UNIT_NONE, (int)first + 2, dims, &values));
  if ((timed && dims[0] != self->axis[TIME].n) || (high && dims[timed] != self->axis[HIGH].n) ||
      dims[first] != self->axis[ACROSS].n || dims[first + 1] != self->axis[ALONG].n) {
    PetscCall(PetscFree(values));
    UserCheck(PETSC_FALSE, OptionsComm(),
              "%s %s: /factor must be [%s%s%d, %d] as %s%s/x2 and /x1 are long", option, file,
              timed ? "nt, " : "", high ? "n3, " : "", (int)self->axis[ACROSS].n,
              (int)self->axis[ALONG].n, timed ? "/t, " : "", high ? "/x3, " : "");
  }
  error = SetValues(self, values);
  if (!error && timed)
    error =
        FindTurns(self, self->axis[HIGH].n * self->axis[ACROSS].n * self->axis[ALONG].n, values);
  PetscCall(PetscFree(values));
  PetscCall(error);
  PetscCall(CheckSign(option, file, self));
  PetscFunctionReturn(0);
}

PetscErrorCode FieldDestroy(Field *field) {
  Field self = *field;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(PetscFree2(self->start, self->factor));
  for (int a = 0; a < AXES; a++) PetscCall(PetscFree(self->axis[a].at));
  PetscCall(PetscFree(self->c));
  PetscCall(PetscFree(self->turns));
  PetscCall(PetscFree(*field));
  PetscFunctionReturn(0);
}

/* FieldIsLayered - does it come from layers, not from a table? */
PetscBool FieldIsLayered(Field self) {
  return (PetscBool)(self->layers > 0);
}

/* FieldFinest - the length over which it changes no farther than so from 0: that over which layers
   are joined, the least distance of a table's entries in space; 0 if it does not change. */
PetscReal FieldFinest(Field self, PetscReal reach) {
  PetscReal least = PETSC_MAX_REAL;

  for (PetscInt k = 1; k < self->layers; k++)
    if (PetscAbsReal(self->start[k]) - self->width / 2 < reach) least = self->width;
  for (int a = HIGH; a <= ALONG; a++)
    for (PetscInt i = 0; i + 1 < self->axis[a].n; i++) {
      const PetscReal *at = &self->axis[a].at[i];
      if (at[0] < reach && at[1] > -reach) least = PetscMin(least, at[1] - at[0]);
    }
  return least < PETSC_MAX_REAL ? least : 0;
}

/* FieldNextTurn - the first time behind t at which it sets out, stops or turns back anywhere;
   PETSC_MAX_REAL if it does not. */
PetscReal FieldNextTurn(Field self, PetscReal t) {
  if (!self->turns) return PETSC_MAX_REAL;
  return TurnsNext(self->axis[TIME].n, self->axis[TIME].at, self->turns, t);
}

/* A table as it goes along one of its axes. */
typedef struct {
  Field field;
  int axis;
  PetscInt before, after; /* coefficients of the axes before and behind it */
} Section;

/* A BendsCurve: what the splines of all other axes are multiplied by. */
static PetscErrorCode AlongAxis(const void *table, PetscReal at, PetscReal value[],
                                PetscReal slope[]) {
  const Section *section = (const Section *)table;
  const Field field = section->field;
  const PetscInt size = Size(&field->axis[section->axis]);
  Weights w;

  PetscFunctionBegin;
  WeightsAt(&field->axis[section->axis], at, &w);
  for (PetscInt i = 0; i < section->before; i++)
    for (PetscInt j = 0; j < section->after; j++) {
      PetscReal f = 0, f_x = 0;
      for (PetscInt k = 0; k < w.n; k++) {
        const PetscReal c = field->c[(i * size + w.first + k) * section->after + j];
        f += w.value[k] * c;
        f_x += w.n > 1 ? w.slope[k] * c : 0;
      }
      value[i * section->after + j] = f;
      slope[i * section->after + j] = f_x;
    }
  PetscFunctionReturn(0);
}

static PetscErrorCode BendsOf(Field self, int axis, PetscReal tolerance, Bends *bends) {
  Section section = {.field = self, .axis = axis, .before = 1, .after = 1};

  PetscFunctionBegin;
  if (self->axis[axis].n < 2) PetscFunctionReturn(0);
  for (int a = 0; a < AXES; a++) {
    if (a < axis) section.before *= Size(&self->axis[a]);
    if (a > axis) section.after *= Size(&self->axis[a]);
  }
  PetscCall(BendsFind(self->axis[axis].n, self->axis[axis].at, section.before * section.after,
                      AlongAxis, &section, tolerance, bends));
  PetscFunctionReturn(0);
}

/* FieldBendsInTime - adds the times at which it bends anywhere (base/bends.h). */
PetscErrorCode FieldBendsInTime(Field self, PetscReal tolerance, Bends *bends) {
  PetscFunctionBegin;
  if (!self->layers) PetscCall(BendsOf(self, TIME, tolerance, bends));
  PetscFunctionReturn(0);
}

/* FieldBendsAlong - adds the places along x1, x2 or x3, axis 0 to 2, at which it bends; of layers
   also places within what joins them. */
PetscErrorCode FieldBendsAlong(Field self, int axis, PetscReal tolerance, Bends *bends) {
  enum { PARTS = 8 };
  const int at[] = {ALONG, ACROSS, HIGH};

  PetscFunctionBegin;
  if (!self->layers) {
    PetscCall(BendsOf(self, at[axis], tolerance, bends));
    PetscFunctionReturn(0);
  }
  for (PetscInt k = 1; k < self->layers && axis == 0; k++)
    for (int i = 0; i <= PARTS; i++)
      PetscCall(BendsAdd(bends, self->start[k] + self->width * ((PetscReal)i / PARTS - 0.5)));
  PetscFunctionReturn(0);
}

/* FieldAt - the factor at a place (in the laboratory) and a time, and its derivatives by x1, x2,
   x3. */
void FieldAt(Field self, const PetscReal x[3], PetscReal t, PetscReal *factor, PetscReal slope[3]) {
  if (self->layers)
    LayersAt(self, x[0], factor, slope);
  else
    TableAt(self, x, t, factor, slope);
}
