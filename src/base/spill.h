/* Memory for what grows all the time and is hardly looked at again: where it is large it is that of
   a file without a name, which may leave memory for the disk. */
#ifndef TENDRIL_SPILL_H
#define TENDRIL_SPILL_H

#include <petscsys.h>

typedef struct {
  void *at;
  size_t bytes;
  PetscBool mapped; /* of a file */
} Spill;

PetscErrorCode SpillNew(size_t bytes, Spill *spill);
PetscErrorCode SpillGrow(size_t used, size_t bytes, Spill *spill);
void SpillRest(const Spill *spill);
void SpillFree(Spill *spill);

#endif
