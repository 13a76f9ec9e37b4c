/* What the files of the estimate share: its errors and the coarse rod that they are stepped on. */
#ifndef TENDRIL_ESTIMATING_H
#define TENDRIL_ESTIMATING_H

#include "base/elimination.h"
#include "rod/ask.h"
#include "rod/coarse.h"
#include "rod/learned.h"
#include "rod/rules.h"
#include "stepping/estimate.h"
#include "stepping/rules.h"

/* What is gathered of the coarse nodes, node after node: the state, its rate, the defect of the
   cell behind; of the fields that have rates, which come first, local errors since the errors were
   stepped last, and those before the latest step if that is looked at by itself. */
typedef struct {
  PetscReal *u, *rate, *defect, *local, *skipped;
} Gathered;

struct _Estimate {
  Leg *leg;
  Estimate whole; /* of one rod of several that hold each other: that of all, of which this one has
                     its part; NULL: none */
  Estimate *part; /* of all: of each, by the rods of its leg; NULL: of one rod */
  const RodModel *model;
  PetscInt fields, followed, mirrors; /* of a node; those that have rates, first, or all that may;
                                         of those across */
  PetscInt left;                      /* equations of a cell that are rows of the node behind it */
  PetscBool touches;                  /* the rod does, or did */
  PetscInt stride, nodes;             /* of the coarse mesh */
  PetscInt since;                     /* steps */
  PetscInt rejected, watch;           /* tries, so far; steps to be looked at one by one */
  PetscReal before, size[MIRRORS];    /* when e was stepped last, and |x2|, |x3| then */
  PetscReal time, latest[MIRRORS];    /* of the latest step, and the largest x2, x3 at it */
  PetscInt until;                     /* times until the defect is measured again */
  PetscReal measured[MIRRORS];        /* the largest x2, x3 when it was */
  Gathered own, all;                  /* of this rank's nodes, 0 elsewhere; all on rank 0 */
  PetscReal (*defect)[MAX_FIELDS];
  PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN]; /* beyond what is early */
  PetscReal start[ESTIMATE_PARTS][ESTIMATE_SEEN]; /* before, for a run that ends there */
  PetscReal began[ESTIMATE_SEEN];                 /* when there was nothing of it, at last */
  PetscReal now[ESTIMATE_PARTS][ESTIMATE_SEEN];   /* of the state when e was stepped last */
  PetscReal gives;                                /* EstimateGives() */
  PetscReal rigid[RIGID_VALUES]; /* what k dU/dk makes of its tip and energy, of itself */
  /* rank 0: the coarse rod; NULL else */
  Rod rod;
  Elimination elimination; /* NULL: far parts of the rod touch, and it is a matrix */
  Mat J;
  KSP ksp;
  Vec U, rate, nudged, F, G;
  PetscReal *e[ESTIMATE_PARTS], *rhs, *b;
  PetscReal *begun[ESTIMATE_PARTS], *once[ESTIMATE_PARTS]; /* before a step, behind it as a whole */
};

PetscInt EstimateFineNode(const Estimate estimate, PetscInt k);
void EstimateAgree(const Estimate from, Estimate to);
PetscErrorCode EstimateRefine(Estimate estimate, PetscInt stride);
PetscErrorCode EstimateLookAtLayer(Estimate estimate, PetscReal t);
PetscErrorCode EstimateSee(const Estimate estimate, PetscReal t, const PetscReal *e,
                           PetscReal seen[ESTIMATE_SEEN], PetscReal change[RIGID_VALUES]);
PetscErrorCode EstimateCount(Estimate estimate, PetscReal t, int part);

#endif
