/*
  The elimination of line.c for halves of other sizes, top and own: cell i has top equations that
  are rows of node i + 1 and own that are rows of node i, L y_i + R y_{i+1} = b_{i+1},     B y_i + U
  y_{i+1} = b_i. What is before node i says T_i y_i = d_i, top equations; with A_i = (T_i; B), T =
  (V, W), B = (P, Q), Q own by own, which fine cells keep near -1, and X = L A^-1 = (E, F), T_{i+1}
  = R - F U, d_{i+1} = b_{i+1} - X (d_i; b_i). A is factored by Q's inverse, then S = V - W Q^-1 P
  with partial pivoting: F = K Q^-1 - E N,  E = (L - K Q^-1 P) S^-1,  N = W Q^-1,  L = (L, K). Sizes
  are known when compiled, and the inner loops run along rows, for the compiler to make vectors of.
*/
#include "base/halves.h"
#include "base/clones.h"
#include <petscblaslapack.h>
#include <string.h>

enum { MOST = HALVES_MOST, MOST_HALF = 8 };

typedef struct {
  PetscInt top, own;
  void (*cell)(Halves);
  void (*solve)(Halves, const PetscReal *, PetscReal *);
} Size;

struct _Halves {
  const Size *size;
  PetscInt n;                  /* cells so far */
  PetscInt reals;              /* of a link */
  PetscReal *link;             /* one behind the other, see Parts */
  int (*row)[MOST_HALF];       /* of their S, in the order of the pivots */
  PetscReal last[MOST * MOST]; /* factors of the last node, whose own equations are any */
  PetscBLASInt pivots[MOST];
  PetscBool regular;
};

/* Where a link has what: (V, W); the factors of S; N; the inverse of Q; X = (E, F); the cell. */
typedef struct {
  PetscReal *T, *S, *N, *Q, *E, *F, *cell[2];
} Parts;

ALWAYS_INLINE Parts PartsOf(int top, int own, PetscReal *link) {
  const int all = top + own;
  Parts at;

  at.T = link;
  at.S = at.T + top * all;
  at.N = at.S + top * top;
  at.Q = at.N + top * own;
  at.E = at.Q + own * own;
  at.F = at.E + top * top;
  at.cell[0] = at.F + top * own;
  at.cell[1] = at.cell[0] + all * all;
  return at;
}

static PetscInt RealsOf(PetscInt top, PetscInt own) {
  const PetscInt all = top + own;

  return 3 * all * all + top * all + top * top;
}

/* A <- A^-1 by elimination with partial pivoting: behind column k its place is taken by that of the
   inverse, and the columns of the inverse are as the rows were before they were exchanged. False if
   there is none. */
ALWAYS_INLINE PetscBool Invert(int n, PetscReal *A) {
  PetscBool regular = PETSC_TRUE;
  int from[MOST_HALF];

  for (int k = 0; k < n; k++) {
    PetscReal pivot[MOST_HALF];
    from[k] = k;
    for (int i = k + 1; i < n; i++)
      if (PetscAbsReal(A[i * n + k]) > PetscAbsReal(A[from[k] * n + k])) from[k] = i;
    PetscReal f = 1 / A[from[k] * n + k];
    if (!(PetscAbsReal(f) <= PETSC_MAX_REAL)) regular = PETSC_FALSE; /* (not so for NaN) */
    for (int j = 0; j < n; j++) pivot[j] = A[from[k] * n + j];
    for (int j = 0; j < n; j++) A[from[k] * n + j] = A[k * n + j];
    pivot[k] = 1;
    for (int j = 0; j < n; j++) pivot[j] *= f;
    for (int i = 0; i < n; i++) {
      const PetscReal a = A[i * n + k];
      A[i * n + k] = 0;
      for (int j = 0; j < n; j++) A[i * n + j] -= a * pivot[j];
    }
    for (int j = 0; j < n; j++) A[k * n + j] = pivot[j];
  }
  for (int k = n - 1; k >= 0; k--)
    for (int i = 0; i < n && from[k] != k; i++) {
      const PetscReal a = A[i * n + k];
      A[i * n + k] = A[i * n + from[k]];
      A[i * n + from[k]] = a;
    }
  return regular;
}

/* S = LU in place, rows in the order of the pivots, whose reciprocals are kept; false if it is
   singular. */
ALWAYS_INLINE PetscBool Factor(int n, PetscReal *S, int row[]) {
  for (int k = 0; k < n; k++) row[k] = k;
  for (int k = 0; k < n; k++) {
    int best = k;
    for (int i = k + 1; i < n; i++)
      if (PetscAbsReal(S[i * n + k]) > PetscAbsReal(S[best * n + k])) best = i;
    if (best != k) {
      int r = row[k];
      row[k] = row[best];
      row[best] = r;
      for (int j = 0; j < n; j++) {
        PetscReal a = S[k * n + j];
        S[k * n + j] = S[best * n + j];
        S[best * n + j] = a;
      }
    }
    S[k * n + k] = 1 / S[k * n + k];
    if (!(PetscAbsReal(S[k * n + k]) <= PETSC_MAX_REAL)) return PETSC_FALSE; /* (nor is NaN) */
    for (int i = k + 1; i < n; i++) {
      PetscReal f = S[i * n + k] *= S[k * n + k];
      for (int j = k + 1; j < n; j++) S[i * n + j] -= f * S[k * n + j];
    }
  }
  return PETSC_TRUE;
}

/* E = L S^-1, all its rows at once: columns are kept together. */
ALWAYS_INLINE void DivideByFactors(int n, const PetscReal *S, const int row[], const PetscReal *L,
                                   PetscReal *E) {
  PetscReal z[MOST_HALF][MOST_HALF];

  for (int j = 0; j < n; j++)
    for (int r = 0; r < n; r++) z[j][r] = L[r * n + j];
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < j; i++)
      for (int r = 0; r < n; r++) z[j][r] -= z[i][r] * S[i * n + j];
    for (int r = 0; r < n; r++) z[j][r] *= S[j * n + j];
  }
  for (int j = n - 1; j >= 0; j--)
    for (int i = j + 1; i < n; i++)
      for (int r = 0; r < n; r++) z[j][r] -= z[i][r] * S[i * n + j];
  for (int j = 0; j < n; j++)
    for (int r = 0; r < n; r++) E[r * n + row[j]] = z[j][r];
}

/* Eliminates the node before the next cell, whose equations by it are known. */
ALWAYS_INLINE void Cell(Halves line, int top, int own) {
  const int all = top + own;
  const Parts at = PartsOf(top, own, line->link + line->n * line->reals);
  const PetscReal *a = at.cell[0], *b = at.cell[1];
  int *row = line->row[line->n++];
  PetscReal L[MOST_HALF * MOST_HALF];

  for (int i = 0; i < own; i++)
    for (int j = 0; j < own; j++) at.Q[i * own + j] = a[(top + i) * all + top + j];
  if (!Invert(own, at.Q)) line->regular = PETSC_FALSE;
  memset(at.N, 0, (size_t)(top * own) * sizeof(PetscReal));
  AddProduct(top, own, own, 1, at.T + top, all, at.Q, own, at.N, own);
  for (int i = 0; i < top; i++)
    for (int j = 0; j < top; j++) at.S[i * top + j] = at.T[i * all + j];
  AddProduct(top, own, top, -1, at.N, own, a + top * all, all, at.S, top);
  if (!Factor(top, at.S, row)) line->regular = PETSC_FALSE;
  memset(at.F, 0, (size_t)(top * own) * sizeof(PetscReal));
  AddProduct(top, own, own, 1, a + top, all, at.Q, own, at.F, own);
  for (int i = 0; i < top; i++)
    for (int j = 0; j < top; j++) L[i * top + j] = a[i * all + j];
  AddProduct(top, own, top, -1, at.F, own, a + top * all, all, L, top);
  DivideByFactors(top, at.S, row, L, at.E);
  AddProduct(top, top, own, -1, at.E, top, at.N, own, at.F, own);
  const Parts next = PartsOf(top, own, line->link + line->n * line->reals);
  memcpy(next.T, b, (size_t)(top * all) * sizeof(PetscReal));
  AddProduct(top, own, all, -1, at.F, own, b + top * all, all, next.T, all);
}

/* y = A^-1 v of a node, in place */
ALWAYS_INLINE void SolveNode(int top, int own, const Parts *at, const int row[], PetscReal *y) {
  const int all = top + own;
  PetscReal d[MOST_HALF], b[MOST_HALF], *y_own = y + top;

  for (int i = 0; i < top; i++) {
    d[i] = y[i];
    for (int k = 0; k < own; k++) d[i] -= at->N[i * own + k] * y_own[k];
  }
  for (int i = 0; i < top; i++) {
    y[i] = d[row[i]];
    for (int k = 0; k < i; k++) y[i] -= at->S[i * top + k] * y[k];
  }
  for (int i = top - 1; i >= 0; i--) {
    for (int k = i + 1; k < top; k++) y[i] -= at->S[i * top + k] * y[k];
    y[i] *= at->S[i * top + i];
  }
  for (int i = 0; i < own; i++) {
    b[i] = y_own[i];
    for (int k = 0; k < top; k++) b[i] -= at->cell[0][(top + i) * all + k] * y[k];
  }
  for (int i = 0; i < own; i++) {
    y_own[i] = 0;
    for (int k = 0; k < own; k++) y_own[i] += at->Q[i * own + k] * b[k];
  }
}

ALWAYS_INLINE void Solve(Halves line, int top, int own, const PetscReal *b, PetscReal *x) {
  const int all = top + own;
  PetscBLASInt fields = all, one = 1, info;
  const PetscInt n = line->n;

  memcpy(x, b, (size_t)((n + 1) * all) * sizeof(*x));
  for (PetscInt i = 0; i < n; i++) {
    const Parts at = PartsOf(top, own, line->link + i * line->reals);
    const PetscReal *here = x + i * all;
    PetscReal *next = x + (i + 1) * all;
    for (int f = 0; f < top; f++) {
      for (int k = 0; k < top; k++) next[f] -= at.E[f * top + k] * here[k];
      for (int k = 0; k < own; k++) next[f] -= at.F[f * own + k] * here[top + k];
    }
  }
  LAPACKgetrs_("N", &fields, &one, line->last, &fields, line->pivots, x + n * all, &fields, &info);
  for (PetscInt i = n - 1; i >= 0; i--) {
    const Parts at = PartsOf(top, own, line->link + i * line->reals);
    const PetscReal *next = x + (i + 1) * all;
    PetscReal *here = x + i * all;
    for (int f = 0; f < own; f++)
      for (int k = 0; k < all; k++) here[top + f] -= at.cell[1][(top + f) * all + k] * next[k];
    SolveNode(top, own, &at, line->row[i], here);
  }
}

/* The sizes that there are: a node of a rod in space; in the plane and in space, each where growth
   feels force, with its speed and the length. */
#define SIZES(X) X(7, 6) X(4, 4) X(8, 7)

#define OF_SIZE(top, own)                                                                          \
  WIDE_VECTORS static void Cell##top##own(Halves line) {                                           \
    Cell(line, top, own);                                                                          \
  }                                                                                                \
  WIDE_VECTORS static void Solve##top##own(Halves line, const PetscReal *b, PetscReal *x) {        \
    Solve(line, top, own, b, x);                                                                   \
  }
SIZES(OF_SIZE)

#define ROW_OF_SIZE(top, own) {top, own, Cell##top##own, Solve##top##own},
static const Size sizes[] = {SIZES(ROW_OF_SIZE)};

static const Size *SizeOf(const PetscInt halves[2]) {
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(sizes); k++)
    if (sizes[k].top == halves[0] && sizes[k].own == halves[1]) return &sizes[k];
  return NULL;
}

/* HalvesCan - are there lines whose nodes have so many equations of the cell before them, and so
   many of the one behind? */
PetscBool HalvesCan(const PetscInt halves[2]) {
  return (PetscBool)(SizeOf(halves) != NULL);
}

/* HalvesCreate - for so many nodes at most; HalvesCan() says yes. The caller ends it with
   HalvesDestroy(). */
PetscErrorCode HalvesCreate(PetscInt nodes, const PetscInt halves[2], Halves *line) {
  PetscFunctionBegin;
  PetscCall(PetscNew(line));
  (*line)->size = SizeOf(halves);
  (*line)->reals = RealsOf(halves[0], halves[1]);
  PetscCall(PetscCalloc2(nodes * (*line)->reals, &(*line)->link, nodes, &(*line)->row));
  PetscFunctionReturn(0);
}

PetscErrorCode HalvesDestroy(Halves *line) {
  PetscFunctionBegin;
  if (!*line) PetscFunctionReturn(0);
  PetscCall(PetscFree2((*line)->link, (*line)->row));
  PetscCall(PetscFree(*line));
  PetscFunctionReturn(0);
}

/* The parts of a link. */
static Parts PartsAt(Halves line, PetscInt i) {
  return PartsOf((int)line->size->top, (int)line->size->own, line->link + i * line->reals);
}

/* HalvesBegin - a new matrix: its cells follow; the first unknowns of the first node, as many as
   its top, are given. */
void HalvesBegin(Halves line) {
  const PetscInt top = line->size->top, all = top + line->size->own;

  line->n = 0;
  line->regular = PETSC_TRUE;
  memset(line->link, 0, (size_t)(top * all) * sizeof(PetscReal));
  for (PetscInt i = 0; i < top; i++) line->link[i * all + i] = 1;
}

/* HalvesFirst - behind HalvesBegin(): the equations of the first node that are its top, for others
   to be put there. */
PetscReal *HalvesFirst(Halves line) {
  return line->link;
}

/* HalvesBlocks - where the equations of the next cell by its nodes a and b are to be put; first
   those that are rows of b, then those that are rows of a. */
void HalvesBlocks(Halves line, PetscReal **a, PetscReal **b) {
  const Parts at = PartsAt(line, line->n);

  *a = at.cell[0];
  *b = at.cell[1];
}

/* HalvesCell - eliminates the node before the next cell, whose equations HalvesBlocks() has been
   given. */
void HalvesCell(Halves line) {
  line->size->cell(line);
}

/* HalvesKeep - keeps the next cell as it is, to be eliminated elsewhere. */
void HalvesKeep(Halves line) {
  line->n++;
}

/* HalvesEnd - the last node's own equations, whatever they are. */
void HalvesEnd(Halves line, const PetscReal own[]) {
  const PetscInt top = line->size->top, all = top + line->size->own;
  const Parts last = PartsAt(line, line->n);
  PetscBLASInt n = (PetscBLASInt)all, info;

  for (PetscInt k = 0; k < all; k++) {
    for (PetscInt i = 0; i < top; i++) line->last[k * all + i] = last.T[i * all + k];
    for (PetscInt i = top; i < all; i++) line->last[k * all + i] = own[(i - top) * all + k];
  }
  LAPACKgetrf_(&n, &n, line->last, &n, line->pivots, &info);
  if (info || PetscIsInfOrNanReal(line->last[0])) line->regular = PETSC_FALSE;
}

/* HalvesCells - how many there are. */
PetscInt HalvesCells(Halves line) {
  return line->n;
}

/* HalvesAt - what is known of a node; of the last T alone. */
HalvesLink HalvesAt(Halves line, PetscInt i) {
  const Parts at = PartsAt(line, i);

  return (HalvesLink){.T = at.T, .S = at.S, .cell = {at.cell[0], at.cell[1]}, .row = line->row[i]};
}

/* HalvesRegular - could it be factored? */
PetscBool HalvesRegular(Halves line) {
  return line->regular;
}

/* HalvesSolve - the unknowns x of the line by b, both of all its nodes. */
void HalvesSolve(Halves line, const PetscReal b[], PetscReal x[]) {
  line->size->solve(line, b, x);
}
