/* What the files of the frame model share. */
#ifndef TENDRIL_FRAME_H
#define TENDRIL_FRAME_H

#include "rod/feet.h"
#include "rod/rod.h"
#include "rod/strands.h"

enum { X1, X2, TH, M, N1, N2, FIELDS };

/* What the laws give at a point; flex = 1/B. */
typedef struct {
  PetscReal s, g, g_t, c, k0, flex;
} Law;

/* Tells one state of the unknowns and their rates from another. */
typedef struct {
  PetscReal t;
  PetscObjectId id[2];
  PetscObjectState state[2];
} FrameState;

typedef struct {
  PetscReal end_weight, mid_weight, bow; /* times h: 1/6, 4/6, 1/8 (order 4); 0, 1, 0 (order 2) */
  PetscReal time;                        /* of the laws below */
  Law *law;                              /* nodes and mids from node first - 1 on, alternating */
  struct _Point *point;                  /* likewise, in the state seen */
  FrameState seen;
  LoadDual *dual; /* likewise, duals of them at each */
  PetscInt duals;
  FootLoad *feet;               /* of each cell, from that before node first on; NULL: no posts */
  struct FrameStrands *strands; /* NULL: the rod does not touch itself */
} Frame;

/* frame_strands.c */
PetscErrorCode FrameStrandsCreate(Rod rod, struct FrameStrands **strands);
PetscErrorCode FrameStrandsDestroy(struct FrameStrands **strands);
PetscErrorCode FrameStrandsLoad(Rod rod, PetscReal t, Vec U, Vec U_t, const PetscReal (**force)[2]);
PetscErrorCode FrameStrandsPattern(Rod rod, Mat J);
PetscErrorCode FrameStrandsJacobian(Rod rod, PetscReal t, Vec U, Vec U_t, const PetscReal shift[],
                                    Mat J);
PetscErrorCode FrameStrandsHold(Rod rod, PetscReal seen, PetscReal *creep);
PetscReal *FrameStrandsRemembered(Rod rod, PetscInt i, PetscInt k);
PetscInt FrameStrandsMemory(Rod rod);
PetscErrorCode FrameStrandsRecalled(Rod rod);

#endif
