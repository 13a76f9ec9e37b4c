/* The rods of a scene that has several, as options files and the command line tell of them: names,
   and what options each has. */
#ifndef TENDRIL_RODS_H
#define TENDRIL_RODS_H

#include "base/options.h"
#include "rod/strands.h"

extern const OptionGroup pair_options;

enum { ROD_NAME = 32 };

typedef struct _Rods *Rods;

PetscErrorCode RodsRead(const OptionWords *words, Rods *rods);
PetscErrorCode RodsDestroy(Rods *rods);
PetscInt RodsCount(Rods rods);
const char *RodsName(Rods rods, PetscInt k);
PetscErrorCode RodsEnter(Rods rods, PetscInt k);
PetscErrorCode RodsLeave(Rods rods);
PetscErrorCode RodsPut(Rods rods, PetscInt k, const char *name, const char *value);
PetscErrorCode RodsAnew(Rods rods);
PetscErrorCode RodsRefuseUnread(Rods rods);
PetscBool RodsTouch(Rods rods);
void RodsMeet(Rods rods, PetscInt a, PetscInt b, StrandMeeting *how);
PetscErrorCode RodsRefuseThin(Rods rods, PetscInt k);
PetscErrorCode RodsText(Rods rods, char **text);

#endif
