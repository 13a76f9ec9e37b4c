#include "record/observe.h"
#include "record/balance.h"
#include "base/lagrange.h"
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
  Node *gathered;  /* rank 0: cells + 1 nodes */
  Balance balance; /* of energy */
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

/* ObserverAmong - what it measures is one of several rods: who knows all of them tells what strands
   do to it. */
void ObserverAmong(Observer self, TouchingTell tell, void *ctx, PetscInt rod) {
  if (self->touching) TouchingAmong(self->touching, tell, ctx, rod);
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
  Split3(lab, &seen->wall_force_1, &seen->wall_force_2, &seen->wall_force_3);
  seen->wall_power = contact->moved + contact->given;
  SceneToLab(self->scene, contact->clamp, lab);
  seen->base_force_1 -= lab[0];
  seen->base_force_2 -= lab[1];
  seen->base_force_3 -= lab[2];
  seen->dissipation += contact->loss;
  seen->growth_power += contact->strain;
}

/* What a piece of a rod gives to n1(0) - n1(1). */
static PetscReal AxialDrop(const Observer self, const Piece *piece) {
  PetscReal drop = 0;

  if (piece->end < piece->first) return 0;
  for (int end = 0; end < 2; end++) {
    const Node *node = &piece->node[end ? piece->end - piece->first : 0];
    const PetscReal n1 = node->force[0];
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
  Split3(lab, &seen->friction_force_1, &seen->friction_force_2, &seen->friction_force_3);
  SceneToLab(self->scene, weight, lab);
  Split3(lab, &seen->weight_force_1, &seen->weight_force_2, &seen->weight_force_3);
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
  const TouchFeet *of_cells = NULL;
  const PetscInt n = self->touching ? TouchingFeet(self->touching, &of_cells) : 0;

  PetscFunctionBegin;
  if (piece->end >= piece->first && self->space) {
    const SampleLaw *law = NULL;
    PetscCall(LawsOf(self, t, piece, &law));
    PetscCall(ObserveSpace(self->scene, t, piece->first, piece->end, piece->node, law, self->push,
                           self->contact.tip, n, of_cells, seen));
  } else if (piece->end >= piece->first)
    PetscCall(ObservePlane(self->scene, t, piece->first, piece->end, piece->node, self->push,
                           self->contact.tip, n, of_cells, lift, seen));
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

/*
  ObserverClose - tells that the energy balance is to be taken for closed over the step measured
  next, and summed on from there. What it was off by before stays.

  last    what was seen where that step begins
  broken  by a jump, so that how fast the rod moves at its end is not known, either
*/
void ObserverClose(Observer observer, const Observation *last, PetscBool broken) {
  Balance *balance = &observer->balance;

  balance->closed = PETSC_TRUE;
  balance->left = last->energy + last->contact_energy;
  balance->broken = broken;
}

/* ObserverGetBalance - on rank 0, what the energy balance needs to go on. Not collective. */
void ObserverGetBalance(Observer self, PetscReal state[BALANCE_STATE]) {
  BalanceGet(&self->balance, state);
}

/* ObserverSetBalance - gives back what ObserverGetBalance gave. Not collective. */
void ObserverSetBalance(Observer self, const PetscReal state[BALANCE_STATE]) {
  BalanceSet(&self->balance, state);
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
    if (known) net += h * gauss_weight[q] * BalancePower(&seen);
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
  PetscReal between[] = {0, 0}; /* the interval to look within */
  Work work = {0};
  Balance *balance = &self->balance;
  PetscBool new =
      (PetscBool)(self->gathered && !(balance->n && seen->t == balance->time[balance->n - 1]));

  PetscFunctionBegin;
  if (new) {
    BalanceAdd(balance, seen, (PetscBool)(U != NULL));
    if (balance->n > 1) BalanceFromTimes(balance, self->scene, seen, &work);
    for (int k = 0; k < 2 && work.unsure; k++) between[k] = balance->time[balance->n - 2 + k];
  }
  if (leg) PetscCallMPI(MPI_Bcast(between, 2, MPIU_REAL, 0, self->comm));
  if (leg && between[1] > between[0]) PetscCall(WorkWithin(self, rod, between, U, leg, &work));
  if (new) BalanceClose(balance, self->scene, &work, seen);
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
