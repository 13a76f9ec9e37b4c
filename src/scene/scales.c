#include "scene/scales.h"

/* What parts of it cells must be to see a length: a place that is joined smoothly or bends, a post,
   which is felt at points, and a bell of growth, which drives all there is. */
static const PetscReal of_width = 0.5, of_post = 1, of_zone = 0.125;

/* Who tells, and the option that says how fine the mesh is that is looked at, with its number. */
typedef struct {
  MPI_Comm comm;
  const char *option;
  PetscInt given;
} Telling;

/* A line for a length that the cell is too long to see. */
static PetscErrorCode Look(const Telling *to, const char *what, PetscReal length, PetscReal cell,
                           PetscReal resolved) {
  const PetscReal times = cell / (resolved * length);
  char text[2][64];

  PetscFunctionBegin;
  if (length <= 0 || times <= 1) PetscFunctionReturn(0);
  PetscCall(PetscPrintf(to->comm,
                        "%s %s: cells are up to %s long there and may miss it; give %.0f %s\n",
                        what, OptionNumber(length, text[0]), OptionNumber(cell, text[1]),
                        (double)PetscCeilReal(times * to->given), to->option));
  PetscFunctionReturn(0);
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

/* How far from 0 the rod comes up to a time. */
static PetscErrorCode Reach(Scene scene, PetscReal t, PetscReal *reach) {
  enum { TIMES = 100 };
  PetscReal length;

  PetscFunctionBegin;
  *reach = scene->clamp == CLAMP_FREE ? PETSC_MAX_REAL : 0;
  for (int k = 0; k <= TIMES; k++) {
    PetscCall(GrowthLength(scene->growth, PetscMax(0, t) * k / TIMES, &length, NULL));
    *reach = PetscMax(*reach, length);
  }
  PetscFunctionReturn(0);
}

/*
  ScalesTell - a line for each of the lengths that the scene's options give and the cells are too
  long for at a time; they are longest at the end of a run. Collective on the scene's ranks.

  mesh           labels of the nodes
  option, given  which says how many, and what it is
*/
PetscErrorCode ScalesTell(Scene scene, const Mesh *mesh, const char *option, PetscInt given,
                          PetscReal t) {
  const Telling to = {.comm = scene->comm, .option = option, .given = given};
  const Surfaces *surfaces = &scene->contact.surfaces;
  Growth growth = scene->growth;
  PetscReal longest, here, L, reach;

  PetscFunctionBegin;
  PetscCall(GrowthLength(growth, t, &L, NULL));
  PetscCall(Reach(scene, t, &reach));
  PetscCall(LongestCell(scene, mesh, 0, t, PETSC_FALSE, &longest));
  if (scene->load.field)
    PetscCall(Look(&to,
                   FieldIsLayered(scene->load.field) ? "-friction_layer_width" : "-friction_field",
                   FieldFinest(scene->load.field, reach), longest, of_width));
  if (scene->tip.resistance.field)
    PetscCall(Look(&to, "-tip_field", FieldFinest(scene->tip.resistance.field, reach), longest, 1));
  PetscCall(Look(&to, "-wall_file: a post or corner of radius", scene->contact.walls.smallest,
                 longest, of_post));
  if (surfaces->n && surfaces->smallest < PETSC_MAX_REAL)
    PetscCall(Look(&to, "-wall_file: a surface that stands out, with the rod's radius, of radius",
                   surfaces->smallest + scene->contact.diameter / 2, longest, of_post));
  PetscCall(LongestCell(scene, mesh, 0, t, (PetscBool)!growth->slides, &here));
  PetscCall(Look(&to,
                 growth->slides ? "-rod_curvature_length or -rod_curvature_file: bends of"
                                : "-rod_curvature_length or -rod_curvature_file: bends of (in s)",
                 CurvatureFinest(&scene->curvature), here, of_width));
  PetscCall(LongestCell(scene, mesh, 1 - PetscMin(growth->finest, L) / L, t, PETSC_FALSE, &here));
  PetscCall(Look(&to, "-growth_zone", growth->finest, here, of_zone));
  PetscCall(Look(&to, "-rod_stiffness_file: the stiffness changes by as much as it is within",
                 StiffnessFinest(&scene->stiffness, L), longest, of_width));
  PetscCall(LongestCell(scene, mesh, 0, t, PETSC_TRUE, &here));
  PetscCall(Look(&to, "-growth_table: the stretch changes by as much as it is within (in s)",
                 growth->steep, here, of_width));
  here = mesh->s[1];
  PetscCall(Look(&to, "-growth_width", growth->narrow, here, of_width));
  PetscFunctionReturn(0);
}
