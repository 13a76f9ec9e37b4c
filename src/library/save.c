/* A simulation in a file. */
#include "library/simulation.h"

/* The rows of all rods, from those of each. */
static PetscErrorCode SumRows(Tendril self) {
  const Columns *first = &self->sight[0].series;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < first->n; i++) PetscCall(SimulationAddSum(self, i));
  PetscFunctionReturn(0);
}

/* SimulationTakeRows - the series of the run that it goes on with. Collective. */
PetscErrorCode SimulationTakeRows(Tendril self) {
  const Observation *rows;
  Observation row;
  PetscInt n;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < self->rods; k++) {
    OutputRows(CourseRod(self, k)->output, &n, &rows);
    PetscCallMPI(MPI_Bcast(&n, 1, MPIU_INT, 0, self->comm));
    for (PetscInt i = 0; i < n; i++) {
      if (rows) row = rows[i];
      PetscCallMPI(MPI_Bcast(&row, OBSERVED, MPIU_REAL, 0, self->comm));
      PetscCall(ColumnsAdd(&self->sight[k].series, &row));
    }
  }
  if (self->several) PetscCall(SumRows(self));
  PetscFunctionReturn(0);
}

static PetscErrorCode Save(Tendril self, const double *t, const char *file) {
  PetscFunctionBegin;
  UserCheck(CourseIsThere(self), self->comm, "save: nothing to save before TendrilSetUp()");
  UserCheck(file && file[0], self->comm, "save: give the name of a file");
  PetscCall(CourseSave(self, file, t ? *t : self->at, self->at));
  PetscFunctionReturn(0);
}

int TendrilSave(Tendril self, const char *file) {
  int code = SimulationEnter(self);

  return code ? code : SimulationLeave(self, Save(self, NULL, file));
}

int TendrilSaveAt(Tendril self, double t, const char *file) {
  int code = SimulationEnter(self);

  return code ? code : SimulationLeave(self, Save(self, &t, file));
}
