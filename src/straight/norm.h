/* The fastest growth that a norm |y|_G^2 = y^T G y sees at one time: the largest eigenvalue of
   G A + A^T G against a second norm, G dense or sparse, nothing formed. */
#ifndef TENDRIL_NORM_H
#define TENDRIL_NORM_H

#include "straight/spectrum.h"

typedef struct {
  Pencil pencil;
  EPS eps;
  Mat K, X, E, D, M; /* K and X act on w, the others on c */
  PetscReal *W;      /* this rank's columns of W, row k at k * nloc; NULL: G = M */
  PetscReal *drag;   /* its weight against D at the Gauss points, for the preconditioner */
  PetscReal *all;    /* n values */
  Mat form, norm;    /* the shells */
  Mat mixed;         /* the preconditioner, factored by a KSP of its own */
  KSP solve_drag, solve_mixed;
  Vec c[4], w[2], z[2], guess;
  PetscReal tolerance; /* on the residual, as asked for */
  PetscBool started;
} Norm;

PetscErrorCode NormCreate(Pencil pencil, const PetscReal W[], PetscReal at, Norm *norm);
PetscErrorCode NormDestroy(Norm *norm);
PetscErrorCode NormGrowth(Norm *norm, PetscReal t, PencilFrame frame, Eigenvalue *value);

#endif
