/*
  A rod in the plane whose growth feels the force along it (material/growth_yield.c). Beside the
  others it has the unknowns V and L of each node, and the equations

    V' = g e,   L' = 0,      s = 0: V = 0, of a rod that is fed y;      s = 1: L_t = V,

  with g = L, c = V - s L_t, and g e = w y, y = (1 + n.q/Pi)_+, w that of the law without force.
*/
#include "curve/cell.h"
#include "rod/frame.h"
#include <string.h>

enum { V = 0, L = 1, OF_V = FIELDS, OF_L, ALL }; /* in arrays of both, and behind the others */

/* y where the force along the rod is so, and its slope by that. */
static PetscReal Yields(const Rod rod, Vector2 q, const PetscReal n[], PetscReal *slope) {
  const PetscReal limit = rod->scene->growth->yield, y = 1 + Dot2(q, From2(n)) / limit;

  if (slope) *slope = y > 0 ? 1 / limit : 0;
  return PetscMax(0, y);
}

/* V' at a label. */
static PetscReal SlopeOfV(const Rod rod, PetscReal s, PetscReal length, Vector2 q,
                          const PetscReal n[]) {
  PetscReal by_length;
  return GrowthYieldWeight(rod->scene->growth, s, length, &by_length) * Yields(rod, q, n, NULL);
}

/* FrameYieldSee - tells the law of growth what it is in a state: V, V' and L of all nodes, on every
   rank. Collective. */
PetscErrorCode FrameYieldSee(Rod rod, PetscReal t, Vec U) {
  enum { VALUES = 3 };
  const PetscInt fields = rod->model->fields, n = rod->last + 1;
  const PetscReal *s = rod->scene->mesh.s, *v;
  PetscReal *all, *speed, *slope;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(VALUES * n, &all, n, &speed, n, &slope));
  PetscCall(VecGetArrayRead(U, (const PetscScalar **)&v));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    const PetscReal *u = v + (i - rod->first) * fields;
    all[VALUES * i] = u[OF_V];
    all[VALUES * i + 1] = SlopeOfV(rod, s[i], u[OF_L], Direction2(u[TH]), u + N1);
    all[VALUES * i + 2] = u[OF_L];
  }
  PetscCall(VecRestoreArrayRead(U, (const PetscScalar **)&v));
  PetscCall(LearnedGather(rod, VALUES, all));
  for (PetscInt i = 0; i < n; i++) {
    speed[i] = all[VALUES * i];
    slope[i] = all[VALUES * i + 1];
  }
  PetscCall(GrowthYieldSee(rod->scene->growth, t, n, s, all[VALUES * n - 1], speed, slope));
  PetscCall(PetscFree3(all, speed, slope));
  PetscFunctionReturn(0);
}

/* FrameYieldLaws - those of nodes and middles, by the unknowns there, and the clocks of what is
   learned there: behind FrameYieldSee(), which the laws of the time have come from. */
void FrameYieldLaws(Rod rod) {
  const Frame *frame = (const Frame *)rod->data;
  const Learned learned = rod->learned;
  const PetscInt from = PetscMax(rod->first - 1, 0), to = PetscMin(rod->end, rod->last);
  const PetscBool by_rate = rod->scene->tropism.by_rate;
  PetscReal slope = 0, before = 0;

  for (PetscInt i = from; i <= to; i++, before = slope) {
    const PetscInt at = i - rod->first + 1;
    const PetscReal *u = learned->u + at * FIELDS, *w = learned->w + at * 2,
                    *w_t = learned->w_t + at * 2;
    Law *law = &frame->law[2 * at];
    law->g = w[L];
    law->g_t = w_t[L];
    law->c = i == rod->last ? 0 : w[V] - law->s * w_t[L]; /* (the tip is its material) */
    slope = SlopeOfV(rod, law->s, w[L], Direction2(u[TH]), u + N1);
    if (!by_rate) learned->clock[2 * at] = slope / law->g;
    if (i == from) continue;
    law[-1].g = (law[-2].g + law->g) / 2;
    law[-1].g_t = (law[-2].g_t + law->g_t) / 2;
    law[-1].c = CurveMid(frame->bow * (law->s - law[-2].s), w[V - 2], before, w[V], slope) -
                law[-1].s * law[-1].g_t;
    if (!by_rate)
      learned->clock[2 * at - 1] =
          (1.5 * (w[V] - w[V - 2]) / (law->s - law[-2].s) - (before + slope) / 4) / law[-1].g;
  }
}

/* FrameYieldResidual - of the cell between nodes i and i + 1. */
void FrameYieldResidual(Rod rod, PetscInt i, PetscReal h, const Point *a, const Point *mid,
                        const Point *b) {
  const Frame *frame = (const Frame *)rod->data;
  const Learned learned = rod->learned;
  const PetscInt at = i - rod->first + 1;
  const Law *law = &frame->law[2 * at];
  const PetscReal *w = learned->w + at * 2;
  PetscReal *row = learned->w_row + at * 2;

  row[2 + V] = w[2 + V] - w[V] -
               h * (frame->end_weight *
                        (SlopeOfV(rod, law[AT_A].s, law[AT_A].g, From2(a->at.axes[0]), a->n) +
                         SlopeOfV(rod, law[AT_B].s, law[AT_B].g, From2(b->at.axes[0]), b->n)) +
                    frame->mid_weight * SlopeOfV(rod, law[AT_MID].s, law[AT_MID].g,
                                                 From2(mid->at.axes[0]), mid->n));
  row[L] = w[2 + L] - w[L];
}

/* FrameYieldEnds - of what is at the clamp, or the tip: p the point there. */
void FrameYieldEnds(Rod rod, PetscInt i, const Point *p) {
  const Learned learned = rod->learned;
  const PetscInt at = i - rod->first + 1;
  const PetscReal *w = learned->w + at * 2;

  if (i == 0)
    learned->w_row[at * 2 + V] = w[V] - GrowthYieldInflow(rod->scene->growth) *
                                            Yields(rod, From2(p->at.axes[0]), p->n, NULL);
  if (i == rod->last) learned->w_row[at * 2 + L] = learned->w_t[at * 2 + L] - w[V];
}

/* FrameYieldBegin - the equation of V at the clamp by its node. */
void FrameYieldBegin(Rod rod, const Point *p, PetscReal by[ALL]) {
  const Vector2 q = From2(p->at.axes[0]);
  PetscReal slope;

  memset(by, 0, ALL * sizeof(*by));
  by[OF_V] = 1;
  (void)Yields(rod, q, p->n, &slope);
  slope *= GrowthYieldInflow(rod->scene->growth);
  by[TH] = -slope * Cross2(q, From2(p->n));
  Put2(Times2(-slope, q), by + N1);
}

/* FrameYieldEnd - the last equation of the tip, L_t = V. */
void FrameYieldEnd(const PetscReal shift[], PetscReal by[ALL]) {
  memset(by, 0, ALL * sizeof(*by));
  by[OF_V] = -1;
  by[OF_L] = shift[OF_L];
}

/* How a point changes: its place, angle, moment and force, natural bend, velocity, and g. */
typedef struct {
  PetscReal theta, m, bend, g;
  Vector2 x, n, v;
} Change;

/* What that changes the slopes by, of all but L. */
static void Vary(const Rod rod, const Law *law, const Point *p, const LoadSlope *slope,
                 const Change *d, PetscReal df[OF_L]) {
  const Load *load = &rod->scene->load;
  const Vector2 q = From2(p->at.axes[0]), n = From2(p->n), dq = Times2(d->theta, Left2(q));
  const PetscReal g = law->g;
  PetscReal by_length, by_force;
  const PetscReal w = GrowthYieldWeight(rod->scene->growth, law->s, g, &by_length),
                  y = Yields(rod, q, p->n, &by_force);

  Put2(Along2(Times2(d->g, q), g, dq), df + X1);
  for (int k = X1; k <= X2; k++) {
    PetscReal *to = &df[N1 + k];
    *to = d->g / g * p->f[N1 + k] + g * Dot2(From2(slope->W[k]), d->v);
    if (load->turns) *to += g * slope->theta[k] * d->theta;
    if (load->moves) *to = *to + g * slope->x[k][X1] * d->x.x + g * slope->x[k][X2] * d->x.y;
  }
  df[TH] = d->g / g * p->f[TH] + g * (law->flex * d->m + d->bend);
  df[M] = d->g / g * p->f[M] - g * (dq.x * n.y - dq.y * n.x + q.x * d->n.y - q.y * d->n.x);
  df[OF_V] =
      by_length * d->g * y + w * by_force * (dq.x * n.x + dq.y * n.y + q.x * d->n.x + q.y * d->n.y);
}

/* The changes by one unknown of a node, or (ALL) the natural bend there: there, in the middle of
 * the cell, and of both slopes. */
typedef struct {
  Change node, mid;
  PetscReal own[ALL + 1], at_node[OF_L], at_mid[OF_L], slide[2]; /* at the node, in the middle */
  Vector2 feet[FOOT_ROWS];                                       /* of what feet do */
} Column;

/* What feet do changes with the place, the angle and the stretch of a node, and what slides. */
static void VaryFeet(const YieldCell *cell, int e, Column *of) {
  const PetscReal by[FOOT_STRETCHES] = {of->own[X1], of->own[X2], of->own[TH], of->own[OF_L],
                                        of->slide[0]};

  for (int k = 0; k < FOOT_ROWS && cell->feet; k++) {
    const PetscReal *slope = cell->feet[k][0];
    Vector2 sum = Times2(of->slide[1], Column2(slope, FOOT_UNKNOWNS, FOOT_MID_SLIDE));
    for (int f = 0; f < FOOT_MID_SLIDE; f++)
      sum = Along2(sum, by[f], Column2(slope, FOOT_UNKNOWNS, FOOT_STRETCHES * e + f));
    of->feet[k] = sum;
  }
}

/* Adds to a cell's equations what feet change, but for that of its middle (CellResidual()). */
static void AddFeet(const Frame *frame, const YieldCell *cell, const Column *of,
                    PetscReal equations[ALL]) {
  const Law *law = &cell->law[AT_MID];
  const Vector2 q = From2(cell->at[AT_MID]->at.axes[0]), turn = From2(cell->load[FOOT_KINK]);
  const PetscReal kink = PetscSqr(cell->h * law->g) * law->flex;

  Add2(Times2(-cell->h * frame->end_weight, Plus2(of->feet[AT_A], of->feet[AT_B])), equations + N1);
  equations[TH] -= kink * (2 * of->mid.g / law->g * Cross2(q, turn) -
                           of->mid.theta * Dot2(q, turn) + Cross2(q, of->feet[FOOT_KINK]));
}

static void Differentiate(const Rod rod, const YieldCell *cell, int e, int unknown, Column *of) {
  const Law *law = cell->law + 2 * e, *mid_law = cell->law + AT_MID;
  const Point *p = cell->at[2 * e], *mid = cell->at[AT_MID];
  const Vector2 q = From2(p->at.axes[0]), perp = Left2(q), q_mid = From2(mid->at.axes[0]);
  const PetscReal *shift = cell->shift[e], k = e ? -cell->bow : cell->bow;
  PetscReal turn, rate, slide, mid_slide;
  Vector2 dq, x_t, w;
  Change *d = &of->node, *m = &of->mid;

  memset(of, 0, sizeof(*of));
  of->own[unknown] = 1;
  turn = shift[TH] * of->own[TH];
  rate = shift[OF_L] * of->own[OF_L];
  slide = of->slide[0] = e && cell->tip ? 0 : of->own[OF_V] - law->s * rate;
  d->theta = of->own[TH];
  d->m = of->own[M];
  d->g = of->own[OF_L];
  d->bend = of->own[ALL];
  dq = Times2(d->theta, perp);
  x_t = (Vector2){shift[X1] * of->own[X1], shift[X2] * of->own[X2]};
  d->x = From2(of->own + X1);
  d->n = From2(of->own + N1);
  d->v = Along2(Along2(x_t, slide, q), law->c, dq);
  w = Along2(Along2(Times2(rate, q), law->g_t, dq), d->g * cell->turn[e] + law->g * turn, perp);
  w = Along2(w, -law->g * cell->turn[e] * d->theta, q);
  Vary(rod, law, p, cell->slope[2 * e], d, of->at_node);
  m->theta = CurveMidOf(k, d->theta, of->at_node[TH]);
  m->m = CurveMidOf(k, d->m, of->at_node[M]);
  m->g = d->g / 2;
  mid_slide = of->slide[1] =
      CurveMidOf(k, of->own[OF_V], of->at_node[OF_V]) - mid_law->s * rate / 2;
  VaryFeet(cell, e, of);
  m->x = CurveMidOf2(k, d->x, From2(of->at_node + X1));
  m->n = Along2(CurveMidOf2(k, d->n, From2(of->at_node + N1)), cell->bow,
                Minus2(of->feet[AT_A], of->feet[AT_B]));
  m->v = Along2(Along2(CurveMidOf2(k, x_t, w), mid_slide, q_mid), m->theta,
                Times2(mid_law->c, Left2(q_mid)));
  Vary(rod, mid_law, mid, cell->slope[AT_MID], m, of->at_mid);
  if (cell->feet) /* (which do not go with the stretch as n' does) */
    Add2(Along2(of->feet[AT_MID], -m->g / mid_law->g, From2(cell->load[AT_MID])), of->at_mid + N1);
}

/* How the clocks of a cell's places go with an unknown: that of the node, e = w y/g, and that of
   the middle, which the law of growth has from its cubic. */
static void Clocks(const Rod rod, const YieldCell *cell, int e, int unknown, const Column *of,
                   PetscReal clock[3][2][LEARNED_MOST]) {
  const Learned learned = rod->learned;
  const PetscReal *a = learned->clock + cell->place, g = cell->law[2 * e].g,
                  g_mid = cell->law[AT_MID].g, sign = e ? 1 : -1;

  if (rod->scene->tropism.by_rate) return;
  clock[2 * e][e][unknown] = (of->at_node[OF_V] - a[2 * e] * of->node.g) / g;
  clock[1][e][unknown] =
      (1.5 * sign * of->own[OF_V] / cell->h - of->at_node[OF_V] / 4 - a[1] * of->mid.g) / g_mid;
}

/* FrameYieldCell - the equations of a cell by its nodes, and what its middle has of their unknowns:
   all columns are found alike. */
void FrameYieldCell(Rod rod, const YieldCell *cell, PetscReal left[ALL][ALL],
                    PetscReal right[ALL][ALL], LearnedCell *learned) {
  const Frame *frame = (const Frame *)rod->data;
  Column of;

  memset(learned->clock, 0, sizeof(learned->clock));
  memset(learned->by_node, 0, sizeof(learned->by_node));
  memset(learned->by_bend, 0, sizeof(learned->by_bend));
  for (int e = 0; e < 2; e++)
    for (int c = 0; c <= ALL; c++) {
      PetscReal equations[ALL], middle[LEARNED_MOST] = {0};
      Differentiate(rod, cell, e, c, &of);
      for (int r = 0; r < ALL; r++) {
        equations[r] = (e ? 1 : -1) * of.own[r];
        if (r < OF_L)
          equations[r] -=
              cell->h * (frame->end_weight * of.at_node[r] + frame->mid_weight * of.at_mid[r]);
      }
      if (cell->feet) AddFeet(frame, cell, &of, equations);
      Put2(of.mid.x, middle + X1);
      middle[TH] = of.mid.theta;
      middle[M] = of.mid.m;
      if (c == ALL) {
        memcpy(learned->column[2 * e][0], equations, sizeof(equations));
        memcpy(learned->by_bend[e][0], middle, sizeof(middle));
        continue;
      }
      for (int r = 0; r < ALL; r++) (e ? right : left)[r][c] = equations[r];
      for (int r = X1; r <= M; r++) learned->by_node[e][r][c] = middle[r];
      Clocks(rod, cell, e, c, &of, learned->clock);
    }
}
