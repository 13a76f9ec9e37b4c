/* The control of the formula's steps: their size and order, what is rejected, what is a jump or
   crosses a mode that grows, and snaps that are followed. */
#ifndef TENDRIL_CONTROLLER_H
#define TENDRIL_CONTROLLER_H

#include "stepping/formula.h"

typedef struct {
  PetscInt order;       /* k, of the present step */
  PetscInt taken_order; /* of the step taken last */
  PetscInt most;        /* highest order allowed */
  PetscInt since;       /* steps since the order changed */
  PetscInt jumps;       /* steps that were jumps, so far */
  PetscInt blind;       /* ... which no snap was followed through */
  PetscReal scale;      /* of time, that short steps are part of; 0: the run's end */
  PetscBool resolves; /* every motion has a velocity: only what is crossed in the layer is a jump */
  PetscReal layer;    /* a step this short is accepted whatever its error */
  PetscReal rejected; /* error of the try before, if one of this step was rejected at a third of
                         the size or more */
  PetscReal usual;    /* the longest of the latest steps, slowly forgotten */
  PetscBool fixed;    /* -ts_adapt_type none: steps as told, order as high as the history allows */
  PetscBool jumped;   /* the present step was accepted as a jump */
  PetscBool tried, snapped; /* to follow a snap in the present step; it begins behind one */
  PetscInt failures;        /* tries of the present step that had no solution, or crossed a mode */
  PetscBool look;           /* its error is to be seen, if there is a point before */
  PetscInt before;          /* points there were before it was tried from the last one alone */
  PetscBool plain_next;     /* nothing is factored in the next step */
  PetscObjectState tolerance_state; /* of the tolerances that were looked at */
  PetscBool minute;                 /* one of them is */
  Vec work;
  VBDFGuess guess;
  void *guess_ctx;
  VBDFSnap snap;
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
