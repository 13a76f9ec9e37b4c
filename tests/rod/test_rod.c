/* Models of the rod: Jacobians by rate for every law, mirror symmetry, set and get.
   test: the Jacobian of each law is that of its differences | ranks 1 2 3 */
#include "rod/by_rate.h"

typedef struct {
  const char *name;
  const RodModel *model;
  const char *options;
} Model;
static const Model models[] = {{"frame, order 4", &rod_frame, "-rod_order 4"},
                               {"frame, order 2", &rod_frame, "-rod_order 2"},
                               {"mixed", &rod_mixed, ""},
                               {"linear", &rod_linear, ""}};
enum { MODELS = sizeof(models) / sizeof(models[0]), FRAME = 0, MIXED = 2, LINEAR = 3 };

static PetscReal Tabulated(PetscReal s, PetscReal t) {
  return 1 + t * (1 + 0.5 * PetscSinReal(3 * s + t)) + 0.3 * PetscCosReal(2 * s - t);
}

static const char *const laws[] = {"-growth_type uniform", "-growth_type gaussian",
                                   "-growth_type feed", "-growth_type apical -growth_zone 0.6",
                                   "-growth_type table -growth_table "};
enum { LAWS = 5, UNIFORM = 0, FEED = 2, APICAL = 3, TABLE = 4 };

/* A natural curvature of both kinds; the linear model has none, and the mirror must turn it. */
static const char *const curved = " -rod_curvature 0.7 -rod_curvature_random 0.9 "
                                  "-rod_curvature_length 0.3";

static void Create(const Model *model, int law, PetscInt cells, const char *more, Scene *scene,
                   Rod *rod) {
  char path[64] = "";
  if (law == TABLE) WriteTable(path, 9, 9, 3, Tabulated);
  SetOptions("%s%s %s -rod_cells %d -ts_max_time 2 %s", laws[law], path, model->options, (int)cells,
             more);
  CHECK(SceneCreate(scene));
  CHECK(RodCreate(*scene, model->model, rod));
  if (law == TABLE) RemoveFile(path);
}

static void Destroy(Scene *scene, Rod *rod) {
  CHECK(RodDestroy(rod));
  CHECK(SceneDestroy(scene));
}

/* The initial shape shaken: far from any symmetry, edges far from 0. */
static void RandomState(Rod rod, PetscReal t, Vec *U, Vec *U_t) {
  ShakenState(rod, t, rod->model == &rod_mixed ? 0.15 / rod->last : 0.3, U, U_t);
}

static void JacobianByRate(const Model *model, int law, PetscReal shift, const char *more) {
  const PetscReal t = 0.7, e = 2e-4, factor_rate[MIRRORS] = {-0.7 * shift, 0.4 * shift};
  RodState at;
  Scene scene;
  Rod rod;
  Vec U, U_t, w;
  Mat J;
  char all[768], title[896];
  snprintf(all, sizeof(all),
           "-shape_amplitude 2 -friction_mu 0.7 -friction_beta 0.1 -friction_newton primal%s",
           more);
  Create(model, law, 12, all, &scene, &rod);
  RandomState(rod, t, &U, &U_t);
  at = StateOf(t, U, U_t, shift);
  AddFactorRates(rod, factor_rate, &at);
  w = RandomVector(rod, 3, model->model == &rod_mixed ? 0.1 : 1);
  CHECK(RodCreateMatrix(rod, &J));
  CHECK(rod->model->jacobian(rod, &at, J));
  snprintf(title, sizeof(title), "%s, %s%s", model->name, laws[law], more);
  ExpectRate(rod, &at, J, w, e, 0.1, title);
  CHECK(MatDestroy(&J));
  CHECK(VecDestroy(&U));
  CHECK(VecDestroy(&U_t));
  CHECK(VecDestroy(&w));
  Destroy(&scene, &rod);
}

/* ... where it is fed by a schedule that turns round, and steered. */
static void TestDrivenJacobians(void **state) {
  static const PetscReal at[] = {0, 0.4, 0.7, 1, 0, 0.5, 1, 1.5}, *t = at + 4;
  const char *const name[] = {"/distance", "/t", "/curvature"};
  const PetscInt four = 4, both[] = {4, 4};
  char path[64], file[64], more[256];
  PetscReal k[16];

  for (int j = 0; j < 4; j++)
    for (int i = 0; i < 4; i++) k[4 * j + i] = PetscCosReal(3 * at[i] - 2 * t[j]);
  OpenScratch(file);
  WriteScratch(file, 3, name, (int[]){1, 1, 2}, (const PetscInt *[]){&four, &four, both},
               (const PetscReal *[]){at, t, k});
  WriteWalls(path, "t,speed\n0,1\n0.5,0\n1,-0.3\n");
  (void)snprintf(more, sizeof(more), " -growth_path %s -rod_curvature_file %s", path, file);
  for (int m = 0; m < LINEAR; m++) JacobianByRate(&models[m], FEED, 3, more);
  RemoveFile(path);
  RemoveFile(file);
}

/* ... whose material learns its natural curvature, by all that it may go by. */
static void TestLearnedJacobians(void **state) {
  static const char *const senses[] = {"", " -tropism_memory 0.4", " -tropism_sensed tip",
                                       " -tropism_sensed tip -tropism_memory 0.4"};
  char more[256];

  for (int m = 0; m < MIXED; m++)
    for (int law = 0; law < LAWS; law++)
      for (size_t k = 0; k < sizeof(senses) / sizeof(senses[0]); k++) {
        (void)snprintf(more, sizeof(more),
                       " -tropism_gravity 2 -tropism_direction 0.3,-1 -tropism_light 1 "
                       "-tropism_source 4,5 -tropism_proprioception 1.5 -growth_ironing 3%s%s",
                       senses[k], law == FEED ? " -tropism_rate 0.7" : "");
        JacobianByRate(&models[m], law, 3, more);
      }
}

/* ... whose growth feels force, in a state that goes no faster backwards than it would forwards. */
static void TestYieldingJacobians(void **state) {
  static const char *const learns[] = {
      "",
      " -tropism_gravity 2 -tropism_direction 0.3,-1 -tropism_proprioception 1.5 "
      "-growth_ironing 3 -tropism_sensed tip -tropism_memory 0.4",
      " -tropism_gravity 2 -tropism_direction 0.3,-1 -tropism_memory 0.4 -tropism_light 1 "
      "-tropism_source 4,5"};
  static const int yielding[] = {UNIFORM, FEED, APICAL};
  char more[320];

  for (int law = 0; law < 3; law++)
    for (size_t k = 0; k < sizeof(learns) / sizeof(learns[0]); k++) {
      (void)snprintf(more, sizeof(more), " -growth_yield 30 -tip_force 0.4 -tip_law resistance%s%s",
                     learns[k], k && yielding[law] == FEED ? " -tropism_rate 0.7" : "");
      JacobianByRate(&models[FRAME], yielding[law], 3, more);
    }
}

static void TestJacobians(void **state) {
  for (int m = 0; m < MODELS; m++)
    for (int law = 0; law < LAWS; law++) {
      JacobianByRate(&models[m], law, 3, "");
      JacobianByRate(&models[m], law, 0, "");
      if (m != LINEAR) JacobianByRate(&models[m], law, 3, curved);
    }
}

/* Friction's factor over place and time, curved in each. */
static PetscReal Factor(PetscReal x1, PetscReal x2, PetscReal t) {
  return 1.5 + 0.4 * PetscSinReal(2 * x1 + t) + 0.5 * PetscCosReal(x2 + 0.5 * x1) +
         0.3 * PetscSinReal(3 * t);
}

static void WriteField(char path[64]) {
  enum { N1 = 9, N2 = 8, NT = 5 };
  PetscInt dims[3] = {NT, N2, N1};
  PetscReal x1[N1], x2[N2], t[NT], factor[NT * N2 * N1];
  OpenScratch(path);
  for (int i = 0; i < N1; i++) x1[i] = -3 + 0.75 * i;
  for (int j = 0; j < N2; j++) x2[j] = -3 + 0.8 * j;
  for (int k = 0; k < NT; k++) t[k] = 0.4 * k;
  for (int k = 0; k < NT; k++)
    for (int j = 0; j < N2; j++)
      for (int i = 0; i < N1; i++) factor[(k * N2 + j) * N1 + i] = Factor(x1[i], x2[j], t[k]);
  WriteScratch(path, 4, (const char *[]){"/t", "/x2", "/x1", "/factor"}, (int[]){1, 1, 1, 3},
               (const PetscInt *[]){dims, dims + 1, dims + 2, dims},
               (const PetscReal *[]){t, x2, x1, factor});
}

static void WriteStiffness(char path[64]) {
  enum { N = 6 };
  PetscInt n = N;
  PetscReal distance[N], factor[N];
  OpenScratch(path);
  for (int i = 0; i < N; i++) {
    distance[i] = 0.3 * i;
    factor[i] = 3 - 2 * PetscExpReal(-distance[i]);
  }
  WriteScratch(path, 2, (const char *[]){"/distance", "/factor"}, (int[]){1, 1},
               (const PetscInt *[]){&n, &n}, (const PetscReal *[]){distance, factor});
}

/* The Jacobians of each law of the world around the rod, and of all together. */
static void TestWorld(void **state) {
  const char *const alone[] = {" -friction_across 2.5",
                               " -friction_layers -1:1,0.3:2.5,0.8:0.4 -friction_layer_width 0.4",
                               " -tip_force 0.8",
                               " -tip_force 0.8 -tip_law follower",
                               " -tip_force 0.8 -tip_law resistance",
                               " -tip_type pinned",
                               " -tip_type clamped"};
  char field[64], stiffness[64], with_field[128], with_tip_field[192], stiff[128], all[512];
  WriteField(field);
  WriteStiffness(stiffness);
  snprintf(with_field, sizeof(with_field), " -friction_field %s", field);
  snprintf(with_tip_field, sizeof(with_tip_field),
           " -tip_force 0.8 -tip_law resistance -tip_field %s", field);
  snprintf(stiff, sizeof(stiff), " -rod_stiffness_file %s", stiffness);
  snprintf(all, sizeof(all), " -friction_across 2.5 -clamp_angle 0.4%s%s%s%s", with_field,
           with_tip_field, stiff, curved);
  for (int m = 0; m < MODELS; m++)
    for (int law = 0; law < LAWS; law++) {
      if (law != UNIFORM && law != FEED && law != APICAL) continue;
      for (size_t k = 0; k < sizeof(alone) / sizeof(alone[0]); k++)
        JacobianByRate(&models[m], law, 3, alone[k]);
      JacobianByRate(&models[m], law, 3, stiff);
      JacobianByRate(&models[m], law, 0, stiff);
      if (law == UNIFORM && m == 0) /* of order 4 alone */
        JacobianByRate(&models[m], law, 3, " -clamp_type hinged -tip_type pinned");
      if (m == LINEAR) continue; /* takes no field that changes across, and no natural curvature */
      JacobianByRate(&models[m], law, 3, with_field);
      JacobianByRate(&models[m], law, 0, with_field);
      JacobianByRate(&models[m], law, 3, with_tip_field);
      JacobianByRate(&models[m], law, 3, all);
      JacobianByRate(&models[m], law, 0, all);
    }
  RemoveFile(field);
  RemoveFile(stiffness);
}

/* Once the duals belong to the state, the primal-dual Jacobian is Newton's own; after a large step
   no more. */
static void TestPrimalDual(void **state) {
  for (int m = 0; m <= MIXED; m++) {
    Scene scene[2];
    Rod rod[2];
    RodState at[2];
    Vec U, U_t, V_t;
    Mat J[2];
    PetscReal norm, difference;
    for (int k = 0; k < 2; k++)
      Create(&models[m], 0, 12,
             k ? "-friction_newton primal_dual -shape_amplitude 2"
               : "-friction_newton primal -shape_amplitude 2",
             &scene[k], &rod[k]);
    RandomState(rod[0], 0.7, &U, &U_t);
    V_t = RandomVector(rod[0], 5, 1);
    for (int k = 0; k < 2; k++) {
      CHECK(RodCreateMatrix(rod[k], &J[k]));
      at[0] = at[1] = StateOf(0.7, U, U_t, 3);
      at[0].fresh = PETSC_TRUE;
      for (int i = 0; i < 2; i++) CHECK(rod[k]->model->jacobian(rod[k], &at[i], J[k]));
    }
    CHECK(MatAXPY(J[1], -1, J[0], SAME_NONZERO_PATTERN));
    CHECK(MatNorm(J[0], NORM_FROBENIUS, &norm));
    CHECK(MatNorm(J[1], NORM_FROBENIUS, &difference));
    EXPECT(difference < 1e-13 * norm, "%s: differs by %g of %g", models[m].name, difference, norm);
    at[1].U_t = V_t;
    for (int k = 0; k < 2; k++) CHECK(rod[k]->model->jacobian(rod[k], &at[1], J[k]));
    CHECK(MatAXPY(J[1], -1, J[0], SAME_NONZERO_PATTERN));
    CHECK(MatNorm(J[1], NORM_FROBENIUS, &difference));
    EXPECT(difference > 1e-6 * norm, "%s: the dual has not been kept", models[m].name);
    for (int k = 0; k < 2; k++) {
      CHECK(MatDestroy(&J[k]));
      Destroy(&scene[k], &rod[k]);
    }
    CHECK(VecDestroy(&U));
    CHECK(VecDestroy(&U_t));
    CHECK(VecDestroy(&V_t));
  }
}

static void Mirror(Rod rod, Vec v) {
  PetscScalar *a;
  PetscInt n, fields = rod->model->fields;
  CHECK(VecGetLocalSize(v, &n));
  CHECK(VecGetArray(v, &a));
  for (PetscInt i = 0; i < n; i++)
    if (rod->model->group[i % fields]) a[i] = -a[i];
  CHECK(VecRestoreArray(v, &a));
}

/* F of the mirrored state is the mirrored F, to the last bit or nearly. */
static void TestMirror(void **state) {
  for (int m = 0; m < MODELS; m++)
    for (int law = 0; law < LAWS; law++) {
      Scene scene;
      Rod rod;
      RodState at;
      Vec U, U_t, F, G;
      PetscReal norm, difference;
      Create(&models[m], law, 12, "-shape_amplitude 2 -clamp_angle 0.3", &scene, &rod);
      RandomState(rod, 0.7, &U, &U_t);
      at = StateOf(0.7, U, U_t, 0);
      CHECK(VecDuplicate(U, &F));
      CHECK(VecDuplicate(U, &G));
      CHECK(rod->model->residual(rod, &at, F));
      Mirror(rod, U);
      Mirror(rod, U_t);
      CHECK(rod->model->residual(rod, &at, G));
      Mirror(rod, G);
      CHECK(VecAXPY(G, -1, F));
      CHECK(VecNorm(F, NORM_INFINITY, &norm));
      CHECK(VecNorm(G, NORM_INFINITY, &difference));
      EXPECT(difference <= 1e-14 * norm, "%s, %s: %g of %g", models[m].name, laws[law], difference,
             norm);
      CHECK(VecDestroy(&U));
      CHECK(VecDestroy(&U_t));
      CHECK(VecDestroy(&F));
      CHECK(VecDestroy(&G));
      Destroy(&scene, &rod);
    }
}

/* Nodes in equilibrium across the rod: n = -P q - m'/g q_perp for the shape sag; with rates. */
static void BalancedNodes(Rod rod, PetscReal t, PetscReal eps, Node *nodes) {
  CHECK(RodInitialNodes(rod, t, nodes));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    Node *node = &nodes[i - rod->first];
    PetscReal s = rod->scene->mesh.s[i], g, g_s, theta_s = 3 * eps * (1 - s) * (1 - s);
    PetscReal q[2] = {PetscCosReal(node->theta), PetscSinReal(node->theta)};
    PetscReal P = -node->force[0], Q;
    CHECK(GrowthStretch(rod->scene->growth, 1, &s, t, &g, NULL, &g_s));
    Q = -(-6 * eps * (1 - s) / g - theta_s * g_s / (g * g)) / g;
    node->force[0] = -P * q[0] - Q * q[1];
    node->force[1] = -P * q[1] + Q * q[0];
  }
}

enum { POSITION, ANGLE, MOMENT, FORCE, KINDS };
static const char *const kinds[KINDS] = {"position", "angle", "moment", "shear force"};

static void SetAndGet(const Model *model, int law, PetscInt cells, PetscReal error[KINDS]) {
  const PetscReal eps = model->model == &rod_linear ? 1e-5 : 1, t = 0.7;
  char more[80];
  Scene scene;
  Rod rod;
  Node *in, *out;
  PetscInt n;
  Vec U;
  snprintf(more, sizeof(more), "-shape_amplitude %g -rod_grading uniform", eps);
  Create(model, law, cells, more, &scene, &rod);
  n = rod->end - rod->first;
  CHECK(PetscMalloc2(n, &in, n, &out));
  BalancedNodes(rod, t, eps, in);
  CHECK(DMCreateGlobalVector(rod->da, &U));
  CHECK(model->model->set(rod, t, in, U));
  CHECK(model->model->get(rod, t, U, NULL, out));
  for (int k = 0; k < KINDS; k++) error[k] = 0;
  for (PetscInt i = 0; i < n; i++) {
    const Node *a = &in[i], *b = &out[i];
    PetscReal force;
    if (model->model == &rod_mixed && (rod->first + i < 2 || rod->first + i == rod->last - 1))
      continue;
    error[POSITION] = PetscMax(error[POSITION], PetscAbsReal(a->x[1] - b->x[1]) / eps);
    if (eps == 1) error[POSITION] = PetscMax(error[POSITION], PetscAbsReal(a->x[0] - b->x[0]));
    error[ANGLE] = PetscMax(error[ANGLE], PetscAbsReal(a->theta - b->theta) / eps);
    error[MOMENT] = PetscMax(error[MOMENT], PetscAbsReal(a->moment - b->moment) / eps);
    force = (b->force[1] - a->force[1]) * PetscCosReal(a->theta) -
            (b->force[0] - a->force[0]) * PetscSinReal(a->theta);
    if (rod->first + i) error[FORCE] = PetscMax(error[FORCE], PetscAbsReal(force) / eps);
  }
  for (int k = 0; k < KINDS; k++) error[k] = AllMax(error[k]);
  CHECK(VecDestroy(&U));
  CHECK(PetscFree2(in, out));
  Destroy(&scene, &rod);
}

/* frame gives all back; mixed and linear the position, the rest with their order. The
   force at the clamp is left out (linear: one-sided difference, first order); for mixed the ends,
   where moment and force are those of the discrete rod's balance, not of the shape. */
static void TestSetAndGet(void **state) {
  for (int law = 0; law < LAWS; law++)
    for (int m = 0; m < MODELS; m++) {
      PetscReal error[2][KINDS];
      for (int k = 0; k < 2; k++) SetAndGet(&models[m], law, 60 << k, error[k]);
      for (int kind = 0; kind < KINDS; kind++) {
        PetscReal order = Order(error[0][kind], error[1][kind]);
        if (m < MIXED || kind == POSITION) {
          EXPECT(error[0][kind] < 1e-13, "%s, %s: %s off by %g", models[m].name, laws[law],
                 kinds[kind], error[0][kind]);
          continue;
        }
        print_message("%s, %s: %s %.1e, order %.2f\n", models[m].name, laws[law], kinds[kind],
                      error[1][kind], order);
        EXPECT(order > 1.8 || error[1][kind] < 1e-6, "%s, %s: %s by %g, order %g", models[m].name,
               laws[law], kinds[kind], error[1][kind], order);
      }
    }
}

/* The rates: those of theta(s) = eps (1-(1-s)^3) with eps = t; x_t is what RodGrowNodes moves. */
static void TestGrowNodes(void **state) {
  for (int law = 0; law < LAWS; law++) {
    const PetscReal t0 = 0.4, t1 = 0.9;
    PetscReal error = 0;
    Scene scene;
    Rod rod;
    Node *now, *then;
    PetscInt n;
    Create(&models[FRAME], law, 200, "-shape_amplitude 1.5", &scene, &rod);
    n = rod->end - rod->first;
    CHECK(PetscMalloc2(n, &now, n, &then));
    CHECK(RodInitialNodes(rod, t0, now));
    CHECK(RodInitialNodes(rod, t1, then)); /* the same angles, grown */
    CHECK(RodGrowNodes(rod, t0, t1, now));
    for (PetscInt i = 0; i < n; i++)
      error = PetscMax(error, hypot(now[i].x[0] - then[i].x[0], now[i].x[1] - then[i].x[1]) +
                                  PetscAbsReal(now[i].moment - then[i].moment) +
                                  PetscAbsReal(now[i].theta - then[i].theta));
    error = AllMax(error);
    EXPECT(error < 2e-5, "%s: off by %g", laws[law], error);
    CHECK(PetscFree2(now, then));
    Destroy(&scene, &rod);
  }
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestJacobians),
                                          cmocka_unit_test(TestLearnedJacobians),
                                          cmocka_unit_test(TestYieldingJacobians),
                                          cmocka_unit_test(TestDrivenJacobians),
                                          cmocka_unit_test(TestWorld),
                                          cmocka_unit_test(TestPrimalDual),
                                          cmocka_unit_test(TestMirror),
                                          cmocka_unit_test(TestSetAndGet),
                                          cmocka_unit_test(TestGrowNodes)};
MAIN(tests)
