#include "world/walls.h"
#include "base/extremes.h"
#include "base/vectors.h"

/* A place or displacement along the axes of the laboratory, in the clamp's frame. */
static Vector2 InFrame(const Walls *walls, const PetscReal lab[3]) {
  return TurnedBack2(walls->turn, From2(lab));
}

/* Where the point about which a wall turns is, as given. */
static Vector2 Pivot(const Walls *walls, PetscInt wall) {
  return InFrame(walls, walls->wall[wall].motion.at);
}

/* The angle by which a wall has turned, to the left. */
static PetscReal Turned(const Walls *walls, PetscInt wall, PetscReal t) {
  const SurfaceMotion *motion = &walls->wall[wall].motion;

  return MotionTurns(motion) ? motion->axis[2] * MotionTurned(motion, t) : 0;
}

static WallPose PoseOf(const Walls *walls, PetscInt wall, PetscReal angle, Vector2 shift) {
  WallPose pose = {{1, 0}, shift};
  Vector2 pivot;

  if (angle == 0) return pose;
  pose.turn = Direction2(angle);
  pivot = Pivot(walls, wall);
  pose.by = Plus2(shift, Minus2(pivot, Turned2(pose.turn, pivot)));
  return pose;
}

/* WallPoseAt - where a wall is at a time. */
WallPose WallPoseAt(const Walls *walls, PetscInt wall, PetscReal t) {
  PetscReal lab[3];

  MotionShift(&walls->wall[wall].motion, t, lab);
  return PoseOf(walls, wall, Turned(walls, wall, t), InFrame(walls, lab));
}

/* WallPoseShifted - ... at the time at which walls are looked at, were it displaced by so much. */
WallPose WallPoseShifted(const Walls *walls, PetscInt wall, const PetscReal lab[3]) {
  return PoseOf(walls, wall, Turned(walls, wall, walls->time), InFrame(walls, lab));
}

/* WallVelocity - how fast that of a wall moves which is at x at the time at which walls are looked
   at, and its rate of turning. */
Vector2 WallVelocity(const Walls *walls, PetscInt wall, Vector2 x, PetscReal *spin) {
  const SurfaceMotion *motion = &walls->wall[wall].motion;
  PetscReal lab[3], shift[3];
  Vector2 v, axis;

  MotionVelocity(motion, walls->time, lab);
  v = InFrame(walls, lab);
  *spin = MotionTurns(motion) ? motion->axis[2] * MotionRate(motion, walls->time) : 0;
  if (*spin == 0) return v;
  MotionShift(motion, walls->time, shift);
  axis = Plus2(Pivot(walls, wall), InFrame(walls, shift));
  return Along2(v, *spin, Left2(Minus2(x, axis)));
}

/* WallCarry - where that of a wall is which was at x at another time. */
Vector2 WallCarry(const Walls *walls, PetscInt wall, PetscReal from, Vector2 x) {
  const WallPose then = WallPoseAt(walls, wall, from), now = WallPoseAt(walls, wall, walls->time);

  return WallPlaced(&now, WallGiven(&then, x));
}

/* WallBow - how far from straight its way has been since another time: see MotionBow(). */
PetscReal WallBow(const Walls *walls, PetscInt wall, PetscReal from, Vector2 x) {
  PetscReal lab[3] = {0};

  Put2(Turned2(walls->turn, x), lab);
  return MotionBow(&walls->wall[wall].motion, from, walls->time, lab);
}

/* From now on a wall is one of those that move. */
static PetscErrorCode IndexAnew(Walls *walls) {
  PetscFunctionBegin;
  PetscCall(WallsDropIndex(walls));
  PetscCall(WallsIndex(walls));
  PetscFunctionReturn(0);
}

/* WallsLeadTo - from t on a wall is led to a displacement since t = 0, at which it comes to rest:
   see MotionLeadTo(). */
PetscErrorCode WallsLeadTo(Walls *walls, PetscInt wall, PetscReal t, PetscReal by,
                           const PetscReal x[3]) {
  PetscFunctionBegin;
  PetscCall(MotionLeadTo(&walls->wall[wall].motion, t, by, x));
  PetscCall(IndexAnew(walls));
  PetscFunctionReturn(0);
}

/* About which a wall turns whose line does not say it: a plane's point, a circle's centre, the mean
   of the other points. */
static void Middle(const Wall *wall, PetscReal x[3]) {
  const PetscInt first = wall->kind == WALL_PATH,
                 n = wall->kind < WALL_POLYGON ? 1 : (wall->numbers - first) / 2;

  Zero3(x);
  for (PetscInt k = 0; k < n; k++)
    for (int d = 0; d < 2; d++) x[d] += wall->number[first + 2 * k + d] / n;
}

/* WallsTurnTo - ... is turned to an angle since t = 0: see MotionTurnTo(). */
PetscErrorCode WallsTurnTo(Walls *walls, PetscInt wall, PetscReal t, PetscReal by,
                           PetscReal angle) {
  PetscReal middle[3];

  PetscFunctionBegin;
  Middle(&walls->wall[wall], middle);
  PetscCall(MotionTurnTo(&walls->wall[wall].motion, t, by, angle, middle));
  PetscCall(IndexAnew(walls));
  PetscFunctionReturn(0);
}

/* WallsPostAt - where a post is at a time. */
Vector2 WallsPostAt(const Walls *walls, PetscInt post, PetscReal t) {
  const WallPost *self = &walls->post[post];
  WallPose pose;

  if (post < walls->resting) return self->at;
  pose = WallPoseAt(walls, self->wall, t);
  return WallPlaced(&pose, self->at);
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
