#include "rod/feet.h"
#include "base/bezier.h"
#include "curve/cell.h"
#include "rod/rules.h"

static PetscReal Dot(const PetscReal a[2], const PetscReal b[2]) {
  return a[0] * b[0] + a[1] * b[1];
}

/* ---- the curve ---- */

/* The sum of values at the ends and slopes there, by the polynomials. */
static inline PetscReal Sum(const PetscReal poly[4], PetscReal a, PetscReal a_z, PetscReal b,
                            PetscReal b_z) {
  return poly[0] * a + poly[1] * a_z + poly[2] * b + poly[3] * b_z;
}

/* FootCellBlock - what holds a cell's curve: the four points of its Bezier polygon. */
Block FootCellBlock(const FootCell *cell) {
  Block block = BlockEmpty(2);
  PetscReal b[4][2];

  BezierOfCell(2, cell->h, cell->g, cell->x[0], cell->q[0], b[0]);
  for (int k = 0; k < 4; k++) BlockHold(2, &block, b[k]);
  return block;
}

static void PlaceOn(const FootCell *cell, Foot *foot) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(foot->z, value, slope, bend);
  for (int d = 0; d < 2; d++) {
    const PetscReal a = cell->x[0][d], a_z = cell->h * cell->g[0] * cell->q[0][d],
                    b = cell->x[1][d], b_z = cell->h * cell->g[1] * cell->q[1][d];
    foot->x[d] = Sum(value, a, a_z, b, b_z);
    foot->slope[d] = Sum(slope, a, a_z, b, b_z);
    foot->bend[d] = Sum(bend, a, a_z, b, b_z);
  }
}

/* (x - c).x_z at a foot */
static PetscReal Lean(const Foot *foot, const PetscReal c[2]) {
  const PetscReal o[2] = {foot->x[0] - c[0], foot->x[1] - c[1]};
  return Dot(o, foot->slope);
}

/* The root of (x - c).x_z between 0 and 1, where it goes from below 0 to above: by Newton's method,
   or by halves where that leaves what is known to hold the root. */
static void Descend(const FootCell *cell, const PetscReal c[2], Foot *foot) {
  PetscReal low = 0, high = 1;

  foot->z = 0.5;
  for (int k = 0; k < rod_rule.nearest_iterations; k++) {
    PetscReal f, f_z, z, o[2];
    PlaceOn(cell, foot);
    f = Lean(foot, c);
    *(f > 0 ? &high : &low) = foot->z;
    for (int d = 0; d < 2; d++) o[d] = foot->x[d] - c[d];
    f_z = Dot(foot->slope, foot->slope) + Dot(o, foot->bend);
    z = f_z > 0 ? foot->z - f / f_z : -1;
    if (!(z > low && z < high)) z = (low + high) / 2;
    if (PetscAbsReal(z - foot->z) < rod_rule.nearest_found || high - low < rod_rule.nearest_found)
      return;
    foot->z = z;
  }
  PlaceOn(cell, foot);
}

/* FootAbout - is the curve of a cell nearest to c within the cell, or at its end if that is the
   rod's? (A cell asks by the directions of its nodes: so of two cells one has it.) Where: z, x and
   its derivatives, ends. */
PetscBool FootAbout(const FootCell *cell, const PetscReal c[2], Foot *foot) {
  PetscReal lean[2];

  for (int e = 0; e < 2; e++) {
    const PetscReal o[2] = {cell->x[e][0] - c[0], cell->x[e][1] - c[1]};
    lean[e] = Dot(o, cell->q[e]);
  }
  foot->ends = PETSC_TRUE;
  if (cell->first && lean[0] > 0)
    foot->z = 0;
  else if (cell->last && lean[1] <= 0)
    foot->z = 1;
  else if (lean[0] <= 0 && lean[1] > 0) {
    foot->ends = PETSC_FALSE;
    Descend(cell, c, foot);
    return PETSC_TRUE;
  } else
    return PETSC_FALSE;
  PlaceOn(cell, foot);
  return PETSC_TRUE;
}

/* ---- which posts are near ---- */

/* A search under way. */
typedef struct {
  const Contact *contact;
  const FootCell *cell;
  PetscReal within;
  PetscInt n;
  Foot *foot;
} Looking;

static PetscReal Meet(PetscInt item, PetscReal reach, void *ctx) {
  Looking *look = (Looking *)ctx;
  const WallPost *post = &look->contact->walls.post[item];
  Foot foot = {.post = item};
  PetscReal share_t,
      share = ContactPostShare(look->contact, post->r + look->contact->diameter / 2, &share_t);
  PetscInt k = look->n;

  if (share == 0 || !FootAbout(look->cell, post->at, &foot)) return reach;
  for (int d = 0; d < 2; d++) foot.n[d] = foot.x[d] - post->at[d];
  foot.distance = hypot(foot.n[0], foot.n[1]);
  foot.gap = foot.distance - post->r - look->contact->diameter / 2;
  if (foot.gap >= look->within || foot.distance == 0 || k == MOST_FEET) return reach;
  for (int d = 0; d < 2; d++) foot.n[d] /= foot.distance;
  foot.strength = share * look->contact->tip;
  foot.strength_t = share * look->contact->tip_t + share_t * look->contact->tip;
  for (; k > 0 && look->foot[k - 1].post > item; k--) look->foot[k] = look->foot[k - 1];
  look->foot[k] = foot;
  look->n++;
  return reach;
}

/* FeetFind - the feet of a cell on posts that are to be met so, with a gap below `within`; returns
   how many there are, in the order of posts. MOST_FEET: there may be more. */
PetscInt FeetFind(const Contact *contact, const FootCell *cell, PetscReal within,
                  Foot foot[MOST_FEET]) {
  Looking look = {.contact = contact, .cell = cell, .within = within, .foot = foot};
  Block block;

  if (!contact->thin) return 0;
  block = FootCellBlock(cell);
  BlocksNear(contact->walls.near_posts, &block, contact->diameter / 2 + PetscMax(0, within), Meet,
             &look);
  return look.n;
}

/* ---- forces ---- */

/* How fast a place moves, v = x_t + c t; and by z. */
typedef struct {
  PetscReal v[2], v_z[2], t[2], size, c; /* tangent, |x_z|, slide */
} Motion;

/* h times the rate of the slope g q at an end. */
static void EndRate(const FootCell *cell, int e, PetscReal rate[2]) {
  const PetscReal turn = cell->g[e] * cell->theta_t[e];
  rate[0] = cell->h * (cell->g_t[e] * cell->q[e][0] - turn * cell->q[e][1]);
  rate[1] = cell->h * (cell->g_t[e] * cell->q[e][1] + turn * cell->q[e][0]);
}

static void MotionOf(const FootCell *cell, const Foot *foot, Motion *m) {
  const PetscReal z = foot->z, *c = cell->c;
  PetscReal value[4], slope[4], bend[4], rate[2][2], c_z, along;

  Hermite(z, value, slope, bend);
  for (int e = 0; e < 2; e++) EndRate(cell, e, rate[e]);
  m->size = hypot(foot->slope[0], foot->slope[1]);
  m->c = CurveBetween(c, z);
  c_z = CurveBetweenSlope(c, z);
  for (int d = 0; d < 2; d++) m->t[d] = foot->slope[d] / m->size;
  along = Dot(m->t, foot->bend);
  for (int d = 0; d < 2; d++) {
    m->v[d] = Sum(value, cell->x_t[0][d], rate[0][d], cell->x_t[1][d], rate[1][d]) + m->c * m->t[d];
    m->v_z[d] = Sum(slope, cell->x_t[0][d], rate[0][d], cell->x_t[1][d], rate[1][d]) +
                c_z * m->t[d] + m->c * (foot->bend[d] - m->t[d] * along) / m->size;
  }
}

static PetscReal FrictionOf(const Contact *contact, const Foot *foot) {
  return ContactWallFriction(contact, contact->walls.post[foot->post].wall);
}

/* f = a l (p n - mu p w t), t = n turned to the left */
static void Force(const Contact *contact, Foot *foot) {
  const PetscReal *n = foot->n, rub = FrictionOf(contact, foot) * foot->p * foot->w;
  foot->force[0] = foot->strength * (foot->p * n[0] + rub * n[1]);
  foot->force[1] = foot->strength * (foot->p * n[1] - rub * n[0]);
}

/* FootPush - what a post does to the rod at a foot that FeetFind() has found. dual: of its
   friction; NULL: nothing is held. */
void FootPush(const Contact *contact, const FootCell *cell, const FrictionDual *dual, Foot *foot) {
  const FrictionDual none = {.v = {0}};
  Motion m;

  foot->p = ContactPressure(contact, foot->gap, &foot->p_gap);
  foot->slip = foot->w = foot->w_slip = 0;
  if (FrictionOf(contact, foot) > 0 && cell->moves) {
    MotionOf(cell, foot, &m);
    foot->slip = foot->n[0] * m.v[1] - foot->n[1] * m.v[0];
    foot->w = ContactRub(contact, foot->slip, dual ? dual : &none, &foot->w_slip);
  }
  Force(contact, foot);
}

/* FootParts - the part that each point of a cell of length h has in a foot, and its derivative by
   z: of the parabola through all three; in order 2, where the ends have no weight, the middle has
   all.
 */
void FootParts(PetscReal h, const PetscReal weight[FOOT_PARTS], PetscReal z,
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

/* FootHandOut - adds to the load of a cell's points, n' = load, what the force of a foot is to
 * them.
 */
void FootHandOut(const FootCell *cell, const Foot *foot, FootLoad load) {
  PetscReal part[FOOT_ROWS], part_z[FOOT_ROWS];

  FootParts(cell->h, cell->weight, foot->z, part, part_z);
  for (int k = 0; k < FOOT_ROWS; k++)
    for (int d = 0; d < 2; d++) load[k][d] += part[k] * foot->force[d];
}

/* ---- derivatives ---- */

typedef PetscReal By[2][FOOT_UNKNOWNS];

/* The derivatives of x and x_z at a fixed z. */
static void PlaceBy(const FootCell *cell, PetscReal z, By x, By x_z) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(z, value, slope, bend);
  for (int d = 0; d < 2; d++)
    for (int e = 0; e < 2; e++) {
      const PetscReal turn = cell->h * cell->g[e] * (d ? cell->q[e][0] : -cell->q[e][1]);
      for (int c = 0; c < 2; c++) {
        x[d][3 * e + c] = c == d ? value[2 * e] : 0;
        x_z[d][3 * e + c] = c == d ? slope[2 * e] : 0;
      }
      x[d][3 * e + 2] = value[2 * e + 1] * turn;
      x_z[d][3 * e + 2] = slope[2 * e + 1] * turn;
    }
}

/* Those of the velocity at a fixed z; x, x_z  as PlaceBy() has them. */
static void MotionBy(const FootCell *cell, const Foot *foot, const Motion *m,
                     const PetscReal shift[3], By x, By x_z, By v) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(foot->z, value, slope, bend);
  for (int f = 0; f < FOOT_UNKNOWNS; f++) {
    const PetscReal turned = (m->t[0] * x_z[1][f] - m->t[1] * x_z[0][f]) / m->size;
    for (int d = 0; d < 2; d++)
      v[d][f] = shift[f % 3] * x[d][f] + m->c * (d ? m->t[0] : -m->t[1]) * turned;
  }
  for (int d = 0; d < 2; d++)
    for (int e = 0; e < 2; e++) {
      const PetscReal perp = d ? cell->q[e][0] : -cell->q[e][1];
      v[d][3 * e + 2] += value[2 * e + 1] * cell->h *
                         (cell->g_t[e] * perp - cell->g[e] * cell->theta_t[e] * cell->q[e][d]);
    }
}

/* How the foot, its normal, gap and slip change. */
typedef struct {
  PetscReal z[FOOT_UNKNOWNS], gap[FOOT_UNKNOWNS], slip[FOOT_UNKNOWNS];
  By n;
} Change;

/*
  With r = x - c:
    dz = -(x_z.dx + r.dx_z) / (x_z.x_z + r.x_zz),   dr = dx + x_z dz,   dgap = n.dr,
    dn = (dr - n dgap)/|r|,   dslip = t.(dv + v_z dz) + v.dt,   t and dt those of n turned to the
  left
*/
static void ChangeOf(const FootCell *cell, const Foot *foot, const PetscReal shift[3],
                     Change *change) {
  const PetscReal *n = foot->n, r[2] = {foot->distance * n[0], foot->distance * n[1]},
                  stiff = Dot(foot->slope, foot->slope) + Dot(r, foot->bend);
  By x, x_z, v = {{0}};
  Motion m = {.v = {0}};

  PlaceBy(cell, foot->z, x, x_z);
  if (cell->moves) {
    MotionOf(cell, foot, &m);
    MotionBy(cell, foot, &m, shift, x, x_z, v);
  }
  for (int f = 0; f < FOOT_UNKNOWNS; f++) {
    PetscReal dr[2], dz = 0, dv[2];
    if (!foot->ends)
      for (int d = 0; d < 2; d++) dz -= (foot->slope[d] * x[d][f] + r[d] * x_z[d][f]) / stiff;
    for (int d = 0; d < 2; d++) {
      dr[d] = x[d][f] + foot->slope[d] * dz;
      dv[d] = v[d][f] + m.v_z[d] * dz;
    }
    change->z[f] = dz;
    change->gap[f] = Dot(n, dr);
    for (int d = 0; d < 2; d++) change->n[d][f] = (dr[d] - n[d] * change->gap[f]) / foot->distance;
    change->slip[f] =
        n[0] * dv[1] - n[1] * dv[0] + change->n[0][f] * m.v[1] - change->n[1][f] * m.v[0];
  }
}

/*
  FootLinearise - adds to the derivatives of the load of a cell's points those of a foot that
  FootPush() has seen, the dual of its friction brought up to the slip first:
    df = a l (dp (n - mu w t) + p (dn - mu w dt) - mu p w' t dslip)

  shift   of the rates of x1, x2, theta      fresh  a Newton solve begins      dual  may be NULL
*/
void FootLinearise(const Contact *contact, const FootCell *cell, const PetscReal shift[3],
                   PetscBool fresh, FrictionDual *dual, Foot *foot, FootSlope slope) {
  const PetscReal mu = FrictionOf(contact, foot), *n = foot->n, t[2] = {-n[1], n[0]},
                  u[2] = {foot->slip, 0};
  PetscReal part[FOOT_ROWS], part_z[FOOT_ROWS];
  FrictionDual own = {.v = {0}};
  Change change;

  if (!dual) dual = &own;
  if (mu > 0 && cell->moves && foot->p > 0) {
    if (fresh)
      FrictionDualReset(&contact->rub, u, dual);
    else
      FrictionDualAdvance(&contact->rub, u, dual);
    foot->w = ContactRub(contact, foot->slip, dual, &foot->w_slip);
    Force(contact, foot);
  }
  ChangeOf(cell, foot, shift, &change);
  FootParts(cell->h, cell->weight, foot->z, part, part_z);
  for (int d = 0; d < 2; d++)
    for (int f = 0; f < FOOT_UNKNOWNS; f++) {
      const PetscReal dt = d ? change.n[0][f] : -change.n[1][f],
                      df = foot->p_gap * change.gap[f] * (n[d] - mu * foot->w * t[d]) +
                           foot->p * (change.n[d][f] - mu * foot->w * dt) -
                           mu * foot->p * foot->w_slip * t[d] * change.slip[f];
      for (int k = 0; k < FOOT_ROWS; k++)
        slope[k][d][f] += part[k] * foot->strength * df + part_z[k] * change.z[f] * foot->force[d];
    }
}
