/* How far a run has gone astray: its errors in time and in space, of friction that is taken for
   exact and of contact that is not rigid, measured on the way and carried along by the linearised
   equations. */
#ifndef TENDRIL_ESTIMATE_H
#define TENDRIL_ESTIMATE_H

#include "stepping/leg.h"

typedef struct _Estimate *Estimate;

enum { ESTIMATE_SPACE, ESTIMATE_TIME, ESTIMATE_LIMIT, ESTIMATE_SOFT, ESTIMATE_PARTS };
enum { ESTIMATE_TIP, ESTIMATE_NORM, ESTIMATE_ENERGY, ESTIMATE_SEEN };

/* What is kept of it for a restart: what is counted, numbers, and errors as states of the rod. */
enum {
  ESTIMATE_COUNTS = 4,
  ESTIMATE_NUMBERS = 2 + 3 * MIRRORS + (1 + ESTIMATE_PARTS) * ESTIMATE_SEEN
};
enum { ESTIMATE_MEMORY = ESTIMATE_COUNTS + ESTIMATE_NUMBERS, ESTIMATE_KEPT = ESTIMATE_PARTS + 2 };

/* How far off a run may be: in each of what is seen, by each of the parts, and in all. */
typedef struct {
  enum { ESTIMATE_NONE, ESTIMATE_MEASURED, ESTIMATE_FITTED } kind;
  PetscReal all, part[ESTIMATE_PARTS], seen[ESTIMATE_SEEN];
} ErrorEstimate;

PetscErrorCode EstimateCreate(Leg *leg, Estimate *estimate);
PetscErrorCode EstimateDestroy(Estimate *estimate);
PetscErrorCode EstimateStep(Estimate estimate, PetscBool jumped, PetscBool touches);
PetscErrorCode EstimateTold(Estimate estimate, PetscReal told[ESTIMATE_PARTS][ESTIMATE_SEEN]);
PetscErrorCode EstimateGet(Estimate estimate, PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN]);
PetscErrorCode EstimateSet(Estimate estimate, PetscReal t,
                           const PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN]);
PetscErrorCode EstimateVectors(Estimate estimate, Vec errors[ESTIMATE_KEPT]);
PetscErrorCode EstimateKeep(Estimate estimate, PetscReal memory[ESTIMATE_MEMORY],
                            Vec errors[ESTIMATE_KEPT]);
PetscErrorCode EstimateTake(Estimate estimate, const PetscReal memory[ESTIMATE_MEMORY],
                            Vec errors[ESTIMATE_KEPT]);

#endif
