/*
  The unknowns of node i are y_i, six. Cell i, between nodes i and i + 1, has six equations; the
  first three are rows of node i + 1, the last three rows of node i:
      L y_i + R y_{i+1} = b_{i+1},     B y_i + U y_{i+1} = b_i.
  The first node's first three rows T_0 are given. The last node has no cell behind it, its last
  three rows are equations of its own.

  What is before node i says T_i y_i = d_i, three equations. With its own rows and their right-hand
  sides, A_i = (T_i; B) and v_i = (d_i; b_i), that is
      A_i y_i = v_i - (0; U y_{i+1}),
  and makes for the next node, with X = L A_i^-1,
      T_{i+1} = R - X (0; U),     d_{i+1} = b_{i+1} - X v_i.
  This is block elimination of a block tridiagonal matrix in its natural order, without the rows
  that are zero by the arrangement of the equations. A = (V, W; P, Q) is factored by halves: first
  Q, which fine cells keep near -1, by its inverse; then S = V - W Q^-1 P with partial pivoting, for
  it may be nearly singular.
*/
#include "base/line.h"
#include <string.h>

enum { FIELDS = LINE_FIELDS, HALF = LINE_HALF };

typedef LineSquare Square;
typedef LineRows Half;
typedef LineLink Link;

/* The columns of a half from one on, as a square. */
static inline void Columns(const Half A, int from, Square B) {
  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++) B[i][j] = A[i][from + j];
}

/* C = A B */
static inline void Multiply(const Square A, const Square B, Square C) {
  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++)
      C[i][j] = A[i][0] * B[0][j] + A[i][1] * B[1][j] + A[i][2] * B[2][j];
}

/* C -= A B */
static inline void MultiplySubtract(const Square A, const Square B, Square C) {
  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++)
      C[i][j] -= A[i][0] * B[0][j] + A[i][1] * B[1][j] + A[i][2] * B[2][j];
}

/* B = A^-1, by its cofactors; false if there is none. */
static inline PetscBool Invert(const Square A, Square B) {
  PetscReal c0 = A[1][1] * A[2][2] - A[1][2] * A[2][1], c1 = A[1][2] * A[2][0] - A[1][0] * A[2][2],
            c2 = A[1][0] * A[2][1] - A[1][1] * A[2][0],
            det = A[0][0] * c0 + A[0][1] * c1 + A[0][2] * c2, f = 1 / det;

  B[0][0] = f * c0;
  B[1][0] = f * c1;
  B[2][0] = f * c2;
  B[0][1] = f * (A[0][2] * A[2][1] - A[0][1] * A[2][2]);
  B[1][1] = f * (A[0][0] * A[2][2] - A[0][2] * A[2][0]);
  B[2][1] = f * (A[0][1] * A[2][0] - A[0][0] * A[2][1]);
  B[0][2] = f * (A[0][1] * A[1][2] - A[0][2] * A[1][1]);
  B[1][2] = f * (A[0][2] * A[1][0] - A[0][0] * A[1][2]);
  B[2][2] = f * (A[0][0] * A[1][1] - A[0][1] * A[1][0]);
  return (PetscBool)(PetscAbsReal(f) <= PETSC_MAX_REAL); /* (not so for NaN) */
}

/* S = LU in place, rows in the order of the pivots, whose reciprocals are kept; false if it is
   singular. */
static inline PetscBool Factor(Square S, int row[HALF]) {
  for (int k = 0; k < HALF; k++) row[k] = k;
  for (int k = 0; k < HALF; k++) {
    int best = k;
    for (int i = k + 1; i < HALF; i++)
      if (PetscAbsReal(S[i][k]) > PetscAbsReal(S[best][k])) best = i;
    if (best != k) {
      int r = row[k];
      row[k] = row[best];
      row[best] = r;
      for (int j = 0; j < HALF; j++) {
        PetscReal a = S[k][j];
        S[k][j] = S[best][j];
        S[best][j] = a;
      }
    }
    S[k][k] = 1 / S[k][k];
    if (!(PetscAbsReal(S[k][k]) <= PETSC_MAX_REAL)) return PETSC_FALSE; /* (nor is NaN) */
    for (int i = k + 1; i < HALF; i++) {
      PetscReal f = S[i][k] *= S[k][k];
      for (int j = k + 1; j < HALF; j++) S[i][j] -= f * S[k][j];
    }
  }
  return PETSC_TRUE;
}

/* E = L S^-1 */
static inline void DivideByFactors(const Half S, const int row[HALF], const Square L, Square E) {
  for (int i = 0; i < HALF; i++) {
    PetscReal x = L[i][0] * S[0][0], y = (L[i][1] - x * S[0][1]) * S[1][1],
              z = (L[i][2] - x * S[0][2] - y * S[1][2]) * S[2][2];
    y -= z * S[2][1];
    x -= y * S[1][0] + z * S[2][0];
    E[i][row[0]] = x;
    E[i][row[1]] = y;
    E[i][row[2]] = z;
  }
}

/* w = S^-1 d */
static inline void SolveByFactors(const Half S, const int row[HALF], const PetscReal d[],
                                  PetscReal w[]) {
  PetscReal x = d[row[0]], y = d[row[1]] - S[1][0] * x,
            z = (d[row[2]] - S[2][0] * x - S[2][1] * y) * S[2][2];
  y = (y - S[1][2] * z) * S[1][1];
  w[0] = (x - S[0][1] * y - S[0][2] * z) * S[0][0];
  w[1] = y;
  w[2] = z;
}

/* LineDivide - X = M A^-1 of a node that is factored, M = (L, K): X = (E, F), F = K Q^-1 - E N, E =
 * (L - K Q^-1 P) S^-1 */
void LineDivide(const Link *link, const Half M, Half X) {
  Square L, K, N, E, F;

  Columns(M, 0, L);
  Columns(M, HALF, K);
  Columns(link->T, HALF, N);
  Multiply(K, link->Q, F);
  MultiplySubtract(F, link->P, L);
  DivideByFactors(link->T, link->row, L, E);
  MultiplySubtract(E, N, F);
  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++) {
      X[i][j] = E[i][j];
      X[i][HALF + j] = F[i][j];
    }
}

/* y = A^-1 v */
static inline void SolveByNode(const Link *link, const PetscReal v[], PetscReal y[]) {
  const PetscReal *b = v + HALF;
  PetscReal d[HALF], w[HALF];

  for (int i = 0; i < HALF; i++) {
    const PetscReal *N = link->T[i] + HALF;
    d[i] = v[i] - N[0] * b[0] - N[1] * b[1] - N[2] * b[2];
  }
  SolveByFactors(link->T, link->row, d, w);
  for (int i = 0; i < HALF; i++) {
    const PetscReal *P = link->P[i];
    d[i] = b[i] - P[0] * w[0] - P[1] * w[1] - P[2] * w[2];
  }
  for (int i = 0; i < HALF; i++) {
    const PetscReal *Q = link->Q[i];
    y[i] = w[i];
    y[HALF + i] = Q[0] * d[0] + Q[1] * d[1] + Q[2] * d[2];
  }
}

/* r -= M v */
static inline void Subtract(const Half M, const PetscReal v[], PetscReal r[]) {
  for (int i = 0; i < HALF; i++)
    for (int k = 0; k < FIELDS; k++) r[i] -= M[i][k] * v[k];
}

/* LineSubtractProduct - C -= M (0; U). */
void LineSubtractProduct(const Half M, const Half U, Half C) {
  for (int i = 0; i < HALF; i++)
    for (int k = 0; k < FIELDS; k++)
      C[i][k] -= M[i][HALF] * U[0][k] + M[i][HALF + 1] * U[1][k] + M[i][HALF + 2] * U[2][k];
}

/* Factors a node, whose own equations are B = (P, Q). */
static inline void LineFactor(Line *line, const Half B) {
  Link *link = &line->link[line->n];
  PetscBool regular;
  Square V, W, Q, N;

  Columns(B, 0, link->P);
  Columns(B, HALF, Q);
  Columns(link->T, 0, V);
  Columns(link->T, HALF, W);
  regular = Invert(Q, link->Q);
  Multiply(W, link->Q, N);
  MultiplySubtract(N, link->P, V);
  if (!Factor(V, link->row) || !regular) line->regular = PETSC_FALSE;
  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++) {
      link->T[i][j] = V[i][j];
      link->T[i][HALF + j] = N[i][j];
    }
}

/* LineCell - eliminates the node before a cell, whose equations by its nodes are a and b. */
void LineCell(Line *line, LineBlock a, LineBlock b) {
  Link *link = &line->link[line->n];

  LineFactor(line, a + HALF);
  LineDivide(link, a, link->X);
  memcpy(link->U, b + HALF, sizeof(Half));
  memcpy(link[1].T, b, sizeof(Half));
  LineSubtractProduct(link->X, link->U, link[1].T);
  line->n++;
}

/* LineBegin - a new matrix; T are the first three rows of the first node. */
void LineBegin(Line *line, const Half T) {
  line->n = 0;
  line->regular = PETSC_TRUE;
  memcpy(line->link[0].T, T, sizeof(Half));
}

/* LineEnd - the last node's own three equations, whatever they are. */
void LineEnd(Line *line, const Half own) {
  const Link *last = &line->link[line->n];
  PetscBLASInt n = FIELDS, info;

  memcpy(line->own, own, sizeof(Half));
  for (int k = 0; k < FIELDS; k++)
    for (int i = 0; i < HALF; i++) {
      line->last[k * FIELDS + i] = last->T[i][k];
      line->last[k * FIELDS + HALF + i] = own[i][k];
    }
  LAPACKgetrf_(&n, &n, line->last, &n, line->pivots, &info);
  if (info || PetscIsInfOrNanReal(line->last[0])) line->regular = PETSC_FALSE;
}

/*
  LineForward - the right-hand sides v of all nodes, into x, from b and from the d of the first,
  which is in x already.

  nodes   of b and x; a line may have one more cell behind the last of them:
  behind  b of the first half of the node there
  beyond  gets its d
*/
void LineForward(const Line *line, PetscInt nodes, const PetscReal (*b)[FIELDS],
                 const PetscReal behind[], PetscReal (*x)[FIELDS], PetscReal beyond[]) {
  for (PetscInt i = 0; i < line->n; i++) {
    const PetscReal *next = i + 1 < nodes ? b[i + 1] : behind;
    PetscReal *d = i + 1 < nodes ? x[i + 1] : beyond;
    for (int f = 0; f < HALF; f++) {
      x[i][HALF + f] = b[i][HALF + f];
      d[f] = next[f];
    }
    Subtract(line->link[i].X, x[i], d);
  }
}

/* The unknowns of the last node, into x, which has its d; own is the right-hand side of its own
   equations. */
static void LineTurn(const Line *line, const PetscReal own[], PetscReal x[]) {
  PetscBLASInt n = FIELDS, one = 1, info;

  for (int f = 0; f < HALF; f++) x[HALF + f] = own[f];
  LAPACKgetrs_("N", &n, &one, (PetscReal *)line->last, &n, (PetscBLASInt *)line->pivots, x, &n,
               &info);
}

/* LineBackward - the unknowns of all nodes before the last, into x, which has their v; y are those
   of the last. */
void LineBackward(const Line *line, const PetscReal y[], PetscReal (*x)[FIELDS]) {
  for (PetscInt i = line->n - 1; i >= 0; i--) {
    Subtract(line->link[i].U, y, x[i] + HALF);
    SolveByNode(&line->link[i], x[i], x[i]);
    y = x[i];
  }
}

/* LineSolve - the unknowns x of a line that is whole, by b, both of all its nodes. */
void LineSolve(const Line *line, const PetscReal (*b)[FIELDS], PetscReal (*x)[FIELDS]) {
  PetscInt n = line->n;

  for (int f = 0; f < HALF; f++) x[0][f] = b[0][f];
  LineForward(line, n + 1, b, NULL, x, NULL);
  LineTurn(line, b[n] + HALF, x[n]);
  LineBackward(line, x[n], x);
}

/*
  The index: how many negative directions the quadratic form has of which the equations say that it
  is stationary, less those that the forces count for, which are half of the unknowns. It is the sum
  of what each node adds when it is eliminated. Let x be the first half of a node's unknowns and f
  the second, each f_j the force that belongs to x_pair[j]. What is before the node says
  x = d + C f, its compliance; the node's own equations are f + K x = ..., its stiffness. It adds
      negative(C^-1 + K) - negative(C^-1):
  for each eigenvector v of 1 + C K with a negative eigenvalue 1, if v K v < 0, else -1 (follow
  C^-1 + a K from a = 0 to 1). So where something is added a compliance passes through infinity: as
  the sign changes in a Sturm sequence, or the conjugate points of Jacobi. A cell's stiffness is at
  both of its nodes, and the part at its second is in V of that node already: V - W Q^-1 P is
  1 + C K with both.
*/
static PetscInt Directions(const Square S, PetscReal sign, const Square K, const int pair[HALF]) {
  PetscReal A[HALF * HALF], real[HALF], imaginary[HALF], vectors[HALF * HALF], none[1],
      work[8 * HALF];
  PetscBLASInt n = HALF, one = 1, size = 8 * HALF, info;
  PetscInt added = 0;

  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++) {
      A[j * HALF + i] = sign * S[i][j];
      if (PetscIsInfOrNanReal(S[i][j])) return line_unknown; /* LAPACK would end the program */
    }
  LAPACKgeev_("N", "V", &n, A, &n, real, imaginary, none, &one, vectors, &n, work, &size, &info);
  for (int k = 0; k < HALF && !info; k++) {
    const PetscReal *v = vectors + k * HALF;
    PetscReal energy = 0;
    if (imaginary[k] != 0 || real[k] > 0) continue;
    for (int i = 0; i < HALF; i++)
      energy += v[pair[i]] * (K[i][0] * v[0] + K[i][1] * v[1] + K[i][2] * v[2]);
    added += energy < 0 ? 1 : -1;
  }
  return added;
}

/* S of a node that is factored. */
static void Recover(const Link *link, Square S) {
  for (int k = 0; k < HALF; k++)
    for (int j = 0; j < HALF; j++) {
      S[link->row[k]][j] = j < k ? 0 : j == k ? 1 / link->T[k][k] : link->T[k][j];
      for (int m = 0; m < k; m++)
        S[link->row[k]][j] += link->T[k][m] * (m > j    ? 0
                                               : m == j ? 1 / link->T[m][m]
                                                        : link->T[m][j]);
    }
}

/* Is det(sign S) < 0? */
static inline PetscBool Turns(const Link *link, PetscReal sign) {
  const PetscReal pivots = sign * link->T[0][0] * link->T[1][1] * link->T[2][2];
  PetscBool even = (PetscBool)((link->row[1] - link->row[0] + HALF) % HALF == 1);

  return (PetscBool)((pivots < 0) == (int)even);
}

/* The stiffness at the second node of the cell behind a link. */
static void Behind(const Link *link, Square K) {
  Square U, inverse;

  Columns(link->U, HALF, U);
  (void)Invert(U, inverse);
  Columns(link->U, 0, U);
  Multiply(inverse, U, K);
  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++) K[i][j] = -K[i][j];
}

/*
  LineIndex - the index of all nodes but the last. Cells must be fine: each node turns one direction
  at most.

  sign  of V, which is about sign I, of all nodes but the first, where it is 1
*/
PetscInt LineIndex(const Line *line, PetscReal sign, const int pair[HALF]) {
  PetscInt index = 0;
  Square S, K;

  for (PetscInt i = 0; i < line->n; i++) {
    const Link *link = &line->link[i];
    PetscReal own = i ? sign : 1;
    if (!Turns(link, own)) continue;
    Recover(link, S);
    Multiply(link->Q, link->P, K);
    index += Directions(S, own, K, pair);
  }
  return index;
}

/* Is det(sign V) < 0? */
static PetscBool Reversed(const Square V, PetscReal sign) {
  const PetscReal det = V[0][0] * (V[1][1] * V[2][2] - V[1][2] * V[2][1]) +
                        V[0][1] * (V[1][2] * V[2][0] - V[1][0] * V[2][2]) +
                        V[0][2] * (V[1][0] * V[2][1] - V[1][1] * V[2][0]);

  return (PetscBool)(sign * det < 0);
}

/* LineIndexOfArrival - what the last cell adds at the last node, of which T is said when it is
   arrived at: one direction at most. (Where friction holds a rod so fast that cells are not fine
   beside it, directions turn round in pairs, which are none.) */
PetscInt LineIndexOfArrival(const Line *line, const Half T, PetscReal sign, const int pair[HALF]) {
  Square V, K;

  Columns(T, 0, V);
  if (!line->n || !Reversed(V, sign)) return 0;
  Behind(&line->link[line->n - 1], K);
  return Directions(V, sign, K, pair);
}

/* S <- V^-1 S, which is 1 + C K of what comes behind V, where V has been counted. */
static void Relative(const Square V, Square S) {
  PetscReal column[HALF], solved[HALF];
  Square A;
  Half factors;
  int row[HALF];

  memcpy(A, V, sizeof(A));
  if (!Factor(A, row)) return;
  for (int i = 0; i < HALF; i++) memcpy(factors[i], A[i], sizeof(A[i]));
  for (int j = 0; j < HALF; j++) {
    for (int i = 0; i < HALF; i++) column[i] = S[i][j];
    SolveByFactors((const PetscReal(*)[FIELDS])factors, row, column, solved);
    for (int i = 0; i < HALF; i++) S[i][j] = solved[i];
  }
}

/* LineIndexOfNode - what node i before the last adds by its own equations, however many directions;
   T is said of it when it is arrived at. */
PetscInt LineIndexOfNode(const Line *line, PetscInt i, const Half T, const int pair[HALF]) {
  Square V, S, K;

  Columns(T, 0, V);
  Recover(&line->link[i], S);
  Multiply(line->link[i].Q, line->link[i].P, K);
  Relative(V, S);
  return Directions(S, 1, K, pair);
}

/* What a last node adds that is held: K is infinite in n directions of x, at place. */
static PetscInt Held(const Square C, int n, const int place[HALF]) {
  const Square stiff = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int same[HALF] = {0, 1, 2};
  Square part = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) part[i][j] = C[place[i]][place[j]];
  return Directions(part, 1, stiff, same);
}

/* LineIndexOfEnd - what the last node adds by its own equations. */
PetscInt LineIndexOfEnd(const Line *line, const int pair[HALF]) {
  Square V, W, P, Q, A, C, K, S;
  int place[HALF], held = 0;

  Columns(line->link[line->n].T, 0, V);
  Columns(line->link[line->n].T, HALF, W);
  Columns(line->own, 0, P);
  Columns(line->own, HALF, Q);
  for (int i = 0; i < HALF; i++) /* an equation of x alone holds it */
    for (int j = 0; j < HALF; j++)
      if (Q[i][0] == 0 && Q[i][1] == 0 && Q[i][2] == 0 && P[i][j] != 0) place[held++] = j;
  if (held) {
    if (!Invert(V, A)) return 0;
    Multiply(A, W, K);
    for (int i = 0; i < HALF; i++)
      for (int j = 0; j < HALF; j++) C[i][pair[j]] = -K[i][j];
    return Held(C, held, place);
  }
  if (!Invert(Q, A)) return 0;
  Multiply(A, P, K);
  memcpy(S, V, sizeof(S));
  MultiplySubtract(W, K, S);
  Relative(V, S);
  return Directions(S, 1, K, pair);
}

/* LineCreate - for so many nodes at most; the caller ends it with LineDestroy(). */
PetscErrorCode LineCreate(PetscInt nodes, Line *line) {
  PetscFunctionBegin;
  PetscCall(PetscCalloc1(nodes, &line->link));
  PetscFunctionReturn(0);
}

PetscErrorCode LineDestroy(Line *line) {
  PetscFunctionBegin;
  PetscCall(PetscFree(line->link));
  PetscFunctionReturn(0);
}
