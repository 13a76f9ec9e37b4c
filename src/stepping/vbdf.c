#include "stepping/vbdf.h"
#include "base/lagrange.h"
#include "base/compat.h"
#include <petsc/private/tsimpl.h> /* a TS type cannot do without */

/* point[0] is the new solution, at time[0]; point[1], point[2], ... those of the steps before. */
/* Sizes: of the fields of each factor, and of those of all together. */
enum { ALL = VBDF_FACTORS, VBDF_SIZES };

typedef struct {
  PetscInt order;       /* k, of the present step */
  PetscInt taken_order; /* of the step taken last */
  PetscInt most;        /* highest order allowed */
  PetscInt n;           /* past points */
  PetscInt since;       /* steps since the order changed */
  PetscBool given;      /* the history was handed over: do not restart */
  PetscBool jumped;     /* the present step was accepted as a jump */
  PetscInt jumps;
  PetscReal layer;    /* a step this short is accepted whatever its error */
  PetscReal rejected; /* error of the try before, if one of this step was rejected at a third of the
                         size or more */
  PetscReal usual;    /* the longest of the latest steps, slowly forgotten */
  PetscBool fixed;    /* -ts_adapt_type none: steps as told, order as high as the history allows */
  PetscReal time[VBDF_POINTS];
  Vec point[VBDF_POINTS];
  PetscReal shift, rho[VBDF_FACTORS]; /* U_t = shift U + affine, and rho U more for the fields
                                         factored, of each of their factors */
  Vec affine, rate, work;
  PetscInt fields;                      /* of a node, if any are factored */
  int factored[VBDF_FIELDS];            /* bit k: by factor k; of several, by their product */
  PetscBool plain, plain_next;          /* nothing is factored in the present step, in the next */
  PetscInt degree, taken[VBDF_FACTORS]; /* of log A at most; points that it goes through */
  PetscReal size[VBDF_POINTS][VBDF_SIZES];    /* log of the size of the fields of each factor in
                                                 point[i], and of those of all */
  int column[VBDF_FACTORS];                   /* of size, that the factor is taken from */
  PetscReal ratio[VBDF_FACTORS][VBDF_POINTS]; /* A(time[0]) / A(time[i]) */
  VBDFGuess guess;
  void *guess_ctx;
  VBDFSnap snap;
  VBDFOtherWay other_way;
  VBDFCheck check;
  VBDFCross cross;
  VBDFMeasure measure;
  PetscObjectState tolerance_state; /* of the tolerances that were looked at */
  PetscBool minute;                 /* one of them is */
  PetscBool tried, snapped;         /* to follow a snap in the present step; it begins behind one */
} VBDF;

/* A snap may be too far for Newton's method: then it fails however short the step is, and after so
   many tries it is followed. */
enum { failures_of_snap = 4 };
/* Or it shows on the way: towards the turning point from which a rod snaps, steps shrink without
   end. One that is this part of the usual one asks whether the rod snaps; and, for it may have been
   too early, each one that is this part of the one that asked before. */
static const PetscReal shrunk = 1e-4, again = 0.1, forgets = 0.95;
/* Aim at this part of the tolerance: low, so that few steps are rejected. (0.5 at half the
   tolerance gives the same errors in as many steps, but has 36 rejected where this has 9.) */
static const PetscReal safety = 0.22;
/* Dry friction cannot hold a rod that is bent too sharply, and without inertia it snaps at once: a
   jump. It shows in an error that a much shorter step (a third at most) does not lessen to this
   part. VBDFSetSnap() tells how to follow it; else, or if it shows once more, backward Euler
   carries the rod over. The history starts anew behind it. Likewise for a step below
   jump_step of the final time: an initial layer as fast as that is left unresolved, and crossed in
   steps that double, up to longest_jump of it. */
static const PetscReal jump_persists = 0.7, jump_step = 1e-13, longest_jump = 1e-6;
/* (In the layer, one whose error is up to so many times the tolerance is tried again shorter: it is
   all but seen, and to jump on would make the next one blind, and so on without end.) */
static const PetscReal nearly_seen = 30;
/* A rod that barely sticks may slip by a little, and stick again in a step that is short enough: in
   a step below this part of the final time, such an error is a jump, too. (That of a kink would
   fall like the step, to a third at most.) */
static const PetscReal slip_persists = 0.25, slip_step = 1e-8;
/* ... and below this part of the present time there is nothing but round-off; early on, of this
   part of the final time. */
static const PetscReal smallest = 1e-13, early = 1e-3;
static const PetscReal shrink_most = 0.2, grow_most = 2;
/* A step that cannot be, or that crosses a mode that grows, is cut to this. */
static const PetscReal cut = 0.3;
/* The factor is taken or left when that gives so much of the error. */
static const PetscReal better = 0.5;
/* It may change by so many e-folds in a step: the tolerance is relative to what the fields are at
   its beginning, and must still mean something at its end. (Rods of usual length stay below 2.) */
static const PetscReal most_folds = 4;
/* A field smaller than this is round-off. */
static const PetscReal vanished = 1e-280;
/* Fields across in two directions are of like size up to this ratio. */
static const PetscReal alike = 1e3;

static PetscErrorCode Self(TS ts, VBDF **self) {
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSVBDF, &same));
  *self = same ? (VBDF *)ts->data : NULL;
  PetscFunctionReturn(0);
}

/*
  The factor. With y = A(t) z for the fields factored, the formula and the polynomials are those of
  z; whatever A is, as long as it is smooth, their order stays. So at t
      y = sum of L_j A(t)/A(t_j) y_j,   y' = sum of L'_j A(t)/A(t_j) y_j + rho y,   rho = A'/A:
  the points' weights times ratios, and rho beside the shift. A step takes for log A the polynomial
  through the log sizes of the fields at the latest points: only what the size does not do as
  extrapolated, and what the shape does, is left for the steps to follow.

  Its degree is at most the order k: then the formula takes it for what it is, and the log of the
  size follows the formula of order k itself, with its stability. (A parabola at order 1 would make
  of h d(log size)/dt a difference with the roots 1, -1 and 1/2: that rings.)
*/
static PetscReal FactorLog(const VBDF *self, int k, PetscReal t) {
  PetscReal L[VBDF_POINTS], sum = 0;

  LagrangeValues(self->taken[k], self->time + 1, t, L);
  for (PetscInt j = 0; j < self->taken[k]; j++) sum += L[j] * self->size[1 + j][self->column[k]];
  return sum;
}

static PetscReal FactorRate(const VBDF *self, int k, PetscReal t) {
  PetscReal D[VBDF_POINTS], sum = 0;

  LagrangeSlopes(self->taken[k], self->time + 1, t, D);
  for (PetscInt j = 0; j < self->taken[k]; j++) sum += D[j] * self->size[1 + j][self->column[k]];
  return sum;
}

/* A(t)/A(t_j) of m points from first on */
static void FactorRatios(const VBDF *self, PetscInt first, PetscInt m, PetscReal t,
                         PetscReal ratio[VBDF_FACTORS][VBDF_POINTS]) {
  for (int k = 0; k < VBDF_FACTORS; k++)
    for (PetscInt j = 0; j < m; j++)
      ratio[k][j] =
          self->taken[k] < 2
              ? 1
              : PetscExpReal(FactorLog(self, k, t) - FactorLog(self, k, self->time[first + j]));
}

/* Is any factor taken in the present step? */
static PetscBool Factored(const VBDF *self) {
  PetscBool any = PETSC_FALSE;
  for (int k = 0; k < VBDF_FACTORS; k++) any = (PetscBool)(any || self->taken[k]);
  return any;
}

/* Are the fields of all factors of like size? Then they have one, that of all of them, whatever the
   axes are: a rod that is bent is as much so when it is turned. */
static PetscBool Common(const VBDF *self) {
  const PetscReal *size = self->size[1];

  return (PetscBool)(size[0] > PETSC_MIN_REAL && size[1] > PETSC_MIN_REAL &&
                     PetscAbsReal(size[0] - size[1]) < PetscLogReal(alike));
}

/* Takes the factor for a step of order q to time[0]. */
static void TakeFactor(VBDF *self, PetscInt q) {
  PetscInt most = self->plain ? 0 : PetscMin(self->n, PetscMin(self->degree, q) + 1);

  for (int k = 0; k < VBDF_FACTORS; k++) {
    self->taken[k] = 0;
    self->column[k] = Common(self) ? ALL : k;
    if (self->fields)
      while (self->taken[k] < most &&
             self->size[1 + self->taken[k]][self->column[k]] > PETSC_MIN_REAL)
        self->taken[k]++;
    if (self->taken[k] < 2) self->taken[k] = 0;
    self->rho[k] = FactorRate(self, k, self->time[0]);
  }
  FactorRatios(self, 0, self->n + 1, self->time[0], self->ratio);
}

/* The log of the Euclidean norm of the first of the fields of one factor; PETSC_MIN_REAL if it has
   vanished, or there is none. (Scaled: its square may lie below the smallest number.) */
static PetscErrorCode SizeOfFactor(const VBDF *self, Vec U, int k, PetscReal *size) {
  MPI_Comm comm = PetscObjectComm((PetscObject)U);
  const PetscScalar *u;
  PetscReal most = 0, sum = 0;
  PetscInt n, f = 0;

  PetscFunctionBegin;
  *size = PETSC_MIN_REAL;
  while (f < self->fields && self->factored[f] != 1 << k) f++;
  if (f == self->fields) PetscFunctionReturn(0);
  PetscCall(VecGetLocalSize(U, &n));
  PetscCall(VecGetArrayRead(U, &u));
  for (PetscInt i = f; i < n; i += self->fields) most = PetscMax(most, PetscAbsScalar(u[i]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPI_MAX, comm));
  for (PetscInt i = f; i < n && most > vanished; i += self->fields)
    sum += PetscSqr(PetscRealPart(u[i]) / most);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPI_SUM, comm));
  PetscCall(VecRestoreArrayRead(U, &u));
  if (sum > 0) *size = PetscLogReal(most) + PetscLogReal(sum) / 2;
  PetscFunctionReturn(0);
}

/* The same of all factors, and of all together. */
static PetscErrorCode FactorSize(const VBDF *self, Vec U, PetscReal size[VBDF_SIZES]) {
  PetscReal most = PETSC_MIN_REAL, sum = 0;

  PetscFunctionBegin;
  for (int k = 0; k < VBDF_FACTORS; k++) {
    PetscCall(SizeOfFactor(self, U, k, &size[k]));
    most = PetscMax(most, size[k]);
  }
  size[ALL] = most;
  if (most == PETSC_MIN_REAL) PetscFunctionReturn(0);
  for (int k = 0; k < VBDF_FACTORS; k++)
    if (size[k] > PETSC_MIN_REAL) sum += PetscExpReal(2 * (size[k] - most));
  size[ALL] = most + PetscLogReal(sum) / 2;
  PetscFunctionReturn(0);
}

/* x = sum of m points y_k times c_k, a number for each field of a node. */
static inline void SumPoints(PetscInt n, PetscInt fields, PetscInt m,
                             const PetscReal c[][VBDF_FIELDS], const PetscScalar *const y[],
                             PetscScalar *x) {
  for (PetscInt i = 0; i < n; i += fields)
    for (PetscInt f = 0; f < fields; f++) {
      PetscScalar sum = 0;
      for (PetscInt k = 0; k < m; k++) sum += c[k][f] * y[k][i + f];
      x[i + f] = sum;
    }
}

/* What m points are multiplied by, c, a number for each field: along; for those that are factored
   (along + their rho times beside) times the ratios of their factors. beside NULL: 0. */
static void Weights(const VBDF *self, PetscInt fields, PetscInt m, const PetscReal along[],
                    const PetscReal beside[], const PetscReal rho[],
                    PetscReal ratio[VBDF_FACTORS][VBDF_POINTS], PetscReal c[][VBDF_FIELDS]) {
  for (PetscInt k = 0; k < m; k++)
    for (PetscInt f = 0; f < fields; f++) {
      c[k][f] = along[k];
      for (int a = 0; a < VBDF_FACTORS && beside; a++)
        if (self->factored[f] & 1 << a) c[k][f] += rho[a] * beside[k];
      for (int a = 0; a < VBDF_FACTORS; a++)
        if (self->factored[f] & 1 << a) c[k][f] *= ratio[a][k];
    }
}

/* X = sum of m points from first on, times their weights. */
static PetscErrorCode Combine(VBDF *self, PetscInt first, PetscInt m, const PetscReal along[],
                              const PetscReal beside[], const PetscReal rho[],
                              PetscReal ratio[VBDF_FACTORS][VBDF_POINTS], Vec X) {
  PetscReal c[VBDF_POINTS][VBDF_FIELDS];
  const PetscScalar *y[VBDF_POINTS];
  PetscScalar *x;
  PetscInt n;

  PetscFunctionBegin;
  if (!Factored(self)) {
    PetscCall(VecZeroEntries(X));
    PetscCall(VecMAXPY(X, m, along, self->point + first));
    PetscFunctionReturn(0);
  }
  Weights(self, self->fields, m, along, beside, rho, ratio, c);
  for (PetscInt k = 0; k < m; k++) PetscCall(VecGetArrayRead(self->point[first + k], &y[k]));
  PetscCall(VecGetLocalSize(X, &n));
  PetscCall(VecGetArrayWrite(X, &x));
  if (self->fields == 6)
    SumPoints(n, 6, m, c, y, x); /* (the compiler unrolls it) */
  else if (self->fields == 13)
    SumPoints(n, 13, m, c, y, x);
  else
    SumPoints(n, self->fields, m, c, y, x);
  PetscCall(VecRestoreArrayWrite(X, &x));
  for (PetscInt k = 0; k < m; k++) PetscCall(VecRestoreArrayRead(self->point[first + k], &y[k]));
  PetscFunctionReturn(0);
}

/* rate = U_t = shift U + affine, and rho U more */
static PetscErrorCode ComputeRate(VBDF *self, Vec U) {
  const PetscScalar *u, *a;
  PetscScalar *r;
  PetscReal shift[VBDF_FIELDS];
  PetscInt n;

  PetscFunctionBegin;
  if (!Factored(self)) {
    PetscCall(VecWAXPY(self->rate, self->shift, U, self->affine));
    PetscFunctionReturn(0);
  }
  PetscCall(VecGetLocalSize(U, &n));
  PetscCall(VecGetArrayRead(U, &u));
  PetscCall(VecGetArrayRead(self->affine, &a));
  PetscCall(VecGetArrayWrite(self->rate, &r));
  for (PetscInt f = 0; f < self->fields; f++) {
    shift[f] = self->shift;
    for (int k = 0; k < VBDF_FACTORS; k++)
      if (self->factored[f] & 1 << k) shift[f] += self->rho[k];
  }
  for (PetscInt i = 0; i < n; i += self->fields)
    for (PetscInt f = 0; f < self->fields; f++) r[i + f] = shift[f] * u[i + f] + a[i + f];
  PetscCall(VecRestoreArrayWrite(self->rate, &r));
  PetscCall(VecRestoreArrayRead(self->affine, &a));
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscFunctionReturn(0);
}

/* The ratios of past points 1 .. m. */
static void PastRatios(const VBDF *self, PetscInt m, PetscReal ratio[VBDF_FACTORS][VBDF_POINTS]) {
  for (int a = 0; a < VBDF_FACTORS; a++)
    for (PetscInt k = 0; k < m; k++) ratio[a][k] = self->ratio[a][1 + k];
}

/* X = the polynomial through past points 1 .. m, at time[0]. */
static PetscErrorCode Extrapolate(VBDF *self, PetscInt m, Vec X) {
  PetscReal L[VBDF_POINTS], ratio[VBDF_FACTORS][VBDF_POINTS];

  PetscFunctionBegin;
  LagrangeValues(m, self->time + 1, self->time[0], L);
  PastRatios(self, m, ratio);
  PetscCall(Combine(self, 1, m, L, NULL, NULL, ratio, X));
  PetscFunctionReturn(0);
}

static PetscErrorCode Predict(TS ts, VBDF *self, Vec X) {
  PetscFunctionBegin;
  if (self->n > 1)
    PetscCall(Extrapolate(self, PetscMin(self->order + 1, self->n), X));
  else if (self->guess)
    PetscCall(self->guess(ts, self->time[1], self->time[0], self->point[1], X, self->guess_ctx));
  else
    PetscCall(VecCopy(self->point[1], X));
  PetscFunctionReturn(0);
}

static PetscErrorCode SolveStage(TS ts, VBDF *self) {
  PetscReal D[VBDF_POINTS], ratio[VBDF_FACTORS][VBDF_POINTS];
  PetscInt its, linear;

  PetscFunctionBegin;
  LagrangeSlopes(self->order + 1, self->time, self->time[0], D);
  self->shift = D[0];
  PastRatios(self, self->order, ratio);
  PetscCall(Combine(self, 1, self->order, D + 1, NULL, NULL, ratio, self->affine));
  PetscCall(TSPreStage(ts, self->time[0]));
  PetscCall(SNESSolve(ts->snes, NULL, self->point[0]));
  PetscCall(SNESGetIterationNumber(ts->snes, &its));
  PetscCall(SNESGetLinearSolveIterations(ts->snes, &linear));
  ts->snes_its += its;
  ts->ksp_its += linear;
  PetscFunctionReturn(0);
}

/* An error so many times its tolerance is that: its square may be no number. Nor may the error be:
   that of a field that was 1e-290 and is driven now, or of a factor extrapolated from there. */
static const PetscReal beyond = 1e100;

/* Where no tolerance is as small as this, no error is beyond: fields are not that large. */
static const PetscReal minute = 1e-85;

/* Is any tolerance minute? It is looked for when they have changed. Collective. */
static PetscErrorCode MayBeBeyond(TS ts, VBDF *self, PetscBool *may) {
  PetscObjectState state;
  const PetscScalar *tolerance;
  int small = 0;
  PetscInt n;

  PetscFunctionBegin;
  *may = PETSC_FALSE;
  if (!ts->vatol) PetscFunctionReturn(0);
  PetscCall(PetscObjectStateGet((PetscObject)ts->vatol, &state));
  if (state != self->tolerance_state) {
    PetscCall(VecGetLocalSize(ts->vatol, &n));
    PetscCall(VecGetArrayRead(ts->vatol, &tolerance));
    for (PetscInt i = 0; i < n && !small; i++) small = PetscAbsReal(tolerance[i]) < minute;
    PetscCall(VecRestoreArrayRead(ts->vatol, &tolerance));
    PetscCallMPI(
        MPI_Allreduce(MPI_IN_PLACE, &small, 1, MPI_INT, MPI_MAX, PetscObjectComm((PetscObject)ts)));
    self->minute = (PetscBool)small;
    self->tolerance_state = state;
  }
  *may = self->minute;
  PetscFunctionReturn(0);
}

/* Is a state so far from another one? Collective. */
static PetscErrorCode IsBeyond(TS ts, VBDF *self, Vec U, Vec X, PetscBool *is) {
  const PetscScalar *u, *x, *tolerance;
  PetscBool may;
  int far = 0;
  PetscInt n;

  PetscFunctionBegin;
  *is = PETSC_FALSE;
  PetscCall(MayBeBeyond(ts, self, &may));
  if (!may) PetscFunctionReturn(0);
  PetscCall(VecGetLocalSize(U, &n));
  PetscCall(VecGetArrayRead(U, &u));
  PetscCall(VecGetArrayRead(X, &x));
  PetscCall(VecGetArrayRead(ts->vatol, &tolerance));
  for (PetscInt i = 0; i < n; i++)
    if (!(PetscAbsReal(x[i] - u[i]) <= beyond * PetscAbsReal(tolerance[i]))) far = 1;
  PetscCall(VecRestoreArrayRead(ts->vatol, &tolerance));
  PetscCall(VecRestoreArrayRead(X, &x));
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, &far, 1, MPI_INT, MPI_MAX, PetscObjectComm((PetscObject)ts)));
  *is = (PetscBool)far;
  PetscFunctionReturn(0);
}

/* The weighted norm of the difference of a state from work, which is lost. */
static PetscErrorCode Norm(TS ts, VBDF *self, Vec U, PetscReal *norm) {
  PetscReal absolute, relative;
  PetscBool far;

  PetscFunctionBegin;
  *norm = beyond;
  if (self->measure) {
    PetscCall(VecAXPY(self->work, -1, U));
    PetscCall(self->measure(ts, self->work));
    PetscCall(VecAXPY(self->work, 1, U));
  }
  PetscCall(IsBeyond(ts, self, U, self->work, &far));
  if (far) PetscFunctionReturn(0);
  PetscCall(
      TSErrorWeightedNorm(ts, U, self->work, ts->adapt->wnormtype, norm, &absolute, &relative));
  PetscFunctionReturn(0);
}

/*
  LocalError - the weighted error that a step of order q would have made, over the tolerance.

  With P the polynomial through the q + 1 past points, U - P = prod_{j=1}^{q+1} (t - t_j) U[t, ..],
  and the formula of order q errs by 1/shift_q prod_{j=1}^{q} (t - t_j) of the same divided
  difference: err = (U - P) / (shift_q (t - t_{q+1})), shift_q = sum_{j=1}^{q} 1/(t - t_j).
*/
static PetscErrorCode LocalError(TS ts, VBDF *self, PetscInt q, PetscReal *error) {
  PetscReal shift = 0, factor;

  PetscFunctionBegin;
  for (PetscInt j = 1; j <= q; j++) shift += 1 / (self->time[0] - self->time[j]);
  factor = 1 / (shift * (self->time[0] - self->time[q + 1]));
  TakeFactor(self, q);
  PetscCall(Extrapolate(self, q + 1, self->work));
  TakeFactor(self, self->order);
  PetscCall(VecAXPBY(self->work, 1 - factor, factor, self->point[0])); /* U - err */
  PetscCall(Norm(ts, self, self->point[0], error));
  PetscFunctionReturn(0);
}

/* The first step has no second point to tell its error from. A decaying mode that changes by d in
   it errs by d^2/2; U is compared with the guess, growth alone. (On the safe side: against rtol,
   while change is measured against the tolerance, a part of it.) Behind a snap friction is at its
   limit all along the rod, and modes of all rates are let go at once: those much faster than the
   step err by all that they change. */
static PetscErrorCode FirstError(TS ts, VBDF *self, PetscReal *error) {
  PetscReal change;

  PetscFunctionBegin;
  *error = 0;
  if (!self->guess) PetscFunctionReturn(0);
  PetscCall(
      self->guess(ts, self->time[1], self->time[0], self->point[1], self->work, self->guess_ctx));
  PetscCall(Norm(ts, self, self->point[0], &change));
  *error = self->snapped ? change : change * change * ts->rtol / 2;
  PetscFunctionReturn(0);
}

/* The factor by which the step may change for an error e of order q, as a part of the tolerance. */
static PetscReal StepFactor(PetscReal e, PetscInt q) {
  return PetscPowReal(safety / PetscMax(e, 1e-14), 1.0 / (q + 1));
}

/* Would the step of order q, whose error is e, have had a smaller one without the factor, or with
   it? Then so the next. A rod that follows its natural curvature, x2 like a power of its length, is
   better off without. */
static PetscErrorCode WithOrWithout(TS ts, VBDF *self, PetscInt q, PetscReal e) {
  PetscReal other;

  PetscFunctionBegin;
  if (!self->fields || !self->degree || self->n <= q || q < 2) PetscFunctionReturn(0);
  self->plain = (PetscBool)!self->plain;
  PetscCall(LocalError(ts, self, q, &other));
  self->plain = (PetscBool)!self->plain;
  TakeFactor(self, self->order);
  if (other < better * e) self->plain_next = (PetscBool)!self->plain;
  PetscFunctionReturn(0);
}

/*
  Choose - accepts or rejects the step just solved; sets the next order and the factor for the step.
  The order changes to the one that allows the longest step, upwards only after order + 1 steps of
  one order (before, the estimates feel the change), except while the history is still building up.
*/
static PetscErrorCode Choose(TS ts, VBDF *self, PetscBool *accept, PetscReal *factor) {
  PetscInt k = self->order, best = k;
  PetscReal e, persists, lower = 0, higher = 0;

  PetscFunctionBegin;
  if (self->n > k)
    PetscCall(LocalError(ts, self, k, &e));
  else
    PetscCall(FirstError(ts, self, &e));
  *accept = (PetscBool)(e <= 1);
  persists = ts->time_step < slip_step * ts->max_time ? slip_persists : jump_persists;
  self->jumped = (PetscBool)(!*accept && k == 1 &&
                             (e > persists * self->rejected ||
                              (ts->time_step < self->layer && (self->n == 1 || e > nearly_seen))));
  self->rejected = *accept ? PETSC_MAX_REAL : e;
  if (self->jumped) *accept = PETSC_TRUE;
  *factor = StepFactor(e, k);
  if (k > 1) {
    PetscCall(LocalError(ts, self, k - 1, &lower));
    if (StepFactor(lower, k - 1) > *factor) {
      best = k - 1;
      *factor = StepFactor(lower, k - 1);
    }
  }
  if (*accept && k < self->most && self->n >= k + 2 &&
      (self->since > k || self->n < self->most + 2)) {
    PetscCall(LocalError(ts, self, k + 1, &higher));
    if (StepFactor(higher, k + 1) > *factor) {
      best = k + 1;
      *factor = StepFactor(higher, k + 1);
    }
  }
  PetscCall(WithOrWithout(ts, self, k, e));
  if (best != k) self->since = 0;
  self->order = best;
  *factor = PetscMax(shrink_most, PetscMin(*factor, *accept ? grow_most : 0.9));
  PetscCall(PetscInfo(
      ts, "t %g dt %g order %d error %g (lower %g, higher %g) %s, next order %d, step times %g\n",
      (double)self->time[0], (double)ts->time_step, (int)k, (double)e, (double)lower,
      (double)higher, *accept ? "accepted" : "rejected", (int)best, (double)*factor));
  PetscFunctionReturn(0);
}

/* Moves the accepted solution into the history. */
static PetscErrorCode Push(TS ts, VBDF *self) {
  Vec last = self->point[VBDF_POINTS - 1];

  PetscFunctionBegin;
  for (PetscInt i = VBDF_POINTS - 1; i > 1; i--) {
    self->point[i] = self->point[i - 1];
    self->time[i] = self->time[i - 1];
    PetscCall(PetscArraycpy(self->size[i], self->size[i - 1], VBDF_SIZES));
  }
  self->point[1] = last;
  self->time[1] = ts->ptime;
  PetscCall(VecCopy(ts->vec_sol, last));
  PetscCall(FactorSize(self, last, self->size[1]));
  self->n = PetscMin(self->n + 1, VBDF_POINTS - 1);
  PetscFunctionReturn(0);
}

/* Keeps the step within the limits and lets the last ones end at the final time. */
static PetscErrorCode LimitStep(TS ts, VBDF *self) {
  PetscReal least, most, left = ts->max_time - ts->ptime;

  PetscFunctionBegin;
  PetscCall(TSAdaptGetStepLimits(ts->adapt, &least, &most));
  ts->time_step = PetscMin(ts->time_step, most);
  if (ts->exact_final_time != TS_EXACTFINALTIME_MATCHSTEP) PetscFunctionReturn(0);
  if (ts->time_step > left)
    ts->time_step = left;
  else if (!self->fixed && ts->time_step > left / 2)
    ts->time_step = left / 2;
  PetscFunctionReturn(0);
}

/* Begins a try: the step's factor, and the step itself if that would change too much in it. */
static void BeginTry(TS ts, VBDF *self) {
  PetscReal folds = 0;

  self->time[0] = ts->ptime + ts->time_step;
  self->plain = self->plain_next;
  TakeFactor(self, self->order);
  if (!Factored(self) || self->fixed) return;
  for (int k = 0; k < VBDF_FACTORS; k++)
    if (self->taken[k])
      folds = PetscMax(
          folds, PetscAbsReal(FactorLog(self, k, self->time[0]) - self->size[1][self->column[k]]));
  if (folds <= most_folds) return;
  ts->time_step *= most_folds / folds;
  self->time[0] = ts->ptime + ts->time_step;
  TakeFactor(self, self->order);
}

/* After a rejection: a shorter step; after several, a fresh start from the last point alone,
   because the history may lie on the other side of a kink. */
static PetscErrorCode Retry(TS ts, VBDF *self, PetscInt attempt, PetscReal factor) {
  PetscFunctionBegin;
  ts->reject++;
  ts->time_step *= factor;
  self->since = 0;
  if (attempt >= 3) {
    self->order = 1;
    self->n = 1;
  }
  if (ts->max_reject >= 0 && attempt > ts->max_reject) ts->reason = TS_DIVERGED_STEP_REJECTED;
  if (ts->time_step < smallest * PetscMax(ts->ptime, early * ts->max_time))
    ts->reason = TS_DIVERGED_STEP_REJECTED;
  PetscFunctionReturn(0);
}

/* Whether a solved step may be; if not, it is as if it had not been solved. */
static PetscErrorCode Check(TS ts, VBDF *self, SNESConvergedReason *solved) {
  PetscBool impossible = PETSC_FALSE;

  PetscFunctionBegin;
  if (!self->check || *solved < 0) PetscFunctionReturn(0);
  PetscCall(
      self->check(ts, self->time[1], self->time[0], self->point[1], self->point[0], &impossible));
  if (impossible) *solved = SNES_DIVERGED_FUNCTION_DOMAIN;
  PetscFunctionReturn(0);
}

/* Does a step like the one solved, if it went to X, cross a mode that grows? */
static PetscErrorCode CrossesAt(TS ts, VBDF *self, Vec X, VBDFSight sight, PetscBool *crosses) {
  Mat J, P;

  PetscFunctionBegin;
  PetscCall(TSPreStage(ts, self->time[0]));
  PetscCall(ComputeRate(self, X));
  PetscCall(TSGetIJacobian(ts, &J, &P, NULL, NULL));
  PetscCall(TSComputeIJacobian(ts, self->time[0], X, self->rate, self->shift, J, P, PETSC_FALSE));
  PetscCall(self->cross(ts, X, sight, crosses));
  PetscFunctionReturn(0);
}

/*
  Crosses - does a step of this order, which would be accepted, cross a mode that grows? A mode of
  the rate r is multiplied by about 1/(1 - h r): beyond h r = 1 its sign turns, and it falls instead
  of growing. No error sees that, for it does not depend on h any more. A step of which no error is
  known may have gone far: it must not cross one where it begins, as predicted, nor half-way. If it
  does, the order and the memory of rejected errors are as if it had not been tried.
*/
static PetscErrorCode Crosses(TS ts, VBDF *self, PetscInt order, PetscBool *crosses) {
  VBDFSight sight = self->n <= order ? VBDF_BLIND : VBDF_SEEN;
  PetscInt best = self->order;

  PetscFunctionBegin;
  *crosses = PETSC_FALSE;
  if (!self->cross) PetscFunctionReturn(0);
  if (self->jumped) sight = ts->time_step < self->layer ? VBDF_BLIND : VBDF_JUMP;
  PetscCall(self->cross(ts, self->point[0], sight, crosses));
  if (sight != VBDF_SEEN && !*crosses) {
    self->order = order;
    PetscCall(Predict(ts, self, self->work));
    PetscCall(CrossesAt(ts, self, self->work, sight, crosses));
    PetscCall(VecAXPBY(self->work, 0.5, 0.5, self->point[0]));
    if (!*crosses) PetscCall(CrossesAt(ts, self, self->work, sight, crosses));
    if (!*crosses)
      PetscCall(CrossesAt(ts, self, self->point[0], sight, crosses)); /* for the next step */
    self->order = best;
  }
  if (!*crosses) PetscFunctionReturn(0);
  self->order = order;
  self->jumped = PETSC_FALSE;
  self->rejected = PETSC_MAX_REAL;
  PetscFunctionReturn(0);
}

/* A jump shows: follows it from the last point on, and begins the step again behind it. */
static PetscErrorCode Snap(TS ts, VBDF *self, PetscBool *accept) {
  PetscBool done;

  PetscFunctionBegin;
  PetscCall(self->snap(ts, self->time[1], self->point[1], &done));
  self->tried = PETSC_TRUE;
  self->snapped = done;
  if (!done) PetscFunctionReturn(0);
  PetscCall(FactorSize(self, self->point[1], self->size[1]));
  *accept = PETSC_FALSE;
  self->jumped = PETSC_FALSE;
  self->rejected = PETSC_MAX_REAL;
  self->order = 1;
  self->n = 1;
  PetscFunctionReturn(0);
}

/* Have the steps shrunk as they do before a snap, or more since that was asked? (The first step is
   but a guess, which a start out of balance cuts to the rates of its fastest modes: no step that
   follows has shrunk against that.) */
static PetscBool Shrinks(const TS ts, VBDF *self) {
  if (self->n <= 1 && self->usual == 0) return PETSC_FALSE;
  PetscBool shrinks = (PetscBool)(ts->time_step < shrunk * self->usual);

  self->usual =
      shrinks ? again / shrunk * ts->time_step : PetscMax(ts->time_step, forgets * self->usual);
  return shrinks;
}

/* Solves the equations of the present step, in the usual way or else in another. */
static PetscErrorCode Solve(TS ts, VBDF *self, SNESConvergedReason *solved) {
  PetscFunctionBegin;
  PetscCall(Predict(ts, self, self->point[0]));
  PetscCall(SolveStage(ts, self));
  PetscCall(SNESGetConvergedReason(ts->snes, solved));
  if (*solved >= 0 || !self->other_way) PetscFunctionReturn(0);
  PetscCall(self->other_way(ts, PETSC_TRUE));
  PetscCall(Predict(ts, self, self->point[0]));
  PetscCall(SolveStage(ts, self));
  PetscCall(SNESGetConvergedReason(ts->snes, solved));
  PetscCall(self->other_way(ts, PETSC_FALSE));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSStep_VBDF(TS ts) {
  VBDF *self = (VBDF *)ts->data;
  PetscReal factor = 1, size;
  PetscBool accept, crosses;
  PetscInt order;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &self->fixed));
  self->jumped = self->tried = self->snapped = PETSC_FALSE;
  self->layer = PetscMax(self->layer, jump_step * ts->max_time);
  self->rejected = PETSC_MAX_REAL;
  if (ts->steprestart && !self->given) self->n = 0;
  if (!self->given && !ts->steprollback) PetscCall(Push(ts, self));
  self->given = PETSC_FALSE;
  if (self->fixed) self->order = PetscMin(self->order + 1, self->most);
  if (!self->fixed && self->snap && Shrinks(ts, self)) PetscCall(Snap(ts, self, &accept));
  for (PetscInt attempt = 1; !ts->reason; attempt++) {
    SNESConvergedReason solved;
    self->order = PetscMax(1, PetscMin(self->order, self->n));
    PetscCall(LimitStep(ts, self));
    BeginTry(ts, self);
    PetscCall(Solve(ts, self, &solved));
    self->taken_order = self->order;
    PetscCall(VecNorm(self->point[0], NORM_INFINITY, &size));
    if (PetscIsInfOrNanReal(size)) solved = DIVERGED_NAN;
    PetscCall(Check(ts, self, &solved));
    if (solved < 0) {
      ts->num_snes_failures++;
      if (self->fixed ||
          (ts->max_snes_failures >= 0 && ts->num_snes_failures > ts->max_snes_failures))
        ts->reason = TS_DIVERGED_NONLINEAR_SOLVE;
      else if (attempt > failures_of_snap && self->snap && !self->tried)
        PetscCall(Snap(ts, self, &accept));
      else
        PetscCall(Retry(ts, self, attempt, cut));
      continue;
    }
    accept = PETSC_TRUE;
    order = self->order;
    if (!self->fixed) PetscCall(Choose(ts, self, &accept, &factor));
    if (accept) PetscCall(Crosses(ts, self, order, &crosses));
    if (accept && crosses) {
      if (self->fixed)
        ts->reason = TS_DIVERGED_STEP_REJECTED;
      else if (attempt > failures_of_snap && self->snap && !self->tried)
        PetscCall(Snap(ts, self, &accept));
      else
        PetscCall(Retry(ts, self, attempt, cut));
      continue;
    }
    if (self->jumped && self->snap && !self->tried && ts->time_step >= self->layer) {
      PetscCall(Snap(ts, self, &accept));
      if (!accept) continue;
    }
    if (accept) break;
    if (factor > 1. / 3) self->rejected = PETSC_MAX_REAL;
    PetscCall(Retry(ts, self, attempt, factor));
  }
  if (ts->reason) PetscFunctionReturn(0);
  self->since++;
  if (self->jumped || self->snapped) self->jumps++;
  if (self->jumped) {
    self->n = 0;
    factor = 1;
    if (ts->time_step < self->layer) {
      factor = 2;
      self->layer = PetscMin(2 * self->layer, longest_jump * ts->max_time);
    }
  } else if (self->n > 1) /* its error was seen: the layer is behind */
    self->layer = 0;
  PetscCall(VecCopy(self->point[0], ts->vec_sol));
  /* of the accepted state: a linear solve has not looked at it any more */
  PetscCall(ComputeRate(self, self->point[0]));
  ts->ptime = self->time[0];
  if (ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP &&
      PetscAbsReal(ts->max_time - ts->ptime) < 1e-12 * ts->max_time)
    ts->ptime = ts->max_time;
  ts->time_step *= factor;
  PetscFunctionReturn(0);
}

/* How many points the dense output goes through. */
static PetscInt DensePoints(const VBDF *self) {
  return PetscMin(self->order + 2, self->n + 1);
}

/* Dense output: the polynomial through the new and the past points, one degree above the formula;
   of z, for the fields factored. */
static PetscErrorCode TSInterpolate_VBDF(TS ts, PetscReal t, Vec X) {
  VBDF *self = (VBDF *)ts->data;
  PetscReal L[VBDF_POINTS], ratio[VBDF_FACTORS][VBDF_POINTS];
  PetscInt m = DensePoints(self);

  PetscFunctionBegin;
  LagrangeValues(m, self->time, t, L);
  FactorRatios(self, 0, m, t, ratio);
  PetscCall(Combine(self, 0, m, L, NULL, NULL, ratio, X));
  PetscFunctionReturn(0);
}

/* VBDFInterpolate - the state and its rate at a time within the latest step, by the dense output;
   done is false if the type is another one. Collective. */
PetscErrorCode VBDFInterpolate(TS ts, PetscReal t, Vec U, Vec U_t, PetscBool *done) {
  VBDF *self = NULL;
  PetscReal L[VBDF_POINTS], D[VBDF_POINTS], rho[VBDF_FACTORS], ratio[VBDF_FACTORS][VBDF_POINTS];
  PetscInt m;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  *done = (PetscBool)(self != NULL);
  if (!self) PetscFunctionReturn(0);
  m = DensePoints(self);
  LagrangeValues(m, self->time, t, L);
  LagrangeSlopes(m, self->time, t, D);
  FactorRatios(self, 0, m, t, ratio);
  for (int k = 0; k < VBDF_FACTORS; k++) rho[k] = FactorRate(self, k, t);
  PetscCall(Combine(self, 0, m, D, L, rho, ratio, U_t));
  PetscCall(TSInterpolate_VBDF(ts, t, U));
  PetscFunctionReturn(0);
}

static PetscErrorCode SNESTSFormFunction_VBDF(SNES snes, Vec U, Vec F, TS ts) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  PetscCall(ComputeRate(self, U));
  PetscCall(TSComputeIFunction(ts, self->time[0], U, self->rate, F, PETSC_FALSE));
  PetscFunctionReturn(0);
}

static PetscErrorCode SNESTSFormJacobian_VBDF(SNES snes, Vec U, Mat J, Mat P, TS ts) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  /* rate holds U_t of the latest residual, which SNES evaluated at this U */
  PetscCall(TSComputeIJacobian(ts, self->time[0], U, self->rate, self->shift, J, P, PETSC_FALSE));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSReset_VBDF(TS ts) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < VBDF_POINTS; i++) PetscCall(VecDestroy(&self->point[i]));
  PetscCall(VecDestroy(&self->affine));
  PetscCall(VecDestroy(&self->rate));
  PetscCall(VecDestroy(&self->work));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSDestroy_VBDF(TS ts) {
  PetscFunctionBegin;
  PetscCall(TSReset_VBDF(ts));
  PetscCall(PetscFree(ts->data));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSSetUp_VBDF(TS ts) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < VBDF_POINTS; i++)
    if (!self->point[i]) PetscCall(VecDuplicate(ts->vec_sol, &self->point[i]));
  if (!self->affine) PetscCall(VecDuplicate(ts->vec_sol, &self->affine));
  if (!self->rate) PetscCall(VecDuplicate(ts->vec_sol, &self->rate));
  if (!self->work) PetscCall(VecDuplicate(ts->vec_sol, &self->work));
  PetscCall(TSGetAdapt(ts, &ts->adapt));
  PetscCall(TSGetSNES(ts, &ts->snes));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSSetFromOptions_VBDF(TS ts, OptionItems PetscOptionsObject) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "variable-order BDF");
  PetscCall(PetscOptionsRangeInt("-ts_bdf_order", "highest order, 1 to 6", "", self->most,
                                 &self->most, NULL, 1, 6));
  PetscCall(PetscOptionsRangeInt("-ts_bdf_factor",
                                 "degree of the logarithm of the factor taken "
                                 "out of fields that decay and grow, 0 (none) to 3",
                                 "", self->degree, &self->degree, NULL, 0, 3));
  PetscOptionsHeadEnd();
  PetscFunctionReturn(0);
}

static PetscErrorCode TSCreate_VBDF(TS ts) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  self->most = 5;
  self->degree = 2;
  self->order = 1;
  ts->data = self;
  ts->ops->reset = TSReset_VBDF;
  ts->ops->destroy = TSDestroy_VBDF;
  ts->ops->setup = TSSetUp_VBDF;
  ts->ops->setfromoptions = TSSetFromOptions_VBDF;
  ts->ops->step = TSStep_VBDF;
  ts->ops->interpolate = TSInterpolate_VBDF;
  ts->ops->snesfunction = SNESTSFormFunction_VBDF;
  ts->ops->snesjacobian = SNESTSFormJacobian_VBDF;
  ts->default_adapt_type = TSADAPTBASIC;
  ts->usessnes = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* VBDFRegister - makes the type known; call once, before TSSetType(). */
PetscErrorCode VBDFRegister(void) {
  PetscFunctionBegin;
  PetscCall(TSRegister(TSVBDF, TSCreate_VBDF));
  PetscFunctionReturn(0);
}

/* VBDFSetGuess - sets how to guess the first step, from one point. No effect on other types. */
PetscErrorCode VBDFSetGuess(TS ts, VBDFGuess guess, void *ctx) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) {
    self->guess = guess;
    self->guess_ctx = ctx;
  }
  PetscFunctionReturn(0);
}

/* VBDFSetHighestOrder - 1 to 6; 5 if not called. The formula of order 6 is stable for rates close
   to the real axis only. -ts_bdf_order overrides it. No effect on other types. */
PetscErrorCode VBDFSetHighestOrder(TS ts, PetscInt order) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->most = order;
  PetscFunctionReturn(0);
}

/* VBDFSetOtherWay - sets how a step is solved that could not be solved. No effect on other types.
 */
PetscErrorCode VBDFSetOtherWay(TS ts, VBDFOtherWay other_way) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->other_way = other_way;
  PetscFunctionReturn(0);
}

/* VBDFSetSnap - sets how to follow a jump. No effect on other types. */
PetscErrorCode VBDFSetSnap(TS ts, VBDFSnap snap) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->snap = snap;
  PetscFunctionReturn(0);
}

/* VBDFSetCheck - sets what a step must not do. No effect on other types. */
PetscErrorCode VBDFSetCheck(TS ts, VBDFCheck check) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->check = check;
  PetscFunctionReturn(0);
}

/* VBDFSetCross - sets how to see that a step crosses a mode that grows: it is cut until it does
   not. No effect on other types. */
PetscErrorCode VBDFSetCross(TS ts, VBDFCross cross) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->cross = cross;
  PetscFunctionReturn(0);
}

/* VBDFSetMeasure - sets how errors are turned before they are held against the tolerances. No
   effect on other types. */
PetscErrorCode VBDFSetMeasure(TS ts, VBDFMeasure measure) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->measure = measure;
  PetscFunctionReturn(0);
}

/*
  VBDFSetFactored - says which fields are about one shape times a factor that falls or rises by many
  orders of magnitude, and may vanish: their factor is taken out of the steps. Before
  VBDFSetHistory(). No effect on other types.

  fields    unknowns of a node, at most VBDF_FIELDS; vectors hold node after node
  factored  of each: 0, or bit k for factor k, which is that of the first field that has it alone; a
            field that has several is factored by their product

  U_t then depends on U by shift + VBDFGetFactorRate() in these fields, for the Jacobian.
*/
PetscErrorCode VBDFSetFactored(TS ts, PetscInt fields, const int factored[]) {
  PetscBool any = PETSC_FALSE;
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  for (PetscInt f = 0; f < fields; f++) any = (PetscBool)(any || factored[f]);
  PetscCheck(fields <= VBDF_FIELDS, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "%d fields, at most %d", (int)fields, VBDF_FIELDS);
  self->fields = any ? fields : 0;
  PetscCall(PetscArraycpy(self->factored, factored, fields));
  PetscFunctionReturn(0);
}

/* VBDFGetFactorRate - rho of the present step: what the fields of each factor have in dU_t/dU
   beside the shift; 0 if the type is another one. */
PetscErrorCode VBDFGetFactorRate(TS ts, PetscReal rate[VBDF_FACTORS]) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  for (int k = 0; k < VBDF_FACTORS; k++) rate[k] = self ? self->rho[k] : 0;
  PetscFunctionReturn(0);
}

/*
  VBDFGetHistory - the points that the next step starts from, latest first, after an accepted step
  or after VBDFSetHistory().

  n       how many, at most VBDF_POINTS; 0 on exit if the type is another one
  points  borrowed
  order   the order chosen for the next step
*/
PetscErrorCode VBDFGetHistory(TS ts, PetscInt *n, PetscReal times[], Vec points[],
                              PetscInt *order) {
  PetscInt first = 1; /* a history that was handed over has no new point yet */
  VBDF *self = NULL;

  PetscFunctionBegin;
  *n = 0;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  if (!self->given) first = 0;
  *n = PetscMin(self->n + 1 - first, VBDF_POINTS - 1);
  *order = self->order;
  for (PetscInt i = 0; i < *n; i++) {
    times[i] = self->time[first + i];
    points[i] = self->point[first + i];
  }
  PetscFunctionReturn(0);
}

/* VBDFSetHistory - hands over n points, latest first (copied), to a TS that has its solution set.
   No effect on other types, which then start afresh. */
PetscErrorCode VBDFSetHistory(TS ts, PetscInt n, const PetscReal times[], const Vec points[],
                              PetscInt order) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  PetscCall(TSSetUp_VBDF(ts));
  for (PetscInt i = 0; i < n; i++) {
    self->time[i + 1] = times[i];
    PetscCall(VecCopy(points[i], self->point[i + 1]));
    PetscCall(FactorSize(self, points[i], self->size[i + 1]));
  }
  self->n = n;
  self->order = order;
  self->since = 0;
  self->given = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* VBDFGetMemory - what the stepper remembers besides its history; zeros if the type is another one.
 */
PetscErrorCode VBDFGetMemory(TS ts, PetscReal memory[VBDF_MEMORY]) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  memory[0] = self ? (PetscReal)self->since : 0;
  memory[1] = self ? self->layer : 0;
  memory[2] = self ? self->usual : 0;
  memory[3] = self ? (PetscReal)self->plain_next : 0;
  PetscFunctionReturn(0);
}

/* VBDFSetMemory - gives it back, after VBDFSetHistory(): the stepper goes on as if it had not
   stopped. */
PetscErrorCode VBDFSetMemory(TS ts, const PetscReal memory[VBDF_MEMORY]) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  self->since = (PetscInt)memory[0];
  self->layer = memory[1];
  self->usual = memory[2];
  self->plain_next = (PetscBool)(memory[3] != 0);
  PetscFunctionReturn(0);
}

/* VBDFGetJumps - how many steps were jumps, so far; 0 if the type is another one. */
PetscErrorCode VBDFGetJumps(TS ts, PetscInt *jumps) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  *jumps = self ? self->jumps : 0;
  PetscFunctionReturn(0);
}

/* VBDFGetOrder - the order of the next step; 0 if the type is another one. */
PetscErrorCode VBDFGetOrder(TS ts, PetscInt *order) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  *order = self ? self->order : 0;
  PetscFunctionReturn(0);
}

/* The error of the first step is known when the second is taken: h^2 U[t0,t1,t2], h its length. */
static void AddFirst(const VBDF *self, PetscInt fields, PetscReal weight[][VBDF_FIELDS]) {
  const PetscReal *t = self->time, first = PetscSqr(t[1] - t[2]);

  for (int j = 0; j < 3; j++)
    for (PetscInt f = 0; f < fields; f++)
      weight[j][f] += first / ((t[j] - t[(j + 1) % 3]) * (t[j] - t[(j + 2) % 3]));
}

/*
  VBDFGetLocalError - what the step taken last adds to the error, as a combination of its points:
  the weights of those that VBDFGetHistory() tells, after an accepted step.

  fields  of a node
  n       how many; 0: it is not known (a jump, another type; the first step's
          comes with the second's)
  weight  of each point, for each field of a node
*/
PetscErrorCode VBDFGetLocalError(TS ts, PetscInt fields, PetscInt *n,
                                 PetscReal weight[VBDF_POINTS][VBDF_FIELDS]) {
  PetscReal factor, along[VBDF_POINTS];
  VBDF *self = NULL;
  PetscInt k;

  PetscFunctionBegin;
  *n = 0;
  PetscCall(Self(ts, &self));
  if (!self || self->given) PetscFunctionReturn(0);
  k = self->taken_order;
  if (self->jumped || self->n < k + 1) PetscFunctionReturn(0);
  TakeFactor(self, k);
  factor = (self->time[0] - self->time[1]) / (self->time[0] - self->time[k + 1]);
  LagrangeValues(k + 1, self->time + 1, self->time[0], along + 1);
  along[0] = factor;
  for (PetscInt j = 1; j <= k + 1; j++) along[j] *= -factor;
  Weights(self, fields, k + 2, along, NULL, NULL, self->ratio, weight);
  if (self->n == 2) AddFirst(self, fields, weight);
  *n = k + 2;
  PetscFunctionReturn(0);
}

/*
  VBDFGetFormula - U_t of the state that the step taken last has led to, as a combination of its
  points: the weights, for each field, of those that VBDFGetHistory() tells, after an accepted step.

  n  how many; 0: there are none (a step behind a snap, another type)

  The factor is taken for a number that was given: whatever it is, the formula is one of the same
  order, also for what moves with the state (tangent.c).
*/
PetscErrorCode VBDFGetFormula(TS ts, PetscInt *n, PetscReal weight[][VBDF_FIELDS]) {
  PetscReal D[VBDF_POINTS], first[VBDF_POINTS] = {1};
  VBDF *self = NULL;

  PetscFunctionBegin;
  *n = 0;
  PetscCall(Self(ts, &self));
  if (!self || self->given || self->snapped) PetscFunctionReturn(0);
  *n = self->taken_order + 1;
  TakeFactor(self, self->taken_order);
  LagrangeSlopes(*n, self->time, self->time[0], D);
  Weights(self, VBDF_FIELDS, *n, D, first, self->rho, self->ratio, weight);
  PetscFunctionReturn(0);
}

/*
  VBDFGetDense - the state and its rate at a time within the latest step, by the dense output, as
  combinations of the points that VBDFGetHistory() tells: their weights for each field.

  n  how many; 0 if the type is another one
*/
PetscErrorCode VBDFGetDense(TS ts, PetscReal t, PetscInt *n, PetscReal value[][VBDF_FIELDS],
                            PetscReal slope[][VBDF_FIELDS]) {
  PetscReal L[VBDF_POINTS], D[VBDF_POINTS], rho[VBDF_FACTORS], ratio[VBDF_FACTORS][VBDF_POINTS];
  VBDF *self = NULL;

  PetscFunctionBegin;
  *n = 0;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  *n = DensePoints(self);
  LagrangeValues(*n, self->time, t, L);
  LagrangeSlopes(*n, self->time, t, D);
  FactorRatios(self, 0, *n, t, ratio);
  for (int k = 0; k < VBDF_FACTORS; k++) rho[k] = FactorRate(self, k, t);
  Weights(self, VBDF_FIELDS, *n, L, NULL, NULL, ratio, value);
  Weights(self, VBDF_FIELDS, *n, D, L, rho, ratio, slope);
  PetscFunctionReturn(0);
}
