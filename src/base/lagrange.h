/* Lagrange's polynomials on a few points, and Gauss-Legendre's rule. */
#ifndef TENDRIL_LAGRANGE_H
#define TENDRIL_LAGRANGE_H

#include <petscsys.h>

void LagrangeValues(PetscInt n, const PetscReal points[], PetscReal t, PetscReal L[]);
void LagrangeSlopes(PetscInt n, const PetscReal points[], PetscReal t, PetscReal D[]);

/* Gauss-Legendre points and weights on [0,1], for integrals over a cell. */
enum { GAUSS = 4 };
extern const PetscReal gauss_point[GAUSS], gauss_weight[GAUSS];

#endif
