/* What a material has learned: its equations, and those of the mechanics, in a matrix. */
#include "rod/learned_parts.h"

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

/* LearnedByElastic - how the equation of a bend learned at a place of clock a changes with the
   unknowns there by its elastic bend: -a (I - G) E'. */
void LearnedByElastic(const Rod rod, PetscReal clock, const LearnedSlope *slope, PetscInt bend,
                      PetscReal by[]) {
  const Tropism *law = &rod->scene->tropism;

  for (PetscInt f = 0; f < rod->learned->mech; f++)
    by[f] = -clock * (law->ironing - law->proprioception) * slope->elastic[bend][f];
}

/* What the states of a place are by the unknowns of a point: -a (S' + (I - G) E'), and -S'. */
static void OfPoint(const Rod rod, PetscReal clock, const LearnedSlope *slope, PetscInt b,
                    PetscReal bend[], PetscReal memory[]) {
  const Learned self = rod->learned;
  const PetscBool at_once = (PetscBool) !(self->remembers || self->at_tip);

  LearnedByElastic(rod, clock, slope, b, bend);
  for (PetscInt f = 0; f < self->mech; f++) {
    if (at_once) bend[f] -= clock * slope->sensed[b][f];
    memory[f] = -slope->sensed[b][f];
  }
}

/* ... by the clock, that goes with forces where growth feels them. */
static void PutClock(const Rod rod, PetscInt place, PetscInt first, PetscInt block,
                     const PetscReal by[LEARNED_MOST], const Rows *rows) {
  const Learned self = rod->learned;

  for (PetscInt b = 0; b < self->bends && self->extra; b++)
    LearnedAdd(self->mech, -self->drives[place * self->bends + b], by,
               Entry(rod, rows, first + b, block, 0));
}

static void PutNode(const Rod rod, PetscInt i, const LearnedSlope *slope, const PetscReal *clock,
                    const Rows *rows) {
  const Learned self = rod->learned;
  const LearnedRow *row = &self->node[i - rod->first + 1];

  PutOwn(rod, i, 0, row, rows);
  if (LearnedIsBorn(rod, 2 * (i - rod->first + 1))) return;
  PutClock(rod, 2 * (i - rod->first + 1), self->mech, OWN, clock, rows);
  for (PetscInt b = 0; b < self->bends; b++) {
    PetscReal of[2][LEARNED_MOST];
    OfPoint(rod, row->clock, slope, b, of[0], of[1]);
    for (int k = 0; k < (self->remembers ? 2 : 1); k++)
      LearnedAdd(self->mech, 1, of[k], Entry(rod, rows, self->mech + k * self->bends + b, OWN, 0));
  }
}

static void PutMid(const Rod rod, PetscInt i, const LearnedCell *cell, const Rows *rows) {
  const Learned self = rod->learned;
  const LearnedRow *row = &self->cell[i - rod->first + 1].at_mid;
  const PetscInt first = self->mech + self->per;

  PutOwn(rod, i, 1, row, rows);
  for (int e = 0; e < 2; e++)
    PutClock(rod, 2 * (i - rod->first + 1) + 1, first, OWN + e, cell->clock[AT_MID][e], rows);
  for (PetscInt b = 0; b < self->bends; b++) {
    PetscReal of[2][LEARNED_MOST];
    OfPoint(rod, row->clock, &cell->slope[AT_MID], b, of[0], of[1]);
    for (int k = 0; k < (self->remembers ? 2 : 1); k++)
      for (int e = 0; e < 2; e++) {
        const PetscInt at = first + k * self->bends + b;
        for (PetscInt f = 0; f < self->mech; f++)
          if (of[k][f] != 0) /* (rows that nothing goes by are not told) */
            LearnedAdd(self->mech, of[k][f], cell->by_node[e][f], Entry(rod, rows, at, OWN + e, 0));
        for (PetscInt c = 0; c < self->bends; c++)
          *Entry(rod, rows, at, OWN + e, self->mech + c) +=
              LearnedTimes(self->mech, of[k], cell->by_bend[e][c]);
      }
  }
}

/* The equations of a cell that are rows of the node before it, or the others; its nodes are the
   blocks a and a + 1 of the rows. */
static void PutEquations(const Rod rod, const LearnedCell *cell, const PetscReal *left,
                         const PetscReal *right, PetscBool before, PetscInt a, const Rows *rows) {
  const Learned self = rod->learned;
  const PetscReal *J[] = {left, right};

  for (PetscInt r = 0; r < self->mech; r++) {
    if (LearnedIsBefore(rod, r) != before) continue;
    for (int e = 0; e < 2; e++) {
      LearnedAdd(self->mech, 1, J[e] + r * self->mech, Entry(rod, rows, r, a + e, 0));
      for (PetscInt b = 0; b < self->bends; b++)
        *Entry(rod, rows, r, a + e, self->mech + b) += cell->column[2 * e][b][r];
    }
    for (PetscInt b = 0; b < self->bends; b++)
      *Entry(rod, rows, r, a, self->mech + self->per + b) += cell->column[AT_MID][b][r];
  }
}

/* The equations of an end, in the order of the rows that they are. */
static void PutEnd(const Rod rod, const PetscReal *by, PetscBool before, const Rows *rows) {
  const PetscInt mech = rod->learned->mech;

  for (PetscInt r = 0; r < mech; r++) {
    if (LearnedIsBefore(rod, r) != before) continue;
    LearnedAdd(mech, 1, by, Entry(rod, rows, r, OWN, 0));
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
    LearnedAdd(self->mech, -self->tip_own[b], self->tip[b], Entry(rod, rows, first + b, OWN, 0));
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
