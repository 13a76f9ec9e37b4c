#include "scene/scene.h"
#include "base/hdf.h"
#include "base/options.h"
#include "base/spline.h"

enum { RANDOM_KNOTS = 201, RANDOM_MODES = 8 };

/*
  SceneSetShape - gives the initial shape by its angle against the clamp at n labels (splined).

  s, theta   copied; s must run from 0 to 1 and theta[0] be 0
*/
PetscErrorCode SceneSetShape(Scene scene, PetscInt n, const PetscReal s[],
                             const PetscReal theta[]) {
  Shape *shape = &scene->shape;

  PetscFunctionBegin;
  PetscCall(PetscFree3(shape->s, shape->theta, shape->theta2));
  PetscCall(PetscMalloc3(n, &shape->s, n, &shape->theta, n, &shape->theta2));
  shape->n = n;
  PetscCall(PetscArraycpy(shape->s, s, n));
  PetscCall(PetscArraycpy(shape->theta, theta, n));
  PetscCall(SplineSecondDerivatives(n, shape->s, 1, n, 1, shape->theta, shape->theta2));
  PetscFunctionReturn(0);
}

static PetscErrorCode ShapeFromFile(Scene scene) {
  const char *file = scene->shape.file;
  PetscReal *s, *theta;
  hsize_t n, m;

  PetscFunctionBegin;
  PetscCall(HdfRead("-shape_file", file, "/s", 1, &n, &s));
  PetscCall(HdfRead("-shape_file", file, "/theta", 1, &m, &theta));
  UserCheck(n == m, PETSC_COMM_WORLD, "-shape_file %s: /s and /theta differ in length", file);
  UserCheck(n >= 4 && n <= 5000, PETSC_COMM_WORLD,
            "-shape_file %s: needs 4 to 5000 entries, has %d", file, (int)n);
  UserCheck(PetscAbsReal(s[0]) < 1e-12 && PetscAbsReal(s[n - 1] - 1) < 1e-12, PETSC_COMM_WORLD,
            "-shape_file %s: /s must run from 0 to 1", file);
  for (hsize_t i = 1; i < n; i++)
    UserCheck(s[i] > s[i - 1], PETSC_COMM_WORLD, "-shape_file %s: /s must increase", file);
  UserCheck(PetscAbsReal(theta[0]) < 1e-9, PETSC_COMM_WORLD,
            "-shape_file %s: /theta is measured against the clamp and must start at 0", file);
  theta[0] = 0;
  PetscCall(SceneSetShape(scene, (PetscInt)n, s, theta));
  PetscCall(PetscFree(s));
  PetscCall(PetscFree(theta));
  PetscFunctionReturn(0);
}

/* A seeded sum of smooth modes, theta' = (1-s)^2 sum_k c_k cos(k pi s) / k^2, c_k even in [-1,1]:
   each meets kappa(1) = kappa'(1) = 0. Scaled so that max |theta| = eps. */
static PetscErrorCode ShapeAtRandom(Scene scene) {
  PetscReal s[RANDOM_KNOTS], theta[RANDOM_KNOTS], c[RANDOM_MODES], most = 0;
  PetscRandom random;

  PetscFunctionBegin;
  PetscCall(PetscRandomCreate(PETSC_COMM_SELF, &random));
  PetscCall(PetscRandomSetType(random, PETSCRANDER48));
  PetscCall(PetscRandomSetInterval(random, -1, 1));
  PetscCall(PetscRandomSetSeed(random, (unsigned long)scene->shape.seed));
  PetscCall(PetscRandomSeed(random));
  for (int k = 0; k < RANDOM_MODES; k++) PetscCall(PetscRandomGetValueReal(random, &c[k]));
  PetscCall(PetscRandomDestroy(&random));
  s[0] = theta[0] = 0;
  for (int i = 1; i < RANDOM_KNOTS; i++) {
    s[i] = (PetscReal)i / (RANDOM_KNOTS - 1);
    theta[i] = theta[i - 1];
    for (int q = 0; q < 3; q++) { /* Gauss-Legendre, 3 points */
      const PetscReal at[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
      PetscReal h = s[i] - s[i - 1], z = s[i - 1] + h * at[q], slope = 0;
      for (int k = 0; k < RANDOM_MODES; k++)
        slope += c[k] * PetscCosReal((k + 1) * PETSC_PI * z) / PetscSqr(k + 1);
      theta[i] += h * (q == 1 ? 4. : 2.5) / 9 * PetscSqr(1 - z) * slope;
    }
    most = PetscMax(most, PetscAbsReal(theta[i]));
  }
  for (int i = 0; i < RANDOM_KNOTS; i++) theta[i] *= scene->shape.amplitude / most;
  PetscCall(SceneSetShape(scene, RANDOM_KNOTS, s, theta));
  PetscFunctionReturn(0);
}

static PetscErrorCode ShapeSetFromOptions(Scene scene) {
  const char *const types[] = {"straight", "sag", "mode", "random", "file"};
  Shape *shape = &scene->shape;
  PetscInt choice = SHAPE_SAG;
  PetscBool set = PETSC_FALSE;

  PetscFunctionBegin;
  shape->amplitude = 0.01;
  shape->seed = 1;
  PetscCall(OptionsHeading("Initial shape"));
  PetscCall(OptionList("-shape_type", "initial shape", 5, types, &choice, NULL));
  shape->type = (ShapeType)choice;
  if (choice != SHAPE_STRAIGHT && choice != SHAPE_FILE)
    PetscCall(OptionReal("-shape_amplitude", "eps, largest initial angle, in radians", -6.5, 6.5,
                         &shape->amplitude, NULL));
  if (choice == SHAPE_RANDOM) {
    PetscCall(
        OptionInt("-shape_seed", "seed of the random shape", 0, PETSC_MAX_INT, &shape->seed, NULL));
    PetscCall(ShapeAtRandom(scene));
  }
  if (choice == SHAPE_FILE) {
    PetscCall(OptionString("-shape_file",
                           "HDF5 file with /s and /theta, the angle against the clamp", shape->file,
                           sizeof(shape->file), &set));
    UserCheck(set, PETSC_COMM_WORLD, "-shape_type file needs -shape_file FILE");
    PetscCall(ShapeFromFile(scene));
  }
  PetscFunctionReturn(0);
}

/*
  SceneShapeAngle - the initial angle against the clamp and its derivative by s, at one label.
  sag: theta = eps (1 - (1-s)^3), the cantilever under a uniform side load. A natural curvature
  comes on top, so that the tip bears no moment whatever the shape.
*/
PetscErrorCode SceneShapeAngle(Scene scene, PetscReal s, PetscReal *theta, PetscReal *theta_s) {
  const Shape *shape = &scene->shape;

  PetscFunctionBegin;
  PetscCall(CurvatureAngle(&scene->curvature, scene->growth, s, theta, theta_s));
  if (shape->type == SHAPE_SAG) {
    *theta += shape->amplitude * (1 - (1 - s) * (1 - s) * (1 - s));
    *theta_s += shape->amplitude * 3 * (1 - s) * (1 - s);
  } else if (shape->n) {
    PetscReal value[4], slope[4];
    PetscInt i;
    SplineWeights(shape->n, shape->s, s, &i, value, slope, NULL);
    for (int k = 0; k < 2; k++) {
      *theta += value[k] * shape->theta[i + k] + value[2 + k] * shape->theta2[i + k];
      *theta_s += slope[k] * shape->theta[i + k] + slope[2 + k] * shape->theta2[i + k];
    }
  }
  PetscFunctionReturn(0);
}

/* SceneCurvature - the natural curvature at one label and time. */
PetscErrorCode SceneCurvature(Scene scene, PetscReal s, PetscReal t, PetscReal *k) {
  PetscFunctionBegin;
  PetscCall(CurvatureValue(&scene->curvature, scene->growth, s, t, k));
  PetscFunctionReturn(0);
}

/*
  SceneCreate - reads and checks all options that say what is simulated, and places the nodes.
  Collective; the caller destroys the scene with SceneDestroy().
*/
PetscErrorCode SceneCreate(Scene *scene) {
  const char *const gradings[] = {"uniform", "growth"};
  PetscInt cells = 500, grading = 1;
  char text[2][32];
  Scene self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  PetscCall(GrowthCreate(&self->growth));
  PetscCall(FrictionSetFromOptions(&self->friction));
  PetscCall(SiSetFromOptions(&self->si, &self->friction));
  PetscCall(OptionsHeading("Rod"));
  PetscCall(OptionReal("-clamp_angle", "alpha, direction of the clamp, in radians", -1e3, 1e3,
                       &self->clamp_angle, NULL));
  PetscCall(ShapeSetFromOptions(self));
  PetscCall(OptionInt("-rod_cells", "N, so N + 1 nodes", 4, 20000000, &cells, NULL));
  PetscCall(OptionList("-rod_grading",
                       "node placement: equidistant in s, or denser where the rod grows", 2,
                       gradings, &grading, NULL));
  self->end_time = 40;
  PetscCall(OptionReal("-ts_max_time", "end of the run", 1e-12, 1e6, &self->end_time, NULL));
  UserCheck(self->end_time <= self->growth->end_time * (1 + 1e-12), PETSC_COMM_WORLD,
            "-ts_max_time %s: the growth table ends at t = %s",
            OptionNumber(self->end_time, text[0]), OptionNumber(self->growth->end_time, text[1]));
  PetscCall(CurvatureSetFromOptions(&self->curvature, self->growth, self->end_time));
  PetscCall(MeshCreate(cells, (PetscBool)grading, self->growth, self->end_time, &self->mesh));
  *scene = self;
  PetscFunctionReturn(0);
}

PetscErrorCode SceneDestroy(Scene *scene) {
  PetscFunctionBegin;
  if (!*scene) PetscFunctionReturn(0);
  PetscCall(CurvatureDestroy(&(*scene)->curvature));
  PetscCall(GrowthDestroy(&(*scene)->growth));
  PetscCall(MeshDestroy(&(*scene)->mesh));
  PetscCall(PetscFree3((*scene)->shape.s, (*scene)->shape.theta, (*scene)->shape.theta2));
  PetscCall(PetscFree(*scene));
  PetscFunctionReturn(0);
}
