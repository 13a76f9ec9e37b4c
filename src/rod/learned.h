/* Natural curvature that the material of a rod learns (material/tropism.h), as a model of the rod
   has it: states of the nodes and of the middles of cells beside the unknowns of its mechanics.
   They see only what is at their own place, so a linear solve eliminates them there, and that of
   the mechanics stays as wide as it is. */
#ifndef TENDRIL_LEARNED_H
#define TENDRIL_LEARNED_H

#include "curve/cell.h"
#include "rod/rod.h"

enum { LEARNED_MOST = 15, LEARNED_STENCIL = 6 }; /* unknowns of the mechanics of a node, at most */

/* By the unknowns of a point: what is sensed there, and its elastic bends. */
typedef struct {
  PetscReal sensed[TROPISM_BENDS][LEARNED_MOST], elastic[TROPISM_BENDS][LEARNED_MOST];
} LearnedSlope;

/* What a model tells of a cell between nodes a and b: its equations by the bends learned at a, in
   its middle and at b; slopes at these three; the unknowns in its middle by those of a and b, and
   by the bends learned there. */
typedef struct {
  PetscReal column[3][TROPISM_BENDS][LEARNED_MOST];
  LearnedSlope slope[3];
  /* the clocks at a, in the middle and at b by the unknowns of a and b, where growth feels force */
  PetscReal clock[3][2][LEARNED_MOST];
  PetscReal by_node[2][LEARNED_MOST][LEARNED_MOST], by_bend[2][TROPISM_BENDS][LEARNED_MOST];
} LearnedCell;

/* What is sensed at a point, its natural and its elastic bends. */
typedef struct {
  PetscReal sensed[TROPISM_BENDS], natural[TROPISM_BENDS], elastic[TROPISM_BENDS];
} LearnedPoint;

/* How the states of a place follow from the unknowns: dk = free + by.d + signal d(signal). */
typedef struct {
  PetscReal by[TROPISM_BENDS][LEARNED_MOST], signal[TROPISM_BENDS];
  PetscReal sensed[TROPISM_BENDS][LEARNED_MOST];                  /* of what it remembers */
  PetscReal clock, own[TROPISM_BENDS], own_memory[TROPISM_BENDS]; /* a; equations by themselves */
} LearnedRow;

/* Those of a cell, for right-hand sides. */
typedef struct {
  PetscReal column[3][TROPISM_BENDS][LEARNED_MOST];
  PetscReal mid[2][TROPISM_BENDS][LEARNED_MOST];    /* dk in the middle by both nodes */
  PetscReal chain[2][TROPISM_BENDS][TROPISM_BENDS]; /* ... by dk of both */
  PetscReal sensed[2][TROPISM_BENDS][LEARNED_MOST]; /* what is sensed there by both nodes */
  PetscReal sensed_chain[2][TROPISM_BENDS][TROPISM_BENDS];
  LearnedRow at_mid;
} LearnedFactor;

/* What the corner at a front adds to the turns of the cell that it is in: see LearnedFrontTurns().
 */
typedef struct {
  PetscInt cell; /* -1: there is none */
  PetscReal turn[TROPISM_BENDS], moment[TROPISM_BENDS], mid[TROPISM_BENDS];
} LearnedCorner;

typedef PetscErrorCode (*LearnedSees)(Rod rod, PetscReal t, const PetscReal u[],
                                      LearnedPoint *point);

/* What the laws of the labels are in a state, where growth feels force: stretch, its rate, slide.
 */
typedef struct {
  PetscReal g, g_t, c;
} LearnedStretch;

/* How the states of a model are condensed: learned_solve.c. */
typedef const struct LearnedKind_ *LearnedKind;

typedef struct Learned_ {
  LearnedKind kind;
  /* what is sensed at the clamp in a state at t, of node 0's unknowns, and its bends */
  LearnedSees sees;
  PetscInt mech, bends, per; /* unknowns of the mechanics, bends, states of a place */
  PetscInt lead;  /* of the mechanics, those that a rod has which feels no force when it grows; */
  PetscInt extra; /* ... and the two beside them that one has which does: V and L, the last */
  PetscBool remembers;        /* each place remembers what it senses; behind the bends */
  PetscBool at_tip;           /* the signal is the tip's: the last node's own, where others have the
                                 middle of the cell behind them */
  PetscReal *u, *u_t;         /* mechanics of nodes first - 1 .. end; node i at i - first + 1 */
  PetscReal *w, *w_t, *w_row; /* V and L of these, and the residuals of their equations */
  LearnedStretch *stretch;    /* of places, by these */
  PetscReal *k, *k_t;         /* states; places as of laws: 2 (i - first + 1) + half */
  PetscReal signal[TROPISM_BENDS], signal_t[TROPISM_BENDS];
  PetscReal nutation[TROPISM_BENDS]; /* at the time of the state */
  PetscBool born; /* node 0 is here, and material comes in there: it has learned nothing */
  PetscReal drive[MIRRORS]; /* how much it bends a straight rod towards x2, x3 */
  PetscReal *given, *clock; /* of places: natural bends that are given, a */
  PetscReal *drives;        /* Dk/Dt/a */
  PetscReal *row;           /* residual of owned nodes: mechanics; behind it those of states */
  PetscReal *rows;
  LearnedRow *node;
  LearnedFactor *cell;
  PetscReal tip[TROPISM_BENDS][LEARNED_MOST], tip_own[TROPISM_BENDS]; /* of the signal */
  Elimination elimination; /* borrowed; what was condensed last */
  PetscBool bordered;      /* border and inverse are of it */
  PetscReal *border[TROPISM_BENDS], inverse[TROPISM_BENDS][TROPISM_BENDS]; /* J^-1 w */
  PetscReal *b, *x, *free; /* room: of owned nodes; free parts of the states of places */
  PetscReal *label, (*over)[LEARNED_STENCIL]; /* of all places: see LearnedCarry(); NULL: not yet */
  PetscReal *turned;    /* of owned nodes, right-hand side and unknowns as they are eliminated */
  LearnedCorner corner; /* in the state taken apart last */
  /* The corner is small, and goes with states near and far: derivatives leave out what it does.
     They are those of equations that have none, by which they are tested. */
  PetscBool smooth;
  PetscReal *rhs, *beside; /* a right-hand side taken apart: its states, and mechanics */
} * Learned;

PetscErrorCode LearnedCreate(Rod rod, PetscInt lead, PetscInt extra, PetscInt bends,
                             LearnedSees sees);
PetscErrorCode LearnedDestroy(Rod rod);
PetscErrorCode LearnedBegin(Rod rod, Vec U);
void LearnedScale(Rod rod, PetscReal scale[]);
PetscErrorCode LearnedOpen(Rod rod, const RodState *at);
PetscErrorCode LearnedFill(Rod rod, void *array);
PetscErrorCode LearnedFilled(Rod rod, Vec F);
void LearnedResidual(Rod rod, PetscInt place, const LearnedPoint *point);
void LearnedSignalResidual(Rod rod, const PetscReal sensed[]);
void LearnedNodeSlope(Rod rod, PetscInt i, const LearnedSlope *slope, const PetscReal *clock,
                      const PetscReal shift[]);
void LearnedCondense(Rod rod, PetscInt i, const LearnedCell *cell, const PetscReal shift[],
                     PetscReal *left, PetscReal *right);
void LearnedSignalSlope(Rod rod, const LearnedSlope *slope, const PetscReal shift[]);
void LearnedCondensed(Rod rod, Elimination elimination);
PetscErrorCode LearnedSolve(Rod rod, Vec b, Vec x);
PetscErrorCode LearnedSetType(PC pc, Rod rod, Elimination elimination);
PetscErrorCode LearnedGet(Rod rod, Vec U, Node *nodes);
PetscErrorCode LearnedSet(Rod rod, const Node *nodes, Vec U);
PetscErrorCode LearnedMatrix(Rod rod, PetscInt i, const PetscReal *begin, const LearnedCell *cell,
                             const PetscReal *left, const PetscReal *right,
                             const LearnedSlope *slope, const PetscReal *clock,
                             const PetscReal *own, PetscReal *room, Mat J);
void LearnedTurned(const Rod rod, PetscInt rows, const PetscReal *from, PetscReal *to);
void LearnedRows(Rod rod, PetscInt i, const LearnedCell *cell, const PetscReal shift[]);
void LearnedByElastic(const Rod rod, PetscReal clock, const LearnedSlope *slope, PetscInt bend,
                      PetscReal by[]);
PetscBool LearnedFront(const Rod rod);
PetscErrorCode LearnedFindCorner(Rod rod, PetscReal t, Vec U);
PetscBool LearnedCarries(const Rod rod);
PetscErrorCode LearnedGather(Rod rod, PetscInt width, PetscReal *all);
PetscErrorCode LearnedKeepWay(Rod rod, PetscInt m, const PetscReal times[], const Vec points[]);
PetscErrorCode LearnedTimesRate(Rod rod, Vec V);
PetscErrorCode LearnedCarry(Rod rod, PetscReal t, PetscInt m, const PetscReal times[],
                            const Vec points[], PetscReal weight[][MAX_FIELDS], PetscBool states,
                            Vec sum);

/* Has the rod unknowns of growth that feels force? */
static inline PetscBool LearnedExtra(const Rod rod) {
  return (PetscBool)(rod->learned && rod->learned->extra);
}

/* Is the corner at a front followed? */
static inline PetscBool LearnedHasCorner(const Rod rod) {
  return (PetscBool)(rod->order == 4 && LearnedCarries(rod) && rod->scene->growth->front);
}

/* The corner in what the cell behind node i has learned, or NULL. */
static inline const LearnedCorner *LearnedCornerOf(const Rod rod, PetscInt i) {
  return rod->learned && rod->learned->corner.cell == i ? &rod->learned->corner : NULL;
}

/* The halves of the equations that an elimination solves: V's is one of the cell before a node, L's
   of the one behind it. */
static inline void LearnedHalves(const Rod rod, PetscInt halves[2]) {
  for (int k = 0; k < 2; k++) halves[k] = rod->model->halves[k] + (LearnedExtra(rod) ? 1 : 0);
}

/* Which unknown of a node, or equation of a cell, comes where they are eliminated: those of the
   cell before the node, V, the others, L. */
static inline PetscInt LearnedOrder(const Rod rod, PetscInt f) {
  const PetscInt before = rod->model->halves[0];

  if (f < before) return f;
  if (f == before) return rod->learned->lead;
  return f + 1 < rod->learned->mech ? f - 1 : f;
}

/* The states of a place, and their rates. */
static inline PetscReal *LearnedAt(const struct Learned_ *self, PetscInt place) {
  return self->k + place * self->per;
}

/* Is anything sensed at a place? Where the tip does it for all of the rod, at the last node alone.
 */
static inline PetscBool LearnedSenses(const Rod rod, PetscInt place) {
  const Tropism *law = &rod->scene->tropism;

  return (PetscBool)(law->senses && (!law->at_tip || place == 2 * (rod->last - rod->first + 1)));
}

#endif
