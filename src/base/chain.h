/* An exact solver, on any number of ranks, for matrices that couple neighbouring nodes of a line
   and need no exchange of nodes: all that tendril solves with. Nothing but PETSc's own LU is asked
   for. */
#ifndef TENDRIL_CHAIN_H
#define TENDRIL_CHAIN_H

#include <petscpc.h>

/* An order for nodes of which far ones see each other, and whose last node is held: PETSc's one-way
   dissection, but the last node last. A held end has its conditions in rows where a free one has
   its forces, so that its own block is singular until all before it is eliminated. */
#define ORDERING_HELD "1wd_held"

PetscErrorCode ChainSetType(PC pc, MatOrderingType ordering);

#endif
