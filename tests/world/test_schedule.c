/* How a clamp turns: rows are met, the rate is the angle's slope, and beyond the rows it is what it
   is said to be. */
#include "harness.h"
#include "world/schedule.h"

/* The rate against differences of the angle, away from rows. */
static void Agrees(Schedule path, PetscReal t) {
  const PetscReal h = 1e-5,
                  slope = (ScheduleAngle(path, t + h) - ScheduleAngle(path, t - h)) / (2 * h),
                  rate = ScheduleRate(path, t);
  EXPECT(PetscAbsReal(slope - rate) < 1e-8, "t %g: rate %g, slope %g", (double)t, (double)rate,
         (double)slope);
}

/* Uneven rows that rise by unlike slopes, none of them 0 within. */
static const PetscReal row[] = {0, 0.7, 2, 2.5, 4}, said[] = {0, 0.3, 1.9, 2, 5};
enum { ROWS = 5 };

static Schedule Read(const char *name) {
  char path[64], text[256] = "";
  Schedule clamp;

  (void)snprintf(text, sizeof(text), "t,%s\n", name);
  for (int k = 0; k < ROWS; k++)
    (void)snprintf(text + strlen(text), sizeof(text) - strlen(text), "%.17g,%.17g\n",
                   (double)row[k], (double)said[k]);
  WriteWalls(path, text);
  CHECK(ScheduleRead("-clamp_path", path, &clamp));
  RemoveFile(path);
  return clamp;
}

static void TestAngle(void **state) {
  Schedule path = Read("turn");

  for (int k = 0; k < ROWS; k++)
    EXPECT(ScheduleAngle(path, row[k]) == said[k], "row %d: %g", k,
           (double)ScheduleAngle(path, row[k]));
  for (PetscReal t = 0.1; t < 4; t += 0.25) Agrees(path, t);
  EXPECT(ScheduleAngle(path, 9) == 5 && ScheduleRate(path, 9) == 0, "does not rest behind it");
  CHECK(ScheduleDestroy(&path));
}

static void TestRate(void **state) {
  Schedule path = Read("spin");

  for (int k = 0; k < ROWS; k++)
    EXPECT(ScheduleRate(path, row[k]) == said[k], "row %d: %g", k,
           (double)ScheduleRate(path, row[k]));
  for (PetscReal t = 0.1; t < 4; t += 0.25) Agrees(path, t);
  EXPECT(ScheduleRate(path, 9) == 5, "does not go on");
  EXPECT(PetscAbsReal(ScheduleAngle(path, 6) - ScheduleAngle(path, 5) - 5) < 1e-12, "nor so");
  CHECK(ScheduleDestroy(&path));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestAngle), cmocka_unit_test(TestRate)};
MAIN(tests)
