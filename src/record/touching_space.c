/* What walls do to a rod in space. */
#include "record/touching.h"
#include "rod/directors.h"

static const PetscReal rest[3] = {0};

/* A spot that stands for this much of s. */
static WallSpot SpotOf(const Sample3 *sample, PetscReal s, PetscReal weight, PetscBool moves) {
  const Place *place = &sample->at;
  WallSpot spot = {
      .at = {place->x, place->axes[0], moves ? place->v : rest, moves ? sample->spin : 0}, .s = s};

  spot.length = sample->law.g * weight;
  spot.length_t = sample->law.strain * weight;
  if (s == 0 && moves) spot.length_t += sample->law.c; /* what comes in at the clamp */
  return spot;
}

/* ---- feet ---- */

/* The cell between two nodes, for its feet; t: the time. */
static void FeetsCell(Scene scene, PetscReal t, PetscInt i, PetscBool moves, const Sample3 *a,
                      const Sample3 *b, FootCell *cell) {
  PetscInt nodes;
  const PetscReal *s = SceneLabels(scene, &nodes);
  const Sample3 *end[] = {a, b};
  CurveCell *curve = &cell->curve;

  *cell = (FootCell){.dims = 3, .moves = moves, .weight = {1. / 6, 4. / 6, 1. / 6}};
  curve->h = s[i + 1] - s[i];
  cell->first = (PetscBool)(i == 0);
  cell->last = (PetscBool)(i == nodes - 2);
  for (int k = 0; k < FOOT_PARTS; k++)
    curve->c[k] = GrowthSlide(scene->growth, (s[i + k / 2] + s[i + (k + 1) / 2]) / 2, t);
  for (int e = 0; e < 2; e++) {
    const Sample3 *p = end[e];
    const PetscReal *p_t = p->node.p_t, size = QuaternionSize(p->node.p);
    PetscReal D[3][4];
    DirectorSlope(p->node.p, size, p->at.axes[0], 0, D);
    curve->g[e] = p->law.g;
    cell->spin[e] = p->spin;
    for (int d = 0; d < 3; d++) {
      curve->x[e][d] = p->node.x[d];
      curve->q[e][d] = p->at.axes[0][d];
      curve->x_t[e][d] = p->node.x_t[d];
      curve->slope_t[e][d] = p->law.g_t * p->at.axes[0][d] + p->law.g * Dot4(D[d], p_t);
    }
  }
}

/*
  TouchingWalls3 - adds what the walls around a rod in space amount to at one time. Not collective.

  touching  takes what feet add to the points of their cells
  nodes  cells + 1 nodes, all of the rod    moves  their rates are known
  likely a node which may be nearest to a wall: what is farther than it is looked at no longer
  law    at nodes and between them
  force  added to, per length: at nodes and between them, 2 cells + 1
*/
PetscErrorCode TouchingWalls3(Touching self, Scene scene, PetscReal t, const Node *nodes,
                              PetscBool moves, PetscInt likely, const SampleLaw law[],
                              PetscReal (*force)[PUSH], TouchSum *sum) {
  PetscInt all;
  const PetscReal round_off = 1e-9, *s = SceneLabels(scene, &all);
  const Contact *contact = &scene->contact;
  const PetscInt cells = all - 1;
  PetscBool before = PETSC_FALSE;
  Sample3 a, b, mid;
  PetscReal bound = sum->nearest;

  PetscFunctionBegin;
  if (bound > contact->smooth) {
    bound = ContactGap(3, contact, nodes[likely].x, bound);
    if (bound < sum->nearest) bound += round_off * PetscAbsReal(bound);
  }
  for (PetscInt i = 0; i <= cells; i++) {
    const PetscReal behind = i < cells ? s[i + 1] - s[i] : 0, ahead = i ? s[i] - s[i - 1] : 0;
    PetscBool touches;
    WallSpot spot;
    b.node = nodes[i];
    b.push = force[2 * i];
    PetscCall(SampleFill3(scene, s[i], t, &law[2 * i], &b));
    spot = SpotOf(&b, s[i], (ahead + behind) / 6, moves);
    spot.tip = (PetscBool)(i == cells && scene->tip.type == TIP_FREE);
    touches = TouchingWalls(3, contact, &spot, bound, force[2 * i], sum);
    if (i) { /* the middle of the cell before it follows from both its ends */
      const PetscReal(*feet)[FOOT_LOAD] = NULL;
      PetscBool between, at_feet = PETSC_FALSE;
      FootCell cell;
      if (contact->thin) {
        FeetsCell(scene, t, i - 1, moves, &a, &b, &cell);
        PetscCall(TouchingCell(self, i - 1, &cell, sum, &at_feet, &feet));
      }
      PetscCall(SampleMid3(scene, s[i - 1], s[i], t, &law[2 * i - 1], &a, &b, feet, &mid));
      spot = SpotOf(&mid, (s[i - 1] + s[i]) / 2, 4 * ahead / 6, moves);
      between = TouchingWalls(3, contact, &spot, bound, force[2 * i - 1], sum);
      between = (PetscBool)(between || at_feet);
      sum->zones += between && !before;
      before = between;
    }
    sum->zones += touches && !before;
    before = touches;
    a = b;
  }
  PetscFunctionReturn(0);
}
