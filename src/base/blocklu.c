/*
  J = L D^-1 U by blocks of a node's fields, node by node. What is 0 throughout is no block. Nodes
  are eliminated in the order of least degree, the exact one, by sets of bits: it follows from the
  blocks alone, so that a run that is restarted has the same. A node's own block is inverted with
  partial pivoting within it. Rows of a block have room for whole vectors of four.
*/
#include "base/blocklu.h"
#include "base/clones.h"
#include <petscblaslapack.h>
#include <stdint.h>
#include <string.h>

enum { MOST_WIDE = 24, MOST_NODES = 4000 }; /* to find the order takes the square of the nodes */

/* The blocks of a node's row, as they are set. */
typedef struct {
  PetscInt n, room;
  int *node;
  size_t *block; /* where in the pool */
} Row;

/* The factors on one side of the diagonal: of the k-th node in the order, its blocks from[k] to
   from[k + 1]. */
typedef struct {
  int *from, *node;
  PetscInt room; /* of node */
  PetscReal *block;
  size_t blocks_room;
} Side;

typedef struct {
  PetscInt nodes, fields, wide; /* a row of a block has room for so many numbers */
  size_t size;                  /* of a block */
  PetscBool *late;              /* of nodes whose own block may be singular: they come last, */
  PetscInt early;               /* ... behind so many; several of them are one block together */
  PetscReal *together;          /* ... its factors, column by column */
  PetscBLASInt *pivots;
  PetscBool factored;
  Row *row;
  PetscReal *pool;
  size_t used, room;
  PetscInt words;       /* of a set of nodes */
  uint64_t *sees, *set; /* of each node, whom it depends on; work of that size */
  int *order, *place;   /* which node comes k-th; and where a node comes */
  Side before, behind;  /* by place in the order; by node */
  PetscReal *own;       /* inverted own blocks, in the order */
  PetscReal **at, *work;
} BlockLU;

/* ---- the matrix ---- */

/* The block of a pair of nodes, made if it is not there: 0 then. */
static PetscErrorCode BlockOf(BlockLU *self, PetscInt i, PetscInt j, PetscReal **block) {
  Row *row = &self->row[i];

  PetscFunctionBegin;
  for (PetscInt k = row->n - 1; k >= 0; k--)
    if (row->node[k] == j) {
      *block = self->pool + row->block[k];
      PetscFunctionReturn(0);
    }
  if (row->n == row->room) {
    row->room = 2 * row->room + 8;
    PetscCall(PetscRealloc((size_t)row->room * sizeof(int), &row->node));
    PetscCall(PetscRealloc((size_t)row->room * sizeof(size_t), &row->block));
  }
  if (self->used + self->size > self->room) {
    self->room = 2 * self->room + 64 * self->size;
    PetscCall(PetscRealloc(self->room * sizeof(PetscReal), &self->pool));
  }
  *block = memset(self->pool + self->used, 0, self->size * sizeof(PetscReal));
  row->node[row->n] = (int)j;
  row->block[row->n++] = self->used;
  self->used += self->size;
  PetscFunctionReturn(0);
}

/* Is a block of values, whose rows are `next` apart, 0 throughout? */
static PetscBool IsZero(PetscInt fields, PetscInt next, const PetscScalar *v) {
  for (PetscInt i = 0; i < fields; i++)
    for (PetscInt j = 0; j < fields; j++)
      if (v[i * next + j] != 0) return PETSC_FALSE;
  return PETSC_TRUE;
}

static PetscErrorCode SetBlocks(Mat J, PetscInt m, const PetscInt rows[], PetscInt n,
                                const PetscInt columns[], const PetscScalar v[], InsertMode mode) {
  BlockLU *self;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &self));
  const PetscInt fields = self->fields, next = n * fields;
  for (PetscInt r = 0; r < m; r++)
    for (PetscInt c = 0; c < n; c++) {
      const PetscScalar *from = v + r * fields * next + c * fields;
      PetscReal *block = NULL;
      if (rows[r] < 0 || columns[c] < 0 || IsZero(fields, next, from)) continue;
      PetscCall(BlockOf(self, rows[r], columns[c], &block));
      for (PetscInt i = 0; i < fields; i++)
        for (PetscInt j = 0; j < fields; j++)
          block[i * self->wide + j] =
              from[i * next + j] + (mode == ADD_VALUES ? block[i * self->wide + j] : 0);
    }
  self->factored = PETSC_FALSE;
  PetscFunctionReturn(0);
}

static PetscErrorCode ZeroEntries(Mat J) {
  BlockLU *self;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &self));
  for (PetscInt i = 0; i < self->nodes; i++) self->row[i].n = 0;
  self->used = 0;
  self->factored = PETSC_FALSE;
  PetscFunctionReturn(0);
}

static PetscErrorCode Mult(Mat J, Vec X, Vec Y) {
  const PetscScalar *x;
  PetscScalar *y;
  BlockLU *self;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &self));
  PetscCall(VecGetArrayRead(X, &x));
  PetscCall(VecGetArrayWrite(Y, &y));
  for (PetscInt i = 0; i < self->nodes; i++)
    for (PetscInt f = 0; f < self->fields; f++) {
      const Row *row = &self->row[i];
      PetscScalar sum = 0;
      for (PetscInt k = 0; k < row->n; k++)
        for (PetscInt j = 0; j < self->fields; j++)
          sum +=
              self->pool[row->block[k] + f * self->wide + j] * x[row->node[k] * self->fields + j];
      y[i * self->fields + f] = sum;
    }
  PetscCall(VecRestoreArrayWrite(Y, &y));
  PetscCall(VecRestoreArrayRead(X, &x));
  PetscFunctionReturn(0);
}

/* ---- the order ---- */

static int Count(const uint64_t *set, PetscInt words) {
  int n = 0;
  for (PetscInt k = 0; k < words; k++) n += __builtin_popcountll(set[k]);
  return n;
}

/* Finds on whom each node depends, and who on it; are there others than there were? */
static PetscBool DependOnOthers(BlockLU *self) {
  const size_t words = (size_t)self->words, all = (size_t)self->nodes * words * sizeof(*self->set);
  uint64_t *now = self->set;

  memset(now, 0, all);
  for (size_t i = 0; i < (size_t)self->nodes; i++)
    for (PetscInt k = 0; k < self->row[i].n; k++) {
      const size_t j = (size_t)self->row[i].node[k];
      if (i == j) continue;
      now[i * words + j / 64] |= (uint64_t)1 << j % 64;
      now[j * words + i / 64] |= (uint64_t)1 << i % 64;
    }
  if (!memcmp(now, self->sees, all)) return PETSC_FALSE;
  memcpy(self->sees, now, all);
  return PETSC_TRUE;
}

/* Takes a node, the k-th, out: those that depend on it depend on each other from then on, and are
   the columns of its row of U. degree: of all nodes. */
static PetscErrorCode TakeOut(BlockLU *self, PetscInt k, int node, int degree[]) {
  const PetscInt words = self->words;
  uint64_t *mine = self->set + node * words;
  int n = self->behind.from[k];

  PetscFunctionBegin;
  self->order[k] = node;
  for (PetscInt w = 0; w < words; w++)
    for (uint64_t bits = mine[w]; bits; bits &= bits - 1) {
      if (n == self->behind.room) {
        self->behind.room = 2 * self->behind.room + 1024;
        PetscCall(PetscRealloc((size_t)self->behind.room * sizeof(int), &self->behind.node));
      }
      self->behind.node[n++] = (int)(64 * w + __builtin_ctzll(bits));
    }
  for (int e = self->behind.from[k]; e < n; e++) {
    const int i = self->behind.node[e];
    uint64_t *its = self->set + i * words;
    for (PetscInt w = 0; w < words; w++) its[w] |= mine[w];
    its[i / 64] &= ~((uint64_t)1 << i % 64);
    its[node / 64] &= ~((uint64_t)1 << node % 64);
    degree[i] = Count(its, words);
  }
  self->behind.from[k + 1] = n;
  PetscFunctionReturn(0);
}

/* The columns of L: who was eliminated before a node and is seen by it, from those of U. */
static PetscErrorCode Transpose(BlockLU *self) {
  const PetscInt nodes = self->nodes;
  const Side *U = &self->behind;
  Side *L = &self->before;
  int *next;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(nodes + 1, &next));
  for (int e = 0; e < U->from[nodes]; e++) next[self->place[U->node[e]] + 1]++;
  for (PetscInt k = 0; k < nodes; k++) next[k + 1] += next[k];
  PetscCall(PetscArraycpy(L->from, next, nodes + 1));
  if (L->room < U->room) {
    L->room = U->room;
    PetscCall(PetscRealloc((size_t)L->room * sizeof(int), &L->node));
  }
  for (PetscInt k = 0; k < nodes; k++)
    for (int e = U->from[k]; e < U->from[k + 1]; e++)
      L->node[next[self->place[U->node[e]]]++] = (int)k;
  PetscCall(PetscFree(next));
  PetscFunctionReturn(0);
}

/* Room for the blocks of the factors. */
static PetscErrorCode MakeRoom(const BlockLU *self, Side *side) {
  const size_t needed = (size_t)side->from[self->nodes] * self->size;

  PetscFunctionBegin;
  if (needed <= side->blocks_room) PetscFunctionReturn(0);
  side->blocks_room = 2 * needed;
  PetscCall(PetscFree(side->block));
  PetscCall(PetscMalloc1(side->blocks_room, &side->block));
  PetscFunctionReturn(0);
}

/* The node of least degree that is not out yet, of equals the first; late ones wait for the others.
 */
static int Next(const BlockLU *self, const int degree[]) {
  int best[2] = {-1, -1};

  for (PetscInt i = 0; i < self->nodes; i++) {
    int *of = &best[self->late[i]];
    if (degree[i] < INT32_MAX && (*of < 0 || degree[i] < degree[*of])) *of = (int)i;
  }
  return best[0] >= 0 ? best[0] : best[1];
}

/* The order of least degree. */
static PetscErrorCode Order(BlockLU *self) {
  const PetscInt nodes = self->nodes, words = self->words;
  int *degree = self->place;

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(self->set, self->sees, nodes * words));
  for (PetscInt i = 0; i < nodes; i++) degree[i] = Count(self->set + i * words, words);
  self->behind.from[0] = 0;
  for (PetscInt k = 0; k < nodes; k++) {
    const int best = Next(self, degree);
    degree[best] = INT32_MAX; /* it is out */
    PetscCall(TakeOut(self, k, best, degree));
  }
  for (PetscInt k = 0; k < nodes; k++) self->place[self->order[k]] = (int)k;
  PetscCall(Transpose(self));
  PetscCall(MakeRoom(self, &self->before));
  PetscCall(MakeRoom(self, &self->behind));
  PetscFunctionReturn(0);
}

/* ---- blocks ---- */

enum { FOURS = MOST_WIDE / 4 };

/* C -= A B */
ALWAYS_INLINE void Subtract(const int fields, const int wide, const PetscReal *restrict A,
                            const PetscReal *restrict B, PetscReal *restrict C) {
  for (int i = 0; i < fields; i++) {
    Four c[FOURS], *to = (Four *)(C + i * wide);
    for (int m = 0; m < wide / 4; m++) c[m] = to[m];
    for (int k = 0; k < fields; k++) {
      const PetscReal a = A[i * wide + k];
      const Four *b = (const Four *)(B + k * wide);
      for (int m = 0; m < wide / 4; m++) c[m] -= a * b[m];
    }
    for (int m = 0; m < wide / 4; m++) to[m] = c[m];
  }
}

/* A <- A D */
ALWAYS_INLINE void Times(const int fields, const int wide, PetscReal *restrict A,
                         const PetscReal *restrict D) {
  for (int i = 0; i < fields; i++) {
    Four c[FOURS], *to = (Four *)(A + i * wide);
    for (int m = 0; m < wide / 4; m++) c[m] = (Four){0};
    for (int k = 0; k < fields; k++) {
      const PetscReal a = A[i * wide + k];
      const Four *b = (const Four *)(D + k * wide);
      for (int m = 0; m < wide / 4; m++) c[m] += a * b[m];
    }
    for (int m = 0; m < wide / 4; m++) to[m] = c[m];
  }
}

/* A <- A^-1 (Gauss and Jordan); false: there is none */
ALWAYS_INLINE PetscBool Invert(const int fields, const int wide, PetscReal *restrict A) {
  int from[MOST_WIDE];

  for (int k = 0; k < fields; k++) {
    PetscReal f, column[MOST_WIDE];
    Four pivot[FOURS], *row;
    from[k] = k;
    for (int i = k + 1; i < fields; i++)
      if (PetscAbsReal(A[i * wide + k]) > PetscAbsReal(A[from[k] * wide + k])) from[k] = i;
    f = 1 / A[from[k] * wide + k];
    if (!(PetscAbsReal(f) <= PETSC_MAX_REAL)) return PETSC_FALSE;
    row = (Four *)(A + from[k] * wide);
    for (int m = 0; m < wide / 4; m++) pivot[m] = row[m] * f;
    for (int m = 0; m < wide / 4; m++) row[m] = ((Four *)(A + k * wide))[m];
    for (int i = 0; i < fields; i++) column[i] = A[i * wide + k];
    for (int i = 0; i < fields; i++) {
      row = (Four *)(A + i * wide);
      for (int m = 0; m < wide / 4; m++) row[m] -= column[i] * pivot[m];
    }
    for (int m = 0; m < wide / 4; m++) ((Four *)(A + k * wide))[m] = pivot[m];
    for (int i = 0; i < fields; i++) A[i * wide + k] = 0 - column[i] * f;
    A[k * wide + k] = f;
  }
  for (int k = fields - 1; k >= 0; k--)
    for (int i = 0; i < fields && from[k] != k; i++) {
      const PetscReal a = A[i * wide + k];
      A[i * wide + k] = A[i * wide + from[k]];
      A[i * wide + from[k]] = a;
    }
  return PETSC_TRUE;
}

/* ---- factors ---- */

/* Lays a node's row out for elimination: what is there is copied, what will be is 0. */
static void LayOut(BlockLU *self, PetscInt k) {
  const int node = self->order[k];
  const Row *row = &self->row[node];
  Side *side[2] = {&self->before, &self->behind};
  const size_t size = self->size, bytes = size * sizeof(PetscReal);

  for (int w = 0; w < 2; w++) {
    const int begin = side[w]->from[k], end = side[w]->from[k + 1];
    memset(side[w]->block + (size_t)begin * size, 0, (size_t)(end - begin) * bytes);
    for (int e = begin; e < end; e++)
      self->at[w ? side[w]->node[e] : self->order[side[w]->node[e]]] =
          side[w]->block + (size_t)e * size;
  }
  self->at[node] = self->own + (size_t)k * size;
  memset(self->at[node], 0, bytes);
  for (PetscInt j = 0; j < row->n; j++)
    memcpy(self->at[row->node[j]], self->pool + row->block[j], bytes);
}

/* What is left of a late node's row, when all early ones are out, is a row of the block of all late
   ones. */
static void Gather(BlockLU *self, PetscInt k) {
  const PetscInt early = self->early, fields = self->fields, n = (self->nodes - early) * fields;
  const Side *side[2] = {&self->before, &self->behind};

  for (PetscInt c = early; c < self->nodes; c++) {
    const PetscReal *block = c == k ? self->at[self->order[k]] : NULL;
    for (int w = 0; w < 2; w++)
      for (int e = side[w]->from[k]; e < side[w]->from[k + 1]; e++)
        if ((w ? self->place[side[w]->node[e]] : side[w]->node[e]) == c)
          block = side[w]->block + (size_t)e * self->size;
    for (PetscInt i = 0; i < fields; i++)
      for (PetscInt j = 0; j < fields; j++)
        self->together[((c - early) * fields + j) * n + (k - early) * fields + i] =
            block ? block[i * self->wide + j] : 0;
  }
}

/* With partial pivoting among all of them. False: it is singular. */
static PetscBool FactorTogether(BlockLU *self) {
  PetscBLASInt n = (PetscBLASInt)((self->nodes - self->early) * self->fields), info = 0;

  if (n) LAPACKgetrf_(&n, &n, self->together, &n, self->pivots, &info);
  return (PetscBool)(info == 0);
}

ALWAYS_INLINE PetscBool Factor(BlockLU *self, const int fields, const int wide) {
  const size_t size = (size_t)(fields * wide);
  const Side *L = &self->before, *U = &self->behind;

  for (PetscInt k = 0; k < self->nodes; k++) {
    LayOut(self, k);
    for (int e = L->from[k]; e < L->from[k + 1]; e++) {
      const int m = L->node[e];
      PetscReal *block = L->block + (size_t)e * size;
      if (m >= self->early) continue;
      Times(fields, wide, block, self->own + (size_t)m * size);
      for (int i = U->from[m]; i < U->from[m + 1]; i++)
        Subtract(fields, wide, block, U->block + (size_t)i * size, self->at[U->node[i]]);
    }
    if (k >= self->early)
      Gather(self, k);
    else if (!Invert(fields, wide, self->own + (size_t)k * size))
      return PETSC_FALSE;
  }
  return FactorTogether(self);
}

/* y -= A x */
ALWAYS_INLINE void SubtractProduct(const int fields, const int wide, const PetscReal *A,
                                   const PetscReal *x, PetscReal *y) {
  for (int i = 0; i < fields; i++) {
    PetscReal sum = 0;
    for (int j = 0; j < fields; j++) sum += A[i * wide + j] * x[j];
    y[i] -= sum;
  }
}

/* The late nodes' unknowns x, by what is left for them. */
static void SolveTogether(BlockLU *self, PetscReal *x) {
  const PetscInt fields = self->fields, late = self->nodes - self->early;
  PetscBLASInt n = (PetscBLASInt)(late * fields), one = 1, info;
  PetscReal *y = self->together + (size_t)n * (size_t)n;

  if (!late) return;
  for (PetscInt k = 0; k < late; k++)
    memcpy(y + k * fields, self->work + (self->early + k) * self->wide,
           (size_t)fields * sizeof(*y));
  LAPACKgetrs_("N", &n, &one, self->together, &n, self->pivots, y, &n, &info);
  for (PetscInt k = 0; k < late; k++)
    memcpy(x + self->order[self->early + k] * fields, y + k * fields, (size_t)fields * sizeof(*x));
}

/* x = U^-1 D L^-1 b, D the own blocks' inverses */
ALWAYS_INLINE void Solve(BlockLU *self, const int fields, const int wide, const PetscReal *b,
                         PetscReal *x) {
  const size_t size = (size_t)(fields * wide);
  const Side *L = &self->before, *U = &self->behind;

  for (PetscInt k = 0; k < self->nodes; k++) {
    PetscReal *y = self->work + k * wide;
    for (int i = 0; i < fields; i++) y[i] = b[self->order[k] * fields + i];
    for (int e = L->from[k]; e < L->from[k + 1] && L->node[e] < self->early; e++)
      SubtractProduct(fields, wide, L->block + (size_t)e * size, self->work + L->node[e] * wide, y);
  }
  SolveTogether(self, x);
  for (PetscInt k = self->early - 1; k >= 0; k--) {
    const PetscReal *D = self->own + (size_t)k * size;
    PetscReal *y = self->work + k * wide;
    for (int e = U->from[k]; e < U->from[k + 1]; e++)
      SubtractProduct(fields, wide, U->block + (size_t)e * size, x + U->node[e] * fields, y);
    for (int i = 0; i < fields; i++) {
      PetscReal sum = 0;
      for (int j = 0; j < fields; j++) sum += D[i * wide + j] * y[j];
      x[self->order[k] * fields + i] = sum;
    }
  }
}

/* The sizes that there are: a node of a rod in the plane, and in space; each also where its
   material learns, at once and by what it remembers. Rows have room for so many numbers. */
#define SIZES(X) X(6, 8) X(8, 8) X(10, 12) X(13, 16) X(17, 20) X(21, 24)

#define OF_SIZE(fields, wide)                                                                      \
  WIDE_VECTORS static PetscBool Factor##fields(BlockLU *self) {                                    \
    return Factor(self, fields, wide);                                                             \
  }                                                                                                \
  WIDE_VECTORS static void Solve##fields(BlockLU *self, const PetscReal *b, PetscReal *x) {        \
    Solve(self, fields, wide, b, x);                                                               \
  }
SIZES(OF_SIZE)

typedef struct {
  PetscInt fields, wide;
  PetscBool (*factor)(BlockLU *);
  void (*solve)(BlockLU *, const PetscReal *, PetscReal *);
} Size;

#define ROW_OF_SIZE(fields, wide) {fields, wide, Factor##fields, Solve##fields},
static const Size sizes[] = {SIZES(ROW_OF_SIZE)};

static const Size *SizeOf(PetscInt fields) {
  for (size_t k = 0; k < sizeof(sizes) / sizeof(*sizes); k++)
    if (sizes[k].fields == fields) return &sizes[k];
  return NULL;
}

/* ---- as PETSc sees it ---- */

/* BlockLUCan - are there blocks for nodes of so many fields, and are the nodes not too many? */
PetscBool BlockLUCan(PetscInt nodes, PetscInt fields) {
  return (PetscBool)(nodes <= MOST_NODES && SizeOf(fields));
}

static PetscErrorCode FreeSide(Side *side) {
  PetscFunctionBegin;
  PetscCall(PetscFree(side->from));
  PetscCall(PetscFree(side->node));
  PetscCall(PetscFree(side->block));
  PetscFunctionReturn(0);
}

static PetscErrorCode Destroy(Mat J) {
  BlockLU *self;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &self));
  for (PetscInt i = 0; i < self->nodes; i++) {
    PetscCall(PetscFree(self->row[i].node));
    PetscCall(PetscFree(self->row[i].block));
  }
  PetscCall(FreeSide(&self->before));
  PetscCall(FreeSide(&self->behind));
  PetscCall(PetscFree(self->pool));
  PetscCall(PetscFree2(self->sees, self->set));
  PetscCall(PetscFree5(self->row, self->order, self->place, self->at, self->own));
  PetscCall(PetscFree(self->work));
  PetscCall(PetscFree(self->late));
  PetscCall(PetscFree2(self->together, self->pivots));
  PetscCall(PetscFree(self));
  PetscFunctionReturn(0);
}

/*
  BlockLUCreate - the matrix, 0, of nodes times fields; its blocks are made as they are set
  (MatSetValuesBlocked). Not collective; BlockLUCan() says whether it can be.

  n_late, late  nodes whose own block may be singular: what holds a tip; no node twice
*/
PetscErrorCode BlockLUCreate(PetscInt nodes, PetscInt fields, PetscInt n_late,
                             const PetscInt late[], Mat *J) {
  const PetscInt n = nodes * fields;
  BlockLU *self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  self->nodes = nodes;
  self->fields = fields;
  self->wide = SizeOf(fields)->wide;
  self->size = (size_t)(self->fields * self->wide);
  self->words = (nodes + 63) / 64;
  PetscCall(PetscCalloc2(nodes * self->words, &self->sees, nodes * self->words, &self->set));
  PetscCall(PetscCalloc5(nodes, &self->row, nodes, &self->order, nodes, &self->place, nodes,
                         &self->at, (size_t)nodes * self->size, &self->own));
  PetscCall(PetscCalloc1(nodes * self->wide, &self->work));
  PetscCall(PetscCalloc1(nodes, &self->late));
  for (PetscInt k = 0; k < n_late; k++) self->late[late[k]] = PETSC_TRUE;
  self->early = n_late > 1 ? nodes - n_late : nodes;
  if (n_late > 1)
    PetscCall(PetscMalloc2(n_late * fields * (n_late * fields + 1), &self->together,
                           n_late * fields, &self->pivots));
  PetscCall(PetscCalloc1(nodes + 1, &self->before.from));
  PetscCall(PetscCalloc1(nodes + 1, &self->behind.from));
  PetscCall(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, self, J));
  PetscCall(MatSetBlockSize(*J, fields));
  PetscCall(MatSetUp(*J));
  PetscCall(MatShellSetOperation(*J, MATOP_MULT, (void (*)(void))Mult));
  PetscCall(MatShellSetOperation(*J, MATOP_ZERO_ENTRIES, (void (*)(void))ZeroEntries));
  PetscCall(MatShellSetOperation(*J, MATOP_SET_VALUES_BLOCKED, (void (*)(void))SetBlocks));
  PetscCall(MatShellSetOperation(*J, MATOP_DESTROY, (void (*)(void))Destroy));
  PetscFunctionReturn(0);
}

static PetscErrorCode SetUp(PC pc) {
  PetscBool regular;
  BlockLU *self;
  Mat J;

  PetscFunctionBegin;
  PetscCall(PCGetOperators(pc, NULL, &J));
  PetscCall(MatShellGetContext(J, &self));
  if (self->factored) PetscFunctionReturn(0);
  if (DependOnOthers(self) || !self->behind.node) PetscCall(Order(self));
  regular = SizeOf(self->fields)->factor(self);
  self->factored = PETSC_TRUE;
  PetscCall(PCSetFailedReason(pc, regular ? PC_NOERROR : PC_FACTOR_NUMERIC_ZEROPIVOT));
  PetscFunctionReturn(0);
}

static PetscErrorCode Apply(PC pc, Vec B, Vec X) {
  const PetscScalar *b;
  PetscScalar *x;
  BlockLU *self;
  Mat J;

  PetscFunctionBegin;
  PetscCall(PCGetOperators(pc, NULL, &J));
  PetscCall(MatShellGetContext(J, &self));
  PetscCall(VecGetArrayRead(B, &b));
  PetscCall(VecGetArrayWrite(X, &x));
  SizeOf(self->fields)->solve(self, b, x);
  PetscCall(VecRestoreArrayWrite(X, &x));
  PetscCall(VecRestoreArrayRead(B, &b));
  PetscFunctionReturn(0);
}

/* BlockLUSetSolver - makes a KSP the solver of such a matrix. */
PetscErrorCode BlockLUSetSolver(KSP ksp) {
  PC pc;

  PetscFunctionBegin;
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetName(pc, "LU of blocks"));
  PetscCall(PCShellSetSetUp(pc, SetUp));
  PetscCall(PCShellSetApply(pc, Apply));
  PetscFunctionReturn(0);
}
