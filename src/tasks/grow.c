#include "tasks/grow.h"
#include "tasks/accuracy.h"
#include "record/event.h"
#include "stepping/leg.h"
#include "record/observe.h"
#include "base/options.h"
#include "record/output.h"
#include "record/restart.h"
#include "stepping/snap.h"
#include "stepping/vbdf.h"
#include <petsctime.h>
#include <signal.h>

enum { LINEAR, FRAME, MIXED, AUTO }; /* as -rod_model and the series `model` number them */
static const RodModel *const models[] = {&rod_linear, &rod_frame, &rod_mixed};

typedef struct {
  Scene scene;
  PetscInt model; /* as asked for */
  Leg leg[3];     /* by model; those not in use are empty; auto has two, taking turns */
  Leg *now;
  Observer observer;
  Output output;
  Observation seen; /* of the latest step */
  PetscReal rtol, output_interval, next_output;
  PetscReal stored_at;        /* time of the latest stored shape */
  PetscReal report_at;        /* time of the next progress line */
  PetscInt iterations, steps; /* before the latest step; steps of earlier legs */
  PetscReal folds;            /* of |x2|, up and down, so far */
  PetscReal neglected;        /* largest part that the linear model left out */
  PetscBool quiet, beyond;    /* beyond: the linear model has left its range */
  PetscLogDouble begin, reported;
  Watch watch;
  Event event;            /* that ended the run */
  PetscLogDouble kept_at; /* wall time when the state for a restart was stored */
  PetscReal start;        /* t at which this run began: 0, or a restart's */
} Grow;

static volatile sig_atomic_t interrupted;

static void OnSignal(int number) {
  interrupted = number;
}

static PetscErrorCode Self(TS ts, Grow **self) {
  Leg *leg;

  PetscFunctionBegin;
  *self = NULL;
  PetscCall(TSGetApplicationContext(ts, &leg));
  *self = (Grow *)leg->owner;
  PetscFunctionReturn(0);
}

static PetscErrorCode Progress(Grow *self, PetscBool last) {
  const Observation *seen = &self->seen;
  PetscReal end = self->scene->end_time;
  PetscLogDouble now;
  char rest[32] = "";

  PetscFunctionBegin;
  if (self->quiet) PetscFunctionReturn(0);
  PetscCall(PetscTime(&now));
  if (!last && now - self->reported < 1 && seen->t < self->report_at) PetscFunctionReturn(0);
  self->reported = now;
  self->report_at = seen->t + end / 10;
  if (now - self->begin > 0.5 && seen->t > 0.02 * end && !last)
    PetscCall(PetscSNPrintf(rest, sizeof(rest), "%7.1f s",
                            (double)((now - self->begin) * (end - seen->t) / seen->t)));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%10.4f %10.4f %12.4e %10.2e %7d %8s %s\n",
                        (double)seen->t, (double)seen->length, (double)seen->norm_x2,
                        (double)seen->step, (int)seen->newton_iterations,
                        models[(int)seen->model]->name, rest));
  PetscFunctionReturn(0);
}

/* Stores the shape of a state at time t. U NULL: the initial shape. */
static PetscErrorCode StoreShape(Grow *self, PetscReal t, Vec U) {
  const Node *nodes;

  PetscFunctionBegin;
  PetscCall(ObserverGather(self->observer, self->now->rod, t, U, NULL, &nodes));
  if (nodes) PetscCall(OutputShape(self->output, t, nodes));
  self->stored_at = t;
  PetscFunctionReturn(0);
}

/* Stores the shapes due between the previous step and this one, by the stepper's dense output. */
static PetscErrorCode StoreDueShapes(Grow *self, PetscReal t, Vec U) {
  Vec W;

  PetscFunctionBegin;
  while (self->next_output <= t * (1 + 1e-14)) {
    if (self->next_output >= t * (1 - 1e-12))
      PetscCall(StoreShape(self, t, U));
    else {
      PetscCall(VecDuplicate(self->now->U, &W));
      PetscCall(TSInterpolate(self->now->ts, self->next_output, W));
      PetscCall(StoreShape(self, self->next_output, W));
      PetscCall(VecDestroy(&W));
    }
    self->next_output += self->output_interval;
  }
  PetscFunctionReturn(0);
}

/* auto: the linear model leaves out terms of relative size theta^2. Take it while they are below
   the tolerance of a step, and take it up again only when well below, so that it does not flicker.
 */
static PetscInt BetterModel(const Grow *self) {
  PetscReal neglected = PetscSqr(self->seen.max_angle);
  if (self->model != AUTO) return self->model;
  if (self->scene->curvature.any) return FRAME; /* the linear model knows none */
  if (self->now == &self->leg[LINEAR]) return neglected > 0.3 * self->rtol ? FRAME : LINEAR;
  return neglected < 0.03 * self->rtol ? LINEAR : FRAME;
}

/* The linear model leaves out terms of the square of the angle and, in friction, of the square of
   the speed across the rod: that along it is about 1. */
static PetscErrorCode Neglect(Grow *self, Vec U_t) {
  PetscReal speed[MAX_FIELDS] = {0};

  PetscFunctionBegin;
  if (self->model != LINEAR) PetscFunctionReturn(0);
  if (U_t) PetscCall(RodFieldSizes(self->now->rod, U_t, speed));
  self->neglected = PetscMax(self->neglected, PetscSqr(PetscMax(speed[0], self->seen.max_angle)));
  PetscFunctionReturn(0);
}

static PetscErrorCode Observe(Grow *self, PetscReal t, Vec U, Vec U_t) {
  PetscInt iterations = 0, all = 0, jumps = 0;

  PetscFunctionBegin;
  if (U) {
    PetscCall(TSGetSNESIterations(self->now->ts, &all));
    PetscCall(VBDFGetJumps(self->now->ts, &jumps));
    if (jumps > self->now->jumps) ObserverJump(self->observer);
    self->now->jumps = jumps;
  }
  iterations = all - self->iterations;
  self->iterations = all;
  PetscReal before = self->seen.t, norm = self->seen.norm_x2;
  PetscCall(ObserverMeasure(self->observer, self->now->rod, t, U, U_t, &self->seen));
  if (norm > rod_vanished && self->seen.norm_x2 > rod_vanished)
    self->folds += PetscAbsReal(PetscLogReal(self->seen.norm_x2 / norm));
  PetscCall(Neglect(self, U_t));
  self->seen.step = t - before;
  self->seen.newton_iterations = iterations;
  self->seen.model = self->now - self->leg;
  PetscCall(OutputSeries(self->output, &self->seen));
  PetscFunctionReturn(0);
}

/* Has an event happened in the state U of time t? Collective. */
static PetscErrorCode LookForEvent(Grow *self, PetscReal t, Vec U, Event *event) {
  const Node *nodes;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(event, sizeof(*event)));
  PetscCall(ObserverGather(self->observer, self->now->rod, t, U, NULL, &nodes));
  if (nodes) PetscCall(WatchLook(&self->watch, self->scene, t, nodes, event));
  PetscCallMPI(MPI_Bcast(event, sizeof(*event), MPI_BYTE, 0, PETSC_COMM_WORLD));
  PetscFunctionReturn(0);
}

/* U_t at time t by the slopes of the stepper's dense output, a polynomial of degree 7 at most:
   seven times over the step h have it exactly but for the last degree. */
static PetscErrorCode InterpolateRate(TS ts, PetscReal t, PetscReal end, PetscReal h, Vec U,
                                      Vec U_t) {
  PetscReal at[7] = {t};

  PetscFunctionBegin;
  for (int k = 1; k < 7; k++) { /* none is nearer to t than a fourteenth of the step */
    at[k] = end - h * (k - 0.5) / 6;
    if (PetscAbsReal(at[k] - t) < h / 14) at[k] -= h / 12;
  }
  PetscCall(VecZeroEntries(U_t));
  for (int k = 0; k < 7; k++) {
    PetscReal slope = 0;
    for (int i = 0; i < 7; i++) { /* l_k'(t) */
      PetscReal product = 1;
      if (i == k) continue;
      for (int j = 0; j < 7; j++)
        if (j != k && j != i) product *= (t - at[j]) / (at[k] - at[j]);
      slope += product / (at[k] - at[i]);
    }
    PetscCall(TSInterpolate(ts, at[k], U));
    PetscCall(VecAXPY(U_t, slope, U));
  }
  PetscFunctionReturn(0);
}

/* If an event has happened in the step to t: finds it by bisection on the dense output; t, U and
   U_t are then those of the event. */
static PetscErrorCode LocateEvent(Grow *self, PetscReal *t, Vec U, Vec U_t) {
  TS ts = self->now->ts;
  PetscReal before = self->seen.t, low = before, end = *t;
  Event event;

  PetscFunctionBegin;
  PetscCall(LookForEvent(self, *t, self->now->U, &event));
  if (event.kind == EVENT_NONE) PetscFunctionReturn(0);
  self->event = event;
  for (int k = 0; k < 60 && self->event.t - low > 4 * PETSC_MACHINE_EPSILON * end; k++) {
    PetscReal mid = (low + self->event.t) / 2;
    PetscCall(TSInterpolate(ts, mid, U));
    PetscCall(LookForEvent(self, mid, U, &event));
    if (event.kind)
      self->event = event;
    else
      low = mid;
  }
  *t = self->event.t;
  PetscCall(InterpolateRate(ts, *t, end, end - before, U, U_t));
  PetscCall(TSInterpolate(ts, *t, U));
  PetscFunctionReturn(0);
}

/* All of a vector on rank 0, in the order of nodes and fields, at to. */
static PetscErrorCode Collect(Vec v, PetscReal *to) {
  VecScatter scatter;
  const PetscScalar *a;
  PetscInt n;
  Vec all;

  PetscFunctionBegin;
  PetscCall(VecScatterCreateToZero(v, &scatter, &all));
  PetscCall(VecScatterBegin(scatter, v, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(scatter, v, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetLocalSize(all, &n));
  PetscCall(VecGetArrayRead(all, &a));
  PetscCall(PetscArraycpy(to, a, n));
  PetscCall(VecRestoreArrayRead(all, &a));
  PetscCall(VecScatterDestroy(&scatter));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(0);
}

/* Stores what a restart needs, after an accepted step. Every second is enough: a restart takes off
   the file what came later. */
static PetscErrorCode StoreRestart(Grow *self, PetscBool always) {
  RestartState state = {.t = self->seen.t, .model = self->now - self->leg};
  PetscInt n, order, steps, size = 0, length;
  Vec old[VBDF_POINTS];
  PetscReal *points;
  PetscLogDouble now;
  int due;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  due = always || now - self->kept_at > 1;
  PetscCallMPI(MPI_Bcast(&due, 1, MPI_INT, 0, PETSC_COMM_WORLD));
  if (!due || self->seen.t == 0) PetscFunctionReturn(0);
  self->kept_at = now;
  for (int m = 0; m < 3; m++) /* the file has room for any model of this run */
    if (self->leg[m].rod) {
      PetscCall(VecGetSize(self->leg[m].U, &length));
      size = PetscMax(size, length * (VBDF_POINTS - 1));
    }
  PetscCall(PetscCalloc1(size, &points));
  PetscCall(VBDFGetHistory(self->now->ts, &n, state.time, old, &order));
  if (!n) { /* another stepper starts afresh from the last point */
    n = order = 1;
    old[0] = self->now->U;
  }
  if (self->event.kind) old[0] = self->now->U; /* the step was cut there */
  state.time[0] = self->seen.t;
  PetscCall(VecGetSize(self->now->U, &length));
  for (PetscInt i = 0; i < n; i++) PetscCall(Collect(old[i], points + i * length));
  PetscCall(TSGetTimeStep(self->now->ts, &state.step));
  PetscCall(TSGetStepNumber(self->now->ts, &steps));
  state.points = n;
  state.order = order;
  state.steps = steps;
  state.fields = self->now->rod->model->fields;
  state.folds = self->folds;
  state.neglected = self->neglected;
  state.reference_length = self->scene->curvature.reference_length;
  PetscCall(ObserverGetBalance(self->observer, state.balance));
  PetscCall(OutputRestart(self->output, &state, size, points));
  PetscCall(PetscFree(points));
  PetscFunctionReturn(0);
}

static PetscErrorCode AfterStep(TS ts) {
  Grow *self;
  TSConvergedReason reason;
  PetscReal t, stored;
  Vec U, U_t, here[2] = {NULL, NULL};
  int stop = interrupted;

  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (reason < 0) PetscFunctionReturn(0); /* called after a step that failed, too */
  PetscCall(Self(ts, &self));
  PetscCall(TSGetTime(ts, &t));
  U = self->now->U;
  U_t = self->now->rod->latest_rate;
  if (self->watch.any) {
    for (int k = 0; k < 2; k++) PetscCall(VecDuplicate(U, &here[k]));
    PetscCall(LocateEvent(self, &t, here[0], here[1]));
    if (self->event.kind) U = here[0], U_t = here[1];
  }
  PetscCall(Observe(self, t, U, U_t));
  stored = self->stored_at;
  PetscCall(StoreDueShapes(self, t, U));
  if (self->event.kind) { /* the run ends there */
    PetscCall(VecCopy(U, self->now->U));
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  }
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&here[k]));
  if (self->stored_at != stored) PetscCall(StoreRestart(self, PETSC_FALSE));
  PetscCall(Progress(self, PETSC_FALSE));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &stop, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD));
  self->beyond = (PetscBool)(self->model == LINEAR && self->seen.max_angle > 1);
  if (self->beyond) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  if (stop) {
    interrupted = stop;
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  }
  if (&self->leg[BetterModel(self)] != self->now && t < self->scene->end_time)
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  PetscFunctionReturn(0);
}

static PetscErrorCode AddLeg(Grow *self, PetscInt model) {
  Leg *leg = &self->leg[model];

  PetscFunctionBegin;
  PetscCall(LegCreate(self->scene, models[model], self->rtol, NULL, leg));
  leg->owner = self;
  PetscCall(TSSetMaxTime(leg->ts, self->scene->end_time));
  PetscCall(TSSetPostStep(leg->ts, AfterStep));
  if (model != LINEAR) PetscCall(VBDFSetSnap(leg->ts, SnapFollow));
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
  char text[32];
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
    PetscCall(Convert(from, to, times[i], old[i], new[i]));
  }
  PetscCall(VBDFSetHistory(to->ts, n, times, new, order));
  for (PetscInt i = 0; i < n; i++) PetscCall(VecDestroy(&new[i]));
  PetscCall(TSGetSNESIterations(to->ts, &self->iterations));
  self->now = to;
  if (!self->quiet)
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "t = %s: from the %s to the %s model\n",
                          OptionNumber(t, text), from->rod->model->name, to->rod->model->name));
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadOptions(Grow *self) {
  const char *const names[] = {"linear", "frame", "mixed", "auto"};
  PetscBool set;

  PetscFunctionBegin;
  self->model = FRAME;
  self->rtol = 1e-6;
  self->output_interval = self->scene->end_time;
  PetscCall(OptionsHeading("Run"));
  PetscCall(OptionList("-rod_model",
                       "which unknowns; auto: linear while accurate enough, else frame", 4, names,
                       &self->model, NULL));
  PetscCall(OptionReal("-ts_rtol",
                       "tolerance of a step, per field, against the field's present size", 1e-13,
                       0.5, &self->rtol, NULL));
  PetscCall(OptionReal("-output_interval",
                       "time between stored shapes; if not given, the first and last are stored",
                       1e-9, 1e9, &self->output_interval, &set));
  PetscCall(WatchSetFromOptions(&self->watch, self->scene->growth));
  PetscCall(OptionBool("-quiet", "print nothing but errors", &self->quiet, NULL));
  UserCheck(!self->scene->curvature.any || self->model != LINEAR, PETSC_COMM_WORLD,
            "-rod_curvature: the linear model is of a rod that is straight by nature; take "
            "-rod_model frame or auto");
  UserCheck(self->scene->friction.beta > 0 || self->model != MIXED, PETSC_COMM_WORLD,
            "-friction_beta 0: exact Coulomb friction needs -rod_model frame or auto, or give a "
            "value above 0");
  PetscFunctionReturn(0);
}

/* The state of a fresh run: the scene's initial shape. */
static PetscErrorCode Begin(Grow *self, const char *output) {
  Node *nodes;
  Event event;

  PetscFunctionBegin;
  self->now = &self->leg[self->model == AUTO ? FRAME : self->model];
  PetscCall(LookForEvent(self, 0, NULL, &event));
  UserCheck(!event.kind, PETSC_COMM_WORLD, "-stop_%s: it is so at the start already",
            event_name[event.kind]);
  PetscCall(OutputCreate(output, self->scene, &self->output)); /* after all refusals */
  PetscCall(Observe(self, 0, NULL, NULL));
  self->now = &self->leg[BetterModel(self)];
  PetscCall(PetscMalloc1(self->now->rod->end - self->now->rod->first, &nodes));
  PetscCall(RodInitialNodes(self->now->rod, 0, nodes));
  PetscCall(self->now->rod->model->set(self->now->rod, 0, nodes, self->now->U));
  PetscCall(PetscFree(nodes));
  PetscCall(StoreShape(self, 0, NULL));
  self->next_output = self->output_interval;
  PetscFunctionReturn(0);
}

/* The state of an earlier run, with the history of its stepper. */
static PetscErrorCode TakeUp(Grow *self, const RestartState *state, const PetscReal *points) {
  Leg *leg = self->now = &self->leg[(int)state->model];
  PetscInt low, high, length;
  PetscScalar *a;
  Vec old[VBDF_POINTS];
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(VecGetOwnershipRange(leg->U, &low, &high));
  PetscCall(VecGetSize(leg->U, &length));
  for (PetscInt i = 0; i < (PetscInt)state->points; i++) {
    PetscCall(VecDuplicate(leg->U, &old[i]));
    PetscCall(VecGetArray(old[i], &a));
    PetscCall(PetscArraycpy(a, points + i * length + low, high - low));
    PetscCall(VecRestoreArray(old[i], &a));
  }
  PetscCall(VecCopy(old[0], leg->U));
  PetscCall(
      VBDFSetHistory(leg->ts, (PetscInt)state->points, state->time, old, (PetscInt)state->order));
  for (PetscInt i = 0; i < (PetscInt)state->points; i++) PetscCall(VecDestroy(&old[i]));
  PetscCall(TSSetTime(leg->ts, state->t));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-ts_dt", &given));
  if (!given) PetscCall(TSSetTimeStep(leg->ts, state->step));
  PetscCall(TSSetStepNumber(leg->ts, (PetscInt)state->steps));
  PetscCall(ObserverSetBalance(self->observer, state->balance));
  self->folds = state->folds;
  self->neglected = state->neglected;
  PetscFunctionReturn(0);
}

static PetscErrorCode GoOn(Grow *self, const char *restart, const RestartState *state,
                           const PetscReal *points, const char *output) {
  Event event;
  char text[32];

  PetscFunctionBegin;
  PetscCall(TakeUp(self, state, points));
  self->seen.t = self->start = self->stored_at = state->t;
  PetscCall(LookForEvent(self, state->t, self->now->U, &event));
  UserCheck(!event.kind, PETSC_COMM_WORLD,
            "-stop_%s: it is so at t = %g already, where -restart %s is", event_name[event.kind],
            (double)state->t, restart);
  PetscCall(
      OutputContinue(output, restart, self->scene, state->t, self->output_interval, &self->output));
  if (!self->quiet)
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "goes on from t = %s of %s, into %s\n",
                          OptionNumber(state->t, text), restart, output[0] ? output : restart));
  self->next_output = self->output_interval;
  while (self->next_output <= state->t * (1 + 1e-12)) self->next_output += self->output_interval;
  PetscFunctionReturn(0);
}

static PetscErrorCode GrowCreate(Grow *self, const char *output, const char *restart) {
  RestartState state;
  PetscReal *points = NULL;

  PetscFunctionBegin;
  PetscCall(ReadOptions(self));
  if (restart[0]) PetscCall(RestartRead(restart, self->scene, &state, &points));
  for (PetscInt m = 0; m < 3; m++)
    if (m == self->model || (self->model == AUTO && m != MIXED)) PetscCall(AddLeg(self, m));
  PetscCall(OptionsRefuseUnread());
  PetscCall(ObserverCreate(self->scene, &self->observer));
  if (!restart[0]) {
    PetscCall(Begin(self, output));
    PetscFunctionReturn(0);
  }
  UserCheck(state.model >= 0 && state.model <= MIXED && self->leg[(int)state.model].rod &&
                self->leg[(int)state.model].rod->model->fields == state.fields,
            PETSC_COMM_WORLD, "-rod_model: the run in -restart %s was of another model", restart);
  PetscCall(GoOn(self, restart, &state, points, output));
  PetscCall(PetscFree(points));
  PetscFunctionReturn(0);
}

/* The last words on a run: how far off it may be. Other steppers than vbdf are not calibrated. */
static PetscErrorCode Errors(Grow *self, PetscInt jumps) {
  Rod rod = self->now->rod;
  PetscReal error = 0, asked = PETSC_MAX_REAL, defect = self->seen.energy_defect;
  PetscBool vbdf;

  PetscFunctionBegin;
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "energy defect %.1e", (double)defect));
  PetscCall(PetscObjectTypeCompare((PetscObject)self->now->ts, TSVBDF, &vbdf));
  if (vbdf) {
    PetscCall(AccuracyEstimate(rod, self->seen.t, self->rtol, self->folds, &error));
    error += self->neglected;
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, ", error estimate %.1e", (double)error));
    PetscCall(PetscOptionsGetReal(NULL, NULL, "-accuracy", &asked, NULL));
  }
  if (jumps)
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "; %d snap%s", (int)jumps, jumps > 1 ? "s" : ""));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "\n"));
  if (error > 3 * asked) /* it is an upper one */
    PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                          "-accuracy %g is not met with the -rod_cells or -ts_rtol given.\n",
                          (double)asked));
  if (defect > 1e-3)
    PetscCall(PetscPrintf(
        PETSC_COMM_WORLD,
        "The energy balance is off by more than 1e-3: lower -ts_rtol or raise -rod_cells.\n"));
  PetscFunctionReturn(0);
}

static PetscErrorCode Summary(Grow *self) {
  const Observation *seen = &self->seen;
  PetscInt steps, iterations = 0, rejections = 0, jumps = 0, n;
  char text[4][32];
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(TSGetStepNumber(self->now->ts, &steps));
  for (int m = 0; m < 3; m++)
    if (self->leg[m].ts) {
      PetscCall(TSGetSNESIterations(self->leg[m].ts, &n));
      iterations += n;
      PetscCall(TSGetStepRejections(self->leg[m].ts, &n));
      rejections += n;
      PetscCall(VBDFGetJumps(self->leg[m].ts, &n));
      jumps += n;
    }
  PetscCall(PetscTime(&now));
  if (self->quiet) PetscFunctionReturn(0);
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "t = %s: length %s, tip (%s, %s), |x2| %.8e\n",
                        OptionNumber(seen->t, text[0]), OptionNumber(seen->length, text[1]),
                        OptionNumber(seen->tip_x1, text[2]), OptionNumber(seen->tip_x2, text[3]),
                        (double)seen->norm_x2));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%d steps, %d rejected, %d Newton iterations, %.3f s; ",
                        (int)steps, (int)rejections, (int)iterations, now - self->begin));
  PetscCall(Errors(self, jumps));
  PetscFunctionReturn(0);
}

static PetscErrorCode TellEvent(Grow *self) {
  const Event *event = &self->event;
  char text[4][32];

  PetscFunctionBegin;
  if (self->quiet) PetscFunctionReturn(0);
  OptionNumber(event->t, text[0]);
  OptionNumber(event->s[0], text[1]);
  OptionNumber(event->s[1], text[2]);
  OptionNumber(self->watch.bound[event->kind], text[3]);
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "stopped at t = %s: ", text[0]));
  if (event->kind == EVENT_LENGTH)
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "length %s\n", text[3]));
  else if (event->kind == EVENT_ANGLE)
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "an angle of %s at s = %s\n", text[3], text[1]));
  else
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "touches itself at s = %s and %s\n", text[1], text[2]));
  PetscFunctionReturn(0);
}

/* Stores the last state and closes the file, whatever the end. */
static PetscErrorCode GrowDestroy(Grow *self, PetscBool finished) {
  PetscFunctionBegin;
  if (self->seen.t != self->stored_at) PetscCall(StoreShape(self, self->seen.t, self->now->U));
  if (self->seen.t > self->start) PetscCall(StoreRestart(self, PETSC_TRUE));
  if (self->event.kind) PetscCall(OutputEvent(self->output, &self->event));
  PetscCall(OutputDestroy(&self->output, finished));
  PetscCall(ObserverDestroy(&self->observer));
  for (int m = 0; m < 3; m++) PetscCall(LegDestroy(&self->leg[m]));
  PetscFunctionReturn(0);
}

/*
  GrowRun - follows the rod of a scene from t = 0 to its end time. Collective.

  output   the result file; empty: none
  restart  the result file of a run to go on with; empty: none

  Ends with a user's error, the last state stored, if the stepper gives up or the run is
  interrupted.
*/
PetscErrorCode GrowRun(Scene scene, const char *output, const char *restart) {
  Grow grow = {.scene = scene, .kept_at = -2}, *self = &grow;
  TSConvergedReason reason = TS_CONVERGED_ITERATING;
  PetscReal t = 0, dt = 0;
  char text[3][32];

  PetscFunctionBegin;
  PetscCall(GrowCreate(self, output, restart));
  signal(SIGTERM, OnSignal);
  signal(SIGINT, OnSignal);
  PetscCall(PetscTime(&self->begin));
  self->reported = self->begin;
  if (!self->quiet)
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%10s %10s %12s %10s %7s %8s %9s\n", "t", "length",
                          "|x2|", "step", "Newton", "model", "rest"));
  while (!interrupted) {
    PetscCall(TSSolve(self->now->ts, self->now->U));
    PetscCall(TSGetConvergedReason(self->now->ts, &reason));
    if (reason != TS_CONVERGED_USER || interrupted || self->beyond || self->event.kind) break;
    PetscCall(HandOver(self, &self->leg[BetterModel(self)]));
  }
  PetscCall(TSGetTime(self->now->ts, &t));
  PetscCall(TSGetTimeStep(self->now->ts, &dt));
  PetscCall(Progress(self, PETSC_TRUE));
  PetscCall(Summary(self));
  if (self->event.kind) PetscCall(TellEvent(self));
  PetscCall(GrowDestroy(self, (PetscBool)(reason == TS_CONVERGED_TIME || self->event.kind)));
  OptionNumber(t, text[0]);
  OptionNumber(dt, text[1]);
  OptionNumber(scene->end_time, text[2]);
  if (self->event.kind) PetscFunctionReturn(0);
  UserCheck(!interrupted, PETSC_COMM_WORLD,
            "interrupted by signal %d at t = %s; the results up to there are stored",
            (int)interrupted, text[0]);
  UserCheck(!grow.beyond, PETSC_COMM_WORLD,
            "-rod_model linear: stopped at t = %s, where an angle reached 1: a straight rod's "
            "model says nothing there; take -rod_model auto",
            text[0]);
  UserCheck(reason != TS_CONVERGED_ITS, PETSC_COMM_WORLD,
            "-ts_max_steps: reached at t = %s before -ts_max_time %s", text[0], text[2]);
  UserCheck(reason == TS_CONVERGED_TIME, PETSC_COMM_WORLD,
            "gave up at t = %s with a step of %s (%s): the results up to there are stored; try a "
            "lower -ts_rtol, more "
            "-rod_cells or a larger -friction_beta",
            text[0], text[1], TSConvergedReasons[reason]);
  PetscFunctionReturn(0);
}
