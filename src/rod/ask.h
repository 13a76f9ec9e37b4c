/* What steppers ask of a rod, or of several that go together: each question is answered for all of
   them at once. */
#ifndef TENDRIL_ASK_H
#define TENDRIL_ASK_H

#include "rod/rod.h"

/* What holds the ends. Of several rods: held and bound where any is, free where any is. */
typedef struct {
  PetscBool clamped, begins_free; /* the beginning neither tilts nor moves; nothing holds it */
  PetscBool gives_way, carried;   /* it tilts or moves on what holds it; that is another rod */
  PetscBool tip_held, tip_rests, tip_points; /* the tip; at rest; its directors, too */
} RodEnds;

/* the part of a vector of the unknowns that is one rod's; all of it, of one rod */
PetscErrorCode RodPartOpen(const Rod rod, PetscInt k, Vec all, Vec *part);
PetscErrorCode RodPartClose(const Rod rod, PetscInt k, Vec all, Vec *part);
PetscErrorCode RodPartOpenRead(const Rod rod, PetscInt k, Vec all, Vec *part);
PetscErrorCode RodPartCloseRead(const Rod rod, PetscInt k, Vec all, Vec *part);

/* where the nodes of one are among the owned ones: from, and up to, so many */
static inline void RodPartNodes(const Rod rod, PetscInt k, PetscInt *begin, PetscInt *end) {
  *begin = rod->at ? rod->at[k] : 0;
  *end = rod->at ? rod->at[k + 1] : rod->end - rod->first;
}

/* its ends, length and units */
RodEnds RodEndsOf(const Rod rod);
PetscInt RodLate(const Rod rod, PetscInt late[]);
PetscErrorCode RodLength(const Rod rod, PetscReal t, PetscReal *length);
PetscErrorCode RodStiffnessAt(const Rod rod, PetscInt node, PetscReal t, PetscReal *g,
                              PetscReal S[3]);
PetscReal RodLongest(const Rod rod);
const PetscReal *RodLabels(const Rod rod);
void RodPassed(const Rod rod, PetscReal t0, PetscReal t1, PetscReal *from, PetscReal *to);
PetscReal RodEndTime(const Rod rod);
const SceneUnits *RodUnits(const Rod rod);

/* what it can touch */
PetscBool RodTouches(const Rod rod);
PetscBool RodMeetsWalls(const Rod rod);
PetscBool RodMeetsStrands(const Rod rod);
PetscBool RodRubsOnWalls(const Rod rod);
void RodMakeSlippery(Rod rod, PetscBool slippery);
PetscReal RodLayer(const Rod rod);
PetscErrorCode RodContactAt(Rod rod, PetscReal t);
PetscBool RodMayGetFirm(const Rod rod);
void RodForgetDepth(Rod rod);
PetscErrorCode RodGetsFirm(Rod rod, PetscBool *firm);
void RodStaysFirm(Rod rod);

/* its friction */
PetscBool RodIsDry(const Rod rod);
PetscBool RodSticks(const Rod rod);
PetscBool RodIsViscous(const Rod rod);
PetscBool RodIsLimit(const Rod rod);
PetscBool RodFeelsSpin(const Rod rod);
void RodSwapSlopes(Rod rod, FrictionNewton slope[2]);
PetscBool RodHasModes(const Rod rod);

/* how it snaps */
PetscReal RodFalls(const Rod rod);
void RodAtSpeed(Rod rod, PetscReal speed);

/* what drives it */
PetscReal RodSteered(const Rod rod, PetscInt field);
PetscReal RodSteeredTo(const Rod rod);
PetscReal RodRounding(const Rod rod, PetscReal length);
PetscReal RodNextTurn(const Rod rod, PetscReal t);
PetscBool RodMayJerk(const Rod rod);
PetscBool RodJerks(const Rod rod, PetscReal t0, PetscReal t1);

#endif
