#include "base/lock.h"
#include "record/storing.h"
#include "record/xdmf.h"
#include <petsctime.h>

/* A store copies the file, so that it is whole at any time. One is due where a shape waits for a
   second, else every ten, and later where storing has taken long: it is to take a twentieth of the
   time at most. Nor is more kept back than a share of the file, or what is nothing to a machine. */
static const PetscLogDouble soon = 1, late = 10, share = 20;
static const double kept_back = 6.4e7, kept_share = 0.25;

/* OutputHolds - is a series one of this run? */
PetscBool OutputHolds(const Output self, int observed) {
  return (PetscBool)(ObservedIn(self->scene, observed) &&
                     (self->follows || strncmp(observed_name[observed], "error_", 6)));
}

/* OutputShapeSize - how many values a shape has in a set. */
PetscInt OutputShapeSize(const Output self, int set) {
  const PetscInt per_node = self->set[set].components;
  return per_node ? per_node * self->nodes : 1;
}

/* Makes room for one more of n entries of `size` reals. */
static PetscErrorCode Room(PetscInt n, PetscInt *room, size_t size, void *array) {
  PetscFunctionBegin;
  if (n < *room) PetscFunctionReturn(0);
  *room = 2 * *room + 16;
  PetscCall(PetscRealloc((size_t)*room * size * sizeof(PetscReal), (void **)array));
  PetscFunctionReturn(0);
}

/* An empty file's groups and datasets. */
static PetscErrorCode Layout(Output self, HdfFile file) {
  const PetscInt n = self->nodes;
  char path[64];

  PetscFunctionBegin;
  PetscCall(HdfGroup(file, "/series"));
  PetscCall(HdfGroup(file, "/shapes"));
  for (int i = 0; i < OBSERVED; i++) {
    if (!OutputHolds(self, i)) continue;
    (void)snprintf(path, sizeof(path), "/series/%s", observed_name[i]);
    PetscCall(HdfAppendable(file, path, 0, NULL, observed_units[i], observed_text[i]));
  }
  PetscCall(HdfWrite(file, "/shapes/s", 1, &n, self->s, "1", "material label of the nodes [n]"));
  for (int i = 0; i < self->sets; i++) {
    const ShapeSet *set = &self->set[i];
    PetscInt row[] = {n, set->components};
    PetscCall(HdfAppendable(file, set->name, (int)PetscMin(2, set->components), row, set->units,
                            set->text));
  }
  PetscFunctionReturn(0);
}

/* Takes off a file what is not wanted of it. */
static PetscErrorCode Cut(Output self, HdfFile file) {
  char path[64];

  PetscFunctionBegin;
  for (int i = 0; i < OBSERVED; i++) {
    if (!OutputHolds(self, i)) continue;
    (void)snprintf(path, sizeof(path), "/series/%s", observed_name[i]);
    PetscCall(HdfTruncate(file, path, self->cut[0]));
  }
  for (int i = 0; i < self->sets; i++)
    PetscCall(HdfTruncate(file, self->set[i].name, self->cut[1]));
  PetscCall(HdfDelete(file, "/event"));
  PetscCall(HdfDelete(file, "/sensitivity"));
  PetscFunctionReturn(0);
}

/* Writes what waits. */
static PetscErrorCode WriteRows(Output self, HdfFile file) {
  PetscReal *column;
  char path[64];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(self->series_n, &column));
  for (int i = 0; i < OBSERVED; i++) {
    if (!OutputHolds(self, i)) continue;
    for (PetscInt k = 0; k < self->series_n; k++)
      column[k] = ((const PetscReal *)&self->series[k])[i];
    (void)snprintf(path, sizeof(path), "/series/%s", observed_name[i]);
    PetscCall(HdfAppend(file, path, self->series_n, column));
  }
  PetscCall(PetscFree(column));
  for (int i = 0; i < self->sets; i++)
    PetscCall(HdfAppend(file, self->set[i].name, self->shapes_n, self->shape[i]));
  PetscFunctionReturn(0);
}

/* On rank 0, the file that the next store makes. */
static PetscErrorCode OpenStore(Output self, HdfFile *file) {
  PetscFunctionBegin;
  *file = NULL;
  if (!self->mine) PetscFunctionReturn(0);
  if (self->from[0])
    PetscCall(HdfAmend(self->from, self->path, file));
  else {
    PetscCall(HdfCreate(self->path, file));
    PetscCall(Layout(self, *file));
  }
  if (self->cut[0] >= 0) PetscCall(Cut(self, *file));
  PetscFunctionReturn(0);
}

/* What waited is in the file. */
static PetscErrorCode Stored(Output self, PetscLogDouble begin) {
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(self->from, self->path, sizeof(self->from)));
  self->there = PETSC_TRUE;
  self->cut[0] = self->cut[1] = -1;
  self->series_n = self->shapes_n = 0;
  self->stored += self->waits;
  self->waits = 0;
  PetscCall(XdmfWrite(self->path, 1, self->nodes, self->times_n, self->times,
                      self->scene->contact.any, self->scene->space.rod));
  PetscCall(PetscTime(&now));
  self->stored_at = now;
  self->cost = now - begin;
  PetscFunctionReturn(0);
}

/*
  OutputStore - brings all that waits into the file, with what the run needs to go on from here.
  Collective.

  rod            at work
  state, points  of RestartKeep(), NULL: the run has not taken a step
  errors         of EstimateKeep(); NULL: none are followed

  What cannot be written (a full disk) is a user's mistake: the file is then what it was before.
*/
PetscErrorCode OutputStore(Output self, Rod rod, RestartState *state, Vec points[], Vec errors[],
                           PetscBool finished) {
  char fault[HDF_FAULT] = "", text[64];
  PetscLogDouble begin;
  HdfFile file;

  PetscFunctionBegin;
  if (!self->path[0] || self->broken) PetscFunctionReturn(0);
  PetscCall(PetscTime(&begin));
  PetscCall(OpenStore(self, &file));
  if (file) {
    PetscCall(WriteRows(self, file));
    PetscCall(OutputAttributes(file, self->comm, finished));
    PetscCall(OutputWriteRun(self, file, state ? state->t : 0));
  }
  PetscCall(RestartWrite(file, self->scene, rod, state, points, errors));
  PetscCall(HdfClose(&file, fault));
  PetscCallMPI(MPI_Bcast(fault, HDF_FAULT, MPI_CHAR, 0, self->comm));
  self->broken = (PetscBool)(fault[0] != 0);
  UserCheck(!fault[0], self->comm,
            self->there ? "-output %s: cannot be written at t = %s: %s; what was stored before is "
                          "whole: make room and go on with -restart"
                        : "-output %s: cannot be written at t = %s: %s; make room, or name a "
                          "file elsewhere",
            self->path, OptionBoth(state ? state->t : 0, UNIT_TIME, text), fault);
  if (self->mine) PetscCall(Stored(self, begin));
  PetscFunctionReturn(0);
}

/* OutputDue - is it time to store? On rank 0; false on the others. Not collective. */
PetscBool OutputDue(Output self) {
  PetscLogDouble now, since;

  if (!self->mine || PetscTime(&now)) return PETSC_FALSE;
  if (self->waits > PetscMax(kept_back, kept_share * self->stored)) return PETSC_TRUE;
  since = now - self->stored_at;
  return (PetscBool)(since > share * self->cost && since > (self->shapes_n ? soon : late));
}

static PetscErrorCode New(const char *path, Scene scene, Output *output) {
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(PetscNew(output));
  (*output)->scene = scene;
  (*output)->comm = scene->comm;
  (*output)->s = SceneLabels(scene, &(*output)->nodes);
  (*output)->set = ShapeSets(scene, &(*output)->sets);
  (*output)->cut[0] = (*output)->cut[1] = -1;
  PetscCall(PetscStrncpy((*output)->path, path, sizeof((*output)->path)));
  PetscCallMPI(MPI_Comm_rank((*output)->comm, &rank));
  (*output)->mine = (PetscBool)(!rank && path[0]);
  if (path[0]) PetscCall(OutputRefuseTaken("-output", path));
  PetscFunctionReturn(0);
}

/*
  OutputCreate - the result file of a new run. Collective; the caller ends it with OutputDestroy().

  path   empty: nothing is stored
*/
PetscErrorCode OutputCreate(const char *path, Scene scene, Output *output) {
  PetscFunctionBegin;
  PetscCall(New(path, scene, output));
  PetscFunctionReturn(0);
}

/* OutputNext - the first time behind t at which a shape is stored. Those are added up; 0, near to
   which a run may take many steps, is none of them. */
PetscReal OutputNext(PetscReal t, PetscReal interval) {
  PetscReal due = interval;

  while (due <= t * (1 + 1e-12)) due += interval;
  return due;
}

/* Is t one of them? */
static PetscBool OnGrid(PetscReal t, PetscReal interval) {
  PetscReal due = interval;

  while (due < t * (1 - 1e-12)) due += interval;
  return (PetscBool)(due <= t * (1 + 1e-12));
}

/* OutputCountUpTo - how many of n increasing times are at or before t. */
PetscInt OutputCountUpTo(PetscInt n, const PetscReal times[], PetscReal t) {
  while (n > 0 && times[n - 1] > t * (1 + 1e-12)) n--;
  return n;
}

/* OutputUpTo - how much there is in a file of a run that goes on from t: rows of its series, and
   the times of its shapes, which the caller frees. Arguments are those of OutputContinue(). */
PetscErrorCode OutputUpTo(const char *from, MPI_Comm comm, PetscReal t, PetscReal interval,
                          PetscInt *rows, PetscInt *shapes, PetscReal **times) {
  PetscBool good;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(HdfRead("-restart", from, "/series/t", 1, &n, times));
  *rows = OutputCountUpTo(n, *times, t);
  good = (PetscBool)(*rows > 0 && PetscAbsReal((*times)[*rows - 1] - t) <= 1e-12 * t);
  PetscCall(PetscFree(*times));
  UserCheck(good, comm, "-restart %s: its series end before its last state", from);
  PetscCall(HdfRead("-restart", from, "/shapes/t", 1, &n, times));
  *shapes = OutputCountUpTo(n, *times, t);
  if (*shapes > 1 && (*times)[*shapes - 1] > t * (1 - 1e-12) && !OnGrid(t, interval)) --*shapes;
  PetscFunctionReturn(0);
}

/* The options of all earlier legs, a heading line with its end before each. */
static PetscErrorCode EarlierOptions(Output self, const char *from, PetscReal t) {
  char *before = NULL, *last;
  PetscBool has;
  size_t room;

  PetscFunctionBegin;
  PetscCall(HdfHas(from, "earlier_options", &has));
  if (has) PetscCall(HdfReadText("-restart", from, "earlier_options", &before));
  PetscCall(HdfReadText("-restart", from, "options", &last));
  room = (before ? strlen(before) : 0) + strlen(last) + 64;
  PetscCall(PetscMalloc1(room, &self->earlier));
  (void)snprintf(self->earlier, room, "%s# up to t = %.17g\n%s", before ? before : "", (double)t,
                 last);
  PetscCall(PetscFree(before));
  PetscCall(PetscFree(last));
  PetscFunctionReturn(0);
}

/*
  OutputContinue - the result file of a run that goes on. Collective.

  path      the file `from` itself goes on if it is the same or empty, else a copy of it; NULL: none
  t         what `from` holds after this time is taken off: it comes again
  interval  a last shape that was stored at t only because the run ended there is taken off too
*/
PetscErrorCode OutputContinue(const char *path, const char *from, Scene scene, PetscReal t,
                              PetscReal interval, Output *output) {
  PetscReal *times;
  PetscInt series, shapes;

  PetscFunctionBegin;
  PetscCall(OutputUpTo(from, scene->comm, t, interval, &series, &shapes, &times));
  if (path) path = path[0] ? path : from; /* NULL: nothing is stored by itself */
  PetscCall(New(path ? path : "", scene, output));
  PetscCall(PetscStrncpy((*output)->from, from, sizeof((*output)->from)));
  (*output)->cut[0] = series;
  (*output)->cut[1] = shapes;
  (*output)->times = times;
  (*output)->times_n = (*output)->times_room = shapes;
  PetscCall(EarlierOptions(*output, from, t));
  PetscFunctionReturn(0);
}

/* OutputSeries - adds one line of the series. */
PetscErrorCode OutputSeries(Output self, const Observation *seen) {
  PetscFunctionBegin;
  if (!self->mine && !self->series_kept) PetscFunctionReturn(0);
  PetscCall(OutputRoom(self, self->series_n + 1));
  self->series[self->series_n++] = *seen;
  self->waits += sizeof(*seen);
  PetscFunctionReturn(0);
}

/* OutputContactAbout - the force of contact per length about node i, from that at nodes and between
   them: what nodes have, times half of the lengths of their cells, adds up to what there is. (Where
   contact is stiff, that at the node itself may be far from that beside it.) */
PetscErrorCode OutputContactAbout(Scene scene, PetscReal t, PetscInt i, PetscReal g,
                                  const PetscReal (*contact)[PUSH], PetscReal about[3]) {
  PetscInt nodes;
  const PetscReal *s = SceneLabels(scene, &nodes);
  PetscReal length = 0, h, z, g_mid;

  PetscFunctionBegin;
  about[0] = about[1] = about[2] = 0;
  for (PetscInt side = -1; side <= 1; side += 2) {
    if (i + side < 0 || i + side >= nodes) continue;
    h = PetscAbsReal(s[i + side] - s[i]);
    z = (s[i + side] + s[i]) / 2;
    PetscCall(SceneStretch(scene, z, t, &g_mid));
    length += h / 2 * g;
    for (int d = 0; d < 3; d++)
      about[d] += h / 6 * (g * contact[2 * i][d] + 2 * g_mid * contact[2 * i + side][d]);
  }
  for (int d = 0; d < 3; d++) about[d] /= length;
  PetscFunctionReturn(0);
}

/* OutputShape - adds the shape at one time. nodes are rank 0's; contact is the force of contact per
   length at nodes and between them, NULL if the scene has none. */
PetscErrorCode OutputShape(Output self, PetscReal t, const Node *nodes,
                           const PetscReal (*contact)[PUSH]) {
  const PetscInt n = self->nodes, k = self->shapes_n;
  PetscInt room = self->shapes_room;
  PetscReal *to[MOST_SHAPE_SETS], about[3];
  LabNode node;

  PetscFunctionBegin;
  if (!self->mine && !self->shapes_kept) PetscFunctionReturn(0);
  for (int i = 0; i < self->sets; i++) {
    room = self->shapes_room;
    PetscCall(Room(k, &room, (size_t)OutputShapeSize(self, i), &self->shape[i]));
    to[i] = self->shape[i] + k * OutputShapeSize(self, i);
    if (!self->set[i].components) *to[i] = t;
    self->waits += (double)(OutputShapeSize(self, i) * (PetscInt)sizeof(PetscReal));
  }
  self->shapes_room = room;
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(LabNodeAt(self->scene, t, self->s[i], &nodes[i], &node));
    if (contact) PetscCall(OutputContactAbout(self->scene, t, i, node.stretch, contact, about));
    if (contact) SceneToLab(self->scene, about, node.contact);
    for (int set = 0; set < self->sets; set++)
      for (PetscInt d = 0; d < self->set[set].components; d++)
        *to[set]++ = ((const PetscReal *)((const char *)&node + self->set[set].at))[d];
  }
  self->shapes_n++;
  PetscCall(Room(self->times_n, &self->times_room, 1, &self->times));
  self->times[self->times_n++] = t;
  PetscFunctionReturn(0);
}

/* OutputBlank - the shape that was added last is none: NaN, but for its time. */
PetscErrorCode OutputBlank(Output self) {
  PetscFunctionBegin;
  if (!self->mine && !self->shapes_kept) PetscFunctionReturn(0);
  for (int i = 0; i < self->sets; i++) {
    const PetscInt size = OutputShapeSize(self, i);
    for (PetscInt j = 0; j < size && self->set[i].components; j++)
      self->shape[i][(self->shapes_n - 1) * size + j] = NAN;
  }
  PetscFunctionReturn(0);
}

/* OutputEvent - keeps the event that ended the run for the next store. */
PetscErrorCode OutputEvent(Output self, const Event *event) {
  PetscFunctionBegin;
  self->event = *event;
  PetscFunctionReturn(0);
}

/* OutputFollows - the errors of the run are followed: they are series of it. Before any are added.
 */
PetscErrorCode OutputFollows(Output self) {
  PetscFunctionBegin;
  self->follows = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* OutputErrors - keeps how far off the run may be for the next store. */
PetscErrorCode OutputErrors(Output self, const ErrorEstimate *error) {
  PetscFunctionBegin;
  self->error = *error;
  PetscFunctionReturn(0);
}

/* OutputInterrupted - keeps what has interrupted the run for the next store: where mpiexec itself
   is stopped, its ranks' last words may be lost. Empty: nothing has. */
PetscErrorCode OutputInterrupted(Output self, const char *by) {
  PetscFunctionBegin;
  PetscCall(PetscStrncpy(self->interrupted, by, sizeof(self->interrupted)));
  PetscFunctionReturn(0);
}

/* OutputStores - is there a file? */
PetscBool OutputStores(Output self) {
  return (PetscBool)(self->path[0] != 0);
}

/* OutputDestroy - frees it; what was not stored is lost. */
PetscErrorCode OutputDestroy(Output *output) {
  PetscFunctionBegin;
  if (!*output) PetscFunctionReturn(0);
  if ((*output)->mine) PetscCall(LockGive((*output)->path));
  for (int i = 0; i < MOST_SHAPE_SETS; i++) PetscCall(PetscFree((*output)->shape[i]));
  SpillFree(&(*output)->kept);
  PetscCall(PetscFree((*output)->times));
  PetscCall(PetscFree((*output)->earlier));
  for (PetscInt k = 0; k < (*output)->derivatives_n; k++)
    PetscCall(PetscFree((*output)->derivatives[k].harvest.data));
  PetscCall(PetscFree((*output)->derivatives));
  PetscCall(PetscFree(*output));
  PetscFunctionReturn(0);
}
