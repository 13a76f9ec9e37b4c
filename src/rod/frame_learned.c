/* What the material of a rod in the plane learns (learned.h): its bend about d3, at nodes and in
   the middles of cells. */
#include "rod/frame.h"
#include "rod/learned.h"
#include <string.h>

/* x in the middle of a cell, of which a point that does not feel it knows none; k = bow h. */
static Vector2 MidPlace(PetscReal k, const Point *a, const Point *b) {
  return CurveMid2(k, From2(a->at.x), From2(a->f + X1), From2(b->at.x), From2(b->f + X1));
}

/* What a place senses, where p is, and its bends. */
static void SeePoint(const Rod rod, PetscInt place, Vector2 x, const Point *p,
                     LearnedPoint *point) {
  const Law *law = &((const Frame *)rod->data)->law[place];
  const Tropism *tropism = &rod->scene->tropism;
  PetscReal pull[3] = {0};

  if (LearnedSenses(rod, place)) TropismPull(tropism, (const PetscReal[3]){x.x, x.y}, pull, NULL);
  point->sensed[0] = TropismSensed(&p->at, 0, pull);
  point->natural[0] = law->k0;
  point->elastic[0] = p->m * law->flex;
}

/* ... and how these change with x, theta and m there: d2 turns by -d1. */
static void SeeSlope(const Rod rod, PetscInt place, Vector2 x, const Point *p,
                     LearnedSlope *slope) {
  const Vector2 q = From2(p->at.axes[0]);
  PetscReal pull[3], by_x[3][3];

  for (int f = 0; f < YIELD_FIELDS; f++) slope->sensed[0][f] = slope->elastic[0][f] = 0;
  slope->elastic[0][M] = ((const Frame *)rod->data)->law[place].flex;
  if (!LearnedSenses(rod, place)) return;
  TropismPull(&rod->scene->tropism, (const PetscReal[3]){x.x, x.y}, pull, by_x);
  slope->sensed[0][TH] = -Dot2(From2(pull), q);
  for (int f = X1; f <= X2; f++) slope->sensed[0][f] = Cross2(q, Column2(by_x[0], 3, f));
}

/* FrameLearnedLaws - keeps what laws are at a time, before the state adds to them. */
void FrameLearnedLaws(Rod rod, PetscReal t) {
  const Frame *frame = (const Frame *)rod->data;
  Learned self = rod->learned;
  const PetscInt from = 2 * (PetscMax(rod->first - 1, 0) - rod->first + 1),
                 to = 2 * (PetscMin(rod->end, rod->last) - rod->first + 1);

  for (PetscInt k = from; k <= to; k++) {
    const Law *law = &frame->law[k];
    self->given[k] = law->k0;
    self->clock[k] =
        TropismClock(&rod->scene->tropism, rod->scene->growth, law->s, t, law->g, law->g_t);
  }
}

/* FrameLearnedOpen - takes a state apart: natural curvatures are those that it has learned, too.
   Collective. */
PetscErrorCode FrameLearnedOpen(Rod rod, const RodState *at) {
  const Frame *frame = (const Frame *)rod->data;
  Learned self = rod->learned;
  const PetscInt from = 2 * (PetscMax(rod->first - 1, 0) - rod->first + 1),
                 to = 2 * (PetscMin(rod->end, rod->last) - rod->first + 1);

  PetscFunctionBegin;
  PetscCall(LearnedOpen(rod, at));
  for (PetscInt k = from; k <= to; k++) frame->law[k].k0 = self->given[k] + *LearnedAt(self, k);
  PetscFunctionReturn(0);
}

/* FrameLearnedResidual - of node i, which is p; mid: of the cell behind it, between it and b; NULL:
   it is the last. */
void FrameLearnedResidual(Rod rod, PetscInt i, PetscReal h, const Point *p, const Point *mid,
                          const Point *b) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt place = 2 * (i - rod->first + 1);
  LearnedPoint point;

  SeePoint(rod, place, From2(p->at.x), p, &point);
  LearnedResidual(rod, place, &point);
  if (!mid) {
    if (rod->learned->at_tip) LearnedSignalResidual(rod, point.sensed);
    return;
  }
  SeePoint(rod, place + 1, MidPlace(frame->bow * h, p, b), mid, &point);
  LearnedResidual(rod, place + 1, &point);
}

/* FrameLearnedDrives - what drives the states of the cell behind node i; of that at a
   where it is asked for. */
void FrameLearnedDrives(Rod rod, PetscInt i, PetscReal h, const Point *a, const Point *mid,
                        const Point *b, PetscBool at_a) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt place = 2 * (i - rod->first + 1);
  LearnedPoint point;

  if (at_a) {
    SeePoint(rod, place, From2(a->at.x), a, &point);
    LearnedResidual(rod, place, &point);
  }
  SeePoint(rod, place + 1, MidPlace(frame->bow * h, a, b), mid, &point);
  LearnedResidual(rod, place + 1, &point);
  SeePoint(rod, place + 2, From2(b->at.x), b, &point);
  LearnedResidual(rod, place + 2, &point);
}

/* The unknowns in the middle by those of one end, and by the bend learned there; k = bow h, -bow h
   of the end towards the tip. */
static void MidByEnd(PetscReal k, const Law *law, const Point *p,
                     PetscReal by[LEARNED_MOST][LEARNED_MOST], PetscReal by_bend[LEARNED_MOST]) {
  const PetscReal kg = k * law->g, *q = p->at.axes[0];

  for (int f = X1; f <= M; f++)
    for (int u = 0; u < FIELDS; u++) by[f][u] = 0;
  for (int f = 0; f < FIELDS; f++) by_bend[f] = 0;
  for (int f = X1; f <= M; f++) by[f][f] = 0.5;
  by[X1][TH] = -kg * q[1];
  by[X2][TH] = kg * q[0];
  by[TH][M] = kg * law->flex;
  by[M][TH] = kg * (q[0] * p->n[0] + q[1] * p->n[1]);
  by[M][N1] = kg * q[1];
  by[M][N2] = -kg * q[0];
  by_bend[TH] = kg;
}

/* A cell's equations by the bend learned at one of its nodes: all that the moment there does by the
   elastic bend, and not by itself. */
static void ColumnOf(PetscReal J[FIELDS][FIELDS], PetscReal own, PetscReal in_mid, PetscReal flex,
                     PetscReal column[]) {
  for (int r = 0; r < FIELDS; r++) {
    const PetscReal itself = r == M ? own : r == TH ? in_mid : 0;
    column[r] = (J[r][M] - itself) / flex;
  }
}

/* FrameLearnedSlopes - the slopes at the nodes of a cell, where they are asked for, and in its
   middle; and its equations by the bend learned there. */
void FrameLearnedSlopes(Rod rod, PetscInt i, PetscReal h, const Point *a, const Point *mid,
                        const Point *b, PetscBool at_a, PetscBool at_b, LearnedCell *cell) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt place = 2 * (i - rod->first + 1);

  if (at_a) SeeSlope(rod, place, From2(a->at.x), a, &cell->slope[AT_A]);
  SeeSlope(rod, place + 1, MidPlace(frame->bow * h, a, b), mid, &cell->slope[AT_MID]);
  if (at_b) SeeSlope(rod, place + 2, From2(b->at.x), b, &cell->slope[AT_B]);
  for (int f = 0; f < YIELD_FIELDS; f++) cell->column[AT_MID][0][f] = 0;
  cell->column[AT_MID][0][TH] = -h * frame->mid_weight * frame->law[place + 1].g;
}

/* FrameLearnedCell - a cell's part, from its equations by its nodes; the slopes at these where they
   are asked for. */
void FrameLearnedCell(Rod rod, PetscInt i, PetscReal h, const Point *a, const Point *mid,
                      const Point *b, PetscBool at_a, PetscBool at_b,
                      PetscReal left[FIELDS][FIELDS], PetscReal right[FIELDS][FIELDS],
                      LearnedCell *cell) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt place = 2 * (i - rod->first + 1);
  const Law *law = frame->law + place;
  const PetscReal k = frame->bow * h, wm = h * frame->mid_weight * law[AT_MID].g;

  FrameLearnedSlopes(rod, i, h, a, mid, b, at_a, at_b, cell);
  MidByEnd(k, law, a, cell->by_node[0], cell->by_bend[0][0]);
  MidByEnd(-k, law + AT_B, b, cell->by_node[1], cell->by_bend[1][0]);
  ColumnOf(left, -1, -wm * law[AT_MID].flex / 2, law[AT_A].flex, cell->column[AT_A][0]);
  ColumnOf(right, 1, -wm * law[AT_MID].flex / 2, law[AT_B].flex, cell->column[AT_B][0]);
}
