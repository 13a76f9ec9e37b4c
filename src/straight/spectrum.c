#include "straight/spectrum.h"
#include "base/band.h"
#include "base/chain.h"
#include "straight/dense.h"
#include "straight/straight.h"
#include <slepcblaslapack.h>

PetscErrorCode SpectrumDestroy(Spectrum *self) {
  PetscFunctionBegin;
  PetscCall(EPSDestroy(&self->eps));
  PetscCall(MatDestroy(&self->A));
  PetscCall(MatDestroy(&self->B));
  PetscFunctionReturn(0);
}

/* The mixed matrix has lengths of 1 in it. Where the rod's own length and rates are far from that,
   it would hold numbers of all sizes; so K is measured in units of B/L^3 and D in those of drag
   times L (powers of 2, which round nothing). */
typedef struct {
  PetscReal force, drag; /* what K and D are multiplied by */
} Units;

static PetscErrorCode UnitsAt(Pencil p, Units *units) {
  PetscReal L;

  PetscFunctionBegin;
  PetscCall(GrowthLength(p->growth, p->time, &L, NULL));
  units->force = exp2(round(3 * log2(L)));
  units->drag = exp2(-round(log2(L * p->drag_max)));
  PetscFunctionReturn(0);
}

static void Scale(PetscInt n, PetscReal band[], PetscReal factor) {
  for (PetscInt i = 0; i < n; i++) band[i] *= factor;
}

/* The residual against the distance to the shift: an eigenvalue may well be 0, where a relative
   test would never be met. */
static PetscErrorCode AgainstShift(EPS eps, PetscScalar re, PetscScalar im, PetscReal residual,
                                   PetscReal *error, void *ctx) {
  const Spectrum *self = (const Spectrum *)ctx;
  PetscReal shift = self->shift / self->rate;
  PetscFunctionBegin;
  *error = residual * SlepcAbsEigenvalue(re - shift, im);
  PetscFunctionReturn(0);
}

static PetscErrorCode DirectSolver(EPS eps) {
  ST st;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscCall(EPSGetST(eps, &st));
  PetscCall(STGetKSP(st, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(ChainSetType(pc, MATORDERINGNATURAL));
  PetscFunctionReturn(0);
}

/* SpectrumReadOptions - reads the solver's options and forgets them, so that a mistyped one can be
   refused before any work. Collective. */
PetscErrorCode SpectrumReadOptions(void) {
  EPS eps;

  PetscFunctionBegin;
  PetscCall(EPSCreate(OptionsComm(), &eps));
  PetscCall(DirectSolver(eps));
  PetscCall(EPSSetFromOptions(eps));
  PetscCall(EPSDestroy(&eps));
  PetscFunctionReturn(0);
}

/* SpectrumCreate - a solver for the pencil's problems, for one kind of them only. The caller
   destroys it with SpectrumDestroy(), before the pencil. Collective.

   quiet   leaves the command line alone; else -eps_... and -st_... are read, here for the first
   time
*/
PetscErrorCode SpectrumCreate(Pencil pencil, PetscBool quiet, Spectrum *self) {
  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  self->pencil = pencil;
  self->quiet = quiet;
  PetscCall(EPSCreate(pencil->comm, &self->eps));
  PetscCall(EPSSetTolerances(self->eps, 1e-11, 500));
  PetscCall(EPSSetDimensions(self->eps, 1, 12, PETSC_DEFAULT));
  PetscCall(DirectSolver(self->eps));
  if (!quiet) PetscCall(EPSSetFromOptions(self->eps));
  PetscFunctionReturn(0);
}

/* Copies a distributed vector to an array of all ranks; stride and offset pick one kind. */
static PetscErrorCode GatherKind(Vec z, PetscInt n, PetscInt stride, PetscInt offset,
                                 PetscReal out[]) {
  VecScatter scatter;
  Vec all;
  const PetscReal *a;

  PetscFunctionBegin;
  PetscCall(VecScatterCreateToAll(z, &scatter, &all));
  PetscCall(VecScatterBegin(scatter, z, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(scatter, z, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(all, &a));
  for (PetscInt i = 0; i < n; i++) out[i] = a[stride * i + offset];
  PetscCall(VecRestoreArrayRead(all, &a));
  PetscCall(VecScatterDestroy(&scatter));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(0);
}

/* c and w of a mixed vector, or NULL; of joined directions those of x2, then those of x3. */
static PetscErrorCode GatherShape(Pencil p, Vec z, PetscReal c[], PetscReal w[]) {
  const PetscInt stride = 3 * p->ways;

  PetscFunctionBegin;
  for (PetscInt way = 0; way < p->ways; way++) {
    if (w) PetscCall(GatherKind(z, p->n, stride, 3 * way, w + way * p->n));
    if (c) PetscCall(GatherKind(z, p->n, stride, 3 * way + 1, c + way * p->n));
  }
  PetscFunctionReturn(0);
}

/* The friction norm |y|^2 = int g phi0 y^2 ds: over L(t) for growth in place, so that a norm that
   only swells with the rod counts as constant; as it is for laws that slide. Returns (ln L)_t or 0.
 */
static PetscErrorCode NormSwell(Pencil pencil, PetscReal *swell) {
  PetscReal L, L_t;

  PetscFunctionBegin;
  PetscCall(GrowthLength(pencil->growth, pencil->time, &L, &L_t));
  *swell = pencil->growth->slides ? 0 : L_t / L;
  PetscFunctionReturn(0);
}

/* The bands that join two directions: K23 and K32, or both halves of their symmetric part. */
static PetscErrorCode Join(Pencil p, PetscBool symmetric, PetscReal force, PetscReal K23[],
                           PetscReal K32[]) {
  const PetscInt rows = (p->last - p->first) * WIDTH;
  PetscReal *T, *TT, *bend;

  PetscFunctionBegin;
  if (p->ways == 1) PetscFunctionReturn(0);
  PetscCall(PetscMalloc3(rows, &T, rows, &TT, rows, &bend));
  PetscCall(PencilBand(p, FORM_TORQUE, T));
  PetscCall(PencilBand(p, FORM_TORQUE_T, TT));
  PetscCall(PencilBand(p, FORM_BEND_23, bend));
  for (PetscInt i = 0; i < rows; i++) {
    PetscReal turn = symmetric ? (T[i] - TT[i]) / 2 : T[i];
    K23[i] = force * (turn - bend[i]);
    K32[i] = force * (-turn - bend[i]);
  }
  PetscCall(PetscFree3(T, TT, bend));
  PetscFunctionReturn(0);
}

/* The mixed pencil of a rate, at the time the pencil is set to. For RATE_FRICTION
   d/dt |y|^2 / 2 |y|^2 = <y, (K + K^T)/2 y + (D_t - swell D)/2 y> / <y, D y>. */
static PetscErrorCode AssembleRate(Spectrum *self, SpectrumRate rate, PetscReal *bound) {
  Pencil p = self->pencil;
  PetscInt rows = (p->last - p->first) * WIDTH;
  PetscReal *K, *K3, *K23, *K32, *D, *extra, *X, *XT, swell = 0;
  PetscBool friction = (PetscBool)(rate == RATE_FRICTION), skew = p->skew;
  PencilBands bands = {.K = {NULL}};
  Units units;

  PetscFunctionBegin;
  PetscCall(PetscMalloc5(rows, &K, rows, &D, rows, &extra, rows, &X, rows, &XT));
  PetscCall(PetscMalloc3(rows, &K3, rows, &K23, rows, &K32));
  PetscCall(PencilBand(p, FORM_STIFF, K));
  if (p->ways > 1) PetscCall(PencilBand(p, FORM_STIFF_3, K3));
  PetscCall(PencilBand(p, FORM_DRAG, D));
  PetscCall(PencilBand(p, FORM_DRAG_RATE, extra));
  PetscCall(PencilBand(p, FORM_SLIDE, X));
  PetscCall(PencilBand(p, FORM_SLIDE_T, XT));
  PetscCall(PencilBound(p, bound));
  PetscCall(NormSwell(p, &swell));
  for (PetscInt i = 0; i < rows && friction; i++) {
    extra[i] = (extra[i] - swell * D[i]) / 2;
    X[i] /= 2;
    XT[i] /= 2;
  }
  if (friction) *bound += PetscMax(0, (p->rate_max - swell) / 2);
  PetscCall(UnitsAt(p, &units));
  self->rate = units.drag / units.force;
  PetscCall(Join(p, friction, units.force, K23, K32));
  Scale(rows, K, units.force);
  if (p->ways > 1) Scale(rows, K3, units.force);
  Scale(rows, X, units.force);
  Scale(rows, XT, units.force);
  Scale(rows, extra, units.force);
  Scale(rows, D, units.drag);
  bands = (PencilBands){.K = {K, K3},
                        .K23 = K23,
                        .K32 = K32,
                        .X = skew ? X : NULL,
                        .XT = skew && friction ? XT : NULL,
                        .c = friction ? extra : NULL,
                        .D = D};
  PetscCall(PencilMixed(p, &bands, &self->A, &self->B));
  PetscCall(PetscFree5(K, D, extra, X, XT));
  PetscCall(PetscFree3(K3, K23, K32));
  PetscFunctionReturn(0);
}

/* Solves for the eigenvalue nearest the shift; vectors as in SpectrumLargest(). */
static PetscErrorCode Solve(Spectrum *self, PetscInt stride, Eigenvalue *value, PetscReal c[],
                            PetscReal w[]) {
  EPS eps = self->eps;
  PetscInt found;
  PetscScalar re, im;
  Vec x;

  PetscFunctionBegin;
  if (!self->quiet) PetscCall(EPSSetFromOptions(eps));
  PetscCall(EPSSolve(eps));
  PetscCall(EPSGetConverged(eps, &found));
  PetscCheck(found > 0, self->pencil->comm, PETSC_ERR_CONV_FAILED,
             "no eigenvalue converged at t = %g", (double)self->pencil->time);
  PetscCall(MatCreateVecs(self->A, &x, NULL));
  PetscCall(EPSGetEigenpair(eps, 0, &re, &im, x, NULL));
  PetscCall(EPSGetErrorEstimate(eps, 0, &value->error));
  value->value = re * self->rate;
  value->frequency = PetscAbsReal(im) * self->rate;
  if (stride > 1)
    PetscCall(GatherShape(self->pencil, x, c, w));
  else if (w)
    PetscCall(GatherKind(x, self->pencil->n, stride, 0, w));
  PetscCall(VecDestroy(&x));
  PetscFunctionReturn(0);
}

/* Turns shift-and-invert on or off; a solver serves one kind of problem only. */
static PetscErrorCode ShiftInvert(Spectrum *self, EPSProblemType type) {
  ST st;

  PetscFunctionBegin;
  PetscCall(EPSSetOperators(self->eps, self->A, self->B));
  PetscCall(EPSSetProblemType(self->eps, type));
  PetscCall(EPSSetTarget(self->eps, self->shift / self->rate));
  PetscCall(EPSSetWhichEigenpairs(self->eps, EPS_TARGET_MAGNITUDE));
  PetscCall(EPSGetST(self->eps, &st));
  PetscCall(STSetType(st, STSINVERT));
  PetscCall(STSetMatStructure(st, SUBSET_NONZERO_PATTERN));
  PetscCall(EPSSetConvergenceTestFunction(self->eps, AgainstShift, self, NULL));
  PetscFunctionReturn(0);
}

/* Round rods have modes in pairs, which turn into each other: where K is not symmetric round-off
   may make two real ones that are the same a complex pair. */
static PetscBool IsRealPair(Pencil p, PetscReal frequency) {
  const PetscReal round_off = 1e-9;
  return (PetscBool)(p->ways > 1 && frequency < round_off * p->compression / p->drag_max);
}

/*
  SpectrumLargest - the largest eigenvalue of A(t) = D^-1 K, or the largest rate of growth of any
  deflection in the friction norm. Collective.

  value   the error is that of the eigenvalue as far as the residual tells
  c, w    coefficients of the eigenvector, n values on all ranks, or NULL; joined directions: 2 n

  Shift-and-invert at PencilBound(), above which there is no eigenvalue: the nearest one is the
  largest. Where K is not symmetric, see SpectrumRightmost().
*/
PetscErrorCode SpectrumLargest(Spectrum *self, SpectrumRate rate, PetscReal t, Eigenvalue *value,
                               PetscReal c[], PetscReal w[]) {
  PetscBool nonsymmetric =
      (PetscBool)((self->pencil->skew || self->pencil->ways > 1) && rate == RATE_A);

  PetscFunctionBegin;
  PetscCall(PencilSetTime(self->pencil, t, rate == RATE_A ? FRAME_ARC : FRAME_LABEL));
  PetscCall(AssembleRate(self, rate, &self->shift));
  if (nonsymmetric) {
    Pencil small;
    Mesh mesh;
    PetscCall(MeshCreate(PetscMin(self->pencil->mesh->cells, 100), PETSC_FALSE,
                         self->pencil->growth, t, &mesh));
    PetscCall(PencilCreate(PETSC_COMM_SELF, self->pencil->scene, &mesh, map_follows,
                           self->pencil->way, &small));
    PetscCall(SpectrumRightmost(small, t, value));
    PetscCall(PencilDestroy(&small));
    PetscCall(MeshDestroy(&mesh));
    self->shift = value->value + 1e-3 + value->frequency / 4;
    PetscCall(EPSSetDimensions(self->eps, 6, 30, PETSC_DEFAULT));
  }
  PetscCall(ShiftInvert(self, nonsymmetric ? EPS_GNHEP : EPS_GHEP));
  if (!nonsymmetric) {
    PetscCall(Solve(self, 3, value, c, w));
    value->error *= value->error * PetscAbsReal(value->value - self->shift);
    PetscFunctionReturn(0);
  }
  {
    Eigenvalue near = *value, first;
    PetscInt found, best = 0;
    PetscReal least = PETSC_MAX_REAL;
    Vec x;
    PetscCall(Solve(self, 3, &first, NULL, NULL));
    PetscCall(EPSGetConverged(self->eps, &found));
    for (PetscInt i = 0; i < found; i++) {
      PetscScalar re, im;
      PetscReal d;
      PetscCall(EPSGetEigenvalue(self->eps, i, &re, &im));
      re *= self->rate;
      im *= self->rate;
      d = SlepcAbsEigenvalue(re - near.value, PetscAbsReal(im) - near.frequency);
      if (d >= least) continue;
      least = d;
      best = i;
      value->value = re;
      value->frequency = PetscAbsReal(im);
    }
    if (IsRealPair(self->pencil, value->frequency)) value->frequency = 0;
    PetscCall(EPSGetErrorEstimate(self->eps, best, &value->error));
    value->error *= self->rate;
    PetscCall(MatCreateVecs(self->A, &x, NULL));
    PetscCall(EPSGetEigenvector(self->eps, best, x, NULL));
    PetscCall(GatherShape(self->pencil, x, c, w));
    PetscCall(VecDestroy(&x));
  }
  PetscFunctionReturn(0);
}

/* A positive definite matrix may be eliminated in any order: this one, where PETSc has it, rounds
   ten times less than from end to end. Several ranks have their own solver, which it does not
   concern. */
static PetscErrorCode OrderForAccuracy(EPS eps) {
  PetscErrorCode (*order)(Mat, MatOrderingType, IS *, IS *);
  ST st;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscCall(PetscFunctionListFind(MatOrderingList, MATORDERINGAMD, &order));
  if (!order) PetscFunctionReturn(0);
  PetscCall(EPSGetST(eps, &st));
  PetscCall(STGetKSP(st, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCFactorSetMatOrderingType(pc, MATORDERINGAMD));
  PetscFunctionReturn(0);
}

/* What no ratio of SpectrumBuckling() exceeds: max(P)/min(B) (2 L/pi)^2, for int u^2 dp <= (2
   L/pi)^2 int u_p^2 dp where u(0) = 0. pulled: P is negative somewhere. */
static PetscErrorCode BucklingBound(Pencil p, PetscReal *bound, PetscBool *pulled) {
  PetscReal most[3] = {PETSC_MIN_REAL, PETSC_MIN_REAL, PETSC_MIN_REAL}, L; /* of P, -P, -B */
  PetscMPIInt n = 3;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < p->cells * GAUSS; k++) {
    most[0] = PetscMax(most[0], p->point[k].P);
    most[1] = PetscMax(most[1], -p->point[k].P);
    most[2] = PetscMax(most[2], -p->point[k].B);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, n, MPIU_REAL, MPI_MAX, p->comm));
  PetscCall(GrowthLength(p->growth, p->time, &L, NULL));
  *bound = most[0] / -most[2] * PetscSqr(2 * L / PETSC_PI);
  *pulled = (PetscBool)(most[1] > 0);
  PetscFunctionReturn(0);
}

/*
  SpectrumBuckling - the largest eigenvalue of int P g u u = ratio int u_p u_p / .., u = y_p: above
  1 the straight rod is unstable, at 1 critical (the Sturm-Liouville problem of
  docs/theory/straight.md). For uniform growth L^3 / ratio = L_cr^3. Collective; arguments as in
  SpectrumLargest(), w only. A rod that is pulled everywhere has none above 0: the ratio is then 0,
  without a mode.

  A tip that is pulled makes most eigenvalues negative and the largest of them small against these:
  it is found as the one nearest to a bound from above.
*/
PetscErrorCode SpectrumBuckling(Spectrum *self, PetscReal t, Eigenvalue *ratio, PetscReal c[],
                                PetscReal w[]) {
  const PetscReal above = 1e-3, nothing = 1e-10;
  PetscReal bound;
  PetscBool pulled;

  PetscFunctionBegin;
  PetscCall(PencilSetTime(self->pencil, t, FRAME_LABEL));
  *ratio = (Eigenvalue){0};
  self->rate = 1;
  if (self->pencil->compression == 0) PetscFunctionReturn(0);
  PetscCall(BucklingBound(self->pencil, &bound, &pulled));
  if (bound <= 0) PetscFunctionReturn(0);
  if (pulled && bound < nothing) { /* round-off of a rod at rest: a matrix of zeros to PETSc */
    ratio->value = bound;
    PetscFunctionReturn(0);
  }
  PetscCall(PencilMatrix(self->pencil, FORM_AXIAL, &self->A));
  PetscCall(PencilMatrix(self->pencil, FORM_BEND, &self->B));
  if (pulled || self->inverted) {
    self->shift = (1 + above) * bound;
    self->inverted = PETSC_TRUE;
    PetscCall(ShiftInvert(self, EPS_GHEP));
  } else {
    PetscCall(EPSSetOperators(self->eps, self->A, self->B));
    PetscCall(EPSSetProblemType(self->eps, EPS_GHEP));
    PetscCall(EPSSetWhichEigenpairs(self->eps, EPS_LARGEST_REAL));
  }
  PetscCall(OrderForAccuracy(self->eps));
  PetscCall(Solve(self, 1, ratio, NULL, w));
  ratio->error *= ratio->error * PetscAbsReal(ratio->value);
  if (c && w) {
    Pencil p = self->pencil;
    const PetscReal *s = p->mesh->s;
    PetscReal sum = 0;
    for (PetscInt i = 0; i < p->n; i++)
      c[i] = sum += w[i] * (s[PetscMin(i + 2, p->mesh->cells)] - s[PetscMax(i - 1, 0)]) / 3;
  }
  PetscFunctionReturn(0);
}

/* Kinds as in PencilMixed(): those of x3 follow those of x2. */
static void FillMixed(Pencil p, const PetscReal *band, PetscReal factor, PetscInt row_kind,
                      PetscInt col_kind, Band *A) {
  const PetscInt n = p->n, stride = 3 * p->ways;
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt b = 0; b < WIDTH; b++) {
      PetscInt j = i - HALF + b;
      PetscReal value = factor * band[i * WIDTH + b];
      if (j < 0 || j >= n || value == 0) continue;
      if (PencilIsHeld(p, i, row_kind % 3) || PencilIsHeld(p, j, col_kind % 3)) continue;
      *BandAt(A, stride * i + row_kind, stride * j + col_kind) += value;
    }
}

/* E, E^T and Delta of one direction. */
static void JoinMixed(Pencil p, PetscInt way, Band *A) {
  const PetscInt stride = 3 * p->ways;

  for (PetscInt i = 0; i < p->n; i++) {
    PetscInt w = stride * i + 3 * way, c = w + 1, n = w + 2;
    if (PencilIsHeld(p, i, 0))
      *BandAt(A, w, w) = 1;
    else
      *BandAt(A, w, n) = *BandAt(A, n, w) = -p->delta[i];
    if (PencilIsHeld(p, i, 1))
      *BandAt(A, c, c) = 1;
    else
      *BandAt(A, n, c) = *BandAt(A, c, n) = 1;
    if (i > 0) *BandAt(A, n, c - stride) = -1;
    if (i < p->n - 1) *BandAt(A, c, n + stride) = -1;
  }
}

/* K - shift D in the mixed unknowns, factored, on one rank. D: [n][WIDTH], filled here. */
static PetscErrorCode FactorMixed(Pencil p, PetscReal shift, const Units *units, PetscReal D[],
                                  Band *A) {
  const PetscInt half = 3 * p->ways * HALF + (p->ways > 1 ? 3 : 1);
  PetscReal *band, *back;

  PetscFunctionBegin;
  PetscCheck(p->first == 0 && p->last == p->n, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "the dense route wants a pencil of one rank");
  PetscCall(PetscMalloc2(p->n * WIDTH, &band, p->n * WIDTH, &back));
  PetscCall(BandCreate(3 * p->ways * p->n, half, half, A));
  PetscCall(PencilBand(p, FORM_DRAG, D));
  for (PetscInt way = 0; way < p->ways; way++) {
    PetscCall(PencilBand(p, way ? FORM_STIFF_3 : FORM_STIFF, band));
    FillMixed(p, band, units->force, 3 * way, 3 * way, A);
    PetscCall(PencilBand(p, FORM_SLIDE, band));
    FillMixed(p, band, units->force, 3 * way + 1, 3 * way, A);
    FillMixed(p, D, -shift * units->force, 3 * way + 1, 3 * way + 1, A);
    JoinMixed(p, way, A);
  }
  if (p->ways > 1) {
    PetscCall(Join(p, PETSC_FALSE, units->force, band, back));
    FillMixed(p, band, 1, 0, 3, A);
    FillMixed(p, back, 1, 3, 0, A);
  }
  PetscCall(BandFactorShifted(A));
  PetscCall(PetscFree2(band, back));
  PetscFunctionReturn(0);
}

/*
  SpectrumDense - the inverse of A - shift as a dense matrix, on one rank, at the time the pencil is
  set to. In the inverse the low modes, the ones that matter, are accurate to rounding.

  symmetric   R (K - shift D)^-1 R^T with D = R^T R, else (K - shift D)^-1 D
  T           n * n, by columns; joined directions: 2 n * 2 n, all of x2 before all of x3
*/
PetscErrorCode SpectrumDense(Pencil p, PetscReal shift, PetscBool symmetric, PetscReal T[]) {
  const PetscInt n = p->n, all = p->ways * n, stride = 3 * p->ways;
  PetscReal *D, *R, *column;
  Units units;
  Band A;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(n * WIDTH, &D, n * (HALF + 1), &R, stride * n, &column));
  PetscCall(UnitsAt(p, &units));
  PetscCall(FactorMixed(p, shift, &units, D, &A));
  PetscCall(BandCholesky(n, HALF, D, R));
  for (PetscInt j = 0; j < all; j++) {
    PetscReal *y = T + j * all, *mine = y + j / n * n; /* of its own direction */
    PetscInt c = 3 * (j / n) + 1;
    PetscCall(PetscArrayzero(y, all));
    y[j] = 1;
    if (!symmetric) BandUpperMult(n, HALF, R, PETSC_FALSE, mine);
    BandUpperMult(n, HALF, R, PETSC_TRUE, mine);
    PetscCall(PetscArrayzero(column, stride * n));
    for (PetscInt i = 0; i < n; i++) column[stride * i + c] = mine[i];
    if (PencilIsHeld(p, n - 1, 1))
      column[stride * (n - 1) + c] = 0; /* held: an eigenvalue 0 of the inverse */
    PetscCall(BandSolve(&A, PETSC_FALSE, 1, column));
    for (PetscInt i = 0; i < all; i++) y[i] = column[stride * (i % n) + 3 * (i / n) + 1];
    for (PetscInt way = 0; symmetric && way < p->ways; way++)
      BandUpperMult(n, HALF, R, PETSC_FALSE, y + way * n);
  }
  if (symmetric)
    for (PetscInt j = 0; j < all; j++)
      for (PetscInt i = 0; i < j; i++)
        T[j * all + i] = T[i * all + j] = (T[j * all + i] + T[i * all + j]) / 2;
  Scale(all * all, T, units.force);
  PetscCall(BandDestroy(&A));
  PetscCall(PetscFree3(D, R, column));
  PetscFunctionReturn(0);
}

/* A shift that is that many times the size of what is looked for is moved nearer, so often at most.
 */
static const PetscReal far_shift = 1e4;
enum { MOST_SHIFTS = 3 };

/* The rightmost of the eigenvalues shift + 1/mu, mu those of the inverse, below the bound of all.
 */
static PetscErrorCode RightmostBy(Pencil p, PetscReal shift, PetscReal bound, PetscReal T[],
                                  PetscReal re[], PetscReal im[], Eigenvalue *value) {
  const PetscInt all = p->ways * p->n;

  PetscFunctionBegin;
  PetscCall(SpectrumDense(p, shift, PETSC_FALSE, T));
  PetscCall(DenseEigenvalues(all, T, re, im, NULL));
  value->value = PETSC_MIN_REAL;
  value->error = 0;
  for (PetscInt i = 0; i < all; i++) {
    PetscReal size = re[i] * re[i] + im[i] * im[i], at = shift + re[i] / size;
    if (size == 0 || at <= value->value || at > bound * (1 + 1e-8)) continue;
    value->value = at;
    value->frequency = PetscAbsReal(im[i]) / size;
  }
  PetscFunctionReturn(0);
}

/*
  SpectrumRightmost - the eigenvalue of A(t) with the largest real part, real or complex, from the
  whole dense spectrum. One rank; for small n.
*/
PetscErrorCode SpectrumRightmost(Pencil p, PetscReal t, Eigenvalue *value) {
  PetscInt n = p->ways * p->n;
  PetscReal *T, *re, *im, bound, shift;

  PetscFunctionBegin;
  PetscCall(PencilSetTime(p, t, FRAME_ARC));
  PetscCall(PencilBound(p, &bound));
  PetscCall(PetscMalloc3(n * n, &T, n, &re, n, &im));
  shift = bound;
  for (int k = 0; k < MOST_SHIFTS; k++) {
    PetscReal size, old = shift;
    PetscCall(RightmostBy(p, shift, bound, T, re, im, value));
    size = PetscAbsReal(value->value) + value->frequency;
    if (shift - value->value <= far_shift * size) break;
    shift = value->value + size; /* what is small against the shift was lost in it */
    if (!(shift < old)) break;
  }
  PetscCall(PetscFree3(T, re, im));
  PetscFunctionReturn(0);
}

/* The symmetric case: W = U^T R, U the eigenvectors of R (K - shift D)^-1 R^T, so W^T W = D. */
static PetscErrorCode LeftSymmetric(Pencil p, PetscReal shift, PetscReal W[]) {
  PetscBLASInt nb, lwork, liwork, info, *iwork;
  PetscInt n = p->n;
  PetscReal *work, *values, *D, *R;

  PetscFunctionBegin;
  PetscCall(SpectrumDense(p, shift, PETSC_TRUE, W));
  PetscCall(PetscBLASIntCast(n, &nb));
  PetscCall(PetscBLASIntCast(1 + 6 * n + 2 * n * n, &lwork));
  PetscCall(PetscBLASIntCast(3 + 5 * n, &liwork));
  PetscCall(
      PetscMalloc5(lwork, &work, liwork, &iwork, n, &values, n * WIDTH, &D, n * (HALF + 1), &R));
  PetscCallBLAS("LAPACKsyevd",
                LAPACKsyevd_("V", "U", &nb, W, &nb, values, work, &lwork, iwork, &liwork, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "dsyevd failed: %d", (int)info);
  PetscCall(PencilBand(p, FORM_DRAG, D));
  PetscCall(BandCholesky(n, HALF, D, R));
  for (PetscInt k = 0; k < n; k++) BandUpperMult(n, HALF, R, PETSC_TRUE, W + k * n);
  PetscCall(PetscFree5(work, iwork, values, D, R));
  PetscFunctionReturn(0);
}

/* paired[k]: rows k and k + 1 are the real and imaginary part of one vector */
static PetscErrorCode LeftGeneral(Pencil p, PetscReal shift, PetscReal W[], PetscBool paired[]) {
  PetscInt n = p->n;
  PetscReal *T, *re, *im;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(n * n, &T, n, &re, n, &im));
  PetscCall(SpectrumDense(p, shift, PETSC_FALSE, T));
  PetscCall(DenseEigenvalues(n, T, re, im, W));
  for (PetscInt k = 0; k < n; k++) paired[k] = (PetscBool)(im[k] > 0); /* LAPACK's order */
  PetscCall(PetscFree3(T, re, im));
  PetscFunctionReturn(0);
}

/* Scales each row, a pair as one, to length 1 in the norm that belongs to a c-by-c form:
   sqrt(row form^-1 row^*). */
static PetscErrorCode ScaleRows(Pencil p, PencilForm form, const PetscBool paired[],
                                PetscReal W[]) {
  PetscInt n = p->n;
  PetscReal *band, *R, *row;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(n * WIDTH, &band, n * (HALF + 1), &R, n, &row));
  PetscCall(PencilBand(p, form, band));
  PetscCall(BandCholesky(n, HALF, band, R));
  for (PetscInt k = 0; k < n; k++) {
    PetscInt last = paired[k] ? k + 1 : k;
    PetscReal size = 0;
    for (PetscInt m = k; m <= last; m++) {
      PetscCall(PetscArraycpy(row, W + m * n, n));
      BandUpperSolve(n, HALF, R, PETSC_TRUE, row);
      for (PetscInt i = 0; i < n; i++) size += row[i] * row[i];
    }
    for (PetscInt i = k * n; i < (last + 1) * n; i++) W[i] /= PetscSqrtReal(size);
    k = last;
  }
  PetscCall(PetscFree3(band, R, row));
  PetscFunctionReturn(0);
}

/*
  SpectrumLeftVectors - W, whose rows are the left eigenvectors of A(t) (their real and imaginary
  parts where they are complex), acting on the coefficients c. One rank, dense.

  unit_rows   rows of length 1 in the L2 norm; else in the dual friction norm, so that W^T W = D
              where A is self-adjoint
  W           row k at W + k n
*/
PetscErrorCode SpectrumLeftVectors(Pencil p, PetscReal t, PetscBool unit_rows, PetscReal W[]) {
  PetscBool *paired;
  PetscReal shift;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(p->n, &paired));
  PetscCall(PencilSetTime(p, t, FRAME_ARC));
  PetscCall(PencilBound(p, &shift));
  if (p->skew)
    PetscCall(LeftGeneral(p, shift, W, paired));
  else
    PetscCall(LeftSymmetric(p, shift, W));
  if (unit_rows || p->skew) PetscCall(ScaleRows(p, unit_rows ? FORM_MASS : FORM_DRAG, paired, W));
  PetscCall(PetscFree(paired));
  PetscFunctionReturn(0);
}
