/* The balance of energy of a run, which is summed from one time to the next. */
#ifndef TENDRIL_BALANCE_H
#define TENDRIL_BALANCE_H

#include "record/observe.h"

/* The latest times with W - dissipation, dissipation and energy, newest last. */
typedef struct {
  PetscInt n;
  PetscReal time[BALANCE_POINTS], net[BALANCE_POINTS], loss[BALANCE_POINTS];
  PetscReal energy[BALANCE_POINTS];
  PetscReal first_energy, net_work, lost_work;
  PetscBool closed, broken; /* over the step to be measured next: ObserverClose() */
  PetscReal left;           /* the energy at its begin, if it is closed */
} Balance;

/* What powers do in the interval that has come last. */
typedef struct {
  PetscReal net, loss, doubt; /* by how much a time less says another net work */
  PetscBool unsure; /* they are those of powers that change too fast for their latest times */
} Work;

PetscReal BalancePower(const Observation *seen);
void BalanceAdd(Balance *balance, const Observation *seen, PetscBool known);
void BalanceFromTimes(const Balance *balance, const Scene scene, const Observation *seen,
                      Work *work);
void BalanceClose(Balance *balance, const Scene scene, const Work *work, Observation *seen);
void BalanceGet(Balance *balance, PetscReal state[BALANCE_STATE]);
void BalanceSet(Balance *balance, const PetscReal state[BALANCE_STATE]);

#endif
