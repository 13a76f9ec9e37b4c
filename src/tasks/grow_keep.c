/* -task grow: what a run needs to go on from a time, now and, of a run by steps, at earlier ones.
 */
#include "tasks/growing.h"
#include "tasks/grow_rules.h"

/* At a time between two steps, or in one: the state alone, from which short steps go on. */
typedef struct GrowMark {
  RestartState state;
  Vec U, errors[ESTIMATE_KEPT]; /* errors: as they were known at the end of a step, if they are */
} Mark;

/* What is known of the run besides its stepper. Collective. */
static PetscErrorCode KeepRun(Grow *self, RestartState *state) {
  PetscFunctionBegin;
  *state = (RestartState){.model = self->now - self->leg, .seen = self->seen, .kept = self->kept};
  state->kept.crawl_way = self->crawl.way;
  state->kept.crawl_half = self->crawl.half;
  state->kept.crawl_steps = (PetscReal)self->crawl.steps;
  state->kept.crawl_at = self->crawl.at;
  ObserverGetBalance(self->observer, state->balance);
  PetscCall(GrowCount(self, state->counted));
  PetscFunctionReturn(0);
}

/* ... and of its errors. */
static PetscErrorCode KeepErrors(Grow *self, RestartState *state, Vec errors[]) {
  PetscFunctionBegin;
  state->follows = self->estimate ? 1 : 0;
  if (!self->estimate) PetscFunctionReturn(0);
  PetscCall(EstimateGet(self->estimate, state->errors));
  PetscCall(EstimateVectors(self->estimate, errors));
  PetscCall(EstimateKeep(self->estimate, state->following, errors));
  PetscFunctionReturn(0);
}

/* The stepper begins again from one point. */
static void FromOnePoint(const Grow *self, PetscReal t, RestartState *state) {
  state->t = t;
  state->time[0] = 0;
  state->points = state->order = 1;
  state->step = grow_rule.again_step * self->scene->end_time;
  state->kept.changed = 1;
}

/* GrowKeep - all that the run needs to go on from its latest step. Collective.

   points  borrowed
   errors  the caller ends them with EstimateVectorsDestroy() */
PetscErrorCode GrowKeep(Grow *self, RestartState *state, Vec points[], Vec errors[]) {
  PetscFunctionBegin;
  PetscCall(KeepRun(self, state));
  PetscCall(RestartKeep(self->now, self->seen.t, self->now->U, state, points));
  if (self->kept.changed) state->points = state->order = 1; /* as GrowChange() has it */
  PetscCall(KeepErrors(self, state, errors));
  PetscFunctionReturn(0);
}

/* What is seen at a time within the step, and the balance of energy up to there, from that of where
   the step began; that of the run itself stays. Collective. */
static PetscErrorCode LookWithin(Grow *self, PetscReal t, Vec U, Vec U_t,
                                 const PetscReal begin[BALANCE_STATE], RestartState *state) {
  const PetscReal law = self->scene->contact.time;
  PetscReal balance[BALANCE_STATE];

  PetscFunctionBegin;
  ObserverGetBalance(self->observer, balance);
  ObserverSetBalance(self->observer, begin ? begin : balance);
  PetscCall(ObserverMeasure(self->observer, self->now->rod, t, U, U_t, NULL, &state->seen));
  ObserverGetBalance(self->observer, state->balance);
  ObserverSetBalance(self->observer, balance);
  PetscCall(SceneContactAt(self->scene, law));
  PetscFunctionReturn(0);
}

/* The run at a time within its latest step, where its balance of energy was as that began; NULL: it
   is there. */
static PetscErrorCode KeepWithin(Grow *self, PetscReal t, const PetscReal balance[BALANCE_STATE],
                                 Mark *mark) {
  Vec points[VBDF_POINTS], V[2];
  PetscReal begin;

  PetscFunctionBegin;
  PetscCall(KeepRun(self, &mark->state));
  PetscCall(KeepErrors(self, &mark->state, mark->errors));
  PetscCall(RestartKeep(self->now, t, self->now->U, &mark->state, points));
  FromOnePoint(self, t, &mark->state);
  PetscCall(GrowWithin(self, t, V, &begin));
  mark->U = V[0];
  PetscCall(LookWithin(self, t, V[0], V[1], balance, &mark->state));
  mark->state.seen.error_tip = self->seen.error_tip;
  mark->state.seen.error_norm_x2 = self->seen.error_norm_x2;
  mark->state.seen.error_energy = self->seen.error_energy;
  mark->state.seen.step = t - begin;
  mark->state.seen.model = self->now - self->leg;
  PetscCall(VecDestroy(&V[1]));
  PetscFunctionReturn(0);
}

/* GrowMark - keeps what a run by steps needs to go on from a time in, or at the end of, its latest
   step. Collective. */
PetscErrorCode GrowMark(Grow *self, PetscReal t) {
  Mark mark;

  PetscFunctionBegin;
  if (!(self->seen.step > 0)) PetscFunctionReturn(0);
  PetscCall(
      KeepWithin(self, PetscMin(t, self->seen.t), t < self->seen.t ? self->balance : NULL, &mark));
  PetscCall(PetscRealloc((size_t)(self->marks + 1) * sizeof(mark), &self->mark));
  self->mark[self->marks++] = mark;
  PetscFunctionReturn(0);
}

PetscErrorCode GrowMarksDestroy(Grow *self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->marks; k++) {
    PetscCall(VecDestroy(&self->mark[k].U));
    PetscCall(EstimateVectorsDestroy(self->estimate, self->mark[k].errors));
  }
  PetscCall(PetscFree(self->mark));
  self->marks = 0;
  PetscFunctionReturn(0);
}

/* As of a mark. A row of the series at its time goes with it, unless there is one. */
static PetscErrorCode SaveMark(Grow *self, const char *path, Mark *mark) {
  const PetscReal t = mark->state.t;
  const Observation *row;
  PetscInt n;
  int has = 0;

  PetscFunctionBegin;
  OutputRows(self->output, &n, &row);
  for (PetscInt k = 0; k < n; k++) has |= PetscAbsReal(row[k].t - t) <= 1e-12 * t;
  PetscCall(OutputSave(self->output, path, t, has ? NULL : &mark->state.seen, self->now->rod,
                       &mark->state, &mark->U, self->estimate ? mark->errors : NULL, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* The present shape is there, too. */
static PetscErrorCode SaveNow(Grow *self, const char *path) {
  Vec points[VBDF_POINTS], errors[ESTIMATE_KEPT];
  const PetscReal stored = self->stored_shape;
  RestartState state;
  PetscErrorCode error;

  PetscFunctionBegin;
  if (self->seen.t == 0) {
    PetscCall(
        OutputSave(self->output, path, 0, NULL, self->now->rod, NULL, NULL, NULL, PETSC_FALSE));
    PetscFunctionReturn(0);
  }
  PetscCall(GrowKeep(self, &state, points, errors));
  if (stored != self->seen.t) PetscCall(GrowStoreShape(self, self->seen.t, self->now->U));
  error = OutputSave(self->output, path, self->seen.t, NULL, self->now->rod, &state, points,
                     self->estimate ? errors : NULL,
                     (PetscBool)(self->over && self->reason == TS_CONVERGED_TIME));
  if (stored != self->seen.t) OutputDropShape(self->output);
  self->stored_shape = stored;
  PetscCall(EstimateVectorsDestroy(self->estimate, errors));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* Within the step that waits. */
static PetscErrorCode SaveWithin(Grow *self, const char *path, PetscReal t) {
  const PetscReal stored = self->stored_shape;
  PetscErrorCode error;
  Mark mark;

  PetscFunctionBegin;
  PetscCall(KeepWithin(self, t, NULL, &mark));
  PetscCall(GrowStoreShape(self, t, mark.U));
  error = SaveMark(self, path, &mark);
  OutputDropShape(self->output);
  self->stored_shape = stored;
  PetscCall(VecDestroy(&mark.U));
  PetscCall(EstimateVectorsDestroy(self->estimate, mark.errors));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/*
  GrowSave - writes a result file of a run by steps, as of a time at which a shape was stored, or as
  of now. Collective.

  now  the present time: that of the latest step, or one within the step that waits
*/
PetscErrorCode GrowSave(Grow *self, const char *path, PetscReal t, PetscReal now) {
  char text[2][64];

  PetscFunctionBegin;
  if (PetscAbsReal(t - now) <= grow_rule.same_time * now) {
    if (self->waits && now > self->seen.t)
      PetscCall(SaveWithin(self, path, now));
    else
      PetscCall(SaveNow(self, path));
    PetscFunctionReturn(0);
  }
  for (PetscInt k = 0; k < self->marks; k++)
    if (PetscAbsReal(t - self->mark[k].state.t) <= grow_rule.same_time * t) {
      PetscCall(SaveMark(self, path, &self->mark[k]));
      PetscFunctionReturn(0);
    }
  UserCheck(PETSC_FALSE, self->scene->comm,
            "save: no shape of this run was stored at t = %s; times are multiples of %s "
            "(-output_interval, -output_shapes)",
            OptionBoth(t, UNIT_TIME, text[0]),
            OptionBoth(self->output_interval, UNIT_TIME, text[1]));
  PetscFunctionReturn(0);
}
