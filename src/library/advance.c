/* How a simulation goes on. */
#include "library/simulation.h"

/* A run that found no way in firm contact begins once more, in soft contact, and comes to where it
   was: its series are then those of that run. What was changed on the way cannot be done again. */
static PetscErrorCode Again(Tendril self) {
  PetscFunctionBegin;
  UserCheck(!self->scene->changes || !self->scene->changes->done, self->comm,
            "no way is found in contact that gets firmer where the rod is pressed in, and what was "
            "changed in the run keeps it from beginning again: give -contact_stiffness");
  PetscCall(CourseStartOver(self));
  ColumnsBegin(&self->sight[0].series);
  PetscFunctionReturn(0);
}

/* The run is over: at its end, or by giving up. */
static PetscErrorCode Finish(Tendril self) {
  PetscErrorCode error;
  PetscBool again;

  PetscFunctionBegin;
  error = CourseFinish(self, &again);
  if (!error && again) {
    PetscCall(Again(self));
    PetscFunctionReturn(0);
  }
  self->ended = (PetscBool)!error;
  self->failed = (PetscBool)(error != 0);
  if (error) PetscCall(PetscStrncpy(self->failure, self->errors.message, sizeof(self->failure)));
  if (error != TENDRIL_ERR_USER) PetscCall(error);
  PetscFunctionReturn(0);
}

/* Goes on until a step has been taken, or waits behind a time. What a run has given up on is no
   error of the call that looks at what came before it. */
static PetscErrorCode Move(Tendril self, PetscReal until) {
  const PetscReal before = CourseTime(self);

  PetscFunctionBegin;
  while (!CourseIsOver(self) && CourseTime(self) <= before) {
    PetscCall(CourseStep(self, until));
    if (CourseWaits(self)) break;
  }
  if (CourseIsOver(self) && !self->ended && !self->failed) PetscCall(Finish(self));
  PetscFunctionReturn(0);
}

/* What a call returns that could not go on: the run has ended, or has given up. */
static int Over(Tendril self) {
  if (self->failed) return SimulationRefuse(self, TENDRIL_RUN, "%s", self->failure);
  return SimulationRefuse(self, TENDRIL_ENDED, "the run is at its end, t = %g", (double)self->at);
}

static PetscBool IsOver(const struct Tendril_ *self) {
  return (PetscBool)((self->ended || self->failed) && !CourseWaits(self));
}

static int StepOn(Tendril self, PetscReal until) {
  const PetscReal before = self->at;
  PetscErrorCode error;
  int code;

  code = SimulationEnter(self);
  if (code) return code;
  do { /* a run that has begun again comes to where it was */
    error = Move(self, until);
    self->at = CourseWaits(self) ? until : CourseTime(self);
    if (!error) error = SimulationLook(self);
  } while (!error && self->at <= before && !self->ended && !self->failed);
  if (SimulationAgree(self)) self->lost = PETSC_TRUE;
  code = SimulationLeave(self, error);
  return !code && self->at <= before ? Over(self) : code;
}

int TendrilStep(Tendril self, double *t) {
  int code;

  if (t) *t = 0;
  if (!self) return TENDRIL_USER;
  code = CourseIsThere(self) ? TENDRIL_OK : TendrilSetUp(self);
  if (!code) code = IsOver(self) ? Over(self) : StepOn(self, PETSC_MAX_REAL);
  if (t && CourseIsThere(self)) *t = self->at;
  return code;
}

int TendrilAdvance(Tendril self, double until) {
  int code;

  if (!self) return TENDRIL_USER;
  code = CourseIsThere(self) ? TENDRIL_OK : TendrilSetUp(self);
  if (code) return code;
  if (!(until >= self->at))
    return SimulationRefuse(self, TENDRIL_USER,
                            "t = %g: the run is at %g already, and goes forward", until,
                            (double)self->at);
  while (!code && self->at < until) {
    if (IsOver(self)) return Over(self);
    code = StepOn(self, until);
    if (!code && self->watch && self->watch(self->watch_ctx, self))
      return SimulationRefuse(self, TENDRIL_WATCH, "the watch has stopped it at t = %g",
                              (double)self->at);
  }
  return code;
}
