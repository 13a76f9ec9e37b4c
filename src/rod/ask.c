#include "rod/ask.h"
#include <string.h>

/* Is it so of any rod? */
static PetscBool Any(const Rod rod, PetscBool (*is)(const struct _Scene *)) {
  for (PetscInt k = 0; k < rod->rods; k++)
    if (is(rod->each[k]->scene)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ---- parts ---- */

/* A vector on the reals of rod k among those of all. */
static PetscErrorCode PartOn(const Rod rod, PetscInt k, const PetscScalar *a, Vec *part) {
  const PetscInt fields = rod->model->fields, first = rod->at[k];

  PetscFunctionBegin;
  PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, fields, (rod->at[k + 1] - first) * fields,
                                  a + first * fields, part));
  PetscFunctionReturn(0);
}

/* RodPartOpen - the part of a vector that is one rod's, until RodPartClose(); of one rod the vector
   itself. */
PetscErrorCode RodPartOpen(const Rod rod, PetscInt k, Vec all, Vec *part) {
  PetscScalar *a;

  PetscFunctionBegin;
  *part = all;
  if (!rod->at) PetscFunctionReturn(0);
  PetscCall(VecGetArray(all, &a));
  PetscCall(PartOn(rod, k, a, part));
  PetscFunctionReturn(0);
}

PetscErrorCode RodPartClose(const Rod rod, PetscInt k, Vec all, Vec *part) {
  PetscScalar *a = NULL;

  PetscFunctionBegin;
  (void)k;
  if (!rod->at) PetscFunctionReturn(0);
  PetscCall(VecDestroy(part));
  PetscCall(VecRestoreArray(all, &a));
  PetscFunctionReturn(0);
}

/* RodPartOpenRead - the same, of a vector that is read alone: it does not count as changed. */
PetscErrorCode RodPartOpenRead(const Rod rod, PetscInt k, Vec all, Vec *part) {
  const PetscScalar *a;

  PetscFunctionBegin;
  *part = all;
  if (!rod->at || !all) PetscFunctionReturn(0);
  PetscCall(VecGetArrayRead(all, &a));
  PetscCall(PartOn(rod, k, a, part));
  PetscFunctionReturn(0);
}

PetscErrorCode RodPartCloseRead(const Rod rod, PetscInt k, Vec all, Vec *part) {
  const PetscScalar *a = NULL;

  PetscFunctionBegin;
  (void)k;
  if (!rod->at || !all) PetscFunctionReturn(0);
  PetscCall(VecDestroy(part));
  PetscCall(VecRestoreArrayRead(all, &a));
  PetscFunctionReturn(0);
}

/* ---- ends, length, units ---- */

/* RodEndsOf - what holds the ends. */
RodEnds RodEndsOf(const Rod rod) {
  RodEnds ends = {.clamped = PETSC_TRUE};

  for (PetscInt k = 0; k < rod->rods; k++) {
    const struct _Scene *scene = rod->each[k]->scene;
    if (scene->clamp != CLAMP_HELD) ends.clamped = PETSC_FALSE;
    if (scene->clamp == CLAMP_FREE) ends.begins_free = PETSC_TRUE;
    if (scene->clamp != CLAMP_HELD && scene->clamp != CLAMP_CARRIED) ends.gives_way = PETSC_TRUE;
    if (SceneCarried(scene)) ends.carried = PETSC_TRUE;
    if (scene->tip.type != TIP_FREE) ends.tip_held = PETSC_TRUE;
    if (TipHolds(&scene->tip, 1)) ends.tip_rests = PETSC_TRUE;
    if (TipPoints(&scene->tip)) ends.tip_points = PETSC_TRUE;
  }
  return ends;
}

/*
  RodLate - the nodes whose own block may be singular: what holds a tip, or lets a beginning give
  way, may leave it so. Their number.

  late  room for two of each rod
*/
PetscInt RodLate(const Rod rod, PetscInt late[]) {
  PetscInt n = 0;

  for (PetscInt k = 0; k < rod->rods; k++) {
    if (RodEndsOf(rod->each[k]).tip_held) late[n++] = rod->at ? rod->at[k + 1] - 1 : rod->last;
    if (rod->at && RodEndsOf(rod->each[k]).gives_way) late[n++] = rod->at[k];
  }
  return n;
}

/* RodLength - how long the rod is at time t; the longest of several. */
PetscErrorCode RodLength(const Rod rod, PetscReal t, PetscReal *length) {
  PetscReal one;

  PetscFunctionBegin;
  *length = 0;
  for (PetscInt k = 0; k < rod->rods; k++) {
    PetscCall(GrowthLength(rod->each[k]->scene->growth, t, &one, NULL));
    *length = PetscMax(*length, one);
  }
  PetscFunctionReturn(0);
}

/* RodStiffnessAt - stretch and stiffnesses at a node: SceneStiffnesses(), in the plane the first
   alone. */
PetscErrorCode RodStiffnessAt(const Rod rod, PetscInt node, PetscReal t, PetscReal *g,
                              PetscReal S[3]) {
  const Scene scene = rod->each[0]->scene;
  PetscReal B;

  PetscFunctionBegin;
  PetscCall(GrowthStretch(scene->growth, 1, &rod->s[node], t, g, NULL, NULL));
  PetscCall(SceneStiffness(scene, rod->s[node], t, &B, NULL));
  S[0] = B;
  if (rod->model->space) SceneStiffnesses(scene, B, S);
  PetscFunctionReturn(0);
}

/* RodLongest - how long it becomes at most in its run. */
PetscReal RodLongest(const Rod rod) {
  PetscReal longest = 0;

  for (PetscInt k = 0; k < rod->rods; k++) longest = PetscMax(longest, rod->each[k]->scene->reach);
  return longest;
}

/* RodLabels - those of its nodes, of one rod. Borrowed. */
const PetscReal *RodLabels(const Rod rod) {
  return rod->scene->mesh.s;
}

/* RodPassed - the labels that the front of its growth passes between two times, of one rod. */
void RodPassed(const Rod rod, PetscReal t0, PetscReal t1, PetscReal *from, PetscReal *to) {
  *from = GrowthFront(rod->scene->growth, t0);
  *to = GrowthFront(rod->scene->growth, t1);
}

/* RodEndTime - when its run ends, as its scene has it. */
PetscReal RodEndTime(const Rod rod) {
  return rod->each[0]->scene->end_time;
}

/* RodUnits - the units that its scene makes for itself; of several, those that suit all. Borrowed.
 */
const SceneUnits *RodUnits(const Rod rod) {
  return &rod->scene->units;
}

/* ---- contact ---- */

static PetscBool Touches(const struct _Scene *scene) {
  return scene->contact.any;
}

static PetscBool MeetsWalls(const struct _Scene *scene) {
  return (PetscBool)(scene->contact.walls.n || scene->contact.surfaces.n);
}

static PetscBool MeetsStrands(const struct _Scene *scene) {
  return ContactOfStrands(&scene->contact);
}

static PetscBool RubsOnWalls(const struct _Scene *scene) {
  return ContactWallsRub(&scene->contact);
}

static PetscBool MayGetFirm(const struct _Scene *scene) {
  return (PetscBool)(scene->contact.deepest != NULL);
}

/* RodTouches - can anything press on it, a wall, or itself? */
PetscBool RodTouches(const Rod rod) {
  return Any(rod, Touches);
}

/* RodMeetsWalls - can a wall? */
PetscBool RodMeetsWalls(const Rod rod) {
  return Any(rod, MeetsWalls);
}

/* RodMeetsStrands - can another part of it, or another rod? */
PetscBool RodMeetsStrands(const Rod rod) {
  return Any(rod, MeetsStrands);
}

/* RodRubsOnWalls - does a wall have friction? */
PetscBool RodRubsOnWalls(const Rod rod) {
  return Any(rod, RubsOnWalls);
}

/* RodMakeSlippery - from now on it is as if no wall had friction, or they have theirs again: to
   count modes. */
void RodMakeSlippery(Rod rod, PetscBool slippery) {
  for (PetscInt k = 0; k < rod->rods; k++) rod->each[k]->scene->contact.slippery = slippery;
}

/* RodLayer - the length over which contact spreads a force that acts at a point; the least one. */
PetscReal RodLayer(const Rod rod) {
  PetscReal least = PETSC_MAX_REAL;

  for (PetscInt k = 0; k < rod->rods; k++)
    least = PetscMin(least, rod->each[k]->scene->contact.tip);
  return least;
}

/* RodContactAt - makes its laws of contact those of time t: SceneContactAt(). */
PetscErrorCode RodContactAt(Rod rod, PetscReal t) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < rod->rods; k++) PetscCall(SceneContactAt(rod->each[k]->scene, t));
  PetscFunctionReturn(0);
}

/* RodMayGetFirm - may its contact become firmer in the course of a run? */
PetscBool RodMayGetFirm(const Rod rod) {
  return Any(rod, MayGetFirm);
}

/* RodForgetDepth - a residual is asked for: how deep the rod is pressed in begins at 0. */
void RodForgetDepth(Rod rod) {
  for (PetscInt k = 0; k < rod->rods; k++) {
    PetscReal *deepest = rod->each[k]->scene->contact.deepest;
    if (deepest) *deepest = 0;
  }
}

/* RodGetsFirm - is the state whose residual was the last in a wall, or in itself, where contact is
   to be firmer than it was taken for? From now on it is. Collective. */
PetscErrorCode RodGetsFirm(Rod rod, PetscBool *firm) {
  PetscReal deepest;

  PetscFunctionBegin;
  *firm = PETSC_FALSE;
  for (PetscInt k = 0; k < rod->rods; k++) {
    Contact *contact = &rod->each[k]->scene->contact;
    if (!contact->deepest || contact->firm) continue;
    PetscCallMPI(MPI_Allreduce(contact->deepest, &deepest, 1, MPIU_REAL, MPIU_MAX, rod->comm));
    if (ContactGetsFirm(contact, deepest)) *firm = PETSC_TRUE;
  }
  PetscFunctionReturn(0);
}

/* RodStaysFirm - contact that may become firmer is so from the start. */
void RodStaysFirm(Rod rod) {
  for (PetscInt k = 0; k < rod->rods; k++) {
    Contact *contact = &rod->each[k]->scene->contact;
    if (contact->deepest) contact->firm = PETSC_TRUE;
  }
}

/* ---- friction ---- */

static PetscBool IsDry(const struct _Scene *scene) {
  return LoadIsDry(&scene->load);
}

static PetscBool Sticks(const struct _Scene *scene) {
  return LoadSticks(&scene->load);
}

static PetscBool IsNotViscous(const struct _Scene *scene) {
  const Contact *contact = &scene->contact;

  return (PetscBool)(!LoadIsLinear(&scene->load) || scene->tip.law == TIP_RESISTANCE ||
                     ContactWallsRub(contact) ||
                     (ContactOfStrands(contact) && contact->friction > 0));
}

static PetscBool IsLimit(const struct _Scene *scene) {
  return scene->load.limit;
}

static PetscBool FeelsSpin(const struct _Scene *scene) {
  return (PetscBool)(scene->load.radius > 0);
}

/* RodIsDry - is its friction dry, so that it may snap? */
PetscBool RodIsDry(const Rod rod) {
  return Any(rod, IsDry);
}

/* RodSticks - is there exact Coulomb friction, by which places stick? */
PetscBool RodSticks(const Rod rod) {
  return Any(rod, Sticks);
}

/* RodIsViscous - is all friction viscous, and so as straight in speed as can be? */
PetscBool RodIsViscous(const Rod rod) {
  return (PetscBool)!Any(rod, IsNotViscous);
}

/* RodIsLimit - is exact friction taken for the limit of one with a beta? */
PetscBool RodIsLimit(const Rod rod) {
  return Any(rod, IsLimit);
}

/* RodFeelsSpin - has friction a radius at which it feels that the rod turns about its tangent? */
PetscBool RodFeelsSpin(const Rod rod) {
  return Any(rod, FeelsSpin);
}

/* RodSwapSlopes - friction along it, and at its tip, has these slopes from now on; out: those that
   it had. */
void RodSwapSlopes(Rod rod, FrictionNewton slope[2]) {
  const FrictionNewton taken[] = {slope[0], slope[1]};

  for (PetscInt k = 0; k < rod->rods; k++) {
    Scene scene = rod->each[k]->scene;
    slope[0] = scene->load.friction.newton;
    slope[1] = scene->tip.resistance.friction.newton;
    scene->load.friction.newton = taken[0];
    scene->tip.resistance.friction.newton = taken[1];
  }
}

/* Is no energy behind the equations? By friction on walls or strands, by that which is weaker
   across than along, or feels a spin; where material learns its natural curvature; and where it
   comes to rest: see stepping/leg.c. */
static PetscBool HasNoModes(const struct _Scene *scene) {
  const Contact *contact = &scene->contact;
  const Load *load = &scene->load;

  if (scene->tropism.any) return PETSC_TRUE;
  return (PetscBool)(ContactWallsRub(contact) || contact->friction > 0 || load->radius > 0 ||
                     scene->space.spin != 0 || load->turns || scene->growth->rests);
}

/* RodHasModes - are the modes of a state that is frozen those of the rod that moves on? */
PetscBool RodHasModes(const Rod rod) {
  return (PetscBool) !(rod->coupled || Any(rod, HasNoModes));
}

/* ---- snaps ---- */

/* RodFalls - the speed at which it snaps: RodAtSpeed(); 0: it does not. */
PetscReal RodFalls(const Rod rod) {
  return rod->each[0]->scene->falls;
}

/* RodAtSpeed - it snaps at this speed, all of it, or no more: SceneAtSpeed(). */
void RodAtSpeed(Rod rod, PetscReal speed) {
  for (PetscInt k = 0; k < rod->rods; k++) SceneAtSpeed(rod->each[k]->scene, speed);
}

/* ---- what drives it ---- */

/* RodSteered - how large what steers the rod, a natural curvature that changes, may make a field;
   0: nothing does. */
PetscReal RodSteered(const Rod rod, PetscInt field) {
  static const char *const moved[STRAINS] = {
      [BEND_3] = "theta x2 p3", [BEND_2] = "x3 p2", [TURN_1] = "p1"};
  PetscReal most = 0;

  for (PetscInt k = 0; k < rod->rods; k++) {
    const Curvature *curvature = &rod->each[k]->scene->curvature;
    for (int e = 0; e < STRAINS && curvature->steered; e++)
      if (strstr(moved[e], rod->model->field[field]))
        most = CurvatureSteered(curvature, e) * RodUnits(rod)->length * RodFieldUnit(rod, field);
  }
  return most;
}

/* RodSteeredTo - the largest bend by nature to which it is steered; 0: it is not. */
PetscReal RodSteeredTo(const Rod rod) {
  PetscReal most = 0;

  for (PetscInt k = 0; k < rod->rods; k++) {
    const Curvature *curvature = &rod->each[k]->scene->curvature;
    if (!curvature->steered) continue;
    most = PetscMax(
        most, PetscMax(CurvatureSteered(curvature, BEND_2), CurvatureSteered(curvature, BEND_3)));
  }
  return most;
}

/* RodRounding - the energy that round-off leaves of a rod that is bent by nature, or that a weight
   across it, which something else balances, would bend. */
PetscReal RodRounding(const Rod rod, PetscReal length) {
  PetscReal most = 0;

  for (PetscInt k = 0; k < rod->rods; k++) {
    const Scene scene = rod->each[k]->scene;
    const PetscReal across = Size2(From2(scene->load.weight + 1)),
                    moment = PETSC_MACHINE_EPSILON * across * PetscSqr(length);
    most = PetscMax(most, CurvatureRounding(&scene->curvature, length));
    most = PetscMax(most, PetscSqr(moment) * length);
  }
  return most;
}

/* RodNextTurn - the first time behind t at which what tables give sets out, stops or turns back:
   SceneNextTurn(). */
PetscReal RodNextTurn(const Rod rod, PetscReal t) {
  PetscReal next = PETSC_MAX_REAL;

  for (PetscInt k = 0; k < rod->rods; k++)
    next = PetscMin(next, SceneNextTurn(rod->each[k]->scene, t));
  return next;
}

static PetscBool MayJerk(const struct _Scene *scene) {
  return (PetscBool)(scene->curvature.steered || scene->growth->jerks || scene->born > 0);
}

/* RodMayJerk - is it fed, or bent by nature, in a way that may set out or stop at once, or born? */
PetscBool RodMayJerk(const Rod rod) {
  return Any(rod, MayJerk);
}

/* RodJerks - does that happen between two times? */
PetscBool RodJerks(const Rod rod, PetscReal t0, PetscReal t1) {
  for (PetscInt k = 0; k < rod->rods; k++)
    if (SceneJerks(rod->each[k]->scene, t0, t1)) return PETSC_TRUE;
  return PETSC_FALSE;
}
