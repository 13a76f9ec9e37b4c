#include "material/stiffness.h"
#include "base/hdf.h"
#include "base/spline.h"

static const OptionRow rows[] = {
    ROW_REAL("-rod_stiffness", "1", 1e-9, 1e9, UNIT_NONE, 0,
             "of one of several rods: its bending stiffness over that of the scales"),
    ROW_TEXT(
        "-rod_stiffness_file", INPUT_FILE,
        "HDF5 file with /distance from the tip, from 0, and /factor: the bending stiffness over "
        "that of the scales, constant beyond the end")};
const OptionGroup stiffness_options = OPTION_GROUP_OF_ROD("Stiffness along the rod", rows);

static PetscErrorCode Check(const char *file, const Stiffness *self, PetscInt m) {
  const PetscReal *d = self->distance;
  const PetscInt n = self->n;
  char text[2][32];

  PetscFunctionBegin;
  UserCheck(n == m && n >= 4, OptionsComm(),
            "-rod_stiffness_file %s: /distance and /factor must have as many entries, 4 at least",
            file);
  UserCheck(d[0] == 0, OptionsComm(), "-rod_stiffness_file %s: /distance must start at 0, the tip",
            file);
  for (PetscInt i = 1; i < n; i++)
    UserCheck(d[i] > d[i - 1], OptionsComm(), "-rod_stiffness_file %s: /distance must increase",
              file);
  for (PetscInt i = 0; i < n; i++)
    UserCheck(self->factor[i] > 0, OptionsComm(),
              "-rod_stiffness_file %s: the factor is %s at distance %s; it must be above 0", file,
              OptionNumber(self->factor[i], text[0]), OptionNumber(d[i], text[1]));
  for (PetscInt i = 0; i < 8 * (n - 1); i++) { /* between the entries too */
    PetscReal z = (PetscReal)(i % 8) / 8, at = (1 - z) * d[i / 8] + z * d[i / 8 + 1], w[4], B = 0;
    PetscInt k;
    SplineWeights(n, d, at, &k, w, NULL, NULL);
    for (int j = 0; j < 2; j++) B += w[j] * self->factor[k + j] + w[2 + j] * self->factor2[k + j];
    UserCheck(B > 0, OptionsComm(),
              "-rod_stiffness_file %s: the factor is %s at distance %s; it must stay above 0, "
              "between the entries too",
              file, OptionNumber(B, text[0]), OptionNumber(at, text[1]));
  }
  PetscFunctionReturn(0);
}

/* StiffnessSetFromOptions - reads and checks the stiffness. Collective; the caller ends it with
   StiffnessDestroy(), also after an error. */
PetscErrorCode StiffnessSetFromOptions(Stiffness *self) {
  const char *option = "-rod_stiffness_file";
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscInt m;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  PetscCall(OptionReal("-rod_stiffness", &self->all, NULL));
  PetscCall(OptionText(option, file, &self->varies));
  if (!self->varies) {
    self->most = self->all;
    PetscFunctionReturn(0);
  }
  PetscCall(HdfReadQuantity(option, file, "/distance", UNIT_LENGTH, 1, &self->n, &self->distance));
  PetscCall(HdfReadQuantity(option, file, "/factor", UNIT_NONE, 1, &m, &self->factor));
  if (self->n == m && m >= 4) {
    PetscCall(PetscMalloc1(m, &self->factor2));
    PetscCall(SplineSecondDerivatives(m, self->distance, 1, m, 1, self->factor, self->factor2));
  }
  PetscCall(Check(file, self, m));
  for (PetscInt i = 0; i < m; i++) {
    self->factor[i] *= self->all;
    self->factor2[i] *= self->all;
    self->most = PetscMax(self->most, self->factor[i]);
  }
  PetscFunctionReturn(0);
}

PetscErrorCode StiffnessDestroy(Stiffness *self) {
  PetscFunctionBegin;
  PetscCall(PetscFree(self->distance));
  PetscCall(PetscFree(self->factor));
  PetscCall(PetscFree(self->factor2));
  PetscFunctionReturn(0);
}

/* StiffnessFinest - the least length along a rod so long over which B changes by as much as it is
   (none is as long as PETSC_MAX_REAL); 0: it is 1 everywhere. */
PetscReal StiffnessFinest(const Stiffness *self, PetscReal length) {
  return self->varies ? SplineSteepest(self->n, self->distance, self->factor, length) : 0;
}

/*
  StiffnessTable - B at the label s and time t, from the table, and the rate B_t at which it changes
  for the material there (may be NULL): material that slides from the tip, or is left behind by it,
  stiffens.
*/
PetscErrorCode StiffnessTable(const Stiffness *self, Growth growth, PetscReal s, PetscReal t,
                              PetscReal *B, PetscReal *B_t) {
  PetscReal L, L_t, p, p_t, w[4], slope[4], d;
  PetscInt i;

  PetscFunctionBegin;
  PetscCall(GrowthLength(growth, t, &L, &L_t));
  PetscCall(GrowthArc(growth, 1, &s, t, &p, &p_t));
  d = growth->even ? (1 - s) * L : L - p; /* the first has no cancellation */
  if (B_t) *B_t = 0;
  if (d >= self->distance[self->n - 1]) {
    *B = self->factor[self->n - 1];
    PetscFunctionReturn(0);
  }
  SplineWeights(self->n, self->distance, PetscMax(d, 0), &i, w, slope, NULL);
  *B = 0;
  for (int k = 0; k < 2; k++) *B += w[k] * self->factor[i + k] + w[2 + k] * self->factor2[i + k];
  if (!B_t) PetscFunctionReturn(0);
  for (int k = 0; k < 2; k++)
    *B_t += slope[k] * self->factor[i + k] + slope[2 + k] * self->factor2[i + k];
  *B_t *= L_t - p_t - GrowthSlide(growth, s, t);
  PetscFunctionReturn(0);
}
