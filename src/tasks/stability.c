#include "tasks/stability.h"
#include "tasks/critical.h"
#include "base/root.h"
#include "scene/scales.h"
#include "straight/norm.h"
#include "straight/senses.h"
#include "record/output.h"
#include "straight/transient.h"
#include "tasks/peak.h"

/* Below SHARED_VERTICES every rank solves it for itself, which is faster than to share it. */
enum { SHARED_VERTICES = 5000 };
/* Where tables bend, between the points of the table of curves, a mesh of so many vertices looks.
 */
enum { FEW_VERTICES = 65, MOST_BENDS = 5000 };
/* Of a rod whose material learns all modes are looked at on so many cells. */
enum { LEARNED_CELLS = 32 };
enum { MODE_CELLS = 400, MOST_DENSE = 4000, MARGIN_POINTS = 4 };
/* A change of sign is found to this part of the time: curves of norms are no better than that. */
static const PetscReal crossing_found = 1e-11;

static const OptionRow rows[] = {
    ROW_REAL("-stability_start", "0", 0, 1e6, UNIT_TIME, 0, "first time of the table"),
    ROW_REAL("-stability_end", "", 0, 1e6, UNIT_TIME, 0,
             "last time of the table (t_cr if not set)"),
    ROW_INT("-stability_points", "50", 1, 1000000, 0, "times in the table"),
    ROW_INT("-stability_vertices", "1000", 9, 20000000, 0, "size of the matrices"),
    ROW_WORD("-stability_norm", "left", "friction,left", 0,
             "how the rows of W are scaled: to length 1 in the friction norm, or (left) in the L2 "
             "norm"),
    ROW_BOOL("-stability_only_modes", "false", 0, "the eigenvalues of A alone, for huge matrices"),
    ROW_BOOL("-stability_transient", "true", 0, "the largest transient growth, by its propagator"),
    ROW_REAL("-stability_transient_start", "", 0, 1e6, UNIT_TIME, 0,
             "t1 of its window (-stability_start if not set)"),
    ROW_REAL("-stability_transient_end", "", 0, 1e6, UNIT_TIME, 0,
             "t2 of its window (-stability_end if not set)"),
    ROW_INT("-stability_transient_cells", "200", 8, 2000, 0, "cells of its mesh"),
    ROW_TEXT("-stability_optimal_shape", OUTPUT_FILE,
             "HDF5 file for the initial shape that grows most in L2, for -shape_file (take a "
             "-shape_amplitude of 1e-5 or less: it bends right at the tip)")};
const OptionGroup stability_options = OPTION_GROUP("-task stability", rows);

/* The curves of the stability figure. */
typedef enum { CURVE_A, CURVE_L2, CURVE_W, CURVE_FRICTION, CURVES } Curve;

static const struct {
  const char *name, *heading, *text, *verdict;
} curves[CURVES] = {
    {"lambda_max_A", "lambda(A)", "largest real part of the eigenvalues of A(t) [k]",
     "every mode, frozen in time, decays"},
    {"lambda_max_A_plus_AT", "lambda(A+A^T)",
     "largest eigenvalue of A + A^T in the discrete L2 norm, twice the rate in it [k]",
     "stable in plain L2"},
    {"lambda_max_C", "lambda(C)",
     "largest eigenvalue of C(t) = W^T W A + transpose against the L2 norm, W the left "
     "eigenvectors "
     "of A(t_cr) [k]",
     "stable in the W norm"},
    {"rate_friction_norm", "friction rate",
     "largest growth rate of any deflection in the friction norm [k]",
     "stable in the friction norm"}};

typedef struct {
  PetscReal start, end;
  PetscInt points, vertices;
  PetscBool end_given, unit_rows, only_modes;
  PetscBool transient; /* and its window and size */
  PetscReal t1, t2;
  PetscInt transient_cells;
  PetscBool t1_given, t2_given;
  char shape[PETSC_MAX_PATH_LEN];
} Settings;

/* The solvers for deflections of one way. */
typedef struct {
  StraightWay way;
  Pencil follow, fixed; /* z moving with t for A, fixed at t_cr for the norms */
  Spectrum modes, friction;
  Norm l2, left;
  Senses few,
      all; /* in their place, of a rod whose material learns: modes of few cells, and of all */
} Solvers;

typedef struct _Stability Stability;
struct _Stability {
  Scene scene;
  MPI_Comm comm; /* of the solvers */
  HdfFile file, shape_file;
  Settings set;
  Mesh mesh;
  PetscInt ways; /* to look at by themselves, see StraightWays() */
  Solvers of[MOST_WAYS];
  PetscBool twisted; /* x2 and x3 are joined */
  PetscBool learns;  /* what the material learns is a part of each mode */
  PetscBool quiet;   /* takes no options of solvers */
  PetscBool has[CURVES];
  Critical critical;
  PetscReal *t, *value[CURVES], *frequency; /* [points] */
  PetscReal *modes[MOST_WAYS];              /* the curve of A of each way [points] */
  PetscReal until[CURVES];                  /* the verdict; start: not even there */
  PetscBool beyond[CURVES];                 /* still stable at the end of what was looked at */
  Bends bends;                              /* of the scene's tables, in time */
  PetscReal straight_on;                    /* ... between which these go on straight */
  Stability *few;                           /* on few vertices, where there are any; else NULL */
};

static PetscErrorCode TransientOptions(Settings *set) {
  PetscFunctionBegin;
  PetscCall(OptionBool("-stability_transient", &set->transient, NULL));
  PetscCall(OptionReal("-stability_transient_start", &set->t1, &set->t1_given));
  PetscCall(OptionReal("-stability_transient_end", &set->t2, &set->t2_given));
  PetscCall(OptionInt("-stability_transient_cells", &set->transient_cells, NULL));
  PetscCall(OptionText("-stability_optimal_shape", set->shape, NULL));
  UserCheck(set->transient || !set->shape[0], OptionsComm(),
            "-stability_optimal_shape needs -stability_transient");
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadSettings(Scene scene, Settings *set) {
  PetscInt choice;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(set, sizeof(*set)));
  PetscCall(OptionReal("-stability_start", &set->start, NULL));
  PetscCall(OptionReal("-stability_end", &set->end, &set->end_given));
  PetscCall(OptionInt("-stability_points", &set->points, NULL));
  PetscCall(OptionInt("-stability_vertices", &set->vertices, NULL));
  PetscCall(OptionWord("-stability_norm", &choice, NULL));
  PetscCall(OptionBool("-stability_only_modes", &set->only_modes, NULL));
  PetscCall(TransientOptions(set));
  set->unit_rows = (PetscBool)choice;
  UserCheck(!set->end_given || set->end > set->start, OptionsComm(),
            "-stability_end %g: give a time after -stability_start %g", (double)set->end,
            (double)set->start);
  UserCheck(PetscMax(set->end, set->t2) <= scene->growth->end_time, OptionsComm(),
            "-stability_end: the growth table ends at t = %g", (double)scene->growth->end_time);
  PetscFunctionReturn(0);
}

/* Reads the options of solvers that are made only once t_cr is known, so that a mistyped one is
   refused now. */
static PetscErrorCode ReadSolverOptions(void) {
  EPS eps;

  PetscFunctionBegin;
  PetscCall(EPSCreate(OptionsComm(), &eps));
  PetscCall(EPSSetOptionsPrefix(eps, "norm_"));
  PetscCall(EPSSetType(eps, EPSGD));
  PetscCall(EPSSetFromOptions(eps));
  PetscCall(EPSDestroy(&eps));
  PetscFunctionReturn(0);
}

/* The left eigenvectors at t_cr, dense, on every rank. */
static PetscErrorCode CreateLeft(Stability *self, Solvers *of) {
  PetscInt n = self->set.vertices;
  PetscReal *W;
  Pencil own;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n * n, &W));
  PetscCall(
      PencilCreate(PETSC_COMM_SELF, self->scene, &self->mesh, self->critical.t, of->way, &own));
  PetscCall(SpectrumLeftVectors(own, self->critical.t, self->set.unit_rows, W));
  PetscCall(NormCreate(of->fixed, W, self->critical.t, &of->left));
  PetscCall(PencilDestroy(&own));
  PetscCall(PetscFree(W));
  PetscFunctionReturn(0);
}

/* Which curves there are. Norms that take left eigenvectors or plain L2 are of one direction. */
static PetscErrorCode ChooseCurves(Stability *self) {
  const PetscBool all = (PetscBool)(!self->set.only_modes && !self->learns),
                  norms = (PetscBool)(all && !self->twisted);

  PetscFunctionBegin;
  self->has[CURVE_A] = PETSC_TRUE;
  self->has[CURVE_FRICTION] = all;
  self->has[CURVE_L2] = norms;
  self->has[CURVE_W] = (PetscBool)(norms && self->set.vertices <= MOST_DENSE);
  if (all && self->twisted)
    PetscCall(PetscPrintf(OptionsComm(),
                          "the L2 and W norms and the transient growth left out: they are of one "
                          "direction across, and twist joins both\n"));
  if (self->learns && !self->set.only_modes)
    PetscCall(PetscPrintf(OptionsComm(),
                          "norms and transient growth left out: they are of a rod whose material "
                          "learns nothing\n"));
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateSolvers(Stability *self, Solvers *of) {
  Scene scene = self->scene;

  PetscFunctionBegin;
  if (self->learns) PetscFunctionReturn(0);
  PetscCall(SpectrumCreate(of->follow, PETSC_TRUE, &of->friction));
  if (!self->has[CURVE_L2]) PetscFunctionReturn(0);
  PetscCall(PencilCreate(self->comm, scene, &self->mesh, self->critical.t, of->way, &of->fixed));
  PetscCall(NormCreate(of->fixed, NULL, self->critical.t, &of->l2));
  if (self->has[CURVE_W])
    PetscCall(CreateLeft(self, of));
  else if (self->set.vertices > MOST_DENSE)
    PetscCall(PetscPrintf(OptionsComm(),
                          "C(t) left out: above -stability_vertices %d the dense left eigenvectors "
                          "take too much\n",
                          MOST_DENSE));
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateMesh(Stability *self) {
  Scene scene = self->scene;
  StraightWay way[MOST_WAYS];

  PetscFunctionBegin;
  PetscCall(
      MeshCreate(self->set.vertices - 1, PETSC_FALSE, scene->growth, scene->end_time, &self->mesh));
  self->twisted = StraightIsTwisted(scene);
  self->learns = TropismLearns(&scene->tropism);
  self->ways = StraightWays(scene, way);
  for (PetscInt k = 0; k < self->ways; k++) {
    Solvers *of = &self->of[k];
    of->way = way[k];
    if (self->learns) {
      PetscCall(SensesCreate(scene, LEARNED_CELLS, of->way, &of->few));
      PetscCall(SensesCreate(scene, self->set.vertices - 1, of->way, &of->all));
      continue;
    }
    PetscCall(PencilCreate(self->comm, scene, &self->mesh, map_follows, of->way, &of->follow));
    PetscCall(SpectrumCreate(of->follow, (PetscBool)(k > 0 || self->quiet), &of->modes));
  }
  PetscFunctionReturn(0);
}

/* The same curves on few vertices, if the scene has tables that bend. */
static PetscErrorCode CreateFew(Stability *self) {
  Stability *few;

  PetscFunctionBegin;
  self->straight_on = 1e-3;
  PetscCall(SceneFewBends(self->scene, MOST_BENDS, &self->straight_on, &self->bends));
  if (!self->bends.n) PetscFunctionReturn(0);
  PetscCall(PetscNew(&few));
  self->few = few;
  few->scene = self->scene;
  few->comm = PETSC_COMM_SELF;
  few->quiet = PETSC_TRUE;
  few->set = self->set;
  few->set.vertices = FEW_VERTICES;
  few->critical.t = self->critical.t;
  PetscCall(PetscArraycpy(few->has, self->has, CURVES));
  PetscCall(CreateMesh(few));
  for (PetscInt k = 0; k < few->ways; k++) PetscCall(CreateSolvers(few, &few->of[k]));
  PetscFunctionReturn(0);
}

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

static PetscErrorCode Tabulate(Stability *self) {
  const Settings *set = &self->set;

  PetscFunctionBegin;
  PetscCall(PetscPrintf(OptionsComm(), "%12s %12s", "t", "L"));
  for (int c = 0; c < CURVES; c++)
    if (self->has[c]) PetscCall(PetscPrintf(OptionsComm(), " %14s", curves[c].heading));
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
static PetscErrorCode Verdict(Stability *self, Curve curve) {
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

/* Is A self-adjoint in the friction norm, and that norm the same at all times but for a factor? For
   uniform growth it is, with friction that is the same in all directions and places, and a tip that
   is free or pushed along the clamp; weight along the rod changes nothing of that. */
static PetscBool IsSelfAdjoint(Scene scene) {
  return (PetscBool)(scene->growth->even && !scene->growth->slides && !scene->load.varied &&
                     !StraightIsTwisted(scene) &&
                     (scene->tip.force == 0 || scene->tip.law == TIP_DEAD));
}

static PetscErrorCode PrintVerdict(const Stability *self) {
  const PetscBool slides = self->scene->growth->slides;
  const PetscReal start = self->set.start;
  PetscReal best = start;

  PetscFunctionBegin;
  for (int c = 0; c < CURVES; c++) {
    if (!self->has[c]) continue;
    if (c != CURVE_A && (c != CURVE_W || !slides)) best = PetscMax(best, self->until[c]);
    if (self->until[c] <= start)
      PetscCall(PetscPrintf(OptionsComm(), "%-32s not even at t = %g\n", curves[c].verdict,
                            (double)start));
    else
      PetscCall(PetscPrintf(OptionsComm(), "%-32s on [%g, %.10g)%s\n", curves[c].verdict,
                            (double)start, (double)self->until[c],
                            self->beyond[c] ? " at least" : ""));
  }
  if (self->bends.n)
    PetscCall(PetscPrintf(OptionsComm(),
                          "(Looked at between the times above, too, wherever tables bend by more "
                          "than %.1g %% of what they give.)\n",
                          (double)(100 * self->straight_on)));
  if (!self->has[CURVE_FRICTION]) PetscFunctionReturn(0);
  if (IsSelfAdjoint(self->scene))
    PetscCall(PetscPrintf(OptionsComm(),
                          "Uniform growth: A is self-adjoint in the friction norm, so the rod is "
                          "exponentially stable exactly up to t_cr.\n"));
  else
    PetscCall(
        PetscPrintf(OptionsComm(),
                    "Best norm: decay for certain up to t = %.8g; the frozen modes grow from t_cr "
                    "= %.8g on; gap %.2g.\n",
                    (double)best, (double)self->critical.t, (double)(self->critical.t - best)));
  if (slides && self->has[CURVE_W])
    PetscCall(
        PetscPrintf(OptionsComm(),
                    "(The W norm, as the modes, is judged on a rod of frozen length: no proof for "
                    "one that is fed.)\n"));
  if (best > self->critical.t * (1 + 1e-6))
    PetscCall(PetscPrintf(
        OptionsComm(), "(The friction norm follows D(t) and may see decay for longer than a mode "
                       "frozen in time does.)\n"));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteScalar(HdfFile file, const char *name, PetscReal value,
                                  const char *units, const char *text) {
  PetscFunctionBegin;
  PetscCall(HdfWrite(file, name, 0, NULL, &value, units, text));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteTable(HdfFile file, Stability *self) {
  const PetscInt k = self->set.points;
  char name[80];
  PetscReal *L;

  PetscFunctionBegin;
  if (!file) PetscFunctionReturn(0);
  PetscCall(HdfGroup(file, "/stability"));
  PetscCall(PetscMalloc1(k, &L));
  for (PetscInt i = 0; i < k; i++)
    PetscCall(GrowthLength(self->scene->growth, self->t[i], &L[i], NULL));
  PetscCall(HdfWrite(file, "/stability/t", 1, &k, self->t, "l/V", "times [k]"));
  PetscCall(HdfWrite(file, "/stability/length", 1, &k, L, "l", "lengths [k]"));
  PetscCall(HdfWrite(file, "/stability/frequency_A", 1, &k, self->frequency, "rad V/l",
                     "imaginary part that belongs to lambda_max_A [k]"));
  PetscCall(PetscFree(L));
  for (int c = 0; c < CURVES; c++) {
    if (!self->has[c]) continue;
    PetscCall(PetscSNPrintf(name, sizeof(name), "/stability/%s", curves[c].name));
    PetscCall(HdfWrite(file, name, 1, &k, self->value[c], "V/l", curves[c].text));
    PetscCall(PetscSNPrintf(name, sizeof(name), "/stability/%s_until", curves[c].name));
    PetscCall(
        WriteScalar(file, name, self->until[c], "l/V", "negative from the first time up to here"));
  }
  for (PetscInt k = 0; k < self->ways && self->ways > 1; k++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "/stability/lambda_max_A_x%d",
                            self->of[k].way == WAY_X2 ? 2 : 3));
    PetscCall(HdfWrite(file, name, 1, &self->set.points, self->modes[k], "V/l",
                       "lambda_max_A of deflections in this direction [k]"));
  }
  if (!self->critical.n) PetscFunctionReturn(0);
  PetscCall(WriteScalar(file, "/stability/t_cr", self->critical.t, "l/V", "critical time"));
  PetscCall(WriteScalar(file, "/stability/t_cr_error", self->critical.error, "l/V",
                        "bound on its error"));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteOptimal(HdfFile file, const Optimal *best, const char *norm) {
  const PetscInt n = best->n;
  const struct {
    const char *name, *units, *text;
    const PetscReal *data;
  } sets[] = {{"s", "1", "material label [n]", best->s},
              {"initial_y", "l", "deflection that grows most, norm 1 at t1 [n]", best->y1},
              {"initial_theta", "rad", "its angle [n]", best->theta1},
              {"final_y", "l", "what it has become at t2 [n]", best->y2},
              {"final_theta", "rad", "its angle [n]", best->theta2}};
  char name[80];

  PetscFunctionBegin;
  if (!file) PetscFunctionReturn(0);
  PetscCall(PetscSNPrintf(name, sizeof(name), "/transient/%s", norm));
  PetscCall(HdfGroup(file, name));
  PetscCall(PetscSNPrintf(name, sizeof(name), "/transient/%s/amplification", norm));
  PetscCall(WriteScalar(file, name, best->amplification, "1", "largest |y(t2)| / |y(t1)|"));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(sets); i++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "/transient/%s/%s", norm, sets[i].name));
    PetscCall(HdfWrite(file, name, 1, &n, sets[i].data, sets[i].units, sets[i].text));
  }
  PetscFunctionReturn(0);
}

/* The optimal shape as -shape_type file reads it, scaled to -shape_amplitude. */
static PetscErrorCode WriteShapeFile(HdfFile file, const Optimal *best, PetscReal amplitude) {
  const PetscInt n = best->n;
  PetscReal *theta, most = 0;

  PetscFunctionBegin;
  if (!file) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(best->n, &theta));
  for (PetscInt i = 0; i < best->n; i++) most = PetscMax(most, PetscAbsReal(best->theta1[i]));
  for (PetscInt i = 0; i < best->n; i++) theta[i] = i ? best->theta1[i] * amplitude / most : 0;
  PetscCall(HdfWrite(file, "/s", 1, &n, best->s, "1", "material label [n]"));
  PetscCall(HdfWrite(file, "/theta", 1, &n, theta, "rad", "angle against the clamp [n]"));
  PetscCall(PetscFree(theta));
  PetscFunctionReturn(0);
}

/* The larger of two amplifications is kept. */
static PetscErrorCode TakeLarger(Propagator *propagator, TransientNorm norm, Optimal *best) {
  Optimal other;

  PetscFunctionBegin;
  PetscCall(TransientOptimal(propagator, norm, &other));
  if (other.amplification > best->amplification) {
    Optimal less = *best;
    *best = other;
    other = less;
  }
  PetscCall(OptimalDestroy(&other));
  PetscFunctionReturn(0);
}

/* The transient growth over a window in both norms, in the direction in which it is larger; every
   rank computes it for itself. */
static PetscErrorCode Transient(Stability *self, HdfFile file, HdfFile shape) {
  const char *const names[] = {"L2", "friction"};
  const Settings *set = &self->set;
  Propagator propagator[MOST_WAYS];
  Scene scene = self->scene;
  Mesh mesh;

  PetscFunctionBegin;
  PetscCall(MeshCreate(set->transient_cells, PETSC_FALSE, scene->growth, set->t2, &mesh));
  for (PetscInt w = 0; w < self->ways; w++)
    PetscCall(
        PropagatorCreate(scene, &mesh, self->of[w].way, set->t1, set->t2, 1e-9, &propagator[w]));
  if (file) {
    PetscCall(HdfGroup(file, "/transient"));
    PetscCall(WriteScalar(file, "/transient/t1", set->t1, "l/V", "start of the window"));
    PetscCall(WriteScalar(file, "/transient/t2", set->t2, "l/V", "end of the window"));
  }
  for (int k = 0; k < 2; k++) {
    Optimal best;
    PetscCall(TransientOptimal(&propagator[0], (TransientNorm)k, &best));
    if (self->ways > 1) PetscCall(TakeLarger(&propagator[1], (TransientNorm)k, &best));
    PetscCall(PetscPrintf(OptionsComm(),
                          "largest amplification from t = %g to %g, %s norm: %.10g\n",
                          (double)set->t1, (double)set->t2, names[k], (double)best.amplification));
    PetscCall(WriteOptimal(file, &best, names[k]));
    if (k == TRANSIENT_L2) PetscCall(WriteShapeFile(shape, &best, scene->shape.amplitude));
    PetscCall(OptimalDestroy(&best));
  }
  for (PetscInt w = 0; w < self->ways; w++) PetscCall(PropagatorDestroy(&propagator[w]));
  PetscCall(MeshDestroy(&mesh));
  PetscFunctionReturn(0);
}

/* Ranges that depend on t_cr. */
static PetscErrorCode CompleteSettings(Settings *set, PetscReal t_cr) {
  PetscFunctionBegin;
  if (!set->end_given) set->end = t_cr;
  UserCheck(
      set->end > set->start, OptionsComm(),
      "-stability_end: the rod is unstable from t = %g on, before -stability_start %g; give an "
      "end after that",
      (double)t_cr, (double)set->start);
  if (!set->t1_given) set->t1 = set->start;
  if (!set->t2_given) set->t2 = set->end;
  UserCheck(!set->transient || set->t2 > set->t1, OptionsComm(),
            "-stability_transient_end %g: give a time after -stability_transient_start %g",
            (double)set->t2, (double)set->t1);
  PetscFunctionReturn(0);
}

static PetscErrorCode Destroy(Stability *self) {
  PetscFunctionBegin;
  PetscCall(HdfDrop(&self->file));
  PetscCall(HdfDrop(&self->shape_file));
  for (PetscInt k = 0; k < MOST_WAYS; k++) {
    Solvers *of = &self->of[k];
    PetscCall(SpectrumDestroy(&of->modes));
    PetscCall(SpectrumDestroy(&of->friction));
    PetscCall(SensesDestroy(&of->few));
    PetscCall(SensesDestroy(&of->all));
    if (of->l2.pencil) PetscCall(NormDestroy(&of->l2));
    if (of->left.pencil) PetscCall(NormDestroy(&of->left));
    PetscCall(PencilDestroy(&of->follow));
    PetscCall(PencilDestroy(&of->fixed));
    PetscCall(PetscFree(self->modes[k]));
  }
  PetscCall(CriticalDestroy(&self->critical));
  PetscCall(MeshDestroy(&self->mesh));
  PetscCall(PetscFree2(self->t, self->frequency));
  for (int c = 0; c < CURVES; c++) PetscCall(PetscFree(self->value[c]));
  PetscCall(BendsDestroy(&self->bends));
  PetscFunctionReturn(0);
}

/* Also of the curves on few vertices. */
static PetscErrorCode DestroyAll(Stability *self) {
  PetscFunctionBegin;
  if (self->few) PetscCall(Destroy(self->few));
  PetscCall(PetscFree(self->few));
  PetscCall(Destroy(self));
  PetscFunctionReturn(0);
}

/* Reads everything, opens the files. */
static PetscErrorCode Open(Stability *self, const char *output) {
  Scene scene = self->scene;

  PetscFunctionBegin;
  UserCheck(scene->tip.type == TIP_FREE, scene->comm,
            "-tip_type: -task stability is about a free tip; -task critical knows the others");
  PetscCall(ReadSettings(scene, &self->set));
  UserCheck(!TropismLearns(&scene->tropism) || !self->set.shape[0], scene->comm,
            "-stability_optimal_shape: what grows most is known of a rod whose material learns "
            "nothing; take it out");
  self->comm = self->set.vertices < SHARED_VERTICES ? PETSC_COMM_SELF : scene->comm;
  PetscCall(CreateMesh(self));
  PetscCall(ReadSolverOptions());
  PetscCall(OptionsRefuseUnread());
  if (output[0]) PetscCall(OutputNewFile("-output", output, scene->comm, &self->file));
  if (self->set.shape[0])
    PetscCall(
        OutputNewFile("-stability_optimal_shape", self->set.shape, scene->comm, &self->shape_file));
  PetscFunctionReturn(0);
}

/* The lengths that are missed by the mesh of the critical time, or by that of the table. */
static PetscErrorCode TellScales(const Stability *self) {
  const Mesh labels = {.cells = self->critical.n - 1, .s = self->critical.s};

  PetscFunctionBegin;
  if (self->critical.n)
    PetscCall(ScalesTell(self->scene, &labels, "-rod_cells", labels.cells, self->critical.t));
  PetscCall(ScalesTell(self->scene, &self->mesh, "-stability_vertices", self->set.vertices,
                       self->set.end));
  PetscFunctionReturn(0);
}

/* When the straight rod turns unstable. Not looked for where the end of the table is given and the
   material learns: such a rod may swing whatever its length. */
static PetscErrorCode FindCritical(Stability *self) {
  PetscFunctionBegin;
  if (self->learns && self->set.end_given) PetscFunctionReturn(0);
  PetscCall(CriticalFind(self->scene, PETSC_TRUE, &self->critical));
  PetscCall(PetscPrintf(OptionsComm(), "critical time t = %.12g, error below %.1e\n",
                        (double)self->critical.t, (double)self->critical.error));
  PetscCall(CriticalPrintLaboratory(OptionsComm(), &self->critical));
  PetscFunctionReturn(0);
}

static PetscErrorCode Compute(Stability *self) {
  PetscFunctionBegin;
  PetscCall(FindCritical(self));
  PetscCall(CompleteSettings(&self->set, self->critical.t));
  PetscCall(TellScales(self));
  PetscCall(PetscMalloc2(self->set.points, &self->t, self->set.points, &self->frequency));
  for (int c = 0; c < CURVES; c++) PetscCall(PetscCalloc1(self->set.points, &self->value[c]));
  for (PetscInt k = 0; k < self->ways; k++)
    PetscCall(PetscCalloc1(self->set.points, &self->modes[k]));
  PetscCall(ChooseCurves(self));
  for (PetscInt k = 0; k < self->ways; k++) PetscCall(CreateSolvers(self, &self->of[k]));
  PetscCall(CreateFew(self));
  PetscCall(Tabulate(self));
  for (int c = 0; c < CURVES; c++)
    if (self->has[c]) PetscCall(Verdict(self, (Curve)c));
  PetscCall(PrintVerdict(self));
  PetscCall(WriteTable(self->file, self));
  if (self->set.transient && !self->twisted && !self->learns)
    PetscCall(Transient(self, self->file, self->shape_file));
  PetscFunctionReturn(0);
}

static PetscErrorCode Close(Stability *self, const char *output) {
  MPI_Comm comm = self->scene->comm;

  PetscFunctionBegin;
  if (self->file) PetscCall(OutputAttributes(self->file, comm, PETSC_TRUE));
  if (output[0]) PetscCall(OutputEndFile("-output", output, comm, &self->file));
  if (self->shape_file) PetscCall(OutputAttributes(self->shape_file, comm, PETSC_TRUE));
  if (self->set.shape[0])
    PetscCall(OutputEndFile("-stability_optimal_shape", self->set.shape, comm, &self->shape_file));
  PetscFunctionReturn(0);
}

/*
  StabilityRun - -task stability: the curves over a range of t, the verdicts, the transient growth;
  printed and stored.

  output   the result file, "": none
*/
PetscErrorCode StabilityRun(Scene scene, const char *output) {
  Stability self = {.scene = scene};
  PetscErrorCode error;

  PetscFunctionBegin;
  error = Open(&self, output);
  if (!error) error = Compute(&self);
  if (!error) error = Close(&self, output);
  PetscCall(DestroyAll(&self));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/*
  StabilitySlowestMode - the eigenvector of A(0) that decays slowest, as an initial shape.
  Collective.

  n          the number of knots
  s, theta   labels from 0 to 1 and angles against the clamp, theta[0] = 0, scaled so that the
             largest |theta| is the scene's amplitude; allocated here, the caller frees both
*/
PetscErrorCode StabilitySlowestMode(Scene scene, PetscInt *n, PetscReal **s, PetscReal **theta) {
  PetscReal *c, *w, most = 0;
  Spectrum spectrum;
  Eigenvalue value;
  Pencil pencil;
  Mesh mesh;

  PetscFunctionBegin;
  PetscCall(MeshCreate(MODE_CELLS, PETSC_FALSE, scene->growth, scene->end_time, &mesh));
  PetscCall(PencilCreate(PETSC_COMM_SELF, scene, &mesh, map_follows, WAY_X2, &pencil));
  PetscCall(SpectrumCreate(pencil, PETSC_TRUE, &spectrum));
  *n = pencil->n;
  PetscCall(PetscMalloc2(*n, &c, *n, &w));
  PetscCall(PetscMalloc1(*n, s));
  PetscCall(PetscMalloc1(*n, theta));
  PetscCall(SpectrumLargest(&spectrum, RATE_A, 0, &value, c, w));
  PetscCall(PencilShape(pencil, c, w, 0, NULL, *theta));
  PetscCall(PetscArraycpy(*s, pencil->node, *n));
  (*theta)[0] = 0;
  for (PetscInt i = 0; i < *n; i++)
    if (PetscAbsReal((*theta)[i]) > PetscAbsReal(most)) most = (*theta)[i];
  for (PetscInt i = 0; i < *n; i++) (*theta)[i] *= scene->shape.amplitude / most;
  PetscCallMPI(MPI_Bcast(*theta, *n, MPIU_REAL, 0, OptionsComm()));
  PetscCall(SpectrumDestroy(&spectrum));
  PetscCall(PencilDestroy(&pencil));
  PetscCall(MeshDestroy(&mesh));
  PetscCall(PetscFree2(c, w));
  PetscFunctionReturn(0);
}
