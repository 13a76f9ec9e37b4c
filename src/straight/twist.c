#include "straight/twist.h"
#include "base/lagrange.h"

/* Is the tip kept from turning about the rod's axis? One that is clamped is, if no moment turns it:
   with a moment it is in a sleeve that guides it and lets it turn. */
static PetscBool TurnIsHeld(Scene scene) {
  return (PetscBool)(TipPoints(&scene->tip) && scene->tip.torque == 0);
}

static PetscBool TwistsByNature(Scene scene) {
  const Strain *twist = &scene->curvature.strain[TURN_1];
  return (PetscBool)(twist->constant != 0 || twist->n > 0);
}

/* StraightIsTwisted - does twist join the two directions across? It does where the rod bears a
   twisting moment; and where two different stiffnesses turn along it. */
PetscBool StraightIsTwisted(Scene scene) {
  const PetscBool nature = TwistsByNature(scene),
                  moment = (PetscBool)(scene->tip.torque != 0 ||
                                       (TurnIsHeld(scene) && (scene->space.spin != 0 || nature)));
  return (PetscBool)(moment || (nature && scene->space.ratio != 1));
}

/* StraightWays - the problems that a scene has: one in both directions across if they are joined;
   one in each if they differ; else one that stands for all directions. Returns how many. */
PetscInt StraightWays(Scene scene, StraightWay way[MOST_WAYS]) {
  way[0] = StraightIsTwisted(scene) ? WAY_BOTH : WAY_X2;
  way[1] = WAY_X3;
  return way[0] == WAY_X2 && scene->space.ratio != 1 ? 2 : 1;
}

/* Adds int dp / C and int u01 dp, from a to b. */
static PetscErrorCode AddPiece(Scene scene, PetscReal a, PetscReal b, PetscReal t,
                               PetscReal sum[2]) {
  const PetscReal longest = 1. / 256;
  const PetscInt pieces = 1 + (PetscInt)((b - a) / longest);
  const PetscReal h = (b - a) / pieces;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < pieces * GAUSS; k++) {
    PetscReal s = a + h * (k / GAUSS + gauss_point[k % GAUSS]), g, B, S[3], u0[3],
              dp = h * gauss_weight[k % GAUSS];
    PetscCall(GrowthStretch(scene->growth, 1, &s, t, &g, NULL, NULL));
    PetscCall(SceneStiffness(scene, s, t, &B, NULL));
    SceneStiffnesses(scene, B, S);
    PetscCall(CurvatureStrains(&scene->curvature, scene->growth, s, t, u0, NULL));
    sum[0] += dp * g / S[0];
    sum[1] += dp * g * u0[0];
  }
  PetscFunctionReturn(0);
}

/* M: the tip's; or what turns a held tip back from where the clamp and growth would have it. */
static PetscErrorCode Moment(Scene scene, PetscReal t, PetscReal *moment) {
  PetscReal start[2] = {0, 0}, now[2] = {0, 0};

  PetscFunctionBegin;
  *moment = scene->tip.torque;
  if (!TurnIsHeld(scene) || (scene->space.spin == 0 && !TwistsByNature(scene)))
    PetscFunctionReturn(0);
  PetscCall(AddPiece(scene, 0, 1, 0, start));
  PetscCall(AddPiece(scene, 0, 1, t, now));
  *moment = (start[1] - now[1] - SpaceClampAngle(&scene->space, t)) / now[0];
  PetscFunctionReturn(0);
}

/*
  StraightTwist - the twist of the straight rod at time t; without friction that feels it, the
  moment is the same all along.

  n, s     labels, increasing
  moment   M about d1, what the part beyond a section does to the part before it
  angle    n values, by which the directors d2 and d3 have turned about d1 from x2 and x3; or NULL
*/
PetscErrorCode StraightTwist(Scene scene, PetscInt n, const PetscReal s[], PetscReal t,
                             PetscReal *moment, PetscReal angle[]) {
  PetscReal sum[2] = {0, 0}, before = 0;

  PetscFunctionBegin;
  PetscCall(Moment(scene, t, moment));
  for (PetscInt i = 0; angle && i < n; i++) {
    PetscCall(AddPiece(scene, before, s[i], t, sum));
    before = s[i];
    angle[i] = SpaceClampAngle(&scene->space, t) + *moment * sum[0] + sum[1];
  }
  PetscFunctionReturn(0);
}
