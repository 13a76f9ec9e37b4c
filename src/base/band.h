/* General banded matrices of one process, factored by LAPACK. */
#ifndef TENDRIL_BAND_H
#define TENDRIL_BAND_H

#include <petscsys.h>

typedef struct {
  PetscInt n, lower, upper;
  PetscReal *a; /* LAPACK's band storage with room for the fill of pivoting */
  int *pivot;
} Band;

PetscErrorCode BandCreate(PetscInt n, PetscInt lower, PetscInt upper, Band *band);
PetscErrorCode BandDestroy(Band *band);
PetscErrorCode BandFactor(Band *band);
PetscErrorCode BandFactorShifted(Band *band);
PetscErrorCode BandSolve(const Band *band, PetscBool transpose, PetscInt columns, PetscReal b[]);
PetscErrorCode BandCholesky(PetscInt n, PetscInt width, const PetscReal rows[], PetscReal R[]);
void BandUpperMult(PetscInt n, PetscInt upper, const PetscReal R[], PetscBool transpose,
                   PetscReal x[]);
void BandUpperSolve(PetscInt n, PetscInt upper, const PetscReal R[], PetscBool transpose,
                    PetscReal x[]);

/* The place of entry (i, j), |i - j| within the band. */
static inline PetscReal *BandAt(const Band *band, PetscInt i, PetscInt j) {
  return band->a + (2 * band->lower + band->upper + 1) * j + band->lower + band->upper + i - j;
}

#endif
