/* The command line as it stands, before PETSc takes it, which drops without a word what belongs to
   no option, and reads options files too early for a plain message. */
#include "base/options.h"
#include "base/words.h"
#include <ctype.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static PetscBool IsNumber(const char *word) {
  char *end;
  (void)strtod(word, &end);
  return (PetscBool)(end != word && !*end);
}

/* What to do about a word that belongs to no option: behind one and its value, or alone. */
static void StrayWord(char **argv, int i, char fault[WORDS_FAULT]) {
  const char *word = argv[i];
  struct stat status;
  char name[80];

  (void)snprintf(name, sizeof(name), "-%s", word);
  if (!stat(word, &status) || strstr(word, ".opts"))
    (void)snprintf(fault, WORDS_FAULT, "%s: a word without an option; give it as -options_file %s",
                   word, word);
  else if (i > 2 && WordIsOption(argv[i - 2]) && IsNumber(argv[i - 1]) && IsNumber(word))
    (void)snprintf(fault, WORDS_FAULT,
                   "%s %s %s: a value has no blank; put commas between numbers, %s,%s", argv[i - 2],
                   argv[i - 1], word, argv[i - 1], word);
  else if (i > 2 && WordIsOption(argv[i - 2]) && IsNumber(argv[i - 1]) && !OptionFind(name))
    (void)snprintf(fault, WORDS_FAULT,
                   "%s %s %s: a value has no blank; write a unit right behind the number, %s%s",
                   argv[i - 2], argv[i - 1], word, argv[i - 1], word);
  else if (OptionNearest(name))
    (void)snprintf(fault, WORDS_FAULT, "%s: a word without an option; did you mean %s?", word,
                   OptionNearest(name));
  else
    (void)snprintf(fault, WORDS_FAULT,
                   "%s: a word without an option; give -NAME VALUE, -help lists the names", word);
}

/* Is there anything wrong with word i? One after an option is its value. */
static PetscBool WordFault(char **argv, int i, char fault[WORDS_FAULT]) {
  if (!strncmp(argv[i], "--", 2))
    (void)snprintf(fault, WORDS_FAULT, "%s: options have one dash, %s", argv[i], argv[i] + 1);
  else if (!WordIsOption(argv[i]) && !(i > 1 && WordIsOption(argv[i - 1])))
    StrayWord(argv, i, fault);
  else if (strlen(argv[i]) >= PETSC_MAX_PATH_LEN)
    (void)snprintf(fault, WORDS_FAULT, "%.60s...: has more than %d characters",
                   WordIsOption(argv[i]) ? argv[i] : argv[i - 1], PETSC_MAX_PATH_LEN - 1);
  return (PetscBool)(fault[0] != 0);
}

/*
  OptionsTakeWords - checks the words of the command line and puts those of options files in their
  place. Before PetscInitialize(), after MPI_Init(); the caller ends it with OptionsFreeWords().

  line        keeps what was given and what PETSc gets
  argc, argv  as main() has them; on exit what PETSc is to have

  Words that belong to no option (a forgotten dash), names with two dashes, and options files
  that cannot be read as such are refused. Returns 0 if all is well, else the line is out.
*/
int OptionsTakeWords(CommandLine *line, int *argc, char ***argv) {
  char fault[WORDS_FAULT] = "", **word = *argv;
  int rank, ranks;

  line->given_n = *argc;
  line->given = *argv;
  for (int i = 0; i < *argc; i++) {
    if (i && WordFault(word, i, fault)) break;
    if (!i || strcmp(word[i], "-options_file"))
      WordsAdd(&line->taken, word[i]);
    else if (i + 1 == *argc || WordIsOption(word[i + 1]))
      (void)snprintf(fault, sizeof(fault), "-options_file: give the name of a file");
    else
      (void)WordsAddFile(&line->taken, word[++i], fault);
    if (fault[0]) break;
  }
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  if (fault[0] && !rank) fprintf(stderr, "tendril: %s\n", fault);
  if (fault[0] && !rank && ranks > 1) (void)usleep(100000); /* mpiexec may drop the last words */
  *argc = line->taken.n;
  *argv = line->taken.word;
  return fault[0] != 0;
}

/* OptionsFreeWords - frees what OptionsTakeWords() has made, which PETSc has until its end. */
void OptionsFreeWords(CommandLine *line) {
  WordsFree(&line->taken);
}

/* OptionOnCommandLine - does the command line itself have this option, or only an options file? */
PetscBool OptionOnCommandLine(const char *name) {
  const CommandLine *line = OptionsLine();

  for (int i = 1; line && i < line->given_n; i++)
    if (!strcmp(line->given[i], name)) return PETSC_TRUE;
  return PETSC_FALSE;
}
