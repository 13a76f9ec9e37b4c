#include "scene/tip.h"

static const OptionRow rows[] = {
    ROW_REAL("-tip_force", "0", -1e9, 1e9, UNIT_FORCE, 0, "P, the force on the tip"),
    ROW_WORD(
        "-tip_law", "dead", "dead,follower,resistance", 0,
        "its direction: against the clamp's; against the tip's own; against the tip's velocity, "
        "as soil does"),
    ROW_TEXT("-tip_field", INPUT_FILE,
             "HDF5 file as for -friction_field: what a resistance is multiplied by"),
    ROW_WORD("-tip_type", "free", "free,pinned,clamped", 0,
             "what holds the tip where it is at the start: nothing; its place; its place and its "
             "direction")};
const OptionGroup tip_options = OPTION_GROUP("Tip", rows);

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
  tip->resistance = *load;
  tip->resistance.friction.mu = 1;
  tip->resistance.across = 1;
  tip->resistance.turns = PETSC_FALSE;
  tip->resistance.field = NULL;
  if (field) PetscCall(FieldFromFile("-tip_field", file, &tip->resistance.field));
  tip->resistance.moves = field;
  tip->resistance.plain = (PetscBool)!field;
  tip->resistance.varied = field;
  PetscFunctionReturn(0);
}

PetscErrorCode TipDestroy(Tip *tip) {
  PetscFunctionBegin;
  PetscCall(FieldDestroy(&tip->resistance.field));
  PetscFunctionReturn(0);
}

/* TipInFastTime - the tip in the fast time of a snap at t: its resistance is that of dry friction.
   What fast holds is borrowed. */
PetscErrorCode TipInFastTime(const Tip *tip, PetscReal t, Tip *fast) {
  PetscBool dry;

  PetscFunctionBegin;
  *fast = *tip;
  PetscCall(LoadInFastTime(&tip->resistance, t, &fast->resistance, &dry));
  fast->resistance.friction.more = fast->resistance.friction.mu - 1; /* nothing viscous */
  PetscFunctionReturn(0);
}

/* The dual of the tip's friction with a wall. */
static LoadDual *WallDual(const Tip *tip, const LoadDual *dual, const Touch *touch) {
  return tip->walls->walls.rub ? (LoadDual *)dual + 1 + touch->wall : NULL;
}

/* Adds to f the push of walls. */
static void AddWalls(const Tip *tip, const TipState *at, const LoadDual *dual, PetscReal f[2]) {
  Touch touch[MOST_TOUCHES];
  PetscInt n = ContactTouches(tip->walls, at->at.x, touch);
  Push push;

  for (PetscInt k = 0; k < n; k++) {
    ContactPush(tip->walls, &touch[k], at->at.v, WallDual(tip, dual, &touch[k]), &push);
    for (int d = 0; d < 2; d++) f[d] += tip->walls->tip * push.force[d];
  }
}

/* Takes its derivatives off J, the condition being n - f = 0. */
static void AddWallsSlope(const Tip *tip, const TipState *at, const PetscReal shift[2],
                          PetscBool fresh, LoadDual *dual, PetscReal J[TIP_ROWS][TIP_FIELDS]) {
  const PetscReal l = tip->walls->tip;
  Touch touch[MOST_TOUCHES];
  PetscInt n = ContactTouches(tip->walls, at->at.x, touch);
  Push push;

  for (PetscInt k = 0; k < n; k++) {
    ContactPushSlope(tip->walls, &touch[k], at->at.v, fresh, WallDual(tip, dual, &touch[k]), &push);
    for (int d = 0; d < 2; d++)
      for (int c = 0; c < 2; c++) J[1 + d][c] -= l * (push.x[d][c] + shift[c] * push.v[d][c]);
  }
}

/* TipForce - the force f on a tip that is free. */
void TipForce(const Tip *tip, const TipState *at, const LoadDual *dual, PetscReal f[2]) {
  const PetscReal P = tip->force;

  f[0] = f[1] = 0;
  if (P != 0 && tip->law == TIP_DEAD)
    f[0] = -P;
  else if (P != 0 && tip->law == TIP_FOLLOWER)
    for (int d = 0; d < 2; d++) f[d] = -P * at->at.q[d];
  else if (P != 0) {
    LoadForce(&tip->resistance, &at->at, dual, f);
    for (int d = 0; d < 2; d++) f[d] *= -P;
  }
  if (tip->walls) AddWalls(tip, at, dual, f);
}

/* TipResidual - the three conditions at the tip, r = 0. */
void TipResidual(const Tip *tip, const TipState *at, const LoadDual *dual, PetscReal r[TIP_ROWS]) {
  PetscReal f[2];

  r[0] = tip->type == TIP_CLAMPED ? at->theta - tip->theta : at->moment;
  if (tip->type == TIP_FREE) TipForce(tip, at, dual, f);
  for (int d = 0; d < 2; d++)
    r[1 + d] = tip->type == TIP_FREE ? at->force[d] - f[d] : at->at.x[d] - tip->x[d];
}

/*
  TipJacobian - their derivatives by (x1, x2, theta, m, n1, n2), of which x_c has the rate
  shift[c] x_c + ...

  fresh, dual  as for LoadLinearise()
*/
void TipJacobian(const Tip *tip, const TipState *at, const PetscReal shift[2], PetscBool fresh,
                 LoadDual *dual, PetscReal J[TIP_ROWS][TIP_FIELDS]) {
  enum { X1, X2, TH, M, N1, N2 };
  const PetscReal P = tip->force, perp[2] = {-at->at.q[1], at->at.q[0]};
  LoadSlope slope = {.v = {{0}}};

  for (int i = 0; i < TIP_ROWS; i++)
    for (int j = 0; j < TIP_FIELDS; j++) J[i][j] = 0;
  J[0][tip->type == TIP_CLAMPED ? TH : M] = 1;
  for (int d = 0; d < 2; d++) J[1 + d][tip->type == TIP_FREE ? N1 + d : X1 + d] = 1;
  if (tip->type != TIP_FREE) return;
  if (tip->walls) AddWallsSlope(tip, at, shift, fresh, dual, J);
  if (P == 0) return;
  for (int d = 0; d < 2 && tip->law == TIP_FOLLOWER; d++) J[1 + d][TH] = P * perp[d];
  if (tip->law != TIP_RESISTANCE) return;
  LoadLinearise(&tip->resistance, &at->at, fresh, dual, &slope);
  for (int d = 0; d < 2; d++)
    for (int c = 0; c < 2; c++) J[1 + d][X1 + c] += P * (shift[c] * slope.v[d][c] + slope.x[d][c]);
}

/* TipCompression - how much the tip's force presses on a straight rod, which is at `at`. */
PetscReal TipCompression(const Tip *tip, const Place *at) {
  const LoadDual none = {.v = {0}};
  TipState state = {.at = *at};
  PetscReal f[2];

  TipForce(tip, &state, &none, f);
  return -f[0];
}
