/* The units that a scene has of its own, and what changes of a rod's fields are measured against.
   test: a rod is measured against what it is, or will be, not against round-off */
#include "harness.h"
#include "rod/rod.h"

enum { X1, X2, X3, P0, P1, P2, P3, M1, M2, M3 }; /* fields of a rod in space */

static const PetscReal round_off = PETSC_MACHINE_EPSILON;

static void Create(const RodModel *model, const char *options, Scene *scene, Rod *rod) {
  SetOptions("-rod_cells 8 -ts_max_time 2 %s", options);
  CHECK(SceneCreate(scene));
  CHECK(RodCreate(*scene, model, rod));
  CHECK(RodFindUnits(*rod));
}

static void Destroy(Scene *scene, Rod *rod) {
  CHECK(RodDestroy(rod));
  CHECK(SceneDestroy(scene));
}

static SceneUnits UnitsOf(const char *options) {
  SceneUnits units;
  Scene scene;
  Rod rod;

  Create(&rod_frame, options, &scene, &rod);
  units = scene->units;
  Destroy(&scene, &rod);
  return units;
}

/* However little friction there is, steps of the rod's own time are none of round-off; and what
   comes to a wall at any speed is not followed at any. */
static void TestShortTimes(void **state) {
  const PetscReal T = 2;
  const SceneUnits tiny =
                       UnitsOf("-growth_type uniform -growth_initial_length 1e-5 -friction_mu 0"),
                   wall = UnitsOf("-growth_type none -growth_initial_length 1e-3 -friction_mu 0 "
                                  "-contact_self true -contact_diameter 1e-5");

  (void)state;
  EXPECT(tiny.own > 1e3 * round_off * T && tiny.own < 1e-11 * T, "own time %g", tiny.own);
  EXPECT(wall.brief > 1e3 * wall.own && wall.brief < 1e-4 * T, "brief %g, own %g", wall.brief,
         wall.own);
}

/* A rod at rest in dry friction has a time of its own by beta: that of one that grows so fast that
   its beta would be the one it has. */
static void TestTimeOfBeta(void **state) {
  const SceneUnits rests = UnitsOf("-growth_type none -growth_initial_length 2"),
                   grows = UnitsOf("-growth_type feed -growth_initial_length 2");

  (void)state;
  EXPECT(PetscAbsReal(rests.time / rests.length - grows.time / grows.length) < 1e-12,
         "1 / speed: %g at rest, %g growing", rests.time / rests.length, grows.time / grows.length);
}

/* Where friction is all but none on a short piece of the rod, it is not that piece which says how
   fast the rod moves. */
static void TestLeastFriction(void **state) {
  const char *const options = "-growth_type none -growth_initial_length 1 -friction_mu 0 "
                              "-friction_layer_width 1e-3 -friction_layers 0:1,0.4:%g,0.6:1";
  char text[200];
  SceneUnits some, none;

  (void)state;
  (void)snprintf(text, sizeof(text), options, 1e-3);
  some = UnitsOf(text);
  (void)snprintf(text, sizeof(text), options, 1e-12);
  none = UnitsOf(text);
  EXPECT(PetscAbsReal(some.own - 1e-3) < 1e-9, "a thousandth counts: own time %g", some.own);
  EXPECT(none.own > 1e-7 && none.own < 1e-5, "next to nothing does not: own time %g", none.own);
}

/* A table of growth is looked at so often that a burst of a thirtieth of the run is seen. */
static void TestBurst(void **state) {
  char path[64], options[160];
  Scene scene;
  Rod rod;

  (void)state;
  WriteWalls(path, "t,speed\n0,1\n0.98,1\n1,5\n1.04,5\n1.06,1\n2,1\n");
  (void)snprintf(options, sizeof(options),
                 "-growth_type feed -growth_initial_length 1 -growth_path %s", path);
  SetOptions("-rod_cells 8 -ts_max_time 2 %s", options);
  CHECK(SceneCreate(&scene));
  scene->growth->fastest = 0; /* as of a table of stretches, which does not say */
  CHECK(RodCreate(scene, &rod_frame, &rod));
  CHECK(RodFindUnits(rod));
  EXPECT(PetscAbsReal(scene->units.speed - 5) < 1e-9, "speed %g", scene->units.speed);
  Destroy(&scene, &rod);
  RemoveFile(path);
}

/* The scales of a rod in space that is straight, from the clamp to this tip. */
static void Scales(const char *more, const PetscReal tip[3], PetscReal finest, Vector2 *axis,
                   PetscReal scale[MAX_FIELDS], PetscReal *unit) {
  char options[160];
  PetscScalar *u;
  Scene scene;
  Rod rod;
  Vec U;

  (void)snprintf(options, sizeof(options),
                 "-rod_model space -growth_type feed -growth_initial_length %g %s", (double)tip[0],
                 more);
  Create(&rod_space, options, &scene, &rod);
  rod->finest = finest;
  CHECK(DMCreateGlobalVector(rod->da, &U));
  CHECK(VecGetArray(U, &u));
  for (PetscInt i = 0; i <= 8; i++) {
    u[13 * i + P0] = 1;
    for (int d = 0; d < 3; d++) u[13 * i + X1 + d] = tip[d] * i / 8;
  }
  CHECK(VecRestoreArray(U, &u));
  CHECK(RodFieldScales(rod, U, axis, scale));
  *unit = RodFieldUnit(rod, X2);
  CHECK(VecDestroy(&U));
  Destroy(&scene, &rod);
}

/* A straight rod that a weight bends from now on is measured against what it will be: not against
   nothing, nor already against all of that; by a weight that is next to nothing, still not against
   round-off. Without any, what breaks its symmetry counts likewise. */
static void TestPrescribed(void **state) {
  const PetscReal along[3] = {1, 0, 0};
  PetscReal scale[MAX_FIELDS], unit;

  (void)state;
  Scales("-rod_weight 0,-1", along, 0, NULL, scale, &unit);
  EXPECT(scale[X2] > 1e-4 * unit && scale[X2] < 1e-2 * unit, "weight 1: %g of %g", scale[X2], unit);
  Scales("-rod_weight 0,-1e-12", along, 0, NULL, scale, &unit);
  EXPECT(scale[X2] > 1e6 * round_off * unit && scale[X2] < 1e-7 * unit, "weight 1e-12: %g of %g",
         scale[X2], unit);
  Scales("", along, 0, NULL, scale, &unit);
  EXPECT(scale[X2] > 1e-5 * unit && scale[X2] < 1e-3 * unit, "no weight: %g of %g", scale[X2],
         unit);
}

/* Of a rod that is bent in a plane between the coordinates, what there is out of that plane is
   round-off of what is in it, and is not measured against itself. */
static void TestAxes(void **state) {
  const PetscReal tip[3] = {1, 0.1, 0.05};
  PetscReal scale[MAX_FIELDS], unit;
  Vector2 axis;

  (void)state;
  Scales("", tip, 0, &axis, scale, &unit);
  EXPECT(PetscAbsReal(axis.y / axis.x - 0.5) < 1e-12, "axis (%g, %g)", axis.x, axis.y);
  EXPECT(scale[X2] > 0.11 && scale[X2] < 0.12, "in its plane: %g", scale[X2]);
  EXPECT(scale[X3] > 1e9 * round_off * scale[X2] && scale[X3] < 1e-3 * scale[X2],
         "out of it: %g of %g", scale[X3], scale[X2]);
}

/* However small a rod's bend is, the plane of it is known, as long as forces and rates of it have
   all their digits; below, there is none. */
static void TestVanished(void **state) {
  const PetscReal small[3] = {1, 4e-269, 2e-269}, none[3] = {1, 4e-280, 2e-280};
  PetscReal scale[MAX_FIELDS], unit;
  Vector2 axis;

  (void)state;
  Scales("", small, 0, &axis, scale, &unit);
  EXPECT(PetscAbsReal(axis.y / axis.x - 0.5) < 1e-12, "1e-269: axis (%g, %g)", axis.x, axis.y);
  Scales("", none, 0, &axis, scale, &unit);
  EXPECT(axis.y == 0, "1e-280: axis (%g, %g)", axis.x, axis.y);
}

/* A rod so short that round-off turns dry friction: with 0.007 of that round-off one crawls, with
   0.1 none does worse. */
static void TestTurned(void **state) {
  const PetscReal tip[3] = {0.01, 1e-9, 0}, finest = 1e-2;
  PetscReal scale[MAX_FIELDS], unit;

  (void)state;
  Scales("-friction_mu 1", tip, finest, NULL, scale, &unit);
  EXPECT(scale[X2] > 0.01 * finest * tip[0] && scale[X2] < 0.1 * finest * tip[0], "x2: %g",
         scale[X2]);
}

/* In space a place across that is small by chance is measured against what its slope makes along
   the rod, and what moments drive out of a plane against what they bend in it. */
static void TestSpace(void **state) {
  PetscReal
      chance[MAX_FIELDS] = {[X1] = 1, [X2] = 1e-6, [X3] = 1e-9, [P3] = 0.2, [P2] = 1e-9},
      driven[MAX_FIELDS] = {
          [X1] = 1, [X2] = 0.1, [X3] = 1e-14, [P2] = 1e-15, [P3] = 0.1, [M2] = 1e-6, [M3] = 1};

  (void)state;
  rod_space.scale(chance);
  EXPECT(chance[X2] > 1e-3 && chance[X2] < 0.2, "x2 of a slope of 0.2: %g", chance[X2]);
  rod_space.scale(driven);
  EXPECT(driven[X3] > 1e-12 && driven[X3] < 1e-8, "x3 by a millionth of the moment: %g",
         driven[X3]);
  EXPECT(driven[P2] > 1e-12 && driven[P2] < 1e-8, "p2: %g", driven[P2]);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestShortTimes),    cmocka_unit_test(TestTimeOfBeta),
    cmocka_unit_test(TestLeastFriction), cmocka_unit_test(TestBurst),
    cmocka_unit_test(TestPrescribed),    cmocka_unit_test(TestAxes),
    cmocka_unit_test(TestVanished),      cmocka_unit_test(TestTurned),
    cmocka_unit_test(TestSpace)};
MAIN(tests)
