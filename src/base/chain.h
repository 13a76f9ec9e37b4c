/* An exact solver, on any number of ranks, for matrices that couple neighbouring nodes of a line
   and need no exchange of nodes: all that tendril solves with. On one rank it is PETSc's LU. On
   several nothing of PETSc's does as much. PCREDUNDANT factors all of it on every rank: 1.2 times
   the time of a rank and twice the memory (eigenvalues of 100 000 vertices on 3 ranks: 521 MB, here
   264), where ranks are asked for because one has not the memory; 1.1 to 1.5 times the time of a
   mixed rod of 2000 cells. MUMPS takes 4 times, and is not everywhere. */
#ifndef TENDRIL_CHAIN_H
#define TENDRIL_CHAIN_H

#include <petscksp.h>

/* An order for nodes of which far ones see each other, and whose last node is held: PETSc's least
   degree first, but the last node last. (Of a rod that is folded upon itself a node and those that
   it touches then follow each other, and its factors keep as little as a line of such groups would;
   one-way dissection leaves three times as much.) A held end has its conditions in rows where a
   free one has its forces, so that its own block is singular until all before it is eliminated. */
#define ORDERING_HELD "qmd_held"

/* The order for nodes of which far ones see each other. */
static inline MatOrderingType ChainFolded(PetscBool held) {
  return held ? ORDERING_HELD : MATORDERINGQMD;
}

PetscErrorCode ChainSetType(PC pc, MatOrderingType ordering);
PetscErrorCode ChainCreateSolver(MPI_Comm comm, MatOrderingType ordering, KSP *ksp);

#endif
