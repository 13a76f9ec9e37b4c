/* Surfaces whose form is in a file: a tube along a path, a body by its distance on a grid. A file
   is looked for beside the file that names it. */
#include "base/table.h"
#include "world/body.h"
#include "world/tube.h"

/* What names a line where it is refused. */
static void Name(const SurfaceLine *line, char *what, size_t length) {
  (void)snprintf(what, length, "-wall_file %s, line %d: %s", line->file, line->line, line->word[0]);
}

/* The path of a file that a line names. */
static void Beside(const SurfaceLine *line, const char *name, char *path, size_t length) {
  const char *slash = strrchr(line->file, '/');
  const int folder = slash && name[0] != '/' ? (int)(slash - line->file) + 1 : 0;

  (void)snprintf(path, length, "%.*s%s", folder, line->file, name);
}

/* Is a word a side, and is that inside? */
static PetscBool SideOf(const char *word, PetscBool *inside) {
  *inside = (PetscBool)!strcmp(word, "inside");
  return (PetscBool)(*inside || !strcmp(word, "outside"));
}

/* ---- tubes ---- */

enum { FOUR = 4 };

/* The balls of a tube; of the numbers of a line. */
static PetscErrorCode BallsOfLine(const SurfaceLine *line, PetscInt *n, PetscReal (**ball)[FOUR]) {
  const PetscInt before = 2;

  PetscFunctionBegin;
  *n = (line->n - before) / FOUR;
  if (*n < 2 || (line->n - before) % FOUR) PetscCall(SurfaceMalformed(line, &surface_tube));
  PetscCall(PetscMalloc1(*n, ball));
  for (PetscInt k = 0; k < FOUR * *n; k++)
    PetscCall(SurfaceNumber(line, before + k, UNIT_LENGTH, &(*ball)[0][k]));
  PetscFunctionReturn(0);
}

/* Which column of a table is called this, or that? */
static PetscErrorCode Column(const char *option, const char *path, Table table, const char *name,
                             const char *other, PetscInt *column) {
  PetscFunctionBegin;
  for (*column = 0; *column < TableColumns(table); ++*column)
    if (!strcmp(TableName(table, *column), name) || !strcmp(TableName(table, *column), other))
      PetscFunctionReturn(0);
  UserCheck(PETSC_FALSE, OptionsComm(),
            "%s %s: a tube needs columns x1, x2, x3 and radius (or x, y, z, r); %s is missing",
            option, path, name);
  PetscFunctionReturn(0);
}

static PetscErrorCode BallsOfTable(const char *option, const char *path, Table table, PetscInt *n,
                                   PetscReal (**ball)[FOUR]) {
  static const char *const name[FOUR][2] = {{"x1", "x"}, {"x2", "y"}, {"x3", "z"}, {"radius", "r"}};
  char what[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  *n = TableRows(table);
  PetscCall(PetscMalloc1(*n, ball));
  for (int d = 0; d < FOUR; d++) {
    PetscInt column;
    PetscCall(Column(option, path, table, name[d][0], name[d][1], &column));
    for (PetscInt k = 0; k < *n; k++) {
      (void)snprintf(what, sizeof(what), "%.300s %.300s: %s of point %d:", option, path, name[d][0],
                     (int)k + 1);
      PetscCall(TableQuantity(what, table, k, column, UNIT_LENGTH, &(*ball)[k][d]));
    }
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode BallsOfFile(const SurfaceLine *line, PetscInt *n, PetscReal (**ball)[FOUR]) {
  char what[PETSC_MAX_PATH_LEN], path[PETSC_MAX_PATH_LEN];
  PetscErrorCode error;
  Table table = NULL;

  PetscFunctionBegin;
  Name(line, what, sizeof(what));
  Beside(line, line->word[1], path, sizeof(path));
  error = TableReadPlain(what, path, &table);
  if (!error) error = BallsOfTable(what, path, table, n, ball);
  PetscCall(TableDestroy(&table));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* The tube with all its points: what is drawn and given again needs no file. */
static PetscErrorCode TubeText(PetscInt n, const PetscReal ball[][FOUR], PetscBool inside,
                               char **text) {
  enum { NUMBER = 26, WORDS = 32 };
  const size_t room = WORDS + NUMBER * FOUR * (size_t)n;
  size_t at;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(room, text));
  at = (size_t)snprintf(*text, room, "tube %s", inside ? "inside" : "outside");
  for (PetscInt k = 0; k < FOUR * n; k++)
    at += (size_t)snprintf(*text + at, room - at, " %.17g", (double)ball[0][k]);
  PetscFunctionReturn(0);
}

static PetscErrorCode TubeMake(const SurfaceLine *line, Surface *surface) {
  PetscReal clamp[3] = {0, 0, 0};
  PetscReal(*ball)[FOUR] = NULL;
  char what[PETSC_MAX_PATH_LEN], text[96];
  PetscErrorCode error;
  PetscBool inside = PETSC_FALSE, placed;
  PetscInt n = 0;

  PetscFunctionBegin;
  Name(line, what, sizeof(what));
  if (line->n > 1 && SideOf(line->word[1], &inside))
    error = BallsOfLine(line, &n, &ball);
  else {
    if (line->n != 3 || !SideOf(line->word[2], &inside))
      PetscCall(SurfaceMalformed(line, &surface_tube));
    error = BallsOfFile(line, &n, &ball);
  }
  if (!error)
    error = TubeCreate(what, n, (const PetscReal(*)[FOUR])ball, inside, line->radius,
                       (Tube *)&surface->data);
  if (!error) error = TubeText(n, (const PetscReal(*)[FOUR])ball, inside, &surface->text);
  if (error) PetscCall(PetscFree(ball));
  PetscCall(error);
  for (PetscInt k = 0; k < n && inside; k++)
    surface->room = PetscMin(surface->room, ball[k][FOUR - 1] - line->radius);
  PetscCall(PetscFree(ball));
  PetscCall(OptionVector("-clamp_place", UNIT_LENGTH, clamp, &placed));
  if (inside)
    UserCheck(
        TubeHolds((Tube)surface->data, clamp, line->radius), OptionsComm(),
        "%s: the clamp, at %s, is outside the tube, or beside its mouth: move the tube, or lead it "
        "to the clamp",
        what, OptionPlace(clamp, text));
  surface->box = TubeBox((Tube)surface->data);
  surface->smallest = TubeSmallest((Tube)surface->data);
  surface->core = TubeCore((Tube)surface->data);
  PetscFunctionReturn(0);
}

static PetscBool TubeSeen(const void *data, const PetscReal x[3], PetscReal within,
                          SurfacePoint *point) {
  return TubeAt((Tube)data, x, within, point);
}

static PetscErrorCode TubeFree(void **data) {
  PetscFunctionBegin;
  PetscCall(TubeDestroy((Tube *)data));
  PetscFunctionReturn(0);
}

/* ---- bodies ---- */

static PetscErrorCode BodyMake(const SurfaceLine *line, Surface *surface) {
  char what[PETSC_MAX_PATH_LEN], path[PETSC_MAX_PATH_LEN];
  PetscBool inside = PETSC_FALSE;
  size_t room;

  PetscFunctionBegin;
  if (line->n < 2 || line->n > 3 || (line->n == 3 && !SideOf(line->word[2], &inside)))
    PetscCall(SurfaceMalformed(line, &surface_body));
  Name(line, what, sizeof(what));
  Beside(line, line->word[1], path, sizeof(path));
  PetscCall(BodyRead(what, path, inside, line->radius, (Body *)&surface->data));
  surface->box = BodyBox((Body)surface->data);
  surface->smallest = BodySmallest((Body)surface->data);
  surface->core = BodyCore((Body)surface->data);
  room = strlen(path) + 20;
  PetscCall(PetscMalloc1(room, &surface->text));
  (void)snprintf(surface->text, room, "body %s %s", path, inside ? "inside" : "outside");
  PetscFunctionReturn(0);
}

static PetscBool BodySeen(const void *data, const PetscReal x[3], PetscReal within,
                          SurfacePoint *point) {
  return BodyAt((Body)data, x, within, point);
}

static PetscErrorCode BodyFree(void **data) {
  PetscFunctionBegin;
  PetscCall(BodyDestroy((Body *)data));
  PetscFunctionReturn(0);
}

const SurfaceKind surface_tube = {
    .name = "tube",
    .form = "tube FILE inside|outside, a table of x1, x2, x3 and radius along a path, or tube "
            "inside|outside X Y Z R X Y Z R ... with the points themselves",
    .make = TubeMake,
    .at = TubeSeen,
    .destroy = TubeFree,
    .known = SURFACE_OF_POINTS};

const SurfaceKind surface_body = {
    .name = "body",
    .form = "body FILE inside|outside, an HDF5 file with its distance on a grid",
    .make = BodyMake,
    .at = BodySeen,
    .destroy = BodyFree,
    .known = SURFACE_ON_A_GRID};
