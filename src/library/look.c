/* What is seen of a simulation: its time, nodes, series. */
#include "library/simulation.h"
#include "rod/ask.h"
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
  return (PetscBool)(CourseWaits(self) && self->at > CourseTime(self));
}

/* The part of a state that is rod k's, until Close(). */
static PetscErrorCode Open(Tendril self, PetscInt k, Vec all, Vec *part) {
  PetscFunctionBegin;
  *part = all;
  if (self->several && all) PetscCall(RodPartOpenRead(self->several->leg.rod, k, all, part));
  PetscFunctionReturn(0);
}

static PetscErrorCode Close(Tendril self, PetscInt k, Vec all, Vec *part) {
  PetscFunctionBegin;
  if (self->several && all) PetscCall(RodPartCloseRead(self->several->leg.rod, k, all, part));
  PetscFunctionReturn(0);
}

/* What is seen of a rod in a state within a step. */
static PetscErrorCode LookWithinAt(Tendril self, PetscInt k, Vec U, Vec U_t) {
  const Grow *grow = CourseRod(self, k);
  Observation *here = &self->sight[k].here;

  PetscFunctionBegin;
  PetscCall(ObserverLookMoving(grow->observer, grow->now->rod, self->at, U, U_t, here));
  here->energy_defect = grow->seen.energy_defect;
  here->error_tip = grow->seen.error_tip;
  here->error_norm_x2 = grow->seen.error_norm_x2;
  here->error_energy = grow->seen.error_energy;
  here->step = self->at - grow->seen.t;
  here->model = grow->seen.model;
  PetscCall(Put(&self->sight[k].series, here));
  PetscFunctionReturn(0);
}

/* A row of all rods, without it counting, from that of each. */
static PetscErrorCode PutSum(Tendril self, PetscInt row) {
  const PetscInt n = self->rods;
  Observation sum = {0};
  PetscReal *of_each;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &of_each));
  for (PetscInt i = 0; i < OBSERVED; i++) {
    for (PetscInt k = 0; k < n; k++)
      of_each[k] =
          OutputHolds(CourseRod(self, k)->output, i) ? self->sight[k].series.column[i][row] : NAN;
    ((PetscReal *)&sum)[i] = SeveralSum(&self->several->file, i, of_each);
  }
  PetscCall(PetscFree(of_each));
  PetscCall(Put(&self->sight[n].series, &sum));
  PetscFunctionReturn(0);
}

/* SimulationAddSum - one more row of all rods. */
PetscErrorCode SimulationAddSum(Tendril self, PetscInt row) {
  PetscFunctionBegin;
  PetscCall(PutSum(self, row));
  self->sight[self->rods].series.n++;
  PetscFunctionReturn(0);
}

static PetscErrorCode LookWithin(Tendril self) {
  Vec V[2], U, U_t, part[2];

  PetscFunctionBegin;
  PetscCall(CourseState(self, self->at, V, &U, &U_t));
  for (PetscInt k = 0; k < self->rods; k++) {
    PetscCall(Open(self, k, U, &part[0]));
    PetscCall(Open(self, k, U_t, &part[1]));
    PetscCall(LookWithinAt(self, k, part[0], part[1]));
    PetscCall(Close(self, k, U_t, &part[1]));
    PetscCall(Close(self, k, U, &part[0]));
  }
  if (self->several) PetscCall(PutSum(self, self->sight[0].series.n));
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&V[k]));
  PetscFunctionReturn(0);
}

/* SimulationLook - brings up to date what is seen, behind all that moves the run. Collective. */
PetscErrorCode SimulationLook(Tendril self) {
  const Columns *first = &self->sight[0].series;

  PetscFunctionBegin;
  if (Within(self)) {
    PetscCall(LookWithin(self));
    PetscFunctionReturn(0);
  }
  self->at = CourseTime(self);
  if (first->n && first->column[0][first->n - 1] >= self->at) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < self->rods; k++)
    PetscCall(ColumnsAdd(&self->sight[k].series, &CourseRod(self, k)->seen));
  if (self->several) PetscCall(SimulationAddSum(self, first->n - 1));
  PetscFunctionReturn(0);
}

int TendrilTime(Tendril self, double *t) {
  if (!self) return TENDRIL_USER;
  *t = CourseIsThere(self) ? self->at : 0;
  return self->code = TENDRIL_OK;
}

int TendrilRods(Tendril self, int *n) {
  if (!self) return TENDRIL_USER;
  *n = CourseIsThere(self) ? (int)self->rods : 0;
  return self->code = TENDRIL_OK;
}

const char *TendrilRodName(Tendril self, int rod) {
  if (!self || !CourseIsThere(self) || rod < 0 || rod >= self->rods) return NULL;
  return self->several ? RodsName(self->several->rods, rod) : "";
}

/* Is there this series of rod k; behind the last: of all of them? */
static PetscBool Has(const struct Tendril_ *self, PetscInt k, int observed) {
  return k < self->rods ? OutputHolds(CourseRod(self, k)->output, observed)
                        : SeveralHas(&self->several->file, observed);
}

/* Where the series are that have no rod: of the only one, or of all. */
static PetscInt Whole(const struct Tendril_ *self) {
  return self->several ? self->rods : 0;
}

/* The k-th series that a rod has; behind the last: all of them. */
static const char *NameOf(const struct Tendril_ *self, PetscInt rod, int k) {
  for (int i = 0; i < OBSERVED && k >= 0; i++)
    if (Has(self, rod, i) && k-- == 0) return observed_name[i];
  return NULL;
}

const char *TendrilSeriesName(Tendril self, int k) {
  return self && CourseIsThere(self) ? NameOf(self, Whole(self), k) : NULL;
}

const char *TendrilRodSeriesName(Tendril self, int rod, int k) {
  if (!self || !CourseIsThere(self) || rod < 0 || rod >= self->rods) return NULL;
  return NameOf(self, rod, k);
}

/* The series of rod k; behind the last: of all of them. */
static int SeriesOf(Tendril self, PetscInt k, const char *name, int *n, const double **values) {
  for (int i = 0; i < OBSERVED; i++) {
    if (!name || strcmp(name, observed_name[i]) || !Has(self, k, i)) continue;
    *n = (int)self->sight[k].series.n + (Within(self) ? 1 : 0);
    *values = self->sight[k].series.column[i];
    return self->code = TENDRIL_OK;
  }
  return SimulationRefuse(self, TENDRIL_USER,
                          "%s: this simulation has no such series; docs/results.md lists them",
                          name ? name : "NULL");
}

int TendrilSeries(Tendril self, const char *name, int *n, const double **values) {
  if (!self) return TENDRIL_USER;
  *n = 0;
  *values = NULL;
  if (!CourseIsThere(self))
    return SimulationRefuse(self, TENDRIL_USER, "no series before TendrilSetUp()");
  return SeriesOf(self, Whole(self), name, n, values);
}

/* There is no such rod. */
static int RefuseRod(Tendril self, int rod) {
  if (self->rods == 1) return SimulationRefuse(self, TENDRIL_USER, "rod %d: there is one, 0", rod);
  return SimulationRefuse(self, TENDRIL_USER, "rod %d: there are %d, from 0 on", rod,
                          (int)self->rods);
}

int TendrilRodSeries(Tendril self, int rod, const char *name, int *n, const double **values) {
  if (!self) return TENDRIL_USER;
  *n = 0;
  *values = NULL;
  if (!CourseIsThere(self))
    return SimulationRefuse(self, TENDRIL_USER, "no series before TendrilSetUp()");
  return rod < 0 || rod >= self->rods ? RefuseRod(self, rod) : SeriesOf(self, rod, name, n, values);
}

/* Room for the nodes of a rod. */
static PetscErrorCode NodeRoom(Tendril self, PetscInt n) {
  PetscFunctionBegin;
  if (n <= self->room) PetscFunctionReturn(0);
  free(self->node);
  self->node = (TendrilNode *)malloc((size_t)n * sizeof(*self->node));
  self->room = self->node ? n : 0;
  PetscCheck(self->node, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for nodes");
  PetscFunctionReturn(0);
}

/* contact: at nodes and between them, in the clamp's frame; NULL: there is none. */
static PetscErrorCode TakeNodes(Tendril self, const Scene scene, PetscReal t, const Node *nodes,
                                const PetscReal (*contact)[PUSH], int *n) {
  const PetscInt all = scene->mesh.cells + 1;

  PetscFunctionBegin;
  PetscCall(NodeRoom(self, all));
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

static PetscErrorCode GatherNodes(Tendril self, PetscInt rod, int *n) {
  Grow *grow = CourseRod(self, rod);
  const Scene scene = grow->scene;
  const PetscReal law = scene->contact.time;
  const PetscReal(*contact)[PUSH] = NULL;
  Vec V[2], U, U_t, part[2];
  const Node *nodes;

  PetscFunctionBegin;
  PetscCall(CourseState(self, self->at, V, &U, &U_t));
  PetscCall(Open(self, rod, U, &part[0]));
  PetscCall(Open(self, rod, U_t, &part[1]));
  PetscCall(ObserverGather(grow->observer, grow->now->rod, self->at, part[0], part[1], &nodes));
  if (nodes) PetscCall(ObserverContact(grow->observer, self->at, nodes, &contact));
  if (nodes) PetscCall(TakeNodes(self, scene, self->at, nodes, contact, n));
  PetscCall(Close(self, rod, U_t, &part[1]));
  PetscCall(Close(self, rod, U, &part[0]));
  if (law > PETSC_MIN_REAL) PetscCall(SceneContactAt(scene, law));
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
  if (!CourseIsThere(self) || rod < 0 || rod >= self->rods) {
    (void)SimulationLeave(self, error);
    return CourseIsThere(self)
               ? RefuseRod(self, rod)
               : SimulationRefuse(self, TENDRIL_USER, "no nodes before TendrilSetUp()");
  }
  error = GatherNodes(self, rod, n);
  *nodes = *n ? self->node : NULL;
  return SimulationLeave(self, error);
}
