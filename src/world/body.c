#include "world/body.h"
#include "base/vectors.h"
#include "base/even.h"
#include "base/hdf.h"

enum { SPACE = 3 };

struct _Body {
  PetscInt n[SPACE]; /* values along x1, x2, x3 */
  PetscReal origin[SPACE], spacing[SPACE];
  PetscReal sign; /* 1: the rod is outside; -1: inside */
  PetscReal rim[SPACE],
      flare; /* over a rim along the grid's faces the surface gives way by flare */
  PetscReal core, smallest;
  MPI_Comm node; /* ranks that share the coefficients */
  MPI_Win window;
  PetscReal *c; /* [n3 + 2][n2 + 2][n1 + 2] */
};

/* ---- the spline ---- */

/* Where the coefficients of the splines at a place begin. */
static const PetscReal *Corner(const struct _Body *self, const EvenSplines e[SPACE]) {
  const PetscInt row = self->n[0] + 2, sheet = row * (self->n[1] + 2);

  return self->c + (size_t)e[SPACE - 1].first * (size_t)sheet +
         (size_t)(e[1].first * row + e[0].first);
}

/* The value of the grid's spline, the same to the last digit as Evaluate() has it: most places are
   farther from the surface than is asked, and no more of them need be known. */
static PetscReal Value(const struct _Body *self, const PetscReal at[SPACE]) {
  const PetscInt row = self->n[0] + 2, sheet = row * (self->n[1] + 2);
  PetscReal value = 0;
  EvenSplines e[SPACE];
  const PetscReal *c;

  for (int d = 0; d < SPACE; d++) (void)EvenValues(self->n[d], at[d], &e[d]);
  c = Corner(self, e);
  for (int k = 0; k < 4; k++, c += sheet) {
    PetscReal v = 0;
    for (int j = 0; j < 4; j++) {
      const PetscReal *line = c + j * row;
      PetscReal f = 0;
      for (int i = 0; i < 4; i++) f += e[0].value[i] * line[i];
      v += e[1].value[j] * f;
    }
    value += e[SPACE - 1].value[k] * v;
  }
  return value;
}

/* Of the grid's spline: value, gradient and second derivatives by grid units, one axis after the
   other; the second derivatives in the order 11, 12, 13, 22, 23, 33. */
static void Evaluate(const struct _Body *self, const PetscReal at[SPACE], PetscReal *value,
                     PetscReal slope[SPACE], PetscReal curve[6]) {
  const PetscInt row = self->n[0] + 2, sheet = row * (self->n[1] + 2);
  EvenSplines e[SPACE], *up = &e[SPACE - 1];
  const PetscReal *c;

  for (int d = 0; d < SPACE; d++) EvenEvaluate(self->n[d], at[d], &e[d]);
  c = Corner(self, e);
  *value = 0;
  for (int d = 0; d < SPACE; d++) slope[d] = 0;
  for (int k = 0; k < 6; k++) curve[k] = 0;
  for (int k = 0; k < 4; k++, c += sheet) {
    PetscReal v = 0, v1 = 0, v2 = 0, v11 = 0, v12 = 0, v22 = 0;
    for (int j = 0; j < 4; j++) {
      const PetscReal *line = c + j * row;
      PetscReal f = 0, f1 = 0, f11 = 0;
      for (int i = 0; i < 4; i++) {
        f += e[0].value[i] * line[i];
        f1 += e[0].slope[i] * line[i];
        f11 += e[0].curve[i] * line[i];
      }
      v += e[1].value[j] * f;
      v1 += e[1].value[j] * f1;
      v2 += e[1].slope[j] * f;
      v11 += e[1].value[j] * f11;
      v12 += e[1].slope[j] * f1;
      v22 += e[1].curve[j] * f;
    }
    *value += up->value[k] * v;
    slope[0] += up->value[k] * v1;
    slope[1] += up->value[k] * v2;
    slope[2] += up->slope[k] * v;
    curve[0] += up->value[k] * v11;
    curve[1] += up->value[k] * v12;
    curve[2] += up->slope[k] * v1;
    curve[3] += up->value[k] * v22;
    curve[4] += up->slope[k] * v2;
    curve[5] += up->curve[k] * v;
  }
}

/* Where the grid ends the rod must not lose a wall from one point to the next: over the rim along
   its faces, d grows by flare (depth in the rim / rim)^3, which is smooth. */
static void AddFlare(const struct _Body *self, const PetscReal x[SPACE], SurfacePoint *point) {
  for (int d = 0; d < SPACE; d++) {
    const PetscReal size = (self->n[d] - 1) * self->spacing[d], o = x[d] - self->origin[d],
                    in = self->rim[d] - PetscMin(o, size - o), z = in / self->rim[d],
                    side = o < size / 2 ? -1 : 1;
    if (in <= 0) continue;
    point->distance += self->flare * z * z * z;
    point->normal[d] += 3 * self->flare * z * z * side / self->rim[d];
    point->bend[d][d] += 6 * self->flare * z / PetscSqr(self->rim[d]);
  }
}

/*
  BodyAt - the distance of a place from the surface, above 0 where the rod may be, its gradient and
  second derivatives, if it is below `within`. Not collective.

  The gradient is that of the interpolated distance, whose length is 1 but for the grid's error.
  Returns false where it is not, and outside the grid, where there is no wall.
*/
PetscBool BodyAt(Body self, const PetscReal x[3], PetscReal within, SurfacePoint *point) {
  static const int place[SPACE][SPACE] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  PetscReal at[SPACE], value, slope[SPACE], curve[6];

  for (int d = 0; d < SPACE; d++) {
    at[d] = (x[d] - self->origin[d]) / self->spacing[d];
    if (!(at[d] >= 0 && at[d] <= self->n[d] - 1)) return PETSC_FALSE;
  }
  /* (the flare but adds to it) */
  if (self->sign * Value(self, at) >= within) return PETSC_FALSE;
  Evaluate(self, at, &value, slope, curve);
  point->distance = self->sign * value;
  for (int d = 0; d < SPACE; d++) {
    point->normal[d] = self->sign * slope[d] / self->spacing[d];
    for (int c = 0; c < SPACE; c++)
      point->bend[d][c] = self->sign * curve[place[d][c]] / (self->spacing[d] * self->spacing[c]);
  }
  AddFlare(self, x, point);
  return (PetscBool)(point->distance < within);
}

/* ---- making it ---- */

/* The coefficients along one axis: lines of n values, `stride` apart, at the places 1 .. n of n
 * + 2.
 */
static void AlongAxis(PetscInt n, size_t stride, PetscReal *first, PetscReal *work) {
  PetscReal *f = work, *c = work + n, *rest = c + n + 2;

  for (PetscInt i = 0; i < n; i++) f[i] = first[(size_t)(i + 1) * stride];
  EvenCoefficients(n, f, rest, c);
  for (PetscInt i = 0; i < n + 2; i++) first[(size_t)i * stride] = c[i];
}

/* From the values [n3][n2][n1] to the coefficients, axis by axis. */
static PetscErrorCode SetCoefficients(Body self, const PetscReal *values) {
  const PetscInt n1 = self->n[0], n2 = self->n[1], n3 = self->n[2],
                 most = PetscMax(n1, PetscMax(n2, n3));
  const size_t row = (size_t)n1 + 2, sheet = row * ((size_t)n2 + 2);
  PetscReal *work, *c = self->c;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(3 * most + 2, &work));
  for (PetscInt k = 0; k < n3; k++)
    for (PetscInt j = 0; j < n2; j++) {
      PetscReal *line = c + (size_t)(k + 1) * sheet + (size_t)(j + 1) * row;
      PetscCall(PetscArraycpy(line + 1, values, n1));
      values += n1;
      AlongAxis(n1, 1, line, work);
    }
  for (PetscInt k = 0; k < n3; k++)
    for (PetscInt i = 0; i < n1 + 2; i++) AlongAxis(n2, row, c + (size_t)(k + 1) * sheet + i, work);
  for (PetscInt j = 0; j < n2 + 2; j++)
    for (PetscInt i = 0; i < n1 + 2; i++) AlongAxis(n3, sheet, c + (size_t)j * row + i, work);
  PetscCall(PetscFree(work));
  PetscFunctionReturn(0);
}

/* Room for the coefficients, once on each machine; `first` is the rank that fills it. */
static PetscErrorCode ShareRoom(Body self, PetscBool *first) {
  MPI_Aint bytes = sizeof(PetscReal), size;
  PetscMPIInt rank;
  int unit;

  PetscFunctionBegin;
  PetscCallMPI(
      MPI_Comm_split_type(OptionsComm(), MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &self->node));
  PetscCallMPI(MPI_Comm_rank(self->node, &rank));
  *first = (PetscBool)!rank;
  for (int d = 0; d < SPACE; d++) bytes *= self->n[d] + 2;
  PetscCallMPI(MPI_Win_allocate_shared(rank ? 0 : bytes, sizeof(PetscReal), MPI_INFO_NULL,
                                       self->node, &self->c, &self->window));
  PetscCallMPI(MPI_Win_shared_query(self->window, 0, &size, &unit, &self->c));
  PetscFunctionReturn(0);
}

static PetscErrorCode CheckGrid(const struct _Body *self, const char *what, const char *file,
                                PetscReal radius) {
  PetscReal widest = PetscMax(self->spacing[0], PetscMax(self->spacing[1], self->spacing[2]));
  char text[2][64];

  PetscFunctionBegin;
  for (int d = 0; d < SPACE; d++) {
    UserCheck(self->n[d] >= EVEN_LEAST, OptionsComm(),
              "%s %s: /distance needs %d values at least along each axis", what, file, EVEN_LEAST);
    UserCheck(self->spacing[d] > 0, OptionsComm(), "%s %s: /spacing must be above 0", what, file);
  }
  UserCheck(!(radius > 0) || widest <= 2 * radius, OptionsComm(),
            "%s %s: its grid, of spacing %s, is too coarse for a rod of diameter %s: make it again "
            "with half of that or less (scripts/surface.sh --diameter)",
            what, file, OptionBoth(widest, UNIT_LENGTH, text[0]),
            OptionBoth(2 * radius, UNIT_LENGTH, text[1]));
  PetscFunctionReturn(0);
}

/* The largest eigenvalue of a symmetric matrix, by the roots of its cubic. */
static PetscReal Largest(const PetscReal a[SPACE][SPACE]) {
  const PetscReal mean = (a[0][0] + a[1][1] + a[2][2]) / 3, xy = a[0][1], xz = a[0][2],
                  yz = a[1][2], off = PetscSqr(xy) + PetscSqr(xz) + PetscSqr(yz),
                  b[SPACE] = {a[0][0] - mean, a[1][1] - mean, a[2][2] - mean},
                  row[SPACE][SPACE] = {{b[0], xy, xz}, {xy, b[1], yz}, {xz, yz, b[2]}},
                  size = PetscSqrtReal((Dot3(b, b) + 2 * off) / 6);
  PetscReal across[SPACE], half;

  if (size == 0) return mean;
  Cross3(row[1], row[2], across);
  half = Dot3(row[0], across) / (2 * size * size * size); /* the determinant */
  return mean + 2 * size * PetscCosReal(PetscAcosReal(PetscMax(-1, PetscMin(1, half))) / 3);
}

/* Is it a distance? Where the surface passes between two values the slope is about 1 on average;
   what is deepest behind the surface, and how sharply it stands out, are found on the way. */
static PetscErrorCode CheckDistance(Body self, const char *what, const char *file,
                                    const PetscReal *values) {
  const PetscReal most = 1.25;
  const size_t row = (size_t)self->n[0], sheet = row * (size_t)self->n[1];
  PetscReal sum = 0, count = 0, bend;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n[2]; k++)
    for (PetscInt j = 0; j < self->n[1]; j++)
      for (PetscInt i = 0; i < self->n[0]; i++) {
        const PetscReal *v = values + (size_t)k * sheet + (size_t)j * row + i;
        const PetscInt at[SPACE] = {i, j, k};
        PetscReal x[SPACE];
        SurfacePoint point;
        for (int d = 0; d < SPACE; d++) x[d] = self->origin[d] + at[d] * self->spacing[d];
        self->core = PetscMax(self->core, -self->sign * *v);
        if (!((i + 1 < self->n[0] && v[0] * v[1] <= 0) ||
              (j + 1 < self->n[1] && v[0] * v[row] <= 0)))
          continue;
        if (!BodyAt(self, x, PETSC_MAX_REAL, &point)) continue;
        sum += Size3(point.normal);
        count++;
        bend = Largest((const PetscReal(*)[SPACE])point.bend);
        if (bend > 0) /* of the surface, not of the one that is parallel to it here */
          self->smallest = PetscMin(self->smallest, PetscMax(0, 1 / bend - point.distance));
      }
  UserCheck(count > 0, OptionsComm(),
            "%s %s: there is no surface in it: /distance does not change its sign", what, file);
  UserCheck(sum < most * count && sum * most > count, OptionsComm(),
            "%s %s: /distance is no distance: at the surface it changes by %.3g per length, not by "
            "1; have values, /origin and /spacing the same unit?",
            what, file, (double)(sum / count));
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadSmall(const char *what, const char *file, const char *name,
                                PetscReal v[SPACE]) {
  PetscReal *data;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(HdfReadQuantity(what, file, name, UNIT_LENGTH, 1, &n, &data));
  for (int d = 0; d < SPACE && (n == 1 || n == SPACE); d++) v[d] = data[n == 1 ? 0 : d];
  PetscCall(PetscFree(data));
  UserCheck(n == 1 || n == SPACE, OptionsComm(), "%s %s: %s must be [3]", what, file, name);
  PetscFunctionReturn(0);
}

static PetscErrorCode Prepare(Body self, const char *what, const char *file, PetscReal radius,
                              const PetscReal *values) {
  const PetscInt cells = 3;
  PetscBool first = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(CheckGrid(self, what, file, radius));
  PetscCall(ShareRoom(self, &first));
  if (first) PetscCall(SetCoefficients(self, values));
  PetscCallMPI(MPI_Win_fence(0, self->window));
  for (int d = 0; d < SPACE; d++) self->rim[d] = 1e-300; /* none yet */
  PetscCall(CheckDistance(self, what, file, values));
  for (int d = 0; d < SPACE; d++) {
    self->rim[d] = PetscMin(PetscMax(cells * self->spacing[d], 2 * radius),
                            (self->n[d] - 1) * self->spacing[d] / 4);
    self->flare = PetscMax(self->flare, PetscMin(self->rim[d], 2 * radius) / 2);
  }
  PetscFunctionReturn(0);
}

/*
  BodyRead - a body from a file of HDF5: /distance [n3, n2, n1], below 0 within the body; /origin
  [3], where the first value is; /spacing [3], or [1]. Each has no dimension, or that of its
  attribute `units`. Collective on OptionsComm(): rank 0 reads, the ranks of a machine share; the
  caller destroys it with BodyDestroy(), also after an error.

  what    names it where it is refused, before the file's name
  inside  is the rod?
  radius  of the rod

  A grid that is too coarse for the rod, or holds no distance, is a user's mistake.
*/
PetscErrorCode BodyRead(const char *what, const char *file, PetscBool inside, PetscReal radius,
                        Body *body) {
  PetscErrorCode error;
  PetscReal *values;
  PetscInt dims[SPACE];
  Body self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *body = self;
  self->node = MPI_COMM_NULL;
  self->window = MPI_WIN_NULL;
  self->sign = inside ? -1 : 1;
  self->smallest = PETSC_MAX_REAL;
  PetscCall(ReadSmall(what, file, "/origin", self->origin));
  PetscCall(ReadSmall(what, file, "/spacing", self->spacing));
  PetscCall(HdfReadQuantity(what, file, "/distance", UNIT_LENGTH, SPACE, dims, &values));
  for (int d = 0; d < SPACE; d++) self->n[d] = dims[SPACE - 1 - d];
  error = Prepare(self, what, file, radius, values);
  PetscCall(PetscFree(values));
  PetscCall(error);
  PetscFunctionReturn(0);
}

PetscErrorCode BodyDestroy(Body *body) {
  Body self = *body;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  if (self->window != MPI_WIN_NULL) PetscCallMPI(MPI_Win_free(&self->window));
  if (self->node != MPI_COMM_NULL) PetscCallMPI(MPI_Comm_free(&self->node));
  PetscCall(PetscFree(*body));
  PetscFunctionReturn(0);
}

/* BodyBox - the grid. */
Block BodyBox(Body self) {
  Block box;

  for (int d = 0; d < SPACE; d++) {
    box.low[d] = self->origin[d];
    box.high[d] = self->origin[d] + (self->n[d] - 1) * self->spacing[d];
  }
  return box;
}

/* BodySmallest - where its surface stands out, the least radius of curvature. */
PetscReal BodySmallest(Body self) {
  return self->smallest;
}

/* BodyCore - the depth of the deepest place behind its surface. */
PetscReal BodyCore(Body self) {
  return self->core;
}
