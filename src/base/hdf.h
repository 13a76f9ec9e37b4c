/* The one place that knows the HDF5 library: arrays in, files out.

   A file is written beside its name and renamed when it is whole, so that under its name there is
   never half a file, whatever ends the program. What goes wrong while it is written (a full disk)
   is kept until HdfClose() tells. */
#ifndef TENDRIL_HDF_H
#define TENDRIL_HDF_H

#include "base/options.h"

enum { HDF_FAULT = 256, HDF_RANK = 4 };

typedef struct _HdfFile *HdfFile;
typedef enum { HDF_REALS, HDF_INTS, HDF_TEXTS } HdfKind; /* of a column */

void HdfBegin(void);

/* writing, on one rank; a file that is NULL takes everything and keeps nothing */
PetscErrorCode HdfCreate(const char *path, HdfFile *file);
PetscErrorCode HdfAmend(const char *from, const char *path, HdfFile *file);
PetscErrorCode HdfClose(HdfFile *file, char fault[HDF_FAULT]);
PetscErrorCode HdfDrop(HdfFile *file);
PetscBool HdfFault(HdfFile file);
PetscErrorCode HdfGroup(HdfFile file, const char *name);
PetscErrorCode HdfWrite(HdfFile file, const char *name, int rank, const PetscInt dims[],
                        const PetscReal data[], const char *units, const char *description);
PetscErrorCode HdfAppendable(HdfFile file, const char *name, int rank, const PetscInt row[],
                             const char *units, const char *description);
PetscErrorCode HdfAppend(HdfFile file, const char *name, PetscInt rows, const PetscReal data[]);
PetscErrorCode HdfColumn(HdfFile file, const char *name, HdfKind kind, PetscInt n,
                         const char *units, const char *description);
PetscErrorCode HdfPut(HdfFile file, const char *name, PetscInt n, const PetscInt rows[],
                      const void *data);
PetscErrorCode HdfTruncate(HdfFile file, const char *name, PetscInt rows);
PetscErrorCode HdfDelete(HdfFile file, const char *name);
PetscErrorCode HdfText(HdfFile file, const char *object, const char *name, const char *text);
PetscErrorCode HdfWriteText(HdfFile file, const char *name, const char *text,
                            const char *description);
PetscErrorCode HdfUnder(HdfFile file, const char *group);
PetscErrorCode HdfReal(HdfFile file, const char *object, const char *name, PetscReal value);
PetscErrorCode HdfInt(HdfFile file, const char *object, const char *name, int value);

/* reading, collective on OptionsComm(): rank 0 reads and tells the others */
PetscErrorCode HdfRead(const char *option, const char *path, const char *name, int rank,
                       PetscInt dims[], PetscReal **data);
PetscErrorCode HdfReadGaps(const char *option, const char *path, const char *name, int rank,
                           PetscInt dims[], PetscReal **data);
PetscErrorCode HdfReadQuantity(const char *option, const char *path, const char *name,
                               Dimension dimension, int rank, PetscInt dims[], PetscReal **data);
PetscErrorCode HdfReadText(const char *option, const char *path, const char *name, char **text);
PetscErrorCode HdfHas(const char *path, const char *name, PetscBool *has);

/* reading, on one rank */
PetscBool HdfIs(const char *path);
PetscErrorCode HdfReadTable(const char *path, PetscInt *columns, PetscInt *rows, char **text,
                            size_t *size, char fault[HDF_FAULT]);
PetscErrorCode HdfReadRow(const char *path, const char *name, PetscInt row, PetscInt n,
                          PetscReal data[], char fault[HDF_FAULT]);

#endif
