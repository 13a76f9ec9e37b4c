/* How well the frame model's cells resolve the state that they have found (pair_defect.h). A cell
   of order 2 is held against order 4. */
#include "rod/frame.h"
#include "rod/pair_defect.h"

static Vector2 Hermite2(PetscReal z, PetscReal h, Vector2 a, Vector2 slope_a, Vector2 b,
                        Vector2 slope_b) {
  return (Vector2){HermiteAt(z, h, a.x, slope_a.x, b.x, slope_b.x),
                   HermiteAt(z, h, a.y, slope_a.y, b.y, slope_b.y)};
}

/* The point at a + z h on the cubics through a and b; at: the point that is known there, whose
   velocity a place that may stick keeps, for what is held does not depend on it. */
static void PointOnCubic(const Load *load, const Law *law_a, const Law *law, const Law *law_b,
                         const FrictionDual *dual, PetscReal z, PetscReal h, const Point *a,
                         const Point *b, PetscReal turn_a, PetscReal turn_b, const Point *at,
                         Point *p) {
  const Vector2 wa = VelocitySlope(law_a, a, turn_a), wb = VelocitySlope(law_b, b, turn_b),
                va = Along2(From2(a->at.v), -law_a->c, From2(a->at.axes[0])),
                vb = Along2(From2(b->at.v), -law_b->c, From2(b->at.axes[0]));
  Vector2 v;

  p->theta = HermiteAt(z, h, a->theta, a->f[TH], b->theta, b->f[TH]);
  p->m = HermiteAt(z, h, a->m, a->f[M], b->m, b->f[M]);
  p->at = at->at;
  PlaceTurn2(Direction2(p->theta), &p->at);
  Put2(Hermite2(z, h, From2(a->n), From2(a->f + N1), From2(b->n), From2(b->f + N1)), p->n);
  Put2(Hermite2(z, h, From2(a->at.x), From2(a->f + X1), From2(b->at.x), From2(b->f + X1)), p->at.x);
  v = Along2(Hermite2(z, h, va, wa, vb, wb), law->c, From2(p->at.axes[0]));
  if (!LoadSticks(load)) Put2(v, p->at.v);
  PointEvaluate(load, law, dual, p);
}

/* f at the points of two cells, contact with the part of its pressure that counts. */
static void Values(const Frame *frame, const Load *load, PetscInt k, PetscReal part,
                   PetscReal value[FIELDS][PLACES]) {
  for (int j = 0; j < PLACES; j++) {
    const Point *p = frame->point + k + j;
    PetscReal bare[RUBS];

    for (int f = 0; f < FIELDS; f++) value[f][j] = p->f[f];
    if (part == 1) continue;
    LoadForce(2, load, &p->at, FrameDuals(frame, k + j), bare);
    for (int f = N1; f <= N2; f++)
      value[f][j] += (1 - part) * (frame->law[k + j].g * bare[f - N1] - p->f[f]);
  }
}

/* Of the two cells of order 4 beside the node between them, whose first point is p[0]. bare: the
   load without what walls do. */
static void PairDefect(const Frame *frame, const Contact *contact, const Load *load,
                       const Load *bare, PetscInt k, const PetscReal s[3], const PetscReal turn[3],
                       PetscReal defect[MAX_FIELDS]) {
  const PetscReal h1 = s[1] - s[0], h2 = s[2] - s[1], h = h1 + h2;
  const Point *p = frame->point + k;
  const Law *law = frame->law + k;
  const PetscReal part = PairSees(contact, law[AT_B].g * h / 2);
  PetscReal weight[PLACES], value[FIELDS][PLACES];
  const Load *seen = part < 1 ? bare : load;
  Point cubic;

  PairWeights(h1, h2, weight);
  PointOnCubic(seen, law, law + 2, law + 4, FrameDuals(frame, k + 2), h1 / h, h, p, p + 4, turn[0],
               turn[2], p + 2, &cubic);
  Values(frame, seen, k, part, value);
  for (int f = 0; f < FIELDS; f++) {
    defect[f] = PairRule(h1, h2, weight, value[f]);
    if (f < N1 || (!frame->strands && part == 1))
      defect[f] += PairCubic(h1, h2, value[f][2], cubic.f[f]);
  }
}

/* Of a cell of order 2. */
static void CellDefect(const Frame *frame, const Load *load, PetscInt k, const PetscReal s[2],
                       const PetscReal turn[2], PetscReal defect[MAX_FIELDS]) {
  const PetscReal h = s[1] - s[0];
  const Point *p = frame->point + k;
  const Law *law = frame->law + k;
  Point cubic;

  PointOnCubic(load, law, law + 1, law + 2, FrameDuals(frame, k + 1), 0.5, h, p, p + 2, turn[0],
               turn[1], p + 1, &cubic);
  for (int f = 0; f < FIELDS; f++)
    defect[f] = h * (p[AT_MID].f[f] - (p[AT_A].f[f] + 4 * cubic.f[f] + p[AT_B].f[f]) / 6);
}

/*
  FrameDefect - by how much a state, that of the latest residual, fails the equations between the
  collocation points, as the equations of cells count it (an integral over the cell). Collective.

  defect  one for each owned node. Order 4: of the two cells beside it, at odd nodes; order 2: of
          the cell before it; else 0
*/
PetscErrorCode FrameDefect(Rod rod, const RodState *at, PetscReal (*defect)[MAX_FIELDS]) {
  const Frame *frame = (const Frame *)rod->data;
  const PetscInt fields = rod->model->fields;
  const PetscReal *s = rod->scene->mesh.s, *rate;
  PetscBool fourth = (PetscBool)(rod->order == 4);
  Load bare = rod->scene->load;
  Vec local;

  PetscFunctionBegin;
  bare.walls = NULL;
  PetscCall(PetscArrayzero(defect, rod->end - rod->first));
  PetscCall(RodOpen(rod, at->U_t, &local, &rate));
  for (PetscInt i = PetscMax(1, rod->first); i < PetscMin(rod->end, rod->last + !fourth); i++) {
    PetscInt k = 2 * (i - rod->first);
    PetscReal turn[3] = {rate[(i - 1) * fields + TH], rate[i * fields + TH], 0};
    if (!fourth)
      CellDefect(frame, &rod->scene->load, k, s + i - 1, turn, defect[i - rod->first]);
    else if (i % 2) {
      turn[2] = rate[(i + 1) * fields + TH];
      PairDefect(frame, &rod->scene->contact, &rod->scene->load, &bare, k, s + i - 1, turn,
                 defect[i - rod->first]);
    }
  }
  PetscCall(RodClose(rod, &local, &rate));
  PetscFunctionReturn(0);
}
