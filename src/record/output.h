/* The result file (HDF5), complete and readable after every stored shape. */
#ifndef TENDRIL_OUTPUT_H
#define TENDRIL_OUTPUT_H

#include "record/event.h"
#include "base/hdf.h"
#include "record/observe.h"
#include "record/restart.h"

typedef struct _Output *Output;

PetscErrorCode OutputCreate(const char *file, Scene scene, Output *output);
PetscErrorCode OutputContinue(const char *file, const char *from, Scene scene, PetscReal t,
                              PetscReal interval, Output *output);
PetscErrorCode OutputRestart(Output output, RestartState *state, PetscInt n,
                             const PetscReal points[]);
PetscErrorCode OutputEvent(Output output, const Event *event);
PetscErrorCode OutputSeries(Output output, const Observation *seen);
PetscErrorCode OutputShape(Output output, PetscReal t, const Node *nodes);
PetscErrorCode OutputDestroy(Output *output, PetscBool finished);
PetscErrorCode OutputNewFile(const char *file, hid_t *f);
PetscErrorCode OutputRootAttributes(hid_t file, PetscBool finished);

#endif
