#include "rod/strand_rows.h"
#include "rod/coupled.h"
#include "rod/learned.h"

/* Where the unknowns of a node begin, and their rows: the plane has no p. bends: how many its
   material learns in the middle of a cell, whose rows are `learned` and behind it. */
typedef struct {
  int dims, fields, node, p, m, n, bends, learned;
} Layout;

static Layout LayoutOf(const Rod rod) {
  Layout of = {.dims = 2, .node = 3, .p = -1, .m = 3, .n = 4};

  if (rod->model->space) of = (Layout){.dims = 3, .node = 7, .p = 3, .m = 7, .n = 10};
  of.fields = (int)rod->model->fields;
  if (!rod->learned) return of;
  of.bends = (int)rod->learned->bends;
  of.learned = (int)(rod->learned->mech + rod->learned->per);
  return of;
}

struct _StrandRows {
  Strands strands;
  PetscBool own; /* ... which is ended with it */
  Coupled coupled;
  Layout of;
  StrandCell *cells;  /* behind the owned nodes */
  RodSeen seen;       /* the state of the latest load, */
  PetscBool searched; /* ... that was searched for pairs */
};

/* StrandRowsCreate - what a rod needs to touch itself, or several rods to touch each other: their
   strands, all nodes on each rank, room in the matrix. The caller ends it with StrandRowsDestroy().
   Collective.

   strands  those of several rods, which must outlive it; NULL: of one, its own */
PetscErrorCode StrandRowsCreate(Rod rod, Strands strands, StrandRows *rows) {
  PetscFunctionBegin;
  PetscCall(PetscNew(rows));
  (*rows)->of = LayoutOf(rod);
  (*rows)->strands = strands;
  (*rows)->own = (PetscBool)!strands;
  if (!strands) PetscCall(StrandsCreate(rod->scene, &(*rows)->strands));
  PetscCall(CoupledCreate(rod, &(*rows)->coupled));
  PetscCall(PetscCalloc1(rod->end - rod->first, &(*rows)->cells));
  RodForget(&(*rows)->seen);
  PetscFunctionReturn(0);
}

PetscErrorCode StrandRowsDestroy(StrandRows *rows) {
  PetscFunctionBegin;
  if (!*rows) PetscFunctionReturn(0);
  if ((*rows)->own) PetscCall(StrandsDestroy(&(*rows)->strands));
  PetscCall(CoupledDestroy(&(*rows)->coupled));
  PetscCall(PetscFree((*rows)->cells));
  PetscCall(PetscFree(*rows));
  PetscFunctionReturn(0);
}

/* The state of the whole rod, on every rank. Ends with CoupledClose(). */
static PetscErrorCode OpenState(StrandRows self, const RodState *at, StrandState *state) {
  const PetscReal *u[2];

  PetscFunctionBegin;
  PetscCall(CoupledOpen(self->coupled, at->U, at->U_t, u));
  *state = (StrandState){.t = at->t, .stride = self->of.fields, .u = u[0], .u_t = u[1]};
  PetscFunctionReturn(0);
}

/* StrandRowsLoad - the forces of contact in a state, as StrandsForces() has them, and the couples
   (NULL: there are none). Pairs are looked for once a Newton solve: a Jacobian follows on the
   residual of the same state. Collective. */
PetscErrorCode StrandRowsLoad(Rod rod, StrandRows self, const RodState *at,
                              const PetscReal (**force)[3], const PetscReal (**couple)[3]) {
  StrandState state;
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(RodRecognise(at, &self->seen, &known));
  PetscCall(OpenState(self, at, &state));
  if (!known || (at->fresh && !self->searched)) {
    if (at->fresh) PetscCall(StrandsSearch(self->strands, &state));
    PetscCall(StrandsLoad(self->strands, &state));
    self->searched = at->fresh;
  }
  PetscCall(CoupledClose(self->coupled, at->U, at->U_t));
  *force = StrandsForces(self->strands);
  *couple = StrandsCouples(self->strands);
  PetscFunctionReturn(0);
}

/* ---- what Newton's method remembers ---- */

/* StrandRowsHold - see StrandsHold(); in the state of the latest load. */
PetscErrorCode StrandRowsHold(StrandRows self, PetscReal seen, PetscReal *creep) {
  PetscFunctionBegin;
  PetscCall(StrandsHold(self->strands, seen, creep));
  RodForget(&self->seen); /* its forces are others now */
  PetscFunctionReturn(0);
}

/* What is remembered of a node and of the middle behind it: of either side, the dual. */
enum { SIDES = 2, RUBBING = 2 };

/* StrandRowsMemory - how many reals a node remembers of the friction between strands. */
PetscInt StrandRowsMemory(StrandRows self) {
  FrictionDual *duals;
  return StrandsDuals(self->strands, &duals) ? 2 * SIDES * FrictionDualReals(RUBBING) : 0;
}

/* StrandRowsRemembered - the k-th of them at node i; NULL where there is none (behind the tip). */
PetscReal *StrandRowsRemembered(StrandRows self, PetscInt i, PetscInt k) {
  FrictionDual *duals;
  const PetscInt n = StrandsDuals(self->strands, &duals), each = FrictionDualReals(RUBBING),
                 at = 2 * SIDES * i + k / each;

  return at < n ? FrictionDualReal(RUBBING, &duals[at], k % each) : NULL;
}

/* StrandRowsRecalled - each rank has recalled what its own nodes remember: tells the others.
   Collective. */
PetscErrorCode StrandRowsRecalled(Rod rod, StrandRows self) {
  FrictionDual *duals;
  PetscInt n = StrandsDuals(self->strands, &duals);
  PetscMPIInt count;

  PetscFunctionBegin;
  RodForget(&self->seen);
  for (PetscInt k = 0; k < n; k++) {
    PetscInt node = k / (2 * SIDES);
    if (node < rod->first || node >= rod->end) PetscCall(PetscMemzero(&duals[k], sizeof(*duals)));
  }
  PetscCall(PetscMPIIntCast(n * (PetscInt)(sizeof(*duals) / sizeof(PetscReal)), &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, duals, count, MPIU_REAL, MPI_SUM, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* ---- the matrix ---- */

/* StrandRowsCell - the cell behind an owned node i, which a model fills in while it makes its own
   part of the matrix. */
StrandCell *StrandRowsCell(Rod rod, StrandRows self, PetscInt i) {
  return &self->cells[i - rod->first];
}

/* StrandRowsPattern - sees to it that J has room for all pairs, and is 0. Collective. */
PetscErrorCode StrandRowsPattern(Rod rod, StrandRows self, PetscBool fresh, Mat J) {
  CellPair *near;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(StrandsNear(self->strands, &n, &near));
  PetscCall(CoupledPattern(rod, self->coupled, fresh, n, near, J));
  PetscFunctionReturn(0);
}

/* The rows of one node by the nodes of two cells: of row f, at f * 4 fields. */
typedef PetscReal Coupling[4 * MAX_FIELDS * MAX_FIELDS];

static inline PetscReal *RowOf(const Layout *of, PetscReal *block, int f) {
  return block + (size_t)(4 * of->fields * f);
}

/* Where the u-th unknown of a contact is among the columns of four nodes. */
static inline int ColumnOf(const Layout *of, int u) {
  return u / of->node * of->fields + u % of->node;
}

/* Adds s times the derivatives of one component to a row. */
static void AddRow(const Layout *of, PetscReal s, const PetscReal by[STRAND_UNKNOWNS],
                   PetscReal *row) {
  for (int u = 0; u < 4 * of->node; u++) row[ColumnOf(of, u)] += s * by[u];
}

/*
  Adds to the rows of a node, those of the cell behind it, that n' of one of its points changes:
  part 0 the node, 1 the middle, 2 the next node. With k = bow h, n_mid = ... + k (n'_a - n'_b):
    r_n = ... - h w n',    r_m = ... + h w_mid g_mid q_mid x n_mid
*/
static void AddToCell(const Layout *of, const StrandCell *cell, int part, StrandBy by,
                      PetscReal *block) {
  const PetscReal w = part == 1 ? cell->mid_weight : cell->end_weight, *q = cell->q,
                  wm = part == 1 ? 0 : cell->mid_weight * cell->g * (part ? -1 : 1) * cell->bow;

  for (int d = 0; d < of->dims; d++) AddRow(of, -w, by[d], RowOf(of, block, of->n + d));
  if (part == 1) return;
  for (int c = of->dims == 2 ? 2 : 0; c < 3; c++) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    PetscReal *row = RowOf(of, block, of->dims == 2 ? of->m : of->m + c);
    for (int u = 0; u < 4 * of->node; u++)
      row[ColumnOf(of, u)] += wm * (q[a] * by[b][u] - q[b] * by[a][u]);
  }
}

/*
  The same of m' in space. The moment in the middle of the cell, m_mid = ... + k (m'_a - m'_b),
  turns the cell's end, too, in the rows of the next node (of which `next` gets a part), and the
  material there learns by it: r_m = ... - h w m',    r_p = ... - h w_mid dp'/dm_mid m_mid
*/
static void AddCouple(const Layout *of, const StrandCell *cell, int part, StrandBy by,
                      PetscReal *block, PetscReal *next) {
  const PetscReal w = part == 1 ? cell->mid_weight : cell->end_weight,
                  bow = part == 1 ? 0 : (part ? -1 : 1) * cell->bow, wm = cell->mid_weight * bow;

  for (int d = 0; d < 3; d++) {
    AddRow(of, -w, by[d], RowOf(of, block, of->m + d));
    for (int k = 0; k < 4; k++)
      AddRow(of, -(wm * cell->p_m[k][d]), by[d], RowOf(of, next, of->p + k));
    for (int b = 0; b < of->bends; b++)
      AddRow(of, bow * cell->learned_m[b][d], by[d], RowOf(of, block, of->learned + b));
  }
}

/* Adds one contact's part of the tip's force and couple. */
static void AddToTip(const Layout *of, StrandSlope *slope, int k, PetscReal *block) {
  for (int d = 0; d < of->dims; d++) {
    AddRow(of, -1, slope->by[k][d], RowOf(of, block, of->n + d));
    if (slope->couples) AddRow(of, -1, slope->couple_by[k][d], RowOf(of, block, of->m + d));
  }
}

/* Adds one contact's part of one taker to J. */
static PetscErrorCode AddTaker(Rod rod, StrandRows self, StrandSlope *slope, int k, Mat J) {
  const Layout *of = &self->of;
  const PetscInt taker = slope->taker[k], i = taker / 2, r = StrandsRod(self->strands, i);
  const Rod one = rod->each[r];
  const PetscInt first = PetscMax(StrandsFirst(self->strands, r), rod->first),
                 last = StrandsFirst(self->strands, r) + one->last,
                 column[4] = {slope->cell[0], slope->cell[0] + 1, slope->cell[1],
                              slope->cell[1] + 1};
  const PetscBool tip = (PetscBool)(taker == 2 * last + 1);

  PetscFunctionBegin;
  for (int which = 0; which < 2; which++) { /* the cell behind the point, and that before a node */
    const int part = which ? 2 : (int)(taker % 2);
    PetscInt row = i - which, after = row + 1;
    Coupling block, next;
    if (row < first || row >= rod->end || (which && (taker % 2 || tip))) continue;
    if (tip && one->scene->tip.type != TIP_FREE) continue;
    if (row == last && !tip) continue; /* behind the tip there is no cell */
    PetscCall(PetscArrayzero(block, 4 * of->fields * of->fields));
    if (tip)
      AddToTip(of, slope, k, block);
    else
      AddToCell(of, StrandRowsCell(rod, self, row), part, slope->by[k], block);
    if (slope->couples && !tip) {
      PetscCall(PetscArrayzero(next, 4 * of->fields * of->fields));
      AddCouple(of, StrandRowsCell(rod, self, row), part, slope->couple_by[k], block, next);
      PetscCall(MatSetValuesBlocked(J, 1, &after, 4, column, next, ADD_VALUES));
    }
    PetscCall(MatSetValuesBlocked(J, 1, &row, 4, column, block, ADD_VALUES));
  }
  PetscFunctionReturn(0);
}

/* StrandRowsJacobian - adds to J, whose other values are set, the derivatives of the forces of
   contact, in the state of the latest load; StrandRowsCell() is known of all owned nodes.
   Collective. */
PetscErrorCode StrandRowsJacobian(Rod rod, StrandRows self, const RodState *at, Mat J) {
  StrandSlope *slopes;
  StrandState state;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(MatAssemblyBegin(J, MAT_FLUSH_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FLUSH_ASSEMBLY));
  PetscCall(OpenState(self, at, &state));
  PetscCall(StrandsLinearise(self->strands, &state, at->shift, at->fresh, &n, &slopes));
  for (PetscInt c = 0; c < n; c++)
    for (int k = 0; k < slopes[c].takers; k++) PetscCall(AddTaker(rod, self, &slopes[c], k, J));
  PetscCall(CoupledClose(self->coupled, at->U, at->U_t));
  PetscFunctionReturn(0);
}
