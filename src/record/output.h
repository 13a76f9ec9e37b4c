/* The result file (HDF5) of a run: whole and readable at any time, whatever ends the program. */
#ifndef TENDRIL_OUTPUT_H
#define TENDRIL_OUTPUT_H

#include "base/hdf.h"
#include "record/event.h"
#include "record/observe.h"
#include "record/restart.h"

typedef struct _Output *Output;

PetscErrorCode OutputCreate(const char *file, Scene scene, Output *output);
PetscErrorCode OutputContinue(const char *file, const char *from, Scene scene, PetscReal t,
                              PetscReal interval, Output *output);
PetscErrorCode OutputSeries(Output output, const Observation *seen);
PetscErrorCode OutputShape(Output output, PetscReal t, const Node *nodes,
                           const PetscReal (*contact)[2]);
PetscErrorCode OutputEvent(Output output, const Event *event);
PetscBool OutputDue(Output output);
PetscErrorCode OutputStore(Output output, Rod rod, RestartState *state, Vec points[],
                           PetscBool finished);
PetscErrorCode OutputDestroy(Output *output);

/* for the results of other tasks */
PetscErrorCode OutputNewFile(const char *option, const char *path, MPI_Comm comm, HdfFile *file);
PetscErrorCode OutputEndFile(const char *option, const char *path, MPI_Comm comm, HdfFile *file);
PetscErrorCode OutputAttributes(HdfFile file, MPI_Comm comm, PetscBool finished);

#endif
