/* -task critical: when the straight rod, or a bent one, stops being stable. */
#ifndef TENDRIL_CRITICAL_H
#define TENDRIL_CRITICAL_H

#include "tasks/member.h"

/* The first time at which a mode of the rod stops decaying. */
typedef struct {
  PetscReal t, length;
  PetscReal error;     /* bound on both */
  PetscReal frequency; /* per unit of t; 0: the mode buckles, else it flutters */
  PetscBool space;     /* the rod is in space: the mode has x3 and its angle, too */
  StraightWay way;     /* the deflection that it is one of */
  PetscInt ways;       /* of which there are so many to look at */
  PetscBool bent;      /* the rod is no straight one: it was followed */
  PetscReal sideways;  /* ... and of its mode this part is out of its plane */
  PetscReal twisting;  /* M; 0: the rod is not twisted */
  PetscBool follows;   /* the other of two ways turns unstable, too */
  PetscReal other[2];  /* t and length then */
  PetscInt bends;      /* of tables, in time; 0: none are in the scene */
  PetscInt looks;      /* so often it was looked at, with these */
  PetscReal widest;    /* ... and at most so far apart */
  PetscInt n;          /* its shape at n labels, largest |y| = 1; theta = dy/dp */
  PetscReal *s, *y, *theta;
  PetscReal *y3, *theta3; /* across in x3; NULL in the plane */
} Critical;

enum { CRITICAL_VALUES = 4 };
extern const char *const critical_name[CRITICAL_VALUES], *const critical_units[CRITICAL_VALUES],
                                                             *const critical_text[CRITICAL_VALUES];

PetscErrorCode CriticalFind(Scene scene, PetscBool quiet, Critical *critical);
PetscErrorCode CriticalPrintLaboratory(MPI_Comm comm, const Critical *critical);
const char *CriticalLooks(const Critical *critical, char text[], size_t size);
PetscErrorCode CriticalDestroy(Critical *critical);
PetscErrorCode CriticalRun(Scene scene, const char *output);
PetscErrorCode CriticalMember(Scene scene, const char *output, Member *member);

#endif
