/* Block elimination along a line of nodes of thirteen unknowns, on one rank (halves.h): seven
   equations of a cell are rows of the node behind it and six of the node before it. */
#ifndef TENDRIL_WIDE_H
#define TENDRIL_WIDE_H

#include <petscsys.h>
#include <petscblaslapack.h>

enum { WIDE_TOP = 7, WIDE_OWN = 6, WIDE_FIELDS = WIDE_TOP + WIDE_OWN };

/* What the index takes to know of a node. The last six of its unknowns are a moment and a force:
   how the first seven move along each of them; half the moment, a vector of the laboratory; and how
   much of that is about the rod itself. */
typedef struct {
  PetscReal way[WIDE_OWN][WIDE_TOP], moment[3], twist;
} WideArms;

typedef struct _WideLine *WideLine;

PetscErrorCode WideCreate(PetscInt nodes, WideLine *line);
PetscErrorCode WideDestroy(WideLine *line);
void WideBegin(WideLine line);
void WideSpring(WideLine line, const PetscReal gives[WIDE_TOP][WIDE_OWN]);
void WideKeep(WideLine line);
void WideArm(WideLine line, const WideArms *arms);
void WideBlocks(WideLine line, PetscReal (**a)[WIDE_FIELDS], PetscReal (**b)[WIDE_FIELDS]);
void WideCell(WideLine line);
PetscInt WideParts(WideLine line, PetscReal parts[]);
void WideTake(WideLine line, const PetscReal parts[], PetscInt reals);
void WideEnd(WideLine line, const PetscReal own[WIDE_OWN][WIDE_FIELDS]);
PetscBool WideRegular(WideLine line);
void WidePlane(WideLine line, PetscBool plane);
PetscInt WideIndex(WideLine line);
void WideSolve(WideLine line, const PetscReal (*b)[WIDE_FIELDS], PetscReal (*x)[WIDE_FIELDS]);

#endif
