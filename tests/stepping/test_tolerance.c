/* The tolerance of steps, as it follows told errors of steps and of contact.
   test: the tolerance follows what contact puts a rod off by */
#include "harness.h"
#include "stepping/tolerance.h"

enum { STEPS = 60 };

/* How many times the tolerance is eased behind so many steps with such errors. */
static PetscReal Follow(Ease *ease, PetscReal steps, PetscReal contact) {
  PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN] = {{0}};

  part[ESTIMATE_TIME][ESTIMATE_TIP] = steps;
  part[ESTIMATE_SOFT][ESTIMATE_ENERGY] = contact;
  for (int k = 0; k < STEPS; k++)
    ToleranceFollow(1e-5, (const PetscReal(*)[ESTIMATE_SEEN])part, ease);
  return ease->times;
}

static void TestFollows(void **state) {
  Ease ease = {.most = 10, .wants = 1, .times = 1};

  EXPECT(Follow(&ease, 1e-6, 1e-3) == 10, "small errors of steps: %g", ease.times);
  EXPECT(Follow(&ease, 1e-3, 1e-4) == 1, "large ones: %g", ease.times);
}

/* Errors that are too large for a ratio: the tolerance rises where contact's are no less, else it
   stays. */
static void TestUnknown(void **state) {
  Ease ease = {.most = 10, .wants = 1, .times = 1};

  EXPECT(Follow(&ease, 0.5, 0.1) == 1, "steps' are larger: %g", ease.times);
  EXPECT(Follow(&ease, 0.1, 0.5) == 10, "contact's are: %g", ease.times);
  EXPECT(Follow(&ease, 0.5, 0.1) == 10, "steps' are again: %g", ease.times);
}

/* Steps whose errors go with their tolerance as those of order 6 do, beside contact that is off by
   this: what is wanted behind so many. */
static PetscReal Settle(Ease *ease, PetscReal contact, int steps) {
  const PetscReal rtol = 1e-5;
  PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN] = {{0}};

  part[ESTIMATE_SOFT][ESTIMATE_ENERGY] = contact;
  for (int k = 0; k < steps; k++) {
    part[ESTIMATE_TIME][ESTIMATE_TIP] = rtol * PetscPowReal(ease->wants, 6. / 7);
    ToleranceFollow(rtol, (const PetscReal(*)[ESTIMATE_SEEN])part, ease);
  }
  return ease->wants;
}

/* The tolerance comes to rest where errors of steps are a third of contact's, about; it rises and
   falls to there by a little from step to step, and does not swing about it. */
static void TestSettles(void **state) {
  const PetscReal contact = 1e-4, third = PetscPowReal(contact / 3 / 1e-5, 7. / 6);
  Ease fine = {.most = 100, .wants = 1, .times = 1},
       coarse = {.most = 100, .wants = 100, .times = 100, .others = contact};
  PetscReal after;

  (void)state;
  after = Settle(&fine, contact, 3);
  EXPECT(after > 1.3 && after < 2, "rises in 3 steps to %g", (double)after);
  after = Settle(&coarse, contact, 3);
  EXPECT(after < 90 && after > 50, "falls in 3 steps from 100 to %g", (double)after);
  Settle(&fine, contact, 30);
  Settle(&coarse, contact, 60);
  EXPECT(fine.wants > 0.7 * third && fine.wants < 1.1 * third, "rises to %g of %g",
         (double)fine.wants, (double)third);
  EXPECT(coarse.wants > 0.7 * third && coarse.wants < 1.1 * third, "falls to %g of %g",
         (double)coarse.wants, (double)third);
  after = fine.wants;
  EXPECT(PetscAbsReal(Settle(&fine, contact, 1) - after) < 1e-2 * after, "swings from %g to %g",
         (double)after, (double)fine.wants);
}

/* What contact puts the rod off by passes through 0 and is not forgotten for that; once it touches
   nothing any more, it is. */
static void TestForgets(void **state) {
  Ease ease = {.most = 10, .wants = 1, .times = 1};

  (void)state;
  Follow(&ease, 1e-6, 1e-3);
  Settle(&ease, 0, 3);
  EXPECT(ease.times > 5, "behind 3 steps: %g", (double)ease.times);
  Settle(&ease, 0, 300);
  EXPECT(ease.times == 1, "behind 300: %g", (double)ease.times);
}

/* Errors that differ by round-off, as they do on other numbers of ranks, give steps of the same
   tolerance: it has some levels in a factor of 10, and few. */
static void TestLevels(void **state) {
  int levels = 1;
  PetscReal before = 1;

  (void)state;
  for (int k = 0; k < 900; k++) {
    Ease ease = {.most = 100, .wants = 1 + k / 100., .times = 1, .holds = PETSC_TRUE};
    const PetscReal part[ESTIMATE_PARTS][ESTIMATE_SEEN] = {
        [ESTIMATE_TIME] = {1e-5}, [ESTIMATE_SOFT] = {1e-5 / 0.3}};
    ToleranceFollow(1e-5, part, &ease);
    levels += ease.times > before;
    before = ease.times;
  }
  EXPECT(levels > 2 && levels < 10, "%d levels", levels);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestFollows), cmocka_unit_test(TestUnknown), cmocka_unit_test(TestSettles),
    cmocka_unit_test(TestForgets), cmocka_unit_test(TestLevels)};
MAIN(tests)
