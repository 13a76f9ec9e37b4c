/* A tube along a smooth path, with a radius along it: the envelope of the balls whose centres c(u)
   and radii r(u) are cubic splines through given points. The rod is inside (a duct, a vessel, a
   borehole), whose ends are open, or outside of it, whose ends are round. All in the laboratory's
   frame. */
#ifndef TENDRIL_TUBE_H
#define TENDRIL_TUBE_H

#include "world/surfaces.h"

typedef struct _Tube *Tube;

PetscErrorCode TubeCreate(const char *what, PetscInt n, const PetscReal ball[][4], PetscBool inside,
                          PetscReal radius, Tube *tube);
PetscErrorCode TubeDestroy(Tube *tube);
PetscBool TubeAt(Tube tube, const PetscReal x[3], PetscReal within, SurfacePoint *point);
PetscBool TubeHolds(Tube tube, const PetscReal x[3], PetscReal radius);
Block TubeBox(Tube tube);
PetscReal TubeSmallest(Tube tube);
PetscReal TubeCore(Tube tube);

#endif
