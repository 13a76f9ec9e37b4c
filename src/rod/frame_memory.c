/* What a rod in the plane bears, and what is remembered of exact friction at its points. */
#include "rod/frame_cells.h"

/* Moves the shift at a point; creep is the largest speed so far. */
static void HoldPoint(const Load *load, const Place *at, PetscReal seen, FrictionDual *dual,
                      PetscReal *creep) {
  *creep = LargerOf(*creep, LoadHold(2, load, at, seen, dual));
}

/* ... at the feet of a cell. */
static void HoldFeet(Cell *cell, PetscInt i, PetscReal seen, PetscReal *creep) {
  const Contact *contact = &cell->rod->scene->contact;
  FootCell of;
  Feet feet;

  if (contact->walls.rub && FrameCellsFeet(cell, i, &of, &feet))
    *creep = LargerOf(*creep, FeetHold(contact, &of, &feet, seen, HeldAt(cell)));
}

/* Adds what the points of cell i and its feet bear; end: what its first point does, and then its
   last one. */
static void AddForces(const Cell *cell, PetscInt i, RodForces *end, RodForces *sum) {
  const Frame *frame = (const Frame *)cell->rod->data;
  const Point *at[3] = {NULL, cell->mid, cell->b};
  const PetscReal weight[3] = {frame->end_weight, frame->mid_weight, frame->end_weight};
  FootCell of;
  Feet feet;
  PetscInt n = frame->feet ? FrameCellsFeet(cell, i, &of, &feet) : 0;

  for (int k = 0; k < 3; k++) {
    if (at[k])
      LoadParts(2, cell->load, &at[k]->at, cell->dual[k], end->friction, end->walls, &end->moved);
    sum->moved += cell->h * weight[k] * cell->law[k].g * end->moved;
    for (int d = 0; d < 3; d++) {
      sum->friction[d] += cell->h * weight[k] * cell->law[k].g * end->friction[d];
      sum->walls[d] += cell->h * weight[k] * cell->law[k].g * end->walls[d];
    }
  }
  for (PetscInt k = 0; k < n; k++)
    for (int d = 0; d < 3; d++) {
      sum->walls[d] += feet.foot[k].force[d];
      sum->moved += feet.foot[k].force[d] * feet.touch[k].v[d];
    }
}

/* Adds what the tip bears. */
static void AddTip(const Cell *cell, RodForces *sum) {
  Rod rod = cell->rod;
  const Tip *tip = &rod->scene->tip;
  const TipState end = TipOf(cell->b);

  sum->moved += TipWalls(2, tip, &end, TipDual(rod), sum->tip);
  for (int d = 0; d < 3; d++) sum->walls[d] += sum->tip[d];
  for (int d = 0; d < 3 && cell->push && tip->type == TIP_FREE; d++)
    sum->tip[d] += cell->push[2 * rod->last + 1][d];
}

PetscErrorCode FrameBears(Rod rod, const RodState *at, RodForces *sum) {
  RodForces end = {.moved = 0};
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  PetscCall(FrameCellsOpen(rod, at, PETSC_FALSE, &cell));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    FrameCellsNext(&cell, i);
    if (i < rod->first) continue;
    if (i == rod->first)
      LoadParts(2, cell.load, &cell.a->at, cell.dual[AT_A], end.friction, end.walls, &end.moved);
    AddForces(&cell, i, &end, sum);
  }
  if (rod->end == rod->last + 1) AddTip(&cell, sum);
  PetscCall(FrameCellsClose(&cell));
  PetscFunctionReturn(0);
}

/* Moves the shifts of exact Coulomb friction; creep is the largest speed of what is held. */
PetscErrorCode FrameHold(Rod rod, const RodState *at, PetscReal seen, PetscReal *creep) {
  Frame *frame = (Frame *)rod->data;
  PetscBool ends = (PetscBool)(frame->end_weight > 0);
  PetscInt first = PetscMax(rod->first - 1, 0);
  RodForces sum;
  Cell cell;

  PetscFunctionBegin;
  *creep = 0;
  PetscCall(FrameBears(rod, at, &sum));
  RodKeepBorne(rod, &sum);
  PetscCall(FrameCellsOpen(rod, at, PETSC_FALSE, &cell));
  for (PetscInt i = first; i < PetscMin(rod->end, rod->last); i++) {
    FrameCellsNext(&cell, i);
    /* the clamped end does not move unless it slides: a shift there would hold nothing, and
       round-off adds up in it to a force on a rod whose x2 may be 1e-25 */
    if (i == first && ends && (i > 0 || cell.law->c != 0 || rod->scene->clamp == CLAMP_FREE))
      HoldPoint(cell.load, &cell.a->at, seen, cell.dual[AT_A], creep);
    HoldPoint(cell.load, &cell.mid->at, seen, cell.dual[AT_MID], creep);
    if (ends) HoldPoint(cell.load, &cell.b->at, seen, cell.dual[AT_B], creep);
    if (frame->feet) HoldFeet(&cell, i, seen, creep);
  }
  if (rod->end == rod->last + 1) {
    const TipState end = TipOf(cell.b);
    *creep = LargerOf(*creep, TipHold(2, &rod->scene->tip, &end, seen, TipDual(rod)));
  }
  PetscCall(FrameCellsClose(&cell));
  FrameCellsForget(frame);
  if (frame->strands) PetscCall(StrandRowsHold(frame->strands, seen, creep));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, creep, 1, MPIU_REAL, MPI_MAX, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* The duals of each node and of the middle of the cell on its right, as a whole: a point that
   begins to press while Newton's method iterates goes on from where it pressed last. */
enum { RUBBING = 2 };

/* So many reals of a node, what strands have besides left out. */
PetscInt FrameRemembers(const Frame *frame) {
  return 2 * frame->duals * FrictionDualReals(RUBBING);
}

/* Value k of what is remembered at node i, in this order; NULL: nothing. */
PetscReal *FrameRemembered(Rod rod, PetscInt i, PetscInt k) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt each = FrictionDualReals(RUBBING), own = FrameRemembers(frame);

  if (k >= own) return StrandRowsRemembered(frame->strands, i, k - own);
  return FrictionDualReal(RUBBING, FrameDuals(frame, 2 * (i - rod->first + 1)) + k / each,
                          k % each);
}

PetscErrorCode FrameRecalled(Rod rod) {
  Frame *frame = (Frame *)rod->data;

  PetscFunctionBegin;
  FrameCellsForget(frame);
  if (frame->strands) PetscCall(StrandRowsRecalled(rod, frame->strands));
  PetscFunctionReturn(0);
}
