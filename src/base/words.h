/* Words of a command line, with those of options files in their place. */
#ifndef TENDRIL_WORDS_H
#define TENDRIL_WORDS_H

#include <petscsys.h>

enum { WORDS_FAULT = PETSC_MAX_PATH_LEN + 512 };

/* A section of an options file: its head, as "rod tap", and the options below it. */
typedef struct {
  char *head, *file;
  int line; /* of the head */
  int n, room;
  struct SectionOption {
    char *name, *value; /* value NULL: given without one */
    int line;
  } * option;
} OptionSection;

typedef struct OptionWords {
  int n, room;
  char **word;               /* [n], and a NULL behind them as in main() */
  struct OptionWords *files; /* the names of the files that were read for them; NULL: none */
  int sections;
  OptionSection *section;
} OptionWords;

PetscBool WordIsOption(const char *word);
void WordsAdd(OptionWords *words, const char *word);
void WordsFree(OptionWords *words);
void SectionDrop(OptionSection *section, int i);
PetscBool WordsAddFile(OptionWords *words, const char *file, char fault[WORDS_FAULT]);
PetscBool WordsAddText(OptionWords *words, const char *file, char *text, char fault[WORDS_FAULT]);

/* the options files that were read, the k-th; NULL: there are no more */
const char *WordsFile(const OptionWords *words, int k);

#endif
