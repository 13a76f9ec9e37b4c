#include "stepping/guard.h"
#include "rod/ask.h"
#include "rod/grazing.h"
#include "rod/crossing.h"
#include "rod/passing.h"
#include "stepping/leg.h"
#include "stepping/vbdf.h"
#include "stepping/rules.h"

/* All nodes of a state on rank 0, NULL on the others; the caller frees them. Collective. */
static PetscErrorCode NodesOnZero(Rod rod, PetscReal t, Vec U, Node **nodes) {
  const PetscScalar *all;
  PetscMPIInt rank;
  PetscScalar *local;
  VecScatter to_zero;
  Vec v, gathered;

  PetscFunctionBegin;
  *nodes = NULL;
  if (rod->alone) {
    PetscCall(PetscMalloc1(rod->last + 1, nodes));
    PetscCall(rod->model->get(rod, t, U, NULL, *nodes));
    PetscFunctionReturn(0);
  }
  PetscCallMPI(MPI_Comm_rank(rod->comm, &rank));
  PetscCall(DMGetGlobalVector(rod->nodes, &v));
  PetscCall(VecGetArray(v, &local));
  PetscCall(rod->model->get(rod, t, U, NULL, (Node *)local));
  PetscCall(VecRestoreArray(v, &local));
  PetscCall(VecScatterCreateToZero(v, &to_zero, &gathered));
  PetscCall(VecScatterBegin(to_zero, v, gathered, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(to_zero, v, gathered, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(gathered, &all));
  if (!rank) {
    PetscCall(PetscMalloc1(rod->last + 1, nodes));
    PetscCall(PetscMemcpy(*nodes, all, (size_t)(rod->last + 1) * sizeof(Node)));
  }
  PetscCall(VecRestoreArrayRead(gathered, &all));
  PetscCall(VecDestroy(&gathered));
  PetscCall(VecScatterDestroy(&to_zero));
  PetscCall(DMRestoreGlobalVector(rod->nodes, &v));
  PetscFunctionReturn(0);
}

/* In the plane: does the rod cross itself? Rank 0 looks. */
static PetscErrorCode CrossesItself(Rod rod, PetscReal t, Vec U, PetscBool *crosses) {
  PetscInt count = 0;
  Node *nodes;

  PetscFunctionBegin;
  PetscCall(NodesOnZero(rod, t, U, &nodes));
  if (nodes) PetscCall(RodCrossings(rod->last + 1, nodes, &count));
  PetscCall(PetscFree(nodes));
  *crosses = (PetscBool)(count > 0);
  PetscFunctionReturn(0);
}

/* In space: has it passed through itself on the way from one state to another? Rank 0 looks. */
static PetscErrorCode PassesItself(Rod rod, PetscReal t0, PetscReal t1, Vec U0, Vec U1,
                                   PetscBool *passes) {
  Node *from, *to;

  PetscFunctionBegin;
  *passes = PETSC_FALSE;
  PetscCall(NodesOnZero(rod, t0, U0, &from));
  PetscCall(NodesOnZero(rod, t1, U1, &to));
  if (from) PetscCall(RodPassesItself(rod->last + 1, NULL, from, to, passes));
  PetscCall(PetscFree(from));
  PetscCall(PetscFree(to));
  PetscFunctionReturn(0);
}

/* Has the rod grazed a wall on its way: was it in one that it touches neither before nor now,
   deeper than a step may err? What lies between is what the step itself says (its dense output).
 */
static PetscErrorCode Grazes(TS ts, Leg *leg, PetscInt which, PetscReal t0, PetscReal t1, Vec U0,
                             Vec U1, PetscBool *grazes) {
  Rod rod = leg->rod->each[which];
  PetscReal depth, length;
  PetscBool done;
  Graze graze;
  Vec U, U_t, part;

  PetscFunctionBegin;
  PetscCall(GrazeBegin(rod, t0, t1, U0, U1, &graze));
  if (graze.any) {
    PetscCall(RodLength(rod, t1, &length));
    PetscCall(DMGetGlobalVector(leg->rod->da, &U));
    PetscCall(DMGetGlobalVector(leg->rod->da, &U_t));
    for (int k = 1; k <= step_rule.states_between && !*grazes; k++) {
      const PetscReal t = t0 + k * (t1 - t0) / (step_rule.states_between + 1);
      PetscCall(VBDFInterpolate(ts, t, U, U_t, &done));
      PetscCall(RodPartOpenRead(leg->rod, which, U, &part));
      PetscCall(GrazeDepth(rod, t, part, &graze, &depth));
      PetscCall(RodPartCloseRead(leg->rod, which, U, &part));
      *grazes = (PetscBool)(depth > leg->rtol * length);
    }
    PetscCall(DMRestoreGlobalVector(leg->rod->da, &U_t));
    PetscCall(DMRestoreGlobalVector(leg->rod->da, &U));
    PetscCall(RodContactAt(rod, t1));
  }
  PetscCall(GrazeEnd(&graze));
  PetscFunctionReturn(0);
}

/* Has one rod, which is in these states of its own? */
static PetscErrorCode Passes(TS ts, Leg *leg, PetscInt which, PetscReal t0, PetscReal t1, Vec U0,
                             Vec U1, PetscBool *passes) {
  const Rod rod = leg->rod->each[which];

  PetscFunctionBegin;
  if (RodMeetsWalls(rod)) {
    PetscCall(RodPassesWalls(rod, t0, t1, U0, U1, passes));
    if (!*passes) PetscCall(Grazes(ts, leg, which, t0, t1, U0, U1, passes));
  }
  if (RodMeetsStrands(rod) && !leg->rod->at && !*passes) {
    if (rod->model->space)
      PetscCall(PassesItself(rod, t0, t1, U0, U1, passes));
    else
      PetscCall(CrossesItself(rod, t1, U1, passes));
    PetscCallMPI(MPI_Bcast(passes, 1, MPIU_BOOL, 0, rod->comm));
  }
  PetscFunctionReturn(0);
}

/* The nodes of all of several rods in a state, in the laboratory's frame. */
static PetscErrorCode NodesOfAll(Leg *leg, PetscReal t, Vec U, Node *nodes) {
  const Rod all = leg->rod;
  Vec part;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < all->rods; k++) {
    const Rod rod = all->each[k];
    Node *first = nodes + all->at[k];
    PetscCall(RodPartOpenRead(all, k, U, &part));
    PetscCall(rod->model->get(rod, t, part, NULL, first));
    PetscCall(RodPartCloseRead(all, k, U, &part));
    for (Node *node = first; node <= first + rod->last; node++) {
      const PetscReal x[3] = {node->x[0], node->x[1], node->x[2]};
      ScenePlaceToLab(rod->scene, x, node->x);
    }
  }
  PetscFunctionReturn(0);
}

/* Has any of several rods passed through itself or another one? */
static PetscErrorCode PassEachOther(Leg *leg, PetscReal t0, PetscReal t1, Vec U0, Vec U1,
                                    PetscBool *pass) {
  const Rod all = leg->rod;
  PetscInt n = 0, *of;
  Node *from, *to;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(all->last + 1, &of, all->last + 1, &from, all->last + 1, &to));
  PetscCall(NodesOfAll(leg, t0, U0, from));
  PetscCall(NodesOfAll(leg, t1, U1, to));
  for (PetscInt k = 0; k < all->rods; k++) {
    if (SceneRests(all->each[k]->scene, t1)) continue; /* not born yet */
    for (PetscInt i = all->at[k]; i < all->at[k + 1]; i++, n++) {
      of[n] = k;
      from[n] = from[i];
      to[n] = to[i];
    }
  }
  PetscCall(RodPassesItself(n, of, from, to, pass));
  PetscCall(PetscFree3(of, from, to));
  PetscFunctionReturn(0);
}

/*
  GuardPasses - a VBDFCheck: has a rod of a leg passed through itself or a wall between two states,
  or grazed a wall? Collective; what is asked next depends on what all ranks know.
*/
PetscErrorCode GuardPasses(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1, PetscBool *passes) {
  Vec part[2];
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  *passes = PETSC_FALSE;
  for (PetscInt k = 0; k < leg->rod->rods && !*passes; k++) {
    if (SceneRests(leg->rod->each[k]->scene, t1)) continue;
    PetscCall(RodPartOpenRead(leg->rod, k, U0, &part[0]));
    PetscCall(RodPartOpenRead(leg->rod, k, U1, &part[1]));
    PetscCall(Passes(ts, leg, k, t0, t1, part[0], part[1], passes));
    PetscCall(RodPartCloseRead(leg->rod, k, U1, &part[1]));
    PetscCall(RodPartCloseRead(leg->rod, k, U0, &part[0]));
  }
  if (!*passes && leg->rod->at && RodMeetsStrands(leg->rod))
    PetscCall(PassEachOther(leg, t0, t1, U0, U1, passes));
  leg->passes = *passes;
  PetscFunctionReturn(0);
}
