#include "stepping/formula.h"
#include "base/lagrange.h"
#include "stepping/rules.h"

/* FormulaSetUp - makes the vectors, like U, that are not there yet. Collective. */
PetscErrorCode FormulaSetUp(Formula *self, Vec U) {
  PetscFunctionBegin;
  for (PetscInt i = 0; i < VBDF_POINTS; i++)
    if (!self->point[i]) PetscCall(VecDuplicate(U, &self->point[i]));
  if (!self->affine) PetscCall(VecDuplicate(U, &self->affine));
  if (!self->rate) PetscCall(VecDuplicate(U, &self->rate));
  PetscFunctionReturn(0);
}

/* FormulaReset - frees them. Collective. */
PetscErrorCode FormulaReset(Formula *self) {
  PetscFunctionBegin;
  for (PetscInt i = 0; i < VBDF_POINTS; i++) PetscCall(VecDestroy(&self->point[i]));
  PetscCall(VecDestroy(&self->affine));
  PetscCall(VecDestroy(&self->rate));
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
static PetscReal FactorLog(const Formula *self, int k, PetscReal t) {
  PetscReal L[VBDF_POINTS], sum = 0;

  LagrangeValues(self->taken[k], self->time + 1, t, L);
  for (PetscInt j = 0; j < self->taken[k]; j++) sum += L[j] * self->size[1 + j][self->column[k]];
  return sum;
}

static PetscReal FactorRate(const Formula *self, int k, PetscReal t) {
  PetscReal D[VBDF_POINTS], sum = 0;

  LagrangeSlopes(self->taken[k], self->time + 1, t, D);
  for (PetscInt j = 0; j < self->taken[k]; j++) sum += D[j] * self->size[1 + j][self->column[k]];
  return sum;
}

/* Behind a step that was cut by far the latest points lie close together, and of those far before
   them their polynomial says what is no number. (Steps change the factor by 4 e-foldings at most,
   controller.c: what is beyond this is an error, and shows as one.) */
static PetscReal Within(PetscReal efoldings) {
  return PetscMax(-step_rule.factor_extrapolated,
                  PetscMin(efoldings, step_rule.factor_extrapolated));
}

/* A(t)/A(t_j) of m points from first on */
static void FactorRatios(const Formula *self, PetscInt first, PetscInt m, PetscReal t,
                         PetscReal ratio[VBDF_FACTORS][VBDF_POINTS]) {
  for (int k = 0; k < VBDF_FACTORS; k++)
    for (PetscInt j = 0; j < m; j++) {
      ratio[k][j] = 1;
      if (self->taken[k] >= 2)
        ratio[k][j] =
            PetscExpReal(Within(FactorLog(self, k, t) - FactorLog(self, k, self->time[first + j])));
    }
}

/* Is any factor taken in the present step? */
static PetscBool Factored(const Formula *self) {
  PetscBool any = PETSC_FALSE;
  for (int k = 0; k < VBDF_FACTORS; k++) any = (PetscBool)(any || self->taken[k]);
  return any;
}

/* Are the fields of all factors of like size? Then they have one, that of all of them, whatever the
   axes are: a rod that is bent is as much so when it is turned. */
static PetscBool Common(const Formula *self) {
  const PetscReal *size = self->size[1];

  return (PetscBool)(size[0] > PETSC_MIN_REAL && size[1] > PETSC_MIN_REAL &&
                     PetscAbsReal(size[0] - size[1]) < PetscLogReal(step_rule.alike_across));
}

/* Are the fields of a factor but round-off? The factor would be what that does. */
static PetscBool RoundOff(const Formula *self, int k) {
  return (PetscBool)(self->column[k] == k && self->least[k] > 0 &&
                     self->size[1][k] < PetscLogReal(self->least[k]));
}

/* FormulaTakeFactor - takes the factor for a step of an order from the history to time[0]. */
void FormulaTakeFactor(Formula *self, PetscInt q) {
  PetscInt most = self->plain ? 0 : PetscMin(self->n, PetscMin(self->degree, q) + 1);

  for (int k = 0; k < VBDF_FACTORS; k++) {
    self->taken[k] = 0;
    self->column[k] = Common(self) ? FORMULA_ALL : k;
    if (self->fields && !RoundOff(self, k))
      while (self->taken[k] < most &&
             self->size[1 + self->taken[k]][self->column[k]] > PETSC_MIN_REAL)
        self->taken[k]++;
    if (self->taken[k] < 2) self->taken[k] = 0;
    self->rho[k] = FactorRate(self, k, self->time[0]);
  }
  FactorRatios(self, 0, self->n + 1, self->time[0], self->ratio);
}

/* FormulaEfoldings - by how many e-foldings the factor changes in the present step, at most; 0 if
   none is taken. */
PetscReal FormulaEfoldings(const Formula *self) {
  PetscReal efoldings = 0;

  for (int k = 0; k < VBDF_FACTORS; k++)
    if (self->taken[k])
      efoldings = PetscMax(efoldings, PetscAbsReal(FactorLog(self, k, self->time[0]) -
                                                   self->size[1][self->column[k]]));
  return efoldings;
}

/* The log of the Euclidean norm of the first of the fields of one factor; PETSC_MIN_REAL if it has
   vanished, or there is none. (Scaled: its square may lie below the smallest number.) */
static PetscErrorCode SizeOfFactor(const Formula *self, Vec U, int k, PetscReal *size) {
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
  for (PetscInt i = f; i < n && most > step_rule.field_vanished; i += self->fields)
    sum += PetscSqr(PetscRealPart(u[i]) / most);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPI_SUM, comm));
  PetscCall(VecRestoreArrayRead(U, &u));
  if (sum > 0) *size = PetscLogReal(most) + PetscLogReal(sum) / 2;
  PetscFunctionReturn(0);
}

/* FormulaMeasureSize - looks at the size of the fields of each factor in point i, and of all
   together: wherever a point has been set. Collective. */
PetscErrorCode FormulaMeasureSize(Formula *self, PetscInt i) {
  PetscReal most = PETSC_MIN_REAL, sum = 0, *size = self->size[i];

  PetscFunctionBegin;
  for (int k = 0; k < VBDF_FACTORS; k++) {
    PetscCall(SizeOfFactor(self, self->point[i], k, &size[k]));
    most = PetscMax(most, size[k]);
  }
  size[FORMULA_ALL] = most;
  if (most == PETSC_MIN_REAL) PetscFunctionReturn(0);
  for (int k = 0; k < VBDF_FACTORS; k++)
    if (size[k] > PETSC_MIN_REAL) sum += PetscExpReal(2 * (size[k] - most));
  size[FORMULA_ALL] = most + PetscLogReal(sum) / 2;
  PetscFunctionReturn(0);
}

/* FormulaPush - moves an accepted solution U into the history. Collective. */
PetscErrorCode FormulaPush(Formula *self, Vec U) {
  const PetscReal step = self->done ? self->time[0] : 0;
  Vec last = self->point[VBDF_POINTS - 1];

  PetscFunctionBegin;
  for (PetscInt i = VBDF_POINTS - 1; i > 1; i--) {
    self->point[i] = self->point[i - 1];
    self->time[i] = self->time[i - 1] - step;
    PetscCall(PetscArraycpy(self->size[i], self->size[i - 1], FORMULA_SIZES));
  }
  self->point[1] = last;
  self->time[1] = 0;
  self->done = PETSC_FALSE;
  PetscCall(VecCopy(U, last));
  PetscCall(FormulaMeasureSize(self, 1));
  self->n = PetscMin(self->n + 1, VBDF_POINTS - 1);
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
static void Weights(const Formula *self, PetscInt fields, PetscInt m, const PetscReal along[],
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
static PetscErrorCode Combine(Formula *self, PetscInt first, PetscInt m, const PetscReal along[],
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

/* The ratios of past points 1 .. m. */
static void PastRatios(const Formula *self, PetscInt m,
                       PetscReal ratio[VBDF_FACTORS][VBDF_POINTS]) {
  for (int a = 0; a < VBDF_FACTORS; a++)
    for (PetscInt k = 0; k < m; k++) ratio[a][k] = self->ratio[a][1 + k];
}

/* FormulaExtrapolate - X = the polynomial through past points 1 .. m, at time[0]. */
PetscErrorCode FormulaExtrapolate(Formula *self, PetscInt m, Vec X) {
  PetscReal L[VBDF_POINTS], ratio[VBDF_FACTORS][VBDF_POINTS];

  PetscFunctionBegin;
  LagrangeValues(m, self->time + 1, self->time[0], L);
  PastRatios(self, m, ratio);
  PetscCall(Combine(self, 1, m, L, NULL, NULL, ratio, X));
  PetscFunctionReturn(0);
}

/* Makes of affine what it is along the material. */
static PetscErrorCode Carry(Formula *self, PetscInt order, const PetscReal along[],
                            PetscReal ratio[VBDF_FACTORS][VBDF_POINTS]) {
  PetscReal c[VBDF_POINTS][VBDF_FIELDS], times[VBDF_POINTS];

  PetscFunctionBegin;
  Weights(self, VBDF_FIELDS, order, along, NULL, NULL, ratio, c);
  for (PetscInt k = 0; k < order; k++) times[k] = self->now + (self->time[1 + k] - self->time[0]);
  PetscCall(self->carry(self->ts, self->now, order, times, self->point + 1, c, self->affine));
  PetscFunctionReturn(0);
}

/* FormulaBegin - shift and affine of a step of an order from the history to time[0]. */
PetscErrorCode FormulaBegin(Formula *self, PetscInt order) {
  PetscReal D[VBDF_POINTS], ratio[VBDF_FACTORS][VBDF_POINTS];

  PetscFunctionBegin;
  LagrangeSlopes(order + 1, self->time, self->time[0], D);
  self->shift = D[0];
  PastRatios(self, order, ratio);
  PetscCall(Combine(self, 1, order, D + 1, NULL, NULL, ratio, self->affine));
  if (self->carry) PetscCall(Carry(self, order, D + 1, ratio));
  PetscFunctionReturn(0);
}

/* FormulaRate - rate = U_t = shift U + affine, and rho U more */
PetscErrorCode FormulaRate(Formula *self, Vec U) {
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

/*
  FormulaWithoutError - X = the new solution less the error that a step of an order would have made.

  With P the polynomial through the q + 1 past points, U - P = prod_{j=1}^{q+1} (t - t_j) U[t, ..],
  and the formula of order q errs by 1/shift_q prod_{j=1}^{q} (t - t_j) of the same divided
  difference: err = (U - P) / (shift_q (t - t_{q+1})), shift_q = sum_{j=1}^{q} 1/(t - t_j).
  The factor is that of this order behind it.
*/
PetscErrorCode FormulaWithoutError(Formula *self, PetscInt q, Vec X) {
  PetscReal shift = 0, factor;

  PetscFunctionBegin;
  for (PetscInt j = 1; j <= q; j++) shift += 1 / (self->time[0] - self->time[j]);
  factor = 1 / (shift * (self->time[0] - self->time[q + 1]));
  FormulaTakeFactor(self, q);
  PetscCall(FormulaExtrapolate(self, q + 1, X));
  PetscCall(VecAXPBY(X, 1 - factor, factor, self->point[0])); /* U - err */
  PetscFunctionReturn(0);
}

/* How many points the dense output goes through. */
static PetscInt DensePoints(const Formula *self, PetscInt order) {
  return PetscMin(order + 2, self->n + 1);
}

/* FormulaInterpolate - dense output: the polynomial through the new and the past points, one degree
   above the formula of an order; of z, for the fields factored. U_t, its rate, may be NULL. */
PetscErrorCode FormulaInterpolate(Formula *self, PetscInt order, PetscReal t, Vec U, Vec U_t) {
  PetscReal L[VBDF_POINTS], D[VBDF_POINTS], rho[VBDF_FACTORS], ratio[VBDF_FACTORS][VBDF_POINTS];
  PetscInt m = DensePoints(self, order);

  PetscFunctionBegin;
  LagrangeValues(m, self->time, t, L);
  FactorRatios(self, 0, m, t, ratio);
  PetscCall(Combine(self, 0, m, L, NULL, NULL, ratio, U));
  if (!U_t) PetscFunctionReturn(0);
  LagrangeSlopes(m, self->time, t, D);
  for (int k = 0; k < VBDF_FACTORS; k++) rho[k] = FactorRate(self, k, t);
  PetscCall(Combine(self, 0, m, D, L, rho, ratio, U_t));
  PetscFunctionReturn(0);
}

/* FormulaDenseWeights - the same as combinations of the points: their weights for each field;
   returns how many points. */
PetscInt FormulaDenseWeights(const Formula *self, PetscInt order, PetscReal t,
                             PetscReal value[][VBDF_FIELDS], PetscReal slope[][VBDF_FIELDS]) {
  PetscReal L[VBDF_POINTS], D[VBDF_POINTS], rho[VBDF_FACTORS], ratio[VBDF_FACTORS][VBDF_POINTS];
  PetscInt m = DensePoints(self, order);

  LagrangeValues(m, self->time, t, L);
  LagrangeSlopes(m, self->time, t, D);
  FactorRatios(self, 0, m, t, ratio);
  for (int k = 0; k < VBDF_FACTORS; k++) rho[k] = FactorRate(self, k, t);
  Weights(self, VBDF_FIELDS, m, L, NULL, NULL, ratio, value);
  Weights(self, VBDF_FIELDS, m, D, L, rho, ratio, slope);
  return m;
}

/* FormulaRateWeights - U_t of the new solution, by the formula of an order, as a combination of the
   points: their weights for each field; returns how many points. */
PetscInt FormulaRateWeights(Formula *self, PetscInt order, PetscReal weight[][VBDF_FIELDS]) {
  PetscReal D[VBDF_POINTS], first[VBDF_POINTS] = {1};

  FormulaTakeFactor(self, order);
  LagrangeSlopes(order + 1, self->time, self->time[0], D);
  Weights(self, VBDF_FIELDS, order + 1, D, first, self->rho, self->ratio, weight);
  return order + 1;
}

/* The error of the first step is known when the second is taken: h^2 U[t0,t1,t2], h its length. */
static void AddFirst(const Formula *self, PetscInt fields, PetscReal weight[][VBDF_FIELDS]) {
  const PetscReal *t = self->time, first = PetscSqr(t[1] - t[2]);

  for (int j = 0; j < 3; j++)
    for (PetscInt f = 0; f < fields; f++)
      weight[j][f] += first / ((t[j] - t[(j + 1) % 3]) * (t[j] - t[(j + 2) % 3]));
}

/* FormulaErrorWeights - what the step to the new solution, by the formula of an order, adds to the
   error, as a combination of the points: their weights for each of a node's fields; returns how
   many points, of which there must be order + 1 past ones. */
PetscInt FormulaErrorWeights(Formula *self, PetscInt k, PetscInt fields,
                             PetscReal weight[][VBDF_FIELDS]) {
  PetscReal factor, along[VBDF_POINTS];

  FormulaTakeFactor(self, k);
  factor = (self->time[0] - self->time[1]) / (self->time[0] - self->time[k + 1]);
  LagrangeValues(k + 1, self->time + 1, self->time[0], along + 1);
  along[0] = factor;
  for (PetscInt j = 1; j <= k + 1; j++) along[j] *= -factor;
  Weights(self, fields, k + 2, along, NULL, NULL, self->ratio, weight);
  if (self->n == 2) AddFirst(self, fields, weight);
  return k + 2;
}
