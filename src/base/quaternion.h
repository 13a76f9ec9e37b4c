/* Products of quaternions, real part first. */
#ifndef TENDRIL_QUATERNION_H
#define TENDRIL_QUATERNION_H

#include "base/vectors.h"

/* QuaternionTimes - r = p q; r is neither of them. */
static inline void QuaternionTimes(const PetscReal p[4], const PetscReal q[4], PetscReal r[4]) {
  r[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
  r[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2];
  r[2] = p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3];
  r[3] = p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1];
}

/* QuaternionFrom - r = h* p, which turns from h to p; r is neither of them. */
static inline void QuaternionFrom(const PetscReal h[4], const PetscReal p[4], PetscReal r[4]) {
  const PetscReal back[4] = {h[0], -h[1], -h[2], -h[3]};
  QuaternionTimes(back, p, r);
}

/* QuaternionNormalise - makes its length 1. */
static inline void QuaternionNormalise(PetscReal p[4]) {
  const PetscReal f = 1 / PetscSqrtReal(Dot4(p, p));
  for (int k = 0; k < 4; k++) p[k] *= f;
}

#endif
