/* The true transient: how much any small deflection of the straight rod can grow from t1 to t2. */
#ifndef TENDRIL_TRANSIENT_H
#define TENDRIL_TRANSIENT_H

#include "base/band.h"
#include "straight/pencil.h"

typedef enum { TRANSIENT_L2, TRANSIENT_FRICTION } TransientNorm;

/* The linear propagator Phi(t2, t1): Radau IIA steps, kept so that its transpose is exact. */
typedef struct {
  Pencil pencil;
  PetscReal t1, t2;
  PetscInt n, steps, room;
  Band *factor;    /* of each step */
  PetscReal *drag; /* [steps][3][n][WIDTH], D at the stages */
  PetscReal *work; /* 3 n values */
  Bends bends;     /* of the scene's tables: steps end there */
} Propagator;

/* The deflection that grows most, and what becomes of it. */
typedef struct {
  PetscReal amplification;
  PetscInt n;
  PetscReal *s, *y1, *theta1, *y2, *theta2; /* norm 1 at t1; n labels */
} Optimal;

PetscErrorCode PropagatorCreate(Scene scene, const Mesh *mesh, StraightWay way, PetscReal t1,
                                PetscReal t2, PetscReal tolerance, Propagator *propagator);
PetscErrorCode PropagatorDestroy(Propagator *propagator);
PetscErrorCode PropagatorApply(Propagator *propagator, PetscBool transpose, PetscReal c[]);
PetscErrorCode TransientOptimal(Propagator *propagator, TransientNorm norm, Optimal *optimal);
PetscErrorCode OptimalDestroy(Optimal *optimal);

#endif
