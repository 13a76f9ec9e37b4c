/* A rod in the plane whose growth feels the force along it: its equations (yields.h), and what all
   of them go by. */
#include "curve/cell.h"
#include "rod/frame.h"
#include "rod/yields.h"
#include <string.h>

enum { OF_V = FIELDS, OF_L, ALL }; /* behind the others */

static PetscReal AlongAt(const PetscReal u[]) {
  return Dot2(Direction2(u[TH]), From2(u + N1));
}

/* V' at a point. */
static PetscReal SlopeAt(const Rod rod, const Law *law, const Point *p) {
  return YieldsSlope(rod, law->s, law->g, Dot2(From2(p->at.axes[0]), From2(p->n)));
}

/* FrameYieldSee - tells the law of growth what it is in a state. Collective. */
PetscErrorCode FrameYieldSee(Rod rod, PetscReal t, Vec U) {
  PetscFunctionBegin;
  PetscCall(YieldsSee(rod, t, U, AlongAt));
  PetscFunctionReturn(0);
}

/* FrameYieldLaws - those of nodes and middles are as the unknowns there have them. */
void FrameYieldLaws(Rod rod) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt from = 2 * (PetscMax(rod->first - 1, 0) - rod->first + 1),
                 to = 2 * (PetscMin(rod->end, rod->last) - rod->first + 1);

  YieldsLaws(rod, frame->bow, AlongAt);
  for (PetscInt k = from; k <= to; k++) {
    const LearnedStretch *stretch = &rod->learned->stretch[k];
    frame->law[k].g = stretch->g;
    frame->law[k].g_t = stretch->g_t;
    frame->law[k].c = stretch->c;
  }
}

/* FrameYieldResidual - of the cell between nodes i and i + 1. */
void FrameYieldResidual(Rod rod, PetscInt i, PetscReal h, const Point *a, const Point *mid,
                        const Point *b) {
  const Frame *frame = (const Frame *)rod->data;
  const Law *law = &frame->law[2 * (i - rod->first + 1)];

  YieldsResidual(rod, i,
                 h * (frame->end_weight * (SlopeAt(rod, law, a) + SlopeAt(rod, law + AT_B, b)) +
                      frame->mid_weight * SlopeAt(rod, law + AT_MID, mid)));
}

/* FrameYieldEnds - of what is at the clamp, or the tip: p the point there. */
void FrameYieldEnds(Rod rod, PetscInt i, const Point *p) {
  YieldsEnds(rod, i, Dot2(From2(p->at.axes[0]), From2(p->n)));
}

/* FrameYieldBegin - the equation of V at the clamp by its node. */
void FrameYieldBegin(Rod rod, const Point *p, PetscReal by[ALL]) {
  const Vector2 q = From2(p->at.axes[0]);
  PetscReal slope;

  memset(by, 0, ALL * sizeof(*by));
  by[OF_V] = 1;
  (void)YieldsPart(rod, Dot2(q, From2(p->n)), &slope);
  slope *= GrowthYieldInflow(rod->scene->growth);
  by[TH] = -slope * Cross2(q, From2(p->n));
  Put2(Times2(-slope, q), by + N1);
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
                  y = YieldsPart(rod, Dot2(q, n), &by_force);

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
      YieldsClocks(rod, cell->place, e, c, cell->h,
                   &(YieldsChange){of.own[OF_V], of.at_node[OF_V], of.node.g, of.mid.g},
                   learned->clock);
    }
}
