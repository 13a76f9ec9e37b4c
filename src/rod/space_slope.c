/* The derivatives of a cell's equations of a rod in space (space.c) by the unknowns of its nodes.
 */
#include "rod/space_slope.h"
#include "base/clones.h"
#include "base/vectors.h"
#include <string.h>

/* The derivatives of the kink that feet leave (space.c), by p in the middle of a cell and by w. */
void SpaceKinkSlope(const Cell *cell, PetscReal by_p[4][4], PetscReal by_w[4][3]) {
  const Point *p = cell->mid;
  const PetscReal *w = cell->foot_load[FOOT_KINK], f = PetscSqr(cell->h * cell->law[AT_MID].g);
  PetscReal D[3][4];

  memset(by_p, 0, 4 * sizeof(*by_p));
  memset(by_w, 0, 4 * sizeof(*by_w));
  for (int k = 1; k < 3; k++) {
    const int other = 3 - k; /* d_k.(d1 x w) = -w.d3 of k = 1, w.d2 of k = 2 */
    const PetscReal size = (k == 1 ? -1 : 1) * f * cell->law[AT_MID].flex[k],
                    unit[3] = {0, k == 1, k == 2},
                    turn[3] = {0, unit[1] * size * Dot3(w, p->at.axes[2]),
                               unit[2] * size * Dot3(w, p->at.axes[1])};
    PetscReal along[4], r[4];
    DirectorSlope(p->p, p->size, p->at.axes[other], other, D);
    QuaternionTurn(p->p, unit, along);
    for (int i = 0; i < 4; i++) {
      for (int j = 0; j < 3; j++) by_w[i][j] += along[i] / 2 * size * p->at.axes[other][j];
      for (int j = 0; j < 4; j++) by_p[i][j] += along[i] / 2 * size * ColumnDot3(D[0], 4, j, w);
    }
    for (int j = 0; j < 4; j++) { /* the product is linear in p */
      const PetscReal one[4] = {j == 0, j == 1, j == 2, j == 3};
      QuaternionTurn(one, turn, r);
      for (int i = 0; i < 4; i++) by_p[i][j] += r[i] / 2;
    }
  }
}

/* The derivatives at a point, its load's brought up to the present state first. By v and spin they
   are not part of f: see AddVelocity(). */
WIDE_VECTORS static void Linearise(const Cell *cell, const Law *law, const Point *p,
                                   FrictionDual *dual, Slope *slope) {
  const Load *load = cell->load;
  const PetscReal g = law->g, *q = p->at.axes[0], *u = p->u, *n = p->n;
  PetscReal(*f)[FIELDS] = slope->f, D[3][4];

  LoadLinearise(3, load, &p->at, cell->fresh, dual, &slope->load);
  memset(f, 0, sizeof(slope->f));
  for (int k = 0; k < 3; k++) { /* u_k = flex_k d_k.m + u0_k */
    DirectorSlope(p->p, p->size, p->at.axes[k], k, D);
    if (!k) memcpy(slope->d1, D, sizeof(D));
    for (int j = 0; j < 4; j++) slope->u_p[k][j] = law->flex[k] * ColumnDot3(D[0], 4, j, p->m);
    for (int j = 0; j < 3; j++) slope->u_m[k][j] = law->flex[k] * p->at.axes[k][j];
  }
  /* x' = g d1 */
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++) f[X + i][P + j] = g * slope->d1[i][j];
  /* p' = g/2 p (0, u): linear in u with T, in p with the matrix of u */
  const PetscReal T[4][3] = {{-p->p[1], -p->p[2], -p->p[3]},
                             {p->p[0], -p->p[3], p->p[2]},
                             {p->p[3], p->p[0], -p->p[1]},
                             {-p->p[2], p->p[1], p->p[0]}},
                  O[4][4] = {{0, -u[0], -u[1], -u[2]},
                             {u[0], 0, u[2], -u[1]},
                             {u[1], -u[2], 0, u[0]},
                             {u[2], u[1], -u[0], 0}};
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++) f[P + i][P + j] = g / 2 * O[i][j];
  AddProduct(4, 3, 4, g / 2, T[0], 3, slope->u_p[0], 4, &f[P][P], FIELDS);
  AddProduct(4, 3, 3, g / 2, T[0], 3, slope->u_m[0], 3, &f[P][M], FIELDS);
  /* m' = -g d1 x n */
  const PetscReal by_q[3][3] = {{0, n[2], -n[1]}, {-n[2], 0, n[0]}, {n[1], -n[0], 0}},
                  by_n[3][3] = {{0, -q[2], q[1]}, {q[2], 0, -q[0]}, {-q[1], q[0], 0}};
  AddProduct(3, 3, 4, -g, by_q[0], 3, slope->d1[0], 4, &f[M][P], FIELDS);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) f[M + i][N + j] = -g * by_n[i][j];
  if (!LoadPlaced(load)) return;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) f[N + i][X + j] = g * slope->load.x[i][j];
  AddProduct(3, 3, 4, g, slope->load.q[0], 3, slope->d1[0], 4, &f[N][P], FIELDS);
}

/* Adds to the derivatives of f what comes of the couple of friction where it turns and varies. */
static void AddCouple(const Load *load, const Law *law, const Point *p, const FrictionDual *dual,
                      Slope *slope) {
  PetscReal l[RUBS];

  LoadForce(3, load, &p->at, dual, l);
  for (int i = 0; i < 3; i++) {
    const PetscReal along = law->g * p->at.axes[0][i], *by_q = slope->load.q[SPIN];
    for (int j = 0; j < 4; j++) slope->f[M + i][P + j] += law->g * l[SPIN] * slope->d1[i][j];
    if (!LoadPlaced(load)) continue;
    for (int j = 0; j < 3; j++) slope->f[M + i][X + j] += along * slope->load.x[SPIN][j];
    for (int j = 0; j < 4; j++)
      slope->f[M + i][P + j] += along * ColumnDot3(slope->d1[0], 4, j, by_q);
  }
}

/* How the rates in W change with the unknowns of a node by their shifts; half: of the rates in the
   middle of a cell each end has half. dW[RUBS][FIELDS] is added to. */
static void RateSlope(const Load *load, const Point *p, PetscReal half, const PetscReal shift[],
                      PetscReal dW[RUBS][FIELDS]) {
  const PetscReal f = 2 / p->size * load->arm;
  PetscReal by_rate[4];

  SpinForm(p->p, by_rate);
  for (int i = 0; i < 3; i++) dW[i][X + i] += half * shift[X + i];
  for (int j = 0; j < 4 && load->arm > 0; j++)
    dW[SPIN][P + j] += half * shift[P + j] * f * by_rate[j];
}

/* By p where its rate is held, in the spin. */
static void SpinByP(const Load *load, const Point *p, PetscReal by[4]) {
  const PetscReal *p_t = p->p_t, f = 2 / p->size * load->arm,
                  spin = f * QuaternionSpin(p->p, p->size, p_t);

  SpinForm(p_t, by);
  for (int j = 0; j < 4; j++) by[j] = -f * by[j] - spin * p->p[j];
}

/* By the place on the curve: of W = (v, r spin) what slides past labels, c d1 and c u1. */
static void SlideSlope(const Load *load, const Law *law, const Slope *slope,
                       PetscReal dW[RUBS][FIELDS]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++) dW[i][P + j] += law->c * slope->d1[i][j];
  if (load->arm == 0) return;
  for (int j = 0; j < 4; j++) dW[SPIN][P + j] += load->arm * law->c * slope->u_p[0][j];
  for (int j = 0; j < 3; j++) dW[SPIN][M + j] += load->arm * law->c * slope->u_m[0][j];
}

/* By the place on the curve: c d1, c u1 and p in the spin. */
static void TurnSlope(const Load *load, const Law *law, const Point *p, const Slope *slope,
                      PetscReal dW[RUBS][FIELDS]) {
  PetscReal by[4];

  SlideSlope(load, law, slope, dW);
  if (load->arm == 0) return;
  SpinByP(load, p, by);
  for (int j = 0; j < 4; j++) dW[SPIN][P + j] += by[j];
}

/* f += s dF/dW dW, of the force and of its couple about d1. */
static void AddVelocity(const Load *load, const Law *law, const Point *p, const Slope *slope,
                        PetscReal s, PetscReal dW[RUBS][FIELDS], PetscReal f[FIELDS][FIELDS]) {
  PetscReal couple[3][RUBS];

  AddProduct(3, 3, M, s * law->g, slope->load.W[0], RUBS, dW[0], FIELDS, f[N], FIELDS);
  if (load->arm == 0) return;
  AddProduct(3, 1, N, s * law->g, slope->load.W[0] + SPIN, RUBS, dW[SPIN], FIELDS, f[N], FIELDS);
  for (int i = 0; i < 3; i++)
    for (int c = 0; c < RUBS; c++) couple[i][c] = p->at.axes[0][i] * slope->load.W[SPIN][c];
  AddProduct(3, RUBS, N, s * law->g, couple[0], RUBS, dW[0], FIELDS, f[M], FIELDS);
}

/* How x'_t = g_t d1 + g d1_t of a node changes with p, and with p_t by its shift: 3 x 4. */
static void VelocitySlopeSlope(const Law *law, const Point *p, const Slope *slope,
                               const PetscReal shift[], PetscReal by_p[3][4]) {
  DirectorRateSlope(p->p, p->size, p->at.axes[0], p->d1_t, 0, slope->d1, p->p_t, by_p);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++)
      by_p[i][j] =
          law->g_t * slope->d1[i][j] + law->g * (shift[P + j] * slope->d1[i][j] + by_p[i][j]);
}

/* How NodeSpinSlope() changes with p and m of a node, by_p as above:
     d(spin') = g_t du1 + g (d(flex1 m_t.d1 + flex1 m.d1_t + flex1_t m.d1) - sum d(u_k d_k.d1_t)).
 */
static void SpinSlopeSlope(const Law *law, const Point *p, const Slope *slope,
                           const PetscReal shift[], PetscReal by_p[3][4], PetscReal by[7]) {
  const PetscReal g = law->g, flex = law->flex[0], flex_t = law->twist.flex_t, *d1_t = p->d1_t;

  for (int j = 0; j < 4; j++) by[j] = law->g_t * slope->u_p[0][j];
  for (int j = 0; j < 3; j++)
    by[4 + j] = (law->g_t + g * shift[M + j]) * slope->u_m[0][j] +
                g * (flex * d1_t[j] + flex_t * p->at.axes[0][j]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++)
      by[j] += g * (flex * p->m_t[i] + flex_t * p->m[i]) * slope->d1[i][j] +
               flex * p->m[i] * (by_p[i][j] - law->g_t * slope->d1[i][j]);
  for (int k = 1; k < 3; k++) {
    const PetscReal *d = p->at.axes[k], turns = Dot3(d, d1_t);
    PetscReal D[3][4];
    DirectorSlope(p->p, p->size, d, k, D);
    for (int j = 0; j < 4; j++) by[j] -= g * slope->u_p[k][j] * turns;
    for (int j = 0; j < 3; j++) by[4 + j] -= g * slope->u_m[k][j] * turns;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 4; j++)
        by[j] -=
            p->u[k] * (g * D[i][j] * d1_t[i] + d[i] * (by_p[i][j] - law->g_t * slope->d1[i][j]));
  }
}

/* Adds to how W changes in the middle of a cell what its spin has of a node: half of that there,
   and k of its slope. */
static void CubicSpin(const Load *load, const Law *law, const Point *p, const Slope *slope,
                      PetscReal k, const PetscReal shift[], PetscReal by_p[3][4],
                      PetscReal dW[RUBS][FIELDS]) {
  PetscReal rates[RUBS][FIELDS] = {{0}}, held[4], along[7];

  RateSlope(load, p, 1, shift, rates);
  SpinByP(load, p, held);
  SpinSlopeSlope(law, p, slope, shift, by_p, along);
  for (int j = 0; j < 4; j++) dW[SPIN][P + j] = (rates[SPIN][P + j] + held[j]) / 2;
  for (int j = 0; j < 7; j++) dW[SPIN][P + j] += load->arm * k * along[j];
}

/* The derivatives at a node, with what its own rates add. */
static void NodeSlope(const Cell *cell, const Law *law, const Point *p, FrictionDual *dual,
                      const PetscReal shift[], Slope *slope) {
  PetscReal dW[RUBS][FIELDS] = {{0}};

  Linearise(cell, law, p, dual, slope);
  if (cell->load->arm > 0) AddCouple(cell->load, law, p, dual, slope);
  RateSlope(cell->load, p, 1, shift, dW);
  TurnSlope(cell->load, law, p, slope, dW);
  AddVelocity(cell->load, law, p, slope, 1, dW, slope->f);
}

/* How the couple of friction at a node changes with its unknowns: 3 x FIELDS. */
static void CoupleSlope(const Cell *cell, const Law *law, const Point *p, const FrictionDual *dual,
                        const PetscReal shift[], const Slope *slope, PetscReal by[3][FIELDS]) {
  PetscReal dW[RUBS][FIELDS] = {{0}};
  Slope alone = *slope;

  memset(alone.f, 0, sizeof(alone.f));
  AddCouple(cell->load, law, p, dual, &alone);
  RateSlope(cell->load, p, 1, shift, dW);
  TurnSlope(cell->load, law, p, slope, dW);
  AddVelocity(cell->load, law, p, slope, 1, dW, alone.f);
  memcpy(by, alone.f[M], 3 * sizeof(*by));
}

/* How an end of the cell changes, for its feet. */
static void EndOf(const Cell *cell, const Law *law, const Point *p, const PetscReal shift[],
                  const Slope *slope, FootEnd *end) {
  PetscReal dW[RUBS][FIELDS] = {{0}};

  memset(end, 0, sizeof(*end));
  memcpy(end->curve.q, slope->d1, sizeof(end->curve.q));
  VelocitySlopeSlope(law, p, slope, shift, end->curve.slope_t);
  for (int d = 0; d < 3; d++) end->curve.shift[d] = shift[X + d];
  if (cell->load->arm == 0) return;
  RateSlope(cell->load, p, 1, shift, dW);
  TurnSlope(cell->load, law, p, slope, dW);
  for (int f = 0; f < FOOT_NODE; f++) end->spin[f] = dW[SPIN][f] / cell->load->arm;
}

/* What feet do to G and J of CellJacobian(), by the unknowns of node e of the cell, a or b. */
static void FeetSlope(const Cell *cell, int e, FootSlope by, PetscReal G[FIELDS][FIELDS],
                      PetscReal J[FIELDS][FIELDS]) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const PetscReal k = self->bow * cell->h, we = cell->h * self->end_weight,
                  wm = cell->h * self->mid_weight;

  for (int i = 0; i < FOOT_LOAD; i++)
    for (int f = 0; f < FOOT_NODE; f++) {
      const int row = i < 3 ? N + i : M + i - 3, u = FOOT_NODE * e + f;
      G[row][f] += k * (by[AT_A][i][u] - by[AT_B][i][u]);
      J[row][f] -= we * (by[AT_A][i][u] + by[AT_B][i][u]) + wm * by[AT_MID][i][u];
    }
}

/* ... and their kink, once G is known. */
static void AddKinkSlope(const Cell *cell, int e, FootSlope by, PetscReal G[FIELDS][FIELDS],
                         PetscReal J[FIELDS][FIELDS]) {
  PetscReal by_p[4][4], by_w[4][3];

  SpaceKinkSlope(cell, by_p, by_w);
  AddProduct(4, 4, FIELDS, -1, by_p[0], 4, G[P], FIELDS, J[P], FIELDS);
  for (int i = 0; i < 4; i++)
    for (int f = 0; f < FOOT_NODE; f++)
      for (int d = 0; d < 3; d++) J[P + i][f] -= by_w[i][d] * by[FOOT_KINK][d][FOOT_NODE * e + f];
}

/* J, the derivative of the cell's equations by the unknowns of one of its nodes: sign -1 for node
   a, 1 for node b. With G = dy_mid/dy = I/2 + k df/dy, J = sign I - we df/dy - wm (df_mid/dy_mid G
   + df_mid/dW dW_mid/dy). feet: what those of the cell change; NULL: it has none. */
WIDE_VECTORS static void CellJacobian(const Cell *cell, PetscReal sign, const PetscReal shift[],
                                      const Law *law, const Point *p, const FrictionDual *dual,
                                      const Slope *slope, const Slope *mid, FootSlope feet,
                                      PetscReal J[FIELDS][FIELDS]) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const Load *load = cell->load;
  const PetscReal k = -sign * self->bow * cell->h, we = cell->h * self->end_weight,
                  wm = cell->h * self->mid_weight;
  PetscReal G[FIELDS][FIELDS], dW[RUBS][FIELDS] = {{0}}, turn[RUBS][FIELDS] = {{0}}, by_p[3][4];

  for (int i = 0; i < FIELDS; i++)
    for (int j = 0; j < FIELDS; j++) {
      G[i][j] = k * slope->f[i][j];
      J[i][j] = -we * slope->f[i][j];
    }
  if (cell->split) {
    PetscReal by[3][FIELDS];
    CoupleSlope(cell, law, p, dual, shift, slope, by);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < FIELDS; j++) {
        G[M + i][j] -= sign * SplitBow(cell) * by[i][j];
        J[M + i][j] -= wm / 2 * by[i][j];
      }
  }
  for (int i = 0; i < FIELDS; i++) {
    G[i][i] += 0.5;
    J[i][i] += sign;
  }
  if (feet) {
    FeetSlope(cell, sign > 0, feet, G, J);
    AddKinkSlope(cell, sign > 0, feet, G, J);
  }
  RateSlope(load, cell->mid, 0.5, shift, dW);
  if (k != 0) {
    VelocitySlopeSlope(law, p, slope, shift, by_p);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 4; j++) dW[i][P + j] += k * by_p[i][j];
  }
  if (cell->cubic) CubicSpin(load, law, p, slope, k, shift, by_p, dW);
  if (cell->law[AT_MID].c != 0 || load->arm > 0) {
    if (cell->cubic)
      SlideSlope(load, &cell->law[AT_MID], mid, turn);
    else
      TurnSlope(load, &cell->law[AT_MID], cell->mid, mid, turn);
    AddProduct(RUBS, 7, FIELDS, 1, turn[0] + P, FIELDS, G[P], FIELDS, dW[0], FIELDS);
  }
  /* rows of x and p by p and m; of m by p and n; of n by x and p: what is 0 is left out */
  AddProduct(3, 4, 7, -wm, &mid->f[X][P], FIELDS, &G[P][P], FIELDS, &J[X][P], FIELDS);
  AddProduct(4, 4, 7, -wm, &mid->f[P][P], FIELDS, &G[P][P], FIELDS, &J[P][P], FIELDS);
  AddProduct(4, 3, FIELDS, -wm, &mid->f[P][M], FIELDS, G[M], FIELDS, J[P], FIELDS);
  AddProduct(3, 4, 7, -wm, &mid->f[M][P], FIELDS, &G[P][P], FIELDS, &J[M][P], FIELDS);
  AddProduct(3, 3, FIELDS, -wm, &mid->f[M][N], FIELDS, G[N], FIELDS, J[M], FIELDS);
  if (LoadPlaced(load)) {
    AddProduct(3, 3, FIELDS, -wm, mid->f[M], FIELDS, G[X], FIELDS, J[M], FIELDS);
    AddProduct(3, 7, FIELDS, -wm, mid->f[N], FIELDS, G[X], FIELDS, J[N], FIELDS);
  }
  if (cell->law[AT_MID].c != 0 || load->arm > 0) {
    AddProduct(3, 3, FIELDS, -wm * cell->law[AT_MID].g, mid->load.W[0], RUBS, dW[0], FIELDS, J[N],
               FIELDS);
    if (load->arm > 0) {
      PetscReal couple[3][RUBS];
      for (int i = 0; i < 3; i++)
        for (int c = 0; c < RUBS; c++)
          couple[i][c] = cell->mid->at.axes[0][i] * mid->load.W[SPIN][c];
      AddProduct(3, 1, FIELDS, -wm * cell->law[AT_MID].g, mid->load.W[0] + SPIN, RUBS, dW[SPIN],
                 FIELDS, J[N], FIELDS);
      if (!cell->split)
        AddProduct(3, RUBS, FIELDS, -wm * cell->law[AT_MID].g, couple[0], RUBS, dW[0], FIELDS, J[M],
                   FIELDS);
    }
  } else
    AddProduct(3, 3, 7, -wm * cell->law[AT_MID].g, mid->load.W[0], RUBS, dW[0], FIELDS, J[N],
               FIELDS);
}

/* The shifts at node i; where modes are counted friction holds a tip that is still. */
static const PetscReal *ShiftsAt(const Cell *cell, PetscInt i, const PetscReal *shift,
                                 PetscReal still[FIELDS]) {
  return cell->counts ? shift : SpaceStill(cell, i, shift, still);
}

/* A cell's equations, that behind node i, by its nodes, left and right. */
void SpaceCellBlocks(Cell *cell, PetscInt i, PetscBool first, const PetscReal shift[],
                     Slopes *slopes, PetscReal left[FIELDS][FIELDS],
                     PetscReal right[FIELDS][FIELDS]) {
  PetscReal still[FIELDS];
  const PetscReal *own = ShiftsAt(cell, i + 1, shift, still);
  FootSlope feet;

  if (first)
    NodeSlope(cell, cell->law, cell->a, cell->dual[AT_A], shift, &slopes->a);
  else
    slopes->a = slopes->b;
  NodeSlope(cell, cell->law + AT_B, cell->b, cell->dual[AT_B], own, &slopes->b);
  Linearise(cell, cell->law + AT_MID, cell->mid, cell->dual[AT_MID], &slopes->mid);
  if (cell->load->arm > 0 && !cell->split)
    AddCouple(cell->load, cell->law + AT_MID, cell->mid, cell->dual[AT_MID], &slopes->mid);
  if (cell->feet.n) {
    FootEnd end[2];
    memset(feet, 0, sizeof(feet));
    EndOf(cell, cell->law, cell->a, shift, &slopes->a, &end[0]);
    EndOf(cell, cell->law + AT_B, cell->b, own, &slopes->b, &end[1]);
    FeetLinearise(&cell->rod->scene->contact, &cell->foot_cell, end, cell->fresh,
                  FeetHeldAt(cell, i), &cell->feet, feet);
  }
  CellJacobian(cell, -1, shift, cell->law, cell->a, cell->dual[AT_A], &slopes->a, &slopes->mid,
               cell->feet.n ? feet : NULL, left);
  CellJacobian(cell, 1, own, cell->law + AT_B, cell->b, cell->dual[AT_B], &slopes->b, &slopes->mid,
               cell->feet.n ? feet : NULL, right);
}

void SpaceTipBlock(const Cell *cell, const Slope *slope, const PetscReal shift[],
                   PetscReal by[RIGHT][FIELDS]) {
  Rod rod = cell->rod;
  TipState tip = SpaceTipOf(cell->load, cell->b);
  PetscReal dW[RUBS][FIELDS] = {{0}}, still[FIELDS];

  RateSlope(cell->load, cell->b, 1, ShiftsAt(cell, rod->last, shift, still), dW);
  TurnSlope(cell->load, cell->law + AT_B, cell->b, slope, dW);
  TipJacobian3(&rod->scene->tip, &tip, (const PetscReal(*)[FIELDS])dW, cell->fresh,
               SpaceTipDual(rod), by);
}

/* How W in the middle of a cell changes with p there, as it is turned, and by its spin with m. */
void SpaceMidTurns(const Cell *cell, const Slope *mid, PetscReal turn[RUBS][FIELDS]) {
  memset(turn, 0, RUBS * sizeof(*turn));
  if (cell->cubic)
    SlideSlope(cell->load, &cell->law[1], mid, turn);
  else
    TurnSlope(cell->load, &cell->law[1], cell->mid, mid, turn);
}
