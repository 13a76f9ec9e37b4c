/* -task grow: the end of a run, and the line for one that was not asked for. */
#include "tasks/growing.h"
#include "tasks/grow_rules.h"

/* Does a rod in space turn about itself far faster than anything drives it? Where friction does not
 * feel the spin nothing says how it gives way. */
static PetscBool SpinsFreely(const Grow *self) {
  const Scene scene = self->scene;
  const PetscReal prescribed = PetscAbsReal(scene->space.spin) + 1 / self->seen.length;

  return (PetscBool)(scene->space.rod && scene->load.radius == 0 &&
                     PetscAbsReal(self->seen.tip_spin) > grow_rule.spins_freely * prescribed);
}

/* Is a rod that touches still straight, and does nothing say to which side it bends? (A load or a
   natural bend across would.) */
static PetscBool PressedStraight(const Grow *self) {
  const Scene scene = self->scene;
  const PetscReal *weight = scene->load.weight, *push = scene->tip.push;
  const PetscBool loaded =
      (PetscBool)(weight[1] != 0 || weight[2] != 0 || push[1] != 0 || push[2] != 0);

  return (PetscBool)(self->seen.contacts > 0 &&
                     self->seen.max_angle <= grow_rule.pressed_straight && !loaded &&
                     !CurvatureBends(&scene->curvature));
}

/* About how much a number is, as OptionBoth() has it. */
static const char *About(PetscReal value, Dimension dimension, char text[64]) {
  PetscReal factor;
  const char *unit = OptionShownIn(value, dimension, &factor);

  (void)snprintf(text, 64, unit ? "%.3g (%.3g %s)" : "%.3g", (double)value,
                 (double)(value * factor), unit);
  return text;
}

/* GrowBaseForce - the size of the clamp's force. */
PetscReal GrowBaseForce(const Observation *seen) {
  return hypot(hypot(seen->base_force_1, seen->base_force_2), seen->base_force_3);
}

/* A rod that is held so that it cannot give way at large bends in waves of 2 pi sqrt(B/P) under the
   force P: cells that are long beside these chatter. Tells how many would do; nothing if there are.
 */
static void AdviseWaves(const Grow *self, char *advice, size_t room) {
  const PetscReal B = self->scene->stiffness.most,
                  P = PetscMax(self->force_before, GrowBaseForce(&self->seen)),
                  length = self->seen.length, cell = length / self->scene->mesh.cells;
  char text[3][64];
  PetscReal wave;

  advice[0] = 0;
  if (!TipHolds(&self->scene->tip, 1) || !(P > 0)) return;
  wave = 2 * PETSC_PI * PetscSqrtReal(B / P);
  if (wave < grow_rule.wave_coarse * cell)
    (void)snprintf(advice, room,
                   "its cells of %s are too long for the waves in which it bends under the force "
                   "%s, of %s: give -rod_cells %.0f",
                   About(cell, UNIT_LENGTH, text[0]), About(P, UNIT_FORCE, text[1]),
                   About(wave, UNIT_LENGTH, text[2]),
                   (double)PetscCeilReal(grow_rule.wave_fine * length / wave));
}

/* Are cells longer than what contact presses on? They see it at one node or at none. */
static PetscBool CoarseForContact(const Grow *self) {
  const PetscReal cell = self->seen.length / self->scene->mesh.cells;

  return (PetscBool)(self->scene->contact.any && cell > 2 * self->scene->contact.tip);
}

/* What to try where a rod gives way faster than steps can follow. */
static void AdviseGivingWay(const Grow *self, char *advice, size_t room) {
  const PetscReal spread = self->scene->contact.tip,
                  cell = self->seen.length / self->scene->mesh.cells;
  const char *const friction =
      self->scene->load.friction.mu >= 0.9999 ? ", or a -friction_mu below 0.9999" : "";
  char text[2][64];

  if (CoarseForContact(self))
    (void)snprintf(advice, room,
                   "its cells of %s are too long for contact, which presses over %s: give "
                   "-rod_cells %.0f",
                   About(cell, UNIT_LENGTH, text[0]), About(spread, UNIT_LENGTH, text[1]),
                   (double)PetscCeilReal(self->seen.length / spread));
  else
    (void)snprintf(advice, room,
                   "take a shorter -ts_dt (without -ts_adapt_type none), more -rod_cells, another "
                   "-ts_rtol%s",
                   friction);
}

/* A conduit pushes what is out of it no way: a rod that comes beside one is stopped by nothing that
   it could slide along. Tells of one that holds neither clamp nor tip; nothing if there is none. */
static void AdviseConduit(const Grow *self, char *advice, size_t room) {
  const Walls *walls = &self->scene->contact.walls;
  const Surfaces *surfaces = &self->scene->contact.surfaces;
  const PetscReal *clamp = self->scene->space.place,
                  tip[3] = {self->seen.tip_x1, self->seen.tip_x2, self->seen.tip_x3};

  for (PetscInt w = 0; w < walls->n && !advice[0]; w++)
    if (!WallsHold(walls, w, clamp) && !WallsHold(walls, w, tip))
      (void)snprintf(advice, room,
                     "it may have come beside wall %d of -wall_file, a path that does not hold it: "
                     "lead that to the clamp, or the rod into its mouth",
                     (int)w + 1);
  for (PetscInt k = 0; k < surfaces->n && !advice[0]; k++)
    if (!SurfaceHolds(&surfaces->surface[k], clamp) && !SurfaceHolds(&surfaces->surface[k], tip))
      (void)snprintf(
          advice, room,
          "it may have come beside the %s in line %d of -wall_file, which does not hold it: "
          "lead that to the clamp, or the rod into its open end",
          surfaces->surface[k].kind->name, surfaces->surface[k].line);
}

/* Dry friction says nothing of how fast a rod falls that it does not hold: if no wall stops it, a
   snap takes it without end, or at the speed of its least viscous share, which means nothing. */
static void AdviseFall(const Grow *self, char *advice, size_t room) {
  const Load *load = &self->scene->load;
  const PetscReal *w = load->weight, weight = hypot(hypot(w[0], w[1]), w[2]);
  PetscBool dry = (PetscBool)(load->weighs && LoadIsDry(load) && !load->field &&
                              weight > PetscMax(1, load->across));

  if (dry && self->scene->clamp == CLAMP_FREE && self->scene->tip.type == TIP_FREE)
    (void)snprintf(advice, room,
                   "-rod_weight is %.3g times what dry friction holds, and the rod falls at once, "
                   "without end if no wall stops it: give a -friction_mu below 1, by which it "
                   "falls at a speed",
                   (double)(weight / PetscMax(1, load->across)));
}

/* What the lines for an end that was not asked for have in common. */
typedef struct {
  const char *kept;     /* what is left of the run */
  char t[64], step[64]; /* the last time and step */
} Ending;

/* ... for one that was stopped: by someone, or before it was through with what it was to follow. */
static PetscErrorCode TellStopped(Grow *self, const Ending *ending) {
  MPI_Comm comm = self->scene->comm;
  char text[64], advice[512] = "";

  PetscFunctionBegin;
  UserCheck(!self->stopped, comm, "interrupted by signal %d at t = %s; %s", self->stopped,
            ending->t, ending->kept);
  UserCheck(!self->beyond, comm,
            "-rod_model linear: stopped at t = %s, where an angle reached 1: a straight rod's "
            "model says nothing there; take -rod_model auto",
            ending->t);
  if (self->reason == TS_CONVERGED_TIME && self->scene->falls > 0)
    AdviseFall(self, advice, sizeof(advice));
  UserCheck(!advice[0], comm, "at t = %s the rod is still falling: %s", ending->t, advice);
  UserCheck(self->reason != TS_CONVERGED_ITS, comm,
            "-ts_max_steps: reached at t = %s before -ts_max_time %s", ending->t,
            OptionBoth(self->scene->end_time, UNIT_TIME, text));
  PetscFunctionReturn(0);
}

/* ... for one that gets nowhere. */
static PetscErrorCode TellNowhere(Grow *self, const Ending *ending) {
  MPI_Comm comm = self->scene->comm;
  char jam[512] = "", crawl[768] = "", advice[512];

  PetscFunctionBegin;
  UserCheck(
      self->jammed || self->reason == TS_CONVERGED_TIME || !PressedStraight(self), comm,
      "gave up at t = %s: the rod is pressed straight against a wall, and nothing says to which "
      "side it gives way; %s; give it a small -rod_curvature",
      ending->t, ending->kept);
  UserCheck(
      !self->slips &&
          !(self->reason < 0 && self->scene->load.shared && self->scene->load.across < 1),
      comm,
      "gave up at t = %s: with -friction_across %g dry friction does not say how fast so bent a "
      "rod moves, and it slips and sticks in no time, again and again; %s; take a larger "
      "-friction_across, or a lower -friction_mu: 0.99, or less",
      ending->t, (double)self->scene->load.across, ending->kept);
  PetscCall(GrowTellLamp(self, ending->kept));
  CrawlTell(&self->crawl, self->scene->load.friction.beta, GrowHeldTwice(self), crawl,
            sizeof(crawl));
  AdviseWaves(self, advice, sizeof(advice));
  UserCheck(!self->crawls, comm, "%s; %s%s%s", crawl, ending->kept, advice[0] ? "; " : "", advice);
  PetscCall(GrowTellJam(self, (PetscBool)(self->reason < 0), jam, sizeof(jam)));
  UserCheck(!jam[0], comm,
            "%s, and it can hardly grow on; %s; end the run before with -stop_force, or, if this "
            "push is meant, give a higher -contact_stiffness",
            jam, ending->kept);
  PetscFunctionReturn(0);
}

/* ... for one that found no step. */
static PetscErrorCode TellGaveUp(Grow *self, const Ending *ending) {
  MPI_Comm comm = self->scene->comm;
  PetscBool waves, passes;
  char advice[512];

  PetscFunctionBegin;
  AdviseWaves(self, advice, sizeof(advice));
  waves = (PetscBool)(advice[0] != 0);
  if (!waves) AdviseConduit(self, advice, sizeof(advice));
  passes = (PetscBool)(self->now->passes ||
                       (self->now->passed && !advice[0] && !CoarseForContact(self)));
  UserCheck(!passes, comm,
            "gave up at t = %s with a step of %s: the rod would pass through itself or a wall; %s; "
            "give more -rod_cells or a higher -contact_stiffness",
            ending->t, ending->step, ending->kept);
  UserCheck(
      !SpinsFreely(self), comm,
      "gave up at t = %s: the rod turns over about its own axis at once, for nothing holds its "
      "spin back, and where it then goes is not determined; %s; give the radius at which "
      "friction feels the spin, -friction_radius",
      ending->t, ending->kept);
  if (!advice[0]) AdviseGivingWay(self, advice, sizeof(advice));
  UserCheck(
      !self->now->crosses, comm,
      "gave up at t = %s: the rod gives way faster than a step of %s can follow, to which side "
      "that step does not tell; %s; %s",
      ending->t, ending->step, ending->kept, advice);
  if (!waves) {
    advice[0] = 0;
    AdviseFall(self, advice, sizeof(advice));
    AdviseConduit(self, advice, sizeof(advice));
  }
  UserCheck(PETSC_FALSE, comm, "gave up at t = %s with a step of %s (%s): %s; %s", ending->t,
            ending->step, TSConvergedReasons[self->reason], ending->kept,
            advice[0] ? advice
            : GrowHeldTwice(self)
                ? crawl_held
                : "try another -ts_rtol, more -rod_cells or a larger -friction_beta");
  PetscFunctionReturn(0);
}

/* The line for an end that was not asked for. */
static PetscErrorCode Verdict(Grow *self) {
  Ending ending = {.kept = OutputStores(self->output) ? "the results up to there are stored"
                           : self->by_steps ? "what was found up to there can be read and saved"
                                            : "nothing is stored without -output FILE"};
  PetscReal step;

  PetscFunctionBegin;
  if (self->event.kind) PetscFunctionReturn(0);
  PetscCall(TSGetTimeStep(self->now->ts, &step));
  OptionBoth(self->seen.t, UNIT_TIME, ending.t);
  OptionBoth(step, UNIT_TIME, ending.step);
  PetscCall(TellStopped(self, &ending));
  PetscCall(TellNowhere(self, &ending));
  if (self->reason != TS_CONVERGED_TIME) PetscCall(TellGaveUp(self, &ending));
  PetscFunctionReturn(0);
}

static PetscErrorCode SumUp(Grow *self) {
  PetscFunctionBegin;
  PetscCall(GrowErrors(self));
  PetscCall(GrowSummary(self));
  PetscFunctionReturn(0);
}

/* GrowEnd - stores the last state, whatever the end. */
PetscErrorCode GrowEnd(Grow *self, PetscBool finished) {
  char text[2][64] = {""};

  PetscFunctionBegin;
  if (self->seen.t != self->stored_shape)
    PetscCall(GrowStoreShape(self, self->seen.t, self->now->U));
  PetscCall(OutputEvent(self->output, &self->event));
  if (self->stopped)
    (void)snprintf(text[0], sizeof(text[0]), "by signal %d at t = %.30s", self->stopped,
                   OptionBoth(self->seen.t, UNIT_TIME, text[1]));
  PetscCall(OutputInterrupted(self->output, text[0]));
  PetscCall(OutputErrors(self->output, &self->error));
  PetscCall(GrowSensitivitiesKeep(self));
  PetscCall(GrowStore(self, finished));
  PetscFunctionReturn(0);
}

/*
  GrowFinish - what a run leaves that is over, and the line for an end that was not asked for.
  Collective.

  again  it was in vain, and is to be run once more, with soft contact: see GrowStartOver()
*/
PetscErrorCode GrowFinish(Grow *self, PetscBool *again) {
  PetscErrorCode error = (PetscErrorCode)0;
  char text[64];

  PetscFunctionBegin;
  *again = GrowFindsNoWay(self);
  if (!*again) error = SumUp(self);
  if (error) (void)GrowEnd(self, PETSC_FALSE); /* what has been computed is not lost */
  PetscCall(error);
  if (*again && !self->quiet)
    PetscCall(PetscPrintf(self->scene->comm,
                          "t = %s: no way is found in contact that gets firmer where the rod is "
                          "pressed in: the run begins anew with contact that does not\n",
                          OptionBoth(self->seen.t, UNIT_TIME, text)));
  if (*again) PetscFunctionReturn(0);
  PetscCall(GrowEnd(self, (PetscBool)(self->reason == TS_CONVERGED_TIME || self->event.kind)));
  if (self->member) self->member->stopped = (PetscBool)(self->stopped != 0);
  PetscCall(Verdict(self));
  if (self->member)
    PetscCall(
        OutputHarvest(self->output, &self->seen, self->member->values, &self->member->harvest));
  PetscFunctionReturn(0);
}
