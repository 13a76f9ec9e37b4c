#include "straight/transient.h"
#include <slepcsvd.h>

enum { STAGES = 3, MAX_STEPS = 20000, MOST_BENDS = 2000 };

/* How far from straight lines tables may be within a step, as a part of their size. */
static const PetscReal straight_on = 0.02;

/* Radau IIA of order 5: the times of its stages and the inverse of its matrix */
static const PetscReal root6 = 2.449489742783178;
static PetscReal StageTime(int i) {
  return i == 2 ? 1 : (4 + (2 * i - 1) * root6) / 10;
}

static void InverseMatrix(PetscReal a[STAGES][STAGES]) {
  const PetscReal r = root6;
  const PetscReal A[3][3] = {{(88 - 7 * r) / 360, (296 - 169 * r) / 1800, (-2 + 3 * r) / 225},
                             {(296 + 169 * r) / 1800, (88 + 7 * r) / 360, (-2 - 3 * r) / 225},
                             {(16 - r) / 36, (16 + r) / 36, 1. / 9}};
  PetscReal det = 0;
  for (int i = 0; i < 3; i++)
    det +=
        A[0][i] * (A[1][(i + 1) % 3] * A[2][(i + 2) % 3] - A[1][(i + 2) % 3] * A[2][(i + 1) % 3]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      a[j][i] = (A[(i + 1) % 3][(j + 1) % 3] * A[(i + 2) % 3][(j + 2) % 3] -
                 A[(i + 1) % 3][(j + 2) % 3] * A[(i + 2) % 3][(j + 1) % 3]) /
                det;
}

/* K on c from its forms on w: C^-T K C^-1 + X C^-1, seven diagonals again. */
static PetscErrorCode StiffnessOnC(Pencil p, PetscReal K[]) {
  PetscInt n = p->n;
  PetscReal *w, *x;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n * WIDTH, &w, n * WIDTH, &x));
  PetscCall(PencilBand(p, FORM_STIFF, w));
  PetscCall(PencilBand(p, FORM_SLIDE, x));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt b = 0; b < WIDTH; b++) {
      PetscInt j = i - HALF + b;
      PetscReal scale = j >= 0 && j < n ? 1 / p->delta[j] : 0;
      w[i * WIDTH + b] *= scale / p->delta[i];
      x[i * WIDTH + b] *= scale;
    }
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt b = 0; b < WIDTH; b++) {
      PetscInt j = i - HALF + b, at = i * WIDTH + b;
      K[at] = 0;
      if (j < 0 || j >= n) continue;
      K[at] = w[at] + x[at];
      if (b + 1 < WIDTH) K[at] -= w[at + 1] + x[at + 1]; /* (i, j + 1) */
      if (i + 1 < n) {
        K[at] += w[at + WIDTH];                /* (i + 1, j + 1) */
        if (b > 0) K[at] -= w[at + WIDTH - 1]; /* (i + 1, j) */
      }
    }
  PetscCall(PetscFree2(w, x));
  PetscFunctionReturn(0);
}

/*
  One step, D_i sum_j (a^-1)_ij (Y_j - y) = h K_i Y_i for the stages i, with Y_3 the new y: factors
  the matrix on the Y. No product with K is ever taken, so what has decayed keeps its digits.
*/
static PetscErrorCode FactorStep(Propagator *self, PetscReal t, PetscReal h, Band *A,
                                 PetscReal *drag) {
  PetscInt n = self->n;
  PetscReal a[STAGES][STAGES], *K;

  PetscFunctionBegin;
  InverseMatrix(a);
  PetscCall(PetscMalloc1(n * WIDTH, &K));
  PetscCall(BandCreate(STAGES * n, STAGES * HALF + STAGES - 1, STAGES * HALF + STAGES - 1, A));
  for (int i = 0; i < STAGES; i++) {
    PetscReal *D = drag + i * n * WIDTH;
    PetscCall(PencilSetTime(self->pencil, t + StageTime(i) * h, FRAME_LABEL));
    PetscCall(StiffnessOnC(self->pencil, K));
    PetscCall(PencilBand(self->pencil, FORM_DRAG, D));
    for (PetscInt r = 0; r < n; r++)
      for (PetscInt b = 0; b < WIDTH; b++) {
        PetscInt col = r - HALF + b;
        if (col < 0 || col >= n) continue;
        for (int j = 0; j < STAGES; j++)
          *BandAt(A, STAGES * r + i, STAGES * col + j) =
              a[i][j] * D[r * WIDTH + b] - (i == j) * h * K[r * WIDTH + b];
      }
  }
  PetscCall(BandFactor(A));
  PetscCall(PetscFree(K));
  PetscFunctionReturn(0);
}

/* y <- y + sum_i f_i D_i x_i (D symmetric), or x_i <- f_i D_i y; x interleaved by stage */
static void StageLoads(PetscInt n, const PetscReal *drag, PetscBool gather, PetscReal *y,
                       PetscReal *x) {
  PetscReal a[STAGES][STAGES];
  InverseMatrix(a);
  for (int i = 0; i < STAGES; i++) {
    PetscReal f = a[i][0] + a[i][1] + a[i][2];
    for (PetscInt r = 0; r < n; r++) {
      const PetscReal *D = drag + (i * n + r) * WIDTH;
      PetscReal sum = 0;
      for (PetscInt b = 0; b < WIDTH; b++) {
        PetscInt j = r - HALF + b;
        if (j >= 0 && j < n) sum += D[b] * (gather ? x[STAGES * j + i] : y[j]);
      }
      if (gather)
        y[r] += f * sum;
      else
        x[STAGES * r + i] = f * sum;
    }
  }
}

static PetscErrorCode ApplyStep(PetscInt n, const Band *A, const PetscReal *drag,
                                PetscBool transpose, PetscReal *c, PetscReal *work) {
  PetscFunctionBegin;
  if (!transpose) {
    StageLoads(n, drag, PETSC_FALSE, c, work);
    PetscCall(BandSolve(A, PETSC_FALSE, 1, work));
    for (PetscInt r = 0; r < n; r++) c[r] = work[STAGES * r + STAGES - 1];
  } else {
    PetscCall(PetscArrayzero(work, STAGES * n));
    for (PetscInt r = 0; r < n; r++) work[STAGES * r + STAGES - 1] = c[r];
    PetscCall(BandSolve(A, PETSC_TRUE, 1, work));
    for (PetscInt r = 0; r < n; r++) c[r] = 0; /* gcc 12 fears that memset's size is negative */
    StageLoads(n, drag, PETSC_TRUE, c, work);
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Room(Propagator *self) {
  PetscInt size = STAGES * self->n * WIDTH, room = PetscMax(64, 2 * self->room);
  Band *factor;
  PetscReal *drag;

  PetscFunctionBegin;
  if (self->steps + 2 <= self->room) PetscFunctionReturn(0);
  PetscCheck(room < MAX_STEPS, PETSC_COMM_SELF, PETSC_ERR_CONV_FAILED,
             "the propagator needs too many steps, shorten its window");
  PetscCall(PetscMalloc1(room, &factor));
  PetscCall(PetscMalloc1(room * size, &drag));
  PetscCall(PetscArraycpy(factor, self->factor, self->steps));
  PetscCall(PetscArraycpy(drag, self->drag, self->steps * size));
  PetscCall(PetscFree(self->factor));
  PetscCall(PetscFree(self->drag));
  self->factor = factor;
  self->drag = drag;
  self->room = room;
  PetscFunctionReturn(0);
}

/* One step of h against two of h/2 on the probe; the two are kept, error is what they differ by. */
static PetscErrorCode TryStep(Propagator *self, PetscReal t, PetscReal h, PetscReal *probe,
                              PetscReal *error) {
  PetscInt n = self->n, size = STAGES * n * WIDTH;
  PetscReal *whole, *drag, change = 0, norm = 0;
  Band A;

  PetscFunctionBegin;
  PetscCall(Room(self));
  PetscCall(PetscMalloc2(n, &whole, size, &drag));
  PetscCall(PetscArraycpy(whole, probe, n));
  PetscCall(FactorStep(self, t, h, &A, drag));
  PetscCall(ApplyStep(n, &A, drag, PETSC_FALSE, whole, self->work));
  PetscCall(BandDestroy(&A));
  for (int k = 0; k < 2; k++) {
    Band *half = self->factor + self->steps + k;
    PetscReal *its = self->drag + (self->steps + k) * size;
    PetscCall(FactorStep(self, t + k * h / 2, h / 2, half, its));
    PetscCall(ApplyStep(n, half, its, PETSC_FALSE, probe, self->work));
  }
  for (PetscInt i = 0; i < n; i++) {
    change += PetscSqr(probe[i] - whole[i]);
    norm += PetscSqr(probe[i]);
  }
  *error = PetscSqrtReal(change / norm) / 31;
  PetscCall(PetscFree2(whole, drag));
  PetscFunctionReturn(0);
}

/* The probe: a rod that sags, smoothed by two long steps (the slowest mode decays at about 10 /
   L^4) so that it meets the free tip's conditions to the order that a tight tolerance can see. */
static PetscErrorCode SmoothProbe(Propagator *self, PetscReal probe[]) {
  PetscReal L, *drag;
  Band A;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < self->n; i++) probe[i] = PetscSqr((PetscReal)(i + 1) / self->n);
  PetscCall(PetscMalloc1(STAGES * self->n * WIDTH, &drag));
  PetscCall(GrowthLength(self->pencil->growth, self->t1, &L, NULL));
  PetscCall(FactorStep(self, self->t1, 0.1 * PetscSqr(L * L), &A, drag));
  for (int k = 0; k < 2; k++)
    PetscCall(ApplyStep(self->n, &A, drag, PETSC_FALSE, probe, self->work));
  PetscCall(BandDestroy(&A));
  PetscCall(PetscFree(drag));
  PetscFunctionReturn(0);
}

/* Steps chosen so that the probe keeps its relative accuracy however small it gets. */
static PetscErrorCode ChooseSteps(Propagator *self, PetscReal tolerance) {
  PetscReal t = self->t1, h = (self->t2 - self->t1) / 1000, *probe, *old, error = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(self->n, &probe, self->n, &old));
  PetscCall(SmoothProbe(self, probe));
  while (t < self->t2) {
    const PetscReal free = h, end = PetscMin(self->t2, BendsNext(&self->bends, t));
    PetscBool last = (PetscBool)(t + 1.0001 * h >= end);
    PetscReal factor;
    if (last) h = end - t;
    PetscCall(PetscArraycpy(old, probe, self->n));
    PetscCall(TryStep(self, t, h, probe, &error));
    factor = 0.9 * PetscPowReal(tolerance / PetscMax(error, 1e-30), 1. / 6);
    factor = PetscMin(3, PetscMax(0.2, factor));
    if (error > tolerance) {
      for (int k = 0; k < 2; k++) PetscCall(BandDestroy(self->factor + self->steps + k));
      PetscCall(PetscArraycpy(probe, old, self->n));
    } else {
      self->steps += 2;
      t = last ? end : t + h;
      if (end < self->t2 && last && factor >= 1) h = PetscMax(h, free / factor);
    }
    h *= factor;
    PetscCheck(h > 1e-12 * self->t2, PETSC_COMM_SELF, PETSC_ERR_CONV_FAILED,
               "the propagator's steps shrink to nothing at t = %g", (double)t);
  }
  PetscCall(PetscFree2(probe, old));
  PetscFunctionReturn(0);
}

/*
  PropagatorCreate - factors all steps of D y_t = K y from t1 to t2. On one process.

  mesh        equidistant in z (pencil.h); outlives the propagator
  way         the direction of the deflection, WAY_X2 or WAY_X3
  tolerance   on the relative error of one step
  propagator  the caller destroys it with PropagatorDestroy()
*/
PetscErrorCode PropagatorCreate(Scene scene, const Mesh *mesh, StraightWay way, PetscReal t1,
                                PetscReal t2, PetscReal tolerance, Propagator *self) {
  PetscReal straight = straight_on;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  self->t1 = t1;
  self->t2 = t2;
  self->n = mesh->cells + 1;
  PetscCall(PencilCreate(PETSC_COMM_SELF, scene, mesh, t2, way, &self->pencil));
  PetscCall(PetscMalloc1(STAGES * self->n, &self->work));
  PetscCall(SceneFewBends(scene, MOST_BENDS, &straight, &self->bends));
  if (self->bends.n > MOST_BENDS) PetscCall(BendsDestroy(&self->bends));
  PetscCall(ChooseSteps(self, tolerance));
  PetscFunctionReturn(0);
}

PetscErrorCode PropagatorDestroy(Propagator *self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->steps; k++) PetscCall(BandDestroy(self->factor + k));
  PetscCall(PetscFree(self->factor));
  PetscCall(PetscFree(self->drag));
  PetscCall(PetscFree(self->work));
  PetscCall(BendsDestroy(&self->bends));
  PetscCall(PencilDestroy(&self->pencil));
  PetscFunctionReturn(0);
}

/* PropagatorApply - c <- Phi c or Phi^T c, c the n coefficients of a deflection. */
PetscErrorCode PropagatorApply(Propagator *self, PetscBool transpose, PetscReal c[]) {
  PetscFunctionBegin;
  for (PetscInt i = 0; i < self->steps; i++) {
    PetscInt k = transpose ? self->steps - 1 - i : i;
    PetscCall(ApplyStep(self->n, self->factor + k, self->drag + k * STAGES * self->n * WIDTH,
                        transpose, c, self->work));
  }
  PetscFunctionReturn(0);
}

/* R2 Phi R1^-1, R^T R the norm at either end */
typedef struct {
  Propagator *propagator;
  PetscReal *R1, *R2;
} Amplifier;

static PetscErrorCode AmplifyEither(Mat A, PetscBool transpose, Vec x, Vec y) {
  Amplifier *self;
  PetscReal *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &self));
  PetscCall(VecCopy(x, y));
  PetscCall(VecGetArray(y, &c));
  if (transpose)
    BandUpperMult(self->propagator->n, HALF, self->R2, PETSC_TRUE, c);
  else
    BandUpperSolve(self->propagator->n, HALF, self->R1, PETSC_FALSE, c);
  PetscCall(PropagatorApply(self->propagator, transpose, c));
  if (transpose)
    BandUpperSolve(self->propagator->n, HALF, self->R1, PETSC_TRUE, c);
  else
    BandUpperMult(self->propagator->n, HALF, self->R2, PETSC_FALSE, c);
  PetscCall(VecRestoreArray(y, &c));
  PetscFunctionReturn(0);
}

static PetscErrorCode Amplify(Mat A, Vec x, Vec y) {
  PetscFunctionBegin;
  PetscCall(AmplifyEither(A, PETSC_FALSE, x, y));
  PetscFunctionReturn(0);
}

static PetscErrorCode AmplifyTranspose(Mat A, Vec x, Vec y) {
  PetscFunctionBegin;
  PetscCall(AmplifyEither(A, PETSC_TRUE, x, y));
  PetscFunctionReturn(0);
}

/* The norm's Cholesky factor: int y^2 ds, or int g phi0 y^2 ds / L (not over L for laws that slide:
   see spectrum.c). */
static PetscErrorCode NormFactor(Pencil p, TransientNorm norm, PetscReal t, PetscReal R[]) {
  PetscReal *band, L = 1;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n * WIDTH, &band));
  PetscCall(PencilSetTime(p, t, FRAME_LABEL));
  PetscCall(PencilBand(p, norm == TRANSIENT_L2 ? FORM_MASS : FORM_DRAG, band));
  if (norm == TRANSIENT_FRICTION && !p->growth->slides)
    PetscCall(GrowthLength(p->growth, t, &L, NULL));
  for (PetscInt i = 0; i < p->n * WIDTH; i++) band[i] /= L;
  PetscCall(BandCholesky(p->n, HALF, band, R));
  PetscCall(PetscFree(band));
  PetscFunctionReturn(0);
}

/* Shapes at the nodes from coefficients c; w = C^-1 c. */
static PetscErrorCode ShapeOf(Pencil p, const PetscReal c[], PetscReal t, PetscReal y[],
                              PetscReal theta[]) {
  PetscReal *w;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n, &w));
  for (PetscInt i = 0; i < p->n; i++) w[i] = (c[i] - (i ? c[i - 1] : 0)) / p->delta[i];
  PetscCall(PencilShape(p, c, w, t, y, theta));
  PetscCall(PetscFree(w));
  PetscFunctionReturn(0);
}

static PetscErrorCode LargestSingularValue(Mat A, Vec u, Vec v, PetscReal *sigma) {
  PetscInt found;
  SVD svd;

  PetscFunctionBegin;
  PetscCall(SVDCreate(PETSC_COMM_SELF, &svd));
  PetscCall(SVDSetOptionsPrefix(svd, "transient_"));
  PetscCall(SVDSetOperators(svd, A, NULL));
  PetscCall(SVDSetType(svd, SVDTRLANCZOS));
  PetscCall(SVDSetWhichSingularTriplets(svd, SVD_LARGEST));
  PetscCall(SVDSetTolerances(svd, 1e-9, 200));
  PetscCall(SVDSetDimensions(svd, 1, 12, PETSC_DEFAULT));
  PetscCall(SVDSolve(svd));
  PetscCall(SVDGetConverged(svd, &found));
  PetscCheck(found > 0, PETSC_COMM_SELF, PETSC_ERR_CONV_FAILED, "no singular value converged");
  PetscCall(SVDGetSingularTriplet(svd, 0, sigma, u, v));
  PetscCall(SVDDestroy(&svd));
  PetscFunctionReturn(0);
}

/*
  TransientOptimal - the largest singular value of the propagator in a norm, and its shapes.

  optimal   amplification |y(t2)| / |y(t1)| of the best y(t1); arrays freed by OptimalDestroy()
*/
PetscErrorCode TransientOptimal(Propagator *self, TransientNorm norm, Optimal *best) {
  Pencil p = self->pencil;
  PetscInt n = self->n;
  Amplifier ends = {self, NULL, NULL};
  PetscReal *c, sign;
  Mat A;
  Vec u, v;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n * (HALF + 1), &ends.R1, n * (HALF + 1), &ends.R2));
  PetscCall(NormFactor(p, norm, self->t1, ends.R1));
  PetscCall(NormFactor(p, norm, self->t2, ends.R2));
  PetscCall(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, &ends, &A));
  PetscCall(MatShellSetOperation(A, MATOP_MULT, (void (*)(void))Amplify));
  PetscCall(MatShellSetOperation(A, MATOP_MULT_TRANSPOSE, (void (*)(void))AmplifyTranspose));
  PetscCall(MatCreateVecs(A, &v, &u));
  PetscCall(LargestSingularValue(A, u, v, &best->amplification));
  best->n = n;
  PetscCall(
      PetscMalloc5(n, &best->s, n, &best->y1, n, &best->theta1, n, &best->y2, n, &best->theta2));
  PetscCall(PetscArraycpy(best->s, p->node, n));
  PetscCall(VecGetArray(v, &c));
  BandUpperSolve(n, HALF, ends.R1, PETSC_FALSE, c);
  PetscCall(ShapeOf(p, c, self->t1, best->y1, best->theta1));
  PetscCall(PropagatorApply(self, PETSC_FALSE, c));
  PetscCall(ShapeOf(p, c, self->t2, best->y2, best->theta2));
  PetscCall(VecRestoreArray(v, &c));
  sign = best->y1[n - 1] < 0 ? -1 : 1;
  for (PetscInt i = 0; i < n; i++) {
    best->y1[i] *= sign, best->theta1[i] *= sign;
    best->y2[i] *= sign, best->theta2[i] *= sign;
  }
  PetscCall(VecDestroy(&u));
  PetscCall(VecDestroy(&v));
  PetscCall(MatDestroy(&A));
  PetscCall(PetscFree2(ends.R1, ends.R2));
  PetscFunctionReturn(0);
}

PetscErrorCode OptimalDestroy(Optimal *best) {
  PetscFunctionBegin;
  PetscCall(PetscFree5(best->s, best->y1, best->theta1, best->y2, best->theta2));
  PetscFunctionReturn(0);
}
