/* -task sweep: one member. */
#include "base/lock.h"
#include "tasks/sweeping.h"
#include <petsctime.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

/* Room for a line of the options' text, and the line in it. */
static PetscErrorCode AddLine(char **text, const char *name, const char *value) {
  size_t n = *text ? strlen(*text) : 0, more = strlen(name) + strlen(value) + 3;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(n + more, text));
  (void)snprintf(*text + n, more, "%s %s\n", name, value);
  PetscFunctionReturn(0);
}

/* An option that members are to have. */
static PetscErrorCode AddCommon(Sweep *self, const char *name, PetscBool excused) {
  char value[PETSC_MAX_PATH_LEN] = "";
  Common *common = &self->common[self->commons++];

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, NULL, name, value, sizeof(value), NULL));
  PetscCall(PetscStrallocpy(name, &common->name));
  if (value[0]) PetscCall(PetscStrallocpy(value, &common->value));
  common->excused = excused;
  PetscCall(AddLine(&self->options, name, value));
  PetscFunctionReturn(0);
}

/* Is this an option for the members? One that tendril does not know and PETSc has read already is
   of the program as a whole; what nobody knows is refused. */
static PetscErrorCode ForMembers(const char *name, PetscBool *is) {
  const OptionRow *row = OptionFind(name);
  PetscBool read = PETSC_FALSE;

  PetscFunctionBegin;
  if (!row) {
    PetscCall(PetscOptionsUsed(NULL, name, &read));
    if (!read) PetscCall(OptionsRefuseStrange(name));
  }
  *is = (PetscBool)(row ? !(row->flags & PROGRAM) : !read);
  PetscFunctionReturn(0);
}

/*
  SweepTakeCommon - takes over what was given for all members. Collective; before anything reads
  these options.

  If the command line asks for a task of its own, what an options file has beyond that is excused,
  as for a single run.
*/
PetscErrorCode SweepTakeCommon(Sweep *self) {
  PetscBool other = OptionOnCommandLine("-sweep_task"), is = PETSC_FALSE;
  PetscInt n = 0;
  char *text, *line;

  PetscFunctionBegin;
  PetscCall(OptionsList(&text));
  for (line = text; *line; line++) n += *line == '\n';
  PetscCall(PetscCalloc1(n + 1, &self->common));
  for (line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
    line[strcspn(line, " ")] = 0;
    PetscCall(ForMembers(line, &is));
    if (is) PetscCall(AddCommon(self, line, (PetscBool)(other && !OptionOnCommandLine(line))));
  }
  PetscCall(PetscFree(text));
  for (size_t k = 0; k < 2; k++) {
    const char *const of_all[] = {"-sweep_task", "-sweep_store"};
    char value[64] = "";
    PetscCall(PetscOptionsGetString(NULL, NULL, of_all[k], value, sizeof(value), NULL));
    PetscCall(AddLine(&self->options, of_all[k], value));
  }
  PetscFunctionReturn(0);
}

/* The options of a member: the common ones, overridden by its row. */
static PetscErrorCode CreateOptions(Sweep *self, PetscInt member, PetscOptions *options) {
  PetscBool has;
  char name[128];

  PetscFunctionBegin;
  PetscCall(PetscOptionsCreate(options));
  for (PetscInt k = 0; k < self->commons; k++) {
    const Common *common = &self->common[k];
    PetscCall(PetscOptionsSetValue(*options, common->name, common->value));
    if (common->excused) /* asking counts as reading */
      PetscCall(PetscOptionsHasName(*options, NULL, common->name, &has));
  }
  for (PetscInt c = 0; c < TableColumns(self->table); c++) {
    const char *cell = TableCell(self->table, member, c);
    (void)snprintf(name, sizeof(name), "-%s", TableName(self->table, c));
    if (*cell) PetscCall(PetscOptionsSetValue(*options, name, cell));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Meanwhile(void *ctx, PetscBool *drop) {
  PetscFunctionBegin;
  PetscCall(HandoutMeanwhile(((Sweep *)ctx)->handout, drop));
  PetscFunctionReturn(0);
}

/* Runs a member, which has all to itself: options, errors, communicator. failed: its line is in
   errors. */
static PetscErrorCode Run(Sweep *self, PetscInt row, const char *output, Member *member,
                          ErrorState *errors, PetscBool *failed) {
  PetscOptions options;

  PetscFunctionBegin;
  PetscCall(CreateOptions(self, row, &options));
  PetscCall(ErrorsBegin(HandoutTeam(self->handout), PETSC_TRUE, errors));
  PetscCall(OptionsPush(HandoutTeam(self->handout), options, NULL));
  *failed = (PetscBool)(SingleRun(self->task, output, member) != 0);
  PetscCall(OptionsPop());
  PetscCall(ErrorsEnd());
  PetscCall(PetscOptionsDestroy(&options));
  PetscFunctionReturn(0);
}

/* Hands in a member's result: its head, and what it has left behind it. */
static PetscErrorCode HandIn(Sweep *self, MemberHead *head, const Harvest *harvest) {
  size_t bytes;
  char *result;

  PetscFunctionBegin;
  if (head->status == MEMBER_FINISHED) {
    head->values = harvest->values;
    head->steps = harvest->steps;
    head->shapes = harvest->shapes;
    head->nodes = harvest->nodes;
    head->n = harvest->n;
  }
  bytes = sizeof(*head) + head->n * sizeof(PetscReal);
  PetscCall(PetscMalloc(bytes, &result));
  PetscCall(PetscMemcpy(result, head, sizeof(*head)));
  PetscCall(PetscMemcpy(result + sizeof(*head), harvest->data, head->n * sizeof(PetscReal)));
  PetscCall(HandoutReturn(self->handout, bytes, result));
  PetscCall(PetscFree(result));
  PetscFunctionReturn(0);
}

enum { LONGEST_NAME = 240, PATH = PETSC_MAX_PATH_LEN + LONGEST_NAME + 32 };

/* -sweep_directory: the name of a member's file, in it or, until it is whole, below it. A slash in
   the row, of a unit or a path, is none in a name. */
static void FileName(const Sweep *self, PetscInt member, PetscBool whole, const char *ending,
                     char path[PATH]) {
  char name[LONGEST_NAME + 2];

  path[0] = 0;
  if (!self->directory[0]) return;
  TableRowName(self->table, member, name, sizeof(name));
  for (char *c = strchr(name, '/'); c; c = strchr(c, '/')) *c = '_';
  (void)snprintf(path, PATH, "%s/%s%s%s", self->directory, whole ? "" : "running/", name, ending);
}

/* A member's file gets its place when it is whole; of one that failed there is its line. */
static void PlaceFiles(const Sweep *self, const MemberHead *head, PetscBool dropped) {
  const char *const endings[] = {".xmf", ".h5"};
  char from[PATH], to[PATH];
  FILE *log;

  if (!self->directory[0]) return;
  for (int i = 0; i < 2; i++) {
    FileName(self, head->member, PETSC_FALSE, endings[i], from);
    FileName(self, head->member, PETSC_TRUE, endings[i], to);
    if (head->status == MEMBER_FINISHED)
      (void)rename(from, to);
    else
      (void)unlink(from);
  }
  FileName(self, head->member, PETSC_TRUE, ".log", to);
  (void)unlink(to);
  if (head->status == MEMBER_FINISHED || dropped || !(log = fopen(to, "w"))) return;
  fprintf(log, "tendril: %s\n", head->line);
  (void)fclose(log);
}

/* Of two names, as those of files. */
static int Compare(const void *one, const void *other) {
  const char *a = *(const char *const *)one, *b = *(const char *const *)other;

  for (; *a && (*a == '/' ? '_' : *a) == (*b == '/' ? '_' : *b); a++, b++) continue;
  return (*a == '/' ? '_' : *a) - (*b == '/' ? '_' : *b);
}

/* Each row has a name that can be that of a file, and of no other row's. */
static PetscErrorCode CheckNames(const Sweep *self) {
  PetscInt n = TableRows(self->table), nameless = 0;
  char name[LONGEST_NAME + 2], same[2 * LONGEST_NAME + 8] = "", **names;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &names));
  for (PetscInt r = 0; r < n; r++) {
    TableRowName(self->table, r, name, sizeof(name));
    if (!nameless && (!name[0] || strlen(name) > LONGEST_NAME)) nameless = r + 1;
    PetscCall(PetscStrallocpy(name, &names[r]));
  }
  qsort(names, (size_t)n, sizeof(*names), Compare);
  for (PetscInt r = 1; r < n; r++)
    if (!Compare(&names[r - 1], &names[r]) && strcmp(names[r - 1], names[r]))
      (void)snprintf(same, sizeof(same), "%s and %s", names[r - 1], names[r]);
  for (PetscInt r = 0; r < n; r++) PetscCall(PetscFree(names[r]));
  PetscCall(PetscFree(names));
  UserCheck(!nameless, OptionsComm(),
            "-sweep_directory: the file of row %d cannot be named by what the table has there: it "
            "is empty or long",
            (int)nameless);
  UserCheck(!same[0], OptionsComm(), "-sweep_directory: %s would have one file", same);
  PetscFunctionReturn(0);
}

/* SweepMakeDirectory - makes -sweep_directory, if one is asked for and not there. Collective. */
PetscErrorCode SweepMakeDirectory(Sweep *self) {
  char path[PATH];
  int fault = 0;

  PetscFunctionBegin;
  if (!self->directory[0]) PetscFunctionReturn(0);
  (void)snprintf(path, sizeof(path), "%s/running", self->directory);
  if (mkdir(self->directory, 0777) && errno != EEXIST) fault = errno;
  if (!fault && mkdir(path, 0777) && errno != EEXIST) fault = errno;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &fault, 1, MPI_INT, MPI_MAX, OptionsComm()));
  UserCheck(!fault, OptionsComm(), "-sweep_directory %s: cannot be made: %s", self->directory,
            strerror(fault));
  PetscCall(LockTake(OptionsComm(), "-sweep_directory", path));
  PetscCall(CheckNames(self));
  PetscFunctionReturn(0);
}

/* SweepMember - runs a member and hands in its result. Collective on the team. */
PetscErrorCode SweepMember(Sweep *self, PetscInt row) {
  Member member = {.meanwhile = Meanwhile,
                   .ctx = self,
                   .values = self->columns.n,
                   .space = self->space,
                   .series = self->columns.series,
                   .shapes = self->columns.shapes};
  MemberHead head = {.member = row, .status = MEMBER_FINISHED};
  char output[PATH];
  PetscLogDouble begin, end;
  PetscBool failed = PETSC_FALSE;
  ErrorState errors;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(HandoutTeam(self->handout), &rank));
  FileName(self, row, PETSC_FALSE, ".h5", output);
  PetscCall(PetscTime(&begin));
  PetscCall(Run(self, row, output, &member, &errors, &failed));
  PetscCall(PetscTime(&end));
  head.seconds = end - begin;
  if (failed) {
    head.status = MEMBER_FAILED;
    (void)snprintf(head.line, sizeof(head.line), "%.*s", MEMBER_LINE - 1,
                   errors.message[0] ? errors.message : "an error without a message");
  }
  if (!rank) PlaceFiles(self, &head, member.stopped);
  if (member.stopped) /* it has not failed, it is to be run another time */
    PetscCall(HandoutStop(self->handout));
  else if (!rank)
    PetscCall(HandIn(self, &head, &member.harvest));
  PetscCall(PetscFree(member.harvest.data));
  PetscFunctionReturn(0);
}
