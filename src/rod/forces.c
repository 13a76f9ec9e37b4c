/* What the world does to a rod under exact Coulomb friction, where its velocities do not say it. */
#include "rod/rod.h"

/*
  RodKeepForces - for a model's hold(): keeps what this rank's part of the rod bore in the state
  that is about to be held, so in the equations as they were solved. (Behind that the shifts that
  hold it are others, and of what sticks nothing else tells the force.) A state is forgotten when
  the second of a later time comes; one that the stepper did not take, when it is tried again.
*/
void RodKeepForces(Rod rod, PetscReal t, const RodForces *sum) {
  if (rod->held[0].t < t) rod->held[1] = rod->held[0];
  rod->held[0].t = t;
  rod->held[0].sum = *sum;
}

/*
  RodForcesAt - what the world does to the whole rod at t, on every rank: within the latest step
  linear in time, for there the velocities of what sticks are noise. Collective.

  known  false: friction is not exact, or there was no step yet
*/
PetscErrorCode RodForcesAt(Rod rod, PetscReal t, RodForces *sum, PetscBool *known) {
  const PetscReal h = rod->held[0].t - rod->held[1].t;
  PetscReal part = 1; /* of the latest */

  PetscFunctionBegin;
  *known = (PetscBool)(LoadSticks(&rod->scene->load) && rod->held[0].t > PETSC_MIN_REAL);
  if (!*known) PetscFunctionReturn(0);
  if (rod->held[1].t > PETSC_MIN_REAL) part = PetscMax(0, PetscMin(1, (t - rod->held[1].t) / h));
  for (int k = 0; k < ROD_FORCES; k++) {
    const PetscReal now = ((PetscReal *)&rod->held[0].sum)[k];
    ((PetscReal *)sum)[k] = now;
    if (part < 1)
      ((PetscReal *)sum)[k] = part * now + (1 - part) * ((PetscReal *)&rod->held[1].sum)[k];
  }
  if (!rod->alone)
    PetscCallMPI(
        MPI_Allreduce(MPI_IN_PLACE, sum, ROD_FORCES, MPIU_REAL, MPI_SUM, rod->scene->comm));
  PetscFunctionReturn(0);
}
