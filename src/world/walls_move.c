#include "world/walls.h"
#include "base/extremes.h"

/* WallsDisplacement - one along the axes of the laboratory, in the clamp's frame. */
Vector2 WallsDisplacement(const Walls *walls, const PetscReal lab[3]) {
  const Vector2 a = From2(lab);

  return (Vector2){Dot2(walls->turn, a), Cross2(walls->turn, a)};
}

/* WallShift - how far a wall has been carried along since t = 0, in the clamp's frame. */
Vector2 WallShift(const Walls *walls, PetscInt wall, PetscReal t) {
  PetscReal lab[3];

  MotionShift(&walls->wall[wall].motion, t, lab);
  return WallsDisplacement(walls, lab);
}

/* WallVelocity - how fast a wall is carried along, at the time at which walls are looked at. */
Vector2 WallVelocity(const Walls *walls, PetscInt wall) {
  PetscReal lab[3];

  MotionVelocity(&walls->wall[wall].motion, walls->time, lab);
  return WallsDisplacement(walls, lab);
}

/* WallsCarried - how far a wall has been carried along since another time. */
Vector2 WallsCarried(const Walls *walls, PetscInt wall, PetscReal from) {
  return Minus2(WallShift(walls, wall, walls->time), WallShift(walls, wall, from));
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
Vector2 WallsPostAt(const Walls *walls, PetscInt post) {
  const WallPost *self = &walls->post[post];

  return post < walls->resting ? self->at
                               : Plus2(WallShift(walls, self->wall, walls->time), self->at);
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
