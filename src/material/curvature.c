#include "material/curvature.h"
#include "base/hdf.h"
#include "base/spline.h"
#include <ctype.h>

static const OptionRow rows[] = {
    ROW_REAL("-rod_curvature", "0", -1e9, 1e9, UNIT_CURVATURE, 0,
             "natural curvature of the whole rod, per length"),
    ROW_REAL("-rod_curvature_2", "0", -1e9, 1e9, UNIT_CURVATURE, 0,
             "natural curvature about d2, out of the plane of the other, which is about d3"),
    ROW_REAL("-rod_twist", "0", -1e9, 1e9, UNIT_CURVATURE, 0,
             "natural twist about the tangent d1, in radians per length"),
    ROW_REAL("-rod_curvature_random_2", "", 0, 1e9, UNIT_CURVATURE, 0,
             "the same as -rod_curvature_random about d2: of a rod in space"),
    ROW_TEXT("-rod_curvature_file", INPUT_FILE,
             "HDF5 file with the natural curvature, /curvature (in space also /curvature_2, "
             "/twist), over the label /s of a rod that grows "
             "in place, over the /distance from the tip of one that slides (feed, apical); with /t "
             "[nt] they are [nt, n] and steer the rod over time"),
    ROW_REAL("-rod_curvature_random", "", 0, 1e9, UNIT_CURVATURE, 0,
             "root mean square of a random natural curvature, per length"),
    ROW_REAL(
        "-rod_curvature_length", "0.1", 1e-4, 1e4, UNIT_LENGTH, PART,
        "its correlation length: a part of the rod, if it grows in place; a length, if it slides"),
    ROW_INT("-rod_curvature_seed", "1", 0, 2e9, 0, "its seed")};
const OptionGroup curvature_options = OPTION_GROUP_OF_ROD("Natural curvature", rows);

enum { WAVES = 64, ANGLES = 4001, PER_LENGTH = 8, MARGIN = 30 };

/* The spline through the knots that are there. */
static PetscErrorCode MakeSpline(Strain *self) {
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(self->n, &self->k2));
  PetscCall(SplineSecondDerivatives(self->n, self->at, 1, self->n, 1, self->k, self->k2));
  PetscFunctionReturn(0);
}

static PetscErrorCode FromFile(Strain *self, Growth growth, const char *file, const char *name) {
  const char *option = "-rod_curvature_file", *where = growth->slides ? "/distance" : "/s";
  const PetscInt most = 1000000;
  PetscBool has, steered;
  PetscInt n, m;

  PetscFunctionBegin;
  PetscCall(HdfHas(file, growth->slides ? "/s" : "/distance", &has));
  UserCheck(!has, OptionsComm(),
            "%s %s: with -growth_type %s natural curvature is laid out over %s, give that", option,
            file, growth->type, where);
  PetscCall(HdfReadQuantity(option, file, where, growth->slides ? UNIT_LENGTH : UNIT_NONE, 1, &n,
                            &self->at));
  PetscCall(HdfHas(file, "/t", &steered));
  m = n;
  if (!steered) PetscCall(HdfReadQuantity(option, file, name, UNIT_CURVATURE, 1, &m, &self->k));
  UserCheck(n == m, OptionsComm(), "%s %s: %s and %s differ in length", option, file, where, name);
  UserCheck(n >= 4 && n <= most, OptionsComm(), "%s %s: needs 4 to %d entries, has %d", option,
            file, (int)most, (int)n);
  UserCheck(PetscAbsReal(self->at[0]) < 1e-12, OptionsComm(), "%s %s: %s must start at 0", option,
            file, where);
  UserCheck(growth->slides || PetscAbsReal(self->at[n - 1] - 1) < 1e-12, OptionsComm(),
            "%s %s: /s must run from 0 to 1", option, file);
  for (PetscInt i = 1; i < n; i++)
    UserCheck(self->at[i] > self->at[i - 1], OptionsComm(), "%s %s: %s must increase", option, file,
              where);
  self->n = n;
  if (steered)
    PetscCall(ActuationRead(option, file, name, n, self->at, &self->steered));
  else
    PetscCall(MakeSpline(self));
  PetscFunctionReturn(0);
}

/*
  A smooth random curvature of root mean square `amplitude` over all seeds and of correlation
  exp(-(dx/length)^2/2): waves of even random phase and normally distributed wave number, tabulated
  from low to high at eight knots per correlation length. The knots are multiples of their distance,
  and go on beyond the ends: so the curvature at a place does not depend on these.
*/
static PetscErrorCode AtRandom(Strain *self, PetscReal amplitude, PetscReal length, PetscInt seed,
                               PetscReal low, PetscReal high) {
  PetscReal wave[WAVES], phase[WAVES], u[2], h = length / PER_LENGTH;
  PetscInt first = (PetscInt)PetscFloorReal(low / h) - MARGIN,
           n = (PetscInt)PetscCeilReal(high / h) + MARGIN + 1 - first;
  PetscRandom random;

  PetscFunctionBegin;
  PetscCall(PetscRandomCreate(PETSC_COMM_SELF, &random));
  PetscCall(PetscRandomSetType(random, PETSCRANDER48));
  PetscCall(PetscRandomSetSeed(random, (unsigned long)seed));
  PetscCall(PetscRandomSeed(random));
  for (int j = 0; j < WAVES; j++) {
    for (int i = 0; i < 2; i++) PetscCall(PetscRandomGetValueReal(random, &u[i]));
    PetscCall(PetscRandomGetValueReal(random, &phase[j]));
    wave[j] = PetscSqrtReal(-2 * PetscLogReal(1 - u[0])) * PetscCosReal(2 * PETSC_PI * u[1]);
  }
  PetscCall(PetscRandomDestroy(&random));
  PetscCall(PetscMalloc1(n, &self->at));
  PetscCall(PetscCalloc1(n, &self->k));
  for (PetscInt i = 0; i < n; i++) {
    self->at[i] = (PetscReal)(first + i) * h;
    for (int j = 0; j < WAVES; j++)
      self->k[i] += amplitude * PetscSqrtReal(2. / WAVES) *
                    PetscCosReal(wave[j] * self->at[i] / length + 2 * PETSC_PI * phase[j]);
  }
  self->n = n;
  PetscCall(MakeSpline(self));
  PetscFunctionReturn(0);
}

/* Tabulates the angle of the rod that nothing bends, at t = 0. */
static PetscErrorCode TabulateAngle(Curvature *self, Growth growth) {
  const PetscReal zero = 0, h = 1. / (ANGLES - 1);
  PetscReal *s, *angle, g, k[3];

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(ANGLES, &self->even, ANGLES, &self->angle, ANGLES, &self->slope));
  s = self->even;
  angle = self->angle;
  s[0] = angle[0] = 0;
  for (int i = 1; i < ANGLES; i++) {
    s[i] = i * h;
    for (int e = 0; e < 3; e++) { /* Simpson's rule */
      PetscReal z = s[i] - h + e * h / 2;
      PetscCall(GrowthStretch(growth, 1, &z, zero, &g, NULL, NULL));
      PetscCall(CurvatureValue(self, growth, z, zero, &k[e], NULL));
      k[e] *= g;
    }
    angle[i] = angle[i - 1] + h / 6 * (k[0] + 4 * k[1] + k[2]);
    if (i == 1) self->slope[0] = k[0];
    self->slope[i] = k[2];
  }
  PetscFunctionReturn(0);
}

/* CurvatureAngle - the angle against the clamp that the natural curvature gives the rod at t = 0,
   and its derivative by s. */
PetscErrorCode CurvatureAngle(const Curvature *self, Growth growth, PetscReal s, PetscReal *theta,
                              PetscReal *theta_s) {
  const PetscReal h = 1. / (ANGLES - 1), zero = 0;
  PetscReal a, b, g;
  PetscInt i;

  PetscFunctionBegin;
  *theta = *theta_s = 0;
  if (!self->any) PetscFunctionReturn(0);
  i = PetscMax(0, PetscMin(ANGLES - 2, (PetscInt)(s / h)));
  b = s / h - i;
  a = 1 - b; /* Hermite's cubic: a spline would cost a dense solve */
  *theta = a * a * (1 + 2 * b) * self->angle[i] + b * b * (1 + 2 * a) * self->angle[i + 1] +
           a * b * h * (a * self->slope[i] - b * self->slope[i + 1]);
  PetscCall(GrowthStretch(growth, 1, &s, zero, &g, NULL, NULL));
  PetscCall(CurvatureValue(self, growth, s, 0, theta_s, NULL));
  *theta_s *= g;
  PetscFunctionReturn(0);
}

/* The correlation length: a part of a rod that grows in place, which has no unit. */
static PetscErrorCode ReadLength(Growth growth, PetscReal *length) {
  char text[64] = "";
  PetscBool unit;

  PetscFunctionBegin;
  PetscCall(OptionReal("-rod_curvature_length", length, NULL));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-rod_curvature_length", text, sizeof(text), NULL));
  unit = (PetscBool)(text[0] && isalpha((unsigned char)text[strlen(text) - 1]));
  UserCheck(
      !unit || growth->slides, OptionsComm(),
      "-rod_curvature_length %s: with -growth_type %s it is a part of the rod, without a unit",
      text, growth->type);
  PetscFunctionReturn(0);
}

/* A strain at random; which: that about d2 has a seed of its own. */
static PetscErrorCode RandomStrain(Strain *self, Growth growth, PetscReal end_time,
                                   PetscReal amplitude, int which) {
  const PetscInt apart = 1000003;
  PetscReal length, low = 0, high = 1, L;
  PetscInt seed;

  PetscFunctionBegin;
  PetscCall(ReadLength(growth, &length));
  PetscCall(OptionInt("-rod_curvature_seed", &seed, NULL));
  PetscCall(growth->slides ? GrowthLongest(growth, end_time, &L)
                           : GrowthLength(growth, end_time, &L, NULL));
  if (growth->slides) {
    low = growth->initial_length - L;
    high = L;
  }
  PetscCall(AtRandom(self, amplitude, length, seed + which * apart, low, high));
  PetscFunctionReturn(0);
}

/* A law of one's own, in the place of all options: what there is of it shows at places all over the
   run. */
static PetscErrorCode TakeOwn(Curvature *self, PetscReal end_time) {
  enum { PLACES = 65, TIMES = 9 };
  static const char *const others[] = {
      "-rod_curvature",      "-rod_curvature_2",      "-rod_twist",
      "-rod_curvature_file", "-rod_curvature_random", "-rod_curvature_random_2"};
  PetscBool given;

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(others); k++) {
    PetscCall(OptionGiven(others[k], &given));
    UserCheck(!given, OptionsComm(), "%s: the curvature of one's own says it; take this out",
              others[k]);
  }
  for (int i = 0; i < PLACES * TIMES; i++) {
    const TendrilPlace at = {.s = (double)(i % PLACES) / (PLACES - 1),
                             .t = end_time * (double)(i / PLACES) / (TIMES - 1)};
    PetscReal value[OWN_VALUES] = {0};
    OwnValue(self->own, &at, value);
    for (int k = 0; k < STRAINS; k++) {
      UserCheck(!PetscIsInfOrNanReal(value[k]), OptionsComm(),
                "the curvature of one's own is no number at s = %g, t = %g", at.s, at.t);
      self->most[k] = PetscMax(self->most[k], PetscAbsReal(value[k]));
    }
  }
  self->any = PETSC_TRUE;
  self->space = (PetscBool)(self->most[BEND_2] > 0 || self->most[TURN_1] > 0);
  PetscFunctionReturn(0);
}

/*
  CurvatureSetFromOptions - reads and checks the options of the natural curvature. Collective; the
  caller ends it with CurvatureDestroy(), also after an error.

  end_time  of the run: so far curvature is wanted
*/
PetscErrorCode CurvatureSetFromOptions(Curvature *self, Growth growth, PetscReal end_time) {
  static const char *const constant[STRAINS] = {"-rod_curvature", "-rod_curvature_2", "-rod_twist"},
                           *const random[STRAINS] = {"-rod_curvature_random",
                                                     "-rod_curvature_random_2", NULL},
                           *const name[STRAINS] = {"/curvature", "/curvature_2", "/twist"};
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool from_file, at_random[STRAINS] = {PETSC_FALSE}, has;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  self->own = OptionsLaw(OWN_CURVATURE);
  if (self->own) {
    PetscCall(TakeOwn(self, end_time));
    PetscCall(TabulateAngle(self, growth));
    PetscFunctionReturn(0);
  }
  PetscCall(OptionText("-rod_curvature_file", file, &from_file));
  for (int k = 0; k < STRAINS; k++) {
    Strain *strain = &self->strain[k];
    PetscReal amplitude = 0;
    PetscCall(OptionReal(constant[k], &strain->constant, NULL));
    if (random[k]) PetscCall(OptionReal(random[k], &amplitude, &at_random[k]));
    UserCheck(!from_file || !at_random[k], OptionsComm(),
              "-rod_curvature_file and %s: give one of them", random[k]);
    if (at_random[k]) PetscCall(RandomStrain(strain, growth, end_time, amplitude, k));
    has = PETSC_TRUE;
    if (from_file && k > BEND_3) PetscCall(HdfHas(file, name[k], &has));
    if (from_file && has) PetscCall(FromFile(strain, growth, file, name[k]));
    self->steered = (PetscBool)(self->steered || strain->steered);
    if (strain->constant != 0 || (from_file && has) || (at_random[k] && amplitude > 0)) {
      self->any = PETSC_TRUE;
      self->space = (PetscBool)(self->space || k > BEND_3);
    }
  }
  if (self->any) PetscCall(TabulateAngle(self, growth));
  PetscFunctionReturn(0);
}

PetscErrorCode CurvatureDestroy(Curvature *self) {
  PetscFunctionBegin;
  for (int k = 0; k < STRAINS; k++) {
    PetscCall(PetscFree(self->strain[k].at));
    PetscCall(PetscFree(self->strain[k].k));
    PetscCall(PetscFree(self->strain[k].k2));
    PetscCall(ActuationDestroy(&self->strain[k].steered));
  }
  PetscCall(PetscFree3(self->even, self->angle, self->slope));
  PetscFunctionReturn(0);
}

/* Where a table is to be read for the material at a label and a time, and the rate of that. What is
   steered is read at the distance from the tip now, from which material slides away at L_t - V. */
static PetscErrorCode OriginOf(const Curvature *self, Growth growth, PetscReal s, PetscReal t,
                               PetscReal *at, PetscReal *at_t) {
  PetscReal L, L_t, p, p_t;

  PetscFunctionBegin;
  *at = s;
  *at_t = 0;
  if (!growth->slides) PetscFunctionReturn(0);
  if (!self->steered) {
    PetscCall(GrowthOrigin(growth, s, t, at, at_t));
    PetscFunctionReturn(0);
  }
  PetscCall(GrowthLength(growth, t, &L, &L_t));
  PetscCall(GrowthArc(growth, 1, &s, t, &p, &p_t));
  *at = (1 - s) * L;
  *at_t = L_t - GrowthSpeed(growth, s, t, p_t);
  PetscFunctionReturn(0);
}

/* A strain that is steered: for the material it changes at the rate k_t + d_t k_d. */
static void Steered(const Strain *self, PetscReal at, PetscReal at_t, PetscReal t, PetscReal *k,
                    PetscReal *k_t) {
  PetscReal value, slope, rate;

  ActuationValue(self->steered, at, t, &value, &slope, &rate);
  *k += value;
  if (k_t) *k_t += rate + at_t * slope;
}

/* One natural strain there, and its rate for the material (may be NULL). */
static void Value(const Strain *self, PetscReal at, PetscReal at_t, PetscReal t, PetscReal *k,
                  PetscReal *k_t) {
  const PetscBool changes = (PetscBool)(k_t && at_t != 0);
  PetscReal weight[4], slope[4];
  PetscInt i;

  *k = self->lead.on ? LeadValue(&self->lead, t) : self->constant;
  if (k_t) *k_t = LeadRate(&self->lead, t);
  if (!self->n) return;
  if (self->steered) {
    Steered(self, at, at_t, t, k, k_t);
    return;
  }
  if (at < self->at[0] || at > self->at[self->n - 1]) {
    *k += self->k[at < self->at[0] ? 0 : self->n - 1];
    return;
  }
  SplineWeights(self->n, self->at, at, &i, weight, changes ? slope : NULL, NULL);
  for (int j = 0; j < 2; j++) *k += weight[j] * self->k[i + j] + weight[2 + j] * self->k2[i + j];
  for (int j = 0; j < 2 && changes; j++)
    *k_t += at_t * (slope[j] * self->k[i + j] + slope[2 + j] * self->k2[i + j]);
}

/* ... or of a law of one's own. */
static void OwnStrain(const Curvature *self, int e, PetscReal s, PetscReal t, PetscReal *k,
                      PetscReal *k_t) {
  const TendrilPlace at = {.s = s, .t = t};
  PetscReal value[OWN_VALUES] = {0};

  OwnValue(self->own, &at, value);
  *k = value[e];
  if (k_t) *k_t = value[STRAINS + e];
}

/*
  CurvatureValue - k0 at the label s and time t, per arc length, and the rate k_t at which it
  changes for the material there (may be NULL).

  In place the table is over the labels. Where material slides, it is over the distance that the
  material there had from the tip at the start (growth.h): a fed rod carries its curvature along.
  Beyond the ends of a file's table its last values go on. What is steered is over the distance that
  it has from the tip now, which of a fed rod is the same.
*/
PetscErrorCode CurvatureValue(const Curvature *self, Growth growth, PetscReal s, PetscReal t,
                              PetscReal *k, PetscReal *k_t) {
  const Strain *strain = &self->strain[BEND_3];
  PetscReal at = s, at_t = 0;

  PetscFunctionBegin;
  if (self->own) {
    OwnStrain(self, BEND_3, s, t, k, k_t);
    PetscFunctionReturn(0);
  }
  if (strain->n) PetscCall(OriginOf(self, growth, s, t, &at, &at_t));
  Value(strain, at, at_t, t, k, k_t);
  PetscFunctionReturn(0);
}

/* CurvatureLeadTo - the constant part of a strain is led on, from what it is at t and at its rate
   there, to k by the time `by`. */
void CurvatureLeadTo(Curvature *self, int strain, PetscReal t, PetscReal by, PetscReal k) {
  Lead *lead = &self->strain[strain].lead;

  LeadTo(lead, t, lead->on ? LeadValue(lead, t) : self->strain[strain].constant, LeadRate(lead, t),
         by, k);
  self->any = PETSC_TRUE;
  self->space = (PetscBool)(self->space || strain != BEND_3);
}

/* CurvatureNextTurn - the first time behind t at which one that is steered kinks, sets out, rests
   or turns back; PETSC_MAX_REAL if there is none. */
PetscReal CurvatureNextTurn(const Curvature *self, PetscReal t) {
  PetscReal next = PETSC_MAX_REAL;

  for (int k = 0; k < STRAINS; k++) next = PetscMin(next, LeadNextTurn(&self->strain[k].lead, t));
  for (int k = 0; k < STRAINS && self->steered; k++)
    if (self->strain[k].steered)
      next = PetscMin(next, ActuationNextTurn(self->strain[k].steered, t));
  return next;
}

/* CurvatureJerks - does the rate at which it is steered jump between two times? */
PetscBool CurvatureJerks(const Curvature *self, PetscReal t0, PetscReal t1) {
  for (int k = 0; k < STRAINS && self->steered; k++)
    if (self->strain[k].steered && ActuationJerks(self->strain[k].steered, t0, t1))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

/* CurvatureBendsInTime - adds the times at which it bends (base/bends.h). */
PetscErrorCode CurvatureBendsInTime(const Curvature *self, PetscReal tolerance, Bends *bends) {
  PetscFunctionBegin;
  for (int k = 0; k < STRAINS; k++)
    if (self->strain[k].steered)
      PetscCall(ActuationBends(self->strain[k].steered, tolerance, bends));
  PetscFunctionReturn(0);
}

/* CurvatureLargest - how large a strain is at most, at any place and time. */
PetscReal CurvatureLargest(const Curvature *self, int e) {
  const Strain *strain = &self->strain[e];
  PetscReal most = PetscMax(PetscAbsReal(strain->constant), self->most[e]);

  if (strain->lead.on)
    most =
        PetscMax(most, PetscMax(PetscAbsReal(strain->lead.x[0]), PetscAbsReal(strain->lead.x[1])));

  if (strain->steered) return PetscMax(most, ActuationLargest(strain->steered));
  for (PetscInt i = 0; i < strain->n; i++) most = PetscMax(most, PetscAbsReal(strain->k[i]));
  return most;
}

/* CurvatureSteered - the largest of a strain that is steered, 0 if that is not. (Two bends twist.)
 */
PetscReal CurvatureSteered(const Curvature *self, int strain) {
  const Strain *of = self->strain;

  if (strain == TURN_1 && !of[TURN_1].steered && of[BEND_2].steered && of[BEND_3].steered)
    return PetscMin(CurvatureSteered(self, BEND_2), CurvatureSteered(self, BEND_3));
  return of[strain].steered ? ActuationLargest(of[strain].steered) : 0;
}

/* CurvatureFinest - the least length (or part of the labels) over which one that is no constant
   changes by as much as it is at most: that of a hook, however far apart the other knots are. 0:
   there is none. */
PetscReal CurvatureFinest(const Curvature *self) {
  PetscReal least = PETSC_MAX_REAL;

  for (int e = 0; e < STRAINS; e++) {
    const Strain *strain = &self->strain[e];
    PetscReal most = 0, steepest = 0;
    if (strain->steered) {
      most = ActuationLargest(strain->steered);
      steepest = ActuationSteepest(strain->steered);
    }
    for (PetscInt i = 0; i < strain->n && !strain->steered; i++) {
      most = PetscMax(most, PetscAbsReal(strain->k[i]));
      if (i + 1 < strain->n)
        steepest = PetscMax(steepest, PetscAbsReal(strain->k[i + 1] - strain->k[i]) /
                                          (strain->at[i + 1] - strain->at[i]));
    }
    if (steepest > 0) least = PetscMin(least, most / steepest);
  }
  return least < PETSC_MAX_REAL ? least : 0;
}

/* CurvatureBends - is the rod bent by nature anywhere, and not only twisted? */
PetscBool CurvatureBends(const Curvature *self) {
  for (int e = 0; e < STRAINS; e++)
    if (e != TURN_1 && CurvatureLargest(self, e) > 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* CurvatureIsTable - is it laid out along the rod, and not the same everywhere? */
PetscBool CurvatureIsTable(const Curvature *self) {
  for (int e = 0; e < STRAINS; e++)
    if (self->strain[e].n) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* CurvatureRounding - the least energy of a rod of that length that is more than round-off: what is
   bent or twisted by nature has that of a difference, a part of k0^2 L; a straight rod has none. */
PetscReal CurvatureRounding(const Curvature *self, PetscReal length) {
  PetscReal most = 0;

  for (int e = 0; e < STRAINS; e++) most = PetscMax(most, CurvatureLargest(self, e));
  return PETSC_MACHINE_EPSILON * PetscSqr(most) * length;
}

/* CurvatureStrains - the natural strains in space: twist, bend about d2, bend about d3; otherwise
   as CurvatureValue(). */
PetscErrorCode CurvatureStrains(const Curvature *self, Growth growth, PetscReal s, PetscReal t,
                                PetscReal u[3], PetscReal u_t[3]) {
  static const int place[STRAINS] = {[BEND_3] = 2, [BEND_2] = 1, [TURN_1] = 0};
  PetscReal at = s, at_t = 0;

  PetscFunctionBegin;
  for (int k = 0; k < STRAINS; k++)
    if (self->strain[k].n) {
      PetscCall(OriginOf(self, growth, s, t, &at, &at_t));
      break;
    }
  for (int k = 0; k < STRAINS; k++)
    if (self->own)
      OwnStrain(self, k, s, t, &u[place[k]], u_t ? &u_t[place[k]] : NULL);
    else
      Value(&self->strain[k], at, at_t, t, &u[place[k]], u_t ? &u_t[place[k]] : NULL);
  PetscFunctionReturn(0);
}
