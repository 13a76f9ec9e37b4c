#include "rod/space_strands.h"
#include "rod/coupled.h"
#include "rod/strands_space.h"

enum { P = 3, M = 7, N = 10, FIELDS = 13 };

struct _SpaceStrands {
  Strands3 strands;
  Coupled coupled;
  RodSeen seen;       /* the state of the latest load, */
  PetscBool searched; /* ... that was searched for pairs */
};

/* SpaceStrandsCreate - the caller ends it with SpaceStrandsDestroy(). Collective. */
PetscErrorCode SpaceStrandsCreate(Rod rod, SpaceStrands *strands) {
  PetscFunctionBegin;
  PetscCall(PetscNew(strands));
  PetscCall(Strands3Create(rod->scene, &(*strands)->strands));
  PetscCall(CoupledCreate(rod, &(*strands)->coupled));
  (*strands)->seen.t = PETSC_MIN_REAL;
  PetscFunctionReturn(0);
}

PetscErrorCode SpaceStrandsDestroy(SpaceStrands *strands) {
  PetscFunctionBegin;
  if (!*strands) PetscFunctionReturn(0);
  PetscCall(Strands3Destroy(&(*strands)->strands));
  PetscCall(CoupledDestroy(&(*strands)->coupled));
  PetscCall(PetscFree(*strands));
  PetscFunctionReturn(0);
}

static PetscErrorCode OpenState(SpaceStrands self, const RodState *at, StrandState3 *state) {
  const PetscReal *u[2];

  PetscFunctionBegin;
  PetscCall(CoupledOpen(self->coupled, at->U, at->U_t, u));
  *state = (StrandState3){.t = at->t, .stride = FIELDS, .u = u[0], .u_t = u[1]};
  PetscFunctionReturn(0);
}

/* SpaceStrandsLoad - the forces of contact in a state, as Strands3Forces() has them, and the
   couples (NULL: there are none). Pairs are looked for once a Newton solve, as in the plane.
   Collective. */
PetscErrorCode SpaceStrandsLoad(Rod rod, SpaceStrands self, const RodState *at,
                                const PetscReal (**force)[3], const PetscReal (**couple)[3]) {
  StrandState3 state;
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(RodRecognise(at, &self->seen, &known));
  PetscCall(OpenState(self, at, &state));
  if (!known || (at->fresh && !self->searched)) {
    if (at->fresh) PetscCall(Strands3Search(self->strands, &state));
    PetscCall(Strands3Load(self->strands, &state));
    self->searched = at->fresh;
  }
  PetscCall(CoupledClose(self->coupled, at->U, at->U_t));
  *force = Strands3Forces(self->strands);
  *couple = Strands3Couples(self->strands);
  PetscFunctionReturn(0);
}

/* SpaceStrandsPattern - sees to it that J has room for all pairs, and is 0. Collective. */
PetscErrorCode SpaceStrandsPattern(Rod rod, SpaceStrands self, PetscBool fresh, Mat J) {
  PetscInt n, (*near)[2];

  PetscFunctionBegin;
  PetscCall(Strands3Near(self->strands, &n, &near));
  PetscCall(CoupledPattern(rod, self->coupled, fresh, n, near, J));
  PetscFunctionReturn(0);
}

/* The rows of one node by the nodes of two cells. */
typedef PetscReal Coupling[FIELDS][4 * FIELDS];

/* Where the u-th unknown of a contact is among the columns of four nodes. */
static inline PetscInt Column(int u) {
  return u / STRAND3_NODE * FIELDS + u % STRAND3_NODE;
}

/*
  Adds to the rows of a node, those of the cell behind it, that n' of one of its points changes:
  part 0 the node, 1 the middle, 2 the next node. With k = bow h, n_mid = ... + k (n'_a - n'_b):
    r_n = ... - h w n',    r_m = ... + h w_mid g_mid d1_mid x n_mid
*/
static void AddToCell(const SpaceCell *cell, int part, PetscReal by[3][STRAND3_UNKNOWNS],
                      Coupling block) {
  const PetscReal w = part == 1 ? cell->mid_weight : cell->end_weight, *q = cell->q,
                  wm = part == 1 ? 0 : cell->mid_weight * cell->g * (part ? -1 : 1) * cell->bow;

  for (int u = 0; u < STRAND3_UNKNOWNS; u++) {
    PetscInt column = Column(u);
    block[M][column] += wm * (q[1] * by[2][u] - q[2] * by[1][u]);
    block[M + 1][column] += wm * (q[2] * by[0][u] - q[0] * by[2][u]);
    block[M + 2][column] += wm * (q[0] * by[1][u] - q[1] * by[0][u]);
    for (int d = 0; d < 3; d++) block[N + d][column] -= w * by[d][u];
  }
}

/*
  The same of m'. The moment in the middle of the cell, m_mid = ... + k (m'_a - m'_b), turns the
  cell's end, too, in the rows of the next node (of which `next` gets a part):
    r_m = ... - h w m',    r_p = ... - h w_mid dp'/dm_mid m_mid
*/
static void AddCouple(const SpaceCell *cell, int part, PetscReal by[3][STRAND3_UNKNOWNS],
                      Coupling block, Coupling next) {
  const PetscReal w = part == 1 ? cell->mid_weight : cell->end_weight,
                  wm = part == 1 ? 0 : cell->mid_weight * (part ? -1 : 1) * cell->bow;

  for (int u = 0; u < STRAND3_UNKNOWNS; u++)
    for (int d = 0; d < 3; d++) {
      block[M + d][Column(u)] -= w * by[d][u];
      for (int k = 0; k < 4; k++) next[P + k][Column(u)] -= wm * cell->p_m[k][d] * by[d][u];
    }
}

/* Adds one contact's part of one taker to J. */
static PetscErrorCode AddTaker(Rod rod, const SpaceCell *cells, const StrandSlope3 *slope, int k,
                               Mat J) {
  const PetscInt taker = slope->taker[k], i = taker / 2,
                 column[4] = {slope->cell[0], slope->cell[0] + 1, slope->cell[1],
                              slope->cell[1] + 1};
  const PetscBool tip = (PetscBool)(taker == 2 * rod->last + 1);
  PetscReal(*by)[STRAND3_UNKNOWNS] = (PetscReal(*)[STRAND3_UNKNOWNS])slope->by[k];

  PetscFunctionBegin;
  for (int which = 0; which < 2; which++) { /* the cell behind the point, and that before a node */
    PetscInt row = i - which;
    Coupling block = {{0}}, next = {{0}};
    PetscReal(*couple)[STRAND3_UNKNOWNS] = (PetscReal(*)[STRAND3_UNKNOWNS])slope->couple_by[k];
    if (row < rod->first || row >= rod->end || (which && (taker % 2 || tip))) continue;
    if (tip && rod->scene->tip.type != TIP_FREE) continue;
    if (row == rod->last && !tip) continue; /* behind the tip there is no cell */
    if (tip)
      for (int u = 0; u < STRAND3_UNKNOWNS; u++)
        for (int d = 0; d < 3; d++) {
          block[N + d][Column(u)] -= by[d][u];
          if (slope->couples) block[M + d][Column(u)] -= couple[d][u];
        }
    else
      AddToCell(cells + (row - rod->first), which ? 2 : (int)(taker % 2), by, block);
    if (slope->couples && !tip) {
      const PetscInt after = row + 1;
      AddCouple(cells + (row - rod->first), which ? 2 : (int)(taker % 2), couple, block, next);
      PetscCall(MatSetValuesBlocked(J, 1, &after, 4, column, &next[0][0], ADD_VALUES));
    }
    PetscCall(MatSetValuesBlocked(J, 1, &row, 4, column, &block[0][0], ADD_VALUES));
  }
  PetscFunctionReturn(0);
}

/*
  SpaceStrandsJacobian - adds to J, whose other values are set, the derivatives of the forces of
  contact, in the state of the latest load. Collective.

  cells  those behind the owned nodes
*/
PetscErrorCode SpaceStrandsJacobian(Rod rod, SpaceStrands self, const RodState *at,
                                    const SpaceCell *cells, Mat J) {
  const StrandSlope3 *slopes;
  StrandState3 state;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(MatAssemblyBegin(J, MAT_FLUSH_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FLUSH_ASSEMBLY));
  PetscCall(OpenState(self, at, &state));
  PetscCall(Strands3Linearise(self->strands, &state, at->shift, at->fresh, &n, &slopes));
  for (PetscInt c = 0; c < n; c++)
    for (int k = 0; k < slopes[c].takers; k++) PetscCall(AddTaker(rod, cells, &slopes[c], k, J));
  PetscCall(CoupledClose(self->coupled, at->U, at->U_t));
  PetscFunctionReturn(0);
}
