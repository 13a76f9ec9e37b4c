/* Passing, of a rod in space: the curve between nodes, and what it sweeps in a step, are divided
   until each part is off the walls: a distance changes by no more than the way, so that a part
   within r of a point that is farther than that from a wall is clear of it. */
#include "base/bezier.h"
#include "base/vectors.h"
#include "rod/passing.h"
#include "rod/rules.h"

/* The four points of a Bezier curve. */
enum { DIMS = 3 };
typedef PetscReal Bezier[4][DIMS];

typedef enum { CLEAR, NEAR, BEHIND } Verdict;

/* A look at a cell: what counts as behind, and how finely the curve is divided; of what is swept,
   by which surface that moves (behind these: which wall of the plane), or by all that rest. */
typedef struct {
  const Contact *contact;
  PetscReal deep, fine;
  PetscInt moving;
} Look;

enum { RESTING = -1 };

enum { DEEPEST = 24 };

static void CurveOf(const FootCell *cell, Bezier b) {
  CurveBezier(DIMS, &cell->curve, b[0]);
}

static PetscReal Apart(const PetscReal a[3], const PetscReal b[3]) {
  PetscReal way[3];
  Minus3(a, b, way);
  return Size3(way);
}

/* Is a place behind a wall of the plane, how deep it may be? */
static PetscBool BehindUpright(const Contact *contact, const PetscReal x[3]) {
  PetscReal y[3];

  if (!contact->walls.n) return PETSC_FALSE;
  ContactToWalls(contact, x, y);
  return (PetscBool)(WallsBehind(&contact->walls, y) >= 0);
}

/* ---- where the rod is ---- */

static Verdict PlaceVerdict(const Look *look, const PetscReal x[3], PetscReal r) {
  const PetscReal gap = ContactGap(3, look->contact, x, r);

  if (gap < -look->deep || BehindUpright(look->contact, x)) return BEHIND;
  return gap - r >= -look->deep ? CLEAR : NEAR;
}

static PetscBool CurveIsBehind(const Look *look, Bezier b, int depth) {
  PetscReal r = 0;
  Bezier half[2];
  Verdict verdict;

  BezierDivide(DIMS, b[0], half[0][0]);
  for (int k = 0; k < 4; k++) r = PetscMax(r, Apart(b[k], half[1][0]));
  verdict = PlaceVerdict(look, half[1][0], r);
  if (verdict == BEHIND) return PETSC_TRUE;
  if (verdict == CLEAR || depth == DEEPEST || r < look->fine) return PETSC_FALSE;
  return (PetscBool)(CurveIsBehind(look, half[0], depth + 1) ||
                     CurveIsBehind(look, half[1], depth + 1));
}

/* ---- what it has swept ---- */

/* Is a surface one of those that are looked at? */
static PetscBool Sweeps(const Look *look, PetscInt which) {
  if (look->moving != RESTING) return (PetscBool)(which == look->moving);
  return (PetscBool)!look->contact->surfaces.surface[which].motion.any;
}

/* Are walls of the plane? */
static PetscBool SweepsFlat(const Look *look) {
  return (PetscBool)(look->moving == RESTING || look->moving >= look->contact->surfaces.n);
}

/* ... the gap to those. */
static PetscReal FlatGap(const Look *look, const PetscReal x[3]) {
  const Walls *walls = &look->contact->walls;
  const PetscReal half = look->contact->diameter / 2;
  const PetscInt wall = look->moving - look->contact->surfaces.n;
  PetscReal y[3];
  WallPose pose;

  ContactToWalls(look->contact, x, y);
  if (look->moving == RESTING) return WallsGapAtRest(walls, y, half);
  pose = WallPoseAt(walls, wall, walls->time);
  return WallGap(walls, wall, &pose, y, half);
}

/* How deep in a thing, which with the rod is so thick, a place is on its way through: half of that,
   for on its way round it is a little deep in it, too; of what is thin beside the depth that counts
   as behind, as of a thread that meets a wire, less than to its middle, or nothing ever would be.
 */
static PetscReal DeepOnTheWay(const Look *look, PetscReal thick) {
  return PetscMin(PetscMax(look->deep, thick / 2), rod_rule.before_middle * thick);
}

/* Of what has another side: was a place so deep in it? fine: how finely it is to be looked. */
static Verdict SweptVerdict(const Look *look, const PetscReal x[3], PetscReal r, PetscReal *fine) {
  const Contact *contact = look->contact;
  const PetscReal half = contact->diameter / 2;
  PetscInt which[MOST_SURFACES], n = 0;
  SurfacePoint point[MOST_SURFACES];
  Verdict verdict = CLEAR;
  PetscReal y[3];

  *fine = PETSC_MAX_REAL;
  ContactToLab(contact, x, y);
  if (contact->surfaces.n) n = SurfacesNear(&contact->surfaces, y, r + half, which, point);
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal core = contact->surfaces.surface[which[k]].core,
                    deep = DeepOnTheWay(look, core + half), gap = point[k].distance - half;
    if (core == PETSC_MAX_REAL || !Sweeps(look, which[k]) || gap - r >= -deep) continue;
    if (gap < -deep) return BEHIND;
    verdict = NEAR;
    *fine = PetscMin(*fine, deep / rod_rule.passing_parts);
  }
  if (n == MOST_SURFACES) { /* there may be more: the parts have fewer about them */
    verdict = NEAR;
    *fine = PetscMin(*fine, look->fine);
  }
  if (contact->walls.smallest > 0 && SweepsFlat(look)) {
    /* the other side of the plane's walls is seen by how narrow they are */
    const PetscReal deep = DeepOnTheWay(look, contact->walls.smallest), gap = FlatGap(look, x);
    if (gap < -deep) return BEHIND;
    if (gap - r < -deep) {
      verdict = NEAR;
      *fine = PetscMin(*fine, deep / rod_rule.passing_parts);
    }
  }
  return verdict;
}

/* Has the curve swept anything on its way from b0 to b1, all points on straight lines? */
static PetscBool SweepIsBehind(const Look *look, Bezier b0, Bezier b1, int depth) {
  PetscReal r[] = {0, 0}, mid[3], fine, reach = 0; /* r: along the curve, along the way */
  Bezier half[2][2], now;
  Verdict verdict;

  BezierDivide(DIMS, b0[0], half[0][0][0]);
  BezierDivide(DIMS, b1[0], half[1][0][0]);
  for (int d = 0; d < 3; d++) mid[d] = (half[0][1][0][d] + half[1][1][0][d]) / 2;
  for (int k = 0; k < 4; k++) {
    reach = PetscMax(reach, PetscMax(Apart(b0[k], mid), Apart(b1[k], mid)));
    r[0] = PetscMax(r[0], Apart(b0[k], half[0][1][0]));
    r[1] = PetscMax(r[1], Apart(b0[k], b1[k]));
  }
  verdict = SweptVerdict(look, mid, reach, &fine);
  if (verdict == BEHIND) return PETSC_TRUE;
  if (verdict == CLEAR || depth == DEEPEST || reach < fine) return PETSC_FALSE;
  if (r[0] > r[1])
    return (PetscBool)(SweepIsBehind(look, half[0][0], half[1][0], depth + 1) ||
                       SweepIsBehind(look, half[0][1], half[1][1], depth + 1));
  for (int k = 0; k < 4; k++)
    for (int d = 0; d < 3; d++) now[k][d] = (b0[k][d] + b1[k][d]) / 2;
  return (PetscBool)(SweepIsBehind(look, b0, now, depth + 1) ||
                     SweepIsBehind(look, now, b1, depth + 1));
}

static PetscBool Moves(Bezier b0, Bezier b1) {
  for (int k = 0; k < 4; k++)
    if (Apart(b0[k], b1[k]) > 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* How what is looked at moves. */
static const SurfaceMotion *MotionOf(const Contact *contact, PetscInt moving) {
  return moving < contact->surfaces.n ? &contact->surfaces.surface[moving].motion
                                      : &contact->walls.wall[moving - contact->surfaces.n].motion;
}

/* A curve of an earlier time as a surface that moves would have it now: it has been carried along
   with the surface since. */
static void Carry(const Contact *contact, PetscInt which, PetscReal from, Bezier b,
                  Bezier carried) {
  PetscReal y[3], z[3];

  for (int k = 0; k < 4; k++) {
    ContactToLab(contact, b[k], y);
    MotionCarry(MotionOf(contact, which), from, contact->time, y, z);
    for (int d = 0; d < 3; d++) z[d] -= contact->place[d];
    TurnBack3(contact->lab, z, carried[k]);
  }
}

/* In how many parts of the time does a curve see a surface go by on ways that are straight, but for
   a part of how deep it would be on its way through? */
static PetscInt PartsOf(const Look *look, PetscReal since, Bezier b) {
  const Contact *contact = look->contact;
  const PetscReal half = contact->diameter / 2,
                  thick = look->moving < contact->surfaces.n
                              ? contact->surfaces.surface[look->moving].core + half
                              : contact->walls.smallest,
                  fine = DeepOnTheWay(look, thick) / rod_rule.passing_parts;
  PetscReal y[3], n;

  ContactToLab(contact, b[0], y);
  n = PetscCeilReal(
      PetscSqrtReal(MotionBow(MotionOf(contact, look->moving), since, contact->time, y) / fine));
  return (PetscInt)PetscMax(1, PetscMin(rod_rule.passing_most, n));
}

/* The cell part of the way from b0 at a time on to b1 now, as a surface that moves would have it.
 */
static void CarryOnTheWay(const Look *look, PetscReal since, PetscReal part, Bezier b0, Bezier b1,
                          Bezier carried) {
  const PetscReal now = look->contact->time;
  Bezier b;

  for (int k = 0; k < 4; k++)
    for (int d = 0; d < 3; d++) b[k][d] = b0[k][d] + part * (b1[k][d] - b0[k][d]);
  Carry(look->contact, look->moving, since + part * (now - since), b, carried);
}

/* Has a surface that moves swept across a cell since a time? */
static PetscBool IsSwept(const Look *look, PetscReal since, Bezier b0, Bezier b1) {
  const PetscInt n = PartsOf(look, since, b1);
  Bezier there[2];
  PetscInt i = 0;

  Carry(look->contact, look->moving, since, b0, there[0]);
  for (; i + 1 < n; i++) {
    CarryOnTheWay(look, since, (PetscReal)(i + 1) / n, b0, b1, there[(i + 1) % 2]);
    if (SweepIsBehind(look, there[i % 2], there[(i + 1) % 2], 0)) return PETSC_TRUE;
  }
  return (PetscBool)(Moves(there[i % 2], b1) && SweepIsBehind(look, there[i % 2], b1, 0));
}

/* Does something move, and has it another side? */
static PetscBool MaySweep(const Contact *contact, PetscInt moving) {
  const PetscInt wall = moving - contact->surfaces.n;

  if (!MotionOf(contact, moving)->any) return PETSC_FALSE;
  if (wall < 0) return (PetscBool)(contact->surfaces.surface[moving].core < PETSC_MAX_REAL);
  return (PetscBool)(contact->walls.wall[wall].kind != WALL_PLANE && contact->walls.smallest > 0);
}

/* Has a cell swept anything since a time, or has anything that moves swept across it? */
static PetscBool CellIsBehind(const Look *look, PetscReal since, Bezier b0, Bezier b1) {
  const Contact *contact = look->contact;
  Look one = *look;

  one.moving = RESTING;
  if (Moves(b0, b1) && SweepIsBehind(&one, b0, b1, 0)) return PETSC_TRUE;
  for (one.moving = 0; one.moving < contact->surfaces.n + contact->walls.n; one.moving++)
    if (MaySweep(contact, one.moving) && IsSwept(&one, since, b0, b1)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* PassingTellSpace - as RodPassesWalls(), of a rod in space. */
PetscErrorCode PassingTellSpace(Rod rod, const Passing *cells, PetscBool *passes) {
  const Contact *contact = &rod->scene->contact;
  Look look = {.contact = contact};
  Bezier before, now;

  PetscFunctionBegin;
  look.deep =
      contact->diameter > 0 ? contact->diameter / 2 : rod_rule.lengths_behind * contact->tip;
  look.fine = look.deep / rod_rule.passing_parts;
  *passes = PETSC_FALSE;
  for (PetscInt k = 0; k < cells->n && !*passes; k++) {
    CurveOf(&cells->before[k], before);
    CurveOf(&cells->now[k], now);
    *passes =
        (PetscBool)(CurveIsBehind(&look, now, 0) || CellIsBehind(&look, cells->t0, before, now));
  }
  PetscFunctionReturn(0);
}
