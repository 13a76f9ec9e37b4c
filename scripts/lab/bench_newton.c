/* Times one Newton iteration of the frame model (residual, Jacobian, factorisation, solve) and, on
   one rank, LAPACK's band solver on the same matrix. Options as of tendril; -bench_repeat R: best
   of R. */
#include "base/chain.h"
#include "tasks/tendril.h"
#include "stepping/newton.h"
#include "base/options.h"
#include "stepping/vbdf.h"
#include <petscblaslapack.h>
#include <petsctime.h>
#include <slepcsys.h>

extern void dgbsv_(const PetscBLASInt *, const PetscBLASInt *, const PetscBLASInt *,
                   const PetscBLASInt *, PetscReal *, const PetscBLASInt *, PetscBLASInt *,
                   PetscReal *, const PetscBLASInt *, PetscBLASInt *);

enum {
  HALF = 11
}; /* block tridiagonal, 6 unknowns per node: no entry is further off the diagonal */

/* Seconds that dgbsv takes on the matrix, best of repeat; error is the largest difference to x. */
static PetscErrorCode BandSolve(Mat J, Vec b, Vec x, PetscInt repeat, PetscLogDouble *best,
                                PetscReal *error) {
  PetscInt n, rows = 3 * HALF + 1;
  PetscBLASInt order, half = HALF, lda = 3 * HALF + 1, one = 1, info, *pivots;
  PetscReal *band, *rhs, size;
  const PetscScalar *a;
  PetscLogDouble begin, end;

  PetscFunctionBegin;
  PetscCall(VecGetSize(b, &n));
  PetscCall(PetscBLASIntCast(n, &order));
  PetscCall(PetscMalloc3(rows * n, &band, n, &rhs, n, &pivots));
  *best = PETSC_MAX_REAL;
  for (PetscInt r = 0; r < repeat; r++) {
    PetscCall(PetscArrayzero(band, rows * n));
    for (PetscInt i = 0; i < n; i++) {
      const PetscInt *cols;
      const PetscScalar *values;
      PetscInt m;
      PetscCall(MatGetRow(J, i, &m, &cols, &values));
      for (PetscInt k = 0; k < m; k++)
        if (PetscAbsInt(i - cols[k]) <= HALF)
          band[2 * HALF + i - cols[k] + cols[k] * rows] = values[k];
      PetscCall(MatRestoreRow(J, i, &m, &cols, &values));
    }
    PetscCall(VecGetArrayRead(b, &a));
    PetscCall(PetscArraycpy(rhs, a, n));
    PetscCall(VecRestoreArrayRead(b, &a));
    PetscCall(PetscTime(&begin));
    PetscCallBLAS("LAPACKgbsv",
                  dgbsv_(&order, &half, &half, &one, band, &lda, pivots, rhs, &order, &info));
    PetscCall(PetscTime(&end));
    *best = PetscMin(*best, end - begin);
  }
  *error = 0;
  PetscCall(VecNorm(x, NORM_INFINITY, &size));
  PetscCall(VecGetArrayRead(x, &a));
  for (PetscInt i = 0; i < n; i++) *error = PetscMax(*error, PetscAbsReal(a[i] - rhs[i]) / size);
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscCall(PetscFree3(band, rhs, pivots));
  PetscFunctionReturn(0);
}

/* A state of the rod and rates as in a run: the initial shape, growing, with step 1/shift. */
static PetscErrorCode State(Rod rod, Vec U, Vec U_t) {
  Node *nodes;
  PetscReal(*rate)[6];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(rod->end - rod->first, &nodes));
  PetscCall(RodInitialNodes(rod, 0, nodes));
  PetscCall(rod->model->set(rod, 0, nodes, U));
  PetscCall(VecZeroEntries(U_t));
  PetscCall(DMDAVecGetArray(rod->da, U_t, &rate));
  for (PetscInt i = rod->first; i < rod->end; i++)
    for (int d = 0; d < 2; d++) rate[i][d] = nodes[i - rod->first].x_t[d];
  PetscCall(DMDAVecRestoreArray(rod->da, U_t, &rate));
  PetscCall(PetscFree(nodes));
  PetscFunctionReturn(0);
}

static PetscErrorCode Run(void) {
  const PetscReal shift = 100;
  PetscInt repeat = 5;
  PetscLogDouble part[4] = {1e9, 1e9, 1e9, 1e9}, mark[5], band = 0;
  PetscReal error = 0, nodes;
  PetscMPIInt ranks;
  Scene scene;
  Rod rod;
  Mat J;
  Vec U, U_t, F, X;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_repeat", &repeat, NULL)); /* best of so many */
  PetscCall(SceneCreate(&scene));
  PetscCall(RodCreate(scene, &rod_frame, &rod));
  PetscCall(RodCreateMatrix(rod, &J));
  PetscCall(DMCreateGlobalVector(rod->da, &U));
  PetscCall(VecDuplicate(U, &U_t));
  PetscCall(VecDuplicate(U, &F));
  PetscCall(VecDuplicate(U, &X));
  PetscCall(State(rod, U, U_t));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  if (ranks > 1)
    PetscCall(ChainSetType(pc, MATORDERINGNATURAL));
  else
    PetscCall(PCSetType(pc, PCLU));
  if (ranks == 1) PetscCall(PCFactorSetMatOrderingType(pc, MATORDERINGNATURAL));
  PetscCall(KSPSetFromOptions(ksp));
  PetscCall(OptionsRefuseUnread());
  for (PetscInt r = 0; r <= repeat; r++) {
    rod->fresh = PETSC_TRUE;
    PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
    PetscCall(PetscTime(&mark[0]));
    PetscCall(RodResidual(NULL, 0, U, U_t, F, rod));
    PetscCall(PetscTime(&mark[1]));
    PetscCall(RodJacobian(NULL, 0, U, U_t, shift, J, J, rod));
    PetscCall(PetscTime(&mark[2]));
    PetscCall(KSPSetOperators(ksp, J, J));
    PetscCall(KSPSetUp(ksp));
    PetscCall(PetscTime(&mark[3]));
    PetscCall(KSPSolve(ksp, F, X));
    PetscCall(PetscTime(&mark[4]));
    for (int k = 0; k < 4 && r; k++)
      part[k] = PetscMin(part[k], mark[k + 1] - mark[k]); /* the first allocates */
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, part, 4, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD));
  if (ranks == 1) PetscCall(BandSolve(J, F, X, PetscMin(repeat, 5), &band, &error));
  nodes = scene->mesh.cells / 1e6;
  PetscCall(PetscPrintf(
      PETSC_COMM_WORLD, "%d %d %.4f %.4f %.4f %.4f %.4f %.4f %.1e\n", (int)scene->mesh.cells,
      (int)ranks, part[0] / nodes, part[1] / nodes, part[2] / nodes, part[3] / nodes,
      (part[0] + part[1] + part[2] + part[3]) / nodes, band / nodes, (double)error));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(MatDestroy(&J));
  PetscCall(VecDestroy(&U));
  PetscCall(VecDestroy(&U_t));
  PetscCall(VecDestroy(&F));
  PetscCall(VecDestroy(&X));
  PetscCall(RodDestroy(&rod));
  PetscCall(SceneDestroy(&scene));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv) {
  PetscBool done;
  int failed = TendrilInitialize(&argc, &argv, &done);

  if (done) return failed;
  if (!failed) failed = Run() != 0;
  return TendrilFinalize() || failed;
}
