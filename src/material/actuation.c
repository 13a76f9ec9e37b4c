#include "material/actuation.h"
#include "base/hdf.h"
#include "base/knots.h"
#include "base/spline.h"
#include "base/turns.h"

/*
  A bicubic not-a-knot spline through k[nt, n] at t and `at`, its value a product of the two sets of
  spline weights (as that of material/growth_table.c). A time that is there twice is a kink, on
  either side of which there is a spline of its own; of two rows a line, of three a parabola. Before
  the first time and behind the last it is what it is there, likewise along the rod.
*/
struct _Actuation {
  PetscInt n, nt;
  PetscReal *at, *t, *k, *k_ss, *k_tt, *k_sstt;
  PetscReal largest;        /* entry, without its sign */
  PetscInt leading;         /* the column that changes most */
  PetscBool *turns, *kinks; /* at which times */
};

/* What is less than this part of the largest change is round-off. */
static const PetscReal rests = 1e-12;

static const PetscInt most = 1000000;

/* ---- splines ---- */

/* The second derivatives in time, of all columns, of the rows first to end of one piece. */
static PetscErrorCode Piece(Actuation self, PetscInt first, PetscInt end, const PetscReal f[],
                            PetscReal f_tt[]) {
  const PetscInt n = self->n, rows = end - first + 1;
  const PetscReal *t = self->t + first;

  PetscFunctionBegin;
  if (rows >= 4) {
    PetscCall(SplineSecondDerivatives(rows, t, n, 1, n, f + first * n, f_tt + first * n));
    PetscFunctionReturn(0);
  }
  for (PetscInt i = 0; i < n && rows == 3; i++) {
    const PetscReal *y = f + first * n + i;
    const PetscReal bend =
        2 * ((y[2 * n] - y[n]) / (t[2] - t[1]) - (y[n] - y[0]) / (t[1] - t[0])) / (t[2] - t[0]);
    for (PetscInt j = first; j <= end; j++) f_tt[j * n + i] = bend;
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode InTime(Actuation self, const PetscReal f[], PetscReal f_tt[]) {
  PetscFunctionBegin;
  for (PetscInt first = 0, end; first < self->nt; first = end + 1) {
    for (end = first; end + 1 < self->nt && self->t[end + 1] > self->t[end];) end++;
    PetscCall(Piece(self, first, end, f, f_tt));
  }
  PetscFunctionReturn(0);
}

/* The weights of the rows j and j + 1 at a time, and those of its slope: just before it, for steps
   end at kinks, but for the start. Beyond the ends it rests. */
static void WeightsInTime(Actuation self, PetscReal t, PetscInt *j, PetscReal value[4],
                          PetscReal slope[4]) {
  const PetscInt last = self->nt - 1;
  const PetscReal *row = self->t, inside = PetscMin(PetscMax(t, row[0]), row[last]);
  PetscInt first;

  *j = KnotBefore(self->nt, row, inside);
  while (*j > 0 && row[*j] == inside) (*j)--;
  SplineWeights(2, row + *j, inside, &first, value, slope, NULL);
  if (t > row[last] || t < row[0] || (t == row[0] && t > 0))
    for (int i = 0; i < 4; i++) slope[i] = 0;
}

static PetscReal Product(Actuation self, PetscInt i, PetscInt j, const PetscReal ws[4],
                         const PetscReal wt[4]) {
  PetscReal sum = 0;

  for (PetscInt a = 0; a < 2; a++)
    for (PetscInt b = 0; b < 2; b++) {
      const PetscInt k = (j + b) * self->n + i + a;
      sum += ws[a] * (wt[b] * self->k[k] + wt[2 + b] * self->k_tt[k]) +
             ws[2 + a] * (wt[b] * self->k_ss[k] + wt[2 + b] * self->k_sstt[k]);
    }
  return sum;
}

/*
  ActuationValue - the strain at a place along the rod and a time, and its derivatives by the two
  (both may be NULL). At a kink that by time is the one before it.
*/
void ActuationValue(Actuation self, PetscReal at, PetscReal t, PetscReal *k, PetscReal *k_at,
                    PetscReal *k_t) {
  const PetscReal first = self->at[0], last = self->at[self->n - 1],
                  inside = PetscMin(PetscMax(at, first), last);
  PetscReal value[4], slope[4], in_time[4], rate[4];
  PetscInt i, j;

  SplineWeights(self->n, self->at, inside, &i, value, slope, NULL);
  WeightsInTime(self, t, &j, in_time, rate);
  *k = Product(self, i, j, value, in_time);
  if (k_at) *k_at = at == inside ? Product(self, i, j, slope, in_time) : 0;
  if (k_t) *k_t = Product(self, i, j, value, rate);
}

/* ---- when it turns ---- */

/* By how much a row changes to the next, at most. */
static PetscReal Change(Actuation self, PetscInt j) {
  PetscReal change = 0;

  for (PetscInt i = 0; i < self->n; i++)
    change =
        PetscMax(change, PetscAbsReal(self->k[(j + 1) * self->n + i] - self->k[j * self->n + i]));
  return change;
}

/* The column that changes most over all times. */
static PetscInt Leading(Actuation self) {
  PetscReal largest = -1;
  PetscInt leading = 0;

  for (PetscInt i = 0; i < self->n; i++) {
    PetscReal low = PETSC_MAX_REAL, high = PETSC_MIN_REAL;
    for (PetscInt j = 0; j < self->nt; j++) {
      low = PetscMin(low, self->k[j * self->n + i]);
      high = PetscMax(high, self->k[j * self->n + i]);
    }
    if (high - low > largest) {
      largest = high - low;
      leading = i;
    }
  }
  return leading;
}

/* When it kinks, sets out or comes to rest, and where the column that changes most turns back:
   steps that end there cannot leave out that it came and went. (A wave turns back somewhere at all
   times; that costs no steps.) */
static PetscErrorCode FindTurns(Actuation self) {
  PetscReal largest = 0;
  PetscBool moved = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscCalloc2(self->nt, &self->turns, self->nt, &self->kinks));
  self->leading = Leading(self);
  for (PetscInt j = 0; j + 1 < self->nt; j++) largest = PetscMax(largest, Change(self, j));
  for (PetscInt j = 0; j < self->nt; j++) {
    const PetscBool end = (PetscBool)(j + 1 == self->nt),
                    moves = (PetscBool)(!end && Change(self, j) > rests * largest),
                    twice = (PetscBool)(!end && self->t[j + 1] == self->t[j]);
    if (twice) self->kinks[j] = self->kinks[j + 1] = PETSC_TRUE;
    if (moves != moved && !twice) self->turns[j] = PETSC_TRUE;
    if ((end || (j == 0 && self->t[0] > 0)) && self->turns[j]) self->kinks[j] = PETSC_TRUE;
    if (!twice) moved = moves;
  }
  if (largest > 0) TurnsMark(self->nt, self->k + self->leading, self->n, self->turns);
  for (PetscInt j = 0; j < self->nt; j++)
    if (self->kinks[j]) self->turns[j] = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* ActuationNextTurn - the first time behind t at which it kinks, sets out, rests or turns back;
   PETSC_MAX_REAL if there is none. */
PetscReal ActuationNextTurn(Actuation self, PetscReal t) {
  return TurnsNext(self->nt, self->t, self->turns, t);
}

/* ActuationJerks - does its rate jump between two times? (At t = 0 all sets out.) */
PetscBool ActuationJerks(Actuation self, PetscReal t0, PetscReal t1) {
  for (PetscInt j = 0; j < self->nt; j++)
    if (self->kinks[j] && self->t[j] > 0 && self->t[j] >= t0 && self->t[j] < t1) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* A BendsCurve: all columns, and last the one that changes most. */
static PetscErrorCode AllInTime(const void *table, PetscReal t, PetscReal value[],
                                PetscReal slope[]) {
  const Actuation self = (const Actuation)table;
  PetscReal w[2][4];
  PetscInt j;

  PetscFunctionBegin;
  WeightsInTime(self, t, &j, w[0], w[1]);
  for (PetscInt i = 0; i <= self->n; i++) {
    const PetscInt a = j * self->n + (i < self->n ? i : self->leading), b = a + self->n;
    for (int d = 0; d < 2; d++)
      (d ? slope : value)[i] = w[d][0] * self->k[a] + w[d][1] * self->k[b] +
                               w[d][2] * self->k_tt[a] + w[d][3] * self->k_tt[b];
  }
  PetscFunctionReturn(0);
}

/* ActuationBends - adds the times at which it bends (base/bends.h). */
PetscErrorCode ActuationBends(Actuation self, PetscReal tolerance, Bends *bends) {
  PetscFunctionBegin;
  PetscCall(BendsFind(self->nt, self->t, self->n + 1, AllInTime, self, tolerance, bends));
  for (PetscInt j = 0; j < self->nt; j++)
    if (self->turns[j]) PetscCall(BendsAdd(bends, self->t[j]));
  PetscFunctionReturn(0);
}

/* ---- sizes ---- */

/* ActuationLargest - how large it is at most at the entries. */
PetscReal ActuationLargest(Actuation self) {
  return self->largest;
}

/* ActuationSteepest - by how much it changes at most per length along the rod, at any time. */
PetscReal ActuationSteepest(Actuation self) {
  PetscReal steepest = 0;

  for (PetscInt j = 0; j < self->nt; j++)
    for (PetscInt i = 0; i + 1 < self->n; i++) {
      const PetscReal *k = self->k + j * self->n + i;
      steepest = PetscMax(steepest, PetscAbsReal(k[1] - k[0]) / (self->at[i + 1] - self->at[i]));
    }
  return steepest;
}

/* ---- reading ---- */

static PetscErrorCode CheckTimes(Actuation self, const char *option, const char *file) {
  PetscFunctionBegin;
  UserCheck(self->nt >= 2 && self->n * self->nt <= most, OptionsComm(),
            "%s %s: needs 2 entries or more in /t, and at most %d in all; there are %d by %d",
            option, file, (int)most, (int)self->nt, (int)self->n);
  for (PetscInt j = 1; j < self->nt; j++)
    UserCheck(self->t[j] >= self->t[j - 1] && (j < 2 || self->t[j] > self->t[j - 2]), OptionsComm(),
              "%s %s: /t must increase, or have a time twice where it has a kink", option, file);
  UserCheck(self->t[1] > self->t[0] && self->t[self->nt - 1] > self->t[self->nt - 2], OptionsComm(),
            "%s %s: /t has its first or last time twice, where a kink has no other side", option,
            file);
  PetscFunctionReturn(0);
}

/* At a kink the rate jumps; what jumps itself would take the rod along at once. */
static PetscErrorCode CheckKinks(Actuation self, const char *option, const char *file,
                                 const char *name) {
  const PetscReal alike = 1e-9;
  char text[64];

  PetscFunctionBegin;
  for (PetscInt j = 0; j + 1 < self->nt; j++)
    UserCheck(self->t[j + 1] > self->t[j] || Change(self, j) <= alike * self->largest,
              OptionsComm(), "%s %s: %s jumps at t = %s, which /t has twice; give it some time",
              option, file, name, OptionBoth(self->t[j], UNIT_TIME, text));
  PetscFunctionReturn(0);
}

static PetscErrorCode Read(Actuation self, const char *option, const char *file, const char *name) {
  const PetscInt n = self->n;
  PetscInt dims[2], all;

  PetscFunctionBegin;
  PetscCall(HdfReadQuantity(option, file, "/t", UNIT_TIME, 1, &self->nt, &self->t));
  PetscCall(HdfReadQuantity(option, file, name, UNIT_CURVATURE, 2, dims, &self->k));
  UserCheck(
      dims[0] == self->nt && dims[1] == n, OptionsComm(),
      "%s %s: %s must be [%d, %d] as /t and the places along the rod are long, it is [%d, %d]",
      option, file, name, (int)self->nt, (int)n, (int)dims[0], (int)dims[1]);
  PetscCall(CheckTimes(self, option, file));
  for (PetscInt k = 0; k < n * self->nt; k++)
    self->largest = PetscMax(self->largest, PetscAbsReal(self->k[k]));
  PetscCall(CheckKinks(self, option, file, name));
  all = n * self->nt;
  PetscCall(PetscCalloc3(all, &self->k_ss, all, &self->k_tt, all, &self->k_sstt));
  PetscCall(SplineSecondDerivatives(n, self->at, self->nt, n, 1, self->k, self->k_ss));
  PetscCall(InTime(self, self->k, self->k_tt));
  PetscCall(InTime(self, self->k_ss, self->k_sstt));
  PetscCall(FindTurns(self));
  PetscFunctionReturn(0);
}

/*
  ActuationRead - reads a strain over time. Collective on OptionsComm(); the caller destroys it with
  ActuationDestroy(), also after an error.

  option, file  the file, and the option that named it
  name          of the array, [nt, n]
  n, at         places along the rod, increasing, 4 or more; the caller's, who keeps them
*/
PetscErrorCode ActuationRead(const char *option, const char *file, const char *name, PetscInt n,
                             const PetscReal at[], Actuation *actuation) {
  PetscFunctionBegin;
  PetscCall(PetscNew(actuation));
  (*actuation)->n = n;
  (*actuation)->at = (PetscReal *)at;
  PetscCall(Read(*actuation, option, file, name));
  PetscFunctionReturn(0);
}

PetscErrorCode ActuationDestroy(Actuation *actuation) {
  Actuation self = *actuation;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(PetscFree(self->t));
  PetscCall(PetscFree(self->k));
  PetscCall(PetscFree3(self->k_ss, self->k_tt, self->k_sstt));
  PetscCall(PetscFree2(self->turns, self->kinks));
  PetscCall(PetscFree(*actuation));
  PetscFunctionReturn(0);
}
