/* How a clamp turns about its axis over time, from a table: its rate, or its angle. Between the
   rows these follow monotone cubic curves. A rate stays what it is before the first row and behind
   the last; by an angle the clamp rests there. */
#ifndef TENDRIL_CLAMP_PATH_H
#define TENDRIL_CLAMP_PATH_H

#include "base/options.h"

typedef struct _ClampPath *ClampPath;

PetscErrorCode ClampPathRead(const char *option, const char *file, ClampPath *path);
PetscErrorCode ClampPathDestroy(ClampPath *path);
PetscReal ClampPathAngle(ClampPath path, PetscReal t);
PetscReal ClampPathRate(ClampPath path, PetscReal t);
PetscReal ClampPathFastest(ClampPath path);
PetscBool ClampPathJerks(ClampPath path, PetscReal t0, PetscReal t1);

#endif
