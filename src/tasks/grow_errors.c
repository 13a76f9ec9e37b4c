/* -task grow: how far off a run may be. */
#include "tasks/accuracy.h"
#include "tasks/growing.h"
#include "rod/ask.h"
#include "rod/learned.h"
#include "rod/rules.h"
#include "tasks/grow_rules.h"

/* What two observations differ by in tip and |x2| (in space the larger one of |x2| and |x3|), over
   a size: of the tip's distance, and of |x2|. */
static PetscReal Differ(const Observation *from, const Observation *to, const PetscReal size[2]) {
  const PetscReal tip[3] = {to->tip_x1 - from->tip_x1, to->tip_x2 - from->tip_x2,
                            to->tip_x3 - from->tip_x3};
  PetscReal change = hypot(hypot(tip[0], tip[1]), tip[2]) / PetscMax(size[0], rod_rule.vanished);

  if (size[1] > rod_rule.vanished)
    change = PetscMax(change, PetscMax(PetscAbsReal(to->norm_x2 - from->norm_x2),
                                       PetscAbsReal(to->norm_x3 - from->norm_x3)) /
                                  size[1]);
  return change;
}

/* ... over the later ones. */
static PetscReal Change(const Observation *from, const Observation *to) {
  const PetscReal size[2] = {hypot(hypot(to->tip_x1, to->tip_x2), to->tip_x3),
                             PetscMax(to->norm_x2, to->norm_x3)};
  return Differ(from, to, size);
}

/* Is that so far that the rod may have left to another side? Not if it is so as part of an |x2|
   next to nothing alone while bending gives energy away: a rod that is bent by nature, and was laid
   straight, goes where it is bent to. */
static PetscBool IsFar(const Observation *from, const Observation *to) {
  const PetscReal length[2] = {to->length, to->length};

  if (Change(from, to) <= grow_rule.start_unknown) return PETSC_FALSE;
  return (PetscBool)(Differ(from, to, length) > grow_rule.start_unknown ||
                     to->energy >= from->energy);
}

/* How far a jump, whose own error is not known, may be off. */
static PetscReal Crossed(const Observation *from, const Observation *to) {
  return IsFar(from, to)
             ? 1
             : PetscMin(grow_rule.start_error_most, grow_rule.start_error * Change(from, to));
}

/*
  GrowCross - counts an unresolved jump to what is seen now: does it cross the start? The steps that
  cross the layer of a start see nothing between their ends, however short they are: if they have
  led far, all of them together, nothing is known either.

  last      seen before it, at that time     layered  it is in the layer
*/
void GrowCross(Grow *self, const Observation *last, PetscReal before, PetscBool layered) {
  if (layered) {
    if (!self->kept.layered) self->kept.began = *last;
    self->kept.layered = PETSC_TRUE;
    if (IsFar(&self->kept.began, &self->seen)) self->kept.crossed = 1;
  } else if (before <= self->seen.t / 2) {
    self->kept.crossings++;
    self->kept.crossed += Crossed(last, &self->seen);
  }
}

/* What comes beside the errors of mesh and steps, in each of what is seen. */
static PetscReal Beside(const Grow *self) {
  const Load *load = &self->scene->load;
  PetscReal error = self->kept.neglected + self->kept.crossed;

  if (load->shared) error += grow_rule.share_error * load->friction.viscous;
  if (!load->shared && self->kept.snaps > self->kept.crossings)
    error += grow_rule.share_error_of_jump * load->friction.least * self->scene->units.speed;
  return self->kept.vanished ? error + 1 : error;
}

/* Do strands of the rod touch each other, in space; has what it learns a front, where it is fed? */
static PetscReal Beyond(const Grow *self) {
  const Rod rod = self->now->rod;
  const PetscBool strands =
      (PetscBool)(self->model == SPACE && self->kept.pressed > 0 && RodMeetsStrands(rod));

  return AccuracyBeyond(strands, LearnedFront(rod));
}

/* What the steps leave at least: each field is followed to the tolerance of its own size, and the
   tip of a rod next to straight is where its length has it; one that is held is there. */
static void Least(const Grow *self, PetscReal least[ESTIMATE_SEEN]) {
  const Observation *seen = &self->seen;
  const PetscReal distance = hypot(hypot(seen->tip_x1, seen->tip_x2), seen->tip_x3),
                  across = PetscMax(seen->norm_x2, seen->norm_x3);

  for (int k = 0; k < ESTIMATE_SEEN; k++)
    least[k] = self->estimate ? self->now->ease.times * self->rtol : 0;
  least[ESTIMATE_TIP] *=
      PetscMax(grow_rule.tip_least, PetscMin(1, across / PetscMax(distance, rod_rule.vanished)));
  if (self->scene->tip.type != TIP_FREE && self->scene->tip.type != TIP_CARRIED)
    least[ESTIMATE_TIP] = 0;
}

/* GrowFollowsErrors - are errors followed over all of the run? */
PetscBool GrowFollowsErrors(const Grow *self) {
  TSType type;

  if (!self->estimate || (self->model != FRAME && self->model != SPACE)) return PETSC_FALSE;
  return (PetscBool)(!TSGetType(self->leg[self->model].ts, &type) && !strcmp(type, TSVBDF));
}

/* What happens to the rod at the latest step that makes errors large for a while; 0: nothing. */
static int Happens(const Grow *self, const Observation *last, PetscBool jumped) {
  const Observation *seen = &self->seen;
  const PetscReal speed = PetscMax(seen->tip_speed, seen->mid_speed);

  if (jumped || grow_rule.jumps_within * seen->t * speed > seen->length) return WHY_SNAP;
  if (seen->contacts > last->contacts) return WHY_TOUCH;
  return seen->contacts < last->contacts ? WHY_LETS_GO : 0;
}

/* Has something happened to the rod just before? */
static PetscBool Happened(const Grow *self) {
  const PetscReal t = self->seen.t;

  return (PetscBool)(self->kept.event_is && t - self->kept.event_at <= grow_rule.reason_within * t);
}

/* What makes an error: what happened just before, else the largest part. */
static int Reason(const Grow *self, const PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN], int k) {
  int most = 0;

  if (Happened(self)) return (int)self->kept.event_is;
  for (int i = 1; i < ESTIMATE_PARTS; i++)
    if (AccuracyTimes(i) * part[i][k] > AccuracyTimes(most) * part[most][k]) most = i;
  return most;
}

/*
  LookForSide - has an error of 1 grown from next to nothing while nothing has happened to the rod?
  A mode that grows does that. Its errors are larger by then than what it has moved itself, so they
  say to which side the rod goes; it comes to rest there, and the errors that are carried along
  fade, as if nothing had been. (A touch or a snap that comes a little too soon makes errors as
  large, but those fade for good; and of |x2| alone they say nothing: a rod that is held straight at
  both ends leaves round-off across.) So what is reported later is not less than these.
*/
static void LookForSide(Grow *self, const PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN],
                        const PetscReal off[ESTIMATE_SEEN], PetscBool happens) {
  Astray *astray = &self->kept.astray;
  const PetscReal t = self->seen.t;
  const PetscBool explained = Happened(self);
  int all = 0; /* how much of what is seen is no longer known */

  for (int k = 0; k < ESTIMATE_SEEN; k++) all += off[k] >= 1;
  for (int k = 0; k < ESTIMATE_SEEN; k++) {
    const PetscBool goes =
        (PetscBool)(!explained && all > 1 && !EstimateIsEarly(self->estimate, t, k) &&
                    off[k] >= 1 && off[k] >= grow_rule.reason_grown * astray->before[1][k]);
    if (happens && astray->at[k] > 0 && t - astray->at[k] <= grow_rule.reason_at_once * t)
      astray->at[k] = 0;
    if (goes && astray->at[k] == 0) astray->at[k] = t;
    for (int i = 0; i < ESTIMATE_PARTS; i++)
      if (astray->at[k] == 0)
        astray->part[i][k] = 0;
      else if (goes)
        astray->part[i][k] = PetscMax(astray->part[i][k], part[i][k]);
  }
  if (t < 2 * astray->mark[0]) return;
  astray->mark[1] = astray->mark[0];
  astray->mark[0] = t;
  for (int k = 0; k < ESTIMATE_SEEN; k++) {
    astray->before[1][k] = astray->before[0][k];
    astray->before[0][k] = off[k];
  }
}

/* The errors of the latest state; by then it may have gone to another side. */
static void Latest(const Grow *self, PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN],
                   PetscReal change[RIGID_VALUES]) {
  EstimateLatest(self->estimate, part, change);
  for (int i = 0; i < ESTIMATE_PARTS; i++)
    for (int k = 0; k < ESTIMATE_SEEN; k++)
      part[i][k] = PetscMax(part[i][k], self->kept.astray.part[i][k]);
}

/*
  GrowFollowErrors - how far off the latest state may be, as part of what is seen of it. The largest
  is kept with its time and its reason; what happens just behind it is the reason, too, for where
  something comes a little sooner or later errors are large on either side.

  last  the state before     jumped  it was a jump
*/
void GrowFollowErrors(Grow *self, const Observation *last, PetscBool jumped) {
  PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN], least[ESTIMATE_SEEN], t = self->seen.t;
  ErrorEstimate *error = &self->error;
  int happens;

  if (!GrowFollowsErrors(self) || t == 0) return;
  happens = Happens(self, last, jumped);
  if (happens) self->kept.event_at = t;
  if (happens) self->kept.event_is = happens;
  Least(self, least);
  EstimateLatest(self->estimate, part, NULL);
  AccuracyMeasured(least, part, Beside(self), Beyond(self), &error->end);
  LookForSide(self, part, error->end.seen, (PetscBool)happens);
  Latest(self, part, NULL);
  AccuracyMeasured(least, part, Beside(self), Beyond(self), &error->end);
  self->seen.error_tip = error->end.seen[ESTIMATE_TIP];
  self->seen.error_norm_x2 = error->end.seen[ESTIMATE_NORM];
  self->seen.error_energy = error->end.seen[ESTIMATE_ENERGY];
  for (int k = 0; k < ESTIMATE_SEEN; k++) {
    WorstError *worst = &self->kept.worst[k];
    if (happens && worst->why < ESTIMATE_PARTS && t - worst->at <= grow_rule.reason_within * t)
      worst->why = happens;
    if (EstimateIsEarly(self->estimate, t, k) || error->end.seen[k] <= worst->error) continue;
    *worst = (WorstError){error->end.seen[k], t, Reason(self, part, k)};
  }
}

/* Where the tip would be, and what the energy, in rigid contact, to first order. */
static void Rigid(const Grow *self, const PetscReal change[RIGID_VALUES],
                  PetscReal rigid[RIGID_VALUES]) {
  PetscReal off[3];

  SceneToLab(self->scene, change + RIGID_TIP, off);
  rigid[RIGID_TIP] = self->seen.tip_x1 + grow_rule.to_rigid * off[0];
  rigid[RIGID_TIP + 1] = self->seen.tip_x2 + grow_rule.to_rigid * off[1];
  rigid[RIGID_TIP + 2] = self->seen.tip_x3 + grow_rule.to_rigid * off[2];
  rigid[RIGID_ENERGY] = self->seen.energy + grow_rule.to_rigid * change[RIGID_ENERGY];
}

/* Of the errors that were followed: the largest of all, and of each part. Of a run that has not got
   beyond its start, those of that. */
static PetscErrorCode Measure(Grow *self) {
  PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN], change[RIGID_VALUES], least[ESTIMATE_SEEN];
  ErrorEstimate *error = &self->error;

  PetscFunctionBegin;
  Least(self, least);
  PetscCall(EstimateReported(self->estimate, part));
  AccuracyMeasured(least, part, Beside(self), Beyond(self), &error->most);
  for (int k = 0; k < ESTIMATE_SEEN; k++) {
    const WorstError *worst = &self->kept.worst[k];
    if (worst->error > 0) error->most.seen[k] = worst->error;
    error->when[k] = worst->at;
    error->why[k] = (int)worst->why;
  }
  Latest(self, part, change);
  AccuracyMeasured(least, part, Beside(self), Beyond(self), &error->end);
  error->most.all = error->end.all = 0;
  for (int k = 0; k < ESTIMATE_SEEN; k++) {
    error->most.all = PetscMax(error->most.all, error->most.seen[k]);
    error->end.all = PetscMax(error->end.all, error->end.seen[k]);
  }
  error->pressed = self->kept.pressed;
  Rigid(self, change, error->rigid);
  PetscFunctionReturn(0);
}

/*
  GrowErrors - finds how far off the run may be so far: as measured, or by a fit where errors are
  not followed. Of other steppers than vbdf nothing is known. Collective.
*/
PetscErrorCode GrowErrors(Grow *self) {
  const Load *load = &self->scene->load;
  PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN] = {{0}}, least[ESTIMATE_SEEN], fitted,
            beside = Beside(self);
  PetscBool vbdf;

  PetscFunctionBegin;
  self->error.kind = ESTIMATE_NONE;
  PetscCall(PetscObjectTypeCompare((PetscObject)self->now->ts, TSVBDF, &vbdf));
  if (!vbdf) PetscFunctionReturn(0);
  self->error.kind = GrowFollowsErrors(self) ? ESTIMATE_MEASURED : ESTIMATE_FITTED;
  if (self->error.kind == ESTIMATE_MEASURED) {
    PetscCall(Measure(self));
    PetscFunctionReturn(0);
  }
  if (self->estimate) PetscCall(EstimateReported(self->estimate, worst));
  PetscCall(AccuracyEstimate(self->now->rod, self->seen.t, self->rtol,
                             PetscMax(self->kept.folds, self->kept.energy_folds / 2),
                             self->kept.weighed, (PetscBool)(self->kept.energy_folds > 0),
                             &fitted));
  beside += fitted;
  if (load->limit && !self->estimate)
    beside += grow_rule.beta_error * PetscPowReal(load->friction.beta, 1. / 6);
  Least(self, least);
  AccuracyMeasured(least, worst, beside, Beyond(self), &self->error.most);
  self->error.most.all = beside;
  for (int k = 0; k < ESTIMATE_PARTS; k++) self->error.most.all += self->error.most.part[k];
  self->error.end = self->error.most;
  PetscFunctionReturn(0);
}
