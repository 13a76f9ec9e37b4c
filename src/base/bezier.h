/* Bezier curves: a cell's cubic by the four points that hold it, in the plane or in space. Points
   lie one behind the other, of `dims` coordinates each. */
#ifndef TENDRIL_BEZIER_H
#define TENDRIL_BEZIER_H

#include <petscsys.h>

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
