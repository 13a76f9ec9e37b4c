#include "stepping/estimate.h"
#include "base/chain.h"
#include "rod/frame.h"
#include "stepping/vbdf.h"

/*
  The state U of a run fails the exact equations F(t, u, u_t) = 0 by a defect d in space
  (FrameDefect()), and each step adds its local error l to it. So its error e = U - u obeys, to
  first order,

    F_U e + F_U_t e_t = -d,     e jumps by l at each step

  This is stepped by backward Euler, e = A z with the factor A by which x2 falls and rises taken out
  of the fields across, as it is for the run itself (vbdf.c). Errors are smooth along the rod, and a
  fifth of them is no matter: so it is done on a coarse mesh of every few nodes of the run's, and
  once in a few steps while the rod is straight. From the first contact on cells are no longer than
  the layer over which contact spreads, and it is done once in a few steps. The two parts, in space
  and in time, are carried along each for itself. What is told is the largest error that they make
  in the tip's place (over its distance), |x2| and the energy (each over itself).
*/
enum { FOLLOWED = 3 };                /* fields that have rates: x1, x2, theta */
enum { LEAST_CELLS = 8, CELLS = 48 }; /* of the run; of the coarse mesh, about */
enum { SELDOM = 4 };  /* steps from one time to the next, while straight or in contact */
enum { DEFECTS = 2 }; /* such times from one measurement of defects to the next */
static const PetscReal longest = 0.8;  /* arc length of a coarse cell, where the mesh allows */
static const PetscReal straight = 0.3; /* angle */
static const PetscReal most_dip = 0.8; /* of the moment: one that it is worth to look at */
static const PetscReal early = 0.01;   /* of the run: what the start does is over by then */
static const PetscReal nudge = 1e-3;   /* of the speed at which friction turns, of beta, of k */

/* What is gathered of a coarse node: the state, its rate, local errors, the defect of the cell
   behind it. */
typedef struct {
  PetscReal u[FIELDS], rate[FIELDS], local[FOLLOWED], defect[FIELDS];
} Gathered;
enum { GATHERED = sizeof(Gathered) / sizeof(PetscReal) };

struct _Estimate {
  Leg *leg;
  PetscBool touches;      /* the rod does, or did */
  PetscInt stride, nodes; /* of the coarse mesh */
  PetscInt since;         /* steps */
  PetscReal before, size; /* when e was stepped last, and |x2| then */
  PetscReal latest;       /* largest x2 at the latest step */
  PetscReal moment[2];    /* the largest, when e was stepped last; the least of it since */
  PetscInt until;         /* times until the defect is measured again */
  PetscReal measured;     /* largest x2 when it was */
  Gathered *own, *all;    /* of this rank's nodes, 0 elsewhere; all on rank 0 */
  PetscReal (*defect)[MAX_FIELDS];
  PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN];
  /* rank 0: the coarse rod; NULL else */
  struct _Scene scene;
  Rod rod;
  Elimination elimination; /* NULL: far parts of the rod touch, and it is a matrix */
  Mat J;
  KSP ksp;
  Vec U, rate, nudged, F, G;
  PetscReal (*e[ESTIMATE_PARTS])[FIELDS], (*rhs)[FIELDS], (*b)[FIELDS];
};

/* Every stride-th node, the tip in any case; an even number, for defects are those of two cells. */
static PetscErrorCode Coarsen(Estimate self, const Scene scene) {
  PetscInt cells = scene->mesh.cells, most = cells / CELLS;
  PetscReal h = scene->reach / cells, length = longest;

  PetscFunctionBegin;
  if (self->touches) {
    length = PetscMin(longest, scene->contact.tip);
    most = cells;
  }
  self->stride = 2 * PetscMax(1, PetscMin(most, (PetscInt)(length / h)) / 2);
  self->nodes = (cells + self->stride - 1) / self->stride + 1;
  PetscFunctionReturn(0);
}

static PetscInt FineNode(const Estimate self, PetscInt k) {
  return PetscMin(k * self->stride, self->leg->rod->last);
}

/* Far parts of the rod see each other: that is no line of neighbours. */
static PetscErrorCode CreateMatrix(Estimate self) {
  PC pc;

  PetscFunctionBegin;
  PetscCall(RodCreateMatrix(self->rod, &self->J));
  PetscCall(KSPCreate(PETSC_COMM_SELF, &self->ksp));
  PetscCall(KSPSetType(self->ksp, KSPPREONLY));
  PetscCall(KSPGetPC(self->ksp, &pc));
  PetscCall(ChainSetType(pc, self->scene.tip.type == TIP_FREE ? MATORDERING1WD : ORDERING_HELD));
  PetscFunctionReturn(0);
}

/* The coarse rod, on rank 0. Itself it touches only from the first contact on. */
static PetscErrorCode CreateCoarse(Estimate self, const Scene scene) {
  struct _Scene *coarse = &self->scene;

  PetscFunctionBegin;
  *coarse = *scene;
  coarse->comm = PETSC_COMM_SELF;
  coarse->contact.self = (PetscBool)(scene->contact.self && self->touches);
  coarse->mesh.cells = self->nodes - 1;
  PetscCall(PetscMalloc1(self->nodes, &coarse->mesh.s));
  for (PetscInt k = 0; k < self->nodes; k++) coarse->mesh.s[k] = scene->mesh.s[FineNode(self, k)];
  SceneLinkWalls(coarse);
  PetscCall(RodCreate(coarse, &rod_frame, &self->rod));
  if (self->rod->coupled)
    PetscCall(CreateMatrix(self));
  else
    PetscCall(
        EliminationCreate(PETSC_COMM_SELF, self->nodes, rod_frame.halves, &self->elimination));
  PetscCall(DMCreateGlobalVector(self->rod->da, &self->U));
  PetscCall(VecDuplicate(self->U, &self->rate));
  PetscCall(VecDuplicate(self->U, &self->nudged));
  PetscCall(VecDuplicate(self->U, &self->F));
  PetscCall(VecDuplicate(self->U, &self->G));
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(PetscCalloc1(self->nodes, &self->e[part]));
  PetscCall(PetscCalloc3(self->nodes, &self->rhs, self->nodes, &self->b, self->nodes, &self->all));
  PetscFunctionReturn(0);
}

static PetscErrorCode DestroyCoarse(Estimate self) {
  PetscFunctionBegin;
  PetscCall(VecDestroy(&self->U));
  PetscCall(VecDestroy(&self->rate));
  PetscCall(VecDestroy(&self->nudged));
  PetscCall(VecDestroy(&self->F));
  PetscCall(VecDestroy(&self->G));
  for (int part = 0; part < ESTIMATE_PARTS; part++) PetscCall(PetscFree(self->e[part]));
  PetscCall(PetscFree3(self->rhs, self->b, self->all));
  PetscCall(EliminationDestroy(&self->elimination));
  PetscCall(KSPDestroy(&self->ksp));
  PetscCall(MatDestroy(&self->J));
  PetscCall(RodDestroy(&self->rod));
  PetscCall(PetscFree(self->scene.mesh.s));
  PetscFunctionReturn(0);
}

/* Chooses the mesh, with all that is on it. */
static PetscErrorCode ChooseMesh(Estimate self) {
  Rod rod = self->leg->rod;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(Coarsen(self, rod->scene));
  PetscCall(PetscCalloc1(self->nodes, &self->own));
  PetscCallMPI(MPI_Comm_rank(rod->scene->comm, &rank));
  if (!rank) PetscCall(CreateCoarse(self, rod->scene));
  PetscFunctionReturn(0);
}

/*
  EstimateCreate - follows the errors of a leg's run from its present state on, which has none; NULL
  if its model does not know its defects, or has too few cells. The tip must be known where it is
  held. Collective; the caller ends it with EstimateDestroy(), before the leg.
*/
PetscErrorCode EstimateCreate(Leg *leg, Estimate *estimate) {
  Estimate self;

  PetscFunctionBegin;
  *estimate = NULL;
  if (!leg->rod->model->defect || leg->rod->last < LEAST_CELLS) PetscFunctionReturn(0);
  PetscCall(PetscNew(&self));
  *estimate = self;
  self->leg = leg;
  PetscCall(PetscCalloc1(leg->rod->end - leg->rod->first, &self->defect));
  PetscCall(ChooseMesh(self));
  PetscFunctionReturn(0);
}

PetscErrorCode EstimateDestroy(Estimate *estimate) {
  Estimate self = *estimate;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(DestroyCoarse(self));
  PetscCall(PetscFree(self->own));
  PetscCall(PetscFree(self->defect));
  PetscCall(PetscFree(*estimate));
  PetscFunctionReturn(0);
}

/* Errors at the nodes of another mesh, linearly between those where they were. */
static void Interpolate(PetscInt m, const PetscReal *from, PetscReal (*old)[FIELDS], PetscInt n,
                        const PetscReal *to, PetscReal (*new)[FIELDS]) {
  PetscInt j = 0;

  for (PetscInt k = 0; k < n; k++) {
    PetscReal z;
    while (j + 2 < m && from[j + 1] < to[k]) j++;
    z = (to[k] - from[j]) / (from[j + 1] - from[j]);
    for (int f = 0; f < FIELDS; f++) new[k][f] = (1 - z) * old[j][f] + z *old[j + 1][f];
  }
}

/* The rod touches something for the first time: its errors go on on another mesh. Collective. */
static PetscErrorCode Refine(Estimate self) {
  PetscReal *s = NULL, (*old)[FIELDS] = NULL;
  PetscInt n = self->nodes;
  PetscBool here = (PetscBool)(self->rod != NULL);

  PetscFunctionBegin;
  self->touches = PETSC_TRUE;
  self->until = 0;
  if (here) {
    PetscCall(PetscMalloc2(n, &s, ESTIMATE_PARTS * n, &old));
    PetscCall(PetscArraycpy(s, self->scene.mesh.s, n));
    for (int part = 0; part < ESTIMATE_PARTS; part++)
      PetscCall(PetscArraycpy(old + part * n, self->e[part], n));
    PetscCall(DestroyCoarse(self));
  }
  PetscCall(PetscFree(self->own));
  PetscCall(ChooseMesh(self));
  for (int part = 0; part < ESTIMATE_PARTS && here; part++)
    Interpolate(n, s, old + part * n, self->nodes, self->scene.mesh.s, self->e[part]);
  PetscCall(PetscFree2(s, old));
  PetscFunctionReturn(0);
}

/* By how much the fields across have changed, as far as x2 tells. */
static PetscReal Ratio(PetscReal now, PetscReal before) {
  return now > rod_vanished && before > rod_vanished ? now / before : 1;
}

/* The step's local error at the coarse nodes of this rank comes on top of those before, which have
   changed meanwhile by a factor. */
static PetscErrorCode AddLocal(Estimate self, PetscReal factor) {
  PetscReal along[VBDF_POINTS], across[VBDF_POINTS], times[VBDF_POINTS];
  const PetscScalar *u[VBDF_POINTS];
  const Rod rod = self->leg->rod;
  PetscInt n, points, order;
  Vec point[VBDF_POINTS];

  PetscFunctionBegin;
  PetscCall(VBDFGetLocalError(self->leg->ts, &n, along, across));
  PetscCall(VBDFGetHistory(self->leg->ts, &points, times, point, &order));
  if (n > points) n = 0;
  for (PetscInt j = 0; j < n; j++) PetscCall(VecGetArrayRead(point[j], &u[j]));
  for (PetscInt k = 0; k < self->nodes; k++) {
    PetscInt i = FineNode(self, k) - rod->first;
    if (i < 0 || i >= rod->end - rod->first) continue;
    for (int f = X2; f < FOLLOWED; f++) self->own[k].local[f] *= factor;
    for (PetscInt j = 0; j < n; j++)
      for (int f = 0; f < FOLLOWED; f++)
        self->own[k].local[f] += (f == X1 ? along : across)[j] * u[j][i * FIELDS + f];
  }
  for (PetscInt j = 0; j < n; j++) PetscCall(VecRestoreArrayRead(point[j], &u[j]));
  PetscFunctionReturn(0);
}

/* The defects of the coarse cells: those of the cells in them. They change slowly, but for the
   factor of x2. */
static PetscErrorCode MeasureDefect(Estimate self, PetscReal size) {
  const Rod rod = self->leg->rod;

  PetscFunctionBegin;
  if (self->until-- > 0) {
    PetscReal factor = Ratio(size, self->measured);
    for (PetscInt k = 0; k < self->nodes; k++)
      for (int f = 0; f < FIELDS; f++)
        if (rod_frame.group[f] != ALONG) self->own[k].defect[f] *= factor;
    self->measured = size;
    PetscFunctionReturn(0);
  }
  self->until = DEFECTS - 1;
  self->measured = size;
  PetscCall(rod->model->defect(rod, self->defect));
  for (PetscInt k = 0; k < self->nodes; k++) PetscCall(PetscArrayzero(self->own[k].defect, FIELDS));
  for (PetscInt i = PetscMax(1, rod->first); i < rod->end; i++)
    for (int f = 0; f < FIELDS; f++)
      self->own[(i - 1) / self->stride].defect[f] += self->defect[i - rod->first][f];
  PetscFunctionReturn(0);
}

/* State, rate and defect of what is owned; all of it on rank 0. */
static PetscErrorCode Gather(Estimate self, PetscReal size) {
  const Rod rod = self->leg->rod;
  const PetscScalar *u, *rate;

  PetscFunctionBegin;
  PetscCall(MeasureDefect(self, size));
  PetscCall(VecGetArrayRead(self->leg->U, &u));
  PetscCall(VecGetArrayRead(rod->latest_rate, &rate));
  for (PetscInt k = 0; k < self->nodes; k++) {
    PetscInt i = FineNode(self, k) - rod->first;
    if (i < 0 || i >= rod->end - rod->first) continue;
    PetscCall(PetscArraycpy(self->own[k].u, u + i * FIELDS, FIELDS));
    PetscCall(PetscArraycpy(self->own[k].rate, rate + i * FIELDS, FIELDS));
  }
  PetscCall(VecRestoreArrayRead(self->leg->U, &u));
  PetscCall(VecRestoreArrayRead(rod->latest_rate, &rate));
  PetscCallMPI(MPI_Reduce(self->own, self->all, (PetscMPIInt)(GATHERED * self->nodes), MPIU_REAL,
                          MPI_SUM, 0, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* |x2| on the coarse mesh, and the rate at which its logarithm changes (scaled: its square may lie
   below the smallest number). */
static PetscReal Size(const Estimate self, PetscReal *rate) {
  PetscReal most = 0, sum = 0, by_rate = 0;

  *rate = 0;
  for (PetscInt k = 0; k < self->nodes; k++)
    most = PetscMax(most, PetscAbsReal(self->all[k].u[X2]));
  if (most <= rod_vanished) return 0;
  for (PetscInt k = 0; k < self->nodes; k++) {
    sum += PetscSqr(self->all[k].u[X2] / most);
    by_rate += self->all[k].u[X2] / most * (self->all[k].rate[X2] / most);
  }
  *rate = by_rate / sum;
  return most * PetscSqrtReal(sum);
}

static PetscErrorCode PutState(Estimate self) {
  PetscReal(*u)[FIELDS], (*rate)[FIELDS];

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(self->U, (PetscScalar **)&u));
  PetscCall(VecGetArrayWrite(self->rate, (PetscScalar **)&rate));
  for (PetscInt k = 0; k < self->nodes; k++) {
    PetscCall(PetscArraycpy(u[k], self->all[k].u, FIELDS));
    PetscCall(PetscArraycpy(rate[k], self->all[k].rate, FIELDS));
  }
  PetscCall(VecRestoreArrayWrite(self->U, (PetscScalar **)&u));
  PetscCall(VecRestoreArrayWrite(self->rate, (PetscScalar **)&rate));
  PetscFunctionReturn(0);
}

/* The law of contact is that of the run, whose mesh it may follow. */
static void TakeContact(Estimate self) {
  const Contact *contact = &self->leg->rod->scene->contact;

  self->scene.contact.given = PETSC_TRUE;
  self->scene.contact.stiffness = contact->stiffness;
  self->scene.contact.time = PETSC_MIN_REAL;
}

/* F_U + F_U_t shift at the state that is put. */
static PetscErrorCode Linearise(Estimate self, PetscReal t, const PetscReal shift[FIELDS]) {
  Rod rod = self->rod;

  PetscFunctionBegin;
  rod->fresh = PETSC_TRUE;
  PetscCall(rod_frame.residual(rod, t, self->U, self->rate, self->F));
  if (self->elimination)
    PetscCall(rod_frame.eliminate(rod, t, self->U, self->rate, shift, self->elimination));
  else {
    PetscCall(rod_frame.jacobian(rod, t, self->U, self->rate, shift, self->J));
    PetscCall(KSPSetOperators(self->ksp, self->J, self->J));
  }
  rod->fresh = PETSC_FALSE;
  PetscFunctionReturn(0);
}

/* ... times e is rhs */
static PetscErrorCode Solve(Estimate self, PetscReal (*e)[FIELDS]) {
  const PetscScalar *x;
  PetscReal(*b)[FIELDS];

  PetscFunctionBegin;
  if (self->elimination) {
    PetscCall(EliminationSolve(self->elimination, (const PetscReal(*)[FIELDS])self->rhs, e));
    PetscFunctionReturn(0);
  }
  PetscCall(VecGetArrayWrite(self->nudged, (PetscScalar **)&b));
  PetscCall(PetscArraycpy(b, self->rhs, self->nodes));
  PetscCall(VecRestoreArrayWrite(self->nudged, (PetscScalar **)&b));
  PetscCall(KSPSolve(self->ksp, self->nudged, self->G));
  PetscCall(VecGetArrayRead(self->G, &x));
  PetscCall(PetscArraycpy((PetscScalar *)e, x, self->nodes * FIELDS));
  PetscCall(VecRestoreArrayRead(self->G, &x));
  PetscFunctionReturn(0);
}

/* rhs = -F_U_t b, by a difference so small that friction is straight over it. */
static PetscErrorCode TimesRate(Estimate self, PetscReal t) {
  const PetscReal beta = self->scene.load.friction.beta;
  const PetscScalar *F, *G;
  PetscReal(*rate)[FIELDS], most = 0, scale;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(self->rhs, self->nodes));
  for (PetscInt k = 0; k < self->nodes; k++)
    for (int f = 0; f < FOLLOWED; f++) most = PetscMax(most, PetscAbsReal(self->b[k][f]));
  if (most <= rod_vanished) PetscFunctionReturn(0);
  scale = nudge * PetscSqrtReal(beta > 0 ? beta : friction_tiny) / most;
  PetscCall(VecCopy(self->rate, self->nudged));
  PetscCall(VecGetArray(self->nudged, (PetscScalar **)&rate));
  for (PetscInt k = 0; k < self->nodes; k++)
    for (int f = 0; f < FOLLOWED; f++) rate[k][f] += scale * self->b[k][f];
  PetscCall(VecRestoreArray(self->nudged, (PetscScalar **)&rate));
  PetscCall(rod_frame.residual(self->rod, t, self->U, self->nudged, self->G));
  PetscCall(VecGetArrayRead(self->F, &F));
  PetscCall(VecGetArrayRead(self->G, &G));
  for (PetscInt i = 0; i < self->nodes * FIELDS; i++)
    (&self->rhs[0][0])[i] = -(G[i] - F[i]) / scale;
  PetscCall(VecRestoreArrayRead(self->F, &F));
  PetscCall(VecRestoreArrayRead(self->G, &G));
  PetscFunctionReturn(0);
}

/* rhs -= d: of each cell's equations, in the rows that the frame model has them. */
static void SubtractDefect(Estimate self) {
  for (PetscInt k = 0; k + 1 < self->nodes; k++)
    for (int f = 0; f < FIELDS; f++) self->rhs[f < M ? k + 1 : k][f] -= self->all[k].defect[f];
}

/* rhs -= by what the residual changes while a number of the scene grows by a part of itself. */
static PetscErrorCode SubtractChange(Estimate self, PetscReal t, PetscReal *number) {
  const PetscReal taken = *number;
  const PetscScalar *F, *G;

  PetscFunctionBegin;
  PetscCall(VecCopy(self->rate, self->nudged)); /* (the same rates, but no state that is known) */
  *number = (1 + nudge) * taken;
  self->scene.contact.time = PETSC_MIN_REAL;
  PetscCall(rod_frame.residual(self->rod, t, self->U, self->nudged, self->G));
  *number = taken;
  self->scene.contact.time = PETSC_MIN_REAL;
  PetscCall(VecGetArrayRead(self->F, &F));
  PetscCall(VecGetArrayRead(self->G, &G));
  for (PetscInt i = 0; i < self->nodes * FIELDS; i++)
    (&self->rhs[0][0])[i] -= (G[i] - F[i]) / nudge;
  PetscCall(VecRestoreArrayRead(self->F, &F));
  PetscCall(VecRestoreArrayRead(self->G, &G));
  PetscFunctionReturn(0);
}

/* Is there anything of this kind that errs? */
static PetscBool Errs(const Estimate self, int part) {
  if (part == ESTIMATE_LIMIT) return self->scene.load.limit;
  return (PetscBool)(part != ESTIMATE_SOFT || self->touches);
}

/* rhs -= what this part does: the defect; beta dF/dbeta, for friction that is exact is that of
   beta -> 0; k dF/dk, for rigid contact is that of 1/k -> 0. */
static PetscErrorCode SubtractSource(Estimate self, PetscReal t, int part) {
  PetscFunctionBegin;
  if (part == ESTIMATE_SPACE) SubtractDefect(self);
  if (part == ESTIMATE_LIMIT) PetscCall(SubtractChange(self, t, &self->scene.load.friction.beta));
  if (part == ESTIMATE_SOFT) PetscCall(SubtractChange(self, t, &self->scene.contact.stiffness));
  PetscFunctionReturn(0);
}

/* What an error makes of tip, |x2| and energy, relative. Where the moment all but vanishes between
   two looks, by Schwarz's inequality, dip its part that is left: dE/E <= 2 |dm|/|m|. */
static PetscErrorCode See(Estimate self, PetscReal t, PetscReal dip, PetscReal (*e)[FIELDS],
                          PetscReal seen[ESTIMATE_SEEN]) {
  const PetscReal *s = self->scene.mesh.s;
  const PetscInt last = self->nodes - 1;
  const Gathered *p = self->all;
  PetscReal norm = 0, energy = 0, by_norm = 0, by_energy = 0, off = 0, size = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k <= last; k++) size = PetscMax(size, PetscAbsReal(p[k].u[X2]));
  size = PetscMax(size, rod_vanished);
  for (PetscInt k = 0; k <= last; k++) {
    PetscReal w = (s[PetscMin(k + 1, last)] - s[PetscMax(k - 1, 0)]) / 2, g, B,
              y = p[k].u[X2] / size;
    PetscCall(GrowthStretch(self->scene.growth, 1, &s[k], t, &g, NULL, NULL));
    PetscCall(SceneStiffness(&self->scene, s[k], t, &B, NULL));
    norm += w * y * y;
    by_norm += w * y * (e[k][X2] / size);
    energy += w * g / B * PetscSqr(p[k].u[M] / size);
    by_energy += 2 * w * g / B * (p[k].u[M] / size) * (e[k][M] / size);
    off += w * g / B * PetscSqr(e[k][M] / size);
  }
  seen[ESTIMATE_TIP] =
      hypot(e[last][X1], e[last][X2]) / PetscMax(hypot(p[last].u[X1], p[last].u[X2]), rod_vanished);
  seen[ESTIMATE_NORM] = norm > 0 ? PetscAbsReal(by_norm / norm) : 0;
  seen[ESTIMATE_ENERGY] = energy > 0 ? PetscAbsReal(by_energy / energy) : 0;
  if (energy > 0 && dip < most_dip)
    seen[ESTIMATE_ENERGY] = PetscMax(seen[ESTIMATE_ENERGY],
                                     2 * PetscSqrtReal(off / energy) / PetscMax(dip, rod_vanished));
  PetscFunctionReturn(0);
}

/* Beyond 1 an error is no small one any more, and the linear equations say nothing. */
static PetscErrorCode Keep(Estimate self, PetscReal t, PetscReal dip, int part) {
  PetscReal seen[ESTIMATE_SEEN] = {0}, most = 0, (*e)[FIELDS] = self->e[part];

  PetscFunctionBegin;
  PetscCall(See(self, t, dip, e, seen));
  for (int k = 0; k < ESTIMATE_SEEN; k++) {
    if (PetscIsInfOrNanReal(seen[k])) seen[k] = most = PETSC_MAX_REAL;
    most = PetscMax(most, seen[k]);
    if (t > early * self->scene.end_time)
      self->worst[part][k] = PetscMax(self->worst[part][k], PetscMin(1, seen[k]));
  }
  for (PetscInt i = 0; i < self->nodes * FIELDS && most > 1; i++) {
    PetscReal *value = &e[0][0] + i;
    *value = most < PETSC_MAX_REAL ? *value / most : 0;
  }
  PetscFunctionReturn(0);
}

/* A step of backward Euler from before to t. (A'/A is that at t: with its mean over the step, which
   is another where the rate changes, errors would rise or fall against x2.) */
static PetscErrorCode Advance(Estimate self, PetscReal t, PetscReal dip) {
  PetscReal rate, size = Size(self, &rate), factor = 1, step = t - self->before, shift[FIELDS],
                  most_folds = 30;

  PetscFunctionBegin;
  if (size > 0 && self->size > 0)
    factor =
        PetscExpReal(PetscMax(-most_folds, PetscMin(most_folds, PetscLogReal(size / self->size))));
  self->size = size;
  self->scene.load.friction.mu = self->leg->rod->scene->load.friction.mu; /* a snap may change it */
  PetscCall(PutState(self));
  TakeContact(self);
  for (int f = 0; f < FIELDS; f++) shift[f] = 1 / step + (rod_frame.group[f] != ALONG ? rate : 0);
  PetscCall(Linearise(self, t, shift));
  for (int part = 0; part < ESTIMATE_PARTS; part++) {
    if (!Errs(self, part)) continue;
    for (PetscInt k = 0; k < self->nodes; k++)
      for (int f = 0; f < FOLLOWED; f++)
        self->b[k][f] = -(self->e[part][k][f] * (f == X1 ? 1 : factor) +
                          (part == ESTIMATE_TIME ? self->all[k].local[f] : 0)) /
                        step;
    PetscCall(TimesRate(self, t));
    PetscCall(SubtractSource(self, t, part));
    PetscCall(Solve(self, self->e[part]));
    PetscCall(Keep(self, t, dip, part));
  }
  PetscFunctionReturn(0);
}

/* By how much the largest moment was less, since e was stepped last, than both then and now. */
static PetscReal Dip(const Estimate self, PetscReal now) {
  return self->moment[1] / PetscMax(PetscMin(self->moment[0], now), rod_vanished);
}

/*
  EstimateStep - goes on to the state that an accepted step has led to. Collective.

  jumped   the step was a jump: what it adds is not known
  touches  the rod has touched something, now or before
*/
PetscErrorCode EstimateStep(Estimate self, PetscBool jumped, PetscBool touches) {
  PetscReal size[MAX_FIELDS], rate, t;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(TSGetTime(self->leg->ts, &t));
  if (touches && !self->touches) PetscCall(Refine(self));
  PetscCall(RodFieldSizes(self->leg->rod, self->leg->U, size));
  if (!jumped) PetscCall(AddLocal(self, Ratio(size[X2], self->latest)));
  self->latest = size[X2];
  self->moment[1] = PetscMin(self->moment[1], size[M]);
  if (++self->since < SELDOM && (touches || size[TH] < straight) &&
      t < self->leg->rod->scene->end_time)
    PetscFunctionReturn(0);
  PetscCall(Gather(self, size[X2]));
  if (self->rod && !jumped) PetscCall(Advance(self, t, Dip(self, size[M])));
  if (self->rod && jumped) self->size = Size(self, &rate);
  for (PetscInt k = 0; k < self->nodes; k++)
    PetscCall(PetscArrayzero(self->own[k].local, FOLLOWED));
  self->before = t;
  self->moment[0] = self->moment[1] = size[M];
  self->since = 0;
  PetscFunctionReturn(0);
}

/* EstimateGet - the largest errors so far, of each part in each of what is seen. Collective. */
PetscErrorCode EstimateGet(Estimate self, PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN]) {
  const PetscMPIInt n = ESTIMATE_PARTS * ESTIMATE_SEEN;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(self->worst, n, MPIU_REAL, 0, self->leg->rod->scene->comm));
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(PetscArraycpy(worst[part], self->worst[part], ESTIMATE_SEEN));
  PetscFunctionReturn(0);
}

/* EstimateSet - takes over those of an earlier run that this one goes on with, at t. */
PetscErrorCode EstimateSet(Estimate self, PetscReal t,
                           const PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN]) {
  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  self->before = t;
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(PetscArraycpy(self->worst[part], worst[part], ESTIMATE_SEEN));
  PetscFunctionReturn(0);
}
