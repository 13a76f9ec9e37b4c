/* What a run needs to go on from a result file as if it had not stopped: what it remembers
   (remembered.h), /restart/state; the stepper's points, /restart/points, latest first, [point][node
   times fields]; what Newton's method remembers, /restart/memory; and the errors that are followed,
   /restart/errors, [part][node times fields]. */
#ifndef TENDRIL_RESTART_H
#define TENDRIL_RESTART_H

#include "record/remembered.h"

extern const OptionGroup restart_options;

PetscErrorCode RestartOptions(char file[PETSC_MAX_PATH_LEN], PetscBool *restart);
PetscErrorCode RestartRead(const char *file, Scene scene, RestartState *state, PetscBool *begun);
PetscErrorCode RestartChange(const char *file, const char *rod, Scene scene);
PetscErrorCode RestartTake(const char *file, const RestartState *state, Leg *leg);
PetscErrorCode RestartReadErrors(const char *file, const RestartState *state, MPI_Comm comm,
                                 Vec errors[]);
PetscErrorCode RestartTakeErrors(const char *file, const RestartState *state, Estimate estimate);
PetscErrorCode RestartWrite(HdfFile file, Scene scene, Rod rod, RestartState *state, Vec points[],
                            Vec errors[]);
PetscErrorCode RestartKeep(Leg *leg, PetscReal t, Vec latest, RestartState *state, Vec points[]);

#endif
