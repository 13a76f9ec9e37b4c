#include "rod/space_cells.h"
#include "curve/cell.h"
#include "rod/rules.h"
#include <string.h>

static void PointAtNode(const Cell *cell, const Law *law, const FrictionDual *dual,
                        const PetscReal *u, const PetscReal *u_t, Point *p) {
  memcpy(p->p, u + P, sizeof(p->p));
  memcpy(p->m, u + M, sizeof(p->m));
  memcpy(p->n, u + N, sizeof(p->n));
  memcpy(p->p_t, u_t + P, sizeof(p->p_t));
  memcpy(p->m_t, u_t + M, sizeof(p->m_t));
  PointStrains(cell->load, law, p);
  DirectorRate(p);
  for (int i = 0; i < 3; i++) {
    p->at.x[i] = u[X + i];
    p->at.v[i] = u_t[X + i] + law->c * p->at.axes[0][i];
  }
  PointEvaluate(cell->load, law, dual, p);
}

/* The point in the middle of the cell; k = bow h. */
static void PointAtMid(Cell *cell, PetscReal k, const PetscReal *ua_t, const PetscReal *ub_t) {
  const Load *load = cell->load;
  const Point *a = cell->a, *b = cell->b;
  Point *p = cell->mid;
  PetscReal wa[3], wb[3];

  VelocitySlope(&cell->law[AT_A], a, wa);
  VelocitySlope(&cell->law[AT_B], b, wb);
  for (int i = 0; i < 4; i++) {
    p->p[i] = CurveMid(k, a->p[i], a->f[P + i], b->p[i], b->f[P + i]);
    p->p_t[i] = (ua_t[P + i] + ub_t[P + i]) / 2;
  }
  for (int i = 0; i < 3; i++) {
    p->m[i] = CurveMid(k, a->m[i], a->f[M + i], b->m[i], b->f[M + i]);
    p->n[i] = CurveMid(k, a->n[i], a->f[N + i], b->n[i], b->f[N + i]);
    p->at.x[i] = CurveMid(k, a->at.x[i], a->f[X + i], b->at.x[i], b->f[X + i]);
  }
  for (int i = 0; i < 3 && cell->split; i++)
    p->m[i] += SplitBow(cell) * (a->couple[i] - b->couple[i]);
  for (int i = 0; i < 3 && cell->feet.n; i++) {
    p->n[i] += k * (cell->foot_load[AT_A][i] - cell->foot_load[AT_B][i]);
    p->m[i] += k * (cell->foot_load[AT_A][3 + i] - cell->foot_load[AT_B][3 + i]);
  }
  PointStrains(load, &cell->law[AT_MID], p);
  if (cell->cubic)
    p->at.v[SPIN] =
        load->arm *
        (CurveMid(k, QuaternionSpin(a->p, a->size, a->p_t), NodeSpinSlope(&cell->law[AT_A], a),
                  QuaternionSpin(b->p, b->size, b->p_t), NodeSpinSlope(&cell->law[AT_B], b)) +
         cell->law[AT_MID].c * p->u[0]);
  for (int i = 0; i < 3; i++)
    p->at.v[i] = CurveMid(k, ua_t[X + i], wa[i], ub_t[X + i], wb[i]) +
                 cell->law[AT_MID].c * p->at.axes[0][i];
  PointEvaluate(load, &cell->law[AT_MID], cell->dual[AT_MID], p);
  for (int i = 0; i < 3 && cell->split; i++)
    p->f[M + i] += (a->couple[i] + b->couple[i]) / 2 - p->couple[i];
  for (int i = 0; i < 3 && cell->feet.n; i++) {
    p->f[N + i] += cell->foot_load[AT_MID][i];
    p->f[M + i] += cell->foot_load[AT_MID][3 + i];
  }
}

/* The laws at all points of the owned nodes and the cells beside them, at time t. */
static PetscErrorCode LawsAt(Rod rod, PetscReal t) {
  Space_ *self = (Space_ *)rod->data;
  Scene scene = rod->scene;
  const PetscReal *s = scene->mesh.s;
  PetscInt i0 = PetscMax(rod->first - 1, 0), i1 = PetscMin(rod->end, rod->last);

  PetscFunctionBegin;
  if (self->time == t) PetscFunctionReturn(0);
  for (PetscInt i = i0; i <= i1; i++)
    for (int half = 0; half < 2 && (!half || i < i1); half++) {
      const PetscInt k = 2 * (i - rod->first + 1) + half;
      Law *law = &self->law[k];
      PetscReal B, S[3];
      law->s = half ? (s[i] + s[i + 1]) / 2 : s[i];
      PetscCall(ScenePlace(scene, law->s, t, &self->point[k].at));
      PetscCall(GrowthStretch(scene->growth, 1, &law->s, t, &law->g, &law->g_t, NULL));
      law->c = GrowthSlide(scene->growth, law->s, t);
      PetscCall(SceneStiffness(scene, law->s, t, &B, NULL));
      SceneStiffnesses(scene, B, S);
      for (int k = 0; k < 3; k++) law->flex[k] = 1 / S[k];
      PetscCall(CurvatureStrains(&scene->curvature, scene->growth, law->s, t, law->u0, NULL));
      if (scene->load.radius > 0) PetscCall(SceneTwistRate(scene, law->s, t, &law->twist));
    }
  self->time = t;
  if (rod->learned) SpaceLearnedLaws(rod, t);
  PetscFunctionReturn(0);
}

/* Adds to n' and m' what strands that touch do at node i, or behind it. */
static inline void AddPush(const Cell *cell, PetscInt i, int half, Point *p) {
  for (int d = 0; d < 3 && cell->push; d++) p->f[N + d] += cell->push[2 * i + half][d];
  for (int d = 0; d < 3 && cell->couple; d++) p->f[M + d] += cell->couple[2 * i + half][d];
}

/* The cell that is looked at, for its feet. */
static void FeetsCell(Cell *cell, PetscInt i) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const PetscReal arm = cell->load->arm;
  FootCell *of = &cell->foot_cell;
  CurveCell *curve = &of->curve;

  *of = (FootCell){.dims = 3, .curve = {.h = cell->h}, .moves = PETSC_TRUE};
  of->first = (PetscBool)(i == 0);
  of->last = (PetscBool)(i == cell->rod->last - 1);
  for (int k = 0; k < FOOT_PARTS; k++) {
    curve->c[k] = cell->law[k].c;
    of->weight[k] = k == 1 ? self->mid_weight : self->end_weight;
  }
  for (int e = 0; e < 2; e++) {
    const Point *p = e ? cell->b : cell->a;
    curve->g[e] = cell->law[2 * e].g;
    VelocitySlope(&cell->law[2 * e], p, curve->slope_t[e]);
    if (arm > 0) of->spin[e] = p->at.v[SPIN] / arm;
    for (int d = 0; d < 3; d++) {
      curve->x[e][d] = p->at.x[d];
      curve->q[e][d] = p->at.axes[0][d];
      curve->x_t[e][d] = p->at.v[d] - cell->law[2 * e].c * p->at.axes[0][d];
    }
  }
}

/* The feet of the cell behind node i, and what they add to its points. */
static void FindFeet(Cell *cell, PetscInt i) {
  const Contact *contact = &cell->rod->scene->contact;

  FeetsCell(cell, i);
  FeetFind(contact, &cell->foot_cell, contact->smooth, &cell->feet);
  if (!cell->feet.n) return;
  memset(cell->foot_load, 0, sizeof(cell->foot_load));
  FeetPush(contact, &cell->foot_cell, FeetHeldAt(cell, i), &cell->feet);
  FeetHandOut(&cell->foot_cell, &cell->feet, cell->foot_load);
}

/* The point at node i. */
static Point *NodePoint(Cell *cell, PetscInt i) {
  Space_ *self = (Space_ *)cell->rod->data;
  PetscInt k = 2 * (i - cell->rod->first + 1);
  Point *p = self->point + k;
  PetscReal still[FIELDS];

  if (cell->known) return p;
  PointAtNode(cell, self->law + k, Duals(self, k), cell->u[i],
              SpaceStill(cell, i, cell->u_t[i], still), p);
  AddPush(cell, i, 0, p);
  return p;
}

/* SpaceCellsForget - forgets the points: what they depend on besides the state has changed, the
   shifts of the duals. */
void SpaceCellsForget(Space_ *self) {
  RodForget(&self->seen);
}

/* Are the points known in a state? What kinds of cells there are, and which strands touch, depends
   on what it is asked for; feet are not kept. */
static PetscErrorCode Recognise(Space_ *self, const RodState *at, Cell *cell) {
  PetscFunctionBegin;
  PetscCall(RodRecognise(at, &self->seen, &cell->known));
  if (cell->thin || at->counts != self->counts) cell->known = PETSC_FALSE;
  if ((at->fresh || at->iterates) && (at->fresh != self->fresh || at->iterates != self->iterates))
    cell->known = PETSC_FALSE;
  self->fresh = at->fresh;
  self->iterates = at->iterates;
  self->counts = at->counts;
  PetscFunctionReturn(0);
}

/* SpaceCellsOpen - begins a walk at the first of the cells that touch owned nodes. Collective. */
PetscErrorCode SpaceCellsOpen(Rod rod, const RodState *at, Cell *cell) {
  Space_ *self = (Space_ *)rod->data;

  PetscFunctionBegin;
  if (self->yields) {
    self->time = PETSC_MIN_REAL; /* laws are those of the state */
    PetscCall(SpaceYieldSee(rod, at->t, at->U));
  }
  PetscCall(LawsAt(rod, at->t));
  PetscCall(SceneContactAt(rod->scene, at->t));
  cell->rod = rod;
  cell->t = at->t;
  cell->fresh = at->fresh;
  cell->iterates = at->iterates;
  cell->counts = at->counts;
  cell->cubics = cell->cubic = SpinCubic(rod, at);
  cell->split = PETSC_FALSE;
  cell->thin = rod->scene->contact.thin;
  cell->feet.n = 0;
  cell->load = &rod->scene->load;
  cell->push = rod->pushed.force;
  cell->couple = rod->pushed.couple;
  if (self->strands) PetscCall(StrandRowsLoad(rod, self->strands, at, &cell->push, &cell->couple));
  cell->s = rod->scene->mesh.s;
  if (rod->learned) {
    PetscCall(SpaceLearnedOpen(rod, at));
    if (self->yields) SpaceYieldLaws(rod);
    cell->u = (const PetscReal(*)[FIELDS])rod->learned->u + 1 - rod->first;
    cell->u_t = (const PetscReal(*)[FIELDS])rod->learned->u_t + 1 - rod->first;
  } else {
    PetscCall(RodOpen(rod, at->U, &cell->local, &cell->u));
    PetscCall(RodOpen(rod, at->U_t, &cell->local_t, &cell->u_t));
  }
  PetscCall(Recognise(self, at, cell));
  cell->b = NodePoint(cell, PetscMax(rod->first - 1, 0));
  PetscFunctionReturn(0);
}

/* SpaceCellsClose - ends a walk. Collective. */
PetscErrorCode SpaceCellsClose(Cell *cell) {
  PetscFunctionBegin;
  if (cell->rod->learned) PetscFunctionReturn(0);
  PetscCall(RodClose(cell->rod, &cell->local, &cell->u));
  PetscCall(RodClose(cell->rod, &cell->local_t, &cell->u_t));
  PetscFunctionReturn(0);
}

/*
  Splits - is there a place in the cell at which the rod stops turning, or turns the other way,
  while it moves little besides? There the couple of friction jumps, and what rests behind it may be
  held by all that friction can. So it must not feel what slides: the couple in the middle of the
  cell would be that of the end that slides, and what it should bear is borne by the one that rests,
  which gives way. Such a cell has couples at its ends alone, each of its own spin, half of the
  cell's each,

    m_b - m_a = ... + h/2 (c_a + c_b),   m between them:  m_a + h/2 c_a,

  which is of order 2 whatever the place. What slides all along is left to Simpson's rule, and where
  beta spreads the jump over cells all is (self->split is NULL). A cell that was split once in a
  Newton solve stays so in it.
*/
static PetscBool Splits(const Cell *cell, PetscInt i) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const Friction *law = &cell->load->friction;
  const PetscReal *a = cell->a->at.v, *b = cell->b->at.v, *fast = b,
                  beta = law->beta > 0 ? law->beta : friction_tiny;
  PetscBool *split = &self->split[i + 1 - cell->rod->first];
  PetscReal aa, bb;

  if (cell->known || (!cell->fresh && !cell->iterates)) return *split;
  if (cell->fresh) *split = PETSC_FALSE;
  aa = Dot3(a, a) + a[SPIN] * a[SPIN] + beta;
  bb = Dot3(b, b) + b[SPIN] * b[SPIN] + beta;
  if (aa > bb) fast = a;
  if (PetscMax(aa, bb) > rod_rule.split_resolved * beta &&
      Dot3(fast, fast) < rod_rule.split_less * fast[SPIN] * fast[SPIN] &&
      (a[SPIN] * b[SPIN] < 0 || aa < rod_rule.split_less * bb || bb < rod_rule.split_less * aa))
    *split = PETSC_TRUE;
  return *split;
}

/* SpaceCellsNext - goes on to the cell between nodes i and i + 1. */
void SpaceCellsNext(Cell *cell, PetscInt i) {
  Space_ *self = (Space_ *)cell->rod->data;
  PetscInt k = 2 * (i - cell->rod->first + 1);
  PetscReal still[FIELDS];

  cell->law = self->law + k;
  for (int e = 0; e < 3; e++) cell->dual[e] = Duals(self, k + e);
  cell->h = cell->s[i + 1] - cell->s[i];
  cell->a = cell->b;
  cell->b = NodePoint(cell, i + 1);
  cell->mid = self->point + k + 1;
  if (self->split) {
    cell->split = Splits(cell, i);
    cell->cubic = (PetscBool)(cell->cubics && !cell->split);
  }
  if (cell->known) return;
  if (cell->thin) FindFeet(cell, i);
  PointAtMid(cell, self->bow * cell->h, cell->u_t[i],
             SpaceStill(cell, i + 1, cell->u_t[i + 1], still));
  AddPush(cell, i, 1, cell->mid);
}
