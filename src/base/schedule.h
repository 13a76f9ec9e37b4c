/* What moves or turns over time, by rows: its rate, or where it is. Between the rows these follow
   monotone cubic curves. A rate stays what it is before the first row and behind the last; what is
   led by where it is rests there. */
#ifndef TENDRIL_SCHEDULE_H
#define TENDRIL_SCHEDULE_H

#include "base/bends.h"
#include "base/options.h"

typedef struct _Schedule *Schedule;

/* How it is told by a table: "a clamp turns", the columns, and what they are measured in. */
typedef struct {
  const char *what, *rate, *place;
  Dimension rate_in, place_in;
} ScheduleWords;

PetscErrorCode ScheduleRead(const char *option, const char *file, const char *who, Schedule *path);
PetscErrorCode ScheduleReadAs(const char *option, const char *file, const ScheduleWords *words,
                              Schedule *path);
PetscErrorCode ScheduleReadPlace(const char *option, const char *file, Schedule place[3]);
PetscErrorCode ScheduleCreate(PetscInt n, Schedule *path);
void ScheduleSetRow(Schedule path, PetscInt row, PetscReal t, PetscReal value);
PetscErrorCode ScheduleSetUp(const char *what, PetscBool rate, Schedule path);
PetscErrorCode ScheduleDestroy(Schedule *path);
PetscReal ScheduleStart(Schedule path);
PetscReal ScheduleValue(Schedule path, PetscReal t);
PetscReal ScheduleRate(Schedule path, PetscReal t);
PetscReal ScheduleFastest(Schedule path);
PetscBool ScheduleJerks(Schedule path, PetscReal t0, PetscReal t1);
PetscReal ScheduleNextTurn(Schedule path, PetscReal t);
PetscErrorCode ScheduleBends(Schedule path, PetscReal tolerance, Bends *bends);
PetscInt ScheduleRows(Schedule path);
PetscBool ScheduleIsRate(Schedule path);
void ScheduleGetRow(Schedule path, PetscInt row, PetscReal *t, PetscReal *value);

#endif
