#include "rod/strands.h"
#include "base/blocks.h"
#include "curve/cell.h"
#include "curve/nearest.h"
#include "curve/spread.h"

enum { A1, A2, ATH, B1, B2, BTH, SPOT_UNKNOWNS }; /* x and theta at both ends of a cell */

/* A place on the curve of the rod: cell, and 0 <= z <= 1 in it. */
typedef struct {
  PetscInt cell;
  PetscReal z;
  PetscReal x[2], slope[2], bend[2]; /* x and its first and second derivative by z */
} Spot;

/* How fast a place moves, and by z; the rest is for its derivatives. */
typedef struct {
  PetscReal v[2], v_z[2], t[2], size, c; /* tangent, |x_z|, slide */
} Motion;

/* A point and what it is near to. */
typedef struct {
  PetscInt point;
  int side;         /* 0 left, 1 right */
  PetscBool ends;   /* the foot is an end of the rod */
  PetscBool apart;  /* they are not the same strand */
  PetscBool active; /* they press */
  Spot at, foot;
  PetscReal n[2], distance, gap;
  PetscReal p, p_gap;        /* pressure and its derivative */
  PetscReal slip, w, w_slip; /* relative velocity along the surface, friction over mu p */
} Pair;

struct _Strands {
  Scene scene;
  const Contact *contact;
  PetscInt cells, points; /* points: 2 cells + 1 */
  PetscReal apart;        /* what is nearer along the rod is the same strand */
  PetscReal time;         /* of what follows: laws at the points */
  PetscReal *g, *g_t, *c, *strain, *arc, *weight;
  PetscInt n, room;
  Pair *pair;
  PetscInt *slot;        /* of a point's side: its pair, -1 none */
  PetscReal (*q)[2];     /* directions at the nodes, in the state that is looked at */
  Spot *spot;            /* where points are in it, as far as anyone has asked: */
  PetscBool *placed;     /* ... has anyone? */
  PetscBool searched;    /* it has been searched for pairs just now */
  PetscReal *seen;       /* x at the nodes when pairs were looked for */
  PetscReal (*force)[2]; /* StrandsForces() */
  FrictionDual *dual;    /* of a point's side; NULL: no friction */
  StrandSlope *slopes;
  PetscInt slopes_room;
  StrandSum sum;
};

static PetscReal Dot(const PetscReal a[2], const PetscReal b[2]) {
  return a[0] * b[0] + a[1] * b[1];
}

static PetscReal Cross(const PetscReal a[2], const PetscReal b[2]) {
  return a[0] * b[1] - a[1] * b[0];
}

/* ---- the curve ---- */

/* What a cell's curve is made of: x at its ends and x_z = h g q there, with q turned to the left.
 */
typedef struct {
  const PetscReal *u[2], *u_t[2];
  PetscReal h, q[2][2], g[2], g_t[2];
} Ends;

static void EndsOf(const struct _Strands *self, const StrandState *state, PetscInt cell, Ends *e) {
  const PetscReal *s = self->scene->mesh.s;
  const PetscReal(*q)[2] = (const PetscReal(*)[2])self->q;

  e->h = s[cell + 1] - s[cell];
  for (int k = 0; k < 2; k++) {
    e->u[k] = state->u + (cell + k) * state->stride;
    e->u_t[k] = state->u_t ? state->u_t + (cell + k) * state->stride : NULL;
    for (int d = 0; d < 2; d++) e->q[k][d] = q[cell + k][d];
    e->g[k] = self->g[2 * (cell + k)];
    e->g_t[k] = self->g_t[2 * (cell + k)];
  }
}

/* x, x_z, x_zz at place z of a cell. */
static void SpotOn(const Ends *e, Spot *spot) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(spot->z, value, slope, bend);
  for (int d = 0; d < 2; d++) {
    PetscReal y[4] = {e->u[0][d], e->h * e->g[0] * e->q[0][d], e->u[1][d],
                      e->h * e->g[1] * e->q[1][d]};
    spot->x[d] = spot->slope[d] = spot->bend[d] = 0;
    for (int k = 0; k < 4; k++) {
      spot->x[d] += value[k] * y[k];
      spot->slope[d] += slope[k] * y[k];
      spot->bend[d] += bend[k] * y[k];
    }
  }
}

static void SpotAt(const struct _Strands *self, const StrandState *state, PetscInt cell,
                   PetscReal z, Spot *spot) {
  Ends e;
  EndsOf(self, state, cell, &e);
  spot->cell = cell;
  spot->z = z;
  SpotOn(&e, spot);
}

/* Where a collocation point is. */
static void PointCell(const struct _Strands *self, PetscInt point, PetscInt *cell, PetscReal *z) {
  PetscBool tip = (PetscBool)(point == self->points - 1);
  *cell = tip ? self->cells - 1 : point / 2;
  *z = tip ? 1 : point % 2 ? 0.5 : 0;
}

/* Where a point is in the state that is looked at. */
static const Spot *SpotOf(const struct _Strands *self, const StrandState *state, PetscInt point) {
  Spot *spot = &self->spot[point];
  PetscInt cell;
  PetscReal z;

  if (self->placed[point]) return spot;
  PointCell(self, point, &cell, &z);
  SpotAt(self, state, cell, z, spot);
  self->placed[point] = PETSC_TRUE;
  return spot;
}

/* The arc length of a place. */
static PetscReal ArcAt(const struct _Strands *self, PetscInt cell, PetscReal z) {
  return self->arc[cell] + z * (self->arc[cell + 1] - self->arc[cell]);
}

/*
  FootFrom - the place of the curve nearest to x, by Newton's method on (x - y(z)).y_z = 0 from a
  place near it, on to the next cell where that is. ends: it is an end of the rod.
*/
static void FootFrom(const struct _Strands *self, const StrandState *state, const PetscReal x[2],
                     Spot *foot, PetscBool *ends) {
  Ends e;

  *ends = PETSC_FALSE;
  EndsOf(self, state, foot->cell, &e);
  for (int k = 0; k < CURVE_MOST; k++) {
    PetscReal o[2], step;
    CurveWay way;
    SpotOn(&e, foot);
    for (int d = 0; d < 2; d++) o[d] = x[d] - foot->x[d];
    step = CurveStep(Dot(o, foot->slope), Dot(foot->slope, foot->slope), Dot(o, foot->bend));
    way = CurveGo(self->cells, foot->z + step, &foot->cell, &foot->z, ends);
    if (way == CURVE_ARRIVED) return;
    if (way == CURVE_NEXT) EndsOf(self, state, foot->cell, &e);
  }
  SpotOn(&e, foot);
}

/* ---- laws ---- */

/* What the laws give at time t: at the points, and the arc length at the nodes. */
static PetscErrorCode LawsAt(Strands self, PetscReal t) {
  Growth growth = self->scene->growth;
  const PetscReal *s = self->scene->mesh.s;

  PetscFunctionBegin;
  PetscCall(SceneContactAt(self->scene, t));
  if (self->time == t) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < self->points; k++) {
    PetscReal z = k % 2 ? (s[k / 2] + s[k / 2 + 1]) / 2 : s[k / 2];
    PetscCall(GrowthStretch(growth, 1, &z, t, &self->g[k], &self->g_t[k], NULL));
    self->c[k] = GrowthSlide(growth, z, t);
    self->strain[k] = GrowthStrain(growth, z, t, self->g_t[k]);
  }
  PetscCall(GrowthArc(growth, self->cells + 1, s, t, self->arc, NULL));
  self->time = t;
  PetscFunctionReturn(0);
}

/* The directions at the nodes; the places of points are those of another state. */
static void DirectionsIn(Strands self, const StrandState *state) {
  for (PetscInt i = 0; i <= self->cells; i++) {
    const PetscReal theta = state->u[i * state->stride + 2];
    self->q[i][0] = PetscCosReal(theta);
    self->q[i][1] = PetscSinReal(theta);
  }
  for (PetscInt k = 0; k < self->points; k++) self->placed[k] = PETSC_FALSE;
}

/* ---- which points are near to what ---- */

/* A search under way. */
typedef struct {
  Strands self;
  const StrandState *state;
  PetscReal reach;
  PetscErrorCode error;
} Looking;

static PetscBool SameStrand(const Block *a, PetscInt first_a, PetscInt last_a, const Block *b,
                            PetscInt first_b, PetscInt last_b, void *ctx) {
  const Strands self = ((const Looking *)ctx)->self;
  return (PetscBool)(self->arc[last_b] - self->arc[first_a] < self->apart);
}

/* Is the foot of x on this cell? 1 yes; 2 it is the end of the rod there; 0 no. */
static int HasFoot(const struct _Strands *self, const StrandState *state, PetscInt cell,
                   const PetscReal x[2]) {
  PetscReal f[2], o[2];

  for (int k = 0; k < 2; k++) {
    const PetscReal *u = state->u + (cell + k) * state->stride;
    for (int d = 0; d < 2; d++) o[d] = x[d] - u[d];
    f[k] = Dot(o, self->q[cell + k]);
  }
  if (f[0] >= 0 && f[1] < 0) return 1;
  if ((cell == 0 && f[0] < 0) || (cell == self->cells - 1 && f[1] >= 0)) return 2;
  return 0;
}

/* A new pair, in the place of one of the same side that is farther away. */
static PetscErrorCode Keep(Strands self, const Pair *pair) {
  PetscInt *slot = &self->slot[2 * pair->point + pair->side];

  PetscFunctionBegin;
  if (*slot >= 0) {
    if (pair->distance < self->pair[*slot].distance) self->pair[*slot] = *pair;
    PetscFunctionReturn(0);
  }
  if (self->n == self->room) {
    self->room = 2 * self->room + 64;
    PetscCall(PetscRealloc((size_t)self->room * sizeof(Pair), &self->pair));
  }
  *slot = self->n;
  self->pair[self->n++] = *pair;
  PetscFunctionReturn(0);
}

static PetscErrorCode LookAt(Looking *look, PetscInt point, PetscInt cell) {
  Strands self = look->self;
  const Spot *at = SpotOf(self, look->state, point);
  const int foot = HasFoot(self, look->state, cell, at->x);
  PetscReal o[2];
  Pair pair;

  PetscFunctionBegin;
  if (!foot) PetscFunctionReturn(0);
  pair = (Pair){.point = point, .at = *at};
  pair.foot.cell = cell;
  pair.foot.z = foot == 1 ? 0.5 : cell ? 1 : 0;
  FootFrom(self, look->state, pair.at.x, &pair.foot, &pair.ends);
  for (int d = 0; d < 2; d++) o[d] = pair.foot.x[d] - pair.at.x[d];
  pair.distance = hypot(o[0], o[1]);
  if (pair.distance >= look->reach) PetscFunctionReturn(0);
  pair.side = Cross(pair.at.slope, o) < 0;
  PetscCall(Keep(self, &pair));
  PetscFunctionReturn(0);
}

/* The points of one cell against another. */
static PetscErrorCode LookFrom(Looking *look, PetscInt from, PetscInt to) {
  PetscInt last = 2 * from + (from == look->self->cells - 1 ? 2 : 1);

  PetscFunctionBegin;
  for (PetscInt point = 2 * from; point <= last; point++) PetscCall(LookAt(look, point, to));
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

/*
  StrandsSearch - looks for all pairs that are near to touching, in a state that StrandsLoad() is
  asked for next. Not collective: the same on every rank.
*/
PetscErrorCode StrandsSearch(Strands self, const StrandState *state) {
  Looking look = {.self = self,
                  .state = state,
                  .reach = (1 + margin) * self->contact->diameter + self->contact->smooth};
  Blocks line;

  PetscFunctionBegin;
  PetscCall(LawsAt(self, state->t));
  DirectionsIn(self, state);
  for (PetscInt k = 0; k < self->n; k++)
    self->slot[2 * self->pair[k].point + self->pair[k].side] = -1;
  self->n = 0;
  for (PetscInt i = 0; i <= self->cells; i++)
    for (int d = 0; d < 2; d++) self->seen[2 * i + d] = state->u[i * state->stride + d];
  PetscCall(BlocksOfLine(2, self->cells, 2, self->seen, NULL, &line));
  BlocksPairs(line, look.reach, SameStrand, Meet, &look);
  PetscCall(BlocksDestroy(&line));
  PetscCall(look.error);
  self->searched = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* Has a node moved so far that there may be other pairs? */
static PetscBool Moved(const struct _Strands *self, const StrandState *state) {
  const PetscReal far = PetscSqr(margin * self->contact->diameter / 2);

  for (PetscInt i = 0; i <= self->cells; i++) {
    const PetscReal *x = state->u + i * state->stride, *y = self->seen + 2 * i;
    if (!(PetscSqr(x[0] - y[0]) + PetscSqr(x[1] - y[1]) < far)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ---- forces ---- */

/* The velocity of a place, x_t + c t, and its derivative by z. */
static void MotionOf(const struct _Strands *self, const StrandState *state, const Spot *spot,
                     Motion *m) {
  const PetscReal *c = self->c + 2 * spot->cell, z = spot->z;
  PetscReal value[4], slope[4], bend[4], c_z, along;
  Ends e;

  EndsOf(self, state, spot->cell, &e);
  Hermite(z, value, slope, bend);
  m->size = hypot(spot->slope[0], spot->slope[1]);
  m->c = CurveBetween(c, z);
  c_z = CurveBetweenSlope(c, z);
  for (int d = 0; d < 2; d++) m->t[d] = spot->slope[d] / m->size;
  along = Dot(m->t, spot->bend);
  for (int d = 0; d < 2; d++) {
    PetscReal y[4];
    for (int k = 0; k < 2; k++) {
      PetscReal perp = d ? e.q[k][0] : -e.q[k][1];
      y[2 * k] = e.u_t[k][d];
      y[2 * k + 1] = e.h * (e.g_t[k] * e.q[k][d] + e.g[k] * e.u_t[k][2] * perp);
    }
    m->v[d] = m->c * m->t[d];
    m->v_z[d] = c_z * m->t[d] + m->c * (spot->bend[d] - along * m->t[d]) / m->size;
    for (int k = 0; k < 4; k++) {
      m->v[d] += value[k] * y[k];
      m->v_z[d] += slope[k] * y[k];
    }
  }
}

/* The lengths of rod that a pair stands for: of the point, and of the tip if it is one. */
static void Shares(const struct _Strands *self, PetscInt point, PetscReal share[2]) {
  share[0] = self->g[point] * self->weight[point] / 2;
  share[1] = point == self->points - 1 ? self->contact->tip : 0;
}

static FrictionDual *DualOf(const struct _Strands *self, const Pair *pair) {
  return self->dual ? &self->dual[2 * pair->point + pair->side] : NULL;
}

/* Where a pair is, and its gap. */
static void PairPlace(const struct _Strands *self, const StrandState *state, Pair *pair) {
  PetscReal o[2];

  pair->at = *SpotOf(self, state, pair->point);
  FootFrom(self, state, pair->at.x, &pair->foot, &pair->ends);
  for (int d = 0; d < 2; d++) o[d] = pair->at.x[d] - pair->foot.x[d];
  pair->distance = hypot(o[0], o[1]);
  for (int d = 0; d < 2; d++) pair->n[d] = o[d] / pair->distance;
  pair->gap = pair->distance - self->contact->diameter;
  pair->apart =
      (PetscBool)(PetscAbsReal(ArcAt(self, pair->at.cell, pair->at.z) -
                               ArcAt(self, pair->foot.cell, pair->foot.z)) >= self->apart);
  pair->active =
      (PetscBool)(pair->gap < self->contact->smooth && pair->apart && pair->distance > 0);
}

/* The speed at which the point slips along its partner, to the left of the normal. */
static void PairSlip(const struct _Strands *self, const StrandState *state, Pair *pair) {
  Motion at, foot;

  MotionOf(self, state, &pair->at, &at);
  MotionOf(self, state, &pair->foot, &foot);
  pair->slip = pair->n[0] * (at.v[1] - foot.v[1]) - pair->n[1] * (at.v[0] - foot.v[0]);
}

/* The force on the point, per length of rod that it stands for:  f = p n - mu p w t. */
static void PairForce(const struct _Strands *self, const Pair *pair, PetscReal f[2]) {
  PetscReal rub = self->contact->friction * pair->p * pair->w;
  f[0] = pair->p * pair->n[0] + rub * pair->n[1];
  f[1] = pair->p * pair->n[1] - rub * pair->n[0];
}

/* What pushes the beginning of a rod that is fed in back along it, the clamp's direction x1: the
   clamp bears that, for it is the clamp that is there, at rest, while the material moves on. */
static PetscBool OnClamp(const struct _Strands *self, const Pair *pair) {
  return (PetscBool)(pair->ends && pair->foot.cell == 0 && pair->foot.z == 0 && self->c[0] != 0);
}

/* Hands a force to who takes it: on points as load per label, n' = load. */
static void HandOut(Strands self, const Pair *pair, const PetscReal f[2]) {
  const PetscReal borne[2] = {OnClamp(self, pair) ? pair->p * pair->n[0] : 0, 0};
  PetscReal share[2];
  Spread spread;

  Shares(self, pair->point, share);
  SpreadAt(self->points, pair->foot.cell, pair->foot.z, &spread);
  for (int d = 0; d < 2; d++) {
    PetscReal all = (share[0] + share[1]) * f[d];
    self->force[pair->point][d] -= share[0] * f[d] / self->weight[pair->point];
    self->force[self->points][d] += share[1] * f[d];
    self->sum.clamp[d] -= (share[0] + share[1]) * borne[d];
    all -= (share[0] + share[1]) * borne[d];
    for (int k = 0; k < 4; k++)
      self->force[spread.point[k]][d] += all * spread.share[k] / self->weight[spread.point[k]];
  }
}

static void AddToSum(Strands self, const Pair *pair) {
  StrandSum *sum = &self->sum;
  PetscReal share[2], all, U = ContactEnergy(self->contact, pair->gap);

  Shares(self, pair->point, share);
  all = share[0] + share[1];
  sum->energy += all * U;
  sum->strain += self->strain[pair->point] * self->weight[pair->point] / 2 * U +
                 share[0] * ContactEnergyRate(self->contact, pair->gap) +
                 (share[1] > 0 ? self->contact->tip_t * U +
                                     share[1] * ContactEnergyRate(self->contact, pair->gap)
                               : 0);
  if (!pair->point) sum->strain += self->c[0] / 2 * U; /* what is fed in comes with it */
  sum->normal += all * pair->p;
  sum->loss += all * self->contact->friction * pair->p * pair->w * pair->slip;
}

static void Nearest(Strands self, const Pair *pair) {
  const PetscReal *s = self->scene->mesh.s;
  const Spot *spot[2] = {&pair->at, &pair->foot};

  if (!pair->apart || pair->gap >= self->sum.nearest) return;
  self->sum.nearest = pair->gap;
  for (int k = 0; k < 2; k++)
    self->sum.at[k] = s[spot[k]->cell] + spot[k]->z * (s[spot[k]->cell + 1] - s[spot[k]->cell]);
  for (int d = 0; d < 2; d++) self->sum.x[d] = (pair->at.x[d] + pair->foot.x[d]) / 2;
}

/*
  StrandsLoad - finds the feet of all pairs and their forces, after a new search if nodes have moved
  far since the last. Not collective: the same on every rank.
*/
PetscErrorCode StrandsLoad(Strands self, const StrandState *state) {
  PetscReal f[2];

  PetscFunctionBegin;
  PetscCall(LawsAt(self, state->t));
  if (!self->searched) DirectionsIn(self, state);
  if (!self->searched && Moved(self, state)) PetscCall(StrandsSearch(self, state));
  self->searched = PETSC_FALSE;
  PetscCall(PetscArrayzero(self->force, self->points + 1));
  PetscCall(PetscMemzero(&self->sum, sizeof(self->sum)));
  self->sum.nearest = PETSC_MAX_REAL;
  for (PetscInt k = 0; k < self->n; k++) {
    Pair *pair = &self->pair[k];
    PairPlace(self, state, pair);
    Nearest(self, pair);
    if (!pair->active) continue;
    pair->p = ContactPressure(self->contact, pair->gap, &pair->p_gap);
    pair->slip = pair->w = pair->w_slip = 0;
    if (self->dual && state->u_t) {
      PairSlip(self, state, pair);
      pair->w = ContactRub(self->contact, pair->slip, DualOf(self, pair), &pair->w_slip);
    }
    PairForce(self, pair, f);
    HandOut(self, pair, f);
    AddToSum(self, pair);
  }
  for (int d = 0; d < 2; d++) {
    self->sum.sum[d] = self->sum.clamp[d] + self->force[self->points][d];
    for (PetscInt k = 0; k < self->points; k++)
      self->sum.sum[d] -= self->force[k][d] * self->weight[k];
  }
  PetscFunctionReturn(0);
}

/* StrandsForces - what StrandsLoad() has found: what contact adds to n' at each point (2 cells + 1
   of them), and behind them the force on the tip. Borrowed. */
const PetscReal (*StrandsForces(Strands self))[2] {
  return (const PetscReal(*)[2])self->force;
}

/* StrandsSum - the sums over all places in contact that StrandsLoad() has found. */
void StrandsSum(Strands self, StrandSum *sum) {
  *sum = self->sum;
}

/* ---- derivatives ---- */

/* The derivatives of a place at fixed z, and of x_z, by the unknowns of its cell. */
static void SpotSlope(const Ends *e, PetscReal z, PetscReal by[2][SPOT_UNKNOWNS],
                      PetscReal slope_by[2][SPOT_UNKNOWNS]) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(z, value, slope, bend);
  for (int d = 0; d < 2; d++)
    for (int k = 0; k < 2; k++) {
      PetscReal turn = e->h * e->g[k] * (d ? e->q[k][0] : -e->q[k][1]);
      for (int c = 0; c < 2; c++) {
        by[d][3 * k + c] = c == d ? value[2 * k] : 0;
        slope_by[d][3 * k + c] = c == d ? slope[2 * k] : 0;
      }
      by[d][3 * k + ATH] = value[2 * k + 1] * turn;
      slope_by[d][3 * k + ATH] = slope[2 * k + 1] * turn;
    }
}

/* The derivatives of its velocity at fixed z. */
static void MotionSlope(const struct _Strands *self, const StrandState *state, const Spot *spot,
                        const PetscReal shift[3], PetscReal by[2][SPOT_UNKNOWNS]) {
  PetscReal value[4], slope[4], bend[4], x_by[2][SPOT_UNKNOWNS], z_by[2][SPOT_UNKNOWNS];
  Motion m;
  Ends e;

  EndsOf(self, state, spot->cell, &e);
  Hermite(spot->z, value, slope, bend);
  SpotSlope(&e, spot->z, x_by, z_by);
  MotionOf(self, state, spot, &m);
  for (int d = 0; d < 2; d++)
    for (int f = 0; f < SPOT_UNKNOWNS; f++) {
      PetscReal turned = m.t[0] * z_by[1][f] - m.t[1] * z_by[0][f]; /* t turned to the left . x_z */
      by[d][f] = shift[f % 3] * x_by[d][f] + m.c * (d ? m.t[0] : -m.t[1]) * turned / m.size;
    }
  for (int d = 0; d < 2; d++)
    for (int k = 0; k < 2; k++) {
      PetscReal perp = d ? e.q[k][0] : -e.q[k][1];
      by[d][3 * k + ATH] +=
          value[2 * k + 1] * e.h * (e.g_t[k] * perp - e.g[k] * e.u_t[k][2] * e.q[k][d]);
    }
}

/* How the pair's normal, distance, foot and slip change. */
typedef struct {
  PetscReal z[STRAND_UNKNOWNS], n[2][STRAND_UNKNOWNS], gap[STRAND_UNKNOWNS], slip[STRAND_UNKNOWNS];
} PairSlope;

/*
  With r = x - y the way from the foot to the point, y_z and y_zz at the foot:
    dz = (y_z.(dx - dy) + r.dy_z) / (y_z.y_z - r.y_zz),    dr = dx - dy - y_z dz,
    dgap = n.dr,    dn = (dr - n dgap)/|r|.
*/
static void PlaceSlope(const struct _Strands *self, const StrandState *state, const Pair *pair,
                       PairSlope *by) {
  PetscReal x[2][SPOT_UNKNOWNS], y[2][SPOT_UNKNOWNS], y_z[2][SPOT_UNKNOWNS], skip[2][SPOT_UNKNOWNS];
  const PetscReal *slope = pair->foot.slope,
                  r[2] = {pair->distance * pair->n[0], pair->distance * pair->n[1]};
  const PetscReal stiff = Dot(slope, slope) - Dot(r, pair->foot.bend);
  Ends e;

  EndsOf(self, state, pair->at.cell, &e);
  SpotSlope(&e, pair->at.z, x, skip);
  EndsOf(self, state, pair->foot.cell, &e);
  SpotSlope(&e, pair->foot.z, y, y_z);
  for (int f = 0; f < STRAND_UNKNOWNS; f++) {
    PetscBool of_foot = (PetscBool)(f >= SPOT_UNKNOWNS);
    int g = f % SPOT_UNKNOWNS;
    PetscReal dr[2];
    for (int d = 0; d < 2; d++) dr[d] = of_foot ? -y[d][g] : x[d][g];
    by->z[f] = 0;
    if (!pair->ends)
      by->z[f] = (Dot(slope, dr) + (of_foot ? r[0] * y_z[0][g] + r[1] * y_z[1][g] : 0)) / stiff;
    for (int d = 0; d < 2; d++) dr[d] -= slope[d] * by->z[f];
    by->gap[f] = Dot(pair->n, dr);
    for (int d = 0; d < 2; d++) by->n[d][f] = (dr[d] - pair->n[d] * by->gap[f]) / pair->distance;
  }
}

/* slip = t.V, V the relative velocity, t = n turned to the left: d slip = t.dV + V.dt */
static void SlipSlope(const struct _Strands *self, const StrandState *state, const Pair *pair,
                      const PetscReal shift[3], PairSlope *by) {
  PetscReal v[2][2][SPOT_UNKNOWNS], V[2];
  const PetscReal t[2] = {-pair->n[1], pair->n[0]};
  Motion at, foot;

  MotionOf(self, state, &pair->at, &at);
  MotionOf(self, state, &pair->foot, &foot);
  MotionSlope(self, state, &pair->at, shift, v[0]);
  MotionSlope(self, state, &pair->foot, shift, v[1]);
  for (int d = 0; d < 2; d++) V[d] = at.v[d] - foot.v[d];
  for (int f = 0; f < STRAND_UNKNOWNS; f++) {
    int of_foot = f >= SPOT_UNKNOWNS, g = f % SPOT_UNKNOWNS;
    PetscReal sign = of_foot ? -1 : 1;
    by->slip[f] = V[1] * by->n[0][f] - V[0] * by->n[1][f] - Dot(t, foot.v_z) * by->z[f];
    for (int d = 0; d < 2; d++) by->slip[f] += sign * t[d] * v[of_foot][d][g];
  }
}

/* The derivatives of what each taker takes, from those of the force f per length:
     df = dp (n - mu w t) + p (dn - mu w dt) - mu p w' t dslip,   dt = dn turned to the left. */
static void TakersSlope(const struct _Strands *self, const Pair *pair, const PairSlope *by,
                        StrandSlope *slope) {
  const PetscReal mu = self->contact->friction, p = pair->p, w = pair->w;
  const PetscBool clamp = OnClamp(self, pair);
  PetscReal share[2], f[2];
  Spread spread;

  Shares(self, pair->point, share);
  SpreadAt(self->points, pair->foot.cell, pair->foot.z, &spread);
  PairForce(self, pair, f);
  slope->cell[0] = pair->at.cell;
  slope->cell[1] = pair->foot.cell;
  slope->takers = 5 + (share[1] > 0);
  slope->taker[4] = pair->point;
  slope->taker[5] = self->points;
  for (int k = 0; k < 4; k++) slope->taker[k] = spread.point[k];
  for (int d = 0; d < 2; d++) {
    const PetscReal n = pair->n[d], t = d ? pair->n[0] : -pair->n[1], all = share[0] + share[1];
    for (int u = 0; u < STRAND_UNKNOWNS; u++) {
      PetscReal dt = d ? by->n[0][u] : -by->n[1][u],
                df = pair->p_gap * by->gap[u] * (n - mu * w * t) + p * (by->n[d][u] - mu * w * dt) -
                     mu * p * pair->w_slip * t * by->slip[u],
                borne = clamp && d == 0 ? pair->p_gap * by->gap[u] * n + p * by->n[0][u] : 0;
      for (int k = 0; k < 4; k++)
        slope->by[k][d][u] =
            all * ((df - borne) * spread.share[k] + f[d] * spread.share_z[k] * by->z[u]) /
            self->weight[spread.point[k]];
      slope->by[4][d][u] = -share[0] * df / self->weight[pair->point];
      slope->by[5][d][u] = share[1] * df;
    }
  }
}

/* Brings the dual of a pair up to its slip. */
static void Advance(Strands self, Pair *pair, PetscBool fresh) {
  const PetscReal v[2] = {pair->slip, 0};
  FrictionDual *dual = DualOf(self, pair);

  if (fresh)
    FrictionDualReset(&self->contact->rub, v, dual);
  else
    FrictionDualAdvance(&self->contact->rub, v, dual);
  pair->w = ContactRub(self->contact, pair->slip, dual, &pair->w_slip);
}

/* What does not touch when a Newton solve begins, and may before it ends, begins from nothing: what
   is left of earlier solves a run that is restarted does not have. (Shifts stay.) */
static void Forget(Strands self) {
  for (PetscInt k = 0; k < 2 * self->points; k++) {
    FrictionDual *dual = &self->dual[k];
    if (self->slot[k] >= 0 && self->pair[self->slot[k]].active) continue;
    for (int d = 0; d < 2; d++) dual->v[d] = dual->w[d] = 0;
  }
}

/*
  StrandsLinearise - the derivatives of the forces that StrandsLoad() found in the same state. Not
  collective: the same on every rank.

  shift   of the rates of x1, x2, theta: du_t/du
  fresh   a Newton solve begins
  n       how many contacts there are; slopes: of each, borrowed
*/
PetscErrorCode StrandsLinearise(Strands self, const StrandState *state, const PetscReal shift[3],
                                PetscBool fresh, PetscInt *n, const StrandSlope **slopes) {
  PetscFunctionBegin;
  if (self->slopes_room < self->n) {
    self->slopes_room = self->room;
    PetscCall(PetscFree(self->slopes));
    PetscCall(PetscMalloc1(self->slopes_room, &self->slopes));
  }
  *n = 0;
  *slopes = self->slopes;
  if (fresh && self->dual) Forget(self);
  for (PetscInt k = 0; k < self->n; k++) {
    Pair *pair = &self->pair[k];
    PairSlope by = {.z = {0}};
    if (!pair->active) continue;
    PlaceSlope(self, state, pair, &by);
    if (self->dual) {
      Advance(self, pair, fresh);
      SlipSlope(self, state, pair, shift, &by);
    }
    TakersSlope(self, pair, &by, &self->slopes[(*n)++]);
  }
  PetscFunctionReturn(0);
}

/* StrandsNear - the cells of all pairs that are near to touching: of the point, of the foot. The
   caller frees them. */
PetscErrorCode StrandsNear(Strands self, PetscInt *n, PetscInt (**cells)[2]) {
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(self->n, cells));
  *n = self->n;
  for (PetscInt k = 0; k < self->n; k++) {
    (*cells)[k][0] = self->pair[k].at.cell;
    (*cells)[k][1] = self->pair[k].foot.cell;
  }
  PetscFunctionReturn(0);
}

/* StrandsHold - moves what holds strands that stick to each other (exact Coulomb friction); creep
   is the largest speed of a place that is held, which counts the less the less it is pressed. */
PetscErrorCode StrandsHold(Strands self, PetscReal seen, PetscReal *creep) {
  PetscFunctionBegin;
  for (PetscInt k = 0; self->dual && k < self->n; k++) {
    const Pair *pair = &self->pair[k];
    const PetscReal v[2] = {pair->slip, 0};
    if (!pair->active || pair->p == 0) continue;
    *creep = LargerOf(*creep, PetscMin(1, self->contact->friction * pair->p) *
                                  FrictionDualHold(v, seen, friction_hold, DualOf(self, pair)));
  }
  PetscFunctionReturn(0);
}

/* StrandsZones - how many zones of contact there are: points in contact with what lies farther
   along the rod, one after the other. */
PetscInt StrandsZones(Strands self) {
  PetscInt zones = 0, before[2] = {-2, -2};

  for (PetscInt point = 0; point < self->points; point++)
    for (int side = 0; side < 2; side++) {
      PetscInt k = self->slot[2 * point + side];
      const Pair *pair = k < 0 ? NULL : &self->pair[k];
      if (!pair || !pair->active || !ContactBears(self->contact, pair->gap) ||
          pair->foot.cell < pair->at.cell)
        continue;
      zones += before[side] < point - 1;
      before[side] = point;
    }
  return zones;
}

/* StrandsDuals - what Newton's method remembers: 2 of each point, 0: nothing. Borrowed. */
PetscInt StrandsDuals(Strands self, FrictionDual **duals) {
  *duals = self->dual;
  return self->dual ? 2 * self->points : 0;
}

/* ---- life ---- */

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
  self->cells = cells;
  self->points = n;
  self->apart = PETSC_PI / 2 * scene->contact.diameter;
  self->time = PETSC_MIN_REAL;
  PetscCall(PetscCalloc6(n, &self->g, n, &self->g_t, n, &self->c, n, &self->strain, cells + 1,
                         &self->arc, n, &self->weight));
  PetscCall(PetscCalloc4(2 * n, &self->slot, 2 * (cells + 1), &self->seen, n + 1, &self->force,
                         cells + 1, &self->q));
  PetscCall(PetscCalloc2(n, &self->spot, n, &self->placed));
  if (scene->contact.friction > 0) PetscCall(PetscCalloc1(2 * n, &self->dual));
  for (PetscInt k = 0; k < 2 * n; k++) self->slot[k] = -1;
  for (PetscInt k = 0; k < 2 * (cells + 1); k++) self->seen[k] = PETSC_MAX_REAL;
  CurveWeights(cells, scene->mesh.s, self->weight);
  PetscFunctionReturn(0);
}

PetscErrorCode StrandsDestroy(Strands *strands) {
  Strands self = *strands;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(PetscFree6(self->g, self->g_t, self->c, self->strain, self->arc, self->weight));
  PetscCall(PetscFree4(self->slot, self->seen, self->force, self->q));
  PetscCall(PetscFree2(self->spot, self->placed));
  PetscCall(PetscFree(self->dual));
  PetscCall(PetscFree(self->pair));
  PetscCall(PetscFree(self->slopes));
  PetscCall(PetscFree(*strands));
  PetscFunctionReturn(0);
}
