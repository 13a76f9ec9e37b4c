/* The leg of one rod of several, and what is between the ends of a step. */
#include "stepping/leg.h"
#include "base/lagrange.h"
#include "stepping/vbdf.h"

/*
  LegWithin - the state and its rate at a time within the latest step. Collective.

  known  by the stepper's dense output: PETSc's have none of rates
*/
PetscErrorCode LegWithin(Leg *leg, PetscReal t, Vec U, Vec U_t, PetscBool *known) {
  Vec all[2], mine[2] = {U, U_t};
  const PetscScalar *from;
  PetscScalar *to;
  PetscInt n;

  PetscFunctionBegin;
  if (!leg->whole) {
    PetscCall(VBDFInterpolate(leg->ts, t, U, U_t, known));
    PetscFunctionReturn(0);
  }
  for (int i = 0; i < 2; i++) PetscCall(DMGetGlobalVector(leg->whole->rod->da, &all[i]));
  PetscCall(VBDFInterpolate(leg->ts, t, all[0], all[1], known));
  PetscCall(VecGetLocalSize(U, &n));
  for (int i = 0; i < 2 && *known; i++) {
    PetscCall(VecGetArrayRead(all[i], &from));
    PetscCall(VecGetArray(mine[i], &to));
    PetscCall(PetscArraycpy(to, from + leg->from, n));
    PetscCall(VecRestoreArray(mine[i], &to));
    PetscCall(VecRestoreArrayRead(all[i], &from));
  }
  for (int i = 1; i >= 0; i--) PetscCall(DMRestoreGlobalVector(leg->whole->rod->da, &all[i]));
  PetscFunctionReturn(0);
}

/* ---- the leg of one rod of several: what looks at a leg looks at it through this ---- */

/* Its part of a vector of all. */
static PetscErrorCode Follow(const Leg *self, Vec all, Vec part) {
  const PetscScalar *a;

  PetscFunctionBegin;
  PetscCall(VecResetArray(part));
  PetscCall(VecGetArrayRead(all, &a));
  PetscCall(VecPlaceArray(part, a + self->from));
  PetscCall(VecRestoreArrayRead(all, &a));
  PetscFunctionReturn(0);
}

/* LegPart - the leg of rod k, which steps as that of all does; the caller ends it with LegPartEnd()
   before that. Its state is there after LegPartFollow(). */
PetscErrorCode LegPart(Leg *whole, PetscInt k, Leg *leg) {
  const Rod all = whole->rod;
  const PetscInt fields = all->model->fields, n = (all->at[k + 1] - all->at[k]) * fields;

  PetscFunctionBegin;
  *leg = *whole;
  leg->whole = whole;
  leg->rod = all->each[k];
  leg->of = &whole->of[k];
  leg->from = all->at[k] * fields;
  leg->held = leg->tolerance = leg->none = NULL;
  PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, fields, n, NULL, &leg->U));
  PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, fields, n, NULL, &leg->newton.latest.U_t));
  leg->newton.latest.U = leg->U;
  PetscFunctionReturn(0);
}

/* LegPartFollow - its state is that which the leg of all has come to. */
PetscErrorCode LegPartFollow(Leg *leg) {
  const RodState *latest = &leg->whole->newton.latest;

  PetscFunctionBegin;
  PetscCall(Follow(leg, leg->whole->U, leg->U));
  if (latest->U_t) PetscCall(Follow(leg, latest->U_t, leg->newton.latest.U_t));
  leg->newton.latest.t = latest->t;
  leg->crosses = leg->whole->crosses;
  leg->passes = leg->whole->passes;
  leg->passed = leg->whole->passed;
  PetscFunctionReturn(0);
}

PetscErrorCode LegPartEnd(Leg *leg) {
  PetscFunctionBegin;
  if (!leg->whole) PetscFunctionReturn(0);
  PetscCall(VecDestroy(&leg->U));
  PetscCall(VecDestroy(&leg->newton.latest.U_t));
  *leg = (Leg){.rod = NULL};
  PetscFunctionReturn(0);
}

enum { DENSE_POINTS = 7 };

/*
  LegInterpolate - the state and its rate at a time within the latest step, by the stepper's dense
  output. Collective.

  end, h  of the step

  PETSc's steppers know no rate: their dense output is a polynomial of degree 6 at most, so seven
  places over the step have it.
*/
PetscErrorCode LegInterpolate(Leg *leg, PetscReal t, PetscReal end, PetscReal h, Vec U, Vec U_t) {
  PetscReal at[DENSE_POINTS], slope[DENSE_POINTS];
  PetscBool done;

  PetscFunctionBegin;
  PetscCall(VBDFInterpolate(leg->ts, t, U, U_t, &done));
  if (done) PetscFunctionReturn(0);
  for (int k = 0; k < DENSE_POINTS; k++) at[k] = end - h * k / (DENSE_POINTS - 1);
  LagrangeSlopes(DENSE_POINTS, at, t, slope);
  PetscCall(VecZeroEntries(U_t));
  for (int k = 0; k < DENSE_POINTS; k++) {
    PetscCall(TSInterpolate(leg->ts, at[k], U));
    PetscCall(VecAXPY(U_t, slope[k], U));
  }
  PetscCall(TSInterpolate(leg->ts, t, U));
  PetscFunctionReturn(0);
}
