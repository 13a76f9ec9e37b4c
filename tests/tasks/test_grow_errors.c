/* What is told of a start that steps have crossed unseen, by how far they have led.
   test: errors that are told are those of known histories */
#include "harness.h"
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

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestOneStep),
                                          cmocka_unit_test(TestLayer)};
MAIN(tests)
