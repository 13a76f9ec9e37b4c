/* Growth laws: what they return is consistent (g = p_s, g_t, g_s and p_t by difference quotients),
   the length grows as asked, and a table reproduces the law it was made of.
   test: laws agree with their differences and integrals | ranks 1 3 */
#include "harness.h"
#include "material/growth.h"

/* Of s and t; below, its difference quotients of fourth order. */
typedef PetscReal (*Function)(Growth, PetscReal s, PetscReal t);

static PetscReal Stretch(Growth growth, PetscReal s, PetscReal t) {
  PetscReal g;
  CHECK(GrowthStretch(growth, 1, &s, t, &g, NULL, NULL));
  return g;
}

static PetscReal Arc(Growth growth, PetscReal s, PetscReal t) {
  PetscReal p;
  CHECK(GrowthArc(growth, 1, &s, t, &p, NULL));
  return p;
}

static PetscReal BySlope(Function f, Growth growth, PetscReal s, PetscReal t, PetscReal h) {
  return (8 * (f(growth, s + h, t) - f(growth, s - h, t)) -
          (f(growth, s + 2 * h, t) - f(growth, s - 2 * h, t))) /
         (12 * h);
}

static PetscReal ByRate(Function f, Growth growth, PetscReal s, PetscReal t, PetscReal h) {
  return (8 * (f(growth, s, t + h) - f(growth, s, t - h)) -
          (f(growth, s, t + 2 * h) - f(growth, s, t - 2 * h))) /
         (12 * h);
}

static void Near(const char *what, PetscReal is, PetscReal should, PetscReal size, PetscReal s,
                 PetscReal t) {
  EXPECT(PetscAbsReal(is - should) <= 2e-8 * size, "%s is %.12g, not %.12g, at s %g, t %g", what,
         is, should, s, t);
}

/* All that a law returns, at points away from the table's knots (multiples of 1/8 in s, t). */
static void Consistent(Growth growth, PetscReal h) {
  const PetscReal at[] = {0.03, 0.055, 0.18, 0.44, 0.93}, times[] = {0.06, 0.9, 3.3};
  for (int i = 0; i < 5; i++)
    for (int j = 0; j < 3; j++) {
      PetscReal s = at[i], t = times[j], g, g_t, g_s, p, p_t, size;
      CHECK(GrowthStretch(growth, 1, &s, t, &g, &g_t, &g_s));
      CHECK(GrowthArc(growth, 1, &s, t, &p, &p_t));
      size = PetscAbsReal(g) + PetscAbsReal(g_t) + PetscAbsReal(g_s);
      Near("g", g, BySlope(Arc, growth, s, t, h), size, s, t);
      Near("g_t", g_t, ByRate(Stretch, growth, s, t, 0.01), size, s, t);
      Near("g_s", g_s, BySlope(Stretch, growth, s, t, h), size, s, t);
      Near("p_t", p_t, ByRate(Arc, growth, s, t, 0.01), size, s, t);
      Near("p(0)", Arc(growth, 0, t), 0, 1e-6, 0, t);
    }
}

static void GrowsAtUnitRate(Growth growth, PetscReal L0) {
  for (PetscReal t = 0; t < 10; t += 1.7) {
    PetscReal L, L_t;
    CHECK(GrowthLength(growth, t, &L, &L_t));
    EXPECT(PetscAbsReal(L - (L0 + t)) < 1e-13 * (1 + t), "length %.15g at t %g", L, t);
    EXPECT(PetscAbsReal(L_t - 1) < 1e-13, "rate of length %.15g at t %g", L_t, t);
  }
}

static void Law(const char *options, PetscReal L0, PetscReal h, PetscBool slides) {
  Growth growth;
  SetOptions("%s -growth_initial_length %g", options, L0);
  CHECK(GrowthCreate(&growth));
  Consistent(growth, h);
  GrowsAtUnitRate(growth, L0);
  EXPECT(PetscAbsReal(Stretch(growth, 0.3, 0) - L0) < 1e-14, "g(s, 0) is not L0");
  EXPECT(GrowthSlide(growth, 0.25, 1) == (slides ? 0.75 : 0), "slide %g",
         GrowthSlide(growth, 0.25, 1));
  CHECK(GrowthDestroy(&growth));
}

static void TestUniform(void **state) {
  Law("-growth_type uniform", 0.5, 1e-3, PETSC_FALSE);
}

static void TestFeed(void **state) {
  Law("-growth_type feed", 2, 1e-3, PETSC_TRUE);
}

static void TestGaussian(void **state) {
  Law("-growth_type gaussian", 0.5, 1e-3, PETSC_FALSE);
  Law("-growth_type gaussian -growth_width 0.05", 1, 2e-4, PETSC_FALSE);
  Law("-growth_type gaussian -growth_width 5", 1, 1e-3, PETSC_FALSE);
  Law("-growth_type gaussian -growth_width 0.005", 1, 2e-5, PETSC_FALSE);
}

/* V = c + s L_t against its integral in quadruple precision, to round-off; strain against the slope
   of c, what is laid down against time: all the way to the end of the zone, where 1 - W cancels. */
static void Apical(PetscReal zone, PetscReal t) {
  Growth growth;
  PetscReal L, worst = 0, slope = 0, still = 0;
  SetOptions("-growth_type apical -growth_zone %g -growth_initial_length 0.5", zone);
  CHECK(GrowthCreate(&growth));
  CHECK(GrowthLength(growth, t, &L, NULL));
  EXPECT(growth->slides && growth->even && L == 0.5 + t, "L = %g", L);
  zone = PetscMin(zone, L);
  for (int i = 0; i <= 400; i++) {
    PetscReal s = i / 400., h = 1e-3 * zone / L, strain = GrowthStrain(growth, s, t, 1), d, d_t,
              moved;
    __float128 z = (1 - (__float128)s) * L / zone, beyond = z < 1 ? 1 - z : 0;
    __float128 V = beyond * beyond * beyond * (1 + 3 * z + 6 * z * z); /* 1 - W, multiplied out */
    worst = PetscMax(worst, PetscAbsReal(GrowthSlide(growth, s, t) + s - (PetscReal)V));
    EXPECT(strain >= 0, "strain %g at s %g", strain, s);
    if (s > 3 * h && s < 1 - 3 * h && PetscAbsReal((1 - s) * L / zone - 1) > 3e-3) {
      PetscReal by = (8 * (GrowthSlide(growth, s + h, t) - GrowthSlide(growth, s - h, t)) -
                      (GrowthSlide(growth, s + 2 * h, t) - GrowthSlide(growth, s - 2 * h, t))) /
                     (12 * h);
      slope = PetscMax(slope, PetscAbsReal(by + 1 - strain)); /* g_t + c_s */
    }
    CHECK(GrowthOrigin(growth, s, t, &d, &d_t));
    if (z < 1) continue; /* at rest: its place, and so where it comes from, stays */
    CHECK(GrowthOrigin(growth, s * L / (L + 1), t + 1, &moved, &d_t));
    still = PetscMax(still, PetscAbsReal(moved - d));
  }
  print_message("zone %g, t %g: V to %.1e, strain to %.1e, places to %.1e\n", zone, t, worst, slope,
                still);
  EXPECT(worst < 4e-15, "V off by %g", worst);
  EXPECT(slope < 1e-9 * PetscMax(1, L / zone), "strain off by %g", slope);
  EXPECT(still < 1e-14 * L, "material at rest moves by %g", still);
  CHECK(GrowthDestroy(&growth));
}

static void TestApical(void **state) {
  Apical(0.5, 0);
  Apical(0.5, 3);
  Apical(2, 0.3); /* the whole rod grows */
  Apical(2, 4);
  Apical(0.2, 30);
}

/* By the formula itself, at one point: g = L0 + 2 t exp(-s^2/a^2) / (a sqrt(pi) erf(1/a)). */
static void TestGaussianValue(void **state) {
  Growth growth;
  SetOptions("-growth_type gaussian -growth_width 0.5 -growth_initial_length 0.7");
  CHECK(GrowthCreate(&growth));
  EXPECT(PetscAbsReal(Stretch(growth, 0.5, 3) - 3.2023503161321747) < 1e-12, "g is %.15g",
         Stretch(growth, 0.5, 3));
  CHECK(GrowthDestroy(&growth));
}

/* Fed by rows of length, or of speed: what it returns is consistent, the rows are met, material
   goes along as it is pushed, and what it has from the tip stays. */
static void Fed(const char *rows, const PetscReal length[4], PetscReal most) {
  PetscReal longest;
  char path[64];
  Growth growth;
  WriteWalls(path, rows);
  SetOptions("-growth_type feed -growth_path %s", path);
  CHECK(GrowthCreate(&growth));
  RemoveFile(path);
  EXPECT(growth->slides && growth->even && !growth->similar, "is no rod that is fed");
  for (int k = 0; k < 4; k++) {
    const PetscReal t = k, s = 0.25, h = 1e-4;
    PetscReal L, L_t, d[2], d_t;
    CHECK(GrowthLength(growth, t, &L, &L_t));
    Near("L", L, length[k], 1, 1, t);
    CHECK(GrowthLength(growth, t + 0.4, &L, &L_t));
    Near("L_t", L_t, ByRate(Arc, growth, 1, t + 0.4, h), 1, 1, t + 0.4);
    Near("c", GrowthSlide(growth, s, t + 0.4), 0.75 * L_t, 1, s, t);
    Near("V", GrowthSpeed(growth, s, t + 0.4, s * L_t), L_t, 1, s, t);
    EXPECT(GrowthStrain(growth, s, t, 3) == 0, "what is fed does not stretch");
    CHECK(GrowthOrigin(growth, s, t + 0.4, &d[0], &d_t));
    Near("from the tip", d[0], 0.75 * L, 1, s, t);
    EXPECT(d_t == 0, "which stays for the material");
  }
  CHECK(GrowthLongest(growth, 3, &longest));
  EXPECT(PetscAbsReal(longest - most) < 1e-12, "longest %g, not %g", (double)longest, (double)most);
  CHECK(GrowthDestroy(&growth));
}

static void TestPath(void **state) {
  Fed("t,length\n0,0.5\n1,1.5\n2,1.5\n3,0.7\n", (const PetscReal[]){0.5, 1.5, 1.5, 0.7}, 1.5);
  /* cubics of slopes 0, 0, -2/3 and -1/4 at the rows */
  Fed("t,speed\n0,1\n1,1\n2,0\n3,-0.5\n", (const PetscReal[]){0.5, 1.5, 37. / 18, 85. / 48},
      37. / 18);
}

static PetscReal Bicubic(PetscReal s, PetscReal t) {
  return (2 + s - 3 * s * s + 2 * s * s * s) * (1 + t / 3 + t * t / 7 - t * t * t / 50) +
         s * t * t * t / 9;
}

static PetscReal Smooth(PetscReal s, PetscReal t) {
  return 1 + t * (1 + 0.5 * PetscSinReal(3 * s + t)) + 0.3 * PetscCosReal(2 * s - t);
}

static Growth Tabulated(PetscInt ns, PetscInt nt, PetscReal (*g)(PetscReal, PetscReal)) {
  char path[64];
  Growth growth;
  WriteTable(path, ns, nt, 4, g);
  SetOptions("-growth_type table -growth_table %s", path);
  CHECK(GrowthCreate(&growth));
  RemoveFile(path);
  return growth;
}

static void TestTableConsistent(void **state) {
  Growth growth = Tabulated(9, 33, Smooth);
  PetscReal L0;
  CHECK(GrowthLength(growth, 0, &L0, NULL));
  Consistent(growth, 1e-3);
  EXPECT(growth->end_time == 4, "the table ends at %g", growth->end_time);
  EXPECT(PetscAbsReal(growth->initial_length - L0) < 1e-14, "L0 %.15g, not %.15g",
         growth->initial_length, L0);
  EXPECT(!growth->even && !growth->slides, "a table is neither uniform nor feed");
  CHECK(GrowthDestroy(&growth));
}

static void TestTableExact(void **state) {
  Growth growth = Tabulated(6, 5, Bicubic);
  for (PetscReal s = 0; s <= 1; s += 0.07)
    for (PetscReal t = 0; t <= 4; t += 0.31)
      EXPECT(PetscAbsReal(Stretch(growth, s, t) - Bicubic(s, t)) < 1e-12, "error %g at s %g, t %g",
             Stretch(growth, s, t) - Bicubic(s, t), s, t);
  EXPECT(PetscAbsReal(Arc(growth, 1, 0) - 2) < 1e-13, "length %.15g", Arc(growth, 1, 0));
  CHECK(GrowthDestroy(&growth));
}

static void TestTableOrder(void **state) {
  PetscReal error[3] = {0};
  for (int k = 0; k < 3; k++) {
    Growth growth = Tabulated((10 << k) + 1, (16 << k) + 1, Smooth);
    for (PetscReal s = 0; s <= 1; s += 0.0137)
      for (PetscReal t = 0; t <= 4; t += 0.0531)
        error[k] = PetscMax(error[k], PetscAbsReal(Stretch(growth, s, t) - Smooth(s, t)));
    CHECK(GrowthDestroy(&growth));
  }
  print_message("table: errors %.2e %.2e %.2e, order %.2f\n", error[0], error[1], error[2],
                Order(error[1], error[2]));
  EXPECT(Order(error[1], error[2]) > 3.7, "order %g", Order(error[1], error[2]));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestUniform),       cmocka_unit_test(TestFeed),
    cmocka_unit_test(TestApical),        cmocka_unit_test(TestGaussian),
    cmocka_unit_test(TestGaussianValue), cmocka_unit_test(TestTableConsistent),
    cmocka_unit_test(TestTableExact),    cmocka_unit_test(TestTableOrder),
    cmocka_unit_test(TestPath)};
MAIN(tests)
