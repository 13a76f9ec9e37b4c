/* The state of a run in a file: /restart/state, reals one behind the other, and /restart/names,
   whose they are: name and how many, a line each. */
#include "record/remembered.h"
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  const char *name;
  PetscInt at, n; /* in a RestartState */
} Number;

#define REALS(size) ((PetscInt)((size) / (sizeof(PetscReal))))
#define ROW(type, name, many, text)                                                                \
  {#name, REALS(offsetof(RestartState, name)), REALS(sizeof(type many))},
#define KEPT_ROW(type, name, many, text)                                                           \
  {#name, REALS(offsetof(RestartState, kept) + offsetof(Remembered, name)),                        \
   REALS(sizeof(type many))},
static const Number numbers[] = {REMEMBERED(KEPT_ROW) REMEMBERED_BY_STEPS(ROW)};

/* The parts of a number that is a struct have names of their own: "seen.t"; NULL: it has none. */
static const char *const *PartsOf(const char *name) {
  if (!strcmp(name, "laws")) return scene_memory_name;
  return !strcmp(name, "seen") || !strcmp(name, "began") ? observed_name : NULL;
}

/* Files that have no names, of version 0.2, have these; and in an observation these. */
static const char *const unnamed =
    "t 1 step 1 points 1 order 1 model 1 fields 1 steps 1 memory 4 wants 1 ease 1 others 1 kick 13 "
    "kick_ends 1 seen 59 began 59 folds 1 neglected 1 laws.falls 1 laws.shared 1 counted 2 "
    "laws.firm 1 errors 12 following 44 follows 1 errors_sum 1 snaps 1 crossings 1 crossed 1 "
    "vanished 1 depth 1 energy_folds 1 weighed 1 gave_way 1 pressed 1 blind 1 layered 1 event_at 1 "
    "event_is 1 worst 9 off 1 crawl_way 1 crawl_half 1 crawl_steps 1 slips_at 1 slips_steps 1 "
    "window 1 window_steps 1 way 1 crawl_at 1 time 9 balance 28 sum 1";
static const char *const unnamed_series =
    "t length tip_x1 tip_x2 norm_x2 norm_x2_length max_angle energy growth_power dissipation "
    "energy_defect end_distance mid_distance width tip_speed mid_speed base_force_1 "
    "base_force_2 feed_force tip_force_1 tip_force_2 tip_power contact_force wall_force_1 "
    "wall_force_2 friction_force_1 friction_force_2 contact_energy penetration contacts "
    "inflections self_crossings step newton_iterations model error_tip error_norm_x2 "
    "error_energy weight_power weight_force_1 weight_force_2 tip_x3 norm_x3 twist writhe link "
    "energy_twist base_force_3 base_moment_1 base_moment_2 base_moment_3 tip_force_3 "
    "wall_force_3 friction_force_3 weight_force_3 wall_power tip_spin clamp_power "
    "curvature_power";
enum { UNNAMED_SERIES = 59 };

/* Finds a name that a file has, and how many reals it is; NULL: none is called so. */
static PetscReal *Find(RestartState *state, const char *name, PetscInt *n) {
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(numbers); k++) {
    const Number *number = &numbers[k];
    const char *const *part = PartsOf(number->name);
    const size_t length = strlen(number->name);
    PetscReal *at = (PetscReal *)state + number->at;
    *n = part ? 1 : number->n;
    if (!part && !strcmp(name, number->name)) return at;
    if (!part || strncmp(name, number->name, length) || name[length] != '.') continue;
    for (PetscInt i = 0; i < number->n; i++)
      if (!strcmp(name + length + 1, part[i])) return at + i;
  }
  return NULL;
}

/* Takes as many of the reals of a file as a name has; known: it has that many here, too. */
static PetscBool Take(RestartState *state, const char *name, PetscInt n, const PetscReal *from) {
  PetscReal *to;
  PetscInt room;

  to = Find(state, name, &room);
  if (!to || room != n) return PETSC_FALSE;
  for (PetscInt k = 0; k < n; k++) to[k] = from[k];
  return PETSC_TRUE;
}

/* Of a file without names: an observation has as many reals as it had series. */
static PetscBool TakeUnnamed(RestartState *state, const char *name, PetscInt n,
                             const PetscReal *from) {
  PetscBool known = PETSC_TRUE;
  const char *series = unnamed_series;
  char part[64];

  if (n != UNNAMED_SERIES) return Take(state, name, n, from);
  for (PetscInt k = 0; k < n; k++, series += strcspn(series, " ") + 1) {
    (void)snprintf(part, sizeof(part), "%s.%.*s", name, (int)strcspn(series, " "), series);
    known = (PetscBool)(known && Take(state, part, 1, from + k));
  }
  return known;
}

/* Takes a state from n reals, by names; known: they are all of this version. */
static PetscErrorCode TakeAll(const char *names, PetscBool named, PetscInt n, const PetscReal *data,
                              RestartState *state, PetscBool *known) {
  PetscInt at = 0, many;
  char *copy, *left;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(state, sizeof(*state)));
  PetscCall(PetscStrallocpy(names, &copy));
  *known = PETSC_TRUE;
  for (char *name = strtok(copy, " \n"); name && *known; name = strtok(NULL, " \n")) {
    const char *count = strtok(NULL, " \n");
    many = count ? (PetscInt)strtol(count, &left, 10) : 0;
    *known = (PetscBool)(many > 0 && at + many <= n &&
                         (named ? Take : TakeUnnamed)(state, name, many, data + at));
    at += many;
  }
  if (at != n) *known = PETSC_FALSE;
  if (!named) state->kept.changed = -1;
  PetscCall(PetscFree(copy));
  PetscFunctionReturn(0);
}

/*
  RememberedRead - the state that a file has. Collective.

  What a file has no name of is 0; one that has a name that is not known here, or of another size,
  is of another version.
*/
PetscErrorCode RememberedRead(const char *file, MPI_Comm comm, RestartState *state) {
  PetscInt n;
  PetscBool named, known;
  char *names = NULL;
  PetscReal *data;

  PetscFunctionBegin;
  PetscCall(HdfRead("-restart", file, "/restart/state", 1, &n, &data));
  PetscCall(HdfHas(file, "/restart/names", &named));
  if (named)
    PetscCall(HdfReadText("-restart", file, "/restart/names", &names));
  else
    PetscCall(PetscStrallocpy(unnamed, &names));
  PetscCall(TakeAll(names, named, n, data, state, &known));
  PetscCall(PetscFree(names));
  PetscCall(PetscFree(data));
  UserCheck(known, comm, "-restart %s: is of another version of tendril", file);
  PetscFunctionReturn(0);
}

/* The reals of a state, as names have them. */
static PetscReal *Give(const RestartState *state, PetscReal *to) {
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(numbers); k++)
    for (PetscInt i = 0; i < numbers[k].n; i++)
      *to++ = ((const PetscReal *)state)[numbers[k].at + i];
  return to;
}

/* RememberedWrite - writes a state, into a file that is open, on rank 0 (NULL on the others). */
PetscErrorCode RememberedWrite(HdfFile file, const RestartState *state) {
  const PetscInt n = RESTART_STATE;
  PetscReal value[RESTART_STATE];
  const size_t room = RESTART_STATE * sizeof(observed_name[0]) * 8;
  char *names, *end;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(room, &names));
  end = names;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(numbers); k++) {
    const Number *number = &numbers[k];
    const char *const *part = PartsOf(number->name);
    if (!part)
      end += snprintf(end, room - (size_t)(end - names), "%s %d\n", number->name, (int)number->n);
    for (PetscInt i = 0; part && i < number->n; i++)
      end += snprintf(end, room - (size_t)(end - names), "%s.%s 1\n", number->name, part[i]);
  }
  (void)Give(state, value);
  PetscCall(HdfWrite(file, "/restart/state", 1, &n, value, "mixed",
                     "time, step and history of the stepper, for -restart"));
  PetscCall(HdfWriteText(file, "/restart/names", names, "what they are, and how many"));
  PetscCall(PetscFree(names));
  PetscFunctionReturn(0);
}

/* RememberedWriteEach - writes the states of n rods, as RememberedWrite() that of all, behind it.
 */
PetscErrorCode RememberedWriteEach(HdfFile file, PetscInt n, const RestartState state[]) {
  const PetscInt dims[] = {n, RESTART_STATE};
  PetscReal *value, *to;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n * RESTART_STATE, &value));
  to = value;
  for (PetscInt r = 0; r < n; r++) to = Give(&state[r], to);
  PetscCall(HdfWrite(file, "/restart/each", 2, dims, value, "mixed",
                     "what each rod remembers, as state has it of all"));
  PetscCall(PetscFree(value));
  PetscFunctionReturn(0);
}

/* RememberedReadEach - the states of n rods that a file has. Collective. */
PetscErrorCode RememberedReadEach(const char *file, MPI_Comm comm, PetscInt n,
                                  RestartState state[]) {
  PetscBool known = PETSC_TRUE;
  PetscInt dims[2];
  PetscReal *data;
  char *names;

  PetscFunctionBegin;
  PetscCall(HdfReadGaps("-restart", file, "/restart/each", 2, dims, &data));
  PetscCall(HdfReadText("-restart", file, "/restart/names", &names));
  UserCheck(dims[0] == n, comm, "-restart %s: holds the state of %d rods, and there are %d", file,
            (int)dims[0], (int)n);
  for (PetscInt k = 0; k < n && known; k++)
    PetscCall(TakeAll(names, PETSC_TRUE, dims[1], data + k * dims[1], &state[k], &known));
  PetscCall(PetscFree(names));
  PetscCall(PetscFree(data));
  UserCheck(known, comm, "-restart %s: is of another version of tendril", file);
  PetscFunctionReturn(0);
}
