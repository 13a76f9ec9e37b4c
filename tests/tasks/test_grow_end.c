/* What is said at the beginning of a run, and at its end, of the rod as it is then.
   test: a run says how it ended by what the rod does */
#include "harness.h"
#include "stepping/estimating.h"
#include "tasks/growing.h"

/* A run that has begun, and nothing more. */
static void Create(const char *options, Grow *self) {
  *self = (Grow){0};
  SetOptions("-growth_initial_length 1 -rod_cells 20 -ts_max_time 1 %s", options);
  CHECK(SceneCreate(&self->scene));
  CHECK(GrowCreate(self, "", ""));
}

static void Destroy(Grow *self) {
  CHECK(GrowDestroy(self));
  CHECK(SceneDestroy(&self->scene));
}

/* The line with which it gives up. */
static const char *LastLine(Grow *self) {
  static ErrorState errors;
  PetscErrorCode error;
  PetscBool again;

  self->quiet = PETSC_TRUE;
  self->reason = TS_DIVERGED_STEP_REJECTED;
  CHECK(ErrorsBegin(PETSC_COMM_SELF, PETSC_TRUE, &errors));
  error = GrowFinish(self, &again);
  CHECK(ErrorsEnd());
  EXPECT(error, "does not give up");
  return errors.message;
}

/* What it prints when it has come through. */
static void Summary(Grow *self, char text[8192]) {
  FILE *const out = PETSC_STDOUT, *const file = tmpfile();
  PetscBool again;
  size_t n;

  EXPECT(file, "no scratch file");
  self->reason = TS_CONVERGED_TIME;
  PETSC_STDOUT = file;
  CHECK(GrowFinish(self, &again));
  PETSC_STDOUT = out;
  rewind(file);
  n = fread(text, 1, 8191, file);
  text[n] = 0;
  fclose(file);
}

/* A rod in space that spins far faster than anything drives it turns over: its spin is held by
   nothing. */
static void TestSpins(void **state) {
  Grow self;
  const char *line;

  (void)state;
  Create("-growth_type feed -rod_model space", &self);
  self.seen.tip_spin = 1e5;
  line = LastLine(&self);
  EXPECT(strstr(line, "-friction_radius"), "spin 1e5: %s", line);
  self.seen.tip_spin = 1e3;
  line = LastLine(&self);
  EXPECT(!strstr(line, "-friction_radius"), "spin 1e3: %s", line);
  Destroy(&self);
}

/* A rod that presses on a wall, and is all but straight, has nothing that says to which side it
   gives way; one that is bent has. */
static void TestPressed(void **state) {
  const char *line;
  Grow self;

  (void)state;
  Create("-growth_type feed", &self);
  self.seen.contacts = 1;
  self.seen.max_angle = 1e-3;
  line = LastLine(&self);
  EXPECT(strstr(line, "pressed straight"), "angle 1e-3: %s", line);
  self.seen.max_angle = 0.1;
  line = LastLine(&self);
  EXPECT(!strstr(line, "pressed straight"), "angle 0.1: %s", line);
  Destroy(&self);
}

/* The cells that are advised to a rod whose tip is held, under a force that bends it in waves of so
   many cells; 0: none. */
static double AdvisedAt(double cells) {
  const PetscReal wave = cells / 20; /* 2 pi sqrt(B/P) */
  const char *line, *cells_at;
  double advised = 0;
  Grow self;

  Create("-growth_type uniform -tip_type clamped", &self);
  self.force_before = PetscSqr(2 * PETSC_PI / wave);
  line = LastLine(&self);
  cells_at = strstr(line, "give -rod_cells ");
  if (strstr(line, "waves") && cells_at) advised = atof(cells_at + strlen("give -rod_cells "));
  Destroy(&self);
  return advised;
}

/* Cells that are long beside the waves of a rod which cannot give way chatter; with those that are
   advised they are short, and not by far. */
static void TestWaves(void **state) {
  double cells = AdvisedAt(20);

  (void)state;
  EXPECT(cells == 0, "waves of 20 cells: %g", cells);
  cells = AdvisedAt(3);
  EXPECT(3 * cells / 20 > 8 && 3 * cells / 20 < 30, "waves of 3 cells: %g cells, %g in a wave",
         cells, 3 * cells / 20);
}

/* What rigid contact would do is said as long as the error of soft contact is small. */
static void TestRigid(void **state) {
  char text[8192];
  Grow self;

  (void)state;
  for (int k = 0; k < 2; k++) {
    Create("-growth_type feed -contact_self true -contact_diameter 0.01", &self);
    self.kept.pressed = PETSC_TRUE;
    self.seen.t = 1;
    self.estimate->now[ESTIMATE_SOFT][ESTIMATE_TIP] = k ? 0.5 : 0.02;
    Summary(&self, text);
    EXPECT((strstr(text, "in rigid contact") != NULL) == !k, "%d: %s", k, text);
    Destroy(&self);
  }
}

/* A rod that began straight stayed so if there is nothing but round-off across. */
static void TestStraight(void **state) {
  char text[8192];
  Grow self;

  (void)state;
  for (int k = 0; k < 2; k++) {
    Create("-growth_type feed -shape_type straight", &self);
    self.seen.t = 1;
    self.seen.max_angle = k ? 2e-11 : 1e-15;
    Summary(&self, text);
    EXPECT((strstr(text, "stayed straight") != NULL) == !k, "%d: %s", k, text);
    Destroy(&self);
  }
}

/* What is printed as a rod begins above a plane, so far beyond where contact sets in, in parts of
   that distance. */
static void Begins(PetscReal beyond, char text[8192]) {
  const PetscReal smooth = 5e-5; /* of this diameter */
  FILE *const out = PETSC_STDOUT, *const file = tmpfile();
  char wall[64], path[64], options[200];
  size_t n;
  Grow self;

  EXPECT(file, "no scratch file");
  (void)snprintf(wall, sizeof(wall), "plane 0 %.17g 0 1\n",
                 (double)(-0.05 - smooth * (1 - beyond)));
  WriteWalls(path, wall);
  (void)snprintf(options, sizeof(options),
                 "-growth_type feed -shape_type straight -contact_diameter 0.1 -wall_file %s",
                 path);
  PETSC_STDOUT = file;
  Create(options, &self);
  PETSC_STDOUT = out;
  EXPECT(PetscAbsReal(self.scene->contact.smooth / smooth - 1) < 1e-9, "sets in at %g",
         self.scene->contact.smooth);
  Destroy(&self);
  RemoveFile(path);
  rewind(file);
  n = fread(text, 1, 8191, file);
  text[n] = 0;
  fclose(file);
}

/* A rod that begins nearer to a wall than contact sets in is told so, unless it is by next to
   nothing. */
static void TestNearer(void **state) {
  char text[8192];

  (void)state;
  Begins(0.04, text);
  EXPECT(strstr(text, "leave more room"), "by a twenty-fifth: %s", text);
  Begins(2e-4, text);
  EXPECT(!strstr(text, "leave more room"), "by a five-thousandth: %s", text);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestSpins), cmocka_unit_test(TestPressed),  cmocka_unit_test(TestWaves),
    cmocka_unit_test(TestRigid), cmocka_unit_test(TestStraight), cmocka_unit_test(TestNearer)};
MAIN(tests)
