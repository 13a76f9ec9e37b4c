#include "record/touching.h"
#include "base/knots.h"
#include "curve/cell.h"
#include "rod/directors.h"

struct _Touching {
  Scene scene;
  const PetscReal *s; /* labels of the nodes, */
  PetscInt cells;     /* one more than these */
  PetscBool space;    /* the rod is in space */
  Strands strands;    /* NULL: it does not touch itself, */
  TouchingTell tell;  /* or who knows of several rods tells; NULL: nobody */
  void *ctx;
  PetscInt rod;             /* ... which it is */
  PetscReal (*force)[PUSH]; /* per length, at nodes and middles of cells */
  SampleLaw *law;           /* of a rod in space, at the time of the latest look, likewise */
  PetscInt likely;          /* the node that was nearest to a wall */
  PetscInt feet, room;      /* cells that have feet, in their order */
  TouchFeet *foot;
};

/* TouchingCreate - for a scene with contact, which must outlive it. Not collective; the caller
   destroys it with TouchingDestroy(). */
PetscErrorCode TouchingCreate(Scene scene, Touching *touching) {
  PetscInt nodes;

  PetscFunctionBegin;
  PetscCall(PetscNew(touching));
  (*touching)->scene = scene;
  (*touching)->s = SceneLabels(scene, &nodes);
  (*touching)->cells = nodes - 1;
  (*touching)->space = scene->space.rod;
  PetscCall(PetscMalloc1(2 * nodes - 1, &(*touching)->force));
  if ((*touching)->space) PetscCall(PetscMalloc1(2 * nodes - 1, &(*touching)->law));
  if (scene->contact.self && !scene->contact.among)
    PetscCall(StrandsCreate(scene, &(*touching)->strands));
  PetscFunctionReturn(0);
}

/* TouchingAmong - it is one of several rods: who knows all of them tells of strands. */
void TouchingAmong(Touching self, TouchingTell tell, void *ctx, PetscInt rod) {
  self->tell = tell;
  self->ctx = ctx;
  self->rod = rod;
}

PetscErrorCode TouchingDestroy(Touching *touching) {
  PetscFunctionBegin;
  if (!*touching) PetscFunctionReturn(0);
  PetscCall(StrandsDestroy(&(*touching)->strands));
  PetscCall(PetscFree((*touching)->force));
  PetscCall(PetscFree((*touching)->law));
  PetscCall(PetscFree((*touching)->foot));
  PetscCall(PetscFree(*touching));
  PetscFunctionReturn(0);
}

/* A collocation point: what walls need to know of it. */
typedef struct {
  PetscReal s, x[3], v[3]; /* x3 = 0 */
  PetscReal length, length_t;
} Spot;

/* By how much the angle in the middle of a cell is more than the mean of its ends', which counts
   where material slides along a wall that rubs: h/8 (theta'_a - theta'_b). */
static PetscErrorCode Bow(const Touching self, PetscReal t, const Node *nodes, PetscInt i,
                          const PetscReal g[], PetscReal *bow) {
  const Scene scene = self->scene;
  const PetscReal *s = self->s + i, h = s[1] - s[0];

  PetscFunctionBegin;
  *bow = 0;
  if (!scene->contact.walls.rub || !scene->growth->slides) PetscFunctionReturn(0);
  for (int e = 0; e < 2; e++) {
    PetscReal B, k0;
    PetscCall(SceneStiffness(scene, s[e], t, &B, NULL));
    PetscCall(SceneCurvature(scene, s[e], t, &k0, NULL));
    if (scene->tropism.any) k0 += nodes[i + e].learned[0].bend[0];
    *bow += (e ? -h / 8 : h / 8) * g[e] * (nodes[i + e].moment / B + k0);
  }
  PetscFunctionReturn(0);
}

/* The place and its rate in the middle of a cell, y = (y_a + y_b)/2 + h/8 (y'_a - y'_b), g and g_t
   at its ends. */
static void MidOf(const Node *a, PetscReal h, const PetscReal g[], const PetscReal g_t[],
                  Vector2 *x, Vector2 *x_t) {
  *x = *x_t = (Vector2){0, 0};
  for (int e = 0; e < 2; e++) {
    const Node *n = a + e;
    const Vector2 q = {PetscCosReal(n->theta), PetscSinReal(n->theta)},
                  slope_t = Along2(Times2(g_t[e], q), g[e] * n->theta_t, Left2(q));
    const PetscReal k = e ? -h / 8 : h / 8;
    *x = Plus2(*x, CurveMidOf2(k * g[e], From2(n->x), q));
    *x_t = Plus2(*x_t, CurveMidOf2(k, From2(n->x_t), slope_t));
  }
}

/* Node i; or the middle of the cell behind it. */
static PetscErrorCode SpotOf(const Touching self, PetscReal t, const Node *nodes, PetscBool moves,
                             PetscInt i, int half, Spot *spot) {
  const Scene scene = self->scene;
  const Growth growth = scene->growth;
  const PetscReal *s = self->s, h = half ? s[i + 1] - s[i] : 0;
  PetscReal g[2], g_t[2], theta = nodes[i].theta, weight = 4 * h / 6, strain, c;
  Vector2 x = From2(nodes[i].x), x_t = From2(nodes[i].x_t);

  PetscFunctionBegin;
  *spot = (Spot){.s = half ? (s[i] + s[i + 1]) / 2 : s[i]};
  if (half) {
    PetscCall(GrowthStretch(growth, 2, &s[i], t, g, g_t, NULL));
    PetscCall(Bow(self, t, nodes, i, g, &theta));
    theta += (nodes[i].theta + nodes[i + 1].theta) / 2;
    MidOf(&nodes[i], h, g, g_t, &x, &x_t);
  }
  PetscCall(GrowthStretch(growth, 1, &spot->s, t, g, g_t, NULL));
  c = moves ? GrowthSlide(growth, spot->s, t) : 0;
  strain = GrowthStrain(growth, spot->s, t, g_t[0]);
  Put2(x, spot->x);
  Put2(Along2(x_t, c, (Vector2){PetscCosReal(theta), PetscSinReal(theta)}), spot->v);
  if (!half && i > 0) weight += (s[i] - s[i - 1]) / 6;
  if (!half && i < self->cells) weight += (s[i + 1] - s[i]) / 6;
  spot->length = g[0] * weight;
  spot->length_t = strain * weight + (spot->s > 0 ? 0 : c); /* at the clamp: what comes in there */
  PetscFunctionReturn(0);
}

/* Adds one wall's push on a point, which stands for `length` of the rod, and for length_t more
   after a unit of time. */
static void AddWall(int dims, const Contact *contact, const Touch *touch, const Rubbed *at,
                    PetscReal length, PetscReal length_t, PetscReal force[PUSH], TouchSum *sum) {
  PetscReal U = ContactEnergy(contact, touch->gap);
  Push push;

  ContactPush(dims, contact, touch, at, NULL, &push);
  sum->energy += length * U;
  sum->strain += length_t * U + length * ContactEnergyRate(contact, touch->gap);
  sum->loss += length * push.power;
  sum->normal += length * push.normal;
  for (int d = 0; d < 3; d++) {
    if (touch->moves) sum->moved += length * push.force[d] * touch->v[d];
    force[d] += push.force[d];
    sum->wall[d] += length * push.force[d];
  }
  force[SPIN] += push.couple;
}

/* TouchingWalls - the walls on one point, and on the tip besides if it is that; do they touch it?
   bound: what is farther is not the nearest. */
PetscBool TouchingWalls(int dims, const Contact *contact, const WallSpot *spot, PetscReal bound,
                        PetscReal force[PUSH], TouchSum *sum) {
  const Rubbed *at = &spot->at;
  const PetscReal within = PetscMax(contact->smooth, PetscMin(sum->nearest, bound)),
                  gap = ContactGap(dims, contact, at->x, within);
  PetscReal on_tip[PUSH] = {0};
  Touch touch[MOST_TOUCHES];
  PetscInt n = gap < contact->smooth ? ContactTouches(dims, contact, at->x, touch) : 0;

  for (PetscInt k = 0; k < n; k++) {
    AddWall(dims, contact, &touch[k], at, spot->length, spot->length_t, force, sum);
    if (spot->tip) AddWall(dims, contact, &touch[k], at, contact->tip, contact->tip_t, on_tip, sum);
  }
  for (int d = 0; d < PUSH && spot->tip; d++) sum->tip[d] += contact->tip * on_tip[d];
  if (gap < within) TouchNearest(sum, gap, spot->s, at->x);
  return ContactBears(contact, gap);
}

/* Room for what the feet of one more cell add, 0 so far; valid until the next one. */
static PetscErrorCode AddCell(Touching self, PetscInt cell, TouchFeet **feet) {
  PetscFunctionBegin;
  if (self->feet == self->room) {
    self->room = 2 * self->room + 8;
    PetscCall(PetscRealloc((size_t)self->room * sizeof(TouchFeet), &self->foot));
  }
  *feet = &self->foot[self->feet++];
  **feet = (TouchFeet){.cell = cell};
  PetscFunctionReturn(0);
}

/* What one foot amounts to. */
static void AddFoot(const Contact *contact, const FootCell *cell, const Feet *feet, PetscInt k,
                    TouchSum *sum) {
  const Foot *foot = &feet->foot[k];
  const Touch *touch = &feet->touch[k];
  const PetscReal U = ContactEnergy(contact, touch->gap),
                  strength_t = foot->strength_t + FootShareRate(contact, cell, feet, k);

  sum->energy += foot->strength * U;
  sum->strain += strength_t * U + foot->strength * ContactEnergyRate(contact, touch->gap);
  sum->normal += foot->normal;
  sum->loss += foot->power;
  for (int d = 0; d < 3; d++) {
    if (touch->moves) sum->moved += foot->force[d] * touch->v[d];
    sum->wall[d] += foot->force[d];
  }
}

/*
  TouchingCell - all feet of cell i.

  touches  one does      load  what they add to its points; NULL: there are none
*/
PetscErrorCode TouchingCell(Touching self, PetscInt i, const FootCell *cell, TouchSum *sum,
                            PetscBool *touches, const PetscReal (**load)[FOOT_LOAD]) {
  const Contact *contact = &self->scene->contact;
  const PetscReal *s = self->s;
  TouchFeet *room = NULL;
  Feet feet;

  PetscFunctionBegin;
  *touches = PETSC_FALSE;
  *load = NULL;
  FeetFind(contact, cell, PetscMax(contact->smooth, sum->nearest), &feet);
  if (!feet.n) PetscFunctionReturn(0);
  FeetPush(contact, cell, NULL, &feet);
  PetscCall(AddCell(self, i, &room));
  FeetHandOut(cell, &feet, room->load);
  *load = (const PetscReal(*)[FOOT_LOAD])room->load;
  for (PetscInt k = 0; k < feet.n; k++) {
    const CurvePlace *on = &feet.foot[k].on;
    AddFoot(contact, cell, &feet, k, sum);
    TouchNearest(sum, feet.touch[k].gap, s[i] + on->z * (s[i + 1] - s[i]), on->x);
    if (ContactBears(contact, feet.touch[k].gap)) *touches = PETSC_TRUE;
  }
  PetscFunctionReturn(0);
}

/* Cell i, for its feet. */
static PetscErrorCode FeetsCell(const Touching self, PetscReal t, const Node *nodes,
                                PetscBool moves, PetscInt i, FootCell *cell) {
  const PetscReal *at = self->s + i;
  const Growth growth = self->scene->growth;
  CurveCell *curve = &cell->curve;
  PetscReal g_t[2];

  PetscFunctionBegin;
  *cell = (FootCell){.dims = 2, .moves = moves, .weight = {1. / 6, 4. / 6, 1. / 6}};
  curve->h = at[1] - at[0];
  cell->first = (PetscBool)(i == 0);
  cell->last = (PetscBool)(i == self->cells - 1);
  PetscCall(GrowthStretch(growth, 2, at, t, curve->g, g_t, NULL));
  for (int k = 0; k < FOOT_PARTS; k++)
    curve->c[k] = GrowthSlide(growth, (at[k / 2] + at[(k + 1) / 2]) / 2, t);
  for (int e = 0; e < 2; e++) {
    const Node *node = &nodes[i + e];
    const Vector2 q = {PetscCosReal(node->theta), PetscSinReal(node->theta)};
    Put2(q, curve->q[e]);
    Put2(Along2(Times2(g_t[e], q), curve->g[e] * node->theta_t, Left2(q)), curve->slope_t[e]);
    Put2(From2(node->x), curve->x[e]);
    Put2(From2(node->x_t), curve->x_t[e]);
  }
  PetscFunctionReturn(0);
}

/* All posts that are met at their feet; touches: of each cell, does one touch it? */
static PetscErrorCode LookAtPosts(Touching self, PetscReal t, const Node *nodes, PetscBool moves,
                                  PetscBool touches[], TouchSum *sum) {
  const PetscReal(*load)[FOOT_LOAD];
  FootCell cell;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < self->cells && self->scene->contact.thin; i++) {
    PetscCall(FeetsCell(self, t, nodes, moves, i, &cell));
    PetscCall(TouchingCell(self, i, &cell, sum, &touches[i], &load));
  }
  PetscFunctionReturn(0);
}

/* All walls: posts first, for a zone of contact may be between two points. */
static PetscErrorCode LookAtWalls(Touching self, PetscReal t, const Node *nodes, PetscBool moves,
                                  TouchSum *sum) {
  const PetscInt cells = self->cells;
  PetscBool before = PETSC_FALSE, *at_feet;
  Spot spot;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(cells + 1, &at_feet));
  PetscCall(LookAtPosts(self, t, nodes, moves, at_feet, sum));
  for (PetscInt k = 0; k <= 2 * cells; k++) {
    PetscBool touches;
    PetscCall(SpotOf(self, t, nodes, moves, k / 2, (int)(k % 2), &spot));
    const WallSpot at = {.at = {.x = spot.x, .v = spot.v},
                         .s = spot.s,
                         .length = spot.length,
                         .length_t = spot.length_t,
                         .tip = (PetscBool)(k == 2 * cells && self->scene->tip.type == TIP_FREE)};
    touches = TouchingWalls(2, &self->scene->contact, &at, INFINITY, self->force[k], sum);
    touches = (PetscBool)(touches || (k % 2 && at_feet[k / 2]));
    sum->zones += touches && !before;
    before = touches;
  }
  PetscCall(PetscFree(at_feet));
  PetscFunctionReturn(0);
}

/* The part of a vector along the tangent at a node, or, half way, along the sum of those beside. */
static PetscReal AboutTangent(const Node *nodes, PetscInt point, const PetscReal v[3]) {
  PetscReal q[3] = {0}, d[3][3];

  for (PetscInt i = point / 2; i <= (point + 1) / 2; i++) {
    Directors(nodes[i].p, QuaternionSize(nodes[i].p), d);
    for (int k = 0; k < 3; k++) q[k] += d[0][k];
  }
  return Dot3(q, v) / PetscSqrtReal(Dot3(q, q));
}

/* What the rod's own strands do. */
static PetscErrorCode OwnStrands(Touching self, PetscReal t, const Node *nodes, PetscBool moves,
                                 StrandsOn *on) {
  const StrandState state = {.t = t,
                             .stride = NODE_VALUES,
                             .between = self->space ? 0 : NODE_BETWEEN,
                             .u = nodes[0].x,
                             .u_t = moves ? nodes[0].x_t : NULL};

  PetscFunctionBegin;
  PetscCall(StrandsSearch(self->strands, &state));
  PetscCall(StrandsLoad(self->strands, &state));
  StrandsSum(self->strands, 0, &on->sum);
  on->force = StrandsForces(self->strands);
  on->couple = StrandsCouples(self->strands);
  PetscFunctionReturn(0);
}

/* All strands that the rod touches. */
static PetscErrorCode LookAtStrands(Touching self, PetscReal t, const Node *nodes, PetscBool moves,
                                    TouchSum *sum) {
  const PetscReal *s = self->s;
  const PetscInt points = 2 * self->cells + 1;
  const PetscReal(*force)[3], (*couple)[3];
  StrandsOn on;

  PetscFunctionBegin;
  if (self->tell)
    PetscCall(self->tell(self->ctx, self->rod, t, moves, &on));
  else
    PetscCall(OwnStrands(self, t, nodes, moves, &on));
  force = on.force;
  couple = on.couple;
  for (PetscInt k = 0; k < points; k++) {
    PetscReal g, z = k % 2 ? (s[k / 2] + s[k / 2 + 1]) / 2 : s[k / 2];
    PetscCall(SceneStretch(self->scene, z, t, &g));
    for (int d = 0; d < 3; d++) self->force[k][d] -= force[k][d] / g;
    if (couple) self->force[k][3] -= AboutTangent(nodes, k, couple[k]) / g;
  }
  sum->energy += on.sum.energy;
  sum->loss += on.sum.loss;
  sum->strain += on.sum.strain;
  sum->normal += on.sum.normal;
  sum->zones += on.sum.zones;
  sum->given += on.sum.moved;
  for (int d = 0; d < 3; d++) {
    sum->tip[d] += force[points][d];
    sum->clamp[d] += on.sum.clamp[d];
  }
  if (couple) sum->tip[SPIN] += AboutTangent(nodes, points - 1, couple[points]);
  if (on.sum.nearest < sum->nearest) {
    sum->nearest = on.sum.nearest;
    for (int k = 0; k < 2; k++) sum->at[k] = on.sum.at[k];
    for (int d = 0; d < 3; d++) sum->x[d] = on.sum.x[d];
  }
  PetscFunctionReturn(0);
}

/*
  TouchingLook - all that contact amounts to at one time. Not collective.

  nodes  cells + 1 nodes, all of the rod    moves  their rates are known
  asks   if for powers alone, sum's gaps, depths and zones say nothing
  force  out, per length: at nodes and between them, 2 cells + 1, in the clamp's frame, in space
  with the couple about the tangent behind it; borrowed
*/
PetscErrorCode TouchingLook(Touching self, PetscReal t, const Node *nodes, PetscBool moves,
                            TouchingAsks asks, TouchSum *sum, const PetscReal (**force)[PUSH]) {
  PetscFunctionBegin;
  PetscCall(SceneContactAt(self->scene, t));
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  self->feet = 0;
  PetscCall(PetscArrayzero(self->force, 2 * self->cells + 1));
  sum->nearest = asks == TOUCHING_ALL ? PETSC_MAX_REAL : -PETSC_MAX_REAL;
  if (self->strands || self->tell) PetscCall(LookAtStrands(self, t, nodes, moves, sum));
  if (self->space) {
    PetscCall(SampleLaws(self->scene, t, 0, self->cells, self->law));
    PetscCall(TouchingWalls3(self, self->scene, t, nodes, moves, self->likely, self->law,
                             self->force, sum));
  } else if (self->scene->contact.walls.n)
    PetscCall(LookAtWalls(self, t, nodes, moves, sum));
  if (asks == TOUCHING_ALL) self->likely = KnotBehind(self->cells + 1, self->s, sum->at[0]) - 1;
  *force = (const PetscReal(*)[PUSH])self->force;
  PetscFunctionReturn(0);
}

/* TouchingLaws - what the laws give at nodes and between them at the time of the latest look, of a
   rod in space. Borrowed. */
const SampleLaw *TouchingLaws(Touching self) {
  return self->law;
}

/* TouchingFeet - the cells with feet that the latest look has found, in their order; their load is
   no part of the force at nodes and between them. Borrowed. */
PetscInt TouchingFeet(Touching self, const TouchFeet **feet) {
  *feet = self->foot;
  return self->feet;
}

/* TouchingShow - adds the forces of feet to those at nodes and between them that the latest look
   has given, as if the points of their cells had them: what all add up to is kept. */
PetscErrorCode TouchingShow(Touching self, PetscReal t, const Node *nodes) {
  const PetscReal *s = self->s;
  const PetscBool space = self->space;

  PetscFunctionBegin;
  for (PetscInt f = 0; f < self->feet; f++)
    for (int k = 0; k < FOOT_PARTS; k++) {
      const PetscInt i = self->foot[f].cell, node = i + k / 2, last = self->cells;
      const PetscReal h = s[i + 1] - s[i], z = k == 1 ? (s[i] + s[i + 1]) / 2 : s[node];
      PetscReal g, part = 1;
      if (k != 1) part = h / (s[PetscMin(node + 1, last)] - s[PetscMax(node - 1, 0)]);
      PetscCall(SceneStretch(self->scene, z, t, &g));
      for (int d = 0; d < 3; d++) self->force[2 * i + k][d] -= part / g * self->foot[f].load[k][d];
      if (space)
        self->force[2 * i + k][SPIN] -=
            part / g * AboutTangent(nodes, 2 * i + k, &self->foot[f].load[k][3]);
    }
  PetscFunctionReturn(0);
}
