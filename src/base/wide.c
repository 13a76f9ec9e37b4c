/* A line of nodes of thirteen unknowns: halves.c eliminates it, the index is told here. */
#include "base/wide.h"
#include "base/clones.h"
#include "base/halves.h"
#include <petscblaslapack.h>
#include <string.h>

enum { TOP = WIDE_TOP, OWN = WIDE_OWN, ALL = WIDE_FIELDS };

struct _WideLine {
  PetscBool plane; /* directions out of the plane of x1 and x2 do not count */
  Halves line;
  WideArms *arms;          /* of all nodes, for the index */
  PetscReal own[OWN][ALL]; /* the last node's own equations */
};

/* WideCreate - for so many nodes at most; the caller ends it with WideDestroy(). */
PetscErrorCode WideCreate(PetscInt nodes, WideLine *line) {
  static const PetscInt halves[2] = {TOP, OWN};

  PetscFunctionBegin;
  PetscCall(PetscNew(line));
  PetscCall(HalvesCreate(nodes, halves, &(*line)->line));
  PetscCall(PetscCalloc1(nodes, &(*line)->arms));
  PetscFunctionReturn(0);
}

PetscErrorCode WideDestroy(WideLine *line) {
  PetscFunctionBegin;
  if (!*line) PetscFunctionReturn(0);
  PetscCall(HalvesDestroy(&(*line)->line));
  PetscCall(PetscFree((*line)->arms));
  PetscCall(PetscFree(*line));
  PetscFunctionReturn(0);
}

/* WideBegin - a new matrix: its cells follow; the first node's first seven unknowns are given. */
void WideBegin(WideLine line) {
  HalvesBegin(line->line);
}

/* WideSpring - behind WideBegin(): the first node's first seven unknowns are not given, but these
   products of its own six. */
void WideSpring(WideLine line, const PetscReal gives[TOP][OWN]) {
  PetscReal *T = HalvesFirst(line->line);

  for (int i = 0; i < TOP; i++)
    for (int j = 0; j < OWN; j++) T[i * ALL + TOP + j] = -gives[i][j];
}

/* WideKeep - keeps the next cell as it is, to be eliminated elsewhere. */
void WideKeep(WideLine line) {
  HalvesKeep(line->line);
}

/* WideArm - the arms of the node that the next cell begins at, or of the last; for WideIndex(). */
void WideArm(WideLine line, const WideArms *arms) {
  line->arms[HalvesCells(line->line)] = *arms;
}

/* WideBlocks - where the equations of the next cell by its nodes a and b are to be put; first the
   seven that are rows of b, then the six that are rows of a. */
void WideBlocks(WideLine line, PetscReal (**a)[ALL], PetscReal (**b)[ALL]) {
  HalvesBlocks(line->line, (PetscReal **)a, (PetscReal **)b);
}

/* WideCell - eliminates the node before the next cell, whose equations WideBlocks() has been given.
 */
void WideCell(WideLine line) {
  HalvesCell(line->line);
}

/* WideParts - of a line whose cells were kept: how many reals its cells and their arms are, and, in
   parts, what they are. */
enum {
  BLOCK = ALL * ALL,
  CELL_REALS = 2 * BLOCK,
  ARM_REALS = sizeof(WideArms) / sizeof(PetscReal)
};

PetscInt WideParts(WideLine line, PetscReal parts[]) {
  const PetscInt n = HalvesCells(line->line);

  for (PetscInt i = 0; i < n && parts; i++, parts += CELL_REALS + ARM_REALS) {
    const HalvesLink link = HalvesAt(line->line, i);
    for (int e = 0; e < 2; e++) memcpy(parts + e * BLOCK, link.cell[e], BLOCK * sizeof(PetscReal));
    memcpy(parts + CELL_REALS, &line->arms[i], sizeof(WideArms));
  }
  return n * (CELL_REALS + ARM_REALS);
}

/* WideTake - eliminates cells that are there in parts, so many reals. */
void WideTake(WideLine line, const PetscReal parts[], PetscInt reals) {
  for (PetscInt k = 0; k < reals; k += CELL_REALS + ARM_REALS) {
    PetscReal *cell[2];
    HalvesBlocks(line->line, &cell[0], &cell[1]);
    for (int e = 0; e < 2; e++) memcpy(cell[e], parts + k + e * BLOCK, BLOCK * sizeof(PetscReal));
    WideArm(line, (const WideArms *)(parts + k + CELL_REALS));
    WideCell(line);
  }
}

/* WideEnd - the last node's own six equations, whatever they are. */
void WideEnd(WideLine line, const PetscReal own[OWN][ALL]) {
  memcpy(line->own, own, sizeof(line->own));
  HalvesEnd(line->line, own[0]);
}

/* WideRegular - could it be factored? */
PetscBool WideRegular(WideLine line) {
  return HalvesRegular(line->line);
}

/* WideSolve - the unknowns x of the line by b, both of all its nodes. */
void WideSolve(WideLine line, const PetscReal (*b)[ALL], PetscReal (*x)[ALL]) {
  HalvesSolve(line->line, b[0], x[0]);
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
static PetscBool Compliance(WideLine line, PetscInt node, Six C) {
  const PetscReal(*T)[ALL] = (const PetscReal(*)[ALL])HalvesAt(line->line, node).T;
  const WideArms *arms = &line->arms[node];
  PetscReal V[TOP * TOP], X[TOP * OWN], Z[OWN * OWN], Y[OWN * OWN];
  PetscBool regular;
  Six skew;

  for (int i = 0; i < TOP; i++) {
    for (int j = 0; j < TOP; j++) V[i * TOP + j] = T[i][j];
    for (int j = 0; j < OWN; j++) X[i * OWN + j] = -T[i][TOP + j];
  }
  if (!Solve(TOP, OWN, V, X)) return PETSC_FALSE;
  Skew(arms, skew);
  for (int i = 0; i < OWN; i++)
    for (int j = 0; j < OWN; j++) {
      C[i][j] = 0;
      for (int k = 0; k < TOP; k++) C[i][j] += arms->way[i][k] * X[k * OWN + j];
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
static PetscBool Stiffness(WideLine line, PetscInt node, Six K) {
  const HalvesLink link = HalvesAt(line->line, node);
  const PetscReal(*a)[ALL] = (const PetscReal(*)[ALL])link.cell[0],
        (*b)[ALL] = (const PetscReal(*)[ALL])link.cell[1];
  const WideArms *arms = &line->arms[node];
  PetscReal A[ALL * ALL], X[TOP * ALL], turned[OWN][TOP], force[OWN][TOP];
  Six skew;

  Skew(arms + 1, skew); /* m_b = - [m/2] turn_b */
  memset(turned, 0, sizeof(turned));
  AddProduct(OWN, OWN, TOP, -1, skew[0], OWN, arms[1].way[0], TOP, turned[0], TOP);
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
  AlongWays((const PetscReal(*)[TOP])force, arms, K);
  Skew(arms, skew);
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
  const PetscInt last = HalvesCells(line->line);
  const WideArms *arms = &line->arms[last];
  PetscReal P[OWN][TOP], Q[OWN][OWN];
  Six C, K = {{0}}, skew, R = {{0}};
  int held = 0;

  if (!Compliance(line, last, C)) return 0;
  for (int i = 0; i < OWN; i++) {
    PetscBool free = PETSC_FALSE;
    memcpy(P[i], line->own[i], TOP * sizeof(PetscReal));
    memcpy(Q[i], line->own[i] + TOP, OWN * sizeof(PetscReal));
    for (int j = 0; j < OWN; j++)
      if (Q[i][j] != 0) free = PETSC_TRUE;
    if (free) continue;
    for (int k = 0; k < OWN; k++)
      for (int j = 0; j < TOP; j++) R[held][k] += P[i][j] * arms->way[k][j];
    held++;
  }
  if (!held && Solve(OWN, TOP, Q[0], P[0])) {
    AlongWays((const PetscReal(*)[TOP])P, arms, K);
    Skew(arms, skew);
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

  for (PetscInt i = 0; i < HalvesCells(line->line); i++) {
    const HalvesLink link = HalvesAt(line->line, i);
    const PetscReal twist = line->arms[i].twist;
    PetscReal most = 0;
    for (int k = 0; k < TOP; k++)
      if (link.row[k] != k || !(link.S[k * TOP + k] > 0)) return PETSC_TRUE;
    if (twist == 0) continue;
    for (int k = 0; k < TOP; k++)
      for (int j = 0; j < 3; j++) most = PetscMax(most, PetscAbsReal(link.T[k * ALL + TOP + j]));
    if (PetscAbsReal(twist) * most > much) return PETSC_TRUE;
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
  for (PetscInt i = 0; i < HalvesCells(line->line); i++) {
    if (!Compliance(line, i, C) || !Stiffness(line, i, K) || !Resolved(C, K)) return -1;
    if (line->plane) LeaveOutOfPlane(C, K);
    index += Added(C, K, 0, NULL);
  }
  return index;
}
