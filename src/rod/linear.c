/* The linear model: a small deflection y = x2 of the straight rod, D y_t = K y in cubic B-splines
   (straight.h), one unknown per node. Terms of relative size theta^2 are left out. */
#include "base/chain.h"
#include "rod/rod.h"
#include <petscksp.h>

typedef struct {
  Straight straight;
  PetscReal *K, *D; /* owned rows, at time */
  PetscReal time;
  PetscReal *basis; /* [N + 1][3][BASIS]: B, B', B'' at the nodes */
  KSP fit;          /* spline coefficients from the values at the nodes */
} Linear;

static PetscErrorCode BandsAt(Rod rod, PetscReal t) {
  Linear *self = (Linear *)rod->data;

  PetscFunctionBegin;
  if (self->time == t) PetscFunctionReturn(0);
  PetscCall(StraightBands(self->straight, t, rod->first, rod->end, self->K, self->D));
  self->time = t;
  PetscFunctionReturn(0);
}

/* F = D y_t - K y */
static PetscErrorCode LinearResidual(Rod rod, PetscReal t, Vec U, Vec U_t, Vec F) {
  Linear *self = (Linear *)rod->data;
  const PetscScalar *y, *y_t;
  PetscScalar *f;
  Vec local[2];

  PetscFunctionBegin;
  PetscCall(RodOpen(rod, U, &local[0], &y));
  PetscCall(RodOpen(rod, U_t, &local[1], &y_t));
  PetscCall(DMDAVecGetArray(rod->da, F, &f));
  PetscCall(StraightApply(self->straight, t, rod->first, rod->end, y, y_t, f));
  PetscCall(DMDAVecRestoreArray(rod->da, F, &f));
  PetscCall(RodClose(rod, &local[0], &y));
  PetscCall(RodClose(rod, &local[1], &y_t));
  PetscFunctionReturn(0);
}

/* J = shift D - K */
static PetscErrorCode LinearJacobian(Rod rod, PetscReal t, Vec U, Vec U_t, const PetscReal shift[],
                                     Mat J) {
  Linear *self = (Linear *)rod->data;

  PetscFunctionBegin;
  PetscCall(BandsAt(rod, t));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    PetscInt cols[BAND];
    PetscScalar row[BAND];
    for (PetscInt b = 0; b < BAND; b++) {
      cols[b] = i + b - 3 <= rod->last ? i + b - 3 : -1;
      row[b] =
          shift[0] * self->D[(i - rod->first) * BAND + b] - self->K[(i - rod->first) * BAND + b];
    }
    PetscCall(MatSetValues(J, 1, &i, BAND, cols, row, INSERT_VALUES));
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

/* The moment m = B (y'/g)'/g at node i. */
static PetscErrorCode Moment(Rod rod, PetscReal t, const PetscScalar *y, PetscInt i, PetscReal *m) {
  PetscReal d[3], g, g_s, B;

  PetscFunctionBegin;
  Evaluate(rod, y, i, d);
  PetscCall(GrowthStretch(rod->scene->growth, 1, &rod->scene->mesh.s[i], t, &g, NULL, &g_s));
  PetscCall(SceneStiffness(rod->scene, rod->scene->mesh.s[i], t, &B, NULL));
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
static PetscErrorCode BetterMoment(Rod rod, PetscReal t, const PetscScalar *y, PetscInt i,
                                   PetscReal *m) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscInt mid = PetscMax(i, 1);
  PetscReal a, b, bend, g, B;

  PetscFunctionBegin;
  *m = 0;
  if (i == rod->last) PetscFunctionReturn(0);
  PetscCall(Moment(rod, t, y, i, m));
  a = s[mid] - s[mid - 1];
  b = s[mid + 1] - s[mid];
  bend = FourthDerivative(rod, y, mid);
  if (!i) bend += a / b * (bend - FourthDerivative(rod, y, 2)); /* on to the clamp */
  PetscCall(GrowthStretch(rod->scene->growth, 1, &s[i], t, &g, NULL, NULL));
  PetscCall(SceneStiffness(rod->scene, s[i], t, &B, NULL));
  *m += B * (a * a * a + b * b * b) / (12 * (a + b)) * bend / (g * g);
  PetscFunctionReturn(0);
}

/* n2 = theta n1 - m'/g, m' that of the parabola through the moments at three nodes; at the tip what
   pushes there. */
static PetscErrorCode ShearForce(Rod rod, PetscReal t, const PetscScalar *y, PetscInt i,
                                 PetscReal g, Node *node) {
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
  for (int k = 0; k < 3; k++) PetscCall(Moment(rod, t, y, mid - 1 + k, &m[k]));
  a = s[mid] - s[mid - 1];
  b = s[mid + 1] - s[mid];
  left = (m[1] - m[0]) / a; /* the slopes in the middles of the cells */
  right = (m[2] - m[1]) / b;
  node->force[1] =
      node->theta * node->force[0] - (left + (right - left) * (i ? a : -a) / (a + b)) / g;
  PetscFunctionReturn(0);
}

/* x1 = p - 1/2 int theta^2 g ds, to the order of the model; y is ghosted. */
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

static PetscErrorCode LinearGet(Rod rod, PetscReal t, Vec U, Vec U_t, Node *nodes) {
  const PetscReal *s = rod->scene->mesh.s;
  const PetscScalar *y, *y_t = NULL;
  PetscReal *P;
  Vec local[2];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(rod->last + 1, &P));
  PetscCall(StraightForce(rod->scene, rod->last + 1, s, t, P));
  PetscCall(RodOpen(rod, U, &local[0], &y));
  if (U_t) PetscCall(RodOpen(rod, U_t, &local[1], &y_t));
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
    if (U_t) {
      Evaluate(rod, y_t, i, d);
      node->x_t[1] = d[0];
      node->theta_t = (d[1] - node->theta * g_t) / g;
    }
    PetscCall(BetterMoment(rod, t, y, i, &node->moment));
    PetscCall(ShearForce(rod, t, y, i, g, node));
  }
  PetscCall(AxialPosition(rod, t, y, nodes));
  PetscCall(RodClose(rod, &local[0], &y));
  if (U_t) PetscCall(RodClose(rod, &local[1], &y_t));
  PetscCall(PetscFree(P));
  PetscFunctionReturn(0);
}

/* The matrix of the fit: row i - 1 holds y at node i = 1 .. N - 1, row N - 1 the slope at the tip
   and row N y there, so that no diagonal entry is 0. */
static PetscErrorCode CreateFit(Rod rod) {
  Linear *self = (Linear *)rod->data;
  Mat A;
  PC pc;

  PetscFunctionBegin;
  PetscCall(RodCreateMatrix(rod, &A));
  for (PetscInt row = rod->first; row < rod->end; row++) {
    PetscInt node = PetscMin(row + 1, rod->last), cell = node - 1, cols[BASIS];
    PetscReal B[3][BASIS];
    StraightBasis(self->straight, cell, 1, B);
    for (PetscInt b = 0; b < BASIS; b++) cols[b] = PetscMax(-1, cell - 2 + b);
    PetscCall(MatSetValues(A, 1, &row, BASIS, cols, B[row == rod->last - 1], INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscCall(KSPCreate(rod->scene->comm, &self->fit));
  PetscCall(KSPSetOperators(self->fit, A, A));
  PetscCall(MatDestroy(&A));
  PetscCall(KSPSetType(self->fit, KSPPREONLY));
  PetscCall(KSPGetPC(self->fit, &pc));
  PetscCall(ChainSetType(pc, MATORDERINGNATURAL));
  PetscFunctionReturn(0);
}

/* The spline through x2 at the nodes with the tip's slope. */
static PetscErrorCode LinearSet(Rod rod, PetscReal t, const Node *nodes, Vec U) {
  Linear *self = (Linear *)rod->data;
  const PetscReal tip = 1;
  PetscReal g;
  Vec values, shifted;
  PetscScalar *v;
  const PetscScalar *w;

  PetscFunctionBegin;
  if (!self->fit) PetscCall(CreateFit(rod));
  PetscCall(GrowthStretch(rod->scene->growth, 1, &tip, t, &g, NULL, NULL));
  PetscCall(DMGetGlobalVector(rod->da, &values));
  PetscCall(DMDAVecGetArray(rod->da, values, &v));
  for (PetscInt i = rod->first; i < rod->end; i++) v[i] = nodes[i - rod->first].x[1];
  PetscCall(DMDAVecRestoreArray(rod->da, values, &v));
  PetscCall(DMGetLocalVector(rod->da, &shifted));
  PetscCall(DMGlobalToLocal(rod->da, values, INSERT_VALUES, shifted));
  PetscCall(DMDAVecGetArrayRead(rod->da, shifted, &w));
  PetscCall(DMDAVecGetArray(rod->da, values, &v));
  for (PetscInt row = rod->first; row < rod->end; row++)
    v[row] = row == rod->last       ? w[row]
             : row == rod->last - 1 ? g * nodes[rod->last - rod->first].theta
                                    : w[row + 1];
  PetscCall(DMDAVecRestoreArray(rod->da, values, &v));
  PetscCall(DMDAVecRestoreArrayRead(rod->da, shifted, &w));
  PetscCall(DMRestoreLocalVector(rod->da, &shifted));
  PetscCall(KSPSolve(self->fit, values, U));
  PetscCall(DMRestoreGlobalVector(rod->da, &values));
  PetscFunctionReturn(0);
}

static PetscErrorCode LinearCreate(Rod rod) {
  PetscInt n = (rod->end - rod->first) * BAND;
  Linear *self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  rod->order = 4;
  PetscCall(StraightCreate(rod->scene, &rod->scene->mesh, WAY_X2, &self->straight));
  PetscCall(PetscMalloc2(n, &self->K, n, &self->D));
  PetscCall(PetscMalloc1((rod->last + 1) * 3 * BASIS, &self->basis));
  for (PetscInt i = 0; i <= rod->last; i++)
    StraightBasis(self->straight, PetscMin(i, rod->last - 1), i == rod->last,
                  (PetscReal(*)[BASIS])(self->basis + i * 3 * BASIS));
  self->time = PETSC_MIN_REAL;
  rod->data = self;
  PetscFunctionReturn(0);
}

static PetscErrorCode LinearDestroy(Rod rod) {
  Linear *self = (Linear *)rod->data;

  PetscFunctionBegin;
  PetscCall(KSPDestroy(&self->fit));
  PetscCall(StraightDestroy(&self->straight));
  PetscCall(PetscFree2(self->K, self->D));
  PetscCall(PetscFree(self->basis));
  PetscCall(PetscFree(rod->data));
  PetscFunctionReturn(0);
}

static const char *LinearRefuses(Scene scene) {
  if (scene->space.why) return RodRefusesSpace(scene);
  if (scene->load.weighs) return "-rod_weight: the linear model is of a rod without weight";
  if (scene->tip.push[0] != 0 || scene->tip.push[1] != 0)
    return "-tip_force_vector: the linear model is of a rod that is pushed along itself, by "
           "-tip_force";
  if (scene->curvature.any)
    return "-rod_curvature: the linear model is of a rod that is straight by nature";
  if (scene->contact.walls.n)
    return "-wall_file: the linear model is of a rod that touches nothing";
  if (scene->tip.type != TIP_FREE)
    return "-tip_type: the linear model is of a rod whose tip is free: straight, it could not grow "
           "against what holds it";
  if (!LoadIsEven(&scene->load, scene->reach, scene->end_time))
    return "-friction_field: changes across the straight rod, which the linear model starts from";
  return NULL;
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
