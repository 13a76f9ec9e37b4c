/* Friction between strands, where their surfaces touch and slip by each other.

   In the plane they slip along t = n turned to the left, at u = t.(v_i - v_foot), and w = w(u) t.
   The law has a memory of each side of a sample, so that friction may be exact.

   In space they slip at V, omega a strand's spin about its tangent t, and roll on each other:

     V = (I - n n^T)(v_i - v_foot) + omega_i a_i + omega_foot a_foot,   a = -D/2 t x n,
     w as the law of friction has it,   couples a.f t on both,   f the force.

   What friction takes is mu p w.V. (That tangents turn, and the couples across them, are left out
   as on walls: contact_push.h.) */
#include "base/clones.h"
#include "rod/directors.h"
#include "rod/strand_pairs.h"

/* How a place of the rod moves. */
static void MotionOf(const struct _Strands *self, const Spot *spot, CurveMotion *m) {
  CurveCell cell;
  StrandCellMoving(self, spot->cell, &cell);
  CurveMove(&cell, &spot->on, m);
}

/* The derivatives of its tangent and velocity at fixed z. */
ALWAYS_INLINE void MotionBy(int dims, const struct _Strands *self, const Spot *spot,
                            const CurveMotion *m, CurveBy t, CurveBy v) {
  const Joint *joint = self->joint + spot->cell;
  const CurveEnd *end[] = {&joint[0].by, &joint[1].by};
  CurveBy x, slope;
  CurveCell cell;

  StrandCellMoving(self, spot->cell, &cell);
  CurvePlaceBy(dims, NodeOf(dims), &cell, end, spot->on.z, x, slope);
  CurveMotionBy(dims, NodeOf(dims), &cell, end, spot->on.z, m, x, slope, t, v);
}

/* ---- in the plane ---- */

static FrictionDual *DualOf(const struct _Strands *self, const Pair *pair) {
  return &self->dual[self->sides * pair->sample + pair->side];
}

/* w and its power, of the slip and of what its dual holds. */
static void RubOf(const struct _Strands *self, Pair *pair) {
  const PetscReal w = ContactRub(pair->contact, pair->slip, DualOf(self, pair), &pair->w_slip);

  pair->w[0] = -w * pair->n[1];
  pair->w[1] = w * pair->n[0];
  pair->rubs = w * pair->slip;
}

static void RubInPlane(const struct _Strands *self, Pair *pair, const CurveMotion motion[2]) {
  const PetscReal *at = motion[0].v, *foot = motion[1].v;

  pair->slip = pair->n[0] * (at[1] - foot[1]) - pair->n[1] * (at[0] - foot[0]);
  RubOf(self, pair);
}

/* Brings the dual of a pair up to its slip. */
static void Advance(const struct _Strands *self, Pair *pair, PetscBool fresh) {
  FrictionFollow(1, &pair->contact->rub, &pair->slip, fresh, DualOf(self, pair));
  RubOf(self, pair);
}

/* du = t.dV + V.dt,   dw = w' t du + w dt,   dt = dn turned to the left */
static void SlopeInPlane(const struct _Strands *self, Pair *pair, PetscBool fresh,
                         const CurveMotion motion[2], PairSlope *by) {
  enum { CELL = 2 * 3 };
  const Vector2 t = Left2(From2(pair->n)), V = Minus2(From2(motion[0].v), From2(motion[1].v)),
                slides = From2(motion[1].v_z);
  PetscReal w;
  CurveBy skip, at, foot;

  Advance(self, pair, fresh);
  w = Dot2(From2(pair->w), t);
  MotionBy(2, self, &pair->at, &motion[0], skip, at);
  MotionBy(2, self, &pair->foot, &motion[1], skip, foot);
  for (int f = 0; f < 2 * CELL; f++) {
    const Vector2 dt = Left2(Column2(by->n[0], STRAND_UNKNOWNS, f)),
                  v = f < CELL ? Column2(at[0], 2 * CURVE_NODE, f)
                               : Times2(-1, Column2(foot[0], 2 * CURVE_NODE, f - CELL)),
                  moves = Along2(v, -by->z[f], slides);
    const PetscReal slip = Dot2(V, dt) + t.x * moves.x + t.y * moves.y;
    by->w[0][f] = w * dt.x + pair->w_slip * t.x * slip;
    by->w[1][f] = w * dt.y + pair->w_slip * t.y * slip;
  }
}

/* PairsForget - what does not touch when a Newton solve begins, and may before it ends, begins from
   nothing: what is left of earlier solves a run that is restarted does not have. (Shifts stay.) */
void PairsForget(Strands self) {
  for (PetscInt k = 0; self->dual && k < self->sides * self->samples; k++) {
    FrictionDual *dual = &self->dual[k];
    if (self->first[k] >= 0 && self->pair[self->first[k]].active) continue;
    *dual = (FrictionDual){.shift = {dual->shift[0]}};
  }
}

/* StrandsHold - moves what holds strands that stick to each other (exact Coulomb friction); creep
   is the largest speed of a place that is held, which counts the less the less it is pressed. Not
   of those in space, which are not held. */
PetscErrorCode StrandsHold(Strands self, PetscReal seen, PetscReal *creep) {
  PetscFunctionBegin;
  for (PetscInt k = 0; self->dual && k < self->n; k++) {
    const Pair *pair = &self->pair[k];
    if (!pair->active || pair->p == 0) continue;
    *creep =
        LargerOf(*creep, PetscMin(1, pair->contact->friction * pair->p) *
                             FrictionHold(1, &pair->slip, seen, friction_hold, DualOf(self, pair)));
  }
  PetscFunctionReturn(0);
}

/* StrandsDuals - what a restart is to remember: of each side of a point; 0: nothing. Borrowed. */
PetscInt StrandsDuals(Strands self, FrictionDual **duals) {
  *duals = self->dual;
  return self->dual ? self->sides * self->samples : 0;
}

/* ---- in space ---- */

/* Twist of a cell, per length: by how much the directors of its nodes turn about d1 between them.
 */
static PetscReal TwistOf(const struct _Strands *self, PetscInt cell) {
  const Joint *a = self->joint + cell, *b = a + 1;
  const PetscReal length = self->arc[cell + 1] - self->arc[cell];

  return QuaternionSpin(a->p, PetscSqrtReal(a->size * b->size), b->p) / length;
}

/* The spin of the material is between nodes linear, but for what slides past them: c times the
   twist. The lever is that of contact_push.h, a = -D/2 t x n on both strands. */
static void TurningOf(const struct _Strands *self, const Spot *spot, const CurveMotion *motion,
                      const PetscReal n[3], Turning *turning) {
  const Joint *a = self->joint + spot->cell, *b = a + 1;
  const PetscReal z = spot->on.z;
  PetscReal twist;

  for (int d = 0; d < 3; d++) turning->t[d] = motion->t[d];
  Cross3(turning->t, n, turning->a);
  for (int d = 0; d < 3; d++) turning->a[d] *= -StrandOf(self, spot->cell)->contact->diameter / 2;
  turning->spin = (1 - z) * a->spin + z * b->spin;
  turning->spin_z = b->spin - a->spin;
  if (motion->c == 0) return;
  twist = TwistOf(self, spot->cell);
  turning->spin += motion->c * twist;
  turning->spin_z += CurveBetweenSlope(self->c + 2 * spot->cell, z) * twist;
}

static void RubInSpace(const struct _Strands *self, Pair *pair, const CurveMotion motion[2]) {
  const Spot *spot[] = {&pair->at, &pair->foot};
  PetscReal normal, v[3], w[4];

  for (int d = 0; d < 3; d++) v[d] = motion[0].v[d] - motion[1].v[d];
  normal = Dot3(pair->n, v);
  for (int d = 0; d < 3; d++) pair->V[d] = v[d] - normal * pair->n[d];
  pair->V[3] = 0;
  for (int k = 0; k < 2; k++) {
    Turning *turning = &pair->turning[k];
    TurningOf(self, spot[k], &motion[k], pair->n, turning);
    for (int d = 0; d < 3; d++) pair->V[d] += turning->spin * turning->a[d];
  }
  FrictionForce(RUBS, &pair->contact->rub, pair->V, &pair->dual, w);
  for (int d = 0; d < 3; d++) pair->w[d] = w[d];
  pair->rubs = Dot3(pair->w, pair->V);
}

/* How the twist of a cell changes with an unknown of it. */
static PetscReal TwistSlope(const struct _Strands *self, PetscInt cell, int f) {
  const Joint *a = self->joint + cell, *b = a + 1, *at = f < STRAND_NODE ? a : b;
  const int j = f % STRAND_NODE - 3;
  const PetscReal size = PetscSqrtReal(a->size * b->size),
                  length = self->arc[cell + 1] - self->arc[cell], sign = at == b ? 1 : -1;
  PetscReal by[4];

  if (j < 0) return 0;
  SpinForm(at == b ? a->p : b->p, by);
  return 2 / (size * length) * (sign * by[j]) - TwistOf(self, cell) * at->p[j] / at->size;
}

enum { CELL = 2 * STRAND_NODE };

/*
  Tangent and lever of a strand, and what its spin adds to the slip; dt at fixed z is that of
  CurveMotionBy():
    dt = ... + t_z dz,   da = -D/2 (dt x n + t x dn),   d(spin a).
*/
static void TurningSlope(const struct _Strands *self, const Pair *pair, int which,
                         const CurveMotion *motion, CurveBy t_by, PairSlope *by) {
  const Spot *spot = which ? &pair->foot : &pair->at;
  const Turning *turning = &pair->turning[which];
  const PetscReal half = StrandOf(self, spot->cell)->contact->diameter / 2, z = spot->on.z;
  const Joint *joint = self->joint + spot->cell;

  for (int f = 0; f < STRAND_UNKNOWNS; f++) {
    const int g = f % CELL, end = g / STRAND_NODE, j = g % STRAND_NODE - 3;
    const PetscBool own = (PetscBool)((f >= CELL) == which);
    PetscReal dn[3], dt[3], turned[3], leaned[3], spin = 0;
    Column3(by->n[0], STRAND_UNKNOWNS, f, dn);
    for (int d = 0; d < 3; d++)
      dt[d] = (own ? t_by[d][g] : 0) + (which ? motion->t_z[d] * by->z[f] : 0);
    Cross3(dt, pair->n, turned);
    Cross3(turning->t, dn, leaned);
    if (own && j >= 0) spin = (end ? z : 1 - z) * joint[end].spin_by[j];
    if (own && motion->c != 0) spin += motion->c * TwistSlope(self, spot->cell, g);
    if (which) spin += turning->spin_z * by->z[f];
    for (int d = 0; d < 3; d++) {
      by->t[which][d][f] = dt[d];
      by->a[which][d][f] = -half * (turned[d] + leaned[d]);
      by->slip[d][f] += spin * turning->a[d] + turning->spin * by->a[which][d][f];
    }
  }
}

/* V = v - n (n.v) + ..., v the relative velocity:  dV = dv - n (n.dv + v.dn) - dn (n.v) + ...
   TurningSlope(). */
static void SlopeInSpace(const struct _Strands *self, Pair *pair, PetscBool fresh,
                         const CurveMotion motion[2], PairSlope *by) {
  CurveBy t_by[2], v_by[2];
  PetscReal v[3], normal;

  for (int d = 0; d < 3; d++) v[d] = motion[0].v[d] - motion[1].v[d];
  normal = Dot3(pair->n, v);
  MotionBy(3, self, &pair->at, &motion[0], t_by[0], v_by[0]);
  MotionBy(3, self, &pair->foot, &motion[1], t_by[1], v_by[1]);
  for (int f = 0; f < STRAND_UNKNOWNS; f++) {
    const int of_foot = f >= CELL, g = f % CELL;
    PetscReal dv[3], dn[3], along;
    Column3(by->n[0], STRAND_UNKNOWNS, f, dn);
    for (int d = 0; d < 3; d++)
      dv[d] = (of_foot ? -v_by[1][d][g] : v_by[0][d][g]) - motion[1].v_z[d] * by->z[f];
    along = Dot3(pair->n, dv) + Dot3(v, dn);
    for (int d = 0; d < 3; d++) by->slip[d][f] = dv[d] - pair->n[d] * along - dn[d] * normal;
  }
  for (int k = 0; k < 2; k++) TurningSlope(self, pair, k, &motion[k], t_by[k], by);
  FrictionLinearise(RUBS, &pair->contact->rub, pair->V, fresh, &pair->dual, pair->by);
  for (int f = 0; f < STRAND_UNKNOWNS; f++) {
    PetscReal slip[3];
    Column3(by->slip[0], STRAND_UNKNOWNS, f, slip);
    for (int d = 0; d < 3; d++) by->w[d][f] = Dot3(pair->by[d], slip);
  }
}

/* ---- */

/* PairRub - the friction of a pair whose places are known: slip, w, and its power. */
void PairRub(const struct _Strands *self, Pair *pair) {
  CurveMotion motion[2];

  MotionOf(self, &pair->at, &motion[0]);
  MotionOf(self, &pair->foot, &motion[1]);
  (self->dims == 2 ? RubInPlane : RubInSpace)(self, pair, motion);
}

/* PairFootPower - that of the force on a foot in space, and of the couple that goes with it, f
   being the force on the sample: per length of that. */
PetscReal PairFootPower(const struct _Strands *self, const Pair *pair, const PetscReal f[3],
                        const PetscReal on_foot[3]) {
  const Turning *turning = &pair->turning[1];
  CurveMotion motion;

  MotionOf(self, &pair->foot, &motion);
  return Dot3(on_foot, motion.v) +
         (pair->contact->friction > 0 ? Dot3(turning->a, f) * turning->spin : 0);
}

/* PairRubSlope - how w of PairRub() changes, of a pair whose places do as `by` says; what Newton's
   method remembers is brought up to the slip first. fresh: a Newton solve begins. */
void PairRubSlope(const struct _Strands *self, Pair *pair, PetscBool fresh, PairSlope *by) {
  CurveMotion motion[2];

  MotionOf(self, &pair->at, &motion[0]);
  MotionOf(self, &pair->foot, &motion[1]);
  (self->dims == 2 ? SlopeInPlane : SlopeInSpace)(self, pair, fresh, motion, by);
}
