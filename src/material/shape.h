/* The initial shape of the rod, by its tangent angle. */
#ifndef TENDRIL_SHAPE_H
#define TENDRIL_SHAPE_H

#include "base/options.h"

typedef enum { SHAPE_STRAIGHT, SHAPE_SAG, SHAPE_MODE, SHAPE_RANDOM, SHAPE_FILE } ShapeType;

typedef struct {
  ShapeType type;
  PetscReal amplitude; /* eps, largest initial angle against the clamp */
  PetscBool hinged;    /* its beginning is in a hinge */
  PetscInt seed;
  PetscInt n;                    /* knots of a tabulated shape (random, file, mode) */
  PetscReal *s, *theta, *theta2; /* its knots, angles and their second derivatives */
  PetscReal turn;                /* by which the shape is turned about the clamp's axis, in space */
  PetscBool space;               /* it is given by strains, not by an angle */
  PetscReal *u[3], *u2[3];       /* those, per length, and second derivatives; NULL: 0 */
} Shape;

extern const OptionGroup shape_options;

PetscErrorCode ShapeSetFromOptions(Shape *shape);
PetscErrorCode ShapeSetTable(Shape *shape, PetscInt n, const PetscReal s[],
                             const PetscReal theta[]);
PetscErrorCode ShapeDestroy(Shape *shape);
void ShapeAngle(const Shape *shape, PetscReal s, PetscReal *theta, PetscReal *theta_s);
void ShapeStrains(const Shape *shape, PetscReal s, PetscReal g, PetscReal u[3]);
PetscReal ShapeMeanBend(const Shape *shape, PetscReal length);

#endif
