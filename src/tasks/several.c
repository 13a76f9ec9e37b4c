/* -task grow of several rods. They are stepped as one (system/model.h); what is seen of each is
   that of a run of its own (growing.h), by the leg that it has in that of all. */
#include "tasks/several.h"
#include "base/signals.h"
#include "record/several.h"
#include "rod/ask.h"
#include "system/births.h"
#include "system/model.h"
#include "stepping/vbdf.h"
#include "tasks/births.h"
#include "tasks/growing.h"
#include "tasks/grow_rules.h"
#include <petsctime.h>

typedef struct {
  Rods rods;
  Joints joints;
  PetscInt n;
  Scene *scene;
  Leg leg;              /* of all */
  Estimate estimate;    /* of rods that hold each other; NULL: each has its own */
  Strands strands[2];   /* of those that may touch, for the stepper and for who looks; NULL: none */
  RodSeen looked;       /* the state that the latter know, */
  PetscBool with_rates; /* ... and whether with its rates */
  Grow *each;           /* what is seen of each */
  Output *output;
  Several file;
  const char *restart; /* the file to go on from; empty: none */
  RestartState from;   /* of all, there, */
  RestartState *own;   /* and of each */
  OptionWords words;   /* the sections of that file */
  PetscReal end, rtol, eased, start, interval, next_output, stored_shape, t;
  PetscBool *to_come, bears;     /* rods that are not born yet; some are with the latest step */
  PetscBool quiet, begun, ready; /* ready: what there is may be stored */
  PetscInt snaps;
  PetscReal counted[2]; /* iterations and rejected tries of the runs that it goes on with */
  int stopped;
  TSConvergedReason reason;
  Pace pace;
} Run;

/* SeveralAsked - has the scene several rods, or the run that is gone on with? */
PetscErrorCode SeveralAsked(PetscBool *asked) {
  const CommandLine *line = OptionsLine();
  char restart[PETSC_MAX_PATH_LEN] = "";

  PetscFunctionBegin;
  *asked = (PetscBool)(!OptionsPushed() && line && line->taken.sections > 0);
  if (*asked || OptionsPushed()) PetscFunctionReturn(0);
  PetscCall(OptionText("-restart", restart, NULL));
  if (restart[0]) PetscCall(HdfHas(restart, "/rods/text", asked));
  PetscFunctionReturn(0);
}

/* ---- what is asked for ---- */

/* Refuses what several rods together cannot yet. */
static PetscErrorCode CheckRod(const Scene scene) {
  PetscFunctionBegin;
  UserCheck(!scene->tropism.any, OptionsComm(),
            "-tropism_ options and -growth_ironing: several rods do not know of a natural "
            "curvature that the material learns in this version; take them out");
  UserCheck(scene->born == 0 || scene->tip.type == TIP_FREE, OptionsComm(),
            "-born: not of a rod whose tip is held or led; leave it or -tip_type, -tip_path out");
  UserCheck(!scene->changes, OptionsComm(),
            "-change_file: several rods are not changed in a run in this version; take it out");
  PetscFunctionReturn(0);
}

static PetscErrorCode MakeScene(Run *self, PetscInt k, const Rod each[]) {
  PetscBool carried, touch = PETSC_FALSE;
  const char *why;
  Scene scene;
  Seat seat;

  PetscFunctionBegin;
  PetscCall(JointsSeat(self->joints, k, each, &seat, &carried));
  PetscCall(RodsEnter(self->rods, k));
  PetscCall(OptionBool("-contact_self", &touch, NULL));
  if (RodsTouch(self->rods)) touch = PETSC_TRUE;
  PetscCall(SceneCreateOn(carried ? &seat : NULL, touch, &self->scene[k]));
  scene = self->scene[k];
  PetscCall(SingleShape(scene));
  scene->space.rod = PETSC_TRUE;
  PetscCall(CheckRod(scene));
  PetscCall(JointsHold(self->joints, k, scene));
  why = rod_space.refuses(scene);
  UserCheck(!why, OptionsComm(), "%s", why);
  SceneAtTolerance(scene, self->rtol);
  PetscCall(RodsLeave(self->rods));
  self->to_come[k] = SceneToCome(scene, self->restart[0] ? self->from.t : 0);
  if (self->restart[0])
    PetscCall(SeveralLabels(self->restart, k, JointsOn(self->joints, k), scene));
  PetscCall(JointsDouble(self->joints, self->rods, k, (PetscBool)(self->restart[0] != 0), scene));
  if (!self->restart[0]) PetscFunctionReturn(0);
  PetscCall(SceneRecall(scene, &self->own[k].laws));
  PetscFunctionReturn(0);
}

/* As of a rod alone; can any touch something, by what is given? */
static PetscErrorCode ReadTolerance(Run *self) {
  PetscBool touches = RodsTouch(self->rods);

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n && !touches; k++) {
    PetscCall(RodsEnter(self->rods, k));
    PetscCall(OptionGiven("-wall_file", &touches));
    if (!touches) PetscCall(OptionGiven("-contact_self", &touches));
    PetscCall(RodsLeave(self->rods));
  }
  PetscCall(GrowTolerance(touches, &self->rtol, &self->eased));
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadOptions(Run *self) {
  PetscBool given, interval, number;
  PetscInt model, shapes;
  PetscReal every;

  PetscFunctionBegin;
  PetscCall(OptionGiven("-accuracy", &given));
  UserCheck(!given, OptionsComm(),
            "-accuracy: is not known of several rods in this version; give -ts_rtol and "
            "-rod_cells");
  PetscCall(OptionDefault("-rod_model", "space"));
  PetscCall(OptionWord("-rod_model", &model, NULL));
  UserCheck(model == SPACE || model == AUTO, OptionsComm(),
            "-rod_model: several rods are in space; take it out");
  PetscCall(ReadTolerance(self));
  PetscCall(OptionBool("-quiet", &self->quiet, NULL));
  PetscCall(OptionReal("-ts_max_time", &self->end, NULL));
  PetscCall(OptionInt("-output_shapes", &shapes, &number));
  PetscCall(OptionReal("-output_interval", &every, &interval));
  UserCheck(!(interval && number), OptionsComm(),
            "-output_shapes: -output_interval says already when shapes are stored; leave one out");
  if (!number && !interval && !self->file.path[0]) shapes = 1;
  self->interval = interval ? every : self->end / (PetscReal)shapes;
  PetscFunctionReturn(0);
}

/* ---- beginning ---- */

/* RodsMeet() */
static PetscErrorCode Meet(void *ctx, PetscInt a, PetscInt b, StrandMeeting *how) {
  PetscFunctionBegin;
  RodsMeet((Rods)ctx, a, b, how);
  PetscFunctionReturn(0);
}

/* The node of a rod at which it is held by a joint. */
static PetscInt HeldAt(const Run *self, const Joint *joint) {
  return joint->tip ? self->scene[joint->rod]->mesh.cells : 0;
}

/* Rods do not touch near a joint, neither those that are held in one place nor what holds them. */
static PetscErrorCode JoinStrands(const Run *self, Strands strands) {
  PetscFunctionBegin;
  for (PetscInt j = 0; j < JointsCount(self->joints); j++) {
    const Joint *joint = JointsGet(self->joints, j);
    const PetscInt of[2] = {joint->rod, joint->carrier}, at[2] = {HeldAt(self, joint), joint->node};
    PetscCall(StrandsJoin(strands, of, at));
    for (PetscInt k = 0; k < j; k++) {
      const Joint *other = JointsGet(self->joints, k);
      const PetscInt both[2] = {joint->rod, other->rod}, ends[2] = {at[0], HeldAt(self, other)};
      if (other->carrier == joint->carrier && other->node == joint->node)
        PetscCall(StrandsJoin(strands, both, ends));
    }
  }
  PetscFunctionReturn(0);
}

/* What looks for strands, if any rod can touch itself or another one. */
static PetscErrorCode MakeStrands(Run *self) {
  PetscBool any = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++)
    if (self->scene[k]->contact.among) any = PETSC_TRUE;
  for (int i = 0; i < 2 && any; i++)
    PetscCall(StrandsCreateSeveral(self->n, self->scene, Meet, self->rods, &self->strands[i]));
  for (int i = 0; i < 2 && any; i++) PetscCall(JoinStrands(self, self->strands[i]));
  RodForget(&self->looked);
  PetscFunctionReturn(0);
}

static PetscErrorCode MakeLeg(Run *self) {
  Rod *each, all;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(self->n, &each));
  for (PetscInt i = 0; i < self->n; i++) {
    const PetscInt k = JointsNext(self->joints, i);
    PetscCall(MakeScene(self, k, each));
    PetscCall(RodsEnter(self->rods, k));
    PetscCall(RodCreate(self->scene[k], &rod_space, &each[k]));
    PetscCall(RodFindUnits(each[k]));
    PetscCall(RodHoldTip(each[k]));
    PetscCall(RodsLeave(self->rods));
    if (self->scene[k]->contact.diameter <= 0) PetscCall(RodsRefuseThin(self->rods, k));
  }
  PetscCall(JointsClose(self->joints, self->rods, each));
  PetscCall(MakeStrands(self));
  PetscCall(SystemCreate(self->n, each, self->joints, self->strands[0], &all));
  PetscCall(PetscFree(each));
  PetscCall(LegCreateOf(all, self->rtol, &self->leg));
  UserCheck(self->leg.newton.elimination || all->coupled, OptionsComm(),
            "-ksp_, -pc_, -mat_ and the like are about a matrix, and several rods have none; take "
            "them out");
  PetscFunctionReturn(0);
}

/* Looks for strands in a state of all; U_t NULL: rates are not known. */
static PetscErrorCode LookForStrands(Run *self, PetscReal t, Vec U, Vec U_t) {
  StrandState state = {.t = t, .stride = self->leg.rod->model->fields};

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(U, &state.u));
  if (U_t) PetscCall(VecGetArrayRead(U_t, &state.u_t));
  PetscCall(StrandsSearch(self->strands[1], &state));
  PetscCall(StrandsLoad(self->strands[1], &state));
  if (U_t) PetscCall(VecRestoreArrayRead(U_t, &state.u_t));
  PetscCall(VecRestoreArrayRead(U, &state.u));
  PetscFunctionReturn(0);
}

/* ... at a time: that which has been come to, or one within the latest step, where the state is by
   the stepper's dense output. */
static PetscErrorCode LookAtTime(Run *self, PetscReal t, PetscBool moves) {
  const RodState *latest = &self->leg.newton.latest;
  PetscBool known;
  Vec U, U_t;

  PetscFunctionBegin;
  if (t == self->t) {
    PetscCall(LookForStrands(self, t, self->leg.U, moves ? latest->U_t : NULL));
    PetscFunctionReturn(0);
  }
  PetscCall(DMGetGlobalVector(self->leg.rod->da, &U));
  PetscCall(DMGetGlobalVector(self->leg.rod->da, &U_t));
  PetscCall(VBDFInterpolate(self->leg.ts, t, U, U_t, &known));
  if (!known) PetscCall(TSInterpolate(self->leg.ts, t, U));
  PetscCall(LookForStrands(self, t, U, moves && known ? U_t : NULL));
  PetscCall(DMRestoreGlobalVector(self->leg.rod->da, &U_t));
  PetscCall(DMRestoreGlobalVector(self->leg.rod->da, &U));
  PetscFunctionReturn(0);
}

/* ... once at a time. */
static PetscErrorCode KnowStrands(Run *self, PetscReal t, PetscBool moves) {
  const RodState at = {.t = t, .U = self->leg.U, .U_t = self->leg.U};
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(RodRecognise(&at, &self->looked, &known));
  if (!known || self->with_rates != moves) PetscCall(LookAtTime(self, t, moves));
  self->with_rates = moves;
  PetscFunctionReturn(0);
}

/* A TouchingTell. */
static PetscErrorCode TellStrands(void *ctx, PetscInt k, PetscReal t, PetscBool moves,
                                  StrandsOn *on) {
  Run *self = (Run *)ctx;
  const PetscInt first = 2 * StrandsFirst(self->strands[1], k);

  PetscFunctionBegin;
  PetscCall(KnowStrands(self, t, moves));
  StrandsSum(self->strands[1], k, &on->sum);
  on->force = StrandsForces(self->strands[1]) + first;
  on->couple = StrandsCouples(self->strands[1]) + first;
  PetscFunctionReturn(0);
}

/* Is any rod to come out in the run? Then all are looked at together. */
static PetscBool AnyToCome(const Run *self) {
  for (PetscInt k = 0; k < self->n; k++)
    if (self->scene[k]->born > 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Births end steps, and what a step of another kind comes to is at no birth. */
static PetscErrorCode CheckSteps(const Run *self) {
  PetscBool vbdf, fixed;
  TSAdapt adapt;

  PetscFunctionBegin;
  if (!AnyToCome(self)) PetscFunctionReturn(0);
  PetscCall(TSGetAdapt(self->leg.ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)self->leg.ts, TSVBDF, &vbdf));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &fixed));
  UserCheck(
      vbdf && !fixed, OptionsComm(),
      "-born: ends a step, and with -ts_type or -ts_adapt_type none steps end elsewhere; take "
      "these out");
  PetscFunctionReturn(0);
}

/* What is seen of one rod. */
static PetscErrorCode MakeSeen(Run *self, PetscInt k) {
  Grow *grow = &self->each[k];

  PetscFunctionBegin;
  grow->scene = self->scene[k];
  grow->model = SPACE;
  grow->rtol = self->rtol;
  grow->quiet = PETSC_TRUE;
  grow->end = self->end;
  grow->reach = grow->scene->reach;
  grow->now = &grow->leg[SPACE];
  grow->eased = grow->scene->contact.any ? self->eased : self->rtol;
  PetscCall(LegPart(&self->leg, k, grow->now));
  grow->now->ease.most = grow->eased / self->rtol;
  PetscCall(LegPartFollow(grow->now));
  if (self->estimate)
    PetscCall(EstimatePart(self->estimate, k, grow->now, &grow->estimate));
  else
    PetscCall(EstimateCreate(grow->now, &grow->estimate));
  PetscCall(ObserverCreate(grow->scene, &grow->observer));
  if (grow->scene->contact.among) ObserverAmong(grow->observer, TellStrands, self, k);
  PetscCall(OutputCreate("", grow->scene, &grow->output));
  PetscCall(OutputKeep(grow->output, PETSC_TRUE, PETSC_TRUE));
  if (GrowFollowsErrors(grow)) PetscCall(OutputFollows(grow->output));
  self->output[k] = grow->output;
  PetscFunctionReturn(0);
}

/* ---- what a run needs to go on ---- */

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

/* Keeps it in a file that is being written. */
static PetscErrorCode Keep(void *ctx, HdfFile file) {
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
  if (self->bears) state.points = state.order = 1; /* as Births() has it */
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

/* Reads it, and the rods of the file, which count unless the scene is given anew. */
static PetscErrorCode ReadRestart(Run *self) {
  char fault[WORDS_FAULT] = "", *text;
  PetscBool begun;

  PetscFunctionBegin;
  PetscCall(HdfHas(self->restart, "/restart/each", &begun));
  UserCheck(begun, OptionsComm(),
            "-restart %s: holds no run of several rods that has taken a step; run the scene anew",
            self->restart);
  PetscCall(HdfReadText("-restart", self->restart, "/rods/text", &text));
  UserCheck(WordsAddText(&self->words, self->restart, text, fault), OptionsComm(), "%s", fault);
  PetscCall(PetscFree(text));
  PetscCall(RememberedRead(self->restart, OptionsComm(), &self->from));
  PetscFunctionReturn(0);
}

/* The rods are those of the file, in its order. */
static PetscErrorCode CheckSame(const Run *self) {
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

/* What each remembers. */
static PetscErrorCode ReadEach(Run *self) {
  char text[64];

  PetscFunctionBegin;
  UserCheck(self->end > self->from.t * (1 + 1e-12), OptionsComm(),
            "-restart %s: is at t = %s already; give a later -ts_max_time", self->restart,
            OptionBoth(self->from.t, UNIT_TIME, text));
  PetscCall(PetscMalloc1(self->n, &self->own));
  PetscCall(RememberedReadEach(self->restart, OptionsComm(), self->n, self->own));
  PetscFunctionReturn(0);
}

/* The tolerance of all is the finest of theirs, and each has its own: what contact puts one off by
   says nothing of one that is free. */
static void EaseEach(Run *self, PetscReal finest) {
  self->leg.ease.times = finest;
  for (PetscInt k = 0; k < self->n; k++)
    self->leg.of[k].eased = self->each[k].now->ease.times / finest;
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

/* All of them do. */
static PetscErrorCode GoOn(Run *self) {
  Vec errors[ESTIMATE_KEPT];
  char text[64];

  PetscFunctionBegin;
  PetscCall(RestartTake(self->restart, &self->from, &self->leg));
  for (int i = 0; i < ESTIMATE_KEPT; i++) PetscCall(VecDuplicate(self->leg.U, &errors[i]));
  PetscCall(RestartReadErrors(self->restart, &self->from, PETSC_COMM_SELF, errors));
  for (PetscInt k = 0; k < self->n; k++) PetscCall(GoOnEach(self, k, errors));
  EaseEach(self, self->from.ease);
  for (int i = 0; i < ESTIMATE_KEPT; i++) PetscCall(VecDestroy(&errors[i]));
  self->t = self->start = self->stored_shape = self->from.t;
  self->snaps = (PetscInt)self->from.kept.snaps;
  PetscCall(PetscArraycpy(self->counted, self->from.counted, 2));
  PetscCall(SeveralTake(&self->file, self->restart, self->t, self->interval));
  self->next_output = OutputNext(self->t, self->interval);
  if (!self->quiet)
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "goes on from t = %s of %s, into %s\n",
                          OptionBoth(self->t, UNIT_TIME, text), self->restart, self->file.path));
  PetscFunctionReturn(0);
}

/* ---- steps ---- */

/* The errors of rods that hold each other go on. */
static PetscErrorCode FollowErrors(Run *self) {
  PetscBool pressed = PETSC_FALSE;
  PetscInt jumps;

  PetscFunctionBegin;
  PetscCall(VBDFGetJumps(self->leg.ts, &jumps));
  for (PetscInt k = 0; k < self->n; k++)
    if (self->each[k].kept.pressed) pressed = PETSC_TRUE;
  PetscCall(EstimateStep(self->estimate, (PetscBool)(jumps > self->leg.jumps), pressed));
  self->leg.jumps = jumps;
  PetscFunctionReturn(0);
}

/* What each is put off by, as what presses it gives. */
static PetscErrorCode TakeGives(Run *self, PetscReal t) {
  StrandSum on;

  PetscFunctionBegin;
  if (!self->strands[1]) PetscFunctionReturn(0);
  PetscCall(KnowStrands(self, t, PETSC_TRUE));
  for (PetscInt k = 0; k < self->n; k++) {
    StrandsSum(self->strands[1], k, &on);
    EstimateGives(self->each[k].estimate, on.gives);
  }
  PetscFunctionReturn(0);
}

/* Rods whose time has come are born: from now on they are there. All go on from there as from a
   change: steps begin anew, short. */
static PetscErrorCode Births(Run *self, PetscReal t) {
  PetscReal step;

  PetscFunctionBegin;
  self->bears = PETSC_FALSE;
  for (PetscInt k = 0; k < self->n; k++) {
    if (!self->to_come[k] || SceneToCome(self->scene[k], t)) continue;
    PetscCall(BirthPlace(self->leg.rod, self->joints, k, t, self->leg.U));
    self->bears = PETSC_TRUE;
  }
  if (!self->bears) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < self->n; k++) self->each[k].kept.changed = PETSC_TRUE;
  PetscCall(VBDFBeginAnew(self->leg.ts));
  PetscCall(TSGetTimeStep(self->leg.ts, &step));
  PetscCall(TSSetTimeStep(self->leg.ts, PetscMin(step, grow_rule.again_step * self->end)));
  PetscFunctionReturn(0);
}

/* Looks at one of them. */
static PetscErrorCode LookAt(Run *self, PetscInt k, PetscReal t, PetscBool begins) {
  Grow *grow = &self->each[k];
  const Leg *leg = grow->now;

  PetscFunctionBegin;
  PetscCall(LegPartFollow(grow->now));
  if (SceneToCome(self->scene[k], t))
    PetscCall(GrowUnseen(grow, t));
  else if (self->to_come[k])
    PetscCall(GrowBorn(grow, t));
  else
    PetscCall(GrowObserve(grow, t, begins ? NULL : leg->U, begins ? NULL : leg->newton.latest.U_t));
  self->to_come[k] = SceneToCome(self->scene[k], t);
  PetscFunctionReturn(0);
}

/* Looks at all rods, at a time; begins: as they begin. */
static PetscErrorCode Look(Run *self, PetscReal t, PetscBool begins) {
  PetscReal times = PETSC_MAX_REAL;

  PetscFunctionBegin;
  self->t = t;
  if (!begins) PetscCall(TakeGives(self, t));
  if (!begins) PetscCall(FollowErrors(self));
  if (!begins) PetscCall(Births(self, t));
  for (PetscInt k = 0; k < self->n; k++) {
    PetscCall(LookAt(self, k, t, begins));
    times = PetscMin(times, self->each[k].now->ease.times);
  }
  EaseEach(self, times);
  PetscFunctionReturn(0);
}

/* Stores the shapes of a state of all; U NULL: as they begin. */
static PetscErrorCode StoreShape(Run *self, PetscReal t, Vec U) {
  StrandPlace *place;
  Vec part = NULL;
  PetscInt n;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    if (U) PetscCall(RodPartOpenRead(self->leg.rod, k, U, &part));
    PetscCall(
        (SceneToCome(self->scene[k], t) ? GrowNoShape : GrowStoreShape)(&self->each[k], t, part));
    if (U) PetscCall(RodPartCloseRead(self->leg.rod, k, U, &part));
  }
  self->stored_shape = t;
  if (!self->strands[1]) PetscFunctionReturn(0);
  PetscCall(KnowStrands(self, t, (PetscBool)(t > 0)));
  PetscCall(StrandsPlaces(self->strands[1], &n, &place));
  PetscCall(SeveralTouch(&self->file, n, place));
  PetscCall(PetscFree(place));
  PetscFunctionReturn(0);
}

/* Those that are due between the previous step and this one, by the stepper's dense output. */
static PetscErrorCode StoreDue(Run *self, PetscReal t) {
  Vec W;

  PetscFunctionBegin;
  for (; self->next_output <= t * (1 + 1e-14); self->next_output += self->interval) {
    if (self->next_output >= t * (1 - 1e-12)) {
      PetscCall(StoreShape(self, t, self->leg.U));
      continue;
    }
    PetscCall(VecDuplicate(self->leg.U, &W));
    PetscCall(TSInterpolate(self->leg.ts, self->next_output, W));
    PetscCall(StoreShape(self, self->next_output, W));
    PetscCall(VecDestroy(&W));
  }
  PetscFunctionReturn(0);
}

/* Dry friction that does not say how fast rods snap has a viscous share from here on. */
static PetscBool ShareMore(Run *self, PetscBool again) {
  PetscBool more = PETSC_FALSE;

  for (PetscInt k = 0; k < self->n; k++) {
    Load *load = &self->scene[k]->load;
    if (again ? !LoadMaySlip(load) : load->shared) continue;
    if (LoadShareMore(load)) more = PETSC_TRUE;
  }
  return more;
}

static PetscErrorCode Progress(Run *self, PetscBool last) {
  PetscReal length = 0, time, unit;
  char left[32];

  PetscFunctionBegin;
  if (self->quiet || !GrowPaceDue(&self->pace, self->start, self->t, self->end, last, left))
    PetscFunctionReturn(0);
  for (PetscInt k = 0; k < self->n; k++) length = PetscMax(length, self->each[k].seen.length);
  (void)OptionShownIn(self->end, UNIT_TIME, &time);
  (void)OptionShownIn(length, UNIT_LENGTH, &unit);
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "%10.4f %10.4f %10.2e %7d %s\n", (double)(time * self->t),
                        (double)(unit * length), (double)(time * self->each[0].seen.step),
                        (int)self->each[0].seen.newton_iterations, left));
  PetscFunctionReturn(0);
}

/* Looks at the step just taken. */
static PetscErrorCode AfterStep(TS ts) {
  TSConvergedReason reason;
  PetscReal t, speed;
  PetscBool begins;
  Leg *leg;
  Run *self;

  PetscFunctionBegin;
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (reason < 0) PetscFunctionReturn(0); /* called after a step that failed, too */
  PetscCall(TSGetApplicationContext(ts, &leg));
  self = (Run *)leg->owner;
  PetscCall(TSGetTime(ts, &t));
  if (!reason && t >= self->end) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_TIME));
  PetscCall(Look(self, t, PETSC_FALSE));
  PetscCall(LegSpeed(&self->leg, &speed, &begins));
  self->snaps += begins;
  if (begins) (void)ShareMore(self, PETSC_FALSE);
  PetscCall(StoreDue(self, t));
  PetscCall(Progress(self, PETSC_FALSE));
  self->stopped = SignalCaught();
  if (self->stopped) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  if (SeveralDue(&self->file)) PetscCall(SeveralStore(&self->file, t, PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* Rods in dry friction that find no step try again with a viscous share, or a larger one. */
static PetscErrorCode Solve(Run *self) {
  PetscBool again = PETSC_TRUE;

  PetscFunctionBegin;
  while (again) {
    PetscCall(TSSolve(self->leg.ts, self->leg.U));
    PetscCall(TSGetConvergedReason(self->leg.ts, &self->reason));
    again = (PetscBool)(self->reason < 0 && !self->stopped && ShareMore(self, PETSC_TRUE));
    if (!again) continue;
    PetscCall(TSRestartStep(self->leg.ts));
    PetscCall(TSSetTimeStep(self->leg.ts, grow_rule.again_step * self->end));
  }
  PetscCall(Progress(self, PETSC_TRUE));
  PetscFunctionReturn(0);
}

/* ---- the end ---- */

/* A line for each rod. */
static PetscErrorCode TellRods(Run *self) {
  char text[4][64];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    const Observation *seen = &self->each[k].seen;
    const ErrorEstimate *error = &self->each[k].error;
    if (self->to_come[k]) {
      PetscCall(PetscPrintf(PETSC_COMM_SELF, "%s: is born at %s\n", RodsName(self->rods, k),
                            OptionBoth(self->scene[k]->born, UNIT_TIME, text[0])));
      continue;
    }
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "%s: length %s, tip (%s, %s, %s)",
                          RodsName(self->rods, k), OptionNumber(seen->length, text[0]),
                          OptionNumber(seen->tip_x1, text[1]), OptionNumber(seen->tip_x2, text[2]),
                          OptionNumber(seen->tip_x3, text[3])));
    PetscCall(PetscPrintf(PETSC_COMM_SELF, ", energy %.6e, its defect %.1e", (double)seen->energy,
                          (double)seen->energy_defect));
    if (error->kind != ESTIMATE_NONE)
      PetscCall(PetscPrintf(PETSC_COMM_SELF, ", error estimate %.1e", (double)error->end.all));
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "\n"));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Summary(Run *self) {
  PetscInt steps, rejected, iterations;
  PetscLogDouble now;
  char text[64];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    PetscCall(GrowErrors(&self->each[k]));
    PetscCall(OutputErrors(self->output[k], &self->each[k].error));
  }
  if (self->quiet) PetscFunctionReturn(0);
  PetscCall(TSGetStepNumber(self->leg.ts, &steps));
  PetscCall(TSGetStepRejections(self->leg.ts, &rejected));
  PetscCall(TSGetSNESIterations(self->leg.ts, &iterations));
  PetscCall(PetscTime(&now));
  PetscCall(TellRods(self));
  PetscCall(PetscPrintf(PETSC_COMM_SELF,
                        "t = %s: %d rods, %d steps, %d rejected, %d Newton iterations, %.3f s",
                        OptionBoth(self->t, UNIT_TIME, text), (int)self->n, (int)steps,
                        (int)(rejected + self->counted[1]), (int)(iterations + self->counted[0]),
                        now - self->pace.begin));
  if (self->snaps)
    PetscCall(
        PetscPrintf(PETSC_COMM_SELF, "; %d snap%s", (int)self->snaps, self->snaps > 1 ? "s" : ""));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "\n"));
  if (!self->file.path[0])
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "nothing is stored; -output FILE keeps the result\n"));
  PetscFunctionReturn(0);
}

/* The rod whose fields move fastest in the latest step: what a line for a run that gave up names.
 */
static PetscInt Fastest(const Run *self) {
  PetscInt which = 0;

  for (PetscInt k = 1; k < self->n; k++)
    if (self->each[k].seen.tip_speed > self->each[which].seen.tip_speed) which = k;
  return which;
}

static PetscErrorCode Verdict(Run *self) {
  const char *const kept = self->file.path[0] ? "the results up to there are stored"
                                              : "nothing is stored without "
                                                "-output FILE";
  char t[64], step[64];
  PetscReal dt;

  PetscFunctionBegin;
  PetscCall(TSGetTimeStep(self->leg.ts, &dt));
  OptionBoth(self->t, UNIT_TIME, t);
  OptionBoth(dt, UNIT_TIME, step);
  UserCheck(!self->stopped, PETSC_COMM_SELF, "interrupted by signal %d at t = %s; %s",
            self->stopped, t, kept);
  UserCheck(self->reason != TS_CONVERGED_ITS, PETSC_COMM_SELF,
            "-ts_max_steps: reached at t = %s before -ts_max_time; %s", t, kept);
  UserCheck(self->reason == TS_CONVERGED_TIME, PETSC_COMM_SELF,
            "gave up at t = %s with a step of %s%s; %s; rod %s moves fastest: run it alone, which "
            "tells more, or give more -rod_cells",
            t, step, self->leg.passes ? ": a rod would pass through a wall" : "", kept,
            RodsName(self->rods, Fastest(self)));
  PetscFunctionReturn(0);
}

static PetscErrorCode Finish(Run *self) {
  char text[2][64] = {""};

  PetscFunctionBegin;
  PetscCall(Summary(self));
  if (self->t != self->stored_shape) PetscCall(StoreShape(self, self->t, self->leg.U));
  if (self->stopped)
    (void)snprintf(text[0], sizeof(text[0]), "by signal %d at t = %.30s", self->stopped,
                   OptionBoth(self->t, UNIT_TIME, text[1]));
  for (PetscInt k = 0; k < self->n; k++) PetscCall(OutputInterrupted(self->output[k], text[0]));
  PetscCall(SeveralStore(&self->file, self->t, (PetscBool)(self->reason == TS_CONVERGED_TIME)));
  PetscCall(Verdict(self));
  PetscFunctionReturn(0);
}

/* Refuses rods that begin within each other. */
static PetscErrorCode CheckApart(Run *self, PetscInt k) {
  const Contact *contact = &self->scene[k]->contact;
  char depth[64], place[96];
  StrandsOn on;

  PetscFunctionBegin;
  if (!contact->among) PetscFunctionReturn(0);
  PetscCall(TellStrands(self, k, 0, PETSC_FALSE, &on));
  UserCheck(on.sum.rod == k || on.sum.nearest >= -contact->smooth, OptionsComm(),
            "rods %s and %s are %s deep in each other at the start, at %s; give one another "
            "-clamp_place, or take -contact false for [pair %s %s]",
            RodsName(self->rods, k), RodsName(self->rods, on.sum.rod),
            OptionBoth(-on.sum.nearest, UNIT_LENGTH, depth), OptionPlace(on.sum.x, place),
            RodsName(self->rods, k), RodsName(self->rods, on.sum.rod));
  PetscFunctionReturn(0);
}

/* Each begins where it can, all of them being where they begin. */
static PetscErrorCode CheckStarts(Run *self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n && !self->restart[0]; k++) PetscCall(CheckApart(self, k));
  for (PetscInt k = 0; k < self->n && !self->restart[0]; k++) {
    if (self->to_come[k]) continue;
    PetscCall(RodsEnter(self->rods, k));
    PetscCall(GrowCheckStart(&self->each[k]));
    PetscCall(RodsLeave(self->rods));
  }
  PetscFunctionReturn(0);
}

/* Refuses rods that hold each other in a ring if what they bear there is not determined. */
static PetscErrorCode CheckRings(Run *self) {
  const Joint *closes = NULL;
  PetscBool determined;

  PetscFunctionBegin;
  for (PetscInt j = 0; j < JointsCount(self->joints) && !closes; j++)
    if (JointsGet(self->joints, j)->tip) closes = JointsGet(self->joints, j);
  if (!closes) PetscFunctionReturn(0);
  PetscCall(NewtonDetermines(&self->leg.newton, self->leg.U, 1 / RodUnits(self->leg.rod)->time,
                             &determined));
  PetscCall(RodsEnter(self->rods, closes->rod));
  UserCheck(determined, OptionsComm(),
            "-tip_on %s: rods that are straight do not stretch, and of this ring of them what they "
            "bear is not determined; bend one (-shape_amplitude), or leave a joint out",
            RodsName(self->rods, closes->carrier));
  PetscCall(RodsLeave(self->rods));
  PetscFunctionReturn(0);
}

static PetscErrorCode Begin(Run *self) {
  const OptionWords *given = &OptionsLine()->taken;

  PetscFunctionBegin;
  if (self->restart[0]) PetscCall(ReadRestart(self));
  PetscCall(RodsRead(given->sections ? given : &self->words, &self->rods));
  self->n = RodsCount(self->rods);
  UserCheck(self->n > 0, OptionsComm(), "[rods]: the table has no row, and so there is no rod");
  if (self->restart[0]) PetscCall(CheckSame(self));
  PetscCall(ReadOptions(self));
  if (self->restart[0]) PetscCall(ReadEach(self));
  PetscCall(JointsRead(self->rods, &self->joints));
  PetscCall(PetscCalloc4(self->n, &self->scene, self->n, &self->each, self->n, &self->output,
                         self->n, &self->to_come));
  PetscCall(MakeLeg(self));
  self->leg.owner = self;
  PetscCall(TSSetMaxTime(self->leg.ts, self->end));
  PetscCall(TSSetPostStep(self->leg.ts, AfterStep));
  PetscCall(LegEndAtTurns(&self->leg));
  PetscCall(CheckSteps(self));
  if (JointsCount(self->joints) || AnyToCome(self))
    PetscCall(EstimateCreate(&self->leg, &self->estimate));
  for (PetscInt k = 0; k < self->n; k++) {
    PetscCall(RodsEnter(self->rods, k));
    PetscCall(MakeSeen(self, k));
    if (!self->restart[0]) PetscCall(RodBegin(self->each[k].now->rod, self->each[k].now->U));
    PetscCall(RodsLeave(self->rods));
  }
  PetscCall(CheckStarts(self));
  if (!self->restart[0]) PetscCall(CheckRings(self));
  PetscCall(RodsRefuseUnread(self->rods));
  PetscCall(OptionsRefuseUnread());
  self->file.rods = self->rods;
  self->file.joints = self->joints;
  self->file.n = self->n;
  self->file.touch = (PetscBool)(self->strands[1] != NULL);
  self->file.each = self->output;
  self->file.keep = Keep;
  self->file.ctx = self;
  PetscCall(SeveralBegin(&self->file));
  self->begun = PETSC_TRUE;
  if (self->restart[0])
    PetscCall(GoOn(self));
  else {
    PetscCall(Look(self, 0, PETSC_TRUE));
    PetscCall(StoreShape(self, 0, NULL));
    self->next_output = self->interval;
  }
  self->ready = PETSC_TRUE;
  PetscCall(SeveralStore(&self->file, self->t, PETSC_FALSE)); /* what cannot be written shows */
  PetscFunctionReturn(0);
}

/* Rods that have a diameter and do not touch each other all the same. */
static PetscErrorCode TellApart(const Run *self) {
  PetscInt thick = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) thick += self->scene[k]->contact.diameter > 0;
  if (thick > 1 && !RodsTouch(self->rods))
    PetscCall(PetscPrintf(PETSC_COMM_SELF,
                          "-contact_diameter: rods pass through each other; with -contact_rods, or "
                          "a section [pair NAME NAME], they do not\n"));
  PetscFunctionReturn(0);
}

static PetscErrorCode Heading(Run *self) {
  PetscReal factor;
  const char *unit = OptionShownIn(self->end, UNIT_TIME, &factor);

  PetscFunctionBegin;
  PetscCall(GrowPaceBegin(&self->pace));
  if (self->quiet) PetscFunctionReturn(0);
  PetscCall(OptionsTellPlain());
  PetscCall(TellApart(self));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "%d rods%s%s\n%10s %10s %10s %7s %11s\n", (int)self->n,
                        unit ? "; times in " : "", unit ? unit : "", "t", "longest", "step",
                        "Newton", "time left"));
  PetscFunctionReturn(0);
}

static PetscErrorCode BeginAndRun(Run *self) {
  PetscFunctionBegin;
  PetscCall(Begin(self));
  SignalsCatch();
  PetscCall(Heading(self));
  PetscCall(Solve(self));
  PetscCall(Finish(self));
  PetscFunctionReturn(0);
}

static PetscErrorCode End(Run *self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n && self->each; k++) {
    PetscCall(OutputDestroy(&self->each[k].output));
    PetscCall(ObserverDestroy(&self->each[k].observer));
    PetscCall(EstimateDestroy(&self->each[k].estimate));
    PetscCall(LegPartEnd(&self->each[k].leg[SPACE]));
  }
  PetscCall(EstimateDestroy(&self->estimate));
  PetscCall(LegDestroy(&self->leg));
  for (int i = 0; i < 2; i++) PetscCall(StrandsDestroy(&self->strands[i]));
  for (PetscInt k = 0; k < self->n && self->scene; k++) PetscCall(SceneDestroy(&self->scene[k]));
  PetscCall(PetscFree4(self->scene, self->each, self->output, self->to_come));
  if (self->begun) PetscCall(SeveralEnd(&self->file));
  PetscCall(JointsDestroy(&self->joints));
  PetscCall(RodsDestroy(&self->rods));
  PetscCall(PetscFree(self->own));
  WordsFree(&self->words);
  PetscFunctionReturn(0);
}

/* SeveralRun - follows the rods of a scene from t = 0 to its end time. Each is on this rank, and
   several ranks are refused. */
PetscErrorCode SeveralRun(const Single *asked) {
  const OptionWords *given = &OptionsLine()->taken;
  const char *head = given->sections ? given->section[0].head : "rod";
  Run run = {.restart = asked->restart};
  PetscErrorCode error;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(OptionsComm(), &ranks));
  UserCheck(ranks == 1, OptionsComm(),
            "[%s]: several rods run on one rank in this version; start without mpiexec", head);
  UserCheck(asked->task == TASK_GROW, OptionsComm(),
            "[%s]: this -task knows one rod; take the sections out, or the -task", head);
  PetscCall(PetscStrncpy(run.file.path, asked->output[0] ? asked->output : asked->restart,
                         sizeof(run.file.path)));
  error = BeginAndRun(&run);
  if (error && run.ready) (void)SeveralStore(&run.file, run.t, PETSC_FALSE);
  PetscCall(End(&run));
  PetscCall(error);
  PetscFunctionReturn(0);
}
