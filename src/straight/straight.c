#include "straight/straight.h"
#include "base/bspline.h"

/* StraightScales - does the linear problem only scale with L? Then it is assembled once, and P
 * known in closed form.
 */
PetscBool StraightScales(Scene scene) {
  return (PetscBool)(scene->growth->even && scene->growth->similar && scene->growth->rate == 1 &&
                     scene->load.factor == 1 && !scene->load.along && scene->stiffness.all == 1 &&
                     !scene->load.moves && !scene->stiffness.varies && scene->tip.force == 0 &&
                     scene->tip.push[0] == 0 && scene->tip.type == TIP_FREE &&
                     !StraightIsTwisted(scene));
}

/* The speed at which the rod feels friction: where it rests, exact friction holds it against
   deflections, as friction next to exact does. */
static PetscReal Seen(const Load *load, PetscReal V) {
  return load->friction.beta > 0 ? V : PetscMax(PetscAbsReal(V), PetscSqrtReal(friction_tiny));
}

/*
  StraightAt - the straight rod at one label.

  motion  stretch, arc length, speed V of the material along the rod, slide c, and the factor of the
          load there
*/
PetscErrorCode StraightAt(Scene scene, PetscReal s, PetscReal t, StraightMotion *motion) {
  Place at = {.axes = {{1}}};
  PetscReal slope[3];

  PetscFunctionBegin;
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, &motion->g, NULL, &motion->g_s));
  PetscCall(GrowthArc(scene->growth, 1, &s, t, &motion->p, &motion->p_t));
  motion->c = GrowthSlide(scene->growth, s, t);
  motion->V = GrowthSpeed(scene->growth, s, t, motion->p_t);
  PetscCall(ScenePlace(scene, s, t, &at));
  at.x[0] = motion->p;
  motion->N = LoadFactor(&scene->load, at.x, t, slope);
  motion->drag = LoadAxialDrag(&scene->load, &at, Seen(&scene->load, motion->V)) * motion->N;
  PetscFunctionReturn(0);
}

/*
  StraightTip - what the tip's force does to the straight rod.

  press   its compression
  turns   how much of it turns with the tip: n2 = - turns theta
  drags   its resistance to a velocity across: n2 = - drags v2
*/
PetscErrorCode StraightTip(Scene scene, PetscReal t, PetscReal *press, PetscReal *turns,
                           PetscReal *drags) {
  StraightMotion tip;
  Place at = {.t = t, .axes = {{1}}};
  PetscReal own;

  PetscFunctionBegin;
  *press = *turns = *drags = 0;
  if (scene->tip.force == 0 && scene->tip.push[0] == 0) PetscFunctionReturn(0);
  PetscCall(StraightAt(scene, 1, t, &tip));
  at.x[0] = tip.p;
  at.v[0] = tip.V;
  *press = TipCompression(&scene->tip, &at);
  own = *press + scene->tip.push[0]; /* without the dead force beside it */
  if (scene->tip.law == TIP_FOLLOWER) *turns = own;
  if (scene->tip.law == TIP_RESISTANCE && tip.V != 0) *drags = own / tip.V;
  PetscFunctionReturn(0);
}

/* The integrand g (N phi V - w1) of the compression. */
static PetscErrorCode AxialLoad(Scene scene, PetscReal s, PetscReal t, PetscReal *f) {
  StraightMotion at;

  PetscFunctionBegin;
  PetscCall(StraightAt(scene, s, t, &at));
  *f = at.V == 0 ? 0 : at.g * at.drag * at.V;
  if (scene->load.weighs) *f -= at.g * scene->load.weight[0];
  PetscFunctionReturn(0);
}

/* P for uniform growth, V = s, and for feed, V = 1, exactly. */
static PetscReal CompressionExact(Scene scene, PetscReal s, PetscReal t) {
  const Place at = {.s = s, .t = t};
  PetscReal L = scene->growth->initial_length + t,
            weight = scene->load.weighs ? L * (1 - s) * scene->load.weight[0] : 0;
  if (scene->growth->slides) return L * (1 - s) * LoadAxialDrag(&scene->load, &at, 1) - weight;
  return L * LoadAxialBetween(&scene->load, s, 1) - weight;
}

/*
  StraightForce - the axial compression P of the straight rod: that of the tip's force, and int_s^1
  g (N phi V - w1) ds, w1 the weight along the rod.

  n, s   labels, increasing, the last one 1
  P      n values; the internal force of the straight rod is n1 = -P
*/
PetscErrorCode StraightForce(Scene scene, PetscInt n, const PetscReal s[], PetscReal t,
                             PetscReal P[]) {
  PetscBool scales = StraightScales(scene);
  PetscReal turns, drags;

  PetscFunctionBegin;
  PetscCall(StraightTip(scene, t, &P[n - 1], &turns, &drags));
  for (PetscInt i = n - 2; i >= 0; i--) {
    P[i] = P[i + 1];
    if (scales) {
      P[i] = CompressionExact(scene, s[i], t);
      continue;
    }
    for (int q = 0; q < GAUSS; q++) {
      PetscReal h = s[i + 1] - s[i], f = 0;
      PetscCall(AxialLoad(scene, s[i] + h * gauss_point[q], t, &f));
      P[i] += h * gauss_weight[q] * f;
    }
  }
  PetscFunctionReturn(0);
}

/* int from gauss_point[q] to 1 of the cubic that is 1 at gauss_point[r], 0 at the other points */
static PetscReal TailWeight(int q, int r) {
  PetscReal a = gauss_point[q], sum = 0;
  for (int k = 0; k < GAUSS; k++) {
    PetscReal L[GAUSS];
    LagrangeValues(GAUSS, gauss_point, a + (1 - a) * gauss_point[k], L);
    sum += (1 - a) * gauss_weight[k] * L[r];
  }
  return sum;
}

/* P at all Gauss points, summed from the tip. */
static PetscErrorCode CompressionAtGauss(Straight self, PetscReal t) {
  const PetscReal *s = self->mesh->s;
  PetscReal tail[GAUSS][GAUSS], f[GAUSS], beyond, turns, drags;

  PetscFunctionBegin;
  if (self->time == t) PetscFunctionReturn(0);
  PetscCall(StraightTip(self->scene, t, &beyond, &turns, &drags));
  for (int q = 0; q < GAUSS; q++)
    for (int r = 0; r < GAUSS; r++) tail[q][r] = TailWeight(q, r);
  for (PetscInt c = self->mesh->cells - 1; c >= 0; c--) {
    PetscReal h = s[c + 1] - s[c], *P = self->compression + c * GAUSS;
    for (int q = 0; q < GAUSS; q++)
      PetscCall(AxialLoad(self->scene, s[c] + h * gauss_point[q], t, &f[q]));
    for (int q = 0; q < GAUSS; q++) {
      P[q] = beyond;
      for (int r = 0; r < GAUSS; r++) P[q] += h * tail[q][r] * f[r];
    }
    for (int q = 0; q < GAUSS; q++) beyond += h * gauss_weight[q] * f[q];
  }
  self->time = t;
  PetscFunctionReturn(0);
}

/*
  StraightBasis - the four cubic B-splines that are not 0 on a cell.

  xi   place in the cell, 0 to 1
  B    B[d][k]: d-th derivative by s of spline k, which belongs to unknown cell - 2 + k (unknowns
       -2 and -1, the splines that y(0) = y'(0) = 0 leave out, count from the clamp)
*/
void StraightBasis(Straight straight, PetscInt cell, PetscReal xi, PetscReal B[3][BASIS]) {
  const Mesh *mesh = straight->mesh;
  BSplines b;

  BSplineEvaluate(mesh->cells, mesh->s, cell,
                  mesh->s[cell] + xi * (mesh->s[cell + 1] - mesh->s[cell]), &b);
  for (PetscInt k = 0; k < BASIS; k++) {
    B[0][k] = b.value[CUBIC][k];
    B[1][k] = b.slope[CUBIC][k];
    B[2][k] = b.curve[k];
  }
}

/*
  StraightCreate - prepares the linear problem of a scene on a mesh; both must outlive it.
  The caller destroys it with StraightDestroy().

  way   WAY_X2 or WAY_X3, the direction of the deflection
*/
PetscErrorCode StraightCreate(Scene scene, const Mesh *mesh, StraightWay way, Straight *straight) {
  Straight self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  self->scene = scene;
  self->mesh = mesh;
  self->way = way;
  self->n = mesh->cells + 1;
  self->time = self->assembled = PETSC_MIN_REAL;
  PetscCall(PetscMalloc2(mesh->cells * GAUSS * 3 * BASIS, &self->basis, mesh->cells * GAUSS,
                         &self->compression));
  for (PetscInt c = 0; c < mesh->cells; c++)
    for (int q = 0; q < GAUSS; q++)
      StraightBasis(self, c, gauss_point[q],
                    (PetscReal(*)[BASIS])(self->basis + (c * GAUSS + q) * 3 * BASIS));
  *straight = self;
  PetscFunctionReturn(0);
}

PetscErrorCode StraightDestroy(Straight *straight) {
  PetscFunctionBegin;
  if (!*straight) PetscFunctionReturn(0);
  PetscCall(PetscFree2((*straight)->basis, (*straight)->compression));
  PetscCall(PetscFree((*straight)->bend));
  PetscCall(PetscFree((*straight)->curve));
  PetscCall(PetscFree(*straight));
  PetscFunctionReturn(0);
}

/* The coefficients of the weak form at Gauss point q of a cell, times its weight:
   <eta, K y> = int -bend (y'/g)' (eta'/g)' + axial y' eta' - convect eta y',  <eta, D y> = int drag
   eta y. */
typedef struct {
  PetscReal bend, axial, convect, drag, inv_g, twist; /* (y'/g)' = inv_g y'' - twist y' */
} Weights;

static PetscErrorCode WeightsAt(Straight self, PetscReal t, PetscInt c, int q, Weights *w) {
  PetscReal h = self->mesh->s[c + 1] - self->mesh->s[c], s = self->mesh->s[c] + h * gauss_point[q];
  PetscReal ds = h * gauss_weight[q], P, B, a = self->scene->load.across;
  StraightMotion at;

  PetscFunctionBegin;
  PetscCall(StraightAt(self->scene, s, t, &at));
  PetscCall(SceneStiffness(self->scene, s, t, &B, NULL));
  P = StraightScales(self->scene) ? CompressionExact(self->scene, s, t)
                                  : self->compression[c * GAUSS + q];
  w->bend = ds / at.g * B * StraightRatio(self->scene, self->way);
  w->axial = ds * P / at.g;
  w->drag = ds * at.g * at.drag * a;
  /* the load across is N phi (a v2 + (1 - a) V theta), v2 = y_t + c theta */
  w->convect = ds * at.drag * (a * at.c + (1 - a) * at.V);
  w->inv_g = 1 / at.g;
  w->twist = at.g_s / (at.g * at.g);
  PetscFunctionReturn(0);
}

/* What the tip's force adds: -eta(1) (turns theta(1) + drags y_t(1)). Of all splines the last alone
   is not 0 at the tip. */
static PetscErrorCode AddTip(Straight self, PetscReal t) {
  PetscInt last = self->n - 1, cell = self->mesh->cells - 1;
  PetscReal press, turns, drags, g, B[3][BASIS];
  const PetscReal tip = 1;

  PetscFunctionBegin;
  if (last < self->first || last >= self->last) PetscFunctionReturn(0);
  PetscCall(StraightTip(self->scene, t, &press, &turns, &drags));
  PetscCall(GrowthStretch(self->scene->growth, 1, &tip, t, &g, NULL, NULL));
  StraightBasis(self, cell, 1, B);
  for (PetscInt j = PetscMax(0, 2 - cell); j < BASIS; j++)
    self->press[(last - self->first) * BAND + j] -= turns * B[1][j] / g;
  self->drag[(last - self->first) * BAND + 3] += drags;
  PetscFunctionReturn(0);
}

/* Assembles rows first to last - 1 of the three parts at time t. */
static PetscErrorCode AssembleParts(Straight self, PetscReal t) {
  PetscInt first = self->first, last = self->last;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(self->bend, 3 * (last - first) * BAND));
  if (!self->curve) PetscCall(PetscMalloc1(self->mesh->cells * GAUSS * BASIS, &self->curve));
  if (!StraightScales(self->scene)) PetscCall(CompressionAtGauss(self, t));
  PetscCall(GrowthLength(self->scene->growth, t, &self->length, NULL));
  self->assembled = t;
  for (PetscInt c = PetscMax(0, first - 1); c <= PetscMin(self->mesh->cells - 1, last + 1); c++)
    for (int q = 0; q < GAUSS; q++) {
      const PetscReal *B = self->basis + (c * GAUSS + q) * 3 * BASIS, *B1 = B + BASIS,
                      *B2 = B1 + BASIS;
      Weights w = {0};
      PetscReal *curve = self->curve + (c * GAUSS + q) * BASIS;
      PetscCall(WeightsAt(self, t, c, q, &w));
      for (PetscInt i = 0; i < BASIS; i++)
        curve[i] = PetscSqrtReal(w.bend) * (w.inv_g * B2[i] - w.twist * B1[i]);
      for (PetscInt i = 0; i < BASIS; i++) {
        PetscInt row = c - 2 + i;
        if (row < PetscMax(0, first) || row >= last) continue;
        for (PetscInt j = PetscMax(0, 2 - c); j < BASIS; j++) {
          PetscInt at = (row - first) * BAND + 3 + j - i;
          self->bend[at] -= curve[i] * curve[j];
          self->press[at] += w.axial * B1[i] * B1[j] - w.convect * B[i] * B1[j];
          self->drag[at] += w.drag * B[i] * B[j];
        }
      }
    }
  PetscCall(AddTip(self, t));
  PetscFunctionReturn(0);
}

/* Sees to it that the parts of these rows are there, at time t but for their scale; ratio is L(t)
   over the length they were assembled at (1 if the problem does not only scale). Those that only
   scale are assembled as they are at t = 0, whenever they are first asked for: so a run that goes
   on has the same round-off. */
static PetscErrorCode PartsAt(Straight self, PetscReal t, PetscInt first, PetscInt last,
                              PetscReal *ratio) {
  PetscInt n = (last - first) * BAND;
  PetscReal length;

  PetscFunctionBegin;
  PetscCall(GrowthLength(self->scene->growth, t, &length, NULL));
  if (self->first != first || self->last != last ||
      (!StraightScales(self->scene) && self->assembled != t)) {
    if (self->last - self->first != last - first) {
      PetscCall(PetscFree(self->bend));
      PetscCall(PetscMalloc1(3 * n, &self->bend));
      self->press = self->bend + n;
      self->drag = self->press + n;
    }
    self->first = first;
    self->last = last;
    PetscCall(AssembleParts(self, StraightScales(self->scene) ? 0 : t));
  }
  *ratio = length / self->length;
  PetscFunctionReturn(0);
}

/*
  StraightBands - rows first to last - 1 of K and D at time t.

  K, D   [last - first][BAND], the caller's: column r - 3 + b of row r at b; entries outside the
         matrix are 0

  For feed K holds the convective part too and is not symmetric: v2 = y_t + (c/g) y'. For uniform
  growth and feed, bend falls with L^-3, press is constant and drag grows with L: assembled once.
*/
PetscErrorCode StraightBands(Straight straight, PetscReal t, PetscInt first, PetscInt last,
                             PetscReal *K, PetscReal *D) {
  PetscReal ratio;

  PetscFunctionBegin;
  PetscCall(PartsAt(straight, t, first, last, &ratio));
  for (PetscInt k = 0; k < (last - first) * BAND; k++) {
    K[k] = straight->bend[k] / (ratio * ratio * ratio) + straight->press[k];
    D[k] = straight->drag[k] * ratio;
  }
  PetscFunctionReturn(0);
}

/*
  StraightApply - f = D y_t - K y in rows first to last - 1.

  y, y_t, f   indexed by unknown; y and y_t known three beyond the rows on each side

  Bending is applied as curve^T (curve y), not by its matrix: the entries of K grow like N^4, and
  the round-off of K y with them; in two steps it grows like N^2.
*/
PetscErrorCode StraightApply(Straight straight, PetscReal t, PetscInt first, PetscInt last,
                             const PetscReal *y, const PetscReal *y_t, PetscReal *f) {
  PetscReal ratio;

  PetscFunctionBegin;
  PetscCall(PartsAt(straight, t, first, last, &ratio));
  for (PetscInt i = first; i < last; i++) {
    f[i] = 0;
    for (PetscInt b = PetscMax(0, 3 - i); b < BAND && i + b - 3 < straight->n; b++) {
      PetscInt at = (i - first) * BAND + b, j = i + b - 3;
      f[i] += straight->drag[at] * ratio * y_t[j] - straight->press[at] * y[j];
    }
  }
  for (PetscInt c = PetscMax(0, first - 1); c <= PetscMin(straight->mesh->cells - 1, last + 1); c++)
    for (int q = 0; q < GAUSS; q++) {
      const PetscReal *curve = straight->curve + (c * GAUSS + q) * BASIS;
      PetscReal bent = 0;
      for (PetscInt j = PetscMax(0, 2 - c); j < BASIS; j++) bent += curve[j] * y[c - 2 + j];
      bent /= ratio * ratio * ratio;
      for (PetscInt j = PetscMax(0, first - c + 2); j < BASIS && c - 2 + j < last; j++)
        f[c - 2 + j] += curve[j] * bent;
    }
  PetscFunctionReturn(0);
}
