#include "rod/spin_rest.h"
#include "base/plane.h"
#include "rod/rules.h"

/*
  With phi the angle by which the directors have turned about d1,
      u1 = u1(0) + phi'/g,   u2 = u2(0) cos phi + u3(0) sin phi,   u3 = u3(0) cos phi - u2(0) sin
      phi,
  the energy is  E = int sum S_k (u_k - u0_k)^2 / 2 g ds - T phi(1),  and at rest
      (S1 (u1 - u01))' = g (S2 (u2 - u02) u3 - S3 (u3 - u03) u2),
      s = 0: phi = 0,   s = 1: S1 (u1 - u01) = T, or phi = 0 where it is held.
  Places are joined by straight lines, and what bends is taken at them.
*/
typedef struct {
  PetscInt n;
  const SpinPlace *place;
  PetscReal torque;
  PetscBool held;
  PetscReal *slope, *below, *diagonal; /* dE/dphi, and a three-diagonal matrix, symmetric */
} Spin;

/* SpinTurn - twist and bends of a place whose directors have turned by so much, which changes so
   along s. */
void SpinTurn(const SpinPlace *place, PetscReal turn, PetscReal slope, PetscReal u[3]) {
  const PetscReal c = PetscCosReal(turn), s = PetscSinReal(turn);
  const Vector2 across = From2(place->u + 1);

  u[0] = place->u[0] + slope / place->g;
  Put2(Along2(Times2(c, across), -s, Left2(across)), u + 1);
}

/* The energy at phi, its slope, and its second derivatives. */
static PetscReal Energy(Spin *self, const PetscReal phi[]) {
  PetscReal energy = -self->torque * phi[self->n - 1];

  for (PetscInt i = 0; i < self->n; i++) self->slope[i] = self->below[i] = self->diagonal[i] = 0;
  self->slope[self->n - 1] = -self->torque;
  for (PetscInt i = 0; i + 1 < self->n; i++) {
    const SpinPlace *a = &self->place[i], *b = a + 1;
    const PetscReal h = b->s - a->s, g = (a->g + b->g) / 2, C = (a->S[0] + b->S[0]) / 2,
                    twist = (a->u[0] - a->u0[0] + b->u[0] - b->u0[0]) / 2 +
                            (phi[i + 1] - phi[i]) / (g * h);
    energy += C * twist * twist / 2 * g * h;
    self->slope[i] -= C * twist;
    self->slope[i + 1] += C * twist;
    self->below[i + 1] = -C / (g * h);
    for (int k = 0; k < 2; k++) {
      const SpinPlace *at = k ? b : a;
      const PetscReal w = at->g * h / 2;
      const Vector2 S = From2(at->S + 1);
      PetscReal u[3];
      SpinTurn(at, phi[i + k], 0, u);
      const Vector2 v = From2(u + 1), d = Minus2(v, From2(at->u0 + 1));
      energy += w * (S.x * d.x * d.x + S.y * d.y * d.y) / 2;
      self->slope[i + k] += w * (S.x * d.x * v.y - S.y * d.y * v.x);
      self->diagonal[i + k] +=
          C / (g * h) + w * (S.x * (v.y * v.y - d.x * v.x) + S.y * (v.x * v.x - d.y * v.y));
    }
  }
  return energy;
}

/* The change of phi by Newton's method, each place held back by its length over delta: on entry the
   slope and the matrix, which are lost. False: that is no step downhill. */
static PetscBool Change(Spin *self, PetscReal delta, PetscReal change[]) {
  const PetscInt last = self->held ? self->n - 2 : self->n - 1;
  const SpinPlace *place = self->place;

  for (PetscInt i = 1; i <= last; i++) {
    PetscReal f = i > 1 ? self->below[i] / self->diagonal[i - 1] : 0;
    self->diagonal[i] += (place[PetscMin(i + 1, self->n - 1)].s - place[i - 1].s) / 2 / delta;
    if (i > 1) {
      self->diagonal[i] -= f * self->below[i];
      self->slope[i] -= f * self->slope[i - 1];
    }
    if (!(self->diagonal[i] > 0)) return PETSC_FALSE;
  }
  change[0] = change[self->n - 1] = 0;
  for (PetscInt i = last; i > 0; i--)
    change[i] =
        -(self->slope[i] + (i < last ? self->below[i + 1] * change[i + 1] : 0)) / self->diagonal[i];
  return PETSC_TRUE;
}

/*
  SpinRest - the angles by which n places turn about the tangent until they are at rest, the way
  downhill from 0. Not collective.

  place   labels increase; at the first nothing turns
  torque  on the last, about the tangent
  held    the last does not turn either
  turn    n angles

  Where friction does not feel the spin a rod turns so in no time: no step is short enough to see
  it, and Newton's method, which would have to turn it at once, may end anywhere.
*/
PetscErrorCode SpinRest(PetscInt n, const SpinPlace place[], PetscReal torque, PetscBool held,
                        PetscReal turn[]) {
  Spin self = {.n = n, .place = place, .torque = held ? 0 : torque, .held = held};
  PetscReal *change, *next, delta = rod_rule.rest_first, energy;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(turn, n));
  PetscCall(PetscMalloc5(n, &self.slope, n, &self.below, n, &self.diagonal, n, &change, n, &next));
  for (int k = 0; k < rod_rule.rest_steps; k++) {
    PetscReal most = 0, lower;
    energy = Energy(&self, turn);
    if (!Change(&self, delta, change)) {
      delta *= rod_rule.rest_shrinks;
      continue;
    }
    for (PetscInt i = 0; i < n; i++) {
      most = PetscMax(most, PetscAbsReal(change[i]));
      next[i] = turn[i] + change[i];
    }
    if (!(most > rod_rule.rest_reached)) break;
    lower = most <= rod_rule.rest_farthest ? Energy(&self, next) : PETSC_MAX_REAL;
    if (lower > energy + PETSC_SMALL * PetscAbsReal(energy)) {
      delta *= rod_rule.rest_shrinks;
      continue;
    }
    PetscCall(PetscArraycpy(turn, next, n));
    delta *= rod_rule.rest_grows;
  }
  PetscCall(PetscFree5(self.slope, self.below, self.diagonal, change, next));
  PetscFunctionReturn(0);
}
