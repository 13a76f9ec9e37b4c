/* How a wall or surface moves, from where it is given at t = 0: it turns about an axis through a
   point, and is carried along, the axis with it. Either goes on evenly, or as given in time. All in
   the laboratory's frame. */
#ifndef TENDRIL_MOTION_H
#define TENDRIL_MOTION_H

#include "base/lead.h"
#include "base/schedule.h"

/* Rows of a time and of up to three numbers. */
typedef struct {
  PetscInt n;
  PetscReal (*row)[4];
} MotionRows;

typedef struct {
  PetscBool any;
  PetscReal velocity[3], rate, at[3], axis[3];
  PetscBool led;     /* it is carried along as given in time: */
  Schedule place[3]; /* along x1, x2, x3; NULL: not at all */
  Schedule turn;     /* NULL: at that rate */
  Lead lead[3],
      lead_turn; /* in the place of those, from a time in the run on; not on: not at all */
  MotionRows places, angles; /* where it was, is and will be by these, for who draws it */
} SurfaceMotion;

PetscBool MotionWord(const char *word);
PetscErrorCode MotionTake(const char *file, int line, PetscInt *n, char *word[],
                          SurfaceMotion *motion);
PetscErrorCode MotionDestroy(SurfaceMotion *motion);
PetscErrorCode MotionLeadTo(SurfaceMotion *motion, PetscReal t, PetscReal by, const PetscReal x[3]);
PetscErrorCode MotionTurnTo(SurfaceMotion *motion, PetscReal t, PetscReal by, PetscReal angle,
                            const PetscReal middle[3]);
PetscErrorCode MotionText(const SurfaceMotion *motion, char **text);
void MotionLed(const SurfaceMotion *motion, PetscReal t, PetscReal shift[3]);
void MotionVelocity(const SurfaceMotion *motion, PetscReal t, PetscReal velocity[3]);
PetscReal MotionRate(const SurfaceMotion *motion, PetscReal t);
void MotionVelocityAt(const SurfaceMotion *motion, PetscReal t, const PetscReal x[3],
                      PetscReal velocity[3], PetscReal spin[3]);
void MotionCarry(const SurfaceMotion *motion, PetscReal from, PetscReal to, const PetscReal x[3],
                 PetscReal y[3]);
PetscReal MotionBow(const SurfaceMotion *motion, PetscReal from, PetscReal to,
                    const PetscReal x[3]);
PetscBool MotionJerks(const SurfaceMotion *motion, PetscReal t0, PetscReal t1);
PetscReal MotionNextTurn(const SurfaceMotion *motion, PetscReal t);

/* MotionShift - how far it has been carried along since t = 0. */
static inline void MotionShift(const SurfaceMotion *motion, PetscReal t, PetscReal shift[3]) {
  if (motion->led)
    MotionLed(motion, t, shift);
  else
    for (int d = 0; d < 3; d++) shift[d] = motion->velocity[d] * t;
}

/* MotionTurns - does it turn, at any time? */
static inline PetscBool MotionTurns(const SurfaceMotion *motion) {
  return (PetscBool)(motion->turn || motion->rate != 0 || motion->lead_turn.on);
}

/* MotionAngle - by how much it turns from one time to another. */
static inline PetscReal MotionAngle(const SurfaceMotion *motion, PetscReal from, PetscReal to) {
  if (motion->lead_turn.on)
    return LeadValue(&motion->lead_turn, to) - LeadValue(&motion->lead_turn, from);
  if (!motion->turn) return motion->rate * (to - from);
  return ScheduleValue(motion->turn, to) - ScheduleValue(motion->turn, from);
}

/* MotionTurned - by how much it has turned since t = 0. */
static inline PetscReal MotionTurned(const SurfaceMotion *motion, PetscReal t) {
  return motion->lead_turn.on ? LeadValue(&motion->lead_turn, t) : MotionAngle(motion, 0, t);
}

#endif
