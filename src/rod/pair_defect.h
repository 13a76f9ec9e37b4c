/* How far the rules by which cells are integrated are off, from what is known at their points.

   A cell of order 4 takes for the integral of f Simpson's, with f at its middle at Hermite's cubic.
   Two cells beside each other have five points of f: the quartic through them integrates f to a
   higher order, and the cubic over both tells at the node between them how far such a cubic is off,
   16 times what those of the halves are.

   The pressure of contact is rough wherever it begins and ends, but the rod gives way to it by
   depth: a tenth of what the rule seems to be off by counts. Where it presses over a layer shorter
   than a cell, depth takes up what the rule has too much of over the layer and not over the cell:
   so much of that counts as the square of the layer is of that of the cell. */
#ifndef TENDRIL_PAIR_DEFECT_H
#define TENDRIL_PAIR_DEFECT_H

#include "base/hermite.h"
#include "base/lagrange.h"
#include "world/contact.h"
#include "rod/rules.h"
#include <string.h>

enum { PLACES = 5 };

/* What part of the pressure of contact counts in a cell of that length. */
static inline PetscReal PairSees(const Contact *contact, PetscReal cell) {
  return contact->any ? PetscMin(1, PetscSqr(contact->tip / cell)) * rod_rule.pressure_defect : 1;
}

/* Weights of the integral over [0, 1] of the polynomial through values at the ends and middles of
   two cells of lengths h1 and h2. */
static inline void PairWeights(PetscReal h1, PetscReal h2, PetscReal weight[PLACES]) {
  static const PetscReal even[PLACES] = {7. / 90, 32. / 90, 12. / 90, 32. / 90, 7. / 90};
  const PetscReal h = h1 + h2, place[PLACES] = {0, h1 / 2 / h, h1 / h, (h1 + h2 / 2) / h, 1};
  PetscReal L[PLACES];

  if (PetscAbsReal(place[2] - 0.5) < 1e-12) { /* Boole's */
    memcpy(weight, even, sizeof(even));
    return;
  }
  for (int j = 0; j < PLACES; j++) weight[j] = 0;
  for (int q = 0; q < GAUSS; q++) {
    LagrangeValues(PLACES, place, gauss_point[q], L);
    for (int j = 0; j < PLACES; j++) weight[j] += gauss_weight[q] * L[j];
  }
}

/* How rough five values are: 0 where they are those of a polynomial of degree 3, up to 1. */
static inline PetscReal Roughness(const PetscReal f[PLACES]) {
  PetscReal d[3], all = 0;

  for (int k = 0; k < 3; k++) {
    d[k] = f[k] - 2 * f[k + 1] + f[k + 2];
    all += PetscAbsReal(d[k]);
  }
  return all > 0 ? PetscMin(1, PetscAbsReal(d[0] - 2 * d[1] + d[2]) / all) : 0;
}

/* By how much Simpson's rule on both cells is off the quartic. */
static inline PetscReal PairRule(PetscReal h1, PetscReal h2, const PetscReal weight[PLACES],
                                 const PetscReal f[PLACES]) {
  PetscReal best = 0, simpson = (h1 * (f[0] + 4 * f[1] + f[2]) + h2 * (f[2] + 4 * f[3] + f[4])) / 6;

  for (int j = 0; j < PLACES; j++) best += (h1 + h2) * weight[j] * f[j];
  return (simpson - best) * (1 + (rod_rule.rough_error - 1) * Roughness(f));
}

/* ... and what the cubics in the cells are off by, from f at the node between them on the cubic
   over both. */
static inline PetscReal PairCubic(PetscReal h1, PetscReal h2, PetscReal at_node, PetscReal cubic) {
  return (h1 + h2) * 4 / 6 * (cubic - at_node) / 16;
}

#endif
