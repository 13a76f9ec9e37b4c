#include "tasks/program.h"
#include "base/hdf.h"
#include "base/lock.h"
#include "record/event.h"
#include "record/restart.h"
#include "stepping/vbdf.h"
#include "system/rods.h"
#include "tasks/accuracy.h"
#include "tasks/critical.h"
#include "tasks/grow.h"
#include "tasks/several.h"
#include "tasks/single.h"
#include "tasks/stability.h"
#include "tasks/sweep.h"
#include <signal.h>
#include <slepceps.h>
#include <stdlib.h>

static const char about[] =
    "tendril: the slow growth of an elastic fibre that friction holds back.\n"
    "  tendril -options_file options/uniform-dry.opts [-output FILE.h5] [overrides]\n\n";

static const OptionRow rows[] = {
    ROW_WORD(
        "-task", "grow", "grow,stability,critical,units,sweep", PASSING | PROGRAM,
        "what to do: follow the rod in time, tabulate its stability, find its critical length, "
        "print its laboratory units, run a table of runs"),
    ROW_TEXT("-output", OUTPUT_FILE | PASSING | PROGRAM, "result file (HDF5)")};
static const OptionGroup main_options = OPTION_GROUP("Task and files", rows);

static const OptionGroup *const table[] = {
    &main_options,  &restart_options,   &accuracy_options,  &growth_options,  &friction_options,
    &load_options,  &tip_options,       &space_options,     &contact_options, &pair_options,
    &scene_options, &stiffness_options, &curvature_options, &tropism_options, &shape_options,
    &grow_options,  &frame_options,     &event_options,     &si_options,      &stability_options,
    &sweep_options, &petsc_options};

/* ProgramSetTable - tells of the options that there are. Not collective. */
void ProgramSetTable(void) {
  static const OptionGroup *all[PETSC_STATIC_ARRAY_LENGTH(table) + ALL_FRICTION_LAWS];
  size_t n = 0;

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(table); k++) {
    all[n++] = table[k];
    if (table[k] == &load_options) n += LoadLawOptions(all + n);
  }
  OptionsSetTable(n, all);
}

/* ProgramRun - does what the options ask for (-task), from the scene to the result. Collective;
   after ProgramBegin(). A failure has been told when it returns, and all is freed. */
PetscErrorCode ProgramRun(void) {
  PetscBool several;
  PetscInt task;
  Single asked;

  PetscFunctionBegin;
  PetscCall(OptionWord("-task", &task, NULL));
  PetscCall(SeveralAsked(&several));
  if (several) {
    PetscCall(SingleAsked(task, NULL, &asked));
    PetscCall(SeveralRun(&asked));
    PetscCall(OptionsRefuseLeft());
  } else if (task == TASK_SWEEP)
    PetscCall(SweepRun());
  else
    PetscCall(SingleRun(task, NULL, NULL));
  PetscFunctionReturn(0);
}

/* ProgramVersion - the versions of tendril and of what it was built with. */
void ProgramVersion(FILE *file) {
  fprintf(file, "tendril %s, PETSc %d.%d.%d, SLEPc %d.%d.%d\n", TENDRIL_VERSION,
          PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, SLEPC_VERSION_MAJOR,
          SLEPC_VERSION_MINOR, SLEPC_VERSION_SUBMINOR);
}

/* Is it a word by which people ask for help? */
static PetscBool AsksHelp(const char *word) {
  return (PetscBool)(!strcmp(word, "-help") || !strcmp(word, "--help") || !strcmp(word, "-h"));
}

/* -help and -version are answered at once; -help petsc goes on, for PETSc to tell. */
static PetscBool Answered(int argc, char **argv) {
  int rank, answered = 0;

  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (int i = 1; i < argc && !answered; i++) {
    PetscBool help = AsksHelp(argv[i]);
    answered = (help && !(i + 1 < argc && !strcmp(argv[i + 1], "petsc"))) ||
               !strcmp(argv[i], "-version") || !strcmp(argv[i], "--version");
    if (answered && !rank && help) {
      fputs(about, stdout);
      OptionsHelp(stdout);
    } else if (answered && !rank)
      ProgramVersion(stdout);
  }
  return (PetscBool)answered;
}

/* A process that nobody has launched together with others needs no network; Open MPI would look for
   one, which takes two thirds of the time to start. It needs no daemon to start others, which takes
   half of the rest; nor a directory to meet them in: processes that start and end side by side now
   and then remove each other's, and do not start. And it needs none of the plugins with which hwloc
   looks for cards: for those that draw it would ask every X server there may be; nor to know of the
   machine's cores and caches, whose files take a fifth of what is left to read. (Where no memory is
   named hwloc puts it in by a copy onto itself.) */
static const struct {
  const char *name, *value;
} alone[] = {{"OMPI_MCA_pml", "ob1"},
             {"OMPI_MCA_btl", "self"}, /* shared memory would be left behind */
             {"OMPI_MCA_ess_singleton_isolated", "1"},
             {"OMPI_MCA_orte_create_session_dirs", "0"},
             {"HWLOC_PLUGINS_PATH", "/dev/null"},
             {"HWLOC_SYNTHETIC", "numa:1 core:1 pu:1"}};

/* ProgramBeginMpi - MPI_Init(), of a process that may be alone. Returns 0 if all is well.

   tidy  the environment is a host program's, and is then as it was */
int ProgramBeginMpi(int *argc, char ***argv, PetscBool tidy) {
  static const char *const launched[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK",
                                         "SLURM_PROCID"};
  PetscBool mine[PETSC_STATIC_ARRAY_LENGTH(alone)] = {PETSC_FALSE}, others = PETSC_FALSE;
  int failed;

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(launched); i++)
    if (getenv(launched[i])) others = PETSC_TRUE;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(alone) && !others; i++) {
    mine[i] = (PetscBool)!getenv(alone[i].name); /* unless told otherwise */
    if (mine[i]) (void)setenv(alone[i].name, alone[i].value, PETSC_FALSE);
  }
  failed = MPI_Init(argc, argv) != MPI_SUCCESS;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(alone) && tidy; i++)
    if (mine[i]) (void)unsetenv(alone[i].name);
  return failed;
}

/*
  ProgramBegin - begins the program: MPI, PETSc and SLEPc with the command line's options.
  Collective on all processes; the caller ends it with ProgramEnd().

  self  is set; it lives until ProgramEnd()
  done  the command line asked for help or the version, or is wrong: there is nothing to run, and
        nothing to finalize
  returns 0, or 1 if the command line is wrong or PETSc does not begin (the line is out)
*/
int ProgramBegin(Program *self, int *argc, char ***argv, PetscBool *done) {
  int begun, failed;

  *self = (Program){0};
  signal(SIGPIPE, SIG_IGN); /* "| head" is no reason to lose a run */
  signal(SIGXFSZ, SIG_IGN); /* a file that may grow no more shows when it is written */
  HdfBegin();
  MPI_Initialized(&begun);
  self->began_mpi = (PetscBool)!begun;
  if (self->began_mpi) (void)ProgramBeginMpi(argc, argv, PETSC_FALSE);
  ProgramSetTable();
  *done = Answered(*argc, *argv);
  failed = *done ? 0 : OptionsTakeWords(&self->line, argc, argv);
  *done = (PetscBool)(*done || failed || Answered(*argc, *argv));
  if (!*done && SlepcInitialize(argc, argv, NULL, about)) *done = PETSC_TRUE, failed = 1;
  if (*done) {
    if (self->began_mpi) MPI_Finalize();
    OptionsFreeWords(&self->line);
    return failed;
  }
  signal(SIGPIPE, SIG_IGN); /* once more: PETSc has handlers of its own */
  signal(SIGXFSZ, SIG_IGN);
  failed = ErrorsBegin(PETSC_COMM_WORLD, PETSC_FALSE, &self->errors) ||
           OptionsPush(PETSC_COMM_WORLD, NULL, &self->line) || VBDFRegister();
  return failed;
}

/* ProgramEnd - ends what ProgramBegin() began. Returns 0 if all is well. */
int ProgramEnd(Program *self) {
  int failed = OptionsPop() != 0, ranks;
  PetscBool given;

  /* what nothing reads has been refused; after an error PETSc would list all that was not reached
   */
  failed |= PetscOptionsHasName(NULL, NULL, "-options_left", &given) != 0;
  if (!given) failed |= PetscOptionsSetValue(NULL, "-options_left", "no") != 0;
  LocksEnd();
  failed |= ErrorsEnd() != 0;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  if (self->errors.said && ranks > 1) ErrorsLastWords();
  failed |= SlepcFinalize() != 0;
  if (self->began_mpi) MPI_Finalize();
  OptionsFreeWords(&self->line);
  return failed;
}
