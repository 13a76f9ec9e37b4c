/* Cells eliminated one by one give what the assembled matrix does.
   test: cells eliminated one by one give what the matrix does | ranks 1 2 3 */
#include "harness.h"
#include "base/chain.h"
#include "rod/by_rate.h"
#include "rod/learned.h"
#include <petscksp.h>

enum { FIELDS = 6 }; /* where nothing is learned */

typedef struct {
  Scene scene;
  Rod rod;
  Vec U, U_t, b, x, y;
  Mat J;
  KSP ksp[2]; /* by the matrix, by elimination */
  Elimination elimination;
} Case;

static void Open(Case *c, const char *options) {
  PetscInt n, halves[2];
  Node *nodes;
  Mat none;
  PC pc;

  SetOptions("-shape_amplitude 2 -rod_cells 40 -ts_max_time 2 %s", options);
  CHECK(SceneCreate(&c->scene));
  c->scene->space.rod = (PetscBool)(strstr(options, "-rod_model space") != NULL);
  CHECK(RodCreate(c->scene, c->scene->space.rod ? &rod_space : &rod_frame, &c->rod));
  CHECK(RodHoldTip(c->rod));
  n = c->rod->end - c->rod->first;
  CHECK(PetscMalloc1(n, &nodes));
  CHECK(RodInitialNodes(c->rod, 0.7, nodes));
  CHECK(DMCreateGlobalVector(c->rod->da, &c->U));
  CHECK(c->rod->model->set(c->rod, 0.7, nodes, c->U));
  CHECK(PetscFree(nodes));
  CHECK(VecDuplicate(c->U, &c->U_t));
  CHECK(VecCopy(c->U, c->U_t)); /* growing in proportion */
  CHECK(VecDuplicate(c->U, &c->b));
  CHECK(VecDuplicate(c->U, &c->x));
  CHECK(VecDuplicate(c->U, &c->y));
  CHECK(RodCreateMatrix(c->rod, &c->J));
  LearnedHalves(c->rod, halves);
  CHECK(EliminationCreate(PETSC_COMM_WORLD, n, halves, &c->elimination));
  for (int k = 0; k < 2; k++) {
    CHECK(KSPCreate(PETSC_COMM_WORLD, &c->ksp[k]));
    CHECK(KSPSetType(c->ksp[k], KSPPREONLY));
    CHECK(KSPGetPC(c->ksp[k], &pc));
    if (k && c->rod->learned)
      CHECK(LearnedSetType(pc, c->rod, c->elimination));
    else if (k)
      CHECK(EliminationSetType(pc, c->elimination));
    else
      CHECK(ChainSetType(pc, MATORDERINGNATURAL));
  }
  n *= c->rod->model->fields;
  CHECK(MatCreateShell(PETSC_COMM_WORLD, n, n, PETSC_DETERMINE, PETSC_DETERMINE, NULL, &none));
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
    for (int f = 0; f < c.rod->model->fields; f++)
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

/* What is learned is eliminated where it is; where growth feels force its speed and length go along
   the rod, on one rank, past posts between its nodes, and in space, too. */
static void TestLearned(void **state) {
  static const char *const senses[] = {"", "-tropism_sensed tip -tropism_memory 0.4",
                                       "-tropism_light 1 -tropism_source 4,5 -tropism_memory 0.4"};
  static const char *const grows[] = {"uniform", "feed -tropism_rate 0.7",
                                      "apical -growth_zone 0.5"};
  char options[400], post[64];
  PetscMPIInt ranks;

  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  WriteWalls(post, "circle 0.2844 0.4475 0.01 outside friction 0.5\n");
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(senses); k++)
    for (int yields = 0; yields < (ranks > 1 ? 1 : 3); yields++) {
      (void)snprintf(options, sizeof(options),
                     "-growth_type %s %s -tropism_gravity 2 -tropism_direction 0.3,-1 "
                     "-tropism_proprioception 1.5 %s%s",
                     grows[k], yields ? "-growth_yield 30" : "", senses[k],
                     yields == 2 ? " -rod_model space -rod_curvature_2 0.4 -friction_radius 0.1"
                                 : "");
      Compare(options);
    }
  (void)snprintf(
      options, sizeof(options),
      "-growth_yield 30 -shape_amplitude 1.5 -clamp_angle 0.3 -rod_cells 12 -wall_file %s "
      "-contact_diameter 0.05 -contact_stiffness 4e3",
      post);
  if (ranks == 1) Compare(options);
  RemoveFile(post);
}

/* A line of nodes of any sizes that there are, whose cells are near those of fine ones: each
   equation is met. */
static void TestHalves(void **state) {
  enum { CELLS = 30, MOST = HALVES_MOST };
  static const PetscInt sizes[][2] = {{7, 6}, {4, 4}, {8, 7}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(sizes); k++) {
    const PetscInt top = sizes[k][0], all = top + sizes[k][1];
    PetscReal cell[CELLS][2][MOST * MOST], own[MOST * MOST], x[(CELLS + 1) * MOST],
        b[(CELLS + 1) * MOST], first[MOST * MOST];
    PetscInt n = 0;
    Halves line;

    assert_true(HalvesCan(sizes[k]));
    CHECK(HalvesCreate(CELLS + 1, sizes[k], &line));
    HalvesBegin(line);
    for (PetscInt i = 0; i < top * all; i++)
      first[i] = HalvesFirst(line)[i] += 0.3 * Scatter(11, n++);
    for (PetscInt i = 0; i < CELLS; i++) {
      PetscReal *at[2];
      HalvesBlocks(line, &at[0], &at[1]);
      for (int e = 0; e < 2; e++)
        for (PetscInt j = 0; j < all * all; j++)
          cell[i][e][j] = at[e][j] = (j % (all + 1) ? 0 : 2 * e - 1) + 0.1 * Scatter(12, n++);
      HalvesCell(line);
    }
    for (PetscInt i = 0; i < (all - top) * all; i++)
      own[i] = (i % all == top + i / all) + 0.3 * Scatter(13, n++);
    HalvesEnd(line, own);
    assert_true(HalvesRegular(line));
    for (PetscInt i = 0; i < (CELLS + 1) * all; i++) b[i] = Scatter(14, i);
    HalvesSolve(line, b, x);
    for (PetscInt i = 0; i < (CELLS + 1) * all; i++) {
      const PetscInt node = i / all, f = i % all, from = f < top ? node - 1 : node;
      const PetscReal *row[2] = {from < 0 ? first + f * all : NULL,
                                 from == CELLS ? own + (f - top) * all : NULL};
      PetscReal sum = -b[i], size = 0;
      for (int e = 0; e < 2; e++) {
        const PetscReal *by = from < 0 || from == CELLS ? row[e] : cell[from][e] + f * all,
                        *at = x + (from < 0        ? 0
                                   : from == CELLS ? from
                                                   : from + e) *
                                      all;
        for (PetscInt j = 0; j < all && by; j++) {
          sum += by[j] * at[j];
          size += PetscAbsReal(by[j] * at[j]);
        }
      }
      EXPECT(PetscAbsReal(sum) <= 1e-10 * (1 + size), "%d + %d, node %d, equation %d: %g of %g",
             (int)top, (int)(all - top), (int)node, (int)f, sum, size);
    }
    CHECK(HalvesDestroy(&line));
  }
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

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestHalves), cmocka_unit_test(TestLearned), cmocka_unit_test(TestModel),
    cmocka_unit_test(TestWorld),  cmocka_unit_test(TestHard),    cmocka_unit_test(TestIndex),
    cmocka_unit_test(TestHeld),   cmocka_unit_test(TestEnds)};
MAIN(tests)
