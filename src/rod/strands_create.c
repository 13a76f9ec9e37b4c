/* What looks for strands that touch is made: rods are gathered, and samples laid along them. */
#include "curve/nearest.h"
#include "rod/strand_pairs.h"
#include "rod/rules.h"

enum { MOST_SAMPLES = 32 }; /* of a cell */

/* How many samples a cell in space has, so that they are close when the rod is longest. */
static PetscErrorCode SamplesOf(Scene scene, PetscInt *each) {
  const PetscInt cells = scene->mesh.cells;
  PetscReal *arc, longest = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(cells + 1, &arc));
  PetscCall(GrowthArc(scene->growth, cells + 1, scene->mesh.s, scene->end_time, arc, NULL));
  for (PetscInt i = 0; i < cells; i++) longest = PetscMax(longest, arc[i + 1] - arc[i]);
  PetscCall(PetscFree(arc));
  *each = 1;
  if (scene->contact.diameter <= 0) PetscFunctionReturn(0);
  *each = 1 + (PetscInt)PetscMin(MOST_SAMPLES - 1,
                                 longest / (rod_rule.sample_distance * scene->contact.diameter));
  PetscFunctionReturn(0);
}

/* Where samples are, and what is kept of them. */
static PetscErrorCode Sample(Strands self) {
  const PetscBool plane = (PetscBool)(self->dims == 2);
  const PetscReal ahead =
      plane ? 0 : 0.5; /* the first of a cell, in parts of the way to the next */

  PetscFunctionBegin;
  self->sides = plane ? 2 : 1;
  for (PetscInt r = 0; r < self->rods; r++) {
    Strand *rod = &self->rod[r];
    rod->each = 2;
    if (!plane) PetscCall(SamplesOf(rod->scene, &rod->each));
    rod->sample = self->samples;
    self->samples += rod->cells * rod->each + 1;
  }
  PetscCall(PetscMalloc1(self->sides * self->samples, &self->first));
  for (PetscInt k = 0; k < self->sides * self->samples; k++) self->first[k] = -1;
  PetscCall(PetscCalloc2(self->samples, &self->spot, self->samples, &self->placed));
  for (PetscInt r = 0; r < self->rods; r++) {
    const Strand *rod = &self->rod[r];
    Spot *spot = &self->spot[rod->sample];
    for (PetscInt k = 0; k < rod->cells * rod->each; k++, spot++)
      *spot = (Spot){.cell = rod->first + k / rod->each,
                     .on = {.z = (k % rod->each + ahead) / rod->each}};
    *spot = (Spot){.cell = rod->first + rod->cells - 1, .on = {.z = 1}};
  }
  if (self->rubs && plane) PetscCall(PetscCalloc1(self->sides * self->samples, &self->dual));
  if (self->rubs && !plane) PetscCall(PetscCalloc1(2 * self->nodes, &self->couple));
  PetscFunctionReturn(0);
}

/* The rods, and their nodes one behind the other. */
static PetscErrorCode Gather(Strands self, const Scene scene[]) {
  PetscFunctionBegin;
  PetscCall(PetscCalloc1(self->rods, &self->rod));
  for (PetscInt r = 0; r < self->rods; r++) {
    self->rod[r] = (Strand){.scene = scene[r],
                            .contact = &scene[r]->contact,
                            .first = self->nodes,
                            .cells = scene[r]->mesh.cells,
                            .axis = {1, 0, 0},
                            .apart = PETSC_PI / 2 * scene[r]->contact.diameter};
    self->nodes += scene[r]->mesh.cells + 1;
  }
  PetscCall(PetscMalloc4(self->nodes, &self->of, self->nodes, &self->s, self->nodes, &self->span,
                         self->nodes, &self->span_end));
  PetscCall(PetscCalloc1(2 * self->nodes, &self->weight));
  for (PetscInt r = 0; r < self->rods; r++) {
    const Strand *rod = &self->rod[r];
    for (PetscInt i = 0; i <= rod->cells; i++) {
      const PetscInt node = rod->first + i;
      self->of[node] = r;
      self->s[node] = scene[r]->mesh.s[i];
      self->span[node] = i && self->s[node] > self->s[node - 1] ? self->span[node - 1] : node;
    }
    for (PetscInt i = rod->cells; i >= 0; i--) {
      const PetscInt node = rod->first + i;
      self->span_end[node] = i < rod->cells && self->span[node + 1] == self->span[node]
                                 ? self->span_end[node + 1]
                                 : node;
    }
    CurveWeights(rod->cells, scene[r]->mesh.s, self->weight + 2 * rod->first);
  }
  PetscFunctionReturn(0);
}

/* Room for them, of which rods and dimension are known. */
static PetscErrorCode MakeRoom(Strands self, const Scene scene[]) {
  PetscInt n;

  PetscFunctionBegin;
  self->time = PETSC_MIN_REAL;
  PetscCall(Gather(self, scene));
  n = 2 * self->nodes;
  PetscCall(PetscCalloc5(n, &self->g, n, &self->g_t, n, &self->c, n, &self->strain, self->nodes,
                         &self->arc));
  PetscCall(PetscCalloc3(3 * self->nodes, &self->seen, n, &self->force, self->nodes, &self->joint));
  PetscCall(Sample(self));
  for (PetscInt k = 0; k < 3 * self->nodes; k++) self->seen[k] = PETSC_MAX_REAL;
  PetscFunctionReturn(0);
}

/* StrandsCreate - for a rod of a scene that has -contact_self, which must outlive it. Not
   collective; the caller destroys it with StrandsDestroy(). */
PetscErrorCode StrandsCreate(Scene scene, Strands *strands) {
  PetscFunctionBegin;
  PetscCall(PetscNew(strands));
  (*strands)->rods = 1;
  (*strands)->dims = scene->space.rod ? 3 : 2;
  (*strands)->rubs = (PetscBool)(scene->contact.friction > 0);
  PetscCall(MakeRoom(*strands, &scene));
  PetscFunctionReturn(0);
}

/* StrandsCreateSeveral - for several rods in space, whose scenes must outlive it. meet, with ctx:
   how two of them do, the first before the second; asked of once. */
PetscErrorCode StrandsCreateSeveral(PetscInt n, const Scene scene[], StrandsMeet meet, void *ctx,
                                    Strands *strands) {
  const PetscReal along[3] = {1, 0, 0};
  Strands self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *strands = self;
  self->rods = n;
  self->dims = 3;
  self->rubs = PETSC_TRUE;
  self->meet = meet;
  self->ctx = ctx;
  PetscCall(PetscMalloc1(n, &self->met));
  for (PetscInt r = 0; r < n; r++) self->met[r] = -1;
  PetscCall(MakeRoom(self, scene));
  for (PetscInt r = 0; r < n; r++) SceneToLab(scene[r], along, self->rod[r].axis);
  PetscFunctionReturn(0);
}

/* StrandsJoin - two rods are joined, at node a of the one and node b of the other, counted along
   these: strands near that, of both, do not touch. */
PetscErrorCode StrandsJoin(Strands self, const PetscInt rod[2], const PetscInt node[2]) {
  PetscFunctionBegin;
  PetscCall(PetscRealloc((size_t)(self->joints + 1) * sizeof(StrandJoint), &self->joint_at));
  for (int k = 0; k < 2; k++)
    self->joint_at[self->joints].node[k] = self->rod[rod[k]].first + node[k];
  self->joints++;
  PetscFunctionReturn(0);
}

PetscErrorCode StrandsDestroy(Strands *strands) {
  Strands self = *strands;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(PetscFree5(self->g, self->g_t, self->c, self->strain, self->arc));
  PetscCall(PetscFree3(self->seen, self->force, self->joint));
  PetscCall(PetscFree2(self->spot, self->placed));
  PetscCall(PetscFree4(self->of, self->s, self->span, self->span_end));
  PetscCall(PetscFree(self->joint_at));
  PetscCall(PetscFree(self->weight));
  PetscCall(PetscFree(self->first));
  PetscCall(PetscFree(self->dual));
  PetscCall(PetscFree(self->couple));
  PetscCall(PetscFree(self->pair));
  PetscCall(PetscFree(self->slopes));
  for (PetscInt k = 0; k < self->meetings; k++) PetscCall(PetscFree(self->meeting[k]));
  PetscCall(PetscFree(self->meeting));
  PetscCall(PetscFree(self->met));
  PetscCall(PetscFree(self->rod));
  PetscCall(PetscFree(*strands));
  PetscFunctionReturn(0);
}
