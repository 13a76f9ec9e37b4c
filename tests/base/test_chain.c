/* The solver for chains gives what the matrix asks for: A x = b for the Jacobians of the models. */
#include "harness.h"
#include "base/chain.h"
#include "rod/rod.h"
#include <petscksp.h>

/* A matrix between that cannot be solved with is said to be so. */
static void Fail(KSP ksp, Mat J, Vec b, Vec y) {
  KSPConvergedReason reason;

  CHECK(MatZeroEntries(J));
  CHECK(KSPSetOperators(ksp, J, J));
  CHECK(KSPSolve(ksp, b, y));
  CHECK(KSPGetConvergedReason(ksp, &reason));
  EXPECT(reason < 0, "reason %d", (int)reason);
}

static void Solve(const RodModel *model, const char *options) {
  Scene scene;
  Rod rod;
  Node *nodes;
  Vec U, U_t, x, y, b;
  Mat J;
  KSP ksp;
  PC pc;
  PetscReal norm, error;
  SetOptions("-shape_amplitude 2 -rod_cells 40 -ts_max_time 2 %s", options);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, model, &rod));
  CHECK(PetscMalloc1(rod->end - rod->first, &nodes));
  CHECK(RodInitialNodes(rod, 0.7, nodes));
  CHECK(DMCreateGlobalVector(rod->da, &U));
  CHECK(model->set(rod, 0.7, nodes, U));
  CHECK(VecDuplicate(U, &U_t));
  CHECK(VecCopy(U, U_t)); /* growing in proportion */
  CHECK(PetscFree(nodes));
  CHECK(VecDuplicate(U, &x));
  CHECK(VecDuplicate(U, &y));
  CHECK(VecDuplicate(U, &b));
  CHECK(RodCreateMatrix(rod, &J));
  CHECK(KSPCreate(PETSC_COMM_WORLD, &ksp));
  CHECK(KSPSetType(ksp, KSPPREONLY));
  CHECK(KSPGetPC(ksp, &pc));
  CHECK(ChainSetType(pc, MATORDERINGNATURAL));
  for (int k = 0; k < 2; k++) { /* a second matrix in the same solver: nothing stale is used */
    if (k) Fail(ksp, J, b, y);
    PetscInt low, high;
    PetscScalar *a;
    CHECK(RodJacobian(NULL, 0.7, U, U_t, k ? 500 : 3, J, J, rod));
    CHECK(VecGetOwnershipRange(x, &low, &high));
    CHECK(VecGetArray(x, &a));
    for (PetscInt i = low; i < high; i++) a[i - low] = Scatter(7 + k, i);
    CHECK(VecRestoreArray(x, &a));
    CHECK(MatMult(J, x, b));
    CHECK(KSPSetOperators(ksp, J, J));
    CHECK(KSPSolve(ksp, b, y));
    CHECK(MatMult(J, y, U_t)); /* the residual */
    CHECK(VecAXPY(U_t, -1, b));
    CHECK(VecNorm(b, NORM_INFINITY, &norm));
    CHECK(VecNorm(U_t, NORM_INFINITY, &error));
    EXPECT(error < 1e-11 * norm, "%s %s: residual %g of %g", model->name, options, error, norm);
    CHECK(VecAXPY(y, -1, x));
    CHECK(VecNorm(y, NORM_INFINITY, &error));
    EXPECT(error < 1e-6, "%s %s: error %g", model->name, options, error);
    CHECK(VecCopy(U, U_t));
  }
  CHECK(KSPDestroy(&ksp));
  CHECK(MatDestroy(&J));
  CHECK(VecDestroy(&U));
  CHECK(VecDestroy(&U_t));
  CHECK(VecDestroy(&x));
  CHECK(VecDestroy(&y));
  CHECK(VecDestroy(&b));
  CHECK(RodDestroy(&rod));
  CHECK(SceneDestroy(&scene));
}

static void TestFrame(void **state) {
  Solve(&rod_frame, "");
  Solve(&rod_frame, "-rod_order 2");
  Solve(&rod_frame, "-growth_type gaussian -growth_width 0.05");
  Solve(&rod_frame, "-growth_type feed");
}

static void TestMixed(void **state) {
  Solve(&rod_mixed, "");
}

static void TestLinear(void **state) {
  Solve(&rod_linear, "");
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestFrame), cmocka_unit_test(TestMixed),
                                          cmocka_unit_test(TestLinear)};
MAIN(tests)
