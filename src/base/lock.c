#include "base/lock.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SAID = 256 };

/* A lock is a file beside the one it is about, locked by flock(): that of a process that was killed
   is locked no more, so nobody need take it away. */
typedef struct Lock {
  char *path, *file; /* what it is about, its own */
  int handle;
  pid_t owner; /* a child has not what its parent has */
  struct Lock *next;
} Lock;

static Lock *held; /* on rank 0 */

/* Opens the lock's file and locks it; -1 with errno. One that its last owner has just taken away is
   no lock any more: then once more. */
static int Open(const char *file) {
  for (;;) {
    struct stat here, there;
    int handle = open(file, O_RDWR | O_CREAT | O_CLOEXEC, 0666), fault;

    if (handle < 0) return -1;
    if (flock(handle, LOCK_EX | LOCK_NB)) {
      fault = errno;
      (void)close(handle);
      errno = fault;
      return -1;
    }
    if (!fstat(handle, &here) && !stat(file, &there) && here.st_ino == there.st_ino) return handle;
    (void)close(handle);
  }
}

/* Who holds it, as it has written there. */
static void Holder(const char *file, char who[SAID]) {
  FILE *f = fopen(file, "r");

  (void)snprintf(who, SAID, "another process");
  if (f && !fgets(who, SAID, f)) (void)snprintf(who, SAID, "another process");
  who[strcspn(who, "\n")] = 0;
  if (f) (void)fclose(f);
}

/* On rank 0. Where no lock can be had (a file system that has none, a directory that is not ours, a
   full disk), the run goes on: what cannot be written shows when it is. */
static PetscErrorCode Take(const char *path, char who[SAID]) {
  char host[64] = "";
  Lock *self;

  PetscFunctionBegin;
  who[0] = 0;
  for (self = held; self; self = self->next)
    if (!strcmp(self->path, path) && self->owner == getpid()) PetscFunctionReturn(0);
  PetscCall(PetscNew(&self));
  self->owner = getpid();
  PetscCall(PetscStrallocpy(path, &self->path));
  PetscCall(PetscMalloc1(strlen(path) + 8, &self->file));
  (void)snprintf(self->file, strlen(path) + 8, "%s.lock", path);
  self->handle = Open(self->file);
  self->next = held;
  held = self;
  if (self->handle >= 0) {
    (void)gethostname(host, sizeof(host) - 1);
    if (!ftruncate(self->handle, 0))
      (void)!dprintf(self->handle, "process %ld on %s\n", (long)getpid(), host);
  } else if (errno == EWOULDBLOCK)
    Holder(self->file, who);
  if (who[0]) PetscCall(LockGive(path));
  PetscFunctionReturn(0);
}

/*
  LockTake - from here on no other run writes this file. Collective on comm; LockGive() ends it, or
  the end of the process.

  option, path  of the file, for the message

  A file that another process is writing is a user's mistake.
*/
PetscErrorCode LockTake(MPI_Comm comm, const char *option, const char *path) {
  char who[SAID] = "";
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) PetscCall(Take(path, who));
  PetscCallMPI(MPI_Bcast(who, SAID, MPI_CHAR, 0, comm));
  UserCheck(!who[0], comm, "%s %s: is being written by %s; name another file, or wait for its end",
            option, path, who);
  PetscFunctionReturn(0);
}

static void Give(Lock *self) {
  if (self->handle >= 0) {
    (void)unlink(self->file); /* while it is locked: who waits for its name makes a new one */
    (void)close(self->handle);
  }
  (void)PetscFree(self->path);
  (void)PetscFree(self->file);
  (void)PetscFree(self);
}

/* LockGive - ends LockTake(), on rank 0; nothing if there is none. Not collective. */
PetscErrorCode LockGive(const char *path) {
  PetscFunctionBegin;
  for (Lock **at = &held; *at; at = &(*at)->next)
    if (!strcmp((*at)->path, path)) {
      Lock *self = *at;
      *at = self->next;
      Give(self);
      break;
    }
  PetscFunctionReturn(0);
}

/* LocksEnd - gives what is still held; before PetscFinalize(). */
void LocksEnd(void) {
  while (held) {
    Lock *self = held;
    held = self->next;
    Give(self);
  }
}
