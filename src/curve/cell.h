/* A cell of a rod's centre line, whatever the model: the cubic through place and slope at both its
   ends, how that moves, and how it changes with the unknowns there. Vectors have three components;
   in the plane the third is 0. */
#ifndef TENDRIL_CURVE_CELL_H
#define TENDRIL_CURVE_CELL_H

#include "base/hermite.h"
#include "base/plane.h"
#include "base/vectors.h"

/* The points of a cell that laws are known at, in this order. */
enum { AT_A, AT_MID, AT_B };

/*
  CurveParabola - the parts that values at both ends of a cell and between them have in a place z of
  the parabola through them, and in its slope by z; either may be NULL.
*/
static inline void CurveParabola(PetscReal z, PetscReal value[3], PetscReal slope[3]) {
  if (value) {
    value[0] = (1 - z) * (1 - 2 * z);
    value[1] = 4 * z * (1 - z);
    value[2] = z * (2 * z - 1);
  }
  if (slope) {
    slope[0] = 4 * z - 3;
    slope[1] = 4 - 8 * z;
    slope[2] = 4 * z - 1;
  }
}

/* CurveSum - of the values, those of a law at the three points of a cell, by their parts. */
static inline PetscReal CurveSum(const PetscReal part[3], const PetscReal at[3]) {
  return part[0] * at[0] + part[1] * at[1] + part[2] * at[2];
}

static inline Vector2 CurveSum2(const PetscReal part[3], Vector2 a, Vector2 mid, Vector2 b) {
  return Along2(Along2(Times2(part[0], a), part[1], mid), part[2], b);
}

/* CurveBetween - the parabola at z. */
static inline PetscReal CurveBetween(const PetscReal at[3], PetscReal z) {
  PetscReal part[3];
  CurveParabola(z, part, NULL);
  return CurveSum(part, at);
}

/* CurveBetweenSlope - ... and its derivative by z. */
static inline PetscReal CurveBetweenSlope(const PetscReal at[3], PetscReal z) {
  PetscReal part[3];
  CurveParabola(z, NULL, part);
  return CurveSum(part, at);
}

/*
  CurveMid - the middle of the cubic from a to b, of the slopes a', b' by the label:

    y_mid = (y_a + y_b)/2 + k (y'_a - y'_b),    k = h/8, or 0 in a formula of order 2
*/
static inline PetscReal CurveMid(PetscReal k, PetscReal a, PetscReal slope_a, PetscReal b,
                                 PetscReal slope_b) {
  return (a + b) / 2 + k * (slope_a - slope_b);
}

static inline Vector2 CurveMid2(PetscReal k, Vector2 a, Vector2 slope_a, Vector2 b,
                                Vector2 slope_b) {
  return Along2(Over2(Plus2(a, b), 2), k, Minus2(slope_a, slope_b));
}

/* CurveMidOf - what one end gives to that, where it is summed up end by end; k is -h/8 of b. */
static inline PetscReal CurveMidOf(PetscReal k, PetscReal a, PetscReal slope_a) {
  return a / 2 + k * slope_a;
}

static inline Vector2 CurveMidOf2(PetscReal k, Vector2 a, Vector2 slope_a) {
  return Along2(Over2(a, 2), k, slope_a);
}

/* The cubic of a cell, and how it moves. */
typedef struct {
  PetscReal h;                        /* length of its labels */
  PetscReal g[2], x[2][3], q[2][3];   /* at its ends: stretch, place, direction; x' = g q */
  PetscReal x_t[2][3], slope_t[2][3]; /* rates of x and x' at fixed labels */
  PetscReal c[3]; /* the slide of the material past these: at the ends and between them */
} CurveCell;

/* A place 0 <= z <= 1 of it: x and its derivatives by z. */
typedef struct {
  PetscReal z, x[3], slope[3], bend[3];
} CurvePlace;

/* How fast the material there moves; its tangent t; both by z; the size of x_z, and the slide. */
typedef struct {
  PetscReal v[3], v_z[3], t[3], t_z[3], size, c;
} CurveMotion;

/* The sum of values at the ends and slopes there by z, by Hermite's polynomials. */
static inline PetscReal CurveHermite(const PetscReal poly[4], PetscReal a, PetscReal a_z,
                                     PetscReal b, PetscReal b_z) {
  return poly[0] * a + poly[1] * a_z + poly[2] * b + poly[3] * b_z;
}

/* CurvePlaceAt - x, x_z and x_zz at place->z. */
static inline void CurvePlaceAt(const CurveCell *cell, CurvePlace *place) {
  const PetscReal *a = cell->x[0], *b = cell->x[1],
                  length[2] = {cell->h * cell->g[0], cell->h * cell->g[1]};
  PetscReal value[4], slope[4], bend[4];

  Hermite(place->z, value, slope, bend);
  for (int d = 0; d < 3; d++) {
    const PetscReal a_z = length[0] * cell->q[0][d], b_z = length[1] * cell->q[1][d];
    place->x[d] = CurveHermite(value, a[d], a_z, b[d], b_z);
    place->slope[d] = CurveHermite(slope, a[d], a_z, b[d], b_z);
    place->bend[d] = CurveHermite(bend, a[d], a_z, b[d], b_z);
  }
}

/*
  CurveBezier - the points b[4][dims] of its Bezier polygon, which hold it:

    b0 = x0,   b1 = x0 + h g0 q0/3,   b2 = x1 - h g1 q1/3,   b3 = x1
*/
static inline void CurveBezier(int dims, const CurveCell *cell, PetscReal *b) {
  const PetscReal *g = cell->g, h = cell->h;

  for (int d = 0; d < dims; d++) {
    b[d] = cell->x[0][d];
    b[dims + d] = b[d] + h * g[0] * cell->q[0][d] / 3;
    b[3 * dims + d] = cell->x[1][d];
    b[2 * dims + d] = b[3 * dims + d] - h * g[1] * cell->q[1][d] / 3;
  }
}

/* CurveRates - x_t and x_zt at a place that stays where it is in the cell. */
static inline void CurveRates(const CurveCell *cell, PetscReal z, PetscReal x_t[3],
                              PetscReal slope_t[3]) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(z, value, slope, bend);
  for (int d = 0; d < 3; d++) {
    const PetscReal a = cell->x_t[0][d], a_z = cell->h * cell->slope_t[0][d], b = cell->x_t[1][d],
                    b_z = cell->h * cell->slope_t[1][d];
    x_t[d] = CurveHermite(value, a, a_z, b, b_z);
    slope_t[d] = CurveHermite(slope, a, a_z, b, b_z);
  }
}

/* CurveMove - v = x_t + c t at a place that CurvePlaceAt() knows; t = x_z/|x_z|. */
static inline void CurveMove(const CurveCell *cell, const CurvePlace *place, CurveMotion *m) {
  const PetscReal c_z = CurveBetweenSlope(cell->c, place->z);
  PetscReal along, x_t[3], slope_t[3];

  CurveRates(cell, place->z, x_t, slope_t);
  m->size = PetscSqrtReal(Dot3(place->slope, place->slope));
  m->c = CurveBetween(cell->c, place->z);
  for (int d = 0; d < 3; d++) m->t[d] = place->slope[d] / m->size;
  along = Dot3(m->t, place->bend);
  for (int d = 0; d < 3; d++) {
    m->t_z[d] = (place->bend[d] - m->t[d] * along) / m->size;
    m->v[d] = x_t[d] + m->c * m->t[d];
    m->v_z[d] = slope_t[d] + c_z * m->t[d] + m->c * m->t_z[d];
  }
}

/* How direction and rate of x' at an end change with what turns it, an angle in the plane, a
   quaternion in space; shifts of the rates of x. */
typedef struct {
  PetscReal q[3][4], slope_t[3][4], shift[3];
} CurveEnd;

/* CurveEndInPlane - of an end at an angle, direction q: derivatives of q are q_perp, of that -q;
   shift that of the rate of the angle. */
static inline void CurveEndInPlane(Vector2 q, PetscReal theta_t, PetscReal g, PetscReal g_t,
                                   PetscReal shift, CurveEnd *end) {
  const Vector2 perp = Left2(q), turned = Minus2(Times2(shift, perp), Times2(theta_t, q)),
                slope_t = Along2(Times2(g_t, perp), g, turned);

  end->q[0][0] = perp.x;
  end->q[1][0] = perp.y;
  end->slope_t[0][0] = slope_t.x;
  end->slope_t[1][0] = slope_t.y;
}

/* Derivatives by the unknowns of the nodes at both ends, those of the second behind the first's:
   place, what turns, and as many more as a node has, on which the curve does not depend. */
enum { CURVE_NODE = 10 };
typedef PetscReal CurveBy[3][2 * CURVE_NODE];

/* The dimension below is a constant of each call: in the plane a node has 2 + 1 unknowns, in space
   3 + 4. */
static inline int CurveTurns(int dims) {
  return dims == 2 ? 1 : 4;
}

/* CurvePlaceBy - the derivatives of x and x_z at a fixed z; node: how many unknowns a node has. */
static inline void CurvePlaceBy(int dims, int node, const CurveCell *cell,
                                const CurveEnd *const end[2], PetscReal z, CurveBy x,
                                CurveBy slope) {
  PetscReal value[4], by[4], bend[4];

  Hermite(z, value, by, bend);
  for (int d = 0; d < dims; d++)
    for (int e = 0; e < 2; e++) {
      const PetscReal length = cell->h * cell->g[e], *turn = end[e]->q[d];
      PetscReal *to = x[d] + node * e, *slope_to = slope[d] + node * e;
      for (int f = 0; f < node; f++) to[f] = slope_to[f] = 0;
      to[d] = value[2 * e];
      slope_to[d] = by[2 * e];
      for (int j = 0; j < CurveTurns(dims); j++) {
        to[dims + j] = value[2 * e + 1] * (length * turn[j]);
        slope_to[dims + j] = by[2 * e + 1] * (length * turn[j]);
      }
    }
}

/* CurveMotionBy - those of the tangent and of the velocity, after CurvePlaceBy():
     dt = (I - t t^T) dx_z/|x_z|,   dv = dx_t + c dt  */
static inline void CurveMotionBy(int dims, int node, const CurveCell *cell,
                                 const CurveEnd *const end[2], PetscReal z, const CurveMotion *m,
                                 CurveBy x, CurveBy slope, CurveBy t, CurveBy v) {
  PetscReal value[4], by[4], bend[4];

  Hermite(z, value, by, bend);
  for (int u = 0; u < 2 * node; u++) {
    const int e = u / node, f = u % node;
    PetscReal along = 0;
    for (int d = 0; d < dims; d++) along += m->t[d] * slope[d][u];
    for (int d = 0; d < dims; d++) {
      t[d][u] = (slope[d][u] - m->t[d] * along) / m->size;
      v[d][u] = m->c * t[d][u];
      if (f < dims)
        v[d][u] += end[e]->shift[f] * x[d][u];
      else if (f < dims + CurveTurns(dims))
        v[d][u] += value[2 * e + 1] * cell->h * end[e]->slope_t[d][f - dims];
    }
  }
}

#endif
