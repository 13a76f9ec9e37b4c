/* Functions whose loops are compiled for processors with wider vectors, too; which ones run is
   decided when the program begins. CMakeLists.txt knows whether compiler and system can
   (TENDRIL_CLONES). */
#ifndef TENDRIL_CLONES_H
#define TENDRIL_CLONES_H

#include <petscsys.h>

#if defined(TENDRIL_CLONES) && !defined(__SANITIZE_ADDRESS__)
#define WIDE_VECTORS __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define WIDE_VECTORS
#endif
/* ... and what they call is compiled with them. */
#define ALWAYS_INLINE static inline __attribute__((always_inline))

/* Left to itself the compiler makes vectors of other loops, and shuffles. */
typedef PetscReal Four __attribute__((vector_size(4 * sizeof(PetscReal)), aligned(8), may_alias));

#endif
