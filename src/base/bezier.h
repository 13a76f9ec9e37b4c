/* Bezier curves: a cell's cubic by the four points that hold it, in the plane or in space. Points
   lie one behind the other, of `dims` coordinates each. */
#ifndef TENDRIL_BEZIER_H
#define TENDRIL_BEZIER_H

#include <petscsys.h>

/*
  BezierOfCell - the points b[4][dims] of the cubic from x[0] to x[1], whose slopes by the label are
  g[0] q[0] and g[1] q[1] at its ends:

    b0 = x0,   b1 = x0 + h g0 q0/3,   b2 = x1 - h g1 q1/3,   b3 = x1
*/
static inline void BezierOfCell(int dims, PetscReal h, const PetscReal g[2], const PetscReal *x,
                                const PetscReal *q, PetscReal *b) {
  for (int d = 0; d < dims; d++) {
    b[d] = x[d];
    b[dims + d] = b[d] + h * g[0] * q[d] / 3;
    b[3 * dims + d] = x[dims + d];
    b[2 * dims + d] = b[3 * dims + d] - h * g[1] * q[dims + d] / 3;
  }
}

/* BezierDivide - the two halves half[2][4][dims] of a curve (de Casteljau). */
static inline void BezierDivide(int dims, const PetscReal *b, PetscReal *half) {
  PetscReal *left = half, *right = half + 4 * dims;

  for (int d = 0; d < dims; d++) {
    const PetscReal p = (b[d] + b[dims + d]) / 2, q = (b[dims + d] + b[2 * dims + d]) / 2,
                    r = (b[2 * dims + d] + b[3 * dims + d]) / 2, pq = (p + q) / 2, qr = (q + r) / 2;
    left[d] = b[d];
    left[dims + d] = p;
    left[2 * dims + d] = pq;
    left[3 * dims + d] = right[d] = (pq + qr) / 2;
    right[dims + d] = qr;
    right[2 * dims + d] = r;
    right[3 * dims + d] = b[3 * dims + d];
  }
}

#endif
