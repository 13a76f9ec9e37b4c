/* What the tests of Jacobians share: a Jacobian is tested by a rate, |F(x + e w) - F(x) - e J w|
   falls fourfold when e is halved. */
#ifndef TENDRIL_BY_RATE_H
#define TENDRIL_BY_RATE_H

#include "harness.h"
#include "rod/rod.h"

/* A new vector of entries size * [-1, 1], the same on any number of ranks. */
static inline Vec RandomVector(Rod rod, int seed, PetscReal size) {
  PetscScalar *a;
  PetscInt low, high;
  Vec v;
  CHECK(DMCreateGlobalVector(rod->da, &v));
  CHECK(VecGetOwnershipRange(v, &low, &high));
  CHECK(VecGetArray(v, &a));
  for (PetscInt i = low; i < high; i++) a[i - low] = size * Scatter(seed, i);
  CHECK(VecRestoreArray(v, &a));
  return v;
}

/* V_t = U_t + e shift w, the shift of a field greater by factor_rate, of each of its mirrors. */
static inline void Shifted(Rod rod, Vec U_t, PetscReal shift, Vec w, PetscReal e, Vec V_t) {
  PetscInt fields = rod->model->fields, n;
  const PetscScalar *d;
  PetscScalar *v;
  CHECK(VecWAXPY(V_t, e * shift, w, U_t));
  CHECK(VecGetLocalSize(w, &n));
  CHECK(VecGetArrayRead(w, &d));
  CHECK(VecGetArray(V_t, &v));
  for (PetscInt i = 0; i < n; i++)
    for (int mirror = 0; mirror < MIRRORS; mirror++)
      if (rod->model->group[i % fields] & 1 << mirror) v[i] += e * rod->factor_rate[mirror] * d[i];
  CHECK(VecRestoreArray(V_t, &v));
  CHECK(VecRestoreArrayRead(w, &d));
}

/* The initial shape at t shaken, with rates of order 1. */
static inline void ShakenState(Rod rod, PetscReal t, PetscReal shake, Vec *U, Vec *U_t) {
  Node *nodes;
  Vec noise = RandomVector(rod, 1, shake);
  CHECK(PetscMalloc1(rod->end - rod->first, &nodes));
  CHECK(RodInitialNodes(rod, t, nodes));
  CHECK(VecDuplicate(noise, U));
  CHECK(rod->model->set(rod, t, nodes, *U));
  CHECK(VecAXPY(*U, 1, noise));
  CHECK(PetscFree(nodes));
  CHECK(VecDestroy(&noise));
  *U_t = RandomVector(rod, 2, 1);
}

/* F(U + e w, U_t + e shift w) - F(U, U_t) - e J w, its largest entry for each field. */
static inline void Remainder(Rod rod, PetscReal t, Vec U, Vec U_t, PetscReal shift, Mat J, Vec w,
                             PetscReal e, PetscReal size[MAX_FIELDS]) {
  Vec V, V_t, F, G;
  CHECK(VecDuplicate(U, &V));
  CHECK(VecDuplicate(U, &V_t));
  CHECK(VecDuplicate(U, &F));
  CHECK(VecDuplicate(U, &G));
  CHECK(VecWAXPY(V, e, w, U));
  Shifted(rod, U_t, shift, w, e, V_t);
  CHECK(RodResidual(NULL, t, V, V_t, G, rod));
  CHECK(RodResidual(NULL, t, U, U_t, F, rod));
  CHECK(VecAXPY(G, -1, F));
  CHECK(MatMult(J, w, F));
  CHECK(VecAXPY(G, -e, F));
  CHECK(RodFieldSizes(rod, G, size));
  CHECK(VecDestroy(&V));
  CHECK(VecDestroy(&V_t));
  CHECK(VecDestroy(&F));
  CHECK(VecDestroy(&G));
}

/* J is the derivative along w, at steps e and e / 2, to within spread of 4; equations that are
   linear leave round-off. */
static inline void ExpectRate(Rod rod, PetscReal t, Vec U, Vec U_t, PetscReal shift, Mat J, Vec w,
                              PetscReal e, PetscReal spread, const char *title) {
  PetscReal coarse[MAX_FIELDS], fine[MAX_FIELDS], entry;
  CHECK(MatNorm(J, NORM_INFINITY, &entry));
  Remainder(rod, t, U, U_t, shift, J, w, e, coarse);
  Remainder(rod, t, U, U_t, shift, J, w, e / 2, fine);
  for (PetscInt f = 0; f < rod->model->fields; f++) {
    PetscReal ratio = coarse[f] / fine[f];
    if (fine[f] < 1e-15 * entry)
      EXPECT(coarse[f] < 4e-15 * entry, "%s, equation of %s: %g", title, rod->model->field[f],
             coarse[f]);
    else
      EXPECT(PetscAbsReal(ratio - 4) < spread, "%s, shift %g, equation of %s: %g to %g, ratio %g",
             title, shift, rod->model->field[f], coarse[f], fine[f], ratio);
  }
}

#endif
