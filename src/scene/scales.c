#include "scene/scales.h"

/* What parts of it cells must be to see a length: a place that is joined smoothly, a bend, a post,
   which is felt at points, and a bell of growth, which drives all there is. */
static const PetscReal of_width = 0.5, of_bend = 1, of_post = 1, of_zone = 0.125;

/* Is the cell too long to see it? */
static void Look(const char *option, PetscReal length, PetscReal cell, PetscReal resolved,
                 PetscInt *n, Scale scale[]) {
  if (length > 0 && cell > resolved * length)
    scale[(*n)++] = (Scale){option, length, cell, resolved};
}

/* The longest cell at a time, of the last and those that begin behind a label; in arc length, or in
   labels. */
static PetscErrorCode LongestCell(Scene scene, const Mesh *mesh, PetscReal from, PetscReal t,
                                  PetscBool labels, PetscReal *most) {
  const PetscReal *s = mesh->s;
  PetscReal p[2];

  PetscFunctionBegin;
  *most = 0;
  for (PetscInt i = 0; i < mesh->cells; i++) {
    if (s[i] < from && i + 1 < mesh->cells) continue;
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
  ScalesMissed - the lengths that the scene's options give and the cells are too long for at a time,
  each with its cell. Cells are longest at the end of a run. Not collective.

  mesh  labels of the nodes
  n     how many, at most MOST_SCALES
*/
PetscErrorCode ScalesMissed(Scene scene, const Mesh *mesh, PetscReal t, PetscInt *n,
                            Scale scale[MOST_SCALES]) {
  const Surfaces *surfaces = &scene->contact.surfaces;
  Growth growth = scene->growth;
  PetscReal longest, here, L;

  PetscFunctionBegin;
  *n = 0;
  PetscCall(GrowthLength(growth, t, &L, NULL));
  PetscCall(LongestCell(scene, mesh, 0, t, PETSC_FALSE, &longest));
  if (scene->load.field)
    Look(FieldIsLayered(scene->load.field) ? "-friction_layer_width" : "-friction_field",
         FieldFinest(scene->load.field), longest, of_width, n, scale);
  if (scene->tip.resistance.field)
    Look("-tip_field", FieldFinest(scene->tip.resistance.field), longest, 1, n, scale);
  Look("-wall_file: a post or corner of radius", scene->contact.walls.smallest, longest, of_post, n,
       scale);
  if (surfaces->n && surfaces->smallest < PETSC_MAX_REAL)
    Look("-wall_file: a surface that stands out, with the rod's radius, of radius",
         surfaces->smallest + scene->contact.diameter / 2, longest, of_post, n, scale);
  PetscCall(LongestCell(scene, mesh, 0, t, (PetscBool)!growth->slides, &here));
  Look(growth->slides ? "-rod_curvature_length or -rod_curvature_file: bends of"
                      : "-rod_curvature_length or -rod_curvature_file: bends of (in s)",
       Bend(&scene->curvature), here, of_bend, n, scale);
  PetscCall(LongestCell(scene, mesh, 1 - PetscMin(growth->finest, L) / L, t, PETSC_FALSE, &here));
  Look("-growth_zone", growth->finest, here, of_zone, n, scale);
  here = mesh->s[1];
  Look("-growth_width", growth->narrow, here, of_width, n, scale);
  PetscFunctionReturn(0);
}

/* ScalesTell - a line for each of them. Collective on the scene's ranks. */
PetscErrorCode ScalesTell(Scene scene, const Mesh *mesh, PetscReal t) {
  Scale missed[MOST_SCALES];
  char text[2][64];
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(ScalesMissed(scene, mesh, t, &n, missed));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal times = missed[k].cell / (missed[k].resolved * missed[k].length);
    PetscCall(PetscPrintf(
        scene->comm, "%s %s: cells are up to %s long there and may miss it; give %.0f -rod_cells\n",
        missed[k].option, OptionNumber(missed[k].length, text[0]),
        OptionNumber(missed[k].cell, text[1]), (double)PetscCeilReal(times * mesh->cells)));
  }
  PetscFunctionReturn(0);
}
