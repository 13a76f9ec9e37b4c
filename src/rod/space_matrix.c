/* The derivatives of the equations of a rod in space: as a matrix, and eliminated cell by cell. */
#include "rod/space_slope.h"
#include "base/clones.h"
#include "rod/rules.h"
#include <string.h>

/* A cell's equations by the bend learned at one of its ends: that turns p' there, and so p in the
   middle by k times that. e: the end, a (0) or b (1); turn: SpaceMidTurns(). */
ALWAYS_INLINE void ColumnOf(const Cell *cell, int e, int bend, const Slope *mid,
                            PetscReal turn[RUBS][FIELDS], PetscReal column[FIELDS],
                            PetscReal by_bend[FIELDS]) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const PetscReal k = (e ? -1 : 1) * self->bow * cell->h, we = cell->h * self->end_weight,
                  wm = cell->h * self->mid_weight, wg = wm * cell->law[AT_MID].g;
  const Point *p = e ? cell->b : cell->a;
  PetscReal turned[4], dW[RUBS] = {0};

  SpaceLearnedTurn(&cell->law[2 * e], p, bend, turned);
  for (int r = 0; r < FIELDS; r++) column[r] = by_bend[r] = 0;
  for (int j = 0; j < 4; j++) {
    by_bend[P + j] = k * turned[j];
    column[P + j] = -we * turned[j];
  }
  for (int r = 0; r < (LoadPlaced(cell->load) ? FIELDS : N); r++)
    for (int j = 0; j < 4; j++) column[r] -= wm * mid->f[r][P + j] * by_bend[P + j];
  for (int c = 0; c < RUBS; c++)
    for (int j = 0; j < 4; j++) dW[c] += turn[c][P + j] * by_bend[P + j];
  if (cell->cubic) /* the spin's slope there has - g u_k d_k.d1_t */
    dW[SPIN] -= cell->load->arm * k * cell->law[2 * e].g * Dot3(p->at.axes[bend ? 1 : 2], p->d1_t);
  for (int i = 0; i < 3; i++)
    for (int c = 0; c < RUBS; c++) {
      column[N + i] -= wg * mid->load.W[i][c] * dW[c];
      if (cell->load->arm > 0 && !cell->split)
        column[M + i] -= wg * cell->mid->at.axes[0][i] * mid->load.W[SPIN][c] * dW[c];
    }
  if (cell->feet.n) {
    PetscReal by_p[4][4], by_w[4][3];
    SpaceKinkSlope(cell, by_p, by_w);
    for (int i = 0; i < 4; i++)
      for (int j = 0; j < 4; j++) column[P + i] -= by_p[i][j] * by_bend[P + j];
  }
}

/* SpaceLearnedCell - what the material of cell i has learned, for learned.h; slopes at its nodes
   where they are asked for. */
WIDE_VECTORS void SpaceLearnedCell(const Cell *cell, PetscInt i, const Slopes *slopes,
                                   PetscBool at_a, PetscBool at_b, LearnedCell *learned) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const PetscInt place = 2 * (i - cell->rod->first + 1);
  const PetscBool asked[3] = {at_a, PETSC_TRUE, at_b};
  const Point *at[3] = {cell->a, cell->mid, cell->b};
  const Slope *slope[3] = {&slopes->a, &slopes->mid, &slopes->b};
  PetscReal turn[RUBS][FIELDS];

  SpaceMidTurns(cell, &slopes->mid, turn);
  for (int k = 0; k < 3; k++)
    if (asked[k])
      SpaceLearnedSlope(cell->rod, place + k, at[k], (const PetscReal(*)[4])slope[k]->u_p,
                        (const PetscReal(*)[3])slope[k]->u_m, &learned->slope[k]);
  for (int e = 0; e < 2; e++) {
    const PetscReal k = (e ? -1 : 1) * self->bow * cell->h;
    for (int r = X; r < N; r++) { /* (of what is there nothing sees the force) */
      for (int j = 0; j < FIELDS; j++) learned->by_node[e][r][j] = k * slope[2 * e]->f[r][j];
      learned->by_node[e][r][r] += 0.5;
    }
    for (int b = 0; b < TROPISM_BENDS; b++)
      ColumnOf(cell, e, b, &slopes->mid, turn, learned->column[2 * e][b], learned->by_bend[e][b]);
  }
  for (int b = 0; b < TROPISM_BENDS; b++) {
    PetscReal turned[4];
    SpaceLearnedTurn(&cell->law[AT_MID], cell->mid, b, turned);
    for (int r = 0; r < FIELDS; r++) learned->column[AT_MID][b][r] = 0;
    for (int j = 0; j < 4; j++)
      learned->column[AT_MID][b][P + j] = -cell->h * self->mid_weight * turned[j];
  }
}

/* Condenses it. */
static void Condense(const Cell *cell, PetscInt i, PetscBool first, const PetscReal shift[],
                     const Slopes *slopes, PetscReal left[FIELDS][FIELDS],
                     PetscReal right[FIELDS][FIELDS]) {
  LearnedCell learned;

  SpaceLearnedCell(cell, i, slopes, first, PETSC_TRUE, &learned);
  if (first) LearnedNodeSlope(cell->rod, i, &learned.slope[AT_A], NULL, shift);
  LearnedNodeSlope(cell->rod, i + 1, &learned.slope[AT_B], NULL, shift);
  LearnedCondense(cell->rod, i, &learned, shift, left[0], right[0]);
  if (i + 1 == cell->rod->last) LearnedSignalSlope(cell->rod, &learned.slope[AT_B], shift);
}

/* Where what strands need to know of the cell behind an owned node is kept; NULL: nowhere. */
static StrandCell *KeptCell(Rod rod, PetscInt i) {
  const Space_ *self = (const Space_ *)rod->data;

  if (self->strands && i >= rod->first) return StrandRowsCell(rod, self->strands, i);
  return rod->pushed.cells ? rod->pushed.cells + i : NULL;
}

/* What strands need to know of the cell behind a node. */
static void KeepCell(const Cell *cell, const Slope *mid, StrandCell *kept) {
  const Space_ *self = (const Space_ *)cell->rod->data;

  *kept = (StrandCell){.end_weight = cell->h * self->end_weight,
                       .mid_weight = cell->h * self->mid_weight,
                       .bow = cell->h * self->bow,
                       .g = cell->law[AT_MID].g};
  memcpy(kept->q, cell->mid->at.axes[0], sizeof(kept->q));
  for (int i = 0; i < 4; i++) memcpy(kept->p_m[i], &mid->f[P + i][M], sizeof(kept->p_m[i]));
}

/* ... if its material learns its natural curvature. */
static void KeepLearnedCell(const Cell *cell, PetscInt i, const Slope *mid,
                            const LearnedSlope *slope) {
  const PetscReal clock = cell->rod->learned->clock[2 * (i - cell->rod->first + 1) + 1];
  StrandCell *kept = KeptCell(cell->rod, i);
  PetscReal by[FIELDS];

  if (!kept) return;
  KeepCell(cell, mid, kept);
  for (int b = 0; b < TROPISM_BENDS; b++) {
    LearnedByElastic(cell->rod, clock, slope, b, by);
    memcpy(kept->learned_m[b], by + M, sizeof(kept->learned_m[b]));
  }
}

/* SpaceJacobian(), of a rod whose material learns its natural curvature. */
static PetscErrorCode LearnedJacobian(Rod rod, const RodState *at, Mat J) {
  const Space_ *self = (const Space_ *)rod->data;
  const PetscInt begin = PetscMax(rod->first - 1, 0);
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS], of_begin[LEFT][FIELDS], by[RIGHT][FIELDS],
      *room;
  LearnedCell learned;
  Slopes slopes;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(8 * PetscSqr(rod->model->fields), &room));
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  if (self->strands) PetscCall(StrandRowsPattern(rod, self->strands, at->fresh, J));
  if (rod->first == 0) SpaceClampBlock(rod->scene, at->t, cell.u[0], of_begin);
  for (PetscInt i = begin; i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    SpaceCellBlocks(&cell, i, (PetscBool)(i == begin), at->shift, &slopes, left, right);
    SpaceLearnedCell(&cell, i, &slopes, PETSC_TRUE, (PetscBool)(i + 1 == rod->last), &learned);
    LearnedNodeSlope(rod, i, &learned.slope[AT_A], NULL, at->shift);
    LearnedRows(rod, i, &learned, at->shift);
    if (i >= rod->first) KeepLearnedCell(&cell, i, &slopes.mid, &learned.slope[AT_MID]);
    PetscCall(LearnedMatrix(rod, i, i == 0 ? of_begin[0] : NULL, &learned, left[0], right[0],
                            &learned.slope[AT_A], NULL, NULL, room, J));
  }
  if (rod->end > rod->last) {
    SpaceTipBlock(&cell, &slopes.b, at->shift, by);
    LearnedNodeSlope(rod, rod->last, &learned.slope[AT_B], NULL, at->shift);
    LearnedSignalSlope(rod, &learned.slope[AT_B], at->shift);
    PetscCall(LearnedMatrix(rod, rod->last, NULL, NULL, NULL, NULL, &learned.slope[AT_B], NULL,
                            by[0], room, J));
  }
  PetscCall(SpaceCellsClose(&cell));
  PetscCall(PetscFree(room));
  if (self->strands) PetscCall(StrandRowsJacobian(rod, self->strands, at, J));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* The rows of a node, by itself (columns FIELDS ...) and its neighbours. */
typedef PetscReal Rows[FIELDS][3 * FIELDS];

static void PutRows(Rows rows, int from, int to, PetscInt column, PetscReal part[FIELDS][FIELDS]) {
  for (int f = from; f < to; f++)
    for (int k = 0; k < FIELDS; k++) rows[f][column + k] = part[f][k];
}

/* SpaceJacobian - the derivatives of the equations, as a matrix. Collective. */
PetscErrorCode SpaceJacobian(Rod rod, const RodState *at, Mat J) {
  Space_ *self = (Space_ *)rod->data;
  PetscInt begin = PetscMax(rod->first - 1, 0);
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS], by[RIGHT][FIELDS];
  StrandCell *kept;
  Slopes slopes;
  Cell cell;
  Rows row;

  PetscFunctionBegin;
  if (rod->learned) {
    PetscCall(self->yields ? SpaceYieldJacobian(rod, at, J) : LearnedJacobian(rod, at, J));
    PetscFunctionReturn(0);
  }
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  if (self->strands) PetscCall(StrandRowsPattern(rod, self->strands, at->fresh, J));
  PetscCall(PetscMemzero(row, sizeof(row)));
  if (rod->first == 0) {
    SpaceClampBlock(rod->scene, at->t, cell.u[0], left);
    for (int f = 0; f < LEFT; f++) PetscCall(PetscArraycpy(&row[f][FIELDS], left[f], FIELDS));
  }
  for (PetscInt i = begin; i < rod->end; i++) {
    PetscInt cols[3] = {i - 1, i, i < rod->last ? i + 1 : -1}; /* -1: none, ignored */
    if (i < rod->last) {
      SpaceCellsNext(&cell, i);
      SpaceCellBlocks(&cell, i, (PetscBool)(i == begin), at->shift, &slopes, left, right);
      kept = KeptCell(rod, i);
      if (kept) KeepCell(&cell, &slopes.mid, kept);
      PutRows(row, LEFT, FIELDS, FIELDS, left);
      PutRows(row, LEFT, FIELDS, 2 * FIELDS, right);
    } else {
      SpaceTipBlock(&cell, &slopes.b, at->shift, by);
      for (int f = 0; f < RIGHT; f++)
        PetscCall(PetscArraycpy(&row[LEFT + f][FIELDS], by[f], FIELDS));
    }
    if (i >= rod->first)
      PetscCall(MatSetValuesBlocked(J, 1, &i, 3, cols, &row[0][0], INSERT_VALUES));
    PetscCall(PetscMemzero(row, sizeof(row)));
    if (i < rod->last) {
      PutRows(row, X, LEFT, 0, left);
      PutRows(row, X, LEFT, FIELDS, right);
    }
  }
  PetscCall(SpaceCellsClose(&cell));
  if (self->strands) PetscCall(StrandRowsJacobian(rod, self->strands, at, J));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* What a turn of e changes p by, dp = (0, e) p/2: twice that, of each part of e. */
static void TurnSlopes(const PetscReal p[4], PetscReal turn[3][4]) {
  const PetscReal all[3][4] = {
      {-p[1], p[0], -p[3], p[2]}, {-p[2], p[3], p[0], -p[1]}, {-p[3], -p[2], p[1], p[0]}};

  memcpy(turn, all, sizeof(all));
}

/* What the moment and the force at a node work along: the turn 2 vec(dp p*) / |p|^2, and x. */
static void Arms(const Point *point, WideArms *arms) {
  const PetscReal f = 2 / point->size;
  PetscReal turn[3][4];

  TurnSlopes(point->p, turn);
  memset(arms, 0, sizeof(*arms));
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 4; j++) arms->way[i][P + j] = f * turn[i][j];
    arms->way[3 + i][X + i] = 1;
    arms->moment[i] = point->m[i] / 2;
    arms->twist += point->m[i] / 2 * point->at.axes[0][i];
  }
}

/* A beginning that turns in a hinge, or is free, is springs so much softer than the rod for who
   counts modes or follows errors: what the first node gives way by its own moments and forces, a
   turn of e, dp = (0, e) p/2, and a place. */
static PetscErrorCode BeginSprings(Rod rod, PetscReal t, const Point *first,
                                   PetscReal gives[LEFT][RIGHT]) {
  const PetscBool is_free = (PetscBool)(rod->scene->clamp == CLAMP_FREE);
  PetscReal length, turn[3][4];

  PetscFunctionBegin;
  TurnSlopes(first->p, turn);
  PetscCall(GrowthLength(rod->scene->growth, t, &length, NULL));
  memset(gives, 0, LEFT * sizeof(*gives));
  for (int i = 0; i < 3; i++) {
    if (is_free) gives[X + i][3 + i] = rod_rule.spring_softer * PetscPowReal(length, 3);
    for (int j = 0; j < 3; j++) {
      PetscReal part = is_free ? first->at.axes[0][i] * first->at.axes[0][j] : 0;
      for (int k = 1; k < 3; k++) part += first->at.axes[k][i] * first->at.axes[k][j];
      for (int k = 0; k < 4; k++)
        gives[P + k][j] += rod_rule.spring_softer * length * turn[i][k] / 2 * part;
    }
  }
  PetscFunctionReturn(0);
}

/* SpaceEliminate - the same matrix, not assembled: each cell is eliminated as soon as it is known,
   or, on several ranks, where modes are counted in it, kept for the first of them. */
PetscErrorCode SpaceEliminate(Rod rod, const RodState *at, Elimination elimination) {
  const PetscBool keeps = EliminationKeeps(elimination),
                  gives_way = (PetscBool)(rod->scene->clamp != CLAMP_HELD);
  const PetscInt begin = PetscMax(rod->first - 1, 0);
  WideLine line = EliminationWide(elimination);
  PetscReal beside[2][FIELDS][FIELDS], (*left)[FIELDS] = beside[0], (*right)[FIELDS] = beside[1],
                                       by[RIGHT][FIELDS], gives[LEFT][RIGHT];
  const PetscBool ends = (PetscBool)(rod->end > rod->last);
  WideArms arms;
  Slopes slopes;
  Cell cell;

  PetscFunctionBegin;
  if (((const Space_ *)rod->data)->yields && !at->counts) {
    PetscCall(SpaceYieldEliminate(rod, at, elimination));
    PetscFunctionReturn(0);
  }
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  WideBegin(line);
  if (gives_way && rod->first == 0) PetscCall(BeginSprings(rod, at->t, cell.b, gives));
  if (gives_way && !keeps) WideSpring(line, (const PetscReal(*)[RIGHT])gives);
  for (PetscInt i = begin; i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (i >= rod->first) WideBlocks(line, &left, &right);
    SpaceCellBlocks(&cell, i, (PetscBool)(i == begin), at->shift, &slopes, left, right);
    if (rod->learned && !at->counts)
      Condense(&cell, i, (PetscBool)(i == begin), at->shift, &slopes, left, right);
    if (i < rod->first) continue;
    Arms(cell.a, &arms);
    WideArm(line, &arms);
    (keeps ? WideKeep : WideCell)(line);
  }
  if (ends) {
    Arms(cell.b, &arms);
    SpaceTipBlock(&cell, &slopes.b, at->shift, by);
  }
  if (ends && !keeps) {
    WideArm(line, &arms);
    WideEnd(line, (const PetscReal(*)[FIELDS])by);
  }
  PetscCall(SpaceCellsClose(&cell));
  if (rod->learned && !at->counts) LearnedCondensed(rod, elimination);
  if (keeps)
    PetscCall(EliminationGather(elimination, gives_way ? (const PetscReal(*)[RIGHT])gives : NULL,
                                &arms, ends ? (const PetscReal(*)[FIELDS])by : NULL));
  PetscFunctionReturn(0);
}
