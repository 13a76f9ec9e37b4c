/* A simulation of the library: what is behind the handle of tendril.h. */
#ifndef TENDRIL_SIMULATION_H
#define TENDRIL_SIMULATION_H

#include "base/spill.h"
#include "tasks/growing.h"
#include <tendril.h>

/* One value for each accepted step. Blocks that have become too small stay, for whoever looks into
   them. */
typedef struct {
  PetscInt n, room;
  double *column[OBSERVED]; /* of the latest block; none before the first row */
  PetscInt blocks;
  Spill *block; /* all that was ever allocated */
} Columns;

struct Tendril_ {
  MPI_Comm comm;
  OptionWords given; /* name, value, name, value ...; a value "" behind a flag */
  CommandLine line;  /* the options files that were read */
  OwnLaw law[OWN_LAWS];
  TendrilWatch watch;
  void *watch_ctx;
  int inside, code;     /* a call is under way; what the latest one returned */
  char message[1024];   /* about the latest that failed */
  ErrorState errors;    /* of the call that is under way */
  PetscOptions options; /* PETSc's, of those given */
  Reading reading;
  Scene scene;
  Grow *grow;
  PetscBool ended, failed, lost; /* the run: is at its end; gave up; a call has left it half-way */
  char failure[1024];            /* why it gave up */
  PetscReal at; /* the present time, if a step beyond it waits: else the step's end */
  Columns series;
  Observation here; /* at that time */
  TendrilNode *node;
};

/* simulation.c */
int SimulationEnter(Tendril self);
PetscErrorCode SimulationAgree(Tendril self);
int SimulationLeave(Tendril self, PetscErrorCode error);
int SimulationRefuse(Tendril self, int code, const char *format, ...);

/* save.c */
PetscErrorCode SimulationTakeRows(Tendril self);

/* process.c */
int ProcessBegin(MPI_Comm comm, char message[], size_t room);
PetscBool ProcessLives(void);

/* change.c */
PetscErrorCode SimulationChange(Tendril self, const char *name, const char *value);

/* look.c */
void ColumnsBegin(Columns *self);
PetscErrorCode ColumnsAdd(Columns *self, const Observation *seen);
void ColumnsFree(Columns *self);
PetscErrorCode SimulationLook(Tendril self);

#endif
