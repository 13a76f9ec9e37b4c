/*
  The elimination of line.c for halves of other sizes: cell i has seven equations that are rows of
  node i + 1 and six that are rows of node i,
      L y_i + R y_{i+1} = b_{i+1},     B y_i + U y_{i+1} = b_i.
  What is before node i says T_i y_i = d_i, seven equations; with A_i = (T_i; B), T = (V, W), B =
  (P, Q), Q six by six, which fine cells keep near -1, and X = L A^-1 = (E, F), T_{i+1} = R - F U,
  d_{i+1} = b_{i+1} - X (d_i; b_i). A is factored by Q's inverse, then S = V - W Q^-1 P with partial
  pivoting: F = K Q^-1 - E N,  E = (L - K Q^-1 P) S^-1,  N = W Q^-1,  L = (L, K). Sizes are known
  when compiled, and the inner loops run along rows, for the compiler to make vectors of.
*/
#include "base/wide.h"
#include <string.h>

enum { TOP = WIDE_TOP, OWN = WIDE_OWN, ALL = WIDE_FIELDS };

/* A node and the cell behind it. */
typedef struct {
  PetscReal T[TOP][ALL];              /* (V, W), until the node is eliminated */
  PetscReal S[TOP][TOP], N[TOP][OWN]; /* the factors of S, of which row[k] is the pivot k */
  PetscReal Q[OWN][OWN], P[OWN][TOP]; /* the inverse of Q */
  PetscReal E[TOP][TOP], F[TOP][OWN]; /* X */
  PetscReal U[OWN][ALL];
  int row[TOP];
} Link;

struct _WideLine {
  PetscInt n; /* cells so far */
  Link *link;
  PetscReal last[ALL * ALL]; /* factors of the last node, whose own equations are any */
  PetscBLASInt pivots[ALL];
  PetscBool regular;
};

/* B = A^-1 by elimination with partial pivoting; A is lost. False if there is none. */
static PetscBool Invert(PetscReal A[OWN][OWN], PetscReal B[OWN][OWN]) {
  PetscBool regular = PETSC_TRUE;

  memset(B, 0, OWN * sizeof(*B));
  for (int i = 0; i < OWN; i++) B[i][i] = 1;
  for (int k = 0; k < OWN; k++) {
    int best = k;
    for (int i = k + 1; i < OWN; i++)
      if (PetscAbsReal(A[i][k]) > PetscAbsReal(A[best][k])) best = i;
    for (int j = 0; j < OWN && best != k; j++) {
      PetscReal a = A[k][j], b = B[k][j];
      A[k][j] = A[best][j];
      A[best][j] = a;
      B[k][j] = B[best][j];
      B[best][j] = b;
    }
    PetscReal f = 1 / A[k][k];
    if (!(PetscAbsReal(f) <= PETSC_MAX_REAL)) regular = PETSC_FALSE; /* (not so for NaN) */
    for (int j = 0; j < OWN; j++) {
      A[k][j] *= f;
      B[k][j] *= f;
    }
    for (int i = 0; i < OWN; i++) {
      PetscReal a = A[i][k];
      if (i == k) continue;
      for (int j = 0; j < OWN; j++) {
        A[i][j] -= a * A[k][j];
        B[i][j] -= a * B[k][j];
      }
    }
  }
  return regular;
}

/* S = LU in place, rows in the order of the pivots, whose reciprocals are kept; false if it is
   singular. */
static PetscBool Factor(PetscReal S[TOP][TOP], int row[TOP]) {
  for (int k = 0; k < TOP; k++) row[k] = k;
  for (int k = 0; k < TOP; k++) {
    int best = k;
    for (int i = k + 1; i < TOP; i++)
      if (PetscAbsReal(S[i][k]) > PetscAbsReal(S[best][k])) best = i;
    if (best != k) {
      int r = row[k];
      row[k] = row[best];
      row[best] = r;
      for (int j = 0; j < TOP; j++) {
        PetscReal a = S[k][j];
        S[k][j] = S[best][j];
        S[best][j] = a;
      }
    }
    S[k][k] = 1 / S[k][k];
    if (!(PetscAbsReal(S[k][k]) <= PETSC_MAX_REAL)) return PETSC_FALSE; /* (nor is NaN) */
    for (int i = k + 1; i < TOP; i++) {
      PetscReal f = S[i][k] *= S[k][k];
      for (int j = k + 1; j < TOP; j++) S[i][j] -= f * S[k][j];
    }
  }
  return PETSC_TRUE;
}

/* E = L S^-1, all its rows at once: columns are kept together. */
static void DivideByFactors(PetscReal S[TOP][TOP], const int row[TOP], PetscReal L[TOP][TOP],
                            PetscReal E[TOP][TOP]) {
  PetscReal z[TOP][TOP];

  for (int j = 0; j < TOP; j++)
    for (int r = 0; r < TOP; r++) z[j][r] = L[r][j];
  for (int j = 0; j < TOP; j++) {
    for (int i = 0; i < j; i++)
      for (int r = 0; r < TOP; r++) z[j][r] -= z[i][r] * S[i][j];
    for (int r = 0; r < TOP; r++) z[j][r] *= S[j][j];
  }
  for (int j = TOP - 1; j >= 0; j--)
    for (int i = j + 1; i < TOP; i++)
      for (int r = 0; r < TOP; r++) z[j][r] -= z[i][r] * S[i][j];
  for (int j = 0; j < TOP; j++)
    for (int r = 0; r < TOP; r++) E[r][row[j]] = z[j][r];
}

/* C = A Q, C -= A P, and so on, of the sizes that occur. */
static inline void Times(int rows, int inner, int columns, PetscReal sign, const PetscReal *A,
                         int lda, const PetscReal *B, PetscReal *C, int ldc) {
  for (int i = 0; i < rows; i++)
    for (int k = 0; k < inner; k++) {
      PetscReal a = sign * A[i * lda + k];
      for (int j = 0; j < columns; j++) C[i * ldc + j] += a * B[k * columns + j];
    }
}

/* WideCreate - for so many nodes at most; the caller ends it with WideDestroy(). */
PetscErrorCode WideCreate(PetscInt nodes, WideLine *line) {
  PetscFunctionBegin;
  PetscCall(PetscNew(line));
  PetscCall(PetscCalloc1(nodes, &(*line)->link));
  PetscFunctionReturn(0);
}

PetscErrorCode WideDestroy(WideLine *line) {
  PetscFunctionBegin;
  if (!*line) PetscFunctionReturn(0);
  PetscCall(PetscFree((*line)->link));
  PetscCall(PetscFree(*line));
  PetscFunctionReturn(0);
}

/* WideBegin - a new matrix: its cells follow; the first node's first seven unknowns are given. */
void WideBegin(WideLine line) {
  line->n = 0;
  line->regular = PETSC_TRUE;
  memset(line->link[0].T, 0, sizeof(line->link[0].T));
  for (int i = 0; i < TOP; i++) line->link[0].T[i][i] = 1;
}

/* Factors a node, whose own equations are the last six of a. */
static void FactorNode(WideLine line, Link *link, WideBlock a) {
  PetscReal Q[OWN][OWN];

  for (int i = 0; i < OWN; i++) {
    memcpy(link->P[i], a[TOP + i], TOP * sizeof(PetscReal));
    memcpy(Q[i], a[TOP + i] + TOP, OWN * sizeof(PetscReal));
  }
  if (!Invert(Q, link->Q)) line->regular = PETSC_FALSE;
  memset(link->N, 0, sizeof(link->N));
  Times(TOP, OWN, OWN, 1, link->T[0] + TOP, ALL, link->Q[0], link->N[0], OWN);
  for (int i = 0; i < TOP; i++) memcpy(link->S[i], link->T[i], TOP * sizeof(PetscReal));
  Times(TOP, OWN, TOP, -1, link->N[0], OWN, link->P[0], link->S[0], TOP);
  if (!Factor(link->S, link->row)) line->regular = PETSC_FALSE;
}

/* WideCell - eliminates the node before a cell, whose equations by its nodes are a and b; first the
   seven that are rows of b, then the six that are rows of a. */
void WideCell(WideLine line, WideBlock a, WideBlock b) {
  Link *link = &line->link[line->n++];
  PetscReal L[TOP][TOP];

  FactorNode(line, link, a);
  memset(link->F, 0, sizeof(link->F));
  Times(TOP, OWN, OWN, 1, a[0] + TOP, ALL, link->Q[0], link->F[0], OWN);
  for (int i = 0; i < TOP; i++) memcpy(L[i], a[i], TOP * sizeof(PetscReal));
  Times(TOP, OWN, TOP, -1, link->F[0], OWN, link->P[0], L[0], TOP);
  DivideByFactors(link->S, link->row, L, link->E);
  Times(TOP, TOP, OWN, -1, link->E[0], TOP, link->N[0], link->F[0], OWN);
  memcpy(link->U, b + TOP, sizeof(link->U));
  memcpy(link[1].T, b, sizeof(link->T));
  Times(TOP, OWN, ALL, -1, link->F[0], OWN, link->U[0], link[1].T[0], ALL);
}

/* WideEnd - the last node's own six equations, whatever they are. */
void WideEnd(WideLine line, const PetscReal own[OWN][ALL]) {
  const Link *last = &line->link[line->n];
  PetscBLASInt n = ALL, info;

  for (int k = 0; k < ALL; k++) {
    for (int i = 0; i < TOP; i++) line->last[k * ALL + i] = last->T[i][k];
    for (int i = 0; i < OWN; i++) line->last[k * ALL + TOP + i] = own[i][k];
  }
  LAPACKgetrf_(&n, &n, line->last, &n, line->pivots, &info);
  if (info || PetscIsInfOrNanReal(line->last[0])) line->regular = PETSC_FALSE;
}

/* WideRegular - could it be factored? */
PetscBool WideRegular(WideLine line) {
  return line->regular;
}

/* y = A^-1 v of a node, in place */
static void SolveNode(const Link *link, PetscReal y[ALL]) {
  PetscReal d[TOP], b[OWN], *own = y + TOP;

  for (int i = 0; i < TOP; i++) {
    d[i] = y[i];
    for (int k = 0; k < OWN; k++) d[i] -= link->N[i][k] * own[k];
  }
  for (int i = 0; i < TOP; i++) {
    y[i] = d[link->row[i]];
    for (int k = 0; k < i; k++) y[i] -= link->S[i][k] * y[k];
  }
  for (int i = TOP - 1; i >= 0; i--) {
    for (int k = i + 1; k < TOP; k++) y[i] -= link->S[i][k] * y[k];
    y[i] *= link->S[i][i];
  }
  for (int i = 0; i < OWN; i++) {
    b[i] = own[i];
    for (int k = 0; k < TOP; k++) b[i] -= link->P[i][k] * y[k];
  }
  for (int i = 0; i < OWN; i++) {
    own[i] = 0;
    for (int k = 0; k < OWN; k++) own[i] += link->Q[i][k] * b[k];
  }
}

/* WideSolve - the unknowns x of the line by b, both of all its nodes. */
void WideSolve(WideLine line, const PetscReal (*b)[ALL], PetscReal (*x)[ALL]) {
  PetscBLASInt fields = ALL, one = 1, info;
  const PetscInt n = line->n;

  memcpy(x, b, (size_t)(n + 1) * sizeof(*x));
  for (PetscInt i = 0; i < n; i++) {
    const Link *link = &line->link[i];
    for (int f = 0; f < TOP; f++) {
      for (int k = 0; k < TOP; k++) x[i + 1][f] -= link->E[f][k] * x[i][k];
      for (int k = 0; k < OWN; k++) x[i + 1][f] -= link->F[f][k] * x[i][TOP + k];
    }
  }
  LAPACKgetrs_("N", &fields, &one, line->last, &fields, line->pivots, x[n], &fields, &info);
  for (PetscInt i = n - 1; i >= 0; i--) {
    const Link *link = &line->link[i];
    for (int f = 0; f < OWN; f++)
      for (int k = 0; k < ALL; k++) x[i][TOP + f] -= link->U[f][k] * x[i + 1][k];
    SolveNode(link, x[i]);
  }
}
