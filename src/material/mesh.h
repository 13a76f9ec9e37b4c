/* The nodes of the rod: N cells in the material label s, graded where growth concentrates. Where
   another rod is joined to it, a node is there twice, with a cell of width 0 between. */
#ifndef TENDRIL_MESH_H
#define TENDRIL_MESH_H

#include "material/growth.h"

typedef struct {
  PetscInt cells;
  PetscReal *s;     /* cells + 1 nodes from 0 to 1, the same on every rank */
  PetscInt doubles; /* so many are there twice */
} Mesh;

PetscErrorCode MeshCreate(PetscInt cells, PetscBool graded, Growth growth, PetscReal end_time,
                          Mesh *mesh);
PetscErrorCode MeshDouble(Mesh *mesh, PetscReal s, PetscInt *node);
PetscErrorCode MeshNextDouble(Mesh *mesh, PetscInt from, PetscInt *node);
PetscErrorCode MeshDestroy(Mesh *mesh);

#endif
