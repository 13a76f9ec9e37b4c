/*
  Growth that feels the force along the rod:

    e = e_law (1 + n.q/Pi)_+,   V(p) = int_0^p e dp (feed: V = (1 + n.q/Pi)_+ of the clamp),
    L_t = V(L),   c = V - s L_t,   g = L: labels share out the length evenly.

  So how long the rod is and how fast its material moves are known with its forces alone: a model
  has both among its unknowns, and says here what they are in the state that it looks at. Between
  nodes V is the cubic of its values and slopes.
*/
#include "base/hermite.h"
#include "base/knots.h"
#include "base/lagrange.h"
#include "material/growth.h"
#include <string.h>

enum { KEPT = 8 };

typedef struct {
  PetscBool zone, fed;
  PetscReal t, length;    /* of the state seen last */
  PetscInt n;             /* nodes of it; 0: none yet */
  PetscReal *s, *V, *V_s; /* what it is at them */
  PetscInt m, of;         /* earlier states that are kept, and their nodes: */
  PetscReal times[KEPT], lengths[KEPT], *at, *speed;
  PetscReal *profile;
  PetscInt rows; /* of a length that is known at all times, 0: of none */
  PetscReal *row_t, *row_L, *row_rate;
} Yield;

static inline Yield *YieldOf(Growth self) {
  return (Yield *)self->data;
}

/* The law without force: g e_law, and how it changes with the length. */
PetscReal GrowthYieldWeight(Growth self, PetscReal s, PetscReal length, PetscReal *by_length) {
  const Yield *yield = YieldOf(self);
  const PetscReal ratio = length / PetscMin(self->finest, length), z = (1 - s) * ratio, y = 1 - z;

  *by_length = 0;
  if (!yield->zone) return yield->fed ? 0 : 1;
  if (z >= 1) return 0;
  if (length > self->finest)
    *by_length = 30 * z * y * (2 * (1 - s) * ratio * (1 - 2 * z) + z * y) / self->finest;
  return HermiteRiseSlope(z) * ratio;
}

/* GrowthYieldInflow - how fast a rod is fed that is not pushed; 0: nothing comes in. */
PetscReal GrowthYieldInflow(Growth self) {
  return YieldOf(self)->fed ? 1 : 0;
}

/* The cell of the nodes in which a label is, and where: z in [0, 1] of its length. */
static PetscInt CellAt(PetscInt n, const PetscReal s[], PetscReal at, PetscReal *z) {
  const PetscInt k = KnotBefore(n, s, at);

  *z = PetscMin(1, PetscMax(0, (at - s[k]) / (s[k + 1] - s[k])));
  return k;
}

/* How fast the material moves at a label, without forces. */
static PetscReal FreeSpeed(Growth self, PetscReal s, PetscReal length) {
  const Yield *yield = YieldOf(self);
  const PetscReal z = PetscMin(1, (1 - s) * length / PetscMin(self->finest, length));

  if (yield->fed) return 1;
  return yield->zone ? HermiteFall(z) : s;
}

static PetscReal SpeedYield(Growth self, PetscReal s, PetscReal t) {
  const Yield *yield = YieldOf(self);
  PetscReal z;
  PetscInt k;

  if (!yield->n) return FreeSpeed(self, s, yield->length);
  k = CellAt(yield->n, yield->s, s, &z);
  return HermiteAt(z, yield->s[k + 1] - yield->s[k], yield->V[k], yield->V_s[k], yield->V[k + 1],
                   yield->V_s[k + 1]);
}

static PetscReal RateYield(Growth self) {
  const Yield *yield = YieldOf(self);

  return yield->n ? yield->V[yield->n - 1] : 1;
}

/* The length at a time, and how fast it grows, of one that is known. */
static void Known(const Yield *yield, PetscReal t, PetscReal *g, PetscReal *g_t) {
  const PetscInt last = yield->rows - 1, k = KnotBefore(yield->rows, yield->row_t, t);
  const PetscReal h = yield->row_t[k + 1] - yield->row_t[k], z = (t - yield->row_t[k]) / h,
                  *L = yield->row_L + k, *rate = yield->row_rate + k;

  if (t >= yield->row_t[last]) {
    *g_t = yield->row_rate[last];
    *g = yield->row_L[last] + *g_t * (t - yield->row_t[last]);
    return;
  }
  *g = HermiteAt(z, h, L[0], rate[0], L[1], rate[1]);
  *g_t = 6 * z * (1 - z) * (L[1] - L[0]) / h + (1 - z) * (1 - 3 * z) * rate[0] +
         z * (3 * z - 2) * rate[1];
  if (t == yield->t && yield->n) *g_t = yield->V[yield->n - 1];
}

/* The length goes on as it grows now at other times than that of the state seen, unless it is
 * known.
 */
static PetscErrorCode StretchYield(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                   PetscReal *g_t, PetscReal *g_s) {
  const Yield *yield = YieldOf(self);

  *g_s = 0;
  if (yield->rows) {
    Known(yield, t, g, g_t);
    return 0;
  }
  *g_t = RateYield(self);
  *g = yield->length + *g_t * (t - yield->t);
  return 0;
}

static PetscErrorCode ArcYield(Growth self, PetscReal s, PetscReal t, PetscReal *p,
                               PetscReal *p_t) {
  PetscReal g, g_t, g_s;

  (void)StretchYield(self, s, t, &g, &g_t, &g_s);
  *p = s * g;
  *p_t = s * g_t;
  return 0;
}

static PetscReal SlideYield(Growth self, PetscReal s, PetscReal t) {
  return SpeedYield(self, s, t) - s * RateYield(self);
}

static PetscReal StrainYield(Growth self, PetscReal s, PetscReal t) {
  const Yield *yield = YieldOf(self);
  PetscReal z, h, by_length;
  PetscInt k;

  if (!yield->n) return GrowthYieldWeight(self, s, yield->length, &by_length);
  k = CellAt(yield->n, yield->s, s, &z);
  h = yield->s[k + 1] - yield->s[k];
  return 6 * z * (1 - z) * (yield->V[k + 1] - yield->V[k]) / h +
         (1 - z) * (1 - 3 * z) * yield->V_s[k] + z * (3 * z - 2) * yield->V_s[k + 1];
}

/* What is laid down keeps its place; while it stretches it takes on that of where it is; of what is
   fed, see OriginFeed(). */
static PetscErrorCode OriginYield(Growth self, PetscReal s, PetscReal t, PetscReal *d,
                                  PetscReal *d_t) {
  const Yield *yield = YieldOf(self);
  PetscReal g, g_t, g_s;

  (void)StretchYield(self, s, t, &g, &g_t, &g_s);
  *d = yield->fed ? (1 - s) * g : self->initial_length - s * g;
  *d_t = yield->fed ? 0 : -SpeedYield(self, s, t);
  return 0;
}

/* Length and speeds at a time, by the polynomials through those that are kept. */
static PetscReal AtTime(const Yield *yield, PetscReal t) {
  PetscReal w[KEPT], length = 0;

  LagrangeValues(yield->m, yield->times, t, w);
  (void)memset(yield->profile, 0, (size_t)yield->of * sizeof(*yield->profile));
  for (PetscInt j = 0; j < yield->m; j++) {
    length += w[j] * yield->lengths[j];
    for (PetscInt i = 0; i < yield->of; i++)
      yield->profile[i] += w[j] * yield->speed[j * yield->of + i];
  }
  return length;
}

/* How fast the material moves that is so far from the clamp, by the profile of a time. */
static PetscReal SpeedAlong(const Yield *yield, PetscReal length, PetscReal p) {
  PetscReal z, w[4], V = 0;
  const PetscReal at = PetscMin(1, PetscMax(0, p / length));
  const PetscInt k = CellAt(yield->of, yield->at, at, &z),
                 first = PetscMax(0, PetscMin(k - 1, yield->of - 4));

  LagrangeValues(4, yield->at + first, at, w);
  for (int j = 0; j < 4; j++) V += w[j] * yield->profile[first + j];
  return V;
}

/* One step of the classical method of Runge and Kutta of all places p from t on. */
static void StepAlong(const Yield *yield, PetscReal t, PetscReal h, PetscInt n, PetscReal p[],
                      PetscReal k1[], PetscReal k2[], PetscReal k3[]) {
  PetscReal length = AtTime(yield, t);

  for (PetscInt i = 0; i < n; i++) k1[i] = SpeedAlong(yield, length, p[i]);
  length = AtTime(yield, t + h / 2);
  for (PetscInt i = 0; i < n; i++) k2[i] = SpeedAlong(yield, length, p[i] + h / 2 * k1[i]);
  for (PetscInt i = 0; i < n; i++) k3[i] = SpeedAlong(yield, length, p[i] + h / 2 * k2[i]);
  length = AtTime(yield, t + h);
  for (PetscInt i = 0; i < n; i++)
    p[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + SpeedAlong(yield, length, p[i] + h * k3[i]));
}

/* Where the material was, by the speeds that are kept. What is fed keeps its distance from the tip,
   other material goes back along its way. */
static PetscErrorCode DepartYield(Growth self, PetscReal t, PetscReal before, PetscInt n,
                                  const PetscReal s[], PetscReal from[]) {
  enum { PARTS = 2 }; /* of the time between two states */
  const Yield *yield = YieldOf(self);
  PetscReal length, then, *room, now = t;

  PetscFunctionBegin;
  if (!yield->m) {
    PetscCall(PetscArraycpy(from, s, n));
    PetscFunctionReturn(0);
  }
  length = AtTime(yield, t);
  then = AtTime(yield, before);
  for (PetscInt i = 0; i < n && yield->fed; i++) from[i] = 1 - (1 - s[i]) * length / then;
  if (yield->fed) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(3 * n, &room));
  for (PetscInt i = 0; i < n; i++) from[i] = s[i] * length;
  for (PetscInt j = 0; j < yield->m && now > before; j++) {
    const PetscReal to = PetscMax(before, yield->times[j]), h = (to - now) / PARTS;
    for (int part = 0; part < PARTS && to < now; part++)
      StepAlong(yield, now + part * h, h, n, from, room, room + n, room + 2 * n);
    now = PetscMin(now, to);
  }
  for (PetscInt i = 0; i < n; i++) from[i] = PetscMin(1, PetscMax(0, from[i] / then));
  PetscCall(PetscFree(room));
  PetscFunctionReturn(0);
}

/* The front of what is fed in, in the states that are kept; of another one by its own length. */
static PetscReal FrontYield(Growth self, PetscReal t) {
  const Yield *yield = YieldOf(self);

  if (!yield->m || t == yield->t) return GrowthFrontFed(self, t);
  return 1 - self->initial_length / AtTime(yield, t);
}

/*
  GrowthYieldSee - what a state says of it, at all of its nodes, on every rank.

  V, V_s  speed of the material and its slope along the labels
*/
PetscErrorCode GrowthYieldSee(Growth self, PetscReal t, PetscInt n, const PetscReal s[],
                              PetscReal length, const PetscReal V[], const PetscReal V_s[]) {
  Yield *yield = YieldOf(self);

  PetscFunctionBegin;
  if (n != yield->n) {
    PetscCall(PetscFree3(yield->s, yield->V, yield->V_s));
    PetscCall(PetscMalloc3(n, &yield->s, n, &yield->V, n, &yield->V_s));
    yield->n = n;
  }
  PetscCall(PetscArraycpy(yield->s, s, n));
  PetscCall(PetscArraycpy(yield->V, V, n));
  PetscCall(PetscArraycpy(yield->V_s, V_s, n));
  yield->t = t;
  yield->length = length;
  PetscFunctionReturn(0);
}

/* GrowthYieldKeep - lengths and speeds of the states that a step goes on from, the latest first. */
PetscErrorCode GrowthYieldKeep(Growth self, PetscInt m, const PetscReal times[],
                               const PetscReal length[], PetscInt n, const PetscReal s[],
                               const PetscReal V[]) {
  Yield *yield = YieldOf(self);

  PetscFunctionBegin;
  if (n != yield->of) {
    PetscCall(PetscFree3(yield->at, yield->speed, yield->profile));
    PetscCall(PetscMalloc3(n, &yield->at, KEPT * n, &yield->speed, n, &yield->profile));
    yield->of = n;
  }
  yield->m = PetscMin(m, KEPT);
  PetscCall(PetscArraycpy(yield->at, s, n));
  PetscCall(PetscArraycpy(yield->times, times, yield->m));
  PetscCall(PetscArraycpy(yield->lengths, length, yield->m));
  PetscCall(PetscArraycpy(yield->speed, V, yield->m * n));
  PetscFunctionReturn(0);
}

/* GrowthYieldFollow - how long the rod is at all times, at n >= 2 of them, and how fast it grows.
 */
PetscErrorCode GrowthYieldFollow(Growth self, PetscInt n, const PetscReal t[],
                                 const PetscReal length[], const PetscReal rate[]) {
  Yield *yield = YieldOf(self);

  PetscFunctionBegin;
  PetscCall(PetscFree3(yield->row_t, yield->row_L, yield->row_rate));
  PetscCall(PetscMalloc3(n, &yield->row_t, n, &yield->row_L, n, &yield->row_rate));
  PetscCall(PetscArraycpy(yield->row_t, t, n));
  PetscCall(PetscArraycpy(yield->row_L, length, n));
  PetscCall(PetscArraycpy(yield->row_rate, rate, n));
  yield->rows = n;
  PetscFunctionReturn(0);
}

static PetscErrorCode DestroyYield(Growth self) {
  Yield *yield = YieldOf(self);

  PetscFunctionBegin;
  PetscCall(PetscFree3(yield->s, yield->V, yield->V_s));
  PetscCall(PetscFree3(yield->at, yield->speed, yield->profile));
  PetscCall(PetscFree3(yield->row_t, yield->row_L, yield->row_rate));
  PetscCall(PetscFree(self->data));
  PetscFunctionReturn(0);
}

/* GrowthYields - makes a law one that feels force, if it is to. */
PetscErrorCode GrowthYields(Growth self) {
  const PetscBool fed = (PetscBool)!strcmp(self->type, "feed"),
                  zone = (PetscBool)!strcmp(self->type, "apical");
  PetscReal limit;
  PetscBool given, even;
  Yield *yield;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-growth_yield", &given));
  if (!given) PetscFunctionReturn(0);
  PetscCall(OptionReal("-growth_yield", &limit, NULL));
  UserCheck(fed || zone || !strcmp(self->type, "uniform"), OptionsComm(),
            "-growth_yield: growth that feels force is uniform, apical or feed; give such a "
            "-growth_type, or take it out");
  UserCheck(self->fastest == 0, OptionsComm(),
            "-growth_yield: how a rod is fed is given by -growth_path; leave one of both out");
  PetscCall(OptionGiven("-growth_profile", &even));
  UserCheck(!even, OptionsComm(),
            "-growth_profile: growth that feels force (-growth_yield) is a bell; take it out");
  if (self->destroy) PetscCall(self->destroy(self));
  PetscCall(PetscNew(&yield));
  self->data = yield;
  self->destroy = DestroyYield;
  self->yield = limit;
  yield->length = self->initial_length;
  yield->fed = fed;
  yield->zone = zone;
  self->similar = PETSC_FALSE;
  self->slides = PETSC_TRUE;
  self->rests = (PetscBool)!fed;
  self->stretch = StretchYield;
  self->arc = ArcYield;
  self->slide = SlideYield;
  self->speed = SpeedYield;
  self->strain = StrainYield;
  self->origin = OriginYield;
  self->depart = DepartYield;
  self->front = fed ? FrontYield : NULL;
  PetscFunctionReturn(0);
}
