/* What is simulated: growth, load, clamp, tip, initial shape and the mesh it lives on. */
#ifndef TENDRIL_SCENE_H
#define TENDRIL_SCENE_H

#include "world/contact.h"
#include "material/curvature.h"
#include "material/growth.h"
#include "world/load.h"
#include "material/mesh.h"
#include "scene/changes.h"
#include "material/shape.h"
#include "scene/si.h"
#include "scene/space.h"
#include "material/stiffness.h"
#include "material/tropism.h"
#include "world/tip.h"

/* s = 0: held in the clamp; in a hinge that holds its place, and keeps it from spinning, but lets
   it tilt; or free, m = 0, n = 0. Or another rod holds it, to which it is welded, or about which it
   swings, and has its conditions (system/joints.h). */
typedef enum {
  CLAMP_HELD,
  CLAMP_HINGED,
  CLAMP_FREE,
  CLAMP_BALL, /* of a rod that another one holds alone */
  CLAMP_CARRIED,
  CLAMP_SWINGS
} ClampType;

/* What a scene makes its own units of, for what has none: see rod/units.c. */
typedef struct {
  PetscReal length, time, stiffness;
  PetscReal speed;    /* at which the rod grows; else its length over the time of the run */
  PetscReal own;      /* the rod's own time */
  PetscReal brief;    /* of which short steps are a part */
  PetscBool unheld;   /* friction holds none of the rod where it begins, or not all of it */
  PetscBool straight; /* it begins so */
  PetscBool found;    /* else they are 1 */
} SceneUnits;

/* What the laws of the rod itself give at a label: SceneMaterial(). In the plane the bend is that
   about d3, and the others are 0. */
typedef struct {
  PetscReal g, g_t, c, strain; /* stretch, its rate, slide, rate of the material's stretch */
  PetscReal S[3], S_t[3];      /* stiffnesses, and their rates in the material */
  PetscReal u0[3], u0_t[3];    /* natural strains, likewise */
} Material;

/* What its laws have become in a run: SceneRemember(). Named as scene_memory_name has it. */
typedef struct {
  PetscReal falls;            /* speed of a rod that snaps; 0: it does not */
  PetscReal shared;           /* viscous share that friction was given, see LoadShareMore() */
  PetscReal firm;             /* 1: contact got firm, 0: it may, -1: it stays as it is */
  PetscReal spun, spins_from; /* by how much the clamp had turned when its rate was changed; when */
} SceneMemory;
extern const char *const scene_memory_name[];

typedef struct _Scene *Scene;
struct _Scene {
  MPI_Comm comm; /* the ranks that share it */
  Growth growth;
  Load load;
  Stiffness stiffness;
  Tip tip;
  Contact contact; /* load and tip know its walls */
  Shape shape;
  Curvature curvature; /* natural, k0 */
  Tropism tropism;     /* ... that the material learns */
  Space space;         /* what there is out of the plane */
  Mesh mesh;
  Si si;
  ClampType clamp;
  PetscReal clamp_angle; /* alpha; the problem is solved in the clamp's frame, results are turned */
  PetscReal born;     /* of one of several rods: it comes out then; 0: it is there from the start */
  PetscReal end_time; /* T, -ts_max_time */
  PetscReal reach;    /* the longest that the rod becomes */
  PetscReal stands_off; /* by how much walls at which the rod begins are taken off, at most */
  Changes changes;      /* what a run changes in all of this; NULL: nothing */
  SceneUnits units;     /* RodFindUnits() */
  PetscReal falls;      /* at this speed, in a snap: SceneAtSpeed(); 0: in none */
  PetscReal beta[3];    /* ... and what its frictions have for beta else */
};

extern const OptionGroup scene_options;

PetscErrorCode SceneCreate(Scene *scene);
PetscErrorCode SceneCreateOn(const Seat *seat, PetscBool touch, Scene *scene);
PetscErrorCode SceneDestroy(Scene *scene);
PetscErrorCode SceneShare(Scene scene, Scene *shared);
PetscErrorCode SceneShareEnd(Scene *shared);
void SceneLinkWalls(Scene scene);
void SceneAtSpeed(Scene scene, PetscReal speed);
const PetscReal *SceneLabels(Scene scene, PetscInt *nodes);
PetscErrorCode SceneLength(Scene scene, PetscReal t, PetscReal *length);
PetscErrorCode SceneStretch(Scene scene, PetscReal s, PetscReal t, PetscReal *g);
PetscErrorCode ScenePlaceAlong(Scene scene, Place *at);
PetscErrorCode SceneMaterial(Scene scene, PetscReal s, PetscReal t, Material *at);
void SceneRemember(Scene scene, SceneMemory *memory);
PetscErrorCode SceneRecall(Scene scene, const SceneMemory *memory);
PetscErrorCode SceneForce(Scene scene, PetscReal *force);
PetscErrorCode SceneContactAt(Scene scene, PetscReal t);
PetscReal SceneNextTurn(Scene scene, PetscReal t);
PetscBool SceneJerks(Scene scene, PetscReal t0, PetscReal t1);
PetscErrorCode SceneBends(Scene scene, PetscReal tolerance, Bends *bends);
PetscErrorCode SceneFewBends(Scene scene, PetscInt most, PetscReal *tolerance, Bends *bends);
void SceneAtTolerance(Scene scene, PetscReal rtol);
PetscErrorCode SceneHoldTip(Scene scene, const PetscReal x[2], PetscReal theta);
PetscErrorCode SceneHoldTip3(Scene scene, const PetscReal x[3], const PetscReal p[4]);
PetscErrorCode SceneShapeAngle(Scene scene, PetscReal s, PetscReal *theta, PetscReal *theta_s);

/* Is it still to come at a time? And is it in the equations of a step that ends there: at its birth
   it is there, and moves with the step that begins then. (Steps end at births but for round-off.)
 */
static inline PetscBool SceneToCome(const struct _Scene *scene, PetscReal t) {
  const PetscReal rounding = 1e-12;
  return (PetscBool)(scene->born > 0 && t < (1 - rounding) * scene->born);
}
static inline PetscBool SceneRests(const struct _Scene *scene, PetscReal t) {
  const PetscReal rounding = 1e-12;
  return (PetscBool)(scene->born > 0 && t <= (1 + rounding) * scene->born);
}

/* Is its beginning held by another rod? */
static inline PetscBool SceneCarried(const struct _Scene *scene) {
  return (PetscBool)(scene->clamp == CLAMP_CARRIED || scene->clamp == CLAMP_SWINGS);
}

/* A vector of the clamp's frame in the laboratory; in the plane the third component is 0. */
static inline void SceneToLab(const struct _Scene *scene, const PetscReal v[3], PetscReal lab[3]) {
  PetscReal c, s;

  if (scene->space.rod) {
    SpaceToLab(&scene->space, v, lab);
    return;
  }
  c = PetscCosReal(scene->clamp_angle);
  s = PetscSinReal(scene->clamp_angle);
  lab[0] = c * v[0] - s * v[1];
  lab[1] = s * v[0] + c * v[1];
  lab[2] = 0;
}

/* A place of the clamp's frame in the laboratory. */
static inline void ScenePlaceToLab(const struct _Scene *scene, const PetscReal x[3],
                                   PetscReal lab[3]) {
  SceneToLab(scene, x, lab);
  for (int d = 0; d < 3; d++) lab[d] += scene->space.place[d];
}

/* Says of a place which it is: label, time and, where a law asks for it, how much of the rod is on
   both sides. The rest of it is the caller's. */
static inline PetscErrorCode ScenePlace(Scene scene, PetscReal s, PetscReal t, Place *at) {
  at->s = s;
  at->t = t;
  return scene->load.along ? ScenePlaceAlong(scene, at) : (PetscErrorCode)0;
}

/* The natural curvature at the label s and time t, and the rate at which it changes for the
   material there (may be NULL). */
static inline PetscErrorCode SceneCurvature(Scene scene, PetscReal s, PetscReal t, PetscReal *k,
                                            PetscReal *k_t) {
  *k = 0;
  if (k_t) *k_t = 0;
  return scene->curvature.any ? CurvatureValue(&scene->curvature, scene->growth, s, t, k, k_t)
                              : (PetscErrorCode)0;
}

/* B at the label s and time t, and the rate B_t at which it changes for the material there (may be
   NULL). */
static inline PetscErrorCode SceneStiffness(Scene scene, PetscReal s, PetscReal t, PetscReal *B,
                                            PetscReal *B_t) {
  *B = scene->stiffness.all;
  if (B_t) *B_t = 0;
  return scene->stiffness.varies ? StiffnessTable(&scene->stiffness, scene->growth, s, t, B, B_t)
                                 : (PetscErrorCode)0;
}

/* The stiffnesses in space over those of the scales, S = B diag(C/B, 1, B3/B2): twist, bend about
   d2, bend about d3. */
static inline void SceneStiffnesses(const struct _Scene *scene, PetscReal B, PetscReal S[3]) {
  S[0] = B * scene->space.torsion;
  S[1] = B;
  S[2] = B * scene->space.ratio;
}

#endif
