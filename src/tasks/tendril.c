#include "tasks/tendril.h"
#include "base/hdf.h"
#include "record/event.h"
#include "record/restart.h"
#include "stepping/vbdf.h"
#include "tasks/accuracy.h"
#include "tasks/critical.h"
#include "tasks/grow.h"
#include "tasks/stability.h"
#include <signal.h>
#include <slepceps.h>

static const char about[] =
    "tendril: the slow growth of an elastic fibre that friction holds back.\n"
    "  tendril -options_file options/uniform-dry.opts [-output FILE.h5] [overrides]\n\n";

static const OptionRow rows[] = {
    ROW_WORD(
        "-task", "grow", "grow,stability,critical,units", PASSING,
        "what to do: follow the rod in time, tabulate its stability, find its critical length, "
        "print its laboratory units"),
    ROW_TEXT("-output", OUTPUT_FILE | PASSING, "result file (HDF5)")};
static const OptionGroup main_options = OPTION_GROUP("Task and files", rows);

static const OptionGroup *const table[] = {
    &main_options,      &restart_options,   &accuracy_options, &growth_options, &friction_options,
    &load_options,      &tip_options,       &contact_options,  &scene_options,  &stiffness_options,
    &curvature_options, &shape_options,     &grow_options,     &frame_options,  &event_options,
    &si_options,        &stability_options, &petsc_options};

enum { GROW, STABILITY, CRITICAL, UNITS };

/* The slowest mode as initial shape: the scene alone cannot know it. */
static PetscErrorCode TakeSlowestMode(Scene scene) {
  PetscReal *s, *theta;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(StabilitySlowestMode(scene, &n, &s, &theta));
  PetscCall(ShapeSetTable(&scene->shape, n, s, theta));
  PetscCall(PetscFree(s));
  PetscCall(PetscFree(theta));
  PetscFunctionReturn(0);
}

static PetscErrorCode PrintUnits(Scene scene) {
  PetscReal start, end;

  PetscFunctionBegin;
  PetscCall(OptionsRefuseUnread());
  PetscCall(GrowthLength(scene->growth, 0, &start, NULL));
  PetscCall(GrowthLength(scene->growth, scene->end_time, &end, NULL));
  PetscCall(SiPrint(&scene->si, scene->load.friction.mu, start, end));
  PetscFunctionReturn(0);
}

/* What is asked for, as far as it concerns no one else. */
typedef struct {
  PetscInt task;
  char output[PETSC_MAX_PATH_LEN], restart[PETSC_MAX_PATH_LEN];
} Asked;

static PetscErrorCode ReadOptions(Asked *asked) {
  PetscBool go_on;
  Si si;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(asked, sizeof(*asked)));
  PetscCall(RestartOptions(asked->restart, &go_on));
  PetscCall(SiSetFromOptions(&si)); /* from here on options may carry units */
  PetscCall(OptionsCheckPetsc());
  PetscCall(OptionWord("-task", &asked->task, NULL));
  PetscCall(OptionText("-output", asked->output, NULL));
  UserCheck(!go_on || asked->task == GROW, OptionsComm(),
            "-restart: only -task grow has something to go on with; take it out");
  PetscCall(OptionsCheckTypes());
  if (asked->task == GROW) PetscCall(AccuracyApply());
  PetscFunctionReturn(0);
}

static PetscErrorCode RunTask(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  UserCheck(asked->task == GROW || asked->task == UNITS || !scene->curvature.any, scene->comm,
            "-rod_curvature: -task critical and stability are about a rod that is straight by "
            "nature; take it out");
  UserCheck(asked->task == GROW || asked->task == UNITS || !scene->contact.any, scene->comm,
            "-%s: -task critical and stability are about a straight rod that touches nothing; take "
            "it out",
            scene->contact.self ? "contact_self" : "wall_file");
  if (scene->shape.type == SHAPE_MODE && asked->task == GROW) PetscCall(TakeSlowestMode(scene));
  if (asked->task == UNITS)
    PetscCall(PrintUnits(scene));
  else if (asked->task == GROW)
    PetscCall(GrowRun(scene, asked->output, asked->restart));
  else if (asked->task == STABILITY)
    PetscCall(StabilityRun(scene, asked->output));
  else
    PetscCall(CriticalRun(scene, asked->output));
  PetscFunctionReturn(0);
}

/* TendrilRun - does what the options ask for (-task), from the scene to the result. Collective;
   after TendrilInitialize(). A failure has been told when it returns, and all is freed. */
PetscErrorCode TendrilRun(void) {
  PetscErrorCode error;
  Scene scene = NULL;
  Asked asked;

  PetscFunctionBegin;
  PetscCall(ReadOptions(&asked));
  error = SceneCreate(&scene);
  if (!error) error = RunTask(scene, &asked);
  PetscCall(SceneDestroy(&scene));
  PetscCall(error);
  PetscCall(OptionsRefuseLeft());
  PetscFunctionReturn(0);
}

/* TendrilVersion - the versions of tendril and of what it was built with. */
void TendrilVersion(FILE *file) {
  fprintf(file, "tendril %s, PETSc %d.%d.%d, SLEPc %d.%d.%d\n", TENDRIL_VERSION,
          PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, SLEPC_VERSION_MAJOR,
          SLEPC_VERSION_MINOR, SLEPC_VERSION_SUBMINOR);
}

/* -help and -version are answered at once; -help petsc goes on, for PETSc to tell. */
static PetscBool Answered(int argc, char **argv) {
  int rank, answered = 0;

  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (int i = 1; i < argc && !answered; i++) {
    PetscBool help = (PetscBool)!strcmp(argv[i], "-help");
    answered =
        (help && !(i + 1 < argc && !strcmp(argv[i + 1], "petsc"))) || !strcmp(argv[i], "-version");
    if (answered && !rank && help) {
      fputs(about, stdout);
      OptionsHelp(stdout);
    } else if (answered && !rank)
      TendrilVersion(stdout);
  }
  return (PetscBool)answered;
}

static ErrorState errors;
static PetscBool began_mpi;

/*
  TendrilInitialize - begins the program: MPI, PETSc and SLEPc with the command line's options.
  Collective on all processes; the caller ends it with TendrilFinalize().

  done  the command line asked for help or the version, or is wrong: there is nothing to run, and
        nothing to finalize
  returns 0, or 1 if the command line is wrong or PETSc does not begin (the line is out)
*/
int TendrilInitialize(int *argc, char ***argv, PetscBool *done) {
  int begun, failed;

  signal(SIGPIPE, SIG_IGN); /* "| head" is no reason to lose a run */
  signal(SIGXFSZ, SIG_IGN); /* a file that may grow no more shows when it is written */
  HdfBegin();
  MPI_Initialized(&begun);
  began_mpi = (PetscBool)!begun;
  if (began_mpi) MPI_Init(argc, argv);
  OptionsSetTable(PETSC_STATIC_ARRAY_LENGTH(table), table);
  failed = OptionsCheckWords(*argc, *argv);
  *done = (PetscBool)(failed || Answered(*argc, *argv));
  if (!*done && SlepcInitialize(argc, argv, NULL, about)) *done = PETSC_TRUE, failed = 1;
  if (*done) {
    if (began_mpi) MPI_Finalize();
    return failed;
  }
  signal(SIGPIPE, SIG_IGN); /* once more: PETSc has handlers of its own */
  signal(SIGXFSZ, SIG_IGN);
  failed = ErrorsBegin(PETSC_COMM_WORLD, PETSC_FALSE, &errors) ||
           OptionsPush(PETSC_COMM_WORLD, NULL) || VBDFRegister();
  return failed;
}

/* TendrilFinalize - ends what TendrilInitialize() began. Returns 0 if all is well. */
int TendrilFinalize(void) {
  int failed = OptionsPop() != 0;
  PetscBool given;

  /* what nothing reads has been refused; after an error PETSc would list all that was not reached
   */
  failed |= PetscOptionsHasName(NULL, NULL, "-options_left", &given) != 0;
  if (!given) failed |= PetscOptionsSetValue(NULL, "-options_left", "no") != 0;
  failed |= ErrorsEnd() != 0;
  failed |= SlepcFinalize() != 0;
  if (began_mpi) MPI_Finalize();
  return failed;
}
