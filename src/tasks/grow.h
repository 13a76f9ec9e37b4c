/* -task grow: follows the rod in time. */
#ifndef TENDRIL_GROW_H
#define TENDRIL_GROW_H

#include "tasks/member.h"

extern const OptionGroup grow_options;

PetscErrorCode GrowRun(Scene scene, const char *output, const char *restart);
PetscErrorCode GrowMember(Scene scene, const char *output, Member *member);

#endif
