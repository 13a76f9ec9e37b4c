/* The model of space: Jacobians by rate for every law, its elimination against a matrix, mirrors,
   and a bend whose exact answer is known.
   test: the Jacobian in space is that of its differences and mirrors hold | ranks 1 2 3 */
#include "base/chain.h"
#include "base/hermite.h"
#include "base/vectors.h"
#include "rod/by_rate.h"
#include "rod/space_cells.h"
#include "rod/spin_rest.h"

static const char *const laws[] = {"-growth_type uniform", "-growth_type gaussian",
                                   "-growth_type feed", "-growth_type apical -growth_zone 0.6"};
enum { LAWS = 4 };

static const char *const worlds[] = {
    "",
    "-rod_order 2",
    "-friction_across 3 -friction_layers 0:1,0.5:2 -friction_layer_width 0.8",
    "-friction_radius 0.4 -clamp_spin 0.3",
    "-friction_radius 0.4 -friction_across 3 -friction_layers 0:1,0.5:2 -friction_layer_width 0.8",
    "-rod_weight 0.3,-0.2,0.5 -rod_bend_ratio 1.7 -rod_torsion 0.6",
    "-tip_force 0.7 -tip_law follower -tip_torque 0.8 -tip_force_vector 0.1,0.2,0.3",
    "-tip_force 0.7 -tip_law resistance",
    "-tip_type clamped",
    "-tip_type pinned -tip_torque 0.3",
    "-tip_type slides -tip_force 0.3 -tip_force_vector 0.1,0.2,0.3"};
enum { WORLDS = sizeof(worlds) / sizeof(worlds[0]) };

static void Create(const char *law, const char *world, PetscInt cells, Scene *scene, Rod *rod) {
  const PetscBool yields = (PetscBool)(strstr(world, "-growth_yield") != NULL);
  SetOptions("%s -rod_cells %d -ts_max_time 2 -shape_amplitude 1 -shape_turn 0.7 -rod_curvature "
             "0.7 -rod_curvature_2 0.5 -rod_twist 0.9%s -friction_mu 0.7 -friction_beta 0.1 "
             "-friction_newton primal %s",
             law, (int)cells,
             yields ? "" /* (by which what is given at a label would change) */
                    : " -rod_curvature_random 0.5 -rod_curvature_random_2 0.4 "
                      "-rod_curvature_length 0.3",
             world);
  CHECK(SceneCreate(scene));
  (*scene)->space.rod = PETSC_TRUE;
  CHECK(RodCreate(*scene, &rod_space, rod));
  CHECK(RodHoldTip(*rod));
}

static void Destroy(Scene *scene, Rod *rod) {
  CHECK(RodDestroy(rod));
  CHECK(SceneDestroy(scene));
}

static void JacobianByRate(const char *law, const char *world) {
  const PetscReal shift = 1.7, factor_rate[MIRRORS] = {-0.7 * shift, 0.4 * shift};
  char title[256];
  RodState at;
  Scene scene;
  Rod rod;
  Vec U, U_t, w;
  Mat J;
  Create(law, world, 12, &scene, &rod);
  ShakenState(rod, 0.7, 0.2, &U, &U_t);
  at = StateOf(0.7, U, U_t, shift);
  AddFactorRates(rod, factor_rate, &at);
  w = RandomVector(rod, 3, 1);
  CHECK(RodCreateMatrix(rod, &J));
  CHECK(rod->model->jacobian(rod, &at, J));
  (void)snprintf(title, sizeof(title), "%s %s", law, world);
  ExpectRate(rod, &at, J, w, 2e-4, 0.1, title);
  CHECK(MatDestroy(&J));
  CHECK(VecDestroy(&U));
  CHECK(VecDestroy(&U_t));
  CHECK(VecDestroy(&w));
  Destroy(&scene, &rod);
}

/* ... whose material learns its natural curvature, also where friction feels the spin. */
static void TestLearnedJacobians(void **state) {
  static const char *const more[] = {
      "-tropism_memory 0.4", "-tropism_sensed tip -friction_radius 0.4",
      "-tropism_sensed tip -tropism_memory 0.4 -rod_order 2", "-friction_radius 0.4"};
  char world[512];

  for (int law = 0; law < LAWS; law++) {
    (void)snprintf(world, sizeof(world),
                   "-tropism_gravity 2 -tropism_direction 0.3,-1,0.4 -tropism_light 1 "
                   "-tropism_source 4,5,2 -tropism_proprioception 1.5 -growth_ironing 3 "
                   "-tropism_nutation 1 -tropism_nutation_2 2 -tropism_nutation_rate 3 "
                   "-tropism_rate 0.7 %s",
                   more[law % 4]);
    JacobianByRate(laws[law], world);
  }
}

/* ... whose growth feels force, and that may learn. */
static void TestYieldingJacobians(void **state) {
  static const char
      *const grows[] = {"-growth_type uniform", "-growth_type feed",
                        "-growth_type apical -growth_zone 0.6"},
             *const learns = "-tropism_gravity 2 -tropism_direction 0.3,-1,0.4 -tropism_light 1 "
                             "-tropism_source 4,5,2 -tropism_proprioception 1.5 -growth_ironing 3 "
                             "-tropism_nutation 1 -tropism_nutation_2 2 -tropism_nutation_rate 3",
             *const more[] = {"", "-tropism_memory 0.4 -friction_radius 0.4",
                              "-tropism_sensed tip -tropism_memory 0.4",
                              "-friction_radius 0.4 -friction_across 3 -friction_layers 0:1,0.5:2 "
                              "-friction_layer_width 0.8"};
  char world[640];

  for (int law = 0; law < 3; law++)
    for (int k = 0; k < 4; k++) {
      (void)snprintf(world, sizeof(world),
                     "-growth_yield 30 -tip_force 0.4 -tip_law resistance %s %s%s",
                     k == 1 || k == 2 ? learns : "", more[k],
                     (k == 1 || k == 2) && law == 1 ? " -tropism_rate 0.7" : "");
      JacobianByRate(grows[law], world);
    }
}

/* Jacobians, of each law and each world; in a hinge, of those laws that one may have. */
static void TestJacobians(void **state) {
  for (int law = 0; law < LAWS; law++)
    for (int world = 0; world < WORLDS; world++) JacobianByRate(laws[law], worlds[world]);
  for (int law = 0; law < 2; law++) {
    JacobianByRate(laws[law], "-clamp_type hinged -clamp_spin 0.8");
    JacobianByRate(laws[law], "-clamp_type hinged -rod_order 2 -friction_radius 0.4 -friction_mu 0 "
                              "-tip_type pinned -tip_torque 0.3");
  }
}

/* The largest pressure of walls on a node. */
static PetscReal Pressed(Rod rod, Vec U) {
  const Contact *contact = &rod->scene->contact;
  const PetscScalar *u;
  PetscReal most = 0, slope;
  CHECK(VecGetArrayRead(U, &u));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    const PetscReal gap = ContactGap(3, contact, u + FIELDS * (i - rod->first), 9);
    most = PetscMax(most, ContactPressure(contact, gap, &slope));
  }
  CHECK(VecRestoreArrayRead(U, &u));
  return AllMax(most);
}

/* Walls that press, with friction that feels the spin and turns about curved surfaces; walls of the
   plane stand upright. */
static const char *const walls[] = {
    "plane 0 0.1 -0.15 0.1 0.2 1 friction 0.5\nsphere 0.6 0.6 0.4 0.35 outside friction 0.4\n",
    "cylinder 0 0 0 1 0.3 0.1 0.25 inside friction 0.7\ncone 0.3 0 -0.5 0 0 1 0.2 0.3 1 outside\n",
    "torus 0 0.6 0 0 0 1 0.7 0.2 inside friction 0.6\ncylinder 0.4 0 0 0 0 1 0.2 outside 3\n",
    "cylinder 0 0 0 1 0.3 0.1 0.25 inside turns 0.6 0 0 0 1 0.3 0.1 friction 0.7\n"
    "plane 0 0.1 -0.2 0.1 0.2 1 moves 0.4 0.3 0.05 friction 0.5\n",
    "circle 0.5 0.6 0.5 outside friction 1\nplane 0 -0.2 0.2 1 friction 0.5\n"};
enum { WALLS = sizeof(walls) / sizeof(walls[0]) };

static void TestWallJacobians(void **state) {
  static const char *const spun[] = {
      "", "-friction_radius 0.4 -friction_across 2", "-rod_order 2 -tip_torque 0.2",
      "-friction_across 3 -friction_layers 0:1,0.5:2", "-tip_force 0.7 -tip_law follower"};
  for (int law = 0; law < LAWS; law++)
    for (int k = 0; k < WALLS; k++) {
      char file[64], options[400];
      const int how = (law + k) % 5;
      const PetscReal shift = k % 2 ? 0 : 3;
      PetscReal pressed;
      RodState at;
      Scene scene;
      Rod rod;
      Vec U, U_t, w;
      Mat J;
      WriteWalls(file, walls[k]);
      (void)snprintf(options, sizeof(options),
                     "-wall_file %s -contact_diameter 0.2 -contact_stiffness 40 -clamp_direction "
                     "1,0.3,0.2 %s",
                     file, spun[how]);
      Create(laws[law], options, 12, &scene, &rod);
      ShakenState(rod, 0.7, 1e-2, &U, &U_t);
      w = RandomVector(rod, 3, 1);
      CHECK(RodCreateMatrix(rod, &J));
      at = StateOf(0.7, U, U_t, shift);
      at.fresh = PETSC_TRUE;
      CHECK(rod->model->jacobian(rod, &at, J));
      ExpectRate(rod, &at, J, w, 1e-5, 0.2, options);
      pressed = Pressed(rod, U);
      EXPECT(pressed > 0.1, "%s presses with %g", walls[k], pressed);
      CHECK(MatDestroy(&J));
      CHECK(VecDestroy(&U));
      CHECK(VecDestroy(&U_t));
      CHECK(VecDestroy(&w));
      Destroy(&scene, &rod);
      RemoveFile(file);
    }
}

/* The place z of a cell of the initial shape, and the tangent there, in the laboratory. */
static void PlaceOf(Rod rod, PetscReal t, PetscInt cell, PetscReal z, PetscReal x[3],
                    PetscReal q[3]) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscReal at[9] = {0}, g[2];
  Node *nodes;
  CHECK(PetscMalloc1(rod->end - rod->first, &nodes));
  CHECK(RodInitialNodes(rod, t, nodes));
  CHECK(GrowthStretch(rod->scene->growth, 2, s + cell, t, g, NULL, NULL));
  for (int e = 0; e < 2; e++) {
    PetscReal value[4], slope[4], bend[4], d[3][3], h = s[cell + 1] - s[cell];
    const Node *node = nodes + cell + e - rod->first;
    if (cell + e < rod->first || cell + e >= rod->end) continue;
    Hermite(z, value, slope, bend);
    Directors(node->p, QuaternionSize(node->p), d);
    for (int k = 0; k < 3; k++) {
      at[k] += value[2 * e] * node->x[k] + value[2 * e + 1] * h * g[e] * d[0][k];
      at[3 + k] += slope[2 * e] * node->x[k] + slope[2 * e + 1] * h * g[e] * d[0][k];
    }
  }
  CHECK(PetscFree(nodes));
  MPI_Allreduce(MPI_IN_PLACE, at, 9, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD);
  SpaceToLab(&rod->scene->space, at, x);
  SpaceToLab(&rod->scene->space, at + 3, q);
  for (int k = 0; k < 3; k++) at[k] = q[k];
  for (int k = 0; k < 3; k++) q[k] = at[k] / PetscSqrtReal(Dot3(at, at));
}

/* The sum of normal forces of feet in a state, and how many there are on all ranks. */
static PetscReal OnFeet(Rod rod, const RodState *at, int *feet) {
  PetscReal sum = 0;
  Cell cell;
  *feet = 0;
  CHECK(SpaceCellsOpen(rod, at, &cell));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (i < rod->first) continue; /* the rank before has it */
    for (PetscInt k = 0; k < cell.feet.n; k++) sum += cell.feet.foot[k].normal;
    *feet += cell.feet.n;
  }
  CHECK(SpaceCellsClose(&cell));
  MPI_Allreduce(MPI_IN_PLACE, feet, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD);
  return sum;
}

/* What stands out and is thinner than a cell, of radius r, so deep in the rod at the place z of a
   cell that its axis, if it has one, is `slant` off across the rod: a line of a wall file. %axis
   is where its axis goes through beside the rod, %at a place behind there, along %a. */
typedef struct {
  const char *line;
  PetscReal r, behind, slant;
  PetscReal velocity[3];
  int feet;
} Thin;

static const Thin thin[] = {
    {"cylinder %s %s 0.01 outside friction 0.5\n", 0.01, 0, 0.3, {0}, 1},
    {"cylinder %s %s 0.11 outside friction 0.5\n", 0.11, 0, 0.2, {0}, 1}, /* met in part */
    {"sphere %s 0.02 outside moves 0.4 0.3 0.05 friction 0.7\n", 0.02, 0, 0, {0.4, 0.3, 0.05}, 1},
    {"sphere %s 0.12 outside friction 0.7\n", 0.12, 0, 0, {0}, 1},
    {"cylinder %s %s 0.01 outside 0.3 friction 0.4\n", 0.01, 0.1, 0.7, {0}, 1},
    {"cylinder %s %s 0.9 outside 0.3 friction 0.4\n", 0.9, 0, 1.1, {0}, 1}, /* an edge */
    {"cone %s %s 0.02 0.01 0.4 outside friction 0.5\n", 0.015, 0.2, 0.2, {0}, 1},
    {"torus %s %s 0.4 0.02 outside friction 0.5\n", 0.42, 0, 0.4, {0}, 1}};
enum { THINS = sizeof(thin) / sizeof(thin[0]) };

/* The line that puts one there, by an axis a across the rod but for the slant, and a way e from the
   rod to it that is across both. */
static void WriteThin(const Thin *of, Rod rod, PetscInt cell, PetscReal z, char line[], size_t n) {
  const PetscReal t = 0.7, D = 0.05, deep = 0.004, other[3] = {0.2, -0.3, 1};
  PetscReal x[3], q[3], a[3], e[3], at[3], size;
  char place[80], axis[80];
  PlaceOf(rod, t, cell, z, x, q);
  Cross3(q, other, e);
  size = PetscSqrtReal(Dot3(e, e));
  for (int d = 0; d < 3; d++) e[d] /= size;
  Cross3(e, q, a);
  for (int d = 0; d < 3; d++) {
    a[d] = PetscCosReal(of->slant) * a[d] + PetscSinReal(of->slant) * q[d];
    at[d] = x[d] + (of->r + D / 2 - deep) * e[d] - of->behind * a[d] - t * of->velocity[d];
  }
  (void)snprintf(place, sizeof(place), "%.17g %.17g %.17g", at[0], at[1], at[2]);
  (void)snprintf(axis, sizeof(axis), "%.17g %.17g %.17g", a[0], a[1], a[2]);
  (void)snprintf(line, n, of->line, place, axis);
}

/* Feet on what is thinner than a cell: there is one, and its derivatives are exact. */
static void TestFootJacobians(void **state) {
  static const char *const spun[] = {
      "-clamp_direction 1,0.3,0.2",
      "-clamp_direction 1,0.3,0.2 -friction_radius 0.4 -clamp_spin 0.5", "-rod_order 2"};
  for (int law = 0; law < 3; law += 2)
    for (int k = 0; k < THINS; k++) {
      const int how = (law + k) % 3;
      char file[64], options[400], line[400];
      RodState at;
      Scene scene;
      Rod rod;
      Vec U, U_t, w;
      Mat J;
      PetscReal sum;
      int feet;
      Create(laws[law], spun[how], 12, &scene, &rod);
      WriteThin(&thin[k], rod, 7, 0.37, line, sizeof(line));
      Destroy(&scene, &rod);
      WriteWalls(file, line);
      (void)snprintf(options, sizeof(options),
                     "-wall_file %s -contact_diameter 0.05 -contact_stiffness 4e3 %s", file,
                     spun[how]);
      Create(laws[law], options, 12, &scene, &rod);
      ShakenState(rod, 0.7, 1e-4, &U, &U_t);
      w = RandomVector(rod, 3, 1);
      CHECK(RodCreateMatrix(rod, &J));
      at = StateOf(0.7, U, U_t, k % 2 ? 0 : 3);
      at.fresh = PETSC_TRUE;
      sum = OnFeet(rod, &at, &feet);
      EXPECT(feet == thin[k].feet && sum > 0.01, "%s: %d feet press with %g", line, feet, sum);
      CHECK(rod->model->jacobian(rod, &at, J));
      ExpectRate(rod, &at, J, w, 1e-5, 0.2, line);
      CHECK(MatDestroy(&J));
      CHECK(VecDestroy(&U));
      CHECK(VecDestroy(&U_t));
      CHECK(VecDestroy(&w));
      Destroy(&scene, &rod);
      RemoveFile(file);
    }
}

/* A straight cell that is fed and spins over a post at a slant: where its foot is, and what it
   does. With phi the angle between both: rho = (r + D/2 + gap)/sin^2 phi - gap. */
static void TestFoot(void **state) {
  const PetscReal phi = 0.5, r = 0.001, half = 0.01, mu = 0.4, deep = 2e-5, at = 0.043, h = 0.1,
                  spin = 60, weight[] = {1. / 6, 4. / 6, 1. / 6};
  const FeetHeld none = NULL;
  const FootCell cell = {
      .dims = 3,
      .curve = {.h = h, .g = {1, 1}, .x = {{0}, {h}}, .q = {{1}, {1}}, .c = {1, 1, 1}},
      .spin = {spin, spin},
      .weight = {weight[0], weight[1], weight[2]},
      .moves = PETSC_TRUE};
  FootLoad load = {{0}};
  PetscReal slope, p, u[2], size, f[3], couple, sum[6] = {0}, lever[3] = {0};
  char file[64], line[200];
  const Contact *contact;
  Feet feet;
  Scene scene;
  Rod rod;
  (void)snprintf(line, sizeof(line), "cylinder %g 0 %.17g %.17g %.17g 0 %g outside friction %g\n",
                 at, -r - half + deep, cos(phi), sin(phi), r, mu);
  WriteWalls(file, line);
  SetOptions("-wall_file %s -contact_diameter %g -rod_cells 10 -friction_beta 1e-30 -growth_type "
             "feed -growth_initial_length 1",
             file, 2 * half);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, &rod_space, &rod));
  CHECK(SceneContactAt(scene, 0));
  contact = &scene->contact;
  FeetFind(contact, &cell, contact->smooth, &feet);
  EXPECT(feet.n == 1, "%d feet", (int)feet.n);
  EXPECT(PetscAbsReal(feet.foot[0].on.z - at / h) < 1e-13, "at %g", feet.foot[0].on.z);
  EXPECT(PetscAbsReal(feet.touch[0].gap + deep) < 1e-15, "gap %g", feet.touch[0].gap);
  size = (r + half - deep) / PetscSqr(sin(phi)) + deep;
  EXPECT(PetscAbsReal(feet.foot[0].rho / size - 1) < 1e-12, "rho %g for %g", feet.foot[0].rho,
         size);
  EXPECT(feet.foot[0].strength == contact->tip, "strength %g", feet.foot[0].strength);
  FeetPush(contact, &cell, none, &feet);
  /* what touches is below the axis, r = -D/2 e3: it goes at (1, D/2 spin) */
  p = contact->tip * ContactPressure(contact, -deep, &slope);
  u[0] = 1;
  u[1] = half * spin;
  size = hypot(u[0], u[1]);
  f[0] = -mu * p * u[0] / size;
  f[1] = -mu * p * u[1] / size;
  f[2] = p;
  couple = half * f[1];
  FeetHandOut(&cell, &feet, load);
  for (int k = 0; k < 3; k++)
    for (int d = 0; d < 6; d++) sum[d] -= h * weight[k] * load[k][d];
  for (int k = 0; k < 3; k++)
    for (int d = 0; d < 3; d++) lever[d] -= h * weight[k] * load[k][d] * k / 2;
  for (int d = 0; d < 3; d++) {
    EXPECT(PetscAbsReal(feet.foot[0].force[d] - f[d]) < 1e-9 * p, "force %d: %g for %g", d,
           feet.foot[0].force[d], f[d]);
    EXPECT(PetscAbsReal(sum[d] - f[d]) < 1e-9 * p, "handed out %d: %g for %g", d, sum[d], f[d]);
    EXPECT(PetscAbsReal(lever[d] - f[d] * at / h) < 1e-9 * p, "moment of %d: %g", d, lever[d]);
  }
  EXPECT(PetscAbsReal(sum[3] - couple) < 1e-9 * half * p && sum[4] == 0, "couple %g for %g", sum[3],
         couple);
  CHECK(RodDestroy(&rod));
  CHECK(SceneDestroy(&scene));
  RemoveFile(file);
}

/* On one rank: what is eliminated solves the equations of the matrix. */
static void TestElimination(void **state) {
  PetscMPIInt ranks;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  for (int world = 0; world < WORLDS && ranks == 1; world++) {
    PetscReal b_size, error;
    RodState at;
    Elimination elimination;
    Scene scene;
    Rod rod;
    Vec U, U_t, x, y, b;
    Mat J;
    PC pc;
    Create(laws[2], worlds[world], 30, &scene, &rod);
    ShakenState(rod, 0.7, 1e-3, &U, &U_t);
    x = RandomVector(rod, 4, 1);
    CHECK(VecDuplicate(x, &y));
    CHECK(VecDuplicate(x, &b));
    CHECK(RodCreateMatrix(rod, &J));
    at = StateOf(0.7, U, U_t, 50);
    CHECK(rod->model->jacobian(rod, &at, J));
    CHECK(EliminationCreate(PETSC_COMM_WORLD, 31, rod_space.halves, &elimination));
    CHECK(rod->model->eliminate(rod, &at, elimination));
    CHECK(PCCreate(PETSC_COMM_WORLD, &pc));
    CHECK(EliminationSetType(pc, elimination));
    CHECK(PCSetOperators(pc, J, J));
    CHECK(MatMult(J, x, b));
    CHECK(PCApply(pc, b, y));
    CHECK(MatMult(J, y, U)); /* (its residual: the matrix may be ill-conditioned) */
    CHECK(VecAXPY(U, -1, b));
    CHECK(VecNorm(U, NORM_INFINITY, &error));
    CHECK(VecNorm(b, NORM_INFINITY, &b_size));
    EXPECT(error < 1e-11 * b_size, "%s: residual %g of %g", worlds[world], error, b_size);
    CHECK(PCDestroy(&pc));
    CHECK(EliminationDestroy(&elimination));
    CHECK(MatDestroy(&J));
    CHECK(VecDestroy(&U));
    CHECK(VecDestroy(&U_t));
    CHECK(VecDestroy(&x));
    CHECK(VecDestroy(&y));
    CHECK(VecDestroy(&b));
    Destroy(&scene, &rod);
  }
}

static void Mirror(Vec v, int mirror) {
  PetscScalar *a;
  PetscInt n;
  CHECK(VecGetLocalSize(v, &n));
  CHECK(VecGetArray(v, &a));
  for (PetscInt i = 0; i < n; i++)
    if (rod_space.group[i % FIELDS] & 1 << mirror) a[i] = -a[i];
  CHECK(VecRestoreArray(v, &a));
}

/* F of the mirrored state is the mirrored F, to the last bit, in both mirrors: of a rod that is
   straight by nature. */
static void TestMirrors(void **state) {
  for (int law = 0; law < LAWS; law++)
    for (int mirror = 0; mirror < MIRRORS; mirror++) {
      Scene scene;
      Rod rod;
      Vec U, U_t, F, G;
      PetscReal error;
      RodState at;
      SetOptions("%s -rod_cells 12 -ts_max_time 2 -rod_model space -friction_across 2 "
                 "-friction_radius 0.3 -rod_bend_ratio 1.4 -tip_force 0.2 -tip_law follower %s",
                 laws[law], law < 2 ? "-clamp_type hinged -friction_mu 0" : "");
      CHECK(SceneCreate(&scene));
      CHECK(RodCreate(scene, &rod_space, &rod));
      ShakenState(rod, 0.7, 0.3, &U, &U_t);
      at = StateOf(0.7, U, U_t, 0);
      CHECK(VecDuplicate(U, &F));
      CHECK(VecDuplicate(U, &G));
      CHECK(rod->model->residual(rod, &at, F));
      Mirror(U, mirror);
      Mirror(U_t, mirror);
      CHECK(rod->model->residual(rod, &at, G));
      Mirror(G, mirror);
      CHECK(VecAXPY(G, -1, F));
      CHECK(VecNorm(G, NORM_INFINITY, &error));
      EXPECT(error == 0, "%s, mirror %d: %g", laws[law], mirror, error);
      CHECK(VecDestroy(&U));
      CHECK(VecDestroy(&U_t));
      CHECK(VecDestroy(&F));
      CHECK(VecDestroy(&G));
      Destroy(&scene, &rod);
    }
}

/* The rod at rest under what pushes its tip, from the arc in one load step; returns iterations. */
static PetscInt Statics(Rod rod, PetscReal tip[3]) {
  PetscReal update = 1;
  RodState at;
  PetscInt iterations = 0, n = rod->end - rod->first;
  Elimination elimination;
  Node *nodes;
  Vec U, U_t, F, x;
  Mat none; /* what a PC asks for */
  PC pc;
  CHECK(PetscMalloc1(n, &nodes));
  CHECK(RodInitialNodes(rod, 0, nodes));
  CHECK(DMCreateGlobalVector(rod->da, &U));
  CHECK(VecDuplicate(U, &U_t));
  CHECK(VecDuplicate(U, &F));
  CHECK(VecDuplicate(U, &x));
  CHECK(rod->model->set(rod, 0, nodes, U));
  at = StateOf(0, U, U_t, 0);
  CHECK(EliminationCreate(PETSC_COMM_WORLD, n, rod_space.halves, &elimination));
  CHECK(PCCreate(PETSC_COMM_WORLD, &pc));
  CHECK(EliminationSetType(pc, elimination));
  CHECK(RodCreateMatrix(rod, &none));
  CHECK(PCSetOperators(pc, none, none));
  for (; update > 1e-12 && iterations < 20; iterations++) {
    CHECK(rod->model->residual(rod, &at, F));
    CHECK(rod->model->eliminate(rod, &at, elimination));
    CHECK(PCApply(pc, F, x));
    CHECK(VecAXPY(U, -1, x));
    CHECK(VecNorm(x, NORM_INFINITY, &update));
  }
  CHECK(rod->model->get(rod, 0, U, NULL, nodes));
  for (int d = 0; d < 3; d++) tip[d] = nodes[n - 1].x[d];
  CHECK(PetscFree(nodes));
  CHECK(MatDestroy(&none));
  CHECK(PCDestroy(&pc));
  CHECK(EliminationDestroy(&elimination));
  CHECK(VecDestroy(&U));
  CHECK(VecDestroy(&U_t));
  CHECK(VecDestroy(&F));
  CHECK(VecDestroy(&x));
  return iterations;
}

/* The bend of 45 degrees (Bathe and Bolourchi, 1979), radius 1, of a rod that does not stretch or
   shear: its tip by shooting. Order 4, and few iterations. */
static void TestBend(void **state) {
  const PetscReal exact[3] = {0.46893035, 0.15558199, 0.53600977};
  PetscReal error[3] = {0};
  PetscMPIInt ranks;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  for (int k = 0; k < 3 && ranks == 1; k++) {
    PetscReal tip[3];
    PetscInt iterations;
    Scene scene;
    Rod rod;
    SetOptions("-rod_cells %d -growth_initial_length %.17g -shape_type straight -rod_curvature 1 "
               "-growth_type none -rod_torsion 0.8436 -tip_force_vector 0,0,7.2",
               4 << k, PETSC_PI / 4);
    CHECK(SceneCreate(&scene));
    CHECK(RodCreate(scene, &rod_space, &rod));
    iterations = Statics(rod, tip);
    for (int d = 0; d < 3; d++) error[k] = PetscMax(error[k], PetscAbsReal(tip[d] - exact[d]));
    print_message("%d cells: off by %.2e, %d iterations\n", 4 << k, error[k], (int)iterations);
    EXPECT(iterations <= 9, "%d iterations", (int)iterations);
    Destroy(&scene, &rod);
  }
  if (ranks > 1) return;
  EXPECT(error[2] < 1e-6, "16 cells: off by %g", error[2]);
  EXPECT(PetscLog2Real(error[1] / error[2]) > 3.7, "order %g", PetscLog2Real(error[1] / error[2]));
}

/* The index of an almost straight viscous rod of length 1 under this force along it and this
   twisting moment, at this shift. */
static PetscInt Index(const char *options, PetscReal force, PetscReal moment, PetscReal shift) {
  enum { P0 = 3, P1, P2, P3, M1, N1 = 10 };
  const PetscReal torsion = 0.75;
  Elimination elimination;
  PetscInt index, n;
  RodState at;
  PetscScalar *u;
  Node *nodes;
  Scene scene;
  Rod rod;
  Vec U, U_t;
  SetOptions("-growth_type none -growth_initial_length 1 -friction_mu 0 -rod_cells 150 "
             "-shape_amplitude %s %s %s",
             strstr(options, "clamped") || strstr(options, "pinned") ? "0.01" : "1e-4",
             strstr(options, "-shape_turn") ? "" : "-shape_turn 0.3", options);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, &rod_space, &rod));
  CHECK(RodHoldTip(rod));
  n = rod->end - rod->first;
  CHECK(PetscMalloc1(n, &nodes));
  CHECK(RodInitialNodes(rod, 0, nodes));
  CHECK(DMCreateGlobalVector(rod->da, &U));
  CHECK(VecDuplicate(U, &U_t));
  CHECK(rod_space.set(rod, 0, nodes, U));
  CHECK(VecGetArray(U, &u));
  for (PetscInt i = 0; i < n; i++, u += FIELDS) {
    PetscReal turn = moment / torsion * (PetscReal)(rod->first + i) / (PetscReal)rod->last;
    if (moment != 0) { /* straight, and turned along itself */
      u[P0] = PetscCosReal(turn / 2);
      u[P1] = PetscSinReal(turn / 2);
      u[P2] = u[P3] = 0;
    }
    u[M1] = moment;
    u[N1] = -force;
  }
  u -= n * FIELDS;
  CHECK(VecRestoreArray(U, &u));
  at = StateOf(0, U, U_t, shift);
  at.counts = PETSC_TRUE;
  CHECK(EliminationCreate(PETSC_COMM_WORLD, n, rod_space.halves, &elimination));
  CHECK(rod_space.eliminate(rod, &at, elimination));
  EliminationPlane(elimination, (PetscBool)(strstr(options, "-shape_turn 0") != NULL));
  CHECK(EliminationIndex(elimination, &index));
  CHECK(EliminationDestroy(&elimination));
  CHECK(PetscFree(nodes));
  CHECK(VecDestroy(&U));
  CHECK(VecDestroy(&U_t));
  Destroy(&scene, &rod);
  return index;
}

/* Modes that grow are counted: of a round rod both directions of each, those of a free rod at P =
   ((k - 1/2) pi)^2, of one clamped at both ends at 4 pi^2 and 80.76, pinned at one at 20.19; with
   two stiffnesses each direction by itself; a twisted one that is clamped gives way at M
   = 8.98681892, in both. */
static void TestIndex(void **state) {
  const PetscReal forces[] = {-5, 1, 2, 3, 15, 30, 100, 400, 1000};
  static const struct {
    const char *options;
    PetscReal force, moment, shift;
    PetscInt index;
  } cases[] = {{"", 30, 0, 200, 2}, /* four grow, two of them faster than 200 */
               {"-tip_type slides", 39, 0, 1e-3, 0},
               {"-tip_type slides", 40, 0, 1e-3, 2},
               {"-tip_type slides", 85, 0, 1e-3, 4},
               /* one that cannot slide is bent a little, and cannot bend on in that plane */
               {"-tip_type clamped", 39, 0, 1e-3, 0},
               {"-tip_type clamped", 40, 0, 1e-3, 1},
               {"-tip_type pinned", 20, 0, 1e-3, 0},
               {"-tip_type pinned", 21, 0, 1e-3, 1},
               {"-tip_type slides", 0, 8.95, 1e-3, 0},
               {"-tip_type slides", 0, 9.05, 1e-3, 2},
               /* in a hinge, from 20.19 and 59.68 on */
               {"-tip_type slides -clamp_type hinged", 19.5, 0, 1, 0},
               {"-tip_type slides -clamp_type hinged", 21, 0, 1, 2},
               {"-tip_type slides -clamp_type hinged", 61, 0, 1, 4},
               /* within the plane alone */
               {"-shape_turn 0", 30, 0, 1e-3, 2},
               {"-tip_type slides -shape_turn 0", 40, 0, 1e-3, 1},
               {"-tip_type clamped -shape_turn 0", 40, 0, 1e-3, 0}};
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(forces); k++) {
    PetscReal P = forces[k];
    PetscInt modes = P > 0 ? (PetscInt)(PetscSqrtReal(P) / PETSC_PI + 0.5) : 0,
             weak = P > 0 ? (PetscInt)(PetscSqrtReal(P / 0.6) / PETSC_PI + 0.5) : 0,
             index = Index("", P, 0, 1e-3), two = Index("-rod_bend_ratio 0.6", P, 0, 1e-3);
    EXPECT(index == 2 * modes, "P = %g: %d modes, not %d", P, (int)index, 2 * (int)modes);
    EXPECT(two == modes + weak, "P = %g, two stiffnesses: %d modes, not %d", P, (int)two,
           (int)(modes + weak));
    EXPECT(Index("", P, 0, 1.5 * P * P + 10) == 0, "P = %g: modes above its largest rate", P);
  }
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(cases); k++) {
    PetscInt index = Index(cases[k].options, cases[k].force, cases[k].moment, cases[k].shift);
    EXPECT(index == cases[k].index, "%s, force %g, moment %g: %d modes, not %d", cases[k].options,
           cases[k].force, cases[k].moment, (int)index, (int)cases[k].index);
  }
}

/* A rod begins in line with its own mesh: places are what its cells make of angles and moments,
   also of few. In the plane, too. */
static void TestBegins(void **state) {
  const RodModel *const models[] = {&rod_space, &rod_frame};
  for (int k = 0; k < 2; k++) {
    const RodModel *model = models[k];
    PetscReal most = 0, off[MAX_FIELDS];
    Scene scene;
    RodState at = {0};
    Vec F;
    Rod rod;
    SetOptions("-rod_cells 24 -ts_max_time 2 -growth_initial_length 2 -shape_amplitude 3.1 %s",
               k ? "" : "-shape_turn 1 -rod_curvature_2 0.3 -rod_bend_ratio 2");
    CHECK(SceneCreate(&scene));
    scene->space.rod = model->space;
    CHECK(RodCreate(scene, model, &rod));
    CHECK(DMCreateGlobalVector(rod->da, &at.U));
    CHECK(VecDuplicate(at.U, &at.U_t));
    CHECK(VecDuplicate(at.U, &F));
    CHECK(VecZeroEntries(at.U_t));
    CHECK(RodBegin(rod, at.U));
    CHECK(model->residual(rod, &at, F));
    CHECK(RodFieldSizes(rod, F, off));
    for (PetscInt f = 0; f < (model->space ? 3 : 2); f++) most = PetscMax(most, off[f]);
    EXPECT(most < 1e-13, "%s: places are off by %g", model->name, (double)most);
    CHECK(VecDestroy(&at.U));
    CHECK(VecDestroy(&at.U_t));
    CHECK(VecDestroy(&F));
    Destroy(&scene, &rod);
  }
}

/* The spin of a bent rod at rest is a pendulum's: with natural bend a about d2 and bends (p, q),
     E = C phi'^2 / 2 - B a (p cos phi + q sin phi) + what does not change, per length,
   so that C phi'^2 / 2 + B a (p cos phi + q sin phi) is the same all along; and a rod that is where
   it would be does not turn. */
static void TestSpinRest(void **state) {
  enum { PLACES = 2001 };
  const PetscReal C = 0.6, B = 1, a = 0.8, p = -0.5, q = 1.3, h = 2. / (PLACES - 1);
  SpinPlace place[PLACES];
  PetscReal turn[PLACES], least = PETSC_MAX_REAL, most = PETSC_MIN_REAL, speed;
  for (PetscInt i = 0; i < PLACES; i++)
    place[i] = (SpinPlace){.s = i * h, .g = 1, .S = {C, B, B}, .u0 = {0, a, 0}, .u = {0, p, q}};
  CHECK(SpinRest(PLACES, place, 0, PETSC_FALSE, turn));
  for (PetscInt i = 1; i + 1 < PLACES; i++) {
    const PetscReal slope = (turn[i + 1] - turn[i - 1]) / (2 * h),
                    sum = C * slope * slope / 2 +
                          B * a * (p * PetscCosReal(turn[i]) + q * PetscSinReal(turn[i]));
    least = PetscMin(least, sum);
    most = PetscMax(most, sum);
  }
  speed = (turn[PLACES - 1] - turn[PLACES - 2]) / h;
  EXPECT(most - least < 1e-6, "between %g and %g", (double)least, (double)most);
  EXPECT(PetscAbsReal(speed) < 2e-3, "the end twists by %g", (double)speed);
  EXPECT(turn[PLACES - 1] > 0.5 && turn[PLACES - 1] < 2, "turns by %g", (double)turn[PLACES - 1]);
  for (PetscInt i = 0; i < PLACES; i++) place[i].u[1] = 1.1, place[i].u[2] = 0;
  CHECK(SpinRest(PLACES, place, 0, PETSC_FALSE, turn));
  EXPECT(turn[PLACES - 1] == 0, "turns by %g at rest", (double)turn[PLACES - 1]);
  CHECK(SpinRest(PLACES, place, 0.05, PETSC_FALSE, turn));
  EXPECT(turn[PLACES - 1] > 0.01, "a torque turns it by %g", (double)turn[PLACES - 1]);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestJacobians),
                                          cmocka_unit_test(TestLearnedJacobians),
                                          cmocka_unit_test(TestWallJacobians),
                                          cmocka_unit_test(TestFootJacobians),
                                          cmocka_unit_test(TestYieldingJacobians),
                                          cmocka_unit_test(TestFoot),
                                          cmocka_unit_test(TestElimination),
                                          cmocka_unit_test(TestMirrors),
                                          cmocka_unit_test(TestBend),
                                          cmocka_unit_test(TestIndex),
                                          cmocka_unit_test(TestBegins),
                                          cmocka_unit_test(TestSpinRest)};
MAIN(tests)
