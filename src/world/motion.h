/* How a surface in space moves, from where it is given at t = 0: it turns about an axis through a
   point, and is carried along, the axis with it. Either goes on evenly, or as given in time. */
#ifndef TENDRIL_MOTION_H
#define TENDRIL_MOTION_H

#include "base/lead.h"
#include "base/schedule.h"

typedef struct {
  PetscBool any;
  PetscReal velocity[3], rate, at[3], axis[3];
  PetscBool led;     /* it is carried along as given in time: */
  Schedule place[3]; /* along x1, x2, x3; NULL: not at all */
  Schedule turn;     /* NULL: at that rate */
  Lead lead[3];      /* in the place of the others, from a time in the run on; not on: not at all */
  PetscInt rows;     /* where it was, is and will be by that: t, x1, x2, x3, for who draws it */
  PetscReal (*row)[4];
} SurfaceMotion;

PetscBool MotionWord(const char *word);
PetscErrorCode MotionTake(const char *file, int line, PetscInt *n, char *word[],
                          SurfaceMotion *motion);
PetscErrorCode MotionDestroy(SurfaceMotion *motion);
PetscErrorCode MotionLeadTo(SurfaceMotion *motion, PetscReal t, PetscReal by, const PetscReal x[3]);
PetscErrorCode MotionText(const SurfaceMotion *motion, char **text);
void MotionLed(const SurfaceMotion *motion, PetscReal t, PetscReal shift[3]);
void MotionVelocity(const SurfaceMotion *motion, PetscReal t, PetscReal velocity[3]);
PetscReal MotionRate(const SurfaceMotion *motion, PetscReal t);
PetscBool MotionJerks(const SurfaceMotion *motion, PetscReal t0, PetscReal t1);
PetscReal MotionNextTurn(const SurfaceMotion *motion, PetscReal t);

/* MotionShift - how far it has been carried along since t = 0. */
static inline void MotionShift(const SurfaceMotion *motion, PetscReal t, PetscReal shift[3]) {
  if (motion->led)
    MotionLed(motion, t, shift);
  else
    for (int d = 0; d < 3; d++) shift[d] = motion->velocity[d] * t;
}

/* MotionAngle - by how much it turns from one time to another. */
static inline PetscReal MotionAngle(const SurfaceMotion *motion, PetscReal from, PetscReal to) {
  if (!motion->turn) return motion->rate * (to - from);
  return ScheduleValue(motion->turn, to) - ScheduleValue(motion->turn, from);
}

#endif
