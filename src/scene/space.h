/* What makes a scene one in space, and what there is only there: two stiffnesses and torsion, a
   clamp that points anywhere and turns, loads out of the plane of x1 and x2. */
#ifndef TENDRIL_SPACE_H
#define TENDRIL_SPACE_H

#include "material/curvature.h"
#include "world/load.h"
#include "material/shape.h"
#include "world/tip.h"
#include "base/schedule.h"

typedef struct {
  const char *why;     /* the option by which something acts out of the plane; NULL: none does */
  char refused[128];   /* the line that says so to who asks for a model of the plane */
  const char *only;    /* an option that was given and means nothing in the plane; NULL: none */
  PetscBool rod;       /* the rod is modelled in space: for who records it */
  PetscReal torsion;   /* C/B */
  PetscReal ratio;     /* B3/B2 */
  PetscReal spin;      /* rate at which the clamp turns about d1; with a path the fastest */
  Schedule clamp_path; /* over time; NULL: at that rate, */
  PetscReal spins_from, spun; /* from this time on, when it had turned by so much */
  PetscReal
      turned[4]; /* angles that drive each group of fields (rod.h) from 0: along, x2, x3, twist */
  PetscReal moved[4];  /* places that do */
  PetscReal lab[3][3]; /* from the clamp's frame to the laboratory, */
  PetscReal place[3];  /* where it is */
} Space;

/* Where a rod begins that another one carries: the place of that, and its directors there as they
   begin, the columns, in the laboratory. */
typedef struct {
  PetscReal place[3], frame[3][3];
} Seat;

extern const OptionGroup space_options;

PetscErrorCode SpaceClampDirection(const Seat *seat, PetscReal *angle, Space *space);
PetscErrorCode SpaceSetFromOptions(Space *space, Load *load, Tip *tip, const Curvature *curvature,
                                   const Shape *shape);
PetscErrorCode SpaceRelease(Space *space);
void SpaceFromLab(const Space *space, const PetscReal lab[3], PetscReal v[3]);
void SpaceToLab(const Space *space, const PetscReal v[3], PetscReal lab[3]);
void SpaceClampTurn(const Space *space, PetscReal t, PetscReal p[4]);
PetscReal SpaceClampAngle(const Space *space, PetscReal t);
PetscReal SpaceClampRate(const Space *space, PetscReal t);
const char *SpaceClampOption(const Space *space);

/* what a run may have changed: scene/change.c */
PetscErrorCode SpaceChangeSpin(Space *space, PetscReal t);
PetscErrorCode SpaceChangeTorque(Space *space, Tip *tip);
PetscErrorCode SpaceChangePush(Space *space, Tip *tip);
PetscErrorCode SpaceChangeWeight(Space *space, Load *load);

/* Is a vector of the clamp's frame along the clamp, but for what rounding leaves across? */
static inline PetscBool SpaceIsAlong(const PetscReal v[3]) {
  const PetscReal rounding = 1e-12, across = PetscSqr(v[1]) + PetscSqr(v[2]);
  return (PetscBool)(across <= PetscSqr(rounding) * (PetscSqr(v[0]) + across));
}

#endif
