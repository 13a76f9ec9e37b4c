#include "tasks/critical.h"
#include "record/output.h"
#include "straight/spectrum.h"
#include "straight/straight.h"

/* the numbers among the results, in the order of Numbers() */
const char *const critical_name[] = {"t", "length", "error", "frequency"},
                  *const critical_units[] = {"l/V", "l", "l", "rad V/l"},
                  *const critical_text[] = {"critical time", "critical length",
                                            "bound on the error of t and of length",
                                            "frequency of the flutter; 0: buckling"};

enum { SHARED_CELLS = 5000, SCAN_CELLS = 64, SCAN_STEPS = 100, ROOT_STEPS = 60 };

/* A growth factor as a function of t, negative while the straight rod is stable. */
typedef struct {
  Mesh mesh;
  Pencil pencil;
  Spectrum spectrum;
  PetscBool dense;     /* all eigenvalues of a small matrix, to be sure of the rightmost */
  PetscReal frequency; /* of the latest evaluation */
  PetscReal *c, *w;    /* its mode, if asked for */
} Factor;

/* On a mesh of cells equidistant in arc length. */
static PetscErrorCode FactorCreate(MPI_Comm comm, Scene scene, PetscInt cells, PetscBool dense,
                                   PetscBool quiet, Factor *self) {
  PetscFunctionBegin;
  self->dense = dense;
  PetscCall(MeshCreate(cells, PETSC_FALSE, scene->growth, scene->end_time, &self->mesh));
  PetscCall(PencilCreate(comm, scene, &self->mesh, map_follows, &self->pencil));
  PetscCall(SpectrumCreate(self->pencil, quiet, &self->spectrum));
  PetscFunctionReturn(0);
}

static PetscErrorCode FactorDestroy(Factor *self) {
  PetscFunctionBegin;
  PetscCall(SpectrumDestroy(&self->spectrum));
  PetscCall(PencilDestroy(&self->pencil));
  PetscCall(MeshDestroy(&self->mesh));
  PetscCall(PetscFree2(self->c, self->w));
  PetscFunctionReturn(0);
}

/* Where K is symmetric and the tip free, ln(ratio) of SpectrumBuckling(), nearly straight over ln
   L: L^3 times a constant for uniform growth. Else the largest real part of an eigenvalue. */
static PetscErrorCode FactorAt(Factor *self, PetscReal t, PetscReal *f) {
  Eigenvalue value;

  PetscFunctionBegin;
  if (!self->pencil->skew && !self->pencil->held) {
    PetscCall(SpectrumBuckling(&self->spectrum, t, &value, self->c, self->w));
    *f = value.value > 0 ? PetscLogReal(value.value) : PETSC_MIN_REAL;
  } else {
    if (self->dense)
      PetscCall(SpectrumRightmost(self->pencil, t, &value));
    else
      PetscCall(SpectrumLargest(&self->spectrum, RATE_A, t, &value, self->c, self->w));
    *f = value.value;
  }
  self->frequency = value.frequency;
  PetscFunctionReturn(0);
}

/* Root in [a, b], f(a) < 0 <= f(b): false position, the stale end's value scaled down (Anderson and
   Bjoerck), with bisection where f is not finite. */
static PetscErrorCode Root(Factor *self, PetscReal a, PetscReal fa, PetscReal b, PetscReal fb,
                           PetscReal *root) {
  PetscReal f = 0, t = b;

  PetscFunctionBegin;
  for (int k = 0; k < ROOT_STEPS && fb != 0; k++) {
    PetscReal old = t;
    t = fa > -1e300 ? (a * fb - b * fa) / (fb - fa) : (a + b) / 2;
    if (!(t > a && t < b)) t = (a + b) / 2;
    PetscCall(FactorAt(self, t, &f));
    if (f == 0 || PetscAbsReal(t - old) <= 2e-13 * PetscAbsReal(t)) break;
    if (f < 0) { /* b is stale if it was kept before too */
      if (fb > 0 && fa > -1e300 && old <= a) fb *= f / fa < 1 ? 1 - f / fa : 0.5;
      a = t;
      fa = f;
    } else {
      if (old >= b && fa > -1e300) fa *= f / fb < 1 ? 1 - f / fb : 0.5;
      b = t;
      fb = f;
    }
    if (b - a <= 2e-13 * PetscAbsReal(b)) break;
  }
  *root = t;
  PetscFunctionReturn(0);
}

/* The first bracket of a crossing, found in steps of 5 % of the length. The rod may also be
   unstable from the start. */
static PetscErrorCode ScanWith(Factor *coarse, Scene scene, PetscReal *low, PetscReal *high) {
  PetscReal T = scene->end_time, f, L, L_t;
  char text[64];

  PetscFunctionBegin;
  *low = *high = 0;
  PetscCall(FactorAt(coarse, 0, &f));
  UserCheck(
      f < 0, scene->comm,
      "-growth_initial_length: the straight rod is unstable already at t = 0, take it shorter");
  while (f < 0 && *high < T) {
    PetscCall(GrowthLength(scene->growth, *high, &L, &L_t));
    *low = *high;
    *high += PetscMin(0.05 * L / PetscMax(PetscAbsReal(L_t), 1e-12), T / SCAN_STEPS);
    *high = PetscMin(*high, T);
    PetscCall(FactorAt(coarse, *high, &f));
  }
  UserCheck(f >= 0, scene->comm,
            "-ts_max_time %s: the straight rod is stable up to there, look further",
            OptionBoth(T, UNIT_TIME, text));
  PetscFunctionReturn(0);
}

static PetscErrorCode Scan(Scene scene, PetscReal *low, PetscReal *high) {
  PetscErrorCode error;
  Factor coarse = {0};

  PetscFunctionBegin;
  error = FactorCreate(PETSC_COMM_SELF, scene, SCAN_CELLS, PETSC_TRUE, PETSC_TRUE, &coarse);
  if (!error) error = ScanWith(&coarse, scene, low, high);
  PetscCall(FactorDestroy(&coarse));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* A root near a bracket that belongs to another mesh: widen it till it holds. */
static PetscErrorCode RootNear(Factor *self, PetscReal low, PetscReal high, PetscReal *root) {
  PetscReal f_low, f_high, d = high - low;

  PetscFunctionBegin;
  PetscCall(FactorAt(self, low, &f_low));
  for (; f_low >= 0 && low > 0; d *= 4) {
    low = PetscMax(0, low - d);
    PetscCall(FactorAt(self, low, &f_low));
  }
  PetscCall(FactorAt(self, high, &f_high));
  for (; f_high < 0; d *= 4) {
    high += d;
    PetscCall(FactorAt(self, high, &f_high));
  }
  PetscCall(Root(self, low, f_low, high, f_high, root));
  PetscFunctionReturn(0);
}

/* The critical time on one mesh. Uniform growth takes one solve: L^3 / ratio = L_cr^3. */
static PetscErrorCode OnMesh(Scene scene, Factor *factor, PetscReal low, PetscReal high,
                             PetscReal *t) {
  Eigenvalue ratio;
  PetscReal L;

  PetscFunctionBegin;
  if (StraightScales(scene) && !factor->pencil->skew) {
    PetscCall(GrowthLength(scene->growth, 1, &L, NULL));
    PetscCall(SpectrumBuckling(&factor->spectrum, 1, &ratio, factor->c, factor->w));
    *t = L / PetscPowReal(ratio.value, 1. / 3) - scene->growth->initial_length;
  } else
    PetscCall(RootNear(factor, low, high, t));
  PetscFunctionReturn(0);
}

/* The mode at the nodes, scaled to largest |y| = 1 and to the side of y(1) > 0. */
static PetscErrorCode StoreMode(Scene scene, const Factor *factor, Critical *self) {
  PetscReal most = 0;

  PetscFunctionBegin;
  self->n = factor->pencil->n;
  PetscCall(PetscMalloc3(self->n, &self->s, self->n, &self->y, self->n, &self->theta));
  PetscCall(PetscArraycpy(self->s, factor->pencil->node, self->n));
  PetscCall(PencilShape(factor->pencil, factor->c, factor->w, self->t, self->y, self->theta));
  for (PetscInt i = 0; i < self->n; i++) most = PetscMax(most, PetscAbsReal(self->y[i]));
  if (self->y[self->n - 1] < 0) most = -most;
  for (PetscInt i = 0; i < self->n; i++) {
    self->y[i] /= most;
    self->theta[i] /= most;
  }
  PetscFunctionReturn(0);
}

/* Ranks that solved it each for itself differ in the last digit: rank 0's word counts. */
static PetscErrorCode Agree(Scene scene, Critical *self) {
  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(&self->t, 1, MPIU_REAL, 0, scene->comm));
  PetscCallMPI(MPI_Bcast(&self->length, 1, MPIU_REAL, 0, scene->comm));
  PetscCallMPI(MPI_Bcast(&self->error, 1, MPIU_REAL, 0, scene->comm));
  PetscCallMPI(MPI_Bcast(&self->frequency, 1, MPIU_REAL, 0, scene->comm));
  PetscCallMPI(MPI_Bcast(self->y, self->n, MPIU_REAL, 0, scene->comm));
  PetscCallMPI(MPI_Bcast(self->theta, self->n, MPIU_REAL, 0, scene->comm));
  PetscFunctionReturn(0);
}

/* The critical time on two meshes, of which the finer is kept. */
static PetscErrorCode FindWith(Factor *fine, Factor *half, Scene scene, PetscBool quiet,
                               Critical *self) {
  PetscReal low = 0, high = 0, half_t, near = 1e-8;
  PetscInt cells = scene->mesh.cells, n = cells + 1;
  MPI_Comm comm = cells < SHARED_CELLS ? PETSC_COMM_SELF : scene->comm;

  PetscFunctionBegin;
  PetscCall(FactorCreate(comm, scene, cells, PETSC_FALSE, quiet, fine));
  if (!StraightScales(scene) || fine->pencil->skew) PetscCall(Scan(scene, &low, &high));
  PetscCall(FactorCreate(comm, scene, (cells + 1) / 2, PETSC_FALSE, quiet, half));
  PetscCall(OnMesh(scene, half, low, high, &half_t));
  PetscCall(PetscMalloc2(n, &fine->c, n, &fine->w));
  PetscCall(OnMesh(scene, fine, half_t - near, half_t + near, &self->t));
  PetscCall(GrowthLength(scene->growth, self->t, &self->length, NULL));
  self->frequency = fine->frequency;
  self->error = PetscAbsReal(self->t - half_t) +
                PetscMax(1, self->length) * (1e-14 + 1e-17 * PetscSqr((PetscReal)n));
  PetscCall(StoreMode(scene, fine, self));
  PetscCall(Agree(scene, self));
  PetscFunctionReturn(0);
}

/*
  CriticalFind - the critical time and length of a scene, with the error and the mode. Collective on
  the scene's ranks.

  Below SHARED_CELLS every rank solves it for itself, which is faster than to share it.

  quiet      takes no solver options from the command line
  critical   the caller frees its arrays with CriticalDestroy()

  The mesh has -rod_cells cells, equidistant in arc length. The error bound is the change from half
  the mesh (of order 4, so the error itself is about a fifteenth of it) and what rounding does to a
  second-order matrix of this size.
*/
PetscErrorCode CriticalFind(Scene scene, PetscBool quiet, Critical *self) {
  Factor fine = {0}, half = {0};
  PetscErrorCode error;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  error = FindWith(&fine, &half, scene, quiet, self);
  PetscCall(FactorDestroy(&half));
  PetscCall(FactorDestroy(&fine));
  PetscCall(error);
  PetscFunctionReturn(0);
}

PetscErrorCode CriticalDestroy(Critical *self) {
  PetscFunctionBegin;
  PetscCall(PetscFree3(self->s, self->y, self->theta));
  PetscFunctionReturn(0);
}

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
  PetscCall(HdfWrite(file, "/critical/y", 1, &n, self->y, "1",
                     "critical mode, deflection, largest 1 [n]"));
  PetscCall(HdfWrite(file, "/critical/theta", 1, &n, self->theta, "1/l", "its angle dy/dp [n]"));
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

static PetscErrorCode Print(MPI_Comm comm, const Critical *self) {
  double cube = (double)(self->length * self->length * self->length);

  PetscFunctionBegin;
  PetscCall(PetscPrintf(
      comm, "critical time   t = %.12g\ncritical length L = %.12g\nerror below     %.1e\n",
      (double)self->t, (double)self->length, (double)self->error));
  if (self->frequency > 0)
    PetscCall(PetscPrintf(comm, "flutter, frequency %.6g per unit of t (L^3 = %.8g)\n",
                          (double)self->frequency, cube));
  else
    PetscCall(PetscPrintf(comm, "buckling (L^3 = %.10g)\n", cube));
  PetscCall(CriticalPrintLaboratory(comm, self));
  if (self->t < 0) PetscCall(PetscPrintf(comm, "the rod is longer than that from the start\n"));
  PetscFunctionReturn(0);
}

/* member NULL: a run of its own. */
static PetscErrorCode FindAndStore(Scene scene, const char *output, Member *member) {
  Critical critical = {0};
  HdfFile file = NULL;
  PetscErrorCode error;

  PetscFunctionBegin;
  PetscCall(SpectrumReadOptions());
  PetscCall(OptionsRefuseUnread());
  if (output[0]) PetscCall(OutputNewFile("-output", output, scene->comm, &file));
  error = CriticalFind(scene, PETSC_FALSE, &critical);
  if (!error) error = member ? Leave(&critical, &member->harvest) : Print(scene->comm, &critical);
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
