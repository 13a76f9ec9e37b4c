/* What errors make of what is seen of a rod: tip, |x2|, energy; what of it is reported. */
#include "stepping/estimating.h"

/* Of an error over what it is an error of, where that is not. */
static const PetscReal unknown = -1;

/* The least angle that counts as a bend, where errors are parts of one. */
static PetscReal LeastBend(const Estimate self) {
  return self->touches ? step_rule.bend_in_contact : 0;
}

/* What an error makes of |x2|, and of |x3| in space, over the larger one, or that of a slope as
   small as counts; none: the rod is straight. */
static PetscReal SeeNorm(const Estimate self, PetscReal length, const PetscReal *e) {
  const PetscReal *s = self->rod->s, *u = self->all.u;
  const PetscInt last = self->nodes - 1, fields = self->fields;
  const PetscReal least = PetscMax(
      rod_rule.vanished, step_rule.steering_at_first * RodSteeredTo(self->rod) * length * length);
  PetscReal norm[MIRRORS] = {0}, by[MIRRORS] = {0}, size = least, most, off = 0;

  for (PetscInt k = 0; k <= last; k++)
    for (PetscInt d = 1; d <= self->mirrors; d++)
      size = PetscMax(size, PetscAbsReal(u[k * fields + d]));
  if (size == least) return unknown;
  for (PetscInt k = 0; k <= last; k++)
    for (PetscInt d = 0; d < self->mirrors; d++) {
      const PetscReal w = (s[PetscMin(k + 1, last)] - s[PetscMax(k - 1, 0)]) / 2,
                      y = u[k * fields + 1 + d] / size;
      norm[d] += w * y * y;
      by[d] += w * y * (e[k * fields + 1 + d] / size);
    }
  most = PetscMax(PetscMax(norm[0], norm[1]), PetscSqr(LeastBend(self) * length / size) / 3);
  for (int d = 0; d < MIRRORS; d++)
    if (norm[d] > 0) off = PetscMax(off, PetscAbsReal(by[d]) / PetscSqrtReal(norm[d] * most));
  return off;
}

/* What an error makes of the energy: change, and seen, over it, or that of an arc as small as
   counts; none: there is none. */
static PetscErrorCode SeeEnergy(const Estimate self, PetscReal t, const PetscReal *e,
                                PetscReal *seen, PetscReal *change) {
  const PetscReal *s = self->rod->s;
  const PetscInt last = self->nodes - 1, fields = self->fields,
                 moments = self->model->space ? 3 : 1;
  PetscReal energy = 0, by = 0, size = rod_rule.vanished, length;

  PetscFunctionBegin;
  *change = 0;
  for (PetscInt k = 0; k <= last; k++)
    for (PetscInt d = 0; d < moments; d++)
      size = PetscMax(size, PetscAbsReal(self->all.u[k * fields + self->left + d]));
  for (PetscInt k = 0; k <= last; k++) {
    PetscReal w = (s[PetscMin(k + 1, last)] - s[PetscMax(k - 1, 0)]) / 2, g, S[3], m[3], dm[3];
    PetscCall(RodStiffnessAt(self->rod, k, t, &g, S));
    self->model->moments(self->all.u + k * fields, e + k * fields, m, dm);
    for (PetscInt d = 0; d < moments; d++) {
      energy += w * g / S[d] * PetscSqr(m[d] / size);
      by += 2 * w * g / S[d] * (m[d] / size) * (dm[d] / size);
    }
  }
  PetscCall(RodLength(self->rod, t, &length));
  if (size == rod_rule.vanished ||
      energy / 2 * size * size <
          PetscMax(RodRounding(self->rod, length),
                   step_rule.steering_at_first * PetscSqr(RodSteeredTo(self->rod)) * length)) {
    *seen = unknown;
    PetscFunctionReturn(0);
  }
  *seen = PetscAbsReal(by) / PetscMax(energy, PetscSqr(LeastBend(self) / size) / length);
  *change = by / 2 * size * size;
  PetscFunctionReturn(0);
}

/* EstimateSee - what an error makes of tip, |x2| and energy, relative; of tip and energy as it is,
   too. */
PetscErrorCode EstimateSee(const Estimate self, PetscReal t, const PetscReal *e,
                           PetscReal seen[ESTIMATE_SEEN], PetscReal change[RIGID_VALUES]) {
  const PetscInt tip = (self->nodes - 1) * self->fields;
  PetscReal off = 0, distance = 0, length;

  PetscFunctionBegin;
  PetscCall(RodLength(self->rod, t, &length));
  for (PetscInt d = 0; d <= self->mirrors; d++) {
    off = hypot(off, e[tip + d]);
    change[RIGID_TIP + d] = e[tip + d];
    distance = hypot(distance, self->all.u[tip + d]);
  }
  seen[ESTIMATE_TIP] = off / PetscMax(distance, rod_rule.vanished);
  seen[ESTIMATE_NORM] = SeeNorm(self, length, e);
  PetscCall(SeeEnergy(self, t, e, &seen[ESTIMATE_ENERGY], &change[RIGID_ENERGY]));
  PetscFunctionReturn(0);
}

/* What others press it by comes on top of what its own contact, which is not rigid, puts it off. */
static void SeeGives(const Estimate self, PetscReal seen[ESTIMATE_SEEN]) {
  const PetscInt tip = (self->nodes - 1) * self->fields;
  PetscReal distance = rod_rule.vanished;

  for (PetscInt d = 0; d <= self->mirrors; d++) distance = hypot(distance, self->all.u[tip + d]);
  for (int k = 0; k < ESTIMATE_SEEN; k++)
    if (seen[k] != unknown) seen[k] += self->gives / distance;
}

/* EstimateIsEarly - is an error of this kind at t one of a start, which does not count? */
PetscBool EstimateIsEarly(Estimate self, PetscReal t, int k) {
  return (PetscBool)(t - self->began[k] <= step_rule.estimate_early * RodEndTime(self->leg->rod));
}

/* EstimateCount - takes the errors of a part at t for what is reported. Beyond 1 an error is no
   small one any more, and the linear equations say nothing. What was seen early fades as time goes
   on,

    start(t) = max(seen(t), start(before) before / t),

   so that what the start does is over by the end of a run that stops soon. What there is nothing of
   for a while, as of the energy of a rod at rest that a wall will meet, starts when it begins: of
   what is next to nothing then, a part says little. */
PetscErrorCode EstimateCount(Estimate self, PetscReal t, int part) {
  PetscReal seen[ESTIMATE_SEEN] = {0}, most = 0, *e = self->e[part], *start = self->start[part],
            change[RIGID_VALUES] = {0};
  const PetscReal *began = self->began;

  PetscFunctionBegin;
  PetscCall(EstimateSee(self, t, e, seen, change));
  if (part == ESTIMATE_SOFT && self->gives > 0) SeeGives(self, seen);
  if (part == ESTIMATE_SOFT) PetscCall(PetscArraycpy(self->rigid, change, RIGID_VALUES));
  for (int k = 0; k < ESTIMATE_SEEN; k++) {
    PetscReal *worst = &self->worst[part][k], reported;
    if (PetscIsInfOrNanReal(seen[k])) seen[k] = most = PETSC_MAX_REAL;
    if (seen[k] == unknown) self->began[k] = t;
    if (began[k] == 0 || !EstimateIsEarly(self, t, k)) most = PetscMax(most, seen[k]);
    reported = seen[k] == unknown ? 0 : PetscMin(1, seen[k]);
    if (seen[k] == unknown)
      start[k] = 0;
    else if (EstimateIsEarly(self, t, k))
      start[k] = PetscMax(reported, start[k] * (self->before - began[k]) / (t - began[k]));
    else
      *worst = PetscMax(*worst, reported);
    self->now[part][k] = reported;
  }
  for (PetscInt i = 0; i < self->nodes * self->fields && most > 1; i++)
    e[i] = most < PETSC_MAX_REAL ? e[i] / most : 0;
  PetscFunctionReturn(0);
}
