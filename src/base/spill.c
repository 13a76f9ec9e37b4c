#include "base/spill.h"
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static const size_t large = (size_t)1 << 22; /* from so many bytes on */

/* A file without a name, of so many bytes, which the disk has; -1: there is none. */
static int Unnamed(size_t bytes) {
  static const char *const place[] = {NULL, "/var/tmp", "/tmp"};

  for (int k = 0; k < 3; k++) {
    const char *folder = k ? place[k] : getenv("TMPDIR");
    char path[PETSC_MAX_PATH_LEN];
    int file;
    if (!folder || !*folder) continue;
    (void)snprintf(path, sizeof(path), "%s/tendril-XXXXXX", folder);
    file = mkstemp(path);
    if (file < 0) continue;
    (void)unlink(path);
    if (!posix_fallocate(file, 0, (off_t)bytes)) return file;
    (void)close(file);
  }
  return -1;
}

/* Memory of such a file; NULL: there is none. */
static void *Mapped(size_t bytes) {
  const int file = Unnamed(bytes);
  void *at;

  if (file < 0) return NULL;
  at = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  (void)close(file); /* the memory keeps it */
  return at == MAP_FAILED ? NULL : at;
}

/* SpillNew - so many bytes, all 0; where no disk has them they are plain memory. Not collective;
   the caller ends it with SpillFree(). */
PetscErrorCode SpillNew(size_t bytes, Spill *spill) {
  PetscFunctionBegin;
  *spill = (Spill){.bytes = bytes};
  if (bytes >= large) spill->at = Mapped(bytes);
  spill->mapped = (PetscBool)(spill->at != NULL);
  if (!spill->at) spill->at = calloc(1, bytes);
  PetscCheck(spill->at, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for %zu bytes", bytes);
  PetscFunctionReturn(0);
}

/* SpillGrow - more bytes, of which the first stay what they are. */
PetscErrorCode SpillGrow(size_t used, size_t bytes, Spill *spill) {
  Spill more;

  PetscFunctionBegin;
  PetscCall(SpillNew(bytes, &more));
  if (used) memcpy(more.at, spill->at, used);
  SpillRest(&more);
  SpillFree(spill);
  *spill = more;
  PetscFunctionReturn(0);
}

/* SpillRest - it may leave memory until it is looked at again. */
void SpillRest(const Spill *spill) {
  if (spill->mapped) (void)madvise(spill->at, spill->bytes, MADV_DONTNEED);
}

/* SpillFree - gives it back; what is empty stays so. */
void SpillFree(Spill *spill) {
  if (spill->mapped)
    (void)munmap(spill->at, spill->bytes);
  else
    free(spill->at);
  *spill = (Spill){0};
}
