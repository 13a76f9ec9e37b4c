/* What moves a simulation: the run of one rod, or of several that go together. */
#include "library/simulation.h"
#include "rod/ask.h"

/* Has it several rods, or the file that it goes on from? */
static PetscErrorCode IsOfSeveral(Tendril self, PetscBool *several) {
  char file[PETSC_MAX_PATH_LEN] = "";

  PetscFunctionBegin;
  *several = (PetscBool)(self->line.taken.sections > 0);
  if (*several) PetscFunctionReturn(0);
  PetscCall(OptionText("-restart", file, NULL));
  if (file[0]) PetscCall(HdfHas(file, "/rods/text", several));
  PetscFunctionReturn(0);
}

static PetscErrorCode BeginSeveral(Tendril self) {
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(self->comm, &ranks));
  UserCheck(ranks == 1, self->comm,
            "several rods run on one rank in this version: give MPI_COMM_SELF");
  PetscCall(SingleAsked(TASK_GROW, "", &self->asked));
  PetscCall(PetscNew(&self->several));
  self->several->restart = self->asked.restart;
  self->several->stopped_by = -1;
  self->several->by_steps = PETSC_TRUE;
  PetscCall(RunBegin(self->several));
  PetscCall(RunHeading(self->several));
  self->rods = self->several->n;
  PetscFunctionReturn(0);
}

static PetscErrorCode BeginSingle(Tendril self) {
  PetscFunctionBegin;
  PetscCall(SingleScene(TASK_GROW, "", &self->asked, &self->scene));
  PetscCall(PetscNew(&self->grow));
  self->grow->scene = self->scene;
  self->grow->by_steps = PETSC_TRUE;
  PetscCall(GrowCreate(self->grow, "", self->asked.restart));
  PetscCall(GrowHeading(self->grow));
  self->rods = 1;
  PetscFunctionReturn(0);
}

/* CourseBegin - from the options to where the rods begin, or go on. Collective; the caller ends it
   with CourseEnd(), also after an error. */
PetscErrorCode CourseBegin(Tendril self) {
  PetscBool several;

  PetscFunctionBegin;
  PetscCall(IsOfSeveral(self, &several));
  PetscCall(several ? BeginSeveral(self) : BeginSingle(self));
  PetscFunctionReturn(0);
}

PetscErrorCode CourseEnd(Tendril self) {
  PetscFunctionBegin;
  if (self->grow) PetscCall(GrowDestroy(self->grow));
  if (self->several) PetscCall(RunEnd(self->several));
  PetscCall(PetscFree(self->grow));
  PetscCall(PetscFree(self->several));
  if (self->scene) PetscCall(SceneDestroy(&self->scene));
  PetscFunctionReturn(0);
}

/* CourseIsThere - is the simulation set up? */
PetscBool CourseIsThere(const struct Tendril_ *self) {
  return (PetscBool)(self->grow || self->several);
}

PetscBool CourseIsOver(const struct Tendril_ *self) {
  return self->grow ? self->grow->over : self->several->over;
}

/* CourseWaits - does the step that was taken last wait to be looked at? */
PetscBool CourseWaits(const struct Tendril_ *self) {
  return self->grow ? self->grow->waits : self->several->waits;
}

/* CourseTime - the end of the latest step that was looked at. */
PetscReal CourseTime(const struct Tendril_ *self) {
  return self->grow ? self->grow->seen.t : self->several->t;
}

PetscReal CourseStart(const struct Tendril_ *self) {
  return self->grow ? self->grow->start : self->several->start;
}

/* CourseRod - what is seen of rod k. */
Grow *CourseRod(const struct Tendril_ *self, PetscInt k) {
  return self->grow ? self->grow : &self->several->each[k];
}

/* CourseStep - one step on; or what is beyond a time waits. Collective. */
PetscErrorCode CourseStep(Tendril self, PetscReal until) {
  PetscFunctionBegin;
  PetscCall(self->grow ? GrowStepOn(self->grow, until) : RunStepOn(self->several, until));
  PetscFunctionReturn(0);
}

/* CourseFinish - what is over is ended; again: it was in vain, see CourseStartOver(). Collective.
 */
PetscErrorCode CourseFinish(Tendril self, PetscBool *again) {
  PetscFunctionBegin;
  PetscCall(self->grow ? GrowFinish(self->grow, again) : RunFinish(self->several, again));
  if (self->several) *again = PETSC_FALSE; /* finer is for who asks for a whole run */
  PetscFunctionReturn(0);
}

/* CourseStartOver - the run begins anew, in soft contact. Collective. */
PetscErrorCode CourseStartOver(Tendril self) {
  PetscFunctionBegin;
  PetscCall(GrowStartOver(self->grow));
  PetscCall(GrowCreate(self->grow, "", ""));
  PetscFunctionReturn(0);
}

/* CourseMayGoOn - may it go on behind its end, if that is put off? Not behind an event. */
PetscBool CourseMayGoOn(const struct Tendril_ *self) {
  return (PetscBool) !(self->grow ? self->grow->event.kind != EVENT_NONE
                                  : self->several->stopped_by >= 0);
}

/* The rod whose prefix a name has, which is taken off; -1: all rods are meant. */
static PetscInt TakePrefix(Run *run, const char *name, char option[128]) {
  for (PetscInt k = 0; k < run->n; k++) {
    const char *rod = RodsName(run->rods, k);
    const size_t n = strlen(rod);
    if (strncmp(name + 1, rod, n) != 0 || name[1 + n] != '_') continue;
    (void)snprintf(option, 128, "-%s", name + n + 2);
    return k;
  }
  (void)snprintf(option, 128, "%s", name);
  return -1;
}

/* CourseChange - a new value from the present time on. What is refused has changed nothing.
   Collective. */
PetscErrorCode CourseChange(Tendril self, const char *name, const char *value) {
  char option[128];
  PetscInt rod;

  PetscFunctionBegin;
  if (self->grow) {
    PetscCall(GrowApply(self->grow, name, value, self->at));
    PetscCall(ChangesDo(&self->scene->changes, self->at, name, value));
    self->grow->over = PETSC_FALSE;
    PetscFunctionReturn(0);
  }
  rod = TakePrefix(self->several, name, option);
  PetscCall(RunApply(self->several, rod, option, value, self->at));
  PetscCall(RunRecord(self->several, rod, option, value, self->at));
  self->several->over = PETSC_FALSE;
  PetscFunctionReturn(0);
}

/* CourseState - the state of all and its rate at the present time; U NULL: as they begin. Borrowed
   from V where they are between steps: the caller destroys that. Collective. */
PetscErrorCode CourseState(Tendril self, PetscReal t, Vec V[2], Vec *U, Vec *U_t) {
  const Leg *leg = self->grow ? self->grow->now : &self->several->leg;

  PetscFunctionBegin;
  V[0] = V[1] = *U = *U_t = NULL;
  if (CourseWaits(self) && t > CourseTime(self)) {
    PetscCall(self->grow ? GrowWithin(self->grow, t, V, NULL) : RunWithin(self->several, t, V));
    *U = V[0];
    *U_t = V[1];
  } else if (CourseTime(self) > 0) {
    *U = leg->U;
    *U_t = self->grow ? leg->newton.latest.U_t : self->several->U_t;
  }
  PetscFunctionReturn(0);
}

/* CourseSave - writes a result file as of a time. Collective.

   now  the present time */
PetscErrorCode CourseSave(Tendril self, const char *path, PetscReal t, PetscReal now) {
  PetscFunctionBegin;
  PetscCall(self->grow ? GrowSave(self->grow, path, t, now) : RunSave(self->several, path, t, now));
  PetscFunctionReturn(0);
}
