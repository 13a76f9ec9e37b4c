/* Passing through walls of the plane: a post has been swept if what the rod has swept winds about
   it, which is known exactly. */
#include "base/bezier.h"
#include "rod/passing.h"
#include "rod/rules.h"

/* The four points of a Bezier curve. */
enum { DIMS = 2 };
typedef PetscReal Bezier[4][DIMS];

static void CurveOf(const FootCell *cell, Bezier b) {
  CurveBezier(DIMS, &cell->curve, b[0]);
}

static Block BlockOf(Bezier b) {
  Block block = BlockEmpty(2);
  for (int k = 0; k < 4; k++) BlockHold(2, &block, b[k]);
  return block;
}

static PetscBool Holds(const Block *block, Vector2 x) {
  return (PetscBool)(x.x >= block->low[0] && x.x <= block->high[0] && x.y >= block->low[1] &&
                     x.y <= block->high[1]);
}

enum { DEEPEST = 48 }; /* as often is a curve divided, until round-off ends it */

/* The angle by which the way from a to b turns about c. */
static PetscReal Turn(Vector2 a, Vector2 b, Vector2 c) {
  const Vector2 o = Minus2(a, c), p = Minus2(b, c);

  return PetscAtan2Real(Cross2(o, p), Dot2(o, p));
}

/* ... the curve: as its chord, if c is not within its points. */
static PetscReal CurveTurn(Bezier b, Vector2 c, int depth) {
  const Block block = BlockOf(b);
  Bezier half[2];

  if (depth == DEEPEST || !Holds(&block, c)) return Turn(From2(b[0]), From2(b[3]), c);
  BezierDivide(DIMS, b[0], half[0][0]);
  return CurveTurn(half[0], c, depth + 1) + CurveTurn(half[1], c, depth + 1);
}

/* Does the curve cut the edge of a polygon? */
static PetscBool Cuts(Bezier b, const WallPiece *line, int depth) {
  PetscReal low = PETSC_MAX_REAL, high = -PETSC_MAX_REAL, near = PETSC_MAX_REAL,
            far = -PETSC_MAX_REAL;
  Bezier half[2];

  for (int k = 0; k < 4; k++) {
    const Vector2 o = Minus2(From2(b[k]), line->at);
    low = PetscMin(low, Dot2(o, line->n));
    high = PetscMax(high, Dot2(o, line->n));
    near = PetscMin(near, Dot2(o, line->t));
    far = PetscMax(far, Dot2(o, line->t));
  }
  if (low > 0 || high < 0 || far < 0 || near > line->edge) return PETSC_FALSE;
  if (depth == DEEPEST) return PETSC_TRUE;
  BezierDivide(DIMS, b[0], half[0][0]);
  return (PetscBool)(Cuts(half[0], line, depth + 1) || Cuts(half[1], line, depth + 1));
}

/* ---- where the rod is ---- */

/* A look at a cell. */
typedef struct {
  const Contact *contact;
  const FootCell *cell;
  Bezier curve;
  const Wall *wall; /* a polygon that moves, if one is looked at: the curve is as it sees it */
  PetscBool passes;
} Looking;

/* Is the curve in the middle of a post, behind half of what it and the rod are thick? */
static PetscReal MeetPost(PetscInt item, PetscReal reach, void *ctx) {
  Looking *look = (Looking *)ctx;
  const WallPost *post = &look->contact->walls.post[item];
  const PetscReal half = look->contact->diameter / 2, rho = post->r + half,
                  deep = half > 0 ? PetscMin(half, rho / 2) : rho / 2;
  const Vector2 at = WallsPostAt(&look->contact->walls, item, look->contact->walls.time);
  Foot foot;

  if (FootAbout(look->cell, at, &foot) && Size2(Minus2(From2(foot.on.x), at)) < rho - deep)
    look->passes = PETSC_TRUE;
  return look->passes ? -1 : reach;
}

/* Does it cut the edge of a polygon? */
static PetscReal MeetPiece(const WallPiece *piece, PetscReal reach, Looking *look) {
  if (!piece->round && Cuts(look->curve, piece, 0)) look->passes = PETSC_TRUE;
  return look->passes ? -1 : reach;
}

static PetscReal MeetPart(PetscInt item, PetscReal reach, void *ctx) {
  Looking *look = (Looking *)ctx;
  const WallPart *part = &look->contact->walls.part[item];

  return MeetPiece(&look->contact->walls.wall[part->wall].piece[part->piece], reach, look);
}

static PetscReal MeetMovedPart(PetscInt item, PetscReal reach, void *ctx) {
  Looking *look = (Looking *)ctx;

  return MeetPiece(&look->wall->piece[item], reach, look);
}

/* ... of one that moves. */
static void MeetMovedEdges(Looking *look) {
  const Walls *walls = &look->contact->walls;

  for (PetscInt w = 0; w < walls->n && !look->passes; w++) {
    Looking seen = {.contact = look->contact, .wall = &walls->wall[w]};
    WallPose pose;
    Block block;
    if (!seen.wall->motion.any || seen.wall->kind != WALL_POLYGON) continue;
    pose = WallPoseAt(walls, w, walls->time);
    for (int k = 0; k < 4; k++) Put2(WallGiven(&pose, From2(look->curve[k])), seen.curve[k]);
    block = BlockOf(seen.curve);
    BlocksNear(seen.wall->near, &block, 0, MeetMovedPart, &seen);
    look->passes = seen.passes;
  }
}

/* Is a place of the rod behind any wall, or was it on its way there? (Only between the arms of
   conduits may it come out again: what is behind the other walls has no other side, or is seen by
   its edges and posts.) */
static PetscBool Behind(const Contact *contact, Vector2 x0, Vector2 x1) {
  const Vector2 way = Minus2(x1, x0);
  const PetscReal half = contact->diameter / 2,
                  deep = half > 0 ? half : rod_rule.lengths_behind * contact->tip;
  PetscInt n = 1;

  if (contact->walls.conduits)
    n = (PetscInt)PetscMin(rod_rule.behind_states, PetscCeilReal(2 * Size2(way) / deep));
  for (PetscInt k = 1; k <= PetscMax(n, 1); k++) {
    PetscReal x[3] = {0};
    Put2(Along2(x0, (PetscReal)k / PetscMax(n, 1), way), x);
    if (WallsGap(&contact->walls, x, half) < -deep) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ... seen from the conduits that have moved since then: so it is told to have been behind one
   where it was not only if it has gone far. */
static PetscBool BehindMoving(const Contact *contact, PetscReal t0, Vector2 x0, Vector2 x1) {
  const Walls *walls = &contact->walls;

  for (PetscInt w = 0; w < walls->n; w++)
    if (walls->wall[w].motion.any && walls->wall[w].kind == WALL_PATH &&
        Behind(contact, WallCarry(walls, w, t0, x0), x1))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscBool CellIsBehind(const Contact *contact, PetscReal t0, const FootCell *before,
                              const FootCell *cell) {
  const Vector2 x0 = From2(before->curve.x[1]), x1 = From2(cell->curve.x[1]);
  Looking look = {.contact = contact, .cell = cell};
  Block block;

  CurveOf(cell, look.curve);
  block = BlockOf(look.curve);
  WallsPostsNear(&contact->walls, &block, contact->diameter / 2, MeetPost, &look);
  if (!look.passes) BlocksNear(contact->walls.near_parts, &block, 0, MeetPart, &look);
  if (contact->walls.move && !look.passes) MeetMovedEdges(&look);
  return (PetscBool)(look.passes || Behind(contact, x0, x1) ||
                     (contact->walls.move && BehindMoving(contact, t0, x0, x1)));
}

/* ---- what it has swept ---- */

static PetscReal Mark(PetscInt item, PetscReal reach, void *ctx) {
  ((char *)ctx)[item] = 1;
  return reach;
}

/* Marks the posts that a cell may have swept, and all that move: what it sweeps is between its
   points before and now. */
static void MarkPosts(const Walls *walls, const FootCell *before, const FootCell *cell,
                      char marked[]) {
  Bezier b[2];
  Block block = BlockEmpty(2);

  CurveOf(before, b[0]);
  CurveOf(cell, b[1]);
  for (int k = 0; k < 8; k++) BlockHold(2, &block, b[k / 4][k % 4]);
  WallsPostsNear(walls, &block, 0, Mark, marked);
}

/* In how many parts of a step does an end of a cell, now at x, see a wall go by on ways that are
   straight, but for a part of how thick a post is with the rod? */
static PetscInt PartsOf(const Contact *contact, PetscReal t0, const WallPost *post, Vector2 x) {
  const PetscReal thick = post->r + contact->diameter / 2,
                  bow = WallBow(&contact->walls, post->wall, t0, x),
                  n = PetscCeilReal(PetscSqrtReal(bow * rod_rule.passing_parts / thick));

  return (PetscInt)PetscMax(1, PetscMin(rod_rule.passing_most, n));
}

/* By how much the way of an end of a cell turns about a post, as that sees it. */
static PetscReal EndTurn(const Contact *contact, const Passing *cells, PetscInt k, int end,
                         PetscInt post) {
  const Walls *walls = &contact->walls;
  const Vector2 from = From2(cells->before[k].curve.x[end]), to = From2(cells->now[k].curve.x[end]),
                c = WallsPostAt(walls, post, walls->time);
  const PetscInt wall = walls->post[post].wall;
  PetscReal sum = 0;
  Vector2 before;
  PetscInt n;

  if (post < walls->resting) return Turn(from, to, c);
  n = PartsOf(contact, cells->t0, &walls->post[post], to);
  before = WallCarry(walls, wall, cells->t0, from);
  for (PetscInt i = 1; i < n; i++) {
    const PetscReal part = (PetscReal)i / n;
    const Vector2 on_the_way = WallCarry(walls, wall, cells->t0 + part * (walls->time - cells->t0),
                                         Along2(from, part, Minus2(to, from)));
    sum += Turn(before, on_the_way, c);
    before = on_the_way;
  }
  return sum + Turn(before, to, c);
}

/*
  Has the rod swept the middle c of a post? The rod before, the way of its tip, the rod now
  backwards, and the way of its beginning, which rests in a clamp, are a closed line: it has, if
  that winds about c,

    turns of the rod before + the way of the tip - the rod now - the way of its beginning = 2 pi, or
    -2 pi

  so it does not matter which of its material is where. Of a post that moves, all is as it sees the
  rod.
*/
static PetscReal Winding(const Contact *contact, const Passing *cells, PetscInt post) {
  const Walls *walls = &contact->walls;
  const Vector2 was = WallsPostAt(walls, post, cells->t0),
                is = WallsPostAt(walls, post, walls->time);
  PetscReal sum = 0;

  for (PetscInt k = 0; k < cells->n; k++)
    for (int now = 0; now < 2; now++) {
      Bezier b;
      CurveOf(now ? &cells->now[k] : &cells->before[k], b);
      sum += (now ? -1 : 1) * CurveTurn(b, now ? is : was, 0);
    }
  if (cells->n && cells->now[0].first) sum -= EndTurn(contact, cells, 0, 0, post);
  if (cells->n && cells->now[cells->n - 1].last)
    sum += EndTurn(contact, cells, cells->n - 1, 1, post);
  return sum;
}

/* Collective. */
static PetscErrorCode Sweeps(Rod rod, const Passing *cells, PetscBool *sweeps) {
  const Walls *walls = &rod->scene->contact.walls;
  PetscInt n = 0;
  PetscReal *sum;
  PetscMPIInt count;
  char *marked;

  PetscFunctionBegin;
  *sweeps = PETSC_FALSE;
  if (!walls->posts) PetscFunctionReturn(0);
  PetscCall(PetscCalloc1(walls->posts, &marked));
  for (PetscInt k = 0; k < cells->n; k++)
    MarkPosts(walls, &cells->before[k], &cells->now[k], marked);
  PetscCall(PetscMPIIntCast(walls->posts, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, marked, count, MPI_CHAR, MPI_MAX, rod->scene->comm));
  PetscCall(PetscMalloc1(walls->posts, &sum));
  for (PetscInt k = 0; k < walls->posts; k++)
    if (marked[k]) sum[n++] = Winding(&rod->scene->contact, cells, k);
  PetscCall(PetscMPIIntCast(n, &count));
  if (n)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, count, MPIU_REAL, MPI_SUM, rod->scene->comm));
  for (PetscInt k = 0; k < n; k++)
    if (PetscAbsReal(sum[k]) > PETSC_PI) *sweeps = PETSC_TRUE;
  PetscCall(PetscFree(sum));
  PetscCall(PetscFree(marked));
  PetscFunctionReturn(0);
}

/* PassingTellPlane - as RodPassesWalls(), of a rod in the plane. */
PetscErrorCode PassingTellPlane(Rod rod, const Passing *cells, PetscBool *passes) {
  const Contact *contact = &rod->scene->contact;
  PetscBool sweeps, behind = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < cells->n && !behind; k++)
    behind = CellIsBehind(contact, cells->t0, &cells->before[k], &cells->now[k]);
  PetscCall(Sweeps(rod, cells, &sweeps));
  *passes = (PetscBool)(behind || sweeps);
  PetscFunctionReturn(0);
}
