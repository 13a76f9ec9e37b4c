#include "world/walls.h"
#include "base/text.h"
#include <ctype.h>

const char *const wall_kind[WALL_KINDS] = {"plane", "circle", "polygon", "path"};

/* What each kind is given by, for who has it wrong. */
static const char *const wall_form[WALL_KINDS] = {
    "plane X1 X2 N1 N2, a point and the direction to the side of the rod",
    "circle X1 X2 R outside|inside", "polygon outside|inside X1 Y1 X2 Y2 X3 Y3 ...",
    "path R X1 Y1 X2 Y2 ..., a conduit of radius R along these points, and radius B behind them if "
    "its bends are to have that"};

/* The surface in space that a wall of the plane is, upright along x3. */
static const char *const wall_in_space[WALL_KINDS] = {
    "plane X1 X2 0 N1 N2 0", "cylinder X1 X2 0 0 0 1 R outside|inside", "body FILE outside|inside",
    "tube FILE inside"};

static const PetscReal everywhere = 1e300;

/* ---- making the pieces ---- */

/* What a wall is made from. */
typedef struct {
  const char *file;
  int line;         /* of the file */
  PetscReal radius; /* of the rod */
  Vector2 turn;     /* cosine and sine of the clamp's angle */
  Wall *wall;
} Maker;

/* Numbers k, k + 1 of the wall, a place or direction of the laboratory, in the clamp's frame. */
static Vector2 PlaceOf(const Maker *self, PetscInt k) {
  const Vector2 a = From2(self->wall->number + k);

  return (Vector2){Dot2(self->turn, a), Cross2(self->turn, a)};
}

/* A line from a on, of this length, free on its left side (1) or right side (-1), moved by `off`
   against it. */
static WallPiece *AddLine(Wall *wall, Vector2 a, Vector2 t, PetscReal length, PetscReal side,
                          PetscReal off) {
  WallPiece *p = &wall->piece[wall->pieces++];

  *p = WallPieceLine(a, t, side);
  p->at = Along2(a, -off, p->n);
  p->to = length;
  return p;
}

/* An arc about c, between two directions less than half a turn apart. */
static WallPiece *AddArc(Wall *wall, Vector2 c, PetscReal r, PetscReal sign, Vector2 one,
                         Vector2 other) {
  WallPiece *p = &wall->piece[wall->pieces++];

  *p = WallPieceArc(c, r, sign, one, other);
  return p;
}

static PetscErrorCode MakePlane(Maker *self) {
  const Vector2 n = PlaceOf(self, 2);
  const PetscReal size = Size2(n);
  WallPiece *p;

  PetscFunctionBegin;
  UserCheck(size > 0, OptionsComm(), "-wall_file %s, line %d: the plane's normal is 0", self->file,
            self->line);
  p = AddLine(self->wall, PlaceOf(self, 0), (Vector2){n.y / size, -n.x / size}, everywhere, 1, 0);
  p->from = -everywhere;
  PetscFunctionReturn(0);
}

static PetscErrorCode MakeCircle(Maker *self) {
  const PetscReal r = self->wall->number[2];

  PetscFunctionBegin;
  UserCheck(r > 0, OptionsComm(), "-wall_file %s, line %d: a circle's radius must be above 0",
            self->file, self->line);
  UserCheck(!self->wall->inside || r > self->radius, OptionsComm(),
            "-wall_file %s, line %d: the circle is narrower than the rod (-contact_diameter)",
            self->file, self->line);
  self->wall->piece[self->wall->pieces++] =
      WallPieceCircle(PlaceOf(self, 0), r, self->wall->inside ? -1 : 1);
  PetscFunctionReturn(0);
}

/* The unit vector from one place to another; its length is returned. */
static PetscReal Direction(Vector2 a, Vector2 b, Vector2 *t) {
  const Vector2 way = Minus2(b, a);
  const PetscReal size = Size2(way);

  *t = size > 0 ? Over2(way, size) : (Vector2){0, 0};
  return size;
}

/* Twice the area of a polygon, positive if it runs to the left. */
static PetscReal Area(const Maker *self, PetscInt from, PetscInt n) {
  PetscReal sum = 0;

  for (PetscInt k = 0; k < n; k++)
    sum += Cross2(PlaceOf(self, from + 2 * k), PlaceOf(self, from + 2 * ((k + 1) % n)));
  return sum;
}

/* Do two edges of a polygon cross? */
static PetscBool EdgesCross(const Maker *self, PetscInt n, PetscInt i, PetscInt j) {
  const Vector2 a = PlaceOf(self, 2 * i), c = PlaceOf(self, 2 * j), o = Minus2(c, a),
                r = Minus2(PlaceOf(self, 2 * ((i + 1) % n)), a),
                q = Minus2(PlaceOf(self, 2 * ((j + 1) % n)), c);
  const PetscReal det = Cross2(r, q), u = Cross2(o, q) / det, w = Cross2(o, r) / det;

  return (PetscBool)(det != 0 && u >= 0 && u <= 1 && w >= 0 && w <= 1);
}

static PetscErrorCode CheckPolygon(Maker *self, PetscInt n) {
  PetscReal area = Area(self, 0, n);

  PetscFunctionBegin;
  UserCheck(self->radius > 0, OptionsComm(),
            "-wall_file %s, line %d: a polygon's corners need a rod that is not infinitely thin: "
            "give -contact_diameter",
            self->file, self->line);
  UserCheck(area != 0, OptionsComm(), "-wall_file %s, line %d: the polygon has no area", self->file,
            self->line);
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = i + 2; j < n; j++)
      UserCheck((i == 0 && j == n - 1) || !EdgesCross(self, n, i, j), OptionsComm(),
                "-wall_file %s, line %d: the polygon crosses itself", self->file, self->line);
  PetscFunctionReturn(0);
}

/* An edge of a polygon, and the corner at its end. */
typedef struct {
  Vector2 at, t;
  PetscReal length;
  PetscReal turn; /* at its end: above 0 where the corner is hollow */
  PetscReal r;    /* of the arc there; 0: there is none */
  PetscReal before,
      behind; /* of its two ends, how much does not press; below 0: it presses beyond */
} Edge;

static PetscErrorCode MeasureEdges(const Maker *self, PetscInt n, PetscReal side, Edge edge[]) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) {
    edge[k] = (Edge){.at = PlaceOf(self, 2 * k)};
    edge[k].length = Direction(edge[k].at, PlaceOf(self, 2 * ((k + 1) % n)), &edge[k].t);
    UserCheck(edge[k].length > 0, OptionsComm(),
              "-wall_file %s, line %d: two of its points are the same", self->file, self->line);
  }
  for (PetscInt k = 0; k < n; k++) {
    const Vector2 t = edge[k].t, u = edge[(k + 1) % n].t;
    edge[k].turn = side * PetscAtan2Real(Cross2(t, u), Dot2(t, u));
  }
  PetscFunctionReturn(0);
}

/* Soft contact is felt so far from the rod's surface, and a jammed rod is pressed in so far, over
   its radius. */
static const PetscReal felt = 0.5, pressed = 0.4;

/*
  How far beyond a hollow corner an edge is felt by a rod that slides along the next: where this is

    (1 - pressed) R = (1 + felt) R cos(turn) - z sin(turn)

  from the rod's middle, which is (1 + felt) R from this one, z beyond it. If it ended before, the
  force of it would be gone at once, and a tip, or a node, would find no rest there: gentle corners,
  pressed deep, or in soft contact.
*/
static PetscReal FeltBeyond(PetscReal R, PetscReal turn) {
  return PetscMax(0, R * ((1 + felt) * PetscCosReal(turn) - (1 - pressed)) / PetscSinReal(turn));
}

/* ... but no farther than the walls behind that corner go on to be hollow. way: 1 beyond the end of
   edge k, -1 beyond its beginning. */
static PetscReal PressesBeyond(PetscReal R, PetscInt n, const Edge edge[], PetscInt k, int way) {
  PetscInt corner = way > 0 ? k : (k + n - 1) % n, next = (k + n + way) % n;
  PetscReal turned = edge[corner].turn, reach = 0;
  const PetscReal most = FeltBeyond(R, turned);

  for (PetscInt seen = 1; seen < n && reach < most; seen++) {
    reach += edge[next].length * PetscCosReal(turned);
    corner = (corner + n + way) % n;
    next = (next + n + way) % n;
    turned += edge[corner].turn;
    if (edge[corner].turn <= 0 || FeltBeyond(R, turned) == 0) break;
  }
  return PetscMin(most, reach);
}

/*
  The arc of a gentle hollow corner. Rounded by r it is filled up by r turn^2/8: a thousandth of
  the rod's diameter D or, if this asks for less than r = D, with that. So points along a curve give
  the curve, and what slides along meets one wall after the other, with the same normal. Where
  edges are too short for a rod to roll along such an arc there is none.
*/
static void RoundCorner(PetscReal R, Edge *edge, const Edge *next) {
  const PetscReal gentle = 9 * PETSC_PI / 180, straight = 1e-5, part = 1e-3, narrow = 1.2,
                  wide = 1e3, D = 2 * R, turn = edge->turn, half = PetscTanReal(turn / 2),
                  room = PetscMin(edge->length, next->length) / (2 * half);
  PetscReal r;

  if (turn > gentle || turn < straight) return;
  r = PetscMax(1, PetscMin(wide, 8 * part / (turn * turn))) * D;
  r = PetscMin(r, room);
  if (r >= narrow * R) edge->r = r;
}

/* What of the edges presses at a hollow corner. */
static void CutEdges(PetscReal R, PetscInt n, Edge edge[]) {
  const PetscReal straight = 1e-5;

  for (PetscInt k = 0; k < n; k++)
    if (edge[k].turn > 0) RoundCorner(R, &edge[k], &edge[(k + 1) % n]);
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt next = (k + 1) % n;
    const PetscReal turn = edge[k].turn;
    if (turn <= 0) continue;
    if (edge[k].r > 0 || turn < straight) /* they go over into the arc, or into each other */
      edge[k].behind = edge[next].before = (edge[k].r > 0 ? edge[k].r : R) * PetscTanReal(turn / 2);
    else {
      edge[k].behind = -PressesBeyond(R, n, edge, k, 1);
      edge[next].before = -PressesBeyond(R, n, edge, next, -1);
    }
  }
}

/* The arc of a corner between two edges; side: 1 the rod is on their left. */
static void AddCornerArc(Maker *self, const Edge *edge, const Edge *next, PetscReal side) {
  const PetscReal out = edge->turn > 0 ? -1 : 1, away = edge->r / PetscCosReal(edge->turn / 2);
  const Vector2 one = Times2(out * side, Left2(edge->t)),
                other = Times2(out * side, Left2(next->t)), middle = Plus2(one, other);
  WallPiece *p = AddArc(self->wall, Minus2(next->at, Over2(Times2(away, middle), Size2(middle))),
                        edge->r, out, one, other);

  if (edge->r > 0) p->deep = self->radius;
}

/* Drawing programs end an outline with its first corner once more, and write one twice: such
   corners are taken once. */
static PetscErrorCode DropRepeated(Maker *self) {
  PetscReal *number = self->wall->number;
  PetscInt n = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->wall->numbers; k += 2) {
    if (n && number[k] == number[n - 2] && number[k + 1] == number[n - 1]) continue;
    number[n++] = number[k];
    number[n++] = number[k + 1];
  }
  while (n > 2 && number[n - 2] == number[0] && number[n - 1] == number[1]) n -= 2;
  UserCheck(n >= 6, OptionsComm(),
            "-wall_file %s, line %d: of the polygon's corners only %d are different; it needs 3",
            self->file, self->line, (int)n / 2);
  self->wall->numbers = n;
  PetscFunctionReturn(0);
}

/* Each edge is a line; a corner that stands out is an arc of radius 0 between the normals of its
   edges, a hollow one that is gentle an arc within. In another hollow one the rod touches both. */
static PetscErrorCode MakePolygon(Maker *self) {
  PetscReal side;
  PetscInt n;
  Edge *edge;

  PetscFunctionBegin;
  PetscCall(DropRepeated(self));
  n = self->wall->numbers / 2;
  side = Area(self, 0, n) > 0 ? -1 : 1;
  PetscCall(CheckPolygon(self, n));
  if (self->wall->inside) side = -side;
  PetscCall(PetscMalloc1(n, &edge));
  PetscErrorCode error = MeasureEdges(self, n, side, edge);
  if (error) PetscCall(PetscFree(edge));
  PetscCall(error);
  CutEdges(self->radius, n, edge);
  for (PetscInt k = 0; k < n; k++) {
    const Edge *next = &edge[(k + 1) % n];
    WallPiece *line = AddLine(self->wall, edge[k].at, edge[k].t, edge[k].length, side, 0);
    line->deep = self->radius;
    line->edge = edge[k].length;
    line->from = edge[k].before;
    line->to = edge[k].length - edge[k].behind;
    if (edge[k].turn < 0 || edge[k].r > 0) AddCornerArc(self, &edge[k], next, side);
  }
  PetscCall(PetscFree(edge));
  PetscFunctionReturn(0);
}

/* The mouths of a conduit are rounded: an arc of its own radius on either side, as a trumpet has.
 */
static void AddMouth(Wall *wall, Vector2 end, Vector2 outwards) {
  const PetscReal r = wall->number[0];

  for (int side = -1; side <= 1; side += 2) {
    const Vector2 across = Times2(side, Left2(outwards));
    WallPiece *p = AddArc(wall, Along2(end, 2 * r, across), r, 1, Times2(-1, across), outwards);
    p->at_mouth = PETSC_TRUE;
    p->mouth = end;
  }
}

/* How much of both its edges the rounding of a corner by this angle takes: what the radius asked
   for needs; else an arc of twice the conduit's radius if there is room; of a gentle corner more,
   so that points along a curve give that curve. */
static PetscReal Rounding(const Wall *wall, PetscReal angle, PetscReal before, PetscReal after) {
  const PetscReal half = PetscTanReal(angle / 2);

  if (wall->bend > 0) return wall->bend * half;
  return PetscMin(wall->number[0] * PetscMax(1, 2 * half), PetscMin(before, after) / 2);
}

/* The arc of the axis about a corner b, and with it the two walls there. */
static PetscErrorCode AddCorner(Maker *self, Vector2 b, Vector2 t, Vector2 u, PetscReal angle,
                                PetscReal taken) {
  const PetscReal r = self->wall->number[0], side = Cross2(t, u) > 0 ? 1 : -1,
                  axis = taken / PetscTanReal(angle / 2);
  const Vector2 one = Times2(-side, Left2(t)), other = Times2(-side, Left2(u)),
                c = Along2(Along2(b, -taken, t), -axis, one);

  PetscFunctionBegin;
  UserCheck(axis > r, OptionsComm(),
            "-wall_file %s, line %d: the path turns more sharply than a conduit of this radius "
            "can: put its points farther apart, make it narrower, or its bends wider",
            self->file, self->line);
  (void)AddArc(self->wall, c, axis + r, -1, one, other);
  (void)AddArc(self->wall, c, axis - r, 1, one, other);
  PetscFunctionReturn(0);
}

static PetscErrorCode MakePath(Maker *self) {
  Wall *wall = self->wall;
  const PetscInt n = (wall->numbers - 1) / 2;
  const PetscReal r = wall->number[0];
  PetscReal taken = 0, leaves;

  PetscFunctionBegin;
  UserCheck(r > self->radius, OptionsComm(),
            "-wall_file %s, line %d: the conduit is narrower than the rod (-contact_diameter)",
            self->file, self->line);
  for (PetscInt k = 0; k + 1 < n; k++, taken = leaves) {
    const Vector2 a = PlaceOf(self, 1 + 2 * k), b = PlaceOf(self, 3 + 2 * k);
    Vector2 t, u;
    const PetscReal length = Direction(a, b, &t);
    UserCheck(length > 0, OptionsComm(), "-wall_file %s, line %d: two of its points are the same",
              self->file, self->line);
    leaves = 0;
    if (!k) AddMouth(wall, a, Times2(-1, t));
    if (k + 2 < n) {
      const PetscReal next = Direction(b, PlaceOf(self, 5 + 2 * k), &u),
                      angle = PetscAbsReal(PetscAtan2Real(Cross2(t, u), Dot2(t, u)));
      if (angle > 1e-9 && next > 0) {
        leaves = Rounding(wall, angle, length, next);
        PetscCall(AddCorner(self, b, t, u, angle, leaves));
      }
    } else
      AddMouth(wall, b, t);
    UserCheck(taken + leaves <= length * (1 + 1e-9), OptionsComm(),
              "-wall_file %s, line %d: bends of this radius do not fit between points %d and %d of "
              "the path: put them farther apart, or give a smaller radius",
              self->file, self->line, (int)k + 1, (int)k + 2);
    for (int side = -1; side <= 1; side += 2)
      (void)AddLine(wall, Along2(a, taken, t), t, length - taken - leaves, side, r);
  }
  PetscFunctionReturn(0);
}

/* ---- reading ---- */

static PetscErrorCode Malformed(const Maker *self, WallKind kind) {
  PetscFunctionBegin;
  UserCheck(PETSC_FALSE, OptionsComm(), "-wall_file %s, line %d: give %s%s", self->file, self->line,
            wall_form[kind], ", and friction MU behind it if it has its own");
  PetscFunctionReturn(0);
}

/* Takes `friction MU` off the end of a line's words. */
static PetscErrorCode TakeFriction(Maker *self, PetscInt *n, char *word[]) {
  char what[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  if (*n < 3 || strcmp(word[*n - 2], "friction")) PetscFunctionReturn(0);
  (void)snprintf(what, sizeof(what), "-wall_file %s, line %d: friction", self->file, self->line);
  PetscCall(OptionQuantity(what, word[*n - 1], UNIT_NONE, &self->wall->friction));
  UserCheck(self->wall->friction >= 0 && self->wall->friction <= 100, OptionsComm(),
            "-wall_file %s, line %d: friction must be from 0 to 100", self->file, self->line);
  *n -= 2;
  PetscFunctionReturn(0);
}

/* Walls of the plane are carried along in it, and turn about x3. */
static PetscErrorCode TakeMotion(const Maker *self, PetscInt *n, char *word[]) {
  const WallKind kind = self->wall->kind;
  SurfaceMotion *motion = &self->wall->motion;
  const PetscReal *axis = motion->axis;
  Schedule upward;
  PetscReal out;

  PetscFunctionBegin;
  PetscCall(MotionTake(self->file, self->line, n, word, motion));
  UserCheck(
      axis[0] == 0 && axis[1] == 0, OptionsComm(),
      "-wall_file %s, line %d: turns: a wall of the plane turns in it; let the axis be 0 0 1, "
      "or in place of this %s give %s",
      self->file, self->line, wall_kind[kind], wall_in_space[kind]);
  upward = motion->place[2];
  out = motion->velocity[2];
  for (PetscInt k = 0; upward && k < ScheduleRows(upward); k++) {
    PetscReal t, x;
    ScheduleGetRow(upward, k, &t, &x);
    out = PetscMax(out, PetscAbsReal(x));
  }
  UserCheck(out == 0, OptionsComm(),
            "-wall_file %s, line %d: moves: a wall of the plane stays in it; let x3 be 0, or in "
            "place of this %s give %s",
            self->file, self->line, wall_kind[kind], wall_in_space[kind]);
  PetscFunctionReturn(0);
}

/* Takes `radius B` off the end of a path's words. */
static PetscErrorCode TakeBend(Maker *self, PetscInt *n, char *word[]) {
  char what[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  if (self->wall->kind != WALL_PATH || *n < 3 || strcmp(word[*n - 2], "radius"))
    PetscFunctionReturn(0);
  (void)snprintf(what, sizeof(what), "-wall_file %s, line %d: radius", self->file, self->line);
  PetscCall(OptionQuantity(what, word[*n - 1], UNIT_LENGTH, &self->wall->bend));
  UserCheck(self->wall->bend > 0, OptionsComm(),
            "-wall_file %s, line %d: the radius of a path's bends must be above 0", self->file,
            self->line);
  *n -= 2;
  PetscFunctionReturn(0);
}

/* Takes outside or inside out of a line's words, where it stands at k. */
static PetscBool TakeSide(Maker *self, PetscInt k, PetscInt *n, char *word[]) {
  if (k >= *n || (strcmp(word[k], "inside") && strcmp(word[k], "outside"))) return PETSC_FALSE;
  self->wall->inside = (PetscBool)!strcmp(word[k], "inside");
  for (PetscInt i = k; i + 1 < *n; i++) word[i] = word[i + 1];
  (*n)--;
  return PETSC_TRUE;
}

/* Have the words of a wall the right number? */
static PetscBool Counts(WallKind kind, PetscInt n) {
  if (kind == WALL_PLANE) return (PetscBool)(n == 4);
  if (kind == WALL_CIRCLE) return (PetscBool)(n == 3);
  if (kind == WALL_POLYGON) return (PetscBool)(n >= 6 && n % 2 == 0);
  return (PetscBool)(n >= 5 && n % 2 == 1);
}

static PetscErrorCode ReadNumbers(Maker *self, WallKind kind, PetscInt n, char *word[]) {
  char what[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  (void)snprintf(what, sizeof(what), "-wall_file %s, line %d: ", self->file, self->line);
  PetscCall(PetscMalloc1(n, &self->wall->number));
  self->wall->numbers = n;
  for (PetscInt k = 0; k < n; k++) /* a plane's normal has no unit */
    PetscCall(OptionQuantity(what, word[k], kind == WALL_PLANE && k > 1 ? UNIT_NONE : UNIT_LENGTH,
                             &self->wall->number[k]));
  PetscFunctionReturn(0);
}

/* One line of the file that is not empty. */
static PetscErrorCode ReadWall(Maker *self, PetscInt n, char *word[]) {
  static PetscErrorCode (*const make[WALL_KINDS])(Maker *) = {MakePlane, MakeCircle, MakePolygon,
                                                              MakePath};
  Wall *wall = self->wall;
  PetscInt kind = 0, place;
  PetscBool sided;

  PetscFunctionBegin;
  while (kind < WALL_KINDS && strcmp(word[0], wall_kind[kind])) kind++;
  UserCheck(kind < WALL_KINDS, OptionsComm(),
            "-wall_file %s, line %d: %s is no wall; there are plane, circle, polygon and path, and "
            "in space sphere, cylinder, cone, torus, tube and body",
            self->file, self->line, word[0]);
  wall->kind = (WallKind)kind;
  PetscCall(TakeFriction(self, &n, word));
  PetscCall(TakeMotion(self, &n, word));
  PetscCall(TakeFriction(self, &n, word));
  PetscCall(TakeBend(self, &n, word));
  if (wall->bend > 0) PetscCall(TakeFriction(self, &n, word)); /* in either order */
  place = kind == WALL_CIRCLE ? n - 1 : 1;
  sided = (PetscBool)(kind == WALL_CIRCLE || kind == WALL_POLYGON);
  if (sided && !TakeSide(self, place, &n, word)) PetscCall(Malformed(self, wall->kind));
  if (!Counts(wall->kind, n - 1)) PetscCall(Malformed(self, wall->kind));
  PetscCall(ReadNumbers(self, wall->kind, n - 1, word + 1));
  PetscCall(PetscCalloc1(2 * wall->numbers + 8, &wall->piece));
  PetscCall(make[kind](self));
  PetscFunctionReturn(0);
}

/* Is a word nothing but digits? */
static PetscBool IsWhole(const char *word) {
  return (PetscBool)(strspn(word, "0123456789") == strlen(word));
}

/* What is easily mistyped, of any kind of wall: a blank before a unit, a comma in a number. */
static PetscErrorCode RefuseSlips(const Maker *self, PetscInt n, char *word[]) {
  PetscFunctionBegin;
  for (PetscInt k = 2; k < n; k++) {
    const char *unit = word[k], *before = word[k - 1];
    UserCheck(!OptionIsLength(unit), OptionsComm(),
              "-wall_file %s, line %d: %s %s: write a unit right behind its number, %s%s",
              self->file, self->line, before, unit, before, unit);
    if (strcmp(word[k - 2], "friction") || !strchr("-.0123456789", *unit)) continue;
    UserCheck(
        !IsWhole(before) || !IsWhole(unit), OptionsComm(),
        "-wall_file %s, line %d: friction %s,%s: give one number, with a point: friction %s.%s",
        self->file, self->line, before, unit, before, unit);
    UserCheck(
        PETSC_FALSE, OptionsComm(),
        "-wall_file %s, line %d: friction %s %s: is one number; write it behind all others of "
        "the line",
        self->file, self->line, before, unit);
  }
  PetscFunctionReturn(0);
}

/* The words of a line, of which there is at least one: a surface in space, or a wall of the plane.
 */
static PetscErrorCode ReadLine(Maker *self, PetscInt n, char *word[], PetscReal friction,
                               Walls *walls, Surfaces *surfaces) {
  const SurfaceLine line = {
      .file = self->file, .line = self->line, .n = n, .word = word, .radius = self->radius};
  PetscBool own = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt k = 1; k < n; k++)
    if (!strcmp(word[k], "friction")) own = PETSC_TRUE;
  if (!own) walls->bare = PETSC_TRUE;
  PetscCall(RefuseSlips(self, n, word));
  if (SurfacesKnow(n, word)) {
    PetscCall(SurfacesAdd(&line, friction, surfaces));
    surfaces->surface[surfaces->n - 1].bare = (PetscBool)!own;
    PetscFunctionReturn(0);
  }
  self->wall = &walls->wall[walls->n++];
  self->wall->friction = friction;
  self->wall->line = self->line;
  self->wall->bare = (PetscBool)!own;
  PetscCall(ReadWall(self, n, word));
  PetscFunctionReturn(0);
}

/* All lines of a text, which is taken apart. */
static PetscErrorCode ReadLines(Maker *self, char *text, PetscReal friction, Walls *walls,
                                Surfaces *surfaces) {
  PetscInt lines = 1, longest = 0, at = 0, n;
  char **word, *line, *next;

  PetscFunctionBegin;
  for (const char *c = text; *c; c++) {
    lines += *c == '\n';
    at = *c == '\n' ? 0 : at + 1;
    longest = PetscMax(longest, at);
  }
  PetscCall(PetscCalloc1(lines, &walls->wall));
  PetscCall(PetscMalloc1(longest + 1, &word));
  for (line = text, self->line = 1; line; line = next, self->line++) {
    PetscErrorCode error;
    next = strchr(line, '\n');
    if (next) *next++ = 0;
    line[strcspn(line, "#")] = 0;
    n = TextWords(line, " \t\r\n,", longest + 1, word);
    if (!n) continue;
    OptionsAtLine(self->line);
    error = ReadLine(self, n, word, friction, walls, surfaces);
    if (error) PetscCall(PetscFree(word));
    PetscCall(error);
  }
  PetscCall(PetscFree(word));
  UserCheck(walls->n + surfaces->n > 0, OptionsComm(), "-wall_file %s: there is no wall in it",
            self->file);
  PetscFunctionReturn(0);
}

/* What stands out and is round, or sharp: circles, corners of polygons, the inner walls of bends.
 */
static PetscErrorCode FindPosts(Walls *walls, PetscReal radius) {
  PetscInt n = 0;

  PetscFunctionBegin;
  for (PetscInt w = 0; w < walls->n; w++) n += walls->wall[w].pieces;
  PetscCall(PetscMalloc1(n, &walls->post));
  for (PetscInt w = 0; w < walls->n; w++)
    for (PetscInt k = 0; k < walls->wall[w].pieces; k++) {
      const WallPiece *p = &walls->wall[w].piece[k];
      WallPost *post = &walls->post[walls->posts];
      if (!p->round || p->sign < 0) continue;
      walls->smallest =
          walls->smallest > 0 ? PetscMin(walls->smallest, p->r + radius) : p->r + radius;
      if (p->at_mouth) continue; /* it is a part of a circle only, and as wide as the conduit */
      post->at = p->at;
      post->r = p->r;
      post->wall = w;
      walls->posts++;
    }
  PetscFunctionReturn(0);
}

/*
  WallsRead - the walls of a file: one a line, # begins a comment, lengths may carry units.
  Collective on OptionsComm(); the caller ends it with WallsDestroy() and SurfacesDestroy(), also
  after an error.

  radius    of the rod
  friction  of walls that do not say their own
  surfaces  those of its lines that are surfaces in space
*/
PetscErrorCode WallsRead(const char *file, PetscReal radius, PetscReal friction,
                         PetscReal clamp_angle, Walls *walls, Surfaces *surfaces) {
  Maker self = {.file = file,
                .radius = radius,
                .turn = {PetscCosReal(clamp_angle), PetscSinReal(clamp_angle)}};
  PetscErrorCode error;
  char *text;

  PetscFunctionBegin;
  PetscCall(TextRead("-wall_file", file, &text));
  OptionsReadLines("-wall_file", file);
  error = ReadLines(&self, text, friction, walls, surfaces);
  OptionsAtLine(0);
  PetscCall(PetscFree(text));
  PetscCall(error);
  walls->turn = self.turn;
  for (PetscInt w = 0; w < walls->n; w++)
    if (walls->wall[w].friction > 0) walls->rub = PETSC_TRUE;
  PetscCall(FindPosts(walls, radius));
  PetscCall(WallsIndex(walls));
  walls->carried = walls->move;
  PetscCall(SurfacesIndex(surfaces));
  PetscFunctionReturn(0);
}

PetscErrorCode WallsDestroy(Walls *walls) {
  PetscFunctionBegin;
  for (PetscInt w = 0; w < walls->n; w++) {
    PetscCall(PetscFree(walls->wall[w].number));
    PetscCall(PetscFree(walls->wall[w].piece));
    PetscCall(MotionDestroy(&walls->wall[w].motion));
  }
  PetscCall(WallsDropIndex(walls));
  PetscCall(PetscFree(walls->wall));
  PetscCall(PetscFree(walls->post));
  walls->n = walls->posts = 0;
  PetscFunctionReturn(0);
}

/* WallsText - the walls as a file has them, dimensionless. The caller frees the text (PetscFree).
 */
PetscErrorCode WallsText(const Walls *walls, char **text) {
  enum { NUMBER = 26, WORDS = 96 };
  size_t room = 1, at = 0;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(room, text));
  for (PetscInt w = 0; w < walls->n; w++) {
    const Wall *wall = &walls->wall[w];
    const char *side = wall->inside ? " inside" : " outside";
    char *moves;
    PetscCall(MotionText(&wall->motion, &moves));
    room += WORDS + NUMBER * (size_t)wall->numbers + strlen(moves);
    PetscCall(PetscRealloc(room, text));
    at += (size_t)snprintf(*text + at, room - at, "%s%s", wall_kind[wall->kind],
                           wall->kind == WALL_POLYGON ? side : "");
    for (PetscInt k = 0; k < wall->numbers; k++)
      at += (size_t)snprintf(*text + at, room - at, " %.17g", (double)wall->number[k]);
    if (wall->bend > 0)
      at += (size_t)snprintf(*text + at, room - at, " radius %.17g", (double)wall->bend);
    at += (size_t)snprintf(*text + at, room - at, "%s%s friction %.17g\n",
                           wall->kind == WALL_CIRCLE ? side : "", moves, (double)wall->friction);
    PetscCall(PetscFree(moves));
  }
  PetscFunctionReturn(0);
}
