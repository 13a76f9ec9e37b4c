/* The load density: what the world exerts on the rod per length, at a place and a velocity. Models
   ask it alone; no one else knows of what terms it is made. Its sign is that of the equation
   n' = g F: F is what the rod overcomes.

     F = N(x,t) M f(v),   M = q q^T + a q_perp q_perp^T,   f(v) = phi(|v|) v  (friction.h)

   N is a factor that varies in space and time, a the ratio of friction across the rod to that along
   it. Where N = 1 and a = 1, neither is computed. Walls that press on the rod (contact.h) take
   their force off F, as does weight. In space see load_space.h. */
#ifndef TENDRIL_LOAD_H
#define TENDRIL_LOAD_H

#include "world/contact.h"
#include "world/field.h"
#include "world/friction.h"

typedef struct {
  Friction friction;
  PetscReal across;       /* a */
  Field field;            /* N over factor; NULL: 1 */
  PetscReal factor;       /* 1 but where a run has changed it */
  const Contact *walls;   /* NULL: none; borrowed */
  PetscReal weight[3];    /* force per length, in the clamp's frame */
  PetscReal radius;       /* at which friction feels the spin of a rod in space; 0: it does not */
  PetscReal lab[3][3];    /* from the clamp's frame to the laboratory, where N is given, */
  PetscReal place[3];     /* and the clamp is here */
  PetscBool weighs;       /* weight is not 0 */
  PetscBool plain;        /* N = 1 and a = 1, no walls, no weight */
  PetscBool varied;       /* N or a is not 1 */
  PetscBool turns, moves; /* F depends on the direction of the rod (a), on the place (N, walls) */
  PetscReal arm;      /* W of a rod in space has arm times its spin: radius, or that of contact */
  PetscInt duals;     /* of each place: that of the friction along the rod, one for each wall,
                         and one for a foot on a post (rod/feet.h) */
  PetscInt duals3;    /* the same of a rod in space (contact_space.h) */
  PetscReal viscous;  /* 1 - mu, as it was asked for */
  PetscBool limit;    /* exact friction was asked for, and is taken as a limit */
  PetscReal resolved; /* ... and then: the speed that steps of tolerance 1e-6 resolve */
  PetscBool shared;   /* a viscous share was given to dry friction, see LoadShareMore() */
} Load;

enum { SPIN = 3, RUBS = 4 }; /* the components of what rubs */

/* Where on the rod, and how fast; all in the clamp's frame. In the plane the third components are
   0. */
typedef struct {
  PetscReal t, x[3], q[3]; /* time, position, tangent */
  PetscReal v[RUBS];       /* velocity of the material, and in space load->arm times its spin */
} Place;

/* The derivatives of F: by v, by the angle of the rod (if it turns), by x (if it moves). */
typedef struct {
  PetscReal v[2][2], theta[2], x[2][2];
} LoadSlope;

typedef FrictionDual LoadDual; /* what Newton's method remembers of a place: load->duals of them */

extern const OptionGroup load_options;

PetscErrorCode LoadSetFromOptions(Load *load);
void LoadNextToExact(Load *load);
PetscBool LoadIsNextToExact(const Load *load);
void LoadNextToExactByWalls(Load *load);
void LoadAtTolerance(Load *load, PetscReal rtol);
void LoadShare(Load *load, PetscReal share);
PetscBool LoadShareMore(Load *load);
PetscReal LoadLeastViscous(const Load *load, PetscReal speed);
void LoadShareLeast(Load *load, PetscReal speed);
PetscBool LoadMaySlip(const Load *load);
PetscBool LoadSharesMost(const Load *load);
void LoadSetWalls(Load *load, const Contact *contact);
void LoadSetWeight(Load *load, const PetscReal weight[3]);
void LoadSetFactor(Load *load, PetscReal factor);
PetscErrorCode LoadDestroy(Load *load);
PetscBool LoadIsEven(const Load *load, PetscReal length, PetscReal end);
void LoadForceVaried(const Load *load, const Place *at, PetscReal f[2]);
void LoadSlopeVaried(const Load *load, const Place *at, const LoadDual *dual, LoadSlope *slope);
PetscReal LoadForceWalls(const Load *load, const Place *at, const LoadDual *dual, PetscReal f[2]);
void LoadSlopeWalls(const Load *load, const Place *at, PetscBool fresh, LoadDual *dual,
                    LoadSlope *slope);
void LoadParts(const Load *load, const Place *at, const LoadDual *dual, PetscReal friction[2],
               PetscReal walls[2], PetscReal *moved);
PetscBool LoadIsDry(const Load *load);
PetscReal LoadFactor(const Load *load, const PetscReal x[3], PetscReal t, PetscReal slope[3]);

/* F */
static inline void LoadForce(const Load *load, const Place *at, const LoadDual *dual,
                             PetscReal f[2]) {
  FrictionForce(&load->friction, at->v, dual, f);
  if (load->plain) return;
  if (load->varied) LoadForceVaried(load, at, f);
  if (load->walls) (void)LoadForceWalls(load, at, dual, f);
  for (int d = 0; d < 2 && load->weighs; d++) f[d] -= load->weight[d];
}

/* The slope of F for Newton's method, the dual brought up to the present velocity first; fresh: a
   Newton solve begins. */
static inline void LoadLinearise(const Load *load, const Place *at, PetscBool fresh, LoadDual *dual,
                                 LoadSlope *slope) {
  if (fresh)
    FrictionDualReset(&load->friction, at->v, dual);
  else
    FrictionDualAdvance(&load->friction, at->v, dual);
  FrictionLinearise(&load->friction, at->v, dual, slope->v);
  if (!load->plain) {
    LoadSlopeVaried(load, at, dual, slope);
    if (load->walls) LoadSlopeWalls(load, at, fresh, dual, slope);
  }
}

/* Does a place stick or slide, without anything between (exact Coulomb friction)? */
static inline PetscBool LoadSticks(const Load *load) {
  return (PetscBool)(load->friction.beta == 0);
}

/* Moves what holds a sticking place; returns the speed at which it creeps. */
static inline PetscReal LoadHold(const Load *load, const Place *at, PetscReal seen,
                                 LoadDual *dual) {
  PetscReal creep = FrictionDualHold(at->v, seen, friction_hold, dual);
  if (load->duals == 1) return creep;
  return LargerOf(creep, ContactHold(load->walls, at->x, at->v, seen, dual + 1));
}

/* F of friction where nothing is held, as an observer sees it: a place at rest bears no dry force.
   Without walls and weight. */
static inline void LoadSeen(const Load *load, const Place *at, PetscReal f[2]) {
  PetscReal drag = FrictionPhi(&load->friction, at->v[0] * at->v[0] + at->v[1] * at->v[1]);
  for (int d = 0; d < 2; d++) f[d] = drag * at->v[d];
  if (load->varied) LoadForceVaried(load, at, f);
}

/* The straight rod, which moves along itself: the drag F/v there, without N. */
static inline PetscReal LoadAxialDrag(const Load *load, PetscReal speed) {
  return FrictionPhi(&load->friction, speed * speed);
}

/* The axial load on a piece of straight rod of unit length, whose speed rises evenly from a to b,
   times b - a; N = 1. */
static inline PetscReal LoadAxialBetween(const Load *load, PetscReal a, PetscReal b) {
  return FrictionBetween(&load->friction, a, b);
}

#endif
