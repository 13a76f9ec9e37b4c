/* The result file (HDF5), complete and readable after every stored shape. */
#ifndef TENDRIL_OUTPUT_H
#define TENDRIL_OUTPUT_H

#include "hdf.h"
#include "observe.h"

typedef struct _Output *Output;

PetscErrorCode OutputCreate(const char *file, Scene scene, Output *output);
PetscErrorCode OutputSeries(Output output, const Observation *seen);
PetscErrorCode OutputShape(Output output, PetscReal t, const Node *nodes);
PetscErrorCode OutputDestroy(Output *output, PetscBool finished);
PetscErrorCode OutputNewFile(const char *file, hid_t *f);
PetscErrorCode OutputRootAttributes(hid_t file, PetscBool finished);

#endif
