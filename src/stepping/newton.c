#include "stepping/newton.h"
#include "base/compat.h"
#include "base/blocklu.h"
#include "base/chain.h"
#include "rod/ask.h"
#include "rod/learned.h"
#include "rod/rules.h"
#include "stepping/rules.h"

/* The largest residual of each group of fields (rod.h) of one rod, in its scene's units, along the
   axes of the state: they do not see each other on the straight rod, and one may be 1e-16 times
   another. */
static PetscErrorCode AddResiduals(Rod rod, Vec U, Vec F, PetscReal residual[GROUPS]) {
  PetscReal size[MAX_FIELDS];
  Vector2 axis = {1, 0};

  PetscFunctionBegin;
  if (rod->model->pairs) {
    PetscCall(RodFieldSizes(rod, U, size));
    PetscCall(RodAxes(rod, U, size, &axis));
  }
  PetscCall(RodSizesAlong(rod, F, axis, size));
  for (PetscInt f = 0; f < rod->model->fields; f++)
    residual[rod->model->group[f]] =
        PetscMax(residual[rod->model->group[f]], size[f] / RodFieldUnit(rod, f));
  PetscFunctionReturn(0);
}

/* ... of all of them. */
static PetscErrorCode Residuals(Rod rod, Vec U, Vec F, PetscReal residual[GROUPS]) {
  Vec part[2];

  PetscFunctionBegin;
  for (int g = 0; g < GROUPS; g++) residual[g] = 0;
  for (PetscInt k = 0; k < rod->rods; k++) {
    PetscCall(RodPartOpenRead(rod, k, U, &part[0]));
    PetscCall(RodPartOpenRead(rod, k, F, &part[1]));
    PetscCall(AddResiduals(rod->each[k], part[0], part[1], residual));
    PetscCall(RodPartCloseRead(rod, k, F, &part[1]));
    PetscCall(RodPartCloseRead(rod, k, U, &part[0]));
  }
  PetscFunctionReturn(0);
}

static void LeaveRoundOff(const Rod rod, PetscReal size[MAX_FIELDS]) {
  const RodModel *model = rod->model;
  PetscReal bent[GROUPS] = {1};

  for (PetscInt f = 0; f < model->fields; f++)
    if (model->followed[f] && model->group[f] && strchr("tp", model->field[f][0]))
      bent[model->group[f]] = PetscMax(bent[model->group[f]], size[f]);
  for (PetscInt f = 0; f < model->fields; f++)
    if (!model->followed[f])
      size[f] = PetscMax(size[f],
                         step_rule.force_round_off * RodFieldUnit(rod, f) * bent[model->group[f]]);
}

/* The largest update of each group's fields of one rod, relative to the field's scale; those not
   followed count by weight; and that of any field followed. A field that is 0 throughout (the
   straight rod's x2) has converged when its update is 0. */
static PetscErrorCode AddUpdates(Rod rod, Vec U, Vec dU, PetscReal weight, PetscReal update[GROUPS],
                                 PetscReal *followed) {
  PetscReal size[MAX_FIELDS], change[MAX_FIELDS];
  Vector2 axis;

  PetscFunctionBegin;
  PetscCall(RodFieldScales(rod, U, &axis, size));
  LeaveRoundOff(rod, size);
  PetscCall(RodSizesAlong(rod, dU, axis, change));
  for (PetscInt f = 0; f < rod->model->fields; f++)
    if (change[f] != 0) {
      PetscReal r = change[f] / PetscMax(size[f], rod_rule.vanished),
                *most = &update[rod->model->group[f]];
      if (rod->model->followed[f])
        *followed = LargerSize(*followed, r);
      else
        r *= weight;
      *most = LargerSize(*most, r);
    }
  PetscFunctionReturn(0);
}

/* ... of all of them. */
static PetscErrorCode RelativeUpdates(Rod rod, Vec U, Vec dU, PetscReal weight,
                                      PetscReal update[GROUPS], PetscReal *followed) {
  Vec part[2];

  PetscFunctionBegin;
  *followed = 0;
  for (int g = 0; g < GROUPS; g++) update[g] = 0;
  for (PetscInt k = 0; k < rod->rods; k++) {
    PetscCall(RodPartOpenRead(rod, k, U, &part[0]));
    PetscCall(RodPartOpenRead(rod, k, dU, &part[1]));
    PetscCall(AddUpdates(rod->each[k], part[0], part[1], weight, update, followed));
    PetscCall(RodPartCloseRead(rod, k, dU, &part[1]));
    PetscCall(RodPartCloseRead(rod, k, U, &part[0]));
  }
  PetscFunctionReturn(0);
}

static PetscReal Largest(const PetscReal residual[GROUPS]) {
  PetscReal largest = 0;

  for (int g = 0; g < GROUPS; g++) largest = PetscMax(largest, residual[g]);
  return largest;
}

/* What an update of forces counts, relative to their size, beside those of the fields followed. */
static PetscReal WeightOfForces(const Newton *self, PetscReal floor) {
  if (self->waits >= step_rule.force_iterations) return 0;
  return PetscMin(1, floor / step_rule.force_settles);
}

/*
  Hopeless - will the iteration of a rod that can touch not arrive? Most that fail went on to the
  last of them: full steps diverge, to residuals of 1e10; those that are cut stall in ever
  shorter ones. The former are given up where the residual has been so many times that of the guess,
  so many times in a row (one that finds its way from far out of balance comes back from there), but
  not before the EARLIEST (the first are, of a rod that leaves a stiff wall), the latter where it
  has not halved in so many. What rests does not diverge: of a guess in balance to the last digit
  residuals of 1e-10 are many times its own, where a short step makes speeds of round-off.
*/
static PetscBool Hopeless(Newton *self, PetscInt it, PetscReal residual, PetscBool rests,
                          PetscBool cut) {
  const PetscBool begins = (PetscBool)!it,
                  halves = (PetscBool)(residual <= step_rule.stalls * self->halved);

  if (begins || halves) self->halved = residual;
  self->stalled = begins || halves ? 0 : self->stalled + 1;
  self->diverges = !begins && !(rests && self->guess <= step_rule.update_round_off) &&
                           residual > step_rule.diverges * self->guess
                       ? self->diverges + 1
                       : 0;
  return (PetscBool)(RodTouches(self->rod) &&
                     (cut ? self->stalled >= step_rule.stalls_iterations
                          : it >= step_rule.diverges_earliest &&
                                self->diverges >= step_rule.diverges_times));
}

/* The speed at which a place that is held must creep to be seen in this step: to go as far as the
   tolerance of the smallest field. Slower, it is not held to the full; else shifts that move with
   each step, however short, would make of what presses on a wall a motion at any speed, and steps
   would shrink for it without end. (Where nothing can press: 0.) */
static PetscReal SpeedSeen(const Newton *self, PetscReal step, const PetscReal size[]) {
  PetscReal least = PETSC_MAX_REAL;

  if (!RodTouches(self->rod)) return 0;
  for (PetscInt f = 0; f < self->rod->model->fields; f++)
    if (self->rod->model->followed[f] && size[f] > 0) least = PetscMin(least, size[f]);
  return self->given * least / step;
}

/* Exact Coulomb friction: once the iteration has converged, the shifts that hold sticking points
   are moved, and it goes on if these creep farther in the step than this part of the tolerance, of
   the rod's size; but not more often than that, for the shifts outlive the step, and go on settling
   in the next. */
static PetscErrorCode Hold(Newton *self, SNES snes, Vec U, Vec F, SNESConvergedReason *reason) {
  PetscReal creep, step, size[MAX_FIELDS];

  PetscFunctionBegin;
  PetscCall(TSGetTimeStep(self->ts, &step));
  PetscCall(RodFieldSizes(self->rod, U, size));
  PetscCall(self->rod->model->hold(self->rod, &self->latest, SpeedSeen(self, step, size), &creep));
  PetscCall(PetscInfo(snes, "held points creep at %g\n", (double)creep));
  if (creep * step > step_rule.stick_slips * self->given * size[0] &&
      self->holds < step_rule.stick_updates) {
    self->holds++;
    *reason = SNES_CONVERGED_ITERATING;
    self->waits = 0;
    PetscCall(SNESComputeFunction(snes, U, F));
  }
  PetscFunctionReturn(0);
}

/* A line search that looks at steps of any length, for forces may have any size. */
static PetscErrorCode SetSearch(SNES snes, SNESLineSearchType type) {
  SNESLineSearch search;

  PetscFunctionBegin;
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(SNESLineSearchSetType(search, type));
  PetscCall(SNESLineSearchSetTolerances(search, PETSC_DEFAULT, PETSC_MAX_REAL, PETSC_DEFAULT,
                                        PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscFunctionReturn(0);
}

/* Keeps what an observer of the state does not find by himself; where places stick, Hold() does. */
static PetscErrorCode KeepForces(Newton *self, Vec F) {
  Rod rod = self->rod;
  RodForces sum;
  Vec part;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < rod->rods; k++) {
    PetscCall(RodPartOpenRead(rod, k, F, &part));
    PetscCall(RodKeepLeft(rod->each[k], self->latest.t, part));
    PetscCall(RodPartCloseRead(rod, k, F, &part));
  }
  if (rod->order == 4 || !rod->model->bears) PetscFunctionReturn(0);
  PetscCall(rod->model->bears(rod, &self->latest, &sum));
  RodKeepBorne(rod, &sum);
  PetscFunctionReturn(0);
}

/*
  Converged - the test of SNES: by the update, per field, against the field's own size. A norm of
  the residual over all fields would not see x2 at 1e-16 beside x1.

  What is left after an iteration is about its update times the rate of convergence. The rate is
  that of the updates or, already after the first iteration, that of the residuals of the group that
  has still something to do: so an iteration that has arrived need not be repeated to see it. Not
  that of the updates where a rod can touch: the second one is next to nothing, whatever is left to
  be found, where the guess lies so deep in a wall that all the first one did was to leave it. And
  nothing has converged whose update was cut short.
*/
static PetscErrorCode Converged(SNES snes, PetscInt it, PetscReal xnorm, PetscReal gnorm,
                                PetscReal fnorm, SNESConvergedReason *reason, void *ctx) {
  Newton *self = (Newton *)ctx;
  PetscReal update[GROUPS] = {0}, residual[GROUPS], rate = 0, left = 0,
            floor = PetscMax(self->tolerance, step_rule.update_round_off);
  Vec U, dU, F;
  SNESLineSearch search;
  PetscReal followed = 0, part = 1, whole = 1;
  PetscBool hopeless;

  PetscFunctionBegin;
  *reason = PetscIsInfOrNanReal(fnorm) ? DIVERGED_NAN : SNES_CONVERGED_ITERATING;
  if (*reason) PetscFunctionReturn(0);
  PetscCall(SNESGetFunction(snes, &F, NULL, NULL));
  PetscCall(SNESGetSolution(snes, &U));
  PetscCall(Residuals(self->rod, U, F, residual));
  if (!it) {
    self->waits = self->holds = 0;
    self->guess = Largest(residual);
  } else {
    PetscCall(SNESGetSolutionUpdate(snes, &dU));
    PetscCall(RelativeUpdates(self->rod, U, dU, WeightOfForces(self, floor), update, &followed));
    /* of a rod that can touch no step is accepted without its forces, while it moves: one at the
       brink of a snap, whose speeds double from next to nothing on, would be taken for one at rest
     */
    self->waits = RodTouches(self->rod) && followed > floor ? 0 : self->waits + 1;
    for (int g = 0; g < GROUPS; g++) {
      if (update[g] > floor) rate = PetscMax(rate, residual[g] / self->residual[g]);
      left = LargerSize(left, update[g]);
    }
    if (it > 1 && !RodTouches(self->rod)) rate = PetscMin(rate, left / self->update);
    self->update = left;
    PetscCall(SNESGetLineSearch(snes, &search));
    PetscCall(SNESLineSearchGetLambda(search, &part));
    PetscCall(SNESLineSearchGetDamping(search, &whole));
    if (PetscIsInfOrNanReal(left))
      *reason = DIVERGED_NAN;
    else if (part < whole)
      *reason = SNES_CONVERGED_ITERATING;
    else if (left <= floor || left * rate <= step_rule.rate_margin * floor)
      *reason = SNES_CONVERGED_SNORM_RELATIVE;
    PetscCall(PetscInfo(snes, "iteration %d: update %g, rate %g, residual %g %g\n", (int)it,
                        (double)left, (double)rate, (double)residual[ALONG],
                        (double)residual[ACROSS_2]));
  }
  hopeless = Hopeless(self, it, Largest(residual), (PetscBool)(followed <= floor),
                      (PetscBool)(part < whole));
  if (!*reason && hopeless) *reason = SNES_DIVERGED_LINE_SEARCH;
  if (*reason > 0) PetscCall(KeepForces(self, F));
  if (*reason > 0 && RodSticks(self->rod) && self->rod->model->hold)
    PetscCall(Hold(self, snes, U, F, reason));
  PetscCall(PetscArraycpy(self->residual, residual, GROUPS));
  PetscFunctionReturn(0);
}

/* F(t, U, U_t), a TSIFunction. */
static PetscErrorCode Residual(TS ts, PetscReal t, Vec U, Vec U_t, Vec F, void *ctx) {
  Newton *self = (Newton *)ctx;
  RodState at = {.t = t, .U = U, .U_t = U_t, .fresh = self->fresh, .iterates = PETSC_TRUE};

  PetscFunctionBegin;
  (void)ts;
  self->latest = (RodState){.t = t, .U = U, .U_t = U_t};
  RodForgetDepth(self->rod);
  PetscCall(self->rod->model->residual(self->rod, &at, F));
  PetscFunctionReturn(0);
}

/* dF/dU + shift dF/dU_t, a TSIJacobian; for the fields across the shift is greater by factor_rate,
   of each of their mirrors. With an elimination it goes there, and not into the matrix. */
static PetscErrorCode Jacobian(TS ts, PetscReal t, Vec U, Vec U_t, PetscReal shift, Mat J, Mat P,
                               void *ctx) {
  Newton *self = (Newton *)ctx;
  const RodModel *model = self->rod->model;
  RodState at = {.t = t, .U = U, .U_t = U_t, .fresh = self->fresh, .iterates = PETSC_TRUE};

  PetscFunctionBegin;
  (void)ts;
  for (PetscInt f = 0; f < model->fields; f++) {
    at.shift[f] = shift;
    for (int mirror = 0; mirror < MIRRORS; mirror++)
      if (model->group[f] & 1 << mirror) at.shift[f] += self->factor_rate[mirror];
  }
  if (self->elimination)
    PetscCall(model->eliminate(self->rod, &at, self->elimination));
  else
    PetscCall(model->jacobian(self->rod, &at, P));
  self->fresh = at.fresh = at.iterates = PETSC_FALSE;
  self->linearised = at;
  if (J != P || self->elimination) {
    PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  }
  PetscFunctionReturn(0);
}

/* NewtonFollow - updates go to a part of the tolerance that the next step has. */
void NewtonFollow(Newton *newton, PetscReal rtol) {
  newton->tolerance = step_rule.newton_share * rtol;
}

/* The tolerance as given. What is below round-off of the whole of a vector is not asked for either
   (rod/sizes.c). */
static void SetTolerance(Newton *newton, PetscReal rtol) {
  const Rod rod = newton->rod;

  NewtonFollow(newton, rtol);
  newton->given = newton->tolerance;
  for (PetscInt k = 0; k < rod->rods; k++)
    rod->each[k]->finest = step_rule.update_round_off / newton->given;
}

/*
  NewtonSetUp - sets the equations of a TS and its SNES, before its options are read: full Newton
  steps, the test above, and a direct solver. PETSc's options override. newton must live as long as
  the TS; the caller ends it with NewtonDestroy().
*/
PetscErrorCode NewtonSetUp(TS ts, Rod rod, Newton *newton) {
  PetscReal rtol;
  SNES snes;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  newton->ts = ts;
  newton->rod = rod;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  SetTolerance(newton, rtol);
  PetscCall(TSSetIFunction(ts, NULL, Residual, newton));
  PetscCall(TSGetSNES(ts, &snes));
  PetscCall(SNESSetType(snes, rod->model->linear ? SNESKSPONLY : SNESNEWTONLS));
  PetscCall(SetSearch(snes, FULL_STEPS));
  PetscCall(SNESSetConvergenceTest(snes, Converged, newton, NULL));
  PetscCall(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 40, 1000000));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(
      ChainSetType(pc, rod->coupled ? ChainFolded(RodEndsOf(rod).tip_held) : MATORDERINGNATURAL));
  PetscFunctionReturn(0);
}

/* Is a matrix asked for? By any option of PETSc's that is about one, or about another way than full
   Newton steps, most of which multiply by it. */
static PetscErrorCode MatrixAsked(TS ts, PetscBool *wanted) {
  static const char *const about[] = {"ksp_",    "pc_",     "mat_",      "snes_test_",
                                      "snes_fd", "snes_mf", "snes_type", "snes_linesearch_"};
  const char *prefix;
  char start[80];

  PetscFunctionBegin;
  PetscCall(OptionsBegin("-chain_", wanted));
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(about) && !*wanted; k++) {
    (void)snprintf(start, sizeof(start), "-%s%s", prefix ? prefix : "", about[k]);
    PetscCall(OptionsBegin(start, wanted));
  }
  PetscFunctionReturn(0);
}

/* Can the equations of neighbours be eliminated as they are computed? Not if the rod's beginning is
   free, nor on several ranks if the tip is held. */
static PetscErrorCode HasChain(Rod rod, PetscBool *has) {
  const RodEnds ends = RodEndsOf(rod);
  PetscMPIInt ranks;
  PetscInt halves[2];

  PetscFunctionBegin;
  LearnedHalves(rod, halves);
  PetscCallMPI(MPI_Comm_size(rod->comm, &ranks));
  *has = (PetscBool)(rod->model->eliminate && EliminationCan(halves, ranks) && ends.clamped &&
                     (ranks == 1 || !ends.tip_held));
  PetscFunctionReturn(0);
}

/* Can modes be counted, though the matrix is assembled? Not of a rod whose beginning is free, nor
   of rods that hold each other. Springs are put for a hinge, and for what holds a tip that several
   ranks go from. */
static PetscErrorCode HasCount(Rod rod, PetscBool *has) {
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(rod->comm, &ranks));
  *has = (PetscBool)(rod->model->eliminate && EliminationCounts(rod->model->halves, ranks) &&
                     !RodEndsOf(rod).begins_free && !(rod->at && rod->coupled));
  PetscFunctionReturn(0);
}

/* J Y of Newton's direction Y, which is all that a line search asks for: Y was solved for, so it is
   the residual. */
static PetscErrorCode MultiplyDirection(Mat J, Vec Y, Vec JY) {
  Newton *newton;
  SNES snes;
  Vec F;

  PetscFunctionBegin;
  (void)Y;
  PetscCall(MatShellGetContext(J, &newton));
  PetscCall(TSGetSNES(newton->ts, &snes));
  PetscCall(SNESGetFunction(snes, &F, NULL, NULL));
  PetscCall(VecCopy(F, JY));
  PetscFunctionReturn(0);
}

/* What solves for the steps of Newton's method. */
static PetscErrorCode SolverOf(TS ts, KSP *ksp, PC *pc) {
  SNES snes;

  PetscFunctionBegin;
  PetscCall(TSGetSNES(ts, &snes));
  PetscCall(SNESGetKSP(snes, ksp));
  PetscCall(KSPGetPC(*ksp, pc));
  PetscFunctionReturn(0);
}

/* What eliminates the equations of one rod, or of several that do not see each other; counts: to
   count modes alone. */
static PetscErrorCode CreateElimination(Rod rod, PetscBool counts, Elimination *elimination) {
  PetscInt *nodes, halves[2];

  PetscFunctionBegin;
  LearnedHalves(rod, halves);
  if (!rod->at) {
    PetscCall(EliminationCreate(rod->comm, rod->end - rod->first,
                                counts ? rod->model->halves : halves, elimination));
    PetscFunctionReturn(0);
  }
  PetscCall(PetscMalloc1(rod->rods, &nodes));
  for (PetscInt k = 0; k < rod->rods; k++) nodes[k] = rod->at[k + 1] - rod->at[k];
  PetscCall(EliminationCreateSeveral(rod->rods, nodes, rod->model->halves, elimination));
  PetscCall(PetscFree(nodes));
  PetscFunctionReturn(0);
}

/* A matrix that is not there: its equations are eliminated as they are computed. Where friction
   feels the spin of a rod modes are counted in another one (rod/space_cells.h), and so they are
   where a tip is held at rest, whose last cell else had no friction at one end alone, and where
   growth feels force. */
static PetscErrorCode SetElimination(TS ts, Newton *newton) {
  Rod rod = newton->rod;
  PetscInt nodes = rod->end - rod->first, n = nodes * rod->model->fields;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscCall(CreateElimination(rod, PETSC_FALSE, &newton->elimination));
  PetscCall(MatCreateShell(rod->comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, newton, &newton->J));
  PetscCall(MatShellSetOperation(newton->J, MATOP_MULT, (void (*)(void))MultiplyDirection));
  PetscCall(SolverOf(ts, &ksp, &pc));
  if (rod->learned)
    PetscCall(LearnedSetType(pc, rod, newton->elimination));
  else
    PetscCall(EliminationSetType(pc, newton->elimination));
  if ((rod->model->space && RodFeelsSpin(rod)) || RodEndsOf(rod).tip_rests || LearnedExtra(rod))
    PetscCall(CreateElimination(rod, PETSC_TRUE, &newton->counter));
  PetscFunctionReturn(0);
}

/* The matrix of a rod on one rank that touches itself, or of several that feel each other, and its
   solver. */
static PetscErrorCode SetBlockLU(TS ts, Newton *newton) {
  const Rod rod = newton->rod;
  PetscInt *late, n;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(2 * rod->rods, &late));
  n = RodLate(rod, late);
  PetscCall(BlockLUCreate(rod->last + 1, rod->model->fields, n, late, &newton->J));
  PetscCall(PetscFree(late));
  PetscCall(SolverOf(ts, &ksp, &pc));
  PetscCall(BlockLUSetSolver(ksp));
  PetscFunctionReturn(0);
}

/*
  NewtonSetMatrix - gives the TS its Jacobian, once its options are read: where the model can, it is
  eliminated while it is computed (base/elimination.c); of a rod on one rank that touches itself its
  blocks are (base/blocklu.c). Else, or if an option is about a matrix or
  its solver, it is assembled, for PETSc's block LU in natural order on one rank (it is
  block-banded, its diagonal blocks regular), on several the same on each, joined (base/chain.c).
*/
PetscErrorCode NewtonSetMatrix(TS ts, Newton *newton) {
  Rod rod = newton->rod;
  PetscBool asked, has, counts;

  PetscFunctionBegin;
  PetscCall(MatrixAsked(ts, &asked));
  PetscCall(HasChain(rod, &has));
  PetscCall(HasCount(rod, &counts));
  if (has && !asked && !rod->coupled)
    PetscCall(SetElimination(ts, newton));
  else {
    if (rod->coupled && rod->alone && !asked && BlockLUCan(rod->last + 1, rod->model->fields))
      PetscCall(SetBlockLU(ts, newton));
    else
      PetscCall(RodCreateMatrix(rod, &newton->J));
    if (counts) PetscCall(CreateElimination(rod, PETSC_TRUE, &newton->counter));
  }
  PetscCall(TSSetIJacobian(ts, newton->J, newton->J, Jacobian, newton));
  PetscFunctionReturn(0);
}

/*
  NewtonDetermines - do the equations determine the unknowns in a state at rest at t = 0? Rods that
  hold each other in a ring may have forces that nothing tells: along rods that are straight, for
  these do not stretch. Of a rod whose matrix is one. A solution is then all but without bounds, or
  there is none.

  rate  of the friction that is felt
*/
PetscErrorCode NewtonDetermines(Newton *newton, Vec U, PetscReal rate, PetscBool *determined) {
  RodState at = {.U = U, .fresh = PETSC_TRUE};
  KSPConvergedReason reason;
  PetscReal size[2];
  PetscInt n;
  Vec b, x;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(U, &b));
  PetscCall(VecDuplicate(U, &x));
  PetscCall(VecDuplicate(U, &at.U_t));
  PetscCall(VecZeroEntries(at.U_t));
  PetscCall(VecGetSize(b, &n));
  for (PetscInt i = 0; i < n; i++)
    PetscCall(VecSetValue(b, i, PetscSinReal(i + 1.), INSERT_VALUES));
  PetscCall(VecAssemblyBegin(b));
  PetscCall(VecAssemblyEnd(b));
  for (PetscInt f = 0; f < newton->rod->model->fields; f++) at.shift[f] = rate;
  PetscCall(newton->rod->model->jacobian(newton->rod, &at, newton->J));
  PetscCall(SolverOf(newton->ts, &ksp, &pc));
  PetscCall(KSPSetOperators(ksp, newton->J, newton->J));
  PetscCall(KSPSolve(ksp, b, x));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCall(VecNorm(b, NORM_INFINITY, &size[0]));
  PetscCall(VecNorm(x, NORM_INFINITY, &size[1]));
  *determined = (PetscBool)(reason >= 0 && size[1] < step_rule.boundless * size[0]);
  PetscCall(VecDestroy(&b));
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&at.U_t));
  PetscFunctionReturn(0);
}

/* NewtonTakesFullSteps - or was another line search, or no search at all, asked for? */
PetscErrorCode NewtonTakesFullSteps(const Newton *newton, PetscBool *full) {
  SNESLineSearch search;
  SNES snes;

  PetscFunctionBegin;
  PetscCall(TSGetSNES(newton->ts, &snes));
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(PetscObjectTypeCompare((PetscObject)search, FULL_STEPS, full));
  *full = (PetscBool)(*full && !newton->rod->model->linear);
  PetscFunctionReturn(0);
}

/* NewtonCuts - from now on steps are cut where the residual does not fall, or are full again. */
PetscErrorCode NewtonCuts(const Newton *newton, PetscBool cuts) {
  SNES snes;

  PetscFunctionBegin;
  PetscCall(TSGetSNES(newton->ts, &snes));
  PetscCall(SetSearch(snes, cuts ? SNESLINESEARCHBT : FULL_STEPS));
  PetscFunctionReturn(0);
}

/* NewtonEliminate - eliminates the matrix of the latest Jacobian to count modes in it, where its
   state is now: its vectors are those that the iteration has gone on with. Collective. */
PetscErrorCode NewtonEliminate(Newton *newton, Elimination elimination) {
  RodState at = newton->linearised;

  PetscFunctionBegin;
  at.counts = PETSC_TRUE;
  PetscCall(newton->rod->model->eliminate(newton->rod, &at, elimination));
  PetscFunctionReturn(0);
}

/* What modes are counted in. */
static Elimination Counted(const Newton *newton) {
  return newton->counter ? newton->counter : newton->elimination;
}

/* NewtonCounts - can modes be counted at the latest Jacobian's state? Not where a rod in space
   sticks, for round-off beside what is so stiff. NewtonIndex() then does. Collective. */
PetscErrorCode NewtonCounts(Newton *newton, PetscBool *can) {
  const Elimination counted = Counted(newton);
  Rod rod = newton->rod;

  PetscFunctionBegin;
  *can = (PetscBool)(counted && (!newton->counter || newton->linearised.U) &&
                     !(EliminationWide(EliminationPart(counted, 0)) && RodSticks(rod)));
  if (*can && counted == newton->counter) PetscCall(NewtonEliminate(newton, counted));
  PetscFunctionReturn(0);
}

/*
  NewtonIndex - how many modes of one of its rods grow faster than the shift of the latest Jacobian,
  see EliminationIndex(); where that was assembled, of the rod without what far parts of it do to
  each other. Behind NewtonCounts(). Collective.

  known  could they be counted?
*/
PetscErrorCode NewtonIndex(const Newton *newton, PetscInt k, PetscInt *index, PetscBool *known) {
  const Elimination counted = EliminationPart(Counted(newton), k);

  PetscFunctionBegin;
  EliminationPlane(counted, newton->plane);
  PetscCall(EliminationIndex(counted, index));
  *known = (PetscBool)(*index >= (EliminationWide(counted) ? 0 : line_unknown / 2));
  PetscFunctionReturn(0);
}

/* NewtonOutOfPlane - how many modes out of the plane of x1 and x2 grow faster than this rate, of a
   rod in space that lies in it; 0 where they cannot be counted. Collective. */
PetscErrorCode NewtonOutOfPlane(Newton *newton, PetscReal rate, PetscInt *modes) {
  const Elimination counted = Counted(newton);
  const RodState linearised = newton->linearised;
  PetscInt index[2] = {0, 0};

  PetscFunctionBegin;
  *modes = 0;
  if (!counted || !linearised.U || RodSticks(newton->rod)) PetscFunctionReturn(0);
  for (PetscInt f = 0; f < newton->rod->model->fields; f++) newton->linearised.shift[f] = rate;
  PetscCall(NewtonEliminate(newton, counted));
  newton->linearised = linearised;
  for (int plane = 0; plane < 2; plane++) {
    EliminationPlane(counted, (PetscBool)plane);
    PetscCall(EliminationIndex(counted, &index[plane]));
  }
  if (index[0] >= 0 && index[1] >= 0) *modes = index[0] - index[1];
  PetscFunctionReturn(0);
}

PetscErrorCode NewtonDestroy(Newton *newton) {
  PetscFunctionBegin;
  PetscCall(MatDestroy(&newton->J));
  PetscCall(EliminationDestroy(&newton->elimination));
  PetscCall(EliminationDestroy(&newton->counter));
  PetscFunctionReturn(0);
}
