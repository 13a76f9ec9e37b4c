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
  FrictionDual *dual; /* owned nodes, and one more for the tip's resistance */
  Place *place;       /* owned nodes: which they are */
} Mixed;

/* K and its first and second derivatives by (a, b), for one turn. */
typedef struct {
  PetscReal K, slope[4], curve[4][4];
} Turn;

/* The two edges of a turn, and the parts of K = 2 N / D: N = a x b, D = |a| |b| + a.b, with their
   derivatives. */
typedef struct {
  Vector2 a, b;
  PetscReal la, lb, N, D, N1[4], D1[4];
} Edges;

static Edges EdgesOf(Vector2 a, Vector2 b) {
  Edges of = {.a = a, .b = b, .la = Size2(a), .lb = Size2(b), .N = Cross2(a, b)};

  of.D = of.la * of.lb + a.x * b.x + a.y * b.y;
  Put2((Vector2){b.y, -b.x}, of.N1);
  Put2(Left2(a), of.N1 + 2);
  Put2(Plus2(Over2(Times2(of.lb, a), of.la), b), of.D1);
  Put2(Plus2(Over2(Times2(of.la, b), of.lb), a), of.D1 + 2);
  return of;
}

static void TurnValue(Vector2 a, Vector2 b, Turn *turn) {
  const Edges of = EdgesOf(a, b);

  turn->K = 2 * of.N / of.D;
  for (int i = 0; i < 4; i++) turn->slope[i] = 2 * (of.N1[i] - of.N * of.D1[i] / of.D) / of.D;
}

static void TurnCurve(Vector2 a, Vector2 b, Turn *turn) {
  const Edges of = EdgesOf(a, b);
  const PetscReal ab[4] = {a.x, a.y, b.x, b.y}, la = of.la, lb = of.lb, D = of.D, *N1 = of.N1,
                  *D1 = of.D1;
  PetscReal N2[4][4] = {{0}}, D2[4][4];

  N2[0][3] = N2[3][0] = 1;
  N2[1][2] = N2[2][1] = -1;
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++) {
      const PetscReal same = i % 2 == j % 2, p = ab[i] * ab[j];
      D2[i][j] = i / 2 != j / 2 ? p / (la * lb) + same
                 : i < 2        ? lb / la * (same - p / (la * la))
                                : la / lb * (same - p / (lb * lb));
    }
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++)
      turn->curve[i][j] = 2 *
                          (N2[i][j] - (N1[i] * D1[j] + D1[i] * N1[j]) / D - of.N * D2[i][j] / D +
                           2 * of.N * D1[i] * D1[j] / (D * D)) /
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
  for (PetscInt i = rod->first; i < rod->end; i++)
    PetscCall(ScenePlace(rod->scene, rod->scene->mesh.s[i], t, &self->place[i - rod->first]));
  self->time = t;
  PetscFunctionReturn(0);
}

/* From one node to another. */
static Vector2 Between(const PetscReal (*u)[FIELDS], PetscInt from, PetscInt to) {
  return Minus2(From2(u[to]), From2(u[from]));
}

static Vector2 Edge(const PetscReal (*u)[FIELDS], PetscInt i) {
  return Between(u, i - 1, i);
}

/* The first edge of turn k; the second is edge k + 1. */
static Vector2 EdgeBefore(const PetscReal (*u)[FIELDS], PetscInt k) {
  return k ? Edge(u, k) : (Vector2){1, 0};
}

/* By how much the rod turns from the middle of the last edge to the tip, where there is no moment.
 */
static PetscReal TipTurn(const Mixed *self, Rod rod) {
  return self->natural[rod->last - rod->first + 1] * EdgeLength(self, rod, rod->last) / 2;
}

static Vector2 Rotated(Vector2 e, PetscReal angle) {
  const PetscReal c = PetscCosReal(angle), s = PetscSinReal(angle);

  return (Vector2){c * e.x - s * e.y, s * e.x + c * e.y};
}

/* The edge that the tangent of node i is taken from: between its neighbours. */
static Vector2 Across(Rod rod, const PetscReal (*u)[FIELDS], PetscInt i) {
  return Between(u, i - 1, PetscMin(i + 1, rod->last));
}

/* Node i and its velocity, v = x_t + c q, with q by central differences; slide is c over the length
   of these. u_t NULL: at rest. */
static void PlaceAt(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                    const PetscReal (*u_t)[FIELDS], PetscInt i, Place *at, PetscReal *slide) {
  const PetscReal c = GrowthSlide(rod->scene->growth, rod->scene->mesh.s[i], self->time);
  Vector2 e = Across(rod, u, i);
  const PetscReal size = Size2(e);

  if (i == rod->last) e = Rotated(e, TipTurn(self, rod));
  *slide = c != 0 && i < rod->last ? c / (2 * NodeLength(self, rod, i)) : 0;
  *at = self->place[i - rod->first];
  Put2(From2(u[i]), at->x);
  PlaceTurn2(Over2(e, size), at);
  Put2(Along2(u_t ? From2(u_t[i]) : (Vector2){0, 0}, *slide, e), at->v);
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
static FrictionDual *TipDual(const Mixed *self, Rod rod) {
  return self->dual + (rod->end - rod->first);
}

/* Residual of the balance at node i. */
static Vector2 BalanceResidual(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                               const PetscReal (*u_t)[FIELDS], PetscInt i) {
  const PetscReal *s = rod->scene->mesh.s;
  PetscReal f[RUBS], slide;
  Vector2 r;
  Place at;
  Turn turn;

  PlaceAt(self, rod, u, u_t, i, &at, &slide);
  LoadForce(2, &rod->scene->load, &at, &self->dual[i - rod->first], f);
  r = Times2(NodeLength(self, rod, i), From2(f));
  for (PetscInt k = i - 1; k <= PetscMin(i + 1, rod->last - 1); k++) {
    PetscReal force;
    TurnValue(EdgeBefore(u, k), Edge(u, k + 1), &turn);
    force = TurnMoment(self, rod, k, &turn);
    const Vector2 a = From2(turn.slope), b = From2(turn.slope + 2);
    /* x_i ends edge i (+) and begins edge i + 1 (-) */
    if (k == i - 1) r = Along2(r, force, b);
    if (k == i) r = Along2(r, force, Minus2(a, b));
    if (k == i + 1) r = Along2(r, -force, a);
  }
  for (PetscInt e = i; e <= PetscMin(i + 1, rod->last); e++)
    r = Plus2(r, Over2(Times2((e == i ? -1 : 1) * 2 * u[e][LAMBDA], Edge(u, e)), s[e] - s[e - 1]));
  if (i == rod->last && rod->scene->tip.force != 0) {
    TipState tip = TipAt(self, rod, u, u_t);
    TipForce(2, &rod->scene->tip, &tip, TipDual(self, rod), f);
    r = Minus2(r, From2(f));
  }
  return r;
}

static PetscErrorCode MixedResidual(Rod rod, const RodState *at, Vec F) {
  Mixed *self = (Mixed *)rod->data;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS];
  PetscReal(*f)[FIELDS];
  Vec local, local_t;

  PetscFunctionBegin;
  PetscCall(LengthsAt(rod, at->t));
  PetscCall(RodOpen(rod, at->U, &local, &u));
  PetscCall(RodOpen(rod, at->U_t, &local_t, &u_t));
  PetscCall(DMDAVecGetArray(rod->da, F, &f));
  if (!rod->first) PetscCall(PetscArraycpy(f[0], u[0], FIELDS));
  for (PetscInt i = PetscMax(1, rod->first); i < rod->end; i++) {
    PetscReal l = EdgeLength(self, rod, i);
    const Vector2 e = Edge(u, i);
    Put2(BalanceResidual(self, rod, u, u_t, i), f[i]);
    f[i][LAMBDA] = Dot2(e, e) / l - l;
  }
  PetscCall(DMDAVecRestoreArray(rod->da, F, &f));
  PetscCall(RodClose(rod, &local, &u));
  PetscCall(RodClose(rod, &local_t, &u_t));
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
  const PetscReal w = TurnWidth(self, rod, k), B = TurnStiffness(self, rod, k);
  const Vector2 a = EdgeBefore(u, k), b = Edge(u, k + 1);
  PetscReal moment;
  Turn turn;

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

/* The rows of the balance, and the unknowns that it is by. */
enum { DIMS = 2 };

/* Adds to the balance of node i the slope of a force that turns with the edge e of Across():
   dq = q_perp (q_perp . de) / |e|. */
static void AddTurning(Rod rod, const PetscReal (*u)[FIELDS], PetscInt i, const PetscReal theta[],
                       Row row) {
  const PetscInt next = PetscMin(i + 1, rod->last) - i + REACH;
  const Vector2 e = Across(rod, u, i);
  const PetscReal perp[] = {-e.y, e.x}, square = Dot2(e, e);

  for (int d = 0; d < DIMS; d++)
    for (int c = 0; c < DIMS; c++) {
      PetscReal value = theta[d] * perp[c] / square;
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
  LoadLinearise(2, load, &at, state->fresh, &self->dual[i - rod->first], &slope);
  for (int d = 0; d < DIMS; d++)
    for (int c = 0; c < DIMS; c++) {
      row[d][REACH * FIELDS + c] += M * slope.W[d][c] * shift[c];
      if (load->moves) row[d][REACH * FIELDS + c] += M * slope.x[d][c];
      if (slide == 0) continue;
      row[d][(REACH + 1) * FIELDS + c] += M * slope.W[d][c] * slide;
      row[d][(REACH - 1) * FIELDS + c] -= M * slope.W[d][c] * slide;
    }
  if (!load->turns) return;
  for (int d = 0; d < DIMS; d++) slope.theta[d] *= M;
  AddTurning(rod, u, i, slope.theta, row);
}

/* The slope of the force on the tip. */
static void TipRows(Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                    const PetscReal (*u_t)[FIELDS], const RodState *state, Row row) {
  TipState tip = TipAt(self, rod, u, u_t);
  PetscReal J[TIP_ROWS][TIP_FIELDS], theta[DIMS];

  TipJacobian(&rod->scene->tip, &tip, state->shift, state->fresh, TipDual(self, rod), J);
  for (int d = 0; d < DIMS; d++) {
    for (int c = 0; c < DIMS; c++) row[d][REACH * FIELDS + c] += J[1 + d][c];
    theta[d] = J[1 + d][2];
  }
  AddTurning(rod, u, rod->last, theta, row);
}

static void BalanceJacobian(Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                            const PetscReal (*u_t)[FIELDS], PetscInt i, const RodState *state,
                            Row row) {
  const PetscReal *s = rod->scene->mesh.s;

  LoadJacobian(self, rod, u, u_t, i, state, row);
  if (i == rod->last && rod->scene->tip.force != 0) TipRows(self, rod, u, u_t, state, row);
  for (PetscInt k = i - 1; k <= PetscMin(i + 1, rod->last - 1); k++)
    TurnJacobian(self, rod, u, i, k, row);
  for (PetscInt edge = i; edge <= PetscMin(i + 1, rod->last); edge++) {
    PetscReal sign = (edge == i ? -1 : 1) * 2 / (s[edge] - s[edge - 1]);
    PetscReal e[DIMS];
    Put2(Edge(u, edge), e);
    for (int d = 0; d < DIMS; d++) {
      row[d][(edge - i + REACH) * FIELDS + LAMBDA] += sign * e[d];
      AddByEdge(row, i, d, edge, d, sign * u[edge][LAMBDA]);
    }
  }
}

static PetscErrorCode MixedJacobian(Rod rod, const RodState *at, Mat J) {
  Mixed *self = (Mixed *)rod->data;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS];
  PetscReal e[DIMS];
  Vec local, local_t;
  Row row;

  PetscFunctionBegin;
  PetscCall(LengthsAt(rod, at->t));
  PetscCall(RodOpen(rod, at->U, &local, &u));
  PetscCall(RodOpen(rod, at->U_t, &local_t, &u_t));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    PetscInt cols[WIDTH];
    PetscCall(PetscMemzero(row, sizeof(row)));
    for (PetscInt k = 0; k < WIDTH; k++) cols[k] = i - REACH + k <= rod->last ? i - REACH + k : -1;
    if (i) {
      BalanceJacobian(self, rod, u, u_t, i, at, row);
      Put2(Edge(u, i), e);
      for (int d = 0; d < DIMS; d++)
        AddByEdge(row, i, LAMBDA, i, d, 2 * e[d] / EdgeLength(self, rod, i));
    } else
      for (int f = 0; f < FIELDS; f++) row[f][REACH * FIELDS + f] = 1;
    PetscCall(MatSetValuesBlocked(J, 1, &i, WIDTH, cols, &row[0][0], INSERT_VALUES));
  }
  PetscCall(RodClose(rod, &local, &u));
  PetscCall(RodClose(rod, &local_t, &u_t));
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
    const Vector2 n = Over2(Plus2(From2(a->force), From2(b->force)), 2),
                  q = {PetscCosReal(b->theta), PetscSinReal(b->theta)};
    u[i][X1] = b->x[0];
    u[i][X2] = b->x[1];
    u[i][LAMBDA] = i ? -Dot2(n, q) * (s[i] - s[i - 1]) / (2 * EdgeLength(self, rod, i)) : 0;
  }
  PetscCall(DMDAVecRestoreArray(rod->da, U, &u));
  PetscFunctionReturn(0);
}

/* The force at the clamp is that of the first edges, carried on (NodeState()): so its half of the
   first edge bears as much per length as node 1. */
static PetscErrorCode MixedBears(Rod rod, const RodState *at, RodForces *sum) {
  const Mixed *self = (const Mixed *)rod->data;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS];
  PetscReal friction[3], walls[3], moved, slide;
  Vec local, local_t;
  Place place;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  PetscCall(LengthsAt(rod, at->t));
  PetscCall(RodOpen(rod, at->U, &local, &u));
  PetscCall(RodOpen(rod, at->U_t, &local_t, &u_t));
  for (PetscInt i = PetscMax(1, rod->first); i < rod->end; i++) {
    const PetscReal at_clamp = i == 1 ? EdgeLength(self, rod, 1) / 2 : 0;
    PlaceAt(self, rod, u, u_t, i, &place, &slide);
    LoadParts(2, &rod->scene->load, &place, &self->dual[i - rod->first], friction, walls, &moved);
    for (int d = 0; d < DIMS; d++)
      sum->friction[d] += (NodeLength(self, rod, i) + at_clamp) * friction[d];
  }
  PetscCall(RodClose(rod, &local, &u));
  PetscCall(RodClose(rod, &local_t, &u_t));
  PetscFunctionReturn(0);
}

/* What is known of an edge: its force n = Q - flux, with Q = dE/d(edge), and its rate of turning.
 */
static Vector2 EdgeState(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                         const PetscReal (*u_t)[FIELDS], PetscInt i, PetscReal *turning) {
  const PetscReal *s = rod->scene->mesh.s;
  const Vector2 e = Edge(u, i), e_t = u_t ? Edge(u_t, i) : (Vector2){0, 0};
  Vector2 n = Over2(Times2(-2 * u[i][LAMBDA], e), s[i] - s[i - 1]);
  Turn turn;

  *turning = Cross2(e, e_t) / Dot2(e, e);
  for (PetscInt k = i - 1; k <= PetscMin(i, rod->last - 1); k++) {
    TurnValue(EdgeBefore(u, k), Edge(u, k + 1), &turn);
    n = Along2(n, TurnMoment(self, rod, k, &turn), From2(turn.slope + (k == i ? 0 : 2)));
  }
  return n;
}

/* Force, angle's rate and moment at a node, from the edges beside it. */
static void NodeState(const Mixed *self, Rod rod, const PetscReal (*u)[FIELDS],
                      const PetscReal (*u_t)[FIELDS], PetscInt i, Node *node) {
  const PetscInt left = PetscMin(PetscMax(i, 1), rod->last - 1);
  PetscReal f[RUBS], before, behind, share;
  const Vector2 n = EdgeState(self, rod, u, u_t, left, &before),
                n_behind = EdgeState(self, rod, u, u_t, left + 1, &behind);
  Turn turn;

  /* linear between, and to the clamp beyond, the middles of two edges */
  share =
      EdgeLength(self, rod, left) / (EdgeLength(self, rod, left) + EdgeLength(self, rod, left + 1));
  if (!i) share = -share;
  Put2(Along2(n, share, Minus2(n_behind, n)), node->force);
  node->theta_t = !i ? 0 : i == rod->last ? behind : before + share * (behind - before);
  if (i == rod->last) {
    TipState tip = TipAt(self, rod, u, u_t);
    TipForce(2, &rod->scene->tip, &tip, TipDual(self, rod), f);
    Put2(From2(f), node->force);
    return;
  }
  TurnValue(EdgeBefore(u, i), Edge(u, i + 1), &turn);
  node->moment = TurnMoment(self, rod, i, &turn);
}

static PetscErrorCode MixedGet(Rod rod, PetscReal t, Vec U, Vec U_t, Node *nodes) {
  Mixed *self = (Mixed *)rod->data;
  const PetscReal(*u)[FIELDS], (*u_t)[FIELDS] = NULL;
  PetscInt n = rod->end - rod->first;
  PetscReal *theta;
  Vec local, local_t;

  PetscFunctionBegin;
  PetscCall(LengthsAt(rod, t));
  PetscCall(PetscArrayzero(nodes, n));
  PetscCall(PetscCalloc1(n, &theta));
  PetscCall(RodOpen(rod, U, &local, &u));
  if (U_t) PetscCall(RodOpen(rod, U_t, &local_t, &u_t));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    Node *node = &nodes[i - rod->first];
    Put2(From2(u[i]), node->x);
    Put2(u_t ? From2(u_t[i]) : (Vector2){0, 0}, node->x_t);
    NodeState(self, rod, u, u_t, i, node);
    if (!i) continue;
    const Edges of = EdgesOf(EdgeBefore(u, i - 1), Edge(u, i)); /* the turn into edge i */
    theta[i - rod->first] = 2 * PetscAtan2Real(of.N, of.D);
  }
  PetscCall(RodClose(rod, &local, &u));
  if (U_t) PetscCall(RodClose(rod, &local_t, &u_t));
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
  PetscCall(PetscCalloc5(n + 4, &self->length, n + 2, &self->natural, n + 2, &self->bend, n + 1,
                         &self->dual, n, &self->place));
  rod->order = 2;
  rod->memory = REMEMBERED;
  rod->data = self;
  PetscFunctionReturn(0);
}

static PetscErrorCode MixedDestroy(Rod rod) {
  Mixed *self = (Mixed *)rod->data;

  PetscFunctionBegin;
  PetscCall(PetscFree5(self->length, self->natural, self->bend, self->dual, self->place));
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
