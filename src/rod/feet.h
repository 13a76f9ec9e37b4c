/* Feet: where the curve of the rod is nearest to what stands out of walls and may be narrower than
   its cells: posts and corners of the plane; thin posts, wires and balls, and sharp edges in space.
   Collocation points would step over them. With d the distance from such a thing, n and H its first
   and second derivatives, a foot is a point contact, of strength a k l as that of the tip is
   (world/contact.h),

     foot: n.x' = 0, where d is smallest,   gamma = d(foot) - D/2,   E = a l U(gamma),

   and its force, that of this energy with friction against the velocity of the place, is handed to
   the two nodes and the middle of this one cell: to each as much as the parabola through them gives
   it a part in x(foot). So force and moment are those of a point load at the foot, and no other
   cell learns of it. In space there is a couple about the tangent, too (contact_push.h).

   a is the share of a post (ContactPostShare()) whose radius is

     rho = 1/(t.H t) - gamma,   t the tangent there:

   r + D/2 in the plane, of a ball, or of a post that is met across, more of one that is met at a
   slant, and without a bound where the rod lies along it, for there the points of the cells feel
   it. So a foot comes and goes where it has no force. (That a changes with the direction is no
   force.) */
#ifndef TENDRIL_FEET_H
#define TENDRIL_FEET_H

#include "curve/cell.h"
#include "scene/scene.h"

/* A node has up to FOOT_NODE unknowns that matter: in the plane place and angle, FOOT_PLANE, and of
   a cell that stretches FOOT_STRETCHES, its stretch, its slide and (the first node's) that in the
   middle; in space place, quaternion and, by the spin of what slides, moment. */
enum {
  FOOT_PARTS = 3,
  FOOT_KINK = 3,
  FOOT_ROWS,
  FOOT_PLANE = 3,
  FOOT_STRETCH = FOOT_PLANE,
  FOOT_SLIDE,
  FOOT_MID_SLIDE,
  FOOT_STRETCHES,
  FOOT_NODE = CURVE_NODE,
  FOOT_UNKNOWNS = 2 * FOOT_NODE,
  FOOT_LOAD = 6,
  MOST_FEET = 16
};

/* A cell: its curve, and the spin of the material at its ends. */
typedef struct {
  int dims; /* 2 in the plane, 3 in space */
  CurveCell curve;
  PetscBool moves, first,
      last; /* the rates are known; the cell is the first, the last of the rod */
  PetscReal spin[2];
  PetscReal weight[FOOT_PARTS]; /* of its points, in the equations of the cell: 1/6, 4/6, 1/6 */
  PetscBool stretches;          /* its stretch and slide are unknowns, too, in the plane */
} FootCell;

/* How its curve and the spin change with the unknowns of an end; the rate of x' with its stretch.
 */
typedef struct {
  CurveEnd curve;
  PetscReal spin[FOOT_NODE], stretch_t[3];
} FootEnd;

typedef struct {
  PetscInt item;                                /* a post; of space, of ContactRidgeTouch() */
  PetscBool ends;                               /* it is an end of the rod */
  CurvePlace on;                                /* where it is on the curve */
  PetscReal rho;                                /* in space, see above */
  PetscReal strength, strength_t, strength_rho; /* a l, its rate where rho stays, and by rho */
  PetscReal t[3], v[3], spin;                   /* tangent, velocity and spin of the material */
  PetscReal force[3], couple, normal, power;    /* on the rod; p a l and what friction takes */
} Foot;

/* The feet of a cell, in the order of items. */
typedef struct {
  PetscInt n;
  Foot foot[MOST_FEET];
  Touch touch[MOST_FEET];
} Feet;

/* What Newton's method remembers of their friction: in the plane that of the first foot; in space
   of walls. NULL: nothing is held. */
typedef FrictionDual *FeetHeld;

/* What feet add to n', and behind it to m', at the points of the cell; and, in row FOOT_KINK, a
   vector w by which the rod turns more from a to b than the cell's formula gives it: that smears a
   point load over the cell. With b = 1/12 - z (1 - z)/2, of mean 0, and w the sum of b f, in the
   plane

     theta_b - theta_a = ... + (h g)^2/B (q1 w2 - q2 w1)

   so the angle does not jump when a foot goes on to the next cell. And by the unknowns of both
   nodes, of as many as they have. */
typedef PetscReal FootLoad[FOOT_ROWS][FOOT_LOAD];
typedef PetscReal FootSlope[FOOT_ROWS][FOOT_LOAD][FOOT_UNKNOWNS];

/* feet_find.c */
PetscBool FootAbout(const FootCell *cell, Vector2 c, Foot *foot);
void FeetFind(const Contact *contact, const FootCell *cell, PetscReal within, Feet *feet);

void FeetPush(const Contact *contact, const FootCell *cell, FeetHeld held, Feet *feet);
void FeetHandOut(const FootCell *cell, const Feet *feet, FootLoad load);
void FeetLinearise(const Contact *contact, const FootCell *cell, const FootEnd end[2],
                   PetscBool fresh, FeetHeld held, Feet *feet, FootSlope slope);
PetscReal FeetHold(const Contact *contact, const FootCell *cell, Feet *feet, PetscReal seen,
                   FeetHeld held);
PetscReal FootShareRate(const Contact *contact, const FootCell *cell, const Feet *feet, PetscInt k);

/* Of a foot: w.H w. */
static inline PetscReal FootSquare(const PetscReal H[3][3], const PetscReal w[3]) {
  PetscReal bent[3];
  Turn3(H, w, bent);
  return Dot3(w, bent);
}

/* ... the second derivative of the distance by z: x_z.H x_z + n.x_zz. */
static inline PetscReal FootStiff(const Foot *foot, const Touch *touch) {
  return FootSquare(touch->bend, foot->on.slope) + Dot3(touch->normal, foot->on.bend);
}

#endif
