/* Norms and eigenvalues of the straight rod against theorems, and the propagator.
   test: the stability of the straight rod is that of theorems | ranks 1 2 3 | apart */
#include "harness.h"
#include "tasks/critical.h"
#include "straight/norm.h"
#include "tasks/stability.h"
#include "straight/transient.h"

static void Setup(Scene *scene, const char *law, PetscReal mu, int cells) {
  SetOptions("%s -friction_mu %g -rod_cells %d -shape_amplitude 0.02", law, mu, cells);
  CHECK(SceneCreate(scene));
}

static void EvenMesh(Scene scene, PetscInt cells, Mesh *mesh) {
  CHECK(MeshCreate(cells, PETSC_FALSE, scene->growth, scene->end_time, mesh));
}

static PetscReal Rate(Scene scene, SpectrumRate rate, PetscReal t, PetscInt cells) {
  Spectrum spectrum;
  Eigenvalue value;
  Pencil pencil;
  Mesh mesh;

  EvenMesh(scene, cells, &mesh);
  CHECK(PencilCreate(PETSC_COMM_WORLD, scene, &mesh, map_follows, WAY_X2, &pencil));
  CHECK(SpectrumCreate(pencil, PETSC_TRUE, &spectrum));
  CHECK(SpectrumLargest(&spectrum, rate, t, &value, NULL, NULL));
  CHECK(SpectrumDestroy(&spectrum));
  CHECK(PencilDestroy(&pencil));
  CHECK(MeshDestroy(&mesh));
  return value.value;
}

/* Uniform growth: A is self-adjoint in the friction norm, so its largest eigenvalue is the rate. */
static void TestTheorem(void **state) {
  const PetscReal mu[] = {0, 0.5, 1}, t[] = {0, 0.7, 1.4, 3};
  Scene scene;

  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 4; i++) {
      PetscReal a, f;
      Setup(&scene, "-growth_type uniform", mu[k], 10);
      a = Rate(scene, RATE_A, t[i], 200);
      f = Rate(scene, RATE_FRICTION, t[i], 200);
      EXPECT(PetscAbsReal(a - f) < 1e-10 * PetscMax(1, PetscAbsReal(a)), "mu %g, t %g: %.14g %.14g",
             (double)mu[k], (double)t[i], (double)a, (double)f);
      CHECK(SceneDestroy(&scene));
    }
  Setup(&scene, "-growth_type feed", 0, 10);
  EXPECT(Rate(scene, RATE_FRICTION, 2, 200) - Rate(scene, RATE_A, 2, 200) > 0.1,
         "feed: rate and eigenvalue agree");
  CHECK(SceneDestroy(&scene));
}

/* Feed: the friction norm can grow from L^3 = 7.83735 on, long before flutter. */
static void TestFeedNorm(void **state) {
  const PetscReal t = 1.98635270743047 - 0.5;
  Scene scene;

  Setup(&scene, "-growth_type feed", 0, 10);
  EXPECT(Rate(scene, RATE_FRICTION, t - 1e-7, 200) < 0, "grows too early");
  EXPECT(Rate(scene, RATE_FRICTION, t + 1e-7, 200) > 0, "grows too late");
  EXPECT(Rate(scene, RATE_A, t + 1e-7, 200) < -0.5, "feed should not buckle");
  CHECK(SceneDestroy(&scene));
}

/* Nothing of the spectrum lies above the bound that the shift relies on; on a mesh of 20000 cells
   the eigenvalue is still that of 500. */
static void TestBound(void **state) {
  Scene scene;
  PetscReal coarse, fine;

  for (int k = 0; k < 12; k++) {
    Pencil pencil;
    Eigenvalue value;
    PetscReal bound;
    Mesh mesh;
    Setup(&scene, k % 2 ? "-growth_type gaussian -growth_width 0.3" : "-growth_type uniform",
          (k % 3) / 2., 40);
    EvenMesh(scene, 40, &mesh);
    CHECK(PencilCreate(PETSC_COMM_SELF, scene, &mesh, map_follows, WAY_X2, &pencil));
    CHECK(SpectrumRightmost(pencil, 0.8 * k, &value));
    CHECK(PencilBound(pencil, &bound));
    EXPECT(value.value < bound, "t %g: %g above %g", 0.8 * k, (double)value.value, (double)bound);
    EXPECT(value.frequency < 1e-6, "t %g: complex", 0.8 * k);
    EXPECT(PetscAbsReal(value.value - Rate(scene, RATE_A, 0.8 * k, 40)) <
               1e-6 * PetscMax(1, PetscAbsReal(value.value)),
           "t %g: not the largest", 0.8 * k);
    CHECK(PencilDestroy(&pencil));
    CHECK(MeshDestroy(&mesh));
    CHECK(SceneDestroy(&scene));
  }
  Setup(&scene, "-growth_type uniform", 1, 10);
  coarse = Rate(scene, RATE_A, 1, 500);
  fine = Rate(scene, RATE_A, 1, 20000);
  EXPECT(PetscAbsReal(fine - coarse) < 2e-8, "%.12g on 500, %.12g on 20000", (double)coarse,
         (double)fine);
  CHECK(SceneDestroy(&scene));
}

/* lambda_max(C) < 0 before t_cr and 0 at it, in both scalings; in plain L2 it is another matter. */
static void TestLeftNorm(void **state) {
  const PetscReal t_cr[] = {1.48713372450, 1.67177006749};
  enum { CELLS = 150 };
  PetscReal *W;

  CHECK(PetscMalloc1((CELLS + 1) * (CELLS + 1), &W));
  for (int k = 0; k < 4; k++) {
    PetscReal at = t_cr[k / 2];
    Eigenvalue before, here, after, flat;
    Pencil pencil, own;
    Norm left, l2;
    Scene scene;
    Mesh mesh;
    Setup(&scene, "-growth_type uniform", k < 2, 10);
    EvenMesh(scene, CELLS, &mesh);
    CHECK(PencilCreate(PETSC_COMM_WORLD, scene, &mesh, at, WAY_X2, &pencil));
    CHECK(PencilCreate(PETSC_COMM_SELF, scene, &mesh, at, WAY_X2, &own));
    CHECK(SpectrumLeftVectors(own, at, (PetscBool)(k % 2), W));
    CHECK(NormCreate(pencil, W, at, &left));
    for (int i = 0; i < 10; i++) {
      CHECK(NormGrowth(&left, at * i / 10, FRAME_LABEL, &before));
      EXPECT(before.value < -0.1, "case %d: %g at t = %g", k, (double)before.value,
             (double)(at * i / 10));
    }
    CHECK(NormGrowth(&left, at - 1e-6, FRAME_LABEL, &before));
    CHECK(NormGrowth(&left, at, FRAME_LABEL, &here));
    CHECK(NormGrowth(&left, at + 1e-6, FRAME_LABEL, &after));
    EXPECT(before.value < 0 && after.value > 0, "case %d: %g and %g around t_cr", k,
           (double)before.value, (double)after.value);
    EXPECT(PetscAbsReal(here.value) < 1e-8, "case %d: %g at t_cr", k, (double)here.value);
    CHECK(NormDestroy(&left));
    CHECK(NormCreate(pencil, NULL, at, &l2));
    CHECK(NormGrowth(&l2, at, FRAME_LABEL, &flat));
    if (k < 2)
      EXPECT(flat.value > 0.5, "dry: plain L2 at t_cr %g", (double)flat.value);
    else
      EXPECT(PetscAbsReal(flat.value) < 1e-7, "viscous: L2 is the friction norm, %g",
             (double)flat.value);
    CHECK(NormDestroy(&l2));
    CHECK(PencilDestroy(&own));
    CHECK(PencilDestroy(&pencil));
    CHECK(MeshDestroy(&mesh));
    CHECK(SceneDestroy(&scene));
  }
  CHECK(PetscFree(W));
}

/* Feed, whose left eigenvectors are complex: with W from the onset of flutter C stays negative up
   to it, long after other norms can grow. */
static void TestLeftNormOfFeed(void **state) {
  const PetscReal at = 3.73771992106;
  enum { CELLS = 120 };
  PetscReal *W;
  Eigenvalue value;
  Pencil pencil, own;
  Norm left;
  Scene scene;
  Mesh mesh;

  CHECK(PetscMalloc1((CELLS + 1) * (CELLS + 1), &W));
  Setup(&scene, "-growth_type feed", 0, 10);
  EvenMesh(scene, CELLS, &mesh);
  CHECK(PencilCreate(PETSC_COMM_WORLD, scene, &mesh, at, WAY_X2, &pencil));
  CHECK(PencilCreate(PETSC_COMM_SELF, scene, &mesh, at, WAY_X2, &own));
  for (int k = 0; k < 2; k++) {
    CHECK(SpectrumLeftVectors(own, at, (PetscBool)k, W));
    CHECK(NormCreate(pencil, W, at, &left));
    for (int i = 0; i < 8; i++) {
      CHECK(NormGrowth(&left, at * i / 8, FRAME_ARC, &value));
      EXPECT(value.value < -0.001, "scaling %d: %g at t = %g", k, (double)value.value,
             (double)(at * i / 8));
    }
    CHECK(NormGrowth(&left, at, FRAME_ARC, &value));
    EXPECT(PetscAbsReal(value.value) < 1e-5, "scaling %d: %g at t_cr", k, (double)value.value);
    CHECK(NormDestroy(&left));
  }
  CHECK(PencilDestroy(&own));
  CHECK(PencilDestroy(&pencil));
  CHECK(MeshDestroy(&mesh));
  CHECK(SceneDestroy(&scene));
  CHECK(PetscFree(W));
}

static void TestSlowestMode(void **state) {
  PetscReal *s, *theta, most = 0;
  PetscInt n;
  Scene scene;

  Setup(&scene, "-growth_type uniform -shape_type mode", 1, 10);
  CHECK(StabilitySlowestMode(scene, &n, &s, &theta));
  for (PetscInt i = 0; i < n; i++) most = PetscMax(most, PetscAbsReal(theta[i]));
  EXPECT(theta[0] == 0 && PetscAbsReal(most - 0.02) < 1e-15, "largest angle %g", (double)most);
  EXPECT(s[0] == 0 && s[n - 1] == 1, "labels");
  EXPECT(PetscAbsReal(theta[n - 1] - theta[n - 2]) < 1e-5 * most, "curvature at the tip");
  CHECK(PetscFree(s));
  CHECK(PetscFree(theta));
  CHECK(SceneDestroy(&scene));
}

/* The propagator's transpose is exact, its steps are accurate, and no deflection beats the theorem
   d|y|/dt <= lambda_max |y| in the friction norm. */
static void TestPropagator(void **state) {
  enum { CELLS = 60, N = CELLS + 1, PIECES = 200 };
  PetscReal x[N], y[N], px[N], py[N], a = 0, b = 0, exponent = 0;
  Optimal rough, fine;
  Propagator propagator;
  Scene scene;
  Mesh mesh;

  Setup(&scene, "-growth_type uniform", 1, 10);
  EvenMesh(scene, CELLS, &mesh);
  CHECK(PropagatorCreate(scene, &mesh, WAY_X2, 0.5, 2.5, 1e-9, &propagator));
  for (int i = 0; i < N; i++) {
    px[i] = x[i] = Scatter(1, (uint64_t)i);
    py[i] = y[i] = Scatter(2, (uint64_t)i);
  }
  CHECK(PropagatorApply(&propagator, PETSC_FALSE, px));
  CHECK(PropagatorApply(&propagator, PETSC_TRUE, py));
  for (int i = 0; i < N; i++) a += px[i] * y[i], b += x[i] * py[i];
  EXPECT(PetscAbsReal(a - b) < 1e-10 * PetscAbsReal(a), "<Phi x, y> %.14g, <x, Phi^T y> %.14g",
         (double)a, (double)b);
  CHECK(TransientOptimal(&propagator, TRANSIENT_FRICTION, &fine));
  CHECK(PropagatorDestroy(&propagator));
  CHECK(PropagatorCreate(scene, &mesh, WAY_X2, 0.5, 2.5, 1e-6, &propagator));
  CHECK(TransientOptimal(&propagator, TRANSIENT_FRICTION, &rough));
  CHECK(PropagatorDestroy(&propagator));
  EXPECT(PetscAbsReal(rough.amplification - fine.amplification) < 1e-4 * fine.amplification,
         "amplification %.10g and %.10g", (double)rough.amplification, (double)fine.amplification);
  for (int i = 0; i < PIECES; i++)
    exponent += Rate(scene, RATE_A, 0.5 + 2 * (i + 0.5) / PIECES, CELLS) * 2 / PIECES;
  EXPECT(fine.amplification < PetscExpReal(exponent) * (1 + 1e-4), "%g beats %g",
         (double)fine.amplification, (double)PetscExpReal(exponent));
  EXPECT(fine.amplification > 0.5 * PetscExpReal(exponent), "%g far from %g",
         (double)fine.amplification, (double)PetscExpReal(exponent));
  CHECK(OptimalDestroy(&rough));
  CHECK(OptimalDestroy(&fine));
  CHECK(MeshDestroy(&mesh));
  CHECK(SceneDestroy(&scene));
}

/* Viscous friction: for uniform growth and for feed the L2 norm is the friction norm, so it grows
   twice as fast as the rate, to the accuracy that is asked of NormGrowth(). */
static void TestPlainNorm(void **state) {
  const char *const laws[] = {"-growth_type uniform", "-growth_type feed"};

  for (int k = 0; k < 2; k++)
    for (int i = 0; i < 4; i++) {
      PetscReal t = 0.5 * i, L, L_t, rate;
      Eigenvalue value;
      Pencil pencil;
      Scene scene;
      Norm l2;
      Mesh mesh;
      Setup(&scene, laws[k], 0, 10);
      EvenMesh(scene, 100, &mesh);
      CHECK(PencilCreate(PETSC_COMM_WORLD, scene, &mesh, 1, WAY_X2, &pencil));
      CHECK(NormCreate(pencil, NULL, 1, &l2));
      CHECK(NormGrowth(&l2, t, FRAME_LABEL, &value));
      CHECK(GrowthLength(scene->growth, t, &L, &L_t));
      rate = Rate(scene, RATE_FRICTION, t, 100);
      if (k) value.value += L_t / L;
      EXPECT(PetscAbsReal(value.value - 2 * rate) < 2e-9 * PetscMax(1, 2 * PetscAbsReal(rate)),
             "law %d, t %g: %.14g and twice %.14g", k, (double)t, (double)value.value,
             (double)rate);
      CHECK(NormDestroy(&l2));
      CHECK(PencilDestroy(&pencil));
      CHECK(MeshDestroy(&mesh));
      CHECK(SceneDestroy(&scene));
    }
}

/* What z is fixed to is a matter of the mesh only: the norm grows alike on the map of another time.
 */
static void TestMap(void **state) {
  const PetscReal map[] = {0.6, 1.5};
  PetscReal found[2];
  Scene scene;

  Setup(&scene, "-growth_type gaussian -growth_width 0.5", 0.5, 10);
  for (int k = 0; k < 2; k++) {
    Eigenvalue value;
    Pencil pencil;
    Norm l2;
    Mesh mesh;
    EvenMesh(scene, 300, &mesh);
    CHECK(PencilCreate(PETSC_COMM_WORLD, scene, &mesh, map[k], WAY_X2, &pencil));
    CHECK(NormCreate(pencil, NULL, map[k], &l2));
    CHECK(NormGrowth(&l2, 0.6, FRAME_LABEL, &value));
    found[k] = value.value;
    CHECK(NormDestroy(&l2));
    CHECK(PencilDestroy(&pencil));
    CHECK(MeshDestroy(&mesh));
  }
  EXPECT(PetscAbsReal(found[1] / found[0] - 1) < 1e-5, "%.12g and %.12g", (double)found[0],
         (double)found[1]);
  CHECK(SceneDestroy(&scene));
}

/* W^T W = D for rows scaled by friction; rows of length 1 in L2 make it M, which is D / L for
   viscous friction and uniform growth: the sum of squares tells them apart. */
static void TestScaling(void **state) {
  enum { CELLS = 40, N = CELLS + 1 };
  PetscReal W[N * N], sum[2] = {0, 0}, L;
  Pencil pencil;
  Scene scene;
  Mesh mesh;

  Setup(&scene, "-growth_type uniform", 0, 10);
  EvenMesh(scene, CELLS, &mesh);
  CHECK(PencilCreate(PETSC_COMM_SELF, scene, &mesh, 2, WAY_X2, &pencil));
  for (int k = 0; k < 2; k++) {
    CHECK(SpectrumLeftVectors(pencil, 2, (PetscBool)k, W));
    for (int i = 0; i < N * N; i++) sum[k] += W[i] * W[i];
  }
  CHECK(GrowthLength(scene->growth, 2, &L, NULL));
  EXPECT(PetscAbsReal(sum[0] / sum[1] / L - 1) < 1e-8, "%.12g, %.12g", (double)sum[0],
         (double)sum[1]);
  CHECK(PencilDestroy(&pencil));
  CHECK(MeshDestroy(&mesh));
  CHECK(SceneDestroy(&scene));
}

/* Both optimal shapes are what they are said to be: clamped, theta = dy/dp at their own time, their
   L2 norms in the ratio of the amplification; and the steps are of order 5. */
static void TestOptimal(void **state) {
  enum { CELLS = 200 };
  const PetscReal t[2] = {0.3, 1.2};
  Propagator propagator, rough;
  Optimal best;
  PetscReal size[2] = {0, 0};
  Scene scene;
  Mesh mesh;

  Setup(&scene, "-growth_type gaussian -growth_width 0.5", 1, 10);
  EvenMesh(scene, CELLS, &mesh);
  CHECK(PropagatorCreate(scene, &mesh, WAY_X2, t[0], t[1], 1e-9, &propagator));
  CHECK(PropagatorCreate(scene, &mesh, WAY_X2, t[0], t[1], 1e-6, &rough));
  EXPECT(propagator.steps < 5 * rough.steps, "%d and %d steps", (int)propagator.steps,
         (int)rough.steps);
  CHECK(TransientOptimal(&propagator, TRANSIENT_L2, &best));
  for (int k = 0; k < 2; k++) {
    const PetscReal *y = k ? best.y2 : best.y1, *theta = k ? best.theta2 : best.theta1;
    PetscReal worst = 0, most = 0;
    for (PetscInt i = 0; i < CELLS; i++) {
      PetscReal p[2];
      CHECK(GrowthArc(scene->growth, 2, best.s + i, t[k], p, NULL));
      worst = PetscMax(
          worst, PetscAbsReal(y[i + 1] - y[i] - (theta[i] + theta[i + 1]) / 2 * (p[1] - p[0])));
      most = PetscMax(most, PetscAbsReal(y[i + 1]));
      size[k] += (y[i] * y[i] + y[i + 1] * y[i + 1]) / 2 * (best.s[i + 1] - best.s[i]);
    }
    EXPECT(worst < 1e-4 * most && y[0] == 0, "shape %d: y and theta differ by %g", k,
           (double)(worst / most));
  }
  EXPECT(PetscAbsReal(PetscSqrtReal(size[1] / size[0]) / best.amplification - 1) < 1e-3,
         "norms %g and %g, amplification %g", (double)size[0], (double)size[1],
         (double)best.amplification);
  CHECK(OptimalDestroy(&best));
  CHECK(PropagatorDestroy(&rough));
  CHECK(PropagatorDestroy(&propagator));
  CHECK(MeshDestroy(&mesh));
  CHECK(SceneDestroy(&scene));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestTheorem),
                                          cmocka_unit_test(TestFeedNorm),
                                          cmocka_unit_test(TestBound),
                                          cmocka_unit_test(TestLeftNorm),       /* ranks 1 2 */
                                          cmocka_unit_test(TestLeftNormOfFeed), /* ranks 1 2 */
                                          cmocka_unit_test(TestSlowestMode),
                                          cmocka_unit_test(TestPropagator), /* ranks 1 2 */
                                          cmocka_unit_test(TestPlainNorm),  /* ranks 1 2 */
                                          cmocka_unit_test(TestMap),
                                          cmocka_unit_test(TestScaling),
                                          cmocka_unit_test(TestOptimal)}; /* ranks 1 2 */

MAIN(tests)
