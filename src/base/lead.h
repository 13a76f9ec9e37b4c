/* A number that is led from what it is, at the rate at which it changes, to another one, at which
   it comes to rest: a cubic between two times, even before and behind. */
#ifndef TENDRIL_LEAD_H
#define TENDRIL_LEAD_H

#include "base/hermite.h"

typedef struct {
  PetscBool on;
  PetscReal t[2], x[2], rate; /* from, to; the rate at t[0] */
} Lead;

/* LeadTo - leads it on to x by the time `by`, from what it is at t, at its rate there. */
static inline void LeadTo(Lead *self, PetscReal t, PetscReal is, PetscReal rate, PetscReal by,
                          PetscReal x) {
  *self = (Lead){PETSC_TRUE, {t, by}, {is, x}, rate};
}

/* LeadValue - what it is at a time, not before t[0]. */
static inline PetscReal LeadValue(const Lead *self, PetscReal t) {
  const PetscReal h = self->t[1] - self->t[0];

  if (t <= self->t[0]) return self->x[0];
  if (t >= self->t[1]) return self->x[1];
  return HermiteAt((t - self->t[0]) / h, h, self->x[0], self->rate, self->x[1], 0);
}

/* LeadRate - how fast it changes; 0 of one that is not on. */
static inline PetscReal LeadRate(const Lead *self, PetscReal t) {
  const PetscReal h = self->t[1] - self->t[0];
  PetscReal w[4], by[4], bend[4];

  if (!self->on || t < self->t[0] || t >= self->t[1]) return 0;
  Hermite((t - self->t[0]) / h, w, by, bend);
  return by[2] * (self->x[1] - self->x[0]) / h + by[1] * self->rate;
}

/* LeadMoves - does it change in a step that ends at t? */
static inline PetscBool LeadMoves(const Lead *self, PetscReal t) {
  return (PetscBool)(self->on && t > self->t[0] && t <= self->t[1] &&
                     (self->x[0] != self->x[1] || self->rate != 0));
}

/* LeadNextTurn - when it comes to rest, if that is behind t; else PETSC_MAX_REAL. */
static inline PetscReal LeadNextTurn(const Lead *self, PetscReal t) {
  return self->on && self->t[1] > t ? self->t[1] : PETSC_MAX_REAL;
}

#endif
