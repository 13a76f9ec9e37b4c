/* A simulation: created, told what it is, set up, destroyed. */
#include "library/simulation.h"
#include <ctype.h>
#include <stdarg.h>
#include <stdlib.h>

/* SimulationRefuse - what was asked for cannot be. Returns the code. */
int SimulationRefuse(Tendril self, int code, const char *format, ...) {
  va_list list;

  va_start(list, format);
  (void)vsnprintf(self->message, sizeof(self->message), format, list);
  va_end(list);
  return self->code = code;
}

/* SimulationEnter - from here on options and errors are this simulation's, until SimulationLeave().
   Returns a code: a simulation that is at work, or of which a call was left half-way, cannot be
   entered. */
int SimulationEnter(Tendril self) {
  if (!self) return TENDRIL_USER;
  if (self->inside)
    return SimulationRefuse(self, TENDRIL_USER,
                            "this simulation is at work: one of its laws cannot ask it for that");
  if (self->lost || !ProcessLives())
    return SimulationRefuse(self, TENDRIL_PETSC,
                            self->lost ? "an error has left this simulation half-way: destroy it"
                                       : "PETSc has not begun, or has ended");
  if (ErrorsEnter(&self->errors)) return SimulationRefuse(self, TENDRIL_PETSC, "out of memory");
  if (OptionsEnter(self->reading)) {
    (void)ErrorsEnd();
    return SimulationRefuse(self, TENDRIL_PETSC, "PETSc cannot take the options");
  }
  self->inside = 1;
  return TENDRIL_OK;
}

/* Has a law of its own failed? */
static const OwnLaw *FailedLaw(Tendril self) {
  for (int k = 0; k < OWN_LAWS; k++)
    if (self->law[k].failed) return &self->law[k];
  return NULL;
}

/* SimulationAgree - a law that has failed on one rank has on all. Collective. */
PetscErrorCode SimulationAgree(Tendril self) {
  int failed[OWN_LAWS], any = 0;

  PetscFunctionBegin;
  for (int k = 0; k < OWN_LAWS; k++) {
    any |= self->law[k].value != NULL;
    failed[k] = self->law[k].failed;
  }
  if (any)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, failed, OWN_LAWS, MPI_INT, MPI_BOR, self->comm));
  for (int k = 0; k < OWN_LAWS; k++) self->law[k].failed = failed[k];
  PetscFunctionReturn(0);
}

/* SimulationLeave - ends SimulationEnter(). Returns the code of an error, whose line is kept. */
int SimulationLeave(Tendril self, PetscErrorCode error) {
  const OwnLaw *law = FailedLaw(self);

  if (self->several && self->several->rods && RodsLeave(self->several->rods)) error = PETSC_ERR_LIB;
  if (OptionsLeave()) error = PETSC_ERR_LIB;
  if (ErrorsEnd()) error = PETSC_ERR_LIB;
  self->inside = 0;
  if (law)
    return SimulationRefuse(self, TENDRIL_LAW, "the law of one's own \"%s\" has returned %d",
                            own_name[law - self->law], law->failed);
  if (!error) return self->code = TENDRIL_OK;
  (void)snprintf(self->message, sizeof(self->message), "%s",
                 self->errors.message[0] ? self->errors.message : "an error without a message");
  self->lost = (PetscBool)(error != TENDRIL_ERR_USER);
  return self->code = self->lost ? TENDRIL_PETSC : TENDRIL_USER;
}

/* PETSc's options are those given. */
static PetscErrorCode MakeOptions(Tendril self) {
  PetscFunctionBegin;
  PetscCall(PetscOptionsCreate(&self->options));
  PetscCall(PetscOptionsSetValue(self->options, "-quiet", "true"));
  for (int i = 0; i + 1 < self->given.n; i += 2)
    PetscCall(PetscOptionsSetValue(self->options, self->given.word[i],
                                   self->given.word[i + 1][0] ? self->given.word[i + 1] : NULL));
  PetscCall(ReadingCreate(self->comm, self->options, &self->line, &self->reading));
  for (int k = 0; k < OWN_LAWS; k++)
    PetscCall(ReadingSetLaw(self->reading, (OwnKind)k, &self->law[k]));
  PetscFunctionReturn(0);
}

static PetscErrorCode FreeOptions(Tendril self) {
  PetscFunctionBegin;
  PetscCall(ReadingDestroy(&self->reading));
  PetscCall(PetscOptionsDestroy(&self->options));
  PetscFunctionReturn(0);
}

int TendrilCreate(MPI_Comm comm, Tendril *simulation) {
  Tendril self = *simulation = (Tendril)calloc(1, sizeof(*self));

  if (!self) return TENDRIL_PETSC;
  self->comm = MPI_COMM_NULL;
  self->lost = PETSC_TRUE; /* until it is whole */
  if (ProcessBegin(comm, self->message, sizeof(self->message))) return self->code = TENDRIL_PETSC;
  if (MPI_Comm_dup(comm, &self->comm))
    return SimulationRefuse(self, TENDRIL_PETSC, "MPI cannot duplicate the communicator");
  if (ErrorsBegin(self->comm, PETSC_TRUE, &self->errors) || ErrorsEnd() || MakeOptions(self))
    return SimulationRefuse(self, TENDRIL_PETSC, "out of memory");
  self->lost = PETSC_FALSE;
  return TENDRIL_OK;
}

int TendrilCreateFortran(int comm, Tendril *simulation) {
  return TendrilCreate(comm < 0 ? MPI_COMM_SELF : MPI_Comm_f2c(comm), simulation);
}

/* Frees what is seen of the rods. */
static void FreeSights(Tendril self) {
  for (PetscInt k = 0; self->sight && k <= self->rods; k++) ColumnsFree(&self->sight[k].series);
  free(self->sight);
  self->sight = NULL;
}

static PetscErrorCode MakeRun(Tendril self) {
  PetscFunctionBegin;
  PetscCall(CourseBegin(self));
  self->sight = (Sight *)calloc((size_t)self->rods + 1, sizeof(*self->sight));
  PetscCheck(self->sight, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for series");
  PetscFunctionReturn(0);
}

/* Takes the run away. */
static PetscErrorCode EndRun(Tendril self) {
  PetscFunctionBegin;
  PetscCall(CourseEnd(self));
  FreeSights(self);
  PetscFunctionReturn(0);
}

void TendrilDestroy(Tendril *simulation) {
  Tendril self = simulation ? *simulation : NULL;
  int ended = 0;

  if (!self || self->inside) return;
  *simulation = NULL;
  MPI_Finalized(&ended);
  if (!ended && ProcessLives() && !ErrorsEnter(&self->errors)) {
    (void)EndRun(self);
    (void)FreeOptions(self);
    (void)ErrorsEnd();
  }
  if (!ended && self->comm != MPI_COMM_NULL) MPI_Comm_free(&self->comm);
  FreeSights(self);
  WordsFree(&self->given);
  WordsFree(&self->line.taken);
  free(self->node);
  free(self);
}

/* The name with its dash. */
static void NameOf(const char *option, char name[128]) {
  while (*option == '-') option++;
  (void)snprintf(name, 128, "-%s", option);
}

/* What a file has that is of the program, as scenes have -output, is left out. */
static PetscBool OfProgram(const char *name) {
  const OptionRow *row = OptionFind(name);

  return (PetscBool)(row && row->flags & PROGRAM && strcmp(name, "-quiet"));
}

/* Is it one that a simulation can have? */
static PetscErrorCode CheckName(Tendril self, const char *name) {
  PetscFunctionBegin;
  UserCheck(isalpha((unsigned char)name[1]), self->comm, "%s: is no name of an option", name);
  UserCheck(!OfProgram(name), self->comm, "%s: is of the program, not of a simulation%s", name,
            !strcmp(name, "-output")    ? "; call TendrilSave()"
            : !strcmp(name, "-restart") ? "; call TendrilLoad()"
                                        : "");
  UserCheck(strcmp(name, "-sensitivity"), self->comm, "%s: is of the program, not of a simulation",
            name);
  if (!OptionFind(name) && !self->line.taken.sections) PetscCall(OptionsRefuseStrange(name));
  PetscFunctionReturn(0);
}

static PetscErrorCode Add(Tendril self, const char *name, const char *value) {
  PetscFunctionBegin;
  PetscCall(PetscOptionsSetValue(self->options, name, value[0] ? value : NULL));
  WordsAdd(&self->given, name);
  WordsAdd(&self->given, value);
  PetscFunctionReturn(0);
}

/* The options of a file, behind those given. */
static PetscErrorCode TakeFile(Tendril self, const char *file) {
  const int before = self->line.taken.n;
  char fault[WORDS_FAULT] = "";
  OptionWords *taken = &self->line.taken;

  PetscFunctionBegin;
  UserCheck(file && WordsAddFile(taken, file, fault), self->comm, "%s",
            file ? fault : "-options_file: give the name of a file");
  for (int i = before; i < taken->n; i++) {
    const char *name = taken->word[i];
    const PetscBool value = (PetscBool)(i + 1 < taken->n && !WordIsOption(taken->word[i + 1]));
    if (value) i++;
    if (!OfProgram(name)) PetscCall(Add(self, name, value ? taken->word[i] : ""));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Take(Tendril self, const char *name, const char *value) {
  PetscFunctionBegin;
  if (!strcmp(name, "-options_file")) {
    PetscCall(TakeFile(self, value));
    PetscFunctionReturn(0);
  }
  PetscCall(CheckName(self, name));
  UserCheck(!value || strlen(value) < PETSC_MAX_PATH_LEN, self->comm,
            "%s: its value has more than %d characters", name, PETSC_MAX_PATH_LEN - 1);
  PetscCall(Add(self, name, value ? value : ""));
  PetscFunctionReturn(0);
}

int TendrilSet(Tendril self, const char *option, const char *value) {
  char name[128];
  int code = SimulationEnter(self);

  if (code) return code;
  NameOf(option ? option : "", name);
  return SimulationLeave(self, CourseIsThere(self) ? SimulationChange(self, name, value)
                                                   : Take(self, name, value));
}

int TendrilSetLaw(Tendril self, const char *kind, TendrilLaw law, void *ctx) {
  if (!self) return TENDRIL_USER;
  if (CourseIsThere(self))
    return SimulationRefuse(self, TENDRIL_USER,
                            "a law cannot be set once the simulation is set up");
  for (int k = 0; k < OWN_LAWS; k++)
    if (kind && !strcmp(kind, own_name[k])) {
      self->law[k] = (OwnLaw){.value = law, .ctx = ctx}; /* the reading looks there */
      return self->code = TENDRIL_OK;
    }
  return SimulationRefuse(self, TENDRIL_USER,
                          "%s: is no law of one's own; there are friction, growth and curvature",
                          kind ? kind : "NULL");
}

int TendrilSetWatch(Tendril self, TendrilWatch watch, void *ctx) {
  if (!self) return TENDRIL_USER;
  self->watch = watch;
  self->watch_ctx = ctx;
  return self->code = TENDRIL_OK;
}

/* As TendrilSetUp(), and TendrilLoad() with the file to go on from. What is refused leaves no
   trace: options are made again. */
static int SetUp(Tendril self, const char *restart) {
  PetscErrorCode error = (PetscErrorCode)0;
  int code = SimulationEnter(self);

  if (code) return code;
  if (CourseIsThere(self)) {
    (void)SimulationLeave(self, error);
    return SimulationRefuse(self, TENDRIL_USER, "the simulation is set up already");
  }
  self->errors.reading = PETSC_TRUE;
  if (restart) error = PetscOptionsSetValue(self->options, "-restart", restart);
  if (!error) error = MakeRun(self);
  if (!error && CourseStart(self) > 0) error = SimulationTakeRows(self);
  if (!error) error = SimulationLook(self);
  self->errors.reading = PETSC_FALSE;
  code = SimulationLeave(self, error);
  if (!error) return code;
  self->lost = (PetscBool)(EndRun(self) || FreeOptions(self) || MakeOptions(self));
  if (code == TENDRIL_PETSC && !self->lost) self->code = TENDRIL_USER;
  return self->code;
}

int TendrilSetUp(Tendril self) {
  return SetUp(self, NULL);
}

int TendrilLoad(Tendril self, const char *file) {
  if (self && !file) return SimulationRefuse(self, TENDRIL_USER, "give the file to go on from");
  return SetUp(self, file);
}

const char *TendrilMessage(Tendril self) {
  if (!self) return "there is no simulation";
  return self->code ? self->message : "";
}

const char *TendrilVersion(void) {
  return TENDRIL_VERSION;
}
