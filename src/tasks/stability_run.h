/* A run of -task stability: what its files share. */
#ifndef TENDRIL_STABILITY_RUN_H
#define TENDRIL_STABILITY_RUN_H

#include "straight/norm.h"
#include "straight/senses.h"
#include "tasks/critical.h"

/* The curves of the stability figure. */
typedef enum { CURVE_A, CURVE_L2, CURVE_W, CURVE_FRICTION, CURVES } Curve;

/* What is said of each. */
typedef struct {
  const char *name, *heading, *text, *verdict;
} CurveText;

extern const CurveText stability_curve[CURVES];

typedef struct {
  PetscReal start, end;
  PetscInt points, vertices;
  PetscBool end_given, unit_rows, only_modes;
  PetscBool transient; /* and its window and size */
  PetscReal t1, t2;
  PetscInt transient_cells;
  PetscBool t1_given, t2_given;
  char shape[PETSC_MAX_PATH_LEN];
} Settings;

/* The solvers for deflections of one way. */
typedef struct {
  StraightWay way;
  Pencil follow, fixed; /* z moving with t for A, fixed at t_cr for the norms */
  Spectrum modes, friction;
  Norm l2, left;
  Senses few,
      all; /* in their place, of a rod whose material learns: modes of few cells, and of all */
} Solvers;

typedef struct _Stability Stability;
struct _Stability {
  Scene scene;
  MPI_Comm comm; /* of the solvers */
  HdfFile file, shape_file;
  Settings set;
  Mesh mesh;
  PetscInt ways; /* to look at by themselves, see StraightWays() */
  Solvers of[MOST_WAYS];
  PetscBool twisted; /* x2 and x3 are joined */
  PetscBool learns;  /* what the material learns is a part of each mode */
  PetscBool quiet;   /* takes no options of solvers */
  PetscBool has[CURVES];
  Critical critical;
  PetscReal *t, *value[CURVES], *frequency; /* [points] */
  PetscReal *modes[MOST_WAYS];              /* the curve of A of each way [points] */
  PetscReal until[CURVES];                  /* the verdict; start: not even there */
  PetscBool beyond[CURVES];                 /* still stable at the end of what was looked at */
  Bends bends;                              /* of the scene's tables, in time */
  PetscReal straight_on;                    /* ... between which these go on straight */
  Stability *few;                           /* on few vertices, where there are any; else NULL */
};

/* stability_curves.c */
PetscErrorCode StabilityTabulate(Stability *self);
PetscErrorCode StabilityVerdict(Stability *self, Curve curve);

/* stability_report.c */
PetscErrorCode StabilityPrint(const Stability *self);
PetscErrorCode StabilityWrite(HdfFile file, Stability *self);
PetscErrorCode StabilityTransient(Stability *self, HdfFile file, HdfFile shape);

#endif
