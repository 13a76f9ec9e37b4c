/* Which strands of a rod are kept as pairs that may come to touch.
   test: strands that may touch before they are looked for again are known */
#include "harness.h"
#include "rod/strand_pairs.h"

/* Pairs of two strands of a rod of diameter 0.1 that is bent back, so far apart; then again when
   it has moved so far, without a new search if it is not far: 1 if there was one. */
static PetscBool Pairs(PetscReal apart, PetscReal moved, PetscBool *again) {
  enum { CELLS = 20, STRIDE = 7 };
  PetscReal u[(CELLS + 1) * STRIDE] = {0}, seen;
  StrandState at = {.stride = STRIDE, .u = u};
  Strands strands;
  PetscBool any;
  Scene scene;

  SetOptions("-ts_max_time 2 -growth_type none -growth_initial_length 4 -shape_type straight "
             "-rod_cells 20 "
             "-contact_self true -contact_diameter 0.1");
  CHECK(SceneCreate(&scene));
  scene->space.rod = PETSC_TRUE;
  CHECK(StrandsCreate(scene, &strands));
  for (PetscInt i = 0; i <= CELLS; i++) { /* there, round, and back */
    PetscReal *x = u + i * STRIDE;
    x[0] = i <= CELLS / 2 ? 0.2 * i : 0.2 * (CELLS - i);
    x[1] = i <= CELLS / 2 ? 0 : apart;
    x[i < CELLS / 2 ? 3 : 6] = 1;
  }
  CHECK(StrandsSearch(strands, &at));
  any = (PetscBool)(strands->n > 0);
  seen = strands->seen[1];
  for (PetscInt i = 0; i <= CELLS; i++) u[i * STRIDE + 1] += moved;
  strands->searched = PETSC_FALSE;
  CHECK(StrandsLoad(strands, &at));
  *again = (PetscBool)(strands->seen[1] != seen);
  CHECK(StrandsDestroy(&strands));
  CHECK(SceneDestroy(&scene));
  return any;
}

/* Strands that may touch before they are looked for again are known, others are not; they are
   looked for when one has moved by as far as that takes. */
static void TestPairs(void **state) {
  PetscBool again;

  (void)state;
  EXPECT(Pairs(0.12, 0.01, &again), "a fifth of a diameter from touching");
  EXPECT(!again, "moved by a tenth of it");
  EXPECT(Pairs(0.12, 0.05, &again) && again, "moved by half of it: no new search");
  EXPECT(!Pairs(0.25, 0, &again), "more than a diameter from touching");
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestPairs)};
MAIN(tests)
