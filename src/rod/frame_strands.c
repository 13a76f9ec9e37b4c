/* The frame model of a rod that touches itself: what rod/strands.h finds goes into the equations
   and into their derivatives. Every rank knows the whole rod and finds the same. */
#include "rod/frame.h"
#include <string.h>
#include <petsc/private/matimpl.h> /* a matrix that is given another pattern does not say so itself */

struct FrameStrands {
  Strands strands;
  VecScatter to_all; /* NULL on one rank */
  Vec all[2];        /* U and U_t of the whole rod */
  const PetscScalar *open[2];
  /* what the matrix has room for: the feet of points on cell a are foot[from[a]] ... */
  PetscInt *from, *foot;
  PetscInt n, (*near)[2]; /* the pairs that its pattern was made of */
};

/* FrameStrandsCreate - what a rod of the frame model needs to touch itself: its strands, all nodes
   on each rank, room in the matrix. The caller ends it with FrameStrandsDestroy(). Collective. */
PetscErrorCode FrameStrandsCreate(Rod rod, struct FrameStrands **strands) {
  struct FrameStrands *self;
  PetscMPIInt ranks;
  Vec U;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *strands = self;
  PetscCall(StrandsCreate(rod->scene, &self->strands));
  PetscCall(PetscCalloc1(rod->last + 1, &self->from));
  PetscCallMPI(MPI_Comm_size(rod->scene->comm, &ranks));
  if (ranks == 1) PetscFunctionReturn(0);
  PetscCall(DMGetGlobalVector(rod->da, &U));
  PetscCall(VecScatterCreateToAll(U, &self->to_all, &self->all[0]));
  PetscCall(VecDuplicate(self->all[0], &self->all[1]));
  PetscCall(DMRestoreGlobalVector(rod->da, &U));
  PetscFunctionReturn(0);
}

PetscErrorCode FrameStrandsDestroy(struct FrameStrands **strands) {
  struct FrameStrands *self = *strands;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(StrandsDestroy(&self->strands));
  PetscCall(PetscFree(self->from));
  PetscCall(PetscFree(self->foot));
  PetscCall(PetscFree(self->near));
  PetscCall(VecScatterDestroy(&self->to_all));
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&self->all[k]));
  PetscCall(PetscFree(*strands));
  PetscFunctionReturn(0);
}

/* The state of the whole rod, on every rank. Ends with CloseState(). */
static PetscErrorCode OpenState(struct FrameStrands *self, PetscReal t, Vec U, Vec U_t,
                                StrandState *state) {
  Vec v[2] = {U, U_t};

  PetscFunctionBegin;
  for (int k = 0; k < 2; k++) {
    if (self->to_all) {
      PetscCall(VecScatterBegin(self->to_all, v[k], self->all[k], INSERT_VALUES, SCATTER_FORWARD));
      PetscCall(VecScatterEnd(self->to_all, v[k], self->all[k], INSERT_VALUES, SCATTER_FORWARD));
      v[k] = self->all[k];
    }
    PetscCall(VecGetArrayRead(v[k], &self->open[k]));
  }
  *state = (StrandState){.t = t, .stride = FIELDS, .u = self->open[0], .u_t = self->open[1]};
  PetscFunctionReturn(0);
}

static PetscErrorCode CloseState(struct FrameStrands *self, Vec U, Vec U_t) {
  PetscFunctionBegin;
  PetscCall(VecRestoreArrayRead(self->to_all ? self->all[0] : U, &self->open[0]));
  PetscCall(VecRestoreArrayRead(self->to_all ? self->all[1] : U_t, &self->open[1]));
  PetscFunctionReturn(0);
}

/* FrameStrandsLoad - the forces of contact in a state, as StrandsForces() has them. Pairs are
   looked for once a Newton solve. Collective. */
PetscErrorCode FrameStrandsLoad(Rod rod, PetscReal t, Vec U, Vec U_t,
                                const PetscReal (**force)[2]) {
  struct FrameStrands *self = ((Frame *)rod->data)->strands;
  StrandState state;

  PetscFunctionBegin;
  PetscCall(OpenState(self, t, U, U_t, &state));
  if (rod->fresh) PetscCall(StrandsSearch(self->strands, &state));
  PetscCall(StrandsLoad(self->strands, &state));
  PetscCall(CloseState(self, U, U_t));
  *force = StrandsForces(self->strands);
  PetscFunctionReturn(0);
}

/* FrameStrandsHold - see StrandsHold(); in the state of the latest load. */
PetscErrorCode FrameStrandsHold(Rod rod, PetscReal seen, PetscReal *creep) {
  PetscFunctionBegin;
  PetscCall(StrandsHold(((Frame *)rod->data)->strands->strands, seen, creep));
  PetscFunctionReturn(0);
}

/* What is remembered of a node and of the middle behind it: of either side, the dual and the shift.
 */
enum { SIDES = 2, OF_SIDE = 4 };

/* FrameStrandsMemory - how many reals a node remembers of the friction between strands. */
PetscInt FrameStrandsMemory(Rod rod) {
  FrictionDual *duals;
  return StrandsDuals(((Frame *)rod->data)->strands->strands, &duals) ? 2 * SIDES * OF_SIDE : 0;
}

/* FrameStrandsRemembered - the k-th of them at node i; NULL where there is none (behind the tip).
 */
PetscReal *FrameStrandsRemembered(Rod rod, PetscInt i, PetscInt k) {
  FrictionDual *duals;
  PetscInt n = StrandsDuals(((Frame *)rod->data)->strands->strands, &duals),
           at = 2 * SIDES * i + k / OF_SIDE;
  if (at >= n) return NULL;
  return (k % OF_SIDE < 2 ? duals[at].w : duals[at].shift) + k % 2;
}

/* FrameStrandsRecalled - each rank has recalled what its own nodes remember: tells the others.
   Collective. */
PetscErrorCode FrameStrandsRecalled(Rod rod) {
  const PetscInt reals = sizeof(FrictionDual) / sizeof(PetscReal);
  FrictionDual *duals;
  PetscInt n = StrandsDuals(((Frame *)rod->data)->strands->strands, &duals);
  PetscMPIInt count;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) {
    PetscInt node = k / (2 * SIDES);
    if (node < rod->first || node >= rod->end) PetscCall(PetscMemzero(&duals[k], sizeof(*duals)));
  }
  PetscCall(PetscMPIIntCast(n * reals, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, duals, count, MPIU_REAL, MPI_SUM, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* ---- the matrix ---- */

/* How far a foot may wander along the rod, in cells, before the matrix needs another pattern. */
enum { WANDER = 1 };

/* The columns of each owned row of nodes, as they are gathered. */
typedef struct {
  PetscInt *n, *room, **column;
} Columns;

/* (Most are there already: a row has some twenty.) */
static PetscErrorCode AddColumn(Columns *columns, PetscInt row, PetscInt column) {
  PetscInt n = columns->n[row];

  PetscFunctionBegin;
  for (PetscInt k = n - 1; k >= 0; k--)
    if (columns->column[row][k] == column) PetscFunctionReturn(0);
  if (n == columns->room[row]) {
    columns->room[row] = 2 * n + 8;
    PetscCall(PetscRealloc((size_t)columns->room[row] * sizeof(PetscInt), &columns->column[row]));
  }
  columns->column[row][columns->n[row]++] = column;
  PetscFunctionReturn(0);
}

/* Rows low .. high, of those owned, get columns from .. to. */
static PetscErrorCode AddColumns(Rod rod, Columns *columns, PetscInt low, PetscInt high,
                                 PetscInt from, PetscInt to) {
  PetscFunctionBegin;
  for (PetscInt i = PetscMax(low, rod->first); i <= PetscMin(high, rod->end - 1); i++)
    for (PetscInt j = PetscMax(from, 0); j <= PetscMin(to, rod->last); j++)
      PetscCall(AddColumn(columns, i - rod->first, j));
  PetscFunctionReturn(0);
}

/* ... for the contact of a point on one cell with a foot on another, or near it. */
static PetscErrorCode AddPair(Rod rod, Columns *columns, const PetscInt cell[2]) {
  PetscFunctionBegin;
  for (int k = 0; k < 2; k++) {
    PetscInt a = cell[k], b = cell[1 - k], low = a - 1 - WANDER, high = a + 1 + WANDER;
    PetscCall(AddColumns(rod, columns, low, high, b - WANDER, b + 1 + WANDER));
    PetscCall(AddColumns(rod, columns, low, high, a - WANDER, a + 1 + WANDER));
  }
  PetscFunctionReturn(0);
}

/* Gives J room for these columns, and zeros there. */
static PetscErrorCode Allocate(Rod rod, Columns *columns, Mat J) {
  const PetscScalar zero[FIELDS * FIELDS] = {0};
  const PetscInt rows = rod->end - rod->first;
  PetscInt *own, *other;

  PetscFunctionBegin;
  PetscCall(PetscCalloc2(rows, &own, rows, &other));
  for (PetscInt i = 0; i < rows; i++) {
    PetscCall(PetscSortInt(columns->n[i], columns->column[i]));
    for (PetscInt k = 0; k < columns->n[i]; k++)
      if (columns->column[i][k] >= rod->first && columns->column[i][k] < rod->end)
        own[i]++;
      else
        other[i]++;
  }
  PetscCall(MatXAIJSetPreallocation(J, FIELDS, own, other, NULL, NULL));
  for (PetscInt i = 0; i < rows; i++) {
    const PetscInt row = i + rod->first;
    for (PetscInt k = 0; k < columns->n[i]; k++)
      PetscCall(MatSetValuesBlocked(J, 1, &row, 1, &columns->column[i][k], zero, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  J->nonzerostate++;
  PetscCall(PetscFree2(own, other));
  PetscFunctionReturn(0);
}

/* Remembers for which pairs there is room. */
static PetscErrorCode KeepPairs(struct FrameStrands *self, PetscInt cells, PetscInt n,
                                PetscInt (*near)[2]) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->foot));
  PetscCall(PetscMalloc1(n, &self->foot));
  PetscCall(PetscArrayzero(self->from, cells + 1));
  for (PetscInt k = 0; k < n; k++) self->from[near[k][0] + 1]++;
  for (PetscInt a = 0; a < cells; a++) self->from[a + 1] += self->from[a];
  for (PetscInt k = 0; k < n; k++) self->foot[--self->from[near[k][0] + 1]] = near[k][1];
  for (PetscInt a = 0; a < cells; a++) self->from[a] = self->from[a + 1];
  self->from[cells] = n;
  PetscFunctionReturn(0);
}

/* Is there room for a pair? */
static PetscBool HasRoom(const struct FrameStrands *self, const PetscInt cell[2]) {
  for (PetscInt k = self->from[cell[0]]; k < self->from[cell[0] + 1]; k++)
    if (PetscAbsInt(self->foot[k] - cell[1]) <= WANDER) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Gives J the pattern of the rod and of all pairs that are near to touching. */
static PetscErrorCode NewPattern(Rod rod, Mat J, PetscInt n, PetscInt (*near)[2]) {
  struct FrameStrands *self = ((Frame *)rod->data)->strands;
  const PetscInt rows = rod->end - rod->first;
  Columns columns;

  PetscFunctionBegin;
  PetscCall(PetscCalloc3(rows, &columns.n, rows, &columns.room, rows, &columns.column));
  for (PetscInt i = rod->first; i < rod->end; i++)
    PetscCall(AddColumns(rod, &columns, i, i, i - 1, i + 1));
  for (PetscInt k = 0; k < n; k++) PetscCall(AddPair(rod, &columns, near[k]));
  PetscCall(KeepPairs(self, rod->last, n, near));
  PetscCall(Allocate(rod, &columns, J));
  for (PetscInt i = 0; i < rows; i++) PetscCall(PetscFree(columns.column[i]));
  PetscCall(PetscFree3(columns.n, columns.room, columns.column));
  PetscFunctionReturn(0);
}

/* Is the pattern that of these pairs, or has it room for them at least? */
static PetscBool Fits(const struct FrameStrands *self, PetscBool exactly, PetscInt n,
                      PetscInt (*near)[2]) {
  PetscBool fits = PETSC_TRUE;

  if (exactly)
    return (PetscBool)(n == self->n &&
                       (!n || !memcmp(near, self->near, (size_t)n * sizeof(*near))));
  for (PetscInt k = 0; k < n && fits; k++) fits = HasRoom(self, near[k]);
  return fits;
}

/* FrameStrandsPattern - sees to it that J has room for all pairs, and is 0. A Newton solve begins
   with the pattern of what is near then, and no more: so a run that is restarted has the same, and
   the same round-off. Collective. */
PetscErrorCode FrameStrandsPattern(Rod rod, Mat J) {
  struct FrameStrands *self = ((Frame *)rod->data)->strands;
  PetscBool assembled;
  PetscInt n, (*near)[2];

  PetscFunctionBegin;
  PetscCall(StrandsNear(self->strands, &n, &near));
  PetscCall(MatAssembled(J, &assembled));
  if (assembled && Fits(self, rod->fresh, n, near))
    PetscCall(PetscFree(near));
  else {
    PetscCall(NewPattern(rod, J, n, near));
    PetscCall(PetscFree(self->near));
    self->near = near;
    self->n = n;
  }
  PetscCall(MatZeroEntries(J));
  PetscFunctionReturn(0);
}

/* The middle's direction of the cell behind node i. */
static void MidDirection(const Frame *frame, Rod rod, const StrandState *state, PetscInt i,
                         PetscReal q[2]) {
  const Law *law = frame->law + 2 * (i - rod->first + 1);
  const PetscReal *a = state->u + i * FIELDS, *b = a + FIELDS,
                  h = rod->scene->mesh.s[i + 1] - rod->scene->mesh.s[i];
  PetscReal theta = (a[TH] + b[TH]) / 2 + frame->bow * h *
                                              (law[0].g * (a[M] * law[0].flex + law[0].k0) -
                                               law[2].g * (b[M] * law[2].flex + law[2].k0));
  q[0] = PetscCosReal(theta);
  q[1] = PetscSinReal(theta);
}

/* The rows of one node by the nodes of two cells. */
typedef PetscReal Block[FIELDS][4 * FIELDS];

/*
  Adds to the rows of node i, those of the cell behind it, that n' of one of its points changes:
  part 0 node i, 1 the middle, 2 node i + 1. With k = bow h and n_mid = ... + k (n'_a - n'_b),
    r_n  = ... - h w n',   r_m = ... - h w_mid g_mid (q2 n1_mid - q1 n2_mid)
*/
static void AddToCell(const Frame *frame, Rod rod, const StrandState *state, PetscInt i, int part,
                      PetscReal by[2][STRAND_UNKNOWNS], Block block) {
  const PetscReal h = rod->scene->mesh.s[i + 1] - rod->scene->mesh.s[i],
                  w = h * (part == 1 ? frame->mid_weight : frame->end_weight),
                  k = (part == 0 ? 1 : -1) * frame->bow * h;
  PetscReal q[2], wm;

  MidDirection(frame, rod, state, i, q);
  wm = part == 1 ? 0 : h * frame->mid_weight * frame->law[2 * (i - rod->first + 1) + 1].g * k;
  for (int u = 0; u < STRAND_UNKNOWNS; u++) {
    PetscInt column = u / 3 * FIELDS + u % 3; /* x1, x2, theta of each of the four nodes */
    block[M][column] -= wm * (q[1] * by[0][u] - q[0] * by[1][u]);
    for (int d = 0; d < 2; d++) block[N1 + d][column] -= w * by[d][u];
  }
}

/* Adds one contact's part of one taker to J. */
static PetscErrorCode AddTaker(Rod rod, const StrandState *state, const StrandSlope *slope, int k,
                               Mat J) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt taker = slope->taker[k], i = taker / 2,
                 column[4] = {slope->cell[0], slope->cell[0] + 1, slope->cell[1],
                              slope->cell[1] + 1};
  PetscReal(*by)[STRAND_UNKNOWNS] = (PetscReal(*)[STRAND_UNKNOWNS])slope->by[k];

  PetscFunctionBegin;
  for (int which = 0; which < 2; which++) { /* the cell behind the point, and that before a node */
    PetscInt row = i - which;
    Block block = {{0}};
    PetscBool tip = (PetscBool)(taker == 2 * rod->last + 1);
    if (row < rod->first || row >= rod->end || (which && (taker % 2 || tip))) continue;
    if (tip && rod->scene->tip.type != TIP_FREE) continue;
    if (row == rod->last && !tip) continue; /* behind the tip there is no cell */
    if (tip)
      for (int u = 0; u < STRAND_UNKNOWNS; u++)
        for (int d = 0; d < 2; d++) block[N1 + d][u / 3 * FIELDS + u % 3] -= by[d][u];
    else
      AddToCell(frame, rod, state, row, which ? 2 : (int)(taker % 2), by, block);
    PetscCall(MatSetValuesBlocked(J, 1, &row, 4, column, &block[0][0], ADD_VALUES));
  }
  PetscFunctionReturn(0);
}

/* FrameStrandsJacobian - adds to J, whose other values are set, the derivatives of the forces of
   contact, in the state of the latest load. Collective. */
PetscErrorCode FrameStrandsJacobian(Rod rod, PetscReal t, Vec U, Vec U_t, const PetscReal shift[],
                                    Mat J) {
  struct FrameStrands *self = ((Frame *)rod->data)->strands;
  const StrandSlope *slopes;
  StrandState state;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(MatAssemblyBegin(J, MAT_FLUSH_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FLUSH_ASSEMBLY));
  PetscCall(OpenState(self, t, U, U_t, &state));
  PetscCall(StrandsLinearise(self->strands, &state, shift, rod->fresh, &n, &slopes));
  for (PetscInt c = 0; c < n; c++)
    for (int k = 0; k < slopes[c].takers; k++) PetscCall(AddTaker(rod, &state, &slopes[c], k, J));
  PetscCall(CloseState(self, U, U_t));
  PetscFunctionReturn(0);
}
