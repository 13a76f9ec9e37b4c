#include "scene/growth.h"
#include "base/hdf.h"
#include "base/options.h"
#include "base/spline.h"

/* uniform: g = L0 + t; feed: the same map of s to arc length, with sliding material */
static PetscErrorCode StretchUniform(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                     PetscReal *g_t, PetscReal *g_s) {
  *g = self->initial_length + t;
  *g_t = 1;
  *g_s = 0;
  return 0;
}

static PetscErrorCode ArcUniform(Growth self, PetscReal s, PetscReal t, PetscReal *p,
                                 PetscReal *p_t) {
  *p = s * (self->initial_length + t);
  *p_t = s;
  return 0;
}

static PetscErrorCode CreateUniform(Growth self) {
  PetscFunctionBegin;
  self->uniform = PETSC_TRUE;
  self->stretch = StretchUniform;
  self->arc = ArcUniform;
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateFeed(Growth self) {
  PetscFunctionBegin;
  PetscCall(CreateUniform(self));
  self->slides = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* gaussian: g = L0 + b exp(-s^2/a^2) t, b = 2 / (a sqrt(pi) erf(1/a)), so that L = L0 + t */
typedef struct {
  PetscReal a, b;
} Gaussian;

static PetscErrorCode StretchGaussian(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                      PetscReal *g_t, PetscReal *g_s) {
  Gaussian *law = (Gaussian *)self->data;
  *g_t = law->b * PetscExpReal(-PetscSqr(s / law->a));
  *g = self->initial_length + *g_t * t;
  *g_s = -2 * s / PetscSqr(law->a) * *g_t * t;
  return 0;
}

static PetscErrorCode ArcGaussian(Growth self, PetscReal s, PetscReal t, PetscReal *p,
                                  PetscReal *p_t) {
  Gaussian *law = (Gaussian *)self->data;
  *p_t = erf(s / law->a) / erf(1 / law->a);
  *p = self->initial_length * s + *p_t * t;
  return 0;
}

static PetscErrorCode DestroyData(Growth self) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->data));
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateGaussian(Growth self) {
  Gaussian *law;

  PetscFunctionBegin;
  PetscCall(PetscNew(&law));
  law->a = 0.5;
  PetscCall(OptionReal("-growth_width", "a, width in s of the growth zone at the clamp (gaussian)",
                       1e-6, 1e6, &law->a, NULL));
  law->b = 2 / (law->a * PetscSqrtReal(PETSC_PI) * erf(1 / law->a));
  self->data = law;
  self->stretch = StretchGaussian;
  self->arc = ArcGaussian;
  self->destroy = DestroyData;
  PetscFunctionReturn(0);
}

/* table: a bicubic not-a-knot spline through /g [nt, ns] at /t and /s. With the second derivatives
   in s, in t and in both at the knots, its value is a product of the two sets of spline weights. */
typedef struct {
  PetscInt ns, nt;
  PetscReal *s, *t, *g, *g_ss, *g_tt, *g_sstt;
  PetscReal *p, *p_tt; /* arc length at the knots, and its second derivative in t */
} Table;

static PetscReal TableProduct(const Table *tab, PetscInt i, PetscInt j, const PetscReal ws[4],
                              const PetscReal wt[4]) {
  PetscReal sum = 0;
  for (PetscInt a = 0; a < 2; a++)
    for (PetscInt b = 0; b < 2; b++) {
      PetscInt k = (j + b) * tab->ns + i + a;
      sum += ws[a] * (wt[b] * tab->g[k] + wt[2 + b] * tab->g_tt[k]) +
             ws[2 + a] * (wt[b] * tab->g_ss[k] + wt[2 + b] * tab->g_sstt[k]);
    }
  return sum;
}

static PetscErrorCode StretchTable(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                   PetscReal *g_t, PetscReal *g_s) {
  Table *tab = (Table *)self->data;
  PetscReal ws[4], ws1[4], wt[4], wt1[4];
  char text[3][32];
  PetscInt i, j;

  PetscFunctionBegin;
  SplineWeights(tab->ns, tab->s, s, &i, ws, ws1, NULL);
  SplineWeights(tab->nt, tab->t, t, &j, wt, wt1, NULL);
  *g = TableProduct(tab, i, j, ws, wt);
  *g_t = TableProduct(tab, i, j, ws, wt1);
  *g_s = TableProduct(tab, i, j, ws1, wt);
  UserCheck(*g > 0, PETSC_COMM_SELF,
            "-growth_table: the stretch is %s at s = %s, t = %s; it must stay above 0 between the "
            "entries too",
            OptionNumber(*g, text[0]), OptionNumber(s, text[1]), OptionNumber(t, text[2]));
  PetscFunctionReturn(0);
}

static PetscErrorCode ArcTable(Growth self, PetscReal s, PetscReal t, PetscReal *p,
                               PetscReal *p_t) {
  Table *tab = (Table *)self->data;
  PetscReal ws[4], wt[4], wt1[4];
  PetscInt i, j;

  PetscFunctionBegin;
  SplineWeights(tab->ns, tab->s, s, &i, NULL, NULL, ws);
  SplineWeights(tab->nt, tab->t, t, &j, wt, wt1, NULL);
  *p = TableProduct(tab, i, j, ws, wt);
  *p_t = TableProduct(tab, i, j, ws, wt1);
  for (PetscInt b = 0; b < 2; b++) {
    PetscInt k = (j + b) * tab->ns + i;
    *p += wt[b] * tab->p[k] + wt[2 + b] * tab->p_tt[k];
    *p_t += wt1[b] * tab->p[k] + wt1[2 + b] * tab->p_tt[k];
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode DestroyTable(Growth self) {
  Table *tab = (Table *)self->data;

  PetscFunctionBegin;
  PetscCall(PetscFree3(tab->s, tab->t, tab->g));
  PetscCall(PetscFree5(tab->g_ss, tab->g_tt, tab->g_sstt, tab->p, tab->p_tt));
  PetscCall(PetscFree(self->data));
  PetscFunctionReturn(0);
}

static PetscErrorCode TableCheck(const char *file, const Table *tab) {
  PetscFunctionBegin;
  UserCheck(tab->ns >= 4 && tab->nt >= 4, PETSC_COMM_WORLD,
            "-growth_table %s: needs at least 4 entries in /s and in /t", file);
  UserCheck(PetscAbsReal(tab->s[0]) < 1e-12 && PetscAbsReal(tab->s[tab->ns - 1] - 1) < 1e-12,
            PETSC_COMM_WORLD, "-growth_table %s: /s must run from 0 to 1", file);
  UserCheck(tab->t[0] <= 1e-12, PETSC_COMM_WORLD, "-growth_table %s: /t must start at 0", file);
  for (PetscInt i = 1; i < tab->ns; i++)
    UserCheck(tab->s[i] > tab->s[i - 1], PETSC_COMM_WORLD, "-growth_table %s: /s must increase",
              file);
  for (PetscInt i = 1; i < tab->nt; i++)
    UserCheck(tab->t[i] > tab->t[i - 1], PETSC_COMM_WORLD, "-growth_table %s: /t must increase",
              file);
  for (PetscInt i = 0; i < tab->ns * tab->nt; i++)
    UserCheck(tab->g[i] > 0, PETSC_COMM_WORLD, "-growth_table %s: /g must be positive", file);
  PetscFunctionReturn(0);
}

static PetscErrorCode TableRead(const char *file, Table *tab) {
  hsize_t ns, nt, dims[2];
  PetscReal *s, *t, *g;

  PetscFunctionBegin;
  PetscCall(HdfRead("-growth_table", file, "/s", 1, &ns, &s));
  PetscCall(HdfRead("-growth_table", file, "/t", 1, &nt, &t));
  PetscCall(HdfRead("-growth_table", file, "/g", 2, dims, &g));
  UserCheck(dims[0] == nt && dims[1] == ns, PETSC_COMM_WORLD,
            "-growth_table %s: /g must be [%d, %d] as /t and /s are long, it is [%d, %d]", file,
            (int)nt, (int)ns, (int)dims[0], (int)dims[1]);
  tab->ns = (PetscInt)ns;
  tab->nt = (PetscInt)nt;
  PetscCall(PetscMalloc3(ns, &tab->s, nt, &tab->t, ns * nt, &tab->g));
  PetscCall(PetscArraycpy(tab->s, s, ns));
  PetscCall(PetscArraycpy(tab->t, t, nt));
  PetscCall(PetscArraycpy(tab->g, g, ns * nt));
  PetscCall(PetscFree(s));
  PetscCall(PetscFree(t));
  PetscCall(PetscFree(g));
  PetscCall(TableCheck(file, tab));
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateTable(Growth self) {
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool set;
  PetscInt n;
  Table *tab;

  PetscFunctionBegin;
  PetscCall(OptionString("-growth_table", "HDF5 file with /s [ns], /t [nt], /g [nt, ns] (table)",
                         file, sizeof(file), &set));
  UserCheck(set, PETSC_COMM_WORLD, "-growth_type table needs -growth_table FILE");
  PetscCall(PetscNew(&tab));
  PetscCall(TableRead(file, tab));
  n = tab->ns * tab->nt;
  PetscCall(PetscCalloc5(n, &tab->g_ss, n, &tab->g_tt, n, &tab->g_sstt, n, &tab->p, n, &tab->p_tt));
  PetscCall(SplineSecondDerivatives(tab->ns, tab->s, tab->nt, tab->ns, 1, tab->g, tab->g_ss));
  PetscCall(SplineSecondDerivatives(tab->nt, tab->t, tab->ns, 1, tab->ns, tab->g, tab->g_tt));
  PetscCall(SplineSecondDerivatives(tab->nt, tab->t, tab->ns, 1, tab->ns, tab->g_ss, tab->g_sstt));
  for (PetscInt k = 0; k < n; k++) {
    if (k % tab->ns == 0) continue; /* p = 0 at the clamp */
    PetscReal h = tab->s[k % tab->ns] - tab->s[k % tab->ns - 1];
    tab->p[k] = tab->p[k - 1] + h / 2 * (tab->g[k - 1] + tab->g[k]) -
                h * h * h / 24 * (tab->g_ss[k - 1] + tab->g_ss[k]);
  }
  PetscCall(SplineSecondDerivatives(tab->nt, tab->t, tab->ns, 1, tab->ns, tab->p, tab->p_tt));
  self->data = tab;
  self->initial_length = tab->p[tab->ns - 1];
  self->end_time = tab->t[tab->nt - 1];
  self->stretch = StretchTable;
  self->arc = ArcTable;
  self->destroy = DestroyTable;
  PetscFunctionReturn(0);
}

/* To add a law: a creator above and a line here. */
static const struct {
  const char *name;
  PetscErrorCode (*create)(Growth);
} laws[] = {{"uniform", CreateUniform},
            {"gaussian", CreateGaussian},
            {"feed", CreateFeed},
            {"table", CreateTable}};

/*
  GrowthCreate - the growth law asked for by -growth_type and its options. Collective.
  The caller destroys it with GrowthDestroy().
*/
PetscErrorCode GrowthCreate(Growth *growth) {
  const char *names[PETSC_STATIC_ARRAY_LENGTH(laws)];
  PetscInt choice = 0;
  Growth self;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(laws); i++) names[i] = laws[i].name;
  PetscCall(PetscNew(&self));
  self->initial_length = 0.5;
  self->end_time = PETSC_MAX_REAL;
  PetscCall(OptionsHeading("Growth"));
  PetscCall(OptionList("-growth_type", "the law g(s,t)", PETSC_STATIC_ARRAY_LENGTH(laws), names,
                       &choice, NULL));
  if (laws[choice].create != CreateTable)
    PetscCall(OptionReal("-growth_initial_length", "L0, length at t = 0, in (YI/N)^(1/3)", 1e-6,
                         1e6, &self->initial_length, NULL));
  PetscCall(PetscStrncpy(self->type, names[choice], sizeof(self->type)));
  PetscCall(laws[choice].create(self));
  *growth = self;
  PetscFunctionReturn(0);
}

PetscErrorCode GrowthDestroy(Growth *growth) {
  PetscFunctionBegin;
  if (!*growth) PetscFunctionReturn(0);
  if ((*growth)->destroy) PetscCall((*growth)->destroy(*growth));
  PetscCall(PetscFree(*growth));
  PetscFunctionReturn(0);
}

/* a law that stands still */
typedef struct {
  Growth law; /* borrowed */
  PetscReal t;
} Stopped;

static PetscErrorCode StretchStopped(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                     PetscReal *g_t, PetscReal *g_s) {
  Stopped *at = (Stopped *)self->data;
  PetscFunctionBegin;
  PetscCall(at->law->stretch(at->law, s, at->t, g, g_t, g_s));
  *g_t = 0;
  PetscFunctionReturn(0);
}

static PetscErrorCode ArcStopped(Growth self, PetscReal s, PetscReal t, PetscReal *p,
                                 PetscReal *p_t) {
  Stopped *at = (Stopped *)self->data;
  PetscFunctionBegin;
  PetscCall(at->law->arc(at->law, s, at->t, p, p_t));
  *p_t = 0;
  PetscFunctionReturn(0);
}

/* GrowthStop - a law that stands still at time t of another, which must outlive it; no material
   slides. The caller destroys it with GrowthDestroy(). Not collective. */
PetscErrorCode GrowthStop(Growth law, PetscReal t, Growth *stopped) {
  Stopped *at;

  PetscFunctionBegin;
  PetscCall(PetscNew(stopped));
  PetscCall(PetscNew(&at));
  **stopped = *law;
  at->law = law;
  at->t = t;
  (*stopped)->stopped = PETSC_TRUE;
  (*stopped)->data = at;
  (*stopped)->stretch = StretchStopped;
  (*stopped)->arc = ArcStopped;
  (*stopped)->destroy = DestroyData;
  PetscFunctionReturn(0);
}

/* GrowthStretch - g, its rate g_t and its slope g_s = dg/ds (both may be NULL) at n labels s, at
   time t. Arrays of n, the caller's. */
PetscErrorCode GrowthStretch(Growth growth, PetscInt n, const PetscReal s[], PetscReal t,
                             PetscReal g[], PetscReal g_t[], PetscReal g_s[]) {
  PetscReal rate, slope;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++)
    PetscCall(
        growth->stretch(growth, s[i], t, &g[i], g_t ? &g_t[i] : &rate, g_s ? &g_s[i] : &slope));
  PetscFunctionReturn(0);
}

/* GrowthArc - the arc length p = int_0^s g and its rate p_t (may be NULL) at n labels, at time t.
 */
PetscErrorCode GrowthArc(Growth growth, PetscInt n, const PetscReal s[], PetscReal t, PetscReal p[],
                         PetscReal p_t[]) {
  PetscReal rate;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++)
    PetscCall(growth->arc(growth, s[i], t, &p[i], p_t ? &p_t[i] : &rate));
  PetscFunctionReturn(0);
}

/* GrowthLength - L(t) and dL/dt (may be NULL). */
PetscErrorCode GrowthLength(Growth growth, PetscReal t, PetscReal *length, PetscReal *length_t) {
  const PetscReal tip = 1;

  PetscFunctionBegin;
  PetscCall(GrowthArc(growth, 1, &tip, t, length, length_t));
  PetscFunctionReturn(0);
}
