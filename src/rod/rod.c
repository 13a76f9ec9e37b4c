#include "rod/rod.h"
#include "base/lagrange.h"
#include "rod/directors.h"
#include "rod/learned.h"
#include "rod/rules.h"
#include <petsc/private/petscimpl.h> /* PetscObjectStateGet() */

/* A model as it is of a scene: that whose material learns what it has to. */
static const RodModel *ModelFor(Scene scene, const RodModel *model) {
  const Tropism *law = &scene->tropism;
  const PetscBool remembers = (PetscBool)(law->memory > 0 && !law->at_tip);

  if (!law->any) return model;
  if (model == &rod_frame && scene->growth->yield > 0)
    return remembers ? &rod_frame_yields_remembers : &rod_frame_yields;
  if (model == &rod_frame) return remembers ? &rod_frame_remembers : &rod_frame_learns;
  if (model == &rod_space && scene->growth->yield > 0)
    return remembers ? &rod_space_yields_remembers : &rod_space_yields;
  if (model == &rod_space) return remembers ? &rod_space_remembers : &rod_space_learns;
  return model;
}

/*
  RodCreate - a rod of one model in a scene, which must outlive it. Collective; the caller destroys
  it with RodDestroy(). Too many ranks for the mesh are a user's mistake.
*/
PetscErrorCode RodCreate(Scene scene, const RodModel *model, Rod *rod) {
  PetscMPIInt ranks;
  Rod self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *rod = self; /* whole or not, the caller destroys it */
  self->model = model = ModelFor(scene, model);
  self->scene = scene;
  self->comm = scene->comm;
  self->s = scene->mesh.s;
  self->itself = self;
  self->rods = 1;
  self->each = &self->itself;
  self->last = scene->mesh.cells;
  self->kept[0].t = self->kept[1].t = PETSC_MIN_REAL;
  PetscCallMPI(MPI_Comm_size(scene->comm, &ranks));
  self->alone = (PetscBool)(ranks == 1);
  UserCheck((self->last + 1) / ranks >= PetscMax(3, model->stencil), scene->comm,
            "-rod_cells %d: too few for %d ranks, give at least %d cells or run on fewer ranks",
            (int)self->last, (int)ranks, (int)(ranks * PetscMax(3, model->stencil)));
  PetscCall(DMDACreate1d(scene->comm, DM_BOUNDARY_NONE, self->last + 1, model->fields,
                         model->stencil, NULL, &self->da));
  PetscCall(DMSetUp(self->da));
  PetscCall(DMDACreate1d(scene->comm, DM_BOUNDARY_NONE, self->last + 1, NODE_VALUES, 1, NULL,
                         &self->nodes));
  PetscCall(DMSetUp(self->nodes));
  PetscCall(DMDAGetCorners(self->da, &self->first, NULL, NULL, &self->end, NULL, NULL));
  self->end += self->first;
  for (PetscInt f = 0; f < model->fields; f++)
    PetscCall(DMDASetFieldName(self->da, f, model->field[f]));
  if (model->create) PetscCall(model->create(self));
  PetscFunctionReturn(0);
}

PetscErrorCode RodDestroy(Rod *rod) {
  PetscFunctionBegin;
  if (!*rod) PetscFunctionReturn(0);
  if ((*rod)->data && (*rod)->model->destroy) PetscCall((*rod)->model->destroy(*rod));
  if ((*rod)->learned) PetscCall(LearnedDestroy(*rod));
  PetscCall(DMDestroy(&(*rod)->da));
  PetscCall(DMDestroy(&(*rod)->nodes));
  PetscCall(PetscFree(*rod));
  PetscFunctionReturn(0);
}

/* RodCreateMatrix - an empty matrix for the rod's Jacobian: blocks of one node, block-banded. */
PetscErrorCode RodCreateMatrix(Rod rod, Mat *J) {
  const PetscInt tip = rod->learned && rod->scene->tropism.at_tip; /* all of the rod sees that */
  PetscInt bs = rod->model->fields, w = rod->model->stencil, n = (rod->end - rod->first) * bs;

  PetscFunctionBegin;
  PetscCall(MatCreateBAIJ(rod->scene->comm, bs, n, n, PETSC_DETERMINE, PETSC_DETERMINE,
                          2 * w + 1 + tip, NULL, w + tip, NULL, J));
  PetscCall(MatSetOption(*J, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* RodCreateMemory - a vector for what the model remembers, and the DMDA it is on; the caller
   destroys both. Collective. */
PetscErrorCode RodCreateMemory(Rod rod, DM *da, Vec *memory) {
  PetscFunctionBegin;
  PetscCall(
      DMDACreate1d(rod->scene->comm, DM_BOUNDARY_NONE, rod->last + 1, rod->memory, 1, NULL, da));
  PetscCall(DMSetUp(*da));
  PetscCall(DMCreateGlobalVector(*da, memory));
  PetscFunctionReturn(0);
}

/* RodRemember - what a restart is to find of what the model remembers. */
PetscErrorCode RodRemember(Rod rod, Vec memory) {
  PetscReal *m;

  PetscFunctionBegin;
  PetscCall(VecGetArray(memory, &m));
  for (PetscInt i = rod->first; i < rod->end; i++)
    for (PetscInt k = 0; k < rod->memory; k++) {
      const PetscReal *value = rod->model->remembered(rod, i, k);
      m[(i - rod->first) * rod->memory + k] = value ? *value : 0;
    }
  PetscCall(VecRestoreArray(memory, &m));
  PetscFunctionReturn(0);
}

/* RodRecall - takes that back. (The cells beside the owned nodes are remembered here too.)
   Collective. */
PetscErrorCode RodRecall(Rod rod, Vec memory) {
  const PetscInt from = PetscMax(rod->first - 1, 0);
  const PetscReal *m;
  Vec local;
  DM da;

  PetscFunctionBegin;
  PetscCall(VecGetDM(memory, &da));
  PetscCall(DMGetLocalVector(da, &local));
  PetscCall(DMGlobalToLocal(da, memory, INSERT_VALUES, local));
  PetscCall(VecGetArrayRead(local, &m));
  for (PetscInt i = from; i <= PetscMin(rod->end, rod->last); i++)
    for (PetscInt k = 0; k < rod->memory; k++) {
      PetscReal *value = rod->model->remembered(rod, i, k);
      if (value) *value = m[(i - from) * rod->memory + k];
    }
  PetscCall(VecRestoreArrayRead(local, &m));
  PetscCall(DMRestoreLocalVector(da, &local));
  if (rod->model->recalled) PetscCall(rod->model->recalled(rod));
  PetscFunctionReturn(0);
}

/* RodOpen - the values of a vector, indexed by node and with those of the neighbours, for reading;
   array points to a pointer to arrays of the model's fields. End with RodClose(). Collective. */
PetscErrorCode RodOpen(Rod rod, Vec v, Vec *local, void *array) {
  PetscFunctionBegin;
  if (rod->alone) /* it has no neighbours */
    *local = v;
  else {
    PetscCall(DMGetLocalVector(rod->da, local));
    PetscCall(DMGlobalToLocal(rod->da, v, INSERT_VALUES, *local));
  }
  PetscCall(DMDAVecGetArrayRead(rod->da, *local, array));
  PetscFunctionReturn(0);
}

/* RodClose - ends what RodOpen() began; local and array are gone. */
PetscErrorCode RodClose(Rod rod, Vec *local, void *array) {
  PetscFunctionBegin;
  PetscCall(DMDAVecRestoreArrayRead(rod->da, *local, array));
  if (rod->alone)
    *local = NULL;
  else
    PetscCall(DMRestoreLocalVector(rod->da, local));
  PetscFunctionReturn(0);
}

/* RodRecognise - is this state the one that was seen last? From now on it is. */
PetscErrorCode RodRecognise(const RodState *at, RodSeen *seen, PetscBool *known) {
  RodSeen now = {.t = at->t};

  PetscFunctionBegin;
  PetscCall(PetscObjectGetId((PetscObject)at->U, &now.id[0]));
  PetscCall(PetscObjectGetId((PetscObject)at->U_t, &now.id[1]));
  PetscCall(PetscObjectStateGet((PetscObject)at->U, &now.state[0]));
  PetscCall(PetscObjectStateGet((PetscObject)at->U_t, &now.state[1]));
  *known = (PetscBool)(now.t == seen->t);
  for (int k = 0; k < 2; k++)
    if (now.id[k] != seen->id[k] || now.state[k] != seen->state[k]) *known = PETSC_FALSE;
  *seen = now;
  PetscFunctionReturn(0);
}

/* RodSumAlong - adds up a quantity along the rod: on entry value[i] is the part of the cell left of
   owned node i, on exit the sum from the clamp. Collective. */
PetscErrorCode RodSumAlong(Rod rod, PetscInt n, PetscReal value[]) {
  PetscReal total = 0, before = 0;
  PetscMPIInt rank;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) total += value[i];
  PetscCallMPI(MPI_Exscan(&total, &before, 1, MPIU_REAL, MPI_SUM, rod->scene->comm));
  PetscCallMPI(MPI_Comm_rank(rod->scene->comm, &rank));
  if (!rank) before = 0; /* MPI leaves it undefined there */
  for (PetscInt i = 0; i < n; i++) value[i] = before += value[i];
  PetscFunctionReturn(0);
}

/* Positions and their rates by quadrature of x' = g q, x'_t = g_t q over the angle of the scene's
   initial shape. */
static PetscErrorCode IntegratePosition(Rod rod, PetscReal t, Node *nodes) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscInt n = rod->end - rod->first;
  PetscReal *all, *x, *y, *x_t, *y_t;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(4 * n, &all));
  x = all;
  y = x + n;
  x_t = y + n;
  y_t = x_t + n;
  for (PetscInt i = PetscMax(rod->first, 1); i < rod->end; i++)
    for (int q = 0; q < GAUSS; q++) {
      PetscReal h = s[i] - s[i - 1], z = s[i - 1] + h * gauss_point[q], g, g_t, theta, slope;
      PetscInt k = i - rod->first;
      PetscCall(GrowthStretch(rod->scene->growth, 1, &z, t, &g, &g_t, NULL));
      PetscCall(SceneShapeAngle(rod->scene, z, &theta, &slope));
      x[k] += h * gauss_weight[q] * g * PetscCosReal(theta);
      y[k] += h * gauss_weight[q] * g * PetscSinReal(theta);
      x_t[k] += h * gauss_weight[q] * g_t * PetscCosReal(theta);
      y_t[k] += h * gauss_weight[q] * g_t * PetscSinReal(theta);
    }
  for (int f = 0; f < 4; f++) PetscCall(RodSumAlong(rod, n, all + f * n));
  for (PetscInt k = 0; k < n; k++) {
    Put2((Vector2){x[k], y[k]}, nodes[k].x);
    Put2((Vector2){x_t[k], y_t[k]}, nodes[k].x_t);
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/*
  RodGetLocalNodes - the nodes of a state, as a vector with those of the neighbours, open to be
  read: with[i] is node i. Collective; given back by RodRestoreLocalNodes().
*/
PetscErrorCode RodGetLocalNodes(Rod rod, PetscReal t, Vec U, Vec *local, const Node **with) {
  PetscScalar *owned;
  Vec v;

  PetscFunctionBegin;
  PetscCall(DMGetGlobalVector(rod->nodes, &v));
  PetscCall(DMGetLocalVector(rod->nodes, local));
  PetscCall(VecGetArray(v, &owned));
  PetscCall(rod->model->get(rod, t, U, NULL, (Node *)owned));
  PetscCall(VecRestoreArray(v, &owned));
  PetscCall(DMGlobalToLocal(rod->nodes, v, INSERT_VALUES, *local));
  PetscCall(DMRestoreGlobalVector(rod->nodes, &v));
  PetscCall(DMDAVecGetArrayRead(rod->nodes, *local, (void *)with));
  PetscFunctionReturn(0);
}

PetscErrorCode RodRestoreLocalNodes(Rod rod, Vec *local, const Node **with) {
  PetscFunctionBegin;
  PetscCall(DMDAVecRestoreArrayRead(rod->nodes, *local, (void *)with));
  PetscCall(DMRestoreLocalVector(rod->nodes, local));
  PetscFunctionReturn(0);
}

/* The moment of the initial shape at s. */
static PetscErrorCode InitialMoment(Scene scene, PetscReal s, PetscReal t, PetscReal *moment) {
  PetscReal g, theta, slope, k0, B;

  PetscFunctionBegin;
  PetscCall(SceneCurvature(scene, s, t, &k0, NULL));
  PetscCall(SceneStiffness(scene, s, t, &B, NULL));
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, &g, NULL, NULL));
  PetscCall(SceneShapeAngle(scene, s, &theta, &slope));
  *moment = B * (slope / g - k0);
  PetscFunctionReturn(0);
}

/* Its force across, of which m' = -g q x n: n = (n.q) q - m'/g q_perp. */
static PetscErrorCode InitialShear(Scene scene, PetscReal s, PetscReal t, Node *node) {
  const Vector2 q = Direction2(node->theta);
  const PetscReal middle = PetscMax(rod_rule.slope_step, PetscMin(1 - rod_rule.slope_step, s));
  const PetscReal at[3] = {middle - rod_rule.slope_step, middle, middle + rod_rule.slope_step};
  PetscReal g, m, D[3], slope = 0;

  PetscFunctionBegin;
  LagrangeSlopes(3, at, s, D);
  for (int k = 0; k < 3; k++) {
    PetscCall(InitialMoment(scene, at[k], t, &m));
    slope += D[k] * m;
  }
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, &g, NULL, NULL));
  Put2(Along2(Times2(node->force[0], q), -slope / g, Left2(q)), node->force);
  PetscFunctionReturn(0);
}

/* RodInitialNodes - the scene's initial shape at the owned nodes, with the force along it of the
   straight rod, that across it which its moments tell, and the velocity of growth without friction.
   Collective. */
PetscErrorCode RodInitialNodes(Rod rod, PetscReal t, Node *nodes) {
  Scene scene = rod->scene;
  PetscReal *P;

  PetscFunctionBegin;
  if (rod->model->initial) {
    PetscCall(rod->model->initial(rod, t, nodes));
    PetscFunctionReturn(0);
  }
  PetscCall(PetscArrayzero(nodes, rod->end - rod->first));
  PetscCall(PetscMalloc1(rod->last + 1, &P));
  PetscCall(StraightForce(scene, rod->last + 1, scene->mesh.s, t, P));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    Node *node = &nodes[i - rod->first];
    PetscReal slope;
    PetscCall(SceneShapeAngle(scene, scene->mesh.s[i], &node->theta, &slope));
    PetscCall(InitialMoment(scene, scene->mesh.s[i], t, &node->moment));
    node->force[0] = -P[i];
    node->growth[0] = GrowthSpeed(scene->growth, scene->mesh.s[i], t, 0);
    PetscCall(GrowthLength(scene->growth, t, &node->growth[1], NULL));
    PetscCall(InitialShear(scene, scene->mesh.s[i], t, node));
  }
  PetscCall(PetscFree(P));
  PetscCall(IntegratePosition(rod, t, nodes));
  PetscFunctionReturn(0);
}

/* Where friction feels the spin of a rod that does not grow, ends that turn begin to. In a guess
   that keeps them at rest it is stiffest, and turning them then makes of it a couple that twists
   all beside them beyond what Newton's method finds back from, however short the step. */
static void TurnEnds(Rod rod, PetscReal t, Node *nodes) {
  const Scene scene = rod->scene;

  if (scene->load.radius == 0 || !scene->growth->still) return;
  if (rod->first == 0 && scene->clamp == CLAMP_HELD) SpaceClampTurn(&scene->space, t, nodes->p);
  if (rod->end == rod->last + 1) TipHeldFrame(&scene->tip, t, nodes[rod->last - rod->first].p);
}

/*
  RodGrowNodes - the first guess for a step that has no history: the rod stretched by growth at
  unchanged angles. A guess that keeps x would put friction where it is stiffest, at rest.
*/
PetscErrorCode RodGrowNodes(Rod rod, PetscReal t0, PetscReal t1, Node *nodes) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscInt n = rod->end - rod->first;
  PetscReal *dx[3], *all, g[2], k0[2], B[2];
  DM da = rod->nodes;
  Vec owned, ghosted;
  Node *with;

  PetscFunctionBegin;
  PetscCall(DMGetGlobalVector(da, &owned));
  PetscCall(DMGetLocalVector(da, &ghosted));
  PetscCall(VecGetArray(owned, (PetscScalar **)&with));
  PetscCall(PetscArraycpy(with, nodes, n));
  PetscCall(VecRestoreArray(owned, (PetscScalar **)&with));
  PetscCall(DMGlobalToLocal(da, owned, INSERT_VALUES, ghosted));
  PetscCall(DMDAVecGetArrayRead(da, ghosted, &with));
  PetscCall(PetscCalloc1(3 * n, &all));
  for (int d = 0; d < 3; d++) dx[d] = all + d * n;
  for (PetscInt i = PetscMax(rod->first, 1); i < rod->end; i++) {
    PetscReal p[2][2];
    if (s[i] == s[i - 1]) continue;
    PetscCall(GrowthArc(rod->scene->growth, 2, &s[i - 1], t0, p[0], NULL));
    PetscCall(GrowthArc(rod->scene->growth, 2, &s[i - 1], t1, p[1], NULL));
    for (int d = 0; d < 3; d++)
      dx[d][i - rod->first] =
          (with[i].x[d] - with[i - 1].x[d]) * ((p[1][1] - p[1][0]) / (p[0][1] - p[0][0]) - 1);
  }
  PetscCall(DMDAVecRestoreArrayRead(da, ghosted, &with));
  PetscCall(DMRestoreLocalVector(da, &ghosted));
  PetscCall(DMRestoreGlobalVector(da, &owned));
  for (int d = 0; d < RodDims(rod->model); d++) PetscCall(RodSumAlong(rod, n, dx[d]));
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(GrowthStretch(rod->scene->growth, 1, &s[rod->first + k], t0, &g[0], NULL, NULL));
    PetscCall(GrowthStretch(rod->scene->growth, 1, &s[rod->first + k], t1, &g[1], NULL, NULL));
    for (int e = 0; e < 2; e++) {
      PetscCall(SceneCurvature(rod->scene, s[rod->first + k], e ? t1 : t0, &k0[e], NULL));
      PetscCall(SceneStiffness(rod->scene, s[rod->first + k], e ? t1 : t0, &B[e], NULL));
    }
    for (int d = 0; d < 3; d++) nodes[k].x[d] += dx[d][k];
    if (rod->scene->growth->yield > 0) nodes[k].growth[1] = g[1];
    if (rod->model->space) continue; /* moments are found by the first iteration */
    nodes[k].moment = B[1] * ((nodes[k].moment / B[0] + k0[0]) * g[0] / g[1] - k0[1]);
  }
  if (rod->model->space) TurnEnds(rod, t1, nodes);
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* RodRefusesSpace - why a model of the plane cannot be of this scene; NULL: it can. */
const char *RodRefusesSpace(Scene scene) {
  Space *space = &scene->space;

  if (!space->why) return NULL;
  (void)snprintf(space->refused, sizeof(space->refused), "%s: takes the rod out of the plane",
                 space->why);
  return space->refused;
}

/* RodPlanePart - angle and moment of a node as every model has them, from the frame of one in
 * space.
 */
void RodPlanePart(Node *node) {
  PetscReal d[3][3], size = QuaternionSize(node->p);

  Directors(node->p, size, d);
  const Vector2 across = From2(d[0] + 1);
  node->theta = atan2(PetscSqrtReal(Dot2(across, across)), d[0][0]);
  node->moment = Size3(node->m3);
}

/* RodHoldTip - tells a scene whose tip is held where that is: where the initial shape has it.
   Collective. */
PetscErrorCode RodHoldTip(Rod rod) {
  PetscInt n = rod->end - rod->first;
  PetscReal tip[8] = {0};
  Node *nodes;
  Vec U;

  PetscFunctionBegin;
  if (rod->scene->tip.type == TIP_FREE || rod->scene->tip.type == TIP_CARRIED)
    PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(n, &nodes));
  PetscCall(DMGetGlobalVector(rod->da, &U));
  PetscCall(RodBegin(rod, U));
  PetscCall(rod->model->get(rod, 0, U, NULL, nodes));
  PetscCall(DMRestoreGlobalVector(rod->da, &U));
  if (rod->end == rod->last + 1) {
    tip[0] = nodes[n - 1].theta;
    PetscCall(PetscArraycpy(tip + 1, nodes[n - 1].x, 3));
    PetscCall(PetscArraycpy(tip + 4, nodes[n - 1].p, 4));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, tip, 8, MPIU_REAL, MPI_SUM, rod->scene->comm));
  if (rod->model->space)
    PetscCall(SceneHoldTip3(rod->scene, tip + 1, tip + 4));
  else
    PetscCall(SceneHoldTip(rod->scene, tip + 1, tip[0]));
  PetscCall(PetscFree(nodes));
  PetscFunctionReturn(0);
}
