#include "scene/change.h"
#include "base/text.h"

enum { MOST_WORDS = 12 };

/* A change that is asked for: from t on, with the words of its value. trial: all is looked at, and
   nothing that scenes share is touched. */
typedef struct {
  const char *name;
  PetscReal t;
  PetscInt n;
  char *word[MOST_WORDS];
  PetscBool trial;
} Asked;

/* A row of the table: what, why the scene cannot have it changed at t (NULL: it can), and what its
   new value does from then on. That of an option the options have; others are words, of which form
   says what they are. */
typedef struct {
  const char *name;
  const char *form; /* NULL: an option */
  const char *(*refuses)(Scene, PetscReal t);
  PetscErrorCode (*change)(Scene, const Asked *asked);
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
  if (LoadHas(&scene->load, &friction_own)) return "the friction law of one's own says it";
  if (scene->load.shared || scene->load.limit || LoadIsDry(&scene->load))
    return "in a run that began with dry friction it stays as it was";
  return NULL;
}

static PetscErrorCode ChangeForce(Scene scene, const Asked *asked) {
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
static PetscErrorCode ChangeFriction(Scene scene, const Asked *asked) {
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

static PetscErrorCode ChangeEnd(Scene scene, const Asked *asked) {
  PetscReal end;
  char text[2][64];

  PetscFunctionBegin;
  PetscCall(OptionReal("-ts_max_time", &end, NULL));
  OptionBoth(end, UNIT_TIME, text[0]);
  UserCheck(end > asked->t, scene->comm, "-ts_max_time %s: the run is at %s already", text[0],
            OptionBoth(asked->t, UNIT_TIME, text[1]));
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

static PetscErrorCode ChangeSpin(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  PetscCall(SpaceChangeSpin(&scene->space, asked->t));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeTorque(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  PetscCall(SpaceChangeTorque(&scene->space, &scene->tip));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangePush(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  PetscCall(SpaceChangePush(&scene->space, &scene->tip));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeWeight(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  PetscCall(SpaceChangeWeight(&scene->space, &scene->load));
  PetscFunctionReturn(0);
}

/* ---- by words ---- */

/* The k-th word of a value as a number. */
static PetscErrorCode Number(const Asked *asked, PetscInt k, Dimension dimension,
                             PetscReal *value) {
  PetscFunctionBegin;
  PetscCall(OptionQuantity(asked->name, asked->word[k], dimension, value));
  PetscFunctionReturn(0);
}

/* The time by which something is to be there. */
static PetscErrorCode By(Scene scene, const Asked *asked, PetscInt k, PetscReal *by) {
  char text[2][64];

  PetscFunctionBegin;
  PetscCall(Number(asked, k, UNIT_TIME, by));
  UserCheck(*by > asked->t, scene->comm, "%s %s: the run is at t = %s already; give a later time",
            asked->name, OptionBoth(*by, UNIT_TIME, text[0]),
            OptionBoth(asked->t, UNIT_TIME, text[1]));
  PetscFunctionReturn(0);
}

static const char *RefusesFeed(Scene scene, PetscReal t) {
  return strcmp(scene->growth->type, "feed") ? "only a rod that is fed has a speed of feeding: "
                                               "-growth_type feed"
                                             : NULL;
}

static PetscErrorCode ChangeFeed(Scene scene, const Asked *asked) {
  PetscReal speed, length;

  PetscFunctionBegin;
  PetscCall(Number(asked, 0, UNIT_SPEED, &speed));
  PetscCall(GrowthLength(scene->growth, asked->t, &length, NULL));
  length += PetscMax(speed, 0) * (scene->end_time - asked->t);
  UserCheck(
      length <= scene->reach * (1 + 1e-9) || !CurvatureIsTable(&scene->curvature), scene->comm,
      "%s: so fed the rod gets longer than its natural curvature is laid out for", asked->name);
  if (asked->trial) PetscFunctionReturn(0);
  PetscCall(GrowthFeedOn(scene->growth, asked->t, speed));
  scene->reach = PetscMax(scene->reach, length);
  PetscFunctionReturn(0);
}

static const char *RefusesFactor(Scene scene, PetscReal t) {
  return LoadHas(&scene->load, &friction_own) ? "the friction law of one's own says it" : NULL;
}

static PetscErrorCode ChangeFactor(Scene scene, const Asked *asked) {
  const PetscReal least = 1e-3, most = 1e3;
  PetscReal factor;

  PetscFunctionBegin;
  PetscCall(Number(asked, 0, UNIT_NONE, &factor));
  UserCheck(factor >= least && factor <= most, scene->comm, "%s %g: give %g to %g", asked->name,
            (double)factor, (double)least, (double)most);
  LoadSetFactor(&scene->load, factor);
  PetscFunctionReturn(0);
}

static const char *RefusesWallFriction(Scene scene, PetscReal t) {
  return ContactWallsRub(&scene->contact)
             ? NULL
             : "no wall has friction in it; begin it with a little, friction 1e-3 in its line";
}

/* Which wall of the plane, or surface, stands in a line of the wall file; the other is -1. */
static PetscErrorCode WallOf(Scene scene, const Asked *asked, PetscInt *wall, PetscInt *surface) {
  const Walls *walls = &scene->contact.walls;
  const Surfaces *surfaces = &scene->contact.surfaces;
  PetscReal line;

  PetscFunctionBegin;
  *wall = *surface = -1;
  PetscCall(Number(asked, 0, UNIT_NONE, &line));
  for (PetscInt k = 0; k < walls->n; k++)
    if (walls->wall[k].line == line) *wall = k;
  for (PetscInt k = 0; k < surfaces->n; k++)
    if (surfaces->surface[k].line == line) *surface = k;
  UserCheck(*wall >= 0 || *surface >= 0, scene->comm,
            "%s %g: there is no wall in this line of -wall_file", asked->name, (double)line);
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeWallFriction(Scene scene, const Asked *asked) {
  const PetscReal most = 100;
  PetscInt wall, surface;
  PetscReal mu;

  PetscFunctionBegin;
  PetscCall(WallOf(scene, asked, &wall, &surface));
  PetscCall(Number(asked, 1, UNIT_NONE, &mu));
  UserCheck(mu >= 0 && mu <= most, scene->comm, "%s: friction must be from 0 to %g", asked->name,
            (double)most);
  if (asked->trial) PetscFunctionReturn(0);
  if (wall >= 0) scene->contact.walls.wall[wall].friction = mu;
  if (surface >= 0) scene->contact.surfaces.surface[surface].friction = mu;
  PetscFunctionReturn(0);
}

static const char *RefusesWalls(Scene scene, PetscReal t) {
  return scene->contact.surfaces.n || scene->contact.walls.n ? NULL : "there is no wall";
}

/* The displacement that stands behind word k; x3 may be left out. */
static PetscErrorCode Shift(Scene scene, const Asked *asked, PetscInt k, PetscReal x[3]) {
  PetscFunctionBegin;
  x[2] = 0;
  for (PetscInt d = 0; d < 3 && k + d < asked->n; d++)
    PetscCall(Number(asked, k + d, UNIT_LENGTH, &x[d]));
  PetscFunctionReturn(0);
}

static PetscErrorCode MoveWall(Scene scene, const Asked *asked, PetscReal by, PetscInt k) {
  Surfaces *surfaces = &scene->contact.surfaces;
  PetscInt wall, surface;
  PetscReal x[3];

  PetscFunctionBegin;
  PetscCall(WallOf(scene, asked, &wall, &surface));
  PetscCall(Shift(scene, asked, k, x));
  UserCheck(wall < 0 || x[2] == 0, scene->comm,
            "%s: leads a wall of the plane, which stays in it, along x3; let that be 0",
            asked->name);
  if (asked->trial) PetscFunctionReturn(0);
  if (wall >= 0) {
    PetscCall(WallsLeadTo(&scene->contact.walls, wall, asked->t, by, x));
    PetscFunctionReturn(0);
  }
  PetscCall(MotionLeadTo(&surfaces->surface[surface].motion, asked->t, by, x));
  PetscCall(SurfacesIndexAnew(surfaces));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeWallTo(Scene scene, const Asked *asked) {
  PetscReal by;

  PetscFunctionBegin;
  PetscCall(By(scene, asked, 1, &by));
  PetscCall(MoveWall(scene, asked, by, 2));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeWallAt(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  PetscCall(MoveWall(scene, asked, asked->t, 1));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeWallTurn(Scene scene, const Asked *asked) {
  Surfaces *surfaces = &scene->contact.surfaces;
  PetscReal by, angle, middle[3];
  PetscInt wall, surface;

  PetscFunctionBegin;
  PetscCall(WallOf(scene, asked, &wall, &surface));
  PetscCall(By(scene, asked, 1, &by));
  PetscCall(Number(asked, 2, UNIT_ANGLE, &angle));
  if (asked->trial) PetscFunctionReturn(0);
  if (wall >= 0) {
    PetscCall(WallsTurnTo(&scene->contact.walls, wall, asked->t, by, angle));
    PetscFunctionReturn(0);
  }
  SurfaceMiddle(&surfaces->surface[surface], middle);
  PetscCall(MotionTurnTo(&surfaces->surface[surface].motion, asked->t, by, angle, middle));
  PetscCall(SurfacesIndexAnew(surfaces));
  PetscFunctionReturn(0);
}

static PetscErrorCode LeadStrain(Scene scene, const Asked *asked, int strain) {
  const PetscReal most = 1e9;
  PetscReal by, k;

  PetscFunctionBegin;
  UserCheck(strain == BEND_3 || scene->space.rod, scene->comm,
            "%s: takes the rod out of the plane, in which this run is; begin it with -rod_model "
            "space",
            asked->name);
  PetscCall(By(scene, asked, 0, &by));
  PetscCall(Number(asked, 1, UNIT_CURVATURE, &k));
  UserCheck(PetscAbsReal(k) <= most, scene->comm, "%s %g: is too large", asked->name, (double)k);
  CurvatureLeadTo(&scene->curvature, strain, asked->t, by, k);
  PetscFunctionReturn(0);
}

static const char *RefusesBend(Scene scene, PetscReal t) {
  return scene->curvature.own ? "the curvature of one's own says it" : NULL;
}

static PetscErrorCode ChangeBend(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  PetscCall(LeadStrain(scene, asked, BEND_3));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeBend2(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  PetscCall(LeadStrain(scene, asked, BEND_2));
  PetscFunctionReturn(0);
}

static PetscErrorCode ChangeTwist(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  PetscCall(LeadStrain(scene, asked, TURN_1));
  PetscFunctionReturn(0);
}

static const char *RefusesLead(Scene scene, PetscReal t) {
  if (scene->tip.type == TIP_FREE) return "the tip is free; -tip_type pinned or clamped holds it";
  if (scene->tip.type == TIP_SLIDES) return "the tip slides";
  return scene->tip.path ? "-tip_path says where the tip is" : NULL;
}

static PetscErrorCode ChangeTipPlace(Scene scene, const Asked *asked) {
  PetscReal by, lab[3], x[3], length, away = 0;

  PetscFunctionBegin;
  PetscCall(By(scene, asked, 0, &by));
  PetscCall(Shift(scene, asked, 1, lab));
  for (int i = 0; i < 3; i++) {
    x[i] = 0;
    for (int j = 0; j < 3; j++) x[i] += scene->space.lab[j][i] * lab[j];
    away += PetscSqr(x[i]);
  }
  PetscCall(GrowthLength(scene->growth, asked->t, &length, NULL));
  UserCheck(scene->clamp == CLAMP_FREE || away < PetscSqr(length), scene->comm,
            "%s: is farther from the clamp than the rod is long", asked->name);
  UserCheck(lab[2] == 0 || scene->space.rod, scene->comm,
            "%s: leads the tip out of the plane, in which this run is", asked->name);
  TipLeadTo(&scene->tip, asked->t, by, x);
  PetscFunctionReturn(0);
}

static const char *RefusesTurn(Scene scene, PetscReal t) {
  if (scene->tip.type != TIP_CLAMPED) return "the tip's direction is free";
  if (scene->space.rod) return "it is for a rod in the plane";
  return scene->tip.path ? "-tip_path says where the tip is" : NULL;
}

static PetscErrorCode ChangeTipTurn(Scene scene, const Asked *asked) {
  PetscReal by, angle;

  PetscFunctionBegin;
  PetscCall(By(scene, asked, 0, &by));
  PetscCall(Number(asked, 1, UNIT_ANGLE, &angle));
  TipTurnTo(&scene->tip, asked->t, by, angle - scene->clamp_angle);
  PetscFunctionReturn(0);
}

static const char *RefusesSense(Scene scene, PetscReal t) {
  return scene->tropism.any ? NULL : "nothing in it learns its bend";
}

static PetscErrorCode ChangeSense(Scene scene, const Asked *asked) {
  PetscFunctionBegin;
  PetscCall(TropismChange(&scene->tropism, asked->name, (const PetscReal(*)[3])scene->space.lab,
                          scene->space.place, scene->space.rod));
  PetscFunctionReturn(0);
}

static const Change changes[] = {
    {"-clamp_spin", NULL, RefusesSpin, ChangeSpin},
    {"-tip_force", NULL, RefusesTip, ChangeForce},
    {"-tip_torque", NULL, RefusesTip, ChangeTorque},
    {"-tip_force_vector", NULL, RefusesTip, ChangePush},
    {"-rod_weight", NULL, NULL, ChangeWeight},
    {"-friction_mu", NULL, RefusesFriction, ChangeFriction},
    {"-ts_max_time", NULL, NULL, ChangeEnd},
    {"-feed_speed", "SPEED", RefusesFeed, ChangeFeed},
    {"-friction_factor", "FACTOR", RefusesFactor, ChangeFactor},
    {"-wall_friction", "LINE MU", RefusesWallFriction, ChangeWallFriction},
    {"-wall_to", "LINE T X1 X2 X3", RefusesWalls, ChangeWallTo},
    {"-wall_turn_to", "LINE T ANGLE", RefusesWalls, ChangeWallTurn},
    {"-wall_at", "LINE X1 X2 X3", RefusesWalls, ChangeWallAt},
    {"-curvature_to", "T K", RefusesBend, ChangeBend},
    {"-curvature_2_to", "T K", RefusesBend, ChangeBend2},
    {"-twist_to", "T K", RefusesBend, ChangeTwist},
    {"-tip_to", "T X1 X2 X3", RefusesLead, ChangeTipPlace},
    {"-tip_turn_to", "T ANGLE", RefusesTurn, ChangeTipTurn},
    {"-tropism_source", NULL, RefusesSense, ChangeSense},
    {"-tropism_direction", NULL, RefusesSense, ChangeSense},
    {"-tropism_light", NULL, RefusesSense, ChangeSense},
    {"-tropism_gravity", NULL, RefusesSense, ChangeSense},
    {"-tropism_proprioception", NULL, RefusesSense, ChangeSense},
    {"-tropism_nutation", NULL, RefusesSense, ChangeSense},
    {"-growth_ironing", NULL, RefusesSense, ChangeSense},
};

static const Change *Find(const char *name) {
  while (*name == '-') name++;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(changes); k++)
    if (!strcmp(name, changes[k].name + 1)) return &changes[k];
  return NULL;
}

/* SceneChangedOption - the option whose value a change is; NULL: it is given by words. */
const OptionRow *SceneChangedOption(const char *name) {
  const Change *change = Find(name);

  return change && !change->form ? OptionFind(change->name) : NULL;
}

/* All names. */
static void Names(char all[], size_t room) {
  all[0] = 0;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(changes); k++)
    (void)snprintf(all + strlen(all), room - strlen(all), "%s%s", k ? ", " : "", changes[k].name);
}

/* The change of a name, refused where there is none or this scene cannot have it at t; mark: behind
   the name in what is said. */
static PetscErrorCode Allowed(Scene scene, const char *name, const char *mark, PetscReal t,
                              const Change **change) {
  const char *why;
  char all[1024];

  PetscFunctionBegin;
  *change = Find(name);
  Names(all, sizeof(all));
  UserCheck(*change, scene->comm, "%s%s cannot be changed in a run; there can %s", name, mark, all);
  why = (*change)->refuses ? (*change)->refuses(scene, t) : NULL;
  UserCheck(!why, scene->comm, "%s%s cannot be changed in this run: %s", name, mark, why);
  PetscFunctionReturn(0);
}

/* Takes a value apart; the caller frees the text. */
static PetscErrorCode TakeWords(Scene scene, const Change *change, const char *value, char **text,
                                Asked *asked) {
  PetscInt wanted = 1;

  PetscFunctionBegin;
  PetscCall(PetscStrallocpy(value, text));
  asked->n = TextWords(*text, " \t,", MOST_WORDS, asked->word);
  for (const char *c = change->form ? change->form : ""; *c; c++) wanted += *c == ' ';
  if (change->form && strstr(change->form, " X3") && asked->n == wanted - 1) wanted--;
  UserCheck(!change->form || asked->n == wanted, scene->comm, "%s %s: give %s", change->name, value,
            change->form);
  PetscFunctionReturn(0);
}

static PetscErrorCode Do(Scene scene, const Change *change, const char *value, PetscReal t,
                         PetscBool trial) {
  Asked asked = {.name = change->name, .t = t, .trial = trial};
  PetscErrorCode error;
  char *text = NULL;

  PetscFunctionBegin;
  error = TakeWords(scene, change, value, &text, &asked);
  if (!error) error = change->change(scene, &asked);
  PetscCall(PetscFree(text));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* SceneMayChange - refuses what cannot be changed in a run at t, or not to this value (which, if it
   is an option's, the options have by now). Collective. */
PetscErrorCode SceneMayChange(Scene scene, const char *name, const char *value, PetscReal t) {
  const Change *change;
  PetscErrorCode error;
  Scene trial;

  PetscFunctionBegin;
  PetscCall(Allowed(scene, name, ":", t, &change));
  PetscCall(SceneShare(scene, &trial));
  error = Do(trial, change, value, t, PETSC_TRUE);
  PetscCall(SceneShareEnd(&trial));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* SceneChange - lets the value (if it is an option's, the one that the options have by now) be in
   force from t on. After SceneMayChange(). Collective. */
PetscErrorCode SceneChange(Scene scene, const char *name, const char *value, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(Do(scene, Find(name), value, t, PETSC_FALSE));
  scene->contact.time = PETSC_MIN_REAL;
  PetscCall(SceneContactAt(scene, t));
  PetscFunctionReturn(0);
}

/* SceneHasRoom - is none of the rod's places, in the clamp's frame, where -wall_at puts a wall?
   After SceneMayChange(). Collective; n may be 0 on some ranks. */
PetscErrorCode SceneHasRoom(Scene scene, const char *value, PetscReal t, PetscInt n,
                            const PetscReal x[][3], PetscBool *has) {
  const Change *change = Find("-wall_at");
  Asked asked = {.name = change->name, .t = t};
  const Walls *walls = &scene->contact.walls;
  const PetscReal half = scene->contact.diameter / 2;
  PetscReal lab[3], shift[3], y[3], gap;
  PetscInt wall, surface;
  WallPose pose;
  char *text;

  PetscFunctionBegin;
  PetscCall(TakeWords(scene, change, value, &text, &asked));
  PetscCall(WallOf(scene, &asked, &wall, &surface));
  PetscCall(Shift(scene, &asked, 1, shift));
  PetscCall(PetscFree(text));
  *has = PETSC_TRUE;
  if (wall >= 0) pose = WallPoseShifted(walls, wall, shift);
  for (PetscInt i = 0; i < n && *has; i++) {
    ScenePlaceToLab(scene, x[i], lab);
    if (scene->space.rod) ContactToWalls(&scene->contact, x[i], y);
    gap = wall >= 0
              ? WallGap(walls, wall, &pose, scene->space.rod ? y : x[i], half)
              : SurfaceShifted(&scene->contact.surfaces.surface[surface], t, shift, lab) - half;
    *has = (PetscBool)(gap >= 0);
  }
  PetscFunctionReturn(0);
}

/* SceneLampHasRoom - ... where -tropism_source, which the options have by now, puts the lamp? Of a
   rod without a diameter, as near as a thousandth of its length. */
PetscErrorCode SceneLampHasRoom(Scene scene, const char *value, PetscReal t, PetscInt n,
                                const PetscReal x[][3], PetscBool *has) {
  const PetscReal part = 1e-3;
  Tropism trial = scene->tropism;
  PetscReal length;

  PetscFunctionBegin;
  PetscCall(TropismChange(&trial, "-tropism_source", (const PetscReal(*)[3])scene->space.lab,
                          scene->space.place, scene->space.rod));
  PetscCall(GrowthLength(scene->growth, t, &length, NULL));
  *has = PETSC_TRUE;
  for (PetscInt i = 0; i + 1 < n && *has; i++)
    *has = (PetscBool)(TropismNearLamp(&trial, x[i], x[i + 1]) >
                       PetscMax(scene->contact.diameter / 2, part * length));
  PetscFunctionReturn(0);
}

/* SceneChangeAbout - lines about mistakes name the row; NULL: no longer. */
void SceneChangeAbout(const ChangeRow *row) {
  char text[96] = "", t[64];

  if (row)
    (void)snprintf(text, sizeof(text),
                   "-change_file: at t = %s: ", OptionBoth(row->t, UNIT_TIME, t));
  ErrorsAbout(text);
}

static PetscErrorCode CheckRow(Scene scene, const ChangeRow *row, PetscReal from) {
  const Change *change;
  char text[64], *words = NULL;
  PetscErrorCode error;
  Asked asked;

  PetscFunctionBegin;
  PetscCall(Allowed(scene, row->what, "", row->t, &change));
  UserCheck(row->t >= from, scene->comm,
            "%s %s was no change of the run that -restart goes on with at t = %s; take the row "
            "out, or begin that run anew",
            row->what, row->value, OptionBoth(from, UNIT_TIME, text));
  error = TakeWords(scene, change, row->value, &words, &asked);
  PetscCall(PetscFree(words));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* SceneChangesCheck - refuses rows to come that no run can have.

   from  when the run begins: what another one did before is in force already. Collective. */
PetscErrorCode SceneChangesCheck(Scene scene, PetscReal from) {
  const Changes list = scene->changes;

  PetscFunctionBegin;
  for (PetscInt k = list ? list->done : 0; list && k < list->n; k++) {
    SceneChangeAbout(&list->row[k]);
    PetscCall(CheckRow(scene, &list->row[k], from));
  }
  SceneChangeAbout(NULL);
  PetscFunctionReturn(0);
}
