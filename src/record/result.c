/* A result file of any task: where it may be made, and what it says of its making. */
#include "base/lock.h"
#include "record/output.h"
#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const meaning_of_units =
    "l = (YI/N)^(1/3), N the friction per length at the speed V of the tip, YI the bending "
    "stiffness; "
    "si_length and the like, if given, say what 1 is in SI units";

/* OutputParameters - the value of each option in force, defaults included. */
PetscErrorCode OutputParameters(HdfFile file) {
  char *all, name[128];

  PetscFunctionBegin;
  PetscCall(OptionsInForce(&all));
  for (char *line = strtok(all, "\n"); line; line = strtok(NULL, "\n")) {
    char *value = line + strcspn(line, " ");
    const OptionRow *row;
    *value++ = 0;
    (void)snprintf(name, sizeof(name), "-%s", line);
    row = OptionFind(name);
    (void)snprintf(name, sizeof(name), "parameters/%s", line);
    if (row->kind == KIND_REAL)
      PetscCall(HdfReal(file, "/", name, strtod(value, NULL)));
    else if (row->kind == KIND_INT)
      PetscCall(HdfInt(file, "/", name, (int)strtol(value, NULL, 10)));
    else
      PetscCall(HdfText(file, "/", name, value));
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* OutputVersions - what wrote a result, and what its units mean. */
PetscErrorCode OutputVersions(HdfFile file) {
  char version[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(version, sizeof(version), "%d.%d.%d", PETSC_VERSION_MAJOR,
                          PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR));
  PetscCall(HdfText(file, "/", "version", TENDRIL_VERSION));
  PetscCall(HdfText(file, "/", "petsc_version", version));
  PetscCall(HdfText(file, "/", "units", meaning_of_units));
  PetscFunctionReturn(0);
}

/* OutputAttributes - what a result is of: options, versions, ranks; and whether it is finished. */
PetscErrorCode OutputAttributes(HdfFile file, MPI_Comm comm, PetscBool finished) {
  char *options;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCall(OptionsList(&options));
  PetscCall(HdfText(file, "/", "options", options));
  PetscCall(PetscFree(options));
  PetscCall(OutputParameters(file));
  PetscCall(OutputVersions(file));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(HdfInt(file, "/", "ranks", ranks));
  PetscCall(HdfInt(file, "/", "finished", finished));
  PetscFunctionReturn(0);
}

/* What keeps files from being made in the directory of a path, as errno has it; 0: nothing. */
static int Closed(const char *path, char directory[PETSC_MAX_PATH_LEN]) {
  const char *slash = strrchr(path, '/');
  struct stat status;

  (void)snprintf(directory, PETSC_MAX_PATH_LEN, "%.*s", slash ? (int)(slash - path) : 1,
                 slash ? path : ".");
  if (stat(directory[0] ? directory : "/", &status)) return errno;
  if (!S_ISDIR(status.st_mode)) return ENOTDIR;
  return access(directory[0] ? directory : "/", W_OK | X_OK) ? errno : 0;
}

/* Before anything is computed: is there the directory that the file is to be in? Collective. */
static PetscErrorCode RefuseNowhere(const char *option, const char *path) {
  char directory[PETSC_MAX_PATH_LEN];
  PetscMPIInt rank;
  int fault;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &rank));
  fault = Closed(path, directory);
  PetscCallMPI(MPI_Bcast(&fault, 1, MPI_INT, 0, OptionsComm()));
  UserCheck(fault != ENOENT, OptionsComm(),
            "%s %s: there is no directory %s; make it (mkdir -p %s), or name a file elsewhere",
            option, path, directory, directory);
  UserCheck(!fault, OptionsComm(), "%s %s: no file can be made there: %s; name a file elsewhere",
            option, path, strerror(fault));
  PetscFunctionReturn(0);
}

/* OutputRefuse - refuses to write over what is no result of tendril, or an input, and where no file
   can be made. Collective. */
PetscErrorCode OutputRefuse(const char *option, const char *path) {
  struct stat status;
  PetscBool ours;
  int free;

  PetscFunctionBegin;
  PetscCall(OptionsRefuseOverwrite(option, path));
  PetscCall(HdfHas(path, "version", &ours));
  /* rank 0 looks for all: when a later one does, the file may be that of this very run */
  free = stat(path, &status) || (S_ISREG(status.st_mode) && !status.st_size);
  PetscCallMPI(MPI_Bcast(&free, 1, MPI_INT, 0, OptionsComm()));
  UserCheck(ours || free, OptionsComm(),
            "%s %s: is there, and is no result of tendril; name another file, or take it away",
            option, path);
  PetscCall(RefuseNowhere(option, path));
  PetscFunctionReturn(0);
}

/* OutputRefuseTaken - as OutputRefuse(); nor does a single run take the place of a whole sweep, or
   write what another process is writing. */
PetscErrorCode OutputRefuseTaken(const char *option, const char *path) {
  PetscBool sweep;

  PetscFunctionBegin;
  PetscCall(OutputRefuse(option, path));
  PetscCall(HdfHas(path, "/status", &sweep));
  UserCheck(!sweep, OptionsComm(), "%s %s: holds a sweep; name another file, or take it away",
            option, path);
  /* files of a sweep's members are in the sweep's keeping */
  if (!OptionsPushed()) PetscCall(LockTake(OptionsComm(), option, path));
  PetscFunctionReturn(0);
}

/* All ranks learn what rank 0 has met. */
static PetscErrorCode Verdict(const char *option, const char *path, MPI_Comm comm,
                              char fault[HDF_FAULT]) {
  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(fault, HDF_FAULT, MPI_CHAR, 0, comm));
  UserCheck(!fault[0], comm, "%s %s: cannot be written: %s; make room, or name a file elsewhere",
            option, path, fault);
  PetscFunctionReturn(0);
}

/* OutputNewFile - a new result file, on rank 0 (on the others it is NULL). Collective; the caller
   ends it with OutputEndFile(). A path that cannot be written is a user's mistake. */
PetscErrorCode OutputNewFile(const char *option, const char *path, MPI_Comm comm, HdfFile *file) {
  char fault[HDF_FAULT] = "";
  PetscMPIInt rank;

  PetscFunctionBegin;
  *file = NULL;
  PetscCall(OutputRefuseTaken(option, path));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) {
    PetscCall(HdfCreate(path, file));
    if (HdfFault(*file)) PetscCall(HdfClose(file, fault));
  }
  PetscCall(Verdict(option, path, comm, fault));
  PetscFunctionReturn(0);
}

/* OutputEndFile - ends what OutputNewFile() began. Collective. */
PetscErrorCode OutputEndFile(const char *option, const char *path, MPI_Comm comm, HdfFile *file) {
  char fault[HDF_FAULT] = "";

  PetscFunctionBegin;
  PetscCall(HdfClose(file, fault));
  PetscCall(LockGive(path));
  PetscCall(Verdict(option, path, comm, fault));
  PetscFunctionReturn(0);
}

/* OutputDropFile - ends it without a result. */
PetscErrorCode OutputDropFile(const char *path, HdfFile *file) {
  PetscFunctionBegin;
  PetscCall(HdfDrop(file));
  PetscCall(LockGive(path));
  PetscFunctionReturn(0);
}
