/* Feet of a rod in space: where its curve is nearest to what stands out of walls and may be
   narrower than its cells, as in the plane (feet.h): thin posts, wires and balls, sharp edges, and
   posts and corners of the plane's walls, which stand upright. With d the distance from such a
   thing, n and H its first and second derivatives,

     foot: n.x' = 0, where d is smallest,   gamma = d(foot) - D/2,   strength a k l,

   and the force and the couple about the tangent are those of contact_space.h, times a l. a is the
   share of a post in the plane (ContactPostShare()) whose radius is

     rho = 1/(t.H t) - gamma,   t the tangent there:

   r + D/2 of a ball, or of a post that is met across, more of one that is met at a slant, and
   without a bound where the rod lies along it, for there the points of the cells feel it. So a foot
   comes and goes where it has no force. (That a changes with the direction is no force.) */
#ifndef TENDRIL_FEET_SPACE_H
#define TENDRIL_FEET_SPACE_H

#include "rod/feet.h"

/* Unknowns of a node that matter: place, quaternion, moment (by the spin of what slides). */
enum { FOOT3_NODE = 10, FOOT3_UNKNOWNS = 2 * FOOT3_NODE, FOOT3_LOAD = 6 };

/* A cell: its curve, the cubic through x and x' = g d1 at its ends, and how that moves. */
typedef struct {
  PetscReal h; /* of labels */
  PetscReal g[2], x[2][3], q[2][3];
  PetscBool moves, first, last;                /* as of a FootCell */
  PetscReal x_t[2][3], slope_t[2][3], spin[2]; /* rates of x and x', spin of the material */
  PetscReal c[FOOT_PARTS], weight[FOOT_PARTS];
} FootCell3;

/* How d1, the rate of x' and the spin at an end change with its unknowns, and shifts of x. */
typedef struct {
  PetscReal q[3][4], slope_t[3][4], spin[FOOT3_NODE], shift[3];
} FootEnd3;

typedef struct {
  PetscInt item;                                /* of ContactRidgeTouch() */
  PetscBool ends;                               /* it is an end of the rod */
  PetscReal z, x[3], slope[3], bend[3];         /* 0 <= z <= 1; x and its derivatives by z */
  PetscReal rho;                                /* see above */
  PetscReal strength, strength_t, strength_rho; /* a l, its rate where rho stays, and by rho */
  PetscReal t[3], v[3], spin;                   /* tangent, velocity and spin of the material */
  PetscReal force[3], couple, normal, power;    /* on the rod; p a l and what friction takes */
} Foot3;

/* The feet of a cell, in the order of items. */
typedef struct {
  PetscInt n;
  Foot3 foot[MOST_FEET];
  Touch3 touch[MOST_FEET];
} Feet3;

/* What they add to n', and behind it to m', at the points of the cell; and w, see FootLoad. */
typedef PetscReal FootLoad3[FOOT_ROWS][FOOT3_LOAD];
typedef PetscReal FootSlope3[FOOT_ROWS][FOOT3_LOAD][FOOT3_UNKNOWNS];

void FeetFind3(const Contact *contact, const FootCell3 *cell, PetscReal within, Feet3 *feet);
void FeetPush3(const Contact *contact, const FootCell3 *cell, const FrictionDual4 slots[],
               Feet3 *feet);
void FeetHandOut3(const FootCell3 *cell, const Feet3 *feet, FootLoad3 load);
void FeetLinearise3(const Contact *contact, const FootCell3 *cell, const FootEnd3 end[2],
                    PetscBool fresh, FrictionDual4 slots[], Feet3 *feet, FootSlope3 slope);
PetscReal FeetHold3(const Contact *contact, Feet3 *feet, PetscReal seen, FrictionDual4 slots[]);
PetscReal FootShareRate3(const Contact *contact, const FootCell3 *cell, const Feet3 *feet,
                         PetscInt k);

#endif
