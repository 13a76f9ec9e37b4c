/* Contact: the rod has a diameter, and what touches it pushes back.

   Gap gamma: distance of the centre line from a surface less the radius, or from another strand of
   the rod less the diameter. Force per length along the normal:

     p(gamma) = k s(gamma),   s = 0 beyond w,   (w - gamma)^2 / 4w up to w,   -gamma below -w,

   C1, with the potential U, U' = -p. Rigid contact is the limit of large k. Friction in contact:
   mu_c p against the relative velocity along the surface, u, as -mu_c p u/r, r = sqrt(u^2 + beta).
   The end of the rod is a point contact of its own, of strength k l, l = (B/k)^(1/4): the length
   over which a point load spreads on such a foundation, B the rod's stiffness there. So is the
   place of the rod nearest to a post, or corner, that is not wider than the cells (rod/feet.h).

   k, unless it is given, follows from what the rod is at each time, and never from when the run is
   to end. */
#ifndef TENDRIL_CONTACT_H
#define TENDRIL_CONTACT_H

#include "world/friction.h"
#include "world/surfaces.h"
#include "world/walls.h"

typedef struct {
  PetscBool any;                    /* there are walls, or strands that touch */
  PetscBool self;                   /* strands touch */
  PetscBool given;                  /* k is the user's */
  PetscBool fine;                   /* k follows the mesh, too: an accuracy is asked for */
  PetscBool slippery;               /* as if no wall had friction, to count modes (leg.c) */
  PetscReal diameter;               /* D */
  PetscReal time;                   /* of what follows */
  PetscReal stiffness, smooth, tip; /* k, w, l */
  PetscReal stiffness_t, smooth_t, tip_t;
  PetscReal force;        /* Q, of usual size */
  PetscReal cell, cell_t; /* the largest, where posts are or k asks for it */
  PetscBool thin;         /* some posts are met at their feet */
  PetscReal friction;     /* mu_c between strands, and of walls without their own */
  Friction rub;           /* how contact friction is regularised: dry, of strength 1 */
  Walls walls;
  Surfaces surfaces;                  /* in space (contact_space.h) */
  PetscReal lab[3][3], upright[3][3]; /* from the clamp's frame to that of surfaces, and of walls */
} Contact;

/* Where on a surface, and what it does there: the force on the rod per length (of its tip: times
   l), and its derivatives. */
typedef struct {
  PetscReal force[2]; /* normal and friction together */
  PetscReal normal;   /* p */
  PetscReal rubbing;  /* mu_c p w, the part of friction along the surface */
  PetscReal v[2][2], x[2][2];
  PetscReal power; /* lost to friction */
} Push;

extern const OptionGroup contact_options;

PetscErrorCode ContactSetFromOptions(Contact *contact, const Friction *friction,
                                     PetscReal clamp_angle);
PetscBool ContactNeedsCell(const Contact *contact);
void ContactSetStiffness(Contact *contact, const PetscReal B[2], const PetscReal cell[2],
                         const PetscReal length[2]);
PetscReal ContactPostShare(const Contact *contact, const WallPost *post, PetscReal *share_t);
PetscErrorCode ContactDestroy(Contact *contact);
PetscErrorCode ContactWallsText(const Contact *contact, char **text);
PetscInt ContactTouches(const Contact *contact, const PetscReal x[2], Touch touch[MOST_TOUCHES]);
void ContactPush(const Contact *contact, const Touch *touch, const PetscReal v[2],
                 const FrictionDual *dual, Push *push);
void ContactPushSlope(const Contact *contact, const Touch *touch, const PetscReal v[2],
                      PetscBool fresh, FrictionDual *dual, Push *push);
PetscReal ContactHold(const Contact *contact, const PetscReal x[2], const PetscReal v[2],
                      PetscReal seen, FrictionDual duals[]);

/* The friction of a wall of the plane, and of a surface. */
static inline PetscReal ContactWallFriction(const Contact *contact, PetscInt wall) {
  return contact->slippery ? 0 : contact->walls.wall[wall].friction;
}

static inline PetscReal ContactSurfaceFriction(const Contact *contact, PetscInt surface) {
  return contact->slippery ? 0 : contact->surfaces.surface[surface].friction;
}

/* Has any wall friction, in the plane or in space? */
static inline PetscBool ContactWallsRub(const Contact *contact) {
  return (PetscBool)(contact->walls.rub || contact->surfaces.rub);
}

/* p(gamma), and its derivative */
static inline PetscReal ContactPressure(const Contact *contact, PetscReal gap, PetscReal *slope) {
  const PetscReal k = contact->stiffness, w = contact->smooth;

  if (gap >= w) return *slope = 0;
  if (gap <= -w) {
    *slope = -k;
    return -k * gap;
  }
  *slope = -k * (w - gap) / (2 * w);
  return k * (w - gap) * (w - gap) / (4 * w);
}

/* U(gamma) = int_gamma^w p */
static inline PetscReal ContactEnergy(const Contact *contact, PetscReal gap) {
  const PetscReal k = contact->stiffness, w = contact->smooth;

  if (gap >= w) return 0;
  if (gap <= -w) return k * (2 * w * w / 3 + (gap * gap - w * w) / 2);
  return k * (w - gap) * (w - gap) * (w - gap) / (12 * w);
}

/* dU/dt at a fixed gap, for k and w change in time */
static inline PetscReal ContactEnergyRate(const Contact *contact, PetscReal gap) {
  const PetscReal k = contact->stiffness, w = contact->smooth;
  PetscReal by_w = 0;

  if (gap <= -w)
    by_w = k * w / 3;
  else if (gap < w)
    by_w = k * (w - gap) * (w - gap) * (2 * w + gap) / (12 * w * w);
  return ContactEnergy(contact, gap) * contact->stiffness_t / k + by_w * contact->smooth_t;
}

/* The friction of a surface that slips by at u, over mu_c p: w, and dw/du. The dual of another
   direction is that of a scalar. */
static inline PetscReal ContactRub(const Contact *contact, PetscReal u, const FrictionDual *dual,
                                   PetscReal *slope) {
  const PetscReal v[2] = {u, 0};
  PetscReal f[2], by[2][2];

  FrictionForce(&contact->rub, v, dual, f);
  FrictionLinearise(&contact->rub, v, dual, by);
  *slope = by[0][0];
  return f[0];
}

#endif
