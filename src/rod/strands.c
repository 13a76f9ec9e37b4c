/* Parts of rods that touch each other: which are near, and with what force they press. */
#include "base/blocks.h"
#include "curve/nearest.h"
#include "rod/directors.h"
#include "rod/strand_pairs.h"
#include "rod/rules.h"
#include <string.h>

/* ---- the curve ---- */

/* The length of a vector. (In the plane hypot() has another last digit.) */
static inline PetscReal Length(const struct _Strands *self, const PetscReal v[3]) {
  return self->dims == 2 ? hypot(v[0], v[1]) : PetscSqrtReal(Dot3(v, v));
}

/* Where a sample is in the state that is looked at. */
static const Spot *SampleSpot(const struct _Strands *self, PetscInt sample) {
  Spot *spot = &self->spot[sample];
  CurveCell cell;

  if (self->placed[sample]) return spot;
  self->placed[sample] = PETSC_TRUE;
  StrandCell(self, spot->cell, &cell);
  CurvePlaceAt(&cell, &spot->on);
  return spot;
}

/* The arc length of a place, along its rod. */
static PetscReal ArcAt(const struct _Strands *self, const Spot *spot) {
  return self->arc[spot->cell] + spot->on.z * (self->arc[spot->cell + 1] - self->arc[spot->cell]);
}

/*
  FootFrom - the place of the curve nearest to x, by Newton's method on (x - y(z)).y_z = 0 from a
  place near it, on to the next cell where that is. ends: it is an end of the rod.
*/
static void FootFrom(const struct _Strands *self, const PetscReal x[3], Spot *foot,
                     PetscBool *ends) {
  const Strand *rod = StrandOf(self, foot->cell);
  PetscInt along = foot->cell - rod->first;
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
    way = CurveGo(rod->cells, on->z + step, &along, &on->z, ends);
    if (way == CURVE_NEXT && !IsCell(self, rod->first + along))
      along += rod->first + along > foot->cell ? 1 : -1;
    foot->cell = rod->first + along;
    if (way == CURVE_ARRIVED) return;
    if (way == CURVE_NEXT) StrandCell(self, foot->cell, &cell);
  }
  CurvePlaceAt(&cell, on);
}

/* ---- laws, and the state ---- */

/* What one rod's laws give at time t: at its points, and the arc length at its nodes. */
static PetscErrorCode RodLawsAt(Strands self, const Strand *rod, PetscReal t) {
  Growth growth = rod->scene->growth;
  const PetscReal *s = self->s;

  PetscFunctionBegin;
  for (PetscInt k = 2 * rod->first; k <= 2 * (rod->first + rod->cells); k++) {
    PetscReal at = k % 2 ? (s[k / 2] + s[k / 2 + 1]) / 2 : s[k / 2];
    PetscCall(GrowthStretch(growth, 1, &at, t, &self->g[k], &self->g_t[k], NULL));
    self->c[k] = GrowthSlide(growth, at, t);
    self->strain[k] = GrowthStrain(growth, at, t, self->g_t[k]);
  }
  PetscCall(GrowthArc(growth, rod->cells + 1, s + rod->first, t, self->arc + rod->first, NULL));
  PetscFunctionReturn(0);
}

static PetscErrorCode LawsAt(Strands self, PetscReal t) {
  PetscFunctionBegin;
  for (PetscInt r = 0; r < self->rods; r++) PetscCall(SceneContactAt(self->rod[r].scene, t));
  StrandLawsNow(self);
  if (self->time == t) PetscFunctionReturn(0);
  for (PetscInt r = 0; r < self->rods; r++) PetscCall(RodLawsAt(self, &self->rod[r], t));
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
  for (PetscInt i = 0; i < self->nodes; i++) {
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
    if (self->meet) StrandJointToLab(self, i, joint);
  }
}

/* ---- which samples are near to what ---- */

/* A search under way: two strands that touch by a law are looked at within a distance. */
typedef struct {
  Strands self;
  const Contact *contact;
  PetscReal within;
  PetscErrorCode error;
} Looking;

static PetscBool OneStrand(const Block *a, PetscInt first_a, PetscInt last_a, const Block *b,
                           PetscInt first_b, PetscInt last_b, void *ctx) {
  const Strands self = ((const Looking *)ctx)->self;
  return (PetscBool)(self->of[first_a] == self->of[last_b] &&
                     self->arc[last_b] - self->arc[first_a] < StrandOf(self, first_a)->apart);
}

/* Is the foot of x on this cell? 1 yes; 2 it is the end of the rod there; 0 no. */
static int HasFoot(const struct _Strands *self, PetscInt cell, const PetscReal x[3]) {
  const PetscInt along = cell - StrandOf(self, cell)->first;
  const Joint *joint = self->joint + cell;
  PetscReal f[2];

  for (int k = 0; k < 2; k++) {
    PetscReal o[3];
    for (int d = 0; d < 3; d++) o[d] = x[d] - joint[k].x[d];
    f[k] = Dot3(o, joint[k].q);
  }
  if (f[0] >= 0 && f[1] < 0) return 1;
  if ((along == 0 && f[0] < 0) || (along == StrandOf(self, cell)->cells - 1 && f[1] >= 0)) return 2;
  return 0;
}

/* Are two places on one rod, and near each other along it? */
static PetscBool SameStrand(const struct _Strands *self, const Spot *a, const Spot *b) {
  return (PetscBool)(self->of[a->cell] == self->of[b->cell] &&
                     PetscAbsReal(ArcAt(self, a) - ArcAt(self, b)) <
                         StrandOf(self, a->cell)->apart);
}

/* Is a place near a node, along its rod? */
static PetscBool IsNear(const struct _Strands *self, const Spot *spot, PetscInt node) {
  return (PetscBool)(self->of[spot->cell] == self->of[node] &&
                     PetscAbsReal(ArcAt(self, spot) - self->arc[node]) <
                         StrandOf(self, node)->apart);
}

/* Are two places near where their rods are joined? */
static PetscBool AreJoined(const struct _Strands *self, const Spot *a, const Spot *b) {
  for (PetscInt k = 0; k < self->joints; k++) {
    const PetscInt *node = self->joint_at[k].node;
    if ((IsNear(self, a, node[0]) && IsNear(self, b, node[1])) ||
        (IsNear(self, a, node[1]) && IsNear(self, b, node[0])))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* A new pair. Of two feet of a sample on one side, in space of those that are near each other along
   the rod and so of one strand, the nearer counts. */
static PetscErrorCode Keep(Strands self, const Pair *pair) {
  PetscInt *first = &self->first[self->sides * pair->sample + pair->side], next = *first;

  PetscFunctionBegin;
  for (PetscInt k = next; k >= 0; k = self->pair[k].next) {
    Pair *other = &self->pair[k];
    if (self->dims == 3 && !SameStrand(self, &other->foot, &pair->foot)) continue;
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
  pair = (Pair){.sample = sample, .contact = look->contact, .at = *at};
  pair.foot.cell = cell;
  pair.foot.on.z = foot == 1 ? 0.5 : cell > StrandOf(self, cell)->first ? 1 : 0;
  FootFrom(self, pair.at.on.x, &pair.foot, &pair.ends);
  for (int d = 0; d < 3; d++) o[d] = pair.foot.on.x[d] - pair.at.on.x[d];
  pair.distance = Length(self, o);
  if (self->dims == 2) pair.side = at->on.slope[0] * o[1] - at->on.slope[1] * o[0] < 0;
  if (pair.distance < look->within) PetscCall(Keep(self, &pair));
  PetscFunctionReturn(0);
}

/* The samples of one cell against another. */
static PetscErrorCode LookFrom(Looking *look, PetscInt from, PetscInt to) {
  const Strand *rod = StrandOf(look->self, from);
  const PetscInt along = from - rod->first, begin = rod->sample + along * rod->each,
                 end = begin + rod->each + (along == rod->cells - 1);

  PetscFunctionBegin;
  for (PetscInt k = begin; k < end; k++) PetscCall(LookAt(look, k, to));
  PetscFunctionReturn(0);
}

/* Within what distance two strands are looked at that touch by a law. */
static PetscReal ReachOf(const Contact *contact) {
  return (1 + rod_rule.pair_margin) * contact->diameter + contact->smooth;
}

static void Meet(PetscInt i, PetscInt j, void *ctx) {
  Looking *look = (Looking *)ctx;
  const Strands self = look->self;
  const Strand *rod = StrandOf(self, i);

  if (look->error || !IsCell(self, i) || !IsCell(self, j)) return;
  if (SceneRests(rod->scene, self->time) || SceneRests(StrandOf(self, j)->scene, self->time))
    return;
  if (self->of[i] != self->of[j])
    look->error = StrandLawOf(self, self->of[i], self->of[j], &look->contact);
  else
    look->contact =
        rod->contact->self && self->arc[j] - self->arc[i + 1] >= rod->apart ? rod->contact : NULL;
  if (look->error || !look->contact) return;
  look->within = ReachOf(look->contact);
  look->error = LookFrom(look, i, j);
  if (!look->error) look->error = LookFrom(look, j, i);
}

static PetscErrorCode Search(Strands self) {
  Looking look = {.self = self};
  PetscReal reach = 0;
  Blocks line;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++)
    self->first[self->sides * self->pair[k].sample + self->pair[k].side] = -1;
  self->n = 0;
  for (PetscInt i = 0; i < self->nodes; i++)
    for (int d = 0; d < 3; d++) self->seen[3 * i + d] = self->joint[i].x[d];
  for (PetscInt r = 0; r < self->rods; r++) reach = PetscMax(reach, ReachOf(self->rod[r].contact));
  PetscCall(BlocksOfLine(self->dims, self->nodes - 1, 3, self->seen, NULL, self->span, &line));
  BlocksPairs(line, reach, OneStrand, Meet, &look);
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
  for (PetscInt r = 0; r < self->rods; r++) {
    const Strand *rod = &self->rod[r];
    const PetscReal far = PetscSqr(rod_rule.pair_margin * rod->contact->diameter / 2);
    for (PetscInt i = rod->first; i <= rod->first + rod->cells; i++) {
      PetscReal way[3];
      Minus3(self->joint[i].x, self->seen + 3 * i, way);
      if (!(Dot3(way, way) < far)) return PETSC_TRUE;
    }
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
  pair->gap = pair->distance - pair->contact->diameter;
  pair->apart = (PetscBool) !(SameStrand(self, &pair->at, &pair->foot) ||
                              AreJoined(self, &pair->at, &pair->foot));
  pair->active =
      (PetscBool)(pair->gap < pair->contact->smooth && pair->apart && pair->distance > 0);
}

/* What a density at the points, per label, is over the labels that a sample stands for. In the
   plane the tip has a part of the last cell, too. */
static PetscReal Over(const struct _Strands *self, const PetscReal *at, const Pair *pair) {
  const PetscInt cell = pair->at.cell;
  const PetscReal *s = self->s;

  if (self->dims == 2) return at[pair->sample] * self->weight[pair->sample] / 2;
  if (SampleIsTip(self, pair->sample)) return 0;
  return CurveBetween(at + 2 * cell, pair->at.on.z) * (s[cell + 1] - s[cell]) /
         (2 * StrandOf(self, cell)->each);
}

/* PairShares - the lengths of rod that a pair stands for: of the sample; of the tip's point
   contact, if it is that. */
void PairShares(const struct _Strands *self, const Pair *pair, PetscReal share[2]) {
  share[0] = Over(self, self->g, pair);
  share[1] = SampleIsTip(self, pair->sample) ? StrandOf(self, pair->at.cell)->contact->tip : 0;
}

/* PairForce - on the sample, per length of rod that it stands for:  f = p (n - mu w). */
void PairForce(const struct _Strands *self, const Pair *pair, PetscReal f[3]) {
  for (int d = 0; d < 3; d++) f[d] = pair->p * (pair->n[d] - pair->contact->friction * pair->w[d]);
}

/* PairOnClamp - what pushes the beginning of a rod that is fed in back along it, the clamp's
   direction x1: the clamp bears that, for it is the clamp that is there, at rest, while the
   material moves on. */
PetscBool PairOnClamp(const struct _Strands *self, const Pair *pair) {
  const PetscInt cell = pair->foot.cell;
  return (PetscBool)(pair->ends && cell == StrandOf(self, cell)->first && pair->foot.on.z == 0 &&
                     self->c[2 * cell] != 0);
}

/* PairSpread - who takes what acts on the foot, or else on the sample (but for the tip's own).
   Returns how many points that are. */
int PairSpread(const struct _Strands *self, const Pair *pair, int of_foot, Spread *spread) {
  const Spot *spot = of_foot ? &pair->foot : &pair->at;
  const PetscInt first = self->span[spot->cell];

  if (self->dims == 2 && !of_foot) {
    *spread = (Spread){.point = {pair->sample}, .share = {1}};
    return 1;
  }
  if (self->dims == 3 && !of_foot && SampleIsTip(self, pair->sample)) return 0;
  (self->dims == 2 ? SpreadAt : SpreadEvenly)(2 * (self->span_end[spot->cell] - first) + 1,
                                              spot->cell - first, spot->on.z, spread);
  for (int k = 0; k < 4; k++) spread->point[k] += 2 * first;
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
  const Strand *rod = StrandOf(self, pair->at.cell);
  PetscReal share[2];

  PairShares(self, pair, share);
  HandTo(self, pair, 0, share[0], on_sample, load);
  for (int d = 0; d < 3 && share[1] > 0; d++) load[TipPoint(rod)][d] += share[1] * on_sample[d];
  HandTo(self, pair, 1, share[0] + share[1], on_foot, load);
}

/* The force of a pair, of which the clamp may bear a part. The power that the rod of the foot has
   from it is that of the sample's, which has the energy of the pair, and loses by it. */
static void HandOut(Strands self, const Pair *pair, const PetscReal f[3], PetscBool moves) {
  Strand *of_foot = &self->rod[self->of[pair->foot.cell]];
  const PetscReal *axis = of_foot->axis,
                  borne = PairOnClamp(self, pair) ? pair->p * Dot3(pair->n, axis) : 0;
  PetscReal share[2], on_foot[3];

  for (int d = 0; d < 3; d++) on_foot[d] = borne * axis[d] - f[d];
  PairShares(self, pair, share);
  for (int d = 0; d < 3; d++) of_foot->sum.clamp[d] -= (share[0] + share[1]) * borne * axis[d];
  HandBoth(self, pair, f, on_foot, self->force);
  if (self->meet && moves) {
    const PetscReal power = (share[0] + share[1]) * PairFootPower(self, pair, f, on_foot);
    of_foot->sum.moved += power;
    self->rod[self->of[pair->at.cell]].sum.moved -= power;
  }
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

/* How far the tip of a rod is put off by a contact that gives: a clamped rod that is pushed by d at
   the distance s along it moves there and at its tip by d and d (1 + 3 (L - s)/(2 s)). */
static PetscReal Gives(const struct _Strands *self, const Pair *pair) {
  const Strand *rod = StrandOf(self, pair->at.cell);
  const PetscReal length = self->arc[rod->first + rod->cells],
                  s = PetscMax(ArcAt(self, &pair->at), rod->contact->diameter);

  if (pair->p_gap == 0) return 0;
  return PetscAbsReal(pair->p / pair->p_gap) * (1 + 1.5 * PetscMax(0, length - s) / s);
}

static void AddToSum(Strands self, const Pair *pair) {
  Strand *rod = &self->rod[self->of[pair->at.cell]];
  const PetscReal U = ContactEnergy(pair->contact, pair->gap),
                  U_t = ContactEnergyRate(pair->contact, pair->gap);
  StrandSum *sum = &rod->sum;
  PetscReal share[2], all;

  PairShares(self, pair, share);
  all = share[0] + share[1];
  sum->energy += all * U;
  sum->strain += Over(self, self->strain, pair) * U + share[0] * U_t +
                 (share[1] > 0 ? rod->contact->tip_t * U + share[1] * U_t : 0);
  if (pair->sample == rod->sample)
    sum->strain += self->c[2 * rod->first] / 2 * U; /* what is fed in comes with it */
  sum->normal += all * pair->p;
  if (self->meet) sum->gives = PetscMax(sum->gives, Gives(self, pair));
  sum->loss += all * pair->contact->friction * pair->p * pair->rubs;
}

static void Nearest(Strands self, const Pair *pair) {
  const PetscReal *s = self->s;
  const Spot *spot[] = {&pair->at, &pair->foot};
  StrandSum *sum = &self->rod[self->of[pair->at.cell]].sum;

  if (!pair->apart || pair->gap >= sum->nearest) return;
  sum->nearest = pair->gap;
  sum->rod = self->of[pair->foot.cell];
  for (int k = 0; k < 2; k++)
    sum->at[k] = s[spot[k]->cell] + spot[k]->on.z * (s[spot[k]->cell + 1] - s[spot[k]->cell]);
  for (int d = 0; d < 3; d++) sum->x[d] = (pair->at.on.x[d] + pair->foot.on.x[d]) / 2;
}

/* How many zones of contact a rod has: samples, one after the other, that touch on a side what lies
   farther along it, or along a later rod. */
static void Zones(Strands self) {
  for (PetscInt r = 0; r < self->rods; r++) {
    const PetscInt sample = self->rod[r].sample,
                   end = r + 1 < self->rods ? self->rod[r + 1].sample : self->samples;
    PetscInt before[] = {-2, -2};
    for (PetscInt head = self->sides * sample; head < self->sides * end; head++)
      for (PetscInt k = self->first[head]; k >= 0; k = self->pair[k].next) {
        const Pair *pair = &self->pair[k];
        if (!pair->active || !ContactBears(pair->contact, pair->gap) ||
            pair->foot.cell < pair->at.cell)
          continue;
        self->rod[r].sum.zones += before[pair->side] < pair->sample - 1;
        before[pair->side] = pair->sample;
      }
  }
}

/* The sum of all forces on each rod, in the frame that its loads are in. */
static void AddUp(Strands self) {
  for (PetscInt r = 0; r < self->rods; r++) {
    Strand *rod = &self->rod[r];
    for (int d = 0; d < 3; d++) {
      rod->sum.sum[d] = rod->sum.clamp[d] + self->force[TipPoint(rod)][d];
      for (PetscInt k = 2 * rod->first; k < TipPoint(rod); k++)
        rod->sum.sum[d] -= self->force[k][d] * self->weight[k];
    }
  }
}

/* Of several rods what is done to each is told in its own frame, but for places and the sum of
   forces. */
static void TellEach(Strands self) {
  if (!self->meet) return;
  StrandsToOwn(self, self->force);
  if (self->couple) StrandsToOwn(self, self->couple);
  for (PetscInt r = 0; r < self->rods; r++) {
    StrandSum *sum = &self->rod[r].sum;
    PetscReal lab[3];
    memcpy(lab, sum->clamp, sizeof(lab));
    SpaceFromLab(&self->rod[r].scene->space, lab, sum->clamp);
  }
}

/*
  StrandsLoad - finds the feet of all pairs and their forces, after a new search if nodes have moved
  far since the last. Not collective: the same on every rank.
*/
PetscErrorCode StrandsLoad(Strands self, const StrandState *state) {
  PetscReal f[3];

  PetscFunctionBegin;
  PetscCall(LawsAt(self, state->t));
  if (!self->searched) StrandJoints(self, state, NULL);
  if (!self->searched && Moved(self)) PetscCall(Search(self));
  self->searched = PETSC_FALSE;
  PetscCall(PetscArrayzero(self->force, 2 * self->nodes));
  if (self->couple) PetscCall(PetscArrayzero(self->couple, 2 * self->nodes));
  for (PetscInt r = 0; r < self->rods; r++)
    self->rod[r].sum = (StrandSum){.nearest = PETSC_MAX_REAL};
  for (PetscInt k = 0; k < self->n; k++) {
    Pair *pair = &self->pair[k];
    const PetscBool rubs = (PetscBool)(pair->contact->friction > 0 && state->u_t);
    PairPlace(self, pair);
    Nearest(self, pair);
    if (!pair->active) continue;
    pair->p = ContactPressure(pair->contact, pair->gap, &pair->p_gap);
    if (rubs) PairRub(self, pair);
    PairForce(self, pair, f);
    HandOut(self, pair, f, (PetscBool)(state->u_t != NULL));
    if (rubs && self->couple) HandCouples(self, pair, f);
    AddToSum(self, pair);
  }
  Zones(self);
  AddUp(self);
  TellEach(self);
  PetscFunctionReturn(0);
}

/* StrandsForces - what StrandsLoad() has found: what contact adds to n' at each point (2 cells + 1
   of a rod), and behind them the force on the tip. Borrowed. */
const PetscReal (*StrandsForces(Strands self))[3] {
  return (const PetscReal(*)[3])self->force;
}

/* StrandsCouples - the couples that belong to them, of friction in space: what contact adds to m';
   NULL: there are none. Borrowed. */
const PetscReal (*StrandsCouples(Strands self))[3] {
  return (const PetscReal(*)[3])self->couple;
}

/* StrandsSum - the sums over all places in contact of a rod that StrandsLoad() has found. */
void StrandsSum(Strands self, PetscInt rod, StrandSum *sum) {
  *sum = self->rod[rod].sum;
}

/* StrandsRod - the rod of a node of all. */
PetscInt StrandsRod(Strands self, PetscInt node) {
  return self->of[node];
}

/* StrandsFirst - the first node of a rod among those of all. */
PetscInt StrandsFirst(Strands self, PetscInt rod) {
  return self->rod[rod].first;
}

/* StrandsNear - the cells of all pairs that are near to touching: of the sample, of the foot, each
   once. The caller frees them. */
PetscErrorCode StrandsNear(Strands self, PetscInt *n, CellPair **cells) {
  PetscInt m = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(self->n, cells));
  for (PetscInt k = 0; k < self->n; k++) {
    const PetscInt a = self->pair[k].at.cell, b = self->pair[k].foot.cell;
    PetscInt seen = m - 1;
    while (seen >= 0 && m - seen <= 2 * StrandOf(self, a)->each &&
           ((*cells)[seen].sample != a || (*cells)[seen].foot != b))
      seen--;
    if (seen >= 0 && (*cells)[seen].sample == a && (*cells)[seen].foot == b) continue;
    (*cells)[m++] = (CellPair){a, b};
  }
  *n = m;
  PetscFunctionReturn(0);
}
