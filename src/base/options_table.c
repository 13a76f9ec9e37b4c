/* The table of options, put together from the groups that the modules declare. */
#include "base/options.h"

static size_t n_groups;
static const OptionGroup *const *groups;

/* OptionsSetTable - the table of this program: n groups, in the order of -help; all of it constant.
   Not collective; before MPI_Init() if need be. */
void OptionsSetTable(size_t n, const OptionGroup *const table[]) {
  n_groups = n;
  groups = table;
}

/* OptionNext - the rows one by one: place begins with 0; NULL behind the last. */
const OptionRow *OptionNext(size_t *place) {
  size_t k = (*place)++;
  for (size_t g = 0; g < n_groups; g++) {
    if (k < groups[g]->n) return &groups[g]->rows[k];
    k -= groups[g]->n;
  }
  return NULL;
}

/* OptionFind - the row of a name (with its dash), or NULL. */
const OptionRow *OptionFind(const char *name) {
  const OptionRow *row;
  size_t place = 0;
  while ((row = OptionNext(&place)))
    if (!strcmp(row->name, name)) break;
  return row;
}

/* OptionOfRod - may each of several rods have this option for itself? */
PetscBool OptionOfRod(const char *name) {
  for (size_t g = 0; g < n_groups; g++)
    for (size_t k = 0; k < groups[g]->n && groups[g]->of_rod; k++)
      if (!strcmp(groups[g]->rows[k].name, name))
        return (PetscBool) !(groups[g]->rows[k].flags & (SHARED | OF_SCENE));
  return PETSC_FALSE;
}

static const char *Kind(const OptionRow *row) {
  switch (row->kind) {
  case KIND_REAL:
    return "real";
  case KIND_INT:
    return "int";
  case KIND_BOOL:
    return "bool";
  case KIND_WORD:
    return row->words;
  default:
    return row->flags & (INPUT_FILE | OUTPUT_FILE) ? "file" : "text";
  }
}

/* OptionsHelp - the reference manual: all rows. */
void OptionsHelp(FILE *file) {
  for (size_t g = 0; g < n_groups; g++) {
    fprintf(file, "%s\n", groups[g]->title);
    for (size_t k = 0; k < groups[g]->n; k++) {
      const OptionRow *row = &groups[g]->rows[k];
      const char *usual = row->usual[0] ? row->usual : "none";
      fprintf(file, "  %-28s <%s, default %s>: %s\n", row->name, Kind(row), usual, row->text);
    }
  }
}

/* Levenshtein's distance between two names of fewer than 64 characters. */
static int Distance(const char *a, const char *b) {
  int row[64], na = (int)strlen(a), nb = (int)strlen(b);

  if (na > 62 || nb > 62) return 99;
  for (int j = 0; j <= nb; j++) row[j] = j;
  for (int i = 1; i <= na; i++) {
    int diagonal = row[0];
    row[0] = i;
    for (int j = 1; j <= nb; j++) {
      int up = row[j], best = diagonal + (a[i - 1] != b[j - 1]);
      best = PetscMin(best, PetscMin(up, row[j - 1]) + 1);
      row[j] = best;
      diagonal = up;
    }
  }
  return row[nb];
}

/* The one name of the table that has these n letters as words at its end, else at its beginning;
   NULL if none or several have. */
static const char *Holding(const char *words, size_t n) {
  const char *ends = NULL, *begins = NULL;
  int ending = 0, beginning = 0;
  const OptionRow *row;
  size_t place = 0;

  while ((row = OptionNext(&place))) {
    const char *name = row->name + 1;
    size_t all = strlen(name);
    if (all <= n) continue;
    if (name[all - n - 1] == '_' && !strncmp(name + all - n, words, n)) ends = row->name, ending++;
    if (name[n] == '_' && !strncmp(name, words, n)) begins = row->name, beginning++;
  }
  if (ending) return ending == 1 ? ends : NULL;
  return beginning == 1 ? begins : NULL;
}

/* The name that a part of one stands for: "-mu" for -friction_mu, "-walls" for -wall_file. */
static const char *OfPart(const char *name) {
  size_t n = strlen(name);
  const char *whole;

  if (n < 3 || name[0] != '-') return NULL;
  whole = Holding(name + 1, n - 1);
  if (!whole && name[n - 1] == 's') whole = Holding(name + 1, n - 2);
  return whole;
}

/* OptionNearest - the name in the table that a mistyped one is most like, itself if it is there,
   or the only one that it is a part of; NULL if none is near. */
const char *OptionNearest(const char *name) {
  int distance = 1 + (int)strlen(name) / 3; /* further off is no likeness */
  const char *best = NULL;
  const OptionRow *row;
  size_t place = 0;

  while ((row = OptionNext(&place))) {
    int d = Distance(name, row->name);
    if (d >= distance) continue;
    distance = d;
    best = row->name;
  }
  return best ? best : OfPart(name);
}
