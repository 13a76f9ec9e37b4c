#include "base/lagrange.h"

/* (as PetscDTGaussQuadrature() has them, but constant: inner loops over the points unroll) */
const PetscReal gauss_point[GAUSS] = {0.069431844202973712, 0.330009478207571868,
                                      0.669990521792428132, 0.930568155797026288};
const PetscReal gauss_weight[GAUSS] = {0.173927422568726929, 0.326072577431273071,
                                       0.326072577431273071, 0.173927422568726929};

/* LagrangeValues - at t, the values of the polynomials L_k that are 1 at points[k] and 0 at the
   others. */
void LagrangeValues(PetscInt n, const PetscReal points[], PetscReal t, PetscReal L[]) {
  for (PetscInt k = 0; k < n; k++) {
    L[k] = 1;
    for (PetscInt j = 0; j < n; j++)
      if (j != k) L[k] *= (t - points[j]) / (points[k] - points[j]);
  }
}

/* LagrangeSlopes - their derivatives at t: sum over i of 1/(x_k - x_i) prod over the others j of
   (t - x_j)/(x_k - x_j). */
void LagrangeSlopes(PetscInt n, const PetscReal points[], PetscReal t, PetscReal D[]) {
  for (PetscInt k = 0; k < n; k++) {
    D[k] = 0;
    for (PetscInt i = 0; i < n; i++) {
      PetscReal product;
      if (i == k) continue;
      product = 1 / (points[k] - points[i]);
      for (PetscInt j = 0; j < n; j++)
        if (j != k && j != i) product *= (t - points[j]) / (points[k] - points[j]);
      D[k] += product;
    }
  }
}
