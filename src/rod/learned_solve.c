/* What a material has learned, in a linear solve: states of nodes and middles of cells are
   eliminated where they are, so that the mechanics are left as wide as they were. */
#include "rod/learned_parts.h"

/* What a model is, known where the compiler unrolls loops by it: so many unknowns of the mechanics,
   of which those from `from` on, before `to`, are what a place senses and its elastic bends go by;
   so many bends. */
typedef struct {
  PetscInt n, from, to, bends;
} Size;

/* The row of a place from its slopes; shift: of its first state; clock: its own by the unknowns
   there, NULL: it does not go with these. */
ALWAYS_INLINE void MakeRow(const Rod rod, PetscInt place, const LearnedSlope *slope,
                           const PetscReal *clock, const PetscReal shift[], Size size,
                           LearnedRow *row) {
  const Learned self = rod->learned;
  const Tropism *law = &rod->scene->tropism;
  const PetscReal a = self->clock[place];

  if (LearnedIsBorn(rod, place)) {
    *row = (LearnedRow){.own = {1, 1}, .own_memory = {1, 1}};
    return;
  }
  row->clock = a;
  for (PetscInt b = 0; b < size.bends; b++) {
    const PetscReal memory = self->remembers ? 1 + law->memory * shift[size.bends + b] : 1,
                    own = shift[b] + a * law->proprioception,
                    senses = self->at_tip ? 0 : a / (own * memory),
                    gives = a / own * (law->ironing - law->proprioception);
    row->own[b] = own;
    row->own_memory[b] = memory;
    row->signal[b] = self->at_tip ? a / own : 0;
    for (PetscInt f = size.from; f < size.to; f++)
      row->by[b][f] = senses * slope->sensed[b][f] + gives * slope->elastic[b][f];
    for (PetscInt f = 0; f < size.n && clock; f++)
      row->by[b][f] = (f >= size.from && f < size.to ? row->by[b][f] : 0) +
                      self->drives[place * size.bends + b] / own * clock[f];
  }
  for (PetscInt b = 0; b < size.bends && self->remembers; b++)
    for (PetscInt f = size.from; f < size.to; f++) row->sensed[b][f] = slope->sensed[b][f];
}

/* J += column row, of n unknowns, of which the row has none before from or behind to. */
ALWAYS_INLINE void AddOuter(PetscInt n, PetscInt from, PetscInt to, const PetscReal column[],
                            const PetscReal row[], PetscReal *J) {
  for (PetscInt i = 0; i < n; i++)
    if (column[i] != 0)
      for (PetscInt j = from; j < to; j++) J[i * n + j] += column[i] * row[j];
}

/* The bends in the middle of a cell by the unknowns and the bends at both ends. */
ALWAYS_INLINE void MakeMid(const Rod rod, PetscInt place, const LearnedCell *cell,
                           const PetscReal shift[], PetscBool clocked, Size size,
                           LearnedFactor *factor) {
  const Learned self = rod->learned;
  const PetscInt n = size.n, span = size.to - size.from;
  LearnedRow *row = &factor->at_mid;

  MakeRow(rod, place, &cell->slope[AT_MID], NULL, shift + n + self->per, size, row);
  for (PetscInt b = 0; b < size.bends; b++)
    for (int e = 0; e < 2; e++) {
      PetscReal by[LEARNED_MOST] = {0};
      for (PetscInt f = size.from; f < size.to; f++)
        LearnedAdd(n, row->by[b][f], cell->by_node[e][f], by);
      if (clocked)
        LearnedAdd(n, self->drives[place * size.bends + b] / row->own[b], cell->clock[AT_MID][e],
                   by);
      for (PetscInt f = 0; f < n; f++) factor->mid[e][b][f] = by[f];
      for (PetscInt c = 0; c < size.bends; c++)
        factor->chain[e][b][c] =
            LearnedTimes(span, row->by[b] + size.from, cell->by_bend[e][c] + size.from);
      if (!self->remembers) continue;
      memset(factor->sensed[e][b], 0, sizeof(factor->sensed[e][b]));
      for (PetscInt f = size.from; f < size.to; f++)
        LearnedAdd(n, row->sensed[b][f], cell->by_node[e][f], factor->sensed[e][b]);
      for (PetscInt c = 0; c < size.bends; c++)
        factor->sensed_chain[e][b][c] =
            LearnedTimes(span, row->sensed[b] + size.from, cell->by_bend[e][c] + size.from);
    }
}

ALWAYS_INLINE void Condense(Rod rod, PetscInt i, const LearnedCell *cell, const PetscReal shift[],
                            PetscBool clocked, Size size, PetscReal *left, PetscReal *right) {
  const Learned self = rod->learned;
  const PetscInt at = i - rod->first + 1, n = size.n, from = clocked ? 0 : size.from,
                 to = clocked ? n : size.to;
  LearnedFactor *factor = &self->cell[at];
  PetscReal *const J[] = {left, right};

  MakeMid(rod, 2 * at + 1, cell, shift, clocked, size, factor);
  for (int k = 0; k < 3; k++)
    for (PetscInt b = 0; b < size.bends; b++)
      for (PetscInt f = 0; f < n; f++) factor->column[k][b][f] = cell->column[k][b][f];
  for (int e = 0; e < 2; e++) {
    const LearnedRow *end = &self->node[at + e];
    for (PetscInt b = 0; b < size.bends; b++) {
      PetscReal mid[LEARNED_MOST];
      for (PetscInt f = 0; f < n; f++) mid[f] = factor->mid[e][b][f];
      for (PetscInt c = 0; c < size.bends; c++)
        for (PetscInt f = from; f < to; f++) mid[f] += factor->chain[e][b][c] * end->by[c][f];
      AddOuter(n, from, to, cell->column[2 * e][b], end->by[b], J[e]);
      AddOuter(n, 0, n, cell->column[AT_MID][b], mid, J[e]);
    }
  }
}

/* r -= dF/dk of a cell times bends at a, in its middle and at b, those of the ends by the chain,
   too. */
ALWAYS_INLINE void CellTimes(const LearnedFactor *factor, const PetscReal *a, const PetscReal *mid,
                             const PetscReal *b, Size size, PetscReal r[]) {
  const PetscReal *end[] = {a, b};

  for (PetscInt c = 0; c < size.bends; c++) {
    PetscReal in = mid[c];
    for (int e = 0; e < 2; e++) {
      LearnedAdd(size.n, -end[e][c], factor->column[2 * e][c], r);
      for (PetscInt d = 0; d < size.bends; d++) in += factor->chain[e][c][d] * end[e][d];
    }
    LearnedAdd(size.n, -in, factor->column[AT_MID][c], r);
  }
}

/* The rows of a cell are those of the node behind it and of the one before it. */
ALWAYS_INLINE void PutCell(const Rod rod, PetscInt i, const PetscReal r[], PetscInt n,
                           PetscReal *b) {
  PetscReal *own = b + (i - rod->first) * n, *next = own + n;

  for (PetscInt f = 0; f < n; f++)
    if (LearnedIsBefore(rod, f)) {
      if (i + 1 < rod->end) next[f] += r[f];
    } else if (i >= rod->first)
      own[f] += r[f];
}

/* b, of owned nodes, less what states do by themselves. */
ALWAYS_INLINE void Fold(const Rod rod, Size size, PetscReal *b) {
  const Learned self = rod->learned;

  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    const PetscInt at = i - rod->first + 1;
    const PetscReal *k = self->free + 2 * at * self->per;
    PetscReal r[LEARNED_MOST] = {0};
    CellTimes(&self->cell[at], k, k + self->per, k + 2 * self->per, size, r);
    PutCell(rod, i, r, size.n, b);
  }
}

/* w, what a signal of 1 does to the equations of the owned nodes. */
ALWAYS_INLINE void BorderOf(const Rod rod, PetscInt bend, Size size, PetscReal *w) {
  const Learned self = rod->learned;

  memset(w, 0, (size_t)((rod->end - rod->first) * size.n) * sizeof(*w));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    const PetscInt at = i - rod->first + 1;
    PetscReal k[3][TROPISM_BENDS] = {{0}}, r[LEARNED_MOST] = {0};
    k[0][bend] = self->node[at].signal[bend];
    k[1][bend] = self->cell[at].at_mid.signal[bend];
    k[2][bend] = self->node[at + 1].signal[bend];
    CellTimes(&self->cell[at], k[0], k[1], k[2], size, r);
    PutCell(rod, i, r, size.n, w);
  }
}

/* The states of node i, once the mechanics of it are known. */
ALWAYS_INLINE void UnfoldNode(const Rod rod, PetscInt i, const PetscReal signal[], Size size,
                              PetscReal *k) {
  const Learned self = rod->learned;
  const PetscInt at = i - rod->first + 1, n = size.n, per = self->per;
  const LearnedRow *row = &self->node[at];
  const PetscReal *x = self->beside + at * n, *rhs = self->rhs + 2 * at * per;

  for (PetscInt b = 0; b < size.bends; b++) {
    k[b] =
        self->free[2 * at * per + b] + LearnedTimes(n, row->by[b], x) + row->signal[b] * signal[b];
    if (self->remembers)
      k[size.bends + b] =
          (rhs[size.bends + b] + LearnedTimes(n, row->sensed[b], x)) / row->own_memory[b];
  }
}

/* ... in the middle of the cell behind it, between those, k[0] and k[2]. */
ALWAYS_INLINE void UnfoldMid(const Rod rod, PetscInt i, const PetscReal signal[], Size size,
                             PetscReal *k) {
  const Learned self = rod->learned;
  const PetscInt at = i - rod->first + 1, place = 2 * at + 1, n = size.n, per = self->per;
  const LearnedFactor *cell = &self->cell[at];
  const PetscReal *rhs = self->rhs + place * per,
                  *x[] = {self->beside + at * n, self->beside + (at + 1) * n},
                  *end[] = {k, k + 2 * per};
  PetscReal *mid = k + per;

  for (PetscInt b = 0; b < size.bends; b++) {
    PetscReal sensed = 0;
    mid[b] = self->free[place * per + b] + cell->at_mid.signal[b] * signal[b];
    for (int e = 0; e < 2; e++) {
      mid[b] += LearnedTimes(n, cell->mid[e][b], x[e]);
      for (PetscInt c = 0; c < size.bends; c++) mid[b] += cell->chain[e][b][c] * end[e][c];
      if (!self->remembers) continue;
      sensed += LearnedTimes(n, cell->sensed[e][b], x[e]);
      for (PetscInt c = 0; c < size.bends; c++) sensed += cell->sensed_chain[e][b][c] * end[e][c];
    }
    if (self->remembers)
      mid[size.bends + b] = (rhs[size.bends + b] + sensed) / cell->at_mid.own_memory[b];
  }
}

/* All states, k, of this rank's places. */
ALWAYS_INLINE void Unfold(const Rod rod, const PetscReal signal[], Size size, PetscReal *k) {
  const PetscInt from = PetscMax(rod->first - 1, 0), to = PetscMin(rod->end, rod->last),
                 per = rod->learned->per;

  for (PetscInt i = from; i <= to; i++)
    UnfoldNode(rod, i, signal, size, k + 2 * (i - rod->first + 1) * per);
  for (PetscInt i = from; i < to; i++)
    UnfoldMid(rod, i, signal, size, k + 2 * (i - rod->first + 1) * per);
}

/* The models: in the plane, x1, x2, theta, m, n1, n2; where growth feels force, and V, L; in space,
   x, p, m, n. Places are sensed by a lamp alone. */
#define SIZES(X)                                                                                   \
  X(Plane, 6, 2, 4, 1, PETSC_FALSE)                                                                \
  X(PlaneLamp, 6, 0, 4, 1, PETSC_FALSE)                                                            \
  X(PlaneYields, 8, 0, 4, 1, PETSC_TRUE)                                                           \
  X(Space, 13, 3, 10, 2, PETSC_FALSE)                                                              \
  X(SpaceLamp, 13, 0, 10, 2, PETSC_FALSE) X(SpaceYields, 15, 0, 10, 2, PETSC_TRUE)

struct LearnedKind_ {
  PetscInt n;
  PetscBool lamp, clocked;
  void (*node)(Rod, PetscInt, const LearnedSlope *, const PetscReal *, const PetscReal *);
  void (*mid)(Rod, PetscInt, const LearnedCell *, const PetscReal *);
  void (*condense)(Rod, PetscInt, const LearnedCell *, const PetscReal *, PetscReal *, PetscReal *);
  void (*fold)(Rod, PetscReal *);
  void (*border)(Rod, PetscInt, PetscReal *);
  void (*unfold)(Rod, const PetscReal *, PetscReal *);
};

#define OF_SIZE(name, n, from, to, bends, clocked)                                                 \
  static const Size size##name = {n, from, to, bends};                                             \
  WIDE_VECTORS static void Node##name(Rod rod, PetscInt at, const LearnedSlope *slope,             \
                                      const PetscReal *clock, const PetscReal *shift) {            \
    MakeRow(rod, 2 * at, slope, clocked ? clock : NULL, shift + n, size##name,                     \
            &rod->learned->node[at]);                                                              \
  }                                                                                                \
  WIDE_VECTORS static void Mid##name(Rod rod, PetscInt at, const LearnedCell *cell,                \
                                     const PetscReal *shift) {                                     \
    MakeMid(rod, 2 * at + 1, cell, shift, clocked, size##name, &rod->learned->cell[at]);           \
  }                                                                                                \
  WIDE_VECTORS static void Condense##name(Rod rod, PetscInt i, const LearnedCell *cell,            \
                                          const PetscReal *shift, PetscReal *left,                 \
                                          PetscReal *right) {                                      \
    Condense(rod, i, cell, shift, clocked, size##name, left, right);                               \
  }                                                                                                \
  WIDE_VECTORS static void Fold##name(Rod rod, PetscReal *b) {                                     \
    Fold(rod, size##name, b);                                                                      \
  }                                                                                                \
  WIDE_VECTORS static void Border##name(Rod rod, PetscInt bend, PetscReal *w) {                    \
    BorderOf(rod, bend, size##name, w);                                                            \
  }                                                                                                \
  WIDE_VECTORS static void Unfold##name(Rod rod, const PetscReal *signal, PetscReal *k) {          \
    Unfold(rod, signal, size##name, k);                                                            \
  }
SIZES(OF_SIZE)

#define ROW_OF_SIZE(name, n, from, to, bends, clocked)                                             \
  {n,          (PetscBool)(from == 0), clocked,     Node##name, Mid##name, Condense##name,         \
   Fold##name, Border##name,           Unfold##name},
static const struct LearnedKind_ kinds[] = {SIZES(ROW_OF_SIZE)};

/* LearnedKindOf - how the states of a rod's model are condensed, which has what LearnedCreate() has
   been told. */
LearnedKind LearnedKindOf(const Rod rod) {
  const Learned self = rod->learned;
  const PetscBool lamp = (PetscBool)(rod->scene->tropism.light != 0);

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(kinds); k++)
    if (kinds[k].n == self->mech && (self->extra || kinds[k].lamp == lamp)) return &kinds[k];
  return NULL;
}

/* LearnedNodeSlope - that of node i: before the cells beside it are condensed. clock: its own by
   the unknowns there, where growth feels force; shift: of all fields. */
void LearnedNodeSlope(Rod rod, PetscInt i, const LearnedSlope *slope, const PetscReal *clock,
                      const PetscReal shift[]) {
  rod->learned->kind->node(rod, i - rod->first + 1, slope, clock, shift);
}

/*
  LearnedCondense - adds to the derivatives of the equations of the cell behind node i by its nodes
  what comes of the bends learned in it: with dk = free + by.d,

    dF/dy += dF/dk by,   and off the right-hand side goes dF/dk free (LearnedSolve()).
*/
void LearnedCondense(Rod rod, PetscInt i, const LearnedCell *cell, const PetscReal shift[],
                     PetscReal *left, PetscReal *right) {
  rod->learned->kind->condense(rod, i, cell, shift, left, right);
}

/* LearnedRows - what LearnedCondense() finds of the middle of a cell, for LearnedMatrix(). */
void LearnedRows(Rod rod, PetscInt i, const LearnedCell *cell, const PetscReal shift[]) {
  rod->learned->kind->mid(rod, i - rod->first + 1, cell, shift);
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

/* What the tip's signal would be by an owned part of the unknowns; on all ranks. */
static PetscErrorCode SignalBy(const Rod rod, const PetscReal *x, PetscReal signal[]) {
  const Learned self = rod->learned;

  PetscFunctionBegin;
  signal[0] = signal[1] = 0;
  for (PetscInt b = 0; b < self->bends && rod->end > rod->last; b++)
    signal[b] = LearnedTimes(self->mech, self->tip[b], x + (rod->last - rod->first) * self->mech);
  PetscCall(LearnedFromLastRank(rod, signal));
  PetscFunctionReturn(0);
}

/* LearnedTurned - rows with their columns, and a cell's equations in turn, as they are eliminated:
   LearnedOrder(). */
void LearnedTurned(const Rod rod, PetscInt rows, const PetscReal *from, PetscReal *to) {
  const PetscInt n = rod->learned->mech;

  for (PetscInt r = 0; r < rows; r++) {
    const PetscReal *row = from + (rows == n ? LearnedOrder(rod, r) : r) * n;
    for (PetscInt f = 0; f < n; f++) to[r * n + f] = row[LearnedOrder(rod, f)];
  }
}

/* The unknowns x of the mechanics of owned nodes by b. */
static PetscErrorCode SolveMechanics(const Rod rod, const PetscReal *b, PetscReal *x) {
  const Learned self = rod->learned;
  const PetscInt nodes = rod->end - rod->first, n = self->mech;
  PetscReal *in = self->extra ? self->turned : NULL, *out = in ? in + nodes * n : x;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < nodes && in; i++)
    for (PetscInt f = 0; f < n; f++) in[i * n + f] = b[i * n + LearnedOrder(rod, f)];
  PetscCall(EliminationSolve(self->elimination, (const PetscReal(*)[LINE_FIELDS])(in ? in : b),
                             (PetscReal(*)[LINE_FIELDS])out));
  for (PetscInt i = 0; i < nodes && in; i++)
    for (PetscInt f = 0; f < n; f++) x[i * n + LearnedOrder(rod, f)] = out[i * n + f];
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
    self->kind->border(rod, b, self->b);
    PetscCall(SolveMechanics(rod, self->b, self->border[b]));
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
  PetscCall(SolveMechanics(rod, self->b, self->x));
  if (!self->at_tip) PetscFunctionReturn(0);
  for (PetscInt b = 0; b < self->bends; b++) LearnedAdd(n, signal[b], self->border[b], self->x);
  PetscCall(SignalBy(rod, self->x, by));
  for (PetscInt b = 0; b < self->bends; b++) {
    c[b] = self->inverse[b][0] * by[0] + self->inverse[b][1] * by[1];
    LearnedAdd(n, c[b], self->border[b], self->x);
    signal[b] += c[b];
  }
  PetscFunctionReturn(0);
}

/* LearnedSolve - x of J x = b for what was condensed and eliminated last. Collective. */
PetscErrorCode LearnedSolve(Rod rod, Vec b, Vec x) {
  const Learned self = rod->learned;
  const PetscInt owned = (rod->end - rod->first) * self->mech;
  PetscReal signal[TROPISM_BENDS] = {0}, *k = self->free;

  PetscFunctionBegin;
  if (self->at_tip && !self->bordered) PetscCall(Border(rod));
  PetscCall(LearnedPart(rod, b, self->beside, NULL, self->rhs));
  for (PetscInt c = 0; c < self->bends && self->at_tip && rod->end > rod->last; c++)
    self->rhs[LearnedSignalPlace(rod) * self->per + c] /= self->tip_own[c];
  PetscCall(LearnedShareSignal(rod, self->rhs, signal));
  FreeOf(rod, self->rhs);
  PetscCall(PetscArraycpy(self->b, self->beside + self->mech, owned));
  self->kind->fold(rod, self->b);
  PetscCall(SolveBordered(rod, signal));
  PetscCall(LearnedPut(rod, self->x, NULL, x));
  PetscCall(LearnedPart(rod, x, self->beside, NULL, NULL));
  self->kind->unfold(rod, signal, k);
  if (rod->end > rod->last)
    memcpy(k + LearnedSignalPlace(rod) * self->per,
           self->at_tip ? signal : self->rhs + LearnedSignalPlace(rod) * self->per,
           (size_t)self->per * sizeof(*k));
  PetscCall(LearnedPut(rod, NULL, k, x));
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
