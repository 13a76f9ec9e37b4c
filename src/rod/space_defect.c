/* How well the cells of the model of space resolve the state that they have found (pair_defect.h).
   A cell of order 2 is held against order 4. Where walls alone feel the spin, the rate of the
   quaternion in the middle of a cell is the mean of both ends', which is of order 2: it is held
   against the parabola through three nodes. */
#include "rod/pair_defect.h"
#include "base/vectors.h"
#include "rod/space_cells.h"

/* Two cells beside each other, or one: their points, laws and duals from the first on. */
typedef struct {
  const Load *load, *bare, *seen; /* that of the rod; without walls; that of these cells */
  PetscReal part;                 /* of the pressure of walls that counts; 1: all */
  PetscReal gives;                /* (l/h)^4, or 1: stiffness of the rod over a cell over k */
  PetscReal h[2];
  const Law *law;
  const FrictionDual *dual[PLACES]; /* at the points */
  const PetscReal (*push)[3];       /* what strands add to n' at these points; NULL: none */
  const PetscReal (*couple)[3];     /* and to m'; NULL: none */
  PetscReal feet[2][FOOT_LOAD];     /* what feet add in the middle of each */
  Point p[PLACES];
  PetscReal wall[PLACES][3];       /* what walls add to n' */
  PetscReal value[PLACES][FIELDS]; /* f at them, as the defect looks at it */
} Cells;

/* The point at a + z h on the cubics through a and b; it has the rate of turning of point k, which
   is known there, and a place that may stick its velocity, too. */
static void PointOnCubic(const Cells *cells, int k, const Law *law_b, PetscReal z, PetscReal h,
                         const Point *b, Point *p) {
  const Point *a = cells->p, *at = a + k;
  const Law *law = cells->law + k;
  const Load *load = cells->seen;
  PetscReal wa[3], wb[3];

  p->at = at->at;
  VelocitySlope(cells->law, a, wa);
  VelocitySlope(law_b, b, wb);
  for (int i = 0; i < 4; i++) {
    p->p[i] = HermiteAt(z, h, a->p[i], a->f[P + i], b->p[i], b->f[P + i]);
    p->p_t[i] = at->p_t[i];
  }
  for (int i = 0; i < 3; i++) {
    p->m[i] = HermiteAt(z, h, a->m[i], a->f[M + i], b->m[i], b->f[M + i]);
    p->n[i] = HermiteAt(z, h, a->n[i], a->f[N + i], b->n[i], b->f[N + i]);
    p->at.x[i] = HermiteAt(z, h, a->at.x[i], a->f[X + i], b->at.x[i], b->f[X + i]);
  }
  PointStrains(load, law, p);
  if (load->radius > 0)
    p->at.v[SPIN] =
        load->arm *
        (HermiteAt(z, h, QuaternionSpin(a->p, a->size, a->p_t), NodeSpinSlope(cells->law, a),
                   QuaternionSpin(b->p, b->size, b->p_t), NodeSpinSlope(law_b, b)) +
         law->c * p->u[0]);
  for (int i = 0; i < 3; i++)
    p->at.v[i] = HermiteAt(z, h, a->at.v[i] - cells->law->c * a->at.axes[0][i], wa[i],
                           b->at.v[i] - law_b->c * b->at.axes[0][i], wb[i]) +
                 law->c * p->at.axes[0][i];
  for (int i = 0; i < RUBS && LoadSticks(load); i++) p->at.v[i] = at->at.v[i];
  PointEvaluate(load, law, cells->dual[k], p);
}

/* What the mean of the rates of turning does in the middle of cell k of two. */
static void AddTurning(const Cells *cells, int k, PetscReal defect[MAX_FIELDS]) {
  const Point *a = cells->p, *b = a + 2, *c = a + 4;
  Point taken = cells->p[2 * k + 1], better = taken;
  const PetscReal h = cells->h[0] + cells->h[1], place[3] = {0, cells->h[0], h},
                  z = k ? (cells->h[0] + h) / 2 : cells->h[0] / 2;
  const Law *law = cells->law + 2 * k + 1;
  PetscReal L[3];

  LagrangeValues(3, place, z, L);
  for (int i = 0; i < 4; i++)
    better.p_t[i] = L[0] * a->p_t[i] + L[1] * b->p_t[i] + L[2] * c->p_t[i];
  PointStrains(cells->load, law, &better);
  PointEvaluate(cells->load, law, cells->dual[2 * k + 1], &better);
  PointEvaluate(cells->load, law, cells->dual[2 * k + 1], &taken); /* (without what strands do) */
  for (int f = M; f < FIELDS; f++)
    defect[f] += cells->part * cells->h[k] * 4 / 6 * (taken.f[f] - better.f[f]);
}

/*
  f at so many points without what strands do there. They press where they cross, over a cell or so,
  and of that no difference tells anything; but what they do is handed to the points so that force
  and moments are kept, whatever the cells (curve/spread.h). Counted as what other loads are off by,
  it left a part of each strand's pressure without its opposite. Of what walls do, that part counts.
*/
static void Strip(Cells *cells, int points, PetscReal part) {
  for (int j = 0; j < points; j++) {
    PetscReal *bare = cells->value[j], with[FIELDS];

    memcpy(bare, cells->p[j].f, sizeof(cells->value[j]));
    for (int d = 0; d < 3; d++) {
      if (cells->push) bare[N + d] -= cells->push[j][d];
      if (cells->couple) bare[M + d] -= cells->couple[j][d];
      if (j % 2) bare[N + d] -= cells->feet[j / 2][d];
      if (j % 2) bare[M + d] -= cells->feet[j / 2][3 + d];
    }
    memcpy(with, bare, sizeof(with));
    if (part < 1) {
      Point p = cells->p[j];
      PointEvaluate(cells->bare, cells->law + j, cells->dual[j], &p);
      for (int f = M; f < FIELDS; f++) bare[f] += (1 - part) * (p.f[f] - bare[f]);
      for (int d = 0; d < 3; d++) cells->wall[j][d] = with[N + d] - p.f[N + d];
    }
  }
}

/*
  What walls push with at single points, the rule integrates as it is, in forces and moments: n
  jumps there, and m' with it, and no smooth curve goes through them. So what walls add to n from
  the first point on is taken out of m' = -g d1 x n, too.
*/
static void StripMoments(Cells *cells) {
  PetscReal n[3] = {0};

  for (int k = 0; k < 2; k++) {
    const PetscReal h = cells->h[k], (*wall)[3] = (const PetscReal(*)[3])cells->wall + 2 * k;
    PetscReal end[3], mid[3];
    for (int d = 0; d < 3; d++) {
      end[d] = n[d] + h * (wall[0][d] + 4 * wall[1][d] + wall[2][d]) / 6;
      mid[d] = (n[d] + end[d]) / 2 + h * (wall[0][d] - wall[2][d]) / 8;
    }
    for (int e = 1; e < 3; e++) {
      const PetscReal *w = e == 1 ? mid : end, *q = cells->p[2 * k + e].at.axes[0],
                      g = cells->law[2 * k + e].g;
      PetscReal turned[3];
      Cross3(q, w, turned);
      for (int d = 0; d < 3; d++) cells->value[2 * k + e][M + d] += g * turned[d];
    }
    memcpy(n, end, sizeof(n));
  }
}

/* What walls add to n' in cell k, at z of it, on the rod's cubic. */
static void WallAt(const Cells *cells, int k, PetscReal z, PetscReal wall[3]) {
  const Point *a = cells->p + 2 * k, *b = a + 2;
  const Law *law = cells->law + 2 * k + 1;
  const FrictionDual *dual = cells->dual[2 * k + 1];
  const PetscReal h = cells->h[k];
  Point with = a[1], without;

  for (int i = 0; i < 4; i++)
    with.p[i] = HermiteAt(z, h, a->p[i], a->f[P + i], b->p[i], b->f[P + i]);
  for (int i = 0; i < 3; i++)
    with.at.x[i] = HermiteAt(z, h, a->at.x[i], a->f[X + i], b->at.x[i], b->f[X + i]);
  PointStrains(cells->load, law, &with);
  without = with;
  PointEvaluate(cells->load, law, dual, &with);
  PointEvaluate(cells->bare, law, dual, &without);
  for (int d = 0; d < 3; d++) wall[d] = with.f[N + d] - without.f[N + d];
}

/* A rod that touches walls is held off them at its points, and between these its curve may be
   deeper or less deep: how the pressure would differ with twice the points. Where that is of a
   layer l shorter than a cell, the rod gives way by that depth, with its own stiffness over the
   cell, B/h^4 = k (l/h)^4. */
static void AddBetween(const Cells *cells, PetscReal defect[MAX_FIELDS]) {
  PetscReal any = 0;

  for (int j = 0; j < PLACES; j++)
    for (int d = 0; d < 3; d++) any += PetscAbsReal(cells->wall[j][d]);
  for (int k = 0; k < 2 && any > 0; k++) {
    PetscReal first[3], second[3];
    WallAt(cells, k, 0.25, first);
    WallAt(cells, k, 0.75, second);
    for (int d = 0; d < 3; d++) {
      const PetscReal a = cells->wall[2 * k][d], m = cells->wall[2 * k + 1][d],
                      b = cells->wall[2 * k + 2][d];
      defect[N + d] += rod_rule.pressure_between * cells->gives * cells->h[k] / 12 *
                       (a + 6 * m + b - 4 * first[d] - 4 * second[d]);
    }
  }
}

/* Of two cells of order 4. */
static void PairDefect(Cells *cells, PetscReal defect[MAX_FIELDS]) {
  const PetscReal h1 = cells->h[0], h2 = cells->h[1];
  const Point *p = cells->p;
  const PetscBool walls = (PetscBool)(cells->load->arm > 0 && cells->load->radius == 0);
  PetscReal weight[PLACES];
  Point cubic;

  PairWeights(h1, h2, weight);
  PointOnCubic(cells, 2, cells->law + 4, h1 / (h1 + h2), h1 + h2, p + 4, &cubic);
  Strip(cells, PLACES, cells->part < 1 ? 0 : 1);
  if (cells->part < 1) StripMoments(cells);
  for (int f = 0; f < FIELDS; f++) {
    PetscReal value[PLACES];
    for (int j = 0; j < PLACES; j++) value[j] = cells->value[j][f];
    defect[f] = PairRule(h1, h2, weight, value);
    if (f < M || cells->part == 1) defect[f] += PairCubic(h1, h2, value[2], cubic.f[f]);
  }
  if (cells->part < 1) AddBetween(cells, defect);
  for (int k = 0; k < 2 && walls && !LoadSticks(cells->load); k++) AddTurning(cells, k, defect);
}

/* Of a cell of order 2. */
static void CellDefect(Cells *cells, PetscReal defect[MAX_FIELDS]) {
  const PetscReal h = cells->h[0];
  const Point *p = cells->p;
  Point cubic;

  PointOnCubic(cells, 1, cells->law + 2, 0.5, h, p + 2, &cubic);
  Strip(cells, 3, cells->part);
  for (int f = 0; f < FIELDS; f++)
    defect[f] = h * (cells->value[AT_MID][f] -
                     (cells->value[AT_A][f] + 4 * cubic.f[f] + cells->value[AT_B][f]) / 6);
}

/* Cell i becomes number k of those. */
static void Take(const Cell *cell, PetscInt i, int k, Cells *cells) {
  if (!k) {
    cells->law = cell->law;
    cells->part =
        cells->load->walls ? PairSees(&cell->rod->scene->contact, cell->law[AT_B].g * cell->h) : 1;
    cells->gives = PetscMin(
        1, PetscPowRealInt(cell->rod->scene->contact.tip / (cell->law[AT_B].g * cell->h), 4));
    cells->seen = cells->part < 1 ? cells->bare : cells->load;
    cells->push = cell->push ? cell->push + 2 * i : NULL;
    cells->couple = cell->couple ? cell->couple + 2 * i : NULL;
  }
  for (int e = 0; e < 3; e++) cells->dual[2 * k + e] = cell->dual[e];
  cells->h[k] = cell->h;
  for (int d = 0; d < FOOT_LOAD; d++) cells->feet[k][d] = cell->feet.n ? cell->foot_load[1][d] : 0;
  cells->p[2 * k] = *cell->a;
  cells->p[2 * k + 1] = *cell->mid;
  cells->p[2 * k + 2] = *cell->b;
}

/* The second of two cells becomes the first. */
static void Shift(Cells *cells) {
  cells->h[0] = cells->h[1];
  cells->law += 2;
  if (cells->push) cells->push += 2;
  if (cells->couple) cells->couple += 2;
  memcpy(cells->feet[0], cells->feet[1], sizeof(cells->feet[0]));
  for (int e = 0; e < 3; e++) {
    cells->dual[e] = cells->dual[2 + e];
    cells->p[e] = cells->p[2 + e];
  }
}

/*
  Of order 4, of a rod with double nodes, across which moment and force jump, on one rank: two by
  two between them. The last of an odd number is looked at with the one before it, and has its part
  of what both fail by; one alone is not looked at.
*/
static void DefectBetween(Cell *cell, Cells *cells, PetscReal (*defect)[MAX_FIELDS]) {
  const PetscInt last = cell->rod->last;
  PetscInt taken = 0;

  for (PetscInt i = 0; i < last; i++) {
    SpaceCellsNext(cell, i);
    if (cell->h == 0) {
      taken = 0;
      continue;
    }
    if (taken > 0 && taken % 2 == 0 && (i + 1 == last || cell->s[i + 2] == cell->s[i + 1])) {
      Shift(cells);
      Take(cell, i, 1, cells);
      PairDefect(cells, defect[i + 1]);
      for (int f = 0; f < FIELDS; f++)
        defect[i + 1][f] *= cells->h[1] / (cells->h[0] + cells->h[1]);
    } else {
      Take(cell, i, (int)(taken % 2), cells);
      if (taken % 2) PairDefect(cells, defect[i]);
    }
    taken++;
  }
}

/*
  SpaceDefect - by how much a state fails the equations between the collocation points, as the
  equations of cells count it (an integral over the cell). Collective.

  defect  one for each owned node. Order 4: of the two cells beside it, at odd nodes; order 2: of
          the cell before it; else 0. Behind a double node, of the two that begin or end there
*/
PetscErrorCode SpaceDefect(Rod rod, const RodState *at, PetscReal (*defect)[MAX_FIELDS]) {
  const PetscBool fourth = (PetscBool)(rod->order == 4);
  Load bare = rod->scene->load;
  Cells cells;
  Cell cell;

  PetscFunctionBegin;
  bare.walls = NULL;
  cells.bare = &bare;
  PetscCall(PetscArrayzero(defect, rod->end - rod->first));
  PetscCall(SpaceCellsOpen(rod, at, &cell));
  cells.load = cell.load;
  if (fourth && rod->scene->mesh.doubles) {
    DefectBetween(&cell, &cells, defect);
    PetscCall(SpaceCellsClose(&cell));
    PetscFunctionReturn(0);
  }
  for (PetscInt i = PetscMax(rod->first - 1, 0); i < PetscMin(rod->end, rod->last); i++) {
    SpaceCellsNext(&cell, i);
    if (!fourth) {
      if (cell.h == 0) continue;
      Take(&cell, i, 0, &cells);
      if (i + 1 >= rod->first && i + 1 < rod->end) CellDefect(&cells, defect[i + 1 - rod->first]);
    } else if (i % 2 == 0)
      Take(&cell, i, 0, &cells);
    else if (i >= rod->first && i > 0) {
      Take(&cell, i, 1, &cells);
      PairDefect(&cells, defect[i - rod->first]);
    }
  }
  PetscCall(SpaceCellsClose(&cell));
  PetscFunctionReturn(0);
}
