/* A simulation of the library: what is behind the handle of tendril.h. */
#ifndef TENDRIL_SIMULATION_H
#define TENDRIL_SIMULATION_H

#include "base/spill.h"
#include "tasks/single.h"
#include "tasks/several_run.h"
#include <tendril.h>

/* One value for each accepted step. Blocks that have become too small stay, for whoever looks into
   them. */
typedef struct {
  PetscInt n, room;
  double *column[OBSERVED]; /* of the latest block; none before the first row */
  PetscInt blocks;
  Spill *block; /* all that was ever allocated */
} Columns;

/* What is seen of a rod. */
typedef struct {
  Columns series;
  Observation here; /* at the present time, if that is within a step */
} Sight;

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
  Single asked;
  Scene scene;  /* of one rod */
  Grow *grow;   /* a run of one rod, */
  Run *several; /* or of several; both NULL: it is not set up */
  PetscInt rods;
  PetscBool ended, failed, lost; /* the run: is at its end; gave up; a call has left it half-way */
  char failure[1024];            /* why it gave up */
  PetscReal at; /* the present time, if a step beyond it waits: else the step's end */
  Sight *sight; /* [rods], and of several one more, of all of them */
  TendrilNode *node;
  PetscInt room; /* nodes that there is room for */
};

/* simulation.c */
int SimulationEnter(Tendril self);
PetscErrorCode SimulationAgree(Tendril self);
int SimulationLeave(Tendril self, PetscErrorCode error);
int SimulationRefuse(Tendril self, int code, const char *format, ...);

/* course.c: what moves it */
PetscErrorCode CourseBegin(Tendril self);
PetscErrorCode CourseEnd(Tendril self);
PetscBool CourseIsThere(const struct Tendril_ *self);
PetscBool CourseIsOver(const struct Tendril_ *self);
PetscBool CourseWaits(const struct Tendril_ *self);
PetscReal CourseTime(const struct Tendril_ *self);
PetscReal CourseStart(const struct Tendril_ *self);
Grow *CourseRod(const struct Tendril_ *self, PetscInt k);
PetscErrorCode CourseStep(Tendril self, PetscReal until);
PetscErrorCode CourseFinish(Tendril self, PetscBool *again);
PetscErrorCode CourseStartOver(Tendril self);
PetscBool CourseMayGoOn(const struct Tendril_ *self);
PetscErrorCode CourseChange(Tendril self, const char *name, const char *value);
PetscErrorCode CourseState(Tendril self, PetscReal t, Vec V[2], Vec *U, Vec *U_t);
PetscErrorCode CourseSave(Tendril self, const char *path, PetscReal t, PetscReal now);

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
PetscErrorCode SimulationAddSum(Tendril self, PetscInt row);
PetscErrorCode SimulationLook(Tendril self);

#endif
