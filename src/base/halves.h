/* Block elimination along a line of nodes, on one rank, where cell i has so many equations that are
   rows of node i + 1 (the top of it) and so many that are rows of node i (its own). Sizes are known
   when compiled: see HalvesCan(). */
#ifndef TENDRIL_HALVES_H
#define TENDRIL_HALVES_H

#include <petscsys.h>

enum { HALVES_MOST = 15 }; /* unknowns of a node */

typedef struct _Halves *Halves;

/* What is known of a node and the cell behind it, rows one behind the other: (V, W) of what is
   before it; the factors of S, of which row[k] is the pivot k; the cell's equations by its nodes.
 */
typedef struct {
  const PetscReal *T, *S, *cell[2];
  const int *row;
} HalvesLink;

PetscBool HalvesCan(const PetscInt halves[2]);
PetscErrorCode HalvesCreate(PetscInt nodes, const PetscInt halves[2], Halves *line);
PetscErrorCode HalvesDestroy(Halves *line);
void HalvesBegin(Halves line);
PetscReal *HalvesFirst(Halves line);
void HalvesBlocks(Halves line, PetscReal **a, PetscReal **b);
void HalvesCell(Halves line);
void HalvesKeep(Halves line);
void HalvesEnd(Halves line, const PetscReal own[]);
PetscInt HalvesCells(Halves line);
HalvesLink HalvesAt(Halves line, PetscInt i);
PetscBool HalvesRegular(Halves line);
void HalvesSolve(Halves line, const PetscReal b[], PetscReal x[]);

#endif
