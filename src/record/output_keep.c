/* A run that is kept in memory, for whoever runs it. */
#include "record/storing.h"

/* OutputKeep - what comes from here on is kept in memory, of an output without a file. */
PetscErrorCode OutputKeep(Output self, PetscBool series, PetscBool shapes) {
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(self->comm, &rank));
  self->series_kept = (PetscBool)(!rank && series);
  self->shapes_kept = (PetscBool)(!rank && shapes);
  PetscFunctionReturn(0);
}

/* OutputRoom - room for so many rows of the series; where they are many, the earlier ones may leave
   memory for the disk. */
PetscErrorCode OutputRoom(Output self, PetscInt n) {
  enum { FEWEST = 64, OFTEN = 4096 };
  const size_t row = sizeof(*self->series);

  PetscFunctionBegin;
  if (n % OFTEN == 0) SpillRest(&self->kept);
  if (n <= self->series_room) PetscFunctionReturn(0);
  self->series_room = PetscMax(n, 2 * self->series_room + FEWEST);
  PetscCall(SpillGrow((size_t)self->series_n * row, (size_t)self->series_room * row, &self->kept));
  self->series = (Observation *)self->kept.at;
  PetscFunctionReturn(0);
}

/* The first of an observation, as many as a harvest has; those that a scene has not are NAN. */
static PetscReal *Observed(Output self, const Observation *seen, PetscInt values, PetscReal *to) {
  for (PetscInt k = 0; k < values; k++)
    to[k] = OutputHolds(self, (int)k) ? ((const PetscReal *)seen)[k] : NAN;
  return to + values;
}

/* OutputHarvest - hands over what was kept, with the last observation; on rank 0 of the run.
   values: how many of each observation, from the first on. */
PetscErrorCode OutputHarvest(Output self, const Observation *last, PetscInt values,
                             Harvest *harvest) {
  size_t n = (size_t)values * (1 + (size_t)self->series_n);
  PetscReal *to;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(harvest, sizeof(*harvest)));
  harvest->values = values;
  harvest->steps = self->series_n;
  harvest->shapes = self->shapes_n;
  if (self->shapes_n) harvest->nodes = self->nodes;
  for (int i = 0; i < CONTACT_SET; i++) n += (size_t)(self->shapes_n * OutputShapeSize(self, i));
  harvest->n = n + (size_t)harvest->nodes;
  PetscCall(PetscMalloc1(harvest->n, &harvest->data));
  to = Observed(self, last, values, harvest->data);
  for (PetscInt k = 0; k < self->series_n; k++) to = Observed(self, &self->series[k], values, to);
  PetscCall(PetscArraycpy(to, self->s, harvest->nodes));
  to += harvest->nodes;
  for (int i = 0; i < CONTACT_SET; i++) {
    PetscCall(PetscArraycpy(to, self->shape[i], self->shapes_n * OutputShapeSize(self, i)));
    to += self->shapes_n * OutputShapeSize(self, i);
  }
  PetscFunctionReturn(0);
}

/* The series of a file, as far as they are wanted. */
static PetscErrorCode TakeSeries(Output self, const char *from, PetscInt n) {
  PetscReal *values;
  PetscInt rows;
  char path[64];

  PetscFunctionBegin;
  PetscCall(OutputRoom(self, n));
  self->series_n = n;
  for (int k = 0; k < OBSERVED; k++) {
    if (!OutputHolds(self, k)) continue;
    (void)snprintf(path, sizeof(path), "/series/%s", observed_name[k]);
    PetscCall(HdfRead("-restart", from, path, 1, &rows, &values));
    for (PetscInt i = 0; i < PetscMin(n, rows); i++) ((PetscReal *)&self->series[i])[k] = values[i];
    PetscCall(PetscFree(values));
  }
  PetscFunctionReturn(0);
}

/* ... and its shapes. */
static PetscErrorCode TakeShapes(Output self, const char *from, PetscInt n) {
  PetscInt dims[3];
  PetscReal *values;

  PetscFunctionBegin;
  self->shapes_n = self->shapes_room = n;
  for (int k = 0; k < self->sets; k++) {
    const PetscInt components = self->set[k].components;
    const int rank = components == 0 ? 1 : components == 1 ? 2 : 3;
    PetscCall(HdfRead("-restart", from, self->set[k].name, rank, dims, &values));
    PetscCall(PetscMalloc1(n * OutputShapeSize(self, k), &self->shape[k]));
    PetscCall(
        PetscArraycpy(self->shape[k], values, PetscMin(n, dims[0]) * OutputShapeSize(self, k)));
    PetscCall(PetscFree(values));
  }
  PetscFunctionReturn(0);
}

/* OutputTakeOver - as OutputContinue(), of an output that stores nothing by itself and keeps all in
   memory: what there is of the run before is read. Collective.

   follows  as OutputFollows() has it */
PetscErrorCode OutputTakeOver(const char *from, Scene scene, PetscReal t, PetscReal interval,
                              PetscBool follows, Output *output) {
  Output self;

  PetscFunctionBegin;
  PetscCall(OutputContinue(NULL, from, scene, t, interval, output));
  self = *output;
  PetscCall(OutputKeep(self, PETSC_TRUE, PETSC_TRUE));
  self->follows = follows;
  PetscCall(TakeSeries(self, from, self->cut[0]));
  PetscCall(TakeShapes(self, from, self->cut[1]));
  self->cut[0] = self->cut[1] = -1;
  self->from[0] = 0;
  PetscFunctionReturn(0);
}

/* OutputRows - the observations that are kept in memory, on the first rank. Borrowed. */
void OutputRows(Output self, PetscInt *n, const Observation **rows) {
  *n = self->series_n;
  *rows = self->series;
}

/* OutputDropShape - takes off again the shape that was added last. */
void OutputDropShape(Output self) {
  if (!self->shapes_kept) return;
  self->shapes_n--;
  self->times_n--;
}

/* The rows up to a time, and one more. */
static PetscErrorCode RowsUpTo(Output self, PetscReal t, const Observation *last,
                               Observation **rows, PetscInt *n) {
  PetscFunctionBegin;
  *n = self->series_n;
  while (*n > 0 && self->series[*n - 1].t > t * (1 + 1e-12)) --*n;
  PetscCall(PetscMalloc1(*n + 1, rows));
  PetscCall(PetscArraycpy(*rows, self->series, *n));
  if (last) (*rows)[(*n)++] = *last;
  PetscFunctionReturn(0);
}

/* OutputCut - leaves out what is later than t, until OutputUncut().

   last  a row more; NULL: none */
PetscErrorCode OutputCut(Output self, PetscReal t, const Observation *last, struct _Output *kept) {
  Observation *rows;

  PetscFunctionBegin;
  *kept = *self;
  PetscCall(RowsUpTo(self, t, last, &rows, &self->series_n));
  self->series = rows;
  self->shapes_n = self->times_n = OutputCountUpTo(self->times_n, self->times, t);
  PetscFunctionReturn(0);
}

PetscErrorCode OutputUncut(Output self, const struct _Output *kept) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->series));
  *self = *kept;
  PetscFunctionReturn(0);
}

/*
  OutputSave - writes all that is kept in memory, up to a time, into a file; nothing changes for
  what comes after. Collective.

  path           the file
  t              what is later is left out
  last           a row more, of the series; NULL: none
  state, points, errors, finished  as of OutputStore()
*/
PetscErrorCode OutputSave(Output self, const char *path, PetscReal t, const Observation *last,
                          Rod rod, RestartState *state, Vec points[], Vec errors[],
                          PetscBool finished) {
  struct _Output kept;
  PetscErrorCode error;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(OutputRefuseTaken("save", path));
  PetscCallMPI(MPI_Comm_rank(self->comm, &rank));
  PetscCall(OutputCut(self, t, last, &kept));
  self->mine = (PetscBool)!rank;
  PetscCall(PetscStrncpy(self->path, path, sizeof(self->path)));
  error = OutputStore(self, rod, state, points, errors, finished);
  PetscCall(OutputUncut(self, &kept));
  PetscCall(error);
  PetscFunctionReturn(0);
}
