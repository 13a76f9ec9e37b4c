/* What a material has learned where it slides past the labels: states go along with it. */
#include "rod/learned_front.h"

/* The labels of places, two a node; that behind the tip is none. */
static PetscReal Label(const Rod rod, PetscInt place) {
  const PetscReal *s = rod->scene->mesh.s;

  return place % 2 ? (s[place / 2] + s[place / 2 + 1]) / 2 : s[place / 2];
}

/* Beyond the clamp of a rod that is fed the field goes on oddly: what is fed in has learned
   nothing. Arrays of places have so many before the first. */
enum { STENCIL = LEARNED_STENCIL, BEYOND = STENCIL / 2 - 1 };

static void GoOnOddly(PetscInt width, PetscReal *first) {
  for (PetscInt k = 1; k <= BEYOND; k++)
    for (PetscInt c = 0; c < width; c++) first[-k * width + c] = -first[k * width + c];
}

/* What the weights of places first .. first + STENCIL - 1 are divided by, for all first places from
   -BEYOND on. */
static void FindDivisors(const PetscReal *label, PetscInt last, PetscReal (*over)[STENCIL]) {
  for (PetscInt first = -BEYOND; first + STENCIL <= last + 1; first++)
    for (int i = 0; i < STENCIL; i++) {
      PetscReal product = 1;
      for (int j = 0; j < STENCIL; j++)
        if (j != i) product *= label[first + i] - label[first + j];
      over[first + BEYOND][i] = 1 / product;
    }
}

/* The weights of places for a value at a label, by the labels of these. */
static void Weights(const PetscReal label[STENCIL], const PetscReal over[STENCIL], PetscReal at,
                    PetscReal w[STENCIL]) {
  PetscReal away[STENCIL], before = 1, behind = 1;

  for (int i = 0; i < STENCIL; i++) {
    away[i] = at - label[i];
    w[i] = over[i] * before;
    before *= away[i];
  }
  for (int i = STENCIL - 1; i >= 0; i--) {
    w[i] *= behind;
    behind *= away[i];
  }
}

/* The labels of all places, and what goes with them: once, for the mesh stays. */
static PetscErrorCode FindLabels(Rod rod) {
  Learned self = rod->learned;
  const PetscInt last = 2 * rod->last;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(BEYOND + last + 1, &self->label));
  PetscCall(PetscMalloc1((last + 1) * STENCIL, (PetscReal **)&self->over));
  for (PetscInt i = 0; i <= last; i++) self->label[BEYOND + i] = Label(rod, i);
  GoOnOddly(1, self->label + BEYOND);
  FindDivisors(self->label + BEYOND, last, self->over);
  PetscFunctionReturn(0);
}

/* LearnedGather - so many numbers of each node, of which a rank has put those of its own into their
   place, to all ranks. Collective. */
PetscErrorCode LearnedGather(Rod rod, PetscInt width, PetscReal *all) {
  const PetscMPIInt mine[2] = {(PetscMPIInt)((rod->end - rod->first) * width),
                               (PetscMPIInt)(rod->first * width)};
  PetscMPIInt ranks, *many, *from;

  PetscFunctionBegin;
  if (rod->alone) PetscFunctionReturn(0);
  PetscCallMPI(MPI_Comm_size(rod->scene->comm, &ranks));
  PetscCall(PetscMalloc2(ranks, &many, ranks, &from));
  PetscCallMPI(MPI_Allgather(&mine[0], 1, MPI_INT, many, 1, MPI_INT, rod->scene->comm));
  PetscCallMPI(MPI_Allgather(&mine[1], 1, MPI_INT, from, 1, MPI_INT, rod->scene->comm));
  PetscCallMPI(MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, all, many, from, MPIU_REAL,
                              rod->scene->comm));
  PetscCall(PetscFree2(many, from));
  PetscFunctionReturn(0);
}

/* All places of a vector's states, node after node, on every rank; and those beyond the clamp. */
static PetscErrorCode AllStates(Rod rod, Vec V, PetscReal *all) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields, width = 2 * self->per;
  const PetscScalar *v;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(V, &v));
  for (PetscInt i = 0; i < rod->end - rod->first; i++)
    for (PetscInt f = 0; f < width; f++)
      all[(rod->first + i) * width + f] = PetscRealPart(v[i * fields + self->mech + f]);
  PetscCall(VecRestoreArrayRead(V, &v));
  PetscCall(LearnedGather(rod, width, all));
  GoOnOddly(self->per, all);
  PetscFunctionReturn(0);
}

/* By how much what is learned rises along the labels where material comes in, in a state: it has
   learned nothing there, and learns as it goes on. all: of all places, and the tip's signal behind.
 */
static PetscErrorCode Inflow(Rod rod, PetscReal t, Vec U, const PetscReal *all, PetscReal slope[]) {
  const Learned self = rod->learned;
  const Tropism *law = &rod->scene->tropism;
  const PetscReal *signal = all + (2 * rod->last + 1) * self->per, *u;
  PetscReal g, g_t, speed = GrowthSpeed(rod->scene->growth, 0, t, 0);
  LearnedPoint point;

  PetscFunctionBegin;
  PetscCall(GrowthLength(rod->scene->growth, t, &g, &g_t));
  PetscCall(VecGetArrayRead(U, (const PetscScalar **)&u));
  for (PetscInt b = 0; b < self->bends && rod->first == 0; b++) {
    if (self->extra) speed = u[self->lead];
    PetscCall(self->sees(rod, t, u, &point));
    const PetscReal f = self->at_tip      ? signal[b]
                        : self->remembers ? 0
                                          : point.sensed[b],
                    drive = TropismDrive(law, f, point.natural[b], point.elastic[b],
                                         TropismNutation(law, b, t));
    slope[b] = g / speed * TropismClock(law, rod->scene->growth, 0, t, g, g_t) * drive;
    if (self->remembers) slope[self->bends + b] = g / speed * point.sensed[b] / law->memory;
  }
  PetscCall(VecRestoreArrayRead(U, (const PetscScalar **)&u));
  if (!rod->alone)
    PetscCallMPI(MPI_Bcast(slope, (PetscMPIInt)self->per, MPIU_REAL, 0, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* LearnedFindCorner - what a front in the cells adds to their turns, in the state that has been
   taken apart. Collective. */
PetscErrorCode LearnedFindCorner(Rod rod, PetscReal t, Vec U) {
  const PetscInt per = rod->learned->per;
  Learned self = rod->learned;
  PetscReal *room = NULL, *all = self->k + 2 * per, inflow[2 * TROPISM_BENDS];
  LearnedSides sides;

  PetscFunctionBegin;
  self->corner.cell = -1;
  if (self->smooth || !LearnedHasCorner(rod)) PetscFunctionReturn(0);
  if (!self->label) PetscCall(FindLabels(rod));
  if (!rod->alone) {
    PetscCall(PetscMalloc1((BEYOND + 2 * rod->last + 2) * per, &room));
    all = room + BEYOND * per;
    PetscCall(AllStates(rod, U, all));
  }
  PetscCall(Inflow(rod, t, U, all, inflow));
  LearnedFrontFind(rod, t, self->label + BEYOND, all, inflow, &sides);
  if (sides.at > 0) LearnedFrontTurns(&sides, &self->corner);
  PetscCall(PetscFree(room));
  PetscFunctionReturn(0);
}

/* LearnedCarries - do states go along with material that slides past the labels? */
PetscBool LearnedCarries(const Rod rod) {
  return (PetscBool)(rod->learned && TropismLearns(&rod->scene->tropism) &&
                     rod->scene->growth->slides);
}

/* LearnedKeepWay - before a step: where growth feels force, which way the material has come is that
   of the states that the step goes on from, the latest first. Collective. */
PetscErrorCode LearnedKeepWay(Rod rod, PetscInt m, const PetscReal times[], const Vec points[]) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields, n = rod->last + 1;
  PetscReal *all, *speed, *length;
  const PetscScalar *v;

  PetscFunctionBegin;
  if (!self->extra || !LearnedCarries(rod)) PetscFunctionReturn(0);
  PetscCall(PetscMalloc3(2 * n, &all, m * n, &speed, m, &length));
  for (PetscInt j = 0; j < m; j++) {
    PetscCall(VecGetArrayRead(points[j], &v));
    for (PetscInt i = 0; i < rod->end - rod->first; i++)
      for (int f = 0; f < 2; f++)
        all[2 * (rod->first + i) + f] = PetscRealPart(v[i * fields + self->lead + f]);
    PetscCall(VecRestoreArrayRead(points[j], &v));
    PetscCall(LearnedGather(rod, 2, all));
    for (PetscInt i = 0; i < n; i++) speed[j * n + i] = all[2 * i];
    length[j] = all[2 * n - 1];
  }
  PetscCall(GrowthYieldKeep(rod->scene->growth, m, times, length, n, rod->scene->mesh.s, speed));
  PetscCall(PetscFree3(all, speed, length));
  PetscFunctionReturn(0);
}

/* The states of one place where the material was that is at a label. place: one at or before it,
   where to look; least: the first place there is, below 0 where material comes in. */
static void StatesAt(const Rod rod, const PetscReal *label, const PetscReal *all, PetscInt least,
                     PetscReal at, PetscInt *place, PetscReal k[]) {
  const PetscInt per = rod->learned->per, last = 2 * rod->last;
  const PetscReal sign = at < 0 ? -1 : 1;
  PetscReal w[STENCIL];
  PetscInt first;

  at = PetscMin(1, PetscAbsReal(at));
  if (label[*place] > at) *place = 0;
  while (*place + 1 < last && label[*place + 1] <= at) (*place)++;
  first = PetscMax(least, PetscMin(*place - (STENCIL / 2 - 1), last + 1 - STENCIL));
  Weights(label + first, rod->learned->over[first + BEYOND], at, w);
  for (PetscInt c = 0; c < per; c++) {
    k[c] = 0;
    for (int i = 0; i < STENCIL; i++) k[c] += sign * w[i] * all[(first + i) * per + c];
  }
}

/* LearnedTimesRate - V, a change of rates, becomes what it changes the equations of states by. */
PetscErrorCode LearnedTimesRate(Rod rod, Vec V) {
  const Learned self = rod->learned;
  const PetscInt fields = rod->model->fields;
  PetscScalar *v;

  PetscFunctionBegin;
  PetscCall(VecGetArray(V, &v));
  for (PetscInt i = 0; i < rod->end - rod->first; i++)
    for (PetscInt f = 0; f < fields; f++)
      v[i * fields + f] *= f < self->mech ? 0
                           : self->remembers && (f - self->mech) % self->per >= self->bends
                               ? rod->scene->tropism.memory
                               : 1;
  PetscCall(VecRestoreArray(V, &v));
  PetscFunctionReturn(0);
}

/*
  LearnedCarry - makes of a sum of points times their weights, at fixed labels, one along the
  material: to U_t that is D/Dt then (docs/theory/growth.md). Of a rod of which LearnedCarries();
  collective.

  t, times  of the sum, and of its points, which are earlier
  weight    of each point, for each field
  states    points are states of the rod, not changes of them
*/
PetscErrorCode LearnedCarry(Rod rod, PetscReal t, PetscInt m, const PetscReal times[],
                            const Vec points[], PetscReal weight[][MAX_FIELDS], PetscBool states,
                            Vec sum) {
  const Learned self = rod->learned;
  const Growth growth = rod->scene->growth;
  const PetscInt fields = rod->model->fields, per = self->per, last = 2 * rod->last,
                 begin = 2 * rod->first, end = PetscMin(2 * rod->end, last + 1),
                 least = LearnedFront(rod) && GrowthSpeed(growth, 0, t, 0) > 0 ? -BEYOND : 0;
  const PetscBool corner = LearnedHasCorner(rod);
  LearnedSides sides;
  const PetscReal *label;
  PetscReal *from, *room, *all, k[2 * TROPISM_BENDS], inflow[2 * TROPISM_BENDS];
  PetscScalar *x;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(last + 1, &from, (BEYOND + last + 2) * per, &room));
  if (!self->label) PetscCall(FindLabels(rod));
  label = self->label + BEYOND;
  all = room + BEYOND * per;
  PetscCall(VecGetArray(sum, &x));
  for (PetscInt j = 0; j < m; j++) {
    const PetscBool on = (PetscBool)(j > 0 && times[j] < times[j - 1]); /* on the same way */
    PetscInt at = 0;
    PetscCall(AllStates(rod, points[j], all));
    PetscCall(growth->depart(growth, on ? times[j - 1] : t, times[j], end - begin,
                             on ? from : label + begin, from)); /* (in place, place by place) */
    if (corner) {
      if (states) PetscCall(Inflow(rod, times[j], points[j], all, inflow));
      LearnedFrontFind(rod, times[j], label, all, states ? inflow : NULL, &sides);
    }
    for (PetscInt i = begin; i < end; i++) {
      PetscScalar *to = x + (i / 2 - rod->first) * fields + self->mech + i % 2 * per;
      const PetscReal *w = weight[j] + self->mech + i % 2 * per;
      if (corner)
        LearnedFrontStates(&sides, from[i - begin], k);
      else
        StatesAt(rod, label, all, least, from[i - begin], &at, k);
      for (PetscInt c = 0; c < per; c++) to[c] += w[c] * (k[c] - all[i * per + c]);
    }
  }
  PetscCall(VecRestoreArray(sum, &x));
  PetscCall(PetscFree2(from, room));
  PetscFunctionReturn(0);
}
