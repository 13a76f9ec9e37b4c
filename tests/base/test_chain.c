/* The solver for chains gives what the matrix asks for: A x = b for the Jacobians of the models.
   test: chains of cells are solved | ranks 1 2 3 */
#include "harness.h"
#include "base/chain.h"
#include "rod/by_rate.h"
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
  RodState at;
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
    at = StateOf(0.7, U, U_t, k ? 500 : 3);
    CHECK(model->jacobian(rod, &at, J));
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

/* A rod that lies on itself, where each node sees those next to it and three of the other strand:
   its factors are hardly larger than it is. */
static void TestFolded(void **state) {
  enum { N = 120, BLOCK = 3 };
  PetscMPIInt ranks;
  MatInfo whole, factors;
  PetscReal values[BLOCK * BLOCK], ratio;
  Mat A, F;
  KSP ksp;
  PC pc;

  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1) return;
  CHECK(MatCreateSeqBAIJ(PETSC_COMM_SELF, BLOCK, N * BLOCK, N * BLOCK, 6, NULL, &A));
  for (PetscInt i = 0; i < N; i++)
    for (PetscInt j = 0; j < N; j++) {
      if (PetscAbsInt(i - j) > 1 && PetscAbsInt(i + j - N) > 1) continue;
      for (int k = 0; k < BLOCK * BLOCK; k++)
        values[k] =
            Scatter(i + 1, (j + 1) * BLOCK * BLOCK + k) + (i == j && k % (BLOCK + 1) == 0 ? 50 : 0);
      CHECK(MatSetValuesBlocked(A, 1, &i, 1, &j, values, INSERT_VALUES));
    }
  CHECK(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  CHECK(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  CHECK(KSPCreate(PETSC_COMM_SELF, &ksp));
  CHECK(KSPSetType(ksp, KSPPREONLY));
  CHECK(KSPGetPC(ksp, &pc));
  CHECK(ChainSetType(pc, ORDERING_HELD));
  CHECK(KSPSetOperators(ksp, A, A));
  CHECK(KSPSetUp(ksp));
  CHECK(PCFactorGetMatrix(pc, &F));
  CHECK(MatGetInfo(A, MAT_LOCAL, &whole));
  CHECK(MatGetInfo(F, MAT_LOCAL, &factors));
  ratio = factors.nz_used / whole.nz_used;
  EXPECT(ratio < 1.3, "the factors have %g times the entries", ratio);
  CHECK(KSPDestroy(&ksp));
  CHECK(MatDestroy(&A));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestFrame), cmocka_unit_test(TestMixed),
                                          cmocka_unit_test(TestLinear),
                                          cmocka_unit_test(TestFolded)};
MAIN(tests)
