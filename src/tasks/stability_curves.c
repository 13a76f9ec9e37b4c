/* The curves of -task stability over time, and how long each is negative. */
#include "tasks/stability_run.h"
#include "base/root.h"
#include "tasks/peak.h"

/* So many times behind t_cr are looked at. */
enum { MARGIN_POINTS = 4 };

/* A change of sign is found to this part of the time: curves of norms are no better than that. */
static const PetscReal crossing_found = 1e-11;

/* One curve of one way at one time. The growth in L2 of a law that slides counts the arc length
   that enters: the norm is int y^2 dp = L int y^2 ds. */
static PetscErrorCode CurveOf(Stability *self, Solvers *of, Curve curve, PetscReal t,
                              Eigenvalue *value) {
  PetscReal L, L_t;

  PetscFunctionBegin;
  switch (curve) {
  case CURVE_A:
    if (self->learns) {
      PetscCall(SensesRightmost(&of->few, t, value));
      PetscCall(SensesNear(&of->all, t, value, NULL, NULL));
      break;
    }
    PetscCall(SpectrumLargest(&of->modes, RATE_A, t, value, NULL, NULL));
    break;
  case CURVE_FRICTION:
    PetscCall(SpectrumLargest(&of->friction, RATE_FRICTION, t, value, NULL, NULL));
    break;
  case CURVE_W:
    PetscCall(NormGrowth(&of->left, t, FRAME_ARC, value));
    break;
  default:
    PetscCall(NormGrowth(&of->l2, t, FRAME_LABEL, value));
    PetscCall(GrowthLength(self->scene->growth, t, &L, &L_t));
    if (self->scene->growth->slides) value->value += L_t / L;
  }
  PetscCallMPI(MPI_Bcast(value, sizeof(*value), MPI_BYTE, 0, self->scene->comm)); /* one verdict */
  PetscFunctionReturn(0);
}

/* One curve at one time: the larger of what it is in each way. one: of each, or NULL. */
static PetscErrorCode CurveAt(Stability *self, Curve curve, PetscReal t, Eigenvalue *value,
                              PetscReal one[]) {
  PetscFunctionBegin;
  *value = (Eigenvalue){.value = PETSC_MIN_REAL};
  for (PetscInt k = 0; k < self->ways; k++) {
    Eigenvalue found;
    PetscCall(CurveOf(self, &self->of[k], curve, t, &found));
    if (one) one[k] = found.value;
    if (found.value > value->value) *value = found;
  }
  PetscFunctionReturn(0);
}

PetscErrorCode StabilityTabulate(Stability *self) {
  const Settings *set = &self->set;

  PetscFunctionBegin;
  PetscCall(PetscPrintf(OptionsComm(), "%12s %12s", "t", "L"));
  for (int c = 0; c < CURVES; c++)
    if (self->has[c]) PetscCall(PetscPrintf(OptionsComm(), " %14s", stability_curve[c].heading));
  PetscCall(PetscPrintf(OptionsComm(), "\n"));
  for (PetscInt i = 0; i < set->points; i++) {
    PetscReal L;
    self->t[i] = set->start + (set->end - set->start) * (PetscReal)i / PetscMax(1, set->points - 1);
    PetscCall(GrowthLength(self->scene->growth, self->t[i], &L, NULL));
    PetscCall(PetscPrintf(OptionsComm(), "%12.8g %12.8g", (double)self->t[i], (double)L));
    for (int c = 0; c < CURVES; c++) {
      Eigenvalue value;
      PetscReal one[MOST_WAYS] = {0, 0};
      if (!self->has[c]) continue;
      PetscCall(CurveAt(self, (Curve)c, self->t[i], &value, one));
      self->value[c][i] = value.value;
      if (c == CURVE_A) self->frequency[i] = value.frequency;
      for (PetscInt k = 0; k < self->ways && c == CURVE_A; k++) self->modes[k][i] = one[k];
      PetscCall(PetscPrintf(OptionsComm(), " %14.7g", (double)value.value));
    }
    PetscCall(PetscPrintf(OptionsComm(), "\n"));
  }
  PetscFunctionReturn(0);
}

/* One of the curves. */
typedef struct {
  Stability *self;
  Curve curve;
} OneCurve;

/* A RootFunction, and a PeakLevel. */
static PetscErrorCode OneCurveAt(void *of, PetscReal t, PetscReal *f) {
  const OneCurve *one = (const OneCurve *)of;
  Eigenvalue value;

  PetscFunctionBegin;
  PetscCall(CurveAt(one->self, one->curve, t, &value, NULL));
  *f = value.value;
  PetscFunctionReturn(0);
}

/* The sign change of a curve in [a, b]. */
static PetscErrorCode Crossing(Stability *self, Curve curve, PetscReal a, PetscReal fa, PetscReal b,
                               PetscReal fb, PetscReal *t) {
  OneCurve one = {self, curve};

  PetscFunctionBegin;
  PetscCall(RootFind(OneCurveAt, &one, a, fa, b, fb, crossing_found, t));
  PetscFunctionReturn(0);
}

/* Is a curve, negative at a, not so at b, where that of few vertices is not? Then its first sign
   change, which is next to a nearer place `from` as far as few vertices tell. */
static PetscErrorCode Confirm(Stability *self, Curve curve, PetscReal a, PetscReal fa,
                              PetscReal from, PetscReal b, PetscReal *t, PetscBool *found) {
  Eigenvalue near, at;

  PetscFunctionBegin;
  PetscCall(CurveAt(self, curve, b, &at, NULL));
  *found = (PetscBool)(at.value >= 0);
  if (!*found) PetscFunctionReturn(0);
  PetscCall(CurveAt(self, curve, from, &near, NULL));
  if (near.value < 0)
    PetscCall(Crossing(self, curve, from, near.value, b, at.value, t));
  else
    PetscCall(Crossing(self, curve, a, fa, from, near.value, t));
  PetscFunctionReturn(0);
}

/* Between two times at which a curve is negative, or up to one at which it is not: does it change
   its sign where tables bend, or next to what stands out there? */
static PetscErrorCode WhereTablesBend(Stability *self, Curve curve, PetscReal a, PetscReal fa,
                                      PetscReal b, PetscReal *t, PetscBool *found) {
  OneCurve of = {self->few, curve};
  PeakPlace at[3] = {{.t = a}, {.t = a}, {.t = a}}, across[2];
  PetscBool above;

  PetscFunctionBegin;
  *found = PETSC_FALSE;
  if (BendsNext(&self->bends, a) >= b) PetscFunctionReturn(0);
  PetscCall(OneCurveAt(&of, a, &at[2].level));
  while (at[2].t < b && !*found) {
    at[0] = at[1];
    at[1] = at[2];
    at[2].t = PetscMin(b, BendsNext(&self->bends, at[1].t));
    PetscCall(OneCurveAt(&of, at[2].t, &at[2].level));
    above = (PetscBool)(at[2].level >= 0 && at[2].t < b);
    across[0] = at[1];
    across[1] = at[2];
    if (!above && at[1].level < 0 && at[0].t < at[1].t)
      PetscCall(PeakFind(OneCurveAt, &of, at, across, &above));
    if (above) PetscCall(Confirm(self, curve, a, fa, across[0].t, across[1].t, t, found));
  }
  PetscFunctionReturn(0);
}

/* How long a curve stays negative from the start on, judged at the points of the table, where
   tables of the scene bend between them, and, if it does all along, at a few more behind t_cr if
   that was looked for. */
PetscErrorCode StabilityVerdict(Stability *self, Curve curve) {
  const Settings *set = &self->set;
  const PetscReal *f = self->value[curve], margin = 0.01 * self->critical.length;
  PetscReal a = self->t[set->points - 1], fa = f[set->points - 1];
  PetscBool found;

  PetscFunctionBegin;
  self->until[curve] = set->start;
  if (curve == CURVE_A && self->critical.n) {
    self->until[curve] = PetscMax(set->start, self->critical.t);
    PetscFunctionReturn(0);
  }
  if (f[0] >= 0) PetscFunctionReturn(0);
  for (PetscInt i = 1; i < set->points; i++) {
    PetscCall(WhereTablesBend(self, curve, self->t[i - 1], f[i - 1], self->t[i],
                              &self->until[curve], &found));
    if (!found && f[i] >= 0)
      PetscCall(
          Crossing(self, curve, self->t[i - 1], f[i - 1], self->t[i], f[i], &self->until[curve]));
    if (found || f[i] >= 0) PetscFunctionReturn(0);
  }
  for (int k = 1; k <= MARGIN_POINTS && self->critical.n; k++) {
    PetscReal b = PetscMax(a, self->critical.t + k * margin * (k > 1));
    Eigenvalue value;
    if (k == 1) b = PetscMax(set->end, self->critical.t) + margin;
    if (b > self->scene->growth->end_time) break;
    PetscCall(WhereTablesBend(self, curve, a, fa, b, &self->until[curve], &found));
    if (found) PetscFunctionReturn(0);
    PetscCall(CurveAt(self, curve, b, &value, NULL));
    if (value.value >= 0) {
      PetscCall(Crossing(self, curve, a, fa, b, value.value, &self->until[curve]));
      PetscFunctionReturn(0);
    }
    a = b;
    fa = value.value;
  }
  self->until[curve] = a;
  self->beyond[curve] = PETSC_TRUE;
  PetscFunctionReturn(0);
}
