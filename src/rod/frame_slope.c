/* The Jacobian of the frame model, assembled or eliminated cell by cell (frame.c has the
   equations). */
#include "rod/frame_cells.h"
#include "curve/cell.h"
#include "rod/rules.h"
#include <string.h>

/* Adds to the derivative of n_d' by x1, x2, theta at a node what comes of a load that varies in
   space and with direction. */
static void AddVaried(const Load *load, PetscReal g, const LoadSlope *slope, int d,
                      PetscReal fn[3]) {
  if (load->turns) fn[TH] += g * slope->theta[d];
  if (load->moves) Add2(Times2(g, From2(slope->x[d])), fn + X1);
}

/*
  J[6][6], the derivative of the cell's equations by the unknowns of one of its nodes.

  sign  -1 for node a (left), +1 for node b
  shift of each field: U_t = shift U + ...
  p     the node's point, mid the cell's
*/
static void CellJacobian(const Frame *frame, const Load *load, PetscReal h, PetscReal sign,
                         const PetscReal shift[], const Law *law, const Law *mid_law,
                         PetscReal theta_t, const Point *p, const LoadSlope *slope,
                         const Point *mid, const LoadSlope *mid_slope,
                         PetscReal J[FIELDS][FIELDS]) {
  const PetscReal g = law->g, gm = mid_law->g, k = -sign * frame->bow * h,
                  we = h * frame->end_weight, wm = h * frame->mid_weight * gm;
  const Vector2 q = From2(p->at.axes[0]), qm = From2(mid->at.axes[0]), perp = Left2(q),
                perp_m = Left2(qm);
  const PetscReal turn = g * Dot2(q, From2(p->n)); /* d(m')/d(theta) */
  const PetscReal turn_m = wm * Dot2(qm, From2(mid->n));
  const PetscReal by_m = k * g * law->flex, flex_m = wm * mid_law->flex; /* d(theta_mid)/dm */
  PetscReal fn[X2 + 1][3]; /* d(n') at the node by x1, x2, theta; k times that is d(n_mid) */

  for (int d = X1; d <= X2; d++) {
    const Vector2 drag = Times2(g, From2(slope->W[d]));
    const PetscReal across = d == X1 ? perp.x : perp.y, across_m = d == X1 ? perp_m.x : perp_m.y;
    fn[d][X1] = shift[X1] * drag.x;
    fn[d][X2] = shift[X2] * drag.y;
    fn[d][TH] = law->c * Dot2(drag, perp);
    if (!load->plain) AddVaried(load, g, slope, d, fn[d]);
    J[d][X1] = d == X1 ? sign : 0;
    J[d][X2] = d == X2 ? sign : 0;
    J[d][TH] = -we * g * across - wm * across_m / 2;
    J[d][M] = -wm * across_m * by_m;
    J[d][N1] = J[d][N2] = 0;
  }
  J[TH][X1] = J[TH][X2] = 0;
  J[TH][TH] = sign - flex_m * k * turn; /* of m_mid */
  J[TH][M] = -we * g * law->flex - flex_m / 2;
  J[TH][N1] = -flex_m * k * g * q.y;
  J[TH][N2] = flex_m * k * g * q.x;
  for (int f = X1; f <= TH; f++) J[M][f] = -wm * k * (qm.y * fn[X1][f] - qm.x * fn[X2][f]);
  J[M][TH] -= we * turn + turn_m / 2;
  J[M][M] = sign - turn_m * by_m;
  J[M][N1] = -we * g * q.y - wm * qm.y / 2;
  J[M][N2] = we * g * q.x + wm * qm.x / 2;
  for (int d = X1; d <= X2; d++) {
    const Vector2 drag = Times2(wm, From2(mid_slope->W[d]));
    const PetscReal along = mid_law->c * Dot2(drag, perp_m); /* by theta */
    const PetscReal by_q = Dot2(drag, q), by_perp = Dot2(drag, perp);
    PetscReal *row = J[N1 + d];
    row[X1] = -we * fn[d][X1] - shift[X1] * drag.x / 2;
    row[X2] = -we * fn[d][X2] - shift[X2] * drag.y / 2;
    row[TH] =
        -we * fn[d][TH] - along / 2 -
        k * (law->g_t * by_perp - g * theta_t * by_q + shift[TH] * g * by_perp); /* of v_mid */
    row[M] = -along * by_m;
    row[N1] = d == X1 ? sign : 0;
    row[N2] = d == X2 ? sign : 0;
    if (load->turns) {
      row[TH] -= wm * mid_slope->theta[d] / 2;
      row[M] -= wm * mid_slope->theta[d] * by_m;
    }
    if (load->moves) { /* by x_mid */
      const PetscReal *by_x = mid_slope->x[d];
      row[X1] -= wm * by_x[X1] / 2;
      row[TH] -= wm * by_x[X1] * k * g * perp.x;
      row[X2] -= wm * by_x[X2] / 2;
      row[TH] -= wm * by_x[X2] * k * g * perp.y;
    }
  }
}

/* The rows of a node, by itself (columns FIELDS ...) and its neighbours. */
typedef PetscReal Rows[FIELDS][3 * FIELDS];

/* Copies rows from ... from + 2 of a cell's derivative by one of its nodes. */
static void PutRows(Rows rows, int from, PetscInt column, PetscReal part[FIELDS][FIELDS]) {
  for (int f = from; f < from + 3; f++)
    for (int k = 0; k < FIELDS; k++) rows[f][column + k] = part[f][k];
}

/* FrameFeetSlopes - what the feet of a cell do, and its slopes; no: there are none. shift_g: of the
   stretch, where it is an unknown; NULL: it is not. */
PetscBool FrameFeetSlopes(const Cell *cell, PetscInt i, const PetscReal shift[],
                          const PetscReal *shift_g, FootLoad load, FootSlope by) {
  FootEnd end[2];
  FootCell of;
  Feet feet;

  if (!FrameCellsFeet(cell, i, &of, &feet)) return PETSC_FALSE;
  of.stretches = (PetscBool)(shift_g != NULL);
  (void)memset(by, 0, sizeof(FootSlope));
  (void)memset(load, 0, sizeof(FootLoad));
  (void)memset(end, 0, sizeof(end));
  FeetHandOut(&of, &feet, load);
  for (int e = 0; e < 2; e++) {
    const Law *law = &cell->law[2 * e];
    const Vector2 q = From2((e ? cell->b : cell->a)->at.axes[0]);
    const PetscReal theta_t = cell->u_t[i + e][TH];
    Put2(From2(shift + X1), end[e].curve.shift);
    CurveEndInPlane(q, theta_t, law->g, law->g_t, shift[TH], &end[e].curve);
    if (shift_g) Put2(Along2(Times2(*shift_g, q), theta_t, Left2(q)), end[e].stretch_t);
  }
  FeetLinearise(&cell->rod->scene->contact, &of, end, cell->fresh, HeldAt(cell), &feet, by);
  return PETSC_TRUE;
}

/* Adds to a cell's equations by its nodes what comes of its feet. */
static void AddFeetSlope(Cell *cell, PetscInt i, const PetscReal shift[],
                         PetscReal left[FIELDS][FIELDS], PetscReal right[FIELDS][FIELDS]) {
  const Frame *frame = (const Frame *)cell->rod->data;
  const Vector2 q = From2(cell->mid->at.axes[0]);
  const PetscReal h = cell->h, wm = h * frame->mid_weight * cell->law[AT_MID].g * frame->bow * h;
  const PetscReal kink = KinkOf(cell);
  PetscReal turn; /* of the kink by the angle in the middle */
  FootSlope by;
  FootLoad load;

  if (!FrameFeetSlopes(cell, i, shift, NULL, load, by)) return;
  turn = -kink * Dot2(q, From2(load[FOOT_KINK]));
  left[TH][TH] -= turn / 2;
  right[TH][TH] -= turn / 2;
  left[TH][M] -= turn * frame->bow * h * cell->law[AT_A].g * cell->law[AT_A].flex;
  right[TH][M] += turn * frame->bow * h * cell->law[AT_B].g * cell->law[AT_B].flex;
  for (int u = 0; u < 2 * FOOT_PLANE; u++) {
    PetscReal(*J)[FIELDS] = u < FOOT_PLANE ? left : right;
    const Vector2 a = Column2(by[AT_A][0], FOOT_UNKNOWNS, u),
                  mid = Column2(by[AT_MID][0], FOOT_UNKNOWNS, u),
                  b = Column2(by[AT_B][0], FOOT_UNKNOWNS, u),
                  turned = Column2(by[FOOT_KINK][0], FOOT_UNKNOWNS, u), bow = Minus2(a, b),
                  sum = Along2(Times2(frame->end_weight, Plus2(a, b)), frame->mid_weight, mid);
    J[TH][u % FOOT_PLANE] -= kink * Cross2(q, turned);
    J[M][u % FOOT_PLANE] -= wm * Cross2(bow, q); /* of n in the middle */
    J[N1][u % FOOT_PLANE] -= h * sum.x;
    J[N2][u % FOOT_PLANE] -= h * sum.y;
  }
}

/* A cell's equations by its nodes, left and right; the slopes at its middle and at those of its
   ends that are new on this walk are brought up to the present state first. */
static void CellBlocks(Cell *cell, PetscInt i, PetscBool new_a, PetscBool new_b,
                       const PetscReal shift[], PetscReal left[FIELDS][FIELDS],
                       PetscReal right[FIELDS][FIELDS]) {
  const Frame *frame = (const Frame *)cell->rod->data;
  PetscReal still[FIELDS];

  if (!new_a) cell->slope[AT_A] = cell->slope[AT_B];
  if (!new_b) cell->slope[AT_B] = cell->slope[AT_A];
  if (new_a) Linearise(cell, 0, cell->a);
  if (new_b) Linearise(cell, 2, cell->b);
  Linearise(cell, 1, cell->mid);
  CellJacobian(frame, cell->load, cell->h, -1, shift, cell->law, cell->law + AT_MID,
               cell->u_t[i][TH], cell->a, &cell->slope[AT_A], cell->mid, &cell->slope[AT_MID],
               left);
  CellJacobian(frame, cell->load, cell->h, 1, ShiftsAt(cell, i + 1, shift, still), cell->law + AT_B,
               cell->law + AT_MID, cell->u_t[i + 1][TH], cell->b, &cell->slope[AT_B], cell->mid,
               &cell->slope[AT_MID], right);
  if (frame->feet) AddFeetSlope(cell, i, shift, left, right);
}

/* The tip's equations by its own unknowns. */
void FrameTipBlock(const Cell *cell, const Point *end, const PetscReal shift[],
                   PetscReal by[TIP_ROWS][FIELDS]) {
  Rod rod = cell->rod;
  TipState tip = TipOf(end);
  PetscReal still[FIELDS];

  TipJacobian(&rod->scene->tip, &tip, ShiftsAt(cell, rod->last, shift, still), cell->fresh,
              TipDual(rod), by);
}

/* What strands need to know of the cell that is looked at. */
static void KeepCell(const Cell *cell, StrandCell *kept) {
  const Frame *frame = (const Frame *)cell->rod->data;

  *kept = (StrandCell){.end_weight = cell->h * frame->end_weight,
                       .mid_weight = cell->h * frame->mid_weight,
                       .bow = cell->h * frame->bow,
                       .g = cell->law[AT_MID].g,
                       .q = {cell->mid->at.axes[0][0], cell->mid->at.axes[0][1]}};
}

/* FrameJacobian(), of a rod whose material learns its natural curvature. */
static PetscErrorCode LearnedJacobian(Rod rod, const RodState *at, Mat J) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt begin = PetscMax(rod->first - 1, 0);
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS], of_begin[LINE_HALF][FIELDS] = {{0}},
                                                         by[TIP_ROWS][FIELDS], *room;
  LearnedCell learned;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(8 * PetscSqr(rod->model->fields), &room));
  PetscCall(FrameCellsOpen(rod, at, PETSC_FALSE, &cell));
  if (frame->strands) PetscCall(StrandRowsPattern(rod, frame->strands, at->fresh, J));
  for (int f = X1; f <= TH; f++) of_begin[f][OfClamp(rod, f)] = 1;
  for (PetscInt i = begin; i < PetscMin(rod->end, rod->last); i++) {
    FrameCellsNext(&cell, i);
    CellBlocks(&cell, i, (PetscBool)(i == begin), PETSC_TRUE, at->shift, left, right);
    FrameLearnedCell(rod, i, cell.h, cell.a, cell.mid, cell.b, PETSC_TRUE,
                     (PetscBool)(i + 1 == rod->last), left, right, &learned);
    LearnedNodeSlope(rod, i, &learned.slope[AT_A], NULL, at->shift);
    LearnedRows(rod, i, &learned, at->shift);
    if (frame->strands && i >= rod->first) KeepCell(&cell, StrandRowsCell(rod, frame->strands, i));
    PetscCall(LearnedMatrix(rod, i, i == 0 ? of_begin[0] : NULL, &learned, left[0], right[0],
                            &learned.slope[AT_A], NULL, NULL, room, J));
  }
  if (rod->end > rod->last) {
    FrameTipBlock(&cell, cell.b, at->shift, by);
    LearnedNodeSlope(rod, rod->last, &learned.slope[AT_B], NULL, at->shift);
    LearnedSignalSlope(rod, &learned.slope[AT_B], at->shift);
    PetscCall(LearnedMatrix(rod, rod->last, NULL, NULL, NULL, NULL, &learned.slope[AT_B], NULL,
                            by[0], room, J));
  }
  PetscCall(FrameCellsClose(&cell));
  PetscCall(PetscFree(room));
  if (frame->strands) PetscCall(StrandRowsJacobian(rod, frame->strands, at, J));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

PetscErrorCode FrameJacobian(Rod rod, const RodState *at, Mat J) {
  Frame *frame = (Frame *)rod->data;
  PetscInt first = rod->first, end = rod->end, begin = PetscMax(first - 1, 0);
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS];
  Cell cell;
  Rows row;

  PetscFunctionBegin;
  if (rod->learned) {
    PetscCall(frame->yields ? FrameYieldJacobian(rod, at, J) : LearnedJacobian(rod, at, J));
    PetscFunctionReturn(0);
  }
  PetscCall(FrameCellsOpen(rod, at, PETSC_FALSE, &cell));
  if (frame->strands) PetscCall(StrandRowsPattern(rod, frame->strands, at->fresh, J));
  PetscCall(PetscMemzero(row, sizeof(row)));
  if (first == 0)
    for (int f = X1; f <= TH; f++) row[f][FIELDS + OfClamp(rod, f)] = 1;
  for (PetscInt i = begin; i < end; i++) {
    PetscInt cols[3] = {i - 1, i, i < rod->last ? i + 1 : -1}; /* -1: none, ignored */
    if (i < rod->last) {
      FrameCellsNext(&cell, i);
      CellBlocks(&cell, i, (PetscBool)(i == begin), PETSC_TRUE, at->shift, left, right);
      if (frame->strands && i >= first) KeepCell(&cell, StrandRowsCell(rod, frame->strands, i));
      PutRows(row, M, FIELDS, left);
      PutRows(row, M, 2 * FIELDS, right);
    } else {
      PetscReal by[TIP_ROWS][FIELDS];
      FrameTipBlock(&cell, cell.b, at->shift, by);
      for (int f = 0; f < TIP_ROWS; f++)
        PetscCall(PetscArraycpy(&row[M + f][FIELDS], by[f], FIELDS));
    }
    if (i >= first) PetscCall(MatSetValuesBlocked(J, 1, &i, 3, cols, &row[0][0], INSERT_VALUES));
    PetscCall(PetscMemzero(row, sizeof(row)));
    if (i < rod->last) {
      PutRows(row, X1, 0, left);
      PutRows(row, X1, FIELDS, right);
    }
  }
  PetscCall(FrameCellsClose(&cell));
  if (frame->strands) PetscCall(StrandRowsJacobian(rod, frame->strands, at, J));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* The tip's equations by its own unknowns, with springs for what holds it. */
static PetscErrorCode TipSprings(Rod rod, PetscReal t, PetscReal by[TIP_ROWS][FIELDS]) {
  const Tip *tip = &rod->scene->tip;
  PetscReal length;

  PetscFunctionBegin;
  PetscCall(GrowthLength(rod->scene->growth, t, &length, NULL));
  if (TipPoints(tip)) {
    by[0][M] = 1;
    by[0][TH] = rod_rule.spring_stiffer / length;
  }
  for (int d = 0; d < 2; d++)
    if (TipHolds(tip, d)) {
      by[1 + d][N1 + d] = 1;
      by[1 + d][X1 + d] = rod_rule.spring_stiffer / (length * length * length);
    }
  PetscFunctionReturn(0);
}

/* A beginning that turns, or is free, as springs. */
static PetscErrorCode BeginSprings(Rod rod, PetscReal t, Elimination elimination) {
  const ClampType clamp = rod->scene->clamp;
  PetscReal length;

  PetscFunctionBegin;
  if (clamp == CLAMP_HELD || rod->first > 0) PetscFunctionReturn(0);
  PetscCall(GrowthLength(rod->scene->growth, t, &length, NULL));
  EliminationSpring(elimination, rod_rule.spring_softer * length,
                    clamp == CLAMP_FREE ? rod_rule.spring_softer * PetscPowReal(length, 3) : 0);
  PetscFunctionReturn(0);
}

/* Condenses what the material of a cell has learned. new_a, new_b: as for CellBlocks(). */
static void Condense(Cell *cell, PetscInt i, PetscBool new_a, PetscBool new_b,
                     const PetscReal shift[], PetscReal left[FIELDS][FIELDS],
                     PetscReal right[FIELDS][FIELDS]) {
  Rod rod = cell->rod;
  LearnedCell learned;

  FrameLearnedCell(rod, i, cell->h, cell->a, cell->mid, cell->b, new_a, new_b, left, right,
                   &learned);
  if (new_a) LearnedNodeSlope(rod, i, &learned.slope[AT_A], NULL, shift);
  if (new_b) LearnedNodeSlope(rod, i + 1, &learned.slope[AT_B], NULL, shift);
  LearnedCondense(rod, i, &learned, shift, left[0], right[0]);
  if (i + 1 == rod->last) LearnedSignalSlope(rod, &learned.slope[AT_B], shift);
}

/* The same matrix, not assembled: each cell is eliminated as soon as it is known. The last of
   several ranks goes from the tip towards the clamp. */
PetscErrorCode FrameEliminate(Rod rod, const RodState *at, Elimination elimination) {
  PetscBool from_tip = EliminationFromTip(elimination);
  PetscInt begin = PetscMax(rod->first - 1, 0), n = PetscMin(rod->end, rod->last) - begin;
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS], by[TIP_ROWS][FIELDS];
  Cell cell;

  PetscFunctionBegin;
  if (((const Frame *)rod->data)->yields && !at->counts) {
    PetscCall(FrameYieldEliminate(rod, at, elimination));
    PetscFunctionReturn(0);
  }
  PetscCall(FrameCellsOpen(rod, at, from_tip, &cell));
  if (from_tip) FrameTipBlock(&cell, cell.a, at->shift, by);
  if (from_tip && at->counts) PetscCall(TipSprings(rod, at->t, by));
  EliminationBegin(elimination, (const PetscReal(*)[FIELDS])by);
  if (!from_tip) PetscCall(BeginSprings(rod, at->t, elimination));
  for (PetscInt k = 0; k < n; k++) {
    PetscInt i = from_tip ? begin + n - 1 - k : begin + k;
    FrameCellsGo(&cell, i, from_tip);
    CellBlocks(&cell, i, (PetscBool)(from_tip || !k), (PetscBool)(!from_tip || !k), at->shift, left,
               right);
    if (rod->learned && !at->counts)
      Condense(&cell, i, (PetscBool)(from_tip || !k), (PetscBool)(!from_tip || !k), at->shift, left,
               right);
    if (i >= rod->first)
      EliminationCell(elimination, (const PetscReal(*)[FIELDS])left,
                      (const PetscReal(*)[FIELDS])right);
  }
  if (rod->end > rod->last && !from_tip) FrameTipBlock(&cell, cell.b, at->shift, by);
  PetscCall(FrameCellsClose(&cell));
  if (rod->learned && !at->counts) LearnedCondensed(rod, elimination);
  PetscCall(EliminationEnd(elimination, (const PetscReal(*)[FIELDS])by));
  PetscFunctionReturn(0);
}
