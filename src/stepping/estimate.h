/* How far a run has gone astray: its errors in time and in space, of friction that is taken for
   exact and of contact that is not rigid, measured on the way and carried along by the linearised
   equations. */
#ifndef TENDRIL_ESTIMATE_H
#define TENDRIL_ESTIMATE_H

#include "stepping/leg.h"

typedef struct _Estimate *Estimate;

enum { ESTIMATE_SPACE, ESTIMATE_TIME, ESTIMATE_LIMIT, ESTIMATE_SOFT, ESTIMATE_PARTS };
enum { ESTIMATE_TIP, ESTIMATE_NORM, ESTIMATE_ENERGY, ESTIMATE_SEEN };
enum { RIGID_TIP, RIGID_ENERGY = 3, RIGID_VALUES };

/* What is kept of it for a restart: what is counted, numbers, and errors as states of the rod. */
enum {
  ESTIMATE_COUNTS = 5,
  ESTIMATE_NUMBERS = 2 + 3 * MIRRORS + (1 + 2 * ESTIMATE_PARTS) * ESTIMATE_SEEN + RIGID_VALUES
};
enum { ESTIMATE_MEMORY = ESTIMATE_COUNTS + ESTIMATE_NUMBERS, ESTIMATE_KEPT = ESTIMATE_PARTS + 2 };

/* How far off: in each of what is seen, by each of the parts, and in all. */
typedef struct {
  PetscReal all, part[ESTIMATE_PARTS], seen[ESTIMATE_SEEN];
} Errors;

/* What an error is the largest of its run by: one of the parts, or what came just then. */
enum { WHY_TOUCH = ESTIMATE_PARTS, WHY_LETS_GO, WHY_SNAP, WHYS };

/* How far off a run may be: over all of it, with times and reasons, and in its last state; and by
   how much its tip and energy would differ, to first order, if contact were rigid. */
typedef struct {
  enum { ESTIMATE_NONE, ESTIMATE_MEASURED, ESTIMATE_FITTED } kind;
  Errors most, end;
  PetscReal when[ESTIMATE_SEEN], rigid[RIGID_VALUES];
  int why[ESTIMATE_SEEN];
  PetscBool pressed; /* the rod has touched something: rigid is known */
} ErrorEstimate;

/* Where errors have become as large as all that is seen, of a mode that grows while nothing happens
   to the rod: to which side it has gone with it is not known (tasks/grow_errors.c). */
typedef struct {
  PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN]; /* errors then; 0: they have not */
  PetscReal at[ESTIMATE_SEEN];                   /* when */
  PetscReal mark[2], before[2][ESTIMATE_SEEN];   /* times, the later one and one of half of it at
                                                    most, and what errors were then */
} Astray;
enum { ASTRAY_NUMBERS = sizeof(Astray) / sizeof(PetscReal) };

PetscErrorCode EstimateCreate(Leg *leg, Estimate *estimate);
PetscErrorCode EstimatePart(Estimate whole, PetscInt k, Leg *leg, Estimate *estimate);
PetscErrorCode EstimateDestroy(Estimate *estimate);
PetscErrorCode EstimateSceneChanged(Estimate estimate);
PetscErrorCode EstimateStep(Estimate estimate, PetscBool jumped, PetscBool touches);
void EstimateGives(Estimate estimate, PetscReal gives);
PetscErrorCode EstimateReported(Estimate estimate,
                                PetscReal reported[ESTIMATE_PARTS][ESTIMATE_SEEN]);
void EstimateLatest(Estimate estimate, PetscReal latest[ESTIMATE_PARTS][ESTIMATE_SEEN],
                    PetscReal rigid[RIGID_VALUES]);
PetscBool EstimateIsEarly(Estimate estimate, PetscReal t, int seen);
PetscErrorCode EstimateGet(Estimate estimate, PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN]);
PetscErrorCode EstimateSet(Estimate estimate, PetscReal t,
                           const PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN]);
PetscErrorCode EstimateVectors(Estimate estimate, Vec errors[ESTIMATE_KEPT]);
PetscErrorCode EstimateVectorsDestroy(Estimate estimate, Vec errors[ESTIMATE_KEPT]);
PetscErrorCode EstimateKeep(Estimate estimate, PetscReal memory[ESTIMATE_MEMORY],
                            Vec errors[ESTIMATE_KEPT]);
PetscErrorCode EstimateTake(Estimate estimate, const PetscReal memory[ESTIMATE_MEMORY],
                            Vec errors[ESTIMATE_KEPT]);

#endif
