/* The load density: what the world exerts on the rod per length, at a place and a velocity. Models
   ask it alone; no one else knows of what terms it is made. Its sign is that of the equation
   n' = g F: F is what the rod overcomes.

     F = N(x,t) M f(v),   M = q q^T + a q_perp q_perp^T,   f(v) = phi(|v|) v  (friction.h),

   phi the sum of the built-in law's and of those beside it (friction_law.h), N a factor that varies
   in space and time, a the ratio of friction across the rod to that along it. Where N = 1 and a =
   1, neither is computed. Walls that press on the rod (contact.h) take their force off F, as does
   weight.

   A rod in space that slides at v and spins at omega about its tangent q in an even grip rubs at W
   = (v, r omega), r the radius at which friction feels the spin:

     F = N M f - weight,  M = q q^T + a (I - q q^T),      couple about q:  N r f_spin,
     f = phi(|W|) W.

   Where the friction along the rod does not feel the spin, but that of walls does, r is half of the
   diameter.

   dims, below: 2 in the plane, where vectors have two components and nothing spins, 3 in space; a
   constant of each call. */
#ifndef TENDRIL_LOAD_H
#define TENDRIL_LOAD_H

#include "curve/place.h"
#include "world/contact_push.h"
#include "world/field.h"
#include "world/friction_law.h"

/* A law beside the built-in one, and what it knows. */
typedef struct {
  const FrictionLaw *kind;
  void *known;
} LoadLaw;

typedef struct {
  Friction friction;
  LoadLaw law[ALL_FRICTION_LAWS];
  int laws;               /* so many of these were asked for; */
  PetscBool along;        /* one varies along the rod */
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
  PetscInt duals3;    /* the same of a rod in space (contact_push.h) */
  PetscReal viscous;  /* 1 - mu, as it was asked for */
  PetscBool limit;    /* exact friction was asked for, and is taken as a limit */
  PetscReal resolved; /* ... and then: the speed that steps of tolerance 1e-6 resolve */
  PetscBool shared;   /* a viscous share was given to dry friction, see LoadShareMore() */
} Load;

/* The derivatives of the force and, last, of the couple: by W, q and x; in the plane by the angle
   of the rod in place of q. */
typedef struct {
  PetscReal W[RUBS][RUBS], x[RUBS][3], q[RUBS][3], theta[3];
} LoadSlope;

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
size_t LoadLawOptions(const OptionGroup *groups[]);
PetscBool LoadHas(const Load *load, const FrictionLaw *kind);
const char *LoadAlong(const Load *load);
PetscBool LoadIsLinear(const Load *load);
void LoadDrag(const Load *load, const Place *at, PetscReal speed2, PetscReal drag[]);
void LoadRubLaws(int n, const Load *load, const Place *at, const PetscReal W[], PetscReal f[]);
void LoadRubLawsSlope(int n, const Load *load, const Place *at, const PetscReal W[],
                      PetscReal slope[RUBS][RUBS]);
PetscReal LoadAxialBetween(const Load *load, PetscReal a, PetscReal b);
PetscBool LoadIsEven(const Load *load, PetscReal length, PetscReal end);
void LoadSetArm(Load *load);
PetscBool LoadInSpace(const Load *load);
void LoadVary(int dims, const Load *load, const Place *at, PetscReal f[RUBS]);
void LoadVarySlope(int dims, const Load *load, const Place *at, const PetscReal W[],
                   const FrictionDual *dual, LoadSlope *slope);
PetscReal LoadForceWalls(int dims, const Load *load, const Place *at, const FrictionDual *dual,
                         PetscReal f[RUBS]);
void LoadSlopeWalls(int dims, const Load *load, const Place *at, PetscBool fresh,
                    FrictionDual *dual, LoadSlope *slope);
void LoadParts(int dims, const Load *load, const Place *at, const FrictionDual *dual,
               PetscReal friction[3], PetscReal walls[3], PetscReal *moved);
PetscReal LoadHold(int dims, const Load *load, const Place *at, PetscReal seen,
                   FrictionDual dual[]);
PetscBool LoadIsDry(const Load *load);
PetscReal LoadFactor(const Load *load, const PetscReal x[3], PetscReal t, PetscReal slope[3]);

/* Does friction along the rod not feel the spin that a place has? */
static inline PetscBool LoadIsDeaf(const Load *load) {
  return (PetscBool)(load->arm != load->radius);
}

/* Do force and couple depend on place and direction? */
static inline PetscBool LoadPlaced(const Load *load) {
  return (PetscBool)(load->varied || load->walls);
}

/* How many components rub, and W as friction along the rod feels it. */
static inline int LoadRubs(int dims) {
  return dims == 2 ? 2 : RUBS;
}

static inline void LoadFelt(int dims, const Load *load, const Place *at, PetscReal W[RUBS]) {
  for (int d = 0; d < LoadRubs(dims); d++) W[d] = at->v[d];
  if (dims == 3 && LoadIsDeaf(load)) W[SPIN] = 0;
}

/* What walls see of a place. */
static inline Rubbed LoadRubbed(const Load *load, const Place *at) {
  return (Rubbed){at->x, at->axes[0], at->v, load->arm > 0 ? at->v[SPIN] / load->arm : 0};
}

/* f(v), W for v. */
static inline void LoadRub(int n, const Load *load, const Place *at, const PetscReal W[],
                           const FrictionDual *dual, PetscReal f[]) {
  FrictionForce(n, &load->friction, W, dual, f);
  if (load->laws) LoadRubLaws(n, load, at, W, f);
}

/* phi at a speed, as an observer sees it. */
static inline PetscReal LoadPhi(const Load *load, const Place *at, PetscReal speed2) {
  PetscReal drag[] = {0, 0};

  if (load->laws) LoadDrag(load, at, speed2, drag);
  return FrictionPhi(&load->friction, speed2) + drag[0];
}

/* LoadForce - the force F that the rod overcomes, per length, and the couple about its tangent. */
static inline void LoadForce(int dims, const Load *load, const Place *at, const FrictionDual *dual,
                             PetscReal f[RUBS]) {
  PetscReal W[RUBS];

  LoadFelt(dims, load, at, W);
  LoadRub(LoadRubs(dims), load, at, W, dual, f);
  if (dims == 2 && load->plain) return;
  if (load->varied) LoadVary(dims, load, at, f);
  for (int d = 0; d < dims && load->weighs; d++) f[d] -= load->weight[d];
  if (dims == 3) f[SPIN] *= load->radius;
  if (load->walls) (void)LoadForceWalls(dims, load, at, dual, f);
}

/* LoadLinearise - the slope of force and couple for Newton's method, the duals brought up to the
   present velocity first; fresh: a Newton solve begins. Those by q and x are set only where
   LoadPlaced(). */
static inline void LoadLinearise(int dims, const Load *load, const Place *at, PetscBool fresh,
                                 FrictionDual *dual, LoadSlope *slope) {
  const int rubs = LoadRubs(dims);
  PetscReal W[RUBS];

  LoadFelt(dims, load, at, W);
  FrictionLinearise(rubs, &load->friction, W, fresh, dual, slope->W);
  if (load->laws) LoadRubLawsSlope(rubs, load, at, W, slope->W);
  if (load->varied || (dims == 2 && !load->plain))
    LoadVarySlope(dims, load, at, W, dual, slope);
  else if (load->walls)
    for (int d = 0; d < rubs; d++)
      for (int c = 0; c < dims; c++) slope->q[d][c] = slope->x[d][c] = 0;
  if (dims == 3) {
    for (int c = 0; c < RUBS; c++) slope->W[SPIN][c] *= load->radius;
    for (int d = 0; d < RUBS && LoadIsDeaf(load); d++) slope->W[d][SPIN] = 0;
  }
  if (load->walls) LoadSlopeWalls(dims, load, at, fresh, dual, slope);
}

/* Does a place stick or slide, without anything between (exact Coulomb friction)? */
static inline PetscBool LoadSticks(const Load *load) {
  return (PetscBool)(load->friction.beta == 0);
}

/* LoadSeen - F of friction where nothing is held, as an observer sees it: a place at rest bears no
   dry force. Without walls and weight. */
static inline void LoadSeen(int dims, const Load *load, const Place *at, PetscReal f[RUBS]) {
  PetscReal W[RUBS], drag;

  LoadFelt(dims, load, at, W);
  drag = LoadPhi(load, at, FrictionSquare(LoadRubs(dims), W));
  for (int d = 0; d < LoadRubs(dims); d++) f[d] = drag * W[d];
  if (load->varied) LoadVary(dims, load, at, f);
  if (dims == 3) f[SPIN] *= load->radius;
}

/* The straight rod, which moves along itself: the drag F/v there, without N. */
static inline PetscReal LoadAxialDrag(const Load *load, const Place *at, PetscReal speed) {
  return LoadPhi(load, at, speed * speed);
}

#endif
