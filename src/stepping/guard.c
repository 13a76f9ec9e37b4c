#include "stepping/guard.h"
#include "rod/crossing.h"
#include "rod/passing.h"
#include "stepping/leg.h"

/* Does the rod cross itself? Rank 0 looks, and tells. */
static PetscErrorCode CrossesItself(Rod rod, PetscReal t, Vec U, PetscBool *crosses) {
  const PetscScalar *all;
  PetscInt count = 0;
  PetscMPIInt rank;
  PetscScalar *local;
  VecScatter to_zero;
  Vec v, gathered;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(rod->scene->comm, &rank));
  PetscCall(DMGetGlobalVector(rod->nodes, &v));
  PetscCall(VecGetArray(v, &local));
  PetscCall(rod->model->get(rod, t, U, NULL, (Node *)local));
  PetscCall(VecRestoreArray(v, &local));
  PetscCall(VecScatterCreateToZero(v, &to_zero, &gathered));
  PetscCall(VecScatterBegin(to_zero, v, gathered, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(to_zero, v, gathered, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(gathered, &all));
  if (!rank) PetscCall(RodCrossings(rod->last + 1, (const Node *)all, &count));
  PetscCall(VecRestoreArrayRead(gathered, &all));
  PetscCall(VecDestroy(&gathered));
  PetscCall(VecScatterDestroy(&to_zero));
  PetscCall(DMRestoreGlobalVector(rod->nodes, &v));
  *crosses = (PetscBool)(count > 0);
  PetscCallMPI(MPI_Bcast(crosses, 1, MPIU_BOOL, 0, rod->scene->comm));
  PetscFunctionReturn(0);
}

/*
  GuardPasses - a VBDFCheck: has the rod of a leg passed through itself or a wall between two
  states? Collective; what is asked next depends on what all ranks know.
*/
PetscErrorCode GuardPasses(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1, PetscBool *passes) {
  const Contact *contact;
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  contact = &leg->rod->scene->contact;
  *passes = PETSC_FALSE;
  if (contact->walls.n) PetscCall(RodPassesWalls(leg->rod, t0, t1, U0, U1, passes));
  if (contact->self && !*passes) PetscCall(CrossesItself(leg->rod, t1, U1, passes));
  leg->passes = *passes;
  PetscFunctionReturn(0);
}
