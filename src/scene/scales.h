/* The lengths that a scene gives, beside those of the cells that are to see them. */
#ifndef TENDRIL_SCALES_H
#define TENDRIL_SCALES_H

#include "scene/scene.h"

/* A length that the cells are too long for. */
typedef struct {
  const char *option;
  PetscReal length;   /* of what is to be seen */
  PetscReal cell;     /* longest cell that is to see it, at a time */
  PetscReal resolved; /* it does if it is shorter than this part of the length */
} Scale;
enum { MOST_SCALES = 8 };

PetscErrorCode ScalesMissed(Scene scene, const Mesh *mesh, PetscReal t, PetscInt *n,
                            Scale scale[MOST_SCALES]);
PetscErrorCode ScalesTell(Scene scene, const Mesh *mesh, PetscReal t);

#endif
