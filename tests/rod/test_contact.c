/* Contact: Jacobians by rate with walls and with strands of the rod that press on each other, forces
   that cancel, feet that are feet. */
#include "rod/by_rate.h"
#include "rod/strands.h"

static void WriteWalls(char path[64], const char *text) {
  PetscMPIInt rank;
  OpenScratch(path);
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (!rank) {
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
}

/* The initial shape, shaken a little, with rates of order 1. */
static void Shaken(Rod rod, PetscReal t, PetscReal shake, Vec *U, Vec *U_t) {
  Node *nodes;
  Vec noise = RandomVector(rod, 1, shake);
  CHECK(PetscMalloc1(rod->end - rod->first, &nodes));
  CHECK(RodInitialNodes(rod, t, nodes));
  CHECK(VecDuplicate(noise, U));
  CHECK(rod->model->set(rod, t, nodes, *U));
  CHECK(VecAXPY(*U, 1, noise));
  CHECK(PetscFree(nodes));
  CHECK(VecDestroy(&noise));
  *U_t = RandomVector(rod, 2, 1);
}

static void ByRate(const char *options, PetscReal shift, PetscReal shake) {
  const PetscReal t = 0.7, e = 1e-5;
  PetscReal coarse[MAX_FIELDS], fine[MAX_FIELDS], entry;
  Scene scene;
  Rod rod;
  Vec U, U_t, w;
  Mat J;
  SetOptions("-friction_mu 0.7 -friction_beta 0.1 -friction_newton primal -ts_max_time 2 %s",
             options);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, &rod_frame, &rod));
  Shaken(rod, t, shake, &U, &U_t);
  w = RandomVector(rod, 3, 1);
  CHECK(RodCreateMatrix(rod, &J));
  rod->fresh = PETSC_TRUE;
  CHECK(RodResidual(NULL, t, U, U_t, w, rod));
  CHECK(VecDestroy(&w));
  w = RandomVector(rod, 3, 1);
  CHECK(RodJacobian(NULL, t, U, U_t, shift, J, J, rod));
  CHECK(MatNorm(J, NORM_INFINITY, &entry));
  Remainder(rod, t, U, U_t, shift, J, w, e, coarse);
  Remainder(rod, t, U, U_t, shift, J, w, e / 2, fine);
  for (PetscInt f = 0; f < rod->model->fields; f++) {
    PetscReal ratio = coarse[f] / fine[f];
    if (fine[f] < 1e-15 * entry) continue;
    EXPECT(ratio > 3.8 && ratio < 4.2, "%s, shift %g, equation of %s: %g to %g, ratio %g", options,
           shift, rod->model->field[f], coarse[f], fine[f], ratio);
  }
  CHECK(MatDestroy(&J));
  CHECK(VecDestroy(&U));
  CHECK(VecDestroy(&U_t));
  CHECK(VecDestroy(&w));
  CHECK(RodDestroy(&rod));
  CHECK(SceneDestroy(&scene));
}

/* A spiral of a turn and a half, whose turns press on each other; fed or growing. */
static const char *const spiral[] = {
    "-growth_type uniform -growth_initial_length 0.5 -rod_curvature 22 -shape_amplitude -3 "
    "-rod_cells 40 -contact_self -contact_diameter 0.09 -contact_stiffness 300",
    "-growth_type feed -growth_initial_length 0.5 -rod_curvature 22 -shape_amplitude -3 "
    "-rod_cells 40 -contact_self -contact_diameter 0.09 -contact_stiffness 300"};

static void TestStrandJacobians(void **state) {
  for (int k = 0; k < 2; k++) {
    char more[512];
    snprintf(more, sizeof(more), "%s -contact_friction 0.6", spiral[k]);
    ByRate(spiral[k], 3, 1e-3);
    ByRate(spiral[k], 0, 1e-3);
    ByRate(more, 3, 1e-3);
    ByRate(more, 0, 1e-3);
  }
}

static void TestWallJacobians(void **state) {
  const char *const walls[] = {"plane 0 0.4 0.2 -1 friction 0.5\nplane 0.9 0 -1 0.1\n",
                               "circle 0.5 0.6 0.5 outside\ncircle 0.3 0.2 0.5 inside friction 1\n",
                               "polygon outside 0.3 0.2 0.8 0.1 0.9 0.9 0.4 0.8\n",
                               "path 0.2 -0.2 0 0.4 0 0.5 0.8 friction 0.3\n"};
  for (size_t k = 0; k < sizeof(walls) / sizeof(walls[0]); k++) {
    char file[64], options[256];
    WriteWalls(file, walls[k]);
    snprintf(options, sizeof(options),
             "-wall_file %s -contact_diameter 0.2 -contact_stiffness 40 -shape_amplitude 1.5 "
             "-clamp_angle 0.3 -rod_cells 24",
             file);
    ByRate(options, 3, 1e-2);
    ByRate(options, 0, 1e-2);
    RemoveFile(file);
  }
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestWallJacobians),
                                          cmocka_unit_test(TestStrandJacobians)};
MAIN(tests)
