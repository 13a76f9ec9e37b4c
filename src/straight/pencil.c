#include "straight/pencil.h"
#include "base/bspline.h"
#include "straight/straight.h"
#include "straight/yielding.h"

/* B-splines on a cell at z = s: value[0..2] the quadratics, value[3..5] their slopes, value[6..9]
   the cubics. */
static void SplineValues(const Mesh *mesh, PetscInt cell, PetscReal s, PetscReal value[PER_POINT]) {
  BSplines b;

  BSplineEvaluate(mesh->cells, mesh->s, cell, s, &b);
  for (PetscInt k = 0; k < 3; k++) {
    value[k] = b.value[2][k];
    value[3 + k] = b.slope[2][k];
  }
  for (PetscInt k = 0; k < 4; k++) value[6 + k] = b.value[CUBIC][k];
}

/* The rows of this rank, the cells they touch, the splines at the Gauss points of these. */
static PetscErrorCode Allocate(Pencil self) {
  const Mesh *mesh = self->mesh;
  PetscInt nloc = PETSC_DECIDE, end, labels;

  PetscFunctionBegin;
  PetscCall(PetscSplitOwnership(self->comm, &nloc, &self->n));
  PetscCallMPI(MPI_Scan(&nloc, &self->last, 1, MPIU_INT, MPI_SUM, self->comm));
  self->first = self->last - nloc;
  self->cell = PetscMin(mesh->cells - 1, PetscMax(0, self->first - self->ahead - 1));
  end = PetscMin(mesh->cells, PetscMax(self->last - self->ahead + 2, self->cell + 1));
  self->cells = end - self->cell;
  labels = (mesh->cells - self->cell) * GAUSS + 1;
  PetscCall(PetscMalloc2(self->cells * GAUSS, &self->point, self->cells * GAUSS * PER_POINT,
                         &self->basis));
  PetscCall(PetscMalloc7(nloc, &self->delta, labels, &self->z, labels, &self->label, labels,
                         &self->stretch, labels, &self->force, mesh->cells + 1, &self->node,
                         self->ways > 1 ? labels : 0, &self->turn));
  for (PetscInt c = 0; c < mesh->cells - self->cell; c++)
    for (int q = 0; q < GAUSS; q++) {
      PetscReal left = mesh->s[self->cell + c], h = mesh->s[self->cell + c + 1] - left;
      self->z[c * GAUSS + q] = left + h * gauss_point[q];
      if (c < self->cells)
        SplineValues(mesh, self->cell + c, left + h * gauss_point[q],
                     self->basis + (c * GAUSS + q) * PER_POINT);
    }
  self->z[labels - 1] = 1;
  for (PetscInt i = 0; i < nloc; i++) {
    PetscInt j = self->first + i - self->ahead;
    self->delta[i] =
        (BSplineKnot(mesh->cells, mesh->s, j + 2) - BSplineKnot(mesh->cells, mesh->s, j - 1)) / 3;
  }
  PetscFunctionReturn(0);
}

/* The label s of a place z, p(s, t) = z L(t): Newton's method within a bracket, from the guess s.
 */
static PetscErrorCode Label(Growth growth, PetscReal z, PetscReal t, PetscReal L, PetscReal *s) {
  PetscReal low = 0, high = 1, p, g;

  PetscFunctionBegin;
  for (int k = 0; k < 100; k++) {
    PetscReal old = *s;
    PetscCall(GrowthArc(growth, 1, s, t, &p, NULL));
    PetscCall(GrowthStretch(growth, 1, s, t, &g, NULL, NULL));
    if (p < z * L)
      low = *s;
    else
      high = *s;
    *s += (z * L - p) / g;
    if (!(*s >= low && *s <= high)) *s = (low + high) / 2;
    if (PetscAbsReal(*s - old) <= 2e-16 * PetscAbsReal(*s)) break;
  }
  PetscFunctionReturn(0);
}

/* Places labels for z = p / L at time t. */
static PetscErrorCode Map(Pencil self, PetscReal t) {
  PetscInt points = (self->mesh->cells - self->cell) * GAUSS;
  PetscReal L, g, s = 0;

  PetscFunctionBegin;
  PetscCall(GrowthLength(self->growth, t, &L, NULL));
  self->label[points] = 1;
  for (PetscInt i = 0; i < points; i++) {
    s = self->z[i];
    if (!self->growth->even) {
      s = i ? self->label[i - 1] : s;
      PetscCall(Label(self->growth, self->z[i], t, L, &s));
    }
    PetscCall(GrowthStretch(self->growth, 1, &s, t, &g, NULL, NULL));
    self->label[i] = s;
    self->stretch[i] = L / g;
  }
  s = 0;
  for (PetscInt i = 0; i <= self->mesh->cells; i++) {
    if (self->growth->even || i == 0 || i == self->mesh->cells)
      s = self->mesh->s[i];
    else
      PetscCall(Label(self->growth, self->mesh->s[i], t, L, &s));
    self->node[i] = s;
  }
  PetscFunctionReturn(0);
}

/* Does material slide past the places at which a problem stands still? Where growth that feels
   force is all along, these are the material's own. */
static PetscBool Slides(Growth growth) {
  return (PetscBool)(growth->slides && !(growth->rests && growth->finest == 0));
}

/* Is the straight rod a solution, and are its eigenvalues to be had? Where material is at rest they
   crowd towards 0 as beta falls. */
static PetscErrorCode CheckStraight(Scene scene) {
  const PetscReal least = 1e-6;
  const Friction *friction = &scene->load.friction;

  PetscFunctionBegin;
  UserCheck(
      LoadIsEven(&scene->load, scene->reach, scene->end_time), scene->comm,
      "-friction_field: it changes across the rod's axis, where a straight rod does not stay "
      "straight; -task critical, -task stability and -shape_type mode need one that does not");
  UserCheck(!scene->growth->rests || scene->growth->finest == 0 || friction->mu == 0 ||
                friction->beta >= least,
            scene->comm,
            "-friction_beta: material behind the growth zone is at rest; for its eigenvalues take "
            "%g at least",
            (double)least);
  PetscFunctionReturn(0);
}

/*
  PencilCreate - prepares the linear problem on a mesh. Collective on comm.

  mesh     in z; outlives the pencil, as does the scene; mesh->cells + 1 unknowns of each kind
  map      the time that z belongs to, or map_follows
  way      the deflection that it is about: one of StraightWays()
  pencil   the caller destroys it with PencilDestroy(); PencilSetTime() comes before any assembly
*/
PetscErrorCode PencilCreate(MPI_Comm comm, Scene scene, const Mesh *mesh, PetscReal map,
                            StraightWay way, Pencil *pencil) {
  Pencil self;

  PetscFunctionBegin;
  PetscCall(CheckStraight(scene));
  PetscCall(PetscNew(&self));
  self->comm = comm;
  self->scene = scene;
  self->growth = scene->growth;
  self->way = way;
  self->ways = way == WAY_BOTH ? 2 : 1;
  self->skew = (PetscBool)(Slides(scene->growth) || scene->load.across != 1 ||
                           (scene->tip.force != 0 && scene->tip.law == TIP_FOLLOWER));
  self->held = scene->tip.type == TIP_FREE ? 0 : scene->tip.type == TIP_PINNED ? 1 : 2;
  self->mesh = mesh;
  self->ahead = scene->clamp == CLAMP_HINGED;
  self->n = mesh->cells + 1 + self->ahead;
  self->map = map;
  PetscCall(Allocate(self));
  if (map != map_follows) PetscCall(Map(self, map));
  *pencil = self;
  PetscFunctionReturn(0);
}

PetscErrorCode PencilDestroy(Pencil *pencil) {
  PetscFunctionBegin;
  if (!*pencil) PetscFunctionReturn(0);
  PetscCall(PetscFree2((*pencil)->point, (*pencil)->basis));
  PetscCall(PetscFree7((*pencil)->delta, (*pencil)->z, (*pencil)->label, (*pencil)->stretch,
                       (*pencil)->force, (*pencil)->node, (*pencil)->turn));
  PetscCall(PetscFree(*pencil));
  PetscFunctionReturn(0);
}

/* the drag on a deflection, g a N phi(V), at one label */
static PetscErrorCode DragAt(Pencil self, PetscReal s, PetscReal t, PetscReal *drag) {
  StraightMotion at;

  PetscFunctionBegin;
  PetscCall(StraightAt(self->scene, s, t, &at));
  *drag = at.g * at.drag * self->scene->load.across;
  PetscFunctionReturn(0);
}

/* PencilDrift - how fast the material at a label moves along the rod past the places at which a
   frame takes derivatives by time: c of labels, V of the arc length, V - L_t of the distance from
   the tip. In place they are all the same. */
PetscErrorCode PencilDrift(Pencil self, PetscReal s, PetscReal t, PencilFrame frame,
                           PetscReal *drift) {
  StraightMotion at;
  PetscReal L, L_t;

  PetscFunctionBegin;
  *drift = 0;
  if (!Slides(self->growth)) PetscFunctionReturn(0);
  PetscCall(StraightAt(self->scene, s, t, &at));
  PetscCall(GrowthLength(self->growth, t, &L, &L_t));
  *drift = frame == FRAME_LABEL ? at.c : frame == FRAME_ARC ? at.V : at.V - L_t;
  PetscFunctionReturn(0);
}

/* The load across is N phi (a v2 + (1 - a) V theta), v2 = y_t + drift theta: what stands before
   theta, over a N phi. */
static PetscErrorCode SlideAt(Pencil self, PetscReal s, PetscReal t, PencilFrame frame,
                              PetscReal *slide) {
  const PetscReal a = self->scene->load.across;
  StraightMotion at;
  PetscReal drift;

  PetscFunctionBegin;
  PetscCall(StraightAt(self->scene, s, t, &at));
  PetscCall(PencilDrift(self, s, t, frame, &drift));
  *slide = frame == FRAME_ARC && Slides(self->growth) ? at.V / a : drift + (1 - a) / a * at.V;
  PetscFunctionReturn(0);
}

/* The step of the central difference for D_t: its error, of second order, is below rounding's. */
static const PetscReal rate_step = 1e-5;

/* dp/dz = g s_z with s_z = L(t_map) / g(s, t_map); its derivative by z. */
static PetscErrorCode StretchAt(Pencil self, PetscReal map, PetscReal t, PetscInt i,
                                PencilPoint *x) {
  PetscReal s = self->label[i], s_z = self->stretch[i], g, g_s, m, m_s;

  PetscFunctionBegin;
  PetscCall(GrowthStretch(self->growth, 1, &s, t, &g, NULL, &g_s));
  PetscCall(GrowthStretch(self->growth, 1, &s, map, &m, NULL, &m_s));
  x->g = g * s_z;
  x->g_z = s_z * s_z * (g_s - g * m_s / m);
  x->ds = x->dz * s_z;
  PetscFunctionReturn(0);
}

/* Of stiffnesses B3, against a deflection along d2, and B2, along d3, that have turned. */
static void TurnedStiffness(Pencil self, PetscInt i, PencilPoint *x) {
  const PetscReal c = PetscCosReal(self->turn[i]), s = PetscSinReal(self->turn[i]), B2 = x->B,
                  B3 = B2 * self->scene->space.ratio;

  x->B = B3 * c * c + B2 * s * s;
  x->B33 = B3 * s * s + B2 * c * c;
  x->B23 = (B3 - B2) * s * c;
  x->M = self->moment;
}

/* The largest P^2/B of PencilBound(). Twist: M Im(u_p u*) <= B/2 |u_p|^2 + M^2/2B |u|^2 leaves half
   of B, and P + M^2/2B, with the weaker of two stiffnesses in place of B. */
static PetscReal Pushed(Pencil self, const PencilPoint *x) {
  PetscReal B = x->B, P = x->P, share = 1;

  if (self->ways > 1) {
    const PetscReal mean = (x->B + x->B33) / 2,
                    half = PetscSqrtReal(PetscSqr((x->B - x->B33) / 2) + PetscSqr(x->B23));
    B = mean - half;
    P += x->M * x->M / (2 * B);
    share = 2;
  }
  return P > 0 ? share * (P * P / B) : 0;
}

static PetscErrorCode PointSet(Pencil self, PetscReal t, PencilFrame frame, PetscInt i) {
  PencilPoint *x = self->point + i;
  const PetscReal *z = self->mesh->s + self->cell + i / GAUSS;
  PetscReal s = self->label[i], before = 0, after = 0;

  PetscFunctionBegin;
  x->dz = (z[1] - z[0]) * gauss_weight[i % GAUSS];
  PetscCall(StretchAt(self, self->map == map_follows ? t : self->map, t, i, x));
  PetscCall(DragAt(self, s, t, &x->drag));
  PetscCall(DragAt(self, s, t - rate_step, &before));
  PetscCall(DragAt(self, s, t + rate_step, &after));
  x->drag_rate = (after - before) / (2 * rate_step);
  x->P = self->force[i];
  PetscCall(SceneStiffness(self->scene, s, t, &x->B, NULL));
  if (self->ways > 1)
    TurnedStiffness(self, i, x);
  else
    x->B *= StraightRatio(self->scene, self->way);
  PetscCall(SlideAt(self, s, t, frame, &x->slide));
  x->ratio = 1;
  PetscFunctionReturn(0);
}

/* What pushes on the tip: n2 = - turns theta - drags v2, v2 = y_t + drift theta. */
static PetscErrorCode TipSet(Pencil self, PetscReal t, PencilFrame frame) {
  PencilTip *tip = &self->tip;
  PetscReal press, turns, before, after, map = self->map == map_follows ? t : self->map, g, m, L;
  const PetscReal one = 1;
  PetscReal drift;

  PetscFunctionBegin;
  PetscCall(StraightTip(self->scene, t - rate_step, &press, &turns, &before));
  PetscCall(StraightTip(self->scene, t + rate_step, &press, &turns, &after));
  PetscCall(StraightTip(self->scene, t, &press, &tip->turns, &tip->drags));
  tip->drags_rate = (after - before) / (2 * rate_step);
  PetscCall(PencilDrift(self, 1, t, frame, &drift));
  tip->turns += tip->drags * drift;
  PetscCall(GrowthStretch(self->growth, 1, &one, t, &g, NULL, NULL));
  PetscCall(GrowthStretch(self->growth, 1, &one, map, &m, NULL, NULL));
  PetscCall(GrowthLength(self->growth, map, &L, NULL));
  tip->g = g * L / m; /* dp/dz */
  PetscFunctionReturn(0);
}

/*
  PencilSetTime - evaluates all coefficients at time t. Collective.

  frame   FRAME_LABEL: y_t at fixed s, what the time stepping sees; FRAME_ARC: y_t at fixed arc
          length, the rod of frozen length that feed's eigenvalues are defined by; FRAME_TIP: at a
          fixed distance from the tip, where a growth zone rests. They differ for laws that slide
  only.
*/
PetscErrorCode PencilSetTime(Pencil self, PetscReal t, PencilFrame frame) {
  PetscInt labels = (self->mesh->cells - self->cell) * GAUSS + 1;
  PetscReal most[4] = {0, PETSC_MIN_REAL, PETSC_MIN_REAL, PETSC_MIN_REAL}, all[4];

  PetscFunctionBegin;
  if (self->growth->yield > 0) PetscCall(YieldingAt(self->scene, t));
  if (self->map == map_follows) PetscCall(Map(self, t));
  PetscCall(StraightForce(self->scene, labels, self->label, t, self->force));
  if (self->ways > 1)
    PetscCall(StraightTwist(self->scene, labels, self->label, t, &self->moment, self->turn));
  PetscCall(TipSet(self, t, frame));
  for (PetscInt i = 0; i < self->cells * GAUSS; i++) {
    const PencilPoint *x = self->point + i;
    PetscReal phi0;
    PetscCall(PointSet(self, t, frame, i));
    phi0 = x->drag * x->ds / (x->g * x->dz);
    most[0] = PetscMax(most[0], Pushed(self, x));
    most[1] = PetscMax(most[1], -phi0);
    most[2] = PetscMax(most[2], phi0);
    most[3] = PetscMax(most[3], x->drag_rate / x->drag);
  }
  PetscCall(MPIU_Allreduce(most, all, 4, MPIU_REAL, MPIU_MAX, self->comm));
  self->compression = all[0];
  self->drag_min = -all[1];
  self->drag_max = all[2];
  self->rate_max = all[3];
  self->time = t;
  PetscFunctionReturn(0);
}

/*
  PencilBound - a number that no eigenvalue of (K, D) exceeds, where K is symmetric; for other laws
  a shift.

  On a half line with a free end int y'^2 - y''^2 <= int y^2: the largest eigenvalue of
  -(y'''' + y'') there is 1. A rod clamped at s = 0 goes on as 0 behind its clamp, hence
  lambda <= max(P^2/B) / min(drag). Where y = 0 at both ends, of a hinge too, int y'^2 = - int y y''
  makes it a quarter of that. The margin covers quadrature and keeps the shift regular.
*/
PetscErrorCode PencilBound(Pencil self, PetscReal *bound) {
  PetscFunctionBegin;
  UserCheck(
      self->drag_min > 0, self->scene->comm,
      "-friction_field or -friction_mu: there is a place without friction across the rod at t "
      "= %g: a deflection there grows without bound",
      (double)self->time);
  *bound = 1.05 * self->compression / self->drag_min + 0.05;
  PetscFunctionReturn(0);
}

/* The integrand's weight of each form. */
static PetscReal Weight(const PencilPoint *x, PencilForm form) {
  switch (form) {
  case FORM_AXIAL:
    return x->dz * x->P / x->g;
  case FORM_BEND:
  case FORM_BEND_RATIO:
    return x->dz / x->g * x->B * (form == FORM_BEND ? 1 : x->ratio);
  case FORM_STIFF:
    return -(x->dz / x->g * x->B);
  case FORM_STIFF_3:
    return -(x->dz / x->g * x->B33);
  case FORM_BEND_23:
    return x->dz / x->g * x->B23;
  case FORM_TORQUE:
  case FORM_TORQUE_T:
    return x->dz * x->M / x->g;
  case FORM_DRAG:
    return x->ds * x->drag;
  case FORM_DRAG_RATE:
    return x->ds * x->drag_rate;
  case FORM_MASS:
    return x->ds;
  case FORM_SLIDE:
  case FORM_SLIDE_T:
    return -x->ds * x->drag * x->slide / x->g;
  default:
    return 0;
  }
}

/* Adds one Gauss point to the rows of this rank: value_i weight value_j. */
static void AddPoint(Pencil self, PetscInt row0, PetscInt nrow, const PetscReal *row, PetscInt col0,
                     PetscInt ncol, const PetscReal *col, PetscReal weight, PetscReal *band) {
  for (PetscInt i = 0; i < nrow; i++) {
    PetscInt r = row0 + i;
    if (r < self->first || r >= self->last) continue;
    for (PetscInt j = 0; j < ncol; j++)
      if (col0 + j >= 0)
        band[(r - self->first) * WIDTH + HALF + col0 + j - r] += weight * row[i] * col[j];
  }
}

/* At the tip y is the last of its coefficients, and w that of its own. */
static void AddTip(Pencil self, PencilForm form, PetscReal *band) {
  const PencilTip *tip = &self->tip;
  PetscReal *at = band + (self->n - 1 - self->first) * WIDTH + HALF;

  if (self->n - 1 < self->first || self->n - 1 >= self->last) return;
  if (form == FORM_DRAG) *at += tip->drags;
  if (form == FORM_DRAG_RATE) *at += tip->drags_rate;
  if (form == FORM_SLIDE || form == FORM_SLIDE_T) *at -= tip->turns / tip->g;
}

/*
  PencilBand - the rows of this rank of one form, at the time of PencilSetTime(). Not collective.

  band   [last - first][WIDTH], the caller's; entries outside the matrix are 0
*/
PetscErrorCode PencilBand(Pencil self, PencilForm form, PetscReal band[]) {
  PetscFunctionBegin;
  PetscCall(PetscArrayzero(band, (self->last - self->first) * WIDTH));
  for (PetscInt i = 0; i < self->cells * GAUSS; i++) {
    const PencilPoint *x = self->point + i;
    const PetscReal *w = self->basis + i * PER_POINT, *w1 = w + 3, *y = w + 6;
    PetscInt cell = self->cell + i / GAUSS + self->ahead;
    PetscReal curve[3]; /* (w/g)' */

    for (int k = 0; k < 3; k++) curve[k] = w1[k] / x->g - w[k] * x->g_z / (x->g * x->g);
    if (form == FORM_BEND || form == FORM_STIFF || form == FORM_BEND_RATIO ||
        form == FORM_STIFF_3 || form == FORM_BEND_23)
      AddPoint(self, cell - 1, 3, curve, cell - 1, 3, curve, Weight(x, form), band);
    if (form == FORM_TORQUE)
      AddPoint(self, cell - 1, 3, w, cell - 1, 3, curve, Weight(x, form), band);
    if (form == FORM_TORQUE_T)
      AddPoint(self, cell - 1, 3, curve, cell - 1, 3, w, Weight(x, form), band);
    if (form == FORM_AXIAL || form == FORM_STIFF || form == FORM_STIFF_3)
      AddPoint(self, cell - 1, 3, w, cell - 1, 3, w, Weight(x, FORM_AXIAL), band);
    if (form == FORM_DRAG || form == FORM_DRAG_RATE || form == FORM_MASS)
      AddPoint(self, cell - 2, 4, y, cell - 2, 4, y, Weight(x, form), band);
    if (form == FORM_SLIDE) AddPoint(self, cell - 2, 4, y, cell - 1, 3, w, Weight(x, form), band);
    if (form == FORM_SLIDE_T) AddPoint(self, cell - 1, 3, w, cell - 2, 4, y, Weight(x, form), band);
  }
  AddTip(self, form, band);
  PetscFunctionReturn(0);
}

/* PencilMatrixFromBand - a sparse matrix of a band; *A NULL: created, the caller's, else refilled
   in the same pattern. Collective. */
PetscErrorCode PencilMatrixFromBand(Pencil self, const PetscReal band[], Mat *A) {
  PetscInt nloc = self->last - self->first;

  PetscFunctionBegin;
  if (!*A) {
    PetscCall(
        MatCreateAIJ(self->comm, nloc, nloc, self->n, self->n, WIDTH, NULL, 2 * HALF, NULL, A));
    PetscCall(MatSetOption(*A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  }
  for (PetscInt r = self->first; r < self->last; r++) {
    PetscInt cols[WIDTH];
    for (int b = 0; b < WIDTH; b++) {
      PetscInt col = r - HALF + b;
      cols[b] = col < self->n ? col : -1; /* PETSc passes over negative columns */
    }
    PetscCall(
        MatSetValues(*A, 1, &r, WIDTH, cols, band + (r - self->first) * WIDTH, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* PencilMatrix - one form as a sparse n by n matrix, as PencilMatrixFromBand(). Collective. */
PetscErrorCode PencilMatrix(Pencil self, PencilForm form, Mat *A) {
  PetscReal *band;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((self->last - self->first) * WIDTH, &band));
  PetscCall(PencilBand(self, form, band));
  PetscCall(PencilMatrixFromBand(self, band, A));
  PetscCall(PetscFree(band));
  PetscFunctionReturn(0);
}

/* PencilDifference - E, which takes (c_i) to (c_i - c_{i-1}); the caller destroys it. */
PetscErrorCode PencilDifference(Pencil self, Mat *E) {
  PetscReal *band;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1((self->last - self->first) * WIDTH, &band));
  for (PetscInt i = 0; i < self->last - self->first; i++) {
    band[i * WIDTH + HALF] = 1;
    band[i * WIDTH + HALF - 1] = -1;
  }
  *E = NULL;
  PetscCall(PencilMatrixFromBand(self, band, E));
  PetscCall(PetscFree(band));
  PetscFunctionReturn(0);
}

/* PencilIsHeld - is unknown `kind` (0 w, 1 c) of node i held at 0? Of a pinned tip y, of a clamped
   one also w. */
PetscBool PencilIsHeld(Pencil self, PetscInt i, PetscInt kind) {
  return (PetscBool)(i == self->n - 1 &&
                     (kind == 1 ? self->held > 0 : kind == 0 && self->held > 1));
}

/* The kinds are 0 w, 1 c, 2 n, and 3 to 5 those of x3. */
static PetscErrorCode MixedBand(Pencil self, PetscInt row_kind, PetscInt col_kind,
                                const PetscReal band[], Mat A) {
  const PetscInt stride = 3 * self->ways;

  PetscFunctionBegin;
  if (!band) PetscFunctionReturn(0);
  for (PetscInt r = self->first; r < self->last; r++) {
    PetscInt cols[WIDTH], row = stride * r + row_kind;
    for (int b = 0; b < WIDTH; b++) {
      PetscInt col = r - HALF + b;
      cols[b] = col < 0 || col >= self->n || PencilIsHeld(self, col, col_kind % 3)
                    ? -1
                    : stride * col + col_kind;
    }
    if (PencilIsHeld(self, r, row_kind % 3)) continue;
    PetscCall(
        MatSetValues(A, 1, &row, WIDTH, cols, band + (r - self->first) * WIDTH, INSERT_VALUES));
  }
  PetscFunctionReturn(0);
}

/* E, E^T and Delta, which join w, c and n of one direction */
static PetscErrorCode MixedJoin(Pencil self, PetscInt way, Mat A) {
  const PetscInt stride = 3 * self->ways;

  PetscFunctionBegin;
  for (PetscInt i = self->first; i < self->last; i++) {
    PetscInt w = stride * i + 3 * way, c = w + 1, n = w + 2;
    PetscReal delta = self->delta[i - self->first];
    if (PencilIsHeld(self, i, 0))
      PetscCall(MatSetValue(A, w, w, 1, INSERT_VALUES));
    else {
      PetscCall(MatSetValue(A, w, n, -delta, INSERT_VALUES));
      PetscCall(MatSetValue(A, n, w, -delta, INSERT_VALUES));
    }
    if (PencilIsHeld(self, i, 1))
      PetscCall(MatSetValue(A, c, c, 1, INSERT_VALUES));
    else {
      PetscCall(MatSetValue(A, n, c, 1, INSERT_VALUES));
      PetscCall(MatSetValue(A, c, n, 1, INSERT_VALUES));
    }
    if (i > 0) PetscCall(MatSetValue(A, n, c - stride, -1, INSERT_VALUES));
    if (i < self->n - 1) PetscCall(MatSetValue(A, c, n + stride, -1, INSERT_VALUES));
  }
  PetscFunctionReturn(0);
}

/* By blocks of a node: in natural order none of them is singular when its turn comes, zeros on the
   diagonal or not (for w and c alone the form is definite, up to a few modes, and n's row holds all
   of the node's and of those before), so that LU needs no other exchange than within a block. */
static PetscErrorCode MixedCreate(Pencil self, Mat *A) {
  const PetscInt stride = 3 * self->ways;
  PetscInt nloc = stride * (self->last - self->first);

  PetscFunctionBegin;
  if (*A) PetscFunctionReturn(0);
  PetscCall(MatCreateBAIJ(self->comm, stride, nloc, nloc, stride * self->n, stride * self->n, WIDTH,
                          NULL, 2 * HALF, NULL, A));
  PetscCall(MatSetOption(*A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/*
  PencilMixed - the mixed pencil A z = lambda B z, z = (w, c, n) by node, 3 n rows; joined
  directions: (w, c, n) of x2 and of x3, 6 n rows. Collective.

  A, B   created if NULL on entry, else refilled (with the same bands present)
*/
PetscErrorCode PencilMixed(Pencil self, const PencilBands *bands, Mat *A, Mat *B) {
  const PetscReal *c = bands->c;
  PetscReal *zero;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1((self->last - self->first) * WIDTH, &zero));
  if (!c) c = zero; /* keep D's places in A: a shift then needs no new pattern */
  PetscCall(MixedCreate(self, A));
  for (PetscInt way = 0; way < self->ways; way++) {
    const PetscInt k = 3 * way;
    PetscCall(MixedBand(self, k, k, bands->K[way], *A));
    PetscCall(MixedBand(self, k + 1, k, bands->X, *A));
    PetscCall(MixedBand(self, k, k + 1, bands->XT, *A));
    PetscCall(MixedBand(self, k + 1, k + 1, c, *A));
    PetscCall(MixedJoin(self, way, *A));
  }
  if (self->ways > 1) {
    PetscCall(MixedBand(self, 0, 3, bands->K23, *A));
    PetscCall(MixedBand(self, 3, 0, bands->K32, *A));
  }
  PetscCall(PetscFree(zero));
  PetscCall(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY));
  if (!B) PetscFunctionReturn(0);
  PetscCall(MixedCreate(self, B));
  for (PetscInt way = 0; way < self->ways; way++)
    PetscCall(MixedBand(self, 3 * way + 1, 3 * way + 1, bands->D, *B));
  PetscCall(MatAssemblyBegin(*B, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*B, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* PencilSum - c = C w = E^-1 Delta w, running sums from the clamp. Collective. */
PetscErrorCode PencilSum(Pencil self, Vec w, Vec c) {
  PetscInt nloc = self->last - self->first;
  const PetscReal *a;
  PetscReal *b, sum = 0, before = 0;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArray(c, &b));
  for (PetscInt i = 0; i < nloc; i++) b[i] = sum += self->delta[i] * a[i];
  PetscCallMPI(MPI_Scan(&sum, &before, 1, MPIU_REAL, MPI_SUM, self->comm));
  before -= sum;
  for (PetscInt i = 0; i < nloc; i++) b[i] += before;
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(VecRestoreArray(c, &b));
  PetscFunctionReturn(0);
}

/* PencilSumTranspose - w = C^T c = Delta E^-T c, running sums from the tip. Collective. */
PetscErrorCode PencilSumTranspose(Pencil self, Vec c, Vec w) {
  PetscInt nloc = self->last - self->first;
  const PetscReal *a;
  PetscReal *b, sum = 0, upto = 0, total = 0;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(c, &a));
  PetscCall(VecGetArray(w, &b));
  for (PetscInt i = nloc - 1; i >= 0; i--) b[i] = sum += a[i];
  PetscCallMPI(MPI_Scan(&sum, &upto, 1, MPIU_REAL, MPI_SUM, self->comm));
  PetscCall(MPIU_Allreduce(&sum, &total, 1, MPIU_REAL, MPIU_SUM, self->comm));
  for (PetscInt i = 0; i < nloc; i++) b[i] = self->delta[i] * (b[i] + (total - upto));
  PetscCall(VecRestoreArrayRead(c, &a));
  PetscCall(VecRestoreArray(w, &b));
  PetscFunctionReturn(0);
}

/* PencilUnsum - w = C^-1 c, for E of PencilDifference(). c and w differ. */
PetscErrorCode PencilUnsum(Pencil self, Mat E, Vec c, Vec w) {
  PetscReal *b;

  PetscFunctionBegin;
  PetscCall(MatMult(E, c, w));
  PetscCall(VecGetArray(w, &b));
  for (PetscInt i = 0; i < self->last - self->first; i++) b[i] /= self->delta[i];
  PetscCall(VecRestoreArray(w, &b));
  PetscFunctionReturn(0);
}

/* PencilUnsumTranspose - c = C^-T w; w is overwritten by Delta^-1 w. */
PetscErrorCode PencilUnsumTranspose(Pencil self, Mat E, Vec w, Vec c) {
  PetscReal *b;

  PetscFunctionBegin;
  PetscCall(VecGetArray(w, &b));
  for (PetscInt i = 0; i < self->last - self->first; i++) b[i] /= self->delta[i];
  PetscCall(VecRestoreArray(w, &b));
  PetscCall(MatMultTranspose(E, w, c));
  PetscFunctionReturn(0);
}

/*
  PencilShape - deflection and angle at the nodes. Not collective.

  c, w       all n coefficients of y and of w = y', on every rank that calls
  y, theta   cells + 1 values at the nodes, or NULL: y, and dy/dp at time t, the one of
             PencilSetTime() if the map follows
*/
PetscErrorCode PencilShape(Pencil self, const PetscReal c[], const PetscReal w[], PetscReal t,
                           PetscReal y[], PetscReal theta[]) {
  const Mesh *mesh = self->mesh;
  PetscReal map = self->map == map_follows ? t : self->map;

  PetscFunctionBegin;
  for (PetscInt i = 0; i <= mesh->cells; i++) {
    PetscInt cell = PetscMin(i, mesh->cells - 1), at = cell + self->ahead;
    PetscReal value[PER_POINT], sum = 0, slope = 0, g, m, L;
    SplineValues(mesh, cell, mesh->s[i], value);
    for (PetscInt k = 0; k < 4; k++)
      if (y && at - 2 + k >= 0) sum += c[at - 2 + k] * value[6 + k];
    for (PetscInt k = 0; k < 3; k++)
      if (theta && at - 1 + k >= 0) slope += w[at - 1 + k] * value[k];
    PetscCall(GrowthStretch(self->growth, 1, &self->node[i], t, &g, NULL, NULL));
    PetscCall(GrowthStretch(self->growth, 1, &self->node[i], map, &m, NULL, NULL));
    PetscCall(GrowthLength(self->growth, map, &L, NULL));
    if (y) y[i] = sum;
    if (theta) theta[i] = slope / (g * L / m);
  }
  PetscFunctionReturn(0);
}
