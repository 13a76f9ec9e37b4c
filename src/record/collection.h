/* The result file (HDF5) of a sweep: one for all members, whole and readable at any time. */
#ifndef TENDRIL_COLLECTION_H
#define TENDRIL_COLLECTION_H

#include "base/table.h"
#include "record/output.h"

enum { MEMBER_WAITS, MEMBER_FINISHED, MEMBER_FAILED }; /* the status of a member */
enum { MEMBER_LINE = 512 };

/* One member's result: this and, behind it, what it has left (Harvest). It is sent from rank to
   rank as it is. */
typedef struct {
  PetscInt member, status;
  PetscReal seconds;
  PetscInt values, steps, shapes, nodes;
  size_t n;
  char line[MEMBER_LINE]; /* why it failed */
} MemberHead;

/* What is stored of every member. */
typedef struct {
  const char *group; /* of the last values; they are n, each with its name, units and meaning */
  PetscInt n;
  const char *const *name, *const *units, *const *text;
  PetscBool series, shapes;
} Columns;

typedef struct _Collection *Collection;

PetscErrorCode CollectionCreate(const char *path, Table table, const Columns *columns,
                                const char *options, Collection *collection);
PetscErrorCode CollectionDestroy(Collection *collection);
const PetscReal *CollectionStatus(Collection collection);
PetscErrorCode CollectionAdd(Collection collection, const MemberHead *head, const PetscReal data[]);
PetscBool CollectionDue(Collection collection);
PetscErrorCode CollectionStore(Collection collection, PetscBool finished, char fault[HDF_FAULT]);

#endif
