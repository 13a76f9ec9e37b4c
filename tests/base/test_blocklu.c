/* LU of blocks: a line of nodes, some of which touch others far away, in the plane and in space.
   test: a line of nodes that touch far away is solved */
#include "base/blocklu.h"
#include "harness.h"

enum { NODES = 70, MOST = 21 };

static PetscReal dense[NODES * MOST][NODES * MOST]; /* what the matrix is to be */

static void SetBlock(Mat J, PetscInt fields, PetscInt i, PetscInt j, PetscReal more) {
  PetscScalar v[MOST * MOST];

  for (PetscInt a = 0; a < fields; a++)
    for (PetscInt b = 0; b < fields; b++)
      dense[i * fields + a][j * fields + b] += v[a * fields + b] =
          Scatter(i * NODES + j, a * fields + b) + (a == b ? more : 0);
  CHECK(MatSetValuesBlocked(J, 1, &i, 1, &j, v, ADD_VALUES));
}

/* A line; of the pairs that touch, two of which are neighbours, those from `first` on. The last
   node's own block is 0 if it is held. */
static void Fill(Mat J, PetscInt fields, PetscBool held, PetscInt first) {
  static const PetscInt touch[][2] = {{3, 40},  {4, 41}, {12, 60}, {0, 69},
                                      {30, 33}, {5, 40}, {50, 51}};

  CHECK(MatZeroEntries(J));
  memset(dense, 0, sizeof(dense));
  for (PetscInt i = 0; i < NODES; i++)
    for (PetscInt j = PetscMax(0, i - 1); j < PetscMin(NODES, i + 2); j++)
      if (!held || i < NODES - 1 || j < i) SetBlock(J, fields, i, j, i == j ? fields / 2. : 0);
  for (size_t k = (size_t)first; k < PETSC_STATIC_ARRAY_LENGTH(touch); k++)
    for (int turn = 0; turn < 2; turn++) SetBlock(J, fields, touch[k][turn], touch[k][1 - turn], 0);
  CHECK(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  CHECK(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
}

/* By how much the solution, or the product with it, is off. */
static PetscReal Left(KSP ksp, Mat J, Vec X, Vec B, Vec R) {
  const PetscScalar *x, *b, *r;
  PetscReal norm = 0;
  PetscInt n;

  CHECK(KSPSetOperators(ksp, J, J));
  CHECK(KSPSolve(ksp, B, X));
  CHECK(MatMult(J, X, R));
  CHECK(VecGetSize(X, &n));
  CHECK(VecGetArrayRead(X, &x));
  CHECK(VecGetArrayRead(B, &b));
  CHECK(VecGetArrayRead(R, &r));
  for (PetscInt i = 0; i < n; i++) {
    PetscReal sum = 0;
    for (PetscInt j = 0; j < n; j++) sum += dense[i][j] * x[j];
    norm = PetscMax(norm, PetscMax(PetscAbsReal(sum - b[i]), PetscAbsReal(sum - r[i])));
  }
  CHECK(VecRestoreArrayRead(R, &r));
  CHECK(VecRestoreArrayRead(B, &b));
  CHECK(VecRestoreArrayRead(X, &x));
  return norm;
}

/* late: so many nodes are left to the end, one of them with no block of its own. */
static void Solve(PetscInt fields, PetscInt late) {
  const PetscBool held = (PetscBool)(late > 0);
  KSPConvergedReason reason;
  PetscReal first = 0;
  Vec x, b, r;
  const PetscInt nodes[] = {NODES - 1, 0, NODES / 2};
  PetscInt n;
  Mat J;
  KSP ksp;

  CHECK(BlockLUCreate(NODES, fields, late, nodes, &J));
  CHECK(MatCreateVecs(J, &x, &b));
  CHECK(VecDuplicate(b, &r));
  CHECK(VecGetSize(b, &n));
  for (PetscInt i = 0; i < n; i++) CHECK(VecSetValue(b, i, Scatter(5, i), INSERT_VALUES));
  CHECK(VecAssemblyBegin(b));
  CHECK(VecAssemblyEnd(b));
  CHECK(KSPCreate(PETSC_COMM_SELF, &ksp));
  CHECK(BlockLUSetSolver(ksp));
  for (PetscInt k = 0; k < 4; k++) { /* others touch; and once more the same */
    PetscReal norm;
    Fill(J, fields, held, k % 3);
    norm = Left(ksp, J, x, b, r);
    EXPECT(norm < 1e-10, "%d fields: %g is left", (int)fields, norm);
    CHECK(VecNorm(x, NORM_2, &norm));
    if (k == 0) first = norm;
    EXPECT(k != 3 || norm == first, "the same blocks give %.17g and %.17g", first, norm);
  }
  CHECK(MatZeroEntries(J)); /* no solution, and it is said */
  CHECK(KSPSetOperators(ksp, J, J));
  CHECK(KSPSolve(ksp, b, x));
  CHECK(KSPGetConvergedReason(ksp, &reason));
  EXPECT(reason < 0, "reason %d", (int)reason);
  CHECK(KSPDestroy(&ksp));
  CHECK(MatDestroy(&J));
  CHECK(VecDestroy(&x));
  CHECK(VecDestroy(&b));
  CHECK(VecDestroy(&r));
}

static void TestSolve(void **state) {
  static const PetscInt fields[] = {6, 8, 10, 13, 17, 21};

  EXPECT(!BlockLUCan(NODES, 7), "there are none of 7");
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(fields); k++) {
    EXPECT(BlockLUCan(NODES, fields[k]), "there are blocks of %d", (int)fields[k]);
    for (int late = 0; late < 4; late++) Solve(fields[k], late);
  }
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestSolve)};
MAIN(tests)
