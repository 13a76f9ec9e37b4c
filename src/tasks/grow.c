/* -task grow: the loop. */
#include "tasks/grow.h"
#include "base/signals.h"
#include "tasks/growing.h"
#include "rod/rules.h"
#include "tasks/grow_rules.h"
#include <signal.h>

static PetscErrorCode Self(TS ts, Grow **self) {
  Leg *leg;

  PetscFunctionBegin;
  *self = NULL;
  PetscCall(TSGetApplicationContext(ts, &leg));
  *self = (Grow *)leg->owner;
  PetscFunctionReturn(0);
}

/* GrowStoreShape - hands the shape of a state at time t to the output. U NULL: the initial shape.
 */
PetscErrorCode GrowStoreShape(Grow *self, PetscReal t, Vec U) {
  const PetscReal(*contact)[PUSH] = NULL;
  const Node *nodes;

  PetscFunctionBegin;
  PetscCall(ObserverGather(self->observer, self->now->rod, t, U, NULL, &nodes));
  if (nodes) PetscCall(ObserverContact(self->observer, t, nodes, &contact));
  if (nodes) PetscCall(OutputShape(self->output, t, nodes, contact));
  PetscCall(GrowSensitivitiesShape(self, t, U));
  self->stored_shape = t;
  PetscFunctionReturn(0);
}

/* Stores the shapes due between the previous step and this one, by the stepper's dense output. */
static PetscErrorCode StoreDueShapes(Grow *self, PetscReal t, Vec U) {
  Vec W;

  PetscFunctionBegin;
  while (self->next_output <= t * (1 + 1e-14)) {
    if (self->by_steps) PetscCall(GrowMark(self, self->next_output));
    if (self->next_output >= t * (1 - 1e-12))
      PetscCall(GrowStoreShape(self, t, U));
    else {
      PetscCall(VecDuplicate(self->now->U, &W));
      PetscCall(TSInterpolate(self->now->ts, self->next_output, W));
      PetscCall(GrowStoreShape(self, self->next_output, W));
      PetscCall(VecDestroy(&W));
    }
    self->next_output += self->output_interval;
  }
  PetscFunctionReturn(0);
}

/* GrowStore - brings all there is into the result file, with what the run needs to go on from here.
 */
PetscErrorCode GrowStore(Grow *self, PetscBool finished) {
  RestartState state;
  Vec points[VBDF_POINTS], errors[ESTIMATE_KEPT];

  PetscFunctionBegin;
  if (self->seen.t == 0) {
    PetscCall(OutputStore(self->output, self->now->rod, NULL, NULL, NULL, finished));
    PetscFunctionReturn(0);
  }
  if (!OutputStores(self->output)) PetscFunctionReturn(0);
  PetscCall(GrowKeep(self, &state, points, errors));
  PetscCall(OutputStore(self->output, self->now->rod, &state, points,
                        self->estimate ? errors : NULL, finished));
  PetscCall(EstimateVectorsDestroy(self->estimate, errors));
  PetscFunctionReturn(0);
}

/* Does what leads tip or clamp, feeds the rod, or moves a surface that is touched set out or stop
   at once between two times? */
static PetscBool LedRoundCorner(Scene scene, PetscBool touches, PetscReal t0, PetscReal t1) {
  return (PetscBool)(SceneJerks(scene, t0, t1) ||
                     (scene->tip.path && PathTurnsCorner(scene->tip.path, t0, t1)) ||
                     (scene->space.clamp_path && ScheduleJerks(scene->space.clamp_path, t0, t1)) ||
                     (touches && (SurfacesJerk(&scene->contact.surfaces, t0, t1) ||
                                  WallsJerk(&scene->contact.walls, t0, t1))));
}

/*
  IsThin - is the layer of a start that has given way still thinner than cells are long? A start out
  of balance, by a moment at its free tip, say, gives way in a layer that has no width at first, and

    (B t)^(1/4),   B = 1, where friction is 1 a length,

  at t. Where that is less than so many cells, what lies between nodes is not the rod's: its powers
  do not add up to what it loses, which friction takes, as in a snap.
*/
static PetscBool IsThin(const Grow *self, PetscReal t) {
  const Mesh *mesh = &self->scene->mesh;
  PetscReal longest = 0, width;

  if (!self->kept.gave_way || t > grow_rule.layer_run * self->scene->end_time) return PETSC_FALSE;
  for (PetscInt i = 0; i < mesh->cells; i++)
    longest = PetscMax(longest, mesh->s[i + 1] - mesh->s[i]);
  width = grow_rule.layer_cells * longest * self->scene->growth->initial_length;
  return (PetscBool)(t < PetscSqr(PetscSqr(width)));
}

/* Newton iterations since they were counted last. */
static PetscErrorCode CountIterations(Grow *self, PetscInt *iterations) {
  const PetscInt before = self->iterations;

  PetscFunctionBegin;
  PetscCall(TSGetSNESIterations(self->now->ts, &self->iterations));
  *iterations = self->iterations - before;
  PetscFunctionReturn(0);
}

/* How far has the step brought the run on: in time, and by what the rod has moved in it, for one
   that snaps gets on while time all but stands still. Counts snaps. Collective. */
static PetscErrorCode GetOn(Grow *self) {
  PetscReal speed;
  PetscBool begins;

  PetscFunctionBegin;
  PetscCall(LegSpeed(self->now, &speed, &begins));
  self->kept.way += self->seen.step * (1 + speed / grow_rule.motion_counts);
  self->kept.snaps += begins;
  if (begins && !self->scene->load.shared) (void)LoadShareMore(&self->scene->load);
  PetscFunctionReturn(0);
}

/* The estimate goes on, and the tolerance with it. */
static PetscErrorCode FollowErrors(Grow *self, PetscBool jumped) {
  PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN];

  PetscFunctionBegin;
  PetscCall(EstimateStep(self->estimate, jumped, self->kept.pressed));
  if (!self->estimate || self->now->ease.most <= 1 || !self->kept.pressed) PetscFunctionReturn(0);
  EstimateLatest(self->estimate, part, NULL);
  ToleranceFollow(self->rtol, (const PetscReal(*)[ESTIMATE_SEEN])part, &self->now->ease);
  PetscFunctionReturn(0);
}

/* GrowObserve - measures the state at a time, and follows what is followed; U NULL: as it begins.
   Collective. */
PetscErrorCode GrowObserve(Grow *self, PetscReal t, Vec U, Vec U_t) {
  PetscReal before = self->seen.t, norm = self->seen.norm_x2, efoldings = self->kept.folds;
  PetscInt iterations = 0, jumps = 0;
  PetscBool jumped = PETSC_FALSE, layered, broken;
  Observation last = self->seen;

  PetscFunctionBegin;
  layered = (PetscBool)(t <= grow_rule.initial_layer * self->scene->units.brief);
  if (U) {
    PetscCall(CountIterations(self, &iterations));
    PetscCall(VBDFGetJumps(self->now->ts, &jumps));
    jumped = (PetscBool)(jumps > self->now->jumps);
    if (jumped && layered) self->kept.gave_way = PETSC_TRUE;
    broken =
        (PetscBool)(jumped || self->kept.changed ||
                    LedRoundCorner(self->scene, (PetscBool)(last.contact_force > 0), before, t));
    if (broken || IsThin(self, before) || (layered && before == 0))
      ObserverClose(self->observer, &last, broken);
    self->kept.changed = PETSC_FALSE;
    if (self->now == &self->leg[GrowWholeModel(self)]) PetscCall(FollowErrors(self, jumped));
    self->now->jumps = jumps;
    if (jumped && !layered) self->kept.snaps++;
  }
  if (self->by_steps) ObserverGetBalance(self->observer, self->balance);
  PetscCall(ObserverMeasure(self->observer, self->now->rod, t, U, U_t, U ? self->now : NULL,
                            &self->seen));
  self->force_before = GrowBaseForce(&last);
  GrowFollowLamp(self, last.length > 0 ? &last : &self->seen);
  if (jumped) GrowCross(self, &last, before, layered);
  if (norm > rod_rule.vanished && self->seen.norm_x2 > rod_rule.vanished)
    self->kept.folds += PetscAbsReal(PetscLogReal(self->seen.norm_x2 / norm));
  if (norm > rod_rule.vanished && self->seen.norm_x2 <= rod_rule.vanished)
    self->kept.vanished = PETSC_TRUE;
  PetscCall(GrowNeglect(self, U_t));
  GrowWeigh(self, &last, self->kept.folds - efoldings);
  self->kept.depth = PetscMax(self->kept.depth, self->seen.penetration);
  self->kept.off = PetscMax(self->kept.off, -self->seen.penetration);
  if (self->seen.contact_force > 0) self->kept.pressed = PETSC_TRUE;
  self->seen.step = t - before;
  self->seen.newton_iterations = iterations;
  self->seen.model = self->now - self->leg;
  GrowFollowErrors(self, &last, jumped);
  PetscCall(OutputSeries(self->output, &self->seen));
  PetscCall(GrowSensitivitiesObserve(self, t, U, U_t));
  PetscFunctionReturn(0);
}

/* What the ranks must agree on after a step: a signal may have reached one of them only, and rank 0
   alone knows when to store. */
static PetscErrorCode Agree(Grow *self, PetscBool *store) {
  int word[2] = {SignalCaught(), OutputDue(self->output)};
  PetscBool drop = PETSC_FALSE;

  PetscFunctionBegin;
  if (self->member) PetscCall(self->member->meanwhile(self->member->ctx, &drop));
  if (drop && !word[0]) word[0] = SIGTERM;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, word, 2, MPI_INT, MPI_MAX, self->scene->comm));
  self->stopped = self->seen.t < self->scene->end_time ? word[0] : 0; /* at its end it has ended */
  *store = (PetscBool)word[1];
  PetscFunctionReturn(0);
}

/* Does the run, or this model of it, end with the step just taken? */
static PetscErrorCode StopHere(Grow *self, TS ts) {
  PetscFunctionBegin;
  self->beyond = (PetscBool)(self->model == LINEAR && self->seen.max_angle > 1);
  self->jammed = (PetscBool)(!self->event.kind && GrowIsJammed(self));
  if (self->event.kind) self->blinded = PETSC_FALSE;
  self->slips =
      (PetscBool)(!self->event.kind && GrowSlips(self) && !LoadShareMore(&self->scene->load));
  self->crawls =
      (PetscBool)(!self->event.kind && !self->jammed && !self->slips && GrowCrawls(self));
  if (self->event.kind || self->stopped || self->beyond || self->jammed || self->slips ||
      self->crawls || self->blinded ||
      (&self->leg[GrowBetterModel(self)] != self->now && self->seen.t < self->scene->end_time))
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  PetscFunctionReturn(0);
}

/* Looks at the step just taken. */
static PetscErrorCode TakeStep(Grow *self, TS ts) {
  PetscBool store, crosses;
  PetscReal t;
  Vec U, U_t, here[2] = {NULL, NULL};

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &t));
  U = self->now->U;
  U_t = self->now->newton.latest.U_t;
  PetscCall(GrowSensitivitiesStep(self, t));
  if (self->watch.any) {
    for (int k = 0; k < 2; k++) PetscCall(VecDuplicate(U, &here[k]));
    PetscCall(GrowLocateEvent(self, &t, here[0], here[1]));
    if (self->event.kind) U = here[0], U_t = here[1];
  }
  PetscCall(GrowObserve(self, t, U, U_t));
  PetscCall(GetOn(self));
  PetscCall(StoreDueShapes(self, t, U));
  if (self->event.kind) PetscCall(VecCopy(U, self->now->U)); /* the run ends there */
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&here[k]));
  PetscCall(LegCrosses(self->now, U, &crosses));
  self->kept.blind += crosses;
  PetscCall(GrowShared(self, t));
  PetscCall(GrowProgress(self, PETSC_FALSE));
  PetscCall(Agree(self, &store));
  PetscCall(StopHere(self, ts));
  if (store) PetscCall(GrowStore(self, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* Is one step taken after the other, for between them something may be changed? */
static PetscBool ByTurns(const Grow *self) {
  return (PetscBool)(self->by_steps || self->scene->changes);
}

/* GrowAfterStep - what a stepper calls behind each of its steps: looks at it, unless it is to wait.
 */
PetscErrorCode GrowAfterStep(TS ts) {
  TSConvergedReason reason;
  PetscInt steps, most;
  PetscReal t;
  Grow *self;

  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (reason < 0) PetscFunctionReturn(0); /* called after a step that failed, too */
  PetscCall(Self(ts, &self));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetStepNumber(ts, &steps));
  PetscCall(TSGetMaxSteps(ts, &most));
  if (!reason) { /* newer PETSc leaves that to TSSolve() */
    if (steps >= most)
      reason = TS_CONVERGED_ITS;
    else if (t >= self->scene->end_time)
      reason = TS_CONVERGED_TIME;
    PetscCall(TSSetConvergedReason(ts, reason));
  }
  self->waits = (PetscBool)(ByTurns(self) && t > self->until * (1 + grow_rule.same_time));
  self->reason = reason;
  if (!self->waits) PetscCall(TakeStep(self, ts));
  if (ByTurns(self)) PetscCall(TSGetConvergedReason(ts, &reason));
  if (self->waits || (ByTurns(self) && !reason))
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER)); /* the host has its turn */
  PetscFunctionReturn(0);
}

/* GrowStepOnce - one step of a TS that solves already, as TSSolve() takes it: that would limit it
   once more. */
PetscErrorCode GrowStepOnce(TS ts) {
  PetscReal t;
  PetscInt steps;
  Vec U;

  PetscFunctionBegin;
  PetscCall(TSPreStep(ts));
  PetscCall(TSStep(ts));
  PetscCall(TSPostEvaluate(ts));
  PetscCall(TSPostStep(ts));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetStepNumber(ts, &steps));
  PetscCall(TSGetSolution(ts, &U));
  PetscCall(TSMonitor(ts, steps, t, U));
  PetscFunctionReturn(0);
}

/* What follows where the stepper has stopped. A rod in dry friction that finds no step tries again
   with a viscous share, or a larger one, in steps of grow_rule.again_step of the run on. */
static PetscErrorCode AfterSolve(Grow *self) {
  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(self->now->ts, &self->reason));
  self->enters = PETSC_FALSE;
  if (self->reason < 0 && !self->stopped && LoadMaySlip(&self->scene->load) &&
      LoadShareMore(&self->scene->load)) {
    PetscCall(TSRestartStep(self->now->ts));
    PetscCall(TSSetTimeStep(self->now->ts, grow_rule.again_step * self->scene->end_time));
    self->enters = PETSC_TRUE;
  } else if (self->reason != TS_CONVERGED_USER || self->stopped || self->beyond || self->jammed ||
             self->slips || self->crawls || self->blinded || self->event.kind)
    self->over = PETSC_TRUE;
  else if (self->now != &self->leg[GrowBetterModel(self)]) {
    PetscCall(GrowHandOver(self, &self->leg[GrowBetterModel(self)]));
    self->enters = PETSC_TRUE;
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Follow(Grow *self) {
  PetscFunctionBegin;
  while (!self->over && self->scene->changes) PetscCall(GrowStepOn(self, PETSC_MAX_REAL));
  while (!self->over) {
    PetscCall(TSSolve(self->now->ts, self->now->U));
    PetscCall(AfterSolve(self));
  }
  PetscCall(GrowProgress(self, PETSC_TRUE));
  PetscCall(GrowTellNotReached(self));
  PetscFunctionReturn(0);
}

/*
  GrowStep - takes one step of a run by steps, or, if that has led beyond a time, lets it wait: the
  rod is then where it was, and what is between is known by the stepper's dense output. A step that
  waits is looked at by the first call that asks for as much. Collective.

  until  that time; PETSC_MAX_REAL: none

  What a run by steps does is what it does otherwise, to the last digit.
*/
PetscErrorCode GrowStep(Grow *self, PetscReal until) {
  TS ts = self->now->ts;
  PetscReal t;

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &t));
  self->until = until;
  if (self->over || (self->waits && t > until)) PetscFunctionReturn(0);
  if (self->waits) {
    self->waits = PETSC_FALSE;
    PetscCall(TSSetConvergedReason(ts, self->reason));
    PetscCall(GrowAfterStep(ts));
  } else if (self->enters)
    PetscCall(TSSolve(ts, self->now->U));
  else
    PetscCall(GrowStepOnce(ts));
  if (!self->waits) PetscCall(AfterSolve(self));
  PetscFunctionReturn(0);
}

/*
  GrowWithin - the state and its rate at a time within the latest step, or within the one that
  waits: by the stepper's dense output. Collective.

  V      made here: the caller destroys them
  begin  of that step; may be NULL
*/
PetscErrorCode GrowWithin(Grow *self, PetscReal t, Vec V[2], PetscReal *begin) {
  PetscReal end = self->seen.t, h = self->seen.step;

  PetscFunctionBegin;
  if (self->waits) {
    PetscCall(TSGetTime(self->now->ts, &end));
    h = end - self->seen.t;
  }
  for (int k = 0; k < 2; k++) PetscCall(VecDuplicate(self->now->U, &V[k]));
  PetscCall(LegInterpolate(self->now, t, end, h, V[0], V[1]));
  if (begin) *begin = end - h;
  PetscFunctionReturn(0);
}

/* GrowSettle - a run by steps goes on from a time within the step that waits, as if that had ended
   there: with what the dense output has. Collective. */
PetscErrorCode GrowSettle(Grow *self, PetscReal t) {
  Vec V[2];

  PetscFunctionBegin;
  if (!self->waits) PetscFunctionReturn(0);
  PetscCall(GrowWithin(self, t, V, NULL));
  self->waits = PETSC_FALSE;
  PetscCall(GrowObserve(self, t, V[0], V[1]));
  PetscCall(StoreDueShapes(self, t, V[0]));
  PetscCall(VecCopy(V[0], self->now->U));
  PetscCall(TSSetTime(self->now->ts, t));
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&V[k]));
  PetscFunctionReturn(0);
}

/* GrowChange - the scene has changed at the present time. Where that acts on the rod, and is not
   its end alone, steps begin again there, short, and in the model that leaves nothing out.
   Collective. */
PetscErrorCode GrowChange(Grow *self, PetscBool acts) {
  PetscFunctionBegin;
  for (PetscInt m = 0; m < MODELS; m++)
    if (self->leg[m].ts) {
      PetscCall(TSSetMaxTime(self->leg[m].ts, self->scene->end_time));
      PetscCall(LegEndAtTurns(&self->leg[m]));
    }
  PetscCall(GrowFindEnd(self));
  if (!acts) PetscFunctionReturn(0);
  self->kept.changed = PETSC_TRUE;
  self->can[LINEAR] = (PetscBool)(self->can[LINEAR] && self->model == LINEAR);
  if (self->now != &self->leg[GrowBetterModel(self)]) {
    PetscCall(GrowHandOver(self, &self->leg[GrowBetterModel(self)]));
    self->enters = PETSC_TRUE;
  }
  PetscCall(VBDFBeginAnew(self->now->ts));
  PetscCall(TSSetTimeStep(self->now->ts, grow_rule.again_step * self->scene->end_time));
  PetscFunctionReturn(0);
}

static PetscErrorCode Run(Grow *self, PetscBool *again) {
  PetscErrorCode error;

  PetscFunctionBegin;
  if (!self->member) SignalsCatch();
  PetscCall(GrowHeading(self));
  error = Follow(self);
  if (error) (void)GrowEnd(self, PETSC_FALSE); /* what has been computed is not lost */
  PetscCall(error);
  PetscCall(GrowFinish(self, again));
  PetscFunctionReturn(0);
}

/* GrowStartOver - ends a run, whose scene is then ready to be run once more, with soft contact. */
PetscErrorCode GrowStartOver(Grow *self) {
  const Grow begun = {.scene = self->scene, .member = self->member, .by_steps = self->by_steps};
  const Load load = self->load;

  PetscFunctionBegin;
  PetscCall(GrowDestroy(self));
  *self = begun;
  SceneAtSpeed(self->scene, 0);
  self->scene->load = load;
  PetscCall(ContactStaysSoft(&self->scene->contact));
  PetscFunctionReturn(0);
}

/* A rod that is wedged may find no way, or crawl, in firm contact, and come through in soft
   contact, which lets it in. So what one run cannot bring to its end another one is to, from the
   beginning: a law that gave way in the course of a run would leave the rod out of balance. */
static PetscErrorCode CreateAndRun(Grow *self, const char *output, const char *restart) {
  PetscBool again = PETSC_FALSE;
  PetscErrorCode error;

  PetscFunctionBegin;
  do {
    if (again) PetscCall(GrowStartOver(self));
    again = PETSC_FALSE;
    error = GrowCreate(self, output, restart);
    if (!error) error = Run(self, &again);
    if (error) PetscCall(GrowDestroy(self));
    PetscCall(error);
  } while (again);
  PetscCall(GrowDestroy(self));
  SceneAtSpeed(self->scene, 0);
  PetscFunctionReturn(0);
}

/*
  GrowRun - follows the rod of a scene from t = 0 to its end time. Collective on the scene's ranks.

  output   the result file; empty: none
  restart  the result file of a run to go on with; empty: none

  Ends with a user's error, the last state stored, if the stepper gives up or the run is
  interrupted (SIGTERM, SIGINT).
*/
PetscErrorCode GrowRun(Scene scene, const char *output, const char *restart) {
  Grow grow = {.scene = scene};

  PetscFunctionBegin;
  PetscCall(CreateAndRun(&grow, output, restart));
  PetscFunctionReturn(0);
}

/* GrowMember - as GrowRun(), of a member of a sweep: nothing is printed, signals are the sweep's,
   and what the run leaves is in memory. Collective on the scene's ranks. */
PetscErrorCode GrowMember(Scene scene, const char *output, Member *member) {
  Grow grow = {.scene = scene, .member = member};

  PetscFunctionBegin;
  PetscCall(CreateAndRun(&grow, output, ""));
  PetscFunctionReturn(0);
}
