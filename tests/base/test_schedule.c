/* What moves or turns by rows: they are met, the rate is the slope, and beyond them it is what it
   is said to be; when it sets out, stops and turns back.
   test: rows over time are met with their slopes and turns | ranks 1 2 */
#include "harness.h"
#include "base/schedule.h"

/* The rate against differences of the angle, away from rows. */
static void Agrees(Schedule path, PetscReal t) {
  const PetscReal h = 1e-5,
                  slope = (ScheduleValue(path, t + h) - ScheduleValue(path, t - h)) / (2 * h),
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
  CHECK(ScheduleRead("-clamp_path", path, "a clamp", &clamp));
  RemoveFile(path);
  return clamp;
}

static void TestAngle(void **state) {
  Schedule path = Read("turn");

  for (int k = 0; k < ROWS; k++)
    EXPECT(ScheduleValue(path, row[k]) == said[k], "row %d: %g", k,
           (double)ScheduleValue(path, row[k]));
  for (PetscReal t = 0.1; t < 4; t += 0.25) Agrees(path, t);
  EXPECT(ScheduleValue(path, 9) == 5 && ScheduleRate(path, 9) == 0, "does not rest behind it");
  CHECK(ScheduleDestroy(&path));
}

static void TestRate(void **state) {
  Schedule path = Read("spin");

  for (int k = 0; k < ROWS; k++)
    EXPECT(ScheduleRate(path, row[k]) == said[k], "row %d: %g", k,
           (double)ScheduleRate(path, row[k]));
  for (PetscReal t = 0.1; t < 4; t += 0.25) Agrees(path, t);
  EXPECT(ScheduleRate(path, 9) == 5, "does not go on");
  EXPECT(PetscAbsReal(ScheduleValue(path, 6) - ScheduleValue(path, 5) - 5) < 1e-12, "nor so");
  CHECK(ScheduleDestroy(&path));
}

/* Times at which it sets out, stops or turns back, from t = 0 on; there are n. */
static void Turns(const PetscReal value[], PetscInt rows, PetscBool rate, PetscInt n,
                  const PetscReal at[]) {
  PetscReal t = 0;
  Schedule path;

  CHECK(ScheduleCreate(rows, &path));
  for (PetscInt k = 0; k < rows; k++) ScheduleSetRow(path, k, k + 1, value[k]);
  CHECK(ScheduleSetUp("test", rate, path));
  for (PetscInt k = 0; k < n; k++) {
    t = ScheduleNextTurn(path, t);
    EXPECT(PetscAbsReal(t - at[k]) < 1e-14, "turn %d of %d rows at %g, not %g", (int)k, (int)rows,
           (double)t, (double)at[k]);
  }
  EXPECT(ScheduleNextTurn(path, t) == PETSC_MAX_REAL, "%d rows: one turn more", (int)rows);
  CHECK(ScheduleDestroy(&path));
}

static void TestTurns(void **state) {
  Turns((PetscReal[]){0, 1, 2, 2, 1, 0}, 6, PETSC_FALSE, 4, (PetscReal[]){1, 3, 4, 6});
  Turns((PetscReal[]){0, 0, 1, 1}, 4, PETSC_FALSE, 2, (PetscReal[]){2, 3});
  Turns((PetscReal[]){3, 3}, 2, PETSC_FALSE, 0, NULL);
  Turns((PetscReal[]){1, 1}, 2, PETSC_TRUE, 0, NULL);                      /* goes on for good */
  Turns((PetscReal[]){1, -1}, 2, PETSC_TRUE, 3, (PetscReal[]){1, 1.5, 2}); /* back in between */
  Turns((PetscReal[]){0, 0, 4, 0}, 4, PETSC_TRUE, 4, (PetscReal[]){1, 2, 3, 4});
}

/* What sets out at once: at rest where a step ends there, but moving from t = 0 on. */
static void TestJerks(void **state) {
  Schedule path;

  for (int late = 0; late < 2; late++) {
    CHECK(ScheduleCreate(2, &path));
    for (int k = 0; k < 2; k++) ScheduleSetRow(path, k, late + k, 7 + 3 * k);
    CHECK(ScheduleSetUp("test", PETSC_FALSE, path));
    EXPECT(ScheduleRate(path, late) == 3 * (1 - late) && ScheduleRate(path, late + 1) == 3, "%d",
           late);
    EXPECT(ScheduleValue(path, 0) == 0 && ScheduleValue(path, 5) == 3, "%d", late);
    EXPECT(ScheduleJerks(path, late, late + 0.1) && !ScheduleJerks(path, late + 0.1, late + 1) &&
               ScheduleJerks(path, late + 1, late + 2),
           "%d", late);
    CHECK(ScheduleDestroy(&path));
  }
}

/* Places from a table, those left out at rest. */
static void TestPlace(void **state) {
  Schedule place[3];
  char path[64];

  WriteWalls(path, "x3,t,x1\n1,0,0\n1.5,1,2\n2,2,4\n");
  CHECK(ScheduleReadPlace("-wall_file", path, place));
  RemoveFile(path);
  EXPECT(!place[1], "x2 has no column");
  EXPECT(PetscAbsReal(ScheduleValue(place[0], 0.7) - 1.4) < 1e-15 &&
             PetscAbsReal(ScheduleValue(place[2], 0.7) - 0.35) < 1e-15,
         "not on the line");
  for (int d = 0; d < 3; d++) CHECK(ScheduleDestroy(&place[d]));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestAngle), cmocka_unit_test(TestRate),
                                          cmocka_unit_test(TestTurns), cmocka_unit_test(TestJerks),
                                          cmocka_unit_test(TestPlace)};
MAIN(tests)
