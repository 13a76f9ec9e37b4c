/* What is simulated: growth, load, clamp, tip, initial shape and the mesh it lives on. */
#ifndef TENDRIL_SCENE_H
#define TENDRIL_SCENE_H

#include "scene/curvature.h"
#include "scene/growth.h"
#include "scene/load.h"
#include "scene/mesh.h"
#include "scene/shape.h"
#include "scene/si.h"
#include "scene/stiffness.h"
#include "scene/tip.h"

typedef struct _Scene *Scene;
struct _Scene {
  MPI_Comm comm; /* the ranks that share it */
  Growth growth;
  Load load;
  Stiffness stiffness;
  Tip tip;
  Shape shape;
  Curvature curvature; /* natural, k0 */
  Mesh mesh;
  Si si;
  PetscReal clamp_angle; /* alpha; the problem is solved in the clamp's frame, results are turned */
  PetscReal end_time;    /* T, -ts_max_time */
};

extern const OptionGroup scene_options;

PetscErrorCode SceneCreate(Scene *scene);
PetscErrorCode SceneDestroy(Scene *scene);
PetscErrorCode SceneCurvature(Scene scene, PetscReal s, PetscReal t, PetscReal *k);
PetscErrorCode SceneShapeAngle(Scene scene, PetscReal s, PetscReal *theta, PetscReal *theta_s);

/* B at the label s and time t. */
static inline PetscReal SceneStiffness(Scene scene, PetscReal s, PetscReal t) {
  return StiffnessAt(&scene->stiffness, scene->growth, s, t);
}

#endif
