/* Surfaces in space: distances against formulas and against points strewn over them, gradients and
   curvatures against difference quotients, the search against looking at all, how they move against
   their velocities and against what their text says.
   test: surfaces have the differences of their distance as normal and bend */
#include "harness.h"
#include "world/surfaces.h"

/* Adds the surface of a line; its text is taken apart. */
static void Add(Surfaces *surfaces, const char *text, PetscReal radius) {
  char copy[512], *word[60];
  SurfaceLine line = {.file = "test", .line = 1, .word = word, .radius = radius};
  (void)snprintf(copy, sizeof(copy), "%s", text);
  for (char *c = strtok(copy, " "); c; c = strtok(NULL, " ")) word[line.n++] = c;
  assert_true(SurfacesKnow(line.n, word));
  CHECK(SurfacesAdd(&line, 0, surfaces));
}

static void Strew(uint64_t i, PetscReal reach, PetscReal x[3]) {
  for (int d = 0; d < 3; d++) x[d] = reach * Scatter(i, 100 + (uint64_t)d);
}

static PetscReal Size(const PetscReal a[3]) {
  return PetscSqrtReal(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

/* The normal is the gradient of the distance, the bend that of the normal. */
static void Derivatives(const char *text, const Surface *surface) {
  const PetscReal h = 1e-5;
  PetscReal slope = 0, bend = 0, along = 0;
  for (uint64_t i = 0; i < 400; i++) {
    PetscReal x[3], y[3], far = 0;
    SurfacePoint at, up, down;
    Strew(i, 3, x);
    if (!SurfaceAt(surface, x, 2, &at) || at.distance < -0.1) continue;
    along = PetscMax(along, PetscAbsReal(Size(at.normal) - 1));
    for (int c = 0; c < 3; c++) {
      PetscReal miss = 0;
      for (int d = 0; d < 3; d++) y[d] = x[d] + (c == d) * h;
      (void)SurfaceAt(surface, y, 9, &up);
      for (int d = 0; d < 3; d++) y[d] = x[d] - (c == d) * h;
      (void)SurfaceAt(surface, y, 9, &down);
      for (int d = 0; d < 3; d++) {
        far = PetscMax(far, PetscAbsReal(up.bend[d][c] - down.bend[d][c]));
        miss =
            PetscMax(miss, PetscAbsReal((up.normal[d] - down.normal[d]) / (2 * h) - at.bend[d][c]));
      }
      slope = PetscMax(slope, PetscAbsReal((up.distance - down.distance) / (2 * h) - at.normal[c]));
      if (far < 1e-2) bend = PetscMax(bend, miss); /* but where the curvature itself jumps */
    }
  }
  EXPECT(along < 1e-14, "%s: normal of length 1 but for %g", text, along);
  EXPECT(slope < 1e-8, "%s: gradient off by %g", text, slope);
  EXPECT(bend < 1e-6, "%s: curvature off by %g", text, bend);
}

static void TestDerivatives(void **state) {
  static const char *const lines[] = {"plane 0.1 0.2 -0.3 1 2 -0.5",
                                      "sphere 0.2 0.1 0 1.1 outside",
                                      "sphere 0.2 0.1 0 2.6 inside",
                                      "cylinder 0.1 0 0 1 0.4 -0.3 0.7 outside",
                                      "cylinder 0.1 0 0 1 0.4 -0.3 1.7 inside",
                                      "cylinder 0.1 0 0 0.3 0.4 -0.3 0.7 outside 1.2",
                                      "cylinder 0 0 0 0.1 -0.4 1 0.7 inside 1.2",
                                      "cone 0 0.1 0 1 0.2 0.1 0.9 0.2 1.1 outside",
                                      "cone 0 0.1 0 1 0.2 0.1 0.9 0.4 1.1 inside",
                                      "cone 0 0.1 0 1 0.2 0.1 0 0.6 1.1 outside",
                                      "torus 0 0 0.1 0.2 0 1 1.4 0.4 outside",
                                      "torus 0 0 0.1 0.2 0 1 1.4 0.6 inside"};
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(lines); k++) {
    Surfaces surfaces = {0};
    Add(&surfaces, lines[k], 0.01);
    CHECK(SurfacesIndex(&surfaces));
    Derivatives(lines[k], &surfaces.surface[0]);
    CHECK(SurfacesDestroy(&surfaces));
  }
}

/* What stands out of solids, its edges and the hull of the balls in its ends: no part of it is in
   front of the solid, and the hull touches that in the middle of its ends and on its side. */
static void TestRidges(void **state) {
  static const char *const lines[] = {"cylinder 0 0 0 0 0 1 0.2 outside 1.5",
                                      "cone 0 0 0 0 0 1 0.3 0.1 1.5 outside",
                                      "cone 0 0 0 0 0 1 0 0.2 1.5 outside"};
  static const PetscReal on[][3][3] = {{{0.2, 0, 0.7}, {0, 0, 0}, {0, 0, 1.5}},
                                       {{0, 0.2, 0.75}, {0, 0, 0}, {0, 0, 1.5}},
                                       {{0, 0.1, 0.75}, {0, 0, 0}, {0, 0, 1.5}}};
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(lines); k++) {
    Surfaces surfaces = {0};
    PetscReal before = PETSC_MAX_REAL, apart = 0;
    Surface ridge;
    Add(&surfaces, lines[k], 0.01);
    CHECK(SurfacesIndex(&surfaces));
    EXPECT(surfaces.ridges == 3, "%s: %d ridges", lines[k], (int)surfaces.ridges);
    ridge = surfaces.surface[0];
    for (PetscInt j = 0; j < surfaces.ridges; j++) {
      ridge.data = surfaces.surface[0].ridge[j].data;
      Derivatives(lines[k], &ridge);
      for (uint64_t i = 0; i < 400; i++) {
        SurfacePoint at, solid;
        PetscReal x[3];
        Strew(i, 2, x);
        (void)SurfaceAt(&surfaces.surface[0], x, 9, &solid);
        if (solid.distance < 0 || !SurfacesRidgeAt(&surfaces, j, x, 9, &at)) continue;
        before = PetscMin(before, at.distance - solid.distance);
      }
      for (int i = 0; i < 3 && j == 2; i++) {
        SurfacePoint at;
        (void)SurfacesRidgeAt(&surfaces, j, on[k][i], 9, &at);
        apart = PetscMax(apart, PetscAbsReal(at.distance));
      }
    }
    EXPECT(before > -1e-14, "%s: in front of it by %g", lines[k], -before);
    EXPECT(apart < 1e-14, "%s: off it by %g", lines[k], apart);
    CHECK(SurfacesDestroy(&surfaces));
  }
}

/* Distances against what everyone knows. */
static void TestFormulas(void **state) {
  Surfaces surfaces = {0};
  const PetscReal z = PetscSqrtReal(0.5);
  PetscReal off = 0;
  Add(&surfaces, "plane 0 0 -1 0 0 2", 0);
  Add(&surfaces, "sphere 1 2 3 0.5 outside", 0);
  Add(&surfaces, "sphere 1 2 3 9 inside", 0);
  Add(&surfaces, "cylinder 0 1 0 1 0 1 0.25 outside", 0);
  Add(&surfaces, "torus 0 0 1 0 0 1 2 0.5 outside", 0);
  CHECK(SurfacesIndex(&surfaces));
  for (uint64_t i = 0; i < 200; i++) {
    PetscReal x[3];
    SurfacePoint at;
    Strew(i, 2, x);
    const PetscReal o[3] = {x[0] - 1, x[1] - 2, x[2] - 3}, along = z * (x[0] + x[2]),
                    c[3] = {x[0] - z * along, x[1] - 1, x[2] - z * along},
                    want[5] = {x[2] + 1, Size(o) - 0.5, 9 - Size(o), Size(c) - 0.25,
                               hypot(hypot(x[0], x[1]) - 2, x[2] - 1) - 0.5};
    for (int k = 0; k < 5; k++) {
      assert_true(SurfaceAt(&surfaces.surface[k], x, 99, &at));
      off = PetscMax(off, PetscAbsReal(at.distance - want[k]));
    }
  }
  CHECK(SurfacesDestroy(&surfaces));
  EXPECT(off < 1e-13, "off by %g", off);
}

/* What ends: from outside the distance is that of the nearest of points strewn over it. */
static void TestEnds(void **state) {
  enum { FINE = 400 };
  Surfaces surfaces = {0};
  PetscReal off = 0;
  Add(&surfaces, "cone 0 0 0 0 0 1 0.9 0.3 1 outside", 0.01);
  CHECK(SurfacesIndex(&surfaces));
  for (uint64_t i = 0; i < 60; i++) {
    PetscReal x[3], rho, least = 9;
    SurfacePoint at;
    Strew(i, 2, x);
    rho = hypot(x[0], x[1]);
    for (int k = 0; k <= FINE; k++) {
      const PetscReal u = (PetscReal)k / FINE;
      least = PetscMin(least, hypot(rho - 0.9 + 0.6 * u, x[2] - u));
      least = PetscMin(least, hypot(rho - 0.9 * u, x[2]));
      least = PetscMin(least, hypot(rho - 0.3 * u, x[2] - 1));
    }
    (void)SurfaceAt(&surfaces.surface[0], x, 99, &at);
    off = PetscMax(off, PetscAbsReal(PetscAbsReal(at.distance) - least));
    EXPECT((at.distance < 0) == (x[2] > 0 && x[2] < 1 && rho < 0.9 - 0.6 * x[2]), "side");
  }
  CHECK(SurfacesDestroy(&surfaces));
  EXPECT(off < 1e-3, "off by %g", off);
}

/* Of many, those near a place and the nearest are found as by looking at all; they come by number.
 */
static void TestSearch(void **state) {
  enum { MANY = 300 };
  Surfaces surfaces = {0};
  Add(&surfaces, "plane 0 0 -9 0 0 1", 0);
  for (uint64_t k = 0; k < MANY; k++) {
    char text[160];
    (void)snprintf(text, sizeof(text), "sphere %.15g %.15g %.15g %.15g outside", 9 * Scatter(k, 1),
                   9 * Scatter(k, 2), 9 * Scatter(k, 3), 0.3 + 0.2 * Scatter(k, 4));
    Add(&surfaces, text, 0);
  }
  CHECK(SurfacesIndex(&surfaces));
  assert_int_equal(surfaces.opens, 1);
  for (uint64_t i = 0; i < 200; i++) {
    PetscInt which[MOST_SURFACES], nearest = -1, n, count = 0, first = -1;
    SurfacePoint point[MOST_SURFACES], at;
    PetscReal x[3], least = 2, found;
    Strew(i, 9, x);
    n = SurfacesNear(&surfaces, x, 1, which, point);
    for (PetscInt k = 0; k < surfaces.n; k++) {
      if (!SurfaceAt(&surfaces.surface[k], x, 99, &at)) continue;
      if (at.distance < least) {
        least = at.distance;
        first = k;
      }
      if (at.distance >= 1) continue;
      assert_true(count < n);
      assert_int_equal(which[count], k);
      assert_true(point[count++].distance == at.distance);
    }
    assert_int_equal(count, n);
    found = SurfacesDistance(&surfaces, x, 2, &nearest);
    assert_true(found == least);
    assert_int_equal(nearest, first);
  }
  CHECK(SurfacesDestroy(&surfaces));
}

/* What moves as it says: velocities are those of what is carried along, and rest is rest. */
static void Carried(const char *text, Surfaces *surfaces) {
  const PetscReal h = 1e-5, x[3] = {0.3, -0.2, 0.9};
  PetscReal y[3][3], v[3], spin[3], off = 0;

  for (PetscReal t = 0.05; t < 4; t += 0.1) {
    for (int k = -1; k <= 1; k++) {
      surfaces->time = t + k * h;
      MotionCarry(&surfaces->surface[0].motion, 0, surfaces->time, x, y[1 + k]);
    }
    surfaces->time = t;
    MotionVelocityAt(&surfaces->surface[0].motion, t, y[1], v, spin);
    for (int d = 0; d < 3; d++)
      off = PetscMax(off, PetscAbsReal((y[2][d] - y[0][d]) / (2 * h) - v[d]));
    if (t > 3) EXPECT(v[0] == 0 && v[1] == 0 && v[2] == 0, "%s: moves at %g", text, (double)t);
  }
  EXPECT(off < 1e-8, "%s: velocity off by %g", text, (double)off);
}

static void TestMotion(void **state) {
  static const char *const lines[] = {
      "sphere 0 0 0 1 outside moves at 0 0 0 1  0.5 1 0 1  1.5 1 0.3 2  2.5 0 0 1",
      "plane 0 0 0 0 0 1 turns at -1 0.5  1 0.7  3 -2 about 0.1 0.2 0 1 2 3",
      "plane 0 0 0 0 0 1 moves at 0 0 0 0 2 1 1 1 turns at 0 0 0.4 1 3 0.5 about 0 1 0 0 0 2",
      "plane 0 0 0 0 0 1 turns spin 0 0 1 2 2.5 -1 3 0 about 0 1 0 0 0 2"};
  PetscReal x[3], within = 2;

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(lines); k++) {
    Surfaces as_said = {0}, again = {0};
    PetscInt nearest;
    char *text;
    Add(&as_said, lines[k], 0.01);
    CHECK(SurfacesIndex(&as_said));
    Carried(lines[k], &as_said);
    CHECK(SurfacesText(&as_said, &text));
    text[strlen(text) - 1] = 0;
    Add(&again, text, 0.01);
    CHECK(SurfacesIndex(&again));
    for (uint64_t i = 0; i < 40; i++) {
      Strew(i, 1, x);
      as_said.time = again.time = 0.1 * (PetscReal)i;
      assert_true(SurfacesDistance(&as_said, x, within, &nearest) ==
                  SurfacesDistance(&again, x, within, &nearest));
    }
    CHECK(PetscFree(text));
    CHECK(SurfacesDestroy(&again));
    CHECK(SurfacesDestroy(&as_said));
  }
}

/* A text of as many rows as are given. */
static void TestLongMotion(void **state) {
  enum { ROWS = 3000 };
  SurfaceLine line = {.file = "test", .line = 1};
  Surfaces surfaces = {0};
  char *number, *text;

  CHECK(PetscMalloc1(8 * ROWS, &number));
  CHECK(PetscMalloc1(4 * ROWS + 10, &line.word));
  line.word[0] = "sphere", line.word[1] = line.word[2] = line.word[3] = line.word[4] = "9";
  line.word[5] = "outside", line.word[6] = "moves", line.word[7] = "at";
  line.n = 8;
  for (int k = 0; k < ROWS; k++) {
    (void)snprintf(number + 8 * k, 8, "%d", k);
    line.word[line.n++] = number + 8 * k;
    for (int d = 0; d < 3; d++) line.word[line.n++] = number + (k % 2) * 8;
  }
  CHECK(SurfacesAdd(&line, 0, &surfaces));
  CHECK(SurfacesIndex(&surfaces));
  CHECK(SurfacesText(&surfaces, &text));
  assert_non_null(strstr(text, " 2998 0 0 0 2999 1 1 1 friction 0"));
  CHECK(PetscFree(text));
  CHECK(PetscFree(number));
  CHECK(PetscFree(line.word));
  CHECK(SurfacesDestroy(&surfaces));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestDerivatives), cmocka_unit_test(TestFormulas), cmocka_unit_test(TestRidges),
    cmocka_unit_test(TestEnds),        cmocka_unit_test(TestSearch),   cmocka_unit_test(TestMotion),
    cmocka_unit_test(TestLongMotion)};
MAIN(tests)
