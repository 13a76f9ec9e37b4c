/* -task grow: how far off a run may be. */
#include "tasks/accuracy.h"
#include "tasks/growing.h"

/* A start that one step has crossed was not
   followed: it may be off by twice what that step has changed, and by no more than of_start; but
   if that is far, the rod may have left it to another side, and nothing is known. Behind
   a growth zone friction that is exact is taken for one with a beta, which moments that were laid
   down feel by its sixth root, and little else does: so much where errors are not followed (at the
   usual tolerance nothing is known). */
static const PetscReal per_change = 2, of_start = 1e-2, far = 0.5, of_limit = 40;
/* What a viscous share adds, over it: norms change by up to ten times that (LoadShareMore()),
   behind a snap by up to 20 times. */
static const PetscReal per_share = 10, per_snap = 20;

/* What two observations differ by in tip and |x2| (in space the larger one of |x2| and |x3|), over
   the later ones. */
static PetscReal Change(const Observation *from, const Observation *to) {
  const PetscReal tip[3] = {to->tip_x1 - from->tip_x1, to->tip_x2 - from->tip_x2,
                            to->tip_x3 - from->tip_x3},
                  distance = hypot(hypot(to->tip_x1, to->tip_x2), to->tip_x3),
                  norm = PetscMax(to->norm_x2, to->norm_x3);
  PetscReal change = hypot(hypot(tip[0], tip[1]), tip[2]) / PetscMax(distance, rod_vanished);

  if (norm > rod_vanished)
    change = PetscMax(change, PetscMax(PetscAbsReal(to->norm_x2 - from->norm_x2),
                                       PetscAbsReal(to->norm_x3 - from->norm_x3)) /
                                  norm);
  return change;
}

/* How far a jump, whose own error is not known, may be off. */
static PetscReal Crossed(const Observation *from, const Observation *to) {
  const PetscReal change = Change(from, to);
  return change > far ? 1 : PetscMin(of_start, per_change * change);
}

/*
  GrowCross - counts a blind jump to what is seen now: does it cross the start? The steps that cross
  the layer of a start see nothing between their ends, however short they are: if they have led far,
  all of them together, nothing is known either.

  last      seen before it, at that time     layered  it is in the layer
*/
void GrowCross(Grow *self, const Observation *last, PetscReal before, PetscBool layered) {
  if (layered) {
    if (!self->layered) self->began = *last;
    self->layered = PETSC_TRUE;
    if (Change(&self->began, &self->seen) > far) self->crossed = 1;
  } else if (before <= self->seen.t / 2) {
    self->crossings++;
    self->crossed += Crossed(last, &self->seen);
  }
}

/* GrowKeepErrors - for a restart: what the errors beside those that are followed come from. */
void GrowKeepErrors(const Grow *self, PetscReal kept[RESTART_BESIDE]) {
  kept[0] = (PetscReal)self->snaps;
  kept[1] = (PetscReal)self->crossings;
  kept[2] = self->crossed;
  kept[3] = self->vanished ? 1 : 0;
  kept[4] = self->depth;
  kept[5] = self->energy_folds;
  kept[6] = self->weighed;
  kept[7] = self->gave_way ? 1 : 0;
  kept[8] = self->pressed ? 1 : 0;
  kept[9] = (PetscReal)self->blind;
  kept[10] = self->layered ? 1 : 0;
}

/* GrowTakeErrors - goes on with that. */
void GrowTakeErrors(Grow *self, const PetscReal kept[RESTART_BESIDE]) {
  self->snaps = (PetscInt)kept[0];
  self->crossings = (PetscInt)kept[1];
  self->crossed = kept[2];
  self->vanished = (PetscBool)(kept[3] != 0);
  self->depth = kept[4];
  self->energy_folds = kept[5];
  self->weighed = kept[6];
  self->gave_way = (PetscBool)(kept[7] != 0);
  self->pressed = (PetscBool)(kept[8] != 0);
  self->blind = (PetscInt)kept[9];
  self->layered = (PetscBool)(kept[10] != 0);
}

/* What comes beside the errors of mesh and steps, in each of what is seen. */
static PetscReal Beside(const Grow *self) {
  const Load *load = &self->scene->load;
  PetscReal error = self->neglected + self->crossed;

  if (load->shared) error += per_share * load->friction.viscous;
  if (!load->shared && self->snaps > self->crossings)
    error += per_snap * load->friction.least * self->scene->units.speed;
  return self->vanished ? error + 1 : error;
}

/*
  GrowErrors - finds how far off the run may be so far: as measured, or by a fit where errors are
  not followed. Of other steppers than vbdf nothing is known. Collective.
*/
PetscErrorCode GrowErrors(Grow *self) {
  const Load *load = &self->scene->load;
  ErrorEstimate *error = &self->error;
  PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN] = {{0}}, fitted, beside = Beside(self);
  PetscBool vbdf;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(error, sizeof(*error)));
  PetscCall(PetscObjectTypeCompare((PetscObject)self->now->ts, TSVBDF, &vbdf));
  if (!vbdf) PetscFunctionReturn(0);
  error->kind = (self->model == FRAME || self->model == SPACE) && self->estimate ? ESTIMATE_MEASURED
                                                                                 : ESTIMATE_FITTED;
  if (self->estimate) PetscCall(EstimateTold(self->estimate, worst));
  if (error->kind == ESTIMATE_FITTED) {
    PetscCall(AccuracyEstimate(self->now->rod, self->seen.t, self->rtol,
                               PetscMax(self->folds, self->energy_folds / 2), self->weighed,
                               (PetscBool)(self->energy_folds > 0), &fitted));
    beside += fitted;
    if (load->limit && !self->estimate)
      beside += of_limit * PetscPowReal(load->friction.beta, 1. / 6);
  }
  AccuracyMeasured(self->estimate ? self->rtol : 0, worst, beside, error);
  PetscFunctionReturn(0);
}
