/* A path over time on which the tip is held: its place and its frame, from a table. Between the
   rows they follow monotone cubic curves, before the first and behind the last they rest. */
#ifndef TENDRIL_PATH_H
#define TENDRIL_PATH_H

#include "base/bends.h"
#include "base/options.h"

typedef struct _Path *Path;

/* What a path may say of the tip: its coordinates in the laboratory, the angle of its tangent in
   the plane, the quaternion of its frame, and a turn about its tangent beside these. */
enum {
  PATH_X1,
  PATH_X2,
  PATH_X3,
  PATH_ANGLE,
  PATH_FRAME,
  PATH_TURN = PATH_FRAME + 4,
  PATH_COLUMNS
};

/* Where the tip is, in the frame of the clamp; angle is that of its tangent in the plane. */
typedef struct {
  PetscReal x[3], p[4], angle;
} PathPlace;

PetscErrorCode PathRead(const char *option, const char *file, Path *path);
PetscErrorCode PathDestroy(Path *path);
PetscBool PathSays(Path path, int column);
PetscBool PathInSpace(Path path);
PetscReal PathRange(Path path, int column);
void PathBegin(Path path, const PetscReal lab[3][3], const PathPlace *start, PetscReal apart[3]);
void PathAt(Path path, PetscReal t, PathPlace *place);
PetscBool PathTurnsCorner(Path path, PetscReal t0, PetscReal t1);
PetscReal PathNextTurn(Path path, PetscReal t);
PetscErrorCode PathBends(Path path, PetscReal tolerance, Bends *bends);
PetscBool PathLeads(Path path, PetscReal t, int axis);
PetscInt PathRows(Path path);
PetscReal PathTime(Path path, PetscInt row);

#endif
