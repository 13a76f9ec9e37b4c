#include "rod/passing.h"
#include "rod/directors.h"

/* RodFootCells - the cells that begin at owned nodes, n of them, in one state; without their rates.
   Collective. */
PetscErrorCode RodFootCells(Rod rod, PetscReal t, Vec U, PetscInt n, FootCell cell[]) {
  const PetscReal *s = rod->scene->mesh.s;
  const int dims = RodDims(rod->model);
  const Node *with;
  Vec local;

  PetscFunctionBegin;
  PetscCall(RodGetLocalNodes(rod, t, U, &local, &with));
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt i = rod->first + k;
    CurveCell *curve = &cell[k].curve;
    PetscCall(PetscMemzero(&cell[k], sizeof(cell[k])));
    cell[k].dims = dims;
    curve->h = s[i + 1] - s[i];
    cell[k].first = (PetscBool)(i == 0);
    cell[k].last = (PetscBool)(i == rod->last - 1);
    PetscCall(GrowthStretch(rod->scene->growth, 2, &s[i], t, curve->g, NULL, NULL));
    for (int e = 0; e < 2; e++) {
      const Node *node = &with[i + e];
      PetscReal d[3][3];
      for (int c = 0; c < dims; c++) curve->x[e][c] = node->x[c];
      if (dims == 2) {
        curve->q[e][0] = PetscCosReal(node->theta);
        curve->q[e][1] = PetscSinReal(node->theta);
        continue;
      }
      Directors(node->p, QuaternionSize(node->p), d);
      for (int c = 0; c < 3; c++) curve->q[e][c] = d[0][c];
    }
  }
  PetscCall(RodRestoreLocalNodes(rod, &local, &with));
  PetscFunctionReturn(0);
}

/* RodRefuseFeet - a user's mistake, if a cell has more feet than are looked at. Collective. */
PetscErrorCode RodRefuseFeet(Rod rod, PetscReal t, PetscBool crowded) {
  PetscFunctionBegin;
  UserCheck(
      !crowded, rod->scene->comm,
      "-wall_file: at t = %g %d posts or corners or more touch one cell of the rod: take more "
      "-rod_cells, or one wall in place of them",
      (double)t, (int)MOST_FEET);
  PetscFunctionReturn(0);
}

/* Does more touch the rod anywhere than is looked at? A user's mistake. Collective. */
static PetscErrorCode RefuseCrowds(Rod rod, PetscReal t, const Passing *passing) {
  const Contact *contact = &rod->scene->contact;
  const int dims = RodDims(rod->model);
  const PetscInt most = dims == 3 ? MOST_SURFACES : MOST_WALL_TOUCHES;
  enum { CROWDED, FEET, CROWDS };
  int crowds[CROWDS] = {0};
  Touch touch[MOST_TOUCHES];
  Feet feet = {.n = 0};

  PetscFunctionBegin;
  for (PetscInt k = 0; k < passing->n; k++) {
    const FootCell *cell = &passing->now[k];
    if (ContactTouches(dims, contact, cell->curve.x[1], touch) >= most) crowds[CROWDED] = 1;
    if (contact->thin) FeetFind(contact, cell, contact->smooth, &feet);
    if (feet.n == MOST_FEET) crowds[FEET] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, crowds, CROWDS, MPI_INT, MPI_MAX, rod->scene->comm));
  UserCheck(
      !crowds[CROWDED], rod->scene->comm,
      "-wall_file: at t = %g %d walls or more touch the rod at one place: take out those that "
      "lie on each other",
      (double)t, (int)most);
  PetscCall(RodRefuseFeet(rod, t, (PetscBool)crowds[FEET]));
  PetscFunctionReturn(0);
}

/*
  RodPassesWalls - has a rod gone through a wall on its way from one state to another, or is it
  behind one? Collective; the same on every rank. Where it has not, and more walls touch than are
  looked at, a user's mistake.

  t0, U0  before      t1, U1  now
*/
PetscErrorCode RodPassesWalls(Rod rod, PetscReal t0, PetscReal t1, Vec U0, Vec U1,
                              PetscBool *passes) {
  Passing passing = {.t0 = t0, .n = PetscMin(rod->end, rod->last) - rod->first};

  PetscFunctionBegin;
  if (rod->model->space || rod->scene->contact.walls.move)
    PetscCall(SceneContactAt(rod->scene, t1));
  PetscCall(PetscMalloc2(passing.n, &passing.before, passing.n, &passing.now));
  PetscCall(RodFootCells(rod, t0, U0, passing.n, passing.before));
  PetscCall(RodFootCells(rod, t1, U1, passing.n, passing.now));
  PetscCall((rod->model->space ? PassingTellSpace : PassingTellPlane)(rod, &passing, passes));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, passes, 1, MPIU_BOOL, MPI_LOR, rod->scene->comm));
  if (!*passes) PetscCall(RefuseCrowds(rod, t1, &passing));
  PetscCall(PetscFree2(passing.before, passing.now));
  PetscFunctionReturn(0);
}
