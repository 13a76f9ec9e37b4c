/* When a run crawls, and what looks like it and does not.
   test: a run that crawls is told from what looks like it */
#include "harness.h"
#include "tasks/crawl.h"
#include "tasks/grow_rules.h"

typedef struct {
  PetscReal t, length, end;
  PetscInt iterations; /* of each step */
  Crawl crawl;
} Run;

/* Takes steps, each so many times as long as the one before, from a first one on; after how many
   the run crawls, 0: not in as many as there are. */
static int Crawls(Run *self, PetscReal step, PetscReal times, int steps) {
  for (int k = 1; k <= steps; k++, step *= times) {
    self->t += step;
    if (CrawlStep(&self->crawl, self->t, self->t,
                  grow_rule.crawl_part * PetscMin(self->length, self->end), self->iterations))
      return k;
  }
  return 0;
}

static Run OfLength(PetscReal length, PetscReal end) {
  Run self = {.length = length, .end = end};
  return self;
}

static void TestAlike(void **state) {
  Run slow = OfLength(1, 2), fast = OfLength(1, 2), late = OfLength(1, 2), shrinks = OfLength(1, 2);
  int k;

  EXPECT((k = Crawls(&slow, 9e-9, 1, 5000)) == 1000, "steps of 9e-9: %d", k);
  EXPECT(PetscAbsReal(slow.crawl.by - 9e-6) < 1e-12, "brought on by %g", (double)slow.crawl.by);
  EXPECT((k = Crawls(&fast, 1.1e-8, 1, 5000)) == 0, "steps of 1.1e-8: %d", k);
  late.t = 1.5;
  EXPECT((k = Crawls(&late, 1e-10, 1, 5000)) == 1001, "from t = 1.5 on: %d", k);
  EXPECT((k = Crawls(&shrinks, 1e-3, 0.9, 2000)) && k < 1200, "steps that shrink: %d", k);
}

/* What is next to nothing is so beside the run, or the rod, whichever is less. */
static void TestScales(void **state) {
  Run brief = OfLength(1, 1e-3), little = OfLength(1e-3, 1), large = OfLength(100, 100);
  int k;

  EXPECT((k = Crawls(&brief, 5e-11, 1, 5000)) == 0, "a short run: %d", k);
  EXPECT((k = Crawls(&little, 5e-11, 1, 5000)) == 0, "a short rod: %d", k);
  EXPECT((k = Crawls(&large, 5e-7, 1, 5000)) == 1000, "a long one: %d", k);
}

/* The layer of a start at the finest tolerance, and behind a kink: 250 steps for a factor of ten.
 */
static void TestLayer(void **state) {
  const PetscReal slowly = PetscPowReal(10, 1. / 250);
  Run start = OfLength(1, 1), kink = OfLength(1, 1);
  int k;

  EXPECT((k = Crawls(&start, 1e-15, slowly, 3500)) == 0, "a start: %d", k);
  EXPECT(start.t > 1e-2, "the start has come to %g", (double)start.t);
  EXPECT((k = Crawls(&kink, 1e-2, 1, 50)) == 0, "up to a kink: %d", k);
  EXPECT((k = Crawls(&kink, 1e-14, slowly, 3000)) == 0, "behind it: %d", k);
}

/* It sticks and slips: thousands of short steps, and now and then a long one. */
static void TestSlips(void **state) {
  Run self = OfLength(1, 1);
  int k = 0;

  for (int slip = 0; slip < 20 && !k; slip++) {
    k = Crawls(&self, 1e-12, 1, 400);
    if (!k) k = Crawls(&self, 1e-3, 1, 1);
  }
  EXPECT(!k, "slips: %d", k);
}

/* In contact that has got firm steps of many iterations count for as many. */
static void TestIterations(void **state) {
  Run few = OfLength(1, 2), many = OfLength(1, 2), all = OfLength(1, 2);
  int k;

  few.iterations = 19;
  many.iterations = all.iterations = 200;
  few.crawl.counts = many.crawl.counts = PETSC_TRUE;
  EXPECT((k = Crawls(&few, 1e-10, 1, 5000)) == 1000, "steps of 19 iterations: %d", k);
  EXPECT((k = Crawls(&many, 1e-10, 1, 5000)) == 100, "steps of 200: %d", k);
  EXPECT((k = Crawls(&all, 1e-10, 1, 5000)) == 1000, "where they do not count: %d", k);
}

/* What the line advises: viscous friction to one that a wall that rubs and dry friction hold. */
static void TestLine(void **state) {
  Run run = OfLength(1, 2);
  char line[768];

  (void)Crawls(&run, 9e-9, 1, 5000);
  for (int held = 0; held < 2; held++) {
    run.crawl.counts = (PetscBool)held;
    CrawlTell(&run.crawl, 1, (PetscBool)held, line, sizeof(line));
    EXPECT(strstr(line, "crawls at t = 9e-06: the latest 1000 steps") && strstr(line, "-ts_rtol"),
           "%s", line);
    EXPECT(!strstr(line, "-friction_mu 0.99, in SI by -si_friction_viscous") == !held, "%s", line);
    EXPECT(!strstr(line, "or 20000 iterations") == !held, "%s", line);
  }
}

static void TestTold(void **state) {
  Run self = OfLength(1, 1);
  int k;

  self.crawl.chosen = PETSC_TRUE;
  EXPECT((k = Crawls(&self, 1e-12, 1, 5000)) == 0, "steps were told: %d", k);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestAlike), cmocka_unit_test(TestScales),     cmocka_unit_test(TestLayer),
    cmocka_unit_test(TestSlips), cmocka_unit_test(TestIterations), cmocka_unit_test(TestLine),
    cmocka_unit_test(TestTold)};
MAIN(tests)
