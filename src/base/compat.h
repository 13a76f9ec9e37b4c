/* What differs between the versions of PETSc that serve (3.18 and later), once. */
#ifndef TENDRIL_COMPAT_H
#define TENDRIL_COMPAT_H

#include <petscsnes.h>

#if PETSC_VERSION_GE(3, 23, 0)
typedef PetscOptionItems OptionItems;
#else
typedef PetscOptionItems *OptionItems;
#endif

#if PETSC_VERSION_GE(3, 25, 0)
#define DIVERGED_NAN SNES_DIVERGED_FUNCTION_NANORINF
#else
#define DIVERGED_NAN SNES_DIVERGED_FNORM_NAN
#endif

#if PETSC_VERSION_GE(3, 26, 0)
#define FULL_STEPS SNESLINESEARCHNONE
#else
#define FULL_STEPS SNESLINESEARCHBASIC
#endif

#endif
