/* When the straight rod stops being stable: the first root of a growth factor, looked for in time.
 */
#include "tasks/critical.h"
#include "base/root.h"
#include "straight/senses.h"
#include "straight/spectrum.h"
#include "straight/straight.h"
#include "tasks/peak.h"

enum { SHARED_CELLS = 5000, SCAN_CELLS = 64, SCAN_STEPS = 100 };
/* Where tables bend so often that looks are many, a mesh of so few cells looks first. */
enum { MANY_BENDS = 2000, GLANCE_CELLS = 16 };
/* Of a rod whose material learns all modes are looked at on so many cells, and followed from there.
 */
enum { LEARNED_CELLS = 24 };

/* A root is found to this part of the time. */
static const PetscReal root_found = 2e-13;

/* A growth factor as a function of t, negative while the straight rod is stable. */
typedef struct {
  Mesh mesh;
  Pencil pencil;
  Spectrum spectrum;
  PetscBool dense;  /* all eigenvalues of a small matrix, to be sure of the rightmost */
  PetscBool learns; /* natural curvature: of few cells, and of all */
  Senses few, all;
  PetscReal frequency; /* of the latest evaluation */
  PetscReal *c, *w;    /* its mode, if asked for */
} Factor;

/* What becomes of the straight rod. */
typedef enum {
  CROSSES,  /* it turns unstable, at a time between two that are given */
  UNSTABLE, /* from the start */
  STABLE,   /* as long as was looked */
  PULLED,   /* as long, for it is under tension all along */
  IDLE      /* as long, for nothing presses or pulls it */
} Fate;

/* On a mesh of cells equidistant in arc length. */
static PetscErrorCode FactorCreate(MPI_Comm comm, Scene scene, PetscInt cells, StraightWay way,
                                   PetscBool dense, PetscBool quiet, Factor *self) {
  PetscFunctionBegin;
  self->dense = dense;
  self->learns = TropismLearns(&scene->tropism);
  if (self->learns) {
    PetscCall(SensesCreate(scene, LEARNED_CELLS, way, &self->few));
    PetscCall(SensesCreate(scene, cells, way, &self->all));
    PetscFunctionReturn(0);
  }
  PetscCall(MeshCreate(cells, PETSC_FALSE, scene->growth, scene->end_time, &self->mesh));
  PetscCall(PencilCreate(comm, scene, &self->mesh, map_follows, way, &self->pencil));
  PetscCall(SpectrumCreate(self->pencil, quiet, &self->spectrum));
  PetscFunctionReturn(0);
}

static PetscErrorCode FactorDestroy(Factor *self) {
  PetscFunctionBegin;
  PetscCall(SensesDestroy(&self->few));
  PetscCall(SensesDestroy(&self->all));
  PetscCall(SpectrumDestroy(&self->spectrum));
  PetscCall(PencilDestroy(&self->pencil));
  PetscCall(MeshDestroy(&self->mesh));
  PetscCall(PetscFree2(self->c, self->w));
  PetscFunctionReturn(0);
}

/* Does a ratio of two forms tell when the rod turns unstable? Where K is symmetric and the tip
   free. */
static PetscBool ByRatio(const Factor *self) {
  const Pencil p = self->pencil;
  return (PetscBool)(!self->learns && !p->skew && !p->held && p->ways == 1);
}

/* By ratio, ln(ratio) of SpectrumBuckling(), nearly straight over ln
   L: L^3 times a constant for uniform growth. Else the largest real part of an eigenvalue. A
   RootFunction. */
static PetscErrorCode FactorAt(void *factor, PetscReal t, PetscReal *f) {
  Factor *self = (Factor *)factor;
  Eigenvalue value;

  PetscFunctionBegin;
  if (self->learns) {
    PetscCall(SensesRightmost(&self->few, t, &value));
    if (!self->dense) PetscCall(SensesNear(&self->all, t, &value, self->c, self->w));
    *f = value.value;
  } else if (ByRatio(self)) {
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

/* Is there no axial force anywhere? On one rank; what senses may swing without any. */
static PetscBool Idle(const Factor *self) {
  const Pencil p = self->pencil;

  if (self->learns) return PETSC_FALSE;
  for (PetscInt k = 0; k < p->cells * GAUSS; k++)
    if (p->point[k].P != 0) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* What stands out if it peaks: the ratio less 1, linear in what presses; or the growth factor. */
static PetscReal LevelOf(const Factor *self, PetscReal f) {
  if (!ByRatio(self)) return f;
  return f > PETSC_MIN_REAL ? PetscExpReal(f) - 1 : -1;
}

/* A PeakLevel. */
static PetscErrorCode Level(void *factor, PetscReal t, PetscReal *level) {
  Factor *self = (Factor *)factor;

  PetscFunctionBegin;
  PetscCall(FactorAt(self, t, level));
  *level = LevelOf(self, *level);
  PetscFunctionReturn(0);
}

/* How far from straight lines tables may be between looks, as a part of their size. */
static const PetscReal straight_on = 1e-3;

/* What is seen of the straight rod by looking at it from time to time. */
typedef struct {
  Fate fate;
  PetscReal low, high; /* the first bracket of a crossing */
  Bends bends;         /* of tables, in time, while looking */
  PetscInt bent;       /* so many */
  PetscInt looks;
  PetscReal widest; /* so far are looks apart */
  PeakPlace at[3];  /* the latest, if tables bend */
} Sight;

/* Is there nothing along the rod that a mesh of few cells does not see? */
static PetscBool IsSmooth(Scene scene) {
  const PetscReal longest = 0.25; /* of the rod */
  const Growth growth = scene->growth;
  const Field field = scene->load.field;
  const PetscReal finest = field ? FieldFinest(field, scene->reach) : 0;

  return (PetscBool)(growth->finest == 0 && growth->narrow == 0 && growth->steep > longest &&
                     !scene->stiffness.varies && (finest == 0 || finest > longest * scene->reach));
}

/* The growth factor of the coarse mesh, or of one that is coarser still (glance, NULL: none) if
   that sees the rod far from unstable: the ratio, or the decay against that of a rod on which
   nothing presses. */
static PetscErrorCode Glance(Factor *coarse, Factor *glance, PetscReal t, PetscReal *f) {
  const PetscReal far = 0.1, unloaded = 12.36; /* 1.875^4 */
  PetscReal L;

  PetscFunctionBegin;
  if (glance) {
    PetscCall(FactorAt(glance, t, f));
    PetscCall(GrowthLength(glance->pencil->growth, t, &L, NULL));
    if (LevelOf(glance, *f) <
        -far * (ByRatio(glance) ? 1 : unloaded / (glance->pencil->drag_min * PetscSqr(L * L))))
      PetscFunctionReturn(0);
  }
  PetscCall(FactorAt(coarse, t, f));
  PetscFunctionReturn(0);
}

/* Where tables bend, a look that stands out from both neighbours may be next to what comes and goes
   between them. */
static PetscErrorCode LookForPeak(Factor *coarse, Sight *sight, PetscReal *f) {
  PetscBool above = PETSC_FALSE;
  PeakPlace across[2];

  PetscFunctionBegin;
  sight->at[0] = sight->at[1];
  sight->at[1] = sight->at[2];
  sight->at[2] = (PeakPlace){sight->high, LevelOf(coarse, *f)};
  if (*f < 0 && sight->at[0].t < sight->at[1].t)
    PetscCall(PeakFind(Level, coarse, sight->at, across, &above));
  if (!above) PetscFunctionReturn(0);
  sight->low = across[0].t;
  sight->high = across[1].t;
  *f = across[1].level;
  PetscFunctionReturn(0);
}

/* The time of the next look: in steps of 5 % of the length, a hundredth of the search, and not past
   where tables bend. */
static PetscErrorCode NextLook(Scene scene, Sight *sight) {
  const PetscReal T = scene->end_time, bend = BendsNext(&sight->bends, sight->high);
  PetscReal L, L_t;

  PetscFunctionBegin;
  PetscCall(GrowthLength(scene->growth, sight->high, &L, &L_t));
  sight->low = sight->high;
  sight->high += PetscMin(0.05 * L / PetscMax(PetscAbsReal(L_t), 1e-12), T / SCAN_STEPS);
  sight->high = PetscMin(PetscMin(sight->high, T), bend);
  sight->widest = PetscMax(sight->widest, sight->high - sight->low);
  sight->looks++;
  PetscFunctionReturn(0);
}

/* The first bracket of a crossing. The rod may also be unstable from the start. */
static PetscErrorCode ScanWith(Factor *coarse, Factor *glance, Scene scene, Sight *sight) {
  PetscReal f;
  PetscBool pulled, idle;

  PetscFunctionBegin;
  PetscCall(FactorAt(coarse, 0, &f));
  pulled = (PetscBool)(f == PETSC_MIN_REAL);
  idle = Idle(coarse);
  sight->fate = UNSTABLE;
  if (f >= 0) PetscFunctionReturn(0);
  sight->at[2].level = LevelOf(coarse, f);
  while (f < 0 && sight->high < scene->end_time) {
    PetscCall(NextLook(scene, sight));
    PetscCall(Glance(coarse, glance, sight->high, &f));
    pulled = (PetscBool)(pulled && f == PETSC_MIN_REAL);
    idle = (PetscBool)(idle && Idle(glance ? glance : coarse));
    if (sight->bends.n) PetscCall(LookForPeak(coarse, sight, &f));
  }
  sight->fate = f >= 0 ? CROSSES : !pulled ? STABLE : idle ? IDLE : PULLED;
  PetscFunctionReturn(0);
}

static PetscErrorCode Scan(Scene scene, StraightWay way, Sight *sight) {
  PetscErrorCode error;
  Factor coarse = {0}, glance = {0};
  PetscBool many;

  PetscFunctionBegin;
  error = SceneBends(scene, straight_on, &sight->bends);
  sight->bent = sight->bends.n;
  many =
      (PetscBool)(sight->bent > MANY_BENDS && IsSmooth(scene) && !TropismLearns(&scene->tropism));
  if (!error)
    error = FactorCreate(PETSC_COMM_SELF, scene, SCAN_CELLS, way, PETSC_TRUE, PETSC_TRUE, &coarse);
  if (!error && many)
    error =
        FactorCreate(PETSC_COMM_SELF, scene, GLANCE_CELLS, way, PETSC_TRUE, PETSC_TRUE, &glance);
  if (!error) error = ScanWith(&coarse, many ? &glance : NULL, scene, sight);
  PetscCall(FactorDestroy(&coarse));
  PetscCall(FactorDestroy(&glance));
  PetscCall(BendsDestroy(&sight->bends));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* So far from the critical time of one mesh that of another is looked for first. */
static const PetscReal near = 1e-8;

/* A root near a bracket that belongs to another mesh: widen it till it holds. found: not, if the
   rod of this one is stable for longer than so, which is the root that is reported then: how far it
   is from those of other meshes is their doubt. */
static PetscErrorCode RootNear(Factor *self, PetscReal low, PetscReal high, PetscReal longer,
                               PetscReal *root, PetscBool *found) {
  const PetscReal most = high + longer;
  PetscReal f_low, f_high, d = high - low;

  PetscFunctionBegin;
  PetscCall(FactorAt(self, low, &f_low));
  for (; f_low >= 0 && low > 0; d *= 4) {
    low = PetscMax(0, low - d);
    PetscCall(FactorAt(self, low, &f_low));
  }
  PetscCall(FactorAt(self, high, &f_high));
  for (; f_high < 0 && high < most; d *= 4) {
    high = PetscMin(most, high + d);
    PetscCall(FactorAt(self, high, &f_high));
  }
  *found = (PetscBool)(f_high >= 0);
  *root = high;
  if (*found) PetscCall(RootFind(FactorAt, self, low, f_low, high, f_high, root_found, root));
  PetscFunctionReturn(0);
}

/* Is the critical length the same however long the rod is at the start? */
static PetscBool AtOnce(Scene scene, const Factor *factor) {
  return (PetscBool)(StraightScales(scene) && ByRatio(factor));
}

/* The critical time on one mesh, of a rod that has one. Uniform growth takes one solve: L^3 / ratio
   = L_cr^3; it tells of a rod that is never critical, too. */
static PetscErrorCode OnMesh(Scene scene, Factor *factor, PetscReal low, PetscReal high,
                             PetscReal *t, Fate *fate) {
  Eigenvalue ratio;
  PetscBool found;
  PetscReal L;

  PetscFunctionBegin;
  if (AtOnce(scene, factor)) {
    PetscCall(GrowthLength(scene->growth, 1, &L, NULL));
    PetscCall(SpectrumBuckling(&factor->spectrum, 1, &ratio, factor->c, factor->w));
    *fate = ratio.value > 0 ? CROSSES : PULLED;
    if (*fate == PULLED) PetscFunctionReturn(0);
    *t = L / PetscPowReal(ratio.value, 1. / 3) - scene->growth->initial_length;
  } else {
    PetscCall(RootNear(factor, low, high, scene->end_time, t, &found));
    *fate = found ? CROSSES : STABLE;
  }
  PetscFunctionReturn(0);
}

/* Scales the mode to largest |y| = 1 and to the side of y(1) > 0. */
static void ScaleMode(PetscInt n, PetscReal y[], PetscReal theta[]) {
  PetscReal most = 0;

  for (PetscInt i = 0; i < n; i++) most = PetscMax(most, PetscAbsReal(y[i]));
  if (y[n - 1] < 0) most = -most;
  for (PetscInt i = 0; i < n; i++) {
    y[i] /= most;
    theta[i] /= most;
  }
}

/* The same where it is in both directions: a round rod's is turned so that it is in x2 where it is
   largest; if stiffnesses differ it may only change its side. */
static void TurnMode(const Critical *self, PetscBool round) {
  PetscReal most = 0, c = 1, s = 0;

  for (PetscInt i = 0; i < self->n; i++) {
    PetscReal size = PetscSqrtReal(PetscSqr(self->y[i]) + PetscSqr(self->y3[i]));
    if (size <= most) continue;
    most = size;
    c = round ? self->y[i] : self->y[i] < 0 ? -size : size;
    s = round ? self->y3[i] : 0;
  }
  for (PetscInt i = 0; i < self->n; i++) {
    PetscReal *pair[2][2] = {{&self->y[i], &self->y3[i]}, {&self->theta[i], &self->theta3[i]}};
    for (int k = 0; k < 2; k++) {
      PetscReal a = *pair[k][0], b = *pair[k][1];
      *pair[k][0] = (c * a + s * b) / (most * most);
      *pair[k][1] = (c * b - s * a) / (most * most);
    }
  }
}

/* The mode at the nodes. */
static PetscErrorCode StoreMode(Scene scene, const Factor *factor, Critical *self) {
  const Pencil p = factor->learns ? factor->all.pencil : factor->pencil;

  PetscFunctionBegin;
  self->n = p->mesh->cells + 1;
  PetscCall(PetscMalloc3(self->n, &self->s, self->n, &self->y, self->n, &self->theta));
  PetscCall(PetscArraycpy(self->s, p->node, self->n));
  PetscCall(PencilShape(p, factor->c, factor->w, self->t, self->y, self->theta));
  if (p->ways == 1) ScaleMode(self->n, self->y, self->theta);
  if (!self->space) PetscFunctionReturn(0);
  PetscCall(PetscCalloc2(self->n, &self->y3, self->n, &self->theta3));
  if (p->ways > 1) {
    PetscCall(PencilShape(p, factor->c + p->n, factor->w + p->n, self->t, self->y3, self->theta3));
    TurnMode(self, (PetscBool)(scene->space.ratio == 1));
  } else if (p->way == WAY_X3)
    for (PetscInt i = 0; i < self->n; i++) {
      self->y3[i] = self->y[i];
      self->theta3[i] = self->theta[i];
      self->y[i] = self->theta[i] = 0;
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
  PetscCallMPI(MPI_Bcast(&self->twisting, 1, MPIU_REAL, 0, scene->comm));
  if (!self->space) PetscFunctionReturn(0);
  PetscCallMPI(MPI_Bcast(self->y3, self->n, MPIU_REAL, 0, scene->comm));
  PetscCallMPI(MPI_Bcast(self->theta3, self->n, MPIU_REAL, 0, scene->comm));
  PetscFunctionReturn(0);
}

/* The critical time on a mesh of so many cells, which tells of the error alone. */
static PetscErrorCode OnOther(Scene scene, MPI_Comm comm, PetscInt cells, StraightWay way,
                              PetscBool quiet, PetscReal low, PetscReal high, PetscReal *t,
                              Fate *fate) {
  Factor other = {0};
  PetscErrorCode error;

  PetscFunctionBegin;
  error = FactorCreate(comm, scene, cells, way, PETSC_FALSE, quiet, &other);
  if (!error) error = OnMesh(scene, &other, low, high, t, fate);
  PetscCall(FactorDestroy(&other));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* By how much a third mesh tells another critical time, where something varies along the rod: what
   is thinner than a cell half and whole mesh may miss alike. A zone at the tip that is shorter than
   a cell drives the rod unseen. */
static PetscErrorCode ThirdChange(Scene scene, const Factor *fine, MPI_Comm comm, PetscBool quiet,
                                  const Critical *self, PetscReal *change) {
  const PetscInt cells = scene->mesh.cells;
  Growth growth = scene->growth;
  PetscReal t = self->t, p[2];
  Fate fate = CROSSES;

  PetscFunctionBegin;
  *change = 0;
  if (growth->even && growth->finest == 0 && !scene->load.field && !scene->stiffness.varies)
    PetscFunctionReturn(0);
  *change = self->length;
  if (!fine->learns) PetscCall(GrowthArc(growth, 2, &fine->pencil->node[cells - 1], t, p, NULL));
  if (growth->finest > 0 && p[1] - p[0] > growth->finest) PetscFunctionReturn(0);
  PetscCall(
      OnOther(scene, comm, (3 * cells + 2) / 4, self->way, quiet, t - near, t + near, &t, &fate));
  if (fate == CROSSES) *change = PetscAbsReal(t - self->t);
  PetscFunctionReturn(0);
}

/* The critical time on two meshes, of which the finer is kept; of deflections of one way. */
static PetscErrorCode FindWith(Factor *fine, Scene scene, PetscBool quiet, Critical *self,
                               Fate *fate) {
  PetscReal half_t, change;
  PetscInt cells = scene->mesh.cells, n;
  Sight sight = {.fate = CROSSES};
  MPI_Comm comm = cells < SHARED_CELLS ? PETSC_COMM_SELF : scene->comm;

  PetscFunctionBegin;
  PetscCall(FactorCreate(comm, scene, cells, self->way, PETSC_FALSE, quiet, fine));
  if (!AtOnce(scene, fine)) PetscCall(Scan(scene, self->way, &sight));
  *fate = sight.fate;
  self->looks = sight.looks;
  self->bends = sight.bent;
  self->widest = sight.widest;
  PetscCallMPI(MPI_Bcast(fate, sizeof(*fate), MPI_BYTE, 0, scene->comm));
  if (*fate != CROSSES) PetscFunctionReturn(0);
  PetscCall(OnOther(scene, comm, (cells + 1) / 2, self->way, quiet, sight.low, sight.high, &half_t,
                    fate));
  if (*fate == PULLED) PetscFunctionReturn(0);
  n = fine->learns ? cells + 1 + (scene->clamp == CLAMP_HINGED)
                   : fine->pencil->ways * fine->pencil->n;
  PetscCall(PetscMalloc2(n, &fine->c, n, &fine->w));
  if (sight.bent && (half_t < sight.low || half_t > sight.high)) /* passed over by half a mesh */
    PetscCall(OnMesh(scene, fine, sight.low, sight.high, &self->t, fate));
  else
    PetscCall(OnMesh(scene, fine, half_t - near, half_t + near, &self->t, fate));
  if (*fate != CROSSES) PetscFunctionReturn(0);
  PetscCall(GrowthLength(scene->growth, self->t, &self->length, NULL));
  self->frequency = fine->frequency;
  if (!fine->learns && fine->pencil->ways > 1) self->twisting = fine->pencil->moment;
  PetscCall(ThirdChange(scene, fine, comm, quiet, self, &change));
  self->error = PetscAbsReal(self->t - half_t) + change +
                PetscMax(1, self->length) * (1e-14 + 1e-17 * PetscSqr((PetscReal)n));
  PetscCall(StoreMode(scene, fine, self));
  PetscCall(Agree(scene, self));
  PetscFunctionReturn(0);
}

static PetscErrorCode FindWay(Scene scene, PetscBool quiet, StraightWay way, Critical *self,
                              Fate *fate) {
  Factor fine = {0};
  PetscErrorCode error;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  self->way = way;
  self->space = (PetscBool)(scene->space.why != NULL);
  error = FindWith(&fine, scene, quiet, self, fate);
  PetscCall(FactorDestroy(&fine));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* CriticalLooks - words for how a scene with tables was looked at, in brackets; none where
   nothing could come and go unseen. */
const char *CriticalLooks(const Critical *self, char text[], size_t size) {
  char apart[64];

  text[0] = 0;
  if (self->bends)
    (void)snprintf(text, size, " (looked at %d times, wherever tables bend, at most %s apart)",
                   (int)self->looks, OptionBoth(self->widest, UNIT_TIME, apart));
  return text;
}

/* A rod that has no critical time to report is refused with the reason. */
static PetscErrorCode CheckFate(Scene scene, const Critical *self, Fate fate) {
  char text[64], looks[128], slow[64] = "";
  const Tropism *law = &scene->tropism;
  PetscReal L, L_t;

  PetscFunctionBegin;
  PetscCall(GrowthLength(scene->growth, scene->end_time, &L, &L_t));
  if (scene->growth->yield > 0) /* rather than to buckle it may stall */
    (void)snprintf(slow, sizeof(slow), ", of length %.6g, and grows at %.2g of its speed",
                   (double)L, (double)L_t);
  UserCheck(fate != UNSTABLE || law->senses || law->ironing == 0 || law->proprioception > 0,
            scene->comm,
            "-growth_ironing: without -tropism_proprioception any thrust makes the straight rod "
            "creep out of line, so it has no critical length; -task stability tells how fast");
  UserCheck(fate != UNSTABLE || !TropismLearns(law), scene->comm,
            "-growth_initial_length: the straight rod is unstable already at t = 0: take it "
            "shorter, or more -tropism_proprioception, less -tropism_memory or -growth_ironing, "
            "and -tropism_direction where it grows");
  UserCheck(
      fate != UNSTABLE, scene->comm,
      "-growth_initial_length: the straight rod is unstable already at t = 0, take it shorter");
  UserCheck(fate != PULLED || !StraightScales(scene), scene->comm,
            "-rod_weight: takes all thrust off the rod, however long it is: it never turns "
            "unstable");
  UserCheck(fate != IDLE, scene->comm,
            "-tip_force: nothing presses the straight rod, so it is stable, however long it is: "
            "load it, or let it grow (-growth_type)");
  UserCheck(fate == CROSSES, scene->comm,
            "-ts_max_time %s: the straight rod is stable up to there%s%s%s, %s",
            OptionBoth(scene->end_time, UNIT_TIME, text), slow,
            fate == PULLED ? ", pulled all along" : "", CriticalLooks(self, looks, sizeof(looks)),
            GrowthOutlook(scene->growth));
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
  second-order matrix of this size. Where something varies along the rod it is what three quarters
  of the cells change, too: what is thinner than a cell the others may miss alike.
*/
PetscErrorCode CriticalFind(Scene scene, PetscBool quiet, Critical *self) {
  Fate fate[MOST_WAYS] = {STABLE, STABLE};
  StraightWay way[MOST_WAYS];
  PetscInt ways = StraightWays(scene, way), first = 0;
  Critical found[MOST_WAYS];

  PetscFunctionBegin;
  PetscCall(PetscMemzero(self, sizeof(*self)));
  PetscCall(PetscMemzero(found, sizeof(found)));
  for (PetscInt k = 0; k < ways; k++) {
    PetscErrorCode error = FindWay(scene, quiet, way[k], &found[k], &fate[k]);
    if (error) PetscCall(CriticalDestroy(&found[0]));
    if (error && k) PetscCall(CriticalDestroy(&found[1]));
    PetscCall(error);
  }
  if (ways > 1 && fate[0] == CROSSES && fate[1] == CROSSES)
    first = found[1].t < found[0].t;
  else if (ways > 1)
    first = fate[1] == UNSTABLE || (fate[0] != UNSTABLE && fate[1] == CROSSES);
  *self = found[first];
  self->ways = ways;
  self->follows = (PetscBool)(ways > 1 && fate[!first] == CROSSES);
  self->other[0] = found[!first].t;
  self->other[1] = found[!first].length;
  if (ways > 1) PetscCall(CriticalDestroy(&found[!first]));
  PetscCall(CheckFate(scene, self, fate[first]));
  PetscFunctionReturn(0);
}

PetscErrorCode CriticalDestroy(Critical *self) {
  PetscFunctionBegin;
  PetscCall(PetscFree3(self->s, self->y, self->theta));
  PetscCall(PetscFree2(self->y3, self->theta3));
  PetscFunctionReturn(0);
}
