/* A result file that is being written: what the files of record/output.h share. */
#ifndef TENDRIL_STORING_H
#define TENDRIL_STORING_H

#include "base/spill.h"
#include "record/output.h"

/* What a number of the scene changes: of what is stored, by it. */
typedef struct {
  char name[64], unit[32];
  PetscReal number;
  Harvest harvest; /* owned */
} Derivative;

/* Only rank 0 has a file; the others hold an empty shell and share the verdict on errors. */
struct _Output {
  Scene scene;
  MPI_Comm comm;
  PetscInt nodes;
  const PetscReal *s;            /* their labels */
  char path[PETSC_MAX_PATH_LEN]; /* empty: nothing is stored */
  PetscBool mine, there, broken; /* this rank writes it; it has been written; it could not be */
  PetscBool series_kept, shapes_kept; /* for OutputHarvest() */
  char from[PETSC_MAX_PATH_LEN]; /* what the next store begins with: the file itself, as a rule */
  PetscInt cut[2];               /* -1, or how many series and shapes of it to keep */
  PetscInt series_n, series_room;
  Observation *series; /* that wait to be stored */
  Spill kept;          /* where these are */
  PetscInt shapes_n, shapes_room;
  const ShapeSet *set;               /* the fields of a shape, */
  int sets;                          /* so many */
  PetscReal *shape[MOST_SHAPE_SETS]; /* that wait to be stored */
  PetscInt times_n, times_room;
  PetscReal *times; /* of all shapes, stored and waiting */
  Event event;
  PetscBool follows;    /* errors are followed, and are series */
  ErrorEstimate error;  /* of kind none until the run has ended */
  char interrupted[64]; /* by what; empty: it is not */
  PetscInt derivatives_n;
  Derivative *derivatives; /* none until the run has ended */
  char *earlier;           /* the options of earlier legs */
  PetscLogDouble stored_at, cost;
  double stored, waits; /* bytes */
};

PetscInt OutputShapeSize(const Output output, int set);
PetscInt OutputCountUpTo(PetscInt n, const PetscReal times[], PetscReal t);
PetscErrorCode OutputUpTo(const char *from, MPI_Comm comm, PetscReal t, PetscReal interval,
                          PetscInt *rows, PetscInt *shapes, PetscReal **times);
PetscErrorCode OutputRefuseTaken(const char *option, const char *path);

/* output_keep.c */
PetscErrorCode OutputRoom(Output output, PetscInt n);

/* output_run.c: into a file that is open, on rank 0 */
PetscErrorCode OutputCut(Output output, PetscReal t, const Observation *last, struct _Output *kept);
PetscErrorCode OutputUncut(Output output, const struct _Output *kept);
PetscErrorCode OutputWriteRun(Output output, HdfFile file, PetscReal t);

#endif
