/* Options: what a value may be, what is refused, files of options.
   test: values of options and of their files are taken or refused */
#include "harness.h"
#include "base/words.h"

/* The line that a value is refused in; NULL: it is taken. */
static const char *RealFault(const char *name, const char *text, PetscReal *value) {
  static ErrorState errors;

  CHECK(PetscOptionsClear(NULL));
  CHECK(PetscOptionsSetValue(NULL, name, text));
  CHECK(ErrorsBegin(PETSC_COMM_WORLD, PETSC_TRUE, &errors));
  if (OptionReal(name, value, NULL)) (void)errors;
  CHECK(ErrorsEnd());
  return errors.message[0] ? errors.message : NULL;
}

static void TestUnits(void **state) {
  const PetscReal scale[UNIT_ALL] = {[UNIT_LENGTH] = 0.02, [UNIT_FORCE] = 0.5, [UNIT_TIME] = 4};
  static const struct {
    const char *name, *text;
    PetscReal value;
  } good[] = {{"-stop_length", "28cm", 14},
              {"-stop_length", "0.28 m", 14},
              {"-stop_length", "14", 14},
              {"-stop_length", "10in", 12.7},
              {"-stop_length", "1 ft", 15.24},
              {"-stop_length", "500mil", 0.635},
              {"-stop_length", "6Fr", 0.1},
              {"-si_speed", "2ft/min", 0.01016},
              {"-si_bending_stiffness", "2Nin^2", 2 * 0.0254 * 0.0254},
              {"-ts_max_time", "2min", 30},
              {"-tip_force", "500mN", 1},
              {"-tip_force", "500 m N", 1},
              {"-clamp_angle", "90deg", PETSC_PI / 2},
              {"-si_bending_stiffness", "2.5 N mm^2", 2.5e-6}};
  static const struct {
    const char *name, *text, *words;
  } bad[] = {{"-stop_length", "28s", "not a unit of length"},
             {"-stop_length", "0,28", "with a point: 0.28"},
             {"-stop_length", "long", "give a number"},
             {"-friction_mu", "1.5", "too large, give at most 1"},
             {"-friction_mu", "1m", "takes no unit"},
             {"-ts_max_time", "inf", "finite"}};
  const char *line;
  PetscReal value;

  CHECK(OptionsSetScales(scale));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(good); k++) {
    line = RealFault(good[k].name, good[k].text, &value);
    EXPECT(!line && PetscAbsReal(value / good[k].value - 1) < 1e-14, "%s %s: %g, %s", good[k].name,
           good[k].text, (double)value, line ? line : "");
  }
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(bad); k++) {
    line = RealFault(bad[k].name, bad[k].text, &value);
    EXPECT(line && strstr(line, bad[k].words) && strstr(line, bad[k].name), "%s %s: %s",
           bad[k].name, bad[k].text, line ? line : "taken");
  }
  CHECK(PetscOptionsClear(NULL));
  CHECK(OptionsSetScales((const PetscReal[UNIT_ALL]){0}));
}

static void TestNearest(void **state) {
  EXPECT(!strcmp(OptionNearest("-friction_nu"), "-friction_mu"), "%s",
         OptionNearest("-friction_nu"));
  EXPECT(!strcmp(OptionNearest("-ts_maxtime"), "-ts_max_time"), "%s", OptionNearest("-ts_maxtime"));
  EXPECT(!strcmp(OptionNearest("-mu"), "-friction_mu"), "%s", OptionNearest("-mu"));
  EXPECT(!strcmp(OptionNearest("-walls"), "-wall_file"), "%s", OptionNearest("-walls"));
  EXPECT(!OptionNearest("-length"), "%s", OptionNearest("-length")); /* of which several have one */
  EXPECT(!OptionNearest("-xyzzy"), "%s", OptionNearest("-xyzzy"));
}

/* What was given is listed as an options file has it: a negative number is no option. */
static void TestList(void **state) {
  char *text;

  SetOptions("-clamp_angle -0.5 -contact_self -friction_layers 0:1,3:2");
  CHECK(OptionsList(&text));
  EXPECT(strstr(text, "-clamp_angle -0.5\n") && strstr(text, "-contact_self\n") &&
             strstr(text, "-friction_layers 0:1,3:2\n"),
         "%s", text);
  CHECK(PetscFree(text));
  CHECK(PetscOptionsClear(NULL));
}

static void Write(const char *path, const char *text, size_t n) {
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(text, 1, n, file), n);
  assert_int_equal(fclose(file), 0);
}

static void TestFile(void **state) {
  static const char sound[] =
      "\xef\xbb\xbf# a scene\n\n  -friction_mu\t0.5 # half\r\n-contact_self\n"
      "-clamp_angle -0.5";
  static const char *const words[] = {"-friction_mu", "0.5", "-contact_self", "-clamp_angle",
                                      "-0.5"};
  static const struct {
    const char *text, *fault;
    size_t n;
  } bad[] = {{"-a 1 -b 2\n", "line 1: two options on a line, -a and -b", 10},
             {"-a\n-b 1 m\n", "line 2: a blank in the value of -b: 1 m", 10},
             {"-a -b\n", "line 1: two options", 6},
             {"\n\n-a 0\0\n", "line 3: is not a text file", 8},
             {"a 1\n", "line 1: begin the line", 4}};
  char path[64], fault[WORDS_FAULT] = "";
  OptionWords got = {0};

  OpenScratch(path);
  Write(path, sound, sizeof(sound) - 1);
  EXPECT(WordsAddFile(&got, path, fault) && !fault[0], "%s", fault);
  EXPECT(got.n == 5, "%d words", got.n);
  for (int k = 0; k < 5; k++) EXPECT(!strcmp(got.word[k], words[k]), "%s", got.word[k]);
  EXPECT(!strcmp(WordsFile(&got, 0), path) && !WordsFile(&got, 1), "files");
  WordsFree(&got);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(bad); k++) {
    Write(path, bad[k].text, bad[k].n);
    EXPECT(!WordsAddFile(&got, path, fault) && strstr(fault, bad[k].fault), "%d: %s", (int)k,
           fault);
    WordsFree(&got);
  }
  RemoveFile(path);
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(TestUnits),
                                          cmocka_unit_test(TestNearest), cmocka_unit_test(TestList),
                                          cmocka_unit_test(TestFile)};
MAIN(tests)
