/* Gaussian elimination along a line of nodes of six unknowns, on any number of ranks, in one pass:
   each cell between two nodes is eliminated as soon as its equations are known, and only the
   factors are kept. No matrix is assembled. */
#ifndef TENDRIL_ELIMINATION_H
#define TENDRIL_ELIMINATION_H

#include <petscpc.h>

enum { LINE_FIELDS = 6, LINE_HALF = 3 };

typedef struct _Elimination *Elimination;

PetscErrorCode EliminationCreate(MPI_Comm comm, PetscInt nodes, Elimination *self);
PetscErrorCode EliminationDestroy(Elimination *self);
void EliminationBegin(Elimination self);
void EliminationCell(Elimination self, const PetscReal a[LINE_FIELDS][LINE_FIELDS],
                     const PetscReal b[LINE_FIELDS][LINE_FIELDS]);
void EliminationTip(Elimination self, const PetscReal tip[LINE_HALF][LINE_FIELDS]);
PetscErrorCode EliminationEnd(Elimination self);
PetscErrorCode EliminationSetType(PC pc, Elimination self);

#endif
