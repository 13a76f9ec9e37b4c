/* What is measured on a rod in the plane. */
#include "record/observe.h"
#include "curve/cell.h"

/* A point of the rod with all that integrals need. */
typedef struct {
  PlaneNode node;
  PetscReal g, g_t, c, strain; /* stretch, its rate, slide, rate of the material's stretch */
  PetscReal k0, k0_t, B, B_t; /* natural curvature and stiffness, and their rates in the material */
  PetscReal F[RUBS];          /* the load of friction along the rod */
  const PetscReal *push;      /* the force of contact per length, NULL: none */
  const NodeLearned *learned; /* of the material there */
  PetscReal drive, ironing;   /* Dk/Dt of that, and the part of ironing */
  Vector2 q, v;               /* tangent, and velocity of the material */
  Place at;                   /* ... as the load sees it */
} Sample;

/* What the material at a sample has learned, and how fast that changes; beside the natural
   curvature that is given. */
static void SampleLearned(Scene scene, Sample *p) {
  const Tropism *law = &scene->tropism;
  const PetscReal clock = TropismClock(law, scene->growth, p->at.s, p->at.t, p->g, p->g_t),
                  elastic = p->node.moment / p->B;

  p->k0 += p->learned->bend[0];
  p->drive = clock * TropismDriveAt(law, &p->at, 0, p->learned->signal[0], p->k0, elastic);
  p->ironing = clock * law->ironing * elastic;
}

static PetscErrorCode SampleFill(Scene scene, PetscReal s, PetscReal t, Sample *p) {
  Growth growth = scene->growth;

  PetscFunctionBegin;
  PetscCall(GrowthStretch(growth, 1, &s, t, &p->g, &p->g_t, NULL));
  p->c = GrowthSlide(growth, s, t);
  p->strain = GrowthStrain(growth, s, t, p->g_t);
  PetscCall(SceneCurvature(scene, s, t, &p->k0, &p->k0_t));
  PetscCall(SceneStiffness(scene, s, t, &p->B, &p->B_t));
  PetscCall(ScenePlace(scene, s, t, &p->at));
  p->q = Direction2(p->node.theta);
  p->v = Along2(From2(p->node.x_t), p->c, p->q);
  PlaceTurn2(p->q, &p->at);
  Put2(From2(p->node.x), p->at.x);
  Put2(p->v, p->at.v);
  if (scene->tropism.any) SampleLearned(scene, p);
  LoadSeen(2, &scene->load, &p->at, p->F);
  PetscFunctionReturn(0);
}

/* The middle of a cell by Hermite's formula y_mid = (y_a + y_b)/2 + h/8 (y'_a - y'_b); feet: what
   they add to n' at a, between and at b, NULL: none. */
static PetscErrorCode SampleMid(Scene scene, PetscReal sa, PetscReal sb, PetscReal t,
                                const Sample *a, const Sample *b,
                                const PetscReal (*feet)[FOOT_LOAD], Sample *mid) {
  const PetscReal h = sb - sa;
  const Vector2 weight = From2(scene->load.weight), none = {0, 0};
  Vector2 x = none, x_t = none, force = none;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(mid, sizeof(*mid)));
  mid->learned = a->learned + 1;
  for (int e = 0; e < 2; e++) {
    const Sample *p = e ? b : a;
    const PlaneNode *n = &p->node;
    const PetscReal k = e ? -h / 8 : h / 8;
    const Vector2 slope_t = Along2(Times2(p->g_t, p->q), p->g * n->theta_t, Left2(p->q)),
                  F = Minus2(From2(p->F), p->push ? From2(p->push) : none);
    mid->node.theta += CurveMidOf(k * p->g, n->theta, n->moment / p->B + p->k0);
    mid->node.moment += CurveMidOf(-k * p->g, n->moment, Cross2(p->q, From2(n->force)));
    x = Plus2(x, CurveMidOf2(k * p->g, From2(n->x), p->q));
    x_t = Plus2(x_t, CurveMidOf2(k, From2(n->x_t), slope_t));
    force = Plus2(force, CurveMidOf2(k * p->g, From2(n->force), F));
    if (scene->load.weighs) force = Along2(force, -k * p->g, weight);
  }
  if (feet) force = Along2(force, h / 8, Minus2(From2(feet[AT_A]), From2(feet[AT_B])));
  Put2(x, mid->node.x);
  Put2(x_t, mid->node.x_t);
  Put2(force, mid->node.force);
  PetscCall(SampleFill(scene, (sa + sb) / 2, t, mid));
  PetscFunctionReturn(0);
}

/* A vector of the plane in the frame of the laboratory. */
static inline void PlaneToLab(Scene scene, Vector2 v, PetscReal lab[3]) {
  const PetscReal v3[3] = {v.x, v.y};

  SceneToLab(scene, v3, lab);
}

/* What a length of material costs: n.q + m^2/2B + m k0, the force against which the rod is fed, or
   grows, but for its sign. */
static PetscReal Tension(const Sample *p) {
  const PlaneNode *n = &p->node;

  return Dot2(From2(n->force), p->q) + PetscSqr(n->moment) / p->B / 2 + n->moment * p->k0;
}

/*
  Adds a sample to the integrals, which are kept in the fields they end up in. The power of growth
  is W = - int (n.q + m^2/2B + m k0) (g_t + c_s) ds - int m k0_t g ds + 1/2 int (m/B)^2 B_t g ds
        - c (n.q + m^2/2B + m k0) at s = 0,
  but for its second integral where k0 is steered: that is the power of who steers.
*/
static void Integrate(Scene scene, const Sample *p, PetscReal weight, PetscReal lift,
                      Observation *sum) {
  PetscReal lab[3], x2, m2 = PetscSqr(p->node.moment) / p->B,
                        k0_t = scene->curvature.steered ? 0 : p->k0_t;

  PlaneToLab(scene, From2(p->node.x), lab);
  x2 = lift * lab[1];
  sum->norm_x2 += weight * x2 * x2;
  sum->norm_x2_length += weight * x2 * x2 * p->g;
  sum->energy += weight * m2 * p->g / 2;
  sum->growth_power += weight * (-p->strain * Tension(p) - p->node.moment * k0_t * p->g +
                                 m2 / p->B * p->B_t * p->g / 2);
  if (scene->curvature.steered) sum->curvature_power -= weight * p->node.moment * p->k0_t * p->g;
  if (scene->tropism.any) {
    sum->natural_angle += weight * p->g * p->k0;
    sum->natural_bend += weight * p->g * p->k0 * p->k0;
    sum->tropism_power -= weight * p->g * p->node.moment * p->drive;
    sum->ironing_power -= weight * p->g * p->node.moment * p->ironing;
  }
  sum->dissipation += weight * p->g * Dot2(From2(p->F), p->v);
  sum->friction_force_1 -= weight * p->g * p->F[0]; /* in the clamp's frame so far */
  sum->friction_force_2 -= weight * p->g * p->F[1];
  if (scene->load.weighs) {
    const PetscReal *w = scene->load.weight;
    sum->weight_power += weight * p->g * Dot2(From2(w), p->v);
    sum->weight_force_1 += weight * p->g * w[0];
    sum->weight_force_2 += weight * p->g * w[1];
  }
}

/* What is read at s = 1/2 of the cell that holds it: on the parabola through a, mid and b. */
static void MeasureMiddle(PetscReal sa, PetscReal h, const Sample *a, const Sample *mid,
                          const Sample *b, Observation *seen) {
  PetscReal w[3];

  CurveParabola((0.5 - sa) / h, w, NULL);
  seen->mid_distance = Size2(CurveSum2(w, From2(a->node.x), From2(mid->node.x), From2(b->node.x)));
  seen->mid_speed = Size2(CurveSum2(w, a->v, mid->v, b->v));
}

/* What is read at the clamp, without integrals. */
static void MeasureClamp(Scene scene, const Sample *p, Observation *seen) {
  PetscReal lab[3];

  seen->feed_force = -Tension(p);
  seen->growth_power += p->c * seen->feed_force;
  PlaneToLab(scene, From2(p->node.force), lab);
  seen->base_force_1 = -lab[0];
  seen->base_force_2 = -lab[1];
}

/* What is read at the tip; contact is the force of contact on it. */
static void MeasureTip(Scene scene, const Sample *p, const PetscReal contact[], Observation *seen) {
  const PlaneNode *tip = &p->node;
  const Vector2 force = Minus2(From2(tip->force), From2(contact));
  PetscReal lab[3];

  seen->tip_speed = Size2(p->v);
  seen->tip_power = Dot2(force, p->v);
  if (scene->tip.path || scene->tip.turned.on) seen->tip_power += tip->moment * tip->theta_t;
  seen->tip_angle = scene->clamp_angle + tip->theta;
  PlaneToLab(scene, From2(tip->x), lab);
  seen->tip_x1 = lab[0];
  seen->tip_x2 = lab[1];
  seen->end_distance = Size2(From2(tip->x));
  PlaneToLab(scene, force, lab);
  seen->tip_force_1 = lab[0];
  seen->tip_force_2 = lab[1];
}

/* The sample at a node, of all points by number: of nodes and of what is between them. */
static PetscErrorCode SampleNode(Scene scene, PetscReal s, PetscReal t, const Node *node,
                                 const PetscReal *push, Sample *p) {
  PetscFunctionBegin;
  PlanePart(node, &p->node);
  p->learned = node->learned;
  p->push = push;
  PetscCall(SampleFill(scene, s, t, p));
  PetscFunctionReturn(0);
}

/*
  ObservePlane - integrals over a piece of a rod in the plane by Simpson's rule on each cell, and
  what is read at its ends. Not collective.

  first, end  nodes of the piece, of which node is the first
  push        force of contact per length at all points of the rod, NULL: none
  tip         of contact on the tip
  feet        n cells with what feet add to their points, in the order of cells
  lift        what x2 is multiplied by before it is squared
*/
PetscErrorCode ObservePlane(Scene scene, PetscReal t, PetscInt first, PetscInt end,
                            const Node *node, const PetscReal (*push)[PUSH], const PetscReal tip[],
                            PetscInt n, const TouchFeet *feet, PetscReal lift, Observation *seen) {
  PetscInt nodes;
  const PetscReal *s = SceneLabels(scene, &nodes);
  Sample a, b = {.g = 0}, mid;

  PetscFunctionBegin;
  PetscCall(SampleNode(scene, s[first], t, node, push ? push[2 * first] : NULL, &b));
  if (!first) MeasureClamp(scene, &b, seen);
  for (PetscInt i = first; i < end; i++) {
    const PetscReal(*load)[FOOT_LOAD] = NULL, h = s[i + 1] - s[i];
    for (; n && feet->cell < i; n--) feet++;
    if (n && feet->cell == i) load = (const PetscReal(*)[FOOT_LOAD])feet->load;
    a = b;
    PetscCall(
        SampleNode(scene, s[i + 1], t, node + i + 1 - first, push ? push[2 * i + 2] : NULL, &b));
    PetscCall(SampleMid(scene, s[i], s[i + 1], t, &a, &b, load, &mid));
    Integrate(scene, &a, h / 6, lift, seen);
    Integrate(scene, &mid, 4 * h / 6, lift, seen);
    Integrate(scene, &b, h / 6, lift, seen);
    if (s[i] < 0.5 && s[i + 1] >= 0.5) MeasureMiddle(s[i], h, &a, &mid, &b, seen);
  }
  if (end == nodes - 1) MeasureTip(scene, &b, tip, seen);
  PetscFunctionReturn(0);
}
