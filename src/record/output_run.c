/* What a result file says of a run as a whole: scales, laws, errors, the event that ended it; and
   its derivatives by numbers of the scene. */
#include "record/storing.h"

/* The scales of the physical rod, if one was given. */
static PetscErrorCode ScaleAttributes(Output self, HdfFile file) {
  const Si *si = &self->scene->si;
  char name[32];

  PetscFunctionBegin;
  for (int k = UNIT_LENGTH; k <= UNIT_CURVATURE; k++) {
    (void)snprintf(name, sizeof(name), "si_%s", si_name[k]);
    if (si->scale[k] > 0) PetscCall(HdfReal(file, "/", name, si->scale[k]));
  }
  PetscFunctionReturn(0);
}

/* What was changed, and what laws have become by time t: the viscous share of friction, the
   stiffness of contact; and the walls around the rod, for who draws it. */
static PetscErrorCode LawAttributes(Output self, HdfFile file, PetscReal t) {
  const Contact *contact = &self->scene->contact;
  const Changes changes = self->scene->changes;
  SceneMemory laws;
  char *text;

  PetscFunctionBegin;
  if (changes && changes->done) {
    PetscCall(ChangesText(changes, &text));
    PetscCall(HdfWriteText(file, "changes", text,
                           "what was changed in the run: time, what, and its new value"));
    PetscCall(PetscFree(text));
  }
  SceneRemember(self->scene, &laws);
  if (laws.shared != 0) PetscCall(HdfReal(file, "/", "viscous_share", laws.shared));
  PetscCall(SceneContactAt(self->scene, t));
  if (contact->any) PetscCall(HdfReal(file, "/", "contact_stiffness", contact->stiffness));
  if (laws.firm > 0) PetscCall(HdfReal(file, "/", "contact_firm", ContactFirmTimes(contact)));
  if (!contact->walls.n && !contact->surfaces.n) PetscFunctionReturn(0);
  PetscCall(ContactWallsText(contact, &text));
  PetscCall(HdfWriteText(file, "walls", text, "the walls around the rod, one a line"));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(0);
}

static PetscErrorCode ErrorAttribute(HdfFile file, const char *which, const char *of,
                                     PetscReal value) {
  char name[32];

  PetscFunctionBegin;
  (void)snprintf(name, sizeof(name), "error_%s%s", which, of);
  PetscCall(HdfReal(file, "/", name, value));
  PetscFunctionReturn(0);
}

/* How far off rigid contact would have tip and energy, to first order. */
static PetscErrorCode RigidAttributes(HdfFile file, const ErrorEstimate *error) {
  static const char *const name[RIGID_VALUES] = {"rigid_tip_x1", "rigid_tip_x2", "rigid_tip_x3",
                                                 "rigid_energy"};

  PetscFunctionBegin;
  for (int k = 0; k < RIGID_VALUES && error->pressed; k++)
    PetscCall(HdfReal(file, "/", name[k], error->rigid[k]));
  PetscFunctionReturn(0);
}

/* How far off the run may be, once that is known: over all of it, and in its last state. */
static PetscErrorCode ErrorAttributes(Output self, HdfFile file) {
  static const char *const kind[] = {"", "measured", "fitted"},
                           *const part[ESTIMATE_PARTS] = {"space", "time", "friction", "contact"},
                           *const why[WHYS] = {"space",   "time",       "friction", "contact",
                                               "a touch", "it lets go", "a snap"},
                           *const seen[ESTIMATE_SEEN] = {"tip", "norm_x2", "energy"};
  const ErrorEstimate *error = &self->error;
  char name[32];

  PetscFunctionBegin;
  if (error->kind == ESTIMATE_NONE) PetscFunctionReturn(0);
  PetscCall(HdfText(file, "/", "error_kind", kind[error->kind]));
  PetscCall(HdfReal(file, "/", "error_estimate", error->most.all));
  if (error->kind != ESTIMATE_MEASURED) PetscFunctionReturn(0);
  PetscCall(HdfReal(file, "/", "error_end_estimate", error->end.all));
  for (int k = 0; k < ESTIMATE_PARTS; k++) {
    PetscCall(ErrorAttribute(file, "", part[k], error->most.part[k]));
    PetscCall(ErrorAttribute(file, "end_", part[k], error->end.part[k]));
  }
  for (int k = 0; k < ESTIMATE_SEEN; k++) {
    PetscCall(ErrorAttribute(file, "", seen[k], error->most.seen[k]));
    PetscCall(ErrorAttribute(file, "end_", seen[k], error->end.seen[k]));
    PetscCall(ErrorAttribute(file, "when_", seen[k], error->when[k]));
    (void)snprintf(name, sizeof(name), "error_why_%s", seen[k]);
    PetscCall(HdfText(file, "/", name, why[error->why[k]]));
  }
  PetscCall(RigidAttributes(file, error));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteEvent(Output self, HdfFile file) {
  const Event *event = &self->event;
  const PetscInt two = 2;
  PetscReal x[3];

  PetscFunctionBegin;
  if (event->kind == EVENT_NONE) PetscFunctionReturn(0);
  PetscCall(HdfDelete(file, "/event"));
  PetscCall(HdfGroup(file, "/event"));
  PetscCall(HdfWrite(file, "/event/t", 0, NULL, &event->t, "l/V", "its time"));
  PetscCall(HdfWrite(file, "/event/s", 1, &two, event->s, "1",
                     "labels of the places concerned; twice the same if it is one"));
  ScenePlaceToLab(self->scene, event->x, x);
  PetscCall(HdfWrite(file, "/event/x", 1, &two, x, "l", "position x1, x2"));
  PetscCall(HdfText(file, "/event", "kind", event_name[event->kind]));
  PetscFunctionReturn(0);
}

/* Has a series a derivative? Counts have none, nor what is of the stepper. */
static PetscBool IsSmooth(int observed) {
  static const char *const others = "t,energy_defect,contacts,inflections,self_crossings,"
                                    "step,newton_iterations,model,"
                                    "error_tip,error_norm_x2,error_energy";
  const char *name = observed_name[observed], *at = others;
  const size_t n = strlen(name);

  for (; (at = strstr(at, name)); at += n)
    if ((at == others || at[-1] == ',') && (!at[n] || at[n] == ',')) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* The derivatives by one number, as series and shapes beside those of the run. */
static PetscErrorCode WriteDerivative(Output self, HdfFile file, const Derivative *by) {
  const Harvest *harvest = &by->harvest;
  const PetscInt values = harvest->values, steps = harvest->steps;
  const PetscReal *row = harvest->data + values, *from = row + values * steps + harvest->nodes;
  PetscReal *column;
  char path[160];

  PetscFunctionBegin;
  (void)snprintf(path, sizeof(path), "/sensitivity/%s", by->name);
  PetscCall(HdfGroup(file, path));
  PetscCall(HdfReal(file, path, "number", by->number));
  PetscCall(HdfText(file, path, "unit", by->unit));
  (void)snprintf(path, sizeof(path), "/sensitivity/%s/series", by->name);
  PetscCall(HdfGroup(file, path));
  (void)snprintf(path, sizeof(path), "/sensitivity/%s/shapes", by->name);
  PetscCall(HdfGroup(file, path));
  PetscCall(PetscMalloc1(steps, &column));
  for (int i = 0; i < values; i++) {
    if (!IsSmooth(i)) continue;
    for (PetscInt k = 0; k < steps; k++) column[k] = row[k * values + i];
    (void)snprintf(path, sizeof(path), "/sensitivity/%s/series/%s", by->name, observed_name[i]);
    PetscCall(HdfWrite(file, path, 1, &steps, column, observed_units[i], observed_text[i]));
  }
  PetscCall(PetscFree(column));
  for (int i = 0; i < CONTACT_SET; i++) {
    const ShapeSet *set = &self->set[i];
    const PetscInt dims[3] = {harvest->shapes, harvest->nodes, set->components};
    (void)snprintf(path, sizeof(path), "/sensitivity/%s%s", by->name, set->name);
    if (set->components)
      PetscCall(
          HdfWrite(file, path, set->components > 1 ? 3 : 2, dims, from, set->units, set->text));
    from += harvest->shapes * OutputShapeSize(self, i);
  }
  PetscFunctionReturn(0);
}

/* The group of all of them, in the place of what stood there. */
static PetscErrorCode WriteDerivatives(Output self, HdfFile file) {
  PetscFunctionBegin;
  if (!self->derivatives_n) PetscFunctionReturn(0);
  PetscCall(HdfDelete(file, "/sensitivity"));
  PetscCall(HdfGroup(file, "/sensitivity"));
  for (PetscInt k = 0; k < self->derivatives_n; k++)
    PetscCall(WriteDerivative(self, file, &self->derivatives[k]));
  PetscFunctionReturn(0);
}

/* OutputWriteRun - all of it, of a run that has come to time t. */
PetscErrorCode OutputWriteRun(Output self, HdfFile file, PetscReal t) {
  PetscFunctionBegin;
  PetscCall(WriteEvent(self, file));
  PetscCall(WriteDerivatives(self, file));
  PetscCall(HdfText(file, "/", "interrupted", self->interrupted));
  PetscCall(ScaleAttributes(self, file));
  PetscCall(LawAttributes(self, file, t));
  PetscCall(ErrorAttributes(self, file));
  if (self->earlier)
    PetscCall(HdfWriteText(file, "earlier_options", self->earlier, "options of the runs before"));
  PetscFunctionReturn(0);
}

/* OutputDerivative - keeps derivatives by the number of an option, in its unit, for the next store;
   the harvest is theirs, as of a run, and the output's from now on. */
PetscErrorCode OutputDerivative(Output self, const char *name, const char *unit, PetscReal number,
                                Harvest *harvest) {
  Derivative *by;

  PetscFunctionBegin;
  PetscCall(PetscRealloc((size_t)(self->derivatives_n + 1) * sizeof(*by), &self->derivatives));
  by = &self->derivatives[self->derivatives_n++];
  *by = (Derivative){.number = number, .harvest = *harvest};
  PetscCall(PetscStrncpy(by->name, name, sizeof(by->name)));
  PetscCall(PetscStrncpy(by->unit, unit, sizeof(by->unit)));
  PetscCall(PetscMemzero(harvest, sizeof(*harvest)));
  PetscFunctionReturn(0);
}
