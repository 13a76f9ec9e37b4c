#include "stepping/leg.h"
#include "rod/ask.h"
#include "rod/learned.h"
#include "stepping/guard.h"
#include "stepping/vbdf.h"
#include "stepping/rules.h"
#include "rod/rules.h"

/* Angles bend where the front of what has learned since the start goes by, once for all: at the
   nodes that it passes on the way from the points of the formula to the end of the step differences
   tell nothing of errors, which are of places there, of the third order. */
static PetscErrorCode LeavePassed(const Leg *leg, const Rod rod, PetscInt begin, PetscScalar *a) {
  const PetscReal *s = RodLabels(rod);
  PetscReal times[VBDF_POINTS], t, step, from, to;
  PetscInt n, order;
  Vec points[VBDF_POINTS];

  PetscFunctionBegin;
  PetscCall(TSGetTime(leg->ts, &t));
  PetscCall(TSGetTimeStep(leg->ts, &step));
  PetscCall(VBDFGetHistory(leg->ts, &n, times, points, &order));
  RodPassed(rod, n ? t + times[n - 1] : t, t + step, &from, &to);
  for (PetscInt i = rod->first; i < rod->end; i++)
    for (PetscInt f = 0; f < rod->learned->lead && s[i] >= from && s[i] <= to; f++)
      if (!RodIsPlace(rod->model, f)) a[(begin + i - rod->first) * rod->model->fields + f] = -1;
  PetscFunctionReturn(0);
}

/* The tolerance of each entry: that part of rtol times the size of its field; -1 leaves out the
   fields that are not followed (forces and moments of an index-2 problem are not to control the
   step). */
static PetscErrorCode SetToleranceOf(Leg *leg, PetscInt k) {
  const Rod rod = leg->rod->each[k];
  const PetscInt fields = rod->model->fields;
  const PetscBool front = LearnedFront(rod); /* angles tell of what is learned there */
  PetscReal most[MAX_FIELDS];
  PetscInt begin, end;
  PetscScalar *a;

  PetscFunctionBegin;
  for (PetscInt f = 0; f < fields; f++) {
    const PetscReal least = rod_rule.vanished * RodFieldUnit(rod, f);
    most[f] =
        rod->model->followed[f] && !(front && !LearnedHasCorner(rod) && f >= rod->learned->mech)
            ? step_rule.step_share *
                  PetscMax(leg->ease.times * leg->of[k].eased * leg->rtol *
                               PetscMax(leg->of[k].size[f],
                                        step_rule.steering_floor * RodSteered(rod, f)),
                           least)
            : -1;
  }
  RodPartNodes(leg->rod, k, &begin, &end);
  PetscCall(VecGetArray(leg->tolerance, &a));
  for (PetscInt i = begin * fields; i < end * fields; i += fields)
    for (PetscInt f = 0; f < fields; f++) a[i + f] = most[f];
  if (rod->learned && LearnedHasCorner(rod)) PetscCall(LeavePassed(leg, rod, begin, a));
  PetscCall(VecRestoreArray(leg->tolerance, &a));
  if (!leg->held) PetscFunctionReturn(0);
  PetscCall(VecGetArray(leg->held, &a));
  for (PetscInt i = begin * fields; i < end * fields; i += fields)
    for (PetscInt f = 0; f < fields; f++) a[i + f] = RodIsPlace(rod->model, f) ? most[f] : -1;
  PetscCall(VecRestoreArray(leg->held, &a));
  PetscFunctionReturn(0);
}

static PetscErrorCode SetTolerance(Leg *leg) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < leg->rod->rods; k++) PetscCall(SetToleranceOf(leg, k));
  PetscFunctionReturn(0);
}

/* The sizes of one rod's fields as a step begins, and what places are no larger than round-off of
   walls. */
static PetscErrorCode SizesNow(Leg *leg, PetscInt k, PetscReal t, PetscReal least[MIRRORS]) {
  const Rod rod = leg->rod->each[k];
  LegMeasure *of = &leg->of[k];
  PetscReal blurred[MIRRORS];
  Vec U;

  PetscFunctionBegin;
  PetscCall(RodPartOpenRead(leg->rod, k, leg->U, &U));
  PetscCall(RodFeelWalls(rod, t, U));
  PetscCall(RodFieldScales(rod, U, leg->turns ? &of->axis : NULL, of->size));
  PetscCall(RodBlurred(rod, U, blurred));
  PetscCall(RodPartCloseRead(leg->rod, k, leg->U, &U));
  for (int d = 0; d < MIRRORS; d++) least[d] = PetscMax(least[d], blurred[d]);
  for (PetscInt f = 0; f < rod->model->fields; f++) {
    if (t >= of->onset_ends) of->onset[f] = 0;
    of->size[f] = PetscMax(of->size[f], of->onset[f]);
  }
  PetscFunctionReturn(0);
}

/* A step begins: sizes are those that the fields have now, or that the onset of a wall will give
 * them. */
static PetscErrorCode BeforeStep(TS ts) {
  PetscReal t, least[MIRRORS] = {0};
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  PetscCall(TSGetTime(ts, &t));
  for (PetscInt k = 0; k < leg->rod->rods; k++) PetscCall(SizesNow(leg, k, t, least));
  for (int d = 0; d < MIRRORS; d++)
    least[d] = PetscMax(least[d], rod_rule.vanished * RodUnits(leg->rod)->length);
  PetscCall(VBDFSetLeast(ts, least));
  PetscCall(SetTolerance(leg));
  PetscCall(
      TSSetTolerances(ts, PETSC_DEFAULT, leg->tolerance, leg->ease.times * leg->rtol, leg->none));
  if (!leg->ease.holds) NewtonFollow(&leg->newton, leg->ease.times * leg->rtol);
  PetscFunctionReturn(0);
}

static PetscErrorCode LookForKick(Leg *leg, PetscReal end, PetscInt k) {
  LegMeasure *of = &leg->of[k];
  PetscBool sets_in = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt f = 0; f < leg->rod->model->fields; f++) {
    if (!leg->rod->model->followed[f] || step_rule.wall_onset * of->tried[f] <= of->size[f])
      continue;
    of->onset[f] = of->size[f] = step_rule.wall_onset * of->tried[f];
    of->onset_ends = PetscMax(end, of->onset_ends);
    sets_in = PETSC_TRUE;
  }
  if (sets_in) PetscCall(SetToleranceOf(leg, k));
  PetscFunctionReturn(0);
}

/* A tip whose directors are held may be reached by any number of turns of a rod in space: which way
   round its cross-sections have turned must be known. */
static PetscBool MindsTurns(const Rod rod) {
  return (PetscBool)(rod->model->turned && RodEndsOf(rod).tip_points);
}

/* A VBDFOtherWay of a rod that can touch. A full Newton step that leaves a wall where there was
   none in sight ends deep in another, or in itself, and from there full ones go to and fro between
   sets of points in touch without end. (Not the usual way: where friction is all but dry, the
   residual of an iteration that goes well does not always fall.) */
static PetscErrorCode CutSteps(TS ts, PetscBool other) {
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  PetscCall(NewtonCuts(&leg->newton, other));
  PetscFunctionReturn(0);
}

/* Steps of fixed size, and PETSc's steppers, take no step back: with them contact is firm from the
   start. */
static PetscErrorCode FirmFromTheStart(TS ts, Rod rod) {
  PetscBool vbdf, fixed;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSVBDF, &vbdf));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &fixed));
  if (!vbdf || fixed) RodStaysFirm(rod);
  PetscFunctionReturn(0);
}

/* Has any rod that minds it turned too far? */
static PetscErrorCode TurnedTooFar(Leg *leg, Vec U0, Vec U1, PetscBool *turned) {
  const Rod all = leg->rod;
  Vec part[2];

  PetscFunctionBegin;
  *turned = PETSC_FALSE;
  for (PetscInt k = 0; k < all->rods && !*turned; k++) {
    if (!MindsTurns(all->each[k])) continue;
    PetscCall(RodPartOpenRead(all, k, U0, &part[0]));
    PetscCall(RodPartOpenRead(all, k, U1, &part[1]));
    PetscCall(all->each[k]->model->turned(all->each[k], part[0], part[1], turned));
    PetscCall(RodPartCloseRead(all, k, U1, &part[1]));
    PetscCall(RodPartCloseRead(all, k, U0, &part[0]));
  }
  PetscFunctionReturn(0);
}

/* How large one rod's fields are, along its axes, where a step has led; does it reach farther than
   it is long? */
static PetscErrorCode Reaches(Leg *leg, PetscInt k, PetscReal t, Vec U, PetscBool *too_far) {
  const Rod rod = leg->rod->each[k];
  LegMeasure *of = &leg->of[k];
  PetscReal length;
  Vec part;

  PetscFunctionBegin;
  PetscCall(RodPartOpenRead(leg->rod, k, U, &part));
  PetscCall(RodSizesAlong(rod, part, of->axis, of->tried));
  PetscCall(RodPartCloseRead(leg->rod, k, U, &part));
  PetscCall(RodLength(rod, t, &length));
  *too_far = (PetscBool) !(RodEndsOf(rod).begins_free || RodEndsOf(rod).carried ||
                           RodReach(rod->model, of->tried) <= step_rule.reach_slack * length);
  PetscFunctionReturn(0);
}

/* A VBDFCheck of a rod that can touch: it has passed through what it cannot, or reaches farther
   than it is long, which Newton's method calls a solution where forces are without measure, or is
   so deep in a wall that this is to be firmer; and does a wall set in? */
static PetscErrorCode AfterTry(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1,
                               PetscBool *impossible) {
  PetscInt step;
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  *impossible = PETSC_FALSE;
  for (PetscInt k = 0; k < leg->rod->rods && !*impossible; k++)
    PetscCall(Reaches(leg, k, t1, U1, impossible));
  PetscCall(TSGetStepNumber(ts, &step));
  leg->passed = (PetscBool)(leg->passed && step == leg->tried);
  leg->tried = step;
  leg->passes = PETSC_FALSE;
  if (!*impossible) PetscCall(TurnedTooFar(leg, U0, U1, impossible));
  if (!*impossible) PetscCall(RodGetsFirm(leg->rod, impossible));
  if (*impossible) PetscFunctionReturn(0);
  PetscCall(GuardPasses(ts, t0, t1, U0, U1, impossible));
  leg->passed = (PetscBool)(leg->passed || leg->passes);
  for (PetscInt k = 0; k < leg->rod->rods; k++) PetscCall(LookForKick(leg, t1, k));
  PetscFunctionReturn(0);
}

/* A VBDFCheck of a rod that minds turns, and cannot touch. */
static PetscErrorCode AfterTurn(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1,
                                PetscBool *impossible) {
  Leg *leg;

  PetscFunctionBegin;
  (void)t0;
  (void)t1;
  PetscCall(TSGetApplicationContext(ts, &leg));
  PetscCall(TurnedTooFar(leg, U0, U1, impossible));
  PetscFunctionReturn(0);
}

/* A VBDFMeasure: an error is measured along the axes that the step's sizes are of. */
static PetscErrorCode TurnError(TS ts, Vec error) {
  Vec part;
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  for (PetscInt k = 0; k < leg->rod->rods; k++) {
    PetscCall(RodPartOpen(leg->rod, k, error, &part));
    PetscCall(RodTurn(leg->rod->each[k], leg->of[k].axis, part));
    PetscCall(RodPartClose(leg->rod, k, error, &part));
  }
  PetscFunctionReturn(0);
}

/* A VBDFCarry of what the material has learned. */
static PetscErrorCode CarryLearned(TS ts, PetscReal t, PetscInt m, const PetscReal times[],
                                   const Vec points[], PetscReal weight[][VBDF_FIELDS], Vec sum) {
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  PetscCall(LearnedKeepWay(leg->rod, m, times, points));
  PetscCall(LearnedCarry(leg->rod, t, m, times, points, weight, PETSC_TRUE, sum));
  PetscFunctionReturn(0);
}

/* Only vbdf can, whose formula is one along the material. */
static PetscErrorCode CarryAlong(TS ts, const Rod rod) {
  PetscBool vbdf;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSVBDF, &vbdf));
  UserCheck(vbdf, OptionsComm(),
            "-ts_type: where material slides past the labels (feed, apical), what it learns by "
            "-tropism_ options takes vbdf");
  PetscCall(VBDFSetCarry(ts, CarryLearned, LearnedHasCorner(rod)));
  PetscFunctionReturn(0);
}

/* Errors of fields across are measured along axes of their own, if the stepper can. */
static PetscErrorCode MeasureAlongAxes(Leg *leg) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < leg->rod->rods; k++) leg->of[k].axis.x = 1;
  PetscCall(PetscObjectTypeCompare((PetscObject)leg->ts, TSVBDF, &leg->turns));
  if (!leg->rod->model->pairs) leg->turns = PETSC_FALSE;
  if (leg->turns) PetscCall(VBDFSetMeasure(leg->ts, TurnError));
  PetscFunctionReturn(0);
}

/* A Newton solve begins: the friction duals start again, the Jacobian learns of the factor. */
static PetscErrorCode BeforeStage(TS ts, PetscReal t) {
  Leg *leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  leg->newton.fresh = PETSC_TRUE;
  PetscCall(VBDFGetFactorRate(ts, leg->newton.factor_rate));
  PetscFunctionReturn(0);
}

/* LegSpeed() of one rod. */
static PetscErrorCode SpeedOf(Rod rod, Vec U_t, PetscReal *speed, PetscBool *begins) {
  const PetscReal before = RodFalls(rod);
  PetscReal rate[MAX_FIELDS], fastest;
  PetscBool falls;

  PetscFunctionBegin;
  PetscCall(RodFieldSizes(rod, U_t, rate));
  fastest = RodReach(rod->model, rate);
  *speed = fastest / RodUnits(rod)->speed;
  falls = (PetscBool)(RodIsDry(rod) &&
                      *speed > (before > 0 ? step_rule.snapped_at : step_rule.snaps_at));
  *begins = (PetscBool)(falls && before == 0);
  if (falls || before > 0) RodAtSpeed(rod, falls ? fastest : 0);
  PetscFunctionReturn(0);
}

/*
  LegSpeed - the speed of the fastest place behind an accepted step, over that at which the rod
  grows. While it snaps its friction is rounded off (SceneAtSpeed()). Collective.

  begins  a snap, with this step
*/
PetscErrorCode LegSpeed(Leg *leg, PetscReal *speed, PetscBool *begins) {
  PetscBool snaps = PETSC_FALSE;
  PetscReal one = 0;
  Vec U_t;

  PetscFunctionBegin;
  *speed = 0;
  *begins = PETSC_FALSE;
  for (PetscInt k = 0; k < leg->rod->rods; k++) {
    PetscCall(RodPartOpenRead(leg->rod, k, leg->newton.latest.U_t, &U_t));
    PetscCall(SpeedOf(leg->rod->each[k], U_t, &one, &snaps));
    PetscCall(RodPartCloseRead(leg->rod, k, leg->newton.latest.U_t, &U_t));
    *speed = PetscMax(*speed, one);
    if (snaps) *begins = PETSC_TRUE;
  }
  PetscFunctionReturn(0);
}

/* The first step has one point to start from: let the rod grow without friction. */
static PetscErrorCode GuessOf(Rod rod, PetscReal t0, PetscReal t1, Vec U0, Vec U1) {
  Node *nodes;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(rod->end - rod->first, &nodes));
  PetscCall(rod->model->get(rod, t0, U0, NULL, nodes));
  PetscCall(RodGrowNodes(rod, t0, t1, nodes));
  PetscCall(rod->model->set(rod, t1, nodes, U1));
  PetscCall(PetscFree(nodes));
  PetscFunctionReturn(0);
}

static PetscErrorCode FirstGuess(TS ts, PetscReal t0, PetscReal t1, Vec U0, Vec U1, void *ctx) {
  const Rod all = (Rod)ctx;
  Vec from, to;

  PetscFunctionBegin;
  (void)ts;
  for (PetscInt k = 0; k < all->rods; k++) {
    PetscCall(RodPartOpenRead(all, k, U0, &from));
    PetscCall(RodPartOpen(all, k, U1, &to));
    PetscCall(GuessOf(all->each[k], t0, t1, from, to));
    PetscCall(RodPartClose(all, k, U1, &to));
    PetscCall(RodPartCloseRead(all, k, U0, &from));
  }
  PetscFunctionReturn(0);
}

/* PETSc's theta methods start Newton's iteration from the step before, a rod at rest, where
   friction is stiffest: let them extrapolate, which only an option can tell them. */
static PetscErrorCode ExtrapolateTheta(void) {
  const char *const option = "-ts_theta_initial_guess_extrapolate";
  char type[32] = "";
  PetscBool given, theta = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-ts_type", type, sizeof(type), NULL));
  PetscCall(PetscStrInList(type, "beuler,theta,cn", ',', &theta));
  PetscCall(PetscOptionsHasName(NULL, NULL, option, &given));
  if (theta && !given) PetscCall(PetscOptionsSetValue(NULL, option, "true"));
  PetscFunctionReturn(0);
}

/* The rates observed are those of the latest residual. A linear solve ends without one at what it
   has found; vbdf knows its rates all the same, PETSc's steppers do not: there Newton's method
   looks once more. */
static PetscErrorCode LookAgain(Leg *leg) {
  PetscBool vbdf;
  SNES snes;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)leg->ts, TSVBDF, &vbdf));
  if (vbdf || !leg->rod->model->linear) PetscFunctionReturn(0);
  PetscCall(TSGetSNES(leg->ts, &snes));
  PetscCall(SNESSetType(snes, SNESNEWTONLS));
  PetscFunctionReturn(0);
}

/* vbdf has a control of its own: what PETSc's controls take besides is refused. */
static PetscErrorCode RefuseAdapt(TS ts) {
  static const char *const ignored[] = {"dt_min",
                                        "safety",
                                        "reject_safety",
                                        "clip",
                                        "scale_solve_failed",
                                        "always_accept",
                                        "max_ignore",
                                        "time_step_increase_delay",
                                        "glee_use_local",
                                        "dsp_filter",
                                        "dsp_pid",
                                        "monitor"};
  char name[64], type[32] = "basic";
  PetscBool vbdf, given, known;
  MPI_Comm comm = PetscObjectComm((PetscObject)ts);

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSVBDF, &vbdf));
  if (!vbdf) PetscFunctionReturn(0);
  PetscCall(PetscOptionsGetString(NULL, NULL, "-ts_adapt_type", type, sizeof(type), NULL));
  PetscCall(PetscStrInList(type, "basic,none", ',', &known));
  UserCheck(
      known, comm,
      "-ts_adapt_type %s: vbdf chooses its steps itself (basic) or has them fixed (none); take "
      "one of them, or -ts_type bdf",
      type);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(ignored); k++) {
    (void)snprintf(name, sizeof(name), "-ts_adapt_%s", ignored[k]);
    PetscCall(PetscOptionsHasName(NULL, NULL, name, &given));
    UserCheck(!given, comm,
              "%s: vbdf chooses its steps without it; take it out (-ts_rtol, -ts_dt and "
              "-ts_adapt_dt_max act on them), or take -ts_type bdf",
              name);
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode SetFirstStep(Leg *leg) {
  const SceneUnits *units = RodUnits(leg->rod);
  PetscReal first = step_rule.first_of_unit * units->time,
            own =
                (units->straight ? step_rule.first_straight : step_rule.first_of_own) * units->own;

  PetscFunctionBegin;
  if (RodIsDry(leg->rod))
    PetscCall(VBDFSetAgain(leg->ts, units->own, PetscMin(first, own), units->unheld));
  else
    first = PetscMin(first, PetscMax(own, step_rule.first_of_brief * units->brief));
  PetscCall(TSSetTimeStep(leg->ts, first));
  PetscFunctionReturn(0);
}

/* The stepper's options, by the names that PETSc has for them. */
static PetscErrorCode TakeOptions(TS ts) {
  PetscFunctionBegin;
  if (PETSC_VERSION_GE(3, 25, 0)) PetscCall(OptionsRename(PETSC_TRUE));
  PetscCall(TSSetFromOptions(ts));
  if (PETSC_VERSION_GE(3, 25, 0)) PetscCall(OptionsRename(PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* No friction holds a rod in space from turning about its own tangent if it has no radius at which
   it feels that, nor does it hold what of such a turn lies within a cell: in dry friction, where
   nothing else takes time, such turns may jump. */
static PetscErrorCode FreeTurns(Leg *leg) {
  PetscFunctionBegin;
  if (!leg->rod->model->space || !RodIsDry(leg->rod)) PetscFunctionReturn(0);
  PetscCall(VecDuplicate(leg->U, &leg->held));
  PetscCall(VBDFSetHeld(leg->ts, leg->held, (PetscBool)!RodFeelsSpin(leg->rod)));
  PetscFunctionReturn(0);
}

/*
  LegCreate - a model of a scene with its stepper, ready for TSSolve() once U is set. Collective;
  the caller destroys it with LegDestroy().

  rtol    tolerance of a step, per field

  The caller sets what is done after a step, and the end if it is not the scene's.
*/
PetscErrorCode LegCreate(Scene scene, const RodModel *model, PetscReal rtol, Leg *leg) {
  PetscFunctionBegin;
  PetscCall(PetscMemzero(leg, sizeof(*leg)));
  PetscCall(RodCreate(scene, model, &leg->rod));
  PetscCall(RodFindUnits(leg->rod));
  PetscCall(LegCreateOf(leg->rod, rtol, leg));
  PetscFunctionReturn(0);
}

/* LegCreateOf - as LegCreate(), of a rod, or several, with units; it is the leg's from now on. */
PetscErrorCode LegCreateOf(Rod rod, PetscReal rtol, Leg *leg) {
  const PetscBool touches = RodTouches(rod);
  PetscBool fixed, given, full;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(leg, sizeof(*leg)));
  leg->rod = rod;
  leg->rtol = rtol;
  leg->ease.most = leg->ease.wants = leg->ease.times = 1;
  leg->ease.holds = (PetscBool)(RodIsDry(rod) && RodRubsOnWalls(rod));
  PetscCall(PetscCalloc1(rod->rods, &leg->of));
  for (PetscInt k = 0; k < rod->rods; k++) leg->of[k].eased = 1;
  PetscCall(DMCreateGlobalVector(leg->rod->da, &leg->U));
  PetscCall(VecDuplicate(leg->U, &leg->tolerance));
  PetscCall(VecDuplicate(leg->U, &leg->none));
  PetscCall(TSCreate(leg->rod->comm, &leg->ts));
  PetscCall(TSSetDM(leg->ts, leg->rod->da));
  PetscCall(TSSetApplicationContext(leg->ts, leg));
  PetscCall(TSSetEquationType(leg->ts, TS_EQ_DAE_IMPLICIT_INDEX2));
  PetscCall(TSSetType(leg->ts, TSVBDF));
  PetscCall(VBDFSetHighestOrder(leg->ts, step_rule.highest_order));
  PetscCall(TSSetTolerances(leg->ts, PETSC_DEFAULT, NULL, rtol, NULL));
  PetscCall(TSSetMaxTime(leg->ts, RodEndTime(leg->rod)));
  PetscCall(TSSetMaxSteps(leg->ts, PETSC_MAX_INT));
  PetscCall(TSSetExactFinalTime(leg->ts, TS_EXACTFINALTIME_MATCHSTEP));
  PetscCall(SetFirstStep(leg));
  PetscCall(TSSetMaxSNESFailures(leg->ts, -1));
  PetscCall(TSSetMaxStepRejections(leg->ts, 50));
  PetscCall(TSSetErrorIfStepFails(leg->ts, PETSC_FALSE));
  PetscCall(TSSetPreStep(leg->ts, BeforeStep));
  PetscCall(TSSetPreStage(leg->ts, BeforeStage));
  PetscCall(NewtonSetUp(leg->ts, leg->rod, &leg->newton));
  PetscCall(ExtrapolateTheta());
  PetscCall(TakeOptions(leg->ts));
  PetscCall(RefuseAdapt(leg->ts));
  PetscCall(NewtonSetMatrix(leg->ts, &leg->newton));
  PetscCall(LookAgain(leg));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)leg->ts, &fixed, TSBEULER, TSTHETA, TSCN, ""));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-ts_dt", &given));
  if (fixed && !given) PetscCall(TSSetTimeStep(leg->ts, 0.01)); /* the paper's */
  PetscCall(PetscOptionsHasName(NULL, NULL, "-ts_max_snes_failures", &given));
  if (fixed && !given)
    PetscCall(TSSetMaxSNESFailures(leg->ts, 10)); /* a fixed step does not help itself */
  PetscCall(VBDFSetScale(leg->ts, RodUnits(leg->rod)->brief));
  PetscCall(VBDFSetResolves(leg->ts, (PetscBool)(RodIsDry(leg->rod) || !touches)));
  PetscCall(FreeTurns(leg));
  PetscCall(VBDFSetFactored(leg->ts, leg->rod->model->fields, leg->rod->model->group));
  if (LearnedCarries(leg->rod)) PetscCall(CarryAlong(leg->ts, leg->rod));
  PetscCall(MeasureAlongAxes(leg));
  PetscCall(VBDFSetGuess(leg->ts, FirstGuess, leg->rod));
  PetscCall(VBDFSetCross(leg->ts, LegCrossesMode));
  PetscCall(NewtonTakesFullSteps(&leg->newton, &full));
  if (touches && full) PetscCall(VBDFSetOtherWay(leg->ts, CutSteps));
  if (RodMayGetFirm(leg->rod)) PetscCall(FirmFromTheStart(leg->ts, leg->rod));
  if (touches)
    PetscCall(VBDFSetCheck(leg->ts, AfterTry));
  else if (MindsTurns(leg->rod))
    PetscCall(VBDFSetCheck(leg->ts, AfterTurn));
  PetscCall(TSSetSolution(leg->ts, leg->U));
  PetscFunctionReturn(0);
}

static PetscReal NextTurn(TS ts, PetscReal t) {
  Leg *leg = NULL;

  if (TSGetApplicationContext(ts, &leg)) return PETSC_MAX_REAL;
  return RodNextTurn(leg->rod, t);
}

static PetscBool Kinks(TS ts, PetscReal t) {
  PetscReal near = 1e-12; /* as steps end there */
  Leg *leg = NULL;

  if (TSGetApplicationContext(ts, &leg)) return PETSC_FALSE;
  near *= RodEndTime(leg->rod);
  return RodJerks(leg->rod, t - near, t + near);
}

/* LegEndAtTurns - lets steps end where what tables give in time sets out, stops or turns back: a
   rod that rests, or does not feel it yet, lets steps be long, and one might leave out that it came
   and went. */
PetscErrorCode LegEndAtTurns(Leg *leg) {
  PetscFunctionBegin;
  if (RodNextTurn(leg->rod, 0) < PETSC_MAX_REAL) PetscCall(VBDFSetNextEnd(leg->ts, NextTurn));
  if (RodMayJerk(leg->rod)) PetscCall(VBDFSetKinks(leg->ts, Kinks));
  PetscFunctionReturn(0);
}

PetscErrorCode LegDestroy(Leg *leg) {
  PetscFunctionBegin;
  PetscCall(TSDestroy(&leg->ts));
  PetscCall(NewtonDestroy(&leg->newton));
  PetscCall(VecDestroy(&leg->U));
  PetscCall(VecDestroy(&leg->tolerance));
  PetscCall(VecDestroy(&leg->held));
  PetscCall(VecDestroy(&leg->none));
  PetscCall(PetscFree(leg->of));
  PetscCall(RodDestroy(&leg->rod));
  PetscFunctionReturn(0);
}
