/* A natural strain that is steered: given over time as well as along the rod. */
#ifndef TENDRIL_ACTUATION_H
#define TENDRIL_ACTUATION_H

#include "base/bends.h"
#include "base/options.h"

typedef struct _Actuation *Actuation;

PetscErrorCode ActuationRead(const char *option, const char *file, const char *name, PetscInt n,
                             const PetscReal at[], Actuation *actuation);
PetscErrorCode ActuationDestroy(Actuation *actuation);
void ActuationValue(Actuation actuation, PetscReal at, PetscReal t, PetscReal *k, PetscReal *k_at,
                    PetscReal *k_t);
PetscReal ActuationNextTurn(Actuation actuation, PetscReal t);
PetscBool ActuationJerks(Actuation actuation, PetscReal t0, PetscReal t1);
PetscErrorCode ActuationBends(Actuation actuation, PetscReal tolerance, Bends *bends);
PetscReal ActuationLargest(Actuation actuation);
PetscReal ActuationSteepest(Actuation actuation);

#endif
