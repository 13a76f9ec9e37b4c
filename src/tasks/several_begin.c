/* -task grow of several rods: what is asked for, and how they begin. */
#include "tasks/several_run.h"
#include "rod/ask.h"
#include "system/model.h"
#include "tasks/single.h"

/* Refuses what several rods together cannot yet. */
static PetscErrorCode CheckRod(const Scene scene) {
  PetscFunctionBegin;
  UserCheck(!scene->tropism.any, OptionsComm(),
            "-tropism_ options and -growth_ironing: several rods do not know of a natural "
            "curvature that the material learns in this version; take them out");
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
  PetscCall(JointsDouble(self->joints, self->rods, k, scene));
  if (!self->restart[0]) PetscFunctionReturn(0);
  PetscCall(SeveralLabels(self->restart, k, scene));
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
  PetscCall(RunAccuracy(self, touches));
  PetscCall(GrowTolerance(touches, &self->rtol, &self->eased));
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadOptions(Run *self) {
  PetscBool interval, number;
  PetscInt model, shapes;
  PetscReal every;

  PetscFunctionBegin;
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
  if (!number && !interval && !self->file.path[0] && !self->by_steps) shapes = 1;
  self->interval = interval ? every : self->end / (PetscReal)shapes;
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
  PetscCall(RunMakeStrands(self));
  PetscCall(SystemCreate(self->n, each, self->joints, self->strands[0], &all));
  PetscCall(PetscFree(each));
  PetscCall(LegCreateOf(all, self->rtol, &self->leg));
  UserCheck(self->leg.newton.elimination || all->coupled, OptionsComm(),
            "-ksp_, -pc_, -mat_ and the like are about a matrix, and several rods have none; take "
            "them out");
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
  grow->by_steps = self->by_steps;
  grow->end = self->end;
  grow->reach = grow->scene->reach;
  grow->now = &grow->leg[SPACE];
  grow->eased = grow->scene->contact.any ? self->eased : self->rtol;
  PetscCall(LegPart(&self->leg, k, grow->now));
  grow->now->ease.most = grow->eased / self->rtol;
  PetscCall(LegPartFollow(grow->now));
  if (JointsCount(self->joints))
    PetscCall(EstimatePart(self->estimate, k, grow->now, &grow->estimate));
  else
    PetscCall(EstimateCreate(grow->now, &grow->estimate));
  PetscCall(WatchSetFromOptions(&grow->watch, grow->scene));
  PetscCall(ObserverCreate(grow->scene, &grow->observer));
  if (grow->scene->contact.among) ObserverAmong(grow->observer, RunTellStrands, self, k);
  PetscCall(OutputCreate("", grow->scene, &grow->output));
  PetscCall(OutputKeep(grow->output, PETSC_TRUE, PETSC_TRUE));
  if (GrowFollowsErrors(grow)) PetscCall(OutputFollows(grow->output));
  self->output[k] = grow->output;
  PetscFunctionReturn(0);
}

/* Refuses rods that begin within each other. */
static PetscErrorCode CheckApart(Run *self, PetscInt k) {
  const Contact *contact = &self->scene[k]->contact;
  char depth[64], place[96];
  StrandsOn on;

  PetscFunctionBegin;
  if (!contact->among) PetscFunctionReturn(0);
  PetscCall(RunTellStrands(self, k, 0, PETSC_FALSE, &on));
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

/* RunBegin - the rods of the scene as they begin, or as the file has them from which they go
   on. The caller ends it with RunEnd(), also after an error. */
PetscErrorCode RunBegin(Run *self) {
  const OptionWords *given = &OptionsLine()->taken;

  PetscFunctionBegin;
  if (self->restart[0]) PetscCall(RunReadRestart(self));
  if (!self->rods) PetscCall(RodsRead(given->sections ? given : &self->words, &self->rods));
  self->n = RodsCount(self->rods);
  UserCheck(self->n > 0, OptionsComm(), "[rods]: the table has no row, and so there is no rod");
  if (self->restart[0]) PetscCall(RunCheckSame(self));
  PetscCall(ReadOptions(self));
  if (self->restart[0]) PetscCall(RunReadEach(self));
  PetscCall(JointsRead(self->rods, &self->joints));
  PetscCall(PetscCalloc3(self->n, &self->scene, self->n, &self->each, self->n, &self->output));
  PetscCall(MakeLeg(self));
  PetscCall(RunTakeChanges(self));
  self->leg.owner = self;
  self->enters = PETSC_TRUE;
  self->U = self->leg.U;
  PetscCall(TSSetMaxTime(self->leg.ts, self->end));
  PetscCall(TSSetPostStep(self->leg.ts, RunAfterStep));
  PetscCall(LegEndAtTurns(&self->leg));
  if (JointsCount(self->joints)) PetscCall(EstimateCreate(&self->leg, &self->estimate));
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
  self->file.keep = RunKeep;
  self->file.ctx = self;
  PetscCall(SeveralBegin(&self->file));
  self->begun = PETSC_TRUE;
  if (self->restart[0])
    PetscCall(RunGoOn(self));
  else {
    PetscCall(RunRefuseEvents(self));
    PetscCall(RunLook(self, 0, PETSC_TRUE));
    PetscCall(RunStoreShape(self, 0, NULL));
    self->next_output = self->interval;
  }
  self->ready = PETSC_TRUE;
  PetscCall(SeveralStore(&self->file, self->t, PETSC_FALSE)); /* what cannot be written shows */
  PetscFunctionReturn(0);
}

PetscErrorCode RunEnd(Run *self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n && self->each; k++) {
    PetscCall(OutputDestroy(&self->each[k].output));
    PetscCall(ObserverDestroy(&self->each[k].observer));
    PetscCall(EstimateDestroy(&self->each[k].estimate));
    PetscCall(LegPartEnd(&self->each[k].leg[SPACE]));
  }
  for (int i = 0; i < 2; i++) PetscCall(VecDestroy(&self->here[i]));
  PetscCall(EstimateDestroy(&self->estimate));
  PetscCall(LegDestroy(&self->leg));
  for (int i = 0; i < 2; i++) PetscCall(StrandsDestroy(&self->strands[i]));
  for (PetscInt k = 0; k < self->n && self->scene; k++) PetscCall(SceneDestroy(&self->scene[k]));
  PetscCall(PetscFree3(self->scene, self->each, self->output));
  if (self->begun) PetscCall(SeveralEnd(&self->file));
  PetscCall(JointsDestroy(&self->joints));
  PetscCall(RodsDestroy(&self->rods));
  PetscCall(PetscFree(self->own));
  PetscCall(PetscFree(self->finer));
  WordsFree(&self->words);
  PetscFunctionReturn(0);
}
