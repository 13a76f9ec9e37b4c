/* The mixed model, the paper's unknowns x1, x2, lambda, as a discrete elastic rod, second order
   (Bergou et al., Discrete elastic rods, 2008): nodes x_i, edges e_i = x_i - x_{i-1} of prescribed
   length l_i, lambda_i on edge i.

     energy      E = sum_k B_k (K_k - k0_k w_k)^2 / (2 w_k),
                 K = 2 tan(psi/2) = 2 a x b / (|a||b| + a.b)
     balance     dE/dx_i + M_i F(v_i) + flux_{i+1} - flux_i = 0,  flux_i = 2 lambda_i e_i / h_i;
                 at the tip less the force on it
     constraint  (|e_i|^2 - l_i^2) / l_i = 0
     clamp       x_0 = 0, lambda_0 = 0 (there is no such edge)

   psi is the turn from edge a = e_k to b = e_{k+1}, w_k = (l_k + l_{k+1})/2; at the clamp a = (1,0)
   and w_0 = l_1/2; at the tip there is no term, so kappa(1) = kappa'(1) = 0. lambda is the paper's
   on the straight rod; on a bent one the paper's is larger by kappa^2/(2g), as its energy is
   another. */
#include "rod/rod.h"

enum { X1, X2, LAMBDA, FIELDS };
enum { REACH = 2, WIDTH = 2 * REACH + 1 };

typedef struct {
  PetscReal time;
  PetscReal *length;  /* l of edge first - 1 + k, for edges first - 1 .. end + 1 where they exist */
  PetscReal *natural; /* k0 at turn first - 1 + k, for turns first - 1 .. end */
  PetscReal *bend;    /* B there */
  LoadDual *dual;     /* owned nodes, and one more for the tip's resistance */
} Mixed;

/* K and its first and second derivatives by (a, b), for one turn. */
typedef struct {
  PetscReal K, slope[4], curve[4][4];
} Turn;

static void TurnValue(const PetscReal a[2], const PetscReal b[2], Turn *turn) {
  PetscReal la = hypot(a[0], a[1]), lb = hypot(b[0], b[1]);
  PetscReal N = a[0] * b[1] - a[1] * b[0], D = la * lb + a[0] * b[0] + a[1] * b[1];
  PetscReal N1[4] = {b[1], -b[0], -a[1], a[0]}, D1[4];
  for (int d = 0; d < 2; d++) {
    D1[d] = lb * a[d] / la + b[d];
    D1[2 + d] = la * b[d] / lb + a[d];
  }
  turn->K = 2 * N / D;
  for (int i = 0; i < 4; i++) turn->slope[i] = 2 * (N1[i] - N * D1[i] / D) / D;
}

static void TurnCurve(const PetscReal a[2], const PetscReal b[2], Turn *turn) {
  PetscReal la = hypot(a[0], a[1]), lb = hypot(b[0], b[1]);
  PetscReal N = a[0] * b[1] - a[1] * b[0], D = la * lb + a[0] * b[0] + a[1] * b[1];
  PetscReal N1[4] = {b[1], -b[0], -a[1], a[0]}, D1[4], N2[4][4] = {{0}}, D2[4][4];
  N2[0][3] = N2[3][0] = 1;
  N2[1][2] = N2[2][1] = -1;
  for (int d = 0; d < 2; d++) {
    D1[d] = lb * a[d] / la + b[d];
    D1[2 + d] = la * b[d] / lb + a[d];
    for (int e = 0; e < 2; e++) {
      D2[d][e] = lb / la * ((d == e) - a[d] * a[e] / (la * la));
      D2[2 + d][2 + e] = la / lb * ((d == e) - b[d] * b[e] / (lb * lb));
      D2[d][2 + e] = D2[2 + e][d] = a[d] * b[e] / (la * lb) + (d == e);
    }
  }
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++)
      turn->curve[i][j] = 2 *
                          (N2[i][j] - (N1[i] * D1[j] + D1[i] * N1[j]) / D - N * D2[i][j] / D +
                           2 * N * D1[i] * D1[j] / (D * D)) /
                          D;
}

static inline PetscReal EdgeLength(const Mixed *self, Rod rod, PetscInt i) {
  return self->length[i - rod->first + 1];
}

/* w_k, the length that turn k is spread over */
static PetscReal TurnWidth(const Mixed *self, Rod rod, PetscInt k) {
  return ((k ? EdgeLength(self, rod, k) : 0) + EdgeLength(self, rod, k + 1)) / 2;
}

static inline PetscReal TurnStiffness(const Mixed *self, Rod rod, PetscInt k) {
  return self->bend[k - rod->first + 1];
}

/* The moment at turn k: B times its curvature less the natural one. */
static PetscReal TurnMoment(const Mixed *self, Rod rod, PetscInt k, const Turn *turn) {
  return TurnStiffness(self, rod, k) *
         (turn->K / TurnWidth(self, rod, k) - self->natural[k - rod->first + 1]);
}

/* M_i, the length whose friction acts on node i */
static PetscReal NodeLength(const Mixed *self, Rod rod, PetscInt i) {
  return (EdgeLength(self, rod, i) + (i < rod->last ? EdgeLength(self, rod, i + 1) : 0)) / 2;
}

static PetscErrorCode LengthsAt(Rod rod, PetscReal t) {
  Mixed *self = (Mixed *)rod->data;
  PetscInt from = PetscMax(1, rod->first - 1), to = PetscMin(rod->last, rod->end + 1);

  PetscFunctionBegin;
  if (self->time == t) PetscFunctionReturn(0);
  for (PetscInt i = from; i <= to; i++) {
    PetscReal p[2];
    PetscCall(GrowthArc(rod->scene->growth, 2, &rod->scene->mesh.s[i - 1], t, p, NULL));
    self->length[i - rod->first + 1] = p[1] - p[0];
  }
  for (PetscInt k = PetscMax(0, rod->first - 1); k <= PetscMin(rod->last, rod->end); k++) {
    const PetscReal *s = rod->scene->mesh.s, at = k ? s[k] : s[1] / 4; /* 0: in half of edge 1 */
    PetscCall(SceneCurvature(rod->scene, at, t, &self->natural[k - rod->first + 1], NULL));
    PetscCall(SceneStiffness(rod->scene, at, t, &self->bend[k - rod->first + 1], NULL));
  }
  self->time = t;
  PetscFunctionReturn(0);
}

static void Edge(const PetscReal (*u)[FIELDS], PetscInt i, PetscReal e[2]) {
  e[0] = u[i][X1] - u[i - 1][X1];
  e[1] = u[i][X2] - u[i - 1][X2];
}

/* The two edges of turn k. */
static void TurnEdges(const PetscReal (*u)[FIELDS], PetscInt k, PetscReal a[2], PetscReal b[2]) {
  a[0] = 1;
  a[1] = 0;
  if (k) Edge(u, k, a);
  Edge(u, k + 1, b);
}

/* By how much the rod turns from the middle of the last edge to the tip, where there is no moment.
 */
static PetscReal TipTurn(const Mixed *self, Rod rod) {
  return self->natural[rod->last - rod->first + 1] * EdgeLength(self, rod, rod->last) / 2;
}

static void Rotate(PetscReal e[2], PetscReal angle) {
  PetscReal x = e[0], c = PetscCosReal(angle), s = PetscSinReal(angle);

  e[0] = c * x - s * e[1];
  e[1] = s * x + c * e[1];
}

/* The edge that the tangent of node i is taken from: between its neighbours. */
static void Across(Rod rod, const PetscReal (*u)[FIELDS], PetscInt i, PetscReal e[2]) {
  const PetscInt next = PetscMin(i + 1, rod->last);
  e[0] = u[next][X1] - u[i - 1][X1];
  e[1] = u[next][X2] - u[i - 1][X2];
}

/* Node i and its velocity, v = x_t + c q, with q by central differences; slide is c over the length
   of these. u_t NULL: at rest. */
static void PlaceAt(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                    const PetscReal (*u_t)[FIELDS], PetscInt i, Place *at, PetscReal *slide) {
  PetscReal e[2], size, c = GrowthSlide(rod->scene->growth, rod->scene->mesh.s[i], self->time);

  Across(rod, u, i, e);
  size = hypot(e[0], e[1]);
  if (i == rod->last) Rotate(e, TipTurn(self, rod));
  *slide = c != 0 && i < rod->last ? c / (2 * NodeLength(self, rod, i)) : 0;
  *at = (Place){.t = self->time};
  for (int d = 0; d < 2; d++) {
    at->x[d] = u[i][d];
    at->q[d] = e[d] / size;
    at->v[d] = (u_t ? u_t[i][d] : 0) + *slide * e[d];
  }
}

/* The tip as its force sees it. */
static TipState TipAt(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                      const PetscReal (*u_t)[FIELDS]) {
  PetscReal slide;
  TipState tip = {.theta = 0};

  PlaceAt(self, rod, u, u_t, rod->last, &tip.at, &slide);
  return tip;
}

/* The tip's resistance remembers behind what the nodes do. */
static LoadDual *TipDual(const Mixed *self, Rod rod) {
  return self->dual + (rod->end - rod->first);
}

/* Residual of the balance at node i. */
static void BalanceResidual(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                            const PetscReal (*u_t)[FIELDS], PetscInt i, PetscReal r[2]) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscReal a[2], b[2], drag[2], slide;
  Place at;
  Turn turn;

  PlaceAt(self, rod, u, u_t, i, &at, &slide);
  LoadForce(&rod->scene->load, &at, &self->dual[i - rod->first], drag);
  for (int d = 0; d < 2; d++) r[d] = NodeLength(self, rod, i) * drag[d];
  for (PetscInt k = i - 1; k <= PetscMin(i + 1, rod->last - 1); k++) {
    PetscReal force;
    TurnEdges(u, k, a, b);
    TurnValue(a, b, &turn);
    force = TurnMoment(self, rod, k, &turn);
    for (int d = 0; d < 2; d++) { /* x_i ends edge i (+) and begins edge i + 1 (-) */
      if (k == i - 1) r[d] += force * turn.slope[2 + d];
      if (k == i) r[d] += force * (turn.slope[d] - turn.slope[2 + d]);
      if (k == i + 1) r[d] -= force * turn.slope[d];
    }
  }
  for (PetscInt e = i; e <= PetscMin(i + 1, rod->last); e++) {
    Edge(u, e, a);
    for (int d = 0; d < 2; d++)
      r[d] += (e == i ? -1 : 1) * 2 * u[e][LAMBDA] * a[d] / (s[e] - s[e - 1]);
  }
  if (i == rod->last && rod->scene->tip.force != 0) {
    TipState tip = TipAt(self, rod, u, u_t);
    TipForce(&rod->scene->tip, &tip, TipDual(self, rod), a);
    for (int d = 0; d < 2; d++) r[d] -= a[d];
  }
}

static PetscErrorCode MixedResidual(Rod rod, const RodState *at, Vec F) {
  Mixed *self = (Mixed *)rod->data;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS];
  PetscReal(*f)[FIELDS], e[2];
  Vec local[2];

  PetscFunctionBegin;
  PetscCall(LengthsAt(rod, at->t));
  PetscCall(RodOpen(rod, at->U, &local[0], &u));
  PetscCall(RodOpen(rod, at->U_t, &local[1], &u_t));
  PetscCall(DMDAVecGetArray(rod->da, F, &f));
  if (!rod->first) PetscCall(PetscArraycpy(f[0], u[0], FIELDS));
  for (PetscInt i = PetscMax(1, rod->first); i < rod->end; i++) {
    PetscReal l = EdgeLength(self, rod, i);
    BalanceResidual(self, rod, u, u_t, i, f[i]);
    Edge(u, i, e);
    f[i][LAMBDA] = (e[0] * e[0] + e[1] * e[1]) / l - l;
  }
  PetscCall(DMDAVecRestoreArray(rod->da, F, &f));
  PetscCall(RodClose(rod, &local[0], &u));
  PetscCall(RodClose(rod, &local[1], &u_t));
  PetscFunctionReturn(0);
}

/* The derivative of node i's rows by node i - REACH + k stands in columns k FIELDS ... */
typedef PetscReal Row[FIELDS][WIDTH * FIELDS];

/* Adds value to d(r_d)/d(edge e, component c), as seen from node i. */
static void AddByEdge(Row row, PetscInt i, int d, PetscInt e, int c, PetscReal value) {
  row[d][(e - i + REACH) * FIELDS + c] += value;
  row[d][(e - 1 - i + REACH) * FIELDS + c] -= value;
}

/* d2E of turn k in the balance of node i */
static void TurnJacobian(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS], PetscInt i,
                         PetscInt k, Row row) {
  PetscReal a[2], b[2], w = TurnWidth(self, rod, k), B = TurnStiffness(self, rod, k), moment;
  Turn turn;

  TurnEdges(u, k, a, b);
  TurnValue(a, b, &turn);
  TurnCurve(a, b, &turn);
  moment = TurnMoment(self, rod, k, &turn);
  for (int p = 0; p < 4; p++) { /* by which x_i enters: edge k (a) or k + 1 (b) */
    PetscInt edge = p < 2 ? k : k + 1;
    PetscReal sign = edge == i ? 1 : edge == i + 1 ? -1 : 0;
    if (!sign || !edge) continue;
    for (int q = 0; q < 4; q++) {
      PetscInt by = q < 2 ? k : k + 1;
      if (by)
        AddByEdge(row, i, p % 2, by, q % 2,
                  sign * (B * turn.slope[p] * turn.slope[q] / w + moment * turn.curve[p][q]));
    }
  }
}

/* Adds to the balance of node i the slope of a force that turns with the edge e of Across():
   dq = q_perp (q_perp . de) / |e|. */
static void AddTurning(Rod rod, const PetscReal (*u)[FIELDS], PetscInt i, const PetscReal theta[2],
                       Row row) {
  const PetscInt next = PetscMin(i + 1, rod->last) - i + REACH;
  PetscReal e[2], square;

  Across(rod, u, i, e);
  square = e[0] * e[0] + e[1] * e[1];
  for (int d = 0; d < 2; d++)
    for (int c = 0; c < 2; c++) {
      PetscReal value = theta[d] * (c ? e[0] : -e[1]) / square;
      row[d][next * FIELDS + c] += value;
      row[d][(REACH - 1) * FIELDS + c] -= value;
    }
}

static void LoadJacobian(Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                         const PetscReal (*u_t)[FIELDS], PetscInt i, const RodState *state,
                         Row row) {
  const PetscReal *shift = state->shift;
  const Load *load = &rod->scene->load;
  PetscReal slide, M = NodeLength(self, rod, i);
  LoadSlope slope;
  Place at;

  PlaceAt(self, rod, u, u_t, i, &at, &slide);
  LoadLinearise(load, &at, state->fresh, &self->dual[i - rod->first], &slope);
  for (int d = 0; d < 2; d++)
    for (int c = 0; c < 2; c++) {
      row[d][REACH * FIELDS + c] += M * slope.v[d][c] * shift[c];
      if (load->moves) row[d][REACH * FIELDS + c] += M * slope.x[d][c];
      if (slide == 0) continue;
      row[d][(REACH + 1) * FIELDS + c] += M * slope.v[d][c] * slide;
      row[d][(REACH - 1) * FIELDS + c] -= M * slope.v[d][c] * slide;
    }
  if (!load->turns) return;
  for (int d = 0; d < 2; d++) slope.theta[d] *= M;
  AddTurning(rod, u, i, slope.theta, row);
}

/* The slope of the force on the tip. */
static void TipRows(Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                    const PetscReal (*u_t)[FIELDS], const RodState *state, Row row) {
  TipState tip = TipAt(self, rod, u, u_t);
  PetscReal J[TIP_ROWS][TIP_FIELDS], theta[2];

  TipJacobian(&rod->scene->tip, &tip, state->shift, state->fresh, TipDual(self, rod), J);
  for (int d = 0; d < 2; d++) {
    for (int c = 0; c < 2; c++) row[d][REACH * FIELDS + c] += J[1 + d][c];
    theta[d] = J[1 + d][2];
  }
  AddTurning(rod, u, rod->last, theta, row);
}

static void BalanceJacobian(Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                            const PetscReal (*u_t)[FIELDS], PetscInt i, const RodState *state,
                            Row row) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscReal e[2];

  LoadJacobian(self, rod, u, u_t, i, state, row);
  if (i == rod->last && rod->scene->tip.force != 0) TipRows(self, rod, u, u_t, state, row);
  for (PetscInt k = i - 1; k <= PetscMin(i + 1, rod->last - 1); k++)
    TurnJacobian(self, rod, u, i, k, row);
  for (PetscInt edge = i; edge <= PetscMin(i + 1, rod->last); edge++) {
    PetscReal sign = (edge == i ? -1 : 1) * 2 / (s[edge] - s[edge - 1]);
    Edge(u, edge, e);
    for (int d = 0; d < 2; d++) {
      row[d][(edge - i + REACH) * FIELDS + LAMBDA] += sign * e[d];
      AddByEdge(row, i, d, edge, d, sign * u[edge][LAMBDA]);
    }
  }
}

static PetscErrorCode MixedJacobian(Rod rod, const RodState *at, Mat J) {
  Mixed *self = (Mixed *)rod->data;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS];
  PetscReal e[2];
  Vec local[2];
  Row row;

  PetscFunctionBegin;
  PetscCall(LengthsAt(rod, at->t));
  PetscCall(RodOpen(rod, at->U, &local[0], &u));
  PetscCall(RodOpen(rod, at->U_t, &local[1], &u_t));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    PetscInt cols[WIDTH];
    PetscCall(PetscMemzero(row, sizeof(row)));
    for (PetscInt k = 0; k < WIDTH; k++) cols[k] = i - REACH + k <= rod->last ? i - REACH + k : -1;
    if (i) {
      BalanceJacobian(self, rod, u, u_t, i, at, row);
      Edge(u, i, e);
      for (int d = 0; d < 2; d++)
        AddByEdge(row, i, LAMBDA, i, d, 2 * e[d] / EdgeLength(self, rod, i));
    } else
      for (int f = 0; f < FIELDS; f++) row[f][REACH * FIELDS + f] = 1;
    PetscCall(MatSetValuesBlocked(J, 1, &i, WIDTH, cols, &row[0][0], INSERT_VALUES));
  }
  PetscCall(RodClose(rod, &local[0], &u));
  PetscCall(RodClose(rod, &local[1], &u_t));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* lambda = -n.q / (2 g) on the edges: the force along the edge is the constraint's. */
static PetscErrorCode MixedSet(Rod rod, PetscReal t, const Node *nodes, Vec U) {
  Mixed *self = (Mixed *)rod->data;
  const PetscReal *s = rod->scene->mesh.s;
  PetscReal(*u)[FIELDS];

  PetscFunctionBegin;
  PetscCall(LengthsAt(rod, t));
  PetscCall(DMDAVecGetArray(rod->da, U, &u));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    const Node *b = &nodes[i - rod->first], *a = i > rod->first ? b - 1 : b;
    PetscReal n[2] = {(a->force[0] + b->force[0]) / 2, (a->force[1] + b->force[1]) / 2};
    u[i][X1] = b->x[0];
    u[i][X2] = b->x[1];
    u[i][LAMBDA] = i ? -(n[0] * PetscCosReal(b->theta) + n[1] * PetscSinReal(b->theta)) *
                           (s[i] - s[i - 1]) / (2 * EdgeLength(self, rod, i))
                     : 0;
  }
  PetscCall(DMDAVecRestoreArray(rod->da, U, &u));
  PetscFunctionReturn(0);
}

/* The force at the clamp is that of the first edges, carried on (NodeState()): so its half of the
   first edge bears as much per length as node 1. */
static PetscErrorCode MixedBears(Rod rod, const RodState *at, RodForces *sum) {
  const Mixed *self = (const Mixed *)rod->data;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS];
  PetscReal friction[2], walls[2], moved, slide;
  Vec local[2];
  Place place;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  PetscCall(LengthsAt(rod, at->t));
  PetscCall(RodOpen(rod, at->U, &local[0], &u));
  PetscCall(RodOpen(rod, at->U_t, &local[1], &u_t));
  for (PetscInt i = PetscMax(1, rod->first); i < rod->end; i++) {
    const PetscReal at_clamp = i == 1 ? EdgeLength(self, rod, 1) / 2 : 0;
    PlaceAt(self, rod, u, u_t, i, &place, &slide);
    LoadParts(&rod->scene->load, &place, &self->dual[i - rod->first], friction, walls, &moved);
    for (int d = 0; d < 2; d++)
      sum->friction[d] += (NodeLength(self, rod, i) + at_clamp) * friction[d];
  }
  PetscCall(RodClose(rod, &local[0], &u));
  PetscCall(RodClose(rod, &local[1], &u_t));
  PetscFunctionReturn(0);
}

/* What is known of an edge: its force n = Q - flux, with Q = dE/d(edge), and its rate of turning.
 */
static void EdgeState(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                      const PetscReal (*u_t)[FIELDS], PetscInt i, PetscReal n[2],
                      PetscReal *turning) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscReal a[2], b[2], e[2], e_t[2] = {0, 0};
  Turn turn;

  Edge(u, i, e);
  if (u_t) Edge(u_t, i, e_t);
  *turning = (e[0] * e_t[1] - e[1] * e_t[0]) / (e[0] * e[0] + e[1] * e[1]);
  for (int d = 0; d < 2; d++) n[d] = -2 * u[i][LAMBDA] * e[d] / (s[i] - s[i - 1]);
  for (PetscInt k = i - 1; k <= PetscMin(i, rod->last - 1); k++) {
    TurnEdges(u, k, a, b);
    TurnValue(a, b, &turn);
    for (int d = 0; d < 2; d++)
      n[d] += TurnMoment(self, rod, k, &turn) * turn.slope[(k == i ? 0 : 2) + d];
  }
}

/* Force, angle's rate and moment at a node, from the edges beside it. */
static void NodeState(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                      const PetscReal (*u_t)[FIELDS], PetscInt i, Node *node) {
  PetscReal n[2][2], turning[2], a[2], b[2], share;
  PetscInt left = PetscMin(PetscMax(i, 1), rod->last - 1);
  Turn turn;

  for (int e = 0; e < 2; e++) EdgeState(self, rod, u, u_t, left + e, n[e], &turning[e]);
  /* linear between, and to the clamp beyond, the middles of two edges */
  share =
      EdgeLength(self, rod, left) / (EdgeLength(self, rod, left) + EdgeLength(self, rod, left + 1));
  if (!i) share = -share;
  for (int d = 0; d < 2; d++) node->force[d] = n[0][d] + share * (n[1][d] - n[0][d]);
  node->theta_t = !i               ? 0
                  : i == rod->last ? turning[1]
                                   : turning[0] + share * (turning[1] - turning[0]);
  if (i == rod->last) {
    TipState tip = TipAt(self, rod, u, u_t);
    TipForce(&rod->scene->tip, &tip, TipDual(self, rod), node->force);
    return;
  }
  TurnEdges(u, i, a, b);
  TurnValue(a, b, &turn);
  node->moment = TurnMoment(self, rod, i, &turn);
}

static PetscErrorCode MixedGet(Rod rod, PetscReal t, Vec U, Vec U_t, Node *nodes) {
  Mixed *self = (Mixed *)rod->data;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS] = NULL;
  PetscInt n = rod->end - rod->first;
  PetscReal *theta, a[2], b[2];
  Vec local[2];

  PetscFunctionBegin;
  PetscCall(LengthsAt(rod, t));
  PetscCall(PetscArrayzero(nodes, n));
  PetscCall(PetscCalloc1(n, &theta));
  PetscCall(RodOpen(rod, U, &local[0], &u));
  if (U_t) PetscCall(RodOpen(rod, U_t, &local[1], &u_t));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    Node *node = &nodes[i - rod->first];
    for (int d = 0; d < 2; d++) {
      node->x[d] = u[i][d];
      node->x_t[d] = u_t ? u_t[i][d] : 0;
    }
    NodeState(self, rod, u, u_t, i, node);
    if (!i) continue;
    TurnEdges(u, i - 1, a, b); /* the turn into edge i */
    theta[i - rod->first] =
        2 * PetscAtan2Real(a[0] * b[1] - a[1] * b[0],
                           hypot(a[0], a[1]) * hypot(b[0], b[1]) + a[0] * b[0] + a[1] * b[1]);
  }
  PetscCall(RodClose(rod, &local[0], &u));
  if (U_t) PetscCall(RodClose(rod, &local[1], &u_t));
  PetscCall(RodSumAlong(rod, n, theta));                        /* angle of edge i */
  for (PetscInt i = PetscMax(1, rod->first); i < rod->end; i++) /* from its middle on to its end */
    nodes[i - rod->first].theta =
        theta[i - rod->first] + (nodes[i - rod->first].moment / TurnStiffness(self, rod, i) +
                                 self->natural[i - rod->first + 1]) *
                                    EdgeLength(self, rod, i) / 2;
  PetscCall(PetscFree(theta));
  PetscFunctionReturn(0);
}

/* The dual of each node, and that of the tip beside the last node's. */
enum { REMEMBERED = 4 };

static PetscReal *MixedRemembered(Rod rod, PetscInt i, PetscInt k) {
  const Mixed *self = (const Mixed *)rod->data;

  if (i < rod->first || i >= rod->end) return NULL;
  if (k < 2) return &self->dual[i - rod->first].w[k];
  return i == rod->last ? &TipDual(self, rod)->w[k - 2] : NULL;
}

static PetscErrorCode MixedCreate(Rod rod) {
  PetscInt n = rod->end - rod->first;
  Mixed *self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  self->time = PETSC_MIN_REAL;
  PetscCall(PetscCalloc4(n + 4, &self->length, n + 2, &self->natural, n + 2, &self->bend, n + 1,
                         &self->dual));
  rod->order = 2;
  rod->memory = REMEMBERED;
  rod->data = self;
  PetscFunctionReturn(0);
}

static PetscErrorCode MixedDestroy(Rod rod) {
  Mixed *self = (Mixed *)rod->data;

  PetscFunctionBegin;
  PetscCall(PetscFree4(self->length, self->natural, self->bend, self->dual));
  PetscCall(PetscFree(rod->data));
  PetscFunctionReturn(0);
}

static const char *MixedRefuses(Scene scene) {
  if (scene->space.why) return RodRefusesSpace(scene);
  if (LoadSticks(&scene->load))
    return "-friction_beta 0: the mixed model has no exact Coulomb friction; give a value above 0";
  if (scene->growth->yield > 0) return "-growth_yield: the mixed model's growth feels no force";
  if (scene->tropism.any)
    return "-tropism_, -growth_ironing: the mixed model has no natural curvature that it learns";
  if (scene->contact.any) return "-wall_file, -contact_self: the mixed model has no contact";
  if (scene->clamp != CLAMP_HELD) return "-clamp_type: the mixed model's rod is held by a clamp";
  if (scene->tip.type != TIP_FREE) return "-tip_type: the mixed model's tip is free";
  return NULL;
}

const RodModel rod_mixed = {.name = "mixed",
                            .refuses = MixedRefuses,
                            .fields = FIELDS,
                            .stencil = REACH,
                            .field = {"x1", "x2", "lambda"},
                            .followed = {PETSC_TRUE, PETSC_TRUE},
                            .group = {ALONG, ACROSS_2, ALONG},
                            .create = MixedCreate,
                            .destroy = MixedDestroy,
                            .set = MixedSet,
                            .get = MixedGet,
                            .residual = MixedResidual,
                            .jacobian = MixedJacobian,
                            .bears = MixedBears,
                            .remembered = MixedRemembered};
