/* -task sweep: what is printed, by rank 0. */
#include "tasks/sweeping.h"
#include <petsctime.h>

/* SweepHeading - above the lines of progress. Collective. */
PetscErrorCode SweepHeading(Sweep *self) {
  PetscInt n = TableRows(self->table);
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCall(PetscTime(&self->begin));
  self->report_after = 1;
  self->reported = self->done;
  self->report_at = self->done + n / 10;
  if (self->quiet) PetscFunctionReturn(0);
  PetscCallMPI(MPI_Comm_size(OptionsComm(), &ranks));
  if (self->done)
    PetscCall(PetscPrintf(OptionsComm(), "%d of %d runs are in %s already\n", (int)self->done,
                          (int)n, self->output));
  if (self->done < n)
    PetscCall(PetscPrintf(OptionsComm(), "%d runs, %d at a time\n%10s %10s %10s %11s\n",
                          (int)(n - self->done), (int)(ranks / self->each), "run", "failed",
                          "seconds", "time left"));
  PetscFunctionReturn(0);
}

/* SweepProgress - a line every tenth of the members, and now and then, ever more rarely. On rank 0;
   not collective. */
PetscErrorCode SweepProgress(Sweep *self) {
  PetscInt n = TableRows(self->table);
  PetscLogDouble now;

  PetscFunctionBegin;
  if (self->quiet) PetscFunctionReturn(0);
  PetscCall(PetscTime(&now));
  now -= self->begin;
  if (self->done == self->reported || self->done == n ||
      (now < self->report_after && self->done < self->report_at))
    PetscFunctionReturn(0);
  self->reported = self->done;
  self->report_after = now + PetscMin(60, PetscMax(1, now / 10));
  self->report_at = PetscMax(self->done, self->report_at) + PetscMax(1, n / 10);
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "%10d %10d %10.1f %9.0f s\n", (int)self->done,
                        (int)(self->failed + self->failed_before), now,
                        now * (double)(n - self->done) / (double)self->ran));
  PetscFunctionReturn(0);
}

/* SweepSummary - the last words. Collective. */
PetscErrorCode SweepSummary(Sweep *self) {
  PetscInt failed = self->failed + self->failed_before, n = TableRows(self->table);
  PetscLogDouble now;

  PetscFunctionBegin;
  if (self->quiet) PetscFunctionReturn(0);
  PetscCall(PetscTime(&now));
  PetscCall(PetscPrintf(OptionsComm(), "%d runs: %d finished, %d failed; %.1f s\n", (int)n,
                        (int)(n - failed), (int)failed, now - self->begin));
  if (self->failed)
    PetscCall(PetscPrintf(OptionsComm(), "run %d failed: %s\n", (int)self->first_member + 1,
                          self->first));
  PetscFunctionReturn(0);
}
