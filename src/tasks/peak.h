/* What is below 0 wherever it was looked at may be above in between: the peak of three places of
   which the one in the middle stands out. */
#ifndef TENDRIL_PEAK_H
#define TENDRIL_PEAK_H

#include <petscsys.h>

/* A number at a time, below 0 while the rod is stable. */
typedef PetscErrorCode (*PeakLevel)(void *of, PetscReal t, PetscReal *level);

typedef struct {
  PetscReal t, level;
} PeakPlace;

PetscErrorCode PeakFind(PeakLevel level, void *of, const PeakPlace at[3], PeakPlace across[2],
                        PetscBool *above);

#endif
