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

/* C += s A B, of sizes known when compiled. */
ALWAYS_INLINE void AddProduct(int rows, int inner, int columns, PetscReal s,
                              const PetscReal *restrict A, int lda, const PetscReal *restrict B,
                              int ldb, PetscReal *restrict C, int ldc) {
  for (int i = 0; i < rows; i++)
    for (int k = 0; k < inner; k++) {
      const PetscReal a = s * A[i * lda + k];
      for (int j = 0; j < columns; j++) C[i * ldc + j] += a * B[k * ldb + j];
    }
}

#endif
