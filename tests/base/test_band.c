/* Banded matrices: solved, with their transpose, too; refused where they are singular, or, shifted
   to an eigenvalue, solved along its vector.
   test: banded matrices are solved, also transposed and beside an eigenvalue */
#include "harness.h"
#include "base/band.h"

enum { N = 7 };

/* The second differences of n values that are held at both ends, minus a shift. */
static void Chain(PetscReal shift, Band *A) {
  CHECK(BandCreate(N, 1, 1, A));
  for (PetscInt i = 0; i < N; i++)
    for (PetscInt j = PetscMax(0, i - 1); j < PetscMin(N, i + 2); j++)
      *BandAt(A, i, j) = i == j ? 2 - shift : j > i ? -1 : -0.5;
}

static void TestSolve(void **state) {
  for (int transpose = 0; transpose < 2; transpose++) {
    PetscReal x[N], b[N];
    Band A;
    Chain(0.3, &A);
    for (PetscInt i = 0; i < N; i++) x[i] = PetscSinReal(2. * i + 1);
    for (PetscInt i = 0; i < N; i++) {
      b[i] = 0;
      for (PetscInt j = PetscMax(0, i - 1); j < PetscMin(N, i + 2); j++)
        b[i] += (transpose ? *BandAt(&A, j, i) : *BandAt(&A, i, j)) * x[j];
    }
    CHECK(BandFactor(&A));
    CHECK(BandSolve(&A, transpose != 0, 1, b));
    for (PetscInt i = 0; i < N; i++)
      EXPECT(PetscAbsReal(b[i] - x[i]) < 1e-13, "x %d off by %g", (int)i, b[i] - x[i]);
    CHECK(BandDestroy(&A));
  }
}

/* [1 1; 1 1] has the eigenvalue 0 of (1, -1). */
static void TestAtAnEigenvalue(void **state) {
  PetscReal b[2] = {1, 0};
  Band A;

  for (int shifted = 0; shifted < 2; shifted++) {
    PetscErrorCode error;
    CHECK(BandCreate(2, 1, 1, &A));
    for (PetscInt i = 0; i < 2; i++)
      for (PetscInt j = 0; j < 2; j++) *BandAt(&A, i, j) = 1;
    CHECK(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
    error = shifted ? BandFactorShifted(&A) : BandFactor(&A);
    CHECK(PetscPopErrorHandler());
    EXPECT((error != 0) == !shifted, "error %d", (int)error);
    if (shifted) CHECK(BandSolve(&A, PETSC_FALSE, 1, b));
    CHECK(BandDestroy(&A));
  }
  EXPECT(PetscAbsReal(b[0]) > 1e15 && PetscIsNormalReal(b[0]), "only %g", b[0]);
  EXPECT(PetscAbsReal(b[0] + b[1]) < 1e-12 * PetscAbsReal(b[0]), "(%g, %g)", b[0], b[1]);
}

/* Each of two pivots of 0 becomes so much smaller than the largest entry above it. */
static void TestPivotsOfZero(void **state) {
  enum { M = 4 };
  const PetscReal U[M][M] = {{3, 1e6, 0, 0}, {0, 0, 2, 1e-6}, {0, 0, 5, 1e-9}, {0, 0, 0, 0}};
  const PetscReal least[M] = {3, 1e6 * PETSC_MACHINE_EPSILON, 5, 1e-6 * PETSC_MACHINE_EPSILON};
  Band A;

  CHECK(BandCreate(M, 1, 2, &A));
  for (PetscInt i = 0; i < M; i++)
    for (PetscInt j = i; j < PetscMin(M, i + 3); j++) *BandAt(&A, i, j) = U[i][j];
  CHECK(BandFactorShifted(&A));
  for (PetscInt j = 0; j < M; j++)
    EXPECT(PetscAbsReal(*BandAt(&A, j, j) / least[j] - 1) < 1e-13, "pivot %d is %g, not %g", (int)j,
           *BandAt(&A, j, j), least[j]);
  CHECK(BandDestroy(&A));

  /* rows are exchanged: U fills beyond the upper diagonals of the matrix */
  CHECK(BandCreate(3, 1, 1, &A));
  *BandAt(&A, 0, 0) = 1e-3;
  *BandAt(&A, 1, 0) = 1;
  *BandAt(&A, 1, 2) = 4;
  CHECK(BandFactorShifted(&A));
  EXPECT(PetscAbsReal(*BandAt(&A, 2, 2) / (4 * PETSC_MACHINE_EPSILON) - 1) < 1e-13, "fill: %g",
         *BandAt(&A, 2, 2));
  CHECK(BandDestroy(&A));
}

/* A symmetric positive band and its factor: R^T R is it, R^-1 undoes R, and R^-T R^T. */
static void TestCholesky(void **state) {
  enum { WIDE = 3, M = 12 };
  PetscReal A[M][2 * WIDE + 1], R[M][WIDE + 1], x[M], error = 0;
  PetscErrorCode code;

  for (PetscInt i = 0; i < M; i++)
    for (PetscInt b = -WIDE; b <= WIDE; b++)
      A[i][WIDE + b] = b ? PetscSinReal((PetscReal)(2 * i + b)) : 4;
  CHECK(BandCholesky(M, WIDE, A[0], R[0]));
  for (PetscInt j = 0; j < M; j++) {
    for (PetscInt i = 0; i < M; i++) x[i] = i == j;
    BandUpperMult(M, WIDE, R[0], PETSC_FALSE, x);
    BandUpperMult(M, WIDE, R[0], PETSC_TRUE, x);
    for (PetscInt i = 0; i < M; i++) {
      const PetscReal entry =
          i > j + WIDE || j > i + WIDE ? 0 : A[PetscMin(i, j)][WIDE + PetscAbs(i - j)];
      error = PetscMax(error, PetscAbsReal(x[i] - entry));
    }
    for (int transpose = 0; transpose < 2; transpose++) {
      for (PetscInt i = 0; i < M; i++) x[i] = i == j;
      BandUpperMult(M, WIDE, R[0], transpose != 0, x);
      BandUpperSolve(M, WIDE, R[0], transpose != 0, x);
      for (PetscInt i = 0; i < M; i++) error = PetscMax(error, PetscAbsReal(x[i] - (i == j)));
    }
  }
  EXPECT(error < 1e-14, "off by %g", error);
  A[5][WIDE] = -1;
  CHECK(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = BandCholesky(M, WIDE, A[0], R[0]);
  CHECK(PetscPopErrorHandler());
  EXPECT(code == PETSC_ERR_MAT_CH_ZRPVT, "error %d", (int)code);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestSolve), cmocka_unit_test(TestCholesky),
    cmocka_unit_test(TestAtAnEigenvalue), cmocka_unit_test(TestPivotsOfZero)};
MAIN(tests)
