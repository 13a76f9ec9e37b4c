/* Several rods are run again, finer, until their errors are as asked for.
   test: a run of several rods is repeated as long as that helps */
#include "harness.h"
#include "base/words.h"
#include "tasks/several_run.h"

static struct _Rod rod = {.order = 4};
static Finer finer;
static Grow each;

/* A run whose errors, all by its steps, are above what was asked for. */
static void Create(OptionWords *words, Run *self) {
  char fault[WORDS_FAULT] = "", text[] = "[rod one]\n-growth_initial_length 1\n";

  SetOptions("-growth_type feed");
  *words = (OptionWords){0};
  EXPECT(WordsAddText(words, "here", text, fault), "%s", fault);
  finer = (Finer){.cells = 20, .cells_given = PETSC_TRUE, .stiffness_given = PETSC_TRUE};
  each = (Grow){.error = {.kind = ESTIMATE_MEASURED}};
  each.now = &each.leg[SPACE];
  each.now->rod = &rod;
  *self = (Run){.n = 1,
                .each = &each,
                .finer = &finer,
                .restart = "",
                .quiet = PETSC_TRUE,
                .accuracy = 1e-3,
                .rtol = 1e-4,
                .eased = 1e-4,
                .leg = {.rod = &rod}};
  CHECK(RodsRead(words, &self->rods));
}

static void Destroy(OptionWords *words, Run *self) {
  CHECK(RodsDestroy(&self->rods));
  WordsFree(words);
}

/* Is it to be run again, with an error of so many times what was asked for? */
static PetscBool Again(Run *self, PetscReal times) {
  PetscBool again;

  each.error.end.all = each.error.end.part[ESTIMATE_TIME] = times * self->accuracy;
  CHECK(RunRefine(self, &again));
  return again;
}

/* It is repeated while each run is much nearer than the one before, some times at most; not where a
   finer run is hardly nearer. */
static void TestHelps(void **state) {
  PetscReal times = 1e10;
  PetscInt runs = 0;
  OptionWords words;
  Run self;

  (void)state;
  Create(&words, &self);
  for (; times > 1 && Again(&self, times); times *= 0.45) runs++;
  EXPECT(runs > 3 && runs < 20, "%d runs", (int)runs);
  Destroy(&words, &self);
  Create(&words, &self);
  EXPECT(!Again(&self, 0.9), "as near as asked for");
  EXPECT(Again(&self, 100), "not as near");
  EXPECT(!Again(&self, 80), "hardly nearer");
  Destroy(&words, &self);
}

/* What a coarse run is told to be off by is no measure of how fine the next is to be: that is finer
   by some, whatever it says. */
static void TestFiner(void **state) {
  PetscReal rtol;
  OptionWords words;
  Run self;

  (void)state;
  Create(&words, &self);
  EXPECT(Again(&self, 1e6), "far off");
  CHECK(OptionReal("-ts_rtol", &rtol, NULL));
  EXPECT(rtol < self.rtol / 4 && rtol > self.rtol / 100, "from %g to %g", (double)self.rtol,
         (double)rtol);
  Destroy(&words, &self);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestHelps), cmocka_unit_test(TestFiner)};
MAIN(tests)
