/* Times one Newton iteration of the frame model (residual, elimination with the Jacobian in it,
   solve), the same with an assembled matrix (Jacobian, factorisation, solve) and, on one rank,
   LAPACK's band solver on that matrix. Options as of tendril; -bench_repeat R: best of R. */
#include "base/chain.h"
#include "tasks/program.h"
#include "stepping/newton.h"
#include "base/options.h"
#include "stepping/vbdf.h"
#include <petsc/private/petscimpl.h>
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

enum { RESIDUAL, JACOBIAN, FACTOR, SOLVE, PARTS };

/* Best seconds of each part of an iteration, of all ranks; the first one allocates. With an
   elimination it takes the place of the matrix. */
static PetscErrorCode Iterate(Rod rod, Elimination elimination, KSP ksp, Mat J, Vec U, Vec U_t,
                              Vec F, Vec X, PetscInt repeat, PetscLogDouble best[PARTS]) {
  RodState at = {.U = U, .U_t = U_t};
  PetscLogDouble mark[PARTS + 1];

  PetscFunctionBegin;
  for (int k = 0; k < PARTS; k++) best[k] = PETSC_MAX_REAL;
  for (int f = 0; f < MAX_FIELDS; f++) at.shift[f] = 100;
  for (PetscInt r = 0; r <= repeat; r++) {
    at.fresh = PETSC_TRUE;
    PetscCall(PetscObjectStateIncrease((PetscObject)U)); /* another state, for all that is known */
    PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
    PetscCall(PetscTime(&mark[0]));
    PetscCall(rod->model->residual(rod, &at, F));
    PetscCall(PetscTime(&mark[1]));
    if (elimination) {
      PetscCall(rod->model->eliminate(rod, &at, elimination));
      PetscCall(PetscObjectStateIncrease((PetscObject)J));
    } else
      PetscCall(rod->model->jacobian(rod, &at, J));
    PetscCall(PetscTime(&mark[2]));
    PetscCall(KSPSetOperators(ksp, J, J));
    PetscCall(KSPSetUp(ksp));
    PetscCall(PetscTime(&mark[3]));
    PetscCall(KSPSolve(ksp, F, X));
    PetscCall(PetscTime(&mark[4]));
    for (int k = 0; k < PARTS && r; k++) best[k] = PetscMin(best[k], mark[k + 1] - mark[k]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, best, PARTS, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD));
  PetscFunctionReturn(0);
}

static PetscErrorCode SolverFor(KSP *ksp, PC *pc) {
  PetscFunctionBegin;
  PetscCall(KSPCreate(PETSC_COMM_WORLD, ksp));
  PetscCall(KSPSetType(*ksp, KSPPREONLY));
  PetscCall(KSPGetPC(*ksp, pc));
  PetscFunctionReturn(0);
}

/* What joins P ranks: microseconds that each spends on the line of the ranks, a cell a rank. */
static PetscErrorCode Joint(PetscInt ranks, PetscInt repeat) {
  PetscReal a[LINE_FIELDS][LINE_FIELDS], b[LINE_FIELDS][LINE_FIELDS];
  PetscLogDouble begin, end, best = PETSC_MAX_REAL;
  Line line;

  PetscFunctionBegin;
  for (int i = 0; i < LINE_FIELDS; i++)
    for (int j = 0; j < LINE_FIELDS; j++) {
      a[i][j] = i == j ? (i < LINE_HALF ? -1 : 1) : 0.1 / (1 + i + j);
      b[i][j] = i == j && i < LINE_HALF ? 1 : 0.2 / (2 + i + j);
    }
  PetscCall(LineCreate(ranks, &line));
  for (PetscInt r = 0; r < repeat; r++) {
    PetscCall(PetscTime(&begin));
    LineBegin(&line, (const PetscReal(*)[LINE_FIELDS])b);
    for (PetscInt k = 1; k < ranks; k++)
      LineCell(&line, (const PetscReal(*)[LINE_FIELDS])a, (const PetscReal(*)[LINE_FIELDS])b);
    LineEnd(&line, (const PetscReal(*)[LINE_FIELDS])(a + LINE_HALF));
    PetscCall(PetscTime(&end));
    best = PetscMin(best, end - begin);
  }
  PetscCall(LineDestroy(&line));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%d %.2f\n", (int)ranks, 1e6 * best));
  PetscFunctionReturn(0);
}

static PetscErrorCode Run(void) {
  PetscInt repeat = 5, n, joint = 0;
  PetscLogDouble part[PARTS], assembled[PARTS], band = 0;
  PetscReal error[2] = {0, 0}, size, nodes;
  PetscMPIInt ranks;
  Elimination elimination;
  Scene scene;
  Rod rod;
  Mat J, none;
  Vec U, U_t, F, X, Y;
  KSP ksp[2];
  PC pc[2];

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_repeat", &repeat, NULL)); /* best of so many */
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_joint", &joint, NULL));   /* of so many ranks */
  if (joint) {
    PetscCall(Joint(joint, repeat));
    PetscFunctionReturn(0);
  }
  PetscCall(SceneCreate(&scene));
  PetscCall(RodCreate(scene, &rod_frame, &rod));
  PetscCall(RodCreateMatrix(rod, &J));
  PetscCall(DMCreateGlobalVector(rod->da, &U));
  PetscCall(VecDuplicate(U, &U_t));
  PetscCall(VecDuplicate(U, &F));
  PetscCall(VecDuplicate(U, &X));
  PetscCall(VecDuplicate(U, &Y));
  PetscCall(VecGetLocalSize(U, &n));
  PetscCall(MatCreateShell(PETSC_COMM_WORLD, n, n, PETSC_DETERMINE, PETSC_DETERMINE, NULL, &none));
  PetscCall(
      EliminationCreate(PETSC_COMM_WORLD, rod->end - rod->first, rod->model->halves, &elimination));
  PetscCall(State(rod, U, U_t));
  for (int k = 0; k < 2; k++) PetscCall(SolverFor(&ksp[k], &pc[k]));
  PetscCall(EliminationSetType(pc[0], elimination));
  PetscCall(ChainSetType(pc[1], MATORDERINGNATURAL));
  PetscCall(OptionsRefuseUnread());
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(Iterate(rod, elimination, ksp[0], none, U, U_t, F, Y, repeat, part));
  PetscCall(Iterate(rod, NULL, ksp[1], J, U, U_t, F, X, PetscMin(repeat, 5), assembled));
  PetscCall(VecNorm(X, NORM_INFINITY, &size));
  PetscCall(VecAXPY(Y, -1, X));
  PetscCall(VecNorm(Y, NORM_INFINITY, &error[0]));
  if (ranks == 1) PetscCall(BandSolve(J, F, X, PetscMin(repeat, 5), &band, &error[1]));
  nodes = scene->mesh.cells / 1e6;
  PetscCall(PetscPrintf(
      PETSC_COMM_WORLD, "%d %d %.4f %.4f %.4f %.4f %.4f %.4f %.1e %.1e\n", (int)scene->mesh.cells,
      (int)ranks, part[RESIDUAL] / nodes, part[JACOBIAN] / nodes, part[SOLVE] / nodes,
      (part[RESIDUAL] + part[JACOBIAN] + part[FACTOR] + part[SOLVE]) / nodes,
      (assembled[RESIDUAL] + assembled[JACOBIAN] + assembled[FACTOR] + assembled[SOLVE]) / nodes,
      band / nodes, (double)(error[0] / size), (double)error[1]));
  for (int k = 0; k < 2; k++) PetscCall(KSPDestroy(&ksp[k]));
  PetscCall(EliminationDestroy(&elimination));
  PetscCall(MatDestroy(&J));
  PetscCall(MatDestroy(&none));
  PetscCall(VecDestroy(&U));
  PetscCall(VecDestroy(&U_t));
  PetscCall(VecDestroy(&F));
  PetscCall(VecDestroy(&X));
  PetscCall(VecDestroy(&Y));
  PetscCall(RodDestroy(&rod));
  PetscCall(SceneDestroy(&scene));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv) {
  Program program;
  PetscBool done;
  int failed = ProgramBegin(&program, &argc, &argv, &done);

  if (done) return failed;
  if (!failed) failed = Run() != 0;
  return ProgramEnd(&program) || failed;
}
