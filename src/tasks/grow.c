/* -task grow: the loop, and the hand-over between models. */
#include "tasks/accuracy.h"
#include "tasks/grow.h"
#include "base/signals.h"
#include "rod/passing.h"
#include "scene/change.h"
#include "tasks/growing.h"
#include <signal.h>

const RodModel *const grow_models[MODELS] = {&rod_linear, &rod_frame, &rod_mixed, &rod_space};

/* Of which the linear one is another for a rod in space. */
static const RodModel *ModelOf(const Grow *self, PetscInt model) {
  return model == LINEAR && self->scene->space.rod ? &rod_linear_space : grow_models[model];
}

/* The model of auto that leaves nothing out. */
static PetscInt WholeModel(const Grow *self) {
  return self->scene->space.rod ? SPACE : FRAME;
}

/* Of the model that was asked for; of auto, of that one. */
static Leg *OwnLeg(Grow *self) {
  return &self->leg[self->model == AUTO ? WholeModel(self) : self->model];
}

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

/* Brings all there is into the result file, with what the run needs to go on from here. */
static PetscErrorCode Store(Grow *self, PetscBool finished) {
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
  for (int k = 0; k < ESTIMATE_KEPT && self->estimate; k++) PetscCall(VecDestroy(&errors[k]));
  PetscFunctionReturn(0);
}

/* auto: takes the linear model while what it leaves out (Neglect()) is below the tolerance of a
   step, and takes it up again only when well below, so that it does not flicker. */
static PetscInt BetterModel(const Grow *self) {
  const PetscReal neglected = PetscMax(self->neglects, PetscSqr(self->seen.max_angle));
  const PetscInt whole = WholeModel(self);
  if (self->model != AUTO) return self->model;
  if (!self->can[LINEAR]) return whole;
  if (self->now == &self->leg[LINEAR]) return neglected > 0.3 * self->rtol ? whole : LINEAR;
  return neglected < 0.03 * self->rtol ? LINEAR : whole;
}

/* How much the linear model's energy changes, which tells of the deflection where |x2| is that of a
   clamp that leans. And its folds once more, as what steps have added in each weighs in the energy:
   it may be in short waves, small beside |x2|, and when these are what is left, as the root of the
   energy over |x2| tells, it weighs so much more. */
static void Weigh(Grow *self, const Observation *last, PetscReal folds) {
  const PetscReal least = 1e-300, size = PetscMax(self->seen.norm_x2, self->seen.norm_x3),
                  before = PetscMax(last->norm_x2, last->norm_x3);
  PetscReal grown;

  if (self->weighed == 0) self->weighed = FEWEST_FOLDS;
  if (self->now == &self->leg[LINEAR] && PetscMin(size, before) > rod_vanished &&
      PetscMin(self->seen.energy, last->energy) > least) {
    grown = self->seen.energy / last->energy;
    self->energy_folds += PetscAbsReal(PetscLogReal(grown));
    self->weighed *= PetscSqrtReal(grown) * before / size;
  }
  self->weighed += folds;
}

/* The linear model leaves out terms of the square of the angle and, in friction, of the square of
   the speed across the rod over that along it: of about 1, or, of a part that is at rest, of what
   there is in its place, the root of beta. */
static PetscErrorCode Neglect(Grow *self, Vec U_t) {
  const RodModel *model = self->now->rod->model;
  const Load *load = &self->scene->load;
  PetscReal speed[MAX_FIELDS] = {0}, across = 0;

  PetscFunctionBegin;
  if (self->model != LINEAR && self->model != AUTO) PetscFunctionReturn(0);
  if (U_t) PetscCall(RodFieldSizes(self->now->rod, U_t, speed));
  for (PetscInt f = 0; f < model->fields; f++)
    if (!strcmp(model->field[f], "y") || !strcmp(model->field[f], "x2") ||
        !strcmp(model->field[f], "x3"))
      across = PetscMax(across, speed[f]);
  self->neglects = PetscSqr(across);
  if (load->told > 0 && load->friction.mu > 0) self->neglects /= load->friction.beta;
  self->neglects = PetscMax(self->neglects, PetscSqr(self->seen.max_angle));
  if (self->model == LINEAR) self->neglected = PetscMax(self->neglected, self->neglects);
  PetscFunctionReturn(0);
}

/* Jumps before this part of what short steps are part of cross the layer of a start, and are no
   snaps (controller.c). A first step that ends in it is one of a start out of balance: what is lost
   on the way to its end goes by rates that nothing tells, for a start has none. */
static const PetscReal initial_layer = 1e-6;

/* Does what leads tip or clamp, feeds the rod, or moves a surface that is touched set out or stop
   at once between two times? */
static PetscBool LedRoundCorner(Scene scene, PetscBool touches, PetscReal t0, PetscReal t1) {
  return (PetscBool)(SceneJerks(scene, t0, t1) ||
                     (scene->tip.path && PathTurnsCorner(scene->tip.path, t0, t1)) ||
                     (scene->space.clamp_path && ScheduleJerks(scene->space.clamp_path, t0, t1)) ||
                     (touches && SurfacesJerk(&scene->contact.surfaces, t0, t1)));
}

/*
  IsThin - is the layer of a start that has given way still thinner than cells are long? A start out
  of balance, by a moment at its free tip, say, gives way in a layer that has no width at first, and

    (B t)^(1/4),   B = 1, where friction is 1 a length,

  at t. Where that is less than so many cells, what lies between nodes is not the rod's: its powers
  do not add up to what it loses, which friction takes, as in a snap.
*/
static PetscBool IsThin(const Grow *self, PetscReal t) {
  const PetscReal cells_wide = 2, most = 1e-3; /* and no more than that part of the run */
  const Mesh *mesh = &self->scene->mesh;
  PetscReal longest = 0, width;

  if (!self->gave_way || t > most * self->scene->end_time) return PETSC_FALSE;
  for (PetscInt i = 0; i < mesh->cells; i++)
    longest = PetscMax(longest, mesh->s[i + 1] - mesh->s[i]);
  width = cells_wide * longest * self->scene->growth->initial_length;
  return (PetscBool)(t < PetscSqr(PetscSqr(width)));
}

static PetscReal BaseForce(const Observation *seen) {
  return hypot(hypot(seen->base_force_1, seen->base_force_2), seen->base_force_3);
}

/* Newton iterations since they were counted last. */
static PetscErrorCode CountIterations(Grow *self, PetscInt *iterations) {
  const PetscInt before = self->iterations;

  PetscFunctionBegin;
  PetscCall(TSGetSNESIterations(self->now->ts, &self->iterations));
  *iterations = self->iterations - before;
  PetscFunctionReturn(0);
}

/* What a rod moves so much faster than it grows counts as much as growth does. */
static const PetscReal counts_as = 10;

/* How far has the step brought the run on: in time, and by what the rod has moved in it, for one
   that snaps gets on while time all but stands still. Counts snaps. Collective. */
static PetscErrorCode GetOn(Grow *self) {
  PetscReal speed;
  PetscBool begins;

  PetscFunctionBegin;
  PetscCall(LegSpeed(self->now, &speed, &begins));
  self->way += self->seen.step * (1 + speed / counts_as);
  self->snaps += begins;
  if (begins && !self->scene->load.shared) (void)LoadShareMore(&self->scene->load);
  PetscFunctionReturn(0);
}

/* The estimate goes on, and the tolerance with it. */
static PetscErrorCode FollowErrors(Grow *self, PetscBool jumped) {
  PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN];

  PetscFunctionBegin;
  PetscCall(EstimateStep(self->estimate, jumped, self->pressed));
  if (!self->estimate || self->now->ease.most <= 1 || !self->pressed) PetscFunctionReturn(0);
  EstimateLatest(self->estimate, part, NULL);
  ToleranceFollow(self->rtol, (const PetscReal(*)[ESTIMATE_SEEN])part, &self->now->ease);
  PetscFunctionReturn(0);
}

static PetscErrorCode Observe(Grow *self, PetscReal t, Vec U, Vec U_t) {
  PetscReal before = self->seen.t, norm = self->seen.norm_x2, folds = self->folds;
  PetscInt iterations = 0, jumps = 0;
  PetscBool jumped = PETSC_FALSE, layered, broken;
  Observation last = self->seen;

  PetscFunctionBegin;
  layered = (PetscBool)(t <= initial_layer * self->scene->units.brief);
  if (U) {
    PetscCall(CountIterations(self, &iterations));
    PetscCall(VBDFGetJumps(self->now->ts, &jumps));
    jumped = (PetscBool)(jumps > self->now->jumps);
    if (jumped && layered) self->gave_way = PETSC_TRUE;
    broken =
        (PetscBool)(jumped || self->changed ||
                    LedRoundCorner(self->scene, (PetscBool)(last.contact_force > 0), before, t));
    if (broken || IsThin(self, before) || (layered && before == 0))
      ObserverClose(self->observer, &last, broken);
    self->changed = PETSC_FALSE;
    if (self->now == &self->leg[WholeModel(self)]) PetscCall(FollowErrors(self, jumped));
    self->now->jumps = jumps;
    if (jumped && !layered) self->snaps++;
  }
  if (self->by_steps) PetscCall(ObserverGetBalance(self->observer, self->balance));
  PetscCall(ObserverMeasure(self->observer, self->now->rod, t, U, U_t, U ? self->now->ts : NULL,
                            &self->seen));
  self->force_before = BaseForce(&last);
  if (jumped) GrowCross(self, &last, before, layered);
  if (norm > rod_vanished && self->seen.norm_x2 > rod_vanished)
    self->folds += PetscAbsReal(PetscLogReal(self->seen.norm_x2 / norm));
  if (norm > rod_vanished && self->seen.norm_x2 <= rod_vanished) self->vanished = PETSC_TRUE;
  PetscCall(Neglect(self, U_t));
  Weigh(self, &last, self->folds - folds);
  self->depth = PetscMax(self->depth, self->seen.penetration);
  self->off = PetscMax(self->off, -self->seen.penetration);
  if (self->seen.contact_force > 0) self->pressed = PETSC_TRUE;
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

/* Did contact get firm of itself? */
static PetscBool GotFirm(const Contact *contact) {
  return (PetscBool)(contact->deepest && contact->firm);
}

/* Is it in touch with a wall that rubs? */
static PetscBool RubsOnWalls(const Grow *self) {
  return (PetscBool)(self->seen.contact_force > 0 && ContactWallsRub(&self->scene->contact));
}

/* ... while dry friction holds it, too: see crawl_held. */
static PetscBool HeldTwice(const Grow *self) {
  return (PetscBool)(RubsOnWalls(self) && 1 - self->scene->load.friction.mu < 1e-3);
}

static PetscBool Crawls(Grow *self) {
  if (self->seen.t >= self->scene->end_time) return PETSC_FALSE;
  self->crawl.counts = (PetscBool)(GotFirm(&self->scene->contact) || RubsOnWalls(self));
  return (PetscBool)(CrawlStep(&self->crawl, self->seen.t, self->way,
                               crawl_part * PetscMin(self->seen.length, self->end),
                               (PetscInt)self->seen.newton_iterations) &&
                     !self->crawl.allowed);
}

/* Does the run, or this model of it, end with the step just taken? */
static PetscErrorCode StopHere(Grow *self, TS ts) {
  PetscFunctionBegin;
  self->beyond = (PetscBool)(self->model == LINEAR && self->seen.max_angle > 1);
  self->jammed = (PetscBool)(!self->event.kind && GrowIsJammed(self));
  self->slips =
      (PetscBool)(!self->event.kind && GrowSlips(self) && !LoadShareMore(&self->scene->load));
  self->crawls = (PetscBool)(!self->event.kind && !self->jammed && !self->slips && Crawls(self));
  if (self->event.kind || self->stopped || self->beyond || self->jammed || self->slips ||
      self->crawls ||
      (&self->leg[BetterModel(self)] != self->now && self->seen.t < self->scene->end_time))
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
  PetscCall(Observe(self, t, U, U_t));
  PetscCall(GetOn(self));
  PetscCall(StoreDueShapes(self, t, U));
  if (self->event.kind) PetscCall(VecCopy(U, self->now->U)); /* the run ends there */
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&here[k]));
  PetscCall(LegCrosses(self->now, U, &crosses));
  self->blind += crosses;
  PetscCall(GrowShared(self, t));
  PetscCall(GrowProgress(self, PETSC_FALSE));
  PetscCall(Agree(self, &store));
  PetscCall(StopHere(self, ts));
  if (store) PetscCall(Store(self, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* Is one step taken after the other, for between them something may be changed? */
static PetscBool ByTurns(const Grow *self) {
  return (PetscBool)(self->by_steps || self->scene->changes);
}

static PetscErrorCode AfterStep(TS ts) {
  const PetscReal same = 1e-12;
  TSConvergedReason reason;
  PetscReal t;
  Grow *self;

  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (reason < 0) PetscFunctionReturn(0); /* called after a step that failed, too */
  PetscCall(Self(ts, &self));
  PetscCall(TSGetTime(ts, &t));
  if (!reason && t >= self->scene->end_time) { /* newer PETSc leaves that to TSSolve() */
    reason = TS_CONVERGED_TIME;
    PetscCall(TSSetConvergedReason(ts, reason));
  }
  self->waits = (PetscBool)(ByTurns(self) && t > self->until * (1 + same));
  self->reason = reason;
  if (!self->waits) PetscCall(TakeStep(self, ts));
  if (ByTurns(self)) PetscCall(TSGetConvergedReason(ts, &reason));
  if (self->waits || (ByTurns(self) && !reason))
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER)); /* the host has its turn */
  PetscFunctionReturn(0);
}

static PetscErrorCode AddLeg(Grow *self, PetscInt model) {
  Leg *leg = &self->leg[model];

  PetscFunctionBegin;
  PetscCall(LegCreate(self->scene, ModelOf(self, model), self->rtol, leg));
  leg->owner = self;
  leg->ease.most = self->eased / self->rtol;
  PetscCall(TSSetMaxTime(leg->ts, self->scene->end_time));
  PetscCall(TSSetPostStep(leg->ts, AfterStep));
  PetscCall(LegEndAtTurns(leg));
  PetscFunctionReturn(0);
}

/* The same state in another model's unknowns. */
static PetscErrorCode Convert(Leg *from, Leg *to, PetscReal t, Vec U, Vec V) {
  Node *nodes;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(from->rod->end - from->rod->first, &nodes));
  PetscCall(from->rod->model->get(from->rod, t, U, NULL, nodes));
  PetscCall(to->rod->model->set(to->rod, t, nodes, V));
  PetscCall(PetscFree(nodes));
  PetscFunctionReturn(0);
}

/* Hands time, state, step and history over to another model. */
static PetscErrorCode HandOver(Grow *self, Leg *to) {
  Leg *from = self->now;
  PetscReal t, dt, times[VBDF_POINTS];
  PetscInt n, order, steps;
  char text[64];
  Vec old[VBDF_POINTS], new[VBDF_POINTS];

  PetscFunctionBegin;
  PetscCall(TSGetTime(from->ts, &t));
  PetscCall(TSGetTimeStep(from->ts, &dt));
  PetscCall(TSGetStepNumber(from->ts, &steps));
  PetscCall(TSSetTime(to->ts, t));
  PetscCall(TSSetTimeStep(to->ts, dt));
  PetscCall(TSSetStepNumber(to->ts, steps));
  PetscCall(Convert(from, to, t, from->U, to->U));
  PetscCall(VBDFGetHistory(from->ts, &n, times, old, &order));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(VecDuplicate(to->U, &new[i]));
    PetscCall(Convert(from, to, t + times[i], old[i], new[i]));
  }
  PetscCall(VBDFSetHistory(to->ts, n, times, new, order));
  for (PetscInt i = 0; i < n; i++) PetscCall(VecDestroy(&new[i]));
  PetscCall(TSGetSNESIterations(to->ts, &self->iterations));
  self->now = to;
  if (!self->quiet)
    PetscCall(PetscPrintf(self->scene->comm, "t = %s: from the %s to the %s model\n",
                          OptionBoth(t, UNIT_TIME, text), from->rod->model->name,
                          to->rod->model->name));
  PetscFunctionReturn(0);
}

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
  UserCheck(!space->rod || !self->member || self->member->values == OBSERVED_IN_SPACE,
            self->scene->comm,
            "%s: takes this rod out of the plane, as nothing that the sweep's options say does; "
            "give the sweep -rod_model space",
            space->why ? space->why : "-rod_model");
  PetscFunctionReturn(0);
}

/* A rod that slides along an edge jerks, by next to nothing, for each place of the mesh that comes
   to it or leaves it: steps of the usual tolerance would follow that, two to four times as many,
   and the tip be nearer by less than a hundredth of what contact's own stiffness puts it off.
   Whether even this is finer than need be, the estimate tells (ToleranceFollow()). */
static PetscErrorCode ChooseTolerance(Grow *self) {
  const PetscReal eases = 10;
  const PetscBool touches = self->scene->contact.any;
  PetscBool given, eased;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-ts_rtol", &given));
  PetscCall(AccuracyTolerance());
  if (touches) PetscCall(OptionDefault("-ts_rtol", "1e-5"));
  PetscCall(OptionReal("-ts_rtol", &self->rtol, NULL));
  if (touches && !given) PetscCall(OptionDefault("-contact_rtol", "%.3g", eases * self->rtol));
  PetscCall(OptionReal("-contact_rtol", &self->eased, &eased));
  UserCheck(touches || !eased, OptionsComm(),
            "-contact_rtol: there is nothing to touch; give -wall_file, or -contact_self");
  UserCheck(!eased || self->eased >= self->rtol, OptionsComm(),
            "-contact_rtol %g: is below -ts_rtol, %g, and steps are never finer than that; give "
            "a smaller -ts_rtol",
            (double)self->eased, (double)self->rtol);
  /* of a run gone on with, both are as they were, but for what is given anew */
  if (!eased || (OptionOnCommandLine("-ts_rtol") && !OptionOnCommandLine("-contact_rtol")))
    self->eased = self->rtol;
  SceneAtTolerance(self->scene, self->rtol);
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadOptions(Grow *self) {
  PetscFunctionBegin;
  PetscCall(ChooseModel(self));
  PetscCall(ChooseTolerance(self));
  PetscCall(WatchSetFromOptions(&self->watch, self->scene));
  PetscCall(OptionBool("-quiet", &self->quiet, NULL));
  if (self->member) self->quiet = PETSC_TRUE;
  for (PetscInt m = 0; m < MODELS; m++) {
    const RodModel *model = ModelOf(self, m);
    const char *why = model->refuses ? model->refuses(self->scene) : NULL;
    self->can[m] = (PetscBool)(why == NULL);
    UserCheck(!why || self->model != m, self->scene->comm, "%s; %s", why,
              m == SPACE               ? "take it out, or what takes the rod out of the plane"
              : self->scene->space.why ? "take -rod_model space"
                                       : "take -rod_model frame or auto");
  }
  PetscFunctionReturn(0);
}

/* Refuses surfaces in space that are hollow and hardly wider than the rod: in their middle contact
   would press from all sides at once. */
static PetscErrorCode CheckRoom(Grow *self) {
  const Contact *contact = &self->scene->contact;
  char text[2][64];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < contact->surfaces.n; k++) {
    const Surface *surface = &contact->surfaces.surface[k];
    const PetscReal stiffer = PetscPowReal(2 * contact->smooth / surface->room, 4. / 3);
    if (surface->room > contact->smooth) continue;
    UserCheck(PETSC_FALSE, self->scene->comm,
              "-wall_file, line %d: the %s is wider than the rod by only %s on all sides, and "
              "contact sets in %s from a wall: make it wider, or give -contact_stiffness %.1e",
              surface->line, surface->kind->name, OptionBoth(surface->room, UNIT_LENGTH, text[0]),
              OptionBoth(contact->smooth, UNIT_LENGTH, text[1]),
              (double)(contact->stiffness * stiffer));
  }
  PetscFunctionReturn(0);
}

/* Refuses a clamp that is behind a surface in space. */
static PetscErrorCode CheckClamp(Grow *self) {
  const Surfaces *surfaces = &self->scene->contact.surfaces;
  const PetscReal clamp[3] = {0, 0, 0};
  const Surface *surface;
  PetscInt nearest = -1;

  PetscFunctionBegin;
  if (self->scene->clamp == CLAMP_FREE) PetscFunctionReturn(0);
  (void)SurfacesDistance(surfaces, clamp, 0, &nearest);
  if (nearest < 0) PetscFunctionReturn(0);
  surface = &surfaces->surface[nearest];
  UserCheck(!surface->hollow, self->scene->comm,
            "-wall_file, line %d: the rod starts in a wall: the clamp, at 0, is out of the %s that "
            "the rod is to be inside of; move it, or give outside",
            surface->line, surface->kind->name);
  UserCheck(
      PETSC_FALSE, self->scene->comm,
      "-wall_file, line %d: the rod starts in a wall: the clamp, at 0, is behind the %s; move "
      "it, or take its other side",
      surface->line, surface->kind->name);
  PetscFunctionReturn(0);
}

/* Of the distance at which contact sets in: so much nearer a place is not worth a line. A wall at
   which a rod begins is taken off by that distance where the rod is nearest, and along a tube's
   floor, a spline, other places are a little nearer. */
static const PetscReal part_near = 1e-3;

/* Says how near a rod begins to a wall, if contact sets in there already. */
static PetscErrorCode TellNear(const Grow *self, const TouchSum *touch) {
  const Contact *contact = &self->scene->contact;
  const PetscReal off = self->scene->stands_off;
  char text[2][64];

  PetscFunctionBegin;
  if (self->quiet) PetscFunctionReturn(0);
  OptionBoth(contact->smooth, UNIT_LENGTH, text[0]);
  if (off > 0)
    PetscCall(PetscPrintf(self->scene->comm,
                          "-wall_file: the rod begins at a wall, %s from it; contact sets in %s "
                          "before surfaces meet, and so the wall is taken so much farther off\n",
                          OptionBoth(contact->smooth - off, UNIT_LENGTH, text[1]), text[0]));
  if (touch->nearest < (1 - part_near) * contact->smooth && touch->at[1] < 0)
    PetscCall(PetscPrintf(
        self->scene->comm,
        "-wall_file: the rod begins %s from a wall at s = %g, and contact sets in "
        "%s before surfaces meet: it is pushed off at once; leave more room\n",
        OptionBoth(touch->nearest, UNIT_LENGTH, text[1]), (double)touch->at[0], text[0]));
  PetscFunctionReturn(0);
}

/* Refuses a rod that starts in a wall, or touching itself. */
static PetscErrorCode CheckStart(Grow *self) {
  const Contact *contact = &self->scene->contact;
  TouchSum touch = {.nearest = PETSC_MAX_REAL};
  const Node *nodes;
  char text[64];

  PetscFunctionBegin;
  if (!contact->any) PetscFunctionReturn(0);
  PetscCall(CheckClamp(self));
  PetscCall(CheckRoom(self));
  PetscCall(ObserverGather(self->observer, self->now->rod, 0, NULL, NULL, &nodes));
  if (nodes) PetscCall(ObserverTouch(self->observer, 0, nodes, &touch));
  PetscCallMPI(MPI_Bcast(&touch, sizeof(touch), MPI_BYTE, 0, self->scene->comm));
  OptionBoth(-touch.nearest, UNIT_LENGTH, text);
  UserCheck(
      touch.nearest >= -contact->smooth || touch.at[1] >= 0, self->scene->comm,
      "-wall_file: the rod starts in a wall, %s deep at s = %g; move the wall or make the rod "
      "thinner (-contact_diameter)",
      text, (double)touch.at[0]);
  UserCheck(touch.nearest >= -contact->smooth, self->scene->comm,
            "-contact_self: the rod touches itself at the start, at s = %g and %g; give another "
            "shape or a smaller -contact_diameter",
            (double)touch.at[0], (double)touch.at[1]);
  PetscCall(TellNear(self, &touch));
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

/* Refuses a rod that starts behind a polygon's surface, or across a wall that is between two nodes.
 */
static PetscErrorCode CheckWalls(Grow *self) {
  const Walls *walls = &self->scene->contact.walls;
  const PetscReal clamp[2] = {0, 0};
  const PetscInt behind = WallsBehind(walls, clamp);
  Rod rod = self->now->rod;
  PetscBool passes;

  PetscFunctionBegin;
  UserCheck(behind < 0, self->scene->comm,
            "-wall_file: the rod starts in a wall: the clamp is %s wall %d, a polygon %s; take the "
            "other of outside and inside, or move it",
            walls->wall[behind].inside ? "out of" : "in", (int)behind + 1,
            walls->wall[behind].inside ? "inside" : "outside");
  PetscCall(RodBegin(rod, self->now->U));
  PetscCall(RodPassesWalls(rod, 0, 0, self->now->U, self->now->U, &passes));
  UserCheck(!passes, self->scene->comm,
            "-wall_file: the rod starts in a wall, between two of its nodes: move the wall");
  PetscFunctionReturn(0);
}

/* Names what the rod is to be inside of and what does not hold its clamp. */
static PetscErrorCode NameBeside(Grow *self) {
  const Walls *walls = &self->scene->contact.walls;
  const Surfaces *surfaces = &self->scene->contact.surfaces;
  const PetscReal clamp[3] = {0, 0, 0};

  PetscFunctionBegin;
  if (self->quiet) PetscFunctionReturn(0);
  for (PetscInt w = 0; w < walls->n; w++)
    if (!WallsHold(walls, w, clamp))
      PetscCall(
          PetscPrintf(self->scene->comm,
                      "-wall_file: wall %d, a path, does not hold the clamp: the rod is out of "
                      "it, unless it comes in through a mouth\n",
                      (int)w + 1));
  if (self->scene->clamp == CLAMP_FREE) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < surfaces->n; k++)
    if (!SurfaceHolds(&surfaces->surface[k], clamp))
      PetscCall(
          PetscPrintf(self->scene->comm,
                      "-wall_file, line %d: the %s does not hold the clamp: the rod is out of "
                      "it, unless it comes in through an open end\n",
                      surfaces->surface[k].line, surfaces->surface[k].kind->name));
  PetscFunctionReturn(0);
}

/* The state of a fresh run: the scene's initial shape. */
static PetscErrorCode Begin(Grow *self, const char *output) {
  Event event;

  PetscFunctionBegin;
  self->now = OwnLeg(self);
  PetscCall(CheckStart(self));
  if (self->scene->contact.walls.n || self->scene->contact.surfaces.n) PetscCall(CheckWalls(self));
  PetscCall(NameBeside(self));
  PetscCall(GrowLookForEvent(self, 0, NULL, &event));
  UserCheck(!event.kind, self->scene->comm, "-stop_%s: it is so at the start already",
            event_name[event.kind]);
  PetscCall(OutputCreate(output, self->scene, &self->output)); /* after all refusals */
  if (GrowFollowsErrors(self)) PetscCall(OutputFollows(self->output));
  if (self->member) PetscCall(OutputKeep(self->output, self->member->series, self->member->shapes));
  if (self->by_steps) PetscCall(OutputKeep(self->output, PETSC_TRUE, PETSC_TRUE));
  PetscCall(Observe(self, 0, NULL, NULL));
  self->now = &self->leg[BetterModel(self)];
  PetscCall(RodBegin(self->now->rod, self->now->U));
  PetscCall(GrowStoreShape(self, 0, NULL));
  if (!self->member) PetscCall(Store(self, PETSC_FALSE)); /* what cannot be written shows early */
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
  PetscCall(ObserverSetBalance(self->observer, state->balance));
  PetscCall(RestartTakeErrors(restart, state, self->estimate));
  GrowTakeErrors(self, state->beside);
  GrowTakeStuck(self, state->stuck);
  if (state->falls > 0) SceneAtSpeed(self->scene, state->falls);
  PetscCall(PetscArraycpy(self->counted, state->counted, 2));
  self->folds = state->folds;
  self->seen = state->seen;
  self->began = state->began;
  self->neglected = state->neglected;
  self->shared = state->shared; /* it has been said */
  self->changed = (PetscBool)(state->points == 1 &&
                              state->step <= 2 * grow_begins_again * self->scene->end_time);
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
  PetscCall(Store(self, PETSC_FALSE));
  if (!self->quiet)
    PetscCall(PetscPrintf(self->scene->comm, "goes on from t = %s of %s, into %s\n",
                          OptionBoth(state->t, UNIT_TIME, text), restart,
                          output[0] ? output : restart));
  self->next_output = self->output_interval;
  while (self->next_output <= state->t * (1 + 1e-12)) self->next_output += self->output_interval;
  PetscFunctionReturn(0);
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
        (self->model == AUTO && (m == LINEAR || m == WholeModel(self)) && self->can[m]))
      PetscCall(AddLeg(self, m));
  PetscCall(CrawlAllowed(OwnLeg(self)->ts, &self->crawl));
  PetscCall(RodHoldTip(OwnLeg(self)->rod));
  if (begun) PetscCall(RestartChange(restart, self->scene));
  for (PetscInt m = 0; m < MODELS && begun; m++)
    if (self->leg[m].ts) PetscCall(LegEndAtTurns(&self->leg[m]));
  if (self->leg[WholeModel(self)].rod)
    PetscCall(EstimateCreate(&self->leg[WholeModel(self)], &self->estimate));
  PetscCall(GrowSensitivitiesCreate(self, output, restart));
  PetscCall(OptionsRefuseUnread());
  PetscCall(SceneChangesCheck(self->scene));
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

/* One step of a TS that solves already, as TSSolve() takes it: that would limit it once more. */
static PetscErrorCode StepOn(TS ts) {
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
   with a viscous share, or a larger one, in steps of grow_begins_again of the run on. */
static PetscErrorCode AfterSolve(Grow *self) {
  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(self->now->ts, &self->reason));
  self->enters = PETSC_FALSE;
  if (self->reason < 0 && !self->stopped && LoadMaySlip(&self->scene->load) &&
      LoadShareMore(&self->scene->load)) {
    PetscCall(TSRestartStep(self->now->ts));
    PetscCall(TSSetTimeStep(self->now->ts, grow_begins_again * self->scene->end_time));
    self->enters = PETSC_TRUE;
  } else if (self->reason != TS_CONVERGED_USER || self->stopped || self->beyond || self->jammed ||
             self->slips || self->crawls || self->event.kind)
    self->over = PETSC_TRUE;
  else if (self->now != &self->leg[BetterModel(self)]) {
    PetscCall(HandOver(self, &self->leg[BetterModel(self)]));
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
    PetscCall(AfterStep(ts));
  } else if (self->enters)
    PetscCall(TSSolve(ts, self->now->U));
  else
    PetscCall(StepOn(ts));
  if (!self->waits) PetscCall(AfterSolve(self));
  PetscFunctionReturn(0);
}

/* GrowSettle - a run by steps goes on from a time within the step that waits, as if that had ended
   there: with what the dense output has. Collective. */
PetscErrorCode GrowSettle(Grow *self, PetscReal t) {
  TS ts = self->now->ts;
  Vec V[2];
  PetscReal end;

  PetscFunctionBegin;
  if (!self->waits) PetscFunctionReturn(0);
  self->waits = PETSC_FALSE;
  PetscCall(TSGetTime(ts, &end));
  for (int k = 0; k < 2; k++) PetscCall(VecDuplicate(self->now->U, &V[k]));
  PetscCall(LegInterpolate(self->now, t, end, end - self->seen.t, V[0], V[1]));
  PetscCall(Observe(self, t, V[0], V[1]));
  PetscCall(StoreDueShapes(self, t, V[0]));
  PetscCall(VecCopy(V[0], self->now->U));
  PetscCall(TSSetTime(ts, t));
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&V[k]));
  PetscFunctionReturn(0);
}

/* GrowChange - the scene has changed at the present time. Where that acts on the rod, and is not
   its end alone, steps begin anew there, short, and in the model that leaves nothing out.
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
  self->changed = PETSC_TRUE;
  self->can[LINEAR] = (PetscBool)(self->can[LINEAR] && self->model == LINEAR);
  if (self->now != &self->leg[BetterModel(self)]) {
    PetscCall(HandOver(self, &self->leg[BetterModel(self)]));
    self->enters = PETSC_TRUE;
  }
  PetscCall(TSRestartStep(self->now->ts));
  PetscCall(TSSetTimeStep(self->now->ts, grow_begins_again * self->scene->end_time));
  PetscFunctionReturn(0);
}

static PetscErrorCode SumUp(Grow *self) {
  PetscFunctionBegin;
  PetscCall(GrowErrors(self));
  PetscCall(GrowSummary(self));
  PetscFunctionReturn(0);
}

/* Stores the last state, whatever the end. */
static PetscErrorCode End(Grow *self, PetscBool finished) {
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
  PetscCall(Store(self, finished));
  PetscFunctionReturn(0);
}

/* Does a rod in space turn about itself far faster than anything drives it? Where friction does not
 * feel the spin nothing says how it gives way. */
static PetscBool SpinsFreely(const Grow *self) {
  const Scene scene = self->scene;
  const PetscReal driven = PetscAbsReal(scene->space.spin) + 1 / self->seen.length, far = 1e4;

  return (PetscBool)(scene->space.rod && scene->load.radius == 0 &&
                     PetscAbsReal(self->seen.tip_spin) > far * driven);
}

/* Is a rod that touches still straight, and does nothing say to which side it bends? (A load or a
   natural bend across would.) */
static PetscBool PressedStraight(const Grow *self) {
  const PetscReal straight = 0.01;
  const Scene scene = self->scene;
  const PetscReal *weight = scene->load.weight, *push = scene->tip.push;
  const PetscBool loaded =
      (PetscBool)(weight[1] != 0 || weight[2] != 0 || push[1] != 0 || push[2] != 0);

  return (PetscBool)(self->seen.contacts > 0 && self->seen.max_angle <= straight && !loaded &&
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

/* A rod that is held so that it cannot give way at large bends in waves of 2 pi sqrt(B/P) under the
   force P: cells that are long beside these chatter. Tells how many would do; nothing if there are.
 */
static void AdviseWaves(const Grow *self, char *advice, size_t room) {
  const PetscReal coarse = 6, fine = 12, B = self->scene->stiffness.most,
                  P = PetscMax(self->force_before, BaseForce(&self->seen)),
                  length = self->seen.length, cell = length / self->scene->mesh.cells;
  char text[3][64];
  PetscReal wave;

  advice[0] = 0;
  if (!TipHolds(&self->scene->tip, 1) || !(P > 0)) return;
  wave = 2 * PETSC_PI * PetscSqrtReal(B / P);
  if (wave < coarse * cell)
    (void)snprintf(advice, room,
                   "its cells of %s are too long for the waves in which it bends under the force "
                   "%s, of %s: give -rod_cells %.0f",
                   About(cell, UNIT_LENGTH, text[0]), About(P, UNIT_FORCE, text[1]),
                   About(wave, UNIT_LENGTH, text[2]), (double)PetscCeilReal(fine * length / wave));
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
  const PetscReal clamp[3] = {0, 0, 0},
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

/* The line for an end that was not asked for. */
static PetscErrorCode Verdict(Grow *self) {
  const TSConvergedReason reason = self->reason;
  MPI_Comm comm = self->scene->comm;
  const char *const kept = OutputStores(self->output) ? "the results up to there are stored"
                           : self->by_steps ? "what was found up to there can be read and saved"
                                            : "nothing is stored without -output FILE";
  char text[3][64], jam[512] = "", crawl[768] = "", advice[512];
  PetscBool waves, passes;
  PetscReal dt;

  PetscFunctionBegin;
  PetscCall(TSGetTimeStep(self->now->ts, &dt));
  OptionBoth(self->seen.t, UNIT_TIME, text[0]);
  OptionBoth(dt, UNIT_TIME, text[1]);
  OptionBoth(self->scene->end_time, UNIT_TIME, text[2]);
  if (self->event.kind) PetscFunctionReturn(0);
  UserCheck(!self->stopped, comm, "interrupted by signal %d at t = %s; %s", self->stopped, text[0],
            kept);
  UserCheck(!self->beyond, comm,
            "-rod_model linear: stopped at t = %s, where an angle reached 1: a straight rod's "
            "model says nothing there; take -rod_model auto",
            text[0]);
  advice[0] = 0;
  if (reason == TS_CONVERGED_TIME && self->scene->falls > 0)
    AdviseFall(self, advice, sizeof(advice));
  UserCheck(!advice[0], comm, "at t = %s the rod is still falling: %s", text[0], advice);
  UserCheck(reason != TS_CONVERGED_ITS, comm,
            "-ts_max_steps: reached at t = %s before -ts_max_time %s", text[0], text[2]);
  UserCheck(
      self->jammed || reason == TS_CONVERGED_TIME || !PressedStraight(self), comm,
      "gave up at t = %s: the rod is pressed straight against a wall, and nothing says to which "
      "side it gives way; %s; give it a small -rod_curvature",
      text[0], kept);
  UserCheck(
      !self->slips && !(reason < 0 && self->scene->load.shared && self->scene->load.across < 1),
      comm,
      "gave up at t = %s: with -friction_across %g dry friction does not say how fast so bent a "
      "rod moves, and it slips and sticks in no time, again and again; %s; take a larger "
      "-friction_across, or a lower -friction_mu: 0.99, or less",
      text[0], (double)self->scene->load.across, kept);
  CrawlTell(&self->crawl, self->scene->load.friction.beta, HeldTwice(self), crawl, sizeof(crawl));
  AdviseWaves(self, advice, sizeof(advice));
  waves = (PetscBool)(advice[0] != 0);
  UserCheck(!self->crawls, comm, "%s; %s%s%s", crawl, kept, waves ? "; " : "", advice);
  PetscCall(GrowTellJam(self, (PetscBool)(reason < 0), jam, sizeof(jam)));
  UserCheck(!jam[0], comm,
            "%s, and it can hardly grow on; %s; end the run before with -stop_force, or, if this "
            "push is meant, give a higher -contact_stiffness",
            jam, kept);
  if (!waves) AdviseConduit(self, advice, sizeof(advice));
  passes = (PetscBool)(self->now->passes ||
                       (self->now->passed && !advice[0] && !CoarseForContact(self)));
  UserCheck(reason == TS_CONVERGED_TIME || !passes, comm,
            "gave up at t = %s with a step of %s: the rod would pass through itself or a wall; %s; "
            "give more -rod_cells or a higher -contact_stiffness",
            text[0], text[1], kept);
  UserCheck(
      reason == TS_CONVERGED_TIME || !SpinsFreely(self), comm,
      "gave up at t = %s: the rod turns over about its own axis at once, for nothing holds its "
      "spin back, and where it then goes is not determined; %s; give the radius at which "
      "friction feels the spin, -friction_radius",
      text[0], kept);
  if (!advice[0]) AdviseGivingWay(self, advice, sizeof(advice));
  UserCheck(
      reason == TS_CONVERGED_TIME || !self->now->crosses, comm,
      "gave up at t = %s: the rod gives way faster than a step of %s can follow, to which side "
      "that step does not tell; %s; %s",
      text[0], text[1], kept, advice);
  if (!waves) {
    advice[0] = 0;
    AdviseFall(self, advice, sizeof(advice));
    AdviseConduit(self, advice, sizeof(advice));
  }
  UserCheck(reason == TS_CONVERGED_TIME, comm, "gave up at t = %s with a step of %s (%s): %s; %s",
            text[0], text[1], TSConvergedReasons[reason], kept,
            advice[0]         ? advice
            : HeldTwice(self) ? crawl_held
                              : "try another -ts_rtol, more -rod_cells or a larger -friction_beta");
  PetscFunctionReturn(0);
}

/* Has firm contact led it nowhere, so that it is to begin anew with soft contact? Not if it gave up
   under great force: it is jammed, as it would be in soft contact a little later. Nor can a run
   that goes on from where another one ended. */
static PetscBool FindsNoWay(const Grow *self) {
  return (PetscBool)(!self->stopped && self->start == 0 && GotFirm(&self->scene->contact) &&
                     !(self->scene->changes && self->scene->changes->done) &&
                     (self->crawls || (self->reason < 0 && !GrowPressedHard(self))));
}

/*
  GrowFinish - what a run leaves that is over, and the line for an end that was not asked for.
  Collective.

  anew  it was in vain, and is to be run once more, with soft contact: see GrowAnew()
*/
PetscErrorCode GrowFinish(Grow *self, PetscBool *anew) {
  PetscErrorCode error = (PetscErrorCode)0;
  char text[64];

  PetscFunctionBegin;
  *anew = FindsNoWay(self);
  if (!*anew) error = SumUp(self);
  if (error) (void)End(self, PETSC_FALSE); /* what has been computed is not lost */
  PetscCall(error);
  if (*anew && !self->quiet)
    PetscCall(PetscPrintf(self->scene->comm,
                          "t = %s: no way is found in contact that gets firmer where the rod is "
                          "pressed in: the run begins anew with contact that does not\n",
                          OptionBoth(self->seen.t, UNIT_TIME, text)));
  if (*anew) PetscFunctionReturn(0);
  PetscCall(End(self, (PetscBool)(self->reason == TS_CONVERGED_TIME || self->event.kind)));
  if (self->member) self->member->stopped = (PetscBool)(self->stopped != 0);
  PetscCall(Verdict(self));
  if (self->member)
    PetscCall(
        OutputHarvest(self->output, &self->seen, self->member->values, &self->member->harvest));
  PetscFunctionReturn(0);
}

static PetscErrorCode Run(Grow *self, PetscBool *anew) {
  PetscErrorCode error;

  PetscFunctionBegin;
  if (!self->member) SignalsCatch();
  PetscCall(GrowHeading(self));
  error = Follow(self);
  if (error) (void)End(self, PETSC_FALSE); /* what has been computed is not lost */
  PetscCall(error);
  PetscCall(GrowFinish(self, anew));
  PetscFunctionReturn(0);
}

/* GrowAnew - ends a run, whose scene is then ready to be run once more, with soft contact. */
PetscErrorCode GrowAnew(Grow *self) {
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
  PetscBool anew = PETSC_FALSE;
  PetscErrorCode error;

  PetscFunctionBegin;
  do {
    if (anew) PetscCall(GrowAnew(self));
    anew = PETSC_FALSE;
    error = GrowCreate(self, output, restart);
    if (!error) error = Run(self, &anew);
    if (error) PetscCall(GrowDestroy(self));
    PetscCall(error);
  } while (anew);
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
