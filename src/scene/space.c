#include "scene/space.h"

static const OptionRow rows[] = {
    ROW_TEXT("-rod_weight", 0,
             "a,b,c: weight per length, over that of friction, a vector in the laboratory (a,b in "
             "the plane); of a rod in the laboratory also with units, 0,0,-0.12N/m or 0,0,-12g/m"),
    ROW_REAL("-rod_torsion", "0.75", 1e-6, 1e6, UNIT_NONE, 0,
             "C/B, torsional over bending stiffness about d2: 1/(1 + nu) of a round rod"),
    ROW_REAL("-rod_bend_ratio", "1", 1e-6, 1e6, UNIT_NONE, 0,
             "B3/B2, bending stiffness about d3 over that about d2"),
    ROW_REAL("-friction_radius", "0", 0, 1e6, UNIT_LENGTH, 0,
             "radius at which friction feels that the rod spins about its tangent; 0: it does not"),
    ROW_TEXT("-tip_force_vector", 0,
             "a,b,c: dead force on the tip, a vector in the laboratory, beside -tip_force"),
    ROW_REAL("-tip_torque", "0", -1e9, 1e9, UNIT_ENERGY, 0,
             "moment about d1 of the tip, that turns with it"),
    ROW_REAL(
        "-clamp_spin", "0", -1e6, 1e6, UNIT_ANGLE, 0,
        "rate at which the clamp turns about d1, radians (or degrees: 90deg) per unit of time"),
    ROW_TEXT("-clamp_path", INPUT_FILE,
             "CSV or HDF5 file with t and spin, the rate at which the clamp turns about d1 over "
             "time, or t and turn, by how much it has turned, instead of -clamp_spin"),
    ROW_TEXT("-clamp_direction", 0,
             "a,b,c: direction of d1 at the clamp in the laboratory, instead of -clamp_angle"),
    ROW_TEXT("-clamp_place", 0,
             "x,y,z: where the clamp is in the laboratory, among walls, fields and lamps; 0 unless "
             "given"),
    ROW_TEXT("-clamp_on", 0,
             "NAME of the rod that carries this one, of several (docs/several-rods.md)"),
    ROW_TEXT("-clamp_at", 0,
             "where: how far along that rod from its beginning, as it begins, or base or tip"),
    ROW_REAL("-clamp_azimuth", "0", -1e6, 1e6, UNIT_ANGLE, 0,
             "about the tangent of the rod that carries it, from d2, to the side to which "
             "-clamp_angle, from that tangent, turns it"),
    ROW_TEXT(
        "-clamp_axis", 0,
        "a,b,c: axis of the hinge on the rod that carries it, in the laboratory as they begin; "
        "0,0,1 unless given"),
    ROW_TEXT("-tip_on", 0,
             "NAME of the rod that holds this one's tip, which is there as it begins"),
    ROW_TEXT("-tip_at", 0, "where on that rod, as -clamp_at")};
const OptionGroup space_options = OPTION_GROUP_OF_ROD("Space", rows);

/* The smallest rotation that takes e1 to the direction d, of length 1; half a turn about e3 before
   it, to -e1, if d is all but that. */
static void SmallestTurn(const PetscReal d[3], PetscReal R[3][3]) {
  const PetscReal across = d[1] * d[1] + d[2] * d[2],
                  c = d[0] > 0 ? 1 + d[0] : across / (1 - d[0]); /* 1 + d[0] less its round-off */

  if (c < 1e-12) {
    const PetscReal half[3] = {-d[0], -d[1], d[2]};
    SmallestTurn(half, R);
    for (int i = 0; i < 2; i++)
      for (int j = 0; j < 3; j++) R[i][j] = -R[i][j];
    return;
  }
  for (int i = 0; i < 3; i++) R[i][0] = d[i];
  R[0][1] = -d[1];
  R[0][2] = -d[2];
  R[1][1] = 1 - d[1] * d[1] / c;
  R[1][2] = R[2][1] = -d[1] * d[2] / c;
  R[2][2] = 1 - d[2] * d[2] / c;
}

/* A rod that another one carries begins at an angle against its tangent, to one side. */
static PetscErrorCode Seated(const Seat *seat, PetscReal angle, Space *self) {
  PetscReal azimuth;

  PetscFunctionBegin;
  PetscCall(OptionReal("-clamp_azimuth", &azimuth, NULL));
  const PetscReal c = PetscCosReal(angle), s = PetscSinReal(angle), ca = PetscCosReal(azimuth),
                  sa = PetscSinReal(azimuth);
  const PetscReal turn[3][3] = {{c, -s, 0}, {s * ca, c * ca, -sa}, {s * sa, c * sa, ca}};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      self->lab[i][j] = 0;
      for (int k = 0; k < 3; k++) self->lab[i][j] += seat->frame[i][k] * turn[k][j];
    }
  PetscFunctionReturn(0);
}

/*
  SpaceClampDirection - reads -clamp_direction. Collective.

  seat   of the rod that carries it; NULL: none does
  angle  of the clamp in the plane, from -clamp_angle on entry; that of the direction on exit, if it
         is in the plane
*/
PetscErrorCode SpaceClampDirection(const Seat *seat, PetscReal *angle, Space *self) {
  PetscReal d[3], length;
  PetscBool direction, turned;

  PetscFunctionBegin;
  PetscCall(OptionVector("-clamp_direction", UNIT_NONE, d, &direction));
  PetscCall(OptionGiven("-clamp_angle", &turned));
  UserCheck(!direction || !turned, OptionsComm(),
            "-clamp_angle and -clamp_direction: give one of them");
  if (seat) PetscCall(PetscArraycpy(self->place, seat->place, 3));
  if (seat && !direction) {
    PetscCall(Seated(seat, *angle, self));
    *angle = 0;
    PetscFunctionReturn(0);
  }
  length = PetscSqrtReal(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  UserCheck(!direction || length > 0, OptionsComm(),
            "-clamp_direction: has no length; give a direction, like 1,0,0");
  if (direction && d[2] != 0) {
    self->why = "-clamp_direction";
    for (int k = 0; k < 3; k++) d[k] /= length;
  } else {
    if (direction) *angle = atan2(d[1], d[0]);
    d[0] = PetscCosReal(*angle);
    d[1] = PetscSinReal(*angle);
    d[2] = 0;
  }
  SmallestTurn(d, self->lab);
  if (d[2] == 0) { /* in the plane: the turn about e3 itself */
    self->lab[1][1] = d[0];
    self->lab[2][2] = 1;
  }
  PetscFunctionReturn(0);
}

/* SpaceFromLab - a vector of the laboratory in the clamp's frame. */
void SpaceFromLab(const Space *self, const PetscReal lab[3], PetscReal v[3]) {
  for (int d = 0; d < 3; d++)
    v[d] = self->lab[0][d] * lab[0] + self->lab[1][d] * lab[1] + self->lab[2][d] * lab[2];
}

/* SpaceToLab - a vector of the clamp's frame in the laboratory. */
void SpaceToLab(const Space *self, const PetscReal v[3], PetscReal lab[3]) {
  for (int d = 0; d < 3; d++)
    lab[d] = self->lab[d][0] * v[0] + self->lab[d][1] * v[1] + self->lab[d][2] * v[2];
}

/* SpaceClampAngle - by how much the clamp has turned about d1 at time t. */
PetscReal SpaceClampAngle(const Space *self, PetscReal t) {
  return self->clamp_path ? ScheduleValue(self->clamp_path, t)
                          : self->spun + self->spin * (t - self->spins_from);
}

/* SpaceClampRate - how fast it turns then. */
PetscReal SpaceClampRate(const Space *self, PetscReal t) {
  return self->clamp_path ? ScheduleRate(self->clamp_path, t) : self->spin;
}

/* SpaceClampOption - the option by which it turns. */
const char *SpaceClampOption(const Space *self) {
  return self->clamp_path ? "-clamp_path" : "-clamp_spin";
}

/* SpaceClampTurn - the quaternion of the clamp at time t, in its own frame at the start. */
void SpaceClampTurn(const Space *self, PetscReal t, PetscReal p[4]) {
  const PetscReal turn = SpaceClampAngle(self, t);

  p[0] = PetscCosReal(turn / 2);
  p[1] = PetscSinReal(turn / 2);
  p[2] = p[3] = 0;
}

/* What a path of the tip drives across and about the axis. */
static void DrivenByPath(Space *self, Path path) {
  PetscReal turned = PathRange(path, PATH_FRAME + 1) + PathRange(path, PATH_FRAME + 2) +
                     PathRange(path, PATH_FRAME + 3);

  self->moved[1] = PathRange(path, PATH_X2);
  self->moved[2] = PathRange(path, PATH_X3);
  self->turned[1] = PathRange(path, PATH_ANGLE) + turned;
  self->turned[2] = turned;
  self->turned[3] = PathRange(path, PATH_TURN) + turned;
}

/* Where it is. A path of the tip, and changes of its place, are told from the clamp. */
static PetscErrorCode ClampPlace(Space *self, const Tip *tip) {
  PetscReal place[3];
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(OptionVector("-clamp_place", UNIT_LENGTH, place, &given));
  if (!given) PetscFunctionReturn(0);
  PetscCall(PetscArraycpy(self->place, place, 3));
  UserCheck(!tip->path, OptionsComm(),
            "-clamp_place: not with -tip_path, which is given from a clamp at 0; leave one out");
  if (self->place[0] != 0 || self->place[1] != 0 || self->place[2] != 0) self->why = "-clamp_place";
  PetscFunctionReturn(0);
}

/* How the clamp turns: at a rate, or over time. */
static PetscErrorCode ClampTurns(Space *self) {
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool rate, path;

  PetscFunctionBegin;
  PetscCall(OptionReal("-clamp_spin", &self->spin, &rate));
  PetscCall(OptionText("-clamp_path", file, &path));
  if (!path) PetscFunctionReturn(0);
  UserCheck(!rate, OptionsComm(), "-clamp_spin and -clamp_path: give one of them");
  PetscCall(ScheduleRead("-clamp_path", file, "a clamp", &self->clamp_path));
  self->spin = ScheduleFastest(self->clamp_path);
  PetscFunctionReturn(0);
}

/*
  SpaceSetFromOptions - reads and checks what there is in space only, and tells load and tip of it;
  after SpaceClampDirection() and after these have their options. Collective; the caller ends it
  with SpaceRelease(), also after an error.
*/
PetscErrorCode SpaceSetFromOptions(Space *self, Load *load, Tip *tip, const Curvature *curvature,
                                   const Shape *shape) {
  PetscReal weight[3], force[3], clamp[3];
  PetscBool given, torsion, radius;

  PetscFunctionBegin;
  PetscCall(OptionVector("-rod_weight", UNIT_LOAD, weight, &given));
  PetscCall(OptionVector("-tip_force_vector", UNIT_FORCE, force, &given));
  PetscCall(OptionReal("-rod_torsion", &self->torsion, &torsion));
  PetscCall(OptionReal("-rod_bend_ratio", &self->ratio, NULL));
  PetscCall(OptionReal("-friction_radius", &load->radius, &radius));
  PetscCall(OptionReal("-tip_torque", &tip->torque, NULL));
  PetscCall(ClampTurns(self));
  PetscCall(ClampPlace(self, tip));
  if (weight[2] != 0) self->why = "-rod_weight";
  if (force[2] != 0) self->why = "-tip_force_vector";
  if (self->ratio != 1) self->why = "-rod_bend_ratio";
  if (tip->torque != 0) self->why = "-tip_torque";
  if (self->spin != 0) self->why = SpaceClampOption(self);
  if (LoadInSpace(load)) self->why = "-friction_field";
  if (LoadInSpace(&tip->resistance)) self->why = "-tip_field";
  if (curvature->space) self->why = "-rod_curvature_2 or -rod_twist";
  if (shape->turn != 0) self->why = "-shape_turn";
  if (shape->space) self->why = "-shape_file";
  if (tip->path && PathInSpace(tip->path)) self->why = "-tip_path";
  if (torsion) self->only = "-rod_torsion";
  if (radius && load->radius > 0) self->only = "-friction_radius";
  SpaceFromLab(self, weight, clamp);
  LoadSetWeight(load, clamp);
  SpaceFromLab(self, force, tip->push);
  if (tip->path) DrivenByPath(self, tip->path);
  if (tip->walls && tip->walls->surfaces.n) self->why = "-wall_file";
  LoadSetArm(load);
  for (int d = 0; d < 3; d++) PetscCall(PetscArraycpy(load->lab[d], self->lab[d], 3));
  for (int d = 0; d < 3; d++) PetscCall(PetscArraycpy(tip->resistance.lab[d], self->lab[d], 3));
  PetscCall(PetscArraycpy(load->place, self->place, 3));
  PetscCall(PetscArraycpy(tip->resistance.place, self->place, 3));
  PetscFunctionReturn(0);
}

/* What acts out of the plane cannot begin in a run that is in it. */
static PetscErrorCode CheckPlane(const Space *self, const char *name, PetscBool leaves) {
  PetscFunctionBegin;
  UserCheck(self->rod || !leaves, OptionsComm(),
            "%s: takes the rod out of the plane, in which this run is; begin it with -rod_model "
            "space",
            name);
  PetscFunctionReturn(0);
}

/* SpaceChangeSpin - the clamp turns on at the rate that -clamp_spin has by now, from t on. */
PetscErrorCode SpaceChangeSpin(Space *self, PetscReal t) {
  PetscReal spin;

  PetscFunctionBegin;
  PetscCall(OptionReal("-clamp_spin", &spin, NULL));
  PetscCall(CheckPlane(self, "-clamp_spin", (PetscBool)(spin != 0)));
  self->spun = SpaceClampAngle(self, t);
  self->spins_from = t;
  self->spin = spin;
  PetscFunctionReturn(0);
}

/* SpaceChangeTorque - the moment on the tip is what -tip_torque has by now. */
PetscErrorCode SpaceChangeTorque(Space *self, Tip *tip) {
  PetscReal torque;

  PetscFunctionBegin;
  PetscCall(OptionReal("-tip_torque", &torque, NULL));
  PetscCall(CheckPlane(self, "-tip_torque", (PetscBool)(torque != 0)));
  tip->torque = torque;
  PetscFunctionReturn(0);
}

/* A vector option's new value, in the clamp's frame. */
static PetscErrorCode NewVector(const Space *self, const char *name, Dimension dimension,
                                PetscReal v[3]) {
  PetscReal lab[3];
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(OptionVector(name, dimension, lab, &given));
  PetscCall(CheckPlane(self, name, (PetscBool)(lab[2] != 0)));
  SpaceFromLab(self, lab, v);
  PetscFunctionReturn(0);
}

/* SpaceChangePush - the dead force on the tip is what -tip_force_vector has by now. */
PetscErrorCode SpaceChangePush(Space *self, Tip *tip) {
  PetscFunctionBegin;
  PetscCall(NewVector(self, "-tip_force_vector", UNIT_FORCE, tip->push));
  PetscFunctionReturn(0);
}

/* SpaceChangeWeight - the weight is what -rod_weight has by now. */
PetscErrorCode SpaceChangeWeight(Space *self, Load *load) {
  PetscReal v[3];

  PetscFunctionBegin;
  PetscCall(NewVector(self, "-rod_weight", UNIT_LOAD, v));
  LoadSetWeight(load, v);
  PetscFunctionReturn(0);
}

PetscErrorCode SpaceRelease(Space *self) {
  PetscFunctionBegin;
  PetscCall(ScheduleDestroy(&self->clamp_path));
  PetscFunctionReturn(0);
}
