/* Small changes u of a state of rods at an instant, dF/dU u + sigma dF/dU_t u = 0 for F their
   equations: the mode that grows fastest, or decays slowest. */
#ifndef TENDRIL_MODES_H
#define TENDRIL_MODES_H

#include <slepceps.h>

typedef struct {
  PetscReal rate, frequency; /* of the mode with the largest real part of those nearest to 0 */
  PetscInt which;            /* of them */
} Growing;

typedef struct {
  EPS eps;
  Mat A, B, T;     /* dF/dU, -dF/dU_t, and A^-1 B; A and B are borrowed */
  KSP ksp;         /* A^-1; borrowed */
  Vec moves, work; /* 1 for each unknown that can move by itself, else 0; borrowed */
} Modes;

PetscErrorCode ModesCreate(Mat A, Mat B, KSP ksp, Vec moves, Modes *modes);
PetscErrorCode ModesLook(Modes *modes, PetscReal t, Growing *growing);
PetscErrorCode ModesDestroy(Modes *modes);

#endif
