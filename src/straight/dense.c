#include "straight/dense.h"
#include <slepcblaslapack.h>

/* DenseEigenvalues - all eigenvalues of a dense matrix, and if VL is given its left eigenvectors by
 * columns (re, im).
 */
PetscErrorCode DenseEigenvalues(PetscInt n, PetscReal T[], PetscReal re[], PetscReal im[],
                                PetscReal *VL) {
  PetscBLASInt nb, one = 1, lwork, info;
  PetscReal *work, none;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(n, &nb));
  PetscCall(PetscBLASIntCast(40 * n, &lwork));
  PetscCall(PetscMalloc1(lwork, &work));
  PetscCallBLAS("LAPACKgeev", LAPACKgeev_(VL ? "V" : "N", "N", &nb, T, &nb, re, im, VL ? VL : &none,
                                          VL ? &nb : &one, &none, &one, work, &lwork, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "dgeev failed: %d", (int)info);
  PetscCall(PetscFree(work));
  PetscFunctionReturn(0);
}

/* DenseSolve - b = A^-1 b, A by columns, which is overwritten. */
PetscErrorCode DenseSolve(PetscInt n, PetscReal A[], PetscReal b[]) {
  enum { MOST = 16 };
  PetscBLASInt nb, one = 1, info, pivot[MOST];

  PetscFunctionBegin;
  PetscCheck(n <= MOST, PETSC_COMM_SELF, PETSC_ERR_PLIB, "of %d rows at most", MOST);
  PetscCall(PetscBLASIntCast(n, &nb));
  PetscCallBLAS("LAPACKgesv", LAPACKgesv_(&nb, &one, A, &nb, pivot, b, &nb, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "dgesv failed: %d", (int)info);
  PetscFunctionReturn(0);
}
