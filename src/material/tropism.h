/* Natural curvature that the material learns while it grows: it turns towards gravity or a lamp,
   straightens, nutates, gives way to its moments (docs/theory/growth.md). */
#ifndef TENDRIL_TROPISM_H
#define TENDRIL_TROPISM_H

#include "curve/place.h"
#include "material/growth.h"

enum { TROPISM_BENDS = 2 }; /* about d3, that of the plane, and about d2 */

typedef struct {
  PetscBool any;            /* there is such a curvature */
  PetscReal gravity, light; /* b, b_l */
  PetscReal direction[3];   /* of gravity's pull, of length 1; in the clamp's frame, as is */
  PetscReal source[3];      /* the place of the lamp */
  PetscReal proprioception; /* G */
  PetscReal ironing;        /* I */
  PetscReal nutation[2];    /* about d3, about d2 */
  PetscReal nutation_rate;  /* radians per time */
  PetscReal memory;         /* T; 0: none */
  PetscReal rate;           /* r, in place of the strain rate of growth, if it is */
  PetscBool by_rate;        /* given */
  PetscBool senses;         /* gravity or light */
  PetscBool at_tip;         /* ... at the tip, for all of the rod */
  const char *why;          /* the option that takes the rod out of the plane; NULL: none */
} Tropism;

extern const OptionGroup tropism_options;

PetscErrorCode TropismSetFromOptions(Tropism *tropism, Growth growth);
void TropismFrame(Tropism *tropism, const PetscReal lab[3][3], const PetscReal place[3]);
PetscErrorCode TropismChange(Tropism *tropism, const char *name, const PetscReal lab[3][3],
                             const PetscReal place[3], PetscBool space);
PetscReal TropismDriveAt(const Tropism *tropism, const Place *at, int bend, PetscReal signal,
                         PetscReal u0, PetscReal elastic);
PetscReal TropismNearLamp(const Tropism *tropism, const PetscReal from[3], const PetscReal to[3]);

/* Does the material bend by itself at all? (Beside growth that feels force `any` holds without.) */
static inline PetscBool TropismLearns(const Tropism *law) {
  return (PetscBool)(law->senses || law->proprioception > 0 || law->ironing > 0 ||
                     law->nutation[0] != 0 || law->nutation[1] != 0);
}

/* The clock a of the law: how fast the material there stretches, or the rate that is given. */
static inline PetscReal TropismClock(const Tropism *tropism, Growth growth, PetscReal s,
                                     PetscReal t, PetscReal g, PetscReal g_t) {
  return tropism->by_rate ? tropism->rate : GrowthStrain(growth, s, t, g_t) / g;
}

/* What sets the bend about d3 (0) or d2 (1) beside what is sensed: n cos(om t), -n2 sin(om t). */
static inline PetscReal TropismNutation(const Tropism *tropism, int bend, PetscReal t) {
  const PetscReal angle = tropism->nutation_rate * t;

  return bend ? -tropism->nutation[1] * PetscSinReal(angle)
              : tropism->nutation[0] * PetscCosReal(angle);
}

/* Adds to a pull, and to its derivatives by x (may be NULL), those of the lamp. */
void TropismLamp(const Tropism *tropism, const PetscReal x[3], PetscReal pull[3],
                 PetscReal (*by_x)[3]);

/* The direction, times its strength, towards which a place turns, and its derivatives by x (may be
   NULL). */
static inline void TropismPull(const Tropism *tropism, const PetscReal x[3], PetscReal pull[3],
                               PetscReal (*by_x)[3]) {
  for (int i = 0; i < 3; i++) {
    pull[i] = tropism->gravity * tropism->direction[i];
    for (int j = 0; j < 3 && by_x; j++) by_x[i][j] = 0;
  }
  if (tropism->light != 0) TropismLamp(tropism, x, pull, by_x);
}

/* What is sensed along d3, pull.d2, and along d2, -pull.d3. */
static inline PetscReal TropismSensed(const Place *at, int bend, const PetscReal pull[3]) {
  const PetscReal *d = at->axes[bend ? 2 : 1];
  const PetscReal along = pull[0] * d[0] + pull[1] * d[1] + pull[2] * d[2];

  return bend ? -along : along;
}

/* What Dk/Dt/a is of one bend: f - G u + I m/B + nutation, at a natural curvature u0 (with k) and
   the elastic bend m/B. */
static inline PetscReal TropismDrive(const Tropism *tropism, PetscReal f, PetscReal u0,
                                     PetscReal elastic, PetscReal nutation) {
  return f - tropism->proprioception * (elastic + u0) + tropism->ironing * elastic + nutation;
}

#endif
