/* -task grow: the models that take turns, and what the linear one leaves out. */
#include "tasks/accuracy.h"
#include "tasks/growing.h"
#include "rod/rules.h"
#include "tasks/grow_rules.h"

const RodModel *const grow_models[MODELS] = {&rod_linear, &rod_frame, &rod_mixed, &rod_space};

/* GrowModelOf - one of these; the linear one is another for a rod in space. */
const RodModel *GrowModelOf(const Grow *self, PetscInt model) {
  return model == LINEAR && self->scene->space.rod ? &rod_linear_space : grow_models[model];
}

/* GrowWholeModel - the model of auto that leaves nothing out. */
PetscInt GrowWholeModel(const Grow *self) {
  return self->scene->space.rod ? SPACE : FRAME;
}

/* GrowOwnLeg - that of the model that was asked for; of auto, of that one. */
Leg *GrowOwnLeg(Grow *self) {
  return &self->leg[self->model == AUTO ? GrowWholeModel(self) : self->model];
}

/* GrowBetterModel - which to go on with. auto takes the linear model while what it leaves out
   (GrowNeglect()) is below the tolerance of a step, and takes it up again only when well below, so
   that it does not flicker. */
PetscInt GrowBetterModel(const Grow *self) {
  const PetscReal neglected = PetscMax(self->neglects, PetscSqr(self->seen.max_angle));
  const PetscInt whole = GrowWholeModel(self);
  if (self->model != AUTO) return self->model;
  if (!self->can[LINEAR]) return whole;
  if (self->now == &self->leg[LINEAR])
    return neglected > grow_rule.linear_until * self->rtol ? whole : LINEAR;
  return neglected < grow_rule.linear_again * self->rtol ? LINEAR : whole;
}

/* GrowWeigh - how much the linear model's energy changes, which tells of the deflection where |x2|
   is that of a clamp that leans. And its e-foldings once more, as what steps have added in each
   weighs in the energy: it may be in short waves, small beside |x2|, and when these are what is
   left, as the root of the energy over |x2| tells, it weighs so much more. */
void GrowWeigh(Grow *self, const Observation *last, PetscReal efoldings) {
  const PetscReal size = PetscMax(self->seen.norm_x2, self->seen.norm_x3),
                  before = PetscMax(last->norm_x2, last->norm_x3);
  PetscReal grown;

  if (self->kept.weighed == 0) self->kept.weighed = FEWEST_EFOLDINGS;
  if (self->now == &self->leg[LINEAR] && PetscMin(size, before) > rod_rule.vanished &&
      PetscMin(self->seen.energy, last->energy) > grow_rule.energy_vanished) {
    grown = self->seen.energy / last->energy;
    self->kept.energy_folds += PetscAbsReal(PetscLogReal(grown));
    self->kept.weighed *= PetscSqrtReal(grown) * before / size;
  }
  self->kept.weighed += efoldings;
}

/* GrowNeglect - the linear model leaves out terms of the square of the angle and, in friction, of
   the square of the speed across the rod over that along it: of about 1, or, of a part that is at
   rest, of what there is in its place, the root of beta. */
PetscErrorCode GrowNeglect(Grow *self, Vec U_t) {
  const RodModel *model = self->now->rod->model;
  const Load *load = &self->scene->load;
  PetscReal speed[MAX_FIELDS] = {0}, across = 0;

  PetscFunctionBegin;
  if (self->model != LINEAR && self->model != AUTO) PetscFunctionReturn(0);
  if (U_t) PetscCall(RodFieldSizes(self->now->rod, U_t, speed));
  for (PetscInt f = 0; f < model->fields; f++)
    if (!strcmp(model->field[f], "y") || !strcmp(model->field[f], "x2") ||
        !strcmp(model->field[f], "x3"))
      across = PetscMax(across, speed[f]);
  self->neglects = PetscSqr(across);
  if (load->resolved > 0 && load->friction.mu > 0) self->neglects /= load->friction.beta;
  self->neglects = PetscMax(self->neglects, PetscSqr(self->seen.max_angle));
  if (self->model == LINEAR) self->kept.neglected = PetscMax(self->kept.neglected, self->neglects);
  PetscFunctionReturn(0);
}

/* GrowAddLeg - makes a model ready to work. Collective. */
PetscErrorCode GrowAddLeg(Grow *self, PetscInt model) {
  Leg *leg = &self->leg[model];

  PetscFunctionBegin;
  PetscCall(LegCreate(self->scene, GrowModelOf(self, model), self->rtol, leg));
  leg->owner = self;
  leg->ease.most = self->eased / self->rtol;
  PetscCall(TSSetMaxTime(leg->ts, self->scene->end_time));
  PetscCall(TSSetPostStep(leg->ts, GrowAfterStep));
  PetscCall(LegEndAtTurns(leg));
  PetscFunctionReturn(0);
}

/* The same state in another model's unknowns. */
static PetscErrorCode Convert(Leg *from, Leg *to, PetscReal t, Vec U, Vec V) {
  Node *nodes;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(from->rod->end - from->rod->first, &nodes));
  PetscCall(from->rod->model->get(from->rod, t, U, NULL, nodes));
  PetscCall(to->rod->model->set(to->rod, t, nodes, V));
  PetscCall(PetscFree(nodes));
  PetscFunctionReturn(0);
}

/* GrowHandOver - hands time, state, step and history over to another model. */
PetscErrorCode GrowHandOver(Grow *self, Leg *to) {
  Leg *from = self->now;
  PetscReal t, dt, times[VBDF_POINTS];
  PetscInt n, order, steps;
  char text[64];
  Vec old[VBDF_POINTS], new[VBDF_POINTS];

  PetscFunctionBegin;
  PetscCall(TSGetTime(from->ts, &t));
  PetscCall(TSGetTimeStep(from->ts, &dt));
  PetscCall(TSGetStepNumber(from->ts, &steps));
  PetscCall(TSSetTime(to->ts, t));
  PetscCall(TSSetTimeStep(to->ts, dt));
  PetscCall(TSSetStepNumber(to->ts, steps));
  PetscCall(Convert(from, to, t, from->U, to->U));
  PetscCall(VBDFGetHistory(from->ts, &n, times, old, &order));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(VecDuplicate(to->U, &new[i]));
    PetscCall(Convert(from, to, t + times[i], old[i], new[i]));
  }
  PetscCall(VBDFSetHistory(to->ts, n, times, new, order));
  for (PetscInt i = 0; i < n; i++) PetscCall(VecDestroy(&new[i]));
  PetscCall(TSGetSNESIterations(to->ts, &self->iterations));
  self->now = to;
  if (!self->quiet)
    PetscCall(PetscPrintf(self->scene->comm, "t = %s: from the %s to the %s model\n",
                          OptionBoth(t, UNIT_TIME, text), from->rod->model->name,
                          to->rod->model->name));
  PetscFunctionReturn(0);
}
