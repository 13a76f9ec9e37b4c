#include "straight/senses.h"
#include "base/band.h"
#include "base/lagrange.h"
#include "straight/dense.h"
#include "straight/straight.h"

enum { NODE = 3 }; /* w, c and n of a node; what its cell has learned follows */

/* k at point q of the cell behind block `block`, and f there. */
static PetscInt PlaceK(const Senses *self, PetscInt block, PetscInt q) {
  return block * self->of + NODE + q;
}

static PetscInt PlaceF(const Senses *self, PetscInt block, PetscInt q) {
  return PlaceK(self, block, GAUSS + q);
}

/* What every point remembers for itself. */
static PetscBool Remembers(const Senses *self) {
  const Tropism *law = &self->scene->tropism;

  return (PetscBool)(law->senses && !law->at_tip && law->memory > 0);
}

/* The frame in which the problem stands still, but for what the length does. */
static PencilFrame FrameOf(Growth growth) {
  return growth->finest > 0 ? FRAME_TIP : FRAME_ARC;
}

/*
  SensesCreate - prepares the problem of a scene, of one direction across, on so many cells. The
  caller destroys it with SensesDestroy(). Each rank has it all.
*/
PetscErrorCode SensesCreate(Scene scene, PetscInt cells, StraightWay way, Senses *self) {
  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  self->scene = scene;
  self->way = way;
  self->cells = cells;
  self->signal = scene->tropism.senses && scene->tropism.at_tip ? self->globals++ : -1;
  self->turned =
      FrameOf(scene->growth) == FRAME_TIP && scene->tip.type == TIP_FREE ? self->globals++ : -1;
  self->moved = self->turned >= 0 && scene->tropism.light != 0 ? self->globals++ : -1;
  self->of = NODE + GAUSS * (Remembers(self) ? 2 : 1);
  PetscFunctionReturn(0);
}

static PetscErrorCode DropMesh(Senses *self) {
  PetscFunctionBegin;
  PetscCall(PencilDestroy(&self->pencil));
  PetscCall(MeshDestroy(&self->mesh));
  for (PetscInt g = 0; g < self->globals; g++) PetscCall(PetscFree(self->global[g].column));
  PetscFunctionReturn(0);
}

PetscErrorCode SensesDestroy(Senses *self) {
  PetscFunctionBegin;
  PetscCall(DropMesh(self));
  PetscCall(PetscFree(self->entry));
  PetscFunctionReturn(0);
}

/* A growth zone has half of the cells, the finer the nearer to the tip, and begins at a node. */
static void GradeMesh(Mesh *mesh, PetscReal share) {
  const PetscInt zone = mesh->cells / 2, rest = mesh->cells - zone;

  for (PetscInt i = 0; i <= mesh->cells; i++) {
    const PetscReal z = (PetscReal)(mesh->cells - i) / (PetscReal)zone;
    mesh->s[i] = i <= rest ? (1 - share) * (PetscReal)i / (PetscReal)rest : 1 - share * z * z;
  }
}

/* Columns and rows are one array. */
static PetscErrorCode MakeGlobal(PetscInt n, SensesGlobal *global) {
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(4 * n, &global->column));
  global->column_b = global->column + n;
  global->row = global->column_b + n;
  global->row_b = global->row + n;
  PetscFunctionReturn(0);
}

static PetscErrorCode MakeMesh(Senses *self, PetscReal t) {
  const Growth growth = self->scene->growth;
  PetscReal L;

  PetscFunctionBegin;
  if (self->pencil && growth->finest == 0) PetscFunctionReturn(0);
  PetscCall(DropMesh(self));
  PetscCall(GrowthLength(growth, t, &L, NULL));
  PetscCall(MeshCreate(self->cells, PETSC_FALSE, growth, t, &self->mesh));
  if (growth->finest > 0 && growth->finest < L) GradeMesh(&self->mesh, growth->finest / L);
  PetscCall(PencilCreate(PETSC_COMM_SELF, self->scene, &self->mesh, map_follows, self->way,
                         &self->pencil));
  self->n = self->pencil->n * self->of;
  for (PetscInt g = 0; g < self->globals; g++) PetscCall(MakeGlobal(self->n, &self->global[g]));
  PetscFunctionReturn(0);
}

static PetscErrorCode Add(Senses *self, PetscInt row, PetscInt col, PetscReal a, PetscReal b) {
  const SensesEntry entry = {row, col, a, b};

  PetscFunctionBegin;
  if (self->entries == self->room) {
    const PetscInt room = 2 * self->room + 1024;
    PetscCall(PetscRealloc((size_t)room * sizeof(entry), &self->entry));
    self->room = room;
  }
  self->entry[self->entries++] = entry;
  PetscFunctionReturn(0);
}

/* A band of the mechanics; kinds 0 w, 1 c. */
static PetscErrorCode AddBand(Senses *self, const PetscReal band[], PetscInt row_kind,
                              PetscInt col_kind, PetscReal a, PetscReal b) {
  const Pencil p = self->pencil;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n; i++)
    for (PetscInt k = 0; k < WIDTH; k++) {
      const PetscInt j = i - HALF + k;
      const PetscReal value = band[i * WIDTH + k];
      if (j < 0 || j >= p->n || value == 0) continue;
      if (PencilIsHeld(p, i, row_kind) || PencilIsHeld(p, j, col_kind)) continue;
      PetscCall(Add(self, i * self->of + row_kind, j * self->of + col_kind, a * value, b * value));
    }
  PetscFunctionReturn(0);
}

/* E, E^T and Delta, as in PencilMixed(); and cells that are none, whose k is 0. */
static PetscErrorCode AddJoins(Senses *self) {
  const Pencil p = self->pencil;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n; i++) {
    const PetscInt w = i * self->of, c = w + 1, n = w + 2, cell = i - p->ahead;
    if (PencilIsHeld(p, i, 0))
      PetscCall(Add(self, w, w, 1, 0));
    else {
      PetscCall(Add(self, w, n, -p->delta[i], 0));
      PetscCall(Add(self, n, w, -p->delta[i], 0));
    }
    if (PencilIsHeld(p, i, 1))
      PetscCall(Add(self, c, c, 1, 0));
    else {
      PetscCall(Add(self, n, c, 1, 0));
      PetscCall(Add(self, c, n, 1, 0));
    }
    if (i > 0) PetscCall(Add(self, n, c - self->of, -1, 0));
    if (i < p->n - 1) PetscCall(Add(self, c, n + self->of, -1, 0));
    for (PetscInt k = w + NODE; (cell < 0 || cell >= self->cells) && k < w + self->of; k++)
      PetscCall(Add(self, k, k, 1, 0));
  }
  PetscFunctionReturn(0);
}

/* The mechanics without k; force: a power of 2 by which rows of w and c are scaled. */
static PetscErrorCode AddMechanics(Senses *self, PetscReal force) {
  const Pencil p = self->pencil;
  PetscReal *band;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n * WIDTH, &band));
  PetscCall(PencilBand(p, FORM_STIFF, band));
  PetscCall(AddBand(self, band, 0, 0, force, 0));
  PetscCall(PencilBand(p, FORM_SLIDE, band));
  PetscCall(AddBand(self, band, 1, 0, force, 0));
  PetscCall(PencilBand(p, FORM_DRAG, band));
  PetscCall(AddBand(self, band, 1, 1, 0, force));
  PetscCall(PetscFree(band));
  PetscCall(AddJoins(self));
  PetscFunctionReturn(0);
}

/* A point of a cell: its clock, drift, what it senses, and its splines. */
typedef struct {
  PetscInt cell, block, q;
  PetscReal p, clock, drift, turn, aside;
  const PencilPoint *x;
  const PetscReal *w, *w1, *y;
} At;

/* S = -turn theta - aside y of a place of the straight rod. */
static PetscErrorCode Sense(const Senses *self, PetscReal s, PetscReal t, PetscReal *turn,
                            PetscReal *aside) {
  const Tropism *law = &self->scene->tropism;
  PetscReal x[3] = {0, 0, 0}, pull[3], by_x[3][3];

  PetscFunctionBegin;
  *turn = *aside = 0;
  if (!law->senses) PetscFunctionReturn(0);
  PetscCall(GrowthArc(self->scene->growth, 1, &s, t, &x[0], NULL));
  UserCheck(law->light == 0 || law->source[0] < 0 || law->source[0] > x[0], OptionsComm(),
            "-tropism_source: the straight rod comes to the lamp; put it farther off");
  TropismPull(law, x, pull, by_x);
  *turn = pull[0];
  *aside = -by_x[1][1];
  PetscFunctionReturn(0);
}

static PetscErrorCode PointAt(const Senses *self, PetscInt i, PetscReal t, At *at) {
  const Pencil p = self->pencil;
  const Growth growth = self->scene->growth;
  const PetscReal s = p->label[i];
  PetscReal g, g_t, g_s;

  PetscFunctionBegin;
  at->cell = i / GAUSS;
  at->q = i % GAUSS;
  at->block = at->cell + p->ahead;
  at->x = p->point + i;
  at->w = p->basis + i * PER_POINT;
  at->w1 = at->w + 3;
  at->y = at->w + 6;
  PetscCall(GrowthStretch(growth, 1, &s, t, &g, &g_t, &g_s));
  at->clock = TropismClock(&self->scene->tropism, growth, s, t, g, g_t);
  PetscCall(PencilDrift(p, s, t, FrameOf(growth), &at->drift));
  PetscCall(GrowthArc(growth, 1, &s, t, &at->p, NULL));
  PetscCall(Sense(self, s, t, &at->turn, &at->aside));
  PetscFunctionReturn(0);
}

/* Adds factor times S of a point to a row. */
static PetscErrorCode AddSensed(Senses *self, const At *at, PetscInt row, PetscReal factor) {
  const Pencil p = self->pencil;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 3; k++) {
    const PetscInt i = at->block - 1 + k;
    if (i >= 0 && !PencilIsHeld(p, i, 0))
      PetscCall(Add(self, row, i * self->of, -factor * at->turn * at->w[k] / at->x->g, 0));
  }
  for (PetscInt k = 0; k < 4 && at->aside != 0; k++) {
    const PetscInt i = at->block - 2 + k;
    if (i >= 0 && !PencilIsHeld(p, i, 1))
      PetscCall(Add(self, row, i * self->of + 1, -factor * at->aside * at->y[k], 0));
  }
  if (self->turned < 0) PetscFunctionReturn(0);
  self->global[self->turned].column[row] -= factor * (at->turn + at->aside * at->p);
  if (self->moved >= 0) self->global[self->moved].column[row] -= factor * at->aside;
  PetscFunctionReturn(0);
}

/* What drifts: -drift k_p of a point, by the values of its cell and the one it comes from, where
   they meet. first: the place of the values of the cell; step: to those of the next. */
static PetscErrorCode AddDrift(Senses *self, const At *at, PetscInt first, PetscReal factor,
                               PetscReal edge_drift) {
  const PetscReal *z = self->mesh.s + at->cell, h = z[1] - z[0], edge = at->drift > 0 ? 0 : 1,
                  along = -factor * at->drift / (at->x->g * h);
  const PetscInt before = at->drift > 0 ? at->cell - 1 : at->cell + 1, step = before - at->cell;
  PetscReal slope[GAUSS], mine[GAUSS], other[GAUSS], lift;

  PetscFunctionBegin;
  if (at->drift == 0 && edge_drift == 0) PetscFunctionReturn(0);
  LagrangeSlopes(GAUSS, gauss_point, gauss_point[at->q], slope);
  LagrangeValues(GAUSS, gauss_point, edge, mine);
  LagrangeValues(GAUSS, gauss_point, 1 - edge, other);
  lift = -factor * PetscAbsReal(edge_drift) * mine[at->q] / (gauss_weight[at->q] * h * at->x->g);
  for (int r = 0; r < GAUSS; r++) {
    PetscCall(Add(self, first + at->q, first + r, along * slope[r] + lift * mine[r], 0));
    if (before < 0 || before >= self->cells) continue;
    PetscCall(Add(self, first + at->q, first + step * self->of + r, -lift * other[r], 0));
  }
  PetscFunctionReturn(0);
}

/* The drift at the end of a point's cell through which material comes into it. */
static PetscErrorCode EdgeDrift(const Senses *self, const At *at, PetscReal t, PetscReal *drift) {
  const PetscReal s = self->pencil->node[at->drift > 0 ? at->cell : at->cell + 1];

  PetscFunctionBegin;
  PetscCall(PencilDrift(self->pencil, s, t, FrameOf(self->scene->growth), drift));
  PetscFunctionReturn(0);
}

/* What turning the whole rod does to the mechanics at a point, which is pressed, and drags; and
   what the forces at the point do to the bend at the clamp, where `gives` is L_t/B: M(0) = int P
   theta - p (load across) dp. */
static void Lift(Senses *self, const At *at, PetscReal L_t, PetscReal gives, PetscReal force) {
  SensesGlobal *turn = self->global + self->turned;
  const PencilPoint *x = at->x;
  const PetscReal drag = x->ds * x->drag, press = x->dz * x->P, arm = gives * drag * at->p;

  for (PetscInt k = 0; k < 3; k++) {
    const PetscInt i = at->block - 1 + k, w = i * self->of;
    if (i < 0) continue;
    turn->column[w] += force * press * at->w[k];
    turn->row[w] += (gives * press - arm * x->slide / x->g) * at->w[k];
  }
  for (PetscInt k = 0; k < 4; k++) {
    const PetscInt i = at->block - 2 + k, c = i * self->of + 1;
    if (i < 0) continue;
    turn->column[c] -= force * drag * (x->slide + L_t) * at->y[k];
    turn->column_b[c] += force * drag * at->p * at->y[k];
    turn->row_b[c] += arm * at->y[k];
  }
  turn->corner[self->turned] += gives * press * x->g - arm * (x->slide + L_t);
  turn->corner_b[self->turned] += arm * at->p;
}

/* The rows of k and f of a point, and what k does to the mechanics. */
static PetscErrorCode AddPoint(Senses *self, PetscInt i, PetscReal t, PetscReal L_t,
                               PetscReal gives, PetscReal force) {
  const Tropism *law = &self->scene->tropism;
  const Pencil p = self->pencil;
  PetscInt k, f;
  PetscReal edge;
  At at;

  PetscFunctionBegin;
  PetscCall(PointAt(self, i, t, &at));
  PetscCall(EdgeDrift(self, &at, t, &edge));
  k = PlaceK(self, at.block, at.q);
  f = PlaceF(self, at.block, at.q);
  self->scale = PetscMax(self->scale, at.clock);
  for (PetscInt j = 0; j < 3; j++) {
    const PetscInt node = at.block - 1 + j;
    const PetscReal curve = at.w1[j] / at.x->g - at.w[j] * at.x->g_z / PetscSqr(at.x->g);
    if (node < 0 || PencilIsHeld(p, node, 0)) continue;
    PetscCall(Add(self, node * self->of, k, force * at.x->dz * at.x->B * curve, 0));
    PetscCall(Add(self, k, node * self->of,
                  at.clock * (law->ironing - law->proprioception) * curve / at.x->g, 0));
  }
  PetscCall(Add(self, k, k, -at.clock * law->ironing, 1));
  PetscCall(AddDrift(self, &at, PlaceK(self, at.block, 0), 1, edge));
  if (self->turned >= 0) Lift(self, &at, L_t, gives, force);
  if (self->signal >= 0)
    self->global[self->signal].column[k] = at.clock;
  else if (!Remembers(self))
    PetscCall(AddSensed(self, &at, k, at.clock));
  else {
    PetscCall(Add(self, k, f, at.clock, 0));
    PetscCall(Add(self, f, f, -1, law->memory));
    PetscCall(AddDrift(self, &at, PlaceF(self, at.block, 0), law->memory, edge));
    PetscCall(AddSensed(self, &at, f, 1));
  }
  PetscFunctionReturn(0);
}

/* What the tip sends, T f_t = S - f; of all splines the last of each kind is not 0 there, but 1. */
static PetscErrorCode AddSignal(Senses *self, PetscReal t, PetscReal L) {
  const Pencil p = self->pencil;
  const PetscInt last = (p->n - 1) * self->of, turned = self->turned;
  PetscReal turn, aside;
  SensesGlobal *signal = self->global + self->signal;

  PetscFunctionBegin;
  if (self->signal < 0) PetscFunctionReturn(0);
  PetscCall(Sense(self, 1, t, &turn, &aside));
  if (!PencilIsHeld(p, p->n - 1, 0)) signal->row[last] = -turn / p->tip.g;
  if (!PencilIsHeld(p, p->n - 1, 1)) signal->row[last + 1] = -aside;
  signal->corner[self->signal] = -1;
  signal->corner_b[self->signal] = self->scene->tropism.memory;
  if (turned < 0) PetscFunctionReturn(0);
  signal->corner[turned] = -turn - aside * L;
  if (self->moved >= 0) signal->corner[self->moved] = -aside;
  PetscFunctionReturn(0);
}

/* What has gone by the clamp's place: its bend there, that learned and, of the forces along the
   rod, the elastic one; those of the tip are here. */
static PetscErrorCode AddLaidDown(Senses *self, PetscReal L, PetscReal L_t, PetscReal gives,
                                  PetscReal force) {
  SensesGlobal *turn = self->global + self->turned, *move = self->global + self->moved;
  const PencilTip *tip = &self->pencil->tip;
  const PetscInt last = (self->pencil->n - 1) * self->of;
  PetscReal edge[GAUSS];

  PetscFunctionBegin;
  if (self->turned < 0) PetscFunctionReturn(0);
  LagrangeValues(GAUSS, gauss_point, 0, edge);
  for (PetscInt q = 0; q < GAUSS; q++)
    turn->row[PlaceK(self, self->pencil->ahead, q)] = L_t * edge[q];
  turn->column[last + 1] -= force * (tip->turns + tip->drags * L_t);
  turn->column_b[last + 1] += force * tip->drags * L;
  turn->row[last] -= gives * L * tip->turns / tip->g;
  turn->row_b[last + 1] += gives * L * tip->drags;
  turn->corner[self->turned] -= gives * L * (tip->turns + tip->drags * L_t);
  turn->corner_b[self->turned] += 1 + gives * L * L * tip->drags;
  if (self->moved < 0) PetscFunctionReturn(0);
  move->corner[self->turned] = L_t;
  move->corner_b[self->moved] = 1;
  PetscFunctionReturn(0);
}

/* All at a time. */
static PetscErrorCode SetTime(Senses *self, PetscReal t) {
  PetscReal L, L_t, B, gives, force;

  PetscFunctionBegin;
  PetscCall(MakeMesh(self, t));
  PetscCall(PencilSetTime(self->pencil, t, FrameOf(self->scene->growth)));
  PetscCall(GrowthLength(self->scene->growth, t, &L, &L_t));
  PetscCall(SceneStiffness(self->scene, 0, t, &B, NULL));
  gives = L_t / (B * StraightRatio(self->scene, self->way));
  force = exp2(round(3 * log2(L)));
  self->entries = 0;
  self->scale = 0;
  for (PetscInt g = 0; g < self->globals; g++) {
    SensesGlobal *global = self->global + g;
    PetscCall(PetscArrayzero(global->column, 4 * self->n));
    PetscCall(PetscArrayzero(global->corner_b, MOST_GLOBAL));
    PetscCall(PetscArrayzero(global->corner, MOST_GLOBAL));
  }
  PetscCall(AddMechanics(self, force));
  for (PetscInt i = 0; i < self->cells * GAUSS; i++)
    PetscCall(AddPoint(self, i, t, L_t, gives, force));
  PetscCall(AddSignal(self, t, L));
  PetscCall(AddLaidDown(self, L, L_t, gives, force));
  PetscFunctionReturn(0);
}

/* A - rate B, factored: of complex rates, (A - re B) and im B in pairs of rows. */
typedef struct {
  Band band;
  PetscInt per; /* rows of one: 1, or 2 of a complex rate */
  PetscReal re, im;
  PetscReal *reply; /* (A - rate B)^-1 of columns of globals [2 globals][n per] */
  PetscReal loop[4 * PetscSqr(MOST_GLOBAL)]; /* their own rows without all else, by columns */
} Factored;

static PetscErrorCode FactoredDestroy(Factored *self) {
  PetscFunctionBegin;
  PetscCall(BandDestroy(&self->band));
  PetscCall(PetscFree(self->reply));
  PetscFunctionReturn(0);
}

/* a - rate b at (i, j) of two by two, row and column of complex numbers. */
static PetscReal Entry(const Factored *at, PetscInt i, PetscInt j, PetscReal a, PetscReal b) {
  if (i == j) return a - at->re * b;
  return (i ? -1 : 1) * at->im * b;
}

/* The rows of globals, of A - rate B, times z. */
static void Asked(const Senses *self, const Factored *at, const PetscReal z[], PetscReal sum[]) {
  const PetscInt per = at->per;

  for (PetscInt k = 0; k < self->globals * per; k++) {
    const SensesGlobal *global = self->global + k / per;
    sum[k] = 0;
    for (PetscInt i = 0; i < self->n * per; i++)
      sum[k] += Entry(at, k % per, i % per, global->row[i / per], global->row_b[i / per]) * z[i];
  }
}

/* With z = z0 - reply f the rows of globals are (corner - row reply) f = r - row z0, of A - rate B.
 */
static PetscErrorCode CloseLoops(const Senses *self, Factored *at) {
  const PetscInt per = at->per, all = self->globals * per;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(all * self->n * per, &at->reply));
  for (PetscInt j = 0; j < all; j++) {
    const SensesGlobal *global = self->global + j / per;
    PetscReal *reply = at->reply + j * self->n * per, *column = at->loop + j * all;
    for (PetscInt i = 0; i < self->n * per; i++)
      reply[i] = Entry(at, i % per, j % per, global->column[i / per], global->column_b[i / per]);
    PetscCall(BandSolve(&at->band, PETSC_FALSE, 1, reply));
    Asked(self, at, reply, column);
    for (PetscInt i = 0; i < all; i++) {
      const SensesGlobal *row = self->global + i / per;
      column[i] =
          Entry(at, i % per, j % per, row->corner[j / per], row->corner_b[j / per]) - column[i];
    }
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode FactorAt(const Senses *self, PetscReal re, PetscReal im, PetscInt per,
                               Factored *at) {
  const PetscInt half = per * (HALF + 1) * self->of - 1;

  PetscFunctionBegin;
  *at = (Factored){.per = per, .re = re, .im = im};
  PetscCall(BandCreate(self->n * per, half, half, &at->band));
  for (PetscInt k = 0; k < self->entries; k++) {
    const SensesEntry *e = self->entry + k;
    for (PetscInt i = 0; i < per; i++)
      for (PetscInt j = 0; j < per; j++)
        *BandAt(&at->band, e->row * per + i, e->col * per + j) += Entry(at, i, j, e->a, e->b);
  }
  PetscCall(BandFactorShifted(&at->band));
  PetscCall(CloseLoops(self, at));
  PetscFunctionReturn(0);
}

/* z = (A - rate B)^-1 z, in place; f: of globals. */
static PetscErrorCode SolveAt(const Senses *self, const Factored *at, PetscReal z[],
                              PetscReal f[]) {
  const PetscInt per = at->per, all = self->globals * per;
  PetscReal loop[4 * PetscSqr(MOST_GLOBAL)], sum[2 * MOST_GLOBAL];

  PetscFunctionBegin;
  PetscCall(BandSolve(&at->band, PETSC_FALSE, 1, z));
  if (!all) PetscFunctionReturn(0);
  Asked(self, at, z, sum);
  for (PetscInt k = 0; k < all; k++) f[k] -= sum[k];
  PetscCall(PetscArraycpy(loop, at->loop, all * all));
  PetscCall(DenseSolve(all, loop, f));
  for (PetscInt j = 0; j < all; j++)
    for (PetscInt i = 0; i < self->n * per; i++) z[i] -= at->reply[j * self->n * per + i] * f[j];
  PetscFunctionReturn(0);
}

/* (b, fb) = B (z, f). */
static void ApplyB(const Senses *self, PetscInt per, const PetscReal z[], const PetscReal f[],
                   PetscReal b[], PetscReal fb[]) {
  for (PetscInt i = 0; i < self->n * per; i++) b[i] = 0;
  for (PetscInt k = 0; k < self->entries; k++) {
    const SensesEntry *e = self->entry + k;
    for (PetscInt part = 0; part < per && e->b != 0; part++)
      b[e->row * per + part] += e->b * z[e->col * per + part];
  }
  for (PetscInt k = 0; k < self->globals * per; k++) {
    const SensesGlobal *global = self->global + k / per;
    fb[k] = 0;
    for (PetscInt g = 0; g < self->globals; g++)
      fb[k] += global->corner_b[g] * f[g * per + k % per];
    for (PetscInt i = 0; i < self->n; i++) {
      fb[k] += global->row_b[i] * z[i * per + k % per];
      b[i * per + k % per] += global->column_b[i] * f[k];
    }
  }
}

/* The unknowns that have a rate: deflections, k and f. */
static PetscInt Moving(const Senses *self, PetscInt which[]) {
  PetscInt m = 0;

  for (PetscInt i = 0; i < self->n; i++) {
    const PetscInt kind = i % self->of, block = i / self->of, cell = block - self->pencil->ahead;
    if (kind == 1 ? !PencilIsHeld(self->pencil, block, 1)
                  : kind >= NODE && cell >= 0 && cell < self->cells)
      which[m++] = i;
  }
  return m;
}

/* (A - shift B)^-1 B as a dense matrix of these, and of globals, by columns. */
static PetscErrorCode Dense(const Senses *self, PetscReal shift, PetscInt m, PetscInt all,
                            const PetscInt which[], PetscReal T[]) {
  PetscReal *z, *b;
  Factored at;

  PetscFunctionBegin;
  PetscCall(FactorAt(self, shift, 0, 1, &at));
  PetscCall(PetscMalloc2(self->n, &z, self->n, &b));
  for (PetscInt j = 0; j < all; j++) {
    PetscReal f[2 * MOST_GLOBAL] = {0}, fb[2 * MOST_GLOBAL];
    PetscCall(PetscArrayzero(z, self->n));
    if (j < m)
      z[which[j]] = 1;
    else
      f[j - m] = 1;
    ApplyB(self, 1, z, f, b, fb);
    PetscCall(SolveAt(self, &at, b, fb));
    for (PetscInt i = 0; i < all; i++) T[j * all + i] = i < m ? b[which[i]] : fb[i - m];
  }
  PetscCall(PetscFree2(z, b));
  PetscCall(FactoredDestroy(&at));
  PetscFunctionReturn(0);
}

/* Rates that are so small a part of the law's own are those of what neither grows nor fades, and
   round-off: of the very tip of a growth zone, and of bends that no one senses or straightens. */
static const PetscReal neutral = 1e-7;

/* The rate with the largest real part, but for those that are neutral, of 1/(rate - shift). */
static void Rightmost(const Senses *self, PetscInt m, PetscReal shift, const PetscReal re[],
                      const PetscReal im[], Eigenvalue *value) {
  const PetscReal lost = 1e-13;
  PetscReal most = 0;

  for (PetscInt i = 0; i < m; i++) most = PetscMax(most, hypot(re[i], im[i]));
  *value = (Eigenvalue){.value = PETSC_MIN_REAL};
  for (PetscInt i = 0; i < m; i++) {
    const PetscReal size = PetscSqr(re[i]) + PetscSqr(im[i]), at = shift + re[i] / size;
    if (PetscSqrtReal(size) <= lost * most || at <= value->value) continue;
    if (hypot(at, im[i] / size) < neutral * self->scale) continue;
    value->value = at;
    value->frequency = PetscAbsReal(im[i]) / size;
  }
}

/*
  SensesRightmost - the eigenvalue with the largest real part, from the whole dense spectrum; for
  few cells.
*/
PetscErrorCode SensesRightmost(Senses *self, PetscReal t, Eigenvalue *value) {
  PetscReal *T, *re, *im, shift;
  PetscInt m, all, *which;

  PetscFunctionBegin;
  PetscCall(SetTime(self, t));
  PetscCall(PencilBound(self->pencil, &shift));
  shift += self->scale * (1 + self->scene->tropism.ironing);
  PetscCall(PetscMalloc1(self->n, &which));
  m = Moving(self, which);
  all = m + self->globals;
  PetscCall(PetscMalloc3(all * all, &T, all, &re, all, &im));
  PetscCall(Dense(self, shift, m, all, which, T));
  PetscCall(DenseEigenvalues(all, T, re, im, NULL));
  Rightmost(self, all, shift, re, im, value);
  PetscCall(PetscFree3(T, re, im));
  PetscCall(PetscFree(which));
  PetscFunctionReturn(0);
}

/* The real part of c and w of a complex solution. */
static void ModeOf(const Senses *self, const PetscReal z[], PetscReal c[], PetscReal w[]) {
  for (PetscInt i = 0; i < self->pencil->n && c; i++) {
    w[i] = z[2 * i * self->of];
    c[i] = z[2 * (i * self->of + 1)];
  }
}

/* x times conj(y), over |y|^2. */
static void Divide(const PetscReal x[2], const PetscReal y[2], PetscReal ratio[2]) {
  const PetscReal size = PetscSqr(y[0]) + PetscSqr(y[1]), re = x[0] * y[0] + x[1] * y[1],
                  im = x[1] * y[0] - x[0] * y[1];

  ratio[0] = re / size;
  ratio[1] = im / size;
}

/* One step of inverse iteration of a mode (z, f), b is room: off, by how much its rate is off the
   shift, from where it is largest, and 1 after that. */
static PetscErrorCode Iterate(const Senses *self, const Factored *at, PetscReal z[], PetscReal f[],
                              PetscReal b[], PetscReal off[2]) {
  PetscReal most = -1, now[2], fb[2 * MOST_GLOBAL];
  PetscInt best = 0;

  PetscFunctionBegin;
  ApplyB(self, 2, z, f, b, fb);
  PetscCall(SolveAt(self, at, b, fb));
  for (PetscInt i = 0; i < self->n; i++) {
    const PetscReal size = hypot(b[2 * i], b[2 * i + 1]);
    if (i % self->of == 0 || i % self->of == 2 || size <= most) continue;
    most = size;
    best = i;
  }
  PetscCall(PetscArraycpy(now, b + 2 * best, 2));
  Divide(z + 2 * best, now, off);
  for (PetscInt i = 0; i < self->n; i++) Divide(b + 2 * i, now, z + 2 * i);
  for (PetscInt g = 0; g < self->globals; g++) Divide(fb + 2 * g, now, f + 2 * g);
  PetscFunctionReturn(0);
}

/*
  SensesNear - the eigenvalue next to one that a coarser mesh has, by inverse iteration.

  value  in: where to look; out: what is there
  c, w   the real part of its mode, as of SpectrumLargest(); NULL: not asked for
*/
PetscErrorCode SensesNear(Senses *self, PetscReal t, Eigenvalue *value, PetscReal c[],
                          PetscReal w[]) {
  enum { HOLD = 3, MOST = 14 };
  const PetscReal found = 1e-14, round_off = 1e-10;
  PetscReal *z, *b, f[2 * MOST_GLOBAL] = {1}, off[2] = {0, 0},
                          rate[2] = {value->value, value->frequency}, size = 0;
  Factored at;

  PetscFunctionBegin;
  PetscCall(SetTime(self, t));
  PetscCall(PetscMalloc2(2 * self->n, &z, 2 * self->n, &b));
  for (PetscInt i = 0; i < 2 * self->n; i++) z[i] = 1. / (PetscReal)(1 + i % 7);
  PetscCall(FactorAt(self, rate[0], rate[1], 2, &at));
  for (int k = 0; k < HOLD; k++) PetscCall(Iterate(self, &at, z, f, b, off));
  for (int k = 0; k < MOST; k++) {
    const PetscReal last = size;
    rate[0] += off[0];
    rate[1] += off[1];
    PetscCall(FactoredDestroy(&at));
    PetscCall(FactorAt(self, rate[0], rate[1], 2, &at));
    PetscCall(Iterate(self, &at, z, f, b, off));
    size = hypot(off[0], off[1]);
    if (size <= found * hypot(rate[0], rate[1]) || (k > 2 && size > last / 2)) break;
  }
  PetscCall(FactoredDestroy(&at));
  value->value = rate[0];
  value->frequency = PetscAbsReal(rate[1]) > round_off * self->scale ? PetscAbsReal(rate[1]) : 0;
  value->error = size;
  ModeOf(self, z, c, w);
  PetscCall(PetscFree2(z, b));
  PetscFunctionReturn(0);
}
