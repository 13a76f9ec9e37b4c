/* What a model of the rod is: its unknowns, their equations F(t, U, U_t) = 0, and how to read from
   them what every model of a rod has (position, angle, moment, force, velocity). A model knows no
   time stepper. */
#ifndef TENDRIL_ROD_H
#define TENDRIL_ROD_H

#include "base/elimination.h"
#include "base/plane.h"
#include "scene/scene.h"
#include "straight/straight.h"
#include <petscdmda.h>
#include <stddef.h>

enum { MAX_FIELDS = 23 };

/* The mirrors of a rod that is nearly straight: x2 -> -x2 and, in space, x3 -> -x3. Fields fall
   into groups by the mirrors in which they change sign, as do their equations: on the straight rod
   groups do not see each other, and one may be 250 orders of magnitude smaller than another. */
enum {
  ALONG = 0,
  ACROSS_2 = 1,
  ACROSS_3 = 2,
  TWIST = ACROSS_2 | ACROSS_3,
  GROUPS = 4,
  MIRRORS = 2
};

/* Two fields that are one vector across the rod: (along, sign beside), of the groups ACROSS_2 and
   ACROSS_3. */
typedef struct {
  PetscInt along, beside;
  PetscReal sign;
} Pair;
enum { MOST_PAIRS = 8 };

/* What the material has learned at a place, about d3 and d2: bends, and the signal that it goes by
   where it remembers one, or the tip sends it. */
typedef struct {
  PetscReal bend[TROPISM_BENDS], signal[TROPISM_BENDS];
} NodeLearned;

/* What is known at a node, for any model; in the clamp's frame. */
typedef struct {
  /* position; quaternion of the directors, in space; tangent angle, m = curvature - k0, and n */
  PetscReal x[3], p[4], theta, moment, force[3];
  PetscReal x_t[3], p_t[4], theta_t; /* their rates at fixed s */
  PetscReal m3[3], m3_t[3]; /* all of the moment in space, whose size is m then, as theta is
                               the angle between d1 and the clamp's axis */
  NodeLearned learned[2];   /* at the node, and in the middle of the cell behind it */
  PetscReal growth[2];      /* V and the length of the rod, where its growth feels force */
} Node;
enum { NODE_VALUES = sizeof(Node) / sizeof(PetscReal) };

/* Its first part, which is all there is in the plane: the rest is then of no account. */
typedef struct {
  PetscReal x[3], p[4], theta, moment, force[3], x_t[3], p_t[4], theta_t;
} PlaneNode;
enum { PLANE_NODE_VALUES = sizeof(PlaneNode) / sizeof(PetscReal) };

/* What stands between a node's place in the plane and its angle: see StrandState. */
enum { NODE_BETWEEN = (int)(offsetof(Node, theta) / sizeof(PetscReal)) - 2 };

static inline void PlanePart(const Node *node, PlaneNode *plane) {
  for (int k = 0; k < PLANE_NODE_VALUES; k++)
    ((PetscReal *)plane)[k] = ((const PetscReal *)node)[k];
}

/* The larger of two sizes; one that is no number is infinite, and stays so. (Then the largest of
   many is the same in any order, and on all ranks, which else go different ways, and hang.) */
static inline PetscReal LargerSize(PetscReal most, PetscReal size) {
  return size <= most ? most : size <= PETSC_MAX_REAL ? size : INFINITY;
}

typedef struct _Rod *Rod;

/* A state in which the equations are asked for, and what for. Its vectors are borrowed. */
typedef struct {
  PetscReal t;
  Vec U, U_t;
  PetscReal shift[MAX_FIELDS]; /* of each field: derivatives are dF/dU + dF/dU_t diag(shift) */
  PetscBool fresh; /* a Newton solve begins here: what it remembers starts again, and pairs that may
                      touch are looked for */
  PetscBool iterates; /* it goes on in one: else what kinds of cells there are stays as it is */
  PetscBool counts;   /* modes are to be counted in it: symmetric if it can */
} RodState;

/* Tells one state of the unknowns and their rates from another. */
typedef struct {
  PetscReal t;
  PetscObjectId id[2];
  PetscObjectState state[2];
} RodSeen;

/* What the world does to a rod, in the clamp's frame. */
typedef struct {
  PetscReal friction[3], walls[3]; /* forces of the friction along it, and of walls, tip included */
  PetscReal moved;                 /* power of walls that move */
  PetscReal
      tip[4]; /* what contact does to the tip: force and, in space, couple about the tangent */
  PetscReal left[3]; /* what is left of the balance */
} RodForces;
enum { ROD_FORCES = sizeof(RodForces) / sizeof(PetscReal) };

typedef struct {
  const char *name;
  PetscInt fields;  /* unknowns per node */
  PetscInt stencil; /* neighbours on each side */
  const char *field[MAX_FIELDS];
  PetscBool followed[MAX_FIELDS]; /* under error control and in Newton's test: x, theta */
  int group[MAX_FIELDS];          /* ALONG, or the mirrors in which it changes sign */
  PetscInt pairs;                 /* of fields across; 0 in the plane */
  Pair pair[MOST_PAIRS];          /* the place first */
  PetscInt halves[2]; /* of a node's equations: rows of the cell before it, of the one behind it */
  PetscBool linear;   /* one Newton step solves it */
  PetscBool space;    /* the rod is in space; else in a plane */
  PetscErrorCode (*initial)(Rod, PetscReal t,
                            Node *nodes); /* RodInitialNodes(); NULL: the plane's */
  const char *(*refuses)(Scene); /* why it cannot be of this scene; NULL: it can, as can a model
                                    without this function */
  PetscErrorCode (*create)(Rod);
  PetscErrorCode (*destroy)(Rod);
  /* U from nodes (local, owned), and nodes from U; U_t may be NULL (rates are then 0) */
  PetscErrorCode (*set)(Rod, PetscReal t, const Node *nodes, Vec U);
  PetscErrorCode (*get)(Rod, PetscReal t, Vec U, Vec U_t, Node *nodes);
  PetscErrorCode (*residual)(Rod, const RodState *, Vec F);
  PetscErrorCode (*jacobian)(Rod, const RodState *, Mat J);
  /* the same, eliminated at once, but for what far parts of a coupled rod do to each other; NULL:
     it cannot */
  PetscErrorCode (*eliminate)(Rod, const RodState *, Elimination);
  /* by how much the state of the latest residual fails the equations between the collocation
     points, per owned node: of what is left of it; NULL: not known */
  PetscErrorCode (*defect)(Rod, const RodState *, PetscReal (*defect)[MAX_FIELDS]);
  /* the moments about the directors (in the plane, the first) at a node u, and by how much a small
     change of u changes them */
  void (*moments)(const PetscReal u[], const PetscReal change[], PetscReal m[3], PetscReal dm[3]);
  /* by more than half a turn: has a cross-section turned as far from one state to another, so that
     which way round is not known? NULL: it cannot */
  PetscErrorCode (*turned)(Rod, Vec U0, Vec U1, PetscBool *turned);
  /* what Newton's method remembers from step to step: value k, of as many as the rod's memory says,
     at an owned node i or one beside these; NULL: nothing there. And all of it has been taken back:
     what depends on it is looked at again; NULL: nothing does */
  PetscReal *(*remembered)(Rod, PetscInt i, PetscInt k);
  PetscErrorCode (*recalled)(Rod);
  /* what changes of the fields are measured against, from their sizes; NULL: these */
  void (*scale)(PetscReal size[]);
  /* exact Coulomb friction: see LoadHold(); NULL: regularised friction only */
  PetscErrorCode (*hold)(Rod, const RodState *, PetscReal seen, PetscReal *creep);
  /* what the world does to the owned cells in the state of the latest residual, as the equations
     have it; NULL: an observer knows */
  PetscErrorCode (*bears)(Rod, const RodState *, RodForces *);
  /* several other rods that go together as these do; they are theirs from then on; NULL: of one */
  PetscErrorCode (*again)(Rod, Rod each[], Rod *other);
} RodModel;

/* What strands do to one of several rods, at its points (rod/strands.h), and room for what its
   cells have to say of that (rod/strand_rows.h); NULL: nothing. Borrowed. */
typedef struct {
  const PetscReal (*force)[3], (*couple)[3];
  struct StrandCell_ *cells;
} RodPushed;

struct _Rod {
  const RodModel *model;
  Scene scene;
  MPI_Comm comm;      /* the ranks that share it */
  const PetscReal *s; /* labels of its nodes, all of them */
  PetscInt rods;      /* of several that go together, how many, */
  Rod *each;          /* ... and these; of one, itself: see rod/ask.h */
  const PetscInt
      *at; /* where the nodes of each begin among all, and where they end; NULL: of one */
  Rod itself;
  DM da;               /* the unknowns: 1D DMDA over the nodes */
  DM nodes;            /* Node at each node, stencil 1 */
  PetscInt first, end; /* owned nodes: first .. end - 1 */
  PetscInt last;       /* the tip, N */
  PetscInt order;      /* of the error in space */
  PetscBool alone;     /* on one rank */
  PetscBool coupled;   /* nodes far from each other along the rod see each other */
  RodPushed pushed;    /* by strands that are looked for among several rods */
  PetscInt memory;     /* reals a node that its Newton's method remembers; 0: none */
  Vector2 oblique;     /* how much so walls are that press: RodFeelWalls() */
  struct {
    PetscReal t;
    PetscBool whole; /* all of the sum, and not only what is left, */
    RodForces sum;   /* of this rank's part */
  } kept[2];         /* of the latest two states, the latest first: see RodKeepLeft() */
  PetscReal finest;  /* what is told apart of a vector across that walls have part in, for
                        RodFieldScales(): of the order of round-off over a step's tolerance */
  PetscReal least;   /* of several that hold each other: changes of places are measured against so
                        much at least, the same part of a turn; 0: of one that feels none */
  struct Learned_ *learned; /* natural curvature of its own (rod/learned.h); NULL: none */
  void *data;
};

/* How many components a place has. */
static inline int RodDims(const RodModel *model) {
  return model->space ? 3 : 2;
}

extern const RodModel rod_frame, rod_mixed, rod_linear, rod_linear_space, rod_space;
/* the same, whose material learns its natural curvature; that also remembers what it senses */
extern const RodModel rod_frame_learns, rod_frame_remembers, rod_space_learns, rod_space_remembers;
/* ... and whose growth feels the force along it */
extern const RodModel rod_frame_yields, rod_frame_yields_remembers, rod_space_yields,
    rod_space_yields_remembers;
extern const OptionGroup frame_options;

PetscErrorCode RodCreate(Scene scene, const RodModel *model, Rod *rod);
PetscErrorCode RodDestroy(Rod *rod);
PetscErrorCode RodCreateMatrix(Rod rod, Mat *J);
PetscErrorCode RodCreateMemory(Rod rod, DM *da, Vec *memory);
PetscErrorCode RodRemember(Rod rod, Vec memory);
PetscErrorCode RodRecall(Rod rod, Vec memory);
PetscErrorCode RodGetLocalNodes(Rod rod, PetscReal t, Vec U, Vec *local, const Node **with);
PetscErrorCode RodRestoreLocalNodes(Rod rod, Vec *local, const Node **with);
PetscErrorCode RodInitialNodes(Rod rod, PetscReal t, Node *nodes);
PetscErrorCode RodFindUnits(Rod rod);
PetscReal RodFieldUnit(const Rod rod, PetscInt field);
PetscBool RodIsPlace(const RodModel *model, PetscInt field);
PetscReal RodReach(const RodModel *model, const PetscReal size[]);
PetscErrorCode RodBegin(Rod rod, Vec U);
PetscErrorCode RodGrowNodes(Rod rod, PetscReal t0, PetscReal t1, Node *nodes);
void RodPlanePart(Node *node);
PetscErrorCode RodHoldTip(Rod rod);
const char *RodRefusesSpace(Scene scene);
PetscErrorCode RodOpen(Rod rod, Vec v, Vec *local, void *array);
PetscErrorCode RodClose(Rod rod, Vec *local, void *array);
/* No state is the one that was seen last: it is looked at again. */
static inline void RodForget(RodSeen *seen) {
  seen->t = PETSC_MIN_REAL;
}

PetscErrorCode RodRecognise(const RodState *at, RodSeen *seen, PetscBool *known);
PetscErrorCode RodSumAlong(Rod rod, PetscInt n, PetscReal value[]);
PetscErrorCode RodFieldSizes(Rod rod, Vec U, PetscReal size[MAX_FIELDS]);
PetscErrorCode RodAxes(Rod rod, Vec U, const PetscReal size[MAX_FIELDS], Vector2 *axis);
PetscErrorCode RodTurn(Rod rod, Vector2 axis, Vec V);
PetscErrorCode RodSizesAlong(Rod rod, Vec U, Vector2 axis, PetscReal size[MAX_FIELDS]);
PetscErrorCode RodBlurred(Rod rod, Vec U, PetscReal place[MIRRORS]);
PetscErrorCode RodFeelWalls(Rod rod, PetscReal t, Vec U);
PetscErrorCode RodKeepLeft(Rod rod, PetscReal t, Vec F);
void RodKeepBorne(Rod rod, const RodForces *sum);
PetscBool RodForcesAt(Rod rod, PetscReal t, RodForces *sum);
PetscErrorCode RodFieldScales(Rod rod, Vec U, Vector2 *axis, PetscReal scale[MAX_FIELDS]);

#endif
