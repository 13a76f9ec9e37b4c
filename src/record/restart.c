#include "record/restart.h"
#include "base/hdf.h"
#include "base/options.h"
#include <ctype.h>

/* Options of the earlier run that say how it was run, not what it was. */
static PetscErrorCode Passing(const char *name, PetscBool stopped, PetscBool *passing) {
  const char *const all[] = {"-output",       "-restart", "-options_file", "-quiet",
                             "-task",         "-ts_dt",   "-log_view",     "-malloc_dump",
                             "-ts_max_steps", "-help",    "-ts_monitor",   "-options_left"};

  PetscFunctionBegin;
  *passing = (PetscBool)(stopped && !strncmp(name, "-stop_", 6));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(all) && !*passing; i++)
    PetscCall(PetscStrcmp(name, all[i], passing));
  PetscFunctionReturn(0);
}

static PetscErrorCode Inherit(const char *name, const char *value, PetscBool stopped) {
  PetscBool passing, given;

  PetscFunctionBegin;
  PetscCall(Passing(name, stopped, &passing));
  PetscCall(PetscOptionsHasName(NULL, NULL, name, &given));
  if (!passing && !given) PetscCall(PetscOptionsSetValue(NULL, name, value[0] ? value : NULL));
  PetscFunctionReturn(0);
}

/*
  RestartOptions - with -restart FILE, takes over the options the earlier run had in force; those
  given now win. Collective; before anything else reads options.
*/
PetscErrorCode RestartOptions(char file[], size_t length, PetscBool *restart) {
  char *text, *word, name[128] = "", value[PETSC_MAX_PATH_LEN] = "";
  PetscBool stopped;

  PetscFunctionBegin;
  PetscCall(OptionString("-restart", "result file of a run to go on with", file, length, restart));
  if (!*restart) PetscFunctionReturn(0);
  PetscCall(HdfReadAttributeText("-restart", file, "options", &text));
  PetscCall(HdfExists(file, "/event", &stopped));
  for (word = strtok(text, " \t\n"); word; word = strtok(NULL, " \t\n")) {
    if (word[0] == '-' && isalpha((unsigned char)word[1])) {
      if (name[0]) PetscCall(Inherit(name, value, stopped));
      PetscCall(PetscStrncpy(name, word, sizeof(name)));
      value[0] = 0;
    } else {
      if (value[0]) PetscCall(PetscStrlcat(value, " ", sizeof(value))); /* a name with a blank */
      PetscCall(PetscStrlcat(value, word, sizeof(value)));
    }
  }
  if (name[0]) PetscCall(Inherit(name, value, stopped));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(0);
}

/* RestartSum - tells whether the points in a file belong to their state. */
PetscReal RestartSum(PetscInt n, const PetscReal points[]) {
  PetscReal sum = 0;
  for (PetscInt i = 0; i < n; i++) sum += PetscAbsReal(points[i]);
  return sum;
}

/*
  RestartRead - reads what is stored to go on from, and gives the scene the file's mesh (which may
  depend on the end time the run had). Collective; the caller frees points (PetscFree).
*/
PetscErrorCode RestartRead(const char *file, Scene scene, RestartState *state, PetscReal **points) {
  PetscReal *data;
  PetscBool exists;
  hsize_t n;
  char text[32];

  PetscFunctionBegin;
  PetscCall(HdfExists(file, "/restart", &exists));
  UserCheck(exists, PETSC_COMM_WORLD,
            "-restart %s: holds nothing to go on from; the run was broken before its first stored "
            "shape, or has its results from another task",
            file);
  PetscCall(HdfRead("-restart", file, "/restart/state", 1, &n, &data));
  UserCheck(n == RESTART_STATE, PETSC_COMM_WORLD, "-restart %s: is of another version of tendril",
            file);
  PetscCall(PetscMemcpy(state, data, sizeof(*state)));
  PetscCall(PetscFree(data));
  PetscCall(HdfRead("-restart", file, "/shapes/s", 1, &n, &data));
  UserCheck((PetscInt)n == scene->mesh.cells + 1, PETSC_COMM_WORLD,
            "-rod_cells %d: the run in -restart %s has %d", (int)scene->mesh.cells, file,
            (int)n - 1);
  PetscCall(PetscArraycpy(scene->mesh.s, data, n));
  PetscCall(PetscFree(data));
  scene->curvature.reference_length = state->reference_length;
  PetscCall(HdfRead("-restart", file, "/restart/points", 1, &n, points));
  UserCheck(state->points >= 1 && state->points < VBDF_POINTS &&
                n >= state->points * state->fields * (scene->mesh.cells + 1) &&
                RestartSum((PetscInt)n, *points) == state->sum,
            PETSC_COMM_WORLD,
            "-restart %s: was broken while it was being written, and cannot be gone on with", file);
  UserCheck(scene->end_time > state->t * (1 + 1e-12), PETSC_COMM_WORLD,
            "-restart %s: is at t = %s already; give a later -ts_max_time", file,
            OptionNumber(state->t, text));
  PetscFunctionReturn(0);
}
