/* The model of space (docs/theory/rod.md): a Kirchhoff rod, thirteen unknowns a node. d1, d2, d3
   are the directors of the quaternion p, d1 the tangent; x, m and n are in the clamp's frame,

     x' = g d1,  p' = g/2 p (0, u),  u = S^-1 (m.d1, m.d2, m.d3) + u0,
     m' = -g d1 x n + g l d1,  n' = g F,

   F the load and l its couple about the tangent (world/load.h), at the velocity
   v = x_t + c d1 and the spin 2 (p* p_t)_1 + c u1,
     s = 0: x = 0, p that of the clamp, or in a hinge m.d2 = m.d3 = 0, |p| = 1 and no turn about d1
            but the clamp's, or m = 0, n = 0, |p| = 1 where it is free;
     s = 1: the tip's six conditions (tip.h).
   The cells are those of the frame model (frame.c), y = (x, p, m, n),
     order 4:  y_b - y_a = h/6 (f_a + 4 f_mid + f_b),  y_mid = (y_a + y_b)/2 + h/8 (f_a - f_b),
     order 2:  y_b - y_a = h f_mid,                    y_mid = (y_a + y_b)/2,
   x_t at mid likewise, and the spin where friction along the rod feels it (rod/spin.h); else the
   rate of p there is the mean of both ends'. Where the couple of friction jumps within a cell it
   has that of its ends (space_cells.c). The rows of node i are the x and p equations of the cell on
   its left, the m and n equations of the cell on its right. */
#include "base/vectors.h"
#include "rod/space_cells.h"
#include "rod/rules.h"
#include <string.h>

/* A point load is smeared over its cell by the formula; what p of the end lacks of that, see
   FootLoad:

     K = p/2 (0, w),   w_k = (h g)^2/S_k d_k.(d1 x w),   w that of the feet, p and d in the middle,
*/
static void Kink(const Cell *cell, PetscReal K[4]) {
  const Point *p = cell->mid;
  const PetscReal *w = cell->foot_load[FOOT_KINK], f = PetscSqr(cell->h * cell->law[AT_MID].g),
                  turn[3] = {0, -f * cell->law[AT_MID].flex[1] * Dot3(w, p->at.axes[2]),
                             f * cell->law[AT_MID].flex[2] * Dot3(w, p->at.axes[1])};

  QuaternionTurn(p->p, turn, K);
  for (int i = 0; i < 4; i++) K[i] /= 2;
}

/* Adds to the residual of a cell what its feet do at its ends alone, and the kink. */
static void AddFeet(const Cell *cell, PetscReal r[FIELDS]) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const PetscReal we = cell->h * self->end_weight, (*load)[FOOT_LOAD] = cell->foot_load;
  PetscReal K[4];

  Kink(cell, K);
  for (int i = 0; i < 4; i++) r[P + i] -= K[i];
  for (int i = 0; i < 3; i++) {
    r[N + i] -= we * (load[AT_A][i] + load[AT_B][i]);
    r[M + i] -= we * (load[AT_A][3 + i] + load[AT_B][3 + i]);
  }
}

static PetscErrorCode SpaceResidual(Rod rod, const RodState *at, Vec F) {
  const Space_ *self = (const Space_ *)rod->data;
  const Scene scene = rod->scene;
  PetscReal(*F_)[FIELDS], r[FIELDS];
  Cell cell;

  PetscFunctionBegin;
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  if (rod->learned)
    PetscCall(LearnedFill(rod, &F_));
  else
    PetscCall(DMDAVecGetArray(rod->da, F, &F_));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (rod->learned) SpaceLearnedResidual(rod, i, cell.a, cell.mid);
    if (self->yields) SpaceYieldResidual(&cell, i);
    if (self->yields && i == 0) SpaceYieldEnds(rod, 0, cell.a);
    for (int f = 0; f < FIELDS; f++)
      r[f] = cell.u[i + 1][f] - cell.u[i][f] -
             cell.h * (self->end_weight * (cell.a->f[f] + cell.b->f[f]) +
                       self->mid_weight * cell.mid->f[f]);
    if (cell.feet.n) AddFeet(&cell, r);
    if (i >= rod->first) PetscCall(PetscArraycpy(&F_[i][LEFT], &r[LEFT], RIGHT));
    if (i + 1 < rod->end) PetscCall(PetscArraycpy(F_[i + 1], r, LEFT));
  }
  if (rod->first == 0) SpaceClampResidual(scene, at->t, cell.u[0], F_[0]);
  if (rod->end == rod->last + 1) {
    TipState tip = SpaceTipOf(cell.load, cell.b);
    TipResidual3(&scene->tip, &tip, SpaceTipDual(rod), &F_[rod->last][LEFT]);
    for (int d = 0; d < 3 && cell.push && scene->tip.type == TIP_FREE; d++) {
      F_[rod->last][N + d] -= cell.push[2 * rod->last + 1][d];
      if (cell.couple) F_[rod->last][M + d] -= cell.couple[2 * rod->last + 1][d];
    }
    if (rod->learned) SpaceLearnedResidual(rod, rod->last, cell.b, NULL);
    if (self->yields) SpaceYieldEnds(rod, rod->last, cell.b);
  }
  if (rod->learned)
    PetscCall(LearnedFilled(rod, F));
  else
    PetscCall(DMDAVecRestoreArray(rod->da, F, &F_));
  PetscCall(SpaceCellsClose(&cell));
  PetscFunctionReturn(0);
}

/* ---- nodes ---- */

/* m_k = d_k.m, and d_k'(dp).m + d_k.dm. */
static void SpaceMoments(const PetscReal u[], const PetscReal change[], PetscReal m[3],
                         PetscReal dm[3]) {
  const PetscReal *p = u + P, size = QuaternionSize(p);
  PetscReal d[3][3], D[3][4];

  Directors(p, size, d);
  for (int k = 0; k < 3; k++) {
    DirectorSlope(p, size, d[k], k, D);
    m[k] = dm[k] = 0;
    for (int i = 0; i < 3; i++) {
      m[k] += d[k][i] * u[M + i];
      dm[k] += d[k][i] * change[M + i];
      for (int j = 0; j < 4; j++) dm[k] += D[i][j] * change[P + j] * u[M + i];
    }
  }
}

/* Is an owned node turned by half a turn or more, p0.p1 <= 0? The same on every rank. */
static PetscErrorCode SpaceTurned(Rod rod, Vec U0, Vec U1, PetscBool *turned) {
  const PetscInt fields = rod->model->fields, n = (rod->end - rod->first) * fields;
  const PetscReal *a, *b;

  PetscFunctionBegin;
  *turned = PETSC_FALSE;
  PetscCall(VecGetArrayRead(U0, (const PetscScalar **)&a));
  PetscCall(VecGetArrayRead(U1, (const PetscScalar **)&b));
  for (PetscInt i = 0; i < n; i += fields) {
    PetscReal dot = 0;
    for (int k = 0; k < 4; k++) dot += a[i + P + k] * b[i + P + k];
    if (!(dot > 0)) *turned = PETSC_TRUE;
  }
  PetscCall(VecRestoreArrayRead(U0, (const PetscScalar **)&a));
  PetscCall(VecRestoreArrayRead(U1, (const PetscScalar **)&b));
  if (!rod->alone)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, turned, 1, MPIU_BOOL, MPI_LOR, rod->scene->comm));
  PetscFunctionReturn(0);
}

static PetscErrorCode SpaceSet(Rod rod, PetscReal t, const Node *nodes, Vec U) {
  const PetscBool yields = ((const Space_ *)rod->data)->yields;
  PetscReal *u, *at;

  PetscFunctionBegin;
  PetscCall(VecGetArray(U, (PetscScalar **)&u));
  at = u;
  for (PetscInt i = 0; i < rod->end - rod->first; i++, at += rod->model->fields) {
    PetscCall(PetscArraycpy(at + X, nodes[i].x, 3));
    PetscCall(PetscArraycpy(at + P, nodes[i].p, 4));
    PetscCall(PetscArraycpy(at + M, nodes[i].m3, 3));
    PetscCall(PetscArraycpy(at + N, nodes[i].force, 3));
    if (yields) PetscCall(PetscArraycpy(at + OF_V, nodes[i].growth, YIELD_FIELDS - FIELDS));
  }
  PetscCall(VecRestoreArray(U, (PetscScalar **)&u));
  if (rod->learned) PetscCall(LearnedSet(rod, nodes, U));
  PetscFunctionReturn(0);
}

static PetscErrorCode SpaceGet(Rod rod, PetscReal t, Vec U, Vec U_t, Node *nodes) {
  const PetscBool yields = ((const Space_ *)rod->data)->yields;
  const PetscInt fields = rod->model->fields;
  const PetscReal *u, *u_t = NULL;

  PetscFunctionBegin;
  if (yields) PetscCall(SpaceYieldSee(rod, t, U)); /* who asks goes on with its length */
  PetscCall(VecGetArrayRead(U, (const PetscScalar **)&u));
  if (U_t) PetscCall(VecGetArrayRead(U_t, (const PetscScalar **)&u_t));
  for (PetscInt i = 0; i < rod->end - rod->first; i++) {
    const PetscReal *at = u + i * fields, *at_t = u_t + i * fields;
    Node *node = &nodes[i];
    PetscCall(PetscMemzero(node, sizeof(*node)));
    PetscCall(PetscArraycpy(node->x, at + X, 3));
    PetscCall(PetscArraycpy(node->p, at + P, 4));
    PetscCall(PetscArraycpy(node->m3, at + M, 3));
    PetscCall(PetscArraycpy(node->force, at + N, 3));
    if (yields) PetscCall(PetscArraycpy(node->growth, at + OF_V, YIELD_FIELDS - FIELDS));
    if (U_t) {
      PetscCall(PetscArraycpy(node->x_t, at_t + X, 3));
      PetscCall(PetscArraycpy(node->p_t, at_t + P, 4));
      PetscCall(PetscArraycpy(node->m3_t, at_t + M, 3));
    }
    RodPlanePart(node);
  }
  if (U_t) PetscCall(VecRestoreArrayRead(U_t, (const PetscScalar **)&u_t));
  PetscCall(VecRestoreArrayRead(U, (const PetscScalar **)&u));
  if (rod->learned) PetscCall(LearnedGet(rod, U, nodes));
  PetscFunctionReturn(0);
}

/* p1 and m1 are made of products of what is across in both directions, and on a rod that is bent in
   one plane, however tilted, no more than what these leave of round-off. And a place across that is
   small by chance is measured against what its slope makes along the rod. Where moments bend a rod
   out of its plane in which it is, but for round-off, as of one that is twisted there, they drive
   it by their part of those in it. */
static void SpaceScale(PetscReal size[]) {
  const PetscReal tilt = size[P + 2] * size[P + 3], most = PetscMax(size[M + 1], size[M + 2]);

  if (size[M + 1] > 0 && size[M + 2] > 0) {
    const PetscReal about_2 = rod_rule.across_by_moment * (size[M + 1] / most),
                    about_3 = rod_rule.across_by_moment * (size[M + 2] / most);
    size[X + 1] = PetscMax(size[X + 1], about_3 * size[X + 2]);
    size[X + 2] = PetscMax(size[X + 2], about_2 * size[X + 1]);
    size[P + 2] = PetscMax(size[P + 2], about_2 * size[P + 3]);
    size[P + 3] = PetscMax(size[P + 3], about_3 * size[P + 2]);
  }

  size[P + 1] = PetscMax(size[P + 1], tilt);
  size[M] = PetscMax(size[M], size[M + 1] * size[P + 3] + size[M + 2] * size[P + 2]);
  size[X + 1] = PetscMax(size[X + 1], rod_rule.across_by_slope * size[P + 3] * size[X]);
  size[X + 2] = PetscMax(size[X + 2], rod_rule.across_by_slope * size[P + 2] * size[X]);
}

/* In space a rod that nothing holds may spin about itself. */
static const char *SpaceRefuses(Scene scene) {
  return scene->clamp == CLAMP_FREE && scene->load.radius == 0
             ? "-clamp_type free: nothing keeps a rod in space from spinning about itself; give it "
               "a -friction_radius"
             : NULL;
}

/* Does the couple of friction jump within cells where the rod stops turning? Not if beta is such
   that it changes along many, nor if growth moves the rod all along. */
static PetscBool Kinks(Scene scene) {
  const Load *load = &scene->load;

  return (PetscBool)(load->radius > 0 && scene->growth->still &&
                     (load->limit || load->friction.beta < rod_rule.couple_jumps));
}

static PetscErrorCode SpaceCreate(Rod rod) {
  PetscInt choice, points = 2 * (rod->end - rod->first + 2);
  Space_ *self;

  PetscFunctionBegin;
  PetscCall(OptionWord("-rod_order", &choice, NULL));
  PetscCall(PetscNew(&self));
  rod->data = self;
  rod->order = choice ? 4 : 2;
  self->end_weight = choice ? 1. / 6 : 0;
  self->mid_weight = choice ? 4. / 6 : 1;
  self->bow = choice ? 1. / 8 : 0;
  self->time = PETSC_MIN_REAL;
  self->yields = (PetscBool)(rod->scene->growth->yield > 0);
  UserCheck(!self->yields || rod->order == 4, rod->scene->comm,
            "-rod_order 2: -growth_yield needs order 4");
  if (rod->model->fields > FIELDS)
    PetscCall(LearnedCreate(rod, FIELDS, self->yields ? YIELD_FIELDS - FIELDS : 0, TROPISM_BENDS));
  rod->memory = SpaceRemembers(&rod->scene->load);
  self->duals = rod->scene->load.duals3;
  SpaceCellsForget(self);
  PetscCall(
      PetscCalloc3(points, &self->law, points * self->duals, &self->dual, points, &self->point));
  if (ContactWallsRub(&rod->scene->contact) && ContactHasRidges(&rod->scene->contact)) {
    PetscCall(PetscCalloc1(points / 2 * WALL_SLOTS, &self->foot_dual));
    rod->memory += FrictionDualReals(RUBS) * WALL_SLOTS;
  }
  if (Kinks(rod->scene)) PetscCall(PetscCalloc1(rod->end - rod->first + 2, &self->split));
  if (rod->scene->contact.self && !rod->scene->contact.among) {
    rod->coupled = PETSC_TRUE;
    PetscCall(StrandRowsCreate(rod, NULL, &self->strands));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode SpaceDestroy(Rod rod) {
  Space_ *self = (Space_ *)rod->data;

  PetscFunctionBegin;
  PetscCall(PetscFree3(self->law, self->dual, self->point));
  PetscCall(PetscFree(self->foot_dual));
  PetscCall(StrandRowsDestroy(&self->strands));
  PetscCall(PetscFree(self->split));
  PetscCall(PetscFree(rod->data));
  PetscFunctionReturn(0);
}

/* What the model is, whatever its material learns. */
#define SPACE                                                                                      \
  .name = "space", .space = PETSC_TRUE, .stencil = 1, .halves = {LEFT, RIGHT},                     \
  .refuses = SpaceRefuses, .create = SpaceCreate, .destroy = SpaceDestroy,                         \
  .initial = SpaceInitial, .scale = SpaceScale, .set = SpaceSet, .get = SpaceGet,                  \
  .residual = SpaceResidual, .defect = SpaceDefect, .moments = SpaceMoments,                       \
  .turned = SpaceTurned, .hold = SpaceHold, .bears = SpaceBears, .remembered = SpaceRemembered,    \
  .recalled = SpaceRecalled, .jacobian = SpaceJacobian, .eliminate = SpaceEliminate
#define NAMES "x1", "x2", "x3", "p0", "p1", "p2", "p3", "m1", "m2", "m3", "n1", "n2", "n3"
#define FIRST_FOLLOWED                                                                             \
  PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE
#define UNFOLLOWED PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE, PETSC_FALSE
#define MIRRORED                                                                                   \
  ALONG, ACROSS_2, ACROSS_3, ALONG, TWIST, ACROSS_3, ACROSS_2, TWIST, ACROSS_3, ACROSS_2, ALONG,   \
      ACROSS_2, ACROSS_3
#define PAIRS                                                                                      \
  {1, 2, 1}, {P + 3, P + 2, -1}, {M + 2, M + 1, -1}, {                                             \
    N + 1, N + 2, 1                                                                                \
  }
#define BENDS(first)                                                                               \
  { (first), (first) + 1, -1 }
#define K_NAMES "k3", "k2", "k3_mid", "k2_mid"
#define F_NAMES "k3", "k2", "f3", "f2", "k3_mid", "k2_mid", "f3_mid", "f2_mid"
#define K_FOLLOWED PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE
#define K_GROUPS ACROSS_2, ACROSS_3, ACROSS_2, ACROSS_3
#define K_PAIRS(first) BENDS(first), BENDS((first) + 2)

const RodModel rod_space = {SPACE,
                            .fields = FIELDS,
                            .field = {NAMES},
                            .followed = {FIRST_FOLLOWED},
                            .group = {MIRRORED},
                            .pairs = 4,
                            .pair = {PAIRS}};
const RodModel rod_space_learns = {SPACE,
                                   .fields = FIELDS + 4,
                                   .field = {NAMES, K_NAMES},
                                   .followed = {FIRST_FOLLOWED, UNFOLLOWED, K_FOLLOWED},
                                   .group = {MIRRORED, K_GROUPS},
                                   .pairs = 6,
                                   .pair = {PAIRS, K_PAIRS(FIELDS)}};
const RodModel rod_space_remembers = {
    SPACE,
    .fields = FIELDS + 8,
    .field = {NAMES, F_NAMES},
    .followed = {FIRST_FOLLOWED, UNFOLLOWED, K_FOLLOWED, K_FOLLOWED},
    .group = {MIRRORED, K_GROUPS, K_GROUPS},
    .pairs = 8,
    .pair = {PAIRS, K_PAIRS(FIELDS), K_PAIRS(FIELDS + 4)}};
/* ... whose growth feels force: eliminated, without its V and L, to count modes alone. */
const RodModel rod_space_yields = {
    SPACE,
    .fields = YIELD_FIELDS + 4,
    .field = {NAMES, "V", "L", K_NAMES},
    .followed = {FIRST_FOLLOWED, UNFOLLOWED, PETSC_FALSE, PETSC_TRUE, K_FOLLOWED},
    .group = {MIRRORED, ALONG, ALONG, K_GROUPS},
    .pairs = 6,
    .pair = {PAIRS, K_PAIRS(YIELD_FIELDS)}};
const RodModel rod_space_yields_remembers = {
    SPACE,
    .fields = YIELD_FIELDS + 8,
    .field = {NAMES, "V", "L", F_NAMES},
    .followed = {FIRST_FOLLOWED, UNFOLLOWED, PETSC_FALSE, PETSC_TRUE, K_FOLLOWED, K_FOLLOWED},
    .group = {MIRRORED, ALONG, ALONG, K_GROUPS, K_GROUPS},
    .pairs = 8,
    .pair = {PAIRS, K_PAIRS(YIELD_FIELDS), K_PAIRS(YIELD_FIELDS + 4)}};
