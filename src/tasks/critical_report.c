/* -task critical: what was found is printed and stored. */
#include "tasks/critical.h"
#include "record/output.h"
#include "scene/scales.h"
#include "straight/spectrum.h"
#include "tasks/bent.h"

/* the numbers among the results, in the order of Numbers() */
const char *const critical_name[] = {"t", "length", "error", "frequency"},
                  *const critical_units[] = {"l/V", "l", "l", "rad V/l"},
                  *const critical_text[] = {"critical time", "critical length",
                                            "bound on the error of t and of length",
                                            "frequency of the flutter; 0: buckling"};

static void Numbers(const Critical *self, PetscReal value[CRITICAL_VALUES]) {
  value[0] = self->t;
  value[1] = self->length;
  value[2] = self->error;
  value[3] = self->frequency;
}

/* What a member of a sweep leaves. */
static PetscErrorCode Leave(const Critical *self, Harvest *harvest) {
  PetscFunctionBegin;
  PetscCall(PetscMemzero(harvest, sizeof(*harvest)));
  harvest->values = CRITICAL_VALUES;
  harvest->n = CRITICAL_VALUES;
  PetscCall(PetscMalloc1(CRITICAL_VALUES, &harvest->data));
  Numbers(self, harvest->data);
  PetscFunctionReturn(0);
}

/* The mode of a rod in space, and when the other direction follows. */
static PetscErrorCode WriteSpace(HdfFile file, const Critical *self) {
  const PetscInt n = self->n;
  const struct {
    const char *name, *units, *text;
    const PetscReal *data;
  } sets[] = {{"x2", "1", "critical mode, deflection in x2, largest in space 1 [n]", self->y},
              {"x3", "1", "its deflection in x3 [n]", self->y3},
              {"theta2", "1/l", "its angle dx2/dp [n]", self->theta},
              {"theta3", "1/l", "its angle dx3/dp [n]", self->theta3}};
  char name[64];

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(sets); i++) {
    (void)snprintf(name, sizeof(name), "/critical/%s", sets[i].name);
    PetscCall(HdfWrite(file, name, 1, &n, sets[i].data, sets[i].units, sets[i].text));
  }
  PetscCall(HdfWrite(file, "/critical/twisting_moment", 0, NULL, &self->twisting, "N l^2",
                     "moment about the rod's axis"));
  if (!self->follows) PetscFunctionReturn(0);
  PetscCall(HdfWrite(file, "/critical/t_other", 0, NULL, &self->other[0], "l/V",
                     "when the stiffer direction follows"));
  PetscCall(
      HdfWrite(file, "/critical/length_other", 0, NULL, &self->other[1], "l", "the length then"));
  PetscFunctionReturn(0);
}

static PetscErrorCode Write(Scene scene, HdfFile file, const Critical *self) {
  const PetscInt n = self->n;
  PetscReal value[CRITICAL_VALUES];
  char name[64];

  PetscFunctionBegin;
  if (!file) PetscFunctionReturn(0);
  Numbers(self, value);
  PetscCall(HdfGroup(file, "/critical"));
  for (int k = 0; k < CRITICAL_VALUES; k++) {
    (void)snprintf(name, sizeof(name), "/critical/%s", critical_name[k]);
    PetscCall(HdfWrite(file, name, 0, NULL, &value[k], critical_units[k], critical_text[k]));
  }
  PetscCall(HdfWrite(file, "/critical/s", 1, &n, self->s, "1", "material label [n]"));
  if (self->space)
    PetscCall(WriteSpace(file, self));
  else {
    PetscCall(HdfWrite(file, "/critical/y", 1, &n, self->y, "1",
                       "critical mode, deflection, largest 1 [n]"));
    PetscCall(HdfWrite(file, "/critical/theta", 1, &n, self->theta, "1/l", "its angle dy/dp [n]"));
  }
  PetscCall(OutputAttributes(file, scene->comm, PETSC_TRUE));
  PetscFunctionReturn(0);
}

/* CriticalPrintLaboratory - prints what it is in the laboratory, as far as that is known.
   Collective. */
PetscErrorCode CriticalPrintLaboratory(MPI_Comm comm, const Critical *self) {
  PetscReal second = OptionsScale(UNIT_TIME);
  char length[32], time[32];

  PetscFunctionBegin;
  OptionInLaboratory(self->length, UNIT_LENGTH, length);
  OptionInLaboratory(self->t, UNIT_TIME, time);
  if (!length[0]) PetscFunctionReturn(0);
  PetscCall(PetscPrintf(comm, "in the laboratory: %s%s%sL = %s", time[0] ? "t = " : "", time,
                        time[0] ? ", " : "", length));
  if (self->frequency > 0 && second > 0)
    PetscCall(PetscPrintf(comm, ", frequency %.6g rad/s", (double)(self->frequency / second)));
  PetscCall(PetscPrintf(comm, "\n"));
  PetscFunctionReturn(0);
}

/* A mode is one of x2 or x3 if so little of it is in the other. */
static const PetscReal sure = 1e-6;

/* In which direction across, in space. */
static PetscErrorCode PrintWay(MPI_Comm comm, const Critical *self) {
  const char *const name[] = {"x2 (about d3)", "x3 (about d2)"};
  char text[64] = "not as far as was looked";

  PetscFunctionBegin;
  if (!self->space) PetscFunctionReturn(0);
  if (self->bent) {
    PetscCall(PetscPrintf(comm, "of a bent rod, %s\n",
                          self->sideways > 1 - sure ? "sideways: in x3"
                          : self->sideways < sure   ? "in its plane: in x2"
                                                    : "in x2 and x3 at once"));
    PetscFunctionReturn(0);
  }
  if (self->follows)
    (void)snprintf(text, sizeof(text), "at t = %.12g, L = %.12g", (double)self->other[0],
                   (double)self->other[1]);
  if (self->way == WAY_BOTH)
    PetscCall(PetscPrintf(comm, "in x2 and x3 at once, under a twisting moment of %.10g\n",
                          (double)self->twisting));
  else if (self->ways > 1)
    PetscCall(PetscPrintf(comm, "in %s; in %s %s\n", name[self->way], name[!self->way], text));
  else
    PetscCall(PetscPrintf(comm, "alike in all directions across\n"));
  PetscFunctionReturn(0);
}

static PetscErrorCode Print(Scene scene, const Critical *self) {
  const Mesh labels = {.cells = self->n - 1, .s = self->s};
  MPI_Comm comm = scene->comm;
  double cube = (double)(self->length * self->length * self->length);
  char looks[128];

  PetscFunctionBegin;
  PetscCall(ScalesTell(scene, &labels, "-rod_cells", labels.cells, self->t));
  PetscCall(PetscPrintf(
      comm, "critical time   t = %.12g\ncritical length L = %.12g\nerror below     %.1e\n",
      (double)self->t, (double)self->length, (double)self->error));
  if (self->frequency > 0)
    PetscCall(PetscPrintf(comm, "flutter, frequency %.6g per unit of t (L^3 = %.8g)\n",
                          (double)self->frequency, cube));
  else
    PetscCall(PetscPrintf(comm, "buckling (L^3 = %.10g)\n", cube));
  if (CriticalLooks(self, looks, sizeof(looks))[0])
    PetscCall(PetscPrintf(comm, "stable before%s\n", looks));
  PetscCall(PrintWay(comm, self));
  PetscCall(CriticalPrintLaboratory(comm, self));
  if (self->t < 0) PetscCall(PetscPrintf(comm, "the rod is longer than that from the start\n"));
  PetscFunctionReturn(0);
}

/* member NULL: a run of its own. */
static PetscErrorCode FindAndStore(Scene scene, const char *output, Member *member) {
  Critical critical = {0};
  HdfFile file = NULL;
  PetscErrorCode error;
  PetscBool bent;

  PetscFunctionBegin;
  PetscCall(BentAsked(scene, &bent));
  if (bent)
    PetscCall(BentReadOptions(scene));
  else
    PetscCall(SpectrumReadOptions());
  PetscCall(OptionsRefuseUnread());
  if (output[0]) PetscCall(OutputNewFile("-output", output, scene->comm, &file));
  error =
      bent ? BentFind(scene, PETSC_FALSE, &critical) : CriticalFind(scene, PETSC_FALSE, &critical);
  if (!error) error = member ? Leave(&critical, &member->harvest) : Print(scene, &critical);
  if (!error) error = Write(scene, file, &critical);
  PetscCall(CriticalDestroy(&critical));
  if (error) PetscCall(OutputDropFile(output, &file));
  PetscCall(error);
  if (output[0]) PetscCall(OutputEndFile("-output", output, scene->comm, &file));
  PetscFunctionReturn(0);
}

/*
  CriticalRun - -task critical: finds the critical time, prints it and stores it with its mode.
  Collective on the scene's ranks.

  output   the result file, "": none
*/
PetscErrorCode CriticalRun(Scene scene, const char *output) {
  PetscFunctionBegin;
  PetscCall(FindAndStore(scene, output, NULL));
  PetscFunctionReturn(0);
}

/* CriticalMember - as CriticalRun(), of a member of a sweep: nothing is printed, and the numbers
   are left in memory. Collective on the scene's ranks. */
PetscErrorCode CriticalMember(Scene scene, const char *output, Member *member) {
  PetscFunctionBegin;
  PetscCall(FindAndStore(scene, output, member));
  PetscFunctionReturn(0);
}
