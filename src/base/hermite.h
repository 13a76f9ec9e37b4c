/* The cubic curve through value and slope at both ends of a cell. */
#ifndef TENDRIL_HERMITE_H
#define TENDRIL_HERMITE_H

#include <petscsys.h>

/* Hermite - its polynomials at z in [0, 1], of a, a_z, b, b_z in this order, and their first and
   second derivatives. */
static inline void Hermite(PetscReal z, PetscReal value[4], PetscReal slope[4], PetscReal bend[4]) {
  const PetscReal y = 1 - z;
  value[0] = y * y * (1 + 2 * z);
  value[1] = z * y * y;
  value[2] = z * z * (1 + 2 * y);
  value[3] = -z * z * y;
  slope[0] = -6 * z * y;
  slope[1] = y * (1 - 3 * z);
  slope[2] = 6 * z * y;
  slope[3] = z * (3 * z - 2);
  bend[0] = 12 * z - 6;
  bend[1] = 6 * z - 4;
  bend[2] = 6 - 12 * z;
  bend[3] = 6 * z - 2;
}

/* HermiteAt - the curve itself at z, from a and b and the slopes there, over a cell of length h. */
static inline PetscReal HermiteAt(PetscReal z, PetscReal h, PetscReal a, PetscReal slope_a,
                                  PetscReal b, PetscReal slope_b) {
  const PetscReal y = 1 - z;
  return (1 + 2 * z) * y * y * a + z * z * (3 - 2 * z) * b +
         h * z * y * (y * slope_a - z * slope_b);
}

/* HermiteRise - the smooth step from 0 at z = 0 to 1 at z = 1, with two derivatives of 0 at both
   ends. */
static inline PetscReal HermiteRise(PetscReal z) {
  return z * z * z * (10 - 15 * z + 6 * z * z);
}

/* HermiteFall - 1 less that, to the last digit also where that is near 1. */
static inline PetscReal HermiteFall(PetscReal z) {
  const PetscReal y = 1 - z;
  return y * y * y * (1 + 3 * z + 6 * z * z);
}

/* HermiteRiseSlope - how steep it is: a bell. */
static inline PetscReal HermiteRiseSlope(PetscReal z) {
  return 30 * z * z * (1 - z) * (1 - z);
}

#endif
