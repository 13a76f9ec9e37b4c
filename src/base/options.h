/* Options. Each module declares its own as rows of a table; all rows together are the reference
   manual (-help, docs/options.md), say which files a run reads and writes and what a restart keeps,
   and tell a mistyped name from one that this run has no use for. */
#ifndef TENDRIL_OPTIONS_H
#define TENDRIL_OPTIONS_H

#include "base/errors.h"
#include "base/own.h"
#include "base/words.h"

typedef enum { KIND_REAL, KIND_INT, KIND_BOOL, KIND_WORD, KIND_TEXT } OptionKind;

/* What a quantity is measured in: laboratory units are converted by its scale (scene/si.h). */
typedef enum {
  UNIT_NONE,
  UNIT_LENGTH,
  UNIT_FORCE,
  UNIT_TIME,
  UNIT_SPEED,
  UNIT_ENERGY,
  UNIT_POWER,
  UNIT_CURVATURE,
  UNIT_ANGLE,
  UNIT_LOAD, /* force per length; behind the others, whose numbers files have */
  UNIT_ALL,
  /* those of the -si_ options, which are in SI units if they carry none */
  SI_STIFFNESS = UNIT_ALL,
  SI_DRY,
  SI_VISCOUS,
  SI_SPEED,
  UNIT_RATE, /* 1 over UNIT_TIME, radians as they are */
  DIMENSIONS
} Dimension;

enum {
  INPUT_FILE = 1,  /* names a file that is read */
  OUTPUT_FILE = 2, /* names a file that is written */
  PASSING = 4,     /* says how a run was run, not what it was: a restart does not keep it */
  EVENT = 8,       /* ends a run: a restart of one that has ended there does not keep it */
  PETSCS = 16,     /* PETSc reads it, tendril only checks it */
  LATE = 32,       /* PETSc reads it only deep in a solve, or at its end */
  IN_PLACE = 64,   /* an input file that may be written over */
  SHARED = 128,    /* PETSc reads it as well as tendril */
  PROGRAM = 256,   /* of the program as a whole: no member of a sweep has it */
  PART = 512,      /* without a unit it may be a part of the rod */
  OF_SCENE = 1024  /* in a group of what each rod may have: of all of them */
};

typedef struct {
  const char *name; /* with its dash */
  OptionKind kind;
  const char *usual;   /* the default, as text; "": none, off unless given */
  PetscReal low, high; /* closed range of a number */
  const char *words;   /* "one,of,these", or NULL */
  Dimension dimension;
  int flags;
  const char *text; /* meaning, for -help */
} OptionRow;

typedef struct {
  const char *title;
  size_t n;
  const OptionRow *rows;
  PetscBool of_rod; /* each of several rods may have its own */
} OptionGroup;

#define ROW_REAL(name, usual, low, high, dimension, flags, text)                                   \
  { name, KIND_REAL, usual, low, high, NULL, dimension, flags, text }
#define ROW_INT(name, usual, low, high, flags, text)                                               \
  { name, KIND_INT, usual, low, high, NULL, UNIT_NONE, flags, text }
#define ROW_BOOL(name, usual, flags, text)                                                         \
  { name, KIND_BOOL, usual, 0, 0, NULL, UNIT_NONE, flags, text }
#define ROW_WORD(name, usual, words, flags, text)                                                  \
  { name, KIND_WORD, usual, 0, 0, words, UNIT_NONE, flags, text }
#define ROW_TEXT(name, flags, text)                                                                \
  { name, KIND_TEXT, "", 0, 0, NULL, UNIT_NONE, flags, text }
#define OPTION_GROUP(title, rows)                                                                  \
  { title, PETSC_STATIC_ARRAY_LENGTH(rows), rows, PETSC_FALSE }
#define OPTION_GROUP_OF_ROD(title, rows)                                                           \
  { title, PETSC_STATIC_ARRAY_LENGTH(rows), rows, PETSC_TRUE }

/* options_petsc.c: PETSc's own */
extern const OptionGroup petsc_options;
PetscErrorCode OptionsRename(PetscBool new_names);

/* options_table.c: the table */
void OptionsSetTable(size_t n, const OptionGroup *const groups[]);
const OptionRow *OptionFind(const char *name);
const OptionRow *OptionNext(size_t *place);
PetscBool OptionOfRod(const char *name);
void OptionsHelp(FILE *file);
const char *OptionNearest(const char *name);

/* The command line as it was given, and as PETSc gets it: with the words of options files. */
typedef struct {
  int given_n;
  char *const *given; /* borrowed */
  OptionWords taken;
} CommandLine;

typedef struct _Reading *Reading;

/* options.c: reading */
MPI_Comm OptionsComm(void);
PetscErrorCode ReadingCreate(MPI_Comm comm, PetscOptions options, const CommandLine *line,
                             Reading *reading);
PetscErrorCode ReadingSetLaw(Reading reading, OwnKind kind, OwnLaw *law);
PetscErrorCode ReadingDestroy(Reading *reading);
PetscErrorCode OptionsEnter(Reading reading);
PetscErrorCode OptionsLeave(void);
PetscErrorCode OptionsPush(MPI_Comm comm, PetscOptions options, const CommandLine *line);
PetscErrorCode OptionsPop(void);
const CommandLine *OptionsLine(void);
OwnLaw *OptionsLaw(OwnKind kind);
PetscBool OptionsPushed(void);
PetscErrorCode OptionsSetScales(const PetscReal scale[UNIT_ALL]);
PetscReal OptionsScale(Dimension dimension);
PetscErrorCode OptionReal(const char *name, PetscReal *value, PetscBool *set);
PetscErrorCode OptionInt(const char *name, PetscInt *value, PetscBool *set);
PetscErrorCode OptionBool(const char *name, PetscBool *value, PetscBool *set);
PetscErrorCode OptionWord(const char *name, PetscInt *choice, PetscBool *set);
PetscErrorCode OptionText(const char *name, char value[PETSC_MAX_PATH_LEN], PetscBool *set);
PetscErrorCode OptionPut(const char *name, const char *value);
PetscErrorCode OptionQuantity(const char *option, const char *text, Dimension dimension,
                              PetscReal *value);
PetscErrorCode OptionTakeOffUnit(const OptionRow *row);
const char *OptionSaid(const char *name);
PetscErrorCode OptionCheck(const OptionRow *row);
PetscErrorCode OptionGiven(const char *name, PetscBool *given);
PetscErrorCode OptionDefault(const char *name, const char *format, ...);
const char *OptionNumber(PetscReal value, char text[32]);

/* options_units.c: the laboratory's units */
PetscBool OptionIsLength(const char *unit);
PetscErrorCode OptionUnit(const char *what, const char *unit, Dimension dimension,
                          PetscReal *factor);
const char *OptionShownIn(PetscReal value, Dimension dimension, PetscReal *factor);
const char *OptionInLaboratory(PetscReal value, Dimension dimension, char text[32]);
const char *OptionBoth(PetscReal value, Dimension dimension, char text[64]);

/* options_vector.c */
PetscErrorCode OptionVector(const char *name, Dimension dimension, PetscReal v[3],
                            PetscBool *given);

const char *OptionPlace(const PetscReal x[3], char text[96]);

/* options_use.c: what was given, as a whole */
PetscErrorCode OptionsCheckPetsc(void);
PetscErrorCode OptionsCheckTypes(void);
PetscErrorCode OptionsBegin(const char *start, PetscBool *any);
PetscErrorCode OptionsRefuseUnread(void);
PetscErrorCode OptionsRefuseLeft(void);
PetscErrorCode OptionsRefuseOverwrite(const char *option, const char *output);
PetscErrorCode OptionsRefuseStrange(const char *name);
PetscErrorCode OptionsRefuse(const char *name);
PetscBool OptionOfPetsc(const char *name);
PetscErrorCode OptionsList(char **text);
PetscErrorCode OptionsInForce(char **text);
void OptionsReadLines(const char *option, const char *file);
void OptionsAtLine(int line);
void OptionsKeepPlain(Dimension dimension, PetscReal value);
PetscErrorCode OptionsTellPlain(void);

/* options_words.c: the command line and options files, before PETSc takes them */
int OptionsTakeWords(CommandLine *line, int *argc, char ***argv);
void OptionsFreeWords(CommandLine *line);
PetscBool OptionOnCommandLine(const char *name);

#endif
