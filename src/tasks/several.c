/* -task grow of several rods: the loop. They are stepped as one (system/model.h); what is seen of
   each is that of a run of its own (growing.h), by the leg that it has in that of all. */
#include "tasks/several.h"
#include "base/signals.h"
#include "tasks/several_run.h"
#include "tasks/grow_rules.h"

/* SeveralAsked - has the scene several rods, or the run that is gone on with? */
PetscErrorCode SeveralAsked(PetscBool *asked) {
  const CommandLine *line = OptionsLine();
  char restart[PETSC_MAX_PATH_LEN] = "";

  PetscFunctionBegin;
  *asked = (PetscBool)(!OptionsPushed() && line && line->taken.sections > 0);
  if (*asked || OptionsPushed()) PetscFunctionReturn(0);
  PetscCall(OptionText("-restart", restart, NULL));
  if (restart[0]) PetscCall(HdfHas(restart, "/rods/text", asked));
  PetscFunctionReturn(0);
}

/* Looks at the step to a time. */
static PetscErrorCode TakeStep(Run *self, PetscReal t) {
  PetscReal speed;
  PetscBool begins;

  PetscFunctionBegin;
  self->U = self->leg.U;
  self->U_t = self->leg.newton.latest.U_t;
  PetscCall(RunLocateEvent(self, &t));
  PetscCall(RunLook(self, t, PETSC_FALSE));
  PetscCall(LegSpeed(&self->leg, &speed, &begins));
  self->snaps += begins;
  if (begins) (void)RunShareMore(self, PETSC_FALSE);
  PetscCall(RunStoreDue(self, t));
  if (self->stopped_by >= 0) PetscCall(RunEndHere(self));
  PetscCall(RunProgress(self, PETSC_FALSE));
  self->stopped = SignalCaught();
  if (self->stopped) PetscCall(TSSetConvergedReason(self->leg.ts, TS_CONVERGED_USER));
  if (SeveralDue(&self->file)) PetscCall(SeveralStore(&self->file, t, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* Is one step taken after the other, for between them something may be changed? */
static PetscBool ByTurns(const Run *self) {
  return (PetscBool)(self->by_steps || RunIsChanged(self));
}

/* RunAfterStep - what the stepper calls behind each of its steps: looks at it, unless it is to
   wait; as GrowAfterStep() has it. */
PetscErrorCode RunAfterStep(TS ts) {
  TSConvergedReason reason;
  PetscInt steps, most;
  Run *self;
  PetscReal t;
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (reason < 0) PetscFunctionReturn(0); /* called after a step that failed, too */
  PetscCall(TSGetApplicationContext(ts, &leg));
  self = (Run *)leg->owner;
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetStepNumber(ts, &steps));
  PetscCall(TSGetMaxSteps(ts, &most));
  if (!reason) { /* newer PETSc leaves that to TSSolve() */
    reason = steps >= most    ? TS_CONVERGED_ITS
             : t >= self->end ? TS_CONVERGED_TIME
                              : TS_CONVERGED_ITERATING;
    PetscCall(TSSetConvergedReason(ts, reason));
  }
  self->waits = (PetscBool)(ByTurns(self) && t > self->until * (1 + grow_rule.same_time));
  self->reason = reason;
  if (!self->waits) PetscCall(TakeStep(self, t));
  if (ByTurns(self)) PetscCall(TSGetConvergedReason(ts, &reason));
  if (self->waits || (ByTurns(self) && !reason))
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER)); /* the host has its turn */
  PetscFunctionReturn(0);
}

/* RunAfterSolve - what follows where the stepper has stopped. Rods in dry friction that find
   no step try again with a viscous share, or a larger one. */
PetscErrorCode RunAfterSolve(Run *self) {
  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(self->leg.ts, &self->reason));
  self->enters = PETSC_FALSE;
  if (self->reason < 0 && !self->stopped && RunShareMore(self, PETSC_TRUE)) {
    PetscCall(TSRestartStep(self->leg.ts));
    PetscCall(TSSetTimeStep(self->leg.ts, grow_rule.again_step * self->end));
    self->enters = PETSC_TRUE;
  } else if (self->reason != TS_CONVERGED_USER || self->stopped || self->stopped_by >= 0)
    self->over = PETSC_TRUE;
  PetscFunctionReturn(0);
}

static PetscErrorCode Follow(Run *self) {
  PetscFunctionBegin;
  while (!self->over && RunIsChanged(self)) PetscCall(RunStepOn(self, PETSC_MAX_REAL));
  while (!self->over) {
    PetscCall(TSSolve(self->leg.ts, self->leg.U));
    PetscCall(RunAfterSolve(self));
  }
  PetscCall(RunProgress(self, PETSC_TRUE));
  PetscCall(RunTellNotReached(self));
  PetscFunctionReturn(0);
}

static PetscErrorCode BeginAndRun(Run *self, PetscBool *again) {
  PetscFunctionBegin;
  *again = PETSC_FALSE;
  PetscCall(RunBegin(self));
  SignalsCatch();
  PetscCall(RunHeading(self));
  PetscCall(Follow(self));
  PetscCall(RunFinish(self, again));
  PetscFunctionReturn(0);
}

/* SeveralRun - follows the rods of a scene from t = 0 to its end time. Each is on this rank, and
   several ranks are refused. */
PetscErrorCode SeveralRun(const Single *asked) {
  const OptionWords *given = &OptionsLine()->taken;
  const char *head = given->sections ? given->section[0].head : "rod";
  Run run = {.restart = asked->restart, .stopped_by = -1};
  PetscErrorCode error;
  PetscMPIInt ranks;
  PetscBool again;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(OptionsComm(), &ranks));
  UserCheck(ranks == 1, OptionsComm(),
            "[%s]: several rods run on one rank in this version; start without mpiexec", head);
  UserCheck(asked->task == TASK_GROW, OptionsComm(),
            "[%s]: this -task knows one rod; take the sections out, or the -task", head);
  PetscCall(PetscStrncpy(run.file.path, asked->output[0] ? asked->output : asked->restart,
                         sizeof(run.file.path)));
  error = BeginAndRun(&run, &again);
  while (!error && again) {
    PetscCall(RunStartOver(&run));
    error = BeginAndRun(&run, &again);
  }
  if (error && run.ready) (void)SeveralStore(&run.file, run.t, PETSC_FALSE);
  PetscCall(RunEnd(&run));
  PetscCall(error);
  PetscFunctionReturn(0);
}
