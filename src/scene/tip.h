/* The tip s = 1: what is free there and what is held. */
#ifndef TENDRIL_TIP_H
#define TENDRIL_TIP_H

#include <petscsys.h>

/* The state of the tip. */
typedef struct {
  PetscReal x[2], theta, moment, force[2];
} TipState;
enum { TIP_ROWS = 3 };

typedef struct {
  PetscBool loaded; /* anything but m = 0, n = 0 */
} Tip;

/* The three conditions at the tip, r = 0: no moment, no force. */
static inline void TipResidual(const Tip *tip, const TipState *at, PetscReal r[TIP_ROWS]) {
  r[0] = at->moment;
  r[1] = at->force[0];
  r[2] = at->force[1];
}

/* Their derivatives by (x1, x2, theta, m, n1, n2). */
static inline void TipJacobian(const Tip *tip, const TipState *at, PetscReal J[TIP_ROWS][6]) {
  for (int i = 0; i < TIP_ROWS; i++)
    for (int j = 0; j < 6; j++) J[i][j] = j == 3 + i;
}

#endif
