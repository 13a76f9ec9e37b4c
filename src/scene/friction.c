#include "scene/friction.h"

static const OptionRow rows[] = {
    ROW_REAL("-friction_mu", "1", 0, 1, UNIT_NONE, 0,
             "dry share of friction, 0 (viscous) to 1 (dry)"),
    ROW_REAL("-friction_beta", "1e-3", 0, 1e6, UNIT_NONE, 0,
             "regularisation of |x_t|^2; 0: exact Coulomb friction with stick"),
    ROW_WORD("-friction_newton", "primal_dual", "primal,primal_dual", 0,
             "linearisation of dry friction")};
const OptionGroup friction_options = OPTION_GROUP("Friction", rows);

/* FrictionSetFromOptions - reads and checks the friction law's options. */
PetscErrorCode FrictionSetFromOptions(Friction *friction) {
  PetscInt choice;

  PetscFunctionBegin;
  friction->more = 0;
  PetscCall(OptionReal("-friction_mu", &friction->mu, NULL));
  PetscCall(OptionReal("-friction_beta", &friction->beta, NULL));
  PetscCall(OptionWord("-friction_newton", &choice, NULL));
  friction->newton = (FrictionNewton)choice;
  PetscFunctionReturn(0);
}

/*
  FrictionDualReset - begins a Newton solve at v. The dual w = u/r makes the first linearisation
  Newton's own, which is best if it is near the dual of the step before. Where it is not, the guess
  for v is but noise around rest (tiny beta), and the old dual is the better one.
*/
void FrictionDualReset(const Friction *law, const PetscReal v[2], FrictionDual *dual) {
  const PetscReal near = 0.2;
  PetscReal u[2], inverse = 1 / FrictionRadius(law, v, dual, u), w[2], d[2];

  for (int i = 0; i < 2; i++) {
    w[i] = u[i] * inverse;
    d[i] = w[i] - dual->w[i];
    dual->v[i] = v[i];
  }
  for (int i = 0; i < 2 && d[0] * d[0] + d[1] * d[1] < near * near; i++) dual->w[i] = w[i];
}

/*
  FrictionDualAdvance - follows a Newton step from dual->v to v. The dual obeys r w = u, linearised
  at the old point, and is drawn back to the unit disc (Chan, Golub, Mulet, SIAM J. Sci. Comput. 20,
  1999): w <- P( u/r + (dv - w (u.dv)/r) / r ).
*/
void FrictionDualAdvance(const Friction *law, const PetscReal v[2], FrictionDual *dual) {
  PetscReal u[2], r = FrictionRadius(law, dual->v, dual, u), *w = dual->w;
  PetscReal dv[2] = {v[0] - dual->v[0], v[1] - dual->v[1]}, size;
  PetscReal along = (u[0] * dv[0] + u[1] * dv[1]) / r;

  for (int i = 0; i < 2; i++) w[i] = (u[i] + dv[i] - w[i] * along) / r;
  size = PetscSqrtReal(w[0] * w[0] + w[1] * w[1]);
  for (int i = 0; i < 2; i++) {
    if (size > 1) w[i] /= size;
    dual->v[i] = v[i];
  }
}

/*
  FrictionLinearise - the derivative of the force phi(|v|) v by v,
    primal:       (1 - mu) I + mu/r (I - (u/r) (u/r)^T),
    primal-dual:  (1 - mu) I + mu/r (I - w (u/r)^T).
*/
void FrictionLinearise(const Friction *law, const PetscReal v[2], const FrictionDual *dual,
                       PetscReal slope[2][2]) {
  PetscReal u[2], inverse = 1 / FrictionRadius(law, v, dual, u), d = law->mu * inverse;

  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      PetscReal w = law->newton == NEWTON_PRIMAL ? u[i] * inverse : dual->w[i];
      slope[i][j] = (i == j) * (1 - law->mu + law->more + d) - d * w * (u[j] * inverse);
    }
}

/* FrictionDualHold - moves the shift by v, for exact Coulomb friction; by less if v is below what
   is seen. Returns the speed at which the point creeps though it is held; 0 if it slides, for then
   it needs no shift. The longest kept leaves the force within 0.5 % of its limit. */
PetscReal FrictionDualHold(const PetscReal v[2], PetscReal seen, FrictionDual *dual) {
  const PetscReal longest = 10 * PetscSqrtReal(friction_tiny);
  const PetscReal speed = PetscSqrtReal(v[0] * v[0] + v[1] * v[1]),
                  part = speed < seen ? speed / seen : 1;
  const PetscReal u[2] = {part * v[0] + dual->shift[0], part * v[1] + dual->shift[1]},
                  size = PetscSqrtReal(u[0] * u[0] + u[1] * u[1]);
  PetscBool slides = (PetscBool)(speed > longest);

  for (int i = 0; i < 2; i++)
    dual->shift[i] = slides ? 0 : size > longest ? u[i] * longest / size : u[i];
  return slides ? 0 : speed;
}
