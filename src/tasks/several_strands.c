/* -task grow of several rods: strands of those that may touch, for the stepper and for who looks.
 */
#include "tasks/several_run.h"
#include "rod/ask.h"
#include "stepping/vbdf.h"

/* RodsMeet() */
static PetscErrorCode Meet(void *ctx, PetscInt a, PetscInt b, StrandMeeting *how) {
  PetscFunctionBegin;
  RodsMeet((Rods)ctx, a, b, how);
  PetscFunctionReturn(0);
}

/* The node of a rod at which it is held by a joint. */
static PetscInt HeldAt(const Run *self, const Joint *joint) {
  return joint->tip ? self->scene[joint->rod]->mesh.cells : 0;
}

/* Rods do not touch near a joint, neither those that are held in one place nor what holds them. */
static PetscErrorCode JoinStrands(const Run *self, Strands strands) {
  PetscFunctionBegin;
  for (PetscInt j = 0; j < JointsCount(self->joints); j++) {
    const Joint *joint = JointsGet(self->joints, j);
    const PetscInt of[2] = {joint->rod, joint->carrier}, at[2] = {HeldAt(self, joint), joint->node};
    PetscCall(StrandsJoin(strands, of, at));
    for (PetscInt k = 0; k < j; k++) {
      const Joint *other = JointsGet(self->joints, k);
      const PetscInt both[2] = {joint->rod, other->rod}, ends[2] = {at[0], HeldAt(self, other)};
      if (other->carrier == joint->carrier && other->node == joint->node)
        PetscCall(StrandsJoin(strands, both, ends));
    }
  }
  PetscFunctionReturn(0);
}

/* RunMakeStrands - what looks for strands, if any rod can touch itself or another one. */
PetscErrorCode RunMakeStrands(Run *self) {
  PetscBool any = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++)
    if (self->scene[k]->contact.among) any = PETSC_TRUE;
  for (int i = 0; i < 2 && any; i++)
    PetscCall(StrandsCreateSeveral(self->n, self->scene, Meet, self->rods, &self->strands[i]));
  for (int i = 0; i < 2 && any; i++) PetscCall(JoinStrands(self, self->strands[i]));
  RodForget(&self->looked);
  PetscFunctionReturn(0);
}

/* Looks for strands in a state of all; U_t NULL: rates are not known. */
static PetscErrorCode LookForStrands(Run *self, PetscReal t, Vec U, Vec U_t) {
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
static PetscErrorCode LookAtTime(Run *self, PetscReal t, PetscBool moves) {
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

/* RunKnowStrands - the strands are those of a time; moves: with rates. Looked for once at a time.
 */
PetscErrorCode RunKnowStrands(Run *self, PetscReal t, PetscBool moves) {
  const RodState at = {.t = t, .U = self->U, .U_t = self->U};
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(RodRecognise(&at, &self->looked, &known));
  if (!known || self->with_rates != moves) PetscCall(LookAtTime(self, t, moves));
  self->with_rates = moves;
  PetscFunctionReturn(0);
}

/* RunTellStrands - a TouchingTell of rod k. */
PetscErrorCode RunTellStrands(void *ctx, PetscInt k, PetscReal t, PetscBool moves, StrandsOn *on) {
  Run *self = (Run *)ctx;
  const PetscInt first = 2 * StrandsFirst(self->strands[1], k);

  PetscFunctionBegin;
  PetscCall(RunKnowStrands(self, t, moves));
  StrandsSum(self->strands[1], k, &on->sum);
  on->force = StrandsForces(self->strands[1]) + first;
  on->couple = StrandsCouples(self->strands[1]) + first;
  PetscFunctionReturn(0);
}
