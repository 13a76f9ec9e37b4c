/* Cubic B-splines on evenly spaced knots: smooth interpolation of large grids. Along a line of n
   values there are n + 2 coefficients; four of them count at a place. */
#ifndef TENDRIL_EVEN_H
#define TENDRIL_EVEN_H

#include <petscsys.h>

enum { EVEN_LEAST = 4 }; /* values along a line, at least */

/* The splines that are not 0 at a place: the first of them, their values, slopes and second
   derivatives, by the place in the grid's own unit. */
typedef struct {
  PetscInt first;
  PetscReal value[4], slope[4], curve[4];
} EvenSplines;

void EvenCoefficients(PetscInt n, const PetscReal f[], PetscReal work[], PetscReal c[]);
PetscReal EvenValues(PetscInt n, PetscReal at, EvenSplines *splines);
void EvenEvaluate(PetscInt n, PetscReal at, EvenSplines *splines);

#endif
