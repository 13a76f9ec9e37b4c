#include "record/output.h"
#include "base/lock.h"
#include "record/xdmf.h"
#include "rod/directors.h"
#include <errno.h>
#include <petsctime.h>
#include <sys/stat.h>
#include <unistd.h>

/* What is stored of a shape. */
enum { PLANE = SHAPE_SETS, CONTACT = CONTACT_SET };
const struct ShapeSet shape_sets[SHAPE_SETS] = {
    {"/shapes/t", "l/V", "times of the stored shapes", 0},
    {"/shapes/x", "l", "position x1, x2 [k, n, 2]", 2},
    {"/shapes/theta", "rad", "tangent angle [k, n]", 1},
    {"/shapes/curvature", "1/l", "curvature theta'/g: of the moment, m/B, and natural, k0 [k, n]",
     1},
    {"/shapes/force", "N l", "internal force n1, n2 [k, n, 2]", 2},
    {"/shapes/natural_curvature", "1/l", "natural curvature k0 [k, n]", 1},
    {"/shapes/stretch", "l", "stretch g = |x'| [k, n]", 1},
    {"/shapes/contact", "N", "force of contact per length, on the rod; without friction [k, n, 2]",
     2}};
/* ... of a rod in space. */
enum { SHAPES = 13, CONTACT_3 = SHAPES - 1 };
static const struct ShapeSet space_sets[SHAPES] = {
    {"/shapes/t", "l/V", "times of the stored shapes", 0},
    {"/shapes/x", "l", "position x1, x2, x3 [k, n, 3]", 3},
    {"/shapes/theta", "rad", "angle of the tangent against the clamp's axis, 0 to pi [k, n]", 1},
    {"/shapes/strain", "1/l", "twist u1 and bends u2, u3 about the directors [k, n, 3]", 3},
    {"/shapes/force", "N l", "internal force n1, n2, n3 [k, n, 3]", 3},
    {"/shapes/natural_strain", "1/l", "natural twist and bends about the directors [k, n, 3]", 3},
    {"/shapes/stretch", "l", "stretch g = |x'| [k, n]", 1},
    {"/shapes/moment", "N l^2", "internal moment m1, m2, m3 [k, n, 3]", 3},
    {"/shapes/d1", "1", "director d1, the tangent [k, n, 3]", 3},
    {"/shapes/d2", "1", "director d2 of the cross-section [k, n, 3]", 3},
    {"/shapes/d3", "1", "director d3 of the cross-section [k, n, 3]", 3},
    {"/shapes/curvature", "1/l", "curvature of the centre line, |u2, u3| [k, n]", 1},
    {"/shapes/contact", "N", "force of contact per length, on the rod; without friction [k, n, 3]",
     3}};

static const char *const meaning_of_units =
    "l = (YI/N)^(1/3), N the friction per length at the speed V of the tip, YI the bending "
    "stiffness; "
    "si_length and the like, if given, say what 1 is in SI units";

/* A store copies the file, so that it is whole at any time. One is due where a shape waits for a
   second, else every ten, and later where storing has taken long: it is to take a twentieth of the
   time at most. Nor is more kept back than a share of the file, or what is nothing to a machine. */
static const PetscLogDouble soon = 1, late = 10, share = 20;
static const double kept_back = 6.4e7, kept_share = 0.25;

/* What a number of the scene changes: of what is stored, by it. */
typedef struct {
  char name[64], unit[32];
  PetscReal number;
  Harvest harvest; /* owned */
} Derivative;

/* Only rank 0 has a file; the others hold an empty shell and share the verdict on errors. */
struct _Output {
  Scene scene;
  char path[PETSC_MAX_PATH_LEN]; /* empty: nothing is stored */
  PetscBool mine, there, broken; /* this rank writes it; it has been written; it could not be */
  PetscBool series_kept, shapes_kept; /* for OutputHarvest() */
  char from[PETSC_MAX_PATH_LEN]; /* what the next store begins with: the file itself, as a rule */
  PetscInt cut[2];               /* -1, or how many series and shapes of it to keep */
  PetscInt series_n, series_room;
  Observation *series; /* that wait to be stored */
  PetscInt shapes_n, shapes_room;
  PetscReal *shape[SHAPES]; /* that wait to be stored */
  PetscInt times_n, times_room;
  PetscReal *times; /* of all shapes, stored and waiting */
  Event event;
  PetscBool follows;    /* errors are followed, and are series */
  ErrorEstimate error;  /* of kind none until the run has ended */
  char interrupted[64]; /* by what; empty: it is not */
  PetscInt derivatives_n;
  Derivative *derivatives; /* none until the run has ended */
  char *earlier;           /* the options of earlier legs */
  PetscLogDouble stored_at, cost;
  double stored, waits; /* bytes */
};

/* OutputHolds - is a series one of this run? */
PetscBool OutputHolds(const Output self, int observed) {
  return (PetscBool)(ObservedIn(self->scene, observed) &&
                     (self->follows || strncmp(observed_name[observed], "error_", 6)));
}

/* How many sets there are. */
static int Sets(Output self) {
  if (self->scene->space.rod) return self->scene->contact.any ? SHAPES : CONTACT_3;
  return self->scene->contact.any ? PLANE : CONTACT;
}

static const struct ShapeSet *SetOf(Output self, int set) {
  return self->scene->space.rod ? &space_sets[set] : &shape_sets[set];
}

/* How many values a shape has in a set. */
static PetscInt ShapeSize(Output self, int set) {
  PetscInt per_node = SetOf(self, set)->components;
  return per_node ? per_node * (self->scene->mesh.cells + 1) : 1;
}

/* Makes room for one more of n entries of `size` reals. */
static PetscErrorCode Room(PetscInt n, PetscInt *room, size_t size, void *array) {
  PetscFunctionBegin;
  if (n < *room) PetscFunctionReturn(0);
  *room = 2 * *room + 16;
  PetscCall(PetscRealloc((size_t)*room * size * sizeof(PetscReal), (void **)array));
  PetscFunctionReturn(0);
}

/* The value of each option in force, defaults included. */
static PetscErrorCode ParameterAttributes(HdfFile file) {
  char *all, name[128];

  PetscFunctionBegin;
  PetscCall(OptionsInForce(&all));
  for (char *line = strtok(all, "\n"); line; line = strtok(NULL, "\n")) {
    char *value = line + strcspn(line, " ");
    const OptionRow *row;
    *value++ = 0;
    (void)snprintf(name, sizeof(name), "-%s", line);
    row = OptionFind(name);
    (void)snprintf(name, sizeof(name), "parameters/%s", line);
    if (row->kind == KIND_REAL)
      PetscCall(HdfReal(file, "/", name, strtod(value, NULL)));
    else if (row->kind == KIND_INT)
      PetscCall(HdfInt(file, "/", name, (int)strtol(value, NULL, 10)));
    else
      PetscCall(HdfText(file, "/", name, value));
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* OutputVersions - what wrote a result, and what its units mean. */
PetscErrorCode OutputVersions(HdfFile file) {
  char version[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(version, sizeof(version), "%d.%d.%d", PETSC_VERSION_MAJOR,
                          PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR));
  PetscCall(HdfText(file, "/", "version", TENDRIL_VERSION));
  PetscCall(HdfText(file, "/", "petsc_version", version));
  PetscCall(HdfText(file, "/", "units", meaning_of_units));
  PetscFunctionReturn(0);
}

/* OutputAttributes - what a result is of: options, versions, ranks; and whether it is finished. */
PetscErrorCode OutputAttributes(HdfFile file, MPI_Comm comm, PetscBool finished) {
  char *options;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCall(OptionsList(&options));
  PetscCall(HdfText(file, "/", "options", options));
  PetscCall(PetscFree(options));
  PetscCall(ParameterAttributes(file));
  PetscCall(OutputVersions(file));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(HdfInt(file, "/", "ranks", ranks));
  PetscCall(HdfInt(file, "/", "finished", finished));
  PetscFunctionReturn(0);
}

/* What keeps files from being made in the directory of a path, as errno has it; 0: nothing. */
static int Closed(const char *path, char directory[PETSC_MAX_PATH_LEN]) {
  const char *slash = strrchr(path, '/');
  struct stat status;

  (void)snprintf(directory, PETSC_MAX_PATH_LEN, "%.*s", slash ? (int)(slash - path) : 1,
                 slash ? path : ".");
  if (stat(directory[0] ? directory : "/", &status)) return errno;
  if (!S_ISDIR(status.st_mode)) return ENOTDIR;
  return access(directory[0] ? directory : "/", W_OK | X_OK) ? errno : 0;
}

/* Before anything is computed: is there the directory that the file is to be in? Collective. */
static PetscErrorCode RefuseNowhere(const char *option, const char *path) {
  char directory[PETSC_MAX_PATH_LEN];
  PetscMPIInt rank;
  int fault;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &rank));
  fault = Closed(path, directory);
  PetscCallMPI(MPI_Bcast(&fault, 1, MPI_INT, 0, OptionsComm()));
  UserCheck(fault != ENOENT, OptionsComm(),
            "%s %s: there is no directory %s; make it (mkdir -p %s), or name a file elsewhere",
            option, path, directory, directory);
  UserCheck(!fault, OptionsComm(), "%s %s: no file can be made there: %s; name a file elsewhere",
            option, path, strerror(fault));
  PetscFunctionReturn(0);
}

/* OutputRefuse - refuses to write over what is no result of tendril, or an input, and where no file
   can be made. Collective. */
PetscErrorCode OutputRefuse(const char *option, const char *path) {
  struct stat status;
  PetscBool ours;
  int free;

  PetscFunctionBegin;
  PetscCall(OptionsRefuseOverwrite(option, path));
  PetscCall(HdfHas(path, "version", &ours));
  /* rank 0 looks for all: when a later one does, the file may be that of this very run */
  free = stat(path, &status) || (S_ISREG(status.st_mode) && !status.st_size);
  PetscCallMPI(MPI_Bcast(&free, 1, MPI_INT, 0, OptionsComm()));
  UserCheck(ours || free, OptionsComm(),
            "%s %s: is there, and is no result of tendril; name another file, or take it away",
            option, path);
  PetscCall(RefuseNowhere(option, path));
  PetscFunctionReturn(0);
}

/* As OutputRefuse(); nor does a single run take the place of a whole sweep, or write what another
   process is writing. */
static PetscErrorCode RefuseTaken(const char *option, const char *path) {
  PetscBool sweep;

  PetscFunctionBegin;
  PetscCall(OutputRefuse(option, path));
  PetscCall(HdfHas(path, "/status", &sweep));
  UserCheck(!sweep, OptionsComm(), "%s %s: holds a sweep; name another file, or take it away",
            option, path);
  /* files of a sweep's members are in the sweep's keeping */
  if (!OptionsPushed()) PetscCall(LockTake(OptionsComm(), option, path));
  PetscFunctionReturn(0);
}

/* All ranks learn what rank 0 has met. */
static PetscErrorCode Verdict(const char *option, const char *path, MPI_Comm comm,
                              char fault[HDF_FAULT]) {
  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(fault, HDF_FAULT, MPI_CHAR, 0, comm));
  UserCheck(!fault[0], comm, "%s %s: cannot be written: %s; make room, or name a file elsewhere",
            option, path, fault);
  PetscFunctionReturn(0);
}

/* OutputNewFile - a new result file, on rank 0 (on the others it is NULL). Collective; the caller
   ends it with OutputEndFile(). A path that cannot be written is a user's mistake. */
PetscErrorCode OutputNewFile(const char *option, const char *path, MPI_Comm comm, HdfFile *file) {
  char fault[HDF_FAULT] = "";
  PetscMPIInt rank;

  PetscFunctionBegin;
  *file = NULL;
  PetscCall(RefuseTaken(option, path));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) {
    PetscCall(HdfCreate(path, file));
    if (HdfFault(*file)) PetscCall(HdfClose(file, fault));
  }
  PetscCall(Verdict(option, path, comm, fault));
  PetscFunctionReturn(0);
}

/* OutputEndFile - ends what OutputNewFile() began. Collective. */
PetscErrorCode OutputEndFile(const char *option, const char *path, MPI_Comm comm, HdfFile *file) {
  char fault[HDF_FAULT] = "";

  PetscFunctionBegin;
  PetscCall(HdfClose(file, fault));
  PetscCall(LockGive(path));
  PetscCall(Verdict(option, path, comm, fault));
  PetscFunctionReturn(0);
}

/* OutputDropFile - ends it without a result. */
PetscErrorCode OutputDropFile(const char *path, HdfFile *file) {
  PetscFunctionBegin;
  PetscCall(HdfDrop(file));
  PetscCall(LockGive(path));
  PetscFunctionReturn(0);
}

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
  const Changes changes = self->scene->changes;
  char *text;

  PetscFunctionBegin;
  if (changes && changes->done) {
    PetscCall(ChangesText(changes, &text));
    PetscCall(HdfWriteText(file, "changes", text,
                           "what was changed in the run: time, what, and its new value"));
    PetscCall(PetscFree(text));
  }
  if (self->scene->load.shared)
    PetscCall(HdfReal(file, "/", "viscous_share", 1 - self->scene->load.friction.mu));
  PetscCall(SceneContactAt(self->scene, t));
  if (self->scene->contact.any)
    PetscCall(HdfReal(file, "/", "contact_stiffness", self->scene->contact.stiffness));
  if (self->scene->contact.firm)
    PetscCall(HdfReal(file, "/", "contact_firm", ContactFirmTimes(&self->scene->contact)));
  if (!self->scene->contact.walls.n && !self->scene->contact.surfaces.n) PetscFunctionReturn(0);
  PetscCall(ContactWallsText(&self->scene->contact, &text));
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

/* An empty file's groups and datasets. */
static PetscErrorCode Layout(Output self, HdfFile file) {
  PetscInt n = self->scene->mesh.cells + 1;
  char path[64];

  PetscFunctionBegin;
  PetscCall(HdfGroup(file, "/series"));
  PetscCall(HdfGroup(file, "/shapes"));
  for (int i = 0; i < OBSERVED; i++) {
    if (!OutputHolds(self, i)) continue;
    (void)snprintf(path, sizeof(path), "/series/%s", observed_name[i]);
    PetscCall(HdfAppendable(file, path, 0, NULL, observed_units[i], observed_text[i]));
  }
  PetscCall(HdfWrite(file, "/shapes/s", 1, &n, self->scene->mesh.s, "1",
                     "material label of the nodes [n]"));
  for (int i = 0; i < Sets(self); i++) {
    const struct ShapeSet *set = SetOf(self, i);
    PetscInt row[2] = {n, set->components};
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
  for (int i = 0; i < Sets(self); i++)
    PetscCall(HdfTruncate(file, SetOf(self, i)->name, self->cut[1]));
  PetscCall(HdfDelete(file, "/event"));
  PetscCall(HdfDelete(file, "/sensitivity"));
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
    const struct ShapeSet *set = SetOf(self, i);
    const PetscInt dims[3] = {harvest->shapes, harvest->nodes, set->components};
    (void)snprintf(path, sizeof(path), "/sensitivity/%s%s", by->name, set->name);
    if (set->components)
      PetscCall(
          HdfWrite(file, path, set->components > 1 ? 3 : 2, dims, from, set->units, set->text));
    from += harvest->shapes * ShapeSize(self, i);
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
  for (int i = 0; i < Sets(self); i++)
    PetscCall(HdfAppend(file, SetOf(self, i)->name, self->shapes_n, self->shape[i]));
  PetscFunctionReturn(0);
}

/* Turns a vector from the clamp's frame to the laboratory's. */
static inline void Turn(Scene scene, const PetscReal v[2], PetscReal to[2]) {
  PetscReal c = PetscCosReal(scene->clamp_angle), s = PetscSinReal(scene->clamp_angle);
  to[0] = c * v[0] - s * v[1];
  to[1] = s * v[0] + c * v[1];
}

static PetscErrorCode WriteEvent(Output self, HdfFile file) {
  const Event *event = &self->event;
  const PetscInt two = 2;
  PetscReal x[2];

  PetscFunctionBegin;
  if (event->kind == EVENT_NONE) PetscFunctionReturn(0);
  PetscCall(HdfDelete(file, "/event"));
  PetscCall(HdfGroup(file, "/event"));
  PetscCall(HdfWrite(file, "/event/t", 0, NULL, &event->t, "l/V", "its time"));
  PetscCall(HdfWrite(file, "/event/s", 1, &two, event->s, "1",
                     "labels of the places concerned; twice the same if it is one"));
  Turn(self->scene, event->x, x);
  PetscCall(HdfWrite(file, "/event/x", 1, &two, x, "l", "position x1, x2"));
  PetscCall(HdfText(file, "/event", "kind", event_name[event->kind]));
  PetscFunctionReturn(0);
}

/* Appends vectors, as rows, to a dataset made here: one at a time on rank 0, where all of them need
   not fit; adds up the absolute values. Collective. */
static PetscErrorCode WriteVectors(HdfFile file, const char *name, const char *text, PetscInt n,
                                   Vec vectors[], PetscReal *sum) {
  const PetscScalar *a;
  VecScatter to_zero;
  PetscInt length;
  Vec all;

  PetscFunctionBegin;
  PetscCall(VecGetSize(vectors[0], &length));
  PetscCall(HdfAppendable(file, name, 1, &length, "mixed", text));
  PetscCall(VecScatterCreateToZero(vectors[0], &to_zero, &all));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(VecScatterBegin(to_zero, vectors[i], all, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(to_zero, vectors[i], all, INSERT_VALUES, SCATTER_FORWARD));
    if (!file) continue;
    PetscCall(VecGetArrayRead(all, &a));
    for (PetscInt k = 0; k < length; k++) *sum += PetscAbsReal(a[k]);
    PetscCall(HdfAppend(file, name, 1, a));
    PetscCall(VecRestoreArrayRead(all, &a));
  }
  PetscCall(VecScatterDestroy(&to_zero));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteMemory(HdfFile file, Rod rod, PetscReal *sum) {
  Vec memory;
  DM da;

  PetscFunctionBegin;
  if (!rod->memory) PetscFunctionReturn(0);
  PetscCall(RodCreateMemory(rod, &da, &memory));
  PetscCall(rod->model->remember(rod, memory));
  PetscCall(WriteVectors(file, "/restart/memory",
                         "what Newton's method remembers from step to step [1][node times values]",
                         1, &memory, sum));
  PetscCall(VecDestroy(&memory));
  PetscCall(DMDestroy(&da));
  PetscFunctionReturn(0);
}

/* What the run needs to go on from here, in the place of what stood there. Collective. */
static PetscErrorCode WriteRestart(Output self, HdfFile file, Rod rod, RestartState *state,
                                   Vec points[], Vec errors[]) {
  const PetscInt n = RESTART_STATE, scales = UNIT_ALL, two = 2;
  const Space *space = &self->scene->space;
  const PetscReal clamp[2] = {space->spun, space->spins_from};

  PetscFunctionBegin;
  PetscCall(HdfDelete(file, "/restart"));
  if (!state) PetscFunctionReturn(0);
  PetscCall(HdfGroup(file, "/restart"));
  state->sum = 0;
  PetscCall(WriteVectors(file, "/restart/points",
                         "the stepper's past points, latest first [point][node times fields]",
                         (PetscInt)state->points, points, &state->sum));
  PetscCall(WriteMemory(file, rod, &state->sum));
  state->errors_sum = 0;
  if (errors)
    PetscCall(WriteVectors(file, "/restart/errors",
                           "the errors that are followed [part][node times fields]", ESTIMATE_KEPT,
                           errors, &state->errors_sum));
  PetscCall(HdfWrite(file, "/restart/state", 1, &n, (const PetscReal *)state, "mixed",
                     "time, step and history of the stepper, for -restart"));
  if (space->spins_from > 0)
    PetscCall(HdfWrite(file, "/restart/clamp", 1, &two, clamp, "rad, l/V",
                       "by how much the clamp had turned when its rate was changed, and when"));
  PetscCall(HdfWrite(file, "/restart/scales", 1, &scales, self->scene->si.scale, "SI",
                     "the scales of the rod in the laboratory, 0: none"));
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
  PetscCall(XdmfWrite(self->path, self->scene->mesh.cells + 1, self->times_n, self->times,
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
    PetscCall(WriteEvent(self, file));
    PetscCall(WriteDerivatives(self, file));
    PetscCall(OutputAttributes(file, self->scene->comm, finished));
    PetscCall(HdfText(file, "/", "interrupted", self->interrupted));
    PetscCall(ScaleAttributes(self, file));
    PetscCall(LawAttributes(self, file, state ? state->t : 0));
    PetscCall(ErrorAttributes(self, file));
    if (self->earlier)
      PetscCall(HdfWriteText(file, "earlier_options", self->earlier, "options of the runs before"));
  }
  PetscCall(WriteRestart(self, file, rod, state, points, errors));
  PetscCall(HdfClose(&file, fault));
  PetscCallMPI(MPI_Bcast(fault, HDF_FAULT, MPI_CHAR, 0, self->scene->comm));
  self->broken = (PetscBool)(fault[0] != 0);
  UserCheck(!fault[0], self->scene->comm,
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
  (*output)->cut[0] = (*output)->cut[1] = -1;
  PetscCall(PetscStrncpy((*output)->path, path, sizeof((*output)->path)));
  PetscCallMPI(MPI_Comm_rank(scene->comm, &rank));
  (*output)->mine = (PetscBool)(!rank && path[0]);
  if (path[0]) PetscCall(RefuseTaken("-output", path));
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

/* OutputKeep - what comes from here on is kept in memory, of an output without a file. */
PetscErrorCode OutputKeep(Output self, PetscBool series, PetscBool shapes) {
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(self->scene->comm, &rank));
  self->series_kept = (PetscBool)(!rank && series);
  self->shapes_kept = (PetscBool)(!rank && shapes);
  PetscFunctionReturn(0);
}

/* The first of an observation, as many as a harvest has; those that a scene has not are NAN. */
static PetscReal *Observed(Output self, const Observation *seen, PetscInt values, PetscReal *to) {
  for (PetscInt k = 0; k < values; k++)
    to[k] = OutputHolds(self, (int)k) ? ((const PetscReal *)seen)[k] : NAN;
  return to + values;
}

/* OutputHarvest - hands over what was kept, with the last observation; on rank 0 of the run.
   values: how many of each observation, from the first on. */
PetscErrorCode OutputHarvest(Output self, const Observation *last, PetscInt values,
                             Harvest *harvest) {
  size_t n = (size_t)values * (1 + (size_t)self->series_n);
  PetscReal *to;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(harvest, sizeof(*harvest)));
  harvest->values = values;
  harvest->steps = self->series_n;
  harvest->shapes = self->shapes_n;
  if (self->shapes_n) harvest->nodes = self->scene->mesh.cells + 1;
  for (int i = 0; i < CONTACT_SET; i++) n += (size_t)(self->shapes_n * ShapeSize(self, i));
  harvest->n = n + (size_t)harvest->nodes;
  PetscCall(PetscMalloc1(harvest->n, &harvest->data));
  to = Observed(self, last, values, harvest->data);
  for (PetscInt k = 0; k < self->series_n; k++) to = Observed(self, &self->series[k], values, to);
  PetscCall(PetscArraycpy(to, self->scene->mesh.s, harvest->nodes));
  to += harvest->nodes;
  for (int i = 0; i < CONTACT_SET; i++) {
    PetscCall(PetscArraycpy(to, self->shape[i], self->shapes_n * ShapeSize(self, i)));
    to += self->shapes_n * ShapeSize(self, i);
  }
  PetscFunctionReturn(0);
}

/* Is t one of the times at which shapes are stored? Those are added up as a run does; 0, near to
   which a run may take many steps, is none of them. */
static PetscBool OnGrid(PetscReal t, PetscReal interval) {
  PetscReal due = interval;

  while (due < t * (1 - 1e-12)) due += interval;
  return (PetscBool)(due <= t * (1 + 1e-12));
}

/* How many of n increasing times are at or before t. */
static PetscInt CountUpTo(PetscInt n, const PetscReal times[], PetscReal t) {
  while (n > 0 && times[n - 1] > t * (1 + 1e-12)) n--;
  return n;
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
  PetscInt series, shapes, n;
  PetscBool good;

  PetscFunctionBegin;
  PetscCall(HdfRead("-restart", from, "/series/t", 1, &n, &times));
  series = CountUpTo(n, times, t);
  good = (PetscBool)(series > 0 && PetscAbsReal(times[series - 1] - t) <= 1e-12 * t);
  PetscCall(PetscFree(times));
  UserCheck(good, scene->comm, "-restart %s: its series end before its last state", from);
  PetscCall(HdfRead("-restart", from, "/shapes/t", 1, &n, &times));
  shapes = CountUpTo(n, times, t);
  if (shapes > 1 && times[shapes - 1] > t * (1 - 1e-12) && !OnGrid(t, interval)) shapes--;
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

/* The series of a file, as far as they are wanted. */
static PetscErrorCode TakeSeries(Output self, const char *from, PetscInt n) {
  PetscReal *values;
  PetscInt rows;
  char path[64];

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n, &self->series));
  self->series_n = self->series_room = n;
  for (int k = 0; k < OBSERVED; k++) {
    if (!OutputHolds(self, k)) continue;
    (void)snprintf(path, sizeof(path), "/series/%s", observed_name[k]);
    PetscCall(HdfRead("-restart", from, path, 1, &rows, &values));
    for (PetscInt i = 0; i < PetscMin(n, rows); i++) ((PetscReal *)&self->series[i])[k] = values[i];
    PetscCall(PetscFree(values));
  }
  PetscFunctionReturn(0);
}

/* ... and its shapes. */
static PetscErrorCode TakeShapes(Output self, const char *from, PetscInt n) {
  PetscInt dims[3];
  PetscReal *values;

  PetscFunctionBegin;
  self->shapes_n = self->shapes_room = n;
  for (int k = 0; k < Sets(self); k++) {
    const PetscInt components = SetOf(self, k)->components;
    const int rank = components == 0 ? 1 : components == 1 ? 2 : 3;
    PetscCall(HdfRead("-restart", from, SetOf(self, k)->name, rank, dims, &values));
    PetscCall(PetscMalloc1(n * ShapeSize(self, k), &self->shape[k]));
    PetscCall(PetscArraycpy(self->shape[k], values, PetscMin(n, dims[0]) * ShapeSize(self, k)));
    PetscCall(PetscFree(values));
  }
  PetscFunctionReturn(0);
}

/* OutputTakeOver - as OutputContinue(), of an output that stores nothing by itself and keeps all in
   memory: what there is of the run before is read. Collective.

   follows  as OutputFollows() has it */
PetscErrorCode OutputTakeOver(const char *from, Scene scene, PetscReal t, PetscReal interval,
                              PetscBool follows, Output *output) {
  Output self;

  PetscFunctionBegin;
  PetscCall(OutputContinue(NULL, from, scene, t, interval, output));
  self = *output;
  PetscCall(OutputKeep(self, PETSC_TRUE, PETSC_TRUE));
  self->follows = follows;
  PetscCall(TakeSeries(self, from, self->cut[0]));
  PetscCall(TakeShapes(self, from, self->cut[1]));
  self->cut[0] = self->cut[1] = -1;
  self->from[0] = 0;
  PetscFunctionReturn(0);
}

/* OutputRows - the observations that are kept in memory, on the first rank. Borrowed. */
void OutputRows(Output self, PetscInt *n, const Observation **rows) {
  *n = self->series_n;
  *rows = self->series;
}

/* OutputDropShape - takes off again the shape that was added last. */
void OutputDropShape(Output self) {
  if (!self->shapes_kept) return;
  self->shapes_n--;
  self->times_n--;
}

/* The rows up to a time, and one more. */
static PetscErrorCode RowsUpTo(Output self, PetscReal t, const Observation *last,
                               Observation **rows, PetscInt *n) {
  PetscFunctionBegin;
  *n = self->series_n;
  while (*n > 0 && self->series[*n - 1].t > t * (1 + 1e-12)) --*n;
  PetscCall(PetscMalloc1(*n + 1, rows));
  PetscCall(PetscArraycpy(*rows, self->series, *n));
  if (last) (*rows)[(*n)++] = *last;
  PetscFunctionReturn(0);
}

/*
  OutputSave - writes all that is kept in memory, up to a time, into a file; nothing changes for
  what comes after. Collective.

  path           the file
  t              what is later is left out
  last           a row more, of the series; NULL: none
  state, points, errors, finished  as of OutputStore()
*/
PetscErrorCode OutputSave(Output self, const char *path, PetscReal t, const Observation *last,
                          Rod rod, RestartState *state, Vec points[], Vec errors[],
                          PetscBool finished) {
  struct _Output kept = *self;
  PetscErrorCode error;
  Observation *rows;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(RefuseTaken("save", path));
  PetscCallMPI(MPI_Comm_rank(self->scene->comm, &rank));
  PetscCall(RowsUpTo(self, t, last, &rows, &self->series_n));
  self->series = rows;
  self->shapes_n = self->times_n = CountUpTo(self->times_n, self->times, t);
  self->mine = (PetscBool)!rank;
  PetscCall(PetscStrncpy(self->path, path, sizeof(self->path)));
  error = OutputStore(self, rod, state, points, errors, finished);
  *self = kept;
  PetscCall(PetscFree(rows));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* OutputSeries - adds one line of the series. */
PetscErrorCode OutputSeries(Output self, const Observation *seen) {
  PetscFunctionBegin;
  if (!self->mine && !self->series_kept) PetscFunctionReturn(0);
  PetscCall(Room(self->series_n, &self->series_room, OBSERVED, &self->series));
  self->series[self->series_n++] = *seen;
  self->waits += sizeof(*seen);
  PetscFunctionReturn(0);
}

/* The force of contact per length about node i, from that at nodes and between them: what nodes
   have, times half of the lengths of their cells, adds up to what there is. (Where contact is
   stiff, that at the node itself may be far from that beside it.) */
static PetscErrorCode ContactAbout(Scene scene, PetscReal t, PetscInt i, PetscReal g,
                                   const PetscReal (*contact)[PUSH], PetscReal about[3]) {
  const PetscReal *s = scene->mesh.s;
  PetscReal length = 0, h, z, g_mid;

  PetscFunctionBegin;
  about[0] = about[1] = about[2] = 0;
  for (PetscInt side = -1; side <= 1; side += 2) {
    if (i + side < 0 || i + side > scene->mesh.cells) continue;
    h = PetscAbsReal(s[i + side] - s[i]);
    z = (s[i + side] + s[i]) / 2;
    PetscCall(GrowthStretch(scene->growth, 1, &z, t, &g_mid, NULL, NULL));
    length += h / 2 * g;
    for (int d = 0; d < 3; d++)
      about[d] += h / 6 * (g * contact[2 * i][d] + 2 * g_mid * contact[2 * i + side][d]);
  }
  for (int d = 0; d < 3; d++) about[d] /= length;
  PetscFunctionReturn(0);
}

/* A node of a rod in space, as entry i of each set. */
static PetscErrorCode ShapeNode3(Scene scene, PetscReal t, PetscInt i, const Node *node,
                                 const PetscReal (*contact)[PUSH], PetscReal *b[SHAPES]) {
  const PetscReal s = scene->mesh.s[i];
  PetscReal d[3][3], B, S[3], g, *u = b[3] + 3 * i, *u0 = b[5] + 3 * i;

  PetscFunctionBegin;
  Directors(node->p, QuaternionSize(node->p), d);
  PetscCall(SceneStiffness(scene, s, t, &B, NULL));
  SceneStiffnesses(scene, B, S);
  PetscCall(CurvatureStrains(&scene->curvature, scene->growth, s, t, u0, NULL));
  PetscCall(GrowthStretch(scene->growth, 1, &s, t, &g, NULL, NULL));
  for (int k = 0; k < 3; k++) {
    u[k] = u0[k] + (d[k][0] * node->m3[0] + d[k][1] * node->m3[1] + d[k][2] * node->m3[2]) / S[k];
    SpaceToLab(&scene->space, d[k], b[8 + k] + 3 * i);
  }
  SpaceToLab(&scene->space, node->x3, b[1] + 3 * i);
  b[2][i] = node->theta;
  SpaceToLab(&scene->space, node->n3, b[4] + 3 * i);
  b[6][i] = g;
  SpaceToLab(&scene->space, node->m3, b[7] + 3 * i);
  b[11][i] = PetscSqrtReal(u[1] * u[1] + u[2] * u[2]);
  if (contact) {
    PetscReal about[3];
    PetscCall(ContactAbout(scene, t, i, g, contact, about));
    SpaceToLab(&scene->space, about, b[CONTACT_3] + 3 * i);
  }
  PetscFunctionReturn(0);
}

/* OutputShape - adds the shape at one time. nodes are rank 0's; contact is the force of contact per
   length at nodes and between them, NULL if the scene has none. */
PetscErrorCode OutputShape(Output self, PetscReal t, const Node *nodes,
                           const PetscReal (*contact)[PUSH]) {
  PetscInt n = self->scene->mesh.cells + 1, k = self->shapes_n, room = self->shapes_room;
  PetscReal *b[SHAPES], k0, g, B;

  PetscFunctionBegin;
  if (!self->mine && !self->shapes_kept) PetscFunctionReturn(0);
  for (int i = 0; i < Sets(self); i++) {
    room = self->shapes_room;
    PetscCall(Room(k, &room, (size_t)ShapeSize(self, i), &self->shape[i]));
    b[i] = self->shape[i] + k * ShapeSize(self, i);
    self->waits += (double)(ShapeSize(self, i) * (PetscInt)sizeof(PetscReal));
  }
  self->shapes_room = room;
  *b[0] = t;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal s = self->scene->mesh.s[i];
    if (self->scene->space.rod) {
      PetscCall(ShapeNode3(self->scene, t, i, &nodes[i], contact, b));
      continue;
    }
    PetscCall(SceneCurvature(self->scene, s, t, &k0, NULL));
    PetscCall(GrowthStretch(self->scene->growth, 1, &s, t, &g, NULL, NULL));
    PetscCall(SceneStiffness(self->scene, s, t, &B, NULL));
    Turn(self->scene, nodes[i].x, b[1] + 2 * i);
    b[2][i] = nodes[i].theta + self->scene->clamp_angle;
    b[3][i] = k0 + nodes[i].moment / B;
    Turn(self->scene, nodes[i].force, b[4] + 2 * i);
    b[5][i] = k0;
    b[6][i] = g;
    if (contact) {
      PetscReal about[3];
      PetscCall(ContactAbout(self->scene, t, i, g, contact, about));
      Turn(self->scene, about, b[CONTACT] + 2 * i);
    }
  }
  self->shapes_n++;
  PetscCall(Room(self->times_n, &self->times_room, 1, &self->times));
  self->times[self->times_n++] = t;
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
  for (int i = 0; i < SHAPES; i++) PetscCall(PetscFree((*output)->shape[i]));
  PetscCall(PetscFree((*output)->series));
  PetscCall(PetscFree((*output)->times));
  PetscCall(PetscFree((*output)->earlier));
  for (PetscInt k = 0; k < (*output)->derivatives_n; k++)
    PetscCall(PetscFree((*output)->derivatives[k].harvest.data));
  PetscCall(PetscFree((*output)->derivatives));
  PetscCall(PetscFree(*output));
  PetscFunctionReturn(0);
}
