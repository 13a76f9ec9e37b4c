#include "record/touching.h"

struct _Touching {
  Scene scene;
  Strands strands;       /* NULL: the rod does not touch itself */
  PetscReal (*force)[2]; /* per length, at nodes and middles of cells */
};

/* TouchingCreate - for a scene with contact, which must outlive it. Not collective; the caller
   destroys it with TouchingDestroy(). */
PetscErrorCode TouchingCreate(Scene scene, Touching *touching) {
  PetscFunctionBegin;
  PetscCall(PetscNew(touching));
  (*touching)->scene = scene;
  PetscCall(PetscMalloc1(2 * scene->mesh.cells + 1, &(*touching)->force));
  if (scene->contact.self) PetscCall(StrandsCreate(scene, &(*touching)->strands));
  PetscFunctionReturn(0);
}

PetscErrorCode TouchingDestroy(Touching *touching) {
  PetscFunctionBegin;
  if (!*touching) PetscFunctionReturn(0);
  PetscCall(StrandsDestroy(&(*touching)->strands));
  PetscCall(PetscFree((*touching)->force));
  PetscCall(PetscFree(*touching));
  PetscFunctionReturn(0);
}

/* A collocation point: what walls need to know of it. */
typedef struct {
  PetscReal s, g, weight, strain, x[2], v[2];
} Spot;

/* The laws at a point, and its velocity from the rate of x. */
static PetscErrorCode SpotLaws(Scene scene, PetscReal t, const PetscReal x_t[2], PetscReal theta,
                               PetscReal g_t, PetscBool moves, Spot *spot) {
  PetscReal c = moves ? GrowthSlide(scene->growth, spot->s, t) : 0;

  PetscFunctionBegin;
  spot->strain = GrowthStrain(scene->growth, spot->s, t, g_t);
  spot->v[0] = x_t[0] + c * PetscCosReal(theta);
  spot->v[1] = x_t[1] + c * PetscSinReal(theta);
  PetscFunctionReturn(0);
}

/* Node i; or the middle of the cell behind it, y = (y_a + y_b)/2 + h/8 (y'_a - y'_b). */
static PetscErrorCode SpotOf(Scene scene, PetscReal t, const Node *nodes, PetscBool moves,
                             PetscInt i, int half, Spot *spot) {
  const PetscReal *s = scene->mesh.s, h = half ? s[i + 1] - s[i] : 0;
  PetscReal g[2], g_t[2], x_t[2] = {nodes[i].x_t[0], nodes[i].x_t[1]}, theta = nodes[i].theta;

  PetscFunctionBegin;
  spot->s = half ? (s[i] + s[i + 1]) / 2 : s[i];
  for (int d = 0; d < 2; d++) spot->x[d] = nodes[i].x[d];
  if (half) {
    PetscCall(GrowthStretch(scene->growth, 2, &s[i], t, g, g_t, NULL));
    theta = (nodes[i].theta + nodes[i + 1].theta) / 2;
    for (int d = 0; d < 2; d++) spot->x[d] = x_t[d] = 0;
    for (int e = 0; e < 2; e++) {
      const Node *n = &nodes[i + e];
      PetscReal q[2] = {PetscCosReal(n->theta), PetscSinReal(n->theta)}, k = e ? -h / 8 : h / 8;
      for (int d = 0; d < 2; d++) {
        spot->x[d] += n->x[d] / 2 + k * g[e] * q[d];
        x_t[d] += n->x_t[d] / 2 + k * (g_t[e] * q[d] + g[e] * n->theta_t * (d ? q[0] : -q[1]));
      }
    }
  }
  PetscCall(GrowthStretch(scene->growth, 1, &spot->s, t, &spot->g, g_t, NULL));
  PetscCall(SpotLaws(scene, t, x_t, theta, g_t[0], moves, spot));
  spot->weight = 4 * h / 6;
  if (half) PetscFunctionReturn(0);
  if (i > 0) spot->weight += (s[i] - s[i - 1]) / 6;
  if (i < scene->mesh.cells) spot->weight += (s[i + 1] - s[i]) / 6;
  PetscFunctionReturn(0);
}

/* Adds one wall's push on a point, which stands for `length` of the rod. */
static void AddWall(const Contact *contact, const Touch *touch, const Spot *spot, PetscReal length,
                    PetscReal force[2], TouchSum *sum) {
  PetscReal U = ContactEnergy(contact, touch->gap);
  Push push;

  ContactPush(contact, touch, spot->v, NULL, &push);
  sum->energy += length * U;
  sum->loss += length * push.power;
  sum->normal += length * push.normal;
  for (int d = 0; d < 2; d++) {
    force[d] += push.force[d];
    sum->wall[d] += length * push.force[d];
  }
}

/* The walls on one point, and on the tip besides if it is the last; do they touch it? */
static PetscBool Walls1(Touching self, const Spot *spot, PetscBool tip, PetscReal force[2],
                        TouchSum *sum) {
  const Contact *contact = &self->scene->contact;
  const PetscReal anywhere = 1e300, length = spot->g * spot->weight;
  PetscReal nearest = anywhere, on_tip[2] = {0, 0};
  Touch touch[MOST_TOUCHES];
  PetscInt n = WallsTouch(&contact->walls, spot->x, contact->diameter / 2, anywhere, touch);

  for (PetscInt k = 0; k < n; k++) {
    nearest = PetscMin(nearest, touch[k].gap);
    sum->strain += spot->strain * spot->weight * ContactEnergy(contact, touch[k].gap);
    AddWall(contact, &touch[k], spot, length, force, sum);
    if (tip) AddWall(contact, &touch[k], spot, contact->tip, on_tip, sum);
  }
  for (int d = 0; d < 2 && tip; d++) sum->tip[d] += contact->tip * on_tip[d];
  if (nearest < sum->nearest) {
    sum->nearest = nearest;
    sum->at[0] = spot->s;
    sum->at[1] = -1;
    for (int d = 0; d < 2; d++) sum->x[d] = spot->x[d];
  }
  sum->depth = PetscMax(sum->depth, -nearest);
  return (PetscBool)(nearest <= 0);
}

/* All walls. */
static PetscErrorCode LookAtWalls(Touching self, PetscReal t, const Node *nodes, PetscBool moves,
                                  TouchSum *sum) {
  const PetscInt cells = self->scene->mesh.cells;
  PetscBool before = PETSC_FALSE;
  Spot spot;

  PetscFunctionBegin;
  for (PetscInt k = 0; k <= 2 * cells; k++) {
    PetscBool touches;
    PetscCall(SpotOf(self->scene, t, nodes, moves, k / 2, (int)(k % 2), &spot));
    touches = Walls1(self, &spot, (PetscBool)(k == 2 * cells && self->scene->tip.type == TIP_FREE),
                     self->force[k], sum);
    sum->zones += touches && !before;
    before = touches;
  }
  PetscFunctionReturn(0);
}

/* All of the rod's own strands. */
static PetscErrorCode LookAtStrands(Touching self, PetscReal t, const Node *nodes, PetscBool moves,
                                    TouchSum *sum) {
  const PetscReal *s = self->scene->mesh.s;
  const PetscInt points = 2 * self->scene->mesh.cells + 1;
  const PetscReal(*force)[2];
  StrandState state = {
      .t = t, .stride = NODE_VALUES, .u = nodes[0].x, .u_t = moves ? nodes[0].x_t : NULL};
  StrandSum strands;

  PetscFunctionBegin;
  PetscCall(StrandsSearch(self->strands, &state));
  PetscCall(StrandsLoad(self->strands, &state));
  StrandsSum(self->strands, &strands);
  force = StrandsForces(self->strands);
  for (PetscInt k = 0; k < points; k++) {
    PetscReal g, z = k % 2 ? (s[k / 2] + s[k / 2 + 1]) / 2 : s[k / 2];
    PetscCall(GrowthStretch(self->scene->growth, 1, &z, t, &g, NULL, NULL));
    for (int d = 0; d < 2; d++) self->force[k][d] -= force[k][d] / g;
  }
  sum->energy += strands.energy;
  sum->loss += strands.loss;
  sum->strain += strands.strain;
  sum->normal += strands.normal;
  sum->depth = PetscMax(sum->depth, strands.depth);
  sum->zones += StrandsZones(self->strands);
  for (int d = 0; d < 2; d++) sum->tip[d] += force[points][d];
  if (strands.nearest < sum->nearest) {
    sum->nearest = strands.nearest;
    for (int k = 0; k < 2; k++) {
      sum->at[k] = strands.at[k];
      sum->x[k] = strands.x[k];
    }
  }
  PetscFunctionReturn(0);
}

/*
  TouchingLook - all that contact amounts to at one time. Not collective.

  nodes  cells + 1 nodes, all of the rod    moves  their rates are known
  force  out, per length: at nodes and between them, 2 cells + 1, in the clamp's frame; borrowed
*/
PetscErrorCode TouchingLook(Touching self, PetscReal t, const Node *nodes, PetscBool moves,
                            TouchSum *sum, const PetscReal (**force)[2]) {
  PetscFunctionBegin;
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  PetscCall(PetscArrayzero(self->force, 2 * self->scene->mesh.cells + 1));
  sum->nearest = PETSC_MAX_REAL;
  if (self->scene->contact.walls.n) PetscCall(LookAtWalls(self, t, nodes, moves, sum));
  if (self->strands) PetscCall(LookAtStrands(self, t, nodes, moves, sum));
  *force = (const PetscReal(*)[2])self->force;
  PetscFunctionReturn(0);
}
