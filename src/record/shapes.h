/* The fields of the labels that results have, and a node as they tell it: in the laboratory. */
#ifndef TENDRIL_SHAPES_H
#define TENDRIL_SHAPES_H

#include "rod/rod.h"

/* A node in the laboratory. In the plane vectors have no third component, but for strains and
   moment, which have that alone. */
typedef struct {
  PetscReal x[3], theta, d[3][3];  /* place; angle of the tangent; directors */
  PetscReal v[3];                  /* of the material there */
  PetscReal strain[3], natural[3]; /* twist and bends about the directors; by nature */
  PetscReal bend;                  /* of the centre line in space */
  PetscReal force[3], moment[3], stretch;
  PetscReal contact[3]; /* force of contact per length, if there is any: the caller's */
} LabNode;

/* A field of the labels, or, of no components, a number of each shape: its time. */
typedef struct {
  const char *name, *units, *text;
  PetscInt components; /* per node */
  size_t at;           /* in a LabNode */
} ShapeSet;

/* Of a rod in the plane. Contact is the last of each: only if the scene has any. */
enum { SHAPE_SETS = 8, CONTACT_SET = SHAPE_SETS - 1, MOST_SHAPE_SETS = 13 };
extern const ShapeSet shape_sets[SHAPE_SETS];

const ShapeSet *ShapeSets(Scene scene, int *n);
PetscErrorCode LabNodeAt(Scene scene, PetscReal t, PetscReal s, const Node *node, LabNode *lab);

#endif
