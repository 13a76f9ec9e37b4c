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
#include "rod/frame_cells.h"
#include <string.h>

static const OptionRow rows[] = {
    ROW_WORD("-rod_order", "4", "2,4", 0, "order in space of the models frame and space")};
const OptionGroup frame_options = OPTION_GROUP_OF_ROD("Models frame and space", rows);

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
  r[TH] -= KinkOf(cell) * Cross2(From2(cell->mid->at.axes[0]), From2(feet[FOOT_KINK]));
}

/* The residual of the conditions at the beginning: what each is about is 0. */
static void ClampResidual(Rod rod, const PetscReal u[FIELDS], PetscReal r[FIELDS]) {
  for (int f = X1; f <= TH; f++) r[f] = u[OfClamp(rod, f)];
}

static PetscErrorCode FrameResidual(Rod rod, const RodState *at, Vec F) {
  Frame *frame = (Frame *)rod->data;
  PetscReal(*F_)[FIELDS];
  PetscInt first = rod->first, end = rod->end;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(FrameCellsOpen(rod, at, PETSC_FALSE, &cell));
  if (rod->learned)
    PetscCall(LearnedFill(rod, &F_));
  else
    PetscCall(DMDAVecGetArray(rod->da, F, &F_));
  for (PetscInt i = PetscMax(first - 1, 0); i < PetscMin(end, rod->last); i++) {
    PetscReal r[FIELDS];
    FrameCellsNext(&cell, i);
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
  PetscCall(FrameCellsClose(&cell));
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
  FrameCellsForget(frame);
  frame->duals = rod->scene->load.duals;
  rod->memory = FrameRemembers(frame);
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
