#include "friction.h"
#include "options.h"

/* FrictionSetFromOptions - reads and checks the friction law's options. */
PetscErrorCode FrictionSetFromOptions(Friction *friction) {
  const char *const linearisations[] = {"primal", "primal_dual"};
  PetscInt choice = NEWTON_PRIMAL_DUAL;

  PetscFunctionBegin;
  friction->mu = 1;
  friction->beta = 1e-3;
  PetscCall(OptionsHeading("Friction"));
  PetscCall(OptionReal("-friction_mu", "dry share of friction, 0 (viscous) to 1 (dry)", 0, 1,
                       &friction->mu, NULL));
  PetscCall(OptionReal("-friction_beta", "regularisation of |x_t|^2, above 0", 0, 1e6,
                       &friction->beta, NULL));
  PetscCall(OptionList("-friction_newton", "linearisation of dry friction", 2, linearisations,
                       &choice, NULL));
  friction->newton = (FrictionNewton)choice;
  PetscFunctionReturn(0);
}

/* FrictionDualReset - the dual that makes the linearisation at v Newton's own: w = v / r. */
void FrictionDualReset(const Friction *law, const PetscReal v[2], FrictionDual *dual) {
  PetscReal r = PetscSqrtReal(v[0] * v[0] + v[1] * v[1] + law->beta);
  for (int i = 0; i < 2; i++) {
    dual->v[i] = v[i];
    dual->w[i] = v[i] / r;
  }
}

/*
  FrictionDualAdvance - follows a Newton step from dual->v to v. The dual obeys r w = v, linearised
  at the old point, and is drawn back to the unit disc (Chan, Golub, Mulet, SIAM J. Sci. Comput. 20,
  1999): w <- P( v/r + (dv - w (v.dv)/r) / r ).
*/
void FrictionDualAdvance(const Friction *law, const PetscReal v[2], FrictionDual *dual) {
  PetscReal *u = dual->v, *w = dual->w, dv[2] = {v[0] - u[0], v[1] - u[1]};
  PetscReal r = PetscSqrtReal(u[0] * u[0] + u[1] * u[1] + law->beta);
  PetscReal along = (u[0] * dv[0] + u[1] * dv[1]) / r, size;

  for (int i = 0; i < 2; i++) w[i] = (u[i] + dv[i] - w[i] * along) / r;
  size = PetscSqrtReal(w[0] * w[0] + w[1] * w[1]);
  for (int i = 0; i < 2; i++) {
    if (size > 1) w[i] /= size;
    u[i] = v[i];
  }
}

/*
  FrictionLinearise - the derivative of the force phi(|v|) v by v,
    primal:       (1 - mu) I + mu/r (I - (v/r) (v/r)^T),
    primal-dual:  (1 - mu) I + mu/r (I - w (v/r)^T).
*/
void FrictionLinearise(const Friction *law, const PetscReal v[2], const FrictionDual *dual,
                       PetscReal slope[2][2]) {
  PetscReal r = PetscSqrtReal(v[0] * v[0] + v[1] * v[1] + law->beta), d = law->mu / r;
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      PetscReal w = law->newton == NEWTON_PRIMAL ? v[i] / r : dual->w[i];
      slope[i][j] = (i == j) * (1 - law->mu + d) - d * w * v[j] / r;
    }
}
