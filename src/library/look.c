/* What is seen of a simulation: its time, nodes, series. */
#include "library/simulation.h"
#include <stdlib.h>

/* ColumnsBegin - no values any more; blocks that were told stay. */
void ColumnsBegin(Columns *self) {
  self->n = self->room = 0;
}

/* Room for one more. The blocks double, so that those left behind take no more than the last one.
   Large ones leave memory now and then, and those left behind at once. */
static PetscErrorCode Room(Columns *self) {
  enum { OFTEN = 4096 };
  const PetscInt room = 2 * self->room + 64;
  Spill *block;
  double *columns;

  PetscFunctionBegin;
  if (self->n % OFTEN == 0 && self->blocks) SpillRest(&self->block[self->blocks - 1]);
  if (self->n < self->room) PetscFunctionReturn(0);
  block = (Spill *)realloc(self->block, (size_t)(self->blocks + 1) * sizeof(*block));
  PetscCheck(block, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for series");
  self->block = block;
  PetscCall(SpillNew((size_t)(room * OBSERVED) * sizeof(*columns), &block[self->blocks]));
  columns = (double *)block[self->blocks++].at;
  for (int k = 0; k < OBSERVED; k++) {
    for (PetscInt i = 0; i < self->n; i++) columns[k * room + i] = self->column[k][i];
    self->column[k] = columns + k * room;
  }
  if (self->blocks > 1) SpillRest(&self->block[self->blocks - 2]);
  self->room = room;
  PetscFunctionReturn(0);
}

/* One more, without it counting. */
static PetscErrorCode Put(Columns *self, const Observation *seen) {
  PetscFunctionBegin;
  PetscCall(Room(self));
  for (int k = 0; k < OBSERVED; k++) self->column[k][self->n] = ((const PetscReal *)seen)[k];
  PetscFunctionReturn(0);
}

/* ColumnsAdd - one more value of each series. */
PetscErrorCode ColumnsAdd(Columns *self, const Observation *seen) {
  PetscFunctionBegin;
  PetscCall(Put(self, seen));
  self->n++;
  PetscFunctionReturn(0);
}

void ColumnsFree(Columns *self) {
  for (PetscInt k = 0; k < self->blocks; k++) SpillFree(&self->block[k]);
  free(self->block);
  *self = (Columns){0};
}

/* Is the present time within a step, whose end waits to be looked at? */
static PetscBool Within(const struct Tendril_ *self) {
  return (PetscBool)(self->grow->waits && self->at > self->grow->seen.t);
}

/* The state and its rate at the present time; U NULL: as it begins. Borrowed from V where they are
   between steps: the caller destroys that. */
static PetscErrorCode State(Tendril self, Vec V[2], Vec *U, Vec *U_t) {
  Grow *grow = self->grow;

  PetscFunctionBegin;
  V[0] = V[1] = *U = *U_t = NULL;
  if (Within(self)) {
    PetscCall(GrowWithin(grow, self->at, V, NULL));
    *U = V[0];
    *U_t = V[1];
  } else if (grow->seen.t > 0) {
    *U = grow->now->U;
    *U_t = grow->now->newton.latest.U_t;
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode LookWithin(Tendril self) {
  Grow *grow = self->grow;
  Vec V[2], U, U_t;

  PetscFunctionBegin;
  PetscCall(State(self, V, &U, &U_t));
  PetscCall(ObserverLookMoving(grow->observer, grow->now->rod, self->at, U, U_t, &self->here));
  self->here.energy_defect = grow->seen.energy_defect;
  self->here.error_tip = grow->seen.error_tip;
  self->here.error_norm_x2 = grow->seen.error_norm_x2;
  self->here.error_energy = grow->seen.error_energy;
  self->here.step = self->at - grow->seen.t;
  self->here.model = grow->seen.model;
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&V[k]));
  PetscFunctionReturn(0);
}

/* SimulationLook - brings up to date what is seen, behind all that moves the run. Collective. */
PetscErrorCode SimulationLook(Tendril self) {
  const Grow *grow = self->grow;
  const Columns *series = &self->series;

  PetscFunctionBegin;
  if (!Within(self)) {
    self->at = grow->seen.t;
    if (!series->n || series->column[0][series->n - 1] < grow->seen.t)
      PetscCall(ColumnsAdd(&self->series, &grow->seen));
    PetscFunctionReturn(0);
  }
  PetscCall(LookWithin(self));
  PetscCall(Put(&self->series, &self->here));
  PetscFunctionReturn(0);
}

int TendrilTime(Tendril self, double *t) {
  if (!self) return TENDRIL_USER;
  *t = self->grow ? self->at : 0;
  return self->code = TENDRIL_OK;
}

/* The k-th series that this simulation has; OBSERVED: there are no more. */
static int Which(const struct Tendril_ *self, int k) {
  for (int i = 0; i < OBSERVED; i++)
    if (OutputHolds(self->grow->output, i) && k-- == 0) return i;
  return OBSERVED;
}

const char *TendrilSeriesName(Tendril self, int k) {
  const int i = self && self->grow && k >= 0 ? Which(self, k) : OBSERVED;

  return i < OBSERVED ? observed_name[i] : NULL;
}

int TendrilSeries(Tendril self, const char *name, int *n, const double **values) {
  if (!self) return TENDRIL_USER;
  *n = 0;
  *values = NULL;
  if (!self->grow) return SimulationRefuse(self, TENDRIL_USER, "no series before TendrilSetUp()");
  for (int i = 0; i < OBSERVED; i++) {
    if (!name || strcmp(name, observed_name[i]) || !OutputHolds(self->grow->output, i)) continue;
    *n = (int)self->series.n + (Within(self) ? 1 : 0);
    *values = self->series.column[i];
    return self->code = TENDRIL_OK;
  }
  return SimulationRefuse(self, TENDRIL_USER,
                          "%s: this simulation has no such series; docs/results.md lists them",
                          name ? name : "NULL");
}

/* contact: at nodes and between them, in the clamp's frame; NULL: there is none. */
static PetscErrorCode TakeNodes(Tendril self, PetscReal t, const Node *nodes,
                                const PetscReal (*contact)[PUSH], int *n) {
  const Scene scene = self->scene;
  const PetscInt all = scene->mesh.cells + 1;

  PetscFunctionBegin;
  if (!self->node) self->node = (TendrilNode *)malloc((size_t)all * sizeof(*self->node));
  PetscCheck(self->node, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for nodes");
  for (PetscInt i = 0; i < all; i++) {
    TendrilNode *to = &self->node[i];
    PetscReal about[3];
    LabNode lab;
    PetscCall(LabNodeAt(scene, t, scene->mesh.s[i], &nodes[i], &lab));
    *to = (TendrilNode){.s = scene->mesh.s[i], .stretch = lab.stretch, .theta = lab.theta};
    if (contact) PetscCall(OutputContactAbout(scene, t, i, lab.stretch, contact, about));
    if (contact) SceneToLab(scene, about, to->contact);
    for (int k = 0; k < 3; k++) {
      to->x[k] = lab.x[k];
      to->v[k] = lab.v[k];
      to->curvature[k] = lab.strain[k];
      to->moment[k] = lab.moment[k];
      to->force[k] = lab.force[k];
      for (int d = 0; d < 3; d++) to->d[k][d] = lab.d[k][d];
    }
  }
  *n = (int)all;
  PetscFunctionReturn(0);
}

static PetscErrorCode GatherNodes(Tendril self, int *n) {
  const PetscReal law = self->scene->contact.time;
  const PetscReal(*contact)[PUSH] = NULL;
  Grow *grow = self->grow;
  const Node *nodes;
  Vec V[2], U, U_t;

  PetscFunctionBegin;
  PetscCall(State(self, V, &U, &U_t));
  PetscCall(ObserverGather(grow->observer, grow->now->rod, self->at, U, U_t, &nodes));
  if (nodes) PetscCall(ObserverContact(grow->observer, self->at, nodes, &contact));
  if (nodes) PetscCall(TakeNodes(self, self->at, nodes, contact, n));
  if (law > PETSC_MIN_REAL) PetscCall(SceneContactAt(self->scene, law));
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&V[k]));
  PetscFunctionReturn(0);
}

int TendrilNodes(Tendril self, int rod, int *n, const TendrilNode **nodes) {
  PetscErrorCode error = (PetscErrorCode)0;
  int code;

  *n = 0;
  *nodes = NULL;
  code = SimulationEnter(self);
  if (code) return code;
  if (!self->grow || rod) {
    (void)SimulationLeave(self, error);
    return SimulationRefuse(self, TENDRIL_USER,
                            rod ? "rod %d: there is one, 0" : "no nodes before TendrilSetUp()",
                            rod);
  }
  error = GatherNodes(self, n);
  *nodes = *n ? self->node : NULL;
  return SimulationLeave(self, error);
}
