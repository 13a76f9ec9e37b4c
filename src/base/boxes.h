/* A binary tree of bounding boxes over the segments of a polygon, in the plane or in space: finds
   pairs of segments that are near each other without looking at all pairs. */
#ifndef TENDRIL_BOXES_H
#define TENDRIL_BOXES_H

#include "base/blocks.h"

typedef struct _Boxes *Boxes;

/* Told of segments first .. last - 1 of each of two boxes, from low to high in x1, x2 and x3 or an
   angle: may they be left out? */
typedef PetscBool (*BoxesSkip)(const Block *a, PetscInt first_a, PetscInt last_a, const Block *b,
                               PetscInt first_b, PetscInt last_b, void *ctx);
/* Told of two segments i < j. */
typedef void (*BoxesMeet)(PetscInt i, PetscInt j, void *ctx);

PetscErrorCode BoxesCreate(PetscInt segments, PetscInt stride, const PetscReal *x,
                           const PetscReal *angle, Boxes *boxes);
PetscErrorCode BoxesCreate3(PetscInt segments, PetscInt stride, const PetscReal *x, Boxes *boxes);
PetscErrorCode BoxesDestroy(Boxes *boxes);
void BoxesPairs(Boxes boxes, PetscReal reach, BoxesSkip skip, BoxesMeet meet, void *ctx);

#endif
