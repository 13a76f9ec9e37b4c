#include "rod/feet_space.h"
#include "base/bezier.h"
#include "curve/cell.h"
#include "rod/rules.h"

/* ---- the curve ---- */

/* The sum of values at the ends and slopes there, by the polynomials. */
static inline PetscReal Sum(const PetscReal poly[4], PetscReal a, PetscReal a_z, PetscReal b,
                            PetscReal b_z) {
  return poly[0] * a + poly[1] * a_z + poly[2] * b + poly[3] * b_z;
}

static void PlaceOn(const FootCell3 *cell, Foot3 *foot) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(foot->z, value, slope, bend);
  for (int d = 0; d < 3; d++) {
    const PetscReal a = cell->x[0][d], a_z = cell->h * cell->g[0] * cell->q[0][d],
                    b = cell->x[1][d], b_z = cell->h * cell->g[1] * cell->q[1][d];
    foot->x[d] = Sum(value, a, a_z, b, b_z);
    foot->slope[d] = Sum(slope, a, a_z, b, b_z);
    foot->bend[d] = Sum(bend, a, a_z, b, b_z);
  }
}

/* w.H w */
static PetscReal Square(const PetscReal H[3][3], const PetscReal w[3]) {
  return w[0] * Dot3(H[0], w) + w[1] * Dot3(H[1], w) + w[2] * Dot3(H[2], w);
}

/* The second derivative of the distance by z: x_z.H x_z + n.x_zz. */
static PetscReal Stiff(const Foot3 *foot, const Touch3 *touch) {
  return Square(touch->bend, foot->slope) + Dot3(touch->normal, foot->bend);
}

/* ---- where it is nearest ---- */

/* Places at which a cell is asked whether it comes nearer or goes away, and intervals between. */
enum { ASKED = 4 };

/* A search under way. */
typedef struct {
  const Contact *contact;
  const FootCell3 *cell;
  PetscReal within, extent; /* extent: no place of the cell is farther from its middle */
  Feet3 *feet;
} Looking;

/* What an item is to the place z of a cell; false: nothing. */
static PetscBool LookFrom(const Looking *look, PetscInt item, Foot3 *foot, Touch3 *touch) {
  PlaceOn(look->cell, foot);
  return ContactRidgeTouch(look->contact, item, foot->x, PETSC_MAX_REAL, touch);
}

/* The root of n.x_z between two places, where it goes from below 0 to above: by Newton's method, or
   by halves where that leaves what is known to hold the root. */
static PetscBool Descend(const Looking *look, PetscInt item, PetscReal low, PetscReal high,
                         Foot3 *foot, Touch3 *touch) {

  foot->z = (low + high) / 2;
  for (int k = 0; k < rod_rule.nearest_iterations; k++) {
    PetscReal f, f_z, z;
    if (!LookFrom(look, item, foot, touch)) return PETSC_FALSE;
    f = Dot3(touch->normal, foot->slope);
    *(f > 0 ? &high : &low) = foot->z;
    f_z = Stiff(foot, touch);
    z = f_z > 0 ? foot->z - f / f_z : -1;
    if (!(z > low && z < high)) z = (low + high) / 2;
    if (PetscAbsReal(z - foot->z) < rod_rule.nearest_found || high - low < rod_rule.nearest_found)
      return PETSC_TRUE;
    foot->z = z;
  }
  return LookFrom(look, item, foot, touch);
}

/* rho, see feet_space.h; PETSC_MAX_REAL where what stands out does not along the rod. */
static PetscReal RhoOf(const Foot3 *foot, const Touch3 *touch) {
  const PetscReal along = Square(touch->bend, foot->slope);
  return along > 0 ? Dot3(foot->slope, foot->slope) / along - touch->gap : PETSC_MAX_REAL;
}

/* a l, its rate and its slope. Of an edge what is round beside it and narrow takes its share. */
static void StrengthOf(const Contact *contact, Foot3 *foot) {
  PetscReal share, share_t, round = 0, round_t = 0, beside, slope;

  (void)ContactRidgeSmallest(contact, foot->item, &beside);
  share = ContactPostShare(contact, foot->rho, &share_t);
  slope = ContactPostShareSlope(contact, foot->rho);
  if (beside < PETSC_MAX_REAL) round = ContactPostShare(contact, beside, &round_t);
  foot->strength = share * (1 - round) * contact->tip;
  foot->strength_rho = slope * (1 - round) * contact->tip;
  foot->strength_t = share * (1 - round) * contact->tip_t +
                     (share_t * (1 - round) - share * round_t) * contact->tip;
}

/* Makes room for a foot of this gap by dropping the farthest, for what is looked for as the nearest
   may be far, and many; false: it is farther itself. */
static PetscBool MakeRoom(Feet3 *feet, PetscReal gap) {
  PetscInt far = 0;

  if (feet->n < MOST_FEET) return PETSC_TRUE;
  for (PetscInt k = 1; k < feet->n; k++)
    if (feet->touch[k].gap > feet->touch[far].gap) far = k;
  if (gap >= feet->touch[far].gap) return PETSC_FALSE;
  feet->n--;
  for (PetscInt k = far; k < feet->n; k++) {
    feet->foot[k] = feet->foot[k + 1];
    feet->touch[k] = feet->touch[k + 1];
  }
  return PETSC_TRUE;
}

/* Takes note of a foot, in the order of items and, of one item, along the rod. */
static void Take(Looking *look, Foot3 *foot, const Touch3 *touch) {
  Feet3 *feet = look->feet;
  PetscInt k;

  foot->rho = RhoOf(foot, touch);
  StrengthOf(look->contact, foot);
  if (touch->gap >= look->within || foot->strength == 0 || !MakeRoom(feet, touch->gap)) return;
  k = feet->n++;
  for (; k > 0 && (feet->foot[k - 1].item > foot->item ||
                   (feet->foot[k - 1].item == foot->item && feet->foot[k - 1].z > foot->z));
       k--) {
    feet->foot[k] = feet->foot[k - 1];
    feet->touch[k] = feet->touch[k - 1];
  }
  feet->foot[k] = *foot;
  feet->touch[k] = *touch;
}

/* Is the cell too far from an item, or that too wide for the cells? */
static PetscBool IsOff(const Looking *look, PetscInt item) {
  Foot3 foot = {.z = 0.5};
  PetscReal beside, rate;
  Touch3 touch;

  if (ContactPostShare(look->contact, ContactRidgeSmallest(look->contact, item, &beside), &rate) ==
      0)
    return PETSC_TRUE;
  PlaceOn(look->cell, &foot);
  return (PetscBool)!ContactRidgeTouch(look->contact, item, foot.x, look->within + look->extent,
                                       &touch);
}

/* An end of the rod, if it is nearer than what is beside it. */
static void TakeEnd(Looking *look, PetscInt item, PetscReal z) {
  Foot3 foot = {.item = item, .ends = PETSC_TRUE, .z = z};
  Touch3 touch;

  if (LookFrom(look, item, &foot, &touch)) Take(look, &foot, &touch);
}

/* (A cell asks by the directions of its nodes: so of two cells one has what is at the node
 * between.)
 */
static PetscReal Meet(PetscInt item, PetscReal reach, void *ctx) {
  Looking *look = (Looking *)ctx;
  const FootCell3 *cell = look->cell;
  PetscReal lean[ASKED + 1];
  PetscBool seen[ASKED + 1];

  if (IsOff(look, item)) return reach;
  for (int k = 0; k <= ASKED; k++) {
    Foot3 foot = {.z = (PetscReal)k / ASKED};
    Touch3 touch;
    seen[k] = LookFrom(look, item, &foot, &touch);
    if (seen[k])
      lean[k] = Dot3(touch.normal, k == 0 ? cell->q[0] : k == ASKED ? cell->q[1] : foot.slope);
  }
  if (cell->first && seen[0] && lean[0] > 0) TakeEnd(look, item, 0);
  for (int k = 0; k < ASKED; k++) {
    Foot3 foot = {.item = item};
    Touch3 touch;
    if (seen[k] && seen[k + 1] && lean[k] <= 0 && lean[k + 1] > 0 &&
        Descend(look, item, (PetscReal)k / ASKED, (PetscReal)(k + 1) / ASKED, &foot, &touch))
      Take(look, &foot, &touch);
  }
  if (cell->last && seen[ASKED] && lean[ASKED] <= 0) TakeEnd(look, item, 1);
  return reach;
}

/* The points that hold a cell's curve. */
static PetscReal Hull(const FootCell3 *cell, PetscReal b[4][3]) {
  Foot3 middle = {.z = 0.5};
  PetscReal extent = 0;

  BezierOfCell(3, cell->h, cell->g, cell->x[0], cell->q[0], b[0]);
  PlaceOn(cell, &middle);
  for (int k = 0; k < 4; k++) {
    const PetscReal o[3] = {b[k][0] - middle.x[0], b[k][1] - middle.x[1], b[k][2] - middle.x[2]};
    extent = PetscMax(extent, PetscSqrtReal(Dot3(o, o)));
  }
  return extent;
}

/* FeetFind3 - the feet of a cell on what is to be met so, with a gap below `within`. MOST_FEET:
   there may be more. */
void FeetFind3(const Contact *contact, const FootCell3 *cell, PetscReal within, Feet3 *feet) {
  Looking look = {.contact = contact, .cell = cell, .within = within, .feet = feet};
  PetscReal b[4][3];

  feet->n = 0;
  if (!contact->thin) return;
  look.extent = Hull(cell, b);
  ContactRidgesNear(contact, b, contact->diameter / 2 + PetscMax(0, within), Meet, &look);
  for (PetscInt k = 1; k < feet->n; k++)
    feet->touch[k].again = (PetscBool)(feet->touch[k].wall == feet->touch[k - 1].wall);
}

/* ---- forces ---- */

/* How fast the velocity and the spin change along the cell; the size of x_z. */
typedef struct {
  PetscReal v_z[3], t_z[3], spin_z, size, c;
} Motion;

/* v = x_t + c t, the spin even between the ends. */
static void MotionOf(const FootCell3 *cell, Foot3 *foot, Motion *m) {
  const PetscReal z = foot->z, *c = cell->c;
  PetscReal value[4], slope[4], bend[4], c_z, along;

  Hermite(z, value, slope, bend);
  m->size = PetscSqrtReal(Dot3(foot->slope, foot->slope));
  m->c = CurveBetween(c, z);
  c_z = CurveBetweenSlope(c, z);
  m->spin_z = cell->spin[1] - cell->spin[0];
  foot->spin = cell->spin[0] + z * m->spin_z;
  for (int d = 0; d < 3; d++) foot->t[d] = foot->slope[d] / m->size;
  along = Dot3(foot->t, foot->bend);
  for (int d = 0; d < 3; d++) {
    const PetscReal a = cell->x_t[0][d], a_z = cell->h * cell->slope_t[0][d], b = cell->x_t[1][d],
                    b_z = cell->h * cell->slope_t[1][d];
    m->t_z[d] = (foot->bend[d] - foot->t[d] * along) / m->size;
    foot->v[d] = Sum(value, a, a_z, b, b_z) + m->c * foot->t[d];
    m->v_z[d] = Sum(slope, a, a_z, b, b_z) + c_z * foot->t[d] + m->c * m->t_z[d];
    if (!cell->moves) foot->v[d] = 0;
  }
  if (!cell->moves) foot->spin = 0;
}

static Rubbed RubbedOf(const Foot3 *foot) {
  return (Rubbed){foot->x, foot->t, foot->v, foot->spin};
}

/* FeetPush3 - what walls do to the rod at the feet that FeetFind3() has found. slots: of their
   friction; NULL: nothing is held. */
void FeetPush3(const Contact *contact, const FootCell3 *cell, const FrictionDual4 slots[],
               Feet3 *feet) {
  for (PetscInt k = 0; k < feet->n; k++) {
    Foot3 *foot = &feet->foot[k];
    Rubbed at;
    Push3 push;
    Motion m;
    MotionOf(cell, foot, &m);
    at = RubbedOf(foot);
    ContactPush3(contact, &feet->touch[k], &at, slots, &push);
    for (int d = 0; d < 3; d++) foot->force[d] = foot->strength * push.force[d];
    foot->couple = foot->strength * push.couple;
    foot->normal = foot->strength * push.normal;
    foot->power = foot->strength * push.power;
  }
}

/* FeetHandOut3 - adds to the load of a cell's points, n' and m' = load, what the feet are to them.
 */
void FeetHandOut3(const FootCell3 *cell, const Feet3 *feet, FootLoad3 load) {
  for (PetscInt j = 0; j < feet->n; j++) {
    const Foot3 *foot = &feet->foot[j];
    PetscReal part[FOOT_ROWS], part_z[FOOT_ROWS];
    FootParts(cell->h, cell->weight, foot->z, part, part_z);
    for (int k = 0; k < FOOT_ROWS; k++)
      for (int d = 0; d < 3; d++) {
        load[k][d] += part[k] * foot->force[d];
        load[k][3 + d] += part[k] * foot->couple * foot->t[d];
      }
  }
}

/* ---- derivatives ---- */

typedef PetscReal By[3][FOOT3_UNKNOWNS];

/* The derivatives at a fixed z: of x, x_z, of the tangent, the velocity and the spin. */
typedef struct {
  By x, slope, t, v;
  PetscReal spin[FOOT3_UNKNOWNS];
} Fixed;

static void FixedBy(const FootCell3 *cell, const FootEnd3 end[2], const Foot3 *foot,
                    const Motion *m, Fixed *by) {
  PetscReal value[4], slope[4], bend[4];

  Hermite(foot->z, value, slope, bend);
  for (int e = 0; e < 2; e++)
    for (int f = 0; f < FOOT3_NODE; f++) {
      const int u = FOOT3_NODE * e + f;
      const PetscReal to = cell->h * value[2 * e + 1], to_slope = cell->h * slope[2 * e + 1];
      PetscReal along = 0;
      for (int d = 0; d < 3; d++) {
        by->x[d][u] = by->slope[d][u] = by->v[d][u] = 0;
        if (f == d) {
          by->x[d][u] = value[2 * e];
          by->slope[d][u] = slope[2 * e];
          by->v[d][u] = end[e].shift[d] * value[2 * e];
        } else if (f >= 3 && f < 7) {
          by->x[d][u] = to * cell->g[e] * end[e].q[d][f - 3];
          by->slope[d][u] = to_slope * cell->g[e] * end[e].q[d][f - 3];
          by->v[d][u] = to * end[e].slope_t[d][f - 3];
        }
        along += foot->t[d] * by->slope[d][u];
      }
      for (int d = 0; d < 3; d++) {
        by->t[d][u] = (by->slope[d][u] - foot->t[d] * along) / m->size;
        by->v[d][u] += m->c * by->t[d][u];
      }
      by->spin[u] = (e ? foot->z : 1 - foot->z) * end[e].spin[f];
    }
}

/* The derivative of x_z.H x_z by x, x_z held: by differences, for surfaces tell no third
   derivatives. Only where a share is between 0 and 1. */
static void SquareBy(const Contact *contact, const Foot3 *foot, const Touch3 *touch,
                     PetscReal by[3]) {
  const PetscReal e = 1e-5 * (foot->rho + touch->gap);

  for (int d = 0; d < 3; d++) {
    PetscReal square[2] = {0, 0};
    for (int side = 0; side < 2; side++) {
      PetscReal x[3] = {foot->x[0], foot->x[1], foot->x[2]};
      Touch3 there;
      x[d] += side ? e : -e;
      if (ContactRidgeTouch(contact, foot->item, x, PETSC_MAX_REAL, &there))
        square[side] = Square(there.bend, foot->slope);
    }
    by[d] = (square[1] - square[0]) / (2 * e);
  }
}

/* How rho changes as x and x_z do; square_by as SquareBy() has it. */
static PetscReal RhoBy(const Foot3 *foot, const Touch3 *touch, const PetscReal square_by[3],
                       const PetscReal dx[3], const PetscReal dslope[3]) {
  const PetscReal *w = foot->slope, along = Square(touch->bend, w), size = Dot3(w, w);
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
static void ChangeOf(const Foot3 *foot, const Touch3 *touch, const Motion *m, const Fixed *by,
                     int u, Change *change) {
  PetscReal z = 0;

  for (int d = 0; d < 3 && !foot->ends; d++)
    z -= (Dot3(touch->bend[d], foot->slope) * by->x[d][u] + touch->normal[d] * by->slope[d][u]) /
         Stiff(foot, touch);
  change->z = z;
  for (int d = 0; d < 3; d++) {
    change->x[d] = by->x[d][u] + foot->slope[d] * z;
    change->slope[d] = by->slope[d][u] + foot->bend[d] * z;
    change->t[d] = by->t[d][u] + m->t_z[d] * z;
    change->v[d] = by->v[d][u] + m->v_z[d] * z;
  }
  change->spin = by->spin[u] + m->spin_z * z;
}

/* ... and its force and, as a vector along the tangent, its couple; more: by how much of itself the
   strength changes. */
static void LoadChange(const Foot3 *foot, const Push3 *push, const Change *change, PetscReal more,
                       PetscReal dF[FOOT3_LOAD]) {
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
static void LineariseOne(const Contact *contact, const FootCell3 *cell, const FootEnd3 end[2],
                         const Push3 *push, const Touch3 *touch, Foot3 *foot, FootSlope3 slope) {
  PetscReal part[FOOT_ROWS], part_z[FOOT_ROWS], square_by[3] = {0}, dF[FOOT3_LOAD];
  Motion m;
  Fixed by;

  MotionOf(cell, foot, &m);
  FixedBy(cell, end, foot, &m, &by);
  FootParts(cell->h, cell->weight, foot->z, part, part_z);
  if (foot->strength_rho != 0) SquareBy(contact, foot, touch, square_by);
  for (int u = 0; u < FOOT3_UNKNOWNS; u++) {
    PetscReal more = 0;
    Change change;
    ChangeOf(foot, touch, &m, &by, u, &change);
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
  FeetLinearise3 - adds to the derivatives of the load of a cell's points those of feet that
  FeetPush3() has seen, the duals of their friction brought up to the slip first.

  end    how the ends of the cell change      fresh  a Newton solve begins      slots  may be NULL
*/
void FeetLinearise3(const Contact *contact, const FootCell3 *cell, const FootEnd3 end[2],
                    PetscBool fresh, FrictionDual4 slots[], Feet3 *feet, FootSlope3 slope) {
  if (slots) ContactSlots(feet->n, feet->touch, slots);
  for (PetscInt k = 0; k < feet->n; k++) {
    const Rubbed at = RubbedOf(&feet->foot[k]);
    const Touch3 *touch = &feet->touch[k];
    Push3 push;
    ContactPushSlope3(contact, touch, &at, fresh, ContactSlot(touch, slots), &push);
    LineariseOne(contact, cell, end, &push, touch, &feet->foot[k], slope);
  }
}

/* FeetHold3 - moves what holds feet that stick (exact Coulomb friction); returns the speed at which
   they creep. */
PetscReal FeetHold3(const Contact *contact, Feet3 *feet, PetscReal seen, FrictionDual4 slots[]) {
  PetscReal creep = 0;

  ContactSlots(feet->n, feet->touch, slots);
  for (PetscInt k = 0; k < feet->n; k++) {
    const Rubbed at = RubbedOf(&feet->foot[k]);
    creep = LargerOf(creep,
                     ContactHoldTouch3(contact, &feet->touch[k], &at, seen, friction_hold, slots));
  }
  return creep;
}

/* FootShareRate3 - the rate of a foot's strength as the rod turns against what it meets, which
   rests; of what moves that is not known, and 0. */
PetscReal FootShareRate3(const Contact *contact, const FootCell3 *cell, const Feet3 *feet,
                         PetscInt k) {
  const Foot3 *foot = &feet->foot[k];
  const Touch3 *touch = &feet->touch[k];
  PetscReal value[4], slope[4], bend[4], x_t[3], slope_t[3], square_by[3], Hw[3], z_t = 0;

  if (foot->strength_rho == 0 || touch->moves || !cell->moves) return 0;
  Hermite(foot->z, value, slope, bend);
  for (int d = 0; d < 3; d++) {
    const PetscReal a = cell->x_t[0][d], a_z = cell->h * cell->slope_t[0][d], b = cell->x_t[1][d],
                    b_z = cell->h * cell->slope_t[1][d];
    x_t[d] = Sum(value, a, a_z, b, b_z);
    slope_t[d] = Sum(slope, a, a_z, b, b_z);
    Hw[d] = Dot3(touch->bend[d], foot->slope);
  }
  if (!foot->ends) z_t = -(Dot3(Hw, x_t) + Dot3(touch->normal, slope_t)) / Stiff(foot, touch);
  for (int d = 0; d < 3; d++) {
    x_t[d] += foot->slope[d] * z_t;
    slope_t[d] += foot->bend[d] * z_t;
  }
  SquareBy(contact, foot, touch, square_by);
  return foot->strength_rho * RhoBy(foot, touch, square_by, x_t, slope_t);
}
