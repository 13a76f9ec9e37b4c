#include "base/quaternion.h"
#include "rod/directors.h"
#include "rod/rod.h"

/* Numbers of a node's place, or of what tells its turn: an angle in the plane, a quaternion in
 * space. */
enum { WIDEST = 4 };

/* Where the angle, or the quaternion, of a node stands: behind its places. */
static PetscInt Places(Rod rod) {
  return rod->model->space ? 3 : 2;
}

/* The sums from the clamp on of the first n numbers of each owned node. Collective. */
static PetscErrorCode SumAlong(Rod rod, PetscInt n, PetscReal off[][WIDEST]) {
  const PetscInt nodes = rod->end - rod->first;
  PetscReal *one;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(nodes, &one));
  for (PetscInt d = 0; d < n; d++) {
    for (PetscInt i = 0; i < nodes; i++) one[i] = off[i][d];
    PetscCall(RodSumAlong(rod, nodes, one));
    for (PetscInt i = 0; i < nodes; i++) off[i][d] = one[i];
  }
  PetscCall(PetscFree(one));
  PetscFunctionReturn(0);
}

/* By what the places, or the turns, of the owned nodes fail the cells before them, all cells from
   the clamp on together; most: in one of them. Of p that fails by r, p - r is (1 - r/p) p: turned
   as a whole what lies behind a cell obeys its own as before. Collective. */
static PetscErrorCode FindOff(Rod rod, RodState *at, PetscBool turns, Vec F,
                              PetscReal off[][WIDEST], PetscReal *most) {
  const PetscInt fields = rod->model->fields, n = turns ? rod->model->halves[0] : Places(rod),
                 from = turns ? Places(rod) : 0;
  const PetscScalar *u, *r;

  PetscFunctionBegin;
  *most = 0;
  PetscCall(rod->model->residual(rod, at, F));
  PetscCall(VecGetArrayRead(at->U, &u));
  PetscCall(VecGetArrayRead(F, &r)); /* row d of a node: field d - that of the one before - ... */
  for (PetscInt i = 0; i < rod->end - rod->first; i++) {
    const PetscReal *p = u + i * fields + from, *by = r + i * fields + from;
    for (PetscInt d = 0; d < WIDEST; d++) off[i][d] = 0;
    if (i + rod->first == 0) continue;
    for (PetscInt d = 0; d < n - from; d++) off[i][d] = by[d];
    if (turns && rod->model->space) {
      const PetscReal back[4] = {p[0], -p[1], -p[2], -p[3]}, size = QuaternionSize(p);
      QuaternionTimes(by, back, off[i]);
      for (int d = 0; d < 4; d++) off[i][d] /= size;
    }
    for (PetscInt d = 0; d < n - from; d++) *most = LargerSize(*most, PetscAbsReal(off[i][d]));
  }
  PetscCall(VecRestoreArrayRead(F, &r));
  PetscCall(VecRestoreArrayRead(at->U, &u));
  PetscCall(SumAlong(rod, n - from, off));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPIU_REAL, MPI_MAX, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* Takes that off. */
static PetscErrorCode TakeOff(Rod rod, Vec U, PetscBool turns, PetscReal off[][WIDEST]) {
  const PetscInt fields = rod->model->fields, n = turns ? rod->model->halves[0] : Places(rod),
                 from = turns ? Places(rod) : 0;
  PetscScalar *u;

  PetscFunctionBegin;
  PetscCall(VecGetArray(U, &u));
  for (PetscInt i = 0; i < rod->end - rod->first; i++) {
    PetscReal *p = u + i * fields + from, by[4];
    if (turns && rod->model->space) {
      QuaternionTimes(off[i], p, by);
      for (int d = 0; d < 4; d++) off[i][d] = by[d];
    }
    for (PetscInt d = 0; d < n - from; d++) p[d] -= off[i][d];
  }
  PetscCall(VecRestoreArray(U, &u));
  PetscFunctionReturn(0);
}

/* Moves the turns of a state into line with its moments, or its places with its turns, to round-off
   (places at once: they are not in their own equations). */
static PetscErrorCode Fit(Rod rod, RodState *at, PetscBool turns, Vec F, PetscReal off[][WIDEST]) {
  PetscReal most, before = PETSC_MAX_REAL;

  PetscFunctionBegin;
  for (PetscBool again = PETSC_TRUE; again; before = most) {
    PetscCall(FindOff(rod, at, turns, F, off, &most));
    if (most < before / 2) PetscCall(TakeOff(rod, at->U, turns, off));
    again = (PetscBool)(turns && most < before / 2);
  }
  PetscFunctionReturn(0);
}

/* Does a state bear no moments, but for round-off of those that would make it straight? */
static PetscErrorCode IsUnbent(Rod rod, Vec U, PetscBool *is) {
  const PetscInt moments = rod->model->space ? 3 : 1;
  PetscReal size[MAX_FIELDS];

  PetscFunctionBegin;
  PetscCall(RodFieldSizes(rod, U, size));
  *is = PETSC_TRUE;
  for (PetscInt d = 0; d < moments; d++)
    if (PetscSqr(size[rod->model->halves[0] + d]) > CurvatureRounding(&rod->scene->curvature, 1))
      *is = PETSC_FALSE;
  PetscFunctionReturn(0);
}

/*
  RodBegin - the state that a rod starts in: the scene's initial shape, on the rod's mesh.
  Collective.

  What the shape itself says of a place is not what the cells make of its angles, by their error.
  That a first step would put right, however short it is: at a speed that is the error over the
  step, against which friction presses the rod together, and it gives way. In steps that become
  shorter that does not become less. (Moments and forces may be off: nothing holds them back.) So
  places are moved into line with angles; where the tip is held, for then that is given, too,
  moments give way.

  Nor is what the shape says of an angle what the cells make of natural bends. A rod that lies as it
  is bent by nature, and rests, would bear moments that make up for that, and an energy of the
  mesh's error where there is none. So its angles are moved into line, too; and its tip is held
  where that leaves it, but for one that a path says the place of.
*/
PetscErrorCode RodBegin(Rod rod, Vec U) {
  const Tip *tip = &rod->scene->tip;
  RodState at = {.t = 0, .U = U};
  PetscReal(*off)[WIDEST];
  PetscBool unbent = PETSC_FALSE;
  Node *nodes;
  Vec F;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(rod->end - rod->first, &nodes));
  PetscCall(RodInitialNodes(rod, 0, nodes));
  PetscCall(rod->model->set(rod, 0, nodes, U));
  PetscCall(PetscFree(nodes));
  if (!rod->model->halves[0]) PetscFunctionReturn(0); /* no equations for places and turns alone */
  PetscCall(IsUnbent(rod, U, &unbent));
  if (tip->type != TIP_FREE && (tip->path || !unbent)) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(rod->end - rod->first, &off));
  PetscCall(VecDuplicate(U, &at.U_t));
  PetscCall(VecDuplicate(U, &F));
  PetscCall(VecZeroEntries(at.U_t));
  if (unbent) PetscCall(Fit(rod, &at, PETSC_TRUE, F, off));
  PetscCall(Fit(rod, &at, PETSC_FALSE, F, off));
  PetscCall(VecDestroy(&at.U_t));
  PetscCall(VecDestroy(&F));
  PetscCall(PetscFree(off));
  PetscFunctionReturn(0);
}
