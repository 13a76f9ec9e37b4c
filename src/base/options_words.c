/* The command line and the options files as they stand, before PETSc takes them: it ignores
   silently what belongs to no option, and reads files too early for a plain message. */
#include "base/options.h"
#include <ctype.h>
#include <sys/stat.h>

static PetscBool IsOption(const char *word) {
  return (PetscBool)(word[0] == '-' && isalpha((unsigned char)word[1]));
}

/* What is wrong with word i, or NULL. A word after an option is its value. */
static const char *WordFault(char **argv, int i, char *text, size_t length) {
  if (!strncmp(argv[i], "--", 2))
    (void)snprintf(text, length, "%s: options have one dash, %s", argv[i], argv[i] + 1);
  else if (!IsOption(argv[i]) && !(i > 1 && IsOption(argv[i - 1])))
    (void)snprintf(text, length, "%s: a word without an option; did you mean -%s?", argv[i],
                   argv[i]);
  else
    return NULL;
  return text;
}

/* Why a file of options cannot be one, or NULL; line is where. */
static const char *FileFault(const char *file, int *line, char *text, size_t length) {
  char row[4096];
  struct stat status;
  const char *fault = NULL;
  FILE *f;

  *line = 0;
  if (stat(file, &status)) return "is not there";
  if (S_ISDIR(status.st_mode)) return "is a directory";
  f = fopen(file, "r");
  if (!f) return "cannot be read";
  while (!fault && fgets(row, sizeof(row), f)) {
    const char *word = row + strspn(row, " \t\r\n");
    ++*line;
    for (const char *c = row; *c; c++)
      if (!isprint((unsigned char)*c) && !isspace((unsigned char)*c) && !((unsigned char)*c & 0x80))
        fault = "is not a text file";
    if (!fault && *word && !strchr("#!%", *word) && *word != '-') {
      (void)snprintf(text, length, "begin the line with - or #: %.60s", word);
      text[strcspn(text, "\r\n")] = 0;
      fault = text;
    }
  }
  fclose(f);
  return fault;
}

static const char *OptionsFileFault(int argc, char **argv, int i, char *text, size_t length) {
  char detail[128];
  const char *fault;
  int line;

  if (i + 1 == argc || IsOption(argv[i + 1])) {
    (void)snprintf(text, length, "-options_file: give the name of a file");
    return text;
  }
  fault = FileFault(argv[i + 1], &line, detail, sizeof(detail));
  if (!fault) return NULL;
  if (line)
    (void)snprintf(text, length, "-options_file %s: %s (line %d)", argv[i + 1], fault, line);
  else
    (void)snprintf(text, length, "-options_file %s: %s", argv[i + 1], fault);
  return text;
}

/*
  OptionsCheckWords - refuses words on the command line that belong to no option (a forgotten dash),
  names with two dashes, and options files that cannot be read as such. Before PetscInitialize(),
  after MPI_Init(); returns 0 if all is well, else the line is out.
*/
int OptionsCheckWords(int argc, char **argv) {
  char text[PETSC_MAX_PATH_LEN + 256];
  const char *fault = NULL;
  int rank;

  for (int i = 1; i < argc && !fault; i++) {
    fault = WordFault(argv, i, text, sizeof(text));
    if (!fault && !strcmp(argv[i], "-options_file"))
      fault = OptionsFileFault(argc, argv, i, text, sizeof(text));
  }
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (fault && !rank) fprintf(stderr, "tendril: %s\n", fault);
  return fault != NULL;
}
