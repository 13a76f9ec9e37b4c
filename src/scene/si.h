/* The rod in the laboratory: scales between tendril's numbers and SI units. */
#ifndef TENDRIL_SI_H
#define TENDRIL_SI_H

#include "scene/friction.h"

enum { SI_SCALES = 7 };
typedef struct {
  PetscBool given;
  PetscReal stiffness, dry, viscous, speed; /* YI, mu, nu, V; V = 0: not given, no scale of time */
  PetscReal scale[SI_SCALES];               /* of what si_name lists; 0: unknown */
} Si;
extern const char *const si_name[SI_SCALES], *const si_unit[SI_SCALES];

PetscErrorCode SiSetFromOptions(Si *si, Friction *friction);
PetscErrorCode SiPrint(const Si *si, PetscReal mu, PetscReal start, PetscReal end);

#endif
