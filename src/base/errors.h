/* Errors: a user's mistake is one plain line, and no error leaves ranks waiting. */
#ifndef TENDRIL_ERRORS_H
#define TENDRIL_ERRORS_H

#include <petscsys.h>

/* The error class of a user's mistake: one plain line on stderr, no traceback. */
#define TENDRIL_ERR_USER PETSC_ERR_USER

/* Refuse a user's mistake; the message names the option and the remedy. All ranks of comm come to
   the same verdict, or comm is PETSC_COMM_SELF. */
#define UserCheck(cond, comm, ...) PetscCheck(cond, comm, TENDRIL_ERR_USER, __VA_ARGS__)

/* What became of the run that is under way; a sweep has one of each member. */
typedef struct ErrorState {
  MPI_Comm comm;     /* of the run */
  PetscBool reading; /* options are being read: any error of PETSc is about one of them */
  PetscBool said;    /* the line is out */
  PetscBool keep;    /* keeps the line in message instead of printing it */
  char about[96];    /* stands before a line about an option: where that was asked for */
  /* what stands before that, by the line itself; NULL: nothing */
  void (*locate)(const void *ctx, const char *message, char about[96]);
  const void *located; /* its ctx */
  char message[1024];
  struct ErrorState *outer;
} ErrorState;

PetscErrorCode ErrorsBegin(MPI_Comm comm, PetscBool keep, ErrorState *state);
PetscErrorCode ErrorsEnter(ErrorState *state);
PetscErrorCode ErrorsEnd(void);
void ErrorsAbout(const char *about);
void ErrorsLocate(void (*locate)(const void *ctx, const char *message, char about[96]),
                  const void *ctx);
void ErrorsOptionsRead(void);
void ErrorsLastWords(void);

#endif
