/* How a clamp turns: rows are met, the rate is the angle's slope, and beyond the rows it is what it
   is said to be. */
#include "harness.h"
#include "world/clamp_path.h"

/* The rate against differences of the angle, away from rows. */
static void Agrees(ClampPath path, PetscReal t) {
  const PetscReal h = 1e-5,
                  slope = (ClampPathAngle(path, t + h) - ClampPathAngle(path, t - h)) / (2 * h),
                  rate = ClampPathRate(path, t);
  EXPECT(PetscAbsReal(slope - rate) < 1e-8, "t %g: rate %g, slope %g", (double)t, (double)rate,
         (double)slope);
}

/* Uneven rows that rise by unlike slopes, none of them 0 within. */
static const PetscReal row[] = {0, 0.7, 2, 2.5, 4}, said[] = {0, 0.3, 1.9, 2, 5};
enum { ROWS = 5 };

static ClampPath Read(const char *name) {
  char path[64], text[256] = "";
  ClampPath clamp;

  (void)snprintf(text, sizeof(text), "t,%s\n", name);
  for (int k = 0; k < ROWS; k++)
    (void)snprintf(text + strlen(text), sizeof(text) - strlen(text), "%.17g,%.17g\n",
                   (double)row[k], (double)said[k]);
  WriteWalls(path, text);
  CHECK(ClampPathRead("-clamp_path", path, &clamp));
  RemoveFile(path);
  return clamp;
}

static void TestAngle(void **state) {
  ClampPath path = Read("turn");

  for (int k = 0; k < ROWS; k++)
    EXPECT(ClampPathAngle(path, row[k]) == said[k], "row %d: %g", k,
           (double)ClampPathAngle(path, row[k]));
  for (PetscReal t = 0.1; t < 4; t += 0.25) Agrees(path, t);
  EXPECT(ClampPathAngle(path, 9) == 5 && ClampPathRate(path, 9) == 0, "does not rest behind it");
  CHECK(ClampPathDestroy(&path));
}

static void TestRate(void **state) {
  ClampPath path = Read("spin");

  for (int k = 0; k < ROWS; k++)
    EXPECT(ClampPathRate(path, row[k]) == said[k], "row %d: %g", k,
           (double)ClampPathRate(path, row[k]));
  for (PetscReal t = 0.1; t < 4; t += 0.25) Agrees(path, t);
  EXPECT(ClampPathRate(path, 9) == 5, "does not go on");
  EXPECT(PetscAbsReal(ClampPathAngle(path, 6) - ClampPathAngle(path, 5) - 5) < 1e-12, "nor so");
  CHECK(ClampPathDestroy(&path));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestAngle), cmocka_unit_test(TestRate)};
MAIN(tests)
