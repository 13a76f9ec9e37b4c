/*
  Sections, rows of tables and prefixes are three spellings of (rod, option, value). What a rod has
  is put together from, each before the next:

    the lines before the first section, which all rods share;
    those of a section [rods FILE.csv], for each rod of its table; the rod's row there;
    the rod's own section [rod NAME];
    -NAME_option, on the command line or before the first section.

  How rods touch that are named in [pair NAME NAME] is told there likewise.

  It is a database of options of its own, from which the rod's scene reads what any scene does.
*/
#include "system/rods.h"
#include "base/table.h"
#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Where an option of a rod was said. */
typedef struct {
  char *name, *value; /* value NULL: none */
  const char *file;   /* NULL: on the command line; borrowed */
  int line;           /* 0: in a row of a table */
} Said;

typedef struct {
  char name[ROD_NAME];
  const char *table; /* that it stands in, borrowed; NULL: none */
  const char *pair;  /* it is no rod but how these touch: their names, borrowed; NULL: a rod */
  const char *file;  /* where the rod was named */
  int line;
  PetscBool sectioned; /* it has a section */
  StrandMeeting how;   /* of a pair */
  PetscOptions options;
  Reading reading;
  PetscInt n, room;
  Said *said;
} OneRod;

struct _Rods {
  PetscInt n, room;
  OneRod *rod;
  PetscInt pairs;
  OneRod *pair;      /* in their order, the later before the former */
  PetscBool touch;   /* all do that no pair is said to be of */
  PetscBool entered; /* options are those of one of them */
};

/* ---- where it was said ---- */

/* A file's name without its directory, and short. */
static const char *Short(const char *file) {
  const char *slash = strrchr(file, '/');
  return slash ? slash + 1 : file;
}

static void About(const OneRod *rod, const Said *said, char about[96]) {
  const char *file = said ? said->file : rod->file;
  const int line = said ? said->line : rod->line;

  if (rod->pair)
    (void)snprintf(about, 96, "%.36s, line %d, pair %.30s: ", Short(file), line, rod->pair);
  else if (!file)
    (void)snprintf(about, 96, "-%s%s: ", rod->name, said ? "_" : "");
  else if (line)
    (void)snprintf(about, 96, "%.36s, line %d, rod %s: ", Short(file), line, rod->name);
  else
    (void)snprintf(about, 96, "%.36s, rod %s: ", Short(file), rod->name);
}

/* What stands before a line about a rod: where the option was said that the line begins with. */
static void Locate(const void *ctx, const char *message, char about[96]) {
  const OneRod *rod = (const OneRod *)ctx;
  const size_t n = strcspn(message, " :,");
  const Said *said = NULL;

  for (PetscInt i = 0; i < rod->n; i++)
    if (strlen(rod->said[i].name) == n && !strncmp(rod->said[i].name, message, n))
      said = &rod->said[i];
  About(rod, said, about);
}

/* ---- the rods ---- */

static OneRod *Find(const Rods self, const char *name) {
  for (PetscInt k = 0; k < self->n; k++)
    if (!strcmp(self->rod[k].name, name)) return &self->rod[k];
  return NULL;
}

/* Is a name the first word of an option, so that -NAME_ could be of either? */
static PetscBool IsWordOfOptions(const char *name) {
  const size_t n = strlen(name);
  const OptionRow *row;
  size_t place = 0;
  char begin[ROD_NAME + 2];

  while ((row = OptionNext(&place)))
    if (!strncmp(row->name + 1, name, n) && (row->name[1 + n] == '_' || !row->name[1 + n]))
      return PETSC_TRUE;
  (void)snprintf(begin, sizeof(begin), "-%s_", name);
  return OptionOfPetsc(begin);
}

static PetscErrorCode CheckName(const char *name, const char *file, int line) {
  PetscBool good = (PetscBool)isalpha((unsigned char)name[0]);

  PetscFunctionBegin;
  for (const char *c = name; *c; c++)
    if (!isalnum((unsigned char)*c)) good = PETSC_FALSE;
  UserCheck(good && strlen(name) < ROD_NAME, OptionsComm(),
            "%s, line %d: a rod's name is of letters and digits, %d at most: %.60s", file, line,
            ROD_NAME - 1, name);
  UserCheck(!IsWordOfOptions(name), OptionsComm(),
            "%s, line %d: a rod cannot be named %s, for -%s_ begins the names of options; give it "
            "another",
            file, line, name, name);
  PetscFunctionReturn(0);
}

static PetscErrorCode AddRod(Rods self, const char *name, const char *file, int line,
                             OneRod **rod) {
  PetscFunctionBegin;
  PetscCall(CheckName(name, file, line));
  if (self->n == self->room) {
    self->room = 2 * self->room + 8;
    PetscCall(PetscRealloc((size_t)self->room * sizeof(*self->rod), &self->rod));
  }
  *rod = &self->rod[self->n++];
  **rod = (OneRod){.file = file, .line = line};
  PetscCall(PetscStrncpy((*rod)->name, name, ROD_NAME));
  PetscFunctionReturn(0);
}

static const OptionRow rows[] = {
    ROW_BOOL("-contact", "true", 0,
             "in a section [pair NAME NAME]: these rods cannot pass through each other")};
const OptionGroup pair_options = OPTION_GROUP("Pairs of rods", rows);

/* Those that say how two rods touch. */
static PetscBool IsOfPair(const char *name) {
  return (PetscBool)(!strcmp(name, "-contact") || !strcmp(name, "-contact_friction") ||
                     !strcmp(name, "-contact_stiffness"));
}

/* An option that a rod is said to have. */
static PetscErrorCode Say(OneRod *rod, const char *name, const char *value, const char *file,
                          int line) {
  Said *said;

  PetscFunctionBegin;
  if (rod->n == rod->room) {
    rod->room = 2 * rod->room + 16;
    PetscCall(PetscRealloc((size_t)rod->room * sizeof(*rod->said), &rod->said));
  }
  said = &rod->said[rod->n++];
  *said = (Said){.file = file, .line = line};
  PetscCall(PetscStrallocpy(name, &said->name));
  if (value) PetscCall(PetscStrallocpy(value, &said->value));
  ErrorsLocate(Locate, rod);
  if (!OptionFind(name)) PetscCall(OptionsRefuse(name));
  if (rod->pair)
    UserCheck(IsOfPair(name), OptionsComm(),
              "%s: is not of how two rods touch; a pair has -contact, -contact_friction and "
              "-contact_stiffness",
              name);
  else
    UserCheck(OptionOfRod(name), OptionsComm(),
              "%s: is of the scene as a whole, and no rod's own; write it before the first section",
              name);
  ErrorsLocate(NULL, NULL);
  PetscFunctionReturn(0);
}

/* All options of a section, of one rod. */
static PetscErrorCode SaySection(OneRod *rod, const OptionSection *section) {
  PetscFunctionBegin;
  for (int i = 0; i < section->n; i++)
    PetscCall(Say(rod, section->option[i].name, section->option[i].value, section->file,
                  section->option[i].line));
  PetscFunctionReturn(0);
}

/* The file that a cell of a table names counts from where the table is. */
static void CellPlace(const char *table, const char *cell, char path[2 * PETSC_MAX_PATH_LEN]) {
  const char *slash = strrchr(table, '/');
  struct stat status;

  (void)snprintf(path, 2 * PETSC_MAX_PATH_LEN, "%s", cell);
  if (cell[0] == '/' || !slash) return;
  (void)snprintf(path, 2 * PETSC_MAX_PATH_LEN, "%.*s/%s", (int)(slash - table), table, cell);
  if (stat(path, &status)) (void)snprintf(path, 2 * PETSC_MAX_PATH_LEN, "%s", cell);
}

/* One row of a table: a rod that is there already has it as well. */
static PetscErrorCode ReadRow(Rods self, const OptionSection *section, Table table, PetscInt row,
                              PetscInt names) {
  const char *const file = section->head + strlen("rods ");
  const char *const called = TableCell(table, row, names);
  char name[128], path[2 * PETSC_MAX_PATH_LEN];
  OneRod *rod = Find(self, called);

  PetscFunctionBegin;
  UserCheck(!rod, OptionsComm(), "%s: two rods are named %s", file, called);
  PetscCall(AddRod(self, called, file, 0, &rod));
  rod->table = file;
  PetscCall(SaySection(rod, section));
  for (PetscInt c = 0; c < TableColumns(table); c++) {
    const char *cell = TableCell(table, row, c);
    const OptionRow *option;
    if (c == names || !*cell) continue;
    (void)snprintf(name, sizeof(name), "-%s", TableName(table, c));
    option = OptionFind(name);
    if (option && option->flags & INPUT_FILE) {
      CellPlace(file, cell, path);
      cell = path;
    }
    PetscCall(Say(rod, name, cell, file, 0));
  }
  PetscFunctionReturn(0);
}

/* [rods FILE.csv] */
static PetscErrorCode ReadTable(Rods self, const OptionSection *section) {
  const char *const file = section->head + strlen("rods ");
  PetscInt names = -1;
  Table table;

  PetscFunctionBegin;
  PetscCall(TableReadPlain("[rods]", file, &table));
  for (PetscInt c = 0; c < TableColumns(table); c++)
    if (!strcmp(TableName(table, c), "name")) names = c;
  UserCheck(names >= 0, OptionsComm(),
            "[rods] %s: has no column `name`, which says what each rod is called", file);
  for (PetscInt r = 0; r < TableRows(table); r++)
    PetscCall(ReadRow(self, section, table, r, names));
  PetscCall(TableDestroy(&table));
  PetscFunctionReturn(0);
}

/* [rod NAME] */
static PetscErrorCode ReadSection(Rods self, const OptionSection *section) {
  const char *const name = section->head + strlen("rod ");
  OneRod *rod = Find(self, name);

  PetscFunctionBegin;
  UserCheck(!rod || !rod->sectioned, OptionsComm(),
            "%s, line %d: there is a [rod %s] already; give each rod one section", section->file,
            section->line, name);
  if (!rod) PetscCall(AddRod(self, name, section->file, section->line, &rod));
  rod->sectioned = PETSC_TRUE;
  PetscCall(SaySection(rod, section));
  PetscFunctionReturn(0);
}

static PetscBool Is(const OptionSection *section, const char *kind) {
  const size_t n = strlen(kind);
  return (PetscBool)(!strncmp(section->head, kind, n) && section->head[n] == ' ');
}

/* ---- pairs ---- */

/* Does a rod stand in the table of that name, FILE of FILE.csv? */
static PetscBool IsOfTable(const OneRod *rod, const char *name, size_t n) {
  const char *table = rod->table ? Short(rod->table) : NULL;
  return (PetscBool)(table && !strncmp(table, name, n) && (!table[n] || table[n] == '.'));
}

/* Is a rod meant by a name: its own, that of its table, or one of several, as in a+b? */
static PetscBool IsCalled(const OneRod *rod, const char *name, size_t n) {
  for (size_t at = 0; at < n; at++) {
    const size_t m = PetscMin(strcspn(name + at, "+"), n - at);
    if (strlen(rod->name) == m && !strncmp(rod->name, name + at, m)) return PETSC_TRUE;
    if (IsOfTable(rod, name + at, m)) return PETSC_TRUE;
    at += m;
  }
  return PETSC_FALSE;
}

/* Goes to the next name of a pair: where it begins, and how long it is; NULL: there are no more. */
static const char *NextName(const char *from, size_t *n) {
  from += strspn(from, " ,");
  *n = strcspn(from, " ,");
  return *n ? from : NULL;
}

/* Are two rods a pair: each meant by a name of its own? */
static PetscBool IsPair(const OneRod *pair, const OneRod *a, const OneRod *b) {
  size_t n, m;

  for (const char *one = NextName(pair->pair, &n); one; one = NextName(one + n, &n))
    for (const char *other = NextName(pair->pair, &m); other; other = NextName(other + m, &m))
      if (one != other && IsCalled(a, one, n) && IsCalled(b, other, m)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* [pair NAME NAME] */
static PetscErrorCode ReadPair(Rods self, const OptionSection *section) {
  OneRod *pair = &self->pair[self->pairs++];
  PetscInt names = 0;
  size_t n;

  PetscFunctionBegin;
  *pair = (OneRod){
      .pair = section->head + strlen("pair "), .file = section->file, .line = section->line};
  for (const char *name = NextName(pair->pair, &n); name; name = NextName(name + n, &n), names++) {
    PetscBool known = PETSC_FALSE;
    for (PetscInt k = 0; k < self->n; k++)
      if (IsCalled(&self->rod[k], name, n)) known = PETSC_TRUE;
    UserCheck(known, OptionsComm(),
              "%s, line %d: [%.60s]: no rod, and no table of rods, is called %.*s", section->file,
              section->line, section->head, (int)PetscMin(n, 40), name);
  }
  UserCheck(names > 1, OptionsComm(),
            "%s, line %d: [%.60s]: a pair has two names; rods of one table touch each other by "
            "[pair NAME NAME]",
            section->file, section->line, section->head);
  PetscCall(SaySection(pair, section));
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadSections(Rods self, const OptionWords *words) {
  PetscFunctionBegin;
  for (int k = 0; k < words->sections; k++)
    if (Is(&words->section[k], "rods")) PetscCall(ReadTable(self, &words->section[k]));
  for (int k = 0; k < words->sections; k++)
    if (Is(&words->section[k], "rod")) PetscCall(ReadSection(self, &words->section[k]));
  PetscCall(PetscCalloc1(words->sections, &self->pair));
  for (int k = 0; k < words->sections; k++)
    if (Is(&words->section[k], "pair")) PetscCall(ReadPair(self, &words->section[k]));
  PetscFunctionReturn(0);
}

/* ---- prefixes, and what all share ---- */

/* The rod whose prefix a name begins with; NULL: none. */
static OneRod *OfPrefix(Rods self, const char *name) {
  for (PetscInt k = 0; k < self->n; k++) {
    const size_t n = strlen(self->rod[k].name);
    if (!strncmp(name + 1, self->rod[k].name, n) && name[1 + n] == '_') return &self->rod[k];
  }
  return NULL;
}

/* What all rods share of the options given: all but those of the program as a whole. */
static PetscErrorCode Share(Rods self, const char *name, const char *value) {
  const OptionRow *row = OptionFind(name);

  PetscFunctionBegin;
  if (row && row->flags & PROGRAM) PetscFunctionReturn(0);
  for (PetscInt k = 0; k < self->n; k++)
    PetscCall(PetscOptionsSetValue(self->rod[k].options, name, value));
  PetscFunctionReturn(0);
}

/* -NAME_option: it is the rod's from now on, and of nobody else. */
static PetscErrorCode TakePrefixed(OneRod *rod, const char *name, const char *value) {
  char option[128];

  PetscFunctionBegin;
  (void)snprintf(option, sizeof(option), "-%s", name + strlen(rod->name) + 2);
  PetscCall(Say(rod, option, value, NULL, 0));
  PetscCall(PetscOptionsClearValue(NULL, name));
  PetscFunctionReturn(0);
}

/* (Asking PETSc for a value would count as reading it.) */
static PetscErrorCode ReadGiven(Rods self) {
  char *text;

  PetscFunctionBegin;
  PetscCall(OptionsList(&text));
  for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
    char *value = line + strcspn(line, " ");
    OneRod *rod;
    if (*value) *value++ = 0;
    rod = OptionFind(line) ? NULL : OfPrefix(self, line);
    if (rod)
      PetscCall(TakePrefixed(rod, line, *value ? value : NULL));
    else
      PetscCall(Share(self, line, *value ? value : NULL));
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(0);
}

/* Options are those of one rod, or of one pair. */
static PetscErrorCode Enter(Rods self, OneRod *rod) {
  PetscFunctionBegin;
  PetscCall(OptionsEnter(rod->reading));
  self->entered = PETSC_TRUE;
  ErrorsLocate(Locate, rod);
  PetscFunctionReturn(0);
}

/* Reads what pairs are said to have. */
static PetscErrorCode TakePairs(Rods self) {
  PetscBool given;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->pairs; k++) {
    OneRod *pair = &self->pair[k];
    PetscCall(PetscOptionsCreate(&pair->options));
    for (PetscInt i = 0; i < pair->n; i++)
      PetscCall(PetscOptionsSetValue(pair->options, pair->said[i].name, pair->said[i].value));
    PetscCall(ReadingCreate(PETSC_COMM_SELF, pair->options, NULL, &pair->reading));
    PetscCall(Enter(self, pair));
    pair->how.touch = PETSC_TRUE;
    PetscCall(OptionBool("-contact", &pair->how.touch, NULL));
    PetscCall(OptionReal("-contact_friction", &pair->how.friction, &given));
    if (!given) pair->how.friction = -1;
    PetscCall(OptionReal("-contact_stiffness", &pair->how.stiffness, &given));
    if (!given) pair->how.stiffness = 0;
    PetscCall(RodsLeave(self));
  }
  self->touch = (PetscBool)(self->pairs > 0);
  PetscCall(OptionBool("-contact_rods", &self->touch, NULL));
  PetscFunctionReturn(0);
}

/* What each is said to have becomes its options. */
static PetscErrorCode MakeReadings(Rods self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) PetscCall(PetscOptionsCreate(&self->rod[k].options));
  PetscCall(ReadGiven(self));
  for (PetscInt k = 0; k < self->n; k++) {
    OneRod *rod = &self->rod[k];
    for (PetscInt i = 0; i < rod->n; i++)
      PetscCall(PetscOptionsSetValue(rod->options, rod->said[i].name, rod->said[i].value));
    PetscCall(ReadingCreate(PETSC_COMM_SELF, rod->options, NULL, &rod->reading));
    for (int law = 0; law < OWN_LAWS; law++)
      PetscCall(ReadingSetLaw(rod->reading, (OwnKind)law, OptionsLaw((OwnKind)law)));
  }
  PetscFunctionReturn(0);
}

/*
  RodsRead - the rods of a scene. Collective; the caller destroys them with RodsDestroy(), also
  after an error.

  words  with the sections in which they are

  Options with a rod's prefix are taken out of those of the scene as a whole.
*/
PetscErrorCode RodsRead(const OptionWords *words, Rods *rods) {
  Rods self;

  PetscFunctionBegin;
  PetscCall(PetscNew(rods));
  self = *rods;
  PetscCall(ReadSections(self, words));
  PetscCall(TakePairs(self));
  PetscCall(MakeReadings(self));
  PetscFunctionReturn(0);
}

/* RodsAnew - options of each are again what it is said to have, as before any was read. */
PetscErrorCode RodsAnew(Rods self) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    PetscCall(ReadingDestroy(&self->rod[k].reading));
    PetscCall(PetscOptionsDestroy(&self->rod[k].options));
  }
  PetscCall(MakeReadings(self));
  PetscFunctionReturn(0);
}

/* RodsPut - rod k is said to have an option, from the next RodsAnew() on. */
PetscErrorCode RodsPut(Rods self, PetscInt k, const char *name, const char *value) {
  PetscFunctionBegin;
  PetscCall(Say(&self->rod[k], name, value, NULL, 0));
  PetscFunctionReturn(0);
}

/* Frees what was said of a rod, or of a pair. */
static PetscErrorCode Forget(OneRod *rod) {
  PetscFunctionBegin;
  for (PetscInt i = 0; i < rod->n; i++) {
    PetscCall(PetscFree(rod->said[i].name));
    PetscCall(PetscFree(rod->said[i].value));
  }
  PetscCall(PetscFree(rod->said));
  PetscCall(ReadingDestroy(&rod->reading));
  PetscCall(PetscOptionsDestroy(&rod->options));
  PetscFunctionReturn(0);
}

PetscErrorCode RodsDestroy(Rods *rods) {
  Rods self = *rods;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  PetscCall(RodsLeave(self));
  for (PetscInt k = 0; k < self->n; k++) PetscCall(Forget(&self->rod[k]));
  for (PetscInt k = 0; k < self->pairs; k++) PetscCall(Forget(&self->pair[k]));
  PetscCall(PetscFree(self->rod));
  PetscCall(PetscFree(self->pair));
  PetscCall(PetscFree(*rods));
  PetscFunctionReturn(0);
}

PetscInt RodsCount(Rods self) {
  return self->n;
}

const char *RodsName(Rods self, PetscInt k) {
  return self->rod[k].name;
}

/* RodsEnter - from here on options are those of one rod, and errors are told as of it, until
   RodsLeave(); RodsDestroy() does that after an error. */
PetscErrorCode RodsEnter(Rods self, PetscInt k) {
  PetscFunctionBegin;
  PetscCall(Enter(self, &self->rod[k]));
  PetscFunctionReturn(0);
}

PetscErrorCode RodsLeave(Rods self) {
  PetscFunctionBegin;
  if (!self->entered) PetscFunctionReturn(0);
  self->entered = PETSC_FALSE;
  ErrorsLocate(NULL, NULL);
  PetscCall(OptionsLeave());
  PetscFunctionReturn(0);
}

/* RodsTouch - may any of them touch another one? */
PetscBool RodsTouch(Rods self) {
  return (PetscBool)(self->touch || self->pairs > 0);
}

/* RodsMeet - how two of them touch: by what pairs are said to have, of which the later counts. */
void RodsMeet(Rods self, PetscInt a, PetscInt b, StrandMeeting *how) {
  *how = (StrandMeeting){.touch = self->touch, .friction = -1};
  for (PetscInt k = 0; k < self->pairs; k++) {
    const OneRod *pair = &self->pair[k];
    if (!IsPair(pair, &self->rod[a], &self->rod[b])) continue;
    how->touch = pair->how.touch;
    if (pair->how.friction >= 0) how->friction = pair->how.friction;
    if (pair->how.stiffness > 0) how->stiffness = pair->how.stiffness;
  }
}

/* RodsRefuseThin - refuses a pair with rod k, which has no diameter, unless it says that these do
   not touch. */
PetscErrorCode RodsRefuseThin(Rods self, PetscInt k) {
  size_t n;

  PetscFunctionBegin;
  for (PetscInt p = 0; p < self->pairs; p++) {
    const OneRod *pair = &self->pair[p];
    if (!pair->how.touch) continue;
    ErrorsLocate(Locate, pair);
    for (const char *name = NextName(pair->pair, &n); name; name = NextName(name + n, &n))
      UserCheck(!IsCalled(&self->rod[k], name, n), OptionsComm(),
                "rod %s has no thickness; give it a -contact_diameter", self->rod[k].name);
    ErrorsLocate(NULL, NULL);
  }
  PetscFunctionReturn(0);
}

/* Has anything read an option that all share? */
static PetscErrorCode IsRead(Rods self, const char *name, PetscBool *read) {
  PetscFunctionBegin;
  PetscCall(PetscOptionsUsed(NULL, name + 1, read));
  for (PetscInt k = 0; k < self->n && !*read; k++)
    PetscCall(PetscOptionsUsed(self->rod[k].options, name + 1, read));
  PetscFunctionReturn(0);
}

/* RodsRefuseUnread - as OptionsRefuseUnread(), of a scene of several rods: refuses what was said of
   a rod and that one does not read; and counts as read, of what all share, what any rod reads.
   Collective. */
PetscErrorCode RodsRefuseUnread(Rods self) {
  PetscBool read;
  char *text;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->n; k++) {
    const OneRod *rod = &self->rod[k];
    for (PetscInt i = 0; i < rod->n; i++) {
      PetscCall(PetscOptionsUsed(rod->options, rod->said[i].name + 1, &read));
      if (read) continue;
      ErrorsLocate(Locate, rod);
      PetscCall(OptionsRefuse(rod->said[i].name));
    }
  }
  PetscCall(OptionsList(&text));
  for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
    line[strcspn(line, " ")] = 0;
    PetscCall(IsRead(self, line, &read));
    if (read) PetscCall(PetscOptionsHasName(NULL, NULL, line, &read)); /* asking counts */
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(0);
}

/* The names of a pair, those of the rods of a table instead of its own: a text has no tables. The
   caller frees it. */
static PetscErrorCode PairText(const Rods self, const OneRod *pair, char **text) {
  size_t room = 1, at = 0, n;

  PetscFunctionBegin;
  for (const char *name = NextName(pair->pair, &n); name; name = NextName(name + n, &n))
    for (PetscInt k = 0; k < self->n; k++) room += ROD_NAME + 2;
  PetscCall(PetscCalloc1(room, text));
  for (const char *name = NextName(pair->pair, &n); name; name = NextName(name + n, &n)) {
    const char *between = at ? " " : "";
    for (PetscInt k = 0; k < self->n; k++) {
      if (!IsCalled(&self->rod[k], name, n)) continue;
      at += (size_t)snprintf(*text + at, room - at, "%s%s", between, self->rod[k].name);
      between = "+";
    }
  }
  PetscFunctionReturn(0);
}

/* Room for what is said of a rod, or of a pair. */
static size_t RoomOf(const OneRod *rod) {
  size_t room = ROD_NAME + 16;

  for (PetscInt i = 0; i < rod->n; i++)
    room += strlen(rod->said[i].name) + (rod->said[i].value ? strlen(rod->said[i].value) : 0) + 2;
  return room;
}

/* Its section, put behind what stands there. */
static void TextOf(const OneRod *rod, const char *called, size_t room, char *text, size_t *at) {
  *at += (size_t)snprintf(text + *at, room - *at, "[%s %s]\n", rod->pair ? "pair" : "rod", called);
  for (PetscInt i = 0; i < rod->n; i++)
    *at += (size_t)snprintf(text + *at, room - *at, "%s %s\n", rod->said[i].name,
                            rod->said[i].value ? rod->said[i].value : "");
}

/* RodsText - the rods, and their pairs, as an options file has them, a section each. The caller
   frees it. */
PetscErrorCode RodsText(Rods self, char **text) {
  size_t room = 1, at = 0;
  char **called;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(self->pairs, &called));
  for (PetscInt k = 0; k < self->n; k++) room += RoomOf(&self->rod[k]);
  for (PetscInt k = 0; k < self->pairs; k++) {
    PetscCall(PairText(self, &self->pair[k], &called[k]));
    room += RoomOf(&self->pair[k]) + strlen(called[k]);
  }
  PetscCall(PetscCalloc1(room, text));
  for (PetscInt k = 0; k < self->n; k++) TextOf(&self->rod[k], self->rod[k].name, room, *text, &at);
  for (PetscInt k = 0; k < self->pairs; k++) {
    TextOf(&self->pair[k], called[k], room, *text, &at);
    PetscCall(PetscFree(called[k]));
  }
  PetscCall(PetscFree(called));
  PetscFunctionReturn(0);
}
