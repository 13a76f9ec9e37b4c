#include "base/chain.h"
#include <petscblaslapack.h>

/* Each rank factors its own diagonal block A (block LU in natural order, as on one rank). With B
   the part of its rows that reaches over to other ranks and g the values there, A x + B g = b. What
   it needs to know of others is little: on a line, the few unknowns next to each cut. Let E be all
   of those, of all ranks. The columns of A^-1 B, read off in the rows of E, give a small dense
   system x_E + (A^-1 B g)_E = (A^-1 b)_E that every rank solves; then x = A^-1 (b - B g). */
typedef struct {
  Mat whole, A, B;  /* A and B are the parts of the whole that this rank has; all borrowed */
  PetscObjectId id; /* of B: another, or one of another pattern, may well have its address */
  MatOrderingType ordering;
  PC local; /* LU of A */
  PetscInt n, first;
  PetscInt ghosts, edges;    /* columns of B; size of E */
  PetscInt *ghost;           /* the place in E of each column of B */
  PetscInt *edge;            /* E, global indices, increasing */
  PetscReal *dense, *values; /* edges x edges, column major; edges */
  PetscBLASInt *pivots;
  Vec x, y, g;
} Chain;

/* This rank's parts of the whole; map has the blocks, of size bs, that the columns of B stand for.
 */
static PetscErrorCode Parts(Chain *self, const PetscInt **map, PetscInt *bs) {
  PetscBool blocked;

  PetscFunctionBegin;
  *bs = 1;
  PetscCall(PetscObjectTypeCompare((PetscObject)self->whole, MATMPIBAIJ, &blocked));
  if (blocked) {
    PetscCall(MatMPIBAIJGetSeqBAIJ(self->whole, &self->A, &self->B, map));
    PetscCall(MatGetBlockSize(self->whole, bs));
  } else
    PetscCall(MatMPIAIJGetSeqAIJ(self->whole, &self->A, &self->B, map));
  PetscFunctionReturn(0);
}

/* The global indices of the columns of B. */
static PetscErrorCode GhostColumns(Chain *self, PetscInt **columns) {
  const PetscInt *map;
  PetscInt bs, n;

  PetscFunctionBegin;
  PetscCall(Parts(self, &map, &bs));
  PetscCall(MatGetSize(self->B, NULL, &n));
  self->ghosts = n;
  PetscCall(PetscMalloc1(n, columns));
  for (PetscInt k = 0; k < n; k++) (*columns)[k] = map[k / bs] * bs + k % bs;
  PetscFunctionReturn(0);
}

/* E, from the ghost columns of all ranks. */
static PetscErrorCode FindEdges(PC pc, Chain *self) {
  MPI_Comm comm = PetscObjectComm((PetscObject)pc);
  PetscMPIInt ranks, mine, *counts, *starts;
  PetscInt *columns, total = 0;

  PetscFunctionBegin;
  PetscCall(GhostColumns(self, &columns));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(PetscMPIIntCast(self->ghosts, &mine));
  PetscCall(PetscMalloc2(ranks, &counts, ranks, &starts));
  PetscCallMPI(MPI_Allgather(&mine, 1, MPI_INT, counts, 1, MPI_INT, comm));
  for (PetscMPIInt r = 0; r < ranks; r++) {
    starts[r] = (PetscMPIInt)total;
    total += counts[r];
  }
  PetscCall(PetscMalloc1(total, &self->edge));
  PetscCallMPI(MPI_Allgatherv(columns, mine, MPIU_INT, self->edge, counts, starts, MPIU_INT, comm));
  PetscCall(PetscSortRemoveDupsInt(&total, self->edge));
  self->edges = total;
  PetscCall(PetscMalloc1(self->ghosts, &self->ghost));
  for (PetscInt k = 0; k < self->ghosts; k++)
    PetscCall(PetscFindInt(columns[k], self->edges, self->edge, &self->ghost[k]));
  PetscCall(PetscFree2(counts, starts));
  PetscCall(PetscFree(columns));
  PetscFunctionReturn(0);
}

static PetscErrorCode FirstSetUp(PC pc, Chain *self) {
  PetscFunctionBegin;
  PetscCall(MatGetOwnershipRange(self->whole, &self->first, &self->n));
  self->n -= self->first;
  PetscCall(FindEdges(pc, self));
  PetscCall(PetscMalloc3(self->edges * self->edges, &self->dense, self->edges, &self->values,
                         self->edges, &self->pivots));
  PetscCall(MatCreateVecs(self->A, &self->x, &self->y));
  PetscCall(MatCreateVecs(self->B, &self->g, NULL));
  PetscCall(PCCreate(PETSC_COMM_SELF, &self->local));
  PetscCall(PCSetOptionsPrefix(self->local, "chain_"));
  PetscCall(PCSetType(self->local, PCLU));
  PetscCall(PCFactorSetMatOrderingType(self->local, self->ordering));
  PetscCall(PCSetFromOptions(self->local));
  PetscFunctionReturn(0);
}

/* Adds to column the entries of v that belong to E. */
static PetscErrorCode ReadEdges(Chain *self, Vec v, PetscReal *column) {
  const PetscScalar *a;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(v, &a));
  for (PetscInt e = 0; e < self->edges; e++)
    if (self->edge[e] >= self->first && self->edge[e] < self->first + self->n)
      column[e] += a[self->edge[e] - self->first];
  PetscCall(VecRestoreArrayRead(v, &a));
  PetscFunctionReturn(0);
}

static PetscErrorCode Forget(Chain *self) {
  PetscFunctionBegin;
  PetscCall(PCDestroy(&self->local));
  PetscCall(VecDestroy(&self->x));
  PetscCall(VecDestroy(&self->y));
  PetscCall(VecDestroy(&self->g));
  PetscCall(PetscFree(self->edge));
  PetscCall(PetscFree(self->ghost));
  PetscCall(PetscFree3(self->dense, self->values, self->pivots));
  PetscFunctionReturn(0);
}

/* Is anything in the dense system not a number? The same on every rank. */
static PetscBool Lost(const Chain *self) {
  for (PetscInt k = 0; k < self->edges * self->edges; k++)
    if (PetscIsInfOrNanReal(self->dense[k])) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscErrorCode SetUp(PC pc) {
  PCFailedReason reason;
  Chain *self;
  const PetscInt *map;
  PetscObjectId id;
  PetscInt m, bs;
  PetscBLASInt order, info;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &self));
  PetscCall(PCGetOperators(pc, NULL, &self->whole));
  PetscCall(Parts(self, &map, &bs));
  PetscCall(PetscObjectGetId((PetscObject)self->B, &id));
  if (self->local && id != self->id) PetscCall(Forget(self));
  self->id = id;
  if (!self->local) PetscCall(FirstSetUp(pc, self));
  PetscCall(PCSetOperators(self->local, self->A, self->A));
  PetscCall(PCSetUp(self->local));
  PetscCall(PCGetFailedReason(self->local, &reason));
  m = self->edges;
  PetscCall(PetscArrayzero(self->dense, m * m));
  if (reason && m) self->dense[0] = NAN;        /* so that all ranks know */
  for (PetscInt k = 0; k < self->ghosts; k++) { /* a column of A^-1 B */
    PetscCall(VecZeroEntries(self->g));
    PetscCall(VecSetValue(self->g, k, 1, INSERT_VALUES));
    PetscCall(VecAssemblyBegin(self->g));
    PetscCall(VecAssemblyEnd(self->g));
    PetscCall(MatMult(self->B, self->g, self->x));
    PetscCall(PCApply(self->local, self->x, self->y));
    PetscCall(ReadEdges(self, self->y, self->dense + self->ghost[k] * m));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, self->dense, (PetscMPIInt)(m * m), MPIU_REAL, MPI_SUM,
                             PetscObjectComm((PetscObject)pc)));
  for (PetscInt e = 0; e < m; e++) self->dense[e * m + e] += 1;
  PetscCall(PetscBLASIntCast(m, &order));
  PetscCallBLAS("LAPACKgetrf",
                LAPACKgetrf_(&order, &order, self->dense, &order, self->pivots, &info));
  /* what failed once need not fail again: it is said either way */
  PetscCall(PCSetFailedReason(pc, info || Lost(self) ? PC_FACTOR_NUMERIC_ZEROPIVOT : PC_NOERROR));
  PetscFunctionReturn(0);
}

static PetscErrorCode Apply(PC pc, Vec b, Vec x) {
  Chain *self;
  PetscBLASInt m, one = 1, info;
  PetscScalar *g;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &self));
  m = (PetscBLASInt)self->edges;
  PetscCall(VecGetLocalVectorRead(b, self->x));
  PetscCall(PCApply(self->local, self->x, self->y));
  PetscCall(PetscArrayzero(self->values, self->edges));
  PetscCall(ReadEdges(self, self->y, self->values));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, self->values, m, MPIU_REAL, MPI_SUM,
                             PetscObjectComm((PetscObject)pc)));
  PetscCallBLAS("LAPACKgetrs", LAPACKgetrs_("N", &m, &one, self->dense, &m, self->pivots,
                                            self->values, &m, &info));
  PetscCall(VecGetArrayWrite(self->g, &g));
  for (PetscInt k = 0; k < self->ghosts; k++) g[k] = -self->values[self->ghost[k]];
  PetscCall(VecRestoreArrayWrite(self->g, &g));
  PetscCall(MatMultAdd(self->B, self->g, self->x, self->y)); /* b - B g */
  PetscCall(VecRestoreLocalVectorRead(b, self->x));
  PetscCall(VecGetLocalVector(x, self->x));
  PetscCall(PCApply(self->local, self->y, self->x));
  PetscCall(VecRestoreLocalVector(x, self->x));
  PetscFunctionReturn(0);
}

static PetscErrorCode Destroy(PC pc) {
  Chain *self;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &self));
  PetscCall(Forget(self));
  PetscCall(PetscFree(self));
  PetscFunctionReturn(0);
}

/* ORDERING_HELD, in the form of a MatOrdering: of a matrix of blocks it is one of the blocks. */
static PetscErrorCode HeldOrdering(Mat A, MatOrderingType type, IS *rows, IS *columns) {
  const PetscInt *from;
  PetscInt n, bs, size, last, *to, k = 0;
  IS is[2];

  PetscFunctionBegin;
  PetscCall(MatGetOrdering(A, MATORDERINGQMD, &is[0], &is[1]));
  PetscCall(ISGetLocalSize(is[0], &n));
  PetscCall(MatGetBlockSize(A, &bs));
  PetscCall(MatGetLocalSize(A, &size, NULL));
  last = n == size ? n - bs : n - 1; /* the first of the last node */
  PetscCall(PetscMalloc1(n, &to));
  PetscCall(ISGetIndices(is[0], &from));
  for (PetscInt i = 0; i < n; i++)
    if (from[i] < last) to[k++] = from[i];
  while (k < n) to[k++] = last++;
  PetscCall(ISRestoreIndices(is[0], &from));
  for (int i = 0; i < 2; i++) PetscCall(ISDestroy(&is[i]));
  PetscCall(ISCreateGeneral(PETSC_COMM_SELF, n, to, PETSC_OWN_POINTER, rows));
  PetscCall(ISSetPermutation(*rows));
  PetscCall(PetscObjectReference((PetscObject)*rows));
  *columns = *rows;
  PetscFunctionReturn(0);
}

/* ChainSetType - makes a PC this solver; call it once for each. On one rank it is PETSc's LU in
   this order (natural for a chain; another if far nodes see each other); on several, for MPIBAIJ
   and MPIAIJ matrices, the local factorisation has the options prefix -chain_. */
PetscErrorCode ChainSetType(PC pc, MatOrderingType ordering) {
  PetscMPIInt ranks;
  Chain *self;

  PetscFunctionBegin;
  PetscCall(MatOrderingRegister(ORDERING_HELD, HeldOrdering)); /* (once more does no harm) */
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)pc), &ranks));
  if (ranks == 1) {
    PetscCall(PCSetType(pc, PCLU));
    PetscCall(PCFactorSetMatOrderingType(pc, ordering));
    PetscFunctionReturn(0);
  }
  PetscCall(PetscNew(&self));
  self->ordering = ordering;
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetName(pc, "chain: each rank's block LU, joined by a dense system"));
  PetscCall(PCShellSetContext(pc, self));
  PetscCall(PCShellSetSetUp(pc, SetUp));
  PetscCall(PCShellSetApply(pc, Apply));
  PetscCall(PCShellSetDestroy(pc, Destroy));
  PetscFunctionReturn(0);
}

/* ChainCreateSolver - a solver that is this one alone; its operators are the caller's, who ends it
   with KSPDestroy(). Collective. */
PetscErrorCode ChainCreateSolver(MPI_Comm comm, MatOrderingType ordering, KSP *ksp) {
  PC pc;

  PetscFunctionBegin;
  PetscCall(KSPCreate(comm, ksp));
  PetscCall(KSPSetType(*ksp, KSPPREONLY));
  PetscCall(KSPGetPC(*ksp, &pc));
  PetscCall(ChainSetType(pc, ordering));
  PetscFunctionReturn(0);
}
