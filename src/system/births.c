#include "system/births.h"
#include "base/quaternion.h"
#include "base/vectors.h"
#include "rod/ask.h"
#include "rod/space_cells.h"

/* A vector turned. */
static void TurnBy(const PetscReal d[3][3], PetscReal v[3]) {
  PetscReal turned[3] = {0};

  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) turned[i] += d[k][i] * v[k];
  memcpy(v, turned, sizeof(turned));
}

/* Carries nodes, as a rigid body is, so that the first is at a place and turned so. */
static void CarryTo(const PetscReal x[3], const PetscReal p[4], PetscInt n,
                    PetscReal (*u)[FIELDS]) {
  const PetscReal from[3] = {u[0][X], u[0][X + 1], u[0][X + 2]}, *begun = u[0] + P;
  const PetscReal back[4] = {begun[0], -begun[1], -begun[2], -begun[3]};
  PetscReal turn[4], d[3][3], turned[4];

  QuaternionTimes(p, back, turn);
  for (int k = 0; k < 4; k++) turn[k] /= QuaternionSize(begun);
  Directors(turn, QuaternionSize(turn), d);
  for (PetscInt i = 0; i < n; i++) {
    for (int k = 0; k < 3; k++) u[i][X + k] -= from[k];
    TurnBy((const PetscReal(*)[3])d, u[i] + X);
    TurnBy((const PetscReal(*)[3])d, u[i] + M);
    TurnBy((const PetscReal(*)[3])d, u[i] + N);
    for (int k = 0; k < 3; k++) u[i][X + k] += x[k];
    QuaternionTimes(turn, u[i] + P, turned);
    memcpy(u[i] + P, turned, sizeof(turned));
  }
}

/*
  BirthPlace - a rod that has stayed as it began is where its place on its carrier is now, and
  turned as that is; or as its own clamp has turned.

  U  of all; the part of rod k changes
*/
PetscErrorCode BirthPlace(Rod all, Joints joints, PetscInt k, PetscReal t, Vec U) {
  const Rod rod = all->each[k];
  PetscReal x[3] = {0}, p[4];
  PetscScalar *u;

  PetscFunctionBegin;
  PetscCall(VecGetArray(U, &u));
  if (!JointsCarry(joints, k, all, t, u, x, p)) SpaceClampTurn(&rod->scene->space, t, p);
  CarryTo(x, p, rod->last + 1, (PetscReal(*)[FIELDS])(u + all->at[k] * FIELDS));
  PetscCall(VecRestoreArray(U, &u));
  PetscFunctionReturn(0);
}
