/* How well the frame model's cells resolve the state that they have found (pair_defect.h). A cell
   of order 2 is held against order 4. */
#include "rod/frame.h"
#include "rod/pair_defect.h"

/* The point at a + z h on the cubics through a and b; at: the point that is known there, whose
   velocity a place that may stick keeps, for what is held does not depend on it. */
static void PointOnCubic(const Load *load, const Law *law_a, const Law *law, const Law *law_b,
                         const FrictionDual *dual, PetscReal z, PetscReal h, const Point *a,
                         const Point *b, PetscReal turn_a, PetscReal turn_b, const Point *at,
                         Point *p) {
  PetscReal wa[2], wb[2];

  VelocitySlope(law_a, a, turn_a, wa);
  VelocitySlope(law_b, b, turn_b, wb);
  p->theta = HermiteAt(z, h, a->theta, a->f[TH], b->theta, b->f[TH]);
  p->m = HermiteAt(z, h, a->m, a->f[M], b->m, b->f[M]);
  p->at.t = at->at.t;
  p->at.x[2] = 0;
  p->at.q[0] = PetscCosReal(p->theta);
  p->at.q[1] = PetscSinReal(p->theta);
  for (int d = 0; d < 2; d++) {
    p->n[d] = HermiteAt(z, h, a->n[d], a->f[N1 + d], b->n[d], b->f[N1 + d]);
    p->at.x[d] = HermiteAt(z, h, a->at.x[d], a->f[X1 + d], b->at.x[d], b->f[X1 + d]);
    p->at.v[d] = HermiteAt(z, h, a->at.v[d] - law_a->c * a->at.q[d], wa[d],
                           b->at.v[d] - law_b->c * b->at.q[d], wb[d]) +
                 law->c * p->at.q[d];
    if (LoadSticks(load)) p->at.v[d] = at->at.v[d];
  }
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
    for (int d = 0; d < 2; d++)
      value[N1 + d][j] += (1 - part) * (frame->law[k + j].g * bare[d] - p->f[N1 + d]);
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
    defect[f] = h * (p[1].f[f] - (p[0].f[f] + 4 * cubic.f[f] + p[2].f[f]) / 6);
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
