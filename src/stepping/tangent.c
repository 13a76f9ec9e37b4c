/*
  A run solves F(t, U, U_t; p) = 0. With S = dU/dp,

    F_U S + F_U_t S_t + F_p = 0.

  vbdf's formula makes of U_t a combination of the new state and past ones, sum of w_j U_j; the same
  holds for S_t, with the same steps and orders, and its factor as it was: the formula is of one
  order whatever the factor. So each accepted step is followed by one linear system for each number
  (staggered), with the matrix of the step, F_U + F_U_t w_0, at the solution itself.

  Let D be the shift of fields that are not factored, w_0 = D + rho, and b what past points give of
  S_t. From S = -b/D + d it is

    (F_U + F_U_t w_0) d = -F_p + (F_U + F_U_t rho) b/D,

  and nothing is divided by w_0, which may vanish. F_p is a difference between two scenes that
  differ by p alone: no law needs to know its derivative by each of its numbers.
*/
#include "stepping/tangent.h"
#include "rod/ask.h"
#include "base/compat.h"
#include "rod/learned.h"
#include "stepping/vbdf.h"

typedef struct {
  TangentOf of;
  Vec point[VBDF_POINTS], rate; /* S at the points that VBDFGetHistory() tells; S_t at the first */
} Tangent;

struct _Tangents {
  Leg *leg;
  PetscInt n;
  Tangent *tangent;
  Mat beside;     /* F_U + F_U_t rho */
  Vec past, work; /* b/D; right-hand side */
  PetscReal t;    /* of the latest step */
  PetscBool lost; /* behind a snap nothing is known */
};

/*
  TangentsCreate - of a leg, which must step by vbdf, and outlive it. Collective; the caller ends it
  with TangentsDestroy().
*/
PetscErrorCode TangentsCreate(Leg *leg, PetscInt n, const TangentOf of[], Tangents *tangents) {
  Tangents self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *tangents = self;
  self->leg = leg;
  self->n = n;
  PetscCall(PetscCalloc1(n, &self->tangent));
  for (PetscInt k = 0; k < n; k++) {
    self->tangent[k].of = of[k];
    for (int j = 0; j < VBDF_POINTS; j++)
      PetscCall(VecDuplicate(leg->U, &self->tangent[k].point[j]));
    PetscCall(VecDuplicate(leg->U, &self->tangent[k].rate));
  }
  PetscCall(VecDuplicate(leg->U, &self->past));
  PetscCall(VecDuplicate(leg->U, &self->work));
  PetscCall(RodCreateMatrix(leg->rod, &self->beside));
  PetscFunctionReturn(0);
}

PetscErrorCode TangentsDestroy(Tangents *tangents) {
  Tangents self = *tangents;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < self->n; k++) {
    for (int j = 0; j < VBDF_POINTS; j++) PetscCall(VecDestroy(&self->tangent[k].point[j]));
    PetscCall(VecDestroy(&self->tangent[k].rate));
  }
  PetscCall(PetscFree(self->tangent));
  PetscCall(VecDestroy(&self->past));
  PetscCall(VecDestroy(&self->work));
  PetscCall(MatDestroy(&self->beside));
  PetscCall(PetscFree(*tangents));
  PetscFunctionReturn(0);
}

/* TangentsLost - has the rod snapped? When it did depends on the numbers, too, and the derivatives
   behind it are not known. */
PetscBool TangentsLost(Tangents tangents) {
  return tangents->lost;
}

/* TangentsBegin - a run begins, with the scene's initial shape. Collective. */
PetscErrorCode TangentsBegin(Tangents self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    Tangent *tangent = &self->tangent[k];
    PetscCall(RodBegin(tangent->of.low, self->work));
    PetscCall(RodBegin(tangent->of.high, tangent->point[0]));
    PetscCall(VecAXPY(tangent->point[0], -1, self->work));
    PetscCall(VecScale(tangent->point[0], 1 / tangent->of.apart));
    PetscCall(VecZeroEntries(tangent->rate));
  }
  PetscFunctionReturn(0);
}

/* X = sum of n points from first on, times their weights; over the number `over`. */
static PetscErrorCode Sum(const Tangents self, PetscInt n, Vec point[],
                          PetscReal weight[][VBDF_FIELDS], PetscReal over, Vec X) {
  const PetscInt fields = self->leg->rod->model->fields;
  const PetscScalar *y;
  PetscInt size;
  PetscScalar *x;

  PetscFunctionBegin;
  PetscCall(VecZeroEntries(X));
  PetscCall(VecGetLocalSize(X, &size));
  PetscCall(VecGetArray(X, &x));
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(VecGetArrayRead(point[k], &y));
    for (PetscInt i = 0; i < size; i += fields)
      for (PetscInt f = 0; f < fields; f++) x[i + f] += weight[k][f] / over * y[i + f];
    PetscCall(VecRestoreArrayRead(point[k], &y));
  }
  PetscCall(VecRestoreArray(X, &x));
  PetscFunctionReturn(0);
}

/* The two matrices at the accepted state: the step's, where its solver has it, and that beside it.
   Friction has its own slope there, not the one that Newton's method is better off with. */
static PetscErrorCode Linearise(Tangents self, PetscReal t, PetscReal shift) {
  Leg *leg = self->leg;
  FrictionNewton slope[2] = {NEWTON_PRIMAL, NEWTON_PRIMAL};
  RodState beside;
  Mat J, P;

  PetscFunctionBegin;
  RodSwapSlopes(leg->rod, slope);
  PetscCall(VBDFGetFactorRate(leg->ts, leg->newton.factor_rate));
  beside = (RodState){.t = t, .U = leg->U, .U_t = leg->newton.latest.U_t, .fresh = PETSC_TRUE};
  for (PetscInt f = 0; f < leg->rod->model->fields; f++)
    for (int m = 0; m < MIRRORS; m++)
      if (leg->rod->model->group[f] & 1 << m) beside.shift[f] += leg->newton.factor_rate[m];
  PetscCall(leg->rod->model->jacobian(leg->rod, &beside, self->beside));
  PetscCall(TSGetIJacobian(leg->ts, &J, &P, NULL, NULL));
  leg->newton.fresh = PETSC_TRUE;
  PetscCall(TSComputeIJacobian(leg->ts, t, leg->U, beside.U_t, shift, J, P, PETSC_FALSE));
  RodSwapSlopes(leg->rod, slope);
  PetscFunctionReturn(0);
}

/* -F_p */
static PetscErrorCode Force(Tangents self, const TangentOf *of, PetscReal t, Vec work, Vec F) {
  const RodState at = {.t = t, .U = self->leg->U, .U_t = self->leg->newton.latest.U_t};

  PetscFunctionBegin;
  PetscCall(of->low->model->residual(of->low, &at, F));
  PetscCall(of->high->model->residual(of->high, &at, work));
  PetscCall(VecAXPY(F, -1, work));
  PetscCall(VecScale(F, 1 / of->apart));
  PetscFunctionReturn(0);
}

/* Makes of a sum of n points from `first` on, over a number, one along the material, as a rod has
   it: where that slides past the labels. */
static PetscErrorCode Carry(Tangents self, Rod rod, PetscInt first, PetscInt n, Vec point[],
                            PetscReal weight[][VBDF_FIELDS], PetscReal over, Vec X) {
  PetscReal times[VBDF_POINTS], part[VBDF_POINTS][VBDF_FIELDS];
  PetscInt points, order;
  Vec past[VBDF_POINTS];

  PetscFunctionBegin;
  if (!LearnedCarries(rod)) PetscFunctionReturn(0);
  PetscCall(VBDFGetHistory(self->leg->ts, &points, times, past, &order));
  for (PetscInt k = 0; k < n; k++) {
    times[first + k] += self->t;
    for (int f = 0; f < VBDF_FIELDS; f++) part[k][f] = weight[first + k][f] / over;
  }
  PetscCall(LearnedCarry(rod, self->t, n, times + first, point ? point + first : past + first, part,
                         PETSC_FALSE, X));
  PetscFunctionReturn(0);
}

/* F -= F_U_t of what the way of the material changes in U_t with a number. */
static PetscErrorCode ForceByWay(Tangents self, const TangentOf *of, PetscInt n,
                                 PetscReal weight[][VBDF_FIELDS], Vec F) {
  Vec by;

  PetscFunctionBegin;
  if (!LearnedCarries(self->leg->rod)) PetscFunctionReturn(0);
  PetscCall(VecDuplicate(F, &by));
  PetscCall(VecZeroEntries(by));
  PetscCall(Carry(self, of->high, 1, n - 1, NULL, weight, of->apart, by));
  PetscCall(Carry(self, of->low, 1, n - 1, NULL, weight, -of->apart, by));
  PetscCall(LearnedTimesRate(self->leg->rod, by));
  PetscCall(VecAXPY(F, -1, by));
  PetscCall(VecDestroy(&by));
  PetscFunctionReturn(0);
}

static PetscErrorCode Follow(Tangents self, Tangent *tangent, KSP ksp, PetscInt n,
                             PetscReal weight[][VBDF_FIELDS]) {
  Vec S = tangent->point[VBDF_POINTS - 1];

  PetscFunctionBegin;
  for (int j = VBDF_POINTS - 1; j > 0; j--) tangent->point[j] = tangent->point[j - 1];
  tangent->point[0] = S;
  PetscCall(Sum(self, n - 1, tangent->point + 1, weight + 1, weight[0][0], self->past));
  PetscCall(
      Carry(self, self->leg->rod, 1, n - 1, tangent->point, weight, weight[0][0], self->past));
  PetscCall(Force(self, &tangent->of, self->t, S, self->work));
  PetscCall(ForceByWay(self, &tangent->of, n, weight, self->work));
  PetscCall(MatMultAdd(self->beside, self->past, self->work, self->work));
  PetscCall(KSPSolve(ksp, self->work, S));
  PetscCall(VecAXPY(S, -1, self->past));
  PetscCall(Sum(self, n, tangent->point, weight, 1, tangent->rate));
  PetscCall(Carry(self, self->leg->rod, 1, n - 1, tangent->point, weight, 1, tangent->rate));
  PetscFunctionReturn(0);
}

/* TangentsStep - follows the step to the leg's present state, at t; after it was accepted, and
   before anything else is done to its stepper. Collective. */
PetscErrorCode TangentsStep(Tangents self, PetscReal t) {
  PetscReal weight[VBDF_POINTS][VBDF_FIELDS];
  PetscInt n;
  SNES snes;
  KSP ksp;

  PetscFunctionBegin;
  PetscCall(VBDFGetFormula(self->leg->ts, &n, weight));
  if (!n) self->lost = PETSC_TRUE;
  if (self->lost) PetscFunctionReturn(0);
  self->t = t;
  /* unknown 0 is the place along the rod: never factored */
  PetscCall(Linearise(self, t, weight[0][0]));
  PetscCall(TSGetSNES(self->leg->ts, &snes));
  PetscCall(SNESGetKSP(snes, &ksp));
  for (PetscInt k = 0; k < self->n; k++) PetscCall(Follow(self, &self->tangent[k], ksp, n, weight));
  PetscFunctionReturn(0);
}

/* TangentsAt - the derivatives of the state and its rate by number k, at a time within the latest
   step. Collective. */
PetscErrorCode TangentsAt(Tangents self, PetscInt k, PetscReal t, Vec S, Vec S_t) {
  PetscReal value[VBDF_POINTS][VBDF_FIELDS], slope[VBDF_POINTS][VBDF_FIELDS];
  Tangent *tangent = &self->tangent[k];
  PetscInt n;

  PetscFunctionBegin;
  if (t == self->t) {
    PetscCall(VecCopy(tangent->point[0], S));
    PetscCall(VecCopy(tangent->rate, S_t));
    PetscFunctionReturn(0);
  }
  PetscCall(VBDFGetDense(self->leg->ts, t, &n, value, slope));
  PetscCall(Sum(self, n, tangent->point, value, 1, S));
  PetscCall(Sum(self, n, tangent->point, slope, 1, S_t));
  PetscFunctionReturn(0);
}
