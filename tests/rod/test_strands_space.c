/* Strands of a rod in space that press on each other: Jacobians by rate, forces and moments that
   cancel, and their work, which is that of the energy; and friction of strands that spin.
   test: strands in space press with the differences of their energy | ranks 1 2 3 */
#include "rod/by_rate.h"
#include "rod/coupled.h"
#include "rod/directors.h"
#include "curve/spread.h"
#include "rod/strands.h"

/* A helix whose coils lie on each other; and one that is wide, bent back so that a strand crosses
   others. */
static const char *const coils =
    "-growth_type feed -growth_initial_length 1.9 -ts_max_time 2 "
    "-rod_curvature 8 -rod_twist 0.9 -contact_self "
    "-contact_diameter 0.09 -contact_stiffness 300 -shape_type straight";

static void Create(const char *more, PetscInt cells, Scene *scene, Rod *rod) {
  SetOptions("%s %s -rod_cells %d -friction_mu 0.7 -friction_beta 0.1 -friction_newton primal",
             coils, more, (int)cells);
  CHECK(SceneCreate(scene));
  (*scene)->space.rod = PETSC_TRUE;
  CHECK(RodCreate(*scene, &rod_space, rod));
}

static void Destroy(Scene *scene, Rod *rod) {
  CHECK(RodDestroy(rod));
  CHECK(SceneDestroy(scene));
}

/* What the material learns follows the moments that friction between strands makes, too. */
#define LEARNS                                                                                     \
  "-contact_friction 0.6 -tropism_gravity 2 -tropism_direction 0.3,-1,0.4 -growth_ironing 4 "      \
  "-tropism_proprioception 1.5 -tropism_rate 0.7 "

static void TestJacobians(void **state) {
  static const char *const mores[] = {
      "",
      "-contact_friction 0.6",
      "-rod_order 2",
      "-contact_friction 0.6 -growth_type uniform",
      "-rod_curvature 3.354 -rod_twist 0.1 -growth_initial_length 1.8 -contact_friction 0.6",
      LEARNS,
      LEARNS "-tropism_sensed tip -tropism_memory 0.4"};
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(mores); k++) { /* (one's tip meets its clamp) */
    const PetscReal shift = 1.7;
    Scene scene;
    RodState at;
    Rod rod;
    Vec U, U_t, w;
    Mat J;
    Create(mores[k], 40, &scene, &rod);
    ShakenState(rod, 0, 3e-3, &U, &U_t);
    w = RandomVector(rod, 3, 1);
    CHECK(RodCreateMatrix(rod, &J));
    at = StateOf(0, U, U_t, shift);
    CHECK(rod->model->residual(rod, &at, w));
    CHECK(VecDestroy(&w));
    w = RandomVector(rod, 3, 1);
    CHECK(rod->model->jacobian(rod, &at, J));
    ExpectRate(rod, &at, J, w, 1e-6, 0.2, mores[k]);
    CHECK(MatDestroy(&J));
    CHECK(VecDestroy(&U));
    CHECK(VecDestroy(&U_t));
    CHECK(VecDestroy(&w));
    Destroy(&scene, &rod);
  }
}

/* The nodes of the coils, drawn out by e along x1 and moved with e across, on every rank. */
static void Coils(Rod rod, PetscReal t, PetscReal e, Node *nodes) {
  CHECK(RodInitialNodes(rod, t, nodes));
  for (PetscInt i = 0; i <= rod->last; i++) {
    const PetscReal s = rod->scene->mesh.s[i];
    nodes[i].x[0] += e * s * s;
    nodes[i].x[1] += e * sin(3 * s);
  }
}

/* Where a point of the rod is: a node, or the middle behind it, as the collocation has it. */
static PetscReal PointAt(Rod rod, const Node *nodes, const PetscReal *g, PetscInt k, int d) {
  const PetscReal *s = rod->scene->mesh.s;
  const Node *a = nodes + k / 2, *b = a + 1;
  PetscReal da[3][3], db[3][3];

  if (k % 2 == 0) return a->x[d];
  Directors(a->p, QuaternionSize(a->p), da);
  Directors(b->p, QuaternionSize(b->p), db);
  return (a->x[d] + b->x[d]) / 2 +
         (s[k / 2 + 1] - s[k / 2]) / 8 * (g[k / 2] * da[0][d] - g[k / 2 + 1] * db[0][d]);
}

/* Zeros into the rows that what presses on a cell reaches, by the nodes of two cells: its force is
   taken by points as far as the middles of the next cells, and a couple turns the end of the cell
   behind a point, too. */
static void FillRows(Rod rod, PetscInt pressed, const PetscInt cell[2], Mat J) {
  const PetscInt column[4] = {cell[0], cell[0] + 1, cell[1], cell[1] + 1};
  const PetscScalar zero[4 * MAX_FIELDS * MAX_FIELDS] = {0};

  for (PetscInt row = pressed - 1; row <= pressed + 2; row++)
    if (row >= rod->first && row < rod->end)
      CHECK(MatSetValuesBlocked(J, 1, &row, 4, column, zero, ADD_VALUES));
}

/* A matrix that has room for the pairs with which a Newton solve begins has it for those of later
   iterates, too, whose feet have wandered by a cell. */
static void TestFeetWander(void **state) {
  Coupled coupled;
  Scene scene;
  Rod rod;
  Mat J;

  Create("-contact_friction 0.6", 60, &scene, &rod);
  CHECK(CoupledCreate(rod, &coupled));
  CHECK(RodCreateMatrix(rod, &J));
  for (PetscInt foot = 39; foot <= 41; foot++) {
    const PetscInt pair[2][2] = {{10, 40}, {10, foot}};
    for (int k = 0; k < 2; k++) {
      CellPair *near;
      CHECK(PetscMalloc1(1, &near));
      *near = (CellPair){pair[k][0], pair[k][1]};
      CHECK(CoupledPattern(rod, coupled, (PetscBool)!k, 1, near, J));
      FillRows(rod, pair[k][0], pair[k], J);
      FillRows(rod, pair[k][1], pair[k], J);
      CHECK(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
      CHECK(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
    }
  }
  CHECK(MatDestroy(&J));
  CHECK(CoupledDestroy(&coupled));
  Destroy(&scene, &rod);
}

/* The relative error of the work of the forces when the coils move, against the energy; forces and
   moments cancel. */
static PetscReal WorkError(PetscInt cells) {
  const PetscReal t = 0, e = 1e-6;
  PetscReal energy[3], work = 0, moment[3] = {0}, lever = 0, *g, *g_t;
  const PetscReal(*force)[3] = NULL;
  Node *nodes[3];
  Strands strands;
  StrandSum sum;
  Scene scene;
  Rod rod;

  Create("-contact_friction 0", cells, &scene, &rod);
  CHECK(StrandsCreate(scene, &strands));
  CHECK(PetscMalloc2(cells + 1, &g, cells + 1, &g_t));
  CHECK(GrowthStretch(scene->growth, cells + 1, scene->mesh.s, t, g, g_t, NULL));
  for (int k = 0; k < 3; k++) {
    int which = k == 2 ? 1 : 2 * k; /* the forces of the one between are seen last */
    StrandState state = {.t = t, .stride = NODE_VALUES};
    CHECK(PetscCalloc1(cells + 1, &nodes[which]));
    Coils(rod, t, (which - 1) * e, nodes[which]);
    state.u = nodes[which][0].x;
    CHECK(StrandsSearch(strands, &state));
    CHECK(StrandsLoad(strands, &state));
    StrandsSum(strands, 0, &sum);
    energy[which] = sum.energy;
  }
  force = StrandsForces(strands);
  EXPECT(sum.normal > 0.01, "nothing touches: %g", sum.normal);
  for (PetscInt k = 0; k <= 2 * cells + 1; k++) {
    const PetscReal *s = scene->mesh.s;
    PetscInt at = PetscMin(k, 2 * cells), i = at / 2;
    PetscReal x[3],
        weight = k > 2 * cells ? -1
                 : at % 2      ? 4 * (s[i + 1] - s[i]) / 6
                          : ((i ? s[i] - s[i - 1] : 0) + (i < cells ? s[i + 1] - s[i] : 0)) / 6;
    for (int d = 0; d < 3; d++) {
      x[d] = PointAt(rod, nodes[1], g, at, d);
      work -= weight * force[k][d] *
              (PointAt(rod, nodes[2], g, at, d) - PointAt(rod, nodes[0], g, at, d));
    }
    for (int d = 0; d < 3; d++) {
      int b = (d + 1) % 3, c = (d + 2) % 3;
      moment[d] += weight * (x[b] * force[k][c] - x[c] * force[k][b]);
      lever += PetscAbsReal(weight * x[b] * force[k][c]);
    }
  }
  for (int d = 0; d < 3; d++) {
    EXPECT(PetscAbsReal(sum.sum[d]) < 1e-12 * sum.normal, "sum %g of %g", sum.sum[d], sum.normal);
    EXPECT(PetscAbsReal(moment[d]) < 3e-3 * lever, "moment %g of %g", moment[d], lever);
  }
  for (int k = 0; k < 3; k++) CHECK(PetscFree(nodes[k]));
  CHECK(PetscFree2(g, g_t));
  CHECK(StrandsDestroy(&strands));
  Destroy(&scene, &rod);
  return PetscAbsReal(work / (energy[0] - energy[2]) - 1);
}

/* An even load, from many places all along the rod, comes out even: by Simpson's weights a third of
   half a cell at nodes, two thirds at middles; each place keeps its force and two moments. */
static void TestSpread(void **state) {
  enum { CELLS = 8, POINTS = 2 * CELLS + 1, EACH = 16 };
  PetscReal load[POINTS] = {0};

  for (PetscInt k = 0; k < CELLS * EACH; k++) {
    const PetscReal place = (k % EACH + 0.5) / EACH, at = 2 * (k / EACH + place), e = 1e-6;
    PetscReal moment[3] = {0};
    Spread spread, beside;
    SpreadEvenly(POINTS, k / EACH, place, &spread);
    SpreadEvenly(POINTS, k / EACH, place + e, &beside);
    for (int j = 0; j < 4; j++) {
      const PetscReal o = spread.point[j] - at, share = spread.share[j];
      load[spread.point[j]] += 2. / EACH * share;
      moment[0] += share;
      moment[1] += share * o;
      moment[2] += share * o * o;
      EXPECT(PetscAbsReal((beside.share[j] - share) / e - spread.share_z[j]) < 1e-4, "slope %g",
             spread.share_z[j]);
    }
    EXPECT(PetscAbsReal(moment[0] - 1) < 1e-14 && PetscAbsReal(moment[1]) < 1e-13 &&
               PetscAbsReal(moment[2]) < 1e-13,
           "moments %g, %g, %g at %g", moment[0], moment[1], moment[2], at);
  }
  for (PetscInt k = 4; k < POINTS - 4; k++)
    EXPECT(PetscAbsReal(load[k] - (k % 2 ? 4. : 2.) / 3) < 2e-3, "load %g of point %g", load[k],
           (double)k);
}

static void TestConservative(void **state) {
  PetscMPIInt ranks;
  PetscReal coarse, fine;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1) return;
  coarse = WorkError(50);
  fine = WorkError(100);
  print_message("work of strands off by %g, %g\n", (double)coarse, (double)fine);
  EXPECT(fine < 1e-3 && fine < coarse / 4, "off by %g, %g", coarse, fine);
}

/* A rod that spins about itself and rests else: coils that lie on each other rub by what both of
   their surfaces move, D omega. The couples brake it with the power that friction takes, and the
   forces of friction cancel. */
static void TestSpins(void **state) {
  const PetscReal omega = 0.8, speed = 0.09 * omega, rubbed = speed / hypot(speed, sqrt(0.1));
  const PetscReal(*couple)[3];
  PetscReal power = 0;
  Strands strands;
  StrandSum sum;
  PetscMPIInt ranks;
  Node *nodes;
  Scene scene;
  Rod rod;

  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1) return;
  Create("-contact_friction 0.6 -growth_type none", 100, &scene, &rod);
  CHECK(StrandsCreate(scene, &strands));
  CHECK(PetscCalloc1(rod->last + 1, &nodes));
  CHECK(RodInitialNodes(rod, 0, nodes));
  for (PetscInt i = 0; i <= rod->last; i++) {
    const PetscReal about[3] = {omega / 2, 0, 0};
    QuaternionTurn(nodes[i].p, about, nodes[i].p_t);
    for (int d = 0; d < 3; d++) nodes[i].x_t[d] = 0;
  }
  StrandState at = {.t = 0, .stride = NODE_VALUES, .u = nodes[0].x, .u_t = nodes[0].x_t};
  CHECK(StrandsSearch(strands, &at));
  CHECK(StrandsLoad(strands, &at));
  StrandsSum(strands, 0, &sum);
  couple = StrandsCouples(strands);
  for (PetscInt k = 0; k < 2 * rod->last + 1; k++) {
    const PetscReal *s = scene->mesh.s;
    const PetscInt i = k / 2;
    PetscReal a[3][3], b[3][3],
        weight = k % 2 ? 4 * (s[i + 1] - s[i]) / 6
                       : ((i ? s[i] - s[i - 1] : 0) + (i < rod->last ? s[i + 1] - s[i] : 0)) / 6;
    Directors(nodes[i].p, QuaternionSize(nodes[i].p), a);
    Directors(nodes[i + k % 2].p, QuaternionSize(nodes[i + k % 2].p), b);
    for (int d = 0; d < 3; d++) power -= weight * couple[k][d] * (a[0][d] + b[0][d]) / 2 * omega;
  }
  { /* and the tip's own */
    PetscReal tip[3][3];
    Directors(nodes[rod->last].p, QuaternionSize(nodes[rod->last].p), tip);
    for (int d = 0; d < 3; d++) power += couple[2 * rod->last + 1][d] * tip[0][d] * omega;
  }
  print_message("friction takes %g, couples do %g\n", (double)sum.loss, (double)power);
  EXPECT(sum.normal > 0.01, "nothing touches: %g", sum.normal);
  EXPECT(PetscAbsReal(power / sum.loss + 1) < 1e-2, "%g of %g", power, sum.loss);
  EXPECT(PetscAbsReal(sum.loss / (0.6 * sum.normal * speed * rubbed) - 1) < 5e-2, "%g of %g",
         sum.loss, 0.6 * sum.normal * speed * rubbed);
  for (int d = 0; d < 3; d++)
    EXPECT(PetscAbsReal(sum.sum[d]) < 1e-12 * sum.normal, "sum %g of %g", sum.sum[d], sum.normal);
  CHECK(PetscFree(nodes));
  CHECK(StrandsDestroy(&strands));
  Destroy(&scene, &rod);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestJacobians), cmocka_unit_test(TestFeetWander), cmocka_unit_test(TestSpread),
    cmocka_unit_test(TestConservative), cmocka_unit_test(TestSpins)};
MAIN(tests)
