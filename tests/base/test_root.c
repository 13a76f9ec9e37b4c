/* A root by false position: found in few looks, also of a function that is no straight line, and of
   one that is no number at first.
   test: roots are found to the last digit within their bounds */
#include "harness.h"
#include "base/root.h"

typedef struct {
  int kind, looks;
  PetscReal last;
} Look;

static PetscErrorCode At(void *of, PetscReal t, PetscReal *f) {
  Look *look = (Look *)of;

  PetscFunctionBegin;
  look->looks++;
  look->last = t;
  if (look->kind == 0) *f = 3 * (t - 0.7);
  if (look->kind == 1) *f = t * t * t * t * t - 0.5;
  if (look->kind == 2) *f = PetscExpReal(20 * t) - PetscExpReal(10);
  if (look->kind == 3) *f = t < 0.2 ? PETSC_MIN_REAL : PetscLogReal(t / 0.4);
  if (look->kind == 4) *f = PetscPowReal(0.5, 15) - PetscPowReal(1 - t, 15);
  PetscFunctionReturn(0);
}

static void TestFind(void **state) {
  const PetscReal exact[] = {0.7, PetscPowReal(0.5, 0.2), 0.5, 0.4};
  const int most[] = {3, 12, 20, 12}; /* halves alone take 42 */

  for (int kind = 0; kind < 4; kind++)
    for (int scale = 0; scale < 2; scale++) {
      Look look = {.kind = kind};
      const PetscReal precision = scale ? 1e-6 : 2e-13;
      PetscReal fa, fb, root;
      CHECK(At(&look, 0, &fa));
      CHECK(At(&look, 1, &fb));
      look.looks = 0;
      CHECK(RootFind(At, &look, 0, fa, 1, fb, precision, &root));
      EXPECT(PetscAbsReal(root / exact[kind] - 1) < 2 * precision, "%d: root %g, off by %g", kind,
             root, root - exact[kind]);
      EXPECT(look.last == root, "%d: looked at %g last, not %g", kind, look.last, root);
      EXPECT(look.looks <= most[kind], "%d: %d looks", kind, look.looks);
    }
}

/* Flat towards the far end, where places follow each other closely that are no root. */
static void TestFlat(void **state) {
  Look look = {.kind = 4};
  PetscReal fa, fb, root;

  CHECK(At(&look, 0, &fa));
  CHECK(At(&look, 1, &fb));
  CHECK(RootFind(At, &look, 0, fa, 1, fb, 1e-3, &root));
  EXPECT(PetscAbsReal(root / 0.5 - 1) < 2e-3, "root %g after %d looks", root, look.looks);
}

/* What is 0 at the end is there. */
static void TestAtTheEnd(void **state) {
  Look look = {0};
  PetscReal root;

  CHECK(RootFind(At, &look, 0, -2.1, 0.7, 0, 1e-12, &root));
  EXPECT(root == 0.7 && !look.looks, "%g after %d looks", root, look.looks);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestFind), cmocka_unit_test(TestFlat),
                                          cmocka_unit_test(TestAtTheEnd)};
MAIN(tests)
