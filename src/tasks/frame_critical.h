/* -task critical of several rods that stand: by which factor all that loads them is to be
   multiplied until they stop being stable. */
#ifndef TENDRIL_FRAME_CRITICAL_H
#define TENDRIL_FRAME_CRITICAL_H

#include "tasks/single.h"

PetscErrorCode FrameCritical(const Single *asked);

#endif
