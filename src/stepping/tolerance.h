/* The tolerance of steps follows the estimate of the errors. */
#ifndef TENDRIL_TOLERANCE_H
#define TENDRIL_TOLERANCE_H

#include "stepping/estimate.h"

void ToleranceFollow(Ease *ease, const PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN]);

#endif
