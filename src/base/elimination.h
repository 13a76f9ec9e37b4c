/* Gaussian elimination along a line of nodes of six unknowns, on any number of ranks, or of
   thirteen, on one (wide.h; several count), or of other sizes, on one (halves.h), in one pass: each
   cell between two nodes is eliminated as soon as its equations are known, and only the factors are
   kept. No matrix is assembled. */
#ifndef TENDRIL_ELIMINATION_H
#define TENDRIL_ELIMINATION_H

#include "base/halves.h"
#include "base/line.h"
#include "base/wide.h"
#include <petscpc.h>

typedef struct _Elimination *Elimination;

PetscBool EliminationCan(const PetscInt halves[2], PetscInt ranks);
PetscBool EliminationCounts(const PetscInt halves[2], PetscInt ranks);
PetscErrorCode EliminationCreate(MPI_Comm comm, PetscInt nodes, const PetscInt halves[2],
                                 Elimination *self);
PetscErrorCode EliminationCreateSeveral(PetscInt lines, const PetscInt nodes[],
                                        const PetscInt halves[2], Elimination *self);
Elimination EliminationPart(Elimination self, PetscInt k);
PetscErrorCode EliminationDestroy(Elimination *self);
PetscBool EliminationFromTip(Elimination self);
WideLine EliminationWide(Elimination self);
Halves EliminationHalves(Elimination self);
void EliminationBegin(Elimination self, const LineRows tip);
void EliminationSpring(Elimination self, PetscReal turn, PetscReal place);
void EliminationCell(Elimination self, LineBlock a, LineBlock b);
PetscBool EliminationKeeps(Elimination self);
PetscErrorCode EliminationGather(Elimination self, const PetscReal gives[WIDE_TOP][WIDE_OWN],
                                 const WideArms *tip, const PetscReal own[WIDE_OWN][WIDE_FIELDS]);
void EliminationPlane(Elimination self, PetscBool plane);
PetscErrorCode EliminationEnd(Elimination self, const LineRows tip);
PetscErrorCode EliminationIndex(Elimination self, PetscInt *index);
PetscErrorCode EliminationSolve(Elimination self, const PetscReal (*b)[LINE_FIELDS],
                                PetscReal (*x)[LINE_FIELDS]);
PetscBool EliminationRegular(Elimination self);
PetscErrorCode EliminationSetType(PC pc, Elimination self);

#endif
