#include "world/motion.h"
#include "base/vectors.h"
#include "base/extremes.h"
#include <ctype.h>
#include <stdarg.h>

/* What stands behind `moves` or `turns`. */
typedef struct {
  const char *file;
  char what[PETSC_MAX_PATH_LEN]; /* names the line and that word where it is refused */
  PetscInt n;
  char **word;
} Said;

/* MotionWord - does a word begin what says how a surface moves? */
PetscBool MotionWord(const char *word) {
  return (PetscBool)(!strcmp(word, "moves") || !strcmp(word, "turns"));
}

static PetscBool IsNumber(const char *word) {
  if (*word == '-' || *word == '+') word++;
  if (*word == '.') word++;
  return (PetscBool)(isdigit((unsigned char)*word) != 0);
}

/* The path of a file, which is looked for beside the file that names it. */
static void Beside(const Said *said, const char *name, char *path, size_t length) {
  const char *slash = strrchr(said->file, '/');
  const int folder = slash && name[0] != '/' ? (int)(slash - said->file) + 1 : 0;

  (void)snprintf(path, length, "%.*s%s", folder, said->file, name);
}

/* ---- how it is carried along ---- */

/* moves at T X1 X2 X3  T X1 X2 X3 ... */
static PetscErrorCode TakePlaces(const Said *said, SurfaceMotion *motion) {
  enum { FOUR = 4 };
  const PetscInt rows = (said->n - 1) / FOUR;
  PetscReal t, x;

  PetscFunctionBegin;
  UserCheck(rows >= 2 && (said->n - 1) % FOUR == 0, OptionsComm(),
            "%s at: has %d numbers; give rows of four, T X1 X2 X3, and two rows at least",
            said->what, (int)said->n - 1);
  for (int d = 0; d < 3; d++) PetscCall(ScheduleCreate(rows, &motion->place[d]));
  for (PetscInt k = 0; k < rows; k++) {
    char **row = said->word + 1 + FOUR * k;
    PetscCall(OptionQuantity(said->what, row[0], UNIT_TIME, &t));
    for (int d = 0; d < 3; d++) {
      PetscCall(OptionQuantity(said->what, row[1 + d], UNIT_LENGTH, &x));
      ScheduleSetRow(motion->place[d], k, t, x);
    }
  }
  for (int d = 0; d < 3; d++) PetscCall(ScheduleSetUp(said->what, PETSC_FALSE, motion->place[d]));
  PetscFunctionReturn(0);
}

static PetscErrorCode Moves(const Said *said, SurfaceMotion *motion) {
  char path[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  if (said->n && !strcmp(said->word[0], "at")) {
    PetscCall(TakePlaces(said, motion));
    motion->led = PETSC_TRUE;
  } else if (said->n == 1 && !IsNumber(said->word[0])) {
    Beside(said, said->word[0], path, sizeof(path));
    PetscCall(ScheduleReadPlace(said->what, path, motion->place));
    motion->led = PETSC_TRUE;
  } else {
    UserCheck(said->n == 3, OptionsComm(),
              "%s: give moves VX VY VZ, and turns RATE X Y Z AX AY AZ, its rate, and the place and "
              "direction of the axis; or, over time, moves at T X1 X2 X3 T X1 X2 X3 ..., or moves "
              "FILE",
              said->what);
    for (int d = 0; d < 3; d++)
      PetscCall(OptionQuantity(said->what, said->word[d], UNIT_SPEED, &motion->velocity[d]));
  }
  PetscFunctionReturn(0);
}

/* ---- how it turns ---- */

/* X Y Z AX AY AZ, the axis */
static PetscErrorCode TakeAxis(const Said *said, char *word[], SurfaceMotion *motion) {
  PetscReal size;

  PetscFunctionBegin;
  for (int d = 0; d < 3; d++) {
    PetscCall(OptionQuantity(said->what, word[d], UNIT_LENGTH, &motion->at[d]));
    PetscCall(OptionQuantity(said->what, word[3 + d], UNIT_NONE, &motion->axis[d]));
  }
  size = Size3(motion->axis);
  UserCheck(size > 0, OptionsComm(), "%s: its axis has no direction", said->what);
  for (int d = 0; d < 3; d++) motion->axis[d] /= size;
  PetscFunctionReturn(0);
}

/* turns at T ANGLE T ANGLE ... about X Y Z AX AY AZ, or turns spin T RATE T RATE ... about ... */
static PetscErrorCode TakeAngles(const Said *said, SurfaceMotion *motion) {
  enum { AXIS = 6 };
  const PetscBool rate = (PetscBool)!strcmp(said->word[0], "spin");
  PetscInt about = 1;
  PetscReal t, value;

  PetscFunctionBegin;
  while (about < said->n && strcmp(said->word[about], "about")) about++;
  UserCheck(said->n == about + 1 + AXIS, OptionsComm(),
            "%s %s: behind the rows give the place and direction of the axis: about X Y Z AX AY AZ",
            said->what, said->word[0]);
  UserCheck(about >= 5 && about % 2, OptionsComm(),
            "%s %s: has %d numbers; give rows of two, T %s, and two rows at least", said->what,
            said->word[0], (int)about - 1, rate ? "RATE" : "ANGLE");
  PetscCall(TakeAxis(said, said->word + about + 1, motion));
  PetscCall(ScheduleCreate(about / 2, &motion->turn));
  for (PetscInt k = 0; k < about / 2; k++) {
    PetscCall(OptionQuantity(said->what, said->word[1 + 2 * k], UNIT_TIME, &t));
    PetscCall(OptionQuantity(said->what, said->word[2 + 2 * k], UNIT_ANGLE, &value));
    ScheduleSetRow(motion->turn, k, t, value);
  }
  PetscCall(ScheduleSetUp(said->what, rate, motion->turn));
  PetscFunctionReturn(0);
}

static PetscErrorCode Turns(const Said *said, SurfaceMotion *motion) {
  enum { TURNS = 7 };
  char path[PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  if (said->n && (!strcmp(said->word[0], "at") || !strcmp(said->word[0], "spin"))) {
    PetscCall(TakeAngles(said, motion));
    PetscFunctionReturn(0);
  }
  UserCheck(
      said->n == TURNS, OptionsComm(),
      "%s: give turns RATE X Y Z AX AY AZ, its rate, and the place and direction of the axis; "
      "or, over time, turns at T ANGLE T ANGLE ... about X Y Z AX AY AZ, or turns FILE X Y Z "
      "AX AY AZ",
      said->what);
  PetscCall(TakeAxis(said, said->word + 1, motion));
  if (IsNumber(said->word[0])) {
    PetscCall(OptionQuantity(said->what, said->word[0], UNIT_ANGLE, &motion->rate));
    PetscFunctionReturn(0);
  }
  Beside(said, said->word[0], path, sizeof(path));
  PetscCall(ScheduleRead(said->what, path, "a surface", &motion->turn));
  PetscFunctionReturn(0);
}

/*
  MotionTake - takes what begins with `moves` and `turns`, in either order, off the end of a line's
  words. Collective on OptionsComm(); the caller ends it with MotionDestroy(), also after an error.

  file, line  where it stands
  n, word     all words of the line, and on exit those before
  motion      all 0 on entry
*/
PetscErrorCode MotionTake(const char *file, int line, PetscInt *n, char *word[],
                          SurfaceMotion *motion) {
  PetscBool moves = PETSC_FALSE, turns = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt k = *n - 1; k > 0; k--) {
    const PetscBool move = (PetscBool)!strcmp(word[k], "moves");
    Said said = {.file = file, .n = *n - k - 1, .word = word + k + 1};
    if (!MotionWord(word[k])) continue;
    (void)snprintf(said.what, sizeof(said.what), "-wall_file %s, line %d: %s", file, line, word[k]);
    UserCheck(!(move ? moves : turns), OptionsComm(), "%s is said twice; leave one out", said.what);
    PetscCall(move ? Moves(&said, motion) : Turns(&said, motion));
    *(move ? &moves : &turns) = motion->any = PETSC_TRUE;
    *n = k;
  }
  PetscFunctionReturn(0);
}

PetscErrorCode MotionDestroy(SurfaceMotion *motion) {
  PetscFunctionBegin;
  for (int d = 0; d < 3; d++) PetscCall(ScheduleDestroy(&motion->place[d]));
  PetscCall(ScheduleDestroy(&motion->turn));
  PetscCall(PetscFree(motion->places.row));
  PetscCall(PetscFree(motion->angles.row));
  PetscFunctionReturn(0);
}

static PetscErrorCode AddRow(MotionRows *self, PetscReal t, const PetscReal x[3]) {
  enum { ROOM = 64 };
  PetscInt *n = &self->n;

  PetscFunctionBegin;
  while (*n && self->row[*n - 1][0] >= t) (*n)--; /* it does not get there any more */
  if (*n % ROOM == 0 || !self->row)
    PetscCall(PetscRealloc((size_t)(*n + ROOM) * sizeof(*self->row), &self->row));
  self->row[*n][0] = t;
  for (int d = 0; d < 3; d++) self->row[*n][1 + d] = x[d];
  (*n)++;
  PetscFunctionReturn(0);
}

/* The rows up to now of what moved, or turned, as its line says. */
static PetscErrorCode RowsSoFar(SurfaceMotion *motion, PetscBool turns, PetscReal t) {
  MotionRows *rows = turns ? &motion->angles : &motion->places;
  Schedule any = turns ? motion->turn : NULL;
  PetscReal x[3] = {0}, at, value;

  PetscFunctionBegin;
  for (int d = 0; d < 3 && !any && !turns; d++) any = motion->place[d];
  for (PetscInt k = 0; any && k < ScheduleRows(any); k++) {
    ScheduleGetRow(any, k, &at, &value);
    if (at >= t) break;
    if (turns)
      x[0] = MotionTurned(motion, at);
    else
      MotionShift(motion, at, x);
    PetscCall(AddRow(rows, at, x));
  }
  if (any || t <= 0) PetscFunctionReturn(0);
  if (!turns) MotionShift(motion, 0, x);
  PetscCall(AddRow(rows, 0, x));
  PetscFunctionReturn(0);
}

/*
  MotionLeadTo - from t on it is led on, from where it is and as fast as it moves, to a displacement
  at which it comes to rest, and turns as it does.

  by  the time when it is there; t: it is put there at once
  x   the displacement since t = 0
*/
PetscErrorCode MotionLeadTo(SurfaceMotion *motion, PetscReal t, PetscReal by,
                            const PetscReal x[3]) {
  const PetscReal moment = 1e-9 * (1 + t); /* of a row behind another */
  PetscReal is[3], rate[3];

  PetscFunctionBegin;
  MotionShift(motion, t, is);
  MotionVelocity(motion, t, rate);
  if (!motion->lead[0].on) PetscCall(RowsSoFar(motion, PETSC_FALSE, t));
  PetscCall(AddRow(&motion->places, t, is));
  PetscCall(AddRow(&motion->places, by > t ? by : t + moment, x));
  for (int d = 0; d < 3; d++)
    if (by > t)
      LeadTo(&motion->lead[d], t, is[d], rate[d], by, x[d]);
    else
      LeadTo(&motion->lead[d], t, x[d], 0, t, x[d]);
  motion->any = motion->led = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/*
  MotionTurnTo - from t on it is turned on, from where it is and as fast as it turns, to an angle at
  which it comes to rest.

  by      the time when it is there
  angle   since t = 0
  middle  about which it turns, upright along x3, if its line does not say how it turns
*/
PetscErrorCode MotionTurnTo(SurfaceMotion *motion, PetscReal t, PetscReal by, PetscReal angle,
                            const PetscReal middle[3]) {
  const PetscReal is[3] = {MotionTurned(motion, t)}, x[3] = {angle}, rate = MotionRate(motion, t);

  PetscFunctionBegin;
  if (!MotionTurns(motion))
    for (int d = 0; d < 3; d++) {
      motion->at[d] = middle[d];
      motion->axis[d] = d == 2;
    }
  if (!motion->lead_turn.on) PetscCall(RowsSoFar(motion, PETSC_TRUE, t));
  PetscCall(AddRow(&motion->angles, t, is));
  PetscCall(AddRow(&motion->angles, by, x));
  LeadTo(&motion->lead_turn, t, is[0], rate, by, angle);
  motion->any = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* ---- text ---- */

/* A text that grows. */
typedef struct {
  size_t at, room;
  char *text;
} Text;

static PetscErrorCode Add(Text *self, const char *format, ...) {
  enum { LONGEST = 40 }; /* a word, or a number, with a blank before it */
  va_list more;

  PetscFunctionBegin;
  if (self->room < self->at + LONGEST) {
    self->room = 2 * self->room + LONGEST;
    PetscCall(PetscRealloc(self->room, &self->text));
  }
  va_start(more, format);
  self->at += (size_t)vsnprintf(self->text + self->at, LONGEST, format, more);
  va_end(more);
  PetscFunctionReturn(0);
}

static PetscErrorCode AddNumbers(Text *text, int n, const PetscReal x[]) {
  PetscFunctionBegin;
  for (int d = 0; d < n; d++) PetscCall(Add(text, " %.17g", (double)x[d]));
  PetscFunctionReturn(0);
}

/* Rows: a time, and n numbers. */
static PetscErrorCode AddRowsSoFar(Text *text, int n, const MotionRows *rows) {
  PetscFunctionBegin;
  for (PetscInt k = 0; k < rows->n; k++) PetscCall(AddNumbers(text, 1 + n, rows->row[k]));
  PetscFunctionReturn(0);
}

/* Rows: a time, and what each of n schedules says, 0 where there is none. */
static PetscErrorCode AddRows(Text *text, int n, const Schedule path[]) {
  Schedule any = NULL;

  PetscFunctionBegin;
  for (int d = 0; d < n && !any; d++) any = path[d];
  for (PetscInt k = 0; k < ScheduleRows(any); k++) {
    PetscReal t, value;
    ScheduleGetRow(any, k, &t, &value);
    PetscCall(Add(text, " %.17g", (double)t));
    for (int d = 0; d < n; d++) {
      value = 0;
      if (path[d]) ScheduleGetRow(path[d], k, &t, &value);
      PetscCall(Add(text, " %.17g", (double)value));
    }
  }
  PetscFunctionReturn(0);
}

/* MotionText - how it moves as a line says it, a blank before each word, dimensionless and without
   files; empty if it does not. The caller frees the text (PetscFree). */
PetscErrorCode MotionText(const SurfaceMotion *motion, char **text) {
  const PetscReal *v = motion->velocity;
  Text said = {0};

  PetscFunctionBegin;
  PetscCall(Add(&said, ""));
  if (motion->places.n) {
    PetscCall(Add(&said, " moves at"));
    PetscCall(AddRowsSoFar(&said, 3, &motion->places));
  } else if (motion->led) {
    PetscCall(Add(&said, " moves at"));
    PetscCall(AddRows(&said, 3, motion->place));
  } else if (Dot3(v, v) > 0) {
    PetscCall(Add(&said, " moves"));
    PetscCall(AddNumbers(&said, 3, v));
  }
  if (MotionTurns(motion)) PetscCall(Add(&said, " turns"));
  if (motion->angles.n) {
    PetscCall(Add(&said, " at"));
    PetscCall(AddRowsSoFar(&said, 1, &motion->angles));
    PetscCall(Add(&said, " about"));
  } else if (motion->turn) {
    PetscCall(Add(&said, ScheduleIsRate(motion->turn) ? " spin" : " at"));
    PetscCall(AddRows(&said, 1, &motion->turn));
    PetscCall(Add(&said, " about"));
  } else if (motion->rate != 0)
    PetscCall(Add(&said, " %.17g", (double)motion->rate));
  if (MotionTurns(motion)) {
    PetscCall(AddNumbers(&said, 3, motion->at));
    PetscCall(AddNumbers(&said, 3, motion->axis));
  }
  *text = said.text;
  PetscFunctionReturn(0);
}

/* ---- moving ---- */

/* The way from its axis, carried along, to a place. */
static void FromAxis(const SurfaceMotion *motion, PetscReal t, const PetscReal x[3],
                     PetscReal o[3]) {
  PetscReal shift[3];

  MotionShift(motion, t, shift);
  for (int d = 0; d < 3; d++) o[d] = x[d] - shift[d] - motion->at[d];
}

/* MotionVelocityAt - the velocity of its material at x, and its rate of turning. */
void MotionVelocityAt(const SurfaceMotion *motion, PetscReal t, const PetscReal x[3],
                      PetscReal velocity[3], PetscReal spin[3]) {
  const PetscReal rate = MotionRate(motion, t);
  PetscReal along[3], o[3];

  FromAxis(motion, t, x, o);
  MotionVelocity(motion, t, along);
  for (int d = 0; d < 3; d++) spin[d] = rate * motion->axis[d];
  Cross3(spin, o, velocity);
  for (int d = 0; d < 3; d++) velocity[d] += along[d];
}

/* MotionCarry - where that of it which was at x at one time is at another. */
void MotionCarry(const SurfaceMotion *motion, PetscReal from, PetscReal to, const PetscReal x[3],
                 PetscReal y[3]) {
  PetscReal shift[3], o[3];

  FromAxis(motion, from, x, o);
  MotionShift(motion, to, shift);
  TurnAbout3(motion->axis, MotionAngle(motion, from, to), o, y);
  for (int d = 0; d < 3; d++) y[d] += shift[d] + motion->at[d];
}

/* How far it is carried along off the straight way, half way between two times. */
static PetscReal OffStraight(const SurfaceMotion *m, PetscReal from, PetscReal to) {
  PetscReal first[3], mid[3], last[3], off = 0;

  if (!m->led) return 0;
  MotionShift(m, from, first);
  MotionShift(m, (from + to) / 2, mid);
  MotionShift(m, to, last);
  for (int d = 0; d < 3; d++) off += PetscSqr(mid[d] - (first[d] + last[d]) / 2);
  return PetscSqrtReal(off);
}

/*
  MotionBow - how far from straight is the way, from one time to another, of that of it which is at
  x in the end? About: of an arc of radius r and angle w it is

    r w^2/8,

  also where w is more than a turn; of n parts of the time each is 1/n^2 of that.
*/
PetscReal MotionBow(const SurfaceMotion *motion, PetscReal from, PetscReal to,
                    const PetscReal x[3]) {
  const PetscReal turned = MotionAngle(motion, from, to);
  PetscReal o[3], across[3];

  if (turned == 0) return OffStraight(motion, from, to);
  FromAxis(motion, to, x, o);
  Cross3(motion->axis, o, across);
  return OffStraight(motion, from, to) + turned * turned / 8 * PetscSqrtReal(Dot3(across, across));
}

/* MotionLed - how far it has been carried along since t = 0, as given in time. */
void MotionLed(const SurfaceMotion *motion, PetscReal t, PetscReal shift[3]) {
  for (int d = 0; d < 3; d++)
    if (motion->lead[d].on)
      shift[d] = LeadValue(&motion->lead[d], t);
    else
      shift[d] = motion->place[d] ? ScheduleValue(motion->place[d], t) : 0;
}

/* MotionVelocity - how fast it is carried along. */
void MotionVelocity(const SurfaceMotion *motion, PetscReal t, PetscReal velocity[3]) {
  for (int d = 0; d < 3; d++)
    if (motion->lead[d].on)
      velocity[d] = LeadRate(&motion->lead[d], t);
    else if (motion->led)
      velocity[d] = motion->place[d] ? ScheduleRate(motion->place[d], t) : 0;
    else
      velocity[d] = motion->velocity[d];
}

/* MotionRate - how fast it turns. */
PetscReal MotionRate(const SurfaceMotion *motion, PetscReal t) {
  if (motion->lead_turn.on) return LeadRate(&motion->lead_turn, t);
  return motion->turn ? ScheduleRate(motion->turn, t) : motion->rate;
}

/* MotionJerks - does it set out or stop at once between two times? */
PetscBool MotionJerks(const SurfaceMotion *motion, PetscReal t0, PetscReal t1) {
  for (int d = 0; d < 3; d++)
    if (motion->place[d] && !motion->lead[d].on && ScheduleJerks(motion->place[d], t0, t1))
      return PETSC_TRUE;
  return (PetscBool)(motion->turn && !motion->lead_turn.on && ScheduleJerks(motion->turn, t0, t1));
}

/* MotionNextTurn - the first time behind t at which it sets out, stops or turns back, in any way;
   PETSC_MAX_REAL if it does not. */
PetscReal MotionNextTurn(const SurfaceMotion *motion, PetscReal t) {
  PetscReal next = PETSC_MAX_REAL;

  if (motion->lead_turn.on)
    next = LeadNextTurn(&motion->lead_turn, t);
  else if (motion->turn)
    next = ScheduleNextTurn(motion->turn, t);
  for (int d = 0; d < 3; d++)
    if (motion->lead[d].on)
      next = SmallerOf(next, LeadNextTurn(&motion->lead[d], t));
    else if (motion->place[d])
      next = SmallerOf(next, ScheduleNextTurn(motion->place[d], t));
  return next;
}
