/* A description of a result file for ParaView and VisIt. */
#ifndef TENDRIL_XDMF_H
#define TENDRIL_XDMF_H

#include <petscsys.h>

PetscErrorCode XdmfWrite(const char *file, PetscInt rods, PetscInt nodes, PetscInt shapes,
                         const PetscReal t[], PetscBool contact, PetscBool space);

#endif
