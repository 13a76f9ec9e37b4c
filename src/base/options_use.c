/* What was given, as a whole: what PETSc reads is checked, what nothing reads is refused, all of it
   is listed for the record. */
#include "base/options.h"
#include "base/words.h"
#include <ctype.h>
#include <petscts.h>
#include <sys/stat.h>

/* OptionsCheckPetsc - checks what was given to PETSc's own options as far as the table knows them,
   and makes numbers of what carries a unit. Collective; after the laboratory's scales are set. */
PetscErrorCode OptionsCheckPetsc(void) {
  const OptionRow *row;
  PetscBool given;
  size_t place = 0;

  PetscFunctionBegin;
  PetscCall(OptionsRename(PETSC_FALSE));
  while ((row = OptionNext(&place))) {
    if (row->flags & (PETSCS | SHARED)) PetscCall(OptionTakeOffUnit(row));
    if (row->flags & PETSCS) PetscCall(OptionCheck(row));
  }
  PetscCall(OptionGiven("-ts_init_time", &given));
  UserCheck(
      !given, OptionsComm(),
      "-ts_init_time: a run begins at t = 0; give -growth_initial_length, or -restart FILE to "
      "go on from a result");
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
  UserCheck(create, OptionsComm(), "%s %s: PETSc has no such type", option, given);
  PetscFunctionReturn(0);
}

/* OptionsCheckTypes - refuses unknown solver types. Call when tendril's own are registered.
   Collective. */
PetscErrorCode OptionsCheckTypes(void) {
  PetscFunctionBegin;
  PetscCall(TSInitializePackage());
  PetscCall(SNESInitializePackage());
  PetscCall(KSPInitializePackage());
  PetscCall(PCInitializePackage());
  PetscCall(CheckType("-snes_type", SNESList));
  PetscCall(CheckType("-snes_linesearch_type", SNESLineSearchList));
  PetscCall(CheckType("-ksp_type", KSPList));
  PetscCall(CheckType("-pc_type", PCList));
  PetscFunctionReturn(0);
}

static PetscBool StartsWith(const char *text, const char *with) {
  return (PetscBool)!strncmp(text, with, strlen(with));
}

/* The objects of PETSc that are at work, by the prefixes of their options. */
static const char *const objects[] = {"-ts_",   "-snes_",  "-ksp_", "-pc_", "-mat_",
                                      "-vec_",  "-dm_",    "-eps_", "-st_", "-svd_",
                                      "-norm_", "-chain_", "-sub_", "-da_", "-transient_"};

/* Options that PETSc reads after the run is set up: views, monitors and reasons of its objects, in
   a solve; and some at its very end. */
static PetscBool ReadLate(const char *name) {
  const char *const words[] = {"_view", "_monitor", "_converged_reason", "_error", "_test_"};
  const OptionRow *row = OptionFind(name);

  if ((row && row->flags & LATE) || StartsWith(name, "-mat_")) return PETSC_TRUE;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(objects); i++)
    for (size_t j = 0; StartsWith(name, objects[i]) && j < PETSC_STATIC_ARRAY_LENGTH(words); j++)
      if (strstr(name, words[j])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* OptionsRefuse - refuses an option that nothing has read. Collective. */
PetscErrorCode OptionsRefuse(const char *name) {
  const char *best = OptionNearest(name), *equals = strchr(name, '=');

  PetscFunctionBegin;
  UserCheck(!equals, OptionsComm(), "%s: put a blank before the value: %.*s %s", name,
            (int)(equals - name), name, equals + 1);
  UserCheck(!best || strcmp(best, name), OptionsComm(),
            "%s: nothing in this run reads it; take it out, or choose the type it belongs to",
            name);
  UserCheck(!best, OptionsComm(), "%s: unknown option, did you mean %s?", name, best);
  UserCheck(PETSC_FALSE, OptionsComm(), "%s: unknown option; -help lists them", name);
  PetscFunctionReturn(0);
}

/* OptionOfPetsc - can this, which is not in the table, be an option of one of PETSc's objects? */
PetscBool OptionOfPetsc(const char *name) {
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(objects); i++)
    if (StartsWith(name, objects[i])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* OptionsRefuseStrange - refuses an option that is not in the table and cannot be PETSc's.
   Collective. */
PetscErrorCode OptionsRefuseStrange(const char *name) {
  PetscFunctionBegin;
  if (!OptionOfPetsc(name)) PetscCall(OptionsRefuse(name));
  PetscFunctionReturn(0);
}

/* OptionsBegin - was any option given whose name begins like this? (It does not count as read.) */
PetscErrorCode OptionsBegin(const char *start, PetscBool *any) {
  char *all, words[80];

  PetscFunctionBegin;
  (void)snprintf(words, sizeof(words), " %s", start);
  PetscCall(PetscOptionsGetAll(NULL, &all));
  *any = (PetscBool)(StartsWith(all, start) || strstr(all, words));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/*
  OptionsRefuseUnread - refuses the run if an option was given that nothing has read (in an options
  file that is fine if the command line asks for a task of its own).
  Call after everything has read its options and before any work. Collective.
*/
PetscErrorCode OptionsRefuseUnread(void) {
  PetscInt n;
  char **unread, **values, found[80] = "";
  PetscBool other = (PetscBool)(!OptionsPushed() && OptionOnCommandLine("-task"));

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &unread, &values));
  for (PetscInt i = 0; i < n && !found[0]; i++) {
    char full[80];
    (void)snprintf(full, sizeof(full), "-%s", unread[i]);
    if (!ReadLate(full) && (!other || OptionOnCommandLine(full)))
      PetscCall(PetscStrncpy(found, full, sizeof(found)));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &unread, &values));
  if (found[0]) PetscCall(OptionsRefuse(found));
  ErrorsOptionsRead();
  PetscFunctionReturn(0);
}

static PetscBool SameFile(const struct stat *a, const struct stat *b) {
  return (PetscBool)(a->st_dev == b->st_dev && a->st_ino == b->st_ino);
}

/* OptionsRefuseOverwrite - refuses an output file, which the named option gives, that is also an
   input. Collective. */
PetscErrorCode OptionsRefuseOverwrite(const char *option, const char *output) {
  const CommandLine *line = OptionsLine();
  char file[PETSC_MAX_PATH_LEN];
  struct stat to, from;
  const OptionRow *row;
  PetscBool found;
  size_t place = 0;

  PetscFunctionBegin;
  if (!output[0] || stat(output, &to)) PetscFunctionReturn(0);
  for (int k = 0; line && WordsFile(&line->taken, k); k++)
    UserCheck(stat(WordsFile(&line->taken, k), &from) || !SameFile(&to, &from), OptionsComm(),
              "%s %s: would overwrite the file that -options_file gives; name another", option,
              output);
  while ((row = OptionNext(&place))) {
    if (!(row->flags & INPUT_FILE) || row->flags & IN_PLACE) continue;
    PetscCall(PetscOptionsGetString(NULL, NULL, row->name, file, sizeof(file), &found));
    if (!found || stat(file, &from)) continue;
    UserCheck(!SameFile(&to, &from), OptionsComm(),
              "%s %s: would overwrite the file that %s gives; name another", option, output,
              row->name);
  }
  PetscFunctionReturn(0);
}

/* Makes a line of each option in a text of PETSc's. */
static void BreakLines(char *all) {
  size_t n = strlen(all);
  for (size_t i = 0; i < n; i++)
    if (all[i] == ' ' && all[i + 1] == '-' && isalpha((unsigned char)all[i + 2])) all[i] = '\n';
  while (n > 0 && isspace((unsigned char)all[n - 1])) all[--n] = 0;
}

/* OptionsList - all options that were given, one a line, as an options file has them, units and
   all. The caller frees the text (PetscFree). (Asking PETSc for them one by one would count them as
   read.) */
PetscErrorCode OptionsList(char **text) {
  char *all, name[128];
  size_t at = 0, room;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetAll(NULL, &all));
  BreakLines(all);
  room = strlen(all) + 2048; /* what carries a unit is short */
  PetscCall(PetscCalloc1(room, text));
  for (const char *line = all; line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL) {
    const char *said;
    (void)snprintf(name, sizeof(name), "%.*s", (int)strcspn(line, " \n"), line);
    said = OptionSaid(name);
    at +=
        (size_t)(said ? snprintf(*text + at, room - at, "%s %s\n", name, said)
                      : snprintf(*text + at, room - at, "%.*s\n", (int)strcspn(line, "\n"), line));
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* OptionsRefuseLeft - at the end of a run: refuses what PETSc was to read and did not, as
   OptionsRefuseUnread() could not know. Collective. */
PetscErrorCode OptionsRefuseLeft(void) {
  PetscInt n;
  char **unread, **values, found[80] = "";

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &unread, &values));
  for (PetscInt i = 0; i < n && !found[0]; i++) {
    const OptionRow *row;
    char full[80];
    (void)snprintf(full, sizeof(full), "-%s", unread[i]);
    row = OptionFind(full);
    if (ReadLate(full) && !(row && row->flags & LATE))
      PetscCall(PetscStrncpy(found, full, sizeof(found)));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &unread, &values));
  UserCheck(!found[0], OptionsComm(),
            "%s: nothing in this run has read it; the run itself is complete", found);
  PetscFunctionReturn(0);
}
