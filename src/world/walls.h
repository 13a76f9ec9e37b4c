/* Walls: what stands around the rod, or is carried along. A wall is a plane, a circle, a polygon or
   a conduit; each is made of pieces, lines and arcs, whose signed distance is smooth. All that is
   kept of a wall that moves is where it is given; a place looks at it as it would from there.
 */
#ifndef TENDRIL_WALLS_H
#define TENDRIL_WALLS_H

#include "base/options.h"
#include "base/blocks.h"
#include "base/plane.h"
#include "base/squares.h"
#include "world/surfaces.h"

typedef enum { WALL_PLANE, WALL_CIRCLE, WALL_POLYGON, WALL_PATH, WALL_KINDS } WallKind;
extern const char *const wall_kind[WALL_KINDS];

/* A piece of a wall: a line, of which one side is free, or an arc, free outside or inside. */
typedef struct {
  PetscBool round;
  Vector2 at;         /* a point of the line; the centre of the arc */
  Vector2 t, n;       /* line: along it, and into the free side */
  PetscReal from, to; /* line: where along t it presses */
  PetscReal edge;     /* of a polygon: how long it is from `at` on, whatever of it presses */
  PetscReal r, sign;  /* arc: radius; 1 free outside, -1 inside */
  Vector2 middle;     /* arc: its middle direction, */
  PetscReal reach;    /* ... and the cosine of half its angle */
  PetscReal deep;     /* not met by what is deeper behind it than this */
  Vector2 mouth;      /* arc at the mouth of a conduit: where the axis ends */
  PetscBool at_mouth;
} WallPiece;

typedef struct {
  WallKind kind;
  int line;         /* of the file, where it stands */
  PetscBool inside; /* circle and polygon: the rod is inside */
  PetscBool bare;   /* does not say its own friction */
  PetscReal friction;
  PetscReal off;  /* by so much it is farther away than given: see ContactStandOff() */
  PetscReal bend; /* of a path: radius of its axis in corners; 0: as wide as it needs */
  PetscInt numbers;
  PetscReal *number; /* as given, in the laboratory; a path's first is its radius */
  PetscInt pieces;
  WallPiece *piece;     /* in the clamp's frame */
  Blocks near;          /* its pieces: where the axis of a conduit is beside each; of a polygon that
                           moves, where they are; of others NULL */
  SurfaceMotion motion; /* in the plane, about x3 */
} Wall;

/* Where a wall is: what is given at x is at the turned x + by, in the clamp's frame. */
typedef struct {
  Vector2 turn, by; /* turn: cosine and sine */
} WallPose;

/* What stands out of a wall and is round, of radius r, or sharp, r = 0: all of the circle is behind
   the surface. It may be narrower than a cell of the rod (rod/feet.h). */
typedef struct {
  Vector2 at;
  PetscReal r;
  PetscInt wall;
} WallPost;

/* One piece of all: of wall w, its k-th. */
typedef struct {
  PetscInt wall, piece;
} WallPart;

typedef struct {
  PetscInt n;
  Wall *wall;
  PetscBool rub;           /* any has friction */
  PetscBool bare;          /* any, or a surface in space, does not say its own friction */
  PetscBool move;          /* any does */
  PetscBool carried;       /* ... from the start, as its line says */
  PetscReal time;          /* at which they are looked at */
  Vector2 turn;            /* of the clamp: cosine and sine of its angle */
  PetscReal smallest;      /* of what the rod is outside of, the least radius; 0: there is none */
  PetscInt posts, resting; /* those of walls that move are behind the others */
  WallPost *post;
  /* so that a place need not look at all of them */
  Blocks near_posts, near_parts; /* posts; pieces that end somewhere, but for conduits; at rest */
  WallPart *part, *open;         /* those pieces; the others, planes and circles from within */
  PetscInt parts, opens, conduits;
  Squares squares; /* of the parts, then of the axis of each conduit; NULL: there are few pieces */
} Walls;

/* A surface near a point: its distance less the rod's radius; the normal, towards the rod; the
   curvature of the lines of equal distance, dn = bend t (t.dx), t across n. */
typedef struct {
  PetscReal gap, bend;
  Vector2 normal, v; /* v: velocity of the wall, where it touches */
  PetscReal spin;    /* its rate of turning */
  PetscInt wall, piece;
  PetscBool again; /* another piece of the wall before it */
} WallTouch;

enum { MOST_WALL_TOUCHES = 32 }; /* at one place */

PetscErrorCode WallsRead(const char *file, PetscReal radius, PetscReal friction,
                         PetscReal clamp_angle, Walls *walls, Surfaces *surfaces);
PetscErrorCode WallsDestroy(Walls *walls);
PetscErrorCode WallsText(const Walls *walls, char **text);

/* walls_move.c */
PetscErrorCode WallsLeadTo(Walls *walls, PetscInt wall, PetscReal t, PetscReal by,
                           const PetscReal x[3]);
PetscErrorCode WallsTurnTo(Walls *walls, PetscInt wall, PetscReal t, PetscReal by, PetscReal angle);
WallPose WallPoseAt(const Walls *walls, PetscInt wall, PetscReal t);
WallPose WallPoseShifted(const Walls *walls, PetscInt wall, const PetscReal lab[3]);
Vector2 WallVelocity(const Walls *walls, PetscInt wall, Vector2 x, PetscReal *spin);
Vector2 WallCarry(const Walls *walls, PetscInt wall, PetscReal from, Vector2 x);
PetscReal WallBow(const Walls *walls, PetscInt wall, PetscReal from, Vector2 x);
Vector2 WallsPostAt(const Walls *walls, PetscInt post, PetscReal t);
void WallsPostsNear(const Walls *walls, const Block *place, PetscReal reach, BlocksMeet meet,
                    void *ctx);
PetscBool WallsJerk(const Walls *walls, PetscReal t0, PetscReal t1);
PetscReal WallsNextTurn(const Walls *walls, PetscReal t);

/* touch.c */
PetscErrorCode WallsIndex(Walls *walls);
PetscErrorCode WallsDropIndex(Walls *walls);
WallPiece WallPieceLine(Vector2 at, Vector2 t, PetscReal side);
WallPiece WallPieceCircle(Vector2 at, PetscReal r, PetscReal sign);
WallPiece WallPieceArc(Vector2 at, PetscReal r, PetscReal sign, Vector2 one, Vector2 other);
PetscBool WallPieceDistance(const WallPiece *piece, Vector2 x, PetscReal *distance, Vector2 *normal,
                            PetscReal *bend);
PetscInt WallsTouch(const Walls *walls, const PetscReal x[3], PetscReal radius, PetscReal within,
                    WallTouch touch[MOST_WALL_TOUCHES]);
PetscReal WallsGapWithin(const Walls *walls, const PetscReal x[3], PetscReal radius,
                         PetscReal within);
PetscReal WallsGap(const Walls *walls, const PetscReal x[3], PetscReal radius);
PetscReal WallsGapAtRest(const Walls *walls, const PetscReal x[3], PetscReal radius);
PetscReal WallGap(const Walls *walls, PetscInt wall, const WallPose *pose, const PetscReal x[3],
                  PetscReal radius);
PetscInt WallsBehind(const Walls *walls, const PetscReal x[3]);
PetscBool WallsHold(const Walls *walls, PetscInt wall, const PetscReal x[3]);

/* WallPlaced - where that of a wall is which is given at a place. */
static inline Vector2 WallPlaced(const WallPose *pose, Vector2 given) {
  return Plus2(Turned2(pose->turn, given), pose->by);
}

/* WallGiven - ... and back. */
static inline Vector2 WallGiven(const WallPose *pose, Vector2 x) {
  return TurnedBack2(pose->turn, Minus2(x, pose->by));
}

#endif
