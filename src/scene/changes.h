/* What changes in a run, and when: the rows of -change_file, and those that a host program has
   added. A step ends at each, and steps begin anew there. */
#ifndef TENDRIL_CHANGES_H
#define TENDRIL_CHANGES_H

#include "base/options.h"

/* From t on; value as it is given, with its words. */
typedef struct {
  PetscReal t;
  char *what, *value;
} ChangeRow;

typedef struct _Changes *Changes;
struct _Changes {
  PetscInt n, room;
  PetscInt done; /* rows from the first on that are in force */
  ChangeRow *row;
};

PetscErrorCode ChangesRead(Changes *changes);
PetscErrorCode ChangesTake(const char *file, const char *name, Changes *changes);
PetscErrorCode ChangesDo(Changes *changes, PetscReal t, const char *what, const char *value);
PetscReal ChangesNext(Changes changes);
PetscErrorCode ChangesText(Changes changes, char **text);
PetscErrorCode ChangesDestroy(Changes *changes);

#endif
