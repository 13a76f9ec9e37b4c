/* Exact Coulomb friction of a rod in space: what is held, what the world bears, and what Newton's
   method remembers of it from step to step. */
#include "rod/space_cells.h"

/* Adds what the points of a cell and its feet bear; end: what its first point does, and then its
   last one. */
static void AddForces(const Cell *cell, RodForces *end, RodForces *sum) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const Point *at[3] = {NULL, cell->mid, cell->b};
  const PetscReal weight[3] = {self->end_weight, self->mid_weight, self->end_weight};

  for (int k = 0; k < 3; k++) {
    const PetscReal length = cell->h * weight[k] * cell->law[k].g;
    if (at[k])
      LoadParts(3, cell->load, &at[k]->at, cell->dual[k], end->friction, end->walls, &end->moved);
    for (int d = 0; d < 3; d++) {
      sum->friction[d] += length * end->friction[d];
      sum->walls[d] += length * end->walls[d];
    }
    sum->moved += length * end->moved;
  }
  for (PetscInt k = 0; k < cell->feet.n; k++)
    for (int d = 0; d < 3; d++) {
      const Touch *touch = &cell->feet.touch[k];
      sum->walls[d] += cell->feet.foot[k].force[d];
      if (touch->moves) sum->moved += cell->feet.foot[k].force[d] * touch->v[d];
    }
}

/* Adds what the tip bears. */
static void AddTip(const Cell *cell, RodForces *sum) {
  Rod rod = cell->rod;
  const TipState tip = SpaceTipOf(cell->load, cell->b);
  const PetscInt last = 2 * rod->last + 1;

  sum->moved += TipWalls(3, &rod->scene->tip, &tip, SpaceTipDual(rod), sum->tip);
  for (int d = 0; d < 3; d++) sum->walls[d] += sum->tip[d];
  for (int d = 0; d < 3 && cell->push && rod->scene->tip.type == TIP_FREE; d++) {
    sum->tip[d] += cell->push[last][d];
    if (cell->couple) sum->tip[SPIN] += cell->couple[last][d] * cell->b->at.axes[0][d];
  }
}

/* SpaceBears - what the world does to the owned part of the rod. */
PetscErrorCode SpaceBears(Rod rod, const RodState *at, RodForces *sum) {
  RodForces end = {.moved = 0};
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (i < rod->first) continue;
    if (i == rod->first)
      LoadParts(3, cell.load, &cell.a->at, cell.dual[AT_A], end.friction, end.walls, &end.moved);
    AddForces(&cell, &end, sum);
  }
  if (rod->end == rod->last + 1) AddTip(&cell, sum);
  PetscCall(SpaceCellsClose(&cell));
  PetscFunctionReturn(0);
}

/* SpaceHold - moves the shifts of exact Coulomb friction; creep is the largest speed of what is
   held. (The clamped end is not held unless it slides: see frame_memory.c.) */
PetscErrorCode SpaceHold(Rod rod, const RodState *at, PetscReal seen, PetscReal *creep) {
  Space_ *self = (Space_ *)rod->data;
  PetscBool ends = (PetscBool)(self->end_weight > 0);
  PetscInt first = PetscMax(rod->first - 1, 0);
  RodForces sum;
  Cell cell;

  PetscFunctionBegin;
  *creep = 0;
  PetscCall(SpaceBears(rod, at, &sum));
  RodKeepBorne(rod, &sum);
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  for (PetscInt i = first; i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (i == first && ends && (i > 0 || cell.law->c != 0 || rod->scene->clamp == CLAMP_FREE))
      *creep = LargerOf(*creep, LoadHold(3, cell.load, &cell.a->at, seen, cell.dual[AT_A]));
    *creep = LargerOf(*creep, LoadHold(3, cell.load, &cell.mid->at, seen, cell.dual[AT_MID]));
    if (ends) *creep = LargerOf(*creep, LoadHold(3, cell.load, &cell.b->at, seen, cell.dual[AT_B]));
    if (cell.feet.n && self->foot_dual)
      *creep = LargerOf(*creep, FeetHold(&rod->scene->contact, &cell.foot_cell, &cell.feet, seen,
                                         FeetHeldAt(&cell, i)));
  }
  if (rod->end == rod->last + 1) {
    TipState tip = SpaceTipOf(cell.load, cell.b);
    *creep = LargerOf(*creep, TipHold(3, &rod->scene->tip, &tip, seen, SpaceTipDual(rod)));
  }
  PetscCall(SpaceCellsClose(&cell));
  SpaceCellsForget(self);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, creep, 1, MPIU_REAL, MPI_MAX, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* SpaceRemembers - how many reals a node: its duals and those of the middle of the cell on its
   right, as a whole, as the frame's (frame_memory.c); the latter's of the last node is the tip's
   own. Behind them those of the cell's feet. */
PetscInt SpaceRemembers(const Load *load) {
  return 2 * FrictionDualReals(RUBS) * load->duals3;
}

/* SpaceRemembered - value k of what is remembered at node i, in that order. */
PetscReal *SpaceRemembered(Rod rod, PetscInt i, PetscInt k) {
  const Space_ *self = (const Space_ *)rod->data;
  const PetscInt of_points = SpaceRemembers(&rod->scene->load), cell = i - rod->first + 1,
                 each = FrictionDualReals(RUBS);
  FrictionDual *dual = Duals(self, 2 * cell) + k / each;

  if (k >= of_points) dual = self->foot_dual + cell * WALL_SLOTS + (k - of_points) / each;
  return FrictionDualReal(RUBS, dual, k % each);
}

/* SpaceRecalled - it has been taken back: the points depend on it. */
PetscErrorCode SpaceRecalled(Rod rod) {
  PetscFunctionBegin;
  SpaceCellsForget((Space_ *)rod->data);
  PetscFunctionReturn(0);
}
