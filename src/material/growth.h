/* Growth laws: the prescribed stretch g(s,t) = |x'|, the arc length p(s,t) = int_0^s g, and the
   speed c(s,t) at which material slides past the labels (docs/theory/growth.md). */
#ifndef TENDRIL_GROWTH_H
#define TENDRIL_GROWTH_H

#include "base/bends.h"
#include "base/options.h"

typedef struct _Growth *Growth;
struct _Growth {
  const char *type;
  PetscReal initial_length; /* L0 */
  PetscReal rate;           /* V, of one of several rods over that of the scales; else 1 */
  PetscReal end_time;       /* the law is defined up to here */
  PetscBool even;           /* g does not depend on s: labels share out the length evenly */
  PetscBool similar;        /* the straight rod's velocity depends on s alone, not on t */
  PetscBool slides;         /* material slides past the labels: c is not 0 */
  PetscBool rests;          /* there is material at rest, behind a growth zone */
  PetscBool still;          /* it does not grow, and is not fed */
  PetscReal finest;         /* length of a zone at the tip that the mesh must resolve; 0: none */
  PetscReal narrow;         /* width in s of a growth zone at the clamp; 0: there is none */
  PetscReal steep;          /* least s over which a table's g changes by itself; 0: no table */
  PetscReal fastest;        /* speed of a rod that is fed by a schedule; 0: there is none */
  PetscReal yield; /* Pi, the thrust that stalls it: growth_yield.c; 0: it feels no force */
  PetscErrorCode (*stretch)(Growth, PetscReal s, PetscReal t, PetscReal *g, PetscReal *g_t,
                            PetscReal *g_s);
  PetscErrorCode (*arc)(Growth, PetscReal s, PetscReal t, PetscReal *p, PetscReal *p_t);
  /* where material slides; NULL unless it does */
  PetscReal (*slide)(Growth, PetscReal s, PetscReal t);
  PetscReal (*speed)(Growth, PetscReal s, PetscReal t);
  PetscReal (*strain)(Growth, PetscReal s, PetscReal t);
  PetscErrorCode (*origin)(Growth, PetscReal s, PetscReal t, PetscReal *d, PetscReal *d_t);
  /* the labels at an earlier time of the material that is at n labels at t, which may be the same
     array; below 0: not in yet */
  PetscErrorCode (*depart)(Growth, PetscReal t, PetscReal before, PetscInt n, const PetscReal s[],
                           PetscReal from[]);
  /* the label of the front between what was there at first and what has been fed in since; NULL:
     nothing is, or it is pulled out again */
  PetscReal (*front)(Growth, PetscReal t);
  /* the first time behind t at which its length sets out, stops or turns back; NULL: never */
  PetscReal (*next_turn)(Growth, PetscReal t);
  /* adds the times at which it bends (base/bends.h); NULL: nothing is given by rows in time */
  PetscErrorCode (*bends)(Growth, PetscReal tolerance, Bends *bends);
  /* does its length set out or stop at once between two times? NULL: never */
  PetscBool (*jerks)(Growth, PetscReal t0, PetscReal t1);
  PetscErrorCode (*destroy)(Growth);
  void *data;
};

extern const OptionGroup growth_options;

PetscErrorCode GrowthCreate(Growth *growth);
PetscErrorCode GrowthDestroy(Growth *growth);
PetscErrorCode GrowthStretch(Growth growth, PetscInt n, const PetscReal s[], PetscReal t,
                             PetscReal g[], PetscReal g_t[], PetscReal g_s[]);
PetscErrorCode GrowthArc(Growth growth, PetscInt n, const PetscReal s[], PetscReal t, PetscReal p[],
                         PetscReal p_t[]);
PetscErrorCode GrowthLength(Growth growth, PetscReal t, PetscReal *length, PetscReal *length_t);
PetscErrorCode GrowthLongest(Growth growth, PetscReal end, PetscReal *length);
const char *GrowthOutlook(Growth growth);
PetscReal GrowthFrontFed(Growth growth, PetscReal t);
PetscErrorCode GrowthDestroyData(Growth growth);
PetscErrorCode GrowthDepartFed(Growth growth, PetscReal t, PetscReal before, PetscInt n,
                               const PetscReal s[], PetscReal from[]);

/* creators that have a file of their own */
PetscErrorCode GrowthCreateTable(Growth growth);
PetscErrorCode GrowthPathGiven(Growth growth, PetscBool *given);
PetscErrorCode GrowthFeedByPath(Growth growth);
PetscErrorCode GrowthFeedOn(Growth growth, PetscReal t, PetscReal speed);

/* growth_follow.c: seen from labels that go with material, and by a clock of its own */
PetscErrorCode GrowthDelay(Growth growth, PetscReal born);
PetscReal GrowthRests(Growth growth, PetscReal distance);
PetscErrorCode GrowthFollow(Growth growth, PetscInt n, const PetscReal along[], PetscReal end,
                            PetscInt nodes, PetscReal s[], PetscReal label[]);

/* growth that feels force: what a model finds of it */
PetscErrorCode GrowthYields(Growth growth);
PetscErrorCode GrowthYieldSee(Growth growth, PetscReal t, PetscInt n, const PetscReal s[],
                              PetscReal length, const PetscReal V[], const PetscReal V_s[]);
PetscErrorCode GrowthYieldKeep(Growth growth, PetscInt m, const PetscReal times[],
                               const PetscReal length[], PetscInt n, const PetscReal s[],
                               const PetscReal V[]);
PetscErrorCode GrowthYieldFollow(Growth growth, PetscInt n, const PetscReal t[],
                                 const PetscReal length[], const PetscReal rate[]);
PetscReal GrowthYieldWeight(Growth growth, PetscReal s, PetscReal length, PetscReal *by_length);
PetscReal GrowthYieldInflow(Growth growth);

/* Convective speed of the material along the rod: v = x_t + c q. */
static inline PetscReal GrowthSlide(Growth growth, PetscReal s, PetscReal t) {
  return growth->slides ? growth->slide(growth, s, t) : 0;
}

/* The speed of the material along a straight rod, V = p_t + c, without cancellation: 0 where it is
   at rest. */
static inline PetscReal GrowthSpeed(Growth growth, PetscReal s, PetscReal t, PetscReal p_t) {
  return growth->slides ? growth->speed(growth, s, t) : p_t;
}

/* How fast the material there stretches, times g: g_t + c_s. */
static inline PetscReal GrowthStrain(Growth growth, PetscReal s, PetscReal t, PetscReal g_t) {
  return growth->slides ? growth->strain(growth, s, t) : g_t;
}

/* The label of the front of what is fed in, of a law that has one. */
static inline PetscReal GrowthFront(Growth growth, PetscReal t) {
  return growth->front(growth, t);
}

/* Where material slides: the distance from the tip that the material there had at the start (of fed
   material: its place on the tube that is not in yet, beyond the clamp), and its rate. */
static inline PetscErrorCode GrowthOrigin(Growth growth, PetscReal s, PetscReal t, PetscReal *d,
                                          PetscReal *d_t) {
  return growth->origin(growth, s, t, d, d_t);
}

#endif
