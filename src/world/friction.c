#include "world/friction.h"

static const OptionRow rows[] = {
    ROW_REAL("-friction_mu", "1", 0, 1, UNIT_NONE, 0,
             "dry share of friction, 0 (viscous) to 1 (dry)"),
    ROW_REAL("-friction_beta", "1e-3", 0, 1e6, UNIT_NONE, 0,
             "regularisation of |x_t|^2; 0: exact Coulomb friction with stick"),
    ROW_WORD("-friction_newton", "primal_dual", "primal,primal_dual", 0,
             "linearisation of dry friction")};
const OptionGroup friction_options = OPTION_GROUP_OF_ROD("Friction", rows);

/* FrictionSetFromOptions - reads and checks the friction law's options. */
PetscErrorCode FrictionSetFromOptions(Friction *friction) {
  PetscInt choice;

  PetscFunctionBegin;
  friction->own = OptionsLaw(OWN_FRICTION);
  if (friction->own) PetscCall(OptionDefault("-friction_mu", "0"));
  PetscCall(OptionReal("-friction_mu", &friction->mu, NULL));
  friction->viscous = 1 - friction->mu;
  friction->least = friction->fast = 0;
  PetscCall(OptionReal("-friction_beta", &friction->beta, NULL));
  UserCheck(!friction->own || friction->mu == 0, OptionsComm(),
            "-friction_mu: the friction law of one's own says all of it; give 0, or take this out");
  PetscCall(OptionWord("-friction_newton", &choice, NULL));
  friction->newton = (FrictionNewton)choice;
  PetscFunctionReturn(0);
}

/* What is said of two components below holds for n, which is known when this is compiled. */
static inline PetscReal Dot(int n, const PetscReal a[], const PetscReal b[]) {
  PetscReal sum = a[0] * b[0];
  for (int i = 1; i < n; i++) sum += a[i] * b[i];
  return sum;
}

static inline PetscReal Radius(const Friction *law, int n, const PetscReal v[],
                               const PetscReal shift[], PetscReal u[]) {
  for (int i = 0; i < n; i++) u[i] = v[i] + shift[i];
  return PetscSqrtReal(Dot(n, u, u) + (law->beta > 0 ? law->beta : friction_tiny));
}

static inline void Reset(const Friction *law, int n, const PetscReal v[], PetscReal seen[],
                         PetscReal dual[], const PetscReal shift[]) {
  const PetscReal near = 0.2;
  PetscReal u[4], inverse = 1 / Radius(law, n, v, shift, u), w[4], d[4];

  for (int i = 0; i < n; i++) {
    w[i] = u[i] * inverse;
    d[i] = w[i] - dual[i];
    seen[i] = v[i];
  }
  for (int i = 0; i < n && Dot(n, d, d) < near * near; i++) dual[i] = w[i];
}

static inline void Advance(const Friction *law, int n, const PetscReal v[], PetscReal seen[],
                           PetscReal w[], const PetscReal shift[]) {
  PetscReal u[4], r = Radius(law, n, seen, shift, u), dv[4], size, along;

  for (int i = 0; i < n; i++) dv[i] = v[i] - seen[i];
  along = Dot(n, u, dv) / r;
  for (int i = 0; i < n; i++) w[i] = (u[i] + dv[i] - w[i] * along) / r;
  size = PetscSqrtReal(Dot(n, w, w));
  for (int i = 0; i < n; i++) {
    if (size > 1) w[i] /= size;
    seen[i] = v[i];
  }
}

static inline void Slope(const Friction *law, int n, const PetscReal v[], const PetscReal dual[],
                         const PetscReal shift[], PetscReal *slope) {
  PetscReal u[4], inverse = 1 / Radius(law, n, v, shift, u), d = law->mu * inverse,
                  v2 = Dot(n, v, v), viscous = FrictionViscous(law, v2), rises = 0;

  if (law->least > 0) rises = 2 * law->least * PetscSqr(law->fast / (v2 + law->fast * law->fast));
  if (law->own) rises = 2 * FrictionOwn(law, v2, 1);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      PetscReal w = law->newton == NEWTON_PRIMAL ? u[i] * inverse : dual[i];
      slope[n * i + j] = (i == j) * (viscous + d) - d * w * (u[j] * inverse);
      if (rises != 0) slope[n * i + j] += rises * v[i] * v[j];
    }
}

static inline PetscReal Hold(int n, const PetscReal v[], PetscReal seen, PetscReal hold,
                             PetscReal shift[]) {
  const PetscReal longest = hold * PetscSqrtReal(friction_tiny);
  PetscReal u[4], size, speed = PetscSqrtReal(Dot(n, v, v)), part = speed < seen ? speed / seen : 1;
  PetscBool slides = (PetscBool)(speed > longest);

  for (int i = 0; i < n; i++) u[i] = part * v[i] + shift[i];
  size = PetscSqrtReal(Dot(n, u, u));
  for (int i = 0; i < n; i++) shift[i] = slides ? 0 : size > longest ? u[i] * longest / size : u[i];
  return slides ? 0 : speed;
}

/* FrictionOwnBetween - FrictionBetween() of a law of one's own, by Gauss's rule: exact for a phi
   that is a polynomial of degree 8. */
PetscReal FrictionOwnBetween(const Friction *law, PetscReal a, PetscReal b) {
  static const PetscReal point[5] = {-0.9061798459386640, -0.5384693101056831, 0,
                                     0.5384693101056831, 0.9061798459386640},
                         weight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                      0.4786286704993665, 0.2369268850561891};
  PetscReal sum = 0;

  for (int k = 0; k < 5; k++) {
    const PetscReal v = (a + b) / 2 + (b - a) / 2 * point[k];
    sum += weight[k] * FrictionOwn(law, v * v, 0) * v;
  }
  return sum * (b - a) / 2;
}

/*
  FrictionDualReset - begins a Newton solve at v. The dual w = u/r makes the first linearisation
  Newton's own, which is best if it is near the dual of the step before. Where it is not, the guess
  for v is but noise around rest (tiny beta), and the old dual is the better one.
*/
void FrictionDualReset(const Friction *law, const PetscReal v[2], FrictionDual *dual) {
  Reset(law, 2, v, dual->v, dual->w, dual->shift);
}

/*
  FrictionDualAdvance - follows a Newton step from dual->v to v. The dual obeys r w = u, linearised
  at the old point, and is drawn back to the unit disc (Chan, Golub, Mulet, SIAM J. Sci. Comput. 20,
  1999): w <- P( u/r + (dv - w (u.dv)/r) / r ).
*/
void FrictionDualAdvance(const Friction *law, const PetscReal v[2], FrictionDual *dual) {
  Advance(law, 2, v, dual->v, dual->w, dual->shift);
}

/*
  FrictionLinearise - the derivative of the force phi(|v|) v by v (without what is fast),
    primal:       viscous I + mu/r (I - (u/r) (u/r)^T),
    primal-dual:  viscous I + mu/r (I - w (u/r)^T).
*/
void FrictionLinearise(const Friction *law, const PetscReal v[2], const FrictionDual *dual,
                       PetscReal slope[2][2]) {
  Slope(law, 2, v, dual->w, dual->shift, &slope[0][0]);
}

/* FrictionDualHold - moves the shift by v, for exact Coulomb friction; by less if v is below what
   is seen. Returns the speed at which the point creeps though it is held; 0 if it slides, for then
   it needs no shift.

   hold   how long a shift may be, over sqrt(friction_tiny): it leaves the force within 1/(2 hold^2)
          of its limit */
PetscReal FrictionDualHold(const PetscReal v[2], PetscReal seen, PetscReal hold,
                           FrictionDual *dual) {
  return Hold(2, v, seen, hold, dual->shift);
}

/* FrictionLinearise4 - of a point in space: begins a Newton solve at v (fresh), or follows it
   there, and gives the derivative of the force by v. */
void FrictionLinearise4(const Friction *law, const PetscReal v[4], PetscBool fresh,
                        FrictionDual4 *dual, PetscReal slope[4][4]) {
  if (fresh)
    Reset(law, 4, v, dual->v, dual->w, dual->shift);
  else
    Advance(law, 4, v, dual->v, dual->w, dual->shift);
  Slope(law, 4, v, dual->w, dual->shift, &slope[0][0]);
}

/* FrictionDualHold4 - as FrictionDualHold(), of a point in space. */
PetscReal FrictionDualHold4(const PetscReal v[4], PetscReal seen, PetscReal hold,
                            FrictionDual4 *dual) {
  return Hold(4, v, seen, hold, dual->shift);
}
