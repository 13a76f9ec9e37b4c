/* -task grow: what a run is asked for, and how it begins, or goes on. */
#include "tasks/accuracy.h"
#include "scene/change.h"
#include "tasks/growing.h"
#include "tasks/grow_rules.h"

static const OptionRow rows[] = {
    ROW_WORD(
        "-rod_model", "frame", "linear,frame,mixed,space,auto", 0,
        "which unknowns; auto: linear while accurate enough, else frame, or space where something "
        "acts out of the plane; space of itself there"),
    ROW_REAL(
        "-ts_rtol", "1e-6", 1e-13, 0.5, UNIT_NONE, 0,
        "tolerance of a step, per field, against the field's present size; 1e-5 where the rod can "
        "touch something"),
    ROW_REAL("-contact_rtol", "", 1e-13, 0.5, UNIT_NONE, 0,
             "what the tolerance of a step may be eased to while errors of steps are small beside "
             "those of contact and mesh; if not given 10 times -ts_rtol, unless that is given"),
    ROW_REAL("-output_interval", "", 1e-9, 1e9, UNIT_TIME, 0,
             "time between stored shapes; if not given, -output_shapes decides"),
    ROW_INT("-output_shapes", "40", 1, 1e6, PASSING,
            "stored shapes after the first, evenly over the run; members of a sweep: 1, the last"),
    ROW_TEXT("-sensitivity", PASSING,
             "names of options, between commas: derivatives of series and shapes by their numbers "
             "are stored, too"),
    ROW_BOOL("-quiet", "false", PASSING | PROGRAM, "print nothing but errors")};
const OptionGroup grow_options = OPTION_GROUP("Run", rows);

/* The model asked for or, where something acts out of the plane, that of space. */
static PetscErrorCode ChooseModel(Grow *self) {
  Space *space = &self->scene->space;
  PetscBool asked;

  PetscFunctionBegin;
  if (space->why) PetscCall(OptionDefault("-rod_model", "space"));
  PetscCall(OptionWord("-rod_model", &self->model, NULL));
  space->rod = (PetscBool)(self->model == SPACE ||
                           (space->why && (self->model == AUTO || self->model == LINEAR)));
  PetscCall(OptionGiven("-accuracy", &asked));
  /* their errors are measured; linear rods creep behind a growth zone under friction that is next
     to exact, by as much as they are bent, and in short waves that the steps do not see */
  if ((asked || LoadIsNextToExact(&self->scene->load)) && self->model == AUTO)
    self->model = space->rod ? SPACE : FRAME;
  UserCheck(
      !space->only || space->rod, self->scene->comm,
      "%s: means nothing in the plane, and nothing here takes the rod out of it; take it out, "
      "or give -rod_model space",
      space->only);
  UserCheck(!space->rod || !self->member || self->member->space, self->scene->comm,
            "%s: takes this rod out of the plane, as nothing that the sweep's options say does; "
            "give the sweep -rod_model space",
            space->why ? space->why : "-rod_model");
  PetscFunctionReturn(0);
}

/*
  GrowTolerance - reads the tolerance of steps, and what it may be eased to. Collective.

  touches  can a rod touch anything?

  A rod that slides along an edge jerks, by next to nothing, for each place of the mesh that comes
  to it or leaves it: steps of the usual tolerance would follow that, two to four times as many, and
  the tip be nearer by less than a hundredth of what contact's own stiffness puts it off. Whether
  even this is finer than need be, the estimate tells (ToleranceFollow()).
*/
PetscErrorCode GrowTolerance(PetscBool touches, PetscReal *rtol, PetscReal *most) {
  PetscBool given, eased;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-ts_rtol", &given));
  PetscCall(AccuracyTolerance());
  if (touches) PetscCall(OptionDefault("-ts_rtol", "1e-5"));
  PetscCall(OptionReal("-ts_rtol", rtol, NULL));
  if (touches && !given)
    PetscCall(OptionDefault("-contact_rtol", "%.3g", grow_rule.contact_eases * *rtol));
  PetscCall(OptionReal("-contact_rtol", most, &eased));
  UserCheck(touches || !eased, OptionsComm(), "-contact_rtol: there is nothing to touch; %s",
            ContactRemedy());
  UserCheck(!eased || *most >= *rtol, OptionsComm(),
            "-contact_rtol %g: is below -ts_rtol, %g, and steps are never finer than that; give "
            "a smaller -ts_rtol",
            (double)*most, (double)*rtol);
  /* of a run gone on with, both are as they were, but for what is given anew */
  if (!eased || (OptionOnCommandLine("-ts_rtol") && !OptionOnCommandLine("-contact_rtol")))
    *most = *rtol;
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadOptions(Grow *self) {
  PetscFunctionBegin;
  PetscCall(ChooseModel(self));
  PetscCall(GrowTolerance(self->scene->contact.any, &self->rtol, &self->eased));
  SceneAtTolerance(self->scene, self->rtol);
  PetscCall(WatchSetFromOptions(&self->watch, self->scene));
  PetscCall(OptionBool("-quiet", &self->quiet, NULL));
  if (self->member) self->quiet = PETSC_TRUE;
  for (PetscInt m = 0; m < MODELS; m++) {
    const RodModel *model = GrowModelOf(self, m);
    const char *why = model->refuses ? model->refuses(self->scene) : NULL;
    self->can[m] = (PetscBool)(why == NULL);
    UserCheck(!why || self->model != m, self->scene->comm, "%s; %s", why,
              m == SPACE               ? "take it out, or what takes the rod out of the plane"
              : self->scene->space.why ? "take -rod_model space"
                                       : "take -rod_model frame or auto");
  }
  PetscFunctionReturn(0);
}

/* When shapes are stored: by a time between them, or by their number; of a run that keeps no file,
   and of a member of a sweep that asks for none, the last alone. Collective. */
static PetscErrorCode SetInterval(Grow *self, const char *output, const char *restart) {
  PetscBool interval, number;
  PetscReal every;
  PetscInt shapes;

  PetscFunctionBegin;
  PetscCall(GrowFindEnd(self));
  PetscCall(OptionInt("-output_shapes", &shapes, &number));
  if (!number && !self->by_steps && (self->member || !(output[0] || restart[0]))) shapes = 1;
  self->output_interval = self->end / (PetscReal)shapes;
  PetscCall(OptionReal("-output_interval", &every, &interval));
  if (interval && !number) self->output_interval = every;
  /* after a restart the interval may be that of the run before, the number is this one's */
  UserCheck(!(interval && number) || restart[0], self->scene->comm,
            "-output_shapes: -output_interval says already when shapes are stored; leave one out");
  PetscFunctionReturn(0);
}

/* The state of a fresh run: the scene's initial shape. */
static PetscErrorCode Begin(Grow *self, const char *output) {
  Event event;

  PetscFunctionBegin;
  self->now = GrowOwnLeg(self);
  PetscCall(GrowCheckStart(self));
  PetscCall(GrowLookForEvent(self, 0, NULL, &event));
  UserCheck(!event.kind, self->scene->comm, "-stop_%s: it is so at the start already",
            event_name[event.kind]);
  PetscCall(OutputCreate(output, self->scene, &self->output)); /* after all refusals */
  if (GrowFollowsErrors(self)) PetscCall(OutputFollows(self->output));
  if (self->member) PetscCall(OutputKeep(self->output, self->member->series, self->member->shapes));
  if (self->by_steps) PetscCall(OutputKeep(self->output, PETSC_TRUE, PETSC_TRUE));
  PetscCall(GrowObserve(self, 0, NULL, NULL));
  self->now = &self->leg[GrowBetterModel(self)];
  PetscCall(RodBegin(self->now->rod, self->now->U));
  PetscCall(GrowStoreShape(self, 0, NULL));
  if (!self->member)
    PetscCall(GrowStore(self, PETSC_FALSE)); /* what cannot be written shows early */
  self->next_output = self->output_interval;
  PetscFunctionReturn(0);
}

/* The state of an earlier run, with the history of its stepper. */
static PetscErrorCode GoOn(Grow *self, const char *restart, const RestartState *state,
                           const char *output) {
  Event event;
  char text[64];

  PetscFunctionBegin;
  UserCheck(state->model >= 0 && state->model < MODELS && self->leg[(int)state->model].rod &&
                self->leg[(int)state->model].rod->model->fields == state->fields,
            self->scene->comm, "-rod_model: the run in -restart %s was of another model", restart);
  self->now = &self->leg[(int)state->model];
  PetscCall(RestartTake(restart, state, self->now));
  ObserverSetBalance(self->observer, state->balance);
  PetscCall(RestartTakeErrors(restart, state, self->estimate));
  if (state->laws.falls > 0) SceneAtSpeed(self->scene, state->laws.falls);
  PetscCall(PetscArraycpy(self->counted, state->counted, 2));
  self->kept = state->kept;
  self->crawl.way = state->kept.crawl_way;
  self->crawl.half = state->kept.crawl_half;
  self->crawl.steps = (PetscInt)state->kept.crawl_steps;
  self->crawl.at = state->kept.crawl_at;
  self->seen = state->seen;
  self->shared = state->laws.shared; /* it has been said */
  if (state->kept.changed < 0)
    self->kept.changed =
        state->points == 1 && state->step <= 2 * grow_rule.again_step * self->scene->end_time;
  self->seen.t = self->start = self->stored_shape = state->t;
  PetscCall(GrowLookForEvent(self, state->t, self->now->U, &event));
  UserCheck(!event.kind, self->scene->comm,
            "-stop_%s: it is so at t = %s already, where -restart %s is", event_name[event.kind],
            OptionBoth(state->t, UNIT_TIME, text), restart);
  if (self->by_steps)
    PetscCall(OutputTakeOver(restart, self->scene, state->t, self->output_interval,
                             GrowFollowsErrors(self), &self->output));
  else
    PetscCall(OutputContinue(output, restart, self->scene, state->t, self->output_interval,
                             &self->output));
  if (GrowFollowsErrors(self)) PetscCall(OutputFollows(self->output));
  PetscCall(GrowStore(self, PETSC_FALSE));
  if (!self->quiet)
    PetscCall(PetscPrintf(self->scene->comm, "goes on from t = %s of %s, into %s\n",
                          OptionBoth(state->t, UNIT_TIME, text), restart,
                          output[0] ? output : restart));
  self->next_output = OutputNext(state->t, self->output_interval);
  PetscFunctionReturn(0);
}

/* Has the run that this one goes on with been changed, in more than its end? Then it left the
   linear model for good: GrowChange(). */
static PetscBool ChangedBefore(const Grow *self) {
  const Changes list = self->scene->changes;

  for (PetscInt k = 0; list && k < list->done; k++)
    if (strcmp(list->row[k].what, "ts_max_time") != 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* GrowCreate - begins a run, of the scene in self, which is 0 but for what its creator says.
   Collective; the caller ends it with GrowDestroy(), also after an error. */
PetscErrorCode GrowCreate(Grow *self, const char *output, const char *restart) {
  PetscBool begun = PETSC_FALSE;
  RestartState state;

  PetscFunctionBegin;
  self->load = self->scene->load;
  self->enters = PETSC_TRUE;
  PetscCall(ReadOptions(self));
  UserCheck(
      self->by_steps || output[0] || restart[0] || self->member ||
          !OptionOnCommandLine("-output_interval"),
      self->scene->comm,
      "-output_interval: no shapes are stored without -output FILE; give it, or take this out");
  PetscCall(SetInterval(self, output, restart));
  if (restart[0]) PetscCall(RestartRead(restart, self->scene, &state, &begun));
  for (PetscInt m = 0; m < MODELS; m++)
    if (m == self->model ||
        (self->model == AUTO && (m == LINEAR || m == GrowWholeModel(self)) && self->can[m]))
      PetscCall(GrowAddLeg(self, m));
  PetscCall(CrawlAllowed(GrowOwnLeg(self)->ts, &self->crawl));
  PetscCall(RodHoldTip(GrowOwnLeg(self)->rod));
  if (begun) PetscCall(RestartChange(restart, NULL, self->scene));
  if (begun && ChangedBefore(self) && self->model == AUTO) self->can[LINEAR] = PETSC_FALSE;
  for (PetscInt m = 0; m < MODELS && begun; m++)
    if (self->leg[m].ts) PetscCall(LegEndAtTurns(&self->leg[m]));
  if (self->leg[GrowWholeModel(self)].rod)
    PetscCall(EstimateCreate(&self->leg[GrowWholeModel(self)], &self->estimate));
  PetscCall(GrowSensitivitiesCreate(self, output, restart));
  PetscCall(OptionsRefuseUnread());
  PetscCall(SceneChangesCheck(self->scene, begun ? state.t * (1 - grow_rule.same_time) : 0));
  UserCheck(!self->sensitivities || !self->scene->changes, self->scene->comm,
            "-sensitivity: is not known of a run in which something is changed; take it, or "
            "-change_file, out");
  PetscCall(ObserverCreate(self->scene, &self->observer));
  if (begun)
    PetscCall(GoOn(self, restart, &state, output));
  else
    PetscCall(Begin(self, output[0] ? output : restart));
  PetscFunctionReturn(0);
}

/* GrowDestroy - frees what a run has, also one that has failed. */
PetscErrorCode GrowDestroy(Grow *self) {
  PetscFunctionBegin;
  PetscCall(GrowMarksDestroy(self));
  PetscCall(GrowSensitivitiesDestroy(self));
  PetscCall(OutputDestroy(&self->output));
  PetscCall(ObserverDestroy(&self->observer));
  PetscCall(EstimateDestroy(&self->estimate));
  for (int m = 0; m < MODELS; m++) PetscCall(LegDestroy(&self->leg[m]));
  PetscFunctionReturn(0);
}
