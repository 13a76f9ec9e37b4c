#include "rod/crossing.h"
#include "base/blocks.h"
#include "base/plane.h"
#include "base/vectors.h"
#include <string.h>

/* Does segment ab cross segment cd? Touching in an end point does not count twice: half-open. */
static PetscBool SegmentsCross(const Node *ab, const Node *cd) {
  const Vector2 a = From2(ab[0].x), c = From2(cd[0].x), o = Minus2(c, a),
                r = Minus2(From2(ab[1].x), a), q = Minus2(From2(cd[1].x), c);
  const PetscReal det = Cross2(r, q), u = Cross2(o, q) / det, w = Cross2(o, r) / det;

  return (PetscBool)(det != 0 && u >= 0 && u < 1 && w >= 0 && w < 1);
}

/* The polygon whose crossings are counted. */
typedef struct {
  const Node *nodes;
  PetscInt count;
} Crossings;

/* An arc whose angles span less than pi cannot meet itself, nor its neighbour in the same arc. */
static PetscBool CannotCross(const Block *a, PetscInt first_a, PetscInt last_a, const Block *b,
                             PetscInt first_b, PetscInt last_b, void *ctx) {
  PetscReal span = PetscMax(a->high[2], b->high[2]) - PetscMin(a->low[2], b->low[2]);
  return (PetscBool)(span < PETSC_PI && (last_a == first_b || first_a == first_b));
}

static void CountCrossing(PetscInt i, PetscInt j, void *ctx) {
  Crossings *self = (Crossings *)ctx;
  const Node *a = self->nodes + i, *c = self->nodes + j;
  if (j > i + 1) self->count += SegmentsCross(a, c); /* else: a node in common */
}

/* RodCrossings - in how many points the polygon through n nodes crosses itself. Not collective.
 */
PetscErrorCode RodCrossings(PetscInt n, const Node *nodes, PetscInt *count) {
  Crossings self = {nodes, 0};
  Blocks line;

  PetscFunctionBegin;
  *count = 0;
  if (n < 4) PetscFunctionReturn(0);
  PetscCall(BlocksOfLine(2, n - 1, NODE_VALUES, nodes[0].x, &nodes[0].theta, NULL, &line));
  BlocksPairs(line, 0, CannotCross, CountCrossing, &self);
  PetscCall(BlocksDestroy(&line));
  *count = self.count;
  PetscFunctionReturn(0);
}

/* ---- in space ---- */

/* A rod that moves from one state to another, every node evenly. */
typedef struct {
  const Node *from, *to;
  const PetscInt *of; /* as of RodPassesItself() */
  PetscBool passes;
} Motion;

static inline void Between(const Motion *self, PetscInt i, PetscReal tau, PetscReal x[3]) {
  for (int d = 0; d < 3; d++) x[d] = (1 - tau) * self->from[i].x[d] + tau * self->to[i].x[d];
}

/* The sides r, q of segments i and j at a time, and the way o from one to the other. */
static void SidesAt(const Motion *self, PetscInt i, PetscInt j, PetscReal tau, PetscReal r[3],
                    PetscReal q[3], PetscReal o[3]) {
  PetscReal a[3], b[3], c[3], d[3];

  Between(self, i, tau, a);
  Between(self, i + 1, tau, b);
  Between(self, j, tau, c);
  Between(self, j + 1, tau, d);
  for (int k = 0; k < 3; k++) {
    r[k] = b[k] - a[k];
    q[k] = d[k] - c[k];
    o[k] = c[k] - a[k];
  }
}

/* The volume o.(r x q) between two segments: 0 when they lie in a plane. */
static PetscReal VolumeAt(const Motion *self, PetscInt i, PetscInt j, PetscReal tau) {
  PetscReal r[3], q[3], o[3], n[3];

  SidesAt(self, i, j, tau, r, q, o);
  Cross3(r, q, n);
  return Dot3(o, n);
}

/* Do two segments that lie in a plane cross there? Half-open, as in the plane. */
static PetscBool CrossAt(const Motion *self, PetscInt i, PetscInt j, PetscReal tau) {
  PetscReal r[3], q[3], o[3], n[3], by_q[3], by_r[3], square, u, w;

  SidesAt(self, i, j, tau, r, q, o);
  Cross3(r, q, n);
  square = Dot3(n, n);
  if (square == 0) return PETSC_FALSE;
  Cross3(o, q, by_q);
  Cross3(o, r, by_r);
  u = Dot3(by_q, n) / square;
  w = Dot3(by_r, n) / square;
  return (PetscBool)(u >= 0 && u < 1 && w >= 0 && w < 1);
}

/* The times between 0 and 1 at which a cubic with these values at 0, 1/3, 2/3 and 1 may have an
   extremum, with both ends: between them it is monotone. */
static int Pieces(const PetscReal f[4], PetscReal at[4]) {
  const PetscReal b = (-11 * f[0] + 18 * f[1] - 9 * f[2] + 2 * f[3]) / 2,
                  c = 9 * (2 * f[0] - 5 * f[1] + 4 * f[2] - f[3]) / 2,
                  d = 9 * (-f[0] + 3 * f[1] - 3 * f[2] + f[3]) / 2, root = c * c - 3 * b * d;
  PetscReal first, second;
  int n = 1;

  at[0] = 0;
  if (root > 0) {
    PetscReal m = -(c + (c < 0 ? -1 : 1) * PetscSqrtReal(root)); /* of 3 d tau^2 + 2 c tau + b */
    first = m != 0 ? b / m : -1;
    second = d != 0 ? m / (3 * d) : -1;
    if (first > second) {
      PetscReal swap = first;
      first = second;
      second = swap;
    }
    if (first > 0 && first < 1) at[n++] = first;
    if (second > 0 && second < 1) at[n++] = second;
  }
  at[n] = 1;
  return n;
}

/* Are two nodes one place, before and behind? There rods are joined. */
static PetscBool AreJoined(const Motion *self, PetscInt i, PetscInt j, PetscReal length) {
  const PetscReal rounding = PetscSqr(1e-7 * length);
  PetscReal before[3], behind[3];

  Minus3(self->from[i].x, self->from[j].x, before);
  Minus3(self->to[i].x, self->to[j].x, behind);
  return (PetscBool)(Dot3(before, before) < rounding && Dot3(behind, behind) < rounding);
}

/* Have segments of two rods an end in common? */
static PetscBool MeetAtJoint(const Motion *self, PetscInt i, PetscInt j) {
  PetscReal side[3];

  if (!self->of || self->of[i] == self->of[j]) return PETSC_FALSE;
  Minus3(self->to[i + 1].x, self->to[i].x, side);
  for (int k = 0; k < 4; k++)
    if (AreJoined(self, i + k / 2, j + k % 2, PetscSqrtReal(Dot3(side, side)))) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* On which side of segment b a place a is in a plane with this normal, at a time; is it beside it?
 */
static PetscReal SideAt(const Motion *self, PetscInt a, PetscInt b, const PetscReal normal[3],
                        PetscReal tau, PetscBool *beside) {
  PetscReal at[3], from[3], to[3], side[3], way[3], n[3];

  Between(self, a, tau, at);
  Between(self, b, tau, from);
  Between(self, b + 1, tau, to);
  Minus3(to, from, side);
  Minus3(at, from, way);
  Cross3(side, way, n);
  *beside = (PetscBool)(Dot3(way, side) >= 0 && Dot3(way, side) < Dot3(side, side));
  return Dot3(n, normal);
}

/* Does node a go through segment b, in a plane? Sides are looked at a few times on the way. */
static PetscBool GoesThrough(const Motion *self, PetscInt a, PetscInt b,
                             const PetscReal normal[3]) {
  enum { LOOKS = 8 };
  PetscBool beside[2];
  PetscReal side[2];

  side[0] = SideAt(self, a, b, normal, 0, &beside[0]);
  for (int k = 1; k <= LOOKS; k++) {
    side[1] = SideAt(self, a, b, normal, (PetscReal)k / LOOKS, &beside[1]);
    if (side[1] == 0) continue; /* on it: the next look tells */
    if (side[0] * side[1] < 0 && beside[0] && beside[1]) return PETSC_TRUE;
    side[0] = side[1];
    beside[0] = beside[1];
  }
  return PETSC_FALSE;
}

/* Do segments of two rods go through each other in a plane that both lie in all the while? Then an
   end of one goes through the other. */
static PetscBool CrossInPlane(const Motion *self, PetscInt i, PetscInt j) {
  PetscReal r[3], q[3], o[3], n[2][3];

  SidesAt(self, i, j, 0, r, q, o);
  Cross3(r, q, n[0]);
  Cross3(r, o, n[1]);
  if (Dot3(n[1], n[1]) > Dot3(n[0], n[0])) memcpy(n[0], n[1], sizeof(n[0]));
  for (int e = 0; e < 2; e++)
    if (GoesThrough(self, i + e, j, n[0]) || GoesThrough(self, j + e, i, n[0])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Is the volume between two segments, at these times, no more than round-off? */
static PetscBool ArePlane(const Motion *self, PetscInt i, PetscInt j, const PetscReal f[4]) {
  PetscReal r[3], q[3], o[3], most = 0;

  if (!self->of || self->of[i] == self->of[j]) return PETSC_FALSE;
  for (int k = 0; k < 4; k++) most = PetscMax(most, PetscAbsReal(f[k]));
  SidesAt(self, i, j, 1, r, q, o);
  return (PetscBool)(most <= 1e-9 * PetscSqrtReal(Dot3(r, r) * Dot3(q, q)) *
                                 PetscSqrtReal(Dot3(r, r) + Dot3(q, q)));
}

/* Do segments i and j pass through each other? They do when they lie in a plane, and cross in it.
 */
static void MeetMoving(PetscInt i, PetscInt j, void *ctx) {
  Motion *self = (Motion *)ctx;
  PetscReal f[4], at[4];
  int pieces;

  if (self->passes || j <= i + 1) return; /* neighbours have a node in common */
  if (self->of && (self->of[i] != self->of[i + 1] || self->of[j] != self->of[j + 1])) return;
  for (int k = 0; k < 4; k++) f[k] = VolumeAt(self, i, j, k / 3.);
  if (ArePlane(self, i, j, f)) {
    self->passes = (PetscBool)(CrossInPlane(self, i, j) && !MeetAtJoint(self, i, j));
    return;
  }
  pieces = Pieces(f, at);
  for (int k = 0; k < pieces && !self->passes; k++) {
    PetscReal low = at[k], high = at[k + 1], sign = VolumeAt(self, i, j, low);
    if (sign * VolumeAt(self, i, j, high) >= 0) continue;
    for (int n = 0; n < 60; n++) {
      PetscReal mid = (low + high) / 2;
      if (sign * VolumeAt(self, i, j, mid) > 0)
        low = mid;
      else
        high = mid;
    }
    self->passes = (PetscBool)(CrossAt(self, i, j, low) && !MeetAtJoint(self, i, j));
  }
}

/* RodPassesItself - does the polygon through n nodes in space pass through itself on its way from
   one state to another, every node on a straight line? Not collective.

   of  of several polygons, one behind the other, that of each node, in a frame that they share;
       NULL: it is one */
PetscErrorCode RodPassesItself(PetscInt n, const PetscInt *of, const Node *from, const Node *to,
                               PetscBool *passes) {
  Motion self = {from, to, of, PETSC_FALSE};
  PetscReal way = 0;
  Blocks line;

  PetscFunctionBegin;
  *passes = PETSC_FALSE;
  if (n < 4) PetscFunctionReturn(0);
  for (PetscInt i = 0; i < n; i++)
    for (int d = 0; d < 3; d++) way = PetscMax(way, PetscAbsReal(to[i].x[d] - from[i].x[d]));
  PetscCall(BlocksOfLine(3, n - 1, NODE_VALUES, to[0].x, NULL, of, &line));
  BlocksPairs(line, 2 * way, NULL, MeetMoving, &self);
  PetscCall(BlocksDestroy(&line));
  *passes = self.passes;
  PetscFunctionReturn(0);
}
