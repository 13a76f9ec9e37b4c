/* The frame model: first order in s, the constraint built in (docs/theory/rod.md),
     x' = g q,  theta' = g (m/B + k0),  m' = -g (q1 n2 - q2 n1),  n' = g F(v),  v = x_t + c q,
     s = 0: x = 0, theta = 0 (in the clamp's frame), m = 0 in a hinge, or m = 0, n = 0 where it is
            free;
     s = 1: the tip's three conditions (tip.h).
   On a cell of width h between nodes a and b, with y = (x, theta, m, n) and y' = f(y),
     order 4 (Lobatto):   y_b - y_a = h/6 (f_a + 4 f_mid + f_b),
                          y_mid = (y_a + y_b)/2 + h/8 (f_a - f_b), and x_t at mid likewise,
     order 2 (midpoint):  y_b - y_a = h f_mid,  y_mid = (y_a + y_b)/2.
   The rows of node i are the x and theta equations of the cell on its left and the m and n
   equations of the cell on its right: so each diagonal block can be factored without looking
   elsewhere. */
#include "rod/frame.h"
#include "curve/cell.h"
#include "rod/rules.h"
#include <string.h>

static const OptionRow rows[] = {
    ROW_WORD("-rod_order", "4", "2,4", 0, "order in space of the models frame and space")};
const OptionGroup frame_options = OPTION_GROUP_OF_ROD("Models frame and space", rows);

/* The present state of a rod, and the cell that is looked at. The points outlive it: a Jacobian
   follows on the residual of the same state. */
typedef struct {
  Rod rod;
  PetscReal t;
  const Load *load;
  const PetscReal (*u)[FIELDS], (*u_t)[FIELDS], *s;
  Vec local, local_t;
  Law *law;                   /* of nodes a, mid, b of the cell */
  FrictionDual *dual[3];      /* likewise */
  const PetscReal (*push)[3]; /* what strands add to n' at all points of the rod; NULL: none */
  PetscReal h;
  PetscBool known;  /* the points are: the state is that of the latest walk */
  PetscBool fresh;  /* a Newton solve begins here */
  PetscBool counts; /* modes are counted in it */
  Point *a, *mid, *b;
  LoadSlope slope[3]; /* of the load at them; the end of a cell is where the next begins */
} Cell;

/* The point at a node; u, u_t its six unknowns and their rates. */
static inline void PointAtNode(const Load *load, const Law *law, const FrictionDual *dual,
                               const PetscReal *u, const PetscReal *u_t, Point *p) {
  const Vector2 q = Direction2(u[TH]);

  p->theta = u[TH];
  p->m = u[M];
  Put2(From2(u + N1), p->n);
  Put2(From2(u + X1), p->at.x);
  Put2(q, p->at.q);
  Put2(Along2(From2(u_t + X1), law->c, q), p->at.v);
  PointEvaluate(load, law, dual, p);
}

/* The point in the middle of a cell between a and b; k = bow h. */
static void PointAtMid(const Load *load, const Law law[3], const FrictionDual *dual, PetscReal k,
                       const Point *a, const Point *b, const PetscReal *ua_t, const PetscReal *ub_t,
                       Point *p) {
  const PetscReal theta = CurveMid(k, a->theta, a->f[TH], b->theta, b->f[TH]);
  const Vector2 q = Direction2(theta), wa = VelocitySlope(&law[AT_A], a, ua_t[TH]),
                wb = VelocitySlope(&law[AT_B], b, ub_t[TH]);

  p->theta = theta;
  p->m = CurveMid(k, a->m, a->f[M], b->m, b->f[M]);
  Put2(q, p->at.q);
  Put2(CurveMid2(k, From2(a->n), From2(a->f + N1), From2(b->n), From2(b->f + N1)), p->n);
  Put2(Along2(CurveMid2(k, From2(ua_t + X1), wa, From2(ub_t + X1), wb), law[AT_MID].c, q), p->at.v);
  if (load->moves)
    Put2(CurveMid2(k, From2(a->at.x), From2(a->f + X1), From2(b->at.x), From2(b->f + X1)), p->at.x);
  PointEvaluate(load, &law[AT_MID], dual, p);
}

/* The laws at all points of the owned nodes and the cells beside them, at time t. */
static PetscErrorCode LawsAt(Rod rod, PetscReal t) {
  Frame *frame = (Frame *)rod->data;
  Scene scene = rod->scene;
  const PetscReal *s = scene->mesh.s;
  PetscInt i0 = PetscMax(rod->first - 1, 0), i1 = PetscMin(rod->end, rod->last);

  PetscFunctionBegin;
  if (frame->time == t) PetscFunctionReturn(0);
  for (PetscInt i = i0; i <= i1; i++)
    for (int half = 0; half < 2 && (!half || i < i1); half++) {
      Law *law = &frame->law[2 * (i - rod->first + 1) + half];
      PetscReal B;
      law->s = half ? (s[i] + s[i + 1]) / 2 : s[i];
      PetscCall(GrowthStretch(scene->growth, 1, &law->s, t, &law->g, &law->g_t, NULL));
      law->c = GrowthSlide(scene->growth, law->s, t);
      PetscCall(SceneStiffness(scene, law->s, t, &B, NULL));
      law->flex = 1 / B;
      PetscCall(SceneCurvature(scene, law->s, t, &law->k0, NULL));
    }
  frame->time = t;
  if (rod->learned) FrameLearnedLaws(rod, t);
  PetscFunctionReturn(0);
}

/* Forgets the points: what they depend on besides the state has changed, the shifts of the duals.
 */
static void Forget(Frame *frame) {
  RodForget(&frame->seen);
}

/* Adds to n' what strands that touch do at node i, or behind it. */
static inline void AddPush(const Cell *cell, PetscInt i, int half, Point *p) {
  if (!cell->push) return;
  Add2(From2(cell->push[2 * i + half]), p->f + N1);
}

/* The cell that is looked at, for its feet. */
static void FeetsCell(const Cell *cell, PetscInt i, FootCell *of) {
  const Frame *frame = (const Frame *)cell->rod->data;
  CurveCell *curve = &of->curve;

  *of = (FootCell){.dims = 2, .curve = {.h = cell->h}, .moves = PETSC_TRUE};
  of->first = (PetscBool)(i == 0);
  of->last = (PetscBool)(i == cell->rod->last - 1);
  for (int k = 0; k < FOOT_PARTS; k++) {
    curve->c[k] = cell->law[k].c;
    of->weight[k] = k == 1 ? frame->mid_weight : frame->end_weight;
  }
  for (int e = 0; e < 2; e++) {
    const Point *p = e ? cell->b : cell->a;
    curve->g[e] = cell->law[2 * e].g;
    Put2(VelocitySlope(&cell->law[2 * e], p, cell->u_t[i + e][TH]), curve->slope_t[e]);
    Put2(From2(cell->u[i + e] + X1), curve->x[e]);
    Put2(From2(cell->u_t[i + e] + X1), curve->x_t[e]);
    Put2(From2(p->at.q), curve->q[e]);
  }
}

/* The dual of the first foot of the cell, which is remembered, stands behind those of the walls at
   its middle. */
static FrictionDual *HeldAt(const Cell *cell) {
  const Frame *frame = (const Frame *)cell->rod->data;
  return cell->rod->scene->contact.walls.rub ? cell->dual[AT_MID] + frame->duals - 1 : NULL;
}

/* The feet of the cell, and what they push with; returns how many. */
static PetscInt CellsFeet(const Cell *cell, PetscInt i, FootCell *of, Feet *feet) {
  const Contact *contact = &cell->rod->scene->contact;

  if (!contact->thin) return 0;
  FeetsCell(cell, i, of);
  FeetFind(contact, of, contact->smooth, feet);
  FeetPush(contact, of, HeldAt(cell), feet);
  return feet->n;
}

/* What feet add to n' at the points of this cell alone; and so to its middle, which is known. */
static void AddFeet(Cell *cell, PetscInt i) {
  Frame *frame = (Frame *)cell->rod->data;
  PetscReal(*load)[FOOT_LOAD] = frame->feet[i - cell->rod->first + 1];
  Point *mid = cell->mid;
  FootCell of;
  Feet feet;

  (void)memset(load, 0, sizeof(FootLoad));
  if (!CellsFeet(cell, i, &of, &feet)) return;
  FeetHandOut(&of, &feet, load);
  Add2(Times2(frame->bow * cell->h, Minus2(From2(load[AT_A]), From2(load[AT_B]))), mid->n);
  Add2(From2(load[AT_MID]), mid->f + N1);
  mid->f[M] = -cell->law[AT_MID].g * Cross2(From2(mid->at.q), From2(mid->n));
}

/* The rates at node i, or their shifts: a place that is held at rest has none. */
static const PetscReal *Still(const Cell *cell, PetscInt i, const PetscReal *rates,
                              PetscReal still[FIELDS]) {
  if (i < cell->rod->last) return rates;
  return TipStill(&cell->rod->scene->tip, cell->t, 2, FIELDS, rates, still);
}

/* The point at node i. */
static Point *CellsNode(Cell *cell, PetscInt i) {
  Frame *frame = (Frame *)cell->rod->data;
  PetscInt k = 2 * (i - cell->rod->first + 1);
  Point *p = frame->point + k;
  PetscReal still[FIELDS];

  if (cell->known) return p;
  p->at.t = cell->t;
  PointAtNode(cell->load, frame->law + k, FrameDuals(frame, k), cell->u[i],
              Still(cell, i, cell->u_t[i], still), p);
  AddPush(cell, i, 0, p);
  return p;
}

/* Begins a walk along the cells that touch owned nodes, at the first of these or, on the last rank,
   at the tip. Collective. */
static PetscErrorCode CellsOpen(Rod rod, const RodState *at, PetscBool from_tip, Cell *cell) {
  Frame *frame = (Frame *)rod->data;
  const PetscReal(*couple)[3]; /* (none in the plane) */

  PetscFunctionBegin;
  if (frame->yields) {
    frame->time = PETSC_MIN_REAL; /* laws are those of the state */
    PetscCall(FrameYieldSee(rod, at->t, at->U));
  }
  PetscCall(LawsAt(rod, at->t));
  PetscCall(SceneContactAt(rod->scene, at->t));
  PetscCall(PetscMemzero(cell, sizeof(*cell)));
  cell->rod = rod;
  cell->t = at->t;
  cell->fresh = at->fresh;
  cell->counts = at->counts;
  cell->load = &rod->scene->load;
  cell->s = rod->scene->mesh.s;
  if (rod->learned) {
    PetscCall(FrameLearnedOpen(rod, at));
    if (frame->yields) FrameYieldLaws(rod);
    cell->u = (const PetscReal(*)[FIELDS])rod->learned->u + 1 - rod->first;
    cell->u_t = (const PetscReal(*)[FIELDS])rod->learned->u_t + 1 - rod->first;
  } else {
    PetscCall(RodOpen(rod, at->U, &cell->local, &cell->u));
    PetscCall(RodOpen(rod, at->U_t, &cell->local_t, &cell->u_t));
  }
  if (frame->strands) PetscCall(StrandRowsLoad(rod, frame->strands, at, &cell->push, &couple));
  PetscCall(RodRecognise(at, &frame->seen, &cell->known));
  if (from_tip)
    cell->a = CellsNode(cell, rod->last);
  else
    cell->b = CellsNode(cell, PetscMax(rod->first - 1, 0));
  PetscFunctionReturn(0);
}

static PetscErrorCode CellsClose(Cell *cell) {
  PetscFunctionBegin;
  if (cell->rod->learned) PetscFunctionReturn(0);
  PetscCall(RodClose(cell->rod, &cell->local, &cell->u));
  PetscCall(RodClose(cell->rod, &cell->local_t, &cell->u_t));
  PetscFunctionReturn(0);
}

/* Goes on to the cell between nodes i and i + 1, of which the node nearer to where the walk began
   is known. */
static void CellsGo(Cell *cell, PetscInt i, PetscBool from_tip) {
  Frame *frame = (Frame *)cell->rod->data;
  PetscInt k = 2 * (i - cell->rod->first + 1);

  cell->law = frame->law + k;
  for (int e = 0; e < 3; e++) cell->dual[e] = FrameDuals(frame, k + e);
  cell->h = cell->s[i + 1] - cell->s[i];
  if (from_tip) {
    cell->b = cell->a;
    cell->a = CellsNode(cell, i);
  } else {
    cell->a = cell->b;
    cell->b = CellsNode(cell, i + 1);
  }
  cell->mid = frame->point + k + 1;
  if (cell->known) return;
  PetscReal still[FIELDS];
  cell->mid->at.t = cell->t;
  PointAtMid(cell->load, cell->law, cell->dual[AT_MID], frame->bow * cell->h, cell->a, cell->b,
             cell->u_t[i], Still(cell, i + 1, cell->u_t[i + 1], still), cell->mid);
  AddPush(cell, i, 1, cell->mid);
  if (frame->feet) AddFeet(cell, i);
}

static void CellsNext(Cell *cell, PetscInt i) {
  CellsGo(cell, i, PETSC_FALSE);
}

/* (h g)^2/B in the middle of a cell, see FootLoad. */
static PetscReal KinkOf(const Cell *cell) {
  return PetscSqr(cell->h * cell->law[AT_MID].g) * cell->law[AT_MID].flex;
}

/* Residual of the six equations of a cell; feet: what they add to n' at its points, NULL: none. */
static void CellResidual(const Frame *frame, const Cell *cell, const PetscReal *ua,
                         const PetscReal *ub, const PetscReal (*feet)[FOOT_LOAD],
                         PetscReal r[FIELDS]) {
  for (int f = 0; f < FIELDS; f++)
    r[f] = ub[f] - ua[f] -
           cell->h * (frame->end_weight * (cell->a->f[f] + cell->b->f[f]) +
                      frame->mid_weight * cell->mid->f[f]);
  if (!feet) return;
  Add2(Times2(-cell->h * frame->end_weight, Plus2(From2(feet[AT_A]), From2(feet[AT_B]))), r + N1);
  r[TH] -= KinkOf(cell) * Cross2(From2(cell->mid->at.q), From2(feet[FOOT_KINK]));
}

/* What the tip's conditions are about. */
static TipState TipOf(const Point *end) {
  return (TipState){
      .at = end->at, .theta = end->theta, .m = {0, 0, end->m}, .n = {end->n[0], end->n[1]}};
}

/* The tip's own dual stands where that of a cell behind the tip would. */
static FrictionDual *TipDual(Rod rod) {
  return FrameDuals((Frame *)rod->data, 2 * (rod->last - rod->first + 1) + 1);
}

/* Which unknown the f-th condition at the beginning is about: */
static int OfClamp(Rod rod, int f) {
  static const int of[][3] = {
      [CLAMP_HELD] = {X1, X2, TH}, [CLAMP_HINGED] = {X1, X2, M}, [CLAMP_FREE] = {N1, N2, M}};
  return of[rod->scene->clamp][f];
}

/* ... it is 0. */
static void ClampResidual(Rod rod, const PetscReal u[FIELDS], PetscReal r[FIELDS]) {
  for (int f = X1; f <= TH; f++) r[f] = u[OfClamp(rod, f)];
}

static PetscErrorCode FrameResidual(Rod rod, const RodState *at, Vec F) {
  Frame *frame = (Frame *)rod->data;
  PetscReal(*F_)[FIELDS];
  PetscInt first = rod->first, end = rod->end;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(CellsOpen(rod, at, PETSC_FALSE, &cell));
  if (rod->learned)
    PetscCall(LearnedFill(rod, &F_));
  else
    PetscCall(DMDAVecGetArray(rod->da, F, &F_));
  for (PetscInt i = PetscMax(first - 1, 0); i < PetscMin(end, rod->last); i++) {
    PetscReal r[FIELDS];
    CellsNext(&cell, i);
    if (rod->learned) FrameLearnedResidual(rod, i, cell.h, cell.a, cell.mid, cell.b);
    CellResidual(frame, &cell, cell.u[i], cell.u[i + 1],
                 frame->feet ? (const PetscReal(*)[FOOT_LOAD])frame->feet[i - first + 1] : NULL, r);
    if (frame->yields) FrameYieldResidual(rod, i, cell.h, cell.a, cell.mid, cell.b);
    if (frame->yields && i == 0) FrameYieldEnds(rod, 0, cell.a);
    if (i >= first) PetscCall(PetscArraycpy(&F_[i][M], &r[M], 3));
    if (i + 1 < end) PetscCall(PetscArraycpy(&F_[i + 1][X1], &r[X1], 3));
  }
  if (first == 0) ClampResidual(rod, cell.u[0], F_[0]);
  if (end == rod->last + 1) {
    TipState tip = TipOf(cell.b);
    TipResidual(&rod->scene->tip, &tip, TipDual(rod), &F_[rod->last][M]);
    if (cell.push && rod->scene->tip.type == TIP_FREE)
      Add2(Times2(-1, From2(cell.push[2 * rod->last + 1])), &F_[rod->last][N1]);
    if (rod->learned) FrameLearnedResidual(rod, rod->last, 0, cell.b, NULL, NULL);
    if (frame->yields) FrameYieldEnds(rod, rod->last, cell.b);
  }
  if (rod->learned)
    PetscCall(LearnedFilled(rod, F));
  else
    PetscCall(DMDAVecRestoreArray(rod->da, F, &F_));
  PetscCall(CellsClose(&cell));
  PetscFunctionReturn(0);
}

/* Adds to the derivative of n_d' by x1, x2, theta at a node what comes of a load that varies in
   space and with direction. */
static void AddVaried(const Load *load, PetscReal g, const LoadSlope *slope, int d,
                      PetscReal fn[3]) {
  if (load->turns) fn[TH] += g * slope->theta[d];
  if (load->moves) Add2(Times2(g, From2(slope->x[d])), fn + X1);
}

/*
  J[6][6], the derivative of the cell's equations by the unknowns of one of its nodes.

  sign  -1 for node a (left), +1 for node b
  shift of each field: U_t = shift U + ...
  p     the node's point, mid the cell's
*/
static void CellJacobian(const Frame *frame, const Load *load, PetscReal h, PetscReal sign,
                         const PetscReal shift[], const Law *law, const Law *mid_law,
                         PetscReal theta_t, const Point *p, const LoadSlope *slope,
                         const Point *mid, const LoadSlope *mid_slope,
                         PetscReal J[FIELDS][FIELDS]) {
  const PetscReal g = law->g, gm = mid_law->g, k = -sign * frame->bow * h,
                  we = h * frame->end_weight, wm = h * frame->mid_weight * gm;
  const Vector2 q = From2(p->at.q), qm = From2(mid->at.q), perp = Left2(q), perp_m = Left2(qm);
  const PetscReal turn = g * Dot2(q, From2(p->n)); /* d(m')/d(theta) */
  const PetscReal turn_m = wm * Dot2(qm, From2(mid->n));
  const PetscReal by_m = k * g * law->flex, flex_m = wm * mid_law->flex; /* d(theta_mid)/dm */
  PetscReal fn[X2 + 1][3]; /* d(n') at the node by x1, x2, theta; k times that is d(n_mid) */

  for (int d = X1; d <= X2; d++) {
    const Vector2 drag = Times2(g, From2(slope->W[d]));
    const PetscReal across = d == X1 ? perp.x : perp.y, across_m = d == X1 ? perp_m.x : perp_m.y;
    fn[d][X1] = shift[X1] * drag.x;
    fn[d][X2] = shift[X2] * drag.y;
    fn[d][TH] = law->c * Dot2(drag, perp);
    if (!load->plain) AddVaried(load, g, slope, d, fn[d]);
    J[d][X1] = d == X1 ? sign : 0;
    J[d][X2] = d == X2 ? sign : 0;
    J[d][TH] = -we * g * across - wm * across_m / 2;
    J[d][M] = -wm * across_m * by_m;
    J[d][N1] = J[d][N2] = 0;
  }
  J[TH][X1] = J[TH][X2] = 0;
  J[TH][TH] = sign - flex_m * k * turn; /* of m_mid */
  J[TH][M] = -we * g * law->flex - flex_m / 2;
  J[TH][N1] = -flex_m * k * g * q.y;
  J[TH][N2] = flex_m * k * g * q.x;
  for (int f = X1; f <= TH; f++) J[M][f] = -wm * k * (qm.y * fn[X1][f] - qm.x * fn[X2][f]);
  J[M][TH] -= we * turn + turn_m / 2;
  J[M][M] = sign - turn_m * by_m;
  J[M][N1] = -we * g * q.y - wm * qm.y / 2;
  J[M][N2] = we * g * q.x + wm * qm.x / 2;
  for (int d = X1; d <= X2; d++) {
    const Vector2 drag = Times2(wm, From2(mid_slope->W[d]));
    const PetscReal along = mid_law->c * Dot2(drag, perp_m); /* by theta */
    const PetscReal by_q = Dot2(drag, q), by_perp = Dot2(drag, perp);
    PetscReal *row = J[N1 + d];
    row[X1] = -we * fn[d][X1] - shift[X1] * drag.x / 2;
    row[X2] = -we * fn[d][X2] - shift[X2] * drag.y / 2;
    row[TH] =
        -we * fn[d][TH] - along / 2 -
        k * (law->g_t * by_perp - g * theta_t * by_q + shift[TH] * g * by_perp); /* of v_mid */
    row[M] = -along * by_m;
    row[N1] = d == X1 ? sign : 0;
    row[N2] = d == X2 ? sign : 0;
    if (load->turns) {
      row[TH] -= wm * mid_slope->theta[d] / 2;
      row[M] -= wm * mid_slope->theta[d] * by_m;
    }
    if (load->moves) { /* by x_mid */
      const PetscReal *by_x = mid_slope->x[d];
      row[X1] -= wm * by_x[X1] / 2;
      row[TH] -= wm * by_x[X1] * k * g * perp.x;
      row[X2] -= wm * by_x[X2] / 2;
      row[TH] -= wm * by_x[X2] * k * g * perp.y;
    }
  }
}

/* The slope of the load at a point. */
static void Linearise(Cell *cell, int k, const Point *p) {
  LoadLinearise(2, cell->load, &p->at, cell->fresh, cell->dual[k], &cell->slope[k]);
}

/* The rows of a node, by itself (columns FIELDS ...) and its neighbours. */
typedef PetscReal Rows[FIELDS][3 * FIELDS];

/* Copies rows from ... from + 2 of a cell's derivative by one of its nodes. */
static void PutRows(Rows rows, int from, PetscInt column, PetscReal part[FIELDS][FIELDS]) {
  for (int f = from; f < from + 3; f++)
    for (int k = 0; k < FIELDS; k++) rows[f][column + k] = part[f][k];
}

/* What the feet of a cell do, and its slopes; no: there are none. shift_g: of the stretch, where it
   is an unknown; NULL: it is not. */
static PetscBool FeetSlopes(const Cell *cell, PetscInt i, const PetscReal shift[],
                            const PetscReal *shift_g, FootLoad load, FootSlope by) {
  FootEnd end[2];
  FootCell of;
  Feet feet;

  if (!CellsFeet(cell, i, &of, &feet)) return PETSC_FALSE;
  of.stretches = (PetscBool)(shift_g != NULL);
  (void)memset(by, 0, sizeof(FootSlope));
  (void)memset(load, 0, sizeof(FootLoad));
  (void)memset(end, 0, sizeof(end));
  FeetHandOut(&of, &feet, load);
  for (int e = 0; e < 2; e++) {
    const Law *law = &cell->law[2 * e];
    const Vector2 q = From2((e ? cell->b : cell->a)->at.q);
    const PetscReal theta_t = cell->u_t[i + e][TH];
    Put2(From2(shift + X1), end[e].curve.shift);
    CurveEndInPlane(q, theta_t, law->g, law->g_t, shift[TH], &end[e].curve);
    if (shift_g) Put2(Along2(Times2(*shift_g, q), theta_t, Left2(q)), end[e].stretch_t);
  }
  FeetLinearise(&cell->rod->scene->contact, &of, end, cell->fresh, HeldAt(cell), &feet, by);
  return PETSC_TRUE;
}

/* Adds to a cell's equations by its nodes what comes of its feet. */
static void AddFeetSlope(Cell *cell, PetscInt i, const PetscReal shift[],
                         PetscReal left[FIELDS][FIELDS], PetscReal right[FIELDS][FIELDS]) {
  const Frame *frame = (const Frame *)cell->rod->data;
  const Vector2 q = From2(cell->mid->at.q);
  const PetscReal h = cell->h, wm = h * frame->mid_weight * cell->law[AT_MID].g * frame->bow * h;
  const PetscReal kink = KinkOf(cell);
  PetscReal turn; /* of the kink by the angle in the middle */
  FootSlope by;
  FootLoad load;

  if (!FeetSlopes(cell, i, shift, NULL, load, by)) return;
  turn = -kink * Dot2(q, From2(load[FOOT_KINK]));
  left[TH][TH] -= turn / 2;
  right[TH][TH] -= turn / 2;
  left[TH][M] -= turn * frame->bow * h * cell->law[AT_A].g * cell->law[AT_A].flex;
  right[TH][M] += turn * frame->bow * h * cell->law[AT_B].g * cell->law[AT_B].flex;
  for (int u = 0; u < 2 * FOOT_PLANE; u++) {
    PetscReal(*J)[FIELDS] = u < FOOT_PLANE ? left : right;
    const Vector2 a = Column2(by[AT_A][0], FOOT_UNKNOWNS, u),
                  mid = Column2(by[AT_MID][0], FOOT_UNKNOWNS, u),
                  b = Column2(by[AT_B][0], FOOT_UNKNOWNS, u),
                  turned = Column2(by[FOOT_KINK][0], FOOT_UNKNOWNS, u), bow = Minus2(a, b),
                  sum = Along2(Times2(frame->end_weight, Plus2(a, b)), frame->mid_weight, mid);
    J[TH][u % FOOT_PLANE] -= kink * Cross2(q, turned);
    J[M][u % FOOT_PLANE] -= wm * Cross2(bow, q); /* of n in the middle */
    J[N1][u % FOOT_PLANE] -= h * sum.x;
    J[N2][u % FOOT_PLANE] -= h * sum.y;
  }
}

/* The shifts at node i; where modes are counted friction holds a tip that is still. */
static const PetscReal *ShiftsAt(const Cell *cell, PetscInt i, const PetscReal *shift,
                                 PetscReal still[FIELDS]) {
  return cell->counts ? shift : Still(cell, i, shift, still);
}

/* A cell's equations by its nodes, left and right; the slopes at its middle and at those of its
   ends that are new on this walk are brought up to the present state first. */
static void CellBlocks(Cell *cell, PetscInt i, PetscBool new_a, PetscBool new_b,
                       const PetscReal shift[], PetscReal left[FIELDS][FIELDS],
                       PetscReal right[FIELDS][FIELDS]) {
  const Frame *frame = (const Frame *)cell->rod->data;
  PetscReal still[FIELDS];

  if (!new_a) cell->slope[AT_A] = cell->slope[AT_B];
  if (!new_b) cell->slope[AT_B] = cell->slope[AT_A];
  if (new_a) Linearise(cell, 0, cell->a);
  if (new_b) Linearise(cell, 2, cell->b);
  Linearise(cell, 1, cell->mid);
  CellJacobian(frame, cell->load, cell->h, -1, shift, cell->law, cell->law + AT_MID,
               cell->u_t[i][TH], cell->a, &cell->slope[AT_A], cell->mid, &cell->slope[AT_MID],
               left);
  CellJacobian(frame, cell->load, cell->h, 1, ShiftsAt(cell, i + 1, shift, still), cell->law + AT_B,
               cell->law + AT_MID, cell->u_t[i + 1][TH], cell->b, &cell->slope[AT_B], cell->mid,
               &cell->slope[AT_MID], right);
  if (frame->feet) AddFeetSlope(cell, i, shift, left, right);
}

/* The tip's equations by its own unknowns. */
static void TipBlock(const Cell *cell, const Point *end, const PetscReal shift[],
                     PetscReal by[TIP_ROWS][FIELDS]) {
  Rod rod = cell->rod;
  TipState tip = TipOf(end);
  PetscReal still[FIELDS];

  TipJacobian(&rod->scene->tip, &tip, ShiftsAt(cell, rod->last, shift, still), cell->fresh,
              TipDual(rod), by);
}

/* CellBlocks(), of a rod whose growth feels force; slopes are new but that at a. */
static void YieldBlocks(Cell *cell, PetscInt i, PetscBool new_a, const PetscReal shift[],
                        PetscReal left[YIELD_FIELDS][YIELD_FIELDS],
                        PetscReal right[YIELD_FIELDS][YIELD_FIELDS], LearnedCell *learned) {
  const Frame *frame = (const Frame *)cell->rod->data;
  FootSlope by;
  FootLoad load;
  PetscReal still[YIELD_FIELDS] = {[FIELDS] = shift[FIELDS], shift[FIELDS + 1]};
  YieldCell of = {.place = 2 * (i - cell->rod->first + 1),
                  .tip = (PetscBool)(i + 1 == cell->rod->last),
                  .h = cell->h,
                  .bow = frame->bow * cell->h,
                  .shift = {shift, ShiftsAt(cell, i + 1, shift, still)},
                  .law = cell->law,
                  .at = {cell->a, cell->mid, cell->b}};

  for (int e = 0; e < 2; e++) of.turn[e] = cell->u_t[i + e][TH];
  if (!new_a)
    cell->slope[AT_A] = cell->slope[AT_B]; /* (each slope is brought up to the state once) */
  for (int k = new_a ? 0 : 1; k < 3; k++) Linearise(cell, k, of.at[k]);
  for (int k = 0; k < 3; k++) of.slope[k] = &cell->slope[k];
  if (frame->feet && FeetSlopes(cell, i, shift, &shift[FIELDS + 1], load, by)) {
    of.load = load;
    of.feet = by;
  }
  FrameLearnedDrives(cell->rod, i, cell->h, cell->a, cell->mid, cell->b, new_a);
  FrameYieldCell(cell->rod, &of, left, right, learned);
  FrameLearnedSlopes(cell->rod, i, cell->h, cell->a, cell->mid, cell->b, PETSC_TRUE, PETSC_TRUE,
                     learned);
}

/* ... and its equations at the clamp, by the node there. */
static void YieldBegins(const Cell *cell, PetscReal begin[LINE_HALF + 1][YIELD_FIELDS]) {
  memset(begin, 0, (LINE_HALF + 1) * sizeof(*begin));
  for (int f = X1; f <= TH; f++) begin[f][OfClamp(cell->rod, f)] = 1;
  FrameYieldBegin(cell->rod, cell->a, begin[LINE_HALF]);
}

/* ... and those of the tip, by the last node. */
static void YieldEnds(const Cell *cell, const PetscReal shift[],
                      PetscReal end[LINE_HALF + 1][YIELD_FIELDS]) {
  PetscReal by[TIP_ROWS][FIELDS];

  TipBlock(cell, cell->b, shift, by);
  memset(end, 0, (LINE_HALF + 1) * sizeof(*end));
  for (int r = 0; r < TIP_ROWS; r++) memcpy(end[r], by[r], sizeof(by[r]));
  FrameYieldEnd(shift, end[LINE_HALF]);
}

/* The Jacobian of that. */
static PetscErrorCode YieldJacobian(Rod rod, const RodState *at, Mat J) {
  const PetscInt begin = PetscMax(rod->first - 1, 0);
  PetscReal left[YIELD_FIELDS][YIELD_FIELDS], right[YIELD_FIELDS][YIELD_FIELDS],
      end[LINE_HALF + 1][YIELD_FIELDS], *room;
  LearnedCell learned;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(8 * PetscSqr(rod->model->fields), &room));
  PetscCall(CellsOpen(rod, at, PETSC_FALSE, &cell));
  for (PetscInt i = begin; i < PetscMin(rod->end, rod->last); i++) {
    CellsNext(&cell, i);
    if (i == 0) YieldBegins(&cell, end);
    YieldBlocks(&cell, i, (PetscBool)(i == begin), at->shift, left, right, &learned);
    LearnedNodeSlope(rod, i, &learned.slope[AT_A], learned.clock[AT_A][0], at->shift);
    LearnedRows(rod, i, &learned, at->shift);
    PetscCall(LearnedMatrix(rod, i, i == 0 ? end[0] : NULL, &learned, left[0], right[0],
                            &learned.slope[AT_A], learned.clock[AT_A][0], NULL, room, J));
  }
  if (rod->end > rod->last) {
    YieldEnds(&cell, at->shift, end);
    LearnedNodeSlope(rod, rod->last, &learned.slope[AT_B], learned.clock[AT_B][1], at->shift);
    LearnedSignalSlope(rod, &learned.slope[AT_B], at->shift);
    PetscCall(LearnedMatrix(rod, rod->last, NULL, NULL, NULL, NULL, &learned.slope[AT_B],
                            learned.clock[AT_B][1], end[0], room, J));
  }
  PetscCall(CellsClose(&cell));
  PetscCall(PetscFree(room));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* Rows with their columns, and a cell's equations in turn, as they are eliminated: LearnedOrder().
 */
static void PutYields(const Rod rod, PetscInt rows, PetscReal from[][YIELD_FIELDS], PetscReal *to) {
  for (PetscInt r = 0; r < rows; r++) {
    const PetscReal *row = from[rows == YIELD_FIELDS ? LearnedOrder(rod, r) : r];
    for (PetscInt f = 0; f < YIELD_FIELDS; f++)
      to[r * YIELD_FIELDS + f] = row[LearnedOrder(rod, f)];
  }
}

/* FrameEliminate(), of a rod whose growth feels force, on one rank. */
static PetscErrorCode YieldEliminate(Rod rod, const RodState *at, Elimination elimination) {
  Halves line = EliminationHalves(elimination);
  PetscReal left[YIELD_FIELDS][YIELD_FIELDS], right[YIELD_FIELDS][YIELD_FIELDS],
      end[LINE_HALF + 1][YIELD_FIELDS], *a, *b;
  LearnedCell learned;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(CellsOpen(rod, at, PETSC_FALSE, &cell));
  HalvesBegin(line);
  for (PetscInt i = 0; i < rod->last; i++) {
    CellsNext(&cell, i);
    if (i == 0) {
      YieldBegins(&cell, end);
      PutYields(rod, LINE_HALF + 1, end, HalvesFirst(line));
    }
    YieldBlocks(&cell, i, (PetscBool)(i == 0), at->shift, left, right, &learned);
    if (i == 0) LearnedNodeSlope(rod, i, &learned.slope[AT_A], learned.clock[AT_A][0], at->shift);
    LearnedNodeSlope(rod, i + 1, &learned.slope[AT_B], learned.clock[AT_B][1], at->shift);
    LearnedCondense(rod, i, &learned, at->shift, left[0], right[0]);
    HalvesBlocks(line, &a, &b);
    PutYields(rod, YIELD_FIELDS, left, a);
    PutYields(rod, YIELD_FIELDS, right, b);
    HalvesCell(line);
  }
  LearnedSignalSlope(rod, &learned.slope[AT_B], at->shift);
  YieldEnds(&cell, at->shift, end);
  PutYields(rod, LINE_HALF + 1, end, left[0]);
  HalvesEnd(line, left[0]);
  PetscCall(CellsClose(&cell));
  LearnedCondensed(rod, elimination);
  PetscFunctionReturn(0);
}

/* What strands need to know of the cell that is looked at. */
static void KeepCell(const Cell *cell, StrandCell *kept) {
  const Frame *frame = (const Frame *)cell->rod->data;

  *kept = (StrandCell){.end_weight = cell->h * frame->end_weight,
                       .mid_weight = cell->h * frame->mid_weight,
                       .bow = cell->h * frame->bow,
                       .g = cell->law[AT_MID].g,
                       .q = {cell->mid->at.q[0], cell->mid->at.q[1]}};
}

/* FrameJacobian(), of a rod whose material learns its natural curvature. */
static PetscErrorCode LearnedJacobian(Rod rod, const RodState *at, Mat J) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt begin = PetscMax(rod->first - 1, 0);
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS], of_begin[LINE_HALF][FIELDS] = {{0}},
                                                         by[TIP_ROWS][FIELDS], *room;
  LearnedCell learned;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(8 * PetscSqr(rod->model->fields), &room));
  PetscCall(CellsOpen(rod, at, PETSC_FALSE, &cell));
  if (frame->strands) PetscCall(StrandRowsPattern(rod, frame->strands, at->fresh, J));
  for (int f = X1; f <= TH; f++) of_begin[f][OfClamp(rod, f)] = 1;
  for (PetscInt i = begin; i < PetscMin(rod->end, rod->last); i++) {
    CellsNext(&cell, i);
    CellBlocks(&cell, i, (PetscBool)(i == begin), PETSC_TRUE, at->shift, left, right);
    FrameLearnedCell(rod, i, cell.h, cell.a, cell.mid, cell.b, PETSC_TRUE,
                     (PetscBool)(i + 1 == rod->last), left, right, &learned);
    LearnedNodeSlope(rod, i, &learned.slope[AT_A], NULL, at->shift);
    LearnedRows(rod, i, &learned, at->shift);
    if (frame->strands && i >= rod->first) KeepCell(&cell, StrandRowsCell(rod, frame->strands, i));
    PetscCall(LearnedMatrix(rod, i, i == 0 ? of_begin[0] : NULL, &learned, left[0], right[0],
                            &learned.slope[AT_A], NULL, NULL, room, J));
  }
  if (rod->end > rod->last) {
    TipBlock(&cell, cell.b, at->shift, by);
    LearnedNodeSlope(rod, rod->last, &learned.slope[AT_B], NULL, at->shift);
    LearnedSignalSlope(rod, &learned.slope[AT_B], at->shift);
    PetscCall(LearnedMatrix(rod, rod->last, NULL, NULL, NULL, NULL, &learned.slope[AT_B], NULL,
                            by[0], room, J));
  }
  PetscCall(CellsClose(&cell));
  PetscCall(PetscFree(room));
  if (frame->strands) PetscCall(StrandRowsJacobian(rod, frame->strands, at, J));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

static PetscErrorCode FrameJacobian(Rod rod, const RodState *at, Mat J) {
  Frame *frame = (Frame *)rod->data;
  PetscInt first = rod->first, end = rod->end, begin = PetscMax(first - 1, 0);
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS];
  Cell cell;
  Rows row;

  PetscFunctionBegin;
  if (rod->learned) {
    PetscCall(frame->yields ? YieldJacobian(rod, at, J) : LearnedJacobian(rod, at, J));
    PetscFunctionReturn(0);
  }
  PetscCall(CellsOpen(rod, at, PETSC_FALSE, &cell));
  if (frame->strands) PetscCall(StrandRowsPattern(rod, frame->strands, at->fresh, J));
  PetscCall(PetscMemzero(row, sizeof(row)));
  if (first == 0)
    for (int f = X1; f <= TH; f++) row[f][FIELDS + OfClamp(rod, f)] = 1;
  for (PetscInt i = begin; i < end; i++) {
    PetscInt cols[3] = {i - 1, i, i < rod->last ? i + 1 : -1}; /* -1: none, ignored */
    if (i < rod->last) {
      CellsNext(&cell, i);
      CellBlocks(&cell, i, (PetscBool)(i == begin), PETSC_TRUE, at->shift, left, right);
      if (frame->strands && i >= first) KeepCell(&cell, StrandRowsCell(rod, frame->strands, i));
      PutRows(row, M, FIELDS, left);
      PutRows(row, M, 2 * FIELDS, right);
    } else {
      PetscReal by[TIP_ROWS][FIELDS];
      TipBlock(&cell, cell.b, at->shift, by);
      for (int f = 0; f < TIP_ROWS; f++)
        PetscCall(PetscArraycpy(&row[M + f][FIELDS], by[f], FIELDS));
    }
    if (i >= first) PetscCall(MatSetValuesBlocked(J, 1, &i, 3, cols, &row[0][0], INSERT_VALUES));
    PetscCall(PetscMemzero(row, sizeof(row)));
    if (i < rod->last) {
      PutRows(row, X1, 0, left);
      PutRows(row, X1, FIELDS, right);
    }
  }
  PetscCall(CellsClose(&cell));
  if (frame->strands) PetscCall(StrandRowsJacobian(rod, frame->strands, at, J));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* The tip's equations by its own unknowns, with springs for what holds it. */
static PetscErrorCode TipSprings(Rod rod, PetscReal t, PetscReal by[TIP_ROWS][FIELDS]) {
  const Tip *tip = &rod->scene->tip;
  PetscReal length;

  PetscFunctionBegin;
  PetscCall(GrowthLength(rod->scene->growth, t, &length, NULL));
  if (TipPoints(tip)) {
    by[0][M] = 1;
    by[0][TH] = rod_rule.spring_stiffer / length;
  }
  for (int d = 0; d < 2; d++)
    if (TipHolds(tip, d)) {
      by[1 + d][N1 + d] = 1;
      by[1 + d][X1 + d] = rod_rule.spring_stiffer / (length * length * length);
    }
  PetscFunctionReturn(0);
}

/* A beginning that turns, or is free, as springs. */
static PetscErrorCode BeginSprings(Rod rod, PetscReal t, Elimination elimination) {
  const ClampType clamp = rod->scene->clamp;
  PetscReal length;

  PetscFunctionBegin;
  if (clamp == CLAMP_HELD || rod->first > 0) PetscFunctionReturn(0);
  PetscCall(GrowthLength(rod->scene->growth, t, &length, NULL));
  EliminationSpring(elimination, rod_rule.spring_softer * length,
                    clamp == CLAMP_FREE ? rod_rule.spring_softer * PetscPowReal(length, 3) : 0);
  PetscFunctionReturn(0);
}

/* Condenses what the material of a cell has learned. new_a, new_b: as for CellBlocks(). */
static void Condense(Cell *cell, PetscInt i, PetscBool new_a, PetscBool new_b,
                     const PetscReal shift[], PetscReal left[FIELDS][FIELDS],
                     PetscReal right[FIELDS][FIELDS]) {
  Rod rod = cell->rod;
  LearnedCell learned;

  FrameLearnedCell(rod, i, cell->h, cell->a, cell->mid, cell->b, new_a, new_b, left, right,
                   &learned);
  if (new_a) LearnedNodeSlope(rod, i, &learned.slope[AT_A], NULL, shift);
  if (new_b) LearnedNodeSlope(rod, i + 1, &learned.slope[AT_B], NULL, shift);
  LearnedCondense(rod, i, &learned, shift, left[0], right[0]);
  if (i + 1 == rod->last) LearnedSignalSlope(rod, &learned.slope[AT_B], shift);
}

/* The same matrix, not assembled: each cell is eliminated as soon as it is known. The last of
   several ranks goes from the tip towards the clamp. */
static PetscErrorCode FrameEliminate(Rod rod, const RodState *at, Elimination elimination) {
  PetscBool from_tip = EliminationFromTip(elimination);
  PetscInt begin = PetscMax(rod->first - 1, 0), n = PetscMin(rod->end, rod->last) - begin;
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS], by[TIP_ROWS][FIELDS];
  Cell cell;

  PetscFunctionBegin;
  if (((const Frame *)rod->data)->yields && !at->counts) {
    PetscCall(YieldEliminate(rod, at, elimination));
    PetscFunctionReturn(0);
  }
  PetscCall(CellsOpen(rod, at, from_tip, &cell));
  if (from_tip) TipBlock(&cell, cell.a, at->shift, by);
  if (from_tip && at->counts) PetscCall(TipSprings(rod, at->t, by));
  EliminationBegin(elimination, (const PetscReal(*)[FIELDS])by);
  if (!from_tip) PetscCall(BeginSprings(rod, at->t, elimination));
  for (PetscInt k = 0; k < n; k++) {
    PetscInt i = from_tip ? begin + n - 1 - k : begin + k;
    CellsGo(&cell, i, from_tip);
    CellBlocks(&cell, i, (PetscBool)(from_tip || !k), (PetscBool)(!from_tip || !k), at->shift, left,
               right);
    if (rod->learned && !at->counts)
      Condense(&cell, i, (PetscBool)(from_tip || !k), (PetscBool)(!from_tip || !k), at->shift, left,
               right);
    if (i >= rod->first)
      EliminationCell(elimination, (const PetscReal(*)[FIELDS])left,
                      (const PetscReal(*)[FIELDS])right);
  }
  if (rod->end > rod->last && !from_tip) TipBlock(&cell, cell.b, at->shift, by);
  PetscCall(CellsClose(&cell));
  if (rod->learned && !at->counts) LearnedCondensed(rod, elimination);
  PetscCall(EliminationEnd(elimination, (const PetscReal(*)[FIELDS])by));
  PetscFunctionReturn(0);
}

/* Moves the shift at a point; creep is the largest speed so far. */
static void HoldPoint(const Load *load, const Place *at, PetscReal seen, FrictionDual *dual,
                      PetscReal *creep) {
  *creep = LargerOf(*creep, LoadHold(2, load, at, seen, dual));
}

/* ... at the feet of a cell. */
static void HoldFeet(Cell *cell, PetscInt i, PetscReal seen, PetscReal *creep) {
  const Contact *contact = &cell->rod->scene->contact;
  FootCell of;
  Feet feet;

  if (contact->walls.rub && CellsFeet(cell, i, &of, &feet))
    *creep = LargerOf(*creep, FeetHold(contact, &of, &feet, seen, HeldAt(cell)));
}

/* Adds what the points of cell i and its feet bear; end: what its first point does, and then its
   last one. */
static void AddForces(const Cell *cell, PetscInt i, RodForces *end, RodForces *sum) {
  const Frame *frame = (const Frame *)cell->rod->data;
  const Point *at[3] = {NULL, cell->mid, cell->b};
  const PetscReal weight[3] = {frame->end_weight, frame->mid_weight, frame->end_weight};
  FootCell of;
  Feet feet;
  PetscInt n = frame->feet ? CellsFeet(cell, i, &of, &feet) : 0;

  for (int k = 0; k < 3; k++) {
    if (at[k])
      LoadParts(2, cell->load, &at[k]->at, cell->dual[k], end->friction, end->walls, &end->moved);
    sum->moved += cell->h * weight[k] * cell->law[k].g * end->moved;
    for (int d = 0; d < 3; d++) {
      sum->friction[d] += cell->h * weight[k] * cell->law[k].g * end->friction[d];
      sum->walls[d] += cell->h * weight[k] * cell->law[k].g * end->walls[d];
    }
  }
  for (PetscInt k = 0; k < n; k++)
    for (int d = 0; d < 3; d++) {
      sum->walls[d] += feet.foot[k].force[d];
      sum->moved += feet.foot[k].force[d] * feet.touch[k].v[d];
    }
}

/* Adds what the tip bears. */
static void AddTip(const Cell *cell, RodForces *sum) {
  Rod rod = cell->rod;
  const Tip *tip = &rod->scene->tip;
  const TipState end = TipOf(cell->b);

  sum->moved += TipWalls(2, tip, &end, TipDual(rod), sum->tip);
  for (int d = 0; d < 3; d++) sum->walls[d] += sum->tip[d];
  for (int d = 0; d < 3 && cell->push && tip->type == TIP_FREE; d++)
    sum->tip[d] += cell->push[2 * rod->last + 1][d];
}

static PetscErrorCode FrameBears(Rod rod, const RodState *at, RodForces *sum) {
  RodForces end = {.moved = 0};
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  PetscCall(CellsOpen(rod, at, PETSC_FALSE, &cell));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    CellsNext(&cell, i);
    if (i < rod->first) continue;
    if (i == rod->first)
      LoadParts(2, cell.load, &cell.a->at, cell.dual[AT_A], end.friction, end.walls, &end.moved);
    AddForces(&cell, i, &end, sum);
  }
  if (rod->end == rod->last + 1) AddTip(&cell, sum);
  PetscCall(CellsClose(&cell));
  PetscFunctionReturn(0);
}

/* Moves the shifts of exact Coulomb friction; creep is the largest speed of what is held. */
static PetscErrorCode FrameHold(Rod rod, const RodState *at, PetscReal seen, PetscReal *creep) {
  Frame *frame = (Frame *)rod->data;
  PetscBool ends = (PetscBool)(frame->end_weight > 0);
  PetscInt first = PetscMax(rod->first - 1, 0);
  RodForces sum;
  Cell cell;

  PetscFunctionBegin;
  *creep = 0;
  PetscCall(FrameBears(rod, at, &sum));
  RodKeepBorne(rod, &sum);
  PetscCall(CellsOpen(rod, at, PETSC_FALSE, &cell));
  for (PetscInt i = first; i < PetscMin(rod->end, rod->last); i++) {
    CellsNext(&cell, i);
    /* the clamped end does not move unless it slides: a shift there would hold nothing, and
       round-off adds up in it to a force on a rod whose x2 may be 1e-25 */
    if (i == first && ends && (i > 0 || cell.law->c != 0 || rod->scene->clamp == CLAMP_FREE))
      HoldPoint(cell.load, &cell.a->at, seen, cell.dual[AT_A], creep);
    HoldPoint(cell.load, &cell.mid->at, seen, cell.dual[AT_MID], creep);
    if (ends) HoldPoint(cell.load, &cell.b->at, seen, cell.dual[AT_B], creep);
    if (frame->feet) HoldFeet(&cell, i, seen, creep);
  }
  if (rod->end == rod->last + 1) {
    const TipState end = TipOf(cell.b);
    *creep = LargerOf(*creep, TipHold(2, &rod->scene->tip, &end, seen, TipDual(rod)));
  }
  PetscCall(CellsClose(&cell));
  Forget(frame);
  if (frame->strands) PetscCall(StrandRowsHold(frame->strands, seen, creep));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, creep, 1, MPIU_REAL, MPI_MAX, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* The duals of each node and of the middle of the cell on its right, as a whole: a point that
   begins to press while Newton's method iterates goes on from where it pressed last. */
enum { RUBBING = 2 };

/* Value k of what is remembered at node i, in this order; NULL: nothing. */
static PetscReal *FrameRemembered(Rod rod, PetscInt i, PetscInt k) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt each = FrictionDualReals(RUBBING), own = 2 * frame->duals * each;

  if (k >= own) return StrandRowsRemembered(frame->strands, i, k - own);
  return FrictionDualReal(RUBBING, FrameDuals(frame, 2 * (i - rod->first + 1)) + k / each,
                          k % each);
}

static PetscErrorCode FrameRecalled(Rod rod) {
  Frame *frame = (Frame *)rod->data;

  PetscFunctionBegin;
  Forget(frame);
  if (frame->strands) PetscCall(StrandRowsRecalled(rod, frame->strands));
  PetscFunctionReturn(0);
}

/* Between a node and its unknowns. */
static void PutNode(const Node *node, PetscReal u[FIELDS]) {
  Put2(From2(node->x), u + X1);
  u[TH] = node->theta;
  u[M] = node->moment;
  Put2(From2(node->force), u + N1);
}

static void GetNode(const PetscReal u[FIELDS], Node *node) {
  Put2(From2(u + X1), node->x);
  node->theta = u[TH];
  node->moment = u[M];
  Put2(From2(u + N1), node->force);
}

static void GetRates(const PetscReal u_t[FIELDS], Node *node) {
  Put2(From2(u_t + X1), node->x_t);
  node->theta_t = u_t[TH];
}

static PetscErrorCode FrameSet(Rod rod, PetscReal t, const Node *nodes, Vec U) {
  const PetscInt fields = rod->model->fields;
  PetscReal *u;

  PetscFunctionBegin;
  PetscCall(VecGetArray(U, (PetscScalar **)&u));
  for (PetscInt i = 0; i < rod->end - rod->first; i++) PutNode(&nodes[i], u + i * fields);
  PetscCall(VecRestoreArray(U, (PetscScalar **)&u));
  if (rod->learned) PetscCall(LearnedSet(rod, nodes, U));
  if (!((Frame *)rod->data)->yields) PetscFunctionReturn(0);
  PetscCall(VecGetArray(U, (PetscScalar **)&u));
  for (PetscInt i = 0; i < rod->end - rod->first; i++)
    PetscCall(PetscArraycpy(u + i * fields + FIELDS, nodes[i].growth, 2));
  PetscCall(VecRestoreArray(U, (PetscScalar **)&u));
  PetscFunctionReturn(0);
}

static void FrameMoments(const PetscReal u[], const PetscReal change[], PetscReal m[3],
                         PetscReal dm[3]) {
  m[0] = u[M];
  dm[0] = change[M];
  m[1] = m[2] = dm[1] = dm[2] = 0;
}

static PetscErrorCode FrameGet(Rod rod, PetscReal t, Vec U, Vec U_t, Node *nodes) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt fields = rod->model->fields, n = rod->end - rod->first;
  const PetscReal *u;

  PetscFunctionBegin;
  if (frame->yields) PetscCall(FrameYieldSee(rod, t, U)); /* who asks goes on with its length */
  PetscCall(VecGetArrayRead(U, (const PetscScalar **)&u));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(PetscMemzero(&nodes[i], sizeof(PlaneNode)));
    GetNode(u + i * fields, &nodes[i]);
    if (frame->yields) PetscCall(PetscArraycpy(nodes[i].growth, u + i * fields + FIELDS, 2));
  }
  PetscCall(VecRestoreArrayRead(U, (const PetscScalar **)&u));
  if (rod->learned) PetscCall(LearnedGet(rod, U, nodes));
  if (!U_t) PetscFunctionReturn(0);
  PetscCall(VecGetArrayRead(U_t, (const PetscScalar **)&u));
  for (PetscInt i = 0; i < n; i++) GetRates(u + i * fields, &nodes[i]);
  PetscCall(VecRestoreArrayRead(U_t, (const PetscScalar **)&u));
  PetscFunctionReturn(0);
}

static PetscErrorCode FrameCreate(Rod rod) {
  PetscInt choice, points = 2 * (rod->end - rod->first + 2);
  Frame *frame;

  PetscFunctionBegin;
  PetscCall(OptionWord("-rod_order", &choice, NULL));
  PetscCall(PetscNew(&frame));
  rod->order = choice ? 4 : 2;
  UserCheck(rod->order == 4 || rod->scene->clamp != CLAMP_HINGED, rod->scene->comm,
            "-rod_order 2: the first cell of a rod that begins in a hinge needs order 4");
  frame->end_weight = choice ? 1. / 6 : 0;
  frame->mid_weight = choice ? 4. / 6 : 1;
  frame->bow = choice ? 1. / 8 : 0;
  frame->time = PETSC_MIN_REAL;
  Forget(frame);
  frame->duals = rod->scene->load.duals;
  rod->memory = 2 * frame->duals * FrictionDualReals(RUBBING);
  PetscCall(PetscCalloc3(points, &frame->law, points * frame->duals, &frame->dual, points,
                         &frame->point));
  rod->data = frame;
  frame->yields = (PetscBool)(rod->scene->growth->yield > 0);
  if (rod->model->fields > FIELDS)
    PetscCall(LearnedCreate(rod, FIELDS, frame->yields ? YIELD_FIELDS - FIELDS : 0, 1));
  UserCheck(!frame->yields || rod->order == 4, rod->scene->comm,
            "-rod_order 2: -growth_yield needs order 4");
  if (rod->scene->contact.walls.posts) PetscCall(PetscCalloc1(points / 2, &frame->feet));
  if (!rod->scene->contact.self) PetscFunctionReturn(0);
  UserCheck(rod->order == 4, rod->scene->comm, "-rod_order 2: -contact_self needs order 4");
  rod->coupled = PETSC_TRUE;
  PetscCall(StrandRowsCreate(rod, NULL, &frame->strands));
  rod->memory += StrandRowsMemory(frame->strands);
  PetscFunctionReturn(0);
}

static PetscErrorCode FrameDestroy(Rod rod) {
  Frame *frame = (Frame *)rod->data;

  PetscFunctionBegin;
  PetscCall(StrandRowsDestroy(&frame->strands));
  PetscCall(PetscFree3(frame->law, frame->dual, frame->point));
  PetscCall(PetscFree(frame->feet));
  PetscCall(PetscFree(rod->data));
  PetscFunctionReturn(0);
}

/* What the model is, whatever its material learns. */
#define FRAME                                                                                      \
  .name = "frame", .stencil = 1, .halves = {3, 3}, .refuses = RodRefusesSpace,                     \
  .create = FrameCreate, .destroy = FrameDestroy, .set = FrameSet, .get = FrameGet,                \
  .residual = FrameResidual, .hold = FrameHold, .bears = FrameBears,                               \
  .remembered = FrameRemembered, .recalled = FrameRecalled, .defect = FrameDefect,                 \
  .moments = FrameMoments, .jacobian = FrameJacobian, .eliminate = FrameEliminate
#define FIELDS_FOLLOWED PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE
#define FIELDS_GROUPS ALONG, ACROSS_2, ACROSS_2, ACROSS_2, ALONG, ACROSS_2

const RodModel rod_frame = {FRAME, .fields = FIELDS,
                            .field = {"x1", "x2", "theta", "m", "n1", "n2"},
                            .followed = {FIELDS_FOLLOWED}, .group = {FIELDS_GROUPS}};
const RodModel rod_frame_learns = {FRAME, .fields = FIELDS + 2,
                                   .field = {"x1", "x2", "theta", "m", "n1", "n2", "k", "k_mid"},
                                   .followed = {FIELDS_FOLLOWED, PETSC_TRUE, PETSC_TRUE},
                                   .group = {FIELDS_GROUPS, ACROSS_2, ACROSS_2}};
const RodModel rod_frame_remembers = {
    FRAME, .fields = FIELDS + 4,
    .field = {"x1", "x2", "theta", "m", "n1", "n2", "k", "f", "k_mid", "f_mid"},
    .followed = {FIELDS_FOLLOWED, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE},
    .group = {FIELDS_GROUPS, ACROSS_2, ACROSS_2, ACROSS_2, ACROSS_2}};
/* ... whose growth feels force: eliminated, without its V and L, to count modes alone. */
#define YIELDS_FOLLOWED FIELDS_FOLLOWED, PETSC_FALSE, PETSC_TRUE
#define YIELDS_GROUPS FIELDS_GROUPS, ALONG, ALONG
const RodModel rod_frame_yields = {
    FRAME, .fields = YIELD_FIELDS + 2,
    .field = {"x1", "x2", "theta", "m", "n1", "n2", "V", "L", "k", "k_mid"},
    .followed = {YIELDS_FOLLOWED, PETSC_TRUE, PETSC_TRUE},
    .group = {YIELDS_GROUPS, ACROSS_2, ACROSS_2}};
const RodModel rod_frame_yields_remembers = {
    FRAME, .fields = YIELD_FIELDS + 4,
    .field = {"x1", "x2", "theta", "m", "n1", "n2", "V", "L", "k", "f", "k_mid", "f_mid"},
    .followed = {YIELDS_FOLLOWED, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE},
    .group = {YIELDS_GROUPS, ACROSS_2, ACROSS_2, ACROSS_2, ACROSS_2}};
