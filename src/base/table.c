#include "base/table.h"
#include "base/hdf.h"
#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>

/* All cells as text, one behind the other with a 0 behind each; those of a file with columns (HDF5)
   column by column, those of a file with lines (CSV) line by line, the names first in both. */
struct _Table {
  PetscInt rows, columns;
  PetscBool by_column;
  size_t size;
  char *text;
  size_t *at; /* [1 + rows][columns], where each begins; the names are row 0 */
  const char *
      *unit; /* [columns], of numbers that say none: NULL, or as it stands behind the name */
};

enum { FAULT = 256, LONGEST = PETSC_MAX_PATH_LEN - 1 };

/* A text of CSV as it is read. */
typedef struct {
  const char *from; /* what is still to be read */
  char *to;         /* where the next cell goes */
  PetscInt line, cells;
  char fault[FAULT];
} Reader;

static PetscBool EndOfLine(char c) {
  return (PetscBool)(c == '\n' || c == '\r' || !c);
}

static const char *Blanks(const char *c) {
  while (*c == ' ' || *c == '\t') c++;
  return c;
}

static void Fault(Reader *self, const char *what) {
  if (!self->fault[0]) (void)snprintf(self->fault, FAULT, "%s (line %d)", what, (int)self->line);
}

/* "a cell in quotes", in which "" is a quote and a comma is nothing special */
static void QuotedCell(Reader *self) {
  const char *c = self->from + 1;

  while (*c && *c != '\n' && (*c != '"' || c[1] == '"')) {
    if (*c == '"') c++;
    *self->to++ = *c++;
  }
  if (*c != '"') {
    Fault(self, "a quote is not closed");
    self->from = c;
    return;
  }
  self->from = Blanks(c + 1);
  if (*self->from != ',' && !EndOfLine(*self->from)) Fault(self, "something stands behind a quote");
}

static void PlainCell(Reader *self) {
  const char *c = self->from, *end;

  while (*c != ',' && !EndOfLine(*c)) c++;
  for (end = c; end > self->from && (end[-1] == ' ' || end[-1] == '\t');) end--;
  while (self->from < end) *self->to++ = *self->from++;
  self->from = c;
}

/* One line, of which something is said: how many cells has it? */
static PetscInt Line(Reader *self) {
  PetscInt n = 0;

  for (;; self->from++) {
    char *begin = self->to;
    self->from = Blanks(self->from);
    if (*self->from == '"')
      QuotedCell(self);
    else
      PlainCell(self);
    if (self->to - begin > LONGEST) Fault(self, "a cell is too long");
    *self->to++ = 0;
    n++;
    if (self->fault[0] || *self->from != ',') break;
  }
  return n;
}

/* Goes to the next line that says something: neither empty nor a comment. */
static PetscBool NextLine(Reader *self) {
  for (;;) {
    const char *c = Blanks(self->from);
    if (!*c) return PETSC_FALSE;
    self->line++;
    if (!EndOfLine(*c) && *c != '#') return PETSC_TRUE;
    while (*c && *c != '\n') c++;
    self->from = *c ? c + 1 : c;
    if (!*c) return PETSC_FALSE;
  }
}

static void SkipEnd(Reader *self) {
  if (*self->from == '\r') self->from++;
  if (*self->from == '\n')
    self->from++;
  else if (*self->from)
    Fault(self, "ends with a carriage return");
}

/* The cells of a text of CSV. */
static PetscErrorCode ReadLines(const char *text, Table self, char fault[FAULT]) {
  const PetscBool marked = (PetscBool)!strncmp(text, "\xef\xbb\xbf", 3); /* as Excel has it */
  Reader reader = {.from = text + (marked ? 3 : 0)};

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(strlen(text) + 2, &self->text)); /* a 0 for each comma and end of line */
  reader.to = self->text;
  for (self->rows = -1; !reader.fault[0] && NextLine(&reader); self->rows++) {
    PetscInt cells = Line(&reader);
    if (self->rows < 0)
      self->columns = cells;
    else if (cells != self->columns && !reader.fault[0])
      (void)snprintf(reader.fault, FAULT, "line %d has %d cells, its header has %d%s",
                     (int)reader.line, (int)cells, (int)self->columns,
                     self->columns == 1 ? "; cells are separated by commas" : "");
    SkipEnd(&reader);
  }
  self->size = (size_t)(reader.to - self->text);
  (void)snprintf(fault, FAULT, "%s", reader.fault);
  PetscFunctionReturn(0);
}

/* A whole file as text. */
static PetscErrorCode ReadFile(const char *path, char **text, char fault[FAULT]) {
  struct stat status;
  FILE *file = fopen(path, "rb");
  size_t n = 0, room = 0, got = 1;

  PetscFunctionBegin;
  *text = NULL;
  if (!file || fstat(fileno(file), &status) || S_ISDIR(status.st_mode))
    (void)snprintf(fault, FAULT, "%s", file ? "is a directory" : strerror(errno));
  while (!fault[0] && got) {
    if (n + 2 > room) {
      room = 2 * room + 65536;
      PetscCall(PetscRealloc(room, text));
    }
    got = fread(*text + n, 1, room - n - 1, file);
    n += got;
  }
  if (file && !fault[0] && ferror(file)) (void)snprintf(fault, FAULT, "%s", strerror(EIO));
  if (file) (void)fclose(file);
  if (fault[0]) PetscFunctionReturn(0);
  (*text)[n] = 0;
  if (strlen(*text) != n) (void)snprintf(fault, FAULT, "is neither text nor HDF5");
  PetscFunctionReturn(0);
}

/* On rank 0. */
static PetscErrorCode ReadTable(const char *path, Table self, char fault[FAULT]) {
  char *text = NULL;

  PetscFunctionBegin;
  self->by_column = HdfIs(path);
  if (self->by_column)
    PetscCall(HdfReadTable(path, &self->columns, &self->rows, &self->text, &self->size, fault));
  else {
    PetscCall(ReadFile(path, &text, fault));
    if (!fault[0]) PetscCall(ReadLines(text, self, fault));
    PetscCall(PetscFree(text));
  }
  if (!fault[0] && !self->columns)
    (void)snprintf(fault, FAULT,
                   "is empty; its first line names the columns, each further is a row");
  else if (!fault[0] && self->rows <= 0)
    (void)snprintf(fault, FAULT, "has no row");
  else if (!fault[0] && self->size > PETSC_MPI_INT_MAX)
    (void)snprintf(fault, FAULT, "is too large");
  PetscFunctionReturn(0);
}

/* Finds the cells in the text. */
static PetscErrorCode Index(Table self) {
  PetscInt rows = self->rows + 1, columns = self->columns;
  size_t at = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)rows * columns, &self->at));
  for (PetscInt k = 0; k < rows * columns; k++) {
    self->at[self->by_column ? k % rows * columns + k / rows : k] = at;
    at += strlen(self->text + at) + 1;
  }
  PetscFunctionReturn(0);
}

/* All ranks get what rank 0 has read. */
static PetscErrorCode Share(Table self) {
  PetscInt word[3] = {self->rows, self->columns, (PetscInt)self->size};
  PetscMPIInt rank, flag = self->by_column;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &rank));
  PetscCallMPI(MPI_Bcast(word, 3, MPIU_INT, 0, OptionsComm()));
  PetscCallMPI(MPI_Bcast(&flag, 1, MPI_INT, 0, OptionsComm()));
  self->rows = word[0];
  self->columns = word[1];
  self->size = (size_t)word[2];
  self->by_column = (PetscBool)flag;
  if (rank) PetscCall(PetscMalloc1(self->size, &self->text));
  PetscCallMPI(MPI_Bcast(self->text, (PetscMPIInt)self->size, MPI_CHAR, 0, OptionsComm()));
  PetscCall(Index(self));
  PetscFunctionReturn(0);
}

/* Takes the units off the names: x1 (mm), x1 [mm]. */
static PetscErrorCode TakeUnits(Table self) {
  PetscFunctionBegin;
  PetscCall(PetscCalloc1(self->columns, &self->unit));
  for (PetscInt c = 0; c < self->columns; c++) {
    char *name = self->text + self->at[c], *end = name + strlen(name), *from = strpbrk(name, "([");
    if (!from || from == name || end - from < 3 || !strchr(")]", end[-1])) continue;
    end[-1] = 0;
    self->unit[c] = from + 1;
    while (from > name && isspace((unsigned char)from[-1])) from--;
    *from = 0;
  }
  PetscFunctionReturn(0);
}

/* Writes a cell with a unit behind each of its numbers, 1,2 as 1mm,2mm; where it ends, behind its
   0. What is no number, or carries a unit, stays. */
static char *WithUnit(const char *cell, const char *unit, char *to) {
  for (;; *to++ = *cell++) {
    const size_t length = strcspn(cell, ",");
    char *end;

    (void)strtod(cell, &end);
    (void)memcpy(to, cell, length);
    to += length;
    if (length && end == cell + length) to = strchr(strcpy(to, unit), 0);
    cell += length;
    if (!*cell) break;
  }
  *to++ = 0;
  return to;
}

/* Puts the units of the names behind the numbers below them: cells are then what options are. */
static PetscErrorCode GiveUnits(Table self) {
  size_t cells = (size_t)(self->rows + 1) * self->columns, longest = 0, room = 0;
  char *text, *to;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < self->columns; c++)
    if (self->unit[c]) longest = PetscMax(longest, strlen(self->unit[c]));
  if (!longest) PetscFunctionReturn(0);
  for (size_t n = 0; n < self->size; n++)
    room += !self->text[n] || self->text[n] == ',' ? longest + 1 : 1;
  PetscCall(PetscMalloc1(room, &text));
  to = text;
  for (size_t k = 0; k < cells; k++) {
    const char *unit = k < (size_t)self->columns ? NULL : self->unit[k % self->columns],
               *cell = self->text + self->at[k];
    self->at[k] = (size_t)(to - text);
    to = WithUnit(cell, unit ? unit : "", to);
  }
  PetscCall(PetscFree(self->text));
  PetscCall(PetscFree(self->unit));
  self->text = text;
  PetscFunctionReturn(0);
}

/* Refuses a unit above a column of an option that has none. */
static PetscErrorCode CheckUnit(const char *option, const char *path, Table self, PetscInt column) {
  char name[80];
  const OptionRow *row;

  PetscFunctionBegin;
  if (!self->unit[column]) PetscFunctionReturn(0);
  (void)snprintf(name, sizeof(name), "-%s", TableName(self, column));
  row = OptionFind(name);
  UserCheck(row && (row->dimension != UNIT_NONE || row->kind == KIND_TEXT), OptionsComm(),
            "%s %s: %s has no unit; take (%s) out of its heading", option, path, name,
            self->unit[column]);
  PetscFunctionReturn(0);
}

/* Refuses a name that cannot stand above a column. */
static PetscErrorCode CheckName(const char *option, const char *path, Table self, PetscInt column) {
  char name[80];
  const OptionRow *row;
  const char *near;

  PetscFunctionBegin;
  (void)snprintf(name, sizeof(name), "-%s", TableName(self, column));
  UserCheck(name[1], OptionsComm(), "%s %s: column %d has no name", option, path, (int)column + 1);
  for (PetscInt c = 0; c < column; c++)
    UserCheck(strcmp(TableName(self, c), name + 1), OptionsComm(), "%s %s: has %s twice", option,
              path, name);
  row = OptionFind(name);
  near = OptionNearest(name);
  UserCheck(row || !near, OptionsComm(), "%s %s: %s: unknown option, did you mean %s?", option,
            path, name, near);
  UserCheck(row || OptionOfPetsc(name), OptionsComm(),
            "%s %s: %s: unknown option; -help lists them", option, path, name);
  UserCheck(!row || !(row->flags & (PROGRAM | OUTPUT_FILE)), OptionsComm(),
            "%s %s: %s is of the sweep as a whole, not of a run; take the column out", option, path,
            name);
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadAny(const char *option, const char *path, Table *table) {
  char fault[FAULT] = "";
  PetscMPIInt rank;
  Table self;

  PetscFunctionBegin;
  PetscCall(PetscNew(&self));
  *table = self;
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &rank));
  if (!rank) PetscCall(ReadTable(path, self, fault));
  PetscCallMPI(MPI_Bcast(fault, FAULT, MPI_CHAR, 0, OptionsComm()));
  UserCheck(!fault[0], OptionsComm(), "%s %s: %s", option, path, fault);
  PetscCall(Share(self));
  PetscFunctionReturn(0);
}

/*
  TableReadPlain - reads a table whatever the names above its columns. Collective on OptionsComm():
  rank 0 reads. The caller destroys it with TableDestroy(), also after an error.

  option  the option that gave the file, named in the message when the file is bad
  path    CSV: names above the columns, with the unit of numbers that carry none in brackets, #
  begins a comment. Or HDF5: a dataset a column, of one entry a row; its attribute `units` stands
  behind each number.

  A file that is no table is a user's mistake; what stands in its cells is not looked at.
*/
PetscErrorCode TableReadPlain(const char *option, const char *path, Table *table) {
  PetscFunctionBegin;
  PetscCall(ReadAny(option, path, table));
  PetscCall(TakeUnits(*table));
  PetscFunctionReturn(0);
}

/*
  TableRead - reads a table of options, as TableReadPlain() does, and checks its names: options,
  with or without their dash, above the columns, a run a row. A unit behind a name, in brackets,
  stands behind each number below it that carries none. An empty cell, or NaN, says nothing about
  its option. Collective.
*/
PetscErrorCode TableRead(const char *option, const char *path, Table *table) {
  PetscFunctionBegin;
  PetscCall(ReadAny(option, path, table));
  PetscCall(TakeUnits(*table));
  for (PetscInt c = 0; c < (*table)->columns; c++) {
    PetscCall(CheckName(option, path, *table, c));
    PetscCall(CheckUnit(option, path, *table, c));
  }
  PetscCall(GiveUnits(*table));
  PetscFunctionReturn(0);
}

PetscErrorCode TableDestroy(Table *table) {
  PetscFunctionBegin;
  if (!*table) PetscFunctionReturn(0);
  PetscCall(PetscFree((*table)->text));
  PetscCall(PetscFree((*table)->at));
  PetscCall(PetscFree((*table)->unit));
  PetscCall(PetscFree(*table));
  PetscFunctionReturn(0);
}

/* TableRows - how many runs it is of. */
PetscInt TableRows(Table table) {
  return table->rows;
}

/* TableColumns - how many options it has. */
PetscInt TableColumns(Table table) {
  return table->columns;
}

/* TableName - the option of a column, without its dash. */
const char *TableName(Table table, PetscInt column) {
  const char *name = table->text + table->at[column];
  return name + (*name == '-');
}

/* TableCell - what a row says of a column's option; empty: nothing. */
const char *TableCell(Table table, PetscInt row, PetscInt column) {
  return table->text + table->at[(row + 1) * table->columns + column];
}

/* TableNumber - is a cell a number, and which? An empty one is NaN. */
PetscBool TableNumber(const char *cell, PetscReal *value) {
  char *end;

  *value = strtod(cell, &end);
  if (!*cell) *value = NAN;
  return (PetscBool) !*end;
}

/* TableQuantity - the number of a cell, which may carry a unit, or have that of its column; what
   names it where it is none. Collective on OptionsComm(). */
PetscErrorCode TableQuantity(const char *what, Table table, PetscInt row, PetscInt column,
                             Dimension dimension, PetscReal *value) {
  const char *cell = TableCell(table, row, column),
             *unit = table->unit ? table->unit[column] : NULL;
  char text[2 * PETSC_MAX_PATH_LEN];
  PetscReal number;

  PetscFunctionBegin;
  if (unit && *cell && TableNumber(cell, &number)) {
    (void)snprintf(text, sizeof(text), "%s%s", cell, unit);
    cell = text;
  }
  PetscCall(OptionQuantity(what, cell, dimension, value));
  PetscFunctionReturn(0);
}

/*
  TableQuantities - the numbers of a column, as TableQuantity() has them. Collective on
  OptionsComm().

  option, path  which named the table, for what is said of a cell that is no number
  value         TableRows() values, the caller's
*/
PetscErrorCode TableQuantities(const char *option, const char *path, Table table, PetscInt column,
                               Dimension dimension, PetscReal value[]) {
  char name[PETSC_MAX_PATH_LEN + 128];

  PetscFunctionBegin;
  (void)snprintf(name, sizeof(name), "%s %s: %s", option, path, TableName(table, column));
  for (PetscInt i = 0; i < table->rows; i++)
    PetscCall(TableQuantity(name, table, i, column, dimension, &value[i]));
  PetscFunctionReturn(0);
}

/* TableMark - 16 digits that two tables share only if they are the same. (The hash of Fowler, Noll
   and Vo.) */
void TableMark(Table table, char mark[17]) {
  unsigned long long hash = 14695981039346656037ull;

  for (PetscInt r = -1; r < table->rows; r++)
    for (PetscInt c = 0; c < table->columns; c++) {
      const char *cell = r < 0 ? TableName(table, c) : TableCell(table, r, c);
      do hash = (hash ^ (unsigned char)*cell) * 1099511628211ull;
      while (*cell++);
    }
  (void)snprintf(mark, 17, "%016llx", hash);
}

/* TableRowName - a row as the name of a file, NAME=VALUE__NAME=VALUE. */
void TableRowName(Table table, PetscInt row, char *name, size_t length) {
  size_t n = 0;

  name[0] = 0;
  for (PetscInt c = 0; c < table->columns && n < length; c++)
    if (TableCell(table, row, c)[0])
      n += (size_t)snprintf(name + n, length - n, "%s%s=%s", n ? "__" : "", TableName(table, c),
                            TableCell(table, row, c));
}
