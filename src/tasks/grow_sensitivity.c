/* -task grow: -sensitivity, derivatives of all that is stored by numbers of the scene.

   Of each number there are two shadows of the run: scenes that differ from its own by the number
   alone, a little lower and a little higher. A shadow is not run. Its states are those of the run,
   moved along their derivatives (stepping/tangent.c) to its number; they are observed and stored as
   the run's are, in memory, and the difference between the two is what is asked for. */
#include "stepping/tangent.h"
#include "tasks/growing.h"
#include "tasks/grow_rules.h"
#include <stdlib.h>

typedef struct {
  PetscReal number; /* in the unit of the option */
  Scene scene;
  Rod rod;
  Observer observer;
  Output output;
} Shadow;

typedef struct {
  char name[64], unit[32]; /* with its dash; "": none */
  PetscReal number;        /* p, in that unit */
  Shadow shadow[2];
} Asked;

struct _Sensitivities {
  PetscInt n;
  Asked *asked;
  Tangents tangents;
  Vec S, S_t, U, U_t;
  PetscBool lost; /* the rod has snapped */
};

/* The option's number and its unit, as they were given or by default. */
static PetscErrorCode ReadNumber(Grow *self, Asked *asked) {
  const OptionRow *row = OptionFind(asked->name);
  const char *said;
  char text[PETSC_MAX_PATH_LEN] = "", *end;
  PetscBool given;

  PetscFunctionBegin;
  UserCheck(row && row->kind == KIND_REAL && !(row->flags & (PETSCS | SHARED | PASSING | EVENT)),
            self->scene->comm,
            "-sensitivity %s: is no option with a number that is of the rod or its "
            "surroundings",
            asked->name + 1);
  PetscCall(OptionGiven(asked->name, &given));
  if (given) PetscCall(PetscOptionsGetString(NULL, NULL, asked->name, text, sizeof(text), NULL));
  said = OptionSaid(asked->name);
  if (!given) said = row->usual;
  if (said) (void)snprintf(text, sizeof(text), "%s", said);
  UserCheck(text[0], self->scene->comm, "-sensitivity %s: give %s itself, too", asked->name + 1,
            asked->name);
  asked->number = strtod(text, &end);
  while (*end == ' ') end++;
  (void)snprintf(asked->unit, sizeof(asked->unit), "%s", end);
  PetscFunctionReturn(0);
}

/* The numbers of the shadows, within what the option may be. */
static PetscErrorCode PlaceShadows(const Grow *self, Asked *asked) {
  const OptionRow *row = OptionFind(asked->name);
  const PetscReal part = PetscMin(grow_rule.sensitivity_step,
                                  grow_rule.sensitivity_turn *
                                      PetscSqrtReal(self->scene->load.friction.beta)),
                  p = asked->number, step = part * (p != 0 ? PetscAbsReal(p) : 1);
  PetscReal value;
  char text[64];

  PetscFunctionBegin;
  for (int k = 0; k < 2; k++) {
    asked->shadow[k].number = k ? p + step : p - step;
    (void)snprintf(text, sizeof(text), "%.17g%s", (double)asked->shadow[k].number, asked->unit);
    PetscCall(OptionQuantity(asked->name, text, row->dimension, &value));
    if (value < row->low || value > row->high) asked->shadow[k].number = p;
  }
  PetscFunctionReturn(0);
}

/* The run's options with another number; the caller destroys them. */
static PetscErrorCode OtherOptions(const Grow *self, const char *name, const char *value,
                                   PetscOptions *options) {
  char *all, end[40];

  PetscFunctionBegin;
  PetscCall(PetscOptionsCreate(options));
  PetscCall(OptionsList(&all));
  for (char *line = strtok(all, "\n"); line; line = strtok(NULL, "\n")) {
    char *text = line + strcspn(line, " ");
    if (*text) *text++ = 0;
    PetscCall(PetscOptionsSetValue(*options, line, *text ? text : NULL));
  }
  PetscCall(PetscFree(all));
  /* times are the run's, whatever its units are */
  (void)snprintf(end, sizeof(end), "%.17g", (double)self->scene->end_time);
  PetscCall(PetscOptionsSetValue(*options, "-ts_max_time", end));
  PetscCall(PetscOptionsSetValue(*options, name, value));
  PetscFunctionReturn(0);
}

/* The scene of a shadow, on the nodes of the run. */
static PetscErrorCode CreateScene(Grow *self, const Asked *asked, Shadow *shadow) {
  PetscOptions options;
  PetscErrorCode error;
  PetscBool used = PETSC_TRUE;
  char text[64];

  PetscFunctionBegin;
  (void)snprintf(text, sizeof(text), "%.17g%s", (double)shadow->number, asked->unit);
  PetscCall(OtherOptions(self, asked->name, text, &options));
  PetscCall(OptionsPush(self->scene->comm, options, NULL));
  error = SceneCreate(&shadow->scene);
  if (!error) error = RodCreate(shadow->scene, self->now->rod->model, &shadow->rod);
  if (!error) error = PetscOptionsUsed(options, asked->name + 1, &used);
  PetscCall(OptionsPop());
  PetscCall(PetscOptionsDestroy(&options));
  PetscCall(error);
  UserCheck(used, self->scene->comm,
            "-sensitivity %s: nothing of this rod and its surroundings depends on it",
            asked->name + 1);
  UserCheck(!shadow->scene->space.why && !shadow->scene->space.only, self->scene->comm,
            "-sensitivity %s: is of rods in space, and nothing in the plane's frame model, which "
            "derivatives are of, depends on it; take it out",
            asked->name + 1);
  SceneAtTolerance(shadow->scene, self->rtol);
  PetscCall(PetscArraycpy(shadow->scene->mesh.s, self->scene->mesh.s, self->scene->mesh.cells + 1));
  PetscCall(RodHoldTip(shadow->rod));
  PetscCall(ObserverCreate(shadow->scene, &shadow->observer));
  PetscCall(OutputCreate("", shadow->scene, &shadow->output));
  PetscCall(OutputKeep(shadow->output, PETSC_TRUE, PETSC_TRUE));
  PetscFunctionReturn(0);
}

/* What has no derivative that would be followed here. */
static PetscErrorCode Refuse(Grow *self, const char *output, const char *restart) {
  const Scene scene = self->scene;
  PetscBool vbdf;

  PetscFunctionBegin;
  UserCheck(!self->member, scene->comm,
            "-sensitivity: a sweep stores none; take it out, or run the member by itself");
  UserCheck(!restart[0], scene->comm,
            "-sensitivity: a run that goes on does not know them; take -restart out");
  UserCheck(output[0], scene->comm, "-sensitivity: is stored with -output FILE; give it");
  UserCheck(self->model == FRAME, scene->comm,
            "-sensitivity: is of the plane's frame model; give -rod_model frame");
  UserCheck(!LoadSticks(&scene->load) && !scene->load.limit && !scene->load.shared, scene->comm,
            "-sensitivity: where friction is exact, or next to it, a run has no derivatives; give "
            "a larger -friction_beta");
  UserCheck(!scene->contact.any, scene->comm,
            "-sensitivity: is not followed through contact; take the walls or -contact_self out");
  UserCheck(scene->shape.type != SHAPE_MODE, scene->comm,
            "-sensitivity: -shape_type mode depends on the whole scene; give another shape");
  PetscCall(PetscObjectTypeCompare((PetscObject)self->leg[FRAME].ts, TSVBDF, &vbdf));
  UserCheck(scene->growth->yield == 0, scene->comm,
            "-sensitivity: is not followed where growth feels force; take -growth_yield out");
  UserCheck(vbdf, scene->comm, "-sensitivity: follows the steps of vbdf; take -ts_type out");
  PetscFunctionReturn(0);
}

/* The names, between commas, with or without their dash. */
static PetscErrorCode ReadNames(Grow *self, char text[]) {
  Sensitivities all = self->sensitivities;
  PetscInt n = 1;

  PetscFunctionBegin;
  for (const char *c = text; *c; c++) n += *c == ',';
  PetscCall(PetscCalloc1(n, &all->asked));
  for (char *name = strtok(text, ","); name; name = strtok(NULL, ",")) {
    Asked *asked = &all->asked[all->n];
    (void)snprintf(asked->name, sizeof(asked->name), "%s%s", *name == '-' ? "" : "-", name);
    for (PetscInt k = 0; k < all->n; k++)
      UserCheck(strcmp(all->asked[k].name, asked->name), self->scene->comm,
                "-sensitivity: %s stands there twice", asked->name + 1);
    PetscCall(ReadNumber(self, asked));
    PetscCall(PlaceShadows(self, asked));
    all->n++;
  }
  PetscFunctionReturn(0);
}

/*
  GrowSensitivitiesCreate - reads -sensitivity; where it is given, makes what it takes: once the
  run's legs are there. Collective.
*/
PetscErrorCode GrowSensitivitiesCreate(Grow *self, const char *output, const char *restart) {
  char text[PETSC_MAX_PATH_LEN];
  Sensitivities all;
  PetscBool given;
  TangentOf *of;

  PetscFunctionBegin;
  PetscCall(OptionText("-sensitivity", text, &given));
  if (!given) PetscFunctionReturn(0);
  PetscCall(Refuse(self, output, restart));
  self->now = &self->leg[FRAME];
  PetscCall(PetscNew(&all));
  self->sensitivities = all;
  PetscCall(ReadNames(self, text));
  PetscCall(PetscMalloc1(all->n, &of));
  for (PetscInt i = 0; i < all->n; i++) {
    Shadow *shadow = all->asked[i].shadow;
    for (int k = 0; k < 2; k++) PetscCall(CreateScene(self, &all->asked[i], &shadow[k]));
    of[i] = (TangentOf){
        .low = shadow[0].rod, .high = shadow[1].rod, .apart = shadow[1].number - shadow[0].number};
  }
  PetscCall(TangentsCreate(self->now, all->n, of, &all->tangents));
  PetscCall(TangentsBegin(all->tangents));
  PetscCall(PetscFree(of));
  for (int k = 0; k < 4; k++)
    PetscCall(VecDuplicate(self->now->U, (Vec *[]){&all->S, &all->S_t, &all->U, &all->U_t}[k]));
  PetscFunctionReturn(0);
}

PetscErrorCode GrowSensitivitiesDestroy(Grow *self) {
  Sensitivities all = self->sensitivities;

  PetscFunctionBegin;
  if (!all) PetscFunctionReturn(0);
  PetscCall(TangentsDestroy(&all->tangents));
  for (PetscInt i = 0; i < all->n; i++)
    for (int k = 0; k < 2; k++) {
      Shadow *shadow = &all->asked[i].shadow[k];
      PetscCall(OutputDestroy(&shadow->output));
      PetscCall(ObserverDestroy(&shadow->observer));
      PetscCall(RodDestroy(&shadow->rod));
      PetscCall(SceneDestroy(&shadow->scene));
    }
  for (int k = 0; k < 4; k++)
    PetscCall(VecDestroy((Vec *[]){&all->S, &all->S_t, &all->U, &all->U_t}[k]));
  PetscCall(PetscFree(all->asked));
  PetscCall(PetscFree(self->sensitivities));
  PetscFunctionReturn(0);
}

/* GrowSensitivitiesStep - follows the step that was taken to time t, before anything is seen of it.
   Collective. */
PetscErrorCode GrowSensitivitiesStep(Grow *self, PetscReal t) {
  Sensitivities all = self->sensitivities;

  PetscFunctionBegin;
  if (!all || all->lost) PetscFunctionReturn(0);
  PetscCall(TangentsStep(all->tangents, t));
  all->lost = TangentsLost(all->tangents);
  PetscFunctionReturn(0);
}

/* The state and rate of a shadow; U NULL: it begins. U_t NULL: no rate is asked for. */
static PetscErrorCode Move(Sensitivities all, PetscInt i, const Shadow *shadow, PetscReal t, Vec U,
                           Vec U_t) {
  const PetscReal by = shadow->number - all->asked[i].number;

  PetscFunctionBegin;
  if (!U) PetscFunctionReturn(0);
  PetscCall(TangentsAt(all->tangents, i, t, all->S, all->S_t));
  PetscCall(VecWAXPY(all->U, by, all->S, U));
  if (U_t) PetscCall(VecWAXPY(all->U_t, by, all->S_t, U_t));
  PetscFunctionReturn(0);
}

/* GrowSensitivitiesObserve - as the run is observed, so its shadows. U NULL: at the start.
   Collective. */
PetscErrorCode GrowSensitivitiesObserve(Grow *self, PetscReal t, Vec U, Vec U_t) {
  Sensitivities all = self->sensitivities;
  Observation seen;

  PetscFunctionBegin;
  if (!all) PetscFunctionReturn(0);
  if (self->kept.snaps) all->lost = PETSC_TRUE;
  for (PetscInt i = 0; i < all->n; i++)
    for (int k = 0; k < 2; k++) {
      const Shadow *shadow = &all->asked[i].shadow[k];
      PetscCall(Move(all, i, shadow, t, all->lost ? NULL : U, U_t));
      if (all->lost)
        for (int v = 0; v < OBSERVED; v++) ((PetscReal *)&seen)[v] = NAN;
      else
        PetscCall(ObserverMeasure(shadow->observer, shadow->rod, t, U ? all->U : NULL,
                                  U_t ? all->U_t : NULL, NULL, &seen));
      PetscCall(OutputSeries(shadow->output, &seen));
    }
  PetscFunctionReturn(0);
}

/* GrowSensitivitiesShape - as the run's shape is stored, so those of its shadows. U NULL: the
   initial one. Collective. */
PetscErrorCode GrowSensitivitiesShape(Grow *self, PetscReal t, Vec U) {
  Sensitivities all = self->sensitivities;
  const Node *nodes;

  PetscFunctionBegin;
  if (!all) PetscFunctionReturn(0);
  for (PetscInt i = 0; i < all->n; i++)
    for (int k = 0; k < 2; k++) {
      const Shadow *shadow = &all->asked[i].shadow[k];
      PetscCall(Move(all, i, shadow, t, U, NULL));
      if (U && all->lost) PetscCall(VecSet(all->U, NAN));
      PetscCall(ObserverGather(shadow->observer, shadow->rod, t, U ? all->U : NULL, NULL, &nodes));
      if (nodes) PetscCall(OutputShape(shadow->output, t, nodes, NULL));
    }
  PetscFunctionReturn(0);
}

/* GrowSensitivitiesKeep - hands all to the output, for its last store. Collective. */
PetscErrorCode GrowSensitivitiesKeep(Grow *self) {
  Sensitivities all = self->sensitivities;
  Harvest harvest[2];

  PetscFunctionBegin;
  if (!all) PetscFunctionReturn(0);
  for (PetscInt i = 0; i < all->n; i++) {
    Asked *asked = &all->asked[i];
    const PetscReal apart = asked->shadow[1].number - asked->shadow[0].number;
    for (int k = 0; k < 2; k++)
      PetscCall(OutputHarvest(asked->shadow[k].output, &self->seen, ObservedOf(self->scene),
                              &harvest[k]));
    for (size_t v = 0; v < harvest[1].n; v++)
      harvest[1].data[v] = (harvest[1].data[v] - harvest[0].data[v]) / apart;
    PetscCall(PetscFree(harvest[0].data));
    PetscCall(
        OutputDerivative(self->output, asked->name + 1, asked->unit, asked->number, &harvest[1]));
  }
  if (all->lost && !self->quiet)
    PetscCall(PetscPrintf(self->scene->comm,
                          "-sensitivity: behind a snap nothing is known, and stored as nan\n"));
  PetscFunctionReturn(0);
}
