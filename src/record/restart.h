/* What a run needs to go on from a result file as if it had not stopped. */
#ifndef TENDRIL_RESTART_H
#define TENDRIL_RESTART_H

#include "record/observe.h"
#include "stepping/vbdf.h"

/* All reals, stored as one array, /restart/state; the points beside it, latest first, as
   [points][node][field]. */
typedef struct {
  PetscReal t, step;                /* where the run is, and the size of its next step */
  PetscReal points, order;          /* of the stepper's history; its next order */
  PetscReal model, fields, steps;   /* models are numbered as in grow.c */
  PetscReal folds, neglected;       /* so far, for the estimate of the error */
  PetscReal reference_length;       /* of the natural curvature of a fed rod */
  PetscReal time[VBDF_POINTS];      /* of the points */
  PetscReal balance[BALANCE_STATE]; /* of the energy balance */
  PetscReal sum;                    /* of the absolute values of all points: a torn file shows */
} RestartState;
enum { RESTART_STATE = sizeof(RestartState) / sizeof(PetscReal) };

PetscErrorCode RestartOptions(char file[], size_t length, PetscBool *restart);
PetscErrorCode RestartRead(const char *file, Scene scene, RestartState *state, PetscReal **points);
PetscReal RestartSum(PetscInt n, const PetscReal points[]);

#endif
