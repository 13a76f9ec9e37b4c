#include "rod/spin.h"
#include "rod/rules.h"

/* 1/C and natural twist. */
static PetscErrorCode Twisting(Scene scene, PetscReal s, PetscReal t, PetscReal law[2]) {
  PetscReal B, S[3], u0[3];

  PetscFunctionBegin;
  PetscCall(SceneStiffness(scene, s, t, &B, NULL));
  SceneStiffnesses(scene, B, S);
  PetscCall(CurvatureStrains(&scene->curvature, scene->growth, s, t, u0, NULL));
  law[0] = 1 / S[0];
  law[1] = u0[0];
  PetscFunctionReturn(0);
}

/* SceneTwistRate - the rates at which torsional flexibility and natural twist change at the label
   s, by differences: they are small beside those of the moment. Where neither varies along the rod
   they are 0. */
PetscErrorCode SceneTwistRate(Scene scene, PetscReal s, PetscReal t, TwistRate *rate) {
  const PetscReal h = rod_rule.twist_rate_step * (1 + t), before = PetscMax(0, t - h),
                  after = t + h;
  PetscReal a[2] = {0}, b[2] = {0};

  PetscFunctionBegin;
  *rate = (TwistRate){0, 0};
  if (!scene->stiffness.varies && scene->curvature.strain[TURN_1].n == 0) PetscFunctionReturn(0);
  PetscCall(Twisting(scene, s, before, a));
  PetscCall(Twisting(scene, s, after, b));
  rate->flex_t = (b[0] - a[0]) / (after - before);
  rate->u0_t = (b[1] - a[1]) / (after - before);
  PetscFunctionReturn(0);
}
