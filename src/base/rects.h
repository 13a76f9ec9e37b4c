/* A binary tree over rectangles that stand still: finds those near a place without looking at all
   of them. */
#ifndef TENDRIL_RECTS_H
#define TENDRIL_RECTS_H

#include <petscsys.h>

typedef struct {
  PetscReal low[2], high[2];
} Rect;

typedef struct _Rects *Rects;

/* Told of a rectangle that is within reach; returns how far the search is to reach from now on. */
typedef PetscReal (*RectsMeet)(PetscInt item, PetscReal reach, void *ctx);

PetscErrorCode RectsCreate(PetscInt n, const Rect rect[], Rects *rects);
PetscErrorCode RectsDestroy(Rects *rects);
void RectsNear(Rects rects, const Rect *place, PetscReal reach, RectsMeet meet, void *ctx);

/* A rectangle that holds nothing yet. */
static inline Rect RectEmpty(void) {
  const PetscReal far = PETSC_MAX_REAL;
  return (Rect){{far, far}, {-far, -far}};
}

/* Makes it hold a point, too. */
static inline void RectHold(Rect *rect, const PetscReal x[2]) {
  for (int d = 0; d < 2; d++) {
    rect->low[d] = PetscMin(rect->low[d], x[d]);
    rect->high[d] = PetscMax(rect->high[d], x[d]);
  }
}

#endif
