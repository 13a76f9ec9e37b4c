/* One knob for model, mesh and tolerances. */
#ifndef TENDRIL_ACCURACY_H
#define TENDRIL_ACCURACY_H

#include "stepping/estimate.h"

enum { FEWEST_EFOLDINGS = 2 }; /* that a run is taken to have */

/* So many times as fine must mesh, steps and contact be, each for its share of an accuracy; 1: it
   is fine enough. */
typedef struct {
  PetscReal cells, steps, stiffness;
} AccuracyNeeds;

extern const OptionGroup accuracy_options;

PetscErrorCode AccuracyApply(void);
PetscErrorCode AccuracyTolerance(void);
PetscReal AccuracyTimes(int part);
PetscReal AccuracyBeyond(PetscBool strands, PetscBool front);
void AccuracyMeasured(const PetscReal least[ESTIMATE_SEEN],
                      PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN], PetscReal beside,
                      PetscReal beyond, Errors *error);
AccuracyNeeds AccuracyMissing(const Errors *error, PetscReal asked, PetscInt order);
PetscErrorCode AccuracyTell(const ErrorEstimate *error, PetscReal rtol, Rod rod, MPI_Comm comm);
PetscErrorCode AccuracyEstimate(Rod rod, PetscReal t, PetscReal rtol, PetscReal efoldings,
                                PetscReal weighed, PetscBool linear, PetscReal *error);

#endif
