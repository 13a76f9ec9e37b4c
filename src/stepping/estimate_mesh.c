/* The coarse mesh of the estimate, with all that is on it: chosen, and refined where the rod
 * touches. */
#include "base/blocklu.h"
#include "base/chain.h"
#include "stepping/estimating.h"

static PetscErrorCode CreateGathered(const Estimate self, Gathered *g) {
  const PetscInt u = self->nodes * self->fields, rate = self->nodes * self->followed;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(3 * u + 2 * rate, &g->u));
  g->rate = g->u + u;
  g->defect = g->rate + u;
  g->local = g->defect + u;
  g->skipped = g->local + rate;
  PetscFunctionReturn(0);
}

/* How many cells of the run a coarse one has: an even number, for defects are those of two cells.
   Where that is longer than the layer over which contact presses, at a length of the rod, it is
   one: between longer ones a place where the rod touches would be lost, and what it holds go
   astray. So it is of rods that hold each other, whose joints are at nodes. */
static PetscInt Stride(const Estimate self, PetscReal reach) {
  const Rod rod = self->leg->rod;
  const PetscReal h = reach / rod->last, half = RodLayer(rod) / 2;
  PetscInt most = rod->last / step_rule.estimate_cells;
  PetscReal length = step_rule.estimate_longest * RodUnits(rod)->length;

  if (rod->at) return 1;
  if (self->touches) {
    if (2 * h > half) return 1;
    length = PetscMin(length, half);
    most = rod->last;
  }
  return 2 * PetscMax(1, PetscMin(most, (PetscInt)(length / h)) / 2);
}

/* EstimateFineNode - which node of the run coarse node k is. */
PetscInt EstimateFineNode(const Estimate self, PetscInt k) {
  return PetscMin(k * self->stride, self->leg->rod->last);
}

/* Far parts of the rod see each other, or it has more unknowns: no line of neighbours that can be
   eliminated. */
static PetscErrorCode CreateMatrix(Estimate self) {
  const PetscBool held = RodEndsOf(self->rod).tip_held;
  PetscInt *late, n;

  PetscFunctionBegin;
  if (self->rod->coupled && BlockLUCan(self->nodes, self->fields)) {
    PetscCall(PetscMalloc1(2 * self->rod->rods, &late));
    n = RodLate(self->rod, late);
    PetscCall(BlockLUCreate(self->nodes, self->fields, n, late, &self->J));
    PetscCall(PetscFree(late));
    PetscCall(KSPCreate(PETSC_COMM_SELF, &self->ksp));
    PetscCall(BlockLUSetSolver(self->ksp));
    PetscFunctionReturn(0);
  }
  PetscCall(RodCreateMatrix(self->rod, &self->J));
  PetscCall(ChainCreateSolver(
      PETSC_COMM_SELF, self->rod->coupled ? ChainFolded(held) : MATORDERINGNATURAL, &self->ksp));
  PetscFunctionReturn(0);
}

/* The coarse rod, on rank 0. Itself it touches only from the first contact on. */
static PetscErrorCode CreateCoarse(Estimate self) {
  const PetscInt n = self->nodes * self->fields;
  PetscInt halves[2];

  PetscFunctionBegin;
  PetscCall(RodCoarsen(self->leg->rod, self->nodes, self->stride,
                       (PetscBool)(self->touches || self->leg->rod->at), &self->rod));
  LearnedHalves(self->rod, halves);
  if (self->rod->coupled)
    PetscCall(CreateMatrix(self));
  else
    PetscCall(EliminationCreate(PETSC_COMM_SELF, self->nodes, halves, &self->elimination));
  PetscCall(DMCreateGlobalVector(self->rod->da, &self->U));
  PetscCall(VecDuplicate(self->U, &self->rate));
  PetscCall(VecDuplicate(self->U, &self->nudged));
  PetscCall(VecDuplicate(self->U, &self->F));
  PetscCall(VecDuplicate(self->U, &self->G));
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(PetscCalloc3(n, &self->e[part], n, &self->begun[part], n, &self->once[part]));
  PetscCall(PetscCalloc2(n, &self->rhs, n, &self->b));
  PetscCall(CreateGathered(self, &self->all));
  PetscFunctionReturn(0);
}

/* EstimateSceneChanged - the scene has been changed in the run: errors are followed on in what it
   is now. self NULL: none are. */
PetscErrorCode EstimateSceneChanged(Estimate self) {
  PetscFunctionBegin;
  if (self && self->rod) RodCoarseTake(self->rod, self->leg->rod, self->touches);
  PetscFunctionReturn(0);
}

static PetscErrorCode DestroyCoarse(Estimate self) {
  PetscFunctionBegin;
  PetscCall(VecDestroy(&self->U));
  PetscCall(VecDestroy(&self->rate));
  PetscCall(VecDestroy(&self->nudged));
  PetscCall(VecDestroy(&self->F));
  PetscCall(VecDestroy(&self->G));
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(PetscFree3(self->e[part], self->begun[part], self->once[part]));
  PetscCall(PetscFree2(self->rhs, self->b));
  PetscCall(PetscFree(self->all.u));
  PetscCall(EliminationDestroy(&self->elimination));
  PetscCall(KSPDestroy(&self->ksp));
  PetscCall(MatDestroy(&self->J));
  PetscCall(RodCoarseEnd(&self->rod));
  PetscFunctionReturn(0);
}

/* The mesh of every stride-th node, the tip in any case, with all that is on it. */
static PetscErrorCode ChooseMesh(Estimate self, PetscInt stride) {
  Rod rod = self->leg->rod;
  PetscMPIInt rank;

  PetscFunctionBegin;
  self->stride = stride;
  self->nodes = (rod->last + stride - 1) / stride + 1;
  PetscCall(CreateGathered(self, &self->own));
  PetscCallMPI(MPI_Comm_rank(rod->comm, &rank));
  if (!rank) PetscCall(CreateCoarse(self));
  PetscFunctionReturn(0);
}

/*
  EstimateCreate - follows the errors of a leg's run from its present state on, which has none; NULL
  if its model does not know its defects, or has too few cells. The tip must be known where it is
  held. Of several rods that hold each other, which have errors in common, each is looked at by an
  EstimatePart(). Collective; the caller ends it with EstimateDestroy(), before the leg.
*/
PetscErrorCode EstimateCreate(Leg *leg, Estimate *estimate) {
  Estimate self;

  PetscFunctionBegin;
  *estimate = NULL;
  if (!leg->rod->model->defect || leg->rod->last < step_rule.estimate_least_cells)
    PetscFunctionReturn(0);
  PetscCall(PetscNew(&self));
  *estimate = self;
  self->leg = leg;
  self->model = leg->rod->model;
  self->fields = self->model->fields;
  self->left = self->model->halves[0];
  self->followed = leg->rod->learned ? self->fields : self->left;
  self->mirrors = self->model->space ? 2 : 1;
  PetscCall(PetscCalloc1(leg->rod->end - leg->rod->first, &self->defect));
  PetscCall(ChooseMesh(self, Stride(self, RodLongest(leg->rod))));
  if (leg->rod->at) PetscCall(PetscCalloc1(leg->rod->rods, &self->part));
  PetscFunctionReturn(0);
}

/* What is gathered of the nodes from one on. */
static Gathered From(const Estimate whole, const Gathered *all, PetscInt node) {
  const PetscInt u = node * whole->fields, rate = node * whole->followed;

  return (Gathered){.u = all->u + u,
                    .rate = all->rate + u,
                    .defect = all->defect + u,
                    .local = all->local + rate,
                    .skipped = all->skipped + rate};
}

/* EstimatePart - what those of several rods make of what is seen of rod k, whose leg is a part of
   theirs; whole NULL: none are followed. It goes on with that of all; the caller ends it with
   EstimateDestroy(), before that. */
PetscErrorCode EstimatePart(Estimate whole, PetscInt k, Leg *leg, Estimate *estimate) {
  Estimate self;
  PetscInt from;

  PetscFunctionBegin;
  *estimate = NULL;
  if (!whole) PetscFunctionReturn(0);
  from = whole->leg->rod->at[k];
  PetscCall(PetscNew(&self));
  *self = *whole;
  *estimate = whole->part[k] = self;
  self->leg = leg;
  self->model = leg->rod->model;
  self->whole = whole;
  self->part = NULL;
  self->nodes = leg->rod->last + 1;
  self->rod = whole->rod->each[k];
  self->own = From(whole, &whole->own, from);
  self->all = From(whole, &whole->all, from);
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    self->e[part] = whole->e[part] + from * self->fields;
  PetscFunctionReturn(0);
}

PetscErrorCode EstimateDestroy(Estimate *estimate) {
  Estimate self = *estimate;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  if (!self->whole) {
    PetscCall(DestroyCoarse(self));
    PetscCall(PetscFree(self->own.u));
    PetscCall(PetscFree(self->defect));
    PetscCall(PetscFree(self->part));
  }
  PetscCall(PetscFree(*estimate));
  PetscFunctionReturn(0);
}

/* Errors at the nodes of another mesh, linearly between those where they were. */
static void Interpolate(PetscInt fields, PetscInt m, const PetscReal *from, const PetscReal *old,
                        PetscInt n, const PetscReal *to, PetscReal *new) {
  PetscInt j = 0;

  for (PetscInt k = 0; k < n; k++) {
    PetscReal z;
    while (j + 2 < m && from[j + 1] < to[k]) j++;
    z = (to[k] - from[j]) / (from[j + 1] - from[j]);
    for (PetscInt f = 0; f < fields; f++)
      new[k * fields + f] = (1 - z) * old[j * fields + f] + z *old[(j + 1) * fields + f];
  }
}

/* EstimateRefine - errors go on on another mesh. Collective. */
PetscErrorCode EstimateRefine(Estimate self, PetscInt stride) {
  PetscReal *s = NULL, *old = NULL;
  PetscInt n = self->nodes, size = n * self->fields;
  PetscBool here = (PetscBool)(self->rod != NULL);

  PetscFunctionBegin;
  self->until = 0;
  if (here) {
    PetscCall(PetscMalloc2(n, &s, ESTIMATE_PARTS * size, &old));
    PetscCall(PetscArraycpy(s, self->rod->s, n));
    for (int part = 0; part < ESTIMATE_PARTS; part++)
      PetscCall(PetscArraycpy(old + part * size, self->e[part], size));
    PetscCall(DestroyCoarse(self));
  }
  PetscCall(PetscFree(self->own.u));
  PetscCall(ChooseMesh(self, stride));
  for (int part = 0; part < ESTIMATE_PARTS && here; part++)
    Interpolate(self->fields, n, s, old + part * size, self->nodes, self->rod->s, self->e[part]);
  PetscCall(PetscFree2(s, old));
  PetscFunctionReturn(0);
}

/* EstimateLookAtLayer - the first contact, and longer cells or a shorter layer later, ask for
   another mesh. Collective. */
PetscErrorCode EstimateLookAtLayer(Estimate self, PetscReal t) {
  const PetscBool first = (PetscBool)!self->touches;
  PetscReal length;
  PetscInt stride;

  PetscFunctionBegin;
  if (!first && (self->stride == 1 || self->since)) PetscFunctionReturn(0);
  self->touches = PETSC_TRUE;
  if (self->part) PetscFunctionReturn(0); /* its mesh is all there is */
  PetscCall(RodLength(self->leg->rod, t, &length));
  stride = Stride(self, length);
  if (first || 2 * stride <= self->stride) PetscCall(EstimateRefine(self, stride));
  PetscFunctionReturn(0);
}
