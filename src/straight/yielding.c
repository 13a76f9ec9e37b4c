/*
  With u = 1 - P/Pi, what is left of growth, from the clamp to the tip

    V' = e_law u_+,   u' = (N phi(V) V - w1)/Pi,   V(0) = 0,   u(L) = 1 - P_tip/Pi

  (fed: V = u_+ of the clamp all along). What is not known is u at the clamp, or, where thrust
  takes all that growth can push, up to where it is 0: one number, by which the end rises.
*/
#include "straight/yielding.h"
#include "base/lagrange.h"
#include "base/root.h"
#include "straight/straight.h"

/* u counts as 0 below this part of sqrt(beta): V rises from there as it does from less. */
static const PetscReal nothing_of = 1e-14;

typedef struct {
  Scene scene;
  PetscReal t, L, from; /* there, and where growth begins */
  PetscReal finest;     /* longest step, of L */
  PetscReal nothing;    /* u that counts as 0 */
  PetscReal exact;      /* of a step */
  PetscInt n, room;     /* places, V and its slope, if they are kept */
  PetscReal *p, *V, *V_p;
  PetscReal speed; /* V at the tip */
} Shot;

/* e_law at a place. */
static PetscReal LawAt(const Shot *self, PetscReal p) {
  PetscReal by_length;

  return GrowthYieldWeight(self->scene->growth, p / self->L, self->L, &by_length) / self->L;
}

/* How V and u change along the rod. */
static void Slope(const Shot *self, PetscReal p, const PetscReal y[2], PetscReal f[2]) {
  const Load *load = &self->scene->load;
  const Place at = {.s = p / self->L, .t = self->t, .x = {p}};
  PetscReal slope[3];
  const PetscReal N = load->moves ? LoadFactor(load, at.x, self->t, slope) : 1;

  f[0] = y[1] > 0 ? LawAt(self, p) * y[1] : 0;
  f[1] = (N * LoadAxialDrag(load, &at, y[0]) * y[0] - (load->weighs ? load->weight[0] : 0)) /
         self->scene->growth->yield;
}

/* A step of the classical method of Runge and Kutta. */
static void Step(const Shot *self, PetscReal p, PetscReal h, const PetscReal y[2],
                 PetscReal to[2]) {
  PetscReal k[4][2], at[2];

  Slope(self, p, y, k[0]);
  for (int j = 1; j < 4; j++) {
    const PetscReal part = j < 3 ? h / 2 : h;
    for (int i = 0; i < 2; i++) at[i] = y[i] + part * k[j - 1][i];
    Slope(self, p + part, at, k[j]);
  }
  for (int i = 0; i < 2; i++)
    to[i] = y[i] + h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
}

static PetscErrorCode Keep(Shot *self, PetscReal p, const PetscReal y[2]) {
  PetscReal f[2];

  PetscFunctionBegin;
  if (!self->room) PetscFunctionReturn(0);
  if (self->n == self->room) {
    self->room *= 2;
    PetscCall(PetscRealloc((size_t)self->room * sizeof(PetscReal), &self->p));
    PetscCall(PetscRealloc((size_t)self->room * sizeof(PetscReal), &self->V));
    PetscCall(PetscRealloc((size_t)self->room * sizeof(PetscReal), &self->V_p));
  }
  Slope(self, p, y, f);
  self->p[self->n] = p;
  self->V[self->n] = y[0];
  self->V_p[self->n++] = f[0];
  PetscFunctionReturn(0);
}

/* From a place to the tip, in steps that agree with two of half their length. */
static PetscErrorCode Shoot(Shot *self, PetscReal p, PetscReal y[2]) {
  const PetscReal exact = self->exact, longest = self->finest * self->L;
  PetscReal h = longest;

  PetscFunctionBegin;
  PetscCall(Keep(self, p, y));
  while (p < self->L) {
    PetscReal whole[2], half[2], two[2], off = 0;
    const PetscBool last = (PetscBool)(p + h >= self->L);
    if (last) h = self->L - p;
    Step(self, p, h, y, whole);
    Step(self, p, h / 2, y, half);
    Step(self, p + h / 2, h / 2, half, two);
    for (int i = 0; i < 2; i++)
      off = PetscMax(off, PetscAbsReal(two[i] - whole[i]) / (PetscAbsReal(two[i]) + self->nothing));
    if (off > 15 * exact && h > 1e-12 * self->L) {
      h *= PetscMax(0.2, 0.9 * PetscPowReal(15 * exact / off, 0.2));
      continue;
    }
    for (int i = 0; i < 2; i++) y[i] = two[i] + (two[i] - whole[i]) / 15;
    p = last ? self->L : p + h;
    PetscCall(Keep(self, p, y));
    h = PetscMin(longest,
                 h * (off > 0 ? PetscMin(4, 0.9 * PetscPowReal(15 * exact / off, 0.2)) : 4));
  }
  self->speed = y[0];
  PetscFunctionReturn(0);
}

/* u at the tip, where the material moves so fast. */
static PetscReal Wanted(const Shot *self, PetscReal speed) {
  const Tip *tip = &self->scene->tip;
  const Place at = {.t = self->t, .axes = {{1}}, .x = {self->L, 0, 0}, .v = {speed, 0, 0}};

  if (tip->force == 0 && tip->push[0] == 0) return 1;
  return 1 - TipCompression(tip, &at) / self->scene->growth->yield;
}

/* By how much u at the tip is off, of a shot that begins with ln u at its first place, or, below 0,
   with nothing so far behind it. A RootFunction. */
static PetscErrorCode Miss(void *shot, PetscReal x, PetscReal *f) {
  Shot *self = (Shot *)shot;
  PetscReal y[2] = {0, self->nothing * PetscExpReal(PetscMax(0, x))},
            start = PetscMin(self->L, self->from + PetscMax(0, -x) * self->L);

  PetscFunctionBegin;
  self->n = 0;
  if (start > 0) PetscCall(Keep(self, 0, (PetscReal[2]){0, 0}));
  PetscCall(Shoot(self, start, y));
  *f = y[1] - Wanted(self, y[0]);
  PetscFunctionReturn(0);
}

/* The thrust at the clamp of a fed rod, whose material moves at one speed. A RootFunction: how much
   faster it moves than that thrust lets it. */
static PetscErrorCode FedMiss(void *shot, PetscReal V, PetscReal *f) {
  enum { PARTS = 200 };
  Shot *self = (Shot *)shot;
  PetscReal y[2] = {V, 0}, slope[2], sum = 0;

  PetscFunctionBegin;
  for (int i = 0; i < PARTS; i++)
    for (int q = 0; q < GAUSS; q++) {
      Slope(self, self->L * (i + gauss_point[q]) / PARTS, y, slope);
      sum += gauss_weight[q] * slope[1] * self->L / PARTS;
    }
  *f = V - PetscMax(0, Wanted(self, V) - sum);
  PetscFunctionReturn(0);
}

static PetscErrorCode SolveFed(Shot *self) {
  PetscReal low, high, at = 1;

  PetscFunctionBegin;
  PetscCall(FedMiss(self, 0, &low));
  self->speed = 0;
  if (low < 0) {
    PetscCall(FedMiss(self, at, &high));
    while (high < 0) PetscCall(FedMiss(self, at *= 2, &high));
    PetscCall(RootFind(FedMiss, self, 0, low, at, high, 1e-15, &self->speed));
  }
  self->n = 0;
  for (int i = 0; i < 2 && self->room; i++)
    PetscCall(Keep(self, i * self->L, (PetscReal[2]){self->speed, 0}));
  PetscFunctionReturn(0);
}

/* The straight rod of a length. guess: where the last one began, or 0; the next one's. */
static PetscErrorCode Solve(Shot *self, PetscReal *guess) {
  const Growth growth = self->scene->growth;
  const PetscReal beta = self->scene->load.friction.beta;
  PetscReal end[2] = {-1}, low, high, f_low, f_high, step = 1e-3;

  PetscFunctionBegin;
  self->nothing = nothing_of * (beta > 0 ? PetscMin(1, PetscSqrtReal(beta)) : 1);
  end[1] = PetscLogReal(1e6 / self->nothing);
  self->from = growth->finest > 0 ? PetscMax(0, self->L - growth->finest) : 0;
  if (GrowthYieldInflow(growth) > 0) PetscFunctionReturn(SolveFed(self));
  low = high = *guess;
  PetscCall(Miss(self, low, &f_low));
  f_high = f_low;
  for (; f_low >= 0 && low > end[0]; step *= 4) {
    high = low;
    f_high = f_low;
    low = PetscMax(end[0], low - step);
    PetscCall(Miss(self, low, &f_low));
  }
  for (; f_high < 0 && high < end[1]; step *= 4) {
    low = high;
    f_low = f_high;
    high = PetscMin(end[1], high + step);
    PetscCall(Miss(self, high, &f_high));
  }
  if (f_low < 0)
    PetscCall(RootFind(Miss, self, low, f_low, high, f_high, 1e-3 * self->exact, guess));
  else /* the tip's force takes it all */
    PetscCall(Miss(self, end[0], &f_low));
  PetscFunctionReturn(0);
}

/* YieldingFollow - sees to it that the law knows how long the straight rod is at each time of a
   scene: t = int dL / L_t. */
PetscErrorCode YieldingFollow(Scene scene) {
  enum { MOST = 4000 };
  const PetscReal part = 0.02, stalled = 1e-9;
  PetscReal *t, *L, *L_t, guess = 0;
  PetscInt n = 0;
  Shot shot = {.scene = scene, .finest = 1e-2, .exact = 1e-9, .L = scene->growth->initial_length};

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(MOST, &t, MOST, &L, MOST, &L_t));
  t[0] = 0;
  while (n < MOST) {
    const PetscReal from = shot.L, h = part * from;
    UserCheck(
        Wanted(&shot, 0) > 0 || n, scene->comm,
        "-growth_yield: the tip's force alone stalls growth; give a larger one, or less of it");
    PetscCall(Solve(&shot, &guess));
    L[n] = from;
    L_t[n++] = shot.speed;
    if (t[n - 1] > scene->end_time || shot.speed < stalled || n == MOST) break;
    t[n] = t[n - 1];
    for (int q = 0; q < GAUSS; q++) {
      shot.L = from + gauss_point[q] * h;
      PetscCall(Solve(&shot, &guess));
      t[n] += h * gauss_weight[q] / PetscMax(shot.speed, stalled);
    }
    shot.L = from + h;
  }
  PetscCall(GrowthYieldFollow(scene->growth, n, t, L, L_t));
  PetscCall(PetscFree3(t, L, L_t));
  PetscFunctionReturn(0);
}

/* YieldingAt - the law knows how fast the material of the straight rod moves at a time. */
PetscErrorCode YieldingAt(Scene scene, PetscReal t) {
  Shot shot = {.scene = scene, .t = t, .finest = 1e-3, .exact = 1e-12, .room = 1024};
  PetscReal guess = 0, L_t;

  PetscFunctionBegin;
  PetscCall(GrowthLength(scene->growth, t, &shot.L, &L_t));
  PetscCall(PetscMalloc1(shot.room, &shot.p));
  PetscCall(PetscMalloc1(shot.room, &shot.V));
  PetscCall(PetscMalloc1(shot.room, &shot.V_p));
  PetscCall(Solve(&shot, &guess));
  for (PetscInt i = 0; i < shot.n; i++) {
    shot.p[i] /= shot.L;
    shot.V_p[i] *= shot.L;
  }
  PetscCall(GrowthYieldSee(scene->growth, t, shot.n, shot.p, shot.L, shot.V, shot.V_p));
  PetscCall(PetscFree(shot.p));
  PetscCall(PetscFree(shot.V));
  PetscCall(PetscFree(shot.V_p));
  PetscFunctionReturn(0);
}
