/* A peak between three places at which a level is below 0: found if it comes up to 0, and with few
   looks given up if it cannot.
   test: a peak is found between steps */
#include "harness.h"
#include "tasks/peak.h"

typedef struct {
  PetscReal at, height, width; /* of a bell on -1 */
  int looks;
} Bell;

static PetscErrorCode Level(void *of, PetscReal t, PetscReal *level) {
  Bell *self = (Bell *)of;

  PetscFunctionBegin;
  *level = self->height * PetscExpReal(-PetscSqr((t - self->at) / self->width)) - 1;
  self->looks++;
  PetscFunctionReturn(0);
}

static PetscBool Find(Bell *bell, PetscReal a, PetscReal b, PetscReal c, PeakPlace across[2]) {
  PeakPlace at[3] = {{.t = a}, {.t = b}, {.t = c}};
  PetscBool above;

  for (int k = 0; k < 3; k++) CHECK(Level(bell, at[k].t, &at[k].level));
  bell->looks = 0;
  CHECK(PeakFind(Level, bell, at, across, &above));
  return above;
}

static void Above(void **state) {
  (void)state;
  for (int k = -9; k <= 9; k++) {
    Bell bell = {.at = 5 + 0.05 * k, .height = 1.02, .width = 0.8};
    PeakPlace across[2];
    PetscReal level;
    CHECK(Level(&bell, 5, &level));
    if (level >= 0) continue; /* seen without any search */
    EXPECT(Find(&bell, 4, 5, 6, across), "a peak at %g", (double)bell.at);
    EXPECT(across[0].level < 0 && across[1].level >= 0 && across[0].t < across[1].t, "at %g",
           (double)bell.at);
    for (PetscReal t = 4; t <= across[0].t; t += 1e-3) {
      CHECK(Level(&bell, t, &level));
      EXPECT(level < 0, "at %g: it crosses before %g, at %g", (double)bell.at, (double)across[0].t,
             (double)t);
    }
  }
}

/* It takes several looks to come near to a peak that is all but level with 0. */
static void JustAbove(void **state) {
  (void)state;
  for (int k = -5; k <= 5; k++) {
    Bell bell = {.at = 5 + 0.05 * k + 1e-3, .height = 1 + 1e-5, .width = 0.5};
    PeakPlace across[2];
    EXPECT(Find(&bell, 4.3, 5, 5.8, across), "a peak at %g, %d looks", (double)bell.at, bell.looks);
    EXPECT(bell.looks < 20, "a peak at %g: %d looks", (double)bell.at, bell.looks);
  }
}

static void Below(void **state) {
  Bell low = {.at = 5.2, .height = 0.4, .width = 0.8},
       under = {.at = 5.2, .height = 1 - 1e-6, .width = 0.8};
  PeakPlace across[2];

  (void)state;
  EXPECT(!Find(&low, 4, 5, 6, across) && low.looks == 0, "%d looks", low.looks);
  EXPECT(!Find(&under, 4, 5, 6, across) && under.looks < 40, "%d looks", under.looks);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(Above), cmocka_unit_test(JustAbove),
                                          cmocka_unit_test(Below)};
MAIN(tests)
