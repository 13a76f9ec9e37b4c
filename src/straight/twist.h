/* The twist of the straight rod in space: the twisting moment M that it bears and how far its
   section has turned. Where there is one it joins the two directions across: a small deflection
   y = x2 + i x3 of a round rod obeys
     D y_t = -(B y_pp)_pp + i M y_ppp - (P y_p)_p
   and one of two different bending stiffnesses feels them turn with the section. */
#ifndef TENDRIL_TWIST_H
#define TENDRIL_TWIST_H

#include "scene/scene.h"

/* The small deflections that can be looked at by themselves. */
typedef enum {
  WAY_X2,  /* x2, also all there is in the plane: bends about d3 */
  WAY_X3,  /* x3: bends about d2 */
  WAY_BOTH /* x2 and x3, joined */
} StraightWay;

enum { MOST_WAYS = 2 };

PetscBool StraightIsTwisted(Scene scene);
PetscInt StraightWays(Scene scene, StraightWay way[MOST_WAYS]);
PetscErrorCode StraightTwist(Scene scene, PetscInt n, const PetscReal s[], PetscReal t,
                             PetscReal *moment, PetscReal angle[]);

/* What B is to be multiplied by for one direction. */
static inline PetscReal StraightRatio(Scene scene, StraightWay way) {
  return way == WAY_X2 ? scene->space.ratio : 1;
}

#endif
