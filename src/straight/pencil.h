/* The linear problem D y_t = K y of the straight rod in a form that stays accurate on any mesh. The
   unknowns are w = y', in quadratic B-splines; y is their sum c = C w in the cubic splines of
   straight.h, C = E^-1 Delta (E takes differences). Then K is of second order in w, and no number
   suffers the h^-4 of the fourth-order matrix. D couples all of w, so solves use the mixed unknowns
   (w, c, n) of a node, n the shear force, which make it sparse again:
       K w - Delta n = 0,   E^T n + X w = lambda D c,   E c - Delta w = 0.
   The splines live on a coordinate z in [0,1], a map of the label s that is fixed in time: the
   share of arc length p(s, t_map) / L(t_map). However narrow the growth zone, nothing is steep in z
   near t_map. For uniform growth z = s, and this is algebraically the pencil of StraightBands. In a
   hinge y'(0) is free: the splines of y and w that are not 0 there are unknowns too, the first
   ones.

   Where twist joins the two directions across (twist.h) there are two of each kind of unknown, and
   K has, beside one block for each direction, those that join w2 and w3: K23 = - int B23 w2' w3' +
   T,    K32 = - int B23 w3' w2' - T,    <a, T b> = int M a b'  */
#ifndef TENDRIL_PENCIL_H
#define TENDRIL_PENCIL_H

#include "straight/twist.h"
#include <petscmat.h>

/* a map that follows the time: z = p / L at each PencilSetTime() */
static const PetscReal map_follows = -1;

enum { HALF = 3, WIDTH = 2 * HALF + 1 }; /* of all bands: column i - HALF + b of row i at b */
enum { PER_POINT = 10 };                 /* splines of a Gauss point: see Pencil.basis */

/* the forms that can be assembled; the first basis is that of the rows */
typedef enum {
  FORM_BEND,       /* int B (w/g)' (w/g)' / g, w by w */
  FORM_AXIAL,      /* int P/g w w, w by w */
  FORM_STIFF,      /* FORM_AXIAL - FORM_BEND: K where it is symmetric */
  FORM_BEND_RATIO, /* FORM_BEND weighted by ratio, w by w */
  FORM_DRAG,       /* D = int g a N phi y y, and the tip's, c by c */
  FORM_DRAG_RATE,  /* its derivative by t, c by c */
  FORM_MASS,       /* int y y ds, c by c */
  FORM_SLIDE,      /* X = - int a N phi slide y w, and the tip's, c by w */
  FORM_SLIDE_T,    /* its transpose, w by c */
  FORM_STIFF_3,    /* FORM_STIFF of x3, where the directions are joined */
  FORM_BEND_23,    /* int B23 (w/g)' (w/g)' / g, w by w */
  FORM_TORQUE,     /* T = int M w/g (w/g)', w by w */
  FORM_TORQUE_T    /* its transpose */
} PencilForm;

/* For sliding laws the time derivative may be taken at fixed label s, at fixed arc length, or at a
   fixed distance from the tip. */
typedef enum { FRAME_LABEL, FRAME_ARC, FRAME_TIP } PencilFrame;

typedef struct {
  PetscReal dz, ds, g, g_z, P, B, drag, drag_rate, slide, ratio; /* at a Gauss point; g = dp/dz */
  PetscReal B33, B23, M;                                         /* joined directions: B is B22 */
} PencilPoint;

/* The bands of a mixed pencil, [last - first][WIDTH], NULL where there is none. */
typedef struct {
  const PetscReal *K[MOST_WAYS], *K23, *K32; /* w by w; joined directions: of both, and between */
  const PetscReal *X, *XT;                   /* c by w, w by c */
  const PetscReal *c;                        /* c by c, added to A */
  const PetscReal *D;                        /* c by c, the only part of B */
} PencilBands;

/* The tip: n2 = - turns theta - drags y_t. */
typedef struct {
  PetscReal turns, drags, drags_rate, g;
} PencilTip;

typedef struct _Pencil *Pencil;
struct _Pencil {
  MPI_Comm comm;
  Scene scene;
  Growth growth;           /* the scene's */
  const Mesh *mesh;        /* nodes in z */
  PetscReal map;           /* t_map, or map_follows */
  PetscInt n, first, last; /* unknowns of each kind, cells + 1 + ahead; this rank's */
  PetscInt ahead;          /* 1: there is one more, the slope at a hinge, before the others */
  PetscInt cell, cells;    /* first cell that touches them, and how many */
  StraightWay way;
  PetscInt ways;  /* 2: joined directions; w, c and n of x2 and of x3 follow each other */
  PetscBool skew; /* there is X, for K is not symmetric */
  PetscInt held;  /* how many conditions hold the tip: 0; 1, y = 0; 2, y' = 0 as well */
  PencilTip tip;
  PencilPoint *point;         /* [cells][GAUSS] */
  PetscReal *basis;           /* [cells][GAUSS][10]: 3 of w, their 3 slopes, 4 of y */
  PetscReal *delta;           /* this rank's diagonal of Delta */
  PetscReal *z, *label;       /* all Gauss points from cell on, and 1; their labels */
  PetscReal *stretch, *force; /* s_z and P there */
  PetscReal *turn;            /* the angle of the section, joined directions */
  PetscReal *node;            /* labels of the cells + 1 nodes */
  PetscReal time, moment;     /* M, joined directions */
  PetscReal compression, drag_min, drag_max, rate_max; /* extremes of P^2/B, drag, (ln D)_t */
};

PetscErrorCode PencilCreate(MPI_Comm comm, Scene scene, const Mesh *mesh, PetscReal map,
                            StraightWay way, Pencil *pencil);
PetscErrorCode PencilDestroy(Pencil *pencil);
PetscErrorCode PencilSetTime(Pencil pencil, PetscReal t, PencilFrame frame);
PetscErrorCode PencilDrift(Pencil pencil, PetscReal s, PetscReal t, PencilFrame frame,
                           PetscReal *drift);
PetscErrorCode PencilBound(Pencil pencil, PetscReal *bound);
PetscErrorCode PencilBand(Pencil pencil, PencilForm form, PetscReal band[]);
PetscErrorCode PencilMatrix(Pencil pencil, PencilForm form, Mat *A);
PetscErrorCode PencilMatrixFromBand(Pencil pencil, const PetscReal band[], Mat *A);
PetscErrorCode PencilDifference(Pencil pencil, Mat *E);
PetscErrorCode PencilMixed(Pencil pencil, const PencilBands *bands, Mat *A, Mat *B);
PetscBool PencilIsHeld(Pencil pencil, PetscInt node, PetscInt kind);
PetscErrorCode PencilSum(Pencil pencil, Vec w, Vec c);
PetscErrorCode PencilSumTranspose(Pencil pencil, Vec c, Vec w);
PetscErrorCode PencilUnsumTranspose(Pencil pencil, Mat E, Vec w, Vec c);
PetscErrorCode PencilUnsum(Pencil pencil, Mat E, Vec c, Vec w);
PetscErrorCode PencilShape(Pencil pencil, const PetscReal c[], const PetscReal w[], PetscReal t,
                           PetscReal y[], PetscReal theta[]);

#endif
