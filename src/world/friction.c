#include "world/friction.h"
#include "base/clones.h"

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
  const PetscBool own = (PetscBool)(OptionsLaw(OWN_FRICTION) != NULL);
  PetscInt choice;

  PetscFunctionBegin;
  if (own) PetscCall(OptionDefault("-friction_mu", "0"));
  PetscCall(OptionReal("-friction_mu", &friction->mu, NULL));
  friction->viscous = own ? 0 : 1 - friction->mu;
  friction->least = friction->fast = 0;
  PetscCall(OptionReal("-friction_beta", &friction->beta, NULL));
  UserCheck(!own || friction->mu == 0, OptionsComm(),
            "-friction_mu: the friction law of one's own says all of it; give 0, or take this out");
  PetscCall(OptionWord("-friction_newton", &choice, NULL));
  friction->newton = (FrictionNewton)choice;
  PetscFunctionReturn(0);
}

static inline PetscReal Dot(int n, const PetscReal a[], const PetscReal b[]) {
  PetscReal sum = a[0] * b[0];
  for (int i = 1; i < n; i++) sum += a[i] * b[i];
  return sum;
}

/* n is known below when this is compiled. */
ALWAYS_INLINE void Reset(const Friction *law, int n, const PetscReal v[], FrictionDual *dual) {
  const PetscReal near = 0.2;
  PetscReal u[RUBS], inverse = 1 / FrictionRadius(n, law, v, dual->shift, u), w[RUBS], d[RUBS];

  for (int i = 0; i < n; i++) {
    w[i] = u[i] * inverse;
    d[i] = w[i] - dual->w[i];
    dual->v[i] = v[i];
  }
  if (!(FrictionSquare(n, d) < near * near)) return;
  for (int i = 0; i < n; i++) dual->w[i] = w[i];
}

ALWAYS_INLINE void Advance(const Friction *law, int n, const PetscReal v[], FrictionDual *dual) {
  PetscReal u[RUBS], r = FrictionRadius(n, law, dual->v, dual->shift, u), dv[RUBS], *w = dual->w,
                     size, along;

  for (int i = 0; i < n; i++) dv[i] = v[i] - dual->v[i];
  along = Dot(n, u, dv) / r;
  for (int i = 0; i < n; i++) w[i] = (u[i] + dv[i] - w[i] * along) / r;
  size = PetscSqrtReal(FrictionSquare(n, w));
  for (int i = 0; i < n; i++) {
    if (size > 1) w[i] /= size;
    dual->v[i] = v[i];
  }
}

ALWAYS_INLINE void Follow(const Friction *law, int n, const PetscReal v[], PetscBool fresh,
                          FrictionDual *dual) {
  if (fresh)
    Reset(law, n, v, dual);
  else
    Advance(law, n, v, dual);
}

ALWAYS_INLINE void Slope(const Friction *law, int n, const PetscReal v[], const FrictionDual *dual,
                         PetscReal slope[RUBS][RUBS]) {
  PetscReal u[RUBS], inverse = 1 / FrictionRadius(n, law, v, dual->shift, u), d = law->mu * inverse,
                     v2 = FrictionSquare(n, v), viscous = FrictionViscous(law, v2), rises = 0;

  if (law->least > 0) rises = 2 * law->least * PetscSqr(law->fast / (v2 + law->fast * law->fast));
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      PetscReal w = law->newton == NEWTON_PRIMAL ? u[i] * inverse : dual->w[i];
      slope[i][j] = (i == j) * (viscous + d) - d * w * (u[j] * inverse);
      if (rises != 0) slope[i][j] += rises * v[i] * v[j];
    }
}

/*
  FrictionFollow - brings the dual up to v.

  fresh   a Newton solve begins there. The dual w = u/r makes the first linearisation Newton's own,
          which is best if it is near the dual of the step before. Where it is not, the guess for v
          is but noise around rest (tiny beta), and the old dual is the better one.
  else    it follows a Newton step from dual->v to v. The dual obeys r w = u, linearised at the old
          point, and is drawn back to the unit disc (Chan, Golub, Mulet, SIAM J. Sci. Comput. 20,
          1999): w <- P( u/r + (dv - w (u.dv)/r) / r ).
*/
void FrictionFollow(int n, const Friction *law, const PetscReal v[], PetscBool fresh,
                    FrictionDual *dual) {
  if (n == 1)
    Follow(law, 1, v, fresh, dual);
  else if (n == 2)
    Follow(law, 2, v, fresh, dual);
  else
    Follow(law, RUBS, v, fresh, dual);
}

/*
  FrictionSlope - the derivative of the force phi(|v|) v by v (without what is fast),
    primal:       viscous I + mu/r (I - (u/r) (u/r)^T),
    primal-dual:  viscous I + mu/r (I - w (u/r)^T).
*/
void FrictionSlope(int n, const Friction *law, const PetscReal v[], const FrictionDual *dual,
                   PetscReal slope[RUBS][RUBS]) {
  if (n == 1)
    Slope(law, 1, v, dual, slope);
  else if (n == 2)
    Slope(law, 2, v, dual, slope);
  else
    Slope(law, RUBS, v, dual, slope);
}

/* FrictionLinearise - FrictionFollow() and FrictionSlope(). */
void FrictionLinearise(int n, const Friction *law, const PetscReal v[], PetscBool fresh,
                       FrictionDual *dual, PetscReal slope[RUBS][RUBS]) {
  FrictionFollow(n, law, v, fresh, dual);
  FrictionSlope(n, law, v, dual, slope);
}

/* FrictionHold - moves the shift by v, for exact Coulomb friction; by less if v is below what
   is seen. Returns the speed at which the point creeps though it is held; 0 if it slides, for then
   it needs no shift.

   hold   how long a shift may be, over sqrt(friction_tiny): it leaves the force within 1/(2 hold^2)
          of its limit */
PetscReal FrictionHold(int n, const PetscReal v[], PetscReal seen, PetscReal hold,
                       FrictionDual *dual) {
  const PetscReal longest = hold * PetscSqrtReal(friction_tiny),
                  speed = PetscSqrtReal(FrictionSquare(n, v)),
                  part = speed < seen ? speed / seen : 1;
  const PetscBool slides = (PetscBool)(speed > longest);
  PetscReal u[RUBS], size;

  for (int i = 0; i < n; i++) u[i] = part * v[i] + dual->shift[i];
  size = PetscSqrtReal(FrictionSquare(n, u));
  for (int i = 0; i < n; i++)
    dual->shift[i] = slides ? 0 : size > longest ? u[i] * longest / size : u[i];
  return slides ? 0 : speed;
}
