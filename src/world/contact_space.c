#include "world/contact_space.h"
#include "base/vectors.h"

/* y = M^T x */
static void TurnBack(const PetscReal M[3][3], const PetscReal x[3], PetscReal y[3]) {
  for (int d = 0; d < 3; d++) y[d] = M[0][d] * x[0] + M[1][d] * x[1] + M[2][d] * x[2];
}

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
     dv_w = spin x (dx - n (n.dx) - d H dx). */
static void Moves(const Contact *self, PetscInt which, const PetscReal y[3],
                  const SurfacePoint *point, Touch3 *t) {
  PetscReal foot[3], v[3], spin[3], turning[3];

  for (int d = 0; d < 3; d++) foot[d] = y[d] - point->distance * point->normal[d];
  SurfacesVelocity(&self->surfaces, which, foot, v, spin);
  TurnBack(self->lab, v, t->v);
  TurnBack(self->lab, spin, turning);
  for (int c = 0; c < 3; c++) {
    PetscReal way[3], by[3];
    for (int d = 0; d < 3; d++)
      way[d] = (c == d) - t->normal[d] * t->normal[c] - point->distance * t->bend[d][c];
    Cross3(turning, way, by);
    for (int d = 0; d < 3; d++) t->v_x[d][c] = by[d];
  }
}

/* What a surface is to the rod, as it looks from the place y of the laboratory. */
static void TouchOf(const Contact *self, PetscInt which, const PetscReal y[3],
                    const SurfacePoint *point, Touch3 *t) {
  PetscReal part[3][3];

  t->gap = point->distance + self->surfaces.surface[which].off - self->diameter / 2;
  t->friction = ContactSurfaceFriction(self, which);
  t->wall = which;
  t->again = PETSC_FALSE;
  t->steep = self->surfaces.surface[which].kind->known == SURFACE_ON_A_GRID
                 ? PetscSqrtReal(Dot3(point->normal, point->normal))
                 : 1;
  t->moves = self->surfaces.surface[which].motion.any;
  TurnBack(self->lab, point->normal, t->normal);
  for (int d = 0; d < 3; d++) TurnBack(self->lab, point->bend[d], part[d]);
  for (int d = 0; d < 3; d++)
    for (int c = 0; c < 3; c++)
      t->bend[d][c] = self->lab[0][d] * part[0][c] + self->lab[1][d] * part[1][c] +
                      self->lab[2][d] * part[2][c];
  if (t->moves) Moves(self, which, y, point, t);
}

static PetscInt TouchSurfaces(const Contact *self, const PetscReal x[3], Touch3 touch[]) {
  SurfacePoint point[MOST_SURFACES];
  PetscInt which[MOST_SURFACES], n;
  PetscReal y[3];

  ToLab(self, x, y);
  n = SurfacesNear(&self->surfaces, y, self->diameter / 2 + self->smooth, which, point);
  for (PetscInt k = 0; k < n; k++) TouchOf(self, which[k], y, &point[k], &touch[k]);
  return n;
}

/* A wall of the plane, which stands upright, of this normal and bend: dn = bend t (t.dx), t across
   n and x3. */
static void TouchWall(const Contact *self, PetscInt wall, const PetscReal n[2], PetscReal bend,
                      Touch3 *touch) {
  const PetscReal normal[3] = {n[0], n[1], 0}, across[3] = {-n[1], n[0], 0};
  PetscReal t[3];

  touch->friction = ContactWallFriction(self, wall);
  touch->wall = self->surfaces.n + wall;
  touch->steep = 1;
  touch->moves = PETSC_FALSE;
  TurnBack(self->upright, normal, touch->normal);
  TurnBack(self->upright, across, t);
  for (int d = 0; d < 3; d++)
    for (int c = 0; c < 3; c++) touch->bend[d][c] = bend * t[d] * t[c];
}

static PetscInt TouchUpright(const Contact *self, const PetscReal x[3], Touch3 touch[]) {
  Touch flat[MOST_TOUCHES];
  PetscReal y[3];
  PetscInt n;

  ToWalls(self, x, y);
  n = WallsTouch(&self->walls, y, self->diameter / 2, self->smooth, flat);
  for (PetscInt k = 0; k < n; k++) {
    touch[k].gap = flat[k].gap;
    touch[k].again = flat[k].again;
    TouchWall(self, flat[k].wall, flat[k].normal, flat[k].bend, &touch[k]);
  }
  return n;
}

/* ContactTouches3 - the walls that press on a point of the rod; returns how many. */
PetscInt ContactTouches3(const Contact *self, const PetscReal x[3], Touch3 touch[MOST_TOUCHES3]) {
  PetscInt n = 0;

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
  Touch3 touch[MOST_TOUCHES3];
  PetscInt n;

  *off = 0;
  if (self->smooth > most) return; /* contact so soft that this would be another place */
  n = ContactTouches3(self, clamp, touch);
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

/* ContactGap3 - the smallest gap of a point of the rod to any wall, if that is below `within`; else
   that. */
PetscReal ContactGap3(const Contact *self, const PetscReal x[3], PetscReal within) {
  const PetscReal half = self->diameter / 2;
  PetscReal y[3], gap = within;
  PetscInt which = -1;

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
}

static PetscBool PostTouch(const Contact *self, const WallPost *post, const PetscReal x[3],
                           PetscReal within, Touch3 *touch) {
  PetscReal y[3], n[2], size;

  ToWalls(self, x, y);
  for (int d = 0; d < 2; d++) n[d] = y[d] - post->at[d];
  size = hypot(n[0], n[1]);
  touch->gap = size - post->r - self->diameter / 2;
  if (size == 0 || touch->gap >= within) return PETSC_FALSE;
  for (int d = 0; d < 2; d++) n[d] /= size;
  touch->again = PETSC_FALSE;
  TouchWall(self, post->wall, n, 1 / size, touch);
  return PETSC_TRUE;
}

/* ContactRidgeTouch - an item of what stands out, as seen from x; false: its gap is not below
   `within`, or it has nothing there. */
PetscBool ContactRidgeTouch(const Contact *self, PetscInt item, const PetscReal x[3],
                            PetscReal within, Touch3 *touch) {
  const PetscReal half = self->diameter / 2;
  SurfacePoint point;
  PetscReal y[3];

  if (item >= self->surfaces.ridges)
    return PostTouch(self, &self->walls.post[item - self->surfaces.ridges], x, within, touch);
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

/* ---- the law ---- */

/* ContactSlot - where the dual of a touch is kept; NULL: nowhere. */
FrictionDual4 *ContactSlot(const Touch3 *touch, FrictionDual4 slots[]) {
  if (!slots || touch->again) return NULL;
  for (int k = 0; k < WALL_SLOTS; k++)
    if (slots[k].shift[3] == (PetscReal)(touch->wall + 1)) return &slots[k];
  return NULL;
}

/* ContactSlots - gives each of the touches of a point a slot, as far as there are any: that of
   another wall, which does not touch any more, is taken. */
void ContactSlots(PetscInt n, const Touch3 touch[], FrictionDual4 slots[]) {
  for (PetscInt k = 0; k < n; k++) {
    FrictionDual4 *take = NULL;
    if (touch[k].again || touch[k].friction == 0 || ContactSlot(&touch[k], slots)) continue;
    for (int i = 0; i < WALL_SLOTS && !take; i++) {
      PetscBool used = PETSC_FALSE;
      for (PetscInt j = 0; j < n; j++)
        if (slots[i].shift[3] == (PetscReal)(touch[j].wall + 1)) used = PETSC_TRUE;
      if (!used) take = &slots[i];
    }
    if (take) *take = (FrictionDual4){.shift = {0, 0, 0, (PetscReal)(touch[k].wall + 1)}};
  }
}

/* Less steep a distance tells no direction, and what it tells with presses next to not at all. */
static const PetscReal least_steep = 1e-3;

/* The touch as friction sees it, with a normal of length 1: of n = g/|g|, dn = (dg - n (n.dg))/|g|.
 */
static const Touch3 *Faced(const Touch3 *touch, Touch3 *room) {
  if (touch->steep == 1) return touch;
  *room = *touch;
  for (int d = 0; d < 3; d++) room->normal[d] /= touch->steep;
  for (int c = 0; c < 3; c++) {
    const PetscReal by[3] = {touch->bend[0][c], touch->bend[1][c], touch->bend[2][c]},
                    along = Dot3(room->normal, by);
    for (int d = 0; d < 3; d++) room->bend[d][c] = (by[d] - room->normal[d] * along) / touch->steep;
  }
  return room;
}

/* Does it rub? */
static PetscBool Rubs(const Touch3 *touch, PetscReal p) {
  return (PetscBool)(touch->friction > 0 && p > 0 && touch->steep > least_steep);
}

/* v in the tangent plane of n */
static void Tangential(const PetscReal n[3], const PetscReal v[3], PetscReal t[3]) {
  const PetscReal along = Dot3(n, v);
  for (int d = 0; d < 3; d++) t[d] = v[d] - along * n[d];
}

/* The velocity against that of the wall. */
static void Against(const Touch3 *touch, const Rubbed *at, PetscReal v[3]) {
  for (int d = 0; d < 3; d++) v[d] = at->v[d] - (touch->moves ? touch->v[d] : 0);
}

/* a, and the slip u, whose fourth is 0. */
static void Slip(const Contact *contact, const Touch3 *touch, const Rubbed *at, PetscReal a[3],
                 PetscReal u[4]) {
  PetscReal v[3];

  Against(touch, at, v);
  Cross3(at->q, touch->normal, a);
  Tangential(touch->normal, v, u);
  for (int d = 0; d < 3; d++) {
    a[d] *= -contact->diameter / 2;
    u[d] += at->spin * a[d];
  }
  u[3] = 0;
}

/* The dual as the tangent plane at present sees it. */
static FrictionDual4 Seen(const Touch3 *touch, const FrictionDual4 *dual) {
  FrictionDual4 seen = {.v = {0}};

  if (!dual) return seen;
  seen = *dual;
  Tangential(touch->normal, dual->shift, seen.shift);
  seen.shift[3] = 0;
  return seen;
}

/* ContactPush3 - what a wall does to a point of the rod; of the derivatives see
   ContactPushSlope3(). slots: NULL, of a point of which nothing is remembered. */
void ContactPush3(const Contact *contact, const Touch3 *touch, const Rubbed *at,
                  const FrictionDual4 slots[], Push3 *push) {
  const PetscReal mu = touch->friction;
  PetscReal slope, a[3], u[4], w[4];
  Touch3 room;

  push->normal = ContactPressure(contact, touch->gap, &slope);
  push->couple = push->power = 0;
  for (int d = 0; d < 3; d++) push->force[d] = push->normal * touch->normal[d];
  push->normal *= touch->steep;
  if (!Rubs(touch, push->normal)) return;
  touch = Faced(touch, &room);
  const FrictionDual4 dual = Seen(touch, ContactSlot(touch, (FrictionDual4 *)slots));
  Slip(contact, touch, at, a, u);
  FrictionForce4(&contact->rub, u, &dual, w);
  for (int d = 0; d < 3; d++) {
    push->force[d] -= mu * push->normal * w[d];
    push->couple -= mu * push->normal * w[d] * a[d];
    push->power += mu * push->normal * w[d] * u[d];
  }
}

/* How u changes with x and q, and a with them:
     du/dx = -(n.v) H - n (H v)^T - T dv_w/dx + omega da/dx,  da/dx = -D/2 [q] H,  da/dq = D/2 [n].
 */
static void SlipSlope(const Contact *contact, const Touch3 *touch, const Rubbed *at,
                      const PetscReal shift[3], PetscReal a_x[3][3], PetscReal a_q[3][3],
                      PetscReal u_x[3][3]) {
  const PetscReal *n = touch->normal, half = contact->diameter / 2;
  PetscReal v[3], along;

  Against(touch, at, v);
  for (int d = 0; d < 3; d++) v[d] += shift[d];
  along = Dot3(n, v);

  for (int c = 0; c < 3; c++) {
    const PetscReal H[3] = {touch->bend[0][c], touch->bend[1][c], touch->bend[2][c]},
                    e[3] = {c == 0, c == 1, c == 2}, by_v = Dot3(H, v);
    PetscReal turned[3], other[3];
    Cross3(at->q, H, turned);
    Cross3(n, e, other);
    for (int d = 0; d < 3; d++) {
      a_x[d][c] = -half * turned[d];
      a_q[d][c] = half * other[d];
      u_x[d][c] = -along * H[d] - n[d] * by_v + at->spin * a_x[d][c];
    }
    if (touch->moves) {
      const PetscReal moved[3] = {touch->v_x[0][c], touch->v_x[1][c], touch->v_x[2][c]};
      PetscReal slips[3];
      Tangential(n, moved, slips);
      for (int d = 0; d < 3; d++) u_x[d][c] -= slips[d];
    }
  }
}

/* Adds friction and its derivatives, with S = dw/du,
     df = -mu (dp w + p S du),   d(a.f) = a.df - mu p w.da;
   p the force along the normal, p_x its derivatives. */
static void RubSlope(const Contact *contact, const Touch3 *touch, const Rubbed *at, PetscBool fresh,
                     FrictionDual4 *kept, PetscReal p, const PetscReal p_x[3], Push3 *push) {
  const PetscReal mu = touch->friction, *n = touch->normal;
  FrictionDual4 dual = Seen(touch, kept);
  PetscReal a[3], u[4], w[4], S[4][4], a_x[3][3], a_q[3][3], u_x[3][3];

  Slip(contact, touch, at, a, u);
  SlipSlope(contact, touch, at, dual.shift, a_x, a_q, u_x);
  FrictionLinearise4(&contact->rub, u, fresh, &dual, S);
  FrictionForce4(&contact->rub, u, &dual, w);
  for (int d = 0; d < 4 && kept; d++) {
    kept->v[d] = dual.v[d];
    kept->w[d] = dual.w[d];
  }
  for (int d = 0; d < 3; d++) {
    const PetscReal normal = Dot3(S[d], n);
    for (int c = 0; c < 3; c++) {
      const PetscReal by_x = S[d][0] * u_x[0][c] + S[d][1] * u_x[1][c] + S[d][2] * u_x[2][c],
                      by_q = at->spin *
                             (S[d][0] * a_q[0][c] + S[d][1] * a_q[1][c] + S[d][2] * a_q[2][c]);
      push->x[d][c] -= mu * (p_x[c] * w[d] + p * by_x);
      push->q[d][c] -= mu * p * by_q;
      push->W[d][c] -= mu * p * (S[d][c] - normal * n[c]);
      push->x[3][c] -= mu * (p_x[c] * w[d] * a[d] + p * (a[d] * by_x + w[d] * a_x[d][c]));
      push->q[3][c] -= mu * p * (a[d] * by_q + w[d] * a_q[d][c]);
      push->W[3][c] -= mu * p * a[d] * (S[d][c] - normal * n[c]);
    }
    push->W[d][3] -= mu * p * Dot3(S[d], a);
    push->W[3][3] -= mu * p * a[d] * Dot3(S[d], a);
  }
}

/*
  ContactPushSlope3 - the derivatives of force and couple by x, q, v and spin, the dual brought up
  to the present slip first (fresh: a Newton solve begins); dual NULL: there is none. Of the normal
  part

    d(p n) = p' n (n.dx) + p H dx
*/
void ContactPushSlope3(const Contact *contact, const Touch3 *touch, const Rubbed *at,
                       PetscBool fresh, FrictionDual4 *dual, Push3 *push) {
  const PetscReal *n = touch->normal;
  PetscReal slope, p_x[3], p = ContactPressure(contact, touch->gap, &slope);
  const Touch3 *given;
  Touch3 room;

  for (int d = 0; d < 4; d++) {
    for (int c = 0; c < 3; c++) {
      push->x[d][c] = d < 3 ? slope * n[d] * n[c] + p * touch->bend[d][c] : 0;
      push->q[d][c] = 0;
    }
    for (int c = 0; c < 4; c++) push->W[d][c] = 0;
  }
  if (!Rubs(touch, p)) return;
  for (int c = 0; c < 3; c++) p_x[c] = slope * n[c] * touch->steep;
  n = (touch = Faced(given = touch, &room))->normal;
  for (int c = 0; c < 3 && touch != given; c++)
    for (int d = 0; d < 3; d++) p_x[c] += p * n[d] * given->bend[d][c];
  RubSlope(contact, touch, at, fresh, dual, p * touch->steep, p_x, push);
}

/* ContactHoldTouch3 - moves what holds a place of the rod at one wall, over a shift of `hold` at
   most; returns the speed at which it creeps, as ContactHold(). */
PetscReal ContactHoldTouch3(const Contact *contact, const Touch3 *touch, const Rubbed *at,
                            PetscReal seen, PetscReal hold, FrictionDual4 slots[]) {
  FrictionDual4 *kept = ContactSlot(touch, slots), dual;
  PetscReal slope, speed, a[3], u[4];
  const PetscReal p = touch->steep * ContactPressure(contact, touch->gap, &slope),
                  mu = touch->friction;
  Touch3 room;

  if (!kept || p == 0) return 0;
  touch = Faced(touch, &room);
  dual = Seen(touch, kept);
  Slip(contact, touch, at, a, u);
  speed = FrictionDualHold4(u, seen, hold, &dual);
  for (int d = 0; d < 3; d++) kept->shift[d] = dual.shift[d];
  return PetscMin(1, mu * p) * speed;
}

/* ContactHold3 - moves what holds a point that sticks to walls (exact Coulomb friction); returns
   the speed at which it creeps, as ContactHold(). */
PetscReal ContactHold3(const Contact *contact, const Rubbed *at, PetscReal seen,
                       FrictionDual4 slots[]) {
  Touch3 touch[MOST_TOUCHES3];
  PetscInt n = ContactTouches3(contact, at->x, touch);
  PetscReal creep = 0;

  if (!n) return 0;
  ContactSlots(n, touch, slots);
  for (PetscInt k = 0; k < n; k++)
    creep = LargerOf(creep,
                     ContactHoldTouch3(contact, &touch[k], at, seen, friction_hold_contact, slots));
  return creep;
}
