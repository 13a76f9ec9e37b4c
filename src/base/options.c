/* Reading options: each value is parsed strictly and checked against its row of the table. */
#include "base/options.h"
#include <ctype.h>
#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/stat.h>

enum { MOST_BARE = 16, LONGEST_BARE = 60 };

/* One run's options: PETSc's database of them, the ranks that share it, its laboratory units, and
   what was read, for the record. A sweep has one of each member, a host program of each of its
   simulations. */
struct _Reading {
  MPI_Comm comm;
  PetscOptions options;      /* borrowed; NULL: those of the command line */
  const CommandLine *line;   /* borrowed; NULL: that of the run around it */
  PetscReal scale[UNIT_ALL]; /* 0: unknown */
  size_t n, room;
  struct {
    const OptionRow *row;
    char *value;
  } * read;
  size_t n_bare;
  struct {
    const char *name;
    char *said;
  } bare[MOST_BARE]; /* whose value has lost its unit in the database */
  size_t n_plain;
  struct {
    const OptionRow *row;
    PetscReal value;
  } plain[MOST_BARE]; /* that had none, and could have had one */
  struct {
    char file[PETSC_MAX_PATH_LEN]; /* with the option that names it */
    int at;                        /* the line that is read; 0: none */
    int line;                      /* of the first such number; 0: there is none */
    char first[64];
    size_t more;
  } lines;               /* such numbers in the lines of a file */
  OwnLaw *law[OWN_LAWS]; /* borrowed; in the place of what options say */
  PetscBool entered;
  Reading outer;
};

/* Of whoever is at work; it is NULL, or the host's, whenever no call is under way. */
static Reading now;

/* ReadingCreate - a run's options. The caller destroys it with ReadingDestroy(), when it is not
   entered.

   comm      the ranks that share them
   options   PETSc's database of them; NULL: the one of the command line
   line      that command line; NULL: that of the run around it, if there is one */
PetscErrorCode ReadingCreate(MPI_Comm comm, PetscOptions options, const CommandLine *line,
                             Reading *reading) {
  PetscFunctionBegin;
  PetscCall(PetscNew(reading));
  (*reading)->comm = comm;
  (*reading)->options = options;
  (*reading)->line = line;
  PetscFunctionReturn(0);
}

/* ReadingSetLaw - a law of one's own, or, where its value is NULL, none. It is borrowed. */
PetscErrorCode ReadingSetLaw(Reading self, OwnKind kind, OwnLaw *law) {
  PetscFunctionBegin;
  self->law[kind] = law;
  PetscFunctionReturn(0);
}

PetscErrorCode ReadingDestroy(Reading *reading) {
  Reading self = *reading;

  PetscFunctionBegin;
  if (!self) PetscFunctionReturn(0);
  for (size_t i = 0; i < self->n; i++) PetscCall(PetscFree(self->read[i].value));
  PetscCall(PetscFree(self->read));
  for (size_t i = 0; i < self->n_bare; i++) PetscCall(PetscFree(self->bare[i].said));
  PetscCall(PetscFree(*reading));
  PetscFunctionReturn(0);
}

/* OptionsEnter - from here on options are those of this run, until OptionsLeave(): a run may be
   entered any number of times, one after the other. Not collective. */
PetscErrorCode OptionsEnter(Reading self) {
  PetscFunctionBegin;
  PetscCheck(!self->entered, PETSC_COMM_SELF, PETSC_ERR_ORDER, "a run is entered while it is");
  if (self->options) PetscCall(PetscOptionsPush(self->options));
  self->entered = PETSC_TRUE;
  self->outer = now;
  now = self;
  PetscFunctionReturn(0);
}

PetscErrorCode OptionsLeave(void) {
  Reading self = now;

  PetscFunctionBegin;
  if (self->options) PetscCall(PetscOptionsPop());
  self->entered = PETSC_FALSE;
  now = self->outer;
  PetscFunctionReturn(0);
}

/* OptionsPush - ReadingCreate() and OptionsEnter() in one: from here on options are those of
   another run, until OptionsPop(). */
PetscErrorCode OptionsPush(MPI_Comm comm, PetscOptions options, const CommandLine *line) {
  Reading self;

  PetscFunctionBegin;
  PetscCall(ReadingCreate(comm, options, line, &self));
  PetscCall(OptionsEnter(self));
  PetscFunctionReturn(0);
}

/* OptionsPop - ends what OptionsPush() began. */
PetscErrorCode OptionsPop(void) {
  Reading self = now;

  PetscFunctionBegin;
  PetscCall(OptionsLeave());
  PetscCall(ReadingDestroy(&self));
  PetscFunctionReturn(0);
}

/* OptionsPushed - are the options now read those of a run within another, a member of a sweep? */
PetscBool OptionsPushed(void) {
  return (PetscBool)(now && now->options);
}

/* OptionsLaw - the law of one's own of this run; NULL: it has none of this kind. */
OwnLaw *OptionsLaw(OwnKind kind) {
  OwnLaw *law = now ? now->law[kind] : NULL;

  return law && law->value ? law : NULL;
}

/* OptionsLine - the command line of the run, or of the one around it; NULL: there is none. */
const CommandLine *OptionsLine(void) {
  Reading self = now;

  while (self && !self->line) self = self->outer;
  return self ? self->line : NULL;
}

/* OptionsComm - the ranks that share the options now read. */
MPI_Comm OptionsComm(void) {
  return now ? now->comm : PETSC_COMM_WORLD;
}

/* OptionsSetScales - what 1 of each dimension is in SI units; 0: not known. From here on values may
   carry units. */
PetscErrorCode OptionsSetScales(const PetscReal scale[UNIT_ALL]) {
  PetscFunctionBegin;
  if (now) PetscCall(PetscArraycpy(now->scale, scale, UNIT_ALL));
  PetscFunctionReturn(0);
}

/* OptionsScale - what 1 of a dimension is in SI units; 0: not known. */
PetscReal OptionsScale(Dimension dimension) {
  if (dimension == UNIT_RATE)
    return now && now->scale[UNIT_TIME] > 0 ? 1 / now->scale[UNIT_TIME] : 0;
  if (dimension == UNIT_ANGLE || dimension >= UNIT_ALL)
    return 1; /* radians; the -si_ options are in SI as they are */
  return now ? now->scale[dimension] : 0;
}

/* Keeps the value in force of an option, for the record. */
static PetscErrorCode Keep(const OptionRow *row, const char *value) {
  size_t i = 0;

  PetscFunctionBegin;
  if (!now) PetscFunctionReturn(0);
  while (i < now->n && now->read[i].row != row) i++;
  if (i == now->room) {
    now->room = 2 * now->room + 64;
    PetscCall(PetscRealloc(now->room * sizeof(*now->read), &now->read));
  }
  if (i == now->n) {
    now->read[now->n].row = row;
    now->read[now->n++].value = NULL;
  }
  PetscCall(PetscFree(now->read[i].value));
  PetscCall(PetscStrallocpy(value, &now->read[i].value));
  PetscFunctionReturn(0);
}

/* OptionsInForce - the value of every option that was read, defaults included, one a line: "name
   value" without the dash. The caller frees it (PetscFree). */
PetscErrorCode OptionsInForce(char **text) {
  size_t length = 1, at = 0;

  PetscFunctionBegin;
  for (size_t i = 0; now && i < now->n; i++)
    length += strlen(now->read[i].row->name) + strlen(now->read[i].value) + 2;
  PetscCall(PetscCalloc1(length, text));
  for (size_t i = 0; now && i < now->n; i++)
    at += (size_t)snprintf(*text + at, length - at, "%s %s\n", now->read[i].row->name + 1,
                           now->read[i].value);
  PetscFunctionReturn(0);
}

/* OptionNumber - a number as a person writes it (PETSc's %g adds a point to whole ones). */
const char *OptionNumber(PetscReal value, char text[32]) {
  (void)snprintf(text, 32, "%.10g", (double)value);
  return text;
}

/* The row of an option, and the text given for it; found tells if any was. */
static PetscErrorCode Given(const char *name, OptionKind kind, const OptionRow **row, char *text,
                            PetscBool *found) {
  PetscFunctionBegin;
  *row = OptionFind(name);
  PetscCheck(*row && (*row)->kind == kind, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "%s has no row, or one of another kind, in the table of options", name);
  PetscCall(PetscOptionsGetString(NULL, NULL, name, text, PETSC_MAX_PATH_LEN, found));
  PetscFunctionReturn(0);
}

/* The unit behind a number; blanks in it (N m^2) say nothing. */
static void UnitOf(const char *text, char unit[32]) {
  size_t n = 0;

  for (; *text && n < 31; text++)
    if (!isspace((unsigned char)*text)) unit[n++] = *text;
  unit[n] = 0;
}

static PetscErrorCode ParseReal(const OptionRow *row, const char *text, PetscReal *value) {
  PetscReal factor;
  char *end, *more, unit[32], what[128];

  PetscFunctionBegin;
  *value = strtod(text, &end);
  UserCheck(end != text, OptionsComm(), "%s %s: give a number", row->name, text);
  UserCheck(*end != ',' || !isdigit((unsigned char)end[1]), OptionsComm(),
            "%s %s: give a number, with a point: %.*s.%s", row->name, text, (int)(end - text), text,
            end + 1);
  (void)strtod(end, &more);
  UserCheck(more == end || !isspace((unsigned char)*end), OptionsComm(),
            "%s %s: put commas between numbers, and no blanks", row->name, text);
  UnitOf(end, unit);
  (void)snprintf(what, sizeof(what), "%s %.*s", row->name, (int)(end - text), text);
  PetscCall(OptionUnit(what, unit, row->dimension, &factor));
  *value *= factor;
  UserCheck(!PetscIsInfOrNanReal(*value), OptionsComm(), "%s %s: give a finite number", row->name,
            text);
  PetscFunctionReturn(0);
}

static PetscErrorCode ParseInt(const OptionRow *row, const char *text, PetscInt *value) {
  char *end;
  long v;

  PetscFunctionBegin;
  errno = 0;
  v = strtol(text, &end, 10);
  while (isspace((unsigned char)*end)) end++;
  UserCheck(end != text && !*end, OptionsComm(), "%s %s: give a whole number", row->name, text);
  UserCheck(!errno && v > -2000000000L && v < 2000000000L, OptionsComm(), "%s %s: too large",
            row->name, text);
  *value = (PetscInt)v;
  PetscFunctionReturn(0);
}

static PetscErrorCode CheckRange(const OptionRow *row, const char *given, PetscReal value) {
  Dimension told = row->dimension < UNIT_ANGLE ? row->dimension : UNIT_NONE;
  char bound[64];

  PetscFunctionBegin;
  OptionBoth(row->low, told, bound);
  UserCheck(value >= row->low, OptionsComm(), "%s %s: too small, give at least %s", row->name,
            given, bound);
  OptionBoth(row->high, told, bound);
  UserCheck(value <= row->high, OptionsComm(), "%s %s: too large, give at most %s%s", row->name,
            given, bound, row->dimension == UNIT_ANGLE ? " (radians), or degrees with deg" : "");
  PetscFunctionReturn(0);
}

/* Does a text end with its number? */
static PetscBool HasNoUnit(const char *text) {
  char *end;

  (void)strtod(text, &end);
  while (isspace((unsigned char)*end)) end++;
  return (PetscBool) !*end;
}

/* Could a number have had a unit of the laboratory? */
static PetscBool HasScale(Dimension dimension, PetscReal value) {
  return (PetscBool)(now && value != 0 && dimension != UNIT_NONE && dimension < UNIT_ANGLE &&
                     now->scale[dimension] > 0);
}

/* Keeps a number that was given without a unit, though the laboratory's are known: in which it was
   meant the user may have forgotten. */
static void KeepPlain(const OptionRow *row, const char *given, PetscReal value) {
  size_t i = 0;

  if (!HasNoUnit(given) || !HasScale(row->dimension, value) || OptionSaid(row->name) ||
      row->flags & (PETSCS | PART))
    return;
  while (i < now->n_plain && now->plain[i].row != row) i++;
  if (i == MOST_BARE) return;
  if (i == now->n_plain) now->n_plain++;
  now->plain[i].row = row;
  now->plain[i].value = value;
}

/* OptionsReadLines - from here on the lines of a file are read: quantities in them, and in files
   that they name, that have no unit are kept for OptionsTellPlain(). OptionsAtLine() says in which
   it is, from 1 on, and with 0 that it is in none.

   option, file   which file that is */
void OptionsReadLines(const char *option, const char *file) {
  if (!now) return;
  now->lines.at = now->lines.line = 0;
  now->lines.more = 0;
  (void)snprintf(now->lines.file, sizeof(now->lines.file), "%s %s", option, file);
}

void OptionsAtLine(int line) {
  if (now) now->lines.at = line;
}

/* OptionsKeepPlain - keeps a number without a unit of the line that is read. */
void OptionsKeepPlain(Dimension dimension, PetscReal value) {
  if (!HasScale(dimension, value) || !now->lines.at) return;
  if (now->lines.line) {
    now->lines.more++;
    return;
  }
  now->lines.line = now->lines.at;
  OptionBoth(value, dimension, now->lines.first);
}

/* OptionsTellPlain - says which numbers were taken as dimensionless in a scene of the laboratory,
   and what they are there: in one line those of options, in another those of the lines of a file.
   Collective. */
PetscErrorCode OptionsTellPlain(void) {
  char text[64];

  PetscFunctionBegin;
  for (size_t i = 0; now && i < now->n_plain; i++)
    PetscCall(
        PetscPrintf(now->comm, "%s%s %s%s",
                    i ? ", " : "without a unit, and so dimensionless: ", now->plain[i].row->name,
                    OptionBoth(now->plain[i].value, now->plain[i].row->dimension, text),
                    i + 1 < now->n_plain ? "" : "\n"));
  if (!now || !now->lines.line) PetscFunctionReturn(0);
  (void)snprintf(text, sizeof(text), now->lines.more ? ", and %ld more" : "",
                 (long)now->lines.more);
  PetscCall(PetscPrintf(now->comm, "%s: without a unit, and so dimensionless: %s of line %d%s\n",
                        now->lines.file, now->lines.first, now->lines.line, text));
  PetscFunctionReturn(0);
}

/*
  OptionReal - reads a real option and checks its range. Collective on OptionsComm().

  name   of a row of the table
  value  the value given, else the row's default, else, if that is none, as it was
  set    whether it was given (may be NULL)

  A malformed or out-of-range value is a user's mistake (TENDRIL_ERR_USER), here as below.
*/
PetscErrorCode OptionReal(const char *name, PetscReal *value, PetscBool *set) {
  char given[PETSC_MAX_PATH_LEN], text[40];
  const OptionRow *row;
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(Given(name, KIND_REAL, &row, given, &found));
  if (found) {
    PetscCall(ParseReal(row, given, value));
    PetscCall(CheckRange(row, given, *value));
    KeepPlain(row, given, *value);
  } else if (row->usual[0])
    *value = strtod(row->usual, NULL);
  if (found || row->usual[0]) {
    (void)snprintf(text, sizeof(text), "%.17g", (double)*value);
    PetscCall(Keep(row, text));
  }
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* OptionInt - reads an integer option and checks its range; as OptionReal(). */
PetscErrorCode OptionInt(const char *name, PetscInt *value, PetscBool *set) {
  char given[PETSC_MAX_PATH_LEN], text[40];
  const OptionRow *row;
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(Given(name, KIND_INT, &row, given, &found));
  if (found) {
    PetscCall(ParseInt(row, given, value));
    PetscCall(CheckRange(row, given, (PetscReal)*value));
  } else if (row->usual[0])
    *value = (PetscInt)strtol(row->usual, NULL, 10);
  if (found || row->usual[0]) {
    (void)snprintf(text, sizeof(text), "%ld", (long)*value);
    PetscCall(Keep(row, text));
  }
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* OptionBool - reads a switch; a bare option means true. */
PetscErrorCode OptionBool(const char *name, PetscBool *value, PetscBool *set) {
  char given[PETSC_MAX_PATH_LEN];
  const OptionRow *row;
  PetscBool found, yes, no;

  PetscFunctionBegin;
  PetscCall(Given(name, KIND_BOOL, &row, given, &found));
  *value = (PetscBool)(found || !strcmp(row->usual, "true"));
  if (found && given[0]) {
    PetscCall(PetscStrInList(given, "1,true,yes,on,TRUE,True,YES,ON", ',', &yes));
    PetscCall(PetscStrInList(given, "0,false,no,off,FALSE,False,NO,OFF", ',', &no));
    UserCheck(yes || no, OptionsComm(), "%s %s: give true or false", name, given);
    *value = yes;
  }
  PetscCall(Keep(row, *value ? "true" : "false"));
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* The place of a word in a list "one,of,these", or -1. */
static PetscInt Place(const char *words, const char *word) {
  size_t n = strlen(word);
  for (PetscInt i = 0; n && words; i++) {
    if (!strncmp(words, word, n) && (!words[n] || words[n] == ',')) return i;
    words = strchr(words, ',');
    if (words) words++;
  }
  return -1;
}

/* OptionWord - reads one of a row's words; choice is its place among them. */
PetscErrorCode OptionWord(const char *name, PetscInt *choice, PetscBool *set) {
  char given[PETSC_MAX_PATH_LEN] = "";
  const OptionRow *row;
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(Given(name, KIND_WORD, &row, given, &found));
  *choice = Place(row->words, found ? given : row->usual);
  UserCheck(*choice >= 0, OptionsComm(), "%s %s: unknown, give one of %s", name, given, row->words);
  PetscCall(Keep(row, found ? given : row->usual));
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* OptionText - reads a text, a file name as a rule; value keeps what it was if not given. */
PetscErrorCode OptionText(const char *name, char value[PETSC_MAX_PATH_LEN], PetscBool *set) {
  struct stat status;
  const OptionRow *row;
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(Given(name, KIND_TEXT, &row, value, &found));
  UserCheck(!found || value[0], OptionsComm(), "%s: give a value", name);
  UserCheck(!found || !(row->flags & INPUT_FILE) || stat(value, &status) ||
                S_ISREG(status.st_mode) || S_ISDIR(status.st_mode),
            OptionsComm(), "%s %s: is a pipe or a device; give a file", name, value);
  if (found) PetscCall(Keep(row, value));
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* OptionPut - gives an option another value, also for the record; "": none. */
PetscErrorCode OptionPut(const char *name, const char *value) {
  const OptionRow *row = OptionFind(name);
  char text[PETSC_MAX_PATH_LEN];
  PetscReal real;

  PetscFunctionBegin;
  if (value[0])
    PetscCall(PetscOptionsSetValue(NULL, name, value));
  else
    PetscCall(PetscOptionsClearValue(NULL, name));
  if (row && row->kind == KIND_REAL)
    PetscCall(OptionReal(name, &real, NULL));
  else if (row && row->kind == KIND_TEXT && value[0])
    PetscCall(OptionText(name, text, NULL));
  PetscFunctionReturn(0);
}

/* OptionQuantity - the number in a part of an option's text, with its unit if it has one. */
PetscErrorCode OptionQuantity(const char *option, const char *text, Dimension dimension,
                              PetscReal *value) {
  const OptionRow row = {.name = option, .dimension = dimension};

  PetscFunctionBegin;
  PetscCall(ParseReal(&row, text, value));
  if (HasNoUnit(text)) OptionsKeepPlain(dimension, *value);
  PetscFunctionReturn(0);
}

/* OptionSaid - what was given for an option before OptionTakeOffUnit(); NULL: no unit was. */
const char *OptionSaid(const char *name) {
  for (size_t i = 0; now && i < now->n_bare; i++)
    if (!strcmp(now->bare[i].name, name)) return now->bare[i].said;
  return NULL;
}

/* OptionTakeOffUnit - puts a number into the database for a value that carries a unit: PETSc, which
   reads the option too, knows none. */
PetscErrorCode OptionTakeOffUnit(const OptionRow *row) {
  char given[PETSC_MAX_PATH_LEN], text[40], *end;
  PetscReal value;
  PetscBool found;

  PetscFunctionBegin;
  if (!row->dimension) PetscFunctionReturn(0);
  PetscCall(PetscOptionsGetString(NULL, NULL, row->name, given, sizeof(given), &found));
  if (!found) PetscFunctionReturn(0);
  (void)strtod(given, &end);
  if (end == given || !*end) PetscFunctionReturn(0);
  PetscCall(ParseReal(row, given, &value));
  PetscCall(CheckRange(row, given, value));
  (void)snprintf(text, sizeof(text), "%.17g", (double)value);
  PetscCall(PetscOptionsSetValue(NULL, row->name, text));
  if (!now || now->n_bare == MOST_BARE || strlen(given) > LONGEST_BARE) PetscFunctionReturn(0);
  now->bare[now->n_bare].name = row->name;
  PetscCall(PetscStrallocpy(given, &now->bare[now->n_bare++].said));
  PetscFunctionReturn(0);
}

/* OptionCheck - checks what was given to an option that PETSc reads: its message for a malformed
   number does not name the option. */
PetscErrorCode OptionCheck(const OptionRow *row) {
  char given[PETSC_MAX_PATH_LEN];
  PetscReal real;
  PetscInt integer;
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, NULL, row->name, given, sizeof(given), &found));
  if (found && row->kind == KIND_REAL) {
    PetscCall(ParseReal(row, given, &real));
    PetscCall(CheckRange(row, given, real));
  } else if (found && row->kind == KIND_INT) {
    PetscCall(ParseInt(row, given, &integer));
    PetscCall(CheckRange(row, given, (PetscReal)integer));
  } else if (found && row->kind == KIND_WORD)
    UserCheck(Place(row->words, given) >= 0, OptionsComm(), "%s %s: unknown, give one of %s",
              row->name, given, row->words);
  if (found || row->usual[0]) PetscCall(Keep(row, found ? given : row->usual));
  PetscFunctionReturn(0);
}

/* OptionGiven - was the option given (or set by another)? */
PetscErrorCode OptionGiven(const char *name, PetscBool *given) {
  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, NULL, name, given));
  PetscFunctionReturn(0);
}

/* OptionDefault - gives an option a value, printf's way, unless it was given. */
PetscErrorCode OptionDefault(const char *name, const char *format, ...) {
  char text[64];
  PetscBool given;
  va_list list;

  PetscFunctionBegin;
  PetscCall(OptionGiven(name, &given));
  if (given) PetscFunctionReturn(0);
  va_start(list, format);
  (void)vsnprintf(text, sizeof(text), format, list);
  va_end(list);
  PetscCall(PetscOptionsSetValue(NULL, name, text));
  PetscFunctionReturn(0);
}
