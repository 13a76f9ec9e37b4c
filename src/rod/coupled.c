#include "rod/coupled.h"
#include "rod/learned.h"
#include "rod/rules.h"
#include <string.h>
#include <petsc/private/matimpl.h> /* a matrix that is given another pattern does not say so itself */

struct _Coupled {
  VecScatter to_all; /* NULL on one rank */
  Vec all[2];        /* U and U_t of the whole rod */
  const PetscScalar *open[2];
  /* what the matrix has room for: the feet of points on cell a are foot[from[a]] ... */
  PetscInt *from, *foot;
  PetscInt n;
  CellPair *near; /* the pairs that its pattern was made of */
};

/* CoupledCreate - all nodes on each rank, and room in the matrix. The caller ends it with
   CoupledDestroy(). Collective. */
PetscErrorCode CoupledCreate(Rod rod, Coupled *coupled) {
  Coupled self;
  PetscMPIInt ranks;
  Vec U;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *coupled = self;
  PetscCall(PetscCalloc1(rod->last + 1, &self->from));
  PetscCallMPI(MPI_Comm_size(rod->scene->comm, &ranks));
  if (ranks == 1) PetscFunctionReturn(0);
  PetscCall(DMGetGlobalVector(rod->da, &U));
  PetscCall(VecScatterCreateToAll(U, &self->to_all, &self->all[0]));
  PetscCall(VecDuplicate(self->all[0], &self->all[1]));
  PetscCall(DMRestoreGlobalVector(rod->da, &U));
  PetscFunctionReturn(0);
}

PetscErrorCode CoupledDestroy(Coupled *coupled) {
  Coupled self = *coupled;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(PetscFree(self->from));
  PetscCall(PetscFree(self->foot));
  PetscCall(PetscFree(self->near));
  PetscCall(VecScatterDestroy(&self->to_all));
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&self->all[k]));
  PetscCall(PetscFree(*coupled));
  PetscFunctionReturn(0);
}

/* CoupledOpen - the state of the whole rod, on every rank: of node i at u[i * fields], and of U_t
   likewise. Ends with CoupledClose(). Collective. */
PetscErrorCode CoupledOpen(Coupled self, Vec U, Vec U_t, const PetscReal *u[2]) {
  Vec v[] = {U, U_t};

  PetscFunctionBegin;
  for (int k = 0; k < 2; k++) {
    if (self->to_all) {
      PetscCall(VecScatterBegin(self->to_all, v[k], self->all[k], INSERT_VALUES, SCATTER_FORWARD));
      PetscCall(VecScatterEnd(self->to_all, v[k], self->all[k], INSERT_VALUES, SCATTER_FORWARD));
      v[k] = self->all[k];
    }
    PetscCall(VecGetArrayRead(v[k], &self->open[k]));
    u[k] = self->open[k];
  }
  PetscFunctionReturn(0);
}

PetscErrorCode CoupledClose(Coupled self, Vec U, Vec U_t) {
  PetscFunctionBegin;
  PetscCall(VecRestoreArrayRead(self->to_all ? self->all[0] : U, &self->open[0]));
  PetscCall(VecRestoreArrayRead(self->to_all ? self->all[1] : U_t, &self->open[1]));
  PetscFunctionReturn(0);
}

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

/* ... for the contact of a point on one cell with a foot on another, or near it. A force reaches
   the rows of its cell and of the next on either side, a couple (in space) those of one node more.
 */
static PetscErrorCode AddPair(Rod rod, Columns *columns, CellPair pair) {
  const PetscInt reach = rod->model->space ? 2 : 1;

  PetscFunctionBegin;
  for (int k = 0; k < 2; k++) {
    PetscInt a = k ? pair.foot : pair.sample, b = k ? pair.sample : pair.foot,
             low = a - 1 - rod_rule.pattern_margin, high = a + reach + rod_rule.pattern_margin;
    PetscCall(AddColumns(rod, columns, low, high, b - rod_rule.pattern_margin,
                         b + 1 + rod_rule.pattern_margin));
    PetscCall(AddColumns(rod, columns, low, high, a - rod_rule.pattern_margin,
                         a + 1 + rod_rule.pattern_margin));
  }
  PetscFunctionReturn(0);
}

/* Gives J room for these columns, and zeros there. */
static PetscErrorCode Allocate(Rod rod, Columns *columns, Mat J) {
  const PetscScalar zero[MAX_FIELDS * MAX_FIELDS] = {0};
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
  PetscCall(MatXAIJSetPreallocation(J, rod->model->fields, own, other, NULL, NULL));
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
static PetscErrorCode KeepPairs(Coupled self, PetscInt cells, PetscInt n, CellPair *near) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->foot));
  PetscCall(PetscMalloc1(n, &self->foot));
  PetscCall(PetscArrayzero(self->from, cells + 1));
  for (PetscInt k = 0; k < n; k++) self->from[near[k].sample + 1]++;
  for (PetscInt a = 0; a < cells; a++) self->from[a + 1] += self->from[a];
  for (PetscInt k = 0; k < n; k++) self->foot[--self->from[near[k].sample + 1]] = near[k].foot;
  for (PetscInt a = 0; a < cells; a++) self->from[a] = self->from[a + 1];
  self->from[cells] = n;
  PetscFunctionReturn(0);
}

/* Is there room for a pair? */
static PetscBool HasRoom(const struct _Coupled *self, CellPair pair) {
  for (PetscInt k = self->from[pair.sample]; k < self->from[pair.sample + 1]; k++)
    if (PetscAbsInt(self->foot[k] - pair.foot) <= rod_rule.pattern_margin) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Gives J the pattern of the rod, all of which may see its tip, and of all pairs that are near to
   touching. */
static PetscErrorCode NewPattern(Rod rod, Coupled self, Mat J, PetscInt n, CellPair *near) {
  const PetscInt rows = rod->end - rod->first;
  Columns columns;

  PetscFunctionBegin;
  PetscCall(PetscCalloc3(rows, &columns.n, rows, &columns.room, rows, &columns.column));
  for (PetscInt i = rod->first; i < rod->end; i++)
    PetscCall(AddColumns(rod, &columns, i, i, i - 1, i + 1));
  if (rod->learned && rod->learned->at_tip)
    PetscCall(AddColumns(rod, &columns, rod->first, rod->end - 1, rod->last, rod->last));
  for (PetscInt k = 0; k < n; k++) PetscCall(AddPair(rod, &columns, near[k]));
  PetscCall(KeepPairs(self, rod->last, n, near));
  PetscCall(Allocate(rod, &columns, J));
  for (PetscInt i = 0; i < rows; i++) PetscCall(PetscFree(columns.column[i]));
  PetscCall(PetscFree3(columns.n, columns.room, columns.column));
  PetscFunctionReturn(0);
}

/* Is the pattern that of these pairs, or has it room for them at least? */
static PetscBool Fits(const struct _Coupled *self, PetscBool exactly, PetscInt n, CellPair *near) {
  PetscBool fits = PETSC_TRUE;

  if (exactly)
    return (PetscBool)(n == self->n &&
                       (!n || !memcmp(near, self->near, (size_t)n * sizeof(*near))));
  for (PetscInt k = 0; k < n && fits; k++) fits = HasRoom(self, near[k]);
  return fits;
}

/*
  CoupledPattern - sees to it that J has room for all pairs, and is 0. A Newton solve begins with
  the pattern of what is near then, and no more: so a run that is restarted has the same, and the
  same round-off. Collective.

  fresh  a Newton solve begins
  near   n pairs of cells that are near to touching; it is taken over
*/
PetscErrorCode CoupledPattern(Rod rod, Coupled self, PetscBool fresh, PetscInt n, CellPair *near,
                              Mat J) {
  PetscBool assembled, own;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)J, MATSHELL, &own));
  if (own) { /* it makes room as it goes */
    PetscCall(PetscFree(near));
    PetscCall(MatZeroEntries(J));
    PetscFunctionReturn(0);
  }
  PetscCall(MatAssembled(J, &assembled));
  if (assembled && Fits(self, fresh, n, near))
    PetscCall(PetscFree(near));
  else {
    PetscCall(NewPattern(rod, self, J, n, near));
    PetscCall(PetscFree(self->near));
    self->near = near;
    self->n = n;
  }
  PetscCall(MatZeroEntries(J));
  PetscFunctionReturn(0);
}
