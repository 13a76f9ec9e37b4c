/* What the tests of Jacobians share: a Jacobian is tested by a rate, |F(x + e w) - F(x) - e J w|
   falls fourfold when e is halved. */
#ifndef TENDRIL_BY_RATE_H
#define TENDRIL_BY_RATE_H

#include "harness.h"
#include "rod/learned.h"
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

/* A state to take equations and derivatives in, with a shift for all fields. */
static inline RodState StateOf(PetscReal t, Vec U, Vec U_t, PetscReal shift) {
  RodState at = {.t = t, .U = U, .U_t = U_t};
  for (int f = 0; f < MAX_FIELDS; f++) at.shift[f] = shift;
  return at;
}

/* ... and more of it for the fields of each mirror. */
static inline void AddFactorRates(Rod rod, const PetscReal rate[MIRRORS], RodState *at) {
  for (PetscInt f = 0; f < rod->model->fields; f++)
    for (int mirror = 0; mirror < MIRRORS; mirror++)
      if (rod->model->group[f] & 1 << mirror) at->shift[f] += rate[mirror];
}

/* V_t = U_t + e shift w, of each field its own. */
static inline void Shifted(Rod rod, const RodState *at, Vec w, PetscReal e, Vec V_t) {
  PetscInt fields = rod->model->fields, n;
  const PetscScalar *d;
  PetscScalar *v;
  CHECK(VecCopy(at->U_t, V_t));
  CHECK(VecGetLocalSize(w, &n));
  CHECK(VecGetArrayRead(w, &d));
  CHECK(VecGetArray(V_t, &v));
  for (PetscInt i = 0; i < n; i++) v[i] += e * at->shift[i % fields] * d[i];
  CHECK(VecRestoreArray(V_t, &v));
  CHECK(VecRestoreArrayRead(w, &d));
}

/* The initial shape at t shaken, with rates of order 1. What has learned has no corner at a front:
 * see learned.h. */
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
  if (rod->learned) rod->learned->smooth = PETSC_TRUE;
}

/* F(U + e w, U_t + e shift w) - F(U, U_t) - e J w, its largest entry for each field. */
static inline void Remainder(Rod rod, const RodState *at, Mat J, Vec w, PetscReal e,
                             PetscReal size[MAX_FIELDS]) {
  RodState near = {.t = at->t}, here = {.t = at->t, .U = at->U, .U_t = at->U_t};
  Vec V, V_t, F, G;
  CHECK(VecDuplicate(at->U, &V));
  CHECK(VecDuplicate(at->U, &V_t));
  CHECK(VecDuplicate(at->U, &F));
  CHECK(VecDuplicate(at->U, &G));
  CHECK(VecWAXPY(V, e, w, at->U));
  Shifted(rod, at, w, e, V_t);
  near.U = V;
  near.U_t = V_t;
  CHECK(rod->model->residual(rod, &near, G));
  CHECK(rod->model->residual(rod, &here, F));
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
static inline void ExpectRate(Rod rod, const RodState *at, Mat J, Vec w, PetscReal e,
                              PetscReal spread, const char *title) {
  PetscReal coarse[MAX_FIELDS], fine[MAX_FIELDS], entry;
  CHECK(MatNorm(J, NORM_INFINITY, &entry));
  Remainder(rod, at, J, w, e, coarse);
  Remainder(rod, at, J, w, e / 2, fine);
  for (PetscInt f = 0; f < rod->model->fields; f++) {
    PetscReal ratio = coarse[f] / fine[f];
    if (fine[f] < 1e-15 * entry)
      EXPECT(coarse[f] < 4e-15 * entry, "%s, equation of %s: %g", title, rod->model->field[f],
             coarse[f]);
    else
      EXPECT(PetscAbsReal(ratio - 4) < spread, "%s, shift %g, equation of %s: %g to %g, ratio %g",
             title, at->shift[f], rod->model->field[f], coarse[f], fine[f], ratio);
  }
}

#endif
