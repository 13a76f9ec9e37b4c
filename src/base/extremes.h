/* The larger and the smaller of two numbers, each asked for once: PetscMax() and PetscMin() are
   macros, which evaluate what they take twice. For what does something, or costs something. */
#ifndef TENDRIL_EXTREMES_H
#define TENDRIL_EXTREMES_H

#include <petscsys.h>

static inline PetscReal LargerOf(PetscReal a, PetscReal b) {
  return a < b ? b : a;
}

static inline PetscReal SmallerOf(PetscReal a, PetscReal b) {
  return a < b ? a : b;
}

#endif
