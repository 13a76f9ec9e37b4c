/* The friction law: force per length -phi(|v|) v, and the linearisations of its dry part for
   Newton's method:

     phi = viscous + mu / sqrt(v^2 + beta) + least v^2 / (v^2 + fast^2)

   The last term holds back a rod that dry friction does not hold: LoadShareLeast(). */
#ifndef TENDRIL_FRICTION_H
#define TENDRIL_FRICTION_H

#include "base/extremes.h" /* who asks how fast a place creeps moves what holds it */
#include "base/options.h"
#include "curve/place.h"

typedef enum { NEWTON_PRIMAL, NEWTON_PRIMAL_DUAL } FrictionNewton;

typedef struct {
  PetscReal mu;      /* dry share, in [0,1] */
  PetscReal beta;    /* regularisation of |v|^2; 0: exact Coulomb friction */
  PetscReal viscous; /* viscous share: 1 - mu; 0 where a law of one's own says all of it */
  PetscReal least;   /* what there is of it above a speed, fast, if it is less; else 0 */
  PetscReal fast;
  FrictionNewton newton;
} Friction;

/* What Newton's method remembers of one friction point: the velocity and the dual w (the dry force
   over mu, |w| <= 1) of its latest linearisation; for exact Coulomb friction also the shift that
   holds a sticking point at rest (else 0). */
typedef struct {
  PetscReal v[RUBS], w[RUBS], shift[RUBS];
} FrictionDual;

extern const OptionGroup friction_options;

PetscErrorCode FrictionSetFromOptions(Friction *friction);

/* n, here and below: how many components rub. 1: along a line, 2 in the plane, RUBS in space. */
void FrictionFollow(int n, const Friction *law, const PetscReal v[], PetscBool fresh,
                    FrictionDual *dual);
void FrictionSlope(int n, const Friction *law, const PetscReal v[], const FrictionDual *dual,
                   PetscReal slope[RUBS][RUBS]);
void FrictionLinearise(int n, const Friction *law, const PetscReal v[], PetscBool fresh,
                       FrictionDual *dual, PetscReal slope[RUBS][RUBS]);
PetscReal FrictionHold(int n, const PetscReal v[], PetscReal seen, PetscReal hold,
                       FrictionDual *dual);

/* Real k of a dual, of as many as one of n components has: velocity, dual and shift. */
static inline PetscReal *FrictionDualReal(int n, FrictionDual *dual, PetscInt k) {
  return (PetscReal *)dual + k / n * RUBS + k % n;
}

static inline PetscInt FrictionDualReals(int n) {
  return 3 * n;
}

/* The dry force is mu w, w = u/r, u = v + shift, r = sqrt(u^2 + beta). Regularised friction has no
   shift. Exact Coulomb friction takes a tiny beta and moves the shift, shift <- shift + v, until
   v settles: then either v = 0, and w is whatever it takes, or |v| is far above sqrt(beta)
   and w = v/|v| (a method of multipliers). */
static const PetscReal friction_tiny = 1e-12;

/* How long a shift may be, over the square root of that: along the rod, and in contact, where a
   rope may lie next to sliding for long. */
static const PetscReal friction_hold = 10, friction_hold_contact = 100;

/* |v|^2 */
static inline PetscReal FrictionSquare(int n, const PetscReal v[]) {
  PetscReal sum = v[0] * v[0];

  for (int d = 1; d < n; d++) sum += v[d] * v[d];
  return sum;
}

/* r, and u with it */
static inline PetscReal FrictionRadius(int n, const Friction *law, const PetscReal v[],
                                       const PetscReal shift[], PetscReal u[]) {
  for (int d = 0; d < n; d++) u[d] = v[d] + shift[d];
  return PetscSqrtReal(FrictionSquare(n, u) + (law->beta > 0 ? law->beta : friction_tiny));
}

/* The dry part of a law alone. */
static inline Friction FrictionDry(Friction law) {
  law.mu = 1;
  law.viscous = law.least = 0;
  return law;
}

/* Viscous friction, over v, given |v|^2. */
static inline PetscReal FrictionViscous(const Friction *law, PetscReal v2) {
  if (law->least == 0) return law->viscous;
  return law->viscous + law->least * v2 / (v2 + law->fast * law->fast);
}

/* The force phi(|v|) v of friction, per length. */
static inline void FrictionForce(int n, const Friction *law, const PetscReal v[],
                                 const FrictionDual *dual, PetscReal f[]) {
  const PetscReal beta = law->beta > 0 ? law->beta : friction_tiny;
  PetscReal u[RUBS], viscous = FrictionViscous(law, FrictionSquare(n, v)), drag, sum = beta;

  for (int d = 0; d < n; d++) {
    u[d] = v[d] + dual->shift[d];
    sum += u[d] * u[d];
  }
  if (n == 2) sum = FrictionSquare(n, u) + beta; /* (each summed as it always was) */
  drag = law->mu / PetscSqrtReal(sum);
  for (int d = 0; d < n; d++) f[d] = viscous * v[d] + drag * u[d];
}

/* phi(|v|) given |v|^2; a point at rest under exact Coulomb friction loses no power: 1 - mu */
static inline PetscReal FrictionPhi(const Friction *law, PetscReal v2) {
  PetscReal r = PetscSqrtReal(v2 + law->beta);
  return FrictionViscous(law, v2) + (r > 0 ? law->mu / r : 0);
}

/* int_a^b phi(v) v dv: the axial friction on a straight rod whose speed rises evenly from a to b */
static inline PetscReal FrictionBetween(const Friction *law, PetscReal a, PetscReal b) {
  const PetscReal rise = b * b - a * a, F2 = law->fast * law->fast;
  PetscReal between =
      law->mu * (PetscSqrtReal(b * b + law->beta) - PetscSqrtReal(a * a + law->beta)) +
      law->viscous * rise / 2;

  if (law->least > 0) between += law->least * (rise - F2 * log1p(rise / (a * a + F2))) / 2;
  return between;
}

#endif
