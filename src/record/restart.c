#include "record/restart.h"
#include "scene/change.h"
#include <ctype.h>

static const OptionRow rows[] = {ROW_TEXT("-restart", INPUT_FILE | IN_PLACE | PASSING | PROGRAM,
                                          "result file of a run to go on with")};
const OptionGroup restart_options = OPTION_GROUP("Going on", rows);

/* Takes over one option of the earlier run, unless it is given now, or says how a run was run and
   not what it was. stopped: the earlier run was ended by an event. */
static PetscErrorCode Inherit(const char *name, const char *value, PetscBool stopped) {
  const OptionRow *row = OptionFind(name);
  PetscBool given;

  PetscFunctionBegin;
  if (row && (row->flags & PASSING || (stopped && row->flags & EVENT))) PetscFunctionReturn(0);
  PetscCall(OptionGiven(name, &given));
  if (!given) PetscCall(PetscOptionsSetValue(NULL, name, value[0] ? value : NULL));
  PetscFunctionReturn(0);
}

/*
  RestartOptions - with -restart FILE, takes over the options the earlier run had in force; those
  given now win. Collective; before anything else reads options.
*/
PetscErrorCode RestartOptions(char file[PETSC_MAX_PATH_LEN], PetscBool *restart) {
  PetscBool stopped;
  char *text;

  PetscFunctionBegin;
  PetscCall(OptionText("-restart", file, restart));
  if (!*restart) PetscFunctionReturn(0);
  PetscCall(HdfReadText("-restart", file, "options", &text));
  PetscCall(HdfHas(file, "/event", &stopped));
  for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
    char *value = line + strcspn(line, " ");
    if (*value) *value++ = 0;
    PetscCall(Inherit(line, value, stopped));
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(0);
}

/* The scales of the earlier run must be those of this one: its numbers stand for other lengths
   otherwise. */
static PetscErrorCode CheckScales(const char *file, Scene scene, MPI_Comm comm) {
  PetscBool same = PETSC_TRUE;
  PetscReal *scale;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(HdfRead("-restart", file, "/restart/scales", 1, &n, &scale));
  for (PetscInt k = 0; k < PetscMin(n, UNIT_ALL); k++)
    if (PetscAbsReal(scale[k] - scene->si.scale[k]) > 1e-12 * PetscAbsReal(scale[k]))
      same = PETSC_FALSE;
  PetscCall(PetscFree(scale));
  UserCheck(same, comm,
            "-si_: the run in -restart %s is of another rod in the laboratory; leave these options "
            "out, they are taken from there",
            file);
  PetscFunctionReturn(0);
}

/* A rod goes on as long as it was: the lengths that the file tells are those of this scene. (Where
   growth feels force its length is part of the state.) */
static PetscErrorCode CheckLength(const char *file, Scene scene, MPI_Comm comm) {
  const PetscReal alike = 1e-9;
  PetscReal *t, *length, now;
  PetscInt n, rows;

  PetscFunctionBegin;
  if (scene->growth->yield > 0) PetscFunctionReturn(0);
  PetscCall(HdfRead("-restart", file, "/series/t", 1, &n, &t));
  PetscCall(HdfRead("-restart", file, "/series/length", 1, &rows, &length));
  n = PetscMin(n, rows) - 1;
  UserCheck(n >= 0, comm, "-restart %s: holds no series", file);
  PetscCall(SceneLength(scene, t[n], &now));
  UserCheck(PetscAbsReal(now - length[n]) <= alike * length[n], comm,
            "-growth_: the rod in -restart %s is %.6g long at t = %.6g, and would be %.6g as it is "
            "said to grow now; leave -growth_initial_length and the like out, they are taken from "
            "there",
            file, (double)length[n], (double)t[n], (double)now);
  PetscCall(PetscFree(t));
  PetscCall(PetscFree(length));
  PetscFunctionReturn(0);
}

/* Gives the scene the file's mesh, which may depend on the end time the run had. */
static PetscErrorCode TakeMesh(const char *file, Mesh *mesh, MPI_Comm comm) {
  PetscReal *s;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(HdfRead("-restart", file, "/shapes/s", 1, &n, &s));
  if (n == mesh->cells + 1) PetscCall(PetscArraycpy(mesh->s, s, n));
  PetscCall(PetscFree(s));
  UserCheck(n == mesh->cells + 1, comm, "-rod_cells %d: the run in -restart %s has %d",
            (int)mesh->cells, file, (int)n - 1);
  PetscFunctionReturn(0);
}

/* Files that have neither names nor changes have it beside: the clamp goes on from where it has
   turned to, if its rate was changed in the run. */
static PetscErrorCode TakeClamp(const char *file, SceneMemory *laws) {
  PetscReal *clamp;
  PetscBool has, changes;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(HdfHas(file, "/restart/clamp", &has));
  PetscCall(HdfHas(file, "changes", &changes));
  if (!has || changes) PetscFunctionReturn(0);
  PetscCall(HdfRead("-restart", file, "/restart/clamp", 1, &n, &clamp));
  if (n == 2) laws->spun = clamp[0];
  if (n == 2) laws->spins_from = clamp[1];
  PetscCall(PetscFree(clamp));
  PetscFunctionReturn(0);
}

/* The value of an option in the lines of a file's options; NULL: it is not there. The rest of its
   line stands behind it. */
static const char *ValueIn(const char *lines, const char *name) {
  const size_t n = strlen(name);

  for (const char *line = lines; line; line = strchr(line, '\n')) {
    if (*line == '\n') line++;
    if (!strncmp(line, name, n) && line[n] == ' ') return line + n + 1;
  }
  return NULL;
}

/* Was an option given to this run, other than the earlier one began with? */
static PetscErrorCode GivenAnew(const char *lines, const char *name, const char *now,
                                PetscBool *anew) {
  const char *began = ValueIn(lines, name), *said = OptionSaid(name);

  PetscFunctionBegin;
  if (!said) said = now;
  *anew = (PetscBool)(said[0] && (!began || strcspn(began, "\n") != strlen(said) ||
                                  strncmp(began, said, strlen(said)) != 0));
  PetscFunctionReturn(0);
}

/* One change again, of a run whose options, as it began with them, are in these lines; not that of
   an option that is given now. */
static PetscErrorCode Again(Scene scene, const char *lines, const ChangeRow *row) {
  char name[128], began[PETSC_MAX_PATH_LEN] = "";
  PetscBool option, anew = PETSC_FALSE;

  PetscFunctionBegin;
  (void)snprintf(name, sizeof(name), "-%s", row->what);
  option = (PetscBool)(SceneChangedOption(name) != NULL);
  if (option) {
    PetscCall(PetscOptionsGetString(NULL, NULL, name, began, sizeof(began), NULL));
    PetscCall(GivenAnew(lines, name, began, &anew));
  }
  if (anew) PetscFunctionReturn(0);
  if (option) PetscCall(PetscOptionsSetValue(NULL, name, row->value));
  PetscCall(SceneChange(scene, name, row->value, row->t));
  if (option) PetscCall(OptionPut(name, began));
  PetscFunctionReturn(0);
}

/*
  RestartChange - does again what was changed in the earlier run, but for a later end, with which
  the options have it already. After all that follows from the scene as the run began. Collective.

  rod  which of several; NULL: there is one
*/
PetscErrorCode RestartChange(const char *file, const char *rod, Scene scene) {
  Changes changes;
  char name[96], *lines;

  PetscFunctionBegin;
  (void)snprintf(name, sizeof(name), rod ? "/rods/of/%s/changes" : "changes", rod);
  PetscCall(ChangesTake(file, name, &scene->changes));
  changes = scene->changes;
  if (rod)
    PetscCall(OptionsList(&lines));
  else
    PetscCall(HdfReadText("-restart", file, "options", &lines));
  for (PetscInt k = 0; changes && k < changes->done; k++)
    if (strcmp(changes->row[k].what, "ts_max_time") != 0)
      PetscCall(Again(scene, lines, &changes->row[k]));
  PetscCall(PetscFree(lines));
  if (!rod) PetscCall(CheckLength(file, scene, scene->comm));
  PetscFunctionReturn(0);
}

/*
  RestartRead - reads what is stored to go on from, and makes the scene that of the file.
  Collective.

  begun  false if the earlier run had not taken a step: state is then not set, the run begins anew
*/
PetscErrorCode RestartRead(const char *file, Scene scene, RestartState *state, PetscBool *begun) {
  const MPI_Comm comm = scene->comm;
  PetscBool result;
  char text[64];

  PetscFunctionBegin;
  PetscCall(HdfHas(file, "/restart/points", begun));
  PetscCall(HdfHas(file, "/shapes/x", &result));
  UserCheck(result, comm, "-restart %s: is the result of another task, not of a run", file);
  if (!*begun) PetscFunctionReturn(0);
  PetscCall(RememberedRead(file, comm, state));
  PetscCall(CheckScales(file, scene, comm));
  PetscCall(TakeMesh(file, &scene->mesh, comm));
  PetscCall(TakeClamp(file, &state->laws));
  PetscCall(SceneRecall(scene, &state->laws));
  UserCheck(scene->end_time > state->t * (1 + 1e-12), comm,
            "-restart %s: is at t = %s already; give a later -ts_max_time", file,
            OptionBoth(state->t, UNIT_TIME, text));
  PetscFunctionReturn(0);
}

/* A vector that is read row by row from a file: on rank 0, and handed out. */
typedef struct {
  const char *file;
  VecScatter to_zero;
  Vec all;
  PetscReal sum; /* of what was read, on rank 0 */
  char fault[HDF_FAULT];
} Reader;

static PetscErrorCode ReaderOpen(Vec like, Reader *self) {
  PetscFunctionBegin;
  PetscCall(VecScatterCreateToZero(like, &self->to_zero, &self->all));
  PetscFunctionReturn(0);
}

static PetscErrorCode ReaderClose(Reader *self) {
  PetscFunctionBegin;
  PetscCall(VecScatterDestroy(&self->to_zero));
  PetscCall(VecDestroy(&self->all));
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadVector(Reader *self, const char *name, PetscInt row, Vec v) {
  PetscScalar *a;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(self->all, &n));
  PetscCall(VecGetArray(self->all, &a));
  if (n && !self->fault[0]) PetscCall(HdfReadRow(self->file, name, row, n, a, self->fault));
  for (PetscInt k = 0; k < n; k++) self->sum += PetscAbsReal(a[k]);
  PetscCall(VecRestoreArray(self->all, &a));
  PetscCall(VecScatterBegin(self->to_zero, self->all, v, INSERT_VALUES, SCATTER_REVERSE));
  PetscCall(VecScatterEnd(self->to_zero, self->all, v, INSERT_VALUES, SCATTER_REVERSE));
  PetscFunctionReturn(0);
}

/* Gives a rod back what it remembered. */
static PetscErrorCode Recall(Reader *reader, Rod rod) {
  Vec memory;
  DM da;

  PetscFunctionBegin;
  if (!rod->memory) PetscFunctionReturn(0);
  PetscCall(RodCreateMemory(rod, &da, &memory));
  PetscCall(ReaderOpen(memory, reader));
  PetscCall(ReadVector(reader, "/restart/memory", 0, memory));
  PetscCall(ReaderClose(reader));
  PetscCall(RodRecall(rod, memory));
  PetscCall(VecDestroy(&memory));
  PetscCall(DMDestroy(&da));
  PetscFunctionReturn(0);
}

/* RestartTake - gives a leg the state, the history and the memory of an earlier run. Collective. */
PetscErrorCode RestartTake(const char *file, const RestartState *state, Leg *leg) {
  MPI_Comm comm = leg->rod->comm;
  PetscInt n = (PetscInt)state->points;
  Reader reader = {.file = file};
  PetscMPIInt rank;
  PetscBool given;
  Vec old[VBDF_POINTS];
  int whole;

  PetscFunctionBegin;
  PetscCall(ReaderOpen(leg->U, &reader));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(VecDuplicate(leg->U, &old[i]));
    PetscCall(ReadVector(&reader, "/restart/points", i, old[i]));
  }
  PetscCall(ReaderClose(&reader));
  PetscCall(Recall(&reader, leg->rod));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  whole = rank || (!reader.fault[0] && reader.sum == state->sum);
  PetscCallMPI(MPI_Bcast(&whole, 1, MPI_INT, 0, comm));
  UserCheck(whole, comm, "-restart %s: its last state is not whole, and cannot be gone on with",
            file);
  PetscCall(VecCopy(old[0], leg->U));
  PetscCall(VBDFSetHistory(leg->ts, n, state->time, old, (PetscInt)state->order));
  PetscCall(VBDFSetMemory(leg->ts, state->memory));
  for (PetscInt i = 0; i < n; i++) PetscCall(VecDestroy(&old[i]));
  PetscCall(TSSetTime(leg->ts, state->t));
  PetscCall(OptionGiven("-ts_dt", &given));
  if (!given) PetscCall(TSSetTimeStep(leg->ts, state->step));
  PetscCall(TSSetStepNumber(leg->ts, (PetscInt)state->steps));
  PetscCall(PetscArraycpy(leg->of->kick, state->kick, RESTART_KICKS));
  leg->of->kick_ends = state->kick_ends;
  leg->ease.times = PetscMin(state->ease, leg->ease.most);
  leg->ease.wants = PetscMin(state->wants, leg->ease.most);
  leg->ease.others = state->others;
  PetscFunctionReturn(0);
}

/* RestartReadErrors - the errors that are followed, as vectors that are there. Collective. */
PetscErrorCode RestartReadErrors(const char *file, const RestartState *state, MPI_Comm comm,
                                 Vec errors[]) {
  Reader reader = {.file = file};
  PetscMPIInt rank;
  int whole;

  PetscFunctionBegin;
  PetscCall(ReaderOpen(errors[0], &reader));
  for (PetscInt k = 0; k < ESTIMATE_KEPT; k++)
    PetscCall(ReadVector(&reader, "/restart/errors", k, errors[k]));
  PetscCall(ReaderClose(&reader));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  whole = rank || (!reader.fault[0] && reader.sum == state->errors_sum);
  PetscCallMPI(MPI_Bcast(&whole, 1, MPI_INT, 0, comm));
  UserCheck(whole, comm, "-restart %s: its last state is not whole, and cannot be gone on with",
            file);
  PetscFunctionReturn(0);
}

/* RestartTakeErrors - goes on following the errors of an earlier run, if it did; they are those of
   the estimate's leg. Collective. */
PetscErrorCode RestartTakeErrors(const char *file, const RestartState *state, Estimate estimate) {
  Vec errors[ESTIMATE_KEPT];
  MPI_Comm comm;

  PetscFunctionBegin;
  PetscCall(EstimateSet(estimate, state->t, state->errors));
  if (!estimate || state->follows == 0) PetscFunctionReturn(0);
  PetscCall(EstimateVectors(estimate, errors));
  PetscCall(PetscObjectGetComm((PetscObject)errors[0], &comm));
  PetscCall(RestartReadErrors(file, state, comm, errors));
  PetscCall(EstimateTake(estimate, state->following, errors));
  PetscCall(EstimateVectorsDestroy(estimate, errors));
  PetscFunctionReturn(0);
}

/*
  RestartKeep - what a leg's stepper knows at time t, after an accepted step. Collective.

  latest  the state at t
  state   what is of the leg is set
  points  borrowed, at most VBDF_POINTS, latest first
*/
PetscErrorCode RestartKeep(Leg *leg, PetscReal t, Vec latest, RestartState *state, Vec points[]) {
  PetscInt n, order, steps;
  PetscReal now;

  PetscFunctionBegin;
  PetscCall(VBDFGetHistory(leg->ts, &n, state->time, points, &order));
  if (!n) n = order = 1; /* another stepper starts afresh from the last point */
  points[0] = latest;
  PetscCall(TSGetTime(leg->ts, &now));
  state->t = t;
  state->time[0] = t - now; /* an event may have ended the run before its step did */
  for (PetscInt i = n - 1; i >= 0; i--) state->time[i] -= state->time[0];
  PetscCall(TSGetTimeStep(leg->ts, &state->step));
  PetscCall(TSGetStepNumber(leg->ts, &steps));
  PetscCall(VBDFGetMemory(leg->ts, state->memory));
  PetscCall(PetscArraycpy(state->kick, leg->of->kick, RESTART_KICKS));
  state->kick_ends = leg->of->kick_ends;
  state->wants = leg->ease.wants;
  state->ease = leg->ease.times;
  state->others = leg->ease.others;
  state->points = n;
  state->order = order;
  state->steps = steps;
  state->fields = leg->rod->model->fields;
  SceneRemember(leg->rod->scene, &state->laws);
  PetscFunctionReturn(0);
}

/* Appends vectors, as rows, to a dataset made here: one at a time on rank 0, where all of them need
   not fit; adds up the absolute values. Collective. */
static PetscErrorCode WriteVectors(HdfFile file, const char *name, const char *text, PetscInt n,
                                   Vec vectors[], PetscReal *sum) {
  const PetscScalar *a;
  VecScatter to_zero;
  PetscInt length;
  Vec all;

  PetscFunctionBegin;
  PetscCall(VecGetSize(vectors[0], &length));
  PetscCall(HdfAppendable(file, name, 1, &length, "mixed", text));
  PetscCall(VecScatterCreateToZero(vectors[0], &to_zero, &all));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(VecScatterBegin(to_zero, vectors[i], all, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(to_zero, vectors[i], all, INSERT_VALUES, SCATTER_FORWARD));
    if (!file) continue;
    PetscCall(VecGetArrayRead(all, &a));
    for (PetscInt k = 0; k < length; k++) *sum += PetscAbsReal(a[k]);
    PetscCall(HdfAppend(file, name, 1, a));
    PetscCall(VecRestoreArrayRead(all, &a));
  }
  PetscCall(VecScatterDestroy(&to_zero));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteMemory(HdfFile file, Rod rod, PetscReal *sum) {
  Vec memory;
  DM da;

  PetscFunctionBegin;
  if (!rod->memory) PetscFunctionReturn(0);
  PetscCall(RodCreateMemory(rod, &da, &memory));
  PetscCall(RodRemember(rod, memory));
  PetscCall(WriteVectors(file, "/restart/memory",
                         "what Newton's method remembers from step to step [1][node times values]",
                         1, &memory, sum));
  PetscCall(VecDestroy(&memory));
  PetscCall(DMDestroy(&da));
  PetscFunctionReturn(0);
}

/* RestartWrite - what the run needs to go on from here, in the place of what stood there; of
   OutputStore(). Collective. */
PetscErrorCode RestartWrite(HdfFile file, Scene scene, Rod rod, RestartState *state, Vec points[],
                            Vec errors[]) {
  const PetscInt scales = UNIT_ALL;

  PetscFunctionBegin;
  PetscCall(HdfDelete(file, "/restart"));
  if (!state) PetscFunctionReturn(0);
  PetscCall(HdfGroup(file, "/restart"));
  state->sum = 0;
  PetscCall(WriteVectors(file, "/restart/points",
                         "the stepper's past points, latest first [point][node times fields]",
                         (PetscInt)state->points, points, &state->sum));
  PetscCall(WriteMemory(file, rod, &state->sum));
  state->errors_sum = 0;
  if (errors)
    PetscCall(WriteVectors(file, "/restart/errors",
                           "the errors that are followed [part][node times fields]", ESTIMATE_KEPT,
                           errors, &state->errors_sum));
  PetscCall(RememberedWrite(file, state));
  PetscCall(HdfWrite(file, "/restart/scales", 1, &scales, scene->si.scale, "SI",
                     "the scales of the rod in the laboratory, 0: none"));
  PetscFunctionReturn(0);
}
