/* -task grow of several rods. They are stepped as one (system/model.h); what is seen of each is
   that of a run of its own (growing.h), by the leg that it has in that of all. Here: the steps, and
   what is looked at after each. */
#include "tasks/several.h"
#include "base/signals.h"
#include "rod/ask.h"
#include "stepping/vbdf.h"
#include "tasks/grow_rules.h"
#include "tasks/several_run.h"

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

/* ---- steps ---- */

/* The errors of rods that hold each other go on. */
static PetscErrorCode FollowErrors(Run *self) {
  PetscBool pressed = PETSC_FALSE;
  PetscInt jumps;

  PetscFunctionBegin;
  PetscCall(VBDFGetJumps(self->leg.ts, &jumps));
  for (PetscInt k = 0; k < self->n; k++)
    if (self->each[k].kept.pressed) pressed = PETSC_TRUE;
  PetscCall(EstimateStep(self->estimate, (PetscBool)(jumps > self->leg.jumps), pressed));
  self->leg.jumps = jumps;
  PetscFunctionReturn(0);
}

/* What each is put off by, as what presses it gives. */
static PetscErrorCode TakeGives(Run *self, PetscReal t) {
  StrandSum on;

  PetscFunctionBegin;
  if (!self->strands[1]) PetscFunctionReturn(0);
  PetscCall(RunKnowStrands(self, t, PETSC_TRUE));
  for (PetscInt k = 0; k < self->n; k++) {
    StrandsSum(self->strands[1], k, &on);
    EstimateGives(self->each[k].estimate, on.gives);
  }
  PetscFunctionReturn(0);
}

/* Looks at all rods, at a time; begins: as they begin. */
PetscErrorCode RunLook(Run *self, PetscReal t, PetscBool begins) {
  PetscReal times = PETSC_MAX_REAL;

  PetscFunctionBegin;
  self->t = t;
  if (!begins) PetscCall(TakeGives(self, t));
  if (!begins) PetscCall(FollowErrors(self));
  if (!begins) PetscCall(RunBirths(self, t));
  for (PetscInt k = 0; k < self->n; k++) {
    PetscCall(RunLookAt(self, k, t, begins));
    times = PetscMin(times, self->each[k].now->ease.times);
  }
  RunEaseEach(self, times);
  PetscFunctionReturn(0);
}

/* Stores the shapes of a state of all; U NULL: as they begin. */
PetscErrorCode RunStoreShape(Run *self, PetscReal t, Vec U) {
  StrandPlace *place;
  Vec part = NULL;
  PetscInt n;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    if (U) PetscCall(RodPartOpenRead(self->leg.rod, k, U, &part));
    PetscCall(RunShapeOf(self, k, t, part));
    if (U) PetscCall(RodPartCloseRead(self->leg.rod, k, U, &part));
  }
  self->stored_shape = t;
  if (!self->strands[1]) PetscFunctionReturn(0);
  PetscCall(RunKnowStrands(self, t, (PetscBool)(t > 0)));
  PetscCall(StrandsPlaces(self->strands[1], &n, &place));
  PetscCall(SeveralTouch(&self->file, n, place));
  PetscCall(PetscFree(place));
  PetscFunctionReturn(0);
}

/* Those that are due between the previous step and this one, by the stepper's dense output. */
static PetscErrorCode StoreDue(Run *self, PetscReal t) {
  Vec W;

  PetscFunctionBegin;
  for (; self->next_output <= t * (1 + 1e-14); self->next_output += self->interval) {
    if (self->next_output >= t * (1 - 1e-12)) {
      PetscCall(RunStoreShape(self, t, self->leg.U));
      continue;
    }
    PetscCall(VecDuplicate(self->leg.U, &W));
    PetscCall(TSInterpolate(self->leg.ts, self->next_output, W));
    PetscCall(RunStoreShape(self, self->next_output, W));
    PetscCall(VecDestroy(&W));
  }
  PetscFunctionReturn(0);
}

/* Dry friction that does not say how fast rods snap has a viscous share from here on. */
static PetscBool ShareMore(Run *self, PetscBool again) {
  PetscBool more = PETSC_FALSE;

  for (PetscInt k = 0; k < self->n; k++) {
    Load *load = &self->scene[k]->load;
    if (again ? !LoadMaySlip(load) : load->shared) continue;
    if (LoadShareMore(load)) more = PETSC_TRUE;
  }
  return more;
}

/* Looks at the step just taken. */
PetscErrorCode RunAfterStep(TS ts) {
  TSConvergedReason reason;
  PetscReal t, speed;
  PetscBool begins;
  Leg *leg;
  Run *self;

  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (reason < 0) PetscFunctionReturn(0); /* called after a step that failed, too */
  PetscCall(TSGetApplicationContext(ts, &leg));
  self = (Run *)leg->owner;
  PetscCall(TSGetTime(ts, &t));
  if (!reason && t >= self->end) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_TIME));
  PetscCall(RunLook(self, t, PETSC_FALSE));
  PetscCall(LegSpeed(&self->leg, &speed, &begins));
  self->snaps += begins;
  if (begins) (void)ShareMore(self, PETSC_FALSE);
  PetscCall(StoreDue(self, t));
  PetscCall(RunProgress(self, PETSC_FALSE));
  self->stopped = SignalCaught();
  if (self->stopped) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  if (SeveralDue(&self->file)) PetscCall(SeveralStore(&self->file, t, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* Rods in dry friction that find no step try again with a viscous share, or a larger one. */
static PetscErrorCode Solve(Run *self) {
  PetscBool again = PETSC_TRUE;

  PetscFunctionBegin;
  while (again) {
    PetscCall(TSSolve(self->leg.ts, self->leg.U));
    PetscCall(TSGetConvergedReason(self->leg.ts, &self->reason));
    again = (PetscBool)(self->reason < 0 && !self->stopped && ShareMore(self, PETSC_TRUE));
    if (!again) continue;
    PetscCall(TSRestartStep(self->leg.ts));
    PetscCall(TSSetTimeStep(self->leg.ts, grow_rule.again_step * self->end));
  }
  PetscCall(RunProgress(self, PETSC_TRUE));
  PetscFunctionReturn(0);
}

/* ---- the end ---- */

static PetscErrorCode Finish(Run *self) {
  char text[2][64] = {""};

  PetscFunctionBegin;
  PetscCall(RunSummary(self));
  if (self->t != self->stored_shape) PetscCall(RunStoreShape(self, self->t, self->leg.U));
  if (self->stopped)
    (void)snprintf(text[0], sizeof(text[0]), "by signal %d at t = %.30s", self->stopped,
                   OptionBoth(self->t, UNIT_TIME, text[1]));
  for (PetscInt k = 0; k < self->n; k++) PetscCall(OutputInterrupted(self->output[k], text[0]));
  PetscCall(SeveralStore(&self->file, self->t, (PetscBool)(self->reason == TS_CONVERGED_TIME)));
  PetscCall(RunVerdict(self));
  PetscFunctionReturn(0);
}

static PetscErrorCode BeginAndRun(Run *self) {
  PetscFunctionBegin;
  PetscCall(RunBegin(self));
  SignalsCatch();
  PetscCall(RunHeading(self));
  PetscCall(Solve(self));
  PetscCall(Finish(self));
  PetscFunctionReturn(0);
}

static PetscErrorCode End(Run *self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n && self->each; k++) {
    PetscCall(OutputDestroy(&self->each[k].output));
    PetscCall(ObserverDestroy(&self->each[k].observer));
    PetscCall(EstimateDestroy(&self->each[k].estimate));
    PetscCall(LegPartEnd(&self->each[k].leg[SPACE]));
  }
  PetscCall(EstimateDestroy(&self->estimate));
  PetscCall(LegDestroy(&self->leg));
  for (int i = 0; i < 2; i++) PetscCall(StrandsDestroy(&self->strands[i]));
  for (PetscInt k = 0; k < self->n && self->scene; k++) PetscCall(SceneDestroy(&self->scene[k]));
  PetscCall(PetscFree4(self->scene, self->each, self->output, self->to_come));
  if (self->begun) PetscCall(SeveralEnd(&self->file));
  PetscCall(JointsDestroy(&self->joints));
  PetscCall(RodsDestroy(&self->rods));
  PetscCall(PetscFree(self->own));
  WordsFree(&self->words);
  PetscFunctionReturn(0);
}

/* SeveralRun - follows the rods of a scene from t = 0 to its end time. Each is on this rank, and
   several ranks are refused. */
PetscErrorCode SeveralRun(const Single *asked) {
  const OptionWords *given = &OptionsLine()->taken;
  const char *head = given->sections ? given->section[0].head : "rod";
  Run run = {.restart = asked->restart};
  PetscErrorCode error;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(OptionsComm(), &ranks));
  UserCheck(ranks == 1, OptionsComm(),
            "[%s]: several rods run on one rank in this version; start without mpiexec", head);
  UserCheck(asked->task == TASK_GROW, OptionsComm(),
            "[%s]: this -task knows one rod; take the sections out, or the -task", head);
  PetscCall(PetscStrncpy(run.file.path, asked->output[0] ? asked->output : asked->restart,
                         sizeof(run.file.path)));
  error = BeginAndRun(&run);
  if (error && run.ready) (void)SeveralStore(&run.file, run.t, PETSC_FALSE);
  PetscCall(End(&run));
  PetscCall(error);
  PetscFunctionReturn(0);
}
