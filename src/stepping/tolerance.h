/* The tolerance of steps follows the estimate of the errors. */
#ifndef TENDRIL_TOLERANCE_H
#define TENDRIL_TOLERANCE_H

#include "stepping/estimate.h"

void ToleranceFollow(PetscReal rtol, const PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN],
                     Ease *ease);

#endif
