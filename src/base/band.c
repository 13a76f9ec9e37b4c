#include "base/band.h"

/* PETSc declares LAPACK's dense routines only; these are LAPACK's and BLAS's own for bands. */
extern void dgbtrf_(const int *m, const int *n, const int *kl, const int *ku, double *ab,
                    const int *ldab, int *ipiv, int *info);
extern void dgbtrs_(const char *trans, const int *n, const int *kl, const int *ku, const int *nrhs,
                    const double *ab, const int *ldab, const int *ipiv, double *b, const int *ldb,
                    int *info, size_t);
extern void dpbtrf_(const char *uplo, const int *n, const int *kd, double *ab, const int *ldab,
                    int *info, size_t);
extern void dtbmv_(const char *uplo, const char *trans, const char *diag, const int *n,
                   const int *k, const double *a, const int *lda, double *x, const int *incx,
                   size_t, size_t, size_t);
extern void dtbsv_(const char *uplo, const char *trans, const char *diag, const int *n,
                   const int *k, const double *a, const int *lda, double *x, const int *incx,
                   size_t, size_t, size_t);

/* BandCreate - a zero matrix of n rows, lower and upper diagonals beside the main one. The caller
   frees it with BandDestroy(). */
PetscErrorCode BandCreate(PetscInt n, PetscInt lower, PetscInt upper, Band *band) {
  PetscFunctionBegin;
  band->n = n;
  band->lower = lower;
  band->upper = upper;
  PetscCall(PetscCalloc1(n * (2 * lower + upper + 1), &band->a));
  PetscCall(PetscMalloc1(n, &band->pivot));
  PetscFunctionReturn(0);
}

PetscErrorCode BandDestroy(Band *band) {
  PetscFunctionBegin;
  PetscCall(PetscFree(band->a));
  PetscCall(PetscFree(band->pivot));
  PetscFunctionReturn(0);
}

/* LU with row exchanges, in place; zero: the first row whose pivot is 0, from 1, or 0. */
static void Factor(Band *band, int *zero) {
  int n = (int)band->n, kl = (int)band->lower, ku = (int)band->upper, ld = 2 * kl + ku + 1;

  dgbtrf_(&n, &n, &kl, &ku, band->a, &ld, band->pivot, zero);
}

/* BandFactor - LU with row exchanges, in place. */
PetscErrorCode BandFactor(Band *band) {
  int zero;

  PetscFunctionBegin;
  Factor(band, &zero);
  PetscCheck(!zero, PETSC_COMM_SELF, PETSC_ERR_MAT_LU_ZRPVT, "banded matrix is singular (row %d)",
             zero);
  PetscFunctionReturn(0);
}

/* BandFactorShifted - likewise K - shift D, which is singular where the shift is an eigenvalue to
   the last digit. A pivot that is 0 becomes the least that counts in its column: what is solved for
   is large along the eigenvector then, as it is beside the eigenvalue. */
PetscErrorCode BandFactorShifted(Band *band) {
  int zero;

  PetscFunctionBegin;
  Factor(band, &zero);
  for (PetscInt j = zero - 1; zero && j < band->n; j++) {
    PetscReal *pivot = BandAt(band, j, j), most = 0;
    if (*pivot != 0) continue;
    for (PetscInt i = PetscMax(0, j - band->lower - band->upper); i < j; i++)
      most = PetscMax(most, PetscAbsReal(*BandAt(band, i, j)));
    *pivot = PETSC_MACHINE_EPSILON * (most > 0 ? most : 1);
  }
  PetscFunctionReturn(0);
}

/* BandSolve - solves with the factors, or with their transpose, in place. b: [columns][n] */
PetscErrorCode BandSolve(const Band *band, PetscBool transpose, PetscInt columns, PetscReal b[]) {
  int n = (int)band->n, kl = (int)band->lower, ku = (int)band->upper, ld = 2 * kl + ku + 1, info;
  int nrhs = (int)columns;

  PetscFunctionBegin;
  dgbtrs_(transpose ? "T" : "N", &n, &kl, &ku, &nrhs, band->a, &ld, band->pivot, b, &n, &info, 1);
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "dgbtrs failed: %d", info);
  PetscFunctionReturn(0);
}

/*
  BandCholesky - R with R^T R = A, A symmetric and positive.

  rows   [n][2 width + 1], entry (i, i - width + b) at b
  R      [n][width + 1], entry (i, i + b) at b; to LAPACK, by columns, this is R^T, a lower band
*/
PetscErrorCode BandCholesky(PetscInt n, PetscInt width, const PetscReal rows[], PetscReal R[]) {
  const int order = (int)n, lower = (int)width, ld = lower + 1;
  int info;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt b = 0; b <= width; b++)
      R[i * (width + 1) + b] = i + b < n ? rows[i * (2 * width + 1) + width + b] : 0;
  dpbtrf_("L", &order, &lower, R, &ld, &info, 1);
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_MAT_CH_ZRPVT, "matrix not positive");
  PetscFunctionReturn(0);
}

/* BandUpperMult - x <- R x or R^T x. */
void BandUpperMult(PetscInt n, PetscInt upper, const PetscReal R[], PetscBool transpose,
                   PetscReal x[]) {
  const int order = (int)n, lower = (int)upper, ld = lower + 1, one = 1;

  dtbmv_("L", transpose ? "N" : "T", "N", &order, &lower, R, &ld, x, &one, 1, 1, 1);
}

/* BandUpperSolve - x <- R^-1 x or R^-T x. */
void BandUpperSolve(PetscInt n, PetscInt upper, const PetscReal R[], PetscBool transpose,
                    PetscReal x[]) {
  const int order = (int)n, lower = (int)upper, ld = lower + 1, one = 1;

  dtbsv_("L", transpose ? "N" : "T", "N", &order, &lower, R, &ld, x, &one, 1, 1, 1);
}
