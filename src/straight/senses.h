/* Eigenvalues of the straight rod whose material learns its natural curvature (material/tropism.h).
   To the linear problem D y_t = K y comes k, which takes the place of the bend that costs nothing:

     a N phi0 (y_t + ..) = -(B (y_pp - k))_pp - (P y_p)_p
     k_t + drift k_p = e (f - G y_pp + I (y_pp - k)),   S = -turn y_p - aside y
     f = S; or with memory T (f_t + drift f_p) = S - f;   at the tip: f one number, of S there

   A problem that is linear in the rate, not symmetric, and larger by k (and f) at the Gauss points
   of each cell, of a discontinuous method (upwind) where the material drifts. Frozen in time for
   the material, for feed at fixed arc length, with a growth zone at fixed distance from the tip:
   there the problem depends on time by the length alone. What the zone lays down stays: what of it
   has gone by the place of the clamp has turned the rod by Theta and moved it by Y,

     Theta_t = L_t y_pp(0),   Y_t = L_t Theta,   y + Y + Theta p and y_p + Theta in place of y and
   y_p

   of which Y counts where a lamp is, and else as L_t Theta, with which friction feels it. */
#ifndef TENDRIL_SENSES_H
#define TENDRIL_SENSES_H

#include "straight/spectrum.h"

/* A place in the matrices of (A - rate B) z = 0. */
typedef struct {
  PetscInt row, col;
  PetscReal a, b;
} SensesEntry;

/* Unknowns that are no place's: the tip's signal, Theta and Y. */
enum { MOST_GLOBAL = 3 };

/* Of A, and of B (with b): its column, its row [n], and its row by all of these. */
typedef struct {
  PetscReal *column, *column_b, *row, *row_b;
  PetscReal corner[MOST_GLOBAL], corner_b[MOST_GLOBAL];
} SensesGlobal;

typedef struct {
  Scene scene;
  StraightWay way;
  PetscInt cells;
  Mesh mesh;
  Pencil pencil; /* on it; NULL: none yet */
  PetscInt of;   /* unknowns of a node: w, c, n, and k (and f) of the cell behind it */
  PetscInt n;    /* of all, without those that are no place's: */
  PetscInt globals, signal, turned, moved; /* so many; which is the signal, Theta, Y; -1: none */
  SensesGlobal global[MOST_GLOBAL];
  PetscInt entries, room;
  SensesEntry *entry;
  PetscReal scale; /* of rates: the largest clock */
} Senses;

PetscErrorCode SensesCreate(Scene scene, PetscInt cells, StraightWay way, Senses *senses);
PetscErrorCode SensesDestroy(Senses *senses);
PetscErrorCode SensesRightmost(Senses *senses, PetscReal t, Eigenvalue *value);
PetscErrorCode SensesNear(Senses *senses, PetscReal t, Eigenvalue *value, PetscReal c[],
                          PetscReal w[]);

#endif
