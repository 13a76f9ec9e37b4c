#include "rod/learned.h"

/*
  Moves the places of a state into line with its angles and moments on the mesh that it is
  on. Collective; no effect on models without equations for that alone.

  What the shape itself says of a place is not what the cells make of its angles, by their error.
  That a first step would put right, however short it is: at a speed that is the error over the
  step, against which friction presses the rod together, and it gives way. In steps that become
  shorter that does not become less. (Moments and forces may be off: nothing holds them back.)
*/
static PetscErrorCode Fit(Rod rod, PetscReal t, Vec U) {
  const PetscInt fields = rod->model->fields, places = RodDims(rod->model),
                 n = rod->end - rod->first;
  RodState at = {.t = t, .U = U};
  PetscReal *off;
  PetscScalar *u;
  Vec F;

  PetscFunctionBegin;
  if (!rod->model->halves[0]) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(n, &off));
  PetscCall(VecDuplicate(U, &at.U_t));
  PetscCall(VecDuplicate(U, &F));
  PetscCall(VecZeroEntries(at.U_t));
  PetscCall(rod->model->residual(rod, &at, F));
  for (PetscInt d = 0; d < places; d++) { /* row d of a node: x_d - that of the one before - ... */
    PetscCall(VecGetArray(F, &u));
    for (PetscInt i = 0; i < n; i++) off[i] = i + rod->first > 0 ? u[i * fields + d] : 0;
    PetscCall(VecRestoreArray(F, &u));
    PetscCall(RodSumAlong(rod, n, off));
    PetscCall(VecGetArray(U, &u));
    for (PetscInt i = 0; i < n; i++) u[i * fields + d] -= off[i];
    PetscCall(VecRestoreArray(U, &u));
  }
  PetscCall(VecDestroy(&at.U_t));
  PetscCall(VecDestroy(&F));
  PetscCall(PetscFree(off));
  PetscFunctionReturn(0);
}

/* RodBegin - the state that a rod starts in: the scene's initial shape, on the rod's mesh; where
   the tip is held as it is, for then that is given, too, and moments give way. Collective. */
PetscErrorCode RodBegin(Rod rod, Vec U) {
  Node *nodes;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(rod->end - rod->first, &nodes));
  PetscCall(RodInitialNodes(rod, 0, nodes));
  PetscCall(rod->model->set(rod, 0, nodes, U));
  PetscCall(PetscFree(nodes));
  if (rod->learned) PetscCall(LearnedBegin(rod, U));
  if (rod->scene->tip.type == TIP_FREE) PetscCall(Fit(rod, 0, U));
  PetscFunctionReturn(0);
}
