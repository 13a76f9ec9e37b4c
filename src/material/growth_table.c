#include "base/hdf.h"
#include "base/spline.h"
#include "base/turns.h"
#include "material/growth.h"

/* table: a bicubic not-a-knot spline through /g [nt, ns] at /t and /s. With the second derivatives
   in s, in t and in both at the knots, its value is a product of the two sets of spline weights. */
typedef struct {
  PetscInt ns, nt;
  PetscReal *s, *t, *g, *g_ss, *g_tt, *g_sstt;
  PetscReal *p, *p_tt; /* arc length at the knots, and its second derivative in t */
  PetscBool *turns;    /* at which times, of the length (base/turns.h) */
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
  char text[3][64];
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
            OptionNumber(*g, text[0]), OptionNumber(s, text[1]), OptionBoth(t, UNIT_TIME, text[2]));
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

static PetscReal NextTurn(Growth self, PetscReal t) {
  const Table *tab = (const Table *)self->data;
  return TurnsNext(tab->nt, tab->t, tab->turns, t);
}

/* A BendsCurve: the stretch at all labels of the table, and last the length. */
static PetscErrorCode InTime(const void *table, PetscReal t, PetscReal value[], PetscReal slope[]) {
  const Table *tab = (const Table *)table;
  PetscReal w[2][4];
  PetscInt j;

  PetscFunctionBegin;
  SplineWeights(tab->nt, tab->t, t, &j, w[0], w[1], NULL);
  for (PetscInt i = 0; i <= tab->ns; i++) {
    const PetscBool last = (PetscBool)(i == tab->ns);
    const PetscReal *f = last ? tab->p : tab->g, *f_tt = last ? tab->p_tt : tab->g_tt;
    const PetscInt k = j * tab->ns + (last ? i - 1 : i), next = k + tab->ns;
    for (int d = 0; d < 2; d++)
      (d ? slope : value)[i] =
          w[d][0] * f[k] + w[d][1] * f[next] + w[d][2] * f_tt[k] + w[d][3] * f_tt[next];
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode FindBends(Growth self, PetscReal tolerance, Bends *bends) {
  const Table *tab = (const Table *)self->data;

  PetscFunctionBegin;
  PetscCall(BendsFind(tab->nt, tab->t, tab->ns + 1, InTime, tab, tolerance, bends));
  PetscFunctionReturn(0);
}

static PetscErrorCode DestroyTable(Growth self) {
  Table *tab = (Table *)self->data;

  PetscFunctionBegin;
  PetscCall(PetscFree(tab->s));
  PetscCall(PetscFree(tab->t));
  PetscCall(PetscFree(tab->g));
  PetscCall(PetscFree(tab->turns));
  PetscCall(PetscFree5(tab->g_ss, tab->g_tt, tab->g_sstt, tab->p, tab->p_tt));
  PetscCall(PetscFree(self->data));
  PetscFunctionReturn(0);
}

static PetscErrorCode TableCheck(const char *file, const Table *tab) {
  PetscFunctionBegin;
  UserCheck(tab->ns >= 4 && tab->nt >= 4, OptionsComm(),
            "-growth_table %s: needs at least 4 entries in /s and in /t", file);
  UserCheck(PetscAbsReal(tab->s[0]) < 1e-12 && PetscAbsReal(tab->s[tab->ns - 1] - 1) < 1e-12,
            OptionsComm(), "-growth_table %s: /s must run from 0 to 1", file);
  UserCheck(tab->t[0] <= 1e-12, OptionsComm(), "-growth_table %s: /t must start at 0", file);
  for (PetscInt i = 1; i < tab->ns; i++)
    UserCheck(tab->s[i] > tab->s[i - 1], OptionsComm(), "-growth_table %s: /s must increase", file);
  for (PetscInt i = 1; i < tab->nt; i++)
    UserCheck(tab->t[i] > tab->t[i - 1], OptionsComm(), "-growth_table %s: /t must increase", file);
  for (PetscInt i = 0; i < tab->ns * tab->nt; i++)
    UserCheck(tab->g[i] > 0, OptionsComm(), "-growth_table %s: /g must be positive", file);
  PetscFunctionReturn(0);
}

/* The spline may dip below 0 between positive entries: looks at a few places between each two. */
static PetscErrorCode TableCheckBetween(const char *file, const Table *tab) {
  enum { PLACES = 4 };

  PetscFunctionBegin;
  for (PetscInt j = 0; j < PLACES * (tab->nt - 1); j++)
    for (PetscInt i = 0; i < PLACES * (tab->ns - 1); i++) {
      PetscReal a = (PetscReal)(i % PLACES) / PLACES, b = (PetscReal)(j % PLACES) / PLACES,
                s = (1 - a) * tab->s[i / PLACES] + a * tab->s[i / PLACES + 1],
                t = (1 - b) * tab->t[j / PLACES] + b * tab->t[j / PLACES + 1], ws[4], wt[4], g;
      char text[3][64];
      PetscInt m, n;
      SplineWeights(tab->ns, tab->s, s, &m, ws, NULL, NULL);
      SplineWeights(tab->nt, tab->t, t, &n, wt, NULL, NULL);
      g = TableProduct(tab, m, n, ws, wt);
      UserCheck(g > 0, OptionsComm(),
                "-growth_table %s: between its entries the stretch falls to %s at s = %s, t = %s; "
                "give more entries there",
                file, OptionNumber(g, text[0]), OptionNumber(s, text[1]),
                OptionBoth(t, UNIT_TIME, text[2]));
    }
  PetscFunctionReturn(0);
}

static PetscErrorCode TableRead(const char *file, Table *tab) {
  PetscInt dims[2];

  PetscFunctionBegin;
  PetscCall(HdfReadQuantity("-growth_table", file, "/s", UNIT_NONE, 1, &tab->ns, &tab->s));
  PetscCall(HdfReadQuantity("-growth_table", file, "/t", UNIT_TIME, 1, &tab->nt, &tab->t));
  PetscCall(HdfReadQuantity("-growth_table", file, "/g", UNIT_LENGTH, 2, dims, &tab->g));
  UserCheck(dims[0] == tab->nt && dims[1] == tab->ns, OptionsComm(),
            "-growth_table %s: /g must be [%d, %d] as /t and /s are long, it is [%d, %d]", file,
            (int)tab->nt, (int)tab->ns, (int)dims[0], (int)dims[1]);
  PetscCall(TableCheck(file, tab));
  PetscFunctionReturn(0);
}

/* GrowthCreateTable - the law of -growth_table. */
PetscErrorCode GrowthCreateTable(Growth self) {
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool set;
  PetscInt n;
  Table *tab;

  PetscFunctionBegin;
  PetscCall(OptionText("-growth_table", file, &set));
  UserCheck(set, OptionsComm(), "-growth_type table needs -growth_table FILE");
  PetscCall(PetscNew(&tab));
  self->data = tab;
  self->destroy = DestroyTable;
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
  PetscCall(TableCheckBetween(file, tab));
  PetscCall(PetscCalloc1(tab->nt, &tab->turns));
  TurnsMark(tab->nt, tab->p + tab->ns - 1, tab->ns, tab->turns);
  self->next_turn = NextTurn;
  self->bends = FindBends;
  self->steep = PETSC_MAX_REAL;
  for (PetscInt j = 0; j < tab->nt; j++)
    self->steep = PetscMin(self->steep, SplineSteepest(tab->ns, tab->s, tab->g + j * tab->ns, 1));
  self->initial_length = tab->p[tab->ns - 1];
  self->end_time = tab->t[tab->nt - 1];
  self->stretch = StretchTable;
  self->arc = ArcTable;
  PetscFunctionReturn(0);
}
