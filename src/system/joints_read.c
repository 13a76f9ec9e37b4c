/* Which rods hold which: read and checked, and where that is on their meshes. */
#include "rod/ask.h"
#include "rod/space_cells.h"
#include "system/joints.h"
#include <string.h>

struct _Joints {
  PetscInt rods, n;
  Joint *joint;    /* in order of their rods */
  PetscInt *order; /* of rods, each behind the one that it begins on */
};

/* ---- what is asked for ---- */

/* The options of one end. */
typedef struct {
  const char *on, *at;
} Words;
static const Words words[2] = {{"-clamp_on", "-clamp_at"}, {"-tip_on", "-tip_at"}};

static PetscErrorCode FindCarrier(Rods rods, const char *option, const char *name, PetscInt k,
                                  PetscInt *carrier) {
  char known[256] = "";
  size_t at = 0;

  PetscFunctionBegin;
  *carrier = -1;
  for (PetscInt i = 0; i < RodsCount(rods); i++) {
    if (!strcmp(RodsName(rods, i), name)) *carrier = i;
    if (at < sizeof(known) - ROD_NAME - 8)
      at += (size_t)snprintf(known + at, sizeof(known) - at, "%s%s", i ? ", " : "",
                             RodsName(rods, i));
  }
  UserCheck(*carrier >= 0, OptionsComm(), "%s %s: there is no rod of that name; there are %s",
            option, name, known);
  UserCheck(*carrier != k, OptionsComm(), "%s %s: a rod cannot hold itself; name another", option,
            name);
  PetscFunctionReturn(0);
}

/* The joint of one end of rod k, if it has one. */
static PetscErrorCode ReadEnd(Joints self, Rods rods, PetscInt k, PetscBool tip) {
  const Words *word = &words[tip];
  char name[PETSC_MAX_PATH_LEN] = "", at[PETSC_MAX_PATH_LEN] = "tip";
  PetscBool given, placed;
  Joint *joint;

  PetscFunctionBegin;
  PetscCall(OptionText(word->on, name, &given));
  PetscCall(OptionText(word->at, at, &placed));
  UserCheck(given || !placed, OptionsComm(),
            "%s: says where on a rod, and %s says on which; give it", word->at, word->on);
  if (!given) PetscFunctionReturn(0);
  joint = &self->joint[self->n++];
  *joint = (Joint){.rod = k, .tip = tip};
  PetscCall(FindCarrier(rods, word->on, name, k, &joint->carrier));
  PetscCall(PetscStrncpy(joint->at, at, sizeof(joint->at)));
  PetscFunctionReturn(0);
}

/* What a rod that another one carries cannot have as well. */
static PetscErrorCode CheckBeginning(void) {
  PetscBool given, turned;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-clamp_place", &given));
  UserCheck(!given, OptionsComm(),
            "-clamp_place: not with -clamp_on, which says where the rod begins; give one of them");
  PetscCall(OptionGiven("-clamp_direction", &given));
  PetscCall(OptionGiven("-clamp_azimuth", &turned));
  UserCheck(!(given && turned), OptionsComm(),
            "-clamp_azimuth: not with -clamp_direction, which says it all; give one of them");
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadRod(Joints self, Rods rods, PetscInt k) {
  const PetscInt before = self->n;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(ReadEnd(self, rods, k, PETSC_FALSE));
  if (self->n > before)
    PetscCall(CheckBeginning());
  else {
    PetscCall(OptionGiven("-clamp_azimuth", &given));
    UserCheck(!given, OptionsComm(),
              "-clamp_azimuth: is about the rod that carries this one; name it, -clamp_on");
  }
  PetscCall(ReadEnd(self, rods, k, PETSC_TRUE));
  PetscFunctionReturn(0);
}

/* What rod k begins on; -1: none. */
static PetscInt Carrier(const Joints self, PetscInt k) {
  for (PetscInt j = 0; j < self->n; j++)
    if (self->joint[j].rod == k && !self->joint[j].tip) return self->joint[j].carrier;
  return -1;
}

/* An order in which each rod comes behind the one that it begins on. */
static PetscErrorCode Sort(Joints self, Rods rods) {
  PetscBool *done;
  PetscInt n = 0, before = -1;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(self->rods, &done));
  while (n < self->rods && n > before) {
    before = n;
    for (PetscInt k = 0; k < self->rods; k++) {
      const PetscInt on = Carrier(self, k);
      if (done[k] || (on >= 0 && !done[on])) continue;
      done[k] = PETSC_TRUE;
      self->order[n++] = k;
    }
  }
  for (PetscInt k = 0; k < self->rods && n < self->rods; k++) {
    PetscInt on = k;
    for (PetscInt i = 0; i < self->rods && on >= 0; i++)
      on = Carrier(self, on) == k ? -1 : Carrier(self, on);
    if (done[k] || on >= 0) continue;
    PetscCall(RodsEnter(rods, k));
    UserCheck(PETSC_FALSE, OptionsComm(),
              "-clamp_on %s: that rod is carried by %s itself, in the end; let one of them begin "
              "elsewhere",
              RodsName(rods, Carrier(self, k)), RodsName(rods, k));
  }
  PetscCall(PetscFree(done));
  PetscFunctionReturn(0);
}

/* JointsRead - which rods hold which. The caller destroys them with JointsDestroy(), also after an
   error. */
PetscErrorCode JointsRead(Rods rods, Joints *joints) {
  Joints self;

  PetscFunctionBegin;
  PetscCall(PetscNew(joints));
  self = *joints;
  self->rods = RodsCount(rods);
  PetscCall(PetscCalloc2(2 * self->rods, &self->joint, self->rods, &self->order));
  for (PetscInt k = 0; k < self->rods; k++) {
    PetscCall(RodsEnter(rods, k));
    PetscCall(ReadRod(self, rods, k));
    PetscCall(RodsLeave(rods));
  }
  PetscCall(Sort(self, rods));
  PetscFunctionReturn(0);
}

PetscErrorCode JointsDestroy(Joints *joints) {
  PetscFunctionBegin;
  if (!*joints) PetscFunctionReturn(0);
  PetscCall(PetscFree2((*joints)->joint, (*joints)->order));
  PetscCall(PetscFree(*joints));
  PetscFunctionReturn(0);
}

PetscInt JointsCount(Joints self) {
  return self ? self->n : 0;
}

const Joint *JointsGet(Joints self, PetscInt j) {
  return &self->joint[j];
}

/* JointsOn - how many are on rod k. */
PetscInt JointsOn(Joints self, PetscInt k) {
  PetscInt n = 0;

  for (PetscInt j = 0; j < self->n; j++) n += self->joint[j].carrier == k;
  return n;
}

/* JointsNext - which rod is to be made i-th. */
PetscInt JointsNext(Joints self, PetscInt i) {
  return self->order[i];
}

/* ---- how it is held ---- */

static PetscErrorCode ReadAxis(PetscReal axis[3]) {
  PetscReal size;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(OptionVector("-clamp_axis", UNIT_NONE, axis, &given));
  if (!given) axis[2] = 1;
  size = PetscSqrtReal(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  UserCheck(size > 0, OptionsComm(), "-clamp_axis: has no length; give a direction, like 0,0,1");
  for (int d = 0; d < 3; d++) axis[d] /= size;
  PetscFunctionReturn(0);
}

/* What the carrier does for a clamp. */
static PetscErrorCode HoldBeginning(Joint *joint, Scene scene) {
  static const JointKind kinds[] = {
      [CLAMP_HELD] = JOINT_WELD, [CLAMP_HINGED] = JOINT_HINGE, [CLAMP_BALL] = JOINT_BALL};

  PetscFunctionBegin;
  UserCheck(scene->clamp != CLAMP_FREE, OptionsComm(),
            "-clamp_type free: not with -clamp_on, which says what holds the rod; leave one out");
  joint->kind = kinds[scene->clamp];
  if (joint->kind == JOINT_HINGE) PetscCall(ReadAxis(joint->across));
  UserCheck(joint->kind == JOINT_WELD || scene->space.spin == 0, OptionsComm(),
            "%s: turns a rod that is welded to its carrier, and this one gives way; give "
            "-clamp_type held, or leave it out",
            SpaceClampOption(&scene->space));
  UserCheck(joint->kind != JOINT_HINGE || scene->born == 0, OptionsComm(),
            "-clamp_type hinged: not of a rod that is born, for its axis is in the laboratory as "
            "rods begin; give held or ball");
  scene->clamp = joint->kind == JOINT_WELD ? CLAMP_CARRIED : CLAMP_SWINGS;
  PetscFunctionReturn(0);
}

/* ... for a tip: what acts on that from outside would act on nothing. */
static PetscErrorCode HoldTip(Joint *joint, Scene scene) {
  static const char *const loads[] = {"-tip_force", "-tip_force_vector", "-tip_torque",
                                      "-tip_path"};
  PetscBool given;

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(loads); k++) {
    PetscCall(OptionGiven(loads[k], &given));
    UserCheck(!given, OptionsComm(),
              "%s: not of a tip that another rod holds (-tip_on); give it to the tip of that rod",
              loads[k]);
  }
  UserCheck(scene->tip.type != TIP_SLIDES, OptionsComm(),
            "-tip_type slides: not of a tip that another rod holds; give clamped or pinned");
  joint->kind = scene->tip.type == TIP_PINNED ? JOINT_BALL : JOINT_WELD;
  scene->tip.type = TIP_CARRIED;
  PetscFunctionReturn(0);
}

/* Nothing keeps a rod from spinning about itself that is in balls, or free, at both ends. */
static PetscErrorCode CheckSpin(const Joint *begins, PetscBool points, Scene scene) {
  PetscFunctionBegin;
  UserCheck(!begins || begins->kind != JOINT_BALL || points || scene->load.radius > 0,
            OptionsComm(),
            "-clamp_type ball: nothing keeps the rod from spinning about itself; give it a "
            "-friction_radius, or a tip that is clamped");
  PetscFunctionReturn(0);
}

/* JointsHold - tells the scene of rod k that others hold it. */
PetscErrorCode JointsHold(Joints self, PetscInt k, Scene scene) {
  const Joint *begins = NULL;
  PetscBool points = TipPoints(&scene->tip);

  PetscFunctionBegin;
  for (PetscInt j = 0; j < self->n; j++) {
    Joint *joint = &self->joint[j];
    if (joint->rod != k) continue;
    PetscCall((joint->tip ? HoldTip : HoldBeginning)(joint, scene));
    if (!joint->tip) begins = joint;
    if (joint->tip) points = (PetscBool)(joint->kind == JOINT_WELD);
  }
  PetscCall(CheckSpin(begins, points, scene));
  PetscFunctionReturn(0);
}

/* ---- where it is ---- */

/* The nodes of a joint, in the states that the rods begin in: of the rod's own end, if that is
   there already, and of the carrier. */
static PetscErrorCode NodesOf(const Joint *joint, const Rod each[], PetscReal own[FIELDS],
                              PetscReal of[FIELDS]) {
  const PetscScalar *u;
  Vec U;

  PetscFunctionBegin;
  for (int end = 0; end < 2; end++) {
    const Rod rod = each[end ? joint->carrier : joint->rod];
    const PetscInt node = end ? joint->node : joint->tip && rod ? rod->last : 0;
    if (!rod) continue;
    PetscCall(DMGetGlobalVector(rod->da, &U));
    PetscCall(RodBegin(rod, U));
    PetscCall(VecGetArrayRead(U, &u));
    PetscCall(PetscArraycpy(end ? of : own, u + node * FIELDS, FIELDS));
    PetscCall(VecRestoreArrayRead(U, &u));
    PetscCall(DMRestoreGlobalVector(rod->da, &U));
  }
  PetscFunctionReturn(0);
}

/* JointsSeat - where rod k begins, if another one carries it, which is there. */
PetscErrorCode JointsSeat(Joints self, PetscInt k, const Rod each[], Seat *seat,
                          PetscBool *carried) {
  PetscReal own[FIELDS], of[FIELDS], d[3][3], lab[3];

  PetscFunctionBegin;
  *carried = PETSC_FALSE;
  for (PetscInt j = 0; j < self->n; j++) {
    const Joint *joint = &self->joint[j];
    const Scene scene = each[joint->carrier] ? each[joint->carrier]->scene : NULL;
    if (joint->rod != k || joint->tip) continue;
    *carried = PETSC_TRUE;
    PetscCall(NodesOf(joint, each, own, of));
    ScenePlaceToLab(scene, of + X, seat->place);
    Directors(of + P, QuaternionSize(of + P), d);
    for (int i = 0; i < 3; i++) {
      SceneToLab(scene, d[i], lab);
      for (int r = 0; r < 3; r++) seat->frame[r][i] = lab[r];
    }
  }
  PetscFunctionReturn(0);
}

/* The label of the material that is so far from the beginning at a time. */
static PetscErrorCode LabelAt(Scene scene, PetscReal distance, PetscReal t, PetscReal *label) {
  PetscReal low = 0, high = 1, p;

  PetscFunctionBegin;
  for (int i = 0; i < 60 && high > low; i++) {
    *label = (low + high) / 2;
    PetscCall(GrowthArc(scene->growth, 1, label, t, &p, NULL));
    if (p > distance)
      high = *label;
    else
      low = *label;
  }
  *label = (low + high) / 2;
  PetscFunctionReturn(0);
}

/* When the rod of a joint is born, of whose options the reading is now; its carrier is there then.
 */
static PetscErrorCode ReadBirth(const Joint *joint, const char *carrier, Scene scene,
                                PetscReal *born) {
  PetscBool given;
  char text[2][64];

  PetscFunctionBegin;
  PetscCall(OptionReal("-born", born, NULL));
  PetscCall(OptionGiven("-clamp_direction", &given));
  UserCheck(*born == 0 || !given, OptionsComm(),
            "-clamp_direction: not of a rod that is born, for its carrier turns till then; give "
            "-clamp_angle and -clamp_azimuth");
  UserCheck(!joint->tip || (*born == 0 && scene->born == 0), OptionsComm(),
            "-born: not where a tip is held (-tip_on): rod and carrier are there from the start; "
            "leave one out");
  UserCheck(*born >= scene->born, OptionsComm(),
            "-born %s: rod %s, which carries it, is born at %s; give a later time",
            OptionBoth(*born, UNIT_TIME, text[0]), carrier,
            OptionBoth(scene->born, UNIT_TIME, text[1]));
  PetscFunctionReturn(0);
}

/* Refuses a place of a carrier that grows at its tip which is in the growth zone. */
static PetscErrorCode CheckBehindZone(const Joint *joint, const char *carrier, Scene scene,
                                      PetscReal born, PetscReal distance) {
  const PetscReal rests = GrowthRests(scene->growth, distance);
  PetscReal length, rate;
  char text[2][64];

  PetscFunctionBegin;
  PetscCall(GrowthLength(scene->growth, born, &length, &rate));
  UserCheck(length >= rests * (1 - 1e-12), OptionsComm(),
            "%s %s: is in the growth zone of rod %s then, where material stretches; give a place "
            "nearer its base, or -born %s, when it is %s long",
            words[joint->tip].at, joint->at, carrier,
            OptionBoth(born + (rests - length) / rate, UNIT_TIME, text[0]),
            OptionBoth(rests, UNIT_LENGTH, text[1]));
  PetscFunctionReturn(0);
}

/* Refuses a place of a carrier that is fed in which is not in from the start to the end. */
static PetscErrorCode CheckIn(const Joint *joint, const char *carrier, Scene scene) {
  const Growth growth = scene->growth;
  const PetscReal slack = 1e-6;
  PetscReal length, t = 0;
  char text[64];

  PetscFunctionBegin;
  while (t < PETSC_MAX_REAL) {
    PetscCall(GrowthLength(growth, t, &length, NULL));
    UserCheck(length * (1 - slack) > joint->along, OptionsComm(),
              "%s %s: that place of rod %s, which is fed, is not in at t = %s; give one nearer its "
              "tip",
              words[joint->tip].at, joint->at, carrier, OptionBoth(t, UNIT_TIME, text));
    if (t >= scene->end_time) break;
    t = growth->next_turn ? PetscMin(growth->next_turn(growth, t), scene->end_time)
                          : scene->end_time;
  }
  PetscFunctionReturn(0);
}

/* Where the material of a carrier slides along it, a joint goes with it: how that is told. */
static PetscErrorCode FindSliding(Joint *joint, const char *carrier, Scene scene, PetscReal born,
                                  PetscReal distance) {
  PetscReal length;

  PetscFunctionBegin;
  joint->follows = PETSC_TRUE;
  joint->along = distance;
  if (scene->growth->rests) {
    PetscCall(CheckBehindZone(joint, carrier, scene, born, distance));
    PetscFunctionReturn(0);
  }
  PetscCall(GrowthLength(scene->growth, born, &length, NULL));
  joint->along = length - distance;
  PetscCall(CheckIn(joint, carrier, scene));
  PetscFunctionReturn(0);
}

/* A joint's place on its carrier, whose scene is here. */
static PetscErrorCode FindPlace(Joint *joint, const char *carrier, Scene scene) {
  const char *const option = words[joint->tip].at;
  PetscReal distance = 0, length, born = 0;
  char text[64];

  PetscFunctionBegin;
  PetscCall(ReadBirth(joint, carrier, scene, &born));
  joint->label = 1;
  if (!strcmp(joint->at, "tip")) PetscFunctionReturn(0);
  if (strcmp(joint->at, "base") != 0)
    PetscCall(OptionQuantity(option, joint->at, UNIT_LENGTH, &distance));
  PetscCall(GrowthLength(scene->growth, born, &length, NULL));
  UserCheck(distance >= 0 && distance <= length * (1 + 1e-12), OptionsComm(),
            "%s %s: rod %s is %s long %s; give a place on it, or base or tip", option, joint->at,
            carrier, OptionBoth(length, UNIT_LENGTH, text), born > 0 ? "then" : "as it begins");
  if (distance >= length * (1 - 1e-12)) PetscFunctionReturn(0);
  joint->label = 0;
  if (scene->growth->slides && (distance > 0 || !scene->growth->rests))
    PetscCall(FindSliding(joint, carrier, scene, born, distance));
  else if (distance > 0)
    PetscCall(LabelAt(scene, distance, born, &joint->label));
  PetscFunctionReturn(0);
}

/* The labels of carrier k go with the material where others are joined to it and that slides.
   placed: those of its nodes do so already. */
static PetscErrorCode FollowMaterial(const Joints self, PetscInt k, PetscBool placed, Scene scene) {
  const PetscBool upwards = scene->growth->rests;
  PetscReal *along, *label;
  PetscInt n = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(self->n, &along, self->n, &label));
  for (PetscInt j = 0; j < self->n; j++)
    if (self->joint[j].carrier == k && self->joint[j].follows) along[n++] = self->joint[j].along;
  PetscCall(PetscSortRemoveDupsReal(&n, along));
  for (PetscInt i = 0; i < n / 2 && !upwards; i++) {
    const PetscReal other = along[i];
    along[i] = along[n - 1 - i];
    along[n - 1 - i] = other;
  }
  if (n > 0)
    PetscCall(GrowthFollow(scene->growth, n, along, scene->end_time,
                           placed ? 0 : scene->mesh.cells + 1, scene->mesh.s, label));
  for (PetscInt j = 0; j < self->n; j++)
    for (PetscInt i = 0; i < n; i++)
      if (self->joint[j].carrier == k && self->joint[j].follows && self->joint[j].along == along[i])
        self->joint[j].label = label[i];
  PetscCall(PetscFree2(along, label));
  PetscFunctionReturn(0);
}

/* The joints on carrier k, from its beginning to its tip. */
static PetscInt Along(const Joints self, PetscInt k, Joint *on[]) {
  PetscInt n = 0;

  for (PetscInt j = 0; j < self->n; j++) {
    PetscInt i = n;
    if (self->joint[j].carrier != k) continue;
    for (; i > 0 && on[i - 1]->label > self->joint[j].label; i--) on[i] = on[i - 1];
    on[i] = &self->joint[j];
    n++;
  }
  return n;
}

/*
  JointsDouble - the scene of rod k gets a double node wherever another one is joined to it, before
  the rod is made. What other rods are said to have is refused as theirs.

  placed  the mesh has them already
*/
PetscErrorCode JointsDouble(Joints self, Rods rods, PetscInt k, PetscBool placed, Scene scene) {
  Joint **on;
  PetscInt n;

  PetscFunctionBegin;
  for (PetscInt j = 0; j < self->n; j++) {
    if (self->joint[j].carrier != k) continue;
    PetscCall(RodsEnter(rods, self->joint[j].rod));
    PetscCall(OptionsSetScales(scene->si.scale)); /* of all; the rod's own scene is still to come */
    PetscCall(FindPlace(&self->joint[j], RodsName(rods, k), scene));
    PetscCall(RodsLeave(rods));
  }
  PetscCall(FollowMaterial(self, k, placed, scene));
  PetscCall(PetscMalloc1(self->n, &on));
  n = Along(self, k, on);
  for (PetscInt i = 0; i < n; i++) {
    if (placed && i && on[i]->label == on[i - 1]->label)
      on[i]->node = on[i - 1]->node;
    else if (placed)
      PetscCall(MeshNextDouble(&scene->mesh, i ? on[i - 1]->node + 2 : 0, &on[i]->node));
    else
      PetscCall(MeshDouble(&scene->mesh, on[i]->label, &on[i]->node));
  }
  PetscCall(PetscFree(on));
  PetscFunctionReturn(0);
}

/* Refuses a tip that is not where it is to be held. */
static PetscErrorCode CheckMeets(const Joint *joint, const char *carrier, const Rod each[],
                                 const PetscReal own[], const PetscReal of[]) {
  const PetscReal near = 1e-5;
  PetscReal x[2][3], apart = 0, length;
  char text[2][96];

  PetscFunctionBegin;
  ScenePlaceToLab(each[joint->rod]->scene, own + X, x[0]);
  ScenePlaceToLab(each[joint->carrier]->scene, of + X, x[1]);
  for (int d = 0; d < 3; d++) apart += PetscSqr(x[0][d] - x[1][d]);
  apart = PetscSqrtReal(apart);
  PetscCall(RodLength(each[joint->rod], 0, &length));
  UserCheck(apart <= near * length, OptionsComm(),
            "-tip_on %s: as the rods begin the tip is at %s, and that place at %s, %g apart; let "
            "them meet, to %g of the rod's length",
            carrier, OptionPlace(x[0], text[0]), OptionPlace(x[1], text[1]), (double)apart, near);
  PetscFunctionReturn(0);
}

/* Refuses two tips each of which is said to hold the other: that is one joint. */
static PetscErrorCode CheckOnce(const Joints self, PetscInt j, const char *carrier) {
  const Joint *joint = &self->joint[j];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < j; i++) {
    const Joint *other = &self->joint[i];
    const PetscBool mutual =
        (PetscBool)(other->rod == joint->carrier && other->carrier == joint->rod);
    UserCheck(!(mutual && joint->tip && other->tip && joint->label == 1 && other->label == 1),
              OptionsComm(),
              "-tip_on %s: the tip of rod %s is held by this one already; leave one of them out",
              carrier, carrier);
  }
  PetscFunctionReturn(0);
}

/* JointsClose - all rods are there: they are joined as they begin. */
PetscErrorCode JointsClose(Joints self, Rods rods, const Rod each[]) {
  PetscReal own[FIELDS], of[FIELDS];

  PetscFunctionBegin;
  for (PetscInt j = 0; j < self->n; j++) {
    Joint *joint = &self->joint[j];
    PetscCall(NodesOf(joint, each, own, of));
    PetscCall(RodsEnter(rods, joint->rod));
    PetscCall(CheckOnce(self, j, RodsName(rods, joint->carrier)));
    if (joint->tip) PetscCall(CheckMeets(joint, RodsName(rods, joint->carrier), each, own, of));
    PetscCall(RodsLeave(rods));
    JointsRelate(joint, each, own, of);
  }
  PetscFunctionReturn(0);
}
