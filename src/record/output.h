/* The result file (HDF5) of a run: whole and readable at any time, whatever ends the program. */
#ifndef TENDRIL_OUTPUT_H
#define TENDRIL_OUTPUT_H

#include "base/hdf.h"
#include "record/event.h"
#include "record/observe.h"
#include "record/restart.h"
#include "record/shapes.h"

typedef struct _Output *Output;

/* What a run leaves in memory for whoever runs it, one behind the other: its last observation, its
   series [steps][OBSERVED], and, if there are shapes, the labels of the nodes [nodes] and the
   shapes, set by set, each as in a result file [shapes][...]. */
typedef struct {
  PetscInt values, steps, shapes, nodes; /* values: reals of the first part */
  size_t n;
  PetscReal *data; /* [n]; the owner frees it (PetscFree) */
} Harvest;

PetscErrorCode OutputCreate(const char *file, Scene scene, Output *output);
PetscErrorCode OutputContinue(const char *file, const char *from, Scene scene, PetscReal t,
                              PetscReal interval, Output *output);
PetscErrorCode OutputTakeOver(const char *from, Scene scene, PetscReal t, PetscReal interval,
                              PetscBool follows, Output *output);
PetscErrorCode OutputSave(Output output, const char *path, PetscReal t, const Observation *last,
                          Rod rod, RestartState *state, Vec points[], Vec errors[],
                          PetscBool finished);
void OutputRows(Output output, PetscInt *n, const Observation **rows);
void OutputDropShape(Output output);
PetscErrorCode OutputKeep(Output output, PetscBool series, PetscBool shapes);
PetscErrorCode OutputHarvest(Output output, const Observation *last, PetscInt values,
                             Harvest *harvest);
PetscErrorCode OutputSeries(Output output, const Observation *seen);
PetscErrorCode OutputContactAbout(Scene scene, PetscReal t, PetscInt i, PetscReal g,
                                  const PetscReal (*contact)[PUSH], PetscReal about[3]);
PetscErrorCode OutputShape(Output output, PetscReal t, const Node *nodes,
                           const PetscReal (*contact)[PUSH]);
PetscErrorCode OutputBlank(Output output);
PetscErrorCode OutputEvent(Output output, const Event *event);
PetscErrorCode OutputFollows(Output output);
PetscErrorCode OutputErrors(Output output, const ErrorEstimate *error);
PetscErrorCode OutputDerivative(Output output, const char *name, const char *unit, PetscReal number,
                                Harvest *harvest);
PetscErrorCode OutputInterrupted(Output output, const char *by);
PetscReal OutputNext(PetscReal t, PetscReal interval);
PetscBool OutputHolds(const Output output, int observed);
PetscBool OutputStores(Output output);
PetscBool OutputDue(Output output);
PetscErrorCode OutputStore(Output output, Rod rod, RestartState *state, Vec points[], Vec errors[],
                           PetscBool finished);
PetscErrorCode OutputDestroy(Output *output);

/* for the results of other tasks */
PetscErrorCode OutputRefuse(const char *option, const char *path);
PetscErrorCode OutputParameters(HdfFile file);
PetscErrorCode OutputVersions(HdfFile file);
PetscErrorCode OutputNewFile(const char *option, const char *path, MPI_Comm comm, HdfFile *file);
PetscErrorCode OutputEndFile(const char *option, const char *path, MPI_Comm comm, HdfFile *file);
PetscErrorCode OutputDropFile(const char *path, HdfFile *file);
PetscErrorCode OutputAttributes(HdfFile file, MPI_Comm comm, PetscBool finished);

#endif
