#include "base/hdf.h"
#include <errno.h>
#include <fcntl.h>
#include <hdf5.h>
#include <stdlib.h>
#include <unistd.h>

struct _HdfFile {
  hid_t id;
  char path[PETSC_MAX_PATH_LEN], part[PETSC_MAX_PATH_LEN + 8];
  char fault[HDF_FAULT]; /* what went wrong first; empty: nothing yet */
  char under[64];        /* HdfUnder(); empty: the file itself */
};

/* HdfBegin - opens the library; before MPI_Init(). At its end it would close once more a file that
   could not be closed (a full disk), and crash: so it has no end of its own, neither at exit nor,
   by a hook that it sets if MPI is there before it, in MPI_Finalize(). */
void HdfBegin(void) {
  (void)H5dont_atexit();
  (void)H5open();
}

/* The innermost entry of HDF5's account of an error: the cause. */
static herr_t Innermost(unsigned n, const H5E_error2_t *entry, void *ctx) {
  const char *mark = "error message = '", *quote = strstr(entry->desc, mark);
  char *fault = (char *)ctx;

  if (n) return 0;
  (void)snprintf(fault, HDF_FAULT, "%s", quote ? quote + strlen(mark) : entry->desc);
  if (quote) fault[strcspn(fault, "'")] = 0;
  return 0;
}

static void Cause(char fault[HDF_FAULT]) {
  (void)snprintf(fault, HDF_FAULT, "HDF5 does not say why");
  (void)H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, Innermost, fault);
}

/* HDF5 prints its own account of every error unless told not to: Cause() has what matters of it. */
static void BeQuiet(void) {
  (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

/* Notes the failure of a call of the library, which shows in a negative value; returns the value.
 */
static hid_t Try(HdfFile file, hid_t value) {
  if (value < 0 && !file->fault[0]) Cause(file->fault);
  return value;
}

static PetscBool Sound(HdfFile file) {
  return (PetscBool)(file && !file->fault[0]);
}

static PetscErrorCode New(const char *path, HdfFile *file) {
  PetscFunctionBegin;
  BeQuiet();
  PetscCall(PetscNew(file));
  PetscCall(PetscStrncpy((*file)->path, path, sizeof((*file)->path)));
  (void)snprintf((*file)->part, sizeof((*file)->part), "%s.part", path);
  PetscFunctionReturn(0);
}

/* HdfCreate - begins a new file, which takes the place of what has its name when it is closed. Not
   collective; the caller ends it with HdfClose(), which also tells if it could not begin. */
PetscErrorCode HdfCreate(const char *path, HdfFile *file) {
  PetscFunctionBegin;
  PetscCall(New(path, file));
  (*file)->id = Try(*file, H5Fcreate((*file)->part, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  PetscFunctionReturn(0);
}

/* Copies a file; 0, or errno. */
static int CopyFile(const char *from, const char *to) {
  FILE *in = fopen(from, "rb"), *out = in ? fopen(to, "wb") : NULL;
  const size_t size = 1 << 20;
  int fault = out ? 0 : errno;
  char *block = fault ? NULL : malloc(size);
  size_t n;

  if (!fault && !block) fault = ENOMEM;
  while (!fault && (n = fread(block, 1, size, in)) > 0)
    if (fwrite(block, 1, n, out) != n) fault = errno;
  if (!fault && in && ferror(in)) fault = EIO;
  if (out && fclose(out) && !fault) fault = errno;
  if (in) fclose(in);
  free(block);
  return fault;
}

/* HdfAmend - as HdfCreate(), but begins with a copy of the file `from`, which may be the one of
   this path. */
PetscErrorCode HdfAmend(const char *from, const char *path, HdfFile *file) {
  int fault;

  PetscFunctionBegin;
  PetscCall(New(path, file));
  (*file)->id = -1;
  fault = CopyFile(from, (*file)->part);
  if (fault)
    (void)snprintf((*file)->fault, HDF_FAULT, "%s", strerror(fault));
  else
    (*file)->id = Try(*file, H5Fopen((*file)->part, H5F_ACC_RDWR, H5P_DEFAULT));
  PetscFunctionReturn(0);
}

/* Sees a file to the disk. */
static int Synchronise(const char *path) {
  int handle = open(path, O_RDONLY), fault = 0;

  if (handle < 0) return errno;
  if (fsync(handle)) fault = errno;
  if (close(handle) && !fault) fault = errno;
  return fault == EINVAL ? 0 : fault; /* a file system that has no such thing */
}

/*
  HdfClose - ends a file: sees it to the disk and gives it its name. Not collective.

  fault  empty, or why it could not be written: then what stood under its name before is still there
*/
PetscErrorCode HdfClose(HdfFile *file, char fault[HDF_FAULT]) {
  HdfFile self = *file;
  int error = 0;

  PetscFunctionBegin;
  fault[0] = 0;
  if (!self) PetscFunctionReturn(0);
  if (self->id >= 0) {
    if (Sound(self)) Try(self, H5Fflush(self->id, H5F_SCOPE_GLOBAL));
    Try(self, H5Fclose(self->id));
  }
  if (Sound(self)) error = Synchronise(self->part);
  if (Sound(self) && !error && rename(self->part, self->path)) error = errno;
  if (error) (void)snprintf(self->fault, HDF_FAULT, "%s", strerror(error));
  if (!Sound(self)) (void)unlink(self->part);
  PetscCall(PetscStrncpy(fault, self->fault, HDF_FAULT));
  PetscCall(PetscFree(*file));
  PetscFunctionReturn(0);
}

/* HdfDrop - ends a file that is not wanted any more; what stood under its name before is still
 * there.
 */
PetscErrorCode HdfDrop(HdfFile *file) {
  char fault[HDF_FAULT];

  PetscFunctionBegin;
  if (*file && !(*file)->fault[0]) (void)snprintf((*file)->fault, HDF_FAULT, "dropped");
  PetscCall(HdfClose(file, fault));
  PetscFunctionReturn(0);
}

/* HdfFault - has anything gone wrong yet? HdfClose() tells what. */
PetscBool HdfFault(HdfFile file) {
  return (PetscBool)(file && file->fault[0]);
}

/* HdfGroup - makes a group. */
PetscErrorCode HdfGroup(HdfFile file, const char *name) {
  hid_t group;

  PetscFunctionBegin;
  if (!Sound(file)) PetscFunctionReturn(0);
  group = Try(file, H5Gcreate2(file->id, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  if (group >= 0) Try(file, H5Gclose(group));
  PetscFunctionReturn(0);
}

/* An attribute that is there, opened to be written over, which is ten times as fast as to make it
   again; below 0: there is none, or it had another form and is gone. */
static hid_t Existing(HdfFile file, hid_t object, const char *name, hid_t type) {
  hid_t a, had;
  htri_t same;

  if (H5Aexists(object, name) <= 0) return -1;
  a = Try(file, H5Aopen(object, name, H5P_DEFAULT));
  if (a < 0) return -1;
  had = Try(file, H5Aget_type(a));
  same = had >= 0 ? H5Tequal(had, type) : 0;
  if (had >= 0) Try(file, H5Tclose(had));
  if (same > 0) return a;
  Try(file, H5Aclose(a));
  Try(file, H5Adelete(object, name));
  return -1;
}

/* Sets an attribute of an open object, replacing what was there. */
static void Attribute(HdfFile file, hid_t object, const char *name, hid_t type, const void *value) {
  hid_t space = Try(file, H5Screate(H5S_SCALAR)), a = Existing(file, object, name, type);

  if (a < 0 && Sound(file))
    a = Try(file, H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT));
  if (a >= 0) {
    Try(file, H5Awrite(a, type, value));
    Try(file, H5Aclose(a));
  }
  if (space >= 0) Try(file, H5Sclose(space));
}

static void TextAttribute(HdfFile file, hid_t object, const char *name, const char *text) {
  hid_t type = Try(file, H5Tcopy(H5T_C_S1));

  if (type < 0) return;
  Try(file, H5Tset_size(type, strlen(text) + 1));
  Attribute(file, object, name, type, text);
  Try(file, H5Tclose(type));
}

/* Sets an attribute of the named object. */
static void AttributeOf(HdfFile file, const char *object, const char *name, hid_t type,
                        const void *value) {
  hid_t o;

  if (!Sound(file)) return;
  if (!strcmp(object, "/") && file->under[0]) object = file->under;
  o = Try(file, H5Oopen(file->id, object, H5P_DEFAULT));
  if (o < 0) return;
  if (type < 0)
    TextAttribute(file, o, name, (const char *)value);
  else
    Attribute(file, o, name, type, value);
  Try(file, H5Oclose(o));
}

/* Takes an attribute of the file off, if it is there. */
static void DropAttribute(HdfFile file, const char *name) {
  if (Sound(file) && H5Aexists(file->id, name) > 0) Try(file, H5Adelete(file->id, name));
}

/* HdfText - sets a text attribute of an object ("/": the file), replacing what was there. HDF5 has
   room for 64 KB in one: a longer text of the file is a dataset (HdfWriteText). */
PetscErrorCode HdfText(HdfFile file, const char *object, const char *name, const char *text) {
  const size_t most = 60000;

  PetscFunctionBegin;
  if (!strcmp(object, "/") && strlen(text) > most) {
    PetscCall(HdfWriteText(file, name, text, "text"));
    PetscFunctionReturn(0);
  }
  if (!strcmp(object, "/") && Sound(file) && !file->under[0] && !strchr(name, '/'))
    PetscCall(HdfDelete(file, name));
  AttributeOf(file, object, name, -1, text);
  PetscFunctionReturn(0);
}

/* HdfUnder - from here on what is said of the file ("/") and texts without a path are of this
   group, which is made; NULL: of the file itself again. */
PetscErrorCode HdfUnder(HdfFile file, const char *group) {
  PetscFunctionBegin;
  if (!Sound(file)) PetscFunctionReturn(0);
  if (group) PetscCall(HdfGroup(file, group));
  (void)snprintf(file->under, sizeof(file->under), "%s", group ? group : "");
  PetscFunctionReturn(0);
}

/* HdfReal - sets a real attribute. */
PetscErrorCode HdfReal(HdfFile file, const char *object, const char *name, PetscReal value) {
  PetscFunctionBegin;
  AttributeOf(file, object, name, H5T_NATIVE_DOUBLE, &value);
  PetscFunctionReturn(0);
}

/* HdfInt - sets an integer attribute. */
PetscErrorCode HdfInt(HdfFile file, const char *object, const char *name, int value) {
  PetscFunctionBegin;
  AttributeOf(file, object, name, H5T_NATIVE_INT, &value);
  PetscFunctionReturn(0);
}

static void Sizes(int rank, const PetscInt from[], hsize_t to[HDF_RANK]) {
  for (int i = 0; i < rank; i++) to[i] = (hsize_t)from[i];
}

/* Makes a dataset with its two notes and closes space and plist; -1 if it could not. */
static hid_t MakeDataset(HdfFile file, const char *name, hid_t type, hid_t space, hid_t plist,
                         const char *units, const char *description) {
  hid_t d = -1;

  if (Sound(file))
    d = Try(file, H5Dcreate2(file->id, name, type, space, H5P_DEFAULT, plist, H5P_DEFAULT));
  if (d >= 0) {
    TextAttribute(file, d, "units", units);
    TextAttribute(file, d, "description", description);
  }
  if (space >= 0) Try(file, H5Sclose(space));
  return d;
}

/* HdfWrite - writes one dataset of fixed size (rank 0: a scalar), in the place of what was there.
 */
PetscErrorCode HdfWrite(HdfFile file, const char *name, int rank, const PetscInt dims[],
                        const PetscReal data[], const char *units, const char *description) {
  hsize_t sizes[HDF_RANK];
  hid_t d;

  PetscFunctionBegin;
  if (!Sound(file)) PetscFunctionReturn(0);
  if (H5Lexists(file->id, name, H5P_DEFAULT) > 0) Try(file, H5Ldelete(file->id, name, H5P_DEFAULT));
  Sizes(rank, dims, sizes);
  d = MakeDataset(file, name, H5T_IEEE_F64LE,
                  Try(file, rank ? H5Screate_simple(rank, sizes, NULL) : H5Screate(H5S_SCALAR)),
                  H5P_DEFAULT, units, description);
  if (d < 0) PetscFunctionReturn(0);
  Try(file, H5Dwrite(d, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
  Try(file, H5Dclose(d));
  PetscFunctionReturn(0);
}

/* HdfWriteText - writes one text of any length as a dataset of the file, in the place of what was
   there, of an attribute of that name, too. */
PetscErrorCode HdfWriteText(HdfFile file, const char *name, const char *text,
                            const char *description) {
  hid_t type, d;
  char path[192];

  PetscFunctionBegin;
  if (!Sound(file)) PetscFunctionReturn(0);
  if (file->under[0] && name[0] != '/') {
    (void)snprintf(path, sizeof(path), "%s/%s", file->under, name);
    name = path;
  } else
    DropAttribute(file, name);
  PetscCall(HdfDelete(file, name));
  type = Try(file, H5Tcopy(H5T_C_S1));
  if (type < 0) PetscFunctionReturn(0);
  Try(file, H5Tset_size(type, strlen(text) + 1));
  d = MakeDataset(file, name, type, Try(file, H5Screate(H5S_SCALAR)), H5P_DEFAULT, "", description);
  if (d >= 0) {
    Try(file, H5Dwrite(d, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text));
    Try(file, H5Dclose(d));
  }
  Try(file, H5Tclose(type));
  PetscFunctionReturn(0);
}

/* HdfAppendable - makes an empty dataset that grows along its first dimension; row has the rank
   sizes of one entry of it (none for rank 0). */
PetscErrorCode HdfAppendable(HdfFile file, const char *name, int rank, const PetscInt row[],
                             const char *units, const char *description) {
  hsize_t dims[HDF_RANK] = {0}, most[HDF_RANK] = {H5S_UNLIMITED}, chunk[HDF_RANK], values = 1;
  hid_t plist, d;

  PetscFunctionBegin;
  if (!Sound(file)) PetscFunctionReturn(0);
  for (int i = 0; i < rank; i++) {
    dims[i + 1] = most[i + 1] = chunk[i + 1] = (hsize_t)row[i];
    values *= (hsize_t)row[i];
  }
  chunk[0] = PetscMax(1, 512 / values);
  plist = Try(file, H5Pcreate(H5P_DATASET_CREATE));
  Try(file, H5Pset_chunk(plist, rank + 1, chunk));
  d = MakeDataset(file, name, H5T_IEEE_F64LE, Try(file, H5Screate_simple(rank + 1, dims, most)),
                  plist, units, description);
  if (d >= 0) Try(file, H5Dclose(d));
  Try(file, H5Pclose(plist));
  PetscFunctionReturn(0);
}

/* Opens a dataset and reads its sizes; -1 if it could not. */
static hid_t OpenDataset(HdfFile file, const char *name, int *rank, hsize_t dims[HDF_RANK]) {
  hid_t d = Try(file, H5Dopen2(file->id, name, H5P_DEFAULT)), space;

  if (d < 0) return d;
  space = Try(file, H5Dget_space(d));
  *rank = H5Sget_simple_extent_dims(space, dims, NULL);
  Try(file, H5Sclose(space));
  return d;
}

/* HdfAppend - writes rows entries at the end of a dataset made by HdfAppendable(). */
PetscErrorCode HdfAppend(HdfFile file, const char *name, PetscInt rows, const PetscReal data[]) {
  hsize_t dims[HDF_RANK], start[HDF_RANK] = {0}, count[HDF_RANK];
  hid_t d, space, memory;
  int rank;

  PetscFunctionBegin;
  if (!Sound(file) || !rows) PetscFunctionReturn(0);
  d = OpenDataset(file, name, &rank, dims);
  if (d < 0) PetscFunctionReturn(0);
  start[0] = dims[0];
  dims[0] += (hsize_t)rows;
  Try(file, H5Dset_extent(d, dims));
  for (int i = 0; i < rank; i++) count[i] = dims[i];
  count[0] = (hsize_t)rows;
  space = Try(file, H5Dget_space(d));
  memory = Try(file, H5Screate_simple(rank, count, NULL));
  Try(file, H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL));
  if (Sound(file)) Try(file, H5Dwrite(d, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, data));
  Try(file, H5Sclose(memory));
  Try(file, H5Sclose(space));
  Try(file, H5Dclose(d));
  PetscFunctionReturn(0);
}

/* The type of a column in a file, to be closed by the caller. */
static hid_t ColumnType(HdfKind kind) {
  hid_t type;

  if (kind != HDF_TEXTS) return H5Tcopy(kind == HDF_REALS ? H5T_IEEE_F64LE : H5T_STD_I64LE);
  type = H5Tcopy(H5T_C_S1);
  (void)H5Tset_size(type, H5T_VARIABLE);
  return type;
}

/* HdfColumn - makes a dataset of n values, which HdfPut() fills one by one: until then they are
   NaN, 0 or an empty text. */
PetscErrorCode HdfColumn(HdfFile file, const char *name, HdfKind kind, PetscInt n,
                         const char *units, const char *description) {
  const PetscReal nothing = NAN;
  hsize_t size = (hsize_t)n;
  hid_t plist, type, d;

  PetscFunctionBegin;
  if (!Sound(file)) PetscFunctionReturn(0);
  type = Try(file, ColumnType(kind));
  plist = Try(file, H5Pcreate(H5P_DATASET_CREATE));
  if (kind == HDF_REALS) Try(file, H5Pset_fill_value(plist, H5T_NATIVE_DOUBLE, &nothing));
  d = MakeDataset(file, name, type, Try(file, H5Screate_simple(1, &size, NULL)), plist, units,
                  description);
  if (d >= 0) Try(file, H5Dclose(d));
  Try(file, H5Pclose(plist));
  Try(file, H5Tclose(type));
  PetscFunctionReturn(0);
}

/* The type of a column in memory, to be closed by the caller. */
static hid_t MemoryType(hid_t dataset) {
  hid_t type = H5Dget_type(dataset);
  H5T_class_t class = H5Tget_class(type);

  if (class == H5T_STRING) return type;
  (void)H5Tclose(type);
  return H5Tcopy(class == H5T_FLOAT ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64);
}

/* Selects the given rows of a dataset; those that follow one another at one blow. */
static PetscErrorCode SelectRows(HdfFile file, hid_t space, PetscInt n, const PetscInt rows[]) {
  hsize_t size = (hsize_t)n, *place;
  PetscInt k = 1;

  PetscFunctionBegin;
  while (k < n && rows[k] == rows[0] + k) k++;
  PetscCall(PetscMalloc1(n, &place));
  for (PetscInt i = 0; i < n; i++) place[i] = (hsize_t)rows[i];
  if (k == n)
    Try(file, H5Sselect_hyperslab(space, H5S_SELECT_SET, place, NULL, &size, NULL));
  else
    Try(file, H5Sselect_elements(space, H5S_SELECT_SET, (size_t)n, place));
  PetscCall(PetscFree(place));
  PetscFunctionReturn(0);
}

/* HdfPut - writes n values into the given rows of a dataset made by HdfColumn(); data are
   PetscReal, PetscInt64 or const char *, by its kind. */
PetscErrorCode HdfPut(HdfFile file, const char *name, PetscInt n, const PetscInt rows[],
                      const void *data) {
  hsize_t dims[HDF_RANK], size = (hsize_t)n;
  hid_t d, space, memory, type;
  int rank;

  PetscFunctionBegin;
  if (!Sound(file) || !n) PetscFunctionReturn(0);
  d = OpenDataset(file, name, &rank, dims);
  if (d < 0) PetscFunctionReturn(0);
  type = Try(file, MemoryType(d));
  space = Try(file, H5Dget_space(d));
  memory = Try(file, H5Screate_simple(1, &size, NULL));
  PetscCall(SelectRows(file, space, n, rows));
  if (Sound(file)) Try(file, H5Dwrite(d, type, memory, space, H5P_DEFAULT, data));
  Try(file, H5Sclose(memory));
  Try(file, H5Sclose(space));
  Try(file, H5Tclose(type));
  Try(file, H5Dclose(d));
  PetscFunctionReturn(0);
}

/* HdfTruncate - leaves the first rows entries of a dataset made by HdfAppendable(). */
PetscErrorCode HdfTruncate(HdfFile file, const char *name, PetscInt rows) {
  hsize_t dims[HDF_RANK];
  hid_t d;
  int rank;

  PetscFunctionBegin;
  if (!Sound(file)) PetscFunctionReturn(0);
  d = OpenDataset(file, name, &rank, dims);
  if (d < 0) PetscFunctionReturn(0);
  dims[0] = PetscMin(dims[0], (hsize_t)rows);
  Try(file, H5Dset_extent(d, dims));
  Try(file, H5Dclose(d));
  PetscFunctionReturn(0);
}

/* HdfDelete - takes an object out, if it is there. */
PetscErrorCode HdfDelete(HdfFile file, const char *name) {
  PetscFunctionBegin;
  if (Sound(file) && H5Lexists(file->id, name, H5P_DEFAULT) > 0)
    Try(file, H5Ldelete(file->id, name, H5P_DEFAULT));
  PetscFunctionReturn(0);
}

/* Reads a dataset of `rank` dimensions; data is allocated. gaps: it may have some, NaN. */
static PetscErrorCode ReadAll(hid_t f, const char *name, PetscBool gaps, int rank, PetscInt dims[],
                              PetscReal **data, char fault[HDF_FAULT]) {
  hid_t d = H5Dopen2(f, name, H5P_DEFAULT), space;
  hsize_t sizes[HDF_RANK], total = 1;
  int found;

  PetscFunctionBegin;
  if (d < 0) {
    (void)snprintf(fault, HDF_FAULT, "has no dataset %s", name);
    PetscFunctionReturn(0);
  }
  space = H5Dget_space(d);
  found = H5Sget_simple_extent_ndims(space);
  if (found == rank)
    H5Sget_simple_extent_dims(space, sizes, NULL);
  else
    (void)snprintf(fault, HDF_FAULT, "%s must have %d dimension(s), it has %d", name, rank, found);
  H5Sclose(space);
  if (!fault[0]) {
    for (int i = 0; i < rank; i++) {
      total *= sizes[i];
      dims[i] = (PetscInt)sizes[i];
    }
    if (total >= PETSC_MAX_INT) (void)snprintf(fault, HDF_FAULT, "%s is too large", name);
  }
  if (!fault[0]) {
    PetscCall(PetscMalloc1(total, data));
    if (H5Dread(d, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, *data) < 0)
      (void)snprintf(fault, HDF_FAULT, "%s cannot be read as numbers; is the file whole?", name);
    for (hsize_t i = 0; i < total && !fault[0]; i++)
      if (PetscIsInfOrNanReal((*data)[i]) && !(gaps && PetscIsNanReal((*data)[i])))
        (void)snprintf(fault, HDF_FAULT, "%s has a value that is not finite", name);
  }
  H5Dclose(d);
  PetscFunctionReturn(0);
}

static hid_t OpenToRead(const char *path, char fault[HDF_FAULT]) {
  hid_t f;

  BeQuiet();
  fault[0] = 0;
  f = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (f < 0) (void)snprintf(fault, HDF_FAULT, "not there, or not a whole HDF5 file");
  return f;
}

/* Tells all ranks what rank 0 has met; a user's mistake if it is anything. */
static PetscErrorCode Verdict(const char *option, const char *path, char fault[HDF_FAULT]) {
  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(fault, HDF_FAULT, MPI_CHAR, 0, OptionsComm()));
  UserCheck(!fault[0], OptionsComm(), "%s %s: %s", option, path, fault);
  PetscFunctionReturn(0);
}

static PetscErrorCode Read(const char *option, const char *path, const char *name, PetscBool gaps,
                           int rank, PetscInt dims[], PetscReal **data) {
  char fault[HDF_FAULT] = "";
  PetscMPIInt me;
  PetscInt total = 1;
  hid_t f = -1;

  PetscFunctionBegin;
  *data = NULL;
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &me));
  if (!me) f = OpenToRead(path, fault);
  if (f >= 0) {
    PetscCall(ReadAll(f, name, gaps, rank, dims, data, fault));
    H5Fclose(f);
  }
  if (fault[0]) PetscCall(PetscFree(*data));
  PetscCall(Verdict(option, path, fault));
  PetscCallMPI(MPI_Bcast(dims, rank, MPIU_INT, 0, OptionsComm()));
  for (int i = 0; i < rank; i++) total *= dims[i];
  if (me) PetscCall(PetscMalloc1(total, data));
  PetscCallMPI(MPI_Bcast(*data, (PetscMPIInt)total, MPIU_REAL, 0, OptionsComm()));
  PetscFunctionReturn(0);
}

/*
  HdfRead - reads a whole array of reals from a file. Collective on OptionsComm(): rank 0 reads.

  option  the option that gave the file, named in the message when the file is bad
  rank    the number of dimensions expected
  dims    their sizes, on exit
  data    allocated here (PetscMalloc), row major; the caller frees it

  A file that is missing, truncated or lacks the array, and values that are not finite, are a user's
  mistake.
*/
PetscErrorCode HdfRead(const char *option, const char *path, const char *name, int rank,
                       PetscInt dims[], PetscReal **data) {
  PetscFunctionBegin;
  PetscCall(Read(option, path, name, PETSC_FALSE, rank, dims, data));
  PetscFunctionReturn(0);
}

/* HdfReadGaps - the same, of an array that has NaN where there is nothing. Collective. */
PetscErrorCode HdfReadGaps(const char *option, const char *path, const char *name, int rank,
                           PetscInt dims[], PetscReal **data) {
  PetscFunctionBegin;
  PetscCall(Read(option, path, name, PETSC_TRUE, rank, dims, data));
  PetscFunctionReturn(0);
}

/* Reads a text attribute of an open object; empty if there is none. */
static void ReadAttribute(hid_t object, const char *name, char *text, size_t length) {
  hid_t a, type, fixed;

  text[0] = 0;
  if (H5Aexists(object, name) <= 0) return;
  a = H5Aopen(object, name, H5P_DEFAULT);
  type = H5Aget_type(a);
  if (H5Tis_variable_str(type) > 0) { /* as h5py writes it */
    char *value = NULL;
    fixed = H5Tcopy(H5T_C_S1);
    (void)H5Tset_size(fixed, H5T_VARIABLE);
    (void)H5Tset_cset(fixed, H5Tget_cset(type));
    if (H5Aread(a, fixed, &value) >= 0 && value) {
      (void)snprintf(text, length, "%s", value);
      (void)H5free_memory(value);
    }
    H5Tclose(fixed);
  } else if (H5Tget_class(type) == H5T_STRING && H5Tget_size(type) < length) {
    (void)H5Aread(a, type, text);
    text[H5Tget_size(type)] = 0;
  }
  H5Tclose(type);
  H5Aclose(a);
}

/*
  HdfReadQuantity - as HdfRead(), for quantities that have a dimension: with an attribute `units`
  (m, cm, s, ...) they are converted by the scales of the laboratory, without they have none.
*/
PetscErrorCode HdfReadQuantity(const char *option, const char *path, const char *name,
                               Dimension dimension, int rank, PetscInt dims[], PetscReal **data) {
  char units[32] = "", fault[HDF_FAULT], what[128];
  PetscReal factor;
  PetscInt total = 1;
  PetscMPIInt me;
  hid_t f = -1, d;

  PetscFunctionBegin;
  PetscCall(HdfRead(option, path, name, rank, dims, data));
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &me));
  if (!me) f = OpenToRead(path, fault);
  if (f >= 0) {
    d = H5Dopen2(f, name, H5P_DEFAULT);
    ReadAttribute(d, "units", units, sizeof(units));
    H5Dclose(d);
    H5Fclose(f);
  }
  PetscCallMPI(MPI_Bcast(units, sizeof(units), MPI_CHAR, 0, OptionsComm()));
  (void)snprintf(what, sizeof(what), "%s %.60s: %s in ", option, path, name);
  PetscCall(OptionUnit(what, strcmp(units, "1") ? units : "", dimension, &factor));
  for (int i = 0; i < rank; i++) total *= dims[i];
  for (PetscInt i = 0; i < total; i++) (*data)[i] *= factor;
  for (PetscInt i = 0; i < total && !units[0]; i++) {
    OptionsKeepPlain(dimension, (*data)[i]);
    if ((*data)[i] != 0) break; /* that is enough to tell */
  }
  PetscFunctionReturn(0);
}

/* Reads a text of a file that is open, an attribute or a dataset; text is allocated, NULL if there
   is none. */
static PetscErrorCode ReadText(hid_t f, const char *name, int *size, char **text) {
  hid_t a = -1, d = -1, type = -1;
  herr_t status = -1;

  PetscFunctionBegin;
  *text = NULL;
  if (H5Aexists(f, name) > 0)
    a = H5Aopen(f, name, H5P_DEFAULT);
  else if (H5Lexists(f, name, H5P_DEFAULT) > 0)
    d = H5Dopen2(f, name, H5P_DEFAULT);
  if (a >= 0 || d >= 0) type = a >= 0 ? H5Aget_type(a) : H5Dget_type(d);
  if (type >= 0 && H5Tget_class(type) == H5T_STRING && !H5Tis_variable_str(type)) {
    *size = (int)H5Tget_size(type) + 1;
    PetscCall(PetscCalloc1(*size, text));
    status =
        a >= 0 ? H5Aread(a, type, *text) : H5Dread(d, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text);
  }
  if (status < 0) PetscCall(PetscFree(*text));
  if (type >= 0) H5Tclose(type);
  if (a >= 0) H5Aclose(a);
  if (d >= 0) H5Dclose(d);
  PetscFunctionReturn(0);
}

/* HdfReadText - reads a text of a file, an attribute or, if it is long, a dataset; the caller frees
   it (PetscFree). A file that is no result of tendril is a user's mistake. Collective on
   OptionsComm(). */
PetscErrorCode HdfReadText(const char *option, const char *path, const char *name, char **text) {
  char fault[HDF_FAULT] = "";
  PetscMPIInt me;
  int size = 0;

  PetscFunctionBegin;
  *text = NULL;
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &me));
  if (!me) {
    hid_t f = OpenToRead(path, fault);
    if (f >= 0) {
      PetscCall(ReadText(f, name, &size, text));
      H5Fclose(f);
      if (!*text) (void)snprintf(fault, HDF_FAULT, "is not a result file of tendril");
    }
  }
  PetscCall(Verdict(option, path, fault));
  PetscCallMPI(MPI_Bcast(&size, 1, MPI_INT, 0, OptionsComm()));
  if (me) PetscCall(PetscCalloc1(size, text));
  PetscCallMPI(MPI_Bcast(*text, size, MPI_CHAR, 0, OptionsComm()));
  PetscFunctionReturn(0);
}

/* HdfHas - tells whether a file is HDF5 and holds the named object, or text of the file, attribute
   or dataset, if the name has no slash in front. Collective on OptionsComm(). */
PetscErrorCode HdfHas(const char *path, const char *name, PetscBool *has) {
  char fault[HDF_FAULT];
  PetscMPIInt me;
  int found = 0;
  hid_t f;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(OptionsComm(), &me));
  if (!me && (f = OpenToRead(path, fault)) >= 0) {
    found = (name[0] != '/' && H5Aexists(f, name) > 0) || H5Lexists(f, name, H5P_DEFAULT) > 0;
    H5Fclose(f);
  }
  PetscCallMPI(MPI_Bcast(&found, 1, MPI_INT, 0, OptionsComm()));
  *has = (PetscBool)found;
  PetscFunctionReturn(0);
}

/* HdfReadRow - reads entry `row` of a dataset, n reals. Not collective; fault says what is wrong.
 */
PetscErrorCode HdfReadRow(const char *path, const char *name, PetscInt row, PetscInt n,
                          PetscReal data[], char fault[HDF_FAULT]) {
  hsize_t start[HDF_RANK] = {(hsize_t)row}, count[HDF_RANK], dims[HDF_RANK], values = 1,
          size = (hsize_t)n;
  hid_t f, d = -1, space = -1, memory = -1;
  int rank = 0;

  PetscFunctionBegin;
  f = OpenToRead(path, fault);
  if (f < 0) PetscFunctionReturn(0);
  d = H5Dopen2(f, name, H5P_DEFAULT);
  if (d >= 0) space = H5Dget_space(d);
  if (space >= 0) rank = H5Sget_simple_extent_dims(space, dims, NULL);
  for (int i = 0; i < rank; i++) values *= count[i] = i ? dims[i] : 1;
  if (rank > 0 && start[0] < dims[0] && values == size &&
      H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0)
    memory = H5Screate_simple(1, &size, NULL);
  if (memory < 0 || H5Dread(d, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, data) < 0)
    (void)snprintf(fault, HDF_FAULT, "%s cannot be read", name);
  if (memory >= 0) H5Sclose(memory);
  if (space >= 0) H5Sclose(space);
  if (d >= 0) H5Dclose(d);
  H5Fclose(f);
  PetscFunctionReturn(0);
}

/* HdfIs - is there a file of HDF5's, whole or not? Not collective. */
PetscBool HdfIs(const char *path) {
  BeQuiet();
  return (PetscBool)(H5Fis_hdf5(path) > 0);
}

/* A text that grows. */
typedef struct {
  char *text;
  size_t n, room;
} Words;

/* Adds a word, of at most `most` characters, and its end; blanks behind it are left out. */
static PetscErrorCode AddWord(Words *self, const char *word, size_t most) {
  size_t n = 0;

  PetscFunctionBegin;
  while (n < most && word[n]) n++;
  while (n > 0 && word[n - 1] == ' ') n--;
  if (self->n + n + 1 > self->room) {
    self->room = 2 * self->room + n + 1024;
    PetscCall(PetscRealloc(self->room, &self->text));
  }
  PetscCall(PetscMemcpy(self->text + self->n, word, n));
  self->n += n;
  self->text[self->n++] = 0;
  PetscFunctionReturn(0);
}

/* The shortest text that is read as this number again; nothing for NaN. */
static void NumberText(double value, const char *unit, char text[64]) {
  text[0] = 0;
  if (value != value) return;
  for (int digits = 15; digits <= 17; digits++) {
    (void)snprintf(text, 64, "%.*g", digits, value);
    if (strtod(text, NULL) == value) break;
  }
  (void)snprintf(text + strlen(text), 64 - strlen(text), "%s", unit);
}

static PetscErrorCode AddNumbers(hid_t d, hsize_t n, Words *words, char fault[HDF_FAULT]) {
  double *value;
  char text[64], unit[32];

  PetscFunctionBegin;
  ReadAttribute(d, "units", unit, sizeof(unit));
  if (!strcmp(unit, "1")) unit[0] = 0;
  PetscCall(PetscMalloc1(n, &value));
  if (H5Dread(d, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, value) < 0)
    (void)snprintf(fault, HDF_FAULT, "cannot be read as numbers; is the file whole?");
  for (hsize_t i = 0; i < n && !fault[0]; i++) {
    NumberText(value[i], unit, text);
    PetscCall(AddWord(words, text, sizeof(text)));
  }
  PetscCall(PetscFree(value));
  PetscFunctionReturn(0);
}

/* Texts of one length, or of any. */
static PetscErrorCode AddTexts(hid_t d, hid_t type, hsize_t n, Words *words,
                               char fault[HDF_FAULT]) {
  PetscBool any = (PetscBool)(H5Tis_variable_str(type) > 0);
  size_t size = H5Tget_size(type);
  char *all;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n * size, &all));
  if (H5Dread(d, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all) < 0)
    (void)snprintf(fault, HDF_FAULT, "cannot be read as text; is the file whole?");
  for (hsize_t i = 0; i < n && !fault[0]; i++) {
    const char *word = any ? ((char **)(void *)all)[i] : all + i * size;
    PetscCall(AddWord(words, word ? word : "", any ? PETSC_MAX_PATH_LEN : size));
    if (any) (void)H5free_memory(((char **)(void *)all)[i]);
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* True and false, as h5py writes them. */
static PetscErrorCode AddSwitches(hid_t d, hid_t type, hsize_t n, Words *words,
                                  char fault[HDF_FAULT]) {
  signed char *all;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n, &all));
  if (H5Tget_size(type) != 1 || H5Dread(d, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all) < 0)
    (void)snprintf(fault, HDF_FAULT, "holds neither numbers nor text");
  for (hsize_t i = 0; i < n && !fault[0]; i++)
    PetscCall(AddWord(words, all[i] ? "true" : "false", 5));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* One dataset of a table; rows -1: the first. */
static PetscErrorCode AddColumn(hid_t d, PetscInt *rows, Words *words, char fault[HDF_FAULT]) {
  hid_t space = H5Dget_space(d), type = H5Dget_type(d);
  H5T_class_t class = H5Tget_class(type);
  hsize_t n = 0;

  PetscFunctionBegin;
  if (H5Sget_simple_extent_ndims(space) != 1)
    (void)snprintf(fault, HDF_FAULT, "must have one dimension, that of the rows");
  else
    (void)H5Sget_simple_extent_dims(space, &n, NULL);
  if (!fault[0] && *rows >= 0 && n != (hsize_t)*rows)
    (void)snprintf(fault, HDF_FAULT, "has %d rows, the first has %d", (int)n, (int)*rows);
  *rows = (PetscInt)n;
  if (!fault[0] && (class == H5T_INTEGER || class == H5T_FLOAT))
    PetscCall(AddNumbers(d, n, words, fault));
  else if (!fault[0] && class == H5T_STRING)
    PetscCall(AddTexts(d, type, n, words, fault));
  else if (!fault[0] && class == H5T_ENUM)
    PetscCall(AddSwitches(d, type, n, words, fault));
  else if (!fault[0])
    (void)snprintf(fault, HDF_FAULT, "holds neither numbers nor text");
  H5Tclose(type);
  H5Sclose(space);
  PetscFunctionReturn(0);
}

/*
  HdfReadTable - reads all datasets of a file as the columns of a table, numbers as text. Not
  collective.

  text   column by column its name and its rows, a 0 behind each; the caller frees it (PetscFree)
  size   of the text
  fault  empty, or what is wrong with the file
*/
PetscErrorCode HdfReadTable(const char *path, PetscInt *columns, PetscInt *rows, char **text,
                            size_t *size, char fault[HDF_FAULT]) {
  Words words = {0};
  H5G_info_t info = {0};
  hid_t f = OpenToRead(path, fault), d;

  PetscFunctionBegin;
  *columns = 0;
  *rows = -1;
  if (f >= 0) (void)H5Gget_info(f, &info);
  for (hsize_t i = 0; i < info.nlinks && !fault[0]; i++) {
    char name[64], why[HDF_FAULT] = "";
    (void)H5Lget_name_by_idx(f, ".", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof(name),
                             H5P_DEFAULT);
    PetscCall(AddWord(&words, name, sizeof(name)));
    d = H5Dopen2(f, name, H5P_DEFAULT);
    if (d < 0)
      (void)snprintf(why, sizeof(why), "is no dataset");
    else {
      PetscCall(AddColumn(d, rows, &words, why));
      H5Dclose(d);
    }
    if (why[0]) (void)snprintf(fault, HDF_FAULT, "%s %.120s", name, why);
    ++*columns;
  }
  if (f >= 0) H5Fclose(f);
  if (fault[0]) PetscCall(PetscFree(words.text));
  *text = words.text;
  *size = words.n;
  PetscFunctionReturn(0);
}
