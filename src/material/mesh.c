#include "material/mesh.h"

/* The part of the nodes spread evenly over s whatever the growth, so that no part of the initial
   rod is left without. */
static const PetscReal even_share = 0.5;
/* A growth zone at the tip gets this part of the nodes besides, densest at the tip itself and
   fading over twice its length. */
static const PetscReal zone_share = 1. / 3;

/* From a growth zone at the clamp that is narrower than this, in s, to the rest of the rod cells
   become larger by little from one to the next: this part of the nodes sees to that. Without them a
   cell behind the zone is as long as many zones, and its growth is missed. */
static const PetscReal narrow = 0.02, graded_share = 0.75;

/* What the nodes are equidistant in, from 0 to its value at s = 1. */
static PetscErrorCode Measure(Growth growth, PetscReal s, PetscReal end_time, PetscReal length,
                              PetscReal *m) {
  PetscReal p, u;

  PetscFunctionBegin;
  *m = s;
  if (growth->finest > 0) {
    u = PetscMin(1, (1 - s) * length / (2 * PetscMin(growth->finest, length)));
    *m += zone_share * (1 - u) * (1 - u);
  } else if (!growth->even) {
    PetscCall(GrowthArc(growth, 1, &s, end_time, &p, NULL));
    *m = p / length + even_share * s;
    if (growth->narrow > 0 && growth->narrow < narrow)
      *m += graded_share * asinh(s / growth->narrow) / asinh(1 / growth->narrow);
  }
  PetscFunctionReturn(0);
}

/*
  MeshCreate - places the nodes.

  cells     N
  graded    nodes equidistant in int (g(s,T)/L(T) + even_share) ds, or denser in a zone of growth at
            the tip; else in s
  end_time  T
  mesh      the caller destroys it with MeshDestroy()

  The map is inverted by bisection on the exact arc length, so any width of growth zone is met.
*/
PetscErrorCode MeshCreate(PetscInt cells, PetscBool graded, Growth growth, PetscReal end_time,
                          Mesh *mesh) {
  PetscReal length, first, all;

  PetscFunctionBegin;
  mesh->cells = cells;
  mesh->doubles = 0;
  PetscCall(PetscMalloc1(cells + 1, &mesh->s));
  graded = (PetscBool)(graded && (!growth->even || growth->finest > 0));
  PetscCall(GrowthLength(growth, end_time, &length, NULL));
  PetscCall(Measure(growth, 0, end_time, length, &first));
  PetscCall(Measure(growth, 1, end_time, length, &all));
  for (PetscInt i = 0; i <= cells; i++) {
    PetscReal goal = (PetscReal)i / cells, lo = i ? mesh->s[i - 1] : 0, hi = 1, m;
    if (!graded || i == 0 || i == cells) {
      mesh->s[i] = goal;
      continue;
    }
    for (PetscInt k = 0; k < 60 && hi - lo > 1e-17; k++) {
      PetscReal mid = (lo + hi) / 2;
      PetscCall(Measure(growth, mid, end_time, length, &m));
      if (m - first > goal * (all - first))
        hi = mid;
      else
        lo = mid;
    }
    mesh->s[i] = (lo + hi) / 2;
  }
  PetscFunctionReturn(0);
}

/* The node that is to be at a label: one at either end of the cell there that is near enough to be
   moved there, and is not doubled; -1: none. */
static PetscInt Movable(const Mesh *mesh, PetscReal s, PetscInt behind) {
  const PetscReal near = 0.3, *at = mesh->s;

  for (PetscInt i = behind - 1; i <= behind; i++) {
    const PetscBool end = (PetscBool)(i == 0 || i == mesh->cells),
                    doubled = (PetscBool)(!end && (at[i] == at[i - 1] || at[i] == at[i + 1]));
    if (at[i] == s && !doubled) return i;
    if (!end && !doubled && PetscAbsReal(at[i] - s) <= near * (at[behind] - at[behind - 1]))
      return i;
  }
  return -1;
}

/* Puts a node at a label, behind so many. */
static PetscErrorCode Insert(Mesh *mesh, PetscReal s, PetscInt behind) {
  PetscFunctionBegin;
  PetscCall(PetscRealloc((size_t)(mesh->cells + 2) * sizeof(*mesh->s), &mesh->s));
  for (PetscInt i = mesh->cells; i >= behind; i--) mesh->s[i + 1] = mesh->s[i];
  mesh->s[behind] = s;
  mesh->cells++;
  PetscFunctionReturn(0);
}

/*
  MeshDouble - makes a label that of two nodes, unless it is: those that are near are moved there.
  Labels from the least to the largest leave the numbers of nodes as they are.

  node  the first of the two
*/
PetscErrorCode MeshDouble(Mesh *mesh, PetscReal s, PetscInt *node) {
  PetscInt behind = 1, at;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < mesh->cells; i++)
    if (mesh->s[i] == s && mesh->s[i + 1] == s) {
      *node = i;
      PetscFunctionReturn(0);
    }
  while (behind < mesh->cells && mesh->s[behind] < s) behind++;
  at = Movable(mesh, s, behind);
  if (at < 0) {
    PetscCall(Insert(mesh, s, behind));
    at = behind;
  }
  mesh->s[at] = s;
  PetscCall(Insert(mesh, s, at));
  mesh->doubles++;
  *node = at;
  PetscFunctionReturn(0);
}

/* MeshNextDouble - the first of the two nodes at the next label from a node on that is there twice,
   of a mesh that was read: it counts from now on. */
PetscErrorCode MeshNextDouble(Mesh *mesh, PetscInt from, PetscInt *node) {
  PetscFunctionBegin;
  for (*node = from; *node < mesh->cells; ++*node)
    if (mesh->s[*node] == mesh->s[*node + 1]) {
      mesh->doubles++;
      PetscFunctionReturn(0);
    }
  UserCheck(PETSC_FALSE, OptionsComm(),
            "-restart: its rods are not joined where these are; leave -clamp_on and the like out");
}

PetscErrorCode MeshDestroy(Mesh *mesh) {
  PetscFunctionBegin;
  PetscCall(PetscFree(mesh->s));
  PetscFunctionReturn(0);
}
