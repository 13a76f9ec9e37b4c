/* A simulation in a file. */
#include "library/simulation.h"

/* SimulationTakeRows - the series of the run that it goes on with. Collective. */
PetscErrorCode SimulationTakeRows(Tendril self) {
  const Observation *rows;
  Observation row;
  PetscInt n;

  PetscFunctionBegin;
  OutputRows(self->grow->output, &n, &rows);
  PetscCallMPI(MPI_Bcast(&n, 1, MPIU_INT, 0, self->comm));
  for (PetscInt k = 0; k < n; k++) {
    if (rows) row = rows[k];
    PetscCallMPI(MPI_Bcast(&row, OBSERVED, MPIU_REAL, 0, self->comm));
    PetscCall(ColumnsAdd(&self->series, &row));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Save(Tendril self, const double *t, const char *file) {
  PetscFunctionBegin;
  UserCheck(self->grow, self->comm, "save: nothing to save before TendrilSetUp()");
  UserCheck(file && file[0], self->comm, "save: give the name of a file");
  PetscCall(GrowSave(self->grow, file, t ? *t : self->at, self->at));
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
