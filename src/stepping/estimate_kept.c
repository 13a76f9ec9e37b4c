/* The errors of a run as a restart keeps them: numbers, and states of the rod. */
#include "stepping/estimating.h"

/* A vector of the rod from the first fields of the coarse nodes on rank 0, linearly between them.
   Collective. */
static PetscErrorCode Spread(Estimate self, PetscInt width, const PetscReal *coarse, Vec V) {
  const PetscInt fields = self->fields, count = self->nodes * width;
  const Rod rod = self->leg->rod;
  const PetscReal *s = rod->s;
  PetscScalar *v;
  PetscReal *c;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(count, &c));
  if (self->rod) PetscCall(PetscArraycpy(c, coarse, count));
  PetscCallMPI(MPI_Bcast(c, (PetscMPIInt)count, MPIU_REAL, 0, rod->comm));
  PetscCall(VecSet(V, 0));
  PetscCall(VecGetArray(V, &v));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    const PetscInt k = PetscMin(i / self->stride, self->nodes - 2), a = EstimateFineNode(self, k),
                   b = EstimateFineNode(self, k + 1);
    const PetscReal z = i == a || i == b ? i == b : (s[i] - s[a]) / (s[b] - s[a]);
    for (PetscInt f = 0; f < width; f++)
      v[(i - rod->first) * fields + f] = (1 - z) * c[k * width + f] + z * c[(k + 1) * width + f];
  }
  PetscCall(VecRestoreArray(V, &v));
  PetscCall(PetscFree(c));
  PetscFunctionReturn(0);
}

/* The first fields of the coarse nodes, on rank 0, from a vector of the rod. Collective. */
static PetscErrorCode Pick(Estimate self, PetscInt width, Vec V, PetscReal *coarse) {
  const PetscScalar *v;
  VecScatter to_zero;
  Vec all;

  PetscFunctionBegin;
  PetscCall(VecScatterCreateToZero(V, &to_zero, &all));
  PetscCall(VecScatterBegin(to_zero, V, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(to_zero, V, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(all, &v));
  for (PetscInt k = 0; k < self->nodes && self->rod; k++)
    for (PetscInt f = 0; f < width; f++)
      coarse[k * width + f] = PetscRealPart(v[EstimateFineNode(self, k) * self->fields + f]);
  PetscCall(VecRestoreArrayRead(all, &v));
  PetscCall(VecScatterDestroy(&to_zero));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(0);
}

/* What is remembered beside errors: numbers to read from and to write to. */
static void Remembered(Estimate self, PetscReal *number[ESTIMATE_NUMBERS]) {
  PetscInt n = 0;

  number[n++] = &self->before;
  number[n++] = &self->time;
  for (int k = 0; k < MIRRORS; k++) {
    number[n++] = &self->size[k];
    number[n++] = &self->latest[k];
    number[n++] = &self->measured[k];
  }
  for (int k = 0; k < ESTIMATE_SEEN; k++) {
    number[n++] = &self->began[k];
    for (int part = 0; part < ESTIMATE_PARTS; part++) {
      number[n++] = &self->start[part][k];
      number[n++] = &self->now[part][k];
    }
  }
  for (int k = 0; k < RIGID_VALUES; k++) number[n++] = &self->rigid[k];
}

/* EstimateVectors - room for what EstimateKeep() keeps; the caller ends it with
   EstimateVectorsDestroy(). Collective. */
PetscErrorCode EstimateVectors(Estimate self, Vec errors[ESTIMATE_KEPT]) {
  PetscFunctionBegin;
  for (int k = 0; k < ESTIMATE_KEPT; k++) PetscCall(VecDuplicate(self->leg->U, &errors[k]));
  PetscFunctionReturn(0);
}

/* EstimateVectorsDestroy - self NULL: there are none. */
PetscErrorCode EstimateVectorsDestroy(Estimate self, Vec errors[ESTIMATE_KEPT]) {
  PetscFunctionBegin;
  for (int k = 0; k < ESTIMATE_KEPT && self; k++) PetscCall(VecDestroy(&errors[k]));
  PetscFunctionReturn(0);
}

/*
  EstimateKeep - what it takes to go on with the errors that have been followed. Collective.

  memory  numbers
  errors  of EstimateVectors(): the errors of each part, what steps have added since these were
          stepped last, and the defect measured last
*/
PetscErrorCode EstimateKeep(Estimate self, PetscReal memory[ESTIMATE_MEMORY],
                            Vec errors[ESTIMATE_KEPT]) {
  const PetscInt followed = self->followed, count = self->nodes * followed,
                 whole = self->nodes * self->fields;
  PetscReal *number[ESTIMATE_NUMBERS], *own, *all;
  MPI_Comm comm = self->leg->rod->comm;

  PetscFunctionBegin;
  memory[0] = self->touches ? (PetscReal)self->stride : 0;
  memory[1] = (PetscReal)self->since;
  memory[2] = (PetscReal)self->watch;
  memory[3] = (PetscReal)self->until;
  memory[4] = (PetscReal)self->stride;
  Remembered(self, number);
  for (int k = 0; k < ESTIMATE_NUMBERS; k++) memory[ESTIMATE_COUNTS + k] = *number[k];
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(Spread(self, self->fields, self->e[part], errors[part]));
  PetscCall(PetscMalloc2(count, &own, whole, &all));
  for (PetscInt i = 0; i < count; i++) own[i] = self->own.local[i] + self->own.skipped[i];
  PetscCallMPI(MPI_Reduce(own, all, (PetscMPIInt)count, MPIU_REAL, MPI_SUM, 0, comm));
  PetscCall(Spread(self, followed, all, errors[ESTIMATE_PARTS]));
  PetscCallMPI(MPI_Reduce(self->own.defect, all, (PetscMPIInt)whole, MPIU_REAL, MPI_SUM, 0, comm));
  PetscCall(Spread(self, self->fields, all, errors[ESTIMATE_PARTS + 1]));
  PetscCall(PetscFree2(own, all));
  PetscFunctionReturn(0);
}

/* EstimateTake - goes on with what EstimateKeep() has kept, behind EstimateSet(). Collective. */
PetscErrorCode EstimateTake(Estimate self, const PetscReal memory[ESTIMATE_MEMORY],
                            Vec errors[ESTIMATE_KEPT]) {
  PetscReal *number[ESTIMATE_NUMBERS];

  PetscFunctionBegin;
  self->touches = (PetscBool)(memory[0] != 0);
  if (self->stride != (PetscInt)memory[4]) PetscCall(EstimateRefine(self, (PetscInt)memory[4]));
  self->since = (PetscInt)memory[1];
  self->watch = (PetscInt)memory[2];
  self->until = (PetscInt)memory[3];
  Remembered(self, number);
  for (int k = 0; k < ESTIMATE_NUMBERS; k++) *number[k] = memory[ESTIMATE_COUNTS + k];
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(Pick(self, self->fields, errors[part], self->e[part]));
  PetscCall(Pick(self, self->followed, errors[ESTIMATE_PARTS], self->own.local));
  PetscCall(Pick(self, self->fields, errors[ESTIMATE_PARTS + 1], self->own.defect));
  if (self->whole) EstimateAgree(self, self->whole);
  PetscFunctionReturn(0);
}
