/* Quaternions and the directors that they stand for: R(p) = (d1 d2 d3) / |p|^2, so that the
   directors have length 1 whatever p has. */
#ifndef TENDRIL_DIRECTORS_H
#define TENDRIL_DIRECTORS_H

#include "base/vectors.h"

static inline PetscReal QuaternionSize(const PetscReal p[4]) {
  return Dot4(p, p);
}

/* The directors d[k], k = 0 the tangent, of p, |p|^2 = size. */
static inline void Directors(const PetscReal p[4], PetscReal size, PetscReal d[3][3]) {
  const PetscReal f = 1 / size, a = p[0], b = p[1], c = p[2], e = p[3];

  d[0][0] = f * (a * a + b * b - c * c - e * e);
  d[0][1] = f * 2 * (b * c + a * e);
  d[0][2] = f * 2 * (b * e - a * c);
  d[1][0] = f * 2 * (b * c - a * e);
  d[1][1] = f * (a * a - b * b + c * c - e * e);
  d[1][2] = f * 2 * (c * e + a * b);
  d[2][0] = f * 2 * (b * e + a * c);
  d[2][1] = f * 2 * (c * e - a * b);
  d[2][2] = f * (a * a - b * b - c * c + e * e);
}

/* Half the derivative of |p|^2 d_k by p, which is linear in p. */
static inline void DirectorForm(const PetscReal p[4], int k, PetscReal A[3][4]) {
  const PetscReal a = p[0], b = p[1], c = p[2], e = p[3];
  const PetscReal form[3][3][4] = {{{a, b, -c, -e}, {e, c, b, a}, {-c, e, -a, b}},
                                   {{-e, c, b, -a}, {a, -b, c, -e}, {b, a, e, c}},
                                   {{c, e, a, b}, {-b, -a, e, c}, {a, -b, -c, e}}};

  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++) A[i][j] = form[k][i][j];
}

/* The derivative of d_k by p. */
static inline void DirectorSlope(const PetscReal p[4], PetscReal size, const PetscReal d[3], int k,
                                 PetscReal D[3][4]) {
  DirectorForm(p, k, D);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++) D[i][j] = 2 / size * (D[i][j] - d[i] * p[j]);
}

/* The derivative by p of the rate d_t = D p_t at which d_k changes, p_t held:
     (A(p_t) - (p.p_t) D - d p_t^T - d_t p^T) 2/|p|^2,   A that of DirectorForm(). */
static inline void DirectorRateSlope(const PetscReal p[4], PetscReal size, const PetscReal d[3],
                                     const PetscReal d_t[3], int k, const PetscReal D[3][4],
                                     const PetscReal p_t[4], PetscReal by[3][4]) {
  const PetscReal dot = Dot4(p, p_t);

  DirectorForm(p_t, k, by);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++)
      by[i][j] = 2 / size * (by[i][j] - dot * D[i][j] - d[i] * p_t[j] - d_t[i] * p[j]);
}

/* r = p (0, u) */
static inline void QuaternionTurn(const PetscReal p[4], const PetscReal u[3], PetscReal r[4]) {
  r[0] = -p[1] * u[0] - p[2] * u[1] - p[3] * u[2];
  r[1] = p[0] * u[0] + p[2] * u[2] - p[3] * u[1];
  r[2] = p[0] * u[1] + p[3] * u[0] - p[1] * u[2];
  r[3] = p[0] * u[2] + p[1] * u[1] - p[2] * u[0];
}

/* The spin about d1 of a frame whose quaternion changes at p_t: 2 (p* p_t)_1 / |p|^2. */
static inline PetscReal QuaternionSpin(const PetscReal p[4], PetscReal size,
                                       const PetscReal p_t[4]) {
  return 2 / size * (p[0] * p_t[1] - p[1] * p_t[0] - p[2] * p_t[3] + p[3] * p_t[2]);
}

/* ... of which the product changes so by p_t; and by p with the sign of SpinForm(p_t) turned. */
static inline void SpinForm(const PetscReal p[4], PetscReal form[4]) {
  form[0] = -p[1];
  form[1] = p[0];
  form[2] = p[3];
  form[3] = -p[2];
}

#endif
