/* What may be changed in a run, from a time on. */
#ifndef TENDRIL_CHANGE_H
#define TENDRIL_CHANGE_H

#include "scene/scene.h"

PetscErrorCode SceneMayChange(Scene scene, const char *name, PetscReal t);
PetscErrorCode SceneChange(Scene scene, const char *name, PetscReal t);

#endif
