/* An exact solver, on any number of ranks, for matrices that couple neighbouring nodes of a line
   and need no exchange of nodes: all that tendril solves with. Nothing but PETSc's own LU is asked
   for. */
#ifndef TENDRIL_CHAIN_H
#define TENDRIL_CHAIN_H

#include <petscpc.h>

PetscErrorCode ChainSetType(PC pc, MatOrderingType ordering);

#endif
