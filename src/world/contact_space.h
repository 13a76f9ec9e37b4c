/* Contact of a rod in space with walls: the law is that of contact.h, the walls are surfaces
   (surfaces.h), and those of the plane (walls.h), which stand upright along x3 of the laboratory.

   Friction acts where the rod's surface touches, at r = -D/2 n from its centre line, that slips by
   at u = T (v - v_w + omega q x r) = T (v - v_w) + omega a,   T = I - n n^T,   a = -D/2 q x n,
   omega the spin of the material about its tangent q. v_w is the velocity of the wall there. So
   friction bears the couple a.f about q, and a rod that is pushed across a plane rolls. (That q
   itself turns is left out of the slip, as is the couple across q: both are of the order of D times
   a bend, and there is none of them in the plane.)

     f = p n - mu p w,   w = u/r, r = sqrt(u^2 + beta).

   Where the distance is interpolated its gradient is not quite of length 1: n is that gradient in
   the first term, for p n is to have an energy, and what friction goes by is the normal of length 1
   and the force p |n|; else the rod would rub against being pressed in. */
#ifndef TENDRIL_CONTACT_SPACE_H
#define TENDRIL_CONTACT_SPACE_H

#include "world/contact.h"

/* What touches a point of the rod, in the clamp's frame. */
typedef struct {
  PetscReal gap, normal[3], bend[3][3]; /* n, dn = bend dx */
  PetscReal steep; /* |n|: 1, but where the distance is interpolated, which p n is the slope of */
  PetscReal friction;
  PetscBool moves;           /* the wall does, and then: */
  PetscReal v[3], v_x[3][3]; /* its velocity where it touches, and how that changes with x */
  PetscInt wall;             /* a surface, or behind these a wall of the plane */
  PetscBool again;           /* another piece of the wall before it */
} Touch3;

enum { MOST_TOUCHES3 = MOST_SURFACES + MOST_TOUCHES };

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
  PetscReal x[4][3], q[4][3], W[4][4];
} Push3;

/* Does anything stand out of walls, so that a thin rod of few cells may need feet? */
static inline PetscBool ContactHasRidges(const Contact *contact) {
  return (PetscBool)(contact->surfaces.ridges > 0 || contact->walls.posts > 0);
}

/* What Newton's method remembers of friction with walls is kept by this many of them at a point; of
   more there is friction, but it is held less well. The last of a dual's shift says of which wall
   it is, its number + 1; 0: of none. */
enum { WALL_SLOTS = 4 };

void ContactSetFrame(Contact *contact, const PetscReal lab[3][3], PetscReal clamp_angle,
                     const PetscReal place[3]);
void ContactToLab(const Contact *contact, const PetscReal x[3], PetscReal lab[3]);
void ContactToWalls(const Contact *contact, const PetscReal x[3], PetscReal y[3]);
void ContactStandOff(Contact *contact, PetscReal *off);
PetscInt ContactTouches3(const Contact *contact, const PetscReal x[3], Touch3 touch[MOST_TOUCHES3]);
PetscBool ContactBlurs(const Contact *contact, int d);
PetscReal ContactGap3(const Contact *contact, const PetscReal x[3], PetscReal within);
void ContactRidgesNear(const Contact *contact, const PetscReal x[4][3], PetscReal reach,
                       BlocksMeet meet, void *ctx);
PetscBool ContactRidgeTouch(const Contact *contact, PetscInt item, const PetscReal x[3],
                            PetscReal within, Touch3 *touch);
PetscReal ContactRidgeSmallest(const Contact *contact, PetscInt item, PetscReal *beside);
void ContactPush3(const Contact *contact, const Touch3 *touch, const Rubbed *at,
                  const FrictionDual4 slots[], Push3 *push);
void ContactPushSlope3(const Contact *contact, const Touch3 *touch, const Rubbed *at,
                       PetscBool fresh, FrictionDual4 *dual, Push3 *push);
void ContactSlots(PetscInt n, const Touch3 touch[], FrictionDual4 slots[]);
FrictionDual4 *ContactSlot(const Touch3 *touch, FrictionDual4 slots[]);
PetscReal ContactHoldTouch3(const Contact *contact, const Touch3 *touch, const Rubbed *at,
                            PetscReal seen, PetscReal hold, FrictionDual4 slots[]);
PetscReal ContactHold3(const Contact *contact, const Rubbed *at, PetscReal seen,
                       FrictionDual4 slots[]);

#endif
