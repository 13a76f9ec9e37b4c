#include "stepping/guard.h"
#include "rod/crossing.h"
#include "stepping/leg.h"

/* How deep in a wall no rod can be: behind half of what the wall is made of, or half its own
   thickness. */
static PetscReal TooDeep(const Contact *contact) {
  const PetscReal nowhere = 1e300, half = contact->diameter / 2,
                  stone = contact->walls.smallest / 2;
  PetscReal deep = nowhere;

  if (half > 0) deep = half;
  if (stone > 0) deep = PetscMin(deep, stone);
  return deep;
}

/* Is a point inside a wall, or was it on the way? */
static PetscBool InWall(const Contact *contact, const PetscReal x0[2], const PetscReal x1[2]) {
  enum { MOST = 1000 };
  const PetscReal deep = TooDeep(contact), way = hypot(x1[0] - x0[0], x1[1] - x0[1]);
  PetscInt n = (PetscInt)PetscMin(MOST, PetscCeilReal(2 * way / deep));
  Touch touch[MOST_TOUCHES];

  for (PetscInt k = 1; k <= PetscMax(n, 1); k++) {
    PetscReal z = (PetscReal)k / PetscMax(n, 1), x[2];
    for (int d = 0; d < 2; d++) x[d] = x0[d] + z * (x1[d] - x0[d]);
    if (WallsTouch(&contact->walls, x, contact->diameter / 2, -deep, touch) > 0) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Has one of the nodes passed through a wall? */
static PetscErrorCode PassesWall(Rod rod, PetscReal t0, PetscReal t1, Vec U0, Vec U1,
                                 PetscBool *passes) {
  PetscInt n = rod->end - rod->first;
  Node *from, *to;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &from, n, &to));
  PetscCall(rod->model->get(rod, t0, U0, NULL, from));
  PetscCall(rod->model->get(rod, t1, U1, NULL, to));
  for (PetscInt k = 0; k < n && !*passes; k++)
    *passes = InWall(&rod->scene->contact, from[k].x, to[k].x);
  PetscCall(PetscFree2(from, to));
  PetscFunctionReturn(0);
}

/* Does the rod cross itself? Rank 0 looks. */
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
  PetscFunctionReturn(0);
}

/*
  GuardPasses - a VBDFCheck: has the rod of a leg passed through itself or a wall between two
  states? Collective.
*/
PetscErrorCode GuardPasses(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1, PetscBool *passes) {
  const Contact *contact;
  int any;
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  contact = &leg->rod->scene->contact;
  *passes = PETSC_FALSE;
  if (contact->walls.n && TooDeep(contact) < 1e299)
    PetscCall(PassesWall(leg->rod, t0, t1, U0, U1, passes));
  if (contact->self) PetscCall(CrossesItself(leg->rod, t1, U1, passes));
  any = *passes;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, leg->rod->scene->comm));
  *passes = (PetscBool)any;
  leg->passes = *passes;
  PetscFunctionReturn(0);
}
