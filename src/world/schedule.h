/* What turns over time, from a table: its rate, or its angle. Between the rows these follow
   monotone cubic curves. A rate stays what it is before the first row and behind the last; by an
   angle it rests there. */
#ifndef TENDRIL_SCHEDULE_H
#define TENDRIL_SCHEDULE_H

#include "base/options.h"

typedef struct _Schedule *Schedule;

PetscErrorCode ScheduleRead(const char *option, const char *file, Schedule *path);
PetscErrorCode ScheduleDestroy(Schedule *path);
PetscReal ScheduleAngle(Schedule path, PetscReal t);
PetscReal ScheduleRate(Schedule path, PetscReal t);
PetscReal ScheduleFastest(Schedule path);
PetscBool ScheduleJerks(Schedule path, PetscReal t0, PetscReal t1);

#endif
