#include "record/output.h"
#include "base/options.h"
#include "record/xdmf.h"
#include <unistd.h>
#include <errno.h>
#include <sys/stat.h>

enum { SHAPES = 5 };
static const struct {
  const char *name, *text;
  hsize_t components;
} shape_sets[SHAPES] = {
    {"/shapes/t", "times of the stored shapes", 0},
    {"/shapes/x", "position x1, x2 [k, n, 2]", 2},
    {"/shapes/theta", "tangent angle, radians [k, n]", 1},
    {"/shapes/curvature", "curvature theta'/g, the moment m and the natural k0 [k, n]", 1},
    {"/shapes/force", "internal force n1, n2 [k, n, 2]", 2}};

/* Only rank 0 has a file; the others hold an empty shell and share the verdict on errors. Series
   are kept back until a shape is stored, so that the file changes only then. */
struct _Output {
  Scene scene;
  hid_t file;
  PetscInt waiting, room;
  Observation *series;
  PetscReal *buffer;
  char name[PETSC_MAX_PATH_LEN];
};

/* All options in force, as one text. */
PetscErrorCode OutputRootAttributes(hid_t file, PetscBool finished) {
  char *options;
  char version[64];
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetAll(NULL, &options));
  PetscCall(HdfAttributeText(file, "options", options));
  PetscCall(PetscFree(options));
  PetscCall(PetscSNPrintf(version, sizeof(version), "%d.%d.%d", PETSC_VERSION_MAJOR,
                          PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR));
  PetscCall(HdfAttributeText(file, "version", TENDRIL_VERSION));
  PetscCall(HdfAttributeText(file, "petsc_version", version));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(HdfAttributeInt(file, "ranks", ranks));
  PetscCall(HdfAttributeInt(file, "finished", finished));
  PetscFunctionReturn(0);
}

/* OutputNewFile - opens a new result file on rank 0 (on the others f is -1). Collective. A path
   that cannot be written is a user's mistake. */
PetscErrorCode OutputNewFile(const char *file, hid_t *f) {
  PetscMPIInt rank;
  int good = 1;

  PetscFunctionBegin;
  *f = -1;
  PetscCall(OptionsRefuseOverwrite(file));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (!rank) {
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    *f = H5Fcreate(file, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    good = *f >= 0;
  }
  PetscCallMPI(MPI_Bcast(&good, 1, MPI_INT, 0, PETSC_COMM_WORLD));
  UserCheck(good, PETSC_COMM_WORLD,
            "-output %s: cannot be written; does its directory exist, and is it yours?", file);
  PetscFunctionReturn(0);
}

static PetscErrorCode Group(hid_t file, const char *name) {
  hid_t g;

  PetscFunctionBegin;
  g = H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  HdfCall(g);
  HdfCall(H5Gclose(g));
  PetscFunctionReturn(0);
}

/* The scales of the physical rod, if one was given. */
static PetscErrorCode SiAttributes(Output self) {
  const Si *si = &self->scene->si;
  char name[32];

  PetscFunctionBegin;
  for (int k = 0; k < SI_SCALES; k++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "si_%s", si_name[k]));
    if (si->scale[k] > 0) PetscCall(HdfAttributeReal(self->file, name, si->scale[k]));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateDatasets(Output self) {
  hsize_t n = self->scene->mesh.cells + 1;
  char path[64];

  PetscFunctionBegin;
  PetscCall(Group(self->file, "/series"));
  PetscCall(Group(self->file, "/shapes"));
  for (int i = 0; i < OBSERVED; i++) {
    PetscCall(PetscSNPrintf(path, sizeof(path), "/series/%s", observed_name[i]));
    PetscCall(HdfAppendable(self->file, path, 0, NULL, "description", observed_text[i]));
  }
  PetscCall(HdfWrite(self->file, "/shapes/s", 1, &n, self->scene->mesh.s, "description",
                     "material label of the nodes [n]"));
  for (int i = 0; i < SHAPES; i++) {
    hsize_t row[2] = {n, shape_sets[i].components};
    int rank = shape_sets[i].components == 0 ? 0 : shape_sets[i].components == 1 ? 1 : 2;
    PetscCall(HdfAppendable(self->file, shape_sets[i].name, rank, row, "description",
                            shape_sets[i].text));
  }
  PetscCall(OutputRootAttributes(self->file, PETSC_FALSE));
  PetscCall(SiAttributes(self));
  HdfCall(H5Fflush(self->file, H5F_SCOPE_GLOBAL));
  PetscFunctionReturn(0);
}

/*
  OutputCreate - a new result file for a run. Collective; the caller ends it with OutputDestroy().

  file   its path; empty: nothing is stored
*/
PetscErrorCode OutputCreate(const char *file, Scene scene, Output *output) {
  Output self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  self->scene = scene;
  self->file = -1;
  if (file[0]) PetscCall(OutputNewFile(file, &self->file));
  if (self->file >= 0) {
    PetscCall(PetscMalloc1(2 * (scene->mesh.cells + 1), &self->buffer));
    PetscCall(PetscStrncpy(self->name, file, sizeof(self->name)));
    PetscCall(CreateDatasets(self));
  }
  *output = self;
  PetscFunctionReturn(0);
}

/* Copies a file, on one rank; returns whether that went well. */
static int CopyFile(const char *from, const char *to) {
  FILE *in = fopen(from, "rb"), *out = in ? fopen(to, "wb") : NULL;
  char block[65536];
  size_t n;
  int good = out != NULL;

  while (good && (n = fread(block, 1, sizeof(block), in)) > 0) good = fwrite(block, 1, n, out) == n;
  if (out && fclose(out)) good = 0;
  if (in) fclose(in);
  return good;
}

static PetscBool SameFile(const char *a, const char *b) {
  struct stat sa, sb;
  return (PetscBool)(!stat(a, &sa) && !stat(b, &sb) && sa.st_dev == sb.st_dev &&
                     sa.st_ino == sb.st_ino);
}

/* Is t one of the times at which shapes are stored? */
static PetscBool OnGrid(PetscReal t, PetscReal interval) {
  return (PetscBool)(PetscAbsReal(t - interval * PetscFloorReal(t / interval + 0.5)) <
                     1e-9 * PetscMax(interval, t));
}

/* How many of n increasing times are at or before t. */
static hsize_t CountUpTo(hsize_t n, const PetscReal times[], PetscReal t) {
  while (n > 0 && times[n - 1] > t * (1 + 1e-12)) n--;
  return n;
}

/* Takes off a file what came after time t. */
static PetscErrorCode CutAt(Output self, hsize_t series, hsize_t shapes) {
  char path[64];

  PetscFunctionBegin;
  for (int i = 0; i < OBSERVED; i++) {
    PetscCall(PetscSNPrintf(path, sizeof(path), "/series/%s", observed_name[i]));
    PetscCall(HdfTruncate(self->file, path, series));
  }
  for (int i = 0; i < SHAPES; i++) PetscCall(HdfTruncate(self->file, shape_sets[i].name, shapes));
  if (H5Lexists(self->file, "/event", H5P_DEFAULT) > 0)
    HdfCall(H5Ldelete(self->file, "/event", H5P_DEFAULT));
  PetscCall(OutputRootAttributes(self->file, PETSC_FALSE));
  PetscCall(SiAttributes(self));
  HdfCall(H5Fflush(self->file, H5F_SCOPE_GLOBAL));
  PetscFunctionReturn(0);
}

/*
  OutputContinue - the result file of a run that goes on. Collective.

  file      its path; the file `from` itself goes on if it is the same or empty, else a copy of it
  t         what `from` holds after this time is taken off: it comes again
  interval  a last shape that was stored at t only because the run ended there is taken off too
*/
PetscErrorCode OutputContinue(const char *file, const char *from, Scene scene, PetscReal t,
                              PetscReal interval, Output *output) {
  PetscReal *times;
  hsize_t series, shapes, n;
  PetscMPIInt rank;
  int good = 1;
  Output self;

  PetscFunctionBegin;
  PetscCall(HdfRead("-restart", from, "/series/t", 1, &n, &times));
  series = CountUpTo(n, times, t);
  good = series > 0 && PetscAbsReal(times[series - 1] - t) <= 1e-12 * t;
  PetscCall(PetscFree(times));
  UserCheck(good, PETSC_COMM_WORLD, "-restart %s: its series end before its last state", from);
  PetscCall(HdfRead("-restart", from, "/shapes/t", 1, &n, &times));
  shapes = CountUpTo(n, times, t);
  if (shapes > 1 && times[shapes - 1] > t * (1 - 1e-12) && !OnGrid(t, interval)) shapes--;
  PetscCall(PetscFree(times));
  PetscCall(PetscNew(&self));
  self->scene = scene;
  self->file = -1;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (!rank) {
    if (!file[0])
      file = from;
    else if (!SameFile(file, from))
      good = CopyFile(from, file);
    if (good) self->file = H5Fopen(file, H5F_ACC_RDWR, H5P_DEFAULT);
    good = self->file >= 0;
  }
  PetscCallMPI(MPI_Bcast(&good, 1, MPI_INT, 0, PETSC_COMM_WORLD));
  UserCheck(good, PETSC_COMM_WORLD,
            "-output %s: cannot be written; does its directory exist, and is it yours?", file);
  if (self->file >= 0) {
    PetscCall(PetscMalloc1(2 * (scene->mesh.cells + 1), &self->buffer));
    PetscCall(PetscStrncpy(self->name, file, sizeof(self->name)));
    PetscCall(CutAt(self, series, shapes));
  }
  *output = self;
  PetscFunctionReturn(0);
}

/* The file that ParaView opens, beside the result file. */
static PetscErrorCode Describe(Output self) {
  hid_t d, space;
  hsize_t n;
  PetscReal *t;

  PetscFunctionBegin;
  d = H5Dopen2(self->file, "/shapes/t", H5P_DEFAULT);
  HdfCall(d);
  space = H5Dget_space(d);
  H5Sget_simple_extent_dims(space, &n, NULL);
  H5Sclose(space);
  PetscCall(PetscMalloc1(n, &t));
  HdfCall(H5Dread(d, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, t));
  H5Dclose(d);
  PetscCall(XdmfWrite(self->name, self->scene->mesh.cells + 1, (PetscInt)n, t));
  PetscCall(PetscFree(t));
  PetscFunctionReturn(0);
}

/* OutputRestart - stores what the run needs to go on from here, in the place of what stood there.
   n reals in points, rank 0's. */
PetscErrorCode OutputRestart(Output output, RestartState *state, PetscInt n,
                             const PetscReal points[]) {
  PetscFunctionBegin;
  if (output->file < 0) PetscFunctionReturn(0);
  state->sum = RestartSum(n, points);
  if (H5Lexists(output->file, "/restart", H5P_DEFAULT) <= 0)
    PetscCall(Group(output->file, "/restart"));
  PetscCall(HdfOverwrite(output->file, "/restart/state", RESTART_STATE, (const PetscReal *)state,
                         "time, step and history of the stepper, for -restart"));
  PetscCall(HdfOverwrite(output->file, "/restart/points", n, points,
                         "the stepper's past points [point][node][field], latest first"));
  PetscCall(Describe(output));
  HdfCall(H5Fflush(output->file, H5F_SCOPE_GLOBAL));
  PetscFunctionReturn(0);
}

/* OutputSeries - adds one line of the series; it reaches the file with the next shape. */
PetscErrorCode OutputSeries(Output output, const Observation *seen) {
  PetscFunctionBegin;
  if (output->file < 0) PetscFunctionReturn(0);
  if (output->waiting == output->room) {
    output->room = 2 * output->room + 64;
    PetscCall(PetscRealloc(output->room * sizeof(Observation), &output->series));
  }
  output->series[output->waiting++] = *seen;
  PetscFunctionReturn(0);
}

static PetscErrorCode FlushSeries(Output self) {
  PetscReal *column;
  char path[64];

  PetscFunctionBegin;
  if (!self->waiting) PetscFunctionReturn(0);
  PetscCall(PetscMalloc1(self->waiting, &column));
  for (int i = 0; i < OBSERVED; i++) {
    for (PetscInt k = 0; k < self->waiting; k++)
      column[k] = ((const PetscReal *)&self->series[k])[i];
    PetscCall(PetscSNPrintf(path, sizeof(path), "/series/%s", observed_name[i]));
    PetscCall(HdfAppend(self->file, path, self->waiting, column));
  }
  PetscCall(PetscFree(column));
  self->waiting = 0;
  PetscFunctionReturn(0);
}

/* Turns a vector from the clamp's frame to the laboratory's. */
static inline void Turn(Scene scene, const PetscReal v[2], PetscReal to[2]) {
  PetscReal c = PetscCosReal(scene->clamp_angle), s = PetscSinReal(scene->clamp_angle);
  to[0] = c * v[0] - s * v[1];
  to[1] = s * v[0] + c * v[1];
}

/* OutputEvent - stores the event that ended the run. */
PetscErrorCode OutputEvent(Output output, const Event *event) {
  const hsize_t two = 2;
  PetscReal x[2];
  hid_t group;

  PetscFunctionBegin;
  if (output->file < 0) PetscFunctionReturn(0);
  PetscCall(Group(output->file, "/event"));
  PetscCall(HdfWrite(output->file, "/event/t", 0, NULL, &event->t, "description", "its time"));
  PetscCall(HdfWrite(output->file, "/event/s", 1, &two, event->s, "description",
                     "labels of the places concerned; twice the same if it is one"));
  Turn(output->scene, event->x, x);
  PetscCall(HdfWrite(output->file, "/event/x", 1, &two, x, "description", "position x1, x2"));
  group = H5Gopen2(output->file, "/event", H5P_DEFAULT);
  HdfCall(group);
  PetscCall(HdfAttributeText(group, "kind", event_name[event->kind]));
  H5Gclose(group);
  PetscFunctionReturn(0);
}

/* OutputShape - stores the shape at one time, and the series up to now. nodes are rank 0's. */
PetscErrorCode OutputShape(Output output, PetscReal t, const Node *nodes) {
  PetscInt n = output->scene->mesh.cells + 1;
  PetscReal *b = output->buffer;

  PetscFunctionBegin;
  if (output->file < 0) PetscFunctionReturn(0);
  PetscCall(HdfAppend(output->file, "/shapes/t", 1, &t));
  for (PetscInt i = 0; i < n; i++) Turn(output->scene, nodes[i].x, &b[2 * i]);
  PetscCall(HdfAppend(output->file, "/shapes/x", 1, b));
  for (PetscInt i = 0; i < n; i++) b[i] = nodes[i].theta + output->scene->clamp_angle;
  PetscCall(HdfAppend(output->file, "/shapes/theta", 1, b));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(SceneCurvature(output->scene, output->scene->mesh.s[i], t, &b[i]));
    b[i] += nodes[i].moment;
  }
  PetscCall(HdfAppend(output->file, "/shapes/curvature", 1, b));
  for (PetscInt i = 0; i < n; i++) Turn(output->scene, nodes[i].force, &b[2 * i]);
  PetscCall(HdfAppend(output->file, "/shapes/force", 1, b));
  PetscCall(FlushSeries(output));
  HdfCall(H5Fflush(output->file, H5F_SCOPE_GLOBAL));
  PetscFunctionReturn(0);
}

/* OutputDestroy - ends the file; finished tells whether the run reached its end. */
PetscErrorCode OutputDestroy(Output *output, PetscBool finished) {
  Output self = *output;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  if (self->file >= 0) {
    PetscCall(FlushSeries(self));
    PetscCall(Describe(self));
    PetscCall(HdfAttributeInt(self->file, "finished", finished));
    HdfCall(H5Fclose(self->file));
  }
  PetscCall(PetscFree(self->series));
  PetscCall(PetscFree(self->buffer));
  PetscCall(PetscFree(*output));
  PetscFunctionReturn(0);
}
