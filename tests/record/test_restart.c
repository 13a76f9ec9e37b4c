/* Newton's method in a step, and the result file of a run that goes on.
   test: a result file holds what a run that goes on needs | ranks 1 2 */
#include "harness.h"
#include "record/output.h"

static const char *const dry =
    "-growth_initial_length 2 -shape_amplitude 0.1 -rod_cells 40 -ts_max_time 1";

static void Begin(const char *options, Scene *scene, Leg *leg) {
  Node *nodes;

  SetOptions("%s", options);
  CHECK(SceneCreate(scene));
  CHECK(LegCreate(*scene, &rod_frame, 1e-6, leg));
  CHECK(TSSetMaxTime(leg->ts, (*scene)->end_time));
  CHECK(PetscMalloc1(leg->rod->end - leg->rod->first, &nodes));
  CHECK(RodInitialNodes(leg->rod, 0, nodes));
  CHECK(leg->rod->model->set(leg->rod, 0, nodes, leg->U));
  CHECK(PetscFree(nodes));
}

static void End(Scene *scene, Leg *leg) {
  CHECK(LegDestroy(leg));
  CHECK(SceneDestroy(scene));
}

static void Steps(Leg *leg, PetscInt to) {
  CHECK(TSSetMaxSteps(leg->ts, to));
  CHECK(TSSolve(leg->ts, leg->U));
}

/* How far two states are from each other, relative to the first. */
static PetscReal Off(Vec a, Vec b) {
  PetscReal off, size;
  Vec d;

  CHECK(VecDuplicate(a, &d));
  CHECK(VecWAXPY(d, -1, a, b));
  CHECK(VecNorm(d, NORM_INFINITY, &off));
  CHECK(VecNorm(a, NORM_INFINITY, &size));
  CHECK(VecDestroy(&d));
  return off / size;
}

/* Eliminated as they are computed or assembled and factored, the equations have one solution; few
   iterations find it. */
static void TestNewton(void **state) {
  char options[256];
  PetscInt n[2];
  PetscReal t[2];
  Scene scene[2];
  Leg leg[2];

  for (int k = 0; k < 2; k++) {
    snprintf(options, sizeof(options), "%s %s", dry, k ? "-ksp_type preonly -mat_type aij" : "");
    Begin(options, &scene[k], &leg[k]);
    EXPECT(!leg[k].newton.elimination == k, "elimination of %s", options);
    Steps(&leg[k], 12);
    CHECK(TSGetSNESIterations(leg[k].ts, &n[k]));
    CHECK(TSGetTime(leg[k].ts, &t[k]));
  }
  EXPECT(n[0] == n[1] && n[0] < 60, "%d and %d iterations", (int)n[0], (int)n[1]);
  EXPECT(PetscAbsReal(t[0] / t[1] - 1) < 1e-6, "at t = %g and %g", t[0], t[1]);
  EXPECT(Off(leg[0].U, leg[1].U) < 1e-8, "off by %g", Off(leg[0].U, leg[1].U));
  for (int k = 0; k < 2; k++) End(&scene[k], &leg[k]);
}

/* Stores a leg, as a run does that is under way. */
static void Store(const char *path, Leg *leg, Scene scene) {
  Observation seen = {0};
  RestartState now = {0};
  Vec points[VBDF_POINTS];
  Output output;
  PetscReal t;

  CHECK(OutputCreate(path, scene, &output));
  EXPECT(OutputStores(output), "has no file");
  CHECK(TSGetTime(leg->ts, &t));
  for (int k = 0; k < 3; k++) { /* the series end with the state */
    seen.t = t * k / 2;
    CHECK(GrowthLength(scene->growth, seen.t, &seen.length, NULL));
    CHECK(OutputSeries(output, &seen));
  }
  CHECK(RestartKeep(leg, t, leg->U, &now, points));
  CHECK(OutputStore(output, leg->rod, &now, points, NULL, PETSC_FALSE));
  CHECK(OutputDestroy(&output));
}

/* What goes on from a file is, to the last bit, what had not stopped. */
static void TestRestart(void **state) {
  char path[64];
  RestartState was;
  PetscBool begun, has;
  PetscReal *t;
  PetscInt n;
  Output output;
  Scene scene[2];
  Leg leg[2];

  OpenScratch(path);
  Begin(dry, &scene[0], &leg[0]);
  Steps(&leg[0], 20);
  Store(path, &leg[0], scene[0]);
  CHECK(HdfHas(path, "interrupted", &has));
  EXPECT(has, "no attribute for an interruption");
  Begin(dry, &scene[1], &leg[1]);
  CHECK(RestartRead(path, scene[1], &was, &begun));
  EXPECT(begun && was.steps == 20 && was.points > 1, "%g steps, %g points", was.steps, was.points);
  CHECK(RestartTake(path, &was, &leg[1]));
  EXPECT(Off(leg[0].U, leg[1].U) == 0, "the state is off by %g", Off(leg[0].U, leg[1].U));
  for (int k = 0; k < 2; k++) Steps(&leg[k], 30);
  EXPECT(Off(leg[0].U, leg[1].U) == 0, "ten steps on off by %g", Off(leg[0].U, leg[1].U));
  /* what is behind the time that a run goes on from is taken off */
  CHECK(OutputContinue("", path, scene[1], was.t / 2, 1, &output));
  CHECK(OutputStore(output, leg[1].rod, NULL, NULL, NULL, PETSC_FALSE));
  CHECK(OutputDestroy(&output));
  CHECK(HdfRead("-restart", path, "/series/t", 1, &n, &t));
  EXPECT(n == 2 && t[1] == was.t / 2, "%d times, the last %g", (int)n, t[n - 1]);
  CHECK(PetscFree(t));
  for (int k = 0; k < 2; k++) End(&scene[k], &leg[k]);
  RemoveFile(path);
}

/* All that a run remembers comes back, each number by its name. */
static void TestNames(void **state) {
  RestartState kept, read;
  char path[64], fault[HDF_FAULT], *names;
  HdfFile file = NULL;
  PetscMPIInt rank;

  OpenScratch(path);
  for (PetscInt k = 0; k < RESTART_STATE; k++) ((PetscReal *)&kept)[k] = (PetscReal)k + 0.5;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (!rank) CHECK(HdfCreate(path, &file));
  CHECK(HdfGroup(file, "/restart"));
  CHECK(RememberedWrite(file, &kept));
  CHECK(HdfClose(&file, fault));
  MPI_Barrier(PETSC_COMM_WORLD);
  CHECK(RememberedRead(path, PETSC_COMM_WORLD, &read));
  EXPECT(!memcmp(&kept, &read, sizeof(kept)), "a restart goes on with less");
  CHECK(HdfReadText("-restart", path, "/restart/names", &names));
  EXPECT(strstr(names, "\nsnaps 1\n") && strstr(names, "\nseen.tip_x1 1\n"), "names: %s", names);
  CHECK(PetscFree(names));
  RemoveFile(path);
}

/* Without a file: what a sweep's member leaves in memory. */
static void TestHarvest(void **state) {
  Observation seen = {0};
  PetscMPIInt rank;
  Harvest harvest;
  Output output;
  Scene scene;

  SetOptions("%s", dry);
  CHECK(SceneCreate(&scene));
  CHECK(OutputCreate("", scene, &output));
  EXPECT(!OutputStores(output), "has a file");
  CHECK(OutputKeep(output, PETSC_TRUE, PETSC_FALSE));
  for (int k = 0; k < 5; k++) {
    seen.t = k;
    CHECK(OutputSeries(output, &seen));
  }
  CHECK(OutputHarvest(output, &seen, OBSERVED_ALWAYS, &harvest));
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  EXPECT(rank || (harvest.steps == 5 && harvest.shapes == 0 && harvest.data[0] == 4 &&
                  harvest.data[OBSERVED_ALWAYS * 3] == 2),
         "%d steps", (int)harvest.steps);
  CHECK(PetscFree(harvest.data));
  CHECK(OutputDestroy(&output));
  CHECK(SceneDestroy(&scene));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestNewton), cmocka_unit_test(TestRestart), cmocka_unit_test(TestNames),
    cmocka_unit_test(TestHarvest)};
MAIN(tests)
