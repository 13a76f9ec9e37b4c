#include "record/collection.h"
#include "base/lock.h"
#include <petsctime.h>
#include <sys/stat.h>

/* A store copies the file, so it is to take a twentieth of the time at most; it is due after a
   tenth of the time so far, but within these bounds, in seconds; or when so many bytes wait. */
static const PetscLogDouble share = 20, soon = 1, late = 10, part = 0.1;
static const size_t kept_back = 64000000;

/* Reals that wait to be stored. */
typedef struct {
  size_t n, room;
  PetscReal *a;
} Reals;

/* Whole numbers of a member. `first` and `count` say where in the series and the shapes of all it
   has its own; nodes of its shapes follow one another, too. */
enum { STATUS, STEP_FIRST, STEP_COUNT, SHAPE_FIRST, SHAPE_COUNT, NODE_FIRST, NODES, NUMBERS };
static const char *const number_name[NUMBERS] = {
    "/status",       "/series/first",      "/series/count", "/shapes/first",
    "/shapes/count", "/shapes/first_node", "/shapes/nodes"};
static const char *const number_text[NUMBERS] = {
    "0: not run yet, 1: finished, 2: failed [members]",
    "first step of each member in the series [members]",
    "steps of each member [members]",
    "first shape of each member in /shapes/t [members]",
    "shapes of each member [members]",
    "first node of each member in /shapes/s, x and the like [members]",
    "nodes of a shape of each member [members]"};

typedef struct {
  PetscInt member;
  PetscInt64 number[NUMBERS];
  PetscReal seconds;
  char *line;
} Row;

struct _Collection {
  char path[PETSC_MAX_PATH_LEN];
  Table table;
  Columns columns;
  char *options;
  PetscReal *status; /* of each member, as the file has it */
  PetscBool there, broken;
  PetscInt64 steps, shapes, nodes; /* in the file and waiting */
  PetscInt rows, room;
  Row *row; /* that wait */
  Reals values, series, labels, shape[CONTACT_SET];
  PetscLogDouble begun, stored_at, cost;
};

static PetscErrorCode Append(Reals *to, size_t n, const PetscReal a[]) {
  PetscFunctionBegin;
  if (to->n + n > to->room) {
    to->room = 2 * to->room + n;
    PetscCall(PetscRealloc(to->room * sizeof(*a), &to->a));
  }
  PetscCall(PetscArraycpy(to->a + to->n, a, n));
  to->n += n;
  PetscFunctionReturn(0);
}

/* How many reals n shapes have in a set. */
static size_t SetSize(int set, PetscInt shapes, PetscInt nodes) {
  PetscInt each = shape_sets[set].components;
  return (size_t)shapes * (size_t)(each ? each * nodes : 1);
}

static PetscErrorCode AddShapes(Collection self, const MemberHead *head, const PetscReal data[]) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < head->shapes; k++)
    PetscCall(Append(&self->labels, (size_t)head->nodes, data));
  data += head->nodes;
  for (int i = 0; i < CONTACT_SET; i++) {
    size_t n = SetSize(i, head->shapes, head->nodes);
    PetscCall(Append(&self->shape[i], n, data));
    data += n;
  }
  self->shapes += head->shapes;
  self->nodes += (PetscInt64)head->shapes * head->nodes;
  PetscFunctionReturn(0);
}

/* CollectionAdd - takes a member's result; it is in the file after the next store. */
PetscErrorCode CollectionAdd(Collection self, const MemberHead *head, const PetscReal data[]) {
  PetscBool finished = (PetscBool)(head->status == MEMBER_FINISHED);
  Row row = {.member = head->member, .seconds = head->seconds};

  PetscFunctionBegin;
  row.number[STATUS] = head->status;
  row.number[STEP_FIRST] = self->steps;
  row.number[SHAPE_FIRST] = self->shapes;
  row.number[NODE_FIRST] = self->nodes;
  if (finished) {
    row.number[STEP_COUNT] = head->steps;
    row.number[SHAPE_COUNT] = head->shapes;
    row.number[NODES] = head->nodes;
    PetscCall(Append(&self->values, (size_t)self->columns.n, data));
    data += head->values;
    PetscCall(Append(&self->series, (size_t)head->steps * (size_t)self->columns.n, data));
    self->steps += head->steps;
    PetscCall(AddShapes(self, head, data + head->steps * self->columns.n));
  } else
    for (PetscInt k = 0; k < self->columns.n; k++)
      PetscCall(Append(&self->values, 1, (const PetscReal[]){NAN}));
  if (head->line[0]) PetscCall(PetscStrallocpy(head->line, &row.line));
  if (self->rows == self->room) {
    self->room = 2 * self->room + 64;
    PetscCall(PetscRealloc((size_t)self->room * sizeof(row), &self->row));
  }
  self->row[self->rows++] = row;
  self->status[head->member] = head->status;
  PetscFunctionReturn(0);
}

/* What was asked, as columns: of reals, if all that stands there is a number. */
static PetscErrorCode WriteInputs(Collection self, HdfFile file) {
  const PetscInt n = TableRows(self->table);
  PetscReal *number;
  const char **text;
  PetscInt *rows;
  char name[128];

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(n, &number, n, &text, n, &rows));
  PetscCall(HdfGroup(file, "/columns"));
  for (PetscInt c = 0; c < TableColumns(self->table); c++) {
    PetscBool numbers = PETSC_TRUE;
    for (PetscInt r = 0; r < n; r++) {
      rows[r] = r;
      text[r] = TableCell(self->table, r, c);
      if (!TableNumber(text[r], &number[r])) numbers = PETSC_FALSE;
    }
    (void)snprintf(name, sizeof(name), "-%s", TableName(self->table, c));
    const OptionRow *row = OptionFind(name);
    (void)snprintf(name, sizeof(name), "/columns/%s", TableName(self->table, c));
    PetscCall(HdfColumn(file, name, numbers ? HDF_REALS : HDF_TEXTS, n, "as the option",
                        row ? row->text : "an option of PETSc's"));
    PetscCall(HdfPut(file, name, n, rows, numbers ? (const void *)number : (const void *)text));
  }
  PetscCall(PetscFree3(number, text, rows));
  PetscFunctionReturn(0);
}

/* The series and the shapes of all members, one behind the other. */
static PetscErrorCode LayoutLong(Collection self, HdfFile file) {
  char name[128];

  PetscFunctionBegin;
  if (self->columns.series) PetscCall(HdfGroup(file, "/series"));
  for (int i = 0; self->columns.series && i < self->columns.n; i++) {
    (void)snprintf(name, sizeof(name), "/series/%s", observed_name[i]);
    PetscCall(HdfAppendable(file, name, 0, NULL, observed_units[i], observed_text[i]));
  }
  if (!self->columns.shapes) PetscFunctionReturn(0);
  PetscCall(HdfGroup(file, "/shapes"));
  PetscCall(HdfAppendable(file, "/shapes/s", 0, NULL, "1", "material label of the nodes"));
  for (int i = 0; i < CONTACT_SET; i++) {
    const PetscInt two = 2;
    PetscCall(HdfAppendable(file, shape_sets[i].name, shape_sets[i].components == 2, &two,
                            shape_sets[i].units, shape_sets[i].text));
  }
  PetscFunctionReturn(0);
}

static PetscBool Has(Collection self, int number) {
  if (number == STATUS) return PETSC_TRUE;
  return number <= STEP_COUNT ? self->columns.series : self->columns.shapes;
}

/* An empty file. */
static PetscErrorCode Layout(Collection self, HdfFile file) {
  const PetscInt n = TableRows(self->table);
  char name[128], mark[17];

  PetscFunctionBegin;
  PetscCall(WriteInputs(self, file));
  PetscCall(LayoutLong(self, file));
  for (int k = 0; k < NUMBERS; k++)
    if (Has(self, k)) PetscCall(HdfColumn(file, number_name[k], HDF_INTS, n, "1", number_text[k]));
  PetscCall(HdfColumn(file, "/seconds", HDF_REALS, n, "s", "wall time of each member [members]"));
  PetscCall(HdfColumn(file, "/line", HDF_TEXTS, n, "text", "why it failed [members]"));
  PetscCall(HdfGroup(file, self->columns.group));
  for (PetscInt k = 0; k < self->columns.n; k++) {
    (void)snprintf(name, sizeof(name), "%s/%s", self->columns.group, self->columns.name[k]);
    PetscCall(HdfColumn(file, name, HDF_REALS, n, self->columns.units[k], self->columns.text[k]));
  }
  TableMark(self->table, mark);
  PetscCall(HdfText(file, "/", "table", mark));
  PetscCall(HdfText(file, "/", "options", self->options));
  PetscCall(OutputVersions(file));
  PetscFunctionReturn(0);
}

/* Writes what waits of one number a member. */
static PetscErrorCode WriteNumbers(Collection self, HdfFile file, const PetscInt rows[]) {
  PetscInt64 *number;
  PetscReal *real;
  char name[128];

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(self->rows, &number, self->rows, &real));
  for (int k = 0; k < NUMBERS; k++) {
    if (!Has(self, k)) continue;
    for (PetscInt i = 0; i < self->rows; i++) number[i] = self->row[i].number[k];
    PetscCall(HdfPut(file, number_name[k], self->rows, rows, number));
  }
  for (PetscInt i = 0; i < self->rows; i++) real[i] = self->row[i].seconds;
  PetscCall(HdfPut(file, "/seconds", self->rows, rows, real));
  for (PetscInt k = 0; k < self->columns.n; k++) {
    for (PetscInt i = 0; i < self->rows; i++) real[i] = self->values.a[i * self->columns.n + k];
    (void)snprintf(name, sizeof(name), "%s/%s", self->columns.group, self->columns.name[k]);
    PetscCall(HdfPut(file, name, self->rows, rows, real));
  }
  PetscCall(PetscFree2(number, real));
  PetscFunctionReturn(0);
}

static PetscErrorCode WriteMembers(Collection self, HdfFile file) {
  PetscInt *rows, failed = 0;
  const char **line;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(self->rows, &rows, self->rows, &line));
  for (PetscInt i = 0; i < self->rows; i++) rows[i] = self->row[i].member;
  PetscCall(WriteNumbers(self, file, rows));
  for (PetscInt i = 0; i < self->rows; i++) {
    if (!self->row[i].line) continue;
    rows[failed] = self->row[i].member;
    line[failed++] = self->row[i].line;
  }
  PetscCall(HdfPut(file, "/line", failed, rows, line));
  PetscCall(PetscFree2(rows, line));
  PetscFunctionReturn(0);
}

/* Writes what waits of series and shapes. */
static PetscErrorCode WriteLong(Collection self, HdfFile file) {
  const PetscInt each = self->columns.n;
  PetscInt n = (PetscInt)(self->series.n / (size_t)each);
  PetscReal *column;
  char name[128];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &column));
  for (int i = 0; n && i < each; i++) {
    for (PetscInt k = 0; k < n; k++) column[k] = self->series.a[k * each + i];
    (void)snprintf(name, sizeof(name), "/series/%s", observed_name[i]);
    PetscCall(HdfAppend(file, name, n, column));
  }
  PetscCall(PetscFree(column));
  if (!self->labels.n) PetscFunctionReturn(0);
  PetscCall(HdfAppend(file, "/shapes/s", (PetscInt)self->labels.n, self->labels.a));
  for (int i = 0; i < CONTACT_SET; i++) {
    PetscInt parts = PetscMax(1, shape_sets[i].components);
    PetscCall(
        HdfAppend(file, shape_sets[i].name, (PetscInt)self->shape[i].n / parts, self->shape[i].a));
  }
  PetscFunctionReturn(0);
}

/* Nothing waits any more. */
static PetscErrorCode Emptied(Collection self) {
  PetscFunctionBegin;
  for (PetscInt i = 0; i < self->rows; i++) PetscCall(PetscFree(self->row[i].line));
  self->rows = 0;
  self->values.n = self->series.n = self->labels.n = 0;
  for (int i = 0; i < CONTACT_SET; i++) self->shape[i].n = 0;
  PetscFunctionReturn(0);
}

/*
  CollectionStore - brings all that waits into the file. On rank 0; not collective.

  finished  all members have been run
  fault     empty, or why it could not be written: the file is then what it was before, and nothing
            more is written
*/
PetscErrorCode CollectionStore(Collection self, PetscBool finished, char fault[HDF_FAULT]) {
  PetscLogDouble begin, end;
  HdfFile file;

  PetscFunctionBegin;
  fault[0] = 0;
  if (self->broken) PetscFunctionReturn(0);
  PetscCall(PetscTime(&begin));
  if (self->there)
    PetscCall(HdfAmend(self->path, self->path, &file));
  else {
    PetscCall(HdfCreate(self->path, &file));
    PetscCall(Layout(self, file));
  }
  PetscCall(WriteMembers(self, file));
  PetscCall(WriteLong(self, file));
  PetscCall(HdfInt(file, "/", "finished", finished));
  PetscCall(HdfClose(&file, fault));
  self->broken = (PetscBool)(fault[0] != 0);
  self->there = PETSC_TRUE;
  PetscCall(Emptied(self));
  PetscCall(PetscTime(&end));
  self->stored_at = end;
  self->cost = end - begin;
  PetscFunctionReturn(0);
}

/* CollectionDue - is it time to store? On rank 0; not collective. */
PetscBool CollectionDue(Collection self) {
  size_t waits = self->series.n + self->shape[1].n;
  PetscLogDouble now, since;

  if (!self->rows || PetscTime(&now)) return PETSC_FALSE;
  if (waits * sizeof(PetscReal) > kept_back) return PETSC_TRUE;
  since = now - self->stored_at;
  return (PetscBool)(since > share * self->cost &&
                     since > PetscMin(late, PetscMax(soon, part * (now - self->begun))));
}

/* Whether a file holds a text attribute, the same as this one. Collective on OptionsComm(). */
static PetscErrorCode Holds(const char *path, const char *name, const char *text, PetscBool *same) {
  char *there;

  PetscFunctionBegin;
  PetscCall(HdfHas(path, name, same));
  if (!*same) PetscFunctionReturn(0);
  PetscCall(HdfReadText("-output", path, name, &there));
  *same = (PetscBool)!strcmp(there, text);
  PetscCall(PetscFree(there));
  PetscFunctionReturn(0);
}

/* What was left by an earlier sweep of the same table and options, and nothing else, is gone on
   with. */
static PetscErrorCode RefuseOther(Collection self) {
  PetscBool sweep, same;
  char mark[17];

  PetscFunctionBegin;
  PetscCall(HdfHas(self->path, "/status", &sweep));
  UserCheck(sweep, OptionsComm(),
            "-output %s: is there, and is no sweep's; name another file, or take it away",
            self->path);
  TableMark(self->table, mark);
  PetscCall(Holds(self->path, "table", mark, &same));
  UserCheck(same, OptionsComm(),
            "-output %s: holds a sweep of another table; name another file, or take it away",
            self->path);
  PetscCall(Holds(self->path, "options", self->options, &same));
  UserCheck(same, OptionsComm(),
            "-output %s: holds a sweep with other options; name another file, or take it away",
            self->path);
  PetscFunctionReturn(0);
}

/* The end, in what is stored of all members, of the last one's part. */
static PetscErrorCode Last(Collection self, const char *first, const char *count, PetscInt64 *end) {
  PetscReal *a, *b;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(HdfRead("-output", self->path, first, 1, &n, &a));
  PetscCall(HdfRead("-output", self->path, count, 1, &n, &b));
  for (PetscInt i = 0; i < n; i++) *end = PetscMax(*end, (PetscInt64)(a[i] + b[i]));
  PetscCall(PetscFree(a));
  PetscCall(PetscFree(b));
  PetscFunctionReturn(0);
}

static PetscErrorCode Nodes(Collection self) {
  PetscReal *nodes, *shapes, *first;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(HdfRead("-output", self->path, number_name[NODES], 1, &n, &nodes));
  PetscCall(HdfRead("-output", self->path, number_name[SHAPE_COUNT], 1, &n, &shapes));
  PetscCall(HdfRead("-output", self->path, number_name[NODE_FIRST], 1, &n, &first));
  for (PetscInt i = 0; i < n; i++)
    self->nodes = PetscMax(self->nodes, (PetscInt64)(first[i] + nodes[i] * shapes[i]));
  PetscCall(PetscFree(nodes));
  PetscCall(PetscFree(shapes));
  PetscCall(PetscFree(first));
  PetscFunctionReturn(0);
}

static PetscErrorCode GoOn(Collection self) {
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(RefuseOther(self));
  self->there = PETSC_TRUE;
  PetscCall(PetscFree(self->status));
  PetscCall(HdfRead("-output", self->path, "/status", 1, &n, &self->status));
  if (self->columns.series)
    PetscCall(Last(self, number_name[STEP_FIRST], number_name[STEP_COUNT], &self->steps));
  if (!self->columns.shapes) PetscFunctionReturn(0);
  PetscCall(Last(self, number_name[SHAPE_FIRST], number_name[SHAPE_COUNT], &self->shapes));
  PetscCall(Nodes(self));
  PetscFunctionReturn(0);
}

/*
  CollectionCreate - the result file of a sweep, which goes on if it is there. Collective on
  OptionsComm(); rank 0 alone uses it then. The caller destroys it with CollectionDestroy(), also
  after an error.

  table, columns  of the sweep; borrowed, live longer
  options         that all members share, and what else makes two sweeps differ; copied

  A file that holds something else, another sweep for example, is a user's mistake.
*/
PetscErrorCode CollectionCreate(const char *path, Table table, const Columns *columns,
                                const char *options, Collection *collection) {
  struct stat status;
  Collection self;
  int there;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *collection = self;
  PetscCall(PetscStrncpy(self->path, path, sizeof(self->path)));
  self->table = table;
  self->columns = *columns;
  PetscCall(PetscStrallocpy(options, &self->options));
  PetscCall(PetscCalloc1(TableRows(table), &self->status));
  PetscCall(OutputRefuse("-output", path));
  PetscCall(LockTake(OptionsComm(), "-output", path));
  there = !stat(path, &status) && status.st_size;
  PetscCallMPI(MPI_Bcast(&there, 1, MPI_INT, 0, OptionsComm()));
  if (there) PetscCall(GoOn(self));
  PetscCall(PetscTime(&self->begun));
  self->stored_at = self->begun;
  PetscFunctionReturn(0);
}

PetscErrorCode CollectionDestroy(Collection *collection) {
  Collection self = *collection;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(LockGive(self->path));
  PetscCall(Emptied(self));
  PetscCall(PetscFree(self->row));
  PetscCall(PetscFree(self->values.a));
  PetscCall(PetscFree(self->series.a));
  PetscCall(PetscFree(self->labels.a));
  for (int i = 0; i < CONTACT_SET; i++) PetscCall(PetscFree(self->shape[i].a));
  PetscCall(PetscFree(self->options));
  PetscCall(PetscFree(self->status));
  PetscCall(PetscFree(*collection));
  PetscFunctionReturn(0);
}

/* CollectionStatus - the status of each member. On all ranks as it was at the beginning; on rank 0
   as it is. */
const PetscReal *CollectionStatus(Collection self) {
  return self->status;
}
