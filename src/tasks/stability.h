/* -task stability: how fast small deflections of the straight rod grow or decay. */
#ifndef TENDRIL_STABILITY_H
#define TENDRIL_STABILITY_H

#include "scene/scene.h"

extern const OptionGroup stability_options;

PetscErrorCode StabilityRun(Scene scene, const char *output);
PetscErrorCode StabilitySlowestMode(Scene scene, PetscInt *n, PetscReal **s, PetscReal **theta);

#endif
