/* How the spin of the directors about the tangent changes along a rod in space. Directors turn at u
   along the rod, per arc length, and at the rate w in time, about themselves; that turns may be
   taken in either order is

     w' = (g u)_t + w x g u,     w1' = (g u1)_t - g (u2 d2 + u3 d3).d1_t,

   and with u1 = m.d1/C + u01

     w1' = g_t u1 + g ((m_t.d1 + m.d1_t)/C + m.d1 (1/C)_t + u01_t - (u2 d2 + u3 d3).d1_t). */
#ifndef TENDRIL_SPIN_H
#define TENDRIL_SPIN_H

#include "scene/scene.h"

/* Rates, at a label, of 1/C and of natural twist. */
typedef struct {
  PetscReal flex_t, u0_t;
} TwistRate;

PetscErrorCode SceneTwistRate(Scene scene, PetscReal s, PetscReal t, TwistRate *rate);

/* The slope of the spin; flex = 1/C. */
static inline PetscReal SpinSlope(PetscReal g, PetscReal g_t, const TwistRate *rate, PetscReal flex,
                                  const PetscReal d[3][3], const PetscReal u[3],
                                  const PetscReal m[3], const PetscReal m_t[3],
                                  const PetscReal d1_t[3]) {
  PetscReal sum = rate->u0_t;

  for (int i = 0; i < 3; i++)
    sum += flex * (m_t[i] * d[0][i] + m[i] * d1_t[i]) + rate->flex_t * m[i] * d[0][i] -
           (u[1] * d[1][i] + u[2] * d[2][i]) * d1_t[i];
  return g_t * u[0] + g * sum;
}

#endif
