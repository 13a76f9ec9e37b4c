/* Planes, and surfaces of revolution: spheres, cylinders, cones, tori. These are a profile of lines
   and arcs in the half-plane of the distance rho from the axis and the place z along it, turned
   about the axis. With its signed distance phi(rho, z), of curvature b along the profile's tangent
   t, d = phi,   n = phi_rho e_rho + phi_z a,   H = b t t^T + phi_rho/rho e_theta e_theta^T. */
#include "world/surfaces.h"
#include "base/vectors.h"
#include "world/walls.h"

static const PetscReal everywhere = 1e300;

enum { MOST_PIECES = 7 };

typedef struct {
  PetscReal at[3], axis[3]; /* where z = 0, and along z */
  PetscInt pieces;
  WallPiece piece[MOST_PIECES]; /* x1 is rho, x2 is z */
} Revolved;

typedef struct {
  PetscReal at[3], normal[3];
} Plane;

/* A direction of length 1 across a, of length 1. */
static void Across(const PetscReal a[3], PetscReal e[3]) {
  int least = 0;
  PetscReal size;

  for (int d = 1; d < 3; d++)
    if (PetscAbsReal(a[d]) < PetscAbsReal(a[least])) least = d;
  size = PetscSqrtReal(1 - a[least] * a[least]);
  for (int d = 0; d < 3; d++) e[d] = ((d == least) - a[least] * a[d]) / size;
}

static PetscBool PlaneAt(const void *data, const PetscReal x[3], PetscReal within,
                         SurfacePoint *point) {
  const Plane *self = (const Plane *)data;

  *point = (SurfacePoint){.distance = 0};
  for (int d = 0; d < 3; d++) {
    point->normal[d] = self->normal[d];
    point->distance += (x[d] - self->at[d]) * self->normal[d];
  }
  return (PetscBool)(point->distance < within);
}

/* The nearest piece of the profile. */
static PetscBool ProfileAt(const Revolved *self, Vector2 y, PetscReal within, PetscReal *distance,
                           Vector2 *normal, PetscReal *bend) {
  PetscReal least = everywhere, far, b;
  Vector2 n;

  for (PetscInt k = 0; k < self->pieces; k++) {
    if (!WallPieceDistance(&self->piece[k], y, &far, &n, &b) || PetscAbsReal(far) >= least)
      continue;
    least = PetscAbsReal(far);
    *distance = far;
    *bend = b;
    *normal = n;
  }
  return (PetscBool)(least < everywhere && *distance < within);
}

static PetscBool RevolvedAt(const void *data, const PetscReal x[3], PetscReal within,
                            SurfacePoint *point) {
  const Revolved *self = (const Revolved *)data;
  const PetscReal *a = self->axis, tiny = 1e-12;
  PetscReal o[3], e[3], f[3], b = 0, around;
  Vector2 y, n = {0, 0};

  for (int d = 0; d < 3; d++) o[d] = x[d] - self->at[d];
  y.y = Dot3(o, a);
  for (int d = 0; d < 3; d++) e[d] = o[d] - y.y * a[d];
  y.x = PetscSqrtReal(Dot3(e, e));
  if (!ProfileAt(self, y, within, &point->distance, &n, &b)) return PETSC_FALSE;
  if (y.x > tiny * PetscSqrtReal(Dot3(o, o))) {
    for (int d = 0; d < 3; d++) e[d] /= y.x;
    around = n.x / y.x;
  } else { /* on the axis, where the surface is as round in all directions, or meets itself */
    Across(a, e);
    around = b;
  }
  for (int d = 0; d < 3; d++)
    f[d] = a[(d + 1) % 3] * e[(d + 2) % 3] - a[(d + 2) % 3] * e[(d + 1) % 3];
  for (int d = 0; d < 3; d++) {
    const PetscReal t = -n.y * e[d] + n.x * a[d];
    point->normal[d] = n.x * e[d] + n.y * a[d];
    for (int c = 0; c < 3; c++)
      point->bend[d][c] = b * t * (-n.y * e[c] + n.x * a[c]) + around * f[d] * f[c];
  }
  return PETSC_TRUE;
}

static PetscErrorCode FreeData(void **data) {
  PetscFunctionBegin;
  PetscCall(PetscFree(*data));
  PetscFunctionReturn(0);
}

/* ---- reading ---- */

/* The words of a line as numbers, and as text without units. form: of each word L for a length, N
   for what has no unit, S for inside or outside; what is behind a blank may be left out. */
typedef struct {
  PetscInt n; /* numbers */
  PetscReal number[10];
  PetscBool inside;
} Words;

static PetscErrorCode ReadWords(const SurfaceLine *line, const SurfaceKind *kind, const char *form,
                                Words *words, Surface *surface) {
  enum { NUMBER = 26, LONGEST = 400 };
  size_t at;
  PetscInt least = (PetscInt)strcspn(form, " "), k = 0;

  PetscFunctionBegin;
  words->n = 0;
  words->inside = PETSC_FALSE;
  PetscCall(PetscCalloc1(LONGEST, &surface->text));
  at = (size_t)snprintf(surface->text, LONGEST, "%s", kind->name);
  if (line->n - 1 < least) PetscCall(SurfaceMalformed(line, kind));
  for (; *form && k + 1 < line->n; form++) {
    const char *word = line->word[k + 1];
    if (*form == ' ') continue;
    k++;
    if (*form == 'S') {
      if (strcmp(word, "inside") && strcmp(word, "outside"))
        PetscCall(SurfaceMalformed(line, kind));
      words->inside = (PetscBool)!strcmp(word, "inside");
      at += (size_t)snprintf(surface->text + at, LONGEST - at, " %s", word);
      continue;
    }
    PetscCall(
        SurfaceNumber(line, k, *form == 'L' ? UNIT_LENGTH : UNIT_NONE, &words->number[words->n]));
    at += (size_t)snprintf(surface->text + at, LONGEST - at, " %.17g",
                           (double)words->number[words->n++]);
  }
  if (k + 1 < line->n) PetscCall(SurfaceMalformed(line, kind));
  PetscFunctionReturn(0);
}

/* Makes v of length 1. */
static PetscErrorCode Unit(const SurfaceLine *line, const char *what, const PetscReal v[3],
                           PetscReal unit[3]) {
  PetscReal size = PetscSqrtReal(Dot3(v, v));

  PetscFunctionBegin;
  UserCheck(size > 0, OptionsComm(), "-wall_file %s, line %d: the %s has no direction", line->file,
            line->line, what);
  for (int d = 0; d < 3; d++) unit[d] = v[d] / size;
  PetscFunctionReturn(0);
}

static PetscErrorCode PlaneMake(const SurfaceLine *line, Surface *surface) {
  Words words;
  Plane *self;

  PetscFunctionBegin;
  PetscCall(ReadWords(line, &surface_plane, "LLLNNN", &words, surface));
  PetscCall(PetscNew(&self));
  surface->data = self;
  PetscCall(PetscArraycpy(self->at, words.number, 3));
  PetscCall(Unit(line, "plane's normal", words.number + 3, self->normal));
  PetscFunctionReturn(0);
}

/* A line of the profile from (rho, z) on, along t, free on its left or, side -1, its right. */
static void AddLine(Revolved *self, PetscReal rho, PetscReal z, Vector2 t, PetscReal from,
                    PetscReal to, PetscReal side) {
  WallPiece *p = &self->piece[self->pieces++];

  *p = WallPieceLine((Vector2){rho, z}, t, side);
  p->from = from;
  p->to = to;
}

/* An arc of the profile about (rho, z), free outside, or, sign -1, inside; all round. */
static void AddCircle(Revolved *self, PetscReal rho, PetscReal z, PetscReal r, PetscReal sign) {
  self->piece[self->pieces++] = WallPieceCircle((Vector2){rho, z}, r, sign);
}

/* ... free outside, between two directions of length 1 that are less than half a turn apart. */
static void AddArc(Revolved *self, PetscReal rho, PetscReal z, PetscReal r, Vector2 one,
                   Vector2 other) {
  self->piece[self->pieces++] = WallPieceArc((Vector2){rho, z}, r, 1, one, other);
}

/* Directions of a profile: away from the axis, along it, against it. */
static const Vector2 out = {1, 0}, up = {0, 1}, down = {0, -1};

static PetscErrorCode RevolvedNew(Surface *surface, const PetscReal at[3], Revolved **self) {
  PetscFunctionBegin;
  PetscCall(PetscNew(self));
  surface->data = *self;
  PetscCall(PetscArraycpy((*self)->at, at, 3));
  (*self)->axis[0] = 1;
  PetscFunctionReturn(0);
}

/* The box of what is within R of the axis between z0 and z1. */
static Block BoxOf(const Revolved *self, PetscReal z0, PetscReal z1, PetscReal R) {
  Block box;
  for (int d = 0; d < 3; d++) {
    const PetscReal a = self->axis[d], beside = R * PetscSqrtReal(PetscMax(0, 1 - a * a)),
                    begin = self->at[d] + z0 * a, end = self->at[d] + z1 * a;
    box.low[d] = PetscMin(begin, end) - beside;
    box.high[d] = PetscMax(begin, end) + beside;
  }
  return box;
}

static PetscErrorCode CheckRadius(const SurfaceLine *line, PetscReal R, PetscBool inside,
                                  Surface *surface) {
  const char *what = line->word[0];

  PetscFunctionBegin;
  UserCheck(R > 0, OptionsComm(), "-wall_file %s, line %d: the radius of a %s must be above 0",
            line->file, line->line, what);
  UserCheck(!inside || R > line->radius, OptionsComm(),
            "-wall_file %s, line %d: the %s is narrower than the rod (-contact_diameter)",
            line->file, line->line, what);
  if (inside) surface->room = R - line->radius;
  PetscFunctionReturn(0);
}

static PetscErrorCode SphereMake(const SurfaceLine *line, Surface *surface) {
  Words words;
  Revolved *self;

  PetscFunctionBegin;
  PetscCall(ReadWords(line, &surface_sphere, "LLLLS", &words, surface));
  const PetscReal R = words.number[3];
  PetscCall(RevolvedNew(surface, words.number, &self));
  PetscCall(CheckRadius(line, R, words.inside, surface));
  AddCircle(self, 0, 0, R, words.inside ? -1 : 1);
  if (words.inside) PetscFunctionReturn(0);
  surface->box = BoxOf(self, 0, 0, R);
  for (int d = 0; d < 3; d++) {
    surface->box.low[d] = self->at[d] - R;
    surface->box.high[d] = self->at[d] + R;
  }
  surface->smallest = surface->core = R;
  PetscFunctionReturn(0);
}

/* Edges need a rod that is not infinitely thin. */
static PetscErrorCode CheckEdges(const SurfaceLine *line) {
  PetscFunctionBegin;
  UserCheck(
      line->radius > 0, OptionsComm(),
      "-wall_file %s, line %d: the edges of a %s need a rod that is not infinitely thin: give "
      "-contact_diameter",
      line->file, line->line, line->word[0]);
  PetscFunctionReturn(0);
}

/* The profile of what is solid within a line from (R0, 0) to (R1, L), with flat ends. */
static void AddSolid(Revolved *self, PetscReal R0, PetscReal R1, PetscReal L) {
  const Vector2 way = {R1 - R0, L}, t = Over2(way, Size2(way)), n = {t.y, -t.x};

  AddLine(self, R0, 0, t, 0, Size2(way), -1);
  AddArc(self, R0, 0, 0, n, down);
  AddArc(self, R1, L, 0, n, up);
  if (R0 > 0) AddLine(self, 0, 0, out, 0, R0, -1);
  if (R1 > 0) AddLine(self, 0, L, out, 0, R1, 1);
}

/* A ridge about the axis of a surface, its profile empty. */
static PetscErrorCode NewRidge(Surface *surface, PetscReal smallest, PetscReal beside,
                               Revolved **ridge) {
  const Revolved *of = (const Revolved *)surface->data;

  PetscFunctionBegin;
  PetscCall(PetscNew(ridge));
  surface->ridge[surface->ridges++] = (SurfaceRidge){*ridge, smallest, beside};
  PetscCall(PetscArraycpy((*ridge)->at, of->at, 3));
  PetscCall(PetscArraycpy((*ridge)->axis, of->axis, 3));
  PetscFunctionReturn(0);
}

/*
  What stands out of a solid within a line from (R0, 0) to (R1, L): the hull of the balls that touch
  it all round and its flat ends in their middle, which is round everywhere, and the edges of these
  ends. The radius of a ball, at the end of R0, is c = R0 L/(size - (R1 - R0)), size the length of
  the line. Where the solid is too short for both balls there are its edges.
*/
static PetscErrorCode AddSolidRidges(Surface *surface, PetscReal R0, PetscReal R1, PetscReal L) {
  const Vector2 way = {R1 - R0, L}, t = Over2(way, Size2(way)), n = {t.y, -t.x};
  const PetscReal size = Size2(way), c0 = R0 * L / (size - way.x), c1 = R1 * L / (size + way.x);
  const PetscBool fits = (PetscBool)(c0 + c1 < L);
  Revolved *ridge;

  PetscFunctionBegin;
  PetscCall(NewRidge(surface, 0, fits ? c0 : PETSC_MAX_REAL, &ridge));
  AddCircle(ridge, R0, 0, 0, 1);
  PetscCall(NewRidge(surface, 0, fits ? c1 : PETSC_MAX_REAL, &ridge));
  AddCircle(ridge, R1, L, 0, 1);
  if (!fits) PetscFunctionReturn(0);
  PetscCall(NewRidge(surface, PetscMin(c0, c1), PETSC_MAX_REAL, &ridge));
  AddLine(ridge, R0, 0, t, -R0 * t.x + c0 * t.y, -R0 * t.x + (L - c1) * t.y, -1);
  AddArc(ridge, 0, c0, c0, n, down);
  AddArc(ridge, 0, L - c1, c1, n, up);
  PetscFunctionReturn(0);
}

/* The profile of a hole along a line from (R0, 0) to (R1, L) through what is solid, open at its
   ends, which are rounded as a trumpet's by arcs of their own radii. */
static void AddHole(Revolved *self, PetscReal R0, PetscReal R1, PetscReal L) {
  const Vector2 way = {R1 - R0, L}, t = Over2(way, Size2(way)), n = Left2(t);

  AddLine(self, R0, 0, t, 0, Size2(way), 1);
  AddArc(self, R0 - R0 * n.x, -R0 * n.y, R0, n, down);
  AddArc(self, R1 - R1 * n.x, L - R1 * n.y, R1, n, up);
  AddLine(self, R0 - R0 * n.x, -R0 * n.y - R0, out, 0, everywhere, -1);
  AddLine(self, R1 - R1 * n.x, L - R1 * n.y + R1, out, 0, everywhere, 1);
}

static PetscErrorCode CylinderMake(const SurfaceLine *line, Surface *surface) {
  Words words;
  Revolved *self;

  PetscFunctionBegin;
  PetscCall(ReadWords(line, &surface_cylinder, "LLLNNNLS L", &words, surface));
  const PetscReal R = words.number[6], L = words.n > 7 ? words.number[7] : 0;
  PetscCall(RevolvedNew(surface, words.number, &self));
  PetscCall(Unit(line, "cylinder's axis", words.number + 3, self->axis));
  PetscCall(CheckRadius(line, R, words.inside, surface));
  if (!words.inside) surface->smallest = surface->core = R;
  if (words.n == 7) {
    AddLine(self, R, 0, up, -everywhere, everywhere, words.inside ? 1 : -1);
    PetscFunctionReturn(0);
  }
  UserCheck(L > 0, OptionsComm(), "-wall_file %s, line %d: a cylinder's length must be above 0",
            line->file, line->line);
  if (words.inside) {
    AddHole(self, R, R, L);
    surface->smallest = R;
    PetscFunctionReturn(0);
  }
  PetscCall(CheckEdges(line));
  AddSolid(self, R, R, L);
  PetscCall(AddSolidRidges(surface, R, R, L));
  surface->smallest = 0;
  surface->core = PetscMin(R, L / 2);
  surface->box = BoxOf(self, 0, L, R);
  PetscFunctionReturn(0);
}

static PetscErrorCode ConeMake(const SurfaceLine *line, Surface *surface) {
  Words words;
  Revolved *self;

  PetscFunctionBegin;
  PetscCall(ReadWords(line, &surface_cone, "LLLNNNLLLS", &words, surface));
  const PetscReal R0 = words.number[6], R1 = words.number[7], L = words.number[8];
  PetscCall(RevolvedNew(surface, words.number, &self));
  PetscCall(Unit(line, "cone's axis", words.number + 3, self->axis));
  UserCheck(R0 >= 0 && R1 >= 0 && R0 + R1 > 0 && L > 0, OptionsComm(),
            "-wall_file %s, line %d: a cone's radii must be at least 0, one of them and the length "
            "above 0",
            line->file, line->line);
  if (words.inside) {
    PetscCall(CheckRadius(line, PetscMin(R0, R1), PETSC_TRUE, surface));
    AddHole(self, R0, R1, L);
    surface->smallest = PetscMin(R0, R1);
    PetscFunctionReturn(0);
  }
  PetscCall(CheckEdges(line));
  AddSolid(self, R0, R1, L);
  PetscCall(AddSolidRidges(surface, R0, R1, L));
  surface->smallest = 0;
  surface->core = PetscMin(PetscMax(R0, R1), L) / 2;
  surface->box = BoxOf(self, 0, L, PetscMax(R0, R1));
  PetscFunctionReturn(0);
}

static PetscErrorCode TorusMake(const SurfaceLine *line, Surface *surface) {
  Words words;
  Revolved *self;

  PetscFunctionBegin;
  PetscCall(ReadWords(line, &surface_torus, "LLLNNNLLS", &words, surface));
  const PetscReal R = words.number[6], r = words.number[7];
  PetscCall(RevolvedNew(surface, words.number, &self));
  PetscCall(Unit(line, "torus's axis", words.number + 3, self->axis));
  PetscCall(CheckRadius(line, r, words.inside, surface));
  UserCheck(R > r, OptionsComm(),
            "-wall_file %s, line %d: the first radius of a torus, of its circle, must be above the "
            "second, of its tube",
            line->file, line->line);
  AddCircle(self, R, 0, r, words.inside ? -1 : 1);
  if (words.inside) {
    surface->smallest = R - r;
    PetscFunctionReturn(0);
  }
  surface->smallest = surface->core = r;
  surface->box = BoxOf(self, -r, r, R + r);
  PetscFunctionReturn(0);
}

const SurfaceKind surface_plane = {
    .name = "plane",
    .form = "plane X Y Z NX NY NZ, a point and the direction to the side of the rod",
    .make = PlaneMake,
    .at = PlaneAt,
    .destroy = FreeData};

const SurfaceKind surface_sphere = {.name = "sphere",
                                    .form = "sphere X Y Z R inside|outside",
                                    .make = SphereMake,
                                    .at = RevolvedAt,
                                    .destroy = FreeData};

const SurfaceKind surface_cylinder = {
    .name = "cylinder",
    .form = "cylinder X Y Z AX AY AZ R inside|outside, a point of the axis, its direction and the "
            "radius, and LENGTH behind them if it ends: it begins at the point",
    .make = CylinderMake,
    .at = RevolvedAt,
    .destroy = FreeData};

const SurfaceKind surface_cone = {
    .name = "cone",
    .form = "cone X Y Z AX AY AZ R1 R2 LENGTH inside|outside, from radius R1 about the point to "
            "radius R2 LENGTH along the axis",
    .make = ConeMake,
    .at = RevolvedAt,
    .destroy = FreeData};

const SurfaceKind surface_torus = {
    .name = "torus",
    .form = "torus X Y Z AX AY AZ R1 R2 inside|outside, its middle, its axis, the radius of its "
            "circle and of the tube about that",
    .make = TorusMake,
    .at = RevolvedAt,
    .destroy = FreeData};
