/* Growth laws: the prescribed stretch g(s,t) = |x'| and the arc length p(s,t) = int_0^s g. */
#ifndef TENDRIL_GROWTH_H
#define TENDRIL_GROWTH_H

#include <petscsys.h>

typedef struct _Growth *Growth;
struct _Growth {
  char type[16];
  PetscReal initial_length; /* L0 */
  PetscReal end_time;       /* the law is defined up to here */
  PetscBool uniform;        /* g does not depend on s */
  PetscBool slides;         /* feed: the rod slides through the clamp, c = 1 - s */
  PetscBool stopped;        /* GrowthStop(): stands still at one time of another law */
  PetscErrorCode (*stretch)(Growth, PetscReal s, PetscReal t, PetscReal *g, PetscReal *g_t,
                            PetscReal *g_s);
  PetscErrorCode (*arc)(Growth, PetscReal s, PetscReal t, PetscReal *p, PetscReal *p_t);
  PetscErrorCode (*destroy)(Growth);
  void *data;
};

PetscErrorCode GrowthCreate(Growth *growth);
PetscErrorCode GrowthDestroy(Growth *growth);
PetscErrorCode GrowthStop(Growth law, PetscReal t, Growth *stopped);
PetscErrorCode GrowthStretch(Growth growth, PetscInt n, const PetscReal s[], PetscReal t,
                             PetscReal g[], PetscReal g_t[], PetscReal g_s[]);
PetscErrorCode GrowthArc(Growth growth, PetscInt n, const PetscReal s[], PetscReal t, PetscReal p[],
                         PetscReal p_t[]);
PetscErrorCode GrowthLength(Growth growth, PetscReal t, PetscReal *length, PetscReal *length_t);

/* Convective speed of the material along the rod (theory.md section 3): v = x_t + c q. */
static inline PetscReal GrowthSlide(Growth growth, PetscReal s) {
  return growth->slides && !growth->stopped ? 1 - s : 0;
}

#endif
