/* Rods that hold each other: one begins on another one, its carrier, or has its tip held there.

   The clamp's seven rows of the first node, or the tip's six of the last one, say how that is, and
   what the rod bears there acts on the carrier. P is the place there, q how the rod is turned
   against its directors:

     weld    x = x_P,  p = p_P q           of a tip  vec((p_P q)* p) = 0
     ball    x = x_P,  m = 0,  |p| = 1     of a tip  without the last
     hinge   x = x_P,  m.e = 0,  vec((p_P q)* p) = 0 across e,  |p| = 1, likewise

   The carrier's node there is double (material/mesh.h), and stays with its material
   (material/growth_follow.c), so that its moment and force jump:

     m_b - m_a + sum of m of all that begin there - sum of m of all tips held there = 0,   n
   likewise.

   Each rod has its own frame, in which it begins at 0 (scene/space.h); the joint goes from one to
   the other. */
#ifndef TENDRIL_JOINTS_H
#define TENDRIL_JOINTS_H

#include "rod/rod.h"
#include "system/rods.h"

typedef enum { JOINT_WELD, JOINT_BALL, JOINT_HINGE } JointKind;

typedef struct {
  PetscInt rod, carrier;
  PetscBool tip; /* of the rod, or its beginning */
  JointKind kind;
  char at[64];         /* where on the carrier, as it was asked for */
  PetscReal label;     /* ... */
  PetscBool follows;   /* its material slides along the carrier, */
  PetscReal along;     /* ... and by this it is told (GrowthFollow()) */
  PetscInt node;       /* the first of its two nodes there */
  PetscReal across[3]; /* of a hinge, its axis in the laboratory, as the rods begin */
  /* from the rod's frame to the carrier's, as vectors go, and to the rod's from there, as
     quaternions do; q; the places as they begin; and the rod's basis in which turns are told, of
     which a hinge turns about the first */
  PetscReal to_carrier[3][3], from_carrier[4], turn[4], x[3], x_P[3], basis[3][3];
} Joint;

typedef struct _Joints *Joints;

/* joints_read.c */
PetscErrorCode JointsRead(Rods rods, Joints *joints);
PetscErrorCode JointsDestroy(Joints *joints);
PetscInt JointsCount(Joints joints);
const Joint *JointsGet(Joints joints, PetscInt j);
PetscInt JointsOn(Joints joints, PetscInt k);
PetscInt JointsNext(Joints joints, PetscInt i);
PetscErrorCode JointsSeat(Joints joints, PetscInt k, const Rod each[], Seat *seat,
                          PetscBool *carried);
PetscErrorCode JointsHold(Joints joints, PetscInt k, Scene scene);
PetscErrorCode JointsDouble(Joints joints, Rods rods, PetscInt k, PetscBool placed, Scene scene);
PetscErrorCode JointsClose(Joints joints, Rods rods, const Rod each[]);

/* joints.c */
PetscErrorCode JointsResidual(Joints joints, Rod all, PetscReal t, Vec U, Vec F);
PetscErrorCode JointsJacobian(Joints joints, Rod all, PetscReal t, Vec U, Mat J);
PetscBool JointsCarry(Joints joints, PetscInt k, Rod all, PetscReal t, const PetscReal *u,
                      PetscReal x[3], PetscReal p[4]);
void JointsRelate(Joint *joint, const Rod each[], const PetscReal own[], const PetscReal of[]);

#endif
