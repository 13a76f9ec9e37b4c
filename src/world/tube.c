#include "world/tube.h"
#include "base/blocks.h"
#include "base/spline.h"
#include "base/vectors.h"

/* Coordinates and, last, the radius. */
enum { RADIUS = 3, FOUR = 4 };

/* A place of the path: the ball there, and its derivatives by u. */
typedef struct {
  PetscReal y[FOUR], d1[FOUR], d2[FOUR];
} Ball;

/* How the path goes on beyond an end, v from it. Its bend fades out over the length `fade`, over
   which the tube widens, r''' = widen; from there it is straight and its wall is the lip of a
   trumpet, a circle of radius lip about a point that is R from the path, at v = at. */
typedef struct {
  PetscReal sign; /* -1 before the path, 1 beyond it */
  Ball from;      /* by v */
  PetscReal fade, widen, last;
  PetscReal lip, R, at;
} Mouth;

/* A part of the path, of one segment or a mouth. */
typedef struct {
  PetscReal a, b;
  PetscInt segment; /* -1, n - 1: the mouths */
  PetscReal r;      /* no ball is larger */
} Piece;

struct _Tube {
  PetscBool inside;
  PetscInt n; /* points */
  PetscReal *u, (*f)[FOUR], (*f2)[FOUR];
  Mouth mouth[2]; /* inside only */
  PetscInt pieces;
  Piece *piece;
  Blocks near; /* the pieces */
  Block box;
  PetscReal widest, narrowest, smallest;
  PetscInt latest; /* the piece that was looked at last, */
  PetscReal at;    /* and where on it: the next place is not far */
};

/* ---- the path ---- */

/* Between points k and k + 1. */
static void OnSegment(const struct _Tube *self, PetscInt k, PetscReal u, Ball *ball) {
  const PetscReal h = self->u[k + 1] - self->u[k], b = (u - self->u[k]) / h, a = 1 - b;
  const PetscReal p = (a * a * a - a) * h * h / 6, q = (b * b * b - b) * h * h / 6,
                  p1 = -(3 * a * a - 1) * h / 6, q1 = (3 * b * b - 1) * h / 6;

  for (int d = 0; d < FOUR; d++) {
    const PetscReal f = self->f[k][d], g = self->f[k + 1][d], f2 = self->f2[k][d],
                    g2 = self->f2[k + 1][d];
    ball->y[d] = a * f + b * g + p * f2 + q * g2;
    ball->d1[d] = (g - f) / h + p1 * f2 + q1 * g2;
    ball->d2[d] = a * f2 + b * g2;
  }
}

/* v beyond an end: y = from + d1 v + d2 (fading to 0) twice integrated + widen v^3/6 in the radius;
   then straight, r = sqrt((v - at)^2 + R^2) - lip. */
static void InMouth(const Mouth *self, PetscReal v, Ball *ball) {
  const PetscReal L = self->fade, z = PetscMin(v, L), o = v - self->at;

  for (int d = 0; d < FOUR; d++) {
    const PetscReal w = d == RADIUS ? self->widen : 0, bend = self->from.d2[d];
    ball->d2[d] = bend * (1 - z / L) + w * z;
    ball->d1[d] = self->from.d1[d] + bend * (z - z * z / (2 * L)) + w * z * z / 2;
    ball->y[d] = self->from.y[d] + self->from.d1[d] * z + bend * (z * z / 2 - z * z * z / (6 * L)) +
                 w * z * z * z / 6 + ball->d1[d] * (v - z);
    if (v > L) ball->d2[d] = 0;
  }
  if (v > L && self->R > 0) {
    const PetscReal s = PetscSqrtReal(o * o + self->R * self->R);
    ball->y[RADIUS] = s - self->lip;
    ball->d1[RADIUS] = o / s;
    ball->d2[RADIUS] = self->R * self->R / (s * s * s);
  }
  for (int d = 0; d < FOUR; d++) ball->d1[d] *= self->sign;
}

static void BallAt(const struct _Tube *self, PetscInt segment, PetscReal u, Ball *ball) {
  if (segment < 0)
    InMouth(&self->mouth[0], -u, ball);
  else if (segment > self->n - 2)
    InMouth(&self->mouth[1], u - self->u[self->n - 1], ball);
  else
    OnSegment(self, segment, u, ball);
}

/* By arc length: how fast the radius changes, and its change; the curvature of the path. */
static void ByArc(const Ball *ball, PetscReal *slope, PetscReal *bend, PetscReal *curvature) {
  const PetscReal speed2 = Dot3(ball->d1, ball->d1), speed = PetscSqrtReal(speed2),
                  along = Dot3(ball->d1, ball->d2) / speed2;
  PetscReal across[3];

  for (int d = 0; d < 3; d++) across[d] = ball->d2[d] - along * ball->d1[d];
  *curvature = PetscSqrtReal(Dot3(across, across)) / speed2;
  *slope = ball->d1[RADIUS] / speed;
  *bend = (ball->d2[RADIUS] - along * ball->d1[RADIUS]) / speed2;
}

/*
  The mouth of the tube at an end. The path's bend fades over one radius r. So that the wall is
  smooth, its widening begins with r''' and goes over into a circle when it is ready, with

    dr/dv = p, d2r/dv2 = k there:    s = (1 - p^2)/k,  lip = s - r,  R = s sqrt(1 - p^2).

  widen r^2 = 0.54 makes lip 0.63 r of a tube that is even. One that widens already has less, so
  that it has a lip at all.
*/
static void SetMouth(Mouth *self) {
  const PetscReal r = self->from.y[RADIUS], most = 0.7;
  PetscReal p, k, s;
  Ball end;

  self->fade = self->last = r;
  self->widen = 0.54 / (r * r);
  self->R = 0;
  for (int halvings = 0; halvings < 30; halvings++, self->widen /= 2) {
    InMouth(self, self->fade, &end);
    p = self->sign * end.d1[RADIUS];
    k = self->widen * self->fade;
    s = (1 - p * p) / k;
    if (p > 0 && p < most && s > end.y[RADIUS]) break;
  }
  if (!(p > 0 && p < most && s > end.y[RADIUS])) return; /* narrows, or is a funnel as it is */
  self->lip = s - end.y[RADIUS];
  self->R = s * PetscSqrtReal(1 - p * p);
  self->at = self->fade - p * s;
  self->last = self->at + self->R * most / PetscSqrtReal(1 - most * most);
}

static void SetMouths(Tube self) {
  for (int w = 0; w < 2; w++) {
    Mouth *mouth = &self->mouth[w];
    const PetscInt segment = w ? self->n - 2 : 0;

    OnSegment(self, segment, self->u[w ? self->n - 1 : 0], &mouth->from);
    mouth->sign = w ? 1 : -1;
    for (int d = 0; d < FOUR; d++) mouth->from.d1[d] *= mouth->sign;
    SetMouth(mouth);
  }
}

/* ---- the distance ---- */

/*
  How far x is within the ball at u, F = r - |x - c|, and its derivatives by u; e is the direction
  from the centre to x:

    F' = r' + e.c',    F'' = r'' + e.c'' - (c'.c' - (e.c')^2)/|x - c|

  The tube is where the largest F is 0, and this largest F is the distance from its wall: balls that
  shrink by as much leave a tube that is everywhere as much narrower. So its gradient is -e, of
  length 1, and its second derivatives follow from u that goes along with x.
*/
typedef struct {
  Ball ball;
  PetscReal e[3], far; /* far: |x - c| */
  PetscReal F, F1, F2;
} Sight;

static void See(const struct _Tube *self, PetscInt segment, PetscReal u, const PetscReal x[3],
                Sight *sight) {
  const Ball *ball = &sight->ball;
  PetscReal along;

  BallAt(self, segment, u, &sight->ball);
  for (int d = 0; d < 3; d++) sight->e[d] = x[d] - ball->y[d];
  sight->far = PetscSqrtReal(Dot3(sight->e, sight->e));
  for (int d = 0; d < 3; d++) sight->e[d] = sight->far > 0 ? sight->e[d] / sight->far : 0;
  along = Dot3(sight->e, ball->d1);
  sight->F = ball->y[RADIUS] - sight->far;
  sight->F1 = ball->d1[RADIUS] + along;
  sight->F2 = ball->d2[RADIUS] + Dot3(sight->e, ball->d2) -
              (Dot3(ball->d1, ball->d1) - along * along) / PetscMax(sight->far, 1e-300);
}

/* The largest F on a piece, by Newton's method between bounds that close in on it; or the first one
   met that is more than enough: of what is far from the wall no more is asked. */
static PetscReal Climb(const struct _Tube *self, const Piece *piece, const PetscReal x[3],
                       PetscReal enough, Sight *sight) {
  enum { MOST = 80 };
  PetscReal low = piece->a, high = piece->b, u, slope;

  See(self, piece->segment, low, x, sight);
  if (sight->F1 <= 0 || sight->F > enough) return low;
  slope = sight->F1;
  See(self, piece->segment, high, x, sight);
  if (sight->F1 >= 0) return high;
  u = low + (high - low) * slope / (slope - sight->F1);
  for (int k = 0; k < MOST; k++) {
    PetscReal next;
    See(self, piece->segment, u, x, sight);
    if (sight->far == 0 || sight->F1 == 0 || sight->F > enough) break;
    *(sight->F1 > 0 ? &low : &high) = u;
    next = sight->F2 < 0 ? u - sight->F1 / sight->F2 : low;
    if (!(next > low && next < high)) next = (low + high) / 2;
    if (PetscAbsReal(next - u) <= 4 * PETSC_MACHINE_EPSILON * (PetscAbsReal(u) + high - low)) break;
    u = next;
  }
  return u;
}

/* A search for the ball that x is deepest in. */
typedef struct {
  const struct _Tube *self;
  const PetscReal *x;
  PetscReal best, u; /* the largest F so far */
  PetscReal enough;  /* more need not be known */
  PetscInt piece;
} Search;

static PetscReal Meet(PetscInt item, PetscReal reach, void *ctx) {
  Search *search = (Search *)ctx;
  const struct _Tube *self = search->self;
  const Piece *piece = &self->piece[item];
  PetscReal u;
  Sight sight;

  (void)reach;
  u = Climb(self, piece, search->x, search->enough, &sight);
  if (sight.F > search->best || (sight.F == search->best && item < search->piece)) {
    search->best = sight.F;
    search->u = u;
    search->piece = item;
  }
  if (search->best > search->enough) return -1;
  return self->widest - search->best;
}

/* d = F, n = -e, H = -(I - e e^T)/|x - c| - q q^T/(|x - c|^2 F''), q = c' - (e.c') e; outside all
   with the other sign. At an end the ball stands still: without q. */
static void Derive(const struct _Tube *self, const Sight *sight, PetscBool end,
                   SurfacePoint *point) {
  const PetscReal sign = self->inside ? 1 : -1, far = sight->far,
                  along = Dot3(sight->e, sight->ball.d1);
  PetscReal q[3], follow = end || !(sight->F2 < 0) ? 0 : 1 / (far * far * sight->F2);

  point->distance = sign * sight->F;
  for (int d = 0; d < 3; d++) q[d] = sight->ball.d1[d] - along * sight->e[d];
  for (int i = 0; i < 3; i++) {
    point->normal[i] = -sign * sight->e[i];
    for (int j = 0; j < 3; j++)
      point->bend[i][j] =
          -sign * (((i == j) - sight->e[i] * sight->e[j]) / far + follow * q[i] * q[j]);
  }
}

/* On the path itself all directions across it are alike: one of them, and no bend. */
static void DeriveOnPath(const struct _Tube *self, const Sight *sight, SurfacePoint *point) {
  const PetscReal *t = sight->ball.d1, sign = self->inside ? 1 : -1;
  int least = 0;
  PetscReal size = 0;

  *point = (SurfacePoint){.distance = sign * sight->F};
  for (int d = 1; d < 3; d++)
    if (PetscAbsReal(t[d]) < PetscAbsReal(t[least])) least = d;
  for (int d = 0; d < 3; d++) {
    point->normal[d] = (d == least) - t[least] * t[d] / Dot3(t, t);
    size += PetscSqr(point->normal[d]);
  }
  for (int d = 0; d < 3; d++) point->normal[d] /= PetscSqrtReal(size);
}

/* Is a place deeper within the tube than is asked? Most are, and a ball of the path beside the
   latest one tells: there, or where a step of Newton's method leads from it. */
static PetscBool IsDeep(Tube self, const PetscReal x[3], PetscReal enough) {
  enum { TRIES = 3 };
  Sight sight;

  for (int k = 0; k < TRIES; k++) {
    See(self, self->piece[self->latest].segment, self->at, x, &sight);
    if (sight.F > enough) return PETSC_TRUE;
    if (!(sight.F2 < 0)) break;
    self->at -= sight.F1 / sight.F2;
    while (self->at > self->piece[self->latest].b && self->latest + 1 < self->pieces)
      self->latest++;
    while (self->at < self->piece[self->latest].a && self->latest > 0) self->latest--;
    self->at =
        PetscMax(self->piece[self->latest].a, PetscMin(self->piece[self->latest].b, self->at));
  }
  return PETSC_FALSE;
}

/*
  TubeAt - the distance of a place from the tube's wall, above 0 where the rod may be, its gradient
  and second derivatives, if it is below `within`. Not collective.

  Returns false where it is not, and where there is no wall: inside beyond the mouths, or behind the
  wall by more than the tube's radius.
*/
PetscBool TubeAt(Tube self, const PetscReal x[3], PetscReal within, SurfacePoint *point) {
  Search search = {.self = self, .x = x, .piece = -1};
  const Block place = BlockAt(3, x);
  const Piece *piece;
  PetscBool end;
  Sight sight;

  if (self->inside && IsDeep(self, x, within)) return PETSC_FALSE;
  search.enough = self->inside ? within : PETSC_MAX_REAL;
  search.best = self->inside ? -self->widest : -within;
  BlocksNear(self->near, &place, self->widest - search.best, Meet, &search);
  if (search.piece < 0) return PETSC_FALSE;
  piece = &self->piece[search.piece];
  self->latest = search.piece;
  self->at = search.u;
  if (search.best > search.enough) return PETSC_FALSE;
  See(self, piece->segment, search.u, x, &sight);
  if (self->inside ? sight.F >= within || sight.F < -sight.ball.y[RADIUS] : -sight.F >= within)
    return PETSC_FALSE;
  end = (PetscBool)((search.piece == 0 && search.u == piece->a && sight.F1 < 0) ||
                    (search.piece == self->pieces - 1 && search.u == piece->b && sight.F1 > 0));
  if (end && self->inside) return PETSC_FALSE;
  if (sight.far > 0)
    Derive(self, &sight, end, point);
  else
    DeriveOnPath(self, &sight, point);
  return PETSC_TRUE;
}

/* Does the mouth whose last ball this is open to a place? Its lip ends at 45 degrees, so that what
   is farther from the axis than   a + sqrt(2) r,   a the way beyond the ball's centre, is beside
   it. */
static PetscBool InFront(const Sight *last, PetscReal sign, PetscReal radius) {
  const PetscReal *out = last->ball.d1,
                  a = sign * last->far * Dot3(last->e, out) / PetscSqrtReal(Dot3(out, out)),
                  from_axis = PetscSqrtReal(PetscMax(0, last->far * last->far - a * a));

  return (PetscBool)(from_axis + radius <= a + PetscSqrtReal(2) * last->ball.y[RADIUS]);
}

/* TubeHolds - may the axis of a rod of this radius be at x: within the tube, or in front of one of
   its mouths? */
PetscBool TubeHolds(Tube self, const PetscReal x[3], PetscReal radius) {
  Search search = {.self = self, .x = x, .piece = -1, .best = -PETSC_MAX_REAL};
  const Block place = BlockAt(3, x);
  const Piece *piece;
  Sight sight;

  search.enough = PETSC_MAX_REAL;
  BlocksNear(self->near, &place, PETSC_MAX_REAL, Meet, &search);
  piece = &self->piece[search.piece];
  See(self, piece->segment, search.u, x, &sight);
  if (search.piece == 0 && search.u == piece->a) return InFront(&sight, -1, radius);
  if (search.piece == self->pieces - 1 && search.u == piece->b) return InFront(&sight, 1, radius);
  return (PetscBool)(sight.F >= radius);
}

/* ---- making it ---- */

/* The spline through two or three points is a line, a parabola. */
static PetscErrorCode SetSpline(Tube self) {
  const PetscInt n = self->n;

  PetscFunctionBegin;
  if (n > 3) PetscCall(SplineSecondDerivatives(n, self->u, FOUR, 1, FOUR, self->f[0], self->f2[0]));
  for (PetscInt d = 0; d < FOUR && n == 3; d++) {
    const PetscReal *u = self->u, before = (self->f[1][d] - self->f[0][d]) / (u[1] - u[0]),
                    after = (self->f[2][d] - self->f[1][d]) / (u[2] - u[1]);
    for (int k = 0; k < 3; k++) self->f2[k][d] = 2 * (after - before) / (u[2] - u[0]);
  }
  PetscFunctionReturn(0);
}

/* Into how many pieces a segment or mouth is cut: each turns little and is not much longer than the
   tube is wide, so that its box says well where it is. */
static PetscInt Cuts(const struct _Tube *self, PetscInt segment, PetscReal a, PetscReal b) {
  enum { MOST = 1000 };
  const PetscReal turns = 0.25, wide = 8;
  PetscReal turn = 0, slope, bend, curvature, r = PETSC_MAX_REAL;

  for (int k = 0; k <= 2; k++) {
    Ball ball;
    BallAt(self, segment, a + (b - a) * k / 2, &ball);
    ByArc(&ball, &slope, &bend, &curvature);
    turn = PetscMax(turn, curvature * (b - a));
    r = PetscMin(r, ball.y[RADIUS]);
  }
  return (PetscInt)PetscMin(MOST, PetscCeilReal(PetscMax(turn / turns, (b - a) / (wide * r))));
}

/* A piece's box: that of the points which a cubic stays within; a mouth's radius, which is none, is
   largest at an end. */
static Block SetPiece(const struct _Tube *self, PetscInt segment, PetscReal a, PetscReal b,
                      Piece *piece) {
  PetscReal y[FOUR];
  Block box = BlockEmpty(3);

  *piece = (Piece){.a = a, .b = b, .segment = segment};
  for (int w = 0; w < 2; w++) {
    Ball ball;
    BallAt(self, segment, w ? b : a, &ball);
    BlockHold(3, &box, ball.y);
    piece->r = PetscMax(piece->r, ball.y[RADIUS]);
    for (int d = 0; d < FOUR; d++) y[d] = ball.y[d] + (w ? -1 : 1) * (b - a) / 3 * ball.d1[d];
    BlockHold(3, &box, y);
    piece->r = PetscMax(piece->r, y[RADIUS]);
  }
  return box;
}

static PetscErrorCode SetPieces(Tube self) {
  const PetscInt first = self->inside ? -1 : 0, last = self->inside ? self->n - 1 : self->n - 2;
  const PetscReal from = self->inside ? -self->mouth[0].last : 0,
                  to = self->u[self->n - 1] + (self->inside ? self->mouth[1].last : 0);
  Block *box = NULL;

  PetscFunctionBegin;
  for (int set = 0; set < 2; set++) { /* first count them */
    self->pieces = 0;
    for (PetscInt k = first; k <= last; k++) {
      const PetscReal a = k < 0 ? from : self->u[k], b = k > self->n - 2 ? to : self->u[k + 1];
      const PetscInt cuts = Cuts(self, k, a, b);
      for (PetscInt i = 0; i < cuts; i++, self->pieces++)
        if (set)
          box[self->pieces] =
              SetPiece(self, k, a + (b - a) * i / cuts,
                       i + 1 < cuts ? a + (b - a) * (i + 1) / cuts : b, &self->piece[self->pieces]);
    }
    if (set) break;
    PetscCall(PetscMalloc1(self->pieces, &self->piece));
    PetscCall(PetscMalloc1(self->pieces, &box));
  }
  self->box = BlockEmpty(3);
  for (PetscInt k = 0; k < self->pieces; k++) {
    self->widest = PetscMax(self->widest, self->piece[k].r);
    for (int d = 0; d < 3; d++) {
      self->box.low[d] = PetscMin(self->box.low[d], box[k].low[d] - self->piece[k].r);
      self->box.high[d] = PetscMax(self->box.high[d], box[k].high[d] + self->piece[k].r);
    }
  }
  PetscCall(BlocksCreate(3, self->pieces, box, &self->near));
  PetscCall(PetscFree(box));
  PetscFunctionReturn(0);
}

/* What is said of a tube that cannot be: between which of its points. */
static PetscErrorCode Refuse(const struct _Tube *self, const char *what, PetscInt k,
                             const char *why, const char *remedy) {
  PetscFunctionBegin;
  UserCheck(PETSC_FALSE, OptionsComm(), "%s: between points %d and %d of %d the tube %s: %s", what,
            (int)k + 1, (int)k + 2, (int)self->n, why, remedy);
  PetscFunctionReturn(0);
}

/* The points as they are given. */
static PetscErrorCode CheckPoints(const char *what, PetscInt n, const PetscReal ball[][FOUR],
                                  PetscBool inside, PetscReal radius) {
  const PetscReal sharpest = PetscCosReal(PETSC_PI / 3);
  char text[2][64];
  PetscReal before = 0;

  PetscFunctionBegin;
  UserCheck(n >= 2, OptionsComm(), "%s: a tube's path needs two points at least", what);
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal *y = ball[k];
    PetscReal step[3] = {0}, last[3], length = 0, turn;
    for (int d = 0; d < 3 && k > 0; d++) step[d] = y[d] - ball[k - 1][d];
    length = PetscSqrtReal(Dot3(step, step));
    UserCheck(y[RADIUS] > 0, OptionsComm(), "%s: point %d: the tube's radius must be above 0", what,
              (int)k + 1);
    UserCheck(!inside || y[RADIUS] > radius, OptionsComm(),
              "%s: point %d: the tube, of radius %s, is narrower than the rod, of radius %s "
              "(-contact_diameter is twice that)",
              what, (int)k + 1, OptionBoth(y[RADIUS], UNIT_LENGTH, text[0]),
              OptionBoth(radius, UNIT_LENGTH, text[1]));
    UserCheck(!k || length > 0, OptionsComm(), "%s: points %d and %d are the same", what, (int)k,
              (int)k + 1);
    if (k > 1) {
      for (int d = 0; d < 3; d++) last[d] = ball[k - 1][d] - ball[k - 2][d];
      turn = Dot3(step, last) / (length * before);
      UserCheck(turn > sharpest, OptionsComm(),
                "%s: the path has a kink of %.0f degrees at point %d; give more points where it "
                "bends",
                what, (double)(PetscAcosReal(PetscMax(-1, turn)) * 180 / PETSC_PI), (int)k);
    }
    before = length;
  }
  PetscFunctionReturn(0);
}

/*
  The tube along segment k: the balls' envelope is smooth where F'' < 0 for all directions that it
  is seen from,  r'' + kappa sqrt(1 - r'^2) < (1 - r'^2)/r  by arc length; outside up to the rod's
  axis.
*/
static PetscErrorCode CheckSegment(Tube self, const char *what, PetscInt k, PetscReal radius) {
  enum { PLACES = 16 };
  PetscReal slope, bend, curvature;
  char why[128], text[2][64];
  Ball ball;

  PetscFunctionBegin;
  for (PetscInt i = 0; i <= PLACES; i++) {
    PetscReal r, out;
    OnSegment(self, k, self->u[k] + (self->u[k + 1] - self->u[k]) * i / PLACES, &ball);
    ByArc(&ball, &slope, &bend, &curvature);
    r = ball.y[RADIUS];
    if (r <= (self->inside ? radius : 0))
      PetscCall(Refuse(self, what, k, self->inside ? "is narrower than the rod" : "vanishes",
                       "its radius is a smooth curve through the points; give more of them"));
    if (PetscAbsReal(slope) >= 0.99)
      PetscCall(Refuse(self, what, k, "widens or narrows more than the path goes on",
                       "give its mouth fewer points, or cut it off"));
    out = self->inside ? r : r + radius;
    if (bend + curvature * PetscSqrtReal(1 - slope * slope) >= (1 - slope * slope) / out) {
      (void)snprintf(why, sizeof(why), "bends with radius %s, or its width does, and has radius %s",
                     OptionBoth(1 / PetscMax(curvature, 1e-300), UNIT_LENGTH, text[0]),
                     OptionBoth(r, UNIT_LENGTH, text[1]));
      PetscCall(
          Refuse(self, what, k, why, "make it narrower, its bends wider, or give more points"));
    }
    self->narrowest = PetscMin(self->narrowest, r);
    self->smallest =
        PetscMin(self->smallest, self->inside ? 1 / PetscMax(curvature, 1e-300) - r : r);
  }
  PetscFunctionReturn(0);
}

/* The nearest other part of the path, as seen from one place of it. */
typedef struct {
  const struct _Tube *self;
  PetscReal u, r, away, x[3]; /* parts are others if they are farther along than `away` */
  PetscInt other;             /* a segment that is met; -1: none */
} Encounter;

static PetscReal MeetOther(PetscInt item, PetscReal reach, void *ctx) {
  Encounter *at = (Encounter *)ctx;
  const Piece *piece = &at->self->piece[item];
  const Piece part[2] = {{piece->a, PetscMin(piece->b, at->u - at->away), piece->segment, 0},
                         {PetscMax(piece->a, at->u + at->away), piece->b, piece->segment, 0}};

  for (int w = 0; w < 2 && piece->segment >= 0 && piece->segment < at->self->n - 1; w++) {
    Sight sight;
    if (part[w].a >= part[w].b) continue;
    (void)Climb(at->self, &part[w], at->x, -at->r, &sight);
    if (sight.F > -at->r) at->other = piece->segment;
  }
  return at->other >= 0 ? -1 : reach;
}

/* Parts of the tube that are farther along than half a turn at its sharpest must not meet: by then
   even that has brought the path two radii away. */
static PetscErrorCode CheckOverlap(Tube self, const char *what) {
  enum { MOST = 100000 };
  const PetscReal end = self->u[self->n - 1];
  const PetscInt places = (PetscInt)PetscMin(MOST, PetscCeilReal(end / self->narrowest));
  PetscInt k = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i <= places; i++) {
    Encounter at = {.self = self, .u = end * i / places, .other = -1};
    Block place;
    Ball ball;
    while (k < self->n - 2 && at.u > self->u[k + 1]) k++;
    OnSegment(self, k, at.u, &ball);
    for (int d = 0; d < 3; d++) at.x[d] = ball.y[d];
    at.r = ball.y[RADIUS];
    at.away = 1.1 * PETSC_PI * self->widest;
    place = BlockAt(3, at.x);
    BlocksNear(self->near, &place, at.r + self->widest, MeetOther, &at);
    UserCheck(at.other < 0, OptionsComm(),
              "%s: the tube runs into itself: between points %d and %d and between %d and %d", what,
              (int)k + 1, (int)k + 2, (int)at.other + 1, (int)at.other + 2);
  }
  PetscFunctionReturn(0);
}

/*
  TubeCreate - a tube along the smooth path through n points, two at least. All ranks call it with
  the same; the caller destroys it with TubeDestroy(), also after an error.

  what    names it where it is refused
  ball    [n][4]: x1, x2, x3, and the tube's radius there
  inside  is the rod?
  radius  of the rod

  A kink, a tube that is narrower than the rod, that bends more sharply than it is wide, or that
  runs into itself is a user's mistake.
*/
PetscErrorCode TubeCreate(const char *what, PetscInt n, const PetscReal ball[][4], PetscBool inside,
                          PetscReal radius, Tube *tube) {
  Tube self;

  PetscFunctionBegin;
  PetscCall(CheckPoints(what, n, ball, inside, radius));
  PetscCall(PetscNew(&self));
  *tube = self;
  self->inside = inside;
  self->n = n;
  self->narrowest = self->smallest = PETSC_MAX_REAL;
  PetscCall(PetscMalloc1(n, &self->u));
  PetscCall(PetscMalloc1(n, &self->f));
  PetscCall(PetscCalloc1(n, &self->f2));
  PetscCall(PetscArraycpy(self->f[0], ball[0], FOUR * n));
  self->u[0] = 0;
  for (PetscInt k = 1; k < n; k++) {
    PetscReal step[3];
    for (int d = 0; d < 3; d++) step[d] = ball[k][d] - ball[k - 1][d];
    self->u[k] = self->u[k - 1] + PetscSqrtReal(Dot3(step, step));
  }
  PetscCall(SetSpline(self));
  for (PetscInt k = 0; k + 1 < n; k++) PetscCall(CheckSegment(self, what, k, radius));
  if (inside) SetMouths(self);
  PetscCall(SetPieces(self));
  PetscCall(CheckOverlap(self, what));
  PetscFunctionReturn(0);
}

PetscErrorCode TubeDestroy(Tube *tube) {
  PetscFunctionBegin;
  if (!*tube) PetscFunctionReturn(0);
  PetscCall(BlocksDestroy(&(*tube)->near));
  PetscCall(PetscFree((*tube)->piece));
  PetscCall(PetscFree((*tube)->u));
  PetscCall(PetscFree((*tube)->f));
  PetscCall(PetscFree((*tube)->f2));
  PetscCall(PetscFree(*tube));
  PetscFunctionReturn(0);
}

/* TubeBox - what holds all of it, its mouths included. */
Block TubeBox(Tube self) {
  return self->box;
}

/* TubeSmallest - where its wall stands out into the free side, the least radius of curvature. */
PetscReal TubeSmallest(Tube self) {
  return self->smallest;
}

/* TubeCore - how far behind its wall it is free again: through a wall that is as thick as the tube
   is wide; to the path. */
PetscReal TubeCore(Tube self) {
  return self->narrowest;
}
