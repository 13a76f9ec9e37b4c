/* Monotone cubic curves through tables (Fritsch and Butland; scipy's PchipInterpolator): smooth,
   and nowhere beyond the entries on both sides. */
#ifndef TENDRIL_MONOTONE_H
#define TENDRIL_MONOTONE_H

#include <petscsys.h>

void MonotoneSlopes(PetscInt n, const PetscReal x[], const PetscReal f[], PetscReal slope[]);
PetscReal MonotoneRate(PetscInt n, const PetscReal x[], const PetscReal f[],
                       const PetscReal slope[], PetscReal at);
PetscReal MonotoneValue(PetscInt n, const PetscReal x[], const PetscReal f[],
                        const PetscReal slope[], PetscReal at);

#endif
