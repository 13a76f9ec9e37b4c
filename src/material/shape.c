#include "material/shape.h"
#include "base/hdf.h"
#include "base/lagrange.h"
#include "base/spline.h"

enum { RANDOM_KNOTS = 201, RANDOM_MODES = 8 };

static const OptionRow rows[] = {
    ROW_WORD("-shape_type", "sag", "straight,sag,mode,random,file", 0, "initial shape"),
    ROW_REAL("-shape_amplitude", "0.01", -6.5, 6.5, UNIT_ANGLE, 0,
             "eps, largest initial angle, in radians"),
    ROW_INT("-shape_seed", "1", 0, 2e9, 0, "seed of the random shape"),
    ROW_TEXT(
        "-shape_file", INPUT_FILE,
        "HDF5 file with /s and /theta, the angle against the clamp; in space /s and some of /u1, "
        "/u2, /u3, twist and bends per length beside the natural ones"),
    ROW_REAL("-shape_turn", "0", -6.2832, 6.2832, UNIT_ANGLE, 0,
             "turns the initial shape about the axis of the clamp, out of the plane, in radians")};
const OptionGroup shape_options = OPTION_GROUP_OF_ROD("Initial shape", rows);

/*
  ShapeSetTable - gives the shape by its angle against the clamp at n labels (splined).

  s, theta   copied; s must run from 0 to 1 and theta[0] be 0
*/
PetscErrorCode ShapeSetTable(Shape *shape, PetscInt n, const PetscReal s[],
                             const PetscReal theta[]) {
  PetscFunctionBegin;
  PetscCall(ShapeDestroy(shape));
  PetscCall(PetscMalloc3(n, &shape->s, n, &shape->theta, n, &shape->theta2));
  shape->n = n;
  PetscCall(PetscArraycpy(shape->s, s, n));
  PetscCall(PetscArraycpy(shape->theta, theta, n));
  PetscCall(SplineSecondDerivatives(n, shape->s, 1, n, 1, shape->theta, shape->theta2));
  PetscFunctionReturn(0);
}

/* ShapeDestroy - frees what a tabulated shape holds. */
PetscErrorCode ShapeDestroy(Shape *shape) {
  PetscFunctionBegin;
  if (shape->space) {
    PetscCall(PetscFree(shape->s));
    for (int d = 0; d < 3; d++) {
      PetscCall(PetscFree(shape->u[d]));
      PetscCall(PetscFree(shape->u2[d]));
    }
  } else
    PetscCall(PetscFree3(shape->s, shape->theta, shape->theta2));
  PetscFunctionReturn(0);
}

static PetscErrorCode Check(const char *file, PetscInt n, const PetscReal s[], PetscInt m,
                            const PetscReal theta[]) {
  PetscFunctionBegin;
  UserCheck(n == m, OptionsComm(), "-shape_file %s: /s and /theta differ in length", file);
  UserCheck(n >= 4, OptionsComm(), "-shape_file %s: needs 4 entries at least, has %d", file,
            (int)n);
  UserCheck(PetscAbsReal(s[0]) < 1e-12 && PetscAbsReal(s[n - 1] - 1) < 1e-12, OptionsComm(),
            "-shape_file %s: /s must run from 0 to 1", file);
  for (PetscInt i = 1; i < n; i++)
    UserCheck(s[i] > s[i - 1], OptionsComm(), "-shape_file %s: /s must increase", file);
  UserCheck(PetscAbsReal(theta[0]) < 1e-9, OptionsComm(),
            "-shape_file %s: /theta is measured against the clamp and must start at 0", file);
  PetscFunctionReturn(0);
}

/* A shape by its strains. */
static PetscErrorCode StrainsFromFile(Shape *shape, const char *file, const PetscBool has[3]) {
  static const char *const name[3] = {"/u1", "/u2", "/u3"};
  PetscInt m;

  PetscFunctionBegin;
  shape->space = PETSC_TRUE;
  PetscCall(HdfReadQuantity("-shape_file", file, "/s", UNIT_NONE, 1, &shape->n, &shape->s));
  for (int d = 0; d < 3; d++) {
    if (!has[d]) continue;
    PetscCall(HdfReadQuantity("-shape_file", file, name[d], UNIT_CURVATURE, 1, &m, &shape->u[d]));
    UserCheck(m == shape->n, OptionsComm(), "-shape_file %s: /s and %s differ in length", file,
              name[d]);
    PetscCall(Check(file, shape->n, shape->s, m, (const PetscReal[]){0}));
    PetscCall(PetscMalloc1(m, &shape->u2[d]));
    PetscCall(SplineSecondDerivatives(m, shape->s, 1, m, 1, shape->u[d], shape->u2[d]));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode FromFile(Shape *shape, const char *file) {
  PetscReal *s = NULL, *theta = NULL;
  PetscErrorCode error;
  PetscBool has[3];
  PetscInt n, m;

  PetscFunctionBegin;
  PetscCall(HdfHas(file, "/u1", &has[0]));
  PetscCall(HdfHas(file, "/u2", &has[1]));
  PetscCall(HdfHas(file, "/u3", &has[2]));
  if (has[0] || has[1] || has[2]) {
    PetscCall(StrainsFromFile(shape, file, has));
    PetscFunctionReturn(0);
  }
  error = HdfReadQuantity("-shape_file", file, "/s", UNIT_NONE, 1, &n, &s);
  if (!error) error = HdfReadQuantity("-shape_file", file, "/theta", UNIT_ANGLE, 1, &m, &theta);
  if (!error) error = Check(file, n, s, m, theta);
  if (!error) {
    theta[0] = 0;
    error = ShapeSetTable(shape, n, s, theta);
  }
  PetscCall(PetscFree(s));
  PetscCall(PetscFree(theta));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* A seeded sum of smooth modes, theta' = (1-s)^2 sum_k c_k cos(k pi s) / k^2, c_k even in [-1,1]:
   each meets kappa(1) = kappa'(1) = 0. Scaled so that max |theta| = eps. */
static PetscErrorCode AtRandom(Shape *shape) {
  PetscReal s[RANDOM_KNOTS], theta[RANDOM_KNOTS], c[RANDOM_MODES], most = 0;
  PetscRandom random;

  PetscFunctionBegin;
  PetscCall(PetscRandomCreate(PETSC_COMM_SELF, &random));
  PetscCall(PetscRandomSetType(random, PETSCRANDER48));
  PetscCall(PetscRandomSetInterval(random, -1, 1));
  PetscCall(PetscRandomSetSeed(random, (unsigned long)shape->seed));
  PetscCall(PetscRandomSeed(random));
  for (int k = 0; k < RANDOM_MODES; k++) PetscCall(PetscRandomGetValueReal(random, &c[k]));
  PetscCall(PetscRandomDestroy(&random));
  s[0] = theta[0] = 0;
  for (int i = 1; i < RANDOM_KNOTS; i++) {
    s[i] = (PetscReal)i / (RANDOM_KNOTS - 1);
    theta[i] = theta[i - 1];
    for (int q = 0; q < GAUSS; q++) {
      PetscReal h = s[i] - s[i - 1], z = s[i - 1] + h * gauss_point[q], slope = 0;
      for (int k = 0; k < RANDOM_MODES; k++)
        slope += c[k] * PetscCosReal((k + 1) * PETSC_PI * z) / PetscSqr(k + 1);
      theta[i] += h * gauss_weight[q] * PetscSqr(1 - z) * slope;
    }
    most = PetscMax(most, PetscAbsReal(theta[i]));
  }
  for (int i = 0; i < RANDOM_KNOTS; i++) theta[i] *= shape->amplitude / most;
  PetscCall(ShapeSetTable(shape, RANDOM_KNOTS, s, theta));
  PetscFunctionReturn(0);
}

/* ShapeSetFromOptions - reads and checks the options of the initial shape. Collective; the caller
   ends it with ShapeDestroy(). */
PetscErrorCode ShapeSetFromOptions(Shape *shape) {
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscInt choice;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(shape, sizeof(*shape)));
  PetscCall(OptionWord("-shape_type", &choice, NULL));
  PetscCall(OptionReal("-shape_turn", &shape->turn, NULL));
  shape->type = (ShapeType)choice;
  if (choice != SHAPE_STRAIGHT && choice != SHAPE_FILE)
    PetscCall(OptionReal("-shape_amplitude", &shape->amplitude, NULL));
  if (choice == SHAPE_RANDOM) {
    PetscCall(OptionInt("-shape_seed", &shape->seed, NULL));
    PetscCall(AtRandom(shape));
  }
  if (choice == SHAPE_FILE) {
    PetscCall(OptionText("-shape_file", file, &set));
    UserCheck(set, OptionsComm(), "-shape_type file needs -shape_file FILE");
    PetscCall(FromFile(shape, file));
  }
  PetscFunctionReturn(0);
}

/*
  ShapeAngle - the initial angle against the clamp and its derivative by s, at one label.
  sag: theta = eps (1 - (1-s)^3), the cantilever under a uniform side load; from a hinge, which
  bears no moment, eps s^2 (3 - 2s), the beam between two hinges under it.
*/
void ShapeAngle(const Shape *shape, PetscReal s, PetscReal *theta, PetscReal *theta_s) {
  *theta = *theta_s = 0;
  if (shape->type == SHAPE_SAG && shape->hinged) {
    *theta = shape->amplitude * s * s * (3 - 2 * s);
    *theta_s = shape->amplitude * 6 * s * (1 - s);
  } else if (shape->type == SHAPE_SAG) {
    *theta = shape->amplitude * (1 - (1 - s) * (1 - s) * (1 - s));
    *theta_s = shape->amplitude * 3 * (1 - s) * (1 - s);
  } else if (shape->theta) {
    PetscReal value[4], slope[4];
    PetscInt i;
    SplineWeights(shape->n, shape->s, s, &i, value, slope, NULL);
    for (int k = 0; k < 2; k++) {
      *theta += value[k] * shape->theta[i + k] + value[2 + k] * shape->theta2[i + k];
      *theta_s += slope[k] * shape->theta[i + k] + slope[2 + k] * shape->theta2[i + k];
    }
  }
}

/* ShapeStrains - twist and bends about d2 and d3 of the initial shape, per length, at a label where
   the rod is stretched by g. */
void ShapeStrains(const Shape *shape, PetscReal s, PetscReal g, PetscReal u[3]) {
  PetscReal theta, theta_s, value[4];
  PetscInt i;

  ShapeAngle(shape, s, &theta, &theta_s);
  u[0] = 0;
  u[1] = shape->turn != 0 ? -PetscSinReal(shape->turn) * theta_s / g : 0;
  u[2] = shape->turn != 0 ? PetscCosReal(shape->turn) * theta_s / g : theta_s / g;
  if (!shape->space) return;
  SplineWeights(shape->n, shape->s, s, &i, value, NULL, NULL);
  for (int d = 0; d < 3; d++)
    for (int k = 0; k < 2 && shape->u[d]; k++)
      u[d] += value[k] * shape->u[d][i + k] + value[2 + k] * shape->u2[d][i + k];
}

/* ShapeMeanBend - how far it is bent on the whole, beside the natural bends, where a rod is of this
   length: the root of the mean square; of one that is tabulated, by its knots. */
PetscReal ShapeMeanBend(const Shape *shape, PetscReal length) {
  enum { PLACES = 21 };
  const PetscInt n = shape->n ? shape->n : PLACES;
  PetscReal sum = 0, before[2] = {0}, u[3]; /* before: label, and square there */

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal s = shape->n ? shape->s[i] : (PetscReal)i / (PLACES - 1);
    PetscReal square;
    ShapeStrains(shape, s, length, u);
    square = u[1] * u[1] + u[2] * u[2];
    sum += (s - before[0]) * (square + before[1]) / 2;
    before[0] = s;
    before[1] = square;
  }
  return PetscSqrtReal(sum);
}
