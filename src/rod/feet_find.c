/* Where feet are. */
#include "rod/feet.h"
#include "rod/rules.h"

/* A search under way. */
typedef struct {
  const Contact *contact;
  const FootCell *cell;
  PetscReal within, extent; /* extent, in space: no place of the cell is farther from its middle */
  Feet *feet;
} Looking;

/* Makes room for a foot of this gap by dropping the farthest, for what is looked for as the nearest
   may be far, and many; false: it is farther itself. */
static PetscBool MakeRoom(Feet *feet, PetscReal gap) {
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
static void Take(Looking *look, Foot *foot, const Touch *touch) {
  Feet *feet = look->feet;
  PetscInt k;

  if (touch->gap >= look->within || foot->strength == 0 || !MakeRoom(feet, touch->gap)) return;
  k = feet->n++;
  for (; k > 0 && (feet->foot[k - 1].item > foot->item ||
                   (feet->foot[k - 1].item == foot->item && feet->foot[k - 1].on.z > foot->on.z));
       k--) {
    feet->foot[k] = feet->foot[k - 1];
    feet->touch[k] = feet->touch[k - 1];
  }
  feet->foot[k] = *foot;
  feet->touch[k] = *touch;
}

/* ---- on posts, in the plane ---- */

/* (x - c).x_z at a foot */
static PetscReal Lean(const CurvePlace *on, Vector2 c) {
  return Dot2(Minus2(From2(on->x), c), From2(on->slope));
}

/* The root of (x - c).x_z between 0 and 1, where it goes from below 0 to above: by Newton's method,
   or by halves where that leaves what is known to hold the root. */
static void DescendToPost(const FootCell *cell, Vector2 c, Foot *foot) {
  PetscReal low = 0, high = 1;
  CurvePlace *on = &foot->on;

  on->z = 0.5;
  for (int k = 0; k < rod_rule.nearest_iterations; k++) {
    PetscReal f, f_z, z, o[3] = {0};
    CurvePlaceAt(&cell->curve, on);
    f = Lean(on, c);
    *(f > 0 ? &high : &low) = on->z;
    Put2(Minus2(From2(on->x), c), o);
    f_z = Dot3(on->slope, on->slope) + Dot3(o, on->bend);
    z = f_z > 0 ? on->z - f / f_z : -1;
    if (!(z > low && z < high)) z = (low + high) / 2;
    if (PetscAbsReal(z - on->z) < rod_rule.nearest_found || high - low < rod_rule.nearest_found)
      return;
    on->z = z;
  }
  CurvePlaceAt(&cell->curve, on);
}

/* FootAbout - is the curve of a cell in the plane nearest to c within the cell, or at its end if
   that is the rod's? (A cell asks by the directions of its nodes: so of two cells one has it.)
   Where: on, ends. */
PetscBool FootAbout(const FootCell *cell, Vector2 c, Foot *foot) {
  const CurveCell *curve = &cell->curve;
  const PetscReal begin = Dot2(Minus2(From2(curve->x[0]), c), From2(curve->q[0])),
                  end = Dot2(Minus2(From2(curve->x[1]), c), From2(curve->q[1]));

  foot->ends = PETSC_TRUE;
  if (cell->first && begin > 0)
    foot->on.z = 0;
  else if (cell->last && end <= 0)
    foot->on.z = 1;
  else if (begin <= 0 && end > 0) {
    foot->ends = PETSC_FALSE;
    DescendToPost(cell, c, foot);
    return PETSC_TRUE;
  } else
    return PETSC_FALSE;
  CurvePlaceAt(&cell->curve, &foot->on);
  return PETSC_TRUE;
}

/* What a post is to a foot: false, the foot is in its middle. */
static PetscBool TouchPost(const Contact *contact, PetscInt item, const Foot *foot, Touch *touch) {
  const Walls *walls = &contact->walls;
  const WallPost *post = &walls->post[item];
  const Vector2 way = Minus2(From2(foot->on.x), WallsPostAt(walls, item, walls->time));
  const PetscReal distance = Size2(way);

  *touch = (Touch){.gap = distance - post->r - contact->diameter / 2,
                   .steep = 1,
                   .wall = post->wall,
                   .friction = ContactWallFriction(contact, post->wall)};
  if (distance == 0) return PETSC_FALSE;
  Put2(Over2(way, distance), touch->normal);
  touch->moves = (PetscBool)(item >= walls->resting);
  if (touch->moves) {
    const Vector2 on = Along2(From2(foot->on.x), post->r - distance, From2(touch->normal));
    PetscReal spin;
    Put2(WallVelocity(walls, post->wall, on, &spin), touch->v);
  }
  for (int d = 0; d < 2; d++)
    for (int c = 0; c < 2; c++)
      touch->bend[d][c] = ((d == c) - touch->normal[d] * touch->normal[c]) / distance;
  touch->curvature = touch->bend[0][0] + touch->bend[1][1];
  return PETSC_TRUE;
}

static PetscReal MeetPost(PetscInt item, PetscReal reach, void *ctx) {
  Looking *look = (Looking *)ctx;
  const Contact *contact = look->contact;
  const WallPost *post = &contact->walls.post[item];
  PetscReal share_t, share = ContactPostShare(contact, post->r + contact->diameter / 2, &share_t);
  Foot foot = {.item = item};
  Touch touch;

  if (share == 0 ||
      !FootAbout(look->cell, WallsPostAt(&contact->walls, item, contact->walls.time), &foot) ||
      !TouchPost(contact, item, &foot, &touch))
    return reach;
  foot.strength = share * contact->tip;
  foot.strength_t = share * contact->tip_t + share_t * contact->tip;
  Take(look, &foot, &touch);
  return reach;
}

/* What holds a cell's curve in the plane: the four points of its Bezier polygon. */
static Block CellBlock(const FootCell *cell) {
  Block block = BlockEmpty(2);
  PetscReal b[4][2];

  CurveBezier(2, &cell->curve, b[0]);
  for (int k = 0; k < 4; k++) BlockHold(2, &block, b[k]);
  return block;
}

/* ---- on what stands out in space ---- */

/* Places at which a cell is asked whether it comes nearer or goes away, and intervals between. */
enum { ASKED = 4 };

/* What an item is to the place z of a cell; false: nothing. */
static PetscBool LookFrom(const Looking *look, PetscInt item, Foot *foot, Touch *touch) {
  CurvePlaceAt(&look->cell->curve, &foot->on);
  return ContactRidgeTouch(look->contact, item, foot->on.x, PETSC_MAX_REAL, touch);
}

/* The root of n.x_z between two places, where it goes from below 0 to above: by Newton's method, or
   by halves where that leaves what is known to hold the root. */
static PetscBool Descend(const Looking *look, PetscInt item, PetscReal low, PetscReal high,
                         Foot *foot, Touch *touch) {

  foot->on.z = (low + high) / 2;
  for (int k = 0; k < rod_rule.nearest_iterations; k++) {
    PetscReal f, f_z, z;
    if (!LookFrom(look, item, foot, touch)) return PETSC_FALSE;
    f = Dot3(touch->normal, foot->on.slope);
    *(f > 0 ? &high : &low) = foot->on.z;
    f_z = FootStiff(foot, touch);
    z = f_z > 0 ? foot->on.z - f / f_z : -1;
    if (!(z > low && z < high)) z = (low + high) / 2;
    if (PetscAbsReal(z - foot->on.z) < rod_rule.nearest_found ||
        high - low < rod_rule.nearest_found)
      return PETSC_TRUE;
    foot->on.z = z;
  }
  return LookFrom(look, item, foot, touch);
}

/* rho, see feet.h; PETSC_MAX_REAL where what stands out does not along the rod. */
static PetscReal RhoOf(const Foot *foot, const Touch *touch) {
  const PetscReal along = FootSquare(touch->bend, foot->on.slope);
  return along > 0 ? Dot3(foot->on.slope, foot->on.slope) / along - touch->gap : PETSC_MAX_REAL;
}

/* a l, its rate and its slope. Of an edge what is round beside it and narrow takes its share. */
static void StrengthOf(const Contact *contact, Foot *foot) {
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

static void TakeRidge(Looking *look, Foot *foot, const Touch *touch) {
  foot->rho = RhoOf(foot, touch);
  StrengthOf(look->contact, foot);
  Take(look, foot, touch);
}

/* Is the cell too far from an item, or that too wide for the cells? */
static PetscBool IsOff(const Looking *look, PetscInt item) {
  Foot foot = {.on = {.z = 0.5}};
  PetscReal beside, rate;
  Touch touch;

  if (ContactPostShare(look->contact, ContactRidgeSmallest(look->contact, item, &beside), &rate) ==
      0)
    return PETSC_TRUE;
  CurvePlaceAt(&look->cell->curve, &foot.on);
  return (PetscBool)!ContactRidgeTouch(look->contact, item, foot.on.x, look->within + look->extent,
                                       &touch);
}

/* An end of the rod, if it is nearer than what is beside it. */
static void TakeEnd(Looking *look, PetscInt item, PetscReal z) {
  Foot foot = {.item = item, .ends = PETSC_TRUE, .on = {.z = z}};
  Touch touch;

  if (LookFrom(look, item, &foot, &touch)) TakeRidge(look, &foot, &touch);
}

/* (A cell asks by the directions of its nodes: so of two cells one has what is at the node
 * between.)
 */
static PetscReal MeetRidge(PetscInt item, PetscReal reach, void *ctx) {
  Looking *look = (Looking *)ctx;
  const FootCell *cell = look->cell;
  PetscReal lean[ASKED + 1];
  PetscBool seen[ASKED + 1];

  if (IsOff(look, item)) return reach;
  for (int k = 0; k <= ASKED; k++) {
    Foot foot = {.on = {.z = (PetscReal)k / ASKED}};
    Touch touch;
    seen[k] = LookFrom(look, item, &foot, &touch);
    if (seen[k])
      lean[k] = Dot3(touch.normal, k == 0       ? cell->curve.q[0]
                                   : k == ASKED ? cell->curve.q[1]
                                                : foot.on.slope);
  }
  if (cell->first && seen[0] && lean[0] > 0) TakeEnd(look, item, 0);
  for (int k = 0; k < ASKED; k++) {
    Foot foot = {.item = item};
    Touch touch;
    if (seen[k] && seen[k + 1] && lean[k] <= 0 && lean[k + 1] > 0 &&
        Descend(look, item, (PetscReal)k / ASKED, (PetscReal)(k + 1) / ASKED, &foot, &touch))
      TakeRidge(look, &foot, &touch);
  }
  if (cell->last && seen[ASKED] && lean[ASKED] <= 0) TakeEnd(look, item, 1);
  return reach;
}

/* The points that hold a cell's curve. */
static PetscReal Hull(const CurveCell *curve, PetscReal b[4][3]) {
  CurvePlace middle = {.z = 0.5};
  PetscReal extent = 0;

  CurveBezier(3, curve, b[0]);
  CurvePlaceAt(curve, &middle);
  for (int k = 0; k < 4; k++) {
    PetscReal o[3];
    Minus3(b[k], middle.x, o);
    extent = PetscMax(extent, Size3(o));
  }
  return extent;
}

/* FeetFind - the feet of a cell on what is to be met so, with a gap below `within`. MOST_FEET:
   there may be more. */
void FeetFind(const Contact *contact, const FootCell *cell, PetscReal within, Feet *feet) {
  const PetscReal reach = contact->diameter / 2 + PetscMax(0, within);
  Looking look = {.contact = contact, .cell = cell, .within = within, .feet = feet};

  feet->n = 0;
  if (!contact->thin) return;
  if (cell->dims == 2) {
    const Block block = CellBlock(cell);
    WallsPostsNear(&contact->walls, &block, reach, MeetPost, &look);
  } else {
    PetscReal b[4][3];
    look.extent = Hull(&cell->curve, b);
    ContactRidgesNear(contact, b, reach, MeetRidge, &look);
    for (PetscInt k = 1; k < feet->n; k++)
      feet->touch[k].again = (PetscBool)(feet->touch[k].wall == feet->touch[k - 1].wall);
  }
}
