/* The Jacobian of a rod in the plane whose growth feels the force along it, assembled or eliminated
   cell by cell; frame_yield.c has what a cell's equations depend on. */
#include "rod/frame_cells.h"
#include "rod/yields.h"
#include <string.h>

/* A cell's equations by its nodes, left and right, and by what is learned; slopes are new but that
   at a. */
static void YieldBlocks(Cell *cell, PetscInt i, PetscBool new_a, const PetscReal shift[],
                        PetscReal left[YIELD_FIELDS][YIELD_FIELDS],
                        PetscReal right[YIELD_FIELDS][YIELD_FIELDS], LearnedCell *learned) {
  const Frame *frame = (const Frame *)cell->rod->data;
  FootSlope by;
  FootLoad load;
  PetscReal still[YIELD_FIELDS] = {[FIELDS] = shift[FIELDS], shift[FIELDS + 1]};
  YieldCell of = {.place = 2 * (i - cell->rod->first + 1),
                  .tip = (PetscBool)(i + 1 == cell->rod->last),
                  .h = cell->h,
                  .bow = frame->bow * cell->h,
                  .shift = {shift, ShiftsAt(cell, i + 1, shift, still)},
                  .law = cell->law,
                  .at = {cell->a, cell->mid, cell->b}};

  for (int e = 0; e < 2; e++) of.turn[e] = cell->u_t[i + e][TH];
  if (!new_a)
    cell->slope[AT_A] = cell->slope[AT_B]; /* (each slope is brought up to the state once) */
  for (int k = new_a ? 0 : 1; k < 3; k++) Linearise(cell, k, of.at[k]);
  for (int k = 0; k < 3; k++) of.slope[k] = &cell->slope[k];
  if (frame->feet && FrameFeetSlopes(cell, i, shift, &shift[FIELDS + 1], load, by)) {
    of.load = load;
    of.feet = by;
  }
  FrameLearnedDrives(cell->rod, i, cell->h, cell->a, cell->mid, cell->b, new_a);
  FrameYieldCell(cell->rod, &of, left, right, learned);
  FrameLearnedSlopes(cell->rod, i, cell->h, cell->a, cell->mid, cell->b, PETSC_TRUE, PETSC_TRUE,
                     learned);
}

/* ... and its equations at the clamp, by the node there. */
static void YieldBegins(const Cell *cell, PetscReal begin[LINE_HALF + 1][YIELD_FIELDS]) {
  memset(begin, 0, (LINE_HALF + 1) * sizeof(*begin));
  for (int f = X1; f <= TH; f++) begin[f][OfClamp(cell->rod, f)] = 1;
  FrameYieldBegin(cell->rod, cell->a, begin[LINE_HALF]);
}

/* ... and those of the tip, by the last node. */
static void YieldEnds(const Cell *cell, const PetscReal shift[],
                      PetscReal end[LINE_HALF + 1][YIELD_FIELDS]) {
  PetscReal by[TIP_ROWS][FIELDS];

  FrameTipBlock(cell, cell->b, shift, by);
  memset(end, 0, (LINE_HALF + 1) * sizeof(*end));
  for (int r = 0; r < TIP_ROWS; r++) memcpy(end[r], by[r], sizeof(by[r]));
  YieldsEnd(cell->rod, shift, end[LINE_HALF]);
}

/* FrameJacobian(), of a rod whose growth feels force. */
PetscErrorCode FrameYieldJacobian(Rod rod, const RodState *at, Mat J) {
  const PetscInt begin = PetscMax(rod->first - 1, 0);
  PetscReal left[YIELD_FIELDS][YIELD_FIELDS], right[YIELD_FIELDS][YIELD_FIELDS],
      end[LINE_HALF + 1][YIELD_FIELDS], *room;
  LearnedCell learned;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(8 * PetscSqr(rod->model->fields), &room));
  PetscCall(FrameCellsOpen(rod, at, PETSC_FALSE, &cell));
  for (PetscInt i = begin; i < PetscMin(rod->end, rod->last); i++) {
    FrameCellsNext(&cell, i);
    if (i == 0) YieldBegins(&cell, end);
    YieldBlocks(&cell, i, (PetscBool)(i == begin), at->shift, left, right, &learned);
    LearnedNodeSlope(rod, i, &learned.slope[AT_A], learned.clock[AT_A][0], at->shift);
    LearnedRows(rod, i, &learned, at->shift);
    PetscCall(LearnedMatrix(rod, i, i == 0 ? end[0] : NULL, &learned, left[0], right[0],
                            &learned.slope[AT_A], learned.clock[AT_A][0], NULL, room, J));
  }
  if (rod->end > rod->last) {
    YieldEnds(&cell, at->shift, end);
    LearnedNodeSlope(rod, rod->last, &learned.slope[AT_B], learned.clock[AT_B][1], at->shift);
    LearnedSignalSlope(rod, &learned.slope[AT_B], at->shift);
    PetscCall(LearnedMatrix(rod, rod->last, NULL, NULL, NULL, NULL, &learned.slope[AT_B],
                            learned.clock[AT_B][1], end[0], room, J));
  }
  PetscCall(FrameCellsClose(&cell));
  PetscCall(PetscFree(room));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* FrameEliminate(), of a rod whose growth feels force, on one rank. */
PetscErrorCode FrameYieldEliminate(Rod rod, const RodState *at, Elimination elimination) {
  Halves line = EliminationHalves(elimination);
  PetscReal left[YIELD_FIELDS][YIELD_FIELDS], right[YIELD_FIELDS][YIELD_FIELDS],
      end[LINE_HALF + 1][YIELD_FIELDS], *a, *b;
  LearnedCell learned;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(FrameCellsOpen(rod, at, PETSC_FALSE, &cell));
  HalvesBegin(line);
  for (PetscInt i = 0; i < rod->last; i++) {
    FrameCellsNext(&cell, i);
    if (i == 0) {
      YieldBegins(&cell, end);
      LearnedTurned(rod, LINE_HALF + 1, end[0], HalvesFirst(line));
    }
    YieldBlocks(&cell, i, (PetscBool)(i == 0), at->shift, left, right, &learned);
    if (i == 0) LearnedNodeSlope(rod, i, &learned.slope[AT_A], learned.clock[AT_A][0], at->shift);
    LearnedNodeSlope(rod, i + 1, &learned.slope[AT_B], learned.clock[AT_B][1], at->shift);
    LearnedCondense(rod, i, &learned, at->shift, left[0], right[0]);
    HalvesBlocks(line, &a, &b);
    LearnedTurned(rod, YIELD_FIELDS, left[0], a);
    LearnedTurned(rod, YIELD_FIELDS, right[0], b);
    HalvesCell(line);
  }
  LearnedSignalSlope(rod, &learned.slope[AT_B], at->shift);
  YieldEnds(&cell, at->shift, end);
  LearnedTurned(rod, LINE_HALF + 1, end[0], left[0]);
  HalvesEnd(line, left[0]);
  PetscCall(FrameCellsClose(&cell));
  LearnedCondensed(rod, elimination);
  PetscFunctionReturn(0);
}
