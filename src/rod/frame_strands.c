/* The frame model of a rod that touches itself: what rod/strands.h finds goes into the equations
   and into their derivatives. Every rank knows the whole rod and finds the same. */
#include "rod/coupled.h"
#include "rod/frame.h"

struct FrameStrands {
  Strands strands;
  Coupled coupled;
  RodSeen seen;       /* the state of the latest load, */
  PetscBool searched; /* ... that was searched for pairs */
};

/* FrameStrandsCreate - what a rod of the frame model needs to touch itself: its strands, all nodes
   on each rank, room in the matrix. The caller ends it with FrameStrandsDestroy(). Collective. */
PetscErrorCode FrameStrandsCreate(Rod rod, struct FrameStrands **strands) {
  PetscFunctionBegin;
  PetscCall(PetscNew(strands));
  PetscCall(StrandsCreate(rod->scene, &(*strands)->strands));
  PetscCall(CoupledCreate(rod, &(*strands)->coupled));
  (*strands)->seen.t = PETSC_MIN_REAL;
  PetscFunctionReturn(0);
}

PetscErrorCode FrameStrandsDestroy(struct FrameStrands **strands) {
  PetscFunctionBegin;
  if (!*strands) PetscFunctionReturn(0);
  PetscCall(StrandsDestroy(&(*strands)->strands));
  PetscCall(CoupledDestroy(&(*strands)->coupled));
  PetscCall(PetscFree(*strands));
  PetscFunctionReturn(0);
}

/* The state of the whole rod, on every rank. Ends with CoupledClose(). */
static PetscErrorCode OpenState(struct FrameStrands *self, const RodState *at, StrandState *state) {
  const PetscReal *u[2];

  PetscFunctionBegin;
  PetscCall(CoupledOpen(self->coupled, at->U, at->U_t, u));
  *state = (StrandState){.t = at->t, .stride = FIELDS, .u = u[0], .u_t = u[1]};
  PetscFunctionReturn(0);
}

/* FrameStrandsLoad - the forces of contact in a state, as StrandsForces() has them. Pairs are
   looked for once a Newton solve: a Jacobian follows on the residual of the same state. Collective.
 */
PetscErrorCode FrameStrandsLoad(Rod rod, const RodState *at, const PetscReal (**force)[2]) {
  struct FrameStrands *self = ((Frame *)rod->data)->strands;
  StrandState state;
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(RodRecognise(at, &self->seen, &known));
  PetscCall(OpenState(self, at, &state));
  if (!known || (at->fresh && !self->searched)) {
    if (at->fresh) PetscCall(StrandsSearch(self->strands, &state));
    PetscCall(StrandsLoad(self->strands, &state));
    self->searched = at->fresh;
  }
  PetscCall(CoupledClose(self->coupled, at->U, at->U_t));
  *force = StrandsForces(self->strands);
  PetscFunctionReturn(0);
}

/* FrameStrandsHold - see StrandsHold(); in the state of the latest load. */
PetscErrorCode FrameStrandsHold(Rod rod, PetscReal seen, PetscReal *creep) {
  struct FrameStrands *self = ((Frame *)rod->data)->strands;

  PetscFunctionBegin;
  PetscCall(StrandsHold(self->strands, seen, creep));
  self->seen.t = PETSC_MIN_REAL; /* its forces are others now */
  PetscFunctionReturn(0);
}

/* What is remembered of a node and of the middle behind it: of either side, the dual. */
enum { SIDES = 2, OF_SIDE = sizeof(FrictionDual) / sizeof(PetscReal) };

/* FrameStrandsMemory - how many reals a node remembers of the friction between strands. */
PetscInt FrameStrandsMemory(Rod rod) {
  FrictionDual *duals;
  return StrandsDuals(((Frame *)rod->data)->strands->strands, &duals) ? 2 * SIDES * OF_SIDE : 0;
}

/* FrameStrandsRemembered - the k-th of them at node i; NULL where there is none (behind the tip).
 */
PetscReal *FrameStrandsRemembered(Rod rod, PetscInt i, PetscInt k) {
  FrictionDual *duals;
  PetscInt n = StrandsDuals(((Frame *)rod->data)->strands->strands, &duals),
           at = 2 * SIDES * i + k / OF_SIDE;
  if (at >= n) return NULL;
  return (PetscReal *)&duals[at] + k % OF_SIDE;
}

/* FrameStrandsRecalled - each rank has recalled what its own nodes remember: tells the others.
   Collective. */
PetscErrorCode FrameStrandsRecalled(Rod rod) {
  const PetscInt reals = sizeof(FrictionDual) / sizeof(PetscReal);
  struct FrameStrands *self = ((Frame *)rod->data)->strands;
  FrictionDual *duals;
  PetscInt n = StrandsDuals(self->strands, &duals);
  PetscMPIInt count;

  PetscFunctionBegin;
  self->seen.t = PETSC_MIN_REAL;
  for (PetscInt k = 0; k < n; k++) {
    PetscInt node = k / (2 * SIDES);
    if (node < rod->first || node >= rod->end) PetscCall(PetscMemzero(&duals[k], sizeof(*duals)));
  }
  PetscCall(PetscMPIIntCast(n * reals, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, duals, count, MPIU_REAL, MPI_SUM, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* ---- the matrix ---- */

/* FrameStrandsPattern - sees to it that J has room for all pairs, and is 0. Collective. */
PetscErrorCode FrameStrandsPattern(Rod rod, PetscBool fresh, Mat J) {
  struct FrameStrands *self = ((Frame *)rod->data)->strands;
  PetscInt n, (*near)[2];

  PetscFunctionBegin;
  PetscCall(StrandsNear(self->strands, &n, &near));
  PetscCall(CoupledPattern(rod, self->coupled, fresh, n, near, J));
  PetscFunctionReturn(0);
}

/* The middle's direction of the cell behind node i. */
static void MidDirection(const Frame *frame, Rod rod, const StrandState *state, PetscInt i,
                         PetscReal q[2]) {
  const Law *law = frame->law + 2 * (i - rod->first + 1);
  const PetscReal *a = state->u + i * FIELDS, *b = a + FIELDS,
                  h = rod->scene->mesh.s[i + 1] - rod->scene->mesh.s[i];
  PetscReal theta = (a[TH] + b[TH]) / 2 + frame->bow * h *
                                              (law[0].g * (a[M] * law[0].flex + law[0].k0) -
                                               law[2].g * (b[M] * law[2].flex + law[2].k0));
  q[0] = PetscCosReal(theta);
  q[1] = PetscSinReal(theta);
}

/* The rows of one node by the nodes of two cells. */
typedef PetscReal Coupling[FIELDS][4 * FIELDS];

/*
  Adds to the rows of node i, those of the cell behind it, that n' of one of its points changes:
  part 0 node i, 1 the middle, 2 node i + 1. With k = bow h and n_mid = ... + k (n'_a - n'_b),
    r_n  = ... - h w n',   r_m = ... - h w_mid g_mid (q2 n1_mid - q1 n2_mid)
*/
static void AddToCell(const Frame *frame, Rod rod, const StrandState *state, PetscInt i, int part,
                      PetscReal by[2][STRAND_UNKNOWNS], Coupling block) {
  const PetscReal h = rod->scene->mesh.s[i + 1] - rod->scene->mesh.s[i],
                  w = h * (part == 1 ? frame->mid_weight : frame->end_weight),
                  k = (part == 0 ? 1 : -1) * frame->bow * h;
  PetscReal q[2], wm;

  MidDirection(frame, rod, state, i, q);
  wm = part == 1 ? 0 : h * frame->mid_weight * frame->law[2 * (i - rod->first + 1) + 1].g * k;
  for (int u = 0; u < STRAND_UNKNOWNS; u++) {
    PetscInt column = u / 3 * FIELDS + u % 3; /* x1, x2, theta of each of the four nodes */
    block[M][column] -= wm * (q[1] * by[0][u] - q[0] * by[1][u]);
    for (int d = 0; d < 2; d++) block[N1 + d][column] -= w * by[d][u];
  }
}

/* Adds one contact's part of one taker to J. */
static PetscErrorCode AddTaker(Rod rod, const StrandState *state, const StrandSlope *slope, int k,
                               Mat J) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt taker = slope->taker[k], i = taker / 2,
                 column[4] = {slope->cell[0], slope->cell[0] + 1, slope->cell[1],
                              slope->cell[1] + 1};
  PetscReal(*by)[STRAND_UNKNOWNS] = (PetscReal(*)[STRAND_UNKNOWNS])slope->by[k];

  PetscFunctionBegin;
  for (int which = 0; which < 2; which++) { /* the cell behind the point, and that before a node */
    PetscInt row = i - which;
    Coupling block = {{0}};
    PetscBool tip = (PetscBool)(taker == 2 * rod->last + 1);
    if (row < rod->first || row >= rod->end || (which && (taker % 2 || tip))) continue;
    if (tip && rod->scene->tip.type != TIP_FREE) continue;
    if (row == rod->last && !tip) continue; /* behind the tip there is no cell */
    if (tip)
      for (int u = 0; u < STRAND_UNKNOWNS; u++)
        for (int d = 0; d < 2; d++) block[N1 + d][u / 3 * FIELDS + u % 3] -= by[d][u];
    else
      AddToCell(frame, rod, state, row, which ? 2 : (int)(taker % 2), by, block);
    PetscCall(MatSetValuesBlocked(J, 1, &row, 4, column, &block[0][0], ADD_VALUES));
  }
  PetscFunctionReturn(0);
}

/* FrameStrandsJacobian - adds to J, whose other values are set, the derivatives of the forces of
   contact, in the state of the latest load. Collective. */
PetscErrorCode FrameStrandsJacobian(Rod rod, const RodState *at, Mat J) {
  struct FrameStrands *self = ((Frame *)rod->data)->strands;
  const StrandSlope *slopes;
  StrandState state;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(MatAssemblyBegin(J, MAT_FLUSH_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FLUSH_ASSEMBLY));
  PetscCall(OpenState(self, at, &state));
  PetscCall(StrandsLinearise(self->strands, &state, at->shift, at->fresh, &n, &slopes));
  for (PetscInt c = 0; c < n; c++)
    for (int k = 0; k < slopes[c].takers; k++) PetscCall(AddTaker(rod, &state, &slopes[c], k, J));
  PetscCall(CoupledClose(self->coupled, at->U, at->U_t));
  PetscFunctionReturn(0);
}
