/* The initial shape of a rod in space. */
#include "base/lagrange.h"
#include "base/quaternion.h"
#include "base/vectors.h"
#include "rod/space_cells.h"
#include "rod/spin_rest.h"
#include "rod/rules.h"
#include <string.h>

/* A state on the way along the initial shape: x, its rate by growth without friction, and p. */
typedef struct {
  PetscReal x[3], x_t[3], p[4];
} Shape_;
enum { SHAPE_REALS = sizeof(Shape_) / sizeof(PetscReal) };

/* Twist and bends of the initial shape, with the natural ones, per length. */
static PetscErrorCode InitialStrains(Scene scene, PetscReal s, PetscReal g, PetscReal u0[3],
                                     PetscReal u[3]) {
  PetscReal g0;

  PetscFunctionBegin;
  PetscCall(GrowthStretch(scene->growth, 1, &s, 0, &g0, NULL, NULL));
  ShapeStrains(&scene->shape, s, g0, u);
  PetscCall(CurvatureStrains(&scene->curvature, scene->growth, s, 0, u0, NULL));
  for (int k = 0; k < 3; k++) u[k] = (u[k] + u0[k]) * g0 / g; /* at other times: the same angles */
  PetscFunctionReturn(0);
}

static PetscErrorCode ShapeSlope(Scene scene, PetscReal s, PetscReal t, const Shape_ *at,
                                 Shape_ *slope) {
  PetscReal g, g_t, u0[3], u[3], d[3][3];

  PetscFunctionBegin;
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, &g, &g_t, NULL));
  PetscCall(InitialStrains(scene, s, g, u0, u));
  Directors(at->p, QuaternionSize(at->p), d);
  QuaternionTurn(at->p, u, slope->p);
  for (int k = 0; k < 4; k++) slope->p[k] *= g / 2;
  for (int k = 0; k < 3; k++) {
    slope->x[k] = g * d[0][k];
    slope->x_t[k] = g_t * d[0][k];
  }
  PetscFunctionReturn(0);
}

/* A step of the classical method of Runge and Kutta. */
static PetscErrorCode ShapeStep(Scene scene, PetscReal s, PetscReal h, PetscReal t, Shape_ *at) {
  static const PetscReal part[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  Shape_ slope[4], here;

  PetscFunctionBegin;
  for (int stage = 0; stage < 4; stage++) {
    here = *at;
    for (int k = 0; k < SHAPE_REALS && stage; k++)
      ((PetscReal *)&here)[k] += part[stage] * h * ((PetscReal *)&slope[stage - 1])[k];
    PetscCall(ShapeSlope(scene, s + part[stage] * h, t, &here, &slope[stage]));
  }
  for (int stage = 0; stage < 4; stage++)
    for (int k = 0; k < SHAPE_REALS; k++)
      ((PetscReal *)at)[k] += h * weight[stage] * ((PetscReal *)&slope[stage])[k];
  PetscFunctionReturn(0);
}

/* What there is at a label of the initial shape. */
static PetscErrorCode PlaceAt(Scene scene, PetscReal s, PetscReal t, SpinPlace *place) {
  PetscReal B;

  PetscFunctionBegin;
  place->s = s;
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, &place->g, NULL, NULL));
  PetscCall(InitialStrains(scene, s, place->g, place->u0, place->u));
  PetscCall(SceneStiffness(scene, s, t, &B, NULL));
  SceneStiffnesses(scene, B, place->S);
  PetscFunctionReturn(0);
}

/* The initial shape at n labels: where friction does not feel the spin, turned until it rests. */
static PetscErrorCode InitialPlaces(Scene scene, PetscReal t, PetscInt n, SpinPlace place[],
                                    PetscReal turn[]) {
  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) PetscCall(PlaceAt(scene, place[i].s, t, &place[i]));
  PetscCall(PetscArrayzero(turn, n));
  if (scene->load.radius == 0 && scene->clamp != CLAMP_FREE)
    PetscCall(SpinRest(n, place, scene->tip.torque, TipPoints(&scene->tip), turn));
  PetscFunctionReturn(0);
}

/* What the slope at place i of n takes from the three places from first on. */
static PetscInt PlaceSlope(PetscInt n, const SpinPlace place[], PetscInt i, PetscReal D[3]) {
  const PetscInt first = PetscMax(0, PetscMin(n - 3, i - 1));
  const PetscReal at[3] = {place[first].s, place[first + 1].s, place[first + 2].s};

  LagrangeSlopes(3, at, place[i].s, D);
  return first;
}

/* Moments about the directors of place i of n, and its twist and bends. */
static void PlaceMoments(PetscInt n, const SpinPlace place[], const PetscReal turn[], PetscInt i,
                         PetscReal m[3], PetscReal u[3]) {
  PetscReal D[3], slope = 0;
  const PetscInt first = PlaceSlope(n, place, i, D);

  for (int k = 0; k < 3; k++) slope += D[k] * turn[first + k];
  SpinTurn(&place[i], turn[i], slope, u);
  for (int k = 0; k < 3; k++) m[k] = place[i].S[k] * (u[k] - place[i].u0[k]);
}

/* Moment and force of place i of n, whose directors are d: the force along d1 is that of the
   straight rod, n = n.d1 d1 - m'/g x d1 across it, with (sum m_k d_k)' = sum m_k' d_k + g u x m. */
static void InitialForces(PetscInt n, const SpinPlace place[], const PetscReal turn[], PetscInt i,
                          const PetscReal d[3][3], PetscReal along, Node *node) {
  PetscReal m[3], u[3], other[3], D[3], curl[3], slope[3], by[3];
  const PetscInt first = PlaceSlope(n, place, i, D);

  PlaceMoments(n, place, turn, i, m, u);
  TurnBack3(d, m, node->m3);
  TurnBack3(d, u, curl);
  for (int j = 0; j < 3; j++) curl[j] *= place[i].g;
  Cross3(curl, node->m3, slope);
  for (int at = 0; at < 3; at++) {
    PlaceMoments(n, place, turn, first + at, m, other);
    TurnBack3(d, m, by);
    for (int j = 0; j < 3; j++) slope[j] += D[at] * by[j];
  }
  Cross3(slope, d[0], by);
  for (int j = 0; j < 3; j++) node->force[j] = along * d[0][j] - by[j] / place[i].g;
}

/* The node at place i of n: the curve's own frame, turned. */
static void InitialNode(PetscInt n, const SpinPlace place[], const PetscReal turn[], PetscInt i,
                        const Shape_ *at, PetscReal along, Node *node) {
  const PetscReal about[4] = {PetscCosReal(turn[i] / 2), PetscSinReal(turn[i] / 2)};
  PetscReal d[3][3];

  memset(node, 0, sizeof(*node));
  memcpy(node->x, at->x, sizeof(node->x));
  memcpy(node->x_t, at->x_t, sizeof(node->x_t));
  QuaternionTimes(at->p, about, node->p);
  Directors(node->p, QuaternionSize(node->p), d);
  InitialForces(n, place, turn, i, (const PetscReal(*)[3])d, along, node);
  RodPlanePart(node);
}

/* The labels of a mesh without those that are there twice, how many cells there are between them,
   and which of them each node has. */
static PetscInt Distinct(PetscInt last, const PetscReal mesh[], PetscReal s[], PetscInt which[]) {
  PetscInt cells = 0;

  s[0] = mesh[0];
  which[0] = 0;
  for (PetscInt i = 1; i <= last; i++) {
    if (mesh[i] > mesh[i - 1]) s[++cells] = mesh[i];
    which[i] = cells;
  }
  return cells;
}

/* The initial shape at the labels of so many cells, each of which is gone along in so many steps.
   Those on this rank are wanted: from .. end - 1. */
static PetscErrorCode ShapeAtLabels(Scene scene, PetscReal t, PetscInt cells, const PetscReal s[],
                                    PetscInt from, PetscInt end, Node nodes[]) {
  const PetscInt fine = PetscMax(1, rod_rule.start_steps / cells), n = cells * fine + 1;
  Shape_ at = {.p = {1}};
  PetscReal *force, *turn;
  SpinPlace *place;

  PetscFunctionBegin;
  SpaceClampTurn(&scene->space, t, at.p);
  PetscCall(PetscMalloc3(cells + 1, &force, n, &place, n, &turn));
  PetscCall(StraightForce(scene, cells + 1, s, t, force));
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt cell = PetscMin(i / fine, cells - 1);
    place[i].s = s[cell] + (s[cell + 1] - s[cell]) * (i - cell * fine) / fine;
  }
  PetscCall(InitialPlaces(scene, t, n, place, turn));
  for (PetscInt i = 0; i < end; i++) {
    for (PetscInt k = 0; i && k < fine; k++) {
      PetscReal h = (s[i] - s[i - 1]) / fine;
      PetscCall(ShapeStep(scene, s[i - 1] + k * h, h, t, &at));
    }
    if (i >= from) InitialNode(n, place, turn, i * fine, &at, -force[i], &nodes[i - from]);
  }
  PetscCall(PetscFree3(force, place, turn));
  PetscFunctionReturn(0);
}

/* SpaceInitial - the scene's initial shape at the owned nodes; see RodInitialNodes(). Every rank
   goes along the whole rod, in steps that are much shorter than its cells. */
PetscErrorCode SpaceInitial(Rod rod, PetscReal t, Node *nodes) {
  PetscInt *which, cells;
  PetscReal *s;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(rod->last + 1, &s, rod->last + 1, &which));
  cells = Distinct(rod->last, rod->scene->mesh.s, s, which);
  PetscCall(
      ShapeAtLabels(rod->scene, t, cells, s, which[rod->first], which[rod->end - 1] + 1, nodes));
  for (PetscInt i = rod->end - 1; i >= rod->first; i--) /* (on one rank, if any is there twice) */
    if (which[i] < i) nodes[i - rod->first] = nodes[which[i] - which[rod->first]];
  for (PetscInt i = rod->first; i < rod->end && rod->scene->growth->yield > 0; i++) {
    PetscReal *growth = nodes[i - rod->first].growth;
    growth[0] = GrowthSpeed(rod->scene->growth, rod->scene->mesh.s[i], t, 0);
    PetscCall(GrowthLength(rod->scene->growth, t, &growth[1], NULL));
  }
  PetscCall(PetscFree2(s, which));
  PetscFunctionReturn(0);
}
