#include "stepping/estimating.h"
#include "stepping/vbdf.h"

/*
  The state U of a run fails the exact equations F(t, u, u_t) = 0 by a defect d in space
  (FrameDefect()), and each step adds its local error l to it. So its error e = U - u obeys, to
  first order,

    F_U e + F_U_t e_t = -d,     e jumps by l at each step

  This is stepped by backward Euler, e = A z with the factor A by which x2 falls and rises taken out
  of the fields across, as it is for the run itself (formula.c; in space a factor each for those of
  both directions, or one for both while they are of like size). Errors are smooth along the rod,
  and a fifth of them is no matter: so it is done on a coarse mesh of every few nodes of the run's,
  and once in a few steps while the rod is straight. From the first contact on cells are no longer
  than the layer over which contact spreads, and it is done once in a few steps, unless the rod
  moves far in one. The parts, in space, in time and so on, are carried along each for itself. What
  is reported is the error that they make in the tip's place (over its distance), |x2| and the
  energy (each over itself): that of the latest state, and the largest so far.

  An error that grows as exp(gamma t) grows by 1/(1 - gamma h) in a step h of backward Euler,
  without bound where h is 1/gamma; in m parts of it by (1 - gamma h/m)^-m, which is near exp(gamma
  h) there, and has its pole elsewhere. So in contact, where modes grow between two such steps (a
  wave that buckles in a tube), a step by which an error grows much is taken again in parts, and
  what is less of both counts.
*/

/* By how much a size has changed. */
static PetscReal Ratio(PetscReal now, PetscReal before) {
  return now > rod_rule.vanished && before > rod_rule.vanished ? now / before : 1;
}

static PetscBool Alike(const PetscReal size[MIRRORS]) {
  return (PetscBool)(PetscMin(size[0], size[1]) > rod_rule.vanished &&
                     PetscMax(size[0], size[1]) <
                         step_rule.alike_across * PetscMin(size[0], size[1]));
}

/* By how much the fields of each group have changed, as far as x2 and x3 tell. */
static void Ratios(const PetscReal now[MIRRORS], const PetscReal before[MIRRORS],
                   PetscReal ratio[GROUPS]) {
  const PetscBool both = (PetscBool)(Alike(now) && Alike(before));

  ratio[ALONG] = 1;
  for (int k = 0; k < MIRRORS; k++)
    ratio[1 << k] =
        both ? Ratio(hypot(now[0], now[1]), hypot(before[0], before[1])) : Ratio(now[k], before[k]);
  ratio[TWIST] = ratio[ACROSS_2] * ratio[ACROSS_3];
}

/* Does what the material learns drive the rod across? Then what is there rises as a power of the
   time at first, and no factor is taken from it: errors of what has been learned do not rise with
   it. */
static PetscBool Driven(const Estimate self, int mirror) {
  const Learned learned = self->leg->rod->learned;

  return (PetscBool)(learned && learned->drive[mirror] > 0);
}

/* The largest x2 and x3, of the sizes of fields. */
static void Across(const Estimate self, const PetscReal size[MAX_FIELDS],
                   PetscReal across[MIRRORS]) {
  for (int k = 0; k < MIRRORS; k++)
    across[k] = k < self->mirrors && !Driven(self, k) ? size[1 + k] : 0;
}

/* Where the rod's vectors have a field of coarse node k; below 0: on another rank. What the
   material has learned in the middle of a coarse cell is that of the place next to it. */
static PetscInt EntryOf(const Estimate self, PetscInt k, PetscInt f) {
  const Rod rod = self->leg->rod;
  const Learned learned = rod->learned;
  PetscInt node = EstimateFineNode(self, k), field = f;

  if (learned && f >= learned->mech + learned->per && k + 1 < self->nodes) {
    const PetscInt both = node + EstimateFineNode(self, k + 1);
    node = both / 2;
    if (both % 2 == 0) field -= learned->per;
  }
  return node < rod->first || node >= rod->end ? -1 : (node - rod->first) * self->fields + field;
}

/* Has a field a rate? Not moments and forces. */
static PetscBool HasRate(const Estimate self, PetscInt f) {
  const Learned learned = self->leg->rod->learned;

  return (PetscBool)(f < self->left || (learned && f >= learned->mech) ||
                     (LearnedExtra(self->leg->rod) && f == learned->mech - 1)); /* L */
}

/* Where a front goes by, from one label on to another, differences at a place do not tell the
   error: of what is learned that along the material does, which is added to; of angles, see leg.c.
 */
static PetscErrorCode AlongFront(Estimate self, PetscInt n, const PetscReal since[],
                                 const Vec point[], PetscReal weight[][VBDF_FIELDS], Vec along,
                                 PetscReal *from, PetscReal *to) {
  const Rod rod = self->leg->rod;
  PetscReal t, times[VBDF_POINTS];

  PetscFunctionBegin;
  PetscCall(TSGetTime(self->leg->ts, &t));
  for (PetscInt j = 0; j < n; j++) times[j] = t + since[j];
  PetscCall(LearnedCarry(rod, t, n, times, point, weight, PETSC_TRUE, along));
  RodPassed(rod, times[n - 1], t, from, to);
  PetscFunctionReturn(0);
}

/* The step's local error at the coarse nodes of this rank comes on top of those before, which have
   changed meanwhile. times_error: it may be so many times that. */
static PetscErrorCode AddLocal(Estimate self, PetscReal times_error,
                               const PetscReal ratio[GROUPS]) {
  PetscReal weight[VBDF_POINTS][VBDF_FIELDS], times[VBDF_POINTS];
  const PetscInt fields = self->fields, followed = self->followed;
  const PetscScalar *u[VBDF_POINTS];
  const Rod rod = self->leg->rod;
  const PetscReal *s = RodLabels(rod), *more = NULL;
  PetscReal from = 1, to = 0;
  PetscInt n, points, order;
  Vec point[VBDF_POINTS], along = NULL;

  PetscFunctionBegin;
  PetscCall(VBDFGetLocalError(self->leg->ts, fields, &n, weight));
  PetscCall(VBDFGetHistory(self->leg->ts, &points, times, point, &order));
  if (n > points) n = 0;
  if (n && LearnedHasCorner(rod)) {
    PetscCall(VecDuplicate(point[0], &along));
    PetscCall(VecZeroEntries(along));
    PetscCall(AlongFront(self, n, times, point, weight, along, &from, &to));
    PetscCall(VecGetArrayRead(along, (const PetscScalar **)&more));
  }
  for (PetscInt j = 0; j < n; j++) PetscCall(VecGetArrayRead(point[j], &u[j]));
  for (PetscInt k = 0; k < self->nodes; k++) {
    PetscReal *local = self->own.local + k * followed, *skipped = self->own.skipped + k * followed;
    for (PetscInt f = 0; f < followed; f++) {
      const PetscInt at = EntryOf(self, k, f);
      const PetscReal label = at < 0 ? 0 : s[rod->first + at / fields];
      const PetscBool learned = (PetscBool)(rod->learned && f >= rod->learned->mech);
      if (at < 0 || !HasRate(self, f)) continue;
      local[f] *= ratio[self->model->group[f]];
      skipped[f] *= ratio[self->model->group[f]];
      if (learned && more) local[f] += times_error * more[at];
      if (label >= from && label <= to && !learned && !RodIsPlace(self->model, f)) continue;
      for (PetscInt j = 0; j < n; j++)
        local[f] += times_error * weight[j][f] * u[j][self->leg->from + at];
    }
  }
  for (PetscInt j = 0; j < n; j++) PetscCall(VecRestoreArrayRead(point[j], &u[j]));
  if (along) PetscCall(VecRestoreArrayRead(along, (const PetscScalar **)&more));
  PetscCall(VecDestroy(&along));
  PetscFunctionReturn(0);
}

/* The defects of the coarse cells: those of the cells in them. They change slowly, but for the
   factor of the fields across. */
static PetscErrorCode MeasureDefect(Estimate self, const PetscReal across[MIRRORS]) {
  const PetscInt fields = self->fields;
  const Rod rod = self->leg->rod;
  PetscReal ratio[GROUPS], t;
  RodState at;

  PetscFunctionBegin;
  Ratios(across, self->measured, ratio);
  PetscCall(PetscArraycpy(self->measured, across, MIRRORS));
  if (self->until-- > 0) {
    for (PetscInt k = 0; k < self->nodes; k++)
      for (PetscInt f = 0; f < fields; f++)
        self->own.defect[k * fields + f] *= ratio[self->model->group[f]];
    PetscFunctionReturn(0);
  }
  self->until = step_rule.defects_every - 1;
  PetscCall(TSGetTime(self->leg->ts, &t));
  at = (RodState){.t = t, .U = self->leg->U, .U_t = self->leg->newton.latest.U_t};
  PetscCall(rod->model->defect(rod, &at, self->defect));
  PetscCall(PetscArrayzero(self->own.defect, self->nodes * fields));
  for (PetscInt i = PetscMax(1, rod->first); i < rod->end; i++)
    for (PetscInt f = 0; f < fields; f++)
      self->own.defect[(i - 1) / self->stride * fields + f] += self->defect[i - rod->first][f];
  PetscFunctionReturn(0);
}

/* State, rate and defect of what is owned; all of it on rank 0. */
static PetscErrorCode Gather(Estimate self, const PetscReal across[MIRRORS]) {
  const PetscInt fields = self->fields, count = self->nodes * (3 * fields + 2 * self->followed);
  const Vec rates = self->leg->newton.latest.U_t;
  const Rod rod = self->leg->rod;
  const PetscScalar *u, *rate;

  PetscFunctionBegin;
  PetscCall(MeasureDefect(self, across));
  PetscCall(VecGetArrayRead(self->leg->U, &u));
  PetscCall(VecGetArrayRead(rates, &rate));
  for (PetscInt k = 0; k < self->nodes; k++)
    for (PetscInt f = 0; f < fields; f++) {
      const PetscInt at = EntryOf(self, k, f);
      if (at < 0) continue;
      self->own.u[k * fields + f] = u[at];
      self->own.rate[k * fields + f] = rate[at];
    }
  PetscCall(VecRestoreArrayRead(self->leg->U, &u));
  PetscCall(VecRestoreArrayRead(rates, &rate));
  PetscCallMPI(
      MPI_Reduce(self->own.u, self->all.u, (PetscMPIInt)count, MPIU_REAL, MPI_SUM, 0, rod->comm));
  PetscFunctionReturn(0);
}

/* The size of a field on the coarse mesh, and the rate at which its logarithm changes (scaled:
   squares may lie below the smallest number). */
static PetscReal SizeOf(const Estimate self, PetscInt f, PetscReal *rate) {
  PetscReal most = 0, sum = 0, by_rate = 0;

  *rate = 0;
  for (PetscInt i = f; i < self->nodes * self->fields; i += self->fields)
    most = PetscMax(most, PetscAbsReal(self->all.u[i]));
  if (most <= rod_rule.vanished) return 0;
  for (PetscInt i = f; i < self->nodes * self->fields; i += self->fields) {
    sum += PetscSqr(self->all.u[i] / most);
    by_rate += self->all.u[i] / most * (self->all.rate[i] / most);
  }
  *rate = by_rate / sum;
  return most * PetscSqrtReal(sum);
}

/* |x2| and |x3| on the coarse mesh, and the rates of their logarithms. */
static void Sizes(const Estimate self, PetscReal size[MIRRORS], PetscReal rate[MIRRORS]) {
  PetscReal both = 0;

  for (int k = 0; k < MIRRORS; k++)
    size[k] = k < self->mirrors && !Driven(self, k) ? SizeOf(self, 1 + k, &rate[k]) : (rate[k] = 0);
  if (!Alike(size)) return;
  for (int k = 0; k < MIRRORS; k++) both += PetscSqr(size[k] / hypot(size[0], size[1])) * rate[k];
  for (int k = 0; k < MIRRORS; k++) rate[k] = both;
}

static PetscErrorCode PutState(Estimate self) {
  PetscReal *u, *rate;

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(self->U, (PetscScalar **)&u));
  PetscCall(VecGetArrayWrite(self->rate, (PetscScalar **)&rate));
  PetscCall(PetscArraycpy(u, self->all.u, self->nodes * self->fields));
  PetscCall(PetscArraycpy(rate, self->all.rate, self->nodes * self->fields));
  PetscCall(VecRestoreArrayWrite(self->U, (PetscScalar **)&u));
  PetscCall(VecRestoreArrayWrite(self->rate, (PetscScalar **)&rate));
  PetscFunctionReturn(0);
}

/* F_U + F_U_t shift at the state that is put. */
static PetscErrorCode Linearise(Estimate self, PetscReal t, const PetscReal shift[]) {
  RodState at = {.t = t, .U = self->U, .U_t = self->rate, .fresh = PETSC_TRUE};

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(at.shift, shift, self->fields));
  PetscCall(self->model->residual(self->rod, &at, self->F));
  if (self->elimination)
    PetscCall(self->model->eliminate(self->rod, &at, self->elimination));
  else {
    PetscCall(self->model->jacobian(self->rod, &at, self->J));
    PetscCall(KSPSetOperators(self->ksp, self->J, self->J));
  }
  PetscFunctionReturn(0);
}

/* ... times e is rhs */
static PetscErrorCode Solve(Estimate self, PetscReal *e) {
  const PetscInt n = self->nodes * self->fields;
  const PetscScalar *x;
  PetscReal *b;

  PetscFunctionBegin;
  if (self->rod->learned && self->elimination) {
    PetscCall(VecPlaceArray(self->nudged, self->rhs));
    PetscCall(VecPlaceArray(self->G, e));
    PetscCall(LearnedSolve(self->rod, self->nudged, self->G));
    PetscCall(VecResetArray(self->nudged));
    PetscCall(VecResetArray(self->G));
    PetscFunctionReturn(0);
  }
  if (self->elimination) {
    PetscCall(EliminationSolve(self->elimination, (const PetscReal(*)[LINE_FIELDS])self->rhs,
                               (PetscReal(*)[LINE_FIELDS])e));
    PetscFunctionReturn(0);
  }
  PetscCall(VecGetArrayWrite(self->nudged, (PetscScalar **)&b));
  PetscCall(PetscArraycpy(b, self->rhs, n));
  PetscCall(VecRestoreArrayWrite(self->nudged, (PetscScalar **)&b));
  PetscCall(KSPSolve(self->ksp, self->nudged, self->G));
  PetscCall(VecGetArrayRead(self->G, &x));
  PetscCall(PetscArraycpy((PetscScalar *)e, x, n));
  PetscCall(VecRestoreArrayRead(self->G, &x));
  PetscFunctionReturn(0);
}

/* The fastest rate of any field, as a speed: what turns does so in the scene's unit of length, for
   an angle has none of its own. */
static PetscReal Fastest(const Estimate self, const PetscReal *rate) {
  const PetscInt fields = self->fields;
  PetscReal fastest = 0;

  for (PetscInt f = 0; f < fields; f++) {
    const PetscReal per = RodFieldUnit(self->rod, 0) / RodFieldUnit(self->rod, f);
    for (PetscInt i = f; i < self->nodes * fields; i += fields)
      fastest = PetscMax(fastest, PetscAbsReal(rate[i]) * per);
  }
  return fastest;
}

/* The beta of friction; the least of several rods'. */
static PetscReal LeastBeta(const Estimate self) {
  PetscReal least = RodCoarseGet(self->rod->each[0], COARSE_BETA);

  for (PetscInt k = 1; k < self->rod->rods; k++)
    least = PetscMin(least, RodCoarseGet(self->rod->each[k], COARSE_BETA));
  return least;
}

/* rhs = -F_U_t b, by a difference so small that friction is straight over it. */
static PetscErrorCode TimesRate(Estimate self, PetscReal t) {
  const RodState at = {.t = t, .U = self->U, .U_t = self->nudged};
  const PetscReal beta = LeastBeta(self);
  const PetscInt n = self->nodes * self->fields;
  const PetscScalar *F, *G;
  const PetscReal most = Fastest(self, self->b);
  PetscReal *rate, fastest = 0, scale;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(self->rhs, n));
  if (most <= rod_rule.vanished) PetscFunctionReturn(0);
  if (RodIsViscous(self->rod)) fastest = Fastest(self, self->all.rate);
  scale = step_rule.derivative_step *
          PetscMax(fastest, PetscSqrtReal(beta > 0 ? beta : friction_tiny)) / most;
  PetscCall(VecCopy(self->rate, self->nudged));
  PetscCall(VecGetArray(self->nudged, (PetscScalar **)&rate));
  for (PetscInt i = 0; i < n; i++) rate[i] += scale * self->b[i];
  PetscCall(VecRestoreArray(self->nudged, (PetscScalar **)&rate));
  PetscCall(self->model->residual(self->rod, &at, self->G));
  PetscCall(VecGetArrayRead(self->F, &F));
  PetscCall(VecGetArrayRead(self->G, &G));
  for (PetscInt i = 0; i < n; i++) self->rhs[i] = -(G[i] - F[i]) / scale;
  PetscCall(VecRestoreArrayRead(self->F, &F));
  PetscCall(VecRestoreArrayRead(self->G, &G));
  PetscFunctionReturn(0);
}

/* rhs -= d: of each cell's equations, in the rows that the model has them. */
static void SubtractDefect(Estimate self) {
  const PetscInt fields = self->fields;

  for (PetscInt k = 0; k + 1 < self->nodes; k++)
    for (PetscInt f = 0; f < fields; f++)
      self->rhs[(f < self->left ? k + 1 : k) * fields + f] -= self->all.defect[k * fields + f];
}

/* The residual G where a number of each scene is more by a part of itself. */
static PetscErrorCode ResidualBeyond(Estimate self, const RodState *at, CoarseNumber number) {
  const Rod rod = self->rod;
  PetscReal *taken;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(rod->rods, &taken));
  for (PetscInt k = 0; k < rod->rods; k++) {
    taken[k] = RodCoarseGet(rod->each[k], number);
    RodCoarseSet(rod->each[k], number, (1 + step_rule.derivative_step) * taken[k]);
  }
  PetscCall(self->model->residual(rod, at, self->G));
  for (PetscInt k = 0; k < rod->rods; k++) RodCoarseSet(rod->each[k], number, taken[k]);
  PetscCall(PetscFree(taken));
  PetscFunctionReturn(0);
}

/* rhs -= by what the residual changes while a number of the scene grows by a part of itself. */
static PetscErrorCode SubtractChange(Estimate self, PetscReal t, CoarseNumber number) {
  const RodState at = {.t = t, .U = self->U, .U_t = self->nudged};
  const PetscScalar *F, *G;

  PetscFunctionBegin;
  PetscCall(VecCopy(self->rate, self->nudged)); /* (the same rates, but no state that is known) */
  PetscCall(ResidualBeyond(self, &at, number));
  PetscCall(VecGetArrayRead(self->F, &F));
  PetscCall(VecGetArrayRead(self->G, &G));
  for (PetscInt i = 0; i < self->nodes * self->fields; i++)
    self->rhs[i] -= (G[i] - F[i]) / step_rule.derivative_step;
  PetscCall(VecRestoreArrayRead(self->F, &F));
  PetscCall(VecRestoreArrayRead(self->G, &G));
  PetscFunctionReturn(0);
}

/* Is there anything of this kind that errs? */
static PetscBool Errs(const Estimate self, int part) {
  if (part == ESTIMATE_LIMIT) return RodIsLimit(self->rod);
  return (PetscBool)(part != ESTIMATE_SOFT || self->touches);
}

/* rhs -= what this part does: the defect; beta dF/dbeta, for friction that is exact is that of
   beta -> 0; k dF/dk, for rigid contact is that of 1/k -> 0. */
static PetscErrorCode SubtractSource(Estimate self, PetscReal t, int part) {
  PetscFunctionBegin;
  if (part == ESTIMATE_SPACE) SubtractDefect(self);
  if (part == ESTIMATE_LIMIT) PetscCall(SubtractChange(self, t, COARSE_BETA));
  if (part == ESTIMATE_SOFT) PetscCall(SubtractChange(self, t, COARSE_STIFFNESS));
  PetscFunctionReturn(0);
}

/* Not more than e^30 up or down in a step. */
static PetscReal Limited(PetscReal ratio) {
  return PetscExpReal(PetscMax(-step_rule.estimate_change,
                               PetscMin(step_rule.estimate_change, PetscLogReal(ratio))));
}

/* The errors of a part as they are at t, if they go along with the material: in place. */
static PetscErrorCode CarryErrors(Estimate self, PetscReal t, int part) {
  PetscReal weight[1][MAX_FIELDS], *e;

  PetscFunctionBegin;
  if (!LearnedCarries(self->rod)) PetscFunctionReturn(0);
  for (int f = 0; f < MAX_FIELDS; f++) weight[0][f] = 1;
  PetscCall(VecGetArrayWrite(self->nudged, (PetscScalar **)&e));
  PetscCall(PetscArraycpy(e, self->e[part], self->nodes * self->fields));
  PetscCall(VecRestoreArrayWrite(self->nudged, (PetscScalar **)&e));
  PetscCall(VecPlaceArray(self->G, self->e[part]));
  PetscCall(
      LearnedCarry(self->rod, t, 1, &self->before, &self->nudged, weight, PETSC_FALSE, self->G));
  PetscCall(VecResetArray(self->G));
  PetscFunctionReturn(0);
}

/* b = minus the errors that a part of a step begins with, over its length; those of the run's steps
   come in the first. */
static void TakeErrors(Estimate self, int part, const PetscReal ratio[GROUPS], PetscReal step,
                       PetscBool first) {
  const PetscInt fields = self->fields, followed = self->followed;

  for (PetscInt k = 0; k < self->nodes; k++)
    for (PetscInt f = 0; f < followed; f++) {
      if (!HasRate(self, f)) continue;
      PetscReal e = self->e[part][k * fields + f] * ratio[self->model->group[f]];
      if (part == ESTIMATE_TIME && first)
        e += self->all.local[k * followed + f] + self->all.skipped[k * followed + f];
      self->b[k * fields + f] = -e / step;
    }
}

/* All errors, over a step to t in equal parts; rate and ratio: of |x2| and |x3|, at its end and
   over it. (A'/A is that at t: with its mean over the step, which is another where the rate
   changes, errors would rise or fall against x2.) */
static PetscErrorCode StepErrors(Estimate self, PetscReal t, PetscInt parts,
                                 const PetscReal rate[MIRRORS], const PetscReal ratio[GROUPS]) {
  const PetscReal step = (t - self->before) / (PetscReal)parts;
  PetscReal shift[MAX_FIELDS], each[GROUPS];

  PetscFunctionBegin;
  for (PetscInt f = 0; f < self->fields; f++) {
    shift[f] = 1 / step;
    for (int k = 0; k < MIRRORS; k++)
      if (self->model->group[f] & 1 << k) shift[f] += rate[k];
  }
  for (int g = 0; g < GROUPS; g++)
    each[g] =
        parts == 1 ? Limited(ratio[g]) : PetscPowReal(Limited(ratio[g]), 1 / (PetscReal)parts);
  PetscCall(Linearise(self, t, shift));
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    for (PetscInt i = 0; i < parts && Errs(self, part); i++) {
      if (i == 0) PetscCall(CarryErrors(self, t, part));
      TakeErrors(self, part, each, step, (PetscBool)(i == 0));
      PetscCall(TimesRate(self, t));
      PetscCall(SubtractSource(self, t, part));
      PetscCall(Solve(self, self->e[part]));
    }
  PetscFunctionReturn(0);
}

/* The largest error at t, and does any grow much, to more than is asked of a step? Of one rod. */
static PetscErrorCode LargestOf(const Estimate self, PetscReal t, PetscReal *largest,
                                PetscBool *grows) {
  PetscReal seen[ESTIMATE_SEEN] = {0}, change[RIGID_VALUES];

  PetscFunctionBegin;
  for (int part = 0; part < ESTIMATE_PARTS; part++) {
    if (!Errs(self, part)) continue;
    PetscCall(EstimateSee(self, t, self->e[part], seen, change));
    for (int k = 0; k < ESTIMATE_SEEN; k++) {
      if (PetscIsInfOrNanReal(seen[k])) seen[k] = PETSC_MAX_REAL;
      if (seen[k] > PetscMax(step_rule.estimate_growth * self->now[part][k], self->leg->rtol))
        *grows = PETSC_TRUE;
      *largest = PetscMax(*largest, seen[k]);
    }
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Largest(const Estimate self, PetscReal t, PetscReal *largest,
                              PetscBool *grows) {
  PetscFunctionBegin;
  *largest = 0;
  *grows = PETSC_FALSE;
  for (PetscInt k = 0; k < self->rod->rods; k++)
    PetscCall(LargestOf(self->part ? self->part[k] : self, t, largest, grows));
  PetscFunctionReturn(0);
}

static PetscErrorCode CopyErrors(const Estimate self, PetscReal *const from[ESTIMATE_PARTS],
                                 PetscReal *const to[ESTIMATE_PARTS]) {
  PetscFunctionBegin;
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(PetscArraycpy(to[part], from[part], self->nodes * self->fields));
  PetscFunctionReturn(0);
}

/* ... in which none grows by more than it may (see above). */
static PetscErrorCode StepWhatGrows(Estimate self, PetscReal t, const PetscReal rate[MIRRORS],
                                    const PetscReal ratio[GROUPS]) {
  PetscReal once, again;
  PetscBool grows;

  PetscFunctionBegin;
  if (self->touches) PetscCall(CopyErrors(self, self->e, self->begun));
  PetscCall(StepErrors(self, t, 1, rate, ratio));
  if (!self->touches) PetscFunctionReturn(0);
  PetscCall(Largest(self, t, &once, &grows));
  if (!grows) PetscFunctionReturn(0);
  PetscCall(CopyErrors(self, self->e, self->once));
  PetscCall(CopyErrors(self, self->begun, self->e));
  PetscCall(StepErrors(self, t, step_rule.estimate_parts, rate, ratio));
  PetscCall(Largest(self, t, &again, &grows));
  if (again > once) PetscCall(CopyErrors(self, self->once, self->e));
  PetscFunctionReturn(0);
}

/* From before to t. */
static PetscErrorCode Advance(Estimate self, PetscReal t) {
  PetscReal size[MIRRORS], rate[MIRRORS], ratio[GROUPS];

  PetscFunctionBegin;
  Sizes(self, size, rate);
  Ratios(size, self->size, ratio);
  PetscCall(PetscArraycpy(self->size, size, MIRRORS));
  RodCoarseFollow(self->rod, self->leg->rod);
  PetscCall(PutState(self));
  PetscCall(StepWhatGrows(self, t, rate, ratio));
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    for (PetscInt k = 0; k < self->rod->rods && Errs(self, part); k++)
      PetscCall(EstimateCount(self->part ? self->part[k] : self, t, part));
  PetscFunctionReturn(0);
}

/* How far the rod is from straight: the angle of its steepest place. */
static PetscReal Angle(const Estimate self, const PetscReal size[MAX_FIELDS]) {
  enum { P2 = 5 }; /* x, and p0 and p1 before it */
  return self->model->space ? 2 * hypot(size[P2], size[P2 + 1]) : size[self->left - 1];
}

/*
  LookForKink - the error of a step that was rejected was not what the steps before had let expect:
  something in it is not smooth in time, as where a tip meets a layer. Moments feel rates at once:
  such a step, and some behind it, are looked at one by one. Those before it, which were not yet,
  come before it. Differences of what is not smooth tell nothing of derivatives: its error is more
  than that of smooth ones (as it is in space, see rod/pair_defect.h).
*/
static PetscErrorCode LookForKink(Estimate self, PetscReal *times_error) {
  const PetscInt count = self->nodes * self->followed;
  PetscInt rejected;
  PetscBool kink;

  PetscFunctionBegin;
  PetscCall(TSGetStepRejections(self->leg->ts, &rejected));
  kink = (PetscBool)(rejected > self->rejected && !self->touches);
  self->rejected = rejected;
  *times_error = kink ? step_rule.kink_error : 1;
  self->watch = kink ? step_rule.estimate_every : PetscMax(0, self->watch - 1);
  if (!kink || !self->since) PetscFunctionReturn(0);
  for (PetscInt i = 0; i < count; i++) {
    self->own.skipped[i] += self->own.local[i];
    self->own.local[i] = 0;
  }
  self->before = self->time;
  PetscFunctionReturn(0);
}

/* Is it too early to step e again? */
static PetscBool Waits(const Estimate self, PetscReal t, const PetscReal size[MAX_FIELDS]) {
  return (PetscBool)(self->since < step_rule.estimate_every && !self->watch &&
                     (self->touches || Angle(self, size) < step_rule.estimate_straight) &&
                     t < RodEndTime(self->leg->rod));
}

/* What rank 0 has found of the latest state, to all. */
static PetscErrorCode Share(Estimate self) {
  PetscReal all[ESTIMATE_PARTS * ESTIMATE_SEEN + ESTIMATE_SEEN + RIGID_VALUES], *at = all;

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(at, self->now[0], ESTIMATE_PARTS * ESTIMATE_SEEN));
  PetscCall(PetscArraycpy(at += ESTIMATE_PARTS * ESTIMATE_SEEN, self->began, ESTIMATE_SEEN));
  PetscCall(PetscArraycpy(at += ESTIMATE_SEEN, self->rigid, RIGID_VALUES));
  PetscCallMPI(MPI_Bcast(all, (PetscMPIInt)PETSC_STATIC_ARRAY_LENGTH(all), MPIU_REAL, 0,
                         self->leg->rod->comm));
  PetscCall(PetscArraycpy(self->now[0], at = all, ESTIMATE_PARTS * ESTIMATE_SEEN));
  PetscCall(PetscArraycpy(self->began, at += ESTIMATE_PARTS * ESTIMATE_SEEN, ESTIMATE_SEEN));
  PetscCall(PetscArraycpy(self->rigid, at += ESTIMATE_SEEN, RIGID_VALUES));
  PetscFunctionReturn(0);
}

static PetscErrorCode StepOn(Estimate self, PetscBool jumped, PetscBool touches) {
  PetscReal size[MAX_FIELDS], across[MIRRORS], ratio[GROUPS], rate[MIRRORS], times_error = 1, t;

  PetscFunctionBegin;
  PetscCall(TSGetTime(self->leg->ts, &t));
  if (touches) PetscCall(EstimateLookAtLayer(self, t));
  PetscCall(RodFieldSizes(self->leg->rod, self->leg->U, size));
  Across(self, size, across);
  PetscCall(LookForKink(self, &times_error));
  Ratios(across, self->latest, ratio);
  if (!jumped) PetscCall(AddLocal(self, times_error, ratio));
  PetscCall(PetscArraycpy(self->latest, across, MIRRORS));
  self->time = t;
  self->since++;
  if (Waits(self, t, size)) PetscFunctionReturn(0);
  PetscCall(Gather(self, across));
  if (self->rod && !jumped) PetscCall(Advance(self, t));
  if (self->rod && jumped) Sizes(self, self->size, rate);
  PetscCall(PetscArrayzero(self->own.local, 2 * self->nodes * self->followed)); /* and skipped */
  self->before = t;
  self->since = 0;
  PetscCall(Share(self));
  PetscFunctionReturn(0);
}

/* EstimateGives - what others that press the rod put its tip off by, as their contact gives: errors
   of it alone do not know of that. */
void EstimateGives(Estimate self, PetscReal gives) {
  if (self) self->gives = gives;
}

/* EstimateAgree - one of all and one of a rod of these are of one time. */
void EstimateAgree(const Estimate from, Estimate to) {
  to->touches = from->touches;
  to->since = from->since;
  to->watch = from->watch;
  to->until = from->until;
  to->before = from->before;
  to->time = from->time;
}

/*
  EstimateStep - goes on to the state that an accepted step has led to, of all rods that hold each
  other at once. Collective.

  jumped   the step was a jump: what it adds is not known
  touches  the rod has touched something, now or before
*/
PetscErrorCode EstimateStep(Estimate self, PetscBool jumped, PetscBool touches) {
  PetscFunctionBegin;
  if (!self || self->whole) PetscFunctionReturn(0);
  PetscCall(StepOn(self, jumped, touches));
  for (PetscInt k = 0; self->part && k < self->rod->rods; k++) EstimateAgree(self, self->part[k]);
  PetscFunctionReturn(0);
}

/* EstimateReported - the largest errors so far, of each part in each of what is seen; of a run that
   has not got far, those of its start. Collective. */
PetscErrorCode EstimateReported(Estimate self, PetscReal reported[ESTIMATE_PARTS][ESTIMATE_SEEN]) {
  const PetscMPIInt n = ESTIMATE_PARTS * ESTIMATE_SEEN;
  const MPI_Comm comm = self->leg->rod->comm;

  PetscFunctionBegin;
  PetscCall(EstimateGet(self, reported));
  PetscCallMPI(MPI_Bcast(self->start, n, MPIU_REAL, 0, comm));
  PetscCallMPI(MPI_Bcast(self->began, ESTIMATE_SEEN, MPIU_REAL, 0, comm));
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    for (int k = 0; k < ESTIMATE_SEEN; k++)
      if (EstimateIsEarly(self, self->before, k))
        reported[part][k] = PetscMax(reported[part][k], self->start[part][k]);
  PetscFunctionReturn(0);
}

/* EstimateLatest - the errors of the state when they were stepped last; and, of one that touches,
   what makes rigid contact of its tip and its energy: k dU/dk. (rigid may be NULL.) */
void EstimateLatest(Estimate self, PetscReal latest[ESTIMATE_PARTS][ESTIMATE_SEEN],
                    PetscReal rigid[RIGID_VALUES]) {
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    for (int k = 0; k < ESTIMATE_SEEN; k++) latest[part][k] = self->now[part][k];
  for (int k = 0; k < RIGID_VALUES && rigid; k++) rigid[k] = self->rigid[k];
}

/* EstimateGet - the largest errors so far beyond the start, for EstimateSet(). Collective. */
PetscErrorCode EstimateGet(Estimate self, PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN]) {
  const PetscMPIInt n = ESTIMATE_PARTS * ESTIMATE_SEEN;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(self->worst, n, MPIU_REAL, 0, self->leg->rod->comm));
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(PetscArraycpy(worst[part], self->worst[part], ESTIMATE_SEEN));
  PetscFunctionReturn(0);
}

/* EstimateSet - takes over those of an earlier run that this one goes on with, at t. */
PetscErrorCode EstimateSet(Estimate self, PetscReal t,
                           const PetscReal worst[ESTIMATE_PARTS][ESTIMATE_SEEN]) {
  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  self->before = self->time = t;
  if (self->whole) self->whole->before = self->whole->time = t;
  for (int part = 0; part < ESTIMATE_PARTS; part++)
    PetscCall(PetscArraycpy(self->worst[part], worst[part], ESTIMATE_SEEN));
  PetscFunctionReturn(0);
}
