#include "tasks/single.h"
#include "tasks/accuracy.h"
#include "tasks/bent.h"
#include "tasks/critical.h"
#include "tasks/grow.h"
#include "straight/twist.h"
#include "straight/yielding.h"
#include "tasks/stability.h"

/* SingleShape - the slowest mode as initial shape, if that is asked for: the scene alone cannot
   know it. Collective. */
PetscErrorCode SingleShape(Scene scene) {
  PetscReal *s, *theta;
  PetscInt n;

  PetscFunctionBegin;
  if (scene->shape.type != SHAPE_MODE) PetscFunctionReturn(0);
  UserCheck(
      scene->clamp != CLAMP_HINGED, scene->comm,
      "-shape_type mode: begins tilted in a hinge, and shapes are measured against the clamp; "
      "give another -shape_type");
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

/* SingleAsked - reads what is asked for of a run, but for its scene. Collective. */
PetscErrorCode SingleAsked(PetscInt task, const char *output, Single *asked) {
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
  PetscFunctionReturn(0);
}

/* -task critical and stability are of a rod that is straight whatever happens along it. */
static PetscErrorCode CheckStraight(Scene scene) {
  const char *const about = "-task critical and stability are about a straight rod",
                    *const other = ", or -task critical -rod_model space";
  const PetscBool turned =
      (PetscBool)(scene->space.spin != 0 || scene->tip.torque != 0 || scene->curvature.any);

  PetscFunctionBegin;
  UserCheck(!CurvatureBends(&scene->curvature), scene->comm,
            "-rod_curvature: %s, straight by nature; give 0 or take it out%s", about, other);
  UserCheck(!scene->curvature.steered, scene->comm,
            "-rod_curvature_file: with /t its twist changes by itself, and %s; take /t out", about);
  UserCheck(scene->clamp != CLAMP_FREE, scene->comm,
            "-clamp_type free: %s that a clamp holds; take it out", about);
  UserCheck(scene->clamp == CLAMP_HELD || scene->tip.type != TIP_FREE, scene->comm,
            "-clamp_type hinged: %s, and one with a free tip swings about its hinge; give "
            "-tip_type pinned, clamped or slides",
            about);
  UserCheck(!scene->contact.any, scene->comm, "-%s: %s that touches nothing; take it out",
            scene->contact.self ? "contact_self" : "wall_file", about);
  UserCheck(
      SpaceIsAlong(scene->load.weight), scene->comm,
      "-rod_weight: a weight across the rod bends it, and %s; give it the clamp's direction%s",
      about, other);
  UserCheck(SpaceIsAlong(scene->tip.push), scene->comm,
            "-tip_force_vector: a force across the rod bends it, and %s; give it the clamp's "
            "direction%s",
            about, other);
  UserCheck(scene->load.radius == 0 || !turned, scene->comm,
            "-friction_radius: twist that friction holds depends on how it came about; -task "
            "critical and stability know twist without it; take it out");
  UserCheck(!scene->changes, scene->comm, "-change_file: %s that nothing changes; take it out",
            about);
  UserCheck(!scene->tip.path, scene->comm,
            "-tip_path: %s whose tip stays where it is held; take it out", about);
  UserCheck(!TipPoints(&scene->tip) || scene->tip.torque == 0 || scene->space.spin == 0,
            scene->comm, "%s: turns a clamped tip that -tip_torque lets turn; give one of them",
            SpaceClampOption(&scene->space));
  PetscFunctionReturn(0);
}

/* ... also of a rod whose material learns: nothing that it senses may bend it. */
static PetscErrorCode CheckLearns(Scene scene, PetscBool bent) {
  const Tropism *law = &scene->tropism;
  const char *const about = "-task critical and stability are about a straight rod";

  PetscFunctionBegin;
  UserCheck(
      !bent || scene->growth->yield == 0, scene->comm,
      "-growth_yield: the modes of a bent rod are known of one that grows whatever presses it; "
      "take it out");
  if (!TropismLearns(law)) PetscFunctionReturn(0);
  UserCheck(!bent, scene->comm,
            "-tropism_, -growth_ironing: the modes of a bent rod are known of one whose material "
            "learns nothing; take them out, or what bends it");
  UserCheck(law->nutation[0] == 0 && law->nutation[1] == 0, scene->comm,
            "-tropism_nutation: %s, which nutation bends; take it out", about);
  UserCheck(law->gravity == 0 || SpaceIsAlong(law->direction), scene->comm,
            "-tropism_direction: %s, and one that grows in another direction than its clamp's "
            "bends; give that of the clamp",
            about);
  UserCheck(law->light == 0 || SpaceIsAlong(law->source), scene->comm,
            "-tropism_source: %s, and a lamp beside it bends it; put it before the clamp", about);
  UserCheck(!StraightIsTwisted(scene), scene->comm,
            "-tropism_, -growth_ironing: -task critical and stability know twist of a rod whose "
            "material learns nothing; take one of both out");
  PetscFunctionReturn(0);
}

static PetscErrorCode RunTask(Scene scene, const Single *asked, Member *member) {
  PetscBool bent = PETSC_FALSE;

  PetscFunctionBegin;
  if (asked->task == TASK_CRITICAL) PetscCall(BentAsked(scene, &bent));
  if (!bent && (asked->task == TASK_STABILITY || asked->task == TASK_CRITICAL))
    PetscCall(CheckStraight(scene));
  if (asked->task == TASK_STABILITY || asked->task == TASK_CRITICAL)
    PetscCall(CheckLearns(scene, bent));
  if (scene->growth->yield > 0 && (asked->task == TASK_STABILITY || asked->task == TASK_CRITICAL))
    PetscCall(YieldingFollow(scene));
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
  SingleScene - reads what a run is asked for, and makes its scene. Collective on OptionsComm().

  output  as of SingleRun()
  asked   what concerns no scene
  scene   the caller destroys it, also after an error
*/
PetscErrorCode SingleScene(PetscInt task, const char *output, Single *asked, Scene *scene) {
  PetscFunctionBegin;
  PetscCall(SingleAsked(task, output, asked));
  if (task == TASK_GROW) PetscCall(AccuracyApply());
  PetscCall(SceneCreate(scene));
  if (task == TASK_GROW) PetscCall(SingleShape(*scene));
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
  Single asked;

  PetscFunctionBegin;
  error = SingleScene(task, output, &asked, &scene);
  if (!error) error = RunTask(scene, &asked, member);
  PetscCall(SceneDestroy(&scene));
  PetscCall(error);
  PetscCall(OptionsRefuseLeft());
  PetscFunctionReturn(0);
}
