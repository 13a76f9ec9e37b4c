/* Walls that touch a rod, and what they do to it: the law is that of contact.h. Of a rod in the
   plane they are those of walls.h; of one in space surfaces (surfaces.h), and the others, too,
   which stand upright along x3 of the laboratory.

   Friction acts where the rod's surface touches, at r = -D/2 n from its centre line, that slips by
   at u = T (v - v_w + omega q x r) = T (v - v_w) + omega a,   T = I - n n^T,   a = -D/2 q x n,
   omega the spin of the material about its tangent q. v_w is the velocity of the wall there. So
   friction bears the couple a.f about q, and a rod that is pushed across a plane rolls. (That q
   itself turns is left out of the slip, as is the couple across q: both are of the order of D times
   a bend, and there is none of them in the plane.)

     f = p n - mu p w,   w = u/r, r = sqrt(u^2 + beta).

   In the plane nothing spins, and u is a number, along t, n turned to the left.

   Where the distance is interpolated its gradient is not quite of length 1: n is that gradient in
   the first term, for p n is to have an energy, and what friction goes by is the normal of length 1
   and the force p |n|; else the rod would rub against being pressed in. */
#ifndef TENDRIL_CONTACT_PUSH_H
#define TENDRIL_CONTACT_PUSH_H

#include "base/vectors.h"
#include "world/contact.h"

/* What touches a point of the rod, in the clamp's frame. */
typedef struct {
  PetscReal gap, normal[3], bend[3][3]; /* n, dn = bend dx */
  PetscReal curvature;                  /* in the plane: bend = curvature t t^T, t across n */
  PetscReal steep; /* |n|: 1, but where the distance is interpolated, which p n is the slope of */
  PetscReal friction;
  PetscBool moves;           /* the wall does, and then: */
  PetscReal v[3], v_x[3][3]; /* its velocity where it touches, and how that changes with x */
  PetscInt wall;             /* a surface, or behind these a wall of the plane */
  PetscBool again;           /* another piece of the wall before it */
} Touch;

enum { MOST_TOUCHES = MOST_SURFACES + MOST_WALL_TOUCHES };

/* A point of the rod: tangent, velocity of the material, spin about the tangent. */
typedef struct {
  const PetscReal *x, *q, *v;
  PetscReal spin;
} Rubbed;

/* What a wall does to it: force and couple about the tangent, per length (to the tip: times l),
   with their derivatives by x, q, v and, last of W, the spin. */
typedef struct {
  PetscReal force[3], couple;
  PetscReal normal; /* p |n| */
  PetscReal power;  /* lost to friction */
  PetscReal x[RUBS][3], q[RUBS][3], W[RUBS][RUBS];
} Push;

/* How a wall of the plane faces a rod in the plane: all but how it moves in that. */
static inline void ContactFace(Vector2 n, PetscReal curvature, Touch *touch) {
  const PetscReal t[3] = {-n.y, n.x, 0};

  Zero3(touch->v);
  Zero3(touch->normal);
  Put2(n, touch->normal);
  touch->curvature = curvature;
  touch->steep = 1;
  for (int d = 0; d < 3; d++)
    for (int c = 0; c < 3; c++) touch->bend[d][c] = curvature * t[d] * t[c];
}

/* Does anything stand out of walls, so that a thin rod of few cells may need feet? */
static inline PetscBool ContactHasRidges(const Contact *contact) {
  return (PetscBool)(contact->surfaces.ridges > 0 || contact->walls.posts > 0);
}

/* What Newton's method remembers of friction with walls is kept for each of them in the plane; in
   space by so many at a point: of more there is friction, but it is held less well. The last of a
   dual's shift says there of which wall it is, its number + 1; 0: of none. */
enum { WALL_SLOTS = 4 };

/* contact_touch.c; dims: 2 in the plane, 3 in space */
void ContactSetFrame(Contact *contact, const PetscReal lab[3][3], PetscReal clamp_angle,
                     const PetscReal place[3]);
void ContactToLab(const Contact *contact, const PetscReal x[3], PetscReal lab[3]);
void ContactToWalls(const Contact *contact, const PetscReal x[3], PetscReal y[3]);
void ContactStandOff(Contact *contact, PetscReal *off);
PetscInt ContactTouches(int dims, const Contact *contact, const PetscReal x[3],
                        Touch touch[MOST_TOUCHES]);
PetscBool ContactBlurs(const Contact *contact, int d);
PetscReal ContactGap(int dims, const Contact *contact, const PetscReal x[3], PetscReal within);
void ContactRidgesNear(const Contact *contact, const PetscReal x[4][3], PetscReal reach,
                       BlocksMeet meet, void *ctx);
PetscBool ContactRidgeTouch(const Contact *contact, PetscInt item, const PetscReal x[3],
                            PetscReal within, Touch *touch);
PetscReal ContactRidgeSmallest(const Contact *contact, PetscInt item, PetscReal *beside);

/* contact_push.c */
void ContactSlots(int dims, PetscInt n, const Touch touch[], FrictionDual duals[]);
FrictionDual *ContactDual(int dims, const Touch *touch, FrictionDual duals[]);
void ContactPush(int dims, const Contact *contact, const Touch *touch, const Rubbed *at,
                 const FrictionDual *dual, Push *push);
void ContactPushSlope(int dims, const Contact *contact, const Touch *touch, const Rubbed *at,
                      PetscBool fresh, FrictionDual *dual, Push *push);
FrictionDual *ContactDuals(int dims, const Contact *contact, const FrictionDual *dual);
PetscReal ContactPushAll(int dims, const Contact *contact, const Rubbed *at,
                         const FrictionDual *dual, PetscReal part, PetscReal f[RUBS]);
PetscReal ContactHoldTouch(int dims, const Contact *contact, const Touch *touch, const Rubbed *at,
                           PetscReal seen, PetscReal hold, FrictionDual *dual);
PetscReal ContactHold(int dims, const Contact *contact, const Rubbed *at, PetscReal seen,
                      FrictionDual *dual);

#endif
