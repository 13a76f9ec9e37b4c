/* What the material of a rod in space learns (learned.h): its bends about d3 and d2, at nodes and
   in the middles of cells. */
#include "base/vectors.h"
#include "rod/space_cells.h"
#include <string.h>

/* The director that a bend is about. */
static const int turn[TROPISM_BENDS] = {2, 1};

/* What a place senses, where p is, and its bends. */
static void SeePoint(const Rod rod, PetscInt place, const Point *p, LearnedPoint *point) {
  const Law *law = &((const Space_ *)rod->data)->law[place];
  PetscReal pull[3] = {0};

  if (LearnedSenses(rod, place)) TropismPull(&rod->scene->tropism, p->at.x, pull, NULL);
  for (int b = 0; b < TROPISM_BENDS; b++) {
    point->sensed[b] = TropismSensed(&p->at, b, pull);
    point->natural[b] = law->u0[turn[b]];
    point->elastic[b] = law->flex[turn[b]] * Dot3(p->at.axes[turn[b]], p->m);
  }
}

/* SpaceLearnedSlope - how these change with x, p and m there; u_p, u_m: the strains by p and m. */
void SpaceLearnedSlope(const Rod rod, PetscInt place, const Point *p, const PetscReal (*u_p)[4],
                       const PetscReal (*u_m)[3], LearnedSlope *slope) {
  PetscReal pull[3], by_x[3][3];

  for (int b = 0; b < TROPISM_BENDS; b++) {
    for (int i = 0; i < FIELDS; i++) slope->sensed[b][i] = slope->elastic[b][i] = 0;
    for (int j = 0; j < 4; j++) slope->elastic[b][P + j] = u_p[turn[b]][j];
    for (int i = 0; i < 3; i++) slope->elastic[b][M + i] = u_m[turn[b]][i];
  }
  if (!LearnedSenses(rod, place)) return;
  TropismPull(&rod->scene->tropism, p->at.x, pull, by_x);
  for (int b = 0; b < TROPISM_BENDS; b++) {
    const int along = b ? 2 : 1; /* sensed about d3 is along d2, about d2 along -d3 */
    const PetscReal sign = b ? -1 : 1;
    PetscReal D[3][4];
    DirectorSlope(p->p, p->size, p->at.axes[along], along, D);
    for (int i = 0; i < 3; i++) {
      for (int j = 0; j < 4; j++) slope->sensed[b][P + j] += sign * pull[i] * D[i][j];
      for (int j = 0; j < 3; j++)
        slope->sensed[b][X + j] += sign * p->at.axes[along][i] * by_x[i][j];
    }
  }
}

static PetscInt FirstPlace(const Rod rod) {
  return 2 * (PetscMax(rod->first - 1, 0) - rod->first + 1);
}

static PetscInt LastPlace(const Rod rod) {
  return 2 * (PetscMin(rod->end, rod->last) - rod->first + 1);
}

/* SpaceLearnedLaws - keeps what laws are at a time, before the state adds to them. */
void SpaceLearnedLaws(Rod rod, PetscReal t) {
  const Space_ *self = (const Space_ *)rod->data;
  Learned learned = rod->learned;

  for (PetscInt k = FirstPlace(rod); k <= LastPlace(rod); k++) {
    const Law *law = &self->law[k];
    for (int b = 0; b < TROPISM_BENDS; b++)
      learned->given[TROPISM_BENDS * k + b] = law->u0[turn[b]];
    learned->clock[k] =
        TropismClock(&rod->scene->tropism, rod->scene->growth, law->s, t, law->g, law->g_t);
  }
}

/* SpaceLearnedOpen - takes a state apart: natural bends are those that it has learned, too.
   Collective. */
PetscErrorCode SpaceLearnedOpen(Rod rod, const RodState *at) {
  const Space_ *self = (const Space_ *)rod->data;
  Learned learned = rod->learned;

  PetscFunctionBegin;
  PetscCall(LearnedOpen(rod, at));
  for (PetscInt k = FirstPlace(rod); k <= LastPlace(rod); k++)
    for (int b = 0; b < TROPISM_BENDS; b++)
      self->law[k].u0[turn[b]] = learned->given[TROPISM_BENDS * k + b] + LearnedAt(learned, k)[b];
  PetscFunctionReturn(0);
}

/* SpaceLearnedResidual - of node i, which is p, and of the middle of the cell behind it; NULL: it
   is the last. */
void SpaceLearnedResidual(Rod rod, PetscInt i, const Point *p, const Point *mid) {
  const PetscInt place = 2 * (i - rod->first + 1);
  LearnedPoint point;

  SpaceLearnedDrives(rod, i, p, mid);
  if (mid || !rod->learned->at_tip) return;
  SeePoint(rod, place, p, &point);
  LearnedSignalResidual(rod, point.sensed);
}

/* SpaceLearnedDrives - what drives the states of node i, which is p, and of the middle of the cell
   behind it; NULL: not of that. */
void SpaceLearnedDrives(Rod rod, PetscInt i, const Point *p, const Point *mid) {
  const PetscInt place = 2 * (i - rod->first + 1);
  LearnedPoint point;

  SeePoint(rod, place, p, &point);
  LearnedResidual(rod, place, &point);
  if (!mid) return;
  SeePoint(rod, place + 1, mid, &point);
  LearnedResidual(rod, place + 1, &point);
}

/* SpaceLearnedTurn - p' by a bend: g/2 p (0, 1 along it). */
void SpaceLearnedTurn(const Law *law, const Point *p, int bend, PetscReal by[4]) {
  PetscReal unit[3] = {0};

  unit[turn[bend]] = law->g / 2;
  QuaternionTurn(p->p, unit, by);
}
