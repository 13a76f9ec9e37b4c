/* What the world does to a rod in the states that its stepper has solved for, where velocities do
   not say it: what Newton's method has left of the balance, and what exact Coulomb friction holds.
 */
#include "rod/rod.h"
#include <string.h>

/* The first field of the force n. */
static PetscInt FirstForce(const RodModel *model) {
  PetscInt f = 0;

  while (f < model->fields && strcmp(model->field[f], "n1")) f++;
  return f;
}

/*
  RodKeepLeft - for a state at t that is taken for solved: keeps what this rank's cells leave of the
  balance of forces,

    sum of n_b - n_a - int g F ds,

  F the residual there. Velocities settle before forces do: so friction that is computed from them
  is still off by that from the friction of Newton's last step, with which n is in balance. Of the
  times asked for later two are kept; one that was tried, and not taken, is written over.
*/
PetscErrorCode RodKeepLeft(Rod rod, PetscReal t, Vec F) {
  const PetscInt fields = rod->model->fields, n = FirstForce(rod->model),
                 forces = rod->model->space ? 3 : PetscMin(2, fields - n),
                 last = PetscMin(rod->end, rod->last);
  RodForces sum = {.moved = 0};
  const PetscScalar *r;

  PetscFunctionBegin;
  if (n == fields) PetscFunctionReturn(0);
  PetscCall(VecGetArrayRead(F, &r));
  for (PetscInt i = 0; i < last - rod->first; i++)
    for (PetscInt d = 0; d < forces; d++) sum.left[d] += r[i * fields + n + d];
  PetscCall(VecRestoreArrayRead(F, &r));
  if (rod->kept[0].t < t) rod->kept[1] = rod->kept[0];
  rod->kept[0].t = t;
  rod->kept[0].sum = sum;
  rod->kept[0].whole = PETSC_FALSE;
  PetscFunctionReturn(0);
}

/* RodKeepBorne - keeps beside it what this rank's part bears, where an observer would not find the
   same: of exact Coulomb friction, before the shifts are moved that hold what sticks, for behind
   that nothing tells the force of the equations as they were solved; and of other quadratures than
   his. */
void RodKeepBorne(Rod rod, const RodForces *sum) {
  RodForces *kept = &rod->kept[0].sum;
  PetscReal left[3];

  for (int d = 0; d < 3; d++) left[d] = kept->left[d];
  *kept = *sum;
  for (int d = 0; d < 3; d++) kept->left[d] = left[d];
  rod->kept[0].whole = PETSC_TRUE;
}

/* RodForcesAt - what was kept of this rank's part at t, all 0 if nothing was: within the latest
   step linear in time, for there the velocities of what sticks are noise. Returns whether it is
   more than what is left. */
PetscBool RodForcesAt(Rod rod, PetscReal t, RodForces *sum) {
  const PetscReal before = rod->kept[1].t, now = rod->kept[0].t;
  const PetscReal *from = (const PetscReal *)&rod->kept[1].sum,
                  *to = (const PetscReal *)&rod->kept[0].sum;
  PetscReal part = 1;

  if (before > PETSC_MIN_REAL) part = PetscMax(0, PetscMin(1, (t - before) / (now - before)));
  for (int k = 0; k < ROD_FORCES; k++)
    ((PetscReal *)sum)[k] = part < 1 ? part * to[k] + (1 - part) * from[k] : to[k];
  return rod->kept[0].whole;
}
