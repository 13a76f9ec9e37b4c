/* What the files of strands share: the nodes in a state, and pairs of what is near. Of several rods
   nodes are counted through, rod behind rod: cell i is behind node i, and behind a rod's last node
   there is none. */
#ifndef TENDRIL_STRAND_PAIRS_H
#define TENDRIL_STRAND_PAIRS_H

#include "curve/cell.h"
#include "curve/spread.h"
#include "rod/strands.h"

/* A node in the state that is looked at: place, direction and their rates, how they change with
   what turns it; in space its quaternion, and the spin of the material about d1. */
typedef struct {
  PetscReal x[3], x_t[3], q[3], q_t[3];
  CurveEnd by;
  const PetscReal *p;
  PetscReal size, spin, spin_by[4];
} Joint;

/* A rod among them. */
typedef struct {
  Scene scene;
  const Contact *contact;
  PetscInt first, cells; /* its first node, and cell; how many cells */
  PetscInt sample, each; /* its first sample; how many a cell has */
  PetscReal apart;       /* what is nearer along it is the same strand */
  PetscReal axis[3];     /* the direction of its clamp */
  StrandSum sum;
} Strand;

/* How two rods touch that have come near each other. */
typedef struct {
  PetscInt rod[2], next; /* the next one of the first rod; -1: none */
  StrandMeeting how;
  Contact law;
} Meeting;

/* Two places at which rods are joined: nodes. */
typedef struct {
  PetscInt node[2];
} StrandJoint;

/* A place on the curve of a rod. */
typedef struct {
  PetscInt cell;
  CurvePlace on;
} Spot;

/* How a strand in space turns where it is touched: its tangent, the lever a by which its surface
   moves with its spin, and that spin and its derivative by z. */
typedef struct {
  PetscReal t[3], a[3], spin, spin_z;
} Turning;

/* A sample and what it is near to. */
typedef struct {
  PetscInt sample, next;
  const Contact *contact; /* the law by which they touch */
  int side;               /* of a sample in the plane: 0 left, 1 right; else 0 */
  PetscBool ends;         /* the foot is an end of the rod */
  PetscBool apart;        /* they are not the same strand */
  PetscBool active;       /* they press */
  Spot at, foot;
  PetscReal n[3], distance, gap;
  PetscReal p, p_gap;       /* pressure and its derivative */
  PetscReal w[3], rubs;     /* friction over mu p, and its power */
  PetscReal slip, w_slip;   /* in the plane: speed along the surface, and how |w| changes with it */
  PetscReal V[4], by[4][4]; /* in space: slip of the surfaces, and how w changes with it */
  Turning turning[2];       /* ... of the sample, of the foot; where there is friction */
  FrictionDual dual;        /* ... and what Newton's method remembers */
} Pair;

struct _Strands {
  PetscInt rods;
  Strand *rod;
  StrandsMeet meet; /* of several rods, which are brought into one frame; NULL: of one */
  void *ctx;
  PetscInt joints;
  StrandJoint *joint_at;
  PetscInt meetings, *met; /* of each rod the first one with a later rod */
  Meeting **meeting;
  PetscInt *of;       /* of each node, its rod, */
  PetscInt *span_end; /* ... its last node, */
  PetscInt *span; /* ... and the first node of its span: where another rod is joined to it a node is
                     there twice (material/mesh.h), and forces are handed to points on one side */
  int dims;       /* 2 in the plane, 3 in space */
  PetscInt nodes; /* of all; node i is point 2 i, the middle behind it 2 i + 1 */
  PetscInt samples; /* of all; that of the tip is a rod's last */
  PetscBool rubs;   /* any two can */
  PetscReal time;   /* of what follows: laws at the points */
  PetscReal *s, *g, *g_t, *c, *strain, *arc, *weight;
  PetscInt n, room;
  Pair *pair;
  PetscInt *first;        /* of a sample, of each side that it has: its first pair, -1 none */
  PetscInt sides;         /* 2 in the plane, 1 in space */
  Joint *joint;           /* of each node */
  Spot *spot;             /* where samples are in the state that is looked at, */
  PetscBool *placed;      /* ... if anyone has asked */
  PetscBool searched;     /* it has been searched for pairs just now */
  PetscReal *seen;        /* x at the nodes when pairs were looked for */
  PetscReal (*force)[3];  /* StrandsForces() */
  PetscReal (*couple)[3]; /* StrandsCouples(); NULL: there are none */
  FrictionDual *dual;     /* of a sample's side in the plane; NULL: no friction */
  StrandSlope *slopes;
  PetscInt slopes_room;
};

/* How the pair's foot, normal, distance and friction change; in space slip, tangents and levers. */
typedef struct {
  PetscReal z[STRAND_UNKNOWNS], gap[STRAND_UNKNOWNS];
  StrandBy n, w, slip, t[2], a[2];
} PairSlope;

/* How many unknowns a node has, of both nodes of a cell and of two of these: constants of a call,
   as the dimension is. */
static inline int NodeOf(int dims) {
  return dims + CurveTurns(dims);
}

/* The rod of a cell. */
static inline const Strand *StrandOf(const struct _Strands *self, PetscInt cell) {
  return &self->rod[self->of[cell]];
}

/* Is it a cell at all? Not between two rods, nor between the two nodes of a joint. */
static inline PetscBool IsCell(const struct _Strands *self, PetscInt cell) {
  return (PetscBool)(self->span[cell] == self->span[cell + 1]);
}

/* Where the force on its tip stands, behind its points. */
static inline PetscInt TipPoint(const Strand *rod) {
  return 2 * (rod->first + rod->cells) + 1;
}

/* Is a sample that of the tip? */
static inline PetscBool SampleIsTip(const struct _Strands *self, PetscInt sample) {
  return (PetscBool)(self->spot[sample].on.z == 1);
}

/* The curve of a cell, without its rates. */
static inline void StrandCell(const struct _Strands *self, PetscInt cell, CurveCell *of) {
  of->h = self->s[cell + 1] - self->s[cell];
  for (int e = 0; e < 2; e++) {
    const Joint *joint = &self->joint[cell + e];
    of->g[e] = self->g[2 * (cell + e)];
    for (int d = 0; d < 3; d++) {
      of->x[e][d] = joint->x[d];
      of->q[e][d] = joint->q[d];
    }
  }
}

/* ... and with them. */
static inline void StrandCellMoving(const struct _Strands *self, PetscInt cell, CurveCell *of) {
  StrandCell(self, cell, of);
  for (int e = 0; e < 2; e++) {
    const Joint *joint = &self->joint[cell + e];
    for (int d = 0; d < 3; d++) {
      of->x_t[e][d] = joint->x_t[d];
      of->slope_t[e][d] = self->g_t[2 * (cell + e)] * joint->q[d] + of->g[e] * joint->q_t[d];
    }
  }
  for (int k = 0; k < 3; k++) of->c[k] = self->c[2 * cell + k];
}

/* strand_friction.c */
void PairRub(const struct _Strands *self, Pair *pair);
PetscReal PairFootPower(const struct _Strands *self, const Pair *pair, const PetscReal f[3],
                        const PetscReal on_foot[3]);
void PairRubSlope(const struct _Strands *self, Pair *pair, PetscBool fresh, PairSlope *by);
void PairsForget(Strands self);

/* strand_laws.c */
PetscErrorCode StrandLawOf(Strands self, PetscInt a, PetscInt b, const Contact **law);
void StrandLawsNow(Strands self);
void StrandJointToLab(const struct _Strands *self, PetscInt node, Joint *joint);
void StrandsToOwn(const struct _Strands *self, PetscReal (*load)[3]);
void StrandSlopeToOwn(const struct _Strands *self, StrandSlope *slope);

/* strands.c */
void StrandJoints(Strands self, const StrandState *state, const PetscReal *shift);
void PairShares(const struct _Strands *self, const Pair *pair, PetscReal share[2]);
PetscBool PairOnClamp(const struct _Strands *self, const Pair *pair);
void PairForce(const struct _Strands *self, const Pair *pair, PetscReal f[3]);
int PairSpread(const struct _Strands *self, const Pair *pair, int of_foot, Spread *spread);

#endif
