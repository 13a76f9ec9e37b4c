#include "base/text.h"
#include "base/options.h"

/* TextRead - the text of a file, on all ranks, without the byte order mark that an editor may have
   put before it; the caller frees it (PetscFree). Collective on OptionsComm().

   option, file  which, and the option that named it */
PetscErrorCode TextRead(const char *option, const char *file, char **text) {
  enum { LARGEST = 1 << 24 };
  static const char mark[] = "\xef\xbb\xbf";
  PetscMPIInt rank, size = -1;

  PetscFunctionBegin;
  *text = NULL;
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &rank));
  if (!rank) {
    FILE *f = fopen(file, "r");
    if (f) {
      PetscCall(PetscMalloc1(LARGEST + 1, text));
      size = (PetscMPIInt)fread(*text, 1, LARGEST + 1, f);
      if (ferror(f)) size = -1;
      (void)fclose(f);
    }
  }
  PetscCallMPI(MPI_Bcast(&size, 1, MPI_INT, 0, OptionsComm()));
  if (size < 0 || size > LARGEST) PetscCall(PetscFree(*text));
  UserCheck(size >= 0, OptionsComm(), "%s %s: no such file, or it cannot be read", option, file);
  UserCheck(size <= LARGEST, OptionsComm(), "%s %s: is larger than 16 MB", option, file);
  if (rank) PetscCall(PetscMalloc1(size + 1, text));
  PetscCallMPI(MPI_Bcast(*text, size, MPI_CHAR, 0, OptionsComm()));
  (*text)[size] = 0;
  UserCheck(strlen(*text) == (size_t)size, OptionsComm(), "%s %s: is no text", option, file);
  if (!strncmp(*text, mark, strlen(mark)))
    (void)memmove(*text, *text + strlen(mark), (size_t)size + 1 - strlen(mark));
  PetscFunctionReturn(0);
}

/* TextWords - the words of a line, in place, with these letters between them; returns how many. */
PetscInt TextWords(char *line, const char *between, PetscInt room, char *word[]) {
  PetscInt n = 0;

  for (char *c = strtok(line, between); c && n < room; c = strtok(NULL, between)) word[n++] = c;
  return n;
}
