/* -task grow: events located in time. */
#include "tasks/growing.h"

/* GrowLookForEvent - has an event happened in the state U of time t? U NULL: the initial shape.
   Collective. */
PetscErrorCode GrowLookForEvent(Grow *self, PetscReal t, Vec U, Event *event) {
  const Node *nodes;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(event, sizeof(*event)));
  PetscCall(ObserverGather(self->observer, self->now->rod, t, U, NULL, &nodes));
  if (nodes) PetscCall(WatchLook(&self->watch, self->observer, self->scene, t, nodes, event));
  PetscCallMPI(MPI_Bcast(event, sizeof(*event), MPI_BYTE, 0, self->scene->comm));
  PetscFunctionReturn(0);
}

/* GrowLocateEvent - if an event has happened in the step to t: finds it by bisection on the dense
   output; t, U and U_t are then those of the event. Collective. */
PetscErrorCode GrowLocateEvent(Grow *self, PetscReal *t, Vec U, Vec U_t) {
  PetscReal before = self->seen.t, low = before, end = *t;
  Event event;

  PetscFunctionBegin;
  PetscCall(GrowLookForEvent(self, *t, self->now->U, &event));
  if (event.kind == EVENT_NONE) PetscFunctionReturn(0);
  self->event = event;
  for (int k = 0; k < 60 && self->event.t - low > 4 * PETSC_MACHINE_EPSILON * end; k++) {
    PetscReal mid = (low + self->event.t) / 2;
    PetscCall(TSInterpolate(self->now->ts, mid, U));
    PetscCall(GrowLookForEvent(self, mid, U, &event));
    if (event.kind)
      self->event = event;
    else
      low = mid;
  }
  *t = self->event.t;
  PetscCall(LegInterpolate(self->now, *t, end, end - before, U, U_t));
  PetscFunctionReturn(0);
}
