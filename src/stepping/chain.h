/* An exact parallel solver for matrices that couple neighbouring nodes of a line. */
#ifndef TENDRIL_CHAIN_H
#define TENDRIL_CHAIN_H

#include <petscpc.h>

PetscErrorCode ChainSetType(PC pc);

#endif
