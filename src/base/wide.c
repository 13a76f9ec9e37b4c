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
#include "base/clones.h"
#include <string.h>

enum { TOP = WIDE_TOP, OWN = WIDE_OWN, ALL = WIDE_FIELDS };

/* A node and the cell behind it. */
typedef struct {
  PetscReal T[TOP][ALL];              /* (V, W), until the node is eliminated */
  PetscReal S[TOP][TOP], N[TOP][OWN]; /* the factors of S, of which row[k] is the pivot k */
  PetscReal Q[OWN][OWN];              /* the inverse of Q */
  PetscReal E[TOP][TOP], F[TOP][OWN]; /* X */
  PetscReal cell[2][ALL][ALL];        /* its equations (L; B) and (R; U) by its nodes */
  WideArms arms;                      /* for the index */
  int row[TOP];
} Link;

struct _WideLine {
  PetscBool plane; /* directions out of the plane of x1 and x2 do not count */
  PetscInt n;      /* cells so far */
  Link *link;
  PetscReal own[OWN][ALL];   /* the last node's own equations */
  PetscReal last[ALL * ALL]; /* factors of the last node, whose own equations are any */
  PetscBLASInt pivots[ALL];
  PetscBool regular;
};

/* A <- A^-1 by elimination with partial pivoting: behind column k its place is taken by that of the
   inverse, and the columns of the inverse are as the rows were before they were exchanged. False if
   there is none. */
ALWAYS_INLINE PetscBool Invert(PetscReal A[OWN][OWN]) {
  PetscBool regular = PETSC_TRUE;
  int from[OWN];

  for (int k = 0; k < OWN; k++) {
    PetscReal pivot[OWN];
    from[k] = k;
    for (int i = k + 1; i < OWN; i++)
      if (PetscAbsReal(A[i][k]) > PetscAbsReal(A[from[k]][k])) from[k] = i;
    PetscReal f = 1 / A[from[k]][k];
    if (!(PetscAbsReal(f) <= PETSC_MAX_REAL)) regular = PETSC_FALSE; /* (not so for NaN) */
    memcpy(pivot, A[from[k]], sizeof(pivot));
    memcpy(A[from[k]], A[k], sizeof(pivot));
    pivot[k] = 1;
    for (int j = 0; j < OWN; j++) pivot[j] *= f;
    for (int i = 0; i < OWN; i++) {
      const PetscReal a = A[i][k];
      A[i][k] = 0;
      for (int j = 0; j < OWN; j++) A[i][j] -= a * pivot[j];
    }
    memcpy(A[k], pivot, sizeof(pivot));
  }
  for (int k = OWN - 1; k >= 0; k--)
    for (int i = 0; i < OWN && from[k] != k; i++) {
      const PetscReal a = A[i][k];
      A[i][k] = A[i][from[k]];
      A[i][from[k]] = a;
    }
  return regular;
}

/* S = LU in place, rows in the order of the pivots, whose reciprocals are kept; false if it is
   singular. */
ALWAYS_INLINE PetscBool Factor(PetscReal S[TOP][TOP], int row[TOP]) {
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
ALWAYS_INLINE void DivideByFactors(PetscReal S[TOP][TOP], const int row[TOP], PetscReal L[TOP][TOP],
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
ALWAYS_INLINE void Times(int rows, int inner, int columns, PetscReal sign,
                         const PetscReal *restrict A, int lda, const PetscReal *restrict B, int ldb,
                         PetscReal *restrict C, int ldc) {
  for (int i = 0; i < rows; i++)
    for (int k = 0; k < inner; k++) {
      PetscReal a = sign * A[i * lda + k];
      for (int j = 0; j < columns; j++) C[i * ldc + j] += a * B[k * ldb + j];
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

/* WideSpring - behind WideBegin(): the first node's first seven unknowns are not given, but these
   products of its own six. */
void WideSpring(WideLine line, const PetscReal gives[TOP][OWN]) {
  for (int i = 0; i < TOP; i++)
    for (int j = 0; j < OWN; j++) line->link[0].T[i][TOP + j] = -gives[i][j];
}

/* WideKeep - keeps the next cell as it is, to be eliminated elsewhere. */
void WideKeep(WideLine line) {
  line->n++;
}

/* Factors the node before a cell, whose equations by it are known. */
ALWAYS_INLINE void FactorNode(WideLine line, Link *link) {
  const PetscReal(*own)[ALL] = (const PetscReal(*)[ALL])link->cell[0] + TOP;

  for (int i = 0; i < OWN; i++) memcpy(link->Q[i], own[i] + TOP, OWN * sizeof(PetscReal));
  if (!Invert(link->Q)) line->regular = PETSC_FALSE;
  memset(link->N, 0, sizeof(link->N));
  Times(TOP, OWN, OWN, 1, link->T[0] + TOP, ALL, link->Q[0], OWN, link->N[0], OWN);
  for (int i = 0; i < TOP; i++) memcpy(link->S[i], link->T[i], TOP * sizeof(PetscReal));
  Times(TOP, OWN, TOP, -1, link->N[0], OWN, own[0], ALL, link->S[0], TOP);
  if (!Factor(link->S, link->row)) line->regular = PETSC_FALSE;
}

/* WideArm - the arms of the node that the next cell begins at, or of the last; for WideIndex(). */
void WideArm(WideLine line, const WideArms *arms) {
  line->link[line->n].arms = *arms;
}

/* WideBlocks - where the equations of the next cell by its nodes a and b are to be put; first the
   seven that are rows of b, then the six that are rows of a. */
void WideBlocks(WideLine line, PetscReal (**a)[ALL], PetscReal (**b)[ALL]) {
  *a = line->link[line->n].cell[0];
  *b = line->link[line->n].cell[1];
}

/* WideCell - eliminates the node before the next cell, whose equations WideBlocks() has been given.
 */
WIDE_VECTORS void WideCell(WideLine line) {
  Link *link = &line->link[line->n++];
  const PetscReal(*a)[ALL] = (const PetscReal(*)[ALL])link->cell[0],
        (*b)[ALL] = (const PetscReal(*)[ALL])link->cell[1];
  PetscReal L[TOP][TOP];

  FactorNode(line, link);
  memset(link->F, 0, sizeof(link->F));
  Times(TOP, OWN, OWN, 1, a[0] + TOP, ALL, link->Q[0], OWN, link->F[0], OWN);
  for (int i = 0; i < TOP; i++) memcpy(L[i], a[i], TOP * sizeof(PetscReal));
  Times(TOP, OWN, TOP, -1, link->F[0], OWN, a[TOP], ALL, L[0], TOP);
  DivideByFactors(link->S, link->row, L, link->E);
  Times(TOP, TOP, OWN, -1, link->E[0], TOP, link->N[0], OWN, link->F[0], OWN);
  memcpy(link[1].T, b, sizeof(link->T));
  Times(TOP, OWN, ALL, -1, link->F[0], OWN, b[TOP], ALL, link[1].T[0], ALL);
}

/* WideParts - of a line whose cells were kept: how many reals its cells and their arms are, and, in
   parts, what they are. */
enum { CELL_REALS = 2 * ALL * ALL, ARM_REALS = sizeof(WideArms) / sizeof(PetscReal) };

PetscInt WideParts(WideLine line, PetscReal parts[]) {
  for (PetscInt i = 0; i < line->n && parts; i++, parts += CELL_REALS + ARM_REALS) {
    memcpy(parts, line->link[i].cell, CELL_REALS * sizeof(PetscReal));
    memcpy(parts + CELL_REALS, &line->link[i].arms, sizeof(WideArms));
  }
  return line->n * (CELL_REALS + ARM_REALS);
}

/* WideTake - eliminates cells that are there in parts, so many reals. */
void WideTake(WideLine line, const PetscReal parts[], PetscInt reals) {
  for (PetscInt k = 0; k < reals; k += CELL_REALS + ARM_REALS) {
    Link *link = &line->link[line->n];
    memcpy(link->cell, parts + k, CELL_REALS * sizeof(PetscReal));
    memcpy(&link->arms, parts + k + CELL_REALS, sizeof(WideArms));
    WideCell(line);
  }
}

/* WideEnd - the last node's own six equations, whatever they are. */
void WideEnd(WideLine line, const PetscReal own[OWN][ALL]) {
  const Link *last = &line->link[line->n];
  PetscBLASInt n = ALL, info;

  memcpy(line->own, own, sizeof(line->own));
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
ALWAYS_INLINE void SolveNode(const Link *link, PetscReal y[ALL]) {
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
    for (int k = 0; k < TOP; k++) b[i] -= link->cell[0][TOP + i][k] * y[k];
  }
  for (int i = 0; i < OWN; i++) {
    own[i] = 0;
    for (int k = 0; k < OWN; k++) own[i] += link->Q[i][k] * b[k];
  }
}

/* WideSolve - the unknowns x of the line by b, both of all its nodes. */
WIDE_VECTORS void WideSolve(WideLine line, const PetscReal (*b)[ALL], PetscReal (*x)[ALL]) {
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
      for (int k = 0; k < ALL; k++) x[i][TOP + f] -= link->cell[1][TOP + f][k] * x[i + 1][k];
    SolveNode(link, x[i]);
  }
}

/*
  The index, as that of line.c: how many negative directions the quadratic form has, less those that
  forces count for, the sum of what each node adds when it is eliminated.

  A moment that does not turn with what it acts on derives from no energy, but mu = m + [m/2] turn
  does, and (w, mu) on both sides of a cell, w = (turn, x), n in mu, obey
      w_b = A w_a + F mu_b,     mu_a = A^T mu_b - K w_a,
  F and K symmetric. With w_a = C mu_a for what is before node a, C symmetric, too,
      w_a = (C^-1 + K)^-1 A^T mu_b,     C' = A (C^-1 + K)^-1 A^T + F,
  and the node adds
      negative(C^-1 + K) - negative(C^-1) = negative(-C, 1; 1, K) - 6.

  As long as S = V - W Q^-1 P, which is about 1 + C K, has positive pivots in its own order at all
  nodes, no direction has turned anywhere: not one, nor two that do not see each other, as those of
  a round rod that is straight. A pair that sees each other by a twisting moment may have: where
  there is one, all nodes are looked at.
*/
typedef PetscReal Six[OWN][OWN];

/* [m/2] of a node, of the turn in w. */
static void Skew(const WideArms *arms, Six A) {
  const PetscReal *m = arms->moment,
                  skew[3][3] = {{0, -m[2], m[1]}, {m[2], 0, -m[0]}, {-m[1], m[0], 0}};

  memset(A, 0, sizeof(Six));
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) A[i][j] = skew[i][j];
}

static void Symmetric(Six A) {
  for (int i = 0; i < OWN; i++)
    for (int j = 0; j < i; j++) A[i][j] = A[j][i] = (A[i][j] + A[j][i]) / 2;
}

/* Z A for A by seven, along the ways, which are at right angles to each other: of w. */
static void AlongWays(const PetscReal A[OWN][TOP], const WideArms *arms, Six Z) {
  for (int j = 0; j < OWN; j++) {
    PetscReal size = 0;
    for (int k = 0; k < TOP; k++) size += arms->way[j][k] * arms->way[j][k];
    for (int i = 0; i < OWN; i++) {
      Z[i][j] = 0;
      for (int k = 0; k < TOP; k++) Z[i][j] += A[i][k] * arms->way[j][k] / size;
    }
  }
}

static inline void SwapRows(int n, PetscReal a[], PetscReal b[]) {
  for (int j = 0; j < n; j++) {
    const PetscReal z = a[j];
    a[j] = b[j];
    b[j] = z;
  }
}

/* B = A^-1 B, n by n and n by m, with partial pivoting; A is lost. False: A is singular. (Sizes are
   constants: LAPACK's takes four times as long for so few.) */
static inline PetscBool Solve(int n, int m, PetscReal A[], PetscReal B[]) {
  for (int k = 0; k < n; k++) {
    int top = k;
    for (int i = k + 1; i < n; i++)
      if (PetscAbsReal(A[i * n + k]) > PetscAbsReal(A[top * n + k])) top = i;
    if (A[top * n + k] == 0) return PETSC_FALSE;
    if (top != k) {
      SwapRows(n, A + k * n, A + top * n);
      SwapRows(m, B + k * m, B + top * m);
    }
    for (int i = k + 1; i < n; i++) {
      const PetscReal share = A[i * n + k] / A[k * n + k];
      if (share == 0) continue;
      for (int j = k + 1; j < n; j++) A[i * n + j] -= share * A[k * n + j];
      for (int j = 0; j < m; j++) B[i * m + j] -= share * B[k * m + j];
    }
  }
  for (int k = n - 1; k >= 0; k--)
    for (int j = 0; j < m; j++) {
      for (int i = k + 1; i < n; i++) B[k * m + j] -= A[k * n + i] * B[i * m + j];
      B[k * m + j] /= A[k * n + k];
    }
  return PETSC_TRUE;
}

/* C of what is before a node: - way V^-1 W of m and n, and C (1 + [m/2] C)^-1 of mu; false if there
   is none. */
static PetscBool Compliance(const Link *link, Six C) {
  PetscReal V[TOP * TOP], X[TOP * OWN], Z[OWN * OWN], Y[OWN * OWN];
  PetscBool regular;
  Six skew;

  for (int i = 0; i < TOP; i++) {
    for (int j = 0; j < TOP; j++) V[i * TOP + j] = link->T[i][j];
    for (int j = 0; j < OWN; j++) X[i * OWN + j] = -link->T[i][TOP + j];
  }
  if (!Solve(TOP, OWN, V, X)) return PETSC_FALSE;
  Skew(&link->arms, skew);
  for (int i = 0; i < OWN; i++)
    for (int j = 0; j < OWN; j++) {
      C[i][j] = 0;
      for (int k = 0; k < TOP; k++) C[i][j] += link->arms.way[i][k] * X[k * OWN + j];
    }
  for (int i = 0; i < OWN; i++) /* the transposed system */
    for (int j = 0; j < OWN; j++) {
      Z[j * OWN + i] = i == j;
      Y[j * OWN + i] = C[i][j];
      for (int k = 0; k < OWN; k++) Z[j * OWN + i] += skew[i][k] * C[k][j];
    }
  regular = Solve(OWN, OWN, Z, Y);
  for (int i = 0; i < OWN && regular; i++)
    for (int j = 0; j < OWN; j++) C[i][j] = Y[j * OWN + i];
  Symmetric(C);
  return regular;
}

/* K of the cell behind a node: - mu_a by w_a at mu_b = 0; false if there is none. */
static PetscBool Stiffness(const Link *link, Six K) {
  const PetscReal(*a)[ALL] = (const PetscReal(*)[ALL])link->cell[0],
        (*b)[ALL] = (const PetscReal(*)[ALL])link->cell[1];
  PetscReal A[ALL * ALL], X[TOP * ALL], turned[OWN][TOP], force[OWN][TOP];
  Six skew;

  Skew(&link[1].arms, skew); /* m_b = - [m/2] turn_b */
  memset(turned, 0, sizeof(turned));
  Times(OWN, OWN, TOP, -1, skew[0], OWN, link[1].arms.way[0], TOP, turned[0], TOP);
  for (int i = 0; i < ALL; i++) {
    for (int j = 0; j < TOP; j++) {
      A[i * ALL + j] = b[i][j];
      for (int k = 0; k < OWN; k++) A[i * ALL + j] += b[i][TOP + k] * turned[k][j];
      X[i * TOP + j] = -a[i][j];
    }
    for (int j = 0; j < OWN; j++) A[i * ALL + TOP + j] = a[i][TOP + j];
  }
  if (!Solve(ALL, TOP, A, X)) return PETSC_FALSE;
  for (int i = 0; i < OWN; i++)
    for (int j = 0; j < TOP; j++) force[i][j] = -X[(TOP + i) * TOP + j];
  AlongWays((const PetscReal(*)[TOP])force, &link->arms, K);
  Skew(&link->arms, skew);
  for (int i = 0; i < OWN; i++)
    for (int j = 0; j < OWN; j++) K[i][j] -= skew[i][j];
  Symmetric(K);
  return PETSC_TRUE;
}

/* The negative eigenvalues of a symmetric matrix, which is lost: as many as of D in L D L^T, of
   which each block of two has one (Bunch and Kaufman take such a block only if its determinant is
   below 0). Eigenvalues themselves would cost five times as much. */
static PetscInt Negative(PetscBLASInt n, PetscReal A[]) {
  PetscReal work[16 * OWN];
  PetscBLASInt pivots[3 * OWN], size = 16 * OWN, info;
  PetscInt negative = 0;

  LAPACKsytrf_("U", &n, A, &n, pivots, work, &size, &info);
  for (int k = 0; k < n && info >= 0; k++) {
    if (pivots[k] > 0) {
      negative += A[k * n + k] < 0;
    } else {
      negative++;
      k++;
    }
  }
  return negative;
}

/* What a node adds; of the last one what holds it, R w = 0, is infinitely stiff. w is scaled for C
   and K to be of like size: a place that sticks is many orders of magnitude stiffer than others. */
static PetscInt Added(Six C, Six K, int held, Six R) {
  const int n = 2 * OWN + held;
  PetscReal A[9 * OWN * OWN] = {0}, scale[OWN];

  for (int i = 0; i < OWN; i++) {
    PetscReal c = PetscAbsReal(C[i][i]), k = PetscAbsReal(K[i][i]);
    scale[i] = c > 0 && k > 0 ? PetscSqrtReal(PetscSqrtReal(c / k)) : 1;
  }
  for (int i = 0; i < OWN; i++) {
    for (int j = 0; j < OWN; j++) {
      A[i * n + j] = -C[i][j] / (scale[i] * scale[j]);
      A[(OWN + i) * n + OWN + j] = K[i][j] * scale[i] * scale[j];
    }
    A[i * n + OWN + i] = A[(OWN + i) * n + i] = 1;
    for (int k = 0; k < held; k++)
      A[(2 * OWN + k) * n + OWN + i] = A[(OWN + i) * n + 2 * OWN + k] = R[k][i] * scale[i];
  }
  return Negative(n, A) - OWN - held;
}

/* Directions out of the plane of x1 and x2, which are turns about its axes and x3, add nothing. */
static void LeaveOutOfPlane(Six C, Six K) {
  static const PetscBool out[OWN] = {PETSC_TRUE,  PETSC_TRUE,  PETSC_FALSE,
                                     PETSC_FALSE, PETSC_FALSE, PETSC_TRUE};

  for (int i = 0; i < OWN; i++)
    for (int j = 0; j < OWN; j++)
      if (out[i] || out[j]) {
        C[i][j] = i == j;
        K[i][j] = 0;
      }
}

/*
  WidePlane - are only directions within the plane of x1 and x2 to count, from now on? Of a rod that
  lies in it, whose equations do not mix the two.
*/
void WidePlane(WideLine line, PetscBool plane) {
  line->plane = plane;
}

/* What the last node adds by its own equations (P, Q): those of x alone hold it, else they say how
   stiff is what it bears. */
static PetscInt AddedAtEnd(WideLine line) {
  const Link *last = &line->link[line->n];
  PetscReal P[OWN][TOP], Q[OWN][OWN], force[OWN][TOP] = {{0}};
  Six C, K = {{0}}, skew, R = {{0}};
  int held = 0;

  if (!Compliance(last, C)) return 0;
  for (int i = 0; i < OWN; i++) {
    PetscBool free = PETSC_FALSE;
    memcpy(P[i], line->own[i], TOP * sizeof(PetscReal));
    memcpy(Q[i], line->own[i] + TOP, OWN * sizeof(PetscReal));
    for (int j = 0; j < OWN; j++)
      if (Q[i][j] != 0) free = PETSC_TRUE;
    if (free) continue;
    for (int k = 0; k < OWN; k++)
      for (int j = 0; j < TOP; j++) R[held][k] += P[i][j] * last->arms.way[k][j];
    held++;
  }
  if (!held && Invert(Q)) {
    Times(OWN, OWN, TOP, 1, Q[0], OWN, P[0], TOP, force[0], TOP);
    AlongWays((const PetscReal(*)[TOP])force, &last->arms, K);
    Skew(&last->arms, skew);
    for (int i = 0; i < OWN; i++)
      for (int j = 0; j < OWN; j++) K[i][j] -= skew[i][j];
  }
  Symmetric(K);
  if (line->plane) LeaveOutOfPlane(C, K);
  return Added(C, K, held, R);
}

/* May a direction have turned anywhere? */
static PetscBool Turns(WideLine line) {
  const PetscReal much = 0.3;

  for (PetscInt i = 0; i < line->n; i++) {
    const Link *link = &line->link[i];
    PetscReal most = 0;
    for (int k = 0; k < TOP; k++)
      if (link->row[k] != k || !(link->S[k][k] > 0)) return PETSC_TRUE;
    if (link->arms.twist == 0) continue;
    for (int k = 0; k < TOP; k++)
      for (int j = 0; j < 3; j++) most = PetscMax(most, PetscAbsReal(link->T[k][TOP + j]));
    if (PetscAbsReal(link->arms.twist) * most > much) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Can C and K of a node be resolved beside each other? */
static PetscBool Resolved(Six C, Six K) {
  const PetscReal most = 1e9;
  PetscReal c = 0, k = 0;

  for (int i = 0; i < OWN; i++)
    for (int j = 0; j < OWN; j++) {
      c = PetscMax(c, PetscAbsReal(C[i][j]));
      k = PetscMax(k, PetscAbsReal(K[i][j]));
    }
  return (PetscBool)(c * k < most);
}

/* WideIndex - the index of the matrix eliminated last (EliminationIndex()); WideArm() has told the
   arms of all nodes. Below 0: it is not known, for round-off. */
PetscInt WideIndex(WideLine line) {
  PetscInt index = AddedAtEnd(line);
  Six C, K;

  if (!Turns(line)) return index;
  for (PetscInt i = 0; i < line->n; i++) {
    if (!Compliance(&line->link[i], C) || !Stiffness(&line->link[i], K) || !Resolved(C, K))
      return -1;
    if (line->plane) LeaveOutOfPlane(C, K);
    index += Added(C, K, 0, NULL);
  }
  return index;
}
