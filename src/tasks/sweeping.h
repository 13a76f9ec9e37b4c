/* A sweep that is under way: what the files of -task sweep share. */
#ifndef TENDRIL_SWEEPING_H
#define TENDRIL_SWEEPING_H

#include "base/handout.h"
#include "record/collection.h"
#include "tasks/single.h"

/* An option that all members share. */
typedef struct {
  char *name, *value; /* value NULL: given without one */
  PetscBool excused;  /* no member need read it */
} Common;

typedef struct {
  PetscInt task, each; /* of a member: what it does, on how many ranks */
  PetscBool quiet;
  char store[64]; /* -sweep_store */
  char output[PETSC_MAX_PATH_LEN], directory[PETSC_MAX_PATH_LEN];
  Table table;
  PetscInt commons;
  Common *common;
  char *options; /* all of what makes two sweeps differ, beside the table, as text */
  Columns columns;
  PetscBool space; /* a member may be a rod in space */
  Collection collection;
  Handout handout;
  MPI_Comm held; /* PETSc's own of the team, that it need not be made again for each member */
  /* rank 0 */
  char fault[HDF_FAULT];              /* why -output cannot be written */
  PetscInt done, ran;                 /* members that have been run: in all, and by this command */
  PetscInt failed, failed_before;     /* of those */
  PetscInt first_member;              /* that failed */
  char first[MEMBER_LINE];            /* its line */
  PetscLogDouble begin, report_after; /* seconds */
  PetscInt reported, report_at;       /* members */
} Sweep;

/* sweep_member.c */
PetscErrorCode SweepTakeCommon(Sweep *self);
PetscErrorCode SweepMakeDirectory(Sweep *self);
PetscErrorCode SweepMember(Sweep *self, PetscInt member);

/* sweep_report.c */
PetscErrorCode SweepHeading(Sweep *self);
PetscErrorCode SweepProgress(Sweep *self);
PetscErrorCode SweepSummary(Sweep *self);

#endif
