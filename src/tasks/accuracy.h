/* One knob for model, mesh and tolerances. */
#ifndef TENDRIL_ACCURACY_H
#define TENDRIL_ACCURACY_H

#include "rod/rod.h"

extern const OptionGroup accuracy_options;

PetscErrorCode AccuracyApply(void);
PetscErrorCode AccuracyEstimate(Rod rod, PetscReal t, PetscReal rtol, PetscReal folds,
                                PetscReal *error);

#endif
