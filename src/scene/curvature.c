#include "scene/curvature.h"
#include "base/hdf.h"
#include "base/spline.h"

static const OptionRow rows[] = {
    ROW_REAL("-rod_curvature", "0", -1e3, 1e3, UNIT_CURVATURE, 0,
             "natural curvature of the whole rod, per length"),
    ROW_TEXT("-rod_curvature_file", INPUT_FILE,
             "HDF5 file with /s and /curvature, the natural curvature"),
    ROW_REAL("-rod_curvature_random", "", 0, 1e3, UNIT_CURVATURE, 0,
             "root mean square of a random natural curvature, per length"),
    ROW_REAL(
        "-rod_curvature_length", "0.1", 1e-4, 100, UNIT_NONE, 0,
        "its correlation length, as a part of the rod; of a fed rod, as a part of what it is at "
        "-ts_max_time"),
    ROW_INT("-rod_curvature_seed", "1", 0, 2e9, 0, "its seed")};
const OptionGroup curvature_options = OPTION_GROUP("Natural curvature", rows);

enum { WAVES = 64, ANGLES = 4001 };

/* The spline through the knots that are there. */
static PetscErrorCode MakeSpline(Curvature *self) {
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(self->n, &self->k2));
  PetscCall(SplineSecondDerivatives(self->n, self->s, 1, self->n, 1, self->k, self->k2));
  PetscFunctionReturn(0);
}

static PetscErrorCode FromFile(Curvature *self, const char *file) {
  const char *option = "-rod_curvature_file";
  const PetscInt most = 1000000;
  PetscInt n, m;

  PetscFunctionBegin;
  PetscCall(HdfRead(option, file, "/s", 1, &n, &self->s));
  PetscCall(HdfRead(option, file, "/curvature", 1, &m, &self->k));
  UserCheck(n == m, OptionsComm(), "%s %s: /s and /curvature differ in length", option, file);
  UserCheck(n >= 4 && n <= most, OptionsComm(), "%s %s: needs 4 to %d entries, has %d", option,
            file, (int)most, (int)n);
  UserCheck(PetscAbsReal(self->s[0]) < 1e-12 && PetscAbsReal(self->s[n - 1] - 1) < 1e-12,
            OptionsComm(), "%s %s: /s must run from 0 to 1", option, file);
  for (PetscInt i = 1; i < n; i++)
    UserCheck(self->s[i] > self->s[i - 1], OptionsComm(), "%s %s: /s must increase", option, file);
  self->n = n;
  PetscCall(MakeSpline(self));
  PetscFunctionReturn(0);
}

/*
  A smooth random curvature of root mean square `amplitude` over all seeds and of correlation
  exp(-(ds/length)^2/2): waves of even random phase and normally distributed wave number,
  tabulated at eight knots per correlation length.
*/
static PetscErrorCode AtRandom(Curvature *self, PetscReal amplitude, PetscReal length,
                               PetscInt seed) {
  PetscInt n = 8 + (PetscInt)(8 / length);
  PetscReal wave[WAVES], phase[WAVES], u[2];
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
  PetscCall(PetscMalloc1(n, &self->s));
  PetscCall(PetscCalloc1(n, &self->k));
  for (PetscInt i = 0; i < n; i++) {
    self->s[i] = (PetscReal)i / (n - 1);
    for (int j = 0; j < WAVES; j++)
      self->k[i] += amplitude * PetscSqrtReal(2. / WAVES) *
                    PetscCosReal(wave[j] * self->s[i] / length + 2 * PETSC_PI * phase[j]);
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
      PetscCall(CurvatureValue(self, growth, z, zero, &k[e]));
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
  PetscCall(CurvatureValue(self, growth, s, 0, theta_s));
  *theta_s *= g;
  PetscFunctionReturn(0);
}

/*
  CurvatureSetFromOptions - reads and checks the options of the natural curvature. Collective; the
  caller ends it with CurvatureDestroy().

  A fed rod slides along its labels: there the table's labels are those at end_time.
*/
PetscErrorCode CurvatureSetFromOptions(Curvature *self, Growth growth, PetscReal end_time) {
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscReal amplitude = 0, length = 0;
  PetscInt seed = 0;
  PetscBool from_file, random;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  PetscCall(GrowthLength(growth, end_time, &self->reference_length, NULL));
  PetscCall(OptionReal("-rod_curvature", &self->constant, NULL));
  PetscCall(OptionText("-rod_curvature_file", file, &from_file));
  PetscCall(OptionReal("-rod_curvature_random", &amplitude, &random));
  UserCheck(!from_file || !random, OptionsComm(),
            "-rod_curvature_file and -rod_curvature_random: give one of them");
  if (random) {
    PetscCall(OptionReal("-rod_curvature_length", &length, NULL));
    PetscCall(OptionInt("-rod_curvature_seed", &seed, NULL));
    PetscCall(AtRandom(self, amplitude, length, seed));
  }
  if (from_file) PetscCall(FromFile(self, file));
  self->any = (PetscBool)(self->constant != 0 || from_file || (random && amplitude > 0));
  if (self->any) PetscCall(TabulateAngle(self, growth));
  PetscFunctionReturn(0);
}

PetscErrorCode CurvatureDestroy(Curvature *self) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->s));
  PetscCall(PetscFree(self->k));
  PetscCall(PetscFree(self->k2));
  PetscCall(PetscFree3(self->even, self->angle, self->slope));
  PetscFunctionReturn(0);
}

/* CurvatureValue - k0 at the label s and time t, per arc length. A fed rod carries it along: the
   material at s will be at 1 - (1 - s) L(t)/L(T) when the run ends. */
PetscErrorCode CurvatureValue(const Curvature *self, Growth growth, PetscReal s, PetscReal t,
                              PetscReal *k) {
  PetscReal weight[4], length;
  PetscInt i;

  PetscFunctionBegin;
  *k = self->constant;
  if (!self->n) PetscFunctionReturn(0);
  if (growth->slides) {
    PetscCall(GrowthLength(growth, t, &length, NULL));
    s = PetscMax(0, 1 - (1 - s) * length / self->reference_length);
  }
  SplineWeights(self->n, self->s, s, &i, weight, NULL, NULL);
  for (int j = 0; j < 2; j++) *k += weight[j] * self->k[i + j] + weight[2 + j] * self->k2[i + j];
  PetscFunctionReturn(0);
}
