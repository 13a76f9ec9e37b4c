/* Cells eliminated one by one give what the assembled matrix does.
   test: cells eliminated one by one give what the matrix does | ranks 1 2 3 */
#include "harness.h"
#include "base/chain.h"
#include "rod/by_rate.h"
#include <petscksp.h>

enum { FIELDS = 6 };

typedef struct {
  Scene scene;
  Rod rod;
  Vec U, U_t, b, x, y;
  Mat J;
  KSP ksp[2]; /* by the matrix, by elimination */
  Elimination elimination;
} Case;

static void Open(Case *c, const char *options) {
  PetscInt n;
  Node *nodes;
  Mat none;
  PC pc;

  SetOptions("-shape_amplitude 2 -rod_cells 40 -ts_max_time 2 %s", options);
  CHECK(SceneCreate(&c->scene));
  CHECK(RodCreate(c->scene, &rod_frame, &c->rod));
  CHECK(RodHoldTip(c->rod));
  n = c->rod->end - c->rod->first;
  CHECK(PetscMalloc1(n, &nodes));
  CHECK(RodInitialNodes(c->rod, 0.7, nodes));
  CHECK(DMCreateGlobalVector(c->rod->da, &c->U));
  CHECK(rod_frame.set(c->rod, 0.7, nodes, c->U));
  CHECK(PetscFree(nodes));
  CHECK(VecDuplicate(c->U, &c->U_t));
  CHECK(VecCopy(c->U, c->U_t)); /* growing in proportion */
  CHECK(VecDuplicate(c->U, &c->b));
  CHECK(VecDuplicate(c->U, &c->x));
  CHECK(VecDuplicate(c->U, &c->y));
  CHECK(RodCreateMatrix(c->rod, &c->J));
  CHECK(EliminationCreate(PETSC_COMM_WORLD, n, rod_frame.halves, &c->elimination));
  for (int k = 0; k < 2; k++) {
    CHECK(KSPCreate(PETSC_COMM_WORLD, &c->ksp[k]));
    CHECK(KSPSetType(c->ksp[k], KSPPREONLY));
    CHECK(KSPGetPC(c->ksp[k], &pc));
    if (k)
      CHECK(EliminationSetType(pc, c->elimination));
    else
      CHECK(ChainSetType(pc, MATORDERINGNATURAL));
  }
  CHECK(MatCreateShell(PETSC_COMM_WORLD, n * FIELDS, n * FIELDS, PETSC_DETERMINE, PETSC_DETERMINE,
                       NULL, &none));
  CHECK(KSPSetOperators(c->ksp[1], none, none));
  CHECK(MatDestroy(&none));
}

static void Close(Case *c) {
  for (int k = 0; k < 2; k++) CHECK(KSPDestroy(&c->ksp[k]));
  CHECK(EliminationDestroy(&c->elimination));
  CHECK(MatDestroy(&c->J));
  CHECK(VecDestroy(&c->U));
  CHECK(VecDestroy(&c->U_t));
  CHECK(VecDestroy(&c->b));
  CHECK(VecDestroy(&c->x));
  CHECK(VecDestroy(&c->y));
  CHECK(RodDestroy(&c->rod));
  CHECK(SceneDestroy(&c->scene));
}

/* The largest of J x - b; |b| is 1. */
static PetscErrorCode Residual(Case *c, Vec x, PetscReal *residual) {
  Vec r;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(x, &r));
  PetscCall(MatMult(c->J, x, r));
  PetscCall(VecAXPY(r, -1, c->b));
  PetscCall(VecNorm(r, NORM_INFINITY, residual));
  PetscCall(VecDestroy(&r));
  PetscFunctionReturn(0);
}

static void Compare(const char *options) {
  const PetscReal shifts[] = {3, 500, 1e6};
  Case c;

  Open(&c, options);
  for (int k = 0; k < 3; k++) {
    PetscInt low, high;
    PetscReal size[MAX_FIELDS], error[MAX_FIELDS], residual[2];
    PetscScalar *a;
    RodState at = StateOf(0.7, c.U, c.U_t, shifts[k]);
    for (int i = 0; i < 2; i++) /* the duals have settled in the second */
      CHECK(c.rod->model->jacobian(c.rod, &at, c.J));
    CHECK(KSPSetOperators(c.ksp[0], c.J, c.J));
    CHECK(c.rod->model->eliminate(c.rod, &at, c.elimination));
    CHECK(VecGetOwnershipRange(c.b, &low, &high));
    CHECK(VecGetArray(c.b, &a));
    for (PetscInt i = low; i < high; i++) a[i - low] = Scatter(7 + k, i);
    CHECK(VecRestoreArray(c.b, &a));
    CHECK(KSPSolve(c.ksp[0], c.b, c.x));
    CHECK(KSPSolve(c.ksp[1], c.b, c.y));
    /* both solve as well as each other */
    CHECK(Residual(&c, c.x, &residual[0]));
    CHECK(Residual(&c, c.y, &residual[1]));
    EXPECT(residual[1] <= 1e-14 + 10 * residual[0], "%s, shift %g: residual %g, of LU %g", options,
           shifts[k], residual[1], residual[0]);
    CHECK(RodFieldSizes(c.rod, c.x, size));
    CHECK(VecAXPY(c.x, -1, c.y));
    CHECK(RodFieldSizes(c.rod, c.x, error));
    for (int f = 0; f < FIELDS; f++)
      EXPECT(error[f] <= 1e-10 * size[f] + residual[0], "%s, shift %g, field %d: %g of %g", options,
             shifts[k], f, error[f], size[f]);
  }
  Close(&c);
}

static void TestModel(void **state) {
  Compare("");
  Compare("-rod_order 2");
  Compare("-growth_type gaussian -growth_width 0.05");
  Compare("-growth_type feed");
}

static void TestWorld(void **state) {
  PetscMPIInt ranks;

  Compare("-friction_across 2 -friction_layers 0:1,0.5:3");
  Compare("-tip_force 0.5 -tip_law follower");
  Compare("-tip_force 0.5 -tip_law resistance");
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1) return; /* several want a free tip */
  Compare("-tip_type pinned");
  Compare("-tip_type clamped");
}

static void TestHard(void **state) {
  Compare("-friction_beta 1e-12");
  Compare("-friction_beta 0");
  Compare("-friction_mu 0");
  Compare("-rod_cells 400 -friction_beta 1e-6 -growth_initial_length 0.01");
  Compare("-rod_cells 400 -growth_initial_length 30");
}

/* The index of a case whose state is set, at this shift; closes it. */
static PetscInt IndexOf(Case *c, PetscReal shift) {
  RodState at = StateOf(0.7, c->U, c->U_t, shift);
  PetscInt index;

  at.counts = PETSC_TRUE;

  CHECK(c->rod->model->eliminate(c->rod, &at, c->elimination));
  CHECK(EliminationIndex(c->elimination, &index));
  Close(c);
  return index;
}

/* The index of an almost straight viscous rod of length 1 under this force along it, at this shift.
 */
static PetscInt Index(const char *ends, PetscReal force, PetscReal shift) {
  enum { N1 = 4 };
  char options[256];
  PetscInt n;
  PetscScalar *u;
  Case c;

  (void)snprintf(options, sizeof(options),
                 "-growth_initial_length 0.3 -friction_mu 0 -rod_cells 150 -shape_amplitude %s %s",
                 strstr(ends, "tip") ? "0.01" : "1e-4", ends);
  Open(&c, options);
  CHECK(VecGetLocalSize(c.U, &n));
  CHECK(VecGetArray(c.U, &u));
  for (PetscInt i = N1; i < n; i += FIELDS) u[i] = -force;
  CHECK(VecRestoreArray(c.U, &u));
  return IndexOf(&c, shift);
}

/* Buckled modes are counted: those of a free rod give way at P = ((k - 1/2) pi)^2. One of the rate
   r counts while the shift is below r. */
static void TestIndex(void **state) {
  const PetscReal forces[] = {-5, 1, 2, 3, 15, 30, 100, 400, 1000, 3000};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(forces); k++) {
    PetscReal P = forces[k];
    PetscInt modes = P > 0 ? (PetscInt)(PetscSqrtReal(P) / PETSC_PI + 0.5) : 0,
             index = Index("", P, 1e-3);
    EXPECT(index == modes, "P = %g: %d modes, not %d", P, (int)index, (int)modes);
    EXPECT(Index("", P, 1.5 * P * P) == 0, "P = %g: modes above its largest rate", P);
  }
  EXPECT(Index("", 30, 200) == 1, "two modes grow, one of them faster than 200");
}

/* Springs in place of a hinge, and of what holds a tip where several ranks meet, do not change the
   count. Modes of a rod in a hinge whose tip is free give way at (k pi)^2, from 0 on; those of one
   that slides along with its tip held across at 39.48 and 80.76, of a hinged one at 20.19
   and 59.68. */
static void TestEnds(void **state) {
  static const char hinged[] = "-clamp_type hinged", held[] = "-tip_type slides",
                    both[] = "-clamp_type hinged -tip_type slides";
  static const struct {
    const char *ends;
    PetscReal force;
    PetscInt index;
  } of[] = {{hinged, -5, 0}, {hinged, 5, 1}, {hinged, 12, 2}, {hinged, 100, 4}, {held, 39, 0},
            {held, 40, 1},   {held, 85, 2},  {both, 19.5, 0}, {both, 21, 1},    {both, 61, 2}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(of); k++) {
    PetscInt index = Index(of[k].ends, of[k].force, 1e-3);
    EXPECT(index == of[k].index, "%s, P = %g: %d modes, not %d", of[k].ends, of[k].force,
           (int)index, (int)of[k].index);
  }
}

/* The index of a rod under a force that friction, all but exact, holds here fast and there loosely,
   by three orders of magnitude more where it begins. */
static PetscInt HeldIndex(PetscReal force, PetscReal shift) {
  enum { N1 = 4, CELLS = 60 };
  PetscInt low, n;
  PetscScalar *u, *v;
  Case c;

  Open(&c, "-growth_initial_length 1 -growth_type feed -rod_cells 60 -friction_beta 1e-18 "
           "-shape_amplitude 1e-3");
  CHECK(VecGetOwnershipRange(c.U, &low, NULL));
  CHECK(VecGetLocalSize(c.U, &n));
  CHECK(VecGetArray(c.U, &u));
  CHECK(VecGetArray(c.U_t, &v));
  for (PetscInt i = 0; i < n; i += FIELDS) {
    PetscReal speed = PetscPowReal(1000, (PetscReal)(low + i) / (CELLS * FIELDS));
    u[i + N1] = -force;
    for (PetscInt f = 0; f < 3; f++) v[i + f] = speed * Scatter(1, low + i + f);
  }
  CHECK(VecRestoreArray(c.U, &u));
  CHECK(VecRestoreArray(c.U_t, &v));
  return IndexOf(&c, shift);
}

/* Friction is no energy's, and stiffer than cells are fine: all ranks count what one does. */
static void TestHeld(void **state) {
  const struct {
    PetscReal force, shift;
    PetscInt index;
  } one[] = {{2, 1, 1}, {200, 1, 8}, {200, 1e4, 7}, {200, 1e10, 0}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(one); k++) {
    PetscInt index = HeldIndex(one[k].force, one[k].shift);
    EXPECT(index == one[k].index, "P = %g, shift %g: %d modes, not %d", one[k].force, one[k].shift,
           (int)index, (int)one[k].index);
  }
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestModel), cmocka_unit_test(TestWorld),
                                          cmocka_unit_test(TestHard),  cmocka_unit_test(TestIndex),
                                          cmocka_unit_test(TestHeld),  cmocka_unit_test(TestEnds)};
MAIN(tests)
