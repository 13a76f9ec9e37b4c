/* What is measured: crossings of known curves, integrals of a known rod, the straight rod's forces,
   the turn of the clamp.
   test: what is measured of known curves is right | ranks 1 2 3 */
#include "harness.h"
#include "record/observe.h"
#include "rod/crossing.h"

enum { MOST = 2001 };

/* A curve from its parameter; angles made continuous. */
typedef void (*Curve)(PetscReal u, PetscReal x[2]);

static void Trace(Curve curve, PetscReal from, PetscReal to, PetscInt n, Node *nodes) {
  const PetscReal e = 1e-6;
  for (PetscInt i = 0; i < n; i++) {
    PetscReal u = from + (to - from) * i / (n - 1), a[2], b[2], theta;
    curve(u - e, a);
    curve(u + e, b);
    nodes[i] = (Node){0};
    curve(u, nodes[i].x);
    theta = PetscAtan2Real(b[1] - a[1], b[0] - a[0]);
    if (i) theta += 2 * PETSC_PI * floor((nodes[i - 1].theta - theta) / (2 * PETSC_PI) + 0.5);
    nodes[i].theta = theta;
  }
}

static void EightCurve(PetscReal u, PetscReal x[2]) {
  x[0] = PetscSinReal(u);
  x[1] = PetscSinReal(2 * u);
}

static void Spiral(PetscReal u, PetscReal x[2]) {
  x[0] = u * PetscCosReal(u);
  x[1] = u * PetscSinReal(u);
}

static void Limacon(PetscReal u, PetscReal x[2]) {
  x[0] = (0.5 + PetscCosReal(u)) * PetscCosReal(u);
  x[1] = (0.5 + PetscCosReal(u)) * PetscSinReal(u);
}

static void Trochoid(PetscReal u, PetscReal x[2]) { /* a loop each 2 pi */
  x[0] = u - 2 * PetscSinReal(u);
  x[1] = 1 - 2 * PetscCosReal(u);
}

static void Rose(PetscReal u, PetscReal x[2]) { /* 3/7: every branch crosses others, 14 petals */
  x[0] = (2 + PetscCosReal(7 * u / 3)) * PetscCosReal(u);
  x[1] = (2 + PetscCosReal(7 * u / 3)) * PetscSinReal(u);
}

static void Sine(PetscReal u, PetscReal x[2]) {
  x[0] = u;
  x[1] = 3 * PetscSinReal(5 * u);
}

static void TestCrossings(void **state) {
  static const struct {
    const char *name;
    Curve curve;
    PetscReal from, to;
    PetscInt crossings;
  } curves[] = {{"sine", Sine, 0, 10, 0},
                {"eight", EightCurve, 0.3, 2 * PETSC_PI + 0.2, 1},
                {"half an eight", EightCurve, 0.3, 3, 0},
                {"spiral", Spiral, 1, 30, 0},
                {"limacon", Limacon, 0.1, 2 * PETSC_PI, 1},
                {"trochoid", Trochoid, 1.1, 5 * 2 * PETSC_PI + 1, 4},
                {"rose", Rose, 0.01, 6 * PETSC_PI, 14}};
  Node nodes[MOST];
  for (size_t c = 0; c < PETSC_STATIC_ARRAY_LENGTH(curves); c++)
    for (PetscInt n = 401; n <= MOST; n += 800) {
      PetscInt count;
      Trace(curves[c].curve, curves[c].from, curves[c].to, n, nodes);
      CHECK(RodCrossings(n, nodes, &count));
      EXPECT(count == curves[c].crossings, "%s with %d nodes: %d crossings, not %d", curves[c].name,
             (int)n, (int)count, (int)curves[c].crossings);
    }
}

static PetscBool Cross(const PetscReal *a, const PetscReal *b, const PetscReal *c,
                       const PetscReal *d) {
#define SIDE(p, q, r) ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))
  return (PetscBool)(SIDE(a, b, c) * SIDE(a, b, d) < 0 && SIDE(c, d, a) * SIDE(c, d, b) < 0);
#undef SIDE
}

/* Random curves of smooth angle against the plain count over all pairs. */
static void TestCrossingsAtRandom(void **state) {
  const PetscInt n = 300;
  Node nodes[300];
  PetscInt all = 0;
  for (int k = 0; k < 20; k++) {
    PetscInt count = 0, found;
    nodes[0] = (Node){0};
    for (PetscInt i = 1; i < n; i++) {
      PetscReal s = (PetscReal)i / n, theta = 0;
      for (int m = 1; m <= 6; m++) theta += 6 * Scatter(k, m) * PetscSinReal(m * 2 * s) / m;
      nodes[i] = (Node){.theta = theta};
      nodes[i].x[0] = nodes[i - 1].x[0] + PetscCosReal((theta + nodes[i - 1].theta) / 2);
      nodes[i].x[1] = nodes[i - 1].x[1] + PetscSinReal((theta + nodes[i - 1].theta) / 2);
    }
    for (PetscInt i = 0; i < n - 1; i++)
      for (PetscInt j = i + 2; j < n - 1; j++)
        count += Cross(nodes[i].x, nodes[i + 1].x, nodes[j].x, nodes[j + 1].x);
    CHECK(RodCrossings(n, nodes, &found));
    all += count;
    EXPECT(found == count, "curve %d: %d crossings, not %d", k, (int)found, (int)count);
  }
  EXPECT(all > 20, "only %d crossings in all", (int)all);
}

static void Create(const char *options, PetscInt cells, Scene *scene, Rod *rod,
                   Observer *observer) {
  SetOptions("%s -rod_cells %d -ts_max_time 2", options, (int)cells);
  CHECK(SceneCreate(scene));
  CHECK(RodCreate(*scene, &rod_frame, rod));
  CHECK(ObserverCreate(*scene, observer));
}

static void Destroy(Scene *scene, Rod *rod, Observer *observer) {
  CHECK(ObserverDestroy(observer));
  CHECK(RodDestroy(rod));
  CHECK(SceneDestroy(scene));
}

/* -n1(0) = L (mu (sqrt(1 + beta) - sqrt(beta)) + (1 - mu)/2) of the straight rod; all work of
   growth goes into friction. */
static void TestStraight(void **state) {
  const PetscReal mu[] = {1, 0.3, 0}, beta = 1e-2, t = 1.5, L = 2;
  for (int k = 0; k < 3; k++) {
    char options[120];
    Scene scene;
    Rod rod;
    Observer observer;
    Observation seen;
    PetscReal should =
        L * (mu[k] * (PetscSqrtReal(1 + beta) - PetscSqrtReal(beta)) + (1 - mu[k]) / 2);
    snprintf(options, sizeof(options),
             "-shape_type straight -friction_beta %g -friction_mu %g -clamp_angle 0.3", beta,
             mu[k]);
    Create(options, 100, &scene, &rod, &observer);
    CHECK(ObserverMeasure(observer, rod, t, NULL, NULL, NULL, &seen));
    EXPECT(PetscAbsReal(seen.base_force_1 - should * PetscCosReal(0.3)) < 1e-12 &&
               PetscAbsReal(seen.base_force_2 - should * PetscSinReal(0.3)) < 1e-12,
           "mu %g: base force (%g, %g), size %g", mu[k], seen.base_force_1, seen.base_force_2,
           should);
    EXPECT(PetscAbsReal(seen.length - L) < 1e-14 && PetscAbsReal(seen.end_distance - L) < 1e-13 &&
               PetscAbsReal(seen.mid_distance - L / 2) < 1e-13,
           "length %g, tip at %g, middle at %g", seen.length, seen.end_distance, seen.mid_distance);
    EXPECT(PetscAbsReal(seen.tip_speed - 1) < 1e-13 && PetscAbsReal(seen.mid_speed - 0.5) < 1e-13,
           "speeds %g, %g", seen.tip_speed, seen.mid_speed);
    EXPECT(PetscAbsReal(seen.growth_power / seen.dissipation - 1) < 1e-6, "W %g, dissipation %g",
           seen.growth_power, seen.dissipation);
    EXPECT(seen.energy == 0 && seen.width == 0 && seen.max_angle == 0 && !seen.inflections &&
               !seen.self_crossings,
           "the straight rod is bent");
    Destroy(&scene, &rod, &observer);
  }
}

/* A rod bent like theta = eps (1 - (1-s)^3), in balance across, turning at the rate theta / eps. */
static const PetscReal eps = 0.8, at = 0.9;

static Vec Bent(Rod rod, Vec *U_t) {
  PetscInt n = rod->end - rod->first;
  Node *nodes, *rates;
  Vec U;
  CHECK(DMCreateGlobalVector(rod->da, &U));
  CHECK(VecDuplicate(U, U_t));
  CHECK(PetscMalloc2(n, &nodes, n, &rates));
  CHECK(RodInitialNodes(rod, at, nodes));
  CHECK(PetscArrayzero(rates, n));
  for (PetscInt i = 0; i < n; i++) {
    Node *node = &nodes[i];
    PetscReal s = rod->scene->mesh.s[rod->first + i], g, g_s, P, Q;
    PetscReal q[2] = {PetscCosReal(node->theta), PetscSinReal(node->theta)};
    P = -node->force[0] * q[0] - node->force[1] * q[1];
    CHECK(GrowthStretch(rod->scene->growth, 1, &s, at, &g, NULL, &g_s));
    Q = (6 * eps * (1 - s) / g + 3 * eps * (1 - s) * (1 - s) * g_s / (g * g)) / g;
    node->force[0] = -P * q[0] - Q * q[1];
    node->force[1] = -P * q[1] + Q * q[0];
    for (int d = 0; d < 2; d++) rates[i].x[d] = node->x_t[d]; /* growth alone */
  }
  CHECK(rod->model->set(rod, at, nodes, U));
  CHECK(rod->model->set(rod, at, rates, *U_t));
  CHECK(PetscFree2(nodes, rates));
  return U;
}

/* The same integrals by the midpoint rule on 200 000 points, from the formulas alone. */
static void BentExactly(Growth growth, const Friction *friction, Observation *sum) {
  const PetscInt n = 200000;
  PetscReal x[2] = {0, 0}, v[2] = {0, 0}, *P, *s, beyond = 0;
  *sum = (Observation){0};
  CHECK(PetscMalloc2(n + 1, &P, n + 1, &s));
  for (PetscInt i = 0; i <= n; i++) s[i] = (PetscReal)i / n;
  for (PetscInt i = n - 1; i >= 0; i--) { /* P in the middles of the cells */
    PetscReal z = (s[i] + s[i + 1]) / 2, g, p, v0, f;
    CHECK(GrowthStretch(growth, 1, &z, at, &g, NULL, NULL));
    CHECK(GrowthArc(growth, 1, &z, at, &p, &v0));
    f = g * v0 * FrictionPhi(friction, v0 * v0) / n;
    P[i] = beyond + f / 2;
    beyond += f;
  }
  for (PetscInt i = 0; i < n; i++) {
    PetscReal z = (s[i] + s[i + 1]) / 2, g, g_t, theta = eps * (1 - pow(1 - z, 3)), m, v2;
    PetscReal q[2] = {PetscCosReal(theta), PetscSinReal(theta)};
    CHECK(GrowthStretch(growth, 1, &z, at, &g, &g_t, NULL));
    m = 3 * eps * (1 - z) * (1 - z) / g;
    for (int d = 0; d < 2; d++) x[d] += g * q[d] / (2 * n), v[d] += g_t * q[d] / (2 * n);
    v2 = v[0] * v[0] + v[1] * v[1];
    sum->norm_x2 += x[1] * x[1] / n;
    sum->norm_x2_length += x[1] * x[1] * g / n;
    sum->energy += m * m * g / (2 * n);
    sum->dissipation += g * FrictionPhi(friction, v2) * v2 / n;
    sum->growth_power -= g_t * (-P[i] + m * m / 2) / n; /* n.q = -P */
    for (int d = 0; d < 2; d++) x[d] += g * q[d] / (2 * n), v[d] += g_t * q[d] / (2 * n);
  }
  sum->norm_x2 = PetscSqrtReal(sum->norm_x2);
  sum->norm_x2_length = PetscSqrtReal(sum->norm_x2_length);
  sum->tip_x1 = x[0];
  sum->tip_x2 = x[1];
  sum->tip_speed = hypot(v[0], v[1]);
  CHECK(PetscFree2(P, s));
}

static void TestIntegrals(void **state) {
  const char *const laws[] = {"-growth_type uniform -friction_mu 0.6 -friction_beta 0.1",
                              "-growth_type gaussian -friction_mu 0.6 -friction_beta 0.1"};
  for (int l = 0; l < 2; l++) {
    Observation exact, seen;
    Scene scene;
    Rod rod;
    Observer observer;
    Vec U, U_t;
    char options[160];
    snprintf(options, sizeof(options), "%s -shape_amplitude %g", laws[l], eps);
    Create(options, 240, &scene, &rod, &observer);
    BentExactly(scene->growth, &scene->load.friction, &exact);
    U = Bent(rod, &U_t);
    CHECK(ObserverMeasure(observer, rod, at, U, U_t, NULL, &seen));
#define SAME(name, part)                                                                           \
  EXPECT(PetscAbsReal(seen.name / exact.name - 1) < part, "%s: " #name " is %.10g, not %.10g",     \
         laws[l], seen.name, exact.name)
    SAME(norm_x2, 2e-7);
    SAME(norm_x2_length, 2e-7);
    SAME(energy, 2e-7);
    SAME(dissipation, 2e-7);
    SAME(growth_power, 1e-4); /* the force is in balance across only, hence second order */
    SAME(tip_x1, 2e-7);
    SAME(tip_x2, 2e-7);
    SAME(tip_speed, 2e-7);
#undef SAME
    EXPECT(PetscAbsReal(seen.max_angle - eps) < 1e-14, "largest angle %g", seen.max_angle);
    EXPECT(seen.inflections == 0, "%g inflections", seen.inflections);
    EXPECT(PetscAbsReal(seen.width - seen.tip_x2) < 1e-13, "width %g", seen.width);
    CHECK(VecDestroy(&U));
    CHECK(VecDestroy(&U_t));
    Destroy(&scene, &rod, &observer);
  }
}

/* A turned clamp turns what has a direction and nothing else. */
static void TestTurnedClamp(void **state) {
  const PetscReal a = 0.7;
  Observation seen[2];
  for (int k = 0; k < 2; k++) {
    Scene scene;
    Rod rod;
    Observer observer;
    Vec U, U_t;
    Create(k ? "-shape_amplitude 0.8 -clamp_angle 0.7" : "-shape_amplitude 0.8", 60, &scene, &rod,
           &observer);
    U = Bent(rod, &U_t);
    CHECK(ObserverMeasure(observer, rod, at, U, U_t, NULL, &seen[k]));
    CHECK(VecDestroy(&U));
    CHECK(VecDestroy(&U_t));
    Destroy(&scene, &rod, &observer);
  }
#define TURNED(f)                                                                                  \
  EXPECT(PetscAbsReal(seen[1].f##1 - PetscCosReal(a) * seen[0].f##1 +                              \
                      PetscSinReal(a) * seen[0].f##2) < 1e-14 &&                                   \
             PetscAbsReal(seen[1].f##2 - PetscSinReal(a) * seen[0].f##1 -                          \
                          PetscCosReal(a) * seen[0].f##2) < 1e-14,                                 \
         #f " (%g, %g)", seen[1].f##1, seen[1].f##2)
  TURNED(tip_x);
  TURNED(base_force_);
#undef TURNED
  EXPECT(seen[1].energy == seen[0].energy && seen[1].dissipation == seen[0].dissipation &&
             seen[1].width == seen[0].width && seen[1].end_distance == seen[0].end_distance,
         "a number without direction has changed");
  EXPECT(seen[1].norm_x2 > 1.1 * seen[0].norm_x2, "|x2| is measured in the laboratory");
}

/* A step over which the balance is taken for closed adds nothing to what it was off by before, nor
   takes that off. */
static void TestClosed(void **state) {
  Observation seen = {0};
  PetscReal defect[4];
  Scene scene;
  Rod rod;
  Observer observer;
  Vec U, U_t;

  Create("-growth_type uniform -shape_amplitude 0.8", 60, &scene, &rod, &observer);
  U = Bent(rod, &U_t);
  for (int k = 0; k < 4; k++) { /* it grows, and moves, but stays as it is */
    if (k == 2) ObserverClose(observer, &seen, PETSC_TRUE);
    CHECK(ObserverMeasure(observer, rod, at + 0.1 * k, U, U_t, NULL, &seen));
    defect[k] = seen.energy_defect;
  }
  EXPECT(defect[1] > 0.01 && defect[2] > 0.8 * defect[1] && defect[2] < 1.01 * defect[1],
         "off by %g before, by %g behind a closed step", defect[1], defect[2]);
  EXPECT(defect[3] > 1.2 * defect[2], "then by %g", defect[3]);
  CHECK(VecDestroy(&U));
  CHECK(VecDestroy(&U_t));
  Destroy(&scene, &rod, &observer);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestCrossings),   cmocka_unit_test(TestCrossingsAtRandom),
    cmocka_unit_test(TestStraight),    cmocka_unit_test(TestIntegrals),
    cmocka_unit_test(TestTurnedClamp), cmocka_unit_test(TestClosed)};
MAIN(tests)
