/* What is simulated: growth, friction, clamp, initial shape and the mesh it lives on. */
#ifndef TENDRIL_SCENE_H
#define TENDRIL_SCENE_H

#include "scene/curvature.h"
#include "scene/friction.h"
#include "scene/growth.h"
#include "scene/mesh.h"
#include "scene/si.h"

typedef enum { SHAPE_STRAIGHT, SHAPE_SAG, SHAPE_MODE, SHAPE_RANDOM, SHAPE_FILE } ShapeType;

typedef struct {
  ShapeType type;
  PetscReal amplitude; /* eps, largest initial angle against the clamp */
  PetscInt seed;
  char file[PETSC_MAX_PATH_LEN];
  PetscInt n;                    /* knots of a tabulated shape (random, file, mode) */
  PetscReal *s, *theta, *theta2; /* its knots, angles and their second derivatives */
} Shape;

typedef struct _Scene *Scene;
struct _Scene {
  Growth growth;
  Friction friction;
  Shape shape;
  Curvature curvature; /* natural, k0 */
  Mesh mesh;
  Si si;
  PetscReal clamp_angle; /* alpha; the problem is solved in the clamp's frame, results are turned */
  PetscReal end_time;    /* T, -ts_max_time */
};

PetscErrorCode SceneCreate(Scene *scene);
PetscErrorCode SceneDestroy(Scene *scene);
PetscErrorCode SceneCurvature(Scene scene, PetscReal s, PetscReal t, PetscReal *k);
PetscErrorCode SceneShapeAngle(Scene scene, PetscReal s, PetscReal *theta, PetscReal *theta_s);
PetscErrorCode SceneSetShape(Scene scene, PetscInt n, const PetscReal s[], const PetscReal theta[]);

#endif
