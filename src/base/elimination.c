/*
  One rank goes along its line (line.c) from the clamp, where the first half of y_0 is given, to the
  tip, whose three equations are the last. Several ranks have the cells that begin at their nodes,
  and join what they find:

  The first goes from the clamp and finds T y = d at the next rank's first node. The last goes from
  the tip towards its own first node: in that direction the halves of the unknowns and of the
  equations change places, and what it finds are three more equations there. Two ranks are done
  with that. Those between do not know the first half of their first node: it is a parameter p.
  With z the other half, what they find is
      T y_end = d + D p,     z = h + F y_end + G p,
  six equations between their first node and that of the next rank: a cell, like the others. So the
  ranks' cells are a line themselves, which every rank eliminates for itself in the same way; its
  cost grows like the number of ranks. With p known, those between go through their nodes again.

  The tip must be free: of a rod whose end is held, the end alone does not tell the force.
*/
#include "base/elimination.h"
#include <string.h>

enum { FIELDS = LINE_FIELDS, HALF = LINE_HALF };

/* How the node behind a rank's cells depends on its parameter, and its first node on that; of the
   last rank T alone, at its first node. */
typedef struct {
  LineRows T, F;
  LineSquare D, G;
} Span;

/* Its right-hand sides. */
typedef struct {
  PetscReal d[HALF], h[HALF];
} Moved;

struct _Elimination {
  MPI_Comm comm;
  PetscMPIInt rank, ranks;
  PetscBool from_tip, between; /* the last of several ranks; neither first nor last */
  PetscInt nodes;              /* owned */
  WideLine wide;               /* of nodes of thirteen unknowns; the rest is then not in use */
  WideLine whole;              /* of all ranks' nodes, on the first of several */
  Halves other;                /* of nodes of other sizes, on one rank; likewise */
  Line own, joint;             /* node r of the joint is the last of rank r's cells */
  Span span;                   /* of own, up to where it is */
  Span *spans;                 /* of all ranks */
  LineRows *reach; /* between: F A^-1 of each link, how its v moves z of the first node */
  PetscReal (*turned)[FIELDS]; /* from the tip: right-hand sides and unknowns in that direction */
  PetscInt parts, fields; /* lines that go together, one behind the other; 0: this is one; of */
  Elimination *part;      /* so many unknowns a node */
};

/* EliminationCan - can a line be eliminated whose nodes have so many equations of the cell before
   them, and so many of the one behind, on so many ranks? */
PetscBool EliminationCan(const PetscInt halves[2], PetscInt ranks) {
  return (PetscBool)((halves[0] == HALF && halves[1] == HALF) || (HalvesCan(halves) && ranks == 1));
}

/* EliminationCounts - can the index be told, if not the line be solved? */
PetscBool EliminationCounts(const PetscInt halves[2], PetscInt ranks) {
  return (PetscBool)(EliminationCan(halves, ranks) || EliminationCan(halves, 1));
}

/* A line of nodes of thirteen unknowns. Several ranks keep their cells, and the first counts. */
static PetscErrorCode CreateWide(Elimination self) {
  PetscInt all = self->nodes;

  PetscFunctionBegin;
  PetscCall(WideCreate(self->nodes + (self->ranks > 1), &self->wide));
  if (self->ranks == 1) PetscFunctionReturn(0);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPIU_INT, MPI_SUM, self->comm));
  if (!self->rank) PetscCall(WideCreate(all, &self->whole));
  PetscFunctionReturn(0);
}

/*
  EliminationCreate - for a line of nodes of which this rank owns so many, in order of the ranks;
  halves as for EliminationCan(), which must say yes, or EliminationCounts(): then it is not solved.
  Collective; the caller destroys it with EliminationDestroy().
*/
PetscErrorCode EliminationCreate(MPI_Comm comm, PetscInt nodes, const PetscInt halves[2],
                                 Elimination *elimination) {
  Elimination self;

  PetscFunctionBegin;
  PetscCall(PetscNew(elimination));
  self = *elimination;
  self->comm = comm;
  self->nodes = nodes;
  PetscCallMPI(MPI_Comm_size(comm, &self->ranks));
  PetscCallMPI(MPI_Comm_rank(comm, &self->rank));
  if (halves[0] == WIDE_TOP) {
    PetscCall(CreateWide(self));
    PetscFunctionReturn(0);
  }
  if (halves[0] != HALF) {
    PetscCall(HalvesCreate(nodes, halves, &self->other));
    PetscFunctionReturn(0);
  }
  self->from_tip = (PetscBool)(self->ranks > 1 && self->rank + 1 == self->ranks);
  self->between = (PetscBool)(self->rank > 0 && !self->from_tip);
  PetscCall(LineCreate(nodes + 1, &self->own));
  PetscCall(LineCreate(self->ranks, &self->joint));
  PetscCall(PetscCalloc1(self->ranks, &self->spans));
  if (self->between) PetscCall(PetscCalloc1(nodes, &self->reach));
  if (self->from_tip) PetscCall(PetscCalloc1(2 * nodes, &self->turned));
  PetscFunctionReturn(0);
}

/* EliminationCreateSeveral - for lines that do not see each other, of so many nodes each, one
   behind the other on this rank; each is eliminated as the part that it is. Not collective; the
   caller destroys it with EliminationDestroy(). */
PetscErrorCode EliminationCreateSeveral(PetscInt lines, const PetscInt nodes[],
                                        const PetscInt halves[2], Elimination *elimination) {
  Elimination self;

  PetscFunctionBegin;
  PetscCall(PetscNew(elimination));
  self = *elimination;
  self->comm = PETSC_COMM_SELF;
  self->parts = lines;
  self->fields = halves[0] + halves[1];
  PetscCall(PetscCalloc1(lines, &self->part));
  for (PetscInt k = 0; k < lines; k++)
    PetscCall(EliminationCreate(PETSC_COMM_SELF, nodes[k], halves, &self->part[k]));
  PetscFunctionReturn(0);
}

/* EliminationPart - that of one of several lines; of one, itself. Borrowed. */
Elimination EliminationPart(Elimination self, PetscInt k) {
  return self->parts ? self->part[k] : self;
}

PetscErrorCode EliminationDestroy(Elimination *self) {
  PetscFunctionBegin;
  if (!*self) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < (*self)->parts; k++) PetscCall(EliminationDestroy(&(*self)->part[k]));
  PetscCall(PetscFree((*self)->part));
  PetscCall(WideDestroy(&(*self)->wide));
  PetscCall(WideDestroy(&(*self)->whole));
  PetscCall(HalvesDestroy(&(*self)->other));
  PetscCall(LineDestroy(&(*self)->own));
  PetscCall(LineDestroy(&(*self)->joint));
  PetscCall(PetscFree((*self)->spans));
  PetscCall(PetscFree((*self)->reach));
  PetscCall(PetscFree((*self)->turned));
  PetscCall(PetscFree(*self));
  PetscFunctionReturn(0);
}

/* EliminationWide - the line of nodes of thirteen unknowns; NULL: it is of six. Borrowed. */
WideLine EliminationWide(Elimination self) {
  return self->wide;
}

/* EliminationHalves - the line of nodes of other sizes. Borrowed. */
Halves EliminationHalves(Elimination self) {
  return self->other;
}

/* EliminationKeeps - does this rank keep its cells of a wide line (WideKeep()), for
   EliminationGather()? */
PetscBool EliminationKeeps(Elimination self) {
  return (PetscBool)(self->wide && self->ranks > 1);
}

/* What a rank has of a wide line, one behind the other: its cells; and the last one, for the tip.
 */
static PetscErrorCode PackWide(Elimination self, const WideArms *tip,
                               const PetscReal own[WIDE_OWN][WIDE_FIELDS], PetscInt *reals,
                               PetscReal **parts) {
  enum { ARMS = sizeof(WideArms) / sizeof(PetscReal), OWN = WIDE_OWN * WIDE_FIELDS };
  const PetscInt cells = WideParts(self->wide, NULL);

  PetscFunctionBegin;
  *reals = cells + (own ? ARMS + OWN : 0);
  PetscCall(PetscMalloc1(*reals, parts));
  (void)WideParts(self->wide, *parts);
  if (!own) PetscFunctionReturn(0);
  memcpy(*parts + cells, tip, sizeof(*tip));
  memcpy(*parts + cells + ARMS, own, OWN * sizeof(PetscReal));
  PetscFunctionReturn(0);
}

/* Eliminates the wide line of all ranks. */
static void EliminateWhole(Elimination self, const PetscReal gives[WIDE_TOP][WIDE_OWN],
                           const PetscReal parts[], PetscInt reals) {
  enum { ARMS = sizeof(WideArms) / sizeof(PetscReal), OWN = WIDE_OWN * WIDE_FIELDS };
  const PetscReal *tip = parts + reals - OWN - ARMS;

  WideBegin(self->whole);
  if (gives) WideSpring(self->whole, gives);
  WideTake(self->whole, parts, reals - OWN - ARMS);
  WideArm(self->whole, (const WideArms *)tip);
  WideEnd(self->whole, (const PetscReal(*)[WIDE_FIELDS])(tip + ARMS));
}

/*
  EliminationGather - all cells of a wide line are there: the first of several ranks eliminates
  them. Collective.

  gives     of the first rank, see WideSpring(); NULL: the beginning is given
  tip, own  arms and equations of the last node, of the last rank; NULL on the others
*/
PetscErrorCode EliminationGather(Elimination self, const PetscReal gives[WIDE_TOP][WIDE_OWN],
                                 const WideArms *tip, const PetscReal own[WIDE_OWN][WIDE_FIELDS]) {
  PetscMPIInt *many, *from, mine;
  PetscReal *parts, *all;
  PetscInt reals;

  PetscFunctionBegin;
  PetscCall(PackWide(self, tip, own, &reals, &parts));
  mine = (PetscMPIInt)reals;
  PetscCall(PetscMalloc2(self->ranks, &many, self->ranks + 1, &from));
  PetscCallMPI(MPI_Gather(&mine, 1, MPI_INT, many, 1, MPI_INT, 0, self->comm));
  from[0] = 0;
  for (PetscMPIInt r = 0; r < self->ranks && !self->rank; r++) from[r + 1] = from[r] + many[r];
  PetscCall(PetscMalloc1(self->rank ? 0 : from[self->ranks], &all));
  PetscCallMPI(MPI_Gatherv(parts, mine, MPIU_REAL, all, many, from, MPIU_REAL, 0, self->comm));
  if (!self->rank) EliminateWhole(self, gives, all, from[self->ranks]);
  PetscCall(PetscFree(all));
  PetscCall(PetscFree2(many, from));
  PetscCall(PetscFree(parts));
  PetscFunctionReturn(0);
}

/* EliminationPlane - of a wide line: see WidePlane(). */
void EliminationPlane(Elimination self, PetscBool plane) {
  if (self->wide) WidePlane(self->wide, plane);
  if (self->whole) WidePlane(self->whole, plane);
}

/* EliminationFromTip - does this rank want its cells from the tip towards the clamp? */
PetscBool EliminationFromTip(Elimination self) {
  return self->from_tip;
}

/* C (0, at column first) = I */
static void Identity(PetscReal *C, int columns, int first) {
  memset(C, 0, HALF * columns * sizeof(*C));
  for (int i = 0; i < HALF; i++) C[i * columns + first + i] = 1;
}

/* Rows with the halves of their columns in each other's place. */
static inline void TurnRows(const LineRows from, LineRows to) {
  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++) {
      to[i][j] = from[i][HALF + j];
      to[i][HALF + j] = from[i][j];
    }
}

/* EliminationBegin - a new matrix: its cells follow. tip: the last three equations, rows of the
   last node, for a rank that begins there; any other needs none yet. */
void EliminationBegin(Elimination self, const LineRows tip) {
  Span *span = &self->span;

  memset(span, 0, sizeof(*span));
  if (self->from_tip)
    TurnRows(tip, span->T);
  else
    Identity(&span->T[0][0], FIELDS, 0);
  Identity(&span->F[0][0], FIELDS, HALF);
  Identity(&span->D[0][0], HALF, 0);
  LineBegin(&self->own, (const PetscReal(*)[FIELDS])span->T);
}

/*
  EliminationSpring - behind EliminationBegin(), of the rank that has the beginning: there the first
  three unknowns are not 0, but give way to their forces, the third (a turn) by this compliance, the
  first two (a place) by that. So a beginning that turns in a hinge, or is free, is that of a line
  that can be eliminated, if the springs are soft beside it.
*/
void EliminationSpring(Elimination self, PetscReal turn, PetscReal place) {
  LineRows T;

  memcpy(T, self->span.T, sizeof(T));
  for (int d = 0; d < 2; d++) T[d][HALF + 1 + d] = -place;
  T[2][HALF] = -turn;
  LineBegin(&self->own, (const PetscReal(*)[FIELDS])T);
}

/* How the span goes on over a link, with H = F A^-1:
     D' = -X (D; 0),  G' = G + H (D; 0),  F' = -H (0; U) */
static void SpanCell(Elimination self, const LineLink *link, LineRows H) {
  Span *span = &self->span;
  LineSquare D;

  LineDivide(link, (const PetscReal(*)[FIELDS])span->F, H);
  memcpy(D, span->D, sizeof(D));
  memset(span->F, 0, sizeof(span->F));
  LineSubtractProduct((const PetscReal(*)[FIELDS])H, link->U, span->F);
  for (int i = 0; i < HALF; i++)
    for (int j = 0; j < HALF; j++) {
      span->D[i][j] = -link->X[i][0] * D[0][j] - link->X[i][1] * D[1][j] - link->X[i][2] * D[2][j];
      span->G[i][j] += H[i][0] * D[0][j] + H[i][1] * D[1][j] + H[i][2] * D[2][j];
    }
}

/* A cell as it is from the tip. */
static void CellFromTip(Elimination self, LineBlock a, LineBlock b) {
  PetscReal from[FIELDS][FIELDS], to[FIELDS][FIELDS];

  TurnRows(b, from + HALF);
  TurnRows(b + HALF, from);
  TurnRows(a, to + HALF);
  TurnRows(a + HALF, to);
  LineCell(&self->own, (const PetscReal(*)[FIELDS])from, (const PetscReal(*)[FIELDS])to);
}

/* EliminationCell - eliminates a cell of this rank: six equations by the unknowns of its nodes, a
   towards the clamp and b towards the tip; first the three that are rows of b, then those that are
   rows of a. */
void EliminationCell(Elimination self, LineBlock a, LineBlock b) {
  PetscInt i = self->own.n;

  if (self->from_tip)
    CellFromTip(self, a, b);
  else
    LineCell(&self->own, a, b);
  if (self->between) SpanCell(self, &self->own.link[i], self->reach[i]);
}

/* The line of the ranks. */
static void Join(Elimination self) {
  Line *joint = &self->joint;
  PetscReal a[FIELDS][FIELDS] = {{0}}, b[FIELDS][FIELDS];

  LineBegin(joint, (const PetscReal(*)[FIELDS])self->spans[0].T);
  Identity(&a[HALF][0], FIELDS, HALF);
  for (PetscMPIInt r = 1; r + 1 < self->ranks; r++) {
    const Span *span = &self->spans[r];
    memcpy(b, span->T, sizeof(LineRows));
    for (int i = 0; i < HALF; i++) {
      for (int j = 0; j < HALF; j++) {
        a[i][j] = -span->D[i][j];
        a[HALF + i][j] = -span->G[i][j];
      }
      for (int k = 0; k < FIELDS; k++) b[HALF + i][k] = -span->F[i][k];
    }
    LineCell(joint, (const PetscReal(*)[FIELDS])a, (const PetscReal(*)[FIELDS])b);
  }
  LineEnd(joint, (const PetscReal(*)[FIELDS])self->spans[self->ranks - 1].T);
}

/* EliminationEnd - all cells of all ranks are there; tip: the last three equations, of the rank
   that has them. Collective. */
PetscErrorCode EliminationEnd(Elimination self, const LineRows tip) {
  enum { VALUES = sizeof(Span) / sizeof(PetscReal) };
  const PetscReal(*T)[FIELDS] = (const PetscReal(*)[FIELDS])self->own.link[self->own.n].T;

  PetscFunctionBegin;
  if (self->ranks == 1) {
    LineEnd(&self->own, tip);
    PetscFunctionReturn(0);
  }
  if (self->from_tip)
    TurnRows(T, self->span.T);
  else
    memcpy(self->span.T, T, sizeof(LineRows));
  PetscCallMPI(
      MPI_Allgather(&self->span, VALUES, MPIU_REAL, self->spans, VALUES, MPIU_REAL, self->comm));
  Join(self);
  PetscFunctionReturn(0);
}

/* What is said of node i of the joint when it is arrived at: by its rank and those before. */
static void Arrived(const Elimination self, PetscInt i, LineRows T) {
  memcpy(T, self->spans[i].T, sizeof(LineRows));
  if (i) LineSubtractProduct(self->joint.link[i - 1].X, self->joint.link[i - 1].U, T);
}

/*
  EliminationIndex - the index of the matrix eliminated last (line.c), whose fourth unknown of a
  node is the force that belongs to the third, its fifth and sixth to the first and second. Of a
  rod's Jacobian with a shift it is the number of real rates above the shift; exactly so where the
  matrix derives from an energy, and always as an odd or even number. Collective. (Of
  nodes of thirteen unknowns see wide.h.)
*/
PetscErrorCode EliminationIndex(Elimination self, PetscInt *index) {
  static const int force[HALF] = {2, 0, 1}, turned[HALF] = {1, 2, 0};
  const int *pair = self->from_tip ? turned : force;
  const PetscReal sign = self->from_tip ? -1 : 1;
  LineRows T;

  PetscFunctionBegin;
  if (self->wide) {
    if (!self->rank) *index = WideIndex(self->whole ? self->whole : self->wide);
    PetscCallMPI(MPI_Bcast(index, 1, MPIU_INT, 0, self->comm));
    PetscFunctionReturn(0);
  }
  if (self->from_tip || self->ranks == 1)
    memcpy(T, self->own.link[self->own.n].T, sizeof(T));
  else
    Arrived(self, self->rank, T);
  *index = LineIndex(&self->own, sign, pair) +
           LineIndexOfArrival(&self->own, (const PetscReal(*)[FIELDS])T, sign, pair);
  if (self->ranks == 1) {
    *index += LineIndexOfEnd(&self->own, force);
    PetscFunctionReturn(0);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, index, 1, MPIU_INT, MPI_SUM, self->comm));
  for (PetscInt i = 0; i < self->joint.n; i++) {
    Arrived(self, i, T);
    *index += LineIndexOfNode(&self->joint, i, (const PetscReal(*)[FIELDS])T, force);
  }
  *index += LineIndexOfEnd(&self->joint, force);
  PetscFunctionReturn(0);
}

/* The nodes of a rank, first to last, as they are from the tip, or back. */
static void Turn(PetscInt nodes, const PetscReal (*from)[FIELDS], PetscReal (*to)[FIELDS]) {
  for (PetscInt i = 0; i < nodes; i++)
    for (int f = 0; f < HALF; f++) {
      to[nodes - 1 - i][f] = from[i][HALF + f];
      to[nodes - 1 - i][HALF + f] = from[i][f];
    }
}

/* h of a rank between, whose x has v. */
static void SpanMoved(const Elimination self, const PetscReal (*x)[FIELDS], PetscReal h[HALF]) {
  for (PetscInt i = 0; i < self->nodes; i++)
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
      b[k][HALF + f] = k < n ? moved[k + 1].h[f] : moved[n + 1].d[f];
    }
  LineSolve(&self->joint, (const PetscReal(*)[FIELDS])b, x);
}

/* From what each rank has found, the unknowns of the nodes where it meets the one before (begin)
   and the one behind it (end). Collective. */
static PetscErrorCode Meet(Elimination self, const Moved *mine, PetscReal begin[FIELDS],
                           PetscReal end[FIELDS]) {
  enum { VALUES = sizeof(Moved) / sizeof(PetscReal) };
  PetscReal(*rhs)[FIELDS], (*joint)[FIELDS];
  Moved *moved;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(self->ranks, &moved, self->ranks, &rhs, self->ranks, &joint));
  PetscCallMPI(MPI_Allgather(mine, VALUES, MPIU_REAL, moved, VALUES, MPIU_REAL, self->comm));
  SolveJoint(self, moved, rhs, joint);
  if (self->rank) PetscCall(PetscArraycpy(begin, joint[self->rank - 1], FIELDS));
  if (!self->from_tip) PetscCall(PetscArraycpy(end, joint[self->rank], FIELDS));
  PetscCall(PetscFree3(moved, rhs, joint));
  PetscFunctionReturn(0);
}

/* The first half's equations of the next rank's first node are those of this rank's last cell. */
static PetscErrorCode FetchBehind(const Elimination self, const PetscReal first[],
                                  PetscReal behind[HALF]) {
  PetscMPIInt left = self->rank ? self->rank - 1 : MPI_PROC_NULL,
              right = self->rank + 1 < self->ranks ? self->rank + 1 : MPI_PROC_NULL;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Sendrecv(first, HALF, MPIU_REAL, left, 0, behind, HALF, MPIU_REAL, right, 0,
                            self->comm, MPI_STATUS_IGNORE));
  PetscFunctionReturn(0);
}

/* Solve, on the first of several ranks; on one between; on the last. */
static PetscErrorCode SolveFromClamp(Elimination self, const PetscReal (*b)[FIELDS],
                                     const PetscReal behind[HALF], PetscReal (*x)[FIELDS]) {
  PetscReal begin[FIELDS], end[FIELDS];
  Moved mine = {.d = {0}};

  PetscFunctionBegin;
  for (int f = 0; f < HALF; f++) x[0][f] = b[0][f];
  LineForward(&self->own, self->nodes, b, behind, x, mine.d);
  PetscCall(Meet(self, &mine, begin, end));
  LineBackward(&self->own, end, x);
  PetscFunctionReturn(0);
}

static PetscErrorCode SolveBetween(Elimination self, const PetscReal (*b)[FIELDS],
                                   const PetscReal behind[HALF], PetscReal (*x)[FIELDS]) {
  PetscReal begin[FIELDS], end[FIELDS], beyond[HALF];
  Moved mine = {.d = {0}};

  PetscFunctionBegin;
  for (int f = 0; f < HALF; f++) x[0][f] = 0;
  LineForward(&self->own, self->nodes, b, behind, x, mine.d);
  SpanMoved(self, (const PetscReal(*)[FIELDS])x, mine.h);
  PetscCall(Meet(self, &mine, begin, end));
  for (int f = 0; f < HALF; f++) x[0][f] = begin[f];
  LineForward(&self->own, self->nodes, b, behind, x, beyond);
  LineBackward(&self->own, end, x);
  PetscFunctionReturn(0);
}

static PetscErrorCode SolveFromTip(Elimination self, const PetscReal (*b)[FIELDS],
                                   PetscReal (*x)[FIELDS]) {
  PetscReal(*rhs)[FIELDS] = self->turned, (*y)[FIELDS] = self->turned + self->nodes,
  begin[1][FIELDS], end[FIELDS];
  PetscInt n = self->own.n;
  Moved mine = {.d = {0}};

  PetscFunctionBegin;
  Turn(self->nodes, b, rhs);
  for (int f = 0; f < HALF; f++) y[0][f] = rhs[0][f];
  LineForward(&self->own, self->nodes, (const PetscReal(*)[FIELDS])rhs, NULL, y, NULL);
  for (int f = 0; f < HALF; f++) mine.d[f] = y[n][f];
  PetscCall(Meet(self, &mine, begin[0], end));
  Turn(1, (const PetscReal(*)[FIELDS])begin, y + n);
  LineBackward(&self->own, y[n], y);
  Turn(self->nodes, (const PetscReal(*)[FIELDS])y, x);
  PetscFunctionReturn(0);
}

static PetscErrorCode Solve(Elimination self, const PetscReal (*b)[FIELDS], PetscReal (*x)[FIELDS]);

/* Each of several lines. */
static PetscErrorCode SolveParts(Elimination self, const PetscReal *b, PetscReal *x) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->parts; k++) {
    const PetscInt n = self->part[k]->nodes * self->fields;
    PetscCall(Solve(self->part[k], (const PetscReal(*)[FIELDS])b, (PetscReal(*)[FIELDS])x));
    b += n;
    x += n;
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Solve(Elimination self, const PetscReal (*b)[FIELDS],
                            PetscReal (*x)[FIELDS]) {
  PetscReal behind[HALF] = {0};

  PetscFunctionBegin;
  if (self->parts) {
    PetscCall(SolveParts(self, (const PetscReal *)b, (PetscReal *)x));
    PetscFunctionReturn(0);
  }
  if (self->wide) {
    WideSolve(self->wide, (const PetscReal(*)[WIDE_FIELDS])b, (PetscReal(*)[WIDE_FIELDS])x);
    PetscFunctionReturn(0);
  }
  if (self->other) {
    HalvesSolve(self->other, b[0], x[0]);
    PetscFunctionReturn(0);
  }
  if (self->ranks == 1) {
    LineSolve(&self->own, b, x);
    PetscFunctionReturn(0);
  }
  PetscCall(FetchBehind(self, b[0], behind));
  if (!self->rank)
    PetscCall(SolveFromClamp(self, b, behind, x));
  else if (self->between)
    PetscCall(SolveBetween(self, b, behind, x));
  else
    PetscCall(SolveFromTip(self, b, x));
  PetscFunctionReturn(0);
}

/* EliminationSolve - x of A x = b, the owned nodes of each; not a number where A is singular.
   Collective. */
PetscErrorCode EliminationSolve(Elimination self, const PetscReal (*b)[FIELDS],
                                PetscReal (*x)[FIELDS]) {
  PetscFunctionBegin;
  PetscCall(Solve(self, b, x));
  PetscFunctionReturn(0);
}

/* EliminationRegular - could all that was eliminated be divided by? */
PetscBool EliminationRegular(Elimination self) {
  for (PetscInt k = 0; k < self->parts; k++)
    if (!EliminationRegular(self->part[k])) return PETSC_FALSE;
  if (self->parts) return PETSC_TRUE;
  if (self->wide) return WideRegular(self->wide);
  if (self->other) return HalvesRegular(self->other);
  return self->ranks == 1 ? self->own.regular : self->joint.regular;
}

static PetscErrorCode SetUp(PC pc) {
  Elimination self;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &self));
  PetscCall(
      PCSetFailedReason(pc, EliminationRegular(self) ? PC_NOERROR : PC_FACTOR_NUMERIC_ZEROPIVOT));
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
