#include "record/observe.h"
#include "base/lagrange.h"
#include "curve/cell.h"
#include "rod/crossing.h"
#include <string.h>

#define X(name, units, text) #name,
const char *const observed_name[OBSERVED] = {EVERY_OBSERVABLE(X)};
#undef X
#define X(name, units, text) units,
const char *const observed_units[OBSERVED] = {EVERY_OBSERVABLE(X)};
#undef X
#define X(name, units, text) text,
const char *const observed_text[OBSERVED] = {EVERY_OBSERVABLE(X)};
#undef X

/* ObservedOf - up to how many of the series, from the first on, there may be in a scene. */
PetscInt ObservedOf(Scene scene) {
  if (scene->tropism.any) return OBSERVED;
  if (scene->curvature.steered) return OBSERVED_STEERED;
  if (scene->space.rod) return OBSERVED_IN_SPACE;
  if (scene->contact.walls.carried) return OBSERVED_IN_SPACE;
  return OBSERVED_ALWAYS + (scene->load.weighs ? OBSERVED_OF_WEIGHT : 0);
}

/* ObservedIn - is a series one of a scene? Of a rod that weighs nothing there is no weight. */
PetscBool ObservedIn(Scene scene, PetscInt observed) {
  const PetscBool weighs = scene->load.weighs;

  if (observed >= ObservedOf(scene)) return PETSC_FALSE;
  if (observed < OBSERVED_ALWAYS || observed >= OBSERVED_STEERED) return PETSC_TRUE;
  if (observed >= OBSERVED_IN_SPACE) return scene->curvature.steered;
  if (!scene->space.rod)
    return (PetscBool)((weighs && observed < OBSERVED_ALWAYS + OBSERVED_OF_WEIGHT) ||
                       (scene->contact.walls.carried &&
                        !strcmp(observed_name[observed], "wall_power")));
  return (PetscBool)(weighs || strncmp(observed_name[observed], "weight_force", 12));
}

struct _Observer {
  Scene scene;
  MPI_Comm comm;
  PetscInt nodes;
  const PetscReal *s; /* their labels */
  PetscBool space;    /* the rod is in space */
  Vec all;            /* every node, on rank 0 */
  VecScatter to_zero;
  Node *gathered; /* rank 0: cells + 1 nodes */
  /* the energy balance: the latest times with W - dissipation, dissipation and energy, newest last
   */
  PetscInt n;
  PetscReal time[BALANCE_POINTS], net[BALANCE_POINTS], loss[BALANCE_POINTS];
  PetscReal energy[BALANCE_POINTS];
  PetscReal first_energy, net_work, lost_work;
  PetscBool closed, broken; /* over the step to be measured next: ObserverClose() */
  PetscReal left;           /* the energy at its begin, if it is closed */
  /* rank 0, in a scene with contact: NULL else */
  Touching touching;
  TouchSum contact;
  SampleLaw *law;                /* of a rod in space that touches nothing, of this rank's part */
  RodForces forces;              /* what the stepper has kept of the state, of this rank's part */
  PetscBool linear;              /* they are of a rod of the linear model */
  PetscBool whole;               /* they are all forces, of all of the rod */
  const PetscReal (*push)[PUSH]; /* force of contact per length */
};

/* ObserverCreate - what measures the states of a run of this scene, which must outlive it; nothing
   is summed up yet. The caller ends it with ObserverDestroy(). Collective. */
PetscErrorCode ObserverCreate(Scene scene, Observer *observer) {
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(PetscNew(observer));
  (*observer)->scene = scene;
  (*observer)->comm = scene->comm;
  (*observer)->s = SceneLabels(scene, &(*observer)->nodes);
  (*observer)->space = scene->space.rod;
  PetscCallMPI(MPI_Comm_rank((*observer)->comm, &rank));
  if (!rank) PetscCall(PetscMalloc1((*observer)->nodes, &(*observer)->gathered));
  if (!rank && scene->contact.any) PetscCall(TouchingCreate(scene, &(*observer)->touching));
  PetscFunctionReturn(0);
}

PetscErrorCode ObserverDestroy(Observer *observer) {
  PetscFunctionBegin;
  if (!*observer) PetscFunctionReturn(0);
  PetscCall(VecScatterDestroy(&(*observer)->to_zero));
  PetscCall(VecDestroy(&(*observer)->all));
  PetscCall(TouchingDestroy(&(*observer)->touching));
  PetscCall(PetscFree((*observer)->law));
  PetscCall(PetscFree((*observer)->gathered));
  PetscCall(PetscFree(*observer));
  PetscFunctionReturn(0);
}

/* The owned nodes, as a vector over the rod; the caller gives it back (DMRestoreGlobalVector). */
static PetscErrorCode NodesOf(Rod rod, PetscReal t, Vec U, Vec U_t, Vec *v) {
  PetscScalar *local;

  PetscFunctionBegin;
  PetscCall(DMGetGlobalVector(rod->nodes, v));
  PetscCall(VecGetArray(*v, &local));
  if (U)
    PetscCall(rod->model->get(rod, t, U, U_t, (Node *)local));
  else
    PetscCall(RodInitialNodes(rod, t, (Node *)local));
  PetscCall(VecRestoreArray(*v, &local));
  PetscFunctionReturn(0);
}

/* All of them, on rank 0: NULL on the others. */
static PetscErrorCode Gather(Observer observer, Vec v, const Node **nodes) {
  const PetscScalar *all;

  PetscFunctionBegin;
  if (!observer->to_zero) PetscCall(VecScatterCreateToZero(v, &observer->to_zero, &observer->all));
  PetscCall(VecScatterBegin(observer->to_zero, v, observer->all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(observer->to_zero, v, observer->all, INSERT_VALUES, SCATTER_FORWARD));
  *nodes = NULL;
  if (!observer->gathered) PetscFunctionReturn(0);
  PetscCall(VecGetArrayRead(observer->all, &all));
  PetscCall(PetscMemcpy(observer->gathered, all, observer->nodes * sizeof(Node)));
  PetscCall(VecRestoreArrayRead(observer->all, &all));
  *nodes = observer->gathered;
  PetscFunctionReturn(0);
}

/*
  ObserverGather - all nodes of a rod on rank 0, in the clamp's frame. Collective.

  U      NULL before the first step: the initial shape, with the rates of growth without friction
  U_t    NULL: rates are 0
  nodes  cells + 1 nodes on rank 0, valid until the next call; NULL on the others
*/
PetscErrorCode ObserverGather(Observer observer, Rod rod, PetscReal t, Vec U, Vec U_t,
                              const Node **nodes) {
  Vec v;

  PetscFunctionBegin;
  PetscCall(NodesOf(rod, t, U, U_t, &v));
  PetscCall(Gather(observer, v, nodes));
  PetscCall(DMRestoreGlobalVector(rod->nodes, &v));
  PetscFunctionReturn(0);
}

/* What a rank measures: the nodes from first to end, and the cells between them; end < first: none.
 */
typedef struct {
  PetscInt first, end;
  const Node *node; /* that of first */
} Piece;

/* A point of the rod with all that integrals need. */
typedef struct {
  PlaneNode node;
  PetscReal g, g_t, c, strain; /* stretch, its rate, slide, rate of the material's stretch */
  PetscReal k0, k0_t, B, B_t; /* natural curvature and stiffness, and their rates in the material */
  PetscReal F[RUBS];          /* the load of friction along the rod */
  const PetscReal *push;      /* the force of contact per length, NULL: none */
  const NodeLearned *learned; /* of the material there */
  PetscReal drive, ironing;   /* Dk/Dt of that, and the part of ironing */
  Place at;
} Sample;

/* What the material at a sample has learned, and how fast that changes; beside the natural
   curvature that is given. */
static void SampleLearned(Scene scene, PetscReal s, PetscReal t, Sample *p) {
  const Tropism *law = &scene->tropism;
  const PetscReal clock = TropismClock(law, scene->growth, s, t, p->g, p->g_t),
                  elastic = p->node.moment / p->B;
  const TropismPlace at = {.x = {p->node.x[0], p->node.x[1], 0},
                           .d2 = {-PetscSinReal(p->node.theta), PetscCosReal(p->node.theta), 0},
                           .d3 = {0, 0, 1}};

  p->k0 += p->learned->bend[0];
  p->drive = clock * TropismDriveAt(law, &at, 0, t, p->learned->signal[0], p->k0, elastic);
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
  if (scene->tropism.any) SampleLearned(scene, s, t, p);
  p->at.t = t;
  p->at.q[0] = PetscCosReal(p->node.theta);
  p->at.q[1] = PetscSinReal(p->node.theta);
  p->at.x[2] = 0;
  for (int d = 0; d < 2; d++) {
    p->at.x[d] = p->node.x[d];
    p->at.v[d] = p->node.x_t[d] + p->c * p->at.q[d];
  }
  LoadSeen(2, &scene->load, &p->at, p->F);
  PetscFunctionReturn(0);
}

/* The middle of a cell by Hermite's formula y_mid = (y_a + y_b)/2 + h/8 (y'_a - y'_b); feet: what
   they add to n' at a, between and at b, NULL: none. */
static PetscErrorCode SampleMid(Scene scene, PetscReal sa, PetscReal sb, PetscReal t,
                                const Sample *a, const Sample *b,
                                const PetscReal (*feet)[FOOT_LOAD], Sample *mid) {
  const Sample *end[2] = {a, b};
  PetscReal h = sb - sa;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(mid, sizeof(*mid)));
  mid->learned = a->learned + 1;
  for (int e = 0; e < 2; e++) {
    const Sample *p = end[e];
    const PlaneNode *n = &p->node;
    const PetscReal *q = p->at.q;
    PetscReal k = e ? -h / 8 : h / 8;
    mid->node.theta += CurveMidOf(k * p->g, n->theta, n->moment / p->B + p->k0);
    mid->node.moment += CurveMidOf(-k * p->g, n->moment, q[0] * n->force[1] - q[1] * n->force[0]);
    for (int d = 0; d < 2; d++) {
      PetscReal perp = d ? q[0] : -q[1];
      mid->node.x[d] += CurveMidOf(k * p->g, n->x[d], q[d]);
      mid->node.x_t[d] += CurveMidOf(k, n->x_t[d], p->g_t * q[d] + p->g * n->theta_t * perp);
      mid->node.force[d] += CurveMidOf(k * p->g, n->force[d], p->F[d] - (p->push ? p->push[d] : 0));
      if (scene->load.weighs) mid->node.force[d] -= k * p->g * scene->load.weight[d];
    }
  }
  for (int d = 0; d < 2 && feet; d++) mid->node.force[d] += h / 8 * (feet[0][d] - feet[2][d]);
  PetscCall(SampleFill(scene, (sa + sb) / 2, t, mid));
  PetscFunctionReturn(0);
}

/* A vector of the plane in the frame of the laboratory. */
static inline void PlaneToLab(Scene scene, const PetscReal v[2], PetscReal lab[3]) {
  const PetscReal v3[3] = {v[0], v[1]};

  SceneToLab(scene, v3, lab);
}

/* What a length of material costs: n.q + m^2/2B + m k0, the force against which the rod is fed, or
   grows, but for its sign. */
static PetscReal Tension(const Sample *p) {
  const PlaneNode *n = &p->node;
  return n->force[0] * p->at.q[0] + n->force[1] * p->at.q[1] + PetscSqr(n->moment) / p->B / 2 +
         n->moment * p->k0;
}

/*
  Adds a sample to the integrals, which are kept in the fields they end up in. The power of growth
  is W = - int (n.q + m^2/2B + m k0) (g_t + c_s) ds - int m k0_t g ds + 1/2 int (m/B)^2 B_t g ds
        - c (n.q + m^2/2B + m k0) at s = 0,
  but for its second integral where k0 is steered: that is the power of who steers.
  lift: what x2 is multiplied by before it is squared.
*/
static void Integrate(Scene scene, const Sample *p, PetscReal weight, PetscReal lift,
                      Observation *sum) {
  PetscReal lab[3], x2, m2 = PetscSqr(p->node.moment) / p->B,
                        k0_t = scene->curvature.steered ? 0 : p->k0_t;

  PlaneToLab(scene, p->node.x, lab);
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
  sum->dissipation += weight * p->g * (p->F[0] * p->at.v[0] + p->F[1] * p->at.v[1]);
  sum->friction_force_1 -= weight * p->g * p->F[0]; /* in the clamp's frame so far */
  sum->friction_force_2 -= weight * p->g * p->F[1];
  if (scene->load.weighs) {
    const PetscReal *w = scene->load.weight;
    sum->weight_power += weight * p->g * (w[0] * p->at.v[0] + w[1] * p->at.v[1]);
    sum->weight_force_1 += weight * p->g * w[0];
    sum->weight_force_2 += weight * p->g * w[1];
  }
}

/* What is read at s = 1/2 of the cell that holds it: on the parabola through a, mid and b. */
static void MeasureMiddle(PetscReal sa, PetscReal h, const Sample *a, const Sample *mid,
                          const Sample *b, Observation *seen) {
  PetscReal w[3], x[2], v[2];

  CurveParabola((0.5 - sa) / h, w, NULL);
  for (int d = 0; d < 2; d++) {
    x[d] = w[0] * a->node.x[d] + w[1] * mid->node.x[d] + w[2] * b->node.x[d];
    v[d] = w[0] * a->at.v[d] + w[1] * mid->at.v[d] + w[2] * b->at.v[d];
  }
  seen->mid_distance = hypot(x[0], x[1]);
  seen->mid_speed = hypot(v[0], v[1]);
}

/* What there is of contact, and what it adds to the integrals: material that is laid down where it
   is pressed works against U besides. What a strand pushes back into the clamp that bears. */
static void AddContact(Observer self, Observation *seen) {
  const TouchSum *contact = &self->contact;
  PetscReal lab[3];

  if (!self->touching) return;
  seen->contact_force = contact->normal;
  seen->contact_energy = contact->energy;
  seen->penetration = ContactBears(&self->scene->contact, contact->nearest) ? -contact->nearest : 0;
  seen->contacts = contact->zones;
  SceneToLab(self->scene, contact->wall, lab);
  seen->wall_force_1 = lab[0];
  seen->wall_force_2 = lab[1];
  seen->wall_force_3 = lab[2];
  seen->wall_power = contact->moved;
  SceneToLab(self->scene, contact->clamp, lab);
  seen->base_force_1 -= lab[0];
  seen->base_force_2 -= lab[1];
  seen->base_force_3 -= lab[2];
  seen->dissipation += contact->loss;
  seen->growth_power += contact->strain;
}

/* What is read at the clamp, without integrals. */
static void MeasureClamp(Scene scene, const Sample *p, Observation *seen) {
  PetscReal lab[3];

  seen->feed_force = -Tension(p);
  seen->growth_power += p->c * seen->feed_force;
  PlaneToLab(scene, p->node.force, lab);
  seen->base_force_1 = -lab[0];
  seen->base_force_2 = -lab[1];
}

/* What is read at the tip; contact is the force of contact on it. */
static void MeasureTip(Scene scene, const Sample *p, const PetscReal contact[2],
                       Observation *seen) {
  const PlaneNode *tip = &p->node;
  PetscReal force[2], lab[3];

  seen->tip_speed = hypot(p->at.v[0], p->at.v[1]);
  seen->tip_power =
      (tip->force[0] - contact[0]) * p->at.v[0] + (tip->force[1] - contact[1]) * p->at.v[1];
  if (scene->tip.path || scene->tip.turned.on) seen->tip_power += tip->moment * tip->theta_t;
  seen->tip_angle = scene->clamp_angle + tip->theta;
  PlaneToLab(scene, tip->x, lab);
  seen->tip_x1 = lab[0];
  seen->tip_x2 = lab[1];
  seen->end_distance = hypot(tip->x[0], tip->x[1]);
  for (int d = 0; d < 2; d++) force[d] = tip->force[d] - contact[d];
  PlaneToLab(scene, force, lab);
  seen->tip_force_1 = lab[0];
  seen->tip_force_2 = lab[1];
}

/* What feet on posts add to n' in cell i, NULL: nothing; cells are asked for one after the other, k
   is how many with feet are behind. */
static const PetscReal (*FeetOf(Observer self, PetscInt i, PetscInt *k))[FOOT_LOAD] {
  const TouchFeet *feet;
  PetscInt n = self->touching ? TouchingFeet(self->touching, &feet) : 0;

  if (*k >= n || feet[*k].cell != i) return NULL;
  return (const PetscReal(*)[FOOT_LOAD])feet[(*k)++].load;
}

/* Integrals over a piece of a rod in the plane by Simpson's rule on each cell, and what is read at
   its ends. */
static PetscErrorCode MeasurePlane(Observer self, PetscReal t, const Piece *piece, PetscReal lift,
                                   Observation *seen) {
  Scene scene = self->scene;
  const PetscReal *s = self->s;
  PetscInt feet = 0;
  Sample a, b, mid;

  PetscFunctionBegin;
  PlanePart(&piece->node[0], &b.node);
  b.learned = piece->node[0].learned;
  b.push = self->push ? self->push[2 * piece->first] : NULL;
  PetscCall(SampleFill(scene, s[piece->first], t, &b));
  if (!piece->first) MeasureClamp(scene, &b, seen);
  for (PetscInt i = piece->first; i < piece->end; i++) {
    PetscReal h = s[i + 1] - s[i];
    a = b;
    PlanePart(&piece->node[i + 1 - piece->first], &b.node);
    b.learned = piece->node[i + 1 - piece->first].learned;
    b.push = self->push ? self->push[2 * i + 2] : NULL;
    PetscCall(SampleFill(scene, s[i + 1], t, &b));
    PetscCall(SampleMid(scene, s[i], s[i + 1], t, &a, &b, FeetOf(self, i, &feet), &mid));
    Integrate(scene, &a, h / 6, lift, seen);
    Integrate(scene, &mid, 4 * h / 6, lift, seen);
    Integrate(scene, &b, h / 6, lift, seen);
    if (s[i] < 0.5 && s[i + 1] >= 0.5) MeasureMiddle(s[i], h, &a, &mid, &b, seen);
  }
  if (piece->end == self->nodes - 1) MeasureTip(scene, &b, self->contact.tip, seen);
  PetscFunctionReturn(0);
}

/* What a piece of a rod gives to n1(0) - n1(1). */
static PetscReal AxialDrop(const Observer self, const Piece *piece) {
  PetscReal drop = 0;

  if (piece->end < piece->first) return 0;
  for (int end = 0; end < 2; end++) {
    const Node *node = &piece->node[end ? piece->end - piece->first : 0];
    const PetscReal n1 = self->space ? node->n3[0] : node->force[0];
    if (!end && !piece->first) drop += n1;
    if (end && piece->end == self->nodes - 1) drop -= n1;
  }
  return drop;
}

/* The forces of friction and of weight, whose integrals are in the clamp's frame. Friction is that
   of Newton's last step, which the residual tells from that of the velocities; exact friction is
   known of all of the rod. The linear model has integrated that along the axis more finely. */
static void MeasureForces(Observer self, const Piece *piece, Observation *seen) {
  const RodForces *kept = &self->forces;
  PetscReal friction[3] = {seen->friction_force_1, seen->friction_force_2, seen->friction_force_3},
            weight[3] = {seen->weight_force_1, seen->weight_force_2, seen->weight_force_3}, lab[3];

  for (int d = 0; d < 3; d++) {
    if (self->whole) friction[d] = self->gathered ? kept->friction[d] : 0;
    if (!self->whole || self->gathered) friction[d] -= kept->left[d];
  }
  if (self->linear) friction[0] = AxialDrop(self, piece) - weight[0];
  SceneToLab(self->scene, friction, lab);
  seen->friction_force_1 = lab[0];
  seen->friction_force_2 = lab[1];
  seen->friction_force_3 = lab[2];
  SceneToLab(self->scene, weight, lab);
  seen->weight_force_1 = lab[0];
  seen->weight_force_2 = lab[1];
  seen->weight_force_3 = lab[2];
}

/* The laws of a piece of a rod in space: a look at contact has found them. */
static PetscErrorCode LawsOf(Observer self, PetscReal t, const Piece *piece,
                             const SampleLaw **law) {
  PetscFunctionBegin;
  if (self->touching)
    *law = TouchingLaws(self->touching) + 2 * piece->first;
  else {
    if (!self->law) PetscCall(PetscMalloc1(2 * self->nodes - 1, &self->law));
    PetscCall(SampleLaws(self->scene, t, piece->first, piece->end, self->law));
    *law = self->law;
  }
  PetscFunctionReturn(0);
}

/* Integrals over a piece, and what is read at its ends. */
static PetscErrorCode MeasureIntegrals(Observer self, PetscReal t, const Piece *piece,
                                       PetscReal lift, Observation *seen) {
  PetscFunctionBegin;
  if (piece->end >= piece->first && self->space) {
    const TouchFeet *of_cells = NULL;
    const PetscInt n = self->touching ? TouchingFeet(self->touching, &of_cells) : 0;
    const SampleLaw *law = NULL;
    PetscCall(LawsOf(self, t, piece, &law));
    PetscCall(ObserveSpace(self->scene, t, piece->first, piece->end, piece->node, law, self->push,
                           self->contact.tip, n, of_cells, seen));
  } else if (piece->end >= piece->first)
    PetscCall(MeasurePlane(self, t, piece, lift, seen));
  MeasureForces(self, piece, seen);
  PetscFunctionReturn(0);
}

/* The extremes of a rod, as numbers of which the largest is wanted. */
typedef struct {
  PetscReal high, low, angle, moment; /* of x2, -x2, |theta|, |m| */
} Extremes;

static PetscErrorCode MeasureExtremes(Observer self, const Piece *piece, Extremes *most) {
  PetscFunctionBegin;
  PetscCall(PetscMemzero(most, sizeof(*most)));
  for (PetscInt i = 0; i <= piece->end - piece->first; i++) {
    const Node *node = &piece->node[i];
    most->high = PetscMax(most->high, node->x[1]);
    most->low = PetscMax(most->low, -node->x[1]);
    most->angle = PetscMax(most->angle, PetscAbsReal(node->theta));
    most->moment = PetscMax(most->moment, PetscAbsReal(node->moment));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, sizeof(*most) / sizeof(PetscReal), MPIU_REAL,
                             MPI_MAX, self->comm));
  PetscFunctionReturn(0);
}

/* Sign changes of the curvature, where it is not next to none beside the largest moment: at the tip
   it is 0 but for round-off. */
static PetscErrorCode MeasureInflections(Observer self, PetscReal t, const Piece *piece,
                                         PetscReal moment, PetscReal *inflections) {
  enum { FIRST, LAST, CHANGES, SIGNS };
  Scene scene = self->scene;
  PetscReal mine[SIGNS] = {0}, *all, sign = 0;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  *inflections = 0;
  if (self->space) PetscFunctionReturn(0); /* a bend has no sign there */
  for (PetscInt i = piece->first; i <= piece->end; i++) {
    PetscReal k, B;
    PetscCall(SceneCurvature(scene, self->s[i], t, &k, NULL));
    if (scene->tropism.any) k += piece->node[i - piece->first].learned[0].bend[0];
    PetscCall(SceneStiffness(scene, self->s[i], t, &B, NULL));
    k += piece->node[i - piece->first].moment / B;
    if (PetscAbsReal(k) <= 1e-6 * moment) continue;
    k = k > 0 ? 1 : -1;
    if (mine[FIRST] == 0) mine[FIRST] = k;
    if (k * mine[LAST] < 0) mine[CHANGES]++;
    mine[LAST] = k;
  }
  PetscCallMPI(MPI_Comm_size(self->comm, &ranks));
  PetscCall(PetscMalloc1(SIGNS * ranks, &all));
  PetscCallMPI(MPI_Allgather(mine, SIGNS, MPIU_REAL, all, SIGNS, MPIU_REAL, self->comm));
  *inflections = 0;
  for (PetscMPIInt r = 0; r < ranks; r++) { /* one more where two ranks meet in other signs */
    const PetscReal *its = all + SIGNS * r;
    *inflections += its[CHANGES] + (sign * its[FIRST] < 0);
    if (its[LAST] != 0) sign = its[LAST];
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* Does a value stay between those of n points, by so much at most? */
static PetscBool StaysBetween(PetscReal value, PetscInt n, const PetscReal f[], PetscReal beside) {
  PetscReal least = f[0], most = f[0];

  for (PetscInt i = 1; i < n; i++) {
    least = PetscMin(least, f[i]);
    most = PetscMax(most, f[i]);
  }
  return (PetscBool)(least - beside * (most - least) <= value &&
                     value <= most + beside * (most - least));
}

/* The integral from the last but one to the last time of the polynomial through all of them, times
   the exponential of another one through logs; NULL: 1. good: false if either leaves what it goes
   through, and says nothing of what is between. */
static PetscReal Through(PetscInt n, const PetscReal time[], const PetscReal f[],
                         const PetscReal logs[], PetscBool *good) {
  PetscReal a = time[n - 2], h = time[n - 1] - a, sum = 0, L[BALANCE_POINTS];

  *good = PETSC_TRUE;
  for (int q = 0; q < GAUSS; q++) {
    PetscReal value = 0, log_now = 0;
    LagrangeValues(n, time, a + h * gauss_point[q], L);
    for (PetscInt i = 0; i < n; i++) {
      value += L[i] * f[i];
      if (logs) log_now += L[i] * logs[i];
    }
    if (!StaysBetween(value, n, f, 1) || (logs && !StaysBetween(log_now, n, logs, 0.25)))
      *good = PETSC_FALSE;
    sum += h * gauss_weight[q] * value * PetscExpReal(log_now);
  }
  return sum;
}

/* An integral over the last interval. */
typedef struct {
  PetscReal sum, doubt; /* and by how much a point less says another */
  PetscBool good;       /* false: it says nothing */
} Integral;

static Integral IntegralThrough(PetscInt n, const PetscReal time[], const PetscReal f[],
                                const PetscReal logs[]) {
  Integral all;
  PetscReal less = (time[n - 1] - time[n - 2]) * f[n - 1]; /* of one */
  PetscBool any;

  all.sum = Through(n, time, f, logs, &all.good);
  if (n > 2) less = Through(n - 1, time + 1, f + 1, logs ? logs + 1 : NULL, &any);
  all.doubt = PetscAbsReal(all.sum - less);
  return all;
}

/* What changes like energy is divided by it first, and its logarithm taken for a polynomial, too:
   while a wobble decays, a step may be many times longer than the energy lasts. */
static Integral IntegralOverEnergy(PetscInt n, const PetscReal time[], const PetscReal f[],
                                   const PetscReal energy[]) {
  PetscReal logs[BALANCE_POINTS] = {0}, part[BALANCE_POINTS] = {0};

  for (PetscInt i = 0; i < n; i++) {
    logs[i] = PetscLogReal(energy[i]);
    part[i] = f[i] / energy[i];
  }
  return IntegralThrough(n, time, part, logs);
}

/* The integral of f over the last interval: over the energy, NULL: not; nor where f itself is
   nearer to a polynomial, of which a point less says more nearly the same: powers of a rod that is
   led, say. Behind a kink, where steps begin anew and double, a polynomial through points on both
   sides may go anywhere between the last two: then through fewer points, down to the chord. */
static Integral LastInterval(PetscInt n, const PetscReal time[], const PetscReal f[],
                             const PetscReal energy[]) {
  Integral over = {.good = PETSC_FALSE}, plain;

  if (energy) over = IntegralOverEnergy(n, time, f, energy);
  if (over.good && n == 2) return over;
  plain = IntegralThrough(n, time, f, NULL);
  if (over.good) return plain.good && plain.doubt < over.doubt ? plain : over;
  for (PetscInt m = n - 1; m > 1 && !plain.good; m--)
    plain = IntegralThrough(m, time + n - m, f + n - m, NULL);
  return plain;
}

/* Can energies be divided by? Not if there is none, or none to speak of beside what friction took,
   which is then round-off; nor if they are so far apart that the round-off of a balance of large
   powers would grow. */
static PetscBool Comparable(PetscInt n, const PetscReal energy[], PetscReal lost) {
  const PetscReal rounding = 1e-14, apart = 1e4;
  PetscReal least = energy[0], most = energy[0];

  for (PetscInt i = 1; i < n; i++) {
    least = PetscMin(least, energy[i]);
    most = PetscMax(most, energy[i]);
  }
  return (PetscBool)(least > rounding * lost && most < apart * least);
}

/* What powers do in the interval that has come last. */
typedef struct {
  PetscReal net, loss, doubt; /* by how much a time less says another net work */
  PetscBool unsure; /* they are those of powers that change too fast for their latest times */
} Work;

/* The power of all that acts less what is lost, and the loss. */
static PetscReal NetPower(const Observation *seen) {
  return seen->growth_power + seen->tip_power + seen->weight_power + seen->clamp_power +
         seen->wall_power + seen->curvature_power + seen->tropism_power - seen->dissipation;
}

/* A power that is not known; a number, for a restart file holds no others. */
static const PetscReal unknown = PETSC_MAX_REAL;

/* The next point of the energy balance; known: its powers are, but behind a break. */
static void AddPoint(Observer self, const Observation *seen, PetscBool known) {
  PetscReal energy = seen->energy + seen->contact_energy;

  if (self->closed) { /* what bending lost, friction took: the powers on both sides do not tell */
    self->lost_work += PetscMax(0, self->left - energy);
    self->net_work += energy - self->left;
    self->n = 0;
  } else if (!self->n)
    self->first_energy = energy;
  known = (PetscBool)(known && !self->broken);
  self->closed = self->broken = PETSC_FALSE;
  if (self->n == BALANCE_POINTS) {
    for (int i = 1; i < BALANCE_POINTS; i++) {
      self->time[i - 1] = self->time[i];
      self->net[i - 1] = self->net[i];
      self->loss[i - 1] = self->loss[i];
      self->energy[i - 1] = self->energy[i];
    }
    self->n--;
  }
  self->time[self->n] = seen->t;
  self->net[self->n] = known ? NetPower(seen) : unknown;
  self->loss[self->n] = seen->dissipation;
  self->energy[self->n] = seen->energy;
  self->n++;
  if (self->n == 2 && self->net[0] == unknown) { /* then the first step's hold for it */
    self->net[0] = self->net[1];
    self->loss[0] = self->loss[1];
  }
}

/* What the defect is a part of. */
static PetscReal BalanceScale(const struct _Observer *self, const Observation *seen) {
  PetscReal scale = PetscMax(seen->energy + seen->contact_energy, self->first_energy);

  if (scale <= CurvatureRounding(&self->scene->curvature, seen->length))
    /* none: at rest, too, round-off of its places works against friction of 1 */
    scale = PETSC_MACHINE_EPSILON * PetscSqr(seen->length);
  return PetscMax(scale, PetscAbsReal(self->lost_work));
}

/* Work by the powers at the latest times. Of a rod that touches something these have kinks,
   wherever a place begins to touch or to slide: where a point less says another work, by more than
   this part of the scale, they do not tell what is between. (Not in the first steps, which see no
   kinks.) */
static void WorkFromTimes(const struct _Observer *self, const Observation *seen, Work *work) {
  const PetscReal sure = 1e-7, *energy = self->energy;
  Integral net;

  work->loss = LastInterval(self->n, self->time, self->loss, NULL).sum;
  if (!Comparable(self->n, energy, PetscAbsReal(self->lost_work + work->loss))) energy = NULL;
  net = LastInterval(self->n, self->time, self->net, energy);
  work->net = net.sum;
  work->doubt = net.doubt;
  work->unsure = (PetscBool)(self->touching && self->n == BALANCE_POINTS &&
                             net.doubt > sure * BalanceScale(self, seen));
}

/* Follows the energy balance dE/dt = W + power at the tip, of weight and clamp - dissipation. */
static void CloseInterval(Observer self, const Work *work, Observation *seen) {
  PetscReal energy = seen->energy + seen->contact_energy;

  self->lost_work += work->loss;
  self->net_work += work->net;
  seen->energy_defect =
      PetscAbsReal(energy - self->first_energy - self->net_work) / BalanceScale(self, seen);
}

/* The sums of the energy balance and the points they are built on, which rank 0 has. */
static void BalanceParts(Observer self, PetscReal *part[BALANCE_PARTS],
                         PetscReal *sum[BALANCE_SUMS]) {
  part[0] = self->time;
  part[1] = self->net;
  part[2] = self->loss;
  part[3] = self->energy;
  sum[0] = &self->first_energy;
  sum[1] = &self->net_work;
  sum[2] = &self->lost_work;
}

/* ObserverGetBalance - on rank 0, what the energy balance needs to go on. Not collective. */
PetscErrorCode ObserverGetBalance(Observer self, PetscReal state[BALANCE_STATE]) {
  PetscReal *part[BALANCE_PARTS], *sum[BALANCE_SUMS];

  PetscFunctionBegin;
  BalanceParts(self, part, sum);
  *state++ = self->n;
  for (int k = 0; k < BALANCE_SUMS; k++) *state++ = *sum[k];
  for (int k = 0; k < BALANCE_PARTS; k++)
    for (int i = 0; i < BALANCE_POINTS; i++) *state++ = part[k][i];
  PetscFunctionReturn(0);
}

/* ObserverSetBalance - gives back what ObserverGetBalance gave. Not collective. */
PetscErrorCode ObserverSetBalance(Observer self, const PetscReal state[BALANCE_STATE]) {
  PetscReal *part[BALANCE_PARTS], *sum[BALANCE_SUMS];

  PetscFunctionBegin;
  BalanceParts(self, part, sum);
  self->n = (PetscInt)*state++;
  for (int k = 0; k < BALANCE_SUMS; k++) *sum[k] = *state++;
  for (int k = 0; k < BALANCE_PARTS; k++)
    for (int i = 0; i < BALANCE_POINTS; i++) part[k][i] = *state++;
  PetscFunctionReturn(0);
}

/*
  ObserverClose - tells that the energy balance is to be taken for closed over the step measured
  next, and summed on from there. What it was off by before stays.

  last    what was seen where that step begins
  broken  by a jump, so that how fast the rod moves at its end is not known, either
*/
void ObserverClose(Observer observer, const Observation *last, PetscBool broken) {
  observer->closed = PETSC_TRUE;
  observer->left = last->energy + last->contact_energy;
  observer->broken = broken;
}

static PetscErrorCode LookAtContact(Observer self, PetscReal t, const Node *nodes, PetscBool moves,
                                    TouchingAsks asks) {
  PetscFunctionBegin;
  if (self->touching)
    PetscCall(TouchingLook(self->touching, t, nodes, moves, asks, &self->contact, &self->push));
  PetscFunctionReturn(0);
}

/* ObserverContact - on rank 0, where the scene has contact: its force on the rod per length, at
   nodes and between them (2 cells + 1, in the clamp's frame; friction is left out: rates are not
   known). Not collective; borrowed. */
PetscErrorCode ObserverContact(Observer observer, PetscReal t, const Node *nodes,
                               const PetscReal (**force)[PUSH]) {
  PetscFunctionBegin;
  PetscCall(LookAtContact(observer, t, nodes, PETSC_FALSE, TOUCHING_ALL));
  if (observer->touching) PetscCall(TouchingShow(observer->touching, t, nodes));
  *force = observer->push;
  PetscFunctionReturn(0);
}

/* ObserverTouch - on rank 0, what there is of contact; all 0 in a scene without. Not collective. */
PetscErrorCode ObserverTouch(Observer observer, PetscReal t, const Node *nodes, TouchSum *sum) {
  PetscFunctionBegin;
  PetscCall(LookAtContact(observer, t, nodes, PETSC_FALSE, TOUCHING_ALL));
  *sum = observer->contact;
  PetscFunctionReturn(0);
}

/* What keeps the square of an x2 this small above the smallest number: a power of two. A rod whose
   clamp is turned has no such x2. */
static PetscReal Lift(Scene scene, PetscReal most) {
  const PetscReal small = 1e-100;

  return most < small && scene->load.lab[1][0] == 0 ? 0x1p800 : 1;
}

/* What all ranks have seen of their pieces, together: a number is a sum, or 0 on all but one. */
static PetscErrorCode Measure(Observer self, PetscReal t, const Piece *piece, Observation *seen) {
  PetscReal lift;
  Extremes most;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(seen, sizeof(*seen)));
  PetscCall(MeasureExtremes(self, piece, &most));
  lift = Lift(self->scene, PetscMax(most.high, most.low));
  PetscCall(MeasureIntegrals(self, t, piece, lift, seen));
  if (self->gathered) AddContact(self, seen);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, seen, OBSERVED, MPIU_REAL, MPI_SUM, self->comm));
  PetscCall(MeasureInflections(self, t, piece, most.moment, &seen->inflections));
  seen->norm_x2 = PetscSqrtReal(seen->norm_x2) / lift;
  seen->norm_x2_length = PetscSqrtReal(seen->norm_x2_length) / lift;
  seen->norm_x3 = PetscSqrtReal(seen->norm_x3);
  seen->width = most.high + most.low;
  seen->max_angle = most.angle;
  seen->t = t;
  PetscCall(GrowthLength(self->scene->growth, t, &seen->length, &seen->growth_rate));
  seen->natural_bend = PetscSqrtReal(seen->natural_bend);
  PetscFunctionReturn(0);
}

/* What walls do where the rod sticks to them under exact friction, which its velocity does not say.
 */
static void WithWhatHolds(const RodForces *forces, TouchSum *contact) {
  for (int d = 0; d < 3; d++) contact->wall[d] = forces->walls[d];
  for (int d = 0; d < PUSH; d++) contact->tip[d] = forces->tip[d];
  contact->moved = forces->moved;
}

/* Rank 0 measures the whole rod: contact is between nodes that are far apart. */
static PetscErrorCode MeasureWhole(Observer self, PetscReal t, Vec v, PetscBool moves,
                                   TouchingAsks asks, Observation *seen) {
  Piece piece = {.first = 0, .end = -1};

  PetscFunctionBegin;
  PetscCall(Gather(self, v, &piece.node));
  if (piece.node) {
    piece.end = self->nodes - 1;
    PetscCall(LookAtContact(self, t, piece.node, moves, asks));
    if (self->whole) WithWhatHolds(&self->forces, &self->contact);
  }
  PetscCall(Measure(self, t, &piece, seen));
  PetscFunctionReturn(0);
}

/* Each rank measures the cells that begin at its nodes. */
static PetscErrorCode MeasurePieces(Observer self, Rod rod, PetscReal t, Vec v, Observation *seen) {
  Piece piece = {.first = rod->first, .end = PetscMin(rod->end, rod->last)};
  const Node *with;
  Vec local = v; /* alone it has all */

  PetscFunctionBegin;
  if (!rod->alone) {
    PetscCall(DMGetLocalVector(rod->nodes, &local));
    PetscCall(DMGlobalToLocal(rod->nodes, v, INSERT_VALUES, local));
  }
  PetscCall(DMDAVecGetArrayRead(rod->nodes, local, (void *)&with));
  piece.node = &with[piece.first];
  PetscCall(Measure(self, t, &piece, seen));
  PetscCall(DMDAVecRestoreArrayRead(rod->nodes, local, (void *)&with));
  if (!rod->alone) PetscCall(DMRestoreLocalVector(rod->nodes, &local));
  PetscFunctionReturn(0);
}

/* Where the rod crosses itself: rank 0 looks. */
static PetscErrorCode MeasureCrossings(Observer self, Vec v, Observation *seen) {
  const Node *nodes;
  PetscInt crossings = 0;

  PetscFunctionBegin;
  if (seen->max_angle <= PETSC_PI / 2 || self->space) PetscFunctionReturn(0);
  PetscCall(Gather(self, v, &nodes));
  if (nodes) PetscCall(RodCrossings(self->nodes, nodes, &crossings));
  seen->self_crossings = crossings;
  PetscFunctionReturn(0);
}

/* What the stepper has kept of a state, nothing of one at rest. If it is whole rank 0 needs it of
   all of the rod. */
static PetscErrorCode TakeForces(Observer self, Rod rod, PetscReal t, Vec U_t) {
  PetscFunctionBegin;
  PetscCall(PetscMemzero(&self->forces, sizeof(self->forces)));
  self->linear = rod->model->linear;
  self->whole = PETSC_FALSE;
  if (U_t) self->whole = RodForcesAt(rod, t, &self->forces);
  if (self->whole && !rod->alone)
    PetscCallMPI(
        MPI_Allreduce(MPI_IN_PLACE, &self->forces, ROD_FORCES, MPIU_REAL, MPI_SUM, self->comm));
  PetscFunctionReturn(0);
}

static PetscErrorCode Look(Observer self, Rod rod, PetscReal t, Vec U, Vec U_t, TouchingAsks asks,
                           Observation *seen) {
  Vec v;

  PetscFunctionBegin;
  PetscCall(TakeForces(self, rod, t, U_t));
  PetscCall(NodesOf(rod, t, U, U_t, &v));
  if (self->scene->contact.any)
    PetscCall(MeasureWhole(self, t, v, (PetscBool)(U_t != NULL), asks, seen));
  else
    PetscCall(MeasurePieces(self, rod, t, v, seen));
  if (asks == TOUCHING_ALL) PetscCall(MeasureCrossings(self, v, seen));
  PetscCall(DMRestoreGlobalVector(rod->nodes, &v));
  PetscFunctionReturn(0);
}

/* ObserverLook - what is measured on a rod at rest, on every rank, with no share in the balance of
   energy, and at any time. Collective. */
PetscErrorCode ObserverLook(Observer observer, Rod rod, PetscReal t, Vec U, Observation *seen) {
  PetscFunctionBegin;
  PetscCall(Look(observer, rod, t, U, NULL, TOUCHING_ALL, seen));
  PetscCallMPI(MPI_Bcast(seen, OBSERVED, MPIU_REAL, 0, observer->comm));
  PetscFunctionReturn(0);
}

/* ObserverLookMoving - likewise, of one that moves: at a time within the latest step, behind which
   the law of contact is left as it was. Collective. */
PetscErrorCode ObserverLookMoving(Observer observer, Rod rod, PetscReal t, Vec U, Vec U_t,
                                  Observation *seen) {
  const PetscReal before = observer->scene->contact.time;

  PetscFunctionBegin;
  PetscCall(Look(observer, rod, t, U, U_t, TOUCHING_ALL, seen));
  PetscCall(SceneContactAt(observer->scene, before));
  PetscCallMPI(MPI_Bcast(seen, OBSERVED, MPIU_REAL, 0, observer->comm));
  PetscFunctionReturn(0);
}

/* Work by powers within the step: those of its dense output, by Gauss's rule. On that way energy
   and work differ by no more than what forces on it leave unbalanced: which is much where a long
   step slides on what is stiff. So a work that is off that of the times by so many times their
   doubt is none. (A look costs a quarter of an iteration; PETSc's steppers are not asked.)
   Collective. */
static PetscErrorCode WorkWithin(Observer self, Rod rod, const PetscReal between[2], Vec U,
                                 Leg *leg, Work *work) {
  const PetscReal h = between[1] - between[0], far = 100;
  PetscReal net = 0, loss = 0;
  PetscBool known = PETSC_TRUE;
  Observation seen;
  Vec V, V_t;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(U, &V));
  PetscCall(VecDuplicate(U, &V_t));
  for (int q = 0; q < GAUSS && known; q++) {
    PetscReal t = between[0] + h * gauss_point[q];
    PetscCall(LegWithin(leg, t, V, V_t, &known));
    if (known) PetscCall(Look(self, rod, t, V, V_t, TOUCHING_POWERS, &seen));
    if (known) net += h * gauss_weight[q] * NetPower(&seen);
    if (known) loss += h * gauss_weight[q] * seen.dissipation;
  }
  if (known && PetscAbsReal(net - work->net) <= far * work->doubt)
    *work = (Work){.net = net, .loss = loss};
  PetscCall(VecDestroy(&V));
  PetscCall(VecDestroy(&V_t));
  PetscCall(SceneContactAt(self->scene, between[1])); /* the law as it was left by the last look */
  PetscFunctionReturn(0);
}

/* Follows the balance of energy to what is seen: rank 0 does, and says when it needs to look within
   the step. Collective. */
static PetscErrorCode MeasureBalance(Observer self, Rod rod, Vec U, Leg *leg, Observation *seen) {
  PetscReal between[2] = {0, 0}; /* the interval to look within */
  Work work = {0};
  PetscBool new = (PetscBool)(self->gathered && !(self->n && seen->t == self->time[self->n - 1]));

  PetscFunctionBegin;
  if (new) {
    AddPoint(self, seen, (PetscBool)(U != NULL));
    if (self->n > 1) WorkFromTimes(self, seen, &work);
    for (int k = 0; k < 2 && work.unsure; k++) between[k] = self->time[self->n - 2 + k];
  }
  if (leg) PetscCallMPI(MPI_Bcast(between, 2, MPIU_REAL, 0, self->comm));
  if (leg && between[1] > between[0]) PetscCall(WorkWithin(self, rod, between, U, leg, &work));
  if (new) CloseInterval(self, &work, seen);
  PetscFunctionReturn(0);
}

/*
  ObserverMeasure - all that is measured on a rod at one time; step, newton_iterations and model are
  left to the caller. Collective; the result is on every rank. Times must come in increasing order,
  for the energy balance is summed from one to the next.

  leg  whose latest step has led there, for what happens within it; NULL: it is not known
*/
PetscErrorCode ObserverMeasure(Observer observer, Rod rod, PetscReal t, Vec U, Vec U_t, Leg *leg,
                               Observation *seen) {
  PetscFunctionBegin;
  PetscCall(Look(observer, rod, t, U, U_t, TOUCHING_ALL, seen));
  PetscCall(MeasureBalance(observer, rod, U, leg, seen));
  PetscCallMPI(MPI_Bcast(seen, OBSERVED, MPIU_REAL, 0, observer->comm));
  PetscFunctionReturn(0);
}
