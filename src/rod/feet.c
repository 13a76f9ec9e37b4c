#include "rod/feet.h"
#include "base/clones.h"

/* ---- what walls do at a foot ---- */

static Rubbed RubbedOf(const Foot *foot) {
  return (Rubbed){foot->on.x, foot->t, foot->v, foot->spin};
}

/* The dual of the k-th. */
static FrictionDual *DualOf(const FootCell *cell, FeetHeld held, const Feet *feet, PetscInt k) {
  if (cell->dims == 2) return k ? NULL : held;
  return ContactDual(3, &feet->touch[k], held);
}

/* The push at a foot, times its strength. */
static void Bear(const Push *push, Foot *foot) {
  for (int d = 0; d < 3; d++) foot->force[d] = foot->strength * push->force[d];
  foot->couple = foot->strength * push->couple;
  foot->normal = foot->strength * push->normal;
  foot->power = foot->strength * push->power;
}

/* How the place moves, v = x_t + c t, the spin even between the ends. */
static void MotionOf(const FootCell *cell, Foot *foot, CurveMotion *m) {
  const PetscReal z = foot->on.z;

  CurveMove(&cell->curve, &foot->on, m);
  foot->spin = cell->moves ? cell->spin[0] + z * (cell->spin[1] - cell->spin[0]) : 0;
  for (int d = 0; d < 3; d++) {
    foot->t[d] = m->t[d];
    foot->v[d] = cell->moves ? m->v[d] : 0;
  }
}

/* FeetPush - what walls do to the rod at the feet that FeetFind() has found. */
void FeetPush(const Contact *contact, const FootCell *cell, FeetHeld held, Feet *feet) {
  for (PetscInt k = 0; k < feet->n; k++) {
    Push push;
    CurveMotion m;
    Rubbed at;
    MotionOf(cell, &feet->foot[k], &m);
    at = RubbedOf(&feet->foot[k]);
    ContactPush(cell->dims, contact, &feet->touch[k], &at, DualOf(cell, held, feet, k), &push);
    Bear(&push, &feet->foot[k]);
  }
}

/* The part that each point of a cell of length h has in a foot, and its derivative by
   z: of the parabola through all three; in order 2, where the ends have no weight, the middle has
   all.
 */
static void Parts(PetscReal h, const PetscReal weight[FOOT_PARTS], PetscReal z,
                  PetscReal part[FOOT_ROWS], PetscReal part_z[FOOT_ROWS]) {
  const PetscBool ends = (PetscBool)(weight[0] > 0);

  CurveParabola(z, part, part_z);
  for (int k = 0; k < FOOT_PARTS; k++) {
    if (!ends) {
      part[k] = k == 1;
      part_z[k] = 0;
    }
    PetscReal all = weight[k] > 0 ? -1 / (h * weight[k]) : 0;
    part[k] *= all;
    part_z[k] *= all;
  }
  part[FOOT_KINK] = ends ? 1. / 12 - z * (1 - z) / 2 : 0;
  part_z[FOOT_KINK] = ends ? z - 0.5 : 0;
}

/* FeetHandOut - adds to the load of a cell's points, n' and m' = load, what the feet are to them.
 */
void FeetHandOut(const FootCell *cell, const Feet *feet, FootLoad load) {
  for (PetscInt j = 0; j < feet->n; j++) {
    const Foot *foot = &feet->foot[j];
    PetscReal part[FOOT_ROWS], part_z[FOOT_ROWS];
    Parts(cell->curve.h, cell->weight, foot->on.z, part, part_z);
    for (int k = 0; k < FOOT_ROWS; k++)
      for (int d = 0; d < 3; d++) {
        load[k][d] += part[k] * foot->force[d];
        load[k][3 + d] += part[k] * foot->couple * foot->t[d];
      }
  }
}

/* ---- derivatives ---- */

/* The derivatives at a fixed z: of x, x_z, of the tangent, the velocity and the spin. */
typedef struct {
  CurveBy x, slope, t, v;
  PetscReal spin[FOOT_UNKNOWNS];
} Fixed;

/* ... by the stretch of the ends, x' = g q, and by what the material slides by at all points. */
static void StretchBy(const FootCell *cell, const FootEnd end[2], PetscReal z, const CurveMotion *m,
                      Fixed *by) {
  const CurveCell *curve = &cell->curve;
  PetscReal value[4], slope[4], bend[4], part[3];

  Hermite(z, value, slope, bend);
  CurveParabola(z, part, NULL);
  for (int e = 0; e < 2; e++) {
    const int u = FOOT_STRETCHES * e + FOOT_STRETCH;
    const PetscReal *q = curve->q[e], along = slope[2 * e + 1] * curve->h * Dot3(m->t, q);
    for (int d = 0; d < 2; d++) {
      by->x[d][u] = value[2 * e + 1] * curve->h * q[d];
      by->slope[d][u] = slope[2 * e + 1] * curve->h * q[d];
      by->t[d][u] = (by->slope[d][u] - m->t[d] * along) / m->size;
      by->v[d][u] = m->c * by->t[d][u] + value[2 * e + 1] * curve->h * end[e].stretch_t[d];
      by->v[d][FOOT_STRETCHES * e + FOOT_SLIDE] = part[2 * e] * m->t[d];
    }
  }
  for (int d = 0; d < 2; d++) by->v[d][FOOT_MID_SLIDE] = part[1] * m->t[d];
}

ALWAYS_INLINE void FixedBy(int dims, int node, const FootCell *cell, const FootEnd end[2],
                           const Foot *foot, const CurveMotion *m, Fixed *by) {
  const CurveEnd *of[] = {&end[0].curve, &end[1].curve};
  const PetscReal z = foot->on.z;

  CurvePlaceBy(dims, node, &cell->curve, of, z, by->x, by->slope);
  CurveMotionBy(dims, node, &cell->curve, of, z, m, by->x, by->slope, by->t, by->v);
  if (node == FOOT_STRETCHES) StretchBy(cell, end, z, m, by);
  for (int e = 0; e < 2; e++)
    for (int f = 0; f < node; f++) by->spin[node * e + f] = (e ? z : 1 - z) * end[e].spin[f];
}

/* The derivative of x_z.H x_z by x, x_z held: by differences, for surfaces tell no third
   derivatives. Only where a share is between 0 and 1. */
static void SquareBy(const Contact *contact, const Foot *foot, const Touch *touch,
                     PetscReal by[3]) {
  const PetscReal e = 1e-5 * (foot->rho + touch->gap);

  for (int d = 0; d < 3; d++) {
    PetscReal square[] = {0, 0};
    for (int side = 0; side < 2; side++) {
      PetscReal x[3] = {foot->on.x[0], foot->on.x[1], foot->on.x[2]};
      Touch there;
      x[d] += side ? e : -e;
      if (ContactRidgeTouch(contact, foot->item, x, PETSC_MAX_REAL, &there))
        square[side] = FootSquare(there.bend, foot->on.slope);
    }
    by[d] = (square[1] - square[0]) / (2 * e);
  }
}

/* How rho changes as x and x_z do; square_by as SquareBy() has it. */
static PetscReal RhoBy(const Foot *foot, const Touch *touch, const PetscReal square_by[3],
                       const PetscReal dx[3], const PetscReal dslope[3]) {
  const PetscReal *w = foot->on.slope, along = FootSquare(touch->bend, w), size = Dot3(w, w);
  PetscReal by = Dot3(square_by, dx);

  for (int d = 0; d < 3; d++) by += 2 * Dot3(touch->bend[d], w) * dslope[d];
  return (2 * Dot3(w, dslope) - size / along * by) / along - Dot3(touch->normal, dx);
}

/* How a foot changes with an unknown. */
typedef struct {
  PetscReal z, x[3], slope[3], t[3], v[3], spin;
} Change;

/*
  With the derivatives at a fixed z,

    dz = -(x_z.H dx + n.dx_z) / (x_z.H x_z + n.x_zz),

  and all else changes by z besides.
*/
ALWAYS_INLINE void ChangeOf(int dims, const FootCell *cell, const Foot *foot, const Touch *touch,
                            const CurveMotion *m, const Fixed *by, int u, Change *change) {
  PetscReal z = 0;

  for (int d = 0; d < dims && !foot->ends; d++)
    z -= (Dot3(touch->bend[d], foot->on.slope) * by->x[d][u] + touch->normal[d] * by->slope[d][u]) /
         FootStiff(foot, touch);
  *change = (Change){.z = z, .spin = by->spin[u] + (cell->spin[1] - cell->spin[0]) * z};
  for (int d = 0; d < dims; d++) {
    change->x[d] = by->x[d][u] + foot->on.slope[d] * z;
    change->slope[d] = by->slope[d][u] + foot->on.bend[d] * z;
    change->t[d] = by->t[d][u] + m->t_z[d] * z;
    change->v[d] = by->v[d][u] + m->v_z[d] * z;
  }
}

/* ... and its force and, as a vector along the tangent, its couple; more: by how much of itself the
   strength changes. */
static void LoadChange(const Foot *foot, const Push *push, const Change *change, PetscReal more,
                       PetscReal dF[FOOT_LOAD]) {
  PetscReal by[4];

  for (int r = 0; r < 4; r++)
    by[r] = foot->strength * (Dot3(push->x[r], change->x) + Dot3(push->q[r], change->t) +
                              Dot3(push->W[r], change->v) + push->W[r][3] * change->spin);
  for (int d = 0; d < 3; d++) {
    dF[d] = by[d] + more * foot->force[d];
    dF[3 + d] = (by[3] + more * foot->couple) * foot->t[d] + foot->couple * change->t[d];
  }
}

/* Adds the derivatives of a foot's load. */
ALWAYS_INLINE void LineariseOne(int dims, int node, const Contact *contact, const FootCell *cell,
                                const FootEnd end[2], const Push *push, const Touch *touch,
                                Foot *foot, FootSlope slope) {
  PetscReal part[FOOT_ROWS], part_z[FOOT_ROWS], square_by[3] = {0}, dF[FOOT_LOAD];
  CurveMotion m;
  Fixed by;

  MotionOf(cell, foot, &m);
  FixedBy(dims, node, cell, end, foot, &m, &by);
  Parts(cell->curve.h, cell->weight, foot->on.z, part, part_z);
  if (foot->strength_rho != 0) SquareBy(contact, foot, touch, square_by);
  for (int u = 0; u < 2 * node; u++) {
    PetscReal more = 0;
    Change change;
    ChangeOf(dims, cell, foot, touch, &m, &by, u, &change);
    if (foot->strength_rho != 0)
      more = foot->strength_rho * RhoBy(foot, touch, square_by, change.x, change.slope) /
             foot->strength;
    LoadChange(foot, push, &change, more, dF);
    for (int k = 0; k < FOOT_ROWS; k++)
      for (int d = 0; d < 3; d++) {
        slope[k][d][u] += part[k] * dF[d] + part_z[k] * change.z * foot->force[d];
        slope[k][3 + d][u] +=
            part[k] * dF[3 + d] + part_z[k] * change.z * foot->couple * foot->t[d];
      }
  }
}

/*
  FeetLinearise - adds to the derivatives of the load of a cell's points those of feet that
  FeetPush() has seen, the duals of their friction brought up to the slip first.

  end    how the ends of the cell change      fresh  a Newton solve begins
  slope  by the unknowns of both nodes: FOOT_PLANE, FOOT_STRETCHES or FOOT_NODE of each
*/
void FeetLinearise(const Contact *contact, const FootCell *cell, const FootEnd end[2],
                   PetscBool fresh, FeetHeld held, Feet *feet, FootSlope slope) {
  if (held) ContactSlots(cell->dims, feet->n, feet->touch, held);
  for (PetscInt k = 0; k < feet->n; k++) {
    const Rubbed at = RubbedOf(&feet->foot[k]);
    const Touch *touch = &feet->touch[k];
    Push push = {.couple = 0};
    ContactPushSlope(cell->dims, contact, touch, &at, fresh, DualOf(cell, held, feet, k), &push);
    if (cell->stretches)
      LineariseOne(2, FOOT_STRETCHES, contact, cell, end, &push, touch, &feet->foot[k], slope);
    else if (cell->dims == 2)
      LineariseOne(2, FOOT_PLANE, contact, cell, end, &push, touch, &feet->foot[k], slope);
    else
      LineariseOne(3, FOOT_NODE, contact, cell, end, &push, touch, &feet->foot[k], slope);
  }
}

/* FeetHold - moves what holds feet that stick (exact Coulomb friction); returns the speed at which
   they creep. */
PetscReal FeetHold(const Contact *contact, const FootCell *cell, Feet *feet, PetscReal seen,
                   FeetHeld held) {
  PetscReal creep = 0;

  ContactSlots(cell->dims, feet->n, feet->touch, held);
  for (PetscInt k = 0; k < feet->n; k++) {
    const Rubbed at = RubbedOf(&feet->foot[k]);
    creep = LargerOf(creep, ContactHoldTouch(cell->dims, contact, &feet->touch[k], &at, seen,
                                             friction_hold, DualOf(cell, held, feet, k)));
  }
  return creep;
}

/* FootShareRate - the rate of a foot's strength as the rod turns against what it meets, which
   rests; of what moves that is not known, and 0. */
PetscReal FootShareRate(const Contact *contact, const FootCell *cell, const Feet *feet,
                        PetscInt k) {
  const Foot *foot = &feet->foot[k];
  const Touch *touch = &feet->touch[k];
  const PetscReal *w = foot->on.slope;
  PetscReal x_t[3], slope_t[3], square_by[3], Hw[3], z_t = 0;

  if (foot->strength_rho == 0 || touch->moves || !cell->moves) return 0;
  CurveRates(&cell->curve, foot->on.z, x_t, slope_t);
  for (int d = 0; d < 3; d++) Hw[d] = Dot3(touch->bend[d], w);
  if (!foot->ends) z_t = -(Dot3(Hw, x_t) + Dot3(touch->normal, slope_t)) / FootStiff(foot, touch);
  for (int d = 0; d < 3; d++) {
    x_t[d] += w[d] * z_t;
    slope_t[d] += foot->on.bend[d] * z_t;
  }
  SquareBy(contact, foot, touch, square_by);
  return foot->strength_rho * RhoBy(foot, touch, square_by, x_t, slope_t);
}
