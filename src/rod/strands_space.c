#include "rod/strands_space.h"
#include "base/blocks.h"
#include "curve/cell.h"
#include "curve/nearest.h"
#include "rod/directors.h"
#include "curve/spread.h"

/* Samples are no farther apart than this part of the diameter, where the rod is longest: strands
   that cross press on each other over half of it, and should feel no kink where one more sample
   begins to. */
static const PetscReal fine = 1. / 32;
enum { MOST_SAMPLES = 32 }; /* of a cell */

/* A node in the state that is looked at, and how it turns with p: d1 and g_t d1 + g d1_t, and the
   spin of the material about d1. */
typedef struct {
  const PetscReal *x, *x_t, *p;
  PetscReal d[3], d_t[3], size, spin;
  PetscReal by[3][4], rate_by[3][4], spin_by[4];
} Joint;

/* A place on the curve of the rod: cell, and 0 <= z <= 1 in it. */
typedef struct {
  PetscInt cell;
  PetscReal z;
  PetscReal x[3], slope[3], bend[3]; /* x and its first and second derivative by z */
} Spot;

/* How fast a place moves, and by z. */
typedef struct {
  PetscReal v[3], v_z[3], t[3], size, c; /* tangent, |x_z|, slide */
} Motion;

/* How a strand turns where it is touched: its tangent, the lever a by which its surface moves with
   its spin, and that spin and its derivative by z. */
typedef struct {
  PetscReal t[3], a[3], spin, spin_z;
} Turning;

/* A sample and what it is near to. */
typedef struct {
  PetscInt sample, next;
  PetscBool ends;   /* the foot is an end of the rod */
  PetscBool apart;  /* they are not the same strand */
  PetscBool active; /* they press */
  Spot at, foot;
  PetscReal n[3], distance, gap;
  PetscReal p, p_gap;                /* pressure and its derivative */
  PetscReal slip[4], w[4], by[4][4]; /* of the surfaces past each other, friction over mu p */
  Turning turning[2];                /* of the sample, of the foot; where there is friction */
  FrictionDual4 dual;
} Pair;

struct _Strands3 {
  Scene scene;
  const Contact *contact;
  PetscInt cells, points; /* points: 2 cells + 1 */
  PetscInt each, samples; /* of a cell; of the rod, with the tip at the end */
  PetscReal apart;        /* what is nearer along the rod is the same strand */
  PetscReal time;         /* of what follows: laws at the points */
  PetscReal *g, *g_t, *c, *strain, *arc, *weight;
  PetscInt n, room;
  Pair *pair;
  PetscInt *first;        /* of a sample: its first pair, -1 none */
  Joint *joint;           /* of each node */
  Spot *spot;             /* where samples are in the state that is looked at, */
  PetscBool *placed;      /* ... if anyone has asked */
  PetscBool searched;     /* it has been searched for pairs just now */
  PetscReal *seen;        /* x at the nodes when pairs were looked for */
  PetscReal (*force)[3];  /* Strands3Forces() */
  PetscReal (*couple)[3]; /* Strands3Couples(); NULL: without friction there are none */
  StrandSlope3 *slopes;
  PetscInt slopes_room;
  StrandSum3 sum;
};

/* What the laws give at a place of a cell, by the parabola through its three points. */
static inline PetscReal Between(const PetscReal *at, PetscInt cell, PetscReal z) {
  return CurveBetween(at + 2 * cell, z);
}

/* ... and its derivative by z. */
static inline PetscReal BetweenSlope(const PetscReal *at, PetscInt cell, PetscReal z) {
  return CurveBetweenSlope(at + 2 * cell, z);
}

/* ---- the curve ---- */

/* What a cell's curve is made of: x at its ends and x_z = h g d1 there. */
typedef struct {
  const Joint *joint; /* two of them */
  PetscReal h, g[2], g_t[2];
} Ends;

static void EndsOf(const struct _Strands3 *self, PetscInt cell, Ends *e) {
  const PetscReal *s = self->scene->mesh.s;

  e->joint = self->joint + cell;
  e->h = s[cell + 1] - s[cell];
  for (int k = 0; k < 2; k++) {
    e->g[k] = self->g[2 * (cell + k)];
    e->g_t[k] = self->g_t[2 * (cell + k)];
  }
}

/* x, x_z, x_zz at place z of a cell. */
static void SpotOn(const Ends *e, Spot *spot) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(spot->z, value, slope, bend);
  for (int d = 0; d < 3; d++) {
    const Joint *a = e->joint, *b = a + 1;
    PetscReal y[4] = {a->x[d], e->h * e->g[0] * a->d[d], b->x[d], e->h * e->g[1] * b->d[d]};
    spot->x[d] = spot->slope[d] = spot->bend[d] = 0;
    for (int k = 0; k < 4; k++) {
      spot->x[d] += value[k] * y[k];
      spot->slope[d] += slope[k] * y[k];
      spot->bend[d] += bend[k] * y[k];
    }
  }
}

static void SpotAt(const struct _Strands3 *self, PetscInt cell, PetscReal z, Spot *spot) {
  Ends e;
  EndsOf(self, cell, &e);
  spot->cell = cell;
  spot->z = z;
  SpotOn(&e, spot);
}

static PetscBool IsTip(const struct _Strands3 *self, PetscInt sample) {
  return (PetscBool)(sample == self->samples - 1);
}

/* Where a sample is in the state that is looked at. */
static const Spot *SampleSpot(const struct _Strands3 *self, PetscInt sample) {
  Spot *spot = &self->spot[sample];

  if (self->placed[sample]) return spot;
  self->placed[sample] = PETSC_TRUE;
  if (IsTip(self, sample))
    SpotAt(self, self->cells - 1, 1, spot);
  else
    SpotAt(self, sample / self->each, (sample % self->each + 0.5) / self->each, spot);
  return spot;
}

/* The arc length of a place. */
static PetscReal ArcAt(const struct _Strands3 *self, const Spot *spot) {
  return self->arc[spot->cell] + spot->z * (self->arc[spot->cell + 1] - self->arc[spot->cell]);
}

/*
  FootFrom - the place of the curve nearest to x, by Newton's method on (x - y(z)).y_z = 0 from a
  place near it, on to the next cell where that is. ends: it is an end of the rod.
*/
static void FootFrom(const struct _Strands3 *self, const PetscReal x[3], Spot *foot,
                     PetscBool *ends) {
  Ends e;

  *ends = PETSC_FALSE;
  EndsOf(self, foot->cell, &e);
  for (int k = 0; k < CURVE_MOST; k++) {
    PetscReal o[3], step;
    CurveWay way;
    SpotOn(&e, foot);
    for (int d = 0; d < 3; d++) o[d] = x[d] - foot->x[d];
    step = CurveStep(Dot3(o, foot->slope), Dot3(foot->slope, foot->slope), Dot3(o, foot->bend));
    way = CurveGo(self->cells, foot->z + step, &foot->cell, &foot->z, ends);
    if (way == CURVE_ARRIVED) return;
    if (way == CURVE_NEXT) EndsOf(self, foot->cell, &e);
  }
  SpotOn(&e, foot);
}

/* ---- laws, and the state ---- */

/* What the laws give at time t: at the points, and the arc length at the nodes. */
static PetscErrorCode LawsAt(Strands3 self, PetscReal t) {
  Growth growth = self->scene->growth;
  const PetscReal *s = self->scene->mesh.s;

  PetscFunctionBegin;
  PetscCall(SceneContactAt(self->scene, t));
  if (self->time == t) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < self->points; k++) {
    PetscReal at = k % 2 ? (s[k / 2] + s[k / 2 + 1]) / 2 : s[k / 2];
    PetscCall(GrowthStretch(growth, 1, &at, t, &self->g[k], &self->g_t[k], NULL));
    self->c[k] = GrowthSlide(growth, at, t);
    self->strain[k] = GrowthStrain(growth, at, t, self->g_t[k]);
  }
  PetscCall(GrowthArc(growth, self->cells + 1, s, t, self->arc, NULL));
  self->time = t;
  PetscFunctionReturn(0);
}

/* How the spin changes with p, and with p_t by its shift. */
static void SpinSlopeAt(const PetscReal p[4], PetscReal size, PetscReal spin,
                        const PetscReal p_t[4], const PetscReal shift[4], PetscReal by[4]) {
  const PetscReal by_rate[4] = {-p[1], p[0], p[3], -p[2]},
                  by_p[4] = {p_t[1], -p_t[0], -p_t[3], p_t[2]};

  for (int j = 0; j < 4; j++) by[j] = 2 / size * (shift[j] * by_rate[j] + by_p[j] - spin * p[j]);
}

/* The nodes in a state; with their derivatives if there are shifts of the rates, else it is a new
   one. */
static void JointsIn(Strands3 self, const StrandState3 *state, const PetscReal *shift) {
  const PetscReal still[STRAND3_NODE] = {0};

  for (PetscInt k = 0; k < self->samples && !shift; k++) self->placed[k] = PETSC_FALSE;
  for (PetscInt i = 0; i <= self->cells; i++) {
    Joint *joint = &self->joint[i];
    const PetscReal *p = state->u + i * state->stride + 3,
                    *rate = state->u_t ? state->u_t + i * state->stride : still, *p_t = rate + 3;
    PetscReal size = QuaternionSize(p), d[3][3], D[3][4];
    Directors(p, size, d);
    DirectorSlope(p, size, d[0], 0, D);
    joint->x = p - 3;
    joint->x_t = rate;
    joint->p = p;
    joint->size = size;
    joint->spin = QuaternionSpin(p, size, p_t);
    for (int c = 0; c < 3; c++) {
      joint->d[c] = d[0][c];
      joint->d_t[c] = D[c][0] * p_t[0] + D[c][1] * p_t[1] + D[c][2] * p_t[2] + D[c][3] * p_t[3];
    }
    if (!shift) continue;
    DirectorRateSlope(p, size, d[0], joint->d_t, 0, D, p_t, joint->rate_by);
    SpinSlopeAt(p, size, joint->spin, p_t, shift + 3, joint->spin_by);
    for (int c = 0; c < 3; c++)
      for (int j = 0; j < 4; j++) {
        joint->by[c][j] = D[c][j];
        joint->rate_by[c][j] = self->g_t[2 * i] * D[c][j] +
                               self->g[2 * i] * (shift[3 + j] * D[c][j] + joint->rate_by[c][j]);
      }
  }
}

/* ---- which samples are near to what ---- */

/* A search under way. */
typedef struct {
  Strands3 self;
  PetscReal reach;
  PetscErrorCode error;
} Looking;

static PetscBool SameStrand(const Block *a, PetscInt first_a, PetscInt last_a, const Block *b,
                            PetscInt first_b, PetscInt last_b, void *ctx) {
  const Strands3 self = ((const Looking *)ctx)->self;
  return (PetscBool)(self->arc[last_b] - self->arc[first_a] < self->apart);
}

/* Is the foot of x on this cell? 1 yes; 2 it is the end of the rod there; 0 no. */
static int HasFoot(const struct _Strands3 *self, PetscInt cell, const PetscReal x[3]) {
  const Joint *joint = self->joint + cell;
  PetscReal f[2];

  for (int k = 0; k < 2; k++) {
    PetscReal o[3];
    for (int d = 0; d < 3; d++) o[d] = x[d] - joint[k].x[d];
    f[k] = Dot3(o, joint[k].d);
  }
  if (f[0] >= 0 && f[1] < 0) return 1;
  if ((cell == 0 && f[0] < 0) || (cell == self->cells - 1 && f[1] >= 0)) return 2;
  return 0;
}

/* A new pair; two feet of a sample that are near each other along the rod are of one strand, of
   which the nearer counts. */
static PetscErrorCode Keep(Strands3 self, const Pair *pair) {
  const PetscReal at = ArcAt(self, &pair->foot);
  PetscInt next = self->first[pair->sample];

  PetscFunctionBegin;
  for (PetscInt k = next; k >= 0; k = self->pair[k].next) {
    Pair *other = &self->pair[k];
    if (PetscAbsReal(ArcAt(self, &other->foot) - at) >= self->apart) continue;
    if (pair->distance < other->distance) {
      PetscInt after = other->next;
      *other = *pair;
      other->next = after;
    }
    PetscFunctionReturn(0);
  }
  if (self->n == self->room) {
    self->room = 2 * self->room + 64;
    PetscCall(PetscRealloc((size_t)self->room * sizeof(Pair), &self->pair));
  }
  self->first[pair->sample] = self->n;
  self->pair[self->n] = *pair;
  self->pair[self->n++].next = next;
  PetscFunctionReturn(0);
}

static PetscErrorCode LookAt(Looking *look, PetscInt sample, PetscInt cell) {
  Strands3 self = look->self;
  const Spot *at = SampleSpot(self, sample);
  const int foot = HasFoot(self, cell, at->x);
  PetscReal square = 0;
  Pair pair;

  PetscFunctionBegin;
  if (!foot) PetscFunctionReturn(0);
  pair = (Pair){.sample = sample, .at = *at};
  pair.foot.cell = cell;
  pair.foot.z = foot == 1 ? 0.5 : cell ? 1 : 0;
  FootFrom(self, pair.at.x, &pair.foot, &pair.ends);
  for (int d = 0; d < 3; d++) square += PetscSqr(pair.foot.x[d] - pair.at.x[d]);
  pair.distance = PetscSqrtReal(square);
  if (pair.distance < look->reach) PetscCall(Keep(self, &pair));
  PetscFunctionReturn(0);
}

/* The samples of one cell against another. */
static PetscErrorCode LookFrom(Looking *look, PetscInt from, PetscInt to) {
  const Strands3 self = look->self;
  PetscInt end = (from + 1) * self->each + (from == self->cells - 1);

  PetscFunctionBegin;
  for (PetscInt k = from * self->each; k < end; k++) PetscCall(LookAt(look, k, to));
  PetscFunctionReturn(0);
}

static void Meet(PetscInt i, PetscInt j, void *ctx) {
  Looking *look = (Looking *)ctx;
  if (look->error || look->self->arc[j] - look->self->arc[i + 1] < look->self->apart) return;
  look->error = LookFrom(look, i, j);
  if (!look->error) look->error = LookFrom(look, j, i);
}

/* Pairs are kept up to this distance from touching, in diameters, and looked for anew when a node
   has moved by half of it. */
static const PetscReal margin = 0.5;

static PetscErrorCode Search(Strands3 self) {
  Looking look = {.self = self,
                  .reach = (1 + margin) * self->contact->diameter + self->contact->smooth};
  Blocks line;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) self->first[self->pair[k].sample] = -1;
  self->n = 0;
  for (PetscInt i = 0; i <= self->cells; i++)
    for (int d = 0; d < 3; d++) self->seen[3 * i + d] = self->joint[i].x[d];
  PetscCall(BlocksOfLine(3, self->cells, 3, self->seen, NULL, &line));
  BlocksPairs(line, look.reach, SameStrand, Meet, &look);
  PetscCall(BlocksDestroy(&line));
  PetscCall(look.error);
  PetscFunctionReturn(0);
}

/*
  Strands3Search - looks for all pairs that are near to touching, in a state that Strands3Load() is
  asked for next. Not collective: the same on every rank.
*/
PetscErrorCode Strands3Search(Strands3 self, const StrandState3 *state) {
  PetscFunctionBegin;
  PetscCall(LawsAt(self, state->t));
  JointsIn(self, state, NULL);
  PetscCall(Search(self));
  self->searched = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* Has a node moved so far that there may be other pairs? */
static PetscBool Moved(const struct _Strands3 *self) {
  const PetscReal far = PetscSqr(margin * self->contact->diameter / 2);

  for (PetscInt i = 0; i <= self->cells; i++) {
    const PetscReal *x = self->joint[i].x, *y = self->seen + 3 * i;
    if (!(PetscSqr(x[0] - y[0]) + PetscSqr(x[1] - y[1]) + PetscSqr(x[2] - y[2]) < far))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ---- forces ---- */

/* The velocity of a place, x_t + c t, and its derivative by z. */
static void MotionOf(const struct _Strands3 *self, const Spot *spot, Motion *m) {
  const PetscReal z = spot->z;
  PetscReal value[4], slope[4], bend[4], c_z, along;
  Ends e;

  EndsOf(self, spot->cell, &e);
  Hermite(z, value, slope, bend);
  m->size = PetscSqrtReal(Dot3(spot->slope, spot->slope));
  m->c = Between(self->c, spot->cell, z);
  c_z = BetweenSlope(self->c, spot->cell, z);
  for (int d = 0; d < 3; d++) m->t[d] = spot->slope[d] / m->size;
  along = Dot3(m->t, spot->bend);
  for (int d = 0; d < 3; d++) {
    m->v[d] = m->c * m->t[d];
    m->v_z[d] = c_z * m->t[d] + m->c * (spot->bend[d] - along * m->t[d]) / m->size;
    for (int k = 0; k < 2; k++) {
      const Joint *joint = &e.joint[k];
      PetscReal turn = e.h * (e.g_t[k] * joint->d[d] + e.g[k] * joint->d_t[d]);
      m->v[d] += value[2 * k] * joint->x_t[d] + value[2 * k + 1] * turn;
      m->v_z[d] += slope[2 * k] * joint->x_t[d] + slope[2 * k + 1] * turn;
    }
  }
}

/* The length of rod that a pair stands for; on the tip, that of its point contact. */
static PetscReal ShareOf(const struct _Strands3 *self, const Pair *pair) {
  const PetscReal *s = self->scene->mesh.s;
  PetscInt cell = pair->at.cell;

  if (IsTip(self, pair->sample)) return self->contact->tip;
  return Between(self->g, cell, pair->at.z) * (s[cell + 1] - s[cell]) / (2 * self->each);
}

/* Where a pair is, and its gap. */
static void PairPlace(const struct _Strands3 *self, Pair *pair) {
  PetscReal o[3];

  pair->at = *SampleSpot(self, pair->sample);
  FootFrom(self, pair->at.x, &pair->foot, &pair->ends);
  for (int d = 0; d < 3; d++) o[d] = pair->at.x[d] - pair->foot.x[d];
  pair->distance = PetscSqrtReal(Dot3(o, o));
  for (int d = 0; d < 3; d++) pair->n[d] = o[d] / pair->distance;
  pair->gap = pair->distance - self->contact->diameter;
  pair->apart =
      (PetscBool)(PetscAbsReal(ArcAt(self, &pair->at) - ArcAt(self, &pair->foot)) >= self->apart);
  pair->active =
      (PetscBool)(pair->gap < self->contact->smooth && pair->apart && pair->distance > 0);
}

/* Twist of a cell, per length: by how much the directors of its nodes turn about d1 between them.
 */
static PetscReal TwistOf(const struct _Strands3 *self, PetscInt cell) {
  const Joint *a = self->joint + cell, *b = a + 1;
  const PetscReal length = self->arc[cell + 1] - self->arc[cell];

  return QuaternionSpin(a->p, PetscSqrtReal(a->size * b->size), b->p) / length;
}

/* The spin of the material is between nodes linear, but for what slides past them: c times the
   twist. The lever is that of contact_space.h, a = -D/2 t x n on both strands. */
static void TurningOf(const struct _Strands3 *self, const Spot *spot, const Motion *motion,
                      const PetscReal n[3], Turning *turning) {
  const Joint *a = self->joint + spot->cell, *b = a + 1;
  const PetscReal z = spot->z;
  PetscReal twist;

  for (int d = 0; d < 3; d++) turning->t[d] = motion->t[d];
  Cross3(turning->t, n, turning->a);
  for (int d = 0; d < 3; d++) turning->a[d] *= -self->contact->diameter / 2;
  turning->spin = (1 - z) * a->spin + z * b->spin;
  turning->spin_z = b->spin - a->spin;
  if (motion->c == 0) return;
  twist = TwistOf(self, spot->cell);
  turning->spin += motion->c * twist;
  turning->spin_z += BetweenSlope(self->c, spot->cell, z) * twist;
}

/* V = v - v_foot of the centre lines, whole; across n, and with the spins, that of the surfaces. */
static void PairSlip(const struct _Strands3 *self, Pair *pair, PetscReal V[3]) {
  const Spot *spot[2] = {&pair->at, &pair->foot};
  PetscReal normal;
  Motion motion[2];

  for (int k = 0; k < 2; k++) MotionOf(self, spot[k], &motion[k]);
  for (int d = 0; d < 3; d++) V[d] = motion[0].v[d] - motion[1].v[d];
  normal = Dot3(pair->n, V);
  for (int d = 0; d < 3; d++) pair->slip[d] = V[d] - normal * pair->n[d];
  pair->slip[3] = 0;
  for (int k = 0; k < 2; k++) {
    Turning *turning = &pair->turning[k];
    TurningOf(self, spot[k], &motion[k], pair->n, turning);
    for (int d = 0; d < 3; d++) pair->slip[d] += turning->spin * turning->a[d];
  }
}

/* The force on the sample, per length of rod that it stands for:  f = p (n - mu w). */
static void PairForce(const struct _Strands3 *self, const Pair *pair, PetscReal f[3]) {
  for (int d = 0; d < 3; d++) f[d] = pair->p * (pair->n[d] - self->contact->friction * pair->w[d]);
}

/* Hands a force, or a couple, on a place to the points around it, as load per label, n' = load. */
static void HandTo(const struct _Strands3 *self, const Spot *spot, PetscReal share,
                   const PetscReal f[3], PetscReal (*load)[3]) {
  Spread spread;

  SpreadEvenly(self->points, spot->cell, spot->z, &spread);
  for (int k = 0; k < 4; k++)
    for (int d = 0; d < 3; d++)
      load[spread.point[k]][d] -= share * f[d] * spread.share[k] / self->weight[spread.point[k]];
}

/* The same on a sample, which may be that of the tip. */
static void HandToSample(const struct _Strands3 *self, const Pair *pair, const PetscReal f[3],
                         PetscReal (*load)[3]) {
  const PetscReal share = ShareOf(self, pair);

  if (IsTip(self, pair->sample))
    for (int d = 0; d < 3; d++) load[self->points][d] += share * f[d];
  else
    HandTo(self, &pair->at, share, f, load);
}

/* What pushes the beginning of a rod that is fed in back along it, the clamp's direction x1: the
   clamp bears that, for it is the clamp that is there, at rest, while the material moves on. */
static PetscBool OnClamp(const struct _Strands3 *self, const Pair *pair) {
  return (PetscBool)(pair->ends && pair->foot.cell == 0 && pair->foot.z == 0 && self->c[0] != 0);
}

static void HandOut(Strands3 self, const Pair *pair, const PetscReal f[3]) {
  const PetscReal share = ShareOf(self, pair),
                  borne = OnClamp(self, pair) ? pair->p * pair->n[0] : 0,
                  on_foot[3] = {f[0] - borne, f[1], f[2]};

  self->sum.clamp[0] -= share * borne;
  HandToSample(self, pair, f, self->force);
  HandTo(self, &pair->foot, -share, on_foot, self->force);
}

/* The couples a.f t of friction on both strands. */
static void HandCouples(const struct _Strands3 *self, const Pair *pair, const PetscReal f[3]) {
  PetscReal couple[2][3];

  for (int k = 0; k < 2; k++) {
    const Turning *turning = &pair->turning[k];
    for (int d = 0; d < 3; d++) couple[k][d] = Dot3(turning->a, f) * turning->t[d];
  }
  HandToSample(self, pair, couple[0], self->couple);
  HandTo(self, &pair->foot, ShareOf(self, pair), couple[1], self->couple);
}

static void AddToSum(Strands3 self, const Pair *pair) {
  StrandSum3 *sum = &self->sum;
  PetscReal share = ShareOf(self, pair), U = ContactEnergy(self->contact, pair->gap),
            U_t = ContactEnergyRate(self->contact, pair->gap);

  sum->energy += share * U;
  sum->strain += share * U_t;
  if (IsTip(self, pair->sample))
    sum->strain += self->contact->tip_t * U;
  else {
    const PetscReal *s = self->scene->mesh.s;
    PetscInt cell = pair->at.cell;
    sum->strain +=
        Between(self->strain, cell, pair->at.z) * (s[cell + 1] - s[cell]) / (2 * self->each) * U;
  }
  if (!pair->sample) sum->strain += self->c[0] / 2 * U; /* what is fed in comes with it */
  sum->normal += share * pair->p;
  sum->loss += share * self->contact->friction * pair->p * Dot3(pair->w, pair->slip);
}

static void Nearest(Strands3 self, const Pair *pair) {
  const PetscReal *s = self->scene->mesh.s;
  const Spot *spot[2] = {&pair->at, &pair->foot};

  if (!pair->apart || pair->gap >= self->sum.nearest) return;
  self->sum.nearest = pair->gap;
  for (int k = 0; k < 2; k++)
    self->sum.at[k] = s[spot[k]->cell] + spot[k]->z * (s[spot[k]->cell + 1] - s[spot[k]->cell]);
  for (int d = 0; d < 3; d++) self->sum.x[d] = (pair->at.x[d] + pair->foot.x[d]) / 2;
}

/* How many zones of contact there are: samples, one after the other, that touch what lies farther
   along the rod. */
static PetscInt Zones(const struct _Strands3 *self) {
  PetscInt zones = 0, before = -2;

  for (PetscInt sample = 0; sample < self->samples; sample++)
    for (PetscInt k = self->first[sample]; k >= 0; k = self->pair[k].next) {
      const Pair *pair = &self->pair[k];
      if (!pair->active || !ContactBears(self->contact, pair->gap) ||
          pair->foot.cell < pair->at.cell)
        continue;
      zones += before < sample - 1;
      before = sample;
    }
  return zones;
}

/*
  Strands3Load - finds the feet of all pairs and their forces, after a new search if nodes have
  moved far since the last. Not collective: the same on every rank.
*/
PetscErrorCode Strands3Load(Strands3 self, const StrandState3 *state) {
  PetscReal f[3], V[3];

  PetscFunctionBegin;
  PetscCall(LawsAt(self, state->t));
  if (!self->searched) JointsIn(self, state, NULL);
  if (!self->searched && Moved(self)) PetscCall(Search(self));
  self->searched = PETSC_FALSE;
  PetscCall(PetscArrayzero(self->force, self->points + 1));
  if (self->couple) PetscCall(PetscArrayzero(self->couple, self->points + 1));
  PetscCall(PetscMemzero(&self->sum, sizeof(self->sum)));
  self->sum.nearest = PETSC_MAX_REAL;
  for (PetscInt k = 0; k < self->n; k++) {
    Pair *pair = &self->pair[k];
    PairPlace(self, pair);
    Nearest(self, pair);
    if (!pair->active) continue;
    pair->p = ContactPressure(self->contact, pair->gap, &pair->p_gap);
    if (self->contact->friction > 0 && state->u_t) {
      PairSlip(self, pair, V);
      FrictionForce4(&self->contact->rub, pair->slip, &pair->dual, pair->w);
    }
    PairForce(self, pair, f);
    HandOut(self, pair, f);
    if (self->couple && state->u_t) HandCouples(self, pair, f);
    AddToSum(self, pair);
  }
  self->sum.zones = Zones(self);
  for (int d = 0; d < 3; d++) {
    self->sum.sum[d] = self->sum.clamp[d] + self->force[self->points][d];
    for (PetscInt k = 0; k < self->points; k++)
      self->sum.sum[d] -= self->force[k][d] * self->weight[k];
  }
  PetscFunctionReturn(0);
}

/* Strands3Forces - what Strands3Load() has found: what contact adds to n' at each point (2 cells +
   1 of them), and behind them the force on the tip. Borrowed. */
const PetscReal (*Strands3Forces(Strands3 self))[3] {
  return (const PetscReal(*)[3])self->force;
}

/* Strands3Couples - the couples that belong to them, of friction: what contact adds to m'; NULL:
   there is no friction. Borrowed. */
const PetscReal (*Strands3Couples(Strands3 self))[3] {
  return (const PetscReal(*)[3])self->couple;
}

/* Strands3Sum - the sums over all places in contact that Strands3Load() has found. */
void Strands3Sum(Strands3 self, StrandSum3 *sum) {
  *sum = self->sum;
}

/* ---- derivatives ---- */

/* By the unknowns of one cell. */
typedef PetscReal ByCell[3][STRAND3_CELL];

/* The derivatives of a place at fixed z, and of x_z. */
static void SpotSlope(const Ends *e, PetscReal z, ByCell by, ByCell slope_by) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(z, value, slope, bend);
  for (int d = 0; d < 3; d++)
    for (int k = 0; k < 2; k++) {
      const PetscReal *turn = e->joint[k].by[d], length = e->h * e->g[k];
      PetscReal *to = by[d] + STRAND3_NODE * k, *slope_to = slope_by[d] + STRAND3_NODE * k;
      for (int c = 0; c < 3; c++) {
        to[c] = c == d ? value[2 * k] : 0;
        slope_to[c] = c == d ? slope[2 * k] : 0;
      }
      for (int j = 0; j < 4; j++) {
        to[3 + j] = value[2 * k + 1] * length * turn[j];
        slope_to[3 + j] = slope[2 * k + 1] * length * turn[j];
      }
    }
}

/* The derivatives of its velocity at fixed z:  dv = ... + c dt,  dt = (I - t t^T) dx_z/|x_z|. */
static void MotionSlope(const struct _Strands3 *self, const Spot *spot, const PetscReal shift[],
                        ByCell by) {
  PetscReal value[4], slope[4], bend[4];
  ByCell x_by, z_by;
  Motion m;
  Ends e;

  EndsOf(self, spot->cell, &e);
  Hermite(spot->z, value, slope, bend);
  SpotSlope(&e, spot->z, x_by, z_by);
  MotionOf(self, spot, &m);
  for (int f = 0; f < STRAND3_CELL; f++) {
    const int k = f / STRAND3_NODE, j = f % STRAND3_NODE;
    PetscReal along = m.t[0] * z_by[0][f] + m.t[1] * z_by[1][f] + m.t[2] * z_by[2][f];
    for (int d = 0; d < 3; d++) {
      by[d][f] = m.c * (z_by[d][f] - m.t[d] * along) / m.size;
      if (j < 3)
        by[d][f] += shift[j] * x_by[d][f];
      else
        by[d][f] += value[2 * k + 1] * e.h * e.joint[k].rate_by[d][j - 3];
    }
  }
}

/* By the unknowns of both. */
typedef PetscReal ByPair[3][STRAND3_UNKNOWNS];

/* How the pair's foot, normal, distance and slip change; and tangents and levers. */
typedef struct {
  PetscReal z[STRAND3_UNKNOWNS], gap[STRAND3_UNKNOWNS];
  ByPair n, slip, t[2], a[2];
} PairSlope;

/*
  With r = x - y the way from the foot to the sample, y_z and y_zz at the foot:
    dz = (y_z.(dx - dy) + r.dy_z) / (y_z.y_z - r.y_zz),    dr = dx - dy - y_z dz,
    dgap = n.dr,    dn = (dr - n dgap)/|r|.
*/
static void PlaceSlope(const struct _Strands3 *self, const Pair *pair, PairSlope *by) {
  const PetscReal *slope = pair->foot.slope,
                  r[3] = {pair->distance * pair->n[0], pair->distance * pair->n[1],
                          pair->distance * pair->n[2]};
  const PetscReal stiff = Dot3(slope, slope) - Dot3(r, pair->foot.bend);
  ByCell x, y, y_z, skip;
  Ends e;

  EndsOf(self, pair->at.cell, &e);
  SpotSlope(&e, pair->at.z, x, skip);
  EndsOf(self, pair->foot.cell, &e);
  SpotSlope(&e, pair->foot.z, y, y_z);
  for (int f = 0; f < STRAND3_UNKNOWNS; f++) {
    PetscBool of_foot = (PetscBool)(f >= STRAND3_CELL);
    int g = f % STRAND3_CELL;
    PetscReal dr[3];
    for (int d = 0; d < 3; d++) dr[d] = of_foot ? -y[d][g] : x[d][g];
    by->z[f] = 0;
    if (!pair->ends) {
      PetscReal turned = r[0] * y_z[0][g] + r[1] * y_z[1][g] + r[2] * y_z[2][g];
      by->z[f] = (Dot3(slope, dr) + (of_foot ? turned : 0)) / stiff;
    }
    for (int d = 0; d < 3; d++) dr[d] -= slope[d] * by->z[f];
    by->gap[f] = Dot3(pair->n, dr);
    for (int d = 0; d < 3; d++) by->n[d][f] = (dr[d] - pair->n[d] * by->gap[f]) / pair->distance;
  }
}

/* How the twist of a cell changes with an unknown of it. */
static PetscReal TwistSlope(const struct _Strands3 *self, PetscInt cell, int f) {
  const Joint *a = self->joint + cell, *b = a + 1, *at = f < STRAND3_NODE ? a : b;
  const int j = f % STRAND3_NODE - 3;
  const PetscReal *p = a->p, *q = b->p, size = PetscSqrtReal(a->size * b->size),
                  length = self->arc[cell + 1] - self->arc[cell];
  const PetscReal by[2][4] = {{q[1], -q[0], -q[3], q[2]}, {-p[1], p[0], p[3], -p[2]}};

  if (j < 0) return 0;
  return 2 / (size * length) * by[at == b][j] - TwistOf(self, cell) * at->p[j] / at->size;
}

/*
  Tangent and lever of a strand, and what its spin adds to the slip:
    dt = (I - t t^T)(dx_z + x_zz dz)/|x_z|,   da = -D/2 (dt x n + t x dn),   d(spin a).
*/
static void TurningSlope(const struct _Strands3 *self, const Pair *pair, int which, PairSlope *by) {
  const Spot *spot = which ? &pair->foot : &pair->at;
  const Turning *turning = &pair->turning[which];
  const PetscReal *t = turning->t, half = self->contact->diameter / 2,
                  size = PetscSqrtReal(Dot3(spot->slope, spot->slope)),
                  slide = Between(self->c, spot->cell, spot->z);
  const Joint *joint = self->joint + spot->cell;
  ByCell skip, slope;
  Ends e;

  EndsOf(self, spot->cell, &e);
  SpotSlope(&e, spot->z, skip, slope);
  for (int f = 0; f < STRAND3_UNKNOWNS; f++) {
    const int g = f % STRAND3_CELL, end = g / STRAND3_NODE, j = g % STRAND3_NODE - 3;
    const PetscBool own = (PetscBool)((f >= STRAND3_CELL) == which);
    const PetscReal dn[3] = {by->n[0][f], by->n[1][f], by->n[2][f]};
    PetscReal dt[3], turned[3], leaned[3], spin = 0, along;
    for (int d = 0; d < 3; d++)
      dt[d] = (own ? slope[d][g] : 0) + (which ? spot->bend[d] * by->z[f] : 0);
    along = Dot3(t, dt);
    for (int d = 0; d < 3; d++) dt[d] = (dt[d] - t[d] * along) / size;
    Cross3(dt, pair->n, turned);
    Cross3(t, dn, leaned);
    if (own && j >= 0) spin = (end ? spot->z : 1 - spot->z) * joint[end].spin_by[j];
    if (own && slide != 0) spin += slide * TwistSlope(self, spot->cell, g);
    if (which) spin += turning->spin_z * by->z[f];
    for (int d = 0; d < 3; d++) {
      by->t[which][d][f] = dt[d];
      by->a[which][d][f] = -half * (turned[d] + leaned[d]);
      by->slip[d][f] += spin * turning->a[d] + turning->spin * by->a[which][d][f];
    }
  }
}

/* slip = V - n (n.V) + ..., V the relative velocity:  dslip = dV - n (n.dV + V.dn) - dn (n.V) + ...
   TurningSlope(). */
static void SlipSlope(const struct _Strands3 *self, Pair *pair, const PetscReal shift[],
                      PairSlope *by) {
  ByCell v[2];
  PetscReal V[3], normal;
  Motion foot;

  PairSlip(self, pair, V);
  normal = Dot3(pair->n, V);
  MotionOf(self, &pair->foot, &foot);
  MotionSlope(self, &pair->at, shift, v[0]);
  MotionSlope(self, &pair->foot, shift, v[1]);
  for (int f = 0; f < STRAND3_UNKNOWNS; f++) {
    int of_foot = f >= STRAND3_CELL, g = f % STRAND3_CELL;
    PetscReal dV[3], dn[3] = {by->n[0][f], by->n[1][f], by->n[2][f]}, along;
    for (int d = 0; d < 3; d++)
      dV[d] = (of_foot ? -v[1][d][g] : v[0][d][g]) - foot.v_z[d] * by->z[f];
    along = Dot3(pair->n, dV) + Dot3(V, dn);
    for (int d = 0; d < 3; d++) by->slip[d][f] = dV[d] - pair->n[d] * along - dn[d] * normal;
  }
  for (int which = 0; which < 2; which++) TurningSlope(self, pair, which, by);
}

/* df = dp (n - mu w) + p (dn - mu w' dslip) */
static void ForceSlope(const struct _Strands3 *self, const Pair *pair, const PairSlope *by,
                       PetscReal df[3][STRAND3_UNKNOWNS]) {
  const PetscReal mu = self->contact->friction;

  for (int d = 0; d < 3; d++)
    for (int u = 0; u < STRAND3_UNKNOWNS; u++) {
      PetscReal rub = pair->by[d][0] * by->slip[0][u] + pair->by[d][1] * by->slip[1][u] +
                      pair->by[d][2] * by->slip[2][u];
      df[d][u] = pair->p_gap * by->gap[u] * (pair->n[d] - mu * pair->w[d]) +
                 pair->p * (by->n[d][u] - mu * rub);
    }
}

/* d(a.f t) = (da.f + a.df) t + a.f dt */
static void CoupleSlope(const Pair *pair, const PairSlope *by, const PetscReal f[3],
                        PetscReal df[3][STRAND3_UNKNOWNS], int which, ByPair dl) {
  const Turning *turning = &pair->turning[which];
  const PetscReal about = Dot3(turning->a, f);

  for (int u = 0; u < STRAND3_UNKNOWNS; u++) {
    PetscReal more = 0;
    for (int d = 0; d < 3; d++) more += by->a[which][d][u] * f[d] + turning->a[d] * df[d][u];
    for (int d = 0; d < 3; d++) dl[d][u] = more * turning->t[d] + about * by->t[which][d][u];
  }
}

/* Couples go where the forces of their strand go, the foot's first. */
static void CouplesSlope(const struct _Strands3 *self, const Pair *pair, const PairSlope *by,
                         const PetscReal f[3], PetscReal df[3][STRAND3_UNKNOWNS],
                         const Spread spread[2], StrandSlope3 *slope) {
  const PetscReal share = ShareOf(self, pair);
  ByPair dl;

  for (int which = 0, n = 4; which < 2; which++, n = 0) {
    const PetscReal about = Dot3(pair->turning[which].a, f);
    CoupleSlope(pair, by, f, df, which, dl);
    for (int k = 0; k < 4; k++, n++) {
      const PetscBool tip = (PetscBool)(!which && IsTip(self, pair->sample));
      const PetscReal part = tip ? share : -share / self->weight[spread[which].point[k]];
      for (int d = 0; d < 3; d++)
        for (int u = 0; u < STRAND3_UNKNOWNS; u++) {
          PetscReal moved =
              which ? about * pair->turning[1].t[d] * spread[1].share_z[k] * by->z[u] : 0;
          slope->couple_by[n][d][u] =
              part * ((tip ? 1 : spread[which].share[k]) * dl[d][u] + moved);
        }
      if (tip) break;
    }
  }
}

/* The derivatives of what each taker takes. */
static void TakersSlope(const struct _Strands3 *self, const Pair *pair, const PairSlope *by,
                        StrandSlope3 *slope) {
  const PetscReal share = ShareOf(self, pair);
  PetscReal f[3], df[3][STRAND3_UNKNOWNS], borne[3][STRAND3_UNKNOWNS] = {{0}};
  Spread spread[2], *at = &spread[0], *foot = &spread[1];
  int n = 4;

  SpreadEvenly(self->points, pair->at.cell, pair->at.z, at);
  SpreadEvenly(self->points, pair->foot.cell, pair->foot.z, foot);
  PairForce(self, pair, f);
  ForceSlope(self, pair, by, df);
  for (int u = 0; u < STRAND3_UNKNOWNS && OnClamp(self, pair); u++)
    borne[0][u] = pair->p_gap * by->gap[u] * pair->n[0] + pair->p * by->n[0][u];
  slope->cell[0] = pair->at.cell;
  slope->cell[1] = pair->foot.cell;
  for (int k = 0; k < 4; k++) {
    slope->taker[k] = foot->point[k];
    for (int d = 0; d < 3; d++)
      for (int u = 0; u < STRAND3_UNKNOWNS; u++)
        slope->by[k][d][u] =
            share *
            ((df[d][u] - borne[d][u]) * foot->share[k] + f[d] * foot->share_z[k] * by->z[u]) /
            self->weight[foot->point[k]];
  }
  if (IsTip(self, pair->sample)) {
    slope->taker[n] = self->points;
    for (int d = 0; d < 3; d++)
      for (int u = 0; u < STRAND3_UNKNOWNS; u++) slope->by[n][d][u] = share * df[d][u];
    n++;
  } else
    for (int k = 0; k < 4; k++, n++) {
      slope->taker[n] = at->point[k];
      for (int d = 0; d < 3; d++)
        for (int u = 0; u < STRAND3_UNKNOWNS; u++)
          slope->by[n][d][u] = -share * at->share[k] * df[d][u] / self->weight[at->point[k]];
    }
  slope->takers = n;
  slope->couples = (PetscBool)(self->couple != NULL);
  if (self->couple) CouplesSlope(self, pair, by, f, df, spread, slope);
}

/*
  Strands3Linearise - the derivatives of the forces that Strands3Load() found in the same state. Not
  collective: the same on every rank.

  shift   of the rates of x and p: du_t/du
  fresh   a Newton solve begins
  n       how many contacts there are; slopes: of each, borrowed
*/
PetscErrorCode Strands3Linearise(Strands3 self, const StrandState3 *state,
                                 const PetscReal shift[STRAND3_NODE], PetscBool fresh, PetscInt *n,
                                 const StrandSlope3 **slopes) {
  PetscFunctionBegin;
  if (self->slopes_room < self->n) {
    self->slopes_room = self->room;
    PetscCall(PetscFree(self->slopes));
    PetscCall(PetscMalloc1(self->slopes_room, &self->slopes));
  }
  *n = 0;
  *slopes = self->slopes;
  JointsIn(self, state, shift);
  for (PetscInt k = 0; k < self->n; k++) {
    Pair *pair = &self->pair[k];
    PairSlope by = {.z = {0}};
    if (!pair->active) continue;
    PlaceSlope(self, pair, &by);
    if (self->contact->friction > 0) {
      SlipSlope(self, pair, shift, &by);
      FrictionLinearise4(&self->contact->rub, pair->slip, fresh, &pair->dual, pair->by);
    }
    TakersSlope(self, pair, &by, &self->slopes[(*n)++]);
  }
  PetscFunctionReturn(0);
}

/* Strands3Near - the cells of all pairs that are near to touching: of the sample, of the foot, each
   once. The caller frees them. */
PetscErrorCode Strands3Near(Strands3 self, PetscInt *n, PetscInt (**cells)[2]) {
  PetscInt m = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(self->n, cells));
  for (PetscInt k = 0; k < self->n; k++) {
    const PetscInt a = self->pair[k].at.cell, b = self->pair[k].foot.cell;
    PetscInt seen = m - 1;
    while (seen >= 0 && m - seen <= 2 * self->each &&
           ((*cells)[seen][0] != a || (*cells)[seen][1] != b))
      seen--;
    if (seen >= 0 && (*cells)[seen][0] == a && (*cells)[seen][1] == b) continue;
    (*cells)[m][0] = a;
    (*cells)[m++][1] = b;
  }
  *n = m;
  PetscFunctionReturn(0);
}

/* ---- life ---- */

/* How many samples a cell has, so that they are close when the rod is longest. */
static PetscErrorCode SamplesOf(Scene scene, PetscInt *each) {
  const PetscInt cells = scene->mesh.cells;
  PetscReal *arc, longest = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(cells + 1, &arc));
  PetscCall(GrowthArc(scene->growth, cells + 1, scene->mesh.s, scene->end_time, arc, NULL));
  for (PetscInt i = 0; i < cells; i++) longest = PetscMax(longest, arc[i + 1] - arc[i]);
  PetscCall(PetscFree(arc));
  *each = 1 + (PetscInt)PetscMin(MOST_SAMPLES - 1, longest / (fine * scene->contact.diameter));
  PetscFunctionReturn(0);
}

/* Strands3Create - for a rod of a scene that has -contact_self, which must outlive it. Not
   collective; the caller destroys it with Strands3Destroy(). */
PetscErrorCode Strands3Create(Scene scene, Strands3 *strands) {
  const PetscInt cells = scene->mesh.cells, n = 2 * cells + 1;
  Strands3 self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *strands = self;
  self->scene = scene;
  self->contact = &scene->contact;
  self->cells = cells;
  self->points = n;
  PetscCall(SamplesOf(scene, &self->each));
  self->samples = cells * self->each + 1;
  self->apart = PETSC_PI / 2 * scene->contact.diameter;
  self->time = PETSC_MIN_REAL;
  PetscCall(PetscCalloc6(n, &self->g, n, &self->g_t, n, &self->c, n, &self->strain, cells + 1,
                         &self->arc, n, &self->weight));
  PetscCall(PetscCalloc4(self->samples, &self->first, 3 * (cells + 1), &self->seen, n + 1,
                         &self->force, cells + 1, &self->joint));
  PetscCall(PetscCalloc2(self->samples, &self->spot, self->samples, &self->placed));
  if (scene->contact.friction > 0) PetscCall(PetscCalloc1(n + 1, &self->couple));
  for (PetscInt k = 0; k < self->samples; k++) self->first[k] = -1;
  for (PetscInt k = 0; k < 3 * (cells + 1); k++) self->seen[k] = PETSC_MAX_REAL;
  CurveWeights(cells, scene->mesh.s, self->weight);
  PetscFunctionReturn(0);
}

PetscErrorCode Strands3Destroy(Strands3 *strands) {
  Strands3 self = *strands;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(PetscFree6(self->g, self->g_t, self->c, self->strain, self->arc, self->weight));
  PetscCall(PetscFree4(self->first, self->seen, self->force, self->joint));
  PetscCall(PetscFree2(self->spot, self->placed));
  PetscCall(PetscFree(self->couple));
  PetscCall(PetscFree(self->pair));
  PetscCall(PetscFree(self->slopes));
  PetscCall(PetscFree(*strands));
  PetscFunctionReturn(0);
}
