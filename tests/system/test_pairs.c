/* Rods that press on each other, each in a frame of its own: derivatives by rate, forces that
   cancel, the power of what they give each other, and laws for each two of them.
   test: rods press on each other with the derivatives and the powers of their forces */
#include "../rod/by_rate.h"
#include "rod/ask.h"
#include "system/model.h"

enum { RODS = 3 };

/* Two rods cross a third, one of which is fed; the third is bent, and thinner. */
static const char *const shared =
    "-ts_max_time 2 -shape_type straight -rod_cells 12 -friction_mu 0.7 -friction_beta 0.1 "
    "-friction_newton primal -growth_type none -contact_diameter 0.09 -growth_initial_length 1 ";
static const char *const own[RODS] = {
    "", "-clamp_place 0.4,-0.3,0.08 -clamp_direction 0.1,1,0.02 -growth_type feed",
    "-clamp_place 0.6,0.5,-0.03 -clamp_direction 0.05,-1,-0.06 -rod_curvature 0.2 "
    "-contact_diameter 0.06 -rod_torsion 0.6"};

typedef struct {
  Scene scene[RODS];
  Rod each[RODS], all;
  Strands strands;
  PetscReal friction;
} World;

static PetscErrorCode Meet(void *ctx, PetscInt a, PetscInt b, StrandMeeting *how) {
  PetscFunctionBegin;
  EXPECT(a < b, "%d before %d", (int)a, (int)b);
  *how = (StrandMeeting){.touch = PETSC_TRUE, .friction = ((const World *)ctx)->friction};
  if (a == 0 && b == 2) how->stiffness = 200;
  PetscFunctionReturn(0);
}

static void Create(PetscReal friction, const char *more, World *world) {
  world->friction = friction;
  for (int k = 0; k < RODS; k++) {
    SetOptions("%s -contact_stiffness 300 %s %s", shared, own[k], more);
    CHECK(SceneCreateOn(NULL, PETSC_TRUE, &world->scene[k]));
    world->scene[k]->space.rod = PETSC_TRUE;
    CHECK(RodCreate(world->scene[k], &rod_space, &world->each[k]));
  }
  CHECK(StrandsCreateSeveral(RODS, world->scene, Meet, world, &world->strands));
  CHECK(SystemCreate(RODS, world->each, NULL, world->strands, &world->all));
}

static void Destroy(World *world) {
  CHECK(RodDestroy(&world->all));
  CHECK(StrandsDestroy(&world->strands));
  for (int k = 0; k < RODS; k++) CHECK(SceneDestroy(&world->scene[k]));
}

/* All as they begin, shaken. */
static void Shaken(World *world, PetscReal shake, Vec *U, Vec *U_t) {
  const Rod all = world->all;
  Node *nodes;

  *U = RandomVector(all, 1, 0);
  *U_t = RandomVector(all, 2, 1);
  CHECK(PetscMalloc1(all->last + 1, &nodes));
  for (int k = 0; k < RODS; k++) {
    const Rod rod = all->each[k];
    Vec part;
    CHECK(RodInitialNodes(rod, 0, nodes));
    CHECK(RodPartOpen(all, k, *U, &part));
    CHECK(rod->model->set(rod, 0, nodes, part));
    CHECK(RodPartClose(all, k, *U, &part));
  }
  CHECK(PetscFree(nodes));
  if (shake > 0) {
    Vec noise = RandomVector(all, 1, shake);
    CHECK(VecAXPY(*U, 1, noise));
    CHECK(VecDestroy(&noise));
  }
}

static void TestJacobian(void **state) {
  static const char *const mores[] = {"", "-rod_order 2", "-tip_type pinned"};

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(mores); k++)
    for (int rubs = 0; rubs < 2; rubs++) {
      World world;
      RodState at;
      Vec U, U_t, w;
      Mat J;
      Create(rubs * 0.6, mores[k], &world);
      Shaken(&world, 3e-3, &U, &U_t);
      at = StateOf(0, U, U_t, 1.7);
      CHECK(RodCreateMatrix(world.all, &J));
      w = RandomVector(world.all, 3, 1);
      CHECK(VecScale(w, 0));
      CHECK(world.all->model->residual(world.all, &at, w));
      CHECK(VecDestroy(&w));
      w = RandomVector(world.all, 3, 1);
      CHECK(world.all->model->jacobian(world.all, &at, J));
      ExpectRate(world.all, &at, J, w, 1e-6, 0.2, mores[k]);
      CHECK(MatDestroy(&J));
      CHECK(VecDestroy(&U));
      CHECK(VecDestroy(&U_t));
      CHECK(VecDestroy(&w));
      Destroy(&world);
    }
}

/* The energy of all contacts in a state. */
static PetscReal Energy(World *world, const StrandState *at, PetscReal moved[RODS]) {
  PetscReal energy = 0;

  CHECK(StrandsSearch(world->strands, at));
  CHECK(StrandsLoad(world->strands, at));
  for (int k = 0; k < RODS; k++) {
    StrandSum sum;
    StrandsSum(world->strands, k, &sum);
    energy += sum.energy;
    moved[k] = sum.moved;
  }
  return energy;
}

/* Forces cancel, and so does what rods give each other; along a motion the powers of a rod's forces
   are what it gets, less what its part of the energy does. */
static void TestForcesCancel(void **state) {
  PetscReal normal = 0, all[3] = {0}, given = 0, moved[RODS];
  World world;
  Vec U, U_t;

  (void)state;
  Create(0.6, "", &world);
  Shaken(&world, 0, &U, &U_t);
  StrandState at = {.t = 0, .stride = world.all->model->fields};
  CHECK(VecGetArrayRead(U, &at.u));
  CHECK(VecGetArrayRead(U_t, &at.u_t));
  EXPECT(Energy(&world, &at, moved) > 0, "nothing touches");
  for (int k = 0; k < RODS; k++) {
    StrandSum sum;
    StrandsSum(world.strands, k, &sum);
    print_message("rod %d: presses by %g, is given %g, loses %g; zones %d\n", k, (double)sum.normal,
                  (double)sum.moved, (double)sum.loss, (int)sum.zones);
    EXPECT(sum.normal > 0.01 && sum.loss > 0, "rod %d: %g, %g", k, sum.normal, sum.loss);
    EXPECT(sum.zones == (k ? 0 : 2), "rod %d: %d zones", k, (int)sum.zones);
    normal += sum.normal;
    given += sum.moved;
    for (int d = 0; d < 3; d++) all[d] += sum.sum[d];
  }
  for (int d = 0; d < 3; d++)
    EXPECT(PetscAbsReal(all[d]) < 1e-12 * normal, "%g of %g", all[d], normal);
  EXPECT(PetscAbsReal(given) < 1e-12 * normal && moved[0] != 0, "given %g", given);
  CHECK(VecRestoreArrayRead(U, &at.u));
  CHECK(VecRestoreArrayRead(U_t, &at.u_t));
  CHECK(VecDestroy(&U));
  CHECK(VecDestroy(&U_t));
  Destroy(&world);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestJacobian),
                                          cmocka_unit_test(TestForcesCancel)};
MAIN(tests)
