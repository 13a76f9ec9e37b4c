/* A model whose rod touches itself, or of several rods: what rod/strands.h finds goes into its
   equations and into their derivatives. Every rank knows the whole rod and finds the same. */
#ifndef TENDRIL_STRAND_ROWS_H
#define TENDRIL_STRAND_ROWS_H

#include "rod/rod.h"
#include "rod/strands.h"

typedef struct _StrandRows *StrandRows;

/* Of the cell behind an owned node, in the equations of the model: the weights of its ends and its
   middle times its length, bow times that, stretch and tangent at the middle; and in space, how p'
   there changes with m, and the equations of what its material learns there. */
typedef struct StrandCell_ {
  PetscReal end_weight, mid_weight, bow, g, q[3], p_m[4][3], learned_m[TROPISM_BENDS][3];
} StrandCell;

PetscErrorCode StrandRowsCreate(Rod rod, Strands strands, StrandRows *rows);
PetscErrorCode StrandRowsDestroy(StrandRows *rows);
PetscErrorCode StrandRowsLoad(Rod rod, StrandRows self, const RodState *at,
                              const PetscReal (**force)[3], const PetscReal (**couple)[3]);
StrandCell *StrandRowsCell(Rod rod, StrandRows self, PetscInt i);
PetscErrorCode StrandRowsPattern(Rod rod, StrandRows self, PetscBool fresh, Mat J);
PetscErrorCode StrandRowsJacobian(Rod rod, StrandRows self, const RodState *at, Mat J);
PetscErrorCode StrandRowsHold(StrandRows self, PetscReal seen, PetscReal *creep);
PetscInt StrandRowsMemory(StrandRows self);
PetscReal *StrandRowsRemembered(StrandRows self, PetscInt i, PetscInt k);
PetscErrorCode StrandRowsRecalled(Rod rod, StrandRows self);

#endif
