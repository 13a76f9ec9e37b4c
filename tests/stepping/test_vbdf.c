/* The time stepper on problems with known solutions: orders 1 to 5 from a warm start, exactness for
   polynomials on uneven steps, error control, dense output; then the orders on a rod.
   test: steps have their orders, keep their error and meet known solutions | ranks 1 2 3 */
#include "harness.h"
#include "base/compat.h"
#include "base/chain.h"
#include "stepping/leg.h"
#include "stepping/vbdf.h"

/* Each rank holds one copy, shifted in time by its rank:
     y1' = -y2 + y1 (z - exp(-t)),  y2' = y1 + y2 (z - exp(-t)),  0 = y1^2 + y2^2 - 1,
     w' = -2 t w^2:
   index 2 in (y, z), y = (cos t, sin t), z = exp(-t), w = 1 / (1 + t^2). */
enum { Y1, Y2, Z, W, FIELDS };

static PetscReal Shift(void) {
  PetscMPIInt rank;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  return 0.3 * rank;
}

static PetscErrorCode Residual(TS ts, PetscReal t, Vec U, Vec U_t, Vec F, void *ctx) {
  const PetscScalar *u, *u_t;
  PetscScalar *f;
  PetscReal p = t + Shift(), pull;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(U, &u));
  PetscCall(VecGetArrayRead(U_t, &u_t));
  PetscCall(VecGetArray(F, &f));
  pull = u[Z] - PetscExpReal(-p);
  f[Y1] = u_t[Y1] + u[Y2] - u[Y1] * pull;
  f[Y2] = u_t[Y2] - u[Y1] - u[Y2] * pull;
  f[Z] = u[Y1] * u[Y1] + u[Y2] * u[Y2] - 1;
  f[W] = u_t[W] + 2 * p * u[W] * u[W];
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscCall(VecRestoreArrayRead(U_t, &u_t));
  PetscCall(VecRestoreArray(F, &f));
  PetscFunctionReturn(0);
}

static PetscErrorCode Jacobian(TS ts, PetscReal t, Vec U, Vec U_t, PetscReal shift, Mat J, Mat P,
                               void *ctx) {
  const PetscScalar *u;
  PetscReal p = t + Shift(), pull;
  PetscInt first, rows[FIELDS];

  PetscFunctionBegin;
  PetscCall(VecGetOwnershipRange(U, &first, NULL));
  for (int i = 0; i < FIELDS; i++) rows[i] = first + i;
  PetscCall(VecGetArrayRead(U, &u));
  pull = u[Z] - PetscExpReal(-p);
  PetscScalar a[FIELDS][FIELDS] = {{shift - pull, 1, -u[Y1], 0},
                                   {-1, shift - pull, -u[Y2], 0},
                                   {2 * u[Y1], 2 * u[Y2], 0, 0},
                                   {0, 0, 0, shift + 4 * p * u[W]}};
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscCall(MatSetValues(P, FIELDS, rows, FIELDS, rows, &a[0][0], INSERT_VALUES));
  PetscCall(MatAssemblyBegin(P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(P, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

static void Exact(PetscReal t, Vec U) {
  PetscReal p = t + Shift();
  PetscScalar *u;
  CHECK(VecGetArray(U, &u));
  u[Y1] = PetscCosReal(p);
  u[Y2] = PetscSinReal(p);
  u[Z] = PetscExpReal(-p);
  u[W] = 1 / (1 + p * p);
  CHECK(VecRestoreArray(U, &u));
}

/* y' = degree t^(degree - 1), y = t^degree */
static PetscInt degree;

static PetscErrorCode PowerResidual(TS ts, PetscReal t, Vec U, Vec U_t, Vec F, void *ctx) {
  PetscFunctionBegin;
  PetscCall(VecCopy(U_t, F));
  PetscCall(VecShift(F, -degree * PetscPowReal(t, degree - 1)));
  PetscFunctionReturn(0);
}

static PetscErrorCode PowerJacobian(TS ts, PetscReal t, Vec U, Vec U_t, PetscReal shift, Mat J,
                                    Mat P, void *ctx) {
  PetscInt low, high;

  PetscFunctionBegin;
  PetscCall(MatGetOwnershipRange(P, &low, &high));
  for (PetscInt i = low; i < high; i++) PetscCall(MatSetValue(P, i, i, shift, INSERT_VALUES));
  PetscCall(MatAssemblyBegin(P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(P, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

static void PowerExact(PetscReal t, Vec U) {
  CHECK(VecSet(U, PetscPowReal(t, degree)));
}

typedef struct {
  TS ts;
  Vec U, V;
  Mat J;
  void (*exact)(PetscReal t, Vec U);
} Problem;

static void CreateWith(PetscInt fields, TSIFunction residual, TSIJacobian jacobian, void *ctx,
                       Problem *p) {
  SNESLineSearch search;
  SNES snes;
  KSP ksp;
  PC pc;
  CHECK(VecCreateMPI(PETSC_COMM_WORLD, fields, PETSC_DETERMINE, &p->U));
  CHECK(VecDuplicate(p->U, &p->V));
  CHECK(MatCreateAIJ(PETSC_COMM_WORLD, fields, fields, PETSC_DETERMINE, PETSC_DETERMINE, fields,
                     NULL, 0, NULL, &p->J));
  CHECK(TSCreate(PETSC_COMM_WORLD, &p->ts));
  CHECK(TSSetIFunction(p->ts, NULL, residual, ctx));
  CHECK(TSSetIJacobian(p->ts, p->J, p->J, jacobian, ctx));
  CHECK(TSSetType(p->ts, TSVBDF));
  CHECK(TSSetExactFinalTime(p->ts, TS_EXACTFINALTIME_MATCHSTEP));
  CHECK(TSSetMaxSteps(p->ts, 100000));
  CHECK(TSGetSNES(p->ts, &snes));
  CHECK(SNESSetTolerances(snes, 1e-15, 1e-13, 1e-12, 20, 1000));
  CHECK(SNESGetLineSearch(snes, &search));
  CHECK(SNESLineSearchSetType(search, FULL_STEPS));
  CHECK(SNESGetKSP(snes, &ksp));
  CHECK(KSPSetType(ksp, KSPPREONLY));
  CHECK(KSPGetPC(ksp, &pc));
  CHECK(PCSetType(pc, PCBJACOBI)); /* each rank's block by LU: exact */
  CHECK(PetscOptionsInsertString(NULL, "-sub_ksp_type preonly -sub_pc_type lu "
                                       "-sub_pc_factor_shift_type nonzero"));
  CHECK(TSSetFromOptions(p->ts));
  CHECK(TSSetSolution(p->ts, p->U));
}

static void Create(PetscBool power, Problem *p) {
  CreateWith(FIELDS, power ? PowerResidual : Residual, power ? PowerJacobian : Jacobian, NULL, p);
  p->exact = power ? PowerExact : Exact;
}

static void Destroy(Problem *p) {
  CHECK(TSDestroy(&p->ts));
  CHECK(MatDestroy(&p->J));
  CHECK(VecDestroy(&p->U));
  CHECK(VecDestroy(&p->V));
}

/* Hands over n exact points, latest at t, spaced by h times 1, 1 + uneven, 1 + 2 uneven ... */
static void WarmStart(Problem *p, PetscReal t, PetscReal h, PetscReal uneven, PetscInt n) {
  PetscReal times[VBDF_POINTS];
  Vec points[VBDF_POINTS];
  for (PetscInt i = 0; i < n; i++) {
    times[i] = i ? times[i - 1] - h * (1 + (i - 1) * uneven) : t;
    CHECK(VecDuplicate(p->U, &points[i]));
    p->exact(times[i], points[i]);
  }
  p->exact(t, p->U);
  CHECK(TSSetTime(p->ts, t));
  CHECK(TSSetTimeStep(p->ts, h));
  CHECK(VBDFSetHistory(p->ts, n, times, points, n));
  for (PetscInt i = 0; i < n; i++) CHECK(VecDestroy(&points[i]));
}

/* Largest error of y and w, or of z, at time t in X. */
static PetscReal Error(Problem *p, PetscReal t, Vec X, PetscBool algebraic) {
  PetscReal error = 0;
  const PetscScalar *v;
  p->exact(t, p->V);
  CHECK(VecAXPY(p->V, -1, X));
  CHECK(VecGetArrayRead(p->V, &v));
  for (int f = 0; f < FIELDS; f++)
    if ((f == Z) == algebraic) error = PetscMax(error, PetscAbsReal(v[f]));
  CHECK(VecRestoreArrayRead(p->V, &v));
  return AllMax(error);
}

/* Errors at t = 3: of y and w, of z, and of y and w by dense output within the last step. */
static void RunFixed(PetscInt order, PetscReal h, PetscReal error[3]) {
  Problem p;
  Vec X;
  SetOptions("-ts_adapt_type none -ts_bdf_order %d", (int)order);
  Create(PETSC_FALSE, &p);
  WarmStart(&p, 1, h, 0, order);
  CHECK(TSSetMaxTime(p.ts, 3));
  CHECK(TSSolve(p.ts, p.U));
  error[0] = Error(&p, 3, p.U, PETSC_FALSE);
  error[1] = Error(&p, 3, p.U, PETSC_TRUE);
  CHECK(VecDuplicate(p.U, &X));
  CHECK(TSInterpolate(p.ts, 3 - 0.4 * h, X));
  error[2] = Error(&p, 3 - 0.4 * h, X, PETSC_FALSE);
  CHECK(VecDestroy(&X));
  Destroy(&p);
}

static void TestOrders(void **state) {
  for (PetscInt order = 1; order <= 5; order++) {
    PetscReal coarse[3], fine[3];
    RunFixed(order, 1. / 20, coarse);
    RunFixed(order, 1. / 40, fine);
    print_message("BDF%d: order %.2f (error %.1e), of the multiplier %.2f, dense output %.2f\n",
                  (int)order, Order(coarse[0], fine[0]), fine[0], Order(coarse[1], fine[1]),
                  Order(coarse[2], fine[2]));
    for (int k = 0; k < 3; k++) {
      PetscReal measured = Order(coarse[k], fine[k]);
      EXPECT(measured > order - 0.25 && (k == 1 || measured < order + 0.6),
             "BDF%d, error %d: order %g", (int)order, k, measured);
    }
    EXPECT(fine[2] < 1.5 * fine[0], "dense output %g, steps %g", fine[2], fine[0]);
  }
}

/* A formula of order k follows t^k exactly, its dense output too, on steps of any length. */
static void TestExactForPolynomials(void **state) {
  for (PetscInt order = 1; order <= 6; order++) {
    Problem p;
    PetscReal error, t, dense;
    Vec X;
    SetOptions("-ts_adapt_type none -ts_bdf_order %d", (int)order);
    degree = order;
    Create(PETSC_TRUE, &p);
    WarmStart(&p, 1, 0.1, 0.3, order);
    CHECK(VecDuplicate(p.U, &X));
    CHECK(TSSetMaxTime(p.ts, 10));
    for (int k = 0; k < 5; k++) {
      CHECK(TSSetTimeStep(p.ts, 0.1 * (1 + k % 3)));
      CHECK(TSStep(p.ts));
      CHECK(TSGetTime(p.ts, &t));
      error = Error(&p, t, p.U, PETSC_FALSE) / PetscPowReal(t, order);
      EXPECT(error < 1e-12, "BDF%d, step %d: %g", (int)order, k, error);
      CHECK(TSInterpolate(p.ts, t - 0.03, X));
      dense = Error(&p, t - 0.03, X, PETSC_FALSE) / PetscPowReal(t, order);
      EXPECT(dense < 1e-11, "BDF%d, dense output at step %d: %g", (int)order, k, dense);
    }
    CHECK(VecDestroy(&X));
    Destroy(&p);
  }
}

/* ---- fields with a factor: y_c = A(t) shape_c(t), beside one that has none, u = t^2 ---- */

/* u' = 2 t,  y1' = a y1 - turn y2,  y2' = turn y1 + a y2: a shape that turns, or stands if turn =
   0; log A = log_size - 30 t + square t^2 + cubic t^3, a its slope. */
enum { PLAIN, TURNS1, TURNS2, OF_THREE };
typedef struct {
  PetscReal square, cubic, turn, log_size;
} Turning;

static PetscReal LogFactor(const Turning *c, PetscReal t) {
  return c->log_size + t * (-30 + t * (c->square + t * c->cubic));
}

static PetscReal FactorSlope(const Turning *c, PetscReal t) {
  return -30 + t * (2 * c->square + t * 3 * c->cubic);
}

static PetscErrorCode TurningResidual(TS ts, PetscReal t, Vec U, Vec U_t, Vec F, void *ctx) {
  const Turning *c = (const Turning *)ctx;
  const PetscScalar *u, *u_t;
  PetscScalar *f;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(U, &u));
  PetscCall(VecGetArrayRead(U_t, &u_t));
  PetscCall(VecGetArray(F, &f));
  f[PLAIN] = u_t[PLAIN] - 2 * t;
  f[TURNS1] = u_t[TURNS1] - FactorSlope(c, t) * u[TURNS1] + c->turn * u[TURNS2];
  f[TURNS2] = u_t[TURNS2] - FactorSlope(c, t) * u[TURNS2] - c->turn * u[TURNS1];
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscCall(VecRestoreArrayRead(U_t, &u_t));
  PetscCall(VecRestoreArray(F, &f));
  PetscFunctionReturn(0);
}

static PetscErrorCode TurningJacobian(TS ts, PetscReal t, Vec U, Vec U_t, PetscReal shift, Mat J,
                                      Mat P, void *ctx) {
  const Turning *c = (const Turning *)ctx;
  PetscReal rate[VBDF_FACTORS], on;
  PetscInt rows[OF_THREE], first;

  PetscFunctionBegin;
  PetscCall(VBDFGetFactorRate(ts, rate));
  PetscCall(VecGetOwnershipRange(U, &first, NULL));
  for (int i = 0; i < OF_THREE; i++) rows[i] = first + i;
  on = shift + rate[0] - FactorSlope(c, t);
  PetscScalar a[OF_THREE][OF_THREE] = {{shift, 0, 0}, {0, on, c->turn}, {0, -c->turn, on}};
  PetscCall(MatSetValues(P, OF_THREE, rows, OF_THREE, rows, &a[0][0], INSERT_VALUES));
  PetscCall(MatAssemblyBegin(P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(P, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

static void TurningExact(const Turning *c, PetscReal t, PetscScalar u[OF_THREE]) {
  u[PLAIN] = t * t;
  u[TURNS1] = PetscExpReal(LogFactor(c, t)) * PetscCosReal(c->turn * t);
  u[TURNS2] = PetscExpReal(LogFactor(c, t)) * PetscSinReal(c->turn * t);
}

/* The largest error against the exact solution (of the rate: its slope), of the plain field in
   itself and of the others in parts of A. */
static void TurningErrors(const Turning *c, PetscReal t, Vec X, PetscBool rate,
                          PetscReal error[2]) {
  PetscScalar should[OF_THREE], u[OF_THREE], size = PetscExpReal(LogFactor(c, t));
  const PetscScalar *x;
  TurningExact(c, t, u);
  CHECK(PetscArraycpy(should, u, OF_THREE));
  if (rate) {
    should[PLAIN] = 2 * t;
    should[TURNS1] = FactorSlope(c, t) * u[TURNS1] - c->turn * u[TURNS2];
    should[TURNS2] = FactorSlope(c, t) * u[TURNS2] + c->turn * u[TURNS1];
  }
  CHECK(VecGetArrayRead(X, &x));
  error[0] = AllMax(PetscAbsReal(x[PLAIN] - should[PLAIN]));
  error[1] = AllMax(
      PetscMax(PetscAbsReal(x[TURNS1] - should[TURNS1]), PetscAbsReal(x[TURNS2] - should[TURNS2])) /
      size);
  CHECK(VecRestoreArrayRead(X, &x));
}

/* Steps of a fixed order from t = 0.4 to 1.6, over 16 decades, and the errors there; dense: of the
   dense output and its rate within the last step. */
static void RunTurning(const Turning *c, PetscInt order, PetscReal h, PetscReal uneven,
                       PetscReal error[2], PetscReal dense[2], PetscReal slope[2]) {
  const int factored[OF_THREE] = {0, 1, 1};
  PetscReal times[VBDF_POINTS], t = 0.4;
  PetscScalar *u;
  PetscBool done;
  Vec points[VBDF_POINTS], X, X_t;
  Problem p;
  SetOptions("-ts_adapt_type none -ts_bdf_order %d", (int)order);
  CreateWith(OF_THREE, TurningResidual, TurningJacobian, (void *)c, &p);
  CHECK(VBDFSetFactored(p.ts, OF_THREE, factored));
  for (PetscInt i = 0; i < PetscMax(order, 3); i++) {
    times[i] = i ? times[i - 1] - h * (1 + uneven * i) : t;
    CHECK(VecDuplicate(p.U, &points[i]));
    CHECK(VecGetArray(points[i], &u));
    TurningExact(c, times[i], u);
    CHECK(VecRestoreArray(points[i], &u));
  }
  CHECK(VecCopy(points[0], p.U));
  CHECK(TSSetTime(p.ts, t));
  CHECK(TSSetTimeStep(p.ts, h));
  CHECK(TSSetMaxTime(p.ts, 1.6));
  CHECK(VBDFSetHistory(p.ts, PetscMax(order, 3), times, points, order));
  for (PetscInt i = 0; i < PetscMax(order, 3); i++) CHECK(VecDestroy(&points[i]));
  for (int k = 0; t < 1.6 - 1e-9; k++) {
    CHECK(TSSetTimeStep(p.ts, PetscMin(h * (1 + uneven * (k % 3)), 1.6 - t)));
    CHECK(TSStep(p.ts));
    CHECK(TSGetTime(p.ts, &t));
  }
  TurningErrors(c, t, p.U, PETSC_FALSE, error);
  CHECK(VecDuplicate(p.U, &X));
  CHECK(VecDuplicate(p.U, &X_t));
  CHECK(VBDFInterpolate(p.ts, t - 0.4 * h, X, X_t, &done));
  TurningErrors(c, t - 0.4 * h, X, PETSC_FALSE, dense);
  TurningErrors(c, t - 0.4 * h, X_t, PETSC_TRUE, slope);
  CHECK(VecDestroy(&X));
  CHECK(VecDestroy(&X_t));
  Destroy(&p);
}

/* A shape that stands and a factor whose logarithm is a parabola (at order 1, a line): no error at
   any order, on steps of any length, in the dense output and its rate; a plain field beside it as
   ever. */
static void TestExactForExponentials(void **state) {
  for (PetscInt order = 1; order <= 6; order++) {
    const Turning stands = {order == 1 ? 0 : 4, 0, 0, 0};
    PetscReal error[2], dense[2], slope[2];
    RunTurning(&stands, order, 0.1, 0.3, error, dense, slope);
    EXPECT(error[1] < 1e-11 && dense[1] < 1e-11 && slope[1] < 1e-9, "BDF%d: %g, dense %g, rate %g",
           (int)order, error[1], dense[1], slope[1]);
    EXPECT(order == 1 || (error[0] < 1e-12 && dense[0] < 1e-12 && slope[0] < 1e-11),
           "BDF%d, plain: %g, dense %g, rate %g", (int)order, error[0], dense[0], slope[0]);
  }
}

/* The factor is taken from fields of any size that have all their digits: here they end at 3e-279.
 */
static void TestExactForTheSmallest(void **state) {
  const Turning stands = {4, 0, 0, log(1e-262)};
  PetscReal error[2], dense[2], slope[2];

  RunTurning(&stands, 2, 0.1, 0.3, error, dense, slope);
  EXPECT(error[1] < 1e-11, "%g", error[1]);
}

/* A shape that turns and a factor that is not a parabola's: the formulas keep their orders. */
static void TestOrdersWithFactor(void **state) {
  const Turning turns = {4, 1, 0.4, 0};
  for (PetscInt order = 1; order <= 6; order++) {
    PetscReal coarse[2], fine[2], dense[2][2], slope[2][2], measured;
    RunTurning(&turns, order, 0.04, 0, coarse, dense[0], slope[0]);
    RunTurning(&turns, order, 0.02, 0, fine, dense[1], slope[1]);
    measured = Order(coarse[1], fine[1]);
    print_message("BDF%d with a factor: error %.1e, order %.2f, dense output %.2f, rate %.2f\n",
                  (int)order, fine[1], measured, Order(dense[0][1], dense[1][1]),
                  Order(slope[0][1], slope[1][1]));
    EXPECT(measured > order - 0.25 && measured < order + 0.6, "BDF%d: order %g", (int)order,
           measured);
    EXPECT(Order(dense[0][1], dense[1][1]) > order - 0.25, "BDF%d: dense output", (int)order);
    EXPECT(Order(slope[0][1], slope[1][1]) > order - 0.25, "BDF%d: its rate", (int)order);
  }
}

/* A step that was cut by far leaves three points next to each other: what their polynomial says of
   the factor at points far behind them is no number, and steps go on all the same. */
static void TestFromCloseTogether(void **state) {
  const Turning c = {0, 0, 1, 0};
  const int factored[OF_THREE] = {0, 1, 1};
  const PetscReal times[] = {0.4, 0.4 - 1e-12, 0.4 - 2e-12, 0.35, 0.3}, end = 1;
  enum { POINTS = sizeof(times) / sizeof(times[0]) };
  PetscReal error[2];
  PetscScalar *u;
  Vec points[POINTS];
  Problem p;
  SetOptions("-ts_adapt_type basic");
  CreateWith(OF_THREE, TurningResidual, TurningJacobian, (void *)&c, &p);
  CHECK(VBDFSetFactored(p.ts, OF_THREE, factored));
  for (PetscInt i = 0; i < POINTS; i++) {
    CHECK(VecDuplicate(p.U, &points[i]));
    CHECK(VecGetArray(points[i], &u));
    TurningExact(&c, times[i], u);
    CHECK(VecRestoreArray(points[i], &u));
  }
  CHECK(VecCopy(points[0], p.U));
  CHECK(TSSetTolerances(p.ts, 0, NULL, 1e-6, NULL));
  CHECK(TSSetTime(p.ts, times[0]));
  CHECK(TSSetTimeStep(p.ts, 1e-11));
  CHECK(TSSetMaxTime(p.ts, end));
  CHECK(TSSetMaxSNESFailures(p.ts, -1));
  CHECK(VBDFSetHistory(p.ts, POINTS, times, points, 2));
  for (PetscInt i = 0; i < POINTS; i++) CHECK(VecDestroy(&points[i]));
  CHECK(TSSolve(p.ts, p.U));
  TurningErrors(&c, end, p.U, PETSC_FALSE, error);
  EXPECT(error[0] < 1e-5 && error[1] < 1e-4, "errors %g, %g", error[0], error[1]);
  Destroy(&p);
}

/* From two points; only y and w are under control, as in tendril. */
static PetscReal RunAdaptive(PetscReal rtol, PetscInt *steps) {
  Problem p;
  Vec tolerance, none;
  PetscScalar *a;
  PetscReal error;
  SetOptions("-ts_adapt_type basic");
  Create(PETSC_FALSE, &p);
  CHECK(VecDuplicate(p.U, &tolerance));
  CHECK(VecDuplicate(p.U, &none));
  CHECK(VecGetArray(tolerance, &a));
  for (int f = 0; f < FIELDS; f++) a[f] = f == Z ? -1 : rtol;
  CHECK(VecRestoreArray(tolerance, &a));
  CHECK(TSSetTolerances(p.ts, rtol, tolerance, 0, none));
  WarmStart(&p, 0, 1e-3, 0, 2);
  CHECK(TSSetMaxSNESFailures(p.ts, -1));
  CHECK(TSSetMaxTime(p.ts, 3));
  CHECK(TSSolve(p.ts, p.U));
  CHECK(TSGetStepNumber(p.ts, steps));
  error = Error(&p, 3, p.U, PETSC_FALSE);
  CHECK(VecDestroy(&tolerance));
  CHECK(VecDestroy(&none));
  Destroy(&p);
  return error;
}

static void TestAdaptive(void **state) {
  PetscReal before = 1;
  for (PetscReal rtol = 1e-4; rtol > 1e-11; rtol *= 1e-2) {
    PetscInt steps;
    PetscReal error = RunAdaptive(rtol, &steps);
    print_message("tolerance %.0e: error %.1e in %d steps\n", rtol, error, (int)steps);
    EXPECT(error < 20 * rtol, "tolerance %g: error %g", rtol, error);
    EXPECT(error < 0.1 * before, "tolerance %g: error %g, before %g", rtol, error, before);
    EXPECT(steps < 40 * PetscPowReal(rtol, -1. / 6), "tolerance %g: %d steps", rtol, (int)steps);
    before = error;
  }
}

/* The least that a step is of the one before it. */
static PetscReal before_last, last_step, least_part;

static PetscErrorCode NoteStep(TS ts) {
  PetscReal t;

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &t));
  if (last_step > 0) least_part = PetscMin(least_part, (t - before_last) / last_step);
  last_step = t - before_last;
  before_last = t;
  PetscFunctionReturn(0);
}

/* Wherever the end is: the last steps share what is left, so that none is a sliver, whose rates
   would be all round-off; and fixed steps that end there all but exactly are as many as they should
   be. */
static void TestEnd(void **state) {
  for (int k = 0; k < 20; k++) {
    Problem p;
    SetOptions("-ts_adapt_type basic");
    Create(PETSC_FALSE, &p);
    CHECK(TSSetTolerances(p.ts, 1e-5, NULL, 1e-5, NULL));
    WarmStart(&p, 0, 1e-2, 0, 2);
    CHECK(TSSetMaxSNESFailures(p.ts, -1));
    CHECK(TSSetMaxTime(p.ts, 2 + 0.037 * k));
    CHECK(TSSetPostStep(p.ts, NoteStep));
    before_last = last_step = 0;
    least_part = 1;
    CHECK(TSSolve(p.ts, p.U));
    EXPECT(least_part > 0.3, "to %g: a step %g of the one before", 2 + 0.037 * k, least_part);
    Destroy(&p);
  }
  for (int n = 10; n < 100; n += 7) {
    PetscInt steps;
    Problem p;
    SetOptions("-ts_adapt_type none -ts_bdf_order 1");
    Create(PETSC_FALSE, &p);
    WarmStart(&p, 0, 1. / n, 0, 2);
    CHECK(TSSetTimeStep(p.ts, 1. / n));
    CHECK(TSSetMaxTime(p.ts, 1));
    CHECK(TSSolve(p.ts, p.U));
    CHECK(TSGetStepNumber(p.ts, &steps));
    EXPECT(steps == n, "%d steps of 1/%d", (int)steps, n);
    Destroy(&p);
  }
}

/* Times at which a step has to end: so many that sums of steps do not all meet them by chance. */
enum { MEETINGS = 40 };
static int met;

static PetscReal Meeting(int k) {
  return PETSC_PI / 80 * (k + 1);
}

static PetscReal NextMeeting(TS ts, PetscReal t) {
  (void)ts;
  for (int k = 0; k < MEETINGS; k++)
    if (Meeting(k) > t) return Meeting(k);
  return PETSC_MAX_REAL;
}

static PetscErrorCode NoteMeeting(TS ts) {
  PetscReal t;

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &t));
  for (int k = 0; k < MEETINGS; k++) met += t == Meeting(k);
  PetscFunctionReturn(0);
}

/* A step ends at each of them, to the bit; steps are long again behind them. */
static void TestMeetings(void **state) {
  PetscInt steps[2];

  for (int k = 0; k < 2; k++) {
    Problem p;
    SetOptions("-ts_adapt_type basic");
    Create(PETSC_FALSE, &p);
    CHECK(TSSetTolerances(p.ts, 1e-5, NULL, 1e-5, NULL));
    WarmStart(&p, 0, 1e-2, 0, 2);
    CHECK(TSSetMaxSNESFailures(p.ts, -1));
    CHECK(TSSetMaxTime(p.ts, 2));
    CHECK(TSSetPostStep(p.ts, NoteMeeting));
    if (k) CHECK(VBDFSetNextEnd(p.ts, NextMeeting));
    met = 0;
    CHECK(TSSolve(p.ts, p.U));
    CHECK(TSGetStepNumber(p.ts, &steps[k]));
    EXPECT(met == k * MEETINGS, "%d of %d are met", met, MEETINGS);
    if (k) EXPECT(Error(&p, 2, p.U, PETSC_FALSE) < 1e-3, "is off");
    Destroy(&p);
  }
  EXPECT(steps[1] < steps[0] + 2 * MEETINGS, "%d steps for %d", (int)steps[1], (int)steps[0]);
}

/* What is handed out is what was handed in, moved on by the steps between. */
static void TestHistory(void **state) {
  PetscReal times[VBDF_POINTS], norm;
  Vec points[VBDF_POINTS];
  PetscInt n, order;
  Problem p;
  SetOptions("-ts_adapt_type none -ts_bdf_order 3");
  Create(PETSC_FALSE, &p);
  WarmStart(&p, 1, 0.1, 0.5, 4);
  CHECK(TSSetMaxTime(p.ts, 10));
  CHECK(TSSetTimeStep(p.ts, 0.2));
  CHECK(TSStep(p.ts));
  CHECK(VBDFGetHistory(p.ts, &n, times, points, &order));
  EXPECT(n == 5 && order == 3, "%d points, order %d", (int)n, (int)order);
  for (int i = 0; i < 4; i++) {
    const PetscReal should[4] = {0, -0.2, -0.3, -0.45};
    EXPECT(PetscAbsReal(times[i] - should[i]) < 1e-14, "point %d at %g", i, times[i]);
    EXPECT(Error(&p, 1.2 + times[i], points[i], PETSC_FALSE) < (i ? 1e-15 : 1e-3), "point %d", i);
  }
  CHECK(VecCopy(points[0], p.V));
  CHECK(VecAXPY(p.V, -1, p.U));
  CHECK(VecNorm(p.V, NORM_INFINITY, &norm));
  EXPECT(norm == 0, "the latest point is not the solution, by %g", norm);
  Destroy(&p);
}

/* ---- on a rod: the dry rod of length 2, at t = 2 ---- */

typedef struct {
  Scene scene;
  Leg leg;
  PetscReal h; /* of the history to be taken at warm - i h */
  PetscInt taken;
  Vec point[VBDF_POINTS];
} Run;
static const PetscReal warm = 1;

/* Takes the points that the warm start needs, oldest (index 5) first, by dense output. */
static PetscErrorCode TakePoints(TS ts) {
  PetscReal t;
  Leg *leg;
  Run *run;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  run = (Run *)leg->owner;
  PetscCall(TSGetTime(ts, &t));
  while (run->h > 0 && run->taken < 6 && warm - (5 - run->taken) * run->h <= t * (1 + 1e-14)) {
    PetscReal at = warm - (5 - run->taken) * run->h;
    PetscCall(VecDuplicate(leg->U, &run->point[5 - run->taken]));
    PetscCall(TSInterpolate(ts, at, run->point[5 - run->taken]));
    run->taken++;
  }
  PetscFunctionReturn(0);
}

static void RunCreate(const char *options, PetscReal rtol, PetscReal h, Run *run) {
  Node *nodes;
  *run = (Run){.h = h};
  SetOptions("-growth_initial_length 2 -shape_amplitude 0.1 -friction_beta 0.05 -rod_cells 20 "
             "-ts_max_time 3 %s",
             options);
  CHECK(SceneCreate(&run->scene));
  CHECK(LegCreate(run->scene, &rod_frame, rtol, &run->leg));
  run->leg.owner = run;
  CHECK(TSSetPostStep(run->leg.ts, TakePoints));
  CHECK(TSSetTimeStep(run->leg.ts, 1e-5));
  CHECK(PetscMalloc1(run->leg.rod->end - run->leg.rod->first, &nodes));
  CHECK(RodInitialNodes(run->leg.rod, 0, nodes));
  CHECK(rod_frame.set(run->leg.rod, 0, nodes, run->leg.U));
  CHECK(PetscFree(nodes));
}

static void RunDestroy(Run *run) {
  for (int i = 0; i < VBDF_POINTS; i++) CHECK(VecDestroy(&run->point[i]));
  CHECK(LegDestroy(&run->leg));
  CHECK(SceneDestroy(&run->scene));
}

/* Largest difference of x and theta. */
static PetscReal Difference(Run *run, Vec A, Vec B) {
  PetscReal size[MAX_FIELDS];
  Vec D;
  CHECK(VecDuplicate(A, &D));
  CHECK(VecWAXPY(D, -1, A, B));
  CHECK(RodFieldSizes(run->leg.rod, D, size));
  CHECK(VecDestroy(&D));
  return PetscMax(size[0], PetscMax(size[1], size[2]));
}

static void TestOrdersOnRod(void **state) {
  const PetscReal steps[2] = {0.1, 0.05}, end = 2;
  Run tight[2];
  for (int k = 0; k < 2; k++) {
    RunCreate("", 1e-11, steps[k], &tight[k]);
    CHECK(TSSetMaxTime(tight[k].leg.ts, end));
    CHECK(TSSolve(tight[k].leg.ts, tight[k].leg.U));
    EXPECT(tight[k].taken == 6, "%d points", (int)tight[k].taken);
  }
  for (PetscInt order = 1; order <= 6; order++) {
    PetscReal error[2], measured;
    for (int k = 0; k < 2; k++) {
      char options[64];
      PetscReal times[6];
      Run run;
      snprintf(options, sizeof(options), "-ts_adapt_type none -ts_bdf_order %d", (int)order);
      RunCreate(options, 1e-11, 0, &run);
      for (int i = 0; i < 6; i++) times[i] = warm - i * steps[k];
      CHECK(VecCopy(tight[k].point[0], run.leg.U));
      CHECK(TSSetTime(run.leg.ts, warm));
      CHECK(TSSetTimeStep(run.leg.ts, steps[k]));
      CHECK(TSSetMaxTime(run.leg.ts, end));
      CHECK(VBDFSetHistory(run.leg.ts, order, times, tight[k].point, order));
      CHECK(TSSolve(run.leg.ts, run.leg.U));
      error[k] = Difference(&run, run.leg.U, tight[1].leg.U);
      RunDestroy(&run);
    }
    measured = Order(error[0], error[1]);
    print_message("BDF%d on the rod: error %.1e, order %.2f\n", (int)order, error[1], measured);
    EXPECT(measured > order - 0.3 && measured < order + 0.7, "BDF%d: errors %g %g, order %g",
           (int)order, error[0], error[1], measured);
  }
  for (int k = 0; k < 2; k++) RunDestroy(&tight[k]);
}

/* y = sin t and, from t = 0.3 on, 1 more: one jump, and nothing special behind it; or a kink there,
   which is none; or there y is 1, and before it what is as good as nothing: an error whose square
   is no number any more; or a fourth root is added that sets in at 0: the error of a first step, a
   square, falls like the root of the step, and that is no jump. */
enum { JUMP, KINK, FROM_NOTHING, ROOT };
static const PetscReal nothing = 1e-290;

static PetscReal Way(int kind, PetscReal t) {
  if (kind == FROM_NOTHING) return t > 0.3 ? 1 : nothing;
  if (kind == ROOT) return PetscSinReal(t) + PetscSqrtReal(PetscSqrtReal(t));
  return PetscSinReal(t) + (kind == KINK ? 5 * PetscMax(0, t - 0.3) : t > 0.3);
}

static PetscErrorCode Broken(TS ts, PetscReal t, Vec U, Vec V, Vec F, void *ctx) {
  const PetscScalar *y;
  PetscScalar *f;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(U, &y));
  PetscCall(VecGetArray(F, &f));
  f[0] = y[0] - Way(*(int *)ctx, t);
  PetscCall(VecRestoreArray(F, &f));
  PetscCall(VecRestoreArrayRead(U, &y));
  PetscFunctionReturn(0);
}

static PetscErrorCode BrokenSlope(TS ts, PetscReal t, Vec U, Vec V, PetscReal shift, Mat J, Mat P,
                                  void *ctx) {
  PetscFunctionBegin;
  PetscCall(MatSetValue(J, 0, 0, 1, INSERT_VALUES));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* The first step is judged by a guess, as on the rod: else a jump passes in one unseen. */
static PetscErrorCode Stay(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1, void *ctx) {
  PetscFunctionBegin;
  PetscCall(VecCopy(U0, U1));
  PetscFunctionReturn(0);
}

/* A tolerance relative to what y is when a step begins. */
static PetscErrorCode RelativeToStart(TS ts) {
  Vec U, tolerance, none;

  PetscFunctionBegin;
  PetscCall(TSGetSolution(ts, &U));
  PetscCall(VecDuplicate(U, &tolerance));
  PetscCall(VecDuplicate(U, &none));
  PetscCall(VecCopy(U, tolerance));
  PetscCall(VecAbs(tolerance));
  PetscCall(VecScale(tolerance, 1e-6));
  PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, tolerance, PETSC_DEFAULT, none));
  PetscCall(VecDestroy(&tolerance));
  PetscCall(VecDestroy(&none));
  PetscFunctionReturn(0);
}

/* most: of rejected steps. (A jump is seen in the second error that does not fall, long before the
   step has shrunk to where no error has to.) */
static void Jump(int kind, PetscInt most) {
  const PetscReal tolerance = kind == ROOT ? 1e-3 : 1e-6;
  TSConvergedReason reason;
  PetscInt jumps, steps, rejected;
  const PetscScalar *y;
  Mat J;
  Vec U;
  TS ts;

  SetOptions("-snes_linesearch_type " FULL_STEPS " -pc_type lu -ksp_type preonly -snes_rtol 1e-12 "
             "-snes_atol 1e-12");
  CHECK(VecCreateSeq(PETSC_COMM_SELF, 1, &U));
  CHECK(VecSet(U, Way(kind, 0)));
  CHECK(MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &J));
  CHECK(TSCreate(PETSC_COMM_SELF, &ts));
  CHECK(TSSetType(ts, TSVBDF));
  CHECK(TSSetIFunction(ts, NULL, Broken, &kind));
  CHECK(TSSetIJacobian(ts, J, J, BrokenSlope, NULL));
  CHECK(TSSetTolerances(ts, tolerance, NULL, tolerance, NULL));
  CHECK(TSSetTimeStep(ts, kind == ROOT ? 0.1 : 1e-6));
  CHECK(TSSetMaxTime(ts, 1));
  CHECK(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  CHECK(TSSetMaxSNESFailures(ts, -1));
  CHECK(TSSetMaxStepRejections(ts, 60));
  CHECK(TSSetErrorIfStepFails(ts, PETSC_FALSE));
  CHECK(VBDFSetGuess(ts, Stay, NULL));
  if (kind == FROM_NOTHING) CHECK(TSSetPreStep(ts, RelativeToStart));
  CHECK(TSSetFromOptions(ts));
  CHECK(TSSolve(ts, U));
  CHECK(TSGetConvergedReason(ts, &reason));
  CHECK(VBDFGetJumps(ts, &jumps));
  CHECK(TSGetStepNumber(ts, &steps));
  CHECK(VecGetArrayRead(U, &y));
  CHECK(TSGetStepRejections(ts, &rejected));
  print_message("%d jumps, %d steps, %d rejected, y %.10g, %s\n", (int)jumps, (int)steps,
                (int)rejected, (double)y[0], TSConvergedReasons[reason]);
  EXPECT(reason > 0 && jumps == (kind == JUMP || kind == FROM_NOTHING), "%d jumps", (int)jumps);
  EXPECT(rejected <= most, "%d rejected, at most %d", (int)rejected, (int)most);
  EXPECT(PetscAbsReal(y[0] - Way(kind, 1)) < 1e-9, "y %.12g", (double)y[0]);
  CHECK(VecRestoreArrayRead(U, &y));
  CHECK(TSDestroy(&ts));
  CHECK(MatDestroy(&J));
  CHECK(VecDestroy(&U));
}

static void TestJump(void **state) {
  Jump(JUMP, 10);
  Jump(KINK, 18);
  Jump(FROM_NOTHING, 4);
  Jump(ROOT, 24);
}

/* y' = 1e8 (1 - y): a layer of 1e-8. */
static const PetscReal fast = 1e8;

static PetscErrorCode Decaying(TS ts, PetscReal t, Vec U, Vec U_t, Vec F, void *ctx) {
  PetscFunctionBegin;
  PetscCall(VecCopy(U, F));
  PetscCall(VecShift(F, -1));
  PetscCall(VecAYPX(F, fast, U_t));
  PetscFunctionReturn(0);
}

static PetscErrorCode DecayingSlope(TS ts, PetscReal t, Vec U, Vec U_t, PetscReal shift, Mat J,
                                    Mat P, void *ctx) {
  PetscFunctionBegin;
  PetscCall(MatSetValue(J, 0, 0, shift + fast, INSERT_VALUES));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* A layer that is 1e-13 of a run's end is crossed blind; of the time that it is about, it is seen.
 */
static void TestScale(void **state) {
  for (int k = 0; k < 2; k++) {
    PetscInt jumps;
    Mat J;
    Vec U;
    TS ts;
    SetOptions("-pc_type lu -ksp_type preonly -snes_type ksponly");
    CHECK(VecCreateSeq(PETSC_COMM_SELF, 1, &U));
    CHECK(VecSet(U, 2));
    CHECK(MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &J));
    CHECK(TSCreate(PETSC_COMM_SELF, &ts));
    CHECK(TSSetType(ts, TSVBDF));
    CHECK(TSSetIFunction(ts, NULL, Decaying, NULL));
    CHECK(TSSetIJacobian(ts, J, J, DecayingSlope, NULL));
    CHECK(TSSetTolerances(ts, 1e-6, NULL, 1e-6, NULL));
    CHECK(TSSetTimeStep(ts, 5e-10));
    CHECK(TSSetMaxTime(ts, 1e4));
    CHECK(TSSetMaxStepRejections(ts, 60));
    CHECK(VBDFSetGuess(ts, Stay, NULL));
    if (k) CHECK(VBDFSetScale(ts, 1));
    CHECK(TSSetFromOptions(ts));
    CHECK(TSSolve(ts, U));
    CHECK(VBDFGetJumps(ts, &jumps));
    EXPECT(k ? jumps == 0 : jumps > 0, "%d steps not seen", (int)jumps);
    CHECK(TSDestroy(&ts));
    CHECK(MatDestroy(&J));
    CHECK(VecDestroy(&U));
  }
}

/* A law that begins so late. */
static const PetscReal late = 1e4;

static PetscErrorCode StretchLate(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                  PetscReal *g_t, PetscReal *g_s) {
  Growth law = (Growth)self->data;
  return law->stretch(law, s, t - late, g, g_t, g_s);
}

static PetscErrorCode ArcLate(Growth self, PetscReal s, PetscReal t, PetscReal *p, PetscReal *p_t) {
  Growth law = (Growth)self->data;
  return law->arc(law, s, t - late, p, p_t);
}

static PetscReal SlideLate(Growth self, PetscReal s, PetscReal t) {
  Growth law = (Growth)self->data;
  return law->slide(law, s, t - late);
}

static PetscReal SpeedLate(Growth self, PetscReal s, PetscReal t) {
  Growth law = (Growth)self->data;
  return law->speed(law, s, t - late);
}

static PetscReal StrainLate(Growth self, PetscReal s, PetscReal t) {
  Growth law = (Growth)self->data;
  return law->strain(law, s, t - late);
}

/* Steps and iterations of a rod that is fed to the brink of a snap, from a time on; its tip at the
   end. */
static void Brink(PetscReal from, PetscInt count[2], PetscReal *tip) {
  struct _Growth law;
  Growth begun;
  TSConvergedReason reason;
  Node *nodes;
  Scene scene;
  Leg leg;

  SetOptions("-growth_type feed -shape_type sag -growth_initial_length 0.764 -shape_amplitude "
             "0.0166 -friction_beta 1.09e-6 -ts_max_time 1.33 -tip_force 3.154 -rod_cells 100");
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &rod_frame, 1.05e-6, &leg));
  CHECK(RodBegin(leg.rod, leg.U));
  begun = scene->growth;
  law = *begun;
  law.data = begun;
  law.stretch = StretchLate;
  law.arc = ArcLate;
  law.slide = SlideLate;
  law.speed = SpeedLate;
  law.strain = StrainLate;
  if (from > 0) scene->growth = &law;
  CHECK(TSSetTime(leg.ts, from));
  CHECK(TSSetMaxTime(leg.ts, from + scene->end_time));
  CHECK(TSSolve(leg.ts, leg.U));
  CHECK(TSGetConvergedReason(leg.ts, &reason));
  EXPECT(reason > 0, "from t = %g: %s", (double)from, TSConvergedReasons[reason]);
  CHECK(TSGetStepNumber(leg.ts, &count[0]));
  CHECK(TSGetSNESIterations(leg.ts, &count[1]));
  CHECK(PetscMalloc1(leg.rod->end - leg.rod->first, &nodes));
  CHECK(rod_frame.get(leg.rod, from + scene->end_time, leg.U, NULL, nodes));
  *tip = -PETSC_MAX_REAL;
  if (leg.rod->end == leg.rod->last + 1) *tip = nodes[leg.rod->last - leg.rod->first].x[1];
  *tip = AllMax(*tip);
  CHECK(PetscFree(nodes));
  scene->growth = begun;
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
}

/* Late in a run a snap takes the steps that it takes in its beginning, though these may be so short
   that the time has hardly room for them. */
static void TestLate(void **state) {
  PetscInt count[2][2];
  PetscReal tip[2];

  for (int k = 0; k < 2; k++) Brink(k * late, count[k], &tip[k]);
  print_message("%d steps, %d iterations; from t = 1e4 on %d, %d\n", (int)count[0][0],
                (int)count[0][1], (int)count[1][0], (int)count[1][1]);
  for (int k = 0; k < 2; k++)
    EXPECT(PetscAbsInt(count[1][k] - count[0][k]) <= count[0][k] / 10, "%d and %d",
           (int)count[0][k], (int)count[1][k]);
  EXPECT(PetscAbsReal(tip[1] - tip[0]) < 1e-5, "tip at %g and %g", (double)tip[0], (double)tip[1]);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestOrders),
                                          cmocka_unit_test(TestExactForPolynomials),
                                          cmocka_unit_test(TestExactForExponentials),
                                          cmocka_unit_test(TestExactForTheSmallest),
                                          cmocka_unit_test(TestOrdersWithFactor),
                                          cmocka_unit_test(TestFromCloseTogether),
                                          cmocka_unit_test(TestAdaptive),
                                          cmocka_unit_test(TestEnd),
                                          cmocka_unit_test(TestMeetings),
                                          cmocka_unit_test(TestHistory),
                                          cmocka_unit_test(TestOrdersOnRod),
                                          cmocka_unit_test(TestJump),
                                          cmocka_unit_test(TestScale),
                                          cmocka_unit_test(TestLate)};
MAIN(tests)
