/* When a run is called jammed, or to slip without end: by what its latest steps have come to.
   test: a run that is stuck says why */
#include "harness.h"
#include "tasks/growing.h"

static struct _Growth growth; /* that feels no force */

/* A rod of length 3 that touches, and is pressed by so many times the usual force of 1. */
static Observation Pressed(PetscReal force) {
  return (Observation){.length = 3, .contacts = 1, .contact_force = force};
}

/* The step, of this size, at which the run is called jammed; 0: not in so many. */
static PetscInt JamsAt(Grow *self, PetscReal step, PetscInt most) {
  for (PetscInt k = 1; k <= most; k++) {
    self->kept.way += step;
    if (GrowIsJammed(self)) return k;
  }
  return 0;
}

/* Wedged rods chatter on, and add up to 2e-5 in a thousand steps; others get on, if slowly. */
static void TestJamGetsNowhere(void **state) {
  struct _Scene scene = {.growth = &growth,
                         .contact = {.any = PETSC_TRUE, .diameter = 0.1, .force = 1}};
  Grow wedged = {.scene = &scene, .seen = Pressed(20)}, slow = wedged, calm = wedged, off = wedged;
  PetscInt at = JamsAt(&wedged, 2e-8, 3000);

  EXPECT(at > 900 && at < 1100, "chatters: jammed after %d steps", (int)at);
  at = JamsAt(&slow, 1e-7, 3000);
  EXPECT(!at, "gets on by 1e-4 in a thousand steps: jammed after %d", (int)at);
  calm.seen.contact_force = 5;
  at = JamsAt(&calm, 0, 3000);
  EXPECT(!at, "pressed with usual forces: jammed after %d", (int)at);
  off.seen.contacts = 0;
  at = JamsAt(&off, 0, 3000);
  EXPECT(!at, "touches nothing: jammed after %d", (int)at);
}

/* Deep in a wall under large forces it is jammed at once; deep in one that is soft it is not. A
   wall that gets firmer lets no force press the rod in so far. */
static void TestJamDeep(void **state) {
  struct _Scene thick = {.growth = &growth,
                         .contact = {.any = PETSC_TRUE, .diameter = 0.1, .force = 1, .tip = 1e-3}},
                firm = {.growth = &growth,
                        .contact = {.any = PETSC_TRUE,
                                    .firm = PETSC_TRUE,
                                    .self = PETSC_TRUE,
                                    .diameter = 0.1,
                                    .force = 1,
                                    .tip = 1e-3,
                                    .stiffness = 1e5,
                                    .smooth = 2e-4}},
                thin = {.growth = &growth, .contact = {.any = PETSC_TRUE, .force = 1, .tip = 0.1}};
  const struct {
    Scene scene;
    PetscReal force, depth;
    PetscBool jams;
  } rods[] = {{&thick, 20, 0.03, PETSC_TRUE},  {&thick, 20, 0.01, PETSC_FALSE},
              {&thick, 5, 0.03, PETSC_FALSE},  {&firm, 20, 0.003, PETSC_TRUE},
              {&firm, 20, 0.001, PETSC_FALSE}, {&firm, 5, 0.003, PETSC_FALSE},
              {&thin, 20, 0.3, PETSC_TRUE},    {&thin, 20, 0.1, PETSC_FALSE}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rods); k++) {
    Grow self = {.scene = rods[k].scene, .seen = Pressed(rods[k].force)};
    self.seen.penetration = rods[k].depth;
    EXPECT(GrowIsJammed(&self) == rods[k].jams, "%d: pressed by %g, %g deep", (int)k,
           (double)rods[k].force, (double)rods[k].depth);
  }
}

/* The step, of this size, at which a run is told to slip; 0: not in so many. */
static PetscInt SlipsAt(Grow *self, PetscReal step, PetscInt most) {
  for (PetscInt k = 1; k <= most; k++) {
    self->kept.way += step;
    if (GrowSlips(self)) return k;
  }
  return 0;
}

/* Weak friction across is given a viscous share, tenfold more as long as it slips, up to a
   hundredth: with that it has five times as many steps to get on by a hundredth of the run. */
static void TestSlips(void **state) {
  struct _Scene scene = {.end_time = 10, .load = {.across = 2, .friction = {.mu = 1}}};
  Grow self = {.scene = &scene};
  PetscInt at = SlipsAt(&self, 0, 3000);

  EXPECT(!at, "strong friction across: slips after %d steps", (int)at);
  scene.load.across = 0.5;
  at = SlipsAt(&self, 0, 3000);
  EXPECT(at > 300 && at < 500, "gets nowhere: slips after %d steps", (int)at);
  for (PetscReal share = 1e-4; share < 0.05; share *= 10) {
    const PetscInt most = share < 5e-3 ? 500 : 2500;
    EXPECT(LoadShareMore(&scene.load), "no share of %g", (double)share);
    EXPECT(PetscAbsReal(1 - scene.load.friction.mu - share) < 1e-3 * share, "a share of %g, not %g",
           1 - (double)scene.load.friction.mu, (double)share);
    at = SlipsAt(&self, 1e-5, 5000);
    EXPECT(at > most / 2 && at < most, "share %g: slips after %d steps", (double)share, (int)at);
    at = SlipsAt(&self, 1e-3, 5000);
    EXPECT(!at, "share %g, gets on: slips after %d steps", (double)share, (int)at);
  }
  EXPECT(!LoadShareMore(&scene.load), "a share of %g", 1 - (double)scene.load.friction.mu);
  scene.load = (Load){.across = 2, .friction = {.mu = 1}};
  EXPECT(!LoadShareMore(&scene.load), "a share though friction across is strong");
}

/* Dry friction has a least viscous share, as a part of what it is at the speed at which the rod
   grows, but nothing of it at that speed; what has more of its own, or is given more, none. */
static void TestLeast(void **state) {
  const struct {
    PetscReal mu, speed, share;
  } rods[] = {{1, 1, 1e-6}, {1, 1e3, 1e-9}, {1 - 1e-7, 1, 1e-6}, {0.999, 1, 1e-3}, {0, 1, 1}};

  for (size_t k = 0; k < sizeof(rods) / sizeof(rods[0]); k++) {
    const PetscReal asked = 1 - rods[k].mu, u = rods[k].speed;
    Load load = {.across = 1, .friction = {.mu = rods[k].mu, .viscous = asked}, .viscous = asked};
    PetscReal fast, slow;
    LoadShareLeast(&load, u);
    fast = FrictionViscous(&load.friction, PetscSqr(1e3 * u));
    slow = FrictionViscous(&load.friction, u * u);
    EXPECT(PetscAbsReal(fast / rods[k].share - 1) < 1e-3, "%d: fast %g", (int)k, (double)fast);
    EXPECT(slow - asked < 0.02 * rods[k].share, "%d: slow %g", (int)k, (double)slow);
    EXPECT(load.friction.mu == rods[k].mu && !load.shared, "%d: dry %g", (int)k,
           (double)load.friction.mu);
    LoadShare(&load, 1e-2);
    LoadShareLeast(&load, u);
    fast = FrictionViscous(&load.friction, PetscSqr(1e3 * u));
    EXPECT(PetscAbsReal(fast / 1e-2 - 1) < 1e-12, "%d: given 1e-2, has %g", (int)k, (double)fast);
  }
}

/* A rod that a wall which rubs presses on is held twice where friction along it is dry, too, or all
   but: not by walls or by friction alone. */
static void TestHeldTwice(void **state) {
  struct _Scene scene = {.contact.walls.rub = PETSC_TRUE, .load.friction.mu = 1};
  Grow self = {.scene = &scene, .seen = Pressed(1)};

  EXPECT(GrowHeldTwice(&self), "dry");
  scene.load.friction.mu = 1 - 1e-4;
  EXPECT(GrowHeldTwice(&self), "a share of 1e-4");
  scene.load.friction.mu = 1 - 1e-2;
  EXPECT(!GrowHeldTwice(&self), "a share of 1e-2");
  scene.load.friction.mu = 1;
  self.seen.contact_force = 0;
  EXPECT(!GrowHeldTwice(&self), "touches nothing");
  self = (Grow){.scene = &scene, .seen = Pressed(1)};
  scene.contact.walls.rub = PETSC_FALSE;
  EXPECT(!GrowHeldTwice(&self), "smooth walls");
}

/* By how much of its step a run gets on in which the tip moves so many times as fast as it grows.
 */
static PetscReal GetsOn(PetscReal times) {
  Grow self = {0};
  PetscScalar *v;
  PetscReal on;

  SetOptions("-growth_type feed -growth_initial_length 1 -rod_cells 6 -ts_max_time 1 -quiet");
  CHECK(SceneCreate(&self.scene));
  CHECK(GrowCreate(&self, "", ""));
  CHECK(TSStep(self.now->ts));
  CHECK(VecGetArray(self.now->newton.latest.U_t, &v));
  v[self.now->rod->model->fields * self.now->rod->last + 1] = times * self.scene->units.speed;
  CHECK(VecRestoreArray(self.now->newton.latest.U_t, &v));
  CHECK(GrowAfterStep(self.now->ts));
  on = self.kept.way / self.seen.step;
  CHECK(GrowDestroy(&self));
  CHECK(SceneDestroy(&self.scene));
  return on;
}

/* A rod that snaps gets on by its motion, while time all but stands still; one that moves about as
   fast as it grows does not get on faster by that. */
static void TestMotionCounts(void **state) {
  PetscReal on = GetsOn(1);

  EXPECT(on >= 1 && on < 2, "as fast as it grows: %g", (double)on);
  on = GetsOn(1e4);
  EXPECT(on > 200 && on < 1e4, "ten thousand times: %g", (double)on);
}

/* Jumps in the layer of a start out of balance are none of the rod: it has given way; behind it, it
   snaps. */
static void TestLayer(void **state) {
  for (int k = 0; k < 2; k++) {
    Grow self = {0};
    SetOptions("-growth_type feed -growth_initial_length 1 -rod_cells 6 -ts_max_time 1 -quiet");
    CHECK(SceneCreate(&self.scene));
    CHECK(GrowCreate(&self, "", ""));
    CHECK(TSStep(self.now->ts));
    self.now->jumps = -1; /* as if the step had been one */
    CHECK(GrowObserve(&self, (k ? 3e-5 : 1e-8) * self.scene->units.brief, self.now->U,
                      self.now->newton.latest.U_t));
    EXPECT(self.kept.gave_way == !k && self.kept.snaps == k, "%d: gave way %g, snaps %g", k,
           (double)self.kept.gave_way, (double)self.kept.snaps);
    CHECK(GrowDestroy(&self));
    CHECK(SceneDestroy(&self.scene));
  }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestJamGetsNowhere), cmocka_unit_test(TestJamDeep),
    cmocka_unit_test(TestSlips),          cmocka_unit_test(TestLeast),
    cmocka_unit_test(TestHeldTwice),      cmocka_unit_test(TestMotionCounts),
    cmocka_unit_test(TestLayer)};
MAIN(tests)
