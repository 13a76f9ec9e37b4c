/* The natural curvature k0 of the rod: what it is bent to where nothing bends it. Real tubes have
   one, and it lasts, unlike the initial shape. In space there are two bends, about d3 (that of the
   plane) and d2, and a twist. */
#ifndef TENDRIL_CURVATURE_H
#define TENDRIL_CURVATURE_H

#include "material/actuation.h"
#include "material/growth.h"
#include "base/lead.h"

enum { BEND_3, BEND_2, TURN_1, STRAINS };

/* One of the three. */
typedef struct {
  PetscReal constant;     /* the part of -rod_curvature, -rod_curvature_2, -rod_twist */
  Lead lead;              /* in the place of that, as a run has changed it; not on: it has not */
  PetscInt n;             /* knots of the other part (file or random); 0: none */
  PetscReal *at, *k, *k2; /* their places, curvatures and second derivatives */
  Actuation steered;      /* the other part over time, in place of k and k2; NULL: it stays */
} Strain;

typedef struct {
  PetscBool any;     /* not 0 everywhere */
  PetscBool space;   /* one of those that there are in space only is not 0 */
  PetscBool steered; /* one changes over time */
  Strain strain[STRAINS];
  OwnLaw *own;                     /* of one's own, in their place; NULL: none */
  PetscReal most[STRAINS];         /* of that, as far as it was looked at */
  PetscReal *even, *angle, *slope; /* int_0^s g k0 ds at t = 0 and its slope, at even labels */
} Curvature;

extern const OptionGroup curvature_options;

PetscErrorCode CurvatureSetFromOptions(Curvature *curvature, Growth growth, PetscReal end_time);
PetscErrorCode CurvatureAngle(const Curvature *curvature, Growth growth, PetscReal s,
                              PetscReal *theta, PetscReal *theta_s);
void CurvatureLeadTo(Curvature *curvature, int strain, PetscReal t, PetscReal by, PetscReal k);
PetscErrorCode CurvatureDestroy(Curvature *curvature);
PetscErrorCode CurvatureValue(const Curvature *curvature, Growth growth, PetscReal s, PetscReal t,
                              PetscReal *k, PetscReal *k_t);
PetscReal CurvatureNextTurn(const Curvature *curvature, PetscReal t);
PetscBool CurvatureJerks(const Curvature *curvature, PetscReal t0, PetscReal t1);
PetscErrorCode CurvatureBendsInTime(const Curvature *curvature, PetscReal tolerance, Bends *bends);
PetscReal CurvatureLargest(const Curvature *curvature, int strain);
PetscReal CurvatureSteered(const Curvature *curvature, int strain);
PetscReal CurvatureFinest(const Curvature *curvature);
PetscBool CurvatureBends(const Curvature *curvature);
PetscBool CurvatureIsTable(const Curvature *curvature);
PetscReal CurvatureRounding(const Curvature *curvature, PetscReal length);
PetscErrorCode CurvatureStrains(const Curvature *curvature, Growth growth, PetscReal s, PetscReal t,
                                PetscReal u[3], PetscReal u_t[3]);

#endif
