#include "rod/rod.h"

/* The sums from the clamp on of `width` numbers of each owned node. Collective. */
static PetscErrorCode SumAlong(Rod rod, PetscInt width, PetscReal *of) {
  const PetscInt n = rod->end - rod->first;
  PetscReal *one;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &one));
  for (PetscInt d = 0; d < width; d++) {
    for (PetscInt i = 0; i < n; i++) one[i] = of[i * width + d];
    PetscCall(RodSumAlong(rod, n, one));
    for (PetscInt i = 0; i < n; i++) of[i * width + d] = one[i];
  }
  PetscCall(PetscFree(one));
  PetscFunctionReturn(0);
}

/* By what each turn fails its cell, off, and the largest of that. F is the residual at u. */
static PetscErrorCode TurnsOff(Rod rod, const PetscScalar *u, const PetscScalar *F, PetscReal *off,
                               PetscReal *most) {
  const PetscInt fields = rod->model->fields;

  PetscFunctionBegin;
  *most = 0;
  for (PetscInt i = 0; i < rod->end - rod->first; i++) {
    PetscReal *own = off + i * TURN;
    for (int k = 0; k < TURN; k++) own[k] = 0;
    if (i + rod->first > 0) rod->model->turn_off(u + i * fields, F + i * fields, own);
    for (int k = 0; k < TURN; k++) *most = LargerSize(*most, PetscAbsReal(own[k]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPIU_REAL, MPI_MAX, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* Turns the nodes, with their moments and forces, until the cells find these moments between them,
   to round-off. Turned as a whole a rod obeys its cells as before;
   so each cell is put right by itself, and what lies behind it goes along. */
static PetscErrorCode FitTurns(Rod rod, RodState *at, Vec F) {
  const PetscInt fields = rod->model->fields, n = rod->end - rod->first;
  PetscReal *off, most, before = PETSC_MAX_REAL;
  const PetscScalar *r;
  PetscScalar *u;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n * TURN, &off));
  for (;; before = most) {
    PetscCall(rod->model->residual(rod, at, F));
    PetscCall(VecGetArray(at->U, &u));
    PetscCall(VecGetArrayRead(F, &r));
    PetscCall(TurnsOff(rod, u, r, off, &most));
    PetscCall(VecRestoreArrayRead(F, &r));
    if (most < before / 2) {
      PetscCall(SumAlong(rod, TURN, off));
      for (PetscInt i = 0; i < n; i++) rod->model->turn(off + i * TURN, u + i * fields);
    }
    PetscCall(VecRestoreArray(at->U, &u));
    if (!(most < before / 2)) break;
  }
  PetscCall(PetscFree(off));
  PetscFunctionReturn(0);
}

/* Moves the places of a state into line with its angles. */
static PetscErrorCode FitPlaces(Rod rod, RodState *at, Vec F) {
  const PetscInt fields = rod->model->fields, places = rod->model->space ? 3 : 2,
                 n = rod->end - rod->first;
  const PetscScalar *r;
  PetscScalar *u;
  PetscReal *off;

  PetscFunctionBegin;
  PetscCall(rod->model->residual(rod, at, F));
  PetscCall(PetscCalloc1(n * places, &off));
  PetscCall(VecGetArrayRead(F, &r));
  for (PetscInt i = rod->first > 0 ? 0 : 1; i < n; i++) /* row d: x_d - that before - ... */
    PetscCall(PetscArraycpy(off + i * places, r + i * fields, places));
  PetscCall(VecRestoreArrayRead(F, &r));
  PetscCall(SumAlong(rod, places, off));
  PetscCall(VecGetArray(at->U, &u));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt d = 0; d < places; d++) u[i * fields + d] -= off[i * places + d];
  PetscCall(VecRestoreArray(at->U, &u));
  PetscCall(PetscFree(off));
  PetscFunctionReturn(0);
}

/*
  RodRests - does a rod lie as it is bent by nature, free of any stress, and does nothing act on it?
  Its moments and forces are round-off then, and become 0. Collective.

  at  a state, with rates of 0; its U is changed
*/
PetscErrorCode RodRests(Rod rod, const RodState *at, PetscBool *rests) {
  const PetscReal round_off = 16 * PETSC_MACHINE_EPSILON;
  const PetscInt fields = rod->model->fields, n = rod->end - rod->first;
  PetscReal size[MAX_FIELDS], off[MAX_FIELDS];
  PetscScalar *u;
  Vec F;

  PetscFunctionBegin;
  *rests = PETSC_FALSE;
  if (!rod->model->turn) PetscFunctionReturn(0);
  PetscCall(VecGetArray(at->U, &u));
  for (PetscInt i = 0; i < n * fields; i++)
    if (!rod->model->followed[i % fields]) u[i] = 0;
  PetscCall(VecRestoreArray(at->U, &u));
  PetscCall(VecDuplicate(at->U, &F));
  PetscCall(rod->model->residual(rod, at, F));
  PetscCall(RodFieldSizes(rod, F, off));
  PetscCall(VecDestroy(&F));
  PetscCall(RodFieldSizes(rod, at->U, size));
  if (rod->model->scale) rod->model->scale(size);
  *rests = PETSC_TRUE;
  for (PetscInt f = 0; f < fields; f++)
    if (!(off[f] <= round_off * size[f])) *rests = PETSC_FALSE;
  PetscFunctionReturn(0);
}

/* If a rod, on the mesh that it is on, lies as it is bent by nature, wherever its tip is
   then, and nothing acts on it: puts it there. */
static PetscErrorCode Lies(Rod rod, Vec U, PetscBool *lies) {
  Tip *tip = &rod->scene->tip;
  const TipType type = tip->type;
  RodState at = {.t = 0};
  Vec F, fitted;

  PetscFunctionBegin;
  *lies = PETSC_FALSE;
  if (!rod->model->turn) PetscFunctionReturn(0);
  tip->type = TIP_FREE; /* it is to be held there */
  PetscCall(VecDuplicate(U, &at.U));
  PetscCall(VecDuplicate(U, &at.U_t));
  PetscCall(VecDuplicate(U, &fitted));
  PetscCall(VecDuplicate(U, &F));
  PetscCall(VecCopy(U, at.U));
  PetscCall(VecZeroEntries(at.U_t));
  PetscCall(FitTurns(rod, &at, F));
  PetscCall(FitPlaces(rod, &at, F));
  PetscCall(VecCopy(at.U, fitted));
  PetscCall(RodRests(rod, &at, lies));
  if (*lies) PetscCall(VecCopy(fitted, U));
  PetscCall(VecDestroy(&at.U));
  PetscCall(VecDestroy(&at.U_t));
  PetscCall(VecDestroy(&fitted));
  PetscCall(VecDestroy(&F));
  tip->type = type;
  PetscFunctionReturn(0);
}

/*
  RodBegin - the state that a rod starts in: the scene's initial shape, on the rod's mesh; where the
  tip is held as it is, for then that is given, too, and moments give way. Collective.

  What the shape itself says of a place is not what the cells make of its angles, by their error.
  That a first step would put right, however short it is: at a speed that is the error over the
  step, against which friction presses the rod together, and it gives way. In steps that become
  shorter that does not become less. (Moments and forces may be off: nothing holds them back.)

  Nor is what it says of an angle what the cells make of natural bends. Where friction holds the
  places moments give way to that: a rod at rest would be under those that the mesh's error makes,
  and bear an energy where it has none. So a rod that lies as it is bent by nature is that of its
  mesh altogether.
*/
PetscErrorCode RodBegin(Rod rod, Vec U) {
  RodState at = {.t = 0, .U = U};
  PetscBool lies;
  Node *nodes;
  Vec F;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(rod->end - rod->first, &nodes));
  PetscCall(RodInitialNodes(rod, 0, nodes));
  PetscCall(rod->model->set(rod, 0, nodes, U));
  PetscCall(PetscFree(nodes));
  PetscCall(Lies(rod, U, &lies));
  if (lies || !rod->model->turn || rod->scene->tip.type != TIP_FREE) PetscFunctionReturn(0);
  PetscCall(VecDuplicate(U, &at.U_t));
  PetscCall(VecDuplicate(U, &F));
  PetscCall(VecZeroEntries(at.U_t));
  PetscCall(FitPlaces(rod, &at, F));
  PetscCall(VecDestroy(&at.U_t));
  PetscCall(VecDestroy(&F));
  PetscFunctionReturn(0);
}
