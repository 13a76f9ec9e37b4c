/* The initial shape of the rod, by its tangent angle. */
#ifndef TENDRIL_SHAPE_H
#define TENDRIL_SHAPE_H

#include "base/options.h"

typedef enum { SHAPE_STRAIGHT, SHAPE_SAG, SHAPE_MODE, SHAPE_RANDOM, SHAPE_FILE } ShapeType;

typedef struct {
  ShapeType type;
  PetscReal amplitude; /* eps, largest initial angle against the clamp */
  PetscInt seed;
  PetscInt n;                    /* knots of a tabulated shape (random, file, mode) */
  PetscReal *s, *theta, *theta2; /* its knots, angles and their second derivatives */
} Shape;

extern const OptionGroup shape_options;

PetscErrorCode ShapeSetFromOptions(Shape *shape);
PetscErrorCode ShapeSetTable(Shape *shape, PetscInt n, const PetscReal s[],
                             const PetscReal theta[]);
PetscErrorCode ShapeDestroy(Shape *shape);
void ShapeAngle(const Shape *shape, PetscReal s, PetscReal *theta, PetscReal *theta_s);

#endif
