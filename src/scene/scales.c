#include "scene/scales.h"

/* What parts of it cells must be to see a length: a place that is joined smoothly, a bend, a post,
   which is felt at points, and a bell of growth, which drives all there is. */
static const PetscReal of_width = 0.5, of_bend = 1, of_post = 1, of_zone = 0.125;

static void Add(const char *option, PetscReal length, PetscReal cell, PetscReal resolved,
                PetscInt *n, Scale scale[]) {
  if (length > 0) scale[(*n)++] = (Scale){option, length, cell, resolved};
}

/* The longest cell at a time, of those that begin behind a label; in arc length, or in labels. */
static PetscErrorCode LongestCell(Scene scene, PetscReal from, PetscReal t, PetscBool labels,
                                  PetscReal *most) {
  const PetscReal *s = scene->mesh.s;
  PetscReal p[2];

  PetscFunctionBegin;
  *most = 0;
  for (PetscInt i = 0; i < scene->mesh.cells; i++) {
    if (s[i] < from) continue;
    PetscCall(GrowthArc(scene->growth, 2, &s[i], t, p, NULL));
    *most = PetscMax(*most, labels ? s[i + 1] - s[i] : p[1] - p[0]);
  }
  PetscFunctionReturn(0);
}

/* The distance of the knots of natural curvatures that are no constants, which bend over two. */
static PetscReal Bend(const Curvature *curvature) {
  PetscReal least = PETSC_MAX_REAL;

  for (int k = 0; k < STRAINS; k++) {
    const Strain *strain = &curvature->strain[k];
    for (PetscInt i = 0; i + 1 < strain->n; i++)
      least = PetscMin(least, strain->at[i + 1] - strain->at[i]);
  }
  return least < PETSC_MAX_REAL ? 2 * least : 0;
}

/*
  ScalesOf - the lengths that the scene's options give, each with the cell that is to see it, at the
  end of the run, when cells are longest. Not collective.

  n  how many, at most MOST_SCALES
*/
PetscErrorCode ScalesOf(Scene scene, PetscInt *n, Scale scale[MOST_SCALES]) {
  const Surfaces *surfaces = &scene->contact.surfaces;
  Growth growth = scene->growth;
  PetscReal longest, here, end = scene->end_time, zone = PetscMin(growth->finest, scene->reach);

  PetscFunctionBegin;
  *n = 0;
  PetscCall(LongestCell(scene, 0, end, PETSC_FALSE, &longest));
  if (scene->load.field)
    Add(FieldIsLayered(scene->load.field) ? "-friction_layer_width" : "-friction_field",
        FieldFinest(scene->load.field), longest, of_width, n, scale);
  if (scene->tip.resistance.field)
    Add("-tip_field", FieldFinest(scene->tip.resistance.field), longest, 1, n, scale);
  Add("-wall_file: a post or corner of radius", scene->contact.walls.smallest, longest, of_post, n,
      scale);
  if (surfaces->n && surfaces->smallest < PETSC_MAX_REAL)
    Add("-wall_file: a surface that stands out, with the rod's radius, of radius",
        surfaces->smallest + scene->contact.diameter / 2, longest, of_post, n, scale);
  PetscCall(LongestCell(scene, 0, end, (PetscBool)!growth->slides, &here));
  Add(growth->slides ? "-rod_curvature_length or -rod_curvature_file: bends of"
                     : "-rod_curvature_length or -rod_curvature_file: bends of (in s)",
      Bend(&scene->curvature), here, of_bend, n, scale);
  PetscCall(LongestCell(scene, 1 - zone / scene->reach, end, PETSC_FALSE, &here));
  Add("-growth_zone", growth->finest, here, of_zone, n, scale);
  here = scene->mesh.s[1];
  Add("-growth_width", growth->narrow, here, of_width, n, scale);
  PetscFunctionReturn(0);
}
