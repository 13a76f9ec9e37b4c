#include "base/errors.h"
#include <ctype.h>
#include <petscblaslapack.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

static ErrorState *now; /* the innermost ErrorsBegin() */

/* ErrorsLastWords - waits until mpiexec has taken from its pipe what was said, five seconds at
   most, and then a little longer: what it has not passed on when a rank ends with an error it may
   drop. Not collective; before MPI_Finalize() or MPI_Abort(). */
void ErrorsLastWords(void) {
  struct stat is;
  int left = 0;

  (void)fflush(stderr);
  if (!fstat(STDERR_FILENO, &is) && S_ISFIFO(is.st_mode))
    for (int k = 0; k < 500 && !ioctl(STDERR_FILENO, FIONREAD, &left) && left > 0; k++)
      (void)usleep(10000);
  (void)usleep(100000);
}

/* An error that one rank has met alone: the others wait for it in some exchange, for ever. All are
   ended, after the line is out. Ranks that meet the same error at once would each print it: the
   lowest comes first and ends the others before they do. */
static void EndAll(MPI_Comm comm, PetscErrorCode n) {
  ErrorsLastWords();
  MPI_Abort(comm, (int)n);
}

static void Say(PetscErrorCode n, const char *message, PetscBool keep) {
  char where[96] = "";
  const char *const about =
      n == TENDRIL_ERR_USER ? now->about : "an option is not as PETSc needs it: ";
  if (now->locate && n == TENDRIL_ERR_USER) now->locate(now->located, message, where);
  if (keep)
    (void)snprintf(now->message, sizeof(now->message), "%s%s%s", where, about, message);
  else
    fprintf(stderr, "tendril: %s%s%s\n", where, about, message);
  now->said = PETSC_TRUE;
}

/* A line for what is no user's mistake. */
static void Keep(const char *func, PetscErrorCode n, const char *message) {
  (void)snprintf(now->message, sizeof(now->message), "PETSc, error %d in %s(): %s", (int)n, func,
                 message);
  now->message[strcspn(now->message, "\n")] = 0;
  now->said = PETSC_TRUE;
}

/* One line for a user's mistake, PETSc's traceback for everything else, unless the line is kept. */
static PetscErrorCode Handle(MPI_Comm comm, int line, const char *func, const char *file,
                             PetscErrorCode n, PetscErrorType p, const char *mess, void *ctx) {
  PetscMPIInt rank = 0, ranks = 1, together = 1;
  PetscBool plain = (PetscBool)(n == TENDRIL_ERR_USER || now->reading || now->said), alone;

  MPI_Comm_rank(now->comm, &rank);
  MPI_Comm_size(now->comm, &ranks);
  MPI_Comm_size(comm, &together);
  alone = (PetscBool)(together < ranks && !now->said);
  if (alone && p == PETSC_ERROR_INITIAL && rank) (void)usleep(1000000 + 100000 * (unsigned)rank);
  if (plain) {
    if (p == PETSC_ERROR_INITIAL && !now->said && (!rank || alone || now->keep))
      Say(n, mess ? mess : "", (PetscBool)(now->keep && !alone));
    now->said = PETSC_TRUE;
  } else if (now->keep && !alone)
    Keep(func, n, mess ? mess : "");
  else
    n = PetscTraceBackErrorHandler(alone ? PETSC_COMM_SELF : comm, line, func, file, n, p, mess,
                                   ctx);
  if (alone && p == PETSC_ERROR_INITIAL) EndAll(now->comm, n);
  return n;
}

/*
  xerbla_ - BLAS and LAPACK call it where an argument cannot be: where a matrix holds what is no
  number, say. Theirs prints a line and ends the program as if all were well; the linker takes this
  one in its place.
*/
__attribute__((visibility("default"))) void xerbla_(const char *routine, const PetscBLASInt *which,
                                                    int length);

void xerbla_(const char *routine, const PetscBLASInt *which, int length) {
  const MPI_Comm comm = now ? now->comm : PETSC_COMM_WORLD;
  PetscErrorCode n;
  char name[16];
  int k = 0;

  for (; k < length && k < (int)sizeof(name) - 1 && isalnum((unsigned char)routine[k]); k++)
    name[k] = routine[k];
  name[k] = 0;
  n = PetscError(PETSC_COMM_SELF, __LINE__, "xerbla_", __FILE__, PETSC_ERR_LIB, PETSC_ERROR_INITIAL,
                 "LAPACK's %s cannot do with its argument %d: is a number of its matrix none?",
                 name, (int)*which);
  if (now && now->keep) fprintf(stderr, "tendril: %s\n", now->message);
  EndAll(comm, n);
}

/*
  ErrorsBegin - from here on errors are those of one run. Collective on comm.

  comm   the ranks of the run: an error that a part of them meets ends them all
  keep   the line of an error is kept in state->message, not printed (a sweep goes on)
  state  lives until ErrorsEnd()
*/
PetscErrorCode ErrorsBegin(MPI_Comm comm, PetscBool keep, ErrorState *state) {
  PetscFunctionBegin;
  PetscCall(PetscMemzero(state, sizeof(*state)));
  state->comm = comm;
  state->keep = keep;
  state->reading = PETSC_TRUE;
  PetscCall(ErrorsEnter(state));
  PetscFunctionReturn(0);
}

/* ErrorsEnter - likewise, of a run that ErrorsBegin() knows, until ErrorsEnd(): what it has said
   before is forgotten. */
PetscErrorCode ErrorsEnter(ErrorState *state) {
  PetscFunctionBegin;
  state->said = PETSC_FALSE;
  state->message[0] = state->about[0] = 0;
  state->locate = NULL;
  state->outer = now;
  now = state;
  PetscCall(PetscPushErrorHandler(Handle, NULL));
  PetscFunctionReturn(0);
}

/* ErrorsEnd - the run is over. */
PetscErrorCode ErrorsEnd(void) {
  PetscFunctionBegin;
  PetscCall(PetscPopErrorHandler());
  now = now->outer;
  PetscFunctionReturn(0);
}

/* ErrorsAbout - what stands before the line of a user's mistake from here on; "": nothing. */
void ErrorsAbout(const char *about) {
  if (now) (void)snprintf(now->about, sizeof(now->about), "%s", about);
}

/* ErrorsLocate - what stands before that, found by the line itself when it is said; NULL: no more.
 */
void ErrorsLocate(void (*locate)(const void *ctx, const char *message, char about[96]),
                  const void *ctx) {
  if (!now) return;
  now->locate = locate;
  now->located = ctx;
  if (!locate) now->about[0] = 0;
}

/* ErrorsOptionsRead - the options are read and the solvers set up: from here on an error of PETSc
   is not about an option. */
void ErrorsOptionsRead(void) {
  if (now) now->reading = PETSC_FALSE;
}
