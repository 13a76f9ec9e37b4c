/* The cells of the frame model, as its files share them: what is known at their ends and in their
   middle in a state of the unknowns (frame.c has the equations). */
#ifndef TENDRIL_FRAME_CELLS_H
#define TENDRIL_FRAME_CELLS_H

#include "rod/frame.h"

/* The present state of a rod, and the cell that is looked at. The points outlive it: a Jacobian
   follows on the residual of the same state. */
typedef struct {
  Rod rod;
  PetscReal t;
  const Load *load;
  const PetscReal (*u)[FIELDS], (*u_t)[FIELDS], *s;
  Vec local, local_t;
  Law *law;                   /* of nodes a, mid, b of the cell */
  FrictionDual *dual[3];      /* likewise */
  const PetscReal (*push)[3]; /* what strands add to n' at all points of the rod; NULL: none */
  PetscReal h;
  PetscBool known;  /* the points are: the state is that of the latest walk */
  PetscBool fresh;  /* a Newton solve begins here */
  PetscBool counts; /* modes are counted in it */
  Point *a, *mid, *b;
  LoadSlope slope[3]; /* of the load at them; the end of a cell is where the next begins */
} Cell;

/* The dual of the first foot of the cell, which is remembered, stands behind those of the walls at
   its middle. */
static inline FrictionDual *HeldAt(const Cell *cell) {
  const Frame *frame = (const Frame *)cell->rod->data;
  return cell->rod->scene->contact.walls.rub ? cell->dual[AT_MID] + frame->duals - 1 : NULL;
}

/* The rates at node i, or their shifts: a place that is held at rest has none. */
static inline const PetscReal *Still(const Cell *cell, PetscInt i, const PetscReal *rates,
                                     PetscReal still[FIELDS]) {
  if (i < cell->rod->last) return rates;
  return TipStill(&cell->rod->scene->tip, cell->t, 2, FIELDS, rates, still);
}

/* The shifts at node i; where modes are counted friction holds a tip that is still. */
static inline const PetscReal *ShiftsAt(const Cell *cell, PetscInt i, const PetscReal *shift,
                                        PetscReal still[FIELDS]) {
  return cell->counts ? shift : Still(cell, i, shift, still);
}

/* (h g)^2/B in the middle of a cell, see FootLoad. */
static inline PetscReal KinkOf(const Cell *cell) {
  return PetscSqr(cell->h * cell->law[AT_MID].g) * cell->law[AT_MID].flex;
}

/* What the tip's conditions are about. */
static inline TipState TipOf(const Point *end) {
  return (TipState){
      .at = end->at, .theta = end->theta, .m = {0, 0, end->m}, .n = {end->n[0], end->n[1]}};
}

/* The tip's own dual stands where that of a cell behind the tip would. */
static inline FrictionDual *TipDual(Rod rod) {
  return FrameDuals((Frame *)rod->data, 2 * (rod->last - rod->first + 1) + 1);
}

/* Which unknown the f-th condition at the beginning is about. */
static inline int OfClamp(Rod rod, int f) {
  static const int of[][3] = {
      [CLAMP_HELD] = {X1, X2, TH}, [CLAMP_HINGED] = {X1, X2, M}, [CLAMP_FREE] = {N1, N2, M}};
  return of[rod->scene->clamp][f];
}

/* The slope of the load at a point. */
static inline void Linearise(Cell *cell, int k, const Point *p) {
  LoadLinearise(2, cell->load, &p->at, cell->fresh, cell->dual[k], &cell->slope[k]);
}

/* frame_cells.c */
void FrameCellsForget(Frame *frame);
PetscErrorCode FrameCellsOpen(Rod rod, const RodState *at, PetscBool from_tip, Cell *cell);
void FrameCellsGo(Cell *cell, PetscInt i, PetscBool from_tip);
PetscErrorCode FrameCellsClose(Cell *cell);
PetscInt FrameCellsFeet(const Cell *cell, PetscInt i, FootCell *of, Feet *feet);

/* ... from the clamp on. */
static inline void FrameCellsNext(Cell *cell, PetscInt i) {
  FrameCellsGo(cell, i, PETSC_FALSE);
}

/* frame_slope.c */
PetscBool FrameFeetSlopes(const Cell *cell, PetscInt i, const PetscReal shift[],
                          const PetscReal *shift_g, FootLoad load, FootSlope by);
void FrameTipBlock(const Cell *cell, const Point *end, const PetscReal shift[],
                   PetscReal by[TIP_ROWS][FIELDS]);
PetscErrorCode FrameJacobian(Rod rod, const RodState *at, Mat J);
PetscErrorCode FrameEliminate(Rod rod, const RodState *at, Elimination elimination);

/* frame_yield_slope.c */
PetscErrorCode FrameYieldJacobian(Rod rod, const RodState *at, Mat J);
PetscErrorCode FrameYieldEliminate(Rod rod, const RodState *at, Elimination elimination);

/* frame_memory.c */
PetscErrorCode FrameBears(Rod rod, const RodState *at, RodForces *sum);
PetscErrorCode FrameHold(Rod rod, const RodState *at, PetscReal seen, PetscReal *creep);
PetscInt FrameRemembers(const Frame *frame);
PetscReal *FrameRemembered(Rod rod, PetscInt i, PetscInt k);
PetscErrorCode FrameRecalled(Rod rod);

#endif
