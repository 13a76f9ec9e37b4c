/* The model of space (docs/theory/rod.md): a Kirchhoff rod, thirteen unknowns a node. d1, d2, d3
   are the directors of the quaternion p, d1 the tangent; x, m and n are in the clamp's frame,

     x' = g d1,  p' = g/2 p (0, u),  u = S^-1 (m.d1, m.d2, m.d3) + u0,
     m' = -g d1 x n + g l d1,  n' = g F,

   F the load and l its couple about the tangent (world/load_space.h), at the velocity
   v = x_t + c d1 and the spin 2 (p* p_t)_1 + c u1,
     s = 0: x = 0, p that of the clamp, or in a hinge m.d2 = m.d3 = 0, |p| = 1 and no turn about d1
            but the clamp's, or m = 0, n = 0, |p| = 1 where it is free;
     s = 1: the tip's six conditions (tip.h).
   The cells are those of the frame model (frame.c), y = (x, p, m, n),
     order 4:  y_b - y_a = h/6 (f_a + 4 f_mid + f_b),  y_mid = (y_a + y_b)/2 + h/8 (f_a - f_b),
     order 2:  y_b - y_a = h f_mid,                    y_mid = (y_a + y_b)/2,
   x_t at mid likewise, and the spin where friction along the rod feels it (rod/spin.h); else the
   rate of p there is the mean of both ends'. Where the couple of friction jumps within a cell it
   has that of its ends (space_cells.c). The rows of node i are the x and p equations of the cell on
   its left, the m and n equations of the cell on its right. */
#include "base/clones.h"
#include "base/lagrange.h"
#include "base/vectors.h"
#include "rod/space_cells.h"
#include "rod/spin_rest.h"
#include <string.h>

/* The derivatives of f at a point by its unknowns, the velocity and the spin held, and by these. */
typedef struct {
  PetscReal d1[3][4], u_p[3][4], u_m[3][3];
  PetscReal f[FIELDS][FIELDS];
  LoadSlope3 load;
} Slope;

/* What the tip's conditions are about. */
static TipState3 TipOf(const Load *load, const Point *end) {
  TipState3 tip = {.at = end->at};

  if (load->arm > 0) {
    tip.per_W = 1 / load->arm;
    tip.spin = end->at.W[SPIN] / load->arm;
  }
  memcpy(tip.p, end->p, sizeof(tip.p));
  memcpy(tip.m, end->m, sizeof(tip.m));
  memcpy(tip.n, end->n, sizeof(tip.n));
  DirectorSlope(end->p, end->size, end->d[0], 0, tip.q_p);
  return tip;
}

static FrictionDual4 *TipDual(Rod rod) {
  return Duals((const Space_ *)rod->data, 2 * (rod->last - rod->first + 1) + 1);
}

/* The four of a hinge beside x = 0, and their derivatives; each changes sign with the field of its
   row in the mirrors. How a section has turned about d1 is counted against the smallest rotation
   that takes the clamp's axis there, as links are: 2 atan2(p1, p0), that of the clamp. The twisting
   moment goes along with d1, as that at the tip does. */
static void HingeResidual(const PetscReal u[FIELDS], const PetscReal clamp[4], PetscReal r[4]) {
  const PetscReal *p = u + P, *m = u + M, size = QuaternionSize(p);
  PetscReal d[3][3];

  Directors(p, size, d);
  r[0] = (size - 1) / 2;
  r[1] = clamp[0] * p[1] - clamp[1] * p[0];
  for (int k = 1; k < 3; k++) r[1 + k] = Dot3(m, d[k]);
}

static void HingeBlock(const PetscReal u[FIELDS], const PetscReal clamp[4],
                       PetscReal by[4][FIELDS]) {
  const PetscReal *p = u + P, *m = u + M, size = QuaternionSize(p);
  PetscReal d[3][3], slope[3][4];

  Directors(p, size, d);
  for (int j = 0; j < 4; j++) by[0][P + j] = p[j];
  by[1][P] = -clamp[1];
  by[1][P + 1] = clamp[0];
  for (int k = 1; k < 3; k++) {
    DirectorSlope(p, size, d[k], k, slope);
    for (int i = 0; i < 3; i++) {
      by[1 + k][M + i] = d[k][i];
      for (int j = 0; j < 4; j++) by[1 + k][P + j] += m[i] * slope[i][j];
    }
  }
}

/* The seven conditions at the beginning, r = 0. */
static void ClampResidual(Scene scene, PetscReal t, const PetscReal u[FIELDS],
                          PetscReal r[FIELDS]) {
  PetscReal p[4];

  if (scene->clamp == CLAMP_FREE) {
    for (int d = 0; d < 6; d++) r[d] = u[M + (d + 3) % 6];
    r[LEFT - 1] = (QuaternionSize(u + P) - 1) / 2;
    return;
  }
  SpaceClampTurn(&scene->space, t, p);
  for (int f = 0; f < LEFT; f++) r[f] = u[f] - (f < P ? 0 : p[f - P]);
  if (scene->clamp == CLAMP_HINGED) HingeResidual(u, p, r + P);
}

/* ... and their derivatives. */
static void ClampBlock(Scene scene, PetscReal t, const PetscReal u[FIELDS],
                       PetscReal by[LEFT][FIELDS]) {
  PetscReal p[4];

  memset(by, 0, LEFT * sizeof(*by));
  if (scene->clamp == CLAMP_FREE) {
    for (int d = 0; d < 6; d++) by[d][M + (d + 3) % 6] = 1;
    for (int k = 0; k < 4; k++) by[LEFT - 1][P + k] = u[P + k];
    return;
  }
  for (int f = 0; f < (scene->clamp == CLAMP_HINGED ? P : LEFT); f++) by[f][f] = 1;
  if (scene->clamp != CLAMP_HINGED) return;
  SpaceClampTurn(&scene->space, t, p);
  HingeBlock(u, p, by + P);
}

/* A point load is smeared over its cell by the formula; what p of the end lacks of that, see
   FootLoad:

     K = p/2 (0, w),   w_k = (h g)^2/S_k d_k.(d1 x w),   w that of the feet, p and d in the middle,
*/
static void Kink(const Cell *cell, PetscReal K[4]) {
  const Point *p = cell->mid;
  const PetscReal *w = cell->foot_load[FOOT_KINK], f = PetscSqr(cell->h * cell->law[1].g),
                  turn[3] = {0, -f * cell->law[1].flex[1] * Dot3(w, p->d[2]),
                             f * cell->law[1].flex[2] * Dot3(w, p->d[1])};

  QuaternionTurn(p->p, turn, K);
  for (int i = 0; i < 4; i++) K[i] /= 2;
}

/* ... and its derivatives by p and w. */
static void KinkSlope(const Cell *cell, PetscReal by_p[4][4], PetscReal by_w[4][3]) {
  const Point *p = cell->mid;
  const PetscReal *w = cell->foot_load[FOOT_KINK], f = PetscSqr(cell->h * cell->law[1].g);
  PetscReal D[3][4];

  memset(by_p, 0, 4 * sizeof(*by_p));
  memset(by_w, 0, 4 * sizeof(*by_w));
  for (int k = 1; k < 3; k++) {
    const int other = 3 - k; /* d_k.(d1 x w) = -w.d3 of k = 1, w.d2 of k = 2 */
    const PetscReal size = (k == 1 ? -1 : 1) * f * cell->law[1].flex[k],
                    unit[3] = {0, k == 1, k == 2},
                    turn[3] = {0, unit[1] * size * Dot3(w, p->d[2]),
                               unit[2] * size * Dot3(w, p->d[1])};
    PetscReal along[4], r[4];
    DirectorSlope(p->p, p->size, p->d[other], other, D);
    QuaternionTurn(p->p, unit, along);
    for (int i = 0; i < 4; i++) {
      for (int j = 0; j < 3; j++) by_w[i][j] += along[i] / 2 * size * p->d[other][j];
      for (int j = 0; j < 4; j++)
        by_p[i][j] += along[i] / 2 * size * (D[0][j] * w[0] + D[1][j] * w[1] + D[2][j] * w[2]);
    }
    for (int j = 0; j < 4; j++) { /* the product is linear in p */
      const PetscReal one[4] = {j == 0, j == 1, j == 2, j == 3};
      QuaternionTurn(one, turn, r);
      for (int i = 0; i < 4; i++) by_p[i][j] += r[i] / 2;
    }
  }
}

/* Adds to the residual of a cell what its feet do at its ends alone, and the kink. */
static void AddFeet(const Cell *cell, PetscReal r[FIELDS]) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const PetscReal we = cell->h * self->end_weight, (*load)[FOOT3_LOAD] = cell->foot_load;
  PetscReal K[4];

  Kink(cell, K);
  for (int i = 0; i < 4; i++) r[P + i] -= K[i];
  for (int i = 0; i < 3; i++) {
    r[N + i] -= we * (load[0][i] + load[2][i]);
    r[M + i] -= we * (load[0][3 + i] + load[2][3 + i]);
  }
}

static PetscErrorCode SpaceResidual(Rod rod, const RodState *at, Vec F) {
  const Space_ *self = (const Space_ *)rod->data;
  const Scene scene = rod->scene;
  PetscReal(*F_)[FIELDS], r[FIELDS];
  Cell cell;

  PetscFunctionBegin;
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  PetscCall(DMDAVecGetArray(rod->da, F, &F_));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    for (int f = 0; f < FIELDS; f++)
      r[f] = cell.u[i + 1][f] - cell.u[i][f] -
             cell.h * (self->end_weight * (cell.a->f[f] + cell.b->f[f]) +
                       self->mid_weight * cell.mid->f[f]);
    if (cell.feet.n) AddFeet(&cell, r);
    if (i >= rod->first) PetscCall(PetscArraycpy(&F_[i][LEFT], &r[LEFT], RIGHT));
    if (i + 1 < rod->end) PetscCall(PetscArraycpy(F_[i + 1], r, LEFT));
  }
  if (rod->first == 0) ClampResidual(scene, at->t, cell.u[0], F_[0]);
  if (rod->end == rod->last + 1) {
    TipState3 tip = TipOf(cell.load, cell.b);
    TipResidual3(&scene->tip, &tip, TipDual(rod), &F_[rod->last][LEFT]);
    for (int d = 0; d < 3 && cell.push && scene->tip.type == TIP_FREE; d++) {
      F_[rod->last][N + d] -= cell.push[2 * rod->last + 1][d];
      if (cell.couple) F_[rod->last][M + d] -= cell.couple[2 * rod->last + 1][d];
    }
  }
  PetscCall(DMDAVecRestoreArray(rod->da, F, &F_));
  PetscCall(SpaceCellsClose(&cell));
  PetscFunctionReturn(0);
}

/* ---- derivatives ---- */

/* C += s A B, of sizes known when compiled. */
ALWAYS_INLINE void AddProduct(int rows, int inner, int columns, PetscReal s,
                              const PetscReal *restrict A, int lda, const PetscReal *restrict B,
                              int ldb, PetscReal *restrict C, int ldc) {
  for (int i = 0; i < rows; i++)
    for (int k = 0; k < inner; k++) {
      const PetscReal a = s * A[i * lda + k];
      for (int j = 0; j < columns; j++) C[i * ldc + j] += a * B[k * ldb + j];
    }
}

/* The derivatives at a point, its load's brought up to the present state first. By v and spin they
   are not part of f: see AddVelocity(). */
WIDE_VECTORS static void Linearise(const Cell *cell, const Law *law, const Point *p,
                                   FrictionDual4 *dual, Slope *slope) {
  const Load *load = cell->load;
  const PetscReal g = law->g, *q = p->d[0], *u = p->u, *n = p->n;
  PetscReal(*f)[FIELDS] = slope->f, D[3][4];

  LoadLinearise3(load, &p->at, cell->fresh, dual, &slope->load);
  memset(f, 0, sizeof(slope->f));
  for (int k = 0; k < 3; k++) { /* u_k = flex_k d_k.m + u0_k */
    DirectorSlope(p->p, p->size, p->d[k], k, D);
    if (!k) memcpy(slope->d1, D, sizeof(D));
    for (int j = 0; j < 4; j++)
      slope->u_p[k][j] = law->flex[k] * (D[0][j] * p->m[0] + D[1][j] * p->m[1] + D[2][j] * p->m[2]);
    for (int j = 0; j < 3; j++) slope->u_m[k][j] = law->flex[k] * p->d[k][j];
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
static void AddCouple(const Load *load, const Law *law, const Point *p, const FrictionDual4 *dual,
                      Slope *slope) {
  PetscReal l[RUBS];

  LoadForce3(load, &p->at, dual, l);
  for (int i = 0; i < 3; i++) {
    const PetscReal along = law->g * p->d[0][i], *by_q = slope->load.q[SPIN];
    for (int j = 0; j < 4; j++) slope->f[M + i][P + j] += law->g * l[SPIN] * slope->d1[i][j];
    if (!LoadPlaced(load)) continue;
    for (int j = 0; j < 3; j++) slope->f[M + i][X + j] += along * slope->load.x[SPIN][j];
    for (int j = 0; j < 4; j++)
      slope->f[M + i][P + j] += along * (by_q[0] * slope->d1[0][j] + by_q[1] * slope->d1[1][j] +
                                         by_q[2] * slope->d1[2][j]);
  }
}

/* How the rates in W change with the unknowns of a node by their shifts; half: of the rates in the
   middle of a cell each end has half. dW[RUBS][FIELDS] is added to. */
static void RateSlope(const Load *load, const Point *p, PetscReal half, const PetscReal shift[],
                      PetscReal dW[RUBS][FIELDS]) {
  const PetscReal *q = p->p, f = 2 / p->size * load->arm;
  const PetscReal by_rate[4] = {-q[1], q[0], q[3], -q[2]};

  for (int i = 0; i < 3; i++) dW[i][X + i] += half * shift[X + i];
  for (int j = 0; j < 4 && load->arm > 0; j++)
    dW[SPIN][P + j] += half * shift[P + j] * f * by_rate[j];
}

/* By p where its rate is held, in the spin. */
static void SpinByP(const Load *load, const Point *p, PetscReal by[4]) {
  const PetscReal *p_t = p->p_t, f = 2 / p->size * load->arm,
                  spin = f * QuaternionSpin(p->p, p->size, p_t),
                  by_p[4] = {p_t[1], -p_t[0], -p_t[3], p_t[2]};

  for (int j = 0; j < 4; j++) by[j] = f * by_p[j] - spin * p->p[j];
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
    for (int c = 0; c < RUBS; c++) couple[i][c] = p->d[0][i] * slope->load.W[SPIN][c];
  AddProduct(3, RUBS, N, s * law->g, couple[0], RUBS, dW[0], FIELDS, f[M], FIELDS);
}

/* How x'_t = g_t d1 + g d1_t of a node changes with p, and with p_t by its shift: 3 x 4. */
static void VelocitySlopeSlope(const Law *law, const Point *p, const Slope *slope,
                               const PetscReal shift[], PetscReal by_p[3][4]) {
  DirectorRateSlope(p->p, p->size, p->d[0], p->d1_t, 0, slope->d1, p->p_t, by_p);
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
                g * (flex * d1_t[j] + flex_t * p->d[0][j]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++)
      by[j] += g * (flex * p->m_t[i] + flex_t * p->m[i]) * slope->d1[i][j] +
               flex * p->m[i] * (by_p[i][j] - law->g_t * slope->d1[i][j]);
  for (int k = 1; k < 3; k++) {
    const PetscReal *d = p->d[k], turns = d[0] * d1_t[0] + d[1] * d1_t[1] + d[2] * d1_t[2];
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
static void NodeSlope(const Cell *cell, const Law *law, const Point *p, FrictionDual4 *dual,
                      const PetscReal shift[], Slope *slope) {
  PetscReal dW[RUBS][FIELDS] = {{0}};

  Linearise(cell, law, p, dual, slope);
  if (cell->load->arm > 0) AddCouple(cell->load, law, p, dual, slope);
  RateSlope(cell->load, p, 1, shift, dW);
  TurnSlope(cell->load, law, p, slope, dW);
  AddVelocity(cell->load, law, p, slope, 1, dW, slope->f);
}

/* How the couple of friction at a node changes with its unknowns: 3 x FIELDS. */
static void CoupleSlope(const Cell *cell, const Law *law, const Point *p, const FrictionDual4 *dual,
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
static void FootEnd(const Cell *cell, const Law *law, const Point *p, const PetscReal shift[],
                    const Slope *slope, FootEnd3 *end) {
  PetscReal dW[RUBS][FIELDS] = {{0}};

  memset(end, 0, sizeof(*end));
  memcpy(end->q, slope->d1, sizeof(end->q));
  VelocitySlopeSlope(law, p, slope, shift, end->slope_t);
  for (int d = 0; d < 3; d++) end->shift[d] = shift[X + d];
  if (cell->load->arm == 0) return;
  RateSlope(cell->load, p, 1, shift, dW);
  TurnSlope(cell->load, law, p, slope, dW);
  for (int f = 0; f < FOOT3_NODE; f++) end->spin[f] = dW[SPIN][f] / cell->load->arm;
}

/* What feet do to G and J of CellJacobian(), by the unknowns of node e of the cell, a or b. */
static void FeetSlope(const Cell *cell, int e, FootSlope3 by, PetscReal G[FIELDS][FIELDS],
                      PetscReal J[FIELDS][FIELDS]) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const PetscReal k = self->bow * cell->h, we = cell->h * self->end_weight,
                  wm = cell->h * self->mid_weight;

  for (int i = 0; i < FOOT3_LOAD; i++)
    for (int f = 0; f < FOOT3_NODE; f++) {
      const int row = i < 3 ? N + i : M + i - 3, u = FOOT3_NODE * e + f;
      G[row][f] += k * (by[0][i][u] - by[2][i][u]);
      J[row][f] -= we * (by[0][i][u] + by[2][i][u]) + wm * by[1][i][u];
    }
}

/* ... and their kink, once G is known. */
static void AddKinkSlope(const Cell *cell, int e, FootSlope3 by, PetscReal G[FIELDS][FIELDS],
                         PetscReal J[FIELDS][FIELDS]) {
  PetscReal by_p[4][4], by_w[4][3];

  KinkSlope(cell, by_p, by_w);
  AddProduct(4, 4, FIELDS, -1, by_p[0], 4, G[P], FIELDS, J[P], FIELDS);
  for (int i = 0; i < 4; i++)
    for (int f = 0; f < FOOT3_NODE; f++)
      for (int d = 0; d < 3; d++) J[P + i][f] -= by_w[i][d] * by[FOOT_KINK][d][FOOT3_NODE * e + f];
}

/* J, the derivative of the cell's equations by the unknowns of one of its nodes: sign -1 for node
   a, 1 for node b. With G = dy_mid/dy = I/2 + k df/dy, J = sign I - we df/dy - wm (df_mid/dy_mid G
   + df_mid/dW dW_mid/dy). feet: what those of the cell change; NULL: it has none. */
WIDE_VECTORS static void CellJacobian(const Cell *cell, PetscReal sign, const PetscReal shift[],
                                      const Law *law, const Point *p, const FrictionDual4 *dual,
                                      const Slope *slope, const Slope *mid, FootSlope3 feet,
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
  if (cell->law[1].c != 0 || load->arm > 0) {
    if (cell->cubic)
      SlideSlope(load, &cell->law[1], mid, turn);
    else
      TurnSlope(load, &cell->law[1], cell->mid, mid, turn);
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
  if (cell->law[1].c != 0 || load->arm > 0) {
    AddProduct(3, 3, FIELDS, -wm * cell->law[1].g, mid->load.W[0], RUBS, dW[0], FIELDS, J[N],
               FIELDS);
    if (load->arm > 0) {
      PetscReal couple[3][RUBS];
      for (int i = 0; i < 3; i++)
        for (int c = 0; c < RUBS; c++) couple[i][c] = cell->mid->d[0][i] * mid->load.W[SPIN][c];
      AddProduct(3, 1, FIELDS, -wm * cell->law[1].g, mid->load.W[0] + SPIN, RUBS, dW[SPIN], FIELDS,
                 J[N], FIELDS);
      if (!cell->split)
        AddProduct(3, RUBS, FIELDS, -wm * cell->law[1].g, couple[0], RUBS, dW[0], FIELDS, J[M],
                   FIELDS);
    }
  } else
    AddProduct(3, 3, 7, -wm * cell->law[1].g, mid->load.W[0], RUBS, dW[0], FIELDS, J[N], FIELDS);
}

/* The slopes at the three points of a cell: that of its first node is the last of the cell before.
 */
typedef struct {
  Slope a, mid, b;
} Slopes;

/* The shifts at node i; where modes are counted friction holds a tip that is still. */
static const PetscReal *ShiftsAt(const Cell *cell, PetscInt i, const PetscReal *shift,
                                 PetscReal still[FIELDS]) {
  return cell->counts ? shift : SpaceStill(cell, i, shift, still);
}

/* A cell's equations, that behind node i, by its nodes, left and right. */
static void CellBlocks(Cell *cell, PetscInt i, PetscBool first, const PetscReal shift[],
                       Slopes *slopes, PetscReal left[FIELDS][FIELDS],
                       PetscReal right[FIELDS][FIELDS]) {
  PetscReal still[FIELDS];
  const PetscReal *own = ShiftsAt(cell, i + 1, shift, still);
  FootSlope3 feet;

  if (first)
    NodeSlope(cell, cell->law, cell->a, cell->dual[0], shift, &slopes->a);
  else
    slopes->a = slopes->b;
  NodeSlope(cell, cell->law + 2, cell->b, cell->dual[2], own, &slopes->b);
  Linearise(cell, cell->law + 1, cell->mid, cell->dual[1], &slopes->mid);
  if (cell->load->arm > 0 && !cell->split)
    AddCouple(cell->load, cell->law + 1, cell->mid, cell->dual[1], &slopes->mid);
  if (cell->feet.n) {
    FootEnd3 end[2];
    memset(feet, 0, sizeof(feet));
    FootEnd(cell, cell->law, cell->a, shift, &slopes->a, &end[0]);
    FootEnd(cell, cell->law + 2, cell->b, own, &slopes->b, &end[1]);
    FeetLinearise3(&cell->rod->scene->contact, &cell->foot_cell, end, cell->fresh,
                   FootDuals(cell, i), &cell->feet, feet);
  }
  CellJacobian(cell, -1, shift, cell->law, cell->a, cell->dual[0], &slopes->a, &slopes->mid,
               cell->feet.n ? feet : NULL, left);
  CellJacobian(cell, 1, own, cell->law + 2, cell->b, cell->dual[2], &slopes->b, &slopes->mid,
               cell->feet.n ? feet : NULL, right);
}

static void TipBlock(const Cell *cell, const Slope *slope, const PetscReal shift[],
                     PetscReal by[RIGHT][FIELDS]) {
  Rod rod = cell->rod;
  TipState3 tip = TipOf(cell->load, cell->b);
  PetscReal dW[RUBS][FIELDS] = {{0}}, still[FIELDS];

  RateSlope(cell->load, cell->b, 1, ShiftsAt(cell, rod->last, shift, still), dW);
  TurnSlope(cell->load, cell->law + 2, cell->b, slope, dW);
  TipJacobian3(&rod->scene->tip, &tip, (const PetscReal(*)[FIELDS])dW, cell->fresh, TipDual(rod),
               by);
}

/* What strands need to know of the cell behind a node. */
static void KeepBehind(const Cell *cell, const Slope *mid, SpaceCell *behind) {
  const Space_ *self = (const Space_ *)cell->rod->data;

  *behind = (SpaceCell){.end_weight = cell->h * self->end_weight,
                        .mid_weight = cell->h * self->mid_weight,
                        .bow = cell->h * self->bow,
                        .g = cell->law[1].g};
  memcpy(behind->q, cell->mid->d[0], sizeof(behind->q));
  for (int i = 0; i < 4; i++) memcpy(behind->p_m[i], &mid->f[P + i][M], sizeof(behind->p_m[i]));
}

/* The rows of a node, by itself (columns FIELDS ...) and its neighbours. */
typedef PetscReal Rows[FIELDS][3 * FIELDS];

static void PutRows(Rows rows, int from, int to, PetscInt column, PetscReal part[FIELDS][FIELDS]) {
  for (int f = from; f < to; f++)
    for (int k = 0; k < FIELDS; k++) rows[f][column + k] = part[f][k];
}

static PetscErrorCode SpaceJacobian(Rod rod, const RodState *at, Mat J) {
  Space_ *self = (Space_ *)rod->data;
  PetscInt begin = PetscMax(rod->first - 1, 0);
  PetscReal left[FIELDS][FIELDS], right[FIELDS][FIELDS], by[RIGHT][FIELDS];
  Slopes slopes;
  Cell cell;
  Rows row;

  PetscFunctionBegin;
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  if (self->strands) PetscCall(SpaceStrandsPattern(rod, self->strands, at->fresh, J));
  PetscCall(PetscMemzero(row, sizeof(row)));
  if (rod->first == 0) {
    ClampBlock(rod->scene, at->t, cell.u[0], left);
    for (int f = 0; f < LEFT; f++) PetscCall(PetscArraycpy(&row[f][FIELDS], left[f], FIELDS));
  }
  for (PetscInt i = begin; i < rod->end; i++) {
    PetscInt cols[3] = {i - 1, i, i < rod->last ? i + 1 : -1}; /* -1: none, ignored */
    if (i < rod->last) {
      SpaceCellsNext(&cell, i);
      CellBlocks(&cell, i, (PetscBool)(i == begin), at->shift, &slopes, left, right);
      if (self->behind && i >= rod->first)
        KeepBehind(&cell, &slopes.mid, &self->behind[i - rod->first]);
      PutRows(row, LEFT, FIELDS, FIELDS, left);
      PutRows(row, LEFT, FIELDS, 2 * FIELDS, right);
    } else {
      TipBlock(&cell, &slopes.b, at->shift, by);
      for (int f = 0; f < RIGHT; f++)
        PetscCall(PetscArraycpy(&row[LEFT + f][FIELDS], by[f], FIELDS));
    }
    if (i >= rod->first)
      PetscCall(MatSetValuesBlocked(J, 1, &i, 3, cols, &row[0][0], INSERT_VALUES));
    PetscCall(PetscMemzero(row, sizeof(row)));
    if (i < rod->last) {
      PutRows(row, X, LEFT, 0, left);
      PutRows(row, X, LEFT, FIELDS, right);
    }
  }
  PetscCall(SpaceCellsClose(&cell));
  if (self->strands) PetscCall(SpaceStrandsJacobian(rod, self->strands, at, self->behind, J));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* What the moment and the force at a node work along: the turn 2 vec(dp p*) / |p|^2, and x. */
static void Arms(const Point *point, WideArms *arms) {
  const PetscReal f = 2 / point->size, *p = point->p;
  const PetscReal turn[3][4] = {
      {-p[1], p[0], -p[3], p[2]}, {-p[2], p[3], p[0], -p[1]}, {-p[3], -p[2], p[1], p[0]}};

  memset(arms, 0, sizeof(*arms));
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 4; j++) arms->way[i][P + j] = f * turn[i][j];
    arms->way[3 + i][X + i] = 1;
    arms->moment[i] = point->m[i] / 2;
    arms->twist += point->m[i] / 2 * point->d[0][i];
  }
}

/* A beginning that turns in a hinge, or is free, is springs so much softer than the rod for who
   counts modes or follows errors: what the first node gives way by its own moments and forces, a
   turn of e, dp = (0, e) p/2, and a place. */
static PetscErrorCode BeginSprings(Rod rod, PetscReal t, const Point *first,
                                   PetscReal gives[LEFT][RIGHT]) {
  const PetscReal softer = 1e6, *p = first->p;
  const PetscBool is_free = (PetscBool)(rod->scene->clamp == CLAMP_FREE);
  const PetscReal turn[3][4] = {
      {-p[1], p[0], -p[3], p[2]}, {-p[2], p[3], p[0], -p[1]}, {-p[3], -p[2], p[1], p[0]}};
  PetscReal length;

  PetscFunctionBegin;
  PetscCall(GrowthLength(rod->scene->growth, t, &length, NULL));
  memset(gives, 0, LEFT * sizeof(*gives));
  for (int i = 0; i < 3; i++) {
    if (is_free) gives[X + i][3 + i] = softer * PetscPowReal(length, 3);
    for (int j = 0; j < 3; j++) {
      PetscReal part = is_free ? first->d[0][i] * first->d[0][j] : 0;
      for (int k = 1; k < 3; k++) part += first->d[k][i] * first->d[k][j];
      for (int k = 0; k < 4; k++) gives[P + k][j] += softer * length * turn[i][k] / 2 * part;
    }
  }
  PetscFunctionReturn(0);
}

/* The same matrix, not assembled: each cell is eliminated as soon as it is known, or, on several
   ranks, where modes are counted in it, kept for the first of them. */
static PetscErrorCode SpaceEliminate(Rod rod, const RodState *at, Elimination elimination) {
  const PetscBool keeps = EliminationKeeps(elimination),
                  gives_way = (PetscBool)(rod->scene->clamp != CLAMP_HELD);
  const PetscInt begin = PetscMax(rod->first - 1, 0);
  WideLine line = EliminationWide(elimination);
  PetscReal beside[2][FIELDS][FIELDS], (*left)[FIELDS] = beside[0], (*right)[FIELDS] = beside[1],
                                       by[RIGHT][FIELDS], gives[LEFT][RIGHT];
  const PetscBool ends = (PetscBool)(rod->end > rod->last);
  WideArms arms;
  Slopes slopes;
  Cell cell;

  PetscFunctionBegin;
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  WideBegin(line);
  if (gives_way && rod->first == 0) PetscCall(BeginSprings(rod, at->t, cell.b, gives));
  if (gives_way && !keeps) WideSpring(line, (const PetscReal(*)[RIGHT])gives);
  for (PetscInt i = begin; i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (i >= rod->first) WideBlocks(line, &left, &right);
    CellBlocks(&cell, i, (PetscBool)(i == begin), at->shift, &slopes, left, right);
    if (i < rod->first) continue;
    Arms(cell.a, &arms);
    WideArm(line, &arms);
    (keeps ? WideKeep : WideCell)(line);
  }
  if (ends) {
    Arms(cell.b, &arms);
    TipBlock(&cell, &slopes.b, at->shift, by);
  }
  if (ends && !keeps) {
    WideArm(line, &arms);
    WideEnd(line, (const PetscReal(*)[FIELDS])by);
  }
  PetscCall(SpaceCellsClose(&cell));
  if (keeps)
    PetscCall(EliminationGather(elimination, gives_way ? (const PetscReal(*)[RIGHT])gives : NULL,
                                &arms, ends ? (const PetscReal(*)[FIELDS])by : NULL));
  PetscFunctionReturn(0);
}

/* ---- exact Coulomb friction, and what is remembered ---- */

/* Adds what the points of a cell and its feet bear; end: what its first point does, and then its
   last one. */
static void AddForces(const Cell *cell, RodForces *end, RodForces *sum) {
  const Space_ *self = (const Space_ *)cell->rod->data;
  const Point *at[3] = {NULL, cell->mid, cell->b};
  const PetscReal weight[3] = {self->end_weight, self->mid_weight, self->end_weight};

  for (int k = 0; k < 3; k++) {
    const PetscReal length = cell->h * weight[k] * cell->law[k].g;
    if (at[k])
      LoadParts3(cell->load, &at[k]->at, cell->dual[k], end->friction, end->walls, &end->moved);
    for (int d = 0; d < 3; d++) {
      sum->friction[d] += length * end->friction[d];
      sum->walls[d] += length * end->walls[d];
    }
    sum->moved += length * end->moved;
  }
  for (PetscInt k = 0; k < cell->feet.n; k++)
    for (int d = 0; d < 3; d++) {
      const Touch3 *touch = &cell->feet.touch[k];
      sum->walls[d] += cell->feet.foot[k].force[d];
      if (touch->moves) sum->moved += cell->feet.foot[k].force[d] * touch->v[d];
    }
}

/* Adds what the tip bears. */
static void AddTip(const Cell *cell, RodForces *sum) {
  Rod rod = cell->rod;
  const TipState3 tip = TipOf(cell->load, cell->b);
  const PetscInt last = 2 * rod->last + 1;

  sum->moved += TipWalls3(&rod->scene->tip, &tip, TipDual(rod), sum->tip);
  for (int d = 0; d < 3; d++) sum->walls[d] += sum->tip[d];
  for (int d = 0; d < 3 && cell->push && rod->scene->tip.type == TIP_FREE; d++) {
    sum->tip[d] += cell->push[last][d];
    if (cell->couple) sum->tip[SPIN] += cell->couple[last][d] * cell->b->d[0][d];
  }
}

static PetscErrorCode SpaceBears(Rod rod, const RodState *at, RodForces *sum) {
  RodForces end = {.moved = 0};
  Cell cell;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (i < rod->first) continue;
    if (i == rod->first)
      LoadParts3(cell.load, &cell.a->at, cell.dual[0], end.friction, end.walls, &end.moved);
    AddForces(&cell, &end, sum);
  }
  if (rod->end == rod->last + 1) AddTip(&cell, sum);
  PetscCall(SpaceCellsClose(&cell));
  PetscFunctionReturn(0);
}

/* Moves the shifts of exact Coulomb friction; creep is the largest speed of what is held. (The
   clamped end is not held unless it slides: see frame.c.) */
static PetscErrorCode SpaceHold(Rod rod, const RodState *at, PetscReal seen, PetscReal *creep) {
  Space_ *self = (Space_ *)rod->data;
  PetscBool ends = (PetscBool)(self->end_weight > 0);
  PetscInt first = PetscMax(rod->first - 1, 0);
  RodForces sum;
  Cell cell;

  PetscFunctionBegin;
  *creep = 0;
  PetscCall(SpaceBears(rod, at, &sum));
  RodKeepBorne(rod, &sum);
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  for (PetscInt i = first; i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (i == first && ends && (i > 0 || cell.law->c != 0 || rod->scene->clamp == CLAMP_FREE))
      *creep = LargerOf(*creep, LoadHold3(cell.load, &cell.a->at, seen, cell.dual[0]));
    *creep = LargerOf(*creep, LoadHold3(cell.load, &cell.mid->at, seen, cell.dual[1]));
    if (ends) *creep = LargerOf(*creep, LoadHold3(cell.load, &cell.b->at, seen, cell.dual[2]));
    if (cell.feet.n && self->foot_dual)
      *creep =
          LargerOf(*creep, FeetHold3(&rod->scene->contact, &cell.feet, seen, FootDuals(&cell, i)));
  }
  if (rod->end == rod->last + 1) {
    TipState3 tip = TipOf(cell.load, cell.b);
    *creep = LargerOf(*creep, TipHold3(&rod->scene->tip, &tip, seen, TipDual(rod)));
  }
  PetscCall(SpaceCellsClose(&cell));
  SpaceCellsForget(self);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, creep, 1, MPIU_REAL, MPI_MAX, rod->scene->comm));
  PetscFunctionReturn(0);
}

/* The duals of each node and of the middle of the cell on its right, as a whole, as the frame's
   (frame.c); the latter's of the last node is the tip's own. Behind them those of the cell's feet.
 */
enum { OF_DUAL = sizeof(FrictionDual4) / sizeof(PetscReal) };

static PetscInt RememberedOf(const Load *load) {
  return 2 * OF_DUAL * load->duals3;
}

static PetscReal *Remembered(Rod rod, PetscInt i, PetscInt k) {
  const Space_ *self = (const Space_ *)rod->data;
  const PetscInt of_points = RememberedOf(&rod->scene->load), cell = i - rod->first + 1;
  FrictionDual4 *dual = Duals(self, 2 * cell) + k / OF_DUAL;

  if (k >= of_points) dual = self->foot_dual + cell * WALL_SLOTS + (k - of_points) / OF_DUAL;
  return (PetscReal *)dual + k % OF_DUAL;
}

static PetscErrorCode SpaceRemember(Rod rod, Vec memory) {
  PetscReal *m;

  PetscFunctionBegin;
  PetscCall(VecGetArray(memory, &m));
  for (PetscInt i = rod->first; i < rod->end; i++)
    for (PetscInt k = 0; k < rod->memory; k++)
      m[(i - rod->first) * rod->memory + k] = *Remembered(rod, i, k);
  PetscCall(VecRestoreArray(memory, &m));
  PetscFunctionReturn(0);
}

/* (The cells beside the owned nodes are remembered here too.) */
static PetscErrorCode SpaceRecall(Rod rod, Vec memory) {
  const PetscReal *m;
  Vec local;
  PetscInt from = PetscMax(rod->first - 1, 0);
  DM da;

  PetscFunctionBegin;
  PetscCall(VecGetDM(memory, &da));
  PetscCall(DMGetLocalVector(da, &local));
  PetscCall(DMGlobalToLocal(da, memory, INSERT_VALUES, local));
  PetscCall(VecGetArrayRead(local, &m));
  for (PetscInt i = from; i <= PetscMin(rod->end, rod->last); i++)
    for (PetscInt k = 0; k < rod->memory; k++)
      *Remembered(rod, i, k) = m[(i - from) * rod->memory + k];
  PetscCall(VecRestoreArrayRead(local, &m));
  PetscCall(DMRestoreLocalVector(da, &local));
  SpaceCellsForget((Space_ *)rod->data);
  PetscFunctionReturn(0);
}

/* ---- nodes ---- */

/* m_k = d_k.m, and d_k'(dp).m + d_k.dm. */
static void SpaceMoments(const PetscReal u[], const PetscReal change[], PetscReal m[3],
                         PetscReal dm[3]) {
  const PetscReal *p = u + P, size = QuaternionSize(p);
  PetscReal d[3][3], D[3][4];

  Directors(p, size, d);
  for (int k = 0; k < 3; k++) {
    DirectorSlope(p, size, d[k], k, D);
    m[k] = dm[k] = 0;
    for (int i = 0; i < 3; i++) {
      m[k] += d[k][i] * u[M + i];
      dm[k] += d[k][i] * change[M + i];
      for (int j = 0; j < 4; j++) dm[k] += D[i][j] * change[P + j] * u[M + i];
    }
  }
}

/* Is an owned node turned by half a turn or more, p0.p1 <= 0? The same on every rank. */
static PetscErrorCode SpaceTurned(Rod rod, Vec U0, Vec U1, PetscBool *turned) {
  const PetscReal(*a)[FIELDS], (*b)[FIELDS];

  PetscFunctionBegin;
  *turned = PETSC_FALSE;
  PetscCall(DMDAVecGetArrayRead(rod->da, U0, (void *)&a));
  PetscCall(DMDAVecGetArrayRead(rod->da, U1, (void *)&b));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    PetscReal dot = 0;
    for (int k = 0; k < 4; k++) dot += a[i][P + k] * b[i][P + k];
    if (!(dot > 0)) *turned = PETSC_TRUE;
  }
  PetscCall(DMDAVecRestoreArrayRead(rod->da, U0, (void *)&a));
  PetscCall(DMDAVecRestoreArrayRead(rod->da, U1, (void *)&b));
  if (!rod->alone)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, turned, 1, MPIU_BOOL, MPI_LOR, rod->scene->comm));
  PetscFunctionReturn(0);
}

static PetscErrorCode SpaceSet(Rod rod, PetscReal t, const Node *nodes, Vec U) {
  PetscReal(*u)[FIELDS];

  PetscFunctionBegin;
  PetscCall(DMDAVecGetArray(rod->da, U, &u));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    const Node *node = &nodes[i - rod->first];
    PetscCall(PetscArraycpy(u[i] + X, node->x3, 3));
    PetscCall(PetscArraycpy(u[i] + P, node->p, 4));
    PetscCall(PetscArraycpy(u[i] + M, node->m3, 3));
    PetscCall(PetscArraycpy(u[i] + N, node->n3, 3));
  }
  PetscCall(DMDAVecRestoreArray(rod->da, U, &u));
  PetscFunctionReturn(0);
}

static PetscErrorCode SpaceGet(Rod rod, PetscReal t, Vec U, Vec U_t, Node *nodes) {
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS] = NULL;

  PetscFunctionBegin;
  PetscCall(DMDAVecGetArrayRead(rod->da, U, &u));
  if (U_t) PetscCall(DMDAVecGetArrayRead(rod->da, U_t, &u_t));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    Node *node = &nodes[i - rod->first];
    PetscCall(PetscMemzero(node, sizeof(*node)));
    PetscCall(PetscArraycpy(node->x3, u[i] + X, 3));
    PetscCall(PetscArraycpy(node->p, u[i] + P, 4));
    PetscCall(PetscArraycpy(node->m3, u[i] + M, 3));
    PetscCall(PetscArraycpy(node->n3, u[i] + N, 3));
    if (U_t) {
      PetscCall(PetscArraycpy(node->x3_t, u_t[i] + X, 3));
      PetscCall(PetscArraycpy(node->p_t, u_t[i] + P, 4));
      PetscCall(PetscArraycpy(node->m3_t, u_t[i] + M, 3));
    }
    RodPlanePart(node);
  }
  if (U_t) PetscCall(DMDAVecRestoreArrayRead(rod->da, U_t, &u_t));
  PetscCall(DMDAVecRestoreArrayRead(rod->da, U, &u));
  PetscFunctionReturn(0);
}

/* A state on the way along the initial shape: x, its rate by growth without friction, and p. */
typedef struct {
  PetscReal x[3], x_t[3], p[4];
} Shape_;
enum { SHAPE_REALS = sizeof(Shape_) / sizeof(PetscReal) };

/* Twist and bends of the initial shape, with the natural ones, per length. */
static PetscErrorCode InitialStrains(Scene scene, PetscReal s, PetscReal g, PetscReal u0[3],
                                     PetscReal u[3]) {
  PetscReal g0;

  PetscFunctionBegin;
  PetscCall(GrowthStretch(scene->growth, 1, &s, 0, &g0, NULL, NULL));
  ShapeStrains(&scene->shape, s, g0, u);
  PetscCall(CurvatureStrains(&scene->curvature, scene->growth, s, 0, u0, NULL));
  for (int k = 0; k < 3; k++) u[k] = (u[k] + u0[k]) * g0 / g; /* at other times: the same angles */
  PetscFunctionReturn(0);
}

static PetscErrorCode ShapeSlope(Scene scene, PetscReal s, PetscReal t, const Shape_ *at,
                                 Shape_ *slope) {
  PetscReal g, g_t, u0[3], u[3], d[3][3];

  PetscFunctionBegin;
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, &g, &g_t, NULL));
  PetscCall(InitialStrains(scene, s, g, u0, u));
  Directors(at->p, QuaternionSize(at->p), d);
  QuaternionTurn(at->p, u, slope->p);
  for (int k = 0; k < 4; k++) slope->p[k] *= g / 2;
  for (int k = 0; k < 3; k++) {
    slope->x[k] = g * d[0][k];
    slope->x_t[k] = g_t * d[0][k];
  }
  PetscFunctionReturn(0);
}

/* A step of the classical method of Runge and Kutta. */
static PetscErrorCode ShapeStep(Scene scene, PetscReal s, PetscReal h, PetscReal t, Shape_ *at) {
  static const PetscReal part[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  Shape_ slope[4], here;

  PetscFunctionBegin;
  for (int stage = 0; stage < 4; stage++) {
    here = *at;
    for (int k = 0; k < SHAPE_REALS && stage; k++)
      ((PetscReal *)&here)[k] += part[stage] * h * ((PetscReal *)&slope[stage - 1])[k];
    PetscCall(ShapeSlope(scene, s + part[stage] * h, t, &here, &slope[stage]));
  }
  for (int stage = 0; stage < 4; stage++)
    for (int k = 0; k < SHAPE_REALS; k++)
      ((PetscReal *)at)[k] += h * weight[stage] * ((PetscReal *)&slope[stage])[k];
  PetscFunctionReturn(0);
}

/* What there is at a label of the initial shape. */
static PetscErrorCode PlaceAt(Scene scene, PetscReal s, PetscReal t, SpinPlace *place) {
  PetscReal B;

  PetscFunctionBegin;
  place->s = s;
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, &place->g, NULL, NULL));
  PetscCall(InitialStrains(scene, s, place->g, place->u0, place->u));
  PetscCall(SceneStiffness(scene, s, t, &B, NULL));
  SceneStiffnesses(scene, B, place->S);
  PetscFunctionReturn(0);
}

/* The initial shape at n labels: where friction does not feel the spin, turned until it rests. */
static PetscErrorCode InitialPlaces(Scene scene, PetscReal t, PetscInt n, SpinPlace place[],
                                    PetscReal turn[]) {
  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) PetscCall(PlaceAt(scene, place[i].s, t, &place[i]));
  PetscCall(PetscArrayzero(turn, n));
  if (scene->load.radius == 0 && scene->clamp != CLAMP_FREE)
    PetscCall(SpinRest(n, place, scene->tip.torque, TipPoints(&scene->tip), turn));
  PetscFunctionReturn(0);
}

/* What the slope at place i of n takes from the three places from first on. */
static PetscInt PlaceSlope(PetscInt n, const SpinPlace place[], PetscInt i, PetscReal D[3]) {
  const PetscInt first = PetscMax(0, PetscMin(n - 3, i - 1));
  const PetscReal at[3] = {place[first].s, place[first + 1].s, place[first + 2].s};

  LagrangeSlopes(3, at, place[i].s, D);
  return first;
}

/* Moments about the directors of place i of n, and its twist and bends. */
static void PlaceMoments(PetscInt n, const SpinPlace place[], const PetscReal turn[], PetscInt i,
                         PetscReal m[3], PetscReal u[3]) {
  PetscReal D[3], slope = 0;
  const PetscInt first = PlaceSlope(n, place, i, D);

  for (int k = 0; k < 3; k++) slope += D[k] * turn[first + k];
  SpinTurn(&place[i], turn[i], slope, u);
  for (int k = 0; k < 3; k++) m[k] = place[i].S[k] * (u[k] - place[i].u0[k]);
}

/* Moment and force of place i of n, whose directors are d: the force along d1 is that of the
   straight rod, n = n.d1 d1 - m'/g x d1 across it, with (sum m_k d_k)' = sum m_k' d_k + g u x m. */
static void InitialForces(PetscInt n, const SpinPlace place[], const PetscReal turn[], PetscInt i,
                          const PetscReal d[3][3], PetscReal along, Node *node) {
  PetscReal m[3], u[3], other[3], D[3], curl[3], slope[3], by[3];
  const PetscInt first = PlaceSlope(n, place, i, D);

  PlaceMoments(n, place, turn, i, m, u);
  for (int j = 0; j < 3; j++) {
    node->m3[j] = m[0] * d[0][j] + m[1] * d[1][j] + m[2] * d[2][j];
    curl[j] = place[i].g * (u[0] * d[0][j] + u[1] * d[1][j] + u[2] * d[2][j]);
  }
  Cross3(curl, node->m3, slope);
  for (int at = 0; at < 3; at++) {
    PlaceMoments(n, place, turn, first + at, m, other);
    for (int j = 0; j < 3; j++)
      slope[j] += D[at] * (m[0] * d[0][j] + m[1] * d[1][j] + m[2] * d[2][j]);
  }
  Cross3(slope, d[0], by);
  for (int j = 0; j < 3; j++) node->n3[j] = along * d[0][j] - by[j] / place[i].g;
}

/* The node at place i of n: the curve's own frame, turned. */
static void InitialNode(PetscInt n, const SpinPlace place[], const PetscReal turn[], PetscInt i,
                        const Shape_ *at, PetscReal along, Node *node) {
  const PetscReal c = PetscCosReal(turn[i] / 2), s = PetscSinReal(turn[i] / 2), *p = at->p;
  const PetscReal turned[4] = {c * p[0] - s * p[1], c * p[1] + s * p[0], c * p[2] + s * p[3],
                               c * p[3] - s * p[2]};
  PetscReal d[3][3];

  memset(node, 0, sizeof(*node));
  memcpy(node->x3, at->x, sizeof(node->x3));
  memcpy(node->x3_t, at->x_t, sizeof(node->x3_t));
  memcpy(node->p, turned, sizeof(node->p));
  Directors(turned, QuaternionSize(turned), d);
  InitialForces(n, place, turn, i, (const PetscReal(*)[3])d, along, node);
  RodPlanePart(node);
}

/* The scene's initial shape at the owned nodes; see RodInitialNodes(). Every rank goes along the
   whole rod, in steps that are much shorter than its cells. */
static PetscErrorCode SpaceInitial(Rod rod, PetscReal t, Node *nodes) {
  enum { STEPS = 4000 };
  Scene scene = rod->scene;
  const PetscReal *s = scene->mesh.s;
  const PetscInt fine = PetscMax(1, STEPS / rod->last), n = rod->last * fine + 1;
  Shape_ at = {.p = {1}};
  PetscReal *force, *turn;
  SpinPlace *place;

  PetscFunctionBegin;
  SpaceClampTurn(&scene->space, t, at.p);
  PetscCall(PetscMalloc3(rod->last + 1, &force, n, &place, n, &turn));
  PetscCall(StraightForce(scene, rod->last + 1, s, t, force));
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt cell = PetscMin(i / fine, rod->last - 1);
    place[i].s = s[cell] + (s[cell + 1] - s[cell]) * (i - cell * fine) / fine;
  }
  PetscCall(InitialPlaces(scene, t, n, place, turn));
  for (PetscInt i = 0; i < rod->end; i++) {
    for (PetscInt k = 0; i && k < fine; k++) {
      PetscReal h = (s[i] - s[i - 1]) / fine;
      PetscCall(ShapeStep(scene, s[i - 1] + k * h, h, t, &at));
    }
    if (i >= rod->first)
      InitialNode(n, place, turn, i * fine, &at, -force[i], &nodes[i - rod->first]);
  }
  PetscCall(PetscFree3(force, place, turn));
  PetscFunctionReturn(0);
}

/* p1 and m1 are made of products of what is across in both directions, and on a rod that is bent in
   one plane, however tilted, no more than what these leave of round-off. And a place across that is
   small by chance is measured against what its slope makes along the rod. Where moments bend a rod
   out of its plane in which it is, but for round-off, as of one that is twisted there, they drive
   it by their part of those in it. */
static void SpaceScale(PetscReal size[]) {
  const PetscReal tilt = size[P + 2] * size[P + 3], part = 0.1, driven = 1e-3,
                  most = PetscMax(size[M + 1], size[M + 2]);

  if (size[M + 1] > 0 && size[M + 2] > 0) {
    const PetscReal about_2 = driven * (size[M + 1] / most),
                    about_3 = driven * (size[M + 2] / most);
    size[X + 1] = PetscMax(size[X + 1], about_3 * size[X + 2]);
    size[X + 2] = PetscMax(size[X + 2], about_2 * size[X + 1]);
    size[P + 2] = PetscMax(size[P + 2], about_2 * size[P + 3]);
    size[P + 3] = PetscMax(size[P + 3], about_3 * size[P + 2]);
  }

  size[P + 1] = PetscMax(size[P + 1], tilt);
  size[M] = PetscMax(size[M], size[M + 1] * size[P + 3] + size[M + 2] * size[P + 2]);
  size[X + 1] = PetscMax(size[X + 1], part * size[P + 3] * size[X]);
  size[X + 2] = PetscMax(size[X + 2], part * size[P + 2] * size[X]);
}

/* In space a rod that nothing holds may spin about itself. */
static const char *SpaceRefuses(Scene scene) {
  return scene->clamp == CLAMP_FREE && scene->load.radius == 0
             ? "-clamp_type free: nothing keeps a rod in space from spinning about itself; give it "
               "a -friction_radius"
             : NULL;
}

/* Does the couple of friction jump within cells where the rod stops turning? Not if beta is such
   that it changes along many, nor if growth moves the rod all along. */
static PetscBool Kinks(Scene scene) {
  const PetscReal nearly_exact = 1e-6;
  const Load *load = &scene->load;

  return (PetscBool)(load->radius > 0 && scene->growth->still &&
                     (load->limit || load->friction.beta < nearly_exact));
}

static PetscErrorCode SpaceCreate(Rod rod) {
  PetscInt choice, points = 2 * (rod->end - rod->first + 2);
  Space_ *self;

  PetscFunctionBegin;
  PetscCall(OptionWord("-rod_order", &choice, NULL));
  PetscCall(PetscNew(&self));
  rod->data = self;
  rod->order = choice ? 4 : 2;
  self->end_weight = choice ? 1. / 6 : 0;
  self->mid_weight = choice ? 4. / 6 : 1;
  self->bow = choice ? 1. / 8 : 0;
  self->time = PETSC_MIN_REAL;
  rod->memory = RememberedOf(&rod->scene->load);
  self->duals = rod->scene->load.duals3;
  SpaceCellsForget(self);
  PetscCall(
      PetscCalloc3(points, &self->law, points * self->duals, &self->dual, points, &self->point));
  if (ContactWallsRub(&rod->scene->contact) && ContactHasRidges(&rod->scene->contact)) {
    PetscCall(PetscCalloc1(points / 2 * WALL_SLOTS, &self->foot_dual));
    rod->memory += OF_DUAL * WALL_SLOTS;
  }
  if (Kinks(rod->scene)) PetscCall(PetscCalloc1(rod->end - rod->first + 2, &self->split));
  if (rod->scene->contact.self) {
    rod->coupled = PETSC_TRUE;
    PetscCall(SpaceStrandsCreate(rod, &self->strands));
    PetscCall(PetscCalloc1(rod->end - rod->first, &self->behind));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode SpaceDestroy(Rod rod) {
  Space_ *self = (Space_ *)rod->data;

  PetscFunctionBegin;
  PetscCall(PetscFree3(self->law, self->dual, self->point));
  PetscCall(PetscFree(self->foot_dual));
  PetscCall(SpaceStrandsDestroy(&self->strands));
  PetscCall(PetscFree(self->split));
  PetscCall(PetscFree(self->behind));
  PetscCall(PetscFree(rod->data));
  PetscFunctionReturn(0);
}

const RodModel rod_space = {
    .name = "space",
    .space = PETSC_TRUE,
    .fields = FIELDS,
    .stencil = 1,
    .field = {"x1", "x2", "x3", "p0", "p1", "p2", "p3", "m1", "m2", "m3", "n1", "n2", "n3"},
    .followed = {PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE,
                 PETSC_TRUE},
    .group = {ALONG, ACROSS_2, ACROSS_3, ALONG, TWIST, ACROSS_3, ACROSS_2, TWIST, ACROSS_3,
              ACROSS_2, ALONG, ACROSS_2, ACROSS_3},
    .pairs = 4,
    .pair = {{1, 2, 1}, {P + 3, P + 2, -1}, {M + 2, M + 1, -1}, {N + 1, N + 2, 1}},
    .halves = {LEFT, RIGHT},
    .refuses = SpaceRefuses,
    .create = SpaceCreate,
    .destroy = SpaceDestroy,
    .initial = SpaceInitial,
    .scale = SpaceScale,
    .set = SpaceSet,
    .get = SpaceGet,
    .residual = SpaceResidual,
    .defect = SpaceDefect,
    .moments = SpaceMoments,
    .turned = SpaceTurned,
    .hold = SpaceHold,
    .bears = SpaceBears,
    .remember = SpaceRemember,
    .recall = SpaceRecall,
    .jacobian = SpaceJacobian,
    .eliminate = SpaceEliminate};
