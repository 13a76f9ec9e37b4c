/* -task grow of several rods: what is told of them, and the end. */
#include "tasks/several_run.h"
#include <petsctime.h>

/* Rods that have a diameter and do not touch each other all the same. */
static PetscErrorCode TellApart(const Run *self) {
  PetscInt thick = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) thick += self->scene[k]->contact.diameter > 0;
  if (thick > 1 && !RodsTouch(self->rods))
    PetscCall(PetscPrintf(PETSC_COMM_SELF,
                          "-contact_diameter: rods pass through each other; with -contact_rods, or "
                          "a section [pair NAME NAME], they do not\n"));
  PetscFunctionReturn(0);
}

/* RunHeading - the first lines. */
PetscErrorCode RunHeading(Run *self) {
  PetscReal factor;
  const char *unit = OptionShownIn(self->end, UNIT_TIME, &factor);

  PetscFunctionBegin;
  PetscCall(GrowPaceBegin(&self->pace));
  if (self->quiet) PetscFunctionReturn(0);
  PetscCall(OptionsTellPlain());
  PetscCall(TellApart(self));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "%d rods%s%s\n%10s %10s %10s %7s %11s\n", (int)self->n,
                        unit ? "; times in " : "", unit ? unit : "", "t", "longest", "step",
                        "Newton", "time left"));
  PetscFunctionReturn(0);
}

/* RunProgress - a line now and then. */
PetscErrorCode RunProgress(Run *self, PetscBool last) {
  PetscReal length = 0, time, unit;
  char left[32];

  PetscFunctionBegin;
  if (self->quiet || !GrowPaceDue(&self->pace, self->start, self->t, self->end, last, left))
    PetscFunctionReturn(0);
  for (PetscInt k = 0; k < self->n; k++) length = PetscMax(length, self->each[k].seen.length);
  (void)OptionShownIn(self->end, UNIT_TIME, &time);
  (void)OptionShownIn(length, UNIT_LENGTH, &unit);
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "%10.4f %10.4f %10.2e %7d %s\n", (double)(time * self->t),
                        (double)(unit * length), (double)(time * self->each[0].seen.step),
                        (int)self->each[0].seen.newton_iterations, left));
  PetscFunctionReturn(0);
}

/* A line for each rod. */
static PetscErrorCode TellRods(Run *self) {
  char text[4][32], name[ROD_NAME + 2];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    const Observation *seen = &self->each[k].seen;
    const ErrorEstimate *error = &self->each[k].error;
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "%s: length %s, tip (%s, %s, %s)",
                          RodsName(self->rods, k), OptionNumber(seen->length, text[0]),
                          OptionNumber(seen->tip_x1, text[1]), OptionNumber(seen->tip_x2, text[2]),
                          OptionNumber(seen->tip_x3, text[3])));
    PetscCall(PetscPrintf(PETSC_COMM_SELF, ", energy %.6e, its defect %.1e", (double)seen->energy,
                          (double)seen->energy_defect));
    if (error->kind != ESTIMATE_NONE)
      PetscCall(PetscPrintf(PETSC_COMM_SELF, ", error estimate %.1e", (double)error->end.all));
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "\n"));
    (void)snprintf(name, sizeof(name), "%s: ", RodsName(self->rods, k));
    if (self->stopped_by < 0 || self->stopped_by == k)
      PetscCall(GrowTellEvents(&self->each[k], name));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Summary(Run *self) {
  PetscInt steps, rejected, iterations;
  PetscLogDouble now;
  char text[64];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    PetscCall(GrowErrors(&self->each[k]));
    PetscCall(OutputErrors(self->output[k], &self->each[k].error));
  }
  if (self->quiet) PetscFunctionReturn(0);
  PetscCall(TSGetStepNumber(self->leg.ts, &steps));
  PetscCall(TSGetStepRejections(self->leg.ts, &rejected));
  PetscCall(TSGetSNESIterations(self->leg.ts, &iterations));
  PetscCall(PetscTime(&now));
  PetscCall(TellRods(self));
  PetscCall(PetscPrintf(PETSC_COMM_SELF,
                        "t = %s: %d rods, %d steps, %d rejected, %d Newton iterations, %.3f s",
                        OptionBoth(self->t, UNIT_TIME, text), (int)self->n, (int)steps,
                        (int)(rejected + self->counted[1]), (int)(iterations + self->counted[0]),
                        now - self->pace.begin));
  if (self->snaps)
    PetscCall(
        PetscPrintf(PETSC_COMM_SELF, "; %d snap%s", (int)self->snaps, self->snaps > 1 ? "s" : ""));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "\n"));
  if (!self->file.path[0])
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "nothing is stored; -output FILE keeps the result\n"));
  PetscFunctionReturn(0);
}

/* The rod whose fields move fastest in the latest step: what a line for a run that gave up names.
 */
static PetscInt Fastest(const Run *self) {
  PetscInt which = 0;

  for (PetscInt k = 1; k < self->n; k++)
    if (self->each[k].seen.tip_speed > self->each[which].seen.tip_speed) which = k;
  return which;
}

static PetscErrorCode Verdict(Run *self) {
  const char *const kept = self->file.path[0] ? "the results up to there are stored"
                                              : "nothing is stored without "
                                                "-output FILE";
  char t[64], step[64];
  PetscReal dt;

  PetscFunctionBegin;
  if (self->stopped_by >= 0) PetscFunctionReturn(0);
  PetscCall(TSGetTimeStep(self->leg.ts, &dt));
  OptionBoth(self->t, UNIT_TIME, t);
  OptionBoth(dt, UNIT_TIME, step);
  UserCheck(!self->stopped, PETSC_COMM_SELF, "interrupted by signal %d at t = %s; %s",
            self->stopped, t, kept);
  UserCheck(self->reason != TS_CONVERGED_ITS, PETSC_COMM_SELF,
            "-ts_max_steps: reached at t = %s before -ts_max_time; %s", t, kept);
  UserCheck(self->reason == TS_CONVERGED_TIME, PETSC_COMM_SELF,
            "gave up at t = %s with a step of %s%s; %s; rod %s moves fastest: run it alone, which "
            "tells more, or give more -rod_cells",
            t, step, self->leg.passes ? ": a rod would pass through a wall" : "", kept,
            RodsName(self->rods, Fastest(self)));
  PetscFunctionReturn(0);
}

/* RunFinish - what a run leaves that is over, and the line for an end that was not asked for.

   again  it is to be run once more, as accurate as asked for */
PetscErrorCode RunFinish(Run *self, PetscBool *again) {
  char text[2][64] = {""};

  PetscFunctionBegin;
  PetscCall(Summary(self));
  if (self->t != self->stored_shape) PetscCall(RunStoreShape(self, self->t, self->leg.U));
  if (self->stopped)
    (void)snprintf(text[0], sizeof(text[0]), "by signal %d at t = %.30s", self->stopped,
                   OptionBoth(self->t, UNIT_TIME, text[1]));
  for (PetscInt k = 0; k < self->n; k++) {
    PetscCall(OutputEvent(self->output[k], &self->each[k].event));
    PetscCall(OutputInterrupted(self->output[k], text[0]));
  }
  PetscCall(SeveralStore(&self->file, self->t,
                         (PetscBool)(self->reason == TS_CONVERGED_TIME || self->stopped_by >= 0)));
  PetscCall(Verdict(self));
  PetscCall(RunRefine(self, again));
  PetscFunctionReturn(0);
}
