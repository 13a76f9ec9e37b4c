#include "base/schedule.h"
#include "material/growth.h"

/*
  feed by a schedule: the length, or the speed of what is pushed in at the clamp, follows rows over
  time, and where it falls the rod is pulled out again:
    g = L(t),   V = L_t,   c = (1 - s) L_t.
*/
static const char *const option = "-growth_path";

/* The shortest that a rod may become. */
static const PetscReal shortest = 1e-6;

/* L and its rate. */
static PetscReal LengthAt(Growth self, PetscReal t, PetscReal *rate) {
  const Schedule path = (Schedule)self->data;

  *rate = ScheduleRate(path, t);
  return self->initial_length + ScheduleValue(path, t);
}

static PetscErrorCode StretchPath(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                  PetscReal *g_t, PetscReal *g_s) {
  char text[64];

  PetscFunctionBegin;
  *g = LengthAt(self, t, g_t);
  *g_s = 0;
  UserCheck(*g > 0, PETSC_COMM_SELF, "%s: at t = %s the rod is pulled out altogether", option,
            OptionBoth(t, UNIT_TIME, text));
  PetscFunctionReturn(0);
}

static PetscErrorCode ArcPath(Growth self, PetscReal s, PetscReal t, PetscReal *p, PetscReal *p_t) {
  PetscReal rate;

  *p = s * LengthAt(self, t, &rate);
  *p_t = s * rate;
  return 0;
}

static PetscReal SpeedPath(Growth self, PetscReal s, PetscReal t) {
  return ScheduleRate((Schedule)self->data, t);
}

static PetscReal SlidePath(Growth self, PetscReal s, PetscReal t) {
  return (1 - s) * SpeedPath(self, s, t);
}

static PetscReal StrainPath(Growth self, PetscReal s, PetscReal t) {
  return 0;
}

static PetscErrorCode OriginPath(Growth self, PetscReal s, PetscReal t, PetscReal *d,
                                 PetscReal *d_t) {
  PetscReal rate;

  *d = (1 - s) * LengthAt(self, t, &rate);
  *d_t = 0;
  return 0;
}

static PetscReal NextTurn(Growth self, PetscReal t) {
  return ScheduleNextTurn((Schedule)self->data, t);
}

static PetscErrorCode FindBends(Growth self, PetscReal tolerance, Bends *bends) {
  PetscFunctionBegin;
  PetscCall(ScheduleBends((Schedule)self->data, tolerance, bends));
  PetscFunctionReturn(0);
}

/* (At t = 0 it sets out as any rod does.) */
static PetscBool Jerks(Growth self, PetscReal t0, PetscReal t1) {
  const PetscReal tiny = 1e-300;

  return ScheduleJerks((Schedule)self->data, PetscMax(t0, tiny), t1);
}

static PetscErrorCode DestroyPath(Growth self) {
  Schedule path = (Schedule)self->data;

  PetscFunctionBegin;
  PetscCall(ScheduleDestroy(&path));
  PetscFunctionReturn(0);
}

/* The length at the start: that of rows that say it, which an option may repeat. */
static PetscErrorCode Begin(Growth self, const char *file) {
  const PetscReal alike = 1e-9;
  const Schedule path = (Schedule)self->data;
  PetscReal begins = ScheduleStart(path), asked;
  PetscBool given;
  char text[2][64];

  PetscFunctionBegin;
  PetscCall(OptionReal("-growth_initial_length", &asked, &given));
  self->initial_length = asked;
  if (ScheduleIsRate(path)) PetscFunctionReturn(0);
  UserCheck(!given || PetscAbsReal(asked - begins) <= alike * asked, OptionsComm(),
            "-growth_initial_length %s: with %s %s the rod is %s long at t = 0; leave it out",
            OptionBoth(asked, UNIT_LENGTH, text[0]), option, file,
            OptionBoth(begins, UNIT_LENGTH, text[1]));
  self->initial_length = begins;
  PetscFunctionReturn(0);
}

/* Between the rows a length goes one way only, and a speed does between its turns. */
static PetscErrorCode CheckLengths(Growth self, const char *file) {
  const Schedule path = (Schedule)self->data;
  PetscReal t = 0, L, rate;
  char text[2][64];

  PetscFunctionBegin;
  for (; t < PETSC_MAX_REAL; t = NextTurn(self, t)) {
    L = LengthAt(self, t, &rate);
    UserCheck(L >= shortest, OptionsComm(),
              "%s %s: at t = %s the rod is %s long; it must stay longer than 0", option, file,
              OptionBoth(t, UNIT_TIME, text[0]), OptionBoth(L, UNIT_LENGTH, text[1]));
  }
  UserCheck(ScheduleFastest(path) > 0, OptionsComm(),
            "%s %s: nothing moves; for a rod that does not grow give -growth_type none", option,
            file);
  PetscFunctionReturn(0);
}

/* GrowthPathGiven - is there a schedule for a law, which goes on without one? Refused if it cannot
   go by one. Collective on OptionsComm(). */
PetscErrorCode GrowthPathGiven(Growth self, PetscBool *given) {
  PetscFunctionBegin;
  PetscCall(OptionGiven(option, given));
  UserCheck(!*given || !strcmp(self->type, "feed"), OptionsComm(),
            "%s: with -growth_type %s length comes and stays as that law has it; a rod that is "
            "pushed in and pulled out by a schedule has -growth_type feed",
            option, self->type);
  PetscFunctionReturn(0);
}

/* GrowthFeedByPath - makes feeding follow the schedule that is given. Collective on OptionsComm().
 */
PetscErrorCode GrowthFeedByPath(Growth self) {
  const ScheduleWords words = {"a rod is fed", "speed", "length", UNIT_SPEED, UNIT_LENGTH};
  char file[PETSC_MAX_PATH_LEN] = "";
  Schedule path;

  PetscFunctionBegin;
  PetscCall(OptionText(option, file, NULL));
  self->destroy = DestroyPath;
  PetscCall(ScheduleReadAs(option, file, &words, (Schedule *)&self->data));
  path = (Schedule)self->data;
  PetscCall(Begin(self, file));
  self->similar = PETSC_FALSE;
  self->fastest = ScheduleFastest(path);
  self->next_turn = NextTurn;
  self->bends = FindBends;
  self->jerks = Jerks;
  self->stretch = StretchPath;
  self->arc = ArcPath;
  self->speed = SpeedPath;
  self->slide = SlidePath;
  self->strain = StrainPath;
  self->origin = OriginPath;
  self->depart = GrowthDepartFed;
  self->front = NextTurn(self, 0) < PETSC_MAX_REAL ? NULL : GrowthFrontFed;
  PetscCall(CheckLengths(self, file));
  PetscFunctionReturn(0);
}

/* ---- fed on at a speed that a run has changed ---- */

/* From a time on, when it was so long; until it is as short as it may get, or for ever. */
typedef struct {
  PetscReal t, length, speed, stops;
} Fed;

/* How much of the length at the start stays in whatever happens. */
static const PetscReal least_left = 0.1;

static PetscReal FedSpeed(Growth self, PetscReal s, PetscReal t) {
  const Fed *fed = (const Fed *)self->data;

  return t < fed->stops ? fed->speed : 0;
}

static PetscReal FedLength(Growth self, PetscReal t) {
  const Fed *fed = (const Fed *)self->data;

  return fed->length + fed->speed * (PetscMin(t, fed->stops) - fed->t);
}

static PetscErrorCode StretchFed(Growth self, PetscReal s, PetscReal t, PetscReal *g,
                                 PetscReal *g_t, PetscReal *g_s) {
  *g = FedLength(self, t);
  *g_t = FedSpeed(self, s, t);
  *g_s = 0;
  return 0;
}

static PetscErrorCode ArcFed(Growth self, PetscReal s, PetscReal t, PetscReal *p, PetscReal *p_t) {
  *p = s * FedLength(self, t);
  *p_t = s * FedSpeed(self, s, t);
  return 0;
}

static PetscReal SlideFed(Growth self, PetscReal s, PetscReal t) {
  return (1 - s) * FedSpeed(self, s, t);
}

static PetscErrorCode OriginFed(Growth self, PetscReal s, PetscReal t, PetscReal *d,
                                PetscReal *d_t) {
  *d = (1 - s) * FedLength(self, t);
  *d_t = 0;
  return 0;
}

static PetscReal FedStops(Growth self, PetscReal t) {
  const Fed *fed = (const Fed *)self->data;

  return fed->stops > t ? fed->stops : PETSC_MAX_REAL;
}

static PetscBool FedJerks(Growth self, PetscReal t0, PetscReal t1) {
  const Fed *fed = (const Fed *)self->data;

  return (PetscBool)(fed->stops >= t0 && fed->stops < t1);
}

/* GrowthFeedOn - a rod that is fed goes on from t on at this speed; below 0 it is pulled out again,
   until a tenth of what there was at the start is left. The same on every rank. */
PetscErrorCode GrowthFeedOn(Growth self, PetscReal t, PetscReal speed) {
  PetscReal length;
  Fed *fed;

  PetscFunctionBegin;
  PetscCall(GrowthLength(self, t, &length, NULL));
  PetscCall(PetscNew(&fed));
  *fed = (Fed){t, length, speed, PETSC_MAX_REAL};
  if (speed < 0) fed->stops = t + PetscMax(0, length - least_left * self->initial_length) / -speed;
  if (self->destroy) PetscCall(self->destroy(self));
  self->data = fed;
  self->destroy = GrowthDestroyData;
  self->similar = PETSC_FALSE;
  self->next_turn = FedStops;
  self->bends = NULL;
  self->front = NULL;
  self->jerks = FedJerks;
  self->stretch = StretchFed;
  self->arc = ArcFed;
  self->speed = FedSpeed;
  self->slide = SlideFed;
  self->strain = StrainPath;
  self->origin = OriginFed;
  PetscFunctionReturn(0);
}
