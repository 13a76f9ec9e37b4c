/* How finely cells are integrated, and which are split.
   test: cells are split and integrated as finely as it takes */
#include "harness.h"
#include "rod/space_cells.h"
#include "rod/pair_defect.h"
#include "rod/spin.h"

static void Create(const char *options, Scene *scene, Rod *rod) {
  SetOptions("-ts_max_time 2 %s", options);
  CHECK(SceneCreate(scene));
  (*scene)->space.rod = PETSC_TRUE;
  CHECK(RodCreate(*scene, &rod_space, rod));
}

static void Destroy(Scene *scene, Rod *rod) {
  CHECK(RodDestroy(rod));
  CHECK(SceneDestroy(scene));
}

/* Is the cell in which a straight rod at rest stops turning split, and no other one? The directors
   spin at these speeds on either side of it, and the rod moves across. */
static PetscBool Splits(PetscReal beta, PetscReal before, PetscReal behind, PetscReal across) {
  enum { CELLS = 6, IN = 2 };
  const PetscReal arm = 0.5;
  PetscBool one;
  PetscScalar *u, *v;
  RodState at = {.fresh = PETSC_TRUE, .iterates = PETSC_TRUE};
  Scene scene;
  Rod rod;
  Vec U[3];

  SetOptions("-ts_max_time 2 -growth_type none -growth_initial_length 1 -shape_type straight "
             "-rod_cells %d -friction_radius %g -friction_beta %g",
             CELLS, (double)arm, (double)beta);
  CHECK(SceneCreate(&scene));
  scene->space.rod = PETSC_TRUE;
  CHECK(RodCreate(scene, &rod_space, &rod));
  for (int k = 0; k < 3; k++) CHECK(DMCreateGlobalVector(rod->da, &U[k]));
  CHECK(RodBegin(rod, U[0]));
  CHECK(VecGetArray(U[0], &u));
  CHECK(VecGetArray(U[1], &v));
  for (PetscInt i = 0; i <= CELLS; i++) { /* the spin is twice p1's rate */
    v[i * FIELDS + P + 1] = (i <= IN ? before : behind) / (2 * arm);
    v[i * FIELDS + X + 1] = across;
  }
  CHECK(VecRestoreArray(U[1], &v));
  CHECK(VecRestoreArray(U[0], &u));
  at.U = U[0];
  at.U_t = U[1];
  CHECK(rod_space.residual(rod, &at, U[2]));
  one = ((const Space_ *)rod->data)->split ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; i < CELLS && one; i++)
    if (((const Space_ *)rod->data)->split[i + 1] != (i == IN)) one = PETSC_FALSE;
  for (int k = 0; k < 3; k++) CHECK(VecDestroy(&U[k]));
  Destroy(&scene, &rod);
  return one;
}

/* Dry friction that resists a spin jumps where that changes its sign, or ends: not if beta spreads
   the jump, nor if the rod hardly spins or slides all along. */
static void TestSplits(void **state) {
  const PetscReal beta = 1e-9, fast = 100 * PetscSqrtReal(beta);

  (void)state;
  EXPECT(Splits(beta, fast, -fast, 0), "turns the other way");
  EXPECT(Splits(beta, fast, 0, 0), "stops turning");
  EXPECT(!Splits(beta, fast, fast, 0), "turns on");
  EXPECT(!Splits(1e-5, 1, -1, 0), "a beta that is no jump");
  EXPECT(!Splits(beta, PetscSqrtReal(beta), -PetscSqrtReal(beta), 0), "hardly turns");
  EXPECT(!Splits(beta, fast, -fast, 0.5 * fast), "slides by half of its spin");
  EXPECT(!Splits(beta, fast, 0.5 * fast, 0), "turns on half as fast");
}

/* By how much Simpson's rule on two cells is told to be off. */
static PetscReal Rule(const PetscReal f[PLACES]) {
  PetscReal weight[PLACES];

  PairWeights(0.5, 0.5, weight);
  return PairRule(0.5, 0.5, weight, f);
}

/* A smooth load is integrated as well as it seems to be; of one that changes from point to point
   the finer rule itself is off by as much again, at least. The pressure of contact, which the rod
   gives way to, counts by a part. */
static void TestRough(void **state) {
  const PetscReal smooth[PLACES] = {1, 1.25, 2, 3.25, 5}, rough[PLACES] = {0, 1, 0, 1, 0};
  const Contact none = {.any = PETSC_FALSE}, some = {.any = PETSC_TRUE, .tip = 1};
  const PetscReal finer = 2. / 3 - 64. / 90, off = PetscAbsReal(Rule(rough) / finer);

  (void)state;
  EXPECT(PetscAbsReal(Rule(smooth)) < 1e-14, "smooth: %g", Rule(smooth));
  EXPECT(off > 1.9 && off < 10, "rough: %g times", off);
  EXPECT(PairSees(&none, 0.1) == 1 && PairSees(&some, 0.1) > 0.03 && PairSees(&some, 0.1) < 0.5,
         "pressure: %g", PairSees(&some, 0.1));
}

/* The tip of an initial shape of a rod of so many cells, whose bend changes along it. */
static void TipOf(PetscInt cells, PetscReal x[3]) {
  char options[160];
  Node *nodes;
  Scene scene;
  Rod rod;

  (void)snprintf(options, sizeof(options),
                 "-growth_type feed -growth_initial_length 3 -shape_type sag -shape_amplitude 2 "
                 "-rod_curvature_2 1 -rod_cells %d",
                 (int)cells);
  Create(options, &scene, &rod);
  CHECK(PetscMalloc1(cells + 1, &nodes));
  CHECK(RodInitialNodes(rod, 0, nodes));
  for (int d = 0; d < 3; d++) x[d] = nodes[cells].x[d];
  CHECK(PetscFree(nodes));
  Destroy(&scene, &rod);
}

/* Where the rod begins is not a matter of its cells. */
static void TestStart(void **state) {
  PetscReal few[3], many[3], off;

  (void)state;
  TipOf(8, few);
  TipOf(3000, many);
  off = hypot(hypot(few[0] - many[0], few[1] - many[1]), few[2] - many[2]);
  EXPECT(off < 1e-9, "the tip of 8 cells is off by %g", off);
}

/* The slope of the moment of the initial shape: what makes the force across it. */
static void TestShear(void **state) {
  enum { CELLS = 7, AT = 3 }; /* between the knots of the shape */
  const PetscReal s = (PetscReal)AT / CELLS, h = 1e-3;
  PetscReal theta, slope[4], m_s = 0, shear;
  static const PetscReal weight[4] = {1. / 12, -8. / 12, 8. / 12, -1. / 12};
  Node *nodes;
  Scene scene;
  Rod rod;

  (void)state;
  SetOptions("-ts_max_time 2 -growth_type uniform -growth_initial_length 1 -shape_type random "
             "-rod_cells %d",
             CELLS);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, &rod_frame, &rod));
  CHECK(PetscMalloc1(CELLS + 1, &nodes));
  CHECK(RodInitialNodes(rod, 0, nodes));
  for (int k = 0; k < 4; k++) {
    CHECK(SceneShapeAngle(scene, s + (k < 2 ? k - 2 : k - 1) * h, &theta, &slope[k]));
    m_s += weight[k] * slope[k] / h;
  }
  theta = nodes[AT].theta;
  shear = -nodes[AT].force[0] * PetscSinReal(theta) + nodes[AT].force[1] * PetscCosReal(theta);
  EXPECT(PetscAbsReal(shear + m_s) < 1e-5 * PetscAbsReal(m_s), "shear %g, slope %g", shear, m_s);
  CHECK(PetscFree(nodes));
  Destroy(&scene, &rod);
}

/* 1/C at a label of a rod, and a time. */
static PetscReal Flexibility(Scene scene, PetscReal s, PetscReal t) {
  PetscReal B, S[3];

  CHECK(SceneStiffness(scene, s, t, &B, NULL));
  SceneStiffnesses(scene, B, S);
  return 1 / S[0];
}

/* The rate at which torsional flexibility changes where a rod is the softer the nearer its tip is,
   and the tip grows away. */
static void TestTwistRate(void **state) {
  enum { KNOTS = 401 };
  static const char *const name[] = {"/distance", "/factor"};
  const int rank_of[] = {1, 1};
  const PetscInt n = KNOTS, *const dims[] = {&n, &n};
  PetscReal distance[KNOTS], factor[KNOTS];
  const PetscReal *const values[] = {distance, factor}, s = 0.3, t = 0.5, h = 1e-3;
  PetscReal exact;
  TwistRate rate;
  char path[64], options[200];
  Scene scene;
  Rod rod;

  (void)state;
  for (PetscInt i = 0; i < KNOTS; i++) {
    distance[i] = 4. * i / (KNOTS - 1);
    factor[i] = 2 - PetscExpReal(-distance[i]);
  }
  OpenScratch(path);
  WriteScratch(path, 2, name, rank_of, dims, values);
  (void)snprintf(options, sizeof(options),
                 "-growth_type uniform -growth_initial_length 1 -shape_type straight -rod_cells 8 "
                 "-friction_radius 0.1 -rod_stiffness_file %s",
                 path);
  Create(options, &scene, &rod);
  exact = (8 * (Flexibility(scene, s, t + h) - Flexibility(scene, s, t - h)) -
           (Flexibility(scene, s, t + 2 * h) - Flexibility(scene, s, t - 2 * h))) /
          (12 * h);
  CHECK(SceneTwistRate(scene, s, t, &rate));
  EXPECT(PetscAbsReal(rate.flex_t - exact) < 1e-8 * PetscAbsReal(exact), "%.12g, exact %.12g",
         rate.flex_t, exact);
  Destroy(&scene, &rod);
  RemoveFile(path);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestSplits), cmocka_unit_test(TestRough),
                                          cmocka_unit_test(TestStart), cmocka_unit_test(TestShear),
                                          cmocka_unit_test(TestTwistRate)};
MAIN(tests)
