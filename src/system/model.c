#include "system/model.h"
#include "rod/ask.h"
#include "rod/rules.h"
#include "rod/strand_rows.h"
#include <petsc/private/petscimpl.h> /* PetscObjectStateSet() */

/* The parts of a state that are one rod's. They are the same vectors in each state, and count as
   changed when that has: what a rod knows of a state it keeps. */
typedef struct {
  Vec U, U_t, F;
} Part;

typedef struct {
  RodModel model; /* of all */
  PetscInt *at;
  Part *part;
  Joints joints;            /* borrowed */
  StrandRows rows;          /* of those that touch; NULL: none can */
  Mat window;               /* the part of a matrix that is one rod's: see Window */
  RodSeen seen;             /* the latest state, */
  PetscObjectState changes; /* the how manieth that is */
} System;

/* ---- strands ---- */

/* What strands do to each rod in a state, or that of none. */
static PetscErrorCode PushEach(Rod rod, const RodState *at) {
  const System *self = (const System *)rod->data;
  const PetscReal(*force)[3], (*couple)[3];

  PetscFunctionBegin;
  if (!self->rows) PetscFunctionReturn(0);
  PetscCall(StrandRowsLoad(rod, self->rows, at, &force, &couple));
  for (PetscInt k = 0; k < rod->rods; k++)
    rod->each[k]->pushed = (RodPushed){.force = force + 2 * self->at[k],
                                       .couple = couple + 2 * self->at[k],
                                       .cells = StrandRowsCell(rod, self->rows, self->at[k])};
  PetscFunctionReturn(0);
}

/* ---- states ---- */

/* Puts the parts on a state, until Leave(). F NULL: no equations are asked for. */
static PetscErrorCode Enter(Rod rod, const RodState *at, Vec F) {
  System *self = (System *)rod->data;
  const PetscInt fields = rod->model->fields;
  const PetscScalar *u, *u_t;
  PetscBool known;
  PetscScalar *f = NULL;

  PetscFunctionBegin;
  PetscCall(PushEach(rod, at));
  PetscCall(RodRecognise(at, &self->seen, &known));
  if (!known) self->changes++;
  PetscCall(VecGetArrayRead(at->U, &u));
  PetscCall(VecGetArrayRead(at->U_t, &u_t));
  if (F) PetscCall(VecGetArray(F, &f));
  for (PetscInt k = 0; k < rod->rods; k++) {
    Part *part = &self->part[k];
    PetscCall(VecPlaceArray(part->U, u + self->at[k] * fields));
    PetscCall(VecPlaceArray(part->U_t, u_t + self->at[k] * fields));
    PetscCall(PetscObjectStateSet((PetscObject)part->U, self->changes));
    PetscCall(PetscObjectStateSet((PetscObject)part->U_t, self->changes));
    if (F) PetscCall(VecPlaceArray(part->F, f + self->at[k] * fields));
  }
  if (F) PetscCall(VecRestoreArray(F, &f));
  PetscCall(VecRestoreArrayRead(at->U_t, &u_t));
  PetscCall(VecRestoreArrayRead(at->U, &u));
  PetscFunctionReturn(0);
}

static PetscErrorCode Leave(Rod rod, Vec F) {
  System *self = (System *)rod->data;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < rod->rods; k++) {
    PetscCall(VecResetArray(self->part[k].U));
    PetscCall(VecResetArray(self->part[k].U_t));
    if (F) PetscCall(VecResetArray(self->part[k].F));
  }
  PetscFunctionReturn(0);
}

/* The state of rod k, of which its parts are on. */
static RodState StateOf(Rod rod, PetscInt k, const RodState *at) {
  const Part *part = &((const System *)rod->data)->part[k];
  RodState own = *at;

  own.U = part->U;
  own.U_t = part->U_t;
  return own;
}

/* ---- the model ---- */

static PetscErrorCode Residual(Rod rod, const RodState *at, Vec F) {
  PetscFunctionBegin;
  PetscCall(Enter(rod, at, F));
  for (PetscInt k = 0; k < rod->rods; k++) {
    const Part *part = &((System *)rod->data)->part[k];
    const RodState own = StateOf(rod, k, at);
    if (SceneRests(rod->each[k]->scene, at->t))
      PetscCall(VecCopy(part->U_t, part->F)); /* it stays as it is */
    else
      PetscCall(rod->each[k]->model->residual(rod->each[k], &own, part->F));
  }
  PetscCall(Leave(rod, F));
  PetscCall(JointsResidual(((System *)rod->data)->joints, rod, at->t, at->U, F));
  PetscFunctionReturn(0);
}

/* A rod puts blocks into the matrix of all as if it were its own: they go there, `first` nodes on.
 */
typedef struct {
  Mat whole;
  PetscInt first;
} Window;

static PetscErrorCode SetInWindow(Mat part, PetscInt m, const PetscInt rows[], PetscInt n,
                                  const PetscInt columns[], const PetscScalar v[],
                                  InsertMode mode) {
  enum { MOST = 8 };
  PetscInt node[2][MOST];
  Window *window;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(part, &window));
  PetscCheck(m <= MOST && n <= MOST, PETSC_COMM_SELF, PETSC_ERR_PLIB, "too many blocks at once");
  for (PetscInt i = 0; i < m; i++) node[0][i] = rows[i] < 0 ? rows[i] : rows[i] + window->first;
  for (PetscInt j = 0; j < n; j++)
    node[1][j] = columns[j] < 0 ? columns[j] : columns[j] + window->first;
  PetscCall(MatSetValuesBlocked(window->whole, m, node[0], n, node[1], v, mode));
  PetscFunctionReturn(0);
}

/* The whole has been: that of all is 0 before any rod puts blocks there. */
static PetscErrorCode ZeroWindow(Mat part) {
  PetscFunctionBegin;
  (void)part;
  PetscFunctionReturn(0);
}

static PetscErrorCode CloseWindow(Mat part) {
  Window *window;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(part, &window));
  PetscCall(PetscFree(window));
  PetscFunctionReturn(0);
}

static PetscErrorCode OpenWindow(PetscInt nodes, PetscInt fields, Mat *part) {
  const PetscInt n = nodes * fields;
  Window *window;

  PetscFunctionBegin;
  PetscCall(PetscNew(&window));
  PetscCall(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, window, part));
  PetscCall(MatSetBlockSize(*part, fields));
  PetscCall(MatSetUp(*part));
  PetscCall(MatShellSetOperation(*part, MATOP_SET_VALUES_BLOCKED, (void (*)(void))SetInWindow));
  PetscCall(MatShellSetOperation(*part, MATOP_ZERO_ENTRIES, (void (*)(void))ZeroWindow));
  PetscCall(MatShellSetOperation(*part, MATOP_DESTROY, (void (*)(void))CloseWindow));
  PetscFunctionReturn(0);
}

/* That of a rod which stays as it is: its rates are 0. */
static PetscErrorCode RestingJacobian(Rod rod, const RodState *at, Mat J) {
  const PetscInt fields = rod->model->fields;
  PetscReal block[MAX_FIELDS * MAX_FIELDS] = {0};

  PetscFunctionBegin;
  for (PetscInt f = 0; f < fields; f++) block[f * fields + f] = at->shift[f];
  for (PetscInt i = 0; i <= rod->last; i++)
    PetscCall(MatSetValuesBlocked(J, 1, &i, 1, &i, block, INSERT_VALUES));
  PetscFunctionReturn(0);
}

/* The matrix of all: the rods' own, and what they do to each other, which adds to blocks. */
static PetscErrorCode Jacobian(Rod rod, const RodState *at, Mat J) {
  const System *self = (const System *)rod->data;
  Window *window;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(self->window, &window));
  PetscCall(Enter(rod, at, NULL));
  if (self->rows)
    PetscCall(StrandRowsPattern(rod, self->rows, at->fresh, J));
  else
    PetscCall(MatZeroEntries(J));
  window->whole = J;
  for (PetscInt k = 0; k < rod->rods; k++) {
    const RodState own = StateOf(rod, k, at);
    window->first = self->at[k];
    PetscCall((SceneRests(rod->each[k]->scene, at->t)
                   ? RestingJacobian
                   : rod->each[k]->model->jacobian)(rod->each[k], &own, self->window));
  }
  PetscCall(Leave(rod, NULL));
  PetscCall(MatAssemblyBegin(J, MAT_FLUSH_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FLUSH_ASSEMBLY));
  if (self->rows) PetscCall(StrandRowsJacobian(rod, self->rows, at, J));
  PetscCall(JointsJacobian(self->joints, rod, at->t, at->U, J));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

static PetscErrorCode Eliminate(Rod rod, const RodState *at, Elimination elimination) {
  PetscFunctionBegin;
  PetscCall(Enter(rod, at, NULL));
  for (PetscInt k = 0; k < rod->rods; k++) {
    const RodState own = StateOf(rod, k, at);
    PetscCall(rod->each[k]->model->eliminate(rod->each[k], &own, EliminationPart(elimination, k)));
  }
  PetscCall(Leave(rod, NULL));
  PetscFunctionReturn(0);
}

static PetscErrorCode Defect(Rod rod, const RodState *at, PetscReal (*defect)[MAX_FIELDS]) {
  PetscFunctionBegin;
  PetscCall(Enter(rod, at, NULL));
  for (PetscInt k = 0; k < rod->rods; k++) {
    const RodState own = StateOf(rod, k, at);
    PetscReal(*const to)[MAX_FIELDS] = defect + ((const System *)rod->data)->at[k];
    if (SceneRests(rod->each[k]->scene, at->t))
      PetscCall(PetscArrayzero(to, rod->each[k]->last + 1));
    else
      PetscCall(rod->each[k]->model->defect(rod->each[k], &own, to));
  }
  PetscCall(Leave(rod, NULL));
  PetscFunctionReturn(0);
}

static PetscErrorCode Hold(Rod rod, const RodState *at, PetscReal seen, PetscReal *creep) {
  PetscReal one;

  PetscFunctionBegin;
  *creep = 0;
  PetscCall(Enter(rod, at, NULL));
  for (PetscInt k = 0; k < rod->rods; k++) {
    const RodState own = StateOf(rod, k, at);
    if (SceneRests(rod->each[k]->scene, at->t)) continue;
    PetscCall(rod->each[k]->model->hold(rod->each[k], &own, seen, &one));
    *creep = PetscMax(*creep, one);
  }
  PetscCall(Leave(rod, NULL));
  PetscFunctionReturn(0);
}

/* Each rod keeps what it bears; of all together it is of no account. */
static PetscErrorCode Bears(Rod rod, const RodState *at, RodForces *sum) {
  RodForces one;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  PetscCall(Enter(rod, at, NULL));
  for (PetscInt k = 0; k < rod->rods; k++) {
    const RodState own = StateOf(rod, k, at);
    if (SceneRests(rod->each[k]->scene, at->t)) continue;
    PetscCall(rod->each[k]->model->bears(rod->each[k], &own, &one));
    RodKeepBorne(rod->each[k], &one);
  }
  PetscCall(Leave(rod, NULL));
  PetscFunctionReturn(0);
}

/* The rod that has node i of all. */
static PetscInt RodOf(const Rod rod, PetscInt i) {
  PetscInt k = 0;
  while (i >= rod->at[k + 1]) k++;
  return k;
}

static PetscReal *RememberedAt(Rod rod, PetscInt i, PetscInt value) {
  const PetscInt k = RodOf(rod, i);
  const Rod one = rod->each[k];

  return value < one->memory ? one->model->remembered(one, i - rod->at[k], value) : NULL;
}

static PetscErrorCode Recalled(Rod rod) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < rod->rods; k++)
    if (rod->each[k]->model->recalled) PetscCall(rod->each[k]->model->recalled(rod->each[k]));
  PetscFunctionReturn(0);
}

/* (What strands do to others is left out.) */
static PetscErrorCode Again(Rod rod, Rod each[], Rod *other) {
  PetscFunctionBegin;
  PetscCall(SystemCreate(rod->rods, each, ((const System *)rod->data)->joints, NULL, other));
  PetscFunctionReturn(0);
}

static PetscErrorCode Destroy(Rod rod) {
  System *self = (System *)rod->data;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < rod->rods; k++) {
    PetscCall(VecDestroy(&self->part[k].U));
    PetscCall(VecDestroy(&self->part[k].U_t));
    PetscCall(VecDestroy(&self->part[k].F));
    PetscCall(RodDestroy(&rod->each[k]));
  }
  PetscCall(StrandRowsDestroy(&self->rows));
  PetscCall(SceneShareEnd(&rod->scene));
  PetscCall(MatDestroy(&self->window));
  PetscCall(PetscFree(self->at));
  PetscCall(PetscFree(self->part));
  PetscCall(PetscFree(rod->each));
  PetscCall(PetscFree(rod->data));
  PetscFunctionReturn(0);
}

/* ---- all of them ---- */

/* The units that steps begin by: those of the rod that wants the shortest. */
static void Units(const Rod rod) {
  SceneUnits *all = &rod->scene->units;

  for (PetscInt k = 1; k < rod->rods; k++) {
    const SceneUnits *one = &rod->each[k]->scene->units;
    all->length = PetscMin(all->length, one->length);
    all->time = PetscMin(all->time, one->time);
    all->own = PetscMin(all->own, one->own);
    all->brief = PetscMin(all->brief, one->brief);
    if (one->unheld) all->unheld = PETSC_TRUE;
    if (!one->straight) all->straight = PETSC_FALSE;
  }
}

/* What all do as one: no fields are a factor times a shape for all of them. */
static void MakeModel(const RodModel *of_each, RodModel *model) {
  *model = *of_each;
  model->name = "several rods";
  for (PetscInt f = 0; f < model->fields; f++) model->group[f] = ALONG;
  model->initial = NULL;
  model->refuses = NULL;
  model->create = NULL;
  model->destroy = Destroy;
  model->set = NULL;
  model->get = NULL;
  model->residual = Residual;
  model->jacobian = Jacobian;
  model->eliminate = Eliminate;
  model->defect = of_each->defect ? Defect : NULL;
  model->hold = of_each->hold ? Hold : NULL;
  model->bears = of_each->bears ? Bears : NULL;
  model->remembered = RememberedAt;
  model->recalled = Recalled;
  model->again = Again;
}

/* Rods that feel each other are measured against a part of the longest of them. */
static PetscErrorCode Measures(Rod rod) {
  PetscReal length;

  PetscFunctionBegin;
  if (!rod->coupled) PetscFunctionReturn(0);
  PetscCall(RodLength(rod, 0, &length));
  for (PetscInt k = 0; k < rod->rods; k++) rod->each[k]->least = rod_rule.joined_part * length;
  PetscFunctionReturn(0);
}

static PetscErrorCode MakeParts(Rod rod) {
  System *self = (System *)rod->data;
  const PetscInt fields = rod->model->fields;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(rod->rods + 1, &self->at));
  PetscCall(PetscCalloc1(rod->rods, &self->part));
  for (PetscInt k = 0; k < rod->rods; k++) {
    const PetscInt nodes = rod->each[k]->last + 1;
    Part *part = &self->part[k];
    self->at[k + 1] = self->at[k] + nodes;
    rod->memory = PetscMax(rod->memory, rod->each[k]->memory);
    PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, fields, nodes * fields, NULL, &part->U));
    PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, fields, nodes * fields, NULL, &part->U_t));
    PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, fields, nodes * fields, NULL, &part->F));
  }
  rod->at = self->at;
  RodForget(&self->seen);
  PetscFunctionReturn(0);
}

/*
  SystemCreate - n rods of one model, which go together, on this rank. They are its own from now on;
  the caller destroys it with RodDestroy(), before their scenes.

  each     with their units
  joints   of them; must outlive it, as
  strands  of those that may touch; NULL: none can
*/
PetscErrorCode SystemCreate(PetscInt n, Rod each[], Joints joints, Strands strands, Rod *rod) {
  System *system;
  Rod self;

  PetscFunctionBegin;
  PetscCall(PetscNew(rod));
  self = *rod;
  PetscCall(PetscNew(&system));
  MakeModel(each[0]->model, &system->model);
  self->data = system;
  self->model = &system->model;
  self->comm = PETSC_COMM_SELF;
  self->alone = PETSC_TRUE;
  self->order = each[0]->order;
  self->rods = n;
  system->joints = joints;
  for (PetscInt k = 0; k < n; k++)
    if (each[k]->scene->clamp != CLAMP_HELD || each[k]->coupled || each[k]->scene->born > 0)
      self->coupled = PETSC_TRUE;
  if (JointsCount(joints) > 0 || strands) self->coupled = PETSC_TRUE;
  PetscCall(PetscMalloc1(n, &self->each));
  PetscCall(PetscArraycpy(self->each, each, n));
  PetscCall(SceneShare(each[0]->scene, &self->scene));
  PetscCall(MakeParts(self));
  PetscCall(Measures(self));
  Units(self);
  self->end = system->at[n];
  self->last = self->end - 1;
  PetscCall(OpenWindow(self->end, self->model->fields, &system->window));
  if (strands) PetscCall(StrandRowsCreate(self, strands, &system->rows));
  for (int k = 0; k < 2; k++) self->kept[k].t = PETSC_MIN_REAL;
  PetscCall(DMDACreate1d(PETSC_COMM_SELF, DM_BOUNDARY_NONE, self->end, self->model->fields, 1, NULL,
                         &self->da));
  PetscCall(DMSetUp(self->da));
  PetscFunctionReturn(0);
}
