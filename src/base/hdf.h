/* The one place that knows the HDF5 C interface: arrays in, growing arrays out. */
#ifndef TENDRIL_HDF_H
#define TENDRIL_HDF_H

#include <petscsys.h>
#include <hdf5.h>

PetscErrorCode HdfRead(const char *option, const char *file, const char *name, int rank,
                       hsize_t dims[], PetscReal **data);
PetscErrorCode HdfExists(const char *file, const char *name, PetscBool *exists);
PetscErrorCode HdfAppendable(hid_t file, const char *name, int rank, const hsize_t row[],
                             const char *attribute, const char *description);
PetscErrorCode HdfAppend(hid_t file, const char *name, hsize_t rows, const PetscReal data[]);
PetscErrorCode HdfWrite(hid_t file, const char *name, int rank, const hsize_t dims[],
                        const PetscReal data[], const char *attribute, const char *description);
PetscErrorCode HdfOverwrite(hid_t file, const char *name, hsize_t n, const PetscReal data[],
                            const char *description);
PetscErrorCode HdfTruncate(hid_t file, const char *name, hsize_t rows);
PetscErrorCode HdfReadAttributeText(const char *option, const char *file, const char *name,
                                    char **text);
PetscErrorCode HdfAttributeText(hid_t object, const char *name, const char *text);
PetscErrorCode HdfAttributeReal(hid_t object, const char *name, PetscReal value);
PetscErrorCode HdfAttributeInt(hid_t object, const char *name, int value);

/* Check a call of the HDF5 library, which reports failure by a negative value. */
#define HdfCall(call)                                                                              \
  PetscCheck((call) >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "HDF5 failed: %s", #call)

#endif
