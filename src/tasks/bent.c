/* -task critical of a rod that is bent, or bears moments across: it is followed in the model of
   space, and at each step small changes u of its state U(t) are looked at, frozen,
     dF/dU u + sigma dF/dU_t u = 0
   for F the equations of the model. It stops being stable where the first sigma comes to have a
   real part of 0 (docs/theory/straight.md). */
#include "tasks/bent.h"
#include "base/chain.h"
#include "base/extremes.h"
#include "base/root.h"
#include "rod/directors.h"
#include "stepping/leg.h"
#include "tasks/growing.h"
#include "tasks/modes.h"

enum { CORRECTIONS = 2 };
/* Steps that tables end, unless they bend farther than by their noise so often. */
enum { MOST_BENDS = 2000 };

/* A root is found to this part of the time. */
static const PetscReal root_found = 2e-13;
/* How far from straight lines tables may be between steps, as a part of their size. */
static const PetscReal straight_on = 0.02;
/* Friction closer to exact than this is 1/sqrt(beta) where the rod rests, and modes are lost in it.
 */
static const PetscReal least_beta = 1e-16;

typedef struct {
  Leg leg;
  Modes modes;
  Mat A, B;          /* dF/dU, -dF/dU_t */
  KSP ksp;           /* A^-1 */
  Vec U, U_t, work;  /* within a step */
  Vec moves;         /* see SetMoves() */
  PetscReal before;  /* the rate at the latest step; 0: none was taken */
  PetscBool settled; /* what the start brought is over */
  Bends bends;       /* of the scene's tables, in time: steps end there */
  PetscInt looks;
  PetscReal widest; /* so far are looks apart */
  Crawl crawl;
  PetscBool crawls;
  PetscBool crosses;
  PetscReal t; /* where it does; 0: a mode grew from the first step on */
  Growing growing;
  Critical *critical; /* where the mode is stored then; NULL: nowhere */
} Bent;

/*
  BentAsked - is the rod of a scene, of which -task critical is asked, one to be followed? If it is
  in space, by itself or as -rod_model says, and something bends it or leads its tip. Collective.
*/
PetscErrorCode BentAsked(Scene scene, PetscBool *bent) {
  const PetscBool across =
      (PetscBool)(CurvatureBends(&scene->curvature) || scene->tip.path ||
                  !SpaceIsAlong(scene->load.weight) || !SpaceIsAlong(scene->tip.push));
  PetscInt model = SPACE;

  PetscFunctionBegin;
  if (across && scene->space.why) PetscCall(OptionDefault("-rod_model", "space"));
  if (across) PetscCall(OptionWord("-rod_model", &model, NULL));
  *bent = (PetscBool)(across && model == SPACE);
  PetscFunctionReturn(0);
}

/* What has no modes that could be taken for those of the moment. */
static PetscErrorCode Check(Scene scene) {
  const char *const about = "-task critical looks at the modes of a bent rod at an instant";

  PetscFunctionBegin;
  UserCheck(scene->clamp == CLAMP_HELD, scene->comm,
            "-clamp_type: %s, of one that a clamp holds; take it out", about);
  UserCheck(!scene->contact.any, scene->comm,
            "-%s: %s, and of one that touches nothing; take it out",
            scene->contact.self ? "contact_self" : "wall_file", about);
  UserCheck(scene->load.friction.mu == 0 || (!LoadSticks(&scene->load) && !scene->load.limit),
            scene->comm,
            "-friction_beta: %s, and what sticks has none; give a value above 0, or -friction_mu 0",
            about);
  UserCheck(scene->load.friction.mu == 0 || scene->load.friction.beta >= least_beta, scene->comm,
            "-friction_beta %g: %s, and next to exact friction those of what rests are round-off; "
            "give %g or more",
            (double)scene->load.friction.beta, about, (double)least_beta);
  PetscFunctionReturn(0);
}

/* 1 for each place and director that can move, 0 for what is held, and for forces and moments. The
   rod is on this rank alone. (A tip that slides is held across the clamp's axes, which need not be
   those of places: there T is 0 by itself.) */
static PetscErrorCode SetMoves(Bent *self) {
  const PetscInt fields = rod_space.fields;
  const Tip *tip = &self->leg.rod->scene->tip;
  PetscScalar *moves;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(self->leg.U, &self->moves));
  PetscCall(VecGetLocalSize(self->moves, &n));
  PetscCall(VecGetArray(self->moves, &moves));
  for (PetscInt i = 0; i < n; i++) moves[i] = i >= fields && rod_space.followed[i % fields];
  for (PetscInt k = 0; k < fields; k++)
    if (k < 3 ? TipHolds(tip, 0) : TipPoints(tip)) moves[n - fields + k] = 0;
  PetscCall(VecRestoreArray(self->moves, &moves));
  PetscFunctionReturn(0);
}

/* A and B of a state. Friction is linearised as what it is, not as Newton's method takes it. */
static PetscErrorCode Assemble(Bent *self, PetscReal t, Vec U, Vec U_t) {
  Rod rod = self->leg.rod;
  Friction *friction = &rod->scene->load.friction;
  const FrictionNewton newton = friction->newton;
  RodState at = {.t = t, .U = U, .U_t = U_t, .fresh = PETSC_TRUE};

  PetscFunctionBegin;
  friction->newton = NEWTON_PRIMAL;
  PetscCall(rod->model->jacobian(rod, &at, self->A));
  for (int f = 0; f < MAX_FIELDS; f++) at.shift[f] = 1;
  PetscCall(rod->model->jacobian(rod, &at, self->B));
  friction->newton = newton;
  PetscCall(MatAYPX(self->B, -1, self->A, SAME_NONZERO_PATTERN));
  PetscFunctionReturn(0);
}

/* The mode of a state that grows fastest, or decays slowest. */
static PetscErrorCode Look(Bent *self, PetscReal t, Vec U, Vec U_t, Growing *growing) {
  PetscFunctionBegin;
  PetscCall(Assemble(self, t, U, U_t));
  PetscCall(ModesLook(&self->modes, t, growing));
  PetscFunctionReturn(0);
}

/* The state between two steps is their polynomial's, which meets the equations to the tolerance of
   steps, moments and forces not even so. So it is brought to them, as a step as long as the latest
   one would. */
static PetscErrorCode Correct(Bent *self, PetscReal t, PetscReal step) {
  Rod rod = self->leg.rod;
  RodState at = {.t = t, .U = self->U, .U_t = self->U_t, .fresh = PETSC_TRUE};
  Vec F;

  PetscFunctionBegin;
  for (int f = 0; f < MAX_FIELDS; f++) at.shift[f] = 1 / step;
  PetscCall(VecDuplicate(self->U, &F));
  for (int k = 0; k < CORRECTIONS; k++) {
    PetscCall(rod->model->residual(rod, &at, F));
    PetscCall(rod->model->jacobian(rod, &at, self->A));
    PetscCall(KSPSetOperators(self->ksp, self->A, self->A));
    PetscCall(KSPSolve(self->ksp, F, self->work));
    PetscCall(VecAXPY(self->U, -1, self->work));
    PetscCall(VecAXPY(self->U_t, -1 / step, self->work));
  }
  PetscCall(VecDestroy(&F));
  PetscFunctionReturn(0);
}

/* The same within the latest step, from t0 to t1. */
static PetscErrorCode LookAt(Bent *self, PetscReal t, PetscReal t0, PetscReal t1,
                             Growing *growing) {
  PetscFunctionBegin;
  PetscCall(LegInterpolate(&self->leg, t, t1, t1 - t0, self->U, self->U_t));
  PetscCall(Correct(self, t, t1 - t0));
  PetscCall(Look(self, t, self->U, self->U_t, growing));
  PetscFunctionReturn(0);
}

/* The shape of the mode, if it is asked for: how the places go across, and the tangents. */
static PetscErrorCode StoreMode(const Bent *self) {
  Critical *critical = self->critical;
  const Scene scene = self->leg.rod->scene;
  const PetscInt fields = rod_space.fields, n = scene->mesh.cells + 1;
  const PetscScalar *u, *state;
  PetscReal most = 0, size[2] = {0, 0};
  Vec mode;

  PetscFunctionBegin;
  if (!critical) PetscFunctionReturn(0);
  critical->n = n;
  critical->frequency = self->growing.frequency;
  PetscCall(PetscFree3(critical->s, critical->y, critical->theta));
  PetscCall(PetscFree2(critical->y3, critical->theta3));
  PetscCall(PetscMalloc3(n, &critical->s, n, &critical->y, n, &critical->theta));
  PetscCall(PetscMalloc2(n, &critical->y3, n, &critical->theta3));
  PetscCall(VecDuplicate(self->U, &mode));
  PetscCall(EPSGetEigenvector(self->modes.eps, self->growing.which, mode, NULL));
  PetscCall(VecGetArrayRead(mode, &u));
  PetscCall(VecGetArrayRead(self->U, &state));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *p = state + i * fields + 3, *dp = u + i * fields + 3;
    PetscReal d[3][3], D[3][4], turn[3];
    Directors(p, QuaternionSize(p), d);
    DirectorSlope(p, QuaternionSize(p), d[0], 0, D);
    for (int k = 0; k < 3; k++)
      turn[k] = D[k][0] * dp[0] + D[k][1] * dp[1] + D[k][2] * dp[2] + D[k][3] * dp[3];
    critical->s[i] = scene->mesh.s[i];
    critical->y[i] = u[i * fields + 1];
    critical->y3[i] = u[i * fields + 2];
    critical->theta[i] = turn[1];
    critical->theta3[i] = turn[2];
    size[0] = PetscMax(size[0], PetscAbsReal(critical->y[i]));
    size[1] = PetscMax(size[1], PetscAbsReal(critical->y3[i]));
  }
  PetscCall(VecRestoreArrayRead(mode, &u));
  PetscCall(VecRestoreArrayRead(self->U, &state));
  PetscCall(VecDestroy(&mode));
  most = PetscMax(size[0], size[1]);
  for (PetscInt i = 0; i < n && most > 0; i++) {
    critical->y[i] /= most;
    critical->y3[i] /= most;
    critical->theta[i] /= most;
    critical->theta3[i] /= most;
  }
  critical->sideways = size[1] / (size[0] + size[1]);
  PetscFunctionReturn(0);
}

/* A place within the latest step. */
typedef struct {
  Bent *self;
  PetscReal t0, t1; /* its ends */
} Within;

/* A RootFunction: the rate. */
static PetscErrorCode RateAt(void *within, PetscReal t, PetscReal *rate) {
  const Within *in = (const Within *)within;
  Bent *self = in->self;

  PetscFunctionBegin;
  self->t = t;
  PetscCall(LookAt(self, t, in->t0, in->t1, &self->growing));
  *rate = self->growing.rate;
  PetscFunctionReturn(0);
}

/* Where the rate, fa < 0 at a, fb >= 0 at b, is 0 within the latest step, which ends at b. */
static PetscErrorCode Cross(Bent *self, PetscReal a, PetscReal fa, PetscReal b, PetscReal fb) {
  Within in = {self, a, b};

  PetscFunctionBegin;
  PetscCall(RootFind(RateAt, &in, a, fa, b, fb, root_found, &self->t));
  PetscCall(StoreMode(self));
  PetscFunctionReturn(0);
}

/* In so many steps as that takes in -task grow the modes of as many states are looked for, and what
   chatters gets on by a hundredth of the run; a run that comes through takes some hundred. */
static const PetscReal crawls_by = 0.05;

/* Do steps get the rod anywhere? If not, it ends. Steps that tables end say nothing of that. */
static PetscErrorCode LookForCrawl(Bent *self, TS ts, PetscReal t0, PetscReal t) {
  const Scene scene = self->leg.rod->scene;
  PetscReal length;

  PetscFunctionBegin;
  if (BendsNext(&self->bends, t0) <= t) PetscFunctionReturn(0);
  PetscCall(GrowthLength(scene->growth, t, &length, NULL));
  self->crawls =
      (PetscBool)(!self->crawl.allowed &&
                  CrawlStep(&self->crawl, t, t, crawls_by * PetscMin(length, scene->end_time), 0));
  if (self->crawls) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  PetscFunctionReturn(0);
}

/* A step was taken: are there modes that grow?

   At the start forces have not settled, and modes of a moment may grow that are gone the next.
   Until the slowest mode had time to decay, of one over its rate, one that grows counts if it stays
   till it had time to grow, or to the end of the run. */
static PetscErrorCode AfterStep(TS ts) {
  PetscReal t0, t1;
  Growing growing;
  Leg *leg;
  Bent *self;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  self = (Bent *)leg->owner;
  PetscCall(TSGetTime(ts, &t1));
  PetscCall(TSGetPrevTime(ts, &t0));
  if (t1 == t0) { /* no step is taken: it gives way at once */
    PetscCall(TSSetConvergedReason(ts, TS_DIVERGED_STEP_REJECTED));
    PetscFunctionReturn(0);
  }
  PetscCall(LookAt(self, t1, t0, t1, &growing));
  self->looks++;
  self->widest = PetscMax(self->widest, t1 - t0);
  if (growing.rate < 0) {
    self->crosses = PETSC_FALSE;
    if (-growing.rate * t1 >= 1) self->settled = PETSC_TRUE;
  } else if (!self->crosses) {
    self->crosses = PETSC_TRUE;
    self->t = 0;
    if (self->before < 0) PetscCall(Cross(self, t0, self->before, t1, growing.rate));
  }
  if (self->crosses && (self->settled || growing.rate * t1 >= 1))
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  else if (t1 < self->leg.rod->scene->end_time)
    PetscCall(LookForCrawl(self, ts, t0, t1));
  self->before = growing.rate;
  PetscFunctionReturn(0);
}

/* A VBDFNextEnd. */
static PetscReal NextEnd(TS ts, PetscReal t) {
  Leg *leg = NULL;

  if (TSGetApplicationContext(ts, &leg)) return PETSC_MAX_REAL;
  return SmallerOf(SceneNextTurn(leg->rod->scene, t), BendsNext(&((Bent *)leg->owner)->bends, t));
}

/* A rod that rests, or does not feel it yet, lets steps be long: they end where tables turn, and
   where they bend. */
static PetscErrorCode EndAtBends(Scene scene, Bent *self) {
  PetscReal tolerance = straight_on;

  PetscFunctionBegin;
  PetscCall(LegEndAtTurns(&self->leg));
  PetscCall(SceneFewBends(scene, MOST_BENDS, &tolerance, &self->bends));
  if (self->bends.n) PetscCall(VBDFSetNextEnd(self->leg.ts, NextEnd));
  PetscFunctionReturn(0);
}

/* A scene at its start, on the mesh that it has. */
static PetscErrorCode Create(Scene scene, PetscReal rtol, PetscBool quiet, Bent *self) {
  Rod rod;

  PetscFunctionBegin;
  PetscCall(LegCreate(scene, &rod_space, rtol, &self->leg));
  rod = self->leg.rod;
  self->leg.owner = self;
  PetscCall(TSSetPostStep(self->leg.ts, AfterStep));
  PetscCall(EndAtBends(scene, self));
  PetscCall(RodHoldTip(rod));
  PetscCall(RodCreateMatrix(rod, &self->A));
  PetscCall(RodCreateMatrix(rod, &self->B));
  PetscCall(VecDuplicate(self->leg.U, &self->U));
  PetscCall(VecDuplicate(self->leg.U, &self->U_t));
  PetscCall(VecDuplicate(self->leg.U, &self->work));
  PetscCall(SetMoves(self));
  PetscCall(ChainCreateSolver(scene->comm, MATORDERINGNATURAL, &self->ksp)); /* as in every step */
  PetscCall(ModesCreate(self->A, self->B, self->ksp, self->moves, &self->modes));
  if (!quiet) PetscCall(EPSSetFromOptions(self->modes.eps));
  PetscCall(CrawlAllowed(self->leg.ts, &self->crawl));
  PetscCall(RodBegin(rod, self->leg.U));
  PetscFunctionReturn(0);
}

static PetscErrorCode Destroy(Bent *self) {
  PetscFunctionBegin;
  PetscCall(ModesDestroy(&self->modes));
  PetscCall(MatDestroy(&self->A));
  PetscCall(MatDestroy(&self->B));
  PetscCall(KSPDestroy(&self->ksp));
  PetscCall(VecDestroy(&self->U));
  PetscCall(VecDestroy(&self->U_t));
  PetscCall(VecDestroy(&self->work));
  PetscCall(VecDestroy(&self->moves));
  PetscCall(BendsDestroy(&self->bends));
  PetscCall(LegDestroy(&self->leg));
  PetscFunctionReturn(0);
}

/* Follows the rod on the mesh that it has; critical NULL: its mode is not asked for. */
static PetscErrorCode Follow(Scene scene, PetscReal rtol, PetscBool quiet, PetscReal *t,
                             Critical *critical) {
  TSConvergedReason reason;
  Bent self = {.critical = critical};
  PetscErrorCode error;
  Critical seen = {0};
  char text[64], crawl[512], looks[128];

  PetscFunctionBegin;
  error = Create(scene, rtol, quiet, &self);
  if (!error) error = TSSolve(self.leg.ts, self.leg.U);
  if (!error) error = TSGetConvergedReason(self.leg.ts, &reason);
  if (!error) error = TSGetTime(self.leg.ts, t);
  seen.bends = self.bends.n;
  seen.looks = self.looks;
  seen.widest = self.widest;
  PetscCall(Destroy(&self));
  PetscCall(error);
  CrawlTell(&self.crawl, scene->load.friction.beta, PETSC_FALSE, crawl, sizeof(crawl));
  UserCheck(!self.crawls, OptionsComm(), "%s", crawl);
  UserCheck(reason > 0 || (self.crosses && self.t > 0), OptionsComm(),
            "the bent rod could not be followed beyond t = %s (%s): try another -ts_rtol or more "
            "-rod_cells",
            OptionBoth(*t, UNIT_TIME, text), TSConvergedReasons[reason]);
  UserCheck(self.crosses || reason != TS_CONVERGED_ITS, OptionsComm(),
            "-ts_max_steps: reached at t = %s, and the bent rod is stable up to there; allow more",
            OptionBoth(*t, UNIT_TIME, text));
  UserCheck(!self.crosses || self.t > 0, OptionsComm(),
            "-growth_initial_length: the bent rod is unstable already at t = 0, take it shorter or "
            "load it less");
  UserCheck(self.crosses, OptionsComm(),
            "-ts_max_time %s: the bent rod is stable up to there%s, %s",
            OptionBoth(scene->end_time, UNIT_TIME, text),
            CriticalLooks(&seen, looks, sizeof(looks)), GrowthOutlook(scene->growth));
  *t = self.t;
  if (!critical) PetscFunctionReturn(0);
  critical->bends = seen.bends;
  critical->looks = seen.looks;
  critical->widest = seen.widest;
  PetscFunctionReturn(0);
}

/* The same with half the cells. */
static PetscErrorCode FollowHalf(Scene scene, PetscReal rtol, PetscBool quiet, PetscReal *t) {
  const Mesh mesh = scene->mesh;
  PetscErrorCode error;

  PetscFunctionBegin;
  PetscCall(
      MeshCreate((mesh.cells + 1) / 2, PETSC_FALSE, scene->growth, scene->end_time, &scene->mesh));
  error = Follow(scene, rtol, quiet, t, NULL);
  PetscCall(MeshDestroy(&scene->mesh));
  scene->mesh = mesh;
  PetscCall(error);
  PetscFunctionReturn(0);
}

/* On this rank alone. */
static PetscErrorCode Find(Scene scene, PetscReal rtol, PetscBool quiet, Critical *critical) {
  PetscReal half;

  PetscFunctionBegin;
  PetscCall(Follow(scene, rtol, quiet, &critical->t, critical));
  PetscCall(FollowHalf(scene, rtol, quiet, &half));
  PetscCall(GrowthLength(scene->growth, critical->t, &critical->length, NULL));
  critical->error = PetscAbsReal(critical->t - half) +
                    PetscMax(critical->t, critical->length) * PetscMax(1e-14, rtol);
  PetscFunctionReturn(0);
}

/*
  BentReadOptions - reads the options of a rod that is followed, and forgets those of its solvers,
  so that a mistyped one can be refused before any work. Collective.
*/
PetscErrorCode BentReadOptions(Scene scene) {
  PetscErrorCode error;
  PetscReal rtol;
  Bent self = {0};

  PetscFunctionBegin;
  PetscCall(Check(scene));
  PetscCall(OptionReal("-ts_rtol", &rtol, NULL));
  scene->space.rod = PETSC_TRUE;
  error = Create(scene, rtol, PETSC_FALSE, &self);
  PetscCall(Destroy(&self));
  PetscCall(error);
  PetscFunctionReturn(0);
}

/*
  BentFind - as CriticalFind(), of a rod that BentAsked() says is followed, after BentReadOptions().
  Every rank does so by itself. Collective on the scene's ranks.

  The error bound is the change from half the cells, and the tolerance of the steps.
*/
PetscErrorCode BentFind(Scene scene, PetscBool quiet, Critical *critical) {
  const MPI_Comm comm = scene->comm;
  PetscErrorCode error;
  PetscReal rtol;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(critical, sizeof(*critical)));
  PetscCall(OptionReal("-ts_rtol", &rtol, NULL));
  critical->space = critical->bent = PETSC_TRUE;
  critical->ways = 1;
  scene->comm = PETSC_COMM_SELF;
  error = Find(scene, rtol, quiet, critical);
  scene->comm = comm;
  if (error) PetscCall(CriticalDestroy(critical));
  PetscCall(error);
  PetscFunctionReturn(0);
}
