/*
  The law. With k what the material has learned, u0 = given + k, and u the bend that it has,

    Dk/Dt = a (f - G u + I (u - u0) + nutation),   D/Dt = d/dt + (c/g) d/ds,   k = 0 at first,

  a the strain rate of growth, or -tropism_rate. Sensed is S = b d1 x dir + b_l d1 x (source - x) /
  |source - x|, its components along d3 and d2; f = S, or with memory T Df/Dt = S - f, f = 0 at
  first. Sensed at the tip, its components there act along the axes of every place.
*/
#include "material/tropism.h"

static const OptionRow rows[] = {
    ROW_REAL("-tropism_gravity", "0", -1e6, 1e6, UNIT_CURVATURE, 0,
             "b, how strongly growth bends towards -tropism_direction: per length and growth "
             "strain"),
    ROW_TEXT("-tropism_direction", 0,
             "a,b,c: where gravity pulls growth to, a vector in the laboratory (a,b in the plane): "
             "down of roots, up of shoots"),
    ROW_REAL("-tropism_light", "0", -1e6, 1e6, UNIT_CURVATURE, 0,
             "how strongly growth bends towards a lamp at -tropism_source: per length and growth "
             "strain"),
    ROW_TEXT("-tropism_source", 0, "a,b,c: the place of the lamp in the laboratory"),
    ROW_REAL("-tropism_proprioception", "0", 0, 1e6, UNIT_NONE, 0,
             "G, how strongly growth straightens what is bent: per growth strain"),
    ROW_WORD("-tropism_sensed", "local", "local,tip", 0,
             "where gravity and light are sensed: in each place, or at the tip for all of the rod"),
    ROW_REAL("-tropism_memory", "0", 0, 1e6, UNIT_TIME, 0,
             "T, time over which what is sensed is averaged; 0: it acts at once"),
    ROW_REAL("-tropism_nutation", "0", -1e6, 1e6, UNIT_CURVATURE, 0,
             "n, of the bend in the plane that growth itself adds, n cos(rate t): per length and "
             "growth strain"),
    ROW_REAL("-tropism_nutation_2", "0", -1e6, 1e6, UNIT_CURVATURE, 0,
             "n2, of that out of the plane, -n2 sin(rate t)"),
    ROW_REAL("-tropism_nutation_rate", "0", -1e6, 1e6, UNIT_RATE, 0,
             "radians per unit of time by which nutation goes round; its sign is the handedness"),
    ROW_REAL("-tropism_rate", "", 0, 1e6, UNIT_RATE, 0,
             "r, per unit of time, in place of the strain rate of growth: of a rod that bends by "
             "itself without growing"),
    ROW_REAL("-growth_ironing", "0", 0, 1e6, UNIT_NONE, 0,
             "I, how strongly growth gives way to bending moments, whose bend the material keeps: "
             "per growth strain; 20 to 500 in plants")};
const OptionGroup tropism_options = OPTION_GROUP_OF_ROD("Tropism", rows);

/* A vector that has to be given where its strength is not 0. */
static PetscErrorCode Towards(const char *strength, const char *name, Dimension dimension,
                              PetscReal v[3]) {
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(OptionVector(name, dimension, v, &given));
  UserCheck(given, OptionsComm(), "%s: needs %s a,b,c (a,b in the plane)", strength, name);
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadSenses(Tropism *self) {
  PetscInt sensed;
  PetscReal length;

  PetscFunctionBegin;
  if (self->gravity != 0) {
    PetscReal *d = self->direction;
    PetscCall(Towards("-tropism_gravity", "-tropism_direction", UNIT_NONE, d));
    length = PetscSqrtReal(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    UserCheck(length > 0, OptionsComm(),
              "-tropism_direction: has no length; give a direction, like 0,-1");
    for (int k = 0; k < 3; k++) d[k] /= length;
    if (d[2] != 0) self->why = "-tropism_direction";
  }
  if (self->light != 0) {
    PetscCall(Towards("-tropism_light", "-tropism_source", UNIT_LENGTH, self->source));
    if (self->source[2] != 0) self->why = "-tropism_source";
  }
  self->senses = (PetscBool)(self->gravity != 0 || self->light != 0);
  if (!self->senses) PetscFunctionReturn(0);
  PetscCall(OptionWord("-tropism_sensed", &sensed, NULL));
  self->at_tip = (PetscBool)(sensed == 1);
  PetscCall(OptionReal("-tropism_memory", &self->memory, NULL));
  PetscFunctionReturn(0);
}

/*
  TropismSetFromOptions - reads and checks the law, whose vectors are in the laboratory's frame
  until TropismFrame(). Collective on OptionsComm().
*/
PetscErrorCode TropismSetFromOptions(Tropism *self, Growth growth) {
  PetscBool nutates;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  PetscCall(OptionReal("-tropism_gravity", &self->gravity, NULL));
  PetscCall(OptionReal("-tropism_light", &self->light, NULL));
  PetscCall(OptionReal("-tropism_proprioception", &self->proprioception, NULL));
  PetscCall(OptionReal("-tropism_nutation", &self->nutation[0], NULL));
  PetscCall(OptionReal("-tropism_nutation_2", &self->nutation[1], NULL));
  PetscCall(OptionReal("-growth_ironing", &self->ironing, NULL));
  PetscCall(ReadSenses(self));
  nutates = (PetscBool)(self->nutation[0] != 0 || self->nutation[1] != 0);
  self->any = TropismLearns(self);
  if (!self->any) PetscFunctionReturn(0);
  if (nutates) PetscCall(OptionReal("-tropism_nutation_rate", &self->nutation_rate, NULL));
  if (self->nutation[1] != 0) self->why = "-tropism_nutation_2";
  PetscCall(OptionReal("-tropism_rate", &self->rate, &self->by_rate));
  UserCheck(self->by_rate || !(growth->still || !strcmp(growth->type, "feed")), OptionsComm(),
            "-growth_type %s: no material grows, so that nothing bends by -tropism_ or "
            "-growth_ironing; give -tropism_rate, or another -growth_type",
            growth->type);
  PetscFunctionReturn(0);
}

/* A vector of the laboratory in the clamp's frame, whose axes are the columns of lab. */
static void FromLab(const PetscReal lab[3][3], const PetscReal v[3], PetscReal in[3]) {
  for (int d = 0; d < 3; d++) in[d] = lab[0][d] * v[0] + lab[1][d] * v[1] + lab[2][d] * v[2];
}

/* TropismFrame - its vectors are those of the clamp's frame from now on; the columns of lab are the
   axes of that in the laboratory, where it is at place. */
void TropismFrame(Tropism *self, const PetscReal lab[3][3], const PetscReal place[3]) {
  PetscReal *const vector[2] = {self->direction, self->source};

  for (int d = 0; d < 3; d++) self->source[d] -= place[d];
  for (int k = 0; k < 2; k++) {
    const PetscReal v[3] = {vector[k][0], vector[k][1], vector[k][2]};
    FromLab(lab, v, vector[k]);
  }
}

/* The number of the law that an option is, where it may change in a run; NULL: it is none. */
static PetscReal *NumberOf(Tropism *self, const char *name) {
  if (!strcmp(name, "-tropism_gravity")) return &self->gravity;
  if (!strcmp(name, "-tropism_light")) return &self->light;
  if (!strcmp(name, "-tropism_proprioception")) return &self->proprioception;
  if (!strcmp(name, "-tropism_nutation")) return &self->nutation[0];
  return !strcmp(name, "-growth_ironing") ? &self->ironing : NULL;
}

/* ... and the vector; sensed: the strength with which it is. */
static PetscReal *VectorOf(Tropism *self, const char *name, PetscReal *sensed) {
  const PetscBool lamp = (PetscBool)!strcmp(name, "-tropism_source");

  *sensed = lamp ? self->light : self->gravity;
  return lamp ? self->source : self->direction;
}

/*
  TropismChange - a number or a vector of the law is what the options have by now. What was 0 from
  the start stays so: the run follows nothing that only it would need. Collective on OptionsComm().

  lab    the axes of the clamp's frame in the laboratory, its columns; place: where that is
  space  the rod is in space: a vector may point out of the plane
*/
PetscErrorCode TropismChange(Tropism *self, const char *name, const PetscReal lab[3][3],
                             const PetscReal place[3], PetscBool space) {
  PetscReal *number = NumberOf(self, name), *vector, sensed, v[3] = {0, 0, 0}, size = 1;
  PetscBool given;

  PetscFunctionBegin;
  if (number) {
    UserCheck(*number != 0, OptionsComm(),
              "%s: is 0 in this run; begin it with a little of it, if it is to change", name);
    PetscCall(OptionReal(name, &v[0], NULL));
    *number = v[0] != 0 ? v[0] : PETSC_SMALL * *number; /* none, but that it can come back */
    PetscFunctionReturn(0);
  }
  vector = VectorOf(self, name, &sensed);
  UserCheck(sensed != 0, OptionsComm(), "%s: is not sensed in this run", name);
  PetscCall(OptionVector(name, vector == self->source ? UNIT_LENGTH : UNIT_NONE, v, &given));
  if (vector == self->direction) size = PetscSqrtReal(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  UserCheck(size > 0, OptionsComm(), "%s: has no length; give a direction, like 0,-1", name);
  UserCheck(v[2] == 0 || space, OptionsComm(), "%s: leads out of the plane, in which this run is",
            name);
  for (int d = 0; d < 3 && vector == self->source; d++) v[d] -= place[d];
  FromLab(lab, v, vector);
  for (int d = 0; d < 3; d++) vector[d] /= size;
  PetscFunctionReturn(0);
}

void TropismLamp(const Tropism *self, const PetscReal x[3], PetscReal pull[3],
                 PetscReal (*by_x)[3]) {
  PetscReal to[3], far, size;

  for (int i = 0; i < 3; i++) to[i] = self->source[i] - x[i];
  far = PetscSqrtReal(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]);
  size = self->light / far;
  for (int i = 0; i < 3; i++) {
    pull[i] += size * to[i];
    for (int j = 0; j < 3 && by_x; j++)
      by_x[i][j] = size * (to[i] * to[j] / (far * far) - (i == j ? 1 : 0));
  }
}

/* TropismDriveAt - TropismDrive() of a place, that goes by a signal unless it senses for itself,
   and at once. */
PetscReal TropismDriveAt(const Tropism *self, const Place *at, int bend, PetscReal signal,
                         PetscReal u0, PetscReal elastic) {
  PetscReal pull[3], f = signal;

  if (self->senses && !self->at_tip && self->memory == 0) {
    TropismPull(self, at->x, pull, NULL);
    f = TropismSensed(at, bend, pull);
  }
  return TropismDrive(self, f, u0, elastic, TropismNutation(self, bend, at->t));
}

/* TropismNearLamp - how near a way from one place straight to another comes to the lamp;
   PETSC_MAX_REAL: there is none. */
PetscReal TropismNearLamp(const Tropism *self, const PetscReal from[3], const PetscReal to[3]) {
  PetscReal along = 0, way = 0, sum = 0, z;

  if (self->light == 0) return PETSC_MAX_REAL;
  for (int i = 0; i < 3; i++) {
    along += (self->source[i] - from[i]) * (to[i] - from[i]);
    way += PetscSqr(to[i] - from[i]);
  }
  z = way > 0 ? PetscMin(1, PetscMax(0, along / way)) : 1;
  for (int i = 0; i < 3; i++) sum += PetscSqr(self->source[i] - from[i] - z * (to[i] - from[i]));
  return PetscSqrtReal(sum);
}
