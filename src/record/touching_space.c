/* What walls do to a rod in space. */
#include "record/touching.h"

/* A point that is looked at: the length of rod that it stands for, and what comes to that in a unit
   of time. */
typedef struct {
  const Sample3 *sample;
  PetscReal s, length, length_t;
  PetscBool moves, tip;
} Spot3;

/* Adds one wall's push on `length` of rod. */
static void AddWall3(const Contact *contact, const Touch3 *touch, const Rubbed *at,
                     PetscReal length, PetscReal length_t, PetscReal force[PUSH], TouchSum *sum) {
  PetscReal U = ContactEnergy(contact, touch->gap);
  Push3 push;

  ContactPush3(contact, touch, at, NULL, &push);
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

static void Nearest3(TouchSum *sum, PetscReal gap, const Spot3 *spot) {
  if (gap >= sum->nearest) return;
  sum->nearest = gap;
  sum->at[0] = spot->s;
  sum->at[1] = -1;
  for (int d = 0; d < 3; d++) sum->x[d] = spot->sample->at.x[d];
  sum->depth = PetscMax(sum->depth, -gap);
}

/* The walls on one point, and on the tip besides if it is that; do they touch it? */
static PetscBool Walls3(const Contact *contact, const Spot3 *spot, PetscReal force[PUSH],
                        TouchSum *sum) {
  const PetscReal rest[3] = {0};
  const Place3 *place = &spot->sample->at;
  const Rubbed at = {place->x, place->q, spot->moves ? place->W : rest,
                     spot->moves ? spot->sample->spin : 0};
  PetscReal gap = ContactGap3(contact, place->x, PetscMax(contact->smooth, sum->nearest)),
            on_tip[PUSH] = {0};
  Touch3 touch[MOST_TOUCHES3];
  PetscInt n = gap < contact->smooth ? ContactTouches3(contact, place->x, touch) : 0;

  for (PetscInt k = 0; k < n; k++) {
    AddWall3(contact, &touch[k], &at, spot->length, spot->length_t, force, sum);
    if (spot->tip) AddWall3(contact, &touch[k], &at, contact->tip, contact->tip_t, on_tip, sum);
  }
  for (int d = 0; d < PUSH && spot->tip; d++) sum->tip[d] += contact->tip * on_tip[d];
  Nearest3(sum, gap, spot);
  return (PetscBool)(gap <= 0);
}

/* A spot that stands for this much of s. */
static Spot3 SpotOf(const Sample3 *sample, PetscReal s, PetscReal weight, PetscBool moves) {
  Spot3 spot = {.sample = sample, .s = s, .moves = moves};

  spot.length = sample->g * weight;
  spot.length_t = sample->strain * weight;
  if (s == 0 && moves) spot.length_t += sample->c; /* what comes in at the clamp */
  return spot;
}

/*
  TouchingWalls3 - adds what the walls around a rod in space amount to at one time. Not collective.

  nodes  cells + 1 nodes, all of the rod    moves  their rates are known
  force  added to, per length: at nodes and between them, 2 cells + 1
*/
PetscErrorCode TouchingWalls3(Scene scene, PetscReal t, const Node *nodes, PetscBool moves,
                              PetscReal (*force)[PUSH], TouchSum *sum) {
  const PetscReal *s = scene->mesh.s;
  const PetscInt cells = scene->mesh.cells;
  PetscBool before = PETSC_FALSE;
  Sample3 a, b, mid;

  PetscFunctionBegin;
  for (PetscInt i = 0; i <= cells; i++) {
    const PetscReal behind = i < cells ? s[i + 1] - s[i] : 0, ahead = i ? s[i] - s[i - 1] : 0;
    PetscBool touches;
    Spot3 spot;
    b.node = nodes[i];
    b.push = force[2 * i];
    PetscCall(SampleFill3(scene, s[i], t, &b));
    spot = SpotOf(&b, s[i], (ahead + behind) / 6, moves);
    spot.tip = (PetscBool)(i == cells && scene->tip.type == TIP_FREE);
    touches = Walls3(&scene->contact, &spot, force[2 * i], sum);
    if (i) { /* the middle of the cell before it follows from both its ends */
      PetscBool between;
      PetscCall(SampleMid3(scene, s[i - 1], s[i], t, &a, &b, &mid));
      spot = SpotOf(&mid, (s[i - 1] + s[i]) / 2, 4 * ahead / 6, moves);
      between = Walls3(&scene->contact, &spot, force[2 * i - 1], sum);
      sum->zones += between && !before;
      before = between;
    }
    sum->zones += touches && !before;
    before = touches;
    a = b;
  }
  PetscFunctionReturn(0);
}
