/* Reading options: each value is parsed strictly, checked against its range, entered in -help and
   remembered by name, so that a mistyped option is refused with the nearest known name. */
#ifndef TENDRIL_OPTIONS_H
#define TENDRIL_OPTIONS_H

#include <petscsys.h>

/* The error class of a user's mistake: one plain line on stderr, no traceback. */
#define TENDRIL_ERR_USER PETSC_ERR_USER

/* Refuse a user's mistake; the message names the option and the remedy. Collective on comm. */
#define UserCheck(cond, comm, ...) PetscCheck(cond, comm, TENDRIL_ERR_USER, __VA_ARGS__)

PetscErrorCode OptionReal(const char *name, const char *text, PetscReal low, PetscReal high,
                          PetscReal *value, PetscBool *set);
PetscErrorCode OptionInt(const char *name, const char *text, PetscInt low, PetscInt high,
                         PetscInt *value, PetscBool *set);
PetscErrorCode OptionBool(const char *name, const char *text, PetscBool *value, PetscBool *set);
PetscErrorCode OptionString(const char *name, const char *text, char *value, size_t length,
                            PetscBool *set);
PetscErrorCode OptionList(const char *name, const char *text, PetscInt n, const char *const *list,
                          PetscInt *choice, PetscBool *set);
PetscErrorCode OptionsHeading(const char *title);

const char *OptionNumber(PetscReal value, char text[32]);
int OptionsCheckFiles(int argc, char **argv);
PetscErrorCode OptionsCheckPetsc(void);
PetscErrorCode OptionsCheckTypes(void);
PetscErrorCode OptionsRefuseOverwrite(const char *output);
PetscErrorCode OptionsRefuseUnread(void);
PetscErrorCode OptionsRefuseBareWords(int argc, char **argv);

PetscErrorCode UserErrorHandler(MPI_Comm comm, int line, const char *func, const char *file,
                                PetscErrorCode n, PetscErrorType p, const char *mess, void *ctx);

#endif
