#include "scene/change.h"

/* A row of the table: an option, why the scene cannot have it changed at t (NULL: it can), and what
   its new value, which the options have, does from then on. */
typedef struct {
  const char *name;
  const char *(*refuses)(Scene, PetscReal t);
  PetscErrorCode (*change)(Scene, PetscReal t);
} Change;

static const char *RefusesSpin(Scene scene, PetscReal t) {
  if (scene->clamp == CLAMP_FREE) return "turns a clamp, and with -clamp_type free there is none";
  if (scene->space.clamp_path) return "-clamp_path says how the clamp turns";
  return NULL;
}

static const char *RefusesTip(Scene scene, PetscReal t) {
  return scene->tip.type == TIP_FREE ? NULL : "nothing pushes on a tip that -tip_type holds";
}

static const char *RefusesFriction(Scene scene, PetscReal t) {
  if (scene->load.friction.own) return "the friction law of one's own says it";
  if (scene->load.shared || scene->load.limit || LoadIsDry(&scene->load))
    return "in a run that began with dry friction it stays as it was";
  return NULL;
}

static PetscErrorCode ChangeForce(Scene scene, PetscReal t) {
  PetscReal force;

  PetscFunctionBegin;
  PetscCall(OptionReal("-tip_force", &force, NULL));
  UserCheck(scene->tip.law != TIP_RESISTANCE || force >= 0, scene->comm,
            "-tip_force: a resistance is not negative");
  scene->tip.force = force;
  PetscFunctionReturn(0);
}

/* Where it is not dry at the beginning it is not to be later on: dry friction is stepped otherwise.
 */
static PetscErrorCode ChangeFriction(Scene scene, PetscReal t) {
  Load load = scene->load;

  PetscFunctionBegin;
  PetscCall(OptionReal("-friction_mu", &load.friction.mu, NULL));
  load.viscous = load.friction.viscous = 1 - load.friction.mu;
  UserCheck(
      !LoadIsDry(&load), scene->comm,
      "-friction_mu %g: a run that began with viscous friction cannot go on with dry friction",
      (double)load.friction.mu);
  scene->load = load;
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeEnd(Scene scene, PetscReal t) {
  PetscReal end;
  char text[2][64];

  PetscFunctionBegin;
  PetscCall(OptionReal("-ts_max_time", &end, NULL));
  OptionBoth(end, UNIT_TIME, text[0]);
  UserCheck(end > t, scene->comm, "-ts_max_time %s: the run is at %s already", text[0],
            OptionBoth(t, UNIT_TIME, text[1]));
  UserCheck(end <= scene->growth->end_time * (1 + 1e-12), scene->comm,
            "-ts_max_time %s: the growth table ends at t = %s", text[0],
            OptionBoth(scene->growth->end_time, UNIT_TIME, text[1]));
  UserCheck(end <= scene->end_time || !scene->growth->slides ||
                !CurvatureIsTable(&scene->curvature),
            scene->comm,
            "-ts_max_time %s: natural curvature is laid out for a rod as long as at %s; begin the "
            "run with the later end",
            text[0], OptionBoth(scene->end_time, UNIT_TIME, text[1]));
  scene->end_time = end;
  PetscCall(GrowthLongest(scene->growth, end, &scene->reach));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeSpin(Scene scene, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(SpaceChangeSpin(&scene->space, t));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeTorque(Scene scene, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(SpaceChangeTorque(&scene->space, &scene->tip));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangePush(Scene scene, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(SpaceChangePush(&scene->space, &scene->tip));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeWeight(Scene scene, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(SpaceChangeWeight(&scene->space, &scene->load));
  PetscFunctionReturn(0);
}

static const Change changes[] = {
    {"-clamp_spin", RefusesSpin, ChangeSpin},  {"-tip_force", RefusesTip, ChangeForce},
    {"-tip_torque", RefusesTip, ChangeTorque}, {"-tip_force_vector", RefusesTip, ChangePush},
    {"-rod_weight", NULL, ChangeWeight},       {"-friction_mu", RefusesFriction, ChangeFriction},
    {"-ts_max_time", NULL, ChangeEnd},
};

static const Change *Find(const char *name) {
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(changes); k++)
    if (!strcmp(name, changes[k].name)) return &changes[k];
  return NULL;
}

/* SceneMayChange - refuses what cannot be changed in a run at t, or not to the value that the
   options have by now. Collective. */
PetscErrorCode SceneMayChange(Scene scene, const char *name, PetscReal t) {
  const Change *change = Find(name);
  const char *why = change && change->refuses ? change->refuses(scene, t) : NULL;
  PetscErrorCode error;
  char all[256] = "";
  Scene trial;

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(changes); k++)
    (void)snprintf(all + strlen(all), sizeof(all) - strlen(all), "%s%s", k ? ", " : "",
                   changes[k].name);
  UserCheck(change, scene->comm, "%s: cannot be changed in a run; there can %s", name, all);
  UserCheck(!why, scene->comm, "%s: cannot be changed in this run: %s", name, why);
  PetscCall(SceneShare(scene, &trial));
  error = change->change(trial, t);
  PetscCall(SceneShareEnd(&trial));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* SceneChange - lets the value that the options have by now be in force from t on. After
   SceneMayChange(). Collective. */
PetscErrorCode SceneChange(Scene scene, const char *name, PetscReal t) {
  const Change *change = Find(name);

  PetscFunctionBegin;
  PetscCall(change->change(scene, t));
  scene->contact.time = PETSC_MIN_REAL;
  PetscCall(SceneContactAt(scene, t));
  PetscFunctionReturn(0);
}
