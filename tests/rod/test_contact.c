/* Contact: Jacobians by rate with walls and with strands of the rod that press on each other,
   forces that cancel, feet that are feet.
   test: the Jacobian in contact is that of its differences and forces cancel | ranks 1 2 3 */
#include "rod/by_rate.h"
#include "rod/feet.h"
#include "rod/strands.h"

/* The normal force of feet on all posts in the initial shape at the time of ByRate(). */
static PetscReal FeetOf(const char *options) {
  const PetscReal t = 0.7;
  PetscReal sum = 0;
  Scene scene;
  Rod rod;
  Node *nodes;
  SetOptions("-ts_max_time 2 %s", options);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, &rod_frame, &rod));
  CHECK(SceneContactAt(scene, t));
  CHECK(PetscMalloc1(rod->end - rod->first, &nodes));
  CHECK(RodInitialNodes(rod, t, nodes));
  for (PetscInt i = rod->first; i + 1 < rod->end; i++) {
    const Node *node = nodes + i - rod->first;
    const FeetHeld none = NULL;
    FootCell cell = {.dims = 2, .curve = {.h = scene->mesh.s[i + 1] - scene->mesh.s[i]}};
    Feet feet;
    cell.first = (PetscBool)(i == 0);
    cell.last = (PetscBool)(i + 1 == rod->last);
    CHECK(GrowthStretch(scene->growth, 2, &scene->mesh.s[i], t, cell.curve.g, NULL, NULL));
    for (int e = 0; e < 2; e++) {
      cell.curve.q[e][0] = PetscCosReal(node[e].theta);
      cell.curve.q[e][1] = PetscSinReal(node[e].theta);
      for (int d = 0; d < 2; d++) cell.curve.x[e][d] = node[e].x[d];
    }
    FeetFind(&scene->contact, &cell, scene->contact.smooth, &feet);
    FeetPush(&scene->contact, &cell, none, &feet);
    for (PetscInt k = 0; k < feet.n; k++) sum += feet.foot[k].normal / feet.foot[k].strength;
  }
  CHECK(PetscFree(nodes));
  CHECK(RodDestroy(&rod));
  CHECK(SceneDestroy(&scene));
  return AllMax(sum);
}

static void ByRate(const char *options, PetscReal shift, PetscReal shake) {
  const PetscReal t = 0.7, e = 1e-5;
  Scene scene;
  Rod rod;
  RodState at;
  Vec U, U_t, w;
  Mat J;
  SetOptions("-friction_mu 0.7 -friction_beta 0.1 -friction_newton primal -ts_max_time 2 %s",
             options);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, &rod_frame, &rod));
  ShakenState(rod, t, shake, &U, &U_t);
  w = RandomVector(rod, 3, 1);
  CHECK(RodCreateMatrix(rod, &J));
  at = StateOf(t, U, U_t, shift);
  at.fresh = PETSC_TRUE;
  CHECK(rod->model->residual(rod, &at, w));
  CHECK(VecDestroy(&w));
  w = RandomVector(rod, 3, 1);
  CHECK(rod->model->jacobian(rod, &at, J));
  ExpectRate(rod, &at, J, w, e, 0.2, options);
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

static const char learns[] = " -tropism_gravity 2 -tropism_direction 0.3,-1 -growth_ironing 3 "
                             "-tropism_proprioception 1.5 -tropism_rate 0.7";

static void TestStrandJacobians(void **state) {
  static const char *const senses[] = {"", " -tropism_sensed tip -tropism_memory 0.4"};

  for (int k = 0; k < 2; k++) {
    char more[512];
    snprintf(more, sizeof(more), "%s -contact_friction 0.6%s%s", spiral[k], learns, senses[k]);
    ByRate(more, 3, 1e-3);
  }
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

/* Posts and corners narrower than a cell, with friction; one beside a node, one at the tip. */
static void TestFootJacobians(void **state) {
  const char *const walls[] = {
      "circle 0.2844 0.4475 0.01 outside friction 0.5\n",
      "polygon outside 0.2655 0.61 0.6 0.3 0.6 0.9 friction 0.7\n",
      "circle 0.1699 0.2195 0.02 outside\ncircle 0.1346 1.1267 0.02 outside friction 1\n"};
  for (size_t k = 0; k < sizeof(walls) / sizeof(walls[0]); k++)
    for (int order = 2; order <= 4; order += 2) {
      char file[64], options[320];
      WriteWalls(file, walls[k]);
      snprintf(options, sizeof(options),
               "-wall_file %s -contact_diameter 0.05 -contact_stiffness 4e3 -shape_amplitude 1.5 "
               "-clamp_angle 0.3 -rod_cells 12 -rod_order %d",
               file, order);
      EXPECT(FeetOf(options) > 0, "%s: there is no foot", walls[k]);
      ByRate(options, 3, 1e-3);
      ByRate(options, 0, 1e-3);
      if (order == 4) {
        (void)strcat(options, " -growth_yield 30");
        EXPECT(FeetOf(options) > 0, "%s: there is no foot", options);
        ByRate(options, 3, 1e-3);
      }
      RemoveFile(file);
    }
}

/* The pressure is minus the slope of the energy, and goes over smoothly. */
static void TestPressure(void **state) {
  Contact contact = {.any = PETSC_TRUE, .given = PETSC_TRUE, .stiffness = 70};
  ContactSetStiffness(&contact, (PetscReal[2]){1, 1}, (PetscReal[2]){0.1, 0}, (PetscReal[2]){1, 0});
  for (int i = -40; i <= 40; i++) {
    const PetscReal gap = contact.smooth * i / 20.1, e = 1e-5 * contact.smooth;
    PetscReal slope, skip,
        p = ContactPressure(&contact, gap, &slope),
        by_energy = (ContactEnergy(&contact, gap - e) - ContactEnergy(&contact, gap + e)) / (2 * e),
        by_p = (ContactPressure(&contact, gap + e, &skip) -
                ContactPressure(&contact, gap - e, &skip)) /
               (2 * e);
    EXPECT(PetscAbsReal(by_energy - p) < 1e-8 * contact.stiffness * contact.smooth,
           "gap %g: %g, %g", gap, p, by_energy);
    EXPECT(PetscAbsReal(by_p - slope) < 1e-4 * contact.stiffness, "gap %g: %g, %g", gap, slope,
           by_p);
  }
}

/* Contact that gets firmer where it is pressed in: beyond each of its pieces' ends, too, the
   pressure is minus the slope of the energy, and its slope does not jump; what k and w do in time
   is in the energy's rate. */
static void TestFirmPressure(void **state) {
  const PetscReal L = 0.05, step = 1e-6;
  Contact now = {.any = PETSC_TRUE, .firm = PETSC_TRUE, .diameter = 0.1}, then[2] = {now, now};
  PetscReal last = 0, skip;

  ContactSetStiffness(&now, (PetscReal[2]){1, 1}, (PetscReal[2]){0, 0}, (PetscReal[2]){L, 1});
  for (int i = 0; i < 2; i++)
    ContactSetStiffness(&then[i], (PetscReal[2]){1, 1}, (PetscReal[2]){0, 0},
                        (PetscReal[2]){L + (2 * i - 1) * step * L, 1});
  for (int i = 40; i >= -300; i--) {
    const PetscReal w = now.smooth, gap = w * i / 40.1, e = 1e-5 * w, k = now.stiffness;
    PetscReal slope,
        p = ContactPressure(&now, gap, &slope),
        by_energy = (ContactEnergy(&now, gap - e) - ContactEnergy(&now, gap + e)) / (2 * e),
        by_p = (ContactPressure(&now, gap + e, &skip) - ContactPressure(&now, gap - e, &skip)) /
               (2 * e),
        rate = (ContactEnergy(&then[1], gap) - ContactEnergy(&then[0], gap)) / (2 * step * L);
    EXPECT(PetscAbsReal(by_energy - p) < 1e-8 * k * w * (1 + p / (k * w)), "gap %g w: %g, %g",
           gap / w, p, by_energy);
    EXPECT(PetscAbsReal(by_p - slope) < 1e-4 * (k - slope), "gap %g w: %g, %g", gap / w, slope,
           by_p);
    EXPECT(PetscAbsReal(slope - last) < 0.03 * ContactFirmTimes(&now) * k,
           "gap %g w: the slope jumps from %g to %g", gap / w, last, slope);
    EXPECT(PetscAbsReal(ContactEnergyRate(&now, gap) - rate) <= 1e-6 * PetscAbsReal(rate),
           "gap %g w: rate %g, %g", gap / w, ContactEnergyRate(&now, gap), rate);
    if (gap > -contact_firm[0] * w && gap < -w)
      EXPECT(p == -k * gap, "gap %g w: %g is not %g", gap / w, p, -k * gap);
    last = slope;
  }
  EXPECT(PetscAbsReal(last / now.stiffness + ContactFirmTimes(&now)) < 1e-9, "%g k in the end",
         -last / now.stiffness);
}

/* Contact gets firmer of itself, once, when a state is so deep that this makes a
   difference, and to no other one; not where k is told, or follows from something else than the
   diameter. */
static void TestGetsFirm(void **state) {
  Contact thick = {.any = PETSC_TRUE, .diameter = 0.1},
          others[5] = {thick, thick, thick, thick, thick};
  const PetscReal depth[] = {1.49, 0.5, 1.51};
  PetscReal slope, before = 0;

  others[0].chosen = others[1].given = others[2].fine = PETSC_TRUE;
  others[3].any = PETSC_FALSE;
  others[4].diameter = 0;
  for (int i = 0; i < 5; i++) {
    CHECK(ContactMayGetFirm(&others[i]));
    EXPECT(!others[i].deepest && !ContactGetsFirm(&others[i], 1), "the other one, %d", i);
  }
  ContactSetStiffness(&thick, (PetscReal[2]){1, 1}, (PetscReal[2]){0, 0}, (PetscReal[2]){1, 0});
  CHECK(ContactMayGetFirm(&thick));
  EXPECT(thick.deepest && !thick.firm, "it is firm from the start, or cannot become so");
  for (int i = 0; i < 3; i++) {
    const PetscReal p = ContactPressure(&thick, -depth[i] * thick.smooth, &slope);
    if (!i) before = p;
    EXPECT(PetscAbsReal(*thick.deepest / thick.smooth - PetscMax(1.49, depth[i])) < 1e-12,
           "seen %g w deep, not %g", *thick.deepest / thick.smooth, depth[i]);
    if (i < 2) EXPECT(!ContactGetsFirm(&thick, *thick.deepest), "firm at %g w", depth[i]);
  }
  EXPECT(ContactGetsFirm(&thick, *thick.deepest) && thick.firm, "not firm at 1.51 w");
  EXPECT(!ContactGetsFirm(&thick, 1), "firm twice");
  EXPECT(ContactPressure(&thick, -depth[0] * thick.smooth, &slope) == before,
         "less deep: another law");
  EXPECT(ContactPressure(&thick, -3 * thick.smooth, &slope) > 4 * thick.smooth * thick.stiffness,
         "deeper: the same law");
  CHECK(ContactStaysSoft(&thick));
  EXPECT(!thick.firm && !ContactGetsFirm(&thick, 1), "it does not stay soft");
}

/* A force on the tip spreads over the length that its own stiffness makes of k, not the rod's. */
static void TestSoftTip(void **state) {
  Contact contact = {.any = PETSC_TRUE, .given = PETSC_TRUE, .stiffness = 16};
  ContactSetStiffness(&contact, (PetscReal[2]){81, 1}, (PetscReal[2]){0.1, 0},
                      (PetscReal[2]){1, 0});
  EXPECT(PetscAbsReal(contact.tip - 0.5) < 1e-14, "a soft tip's length: %g", contact.tip);
}

/* A rod shorter than thick is not to be pushed off by more than a part of its length; k and w
   change as their rates say. */
static void TestShortRod(void **state) {
  const PetscReal lengths[] = {0.01, 0.05, 0.5, 5}, step = 1e-6;
  for (size_t i = 0; i < sizeof(lengths) / sizeof(lengths[0]); i++) {
    const PetscReal L = lengths[i], D = 0.1;
    Contact now = {.any = PETSC_TRUE, .diameter = D, .usual = 1}, later = now;
    ContactSetStiffness(&now, (PetscReal[2]){1, 1}, (PetscReal[2]){0, 0}, (PetscReal[2]){L, 1});
    ContactSetStiffness(&later, (PetscReal[2]){1, 1}, (PetscReal[2]){0, 0},
                        (PetscReal[2]){L + step * L, 1});
    EXPECT(now.smooth < 2.1e-3 * PetscMin(D, L), "length %g: layer %g", L, now.smooth);
    EXPECT(PetscAbsReal((later.stiffness - now.stiffness) / (step * L) - now.stiffness_t) <
               1e-4 * now.stiffness / L,
           "length %g: rate of k %g", L, now.stiffness_t);
    EXPECT(PetscAbsReal((later.smooth - now.smooth) / (step * L) - now.smooth_t) <
               1e-4 * now.smooth / L,
           "length %g: rate of w %g", L, now.smooth_t);
  }
}

/* Energy and force of the walls at a place; within: how near they are seen. */
static PetscReal WallField(const Walls *walls, const PetscReal x[2], PetscReal f[2]) {
  const PetscReal within = 0.05;
  WallTouch touch[MOST_WALL_TOUCHES];
  const PetscReal place[3] = {x[0], x[1], 0};
  PetscInt n = WallsTouch(walls, place, 0.1, within, touch);
  PetscReal sum = 0;
  f[0] = f[1] = 0;
  for (PetscInt k = 0; k < n; k++) {
    sum += PetscSqr(within - touch[k].gap) / 2;
    Put2(Along2(From2(f), within - touch[k].gap, touch[k].normal), f);
  }
  return sum;
}

/* Is a place, in a clamp's frame turned by 0.3, out of the conduit of the test below? */
static PetscBool Outside(const PetscReal x[2]) {
  static const PetscReal axis[4][2] = {{0, 0}, {1, 0}, {1.5, 0.8}, {1.2, 1.6}};
  const PetscReal y[2] = {cos(0.3) * x[0] - sin(0.3) * x[1], sin(0.3) * x[0] + cos(0.3) * x[1]};
  for (int k = 0; k < 3; k++) {
    PetscReal t[2] = {axis[k + 1][0] - axis[k][0], axis[k + 1][1] - axis[k][1]}, z;
    z = ((y[0] - axis[k][0]) * t[0] + (y[1] - axis[k][1]) * t[1]) / (t[0] * t[0] + t[1] * t[1]);
    z = PetscMax(0, PetscMin(1, z));
    if (hypot(y[0] - axis[k][0] - z * t[0], y[1] - axis[k][1] - z * t[1]) < 0.18)
      return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* However soft contact is, the rod feels nothing farther than a hundredth of its diameter from it,
   and no rate of that. */
static void TestSoftContactIsNear(void **state) {
  Contact contact = {.any = PETSC_TRUE, .diameter = 0.1, .given = PETSC_TRUE, .stiffness = 1};

  ContactSetStiffness(&contact, (PetscReal[2]){1, 1}, (PetscReal[2]){0.1, 0.1},
                      (PetscReal[2]){1, 1});
  EXPECT(PetscAbsReal(contact.smooth - 0.001) < 1e-15 && contact.smooth_t == 0,
         "layer %g, its rate %g", contact.smooth, contact.smooth_t);
}

/* A wall about 0 with so many corners. */
static void RoundCavity(int corners, size_t room, char text[]) {
  size_t at = (size_t)snprintf(text, room, "polygon inside");
  for (int k = 0; k < corners; k++) {
    const PetscReal angle = 2 * PETSC_PI * k / corners;
    at += (size_t)snprintf(text + at, room - at, " %.6f %.6f", 0.5 * cos(angle), 0.5 * sin(angle));
  }
  (void)snprintf(text + at, room - at, "\n");
}

/* Along paths at random, past corners and through mouths: no jumps, and the force is minus the
   slope of the energy. */
static void TestWallsAreSmooth(void **state) {
  enum { CAVITIES = 3, ROOM = 8192 };
  const int corners[CAVITIES] = {18, 60, 300};
  static char cavity[CAVITIES][ROOM];
  for (int c = 0; c < CAVITIES; c++) RoundCavity(corners[c], ROOM, cavity[c]);
  const char *const file_of[] = {
      "polygon outside 0.3 0.2 0.8 0.1 0.9 0.9 0.4 0.8\n",
      "polygon inside 0 0 1 0 1 0.5 0.5 0.5 0.5 1 0 1\n",
      "path 0.2 0 0 1 0 1.5 0.8 1.2 1.6\n",
      "circle 0.5 0.5 0.3 outside\nplane 0.2 0 1 0.3\n",
      "polygon inside -0.3 -0.3 0.3 -0.3 0.302 -0.1 0.302 0.1 0.3 0.3 -0.3 0.3\n",
      "polygon outside -0.5 -0.5 0.5 -0.5 0.5 0.3 0.3 0.2 0 0.18 -0.2 0.2 -0.5 0.3\n",
      cavity[0],
      cavity[1],
      cavity[2]};
  for (size_t w = 0; w < sizeof(file_of) / sizeof(file_of[0]); w++) {
    Walls walls = {0};
    Surfaces surfaces = {0};
    PetscInt met = 0;
    PetscReal jump = 0, gain = 0; /* over a step: the largest */
    char file[64];
    WriteWalls(file, file_of[w]);
    CHECK(WallsRead(file, 0.1, 0, 0.3, &walls, &surfaces));
    for (int path = 0; path < 200; path++) {
      const PetscReal a[2] = {1.5 * Scatter(path, 1), 1.5 * Scatter(path, 2)},
                      turn = PETSC_PI * Scatter(path, 3), step = 1e-4;
      PetscReal before = 0, f0[2] = {0, 0};
      for (int i = 0; i <= 4000; i++) {
        PetscReal x[2] = {a[0] + i * step * PetscCosReal(turn),
                          a[1] + i * step * PetscSinReal(turn)},
                  f[2], now = WallField(&walls, x, f), size = hypot(f[0], f[1]);
        /* a conduit's mouth is a trumpet that ends: what is outside of it is not asked */
        if (w == 2 && Outside(x)) {
          f0[0] = f0[1] = 1;
          continue;
        }
        /* less deep than the rod is thick: what lies deeper has no side */
        if (i && size < 0.1 && hypot(f0[0], f0[1]) < 0.1) {
          PetscReal work = -step * ((f[0] + f0[0]) / 2 * PetscCosReal(turn) +
                                    (f[1] + f0[1]) / 2 * PetscSinReal(turn));
          met += size > 0;
          jump = PetscMax(jump, hypot(f[0] - f0[0], f[1] - f0[1]) / step);
          gain = PetscMax(gain, PetscAbsReal(now - before - work) / (step * step));
        }
        before = now;
        f0[0] = f[0], f0[1] = f[1];
      }
    }
    EXPECT(jump < 6, "%s: the force jumps by %g steps", file_of[w], jump);
    EXPECT(gain < 6, "%s: energy is off its work by %g steps squared", file_of[w], gain);
    EXPECT(met > 1000, "%s: met %d times", file_of[w], (int)met);
    CHECK(WallsDestroy(&walls));
    CHECK(SurfacesDestroy(&surfaces));
    RemoveFile(file);
  }
}

/* A spiral whose turns press on each other, bent by e in a way of its own; x at nodes. */
static void Spiral(const PetscReal s[], PetscInt cells, PetscReal L, PetscReal e, Node *nodes) {
  enum { PARTS = 40 };
  for (PetscInt i = 0; i <= cells; i++) {
    nodes[i].theta = 16 * s[i] - 4 * s[i] * s[i] + e * PetscSinReal(5 * s[i]);
    for (int d = 0; d < 2; d++) nodes[i].x[d] = i ? nodes[i - 1].x[d] : 0;
    for (int k = 0; i && k <= PARTS; k++) {
      PetscReal h = (s[i] - s[i - 1]) / PARTS, z = s[i - 1] + k * h,
                w = L * h / 3 * (k % PARTS ? 2 + 2 * (k % 2) : 1),
                theta = 16 * z - 4 * z * z + e * PetscSinReal(5 * z);
      nodes[i].x[0] += w * PetscCosReal(theta);
      nodes[i].x[1] += w * PetscSinReal(theta);
    }
  }
}

/* x at point k: a node, or the middle behind it. */
static PetscReal PointAt(const PetscReal s[], PetscReal L, const Node *nodes, PetscInt k, int d) {
  const Node *a = &nodes[k / 2], *b = a + k % 2;
  PetscReal h = L * (s[k / 2 + k % 2] - s[k / 2]);
  if (k % 2 == 0) return a->x[d];
  return (a->x[d] + b->x[d]) / 2 +
         h / 8 * (d ? sin(a->theta) - sin(b->theta) : cos(a->theta) - cos(b->theta));
}

/* The relative error of the work of the forces when the spiral bends, against the energy. */
static PetscReal WorkError(PetscInt cells) {
  const PetscReal t = 0.7, e = 1e-5;
  PetscReal energy[2], work = 0, L;
  const PetscReal(*force)[3];
  Node *nodes[3];
  Strands strands;
  StrandSum sum;
  Scene scene;
  SetOptions("-growth_initial_length 0.5 -ts_max_time 2 -rod_cells %d -contact_self "
             "-contact_diameter 0.03 -contact_stiffness 300",
             (int)cells);
  CHECK(SceneCreate(&scene));
  CHECK(StrandsCreate(scene, &strands));
  CHECK(GrowthLength(scene->growth, t, &L, NULL));
  for (int k = 0; k < 3; k++) {
    StrandState state = {.t = t, .stride = NODE_VALUES, .between = NODE_BETWEEN};
    CHECK(PetscCalloc1(cells + 1, &nodes[k]));
    Spiral(scene->mesh.s, cells, L, (k - 1) * e, nodes[k]);
    if (k == 1) continue;
    state.u = nodes[k][0].x;
    CHECK(StrandsSearch(strands, &state));
    CHECK(StrandsLoad(strands, &state));
    StrandsSum(strands, 0, &sum);
    energy[k / 2] = sum.energy;
  }
  {
    StrandState state = {
        .t = t, .stride = NODE_VALUES, .between = NODE_BETWEEN, .u = nodes[1][0].x};
    CHECK(StrandsSearch(strands, &state));
    CHECK(StrandsLoad(strands, &state));
    StrandsSum(strands, 0, &sum);
  }
  force = StrandsForces(strands);
  EXPECT(sum.normal > 0.01, "nothing touches: %g", sum.normal);
  EXPECT(hypot(sum.sum[0], sum.sum[1]) < 1e-12 * sum.normal, "sum %g, %g of %g", sum.sum[0],
         sum.sum[1], sum.normal);
  for (PetscInt k = 0; k <= 2 * cells + 1; k++)
    for (int d = 0; d < 2; d++) {
      const PetscReal *s = scene->mesh.s;
      PetscInt at = PetscMin(k, 2 * cells), i = at / 2;
      PetscReal weight = k > 2 * cells ? -1
                         : at % 2
                             ? 4 * (s[i + 1] - s[i]) / 6
                             : ((i ? s[i] - s[i - 1] : 0) + (i < cells ? s[i + 1] - s[i] : 0)) / 6;
      work -=
          weight * force[k][d] * (PointAt(s, L, nodes[2], at, d) - PointAt(s, L, nodes[0], at, d));
    }
  for (int k = 0; k < 3; k++) CHECK(PetscFree(nodes[k]));
  CHECK(StrandsDestroy(&strands));
  CHECK(SceneDestroy(&scene));
  return PetscAbsReal(work / (energy[0] - energy[1]) - 1);
}

/* The forces of strands cancel, and are minus the slope of their energy, ever better on finer
 * meshes. */
static void TestStrandsAreConservative(void **state) {
  PetscReal coarse = WorkError(50), fine = WorkError(100);
  print_message("work of strands off by %g, %g\n", (double)coarse, (double)fine);
  EXPECT(fine < 1e-3 && fine < coarse / 4, "off by %g, %g", coarse, fine);
}

/* The pattern of the matrix has room for feet that wander by a cell or so, and no more: most of it
   stays empty. */
static void TestPattern(void **state) {
  enum { CELLS = 120 };
  const PetscReal t = 0.7;
  MatInfo info;
  PetscReal part;
  Scene scene;
  Rod rod;
  RodState at;
  Vec U, U_t, F;
  Mat J;

  (void)state;
  SetOptions("-friction_mu 0.7 -ts_max_time 2 %s -rod_cells %d", spiral[0], CELLS);
  CHECK(SceneCreate(&scene));
  CHECK(RodCreate(scene, &rod_frame, &rod));
  ShakenState(rod, t, 0, &U, &U_t);
  CHECK(VecDuplicate(U, &F));
  CHECK(RodCreateMatrix(rod, &J));
  at = StateOf(t, U, U_t, 1);
  at.fresh = PETSC_TRUE;
  CHECK(rod->model->residual(rod, &at, F));
  CHECK(rod->model->jacobian(rod, &at, J));
  CHECK(MatGetInfo(J, MAT_GLOBAL_SUM, &info));
  part = info.nz_used / PetscSqr((PetscReal)(CELLS + 1) * rod->model->fields);
  print_message("%.3f of all entries\n", (double)part);
  EXPECT(part > 0.03 && part < 0.25, "%.3f of all entries", (double)part);
  CHECK(MatDestroy(&J));
  CHECK(VecDestroy(&U));
  CHECK(VecDestroy(&U_t));
  CHECK(VecDestroy(&F));
  CHECK(RodDestroy(&rod));
  CHECK(SceneDestroy(&scene));
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestPattern),
                                          cmocka_unit_test(TestPressure),
                                          cmocka_unit_test(TestFirmPressure),
                                          cmocka_unit_test(TestGetsFirm),
                                          cmocka_unit_test(TestSoftTip),
                                          cmocka_unit_test(TestShortRod),
                                          cmocka_unit_test(TestSoftContactIsNear),
                                          cmocka_unit_test(TestWallsAreSmooth),
                                          cmocka_unit_test(TestStrandsAreConservative),
                                          cmocka_unit_test(TestWallJacobians),
                                          cmocka_unit_test(TestFootJacobians),
                                          cmocka_unit_test(TestStrandJacobians)};
MAIN(tests)
