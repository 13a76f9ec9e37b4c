/* tendril: the growth of an elastic fibre that friction holds back. Options -> scene -> task. */
#include "tasks/accuracy.h"
#include "stepping/chain.h"
#include "tasks/critical.h"
#include "tasks/grow.h"
#include "base/options.h"
#include "record/restart.h"
#include "tasks/stability.h"
#include "stepping/vbdf.h"
#include <signal.h>
#include <slepceps.h>

static const char help[] =
    "tendril: the slow growth of an elastic fibre that friction holds back.\n"
    "  tendril -options_file options/uniform-dry.opts [-output FILE.h5] [overrides]\n\n";

enum { GROW, STABILITY, CRITICAL, UNITS };

static PetscErrorCode Run(int argc, char **argv) {
  const char *const tasks[] = {"grow", "stability", "critical", "units"};
  char output[PETSC_MAX_PATH_LEN] = "", restart[PETSC_MAX_PATH_LEN] = "";
  PetscInt task = GROW;
  PetscBool go_on;
  Scene scene;

  PetscFunctionBegin;
  PetscCall(OptionsRefuseBareWords(argc, argv));
  PetscCall(RestartOptions(restart, sizeof(restart), &go_on));
  PetscCall(OptionsCheckPetsc());
  PetscCall(OptionList(
      "-task",
      "what to do: follow the rod in time, tabulate its stability, find its critical length", 4,
      tasks, &task, NULL));
  PetscCall(OptionString("-output", "result file (HDF5)", output, sizeof(output), NULL));
  UserCheck(!go_on || task == GROW, PETSC_COMM_WORLD,
            "-restart: -task %s has nothing to go on with; take it out", tasks[task]);
  PetscCall(VBDFRegister());
  PetscCall(ChainRegister());
  PetscCall(OptionsCheckTypes());
  if (task == GROW) PetscCall(AccuracyApply());
  PetscCall(SceneCreate(&scene));
  if (scene->shape.type == SHAPE_MODE && task == GROW) {
    PetscInt n;
    PetscReal *s, *theta;
    PetscCall(StabilitySlowestMode(scene, &n, &s, &theta));
    PetscCall(SceneSetShape(scene, n, s, theta));
    PetscCall(PetscFree(s));
    PetscCall(PetscFree(theta));
  }
  if (task == UNITS) {
    PetscReal start, end;
    PetscCall(OptionsRefuseUnread());
    PetscCall(GrowthLength(scene->growth, 0, &start, NULL));
    PetscCall(GrowthLength(scene->growth, scene->end_time, &end, NULL));
    PetscCall(SiPrint(&scene->si, scene->friction.mu, start, end));
    PetscCall(SceneDestroy(&scene));
    PetscFunctionReturn(0);
  }
  UserCheck(task == GROW || !scene->curvature.any, PETSC_COMM_WORLD,
            "-rod_curvature: -task %s is about a rod that is straight by nature; take it out",
            tasks[task]);
  if (task == GROW)
    PetscCall(GrowRun(scene, output, restart));
  else if (task == STABILITY)
    PetscCall(StabilityRun(scene, output));
  else
    PetscCall(CriticalRun(scene, output));
  PetscCall(SceneDestroy(&scene));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv) {
  int failed;

  MPI_Init(&argc, &argv);
  failed = OptionsCheckFiles(argc, argv);
  if (!failed) {
    for (int i = 1; i < argc; i++) /* or "-help | head" would end in PETSc's account of a signal */
      if (!strcmp(argv[i], "-help")) (void)PetscOptionsSetValue(NULL, "-no_signal_handler", NULL);
    signal(SIGPIPE, SIG_IGN);
    if (SlepcInitialize(&argc, &argv, NULL, help)) return 1;
    signal(SIGPIPE, SIG_IGN); /* "| head" is no reason to lose a run */
    PetscCall(PetscPushErrorHandler(UserErrorHandler, NULL));
    failed = Run(argc, argv) != 0;
    PetscCall(PetscPopErrorHandler());
    failed |= SlepcFinalize() != 0;
  }
  MPI_Finalize();
  return failed;
}
