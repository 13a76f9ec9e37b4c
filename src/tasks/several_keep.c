/* -task grow of several rods: what a run needs to go on. */
#include "tasks/several_run.h"
#include "rod/ask.h"

/* The errors of one rod, which are followed, as its part of those of all; back: taken from there.
 */
static PetscErrorCode CopyErrors(const Run *self, PetscInt k, Vec all[], Vec own[],
                                 PetscBool back) {
  Vec part;

  PetscFunctionBegin;
  for (int i = 0; i < ESTIMATE_KEPT; i++) {
    PetscCall(RodPartOpen(self->leg.rod, k, all[i], &part));
    PetscCall(back ? VecCopy(part, own[i]) : VecCopy(own[i], part));
    PetscCall(RodPartClose(self->leg.rod, k, all[i], &part));
  }
  PetscFunctionReturn(0);
}

/* Of each rod, and its errors. */
static PetscErrorCode KeepEach(Run *self, RestartState own[], Vec all[]) {
  Vec points[VBDF_POINTS], errors[ESTIMATE_KEPT];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    PetscCall(LegPartFollow(self->each[k].now));
    PetscCall(GrowKeep(&self->each[k], &own[k], points, errors));
    if (!self->each[k].estimate) continue;
    PetscCall(CopyErrors(self, k, all, errors, PETSC_FALSE));
    PetscCall(EstimateVectorsDestroy(self->each[k].estimate, errors));
  }
  PetscFunctionReturn(0);
}

/* RunKeep - keeps it in a file that is being written: of a Several. */
PetscErrorCode RunKeep(void *ctx, HdfFile file) {
  Run *self = (Run *)ctx;
  Vec points[VBDF_POINTS], errors[ESTIMATE_KEPT];
  RestartState state = {.model = SPACE}, *own;
  PetscInt iterations, rejected;

  PetscFunctionBegin;
  if (self->t == 0) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(self->n, &own));
  for (int i = 0; i < ESTIMATE_KEPT; i++) {
    PetscCall(VecDuplicate(self->leg.U, &errors[i]));
    PetscCall(VecZeroEntries(errors[i]));
  }
  PetscCall(KeepEach(self, own, errors));
  PetscCall(RestartKeep(&self->leg, self->t, self->leg.U, &state, points));
  if (self->each[0].kept.changed) state.points = state.order = 1; /* steps begin anew */
  PetscCall(TSGetSNESIterations(self->leg.ts, &iterations));
  PetscCall(TSGetStepRejections(self->leg.ts, &rejected));
  state.counted[0] = self->counted[0] + iterations;
  state.counted[1] = self->counted[1] + rejected;
  state.kept.snaps = self->snaps;
  PetscCall(RestartWrite(file, self->leg.rod->scene, self->leg.rod, &state, points, errors));
  PetscCall(RememberedWriteEach(file, self->n, own));
  for (int i = 0; i < ESTIMATE_KEPT; i++) PetscCall(VecDestroy(&errors[i]));
  PetscCall(PetscFree(own));
  PetscFunctionReturn(0);
}

/* What ended the earlier run does not end this one, too. */
static void DropEvents(OptionWords *words) {
  for (int k = 0; k < words->sections; k++)
    for (int i = words->section[k].n - 1; i >= 0; i--) {
      const OptionRow *row = OptionFind(words->section[k].option[i].name);
      if (row && row->flags & EVENT) SectionDrop(&words->section[k], i);
    }
}

/* RunReadRestart - reads it, and the rods of the file, which count unless the scene is given
   anew. */
PetscErrorCode RunReadRestart(Run *self) {
  char fault[WORDS_FAULT] = "", *text;
  PetscBool begun, stopped;

  PetscFunctionBegin;
  PetscCall(HdfHas(self->restart, "/restart/each", &begun));
  UserCheck(begun, OptionsComm(),
            "-restart %s: holds no run of several rods that has taken a step; run the scene anew",
            self->restart);
  PetscCall(HdfReadText("-restart", self->restart, "/rods/text", &text));
  UserCheck(WordsAddText(&self->words, self->restart, text, fault), OptionsComm(), "%s", fault);
  PetscCall(PetscFree(text));
  PetscCall(HdfHas(self->restart, "/event", &stopped));
  if (stopped) DropEvents(&self->words);
  PetscCall(RememberedRead(self->restart, OptionsComm(), &self->from));
  PetscFunctionReturn(0);
}

/* RunCheckSame - the rods are those of the file, in its order. */
PetscErrorCode RunCheckSame(const Run *self) {
  PetscInt rods = 0;

  PetscFunctionBegin;
  for (int k = 0; k < self->words.sections; k++)
    if (!strncmp(self->words.section[k].head, "rod ", 4)) rods++;
  UserCheck(rods == self->n, OptionsComm(), "-restart %s: has %d rods, and the scene has %d",
            self->restart, (int)rods, (int)self->n);
  for (PetscInt k = 0; k < self->n; k++) {
    const char *name = self->words.section[k].head + strlen("rod ");
    UserCheck(!strcmp(name, RodsName(self->rods, k)), OptionsComm(),
              "-restart %s: its rod %d is %s, and that of the scene %s", self->restart, (int)k + 1,
              name, RodsName(self->rods, k));
  }
  PetscFunctionReturn(0);
}

/* RunReadEach - what each remembers. */
PetscErrorCode RunReadEach(Run *self) {
  char text[64];

  PetscFunctionBegin;
  UserCheck(self->end > self->from.t * (1 + 1e-12), OptionsComm(),
            "-restart %s: is at t = %s already; give a later -ts_max_time", self->restart,
            OptionBoth(self->from.t, UNIT_TIME, text));
  PetscCall(PetscMalloc1(self->n, &self->own));
  PetscCall(RememberedReadEach(self->restart, OptionsComm(), self->n, self->own));
  PetscFunctionReturn(0);
}

/* One rod goes on. */
static PetscErrorCode GoOnEach(Run *self, PetscInt k, Vec all[]) {
  const RestartState *state = &self->own[k];
  Grow *grow = &self->each[k];
  LegMeasure *of = &self->leg.of[k];
  Vec errors[ESTIMATE_KEPT];

  PetscFunctionBegin;
  ObserverSetBalance(grow->observer, state->balance);
  PetscCall(EstimateSet(grow->estimate, state->t, state->errors));
  if (grow->estimate && state->follows != 0) {
    PetscCall(EstimateVectors(grow->estimate, errors));
    PetscCall(CopyErrors(self, k, all, errors, PETSC_TRUE));
    PetscCall(EstimateTake(grow->estimate, state->following, errors));
    PetscCall(EstimateVectorsDestroy(grow->estimate, errors));
  }
  if (state->laws.falls > 0) SceneAtSpeed(grow->scene, state->laws.falls);
  grow->kept = state->kept;
  grow->seen = state->seen;
  grow->seen.t = grow->start = grow->stored_shape = state->t;
  PetscCall(PetscArraycpy(grow->counted, state->counted, 2));
  grow->now->ease.times = PetscMin(state->ease, grow->now->ease.most);
  grow->now->ease.wants = PetscMin(state->wants, grow->now->ease.most);
  grow->now->ease.others = state->others;
  PetscCall(PetscArraycpy(of->kick, state->kick, RESTART_KICKS));
  of->kick_ends = state->kick_ends;
  PetscFunctionReturn(0);
}

/* RunGoOn - all of them do. */
PetscErrorCode RunGoOn(Run *self) {
  Vec errors[ESTIMATE_KEPT];
  char text[64];

  PetscFunctionBegin;
  PetscCall(RestartTake(self->restart, &self->from, &self->leg));
  self->U_t = self->leg.newton.latest.U_t;
  for (int i = 0; i < ESTIMATE_KEPT; i++) PetscCall(VecDuplicate(self->leg.U, &errors[i]));
  PetscCall(RestartReadErrors(self->restart, &self->from, PETSC_COMM_SELF, errors));
  for (PetscInt k = 0; k < self->n; k++) PetscCall(GoOnEach(self, k, errors));
  RunEaseEach(self, self->from.ease);
  for (int i = 0; i < ESTIMATE_KEPT; i++) PetscCall(VecDestroy(&errors[i]));
  self->t = self->start = self->stored_shape = self->from.t;
  self->snaps = (PetscInt)self->from.kept.snaps;
  PetscCall(PetscArraycpy(self->counted, self->from.counted, 2));
  PetscCall(SeveralTake(&self->file, self->restart, self->t, self->interval));
  PetscCall(RunRefuseEvents(self));
  self->next_output = OutputNext(self->t, self->interval);
  if (!self->quiet)
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "goes on from t = %s of %s, into %s\n",
                          OptionBoth(self->t, UNIT_TIME, text), self->restart, self->file.path));
  PetscFunctionReturn(0);
}
