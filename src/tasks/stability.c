/* -task stability: what is asked for, the solvers, and the order of the work. */
#include "tasks/stability_run.h"
#include "tasks/stability.h"
#include "record/output.h"
#include "scene/scales.h"

/* Below SHARED_VERTICES every rank solves it for itself, which is faster than to share it. */
enum { SHARED_VERTICES = 5000 };
/* Where tables bend, between the points of the table of curves, a mesh of so many vertices looks.
 */
enum { FEW_VERTICES = 65, MOST_BENDS = 5000 };
/* Of a rod whose material learns all modes are looked at on so many cells. */
enum { LEARNED_CELLS = 32 };
enum { MODE_CELLS = 400, MOST_DENSE = 4000 };

static const OptionRow rows[] = {
    ROW_REAL("-stability_start", "0", 0, 1e6, UNIT_TIME, 0, "first time of the table"),
    ROW_REAL("-stability_end", "", 0, 1e6, UNIT_TIME, 0,
             "last time of the table (t_cr if not set)"),
    ROW_INT("-stability_points", "50", 1, 1000000, 0, "times in the table"),
    ROW_INT("-stability_vertices", "1000", 9, 20000000, 0, "size of the matrices"),
    ROW_WORD("-stability_norm", "left", "friction,left", 0,
             "how the rows of W are scaled: to length 1 in the friction norm, or (left) in the L2 "
             "norm"),
    ROW_BOOL("-stability_only_modes", "false", 0, "the eigenvalues of A alone, for huge matrices"),
    ROW_BOOL("-stability_transient", "true", 0, "the largest transient growth, by its propagator"),
    ROW_REAL("-stability_transient_start", "", 0, 1e6, UNIT_TIME, 0,
             "t1 of its window (-stability_start if not set)"),
    ROW_REAL("-stability_transient_end", "", 0, 1e6, UNIT_TIME, 0,
             "t2 of its window (-stability_end if not set)"),
    ROW_INT("-stability_transient_cells", "200", 8, 2000, 0, "cells of its mesh"),
    ROW_TEXT("-stability_optimal_shape", OUTPUT_FILE,
             "HDF5 file for the initial shape that grows most in L2, for -shape_file (take a "
             "-shape_amplitude of 1e-5 or less: it bends right at the tip)")};
const OptionGroup stability_options = OPTION_GROUP("-task stability", rows);

static PetscErrorCode TransientOptions(Settings *set) {
  PetscFunctionBegin;
  PetscCall(OptionBool("-stability_transient", &set->transient, NULL));
  PetscCall(OptionReal("-stability_transient_start", &set->t1, &set->t1_given));
  PetscCall(OptionReal("-stability_transient_end", &set->t2, &set->t2_given));
  PetscCall(OptionInt("-stability_transient_cells", &set->transient_cells, NULL));
  PetscCall(OptionText("-stability_optimal_shape", set->shape, NULL));
  UserCheck(set->transient || !set->shape[0], OptionsComm(),
            "-stability_optimal_shape needs -stability_transient");
  PetscFunctionReturn(0);
}

static PetscErrorCode ReadSettings(Scene scene, Settings *set) {
  PetscInt choice;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(set, sizeof(*set)));
  PetscCall(OptionReal("-stability_start", &set->start, NULL));
  PetscCall(OptionReal("-stability_end", &set->end, &set->end_given));
  PetscCall(OptionInt("-stability_points", &set->points, NULL));
  PetscCall(OptionInt("-stability_vertices", &set->vertices, NULL));
  PetscCall(OptionWord("-stability_norm", &choice, NULL));
  PetscCall(OptionBool("-stability_only_modes", &set->only_modes, NULL));
  PetscCall(TransientOptions(set));
  set->unit_rows = (PetscBool)choice;
  UserCheck(!set->end_given || set->end > set->start, OptionsComm(),
            "-stability_end %g: give a time after -stability_start %g", (double)set->end,
            (double)set->start);
  UserCheck(PetscMax(set->end, set->t2) <= scene->growth->end_time, OptionsComm(),
            "-stability_end: the growth table ends at t = %g", (double)scene->growth->end_time);
  PetscFunctionReturn(0);
}

/* Reads the options of solvers that are made only once t_cr is known, so that a mistyped one is
   refused now. */
static PetscErrorCode ReadSolverOptions(void) {
  EPS eps;

  PetscFunctionBegin;
  PetscCall(EPSCreate(OptionsComm(), &eps));
  PetscCall(EPSSetOptionsPrefix(eps, "norm_"));
  PetscCall(EPSSetType(eps, EPSGD));
  PetscCall(EPSSetFromOptions(eps));
  PetscCall(EPSDestroy(&eps));
  PetscFunctionReturn(0);
}

/* The left eigenvectors at t_cr, dense, on every rank. */
static PetscErrorCode CreateLeft(Stability *self, Solvers *of) {
  PetscInt n = self->set.vertices;
  PetscReal *W;
  Pencil own;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n * n, &W));
  PetscCall(
      PencilCreate(PETSC_COMM_SELF, self->scene, &self->mesh, self->critical.t, of->way, &own));
  PetscCall(SpectrumLeftVectors(own, self->critical.t, self->set.unit_rows, W));
  PetscCall(NormCreate(of->fixed, W, self->critical.t, &of->left));
  PetscCall(PencilDestroy(&own));
  PetscCall(PetscFree(W));
  PetscFunctionReturn(0);
}

/* Which curves there are. Norms that take left eigenvectors or plain L2 are of one direction. */
static PetscErrorCode ChooseCurves(Stability *self) {
  const PetscBool all = (PetscBool)(!self->set.only_modes && !self->learns),
                  norms = (PetscBool)(all && !self->twisted);

  PetscFunctionBegin;
  self->has[CURVE_A] = PETSC_TRUE;
  self->has[CURVE_FRICTION] = all;
  self->has[CURVE_L2] = norms;
  self->has[CURVE_W] = (PetscBool)(norms && self->set.vertices <= MOST_DENSE);
  if (all && self->twisted)
    PetscCall(PetscPrintf(OptionsComm(),
                          "the L2 and W norms and the transient growth left out: they are of one "
                          "direction across, and twist joins both\n"));
  if (self->learns && !self->set.only_modes)
    PetscCall(PetscPrintf(OptionsComm(),
                          "norms and transient growth left out: they are of a rod whose material "
                          "learns nothing\n"));
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateSolvers(Stability *self, Solvers *of) {
  Scene scene = self->scene;

  PetscFunctionBegin;
  if (self->learns) PetscFunctionReturn(0);
  PetscCall(SpectrumCreate(of->follow, PETSC_TRUE, &of->friction));
  if (!self->has[CURVE_L2]) PetscFunctionReturn(0);
  PetscCall(PencilCreate(self->comm, scene, &self->mesh, self->critical.t, of->way, &of->fixed));
  PetscCall(NormCreate(of->fixed, NULL, self->critical.t, &of->l2));
  if (self->has[CURVE_W])
    PetscCall(CreateLeft(self, of));
  else if (self->set.vertices > MOST_DENSE)
    PetscCall(PetscPrintf(OptionsComm(),
                          "C(t) left out: above -stability_vertices %d the dense left eigenvectors "
                          "take too much\n",
                          MOST_DENSE));
  PetscFunctionReturn(0);
}

static PetscErrorCode CreateMesh(Stability *self) {
  Scene scene = self->scene;
  StraightWay way[MOST_WAYS];

  PetscFunctionBegin;
  PetscCall(
      MeshCreate(self->set.vertices - 1, PETSC_FALSE, scene->growth, scene->end_time, &self->mesh));
  self->twisted = StraightIsTwisted(scene);
  self->learns = TropismLearns(&scene->tropism);
  self->ways = StraightWays(scene, way);
  for (PetscInt k = 0; k < self->ways; k++) {
    Solvers *of = &self->of[k];
    of->way = way[k];
    if (self->learns) {
      PetscCall(SensesCreate(scene, LEARNED_CELLS, of->way, &of->few));
      PetscCall(SensesCreate(scene, self->set.vertices - 1, of->way, &of->all));
      continue;
    }
    PetscCall(PencilCreate(self->comm, scene, &self->mesh, map_follows, of->way, &of->follow));
    PetscCall(SpectrumCreate(of->follow, (PetscBool)(k > 0 || self->quiet), &of->modes));
  }
  PetscFunctionReturn(0);
}

/* The same curves on few vertices, if the scene has tables that bend. */
static PetscErrorCode CreateFew(Stability *self) {
  Stability *few;

  PetscFunctionBegin;
  self->straight_on = 1e-3;
  PetscCall(SceneFewBends(self->scene, MOST_BENDS, &self->straight_on, &self->bends));
  if (!self->bends.n) PetscFunctionReturn(0);
  PetscCall(PetscNew(&few));
  self->few = few;
  few->scene = self->scene;
  few->comm = PETSC_COMM_SELF;
  few->quiet = PETSC_TRUE;
  few->set = self->set;
  few->set.vertices = FEW_VERTICES;
  few->critical.t = self->critical.t;
  PetscCall(PetscArraycpy(few->has, self->has, CURVES));
  PetscCall(CreateMesh(few));
  for (PetscInt k = 0; k < few->ways; k++) PetscCall(CreateSolvers(few, &few->of[k]));
  PetscFunctionReturn(0);
}

/* Ranges that depend on t_cr. */
static PetscErrorCode CompleteSettings(Settings *set, PetscReal t_cr) {
  PetscFunctionBegin;
  if (!set->end_given) set->end = t_cr;
  UserCheck(
      set->end > set->start, OptionsComm(),
      "-stability_end: the rod is unstable from t = %g on, before -stability_start %g; give an "
      "end after that",
      (double)t_cr, (double)set->start);
  if (!set->t1_given) set->t1 = set->start;
  if (!set->t2_given) set->t2 = set->end;
  UserCheck(!set->transient || set->t2 > set->t1, OptionsComm(),
            "-stability_transient_end %g: give a time after -stability_transient_start %g",
            (double)set->t2, (double)set->t1);
  PetscFunctionReturn(0);
}

static PetscErrorCode Destroy(Stability *self) {
  PetscFunctionBegin;
  PetscCall(HdfDrop(&self->file));
  PetscCall(HdfDrop(&self->shape_file));
  for (PetscInt k = 0; k < MOST_WAYS; k++) {
    Solvers *of = &self->of[k];
    PetscCall(SpectrumDestroy(&of->modes));
    PetscCall(SpectrumDestroy(&of->friction));
    PetscCall(SensesDestroy(&of->few));
    PetscCall(SensesDestroy(&of->all));
    if (of->l2.pencil) PetscCall(NormDestroy(&of->l2));
    if (of->left.pencil) PetscCall(NormDestroy(&of->left));
    PetscCall(PencilDestroy(&of->follow));
    PetscCall(PencilDestroy(&of->fixed));
    PetscCall(PetscFree(self->modes[k]));
  }
  PetscCall(CriticalDestroy(&self->critical));
  PetscCall(MeshDestroy(&self->mesh));
  PetscCall(PetscFree2(self->t, self->frequency));
  for (int c = 0; c < CURVES; c++) PetscCall(PetscFree(self->value[c]));
  PetscCall(BendsDestroy(&self->bends));
  PetscFunctionReturn(0);
}

/* Also of the curves on few vertices. */
static PetscErrorCode DestroyAll(Stability *self) {
  PetscFunctionBegin;
  if (self->few) PetscCall(Destroy(self->few));
  PetscCall(PetscFree(self->few));
  PetscCall(Destroy(self));
  PetscFunctionReturn(0);
}

/* Reads everything, opens the files. */
static PetscErrorCode Open(Stability *self, const char *output) {
  Scene scene = self->scene;

  PetscFunctionBegin;
  UserCheck(scene->tip.type == TIP_FREE, scene->comm,
            "-tip_type: -task stability is about a free tip; -task critical knows the others");
  PetscCall(ReadSettings(scene, &self->set));
  UserCheck(!TropismLearns(&scene->tropism) || !self->set.shape[0], scene->comm,
            "-stability_optimal_shape: what grows most is known of a rod whose material learns "
            "nothing; take it out");
  self->comm = self->set.vertices < SHARED_VERTICES ? PETSC_COMM_SELF : scene->comm;
  PetscCall(CreateMesh(self));
  PetscCall(ReadSolverOptions());
  PetscCall(OptionsRefuseUnread());
  if (output[0]) PetscCall(OutputNewFile("-output", output, scene->comm, &self->file));
  if (self->set.shape[0])
    PetscCall(
        OutputNewFile("-stability_optimal_shape", self->set.shape, scene->comm, &self->shape_file));
  PetscFunctionReturn(0);
}

/* The lengths that are missed by the mesh of the critical time, or by that of the table. */
static PetscErrorCode TellScales(const Stability *self) {
  const Mesh labels = {.cells = self->critical.n - 1, .s = self->critical.s};

  PetscFunctionBegin;
  if (self->critical.n)
    PetscCall(ScalesTell(self->scene, &labels, "-rod_cells", labels.cells, self->critical.t));
  PetscCall(ScalesTell(self->scene, &self->mesh, "-stability_vertices", self->set.vertices,
                       self->set.end));
  PetscFunctionReturn(0);
}

/* When the straight rod turns unstable. Not looked for where the end of the table is given and the
   material learns: such a rod may swing whatever its length. */
static PetscErrorCode FindCritical(Stability *self) {
  PetscFunctionBegin;
  if (self->learns && self->set.end_given) PetscFunctionReturn(0);
  PetscCall(CriticalFind(self->scene, PETSC_TRUE, &self->critical));
  PetscCall(PetscPrintf(OptionsComm(), "critical time t = %.12g, error below %.1e\n",
                        (double)self->critical.t, (double)self->critical.error));
  PetscCall(CriticalPrintLaboratory(OptionsComm(), &self->critical));
  PetscFunctionReturn(0);
}

static PetscErrorCode Compute(Stability *self) {
  PetscFunctionBegin;
  PetscCall(FindCritical(self));
  PetscCall(CompleteSettings(&self->set, self->critical.t));
  PetscCall(TellScales(self));
  PetscCall(PetscMalloc2(self->set.points, &self->t, self->set.points, &self->frequency));
  for (int c = 0; c < CURVES; c++) PetscCall(PetscCalloc1(self->set.points, &self->value[c]));
  for (PetscInt k = 0; k < self->ways; k++)
    PetscCall(PetscCalloc1(self->set.points, &self->modes[k]));
  PetscCall(ChooseCurves(self));
  for (PetscInt k = 0; k < self->ways; k++) PetscCall(CreateSolvers(self, &self->of[k]));
  PetscCall(CreateFew(self));
  PetscCall(StabilityTabulate(self));
  for (int c = 0; c < CURVES; c++)
    if (self->has[c]) PetscCall(StabilityVerdict(self, (Curve)c));
  PetscCall(StabilityPrint(self));
  PetscCall(StabilityWrite(self->file, self));
  if (self->set.transient && !self->twisted && !self->learns)
    PetscCall(StabilityTransient(self, self->file, self->shape_file));
  PetscFunctionReturn(0);
}

static PetscErrorCode Close(Stability *self, const char *output) {
  MPI_Comm comm = self->scene->comm;

  PetscFunctionBegin;
  if (self->file) PetscCall(OutputAttributes(self->file, comm, PETSC_TRUE));
  if (output[0]) PetscCall(OutputEndFile("-output", output, comm, &self->file));
  if (self->shape_file) PetscCall(OutputAttributes(self->shape_file, comm, PETSC_TRUE));
  if (self->set.shape[0])
    PetscCall(OutputEndFile("-stability_optimal_shape", self->set.shape, comm, &self->shape_file));
  PetscFunctionReturn(0);
}

/*
  StabilityRun - -task stability: the curves over a range of t, the verdicts, the transient growth;
  printed and stored.

  output   the result file, "": none
*/
PetscErrorCode StabilityRun(Scene scene, const char *output) {
  Stability self = {.scene = scene};
  PetscErrorCode error;

  PetscFunctionBegin;
  error = Open(&self, output);
  if (!error) error = Compute(&self);
  if (!error) error = Close(&self, output);
  PetscCall(DestroyAll(&self));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/*
  StabilitySlowestMode - the eigenvector of A(0) that decays slowest, as an initial shape.
  Collective.

  n          the number of knots
  s, theta   labels from 0 to 1 and angles against the clamp, theta[0] = 0, scaled so that the
             largest |theta| is the scene's amplitude; allocated here, the caller frees both
*/
PetscErrorCode StabilitySlowestMode(Scene scene, PetscInt *n, PetscReal **s, PetscReal **theta) {
  PetscReal *c, *w, most = 0;
  Spectrum spectrum;
  Eigenvalue value;
  Pencil pencil;
  Mesh mesh;

  PetscFunctionBegin;
  PetscCall(MeshCreate(MODE_CELLS, PETSC_FALSE, scene->growth, scene->end_time, &mesh));
  PetscCall(PencilCreate(PETSC_COMM_SELF, scene, &mesh, map_follows, WAY_X2, &pencil));
  PetscCall(SpectrumCreate(pencil, PETSC_TRUE, &spectrum));
  *n = pencil->n;
  PetscCall(PetscMalloc2(*n, &c, *n, &w));
  PetscCall(PetscMalloc1(*n, s));
  PetscCall(PetscMalloc1(*n, theta));
  PetscCall(SpectrumLargest(&spectrum, RATE_A, 0, &value, c, w));
  PetscCall(PencilShape(pencil, c, w, 0, NULL, *theta));
  PetscCall(PetscArraycpy(*s, pencil->node, *n));
  (*theta)[0] = 0;
  for (PetscInt i = 0; i < *n; i++)
    if (PetscAbsReal((*theta)[i]) > PetscAbsReal(most)) most = (*theta)[i];
  for (PetscInt i = 0; i < *n; i++) (*theta)[i] *= scene->shape.amplitude / most;
  PetscCallMPI(MPI_Bcast(*theta, *n, MPIU_REAL, 0, OptionsComm()));
  PetscCall(SpectrumDestroy(&spectrum));
  PetscCall(PencilDestroy(&pencil));
  PetscCall(MeshDestroy(&mesh));
  PetscCall(PetscFree2(c, w));
  PetscFunctionReturn(0);
}
