/* The frame model: first order in s, the constraint built in (theory.md, section 1),
     x' = g q,  theta' = g (m + k0),  m' = -g (q1 n2 - q2 n1),  n' = g phi(|v|) v,  v = x_t + c q,
     s = 0: x = 0, theta = 0 (in the clamp's frame);  s = 1: m = 0, n = 0.
   On a cell of width h between nodes a and b, with y = (x, theta, m, n) and y' = f(y),
     order 4 (Lobatto):   y_b - y_a = h/6 (f_a + 4 f_mid + f_b),
                          y_mid = (y_a + y_b)/2 + h/8 (f_a - f_b), and x_t at mid likewise,
     order 2 (midpoint):  y_b - y_a = h f_mid,  y_mid = (y_a + y_b)/2.
   The rows of node i are the x and theta equations of the cell on its left and the m and n
   equations of the cell on its right: so each diagonal block can be factored without looking
   elsewhere. */
#include "rod/rod.h"
#include "base/options.h"

enum { X1, X2, TH, M, N1, N2, FIELDS };

/* What the laws give at a point. */
typedef struct {
  PetscReal g, g_t, c, k0;
} Law;

typedef struct {
  PetscReal end_weight, mid_weight, bow; /* times h: 1/6, 4/6, 1/8 (order 4); 0, 1, 0 (order 2) */
  PetscReal time;                        /* of the laws below */
  Law *law;                              /* nodes and mids from node first - 1 on, alternating */
  FrictionDual *dual;                    /* likewise */
} Frame;

/* One point of the rod: its unknowns, velocity, f, and the derivatives of f. */
typedef struct {
  PetscReal theta, m, n[2], v[2], q[2], f[FIELDS];
  PetscReal slope[2][2]; /* d(phi v)/dv */
} Point;

static void PointEvaluate(const Friction *friction, const Law *law, const FrictionDual *dual,
                          Point *p) {
  p->f[X1] = law->g * p->q[0];
  p->f[X2] = law->g * p->q[1];
  p->f[TH] = law->g * (p->m + law->k0);
  p->f[M] = -law->g * (p->q[0] * p->n[1] - p->q[1] * p->n[0]);
  FrictionForce(friction, p->v, dual, &p->f[N1]);
  p->f[N1] *= law->g;
  p->f[N2] *= law->g;
}

/* The point at a node; u, u_t its six unknowns and their rates. */
static void PointAtNode(const Friction *friction, const Law *law, const FrictionDual *dual,
                        const PetscReal *u, const PetscReal *u_t, Point *p) {
  p->theta = u[TH];
  p->m = u[M];
  p->q[0] = PetscCosReal(u[TH]);
  p->q[1] = PetscSinReal(u[TH]);
  for (int d = 0; d < 2; d++) {
    p->n[d] = u[N1 + d];
    p->v[d] = u_t[X1 + d] + law->c * p->q[d];
  }
  PointEvaluate(friction, law, dual, p);
}

/* The slope x'_t = g_t q + g theta_t q_perp of the velocity at a node. */
static inline void VelocitySlope(const Law *law, const Point *p, PetscReal theta_t,
                                 PetscReal w[2]) {
  w[0] = law->g_t * p->q[0] - law->g * theta_t * p->q[1];
  w[1] = law->g_t * p->q[1] + law->g * theta_t * p->q[0];
}

/* The point in the middle of a cell between a and b; k = bow h. */
static void PointAtMid(const Friction *friction, const Law law[3], const FrictionDual dual[3],
                       PetscReal k, const Point *a, const Point *b, const PetscReal *ua_t,
                       const PetscReal *ub_t, Point *p) {
  PetscReal wa[2], wb[2];
  VelocitySlope(&law[0], a, ua_t[TH], wa);
  VelocitySlope(&law[2], b, ub_t[TH], wb);
  p->theta = (a->theta + b->theta) / 2 + k * (a->f[TH] - b->f[TH]);
  p->m = (a->m + b->m) / 2 + k * (a->f[M] - b->f[M]);
  p->q[0] = PetscCosReal(p->theta);
  p->q[1] = PetscSinReal(p->theta);
  for (int d = 0; d < 2; d++) {
    p->n[d] = (a->n[d] + b->n[d]) / 2 + k * (a->f[N1 + d] - b->f[N1 + d]);
    p->v[d] = (ua_t[X1 + d] + ub_t[X1 + d]) / 2 + k * (wa[d] - wb[d]) + law[1].c * p->q[d];
  }
  PointEvaluate(friction, &law[1], &dual[1], p);
}

/* The laws at all points of the owned nodes and the cells beside them, at time t. */
static PetscErrorCode LawsAt(Rod rod, PetscReal t) {
  Frame *frame = (Frame *)rod->data;
  const PetscReal *s = rod->scene->mesh.s;
  PetscInt i0 = PetscMax(rod->first - 1, 0), i1 = PetscMin(rod->end, rod->last);

  PetscFunctionBegin;
  if (frame->time == t) PetscFunctionReturn(0);
  for (PetscInt i = i0; i <= i1; i++)
    for (int half = 0; half < 2 && (!half || i < i1); half++) {
      Law *law = &frame->law[2 * (i - rod->first + 1) + half];
      PetscReal z = half ? (s[i] + s[i + 1]) / 2 : s[i];
      PetscCall(GrowthStretch(rod->scene->growth, 1, &z, t, &law->g, &law->g_t, NULL));
      law->c = GrowthSlide(rod->scene->growth, z);
      PetscCall(SceneCurvature(rod->scene, z, t, &law->k0));
    }
  frame->time = t;
  PetscFunctionReturn(0);
}

/* Residual of the six equations of a cell. */
static void CellResidual(const Frame *frame, PetscReal h, const PetscReal *ua, const PetscReal *ub,
                         const Point *a, const Point *mid, const Point *b, PetscReal r[FIELDS]) {
  for (int f = 0; f < FIELDS; f++)
    r[f] = ub[f] - ua[f] -
           h * (frame->end_weight * (a->f[f] + b->f[f]) + frame->mid_weight * mid->f[f]);
}

static PetscErrorCode FrameResidual(Rod rod, PetscReal t, Vec U, Vec U_t, Vec F) {
  Frame *frame = (Frame *)rod->data;
  const Friction *friction = &rod->scene->friction;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS], *s = rod->scene->mesh.s;
  PetscReal(*F_)[FIELDS];
  PetscInt first = rod->first, end = rod->end;
  Vec local[2];
  Point a, b, mid;

  PetscFunctionBegin;
  PetscCall(LawsAt(rod, t));
  PetscCall(RodOpen(rod, U, &local[0], &u));
  PetscCall(RodOpen(rod, U_t, &local[1], &u_t));
  PetscCall(DMDAVecGetArray(rod->da, F, &F_));
  for (PetscInt i = PetscMax(first - 1, 0); i < PetscMin(end, rod->last); i++) {
    const Law *law = &frame->law[2 * (i - first + 1)];
    const FrictionDual *dual = &frame->dual[2 * (i - first + 1)];
    PetscReal h = s[i + 1] - s[i], r[FIELDS];
    if (i == PetscMax(first - 1, 0)) PointAtNode(friction, law, dual, u[i], u_t[i], &b);
    a = b;
    PointAtNode(friction, law + 2, dual + 2, u[i + 1], u_t[i + 1], &b);
    PointAtMid(friction, law, dual, frame->bow * h, &a, &b, u_t[i], u_t[i + 1], &mid);
    CellResidual(frame, h, u[i], u[i + 1], &a, &mid, &b, r);
    if (i >= first) PetscCall(PetscArraycpy(&F_[i][M], &r[M], 3));
    if (i + 1 < end) PetscCall(PetscArraycpy(&F_[i + 1][X1], &r[X1], 3));
  }
  if (first == 0) PetscCall(PetscArraycpy(&F_[0][X1], &u[0][X1], 3));
  if (end == rod->last + 1) PetscCall(PetscArraycpy(&F_[rod->last][M], &u[rod->last][M], 3));
  PetscCall(DMDAVecRestoreArray(rod->da, F, &F_));
  PetscCall(RodClose(rod, &local[0], &u));
  PetscCall(RodClose(rod, &local[1], &u_t));
  PetscFunctionReturn(0);
}

/*
  Adds to J[6][6] the derivative of the cell's equations by the unknowns of one of its nodes.

  sign  -1 for node a (left), +1 for node b
  p     the node's point, mid the cell's
*/
static void CellJacobian(const Frame *frame, PetscReal h, PetscReal sign, PetscReal shift,
                         const Law *law, const Law *mid_law, PetscReal theta_t, const Point *p,
                         const Point *mid, PetscReal J[FIELDS][FIELDS]) {
  const PetscReal g = law->g, k = -sign * frame->bow * h, we = h * frame->end_weight,
                  wm = h * frame->mid_weight;
  const PetscReal perp[2] = {-p->q[1], p->q[0]}, mid_perp[2] = {-mid->q[1], mid->q[0]},
                  gm = mid_law->g;
  const PetscReal turn = g * (p->q[0] * p->n[0] + p->q[1] * p->n[1]); /* d(m')/d(theta) */
  const PetscReal mid_turn = gm * (mid->q[0] * mid->n[0] + mid->q[1] * mid->n[1]);
  PetscReal th[FIELDS] = {0, 0, 0.5, k * g, 0, 0};                                /* d(theta_mid) */
  PetscReal m[FIELDS] = {0, 0, k * turn, 0.5, k * g * p->q[1], -k * g * p->q[0]}; /* d(m_mid) */
  PetscReal fn[2][3], n[2][FIELDS] = {{0}}, v[2][FIELDS] = {{0}}; /* d(n'), d(n_mid), d(v_mid) */

  for (int d = 0; d < 2; d++) {
    PetscReal drag[2] = {g * p->slope[d][0], g * p->slope[d][1]};
    fn[d][X1] = shift * drag[0];
    fn[d][X2] = shift * drag[1];
    fn[d][TH] = law->c * (drag[0] * perp[0] + drag[1] * perp[1]);
    for (int f = X1; f <= TH; f++) n[d][f] = k * fn[d][f];
    n[d][N1 + d] = 0.5;
    v[d][X1 + d] = 0.5 * shift;
    v[d][TH] = k * (law->g_t * perp[d] - g * theta_t * p->q[d] + shift * g * perp[d]);
    for (int f = TH; f <= M; f++) v[d][f] += mid_law->c * mid_perp[d] * th[f];
  }
  for (int f = 0; f < FIELDS; f++) J[f][f] += sign;
  for (int d = 0; d < 2; d++) {
    J[X1 + d][TH] -= we * g * perp[d];
    for (int f = TH; f <= M; f++) J[X1 + d][f] -= wm * gm * mid_perp[d] * th[f];
  }
  J[TH][M] -= we * g;
  for (int f = TH; f < FIELDS; f++) J[TH][f] -= wm * gm * m[f];
  J[M][TH] -= we * turn;
  J[M][N1] -= we * g * p->q[1];
  J[M][N2] += we * g * p->q[0];
  for (int f = 0; f < FIELDS; f++)
    J[M][f] -= wm * (mid_turn * th[f] + gm * (mid->q[1] * n[0][f] - mid->q[0] * n[1][f]));
  for (int d = 0; d < 2; d++) {
    for (int f = X1; f <= TH; f++) J[N1 + d][f] -= we * fn[d][f];
    for (int f = X1; f <= M; f++)
      J[N1 + d][f] -= wm * gm * (mid->slope[d][0] * v[0][f] + mid->slope[d][1] * v[1][f]);
  }
}

/* The slope of the friction force at a point, its dual brought up to the present velocity first. */
static void Linearise(Rod rod, FrictionDual *dual, Point *p) {
  const Friction *friction = &rod->scene->friction;
  if (rod->fresh)
    FrictionDualReset(friction, p->v, dual);
  else
    FrictionDualAdvance(friction, p->v, dual);
  FrictionLinearise(friction, p->v, dual, p->slope);
}

static PetscErrorCode FrameJacobian(Rod rod, PetscReal t, Vec U, Vec U_t, PetscReal shift, Mat J) {
  Frame *frame = (Frame *)rod->data;
  const Friction *friction = &rod->scene->friction;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS], *s = rod->scene->mesh.s;
  PetscInt first = rod->first, end = rod->end;
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS]; /* a cell's rows by node a and by node b */
  PetscReal row[FIELDS][3 * FIELDS]; /* the rows of a node by itself and its neighbours */
  Vec local[2];
  Point a, b, mid;

  PetscFunctionBegin;
  PetscCall(LawsAt(rod, t));
  PetscCall(RodOpen(rod, U, &local[0], &u));
  PetscCall(RodOpen(rod, U_t, &local[1], &u_t));
  PetscCall(PetscMemzero(row, sizeof(row)));
  if (first == 0)
    for (int f = X1; f <= TH; f++) row[f][FIELDS + f] = 1;
  for (PetscInt i = PetscMax(first - 1, 0); i < end; i++) {
    const Law *law = &frame->law[2 * (i - first + 1)];
    FrictionDual *dual = &frame->dual[2 * (i - first + 1)];
    PetscInt cols[3] = {i - 1, i, i < rod->last ? i + 1 : -1}; /* -1: none, ignored */
    if (i < rod->last) {
      PetscReal h = s[i + 1] - s[i];
      if (i == PetscMax(first - 1, 0)) {
        PointAtNode(friction, law, dual, u[i], u_t[i], &b);
        Linearise(rod, dual, &b);
      }
      a = b;
      PointAtNode(friction, law + 2, dual + 2, u[i + 1], u_t[i + 1], &b);
      Linearise(rod, dual + 2, &b);
      PointAtMid(friction, law, dual, frame->bow * h, &a, &b, u_t[i], u_t[i + 1], &mid);
      Linearise(rod, dual + 1, &mid);
      PetscCall(PetscMemzero(left, sizeof(left)));
      PetscCall(PetscMemzero(right, sizeof(right)));
      CellJacobian(frame, h, -1, shift, law, law + 1, u_t[i][TH], &a, &mid, left);
      CellJacobian(frame, h, 1, shift, law + 2, law + 1, u_t[i + 1][TH], &b, &mid, right);
      for (int f = M; f <= N2; f++)
        for (int k = 0; k < FIELDS; k++) {
          row[f][FIELDS + k] = left[f][k];
          row[f][2 * FIELDS + k] = right[f][k];
        }
    } else
      for (int f = M; f <= N2; f++) row[f][FIELDS + f] = 1;
    if (i >= first) PetscCall(MatSetValuesBlocked(J, 1, &i, 3, cols, &row[0][0], INSERT_VALUES));
    PetscCall(PetscMemzero(row, sizeof(row)));
    if (i < rod->last)
      for (int f = X1; f <= TH; f++)
        for (int k = 0; k < FIELDS; k++) {
          row[f][k] = left[f][k];
          row[f][FIELDS + k] = right[f][k];
        }
  }
  PetscCall(RodClose(rod, &local[0], &u));
  PetscCall(RodClose(rod, &local[1], &u_t));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* Moves the shifts of exact Coulomb friction; change is the largest of a force. */
static PetscErrorCode FrameHold(Rod rod, PetscReal t, Vec U, Vec U_t, PetscReal *change) {
  Frame *frame = (Frame *)rod->data;
  const Friction *friction = &rod->scene->friction;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS], *s = rod->scene->mesh.s;
  PetscInt first = PetscMax(rod->first - 1, 0);
  Vec local[2];
  Point a, b, mid;

  PetscFunctionBegin;
  *change = 0;
  PetscCall(LawsAt(rod, t));
  PetscCall(RodOpen(rod, U, &local[0], &u));
  PetscCall(RodOpen(rod, U_t, &local[1], &u_t));
  for (PetscInt i = first; i <= PetscMin(rod->end, rod->last); i++) {
    const Law *law = &frame->law[2 * (i - rod->first + 1)];
    FrictionDual *dual = &frame->dual[2 * (i - rod->first + 1)];
    a = b;
    PointAtNode(friction, law, dual, u[i], u_t[i], &b);
    if (i > first) {
      PointAtMid(friction, law - 2, dual - 2, frame->bow * (s[i] - s[i - 1]), &a, &b, u_t[i - 1],
                 u_t[i], &mid);
      *change = PetscMax(*change, FrictionDualHold(friction, mid.v, dual - 1));
    }
    if (frame->end_weight > 0) *change = PetscMax(*change, FrictionDualHold(friction, b.v, dual));
  }
  PetscCall(RodClose(rod, &local[0], &u));
  PetscCall(RodClose(rod, &local[1], &u_t));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, change, 1, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD));
  PetscFunctionReturn(0);
}

static PetscErrorCode FrameSet(Rod rod, PetscReal t, const Node *nodes, Vec U) {
  PetscReal(*u)[FIELDS];

  PetscFunctionBegin;
  PetscCall(DMDAVecGetArray(rod->da, U, &u));
  for (PetscInt i = rod->first; i < rod->end; i++)
    PetscCall(PetscMemcpy(u[i], &nodes[i - rod->first], sizeof(u[i])));
  PetscCall(DMDAVecRestoreArray(rod->da, U, &u));
  PetscFunctionReturn(0);
}

static PetscErrorCode FrameGet(Rod rod, PetscReal t, Vec U, Vec U_t, Node *nodes) {
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS];

  PetscFunctionBegin;
  PetscCall(DMDAVecGetArrayRead(rod->da, U, &u));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    Node *node = &nodes[i - rod->first];
    PetscCall(PetscMemzero(node, sizeof(*node)));
    PetscCall(PetscMemcpy(node, u[i], sizeof(u[i])));
  }
  PetscCall(DMDAVecRestoreArrayRead(rod->da, U, &u));
  if (!U_t) PetscFunctionReturn(0);
  PetscCall(DMDAVecGetArrayRead(rod->da, U_t, &u_t));
  for (PetscInt i = rod->first; i < rod->end; i++)
    PetscCall(PetscMemcpy(nodes[i - rod->first].x_t, u_t[i], 3 * sizeof(PetscReal)));
  PetscCall(DMDAVecRestoreArrayRead(rod->da, U_t, &u_t));
  PetscFunctionReturn(0);
}

static PetscErrorCode FrameCreate(Rod rod) {
  const char *const orders[] = {"2", "4"};
  PetscInt choice = 1, points = 2 * (rod->end - rod->first + 2);
  Frame *frame;

  PetscFunctionBegin;
  PetscCall(
      OptionList("-rod_order", "order in space of the frame model", 2, orders, &choice, NULL));
  PetscCall(PetscNew(&frame));
  rod->order = choice ? 4 : 2;
  frame->end_weight = choice ? 1. / 6 : 0;
  frame->mid_weight = choice ? 4. / 6 : 1;
  frame->bow = choice ? 1. / 8 : 0;
  frame->time = PETSC_MIN_REAL;
  PetscCall(PetscCalloc2(points, &frame->law, points, &frame->dual));
  rod->data = frame;
  PetscFunctionReturn(0);
}

static PetscErrorCode FrameDestroy(Rod rod) {
  Frame *frame = (Frame *)rod->data;

  PetscFunctionBegin;
  PetscCall(PetscFree2(frame->law, frame->dual));
  PetscCall(PetscFree(rod->data));
  PetscFunctionReturn(0);
}

const RodModel rod_frame = {
    .name = "frame",
    .fields = FIELDS,
    .stencil = 1,
    .field = {"x1", "x2", "theta", "m", "n1", "n2"},
    .followed = {PETSC_TRUE, PETSC_TRUE, PETSC_TRUE},
    .across = {PETSC_FALSE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_FALSE, PETSC_TRUE},
    .create = FrameCreate,
    .destroy = FrameDestroy,
    .set = FrameSet,
    .get = FrameGet,
    .residual = FrameResidual,
    .hold = FrameHold,
    .jacobian = FrameJacobian};
