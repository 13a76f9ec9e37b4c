/* The TS type: what PETSc and the rest of the program see of the formula and of the controller. */
#include "stepping/vbdf.h"
#include "stepping/controller.h"
#include "base/compat.h"
#include <petsc/private/tsimpl.h> /* a TS type cannot do without */

typedef struct {
  Formula formula;
  Controller controller;
} VBDF;

static PetscErrorCode Self(TS ts, VBDF **self) {
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSVBDF, &same));
  *self = same ? (VBDF *)ts->data : NULL;
  PetscFunctionReturn(0);
}

static PetscErrorCode TSStep_VBDF(TS ts) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  PetscCall(ControllerStep(ts, &self->controller, &self->formula));
  PetscFunctionReturn(0);
}

/* A time of the run as the history counts. */
static PetscReal Since(TS ts, const VBDF *self, PetscReal t) {
  const Formula *f = &self->formula;

  return t - ts->ptime - self->controller.late + (f->done ? f->time[0] : 0);
}

static PetscErrorCode TSInterpolate_VBDF(TS ts, PetscReal t, Vec X) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  PetscCall(
      FormulaInterpolate(&self->formula, self->controller.order, Since(ts, self, t), X, NULL));
  PetscFunctionReturn(0);
}

/* VBDFInterpolate - the state and its rate at a time within the latest step, by the dense output;
   done is false if the type is another one. Collective. */
PetscErrorCode VBDFInterpolate(TS ts, PetscReal t, Vec U, Vec U_t, PetscBool *done) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  *done = (PetscBool)(self != NULL);
  if (!self) PetscFunctionReturn(0);
  PetscCall(FormulaInterpolate(&self->formula, self->controller.order, Since(ts, self, t), U, U_t));
  PetscFunctionReturn(0);
}

static PetscErrorCode SNESTSFormFunction_VBDF(SNES snes, Vec U, Vec F, TS ts) {
  Formula *f = &((VBDF *)ts->data)->formula;

  PetscFunctionBegin;
  PetscCall(FormulaRate(f, U));
  PetscCall(TSComputeIFunction(ts, f->now, U, f->rate, F, PETSC_FALSE));
  PetscFunctionReturn(0);
}

static PetscErrorCode SNESTSFormJacobian_VBDF(SNES snes, Vec U, Mat J, Mat P, TS ts) {
  const Formula *f = &((VBDF *)ts->data)->formula;

  PetscFunctionBegin;
  /* rate holds U_t of the latest residual, which SNES evaluated at this U */
  PetscCall(TSComputeIJacobian(ts, f->now, U, f->rate, f->shift, J, P, PETSC_FALSE));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSReset_VBDF(TS ts) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  PetscCall(FormulaReset(&self->formula));
  PetscCall(VecDestroy(&self->controller.work));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSDestroy_VBDF(TS ts) {
  PetscFunctionBegin;
  PetscCall(TSReset_VBDF(ts));
  PetscCall(PetscFree(ts->data));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSSetUp_VBDF(TS ts) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  PetscCall(FormulaSetUp(&self->formula, ts->vec_sol));
  if (!self->controller.work) PetscCall(VecDuplicate(ts->vec_sol, &self->controller.work));
  PetscCall(TSGetAdapt(ts, &ts->adapt));
  PetscCall(TSGetSNES(ts, &ts->snes));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSSetFromOptions_VBDF(TS ts, OptionItems PetscOptionsObject) {
  VBDF *self = (VBDF *)ts->data;

  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "variable-order BDF");
  PetscCall(PetscOptionsRangeInt("-ts_bdf_order", "highest order, 1 to 6", "",
                                 self->controller.most, &self->controller.most, NULL, 1, 6));
  PetscCall(PetscOptionsRangeInt("-ts_bdf_factor",
                                 "degree of the logarithm of the factor taken "
                                 "out of fields that decay and grow, 0 (none) to 3",
                                 "", self->formula.degree, &self->formula.degree, NULL, 0, 3));
  PetscOptionsHeadEnd();
  PetscFunctionReturn(0);
}

static PetscErrorCode TSView_VBDF(TS ts, PetscViewer viewer) {
  VBDF *self = (VBDF *)ts->data;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (!ascii) PetscFunctionReturn(0);
  PetscCall(PetscViewerASCIIPrintf(viewer, "  highest order: %d\n", (int)self->controller.most));
  if (self->formula.fields)
    PetscCall(PetscViewerASCIIPrintf(
        viewer, "  taken out of fields: a factor, its logarithm of degree %d\n",
        (int)self->formula.degree));
  PetscFunctionReturn(0);
}

static PetscErrorCode TSCreate_VBDF(TS ts) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  self->controller.most = 5;
  self->formula.degree = 2;
  self->controller.order = 1;
  ts->data = self;
  ts->ops->reset = TSReset_VBDF;
  ts->ops->destroy = TSDestroy_VBDF;
  ts->ops->setup = TSSetUp_VBDF;
  ts->ops->view = TSView_VBDF;
  ts->ops->setfromoptions = TSSetFromOptions_VBDF;
  ts->ops->step = TSStep_VBDF;
  ts->ops->interpolate = TSInterpolate_VBDF;
  ts->ops->snesfunction = SNESTSFormFunction_VBDF;
  ts->ops->snesjacobian = SNESTSFormJacobian_VBDF;
  ts->default_adapt_type = TSADAPTBASIC;
  ts->usessnes = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* VBDFRegister - makes the type known; call once, before TSSetType(). */
PetscErrorCode VBDFRegister(void) {
  PetscFunctionBegin;
  PetscCall(TSRegister(TSVBDF, TSCreate_VBDF));
  PetscFunctionReturn(0);
}

/* VBDFSetGuess - sets how to guess the first step, from one point. No effect on other types. */
PetscErrorCode VBDFSetGuess(TS ts, VBDFGuess guess, void *ctx) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) {
    self->controller.guess = guess;
    self->controller.guess_ctx = ctx;
  }
  PetscFunctionReturn(0);
}

/* VBDFSetHighestOrder - 1 to 6; 5 if not called. The formula of order 6 is stable for rates close
   to the real axis only. -ts_bdf_order overrides it. No effect on other types. */
PetscErrorCode VBDFSetHighestOrder(TS ts, PetscInt order) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->controller.most = order;
  PetscFunctionReturn(0);
}

/* VBDFSetOtherWay - sets how a step is solved that could not be solved. No effect on other types.
 */
PetscErrorCode VBDFSetOtherWay(TS ts, VBDFOtherWay other_way) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->controller.other_way = other_way;
  PetscFunctionReturn(0);
}

/* VBDFSetResolves - says that every motion has a finite velocity, which steps are to see: an error
   that does not fall with the step is no jump. No effect on other types. */
PetscErrorCode VBDFSetResolves(TS ts, PetscBool resolves) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->controller.resolves = resolves;
  PetscFunctionReturn(0);
}

/* VBDFSetScale - sets the time that something takes in what is followed: a step that is a tiny part
   of it is all but none. Without it that is the end of the run, which may be far behind. No effect
   on other types. */
PetscErrorCode VBDFSetScale(TS ts, PetscReal scale) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->controller.scale = scale;
  PetscFunctionReturn(0);
}

/* VBDFSetAgain - for what takes a time of its own that may be far less than the scale: the size in
   which a first step is tried again that has no solution, or an error that does not fall with its
   size; unheld: nothing holds a part of it, which may jump. No effect on other types. */
PetscErrorCode VBDFSetAgain(TS ts, PetscReal own, PetscReal again, PetscBool unheld) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  self->controller.own = own;
  self->controller.again = again;
  self->controller.unheld = unheld;
  PetscFunctionReturn(0);
}

/* VBDFSetHeld - sets the tolerances of what something holds back, where that is not all there is:
   the rest may jump; free: nothing at all holds that. Borrowed; as long as the TS. No effect on
   other types. */
PetscErrorCode VBDFSetHeld(TS ts, Vec held, PetscBool free) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  self->controller.held = held;
  self->controller.free = free;
  PetscFunctionReturn(0);
}

/* VBDFSetCheck - sets what a step must not do. No effect on other types. */
PetscErrorCode VBDFSetCheck(TS ts, VBDFCheck check) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->controller.check = check;
  PetscFunctionReturn(0);
}

/* VBDFSetCross - sets how to see that a step crosses a mode that grows: it is cut until it does
   not. No effect on other types. */
PetscErrorCode VBDFSetCross(TS ts, VBDFCross cross) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->controller.cross = cross;
  PetscFunctionReturn(0);
}

/* VBDFSetNextEnd - sets when steps have to end; steps of fixed size do not. No effect on other
   types. */
PetscErrorCode VBDFSetNextEnd(TS ts, VBDFNextEnd next_end) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->controller.next_end = next_end;
  PetscFunctionReturn(0);
}

/* VBDFSetKinks - sets how to see that a time, at which a step has ended, is one of a kink: the
   history starts again there. No effect on other types. */
PetscErrorCode VBDFSetKinks(TS ts, VBDFKinks kinks) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->controller.kinks = kinks;
  PetscFunctionReturn(0);
}

/* VBDFSetCarry - sets how fields of the material go along with it; all: where they are
   extrapolated, too. No effect on other types. */
PetscErrorCode VBDFSetCarry(TS ts, VBDFCarry carry, PetscBool all) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  self->formula.carry = carry;
  self->formula.carries_all = all;
  self->formula.ts = ts;
  PetscFunctionReturn(0);
}

/* VBDFSetMeasure - sets how errors are turned before they are held against the tolerances. No
   effect on other types. */
PetscErrorCode VBDFSetMeasure(TS ts, VBDFMeasure measure) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) self->controller.measure = measure;
  PetscFunctionReturn(0);
}

/*
  VBDFSetFactored - says which fields are about one shape times a factor that falls or rises by many
  orders of magnitude, and may vanish: their factor is taken out of the steps. Before
  VBDFSetHistory(). No effect on other types.

  fields    unknowns of a node, at most VBDF_FIELDS; vectors hold node after node
  factored  of each: 0, or bit k for factor k, which is that of the first field that has it alone; a
            field that has several is factored by their product

  U_t then depends on U by shift + VBDFGetFactorRate() in these fields, for the Jacobian.
*/
PetscErrorCode VBDFSetFactored(TS ts, PetscInt fields, const int factored[]) {
  PetscBool any = PETSC_FALSE;
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  for (PetscInt f = 0; f < fields; f++) any = (PetscBool)(any || factored[f]);
  PetscCheck(fields <= VBDF_FIELDS, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "%d fields, at most %d", (int)fields, VBDF_FIELDS);
  self->formula.fields = any ? fields : 0;
  PetscCall(PetscArraycpy(self->formula.factored, factored, fields));
  PetscFunctionReturn(0);
}

/* VBDFSetLeast - says below which size of its first field, in the step that begins, no factor is
   taken: what it would be of is round-off. No effect on other types. */
PetscErrorCode VBDFSetLeast(TS ts, const PetscReal least[VBDF_FACTORS]) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (self) PetscCall(PetscArraycpy(self->formula.least, least, VBDF_FACTORS));
  PetscFunctionReturn(0);
}

/* VBDFGetFactorRate - rho of the present step: what the fields of each factor have in dU_t/dU
   beside the shift; 0 if the type is another one. */
PetscErrorCode VBDFGetFactorRate(TS ts, PetscReal rate[VBDF_FACTORS]) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  for (int k = 0; k < VBDF_FACTORS; k++) rate[k] = self ? self->formula.rho[k] : 0;
  PetscFunctionReturn(0);
}

/*
  VBDFGetHistory - the points that the next step starts from, latest first, after an accepted step,
  after one that ended the run, or after VBDFSetHistory().

  n       how many, at most VBDF_POINTS; 0 on exit if the type is another one
  times   since the latest of them: 0, and what is negative
  points  borrowed
  order   the order chosen for the next step
*/
PetscErrorCode VBDFGetHistory(TS ts, PetscInt *n, PetscReal times[], Vec points[],
                              PetscInt *order) {
  const Formula *f;
  VBDF *self = NULL;
  PetscInt first;

  PetscFunctionBegin;
  *n = 0;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  f = &self->formula;
  /* a history that was handed over has no new point yet, nor has one whose last step failed */
  first = f->given || (f->n > 0 && !f->done) ? 1 : 0;
  *n = PetscMin(f->n + 1 - first, VBDF_POINTS - 1);
  *order = self->controller.order;
  for (PetscInt i = 0; i < *n; i++) {
    times[i] = f->time[first + i] - f->time[first];
    points[i] = f->point[first + i];
  }
  PetscFunctionReturn(0);
}

/* VBDFSetHistory - hands over n points, latest first (copied), to a TS that has its solution set,
   and its time: theirs count from it. No effect on other types, which then start afresh. */
PetscErrorCode VBDFSetHistory(TS ts, PetscInt n, const PetscReal times[], const Vec points[],
                              PetscInt order) {
  VBDF *self = NULL;
  Formula *f;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  PetscCall(TSSetUp_VBDF(ts));
  f = &self->formula;
  for (PetscInt i = 0; i < n; i++) {
    f->time[i + 1] = times[i] - times[0];
    PetscCall(VecCopy(points[i], f->point[i + 1]));
    PetscCall(FormulaMeasureSize(f, i + 1));
  }
  f->n = n;
  f->given = PETSC_TRUE;
  f->done = PETSC_FALSE;
  self->controller.late = 0;
  self->controller.order = order;
  self->controller.since = 0;
  PetscFunctionReturn(0);
}

/* VBDFBeginAnew - the next step starts from the latest point alone, also of a history that was
   handed over. (Other types: as TSRestartStep().) */
PetscErrorCode VBDFBeginAnew(TS ts) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(TSRestartStep(ts));
  PetscCall(Self(ts, &self));
  if (self && self->formula.given) self->formula.n = 1;
  PetscFunctionReturn(0);
}

/* VBDFGetMemory - what the stepper remembers besides its history; zeros if the type is another one.
 */
PetscErrorCode VBDFGetMemory(TS ts, PetscReal memory[VBDF_MEMORY]) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  memory[0] = self ? (PetscReal)self->controller.since : 0;
  memory[1] = self ? self->controller.layer : 0;
  memory[2] = self ? self->controller.late : 0;
  memory[3] = self ? (PetscReal)self->controller.plain_next : 0;
  PetscFunctionReturn(0);
}

/* VBDFSetMemory - gives it back, after VBDFSetHistory(): the stepper goes on as if it had not
   stopped. */
PetscErrorCode VBDFSetMemory(TS ts, const PetscReal memory[VBDF_MEMORY]) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  if (!self) PetscFunctionReturn(0);
  self->controller.since = (PetscInt)memory[0];
  self->controller.layer = memory[1];
  self->controller.late = memory[2];
  self->controller.plain_next = (PetscBool)(memory[3] != 0);
  PetscFunctionReturn(0);
}

/* VBDFGetJumps - how many steps were jumps, so far; 0 if the type is another one. */
PetscErrorCode VBDFGetJumps(TS ts, PetscInt *jumps) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  *jumps = self ? self->controller.jumps : 0;
  PetscFunctionReturn(0);
}

/* VBDFGetOrder - the order of the next step; 0 if the type is another one. */
PetscErrorCode VBDFGetOrder(TS ts, PetscInt *order) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  PetscCall(Self(ts, &self));
  *order = self ? self->controller.order : 0;
  PetscFunctionReturn(0);
}

/*
  VBDFGetLocalError - what the step taken last adds to the error, as a combination of its points:
  the weights of those that VBDFGetHistory() tells, after an accepted step.

  fields  of a node
  n       how many; 0: it is not known (a jump, another type; the first step's
          comes with the second's)
  weight  of each point, for each field of a node
*/
PetscErrorCode VBDFGetLocalError(TS ts, PetscInt fields, PetscInt *n,
                                 PetscReal weight[VBDF_POINTS][VBDF_FIELDS]) {
  VBDF *self = NULL;
  PetscInt order;

  PetscFunctionBegin;
  *n = 0;
  PetscCall(Self(ts, &self));
  if (!self || self->formula.given) PetscFunctionReturn(0);
  order = self->controller.taken_order;
  if (!self->controller.jumped && self->formula.n > order)
    *n = FormulaErrorWeights(&self->formula, order, fields, weight);
  PetscFunctionReturn(0);
}

/*
  VBDFGetFormula - U_t of the state that the step taken last has led to, as a combination of its
  points: the weights, for each field, of those that VBDFGetHistory() tells, after an accepted step.

  n  how many; 0: there are none (another type)

  The factor is taken for a number that was given: whatever it is, the formula is one of the same
  order, also for what moves with the state (tangent.c).
*/
PetscErrorCode VBDFGetFormula(TS ts, PetscInt *n, PetscReal weight[][VBDF_FIELDS]) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  *n = 0;
  PetscCall(Self(ts, &self));
  if (self && !self->formula.given)
    *n = FormulaRateWeights(&self->formula, self->controller.taken_order, weight);
  PetscFunctionReturn(0);
}

/*
  VBDFGetDense - the state and its rate at a time within the latest step, by the dense output, as
  combinations of the points that VBDFGetHistory() tells: their weights for each field.

  n  how many; 0 if the type is another one
*/
PetscErrorCode VBDFGetDense(TS ts, PetscReal t, PetscInt *n, PetscReal value[][VBDF_FIELDS],
                            PetscReal slope[][VBDF_FIELDS]) {
  VBDF *self = NULL;

  PetscFunctionBegin;
  *n = 0;
  PetscCall(Self(ts, &self));
  if (self)
    *n = FormulaDenseWeights(&self->formula, self->controller.order, Since(ts, self, t), value,
                             slope);
  PetscFunctionReturn(0);
}
