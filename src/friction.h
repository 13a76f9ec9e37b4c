/* The friction law: force per length -phi(|v|) v, phi = (1 - mu) + mu / sqrt(v^2 + beta), and the
   linearisations of its dry part for Newton's method. */
#ifndef TENDRIL_FRICTION_H
#define TENDRIL_FRICTION_H

#include <petscsys.h>

typedef enum { NEWTON_PRIMAL, NEWTON_PRIMAL_DUAL } FrictionNewton;

typedef struct {
  PetscReal mu;   /* dry share, in [0,1] */
  PetscReal beta; /* regularisation of |v|^2; 0: exact Coulomb friction */
  FrictionNewton newton;
} Friction;

/* What Newton's method remembers of one friction point: the velocity and the dual w (the dry force
   over mu, |w| <= 1) of its latest linearisation. */
typedef struct {
  PetscReal v[2], w[2];
} FrictionDual;

PetscErrorCode FrictionSetFromOptions(Friction *friction);
void FrictionDualReset(const Friction *law, const PetscReal v[2], FrictionDual *dual);
void FrictionDualAdvance(const Friction *law, const PetscReal v[2], FrictionDual *dual);
void FrictionLinearise(const Friction *law, const PetscReal v[2], const FrictionDual *dual,
                       PetscReal slope[2][2]);

/* phi(|v|) given |v|^2 */
static inline PetscReal FrictionPhi(const Friction *law, PetscReal v2) {
  return 1 - law->mu + law->mu / PetscSqrtReal(v2 + law->beta);
}

#endif
