/* Eigenvalues of the straight rod's linear problem at one time (SLEPc). */
#ifndef TENDRIL_SPECTRUM_H
#define TENDRIL_SPECTRUM_H

#include "straight/pencil.h"
#include <slepceps.h>

/* The largest eigenvalue of A = D^-1 K, or the largest rate of growth in the friction norm. */
typedef enum { RATE_A, RATE_FRICTION } SpectrumRate;

typedef struct {
  PetscReal value, frequency; /* real part; imaginary part, >= 0 */
  PetscReal error;            /* bound from the residual of the eigenvector */
} Eigenvalue;

/* One eigenvalue problem solved over and over at different times: keeps its matrices and solver. */
typedef struct {
  Pencil pencil;
  EPS eps;
  Mat A, B;
  PetscReal shift;
  PetscReal rate;     /* a rate in the matrices' units, see Units */
  PetscBool quiet;    /* takes no options from the command line */
  PetscBool inverted; /* buckling: about a shift, from now on */
} Spectrum;

PetscErrorCode SpectrumReadOptions(void);
PetscErrorCode SpectrumCreate(Pencil pencil, PetscBool quiet, Spectrum *spectrum);
PetscErrorCode SpectrumDestroy(Spectrum *spectrum);
PetscErrorCode SpectrumLargest(Spectrum *spectrum, SpectrumRate rate, PetscReal t,
                               Eigenvalue *value, PetscReal c[], PetscReal w[]);
PetscErrorCode SpectrumBuckling(Spectrum *spectrum, PetscReal t, Eigenvalue *ratio, PetscReal c[],
                                PetscReal w[]);
PetscErrorCode SpectrumDense(Pencil pencil, PetscReal shift, PetscBool symmetric, PetscReal T[]);
PetscErrorCode SpectrumRightmost(Pencil pencil, PetscReal t, Eigenvalue *value);
PetscErrorCode SpectrumLeftVectors(Pencil pencil, PetscReal t, PetscBool unit_rows, PetscReal W[]);

#endif
