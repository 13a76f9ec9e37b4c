/* What is measured on a rod in space: the integrals of observe.c, with two bends, twist and spin.
 */
#include "record/observe.h"
#include "base/quaternion.h"
#include "curve/cell.h"
#include "record/sample_space.h"
#include "rod/directors.h"

/* What a length of material costs: n.d1 + (u - u0).S(u - u0)/2 + u0.S(u - u0). */
static PetscReal Tension3(const Sample3 *p) {
  PetscReal sum = Dot3(p->node.force, p->at.axes[0]);
  for (int k = 0; k < 3; k++) sum += p->moment[k] * (p->moment[k] / p->law.S[k] / 2 + p->law.u0[k]);
  return sum;
}

/* The rate of the writhe along the rod, in turns (Fuller's, against the clamp's axis e1):
   (e1 x d1).d1' / (2 pi (1 + e1.d1)),  d1' = u3 d2 - u2 d3. */
static PetscReal WritheRate(const Sample3 *p) {
  const PetscReal *q = p->at.axes[0];
  PetscReal bend[3];

  for (int i = 0; i < 3; i++) bend[i] = p->u[2] * p->at.axes[1][i] - p->u[1] * p->at.axes[2][i];
  return Cross2(From2(q + 1), From2(bend + 1)) / (2 * PETSC_PI * PetscMax(1e-12, 1 + q[0]));
}

static void Integrate3(Scene scene, const Sample3 *p, PetscReal weight, Observation *sum) {
  const PetscReal *w = scene->load.weight;
  const PetscReal dl = weight * p->law.g;
  const PetscBool steered = scene->curvature.steered;
  PetscReal lab[3], bending = 0, growth = 0;

  SceneToLab(scene, p->node.x, lab);
  for (int k = 0; k < 3; k++) {
    PetscReal elastic = PetscSqr(p->moment[k]) / p->law.S[k] / 2;
    bending += elastic;
    growth += elastic / p->law.S[k] * p->law.S_t[k] - p->moment[k] * (steered ? 0 : p->law.u0_t[k]);
    if (steered) sum->curvature_power -= dl * p->moment[k] * p->law.u0_t[k];
  }
  if (scene->tropism.any) {
    sum->natural_angle += dl * p->law.u0[2];
    sum->natural_angle_2 += dl * p->law.u0[1];
    sum->natural_bend += dl * Dot2(From2(p->law.u0 + 1), From2(p->law.u0 + 1));
    sum->tropism_power -= dl * Dot3(p->moment, p->drive);
    sum->ironing_power -= dl * Dot3(p->moment, p->ironing);
  }
  sum->norm_x2 += weight * lab[1] * lab[1];
  sum->norm_x2_length += dl * lab[1] * lab[1];
  sum->norm_x3 += weight * lab[2] * lab[2];
  sum->energy += dl * bending;
  sum->energy_twist += dl * PetscSqr(p->moment[0]) / p->law.S[0] / 2;
  sum->growth_power += dl * growth - weight * p->law.strain * Tension3(p);
  sum->dissipation += dl * (Dot3(p->F, p->at.v) + p->F[SPIN] * p->spin);
  sum->weight_power += dl * Dot3(w, p->at.v);
  sum->friction_force_1 -= dl * p->F[0]; /* in the clamp's frame, as in the plane */
  sum->friction_force_2 -= dl * p->F[1];
  sum->friction_force_3 -= dl * p->F[2];
  sum->weight_force_1 += dl * w[0];
  sum->weight_force_2 += dl * w[1];
  sum->weight_force_3 += dl * w[2];
  sum->twist += dl * p->u[0];
  sum->writhe += dl * WritheRate(p);
}

/* The angle by which the directors are turned about the tangent against the smallest rotation that
   takes the clamp's axis to it. */
static PetscReal Turned(const Node *node) {
  return 2 * atan2(node->p[1], node->p[0]);
}

/* How far that turns from one node to the next: less than half a turn, either way. */
static PetscReal TurnedBetween(const Node *a, const Node *b) {
  PetscReal turn = (Turned(b) - Turned(a)) / (2 * PETSC_PI);
  return turn - PetscFloorReal(turn + 0.5);
}

/* What turns a rod's beginning about itself does work: a clamp that is turned; and a hinge, whose
   moment goes along with a tangent that circles. */
static PetscReal ClampPower(Scene scene, const Sample3 *p) {
  PetscReal turn[4];

  if (scene->clamp != CLAMP_HINGED) return -p->node.m3[0] * SpaceClampRate(&scene->space, p->at.t);
  QuaternionFrom(p->node.p, p->node.p_t, turn); /* about the directors */
  return -p->moment[0] * 2 / QuaternionSize(p->node.p) * turn[1];
}

/* How fast a section turns: 2 p_t p* of the directors, and c u of material that slides past them.
 */
static void Omega(const Sample3 *p, PetscReal c, PetscReal omega[3]) {
  PetscReal turn[4];

  QuaternionFrom(p->node.p, p->node.p_t, turn); /* about the directors */
  for (int i = 0; i < 3; i++) {
    omega[i] = 0;
    for (int k = 0; k < 3; k++)
      omega[i] += p->at.axes[k][i] * (2 / QuaternionSize(p->node.p) * turn[1 + k] + c * p->u[k]);
  }
}

/* The power of what a section bears, at its place. */
static PetscReal PowerOf(const Sample3 *p) {
  PetscReal omega[3];

  Omega(p, 0, omega);
  return Dot3(p->node.force, p->node.x_t) + Dot3(p->node.m3, omega);
}

static void MeasureClamp3(Scene scene, const Sample3 *p, Observation *seen) {
  PetscReal lab[3];

  seen->feed_force = -Tension3(p);
  seen->growth_power += p->law.c * seen->feed_force;
  SceneToLab(scene, p->node.force, lab);
  Times3(-1, lab, lab);
  Split3(lab, &seen->base_force_1, &seen->base_force_2, &seen->base_force_3);
  SceneToLab(scene, p->node.m3, lab);
  Times3(-1, lab, lab);
  Split3(lab, &seen->base_moment_1, &seen->base_moment_2, &seen->base_moment_3);
  seen->clamp_power = SceneCarried(scene) ? -PowerOf(p) : ClampPower(scene, p);
}

/* contact: its force on the tip, and its couple about the tangent. */
static void MeasureTip3(Scene scene, const Sample3 *p, const PetscReal contact[PUSH],
                        Observation *seen) {
  const Node *tip = &p->node;
  PetscReal lab[3], omega[3], force[3];

  Omega(p, p->law.c, omega);
  seen->tip_speed = Size3(p->at.v);
  seen->tip_spin = p->spin;
  seen->tip_power = Dot3(tip->force, p->at.v) - Dot3(contact, p->at.v) + Dot3(tip->m3, omega) -
                    contact[SPIN] * p->spin;
  seen->tip_angle = tip->theta;
  SceneToLab(scene, tip->x, lab);
  seen->end_distance = Size3(lab);
  ScenePlaceToLab(scene, tip->x, lab);
  Split3(lab, &seen->tip_x1, &seen->tip_x2, &seen->tip_x3);
  for (int d = 0; d < 3; d++) force[d] = tip->force[d] - contact[d];
  SceneToLab(scene, force, lab);
  Split3(lab, &seen->tip_force_1, &seen->tip_force_2, &seen->tip_force_3);
}

/* What is read at s = 1/2, on the parabola through the points of the cell that holds it. */
static void MeasureMiddle3(PetscReal z, const Sample3 *a, const Sample3 *mid, const Sample3 *b,
                           Observation *seen) {
  PetscReal w[3], x[3], v[3];

  CurveParabola(z, w, NULL);
  for (int d = 0; d < 3; d++) {
    const PetscReal x_at[3] = {a->node.x[d], mid->node.x[d], b->node.x[d]},
                    v_at[3] = {a->at.v[d], mid->at.v[d], b->at.v[d]};
    x[d] = CurveSum(w, x_at);
    v[d] = CurveSum(w, v_at);
  }
  seen->mid_distance = Size3(x);
  seen->mid_speed = Size3(v);
}

/*
  ObserveSpace - integrals over a piece of a rod in space by Simpson's rule on each cell, and what
  is read at its ends, added to seen. Not collective.

  first, end  its nodes      node  that of first
  law         at its nodes and between them
  push        of contact per length, at all nodes of the rod and between them; NULL: none
  contact     the same, of the tip
  n, feet     what those of cells add to the points of these alone, in their order
*/
PetscErrorCode ObserveSpace(Scene scene, PetscReal t, PetscInt first, PetscInt end,
                            const Node node[], const SampleLaw law[], const PetscReal (*push)[PUSH],
                            const PetscReal contact[PUSH], PetscInt n, const TouchFeet feet[],
                            Observation *seen) {
  PetscInt nodes;
  const PetscReal *s = SceneLabels(scene, &nodes);
  Sample3 a, b, mid;

  PetscFunctionBegin;
  b.node = node[0];
  b.push = push ? push[2 * first] : NULL;
  PetscCall(SampleFill3(scene, s[first], t, law, &b));
  if (!first) MeasureClamp3(scene, &b, seen);
  for (PetscInt i = first; i < end; i++, law += 2) {
    const PetscReal(*load)[FOOT_LOAD] = NULL, h = s[i + 1] - s[i];
    for (; n > 0 && feet->cell < i; n--) feet++;
    if (n > 0 && feet->cell == i) load = feet->load;
    a = b;
    b.node = node[i + 1 - first];
    b.push = push ? push[2 * i + 2] : NULL;
    PetscCall(SampleFill3(scene, s[i + 1], t, law + 2, &b));
    PetscCall(SampleMid3(scene, s[i], s[i + 1], t, law + 1, &a, &b, load, &mid));
    Integrate3(scene, &a, h / 6, seen);
    Integrate3(scene, &mid, 4 * h / 6, seen);
    Integrate3(scene, &b, h / 6, seen);
    seen->link += TurnedBetween(&a.node, &b.node);
    if (h == 0) seen->clamp_power += PowerOf(&a) - PowerOf(&b); /* of rods that are joined to it */
    if (s[i] < 0.5 && s[i + 1] >= 0.5) MeasureMiddle3((0.5 - s[i]) / h, &a, &mid, &b, seen);
  }
  if (end == nodes - 1) MeasureTip3(scene, &b, contact, seen);
  PetscFunctionReturn(0);
}
