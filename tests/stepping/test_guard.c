/* The guard: what the rod's curve has swept between two states, on any number of ranks; and what
   one rank alone sees.
   test: what the rod has swept between two states is seen | ranks 1 2 3 */
#include "harness.h"
#include "rod/crossing.h"
#include "rod/passing.h"
#include "stepping/guard.h"
#include "stepping/leg.h"

/* A rod of length 1, straight up to `bend` of it, then at an angle. */
static Vec State(Rod rod, PetscReal bend, PetscReal angle) {
  const PetscReal *s = rod->scene->mesh.s;
  Node *nodes;
  Vec U;
  CHECK(DMCreateGlobalVector(rod->da, &U));
  CHECK(PetscCalloc1(rod->end - rod->first, &nodes));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    Node *node = &nodes[i - rod->first];
    const PetscReal along = PetscMax(0, s[i] - bend);
    node->theta = s[i] > bend ? angle : 0;
    node->x[0] = PetscMin(s[i], bend) + along * PetscCosReal(angle);
    node->x[1] = along * PetscSinReal(angle);
    node->p[0] = PetscCosReal(node->theta / 2); /* in space */
    node->p[3] = PetscSinReal(node->theta / 2);
  }
  CHECK(rod->model->set(rod, 0, nodes, U));
  CHECK(PetscFree(nodes));
  return U;
}

static const char thread[] = "-growth_type feed -growth_initial_length 1 -shape_type straight "
                             "-rod_cells 20 -ts_max_time 2 ";

/* Does the rod of a model pass from one angle to another, bent at 0.2? */
static PetscBool PassesAs(const RodModel *model, const char *wall, const char *more, PetscReal from,
                          PetscReal to) {
  PetscBool passes;
  char file[64];
  Scene scene;
  Rod rod;
  Vec U[2];
  WriteWalls(file, wall);
  SetOptions("%s %s -wall_file %s", thread, more, file);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, model, &rod));
  U[0] = State(rod, 0.2, from);
  U[1] = State(rod, 0.2, to);
  CHECK(RodPassesWalls(rod, 0, 0, U[0], U[1], &passes));
  for (int k = 0; k < 2; k++) CHECK(VecDestroy(&U[k]));
  CHECK(RodDestroy(&rod));
  CHECK(SceneDestroy(&scene));
  RemoveFile(file);
  return passes;
}

static PetscBool Passes(const char *wall, const char *more, PetscReal from, PetscReal to) {
  return PassesAs(&rod_frame, wall, more, from, to);
}

/* Does a straight rod pass that moves across by so much? */
static PetscBool Leaves(const char *wall, PetscReal across) {
  PetscScalar *u;
  PetscBool passes;
  char file[64];
  Scene scene;
  Rod rod;
  Vec U[2];
  WriteWalls(file, wall);
  SetOptions("%s -contact_diameter 0.02 -wall_file %s", thread, file);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, &rod_frame, &rod));
  for (int k = 0; k < 2; k++) U[k] = State(rod, 0.2, 0);
  CHECK(VecGetArray(U[1], &u));
  for (PetscInt i = rod->first; i < rod->end; i++)
    u[(i - rod->first) * rod->model->fields + 1] += across;
  CHECK(VecRestoreArray(U[1], &u));
  CHECK(RodPassesWalls(rod, 0, 0, U[0], U[1], &passes));
  for (int k = 0; k < 2; k++) CHECK(VecDestroy(&U[k]));
  CHECK(RodDestroy(&rod));
  CHECK(SceneDestroy(&scene));
  RemoveFile(file);
  return passes;
}

/* Posts a hundredth of a cell wide, wherever they are on the rod: also between nodes, and between
   ranks. */
static void TestSweeps(void **state) {
  for (int k = 0; k < 25; k++) {
    const PetscReal at = 0.3 + 0.025 * k;
    char wall[128];
    snprintf(wall, sizeof(wall), "circle %.17g 0.05 5e-4 outside\n", (double)at);
    EXPECT(Passes(wall, "", 0, 1.2), "over a post at %g", at);
    EXPECT(Passes(wall, "", 1.2, 0), "back over a post at %g", at);
    EXPECT(!Passes(wall, "", 0, -1), "away from a post at %g", at);
    EXPECT(!Passes(wall, "", 1.2, 1.4) || at < 0.24, "beyond a post at %g", at);
  }
  EXPECT(!Passes("circle 1.3 0.05 5e-4 outside\n", "", -1, 1), "past a post before the tip");
}

/* Through a plate thinner than the rod's cells; across a corner of a polygon; in it. */
static void TestCuts(void **state) {
  const char *const soft = "-contact_stiffness 3.16e4";
  const char *const in_space = "-rod_model space -contact_stiffness 3.16e4";
  const char *const bend = "path 0.15 -1 0 1 0 1.38823 0.0511113 1.75 0.200962 2.06066 0.43934 "
                           "2.29904 0.75 2.44889 1.11177 2.5 1.5 2.5 5\n";
  const char *const plate = "polygon outside 0.4 0.2 0.9 0.2 0.9 0.2003 0.4 0.2003\n";
  EXPECT(Passes(plate, "-contact_diameter 1e-4", 0, 0.9), "ends across a plate");
  EXPECT(!Passes(plate, "-contact_diameter 1e-4", 0, 0.1), "stays before it");
  EXPECT(Passes(plate, "-contact_diameter 1e-4", 0, 1.5), "past all of it");
  EXPECT(Passes("polygon inside -1 -0.3 3 -0.3 3 0.3 -1 0.3\n", "-contact_diameter 0.01", 0, 1),
         "out of a box");
  EXPECT(!Passes("polygon inside -1 -0.3 3 -0.3 3 0.3 -1 0.3\n", "-contact_diameter 0.01", 0, 0.2),
         "within a box");
  EXPECT(Passes("plane 0 0.3 0 -1\n", "-contact_diameter 0.01", 0, 1), "behind a plane");
  /* A thread is behind a wall at 4 l, l = (B/k)^(1/4): 0.3 with this k, 0.012 with the usual one.
   */
  EXPECT(Passes("plane 0 0.3 0 -1\n", soft, 0, 1), "a thread far behind a plane");
  EXPECT(!Passes("plane 0 0.3 0 -1\n", soft, 0, 0.6), "a thread pressed into a plane");
  EXPECT(Passes("circle 0 0 0.6 inside\n", soft, 0, 0.1), "a thread far out of a cavity");
  EXPECT(!Passes("circle 0 0 0.8 inside\n", soft, 0, 0.1), "a thread pressed into its wall");
  EXPECT(Passes("plane 0 0.3 0 -1\n", "", 0, 0.42), "a thread behind a plane as stiff as usual");
  EXPECT(!Passes("plane 0 0.3 0 -1\n", "", 0, 0.39), "a thread pressed into it");
  EXPECT(!Passes(bend, "-contact_diameter 0.05", 0, 0),
         "the circle of a bend's last, gentle corner goes through its straight beginning");
  EXPECT(Passes("path 0.2 -1 0 0.6 0 0.6 2\n", "-contact_diameter 0.01", 0, 0.6),
         "across the inner wall of a conduit's corner");
  EXPECT(PassesAs(&rod_space, "plane 0 0.3 0  0 -1 0\n", in_space, 0, 1),
         "far behind one in space");
  EXPECT(!PassesAs(&rod_space, "plane 0 0.3 0  0 -1 0\n", in_space, 0, 0.6), "pressed into it");
}

/* In space: a ball that is small beside the cells, and a wire that a thread meets, thin beside the
   depth that counts as behind a wall, wherever they are; in a bent tube from one arm to the other,
   past what is between. */
static void TestSweepsSpace(void **state) {
  const char *const tube = "path 0.05 -1 0 3 0 3 0.5 -1 0.5\n";

  for (int k = 0; k < 5; k++) {
    const PetscReal at = 0.3 + 0.11 * k;
    char ball[128], wire[128];
    snprintf(ball, sizeof(ball), "sphere %.17g 0.05 0 0.004 outside\n", (double)at);
    snprintf(wire, sizeof(wire), "cylinder %.17g 0.05 0 0 0 1 5e-4 outside\n", (double)at);
    EXPECT(PassesAs(&rod_space, ball, "-rod_model space -contact_diameter 2e-3", 0, 1.2),
           "over a ball at %g", at);
    EXPECT(!PassesAs(&rod_space, ball, "-rod_model space -contact_diameter 2e-3", 0, -1),
           "away from it");
    EXPECT(PassesAs(&rod_space, wire, "-rod_model space", 0, 1.2), "over a wire at %g", at);
    EXPECT(!PassesAs(&rod_space, wire, "-rod_model space", 0, -1), "away from it");
  }
  EXPECT(Leaves(tube, 0.5), "from one arm of a tube into the other");
  EXPECT(!Leaves(tube, 0.02), "within an arm");
}

/* A ball goes round and round, and through a rod that rests, in a step of so many turns; does the
   rod see it? */
static PetscBool SeesGoingRound(PetscReal radius, PetscReal turns) {
  PetscBool passes;
  char file[64], wall[200];
  Scene scene;
  Rod rod;
  Vec U;
  snprintf(wall, sizeof(wall), "sphere 0 %.17g 0 0.004 outside turns %.17g 0 0 0 0 0 1\n",
           (double)radius, (double)(turns * 2 * PETSC_PI));
  WriteWalls(file, wall);
  SetOptions("%s -rod_model space -contact_diameter 2e-3 -wall_file %s", thread, file);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, &rod_space, &rod));
  U = State(rod, 0.2, 0);
  CHECK(RodPassesWalls(rod, 0, 1, U, U, &passes));
  CHECK(VecDestroy(&U));
  CHECK(RodDestroy(&rod));
  CHECK(SceneDestroy(&scene));
  RemoveFile(file);
  return passes;
}

static void TestGoesRound(void **state) {
  for (int k = 1; k < 4; k++) {
    EXPECT(SeesGoingRound(0.67, 3 * k), "%d turns through the rod", 3 * k);
    EXPECT(!SeesGoingRound(1.1, 3 * k), "%d turns past its tip", 3 * k);
  }
}

/* The tip alone is behind a wall, and the rod may touch itself, too: every rank ends the look, with
   the same verdict. */
static void TestOneRankKnows(void **state) {
  PetscBool passes;
  char file[64];
  Scene scene;
  Leg leg;
  Vec U[2];
  WriteWalls(file, "plane 0.97 0 -1 0\n");
  SetOptions("%s -wall_file %s -contact_diameter 0.02 -contact_self", thread, file);
  CHECK(SceneCreate(&scene));
  CHECK(LegCreate(scene, &rod_frame, 1e-6, &leg));
  U[0] = State(leg.rod, 0.2, 1);
  U[1] = State(leg.rod, 0.2, 0);
  CHECK(GuardPasses(leg.ts, 0, 0, U[0], U[1], &passes));
  EXPECT(passes && leg.passes, "the tip is behind the wall");
  CHECK(GuardPasses(leg.ts, 0, 0, U[0], U[0], &passes));
  EXPECT(!passes && !leg.passes, "nothing is");
  for (int k = 0; k < 2; k++) CHECK(VecDestroy(&U[k]));
  CHECK(LegDestroy(&leg));
  CHECK(SceneDestroy(&scene));
  RemoveFile(file);
}

/* A thread in space: out along x1, round, and back at height `back` and turned by `turn`, so that
   its ends cross as seen from above; moved on by `along`. */
static void Loop(PetscReal back, PetscReal turn, PetscReal along, Node node[6]) {
  const PetscReal c = PetscCosReal(turn), s = PetscSinReal(turn);
  const PetscReal at[6][3] = {{-1, 0, 0}, {1, 0, 0},    {2, 0, 0},
                              {2, 3, 0},  {s, c, back}, {-s, -c, back}};
  for (int i = 0; i < 6; i++)
    for (int d = 0; d < 3; d++) node[i].x[d] = at[i][d] + (d == 0 && i > 3 ? along : 0);
}

static PetscBool PassesItself(const PetscReal from[3], const PetscReal to[3]) {
  Node there[2][6] = {{{{0}}}};
  PetscBool passes, back;
  Loop(from[0], from[1], from[2], there[0]);
  Loop(to[0], to[1], to[2], there[1]);
  CHECK(RodPassesItself(6, NULL, there[0], there[1], &passes));
  CHECK(RodPassesItself(6, NULL, there[1], there[0], &back));
  EXPECT(passes == back, "there %d, and back %d", passes, back);
  return passes;
}

/* A strand that goes through another is seen, whatever the step; one that goes over it, or turns
   above it, or slides along, is not. */
static void TestPassesItself(void **state) {
  const struct {
    PetscReal from[3], to[3];
    PetscBool passes;
  } way[] = {
      {{0.1, 0, 0}, {-0.1, 0, 0}, PETSC_TRUE},        {{1e-9, 0, 0}, {-5, 0, 0}, PETSC_TRUE},
      {{0.1, 0.4, 0}, {-0.1, -0.5, 0.3}, PETSC_TRUE}, {{0.1, 0, 0}, {0.01, 0, 0}, PETSC_FALSE},
      {{0.1, -0.9, 0}, {0.1, 0.9, 0}, PETSC_FALSE},   {{0.1, 0, 0}, {0.1, 0, 5}, PETSC_FALSE},
      {{0.1, 0, 3.5}, {-0.1, 0, 3.5}, PETSC_FALSE},   {{0.1, 0, 0.5}, {-0.1, 0, 5}, PETSC_FALSE}};
  for (size_t k = 0; k < sizeof(way) / sizeof(way[0]); k++)
    EXPECT(PassesItself(way[k].from, way[k].to) == way[k].passes, "way %d", (int)k);
}

/* Two rods that lie in one plane: one that goes through the other is seen, lengthways and across,
   and what slides beside it or goes round it is not. */
static void TestPassInPlane(void **state) {
  const PetscInt of[5] = {0, 0, 0, 1, 1};
  const struct {
    PetscReal from[2][2], to[2][2]; /* of the second, x1 and x2; the first lies along x1 */
    PetscBool passes;
  } way[] = {{{{0.2, 2}, {0.2, 0.1}}, {{0.2, 2}, {0.2, -0.1}}, PETSC_TRUE},
             {{{-0.5, 0.1}, {0.5, 0.1}}, {{-0.5, -0.1}, {0.5, -0.1}}, PETSC_TRUE},
             {{{0.2, 2}, {0.2, 0.1}}, {{0.7, 2}, {0.7, 0.01}}, PETSC_FALSE},
             {{{1.2, 2}, {1.2, 0.1}}, {{1.2, 2}, {1.2, -0.1}}, PETSC_FALSE}};
  for (size_t k = 0; k < sizeof(way) / sizeof(way[0]); k++) {
    Node there[2][5] = {{{{0}}}};
    PetscBool passes;
    for (int i = 0; i < 3; i++) there[0][i].x[0] = there[1][i].x[0] = i - 1;
    for (int i = 0; i < 2; i++)
      for (int d = 0; d < 2; d++) {
        there[0][3 + i].x[d] = way[k].from[i][d];
        there[1][3 + i].x[d] = way[k].to[i][d];
      }
    CHECK(RodPassesItself(5, of, there[0], there[1], &passes));
    EXPECT(passes == way[k].passes, "way %d", (int)k);
  }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestPassInPlane), cmocka_unit_test(TestPassesItself),
    cmocka_unit_test(TestSweeps),      cmocka_unit_test(TestSweepsSpace),
    cmocka_unit_test(TestGoesRound),   cmocka_unit_test(TestCuts),
    cmocka_unit_test(TestOneRankKnows)};
MAIN(tests)
