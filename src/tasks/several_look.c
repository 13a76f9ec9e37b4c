/* -task grow of several rods: what is seen of them behind a step, and stored. */
#include "tasks/several_run.h"
#include "rod/ask.h"
#include "stepping/vbdf.h"

/* RunEaseEach - the tolerance of all is the finest of theirs, and each has its own: what contact
   puts one off by says nothing of one that is free. */
void RunEaseEach(Run *self, PetscReal finest) {
  self->leg.ease.times = finest;
  for (PetscInt k = 0; k < self->n; k++)
    self->leg.of[k].eased = self->each[k].now->ease.times / finest;
}

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

/* RunLook - looks at all rods in the state that was come to, at a time; begins: as they begin.
 */
PetscErrorCode RunLook(Run *self, PetscReal t, PetscBool begins) {
  PetscReal times = PETSC_MAX_REAL;
  Vec U = NULL, U_t = NULL;

  PetscFunctionBegin;
  self->t = t;
  if (!begins) PetscCall(TakeGives(self, t));
  if (!begins) PetscCall(FollowErrors(self));
  for (PetscInt k = 0; k < self->n; k++) {
    Grow *grow = &self->each[k];
    Leg *leg = grow->now;
    PetscCall(LegPartFollow(leg));
    if (!begins) PetscCall(RodPartOpenRead(self->leg.rod, k, self->U, &U));
    if (!begins) PetscCall(RodPartOpenRead(self->leg.rod, k, self->U_t, &U_t));
    PetscCall(GrowObserve(grow, t, U, U_t));
    if (!begins) PetscCall(RodPartCloseRead(self->leg.rod, k, self->U_t, &U_t));
    if (!begins) PetscCall(RodPartCloseRead(self->leg.rod, k, self->U, &U));
    times = PetscMin(times, leg->ease.times);
  }
  RunEaseEach(self, times);
  PetscFunctionReturn(0);
}

/* RunStoreShape - stores the shapes of a state of all; U NULL: as they begin. */
PetscErrorCode RunStoreShape(Run *self, PetscReal t, Vec U) {
  StrandPlace *place;
  Vec part = NULL;
  PetscInt n;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    if (U) PetscCall(RodPartOpenRead(self->leg.rod, k, U, &part));
    PetscCall(GrowStoreShape(&self->each[k], t, part));
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

/* RunStoreDue - stores those that are due between the previous step and this one, by the stepper's
   dense output. */
PetscErrorCode RunStoreDue(Run *self, PetscReal t) {
  Vec W;

  PetscFunctionBegin;
  for (; self->next_output <= t * (1 + 1e-14); self->next_output += self->interval) {
    if (self->next_output >= t * (1 - 1e-12)) {
      PetscCall(RunStoreShape(self, t, self->U));
      continue;
    }
    PetscCall(VecDuplicate(self->leg.U, &W));
    PetscCall(TSInterpolate(self->leg.ts, self->next_output, W));
    PetscCall(RunStoreShape(self, self->next_output, W));
    PetscCall(VecDestroy(&W));
  }
  PetscFunctionReturn(0);
}

/* RunShareMore - dry friction that does not say how fast rods snap has a viscous share from here
   on; again: or a larger one. Does any? */
PetscBool RunShareMore(Run *self, PetscBool again) {
  PetscBool more = PETSC_FALSE;

  for (PetscInt k = 0; k < self->n; k++) {
    Load *load = &self->scene[k]->load;
    if (again ? !LoadMaySlip(load) : load->shared) continue;
    if (LoadShareMore(load)) more = PETSC_TRUE;
  }
  return more;
}
