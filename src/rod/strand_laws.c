/* Strands of several rods: the law by which two touch, and their frames. */
#include "rod/strand_pairs.h"
#include <string.h>

/* ---- laws ---- */

/* The mean of what two rods have of it. */
static PetscReal Mean(PetscReal a, PetscReal b) {
  return (a + b) / 2;
}

/* The law of a meeting, of those of both rods now: springs in series. */
static void LawNow(const struct _Strands *self, Meeting *meeting) {
  const Contact *a = self->rod[meeting->rod[0]].contact, *b = self->rod[meeting->rod[1]].contact;
  Contact *law = &meeting->law;
  PetscReal k = 1 / Mean(1 / a->stiffness, 1 / b->stiffness);

  law->stiffness_t =
      k * k *
      Mean(a->stiffness_t / PetscSqr(a->stiffness), b->stiffness_t / PetscSqr(b->stiffness));
  if (meeting->how.stiffness > 0) {
    k = meeting->how.stiffness;
    law->stiffness_t = 0;
  }
  law->stiffness = k;
  law->smooth = Mean(a->smooth, b->smooth);
  law->smooth_t = Mean(a->smooth_t, b->smooth_t);
  law->firm = (PetscBool)(meeting->how.stiffness == 0 && (a->firm || b->firm));
}

/* StrandLawsNow - all laws are those of now. */
void StrandLawsNow(Strands self) {
  for (PetscInt k = 0; k < self->meetings; k++)
    if (self->meeting[k]->how.touch) LawNow(self, self->meeting[k]);
}

/* What does not change of it. How deep they press each other in the thinner one is told of. */
static void MakeLaw(const struct _Strands *self, Meeting *meeting) {
  const Contact *a = self->rod[meeting->rod[0]].contact, *b = self->rod[meeting->rod[1]].contact;
  const Contact *thin = a->diameter <= b->diameter ? a : b;

  meeting->law = (Contact){.any = PETSC_TRUE,
                           .among = PETSC_TRUE,
                           .diameter = Mean(a->diameter, b->diameter),
                           .friction = meeting->how.friction >= 0 ? meeting->how.friction
                                                                  : Mean(a->friction, b->friction),
                           .rub = a->rub,
                           .deepest = meeting->how.stiffness > 0 ? NULL : thin->deepest};
  if (a->diameter <= 0 || b->diameter <= 0) meeting->how.touch = PETSC_FALSE;
  if (meeting->how.touch) LawNow(self, meeting);
}

/* StrandLawOf - the law by which two rods touch, a before b; NULL: they do not. */
PetscErrorCode StrandLawOf(Strands self, PetscInt a, PetscInt b, const Contact **law) {
  PetscInt k = self->met[a];
  Meeting *meeting;

  PetscFunctionBegin;
  while (k >= 0 && self->meeting[k]->rod[1] != b) k = self->meeting[k]->next;
  if (k < 0) {
    k = self->meetings++;
    PetscCall(PetscRealloc((size_t)self->meetings * sizeof(*self->meeting), &self->meeting));
    PetscCall(PetscNew(&meeting));
    self->meeting[k] = meeting;
    *meeting = (Meeting){.rod = {a, b}, .next = self->met[a]};
    self->met[a] = k;
    PetscCall(self->meet(self->ctx, a, b, &meeting->how));
    MakeLaw(self, meeting);
  }
  *law = self->meeting[k]->how.touch ? &self->meeting[k]->law : NULL;
  PetscFunctionReturn(0);
}

/* ---- frames ---- */

/* A column of a matrix is brought into the laboratory's frame. */
static void ColumnToLab(Scene scene, PetscReal by[3][4], int j) {
  PetscReal v[3], lab[3];

  Column3(by[0], 4, j, v);
  SceneToLab(scene, v, lab);
  for (int d = 0; d < 3; d++) by[d][j] = lab[d];
}

/* A vector likewise, or back from there. */
static void Turn(Scene scene, PetscBool to_lab, PetscReal v[3]) {
  PetscReal from[3];

  memcpy(from, v, sizeof(from));
  if (to_lab)
    SceneToLab(scene, from, v);
  else
    SpaceFromLab(&scene->space, from, v);
}

/* StrandJointToLab - a node in the laboratory's frame. By its place things change there as by that
   in its own: see StrandSlopeToOwn(). (Rates of all parts of it have one shift.) */
void StrandJointToLab(const struct _Strands *self, PetscInt node, Joint *joint) {
  const Scene scene = StrandOf(self, node)->scene;
  PetscReal own[3];

  memcpy(own, joint->x, sizeof(own));
  ScenePlaceToLab(scene, own, joint->x);
  Turn(scene, PETSC_TRUE, joint->x_t);
  Turn(scene, PETSC_TRUE, joint->q);
  Turn(scene, PETSC_TRUE, joint->q_t);
  for (int j = 0; j < 4; j++) {
    ColumnToLab(scene, joint->by.q, j);
    ColumnToLab(scene, joint->by.slope_t, j);
  }
}

/* StrandsToOwn - loads at all points, each in its own rod's frame. */
void StrandsToOwn(const struct _Strands *self, PetscReal (*load)[3]) {
  for (PetscInt k = 0; k < 2 * self->nodes; k++)
    Turn(StrandOf(self, k / 2)->scene, PETSC_FALSE, load[k]);
}

/* Derivatives of a load on a rod by the unknowns of two cells: rows into its frame, columns of
   places into those of the rods that the cells are of. */
static void ByToOwn(Scene of_load, const Scene of_cell[2], StrandBy by) {
  for (int u = 0; u < STRAND_UNKNOWNS; u++) {
    PetscReal v[3];
    Column3(by[0], STRAND_UNKNOWNS, u, v);
    Turn(of_load, PETSC_FALSE, v);
    for (int d = 0; d < 3; d++) by[d][u] = v[d];
  }
  for (int node = 0; node < 4; node++)
    for (int d = 0; d < 3; d++) Turn(of_cell[node / 2], PETSC_FALSE, &by[d][STRAND_NODE * node]);
}

/* StrandSlopeToOwn - what a contact's loads change by, in the frames of its rods. */
void StrandSlopeToOwn(const struct _Strands *self, StrandSlope *slope) {
  const Scene of_cell[2] = {StrandOf(self, slope->cell[0])->scene,
                            StrandOf(self, slope->cell[1])->scene};

  for (int k = 0; k < slope->takers; k++) {
    const Scene of_load = StrandOf(self, slope->taker[k] / 2)->scene;
    ByToOwn(of_load, of_cell, slope->by[k]);
    if (slope->couples) ByToOwn(of_load, of_cell, slope->couple_by[k]);
  }
}
