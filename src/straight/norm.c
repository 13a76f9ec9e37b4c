#include "straight/norm.h"
#include "base/chain.h"
#include "straight/straight.h"
#include <petscblaslapack.h>

/* y <- G x in the dual of c: M x, or W^T (W x) with the sum over ranks between. */
static PetscErrorCode ApplyG(Norm *self, Vec x, Vec y) {
  PetscBLASInt n, nloc, one = 1;
  PetscReal *a, unit = 1, zero = 0;
  const PetscReal *b;

  PetscFunctionBegin;
  if (!self->W) {
    PetscCall(MatMult(self->M, x, y));
    PetscFunctionReturn(0);
  }
  PetscCall(PetscBLASIntCast(self->pencil->n, &n));
  PetscCall(PetscBLASIntCast(self->pencil->last - self->pencil->first, &nloc));
  PetscCall(VecGetArrayRead(x, &b));
  PetscCallBLAS("BLASgemv",
                BLASgemv_("T", &nloc, &n, &unit, self->W, &nloc, b, &one, &zero, self->all, &one));
  PetscCall(VecRestoreArrayRead(x, &b));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, self->all, n, MPIU_REAL, MPIU_SUM, self->pencil->comm));
  PetscCall(VecGetArray(y, &a));
  PetscCallBLAS("BLASgemv",
                BLASgemv_("N", &nloc, &n, &unit, self->W, &nloc, self->all, &one, &zero, a, &one));
  PetscCall(VecRestoreArray(y, &a));
  PetscFunctionReturn(0);
}

/* y = (G A + A^T G) x on w, where A = D^-1 K_c and K_c = C^-T K C^-1 + X C^-1 on c. Sums and
   differences take the place of fourth derivatives, so rounding stays small. */
static PetscErrorCode FormMult(Mat form, Vec x, Vec y) {
  Norm *self;
  Vec *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(form, &self));
  c = self->c;
  PetscCall(MatMult(self->K, x, self->w[0]));
  PetscCall(PencilUnsumTranspose(self->pencil, self->E, self->w[0], c[0]));
  if (self->X) PetscCall(MatMultAdd(self->X, x, c[0], c[0]));
  PetscCall(KSPSolve(self->solve_drag, c[0], c[1]));
  PetscCall(ApplyG(self, c[1], c[0]));
  PetscCall(PencilSumTranspose(self->pencil, c[0], y));
  PetscCall(PencilSum(self->pencil, x, c[0]));
  PetscCall(ApplyG(self, c[0], c[1]));
  PetscCall(KSPSolve(self->solve_drag, c[1], c[0]));
  PetscCall(PencilUnsum(self->pencil, self->E, c[0], self->w[0]));
  PetscCall(MatMultAdd(self->K, self->w[0], y, y));
  if (self->X) PetscCall(MatMultTransposeAdd(self->X, c[0], y, y));
  PetscFunctionReturn(0);
}

/* y = C^T M C x: the L2 norm, against which the eigenvalue is taken */
static PetscErrorCode NormMult(Mat norm, Vec x, Vec y) {
  Norm *self;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(norm, &self));
  PetscCall(PencilSum(self->pencil, x, self->c[2]));
  PetscCall(MatMult(self->M, self->c[2], self->c[3]));
  PetscCall(PencilSumTranspose(self->pencil, self->c[3], y));
  PetscFunctionReturn(0);
}

/* The preconditioner: bending alone, each place weighted by how much G exceeds D there; solved in
   the mixed unknowns with w's row loaded. */
static PetscErrorCode Precondition(PC pc, Vec x, Vec y) {
  Norm *self;
  PetscInt nloc;
  const PetscReal *a;
  PetscReal *b;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &self));
  PetscCall(VecGetLocalSize(x, &nloc));
  PetscCall(VecZeroEntries(self->z[0]));
  PetscCall(VecGetArrayRead(x, &a));
  PetscCall(VecGetArray(self->z[0], &b));
  for (PetscInt i = 0; i < nloc; i++) b[3 * i] = a[i];
  PetscCall(VecRestoreArray(self->z[0], &b));
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscCall(KSPSolve(self->solve_mixed, self->z[0], self->z[1]));
  PetscCall(VecGetArrayRead(self->z[1], &a));
  PetscCall(VecGetArray(y, &b));
  for (PetscInt i = 0; i < nloc; i++) b[i] = a[3 * i];
  PetscCall(VecRestoreArray(y, &b));
  PetscCall(VecRestoreArrayRead(self->z[1], &a));
  PetscFunctionReturn(0);
}

/* The first tolerance on the residual, and how often it is made ten times smaller if the eigenvalue
   turns out worse than this, relative to its size or to 1. */
static const PetscReal first_tolerance = 1e-7, wanted = 1e-9;
enum { TIGHTER = 5 };

/* The residual is judged by the eigenvalue's own size, or by 1 where that is larger: the eigenvalue
   may well be 0. */
static PetscErrorCode Judge(EPS eps, PetscScalar re, PetscScalar im, PetscReal residual,
                            PetscReal *error, void *ctx) {
  PetscFunctionBegin;
  *error = residual / PetscMax(1, PetscAbsReal(re));
  PetscFunctionReturn(0);
}

static PetscErrorCode SetUpSolver(Norm *self) {
  ST st;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscCall(EPSCreate(self->pencil->comm, &self->eps));
  PetscCall(EPSSetOptionsPrefix(self->eps, "norm_"));
  PetscCall(EPSSetOperators(self->eps, self->form, self->norm));
  PetscCall(EPSSetProblemType(self->eps, EPS_GHEP));
  PetscCall(EPSSetWhichEigenpairs(self->eps, EPS_LARGEST_REAL));
  PetscCall(EPSSetType(self->eps, EPSGD));
  PetscCall(EPSSetDimensions(self->eps, 1, 24, PETSC_DEFAULT));
  PetscCall(EPSSetTolerances(self->eps, first_tolerance, 400));
  PetscCall(EPSSetConvergenceTestFunction(self->eps, Judge, self, NULL));
  PetscCall(EPSGetST(self->eps, &st));
  PetscCall(STSetType(st, STPRECOND));
  PetscCall(STGetKSP(st, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetContext(pc, self));
  PetscCall(PCShellSetApply(pc, Precondition));
  PetscCall(EPSSetFromOptions(self->eps));
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateShell(Norm *self, PetscErrorCode (*mult)(Mat, Vec, Vec), Mat *shell) {
  PetscInt nloc = self->pencil->last - self->pencil->first, n = self->pencil->n;

  PetscFunctionBegin;
  PetscCall(MatCreateShell(self->pencil->comm, nloc, nloc, n, n, self, shell));
  PetscCall(MatShellSetOperation(*shell, MATOP_MULT, (void (*)(void))mult));
  PetscCall(MatShellSetOperation(*shell, MATOP_MULT_TRANSPOSE, (void (*)(void))mult));
  PetscFunctionReturn(0);
}

/*
  NormCreate - prepares the growth of one norm. Collective on the pencil's communicator; it reads
  options with the prefix -norm_ (-norm_eps_...).

  W    the norm |W c|: all of W by rows, n * n, on every rank (copied); NULL: the L2 norm
  at   the time W belongs to
  norm the caller destroys it with NormDestroy(), before the pencil
*/
PetscErrorCode NormCreate(Pencil pencil, const PetscReal W[], PetscReal at, Norm *self) {
  PetscInt n = pencil->n, nloc = pencil->last - pencil->first, points = pencil->cells * GAUSS;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  self->pencil = pencil;
  PetscCall(PetscMalloc2(points, &self->drag, n, &self->all));
  PetscCall(PencilSetTime(pencil, at, FRAME_ARC));
  for (PetscInt i = 0; i < points; i++) self->drag[i] = W ? pencil->point[i].drag : 1;
  if (W) {
    PetscCall(PetscMalloc1(n * nloc, &self->W));
    for (PetscInt k = 0; k < n; k++)
      PetscCall(PetscArraycpy(self->W + k * nloc, W + k * n + pencil->first, nloc));
  }
  PetscCall(PencilDifference(pencil, &self->E));
  PetscCall(CreateShell(self, FormMult, &self->form));
  PetscCall(CreateShell(self, NormMult, &self->norm));
  for (int i = 0; i < 4; i++) PetscCall(MatCreateVecs(self->E, &self->c[i], NULL));
  for (int i = 0; i < 2; i++) PetscCall(MatCreateVecs(self->E, &self->w[i], NULL));
  PetscCall(MatCreateVecs(self->E, &self->guess, NULL));
  PetscCall(ChainCreateSolver(pencil->comm, MATORDERINGNATURAL, &self->solve_drag));
  PetscCall(ChainCreateSolver(pencil->comm, MATORDERINGNATURAL, &self->solve_mixed));
  PetscCall(SetUpSolver(self));
  PetscFunctionReturn(0);
}

PetscErrorCode NormDestroy(Norm *self) {
  PetscFunctionBegin;
  PetscCall(EPSDestroy(&self->eps));
  PetscCall(KSPDestroy(&self->solve_drag));
  PetscCall(KSPDestroy(&self->solve_mixed));
  PetscCall(MatDestroy(&self->K));
  PetscCall(MatDestroy(&self->X));
  PetscCall(MatDestroy(&self->E));
  PetscCall(MatDestroy(&self->D));
  PetscCall(MatDestroy(&self->M));
  PetscCall(MatDestroy(&self->form));
  PetscCall(MatDestroy(&self->norm));
  PetscCall(MatDestroy(&self->mixed));
  for (int i = 0; i < 4; i++) PetscCall(VecDestroy(&self->c[i]));
  for (int i = 0; i < 2; i++) PetscCall(VecDestroy(&self->w[i]));
  for (int i = 0; i < 2; i++) PetscCall(VecDestroy(&self->z[i]));
  PetscCall(VecDestroy(&self->guess));
  PetscCall(PetscFree(self->W));
  PetscCall(PetscFree2(self->drag, self->all));
  PetscFunctionReturn(0);
}

static PetscErrorCode AssemblePreconditioner(Norm *self) {
  Pencil p = self->pencil;
  PetscInt rows = (p->last - p->first) * WIDTH;
  PetscReal *bend, *mass;
  PencilBands bands = {.K = {NULL}};

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(rows, &bend, rows, &mass));
  bands.K[0] = bend;
  bands.c = mass;
  for (PetscInt i = 0; i < p->cells * GAUSS; i++)
    p->point[i].ratio = self->drag[i] / p->point[i].drag;
  PetscCall(PencilBand(p, FORM_BEND_RATIO, bend));
  PetscCall(PencilBand(p, FORM_MASS, mass));
  for (PetscInt i = 0; i < rows; i++) {
    bend[i] *= -2;
    mass[i] *= -1;
  }
  PetscCall(PencilMixed(p, &bands, &self->mixed, NULL));
  if (!self->z[0]) PetscCall(MatCreateVecs(self->mixed, &self->z[0], &self->z[1]));
  PetscCall(KSPSetOperators(self->solve_mixed, self->mixed, self->mixed));
  PetscCall(KSPSetUp(self->solve_mixed));
  PetscCall(PetscFree2(bend, mass));
  PetscFunctionReturn(0);
}

static PetscErrorCode Preconditioner(Norm *self, PC *pc) {
  KSP ksp;
  ST st;

  PetscFunctionBegin;
  PetscCall(EPSGetST(self->eps, &st));
  PetscCall(STGetKSP(st, &ksp));
  PetscCall(KSPGetPC(ksp, pc));
  PetscFunctionReturn(0);
}

/* The first guess: how the rod bends under an even load, smooth and within the clamp. */
static PetscErrorCode FirstGuess(Norm *self) {
  PC pc;
  Vec load;

  PetscFunctionBegin;
  PetscCall(Preconditioner(self, &pc));
  PetscCall(VecDuplicate(self->guess, &load));
  PetscCall(VecSet(self->c[2], 1));
  PetscCall(MatMult(self->M, self->c[2], self->c[3]));
  PetscCall(PencilSumTranspose(self->pencil, self->c[3], load));
  PetscCall(Precondition(pc, load, self->guess));
  PetscCall(VecDestroy(&load));
  PetscFunctionReturn(0);
}

/* The Rayleigh quotient of the latest eigenvector, and the error left in it, of second order in the
   residual r: r^T P^-1 r / |w|^2 with the preconditioner P in place of the form. (The plain size of
   r says little: on w it scales with the mesh.) */
static PetscErrorCode Quotient(Norm *self, Eigenvalue *value) {
  PetscReal size, left;
  PC pc;
  Vec x = self->guess, r, p;

  PetscFunctionBegin;
  PetscCall(Preconditioner(self, &pc));
  PetscCall(VecDuplicate(x, &r));
  PetscCall(VecDuplicate(x, &p));
  PetscCall(MatMult(self->norm, x, p));
  PetscCall(VecDot(x, p, &size));
  PetscCall(MatMult(self->form, x, r));
  PetscCall(VecDot(x, r, &value->value));
  value->value /= size;
  value->frequency = 0;
  PetscCall(VecAXPY(r, -value->value, p));
  PetscCall(Precondition(pc, r, p));
  PetscCall(VecDot(r, p, &left));
  value->error = PetscAbsReal(left) / size;
  PetscCall(VecDestroy(&r));
  PetscCall(VecDestroy(&p));
  PetscFunctionReturn(0);
}

/* One solve from the latest eigenvector; found tells whether it converged. */
static PetscErrorCode SolveOnce(Norm *self, PetscReal tolerance, Eigenvalue *value,
                                PetscBool *done) {
  PetscInt found;
  PetscScalar re, im;

  PetscFunctionBegin;
  PetscCall(EPSSetTolerances(self->eps, tolerance, PETSC_DEFAULT));
  PetscCall(EPSSetInitialSpace(self->eps, 1, &self->guess));
  PetscCall(EPSSolve(self->eps));
  PetscCall(EPSGetConverged(self->eps, &found));
  *done = (PetscBool)(found > 0);
  if (!found) PetscFunctionReturn(0);
  PetscCall(EPSGetEigenpair(self->eps, 0, &re, &im, self->guess, NULL));
  PetscCall(Quotient(self, value));
  PetscFunctionReturn(0);
}

static PetscErrorCode Assemble(Norm *self, PetscReal t, PencilFrame frame) {
  Pencil p = self->pencil;

  PetscFunctionBegin;
  PetscCall(PencilSetTime(p, t, frame));
  PetscCall(PencilMatrix(p, FORM_STIFF, &self->K));
  PetscCall(PencilMatrix(p, FORM_DRAG, &self->D));
  PetscCall(PencilMatrix(p, FORM_MASS, &self->M));
  if (p->skew) PetscCall(PencilMatrix(p, FORM_SLIDE, &self->X));
  PetscCall(KSPSetOperators(self->solve_drag, self->D, self->D));
  PetscCall(AssemblePreconditioner(self));
  PetscFunctionReturn(0);
}

/*
  NormGrowth - the largest eigenvalue of G A(t) + A(t)^T G against the L2 norm, G = W^T W or the L2
  norm itself, by generalized Davidson. Collective.

  frame   in which the time derivative is taken, for laws that slide
  value   the eigenvalue; negative if and only if every deflection shrinks in the norm at t
*/
PetscErrorCode NormGrowth(Norm *self, PetscReal t, PencilFrame frame, Eigenvalue *value) {
  PetscReal tolerance;
  PetscBool done;

  PetscFunctionBegin;
  PetscCall(Assemble(self, t, frame));
  if (!self->started) {
    PetscCall(FirstGuess(self));
    PetscCall(EPSGetTolerances(self->eps, &self->tolerance, NULL));
    self->started = PETSC_TRUE;
  }
  tolerance = self->tolerance;
  PetscCall(SolveOnce(self, tolerance, value, &done));
  PetscCheck(done, self->pencil->comm, PETSC_ERR_CONV_FAILED,
             "the growth of a norm did not converge at t = %g (see -norm_eps_max_it)", (double)t);
  for (int k = 0; k < TIGHTER && done; k++) {
    if (value->error <= wanted * PetscMax(1, PetscAbsReal(value->value))) break;
    tolerance /= 10;
    PetscCall(
        SolveOnce(self, tolerance, value, &done)); /* at rounding's floor: the last one stands */
  }
  PetscFunctionReturn(0);
}
