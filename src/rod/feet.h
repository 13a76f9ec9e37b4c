/* Feet: where the rod meets posts and corners that may be narrower than its cells. Collocation
   points would step over them. So the place of a cell's curve that is nearest to the middle c of a
   post, of radius r, is a point contact, of strength a k l as that of the tip is (world/contact.h),

     E = a k l ... = a l U(gamma),   gamma = |x(foot) - c| - r - D/2,   foot: (x(foot) - c).x' = 0,

   and its force, that of this energy, p(gamma) a l n with friction against the velocity of the
   place, is handed to the two nodes and the middle of this one cell: to each as much as the
   parabola through them gives it a part in x(foot). So force and moment are those of a point load
   at the foot, and no other cell learns of it. */
#ifndef TENDRIL_FEET_H
#define TENDRIL_FEET_H

#include "scene/scene.h"

enum { FOOT_PARTS = 3, FOOT_KINK = 3, FOOT_ROWS, FOOT_UNKNOWNS = 6, MOST_FEET = 16 };

/* A cell: its curve, the cubic through x and x' = g q at its ends, and how that moves. */
typedef struct {
  PetscReal h; /* of labels */
  PetscReal x[2][2], q[2][2], g[2];
  PetscReal x_t[2][2], theta_t[2], g_t[2], c[FOOT_PARTS]; /* c at the ends and between them */
  PetscBool moves, first,
      last; /* the rates are known; the cell is the first, the last of the rod */
  PetscReal weight[FOOT_PARTS]; /* of its points, in the equations of the cell: 1/6, 4/6, 1/6 */
} FootCell;

typedef struct {
  PetscInt post;
  PetscBool ends;                       /* it is an end of the rod */
  PetscReal z, x[2], slope[2], bend[2]; /* 0 <= z <= 1; x and its derivatives by z */
  PetscReal n[2], distance, gap;
  PetscReal strength, strength_t; /* a l, and its rate */
  PetscReal p, p_gap;             /* pressure and its derivative */
  PetscReal slip, w, w_slip;      /* speed along the surface, friction over mu p */
  PetscReal force[2];             /* on the rod */
} Foot;

/* What feet add to n' at the points of the cell; and, in row FOOT_KINK, a vector w by which the
   angle turns more from a to b than the cell's formula gives it: that smears a point load over the
   cell. With b = 1/12 - z (1 - z)/2, of mean 0, and w the sum of b f,

     theta_b - theta_a = ... + (h g)^2/B (q1 w2 - q2 w1)

   so the angle does not jump when a foot goes on to the next cell. And by x1, x2, theta of both
   nodes. */
typedef PetscReal FootLoad[FOOT_ROWS][2];
typedef PetscReal FootSlope[FOOT_ROWS][2][FOOT_UNKNOWNS];

void FootParts(PetscReal h, const PetscReal weight[FOOT_PARTS], PetscReal z,
               PetscReal part[FOOT_ROWS], PetscReal part_z[FOOT_ROWS]);
Block FootCellBlock(const FootCell *cell);
PetscBool FootAbout(const FootCell *cell, const PetscReal c[2], Foot *foot);
PetscInt FeetFind(const Contact *contact, const FootCell *cell, PetscReal within,
                  Foot foot[MOST_FEET]);
void FootPush(const Contact *contact, const FootCell *cell, const FrictionDual *dual, Foot *foot);
void FootHandOut(const FootCell *cell, const Foot *foot, FootLoad load);
void FootLinearise(const Contact *contact, const FootCell *cell, const PetscReal shift[3],
                   PetscBool fresh, FrictionDual *dual, Foot *foot, FootSlope slope);

#endif
