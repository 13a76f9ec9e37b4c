/* -task grow of several rods: the loop. They are stepped as one (system/model.h); what is seen of
   each is that of a run of its own (growing.h), by the leg that it has in that of all. */
#include "tasks/several.h"
#include "base/signals.h"
#include "tasks/together.h"
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

/* Looks at the state that was come to. */
static PetscErrorCode TakeStep(Together *self, PetscReal t) {
  PetscReal speed;
  PetscBool begins;

  PetscFunctionBegin;
  PetscCall(TogetherLook(self, t, PETSC_FALSE));
  PetscCall(LegSpeed(&self->leg, &speed, &begins));
  self->snaps += begins;
  if (begins) (void)TogetherShare(self, PETSC_FALSE);
  PetscCall(TogetherDue(self, t));
  if (self->stopped_by >= 0) PetscCall(TogetherEndHere(self));
  PetscCall(TogetherProgress(self, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* TogetherAfterStep - what the stepper calls behind each of its steps: looks at it. */
PetscErrorCode TogetherAfterStep(TS ts) {
  TSConvergedReason reason;
  Together *self;
  PetscReal t;
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (reason < 0) PetscFunctionReturn(0); /* called after a step that failed, too */
  PetscCall(TSGetApplicationContext(ts, &leg));
  self = (Together *)leg->owner;
  PetscCall(TSGetTime(ts, &t));
  if (!reason && t >= self->end) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_TIME));
  self->U = self->leg.U;
  self->U_t = self->leg.newton.latest.U_t;
  PetscCall(TogetherLocateEvent(self, &t));
  PetscCall(TakeStep(self, t));
  self->stopped = SignalCaught();
  if (self->stopped) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  if (SeveralDue(&self->file)) PetscCall(SeveralStore(&self->file, t, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* Rods in dry friction that find no step try again with a viscous share, or a larger one. */
static PetscErrorCode Solve(Together *self) {
  PetscBool again = PETSC_TRUE;

  PetscFunctionBegin;
  while (again) {
    PetscCall(TSSolve(self->leg.ts, self->leg.U));
    PetscCall(TSGetConvergedReason(self->leg.ts, &self->reason));
    again = (PetscBool)(self->reason < 0 && !self->stopped && TogetherShare(self, PETSC_TRUE));
    if (!again) continue;
    PetscCall(TSRestartStep(self->leg.ts));
    PetscCall(TSSetTimeStep(self->leg.ts, grow_rule.again_step * self->end));
  }
  PetscCall(TogetherProgress(self, PETSC_TRUE));
  PetscFunctionReturn(0);
}

static PetscErrorCode BeginAndRun(Together *self, PetscBool *again) {
  PetscFunctionBegin;
  *again = PETSC_FALSE;
  PetscCall(TogetherBegin(self));
  SignalsCatch();
  PetscCall(TogetherHeading(self));
  PetscCall(Solve(self));
  PetscCall(TogetherFinish(self, again));
  PetscFunctionReturn(0);
}

/* SeveralRun - follows the rods of a scene from t = 0 to its end time. Each is on this rank, and
   several ranks are refused. */
PetscErrorCode SeveralRun(const Single *asked) {
  const OptionWords *given = &OptionsLine()->taken;
  const char *head = given->sections ? given->section[0].head : "rod";
  Together run = {.restart = asked->restart, .stopped_by = -1};
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
    PetscCall(TogetherStartOver(&run));
    error = BeginAndRun(&run, &again);
  }
  if (error && run.ready) (void)SeveralStore(&run.file, run.t, PETSC_FALSE);
  PetscCall(TogetherEnd(&run));
  PetscCall(error);
  PetscFunctionReturn(0);
}
