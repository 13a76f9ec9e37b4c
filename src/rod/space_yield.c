/* A rod in space whose growth feels the force along it: its equations (yields.h), and their
   derivatives, assembled or eliminated cell by cell. What a cell's equations depend on by stretch,
   its rate and slide, which are unknowns here, comes on top of what space_slope.c has of the
   others. */
#include "base/vectors.h"
#include "rod/space_slope.h"
#include "rod/yields.h"
#include <string.h>

static PetscReal AlongAt(const PetscReal u[]) {
  PetscReal d[3][3];

  Directors(u + P, QuaternionSize(u + P), d);
  return Dot3(d[0], u + N);
}

static PetscReal AlongOf(const Point *p) {
  return Dot3(p->at.axes[0], p->n);
}

/* SpaceYieldSee - tells the law of growth what it is in a state. Collective. */
PetscErrorCode SpaceYieldSee(Rod rod, PetscReal t, Vec U) {
  PetscFunctionBegin;
  PetscCall(YieldsSee(rod, t, U, AlongAt));
  PetscFunctionReturn(0);
}

/* SpaceYieldLaws - those of nodes and middles are as the unknowns there have them. */
void SpaceYieldLaws(Rod rod) {
  const Space_ *self = (const Space_ *)rod->data;
  const PetscInt from = 2 * (PetscMax(rod->first - 1, 0) - rod->first + 1),
                 to = 2 * (PetscMin(rod->end, rod->last) - rod->first + 1);

  YieldsLaws(rod, self->bow, AlongAt);
  for (PetscInt k = from; k <= to; k++) {
    const LearnedStretch *stretch = &rod->learned->stretch[k];
    self->law[k].g = stretch->g;
    self->law[k].g_t = stretch->g_t;
    self->law[k].c = stretch->c;
  }
}

/* V' at a point. */
static PetscReal SlopeAt(const Rod rod, const Law *law, const Point *p) {
  return YieldsSlope(rod, law->s, law->g, AlongOf(p));
}

/* SpaceYieldResidual - of the cell behind node i. */
void SpaceYieldResidual(const Cell *cell, PetscInt i) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const Law *law = cell->law;
  const PetscReal ends = SlopeAt(cell->rod, law, cell->a) + SlopeAt(cell->rod, law + AT_B, cell->b);

  YieldsResidual(cell->rod, i,
                 cell->h * (self->end_weight * ends +
                            self->mid_weight * SlopeAt(cell->rod, law + AT_MID, cell->mid)));
}

/* SpaceYieldEnds - of what is at the clamp, or the tip: p the point there. */
void SpaceYieldEnds(Rod rod, PetscInt i, const Point *p) {
  YieldsEnds(rod, i, AlongOf(p));
}

/* ---- derivatives ---- */

/* A cell between nodes a and b, and what its equations go by. */
typedef struct {
  const Cell *cell;
  const PetscReal *shift;
  const Law *law;
  const Point *at[3];
  const Slope *slope[3];
  PetscInt place;               /* of a */
  PetscBool tip;                /* b is the tip */
  PetscReal k[2], we, wm;       /* what slopes at a and b are in the middle; weights, times h */
  PetscReal turn[RUBS][FIELDS]; /* SpaceMidTurns() */
  PetscReal along[3][FIELDS];   /* how V' at all three goes with the unknowns there */
  PetscReal by_g[3];            /* ... and with the stretch */
} YieldCell;

/* What changes at a place: stretch, its rate, and slide. */
typedef struct {
  PetscReal g, g_t, c;
} Change;

/* How the equations of a cell change, and the unknowns in its middle. */
typedef struct {
  PetscReal equations[FIELDS], mid[FIELDS];
} Changed;

/* The sum of so many products. */
static PetscReal Times(PetscInt n, const PetscReal a[], const PetscReal b[]) {
  PetscReal sum = 0;

  for (PetscInt k = 0; k < n; k++) sum += a[k] * b[k];
  return sum;
}

/* How V' at a point changes with its unknowns, and with the stretch there. */
static void VaryV(const Rod rod, const Law *law, const Point *p, const Slope *slope,
                  PetscReal by[FIELDS], PetscReal *by_g) {
  PetscReal by_length, by_force;
  const PetscReal w = GrowthYieldWeight(rod->scene->growth, law->s, law->g, &by_length),
                  y = YieldsPart(rod, AlongOf(p), &by_force);

  memset(by, 0, FIELDS * sizeof(*by));
  for (int j = 0; j < 4; j++) by[P + j] = w * by_force * ColumnDot3(slope->d1[0], 4, j, p->n);
  for (int j = 0; j < 3; j++) by[N + j] = w * by_force * p->at.axes[0][j];
  *by_g = by_length * y;
}

/* Adds what a change of W at a point does to f there. */
static void AddRubbed(const Load *load, const Law *law, const Point *p, const Slope *slope,
                      const PetscReal dW[RUBS], PetscReal df[FIELDS]) {
  const int rubs = load->arm > 0 ? RUBS : SPIN;

  for (int i = 0; i < 3; i++) {
    df[N + i] += law->g * Times(rubs, slope->load.W[i], dW);
    if (load->arm > 0)
      df[M + i] += law->g * p->at.axes[0][i] * Times(rubs, slope->load.W[SPIN], dW);
  }
}

/* Adds what slides past a label faster by c. */
static void AddSlide(const Load *load, const Point *p, PetscReal c, PetscReal dW[RUBS]) {
  for (int i = 0; i < 3; i++) dW[i] += c * p->at.axes[0][i];
  dW[SPIN] += load->arm * c * p->u[0];
}

/* How f at end e changes, and W in the middle by the slopes there. */
static void VaryEnd(const YieldCell *of, int e, const Change *d, PetscReal df[FIELDS],
                    PetscReal dW[RUBS]) {
  const Load *load = of->cell->load;
  const Law *law = &of->law[2 * e];
  const Point *p = of->at[2 * e];
  PetscReal slides[RUBS] = {0};

  for (int f = 0; f < FIELDS; f++) df[f] = d->g / law->g * p->f[f];
  AddSlide(load, p, d->c, slides);
  AddRubbed(load, law, p, of->slope[2 * e], slides, df);
  for (int i = 0; i < 3; i++) dW[i] += of->k[e] * (d->g_t * p->at.axes[0][i] + d->g * p->d1_t[i]);
  if (of->cell->cubic)
    dW[SPIN] += of->k[e] * load->arm *
                (d->g_t * p->u[0] + d->g / law->g * (NodeSpinSlope(law, p) - law->g_t * p->u[0]));
}

/* All of it: of end e, and in the middle. */
static void Vary(const YieldCell *of, int e, const Change *end, const Change *mid, Changed *to) {
  const Cell *cell = of->cell;
  const Law *law = &of->law[AT_MID];
  const Point *p = of->at[AT_MID];
  const Slope *slope = of->slope[AT_MID];
  PetscReal df[FIELDS], dW[RUBS] = {0}, df_mid[FIELDS];

  VaryEnd(of, e, end, df, dW);
  AddSlide(cell->load, p, mid->c, dW);
  for (int f = 0; f < FIELDS; f++) to->mid[f] = of->k[e] * df[f];
  for (int c = 0; c < RUBS; c++) dW[c] += Times(N - P, of->turn[c] + P, to->mid + P);
  for (int f = 0; f < FIELDS; f++)
    df_mid[f] = mid->g / law->g * p->f[f] + Times(FIELDS, slope->f[f], to->mid);
  for (int d = 0; d < FOOT_LOAD / 2 && cell->feet.n; d++) { /* (which are no part of g F) */
    df_mid[N + d] -= mid->g / law->g * cell->foot_load[AT_MID][d];
    df_mid[M + d] -= mid->g / law->g * cell->foot_load[AT_MID][3 + d];
  }
  AddRubbed(cell->load, law, p, slope, dW, df_mid);
  for (int f = 0; f < FIELDS; f++) to->equations[f] = -of->we * df[f] - of->wm * df_mid[f];
}

/* What the cell behind node i goes by, once its slopes are known. */
static void Describe(const Cell *cell, PetscInt i, const PetscReal shift[], const Slopes *slopes,
                     YieldCell *of) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const PetscReal k = self->bow * cell->h;

  *of = (YieldCell){.cell = cell,
                    .shift = shift,
                    .law = cell->law,
                    .at = {cell->a, cell->mid, cell->b},
                    .slope = {&slopes->a, &slopes->mid, &slopes->b},
                    .place = 2 * (i - cell->rod->first + 1),
                    .tip = (PetscBool)(i + 1 == cell->rod->last),
                    .k = {k, -k},
                    .we = cell->h * self->end_weight,
                    .wm = cell->h * self->mid_weight};
  SpaceMidTurns(cell, &slopes->mid, of->turn);
  for (int p = 0; p < 3; p++)
    VaryV(cell->rod, of->law + p, of->at[p], of->slope[p], of->along[p], &of->by_g[p]);
}

/* The unknowns in the middle by the others of end e: mid[f] those that they change by f. */
static void MidByEnd(const YieldCell *of, int e, PetscReal mid[FIELDS][FIELDS]) {
  for (int r = 0; r < FIELDS; r++)
    for (int f = 0; f < FIELDS; f++)
      mid[f][r] = (r == f ? 0.5 : 0) + of->k[e] * of->slope[2 * e]->f[r][f];
}

/* Adds V and L of end e to a cell's equations by that end, J, of which those of the others are
   there. With slide in the middle all unknowns change that V' at the end goes by. */
static void AddYield(const YieldCell *of, int e, PetscReal J[YIELD_FIELDS][YIELD_FIELDS],
                     LearnedCell *learned) {
  const Law *law = of->law;
  const PetscReal sign = e ? 1 : -1, shift = of->shift[OF_L], *along = of->along[2 * e],
                  *along_mid = of->along[AT_MID], moves = e && of->tip ? 0 : 1,
                  s_mid = law[AT_MID].s, k = of->k[e];
  const Change still = {0}, by_V = {.c = moves},
               by_L = {.g = 1, .g_t = shift, .c = -moves * law[2 * e].s * shift},
               mid_V = {.c = 0.5}, mid_L = {.g = 0.5, .c = k * of->by_g[2 * e] - s_mid * shift / 2},
               slides = {.c = 1};
  PetscReal mid[YIELD_FIELDS][FIELDS], slope, slope_mid;
  Changed by[2], slid;

  Vary(of, e, &by_V, &mid_V, &by[0]);
  Vary(of, e, &by_L, &mid_L, &by[1]);
  Vary(of, e, &still, &slides, &slid);
  MidByEnd(of, e, mid);
  for (int c = 0; c < 2; c++) {
    memcpy(mid[OF_V + c], by[c].mid, sizeof(by[c].mid));
    for (int r = 0; r < FIELDS; r++) J[r][OF_V + c] = by[c].equations[r];
    for (int r = X; r < N; r++) learned->by_node[e][r][OF_V + c] = by[c].mid[r];
  }
  for (int f = 0; f < YIELD_FIELDS; f++) {
    const PetscReal g = f == OF_L, V = f == OF_V;
    slope = f < FIELDS ? along[f] : g * of->by_g[2 * e];
    slope_mid = Times(FIELDS, along_mid, mid[f]) + g / 2 * of->by_g[AT_MID];
    for (int r = 0; r < FIELDS && f < FIELDS; r++) J[r][f] += slid.equations[r] * k * slope;
    J[OF_V][f] = sign * V - of->we * slope - of->wm * slope_mid;
    J[OF_L][f] = sign * g;
    YieldsClocks(of->cell->rod, of->place, e, f, of->cell->h, &(YieldsChange){V, slope, g, g / 2},
                 learned->clock);
  }
  for (int b = 0; b < TROPISM_BENDS; b++)
    learned->column[2 * e][b][OF_V] = -of->wm * Times(FIELDS, along_mid, learned->by_bend[e][b]);
}

/* A cell's equations by its nodes, left and right, and by what is learned. */
static void YieldBlocks(Cell *cell, PetscInt i, PetscBool first, const PetscReal shift[],
                        Slopes *slopes, PetscReal left[YIELD_FIELDS][YIELD_FIELDS],
                        PetscReal right[YIELD_FIELDS][YIELD_FIELDS], LearnedCell *learned) {
  PetscReal bare[2][FIELDS][FIELDS], (*J[2])[YIELD_FIELDS] = {left, right};
  YieldCell of;

  SpaceLearnedDrives(cell->rod, i, cell->a, cell->mid);
  SpaceLearnedDrives(cell->rod, i + 1, cell->b, NULL);
  SpaceCellBlocks(cell, i, first, shift, slopes, bare[0], bare[1]);
  memset(learned, 0, sizeof(*learned));
  SpaceLearnedCell(cell, i, slopes, PETSC_TRUE, PETSC_TRUE, learned);
  Describe(cell, i, shift, slopes, &of);
  for (int e = 0; e < 2; e++) {
    for (int r = 0; r < FIELDS; r++) memcpy(J[e][r], bare[e][r], sizeof(bare[e][r]));
    AddYield(&of, e, J[e], learned);
  }
}

/* The equations at the clamp, by the node there. */
static void AtClamp(const Cell *cell, const PetscReal u[FIELDS],
                    PetscReal begin[LEFT + 1][YIELD_FIELDS]) {
  const Rod rod = cell->rod;
  const Point *p = cell->a;
  PetscReal by[LEFT][FIELDS], D[3][4], slope, *of_V = begin[LEFT];

  memset(begin, 0, (LEFT + 1) * sizeof(*begin));
  SpaceClampBlock(rod->scene, cell->t, u, by);
  for (int r = 0; r < LEFT; r++) memcpy(begin[r], by[r], sizeof(by[r]));
  of_V[OF_V] = 1;
  (void)YieldsPart(rod, AlongOf(p), &slope);
  slope *= GrowthYieldInflow(rod->scene->growth);
  DirectorSlope(p->p, p->size, p->at.axes[0], 0, D);
  for (int j = 0; j < 4; j++) of_V[P + j] = -slope * ColumnDot3(D[0], 4, j, p->n);
  for (int j = 0; j < 3; j++) of_V[N + j] = -slope * p->at.axes[0][j];
}

/* ... and those of the tip, by the last node. */
static void AtTip(const Cell *cell, const Slope *slope, const PetscReal shift[],
                  PetscReal end[RIGHT + 1][YIELD_FIELDS]) {
  PetscReal by[RIGHT][FIELDS];

  SpaceTipBlock(cell, slope, shift, by);
  memset(end, 0, (RIGHT + 1) * sizeof(*end));
  for (int r = 0; r < RIGHT; r++) memcpy(end[r], by[r], sizeof(by[r]));
  YieldsEnd(cell->rod, shift, end[RIGHT]);
}

/* SpaceYieldJacobian - SpaceJacobian(), of a rod whose growth feels force. */
PetscErrorCode SpaceYieldJacobian(Rod rod, const RodState *at, Mat J) {
  const PetscInt begin = PetscMax(rod->first - 1, 0);
  PetscReal left[YIELD_FIELDS][YIELD_FIELDS], right[YIELD_FIELDS][YIELD_FIELDS],
      end[LEFT + 1][YIELD_FIELDS], *room;
  LearnedCell learned;
  Slopes slopes;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(8 * PetscSqr(rod->model->fields), &room));
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  for (PetscInt i = begin; i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (i == 0) AtClamp(&cell, cell.u[0], end);
    YieldBlocks(&cell, i, (PetscBool)(i == begin), at->shift, &slopes, left, right, &learned);
    LearnedNodeSlope(rod, i, &learned.slope[AT_A], learned.clock[AT_A][0], at->shift);
    LearnedRows(rod, i, &learned, at->shift);
    PetscCall(LearnedMatrix(rod, i, i == 0 ? end[0] : NULL, &learned, left[0], right[0],
                            &learned.slope[AT_A], learned.clock[AT_A][0], NULL, room, J));
  }
  if (rod->end > rod->last) {
    AtTip(&cell, &slopes.b, at->shift, end);
    LearnedNodeSlope(rod, rod->last, &learned.slope[AT_B], learned.clock[AT_B][1], at->shift);
    LearnedSignalSlope(rod, &learned.slope[AT_B], at->shift);
    PetscCall(LearnedMatrix(rod, rod->last, NULL, NULL, NULL, NULL, &learned.slope[AT_B],
                            learned.clock[AT_B][1], end[0], room, J));
  }
  PetscCall(SpaceCellsClose(&cell));
  PetscCall(PetscFree(room));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* SpaceYieldEliminate - SpaceEliminate(), of a rod whose growth feels force, on one rank. */
PetscErrorCode SpaceYieldEliminate(Rod rod, const RodState *at, Elimination elimination) {
  Halves line = EliminationHalves(elimination);
  PetscReal left[YIELD_FIELDS][YIELD_FIELDS], right[YIELD_FIELDS][YIELD_FIELDS],
      end[LEFT + 1][YIELD_FIELDS], *a, *b;
  LearnedCell learned;
  Slopes slopes;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  HalvesBegin(line);
  for (PetscInt i = 0; i < rod->last; i++) {
    SpaceCellsNext(&cell, i);
    if (i == 0) {
      AtClamp(&cell, cell.u[0], end);
      LearnedTurned(rod, LEFT + 1, end[0], HalvesFirst(line));
    }
    YieldBlocks(&cell, i, (PetscBool)(i == 0), at->shift, &slopes, left, right, &learned);
    if (i == 0) LearnedNodeSlope(rod, i, &learned.slope[AT_A], learned.clock[AT_A][0], at->shift);
    LearnedNodeSlope(rod, i + 1, &learned.slope[AT_B], learned.clock[AT_B][1], at->shift);
    LearnedCondense(rod, i, &learned, at->shift, left[0], right[0]);
    HalvesBlocks(line, &a, &b);
    LearnedTurned(rod, YIELD_FIELDS, left[0], a);
    LearnedTurned(rod, YIELD_FIELDS, right[0], b);
    HalvesCell(line);
  }
  LearnedSignalSlope(rod, &learned.slope[AT_B], at->shift);
  AtTip(&cell, &slopes.b, at->shift, end);
  LearnedTurned(rod, RIGHT + 1, end[0], left[0]);
  HalvesEnd(line, left[0]);
  PetscCall(SpaceCellsClose(&cell));
  LearnedCondensed(rod, elimination);
  PetscFunctionReturn(0);
}
