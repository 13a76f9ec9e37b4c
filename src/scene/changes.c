#include "scene/changes.h"
#include "base/hdf.h"
#include "base/text.h"
#include <ctype.h>

static const char *const option = "-change_file";

/* A row in the place k; those from there on move up. */
static PetscErrorCode Insert(Changes self, PetscInt k, PetscReal t, const char *what,
                             const char *value) {
  ChangeRow row = {.t = t};

  PetscFunctionBegin;
  if (self->n == self->room) {
    self->room = 2 * self->room + 16;
    PetscCall(PetscRealloc((size_t)self->room * sizeof(row), &self->row));
  }
  PetscCall(PetscStrallocpy(what, &row.what));
  PetscCall(PetscStrallocpy(value, &row.value));
  memmove(&self->row[k + 1], &self->row[k], (size_t)(self->n - k) * sizeof(row));
  self->row[k] = row;
  self->n++;
  PetscFunctionReturn(0);
}

static PetscErrorCode Drop(Changes self, PetscInt k) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->row[k].what));
  PetscCall(PetscFree(self->row[k].value));
  self->n--;
  memmove(&self->row[k], &self->row[k + 1], (size_t)(self->n - k) * sizeof(self->row[k]));
  PetscFunctionReturn(0);
}

/* The next word of a line, which is cut off behind it. */
static char *Word(char **line) {
  char *word;

  while (isspace((unsigned char)**line)) (*line)++;
  word = *line;
  while (**line && !isspace((unsigned char)**line)) (*line)++;
  if (**line) *(*line)++ = 0;
  return word;
}

/* What stands behind a line's words, without blanks around it. */
static char *Rest(char *line) {
  size_t n;

  while (isspace((unsigned char)*line)) line++;
  for (n = strlen(line); n && isspace((unsigned char)line[n - 1]); n--) line[n - 1] = 0;
  return line;
}

/* T WHAT VALUE, on a line of which a comment has been cut off. */
static PetscErrorCode Line(const char *where, char *line, Changes self) {
  char *time = Word(&line), *what = Word(&line), *value = Rest(line);
  PetscReal t;

  PetscFunctionBegin;
  if (!time[0]) PetscFunctionReturn(0);
  UserCheck(value[0], OptionsComm(),
            "%s: give a time, what changes then, and its new value, as in 2.5 tip_force 0.2",
            where);
  PetscCall(OptionQuantity(where, time, UNIT_TIME, &t));
  while (*what == '-') what++;
  UserCheck(t >= 0, OptionsComm(), "%s: t must be 0 or more", where);
  UserCheck(!self->n || t >= self->row[self->n - 1].t, OptionsComm(),
            "%s: t must not decrease from line to line", where);
  PetscCall(Insert(self, self->n, t, what, value));
  PetscFunctionReturn(0);
}

/* All lines of a text, which is taken apart. */
static PetscErrorCode Lines(const char *file, char *text, Changes self) {
  char where[PETSC_MAX_PATH_LEN + 64], *next;

  PetscFunctionBegin;
  for (int k = 1; text; text = next, k++) {
    next = strchr(text, '\n');
    if (next) *next++ = 0;
    text[strcspn(text, "#")] = 0;
    (void)snprintf(where, sizeof(where), "%s %s, line %d", option, file, k);
    OptionsAtLine(k);
    PetscCall(Line(where, text, self));
  }
  PetscFunctionReturn(0);
}

/* ChangesRead - the rows of -change_file; NULL if it is not given. Collective on OptionsComm(); the
   caller ends it with ChangesDestroy(), also after an error. */
PetscErrorCode ChangesRead(Changes *changes) {
  char file[PETSC_MAX_PATH_LEN] = "", *text;
  PetscErrorCode error;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(OptionText(option, file, &given));
  if (!given) PetscFunctionReturn(0);
  PetscCall(PetscNew(changes));
  PetscCall(TextRead(option, file, &text));
  OptionsReadLines(option, file);
  error = Lines(file, text, *changes);
  OptionsAtLine(0);
  PetscCall(PetscFree(text));
  PetscCall(error);
  UserCheck((*changes)->n, OptionsComm(), "%s %s: there is no change in it", option, file);
  PetscFunctionReturn(0);
}

/* ChangesDo - a change from t on that no file has said. */
PetscErrorCode ChangesDo(Changes *changes, PetscReal t, const char *what, const char *value) {
  PetscFunctionBegin;
  if (!*changes) PetscCall(PetscNew(changes));
  while (*what == '-') what++;
  PetscCall(Insert(*changes, (*changes)->done++, t, what, value));
  PetscFunctionReturn(0);
}

/* Takes a row off what is still to be done, if it is there. */
static PetscErrorCode IsDone(Changes self, const ChangeRow *row) {
  PetscFunctionBegin;
  for (PetscInt k = self->done; k < self->n; k++)
    if (self->row[k].t == row->t && !strcmp(self->row[k].what, row->what) &&
        !strcmp(self->row[k].value, row->value)) {
      PetscCall(Drop(self, k));
      break;
    }
  PetscFunctionReturn(0);
}

/* ChangesTake - those that were in force in the run of a result file are so again, first of all.
   Collective on OptionsComm().

   name  that the file has for them */
PetscErrorCode ChangesTake(const char *file, const char *name, Changes *changes) {
  struct _Changes taken = {0};
  PetscErrorCode error;
  PetscBool has;
  char *text;

  PetscFunctionBegin;
  PetscCall(HdfHas(file, name, &has));
  if (!has) PetscFunctionReturn(0);
  PetscCall(HdfReadText("-restart", file, name, &text));
  error = Lines(file, text, &taken);
  OptionsAtLine(0);
  PetscCall(PetscFree(text));
  for (PetscInt k = 0; k < taken.n && !error; k++) {
    const ChangeRow *row = &taken.row[k];
    if (*changes) PetscCall(IsDone(*changes, row));
    PetscCall(ChangesDo(changes, row->t, row->what, row->value));
  }
  while (taken.n) PetscCall(Drop(&taken, taken.n - 1));
  PetscCall(PetscFree(taken.row));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* ChangesNext - when the next one is to be; PETSC_MAX_REAL: there is none. */
PetscReal ChangesNext(Changes self) {
  return self && self->done < self->n ? self->row[self->done].t : PETSC_MAX_REAL;
}

/* ChangesText - those in force, as a file has them. The caller frees the text (PetscFree). */
PetscErrorCode ChangesText(Changes self, char **text) {
  enum { NUMBER = 32 };
  size_t room = 1, at = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->done; k++)
    room += NUMBER + strlen(self->row[k].what) + strlen(self->row[k].value);
  PetscCall(PetscCalloc1(room, text));
  for (PetscInt k = 0; k < self->done; k++)
    at += (size_t)snprintf(*text + at, room - at, "%.17g %s %s\n", (double)self->row[k].t,
                           self->row[k].what, self->row[k].value);
  PetscFunctionReturn(0);
}

PetscErrorCode ChangesDestroy(Changes *changes) {
  PetscFunctionBegin;
  if (!*changes) PetscFunctionReturn(0);
  while ((*changes)->n) PetscCall(Drop(*changes, (*changes)->n - 1));
  PetscCall(PetscFree((*changes)->row));
  PetscCall(PetscFree(*changes));
  PetscFunctionReturn(0);
}
