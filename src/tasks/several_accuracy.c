/* -accuracy of several rods: what it sets of each at first, and how the run is repeated, finer,
   until the told error of none is above it. */
#include "tasks/accuracy.h"
#include "tasks/grow_rules.h"
#include "tasks/several_run.h"

/* What a rod's own options tell of its mesh, and of the steps that it wants. */
static PetscErrorCode FirstOf(Run *self, PetscInt k, PetscReal *rtol) {
  Finer *rod = &self->finer[k];
  PetscReal wants;
  char text[32];

  PetscFunctionBegin;
  PetscCall(RodsEnter(self->rods, k));
  PetscCall(OptionGiven("-rod_cells", &rod->cells_given));
  PetscCall(OptionGiven("-contact_stiffness", &rod->stiffness_given));
  PetscCall(AccuracyApply());
  PetscCall(AccuracyTolerance());
  PetscCall(OptionInt("-rod_cells", &rod->cells, NULL));
  PetscCall(OptionReal("-ts_rtol", &wants, NULL));
  PetscCall(RodsLeave(self->rods));
  *rtol = PetscMin(*rtol, wants);
  (void)snprintf(text, sizeof(text), "%d", (int)rod->cells);
  if (!rod->cells_given) PetscCall(RodsPut(self->rods, k, "-rod_cells", text));
  PetscFunctionReturn(0);
}

static PetscErrorCode SetTolerance(Run *self, PetscReal rtol, PetscBool touches) {
  char text[32];

  PetscFunctionBegin;
  if (self->rtol_given) PetscFunctionReturn(0);
  (void)snprintf(text, sizeof(text), "%.3g", (double)rtol);
  PetscCall(OptionPut("-ts_rtol", text));
  (void)snprintf(text, sizeof(text), "%.3g", (double)(grow_rule.contact_eases * rtol));
  if (touches) PetscCall(OptionPut("-contact_rtol", text));
  PetscFunctionReturn(0);
}

/* RunAccuracy - sets what is not given from -accuracy, in the first run; touches: any rod can
   touch something. */
PetscErrorCode RunAccuracy(Run *self, PetscBool touches) {
  PetscReal rtol = PETSC_MAX_REAL;
  PetscBool set, eased;

  PetscFunctionBegin;
  PetscCall(OptionReal("-accuracy", &self->accuracy, &set));
  if (!set) self->accuracy = 0;
  if (!set || self->runs || self->restart[0]) PetscFunctionReturn(0);
  PetscCall(PetscCalloc1(self->n, &self->finer));
  PetscCall(OptionGiven("-ts_rtol", &self->rtol_given));
  PetscCall(OptionGiven("-contact_rtol", &eased));
  if (eased) self->rtol_given = PETSC_TRUE;
  for (PetscInt k = 0; k < self->n; k++) PetscCall(FirstOf(self, k, &rtol));
  PetscCall(SetTolerance(self, rtol, touches));
  PetscCall(RodsAnew(self->rods));
  PetscFunctionReturn(0);
}

/* What the rods are to be finer by: each by its own errors or, where they feel each other, all by
   the largest. */
static AccuracyNeeds Needs(const Run *self, PetscInt k) {
  AccuracyNeeds most = {1, 1, 1};

  for (PetscInt i = 0; i < self->n; i++) {
    const Errors *error = &self->each[i].error.end;
    if ((i != k && !self->leg.rod->coupled) || error->all <= self->accuracy) continue;
    const AccuracyNeeds one = AccuracyMissing(error, self->accuracy, self->leg.rod->order);
    most.cells = PetscMax(most.cells, one.cells);
    most.steps = PetscMax(most.steps, one.steps);
    most.stiffness = PetscMax(most.stiffness, one.stiffness);
  }
  return most;
}

/* Rod k is to have that option from now on. */
static PetscErrorCode Put(Run *self, PetscInt k, const char *name, PetscReal value) {
  char text[32];

  PetscFunctionBegin;
  (void)snprintf(text, sizeof(text), "%.4g", (double)value);
  PetscCall(RodsPut(self->rods, k, name, text));
  PetscFunctionReturn(0);
}

/* A finer mesh, and firmer contact. */
static PetscErrorCode RefineRod(Run *self, PetscInt k, const AccuracyNeeds *needs, PetscBool *can) {
  Finer *rod = &self->finer[k];

  PetscFunctionBegin;
  if (needs->cells > 1 && !rod->cells_given) {
    rod->cells = (PetscInt)PetscCeilReal(rod->cells * PetscMin(needs->cells, grow_rule.finer_most));
    PetscCall(Put(self, k, "-rod_cells", rod->cells));
    *can = PETSC_TRUE;
  }
  if (needs->stiffness > 1 && !rod->stiffness_given) {
    PetscCall(Put(self, k, "-contact_stiffness",
                  self->scene[k]->contact.stiffness *
                      PetscMin(needs->stiffness, PetscSqr(grow_rule.finer_most))));
    *can = PETSC_TRUE;
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Refine(Run *self, PetscBool *can) {
  PetscReal steps = 1;

  PetscFunctionBegin;
  *can = PETSC_FALSE;
  for (PetscInt k = 0; k < self->n; k++) {
    const AccuracyNeeds needs = Needs(self, k);
    steps = PetscMax(steps, PetscMin(needs.steps, PetscSqr(grow_rule.finer_most)));
    PetscCall(RefineRod(self, k, &needs, can));
  }
  if (steps == 1 || self->rtol_given) PetscFunctionReturn(0);
  PetscCall(SetTolerance(self, self->rtol / steps, (PetscBool)(self->eased > self->rtol)));
  *can = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* RunRefine - is the run to be repeated, for errors are above -accuracy? It is then finer.
   What cannot be is told. */
PetscErrorCode RunRefine(Run *self, PetscBool *again) {
  PetscReal most = 0;
  PetscInt cells = 0;
  PetscBool helps;

  PetscFunctionBegin;
  *again = PETSC_FALSE;
  for (PetscInt k = 0; k < self->n; k++)
    if (self->each[k].error.kind != ESTIMATE_NONE)
      most = PetscMax(most, self->each[k].error.end.all);
  if (self->accuracy == 0 || most <= self->accuracy) PetscFunctionReturn(0);
  helps = (PetscBool)(!self->runs || most < grow_rule.finer_helps * self->before);
  self->before = most;
  if (helps && !self->restart[0] && ++self->runs < grow_rule.finer_runs)
    PetscCall(Refine(self, again));
  for (PetscInt k = 0; k < self->n && *again; k++) cells = PetscMax(cells, self->finer[k].cells);
  if (*again && !self->quiet)
    PetscCall(PetscPrintf(PETSC_COMM_SELF,
                          "the error estimate, %.1e, is above -accuracy %g: once more, with up to "
                          "%d cells a rod\n",
                          (double)most, (double)self->accuracy, (int)cells));
  for (PetscInt k = 0; k < self->n && !*again; k++) {
    PetscCall(RodsEnter(self->rods, k));
    PetscCall(
        AccuracyTell(&self->each[k].error, self->rtol, self->each[k].now->rod, PETSC_COMM_SELF));
    PetscCall(RodsLeave(self->rods));
  }
  PetscFunctionReturn(0);
}

/* RunStartOver - ends a run, whose rods are then ready to be run once more. */
PetscErrorCode RunStartOver(Run *self) {
  Run begun = {.restart = self->restart,
               .stopped_by = -1,
               .rods = self->rods,
               .finer = self->finer,
               .rtol_given = self->rtol_given,
               .runs = self->runs,
               .before = self->before};

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(begun.file.path, self->file.path, sizeof(begun.file.path)));
  self->rods = NULL;
  self->finer = NULL;
  PetscCall(RunEnd(self));
  *self = begun;
  PetscCall(RodsAnew(self->rods));
  PetscFunctionReturn(0);
}
