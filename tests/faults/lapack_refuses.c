/* A matrix of which something is no number, given to LAPACK on the last rank: that is an error. */
#include "base/errors.h"
#include "base/wide.h"
#include "support/program.h"

static PetscErrorCode Run(void) {
  PetscReal A[9] = {1, NAN, 2, 3, 4, 5, 6, 7, 9}, re[3], im[3], none = 0, work[64];
  PetscBLASInt n = 3, one = 1, room = 64, info;
  PetscMPIInt rank, ranks;

  PetscFunctionBegin;
  ErrorsOptionsRead();
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  if (rank == ranks - 1) {
    LAPACKgeev_("N", "N", &n, A, &n, re, im, &none, &one, &none, &one, work, &room, &info);
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "it went on\n"));
  }
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscFunctionReturn(0);
}

PROGRAM(Run)
