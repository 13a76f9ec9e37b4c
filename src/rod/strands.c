#include "base/blocks.h"
#include "curve/nearest.h"
#include "rod/directors.h"
#include "rod/strand_pairs.h"
#include "rod/rules.h"

enum { MOST_SAMPLES = 32 }; /* of a cell */

/* ---- the curve ---- */

/* The length of a vector. (In the plane hypot() has another last digit.) */
static inline PetscReal Length(const struct _Strands *self, const PetscReal v[3]) {
  return self->dims == 2 ? hypot(v[0], v[1]) : PetscSqrtReal(Dot3(v, v));
}

/* Where a sample is in the state that is looked at. */
static const Spot *SampleSpot(const struct _Strands *self, PetscInt sample) {
  const PetscBool tip = SampleIsTip(self, sample);
  Spot *spot = &self->spot[sample];
  CurveCell cell;

  if (self->placed[sample]) return spot;
  self->placed[sample] = PETSC_TRUE;
  spot->cell = tip ? self->cells - 1 : sample / self->each;
  spot->on.z = tip ? 1 : (sample % self->each + self->ahead) / self->each;
  StrandCell(self, spot->cell, &cell);
  CurvePlaceAt(&cell, &spot->on);
  return spot;
}

/* The arc length of a place. */
static PetscReal ArcAt(const struct _Strands *self, const Spot *spot) {
  return self->arc[spot->cell] + spot->on.z * (self->arc[spot->cell + 1] - self->arc[spot->cell]);
}

/*
  FootFrom - the place of the curve nearest to x, by Newton's method on (x - y(z)).y_z = 0 from a
  place near it, on to the next cell where that is. ends: it is an end of the rod.
*/
static void FootFrom(const struct _Strands *self, const PetscReal x[3], Spot *foot,
                     PetscBool *ends) {
  CurvePlace *on = &foot->on;
  CurveCell cell;

  *ends = PETSC_FALSE;
  StrandCell(self, foot->cell, &cell);
  for (int k = 0; k < CURVE_MOST; k++) {
    PetscReal o[3], step;
    CurveWay way;
    CurvePlaceAt(&cell, on);
    for (int d = 0; d < 3; d++) o[d] = x[d] - on->x[d];
    step = CurveStep(Dot3(o, on->slope), Dot3(on->slope, on->slope), Dot3(o, on->bend));
    way = CurveGo(self->cells, on->z + step, &foot->cell, &on->z, ends);
    if (way == CURVE_ARRIVED) return;
    if (way == CURVE_NEXT) StrandCell(self, foot->cell, &cell);
  }
  CurvePlaceAt(&cell, on);
}

/* ---- laws, and the state ---- */

/* What the laws give at time t: at the points, and the arc length at the nodes. */
static PetscErrorCode LawsAt(Strands self, PetscReal t) {
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
static void SpinSlopeAt(const Joint *joint, const PetscReal p_t[4], const PetscReal shift[4],
                        PetscReal by[4]) {
  PetscReal by_rate[4], by_p[4];

  SpinForm(joint->p, by_rate);
  SpinForm(p_t, by_p);
  for (int j = 0; j < 4; j++)
    by[j] = 2 / joint->size * (shift[j] * by_rate[j] - by_p[j] - joint->spin * joint->p[j]);
}

/* A node in space, whose quaternion is p. */
static void JointInSpace(const PetscReal p[4], const PetscReal p_t[4], PetscReal g, PetscReal g_t,
                         const PetscReal *shift, Joint *joint) {
  PetscReal d[3][3], D[3][4];

  joint->p = p;
  joint->size = QuaternionSize(p);
  Directors(p, joint->size, d);
  DirectorSlope(p, joint->size, d[0], 0, D);
  joint->spin = QuaternionSpin(p, joint->size, p_t);
  for (int c = 0; c < 3; c++) {
    joint->q[c] = d[0][c];
    joint->q_t[c] = Dot4(D[c], p_t);
  }
  if (!shift) return;
  DirectorRateSlope(p, joint->size, d[0], joint->q_t, 0, D, p_t, joint->by.slope_t);
  SpinSlopeAt(joint, p_t, shift, joint->spin_by);
  for (int c = 0; c < 3; c++)
    for (int j = 0; j < 4; j++) {
      joint->by.q[c][j] = D[c][j];
      joint->by.slope_t[c][j] = g_t * D[c][j] + g * (shift[j] * D[c][j] + joint->by.slope_t[c][j]);
    }
}

/* One in the plane, at the angle theta; the derivatives are those of q, q_perp and -q. */
static void JointInPlane(PetscReal theta, PetscReal theta_t, PetscReal g, PetscReal g_t,
                         const PetscReal *shift, Joint *joint) {
  const Vector2 q = Direction2(theta), perp = Left2(q);

  Put2(q, joint->q);
  Put2(Times2(theta_t, perp), joint->q_t);
  CurveEndInPlane(q, theta_t, g, g_t, shift ? *shift : 0, &joint->by);
}

/* StrandJoints - the nodes in a state; with their derivatives if there are shifts of the rates,
   else it is a new one. */
void StrandJoints(Strands self, const StrandState *state, const PetscReal *shift) {
  const PetscReal still[STRAND_NODE] = {0};
  const int dims = self->dims;

  for (PetscInt k = 0; k < self->samples && !shift; k++) self->placed[k] = PETSC_FALSE;
  for (PetscInt i = 0; i <= self->cells; i++) {
    const PetscReal *u = state->u + i * state->stride, g = self->g[2 * i], g_t = self->g_t[2 * i],
                    *u_t = state->u_t ? state->u_t + i * state->stride : still;
    Joint *joint = &self->joint[i];
    for (int d = 0; d < dims; d++) {
      joint->x[d] = u[d];
      joint->x_t[d] = u_t[d];
      if (shift) joint->by.shift[d] = shift[d];
    }
    const PetscReal *turn = u + dims + state->between,
                    *turn_t = state->u_t ? u_t + dims + state->between : still;
    if (dims == 2)
      JointInPlane(*turn, *turn_t, g, g_t, shift ? shift + dims : NULL, joint);
    else
      JointInSpace(turn, turn_t, g, g_t, shift ? shift + dims : NULL, joint);
  }
}

/* ---- which samples are near to what ---- */

/* A search under way. */
typedef struct {
  Strands self;
  PetscReal reach;
  PetscErrorCode error;
} Looking;

static PetscBool SameStrand(const Block *a, PetscInt first_a, PetscInt last_a, const Block *b,
                            PetscInt first_b, PetscInt last_b, void *ctx) {
  const Strands self = ((const Looking *)ctx)->self;
  return (PetscBool)(self->arc[last_b] - self->arc[first_a] < self->apart);
}

/* Is the foot of x on this cell? 1 yes; 2 it is the end of the rod there; 0 no. */
static int HasFoot(const struct _Strands *self, PetscInt cell, const PetscReal x[3]) {
  const Joint *joint = self->joint + cell;
  PetscReal f[2];

  for (int k = 0; k < 2; k++) {
    PetscReal o[3];
    for (int d = 0; d < 3; d++) o[d] = x[d] - joint[k].x[d];
    f[k] = Dot3(o, joint[k].q);
  }
  if (f[0] >= 0 && f[1] < 0) return 1;
  if ((cell == 0 && f[0] < 0) || (cell == self->cells - 1 && f[1] >= 0)) return 2;
  return 0;
}

/* A new pair. Of two feet of a sample on one side, in space of those that are near each other along
   the rod and so of one strand, the nearer counts. */
static PetscErrorCode Keep(Strands self, const Pair *pair) {
  PetscInt *first = &self->first[self->sides * pair->sample + pair->side], next = *first;
  const PetscReal at = ArcAt(self, &pair->foot);

  PetscFunctionBegin;
  for (PetscInt k = next; k >= 0; k = self->pair[k].next) {
    Pair *other = &self->pair[k];
    if (self->dims == 3 && PetscAbsReal(ArcAt(self, &other->foot) - at) >= self->apart) continue;
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
  *first = self->n;
  self->pair[self->n] = *pair;
  self->pair[self->n++].next = next;
  PetscFunctionReturn(0);
}

static PetscErrorCode LookAt(Looking *look, PetscInt sample, PetscInt cell) {
  Strands self = look->self;
  const Spot *at = SampleSpot(self, sample);
  const int foot = HasFoot(self, cell, at->on.x);
  PetscReal o[3];
  Pair pair;

  PetscFunctionBegin;
  if (!foot) PetscFunctionReturn(0);
  pair = (Pair){.sample = sample, .at = *at};
  pair.foot.cell = cell;
  pair.foot.on.z = foot == 1 ? 0.5 : cell ? 1 : 0;
  FootFrom(self, pair.at.on.x, &pair.foot, &pair.ends);
  for (int d = 0; d < 3; d++) o[d] = pair.foot.on.x[d] - pair.at.on.x[d];
  pair.distance = Length(self, o);
  if (self->dims == 2) pair.side = at->on.slope[0] * o[1] - at->on.slope[1] * o[0] < 0;
  if (pair.distance < look->reach) PetscCall(Keep(self, &pair));
  PetscFunctionReturn(0);
}

/* The samples of one cell against another. */
static PetscErrorCode LookFrom(Looking *look, PetscInt from, PetscInt to) {
  const Strands self = look->self;
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

static PetscErrorCode Search(Strands self) {
  Looking look = {.self = self,
                  .reach =
                      (1 + rod_rule.pair_margin) * self->contact->diameter + self->contact->smooth};
  Blocks line;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++)
    self->first[self->sides * self->pair[k].sample + self->pair[k].side] = -1;
  self->n = 0;
  for (PetscInt i = 0; i <= self->cells; i++)
    for (int d = 0; d < 3; d++) self->seen[3 * i + d] = self->joint[i].x[d];
  PetscCall(BlocksOfLine(self->dims, self->cells, 3, self->seen, NULL, &line));
  BlocksPairs(line, look.reach, SameStrand, Meet, &look);
  PetscCall(BlocksDestroy(&line));
  PetscCall(look.error);
  PetscFunctionReturn(0);
}

/*
  StrandsSearch - looks for all pairs that are near to touching, in a state that StrandsLoad() is
  asked for next. Not collective: the same on every rank.
*/
PetscErrorCode StrandsSearch(Strands self, const StrandState *state) {
  PetscFunctionBegin;
  PetscCall(LawsAt(self, state->t));
  StrandJoints(self, state, NULL);
  PetscCall(Search(self));
  self->searched = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* Has a node moved so far that there may be other pairs? */
static PetscBool Moved(const struct _Strands *self) {
  const PetscReal far = PetscSqr(rod_rule.pair_margin * self->contact->diameter / 2);

  for (PetscInt i = 0; i <= self->cells; i++) {
    PetscReal way[3];
    Minus3(self->joint[i].x, self->seen + 3 * i, way);
    if (!(Dot3(way, way) < far)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ---- forces ---- */

/* Where a pair is, and its gap. */
static void PairPlace(const struct _Strands *self, Pair *pair) {
  PetscReal o[3];

  pair->at = *SampleSpot(self, pair->sample);
  FootFrom(self, pair->at.on.x, &pair->foot, &pair->ends);
  for (int d = 0; d < 3; d++) o[d] = pair->at.on.x[d] - pair->foot.on.x[d];
  pair->distance = Length(self, o);
  for (int d = 0; d < 3; d++) pair->n[d] = o[d] / pair->distance;
  pair->gap = pair->distance - self->contact->diameter;
  pair->apart =
      (PetscBool)(PetscAbsReal(ArcAt(self, &pair->at) - ArcAt(self, &pair->foot)) >= self->apart);
  pair->active =
      (PetscBool)(pair->gap < self->contact->smooth && pair->apart && pair->distance > 0);
}

/* What a density at the points, per label, is over the labels that a sample stands for. In the
   plane the tip has a part of the last cell, too. */
static PetscReal Over(const struct _Strands *self, const PetscReal *at, const Pair *pair) {
  const PetscInt cell = pair->at.cell;
  const PetscReal *s = self->scene->mesh.s;

  if (self->dims == 2) return at[pair->sample] * self->weight[pair->sample] / 2;
  if (SampleIsTip(self, pair->sample)) return 0;
  return CurveBetween(at + 2 * cell, pair->at.on.z) * (s[cell + 1] - s[cell]) / (2 * self->each);
}

/* PairShares - the lengths of rod that a pair stands for: of the sample; of the tip's point
   contact, if it is that. */
void PairShares(const struct _Strands *self, const Pair *pair, PetscReal share[2]) {
  share[0] = Over(self, self->g, pair);
  share[1] = SampleIsTip(self, pair->sample) ? self->contact->tip : 0;
}

/* PairForce - on the sample, per length of rod that it stands for:  f = p (n - mu w). */
void PairForce(const struct _Strands *self, const Pair *pair, PetscReal f[3]) {
  for (int d = 0; d < 3; d++) f[d] = pair->p * (pair->n[d] - self->contact->friction * pair->w[d]);
}

/* PairOnClamp - what pushes the beginning of a rod that is fed in back along it, the clamp's
   direction x1: the clamp bears that, for it is the clamp that is there, at rest, while the
   material moves on. */
PetscBool PairOnClamp(const struct _Strands *self, const Pair *pair) {
  return (PetscBool)(pair->ends && pair->foot.cell == 0 && pair->foot.on.z == 0 && self->c[0] != 0);
}

/* PairSpread - who takes what acts on the foot, or else on the sample (but for the tip's own).
   Returns how many points that are. */
int PairSpread(const struct _Strands *self, const Pair *pair, int of_foot, Spread *spread) {
  const Spot *spot = of_foot ? &pair->foot : &pair->at;

  if (self->dims == 2 && !of_foot) {
    *spread = (Spread){.point = {pair->sample}, .share = {1}};
    return 1;
  }
  if (self->dims == 2)
    SpreadAt(self->points, spot->cell, spot->on.z, spread);
  else if (!of_foot && SampleIsTip(self, pair->sample))
    return 0;
  else
    SpreadEvenly(self->points, spot->cell, spot->on.z, spread);
  return 4;
}

/* Hands a force, or a couple, on a foot or a sample to the points around it, as load per label,
   n' = load. */
static void HandTo(const struct _Strands *self, const Pair *pair, int of_foot, PetscReal share,
                   const PetscReal f[3], PetscReal (*load)[3]) {
  Spread spread;
  const int n = PairSpread(self, pair, of_foot, &spread);

  for (int k = 0; k < n; k++)
    for (int d = 0; d < 3; d++)
      load[spread.point[k]][d] -= share * f[d] * spread.share[k] / self->weight[spread.point[k]];
}

/* What is on the sample, and what is on the foot. */
static void HandBoth(const struct _Strands *self, const Pair *pair, const PetscReal on_sample[3],
                     const PetscReal on_foot[3], PetscReal (*load)[3]) {
  PetscReal share[2];

  PairShares(self, pair, share);
  HandTo(self, pair, 0, share[0], on_sample, load);
  for (int d = 0; d < 3 && share[1] > 0; d++) load[self->points][d] += share[1] * on_sample[d];
  HandTo(self, pair, 1, share[0] + share[1], on_foot, load);
}

static void HandOut(Strands self, const Pair *pair, const PetscReal f[3]) {
  const PetscReal borne = PairOnClamp(self, pair) ? pair->p * pair->n[0] : 0;
  PetscReal share[2], on_foot[3];

  for (int d = 0; d < 3; d++) on_foot[d] = (d ? 0 : borne) - f[d];
  PairShares(self, pair, share);
  self->sum.clamp[0] -= (share[0] + share[1]) * borne;
  HandBoth(self, pair, f, on_foot, self->force);
}

/* The couples a.f t of friction on both strands. */
static void HandCouples(const struct _Strands *self, const Pair *pair, const PetscReal f[3]) {
  PetscReal couple[2][3];

  for (int k = 0; k < 2; k++) {
    const Turning *turning = &pair->turning[k];
    for (int d = 0; d < 3; d++) couple[k][d] = Dot3(turning->a, f) * turning->t[d];
  }
  HandBoth(self, pair, couple[0], couple[1], self->couple);
}

static void AddToSum(Strands self, const Pair *pair) {
  const PetscReal U = ContactEnergy(self->contact, pair->gap),
                  U_t = ContactEnergyRate(self->contact, pair->gap);
  StrandSum *sum = &self->sum;
  PetscReal share[2], all;

  PairShares(self, pair, share);
  all = share[0] + share[1];
  sum->energy += all * U;
  sum->strain += Over(self, self->strain, pair) * U + share[0] * U_t +
                 (share[1] > 0 ? self->contact->tip_t * U + share[1] * U_t : 0);
  if (!pair->sample) sum->strain += self->c[0] / 2 * U; /* what is fed in comes with it */
  sum->normal += all * pair->p;
  sum->loss += all * self->contact->friction * pair->p * pair->rubs;
}

static void Nearest(Strands self, const Pair *pair) {
  const PetscReal *s = self->scene->mesh.s;
  const Spot *spot[2] = {&pair->at, &pair->foot};

  if (!pair->apart || pair->gap >= self->sum.nearest) return;
  self->sum.nearest = pair->gap;
  for (int k = 0; k < 2; k++)
    self->sum.at[k] = s[spot[k]->cell] + spot[k]->on.z * (s[spot[k]->cell + 1] - s[spot[k]->cell]);
  for (int d = 0; d < 3; d++) self->sum.x[d] = (pair->at.on.x[d] + pair->foot.on.x[d]) / 2;
}

/* How many zones of contact there are: samples, one after the other, that touch on a side what lies
   farther along the rod. */
static PetscInt Zones(const struct _Strands *self) {
  PetscInt zones = 0, before[2] = {-2, -2};

  for (PetscInt head = 0; head < self->sides * self->samples; head++)
    for (PetscInt k = self->first[head]; k >= 0; k = self->pair[k].next) {
      const Pair *pair = &self->pair[k];
      if (!pair->active || !ContactBears(self->contact, pair->gap) ||
          pair->foot.cell < pair->at.cell)
        continue;
      zones += before[pair->side] < pair->sample - 1;
      before[pair->side] = pair->sample;
    }
  return zones;
}

/*
  StrandsLoad - finds the feet of all pairs and their forces, after a new search if nodes have moved
  far since the last. Not collective: the same on every rank.
*/
PetscErrorCode StrandsLoad(Strands self, const StrandState *state) {
  const PetscBool rubs = (PetscBool)(self->contact->friction > 0 && state->u_t);
  PetscReal f[3];

  PetscFunctionBegin;
  PetscCall(LawsAt(self, state->t));
  if (!self->searched) StrandJoints(self, state, NULL);
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
    if (rubs) PairRub(self, pair);
    PairForce(self, pair, f);
    HandOut(self, pair, f);
    if (rubs && self->couple) HandCouples(self, pair, f);
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

/* StrandsForces - what StrandsLoad() has found: what contact adds to n' at each point (2 cells + 1
   of them), and behind them the force on the tip. Borrowed. */
const PetscReal (*StrandsForces(Strands self))[3] {
  return (const PetscReal(*)[3])self->force;
}

/* StrandsCouples - the couples that belong to them, of friction in space: what contact adds to m';
   NULL: there are none. Borrowed. */
const PetscReal (*StrandsCouples(Strands self))[3] {
  return (const PetscReal(*)[3])self->couple;
}

/* StrandsSum - the sums over all places in contact that StrandsLoad() has found. */
void StrandsSum(Strands self, StrandSum *sum) {
  *sum = self->sum;
}

/* StrandsNear - the cells of all pairs that are near to touching: of the sample, of the foot, each
   once. The caller frees them. */
PetscErrorCode StrandsNear(Strands self, PetscInt *n, PetscInt (**cells)[2]) {
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

/* How many samples a cell in space has, so that they are close when the rod is longest. */
static PetscErrorCode SamplesOf(Scene scene, PetscInt *each) {
  const PetscInt cells = scene->mesh.cells;
  PetscReal *arc, longest = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(cells + 1, &arc));
  PetscCall(GrowthArc(scene->growth, cells + 1, scene->mesh.s, scene->end_time, arc, NULL));
  for (PetscInt i = 0; i < cells; i++) longest = PetscMax(longest, arc[i + 1] - arc[i]);
  PetscCall(PetscFree(arc));
  *each = 1 + (PetscInt)PetscMin(MOST_SAMPLES - 1,
                                 longest / (rod_rule.sample_distance * scene->contact.diameter));
  PetscFunctionReturn(0);
}

/* Where samples are, and what is kept of them. */
static PetscErrorCode Sample(Strands self) {
  const PetscBool plane = (PetscBool)(self->dims == 2), rubs = self->contact->friction > 0;

  PetscFunctionBegin;
  self->sides = plane ? 2 : 1;
  self->ahead = plane ? 0 : 0.5;
  self->each = 2;
  if (!plane) PetscCall(SamplesOf(self->scene, &self->each));
  self->samples = self->cells * self->each + 1;
  PetscCall(PetscMalloc1(self->sides * self->samples, &self->first));
  for (PetscInt k = 0; k < self->sides * self->samples; k++) self->first[k] = -1;
  PetscCall(PetscCalloc2(self->samples, &self->spot, self->samples, &self->placed));
  if (rubs && plane) PetscCall(PetscCalloc1(self->sides * self->samples, &self->dual));
  if (rubs && !plane) PetscCall(PetscCalloc1(self->points + 1, &self->couple));
  PetscFunctionReturn(0);
}

/* StrandsCreate - for a rod of a scene that has -contact_self, which must outlive it. Not
   collective; the caller destroys it with StrandsDestroy(). */
PetscErrorCode StrandsCreate(Scene scene, Strands *strands) {
  const PetscInt cells = scene->mesh.cells, n = 2 * cells + 1;
  Strands self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *strands = self;
  self->scene = scene;
  self->contact = &scene->contact;
  self->dims = scene->space.rod ? 3 : 2;
  self->cells = cells;
  self->points = n;
  self->apart = PETSC_PI / 2 * scene->contact.diameter;
  self->time = PETSC_MIN_REAL;
  PetscCall(PetscCalloc6(n, &self->g, n, &self->g_t, n, &self->c, n, &self->strain, cells + 1,
                         &self->arc, n, &self->weight));
  PetscCall(
      PetscCalloc3(3 * (cells + 1), &self->seen, n + 1, &self->force, cells + 1, &self->joint));
  PetscCall(Sample(self));
  for (PetscInt k = 0; k < 3 * (cells + 1); k++) self->seen[k] = PETSC_MAX_REAL;
  CurveWeights(cells, scene->mesh.s, self->weight);
  PetscFunctionReturn(0);
}

PetscErrorCode StrandsDestroy(Strands *strands) {
  Strands self = *strands;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(PetscFree6(self->g, self->g_t, self->c, self->strain, self->arc, self->weight));
  PetscCall(PetscFree3(self->seen, self->force, self->joint));
  PetscCall(PetscFree2(self->spot, self->placed));
  PetscCall(PetscFree(self->first));
  PetscCall(PetscFree(self->dual));
  PetscCall(PetscFree(self->couple));
  PetscCall(PetscFree(self->pair));
  PetscCall(PetscFree(self->slopes));
  PetscCall(PetscFree(*strands));
  PetscFunctionReturn(0);
}
