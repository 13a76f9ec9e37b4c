#include "stepping/controller.h"
#include "base/compat.h"
#include "base/extremes.h"
#include "stepping/rules.h"
#include <petsc/private/tsimpl.h> /* it takes the place of a TS type's own */

/* What short steps are part of. */
static PetscReal Scale(TS ts, const Controller *self) {
  return self->scale > 0 ? self->scale : ts->max_time;
}

static PetscErrorCode Predict(TS ts, Controller *self, Formula *f, Vec X) {
  PetscFunctionBegin;
  if (f->n > 1)
    PetscCall(FormulaExtrapolate(f, PetscMin(self->order + 1, f->n), X));
  else if (self->guess)
    PetscCall(self->guess(ts, ts->ptime, f->now, f->point[1], X, self->guess_ctx));
  else
    PetscCall(VecCopy(f->point[1], X));
  PetscFunctionReturn(0);
}

static PetscErrorCode SolveStage(TS ts, Controller *self, Formula *f) {
  PetscInt its, linear;

  PetscFunctionBegin;
  PetscCall(FormulaBegin(f, self->order));
  PetscCall(TSPreStage(ts, f->now));
  PetscCall(SNESSolve(ts->snes, NULL, f->point[0]));
  PetscCall(SNESGetIterationNumber(ts->snes, &its));
  PetscCall(SNESGetLinearSolveIterations(ts->snes, &linear));
  ts->snes_its += its;
  ts->ksp_its += linear;
  PetscFunctionReturn(0);
}

/* Is any tolerance minute? It is looked for when they have changed. Collective. */
static PetscErrorCode MayBeBeyond(TS ts, Controller *self, PetscBool *may) {
  PetscObjectState state;
  const PetscScalar *tolerance;
  int small = 0;
  PetscInt n;

  PetscFunctionBegin;
  *may = PETSC_FALSE;
  if (!ts->vatol) PetscFunctionReturn(0);
  PetscCall(PetscObjectStateGet((PetscObject)ts->vatol, &state));
  if (state != self->tolerance_state) {
    PetscCall(VecGetLocalSize(ts->vatol, &n));
    PetscCall(VecGetArrayRead(ts->vatol, &tolerance));
    for (PetscInt i = 0; i < n && !small; i++)
      small = PetscAbsReal(tolerance[i]) < step_rule.tolerance_minute;
    PetscCall(VecRestoreArrayRead(ts->vatol, &tolerance));
    PetscCallMPI(
        MPI_Allreduce(MPI_IN_PLACE, &small, 1, MPI_INT, MPI_MAX, PetscObjectComm((PetscObject)ts)));
    self->minute = (PetscBool)small;
    self->tolerance_state = state;
  }
  *may = self->minute;
  PetscFunctionReturn(0);
}

/* Is a state so far from another one? Collective. */
static PetscErrorCode IsBeyond(TS ts, Controller *self, Vec U, Vec X, PetscBool *is) {
  const PetscScalar *u, *x, *tolerance;
  PetscBool may;
  int far = 0;
  PetscInt n;

  PetscFunctionBegin;
  *is = PETSC_FALSE;
  PetscCall(MayBeBeyond(ts, self, &may));
  if (!may) PetscFunctionReturn(0);
  PetscCall(VecGetLocalSize(U, &n));
  PetscCall(VecGetArrayRead(U, &u));
  PetscCall(VecGetArrayRead(X, &x));
  PetscCall(VecGetArrayRead(ts->vatol, &tolerance));
  for (PetscInt i = 0; i < n; i++)
    if (!(PetscAbsReal(x[i] - u[i]) <= step_rule.error_overflows * PetscAbsReal(tolerance[i])))
      far = 1;
  PetscCall(VecRestoreArrayRead(ts->vatol, &tolerance));
  PetscCall(VecRestoreArrayRead(X, &x));
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, &far, 1, MPI_INT, MPI_MAX, PetscObjectComm((PetscObject)ts)));
  *is = (PetscBool)far;
  PetscFunctionReturn(0);
}

/* The weighted norm of the difference of a state from work, which is lost. */
static PetscErrorCode Norm(TS ts, Controller *self, Vec U, PetscReal *norm) {
  PetscReal absolute, relative;
  PetscBool far;

  PetscFunctionBegin;
  *norm = step_rule.error_overflows;
  if (self->measure) {
    PetscCall(VecAXPY(self->work, -1, U));
    PetscCall(self->measure(ts, self->work));
    PetscCall(VecAXPY(self->work, 1, U));
  }
  PetscCall(IsBeyond(ts, self, U, self->work, &far));
  if (far) PetscFunctionReturn(0);
  PetscCall(
      TSErrorWeightedNorm(ts, U, self->work, ts->adapt->wnormtype, norm, &absolute, &relative));
  PetscFunctionReturn(0);
}

/* The weighted error that a step of order q would have made, over the tolerance. */
static PetscErrorCode LocalError(TS ts, Controller *self, Formula *f, PetscInt q,
                                 PetscReal *error) {
  PetscFunctionBegin;
  PetscCall(FormulaWithoutError(f, q, self->work));
  FormulaTakeFactor(f, self->order);
  PetscCall(Norm(ts, self, f->point[0], error));
  PetscFunctionReturn(0);
}

/* The first step has no second point to tell its error from. A decaying mode that changes by d in
   it errs by d^2/2; U is compared with the guess, growth alone. (On the safe side: against rtol,
   while change is measured against the tolerance, a part of it.) Behind a kink of what bends the
   rod modes of all rates are let go at once: those much faster than the step err by all that they
   change. */
static PetscErrorCode FirstError(TS ts, Controller *self, Formula *f, PetscReal *error) {
  PetscReal change;

  PetscFunctionBegin;
  *error = 0;
  if (!self->guess) PetscFunctionReturn(0);
  PetscCall(self->guess(ts, ts->ptime, f->now, f->point[1], self->work, self->guess_ctx));
  PetscCall(Norm(ts, self, f->point[0], &change));
  *error = self->kinked ? change : change * change * ts->rtol / 2;
  PetscFunctionReturn(0);
}

/* The factor by which the step may change for an error e of order q, as a part of the tolerance. */
static PetscReal StepFactor(PetscReal e, PetscInt q) {
  return PetscPowReal(step_rule.error_aim / PetscMax(e, 1e-14), 1.0 / (q + 1));
}

/* Would the step of order q, whose error is e, have had a smaller one without the factor, or with
   it? Then so the next. A rod that follows its natural curvature, x2 like a power of its length, is
   better off without. */
static PetscErrorCode WithOrWithout(TS ts, Controller *self, Formula *f, PetscInt q, PetscReal e) {
  PetscReal other;

  PetscFunctionBegin;
  if (!f->fields || !f->degree || f->n <= q || q < 2) PetscFunctionReturn(0);
  f->plain = (PetscBool)!f->plain;
  PetscCall(LocalError(ts, self, f, q, &other));
  f->plain = (PetscBool)!f->plain;
  FormulaTakeFactor(f, self->order);
  if (other < step_rule.factor_better * e) self->plain_next = (PetscBool)!f->plain;
  PetscFunctionReturn(0);
}

/* The error of the step just solved. */
static PetscErrorCode Error(TS ts, Controller *self, Formula *f, PetscReal *error) {
  PetscFunctionBegin;
  if (f->n > self->order)
    PetscCall(LocalError(ts, self, f, self->order, error));
  else
    PetscCall(FirstError(ts, self, f, error));
  PetscFunctionReturn(0);
}

/* Is the error of what is held right, and only that of the rest is not? Or all but right, in a
   first step that is as short as the rod's own time: what of a turn lies within a long cell moves
   places a little. */
static PetscErrorCode LookAtHeld(TS ts, Controller *self, Formula *f, PetscBool accept) {
  const Vec all = ts->vatol;
  PetscReal error;
  PetscBool begins;

  PetscFunctionBegin;
  self->placed = PETSC_FALSE;
  if (accept || !self->held || self->order > 1) PetscFunctionReturn(0);
  ts->vatol = self->held;
  PetscCall(Error(ts, self, f, &error));
  ts->vatol = all;
  begins = (PetscBool)(!ts->steps && ts->time_step <= self->again);
  self->placed = (PetscBool)(begins ? error <= step_rule.nearly_resolved
                                    : error <= 1 && (self->free || ts->steps > 0));
  PetscFunctionReturn(0);
}

/*
  Choose - accepts or rejects the step just solved; sets the next order and the factor for the step.
  The order changes to the one that allows the longest step, upwards only after order + 1 steps of
  one order (before, the estimates feel the change), except while the history is still building up.
*/
static PetscErrorCode Choose(TS ts, Controller *self, Formula *f, PetscBool *accept,
                             PetscReal *factor) {
  PetscInt k = self->order, best = k;
  PetscReal e, persists, lower = 0, higher = 0;

  PetscFunctionBegin;
  PetscCall(Error(ts, self, f, &e));
  *accept = (PetscBool)(e <= 1);
  PetscCall(LookAtHeld(ts, self, f, *accept));
  persists = (self->placed && !ts->steps) || ts->time_step < step_rule.slip_step * Scale(ts, self)
                 ? step_rule.slip_persists
                 : step_rule.jump_persists;
  self->jumped =
      (PetscBool)(!*accept && k == 1 &&
                  (e > persists * self->rejected ||
                   (ts->time_step < self->layer && (f->n == 1 || e > step_rule.nearly_resolved))));
  if (self->again > 0
          ? !self->placed && !(self->unheld && ts->time_step < step_rule.unheld_step * self->own)
          : self->resolves && ts->steps > 0 && ts->time_step >= self->layer) {
    self->snaps = self->jumped;
    self->jumped = PETSC_FALSE;
  }
  if (self->kinked) self->jumped = PETSC_FALSE;
  self->rejected = *accept ? PETSC_MAX_REAL : e;
  if (self->jumped) *accept = PETSC_TRUE;
  *factor = StepFactor(e, k);
  if (k > 1) {
    PetscCall(LocalError(ts, self, f, k - 1, &lower));
    if (StepFactor(lower, k - 1) > *factor) {
      best = k - 1;
      *factor = StepFactor(lower, k - 1);
    }
  }
  if (*accept && k < self->most && f->n >= k + 2 && (self->since > k || f->n < self->most + 2)) {
    PetscCall(LocalError(ts, self, f, k + 1, &higher));
    if (StepFactor(higher, k + 1) > *factor) {
      best = k + 1;
      *factor = StepFactor(higher, k + 1);
    }
  }
  PetscCall(WithOrWithout(ts, self, f, k, e));
  if (best != k) self->since = 0;
  self->order = best;
  *factor = PetscMax(step_rule.shrink_most, PetscMin(*factor, *accept ? step_rule.grow_most : 0.9));
  PetscCall(PetscInfo(
      ts, "t %g dt %g order %d error %g (lower %g, higher %g) %s, next order %d, step times %g\n",
      (double)f->now, (double)ts->time_step, (int)k, (double)e, (double)lower, (double)higher,
      *accept ? "accepted" : "rejected", (int)best, (double)*factor));
  PetscFunctionReturn(0);
}

/* Keeps the step within the limits and lets the last ones before a time at which a step has to end,
   the final one, say, end there. (One that is as long as what is left is the last: PETSc cuts the
   step of a run that goes on to that, as the time tells it, which knows of nothing late.) */
static PetscErrorCode LimitStep(TS ts, Controller *self) {
  const PetscBool match = (PetscBool)(ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP);
  PetscReal least, most, end, left;

  PetscFunctionBegin;
  PetscCall(TSAdaptGetStepLimits(ts->adapt, &least, &most));
  ts->time_step = PetscMin(ts->time_step, most);
  end = match ? ts->max_time : PETSC_MAX_REAL;
  if (self->next_end && !self->fixed)
    end = SmallerOf(end, self->next_end(ts, ts->ptime + step_rule.end_met * ts->max_time));
  left = end - ts->ptime - self->late;
  if (ts->time_step >= PetscMin(left, end - ts->ptime))
    ts->time_step = left;
  else if (!self->fixed && ts->time_step > left / 2)
    ts->time_step = left / 2;
  PetscFunctionReturn(0);
}

/* The step is this long from now on. Beside a time that is late in a run it may be next to nothing:
   the history holds differences, and what the time has not room for is kept. */
static void TakeStep(TS ts, const Controller *self, Formula *f) {
  f->time[0] = ts->time_step;
  f->now = ts->ptime + (self->late + ts->time_step);
}

/* Begins a try: the step's factor, and the step itself if that would change too much in it. */
static void BeginTry(TS ts, Controller *self, Formula *f) {
  PetscReal efoldings;

  TakeStep(ts, self, f);
  f->plain = self->plain_next;
  FormulaTakeFactor(f, self->order);
  efoldings = FormulaEfoldings(f);
  if (self->fixed || efoldings <= step_rule.factor_change) return;
  ts->time_step *= step_rule.factor_change / efoldings;
  TakeStep(ts, self, f);
  FormulaTakeFactor(f, self->order);
}

/* A step that is no step. */
static PetscReal Smallest(TS ts, const Controller *self) {
  return step_rule.smallest_step * (self->own > 0 ? self->own : Scale(ts, self));
}

/* After a rejection: a shorter step; after several, a fresh start from the last point alone,
   because the history may lie on the other side of a kink. */
static PetscErrorCode Retry(TS ts, Controller *self, Formula *f, PetscInt attempt,
                            PetscReal factor) {
  PetscFunctionBegin;
  ts->reject++;
  ts->time_step *= factor;
  if (!ts->steps && self->again > 0 && self->snaps)
    ts->time_step = PetscMin(ts->time_step, self->again);
  self->since = 0;
  if (attempt >= 3) {
    self->order = 1;
    f->n = 1;
  }
  if (ts->max_reject >= 0 && attempt > ts->max_reject) ts->reason = TS_DIVERGED_STEP_REJECTED;
  if (ts->time_step < Smallest(ts, self)) ts->reason = TS_DIVERGED_STEP_REJECTED;
  PetscFunctionReturn(0);
}

/* Whether a solved step may be; if not, it is as if it had not been solved. */
static PetscErrorCode Check(TS ts, Controller *self, Formula *f, SNESConvergedReason *solved) {
  PetscBool impossible = PETSC_FALSE;

  PetscFunctionBegin;
  if (!self->check || *solved < 0) PetscFunctionReturn(0);
  PetscCall(self->check(ts, ts->ptime, f->now, f->point[1], f->point[0], &impossible));
  if (impossible) *solved = SNES_DIVERGED_FUNCTION_DOMAIN;
  PetscFunctionReturn(0);
}

/* Does the step solved cross a mode that grows, where it passes X? At the rate that the step has:
   dry friction resists a rod at rest, and next to nothing of it a rod that moves fast, so that
   modes of one that falls grow a thousandfold faster than they seem to where it still lies. */
static PetscErrorCode CrossesAt(TS ts, Controller *self, Formula *f, Vec X, VBDFSight sight,
                                PetscBool *crosses) {
  Mat J, P;

  PetscFunctionBegin;
  PetscCall(TSPreStage(ts, f->now));
  PetscCall(FormulaRate(f, f->point[0]));
  PetscCall(TSGetIJacobian(ts, &J, &P, NULL, NULL));
  PetscCall(TSComputeIJacobian(ts, f->now, X, f->rate, f->shift, J, P, PETSC_FALSE));
  PetscCall(self->cross(ts, X, sight, crosses));
  PetscFunctionReturn(0);
}

/*
  Crosses - does a step of this order, which would be accepted, cross a mode that grows? A mode of
  the rate r is multiplied by about 1/(1 - h r): beyond h r = 1 its sign turns, and it falls instead
  of growing. No error sees that, for it does not depend on h any more. A step of which no error is
  known may have gone far: it must not cross one where it begins, as predicted, nor half-way. If it
  does, the order and the memory of rejected errors are as if it had not been tried.
*/
static PetscErrorCode Crosses(TS ts, Controller *self, Formula *f, PetscInt order,
                              PetscBool *crosses) {
  VBDFSight sight = f->n <= order ? VBDF_BLIND : VBDF_SEEN;
  PetscInt best = self->order;

  PetscFunctionBegin;
  *crosses = PETSC_FALSE;
  if (!self->cross) PetscFunctionReturn(0);
  if (self->jumped) sight = ts->time_step < self->layer ? VBDF_BLIND : VBDF_JUMP;
  PetscCall(self->cross(ts, f->point[0], sight, crosses));
  if (sight != VBDF_SEEN && !*crosses) {
    self->order = order;
    PetscCall(Predict(ts, self, f, self->work));
    PetscCall(CrossesAt(ts, self, f, self->work, sight, crosses));
    PetscCall(VecAXPBY(self->work, 0.5, 0.5, f->point[0]));
    if (!*crosses) PetscCall(CrossesAt(ts, self, f, self->work, sight, crosses));
    if (!*crosses)
      PetscCall(CrossesAt(ts, self, f, f->point[0], sight, crosses)); /* for the next step */
    self->order = best;
  }
  if (!*crosses) PetscFunctionReturn(0);
  self->order = order;
  self->jumped = PETSC_FALSE;
  self->rejected = PETSC_MAX_REAL;
  PetscFunctionReturn(0);
}

/* Solves the equations of the present step, in the usual way or else in another. */
static PetscErrorCode Solve(TS ts, Controller *self, Formula *f, SNESConvergedReason *solved) {
  PetscFunctionBegin;
  PetscCall(Predict(ts, self, f, f->point[0]));
  PetscCall(SolveStage(ts, self, f));
  PetscCall(SNESGetConvergedReason(ts->snes, solved));
  if (*solved >= 0 || !self->other_way) PetscFunctionReturn(0);
  PetscCall(self->other_way(ts, PETSC_TRUE));
  PetscCall(Predict(ts, self, f, f->point[0]));
  PetscCall(SolveStage(ts, self, f));
  PetscCall(SNESGetConvergedReason(ts->snes, solved));
  PetscCall(self->other_way(ts, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* What a try has come to: its equations have no solution, or one that cannot be; it crosses a mode
   that grows; its error is too large; or it is accepted. */
typedef enum { TRY_UNSOLVED, TRY_CROSSES, TRY_ERRS, TRY_ACCEPTED } Outcome;

/* One try of the step. factor: what its size is multiplied by for the next one. (A state with what
   is no number in it, or would make none of a norm of errors, is no solution. Its sum tells so on
   all ranks: from a largest value what is no number may be lost on some.) */
static PetscErrorCode Try(TS ts, Controller *self, Formula *f, Outcome *outcome,
                          PetscReal *factor) {
  PetscBool accept = PETSC_TRUE, crosses = PETSC_FALSE;
  SNESConvergedReason solved;
  PetscReal size;

  PetscFunctionBegin;
  self->order = PetscMax(1, PetscMin(self->order, f->n));
  PetscCall(LimitStep(ts, self));
  BeginTry(ts, self, f);
  self->placed = self->snaps = PETSC_FALSE;
  PetscCall(Solve(ts, self, f, &solved));
  self->taken_order = self->order;
  PetscCall(VecNorm(f->point[0], NORM_1, &size));
  if (!(size < step_rule.error_overflows)) solved = DIVERGED_NAN;
  PetscCall(Check(ts, self, f, &solved));
  *outcome = TRY_UNSOLVED;
  self->snaps = (PetscBool)(solved < 0);
  if (solved < 0) PetscFunctionReturn(0);
  if (!self->fixed) PetscCall(Choose(ts, self, f, &accept, factor));
  if (accept) PetscCall(Crosses(ts, self, f, self->taken_order, &crosses));
  *outcome = !accept ? TRY_ERRS : crosses ? TRY_CROSSES : TRY_ACCEPTED;
  PetscFunctionReturn(0);
}

/* The step cannot be as it was tried: one of fixed size ends the run; another is cut. */
static PetscErrorCode Cut(TS ts, Controller *self, Formula *f, PetscInt attempt, Outcome outcome) {
  PetscBool unsolved = (PetscBool)(outcome == TRY_UNSOLVED);

  PetscFunctionBegin;
  if (unsolved) ts->num_snes_failures++;
  if (self->fixed ||
      (unsolved && ts->max_snes_failures >= 0 && ts->num_snes_failures > ts->max_snes_failures))
    ts->reason = unsolved ? TS_DIVERGED_NONLINEAR_SOLVE : TS_DIVERGED_STEP_REJECTED;
  else
    PetscCall(Retry(ts, self, f, attempt, step_rule.failed_cut));
  PetscFunctionReturn(0);
}

/* Tries the step until it is accepted, or the TS has a reason to end. factor: for the next step. */
static PetscErrorCode TryUntilAccepted(TS ts, Controller *self, Formula *f, PetscReal *factor) {
  Outcome outcome = TRY_UNSOLVED;

  PetscFunctionBegin;
  for (PetscInt attempt = 1; outcome != TRY_ACCEPTED && !ts->reason; attempt++) {
    PetscCall(Try(ts, self, f, &outcome, factor));
    if (outcome == TRY_ERRS) {
      if (*factor > 1. / 3) self->rejected = PETSC_MAX_REAL;
      PetscCall(Retry(ts, self, f, attempt, *factor));
    } else if (outcome != TRY_ACCEPTED) {
      PetscCall(Cut(ts, self, f, attempt, outcome));
    }
  }
  PetscFunctionReturn(0);
}

/* A step that begins at a kink knows nothing of what is behind it: the history starts again, and
   the step is short. */
static void SetOutAnew(TS ts, Controller *self, Formula *f) {
  self->kinked = (PetscBool)(self->kinks && !self->fixed && f->n > 1 && self->kinks(ts, ts->ptime));
  if (!self->kinked) return;
  f->n = self->order = 1;
  ts->time_step = PetscMin(ts->time_step, ts->rtol * Scale(ts, self));
}

/* Begins a step: moves the state into the history. */
static PetscErrorCode BeginStep(TS ts, Controller *self, Formula *f) {
  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &self->fixed));
  self->jumped = PETSC_FALSE;
  self->layer = PetscMax(self->layer, step_rule.jump_step * Scale(ts, self));
  self->rejected = PETSC_MAX_REAL;
  if (ts->steprestart && !f->given) f->n = 0;
  if (!f->given && !ts->steprollback) PetscCall(FormulaPush(f, ts->vec_sol));
  f->given = PETSC_FALSE;
  SetOutAnew(ts, self, f);
  if (self->fixed) self->order = PetscMin(self->order + 1, self->most);
  PetscFunctionReturn(0);
}

/* Time passes. */
static void Pass(TS ts, Controller *self, Formula *f) {
  const PetscReal before = ts->ptime, step = self->late + ts->time_step;

  ts->ptime = f->now;
  self->late = step - (f->now - before);
  f->done = PETSC_TRUE;
  if (ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP &&
      PetscAbsReal(ts->max_time - ts->ptime) < step_rule.end_met * ts->max_time) {
    ts->ptime = ts->max_time;
    self->late = 0;
  }
}

/* Ends an accepted step: hands over the state, and sets the size of the next step, times factor.
   Behind a jump the history starts again. */
static PetscErrorCode EndStep(TS ts, Controller *self, Formula *f, PetscReal factor) {
  PetscFunctionBegin;
  self->since++;
  if (self->jumped) {
    self->jumps++;
    f->n = 0;
    factor = 1;
    if (ts->time_step < self->layer) {
      factor = 2;
      self->layer = PetscMin(2 * self->layer, step_rule.longest_jump * Scale(ts, self));
    }
  }
  PetscCall(VecCopy(f->point[0], ts->vec_sol));
  /* of the accepted state: a linear solve has not looked at it any more */
  PetscCall(FormulaRate(f, f->point[0]));
  Pass(ts, self, f);
  ts->time_step *= factor;
  PetscFunctionReturn(0);
}

/* ControllerStep - takes a step of a TS whose formula this is, or gives the TS the reason why it
   cannot be taken. Collective. */
PetscErrorCode ControllerStep(TS ts, Controller *self, Formula *f) {
  PetscReal factor = 1;

  PetscFunctionBegin;
  PetscCall(BeginStep(ts, self, f));
  PetscCall(TryUntilAccepted(ts, self, f, &factor));
  if (!ts->reason) PetscCall(EndStep(ts, self, f, factor));
  PetscFunctionReturn(0);
}
