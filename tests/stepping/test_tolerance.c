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

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestFollows),
                                          cmocka_unit_test(TestUnknown)};
MAIN(tests)
