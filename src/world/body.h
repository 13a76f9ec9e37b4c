/* A body given by its signed distance on an even grid, a spline of third degree between the values:
   smooth twice over, so that no facet of what it was made from is felt. All in the laboratory's
   frame. */
#ifndef TENDRIL_BODY_H
#define TENDRIL_BODY_H

#include "world/surfaces.h"

typedef struct _Body *Body;

PetscErrorCode BodyRead(const char *what, const char *file, PetscBool inside, PetscReal radius,
                        Body *body);
PetscErrorCode BodyDestroy(Body *body);
PetscBool BodyAt(Body body, const PetscReal x[3], PetscReal within, SurfacePoint *point);
Block BodyBox(Body body);
PetscReal BodySmallest(Body body);
PetscReal BodyCore(Body body);

#endif
