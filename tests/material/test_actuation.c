/* A strain that is given over time: cubics of place and time are met exactly, with their slopes, on
   either side of a kink; beyond the rows it rests; when it turns, and where its rate jumps. And
   what a rod makes of it: its rate for material that slides.
   test: a strain over time is met with its slopes and kinks | ranks 1 2 */
#include "harness.h"
#include "base/hdf.h"
#include "material/curvature.h"

static PetscReal Cubic(PetscReal d, PetscReal t) {
  return (1 - 2 * d + d * d * d / 3) * (0.5 + t - t * t * t / 7) + d * d * t * t / 5;
}

static PetscReal CubicByPlace(PetscReal d, PetscReal t) {
  return (-2 + d * d) * (0.5 + t - t * t * t / 7) + 2 * d * t * t / 5;
}

static PetscReal CubicByTime(PetscReal d, PetscReal t) {
  return (1 - 2 * d + d * d * d / 3) * (1 - 3 * t * t / 7) + 2 * d * d * t / 5;
}

/* Up to the kink at 1 that cubic, a parabola up to 2, where it has turned the way it came by a
   line. */
static const PetscReal row[] = {0, 0.2, 0.5, 0.8, 1, 1, 1.5, 2, 2, 3};
enum { ROWS = 10, PLACES = 6 };

static PetscReal Said(PetscReal d, PetscReal t, PetscInt j) {
  if (j <= 4) return Cubic(d, t);
  if (j <= 7) return Cubic(d, 1) + (1 + d) * (t - 1) * (t - 1);
  return Cubic(d, 1) + (1 + d) * (1 - 3 * (t - 2));
}

static PetscReal *Places(PetscReal at[PLACES]) {
  for (int i = 0; i < PLACES; i++) at[i] = (PetscReal)(i * i) / ((PLACES - 1) * (PLACES - 1));
  return at;
}

static void Write(char path[64], const char *where) {
  const char *const name[] = {where, "/t", "/curvature"};
  const PetscInt places = PLACES, rows = ROWS, both[] = {ROWS, PLACES};
  PetscReal at[PLACES], k[ROWS * PLACES];

  (void)Places(at);
  for (int j = 0; j < ROWS; j++)
    for (int i = 0; i < PLACES; i++) k[j * PLACES + i] = Said(at[i], row[j], j);
  OpenScratch(path);
  WriteScratch(path, 3, name, (int[]){1, 1, 2}, (const PetscInt *[]){&places, &rows, both},
               (const PetscReal *[]){at, row, k});
}

static void Same(const char *what, PetscReal is, PetscReal should, PetscReal d, PetscReal t) {
  EXPECT(PetscAbsReal(is - should) < 1e-12, "%s is %.15g, not %.15g, at %g, t %g", what, (double)is,
         (double)should, (double)d, (double)t);
}

static void TestValue(void **state) {
  PetscReal at[PLACES], k, k_d, k_t;
  Actuation steered;
  char path[64];

  Write(path, "/s");
  CHECK(ActuationRead("-rod_curvature_file", path, "/curvature", PLACES, Places(at), &steered));
  RemoveFile(path);
  for (PetscReal d = 0; d <= 1; d += 0.125) {
    for (PetscReal t = 0; t <= 1; t += 0.125) {
      ActuationValue(steered, d, t, &k, &k_d, &k_t);
      Same("k", k, Cubic(d, t), d, t);
      Same("k_d", k_d, CubicByPlace(d, t), d, t);
      Same("k_t", k_t, CubicByTime(d, t), d, t);
    }
    ActuationValue(steered, d, 1.25, &k, &k_d, &k_t);
    Same("k of the parabola", k, Said(d, 1.25, 6), d, 1.25);
    Same("its rate", k_t, (1 + d) * 0.5, d, 1.25);
    ActuationValue(steered, d, 2.5, &k, &k_d, &k_t);
    Same("k of the line", k, Said(d, 2.5, 9), d, 2.5);
    Same("its rate", k_t, -3 * (1 + d), d, 2.5);
    ActuationValue(steered, d, 2, &k, NULL, &k_t);
    Same("rate before the kink", k_t, 2 * (1 + d), d, 2);
    ActuationValue(steered, d, 7, &k, NULL, &k_t);
    Same("k behind the rows", k, Said(d, 3, 9), d, 7);
    Same("its rate", k_t, 0, d, 7);
  }
  ActuationValue(steered, 4, 0.5, &k, &k_d, &k_t);
  Same("k beyond the places", k, Cubic(1, 0.5), 4, 0.5);
  Same("its slope", k_d, 0, 4, 0.5);
  CHECK(ActuationDestroy(&steered));
}

static void TestTurns(void **state) {
  const PetscReal turns[] = {1, 2, 3, PETSC_MAX_REAL};
  PetscReal at[PLACES], t = 0;
  Actuation steered;
  char path[64];

  Write(path, "/s");
  CHECK(ActuationRead("-rod_curvature_file", path, "/curvature", PLACES, Places(at), &steered));
  RemoveFile(path);
  for (int k = 0; k < 4; k++, t = ActuationNextTurn(steered, t))
    EXPECT(ActuationNextTurn(steered, t) == turns[k], "behind %g: %g", (double)t,
           (double)ActuationNextTurn(steered, t));
  EXPECT(ActuationJerks(steered, 0.9, 1.1) && ActuationJerks(steered, 1, 1.1) &&
             ActuationJerks(steered, 2.9, 3.1),
         "misses a kink");
  EXPECT(!ActuationJerks(steered, 0, 1) && !ActuationJerks(steered, 1.1, 1.9) &&
             !ActuationJerks(steered, 3.1, 9),
         "sees one that is not there");
  CHECK(ActuationDestroy(&steered));
}

/* The rate for the material, of what is fed and of what is laid down by a tip: against the value at
   the place where the material is a little later, V further. */
static void Follows(const char *options) {
  const PetscReal h = 1e-4, t = 0.3;
  Curvature curvature;
  PetscReal k[3], rate;
  char path[64];
  Growth growth;

  Write(path, "/distance");
  SetOptions("%s -growth_initial_length 1 -rod_curvature_file %s -rod_curvature 0.4", options,
             path);
  CHECK(GrowthCreate(&growth));
  CHECK(CurvatureSetFromOptions(&curvature, growth, 2));
  RemoveFile(path);
  for (PetscReal s = 0.3; s < 1; s += 0.2) {
    PetscReal p, p_t, L, L_t, V;
    CHECK(GrowthArc(growth, 1, &s, t, &p, &p_t));
    V = GrowthSpeed(growth, s, t, p_t);
    CHECK(CurvatureValue(&curvature, growth, s, t, &k[1], &rate));
    for (int side = -1; side <= 1; side += 2) {
      CHECK(GrowthLength(growth, t + side * h, &L, &L_t));
      CHECK(CurvatureValue(&curvature, growth, (p + side * h * V) / L, t + side * h, &k[1 + side],
                           NULL));
    }
    EXPECT(PetscAbsReal((k[2] - k[0]) / (2 * h) - rate) < 1e-6, "%s: %g, not %g, at %g", options,
           (double)rate, (double)(k[2] - k[0]) / (2 * h), (double)s);
    EXPECT(PetscAbsReal(k[1] - 0.4 - Cubic(PetscMin(1, L - p), t)) < 1e-3, "%s: %g at %g", options,
           (double)k[1], (double)s);
  }
  CHECK(CurvatureDestroy(&curvature));
  CHECK(GrowthDestroy(&growth));
}

static void TestFollows(void **state) {
  Follows("-growth_type feed");
  Follows("-growth_type apical -growth_zone 0.5");
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestValue), cmocka_unit_test(TestTurns),
                                          cmocka_unit_test(TestFollows)};
MAIN(tests)
