/* The critical length against the table of docs/notes/exact-answers.md, its order of convergence
 * and its error bound.
   test: critical lengths are those of the table with their order and bound | ranks 1 3 */
#include "harness.h"
#include "tasks/critical.h"

static PetscReal Find(Critical *critical, const char *format, ...) {
  char text[512];
  Critical own, *at = critical ? critical : &own;
  PetscReal length;
  Scene scene;
  va_list list;

  va_start(list, format);
  vsnprintf(text, sizeof(text), format, list);
  va_end(list);
  SetOptions("%s", text);
  CHECK(SceneCreate(&scene));
  CHECK(CriticalFind(scene, PETSC_FALSE, at));
  CHECK(SceneDestroy(&scene));
  length = at->length;
  if (!critical) CHECK(CriticalDestroy(&own));
  return length;
}

static const struct {
  const char *options;
  PetscReal length, tolerance; /* relative */
} rows[] = {
    {"-friction_beta 0", 1.98635270743047, 1e-8},
    {"-friction_beta 1e-12", 1.98635270743047, 1e-8},
    {"-friction_beta 1e-6", 1.9863534938, 1e-8},
    {"-friction_beta 1e-3", 1.9871337245, 1e-8},
    {"-friction_beta 1e-2", 1.9938850326, 1e-8},
    {"-friction_beta 1e-2 -rod_cells 6000", 1.9938850326, 1e-8}, /* shared among the ranks */
    {"-friction_mu 0.5", 2.0717173057, 1e-8},
    {"-friction_mu 0", 2.17177006749405, 1e-8},
    {"-friction_mu 0 -growth_initial_length 2", 2.17177006749405, 1e-8},
    {"-growth_type gaussian -growth_width 5", 1.98713, 3e-6},
    {"-growth_type gaussian -growth_width 0.5", 1.98698, 3e-6},
    {"-growth_type gaussian -growth_width 0.05", 1.98686, 3e-6},
    {"-growth_type gaussian -growth_width 0.5 -friction_beta 0", 1.98635270743047, 1e-8},
    {"-growth_type gaussian -growth_width 0.005 -friction_beta 1e-12", 1.98635270743047, 1e-8},
    {"-friction_mu 0 -growth_type gaussian -growth_width 5", 2.17105, 3e-6},
    {"-friction_mu 0 -growth_type gaussian -growth_width 0.5", 2.115744753044948, 1e-8},
    {"-friction_mu 0 -growth_type gaussian -growth_width 0.05", 2.056307172441833, 1e-8},
    /* by shooting with an ODE solver at 1e-12 */
    {"-friction_mu 0 -growth_type gaussian -growth_width 0.005", 2.0515888825515565, 1e-8}};

/* Several ranks solve a coarse mesh each for itself, as one does: of these rows some are enough for
   them, and the one of the mesh that they share. */
static void TestTable(void **state) {
  int ranks;

  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  for (size_t k = 0; k<PETSC_STATIC_ARRAY_LENGTH(rows); k += ranks> 1 ? 5 : 1) {
    PetscReal length = Find(NULL, "%s", rows[k].options);
    EXPECT(PetscAbsReal(length - rows[k].length) < rows[k].tolerance * length,
           "%s: %.12g not %.12g", rows[k].options, (double)length, (double)rows[k].length);
  }
}

/* Weight along the rod: (7.837347438943 / (1 + w))^(1/3) where friction is dry; viscous, by an ODE
   solver at 20 digits. Two stiffnesses: the weaker direction decides. A twisting moment: clamped at
   both ends without thrust tan z = z, z = M L / 2B, and with thrust or pull the determinant of the
   four solutions; between two hinges, or a hinge and a clamp, without a moment pi^2 and 4.4934^2,
   with one (M/2B)^2 + P/B = (pi/L)^2 (Greenhill); a heavy rod that stands on a hinge, held above
   (Lubinski, by Hermite elements); its flutter in feed, where P is constant if weight balances
   friction, from that determinant at 25 digits, lambda = i omega. */
#define BALANCED "-friction_beta 0 -rod_weight 1,0 -ts_max_time 40 "
#define HINGED "-clamp_type hinged -tip_type pinned "
#define HEAVY HINGED "-friction_mu 0 -friction_layers 0:1e-12 -rod_weight -1,0 -ts_max_time 20 "
#define FED "-growth_type feed -friction_mu 0 -rod_weight 1,0 -ts_max_time 20 "
static const struct {
  const char *options;
  PetscReal length, frequency;
} world[] = {
    {"-friction_beta 0 -rod_weight -1,0", 1.5765691886775048, 0},
    {"-friction_beta 0 -rod_weight 0.5,0", 2.5026475886072737, 0},
    {"-friction_beta 0 -rod_weight -1,0 -growth_type gaussian -growth_width 0.5",
     1.5765691886775048, 0},
    {"-friction_mu 0 -rod_weight -1,0", 1.6439604994819, 0},
    {"-friction_beta 0 -clamp_angle 90deg -rod_weight 0,-1", 1.5765691886775048, 0},
    {"-friction_beta 0 -clamp_direction 0,0,1 -rod_weight 0,0,-1", 1.5765691886775048, 0},
    {"-friction_beta 0 -tip_force_vector -1,0", 1.3269921240925185, 0},
    {"-friction_beta 0 -rod_bend_ratio 3", 1.98635270743047, 0},
    {"-friction_beta 0 -rod_bend_ratio 0.5", 1.5765691886775048, 0},
    {BALANCED "-tip_type clamped -tip_torque 2", 8.98681891582 / 2, 0},
    {BALANCED "-tip_type clamped -tip_torque -5", 8.98681891582 / 5, 0},
    {BALANCED "-tip_type clamped -tip_torque 3.72550782215 -tip_force 2.5", 2, 0},
    {BALANCED "-tip_type clamped -tip_torque 1.90021481174 -tip_force 7.5", 2, 0},
    {BALANCED "-tip_type clamped -tip_torque 5.21442821965 -tip_force -2.5", 2, 0},
    {BALANCED "-tip_type clamped -clamp_spin 1 -growth_initial_length 1", 1 + 8.98681891582 / 0.75,
     0},
    {BALANCED HINGED "-tip_force 1", PETSC_PI, 0},
    {BALANCED "-clamp_type hinged -tip_type clamped -tip_force 1", 4.493409457909064, 0},
    {BALANCED HINGED "-tip_force 1 -rod_bend_ratio 4", PETSC_PI, 0},
    {BALANCED HINGED "-tip_torque 2", PETSC_PI, 0},
    {BALANCED HINGED "-tip_torque 2.422726645969239 -tip_force 1", 2, 0},
    {BALANCED HINGED "-tip_torque 4.457533443631058 -tip_force -2.5", 2, 0},
    {HEAVY "-tip_force -2.881421311569217 -growth_initial_length 4", 5, 0},
    {HEAVY "-tip_force -18.28895945976756 -growth_initial_length 16", 20, 0},
    {FED "-tip_torque 2", 4.6390669891599, 1.6988328106},
    {FED "-tip_torque 4 -tip_type pinned", 1.8678022060344, 10.559465236},
    {FED "-tip_torque 4 -tip_type clamped", 2.2477505051122, 1.4215174497},
    {FED "-tip_torque 4 -tip_type clamped -rod_cells 5000", 2.2477505051122, 1.4215174497}};

/* Of several ranks each solves a coarse mesh for itself, as one does: they solve the fine one,
   which they share. One rank does the same on either, and solves the coarse ones. */
static void TestWorld(void **state) {
  const size_t last = PETSC_STATIC_ARRAY_LENGTH(world) - 1;
  int ranks;

  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  for (size_t k = ranks == 1 ? 0 : last; ranks == 1 ? k < last : k <= last; k++) {
    Critical c;
    PetscReal length = Find(&c, "%s", world[k].options), wanted = world[k].length;
    EXPECT(PetscAbsReal(length - wanted) < 1e-8 * wanted, "%s: %.12g not %.12g", world[k].options,
           (double)length, (double)wanted);
    EXPECT(PetscAbsReal(c.frequency - world[k].frequency) <= 1e-6 * world[k].frequency,
           "%s: frequency %.12g not %.12g", world[k].options, (double)c.frequency,
           (double)world[k].frequency);
    EXPECT(PetscAbsReal(length - wanted) <= c.error, "%s: off by %g, bound %g", world[k].options,
           (double)(length - wanted), (double)c.error);
    CHECK(CriticalDestroy(&c));
  }
}

/* Both directions of a rod of two stiffnesses, and the mode in that of the weaker. */
static void TestDirections(void **state) {
  Critical c;

  Find(&c, "-friction_beta 0 -rod_bend_ratio 8 -rod_cells 200");
  EXPECT(c.way == WAY_X3 && c.ways == 2 && c.follows, "way %d of %d", (int)c.way, (int)c.ways);
  EXPECT(PetscAbsReal(c.other[1] - 2 * c.length) < 1e-8, "%.12g after %.12g", (double)c.other[1],
         (double)c.length);
  for (PetscInt i = 0; i < c.n; i++)
    EXPECT(c.y[i] == 0 && c.theta[i] == 0, "x2 %g at %d", (double)c.y[i], (int)i);
  EXPECT(c.y3[200] == 1 && c.theta3[0] < 1e-12, "x3 %g at the tip", (double)c.y3[200]);
  CHECK(CriticalDestroy(&c));
}

/* Clamped at both ends and twisted, with v = s - 1/2 and z = M L: the mode is cos z v - cos z/2 + z
   sin z/2 (v^2 - 1/4) + i (sin z v - z v cos z/2). */
static void TestTwistedMode(void **state) {
  const PetscReal z = 8.98681891582;
  PetscReal worst = 0, most = 0, turn[2];
  PetscInt cells = 200, top = 0;
  Critical c;
  int ranks;

  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1) return; /* each would do the same */
  Find(&c, BALANCED "-tip_type clamped -tip_torque 2 -rod_cells %d", (int)cells);
  for (int pass = 0; pass < 2; pass++)
    for (PetscInt i = 0; i <= cells; i++) {
      PetscReal v = c.s[i] - 0.5,
                re = PetscCosReal(z * v) - PetscCosReal(z / 2) +
                     z * PetscSinReal(z / 2) * (v * v - 1. / 4),
                im = PetscSinReal(z * v) - z * v * PetscCosReal(z / 2);
      PetscReal size = PetscSqrtReal(re * re + im * im);
      if (!pass && size > most) {
        most = size;
        top = i;
        turn[0] = re / size;
        turn[1] = im / size;
      }
      if (!pass) continue;
      worst = PetscMax(worst, PetscAbsReal((turn[0] * re + turn[1] * im) / most - c.y[i]));
      worst = PetscMax(worst, PetscAbsReal((turn[0] * im - turn[1] * re) / most - c.y3[i]));
    }
  EXPECT(worst < 1e-6, "off by %g, largest at %d", (double)worst, (int)top);
  CHECK(CriticalDestroy(&c));
}

/* Feed flutters, with either friction; nothing happens near 1.986. */
static void TestFeed(void **state) {
  const char *const frictions[] = {"-friction_mu 0", "-friction_mu 1 -friction_beta 0"};

  for (int k = 0; k < 2; k++) {
    Critical c;
    PetscReal length = Find(&c, "-growth_type feed %s", frictions[k]);
    EXPECT(PetscAbsReal(length - 4.23772) < 1e-5, "flutter at %.10g", (double)length);
    EXPECT(PetscAbsReal(c.frequency - 0.60958) < 1e-5, "frequency %.8g", (double)c.frequency);
    CHECK(CriticalDestroy(&c));
  }
}

/* Order 4 in the cells, asserted from the finest pair that rounding leaves alone; and the bound
   holds on every mesh. */
static void TestOrder(void **state) {
  const PetscReal greenhill = 1.98635270743047;
  const int cells[] = {16, 32, 64, 128};
  PetscReal error[4];

  for (int k = 0; k < 4; k++) {
    Critical c;
    error[k] = PetscAbsReal(Find(&c, "-friction_beta 0 -rod_cells %d", cells[k]) - greenhill);
    EXPECT(error[k] <= c.error, "%d cells: off by %g, bound %g", cells[k], (double)error[k],
           (double)c.error);
    EXPECT(c.error < 100 * error[k] + 1e-12, "%d cells: off by %g, bound %g", cells[k],
           (double)error[k], (double)c.error);
    CHECK(CriticalDestroy(&c));
  }
  EXPECT(PetscAbsReal(Order(error[2], error[3]) - 4) < 0.1, "order %g",
         (double)Order(error[2], error[3]));
}

/* The mode obeys the clamp, the free tip and its scale. */
static void TestMode(void **state) {
  Critical c;
  PetscReal most = 0;

  Find(&c, "-growth_type gaussian -growth_width 0.2 -rod_cells 200");
  for (PetscInt i = 0; i < c.n; i++) most = PetscMax(most, PetscAbsReal(c.y[i]));
  EXPECT(c.n == 201 && c.s[0] == 0 && c.s[200] == 1, "labels");
  EXPECT(PetscAbsReal(most - 1) < 1e-14 && c.y[200] > 0.99, "scale %g", (double)most);
  EXPECT(PetscAbsReal(c.y[0]) < 1e-14 && PetscAbsReal(c.theta[0]) < 1e-14, "clamp");
  EXPECT(PetscAbsReal(c.theta[200] - c.theta[199]) < 1e-4, "curvature at the tip");
  CHECK(CriticalDestroy(&c));
}

/* A tabulated law: growth that stops half-way, and goes on, must be followed through the pause. */
static PetscReal Pausing(PetscReal s, PetscReal t) {
  return t < 1 ? 0.5 + t - t * t / 2 : 1 + PetscSqr(t - 1) / 2;
}

static void TestTableOfGrowth(void **state) {
  char path[64];
  PetscReal length, rate;

  WriteTable(path, 5, 401, 4, Pausing);
  length = Find(NULL, "-growth_type table -growth_table %s -ts_max_time 4 -friction_mu 0", path);
  RemoveFile(path);
  rate = PetscSqrtReal(2 * (length - 1)); /* viscous friction: L_t L^3 is what counts */
  EXPECT(PetscAbsReal(rate * length * length * length - 10.24333861) < 1e-4, "L_t L^3 = %g",
         (double)(rate * length * length * length));
}

/* theta = dy/dp of the mode, also where it comes from the Sturm-Liouville problem for w alone. */
static void TestModeAngle(void **state) {
  const char *const laws[] = {"uniform", "gaussian -growth_width 0.2", "feed"};

  for (int k = 0; k < 3; k++) {
    PetscReal worst = 0;
    Critical c;
    Scene scene;
    Find(&c, "-growth_type %s -rod_cells 200", laws[k]);
    CHECK(SceneCreate(&scene));
    for (PetscInt i = 0; i < 200; i++) {
      PetscReal p[2];
      CHECK(GrowthArc(scene->growth, 2, c.s + i, c.t, p, NULL));
      worst = PetscMax(worst, PetscAbsReal(c.y[i + 1] - c.y[i] -
                                           (c.theta[i] + c.theta[i + 1]) / 2 * (p[1] - p[0])));
    }
    EXPECT(worst < 1e-6, "%s: y and theta differ by %g", laws[k], (double)worst);
    CHECK(SceneDestroy(&scene));
    CHECK(CriticalDestroy(&c));
  }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestTable),       cmocka_unit_test(TestFeed),
    cmocka_unit_test(TestWorld),       cmocka_unit_test(TestDirections),
    cmocka_unit_test(TestTwistedMode), cmocka_unit_test(TestOrder),
    cmocka_unit_test(TestMode),        cmocka_unit_test(TestTableOfGrowth),
    cmocka_unit_test(TestModeAngle)};

MAIN(tests)
