/* The cells of the model of space, as its files share them: what is known at their ends and in
   their middle in a state of the unknowns (space.c has the equations). */
#ifndef TENDRIL_SPACE_CELLS_H
#define TENDRIL_SPACE_CELLS_H

#include "rod/directors.h"
#include "rod/feet.h"
#include "rod/learned.h"
#include "rod/rod.h"
#include "rod/strand_rows.h"
#include "rod/spin.h"

enum { X, P = 3, M = 7, N = 10, FIELDS = 13, LEFT = M, RIGHT = FIELDS - LEFT };
/* ... and of a rod whose growth feels force (space_yield.c). */
enum { OF_V = FIELDS, OF_L, YIELD_FIELDS };

/* What the laws give at a point; flex = 1/S. */
typedef struct {
  PetscReal s, g, g_t, c, u0[3], flex[3];
  TwistRate twist; /* where friction along the rod feels the spin */
} Law;

/* A point of the rod: its unknowns, what follows from them, and f. */
typedef struct {
  PetscReal p[4], m[3], n[3], size, u[3], f[FIELDS];
  PetscReal couple[3];               /* of friction, in f */
  PetscReal p_t[4], m_t[3], d1_t[3]; /* rates, that of d1 at nodes */
  Place at;
} Point;

typedef struct {
  PetscReal end_weight, mid_weight, bow; /* times h: 1/6, 4/6, 1/8 (order 4); 0, 1, 0 (order 2) */
  PetscReal time;                        /* of the laws below */
  Law *law;                              /* nodes and mids from node first - 1 on, alternating */
  Point *point; /* likewise, in the state seen, and what that was asked for */
  RodSeen seen;
  PetscBool fresh, iterates, counts;
  FrictionDual *dual; /* likewise, duals of each; the tip's own where a cell behind it would be */
  PetscInt duals;
  FrictionDual *foot_dual; /* of cells, likewise: of their feet, WALL_SLOTS each; NULL: none */
  PetscBool *split; /* of cells, from that before node first on, in this Newton solve; NULL: none */
  StrandRows strands; /* NULL: the rod does not touch itself */
  PetscBool yields;   /* its growth feels force */
} Space_;

/* A walk along the cells that touch owned nodes. */
typedef struct {
  Rod rod;
  PetscReal t, h;
  PetscBool fresh;    /* a Newton solve begins here */
  PetscBool iterates; /* ... or goes on */
  PetscBool counts;   /* modes are counted in it */
  PetscBool cubics;   /* the spin in the middle of a cell is that of Hermite's cubic, */
  PetscBool cubic;    /* ... also of this one */
  PetscBool split; /* the rod rests at one end of this cell, or turns the other way: see Splits() */
  const Load *load;
  const PetscReal (*u)[FIELDS], (*u_t)[FIELDS], *s;
  Vec local, local_t;
  Law *law; /* of nodes a, mid, b of the cell */
  FrictionDual *dual[3];
  const PetscReal (*push)[3];   /* what strands add to n' at all points of the rod; NULL: none */
  const PetscReal (*couple)[3]; /* and to m' */
  PetscBool known;              /* the points are: the state is that of the latest walk */
  Point *a, *mid, *b;
  PetscBool thin;     /* there may be feet */
  FootCell foot_cell; /* of this cell, ... */
  Feet feet;          /* ... what it is to what stands out, */
  FootLoad foot_load; /* and what that adds to n' and m' at its points alone */
} Cell;

/* What a cell that is split adds to the moment in its middle, times the couple at its beginning,
   and takes off times that at its end, so that the moment along it is that between couples at
   nodes. */
static inline PetscReal SplitBow(const Cell *cell) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  return cell->h * (0.25 / self->mid_weight - self->bow);
}

/* f at a point whose unknowns, place and velocity are set */
static inline void PointEvaluate(const Load *load, const Law *law, const FrictionDual *dual,
                                 Point *p) {
  const PetscReal *q = p->at.axes[0], g = law->g;
  PetscReal load_[RUBS], turned[3];

  LoadForce(3, load, &p->at, dual, load_);
  QuaternionTurn(p->p, p->u, p->f + P);
  for (int i = 0; i < 4; i++) p->f[P + i] *= g / 2;
  Cross3(q, p->n, turned);
  for (int i = 0; i < 3; i++) {
    p->f[M + i] = -g * turned[i];
    p->f[X + i] = g * q[i];
    if (load->arm > 0) p->f[M + i] += p->couple[i] = g * load_[SPIN] * q[i];
    p->f[N + i] = g * load_[i];
  }
}

/* Directors and strains from p and m, and the spin. */
static inline void PointStrains(const Load *load, const Law *law, Point *p) {
  p->size = QuaternionSize(p->p);
  Directors(p->p, p->size, p->at.axes);
  for (int k = 0; k < 3; k++) p->u[k] = law->flex[k] * Dot3(p->at.axes[k], p->m) + law->u0[k];
  p->at.v[SPIN] = 0;
  if (load->arm > 0)
    p->at.v[SPIN] = load->arm * (QuaternionSpin(p->p, p->size, p->p_t) + law->c * p->u[0]);
}

/* d1_t at a node. */
static inline void DirectorRate(Point *p) {
  PetscReal D[3][4];

  DirectorSlope(p->p, p->size, p->at.axes[0], 0, D);
  for (int i = 0; i < 3; i++) p->d1_t[i] = Dot4(D[i], p->p_t);
}

/* The rates at node i, or their shifts: a place that is held at rest has none. */
static inline const PetscReal *SpaceStill(const Cell *cell, PetscInt i, const PetscReal *rates,
                                          PetscReal still[FIELDS]) {
  if (i < cell->rod->last) return rates;
  return TipStill(&cell->rod->scene->tip, cell->t, 3, FIELDS, rates, still);
}

/* The slope x'_t = g_t d1 + g d1_t of the velocity at a node. */
static inline void VelocitySlope(const Law *law, const Point *p, PetscReal w[3]) {
  for (int i = 0; i < 3; i++) w[i] = law->g_t * p->at.axes[0][i] + law->g * p->d1_t[i];
}

/* Is the spin in the middle of a cell that of Hermite's cubic? It takes the rate of the moment, and
   so is left where friction along the rod does not feel the spin (what walls do comes at once), and
   where modes are counted: with that rate no energy is behind the equations of a cell. */
static inline PetscBool SpinCubic(Rod rod, const RodState *at) {
  const Space_ *self = (const Space_ *)rod->data;
  return (PetscBool)(rod->scene->load.radius > 0 && self->bow > 0 && !at->counts);
}

/* How the spin of the directors changes along the rod at a node, see rod/spin.h. */
static inline PetscReal NodeSpinSlope(const Law *law, const Point *p) {
  return SpinSlope(law->g, law->g_t, &law->twist, law->flex[0], p->at.axes, p->u, p->m, p->m_t,
                   p->d1_t);
}

/* The duals of point k of the rank's: of friction along the rod, and of walls. */
static inline FrictionDual *Duals(const Space_ *self, PetscInt k) {
  return self->dual + k * self->duals;
}

/* Those of the feet of the cell behind node i. */
static inline FeetHeld FeetHeldAt(const Cell *cell, PetscInt i) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  return self->foot_dual ? self->foot_dual + (i - cell->rod->first + 1) * WALL_SLOTS : NULL;
}

void SpaceCellsForget(Space_ *self);
PetscErrorCode SpaceCellsOpen(Rod rod, const RodState *at, Cell *cell);
void SpaceCellsNext(Cell *cell, PetscInt i);
PetscErrorCode SpaceCellsClose(Cell *cell);

/* space_ends.c */
TipState SpaceTipOf(const Load *load, const Point *end);
FrictionDual *SpaceTipDual(Rod rod);
void SpaceClampResidual(Scene scene, PetscReal t, const PetscReal u[FIELDS], PetscReal r[FIELDS]);
void SpaceClampBlock(Scene scene, PetscReal t, const PetscReal u[FIELDS],
                     PetscReal by[LEFT][FIELDS]);

/* space_matrix.c */
PetscErrorCode SpaceJacobian(Rod rod, const RodState *at, Mat J);
PetscErrorCode SpaceEliminate(Rod rod, const RodState *at, Elimination elimination);

/* space_memory.c */
PetscErrorCode SpaceBears(Rod rod, const RodState *at, RodForces *sum);
PetscErrorCode SpaceHold(Rod rod, const RodState *at, PetscReal seen, PetscReal *creep);
PetscInt SpaceRemembers(const Load *load);
PetscReal *SpaceRemembered(Rod rod, PetscInt i, PetscInt k);
PetscErrorCode SpaceRecalled(Rod rod);

/* space_start.c */
PetscErrorCode SpaceInitial(Rod rod, PetscReal t, Node *nodes);

/* space_learned.c */
void SpaceLearnedLaws(Rod rod, PetscReal t);
PetscErrorCode SpaceLearnedOpen(Rod rod, const RodState *at);
void SpaceLearnedResidual(Rod rod, PetscInt i, const Point *p, const Point *mid);
void SpaceLearnedSlope(const Rod rod, PetscInt place, const Point *p, const PetscReal (*u_p)[4],
                       const PetscReal (*u_m)[3], LearnedSlope *slope);
void SpaceLearnedTurn(const Law *law, const Point *p, int bend, PetscReal by[4]);
void SpaceLearnedDrives(Rod rod, PetscInt i, const Point *p, const Point *mid);

/* space_yield.c */
PetscErrorCode SpaceYieldSee(Rod rod, PetscReal t, Vec U);
void SpaceYieldLaws(Rod rod);
void SpaceYieldResidual(const Cell *cell, PetscInt i);
void SpaceYieldEnds(Rod rod, PetscInt i, const Point *p);
PetscErrorCode SpaceYieldJacobian(Rod rod, const RodState *at, Mat J);
PetscErrorCode SpaceYieldEliminate(Rod rod, const RodState *at, Elimination elimination);

/* space_defect.c */
PetscErrorCode SpaceDefect(Rod rod, const RodState *at, PetscReal (*defect)[MAX_FIELDS]);

#endif
