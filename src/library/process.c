/* What a process has once, however many simulations are in it: MPI, PETSc and SLEPc, begun by
   whoever comes first. */
#include "library/simulation.h"
#include "tasks/program.h"
#include <slepcsys.h>
#include <stdlib.h>

/* What there is of it that is not the host's. */
typedef struct {
  PetscBool ready;      /* PETSc and SLEPc are, and know tendril's stepper */
  PetscBool mpi, petsc; /* are the library's, which ends them */
} Process;

static Process process; /* PETSc has one, too: it is a process's, not a simulation's */

/* ProcessLives - may PETSc be called (still)? */
PetscBool ProcessLives(void) {
  PetscBool ended = PETSC_FALSE;

  if (PetscFinalized(&ended)) return PETSC_FALSE;
  return (PetscBool)(process.ready && !ended);
}

static void EndPetsc(void) {
  const PetscBool petsc = process.petsc, lives = ProcessLives();

  process.petsc = process.ready = PETSC_FALSE;
  if (!petsc || !lives) return;
  (void)PetscOptionsSetValue(NULL, "-options_left", "no");
  (void)SlepcFinalize();
}

/* MPI ends: PETSc must have ended before. (MPI_Finalize() drops what is attached to MPI_COMM_SELF
   before it does anything else.) */
static int EndWithMpi(MPI_Comm comm, int keyval, void *attribute, void *state) {
  EndPetsc();
  return MPI_SUCCESS;
}

static void EndWithProcess(void) {
  int ended = 0;

  MPI_Finalized(&ended);
  if (!ended && process.mpi) MPI_Finalize();
}

static int BeginMpi(void) {
  int begun = 0, ended = 0;

  MPI_Finalized(&ended);
  if (ended) return 1;
  MPI_Initialized(&begun);
  if (begun) return 0;
  if (ProgramBeginMpi(NULL, NULL, PETSC_TRUE)) return 1;
  process.mpi = PETSC_TRUE;
  return atexit(EndWithProcess);
}

/* PETSc's world is the ranks of the first simulation: others of the host may never come here. */
static int BeginPetsc(MPI_Comm comm) {
  PetscBool begun = PETSC_FALSE;
  int key;

  if (PetscInitialized(&begun)) return 1;
  if (!begun) {
    if (MPI_Comm_dup(comm, &PETSC_COMM_WORLD)) return 1;
    (void)PetscOptionsSetValue(NULL, "-no_signal_handler", "true");
    (void)PetscOptionsSetValue(NULL, "-skip_petscrc", "true");
    if (SlepcInitialize(NULL, NULL, NULL, NULL)) return 1;
    process.petsc = PETSC_TRUE;
    if (MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, EndWithMpi, &key, NULL)) return 1;
    if (MPI_Comm_set_attr(MPI_COMM_SELF, key, NULL) || MPI_Comm_free_keyval(&key)) return 1;
  } else if (SlepcInitialize(NULL, NULL, NULL, NULL))
    return 1;
  return VBDFRegister() != 0;
}

/* ProcessBegin - sees to it that there are MPI, PETSc and SLEPc. Collective on comm. Returns 0 if
   all is well, else why not is in message. */
int ProcessBegin(MPI_Comm comm, char message[], size_t room) {
  PetscBool ended = PETSC_FALSE;

  (void)PetscFinalized(&ended);
  if (process.ready && !ended) return 0;
  ProgramSetTable();
  process.ready = PETSC_FALSE;
  if (BeginMpi())
    (void)snprintf(message, room, "MPI has ended, or does not begin: no simulation can be created");
  else if (ended)
    (void)snprintf(message, room, "PETSc has ended: no simulation can be created after that");
  else if (BeginPetsc(comm))
    (void)snprintf(message, room, "PETSc or SLEPc do not begin");
  else
    process.ready = PETSC_TRUE;
  return !process.ready;
}
