/* What touches a rod, and where. */
#include "world/contact_push.h"
#include "base/vectors.h"

/*
  ContactSetFrame - tells contact how a rod in space stands to what is around it.

  lab          from the clamp's frame to the laboratory
  clamp_angle  by which the plane's walls have been turned back
  place        of the clamp in the laboratory
*/
void ContactSetFrame(Contact *self, const PetscReal lab[3][3], PetscReal clamp_angle,
                     const PetscReal place[3]) {
  const PetscReal c = PetscCosReal(clamp_angle), s = PetscSinReal(clamp_angle);

  for (int d = 0; d < 3; d++) self->place[d] = place[d];
  self->stand[0] = c * place[0] + s * place[1];
  self->stand[1] = -s * place[0] + c * place[1];
  self->stand[2] = place[2];

  for (int k = 0; k < 3; k++) {
    for (int d = 0; d < 3; d++) self->lab[d][k] = lab[d][k];
    self->upright[0][k] = c * lab[0][k] + s * lab[1][k];
    self->upright[1][k] = -s * lab[0][k] + c * lab[1][k];
    self->upright[2][k] = lab[2][k];
  }
}

/* A place of the clamp's frame in the laboratory, where surfaces are. */
static inline void ToLab(const Contact *self, const PetscReal x[3], PetscReal lab[3]) {
  for (int d = 0; d < 3; d++) lab[d] = Dot3(self->lab[d], x) + self->place[d];
}

/* ... in the frame of the walls of the plane. */
static inline void ToWalls(const Contact *self, const PetscReal x[3], PetscReal y[3]) {
  for (int d = 0; d < 3; d++) y[d] = Dot3(self->upright[d], x) + self->stand[d];
}

/* ContactToLab - a place of the clamp's frame in the laboratory. */
void ContactToLab(const Contact *self, const PetscReal x[3], PetscReal lab[3]) {
  ToLab(self, x, lab);
}

/* ContactToWalls - ... in the frame of the walls of the plane. */
void ContactToWalls(const Contact *self, const PetscReal x[3], PetscReal y[3]) {
  ToWalls(self, x, y);
}

/* ---- what touches ---- */

/* A rod begins at a wall if it is so near to it, over its diameter; the wall is then taken off by
   that part of it at most. */
static const PetscReal part_at_wall = 1e-6, part_of_stand_off = 0.01;

/* The velocity of a wall that moves at v and turns at spin where it touches, x - d n, and
     dv_w = spin x (dx - n (n.dx) - d H dx);
   frame: from the clamp's frame to that of v and spin. */
static void Moves(const PetscReal frame[3][3], const PetscReal v[3], const PetscReal spin[3],
                  PetscReal distance, Touch *t) {
  PetscReal turning[3];

  TurnBack3(frame, v, t->v);
  TurnBack3(frame, spin, turning);
  for (int c = 0; c < 3; c++) {
    PetscReal way[3], by[3];
    for (int d = 0; d < 3; d++)
      way[d] = (c == d) - t->normal[d] * t->normal[c] - distance * t->bend[d][c];
    Cross3(turning, way, by);
    for (int d = 0; d < 3; d++) t->v_x[d][c] = by[d];
  }
}

/* ... of a surface, seen from the place y of the laboratory. */
static void SurfaceMoves(const Contact *self, PetscInt which, const PetscReal y[3],
                         const SurfacePoint *point, Touch *t) {
  PetscReal foot[3], v[3], spin[3];

  for (int d = 0; d < 3; d++) foot[d] = y[d] - point->distance * point->normal[d];
  MotionVelocityAt(&self->surfaces.surface[which].motion, self->surfaces.time, foot, v, spin);
  Moves(self->lab, v, spin, point->distance, t);
}

/* What a surface is to the rod, as it looks from the place y of the laboratory. */
static void TouchOf(const Contact *self, PetscInt which, const PetscReal y[3],
                    const SurfacePoint *point, Touch *t) {
  PetscReal part[3][3];

  t->gap = point->distance + self->surfaces.surface[which].off - self->diameter / 2;
  t->friction = ContactSurfaceFriction(self, which);
  t->wall = which;
  t->again = PETSC_FALSE;
  t->steep = self->surfaces.surface[which].kind->known == SURFACE_ON_A_GRID
                 ? PetscSqrtReal(Dot3(point->normal, point->normal))
                 : 1;
  t->moves = self->surfaces.surface[which].motion.any;
  TurnBack3(self->lab, point->normal, t->normal);
  for (int d = 0; d < 3; d++) TurnBack3(self->lab, point->bend[d], part[d]);
  for (int c = 0; c < 3; c++) {
    PetscReal column[3];
    Column3(part[0], 3, c, column);
    for (int d = 0; d < 3; d++) t->bend[d][c] = ColumnDot3(self->lab[0], 3, d, column);
  }
  if (t->moves) SurfaceMoves(self, which, y, point, t);
}

static PetscInt TouchSurfaces(const Contact *self, const PetscReal x[3], Touch touch[]) {
  SurfacePoint point[MOST_SURFACES];
  PetscInt which[MOST_SURFACES], n;
  PetscReal y[3];

  ToLab(self, x, y);
  n = SurfacesNear(&self->surfaces, y, self->diameter / 2 + self->smooth, which, point);
  for (PetscInt k = 0; k < n; k++) TouchOf(self, which[k], y, &point[k], &touch[k]);
  return n;
}

/* A wall of the plane, which stands upright: dn = bend t (t.dx), t across n and x3. */
static void TouchWall(const Contact *self, const WallTouch *flat, Touch *touch) {
  const Wall *wall = &self->walls.wall[flat->wall];
  const Vector2 n = flat->normal;
  const PetscReal normal[3] = {n.x, n.y, 0}, across[3] = {-n.y, n.x, 0},
                  v[3] = {flat->v.x, flat->v.y, 0}, spin[3] = {0, 0, flat->spin};
  PetscReal t[3];

  touch->gap = flat->gap;
  touch->again = flat->again;
  touch->friction = ContactWallFriction(self, flat->wall);
  touch->wall = self->surfaces.n + flat->wall;
  touch->steep = 1;
  touch->moves = wall->motion.any;
  TurnBack3(self->upright, normal, touch->normal);
  TurnBack3(self->upright, across, t);
  for (int d = 0; d < 3; d++)
    for (int c = 0; c < 3; c++) touch->bend[d][c] = flat->bend * t[d] * t[c];
  if (touch->moves)
    Moves(self->upright, v, spin, flat->gap + self->diameter / 2 - wall->off, touch);
}

static PetscInt TouchUpright(const Contact *self, const PetscReal x[3], Touch touch[]) {
  WallTouch flat[MOST_WALL_TOUCHES];
  PetscReal y[3];
  PetscInt n;

  ToWalls(self, x, y);
  n = WallsTouch(&self->walls, y, self->diameter / 2, self->smooth, flat);
  for (PetscInt k = 0; k < n; k++) TouchWall(self, &flat[k], &touch[k]);
  return n;
}

/* ... of a rod in the plane, whose clamp's frame is the walls' own. */
static PetscInt TouchFlat(const Contact *self, const PetscReal x[3], Touch touch[]) {
  WallTouch flat[MOST_WALL_TOUCHES];
  const PetscInt n = WallsTouch(&self->walls, x, self->diameter / 2, self->smooth, flat);

  for (PetscInt k = 0; k < n; k++) {
    touch[k].gap = flat[k].gap;
    touch[k].again = flat[k].again;
    ContactFace(flat[k].normal, flat[k].bend, &touch[k]);
    touch[k].friction = ContactWallFriction(self, flat[k].wall);
    touch[k].wall = flat[k].wall;
    touch[k].moves = self->walls.wall[flat[k].wall].motion.any;
    Put2(flat[k].v, touch[k].v);
  }
  return n;
}

/* ContactTouches - the walls that press on a point of the rod; returns how many. */
PetscInt ContactTouches(int dims, const Contact *self, const PetscReal x[3],
                        Touch touch[MOST_TOUCHES]) {
  PetscInt n = 0;

  if (dims == 2) return TouchFlat(self, x, touch);
  if (self->surfaces.n) n = TouchSurfaces(self, x, touch);
  if (self->walls.n) n += TouchUpright(self, x, touch + n);
  return n;
}

/*
  ContactStandOff - takes walls at which the rod begins off by so much that contact, which sets in
  a little before surfaces meet, does not press there. Else a rod that lies on a table, as a user
  sets it up, would be pushed off with a force of usual size at once. (A clamp that is a little
  nearer or farther may be meant so, in balance with what presses there.) Behind ContactSetFrame()
  and ContactSetStiffness().

  off  the largest length by which one was
*/
void ContactStandOff(Contact *self, PetscReal *off) {
  const PetscReal most = part_of_stand_off * self->diameter, clamp[3] = {0, 0, 0};
  Touch touch[MOST_TOUCHES];
  PetscInt n;

  *off = 0;
  if (self->smooth > most) return; /* contact so soft that this would be another place */
  n = ContactTouches(3, self, clamp, touch);
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt flat = touch[k].wall - self->surfaces.n;
    PetscReal *by =
        flat >= 0 ? &self->walls.wall[flat].off : &self->surfaces.surface[touch[k].wall].off;
    if (PetscAbsReal(touch[k].gap) > part_at_wall * self->diameter) continue;
    *by = PetscMax(*by, self->smooth - touch[k].gap);
    *off = PetscMax(*off, *by);
  }
}

/* Is component d of what is turned into the clamp's frame a sum? */
static PetscBool Sums(const PetscReal turn[3][3], int d) {
  int parts = 0;

  for (int k = 0; k < 3; k++) parts += turn[k][d] != 0;
  return (PetscBool)(parts > 1);
}

/*
  ContactBlurs - is what walls push a rod with along d, an axis of the clamp's frame, known to
  round-off of the whole push only?

  So it is where it is summed up, by a turn between frames that are oblique to each other, and of
  surfaces that are made of points. Else it is 0 to the last digit where a mirror makes it 0, and
  where the place along d is small, it is as small, and has as many digits.
*/
PetscBool ContactBlurs(const Contact *self, int d) {
  if (self->walls.n && Sums(self->upright, d)) return PETSC_TRUE;
  if (self->surfaces.n && Sums(self->lab, d)) return PETSC_TRUE;
  for (PetscInt k = 0; k < self->surfaces.n; k++)
    if (self->surfaces.surface[k].kind->known != SURFACE_EXACT) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ContactGap - the smallest gap of a point of the rod to any wall, if that is below `within`; else
   that. */
PetscReal ContactGap(int dims, const Contact *self, const PetscReal x[3], PetscReal within) {
  const PetscReal half = self->diameter / 2;
  PetscReal y[3], gap = within;
  PetscInt which = -1;

  if (dims == 2) return WallsGapWithin(&self->walls, x, half, within);
  if (self->surfaces.n) {
    ToLab(self, x, y);
    gap = SurfacesDistance(&self->surfaces, y, within + half, &which) - half;
    if (which >= 0) gap = PetscMin(within, gap + self->surfaces.surface[which].off);
  }
  if (self->walls.n) {
    ToWalls(self, x, y);
    gap = PetscMin(gap, WallsGap(&self->walls, y, half));
  }
  return gap;
}

/* ---- what stands out ---- */

/* ContactRidgesNear - tells of all that stands out of walls and is nearer than `reach` to what
   holds four points of the clamp's frame, item by item, posts behind what stands out of surfaces;
   see BlocksNear(). */
void ContactRidgesNear(const Contact *self, const PetscReal x[4][3], PetscReal reach,
                       BlocksMeet meet, void *ctx) {
  Block place = BlockEmpty(3), flat = BlockEmpty(2);

  for (int k = 0; k < 4; k++) {
    PetscReal y[3];
    ToLab(self, x[k], y);
    BlockHold(3, &place, y);
    ToWalls(self, x[k], y);
    BlockHold(2, &flat, y);
  }
  if (self->surfaces.ridges) SurfacesRidgesNear(&self->surfaces, &place, reach, meet, ctx);
  if (self->walls.posts)
    BlocksNearBehind(self->walls.near_posts, self->surfaces.ridges, &flat, reach, meet, ctx);
  for (PetscInt k = self->walls.resting; k < self->walls.posts; k++)
    (void)meet(self->surfaces.ridges + k, reach, ctx);
}

static PetscBool PostTouch(const Contact *self, PetscInt item, const PetscReal x[3],
                           PetscReal within, Touch *touch) {
  const WallPost *post = &self->walls.post[item];
  WallTouch flat = {.wall = post->wall};
  PetscReal y[3], size;
  Vector2 way;

  ToWalls(self, x, y);
  way = Minus2(From2(y), WallsPostAt(&self->walls, item, self->walls.time));
  size = Size2(way);
  flat.gap = size - post->r - self->diameter / 2;
  if (size == 0 || flat.gap >= within) return PETSC_FALSE;
  flat.normal = Over2(way, size);
  flat.bend = 1 / size;
  if (item >= self->walls.resting)
    flat.v = WallVelocity(&self->walls, post->wall, Along2(From2(y), post->r - size, flat.normal),
                          &flat.spin);
  TouchWall(self, &flat, touch);
  return PETSC_TRUE;
}

/* ContactRidgeTouch - an item of what stands out, as seen from x; false: its gap is not below
   `within`, or it has nothing there. */
PetscBool ContactRidgeTouch(const Contact *self, PetscInt item, const PetscReal x[3],
                            PetscReal within, Touch *touch) {
  const PetscReal half = self->diameter / 2;
  SurfacePoint point;
  PetscReal y[3];

  if (item >= self->surfaces.ridges)
    return PostTouch(self, item - self->surfaces.ridges, x, within, touch);
  ToLab(self, x, y);
  if (!SurfacesRidgeAt(&self->surfaces, item, y, within + half, &point)) return PETSC_FALSE;
  TouchOf(self, self->surfaces.ridge[item].surface, y, &point, touch);
  return (PetscBool)(touch->gap < within);
}

/* ContactRidgeSmallest - the least radius of an item, with the rod's, and, of a sharp edge, what is
   met in its place where that is narrow, too. */
PetscReal ContactRidgeSmallest(const Contact *self, PetscInt item, PetscReal *beside) {
  const PetscReal half = self->diameter / 2;
  const SurfaceRidge *ridge;

  *beside = PETSC_MAX_REAL;
  if (item >= self->surfaces.ridges) return self->walls.post[item - self->surfaces.ridges].r + half;
  ridge = &self->surfaces.surface[self->surfaces.ridge[item].surface]
               .ridge[self->surfaces.ridge[item].ridge];
  *beside = ridge->beside + half;
  return ridge->smallest + half;
}
