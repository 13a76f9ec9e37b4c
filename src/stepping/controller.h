/* The control of the formula's steps: their size and order, what is rejected, what is a jump or
   crosses a mode that grows. */
#ifndef TENDRIL_CONTROLLER_H
#define TENDRIL_CONTROLLER_H

#include "stepping/formula.h"

typedef struct {
  PetscInt order;       /* k, of the present step */
  PetscInt taken_order; /* of the step taken last */
  PetscInt most;        /* highest order allowed */
  PetscInt since;       /* steps since the order changed */
  PetscInt jumps;       /* steps that were jumps, so far */
  PetscReal scale;      /* of time, that short steps are part of; 0: the run's end */
  PetscBool resolves; /* every motion has a velocity: only what is crossed in the layer is a jump */
  PetscReal layer;    /* a step this short is accepted whatever its error */
  PetscReal again;    /* a first step that snaps is tried again in this size; 0: as others */
  PetscReal own;      /* the time that what is followed takes itself, if it is less than scale */
  PetscBool unheld;   /* nothing holds a part of it, in which any motion takes no time */
  Vec held;           /* tolerances of what something holds back, if that is not all; borrowed */
  PetscBool free;     /* nothing at all holds the rest; else but in a step as short as again */
  PetscBool placed;   /* the latest try was right in that, and wrong */
  PetscBool snaps;    /* it has no solution, or an error that does not fall though all is held */
  PetscReal rejected; /* error of the try before, if one of this step was rejected at a third of
                         the size or more */
  PetscReal late;     /* what the time has passed by that has no room in it beside what it is */
  PetscBool fixed;    /* -ts_adapt_type none: steps as told, order as high as the history allows */
  PetscBool jumped;   /* the present step was accepted as a jump */
  PetscBool plain_next;             /* nothing is factored in the next step */
  PetscObjectState tolerance_state; /* of the tolerances that were looked at */
  PetscBool minute;                 /* one of them is */
  Vec work;
  VBDFGuess guess;
  void *guess_ctx;
  VBDFOtherWay other_way;
  VBDFCheck check;
  VBDFCross cross;
  VBDFMeasure measure;
  VBDFNextEnd next_end;
  VBDFKinks kinks;
  PetscBool kinked; /* the present step begins at a kink of what drives the rod */
} Controller;

PetscErrorCode ControllerStep(TS ts, Controller *controller, Formula *formula);

#endif
