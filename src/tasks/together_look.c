/* -task grow of several rods: what is seen of them behind a step, and stored. */
#include "tasks/together.h"
#include "rod/ask.h"
#include "stepping/vbdf.h"

/* Looks for strands in a state of all; U_t NULL: rates are not known. */
static PetscErrorCode LookForStrands(Together *self, PetscReal t, Vec U, Vec U_t) {
  StrandState state = {.t = t, .stride = self->leg.rod->model->fields};

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(U, &state.u));
  if (U_t) PetscCall(VecGetArrayRead(U_t, &state.u_t));
  PetscCall(StrandsSearch(self->strands[1], &state));
  PetscCall(StrandsLoad(self->strands[1], &state));
  if (U_t) PetscCall(VecRestoreArrayRead(U_t, &state.u_t));
  PetscCall(VecRestoreArrayRead(U, &state.u));
  PetscFunctionReturn(0);
}

/* ... at a time: that which has been come to, or one within the latest step, where the state is by
   the stepper's dense output. */
static PetscErrorCode LookAtTime(Together *self, PetscReal t, PetscBool moves) {
  PetscBool known;
  Vec U, U_t;

  PetscFunctionBegin;
  if (t == self->t) {
    PetscCall(LookForStrands(self, t, self->U, moves ? self->U_t : NULL));
    PetscFunctionReturn(0);
  }
  PetscCall(DMGetGlobalVector(self->leg.rod->da, &U));
  PetscCall(DMGetGlobalVector(self->leg.rod->da, &U_t));
  PetscCall(VBDFInterpolate(self->leg.ts, t, U, U_t, &known));
  if (!known) PetscCall(TSInterpolate(self->leg.ts, t, U));
  PetscCall(LookForStrands(self, t, U, moves && known ? U_t : NULL));
  PetscCall(DMRestoreGlobalVector(self->leg.rod->da, &U_t));
  PetscCall(DMRestoreGlobalVector(self->leg.rod->da, &U));
  PetscFunctionReturn(0);
}

/* TogetherStrands - the strands are those of a time; moves: with rates. Looked for once at a time.
 */
PetscErrorCode TogetherStrands(Together *self, PetscReal t, PetscBool moves) {
  const RodState at = {.t = t, .U = self->U, .U_t = self->U};
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(RodRecognise(&at, &self->looked, &known));
  if (!known || self->with_rates != moves) PetscCall(LookAtTime(self, t, moves));
  self->with_rates = moves;
  PetscFunctionReturn(0);
}

/* TogetherTellStrands - a TouchingTell of rod k. */
PetscErrorCode TogetherTellStrands(void *ctx, PetscInt k, PetscReal t, PetscBool moves,
                                   StrandsOn *on) {
  Together *self = (Together *)ctx;
  const PetscInt first = 2 * StrandsFirst(self->strands[1], k);

  PetscFunctionBegin;
  PetscCall(TogetherStrands(self, t, moves));
  StrandsSum(self->strands[1], k, &on->sum);
  on->force = StrandsForces(self->strands[1]) + first;
  on->couple = StrandsCouples(self->strands[1]) + first;
  PetscFunctionReturn(0);
}

/* TogetherEase - the tolerance of all is the finest of theirs, and each has its own: what contact
   puts one off by says nothing of one that is free. */
void TogetherEase(Together *self, PetscReal finest) {
  self->leg.ease.times = finest;
  for (PetscInt k = 0; k < self->n; k++)
    self->leg.of[k].eased = self->each[k].now->ease.times / finest;
}

/* The errors of rods that hold each other go on. */
static PetscErrorCode FollowErrors(Together *self) {
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
static PetscErrorCode TakeGives(Together *self, PetscReal t) {
  StrandSum on;

  PetscFunctionBegin;
  if (!self->strands[1]) PetscFunctionReturn(0);
  PetscCall(TogetherStrands(self, t, PETSC_TRUE));
  for (PetscInt k = 0; k < self->n; k++) {
    StrandsSum(self->strands[1], k, &on);
    EstimateGives(self->each[k].estimate, on.gives);
  }
  PetscFunctionReturn(0);
}

/* TogetherLook - looks at all rods in the state that was come to, at a time; begins: as they begin.
 */
PetscErrorCode TogetherLook(Together *self, PetscReal t, PetscBool begins) {
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
  TogetherEase(self, times);
  PetscFunctionReturn(0);
}

/* TogetherShape - stores the shapes of a state of all; U NULL: as they begin. */
PetscErrorCode TogetherShape(Together *self, PetscReal t, Vec U) {
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
  PetscCall(TogetherStrands(self, t, (PetscBool)(t > 0)));
  PetscCall(StrandsPlaces(self->strands[1], &n, &place));
  PetscCall(SeveralTouch(&self->file, n, place));
  PetscCall(PetscFree(place));
  PetscFunctionReturn(0);
}

/* TogetherDue - stores those that are due between the previous step and this one, by the stepper's
   dense output. */
PetscErrorCode TogetherDue(Together *self, PetscReal t) {
  Vec W;

  PetscFunctionBegin;
  for (; self->next_output <= t * (1 + 1e-14); self->next_output += self->interval) {
    if (self->next_output >= t * (1 - 1e-12)) {
      PetscCall(TogetherShape(self, t, self->U));
      continue;
    }
    PetscCall(VecDuplicate(self->leg.U, &W));
    PetscCall(TSInterpolate(self->leg.ts, self->next_output, W));
    PetscCall(TogetherShape(self, self->next_output, W));
    PetscCall(VecDestroy(&W));
  }
  PetscFunctionReturn(0);
}

/* TogetherShare - dry friction that does not say how fast rods snap has a viscous share from here
   on; again: or a larger one. Does any? */
PetscBool TogetherShare(Together *self, PetscBool again) {
  PetscBool more = PETSC_FALSE;

  for (PetscInt k = 0; k < self->n; k++) {
    Load *load = &self->scene[k]->load;
    if (again ? !LoadMaySlip(load) : load->shared) continue;
    if (LoadShareMore(load)) more = PETSC_TRUE;
  }
  return more;
}
