#include "world/walls.h"
#include "base/extremes.h"

/* WallsDisplacement - one along the axes of the laboratory, in the clamp's frame. */
void WallsDisplacement(const Walls *walls, const PetscReal lab[3], PetscReal x[2]) {
  const PetscReal c = walls->turn[0], s = walls->turn[1];

  x[0] = c * lab[0] + s * lab[1];
  x[1] = -s * lab[0] + c * lab[1];
}

/* WallShift - how far a wall has been carried along since t = 0, in the clamp's frame. */
void WallShift(const Walls *walls, PetscInt wall, PetscReal t, PetscReal shift[2]) {
  PetscReal lab[3];

  MotionShift(&walls->wall[wall].motion, t, lab);
  WallsDisplacement(walls, lab, shift);
}

/* WallVelocity - how fast a wall is carried along, at the time at which walls are looked at. */
void WallVelocity(const Walls *walls, PetscInt wall, PetscReal velocity[2]) {
  PetscReal lab[3];

  MotionVelocity(&walls->wall[wall].motion, walls->time, lab);
  WallsDisplacement(walls, lab, velocity);
}

/* WallsCarried - how far a wall has been carried along since another time. */
void WallsCarried(const Walls *walls, PetscInt wall, PetscReal from, PetscReal by[2]) {
  PetscReal then[2];

  WallShift(walls, wall, walls->time, by);
  WallShift(walls, wall, from, then);
  for (int d = 0; d < 2; d++) by[d] -= then[d];
}

/*
  WallsLeadTo - from t on a wall is led to a displacement since t = 0, at which it comes to rest:
  see MotionLeadTo(). From then on it is one of those that move.
*/
PetscErrorCode WallsLeadTo(Walls *walls, PetscInt wall, PetscReal t, PetscReal by,
                           const PetscReal x[3]) {
  PetscFunctionBegin;
  PetscCall(MotionLeadTo(&walls->wall[wall].motion, t, by, x));
  PetscCall(WallsDropIndex(walls));
  PetscCall(WallsIndex(walls));
  PetscFunctionReturn(0);
}

/* WallsPostAt - where a post is. */
void WallsPostAt(const Walls *walls, PetscInt post, PetscReal at[2]) {
  const WallPost *self = &walls->post[post];

  for (int d = 0; d < 2; d++) at[d] = 0;
  if (post >= walls->resting) WallShift(walls, self->wall, walls->time, at);
  for (int d = 0; d < 2; d++) at[d] += self->at[d];
}

/* WallsPostsNear - tells of posts nearer than `reach` to a place, and of all that move; see
   BlocksNear(). */
void WallsPostsNear(const Walls *walls, const Block *place, PetscReal reach, BlocksMeet meet,
                    void *ctx) {
  BlocksNear(walls->near_posts, place, reach, meet, ctx);
  for (PetscInt k = walls->resting; k < walls->posts; k++) (void)meet(k, reach, ctx);
}

/* WallsJerk - does any of them set out or stop at once between two times? */
PetscBool WallsJerk(const Walls *walls, PetscReal t0, PetscReal t1) {
  for (PetscInt w = 0; w < walls->n && walls->move; w++)
    if (MotionJerks(&walls->wall[w].motion, t0, t1)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* WallsNextTurn - the first time behind t at which one that moves as given in time sets out, stops
   or turns back; PETSC_MAX_REAL if there is none. */
PetscReal WallsNextTurn(const Walls *walls, PetscReal t) {
  PetscReal next = PETSC_MAX_REAL;

  for (PetscInt w = 0; w < walls->n && walls->move; w++)
    next = SmallerOf(next, MotionNextTurn(&walls->wall[w].motion, t));
  return next;
}
