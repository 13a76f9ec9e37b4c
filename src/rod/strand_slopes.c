/* The derivatives of what strands do to each other. The dimension is a constant of each call. */
#include "base/clones.h"
#include "rod/strand_pairs.h"

/* The derivatives of a place at fixed z, and of x_z. */
ALWAYS_INLINE void SpotBy(int dims, const struct _Strands *self, const Spot *spot, CurveBy x,
                          CurveBy slope) {
  const Joint *joint = self->joint + spot->cell;
  const CurveEnd *end[] = {&joint[0].by, &joint[1].by};
  CurveCell cell;

  StrandCell(self, spot->cell, &cell);
  CurvePlaceBy(dims, NodeOf(dims), &cell, end, spot->on.z, x, slope);
}

/*
  With r = x - y the way from the foot to the sample, y_z and y_zz at the foot:
    dz = (y_z.(dx - dy) + r.dy_z) / (y_z.y_z - r.y_zz),    dr = dx - dy - y_z dz,
    dgap = n.dr,    dn = (dr - n dgap)/|r|.
*/
ALWAYS_INLINE void PlaceSlope(int dims, const struct _Strands *self, const Pair *pair,
                              PairSlope *by) {
  const int of_cell = 2 * NodeOf(dims);
  const PetscReal *slope = pair->foot.on.slope, *n = pair->n;
  PetscReal r[3], stiff;
  CurveBy x, y, y_z, skip;

  for (int d = 0; d < 3; d++) r[d] = pair->distance * n[d];
  stiff = Dot3(slope, slope) - Dot3(r, pair->foot.on.bend);
  SpotBy(dims, self, &pair->at, x, skip);
  SpotBy(dims, self, &pair->foot, y, y_z);
  for (int f = 0; f < 2 * of_cell; f++) {
    const PetscBool of_foot = (PetscBool)(f >= of_cell);
    const int g = f % of_cell;
    PetscReal dr[3] = {0};
    for (int d = 0; d < dims; d++) dr[d] = of_foot ? -y[d][g] : x[d][g];
    by->z[f] = 0;
    if (!pair->ends) {
      PetscReal turned = 0;
      for (int d = 0; d < dims && of_foot; d++) turned += r[d] * y_z[d][g];
      by->z[f] = (Dot3(slope, dr) + turned) / stiff;
    }
    for (int d = 0; d < dims; d++) dr[d] -= slope[d] * by->z[f];
    by->gap[f] = Dot3(n, dr);
    for (int d = 0; d < dims; d++) by->n[d][f] = (dr[d] - n[d] * by->gap[f]) / pair->distance;
  }
}

/* df = dp (n - mu w) + p (dn - mu dw) */
ALWAYS_INLINE void ForceSlope(int dims, const struct _Strands *self, const Pair *pair,
                              const PairSlope *by, StrandBy df) {
  const PetscReal mu = pair->contact->friction;

  for (int d = 0; d < dims; d++)
    for (int u = 0; u < 4 * NodeOf(dims); u++)
      df[d][u] = pair->p_gap * by->gap[u] * (pair->n[d] - mu * pair->w[d]) +
                 pair->p * (by->n[d][u] - mu * by->w[d][u]);
}

/* What the points take that a force, or a couple, on the foot goes to, and behind them those of the
   sample, as load per label: its derivatives. on[0], by[0] of what is on the sample, 1 of the foot.
   Returns how many they are. */
ALWAYS_INLINE int TakersBy(int dims, const struct _Strands *self, const Pair *pair,
                           const PetscReal z[], const PetscReal on_foot[3], StrandBy by[2],
                           PetscInt taker[STRAND_TAKERS], StrandBy load[STRAND_TAKERS]) {
  const int unknowns = 4 * NodeOf(dims);
  PetscReal share[2];
  Spread spread;
  int n = 0, of;

  PairShares(self, pair, share);
  of = PairSpread(self, pair, 1, &spread);
  for (int k = 0; k < of; k++, n++) {
    const PetscReal all = share[0] + share[1];
    taker[n] = spread.point[k];
    for (int d = 0; d < dims; d++)
      for (int u = 0; u < unknowns; u++)
        load[n][d][u] = -all *
                        (by[1][d][u] * spread.share[k] + on_foot[d] * spread.share_z[k] * z[u]) /
                        self->weight[spread.point[k]];
  }
  of = PairSpread(self, pair, 0, &spread);
  for (int k = 0; k < of; k++, n++) {
    taker[n] = spread.point[k];
    for (int d = 0; d < dims; d++)
      for (int u = 0; u < unknowns; u++)
        load[n][d][u] = -share[0] * spread.share[k] * by[0][d][u] / self->weight[spread.point[k]];
  }
  if (share[1] == 0) return n;
  taker[n] = TipPoint(StrandOf(self, pair->at.cell));
  for (int d = 0; d < dims; d++)
    for (int u = 0; u < unknowns; u++) load[n][d][u] = share[1] * by[0][d][u];
  return n + 1;
}

/* d(a.f t) = (da.f + a.df) t + a.f dt */
static void CouplesSlope(const struct _Strands *self, const Pair *pair, const PairSlope *by,
                         const PetscReal f[3], StrandBy df, StrandSlope *slope) {
  PetscInt taker[STRAND_TAKERS];
  PetscReal on_foot[3];
  StrandBy dl[2];

  for (int which = 0; which < 2; which++) {
    const Turning *turning = &pair->turning[which];
    const PetscReal about = Dot3(turning->a, f);
    for (int d = 0; d < 3; d++) on_foot[d] = about * turning->t[d];
    for (int u = 0; u < STRAND_UNKNOWNS; u++) {
      PetscReal more = 0;
      for (int d = 0; d < 3; d++) more += by->a[which][d][u] * f[d] + turning->a[d] * df[d][u];
      for (int d = 0; d < 3; d++)
        dl[which][d][u] = more * turning->t[d] + about * by->t[which][d][u];
    }
  }
  (void)TakersBy(3, self, pair, by->z, on_foot, dl, taker, slope->couple_by);
}

/* The derivatives of what each taker takes. */
ALWAYS_INLINE void TakersSlope(int dims, const struct _Strands *self, const Pair *pair,
                               const PairSlope *by, StrandSlope *slope) {
  PetscReal f[3], on_foot[3];
  StrandBy df[2];

  PairForce(self, pair, f);
  ForceSlope(dims, self, pair, by, df[0]);
  for (int d = 0; d < dims; d++) {
    on_foot[d] = -f[d];
    for (int u = 0; u < 4 * NodeOf(dims); u++) df[1][d][u] = -df[0][d][u];
  }
  for (int u = 0; u < 4 * NodeOf(dims) && PairOnClamp(self, pair); u++) {
    const PetscReal *axis = StrandOf(self, pair->foot.cell)->axis,
                    borne = pair->p_gap * by->gap[u] * Dot3(pair->n, axis) +
                            pair->p * ColumnDot3(by->n[0], STRAND_UNKNOWNS, u, axis);
    for (int d = 0; d < dims; d++) df[1][d][u] += borne * axis[d];
  }
  slope->cell[0] = pair->at.cell;
  slope->cell[1] = pair->foot.cell;
  slope->takers = TakersBy(dims, self, pair, by->z, on_foot, df, slope->taker, slope->by);
  slope->couples = (PetscBool)(self->couple != NULL);
  if (self->couple) CouplesSlope(self, pair, by, f, df[0], slope);
}

/* Of one pair. */
ALWAYS_INLINE void Linearise(int dims, const struct _Strands *self, Pair *pair, PetscBool fresh,
                             StrandSlope *slope) {
  PairSlope by = {.z = {0}};

  PlaceSlope(dims, self, pair, &by);
  if (pair->contact->friction > 0) PairRubSlope(self, pair, fresh, &by);
  TakersSlope(dims, self, pair, &by, slope);
}

static void LineariseInPlane(Strands self, Pair *pair, PetscBool fresh, StrandSlope *slope) {
  Linearise(2, self, pair, fresh, slope);
}

static void LineariseInSpace(Strands self, Pair *pair, PetscBool fresh, StrandSlope *slope) {
  Linearise(3, self, pair, fresh, slope);
}

/*
  StrandsLinearise - the derivatives of the forces that StrandsLoad() found in the same state. Not
  collective: the same on every rank.

  shift   of the rates of a node's unknowns: du_t/du
  fresh   a Newton solve begins
  n       how many contacts there are; slopes: of each, borrowed
*/
PetscErrorCode StrandsLinearise(Strands self, const StrandState *state, const PetscReal shift[],
                                PetscBool fresh, PetscInt *n, StrandSlope **slopes) {
  PetscFunctionBegin;
  if (self->slopes_room < self->n) {
    self->slopes_room = self->room;
    PetscCall(PetscFree(self->slopes));
    PetscCall(PetscMalloc1(self->slopes_room, &self->slopes));
  }
  *n = 0;
  *slopes = self->slopes;
  if (fresh) PairsForget(self);
  StrandJoints(self, state, shift);
  for (PetscInt k = 0; k < self->n; k++) {
    StrandSlope *slope = &self->slopes[*n];
    if (!self->pair[k].active) continue;
    (self->dims == 2 ? LineariseInPlane : LineariseInSpace)(self, &self->pair[k], fresh, slope);
    if (self->meet) StrandSlopeToOwn(self, slope);
    (*n)++;
  }
  PetscFunctionReturn(0);
}
