/* The result file of several rods: their series and shapes packed, rod behind rod.

     /rods/name, first, count [r]   rod k has the nodes first[k] ... first[k] + count[k] - 1
     /rods/series/NAME [steps][r]   as /series/NAME of a single rod's file
     /rods/of/NAME                   attributes, and walls, as a single rod's file has them
     /rods/text                     the rods' own options, a section each
     /series/NAME [steps]           of all: sums, or the largest
     /shapes/...                    as of a single rod, all nodes
     /joints/name, on, end, node [j]; force, moment [k][j][3]: where rods hold each other
     /pairs/first [k+1]             shape k has the places first[k] ... first[k+1] - 1, where rods
                                    touch: rods [c,2], s [c,2], force [c,3], gap [c] */
#ifndef TENDRIL_SEVERAL_H
#define TENDRIL_SEVERAL_H

#include "record/output.h"
#include "system/joints.h"
#include "system/rods.h"

typedef struct {
  char path[PETSC_MAX_PATH_LEN]; /* empty: nothing is stored */
  Rods rods;
  Joints joints;
  PetscInt n;
  Output *each;                                    /* [n], kept in memory */
  PetscErrorCode (*keep)(void *ctx, HdfFile file); /* what the run needs to go on from here */
  void *ctx;
  PetscBool touch;       /* rods may, */
  PetscInt places, room; /* and where they do, in all shapes, */
  StrandPlace *place;
  PetscInt shapes, *until; /* of each shape up to here */
  PetscLogDouble stored_at, cost;
  PetscBool there, broken;
} Several;

PetscErrorCode SeveralTouch(Several *self, PetscInt n, const StrandPlace place[]);
PetscErrorCode SeveralBegin(Several *self);
PetscBool SeveralDue(const Several *self);
PetscErrorCode SeveralStore(Several *self, PetscReal t, PetscBool finished);
PetscErrorCode SeveralSave(Several *self, const char *path, PetscReal t, PetscBool finished);
void SeveralDropShape(Several *self);
PetscBool SeveralHas(const Several *self, PetscInt observed);
PetscReal SeveralSum(const Several *self, PetscInt observed, const PetscReal of_each[]);
PetscErrorCode SeveralTake(Several *self, const char *from, PetscReal t, PetscReal interval);
PetscErrorCode SeveralLabels(const char *from, PetscInt k, Scene scene);
PetscErrorCode SeveralEnd(Several *self);

#endif
