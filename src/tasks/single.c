#include "tasks/single.h"
#include "tasks/accuracy.h"
#include "tasks/critical.h"
#include "tasks/grow.h"
#include "tasks/stability.h"

/* What is asked for, as far as it concerns no one else. */
typedef struct {
  PetscInt task;
  char output[PETSC_MAX_PATH_LEN], restart[PETSC_MAX_PATH_LEN];
} Asked;

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

static PetscErrorCode ReadOptions(PetscInt task, const char *output, Asked *asked) {
  PetscBool go_on;
  Si si;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(asked, sizeof(*asked)));
  asked->task = task;
  PetscCall(RestartOptions(asked->restart, &go_on));
  PetscCall(SiSetFromOptions(&si)); /* from here on options may carry units */
  PetscCall(OptionsCheckPetsc());
  if (output)
    PetscCall(PetscStrncpy(asked->output, output, sizeof(asked->output)));
  else
    PetscCall(OptionText("-output", asked->output, NULL));
  UserCheck(!go_on || asked->task == TASK_GROW, OptionsComm(),
            "-restart: only -task grow has something to go on with; take it out");
  PetscCall(OptionsCheckTypes());
  if (asked->task == TASK_GROW) PetscCall(AccuracyApply());
  PetscFunctionReturn(0);
}

/* -task critical and stability are of a rod in the plane, pushed along itself. */
static PetscErrorCode CheckStraight(Scene scene) {
  const Space *space = &scene->space;

  PetscFunctionBegin;
  UserCheck(!space->why && !space->only, scene->comm,
            "%s: -task critical and stability are about a rod in the plane; take it out",
            space->why ? space->why : space->only);
  UserCheck(!scene->load.weighs && scene->tip.push[0] == 0 && scene->tip.push[1] == 0, scene->comm,
            "-%s: -task critical and stability know growth, friction and -tip_force only; take it "
            "out",
            scene->load.weighs ? "rod_weight" : "tip_force_vector");
  PetscFunctionReturn(0);
}

static PetscErrorCode RunTask(Scene scene, const Asked *asked, Member *member) {
  PetscFunctionBegin;
  UserCheck(asked->task == TASK_GROW || asked->task == TASK_UNITS || !scene->curvature.any,
            scene->comm,
            "-rod_curvature: -task critical and stability are about a rod that is straight by "
            "nature; take it out");
  UserCheck(asked->task == TASK_GROW || asked->task == TASK_UNITS || !scene->contact.any,
            scene->comm,
            "-%s: -task critical and stability are about a straight rod that touches nothing; take "
            "it out",
            scene->contact.self ? "contact_self" : "wall_file");
  if (asked->task == TASK_STABILITY || asked->task == TASK_CRITICAL)
    PetscCall(CheckStraight(scene));
  if (scene->shape.type == SHAPE_MODE && asked->task == TASK_GROW)
    PetscCall(TakeSlowestMode(scene));
  if (member && asked->task == TASK_GROW)
    PetscCall(GrowMember(scene, asked->output, member));
  else if (member)
    PetscCall(CriticalMember(scene, asked->output, member));
  else if (asked->task == TASK_UNITS)
    PetscCall(PrintUnits(scene));
  else if (asked->task == TASK_GROW)
    PetscCall(GrowRun(scene, asked->output, asked->restart));
  else if (asked->task == TASK_STABILITY)
    PetscCall(StabilityRun(scene, asked->output));
  else
    PetscCall(CriticalRun(scene, asked->output));
  PetscFunctionReturn(0);
}

/*
  SingleRun - does one run, of any task but a sweep, from its options to its result. Collective on
  OptionsComm().

  output  the result file, empty: none; NULL: as -output says
  member  of a sweep, of -task grow or critical: it gets what the run leaves; NULL: it is none

  A failure has been told, or its line kept, when it returns, and all is freed.
*/
PetscErrorCode SingleRun(PetscInt task, const char *output, Member *member) {
  PetscErrorCode error;
  Scene scene = NULL;
  Asked asked;

  PetscFunctionBegin;
  PetscCall(ReadOptions(task, output, &asked));
  error = SceneCreate(&scene);
  if (!error) error = RunTask(scene, &asked, member);
  PetscCall(SceneDestroy(&scene));
  PetscCall(error);
  PetscCall(OptionsRefuseLeft());
  PetscFunctionReturn(0);
}
