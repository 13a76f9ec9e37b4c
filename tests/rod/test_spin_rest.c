/* A rod that nothing keeps from spinning turns about its tangent until it is at rest.
   test: directors come to rest the way downhill */
#include "harness.h"
#include "base/plane.h"
#include "rod/spin_rest.h"

enum { N = 41 };

/* A curve of bend 1 about d3, of a rod of these stiffnesses, whose own bend of the same size is
   turned by an angle. */
static void Curve(PetscReal twisting, PetscReal bending, PetscReal angle, SpinPlace place[N]) {
  for (PetscInt i = 0; i < N; i++)
    place[i] = (SpinPlace){.s = (PetscReal)i / (N - 1),
                           .g = 1,
                           .S = {twisting, bending, bending},
                           .u0 = {0, PetscSinReal(angle), PetscCosReal(angle)},
                           .u = {0, 0, 1}};
}

/* A straight rod under a torque is twisted evenly, by T L/C. */
static void TestTwist(void **state) {
  const PetscReal C = 0.5, T = 2;
  PetscReal turn[N], off = 0;
  SpinPlace place[N];

  (void)state;
  Curve(C, 1, 0, place);
  for (PetscInt i = 0; i < N; i++) place[i].u[2] = place[i].u0[2] = 0;
  CHECK(SpinRest(N, place, T, PETSC_FALSE, turn));
  for (PetscInt i = 0; i < N; i++) off = PetscMax(off, PetscAbsReal(turn[i] - T / C * place[i].s));
  EXPECT(off < 1e-12, "off by %g", (double)off);
}

/* One that is bent against its own bend by more than a quarter turn, where pure steps of Newton's
   method go uphill, comes to rest: no part of it feels a moment about the tangent. */
static void TestBend(void **state) {
  const PetscReal angle[] = {0.4, 1.4, 2.2, 3.0};
  SpinPlace place[N];

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(angle); k++) {
    const PetscReal h = 1. / (N - 1), C = 0.01;
    PetscReal turn[N], most = 0;
    Curve(C, 1, angle[k], place);
    CHECK(SpinRest(N, place, 0, PETSC_FALSE, turn));
    for (PetscInt i = 1; i + 1 < N; i++) {
      const PetscReal bends = PetscSinReal(turn[i] - angle[k]);
      PetscReal left = C * (turn[i + 1] - 2 * turn[i] + turn[i - 1]) / (h * h) - bends;
      most = PetscMax(most, PetscAbsReal(left));
    }
    EXPECT(most < 1e-9, "angle %g: a moment of %g is left", (double)angle[k], (double)most);
    EXPECT(turn[N - 1] > 0 && turn[N - 1] < angle[k] + 1e-6,
           "angle %g: turns by %g, not the short way", (double)angle[k], (double)turn[N - 1]);
  }
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestTwist), cmocka_unit_test(TestBend)};
MAIN(tests)
