/* -task sweep: a table of runs, handed out to the ranks. */
#ifndef TENDRIL_SWEEP_H
#define TENDRIL_SWEEP_H

#include "base/options.h"

extern const OptionGroup sweep_options;

PetscErrorCode SweepRun(void);

#endif
