/* The lengths that a scene gives, beside those of the cells that are to see them. */
#ifndef TENDRIL_SCALES_H
#define TENDRIL_SCALES_H

#include "scene/scene.h"

PetscErrorCode ScalesTell(Scene scene, const Mesh *mesh, const char *option, PetscInt given,
                          PetscReal t);

#endif
