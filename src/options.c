#include "options.h"
#include <ctype.h>
#include <errno.h>
#include <stdlib.h>

enum { MAX_OPTIONS = 128 };
static char known[MAX_OPTIONS][48];
static int n_known;

/* PETSc's own options that scenes and users set often: checked here, because PETSc's message for a
   malformed number does not name the option, and offered when a name is mistyped. */
static const char *const petsc_reals[] = {"-ts_max_time", "-ts_rtol", "-ts_dt", "-ts_init_time"};
static const char *const petsc_ints[] = {"-ts_bdf_order", "-ts_max_steps", "-snes_max_it",
                                         "-ts_max_snes_failures", "-ts_max_reject"};
static const char *const petsc_names[] = {"-ts_type",
                                          "-ts_adapt_type",
                                          "-ts_adapt_dt_max",
                                          "-ts_adapt_dt_min",
                                          "-snes_type",
                                          "-ksp_type",
                                          "-pc_type",
                                          "-log_view",
                                          "-options_file",
                                          "-options_left",
                                          "-help",
                                          "-eps_type",
                                          "-ts_view",
                                          "-snes_monitor",
                                          "-ts_monitor",
                                          "-malloc_dump",
                                          "-eps_tol",
                                          "-eps_nev",
                                          "-st_type",
                                          "-pc_factor_mat_solver_type",
                                          "-snes_converged_reason"};

static PetscErrorCode Remember(const char *name) {
  PetscFunctionBegin;
  for (int i = 0; i < n_known; i++) {
    PetscBool same;
    PetscCall(PetscStrcmp(known[i], name, &same));
    if (same) PetscFunctionReturn(0);
  }
  PetscCheck(n_known < MAX_OPTIONS, PETSC_COMM_SELF, PETSC_ERR_PLIB, "MAX_OPTIONS too small");
  PetscCall(PetscStrncpy(known[n_known++], name, sizeof(known[0])));
  PetscFunctionReturn(0);
}

/* The text given for an option, with surrounding blanks removed; set tells if it was given. */
static PetscErrorCode Given(const char *name, char *text, size_t length, PetscBool *set) {
  PetscFunctionBegin;
  PetscCall(Remember(name));
  PetscCall(PetscOptionsGetString(NULL, NULL, name, text, length, set));
  PetscFunctionReturn(0);
}

static PetscErrorCode Help(const char *name, const char *type, const char *value,
                           const char *text) {
  PetscBool help;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasHelp(NULL, &help));
  if (help)
    PetscCall(
        PetscPrintf(PETSC_COMM_WORLD, "  %-28s <%s, default %s>: %s\n", name, type, value, text));
  PetscFunctionReturn(0);
}

static PetscErrorCode ParseReal(const char *name, const char *text, PetscReal *value) {
  char *end;

  PetscFunctionBegin;
  *value = strtod(text, &end);
  while (isspace((unsigned char)*end)) end++;
  UserCheck(end != text && !*end, PETSC_COMM_WORLD, "%s %s: give a number", name, text);
  UserCheck(!PetscIsInfOrNanReal(*value), PETSC_COMM_WORLD, "%s %s: give a finite number", name,
            text);
  PetscFunctionReturn(0);
}

static PetscErrorCode ParseInt(const char *name, const char *text, PetscInt *value) {
  char *end;
  long v;

  PetscFunctionBegin;
  errno = 0;
  v = strtol(text, &end, 10);
  while (isspace((unsigned char)*end)) end++;
  UserCheck(end != text && !*end, PETSC_COMM_WORLD, "%s %s: give a whole number", name, text);
  UserCheck(!errno && v > -2000000000L && v < 2000000000L, PETSC_COMM_WORLD, "%s %s: too large",
            name, text);
  *value = (PetscInt)v;
  PetscFunctionReturn(0);
}

/*
  OptionReal - reads a real option and checks its range. Collective on PETSC_COMM_WORLD.

  name   the option, with its dash
  text   meaning, unit and range, shown by -help
  low, high   closed range; PETSC_MIN_REAL and PETSC_MAX_REAL where there is none
  value  default on entry, value on exit
  set    whether it was given (may be NULL)

  A malformed or out-of-range value is a user's mistake (TENDRIL_ERR_USER).
*/
PetscErrorCode OptionReal(const char *name, const char *text, PetscReal low, PetscReal high,
                          PetscReal *value, PetscBool *set) {
  char given[128], dflt[32];
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(dflt, sizeof(dflt), "%g", (double)*value));
  PetscCall(Help(name, "real", dflt, text));
  PetscCall(Given(name, given, sizeof(given), &found));
  if (found) {
    PetscCall(ParseReal(name, given, value));
    UserCheck(*value >= low, PETSC_COMM_WORLD, "%s %s: too small, give at least %g", name, given,
              (double)low);
    UserCheck(*value <= high, PETSC_COMM_WORLD, "%s %s: too large, give at most %g", name, given,
              (double)high);
  }
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* OptionInt - reads an integer option and checks its range; as OptionReal. */
PetscErrorCode OptionInt(const char *name, const char *text, PetscInt low, PetscInt high,
                         PetscInt *value, PetscBool *set) {
  char given[128], dflt[32];
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(dflt, sizeof(dflt), "%d", (int)*value));
  PetscCall(Help(name, "int", dflt, text));
  PetscCall(Given(name, given, sizeof(given), &found));
  if (found) {
    PetscCall(ParseInt(name, given, value));
    UserCheck(*value >= low, PETSC_COMM_WORLD, "%s %s: too small, give at least %d", name, given,
              (int)low);
    UserCheck(*value <= high, PETSC_COMM_WORLD, "%s %s: too large, give at most %d", name, given,
              (int)high);
  }
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* OptionBool - reads a switch; a bare option means true. */
PetscErrorCode OptionBool(const char *name, const char *text, PetscBool *value, PetscBool *set) {
  char given[32];
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(Help(name, "bool", *value ? "true" : "false", text));
  PetscCall(Given(name, given, sizeof(given), &found));
  if (found && given[0]) {
    PetscBool yes = PETSC_FALSE, no = PETSC_FALSE;
    const char *words[2][4] = {{"1", "true", "yes", "on"}, {"0", "false", "no", "off"}};
    for (int i = 0; i < 4 && !yes && !no; i++) {
      PetscCall(PetscStrcasecmp(given, words[0][i], &yes));
      if (!yes) PetscCall(PetscStrcasecmp(given, words[1][i], &no));
    }
    UserCheck(yes || no, PETSC_COMM_WORLD, "%s %s: give true or false", name, given);
    *value = yes;
  } else if (found)
    *value = PETSC_TRUE;
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* OptionString - reads a text, a file name as a rule; value keeps its default if not given. */
PetscErrorCode OptionString(const char *name, const char *text, char *value, size_t length,
                            PetscBool *set) {
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(Help(name, "text", value[0] ? value : "none", text));
  PetscCall(Given(name, value, length, &found));
  UserCheck(!found || value[0], PETSC_COMM_WORLD, "%s: give a value", name);
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* OptionList - reads one word of a list; choice is its index. */
PetscErrorCode OptionList(const char *name, const char *text, PetscInt n, const char *const *list,
                          PetscInt *choice, PetscBool *set) {
  char given[64], all[256] = "";
  PetscBool found, same = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(PetscStrlcat(all, i ? ", " : "", sizeof(all)));
    PetscCall(PetscStrlcat(all, list[i], sizeof(all)));
  }
  PetscCall(Help(name, all, list[*choice], text));
  PetscCall(Given(name, given, sizeof(given), &found));
  for (PetscInt i = 0; found && i < n && !same; i++) {
    PetscCall(PetscStrcmp(given, list[i], &same));
    if (same) *choice = i;
  }
  UserCheck(!found || same, PETSC_COMM_WORLD, "%s %s: unknown, give one of %s", name, given, all);
  if (set) *set = found;
  PetscFunctionReturn(0);
}

/* OptionsHeading - a title above a group of options in -help. */
PetscErrorCode OptionsHeading(const char *title) {
  PetscBool help;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasHelp(NULL, &help));
  if (help) PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s\n", title));
  PetscFunctionReturn(0);
}

/* OptionsCheckPetsc - checks the numbers given to those of PETSc's options that are set most. */
PetscErrorCode OptionsCheckPetsc(void) {
  char given[128];
  PetscBool found;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(petsc_reals); i++) {
    PetscReal v;
    PetscCall(PetscOptionsGetString(NULL, NULL, petsc_reals[i], given, sizeof(given), &found));
    if (!found) continue;
    PetscCall(ParseReal(petsc_reals[i], given, &v));
    UserCheck(v > 0 || i == 3, PETSC_COMM_WORLD, "%s %s: give a positive number", petsc_reals[i],
              given);
  }
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(petsc_ints); i++) {
    PetscInt v;
    PetscCall(PetscOptionsGetString(NULL, NULL, petsc_ints[i], given, sizeof(given), &found));
    if (found) PetscCall(ParseInt(petsc_ints[i], given, &v));
    if (found && i == 0)
      UserCheck(v >= 1 && v <= 6, PETSC_COMM_WORLD, "-ts_bdf_order %s: give an order from 1 to 6",
                given);
  }
  PetscFunctionReturn(0);
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

static void Nearest(const char *name, const char *candidate, const char **best, int *distance) {
  int d = Distance(name, candidate);
  if (d < *distance) {
    *distance = d;
    *best = candidate;
  }
}

/*
  OptionsRefuseUnread - refuses the run if an option was given that nothing has read.
  Call after everything has read its options and before any work. Collective.
*/
PetscErrorCode OptionsRefuseUnread(void) {
  PetscInt n;
  char **names, **values;
  /* read by PETSc only at its end, or by nobody because its purpose is to be looked at */
  const char *late[] = {"options_left", "malloc_dump",  "log_view",
                        "malloc_view",  "options_file", "memory_view"};

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt i = 0; i < n; i++) {
    PetscBool fine = PETSC_FALSE;
    char full[80];
    const char *best = NULL;
    int distance = 9;
    for (size_t j = 0; j < PETSC_STATIC_ARRAY_LENGTH(late) && !fine; j++)
      PetscCall(PetscStrcmp(names[i], late[j], &fine));
    if (fine) continue;
    PetscCall(PetscSNPrintf(full, sizeof(full), "-%s", names[i]));
    for (int j = 0; j < n_known; j++) Nearest(full, known[j], &best, &distance);
    for (size_t j = 0; j < PETSC_STATIC_ARRAY_LENGTH(petsc_reals); j++)
      Nearest(full, petsc_reals[j], &best, &distance);
    for (size_t j = 0; j < PETSC_STATIC_ARRAY_LENGTH(petsc_ints); j++)
      Nearest(full, petsc_ints[j], &best, &distance);
    for (size_t j = 0; j < PETSC_STATIC_ARRAY_LENGTH(petsc_names); j++)
      Nearest(full, petsc_names[j], &best, &distance);
    UserCheck(!best || !distance, PETSC_COMM_WORLD, "%s: unknown option, did you mean %s?", full,
              best);
    UserCheck(PETSC_FALSE, PETSC_COMM_WORLD, "%s: nothing in this run reads it; see -help", full);
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(0);
}

/*
  OptionsRefuseBareWords - refuses words on the command line that belong to no option (a forgotten
  dash): PETSc ignores them silently. A word after an option is its value.
*/
PetscErrorCode OptionsRefuseBareWords(int argc, char **argv) {
  PetscFunctionBegin;
  for (int i = 1; i < argc; i++) {
    PetscBool is_option = (PetscBool)(argv[i][0] == '-' && !isdigit((unsigned char)argv[i][1]));
    PetscBool after =
        (PetscBool)(i > 1 && argv[i - 1][0] == '-' && isalpha((unsigned char)argv[i - 1][1]));
    UserCheck(is_option || after, PETSC_COMM_WORLD,
              "%s: a word without an option; did you mean -%s?", argv[i], argv[i]);
  }
  PetscFunctionReturn(0);
}

/* UserErrorHandler - one line for a user's mistake, PETSc's traceback for everything else. */
PetscErrorCode UserErrorHandler(MPI_Comm comm, int line, const char *func, const char *file,
                                PetscErrorCode n, PetscErrorType p, const char *mess, void *ctx) {
  if (n == TENDRIL_ERR_USER) {
    int rank = 0, up;
    if (p != PETSC_ERROR_INITIAL) return n;
    MPI_Initialized(&up);
    if (up && comm != PETSC_COMM_SELF) MPI_Comm_rank(comm, &rank);
    if (!rank) fprintf(stderr, "tendril: %s\n", mess);
    return n;
  }
  return PetscTraceBackErrorHandler(comm, line, func, file, n, p, mess, ctx);
}
