/* The initial shape and the scales of the laboratory.
   test: initial shapes and scales are those asked for | ranks 1 2 */
#include "harness.h"
#include "material/shape.h"
#include "scene/si.h"

/* The largest angle, and how far the slope is from that of the angle. */
static void Survey(const Shape *shape, PetscReal *most, PetscReal *off) {
  const PetscReal e = 1e-6;

  *most = *off = 0;
  for (int i = 1; i < 400; i++) {
    PetscReal s = i / 400., a, b, slope, none;
    ShapeAngle(shape, s - e, &a, &none);
    ShapeAngle(shape, s + e, &b, &none);
    ShapeAngle(shape, s, &none, &slope);
    *most = PetscMax(*most, PetscAbsReal(none));
    *off = PetscMax(*off, PetscAbsReal((b - a) / (2 * e) - slope));
  }
}

static void TestSag(void **state) {
  PetscReal theta, slope, most, off;
  Shape shape;

  SetOptions("-shape_amplitude 0.3");
  CHECK(ShapeSetFromOptions(&shape));
  ShapeAngle(&shape, 0, &theta, &slope);
  EXPECT(theta == 0 && PetscAbsReal(slope - 0.9) < 1e-15, "at the clamp %g, %g", theta, slope);
  ShapeAngle(&shape, 1, &theta, &slope);
  EXPECT(PetscAbsReal(theta - 0.3) < 1e-15 && slope == 0, "at the tip %g, %g", theta, slope);
  Survey(&shape, &most, &off);
  EXPECT(off < 1e-8, "slope off by %g", off);
  CHECK(ShapeDestroy(&shape));
  SetOptions("-shape_type straight");
  CHECK(ShapeSetFromOptions(&shape));
  Survey(&shape, &most, &off);
  EXPECT(most == 0 && off == 0, "straight: %g", most);
  CHECK(ShapeDestroy(&shape));
}

/* Of a seed the same shape each time, of another another; as large as it was asked for, free of
   moment and shear at the tip. */
static void TestRandom(void **state) {
  PetscReal most, off, at[3], slope;
  Shape shape;

  for (int k = 0; k < 3; k++) {
    SetOptions("-shape_type random -shape_amplitude 0.02 -shape_seed %d", k == 2 ? 8 : 7);
    CHECK(ShapeSetFromOptions(&shape));
    Survey(&shape, &most, &off);
    EXPECT(PetscAbsReal(most / 0.02 - 1) < 1e-3 && off < 1e-6, "most %g, slope off by %g", most,
           off);
    ShapeAngle(&shape, 0.6, &at[k], &slope);
    ShapeAngle(&shape, 1, &most, &slope);
    EXPECT(PetscAbsReal(slope) < 1e-4, "curvature at the tip %g", slope);
    CHECK(ShapeDestroy(&shape));
  }
  EXPECT(at[0] == at[1] && PetscAbsReal(at[2] - at[0]) > 1e-4, "%g %g %g", at[0], at[1], at[2]);
}

static PetscReal Bend(PetscReal s) {
  return PetscSinReal(2 * s) / 10;
}

static void TestFile(void **state) {
  enum { N = 41 };
  const char *const name[] = {"/s", "/theta"};
  const int rank_of[] = {1, 1};
  const PetscInt n = N, *const dims[] = {&n, &n};
  PetscReal s[N], theta[N], angle, slope;
  const PetscReal *const values[] = {s, theta};
  char path[64];
  Shape shape;

  for (int i = 0; i < N; i++) theta[i] = Bend(s[i] = i / (N - 1.));
  OpenScratch(path);
  WriteScratch(path, 2, name, rank_of, dims, values);
  SetOptions("-shape_type file -shape_file %s", path);
  CHECK(ShapeSetFromOptions(&shape));
  for (PetscReal z = 0.1; z < 1; z += 0.17) {
    ShapeAngle(&shape, z, &angle, &slope);
    EXPECT(PetscAbsReal(angle - Bend(z)) < 1e-6, "at %g: %g", z, angle);
    EXPECT(PetscAbsReal(slope - PetscCosReal(2 * z) / 5) < 2e-3, "slope at %g: %g", z, slope);
  }
  CHECK(ShapeDestroy(&shape));
  RemoveFile(path);
}

/* l = (YI/N)^(1/3), N = mu + nu V; what is measured in two ways has one scale. */
static void TestScales(void **state) {
  const PetscReal *c;
  PetscReal mu = 0, N = 2 + 100 * 0.01, l = PetscPowReal(3e-4 / N, 1. / 3);
  Si si;

  SetOptions(
      "-si_bending_stiffness 3e-4 -si_friction_dry 2 -si_friction_viscous 100 -si_speed 1cm/s");
  CHECK(SiSetFromOptions(&si));
  c = si.scale;
  EXPECT(PetscAbsReal(c[UNIT_LENGTH] / l - 1) < 1e-14, "length %g", c[UNIT_LENGTH]);
  EXPECT(PetscAbsReal(c[UNIT_FORCE] / (N * l) - 1) < 1e-14, "force %g", c[UNIT_FORCE]);
  EXPECT(PetscAbsReal(c[UNIT_FORCE] * c[UNIT_LENGTH] / c[UNIT_ENERGY] - 1) < 1e-14, "energy");
  EXPECT(PetscAbsReal(c[UNIT_ENERGY] / c[UNIT_TIME] / c[UNIT_POWER] - 1) < 1e-14, "power");
  EXPECT(PetscAbsReal(c[UNIT_LENGTH] / c[UNIT_TIME] / c[UNIT_SPEED] - 1) < 1e-14, "speed");
  EXPECT(PetscAbsReal(c[UNIT_LENGTH] * c[UNIT_CURVATURE] - 1) < 1e-14, "curvature");
  CHECK(OptionReal("-friction_mu", &mu, NULL));
  EXPECT(PetscAbsReal(mu - 2. / 3) < 1e-15, "dry share %g", mu);
  SetOptions("-si_bending_stiffness 3e-4 -si_friction_dry 2");
  CHECK(SiSetFromOptions(&si));
  EXPECT(si.scale[UNIT_TIME] == 0 && si.scale[UNIT_SPEED] == 0 && si.scale[UNIT_FORCE] > 0,
         "without a speed there is no time");
  CHECK(OptionsSetScales((const PetscReal[UNIT_ALL]){0}));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestSag), cmocka_unit_test(TestRandom),
                                          cmocka_unit_test(TestFile), cmocka_unit_test(TestScales)};
MAIN(tests)
