#include "rod/learned.h"
#include "base/clones.h"
#include <string.h>

/* By what part of a turn the law bends a straight rod, as long as it becomes, towards x2 and x3. */
static void FindDrive(Rod rod) {
  const Tropism *law = &rod->scene->tropism;
  const PetscReal clamp[3] = {0};
  PetscReal pull[3] = {0};

  if (law->senses) TropismPull(law, clamp, pull, NULL);
  for (int d = 0; d < 2; d++)
    rod->learned->drive[d] =
        rod->scene->reach * (PetscAbsReal(pull[1 + d]) + PetscAbsReal(law->nutation[d]));
}

/* LearnedCreate - for a rod whose model has such states, behind so many unknowns of its mechanics:
   lead, and the extra ones of growth that feels force. */
PetscErrorCode LearnedCreate(Rod rod, PetscInt lead, PetscInt extra, PetscInt bends) {
  const Tropism *law = &rod->scene->tropism;
  const PetscInt nodes = rod->end - rod->first + 2, places = 2 * nodes, mech = lead + extra;
  Learned self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  rod->learned = self;
  self->lead = lead;
  self->extra = extra;
  self->mech = mech;
  self->bends = bends;
  self->per = (rod->model->fields - mech) / 2;
  self->remembers = (PetscBool)(self->per > bends);
  self->at_tip = law->at_tip;
  FindDrive(rod);
  PetscCall(PetscCalloc4(nodes * mech, &self->u, nodes * mech, &self->u_t, places * self->per,
                         &self->k, places * self->per, &self->k_t));
  PetscCall(PetscCalloc4(places * bends, &self->given, places, &self->clock, nodes * mech,
                         &self->row, places * self->per, &self->rows));
  PetscCall(PetscCalloc4(nodes * extra, &self->w, nodes * extra, &self->w_t, nodes * extra,
                         &self->w_row, places * bends, &self->drives));
  PetscCall(PetscCalloc2(nodes, &self->node, nodes, &self->cell));
  PetscCall(PetscCalloc5(nodes * mech, &self->b, nodes * mech, &self->x, places * self->per,
                         &self->free, places * self->per, &self->rhs, nodes * mech, &self->beside));
  for (int b = 0; b < TROPISM_BENDS; b++)
    PetscCall(PetscCalloc1(self->at_tip ? nodes * mech : 0, &self->border[b]));
  PetscFunctionReturn(0);
}

PetscErrorCode LearnedDestroy(Rod rod) {
  Learned self = rod->learned;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(PetscFree4(self->u, self->u_t, self->k, self->k_t));
  PetscCall(PetscFree4(self->given, self->clock, self->row, self->rows));
  PetscCall(PetscFree4(self->w, self->w_t, self->w_row, self->drives));
  PetscCall(PetscFree2(self->node, self->cell));
  PetscCall(PetscFree5(self->b, self->x, self->free, self->rhs, self->beside));
  for (int b = 0; b < TROPISM_BENDS; b++) PetscCall(PetscFree(self->border[b]));
  PetscCall(PetscFree(self->label));
  PetscCall(PetscFree(self->over));
  PetscCall(PetscFree(rod->learned));
  PetscFunctionReturn(0);
}

/* The place where the last node has the tip's own signal. */
static PetscInt SignalPlace(const Rod rod) {
  return 2 * (rod->last - rod->first + 1) + 1;
}

/* LearnedBegin - the signal of a tip that remembers nothing is what it senses at the start, too.
   Collective. */
PetscErrorCode LearnedBegin(Rod rod, Vec U) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields;
  RodState at = {.t = 0, .U = U};
  PetscScalar *u;
  Vec F;

  PetscFunctionBegin;
  if (!self->at_tip || rod->scene->tropism.memory > 0) PetscFunctionReturn(0);
  PetscCall(VecDuplicate(U, &at.U_t));
  PetscCall(VecDuplicate(U, &F));
  PetscCall(VecZeroEntries(at.U_t));
  PetscCall(rod->model->residual(rod, &at, F));
  PetscCall(VecGetArray(U, &u));
  for (PetscInt b = 0; b < self->bends && rod->end > rod->last; b++)
    u[(rod->last - rod->first) * fields + self->mech + self->per + b] -=
        self->rows[SignalPlace(rod) * self->per + b];
  PetscCall(VecRestoreArray(U, &u));
  PetscCall(VecDestroy(&at.U_t));
  PetscCall(VecDestroy(&F));
  PetscFunctionReturn(0);
}

/* LearnedScale - what a change of a state is measured against is no less than the bend that turns
   the whole rod by what its turns are measured against. */
void LearnedScale(Rod rod, PetscReal scale[]) {
  const RodModel *model = rod->model;
  const PetscInt mech = rod->learned->mech;

  for (PetscInt f = mech; f < model->fields; f++)
    for (PetscInt turn = 0; turn < mech; turn++) {
      const char name = model->field[turn][0];
      const PetscReal angle = name == 't' ? 1 : name == 'p' ? 2 : 0;
      if (model->group[turn] == model->group[f])
        scale[f] = PetscMax(scale[f], angle * scale[turn] / rod->scene->reach);
    }
}

/* Mechanics and states of the nodes first - 1 .. end of a vector, apart; states NULL: not these. w:
   the extra unknowns go there; NULL: they stay behind the others. */
static PetscErrorCode Part(Rod rod, Vec V, PetscReal *mech, PetscReal *w, PetscReal *states) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields, from = PetscMax(rod->first - 1, 0),
                 to = PetscMin(rod->end, rod->last), lead = w ? self->lead : self->mech;
  const PetscReal *v;
  Vec local;

  PetscFunctionBegin;
  PetscCall(RodOpen(rod, V, &local, &v));
  for (PetscInt i = from; i <= to; i++) {
    const PetscInt n = i - rod->first + 1;
    memcpy(mech + n * lead, v + i * fields, (size_t)lead * sizeof(*v));
    if (w && self->extra)
      memcpy(w + n * self->extra, v + i * fields + lead, (size_t)self->extra * sizeof(*v));
    if (states)
      memcpy(states + 2 * n * self->per, v + i * fields + self->mech,
             2 * (size_t)self->per * sizeof(*v));
  }
  PetscCall(RodClose(rod, &local, &v));
  PetscFunctionReturn(0);
}

/* What the last rank has of a signal, to all. */
static PetscErrorCode FromLastRank(const Rod rod, PetscReal signal[]) {
  PetscMPIInt ranks;

  PetscFunctionBegin;
  if (rod->alone) PetscFunctionReturn(0);
  PetscCallMPI(MPI_Comm_size(rod->scene->comm, &ranks));
  PetscCallMPI(MPI_Bcast(signal, TROPISM_BENDS, MPIU_REAL, ranks - 1, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* ... among its states. */
static PetscErrorCode ShareSignal(Rod rod, const PetscReal *states, PetscReal signal[]) {
  PetscFunctionBegin;
  if (!rod->learned->at_tip) PetscFunctionReturn(0);
  if (rod->end > rod->last)
    memcpy(signal, states + SignalPlace(rod) * rod->learned->per,
           (size_t)rod->learned->bends * sizeof(*signal));
  PetscCall(FromLastRank(rod, signal));
  PetscFunctionReturn(0);
}

/* Is a place that where material comes in? */
static PetscBool IsBorn(const Rod rod, PetscInt place) {
  return (PetscBool)(rod->learned->born && place == 2);
}

/* LearnedFront - does a front go along the rod, between what was there at first and what has come
   in, in which what is learned has a corner? */
PetscBool LearnedFront(const Rod rod) {
  const Growth growth = rod->scene->growth;

  return (PetscBool)(rod->learned && growth->slides && !growth->rests);
}

/* LearnedOpen - takes a state and its rates apart. Collective. */
PetscErrorCode LearnedOpen(Rod rod, const RodState *at) {
  Learned self = rod->learned;

  PetscFunctionBegin;
  PetscCall(Part(rod, at->U, self->u, self->w, self->k));
  PetscCall(Part(rod, at->U_t, self->u_t, self->w_t, self->k_t));
  self->born = (PetscBool)(rod->first == 0 && rod->scene->growth->slides &&
                           GrowthSpeed(rod->scene->growth, 0, at->t, 0) > 0);
  PetscCall(ShareSignal(rod, self->k, self->signal));
  PetscCall(ShareSignal(rod, self->k_t, self->signal_t));
  for (int b = 0; b < TROPISM_BENDS; b++)
    self->nutation[b] = TropismNutation(&rod->scene->tropism, b, at->t);
  PetscFunctionReturn(0);
}

/* LearnedFill - an array for the residual of the mechanics, indexed by node; that of states is
   beside it. */
PetscErrorCode LearnedFill(Rod rod, void *array) {
  Learned self = rod->learned;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(self->rows, 2 * (rod->end - rod->first + 2) * self->per));
  *(PetscReal **)array = self->row - rod->first * self->lead;
  PetscFunctionReturn(0);
}

/* LearnedFilled - both are those of F. */
PetscErrorCode LearnedFilled(Rod rod, Vec F) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields;
  PetscReal *f;

  PetscFunctionBegin;
  if (rod->end > rod->last && !self->at_tip) /* places that are none: they stay 0 */
    PetscCall(PetscArraycpy(self->rows + SignalPlace(rod) * self->per,
                            self->k + SignalPlace(rod) * self->per, self->per));
  PetscCall(VecGetArrayWrite(F, (PetscScalar **)&f));
  for (PetscInt n = 0; n < rod->end - rod->first; n++) {
    memcpy(f + n * fields, self->row + n * self->lead, (size_t)self->lead * sizeof(*f));
    memcpy(f + n * fields + self->lead, self->w_row + (n + 1) * self->extra,
           (size_t)self->extra * sizeof(*f));
    memcpy(f + n * fields + self->mech, self->rows + 2 * (n + 1) * self->per,
           2 * (size_t)self->per * sizeof(*f));
  }
  PetscCall(VecRestoreArrayWrite(F, (PetscScalar **)&f));
  PetscFunctionReturn(0);
}

/* LearnedResidual - that of the states of a place: Dk/Dt - a (f - G u + I m/B + nutation), and
   T Df/Dt + f - S. */
void LearnedResidual(Rod rod, PetscInt place, const LearnedPoint *point) {
  Learned self = rod->learned;
  const Tropism *law = &rod->scene->tropism;
  const PetscReal *k = self->k + place * self->per, *k_t = self->k_t + place * self->per;
  PetscReal *row = self->rows + place * self->per;

  for (PetscInt c = 0; c < self->per && IsBorn(rod, place); c++) row[c] = k[c];
  if (IsBorn(rod, place)) return;
  for (PetscInt b = 0; b < self->bends; b++) {
    const PetscReal f = self->at_tip      ? self->signal[b]
                        : self->remembers ? k[self->bends + b]
                                          : point->sensed[b];
    const PetscReal drive =
        TropismDrive(law, f, point->natural[b], point->elastic[b], self->nutation[b]);
    self->drives[place * self->bends + b] = drive;
    row[b] = k_t[b] - self->clock[place] * drive;
    if (self->remembers)
      row[self->bends + b] = law->memory * k_t[self->bends + b] + f - point->sensed[b];
  }
}

/* LearnedSignalResidual - of the tip's signal. */
void LearnedSignalResidual(Rod rod, const PetscReal sensed[]) {
  Learned self = rod->learned;

  for (PetscInt b = 0; b < self->bends; b++)
    self->rows[SignalPlace(rod) * self->per + b] =
        rod->scene->tropism.memory * self->signal_t[b] + self->signal[b] - sensed[b];
}

/* ---- what a linear solve eliminates ---- */

/* The row of a place from its slopes; shift: of its first state. n, bends: as in LearnedCreate(),
   here and below, where the compiler knows them. */
ALWAYS_INLINE void MakeRow(const Rod rod, PetscInt place, const LearnedSlope *slope,
                           const PetscReal shift[], PetscInt n, PetscInt bends, LearnedRow *row) {
  const Learned self = rod->learned;
  const Tropism *law = &rod->scene->tropism;
  const PetscReal a = self->clock[place];

  if (IsBorn(rod, place)) {
    *row = (LearnedRow){.own = {1, 1}, .own_memory = {1, 1}};
    return;
  }
  row->clock = a;
  for (PetscInt b = 0; b < bends; b++) {
    const PetscReal memory = self->remembers ? 1 + law->memory * shift[bends + b] : 1,
                    own = shift[b] + a * law->proprioception,
                    senses = self->at_tip ? 0 : a / (own * memory),
                    gives = a / own * (law->ironing - law->proprioception);
    row->own[b] = own;
    row->own_memory[b] = memory;
    row->signal[b] = self->at_tip ? a / own : 0;
    for (PetscInt f = 0; f < n; f++)
      row->by[b][f] = senses * slope->sensed[b][f] + gives * slope->elastic[b][f];
  }
  if (self->remembers) memcpy(row->sensed, slope->sensed, sizeof(row->sensed));
}

/* LearnedNodeSlope - that of node i: before the cells beside it are condensed. shift: of all
   fields. */
void LearnedNodeSlope(Rod rod, PetscInt i, const LearnedSlope *slope, const PetscReal shift[]) {
  const PetscInt at = i - rod->first + 1;
  LearnedRow *row = &rod->learned->node[at];

  if (rod->learned->mech == LINE_FIELDS)
    MakeRow(rod, 2 * at, slope, shift + LINE_FIELDS, LINE_FIELDS, 1, row);
  else if (rod->learned->extra)
    MakeRow(rod, 2 * at, slope, shift + rod->learned->mech, rod->learned->mech, 1, row);
  else
    MakeRow(rod, 2 * at, slope, shift + WIDE_FIELDS, WIDE_FIELDS, TROPISM_BENDS, row);
}

/* y += s x, of the mechanics' unknowns. */
ALWAYS_INLINE void Add(PetscInt n, PetscReal s, const PetscReal x[], PetscReal y[]) {
  for (PetscInt f = 0; f < n; f++) y[f] += s * x[f];
}

ALWAYS_INLINE PetscReal Times(PetscInt n, const PetscReal x[], const PetscReal y[]) {
  PetscReal sum = 0;

  for (PetscInt f = 0; f < n; f++) sum += x[f] * y[f];
  return sum;
}

/* J += column row, of n unknowns. */
ALWAYS_INLINE void AddOuter(PetscInt n, const PetscReal column[], const PetscReal row[],
                            PetscReal *J) {
  for (PetscInt i = 0; i < n; i++)
    if (column[i] != 0)
      for (PetscInt j = 0; j < n; j++) J[i * n + j] += column[i] * row[j];
}

/* The bends in the middle of a cell by the unknowns and the bends at both ends. */
ALWAYS_INLINE void MakeMid(const Rod rod, PetscInt place, const LearnedCell *cell,
                           const PetscReal shift[], PetscInt n, PetscInt bends,
                           LearnedFactor *factor) {
  const Learned self = rod->learned;
  LearnedRow *row = &factor->at_mid;

  MakeRow(rod, place, &cell->slope[1], shift + n + self->per, n, bends, row);
  for (PetscInt b = 0; b < bends; b++)
    for (int e = 0; e < 2; e++) {
      memset(factor->mid[e][b], 0, sizeof(factor->mid[e][b]));
      for (PetscInt f = 0; f < n; f++)
        if (row->by[b][f] != 0) Add(n, row->by[b][f], cell->by_node[e][f], factor->mid[e][b]);
      for (PetscInt c = 0; c < bends; c++)
        factor->chain[e][b][c] = Times(n, row->by[b], cell->by_bend[e][c]);
      if (!self->remembers) continue;
      memset(factor->sensed[e][b], 0, sizeof(factor->sensed[e][b]));
      for (PetscInt f = 0; f < n; f++)
        Add(n, row->sensed[b][f], cell->by_node[e][f], factor->sensed[e][b]);
      for (PetscInt c = 0; c < bends; c++)
        factor->sensed_chain[e][b][c] = Times(n, row->sensed[b], cell->by_bend[e][c]);
    }
}

ALWAYS_INLINE void Condense(Rod rod, PetscInt i, const LearnedCell *cell, const PetscReal shift[],
                            PetscInt n, PetscInt bends, PetscReal *left, PetscReal *right) {
  const Learned self = rod->learned;
  const PetscInt at = i - rod->first + 1;
  LearnedFactor *factor = &self->cell[at];
  PetscReal *const J[2] = {left, right};

  MakeMid(rod, 2 * at + 1, cell, shift, n, bends, factor);
  memcpy(factor->column, cell->column, sizeof(factor->column));
  for (int e = 0; e < 2; e++) {
    const LearnedRow *end = &self->node[at + e];
    for (PetscInt b = 0; b < bends; b++) {
      PetscReal mid[LEARNED_MOST];
      memcpy(mid, factor->mid[e][b], sizeof(mid));
      for (PetscInt c = 0; c < bends; c++) Add(n, factor->chain[e][b][c], end->by[c], mid);
      AddOuter(n, cell->column[2 * e][b], end->by[b], J[e]);
      AddOuter(n, cell->column[1][b], mid, J[e]);
    }
  }
}

/*
  LearnedCondense - adds to the derivatives of the equations of the cell behind node i by its nodes
  what comes of the bends learned in it: with dk = free + by.d,

    dF/dy += dF/dk by,   and off the right-hand side goes dF/dk free (LearnedSolve()).
*/
void LearnedCondense(Rod rod, PetscInt i, const LearnedCell *cell, const PetscReal shift[],
                     PetscReal *left, PetscReal *right) {
  if (rod->learned->mech == LINE_FIELDS)
    Condense(rod, i, cell, shift, LINE_FIELDS, 1, left, right); /* (the compiler unrolls it) */
  else
    Condense(rod, i, cell, shift, WIDE_FIELDS, TROPISM_BENDS, left, right);
}

/* LearnedRows - what LearnedCondense() finds of the middle of a cell, for LearnedMatrix(). */
void LearnedRows(Rod rod, PetscInt i, const LearnedCell *cell, const PetscReal shift[]) {
  const PetscInt at = i - rod->first + 1;

  MakeMid(rod, 2 * at + 1, cell, shift, rod->learned->mech, rod->learned->bends,
          &rod->learned->cell[at]);
}

/* LearnedSignalSlope - of the tip's signal by the last node's unknowns. */
void LearnedSignalSlope(Rod rod, const LearnedSlope *slope, const PetscReal shift[]) {
  Learned self = rod->learned;

  for (PetscInt b = 0; b < self->bends; b++) {
    const PetscReal own = 1 + rod->scene->tropism.memory * shift[self->mech + self->per + b];
    self->tip_own[b] = own;
    for (PetscInt f = 0; f < self->mech; f++) self->tip[b][f] = slope->sensed[b][f] / own;
  }
}

/* LearnedCondensed - all cells are, and the mechanics eliminated. */
void LearnedCondensed(Rod rod, Elimination elimination) {
  rod->learned->elimination = elimination;
  rod->learned->bordered = PETSC_FALSE;
}

/* free of the states of all places of this rank, from a right-hand side taken apart. */
static void FreeOf(const Rod rod, const PetscReal *b) {
  const Learned self = rod->learned;
  const PetscInt from = PetscMax(rod->first - 1, 0), to = PetscMin(rod->end, rod->last);

  for (PetscInt i = from; i <= to; i++)
    for (int half = 0; half < 2 && (!half || i < to); half++) {
      const PetscInt at = i - rod->first + 1, place = 2 * at + half;
      const LearnedRow *row = half ? &self->cell[at].at_mid : &self->node[at];
      for (PetscInt c = 0; c < self->bends; c++) {
        const PetscReal *rhs = b + place * self->per;
        PetscReal sum = rhs[c];
        if (self->remembers) sum += row->clock * rhs[self->bends + c] / row->own_memory[c];
        self->free[place * self->per + c] = sum / row->own[c];
      }
    }
}

/* r -= dF/dk of a cell times bends at a, in its middle and at b, those of the ends by the chain,
   too. */
static void CellTimes(const Learned self, const LearnedFactor *factor, const PetscReal *a,
                      const PetscReal *mid, const PetscReal *b, PetscReal r[]) {
  const PetscReal *end[2] = {a, b};

  for (PetscInt c = 0; c < self->bends; c++) {
    PetscReal in = mid[c];
    for (int e = 0; e < 2; e++) {
      Add(self->mech, -end[e][c], factor->column[2 * e][c], r);
      for (PetscInt d = 0; d < self->bends; d++) in += factor->chain[e][c][d] * end[e][d];
    }
    Add(self->mech, -in, factor->column[1][c], r);
  }
}

/* The rows of a cell are those of the node behind it and of the one before it. */
static void PutCell(const Rod rod, PetscInt i, const PetscReal r[], PetscReal *b) {
  const Learned self = rod->learned;
  const PetscInt half = rod->model->halves[0], n = i - rod->first;

  if (i >= rod->first) Add(self->mech - half, 1, r + half, b + n * self->mech + half);
  if (i + 1 < rod->end) Add(half, 1, r, b + (n + 1) * self->mech);
}

/* b, of owned nodes, less what states do by themselves. */
static void Fold(const Rod rod, PetscReal *b) {
  const Learned self = rod->learned;

  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    const PetscInt at = i - rod->first + 1;
    const PetscReal *k = self->free + 2 * at * self->per;
    PetscReal r[LEARNED_MOST] = {0};
    CellTimes(self, &self->cell[at], k, k + self->per, k + 2 * self->per, r);
    PutCell(rod, i, r, b);
  }
}

/* w, what a signal of 1 does to the equations of the owned nodes. */
static void BorderOf(const Rod rod, PetscInt bend, PetscReal *w) {
  const Learned self = rod->learned;

  memset(w, 0, (size_t)((rod->end - rod->first) * self->mech) * sizeof(*w));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    const PetscInt at = i - rod->first + 1;
    PetscReal k[3][TROPISM_BENDS] = {{0}}, r[LEARNED_MOST] = {0};
    k[0][bend] = self->node[at].signal[bend];
    k[1][bend] = self->cell[at].at_mid.signal[bend];
    k[2][bend] = self->node[at + 1].signal[bend];
    CellTimes(self, &self->cell[at], k[0], k[1], k[2], r);
    PutCell(rod, i, r, w);
  }
}

/* What the tip's signal would be by an owned part of the unknowns; on all ranks. */
static PetscErrorCode SignalBy(const Rod rod, const PetscReal *x, PetscReal signal[]) {
  const Learned self = rod->learned;

  PetscFunctionBegin;
  signal[0] = signal[1] = 0;
  for (PetscInt b = 0; b < self->bends && rod->end > rod->last; b++)
    signal[b] = Times(self->mech, self->tip[b], x + (rod->last - rod->first) * self->mech);
  PetscCall(FromLastRank(rod, signal));
  PetscFunctionReturn(0);
}

static PetscErrorCode SolveMechanics(const Learned self, const PetscReal *b, PetscReal *x) {
  PetscFunctionBegin;
  PetscCall(EliminationSolve(self->elimination, (const PetscReal(*)[LINE_FIELDS])b,
                             (PetscReal(*)[LINE_FIELDS])x));
  PetscFunctionReturn(0);
}

/*
  Border - the signal sees the tip, and all of the rod sees the signal: with d(signal) = free + v.d,

    (J - w v) d = b + w free,   d = y + z c,  J y = b + w free, J z = w,  (1 - v z) c = v y.
*/
static PetscErrorCode Border(const Rod rod) {
  const Learned self = rod->learned;
  PetscReal M[TROPISM_BENDS][TROPISM_BENDS] = {{1, 0}, {0, 1}}, signal[TROPISM_BENDS], det;

  PetscFunctionBegin;
  for (PetscInt b = 0; b < self->bends; b++) {
    BorderOf(rod, b, self->b);
    PetscCall(SolveMechanics(self, self->b, self->border[b]));
    PetscCall(SignalBy(rod, self->border[b], signal));
    for (PetscInt c = 0; c < self->bends; c++) M[c][b] -= signal[c];
  }
  det = M[0][0] * M[1][1] - M[0][1] * M[1][0];
  self->inverse[0][0] = M[1][1] / det;
  self->inverse[1][1] = M[0][0] / det;
  self->inverse[0][1] = -M[0][1] / det;
  self->inverse[1][0] = -M[1][0] / det;
  self->bordered = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* x of the mechanics, from b folded; rhs: of the signal, on exit how that changes. */
static PetscErrorCode SolveBordered(const Rod rod, PetscReal signal[]) {
  const Learned self = rod->learned;
  const PetscInt n = (rod->end - rod->first) * self->mech;
  PetscReal by[TROPISM_BENDS], c[TROPISM_BENDS];

  PetscFunctionBegin;
  PetscCall(SolveMechanics(self, self->b, self->x));
  if (!self->at_tip) PetscFunctionReturn(0);
  for (PetscInt b = 0; b < self->bends; b++) Add(n, signal[b], self->border[b], self->x);
  PetscCall(SignalBy(rod, self->x, by));
  for (PetscInt b = 0; b < self->bends; b++) {
    c[b] = self->inverse[b][0] * by[0] + self->inverse[b][1] * by[1];
    Add(n, c[b], self->border[b], self->x);
    signal[b] += c[b];
  }
  PetscFunctionReturn(0);
}

/* The states of node i, once the mechanics of it are known. */
static void UnfoldNode(const Rod rod, PetscInt i, const PetscReal signal[], PetscReal *k) {
  const Learned self = rod->learned;
  const PetscInt at = i - rod->first + 1, n = self->mech, per = self->per;
  const LearnedRow *row = &self->node[at];
  const PetscReal *x = self->beside + at * n, *rhs = self->rhs + 2 * at * per;

  for (PetscInt b = 0; b < self->bends; b++) {
    k[b] = self->free[2 * at * per + b] + Times(n, row->by[b], x) + row->signal[b] * signal[b];
    if (self->remembers)
      k[self->bends + b] =
          (rhs[self->bends + b] + Times(n, row->sensed[b], x)) / row->own_memory[b];
  }
}

/* ... in the middle of the cell behind it, between those, k[0] and k[2]. */
static void UnfoldMid(const Rod rod, PetscInt i, const PetscReal signal[], PetscReal *k) {
  const Learned self = rod->learned;
  const PetscInt at = i - rod->first + 1, place = 2 * at + 1, n = self->mech, per = self->per;
  const LearnedFactor *cell = &self->cell[at];
  const PetscReal *rhs = self->rhs + place * per,
                  *x[2] = {self->beside + at * n, self->beside + (at + 1) * n},
                  *end[2] = {k, k + 2 * per};
  PetscReal *mid = k + per;

  for (PetscInt b = 0; b < self->bends; b++) {
    PetscReal sensed = 0;
    mid[b] = self->free[place * per + b] + cell->at_mid.signal[b] * signal[b];
    for (int e = 0; e < 2; e++) {
      mid[b] += Times(n, cell->mid[e][b], x[e]);
      for (PetscInt c = 0; c < self->bends; c++) mid[b] += cell->chain[e][b][c] * end[e][c];
      if (!self->remembers) continue;
      sensed += Times(n, cell->sensed[e][b], x[e]);
      for (PetscInt c = 0; c < self->bends; c++) sensed += cell->sensed_chain[e][b][c] * end[e][c];
    }
    if (self->remembers)
      mid[self->bends + b] = (rhs[self->bends + b] + sensed) / cell->at_mid.own_memory[b];
  }
}

/* Writes owned mechanics, or states of places, into a vector. */
static PetscErrorCode Put(Rod rod, const PetscReal *mech, const PetscReal *states, Vec V) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields;
  PetscReal *v;

  PetscFunctionBegin;
  PetscCall(VecGetArray(V, (PetscScalar **)&v));
  for (PetscInt n = 0; n < rod->end - rod->first; n++) {
    if (mech) memcpy(v + n * fields, mech + n * self->mech, (size_t)self->mech * sizeof(*v));
    if (states)
      memcpy(v + n * fields + self->mech, states + 2 * (n + 1) * self->per,
             2 * (size_t)self->per * sizeof(*v));
  }
  PetscCall(VecRestoreArray(V, (PetscScalar **)&v));
  PetscFunctionReturn(0);
}

/* LearnedSolve - x of J x = b for what was condensed and eliminated last. Collective. */
PetscErrorCode LearnedSolve(Rod rod, Vec b, Vec x) {
  const Learned self = rod->learned;
  const PetscInt from = PetscMax(rod->first - 1, 0), to = PetscMin(rod->end, rod->last),
                 owned = (rod->end - rod->first) * self->mech;
  PetscReal signal[TROPISM_BENDS] = {0}, *k = self->free;

  PetscFunctionBegin;
  if (self->at_tip && !self->bordered) PetscCall(Border(rod));
  PetscCall(Part(rod, b, self->beside, NULL, self->rhs));
  for (PetscInt c = 0; c < self->bends && self->at_tip && rod->end > rod->last; c++)
    self->rhs[SignalPlace(rod) * self->per + c] /= self->tip_own[c];
  PetscCall(ShareSignal(rod, self->rhs, signal));
  FreeOf(rod, self->rhs);
  PetscCall(PetscArraycpy(self->b, self->beside + self->mech, owned));
  Fold(rod, self->b);
  PetscCall(SolveBordered(rod, signal));
  PetscCall(Put(rod, self->x, NULL, x));
  PetscCall(Part(rod, x, self->beside, NULL, NULL));
  for (PetscInt i = from; i <= to; i++)
    UnfoldNode(rod, i, signal, k + 2 * (i - rod->first + 1) * self->per);
  for (PetscInt i = from; i < to; i++)
    UnfoldMid(rod, i, signal, k + 2 * (i - rod->first + 1) * self->per);
  if (rod->end > rod->last)
    memcpy(k + SignalPlace(rod) * self->per,
           self->at_tip ? signal : self->rhs + SignalPlace(rod) * self->per,
           (size_t)self->bends * sizeof(*k));
  PetscCall(Put(rod, NULL, k, x));
  PetscFunctionReturn(0);
}

static PetscErrorCode SetUp(PC pc) {
  Rod rod;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &rod));
  PetscCall(PCSetFailedReason(pc, EliminationRegular(rod->learned->elimination)
                                      ? PC_NOERROR
                                      : PC_FACTOR_NUMERIC_ZEROPIVOT));
  PetscFunctionReturn(0);
}

static PetscErrorCode Apply(PC pc, Vec b, Vec x) {
  Rod rod;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &rod));
  PetscCall(LearnedSolve(rod, b, x));
  PetscFunctionReturn(0);
}

/* LearnedSetType - makes a PC the exact solver of what has been condensed when it is set up; the
   rod must outlive it. */
PetscErrorCode LearnedSetType(PC pc, Rod rod, Elimination elimination) {
  PetscFunctionBegin;
  PetscCall(EliminationSetType(pc, elimination));
  PetscCall(PCShellSetContext(pc, rod));
  PetscCall(PCShellSetSetUp(pc, SetUp));
  PetscCall(PCShellSetApply(pc, Apply));
  PetscFunctionReturn(0);
}

/* LearnedGet - what owned nodes, and the middles of the cells behind them, have learned, and what
   they go by. Collective. */
PetscErrorCode LearnedGet(Rod rod, Vec U, Node *nodes) {
  const Learned self = rod->learned;
  PetscReal signal[TROPISM_BENDS] = {0}, *states = self->rhs;

  PetscFunctionBegin;
  PetscCall(Part(rod, U, self->beside, NULL, states));
  PetscCall(ShareSignal(rod, states, signal));
  for (PetscInt i = rod->first; i < rod->end; i++)
    for (int half = 0; half < 2; half++)
      for (PetscInt b = 0; b < self->bends; b++) {
        const PetscReal *k = states + (2 * (i - rod->first + 1) + half) * self->per;
        NodeLearned *learned = &nodes[i - rod->first].learned[half];
        learned->bend[b] = half && i == rod->last ? 0 : k[b];
        learned->signal[b] = self->at_tip ? signal[b] : self->remembers ? k[self->bends + b] : 0;
      }
  PetscFunctionReturn(0);
}

/* LearnedSet - a state that has learned what nodes say; the tip's signal is what the last of them
   says. */
PetscErrorCode LearnedSet(Rod rod, const Node *nodes, Vec U) {
  const Learned self = rod->learned;
  PetscReal *states = self->rhs;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(states, 2 * (rod->end - rod->first + 2) * self->per));
  for (PetscInt i = rod->first; i < rod->end; i++)
    for (int half = 0; half < 2; half++)
      for (PetscInt b = 0; b < self->bends; b++) {
        PetscReal *k = states + (2 * (i - rod->first + 1) + half) * self->per;
        const NodeLearned *learned = &nodes[i - rod->first].learned[half];
        const PetscBool ends = (PetscBool)(half && i == rod->last);
        k[b] = !ends ? learned->bend[b] : self->at_tip ? learned->signal[b] : 0;
        if (self->remembers && !ends) k[self->bends + b] = learned->signal[b];
      }
  PetscCall(Put(rod, NULL, states, U));
  PetscFunctionReturn(0);
}

/* ---- material that slides past the labels ---- */

/* The labels of places, two a node; that behind the tip is none. */
static PetscReal Label(const Rod rod, PetscInt place) {
  const PetscReal *s = rod->scene->mesh.s;

  return place % 2 ? (s[place / 2] + s[place / 2 + 1]) / 2 : s[place / 2];
}

/* Beyond the clamp of a rod that is fed the field goes on oddly: what is fed in has learned
   nothing. Arrays of places have so many before the first. */
enum { STENCIL = LEARNED_STENCIL, BEYOND = STENCIL / 2 - 1 };

static void GoOnOddly(PetscInt width, PetscReal *first) {
  for (PetscInt k = 1; k <= BEYOND; k++)
    for (PetscInt c = 0; c < width; c++) first[-k * width + c] = -first[k * width + c];
}

/* What the weights of places first .. first + STENCIL - 1 are divided by, for all first places from
   -BEYOND on. */
static void FindDivisors(const PetscReal *label, PetscInt last, PetscReal (*over)[STENCIL]) {
  for (PetscInt first = -BEYOND; first + STENCIL <= last + 1; first++)
    for (int i = 0; i < STENCIL; i++) {
      PetscReal product = 1;
      for (int j = 0; j < STENCIL; j++)
        if (j != i) product *= label[first + i] - label[first + j];
      over[first + BEYOND][i] = 1 / product;
    }
}

/* The weights of places for a value at a label, by the labels of these. */
static void Weights(const PetscReal label[STENCIL], const PetscReal over[STENCIL], PetscReal at,
                    PetscReal w[STENCIL]) {
  PetscReal away[STENCIL], before = 1, behind = 1;

  for (int i = 0; i < STENCIL; i++) {
    away[i] = at - label[i];
    w[i] = over[i] * before;
    before *= away[i];
  }
  for (int i = STENCIL - 1; i >= 0; i--) {
    w[i] *= behind;
    behind *= away[i];
  }
}

/* The labels of all places, and what goes with them: once, for the mesh stays. */
static PetscErrorCode FindLabels(Rod rod) {
  Learned self = rod->learned;
  const PetscInt last = 2 * rod->last;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(BEYOND + last + 1, &self->label));
  PetscCall(PetscMalloc1((last + 1) * STENCIL, (PetscReal **)&self->over));
  for (PetscInt i = 0; i <= last; i++) self->label[BEYOND + i] = Label(rod, i);
  GoOnOddly(1, self->label + BEYOND);
  FindDivisors(self->label + BEYOND, last, self->over);
  PetscFunctionReturn(0);
}

/* LearnedGather - so many numbers of each node, of which a rank has put those of its own into their
   place, to all ranks. Collective. */
PetscErrorCode LearnedGather(Rod rod, PetscInt width, PetscReal *all) {
  const PetscMPIInt mine[2] = {(PetscMPIInt)((rod->end - rod->first) * width),
                               (PetscMPIInt)(rod->first * width)};
  PetscMPIInt ranks, *many, *from;

  PetscFunctionBegin;
  if (rod->alone) PetscFunctionReturn(0);
  PetscCallMPI(MPI_Comm_size(rod->scene->comm, &ranks));
  PetscCall(PetscMalloc2(ranks, &many, ranks, &from));
  PetscCallMPI(MPI_Allgather(&mine[0], 1, MPI_INT, many, 1, MPI_INT, rod->scene->comm));
  PetscCallMPI(MPI_Allgather(&mine[1], 1, MPI_INT, from, 1, MPI_INT, rod->scene->comm));
  PetscCallMPI(MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, all, many, from, MPIU_REAL,
                              rod->scene->comm));
  PetscCall(PetscFree2(many, from));
  PetscFunctionReturn(0);
}

/* All places of a vector's states, node after node, on every rank; and those beyond the clamp. */
static PetscErrorCode AllStates(Rod rod, Vec V, PetscReal *all) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields, width = 2 * self->per;
  const PetscScalar *v;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(V, &v));
  for (PetscInt i = 0; i < rod->end - rod->first; i++)
    for (PetscInt f = 0; f < width; f++)
      all[(rod->first + i) * width + f] = PetscRealPart(v[i * fields + self->mech + f]);
  PetscCall(VecRestoreArrayRead(V, &v));
  PetscCall(LearnedGather(rod, width, all));
  GoOnOddly(self->per, all);
  PetscFunctionReturn(0);
}

/* LearnedKeepWay - before a step: where growth feels force, which way the material has come is that
   of the states that the step goes on from, the latest first. Collective. */
PetscErrorCode LearnedKeepWay(Rod rod, PetscInt m, const PetscReal times[], const Vec points[]) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields, n = rod->last + 1;
  PetscReal *all, *speed, *length;
  const PetscScalar *v;

  PetscFunctionBegin;
  if (!self->extra) PetscFunctionReturn(0);
  PetscCall(PetscMalloc3(2 * n, &all, m * n, &speed, m, &length));
  for (PetscInt j = 0; j < m; j++) {
    PetscCall(VecGetArrayRead(points[j], &v));
    for (PetscInt i = 0; i < rod->end - rod->first; i++)
      for (int f = 0; f < 2; f++)
        all[2 * (rod->first + i) + f] = PetscRealPart(v[i * fields + self->lead + f]);
    PetscCall(VecRestoreArrayRead(points[j], &v));
    PetscCall(LearnedGather(rod, 2, all));
    for (PetscInt i = 0; i < n; i++) speed[j * n + i] = all[2 * i];
    length[j] = all[2 * n - 1];
  }
  PetscCall(GrowthYieldKeep(rod->scene->growth, m, times, length, n, rod->scene->mesh.s, speed));
  PetscCall(PetscFree3(all, speed, length));
  PetscFunctionReturn(0);
}

/* The states of one place where the material was that is at a label. place: one at or before it,
   where to look; least: the first place there is, below 0 where material comes in. */
static void StatesAt(const Rod rod, const PetscReal *label, const PetscReal *all, PetscInt least,
                     PetscReal at, PetscInt *place, PetscReal k[]) {
  const PetscInt per = rod->learned->per, last = 2 * rod->last;
  const PetscReal sign = at < 0 ? -1 : 1;
  PetscReal w[STENCIL];
  PetscInt first;

  at = PetscMin(1, PetscAbsReal(at));
  if (label[*place] > at) *place = 0;
  while (*place + 1 < last && label[*place + 1] <= at) (*place)++;
  first = PetscMax(least, PetscMin(*place - (STENCIL / 2 - 1), last + 1 - STENCIL));
  Weights(label + first, rod->learned->over[first + BEYOND], at, w);
  for (PetscInt c = 0; c < per; c++) {
    k[c] = 0;
    for (int i = 0; i < STENCIL; i++) k[c] += sign * w[i] * all[(first + i) * per + c];
  }
}

/* LearnedCarries - do states go along with material that slides past the labels? */
PetscBool LearnedCarries(const Rod rod) {
  return (PetscBool)(rod->learned && rod->scene->growth->slides);
}

/* LearnedTimesRate - V, a change of rates, becomes what it changes the equations of states by. */
PetscErrorCode LearnedTimesRate(Rod rod, Vec V) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields;
  PetscScalar *v;

  PetscFunctionBegin;
  PetscCall(VecGetArray(V, &v));
  for (PetscInt i = 0; i < rod->end - rod->first; i++)
    for (PetscInt f = 0; f < fields; f++)
      v[i * fields + f] *= f < self->mech ? 0
                           : self->remembers && (f - self->mech) % self->per >= self->bends
                               ? rod->scene->tropism.memory
                               : 1;
  PetscCall(VecRestoreArray(V, &v));
  PetscFunctionReturn(0);
}

/*
  LearnedCarry - makes of a sum of points times their weights, at fixed labels, one along the
  material: to U_t that is D/Dt then (docs/theory/growth.md). Of a rod of which LearnedCarries();
  collective.

  t, times  of the sum, and of its points, which are earlier
  weight    of each point, for each field
*/
PetscErrorCode LearnedCarry(Rod rod, PetscReal t, PetscInt m, const PetscReal times[],
                            const Vec points[], PetscReal weight[][MAX_FIELDS], Vec sum) {
  const Learned self = rod->learned;
  const Growth growth = rod->scene->growth;
  const PetscInt fields = rod->model->fields, per = self->per, last = 2 * rod->last,
                 begin = 2 * rod->first, end = PetscMin(2 * rod->end, last + 1),
                 least = LearnedFront(rod) && GrowthSpeed(growth, 0, t, 0) > 0 ? -BEYOND : 0;
  const PetscReal *label;
  PetscReal *from, *room, *all, k[2 * TROPISM_BENDS];
  PetscScalar *x;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(last + 1, &from, (BEYOND + last + 2) * per, &room));
  if (!self->label) PetscCall(FindLabels(rod));
  label = self->label + BEYOND;
  all = room + BEYOND * per;
  PetscCall(VecGetArray(sum, &x));
  for (PetscInt j = 0; j < m; j++) {
    PetscInt at = 0;
    PetscCall(AllStates(rod, points[j], all));
    PetscCall(growth->depart(growth, t, times[j], end - begin, label + begin, from));
    for (PetscInt i = begin; i < end; i++) {
      PetscScalar *to = x + (i / 2 - rod->first) * fields + self->mech + i % 2 * per;
      const PetscReal *w = weight[j] + self->mech + i % 2 * per;
      StatesAt(rod, label, all, least, from[i - begin], &at, k);
      for (PetscInt c = 0; c < per; c++) to[c] += w[c] * (k[c] - all[i * per + c]);
    }
  }
  PetscCall(VecRestoreArray(sum, &x));
  PetscCall(PetscFree2(from, room));
  PetscFunctionReturn(0);
}

/* ---- the same equations in a matrix ---- */

/* The rows of a node, by its neighbour towards the clamp, itself, the other one, and the last. */
enum { BESIDE = 4, OWN = 1 };

typedef struct {
  PetscInt width; /* of a row */
  PetscReal *v;
} Rows;

static inline PetscReal *Entry(const Rod rod, const Rows *rows, PetscInt row, PetscInt block,
                               PetscInt column) {
  return rows->v + row * rows->width + block * rod->model->fields + column;
}

/* Where the signal's column is for node i. */
static PetscInt SignalBlock(const Rod rod, PetscInt i) {
  const PetscInt away = rod->last - i;

  return away > 1 ? BESIDE - 1 : OWN + away;
}

/* Rows of the states of place `half` of node i, but for what they are by mechanics: by themselves,
   and by the signal. */
static void PutOwn(const Rod rod, PetscInt i, int half, const LearnedRow *row, const Rows *rows) {
  const Learned self = rod->learned;
  const PetscInt first = self->mech + half * self->per, signal = self->mech + self->per;

  for (PetscInt b = 0; b < self->bends; b++) {
    const PetscInt memory = first + self->bends + b;
    *Entry(rod, rows, first + b, OWN, first + b) += row->own[b];
    if (self->at_tip) *Entry(rod, rows, first + b, SignalBlock(rod, i), signal + b) -= row->clock;
    if (!self->remembers) continue;
    *Entry(rod, rows, first + b, OWN, memory) -= row->clock;
    *Entry(rod, rows, memory, OWN, memory) += row->own_memory[b];
  }
}

/* What the states of a place are by the unknowns of a point: -a (S' + (I - G) E'), and -S'. */
static void OfPoint(const Rod rod, PetscReal clock, const LearnedSlope *slope, PetscInt b,
                    PetscReal bend[], PetscReal memory[]) {
  const Learned self = rod->learned;
  const Tropism *law = &rod->scene->tropism;
  const PetscBool at_once = (PetscBool) !(self->remembers || self->at_tip);

  for (PetscInt f = 0; f < self->mech; f++) {
    bend[f] = -clock * ((at_once ? slope->sensed[b][f] : 0) +
                        (law->ironing - law->proprioception) * slope->elastic[b][f]);
    memory[f] = -slope->sensed[b][f];
  }
}

/* ... by the clock, that goes with forces where growth feels them. */
static void PutClock(const Rod rod, PetscInt place, PetscInt first, PetscInt block,
                     const PetscReal by[LEARNED_MOST], const Rows *rows) {
  const Learned self = rod->learned;

  for (PetscInt b = 0; b < self->bends && self->extra; b++)
    Add(self->mech, -self->drives[place * self->bends + b], by,
        Entry(rod, rows, first + b, block, 0));
}

static void PutNode(const Rod rod, PetscInt i, const LearnedSlope *slope, const PetscReal *clock,
                    const Rows *rows) {
  const Learned self = rod->learned;
  const LearnedRow *row = &self->node[i - rod->first + 1];

  PutOwn(rod, i, 0, row, rows);
  if (IsBorn(rod, 2 * (i - rod->first + 1))) return;
  PutClock(rod, 2 * (i - rod->first + 1), self->mech, OWN, clock, rows);
  for (PetscInt b = 0; b < self->bends; b++) {
    PetscReal of[2][LEARNED_MOST];
    OfPoint(rod, row->clock, slope, b, of[0], of[1]);
    for (int k = 0; k < (self->remembers ? 2 : 1); k++)
      Add(self->mech, 1, of[k], Entry(rod, rows, self->mech + k * self->bends + b, OWN, 0));
  }
}

static void PutMid(const Rod rod, PetscInt i, const LearnedCell *cell, const Rows *rows) {
  const Learned self = rod->learned;
  const LearnedRow *row = &self->cell[i - rod->first + 1].at_mid;
  const PetscInt first = self->mech + self->per;

  PutOwn(rod, i, 1, row, rows);
  for (int e = 0; e < 2; e++)
    PutClock(rod, 2 * (i - rod->first + 1) + 1, first, OWN + e, cell->clock[1][e], rows);
  for (PetscInt b = 0; b < self->bends; b++) {
    PetscReal of[2][LEARNED_MOST];
    OfPoint(rod, row->clock, &cell->slope[1], b, of[0], of[1]);
    for (int k = 0; k < (self->remembers ? 2 : 1); k++)
      for (int e = 0; e < 2; e++) {
        const PetscInt at = first + k * self->bends + b;
        for (PetscInt f = 0; f < self->mech; f++)
          Add(self->mech, of[k][f], cell->by_node[e][f], Entry(rod, rows, at, OWN + e, 0));
        for (PetscInt c = 0; c < self->bends; c++)
          *Entry(rod, rows, at, OWN + e, self->mech + c) +=
              Times(self->mech, of[k], cell->by_bend[e][c]);
      }
  }
}

/* Is an equation of a cell, or of an end, a row of the node before it? V's is. */
static PetscBool OfNodeBefore(const Rod rod, PetscInt row) {
  const Learned self = rod->learned;

  return (PetscBool)(row < rod->model->halves[0] || (self->extra && row == self->lead));
}

/* The equations of a cell that are rows of the node before it, or the others; its nodes are the
   blocks a and a + 1 of the rows. */
static void PutEquations(const Rod rod, const LearnedCell *cell, const PetscReal *left,
                         const PetscReal *right, PetscBool before, PetscInt a, const Rows *rows) {
  const Learned self = rod->learned;
  const PetscReal *J[2] = {left, right};

  for (PetscInt r = 0; r < self->mech; r++) {
    if (OfNodeBefore(rod, r) != before) continue;
    for (int e = 0; e < 2; e++) {
      Add(self->mech, 1, J[e] + r * self->mech, Entry(rod, rows, r, a + e, 0));
      for (PetscInt b = 0; b < self->bends; b++)
        *Entry(rod, rows, r, a + e, self->mech + b) += cell->column[2 * e][b][r];
    }
    for (PetscInt b = 0; b < self->bends; b++)
      *Entry(rod, rows, r, a, self->mech + self->per + b) += cell->column[1][b][r];
  }
}

/* The equations of an end, in the order of the rows that they are. */
static void PutEnd(const Rod rod, const PetscReal *by, PetscBool before, const Rows *rows) {
  const PetscInt mech = rod->learned->mech;

  for (PetscInt r = 0; r < mech; r++) {
    if (OfNodeBefore(rod, r) != before) continue;
    Add(mech, 1, by, Entry(rod, rows, r, OWN, 0));
    by += mech;
  }
}

/* The last node's own: the tip's signal, and places that are none. */
static void PutLast(const Rod rod, const Rows *rows) {
  const Learned self = rod->learned;
  const PetscInt first = self->mech + self->per;

  for (PetscInt c = 0; c < self->per; c++)
    *Entry(rod, rows, first + c, OWN, first + c) = self->at_tip ? self->tip_own[c] : 1;
  for (PetscInt b = 0; b < self->bends && self->at_tip; b++)
    Add(self->mech, -self->tip_own[b], self->tip[b], Entry(rod, rows, first + b, OWN, 0));
}

/*
  LearnedMatrix - sets the rows of owned node i, and begins those of the next one. (To be called
  node after node, from that before the first owned one on, which has none.)

  begin            the equations of the beginning, by its node; NULL: it is another node
  cell, left, right  of the cell behind it, NULL for the last node
  clock            the node's by its unknowns
  own              the last equations of the last node; NULL: it is another one
  room             2 * fields * 4 * fields numbers, 0 at first
*/
PetscErrorCode LearnedMatrix(Rod rod, PetscInt i, const PetscReal *begin, const LearnedCell *cell,
                             const PetscReal *left, const PetscReal *right,
                             const LearnedSlope *slope, const PetscReal *clock,
                             const PetscReal *own, PetscReal *room, Mat J) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields, size = fields * BESIDE * fields;
  const Rows rows = {.width = BESIDE * fields, .v = room},
             next = {.width = BESIDE * fields, .v = room + size};
  const PetscInt cols[BESIDE] = {i - 1, i, i < rod->last ? i + 1 : -1,
                                 self->at_tip && rod->last > i + 1 ? rod->last : -1};

  PetscFunctionBegin;
  if (begin) PutEnd(rod, begin, PETSC_TRUE, &rows);
  PutNode(rod, i, slope, clock, &rows);
  if (cell) {
    PutEquations(rod, cell, left, right, PETSC_FALSE, OWN, &rows);
    PutEquations(rod, cell, left, right, PETSC_TRUE, 0, &next);
    PutMid(rod, i, cell, &rows);
  } else {
    PutEnd(rod, own, PETSC_FALSE, &rows);
    PutLast(rod, &rows);
  }
  if (i >= rod->first)
    PetscCall(MatSetValuesBlocked(J, 1, &i, BESIDE, cols, rows.v, INSERT_VALUES));
  PetscCall(PetscArraycpy(rows.v, next.v, size));
  PetscCall(PetscArrayzero(next.v, size));
  PetscFunctionReturn(0);
}
