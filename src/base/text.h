/* Text files, on all ranks. */
#ifndef TENDRIL_TEXT_H
#define TENDRIL_TEXT_H

#include <petscsys.h>

PetscErrorCode TextRead(const char *option, const char *file, char **text);
PetscInt TextWords(char *line, const char *between, PetscInt room, char *word[]);

#endif
