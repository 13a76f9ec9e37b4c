/* What the files of the frame model share. */
#ifndef TENDRIL_FRAME_H
#define TENDRIL_FRAME_H

#include "rod/feet.h"
#include "rod/learned.h"
#include "rod/rod.h"
#include "rod/strand_rows.h"

enum { X1, X2, TH, M, N1, N2, FIELDS };

/* What the laws give at a point; flex = 1/B. */
typedef struct {
  PetscReal s, g, g_t, c, k0, flex;
} Law;

/* One point of the rod: its unknowns, f, its place and velocity. */
typedef struct _Point {
  PetscReal theta, m, n[2], f[FIELDS];
  Place at;
} Point;

typedef struct {
  PetscReal end_weight, mid_weight, bow; /* times h: 1/6, 4/6, 1/8 (order 4); 0, 1, 0 (order 2) */
  PetscReal time;                        /* of the laws below */
  Law *law;                              /* nodes and mids from node first - 1 on, alternating */
  Point *point;                          /* likewise, in the state seen */
  RodSeen seen;
  FrictionDual *dual; /* likewise, duals of them at each */
  PetscInt duals;
  FootLoad *feet;     /* of each cell, from that before node first on; NULL: no posts */
  StrandRows strands; /* NULL: the rod does not touch itself */
  PetscBool yields;   /* its growth feels force: frame_yield.c */
} Frame;

/* f at a point */
static inline void PointEvaluate(const Load *load, const Law *law, const FrictionDual *dual,
                                 Point *p) {
  const PetscReal *q = p->at.axes[0];
  PetscReal F[RUBS];

  p->f[X1] = law->g * q[0];
  p->f[X2] = law->g * q[1];
  p->f[TH] = law->g * (p->m * law->flex + law->k0);
  p->f[M] = -law->g * (q[0] * p->n[1] - q[1] * p->n[0]);
  LoadForce(2, load, &p->at, dual, F);
  p->f[N1] = law->g * F[0];
  p->f[N2] = law->g * F[1];
}

/* The slope x'_t = g_t q + g theta_t q_perp of the velocity at a node. */
static inline Vector2 VelocitySlope(const Law *law, const Point *p, PetscReal theta_t) {
  const Vector2 q = From2(p->at.axes[0]);

  return Along2(Times2(law->g_t, q), law->g * theta_t, Left2(q));
}

/* The duals of point k: nodes and mids alternate, from node first - 1 on. */
static inline FrictionDual *FrameDuals(const Frame *frame, PetscInt k) {
  return frame->dual + k * frame->duals;
}

/* A cell of a rod whose growth feels force: nodes a and b, and its middle between them. */
enum { YIELD_FIELDS = FIELDS + 2 };

typedef struct {
  PetscInt place;            /* of a */
  PetscBool tip;             /* b is the tip */
  PetscReal h, bow, turn[2]; /* 1/8 of h, or 0; theta_t of both nodes */
  const PetscReal *shift[2];
  const Law *law;
  const Point *at[3];
  const LoadSlope *slope[3];
  const PetscReal (*load)[FOOT_LOAD]; /* what feet do, and its slopes; NULL: there are none */
  const PetscReal (*feet)[FOOT_LOAD][FOOT_UNKNOWNS];
} YieldCell;

/* frame_yield.c */
PetscErrorCode FrameYieldSee(Rod rod, PetscReal t, Vec U);
void FrameYieldLaws(Rod rod);
void FrameYieldResidual(Rod rod, PetscInt i, PetscReal h, const Point *a, const Point *mid,
                        const Point *b);
void FrameYieldEnds(Rod rod, PetscInt i, const Point *p);
void FrameYieldBegin(Rod rod, const Point *p, PetscReal by[YIELD_FIELDS]);
void FrameYieldCell(Rod rod, const YieldCell *cell, PetscReal left[YIELD_FIELDS][YIELD_FIELDS],
                    PetscReal right[YIELD_FIELDS][YIELD_FIELDS], LearnedCell *learned);

/* frame_defect.c */
PetscErrorCode FrameDefect(Rod rod, const RodState *at, PetscReal (*defect)[MAX_FIELDS]);

/* frame_learned.c */
void FrameLearnedLaws(Rod rod, PetscReal t);
PetscErrorCode FrameLearnedOpen(Rod rod, const RodState *at);
void FrameLearnedResidual(Rod rod, PetscInt i, PetscReal h, const Point *p, const Point *mid,
                          const Point *b);
void FrameLearnedDrives(Rod rod, PetscInt i, PetscReal h, const Point *a, const Point *mid,
                        const Point *b, PetscBool at_a);
void FrameLearnedCell(Rod rod, PetscInt i, PetscReal h, const Point *a, const Point *mid,
                      const Point *b, PetscBool at_a, PetscBool at_b,
                      PetscReal left[FIELDS][FIELDS], PetscReal right[FIELDS][FIELDS],
                      LearnedCell *cell);
void FrameLearnedSlopes(Rod rod, PetscInt i, PetscReal h, const Point *a, const Point *mid,
                        const Point *b, PetscBool at_a, PetscBool at_b, LearnedCell *cell);

#endif
