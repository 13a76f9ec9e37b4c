/* What walls do to what touches them. */
#include "world/contact_push.h"
#include "base/vectors.h"

/* ---- what is remembered ---- */

/* ContactDual - where the dual of a touch is kept, among those of a place; NULL: nowhere. */
FrictionDual *ContactDual(int dims, const Touch *touch, FrictionDual duals[]) {
  if (!duals || touch->again) return NULL;
  if (dims == 2) return &duals[touch->wall];
  for (int k = 0; k < WALL_SLOTS; k++)
    if (duals[k].shift[SPIN] == (PetscReal)(touch->wall + 1)) return &duals[k];
  return NULL;
}

/* ContactDuals - of the duals of a place, dual, those of friction with walls, behind its first;
   NULL: there are none. */
FrictionDual *ContactDuals(int dims, const Contact *contact, const FrictionDual *dual) {
  const PetscBool rub = dims == 2 ? contact->walls.rub : ContactWallsRub(contact);

  return rub ? (FrictionDual *)dual + 1 : NULL;
}

/* ContactSlots - gives each of the touches of a point in space a slot, as far as there are any:
   that of another wall, which does not touch any more, is taken. */
void ContactSlots(int dims, PetscInt n, const Touch touch[], FrictionDual slots[]) {
  for (PetscInt k = 0; k < n && dims == 3; k++) {
    FrictionDual *take = NULL;
    if (touch[k].again || touch[k].friction == 0 || ContactDual(3, &touch[k], slots)) continue;
    for (int i = 0; i < WALL_SLOTS && !take; i++) {
      PetscBool used = PETSC_FALSE;
      for (PetscInt j = 0; j < n; j++)
        if (slots[i].shift[SPIN] == (PetscReal)(touch[j].wall + 1)) used = PETSC_TRUE;
      if (!used) take = &slots[i];
    }
    if (take) *take = (FrictionDual){.shift = {0, 0, 0, (PetscReal)(touch[k].wall + 1)}};
  }
}

/* ---- in the plane ---- */

/* The velocity against that of the wall. */
static Vector2 AgainstInPlane(const Touch *touch, const Rubbed *at) {
  return Minus2(From2(at->v), From2(touch->v));
}

/* The speed along a surface, t.(v - v_w) with t = n turned to the left. */
static PetscReal SlipInPlane(const Touch *touch, const Rubbed *at) {
  return Cross2(From2(touch->normal), AgainstInPlane(touch, at));
}

/* f = p n - mu p w t,   w = u/r, u = (v - v_w).t */
static void PushInPlane(const Contact *contact, const Touch *touch, const Rubbed *at,
                        const FrictionDual *dual, Push *push) {
  static const FrictionDual none = {.v = {0}};
  const PetscReal *n = touch->normal, mu = touch->friction, u = SlipInPlane(touch, at);
  PetscReal rubbing, slope, w = 0;

  push->normal = ContactPressure(contact, touch->gap, &slope);
  if (mu > 0) FrictionForce(1, &contact->rub, &u, dual ? dual : &none, &w);
  rubbing = mu * push->normal * w;
  push->couple = 0;
  Zero3(push->force);
  push->power = rubbing * u;
  push->force[0] = push->normal * n[0] + rubbing * n[1];
  push->force[1] = push->normal * n[1] - rubbing * n[0];
}

/* With dn = bend t (t.dx), dt = -bend n (t.dx), dp = p' n.dx:

     df = p' (n.dx)(n - mu w t) + p (dn - mu w dt) - mu p w' t (t.dv + (v - v_w).dt) */
static void SlopeInPlane(const Contact *contact, const Touch *touch, const Rubbed *at,
                         PetscBool fresh, FrictionDual *dual, Push *push) {
  enum { DIMS = 2 };
  const PetscReal *n = touch->normal, mu = touch->friction, bend = touch->curvature,
                  t[] = {-n[1], n[0]}, away = Dot2(AgainstInPlane(touch, at), From2(n));
  PetscReal u = SlipInPlane(touch, at), p, slope, w = 0, by_u = 0;
  FrictionDual own = {.v = {0}};

  p = ContactPressure(contact, touch->gap, &slope);
  if (!dual) dual = &own;
  if (mu > 0 && p > 0) {
    FrictionFollow(1, &contact->rub, &u, fresh, dual);
    w = ContactRub(contact, u, dual, &by_u);
  }
  for (int d = 0; d < DIMS; d++)
    for (int c = 0; c < DIMS; c++) {
      const PetscReal dn = bend * t[d] * t[c], dt = -bend * n[d] * t[c], du = -bend * away * t[c];
      push->x[d][c] = slope * n[c] * (n[d] - mu * w * t[d]) + p * (dn - mu * w * dt) -
                      mu * p * by_u * t[d] * du;
      push->W[d][c] = -mu * p * by_u * t[d] * t[c];
    }
}

/* ---- in space ---- */

/* Less steep a distance tells no direction, and what it tells with presses next to not at all. */
static const PetscReal least_steep = 1e-3;

/* The touch as friction sees it, with a normal of length 1: of n = g/|g|, dn = (dg - n (n.dg))/|g|.
 */
static const Touch *Faced(const Touch *touch, Touch *room) {
  if (touch->steep == 1) return touch;
  *room = *touch;
  for (int d = 0; d < 3; d++) room->normal[d] /= touch->steep;
  for (int c = 0; c < 3; c++) {
    PetscReal by[3], along;
    Column3(touch->bend[0], 3, c, by);
    along = Dot3(room->normal, by);
    for (int d = 0; d < 3; d++) room->bend[d][c] = (by[d] - room->normal[d] * along) / touch->steep;
  }
  return room;
}

/* Does it rub? */
static PetscBool Rubs(const Touch *touch, PetscReal p) {
  return (PetscBool)(touch->friction > 0 && p > 0 && touch->steep > least_steep);
}

/* v in the tangent plane of n */
static void Tangential(const PetscReal n[3], const PetscReal v[3], PetscReal t[3]) {
  const PetscReal along = Dot3(n, v);
  for (int d = 0; d < 3; d++) t[d] = v[d] - along * n[d];
}

/* The velocity against that of the wall. */
static void Against(const Touch *touch, const Rubbed *at, PetscReal v[3]) {
  for (int d = 0; d < 3; d++) v[d] = at->v[d] - (touch->moves ? touch->v[d] : 0);
}

/* a, and the slip u, whose fourth is 0. */
static void Slip(const Contact *contact, const Touch *touch, const Rubbed *at, PetscReal a[3],
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
static FrictionDual Seen(const Touch *touch, const FrictionDual *dual) {
  FrictionDual seen = {.v = {0}};

  if (!dual) return seen;
  seen = *dual;
  Tangential(touch->normal, dual->shift, seen.shift);
  seen.shift[3] = 0;
  return seen;
}

static void PushInSpace(const Contact *contact, const Touch *touch, const Rubbed *at,
                        const FrictionDual *kept, Push *push) {
  const PetscReal mu = touch->friction;
  PetscReal slope, a[3], u[4], w[4];
  Touch room;

  push->normal = ContactPressure(contact, touch->gap, &slope);
  push->couple = push->power = 0;
  for (int d = 0; d < 3; d++) push->force[d] = push->normal * touch->normal[d];
  push->normal *= touch->steep;
  if (!Rubs(touch, push->normal)) return;
  touch = Faced(touch, &room);
  const FrictionDual dual = Seen(touch, kept);
  Slip(contact, touch, at, a, u);
  FrictionForce(RUBS, &contact->rub, u, &dual, w);
  for (int d = 0; d < 3; d++) {
    push->force[d] -= mu * push->normal * w[d];
    push->couple -= mu * push->normal * w[d] * a[d];
    push->power += mu * push->normal * w[d] * u[d];
  }
}

/* How u changes with x and q, and a with them:
     du/dx = -(n.v) H - n (H v)^T - T dv_w/dx + omega da/dx,  da/dx = -D/2 [q] H,  da/dq = D/2 [n].
 */
static void SlipSlope(const Contact *contact, const Touch *touch, const Rubbed *at,
                      const PetscReal shift[3], PetscReal a_x[3][3], PetscReal a_q[3][3],
                      PetscReal u_x[3][3]) {
  const PetscReal *n = touch->normal, half = contact->diameter / 2;
  PetscReal v[3], along;

  Against(touch, at, v);
  for (int d = 0; d < 3; d++) v[d] += shift[d];
  along = Dot3(n, v);

  for (int c = 0; c < 3; c++) {
    const PetscReal e[3] = {c == 0, c == 1, c == 2};
    PetscReal H[3], turned[3], other[3], by_v;
    Column3(touch->bend[0], 3, c, H);
    by_v = Dot3(H, v);
    Cross3(at->q, H, turned);
    Cross3(n, e, other);
    for (int d = 0; d < 3; d++) {
      a_x[d][c] = -half * turned[d];
      a_q[d][c] = half * other[d];
      u_x[d][c] = -along * H[d] - n[d] * by_v + at->spin * a_x[d][c];
    }
    if (touch->moves) {
      PetscReal moved[3], slips[3];
      Column3(touch->v_x[0], 3, c, moved);
      Tangential(n, moved, slips);
      for (int d = 0; d < 3; d++) u_x[d][c] -= slips[d];
    }
  }
}

/* Adds friction and its derivatives, with S = dw/du,
     df = -mu (dp w + p S du),   d(a.f) = a.df - mu p w.da;
   p the force along the normal, p_x its derivatives. */
static void RubSlope(const Contact *contact, const Touch *touch, const Rubbed *at, PetscBool fresh,
                     FrictionDual *kept, PetscReal p, const PetscReal p_x[3], Push *push) {
  const PetscReal mu = touch->friction, *n = touch->normal;
  FrictionDual dual = Seen(touch, kept);
  PetscReal a[3], u[4], w[4], S[4][4], a_x[3][3], a_q[3][3], u_x[3][3];

  Slip(contact, touch, at, a, u);
  SlipSlope(contact, touch, at, dual.shift, a_x, a_q, u_x);
  FrictionLinearise(RUBS, &contact->rub, u, fresh, &dual, S);
  FrictionForce(RUBS, &contact->rub, u, &dual, w);
  for (int d = 0; d < 4 && kept; d++) {
    kept->v[d] = dual.v[d];
    kept->w[d] = dual.w[d];
  }
  for (int d = 0; d < 3; d++) {
    const PetscReal normal = Dot3(S[d], n);
    for (int c = 0; c < 3; c++) {
      const PetscReal by_x = ColumnDot3(u_x[0], 3, c, S[d]),
                      by_q = at->spin * ColumnDot3(a_q[0], 3, c, S[d]);
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

/* Of the normal part d(p n) = p' n (n.dx) + p H dx. */
static void SlopeInSpace(const Contact *contact, const Touch *touch, const Rubbed *at,
                         PetscBool fresh, FrictionDual *dual, Push *push) {
  const PetscReal *n = touch->normal;
  PetscReal slope, p_x[3], p = ContactPressure(contact, touch->gap, &slope);
  const Touch *given;
  Touch room;

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

/* What holds a place, moved by its slip at one wall; how fast it creeps. */
static PetscReal HoldInSpace(const Contact *contact, const Touch *touch, const Rubbed *at,
                             PetscReal seen, PetscReal hold, FrictionDual *kept) {
  FrictionDual dual;
  PetscReal speed, a[3], u[4];
  Touch room;

  touch = Faced(touch, &room);
  dual = Seen(touch, kept);
  Slip(contact, touch, at, a, u);
  speed = FrictionHold(RUBS, u, seen, hold, &dual);
  for (int d = 0; d < 3; d++) kept->shift[d] = dual.shift[d];
  return speed;
}

/* ---- in both ---- */

/* ContactPush - what a wall does to a point of the rod; of the derivatives see ContactPushSlope().
   dual: as ContactDual() has it. */
void ContactPush(int dims, const Contact *contact, const Touch *touch, const Rubbed *at,
                 const FrictionDual *dual, Push *push) {
  (dims == 2 ? PushInPlane : PushInSpace)(contact, touch, at, dual, push);
}

/* ContactPushSlope - the derivatives of force and couple by x, q, v and spin, the dual brought up
   to the present slip first (fresh: a Newton solve begins). In the plane those by x and v, of the
   force. */
void ContactPushSlope(int dims, const Contact *contact, const Touch *touch, const Rubbed *at,
                      PetscBool fresh, FrictionDual *dual, Push *push) {
  (dims == 2 ? SlopeInPlane : SlopeInSpace)(contact, touch, at, fresh, dual, push);
}

/* ContactPushAll - adds to f, times `part`, what all walls push a place with, and in space the
   couple about its tangent; returns the power of those that move, likewise. dual: as ContactDuals()
   has it. */
PetscReal ContactPushAll(int dims, const Contact *contact, const Rubbed *at,
                         const FrictionDual *dual, PetscReal part, PetscReal f[RUBS]) {
  FrictionDual *duals = ContactDuals(dims, contact, dual);
  Touch touch[MOST_TOUCHES];
  PetscInt n = ContactTouches(dims, contact, at->x, touch);
  PetscReal moved = 0;
  Push push;

  for (PetscInt k = 0; k < n; k++) {
    ContactPush(dims, contact, &touch[k], at, ContactDual(dims, &touch[k], duals), &push);
    for (int d = 0; d < dims; d++) f[d] += part * push.force[d];
    if (dims == 3) f[SPIN] += part * push.couple;
    if (touch[k].moves) moved += part * Dot3(push.force, touch[k].v);
  }
  return moved;
}

/* ContactHoldTouch - moves what holds a place of the rod at one wall (exact Coulomb friction), over
   a shift of `hold` at most; returns the speed at which it creeps, which counts the less the less
   it is pressed. */
PetscReal ContactHoldTouch(int dims, const Contact *contact, const Touch *touch, const Rubbed *at,
                           PetscReal seen, PetscReal hold, FrictionDual *dual) {
  PetscReal slope, speed, u;
  const PetscReal p = touch->steep * ContactPressure(contact, touch->gap, &slope),
                  mu = touch->friction;

  if (!dual || p == 0 || mu == 0) return 0;
  if (dims == 2) {
    u = SlipInPlane(touch, at);
    speed = FrictionHold(1, &u, seen, hold, dual);
  } else
    speed = HoldInSpace(contact, touch, at, seen, hold, dual);
  return PetscMin(1, mu * p) * speed;
}

/* ContactHold - the same at all walls that a place touches. dual: as ContactDuals() has it. */
PetscReal ContactHold(int dims, const Contact *contact, const Rubbed *at, PetscReal seen,
                      FrictionDual *dual) {
  FrictionDual *duals = ContactDuals(dims, contact, dual);
  Touch touch[MOST_TOUCHES];
  PetscReal creep = 0;
  PetscInt n;

  if (!duals) return 0;
  n = ContactTouches(dims, contact, at->x, touch);
  ContactSlots(dims, n, touch, duals);
  for (PetscInt k = 0; k < n; k++)
    creep =
        LargerOf(creep, ContactHoldTouch(dims, contact, &touch[k], at, seen, friction_hold_contact,
                                         ContactDual(dims, &touch[k], duals)));
  return creep;
}
