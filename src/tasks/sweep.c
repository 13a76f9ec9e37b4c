/* -task sweep: each row of a table is a run of its own, a member; all results go into one file. */
#include "tasks/sweep.h"
#include "base/handout.h"
#include "base/signals.h"
#include "tasks/critical.h"
#include "tasks/sweeping.h"
#include <petsctime.h>
#include <stdlib.h>
#include <string.h>

static const OptionRow rows[] = {
    ROW_TEXT("-sweep_file", INPUT_FILE | PASSING | PROGRAM,
             "the table of -task sweep: names of options, with their units in brackets, above the "
             "columns, a run a line (CSV), or a dataset an option (HDF5)"),
    ROW_WORD("-sweep_task", "grow", "grow,critical", PASSING | PROGRAM, "what each run does"),
    ROW_TEXT("-sweep_store", PASSING | PROGRAM,
             "what -output holds of each run: final (the default), series, shapes; several with "
             "commas"),
    ROW_TEXT("-sweep_directory", PASSING | PROGRAM,
             "directory for a result file of each run, named by its row"),
    ROW_INT("-sweep_ranks", "1", 1, 1e6, PASSING | PROGRAM, "ranks that share each run")};
const OptionGroup sweep_options = OPTION_GROUP("Sweep", rows);

/* Words of -sweep_store, in any order. */
static PetscErrorCode ReadStore(Sweep *self) {
  char text[PETSC_MAX_PATH_LEN] = "final";

  PetscFunctionBegin;
  PetscCall(OptionText("-sweep_store", text, NULL));
  (void)snprintf(self->store, sizeof(self->store), "%.60s", text);
  for (char *word = strtok(text, ","); word; word = strtok(NULL, ",")) {
    if (!strcmp(word, "series"))
      self->columns.series = PETSC_TRUE;
    else if (!strcmp(word, "shapes"))
      self->columns.shapes = PETSC_TRUE;
    else
      UserCheck(!strcmp(word, "final"), OptionsComm(),
                "-sweep_store %s: unknown, give some of final,series,shapes", word);
  }
  UserCheck(self->task == TASK_GROW || !(self->columns.series || self->columns.shapes),
            OptionsComm(), "-sweep_store %s: of -sweep_task critical there is only final",
            self->store);
  PetscFunctionReturn(0);
}

/* Does this value of an option take a rod out of the plane? Of a vector its third part does. */
static PetscBool TakesOut(const char *name, const char *value) {
  static const char *const scalar[] = {"rod_bend_ratio",    "rod_twist",  "rod_curvature_2",
                                       "tip_torque",        "shape_turn", "rod_curvature_random_2",
                                       "clamp_direction",   "clamp_spin", "clamp_path",
                                       "tropism_nutation_2"},
                           *const vector[] = {"rod_weight", "tip_force_vector", "tropism_direction",
                                              "tropism_source"};
  const char *third = value ? strchr(value, ',') : NULL;

  if (!value || !*value) return PETSC_FALSE;
  if (!strcmp(name, "rod_model")) return (PetscBool)!strcmp(value, "space");
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(scalar); k++)
    if (!strcmp(name, scalar[k])) return PETSC_TRUE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(vector); k++)
    if (!strcmp(name, vector[k])) {
      third = third ? strchr(third + 1, ',') : NULL;
      return (PetscBool)(third && atof(third + 1) != 0);
    }
  return PETSC_FALSE;
}

/* Does this option make the material learn its bend? */
static PetscBool Teaches(const char *name, const char *value) {
  return (PetscBool)(!strncmp(name, "tropism_", 8) || !strcmp(name, "growth_ironing"));
}

/* Does an option of any member, of what all have in common or of the table, do this? */
static PetscBool AnyDoes(const Sweep *self, PetscBool (*does)(const char *, const char *)) {
  for (PetscInt k = 0; k < self->commons; k++)
    if (does(self->common[k].name + 1, self->common[k].value)) return PETSC_TRUE;
  for (PetscInt c = 0; c < TableColumns(self->table); c++)
    for (PetscInt r = 0; r < TableRows(self->table); r++)
      if (does(TableName(self->table, c), TableCell(self->table, r, c))) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* If any member is a rod in space all have the numbers that there are in space, and likewise those
   of a material that learns; what a member has not is nan. */
static PetscErrorCode ColumnsOfAll(Sweep *self) {
  PetscFunctionBegin;
  if (self->task != TASK_GROW) PetscFunctionReturn(0);
  self->space = AnyDoes(self, TakesOut);
  UserCheck(
      !self->space || !self->columns.shapes, OptionsComm(),
      "-sweep_store %s: the table has rods in space, whose shapes are in a file of each; give "
      "-sweep_directory, and leave shapes out",
      self->store);
  if (self->space) self->columns.n = OBSERVED_IN_SPACE;
  if (AnyDoes(self, Teaches)) self->columns.n = OBSERVED;
  PetscFunctionReturn(0);
}

/* What is stored of a member of each task. */
static void ChooseColumns(Sweep *self) {
  if (self->task == TASK_GROW)
    self->columns = (Columns){.group = "/final",
                              .n = OBSERVED_ALWAYS,
                              .name = observed_name,
                              .units = observed_units,
                              .text = observed_text};
  else
    self->columns = (Columns){.group = "/critical",
                              .n = CRITICAL_VALUES,
                              .name = critical_name,
                              .units = critical_units,
                              .text = critical_text};
}

static PetscErrorCode ReadTask(Sweep *self) {
  const PetscInt tasks[] = {TASK_GROW, TASK_CRITICAL};
  PetscInt choice;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCall(OptionWord("-sweep_task", &choice, NULL));
  self->task = tasks[choice];
  ChooseColumns(self);
  PetscCall(ReadStore(self));
  PetscCall(OptionInt("-sweep_ranks", &self->each, NULL));
  PetscCallMPI(MPI_Comm_size(OptionsComm(), &ranks));
  UserCheck(ranks % self->each == 0, OptionsComm(),
            "-sweep_ranks %d: there are %d ranks; give a number that divides this", (int)self->each,
            (int)ranks);
  PetscCall(OptionText("-sweep_directory", self->directory, NULL));
  UserCheck(!self->directory[0] || !(self->columns.series || self->columns.shapes), OptionsComm(),
            "-sweep_directory: each run's file holds its series and shapes; leave -sweep_store %s "
            "out",
            self->store);
  PetscCall(OptionBool("-quiet", &self->quiet, NULL));
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadOptions(Sweep *self) {
  char path[PETSC_MAX_PATH_LEN];
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(SweepTakeCommon(self)); /* before anything reads them */
  PetscCall(OptionGiven("-restart", &given));
  UserCheck(!given, OptionsComm(),
            "-restart: a sweep goes on by itself when its -output is there; take it out");
  PetscCall(ReadTask(self));
  PetscCall(OptionText("-sweep_file", path, &given));
  UserCheck(given, OptionsComm(), "-task sweep: give the table of its runs, -sweep_file FILE");
  PetscCall(OptionText("-output", self->output, &given));
  UserCheck(given, OptionsComm(), "-task sweep: give the file for its results, -output FILE");
  PetscCall(TableRead("-sweep_file", path, &self->table));
  PetscCall(ColumnsOfAll(self));
  PetscCall(OptionsCheckTypes());
  PetscFunctionReturn(0);
}

/* Stores what waits; what cannot be written ends the sweep. On rank 0. */
static PetscErrorCode Store(Sweep *self) {
  PetscBool finished = (PetscBool)(self->done == TableRows(self->table));

  PetscFunctionBegin;
  PetscCall(CollectionStore(self->collection, finished, self->fault));
  if (self->fault[0] && self->handout) PetscCall(HandoutStop(self->handout));
  PetscFunctionReturn(0);
}

/* A result has come in. On rank 0. */
static PetscErrorCode Take(void *ctx, size_t bytes, const void *result) {
  const MemberHead *head = (const MemberHead *)result;
  Sweep *self = (Sweep *)ctx;

  PetscFunctionBegin;
  PetscCall(CollectionAdd(self->collection, head, (const PetscReal *)(const void *)(head + 1)));
  self->done++;
  self->ran++;
  if (head->status == MEMBER_FAILED) {
    if (!self->failed++) (void)snprintf(self->first, sizeof(self->first), "%s", head->line);
    if (self->failed == 1) self->first_member = head->member;
  }
  PetscFunctionReturn(0);
}

/* Now and then, while a member is under way. On rank 0. */
static PetscErrorCode Tick(void *ctx) {
  Sweep *self = (Sweep *)ctx;

  PetscFunctionBegin;
  if (!self->fault[0] && CollectionDue(self->collection)) PetscCall(Store(self));
  PetscCall(SweepProgress(self));
  PetscFunctionReturn(0);
}

/* The members that are still to be run. */
static PetscErrorCode CreateHandout(Sweep *self) {
  const PetscReal *status = CollectionStatus(self->collection);
  PetscInt *jobs, n = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(TableRows(self->table), &jobs));
  for (PetscInt r = 0; r < TableRows(self->table); r++)
    if (status[r] == MEMBER_WAITS)
      jobs[n++] = r;
    else
      self->failed_before += status[r] == MEMBER_FAILED;
  self->done = TableRows(self->table) - n;
  PetscCall(SweepHeading(self));
  PetscCall(HandoutCreate(OptionsComm(), self->each, n, jobs, Take, Tick, self, &self->handout));
  PetscCall(PetscFree(jobs));
  PetscFunctionReturn(0);
}

/* All ranks learn what rank 0 has met. */
static PetscErrorCode Verdict(Sweep *self) {
  PetscInt word[2] = {self->done, SignalCaught()};

  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(self->fault, HDF_FAULT, MPI_CHAR, 0, OptionsComm()));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, word, 2, MPIU_INT, MPI_MAX, OptionsComm()));
  UserCheck(!self->fault[0], OptionsComm(),
            "-output %s: cannot be written: %s; what was stored before is whole: make room and "
            "give the same command again",
            self->output, self->fault);
  UserCheck(word[0] == TableRows(self->table), OptionsComm(),
            "interrupted by signal %d; %d of %d runs are stored, the same command goes on with "
            "the others",
            (int)word[1], (int)word[0], (int)TableRows(self->table));
  PetscFunctionReturn(0);
}

/* All members, one after the other, as far as this team gets them. */
static PetscErrorCode RunMembers(Sweep *self) {
  PetscMPIInt rank;
  PetscInt member;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &rank));
  PetscCall(PetscCommDuplicate(HandoutTeam(self->handout), &self->held, NULL));
  for (;;) {
    PetscCall(HandoutNext(self->handout, &member));
    if (member < 0) break;
    PetscCall(SweepMember(self, member));
  }
  if (!rank && !self->fault[0]) PetscCall(Store(self));
  PetscCall(PetscCommDestroy(&self->held));
  PetscCall(HandoutEnd(&self->handout));
  PetscFunctionReturn(0);
}

static PetscErrorCode Run(Sweep *self) {
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(ReadOptions(self));
  PetscCall(CollectionCreate(self->output, self->table, &self->columns, self->options,
                             &self->collection));
  PetscCall(SweepMakeDirectory(self));
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &rank));
  if (!rank) PetscCall(Store(self)); /* what cannot be written is to show before the work */
  PetscCallMPI(MPI_Bcast(self->fault, HDF_FAULT, MPI_CHAR, 0, OptionsComm()));
  UserCheck(!self->fault[0], OptionsComm(),
            "-output %s: cannot be written: %s; make room, or name a file elsewhere", self->output,
            self->fault);
  ErrorsOptionsRead();
  SignalsCatch();
  PetscCall(CreateHandout(self));
  PetscCall(RunMembers(self));
  PetscCall(Verdict(self));
  PetscCall(SweepSummary(self));
  PetscFunctionReturn(0);
}

static PetscErrorCode Destroy(Sweep *self) {
  PetscFunctionBegin;
  PetscCall(CollectionDestroy(&self->collection));
  PetscCall(TableDestroy(&self->table));
  for (PetscInt k = 0; k < self->commons; k++) {
    PetscCall(PetscFree(self->common[k].name));
    PetscCall(PetscFree(self->common[k].value));
  }
  PetscCall(PetscFree(self->common));
  PetscCall(PetscFree(self->options));
  PetscFunctionReturn(0);
}

/*
  SweepRun - -task sweep: runs each row of the table -sweep_file as a run of its own, with the
  common options overridden by those of the row, and stores all results in -output. Collective on
  OptionsComm(), whose ranks, in teams of -sweep_ranks, are handed the members as they fall free.

  A member that fails is recorded with its line; the sweep goes on. It is an error only if not all
  members could be run: what was stored is then whole, and the same sweep goes on where it was.
*/
PetscErrorCode SweepRun(void) {
  Sweep sweep = {0};
  PetscErrorCode error;

  PetscFunctionBegin;
  error = Run(&sweep);
  PetscCall(Destroy(&sweep));
  PetscCall(error);
  PetscFunctionReturn(0);
}
