/* The natural curvature k0 of the rod: what it is bent to where nothing bends it. Real tubes have
   one, and it lasts, unlike the initial shape. */
#ifndef TENDRIL_CURVATURE_H
#define TENDRIL_CURVATURE_H

#include "scene/growth.h"

typedef struct {
  PetscBool any;                   /* not 0 everywhere */
  PetscReal constant;              /* the part of -rod_curvature */
  PetscInt n;                      /* knots of the other part (file or random); 0: none */
  PetscReal *at, *k, *k2;          /* their places, curvatures and second derivatives */
  PetscReal *even, *angle, *slope; /* int_0^s g k0 ds at t = 0 and its slope, at even labels */
} Curvature;

extern const OptionGroup curvature_options;

PetscErrorCode CurvatureSetFromOptions(Curvature *curvature, Growth growth, PetscReal end_time);
PetscErrorCode CurvatureAngle(const Curvature *curvature, Growth growth, PetscReal s,
                              PetscReal *theta, PetscReal *theta_s);
PetscErrorCode CurvatureDestroy(Curvature *curvature);
PetscErrorCode CurvatureValue(const Curvature *curvature, Growth growth, PetscReal s, PetscReal t,
                              PetscReal *k, PetscReal *k_t);

#endif
