/* Files of HDF5 are read: arrays, rows of them, texts. */
#include "base/hdf_library.h"

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

hid_t HdfOpenToRead(const char *path, char fault[HDF_FAULT]) {
  hid_t f;

  HdfBeQuiet();
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
  if (!me) f = HdfOpenToRead(path, fault);
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
void HdfReadAttribute(hid_t object, const char *name, char *text, size_t length) {
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
  if (!me) f = HdfOpenToRead(path, fault);
  if (f >= 0) {
    d = H5Dopen2(f, name, H5P_DEFAULT);
    HdfReadAttribute(d, "units", units, sizeof(units));
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
    hid_t f = HdfOpenToRead(path, fault);
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
  if (!me && (f = HdfOpenToRead(path, fault)) >= 0) {
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
  f = HdfOpenToRead(path, fault);
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
  HdfBeQuiet();
  return (PetscBool)(H5Fis_hdf5(path) > 0);
}
