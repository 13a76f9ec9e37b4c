#include "base/even.h"

/*
  EvenCoefficients - the coefficients of the cubic spline through evenly spaced values.

  n     how many values, EVEN_LEAST at least
  f     [n]
  work  [n]
  c     [n + 2]; the spline at knot i is (c_i + 4 c_{i+1} + c_{i+2})/6

  End conditions: not-a-knot (the third derivative does not jump across the first and the last inner
  knot), so that the spline is of fourth order up to the ends and exact for cubics.
*/
void EvenCoefficients(PetscInt n, const PetscReal f[], PetscReal work[], PetscReal c[]) {
  /* not-a-knot says the coefficients next to the ends outright: the fourth difference is 0 there */
  c[2] = f[1] - (f[0] - 2 * f[1] + f[2]) / 6;
  c[n - 1] = f[n - 2] - (f[n - 3] - 2 * f[n - 2] + f[n - 1]) / 6;
  /* between them c_{i-1} + 4 c_i + c_{i+1} = 6 f_{i-1}: elimination without pivots */
  work[2] = 0;
  for (PetscInt i = 3; i < n - 1; i++) {
    work[i] = 1 / (4 - work[i - 1]);
    c[i] = (6 * f[i - 1] - c[i - 1]) * work[i];
  }
  for (PetscInt i = n - 2; i > 2; i--) c[i] -= work[i] * c[i + 1];
  for (PetscInt i = 1; i >= 0; i--) {
    c[i] = 6 * f[i] - 4 * c[i + 1] - c[i + 2];
    c[n + 1 - i] = 6 * f[n - 1 - i] - 4 * c[n - i] - c[n - 1 - i];
  }
}

/* EvenValues - the splines at a place between 0 and n - 1, in which value i is at i; outside, the
   cubics of the ends go on. Their derivatives are left as they are. Returns where in its cell the
   place is. */
PetscReal EvenValues(PetscInt n, PetscReal at, EvenSplines *splines) {
  const PetscReal cell = PetscMax(0, PetscMin(n - 2, PetscFloorReal(at)));
  const PetscReal b = at - cell, a = 1 - b;

  splines->first = (PetscInt)cell;
  splines->value[0] = a * a * a / 6;
  splines->value[1] = (4 + 3 * b * b * (b - 2)) / 6;
  splines->value[2] = (4 + 3 * a * a * (a - 2)) / 6;
  splines->value[3] = b * b * b / 6;
  return b;
}

/* EvenEvaluate - the same with their derivatives. */
void EvenEvaluate(PetscInt n, PetscReal at, EvenSplines *splines) {
  const PetscReal b = EvenValues(n, at, splines), a = 1 - b;

  splines->slope[0] = -a * a / 2;
  splines->slope[1] = b * (3 * b - 4) / 2;
  splines->slope[2] = -a * (3 * a - 4) / 2;
  splines->slope[3] = b * b / 2;
  splines->curve[0] = a;
  splines->curve[1] = 3 * b - 2;
  splines->curve[2] = 3 * a - 2;
  splines->curve[3] = b;
}
