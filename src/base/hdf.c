#include "base/hdf.h"
#include "base/options.h"

/*
  HdfRead - reads a whole array of reals from an HDF5 file, on every rank.

  option  the option that gave the file, named in the message when the file is bad
  rank    the number of dimensions expected
  dims    their sizes, on exit
  data    allocated here (PetscMalloc), row major; the caller frees it

  A file that is missing, truncated or lacks the array, and values that are not finite, are a user's
  mistake.
*/
PetscErrorCode HdfRead(const char *option, const char *file, const char *name, int rank,
                       hsize_t dims[], PetscReal **data) {
  hid_t f, d, space;
  hsize_t total = 1;
  int ndims;
  herr_t status;

  PetscFunctionBegin;
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  f = H5Fopen(file, H5F_ACC_RDONLY, H5P_DEFAULT);
  UserCheck(f >= 0, PETSC_COMM_WORLD, "%s %s: not there, or not a whole HDF5 file", option, file);
  d = H5Dopen2(f, name, H5P_DEFAULT);
  if (d < 0) H5Fclose(f);
  UserCheck(d >= 0, PETSC_COMM_WORLD, "%s %s: has no dataset %s", option, file, name);
  space = H5Dget_space(d);
  ndims = H5Sget_simple_extent_ndims(space);
  if (ndims == rank) H5Sget_simple_extent_dims(space, dims, NULL);
  H5Sclose(space);
  if (ndims != rank) {
    H5Dclose(d);
    H5Fclose(f);
  }
  UserCheck(ndims == rank, PETSC_COMM_WORLD, "%s %s: %s must have %d dimension(s), it has %d",
            option, file, name, rank, ndims);
  for (int i = 0; i < rank; i++) total *= dims[i];
  PetscCall(PetscMalloc1(total, data));
  status = H5Dread(d, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, *data);
  H5Dclose(d);
  H5Fclose(f);
  UserCheck(status >= 0, PETSC_COMM_WORLD,
            "%s %s: %s cannot be read as numbers; is the file whole?", option, file, name);
  for (hsize_t i = 0; i < total; i++)
    UserCheck(!PetscIsInfOrNanReal((*data)[i]), PETSC_COMM_WORLD,
              "%s %s: %s has a value that is not finite", option, file, name);
  PetscFunctionReturn(0);
}

/* HdfExists - tells whether a file is HDF5 and holds the named object. */
PetscErrorCode HdfExists(const char *file, const char *name, PetscBool *exists) {
  hid_t f;

  PetscFunctionBegin;
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  f = H5Fopen(file, H5F_ACC_RDONLY, H5P_DEFAULT);
  *exists = (PetscBool)(f >= 0 && H5Lexists(f, name, H5P_DEFAULT) > 0);
  if (f >= 0) H5Fclose(f);
  PetscFunctionReturn(0);
}

/* HdfAppendable - creates an empty dataset that grows along its first dimension; row has the rank
   sizes of one entry of it (none for rank 0). */
PetscErrorCode HdfAppendable(hid_t file, const char *name, int rank, const hsize_t row[],
                             const char *attribute, const char *description) {
  hsize_t dims[4] = {0}, most[4] = {H5S_UNLIMITED}, chunk[4], values = 1;
  hid_t space, plist, d;

  PetscFunctionBegin;
  for (int i = 0; i < rank; i++) {
    dims[i + 1] = most[i + 1] = chunk[i + 1] = row[i];
    values *= row[i];
  }
  chunk[0] = PetscMax(1, 512 / values);
  space = H5Screate_simple(rank + 1, dims, most);
  plist = H5Pcreate(H5P_DATASET_CREATE);
  HdfCall(H5Pset_chunk(plist, rank + 1, chunk));
  d = H5Dcreate2(file, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, plist, H5P_DEFAULT);
  HdfCall(d);
  PetscCall(HdfAttributeText(d, attribute, description));
  H5Dclose(d);
  H5Pclose(plist);
  H5Sclose(space);
  PetscFunctionReturn(0);
}

/* HdfAppend - adds rows entries at the end of a dataset made by HdfAppendable. */
PetscErrorCode HdfAppend(hid_t file, const char *name, hsize_t rows, const PetscReal data[]) {
  hsize_t dims[4], start[4] = {0}, count[4];
  hid_t d = H5Dopen2(file, name, H5P_DEFAULT), space, memory;
  int n;

  PetscFunctionBegin;
  HdfCall(d);
  space = H5Dget_space(d);
  n = H5Sget_simple_extent_dims(space, dims, NULL);
  H5Sclose(space);
  start[0] = dims[0];
  dims[0] += rows;
  HdfCall(H5Dset_extent(d, dims));
  for (int i = 0; i < n; i++) count[i] = dims[i];
  count[0] = rows;
  space = H5Dget_space(d);
  memory = H5Screate_simple(n, count, NULL);
  HdfCall(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL));
  HdfCall(H5Dwrite(d, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, data));
  H5Sclose(memory);
  H5Sclose(space);
  H5Dclose(d);
  PetscFunctionReturn(0);
}

/* HdfWrite - writes one dataset of fixed size (rank 0: a scalar), with one text attribute. */
PetscErrorCode HdfWrite(hid_t file, const char *name, int rank, const hsize_t dims[],
                        const PetscReal data[], const char *attribute, const char *description) {
  hid_t space = rank ? H5Screate_simple(rank, dims, NULL) : H5Screate(H5S_SCALAR), d;

  PetscFunctionBegin;
  if (H5Lexists(file, name, H5P_DEFAULT) > 0) HdfCall(H5Ldelete(file, name, H5P_DEFAULT));
  d = H5Dcreate2(file, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  HdfCall(d);
  HdfCall(H5Dwrite(d, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
  PetscCall(HdfAttributeText(d, attribute, description));
  H5Dclose(d);
  H5Sclose(space);
  PetscFunctionReturn(0);
}

/* HdfOverwrite - writes an array in the place of the one of the same size that stands there, so
   that the file does not grow; creates it the first time. */
PetscErrorCode HdfOverwrite(hid_t file, const char *name, hsize_t n, const PetscReal data[],
                            const char *description) {
  hid_t d;

  PetscFunctionBegin;
  if (H5Lexists(file, name, H5P_DEFAULT) > 0) {
    d = H5Dopen2(file, name, H5P_DEFAULT);
    HdfCall(d);
    HdfCall(H5Dwrite(d, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
    H5Dclose(d);
  } else
    PetscCall(HdfWrite(file, name, 1, &n, data, "description", description));
  PetscFunctionReturn(0);
}

/* HdfTruncate - leaves the first rows entries of a dataset made by HdfAppendable. */
PetscErrorCode HdfTruncate(hid_t file, const char *name, hsize_t rows) {
  hsize_t dims[4];
  hid_t d = H5Dopen2(file, name, H5P_DEFAULT), space;

  PetscFunctionBegin;
  HdfCall(d);
  space = H5Dget_space(d);
  H5Sget_simple_extent_dims(space, dims, NULL);
  H5Sclose(space);
  dims[0] = PetscMin(dims[0], rows);
  HdfCall(H5Dset_extent(d, dims));
  H5Dclose(d);
  PetscFunctionReturn(0);
}

/* HdfReadAttributeText - reads a text attribute of a file, on every rank; the caller frees it
   (PetscFree). A file that is no result of tendril is a user's mistake. */
PetscErrorCode HdfReadAttributeText(const char *option, const char *file, const char *name,
                                    char **text) {
  hid_t f, a = -1, type = -1;
  herr_t status = -1;
  size_t size = 0;

  PetscFunctionBegin;
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  f = H5Fopen(file, H5F_ACC_RDONLY, H5P_DEFAULT);
  UserCheck(f >= 0, PETSC_COMM_WORLD, "%s %s: not there, or not a whole HDF5 file", option, file);
  if (H5Aexists(f, name) > 0) a = H5Aopen(f, name, H5P_DEFAULT);
  if (a >= 0) {
    type = H5Aget_type(a);
    size = H5Tget_size(type);
    PetscCall(PetscCalloc1(size + 1, text));
    status = H5Tis_variable_str(type) ? -1 : H5Aread(a, type, *text);
    H5Tclose(type);
    H5Aclose(a);
  }
  H5Fclose(f);
  UserCheck(status >= 0, PETSC_COMM_WORLD, "%s %s: is not a result file of tendril", option, file);
  PetscFunctionReturn(0);
}

static PetscErrorCode Attribute(hid_t object, const char *name, hid_t type, const void *value) {
  hid_t space, a;

  PetscFunctionBegin;
  if (H5Aexists(object, name) > 0) HdfCall(H5Adelete(object, name));
  space = H5Screate(H5S_SCALAR);
  a = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  HdfCall(a);
  HdfCall(H5Awrite(a, type, value));
  H5Aclose(a);
  H5Sclose(space);
  PetscFunctionReturn(0);
}

/* HdfAttributeText - sets a text attribute of an open object, replacing what was there. */
PetscErrorCode HdfAttributeText(hid_t object, const char *name, const char *text) {
  hid_t type = H5Tcopy(H5T_C_S1);

  PetscFunctionBegin;
  HdfCall(H5Tset_size(type, strlen(text) + 1));
  PetscCall(Attribute(object, name, type, text));
  H5Tclose(type);
  PetscFunctionReturn(0);
}

/* HdfAttributeReal - sets a real attribute of an open object. */
PetscErrorCode HdfAttributeReal(hid_t object, const char *name, PetscReal value) {
  PetscFunctionBegin;
  PetscCall(Attribute(object, name, H5T_NATIVE_DOUBLE, &value));
  PetscFunctionReturn(0);
}

/* HdfAttributeInt - sets an integer attribute of an open object. */
PetscErrorCode HdfAttributeInt(hid_t object, const char *name, int value) {
  PetscFunctionBegin;
  PetscCall(Attribute(object, name, H5T_NATIVE_INT, &value));
  PetscFunctionReturn(0);
}
