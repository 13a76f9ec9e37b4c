/* The linear model: a small deflection y = x2 of the straight rod, D y_t = K y in cubic B-splines
   (straight.h), one unknown per node. Terms of relative size theta^2 are left out. In space x3 is
   another such deflection: two unknowns per node, which do not see each other. */
#include "base/chain.h"
#include "rod/directors.h"
#include "rod/rod.h"
#include <petscksp.h>

enum { WAYS = 2 };

typedef struct {
  Straight straight[WAYS];      /* of x2 and x3; one for both if they are alike */
  PetscReal *K[WAYS], *D[WAYS]; /* owned rows, at time */
  PetscReal time;
  PetscReal *room[WAYS + 1]; /* in space, for a field by itself: owned nodes and three beyond */
  PetscReal *basis;          /* [N + 1][3][BASIS]: B, B', B'' at the nodes */
  KSP fit;                   /* spline coefficients from the values at the nodes */
} Linear;

static PetscErrorCode BandsAt(Rod rod, PetscReal t) {
  Linear *self = (Linear *)rod->data;

  PetscFunctionBegin;
  if (self->time == t) PetscFunctionReturn(0);
  for (PetscInt f = 0; f < rod->model->fields; f++)
    if (!f || self->straight[f] != self->straight[0])
      PetscCall(StraightBands(self->straight[f], t, rod->first, rod->end, self->K[f], self->D[f]));
  self->time = t;
  PetscFunctionReturn(0);
}

/* One field of a vector opened by RodOpen(), indexed by node: itself if it is the only one, else
   copied into room k. */
static const PetscScalar *OneField(Rod rod, const PetscScalar *v, PetscInt f, int k) {
  const PetscInt fields = rod->model->fields, from = rod->first - 3;
  PetscReal *room = ((Linear *)rod->data)->room[k];

  if (fields == 1) return v;
  for (PetscInt i = PetscMax(from, 0); i < PetscMin(rod->end + 3, rod->last + 1); i++)
    room[i - from] = v[fields * i + f];
  return room - from;
}

/* F = D y_t - K y */
static PetscErrorCode LinearResidual(Rod rod, const RodState *at, Vec F) {
  Linear *self = (Linear *)rod->data;
  const PetscScalar *y, *y_t;
  PetscScalar *f;
  Vec local, local_t;

  PetscFunctionBegin;
  PetscCall(RodOpen(rod, at->U, &local, &y));
  PetscCall(RodOpen(rod, at->U_t, &local_t, &y_t));
  PetscCall(DMDAVecGetArray(rod->da, F, &f));
  for (PetscInt k = 0; k < rod->model->fields; k++) {
    PetscReal *out = rod->model->fields > 1 ? self->room[WAYS] - (rod->first - 3) : f;
    PetscCall(StraightApply(self->straight[k], at->t, rod->first, rod->end, OneField(rod, y, k, 0),
                            OneField(rod, y_t, k, 1), out));
    for (PetscInt i = rod->first; out != f && i < rod->end; i++)
      f[rod->model->fields * i + k] = out[i];
  }
  PetscCall(DMDAVecRestoreArray(rod->da, F, &f));
  PetscCall(RodClose(rod, &local, &y));
  PetscCall(RodClose(rod, &local_t, &y_t));
  PetscFunctionReturn(0);
}

/* J = shift D - K */
static PetscErrorCode LinearJacobian(Rod rod, const RodState *at, Mat J) {
  const PetscInt fields = rod->model->fields;
  Linear *self = (Linear *)rod->data;

  PetscFunctionBegin;
  PetscCall(BandsAt(rod, at->t));
  for (PetscInt k = 0; k < fields * (rod->end - rod->first); k++) {
    PetscInt i = rod->first + k / fields, f = k % fields, own = fields * i + f, cols[BAND];
    PetscScalar row[BAND];
    for (PetscInt b = 0; b < BAND; b++) {
      PetscInt j = i + b - 3, entry = (i - rod->first) * BAND + b;
      cols[b] = j >= 0 && j <= rod->last ? fields * j + f : -1;
      row[b] = at->shift[f] * self->D[f][entry] - self->K[f][entry];
    }
    PetscCall(MatSetValues(J, 1, &own, BAND, cols, row, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* The derivatives 0 to 2 of y by s at node i. */
static void Evaluate(Rod rod, const PetscScalar *y, PetscInt i, PetscReal d[3]) {
  Linear *self = (Linear *)rod->data;
  PetscInt cell = PetscMin(i, rod->last - 1);
  const PetscReal(*B)[BASIS] = (const PetscReal(*)[BASIS])(self->basis + i * 3 * BASIS);

  for (int k = 0; k < 3; k++) {
    d[k] = 0;
    for (PetscInt b = PetscMax(0, 2 - cell); b < BASIS; b++)
      if (cell - 2 + b >= i - 3) d[k] += B[k][b] * y[cell - 2 + b];
  }
}

/* B for a deflection of one way. */
static PetscErrorCode StiffnessOf(Rod rod, PetscReal t, StraightWay way, PetscInt i, PetscReal *B) {
  PetscFunctionBegin;
  PetscCall(SceneStiffness(rod->scene, rod->scene->mesh.s[i], t, B, NULL));
  *B *= StraightRatio(rod->scene, way);
  PetscFunctionReturn(0);
}

/* The moment m = B (y'/g)'/g at node i. */
static PetscErrorCode Moment(Rod rod, PetscReal t, StraightWay way, const PetscScalar *y,
                             PetscInt i, PetscReal *m) {
  PetscReal d[3], g, g_s, B;

  PetscFunctionBegin;
  Evaluate(rod, y, i, d);
  PetscCall(GrowthStretch(rod->scene->growth, 1, &rod->scene->mesh.s[i], t, &g, NULL, &g_s));
  PetscCall(StiffnessOf(rod, t, way, i, &B));
  *m = B * (d[2] / g - d[1] * g_s / (g * g)) / g;
  PetscFunctionReturn(0);
}

/* y'''' at an inner node, by differences of the spline's y''. */
static PetscReal FourthDerivative(Rod rod, const PetscScalar *y, PetscInt i) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscReal d[3][3], a = s[i] - s[i - 1], b = s[i + 1] - s[i];

  for (int k = 0; k < 3; k++) Evaluate(rod, y, i - 1 + k, d[k]);
  return 2 * ((d[2][2] - d[1][2]) / b - (d[1][2] - d[0][2]) / a) / (a + b);
}

/* The spline's y'' at a node lags by (a^3 + b^3) / (12 (a + b)) y'''', a and b the cells beside it;
   with that put right the moment is of fourth order too. */
static PetscErrorCode BetterMoment(Rod rod, PetscReal t, StraightWay way, const PetscScalar *y,
                                   PetscInt i, PetscReal *m) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscInt mid = PetscMax(i, 1);
  PetscReal a, b, bend, g, B;

  PetscFunctionBegin;
  *m = 0;
  if (i == rod->last) PetscFunctionReturn(0);
  PetscCall(Moment(rod, t, way, y, i, m));
  a = s[mid] - s[mid - 1];
  b = s[mid + 1] - s[mid];
  bend = FourthDerivative(rod, y, mid);
  if (!i) bend += a / b * (bend - FourthDerivative(rod, y, 2)); /* on to the clamp */
  PetscCall(GrowthStretch(rod->scene->growth, 1, &s[i], t, &g, NULL, NULL));
  PetscCall(StiffnessOf(rod, t, way, i, &B));
  *m += B * (a * a * a + b * b * b) / (12 * (a + b)) * bend / (g * g);
  PetscFunctionReturn(0);
}

/* n2 = theta n1 - m'/g, m' that of the parabola through the moments at three nodes; at the tip what
   pushes there. */
static PetscErrorCode ShearForce(Rod rod, PetscReal t, StraightWay way, const PetscScalar *y,
                                 PetscInt i, PetscReal g, Node *node) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscInt mid = PetscMax(i, 1);
  PetscReal m[3], left, right, a, b;

  PetscFunctionBegin;
  if (i == rod->last) {
    PetscReal press, turns, drags;
    PetscCall(StraightTip(rod->scene, t, &press, &turns, &drags));
    node->force[1] = -turns * node->theta - drags * node->x_t[1];
    PetscFunctionReturn(0);
  }
  for (int k = 0; k < 3; k++) PetscCall(Moment(rod, t, way, y, mid - 1 + k, &m[k]));
  a = s[mid] - s[mid - 1];
  b = s[mid + 1] - s[mid];
  left = (m[1] - m[0]) / a; /* the slopes in the middles of the cells */
  right = (m[2] - m[1]) / b;
  node->force[1] =
      node->theta * node->force[0] - (left + (right - left) * (i ? a : -a) / (a + b)) / g;
  PetscFunctionReturn(0);
}

/* x1 = p - 1/2 int theta^2 g ds, to the order of the model: takes off what one ghosted deflection y
   adds to the integral. */
static PetscErrorCode AxialPosition(Rod rod, PetscReal t, const PetscScalar *y, Node *nodes) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscReal *shortened, before = 0, d[3], g;
  PetscInt n = rod->end - rod->first;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n, &shortened));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < rod->end; i++) {
    PetscReal square; /* theta^2 g / 2 */
    PetscCall(GrowthStretch(rod->scene->growth, 1, &s[i], t, &g, NULL, NULL));
    Evaluate(rod, y, i, d);
    square = d[1] * d[1] / g / 2;
    if (i && i >= rod->first) shortened[i - rod->first] = (s[i] - s[i - 1]) * (before + square) / 2;
    before = square;
  }
  PetscCall(RodSumAlong(rod, n, shortened));
  for (PetscInt k = 0; k < n; k++) nodes[k].x[0] -= shortened[k];
  PetscCall(PetscFree(shortened));
  PetscFunctionReturn(0);
}

/* The rod that deflects in one way, as one in a plane; but for the shortening of x1. y_t may be
   NULL. */
static PetscErrorCode PlaneNodes(Rod rod, PetscReal t, StraightWay way, const PetscReal P[],
                                 const PetscScalar *y, const PetscScalar *y_t, Node *nodes) {
  const PetscReal *s = rod->scene->mesh.s;

  PetscFunctionBegin;
  for (PetscInt i = rod->first; i < rod->end; i++) {
    Node *node = &nodes[i - rod->first];
    PetscReal d[3], g, g_t;
    PetscCall(PetscMemzero(node, sizeof(*node)));
    PetscCall(GrowthStretch(rod->scene->growth, 1, &s[i], t, &g, &g_t, NULL));
    PetscCall(GrowthArc(rod->scene->growth, 1, &s[i], t, &node->x[0], &node->x_t[0]));
    Evaluate(rod, y, i, d);
    node->x[1] = d[0];
    node->theta = d[1] / g;
    node->force[0] = -P[i];
    if (y_t) {
      Evaluate(rod, y_t, i, d);
      node->x_t[1] = d[0];
      node->theta_t = (d[1] - node->theta * g_t) / g;
    }
    PetscCall(BetterMoment(rod, t, way, y, i, &node->moment));
    PetscCall(ShearForce(rod, t, way, y, i, g, node));
  }
  PetscFunctionReturn(0);
}

/* A node in space from those of the two ways, whose angles are the tangent's parts across: its
   directors are turned by the smallest rotation from the clamp's, for there is no twist. The moment
   is e1 x (B theta'), and none about the tangent. */
static void JoinWays(const Node *one, const Node *other, Node *node) {
  const PetscReal a = one->theta, b = other->theta, a_t = one->theta_t, b_t = other->theta_t;
  const PetscReal c = PetscSqrtReal(PetscMax(1e-6, 1 - a * a - b * b)),
                  c_t = -(a * a_t + b * b_t) / c, p = PetscSqrtReal((1 + c) / 2),
                  p_t = c_t / (4 * p);
  Node joined = {.x = {one->x[0], one->x[1], other->x[1]},
                 .x_t = {one->x_t[0], one->x_t[1], other->x_t[1]},
                 .force = {one->force[0], one->force[1], other->force[1]},
                 .m3 = {0, -other->moment, one->moment},
                 .p = {p, 0, -b / (2 * p), a / (2 * p)},
                 .p_t = {p_t, 0, (b * p_t / p - b_t) / (2 * p), (a_t - a * p_t / p) / (2 * p)}};

  joined.m3[0] = -(joined.m3[1] * a + joined.m3[2] * b) / c;
  RodPlanePart(&joined);
  *node = joined;
}

static PetscErrorCode LinearGet(Rod rod, PetscReal t, Vec U, Vec U_t, Node *nodes) {
  const PetscInt n = rod->end - rod->first, fields = rod->model->fields;
  const PetscScalar *y, *y_t = NULL;
  PetscReal *P;
  Node *other;
  Vec local, local_t;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(rod->last + 1, &P, fields > 1 ? n : 0, &other));
  PetscCall(StraightForce(rod->scene, rod->last + 1, rod->scene->mesh.s, t, P));
  PetscCall(RodOpen(rod, U, &local, &y));
  if (U_t) PetscCall(RodOpen(rod, U_t, &local_t, &y_t));
  for (PetscInt f = fields - 1; f >= 0; f--) {
    const PetscScalar *one = OneField(rod, y, f, 0), *one_t = U_t ? OneField(rod, y_t, f, 1) : NULL;
    PetscCall(PlaneNodes(rod, t, f ? WAY_X3 : WAY_X2, P, one, one_t, f ? other : nodes));
    PetscCall(AxialPosition(rod, t, one, f ? other : nodes));
  }
  for (PetscInt k = 0; k < n && fields > 1; k++) {
    PetscReal arc;
    PetscCall(GrowthArc(rod->scene->growth, 1, &rod->scene->mesh.s[rod->first + k], t, &arc, NULL));
    nodes[k].x[0] += other[k].x[0] - arc; /* shortened by both */
    JoinWays(&nodes[k], &other[k], &nodes[k]);
  }
  PetscCall(RodClose(rod, &local, &y));
  if (U_t) PetscCall(RodClose(rod, &local_t, &y_t));
  PetscCall(PetscFree2(P, other));
  PetscFunctionReturn(0);
}

/* The matrix of the fit: row i - 1 holds y at node i = 1 .. N - 1, row N - 1 the slope at the tip
   and row N y there, so that no diagonal entry is 0; of each field. */
static PetscErrorCode CreateFit(Rod rod) {
  const PetscInt fields = rod->model->fields;
  Linear *self = (Linear *)rod->data;
  Mat A;

  PetscFunctionBegin;
  PetscCall(RodCreateMatrix(rod, &A));
  for (PetscInt k = 0; k < fields * (rod->end - rod->first); k++) {
    PetscInt row = rod->first + k / fields, f = k % fields, node = PetscMin(row + 1, rod->last),
             cell = node - 1, at = fields * row + f, cols[BASIS];
    PetscReal B[3][BASIS];
    StraightBasis(self->straight[0], cell, 1, B);
    for (PetscInt b = 0; b < BASIS; b++)
      cols[b] = cell - 2 + b < 0 ? -1 : fields * (cell - 2 + b) + f;
    PetscCall(MatSetValues(A, 1, &at, BASIS, cols, B[row == rod->last - 1], INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscCall(ChainCreateSolver(rod->scene->comm, MATORDERINGNATURAL, &self->fit));
  PetscCall(KSPSetOperators(self->fit, A, A));
  PetscCall(MatDestroy(&A));
  PetscFunctionReturn(0);
}

/* The deflection of a node, and its slope dy/dp. */
static void Deflection(const Node *node, PetscInt fields, PetscInt f, PetscReal value[2]) {
  PetscReal d[3][3];

  value[0] = node->x[1 + f];
  value[1] = node->theta;
  if (fields == 1) return;
  Directors(node->p, QuaternionSize(node->p), d);
  value[1] = d[0][1 + f];
}

/* The splines through the deflections at the nodes with the tip's slopes. */
static PetscErrorCode LinearSet(Rod rod, PetscReal t, const Node *nodes, Vec U) {
  const PetscInt fields = rod->model->fields;
  Linear *self = (Linear *)rod->data;
  const PetscReal tip = 1;
  PetscReal g, at[2];
  Vec values, shifted;
  PetscScalar *v;
  const PetscScalar *w;

  PetscFunctionBegin;
  if (!self->fit) PetscCall(CreateFit(rod));
  PetscCall(GrowthStretch(rod->scene->growth, 1, &tip, t, &g, NULL, NULL));
  PetscCall(DMGetGlobalVector(rod->da, &values));
  PetscCall(DMDAVecGetArray(rod->da, values, &v));
  for (PetscInt k = fields * rod->first; k < fields * rod->end; k++) {
    Deflection(&nodes[k / fields - rod->first], fields, k % fields, at);
    v[k] = at[0];
  }
  PetscCall(DMDAVecRestoreArray(rod->da, values, &v));
  PetscCall(DMGetLocalVector(rod->da, &shifted));
  PetscCall(DMGlobalToLocal(rod->da, values, INSERT_VALUES, shifted));
  PetscCall(DMDAVecGetArrayRead(rod->da, shifted, &w));
  PetscCall(DMDAVecGetArray(rod->da, values, &v));
  for (PetscInt k = fields * rod->first; k < fields * rod->end; k++) {
    PetscInt row = k / fields;
    v[k] = row == rod->last ? w[k] : w[k + fields];
    if (row != rod->last - 1) continue;
    Deflection(&nodes[rod->last - rod->first], fields, k % fields, at);
    v[k] = g * at[1];
  }
  PetscCall(DMDAVecRestoreArray(rod->da, values, &v));
  PetscCall(DMDAVecRestoreArrayRead(rod->da, shifted, &w));
  PetscCall(DMRestoreLocalVector(rod->da, &shifted));
  PetscCall(KSPSolve(self->fit, values, U));
  PetscCall(DMRestoreGlobalVector(rod->da, &values));
  PetscFunctionReturn(0);
}

static PetscErrorCode LinearCreate(Rod rod) {
  const PetscInt n = (rod->end - rod->first) * BAND, room = rod->end - rod->first + 6;
  const Mesh *mesh = &rod->scene->mesh;
  PetscBool alike = (PetscBool)(rod->scene->space.ratio == 1);
  Linear *self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  rod->data = self;
  rod->order = 4;
  for (PetscInt f = 0; f < rod->model->fields; f++) {
    if (f && alike) {
      self->straight[1] = self->straight[0];
      self->K[1] = self->K[0];
      self->D[1] = self->D[0];
      break;
    }
    PetscCall(StraightCreate(rod->scene, mesh, f ? WAY_X3 : WAY_X2, &self->straight[f]));
    PetscCall(PetscMalloc2(n, &self->K[f], n, &self->D[f]));
  }
  for (int k = 0; k <= WAYS && rod->model->fields > 1; k++)
    PetscCall(PetscCalloc1(room, &self->room[k]));
  PetscCall(PetscMalloc1((rod->last + 1) * 3 * BASIS, &self->basis));
  for (PetscInt i = 0; i <= rod->last; i++)
    StraightBasis(self->straight[0], PetscMin(i, rod->last - 1), i == rod->last,
                  (PetscReal(*)[BASIS])(self->basis + i * 3 * BASIS));
  self->time = PETSC_MIN_REAL;
  PetscFunctionReturn(0);
}

static PetscErrorCode LinearDestroy(Rod rod) {
  Linear *self = (Linear *)rod->data;

  PetscFunctionBegin;
  PetscCall(KSPDestroy(&self->fit));
  for (PetscInt f = WAYS - 1; f >= 0; f--) {
    if (f && self->straight[1] == self->straight[0]) continue;
    PetscCall(StraightDestroy(&self->straight[f]));
    PetscCall(PetscFree2(self->K[f], self->D[f]));
  }
  for (int k = 0; k <= WAYS; k++) PetscCall(PetscFree(self->room[k]));
  PetscCall(PetscFree(self->basis));
  PetscCall(PetscFree(rod->data));
  PetscFunctionReturn(0);
}

static const char *Refuses(Scene scene) {
  if (scene->clamp != CLAMP_HELD) return "-clamp_type: the linear model's rod is held by a clamp";
  if (!SpaceIsAlong(scene->load.weight))
    return "-rod_weight: the linear model is of a rod that no weight bends";
  if (!SpaceIsAlong(scene->tip.push))
    return "-tip_force_vector: the linear model is of a rod that is pushed along itself";
  if (scene->curvature.any)
    return "-rod_curvature: the linear model is of a rod that is straight by nature";
  if (scene->growth->yield > 0) return "-growth_yield: the linear model's growth feels no force";
  if (scene->tropism.any)
    return "-tropism_, -growth_ironing: the linear model is of a rod that stays straight by nature";
  if (scene->contact.walls.n)
    return "-wall_file: the linear model is of a rod that touches nothing";
  if (scene->tip.type != TIP_FREE)
    return "-tip_type: the linear model is of a rod whose tip is free: straight, it could not grow "
           "against what holds it";
  if (!LoadIsEven(&scene->load, scene->reach, scene->end_time))
    return "-friction_field: changes across the straight rod, which the linear model starts from";
  return NULL;
}

static const char *LinearRefuses(Scene scene) {
  return scene->space.why ? RodRefusesSpace(scene) : Refuses(scene);
}

static const char *LinearRefusesSpace(Scene scene) {
  if (scene->tip.torque != 0 || scene->space.spin != 0 || scene->curvature.space)
    return scene->tip.torque != 0 ? "-tip_torque: twist joins both directions across, and the "
                                    "linear model takes each by itself"
           : scene->space.spin != 0
               ? "-clamp_spin or -clamp_path: the linear model's rod does not turn about itself"
               : "-rod_twist or -rod_curvature_2: the linear model is of a rod "
                 "that is straight by nature";
  return Refuses(scene);
}

static PetscErrorCode LinearInitialSpace(Rod rod, PetscReal t, Node *nodes) {
  PetscFunctionBegin;
  PetscCall(rod_space.initial(rod, t, nodes));
  PetscFunctionReturn(0);
}

const RodModel rod_linear = {.name = "linear",
                             .refuses = LinearRefuses,
                             .fields = 1,
                             .stencil = 3,
                             .field = {"y"},
                             .followed = {PETSC_TRUE},
                             .group = {ACROSS_2},
                             .linear = PETSC_TRUE,
                             .create = LinearCreate,
                             .destroy = LinearDestroy,
                             .set = LinearSet,
                             .get = LinearGet,
                             .residual = LinearResidual,
                             .jacobian = LinearJacobian};

const RodModel rod_linear_space = {.name = "linear",
                                   .space = PETSC_TRUE,
                                   .refuses = LinearRefusesSpace,
                                   .fields = WAYS,
                                   .stencil = 3,
                                   .field = {"x2", "x3"},
                                   .followed = {PETSC_TRUE, PETSC_TRUE},
                                   .group = {ACROSS_2, ACROSS_3},
                                   .linear = PETSC_TRUE,
                                   .create = LinearCreate,
                                   .destroy = LinearDestroy,
                                   .initial = LinearInitialSpace,
                                   .set = LinearSet,
                                   .get = LinearGet,
                                   .residual = LinearResidual,
                                   .jacobian = LinearJacobian};
