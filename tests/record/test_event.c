/* Self-contact of a rod of some thickness: shapes whose gaps are known.
   test: a thick rod touches itself where its gap is known to close */
#include "harness.h"
#include "record/event.h"

enum { ARM = 10, ARC = 2000, ALL = 2 * ARM + ARC };

/* Half a circle of radius R between two parallel arms of length a each. */
static void Hairpin(PetscReal R, PetscReal a, PetscReal s[], Node nodes[]) {
  const PetscReal length = PETSC_PI * R + 2 * a;

  for (PetscInt i = 0; i <= ALL; i++) {
    PetscReal p = i <= ARM        ? a * i / ARM
                  : i < ARM + ARC ? a + PETSC_PI * R * (i - ARM) / ARC
                                  : a + PETSC_PI * R + a * (i - ARM - ARC) / ARM;
    PetscReal angle = PetscMax(0, PetscMin(PETSC_PI, (p - a) / R));
    nodes[i] = (Node){.theta = angle};
    nodes[i].x[0] = PetscMin(p, a) + R * PetscSinReal(angle) - PetscMax(0, p - a - PETSC_PI * R);
    nodes[i].x[1] = R * (1 - PetscCosReal(angle));
    s[i] = p / length;
  }
}

/* Neighbours are within pi/2 diameters along the rod: a bend that the rod can just make is no
   contact, its arms are, and a gap is measured to the last digit. */
static void TestHairpin(void **state) {
  static const struct {
    PetscReal R, arm, diameter;
    PetscBool touch;
  } rows[] = {{0.5, 2, 0.999, PETSC_FALSE}, {0.5, 2, 1.001, PETSC_TRUE},
              {0.495, 0.05, 1, PETSC_TRUE}, {0.51, 0.05, 1, PETSC_FALSE},
              {0.6, 0.05, 1, PETSC_FALSE},  {0.5, 2, 0, PETSC_FALSE}};
  PetscReal s[ALL + 1];
  Node nodes[ALL + 1];
  Event event;

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) {
    Hairpin(rows[k].R, rows[k].arm, s, nodes);
    CHECK(EventContact(ALL, s, nodes, rows[k].diameter, &event));
    EXPECT((event.kind == EVENT_SELF_CONTACT) == rows[k].touch, "row %d: kind %d", (int)k,
           (int)event.kind);
    if (!rows[k].touch) continue;
    /* the nearest pair lies on the two arms, at one x1, its middle between them */
    EXPECT(PetscAbsReal(event.s[0] + event.s[1] - 1) < 1e-3, "row %d: labels %g %g", (int)k,
           (double)event.s[0], (double)event.s[1]);
    EXPECT(PetscAbsReal(event.x[1] - rows[k].R) < 1e-3, "row %d: x2 %g", (int)k,
           (double)event.x[1]);
  }
}

/* Every way in which two segments can be nearest, and where. */
static void TestPlaces(void **state) {
  static const struct {
    PetscReal x[4][2], s[2]; /* segments 0-1 and 2-3 of three cells; the labels that meet */
  } rows[] = {{{{0, 0}, {4, 0}, {4, 5}, {1, 1}}, {0.25 / 3, 1}},
              {{{0, 0}, {8, 0}, {6, 1}, {6, 5}}, {0.75 / 3, 2. / 3}},
              {{{1, 1}, {1, 9}, {0, 0}, {4, 0}}, {0, 2.25 / 3}},
              {{{1, 9}, {1, 1}, {-3, 0}, {5, 0}}, {1. / 3, 2.5 / 3}},
              {{{0, 0}, {4, 0}, {2, 3}, {2, -1}}, {0.5 / 3, 2.75 / 3}}};
  const PetscReal s[4] = {0, 1. / 3, 2. / 3, 1};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) {
    Node nodes[4];
    Event event;
    CHECK(PetscMemzero(nodes, sizeof(nodes)));
    for (int i = 0; i < 4; i++) CHECK(PetscArraycpy(nodes[i].x, rows[k].x[i], 2));
    CHECK(EventContact(3, s, nodes, 1.01, &event));
    EXPECT(event.kind == EVENT_SELF_CONTACT, "row %d: no contact", (int)k);
    for (int e = 0; e < 2; e++)
      EXPECT(PetscAbsReal(event.s[e] - rows[k].s[e]) < 1e-12, "row %d: labels %.15g %.15g", (int)k,
             (double)event.s[0], (double)event.s[1]);
  }
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestHairpin),
                                          cmocka_unit_test(TestPlaces)};

MAIN(tests)
