/* Vectors in space, and quaternions, by their components. */
#ifndef TENDRIL_VECTORS_H
#define TENDRIL_VECTORS_H

#include <petscsys.h>

static inline PetscReal Dot3(const PetscReal a[3], const PetscReal b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Cross3 - c = a x b; c is neither of them. */
static inline void Cross3(const PetscReal a[3], const PetscReal b[3], PetscReal c[3]) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Of four: quaternions, and rows by one. */
static inline PetscReal Dot4(const PetscReal a[4], const PetscReal b[4]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

static inline PetscReal Size3(const PetscReal a[3]) {
  return PetscSqrtReal(Dot3(a, a));
}

/* c = a - b */
static inline void Minus3(const PetscReal a[3], const PetscReal b[3], PetscReal c[3]) {
  for (int d = 0; d < 3; d++) c[d] = a[d] - b[d];
}

/* Names its components. */
static inline void Split3(const PetscReal a[3], PetscReal *x, PetscReal *y, PetscReal *z) {
  *x = a[0];
  *y = a[1];
  *z = a[2];
}

/* b = s a */
static inline void Times3(PetscReal s, const PetscReal a[3], PetscReal b[3]) {
  for (int d = 0; d < 3; d++) b[d] = s * a[d];
}

static inline void Zero3(PetscReal a[3]) {
  for (int d = 0; d < 3; d++) a[d] = 0;
}

/* Column3 - column c of a matrix of three rows, each of n. */
static inline void Column3(const PetscReal *M, int n, int c, PetscReal column[3]) {
  for (int d = 0; d < 3; d++) column[d] = M[d * n + c];
}

/* ColumnDot3 - its product with x. */
static inline PetscReal ColumnDot3(const PetscReal *M, int n, int c, const PetscReal x[3]) {
  return M[c] * x[0] + M[n + c] * x[1] + M[2 * n + c] * x[2];
}

/* TurnAbout3 - v turned about an axis of length 1 by an angle (Rodrigues). */
static inline void TurnAbout3(const PetscReal a[3], PetscReal angle, const PetscReal v[3],
                              PetscReal w[3]) {
  const PetscReal c = PetscCosReal(angle), s = PetscSinReal(angle), along = (1 - c) * Dot3(a, v);
  PetscReal across[3];

  Cross3(a, v, across);
  for (int d = 0; d < 3; d++) w[d] = c * v[d] + s * across[d] + along * a[d];
}

/* Turn3 - y = M x;  TurnBack3 - y = M^T x. x is not y. */
static inline void Turn3(const PetscReal M[3][3], const PetscReal x[3], PetscReal y[3]) {
  for (int d = 0; d < 3; d++) y[d] = Dot3(M[d], x);
}

static inline void TurnBack3(const PetscReal M[3][3], const PetscReal x[3], PetscReal y[3]) {
  for (int d = 0; d < 3; d++) y[d] = ColumnDot3(M[0], 3, d, x);
}

#endif
