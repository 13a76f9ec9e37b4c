/* Options files. PETSc reads them, too, but what users need is not in it (seen with 3.18): data
   that a file names count from its own place, a fault is one line with the remedy and not a
   traceback, the files read are known (no output goes over them). It crashes on a file that names
   itself, and takes --name for an option. */
#include "base/words.h"
#include "base/options.h"
#include <ctype.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/stat.h>

static const char *const blanks = " \t\r\n\v\f";
enum { DEEPEST = 16, LONGEST = PETSC_MAX_PATH_LEN - 1, SHOWN = 60 };

/* A file that is being read, and the one that names it. */
typedef struct Source {
  const char *file;
  struct stat status;
  int line, depth;
  char *fault;
  int section; /* its lines are of this one; -1: of none */
  const struct Source *outer;
} Source;

/* WordIsOption - is it a name, not a value as -0.5 is one? */
PetscBool WordIsOption(const char *word) {
  return (PetscBool)(word[0] == '-' && isalpha((unsigned char)word[1]));
}

/* What malloc() gives; without memory for a few words nothing can go on. */
static void *Need(void *memory) {
  if (!memory) abort();
  return memory;
}

/* WordsAdd - adds a copy of a word. Not collective, as all here; before PetscInitialize(). */
void WordsAdd(OptionWords *self, const char *word) {
  if (self->n + 2 > self->room) {
    self->room = 2 * self->room + 32;
    self->word =
        (char **)Need(realloc((void *)self->word, (size_t)self->room * sizeof(*self->word)));
  }
  self->word[self->n++] = (char *)Need(strdup(word));
  self->word[self->n] = NULL;
}

static void FreeSection(OptionSection *self) {
  for (int k = 0; k < self->n; k++) {
    free(self->option[k].name);
    free(self->option[k].value);
  }
  free(self->option);
  free(self->head);
  free(self->file);
}

/* WordsFree - frees them, and what is known of files and sections. */
void WordsFree(OptionWords *self) {
  for (int i = 0; i < self->n; i++) free(self->word[i]);
  for (int k = 0; k < self->sections; k++) FreeSection(&self->section[k]);
  free(self->section);
  free((void *)self->word);
  if (self->files) WordsFree(self->files);
  free(self->files);
  *self = (OptionWords){0};
}

/* SectionDrop - takes the i-th option out of a section. */
void SectionDrop(OptionSection *self, int i) {
  free(self->option[i].name);
  free(self->option[i].value);
  for (self->n--; i < self->n; i++) self->option[i] = self->option[i + 1];
}

/* WordsFile - the name of the k-th options file that was read; NULL: there are no more. */
const char *WordsFile(const OptionWords *self, int k) {
  return self->files && k < self->files->n ? self->files->word[k] : NULL;
}

static PetscBool Fault(const Source *self, const char *format, ...) {
  va_list list;
  int n;

  n = snprintf(self->fault, WORDS_FAULT, "-options_file %s", self->file);
  if (self->line) n += snprintf(self->fault + n, WORDS_FAULT - (size_t)n, ", line %d", self->line);
  n += snprintf(self->fault + n, WORDS_FAULT - (size_t)n, ": ");
  va_start(list, format);
  (void)vsnprintf(self->fault + n, WORDS_FAULT - (size_t)n, format, list);
  va_end(list);
  return PETSC_FALSE;
}

/* Where a file that an options file names is: from that file's own place, as a scene and its data
   are kept together; where there is none, from the directory one is in. */
static void Place(const Source *self, const char *name, char *path, size_t length) {
  const char *slash = strrchr(self->file, '/');
  struct stat status;

  (void)snprintf(path, length, "%s", name);
  if (name[0] == '/' || !slash) return;
  (void)snprintf(path, length, "%.*s/%s", (int)(slash - self->file), self->file, name);
  if (stat(path, &status)) (void)snprintf(path, length, "%s", name);
}

static PetscBool AddFile(OptionWords *words, Source *self);

static void KeepFile(OptionWords *words, const char *file) {
  if (!words->files) words->files = (OptionWords *)Need(calloc(1, sizeof(OptionWords)));
  WordsAdd(words->files, file);
}

/* An option of the section that is being read. */
static void AddToSection(OptionWords *words, const Source *self, const char *name,
                         const char *value) {
  OptionSection *section = &words->section[self->section];

  if (section->n == section->room) {
    section->room = 2 * section->room + 16;
    section->option = (struct SectionOption *)Need(
        realloc(section->option, (size_t)section->room * sizeof(*section->option)));
  }
  section->option[section->n++] =
      (struct SectionOption){.name = (char *)Need(strdup(name)),
                             .value = value ? (char *)Need(strdup(value)) : NULL,
                             .line = self->line};
}

/* The names of a pair, one blank between two: what, also, and the rest of a line that is taken
   apart. */
static void PairNames(const char *what, const char *also, char **rest, char *names, size_t room) {
  size_t n = (size_t)snprintf(names, room, "%s", what);

  for (; also && n < room; also = strtok_r(NULL, blanks, rest))
    n += (size_t)snprintf(names + n, room - n, " %s", also);
}

/* [rod NAME], [rods FILE.csv] or [pair NAME NAME]: the lines that follow are of that. */
static PetscBool AddSection(OptionWords *words, Source *self, char *line) {
  char *end = strchr(line, ']'), *rest, *kind, *what, *also, head[2 * PETSC_MAX_PATH_LEN + 16],
       path[2 * PETSC_MAX_PATH_LEN];
  PetscBool rods, good;

  if (!end || end[1 + strspn(end + 1, blanks)])
    return Fault(self, "a section is a line of its own, in brackets: [rod NAME]");
  *end = 0;
  kind = strtok_r(line + 1, blanks, &rest);
  what = kind ? strtok_r(NULL, blanks, &rest) : NULL;
  also = what ? strtok_r(NULL, blanks, &rest) : NULL;
  rods = (PetscBool)(kind && !strcmp(kind, "rods"));
  good = (PetscBool)(what && !also && (rods || !strcmp(kind, "rod")));
  if (kind && !strcmp(kind, "pair")) {
    good = (PetscBool)(what && (also || strchr(what, ',')));
    if (good) PairNames(what, also, &rest, path, sizeof(path));
    what = path;
  }
  if (!good)
    return Fault(self, "[%.*s]: a section is [rod NAME], [rods FILE.csv] or [pair NAME NAME]",
                 SHOWN, kind ? kind : "");
  if (rods) {
    Place(self, what, path, sizeof(path));
    KeepFile(words, path);
    what = path;
  }
  (void)snprintf(head, sizeof(head), "%s %s", kind, what);
  self->section = words->sections++;
  words->section = (OptionSection *)Need(
      realloc(words->section, (size_t)words->sections * sizeof(*words->section)));
  words->section[self->section] = (OptionSection){.head = (char *)Need(strdup(head)),
                                                  .file = (char *)Need(strdup(self->file)),
                                                  .line = self->line};
  return PETSC_TRUE;
}

/* An option and its value, which may be NULL. */
static PetscBool AddOption(OptionWords *words, const Source *self, const char *name,
                           const char *value) {
  const OptionRow *row = OptionFind(name);
  char path[2 * PETSC_MAX_PATH_LEN];
  Source inner = {
      .file = path, .fault = self->fault, .depth = self->depth + 1, .section = -1, .outer = self};

  if (value && row && row->flags & INPUT_FILE) {
    Place(self, value, path, sizeof(path));
    value = path;
  }
  if (self->section >= 0 && !strcmp(name, "-options_file"))
    return Fault(self, "-options_file: is no option of a rod; name it before the first section");
  if (!strcmp(name, "-options_file"))
    return value ? AddFile(words, &inner) : Fault(self, "-options_file: give the name of a file");
  if (value && strlen(value) > LONGEST)
    return Fault(self, "%.*s: its value has more than %d characters", SHOWN, name, (int)LONGEST);
  if (self->section >= 0)
    AddToSection(words, self, name, value);
  else {
    WordsAdd(words, name);
    if (value) WordsAdd(words, value);
  }
  return PETSC_TRUE;
}

/* What the first word of a line must be. */
static PetscBool CheckName(const Source *self, const char *name) {
  if (WordIsOption(name)) return PETSC_TRUE;
  if (!strncmp(name, "--", 2))
    return Fault(self, "%.*s: options have one dash, %.*s", SHOWN, name, SHOWN, name + 1);
  return Fault(self, "begin the line with an option (-) or a comment (#): %.*s", SHOWN, name);
}

static PetscBool AddLine(OptionWords *words, Source *self, char *line) {
  char *rest, *name, *value, *more;

  line[strcspn(line, "#")] = 0;
  line += strspn(line, blanks);
  if (line[0] == '[') return AddSection(words, self, line);
  name = strtok_r(line, blanks, &rest);
  if (!name || strchr("!%", name[0])) return PETSC_TRUE;
  if (!CheckName(self, name)) return PETSC_FALSE;
  value = strtok_r(NULL, blanks, &rest);
  more = value ? strtok_r(NULL, blanks, &rest) : NULL;
  if (value && WordIsOption(value)) more = value;
  if (more && WordIsOption(more))
    return Fault(self, "two options on a line, %.*s and %.*s: give each a line of its own", SHOWN,
                 name, SHOWN, more);
  if (more)
    return Fault(self,
                 "a blank in the value of %.*s: %.*s %.*s; write it without, or # before a comment",
                 SHOWN, name, SHOWN, value, SHOWN, more);
  return AddOption(words, self, name, value);
}

static PetscBool IsText(const char *line, size_t n) {
  for (size_t i = 0; i < n; i++) {
    unsigned char c = (unsigned char)line[i];
    if (!isprint(c) && !isspace(c) && !(c & 0x80)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Can it be read, and is it not being read already? */
static PetscBool CheckFile(Source *self) {
  if (stat(self->file, &self->status)) return Fault(self, "is not there");
  if (S_ISDIR(self->status.st_mode)) return Fault(self, "is a directory");
  if (!S_ISREG(self->status.st_mode)) return Fault(self, "is a pipe or a device; give a file");
  for (const Source *outer = self->outer; outer; outer = outer->outer)
    if (outer->status.st_dev == self->status.st_dev && outer->status.st_ino == self->status.st_ino)
      return Fault(outer, "names itself%s", outer == self->outer ? "" : ", through another");
  if (self->depth == DEEPEST)
    return Fault(self, "is named by the last of %d options files, each in another", DEEPEST);
  return PETSC_TRUE;
}

static PetscBool AddFile(OptionWords *words, Source *self) {
  PetscBool good;
  size_t room = 0;
  char *line = NULL;
  ssize_t n;
  FILE *f;

  if (!CheckFile(self)) return PETSC_FALSE;
  f = fopen(self->file, "r");
  if (!f) return Fault(self, "cannot be read");
  KeepFile(words, self->file);
  for (good = PETSC_TRUE; good && (n = getline(&line, &room, f)) >= 0;) {
    char *begin = line;
    /* an editor may have put a byte order mark before the first line */
    if (!self->line++ && !strncmp(line, "\xef\xbb\xbf", 3)) begin += 3;
    good = IsText(begin, (size_t)(n - (begin - line))) ? AddLine(words, self, begin)
                                                       : Fault(self, "is not a text file");
  }
  free(line);
  fclose(f);
  return good;
}

/*
  WordsAddFile - adds the options of a file: one a line, with its value; # begins a comment. A file
  that it names (of options, walls, tables) counts from its own directory.

  fault  what is wrong with it, with its line

  Returns whether all is well.
*/
PetscBool WordsAddFile(OptionWords *words, const char *file, char fault[WORDS_FAULT]) {
  Source source = {.file = file, .section = -1, .fault = fault};

  return AddFile(words, &source);
}

/* WordsAddText - adds the options of a text that is in memory, of this file, as WordsAddFile(); the
   text is used up. */
PetscBool WordsAddText(OptionWords *words, const char *file, char *text, char fault[WORDS_FAULT]) {
  Source source = {.file = file, .section = -1, .fault = fault};
  PetscBool good = PETSC_TRUE;

  for (char *line = text, *next; good && line; line = next) {
    next = strchr(line, '\n');
    if (next) *next++ = 0;
    source.line++;
    good = AddLine(words, &source, line);
  }
  return good;
}
