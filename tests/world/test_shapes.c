/* Tubes and bodies: distances against surfaces that are written down, gradients and second
   derivatives by differences, no jumps where pieces meet, orders; friction on a body.
   test: surfaces of each shape have their distance, normal and bend | ranks 1 2 */
#include "harness.h"
#include "base/vectors.h"
#include "world/body.h"
#include "world/contact_push.h"
#include "world/tube.h"

enum { FOUR = 4 };
static const PetscReal any = PETSC_MAX_REAL;

static PetscReal Dot(const PetscReal a[3], const PetscReal b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* ---- a tube about a helix, whose width varies ---- */

static const PetscReal helix_radius = 2, helix_rise = 0.4, turn = 2.4; /* z = rise * angle */

static void Helix(PetscReal a, PetscReal y[FOUR]) {
  y[0] = helix_radius * PetscCosReal(a);
  y[1] = helix_radius * PetscSinReal(a);
  y[2] = helix_rise * a;
  y[3] = 0.5 + 0.12 * PetscSinReal(turn * a);
}

static Tube HelicalTube(PetscInt n, PetscBool inside) {
  PetscReal(*ball)[FOUR];
  Tube tube = NULL;
  CHECK(PetscMalloc1(n, &ball));
  for (PetscInt k = 0; k < n; k++) Helix(4. * k / (n - 1), ball[k]);
  CHECK(TubeCreate("tube", n, (const PetscReal(*)[FOUR])ball, inside, 0.1, &tube));
  CHECK(PetscFree(ball));
  return tube;
}

/* The wall itself, seen from the analytic helix: at angle f about it the envelope of the balls is
   c - r r' t + r sqrt(1 - r'^2) (cos f N + sin f B), by arc length. */
static void WallAt(PetscReal a, PetscReal f, PetscReal x[3]) {
  const PetscReal speed = hypot(helix_radius, helix_rise), c = PetscCosReal(a), s = PetscSinReal(a);
  const PetscReal t[3] = {-helix_radius * s / speed, helix_radius * c / speed, helix_rise / speed},
                  N[3] = {-c, -s, 0},
                  B[3] = {helix_rise * s / speed, -helix_rise * c / speed, helix_radius / speed};
  PetscReal y[FOUR], slope = 0.12 * turn * PetscCosReal(turn * a) / speed, out;
  Helix(a, y);
  out = y[3] * PetscSqrtReal(1 - slope * slope);
  for (int d = 0; d < 3; d++)
    x[d] = y[d] - y[3] * slope * t[d] + out * (PetscCosReal(f) * N[d] + PetscSinReal(f) * B[d]);
}

/* The nearest point of the wall, by looking ever closer about the best. */
static PetscReal FromWall(const PetscReal x[3], PetscReal a, PetscReal f) {
  PetscReal best = any;
  for (PetscReal h = 0.3; h > 1e-9; h *= 0.5) {
    PetscReal at[2] = {a, f};
    for (int i = -3; i <= 3; i++)
      for (int j = -3; j <= 3; j++) {
        PetscReal y[3], o[3];
        WallAt(at[0] + i * h, at[1] + j * h, y);
        for (int d = 0; d < 3; d++) o[d] = x[d] - y[d];
        if (Dot(o, o) < best) best = Dot(o, o), a = at[0] + i * h, f = at[1] + j * h;
      }
  }
  return PetscSqrtReal(best);
}

/* A place this far inside of the wall. */
static void PlaceNear(int k, PetscReal depth, PetscReal *a, PetscReal *f, PetscReal x[3]) {
  PetscReal y[FOUR], wall[3], size = 0;
  *a = 2 + 1.5 * Scatter(1, (uint64_t)k);
  *f = PETSC_PI * Scatter(2, (uint64_t)k);
  WallAt(*a, *f, wall);
  Helix(*a, y);
  for (int d = 0; d < 3; d++) size += PetscSqr(y[d] - wall[d]);
  for (int d = 0; d < 3; d++) x[d] = wall[d] + depth * (y[d] - wall[d]) / PetscSqrtReal(size);
}

/* Both sides of the wall, both kinds of tube; with more points of order 4. */
static void TestTubeDistance(void **state) {
  PetscReal error[3] = {0};
  for (int m = 0; m < 3; m++)
    for (int inside = 0; inside < 2; inside++) {
      Tube tube = HelicalTube((16 << m) + 1, (PetscBool)inside);
      for (int k = 0; k < 60; k++) {
        PetscReal a, f, x[3], far, depth = 0.2 * Scatter(3, (uint64_t)k);
        SurfacePoint at;
        PlaceNear(k, depth, &a, &f, x);
        far = FromWall(x, a, f) * ((depth > 0) == (inside > 0) ? 1 : -1);
        EXPECT(TubeAt(tube, x, any, &at), "no wall at place %d", k);
        error[m] = PetscMax(error[m], PetscAbsReal(at.distance - far));
        EXPECT(PetscAbsReal(Dot(at.normal, at.normal) - 1) < 1e-13, "gradient not of length 1");
        EXPECT(!TubeAt(tube, x, far - 0.01, &at), "seen from farther than asked");
      }
      CHECK(TubeDestroy(&tube));
    }
  print_message("tube: errors %.2e %.2e %.2e, order %.2f\n", error[0], error[1], error[2],
                Order(error[1], error[2]));
  EXPECT(error[2] < 2e-6, "error %g", error[2]);
  EXPECT(Order(error[1], error[2]) > 3.5, "order %g", Order(error[1], error[2]));
}

typedef PetscBool (*Look)(void *surface, const PetscReal x[3], SurfacePoint *at);

static PetscBool LookTube(void *surface, const PetscReal x[3], SurfacePoint *at) {
  return TubeAt((Tube)surface, x, any, at);
}

static PetscBool LookBody(void *surface, const PetscReal x[3], SurfacePoint *at) {
  return BodyAt((Body)surface, x, any, at);
}

/* How far gradient and second derivatives are from central differences. */
static void Differences(Look look, void *surface, const PetscReal x[3], PetscReal h,
                        PetscReal off[2]) {
  SurfacePoint at, side[2];
  off[0] = off[1] = 0;
  EXPECT(look(surface, x, &at), "no surface");
  for (int d = 0; d < 3; d++) {
    for (int w = 0; w < 2; w++) {
      PetscReal y[3] = {x[0], x[1], x[2]};
      y[d] += w ? h : -h;
      EXPECT(look(surface, y, &side[w]), "no surface");
    }
    off[0] = PetscMax(off[0],
                      PetscAbsReal((side[1].distance - side[0].distance) / (2 * h) - at.normal[d]));
    for (int c = 0; c < 3; c++) {
      off[1] = PetscMax(
          off[1], PetscAbsReal((side[1].normal[c] - side[0].normal[c]) / (2 * h) - at.bend[c][d]));
      EXPECT(PetscAbsReal(at.bend[c][d] - at.bend[d][c]) < 1e-11, "not symmetric");
    }
  }
}

static void Derivatives(const char *what, Look look, void *surface, const PetscReal x[3]) {
  PetscReal coarse[2], fine[2];
  Differences(look, surface, x, 2e-3, coarse);
  Differences(look, surface, x, 1e-3, fine);
  for (int k = 0; k < 2; k++) /* C2: by h^2, across a knot by h */
    EXPECT(fine[k] < 1e-8 || (fine[k] < 2e-2 && fine[k] < 0.7 * coarse[k]),
           "%s: derivative %d off by %g, then %g", what, k + 1, coarse[k], fine[k]);
}

static void TestTubeDerivatives(void **state) {
  for (int inside = 0; inside < 2; inside++) {
    Tube tube = HelicalTube(33, (PetscBool)inside);
    for (int k = 0; k < 40; k++) {
      PetscReal a, f, x[3];
      PlaceNear(k, 0.15, &a, &f, x);
      Derivatives("tube", LookTube, tube, x);
    }
    CHECK(TubeDestroy(&tube));
  }
}

/* Nothing jumps on a walk along the wall, over knots and out of both mouths. */
static void TestTubeSmooth(void **state) {
  enum { STEPS = 4000 };
  const PetscReal h = 1e-3;
  Tube tube = HelicalTube(17, PETSC_TRUE);
  PetscReal most = 0, out[2] = {0};
  for (int side = -1; side <= 1; side += 2) {
    SurfacePoint before = {.distance = 0}, at;
    PetscBool seen = PETSC_FALSE;
    PetscReal x[3], y[FOUR], t[3], n[3] = {0}, wall[3], size = 0;
    /* straight on from the first or last place, beside the wall */
    PetscReal a = side < 0 ? 0 : 4;
    Helix(a, y);
    WallAt(a, 1, wall);
    t[0] = -helix_radius * PetscSinReal(a);
    t[1] = helix_radius * PetscCosReal(a);
    t[2] = helix_rise;
    size = PetscSqrtReal(Dot(t, t));
    for (int d = 0; d < 3; d++) t[d] *= side / size, n[d] = 0.9 * (wall[d] - y[d]);
    for (int k = -STEPS / 8; k < STEPS; k++) {
      for (int d = 0; d < 3; d++) x[d] = y[d] + n[d] + k * h * t[d];
      if (!TubeAt(tube, x, any, &at)) {
        if (k < 0) continue;
        out[side > 0] = k * h;
        break;
      }
      for (int i = 0; i < 3 && seen; i++)
        for (int j = 0; j < 3; j++)
          most = PetscMax(most, PetscAbsReal(at.bend[i][j] - before.bend[i][j]));
      before = at;
      seen = PETSC_TRUE;
    }
    EXPECT(before.distance > 0.2, "the mouth does not widen: %g", before.distance);
  }
  print_message("tube: second derivatives change by %.1e in %.0e; its mouths end at %.2f, %.2f\n",
                most, h, out[0], out[1]);
  EXPECT(most < 60 * h, "second derivatives jump by %g", most);
  EXPECT(out[0] > 0.3 && out[1] > 0.3, "no mouth: %g, %g", out[0], out[1]);
  CHECK(TubeDestroy(&tube));
}

/* A line, with two points, and a parabola, with three, are exact. */
static void TestTubeFewPoints(void **state) {
  const PetscReal line[2][FOUR] = {{0, 0, 0, 0.5}, {3, 4, 0, 0.5}},
                  bow[3][FOUR] = {{-1, 0.3, 0, 0.2}, {0, 0, 0, 0.2}, {1, 0.3, 0, 0.2}};
  PetscReal x[3] = {1.5, 2, 0.3};
  SurfacePoint at;
  Tube tube = NULL;
  CHECK(TubeCreate("tube", 2, line, PETSC_TRUE, 0, &tube));
  EXPECT(TubeAt(tube, x, any, &at), "no wall");
  EXPECT(PetscAbsReal(at.distance - 0.2) < 1e-14, "distance %g", at.distance);
  EXPECT(PetscAbsReal(at.normal[2] + 1) < 1e-14, "normal %g", at.normal[2]);
  EXPECT(PetscAbsReal(at.bend[0][0] + 0.64 / 0.3) < 1e-12, "bend %g", at.bend[0][0]);
  x[2] = 0; /* on the path */
  EXPECT(TubeAt(tube, x, any, &at) && at.distance == 0.5, "on the path %g", at.distance);
  EXPECT(PetscAbsReal(Dot(at.normal, at.normal) - 1) < 1e-14, "no normal on the path");
  EXPECT(TubeHolds(tube, x, 0.49) && !TubeHolds(tube, x, 0.51), "what it holds");
  x[2] = 1.2; /* through its wall */
  EXPECT(!TubeHolds(tube, x, 0), "holds what is beside it");
  EXPECT(!TubeAt(tube, x, any, &at), "the wall has no other side");
  x[0] = -30;
  x[1] = -40;
  EXPECT(TubeHolds(tube, x, 0.1), "not before its end");
  CHECK(TubeDestroy(&tube));
  CHECK(TubeCreate("tube", 3, bow, PETSC_FALSE, 0, &tube));
  x[0] = x[2] = 0;
  x[1] = -0.5;
  EXPECT(TubeAt(tube, x, any, &at), "no wall");
  EXPECT(PetscAbsReal(at.distance - 0.3) < 1e-14, "distance %g", at.distance);
  CHECK(TubeDestroy(&tube));
}

/* ---- bodies ---- */

static const PetscReal middle[3] = {0.1, -0.2, 0.05};

/* A sphere of radius 1, a plane, or an edge, hollow as seen from inside, on a grid of this spacing.
 */
typedef enum { PLANE, ROUND, EDGE } Form;

static PetscReal FormAt(Form form, const PetscReal x[3]) {
  const PetscReal along = 0.6 * x[0], up = 0.8 * x[2];
  if (form == ROUND) return PetscSqrtReal(Dot(x, x)) - 1;
  return form == PLANE ? along + up : PetscAbsReal(along) + up;
}

static void WriteGrid(PetscInt n, Form form, char path[64]) {
  const PetscInt dims[3] = {n, n + 2, n + 5}, three = 3;
  const PetscReal h = 3.2 / (n - 1), origin[3] = {-1.5, -1.8, -1.55}, spacing[3] = {h, h, h};
  PetscReal *values;
  CHECK(PetscMalloc1(dims[0] * dims[1] * dims[2], &values));
  for (PetscInt k = 0, at = 0; k < dims[0]; k++)
    for (PetscInt j = 0; j < dims[1]; j++)
      for (PetscInt i = 0; i < dims[2]; i++, at++) {
        const PetscReal x[3] = {origin[0] + i * h - middle[0], origin[1] + j * h - middle[1],
                                origin[2] + k * h - middle[2]};
        values[at] = FormAt(form, x);
      }
  OpenScratch(path);
  WriteScratch(path, 3, (const char *[]){"/distance", "/origin", "/spacing"}, (int[]){3, 1, 1},
               (const PetscInt *[]){dims, &three, &three},
               (const PetscReal *[]){values, origin, spacing});
  CHECK(PetscFree(values));
}

static Body Grid(PetscInt n, Form form, PetscBool inside) {
  char path[64];
  Body body = NULL;
  WriteGrid(n, form, path);
  CHECK(BodyRead("body", path, inside, 0.2, &body));
  RemoveFile(path);
  return body;
}

static void TestBodyOrder(void **state) {
  PetscReal error[3][3] = {{0}};
  for (int m = 0; m < 3; m++) {
    Body body = Grid((16 << m) + 1, ROUND, PETSC_FALSE);
    EXPECT(PetscAbsReal(BodySmallest(body) - 1) < 0.02 && BodyCore(body) > 0.9,
           "smallest %g, core %g", BodySmallest(body), BodyCore(body));
    for (int k = 0; k < 200; k++) {
      PetscReal x[3], e[3], size, far = 1 + 0.1 * Scatter(4, (uint64_t)k);
      SurfacePoint at;
      for (int d = 0; d < 3; d++) e[d] = Scatter(5 + (uint64_t)d, (uint64_t)k);
      size = PetscSqrtReal(Dot(e, e));
      for (int d = 0; d < 3; d++) e[d] /= size, x[d] = middle[d] + far * e[d];
      EXPECT(BodyAt(body, x, any, &at), "outside the grid");
      error[m][0] = PetscMax(error[m][0], PetscAbsReal(at.distance - (far - 1)));
      for (int d = 0; d < 3; d++) {
        error[m][1] = PetscMax(error[m][1], PetscAbsReal(at.normal[d] - e[d]));
        for (int c = 0; c < 3; c++)
          error[m][2] =
              PetscMax(error[m][2], PetscAbsReal(at.bend[d][c] - ((c == d) - e[c] * e[d]) / far));
      }
    }
    CHECK(BodyDestroy(&body));
  }
  for (int k = 0; k < 3; k++) {
    PetscReal order = Order(error[1][k], error[2][k]);
    print_message("body, derivative %d: errors %.2e %.2e %.2e, order %.2f\n", k, error[0][k],
                  error[1][k], error[2][k], order);
    EXPECT(order > 3.6 - k * 0.9, "derivative %d: order %g", k, order);
  }
}

static void TestBodyDerivatives(void **state) {
  for (int inside = 0; inside < 2; inside++) {
    Body body = Grid(17, ROUND, (PetscBool)inside);
    SurfacePoint at;
    PetscReal x[3] = {7, 0, 0};
    EXPECT(!BodyAt(body, x, any, &at), "a wall outside the grid");
    for (int k = 0; k < 60; k++) { /* in the rim, too */
      for (int d = 0; d < 3; d++) x[d] = middle[d] + 1.45 * Scatter(8 + (uint64_t)d, (uint64_t)k);
      Derivatives("body", LookBody, body, x);
    }
    CHECK(BodyDestroy(&body));
  }
}

/* A plane is exact but for the rim, where it gives way. */
static void TestBodyPlane(void **state) {
  Body body = Grid(17, PLANE, PETSC_TRUE);
  SurfacePoint at;
  PetscReal x[3] = {0.3, 0.1, 0.2}, far = 0.6 * 0.2 + 0.8 * 0.15;
  EXPECT(BodyAt(body, x, any, &at), "outside the grid");
  EXPECT(PetscAbsReal(at.distance + far) < 1e-13, "distance %g, not %g", at.distance, -far);
  EXPECT(PetscAbsReal(at.normal[0] + 0.6) < 1e-12, "normal %g", at.normal[0]);
  EXPECT(!BodyAt(body, x, -far - 0.01, &at), "seen from farther than asked");
  x[1] = -1.8;
  EXPECT(BodyAt(body, x, any, &at) && at.distance > -far + 0.15, "no rim: %g", at.distance);
  CHECK(BodyDestroy(&body));
}

/* A rod of diameter 0.4 in a body with a hollow edge, next to which the gradient of the
   interpolated distance is not of length 1. */
static void MakeEdge(Contact *contact) {
  const PetscReal upright[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  char grid[64], file[64], line[128];
  *contact = (Contact){.any = PETSC_TRUE,
                       .diameter = 0.4,
                       .stiffness = 50,
                       .smooth = 0.02,
                       .rub = {.mu = 1, .beta = 0.1}};
  WriteGrid(17, EDGE, grid);
  (void)snprintf(line, sizeof(line), "body %s inside friction 0.5\n", grid);
  WriteWalls(file, line);
  CHECK(WallsRead(file, 0.2, 0, 0, &contact->walls, &contact->surfaces));
  ContactSetFrame(contact, upright, 0, (const PetscReal[3]){0});
  RemoveFile(file);
  RemoveFile(grid);
}

/* The force on a point of the rod there, its couple last. */
static PetscReal PushAt(const Contact *contact, const Rubbed *at, PetscReal f[4]) {
  Touch touch[MOST_TOUCHES];
  Push push;
  EXPECT(ContactTouches(3, contact, at->x, touch) == 1, "no touch");
  ContactPush(3, contact, touch, at, NULL, &push);
  for (int d = 0; d < 3; d++) f[d] = push.force[d];
  f[3] = push.couple;
  return push.normal;
}

/* Are the derivatives by place and velocity, which are set, those of the force? Returns the length
   of the gradient there. */
static PetscReal SlopesAt(const Contact *contact, const Rubbed *at, PetscReal x[3],
                          PetscReal v[3]) {
  const PetscReal e = 1e-6;
  PetscReal *const moved[2] = {x, v}, f[2][4];
  Touch touch[MOST_TOUCHES];
  Push push;
  (void)ContactTouches(3, contact, x, touch);
  ContactPushSlope(3, contact, touch, at, PETSC_TRUE, NULL, &push);
  for (int by = 0; by < 2; by++)
    for (int c = 0; c < 3; c++) {
      const PetscReal was = moved[by][c];
      for (int side = 0; side < 2; side++) {
        moved[by][c] = was + (side ? e : -e);
        (void)PushAt(contact, at, f[side]);
      }
      moved[by][c] = was;
      for (int d = 0; d < 4; d++) {
        const PetscReal is = by ? push.W[d][c] : push.x[d][c],
                        about = (f[1][d] - f[0][d]) / (2 * e);
        EXPECT(PetscAbsReal(about - is) < 1e-6 * contact->stiffness, "%s %d %d: %g, not %g",
               by ? "v" : "x", d, c, is, about);
      }
    }
  return PetscSqrtReal(Dot(touch->normal, touch->normal));
}

/* A look that is bounded tells what one without a bound does, if that is nearer, wherever one has
   looked before. */
static void TestBounds(void **state) {
  Tube tube = HelicalTube(60, PETSC_TRUE);
  Body body = Grid(33, ROUND, PETSC_TRUE);
  PetscInt near[2] = {0}, looks = 0;

  for (uint64_t k = 0; k < 600; k++) {
    const PetscReal within = 0.3 * (1 + Scatter(9, k));
    SurfacePoint free[2], bound[2];
    PetscReal x[FOUR], y[3];
    PetscBool known[2];
    Helix(2 + 2 * Scatter(10, k / 5), x); /* some looks at about the same place, then elsewhere */
    for (uint64_t d = 0; d < 3; d++) {
      x[d] += 0.4 * Scatter(11 + d, k);
      y[d] = middle[d] + 0.8 * Scatter(11 + d, k);
    }
    known[0] = TubeAt(tube, x, any, &free[0]);
    known[1] = BodyAt(body, y, any, &free[1]);
    for (int w = 0; w < 2; w++, looks++) {
      const PetscBool found =
          w ? BodyAt(body, y, within, &bound[w]) : TubeAt(tube, x, within, &bound[w]);
      assert_int_equal(found, known[w] && free[w].distance < within);
      if (found) assert_memory_equal(&bound[w], &free[w], sizeof(free[w]));
      near[w] += found;
    }
  }
  EXPECT(near[0] > 100 && near[1] > 100 && near[0] + near[1] < looks - 200, "%d, %d near of %d",
         (int)near[0], (int)near[1], (int)looks);
  CHECK(BodyDestroy(&body));
  CHECK(TubeDestroy(&tube));
}

/* What is pressed straight into a body does not rub on it; what slides along is held back by mu
   times what presses, along the surface; and the derivatives are those of the force. */
static void TestBodyFriction(void **state) {
  const PetscReal still[3] = {0}, q[3] = {0.6, 0.48, 0.64};
  PetscReal steep[2] = {1, 1};
  Contact contact;
  MakeEdge(&contact);
  for (int k = 0; k < 60; k++) {
    PetscReal x[3] = {middle[0] + 0.3 * Scatter(1, (uint64_t)k), 0, 0}, n[4], v[3], f[4], g[4],
              size, p, w;
    x[2] = middle[2] - 0.75 * PetscAbsReal(x[0] - middle[0]) - 0.2 + 0.05 * Scatter(2, (uint64_t)k);
    Rubbed at = {x, q, still, 0};
    p = PushAt(&contact, &at, n);
    size = PetscSqrtReal(Dot(n, n));
    EXPECT(PetscAbsReal(p - size) < 1e-12 * size, "presses with %g, tells %g", size, p);
    for (int d = 0; d < 3; d++) v[d] = -3 * n[d] / size;
    at.v = v;
    (void)PushAt(&contact, &at, f);
    for (int d = 0; d < 3; d++)
      EXPECT(PetscAbsReal(f[d] - n[d]) < 1e-12 * size, "pressed in it rubs: %g", f[d] - n[d]);
    v[0] += 0.7, v[1] -= 0.4;
    (void)PushAt(&contact, &at, f);
    for (int d = 0; d < 3; d++) f[d] -= n[d];
    EXPECT(PetscAbsReal(Dot(f, n)) < 1e-12 * size * size, "friction along the normal: %g",
           Dot(f, n) / size);
    for (int d = 0; d < 3; d++) g[d] = v[d] - Dot(v, n) * n[d] / (size * size);
    w = PetscSqrtReal(Dot(g, g) / (Dot(g, g) + 0.1));
    EXPECT(PetscAbsReal(PetscSqrtReal(Dot(f, f)) - 0.5 * w * size) < 1e-12 * size,
           "friction of %g on %g", PetscSqrtReal(Dot(f, f)), size);
    at.spin = 0.8;
    size = SlopesAt(&contact, &at, x, v);
    steep[0] = PetscMin(steep[0], size);
    steep[1] = PetscMax(steep[1], size);
  }
  EXPECT(steep[0] < 0.9 && steep[1] > 1.02, "the normal is of length %g to %g", steep[0], steep[1]);
  CHECK(WallsDestroy(&contact.walls));
  CHECK(SurfacesDestroy(&contact.surfaces));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestTubeDistance), cmocka_unit_test(TestTubeDerivatives),
    cmocka_unit_test(TestTubeSmooth),   cmocka_unit_test(TestTubeFewPoints),
    cmocka_unit_test(TestBodyOrder),    cmocka_unit_test(TestBodyDerivatives),
    cmocka_unit_test(TestBodyPlane),    cmocka_unit_test(TestBodyFriction),
    cmocka_unit_test(TestBounds)};
MAIN(tests)
