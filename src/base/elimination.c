/*
  The unknowns of node i are y_i, six. Cell i, between nodes i and i + 1, has six equations; the
  first three are rows of node i + 1, the last three rows of node i:
      L y_i + R y_{i+1} = b_{i+1},     B y_i + U y_{i+1} = b_i.
  At the clamp the first three of y_0 are given. The tip's node has no cell on its right, its last
  three rows are equations of its own.

  What is before node i says T_i y_i = d_i, three equations, T_0 = (I, 0). With its own rows and
  their right-hand sides, A_i = (T_i; B) and v_i = (d_i; b_i), that is
      A_i y_i = v_i - (0; U y_{i+1}),
  and makes for the next node, with X = L A_i^-1,
      T_{i+1} = R - X (0; U),     d_{i+1} = b_{i+1} - X v_i.
  This is block elimination of a block tridiagonal matrix in its natural order, without the rows
  that are zero by the arrangement of the equations. A = (V, W; P, Q) is factored by halves: first
  Q, which fine cells keep near -1, by its inverse; then S = V - W Q^-1 P with partial pivoting, for
  it may be nearly singular.

  Several ranks: each has the cells that begin at its nodes. But for the first they do not know the
  first half of their first node: it is a parameter p. With z the other half, what they find is
      T y_end = d + D p,     z = h + F y_end + G p,
  six equations between that node and the next rank's first, or the tip: a cell, like the others.
  So the ranks' cells are a line themselves, which every rank eliminates for itself in the same way;
  its cost grows like the number of ranks. With p known, each goes through its own nodes again.
  (The tip is no part of the last rank's span: a piece of rod between two ends that are held is so
  much stiffer than the whole that digits would be lost.)
*/
#include "base/elimination.h"
#include <petscblaslapack.h>
#include <string.h>

enum { FIELDS = LINE_FIELDS, HALF = LINE_HALF };

typedef PetscReal Square[HALF][HALF];
typedef PetscReal Half[HALF][FIELDS];
typedef const PetscReal Block[FIELDS][FIELDS];

/* A node and the cell on its right. */
typedef struct {
  Half T;        /* (V, W), until the node is eliminated: then the factors of S, and N = W Q^-1 */
  int row[HALF]; /* of S, in the order of the pivots */
  Square Q, P;   /* the inverse of Q */
  Half X, U;
} Link;

/* How a rank's last node depends on its parameter and its first node on its last; and the tip's
   equations, on the last rank. */
typedef struct {
  Half T, F, tip;
  Square D, G;
} Span;

/* Its right-hand sides. */
typedef struct {
  PetscReal d[HALF], h[HALF], tip[HALF];
} Moved;

/* Links, one after the other. */
typedef struct {
  PetscInt n;                     /* cells so far */
  Link *link;                     /* n + 1 */
  PetscReal tip[FIELDS * FIELDS]; /* factors of the last node, whose own equations are any */
  PetscBLASInt pivots[FIELDS];
  PetscBool regular;
} Line;

struct _Elimination {
  MPI_Comm comm;
  PetscMPIInt rank, ranks;
  PetscInt nodes;  /* owned */
  Line own, joint; /* node r of the joint is the last of rank r's cells */
  Span span;       /* of own, up to where it is */
  Span *spans;     /* of all ranks */
  Half *reach;     /* F A^-1 of each link: how its v moves z of the first node; not on rank 0 */
};

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

/* X = M A^-1, M = (L, K): X = (E, F), F = K Q^-1 - E N, E = (L - K Q^-1 P) S^-1 */
static inline void DivideByNode(const Link *link, const Half M, Half X) {
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

/* C -= M (0; U) */
static inline void SubtractProduct(const Half M, const Half U, Half C) {
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

/* Eliminates the node before a cell, whose equations by its nodes are a and b. */
static inline void LineCell(Line *line, Block a, Block b) {
  Link *link = &line->link[line->n];

  LineFactor(line, a + HALF);
  DivideByNode(link, a, link->X);
  memcpy(link->U, b + HALF, sizeof(Half));
  memcpy(link[1].T, b, sizeof(Half));
  SubtractProduct(link->X, link->U, link[1].T);
  line->n++;
}

/* The right-hand sides v of all nodes of a line, into x, from b and from the d of the first, which
   is in x already; behind is the b of the first half behind the last cell, beyond its d. */
static inline void LineForward(const Line *line, PetscInt nodes, const PetscReal (*b)[FIELDS],
                               const PetscReal behind[], PetscReal (*x)[FIELDS],
                               PetscReal beyond[]) {
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

/* From the end back: y of nodes n - 1 ... 0; behind them is y. */
static inline void LineBackward(const Line *line, PetscInt n, const PetscReal *y,
                                PetscReal (*x)[FIELDS]) {
  for (PetscInt i = n - 1; i >= 0; i--) {
    Subtract(line->link[i].U, y, x[i] + HALF);
    SolveByNode(&line->link[i], x[i], x[i]);
    y = x[i];
  }
}

/* The last node. */
static void LineTip(Line *line, const Half tip) {
  const Link *last = &line->link[line->n];
  PetscBLASInt n = FIELDS, info;

  for (int k = 0; k < FIELDS; k++)
    for (int i = 0; i < HALF; i++) {
      line->tip[k * FIELDS + i] = last->T[i][k];
      line->tip[k * FIELDS + HALF + i] = tip[i][k];
    }
  LAPACKgetrf_(&n, &n, line->tip, &n, line->pivots, &info);
  if (info || PetscIsInfOrNanReal(line->tip[0])) line->regular = PETSC_FALSE;
}

/* The unknowns of the last node, with the tip's right-hand side. */
static void LineTurn(const Line *line, const PetscReal tip[], PetscReal x[]) {
  PetscBLASInt n = FIELDS, one = 1, info;

  for (int f = 0; f < HALF; f++) x[HALF + f] = tip[f];
  LAPACKgetrs_("N", &n, &one, (PetscReal *)line->tip, &n, (PetscBLASInt *)line->pivots, x, &n,
               &info);
}

/*
  EliminationCreate - for a line of nodes of which this rank owns so many, in order of the ranks.
  Collective; the caller destroys it with EliminationDestroy().
*/
PetscErrorCode EliminationCreate(MPI_Comm comm, PetscInt nodes, Elimination *self) {
  PetscFunctionBegin;
  PetscCall(PetscNew(self));
  (*self)->comm = comm;
  (*self)->nodes = nodes;
  PetscCallMPI(MPI_Comm_size(comm, &(*self)->ranks));
  PetscCallMPI(MPI_Comm_rank(comm, &(*self)->rank));
  PetscCall(PetscCalloc1(nodes + 1, &(*self)->own.link));
  PetscCall(PetscCalloc1((*self)->ranks + 1, &(*self)->joint.link));
  PetscCall(PetscCalloc1((*self)->ranks, &(*self)->spans));
  if ((*self)->rank) PetscCall(PetscCalloc1(nodes + 1, &(*self)->reach));
  PetscFunctionReturn(0);
}

PetscErrorCode EliminationDestroy(Elimination *self) {
  PetscFunctionBegin;
  if (!*self) PetscFunctionReturn(0);
  PetscCall(PetscFree((*self)->own.link));
  PetscCall(PetscFree((*self)->joint.link));
  PetscCall(PetscFree((*self)->spans));
  PetscCall(PetscFree((*self)->reach));
  PetscCall(PetscFree(*self));
  PetscFunctionReturn(0);
}

/* C (0, at column first) = I */
static void Identity(PetscReal *C, int columns, int first) {
  memset(C, 0, HALF * columns * sizeof(*C));
  for (int i = 0; i < HALF; i++) C[i * columns + first + i] = 1;
}

static void LineBegin(Line *line, const Half T) {
  line->n = 0;
  line->regular = PETSC_TRUE;
  memcpy(line->link[0].T, T, sizeof(Half));
}

/* EliminationBegin - a new matrix: its cells follow from the clamp to the tip. */
void EliminationBegin(Elimination self) {
  Span *span = &self->span;

  memset(span, 0, sizeof(*span));
  Identity(&span->T[0][0], FIELDS, 0);
  Identity(&span->F[0][0], FIELDS, HALF);
  Identity(&span->D[0][0], HALF, 0);
  LineBegin(&self->own, (const PetscReal(*)[FIELDS])span->T);
}

/* How the span goes on over a link, with H = F A^-1:
     D' = -X (D; 0),  G' = G + H (D; 0),  F' = -H (0; U) */
static void SpanCell(Elimination self, const Link *link, Half H) {
  Span *span = &self->span;
  Square D;

  DivideByNode(link, (const PetscReal(*)[FIELDS])span->F, H);
  memcpy(D, span->D, sizeof(D));
  memset(span->F, 0, sizeof(span->F));
  SubtractProduct((const PetscReal(*)[FIELDS])H, link->U, span->F);
  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++) {
      span->D[i][j] = -link->X[i][0] * D[0][j] - link->X[i][1] * D[1][j] - link->X[i][2] * D[2][j];
      span->G[i][j] += H[i][0] * D[0][j] + H[i][1] * D[1][j] + H[i][2] * D[2][j];
    }
}

/* EliminationCell - eliminates a cell of this rank: six equations by the unknowns of its nodes, a
   and b; first the three that are rows of b, then those that are rows of a. */
void EliminationCell(Elimination self, Block a, Block b) {
  PetscInt i = self->own.n;

  LineCell(&self->own, a, b);
  if (self->rank) SpanCell(self, &self->own.link[i], self->reach[i]);
}

/* EliminationTip - the last three equations, rows of the last node; on the last rank. */
void EliminationTip(Elimination self, const Half tip) {
  memcpy(self->span.tip, tip, sizeof(Half));
  if (self->ranks == 1) LineTip(&self->own, tip);
}

/* The line of the ranks. */
static void Join(Elimination self) {
  Line *joint = &self->joint;
  PetscReal a[FIELDS][FIELDS] = {{0}}, b[FIELDS][FIELDS];

  LineBegin(joint, (const PetscReal(*)[FIELDS])self->spans[0].T);
  Identity(&a[HALF][0], FIELDS, HALF);
  for (PetscMPIInt r = 1; r < self->ranks; r++) {
    const Span *span = &self->spans[r];
    memcpy(b, span->T, sizeof(Half));
    for (int i = 0; i < HALF; i++) {
      for (int j = 0; j < HALF; j++) {
        a[i][j] = -span->D[i][j];
        a[HALF + i][j] = -span->G[i][j];
      }
      for (int k = 0; k < FIELDS; k++) b[HALF + i][k] = -span->F[i][k];
    }
    LineCell(joint, (const PetscReal(*)[FIELDS])a, (const PetscReal(*)[FIELDS])b);
  }
  LineTip(joint, (const PetscReal(*)[FIELDS])self->spans[self->ranks - 1].tip);
}

/* EliminationEnd - all cells of all ranks are there. Collective. */
PetscErrorCode EliminationEnd(Elimination self) {
  enum { VALUES = sizeof(Span) / sizeof(PetscReal) };

  PetscFunctionBegin;
  if (self->ranks == 1) PetscFunctionReturn(0);
  memcpy(self->span.T, self->own.link[self->own.n].T, sizeof(Half));
  PetscCallMPI(
      MPI_Allgather(&self->span, VALUES, MPIU_REAL, self->spans, VALUES, MPIU_REAL, self->comm));
  Join(self);
  PetscFunctionReturn(0);
}

/* h of this rank, whose x has v. */
static void SpanMoved(const Elimination self, const PetscReal (*x)[FIELDS], PetscReal h[HALF]) {
  for (PetscInt i = 0; i < self->own.n; i++)
    for (int f = 0; f < HALF; f++)
      for (int k = 0; k < FIELDS; k++) h[f] += self->reach[i][f][k] * x[i][k];
}

/* The unknowns of the joint's nodes. */
static void SolveJoint(const Elimination self, const Moved moved[], PetscReal (*b)[FIELDS],
                       PetscReal (*x)[FIELDS]) {
  PetscInt n = self->joint.n;

  for (PetscInt k = 0; k <= n; k++)
    for (int f = 0; f < HALF; f++) {
      b[k][f] = moved[k].d[f];
      b[k][HALF + f] = k < n ? moved[k + 1].h[f] : moved[n].tip[f];
    }
  for (int f = 0; f < HALF; f++) x[0][f] = b[0][f];
  LineForward(&self->joint, n + 1, (const PetscReal(*)[FIELDS])b, NULL, x, NULL);
  LineTurn(&self->joint, b[n] + HALF, x[n]);
  LineBackward(&self->joint, n, x[n], x);
}

/* The first pass of several ranks: finds the unknowns at the ends of this rank's cells. Collective.
 */
static PetscErrorCode FindEnds(Elimination self, const PetscReal (*b)[FIELDS],
                               const PetscReal behind[], PetscReal (*x)[FIELDS], PetscReal begin[],
                               PetscReal end[]) {
  enum { VALUES = sizeof(Moved) / sizeof(PetscReal) };
  PetscReal(*rhs)[FIELDS], (*joint)[FIELDS];
  PetscInt n = self->own.n;
  Moved *moved, mine = {.d = {0}};

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(self->ranks, &moved, self->ranks, &rhs, self->ranks, &joint));
  LineForward(&self->own, self->nodes, b, behind, x, mine.d);
  if (n < self->nodes)
    for (int f = 0; f < HALF; f++) {
      mine.d[f] = x[n][f];
      mine.tip[f] = b[n][HALF + f];
    }
  if (self->rank) SpanMoved(self, (const PetscReal(*)[FIELDS])x, mine.h);
  PetscCallMPI(MPI_Allgather(&mine, VALUES, MPIU_REAL, moved, VALUES, MPIU_REAL, self->comm));
  SolveJoint(self, moved, rhs, joint);
  if (self->rank) PetscCall(PetscArraycpy(begin, joint[self->rank - 1], HALF));
  PetscCall(PetscArraycpy(end, joint[self->rank], FIELDS));
  PetscCall(PetscFree3(moved, rhs, joint));
  PetscFunctionReturn(0);
}

/* The equations of w behind this rank's last cell are rows of the next rank's first node. */
static PetscErrorCode FetchBehind(const Elimination self, const PetscReal first[],
                                  PetscReal behind[HALF]) {
  PetscMPIInt left = self->rank ? self->rank - 1 : MPI_PROC_NULL,
              right = self->rank + 1 < self->ranks ? self->rank + 1 : MPI_PROC_NULL;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Sendrecv(first, HALF, MPIU_REAL, left, 0, behind, HALF, MPIU_REAL, right, 0,
                            self->comm, MPI_STATUS_IGNORE));
  PetscFunctionReturn(0);
}

static PetscErrorCode Solve(Elimination self, const PetscReal (*b)[FIELDS],
                            PetscReal (*x)[FIELDS]) {
  PetscInt n = self->own.n;
  PetscReal behind[HALF] = {0}, begin[HALF] = {0}, end[FIELDS], beyond[HALF];

  PetscFunctionBegin;
  if (!self->rank) PetscCall(PetscArraycpy(begin, b[0], HALF));
  if (self->ranks > 1) {
    PetscCall(FetchBehind(self, b[0], behind));
    PetscCall(PetscArraycpy(x[0], begin, HALF));
    PetscCall(FindEnds(self, b, behind, x, begin, end));
  }
  PetscCall(PetscArraycpy(x[0], begin, HALF));
  LineForward(&self->own, self->nodes, b, behind, x, beyond);
  if (self->ranks == 1)
    LineTurn(&self->own, b[n] + HALF, x[n]);
  else if (n < self->nodes)
    PetscCall(PetscArraycpy(x[n], end, FIELDS));
  LineBackward(&self->own, n, n < self->nodes ? x[n] : end, x);
  PetscFunctionReturn(0);
}

static PetscErrorCode SetUp(PC pc) {
  Elimination self;
  PetscBool regular;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &self));
  regular = self->ranks == 1 ? self->own.regular : self->joint.regular;
  PetscCall(PCSetFailedReason(pc, regular ? PC_NOERROR : PC_FACTOR_NUMERIC_ZEROPIVOT));
  PetscFunctionReturn(0);
}

static PetscErrorCode ApplyShell(PC pc, Vec b, Vec x) {
  Elimination self;
  const PetscScalar *from;
  PetscScalar *to;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &self));
  PetscCall(VecGetArrayRead(b, &from));
  PetscCall(VecGetArrayWrite(x, &to));
  PetscCall(Solve(self, (const PetscReal(*)[FIELDS])from, (PetscReal(*)[FIELDS])to));
  PetscCall(VecRestoreArrayWrite(x, &to));
  PetscCall(VecRestoreArrayRead(b, &from));
  PetscFunctionReturn(0);
}

/* EliminationSetType - makes a PC the exact solver of what has been eliminated when it is set up;
   self must outlive it. */
PetscErrorCode EliminationSetType(PC pc, Elimination self) {
  PetscFunctionBegin;
  PetscCall(PCSetType(pc, PCNONE)); /* (it may be another shell) */
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetName(pc, "elimination: cell by cell, along the rod"));
  PetscCall(PCShellSetContext(pc, self));
  PetscCall(PCShellSetSetUp(pc, SetUp));
  PetscCall(PCShellSetApply(pc, ApplyShell));
  PetscFunctionReturn(0);
}
