/* Products of vectors in space. */
#ifndef TENDRIL_VECTORS_H
#define TENDRIL_VECTORS_H

#include <petscsys.h>

static inline PetscReal Dot3(const PetscReal a[3], const PetscReal b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Cross3 - c = a x b; c is neither of them. */
static inline void Cross3(const PetscReal a[3], const PetscReal b[3], PetscReal c[3]) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

#endif
