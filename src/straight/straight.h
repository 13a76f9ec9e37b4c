/* The straight rod: its velocity v0, friction phi0 and compression P, and the linear problem
   D y_t = K y of a small deflection y on it (docs/theory/straight.md), in cubic B-splines: one
   unknown per node, D and K symmetric (K not for feed), fourth order. */
#ifndef TENDRIL_STRAIGHT_H
#define TENDRIL_STRAIGHT_H

#include "base/lagrange.h"
#include "scene/scene.h"
#include "straight/twist.h"

enum { BASIS = 4, BAND = 7 }; /* per cell; per row of K and D */

/* At one label: stretch and its slope, arc length and its rate, slide, speed V = p_t + c, factor N
   and drag N phi(V) of the load. */
typedef struct {
  PetscReal g, g_s, p, p_t, c, V, N, drag;
} StraightMotion;

typedef struct _Straight *Straight;
struct _Straight {
  Scene scene;
  const Mesh *mesh;
  StraightWay way;        /* x2 or x3 */
  PetscInt n;             /* unknowns, cells + 1 */
  PetscReal *basis;       /* [cells][GAUSS][3][BASIS]: B, B', B'' at the Gauss points */
  PetscReal *compression; /* [cells][GAUSS], at time */
  PetscReal time;
  PetscInt first, last;           /* the rows of the parts below */
  PetscReal assembled, length;    /* the time when they were assembled, and L then */
  PetscReal *bend, *press, *drag; /* K = bend + press, D = drag */
  PetscReal
      *curve; /* [cells][GAUSS][BASIS]: bend = -curve^T curve, of the cells that touch the rows */
};

PetscErrorCode StraightCreate(Scene scene, const Mesh *mesh, StraightWay way, Straight *straight);
PetscErrorCode StraightDestroy(Straight *straight);
PetscBool StraightScales(Scene scene);
PetscErrorCode StraightAt(Scene scene, PetscReal s, PetscReal t, StraightMotion *motion);
PetscErrorCode StraightTip(Scene scene, PetscReal t, PetscReal *press, PetscReal *turns,
                           PetscReal *drags);
PetscErrorCode StraightForce(Scene scene, PetscInt n, const PetscReal s[], PetscReal t,
                             PetscReal P[]);
PetscErrorCode StraightBands(Straight straight, PetscReal t, PetscInt first, PetscInt last,
                             PetscReal *K, PetscReal *D);
PetscErrorCode StraightApply(Straight straight, PetscReal t, PetscInt first, PetscInt last,
                             const PetscReal *y, const PetscReal *y_t, PetscReal *f);
void StraightBasis(Straight straight, PetscInt cell, PetscReal xi, PetscReal B[3][BASIS]);

#endif
