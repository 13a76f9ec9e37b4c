#include "tasks/modes.h"

/* Eigenvalues nearest to 0 that are looked at: modes that are about to grow come through it, or
   past it. */
enum { NEAREST = 6, SUBSPACE = 40 };

/* 1/sigma that is so much smaller than the largest is its round-off. */
static const PetscReal noise = 1e-7;

/* y = T x, see ModesCreate(). */
static PetscErrorCode Apply(Mat T, Vec x, Vec y) {
  Modes *self;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(T, &self));
  PetscCall(VecPointwiseMult(y, self->moves, x));
  PetscCall(MatMult(self->B, y, self->work));
  PetscCall(KSPSolve(self->ksp, self->work, y));
  PetscCall(VecPointwiseMult(y, self->moves, y));
  PetscFunctionReturn(0);
}

/*
  ModesCreate - what looks for modes; the caller destroys it with ModesDestroy(), before what it is
  given, which it borrows. It must stay where it is.

  The problem is T u = u/sigma, T = A^-1 B, of places and directors alone: no rates of forces are in
  the equations, so these follow, and with them T has round-off for eigenvalues that are 0. Nor of
  what is held, for that is at rest: where friction is next to exact B is 1/sqrt(beta) there, and
  what it makes of a first guess that is not 0 there is so much larger than any mode that their
  round-off was told as modes that grow.
*/
PetscErrorCode ModesCreate(Mat A, Mat B, KSP ksp, Vec moves, Modes *self) {
  MPI_Comm comm = PetscObjectComm((PetscObject)moves);
  PetscInt n;

  PetscFunctionBegin;
  *self = (Modes){.A = A, .B = B, .ksp = ksp, .moves = moves};
  PetscCall(VecDuplicate(moves, &self->work));
  PetscCall(VecGetLocalSize(moves, &n));
  PetscCall(MatCreateShell(comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, self, &self->T));
  PetscCall(MatShellSetOperation(self->T, MATOP_MULT, (void (*)(void))Apply));
  PetscCall(EPSCreate(comm, &self->eps));
  PetscCall(EPSSetOperators(self->eps, self->T, NULL));
  PetscCall(EPSSetProblemType(self->eps, EPS_NHEP));
  PetscCall(EPSSetTolerances(self->eps, 1e-10, 200));
  PetscCall(EPSSetDimensions(self->eps, NEAREST, PetscMin(SUBSPACE, n), PETSC_DEFAULT));
  PetscCall(EPSSetWhichEigenpairs(self->eps, EPS_LARGEST_MAGNITUDE));
  PetscFunctionReturn(0);
}

/*
  ModesLook - the mode that grows fastest, or decays slowest, of the state that A and B are of.
  Collective.

  t  its time, for the error
*/
PetscErrorCode ModesLook(Modes *self, PetscReal t, Growing *growing) {
  PetscReal most = 0;
  PetscScalar re, im;
  PetscInt found;

  PetscFunctionBegin;
  PetscCall(KSPSetOperators(self->ksp, self->A, self->A));
  PetscCall(EPSSetOperators(self->eps, self->T, NULL)); /* it has changed */
  PetscCall(EPSSolve(self->eps));
  PetscCall(EPSGetConverged(self->eps, &found));
  PetscCheck(found > 0, PetscObjectComm((PetscObject)self->eps), PETSC_ERR_CONV_FAILED,
             "no mode was found at t = %g", (double)t);
  *growing = (Growing){.rate = PETSC_MIN_REAL};
  for (PetscInt i = 0; i < found; i++) {
    PetscReal size;
    PetscCall(EPSGetEigenvalue(self->eps, i, &re, &im));
    size = re * re + im * im;
    if (!i) most = size;
    if (size < most * PetscSqr(noise)) continue;
    re /= size;
    im /= size;
    if (re > growing->rate) *growing = (Growing){re, PetscAbsReal(im), i};
  }
  PetscFunctionReturn(0);
}

/* ModesDestroy - also of one that is 0, or was begun. */
PetscErrorCode ModesDestroy(Modes *self) {
  PetscFunctionBegin;
  PetscCall(EPSDestroy(&self->eps));
  PetscCall(MatDestroy(&self->T));
  PetscCall(VecDestroy(&self->work));
  PetscFunctionReturn(0);
}
