/* What a run needs to go on from a result file as if it had not stopped. */
#ifndef TENDRIL_RESTART_H
#define TENDRIL_RESTART_H

#include "base/hdf.h"
#include "record/observe.h"
#include "stepping/estimate.h"
#include "stepping/vbdf.h"

enum { RESTART_KICKS = 13 }; /* of the fields of the mechanics */
enum {
  RESTART_BESIDE = 14 + 3 * ESTIMATE_SEEN + ASTRAY_NUMBERS,
  RESTART_STUCK = 9
}; /* as grow_errors.c and grow_jam.c have them */

/* All reals, stored as one array, /restart/state; beside it the stepper's points, /restart/points,
   latest first, [point][node times fields], what Newton's method remembers, /restart/memory, and
   the errors that are followed, /restart/errors, [part][node times fields]. */
typedef struct {
  PetscReal t, step;                        /* where the run is, and the size of its next step */
  PetscReal points, order;                  /* of the stepper's history; its next order */
  PetscReal model, fields, steps;           /* models are numbered as in growing.h */
  PetscReal memory[VBDF_MEMORY];            /* of the stepper, beside its points */
  PetscReal wants, ease, others;            /* of the leg: its Ease */
  PetscReal kick[RESTART_KICKS], kick_ends; /* of the leg: what a wall's kick is measured against */
  Observation seen, began;    /* at t; where steps began to cross the layer of the start */
  PetscReal folds, neglected; /* so far, for the estimate of the error */
  PetscReal falls;            /* speed of a rod that snaps, SceneAtSpeed(); 0: it does not */
  PetscReal shared;           /* viscous share that friction was given, see LoadShareMore() */
  PetscReal counted[2];       /* so far: Newton iterations, rejected tries of steps */
  PetscReal firm;             /* 1: contact got firm, 0: it may, -1: it stays as it is */
  PetscReal errors[ESTIMATE_PARTS][ESTIMATE_SEEN]; /* followed so far */
  PetscReal following[ESTIMATE_MEMORY];            /* how they are followed on */
  PetscReal follows, errors_sum;                   /* are they? as sum, of /restart/errors */
  PetscReal beside[RESTART_BESIDE]; /* errors that are not followed, and what they follow from */
  PetscReal stuck[RESTART_STUCK];   /* since when, and in how many steps, it has got nowhere */
  PetscReal time[VBDF_POINTS];      /* of the points, since t */
  PetscReal balance[BALANCE_STATE]; /* of the energy balance */
  PetscReal sum;                    /* of the absolute values of all of it: a torn file shows */
} RestartState;
enum { RESTART_STATE = sizeof(RestartState) / sizeof(PetscReal) };

extern const OptionGroup restart_options;

PetscErrorCode RestartOptions(char file[PETSC_MAX_PATH_LEN], PetscBool *restart);
PetscErrorCode RestartRead(const char *file, Scene scene, RestartState *state, PetscBool *begun);
PetscErrorCode RestartChange(const char *file, Scene scene);
PetscErrorCode RestartTake(const char *file, const RestartState *state, Leg *leg);
PetscErrorCode RestartTakeErrors(const char *file, const RestartState *state, Estimate estimate);
PetscErrorCode RestartWrite(HdfFile file, Scene scene, Rod rod, RestartState *state, Vec points[],
                            Vec errors[]);
PetscErrorCode RestartKeep(Leg *leg, PetscReal t, Vec latest, RestartState *state, Vec points[]);

#endif
