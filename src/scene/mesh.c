#include "scene/mesh.h"

/* The part of the nodes spread evenly over s whatever the growth, so that no part of the initial
   rod is left without. */
static const PetscReal even_share = 0.5;

/*
  MeshCreate - places the nodes.

  cells     N
  graded    nodes equidistant in int (g(s,T)/L(T) + even_share) ds, else in s
  end_time  T
  mesh      the caller destroys it with MeshDestroy()

  The map is inverted by bisection on the exact arc length, so any width of growth zone is met.
*/
PetscErrorCode MeshCreate(PetscInt cells, PetscBool graded, Growth growth, PetscReal end_time,
                          Mesh *mesh) {
  PetscReal length = 1;

  PetscFunctionBegin;
  mesh->cells = cells;
  PetscCall(PetscMalloc1(cells + 1, &mesh->s));
  graded = (PetscBool)(graded && !growth->even);
  if (graded) PetscCall(GrowthLength(growth, end_time, &length, NULL));
  for (PetscInt i = 0; i <= cells; i++) {
    PetscReal goal = (PetscReal)i / cells, lo = i ? mesh->s[i - 1] : 0, hi = 1, p;
    if (!graded || i == 0 || i == cells) {
      mesh->s[i] = goal;
      continue;
    }
    for (PetscInt k = 0; k < 60 && hi - lo > 1e-17; k++) {
      PetscReal mid = (lo + hi) / 2;
      PetscCall(GrowthArc(growth, 1, &mid, end_time, &p, NULL));
      if (p / length + even_share * mid > goal * (1 + even_share))
        hi = mid;
      else
        lo = mid;
    }
    mesh->s[i] = (lo + hi) / 2;
  }
  PetscFunctionReturn(0);
}

PetscErrorCode MeshDestroy(Mesh *mesh) {
  PetscFunctionBegin;
  PetscCall(PetscFree(mesh->s));
  PetscFunctionReturn(0);
}
