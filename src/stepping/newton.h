/* Newton's method in each time step: its linear solver and its test of convergence. */
#ifndef TENDRIL_NEWTON_H
#define TENDRIL_NEWTON_H

#include "rod/rod.h"
#include <petscts.h>

typedef struct {
  TS ts; /* borrowed */
  Rod rod;
  Elimination elimination; /* instead of a matrix; NULL: none */
  Elimination counter;     /* beside a matrix, to count modes that grow; NULL: none */
  PetscBool plane;         /* only modes within the plane of x1 and x2 are to count */
  Mat J;
  PetscBool fresh;                /* the next Jacobian is the first of its solve */
  PetscReal factor_rate[MIRRORS]; /* what a field has in U_t beside shift U (vbdf.h), for each
                                     mirror in which it changes sign */
  RodState latest;     /* t, U and U_t of the latest residual: of the accepted state, once a step is
                          taken */
  RodState linearised; /* of the latest Jacobian; U NULL: there was none */
  PetscReal tolerance; /* of the update, relative to each field's size */
  PetscReal given;     /* likewise, before it is eased: what sticks is held to that */
  PetscReal update;    /* the latest iteration's largest */
  PetscReal residual[GROUPS]; /* the latest, of each group of fields */
  PetscReal guess;            /* the largest residual of the guess */
  PetscReal halved;           /* the largest residual when it last had halved */
  PetscInt stalled;           /* how many iterations ago that was */
  PetscInt diverges;          /* for how many it has been far above that of the guess */
  PetscInt holds;             /* how often sticking points were held again */
  PetscInt waits;             /* how many iterations forces have been waited for */
} Newton;

PetscErrorCode NewtonSetUp(TS ts, Rod rod, Newton *newton);
void NewtonFollow(Newton *newton, PetscReal rtol);
PetscErrorCode NewtonSetMatrix(TS ts, Newton *newton);
PetscErrorCode NewtonDetermines(Newton *newton, Vec U, PetscReal rate, PetscBool *determined);
PetscErrorCode NewtonTakesFullSteps(const Newton *newton, PetscBool *full);
PetscErrorCode NewtonCuts(const Newton *newton, PetscBool cuts);
PetscErrorCode NewtonEliminate(Newton *newton, Elimination elimination);
PetscErrorCode NewtonCounts(Newton *newton, PetscBool *can);
PetscErrorCode NewtonIndex(const Newton *newton, PetscInt k, PetscInt *index, PetscBool *known);
PetscErrorCode NewtonOutOfPlane(Newton *newton, PetscReal rate, PetscInt *modes);
PetscErrorCode NewtonDestroy(Newton *newton);

#endif
