/* Memory that may be left on disk.
   test: what grows leaves memory and stays what it is */
#include "harness.h"
#include "base/spill.h"
#include <stdio.h>

/* Bytes of this process that are in memory. */
static double InMemory(void) {
  FILE *file = fopen("/proc/self/statm", "r");
  long all, here = -1;

  if (!file) return -1;
  if (fscanf(file, "%ld %ld", &all, &here) != 2) here = -1;
  (void)fclose(file);
  return (double)here * (double)sysconf(_SC_PAGESIZE);
}

static void TestKeepsAllAndLeavesMemory(void **state) {
  const size_t some = (size_t)1 << 17, most = (size_t)1 << 23; /* of numbers; 64 MB */
  const double before = InMemory();
  Spill spill = {0};
  size_t room = some, wrong = 0;

  CHECK(SpillNew(room * sizeof(double), &spill));
  for (size_t k = 0; k < most; k++) {
    if (k == room) {
      CHECK(SpillGrow(k * sizeof(double), 2 * room * sizeof(double), &spill));
      room *= 2;
    }
    ((double *)spill.at)[k] = (double)k;
    if (k % some == 0) SpillRest(&spill);
  }
  SpillRest(&spill);
  EXPECT(!spill.mapped || before < 0 || InMemory() - before < 16e6, "%g MB are in memory",
         (InMemory() - before) / 1e6);
  EXPECT(spill.mapped, "no disk here has 64 MB");
  for (size_t k = 0; k < most; k++) wrong += ((double *)spill.at)[k] != (double)k;
  EXPECT(wrong == 0, "%zu numbers are not what they were", wrong);
  SpillFree(&spill);
  EXPECT(!spill.at && !spill.bytes, "it is not empty");
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestKeepsAllAndLeavesMemory)};
MAIN(tests)
