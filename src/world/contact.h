/* Contact: the rod has a diameter, and what touches it pushes back.

   Gap gamma: distance of the centre line from a surface less the radius, or from another strand of
   the rod less the diameter. Force per length along the normal:

     p(gamma) = k s(gamma),   s = 0 beyond w,   (w - gamma)^2 / 4w up to w,   -gamma below -w,

   C1, with the potential U, U' = -p. Rigid contact is the limit of large k. That which
   follows from D rises smoothly to contact_firm_times of it over the depths from contact_firm[0] w
   to contact_firm[1] w (w is 5e-4 D where k follows from D, and 2e-3 D of a rod that can touch
   itself), and is even again behind, so that no overshoot of Newton's method meets forces without a
   bound. The law is the same all along, for one that is switched on in the course of a run is
   another problem from there on; but a rod need not know of it before it is pressed in by
   contact_firm[0] w (ContactGetsFirm()). All of it scales with k and w, so that what is led to
   rigid contact by both is so here, too. Friction in contact: mu_c p against the relative velocity
   along the surface, u, as -mu_c p u/r, r = sqrt(u^2
   + beta). The end of the rod is a point contact of its own, of strength k l, l = (B/k)^(1/4): the
   length over which a point load spreads on such a foundation, B the rod's stiffness there. So is
   the place of the rod nearest to a post, or corner, that is not wider than the cells (rod/feet.h).

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
  PetscBool among;                  /* it is one of several rods, whose strands are looked at
                                       together: others may touch it */
  PetscBool given;                  /* k is the user's */
  PetscBool fine;                   /* an accuracy is asked for, and k follows from that, too */
  PetscBool firm;                   /* k grows where the rod is pressed in */
  PetscBool chosen;                 /* whether it does is the user's */
  PetscReal *deepest;               /* of the state whose forces were asked for last, if k may have
                                       to grow: see ContactMayGetFirm(); else NULL */
  PetscBool slippery;               /* as if no wall had friction, to count modes (leg_modes.c) */
  PetscReal diameter;               /* D */
  PetscReal accuracy;               /* that which is asked for */
  PetscReal usual;                  /* force with which the rod is pressed: SceneForce() */
  PetscReal time;                   /* of what follows */
  PetscReal stiffness, smooth, tip; /* k, w, l */
  PetscReal stiffness_t, smooth_t, tip_t;
  PetscReal force;        /* Q, of usual size: that, or more in a short rod */
  PetscReal cell, cell_t; /* the largest, where posts are */
  PetscBool thin;         /* some posts are met at their feet */
  PetscReal friction;     /* mu_c between strands, and of walls without their own */
  Friction rub;           /* how contact friction is regularised: dry, of strength 1 */
  Walls walls;
  Surfaces surfaces; /* in space (contact_push.h) */
  PetscReal lab[3][3],
      upright[3][3];            /* from the clamp's frame to that of surfaces, and of walls, */
  PetscReal place[3], stand[3]; /* in which the clamp is here */
} Contact;

extern const OptionGroup contact_options;

const char *ContactRemedy(void);
PetscErrorCode ContactSetFromOptions(Contact *contact, PetscBool among, const Friction *friction,
                                     PetscReal clamp_angle);
PetscErrorCode ContactMayGetFirm(Contact *contact);
PetscErrorCode ContactStaysSoft(Contact *contact);
PetscBool ContactGetsFirm(Contact *contact, PetscReal deepest);
PetscBool ContactNeedsCell(const Contact *contact);
void ContactSetStiffness(Contact *contact, const PetscReal B[2], const PetscReal cell[2],
                         const PetscReal length[2]);
PetscReal ContactPostShare(const Contact *contact, PetscReal rho, PetscReal *share_t);
PetscReal ContactPostShareSlope(const Contact *contact, PetscReal rho);
PetscErrorCode ContactDestroy(Contact *contact);
PetscErrorCode ContactWallsText(const Contact *contact, char **text);

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

/* Depths over w between which contact gets firmer, and how many times: of walls, and where the rod
   can touch itself, which is softer to begin with. */
static const PetscReal contact_firm[2] = {1.5, 3}, contact_firm_times[2] = {16, 64};

/* Can strands touch, of the rod or of others? */
static inline PetscBool ContactOfStrands(const Contact *contact) {
  return (PetscBool)(contact->self || contact->among);
}

static inline PetscReal ContactFirmTimes(const Contact *contact) {
  return contact_firm_times[ContactOfStrands(contact) ? 1 : 0];
}

/* What the part that is firm adds to the depth, r; by_depth its derivative, energy its integral. */
static inline PetscReal ContactFirm(const Contact *contact, PetscReal gap, PetscReal *by_depth,
                                    PetscReal *energy) {
  const PetscReal over = -gap - contact_firm[0] * contact->smooth,
                  way = (contact_firm[1] - contact_firm[0]) * contact->smooth,
                  more = ContactFirmTimes(contact) - 1;
  PetscReal z, beyond;

  *by_depth = *energy = 0;
  if (!contact->firm || over <= 0) return 0;
  z = PetscMin(over / way, 1);
  beyond = PetscMax(over - way, 0);
  *by_depth = more * z * z * (3 - 2 * z);
  *energy = more * (way * way * z * z * z * z * (0.25 - 0.1 * z) + (way + beyond) * beyond / 2);
  return more * (way * z * z * z * (1 - z / 2) + beyond);
}

/* p(gamma), and its derivative */
static inline PetscReal ContactPressure(const Contact *contact, PetscReal gap, PetscReal *slope) {
  const PetscReal k = contact->stiffness, w = contact->smooth;
  PetscReal firm, by_depth, energy;

  if (gap >= w) return *slope = 0;
  if (gap <= -w) {
    if (contact->deepest) *contact->deepest = PetscMax(*contact->deepest, -gap);
    firm = ContactFirm(contact, gap, &by_depth, &energy);
    *slope = -k * (1 + by_depth);
    return -k * (gap - firm);
  }
  *slope = -k * (w - gap) / (2 * w);
  return k * (w - gap) * (w - gap) / (4 * w);
}

/* Of the layer in which a place begins to be pressed, the rest is where next to nothing is. */
static const PetscReal contact_bears = 0.9;

/* Does a place that is so near bear a force? Then it is in contact, whether it is pressed in, or
   held off within that layer. */
static inline PetscBool ContactBears(const Contact *contact, PetscReal gap) {
  return (PetscBool)(gap < contact_bears * contact->smooth);
}

/* How deep the force that presses in so far would press in, were contact as soft there as it is
   where it is touched: a point load sinks in by k^(-3/4), with the p/depth that it meets for k. */
static inline PetscReal ContactSoftDepth(const Contact *contact, PetscReal depth) {
  PetscReal slope;

  if (!contact->firm || depth <= contact_firm[0] * contact->smooth) return depth;
  return depth *
         PetscPowReal(ContactPressure(contact, -depth, &slope) / contact->stiffness / depth, 0.75);
}

/* U(gamma) = int_gamma^w p */
static inline PetscReal ContactEnergy(const Contact *contact, PetscReal gap) {
  const PetscReal k = contact->stiffness, w = contact->smooth;
  PetscReal by_depth, energy;

  if (gap >= w) return 0;
  if (gap > -w) return k * (w - gap) * (w - gap) * (w - gap) / (12 * w);
  (void)ContactFirm(contact, gap, &by_depth, &energy);
  return k * (2 * w * w / 3 + (gap * gap - w * w) / 2 + energy);
}

/* dU/dt at a fixed gap, for k and w change in time. (Of U = k w^2 f(gamma/w) the derivative by w is
   (2 U + p gamma)/w.) */
static inline PetscReal ContactEnergyRate(const Contact *contact, PetscReal gap) {
  const PetscReal k = contact->stiffness, w = contact->smooth;
  PetscReal by_w = 0, firm, by_depth, energy;

  if (gap <= -w) {
    firm = ContactFirm(contact, gap, &by_depth, &energy);
    by_w = k * w / 3 + k * (2 * energy + firm * gap) / w;
  } else if (gap < w)
    by_w = k * (w - gap) * (w - gap) * (2 * w + gap) / (12 * w * w);
  return ContactEnergy(contact, gap) * contact->stiffness_t / k + by_w * contact->smooth_t;
}

/* The friction of a surface that slips by at u, over mu_c p: w, and dw/du. The dual of another
   direction is that of a scalar. */
static inline PetscReal ContactRub(const Contact *contact, PetscReal u, const FrictionDual *dual,
                                   PetscReal *slope) {
  PetscReal f[RUBS], by[RUBS][RUBS];

  FrictionForce(1, &contact->rub, &u, dual, f);
  FrictionSlope(1, &contact->rub, &u, dual, by);
  *slope = by[0][0];
  return f[0];
}

#endif
