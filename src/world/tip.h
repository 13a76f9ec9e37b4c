/* The tip s = 1: what pushes on it, or holds it.
     free      m = 0,  n = f
     pinned    m = 0,  x as at the start
     clamped   theta and x as at the start
     slides    theta and x2 (in space x3, too) as at the start, n1 = f1
     carried   another rod holds it, and has its conditions (system/joints.h)
   or, with a path (path.h), as that says over time.
   f is the force on the tip: none; dead, -P along the clamp; follower, -P q; resistance, -P N v/r,
   r = sqrt(v^2 + beta), N a field as for friction. A free tip that meets a wall is pushed by it,
   too: it stands for a piece of the rod (contact.h). */
#ifndef TENDRIL_TIP_H
#define TENDRIL_TIP_H

#include "base/lead.h"
#include "world/load.h"
#include "world/path.h"

typedef enum { TIP_FREE, TIP_PINNED, TIP_CLAMPED, TIP_SLIDES, TIP_CARRIED } TipType;
typedef enum { TIP_DEAD, TIP_FOLLOWER, TIP_RESISTANCE } TipLaw;

enum { TIP_ROWS = 3, TIP_FIELDS = 6 };

typedef struct {
  TipType type;
  TipLaw law;
  PetscReal force;       /* P */
  Load resistance;       /* its friction is that of the tip: dry, of strength 1; its field is N */
  PetscReal x[3], theta; /* where it is held, once the scene knows */
  const Contact *walls;  /* NULL: none; borrowed */
  PetscReal push[3];     /* dead force beside, in the clamp's frame */
  PetscReal torque;      /* in space: about d1 of the tip, turns with it */
  PetscReal p[4];        /* in space: what theta leaves out of how it is held */
  Path path;             /* over time; NULL: it is held where it is at the start */
  Lead lead[3], turned;  /* place and angle, as a run has changed them; not on: it has not */
  /* What tells by how much it is off is a moment and a force in the rod's units, as the other
     conditions are: the turn and the place are multiplied by these. */
  PetscReal per_turn, per_place;
} Tip;

enum { TIP_ROWS3 = 6, TIP_FIELDS3 = 13 };

/* The state of the tip, in the clamp's frame: how it is turned, in the plane by an angle, in space
   by a quaternion; moment (in the plane about x3) and force. */
typedef struct {
  Place at;
  PetscReal theta, p[4], m[3], n[3];
  PetscReal q_p[3][4];   /* in space: how the tangent changes with p */
  PetscReal spin, per_W; /* ... spin of the material, and how that changes with the last of at.v */
} TipState;

extern const OptionGroup tip_options;

PetscErrorCode TipSetFromOptions(Tip *tip, const Load *load);
PetscErrorCode TipDestroy(Tip *tip);
const PetscReal *TipStill(const Tip *tip, PetscReal t, int axes, int fields,
                          const PetscReal rates[], PetscReal still[]);
void TipForce(int dims, const Tip *tip, const TipState *at, const FrictionDual *dual,
              PetscReal f[RUBS]);
PetscReal TipWalls(int dims, const Tip *tip, const TipState *at, const FrictionDual *dual,
                   PetscReal f[RUBS]);
void TipResidual(const Tip *tip, const TipState *at, const FrictionDual *dual,
                 PetscReal r[TIP_ROWS]);
void TipJacobian(const Tip *tip, const TipState *at, const PetscReal shift[], PetscBool fresh,
                 FrictionDual *dual, PetscReal J[TIP_ROWS][TIP_FIELDS]);
void TipResidual3(const Tip *tip, const TipState *at, const FrictionDual *dual,
                  PetscReal r[TIP_ROWS3]);
void TipJacobian3(const Tip *tip, const TipState *at, const PetscReal dW[RUBS][TIP_FIELDS3],
                  PetscBool fresh, FrictionDual *dual, PetscReal J[TIP_ROWS3][TIP_FIELDS3]);
void TipHeldFrame(const Tip *tip, PetscReal t, PetscReal p[4]);
PetscReal TipHold(int dims, const Tip *tip, const TipState *at, PetscReal seen,
                  FrictionDual dual[]);
PetscErrorCode TipSetPath(Tip *tip, MPI_Comm comm, PetscReal length, const PetscReal lab[3][3],
                          PetscBool space);
void TipLeadTo(Tip *tip, PetscReal t, PetscReal by, const PetscReal x[3]);
void TipTurnTo(Tip *tip, PetscReal t, PetscReal by, PetscReal angle);
PetscReal TipNextTurn(const Tip *tip, PetscReal t);
PetscReal TipCompression(const Tip *tip, const Place *at);

/* Is its direction held? */
static inline PetscBool TipPoints(const Tip *tip) {
  return (PetscBool)(tip->type == TIP_CLAMPED || tip->type == TIP_SLIDES);
}

/* Is it held along the axis d of the clamp's frame? */
static inline PetscBool TipHolds(const Tip *tip, int d) {
  return (PetscBool)(tip->type == TIP_PINNED || tip->type == TIP_CLAMPED ||
                     (tip->type == TIP_SLIDES && d > 0));
}

/* Is the tip's force one of resistance? */
static inline PetscBool TipResists(const Tip *tip) {
  return (PetscBool)(tip->type == TIP_FREE && tip->force != 0 && tip->law == TIP_RESISTANCE);
}

#endif
