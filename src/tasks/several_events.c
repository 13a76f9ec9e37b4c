/* -task grow of several rods: events, of any of them, located in time. */
#include "tasks/several_run.h"
#include "rod/ask.h"

static PetscBool Watches(const Run *self) {
  for (PetscInt k = 0; k < self->n; k++)
    if (self->each[k].watch.any) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Has an event happened to any rod in a state of all, at a time? U NULL: as they begin.

   which  the rod; -1: to none */
static PetscErrorCode LookForEvent(Run *self, PetscReal t, Vec U, Event *event, PetscInt *which) {
  Vec part = NULL;

  PetscFunctionBegin;
  *which = -1;
  self->t = t;
  self->U = U ? U : self->leg.U;
  for (PetscInt k = 0; k < self->n && *which < 0; k++) {
    if (!self->each[k].watch.any) continue;
    if (U) PetscCall(RodPartOpenRead(self->leg.rod, k, U, &part));
    PetscCall(GrowLookForEvent(&self->each[k], t, part, event));
    if (U) PetscCall(RodPartCloseRead(self->leg.rod, k, U, &part));
    if (event->kind) *which = k;
  }
  PetscFunctionReturn(0);
}

/* RunRefuseEvents - refuses what ends the run where it begins, or goes on. */
PetscErrorCode RunRefuseEvents(Run *self) {
  PetscInt which;
  char text[64];
  Event event;

  PetscFunctionBegin;
  PetscCall(LookForEvent(self, self->t, self->t > 0 ? self->leg.U : NULL, &event, &which));
  if (which < 0) PetscFunctionReturn(0);
  PetscCall(RodsEnter(self->rods, which));
  UserCheck(PETSC_FALSE, OptionsComm(), "-stop_%s: it is so at t = %s already, where the run %s",
            event_name[event.kind], OptionBoth(self->t, UNIT_TIME, text),
            self->restart[0] ? "goes on" : "begins");
  PetscFunctionReturn(0);
}

/*
  RunLocateEvent - if an event has happened to a rod in the step to t: finds the first one by
  bisection on the dense output; t and the state that was come to are then those of the event.
*/
PetscErrorCode RunLocateEvent(Run *self, PetscReal *t) {
  PetscReal low = self->t, end = *t, high = end;
  const PetscReal before = low;
  PetscInt which;
  Event event;

  PetscFunctionBegin;
  if (!Watches(self)) PetscFunctionReturn(0);
  PetscCall(LookForEvent(self, end, self->leg.U, &event, &which));
  if (which < 0) PetscFunctionReturn(0);
  for (int i = 0; i < 2; i++) {
    PetscCall(VecDestroy(&self->here[i]));
    PetscCall(VecDuplicate(self->leg.U, &self->here[i]));
  }
  while (which >= 0) { /* the latest that was found, until none is before it */
    self->stopped_by = which;
    self->each[which].event = event;
    high = event.t;
    for (which = -1; which < 0 && high - low > 4 * PETSC_MACHINE_EPSILON * end;) {
      const PetscReal mid = (low + high) / 2;
      PetscCall(TSInterpolate(self->leg.ts, mid, self->here[0]));
      PetscCall(LookForEvent(self, mid, self->here[0], &event, &which));
      if (which < 0) low = mid;
    }
    if (which >= 0 && which != self->stopped_by)
      self->each[self->stopped_by].event.kind = EVENT_NONE;
  }
  *t = high;
  PetscCall(LegInterpolate(&self->leg, high, end, end - before, self->here[0], self->here[1]));
  self->U = self->here[0];
  self->U_t = self->here[1];
  PetscFunctionReturn(0);
}

/* RunEndHere - the run ends in the state of its event, which has been looked at. */
PetscErrorCode RunEndHere(Run *self) {
  PetscFunctionBegin;
  PetscCall(VecCopy(self->here[0], self->leg.U));
  PetscCall(TSSetConvergedReason(self->leg.ts, TS_CONVERGED_USER));
  PetscFunctionReturn(0);
}
