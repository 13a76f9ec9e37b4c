#include "scene/scene.h"
#include "base/extremes.h"
#include <string.h>
#include <unistd.h>

static const OptionRow rows[] = {
    ROW_REAL("-clamp_angle", "0", -6.2832, 6.2832, UNIT_ANGLE, 0,
             "alpha, direction of the clamp, in radians (or degrees: 90deg)"),
    ROW_WORD("-clamp_type", "held", "held,hinged,free,ball", 0,
             "is the rod's beginning held there, in a hinge that lets it tilt but not spin, or as "
             "free as a tip on which nothing pushes? Of one that another rod carries: welded, "
             "hinged about -clamp_axis, or in a ball joint"),
    ROW_INT("-rod_cells", "500", 4, 3e8, 0, "N, so N + 1 nodes"),
    ROW_WORD("-rod_grading", "growth", "uniform,growth", 0,
             "node placement: equidistant in s, or denser where the rod grows"),
    ROW_REAL("-born", "0", 0, 1e9, UNIT_TIME, 0,
             "of one of several rods: it comes out then, and its growth counts time from there"),
    ROW_REAL("-ts_max_time", "40", 1e-12, 1e9, UNIT_TIME, SHARED, "end of the run"),
    ROW_TEXT("-change_file", INPUT_FILE,
             "text file of what changes in the run, one a line: the time, what, and its new value, "
             "as in 2.5 tip_force 0.2 (docs/live.md)")};
const OptionGroup scene_options = OPTION_GROUP_OF_ROD("Rod and clamp", rows);

/* SceneShapeAngle - the initial angle against the clamp and its derivative by s, at one label. A
   natural curvature comes on top of the initial shape, so that the tip bears no moment. */
PetscErrorCode SceneShapeAngle(Scene scene, PetscReal s, PetscReal *theta, PetscReal *theta_s) {
  PetscReal shape, shape_s;

  PetscFunctionBegin;
  PetscCall(CurvatureAngle(&scene->curvature, scene->growth, s, theta, theta_s));
  ShapeAngle(&scene->shape, s, &shape, &shape_s);
  *theta += shape;
  *theta_s += shape_s;
  PetscFunctionReturn(0);
}

/* Refuses more cells than a rank can number or this machine has memory for: a node's unknowns,
   their history, its row of the Jacobian and of its factors. */
static PetscErrorCode CheckSize(PetscInt cells) {
  const double bytes = 3200,
               most = 1.8e7; /* a node; nodes of a rank: 108 entries each, in 31 bits */
  double nodes, memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(OptionsComm(), &ranks));
  nodes = (double)cells / ranks;
  UserCheck(nodes <= most || sizeof(PetscInt) > 4, OptionsComm(),
            "-rod_cells %d: too many for %d rank(s), give at most %g a rank", (int)cells,
            (int)ranks, most);
  UserCheck(
      memory <= 0 || nodes * bytes <= memory, OptionsComm(),
      "-rod_cells %d: would take about %.0f GB a rank, and there are %.0f GB here; give fewer, "
      "or more ranks",
      (int)cells, nodes * bytes / 1e9, memory / 1e9);
  PetscFunctionReturn(0);
}

/* The largest cell at time t, and its rate. */
static PetscErrorCode LargestCell(Scene scene, PetscReal t, PetscReal cell[2]) {
  const PetscInt n = scene->mesh.cells + 1;
  PetscReal *p, *p_t;

  PetscFunctionBegin;
  cell[0] = cell[1] = 0;
  PetscCall(PetscMalloc2(n, &p, n, &p_t));
  PetscCall(GrowthArc(scene->growth, n, scene->mesh.s, t, p, p_t));
  for (PetscInt i = 0; i + 1 < n; i++)
    if (p[i + 1] - p[i] > cell[0]) {
      cell[0] = p[i + 1] - p[i];
      cell[1] = p_t[i + 1] - p_t[i];
    }
  PetscCall(PetscFree2(p, p_t));
  PetscFunctionReturn(0);
}

/* SceneNextTurn - the first time behind t at which what tables give in time sets out, stops or
   turns back: the places of tip, clamp and walls, factors of friction, the length, natural
   curvature; or at which the rod is born. PETSC_MAX_REAL if nothing does. */
PetscReal SceneNextTurn(Scene scene, PetscReal t) {
  const Growth growth = scene->growth;
  PetscReal next = SurfacesNextTurn(&scene->contact.surfaces, t);

  next = SmallerOf(next, WallsNextTurn(&scene->contact.walls, t));
  next = SmallerOf(next, TipNextTurn(&scene->tip, t));
  if (scene->space.clamp_path) next = SmallerOf(next, ScheduleNextTurn(scene->space.clamp_path, t));
  if (scene->load.field) next = SmallerOf(next, FieldNextTurn(scene->load.field, t));
  if (scene->tip.resistance.field)
    next = SmallerOf(next, FieldNextTurn(scene->tip.resistance.field, t));
  if (growth->next_turn) next = SmallerOf(next, growth->next_turn(growth, t));
  next = SmallerOf(next, CurvatureNextTurn(&scene->curvature, t));
  if (scene->born > t) next = SmallerOf(next, scene->born);
  return next;
}

/* SceneJerks - does what feeds the rod, or bends it by nature, set out or stop at once between two
   times, or is it born? */
PetscBool SceneJerks(Scene scene, PetscReal t0, PetscReal t1) {
  const Growth growth = scene->growth;

  return (PetscBool)((scene->born > 0 && t0 < scene->born && scene->born <= t1) ||
                     (growth->jerks && growth->jerks(growth, t0, t1)) ||
                     CurvatureJerks(&scene->curvature, t0, t1));
}

/* SceneContactAt - makes the law of contact that of time t. Whoever asks for forces of contact
   calls it first; it costs nothing where there is none. */
PetscErrorCode SceneContactAt(Scene scene, PetscReal t) {
  PetscReal B[2], cell[2] = {0, 0}, length[2];

  PetscFunctionBegin;
  if (!scene->contact.any || scene->contact.time == t) PetscFunctionReturn(0);
  if (ContactNeedsCell(&scene->contact)) PetscCall(LargestCell(scene, t, cell));
  PetscCall(GrowthLength(scene->growth, t, &length[0], &length[1]));
  PetscCall(SceneStiffness(scene, 1, t, &B[1], NULL));
  B[0] = scene->stiffness.most;
  ContactSetStiffness(&scene->contact, B, cell, length);
  scene->contact.surfaces.time = scene->contact.walls.time = t;
  scene->contact.time = t;
  PetscFunctionReturn(0);
}

/* SceneShare - a scene beside another one, which must outlive it: all that it has is the other's,
   until the caller puts something else in its place; SceneLinkWalls() then tells load and tip of
   its own walls. The caller frees what it has put there, and ends it with SceneShareEnd(). */
PetscErrorCode SceneShare(Scene scene, Scene *shared) {
  PetscFunctionBegin;
  PetscCall(PetscNew(shared));
  **shared = *scene;
  PetscFunctionReturn(0);
}

PetscErrorCode SceneShareEnd(Scene *shared) {
  PetscFunctionBegin;
  PetscCall(PetscFree(*shared));
  PetscFunctionReturn(0);
}

/* SceneAtSpeed - the frictions of a rod that snaps, the fastest place of which moves at this speed:
   what is slower than a part of it may creep, for to tell when each place comes to rest, or turns
   round, takes steps without end. 0: the snap is over, and friction is what it was. */
void SceneAtSpeed(Scene scene, PetscReal speed) {
  const PetscReal as_good_as_at_rest = 1e-5;
  PetscReal *const beta[] = {&scene->load.friction.beta, &scene->tip.resistance.friction.beta,
                             &scene->contact.rub.beta};

  for (int k = 0; k < 3; k++) {
    if (scene->falls == 0) scene->beta[k] = *beta[k];
    *beta[k] = PetscMax(scene->beta[k], PetscSqr(as_good_as_at_rest * speed));
  }
  scene->falls = speed;
}

const char *const scene_memory_name[] = {"falls", "shared", "firm", "spun", "spins_from"};

/* SceneRemember - for a restart: what laws have become, but by changes, which are done again. */
void SceneRemember(Scene scene, SceneMemory *memory) {
  const Load *load = &scene->load;
  const Contact *contact = &scene->contact;

  *memory = (SceneMemory){.falls = scene->falls,
                          .shared = load->shared ? 1 - load->friction.mu : 0,
                          .firm = contact->firm      ? 1
                                  : contact->deepest ? 0
                                                     : -1};
  if (scene->space.spins_from > 0 && !(scene->changes && scene->changes->done)) {
    memory->spun = scene->space.spun;
    memory->spins_from = scene->space.spins_from;
  }
}

/* SceneRecall - they are that again; but for a rod that snaps, which waits for its units:
   SceneAtSpeed(). */
PetscErrorCode SceneRecall(Scene scene, const SceneMemory *memory) {
  Contact *contact = &scene->contact;

  PetscFunctionBegin;
  if (memory->spins_from > 0) {
    scene->space.spun = memory->spun;
    scene->space.spins_from = memory->spins_from;
  }
  if (memory->shared != 0) LoadShare(&scene->load, memory->shared);
  if (!contact->chosen && memory->firm < 0) PetscCall(ContactStaysSoft(contact));
  if (!contact->chosen) contact->firm = (PetscBool)(memory->firm > 0);
  contact->time = PETSC_MIN_REAL; /* its law may follow from the cells */
  PetscFunctionReturn(0);
}

/* SceneLinkWalls - tells the load and the tip of the walls; once more where a scene is shared. */
void SceneLinkWalls(Scene scene) {
  LoadSetWalls(&scene->load, &scene->contact);
  scene->tip.walls = scene->load.walls;
}

/* SceneLabels - the labels of the rod's nodes, and how many there are. Borrowed. */
const PetscReal *SceneLabels(Scene scene, PetscInt *nodes) {
  *nodes = scene->mesh.cells + 1;
  return scene->mesh.s;
}

/* SceneLength - how long the rod is at time t. */
PetscErrorCode SceneLength(Scene scene, PetscReal t, PetscReal *length) {
  PetscFunctionBegin;
  PetscCall(GrowthLength(scene->growth, t, length, NULL));
  PetscFunctionReturn(0);
}

/* SceneStretch - g at the label s and time t. */
PetscErrorCode SceneStretch(Scene scene, PetscReal s, PetscReal t, PetscReal *g) {
  PetscFunctionBegin;
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, g, NULL, NULL));
  PetscFunctionReturn(0);
}

/* ScenePlaceAlong - of a place whose label and time are known: how much of the rod is behind it,
   and before it. */
PetscErrorCode ScenePlaceAlong(Scene scene, Place *at) {
  const PetscReal label[] = {at->s, 1};
  PetscReal length[] = {0, 0};

  PetscFunctionBegin;
  PetscCall(GrowthArc(scene->growth, 2, label, at->t, length, NULL));
  at->from_base = length[0];
  at->to_tip = length[1] - length[0];
  PetscFunctionReturn(0);
}

/* SceneMaterial - what the rod's own laws give at the label s and time t. */
PetscErrorCode SceneMaterial(Scene scene, PetscReal s, PetscReal t, Material *at) {
  PetscReal B, B_t;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(at, sizeof(*at)));
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, &at->g, &at->g_t, NULL));
  at->c = GrowthSlide(scene->growth, s, t);
  at->strain = GrowthStrain(scene->growth, s, t, at->g_t);
  PetscCall(SceneStiffness(scene, s, t, &B, &B_t));
  if (scene->space.rod) {
    SceneStiffnesses(scene, B, at->S);
    SceneStiffnesses(scene, B_t, at->S_t);
    PetscCall(CurvatureStrains(&scene->curvature, scene->growth, s, t, at->u0, at->u0_t));
  } else {
    at->S[2] = B;
    at->S_t[2] = B_t;
    PetscCall(SceneCurvature(scene, s, t, &at->u0[2], &at->u0_t[2]));
  }
  PetscFunctionReturn(0);
}

/* SceneAtTolerance - tells a scene at which tolerance it is to be stepped: what exact friction of
   material at rest is taken for depends on it (LoadAtTolerance()). */
void SceneAtTolerance(Scene scene, PetscReal rtol) {
  LoadAtTolerance(&scene->load, rtol);
  if (scene->load.limit) scene->contact.rub.beta = scene->load.friction.beta;
}

/* What does not go with growth that feels force: strands that touch, of which V and L are not told,
   and friction that varies along a rod whose length is an unknown.
   And what is given at labels, if the rod grows all along: its material slides past them then. */
static PetscErrorCode CheckYield(Scene scene) {
  static const char *const at_labels[] = {"-rod_curvature_file", "-rod_curvature_random"};
  PetscBool given;

  PetscFunctionBegin;
  if (scene->growth->yield == 0) PetscFunctionReturn(0);
  UserCheck(
      !LoadAlong(&scene->load), OptionsComm(),
      "%s: not of a rod whose growth feels force (-growth_yield), and with it its length; leave "
      "one out",
      LoadAlong(&scene->load));
  UserCheck(!scene->contact.self, OptionsComm(),
            "-contact_self: not of a rod whose growth feels force (-growth_yield); leave one out");
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(at_labels); k++) {
    if (strcmp(scene->growth->type, "uniform")) break;
    PetscCall(OptionGiven(at_labels[k], &given));
    UserCheck(!given, OptionsComm(),
              "%s: not with -growth_yield of a rod that grows all along; leave one out",
              at_labels[k]);
  }
  PetscFunctionReturn(0);
}

/* A rod whose beginning is free has nothing there that lets material in, or turns it; and a hinge
   is one about which material that has grown swings, none that lets it in. */
static PetscErrorCode CheckClamp(Scene scene, PetscBool carried) {
  PetscInt type;

  PetscFunctionBegin;
  PetscCall(OptionWord("-clamp_type", &type, NULL));
  scene->clamp = (ClampType)type;
  UserCheck(scene->clamp != CLAMP_BALL || carried, OptionsComm(),
            "-clamp_type ball: is a joint between rods (-clamp_on); give held, hinged or free");
  UserCheck(scene->clamp == CLAMP_HELD || !scene->growth->slides, OptionsComm(),
            "-clamp_type %s: rods that are fed in, or slide out of the clamp, have one; give "
            "another -growth_type",
            scene->clamp == CLAMP_FREE     ? "free"
            : scene->clamp == CLAMP_HINGED ? "hinged"
                                           : "ball");
  scene->shape.hinged = (PetscBool)(scene->clamp == CLAMP_HINGED);
  UserCheck(scene->clamp != CLAMP_HINGED || scene->load.radius == 0 || scene->load.friction.mu == 0,
            OptionsComm(),
            "-friction_radius: a rod that tilts in its hinge hardly spins there, and which way dry "
            "friction points then is undecided; with -clamp_type hinged take it out, or give "
            "-friction_mu 0");
  if (scene->clamp != CLAMP_FREE) PetscFunctionReturn(0);
  UserCheck(scene->space.spin == 0, OptionsComm(),
            "%s: turns a clamp, and with -clamp_type free there is none; leave one out",
            SpaceClampOption(&scene->space));
  PetscFunctionReturn(0);
}

/*
  SceneCreateOn - reads and checks all options that say what is simulated, and places the nodes.
  Collective on OptionsComm(), the ranks that are to share the scene; the caller destroys it with
  SceneDestroy(), also after an error.

  seat   where another rod carries it; NULL: none does
  touch  it is one of several rods that may touch each other
*/
PetscErrorCode SceneCreateOn(const Seat *seat, PetscBool touch, Scene *scene) {
  PetscInt cells, grading;
  char text[2][64];
  Scene self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *scene = self; /* whole or not, the caller destroys it */
  self->comm = OptionsComm();
  self->units.length = self->units.time = self->units.stiffness = 1;
  PetscCall(SiSetFromOptions(&self->si)); /* first: the others may carry units */
  PetscCall(GrowthCreate(&self->growth));
  PetscCall(OptionReal("-born", &self->born, NULL));
  if (self->born > 0) PetscCall(GrowthDelay(self->growth, self->born));
  PetscCall(OptionReal("-clamp_angle", &self->clamp_angle, NULL));
  PetscCall(SpaceClampDirection(seat, &self->clamp_angle, &self->space));
  PetscCall(LoadSetFromOptions(&self->load));
  if (self->growth->rests || self->growth->yield > 0) LoadNextToExact(&self->load);
  PetscCall(TipSetFromOptions(&self->tip, &self->load));
  PetscCall(StiffnessSetFromOptions(&self->stiffness));
  PetscCall(ShapeSetFromOptions(&self->shape));
  PetscCall(OptionInt("-rod_cells", &cells, NULL));
  PetscCall(CheckSize(cells));
  PetscCall(OptionWord("-rod_grading", &grading, NULL));
  PetscCall(OptionReal("-ts_max_time", &self->end_time, NULL));
  UserCheck(self->end_time <= self->growth->end_time * (1 + 1e-12), OptionsComm(),
            "-ts_max_time %s: the growth table ends at t = %s",
            OptionBoth(self->end_time, UNIT_TIME, text[0]),
            OptionBoth(self->growth->end_time, UNIT_TIME, text[1]));
  PetscCall(GrowthLongest(self->growth, self->end_time, &self->reach));
  PetscCall(CurvatureSetFromOptions(&self->curvature, self->growth, self->end_time));
  PetscCall(TropismSetFromOptions(&self->tropism, self->growth));
  if (self->growth->yield > 0) self->tropism.any = PETSC_TRUE; /* its material may learn */
  PetscCall(MeshCreate(cells, (PetscBool)grading, self->growth, self->end_time, &self->mesh));
  PetscCall(ContactSetFromOptions(&self->contact, touch, &self->load.friction, self->clamp_angle));
  self->contact.time = PETSC_MIN_REAL;
  SceneLinkWalls(self);
  PetscCall(
      SpaceSetFromOptions(&self->space, &self->load, &self->tip, &self->curvature, &self->shape));
  if (self->tropism.any)
    TropismFrame(&self->tropism, (const PetscReal(*)[3])self->space.lab, self->space.place);
  if (self->tropism.why) self->space.why = self->tropism.why;
  PetscCall(CheckYield(self));
  PetscCall(CheckClamp(self, (PetscBool)(seat != NULL)));
  if (self->load.radius > 0 && self->clamp != CLAMP_FREE) LoadNextToExact(&self->load);
  if (ContactWallsRub(&self->contact) && self->clamp != CLAMP_FREE)
    LoadNextToExactByWalls(&self->load);
  ContactSetFrame(&self->contact, (const PetscReal(*)[3])self->space.lab, self->clamp_angle,
                  self->space.place);
  PetscCall(SceneForce(self, &self->contact.usual));
  PetscCall(SceneContactAt(self, 0));
  ContactStandOff(&self->contact, &self->stands_off);
  PetscCall(ChangesRead(&self->changes));
  PetscFunctionReturn(0);
}

/* SceneCreate - of a rod alone: SceneCreateOn(). What it is beside others is what the scales are
   of. Collective. */
PetscErrorCode SceneCreate(Scene *scene) {
  static const char *const beside[] = {
      "-rod_stiffness", "-friction_strength", "-growth_speed", "-clamp_on", "-tip_on", "-born"};
  PetscBool given;

  PetscFunctionBegin;
  *scene = NULL;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(beside); k++) {
    PetscCall(OptionGiven(beside[k], &given));
    UserCheck(!given, OptionsComm(),
              "%s: is of one of several rods; take it out, or write sections [rod NAME]",
              beside[k]);
  }
  PetscCall(SceneCreateOn(NULL, PETSC_FALSE, scene));
  PetscFunctionReturn(0);
}

/* Can a tip be held so far away from the clamp? */
static PetscErrorCode CheckHeld(Scene scene, PetscReal away) {
  const PetscReal slack = 1e-6, *push = scene->tip.push,
                  pushed = PetscAbsReal(push[0]) + PetscAbsReal(push[1]) + PetscAbsReal(push[2]);
  PetscReal length;

  PetscFunctionBegin;
  if (scene->tip.type == TIP_SLIDES) {
    UserCheck(scene->tip.law == TIP_DEAD, scene->comm,
              "-tip_law: what presses on a tip that slides is dead; take -tip_law out");
    PetscFunctionReturn(0);
  }
  PetscCall(GrowthLength(scene->growth, 0, &length, NULL));
  UserCheck(scene->tip.force == 0 && pushed == 0, scene->comm,
            "-tip_force or -tip_force_vector: has no effect on a tip that is held; leave it or "
            "-tip_type out");
  UserCheck(away < (1 - slack) * length || scene->clamp == CLAMP_FREE, scene->comm,
            "-tip_type: the rod is straight from the clamp to its held tip (to %g) and has nowhere "
            "to grow: give it a larger -shape_amplitude or a natural curvature",
            (double)slack);
  PetscFunctionReturn(0);
}

/* Can the rod reach all along the path of its tip? */
static PetscErrorCode CheckPath(Scene scene) {
  Path path = scene->tip.path;
  PetscReal length;
  PathPlace at;

  PetscFunctionBegin;
  if (scene->tip.type == TIP_SLIDES || scene->clamp == CLAMP_FREE) PetscFunctionReturn(0);
  for (PetscInt i = 0; i < PathRows(path); i++) {
    PetscReal t = PathTime(path, i);
    if (t < 0 || t > scene->end_time) continue;
    PathAt(path, t, &at);
    PetscCall(GrowthLength(scene->growth, t, &length, NULL));
    UserCheck(at.x[0] * at.x[0] + at.x[1] * at.x[1] + at.x[2] * at.x[2] < length * length,
              scene->comm, "-tip_path: at t = %g it is farther from the clamp than the rod is long",
              (double)t);
  }
  PetscFunctionReturn(0);
}

/* The path of the tip, if it has one, begins where it is held. */
static PetscErrorCode LeadTip(Scene scene, PetscBool space) {
  PetscReal length;

  PetscFunctionBegin;
  if (!scene->tip.path) PetscFunctionReturn(0);
  PetscCall(GrowthLength(scene->growth, 0, &length, NULL));
  PetscCall(TipSetPath(&scene->tip, scene->comm, length, scene->space.lab, space));
  PetscCall(CheckPath(scene));
  PetscFunctionReturn(0);
}

/* SceneHoldTip - tells a scene whose tip is held where that is, in the clamp's frame. A rod that is
   straight from the clamp to there cannot grow, and one that nearly is has too many ways to.
   Collective. */
PetscErrorCode SceneHoldTip(Scene scene, const PetscReal x[2], PetscReal theta) {
  PetscFunctionBegin;
  PetscCall(CheckHeld(scene, PetscSqrtReal(x[0] * x[0] + x[1] * x[1])));
  PetscCall(PetscArraycpy(scene->tip.x, x, 2));
  scene->tip.theta = theta;
  scene->tip.p[0] = PetscCosReal(theta / 2);
  scene->tip.p[3] = PetscSinReal(theta / 2);
  PetscCall(LeadTip(scene, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* SceneHoldTip3 - the same in space; p is the quaternion there. */
PetscErrorCode SceneHoldTip3(Scene scene, const PetscReal x[3], const PetscReal p[4]) {
  PetscFunctionBegin;
  PetscCall(CheckHeld(scene, PetscSqrtReal(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])));
  PetscCall(PetscArraycpy(scene->tip.x, x, 2));
  scene->tip.x[2] = x[2];
  PetscCall(PetscArraycpy(scene->tip.p, p, 4));
  PetscCall(LeadTip(scene, PETSC_TRUE));
  PetscFunctionReturn(0);
}

PetscErrorCode SceneDestroy(Scene *scene) {
  PetscFunctionBegin;
  if (!*scene) PetscFunctionReturn(0);
  PetscCall(SpaceRelease(&(*scene)->space));
  PetscCall(CurvatureDestroy(&(*scene)->curvature));
  PetscCall(LoadDestroy(&(*scene)->load));
  PetscCall(TipDestroy(&(*scene)->tip));
  PetscCall(ContactDestroy(&(*scene)->contact));
  PetscCall(StiffnessDestroy(&(*scene)->stiffness));
  PetscCall(GrowthDestroy(&(*scene)->growth));
  PetscCall(MeshDestroy(&(*scene)->mesh));
  PetscCall(ShapeDestroy(&(*scene)->shape));
  PetscCall(ChangesDestroy(&(*scene)->changes));
  PetscCall(PetscFree(*scene));
  PetscFunctionReturn(0);
}
