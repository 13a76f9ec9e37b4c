#include "base/options.h"
#include <ctype.h>
#include <errno.h>
#include <petscts.h>
#include <stdlib.h>
#include <sys/stat.h>

enum { MAX_OPTIONS = 128 };
static char known[MAX_OPTIONS][48];
static int n_known;

/* Every option of tendril, for the nearest name to a mistyped one, and to tell a mistyped option
   from one that this run has no use for. */
static const char *const names[] = {"-task",
                                    "-output",
                                    "-output_interval",
                                    "-quiet",
                                    "-accuracy",
                                    "-restart",
                                    "-growth_type",
                                    "-growth_initial_length",
                                    "-growth_width",
                                    "-growth_table",
                                    "-friction_mu",
                                    "-friction_beta",
                                    "-friction_newton",
                                    "-clamp_angle",
                                    "-shape_type",
                                    "-shape_amplitude",
                                    "-shape_seed",
                                    "-shape_file",
                                    "-rod_model",
                                    "-rod_cells",
                                    "-rod_order",
                                    "-rod_grading",
                                    "-rod_curvature",
                                    "-rod_curvature_file",
                                    "-rod_curvature_random",
                                    "-rod_curvature_length",
                                    "-rod_curvature_seed",
                                    "-stop_self_contact",
                                    "-stop_length",
                                    "-stop_angle",
                                    "-si_bending_stiffness",
                                    "-si_friction_dry",
                                    "-si_friction_viscous",
                                    "-si_speed",
                                    "-stability_start",
                                    "-stability_end",
                                    "-stability_points",
                                    "-stability_vertices",
                                    "-stability_norm"};

/* PETSc's own options that users set: numbers are checked here, because PETSc's message for a
   malformed one does not name the option. */
static const char *const petsc_reals[] = {"-ts_max_time",  "-ts_rtol",         "-ts_dt",
                                          "-ts_init_time", "-ts_adapt_dt_max", "-ts_adapt_dt_min",
                                          "-snes_atol",    "-snes_rtol",       "-snes_stol",
                                          "-ksp_rtol",     "-eps_tol"};
static const char *const petsc_ints[] = {
    "-ts_bdf_order",  "-ts_max_steps", "-snes_max_it", "-ts_max_snes_failures",
    "-ts_max_reject", "-ksp_max_it",   "-eps_nev",     "-eps_ncv",
    "-eps_max_it"};
static const char *const petsc_names[] = {"-ts_type",
                                          "-ts_adapt_type",
                                          "-snes_type",
                                          "-ksp_type",
                                          "-pc_type",
                                          "-log_view",
                                          "-options_file",
                                          "-options_left",
                                          "-help",
                                          "-eps_type",
                                          "-ts_view",
                                          "-st_type",
                                          "-snes_monitor",
                                          "-ts_monitor",
                                          "-malloc_dump",
                                          "-pc_factor_mat_solver_type",
                                          "-snes_converged_reason",
                                          "-snes_linesearch_type"};

/* Until the options are read and the solvers set up, any error of PETSc is about an option. */
static PetscBool reading = PETSC_TRUE;

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

/* OptionNumber - a number as a person writes it (PETSc's %g adds a point to whole ones). */
const char *OptionNumber(PetscReal value, char text[32]) {
  (void)snprintf(text, 32, "%.10g", (double)value);
  return text;
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
  char given[128], dflt[32], bound[32];
  PetscBool found;

  PetscFunctionBegin;
  OptionNumber(*value, dflt);
  PetscCall(Help(name, "real", dflt, text));
  PetscCall(Given(name, given, sizeof(given), &found));
  if (found) {
    PetscCall(ParseReal(name, given, value));
    OptionNumber(low, bound);
    UserCheck(*value >= low, PETSC_COMM_WORLD, "%s %s: too small, give at least %s", name, given,
              bound);
    OptionNumber(high, bound);
    UserCheck(*value <= high, PETSC_COMM_WORLD, "%s %s: too large, give at most %s", name, given,
              bound);
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

/* Refuses a type that PETSc does not know. */
static PetscErrorCode CheckType(const char *option, PetscFunctionList list) {
  char given[64];
  PetscBool found;
  void (*create)(void) = NULL;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, NULL, option, given, sizeof(given), &found));
  if (!found) PetscFunctionReturn(0);
  PetscCall(PetscFunctionListFind(list, given, &create));
  UserCheck(create, PETSC_COMM_WORLD, "%s %s: PETSc has no such type", option, given);
  PetscFunctionReturn(0);
}

/* Refuses a word that is not in a list. */
static PetscErrorCode CheckWord(const char *option, size_t n, const char *const list[],
                                const char *fault) {
  char given[64];
  PetscBool found, good = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, NULL, option, given, sizeof(given), &found));
  for (size_t i = 0; found && i < n && !good; i++) PetscCall(PetscStrcmp(given, list[i], &good));
  UserCheck(!found || good, PETSC_COMM_WORLD, "%s %s: %s", option, given, fault);
  PetscFunctionReturn(0);
}

/*
  OptionsCheckTypes - refuses unknown solver types, and time steppers that are wrong for the rod:
  those that take F for U_t + G(t, U) or start from an explicit stage. Call when the time steppers
  are known.
*/
PetscErrorCode OptionsCheckTypes(void) {
  const char *const steppers[] = {"vbdf", "bdf", "beuler", "theta", "cn"};
  const char *const adapts[] = {"none", "basic", "dsp", "cfl", "glee", "history"};

  PetscFunctionBegin;
  PetscCall(TSInitializePackage());
  PetscCall(SNESInitializePackage());
  PetscCall(KSPInitializePackage());
  PetscCall(PCInitializePackage());
  PetscCall(CheckType("-ts_type", TSList));
  PetscCall(CheckWord("-ts_adapt_type", PETSC_STATIC_ARRAY_LENGTH(adapts), adapts,
                      "PETSc has no such type"));
  PetscCall(CheckType("-snes_type", SNESList));
  PetscCall(CheckType("-snes_linesearch_type", SNESLineSearchList));
  PetscCall(CheckType("-ksp_type", KSPList));
  PetscCall(CheckType("-pc_type", PCList));
  PetscCall(CheckWord(
      "-ts_type", PETSC_STATIC_ARRAY_LENGTH(steppers), steppers,
      "wrong for friction that is nonlinear in the velocity; give vbdf, bdf, beuler, theta or cn"));
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

static void NearestOf(const char *name, size_t n, const char *const list[], const char **best,
                      int *distance) {
  for (size_t i = 0; i < n; i++) Nearest(name, list[i], best, distance);
}

/* One option that nothing has read. */
static PetscErrorCode RefuseUnread(const char *name) {
  const char *best = NULL;
  int distance = 1 + (int)strlen(name) / 3; /* further off is no likeness */

  PetscFunctionBegin;
  for (int i = 0; i < n_known; i++) Nearest(name, known[i], &best, &distance);
  NearestOf(name, PETSC_STATIC_ARRAY_LENGTH(names), names, &best, &distance);
  NearestOf(name, PETSC_STATIC_ARRAY_LENGTH(petsc_reals), petsc_reals, &best, &distance);
  NearestOf(name, PETSC_STATIC_ARRAY_LENGTH(petsc_ints), petsc_ints, &best, &distance);
  NearestOf(name, PETSC_STATIC_ARRAY_LENGTH(petsc_names), petsc_names, &best, &distance);
  UserCheck(!best || distance, PETSC_COMM_WORLD,
            "%s: nothing in this run reads it; take it out, or choose the type it belongs to",
            name);
  UserCheck(!best, PETSC_COMM_WORLD, "%s: unknown option, did you mean %s?", name, best);
  UserCheck(PETSC_FALSE, PETSC_COMM_WORLD, "%s: unknown option; -help lists them", name);
  PetscFunctionReturn(0);
}

static PetscBool OnCommandLine(const char *name) {
  PetscBool same = PETSC_FALSE;
  int argc = 0;
  char **argv = NULL;

  (void)PetscGetArgs(&argc, &argv);
  for (int i = 1; i < argc && !same; i++) (void)PetscStrcmp(argv[i], name, &same);
  return same;
}

/*
  OptionsRefuseUnread - refuses the run if an option was given that nothing has read (in an options
  file that is fine if the command line asks for a task of its own); with -help,
  ends it in good order.
  Call after everything has read its options and before any work. Collective.
*/
PetscErrorCode OptionsRefuseUnread(void) {
  /* read by PETSc only at its end or deep in a solve */
  const char *late[] = {"options_left", "malloc_dump",  "malloc_view",
                        "log_view",     "options_file", "memory_view"};
  PetscInt n;
  char **unread, **values;
  PetscBool help, other = OnCommandLine("-task"); /* than that of an options file */

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasHelp(NULL, &help));
  if (help) { /* all has been listed: that was what was asked for */
    PetscCall(PetscFinalize());
    MPI_Finalize();
    exit(0);
  }
  PetscCall(PetscOptionsLeftGet(NULL, &n, &unread, &values));
  for (PetscInt i = 0; i < n; i++) {
    PetscBool fine;
    char full[80];
    PetscCall(PetscStrncmp(unread[i], "mat_", 4, &fine));
    for (size_t j = 0; j < PETSC_STATIC_ARRAY_LENGTH(late) && !fine; j++)
      PetscCall(PetscStrcmp(unread[i], late[j], &fine));
    PetscCall(PetscSNPrintf(full, sizeof(full), "-%s", unread[i]));
    if (!fine && other) fine = (PetscBool)!OnCommandLine(full);
    if (!fine) PetscCall(RefuseUnread(full));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &unread, &values));
  reading = PETSC_FALSE;
  PetscFunctionReturn(0);
}

/*
  OptionsRefuseBareWords - refuses words on the command line that belong to no option (a forgotten
  dash), and names with two dashes: PETSc ignores both silently. A word after an option is its
  value.
*/
PetscErrorCode OptionsRefuseBareWords(int argc, char **argv) {
  PetscFunctionBegin;
  for (int i = 1; i < argc; i++) {
    PetscBool is_option = (PetscBool)(argv[i][0] == '-' && isalpha((unsigned char)argv[i][1]));
    PetscBool is_number =
        (PetscBool)(argv[i][0] == '-' && (isdigit((unsigned char)argv[i][1]) || argv[i][1] == '.'));
    PetscBool after =
        (PetscBool)(i > 1 && argv[i - 1][0] == '-' && isalpha((unsigned char)argv[i - 1][1]));
    UserCheck(strncmp(argv[i], "--", 2), PETSC_COMM_WORLD, "%s: options have one dash, %s", argv[i],
              argv[i] + 1);
    UserCheck(is_option || after || (is_number && after), PETSC_COMM_WORLD,
              "%s: a word without an option; did you mean -%s?", argv[i], argv[i]);
  }
  PetscFunctionReturn(0);
}

/* OptionsRefuseOverwrite - refuses an output file that is also an input. */
PetscErrorCode OptionsRefuseOverwrite(const char *output) {
  const char *const inputs[] = {"-growth_table", "-shape_file", "-rod_curvature_file",
                                "-options_file"};
  char file[PETSC_MAX_PATH_LEN];
  struct stat to, from;
  PetscBool found;

  PetscFunctionBegin;
  if (!output[0] || stat(output, &to)) PetscFunctionReturn(0);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(inputs); i++) {
    PetscCall(PetscOptionsGetString(NULL, NULL, inputs[i], file, sizeof(file), &found));
    if (!found || stat(file, &from)) continue;
    UserCheck(to.st_dev != from.st_dev || to.st_ino != from.st_ino, PETSC_COMM_WORLD,
              "-output %s: would overwrite the file that %s gives; name another", output,
              inputs[i]);
  }
  PetscFunctionReturn(0);
}

/* Why a file of options cannot be one, or NULL. */
static const char *FileFault(const char *file, int *line) {
  static char fault_text[128];
  char text[4096];
  struct stat status;
  const char *fault = NULL;
  FILE *f;

  if (stat(file, &status)) return "is not there";
  if (S_ISDIR(status.st_mode)) return "is a directory";
  f = fopen(file, "r");
  if (!f) return "cannot be read";
  for (*line = 1; !fault && fgets(text, sizeof(text), f); ++*line) {
    const char *word = text + strspn(text, " \t\r\n");
    for (const char *c = text; *c; c++)
      if (!isprint((unsigned char)*c) && !isspace((unsigned char)*c) && !((unsigned char)*c & 0x80))
        fault = "is not a text file";
    if (!fault && *word && !strchr("#!%", *word) && *word != '-') {
      (void)snprintf(fault_text, sizeof(fault_text), "begin the line with - or #: %.60s", word);
      fault_text[strcspn(fault_text, "\r\n")] = 0;
      fault = fault_text;
    }
  }
  fclose(f);
  return fault;
}

/*
  OptionsCheckFiles - checks the files of -options_file before PETSC reads them, which it does too
  early for a plain message. Before PetscInitialize(), after MPI_Init(); returns 0 if all is well.
*/
int OptionsCheckFiles(int argc, char **argv) {
  int rank, line = 0;

  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (int i = 1; i < argc; i++) {
    const char *fault;
    if (strcmp(argv[i], "-options_file")) continue;
    if (i + 1 == argc || (argv[i + 1][0] == '-' && isalpha((unsigned char)argv[i + 1][1]))) {
      if (!rank) fprintf(stderr, "tendril: -options_file: give the name of a file\n");
      return 1;
    }
    fault = FileFault(argv[i + 1], &line);
    if (!fault) continue;
    if (!rank && line)
      fprintf(stderr, "tendril: -options_file %s: %s (line %d)\n", argv[i + 1], fault, line - 1);
    else if (!rank)
      fprintf(stderr, "tendril: -options_file %s: %s\n", argv[i + 1], fault);
    return 1;
  }
  return 0;
}

/* UserErrorHandler - one line for a user's mistake, PETSc's traceback for everything else. */
PetscErrorCode UserErrorHandler(MPI_Comm comm, int line, const char *func, const char *file,
                                PetscErrorCode n, PetscErrorType p, const char *mess, void *ctx) {
  static PetscBool said = PETSC_FALSE;
  int rank = 0;

  if (n == TENDRIL_ERR_USER || reading || said) {
    if (p != PETSC_ERROR_INITIAL || said) return n;
    if (comm != PETSC_COMM_SELF) MPI_Comm_rank(comm, &rank);
    if (!rank)
      fprintf(stderr,
              n == TENDRIL_ERR_USER ? "tendril: %s\n"
                                    : "tendril: an option is not as PETSc needs it: %s\n",
              mess ? mess : "");
    said = PETSC_TRUE;
    return n;
  }
  return PetscTraceBackErrorHandler(comm, line, func, file, n, p, mess, ctx);
}
