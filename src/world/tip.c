#include "world/tip.h"
#include "base/extremes.h"
#include "base/quaternion.h"
#include "base/vectors.h"

static const OptionRow rows[] = {
    ROW_REAL("-tip_force", "0", -1e9, 1e9, UNIT_FORCE, 0, "P, the force on the tip"),
    ROW_WORD(
        "-tip_law", "dead", "dead,follower,resistance", 0,
        "its direction: against the clamp's; against the tip's own; against the tip's velocity, "
        "as soil does"),
    ROW_TEXT("-tip_field", INPUT_FILE,
             "HDF5 file as for -friction_field: what a resistance is multiplied by"),
    ROW_WORD("-tip_type", "free", "free,pinned,clamped,slides", 0,
             "what holds the tip where it is at the start: nothing; its place; its place and its "
             "direction; the same, but free to slide along the clamp's axis"),
    ROW_TEXT("-tip_path", INPUT_FILE,
             "CSV or HDF5 file with t and some of x1, x2, x3, angle (or q0, q1, q2, q3), turn: "
             "where a tip that -tip_type holds is led over time")};
const OptionGroup tip_options = OPTION_GROUP_OF_ROD("Tip", rows);

/* Reads the path of a tip that is held. */
static PetscErrorCode ReadPath(Tip *tip) {
  const char *option = "-tip_path";
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(OptionText(option, file, &given));
  if (!given) PetscFunctionReturn(0);
  UserCheck(tip->type != TIP_FREE, OptionsComm(),
            "%s: leads a tip that is held; give -tip_type pinned, clamped or slides", option);
  PetscCall(PathRead(option, file, &tip->path));
  UserCheck(tip->type != TIP_PINNED ||
                !(PathSays(tip->path, PATH_ANGLE) || PathSays(tip->path, PATH_FRAME) ||
                  PathSays(tip->path, PATH_TURN)),
            OptionsComm(),
            "%s %s: a pinned tip is free to turn; take angle, q0 to q3 and turn out, or -tip_type "
            "clamped",
            option, file);
  PetscFunctionReturn(0);
}

/*
  TipSetFromOptions - reads and checks the options of the tip. Collective; the caller ends it with
  TipDestroy(), also after an error.

  load  along the rod: a resistance is regularised as dry friction is there
*/
PetscErrorCode TipSetFromOptions(Tip *tip, const Load *load) {
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool force, law, field;
  PetscInt choice;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(tip, sizeof(*tip)));
  PetscCall(OptionWord("-tip_type", &choice, NULL));
  tip->type = (TipType)choice;
  PetscCall(OptionReal("-tip_force", &tip->force, &force));
  PetscCall(OptionWord("-tip_law", &choice, &law));
  tip->law = (TipLaw)choice;
  PetscCall(OptionText("-tip_field", file, &field));
  UserCheck(!law || force, OptionsComm(), "-tip_law: needs -tip_force, the force on the tip");
  UserCheck(!field || tip->law == TIP_RESISTANCE, OptionsComm(),
            "-tip_field: is for -tip_law resistance; take it out, or give that law");
  UserCheck(tip->law != TIP_RESISTANCE || tip->force >= 0, OptionsComm(),
            "-tip_force: a resistance is not negative");
  tip->per_turn = tip->per_place = 1;
  tip->resistance = *load;
  tip->resistance.friction = FrictionDry(load->friction);
  tip->resistance.across = 1;
  tip->resistance.turns = PETSC_FALSE;
  tip->resistance.field = NULL;
  tip->resistance.factor = 1;
  tip->resistance.weighs = PETSC_FALSE;
  if (field) PetscCall(FieldFromFile("-tip_field", file, &tip->resistance.field));
  tip->resistance.moves = field;
  tip->resistance.plain = (PetscBool)!field;
  tip->resistance.varied = field;
  PetscCall(ReadPath(tip));
  PetscFunctionReturn(0);
}

PetscErrorCode TipDestroy(Tip *tip) {
  PetscFunctionBegin;
  PetscCall(FieldDestroy(&tip->resistance.field));
  PetscCall(PathDestroy(&tip->path));
  PetscFunctionReturn(0);
}

static Rubbed RubbedOf(const TipState *at) {
  return (Rubbed){at->at.x, at->at.axes[0], at->at.v, at->spin};
}

/* TipWalls - adds to f what walls push a free tip with, and the couple about its tangent: that of a
   piece l of rod. Returns the power of those that move. */
PetscReal TipWalls(int dims, const Tip *tip, const TipState *at, const FrictionDual *dual,
                   PetscReal f[RUBS]) {
  const Rubbed rubbed = RubbedOf(at);

  if (!tip->walls || tip->type != TIP_FREE) return 0;
  return ContactPushAll(dims, tip->walls, &rubbed, dual, tip->walls->tip, f);
}

/* Takes its derivatives off J in the plane, the condition being n - f = 0. */
static void PushWallsSlope(const Tip *tip, const TipState *at, const PetscReal shift[],
                           PetscBool fresh, FrictionDual *dual, PetscReal J[TIP_ROWS][TIP_FIELDS]) {
  enum { DIMS = 2 };
  const Rubbed rubbed = RubbedOf(at);
  const PetscReal l = tip->walls->tip;
  FrictionDual *duals = ContactDuals(DIMS, tip->walls, dual);
  Touch touch[MOST_TOUCHES];
  PetscInt n = ContactTouches(DIMS, tip->walls, at->at.x, touch);
  Push push;

  for (PetscInt k = 0; k < n; k++) {
    ContactPushSlope(DIMS, tip->walls, &touch[k], &rubbed, fresh,
                     ContactDual(DIMS, &touch[k], duals), &push);
    for (int d = 0; d < DIMS; d++)
      for (int c = 0; c < DIMS; c++) J[1 + d][c] -= l * (push.x[d][c] + shift[c] * push.W[d][c]);
  }
}

/* What is on a free tip, but for a resistance and walls: -P along the clamp, or -P q; and what
   pushes beside. */
static void OwnForce(const Tip *tip, const TipState *at, PetscReal f[3]) {
  const PetscReal P = tip->force;

  for (int d = 0; d < 3; d++)
    f[d] = tip->push[d] - (tip->law == TIP_FOLLOWER ? P * at->at.axes[0][d] : 0);
  if (tip->law == TIP_DEAD) f[0] -= P;
}

/* The place of the tip as a resistance sees it, which feels it move, but not spin. */
static Place Unspun(const TipState *at) {
  Place place = at->at;

  place.v[SPIN] = 0;
  return place;
}

/* TipForce - the force on a tip that is free and, in space, the couple about its tangent. */
void TipForce(int dims, const Tip *tip, const TipState *at, const FrictionDual *dual,
              PetscReal f[RUBS]) {
  PetscReal drag[RUBS];

  OwnForce(tip, at, f);
  f[SPIN] = tip->torque;
  if (tip->force != 0 && tip->law == TIP_RESISTANCE) {
    const Place unspun = Unspun(at);
    LoadForce(dims, &tip->resistance, &unspun, dual, drag);
    for (int d = 0; d < dims; d++) f[d] -= tip->force * drag[d];
  }
  (void)TipWalls(dims, tip, at, dual, f);
}

/* Where it was at the start. */
static void AtStart(const Tip *tip, PathPlace *start) {
  start->angle = tip->theta;
  memcpy(start->x, tip->x, sizeof(start->x));
  memcpy(start->p, tip->p, sizeof(start->p));
}

/* Where it is held at a time. */
static void Held(const Tip *tip, PetscReal t, PathPlace *held) {
  AtStart(tip, held);
  if (tip->path) PathAt(tip->path, t, held);
  for (int d = 0; d < 3; d++)
    if (tip->lead[d].on) held->x[d] = LeadValue(&tip->lead[d], t);
  if (!tip->turned.on) return;
  held->angle = LeadValue(&tip->turned, t);
  held->p[0] = PetscCosReal(held->angle / 2);
  held->p[3] = PetscSinReal(held->angle / 2);
}

/* TipLeadTo - a tip that is held is led on, from where it is at t and as fast as it moves, to a
   place in the clamp's frame, where it comes to rest at the time `by`. */
void TipLeadTo(Tip *tip, PetscReal t, PetscReal by, const PetscReal x[3]) {
  PathPlace held;

  Held(tip, t, &held);
  for (int d = 0; d < 3; d++)
    LeadTo(&tip->lead[d], t, held.x[d], LeadRate(&tip->lead[d], t), by, x[d]);
}

/* TipTurnTo - ... in the plane, to a direction against the clamp's. */
void TipTurnTo(Tip *tip, PetscReal t, PetscReal by, PetscReal angle) {
  PathPlace held;

  Held(tip, t, &held);
  LeadTo(&tip->turned, t, held.angle, LeadRate(&tip->turned, t), by, angle);
}

/* TipNextTurn - the first time behind t at which a tip that is led sets out, stops or turns back;
   PETSC_MAX_REAL if it does not. */
PetscReal TipNextTurn(const Tip *tip, PetscReal t) {
  PetscReal next = LeadNextTurn(&tip->turned, t);

  for (int d = 0; d < 3; d++) next = SmallerOf(next, LeadNextTurn(&tip->lead[d], t));
  return tip->path ? SmallerOf(next, PathNextTurn(tip->path, t)) : next;
}

/* Does a path lead it along an axis at a time? */
static PetscBool Led(const Tip *tip, PetscReal t, int axis) {
  if (tip->lead[axis].on) return LeadMoves(&tip->lead[axis], t);
  return (PetscBool)(tip->path && PathLeads(tip->path, t, axis));
}

/*
  TipStill - the rates of the unknowns at the tip, or their shifts, without those of a place that is
  held at rest, which are kept in still: its velocity is 0, and not what round-off makes of it in a
  step that is short. Where dry friction is next to exact that would be a direction, in which the
  tip is pushed with all that friction can, another one in each step.

  axes, fields  of its place, the first of the unknowns; of all
*/
const PetscReal *TipStill(const Tip *tip, PetscReal t, int axes, int fields,
                          const PetscReal rates[], PetscReal still[]) {
  memcpy(still, rates, (size_t)fields * sizeof(*still));
  for (int d = 0; d < axes; d++)
    if (TipHolds(tip, d) && !Led(tip, t, d)) still[d] = 0;
  return still;
}

/* TipHeldFrame - turns the quaternion of a tip in space to the frame in which it is held at a time,
   if it is. */
void TipHeldFrame(const Tip *tip, PetscReal t, PetscReal p[4]) {
  PathPlace held;
  PetscReal dot = 0;

  if (!TipPoints(tip)) return;
  Held(tip, t, &held);
  for (int k = 0; k < 4; k++) dot += held.p[k] * p[k];
  for (int k = 0; k < 4; k++) p[k] = dot < 0 ? -held.p[k] : held.p[k];
}

/* The conditions on force and place: n = f, or the place along axes along which it is held. */
static inline void Hold(int dims, const Tip *tip, const TipState *at, const PathPlace *held,
                        const PetscReal f[], PetscReal r[]) {
  for (int d = 0; d < dims; d++)
    r[d] = TipHolds(tip, d) ? tip->per_place * (at->at.x[d] - held->x[d]) : at->n[d] - f[d];
}

/* TipResidual - the three conditions at the tip, r = 0. */
void TipResidual(const Tip *tip, const TipState *at, const FrictionDual *dual,
                 PetscReal r[TIP_ROWS]) {
  PathPlace held = {.angle = 0};
  PetscReal f[RUBS];

  if (tip->type != TIP_FREE) Held(tip, at->at.t, &held);
  if (!TipHolds(tip, 0)) TipForce(2, tip, at, dual, f);
  r[0] = TipPoints(tip) ? tip->per_turn * (at->theta - held.angle) : at->m[2];
  Hold(2, tip, at, &held, f, r + 1);
}

/*
  TipJacobian - their derivatives by (x1, x2, theta, m, n1, n2), of which x_c has the rate
  shift[c] x_c + ...

  fresh, dual  as for LoadLinearise()
*/
void TipJacobian(const Tip *tip, const TipState *at, const PetscReal shift[], PetscBool fresh,
                 FrictionDual *dual, PetscReal J[TIP_ROWS][TIP_FIELDS]) {
  enum { X1, X2, TH, M, N1, N2, DIMS = 2 };
  const PetscReal P = tip->force, perp[] = {-at->at.axes[0][1], at->at.axes[0][0]};
  LoadSlope slope = {.W = {{0}}};

  for (int i = 0; i < TIP_ROWS; i++)
    for (int j = 0; j < TIP_FIELDS; j++) J[i][j] = 0;
  J[0][TipPoints(tip) ? TH : M] = TipPoints(tip) ? tip->per_turn : 1;
  for (int d = 0; d < DIMS; d++)
    J[1 + d][TipHolds(tip, d) ? X1 + d : N1 + d] = TipHolds(tip, d) ? tip->per_place : 1;
  if (tip->type != TIP_FREE) return; /* (what presses on one that slides is dead) */
  if (tip->walls) PushWallsSlope(tip, at, shift, fresh, dual, J);
  if (P == 0) return;
  for (int d = 0; d < DIMS && tip->law == TIP_FOLLOWER; d++) J[1 + d][TH] = P * perp[d];
  if (tip->law != TIP_RESISTANCE) return;
  LoadLinearise(DIMS, &tip->resistance, &at->at, fresh, dual, &slope);
  for (int d = 0; d < DIMS; d++)
    for (int c = 0; c < DIMS; c++)
      J[1 + d][X1 + c] += P * (shift[c] * slope.W[d][c] + slope.x[d][c]);
}

/* The vector part of p_held* p, which says by how much a tip has turned from where it is held. */
static void TurnFrom(const PetscReal held[4], const PetscReal p[4], PetscReal v[3]) {
  PetscReal turn[4];

  QuaternionFrom(held, p, turn);
  for (int d = 0; d < 3; d++) v[d] = turn[1 + d];
}

/* TipResidual3 - the six conditions at the tip in space, r = 0: m = torque d1, or the frame it is
   held at; n = f, or the place. Of one that another rod holds they are not known here: 0. */
void TipResidual3(const Tip *tip, const TipState *at, const FrictionDual *dual,
                  PetscReal r[TIP_ROWS3]) {
  PetscReal f[RUBS] = {0, 0, 0, tip->torque};
  PathPlace held = {.angle = 0};

  if (tip->type == TIP_CARRIED) {
    memset(r, 0, TIP_ROWS3 * sizeof(*r));
    return;
  }
  if (tip->type != TIP_FREE) Held(tip, at->at.t, &held);
  if (!TipHolds(tip, 0)) TipForce(3, tip, at, dual, f);
  if (TipPoints(tip)) TurnFrom(held.p, at->p, r);
  for (int d = 0; d < 3; d++)
    r[d] = TipPoints(tip) ? tip->per_turn * r[d] : at->m[d] - f[SPIN] * at->at.axes[0][d];
  Hold(3, tip, at, &held, f, r + 3);
}

/* Takes the derivatives of what walls push with off J, the conditions being m - couple q = 0 and
   n - f = 0. */
static void PushWallsSlope3(const Tip *tip, const TipState *at,
                            const PetscReal dW[RUBS][TIP_FIELDS3], PetscBool fresh,
                            FrictionDual *dual, PetscReal J[TIP_ROWS3][TIP_FIELDS3]) {
  enum { P = 3 };
  const Rubbed rubbed = RubbedOf(at);
  FrictionDual *slots = ContactDuals(3, tip->walls, dual);
  Touch touch[MOST_TOUCHES];
  PetscInt n = ContactTouches(3, tip->walls, at->at.x, touch);
  PetscReal by[RUBS][TIP_FIELDS3], l = tip->walls->tip;
  Push push;

  if (slots) ContactSlots(3, n, touch, slots);
  for (PetscInt k = 0; k < n; k++) {
    FrictionDual *kept = ContactDual(3, &touch[k], slots);
    ContactPush(3, tip->walls, &touch[k], &rubbed, kept, &push);
    const PetscReal couple = push.couple;
    ContactPushSlope(3, tip->walls, &touch[k], &rubbed, fresh, kept, &push);
    for (int d = 0; d < RUBS; d++) {
      push.W[d][SPIN] *= at->per_W;
      for (int j = 0; j < TIP_FIELDS3; j++) {
        by[d][j] = j < 3 ? push.x[d][j] : 0;
        for (int c = 0; c < RUBS; c++) by[d][j] += push.W[d][c] * dW[c][j];
        for (int c = 0; c < 3 && j >= P && j < P + 4; c++)
          by[d][j] += push.q[d][c] * at->q_p[c][j - P];
      }
    }
    for (int d = 0; d < 3; d++)
      for (int j = 0; j < TIP_FIELDS3; j++) {
        J[d][j] -= l * at->at.axes[0][d] * by[SPIN][j];
        if (j >= P && j < P + 4) J[d][j] -= l * couple * at->q_p[d][j - P];
        J[3 + d][j] -= l * by[d][j];
      }
  }
}

/* TipJacobian3 - their derivatives by (x, p, m, n), of which W has the derivatives dW; fresh, dual
   as for LoadLinearise(). */
void TipJacobian3(const Tip *tip, const TipState *at, const PetscReal dW[RUBS][TIP_FIELDS3],
                  PetscBool fresh, FrictionDual *dual, PetscReal J[TIP_ROWS3][TIP_FIELDS3]) {
  enum { X, P = 3, M = 7, N = 10 };
  const PetscReal force = tip->force;
  const Place unspun = Unspun(at);
  LoadSlope slope = {.q = {{0}}};
  PathPlace held;

  for (int i = 0; i < TIP_ROWS3; i++)
    for (int j = 0; j < TIP_FIELDS3; j++) J[i][j] = 0;
  if (tip->type == TIP_CARRIED) return;
  if (TipPoints(tip)) {
    Held(tip, at->at.t, &held);
    for (int k = 0; k < 4; k++) {
      PetscReal unit[4] = {k == 0, k == 1, k == 2, k == 3}, v[3];
      TurnFrom(held.p, unit, v);
      for (int d = 0; d < 3; d++) J[d][P + k] = tip->per_turn * v[d];
    }
  } else
    for (int d = 0; d < 3; d++) {
      J[d][M + d] = 1;
      for (int k = 0; k < 4; k++) J[d][P + k] = -tip->torque * at->q_p[d][k];
    }
  for (int d = 0; d < 3; d++)
    J[3 + d][(TipHolds(tip, d) ? X : N) + d] = TipHolds(tip, d) ? tip->per_place : 1;
  if (tip->type != TIP_FREE) return;
  if (tip->walls) PushWallsSlope3(tip, at, dW, fresh, dual, J);
  if (force == 0) return;
  for (int d = 0; d < 3 && tip->law == TIP_FOLLOWER; d++)
    for (int k = 0; k < 4; k++) J[3 + d][P + k] += force * at->q_p[d][k];
  if (tip->law != TIP_RESISTANCE) return;
  LoadLinearise(3, &tip->resistance, &unspun, fresh, dual, &slope);
  for (int d = 0; d < 3; d++)
    for (int c = 0; c < 3; c++)
      J[3 + d][X + c] += force * (dW[c][X + c] * slope.W[d][c] + slope.x[d][c]);
}

/* TipHold - moves what holds a tip that sticks, to what resists it or to walls; returns the speed
   at which it creeps. */
PetscReal TipHold(int dims, const Tip *tip, const TipState *at, PetscReal seen,
                  FrictionDual dual[]) {
  const Rubbed rubbed = RubbedOf(at);
  const Place unspun = Unspun(at);
  PetscReal creep = 0;

  if (tip->type != TIP_FREE) return 0;
  if (TipResists(tip)) creep = FrictionHold(LoadRubs(dims), unspun.v, seen, friction_hold, dual);
  if (tip->walls) creep = LargerOf(creep, ContactHold(dims, tip->walls, &rubbed, seen, dual));
  return creep;
}

/* TipCompression - how much the tip's force presses on a straight rod, which is at `at`. */
PetscReal TipCompression(const Tip *tip, const Place *at) {
  const FrictionDual none = {.v = {0}};
  TipState state = {.at = *at};
  PetscReal f[RUBS];

  TipForce(2, tip, &state, &none, f);
  return -f[0];
}

/* A tip that slides is free along the clamp's axis, so a place there would lead nothing. */
static PetscErrorCode CheckSliding(const Tip *tip, MPI_Comm comm, const PetscReal lab[3][3]) {
  const PetscReal oblique = 1e-12;

  PetscFunctionBegin;
  for (int d = 0; d < 3 && tip->type == TIP_SLIDES; d++)
    UserCheck(!PathSays(tip->path, PATH_X1 + d) || PetscAbsReal(lab[d][0]) < 1 - oblique, comm,
              "-tip_path: a tip that slides is free along x%d, the clamp's axis; take x%d out, or "
              "-tip_type clamped",
              d + 1, d + 1);
  PetscFunctionReturn(0);
}

/*
  TipSetPath - tells the path of a tip, if it has one, where clamp and tip are at the start; after
  x, theta and p are set.

  length  of the rod, against which its first row must be next to the tip
  lab     from the frame of the clamp to the laboratory
  space   is the rod in space? else its angle says more than its frame
*/
PetscErrorCode TipSetPath(Tip *tip, MPI_Comm comm, PetscReal length, const PetscReal lab[3][3],
                          PetscBool space) {
  const PetscReal near = 0.01, alike = 0.2;
  PetscReal apart[3];
  PathPlace start;

  PetscFunctionBegin;
  if (!tip->path) PetscFunctionReturn(0);
  PetscCall(CheckSliding(tip, comm, lab));
  AtStart(tip, &start);
  PathBegin(tip->path, lab, &start, apart);
  UserCheck(apart[0] <= near * length, comm,
            "-tip_path: begins %g away from the tip, which is at (%g, %g, %g) of the clamp's frame "
            "at the start; begin there, to a hundredth of the rod's length",
            (double)apart[0], (double)start.x[0], (double)start.x[1], (double)start.x[2]);
  UserCheck(apart[space ? 1 : 2] <= alike, comm,
            "-tip_path: begins turned by %g against the tip at the start; begin there, to %g "
            "radians",
            (double)apart[space ? 1 : 2], (double)alike);
  PetscFunctionReturn(0);
}
