/* With which force a rod is pressed on what it touches. */
#include "scene/scene.h"

/* What friction along the rod is multiplied by: the most of it along the straight rod at first, for
   where it will be is not known. */
static PetscReal FrictionFactor(const struct _Scene *scene) {
  enum { PLACES = 5 };
  PetscReal most = 0, slope[3];

  for (int k = 0; k < PLACES; k++) {
    const PetscReal x[3] = {scene->growth->initial_length * k / (PLACES - 1), 0, 0};
    most = PetscMax(most, LoadFactor(&scene->load, x, 0, slope));
  }
  return most;
}

/* The force per length of friction along the rod: its dry part, and its viscous one at the speed at
   which the rod begins to grow, or a schedule feeds it at most. */
static PetscErrorCode FrictionAlong(Scene scene, PetscReal *friction) {
  const Load *load = &scene->load;
  PetscReal length, speed;

  PetscFunctionBegin;
  PetscCall(GrowthLength(scene->growth, 0, &length, &speed));
  if (scene->growth->fastest > 0) speed = scene->growth->fastest;
  *friction =
      FrictionFactor(scene) *
      (1 - load->viscous + load->viscous * (scene->growth->still ? 0 : PetscAbsReal(speed)));
  PetscFunctionReturn(0);
}

/* How far a natural curvature is from 0 at most; of one that is random, which goes on as the rod
   gets longer, that of usual size. */
static PetscErrorCode NaturalBend(Scene scene, PetscReal *bend) {
  static const char *const random[] = {"-rod_curvature_random", "-rod_curvature_random_2"};
  PetscReal sum = 0, of_random;
  PetscBool given;

  PetscFunctionBegin;
  for (int b = BEND_3; b <= BEND_2; b++) {
    PetscCall(OptionReal(random[b], &of_random, &given));
    sum += PetscSqr(given ? PetscAbsReal(scene->curvature.strain[b].constant) + of_random
                          : CurvatureLargest(&scene->curvature, b));
  }
  *bend = PetscSqrtReal(sum);
  PetscFunctionReturn(0);
}

/*
  SceneForce - the force of usual size with which a rod presses on what it touches, whatever its
  length and the end of the run: a load f per length, of friction or weight, bends it within
  (B/f)^(1/3), and is B^(1/3) f^(2/3) over that; a bend k that is natural to it is straightened by B
  k^2, and one that is laid down in it (a knot) straightens itself by as much, as it is bent on the
  whole: where it is bent most it does so at once; what pushes its tip goes through it. (A short one
  may be pressed harder: ContactSetStiffness().) Collective.
*/
PetscErrorCode SceneForce(Scene scene, PetscReal *force) {
  const PetscReal B = scene->stiffness.most, *w = scene->load.weight, *push = scene->tip.push;
  PetscReal load = 0, bend = 0;

  PetscFunctionBegin;
  *force = 0;
  if (!scene->contact.any) PetscFunctionReturn(0);
  PetscCall(FrictionAlong(scene, &load));
  load = PetscMax(load, hypot(hypot(w[0], w[1]), w[2]));
  PetscCall(NaturalBend(scene, &bend));
  bend = PetscMax(bend, ShapeMeanBend(&scene->shape, scene->growth->initial_length));
  *force = PetscMax(PetscPowReal(B * load * load, 1. / 3), B * bend * bend / 4);
  *force = PetscMax(*force, PetscAbsReal(scene->tip.force));
  *force = PetscMax(*force, hypot(hypot(push[0], push[1]), push[2]));
  PetscFunctionReturn(0);
}
