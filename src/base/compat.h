/* What differs between the versions of PETSc that serve (3.18 and later), once. */
#ifndef TENDRIL_COMPAT_H
#define TENDRIL_COMPAT_H

#include <petscsys.h>

#if PETSC_VERSION_GE(3, 23, 0)
typedef PetscOptionItems OptionItems;
#else
typedef PetscOptionItems *OptionItems;
#endif

#endif
