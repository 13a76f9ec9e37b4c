/* The laws and the state at the points of a cell of the frame model, and the walk along the cells
   (frame.c has the equations). */
#include "rod/frame_cells.h"
#include "curve/cell.h"
#include <string.h>

/* The point at a node; u, u_t its six unknowns and their rates. */
static inline void PointAtNode(const Load *load, const Law *law, const FrictionDual *dual,
                               const PetscReal *u, const PetscReal *u_t, Point *p) {
  const Vector2 q = Direction2(u[TH]);

  p->theta = u[TH];
  p->m = u[M];
  Put2(From2(u + N1), p->n);
  Put2(From2(u + X1), p->at.x);
  PlaceTurn2(q, &p->at);
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
  PlaceTurn2(q, &p->at);
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
      const PetscInt k = 2 * (i - rod->first + 1) + half;
      Law *law = &frame->law[k];
      PetscReal B;
      law->s = half ? (s[i] + s[i + 1]) / 2 : s[i];
      PetscCall(ScenePlace(scene, law->s, t, &frame->point[k].at));
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
void FrameCellsForget(Frame *frame) {
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
    Put2(From2(p->at.axes[0]), curve->q[e]);
  }
}

/* The feet of the cell, and what they push with; returns how many. */
PetscInt FrameCellsFeet(const Cell *cell, PetscInt i, FootCell *of, Feet *feet) {
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
  if (!FrameCellsFeet(cell, i, &of, &feet)) return;
  FeetHandOut(&of, &feet, load);
  Add2(Times2(frame->bow * cell->h, Minus2(From2(load[AT_A]), From2(load[AT_B]))), mid->n);
  Add2(From2(load[AT_MID]), mid->f + N1);
  mid->f[M] = -cell->law[AT_MID].g * Cross2(From2(mid->at.axes[0]), From2(mid->n));
}

/* The point at node i. */
static Point *CellsNode(Cell *cell, PetscInt i) {
  Frame *frame = (Frame *)cell->rod->data;
  PetscInt k = 2 * (i - cell->rod->first + 1);
  Point *p = frame->point + k;
  PetscReal still[FIELDS];

  if (cell->known) return p;
  PointAtNode(cell->load, frame->law + k, FrameDuals(frame, k), cell->u[i],
              Still(cell, i, cell->u_t[i], still), p);
  AddPush(cell, i, 0, p);
  return p;
}

/* Begins a walk along the cells that touch owned nodes, at the first of these or, on the last rank,
   at the tip. Collective. */
PetscErrorCode FrameCellsOpen(Rod rod, const RodState *at, PetscBool from_tip, Cell *cell) {
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

PetscErrorCode FrameCellsClose(Cell *cell) {
  PetscFunctionBegin;
  if (cell->rod->learned) PetscFunctionReturn(0);
  PetscCall(RodClose(cell->rod, &cell->local, &cell->u));
  PetscCall(RodClose(cell->rod, &cell->local_t, &cell->u_t));
  PetscFunctionReturn(0);
}

/* Goes on to the cell between nodes i and i + 1, of which the node nearer to where the walk began
   is known. */
void FrameCellsGo(Cell *cell, PetscInt i, PetscBool from_tip) {
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
  PointAtMid(cell->load, cell->law, cell->dual[AT_MID], frame->bow * cell->h, cell->a, cell->b,
             cell->u_t[i], Still(cell, i + 1, cell->u_t[i + 1], still), cell->mid);
  AddPush(cell, i, 1, cell->mid);
  if (frame->feet) AddFeet(cell, i);
}
