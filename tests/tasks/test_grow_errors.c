/* What is told of a start that steps have crossed unseen, by how far they have led.
   test: errors that are told are those of known histories */
#include "harness.h"
#include "stepping/estimating.h"
#include "tasks/growing.h"

/* A run that has come from a tip at 1 to one that is off by so much, at a time. */
static Grow Moved(PetscReal by, PetscReal t) {
  Grow self = {.seen = {.t = t, .tip_x1 = 1, .tip_x2 = by, .norm_x2 = 1, .length = 1}};
  return self;
}

static const Observation start = {.tip_x1 = 1, .norm_x2 = 1, .length = 1};

static void TestOneStep(void **state) {
  Grow near = Moved(1e-3, 1), some = Moved(0.4, 1), far = Moved(0.7, 1), late = Moved(0.7, 1);

  GrowCross(&near, &start, 0, PETSC_FALSE);
  EXPECT(PetscAbsReal(near.kept.crossed - 2e-3) < 1e-8, "a change of 1e-3: %g",
         (double)near.kept.crossed);
  GrowCross(&some, &start, 0, PETSC_FALSE);
  EXPECT(some.kept.crossed == 1e-2 && some.kept.crossings == 1, "of 0.4: %g",
         (double)some.kept.crossed);
  GrowCross(&far, &start, 0, PETSC_FALSE);
  EXPECT(far.kept.crossed == 1, "of 0.7: %g", (double)far.kept.crossed);
  GrowCross(&late, &start, 0.6, PETSC_FALSE);
  EXPECT(late.kept.crossed == 0 && late.kept.crossings == 0, "a late jump: %g",
         (double)late.kept.crossed);
}

/* In the layer of a start it is how far all steps have led that counts. */
static void TestLayer(void **state) {
  Grow self = Moved(0.4, 1e-9), side = Moved(0, 1e-9);
  Observation last;

  GrowCross(&self, &start, 0, PETSC_TRUE);
  EXPECT(self.kept.crossed == 0 && self.kept.crossings == 0, "not far: %g",
         (double)self.kept.crossed);
  last = self.seen;
  self.seen.tip_x2 = 0.8;
  GrowCross(&self, &last, 1e-9, PETSC_TRUE);
  EXPECT(self.kept.crossed == 1, "far in two steps: %g", (double)self.kept.crossed);
  side.seen.norm_x2 = 0.5; /* the tip where it was, the rod not */
  GrowCross(&side, &start, 0, PETSC_TRUE);
  EXPECT(side.kept.crossed == 1, "a norm that is half as large: %g", (double)side.kept.crossed);
}

static const PetscReal rtol = 1e-6;

/* A run of a rod in the plane; follows: with an estimate of its errors, of which nothing is known
   yet. */
static void Create(PetscBool follows, Grow *self) {
  *self = (Grow){.model = FRAME, .rtol = rtol};
  SetOptions("-rod_cells 16 -ts_max_time 2 -growth_type feed -growth_initial_length 1");
  CHECK(SceneCreate(&self->scene));
  CHECK(LegCreate(self->scene, &rod_frame, rtol, &self->leg[FRAME]));
  self->now = &self->leg[FRAME];
  self->now->ease.times = 1;
  if (follows) CHECK(EstimateCreate(self->now, &self->estimate));
  self->seen = (Observation){.t = 1, .length = 1, .tip_x1 = 1, .tip_x2 = 0.1, .norm_x2 = 0.1};
}

static void Destroy(Grow *self) {
  CHECK(EstimateDestroy(&self->estimate));
  CHECK(LegDestroy(self->now));
  CHECK(SceneDestroy(&self->scene));
}

/* All that is told where errors are not followed. */
static PetscReal Fitted(Grow *self) {
  CHECK(GrowErrors(self));
  return self->error.end.all;
}

/* A viscous share that friction was given adds more than it is, for norms change by more, and so
   does the least one where a jump was crossed with it; exact friction that is taken as a limit
   behind a growth zone goes with the sixth root of its beta. */
static void TestBeside(void **state) {
  PetscReal none, all;
  Load *load;
  Grow self;

  (void)state;
  Create(PETSC_FALSE, &self);
  load = &self.scene->load;
  none = Fitted(&self);
  load->shared = PETSC_TRUE;
  load->friction.viscous = 1e-3;
  all = Fitted(&self);
  EXPECT(all > none + 2e-3 && all < none + 5e-2, "share 1e-3: %g and %g", none, all);
  load->shared = PETSC_FALSE;
  load->friction.viscous = 0;
  load->friction.least = 1e-3;
  self.scene->units.speed = 1;
  EXPECT(Fitted(&self) == none, "no jump: %g", self.error.end.all);
  self.kept.snaps = 1;
  all = Fitted(&self);
  EXPECT(all > none + 2e-3 && all < none + 1e-1, "a jump: %g and %g", none, all);
  self.kept.snaps = 0;
  load->limit = PETSC_TRUE;
  load->friction.beta = 1e-12;
  all = Fitted(&self);
  EXPECT(all > none + 0.1 && all < none + 1, "beta 1e-12: %g and %g", none, all);
  Destroy(&self);
}

/* The tip of a straight rod is where its length has it, nearly to the last digit, whatever the
   tolerance of what is across. */
static void TestLeastTip(void **state) {
  Grow self;

  (void)state;
  Create(PETSC_TRUE, &self);
  CHECK(GrowErrors(&self));
  EXPECT(self.error.end.seen[ESTIMATE_TIP] > 0.05 * rtol, "bent: %g",
         self.error.end.seen[ESTIMATE_TIP]);
  self.seen.tip_x2 = self.seen.norm_x2 = 0;
  CHECK(GrowErrors(&self));
  EXPECT(self.error.end.seen[ESTIMATE_TIP] < 1e-4 * rtol &&
             self.error.end.seen[ESTIMATE_TIP] > 1e-8 * rtol,
         "straight: %g", self.error.end.seen[ESTIMATE_TIP]);
  EXPECT(self.error.end.seen[ESTIMATE_NORM] >= rtol, "x2: %g", self.error.end.seen[ESTIMATE_NORM]);
  Destroy(&self);
}

/* Contact of stiffness k that puts the tip off by d k^(-3/4), as depths go, would not if it were
   rigid: that is as far as k dU/dk says. */
static void TestRigid(void **state) {
  const PetscReal d = 1e-3, by_ln_k = 0.75 * d; /* of the way to where it is rigid */
  Grow self;

  (void)state;
  Create(PETSC_TRUE, &self);
  self.estimate->rigid[RIGID_TIP + 1] = by_ln_k;
  CHECK(GrowErrors(&self));
  EXPECT(PetscAbsReal(self.error.rigid[RIGID_TIP + 1] - (self.seen.tip_x2 + d)) < 1e-12,
         "x2 of the tip: %g", self.error.rigid[RIGID_TIP + 1]);
  Destroy(&self);
}

/* The estimate says so at t, of all that is seen. */
static void Follow(Grow *self, PetscReal t, PetscReal error, PetscInt contacts, PetscReal speed) {
  const Observation last = self->seen;

  self->seen.t = t;
  self->seen.contacts = contacts;
  self->seen.tip_speed = speed;
  for (int k = 0; k < ESTIMATE_SEEN; k++) self->estimate->now[ESTIMATE_TIME][k] = error;
  GrowFollowErrors(self, &last, PETSC_FALSE);
}

/* What an error that is the largest just behind a touch comes of. */
static int ReasonAt(PetscReal before, PetscReal touches, PetscReal largest) {
  Grow self;
  int why;

  Create(PETSC_TRUE, &self);
  Follow(&self, before, 1e-5, 0, 0);
  Follow(&self, touches, 1e-5, 1, 0);
  Follow(&self, largest, 1e-3, 1, 0);
  CHECK(GrowErrors(&self));
  why = self.error.why[ESTIMATE_NORM];
  Destroy(&self);
  return why;
}

/* The reason of an error is what has happened just before; what happened long before is none. */
static void TestReason(void **state) {
  int why = ReasonAt(0.9, 1, 1.01);

  (void)state;
  EXPECT(why == WHY_TOUCH, "just behind a touch: %d", why);
  why = ReasonAt(0.9, 1, 1.2);
  EXPECT(why == ESTIMATE_TIME, "long behind it: %d", why);
}

/* A rod that would move by its length in a small part of the time so far jumps; one that takes a
   fifth of it does not. */
static void TestJumps(void **state) {
  Grow self;

  (void)state;
  Create(PETSC_TRUE, &self);
  Follow(&self, 1, 1e-5, 0, 5);
  EXPECT(self.kept.event_is == 0, "speed 5: %g", self.kept.event_is);
  Follow(&self, 1.1, 1e-5, 0, 500);
  EXPECT(self.kept.event_is == WHY_SNAP, "speed 500: %g", self.kept.event_is);
  Destroy(&self);
}

/* How far off the run is told to be at the end, where errors were 1 at t = 1, and fade; a wall is
   touched at another time. */
static PetscReal AtTheEnd(PetscReal before, PetscReal touches) {
  PetscReal end;
  Grow self;

  Create(PETSC_TRUE, &self);
  Follow(&self, 0.2, before, 0, 0);
  Follow(&self, 0.5, before, 0, 0);
  Follow(&self, 1, 1, 0, 0);
  Follow(&self, touches, 1e-5, 1, 0);
  Follow(&self, 1.9, 1e-5, 1, 0);
  end = self.error.end.seen[ESTIMATE_NORM];
  Destroy(&self);
  return end;
}

/* Errors that grow to 1 while nothing happens say that the rod may have gone to another side: that
   is told to the end. Not if they were large all along, nor if a wall that is touched at once
   explains them. */
static void TestSide(void **state) {
  PetscReal end = AtTheEnd(1e-5, 1.05);

  (void)state;
  EXPECT(end >= 1, "a touch long behind it: %g", end);
  end = AtTheEnd(1e-5, 1 + 3e-4);
  EXPECT(end < 1e-3, "at once: %g", end);
  end = AtTheEnd(0.1, 1.05);
  EXPECT(end < 1e-3, "large all along: %g", end);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestOneStep),  cmocka_unit_test(TestLayer), cmocka_unit_test(TestBeside),
    cmocka_unit_test(TestLeastTip), cmocka_unit_test(TestRigid), cmocka_unit_test(TestReason),
    cmocka_unit_test(TestJumps),    cmocka_unit_test(TestSide)};
MAIN(tests)
