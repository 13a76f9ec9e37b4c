#include "rod/grazing.h"
#include "rod/feet.h"
#include "rod/passing.h"
#include "rod/rules.h"

/* A wall that is touched somewhere: which one, and how deep. */
typedef struct {
  PetscInt wall;
  PetscReal depth;
} Dent;

enum { MOST_DENTS = MOST_TOUCHES };

static PetscInt CountWalls(const Contact *contact) {
  return contact->walls.n + contact->surfaces.n;
}

/* Do walls move? */
static PetscBool WallsMove(const Contact *contact) {
  for (PetscInt k = 0; k < contact->surfaces.n; k++)
    if (contact->surfaces.surface[k].motion.any) return PETSC_TRUE;
  return contact->walls.move;
}

/* Where an owned node is: the first fields of a rod that can touch. */
static void PlaceOf(Rod rod, const PetscScalar *u, PetscInt k, PetscReal x[3]) {
  for (int d = 0; d < 3; d++)
    x[d] = d < RodDims(rod->model) ? PetscRealPart(u[k * rod->model->fields + d]) : 0;
}

/* The gap of a place to the nearest wall, if it is below `within`; else that. */
static PetscReal GapOf(Rod rod, const PetscReal x[3], PetscReal within) {
  return ContactGap(RodDims(rod->model), &rod->scene->contact, x, within);
}

/* Which walls a node is in touch with; returns how many. */
static PetscInt DentsOf(Rod rod, const PetscReal x[3], Dent dent[MOST_DENTS]) {
  Touch touch[MOST_TOUCHES];
  PetscInt n = ContactTouches(RodDims(rod->model), &rod->scene->contact, x, touch);

  for (PetscInt k = 0; k < n; k++) dent[k] = (Dent){touch[k].wall, -touch[k].gap};
  return n;
}

/* Marks a wall that is touched, or tells how deep in one that is not marked. */
static void NoteWall(const Graze *graze, PetscInt wall, PetscReal deep, PetscReal *depth) {
  if (!depth)
    graze->wall[wall] = 1;
  else if (!graze->wall[wall])
    *depth = PetscMax(*depth, deep);
}

/* Marks the walls that feet are on in a state, or tells how deep they are in the others: depth
   NULL, or that. */
static PetscErrorCode LookAtFeet(Rod rod, PetscReal t, Vec U, const Graze *graze,
                                 PetscReal *depth) {
  const PetscInt n = PetscMin(rod->end, rod->last) - rod->first;
  const Contact *contact = &rod->scene->contact;
  FootCell *cell;
  Feet feet;

  PetscFunctionBegin;
  if (!contact->thin) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(n, &cell));
  PetscCall(RodFootCells(rod, t, U, n, cell));
  for (PetscInt k = 0; k < n; k++) {
    FeetFind(contact, &cell[k], depth ? 0 : contact->smooth, &feet);
    for (PetscInt j = 0; j < feet.n; j++)
      NoteWall(graze, feet.touch[j].wall, -feet.touch[j].gap, depth);
  }
  PetscCall(PetscFree(cell));
  PetscFunctionReturn(0);
}

/* The same of a state at its nodes and feet: depth NULL, or that at nodes which may have grazed.
   Collective; the law of contact is that of t on exit. */
static PetscErrorCode LookAt(Rod rod, PetscReal t, Vec U, const Graze *graze, PetscReal *depth) {
  const PetscScalar *u;
  Dent dent[MOST_DENTS];
  PetscReal x[3];

  PetscFunctionBegin;
  PetscCall(SceneContactAt(rod->scene, t));
  PetscCall(VecGetArrayRead(U, &u));
  for (PetscInt k = 0; k < rod->end - rod->first; k++) {
    PetscInt n;
    if (depth && !graze->node[k]) continue;
    PlaceOf(rod, u, k, x);
    n = DentsOf(rod, x, dent);
    for (PetscInt j = 0; j < n; j++) NoteWall(graze, dent[j].wall, dent[j].depth, depth);
  }
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscCall(LookAtFeet(rod, t, U, graze, depth));
  PetscFunctionReturn(0);
}

/* Which nodes may have grazed a wall? A gap changes by no more than the way of the place: so it
   may where that is longer than the gaps at both its ends together. Collective. */
static PetscErrorCode AskNodes(Rod rod, PetscReal t1, Vec U0, Vec U1, Graze *graze) {
  const PetscBool move = WallsMove(&rod->scene->contact);
  const PetscScalar *u0, *u1;
  PetscReal x0[3], x1[3];
  int any = 0;

  PetscFunctionBegin;
  PetscCall(SceneContactAt(rod->scene, t1));
  PetscCall(VecGetArrayRead(U0, &u0));
  PetscCall(VecGetArrayRead(U1, &u1));
  for (PetscInt k = 0; k < rod->end - rod->first; k++) {
    PetscReal way, gap;
    PlaceOf(rod, u0, k, x0);
    PlaceOf(rod, u1, k, x1);
    way = rod_rule.way_round * hypot(hypot(x1[0] - x0[0], x1[1] - x0[1]), x1[2] - x0[2]);
    gap = move ? 0 : GapOf(rod, x1, way);
    if (gap < way && !move) gap += PetscMax(0, GapOf(rod, x0, way));
    graze->node[k] = (char)(move || gap < way);
    any = any || graze->node[k];
  }
  PetscCall(VecRestoreArrayRead(U1, &u1));
  PetscCall(VecRestoreArrayRead(U0, &u0));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, rod->scene->comm));
  graze->any = (PetscBool)any;
  PetscFunctionReturn(0);
}

/* Are there walls of which nothing is known to touch them? Collective. */
static PetscErrorCode SomeAreFree(Rod rod, Graze *graze) {
  const PetscInt n = CountWalls(&rod->scene->contact);
  PetscMPIInt count;

  PetscFunctionBegin;
  PetscCall(PetscMPIIntCast(n, &count));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, graze->wall, count, MPI_CHAR, MPI_MAX, rod->scene->comm));
  graze->any = PETSC_FALSE;
  for (PetscInt k = 0; k < n; k++) graze->any = (PetscBool)(graze->any || !graze->wall[k]);
  PetscFunctionReturn(0);
}

/*
  GrazeBegin - where may a rod have touched a wall on its way from one state to another, that it
  touches in neither? Collective; the caller ends it with GrazeEnd(). The law of contact is that of
  t1 on exit.

  t0, U0  before      t1, U1  now
*/
PetscErrorCode GrazeBegin(Rod rod, PetscReal t0, PetscReal t1, Vec U0, Vec U1, Graze *graze) {
  PetscFunctionBegin;
  PetscCall(PetscCalloc2(rod->end - rod->first, &graze->node, CountWalls(&rod->scene->contact),
                         &graze->wall));
  PetscCall(AskNodes(rod, t1, U0, U1, graze));
  if (!graze->any) PetscFunctionReturn(0);
  PetscCall(LookAt(rod, t0, U0, graze, NULL));
  PetscCall(LookAt(rod, t1, U1, graze, NULL));
  PetscCall(SomeAreFree(rod, graze));
  PetscFunctionReturn(0);
}

/* GrazeDepth - how deep a rod is, at most, in walls that it touches neither before nor now, in a
   state between; 0: in none. Collective; the law of contact is that of t on exit. */
PetscErrorCode GrazeDepth(Rod rod, PetscReal t, Vec U, const Graze *graze, PetscReal *depth) {
  PetscFunctionBegin;
  *depth = 0;
  PetscCall(LookAt(rod, t, U, graze, depth));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, depth, 1, MPIU_REAL, MPI_MAX, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* GrazeEnd - gives back what GrazeBegin() took. */
PetscErrorCode GrazeEnd(Graze *graze) {
  PetscFunctionBegin;
  PetscCall(PetscFree2(graze->node, graze->wall));
  PetscFunctionReturn(0);
}
