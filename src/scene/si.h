/* The rod in the laboratory: scales between tendril's numbers and SI units. */
#ifndef TENDRIL_SI_H
#define TENDRIL_SI_H

#include "base/options.h"

typedef struct {
  PetscBool given;
  PetscReal stiffness, dry, viscous, speed; /* YI, mu, nu, V; V = 0: not given, no scale of time */
  PetscReal scale[UNIT_ALL];                /* what 1 of each is in SI; 0: unknown */
} Si;

/* of the dimensions; NULL: an angle, which is the same in both */
extern const char *const si_name[UNIT_ALL], *const si_unit[UNIT_ALL];
extern const OptionGroup si_options;

PetscErrorCode SiSetFromOptions(Si *si);
PetscErrorCode SiPrint(const Si *si, PetscReal mu, PetscReal start, PetscReal end);

#endif
