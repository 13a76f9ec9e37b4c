#include "world/load.h"
#include "base/vectors.h"

static const OptionRow rows[] = {
    ROW_REAL("-friction_strength", "1", 0, 1e9, UNIT_NONE, 0,
             "of one of several rods: its friction over that of the scales"),
    ROW_REAL("-friction_across", "1", 1e-6, 1e6, UNIT_NONE, 0,
             "a, ratio of friction across the rod to that along it, dry and viscous alike"),
    ROW_TEXT("-friction_field", INPUT_FILE,
             "HDF5 file with /x1 [n1], /x2 [n2], /factor [n2, n1], or also /x3 [n3], /t [nt] and "
             "/factor [nt, n3, n2, n1]: what friction is multiplied by, constant beyond the edges"),
    ROW_TEXT("-friction_layers", 0,
             "\"X:F,X:F,...\": friction in layers along x1, the start of each and its factor"),
    ROW_REAL("-friction_layer_width", "0.1", 1e-9, 1e6, UNIT_LENGTH, 0,
             "length over which layers are joined")};
const OptionGroup load_options = OPTION_GROUP_OF_ROD("Friction that varies", rows);

static PetscErrorCode ReadField(Load *load) {
  char file[PETSC_MAX_PATH_LEN] = "", layers[PETSC_MAX_PATH_LEN] = "";
  PetscReal width;
  PetscBool from_file, layered;

  PetscFunctionBegin;
  PetscCall(OptionText("-friction_field", file, &from_file));
  PetscCall(OptionText("-friction_layers", layers, &layered));
  UserCheck(!from_file || !layered, OptionsComm(),
            "-friction_field and -friction_layers: give one of them");
  if (layered) {
    PetscCall(OptionReal("-friction_layer_width", &width, NULL));
    PetscCall(FieldFromLayers("-friction_layers", layers, width, &load->field));
  }
  if (from_file) PetscCall(FieldFromFile("-friction_field", file, &load->field));
  PetscFunctionReturn(0);
}

#define LISTED(law) &law,
static const FrictionLaw *const laws[] = {FRICTION_LAWS(LISTED)};
#undef LISTED

/* LoadLawOptions - the options that laws beside the built-in one have: adds their groups, and says
   how many these are; at most ALL_FRICTION_LAWS. */
size_t LoadLawOptions(const OptionGroup *groups[]) {
  size_t n = 0;

  for (int k = 0; k < ALL_FRICTION_LAWS; k++)
    if (laws[k]->options) groups[n++] = laws[k]->options;
  return n;
}

static PetscErrorCode ReadLaws(Load *load) {
  PetscFunctionBegin;
  load->laws = 0;
  load->along = PETSC_FALSE;
  for (int k = 0; k < ALL_FRICTION_LAWS; k++) {
    LoadLaw law = {.kind = laws[k]};
    PetscCall(law.kind->create(&law.known));
    if (!law.known) continue;
    load->law[load->laws++] = law;
    load->along = (PetscBool)(load->along || law.kind->along);
  }
  PetscFunctionReturn(0);
}

/* LoadHas - was this law asked for? */
PetscBool LoadHas(const Load *load, const FrictionLaw *kind) {
  for (int k = 0; k < load->laws; k++)
    if (load->law[k].kind == kind) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* LoadAlong - the option by which friction varies along the rod, whatever its place; NULL: none. */
const char *LoadAlong(const Load *load) {
  for (int k = 0; k < load->laws; k++)
    if (load->law[k].kind->along) return load->law[k].kind->option;
  return NULL;
}

/* LoadIsLinear - is friction along the rod so by the velocity? */
PetscBool LoadIsLinear(const Load *load) {
  for (int k = 0; k < load->laws; k++)
    if (!load->law[k].kind->linear) return PETSC_FALSE;
  return (PetscBool)(load->friction.mu == 0);
}

/* LoadDrag - F/v by all laws beside the built-in one, and its derivative by |v|^2. */
void LoadDrag(const Load *load, const Place *at, PetscReal speed2, PetscReal drag[]) {
  drag[0] = drag[1] = 0;
  for (int k = 0; k < load->laws; k++) {
    PetscReal part[] = {0, 0};
    load->law[k].kind->drag(load->law[k].known, at, speed2, part);
    drag[0] += part[0];
    drag[1] += part[1];
  }
}

/* LoadRubLaws - adds what they do to f. */
void LoadRubLaws(int n, const Load *load, const Place *at, const PetscReal W[], PetscReal f[]) {
  PetscReal drag[] = {0, 0};

  LoadDrag(load, at, FrictionSquare(n, W), drag);
  for (int d = 0; d < n; d++) f[d] += drag[0] * W[d];
}

/* LoadRubLawsSlope - ... and to its slope by W. */
void LoadRubLawsSlope(int n, const Load *load, const Place *at, const PetscReal W[],
                      PetscReal slope[RUBS][RUBS]) {
  PetscReal drag[] = {0, 0};

  LoadDrag(load, at, FrictionSquare(n, W), drag);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      slope[i][j] += (i == j) * drag[0];
      slope[i][j] += 2 * drag[1] * W[i] * W[j];
    }
}

/*
  LoadAxialBetween - the axial load on a piece of straight rod of unit length, whose speed rises
  evenly from a to b, times b - a; N = 1, and no law varies along the rod. Of laws beside the
  built-in one by Gauss's rule: exact for a phi that is a polynomial of degree 8.
*/
PetscReal LoadAxialBetween(const Load *load, PetscReal a, PetscReal b) {
  static const PetscReal point[5] = {-0.9061798459386640, -0.5384693101056831, 0,
                                     0.5384693101056831, 0.9061798459386640},
                         weight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                      0.4786286704993665, 0.2369268850561891};
  const Place at = {.s = 0};
  PetscReal sum = 0;

  for (int k = 0; k < 5 && load->laws; k++) {
    const PetscReal v = (a + b) / 2 + (b - a) / 2 * point[k];
    PetscReal drag[] = {0, 0};
    LoadDrag(load, &at, v * v, drag);
    sum += weight[k] * drag[0] * v;
  }
  return FrictionBetween(&load->friction, a, b) + sum * (b - a) / 2;
}

/*
  LoadSetFromOptions - reads and checks the options of all terms. Collective; the caller ends it
  with LoadDestroy(), also after an error.
*/
PetscErrorCode LoadSetFromOptions(Load *load) {
  PetscReal strength;

  PetscFunctionBegin;
  PetscCall(FrictionSetFromOptions(&load->friction));
  PetscCall(ReadLaws(load));
  load->viscous = 1 - load->friction.mu;
  PetscCall(OptionReal("-friction_across", &load->across, NULL));
  PetscCall(ReadField(load));
  load->factor = 1;
  load->turns = (PetscBool)(load->across != 1);
  load->moves = (PetscBool)(load->field != NULL);
  load->varied = (PetscBool)(load->turns || load->moves);
  load->plain = (PetscBool)!load->varied;
  load->walls = NULL;
  load->duals = load->duals3 = 1;
  load->weighs = PETSC_FALSE;
  load->radius = 0;
  PetscCall(OptionReal("-friction_strength", &strength, NULL));
  if (strength != 1) LoadSetFactor(load, strength);
  PetscFunctionReturn(0);
}

/* LoadSetWalls - lets the walls of a contact press, if it has any; it must outlive the load. */
void LoadSetWalls(Load *load, const Contact *contact) {
  if (!contact->walls.n && !contact->surfaces.n) return;
  load->walls = contact;
  load->plain = PETSC_FALSE;
  load->moves = PETSC_TRUE;
  if (contact->walls.rub) load->duals = 1 + contact->walls.n + (contact->walls.posts > 0);
  if (ContactWallsRub(contact)) load->duals3 = 1 + WALL_SLOTS;
}

/* LoadSetWeight - a force per length, in the clamp's frame. */
void LoadSetWeight(Load *load, const PetscReal weight[3]) {
  for (int d = 0; d < 3; d++) {
    load->weight[d] = weight[d];
    load->weighs = (PetscBool)(load->weighs || weight[d] != 0);
  }
  load->plain = (PetscBool)(load->plain && !load->weighs);
}

/* LoadSetFactor - multiplies all friction along the rod, and across it. */
void LoadSetFactor(Load *load, PetscReal factor) {
  load->factor = factor;
  load->varied = PETSC_TRUE;
  load->plain = PETSC_FALSE;
}

PetscErrorCode LoadDestroy(Load *load) {
  PetscFunctionBegin;
  PetscCall(FieldDestroy(&load->field));
  for (; load->laws > 0; load->laws--) {
    LoadLaw *law = &load->law[load->laws - 1];
    if (law->kind->destroy) PetscCall(law->kind->destroy(&law->known));
  }
  PetscFunctionReturn(0);
}

/* LoadFactor - N at a place in the clamp's frame, and its derivatives there. */
PetscReal LoadFactor(const Load *load, const PetscReal x[3], PetscReal t, PetscReal slope[3]) {
  PetscReal lab[3], by[3], factor;

  for (int d = 0; d < 3; d++) slope[d] = 0;
  if (!load->field) return load->factor;
  for (int d = 0; d < 3; d++) lab[d] = Dot3(load->lab[d], x) + load->place[d];
  FieldAt(load->field, lab, t, &factor, by);
  TurnBack3(load->lab, by, slope);
  for (int d = 0; d < 3; d++) slope[d] *= load->factor;
  return load->factor * factor;
}

/* N at a place, and its derivatives there, which are 0 where nothing varies from place to place. */
static PetscReal FactorAt(const Load *load, const Place *at, PetscReal by[3]) {
  if (load->field) return LoadFactor(load, at->x, at->t, by);
  for (int d = 0; d < 3; d++) by[d] = 0;
  return load->factor;
}

/* LoadVary - f <- N M f, and in space N times the couple. */
void LoadVary(int dims, const Load *load, const Place *at, PetscReal f[RUBS]) {
  const PetscReal *q = at->axes[0], a = load->across;
  PetscReal by[3], N = FactorAt(load, at, by);

  if (dims == 2) {
    const PetscReal along = q[0] * f[0] + q[1] * f[1], across = a * (q[0] * f[1] - q[1] * f[0]);
    f[0] = N * (along * q[0] - across * q[1]);
    f[1] = N * (along * q[1] + across * q[0]);
  } else {
    const PetscReal more = (1 - a) * Dot3(q, f);
    for (int d = 0; d < 3; d++) f[d] = N * (a * f[d] + more * q[d]);
    f[SPIN] *= N;
  }
}

/* dF/dv = N M df/dv,   dF/dtheta = N (1 - a) (q_perp (q.f) + q (q_perp.f)),
   dF/dx = (M f) (dN/dx)^T */
static void VarySlopeInPlane(const Load *load, const Place *at, const FrictionDual *dual,
                             LoadSlope *slope) {
  enum { DIMS = 2 };
  const PetscReal *q = at->axes[0], perp[] = {-q[1], q[0]}, a = load->across;
  PetscReal by[3], N = FactorAt(load, at, by), f[RUBS], along, across;

  for (int c = 0; c < DIMS; c++) {
    along = N * (q[0] * slope->W[0][c] + q[1] * slope->W[1][c]);
    across = N * a * (perp[0] * slope->W[0][c] + perp[1] * slope->W[1][c]);
    for (int d = 0; d < DIMS; d++) slope->W[d][c] = along * q[d] + across * perp[d];
  }
  LoadRub(DIMS, load, at, at->v, dual, f);
  along = q[0] * f[0] + q[1] * f[1];
  across = perp[0] * f[0] + perp[1] * f[1];
  for (int d = 0; d < DIMS; d++) {
    slope->theta[d] = N * (1 - a) * (along * perp[d] + across * q[d]);
    for (int c = 0; c < DIMS; c++) slope->x[d][c] = (along * q[d] + a * across * perp[d]) * by[c];
  }
}

/* dN M f: by W, as friction feels it, by q and by x. */
static void VarySlopeInSpace(const Load *load, const Place *at, const PetscReal W[RUBS],
                             const FrictionDual *dual, LoadSlope *slope) {
  const PetscReal *q = at->axes[0], a = load->across;
  PetscReal by[3], N = FactorAt(load, at, by), f[RUBS], along;

  for (int c = 0; c < RUBS; c++) {
    PetscReal column[3];
    Column3(slope->W[0], RUBS, c, column);
    along = (1 - a) * Dot3(q, column);
    for (int d = 0; d < 3; d++) slope->W[d][c] = N * (a * slope->W[d][c] + along * q[d]);
    slope->W[SPIN][c] *= N;
  }
  LoadRub(RUBS, load, at, W, dual, f);
  along = Dot3(q, f);
  for (int d = 0; d < 3; d++)
    for (int c = 0; c < 3; c++) {
      slope->q[d][c] = N * (1 - a) * ((d == c) * along + q[d] * f[c]);
      slope->x[d][c] = (a * f[d] + (1 - a) * along * q[d]) * by[c];
    }
  for (int c = 0; c < 3; c++) {
    slope->x[SPIN][c] = load->radius * f[SPIN] * by[c];
    slope->q[SPIN][c] = 0;
  }
}

/* LoadVarySlope - from the slope of f by W to those of N M f. */
void LoadVarySlope(int dims, const Load *load, const Place *at, const PetscReal W[],
                   const FrictionDual *dual, LoadSlope *slope) {
  if (dims == 2)
    VarySlopeInPlane(load, at, dual, slope);
  else
    VarySlopeInSpace(load, at, W, dual, slope);
}

/* LoadSetArm - of W, once friction and walls are known. */
void LoadSetArm(Load *load) {
  load->arm = load->radius;
  if (load->arm == 0 && load->duals3 > 1) load->arm = load->walls->diameter / 2;
}

/* LoadInSpace - does it act out of the plane of x1 and x2, whatever the rod does? */
PetscBool LoadInSpace(const Load *load) {
  return FieldInSpace(load->field);
}

/* LoadForceWalls - takes off f what walls push with; returns the power of those that move. */
PetscReal LoadForceWalls(int dims, const Load *load, const Place *at, const FrictionDual *dual,
                         PetscReal f[RUBS]) {
  const Rubbed rubbed = LoadRubbed(load, at);

  return -ContactPushAll(dims, load->walls, &rubbed, dual, -1, f);
}

/* LoadSlopeWalls - the same for the slopes. */
void LoadSlopeWalls(int dims, const Load *load, const Place *at, PetscBool fresh,
                    FrictionDual *dual, LoadSlope *slope) {
  const int rubs = LoadRubs(dims);
  FrictionDual *duals = ContactDuals(dims, load->walls, dual);
  const Rubbed rubbed = LoadRubbed(load, at);
  Touch touch[MOST_TOUCHES];
  PetscInt n = ContactTouches(dims, load->walls, at->x, touch);
  Push push;

  if (duals) ContactSlots(dims, n, touch, duals);
  for (PetscInt k = 0; k < n; k++) {
    ContactPushSlope(dims, load->walls, &touch[k], &rubbed, fresh,
                     ContactDual(dims, &touch[k], duals), &push);
    for (int d = 0; d < rubs; d++) {
      for (int c = 0; c < dims; c++) {
        slope->x[d][c] -= push.x[d][c];
        slope->W[d][c] -= push.W[d][c];
        if (dims == 3) slope->q[d][c] -= push.q[d][c];
      }
      if (dims == 3 && load->arm > 0) slope->W[d][SPIN] -= push.W[d][SPIN] / load->arm;
    }
  }
}

/* LoadParts - the forces of friction and of walls on the rod, per length, and the power of walls
   that move. */
void LoadParts(int dims, const Load *load, const Place *at, const FrictionDual *dual,
               PetscReal friction[3], PetscReal walls[3], PetscReal *moved) {
  PetscReal W[RUBS], f[RUBS], of_walls[RUBS] = {0};

  LoadFelt(dims, load, at, W);
  LoadRub(LoadRubs(dims), load, at, W, dual, f);
  if (load->varied) LoadVary(dims, load, at, f);
  *moved = load->walls ? LoadForceWalls(dims, load, at, dual, of_walls) : 0;
  for (int d = 0; d < dims; d++) {
    friction[d] = -f[d];
    walls[d] = -of_walls[d];
  }
}

/* LoadHold - moves what holds a sticking place; returns the speed at which it creeps. */
PetscReal LoadHold(int dims, const Load *load, const Place *at, PetscReal seen,
                   FrictionDual dual[]) {
  const Rubbed rubbed = LoadRubbed(load, at);
  PetscReal W[RUBS], creep;

  LoadFelt(dims, load, at, W);
  creep = FrictionHold(LoadRubs(dims), W, seen, friction_hold, dual);
  if (!load->walls) return creep;
  return LargerOf(creep, ContactHold(dims, load->walls, &rubbed, seen, dual));
}

static const PetscReal nearly_dry = 1e-4; /* 1 - mu up to here: a rod may snap */

/* LoadIsDry - was no viscous share to speak of asked for, so that a rod may snap? */
PetscBool LoadIsDry(const Load *load) {
  return (PetscBool)(load->viscous <= nearly_dry);
}

/*
  The least viscous share. Dry friction is 1 per length at most. Where a bent rod pulls harder, no
  velocity balances it: with mu = 1 the rod snaps, and where it comes to rest depends on the path.
  The path is that of a vanishing viscous share d: friction mu v/|v| + d v. So there always is a
  share, so small that it is seen in a snap alone, and a snap is a motion like others, if a fast
  one. Behind a snap a rod is off by 15 d of its size at most; with 1e-7 steps find it harder to
  follow (snaps.py).
*/
static const PetscReal least_share = 1e-6;

/* LoadLeastViscous - viscous friction with that share at this speed, at which the rod moves else;
   or what was asked for. */
PetscReal LoadLeastViscous(const Load *load, PetscReal speed) {
  return PetscMax(load->viscous, least_share * (1 - load->viscous) / speed);
}

/* LoadShareLeast - gives dry friction that share, unless it has a larger one, where the rod is much
   faster than this speed. */
void LoadShareLeast(Load *load, PetscReal speed) {
  const PetscReal fast = 10;

  load->friction.least = 0;
  load->friction.fast = fast * speed;
  if (!load->shared) load->friction.least = LoadLeastViscous(load, speed) - load->viscous;
}

/* The smallest beta in place of 0, and the speed that steps of tolerance 1e-6 tell from rest; where
   a wall holds the rod by its tip, and little of it is at rest for long, they tell a tenth of it.
 */
static const PetscReal next_to_exact = 1e-16, resolved_from_rest = 3e-5, resolved_by_walls = 3e-6,
                       its_tolerance = 1e-6;

/* LoadNextToExact - for a rod of which a part is at rest: there exact Coulomb friction does not say
   what the axial force is. So it is taken as what it is the limit of, which says that it is the
   least that balance allows. Likewise a rod that friction holds from turning: where it is at rest
   twist decides between two ways round, and round-off between them. */
void LoadNextToExact(Load *load) {
  load->limit = (PetscBool)(load->limit || LoadSticks(load));
  load->resolved = resolved_from_rest;
  if (load->limit) load->friction.beta = next_to_exact;
}

/* LoadIsNextToExact - is it, as a limit or by its own beta, of a rod of which a part is at rest?
   Steps of the usual tolerance do not tell that from what creeps. */
PetscBool LoadIsNextToExact(const Load *load) {
  return (PetscBool)(load->resolved > 0 && load->friction.mu > 0 &&
                     load->friction.beta <= PetscSqr(load->resolved));
}

/* LoadNextToExactByWalls - and for one that walls may hold at its tip: all of it may be at rest,
   and where it starts again behind a snap steps are so short that the noise of its velocities is
   more than they are. */
void LoadNextToExactByWalls(Load *load) {
  if (load->limit) return;
  LoadNextToExact(load);
  load->resolved = resolved_by_walls;
}

/*
  LoadAtTolerance - the same for steps of a tolerance: with sqrt(beta) far below the noise of their
  velocities, material at rest would be pushed to and fro by all that friction can, and forces add
  up to noise. So sqrt(beta) is about what they tell from rest; noise falls more slowly than the
  tolerance, for that of the mesh stays. No effect on a load that is not next to exact.
*/
void LoadAtTolerance(Load *load, PetscReal rtol) {
  PetscReal speed = load->resolved * PetscSqrtReal(rtol / its_tolerance);
  if (load->limit) load->friction.beta = PetscMax(next_to_exact, PetscSqr(speed));
}

/* The largest viscous share that is given: results are off by some percent with it. */
static const PetscReal most_shared = 1e-2, raised_by = 10;

/* LoadShare - gives dry friction this viscous share. */
void LoadShare(Load *load, PetscReal share) {
  load->friction.mu = 1 - share;
  load->friction.viscous = 1 - load->friction.mu; /* as a restart has it */
  load->friction.least = 0;
  load->shared = PETSC_TRUE;
}

/* LoadSharesMost - has it as large a share as there is? */
PetscBool LoadSharesMost(const Load *load) {
  return (PetscBool)(load->shared && raised_by * (1 - load->friction.mu) > 2 * most_shared);
}

/*
  LoadShareMore - for a rod that slips again and again. Where friction across is weaker than along,
  dry friction is not the derivative of a dissipation, and of a bent rod it need not say with which
  velocity it moves: docs/theory/friction.md. So from then on a part nearly_dry of it is viscous, by
  which results are off about as much; or ten times the part that is. Stronger friction across asks
  for none.

  Returns whether it could.
*/
PetscBool LoadShareMore(Load *load) {
  PetscReal share = load->shared ? raised_by * (1 - load->friction.mu) : nearly_dry;

  if (load->across >= 1 || 1 - load->friction.mu >= share || share > 2 * most_shared)
    return PETSC_FALSE;
  LoadShare(load, share);
  return PETSC_TRUE;
}

/* LoadMaySlip - may it be that friction does not say how fast a bent rod moves? */
PetscBool LoadMaySlip(const Load *load) {
  return (PetscBool)(load->across < 1 && (load->shared || LoadIsDry(load)));
}

/* LoadIsEven - does the load leave a straight rod straight, up to this length and time? Not if a
   field changes across the axis. */
PetscBool LoadIsEven(const Load *load, PetscReal length, PetscReal end) {
  enum { ALONG = 200, TIMES = 20 };

  for (int i = 0; i <= ALONG && load->moves; i++)
    for (int j = 0; j <= TIMES; j++) {
      const PetscReal x[3] = {length * i / ALONG, 0, 0};
      PetscReal slope[3];
      (void)LoadFactor(load, x, end * j / TIMES, slope);
      if (PetscMax(PetscAbsReal(slope[1]), PetscAbsReal(slope[2])) > 1e-9) return PETSC_FALSE;
    }
  return PETSC_TRUE;
}
