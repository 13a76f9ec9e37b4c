/* Where a point touches walls. */
#include "world/walls.h"

static const PetscReal everywhere = 1e300;

/* WallPieceLine - from a point along t, free on its left side (1) or right side (-1); it ends
   nowhere yet. */
WallPiece WallPieceLine(Vector2 at, Vector2 t, PetscReal side) {
  return (WallPiece){.at = at, .t = t, .n = Times2(side, Left2(t)), .deep = everywhere};
}

/* WallPieceCircle - an arc all round, free outside (1) or inside (-1). */
WallPiece WallPieceCircle(Vector2 at, PetscReal r, PetscReal sign) {
  return (WallPiece){
      .round = PETSC_TRUE, .at = at, .r = r, .sign = sign, .reach = -2, .deep = everywhere};
}

/* WallPieceArc - ... between two directions of length 1 that are less than half a turn apart. */
WallPiece WallPieceArc(Vector2 at, PetscReal r, PetscReal sign, Vector2 one, Vector2 other) {
  WallPiece p = WallPieceCircle(at, r, sign);
  const Vector2 sum = Plus2(one, other);

  p.middle = Over2(sum, Size2(sum));
  p.reach = Dot2(one, p.middle);
  return p;
}

/* WallPieceDistance - the distance of x from a piece, 0 on it, and its normal; is x in the piece's
   range? */
PetscBool WallPieceDistance(const WallPiece *p, Vector2 x, PetscReal *distance, Vector2 *normal,
                            PetscReal *bend) {
  const Vector2 o = Minus2(x, p->at);
  PetscReal size;

  if (!p->round) {
    const PetscReal z = Dot2(o, p->t);
    *distance = Dot2(o, p->n);
    *normal = p->n;
    *bend = 0;
    return (PetscBool)(z >= p->from && z < p->to && *distance >= -p->deep);
  }
  if (p->reach > 0 && Dot2(o, p->middle) < 0) return PETSC_FALSE;
  size = PetscSqrtReal(Dot2(o, o));
  if (size == 0) return PETSC_FALSE;
  *distance = p->sign * (size - p->r);
  *normal = Over2(Times2(p->sign, o), size);
  *bend = p->sign / size;
  return (PetscBool)(Dot2(o, p->middle) >= p->reach * size && *distance >= -p->deep);
}

/* ---- which pieces are near ---- */

static void Hold(Block *block, Vector2 x) {
  const PetscReal at[] = {x.x, x.y};

  BlockHold(2, block, at);
}

static Block PlaceBlock(Vector2 x) {
  const PetscReal at[] = {x.x, x.y};

  return BlockAt(2, at);
}

/* Where an arc is: within the triangle of its ends and of the corner that it rounds. */
static Block ArcBlock(const WallPiece *p, PetscReal r) {
  const PetscReal across = PetscSqrtReal(PetscMax(0, 1 - p->reach * p->reach));
  Block block = BlockEmpty(2);

  for (int e = -1; e <= 1; e++) {
    const Vector2 middle = Times2(e ? p->reach : 1 / p->reach, p->middle);
    Hold(&block, Along2(p->at, r, Along2(middle, e * across, Left2(p->middle))));
  }
  return block;
}

/* Where a piece is that ends somewhere. */
static Block PieceBlock(const WallPiece *p) {
  const Vector2 all_round = {p->r, p->r};
  Block block = BlockEmpty(2);

  if (p->round && p->reach > 0) return ArcBlock(p, p->r);
  Hold(&block, p->round ? Minus2(p->at, all_round) : Along2(p->at, PetscMin(0, p->from), p->t));
  Hold(&block, p->round ? Plus2(p->at, all_round) : Along2(p->at, PetscMax(p->edge, p->to), p->t));
  return block;
}

/* Where the axis of a conduit is beside one of its pieces. */
static Block AxisBlock(const Wall *wall, const WallPiece *p) {
  const PetscReal R = wall->number[0];
  Block block = BlockEmpty(2);

  if (p->at_mouth) {
    Hold(&block, p->mouth);
    return block;
  }
  if (p->round) return ArcBlock(p, p->r + p->sign * R);
  Hold(&block, Along2(p->at, R, p->n));
  Hold(&block, Along2(Along2(p->at, R, p->n), p->to, p->t));
  return block;
}

/* The pieces of one wall, so that a place need not look at all of them. */
static PetscErrorCode IndexPieces(Wall *wall) {
  Block *block;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(wall->pieces, &block));
  for (PetscInt k = 0; k < wall->pieces; k++)
    block[k] =
        wall->kind == WALL_PATH ? AxisBlock(wall, &wall->piece[k]) : PieceBlock(&wall->piece[k]);
  PetscCall(BlocksCreate(2, wall->pieces, block, &wall->near));
  PetscCall(PetscFree(block));
  PetscFunctionReturn(0);
}

/* Is it a conduit that rests? */
static PetscBool IsConduit(const Wall *wall) {
  return (PetscBool)(wall->kind == WALL_PATH && !wall->motion.any);
}

static PetscReal FromAxis(const Walls *walls, PetscInt conduit, Vector2 x);

/* A gentle bend is an arc of a wide circle. Where the conduit goes through that circle elsewhere,
   not all of it is behind the surface, and it is no post. */
static void DropOpenPosts(Walls *walls) {
  const PetscReal round_off = 1e-6;
  PetscInt n = 0;

  for (PetscInt k = 0; k < walls->posts; k++) {
    const WallPost post = walls->post[k];
    const Wall *wall = &walls->wall[post.wall];
    if (wall->kind == WALL_PATH &&
        FromAxis(walls, post.wall, post.at) < post.r + (1 - round_off) * wall->number[0])
      continue;
    walls->post[n++] = post;
  }
  walls->posts = n;
}

/* Puts those of walls that move behind the others. */
static PetscErrorCode SortPosts(Walls *walls) {
  WallPost *before;
  PetscInt n = 0;

  PetscFunctionBegin;
  walls->resting = walls->posts;
  if (!walls->move) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(walls->posts, &before));
  PetscCall(PetscArraycpy(before, walls->post, walls->posts));
  for (int moves = 0; moves < 2; moves++) {
    if (moves) walls->resting = n;
    for (PetscInt k = 0; k < walls->posts; k++)
      if ((int)walls->wall[before[k].wall].motion.any == moves) walls->post[n++] = before[k];
  }
  PetscCall(PetscFree(before));
  PetscFunctionReturn(0);
}

static PetscErrorCode IndexPosts(Walls *walls) {
  Block *block;

  PetscFunctionBegin;
  DropOpenPosts(walls);
  PetscCall(SortPosts(walls));
  PetscCall(PetscMalloc1(walls->resting, &block));
  for (PetscInt k = 0; k < walls->resting; k++) {
    const WallPost *post = &walls->post[k];
    const Vector2 all_round = {post->r, post->r};
    Put2(Minus2(post->at, all_round), block[k].low);
    Put2(Plus2(post->at, all_round), block[k].high);
  }
  PetscCall(BlocksCreate(2, walls->resting, block, &walls->near_posts));
  PetscCall(PetscFree(block));
  PetscFunctionReturn(0);
}

/* Squares are half as wide as the narrowest conduit and as the parts in the mean. Their lists reach
   from one over a conduit's axis as far as it is wide, and half as far again; from parts two
   squares far. */
static PetscErrorCode MakeSquares(Walls *walls) {
  enum { FEWEST = 8 }; /* pieces that are worth it */
  PetscReal size = PETSC_MAX_REAL, sum = 0, *reach;
  PetscInt pieces = walls->parts, n = 0;
  Blocks *tree;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < walls->parts; k++) {
    const WallPiece *p = &walls->wall[walls->part[k].wall].piece[walls->part[k].piece];
    sum += p->round ? p->r : p->to;
  }
  if (walls->parts) size = PetscMax(sum / walls->parts / 2, 1e-6);
  for (PetscInt w = 0; w < walls->n; w++)
    if (IsConduit(&walls->wall[w])) {
      size = PetscMin(size, walls->wall[w].number[0] / 2);
      pieces += walls->wall[w].pieces;
    }
  if (pieces < FEWEST) PetscFunctionReturn(0);
  PetscCall(PetscMalloc2(1 + walls->conduits, &tree, 1 + walls->conduits, &reach));
  tree[n] = walls->near_parts;
  reach[n++] = 2 * size;
  for (PetscInt w = 0; w < walls->n; w++)
    if (IsConduit(&walls->wall[w])) {
      tree[n] = walls->wall[w].near;
      reach[n++] = 1.5 * walls->wall[w].number[0];
    }
  PetscCall(SquaresCreate(size, n, tree, reach, &walls->squares));
  PetscCall(PetscFree2(tree, reach));
  PetscFunctionReturn(0);
}

/* WallsIndex - puts the walls where a place finds those near it. Not collective; WallsDropIndex()
   frees what is made here. */
PetscErrorCode WallsIndex(Walls *walls) {
  PetscInt n = 0;
  Block *block;

  PetscFunctionBegin;
  for (PetscInt w = 0; w < walls->n; w++) n += walls->wall[w].pieces;
  PetscCall(PetscMalloc1(n, &block));
  PetscCall(PetscMalloc1(n, &walls->part));
  PetscCall(PetscMalloc1(n, &walls->open));
  for (PetscInt w = 0; w < walls->n; w++) {
    Wall *wall = &walls->wall[w];
    PetscBool ends =
        (PetscBool)(wall->kind == WALL_POLYGON || (wall->kind == WALL_CIRCLE && !wall->inside));
    walls->conduits += wall->kind == WALL_PATH;
    if (wall->motion.any) walls->move = PETSC_TRUE;
    if (wall->kind == WALL_PATH || (wall->kind == WALL_POLYGON && wall->motion.any))
      PetscCall(IndexPieces(wall));
    for (PetscInt k = 0; k < wall->pieces && wall->kind != WALL_PATH && !wall->motion.any; k++) {
      if (ends) block[walls->parts] = PieceBlock(&wall->piece[k]);
      *(ends ? &walls->part[walls->parts++] : &walls->open[walls->opens++]) = (WallPart){w, k};
    }
  }
  PetscCall(BlocksCreate(2, walls->parts, block, &walls->near_parts));
  PetscCall(PetscFree(block));
  PetscCall(IndexPosts(walls));
  PetscCall(MakeSquares(walls));
  PetscFunctionReturn(0);
}

PetscErrorCode WallsDropIndex(Walls *walls) {
  PetscFunctionBegin;
  for (PetscInt w = 0; w < walls->n; w++) PetscCall(BlocksDestroy(&walls->wall[w].near));
  PetscCall(BlocksDestroy(&walls->near_posts));
  PetscCall(BlocksDestroy(&walls->near_parts));
  PetscCall(SquaresDestroy(&walls->squares));
  PetscCall(PetscFree(walls->part));
  PetscCall(PetscFree(walls->open));
  walls->parts = walls->opens = walls->conduits = 0;
  PetscFunctionReturn(0);
}

/* ---- what touches ---- */

/* One look from a place. */
typedef struct {
  const Walls *walls;
  Vector2 at;
  PetscReal radius, within;
  PetscReal nearest; /* gap so far, if that is what is looked for */
  PetscInt n;        /* touches so far */
  WallTouch *touch;  /* NULL: the nearest is looked for */
  PetscInt wall;     /* the conduit that is looked at */
  PetscReal far;     /* its axis, at most */
} Look;

/* Takes note of a piece, in order: by wall and piece. */
static void Take(Look *look, PetscInt wall, PetscInt piece, WallTouch *at) {
  PetscInt k = look->n;

  at->gap += look->walls->wall[wall].off - look->radius;
  look->nearest = PetscMin(look->nearest, at->gap);
  if (!look->touch || at->gap >= look->within || look->n == MOST_WALL_TOUCHES) return;
  at->wall = wall;
  at->piece = piece;
  at->again = PETSC_FALSE;
  at->v = (Vector2){0, 0};
  at->spin = 0;
  for (; k > 0 && (look->touch[k - 1].wall > wall ||
                   (look->touch[k - 1].wall == wall && look->touch[k - 1].piece > piece));
       k--)
    look->touch[k] = look->touch[k - 1];
  look->touch[k] = *at;
  look->n++;
}

static void LookAt(Look *look, const WallPart *part) {
  WallTouch at;

  if (WallPieceDistance(&look->walls->wall[part->wall].piece[part->piece], look->at, &at.gap,
                        &at.normal, &at.bend))
    Take(look, part->wall, part->piece, &at);
}

/* How far to look for pieces: a polygon's are met from behind, too, as deep as the rod is thick. */
static PetscReal Reach(const Look *look) {
  return look->radius + PetscMax(0, look->touch ? look->within : look->nearest);
}

static PetscReal MeetPart(PetscInt item, PetscReal reach, void *ctx) {
  Look *look = (Look *)ctx;

  LookAt(look, &look->walls->part[item]);
  return PetscMin(reach, Reach(look));
}

/* How far x is from the axis of a conduit, seen from one of its pieces. */
static PetscReal AxisDistance(const Wall *wall, const WallPiece *p, Vector2 x, PetscReal distance) {
  if (p->at_mouth) return Size2(Minus2(x, p->mouth));
  return PetscAbsReal(wall->number[0] - distance);
}

static PetscReal MeetAxis(PetscInt item, PetscReal reach, void *ctx) {
  Look *look = (Look *)ctx;
  const Wall *wall = &look->walls->wall[look->wall];
  WallTouch at;

  if (WallPieceDistance(&wall->piece[item], look->at, &at.gap, &at.normal, &at.bend))
    look->far = PetscMin(look->far, AxisDistance(wall, &wall->piece[item], look->at, at.gap));
  return PetscMin(reach, look->far);
}

static PetscReal MeetConduit(PetscInt item, PetscReal reach, void *ctx) {
  Look *look = (Look *)ctx;
  const Wall *wall = &look->walls->wall[look->wall];
  WallTouch at;

  if (WallPieceDistance(&wall->piece[item], look->at, &at.gap, &at.normal, &at.bend) &&
      AxisDistance(wall, &wall->piece[item], look->at, at.gap) <= reach)
    Take(look, look->wall, item, &at);
  return reach;
}

/* So few pieces are looked at one after the other: that is faster than a tree. */
enum { FEW = 24 };

/* Of a conduit those pieces count that are at the place of its axis nearest to x. */
static void LookAtConduit(Look *look, PetscInt wall, const Block *place) {
  const PetscReal same = 1 + 1e-9;

  look->wall = wall;
  look->far = everywhere;
  if (look->walls->wall[wall].pieces <= FEW) {
    const PetscInt n = look->walls->wall[wall].pieces;
    for (PetscInt k = 0; k < n; k++) (void)MeetAxis(k, everywhere, look);
    if (look->touch && look->far < look->walls->wall[wall].number[0] - look->radius - look->within)
      return; /* too near to the axis to touch */
    for (PetscInt k = 0; k < n; k++) (void)MeetConduit(k, same * look->far, look);
    return;
  }
  BlocksNear(look->walls->wall[wall].near, place, everywhere, MeetAxis, look);
  if (look->far < everywhere)
    BlocksNear(look->walls->wall[wall].near, place, same * look->far, MeetConduit, look);
}

/* LookAtConduit(), by the list of a square; false: it does not reach far enough. */
static PetscBool LookAtListed(Look *look, PetscInt wall, PetscReal reach, const int *list) {
  enum { MOST = 64 };
  const Wall *self = &look->walls->wall[wall];
  const PetscReal same = 1 + 1e-9;
  const PetscReal inner = look->touch ? self->number[0] - look->radius - look->within : 0;
  PetscReal away[MOST];
  const int n = *list++;
  WallTouch at[MOST];

  if (n > MOST) return PETSC_FALSE;
  look->far = everywhere;
  for (int k = 0; k < n; k++) {
    away[k] = everywhere;
    if (!WallPieceDistance(&self->piece[list[k]], look->at, &at[k].gap, &at[k].normal, &at[k].bend))
      continue;
    away[k] = AxisDistance(self, &self->piece[list[k]], look->at, at[k].gap);
    if (same * away[k] < inner) return PETSC_TRUE; /* too near to the axis to touch */
    look->far = PetscMin(look->far, away[k]);
  }
  if (!(same * look->far <= reach)) return PETSC_FALSE;
  for (int k = 0; k < n; k++)
    if (away[k] <= same * look->far) Take(look, wall, list[k], &at[k]);
  return PETSC_TRUE;
}

/* The pieces that end somewhere, by the list of a square as far as it reaches. */
static void LookAtParts(Look *look, const int *list) {
  const Walls *walls = look->walls;
  const Block place = PlaceBlock(look->at);
  const PetscReal reach = SquaresReach(walls->squares, 0);
  const PetscBool near = (PetscBool)(!look->touch || Reach(look) <= reach);

  if (!walls->parts) return;
  for (int k = 1; near && k <= *list; k++) LookAt(look, &walls->part[list[k]]);
  if (Reach(look) > reach) BlocksNear(walls->near_parts, &place, Reach(look), MeetPart, look);
}

/* What is near to a place, by the lists of its square. */
static void LookByLists(Look *look, const int *parts) {
  const Walls *walls = look->walls;
  const Block place = PlaceBlock(look->at);
  const int *list = SquaresNext(parts);
  PetscInt tree = 1;

  for (PetscInt w = 0; w < walls->n && walls->conduits; w++)
    if (IsConduit(&walls->wall[w])) {
      if (!LookAtListed(look, w, SquaresReach(walls->squares, tree++), list))
        LookAtConduit(look, w, &place);
      list = SquaresNext(list);
    }
  LookAtParts(look, parts);
}

/* A piece of one wall. */
static PetscReal MeetPiece(PetscInt item, PetscReal reach, void *ctx) {
  Look *look = (Look *)ctx;

  LookAt(look, &(const WallPart){look->wall, item});
  return PetscMin(reach, Reach(look));
}

/* One wall by itself. */
static void LookAtWall(Look *look, PetscInt w) {
  const Wall *wall = &look->walls->wall[w];
  const Block place = PlaceBlock(look->at);

  look->wall = w;
  if (wall->kind == WALL_PATH)
    LookAtConduit(look, w, &place);
  else if (wall->near && wall->pieces > FEW)
    BlocksNear(wall->near, &place, Reach(look), MeetPiece, look);
  else
    for (PetscInt k = 0; k < wall->pieces; k++) (void)MeetPiece(k, everywhere, look);
}

/* ... where it is: what is seen is told as of where it is given. */
static void LookAtPlaced(Look *look, PetscInt wall, const WallPose *pose) {
  const Vector2 from = look->at;

  look->at = WallGiven(pose, from);
  LookAtWall(look, wall);
  look->at = from;
}

static void LookAtMoving(Look *look) {
  const Walls *walls = look->walls;

  for (PetscInt w = 0; w < walls->n; w++)
    if (walls->wall[w].motion.any) {
      const WallPose pose = WallPoseAt(walls, w, walls->time);
      LookAtPlaced(look, w, &pose);
    }
}

static void LookAtResting(Look *look) {
  const Walls *walls = look->walls;
  const Block place = PlaceBlock(look->at);
  const PetscReal at[] = {look->at.x, look->at.y};
  const int *lists = walls->squares ? SquaresAt(walls->squares, at) : NULL;

  for (PetscInt k = 0; k < walls->opens; k++) LookAt(look, &walls->open[k]);
  if (lists) {
    LookByLists(look, lists);
    return;
  }
  for (PetscInt w = 0; w < walls->n && walls->conduits; w++)
    if (IsConduit(&walls->wall[w])) LookAtConduit(look, w, &place);
  if (walls->parts <= FEW)
    for (PetscInt k = 0; k < walls->parts; k++) LookAt(look, &walls->part[k]);
  else
    BlocksNear(walls->near_parts, &place, Reach(look), MeetPart, look);
}

static void LookAround(Look *look) {
  if (look->walls->move) LookAtMoving(look);
  LookAtResting(look);
}

/* Of a wall that moves: its normal as it is now, and its velocity where it touches. */
static void Moves(const Look *look, WallTouch *touch) {
  const Wall *wall = &look->walls->wall[touch->wall];
  const WallPose pose = WallPoseAt(look->walls, touch->wall, look->walls->time);
  const PetscReal distance = touch->gap + look->radius - wall->off;

  touch->normal = Turned2(pose.turn, touch->normal);
  touch->v = WallVelocity(look->walls, touch->wall, Along2(look->at, -distance, touch->normal),
                          &touch->spin);
}

/*
  WallsTouch - the surfaces near a point of the rod, in the clamp's frame.

  radius  of the rod        within  only those with a gap below this
  Returns how many there are; MOST_WALL_TOUCHES: there may be more.
*/
PetscInt WallsTouch(const Walls *walls, const PetscReal x[3], PetscReal radius, PetscReal within,
                    WallTouch touch[MOST_WALL_TOUCHES]) {
  Look look = {.walls = walls, .at = From2(x), .radius = radius, .within = within, .touch = touch};

  look.nearest = everywhere;
  LookAround(&look);
  for (PetscInt k = 1; k < look.n; k++)
    touch[k].again = (PetscBool)(touch[k].wall == touch[k - 1].wall);
  for (PetscInt k = 0; k < look.n && walls->move; k++)
    if (walls->wall[touch[k].wall].motion.any) Moves(&look, &touch[k]);
  return look.n;
}

/* WallsGapWithin - the smallest gap of a point of the rod to any wall, if that is below `within`;
   else that. */
PetscReal WallsGapWithin(const Walls *walls, const PetscReal x[3], PetscReal radius,
                         PetscReal within) {
  Look look = {.walls = walls, .at = From2(x), .radius = radius, .nearest = within};

  LookAround(&look);
  return look.nearest;
}

/* WallsGap - the smallest gap of a point of the rod to any wall; 1e300: there is none. */
PetscReal WallsGap(const Walls *walls, const PetscReal x[3], PetscReal radius) {
  return WallsGapWithin(walls, x, radius, everywhere);
}

/* WallsGapAtRest - ... to any that does not move. */
PetscReal WallsGapAtRest(const Walls *walls, const PetscReal x[3], PetscReal radius) {
  Look look = {.walls = walls, .at = From2(x), .radius = radius, .nearest = everywhere};

  LookAtResting(&look);
  return look.nearest;
}

/* ---- what is solid ---- */

/* Is x in the polygon? A ray along x1 crosses its edges an odd number of times. */
static PetscBool InPolygon(const Wall *wall, Vector2 x) {
  PetscBool in = PETSC_FALSE;

  for (PetscInt k = 0; k < wall->pieces; k++) {
    const WallPiece *p = &wall->piece[k];
    const Vector2 a = Minus2(p->at, x), b = Along2(a, p->edge, p->t);
    if (p->round) continue;
    if ((a.y > 0) != (b.y > 0) && (Cross2(a, b) > 0) == (b.y > a.y)) in = (PetscBool)!in;
  }
  return in;
}

/* A place as a wall has it that is where it is given. */
static Vector2 AsGiven(const Walls *walls, PetscInt wall, const PetscReal x[3]) {
  WallPose pose;

  if (!walls->wall[wall].motion.any) return From2(x);
  pose = WallPoseAt(walls, wall, walls->time);
  return WallGiven(&pose, From2(x));
}

/* WallsBehind - the polygon behind whose surface a place is, however deep: its number; -1: none.
   (Of the other walls the gap tells.) */
PetscInt WallsBehind(const Walls *walls, const PetscReal x[3]) {
  for (PetscInt w = 0; w < walls->n; w++)
    if (walls->wall[w].kind == WALL_POLYGON &&
        InPolygon(&walls->wall[w], AsGiven(walls, w, x)) != walls->wall[w].inside)
      return w;
  return -1;
}

/* WallGap - the gap of a point of the rod to one wall, which is there. */
PetscReal WallGap(const Walls *walls, PetscInt wall, const WallPose *pose, const PetscReal x[3],
                  PetscReal radius) {
  const Wall *self = &walls->wall[wall];
  Look look = {.walls = walls, .at = From2(x), .radius = radius, .nearest = everywhere};

  if (self->kind == WALL_POLYGON && InPolygon(self, WallGiven(pose, look.at)) != self->inside)
    return -radius;
  LookAtPlaced(&look, wall, pose);
  return look.nearest;
}

/* How far a place is, where walls are given, from the axis of a conduit. */
static PetscReal FromAxis(const Walls *walls, PetscInt conduit, Vector2 x) {
  const Block place = PlaceBlock(x);
  Look look = {.walls = walls, .at = x, .nearest = everywhere, .wall = conduit, .far = everywhere};

  BlocksNear(walls->wall[conduit].near, &place, everywhere, MeetAxis, &look);
  return look.far;
}

/* WallsHold - is a place in the conduit which that wall is? One that is none holds every place. */
PetscBool WallsHold(const Walls *walls, PetscInt wall, const PetscReal x[3]) {
  const Wall *self = &walls->wall[wall];

  return (PetscBool)(self->kind != WALL_PATH ||
                     FromAxis(walls, wall, AsGiven(walls, wall, x)) <= self->number[0]);
}
