/* The equations of joints (joints.h), and their derivatives. */
#include "system/joints.h"
#include "base/quaternion.h"
#include "base/vectors.h"
#include "rod/space_cells.h"

typedef PetscReal JointBlock[FIELDS][FIELDS];

/* A joint in a state: where its ends are, and how its rod is turned there by what carries it. */
typedef struct {
  const Joint *joint;
  PetscInt own, of; /* nodes among those of all */
  const PetscReal *u, *u_P;
  PetscReal after[4], held[4]; /* what comes behind p_P in p_P q, and p as a weld has it */
  PetscReal per_turn, per_place;
} Seen;

static void See(const Joint *joint, const Rod all, PetscReal t, const PetscReal *u, Seen *seen) {
  const Scene scene = all->each[joint->rod]->scene;
  PetscReal begun[4], turned[4], twist[4], carried[4];

  *seen = (Seen){.joint = joint, .per_turn = 1, .per_place = 1};
  seen->own = joint->tip ? all->at[joint->rod + 1] - 1 : all->at[joint->rod];
  seen->of = all->at[joint->carrier] + joint->node;
  seen->u = u + seen->own * FIELDS;
  seen->u_P = u + seen->of * FIELDS;
  memcpy(seen->after, joint->turn, sizeof(seen->after));
  if (joint->tip) {
    seen->per_turn = scene->tip.per_turn;
    seen->per_place = scene->tip.per_place;
  } else { /* it may turn there about itself */
    SpaceClampTurn(&scene->space, 0, begun);
    SpaceClampTurn(&scene->space, t, turned);
    QuaternionFrom(begun, turned, twist);
    QuaternionTimes(joint->turn, twist, seen->after);
  }
  QuaternionTimes(joint->from_carrier, seen->u_P + P, carried);
  QuaternionTimes(carried, seen->after, seen->held);
}

/* Is its rod still to come? Then it is none. */
static PetscBool IsToCome(const Joint *joint, const Rod all, PetscReal t) {
  return SceneRests(all->each[joint->rod]->scene, t);
}

/* Does the joint let the rod turn about a direction of its basis? */
static PetscBool Turns(const Joint *joint, int i) {
  return (PetscBool)(joint->kind == JOINT_BALL || (joint->kind == JOINT_HINGE && i == 0));
}

/* What says how the rod is turned: three numbers, moments or turns. */
static void TurnResidual(const Seen *seen, PetscReal r[3]) {
  const PetscReal *p = seen->u + P, size = QuaternionSize(p);
  PetscReal d[3][3], turn[4];

  Directors(p, size, d);
  QuaternionFrom(seen->held, p, turn);
  for (int i = 0; i < 3; i++) {
    const PetscReal *basis = seen->joint->basis[i];
    r[i] = 0;
    for (int k = 0; k < 3; k++)
      r[i] += basis[k] *
              (Turns(seen->joint, i) ? Dot3(d[k], seen->u + M) : seen->per_turn * turn[1 + k]);
  }
}

/* ... by the rod's node and by the carrier's. */
static void TurnSlope(const Seen *seen, PetscReal own[3][FIELDS], PetscReal of[3][FIELDS]) {
  const PetscReal *p = seen->u + P, *m = seen->u + M, size = QuaternionSize(p);
  PetscReal d[3][3], slope[3][3][4], by_own[4][4], by_of[4][4];

  Directors(p, size, d);
  for (int k = 0; k < 3; k++) DirectorSlope(p, size, d[k], k, slope[k]);
  for (int j = 0; j < 4; j++) {
    const PetscReal unit[4] = {j == 0, j == 1, j == 2, j == 3};
    PetscReal carried[4], held[4];
    QuaternionFrom(seen->held, unit, by_own[j]);
    QuaternionTimes(seen->joint->from_carrier, unit, carried);
    QuaternionTimes(carried, seen->after, held);
    QuaternionFrom(held, p, by_of[j]);
  }
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      const PetscReal b = seen->joint->basis[i][k];
      for (int l = 0; l < 3 && Turns(seen->joint, i); l++) {
        own[i][M + l] += b * d[k][l];
        for (int j = 0; j < 4; j++) own[i][P + j] += b * slope[k][l][j] * m[l];
      }
      for (int j = 0; j < 4 && !Turns(seen->joint, i); j++) {
        own[i][P + j] += b * seen->per_turn * by_own[j][1 + k];
        of[i][P + j] += b * seen->per_turn * by_of[j][1 + k];
      }
    }
}

/* Where the place that carries the rod is. */
static void PlaceOf(const Seen *seen, PetscReal x[3]) {
  const Joint *joint = seen->joint;

  for (int i = 0; i < 3; i++) {
    x[i] = joint->x[i];
    for (int k = 0; k < 3; k++)
      x[i] += joint->to_carrier[k][i] * (seen->u_P[X + k] - joint->x_P[k]);
  }
}

/* Where the rod is, less where that is. */
static void PlaceResidual(const Seen *seen, PetscReal r[3]) {
  const Joint *joint = seen->joint;

  for (int i = 0; i < 3; i++) {
    r[i] = seen->u[X + i] - joint->x[i];
    for (int k = 0; k < 3; k++)
      r[i] -= joint->to_carrier[k][i] * (seen->u_P[X + k] - joint->x_P[k]);
    r[i] *= seen->per_place;
  }
}

/* The rows of the rod's end, and what it does to its carrier. */
static void AddResidual(const Seen *seen, PetscReal own[FIELDS], PetscReal of[FIELDS]) {
  const Joint *joint = seen->joint;
  const PetscReal sign = joint->tip ? -1 : 1, *p = seen->u + P;

  PlaceResidual(seen, own + (joint->tip ? N : X));
  if (joint->tip)
    TurnResidual(seen, own + M);
  else if (joint->kind == JOINT_WELD)
    for (int k = 0; k < 4; k++) own[P + k] = p[k] - seen->held[k];
  else {
    own[P] = (QuaternionSize(p) - 1) / 2;
    TurnResidual(seen, own + P + 1);
  }
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      of[M + i] += sign * joint->to_carrier[i][k] * seen->u[M + k];
      of[N + i] += sign * joint->to_carrier[i][k] * seen->u[N + k];
    }
}

/* JointsResidual - adds the equations of all joints to those of all rods, which have none in their
   place. */
PetscErrorCode JointsResidual(Joints joints, Rod all, PetscReal t, Vec U, Vec F) {
  const PetscScalar *u;
  PetscScalar *f;
  Seen seen;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(U, &u));
  PetscCall(VecGetArray(F, &f));
  for (PetscInt j = 0; j < JointsCount(joints); j++) {
    if (IsToCome(JointsGet(joints, j), all, t)) continue;
    See(JointsGet(joints, j), all, t, u, &seen);
    AddResidual(&seen, f + seen.own * FIELDS, f + seen.of * FIELDS);
  }
  PetscCall(VecRestoreArray(F, &f));
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscFunctionReturn(0);
}

/* The rows of a weld at a rod's beginning: p - p_P q. */
static void WeldSlope(const Seen *seen, JointBlock own, JointBlock of) {
  for (int j = 0; j < 4; j++) {
    const PetscReal unit[4] = {j == 0, j == 1, j == 2, j == 3};
    PetscReal carried[4], held[4];
    QuaternionTimes(seen->joint->from_carrier, unit, carried);
    QuaternionTimes(carried, seen->after, held);
    own[P + j][P + j] = 1;
    for (int k = 0; k < 4; k++) of[P + k][P + j] = -held[k];
  }
}

/* The rows of the rod's end by itself and by its carrier's node, and the carrier's rows by it. */
static void Slopes(const Seen *seen, JointBlock own, JointBlock of, JointBlock back) {
  const Joint *joint = seen->joint;
  const PetscReal sign = joint->tip ? -1 : 1;
  const int place = joint->tip ? N : X;

  for (int i = 0; i < 3; i++) {
    own[place + i][X + i] = seen->per_place;
    for (int k = 0; k < 3; k++) {
      of[place + i][X + k] = -seen->per_place * joint->to_carrier[k][i];
      back[M + i][M + k] = back[N + i][N + k] = sign * joint->to_carrier[i][k];
    }
  }
  if (joint->tip)
    TurnSlope(seen, own + M, of + M);
  else if (joint->kind == JOINT_WELD)
    WeldSlope(seen, own, of);
  else {
    for (int k = 0; k < 4; k++) own[P][P + k] = seen->u[P + k];
    TurnSlope(seen, own + P + 1, of + P + 1);
  }
}

/* JointsJacobian - adds their derivatives. */
PetscErrorCode JointsJacobian(Joints joints, Rod all, PetscReal t, Vec U, Mat J) {
  const PetscScalar *u;
  JointBlock block[3];
  Seen seen;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(U, &u));
  for (PetscInt j = 0; j < JointsCount(joints); j++) {
    if (IsToCome(JointsGet(joints, j), all, t)) continue;
    See(JointsGet(joints, j), all, t, u, &seen);
    PetscCall(PetscMemzero(block, sizeof(block)));
    Slopes(&seen, block[0], block[1], block[2]);
    PetscCall(MatSetValuesBlocked(J, 1, &seen.own, 1, &seen.own, block[0][0], ADD_VALUES));
    PetscCall(MatSetValuesBlocked(J, 1, &seen.own, 1, &seen.of, block[1][0], ADD_VALUES));
    PetscCall(MatSetValuesBlocked(J, 1, &seen.of, 1, &seen.own, block[2][0], ADD_VALUES));
  }
  PetscCall(VecRestoreArrayRead(U, &u));
  PetscFunctionReturn(0);
}

/* JointsCarry - where rod k begins in a state of all, u, and how, in its own frame, if another rod
   carries it: does one? */
PetscBool JointsCarry(Joints joints, PetscInt k, Rod all, PetscReal t, const PetscReal *u,
                      PetscReal x[3], PetscReal p[4]) {
  Seen seen;

  for (PetscInt j = 0; j < JointsCount(joints); j++) {
    const Joint *joint = JointsGet(joints, j);
    if (joint->rod != k || joint->tip) continue;
    See(joint, all, t, u, &seen);
    PlaceOf(&seen, x);
    memcpy(p, seen.held, sizeof(seen.held));
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* ---- how the rods begin ---- */

/* The quaternion of a turn. */
static void QuaternionOf(const PetscReal R[3][3], PetscReal p[4]) {
  const PetscReal square[4] = {1 + R[0][0] + R[1][1] + R[2][2], 1 + R[0][0] - R[1][1] - R[2][2],
                               1 - R[0][0] + R[1][1] - R[2][2], 1 - R[0][0] - R[1][1] + R[2][2]};
  int most = 0;

  for (int k = 1; k < 4; k++)
    if (square[k] > square[most]) most = k;
  const PetscReal f = PetscSqrtReal(square[most]) / 2;
  p[most] = f;
  if (most == 0) {
    p[1] = (R[2][1] - R[1][2]) / (4 * f);
    p[2] = (R[0][2] - R[2][0]) / (4 * f);
    p[3] = (R[1][0] - R[0][1]) / (4 * f);
    return;
  }
  const int i = most - 1, j = (i + 1) % 3, k = (i + 2) % 3;
  p[0] = (R[k][j] - R[j][k]) / (4 * f);
  p[1 + j] = (R[j][i] + R[i][j]) / (4 * f);
  p[1 + k] = (R[k][i] + R[i][k]) / (4 * f);
}

/* A basis whose first is the axis of a hinge, of length 1. */
static void BasisOf(const PetscReal axis[3], PetscReal basis[3][3]) {
  PetscReal other[3] = {0, 0, 0}, size;
  int least = 0;

  for (int k = 1; k < 3; k++)
    if (PetscAbsReal(axis[k]) < PetscAbsReal(axis[least])) least = k;
  other[least] = 1;
  memcpy(basis[0], axis, sizeof(basis[0]));
  Cross3(axis, other, basis[1]);
  size = PetscSqrtReal(Dot3(basis[1], basis[1]));
  for (int k = 0; k < 3; k++) basis[1][k] /= size;
  Cross3(basis[0], basis[1], basis[2]);
}

/* JointsRelate - how the rod of a joint is to its carrier from now on: as their nodes there, own
   and of the carrier, are. */
void JointsRelate(Joint *joint, const Rod each[], const PetscReal own[], const PetscReal of[]) {
  const Space *space = &each[joint->rod]->scene->space,
              *carrier = &each[joint->carrier]->scene->space;
  PetscReal back[3][3], carried[4], d[3][3], lab[3], axis[3] = {1, 0, 0};

  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      joint->to_carrier[i][j] = 0;
      for (int k = 0; k < 3; k++) joint->to_carrier[i][j] += carrier->lab[k][i] * space->lab[k][j];
      back[j][i] = joint->to_carrier[i][j];
    }
  QuaternionOf((const PetscReal(*)[3])back, joint->from_carrier);
  QuaternionTimes(joint->from_carrier, of + P, carried);
  QuaternionFrom(carried, own + P, joint->turn);
  QuaternionNormalise(joint->turn);
  memcpy(joint->x_P, of + X, sizeof(joint->x_P));
  ScenePlaceToLab(each[joint->carrier]->scene, of + X, lab);
  for (int k = 0; k < 3; k++) lab[k] -= space->place[k];
  SpaceFromLab(space, lab, joint->x); /* (a beginning is there; a tip but for round-off) */
  if (joint->kind == JOINT_HINGE) {
    Directors(own + P, QuaternionSize(own + P), d);
    SpaceFromLab(space, joint->across, lab);
    for (int k = 0; k < 3; k++) axis[k] = Dot3(d[k], lab);
  }
  BasisOf(axis, joint->basis);
}
