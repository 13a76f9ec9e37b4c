#include "rod/yields.h"
#include <string.h>

/* YieldsPart - y, the part of its speed that growth has under a force along the rod, and its slope
   by that; slope NULL: not asked for. */
PetscReal YieldsPart(const Rod rod, PetscReal along, PetscReal *slope) {
  const PetscReal limit = rod->scene->growth->yield, y = 1 + along / limit;

  if (slope) *slope = y > 0 ? 1 / limit : 0;
  return PetscMax(0, y);
}

/* YieldsSlope - V' at a label. */
PetscReal YieldsSlope(const Rod rod, PetscReal s, PetscReal length, PetscReal along) {
  PetscReal by_length;
  return GrowthYieldWeight(rod->scene->growth, s, length, &by_length) *
         YieldsPart(rod, along, NULL);
}

/* YieldsSee - tells the law of growth what it is in a state: V, V' and L of all nodes, on every
   rank. Collective. */
PetscErrorCode YieldsSee(Rod rod, PetscReal t, Vec U, YieldsAlong along) {
  enum { VALUES = 3 };
  const PetscInt fields = rod->model->fields, n = rod->last + 1, lead = rod->learned->lead;
  const PetscReal *s = rod->scene->mesh.s, *v;
  PetscReal *all, *speed, *slope;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(VALUES * n, &all, n, &speed, n, &slope));
  PetscCall(VecGetArrayRead(U, (const PetscScalar **)&v));
  for (PetscInt i = rod->first; i < rod->end; i++) {
    const PetscReal *u = v + (i - rod->first) * fields, *w = u + lead;
    all[VALUES * i] = w[YIELDS_V];
    all[VALUES * i + 1] = YieldsSlope(rod, s[i], w[YIELDS_L], along(u));
    all[VALUES * i + 2] = w[YIELDS_L];
  }
  PetscCall(VecRestoreArrayRead(U, (const PetscScalar **)&v));
  PetscCall(LearnedGather(rod, VALUES, all));
  for (PetscInt i = 0; i < n; i++) {
    speed[i] = all[VALUES * i];
    slope[i] = all[VALUES * i + 1];
  }
  PetscCall(GrowthYieldSee(rod->scene->growth, t, n, s, all[VALUES * n - 1], speed, slope));
  PetscCall(PetscFree3(all, speed, slope));
  PetscFunctionReturn(0);
}

/* YieldsLaws - stretch and slide of nodes and middles, by the unknowns there, and the clocks of
   what is learned there: behind YieldsSee(), which the laws of the time have come from. */
void YieldsLaws(Rod rod, PetscReal bow, YieldsAlong along) {
  const Learned learned = rod->learned;
  const PetscReal *s = rod->scene->mesh.s;
  const PetscInt from = PetscMax(rod->first - 1, 0), to = PetscMin(rod->end, rod->last);
  const PetscBool by_rate = rod->scene->tropism.by_rate;
  PetscReal slope = 0, before = 0, h;

  for (PetscInt i = from; i <= to; i++, before = slope) {
    const PetscInt at = i - rod->first + 1;
    const PetscReal *w = learned->w + at * YIELDS, *w_t = learned->w_t + at * YIELDS;
    LearnedStretch *law = &learned->stretch[2 * at];
    law->g = w[YIELDS_L];
    law->g_t = w_t[YIELDS_L];
    law->c =
        i == rod->last ? 0 : w[YIELDS_V] - s[i] * w_t[YIELDS_L]; /* (the tip is its material) */
    slope = YieldsSlope(rod, s[i], w[YIELDS_L], along(learned->u + at * learned->lead));
    if (!by_rate) learned->clock[2 * at] = slope / law->g;
    if (i == from) continue;
    law[-1].g = (law[-2].g + law->g) / 2;
    law[-1].g_t = (law[-2].g_t + law->g_t) / 2;
    h = s[i] - s[i - 1];
    law[-1].c = CurveMid(bow * h, w[YIELDS_V - YIELDS], before, w[YIELDS_V], slope) -
                (s[i - 1] + s[i]) / 2 * law[-1].g_t;
    if (!by_rate)
      learned->clock[2 * at - 1] =
          (1.5 * (w[YIELDS_V] - w[YIELDS_V - YIELDS]) / h - (before + slope) / 4) / law[-1].g;
  }
}

/* YieldsResidual - of the cell between nodes i and i + 1, over which V' has this integral. */
void YieldsResidual(Rod rod, PetscInt i, PetscReal integral) {
  const Learned learned = rod->learned;
  const PetscInt at = (i - rod->first + 1) * YIELDS;
  const PetscReal *w = learned->w + at;
  PetscReal *row = learned->w_row + at;

  row[YIELDS + YIELDS_V] = w[YIELDS + YIELDS_V] - w[YIELDS_V] - integral;
  row[YIELDS_L] = w[YIELDS + YIELDS_L] - w[YIELDS_L];
}

/* YieldsEnds - of the clamp, or the tip. */
void YieldsEnds(Rod rod, PetscInt i, PetscReal along) {
  const Learned learned = rod->learned;
  const PetscInt at = (i - rod->first + 1) * YIELDS;
  const PetscReal *w = learned->w + at;

  if (i == 0)
    learned->w_row[at + YIELDS_V] =
        w[YIELDS_V] - GrowthYieldInflow(rod->scene->growth) * YieldsPart(rod, along, NULL);
  if (i == rod->last) learned->w_row[at + YIELDS_L] = learned->w_t[at + YIELDS_L] - w[YIELDS_V];
}

/* YieldsEnd - the last equation of the tip, L_t = V, by its unknowns. */
void YieldsEnd(const Rod rod, const PetscReal shift[], PetscReal by[]) {
  const PetscInt lead = rod->learned->lead;

  memset(by, 0, (size_t)rod->learned->mech * sizeof(*by));
  by[lead + YIELDS_V] = -1;
  by[lead + YIELDS_L] = shift[lead + YIELDS_L];
}

/* YieldsClocks - how the clocks of a cell's places go with an unknown of its end e: that of the
   node, e = w y/g, and that of the middle, which the law of growth has from its cubic. */
void YieldsClocks(const Rod rod, PetscInt place, int e, PetscInt unknown, PetscReal h,
                  const YieldsChange *d, PetscReal clock[3][2][LEARNED_MOST]) {
  const PetscReal *a = rod->learned->clock + place, sign = e ? 1 : -1;
  const LearnedStretch *law = rod->learned->stretch + place;

  if (rod->scene->tropism.by_rate) return;
  clock[2 * e][e][unknown] = (d->slope - a[2 * e] * d->g) / law[2 * e].g;
  clock[AT_MID][e][unknown] =
      (1.5 * sign * d->V / h - d->slope / 4 - a[AT_MID] * d->g_mid) / law[AT_MID].g;
}
