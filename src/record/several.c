#include "record/several.h"
#include "base/lock.h"
#include "record/storing.h"
#include "record/xdmf.h"
#include <petsctime.h>

/* A store writes the file again, which is to take a twentieth of the time at most. */
static const PetscLogDouble soon = 2, share = 20;

/* How a number of all rods comes from those of each. */
typedef enum { NONE, SAME, SUM, MOST } Of;

static Of OfAll(int observed) {
  static const char *const
      same = ",t,step,newton_iterations,model,",
      *const sum = ",energy,energy_twist,growth_power,dissipation,tip_power,contact_force,"
                   "contact_energy,contacts,weight_power,curvature_power,wall_power,clamp_power,"
                   "tropism_power,ironing_power,snaps,self_crossings,",
      *const most = ",length,max_angle,energy_defect,tip_speed,mid_speed,penetration,error_tip,"
                    "error_norm_x2,error_energy,";
  char name[64];

  (void)snprintf(name, sizeof(name), ",%s,", observed_name[observed]);
  if (strstr(same, name)) return SAME;
  if (strstr(sum, name)) return SUM;
  return strstr(most, name) ? MOST : NONE;
}

/* Has any rod this series? */
static PetscBool Holds(const Several *self, int observed) {
  for (PetscInt k = 0; k < self->n; k++)
    if (OutputHolds(self->each[k], observed)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Series `observed` of each rod, [steps][rods]; NaN of those that have none. */
static void Columns(const Several *self, int observed, PetscReal *value) {
  const PetscInt steps = self->each[0]->series_n;

  for (PetscInt i = 0; i < steps; i++)
    for (PetscInt k = 0; k < self->n; k++) {
      const Output one = self->each[k];
      *value++ = OutputHolds(one, observed) ? ((const PetscReal *)&one->series[i])[observed] : NAN;
    }
}

static PetscReal Together(Of of, PetscInt n, const PetscReal value[]) {
  PetscReal all = 0;

  for (PetscInt k = 0; k < n; k++) {
    if (PetscIsNanReal(value[k])) continue;
    if (of == SUM)
      all += value[k];
    else
      all = k && of == MOST ? PetscMax(all, value[k]) : of == MOST ? value[k] : value[0];
  }
  return all;
}

static PetscErrorCode WriteSeries(const Several *self, HdfFile file) {
  const PetscInt dims[] = {self->each[0]->series_n, self->n};
  PetscReal *value, *all;
  char path[96];

  PetscFunctionBegin;
  PetscCall(HdfGroup(file, "/series"));
  PetscCall(HdfGroup(file, "/rods/series"));
  PetscCall(PetscMalloc2(dims[0] * dims[1], &value, dims[0], &all));
  for (int i = 0; i < OBSERVED; i++) {
    const Of of = OfAll(i);
    if (!Holds(self, i)) continue;
    Columns(self, i, value);
    for (PetscInt k = 0; k < dims[0]; k++) all[k] = Together(of, self->n, value + k * self->n);
    (void)snprintf(path, sizeof(path), "/series/%s", observed_name[i]);
    if (of != NONE)
      PetscCall(HdfWrite(file, path, 1, dims, all, observed_units[i], observed_text[i]));
    (void)snprintf(path, sizeof(path), "/rods/series/%s", observed_name[i]);
    if (of != SAME)
      PetscCall(HdfWrite(file, path, 2, dims, value, observed_units[i], observed_text[i]));
  }
  PetscCall(PetscFree2(value, all));
  PetscFunctionReturn(0);
}

/* The rod that has the most sets: contact is the last of them, and not all have it. */
static Output Fullest(const Several *self) {
  Output most = self->each[0];

  for (PetscInt k = 1; k < self->n; k++)
    if (self->each[k]->sets > most->sets) most = self->each[k];
  return most;
}

/* One set of all shapes, rod behind rod; 0 of those that have none. */
static PetscErrorCode WriteSet(const Several *self, HdfFile file, int set, PetscInt nodes) {
  const ShapeSet *is = &Fullest(self)->set[set];
  const PetscInt shapes = self->each[0]->shapes_n, width = PetscMax(1, is->components),
                 dims[3] = {shapes, nodes, is->components};
  PetscReal *all, *to;

  PetscFunctionBegin;
  if (!is->components) {
    PetscCall(HdfWrite(file, is->name, 1, dims, self->each[0]->shape[set], is->units, is->text));
    PetscFunctionReturn(0);
  }
  PetscCall(PetscCalloc1(shapes * nodes * width, &all));
  to = all;
  for (PetscInt i = 0; i < shapes; i++)
    for (PetscInt k = 0; k < self->n; k++) {
      const Output one = self->each[k];
      const PetscInt size = one->nodes * width;
      if (set < one->sets) PetscCall(PetscArraycpy(to, one->shape[set] + i * size, size));
      to += size;
    }
  PetscCall(HdfWrite(file, is->name, width > 1 ? 3 : 2, dims, all, is->units, is->text));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteShapes(const Several *self, HdfFile file) {
  PetscReal *s;
  PetscInt nodes = 0, at = 0;

  PetscFunctionBegin;
  PetscCall(HdfGroup(file, "/shapes"));
  for (PetscInt k = 0; k < self->n; k++) nodes += self->each[k]->nodes;
  PetscCall(PetscMalloc1(nodes, &s));
  for (PetscInt k = 0; k < self->n; at += self->each[k++]->nodes)
    PetscCall(PetscArraycpy(s + at, self->each[k]->s, self->each[k]->nodes));
  PetscCall(HdfWrite(file, "/shapes/s", 1, &nodes, s, "1",
                     "material label of the nodes, rod behind rod [n]"));
  PetscCall(PetscFree(s));
  for (int set = 0; set < Fullest(self)->sets; set++) PetscCall(WriteSet(self, file, set, nodes));
  PetscFunctionReturn(0);
}

/* Names and places of the rods. */
static PetscErrorCode WriteRods(const Several *self, HdfFile file) {
  PetscInt64 *first, *count;
  const char **name;
  PetscInt *row;

  PetscFunctionBegin;
  PetscCall(PetscMalloc4(self->n, &first, self->n, &count, self->n, &name, self->n, &row));
  for (PetscInt k = 0; k < self->n; k++) {
    row[k] = k;
    name[k] = RodsName(self->rods, k);
    count[k] = self->each[k]->nodes;
    first[k] = k ? first[k - 1] + count[k - 1] : 0;
  }
  PetscCall(HdfColumn(file, "/rods/name", HDF_TEXTS, self->n, "", "what each is called [r]"));
  PetscCall(HdfPut(file, "/rods/name", self->n, row, name));
  PetscCall(HdfColumn(file, "/rods/first", HDF_INTS, self->n, "1",
                      "first node of each in the shapes [r]"));
  PetscCall(HdfPut(file, "/rods/first", self->n, row, first));
  PetscCall(HdfColumn(file, "/rods/count", HDF_INTS, self->n, "1", "nodes of each [r]"));
  PetscCall(HdfPut(file, "/rods/count", self->n, row, count));
  PetscCall(PetscFree4(first, count, name, row));
  PetscFunctionReturn(0);
}

/* When each is born, if any is in the run. */
static PetscErrorCode WriteBirths(const Several *self, HdfFile file) {
  PetscBool any = PETSC_FALSE;
  PetscReal *born;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(self->n, &born));
  for (PetscInt k = 0; k < self->n; k++) {
    born[k] = self->each[k]->scene->born;
    if (born[k] > 0) any = PETSC_TRUE;
  }
  if (any)
    PetscCall(HdfWrite(file, "/rods/born", 1, &self->n, born, "l/V",
                       "when each comes out; before, its shapes and series are NaN [r]"));
  PetscCall(PetscFree(born));
  PetscFunctionReturn(0);
}

/* The nodes of each as a line: what Xdmf calls mixed topology. */
static PetscErrorCode WriteLines(const Several *self, HdfFile file) {
  enum { POLYLINE = 2 };
  PetscInt room = 0, n = 0, node = 0, *row;
  PetscInt64 *line;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) room += 2 + self->each[k]->nodes;
  PetscCall(PetscMalloc2(room, &line, room, &row));
  for (PetscInt k = 0; k < self->n; k++) {
    line[n++] = POLYLINE;
    line[n++] = self->each[k]->nodes;
    for (PetscInt i = 0; i < self->each[k]->nodes; i++) line[n++] = node++;
  }
  for (PetscInt i = 0; i < room; i++) row[i] = i;
  PetscCall(HdfColumn(file, "/rods/lines", HDF_INTS, room, "1",
                      "each for viewers: 2 (a line), how many nodes, and which"));
  PetscCall(HdfPut(file, "/rods/lines", room, row, line));
  PetscCall(PetscFree2(line, row));
  PetscFunctionReturn(0);
}

/* The description of a file that has been written, for viewers. */
static PetscErrorCode Describe(const Several *self, const char *path) {
  const Output one = self->each[0];
  PetscInt nodes = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) nodes += self->each[k]->nodes;
  PetscCall(XdmfWrite(path, self->n, nodes, one->times_n, one->times,
                      (PetscBool)(Fullest(self)->sets > CONTACT_SET), PETSC_TRUE));
  PetscFunctionReturn(0);
}

/* What each rod's own file would say of it. */
static PetscErrorCode WriteAbout(const Several *self, HdfFile file, PetscReal t) {
  char group[64], *text;

  PetscFunctionBegin;
  PetscCall(HdfGroup(file, "/rods/of"));
  for (PetscInt k = 0; k < self->n; k++) {
    (void)snprintf(group, sizeof(group), "/rods/of/%s", RodsName(self->rods, k));
    PetscCall(RodsEnter(self->rods, k));
    PetscCall(HdfUnder(file, group));
    PetscCall(OptionsList(&text));
    PetscCall(HdfText(file, "/", "options", text));
    PetscCall(PetscFree(text));
    PetscCall(OutputParameters(file));
    PetscCall(OutputWriteRun(self->each[k], file, t));
    PetscCall(HdfUnder(file, NULL));
    PetscCall(RodsLeave(self->rods));
  }
  PetscFunctionReturn(0);
}

/* One number, or some, of all places, `from` reals behind the beginning of each. */
static PetscErrorCode WritePlaces(const Several *self, HdfFile file, const char *name,
                                  PetscInt width, size_t from, const char *units,
                                  const char *text) {
  const PetscInt dims[] = {self->places, width};
  PetscReal *value;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(self->places * width, &value));
  for (PetscInt k = 0; k < self->places; k++)
    PetscCall(PetscArraycpy(value + k * width,
                            (const PetscReal *)((const char *)&self->place[k] + from), width));
  PetscCall(HdfWrite(file, name, width > 1 ? 2 : 1, dims, value, units, text));
  PetscCall(PetscFree(value));
  PetscFunctionReturn(0);
}

/* Where rods touch, shape by shape. */
static PetscErrorCode WritePairs(const Several *self, HdfFile file) {
  const PetscInt dims[] = {self->places, 2};
  PetscReal *which;
  PetscInt64 *first;
  PetscInt *row;

  PetscFunctionBegin;
  if (!self->touch) PetscFunctionReturn(0);
  PetscCall(HdfGroup(file, "/pairs"));
  PetscCall(
      PetscMalloc3(2 * self->places, &which, self->shapes + 1, &first, self->shapes + 1, &row));
  for (PetscInt k = 0; k <= self->shapes; k++) {
    row[k] = k;
    first[k] = k ? self->until[k - 1] : 0;
  }
  for (PetscInt k = 0; k < 2 * self->places; k++) which[k] = self->place[k / 2].rod[k % 2];
  PetscCall(HdfColumn(file, "/pairs/first", HDF_INTS, self->shapes + 1, "1",
                      "first place of each shape, and behind the last [k+1]"));
  PetscCall(HdfPut(file, "/pairs/first", self->shapes + 1, row, first));
  PetscCall(HdfWrite(file, "/pairs/rods", 2, dims, which, "1",
                     "which two rods touch there, counted from 0 [c, 2]"));
  PetscCall(PetscFree3(which, first, row));
  PetscCall(WritePlaces(self, file, "/pairs/s", 2, offsetof(StrandPlace, s), "1",
                        "material labels of the middle of the place, on either [c, 2]"));
  PetscCall(WritePlaces(self, file, "/pairs/force", 3, offsetof(StrandPlace, force), "N l",
                        "force on the first, in the laboratory [c, 3]"));
  PetscCall(WritePlaces(self, file, "/pairs/gap", 1, offsetof(StrandPlace, gap), "l",
                        "the smallest gap there [c]"));
  PetscFunctionReturn(0);
}

/* What a rod bears where it is joined, and so does to its carrier, in all shapes: a set of theirs.
 */
static PetscErrorCode WriteBorne(const Several *self, HdfFile file, const char *set,
                                 const char *path, const char *units, const char *text) {
  const PetscInt joints = JointsCount(self->joints), dims[3] = {self->each[0]->shapes_n, joints, 3};
  PetscReal *all, *to;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(dims[0] * joints * 3, &all));
  to = all;
  for (PetscInt i = 0; i < dims[0]; i++)
    for (PetscInt j = 0; j < joints; j++) {
      const Joint *joint = JointsGet(self->joints, j);
      const Output one = self->each[joint->rod];
      const PetscInt node = joint->tip ? one->nodes - 1 : 0;
      int k = 0;
      while (strcmp(one->set[k].name, set) != 0) k++;
      const PetscReal *at = one->shape[k] + (i * one->nodes + node) * 3;
      for (int d = 0; d < 3; d++) *to++ = joint->tip ? -at[d] : at[d];
    }
  PetscCall(HdfWrite(file, path, 3, dims, all, units, text));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* Where rods hold each other: names, and the first of the carrier's two nodes there among all. */
static PetscErrorCode WriteJoints(const Several *self, HdfFile file) {
  const PetscInt n = JointsCount(self->joints);
  const char **of;
  PetscInt64 *node;
  PetscInt *row;

  PetscFunctionBegin;
  if (!n) PetscFunctionReturn(0);
  PetscCall(HdfGroup(file, "/joints"));
  PetscCall(PetscMalloc3(n, &of, n, &node, n, &row));
  for (int what = 0; what < 3; what++) {
    static const char *const path[] = {"/joints/name", "/joints/on", "/joints/end"},
                             *const text[] = {"rod that is held [j]", "rod that holds it [j]",
                                              "which end of it: base or tip [j]"};
    for (PetscInt j = 0; j < n; j++) {
      const Joint *joint = JointsGet(self->joints, j);
      const char *const said[] = {RodsName(self->rods, joint->rod),
                                  RodsName(self->rods, joint->carrier),
                                  joint->tip ? "tip" : "base"};
      of[j] = said[what];
      row[j] = j;
    }
    PetscCall(HdfColumn(file, path[what], HDF_TEXTS, n, "", text[what]));
    PetscCall(HdfPut(file, path[what], n, row, of));
  }
  for (PetscInt j = 0; j < n; j++) {
    const Joint *joint = JointsGet(self->joints, j);
    node[j] = joint->node;
    for (PetscInt k = 0; k < joint->carrier; k++) node[j] += self->each[k]->nodes;
  }
  PetscCall(HdfColumn(file, "/joints/node", HDF_INTS, n, "1",
                      "first of the two nodes there of the rod that holds it, in the shapes [j]"));
  PetscCall(HdfPut(file, "/joints/node", n, row, node));
  PetscCall(PetscFree3(of, node, row));
  PetscCall(WriteBorne(self, file, "/shapes/force", "/joints/force", "N l",
                       "force on the rod that holds, in the laboratory [k, j, 3]"));
  PetscCall(WriteBorne(self, file, "/shapes/moment", "/joints/moment", "N l^2",
                       "moment on it [k, j, 3]"));
  PetscFunctionReturn(0);
}

/* How far off any rod may be, once that is known. */
static PetscErrorCode WriteErrors(const Several *self, HdfFile file) {
  PetscReal most = 0, end = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    const ErrorEstimate *error = &self->each[k]->error;
    if (error->kind == ESTIMATE_NONE) PetscFunctionReturn(0);
    most = PetscMax(most, error->most.all);
    end = PetscMax(end, error->end.all);
  }
  PetscCall(HdfReal(file, "/", "error_estimate", most));
  PetscCall(HdfReal(file, "/", "error_end_estimate", end));
  PetscFunctionReturn(0);
}

/* Of which rod what has ended the run was, which that has written. */
static PetscErrorCode WriteEventRod(const Several *self, HdfFile file) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++)
    if (self->each[k]->event.kind)
      PetscCall(HdfText(file, "/event", "rod", RodsName(self->rods, k)));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteAll(const Several *self, HdfFile file, PetscReal t, PetscBool finished) {
  char *text;

  PetscFunctionBegin;
  PetscCall(OutputAttributes(file, PETSC_COMM_SELF, finished));
  PetscCall(HdfText(file, "/", "interrupted", self->each[0]->interrupted));
  PetscCall(HdfGroup(file, "/rods"));
  PetscCall(RodsText(self->rods, &text));
  PetscCall(HdfWriteText(file, "/rods/text", text, "the rods' own options, a section each"));
  PetscCall(PetscFree(text));
  PetscCall(WriteRods(self, file));
  PetscCall(WriteBirths(self, file));
  PetscCall(WriteLines(self, file));
  PetscCall(WriteSeries(self, file));
  PetscCall(WriteShapes(self, file));
  PetscCall(WriteJoints(self, file));
  PetscCall(WritePairs(self, file));
  PetscCall(WriteAbout(self, file, t));
  PetscCall(WriteErrors(self, file));
  PetscCall(WriteEventRod(self, file));
  PetscCall(self->keep(self->ctx, file));
  PetscFunctionReturn(0);
}

/* SeveralTouch - the places where rods touch in the shape that has been stored just now. */
PetscErrorCode SeveralTouch(Several *self, PetscInt n, const StrandPlace place[]) {
  PetscFunctionBegin;
  if (self->places + n > self->room) {
    self->room = 2 * self->room + n;
    PetscCall(PetscRealloc((size_t)self->room * sizeof(StrandPlace), &self->place));
  }
  PetscCall(PetscArraycpy(self->place + self->places, place, n));
  self->places += n;
  PetscCall(PetscRealloc((size_t)(self->shapes + 1) * sizeof(PetscInt), &self->until));
  self->until[self->shapes++] = self->places;
  PetscFunctionReturn(0);
}

/* SeveralBegin - may a file be written there? Behind all refusals of options. */
PetscErrorCode SeveralBegin(Several *self) {
  PetscFunctionBegin;
  PetscCall(PetscTime(&self->stored_at));
  if (self->path[0]) PetscCall(OutputRefuseTaken("-output", self->path));
  PetscFunctionReturn(0);
}

/* SeveralDue - is it time to store? */
PetscBool SeveralDue(const Several *self) {
  PetscLogDouble now;

  if (!self->path[0] || PetscTime(&now)) return PETSC_FALSE;
  return (PetscBool)(now - self->stored_at > PetscMax(soon, share * self->cost));
}

/* SeveralStore - brings all there is, up to time t, into the file. What cannot be written (a full
   disk) is a user's mistake: the file is then what it was before. */
PetscErrorCode SeveralStore(Several *self, PetscReal t, PetscBool finished) {
  char fault[HDF_FAULT] = "";
  PetscLogDouble begin;
  HdfFile file;

  PetscFunctionBegin;
  if (!self->path[0] || self->broken) PetscFunctionReturn(0);
  PetscCall(PetscTime(&begin));
  PetscCall(HdfCreate(self->path, &file));
  PetscCall(WriteAll(self, file, t, finished));
  PetscCall(HdfClose(&file, fault));
  self->broken = (PetscBool)(fault[0] != 0);
  UserCheck(!fault[0], PETSC_COMM_SELF,
            "-output %s: cannot be written: %s%s; make room, or name a file elsewhere", self->path,
            fault, self->there ? "; what was stored before is whole" : "");
  self->there = PETSC_TRUE;
  PetscCall(Describe(self, self->path));
  PetscCall(PetscTime(&self->stored_at));
  self->cost = self->stored_at - begin;
  PetscFunctionReturn(0);
}

static PetscErrorCode Save(const Several *self, const char *path, PetscReal t, PetscBool finished) {
  char fault[HDF_FAULT] = "";
  HdfFile file;

  PetscFunctionBegin;
  PetscCall(HdfCreate(path, &file));
  PetscCall(WriteAll(self, file, t, finished));
  PetscCall(HdfClose(&file, fault));
  UserCheck(!fault[0], OptionsComm(),
            "save %s: cannot be written: %s; make room, or name a file elsewhere", path, fault);
  PetscCall(Describe(self, path));
  PetscFunctionReturn(0);
}

/* SeveralSave - all there is up to time t, in another file; nothing changes for what comes after.

   last  a row more of the series of each, [rods]; NULL: none */
PetscErrorCode SeveralSave(Several *self, const char *path, PetscReal t,
                           const Observation *const last[], PetscBool finished) {
  const PetscInt shapes = self->shapes, places = self->places;
  PetscErrorCode error;
  struct _Output *kept;

  PetscFunctionBegin;
  PetscCall(OutputRefuseTaken("save", path));
  PetscCall(PetscMalloc1(self->n, &kept));
  for (PetscInt k = 0; k < self->n; k++)
    PetscCall(OutputCut(self->each[k], t, last ? last[k] : NULL, &kept[k]));
  if (shapes) {
    self->shapes = self->each[0]->shapes_n;
    self->places = self->shapes ? self->until[self->shapes - 1] : 0;
  }
  error = Save(self, path, t, finished);
  self->shapes = shapes;
  self->places = places;
  for (PetscInt k = 0; k < self->n; k++) PetscCall(OutputUncut(self->each[k], &kept[k]));
  PetscCall(PetscFree(kept));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* SeveralDropShape - forgets the shapes that were stored last. */
void SeveralDropShape(Several *self) {
  for (PetscInt k = 0; k < self->n; k++) OutputDropShape(self->each[k]);
  if (!self->shapes) return;
  self->shapes--;
  self->places = self->shapes ? self->until[self->shapes - 1] : 0;
}

/* SeveralHas - is this series one of all rods, too? */
PetscBool SeveralHas(const Several *self, PetscInt observed) {
  return (PetscBool)(OfAll(observed) != NONE && Holds(self, observed));
}

/* SeveralSum - a number of all rods, from that of each; NaN of those that have none. */
PetscReal SeveralSum(const Several *self, PetscInt observed, const PetscReal of_each[]) {
  return Together(OfAll(observed), self->n, of_each);
}

/* ---- going on ---- */

/* One series of all rods, up to a row. */
static PetscErrorCode TakeSeries(const Several *self, const char *from, int observed,
                                 PetscInt rows) {
  const PetscBool same = (PetscBool)(OfAll(observed) == SAME);
  PetscInt dims[] = {0, 1};
  PetscReal *value;
  char path[96];

  PetscFunctionBegin;
  (void)snprintf(path, sizeof(path), same ? "/series/%s" : "/rods/series/%s",
                 observed_name[observed]);
  PetscCall(HdfReadGaps("-restart", from, path, same ? 1 : 2, dims, &value));
  for (PetscInt i = 0; i < PetscMin(rows, dims[0]); i++)
    for (PetscInt k = 0; k < self->n; k++)
      ((PetscReal *)&self->each[k]->series[i])[observed] =
          value[same ? i : i * dims[1] + PetscMin(k, dims[1] - 1)];
  PetscCall(PetscFree(value));
  PetscFunctionReturn(0);
}

/* One set of the shapes of all rods, up to one. */
static PetscErrorCode TakeSet(const Several *self, const char *from, int set, PetscInt shapes) {
  const ShapeSet *is = &Fullest(self)->set[set];
  const PetscInt width = PetscMax(1, is->components);
  const int rank = !is->components ? 1 : width == 1 ? 2 : 3;
  PetscInt dims[3] = {0}, at = 0;
  PetscReal *value;

  PetscFunctionBegin;
  PetscCall(HdfReadGaps("-restart", from, is->name, rank, dims, &value));
  for (PetscInt k = 0; k < self->n; k++) {
    Output one = self->each[k];
    const PetscInt size = set < one->sets ? OutputShapeSize(one, set) : 0,
                   row = is->components ? dims[1] * width : 1;
    PetscCall(PetscMalloc1(shapes * size, &one->shape[set]));
    for (PetscInt i = 0; i < shapes; i++)
      PetscCall(PetscArraycpy(one->shape[set] + i * size,
                              value + i * row + (is->components ? at * width : 0), size));
    at += one->nodes;
  }
  PetscCall(PetscFree(value));
  PetscFunctionReturn(0);
}

/* The places of so many shapes. */
static PetscErrorCode TakePairs(Several *self, const char *from, PetscInt shapes) {
  PetscReal *first, *which, *s, *force, *gap;
  PetscInt n, dims[2];
  PetscBool there;

  PetscFunctionBegin;
  PetscCall(HdfHas(from, "/pairs/first", &there));
  if (!self->touch || !there) PetscFunctionReturn(0);
  PetscCall(HdfRead("-restart", from, "/pairs/first", 1, &n, &first));
  PetscCall(HdfRead("-restart", from, "/pairs/rods", 2, dims, &which));
  PetscCall(HdfRead("-restart", from, "/pairs/s", 2, dims, &s));
  PetscCall(HdfRead("-restart", from, "/pairs/force", 2, dims, &force));
  PetscCall(HdfRead("-restart", from, "/pairs/gap", 1, dims, &gap));
  for (PetscInt k = 0; k < PetscMin(shapes, n - 1); k++) {
    const PetscInt begin = (PetscInt)first[k], count = (PetscInt)first[k + 1] - begin;
    StrandPlace *place;
    PetscCall(PetscMalloc1(count, &place));
    for (PetscInt c = 0; c < count; c++) {
      const PetscInt at = begin + c;
      place[c] = (StrandPlace){.rod = {(PetscInt)which[2 * at], (PetscInt)which[2 * at + 1]},
                               .s = {s[2 * at], s[2 * at + 1]},
                               .gap = gap[at]};
      PetscCall(PetscArraycpy(place[c].force, force + 3 * at, 3));
    }
    PetscCall(SeveralTouch(self, count, place));
    PetscCall(PetscFree(place));
  }
  PetscCall(PetscFree(first));
  PetscCall(PetscFree(which));
  PetscCall(PetscFree(s));
  PetscCall(PetscFree(force));
  PetscCall(PetscFree(gap));
  PetscFunctionReturn(0);
}

/* SeveralTake - reads what a file holds of the rods up to a time; as OutputContinue() has it. */
PetscErrorCode SeveralTake(Several *self, const char *from, PetscReal t, PetscReal interval) {
  PetscReal *times;
  PetscInt rows, shapes;

  PetscFunctionBegin;
  PetscCall(OutputUpTo(from, PETSC_COMM_SELF, t, interval, &rows, &shapes, &times));
  for (PetscInt k = 0; k < self->n; k++) {
    Output one = self->each[k];
    PetscCall(OutputRoom(one, rows));
    one->series_n = rows;
    one->shapes_n = one->shapes_room = one->times_n = one->times_room = shapes;
    PetscCall(PetscMalloc1(shapes, &one->times));
    PetscCall(PetscArraycpy(one->times, times, shapes));
  }
  PetscCall(PetscFree(times));
  for (int i = 0; i < OBSERVED; i++)
    if (Holds(self, i)) PetscCall(TakeSeries(self, from, i, rows));
  for (int set = 0; set < Fullest(self)->sets; set++) PetscCall(TakeSet(self, from, set, shapes));
  PetscCall(TakePairs(self, from, shapes));
  PetscFunctionReturn(0);
}

/* SeveralLabels - gives the scene of rod k the file's mesh, which may depend on the end time.
   joints: so many others are joined to the rod, for each of which the file has a node more, or two.
 */
PetscErrorCode SeveralLabels(const char *from, PetscInt k, PetscInt joints, Scene scene) {
  Mesh *mesh = &scene->mesh;
  PetscReal *s, *first, *count;
  PetscInt n, rods, cells = 0;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(HdfRead("-restart", from, "/shapes/s", 1, &n, &s));
  PetscCall(HdfRead("-restart", from, "/rods/first", 1, &rods, &first));
  PetscCall(HdfRead("-restart", from, "/rods/count", 1, &rods, &count));
  if (k < rods && (PetscInt)(first[k] + count[k]) <= n) cells = (PetscInt)count[k] - 1;
  same = (PetscBool)(cells >= mesh->cells && cells <= mesh->cells + 2 * joints);
  if (same) {
    mesh->cells = cells;
    PetscCall(PetscRealloc((size_t)(cells + 1) * sizeof(*s), &mesh->s));
    PetscCall(PetscArraycpy(mesh->s, s + (PetscInt)first[k], cells + 1));
  }
  PetscCall(PetscFree(s));
  PetscCall(PetscFree(first));
  PetscCall(PetscFree(count));
  UserCheck(same, OptionsComm(), "-rod_cells %d: the run in -restart %s has another number",
            (int)mesh->cells, from);
  PetscFunctionReturn(0);
}

PetscErrorCode SeveralEnd(Several *self) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->place));
  PetscCall(PetscFree(self->until));
  if (self->path[0]) PetscCall(LockGive(self->path));
  PetscFunctionReturn(0);
}
