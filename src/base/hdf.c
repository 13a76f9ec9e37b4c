/* Files of HDF5 are written. */
#include "base/hdf_library.h"
#include <errno.h>
#include <fcntl.h>
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
void HdfBeQuiet(void) {
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
  HdfBeQuiet();
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
