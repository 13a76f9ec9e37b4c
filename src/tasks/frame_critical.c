/* The rods do not grow and are at rest, U_t = 0: states U(p) in which their equations hold under p
   times all loads, F(U; p) = 0, are followed from p = 0 on, and at each is asked how its modes
   (modes.h) grow or decay. They stop being stable at the first p at which one does neither. */
#include "tasks/frame_critical.h"
#include "base/blocklu.h"
#include "base/root.h"
#include "record/output.h"
#include "rod/ask.h"
#include "tasks/modes.h"
#include "tasks/several_run.h"

/* Looks along p, Newton's iterations for a state, and halvings of a step that finds none. */
enum { LOOKS = 200, ITERATIONS = 20, HALVINGS = 12 };

/* First step in p, part of that under which the weakest rod alone might give way; the next are at
   most so many times as long, and go so much beyond where the mode, going on as it went, would be.
 */
static const PetscReal first_step = 0.1, grow_most = 1.6, beyond = 1.02;
/* p is looked for up to so many times that. */
static const PetscReal farthest = 1e4;
/* A mode that decays by less than this part of the rate from which it is looked at does not. */
static const PetscReal moves = 1e-6;
/* The equations hold to this part of the loads, or so many times that if they come no nearer; a
   root is found to this part of p. */
static const PetscReal held_to = 1e-11, rounding = 1e3, root_found = 1e-13;

/* What loads a rod, as given. */
typedef struct {
  PetscReal push[3], weight[3], force, torque;
} Given;

typedef struct {
  Run *run;
  Rod rod;
  Given *given;
  PetscReal strength; /* of all loads: forces */
  PetscReal scale;    /* p under which the weakest rod alone might give way */
  /* Next to where the rods give way dF/dU is next to singular. So modes are looked at from a rate
     on, of the size of the slowest: A = dF/dU + rate dF/dU_t, of which they are sigma - rate. */
  PetscReal rate;
  Mat A, twice, B;      /* A, the same with twice the rate, and -dF/dU_t as the difference */
  KSP ksp;              /* A^-1 */
  Vec U, rest, F, work; /* the state, U_t = 0 */
  Vec from[2];          /* states at both ends of the latest step */
  PetscReal p, at[2];   /* of the state, and of those */
  Vec moves;
  Modes modes;
  Growing growing;
  Vec mode; /* of which that is, once it is found */
} Frame;

/* ---- loads ---- */

static PetscErrorCode TakeLoads(Frame *self) {
  PetscReal weakest = PETSC_MAX_REAL, length, g, S[3];

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(self->rod->rods, &self->given));
  for (PetscInt k = 0; k < self->rod->rods; k++) {
    const Rod rod = self->rod->each[k];
    const Scene scene = rod->scene;
    Given *given = &self->given[k];
    PetscReal weight = 0, push = 0;
    PetscCall(RodLength(rod, 0, &length));
    PetscCall(RodStiffnessAt(rod, 0, 0, &g, S));
    for (int d = 0; d < 3; d++) {
      given->push[d] = scene->tip.push[d];
      given->weight[d] = scene->load.weight[d];
      push += PetscSqr(given->push[d]);
      weight += PetscSqr(given->weight[d]);
    }
    given->force = scene->tip.force;
    given->torque = scene->tip.torque;
    self->strength += PetscSqrtReal(push) + length * PetscSqrtReal(weight) +
                      PetscAbsReal(given->force) + PetscAbsReal(given->torque) / length;
    weakest = PetscMin(weakest, PetscMin(S[1], S[2]) / PetscSqr(length));
  }
  UserCheck(self->strength > 0, OptionsComm(),
            "-task critical: nothing loads the rods; give one a -tip_force, a -tip_force_vector, a "
            "-tip_torque or a -rod_weight");
  self->scale = weakest / self->strength;
  PetscFunctionReturn(0);
}

/* Loads the rods by p times what is given. */
static void SetLoads(Frame *self, PetscReal p) {
  self->p = p;
  for (PetscInt k = 0; k < self->rod->rods; k++) {
    const Scene scene = self->rod->each[k]->scene;
    const Given *given = &self->given[k];
    PetscReal weight[3];
    for (int d = 0; d < 3; d++) {
      scene->tip.push[d] = p * given->push[d];
      weight[d] = p * given->weight[d];
    }
    scene->tip.force = p * given->force;
    scene->tip.torque = p * given->torque;
    LoadSetWeight(&scene->load, weight);
  }
}

/* ---- states ---- */

static RodState StateOf(const Frame *self, PetscReal rate) {
  RodState at = {.U = self->U, .U_t = self->rest, .fresh = PETSC_TRUE};

  for (int f = 0; f < MAX_FIELDS; f++) at.shift[f] = rate;
  return at;
}

/* Newton's method for the state under the loads; found: it has come there. A state that meets the
   equations already stays as it is: next to where the rods give way its A is next to singular. */
static PetscErrorCode Settle(Frame *self, PetscBool *found) {
  const PetscReal enough = held_to * PetscMax(self->p, self->scale) * self->strength;
  const RodState at = StateOf(self, 0);
  PetscReal off = 0, before;

  PetscFunctionBegin;
  *found = PETSC_FALSE;
  for (int k = 0; k <= ITERATIONS; k++) {
    before = off;
    PetscCall(self->rod->model->residual(self->rod, &at, self->F));
    PetscCall(VecNorm(self->F, NORM_INFINITY, &off));
    *found = (PetscBool)(off <= enough || (k > 1 && off <= rounding * enough && off > before / 2));
    if (*found || !(off < PETSC_MAX_REAL)) break;
    PetscCall(self->rod->model->jacobian(self->rod, &at, self->A));
    PetscCall(KSPSetOperators(self->ksp, self->A, self->A));
    PetscCall(KSPSolve(self->ksp, self->F, self->work));
    PetscCall(VecAXPY(self->U, -1, self->work));
  }
  PetscFunctionReturn(0);
}

/* y = B x */
static PetscErrorCode ApplyRates(Mat B, Vec x, Vec y) {
  Frame *self;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &self));
  PetscCall(MatMult(self->twice, x, self->F));
  PetscCall(MatMult(self->A, x, y));
  PetscCall(VecAXPY(y, -1, self->F));
  PetscCall(VecScale(y, 1 / self->rate));
  PetscFunctionReturn(0);
}

/* How the modes of the state grow. */
static PetscErrorCode Look(Frame *self) {
  const RodState once = StateOf(self, self->rate), twice = StateOf(self, 2 * self->rate);

  PetscFunctionBegin;
  PetscCall(self->rod->model->jacobian(self->rod, &once, self->A));
  PetscCall(self->rod->model->jacobian(self->rod, &twice, self->twice));
  PetscCall(ModesLook(&self->modes, self->p, &self->growing));
  self->growing.rate += self->rate;
  PetscFunctionReturn(0);
}

/* ---- the way along p ---- */

/* The state under p, as one on the line through the two of the latest step first. */
static PetscErrorCode GoTo(Frame *self, PetscReal p, PetscBool *found) {
  const PetscReal part = (p - self->at[0]) / (self->at[1] - self->at[0]);

  PetscFunctionBegin;
  SetLoads(self, p);
  PetscCall(VecCopy(self->from[0], self->U));
  PetscCall(VecScale(self->U, 1 - part));
  PetscCall(VecAXPY(self->U, part, self->from[1]));
  PetscCall(Settle(self, found));
  PetscFunctionReturn(0);
}

/* A RootFunction. */
static PetscErrorCode RateAt(void *ctx, PetscReal p, PetscReal *rate) {
  Frame *self = (Frame *)ctx;
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(GoTo(self, p, &found));
  PetscCheck(found, PETSC_COMM_SELF, PETSC_ERR_CONV_FAILED, "no state at %g times the loads",
             (double)p);
  PetscCall(Look(self));
  *rate = self->growing.rate;
  PetscFunctionReturn(0);
}

/* The next end of a step, from a, where the rate is fa, on; b, fb: before that. */
static PetscReal NextStep(const Frame *self, PetscReal b, PetscReal fb, PetscReal a, PetscReal fa) {
  const PetscReal longest = grow_most * PetscMax(a - b, first_step * self->scale);
  const PetscReal met = fa > fb ? a + beyond * fa * (a - b) / (fb - fa) : PETSC_MAX_REAL;

  return PetscMin(a + longest, PetscMax(met, a + first_step * (a - b)));
}

/* A state with longer loads: steps become shorter until there is one. */
static PetscErrorCode Step(Frame *self, PetscReal *next) {
  PetscBool found = PETSC_FALSE;
  PetscReal p = *next;

  PetscFunctionBegin;
  for (int k = 0; k < HALVINGS && !found; k++) {
    if (k) p = (self->at[1] + p) / 2;
    PetscCall(GoTo(self, p, &found));
  }
  UserCheck(found, OptionsComm(),
            "-task critical: under more than %.8g times the loads no state at rest was found; give "
            "smaller loads, or more -rod_cells",
            (double)self->at[1]);
  *next = p;
  PetscCall(VecCopy(self->from[1], self->from[0]));
  PetscCall(VecCopy(self->U, self->from[1]));
  self->at[0] = self->at[1];
  self->at[1] = p;
  PetscFunctionReturn(0);
}

/* The rods as they begin, without loads, and under a little of them. */
static PetscErrorCode Begin(Frame *self, PetscReal *rate) {
  PetscBool found;

  PetscFunctionBegin;
  PetscCall(VecCopy(self->run->leg.U, self->U));
  SetLoads(self, 0);
  self->rate = 1 / RodUnits(self->rod)->own;
  PetscCall(Settle(self, &found));
  if (found) PetscCall(Look(self));
  if (found && self->growing.rate < 0) self->rate = -self->growing.rate;
  if (found) PetscCall(Look(self));
  UserCheck(found && self->growing.rate < -moves * self->rate, OptionsComm(),
            "-task critical: the rods move without a load, or give way to none; give them another "
            "joint, or a clamp");
  *rate = self->growing.rate;
  for (int k = 0; k < 2; k++) PetscCall(VecCopy(self->U, self->from[k]));
  self->at[0] = -1; /* there is none before */
  self->at[1] = 0;
  PetscFunctionReturn(0);
}

static PetscErrorCode Find(Frame *self, PetscReal *factor) {
  PetscReal b = 0, fb = 0, a = 0, fa = 0, next;

  PetscFunctionBegin;
  PetscCall(Begin(self, &fa));
  fb = fa;
  for (int k = 0; k < LOOKS && a < farthest * self->scale; k++) {
    next = k ? NextStep(self, b, fb, a, fa) : first_step * self->scale;
    PetscCall(Step(self, &next));
    PetscCall(Look(self));
    b = a;
    fb = fa;
    a = next;
    fa = self->growing.rate;
    if (fa >= 0) {
      PetscCall(RootFind(RateAt, self, b, fb, a, fa, root_found, factor));
      PetscFunctionReturn(0);
    }
  }
  UserCheck(PETSC_FALSE, OptionsComm(),
            "-task critical: the rods are stable up to %.4g times the loads; load them otherwise",
            (double)a);
  PetscFunctionReturn(0);
}

/* ---- making ---- */

static PetscErrorCode CreateMatrix(const Rod rod, Mat *J) {
  PetscInt *late, n;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(2 * rod->rods, &late));
  n = RodLate(rod, late);
  PetscCall(BlockLUCreate(rod->last + 1, rod->model->fields, n, late, J));
  PetscCall(PetscFree(late));
  PetscFunctionReturn(0);
}

/* 1 for each place and director that is not held, see modes.h. */
static PetscErrorCode SetMoves(Frame *self) {
  const Rod rod = self->rod;
  const PetscInt fields = rod->model->fields;
  PetscScalar *free;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(self->U, &self->moves));
  PetscCall(VecGetArray(self->moves, &free));
  for (PetscInt k = 0; k < rod->rods; k++) {
    const Scene scene = rod->each[k]->scene;
    for (PetscInt i = rod->at[k]; i < rod->at[k + 1]; i++)
      for (PetscInt f = 0; f < fields; f++) {
        const PetscBool base = (PetscBool)(i == rod->at[k] && scene->clamp == CLAMP_HELD);
        const PetscBool tip =
            (PetscBool)(i == rod->at[k + 1] - 1 &&
                        (f < 3 ? TipHolds(&scene->tip, 0) : TipPoints(&scene->tip)));
        free[i * fields + f] = !base && !tip && rod->model->followed[f];
      }
  }
  PetscCall(VecRestoreArray(self->moves, &free));
  PetscFunctionReturn(0);
}

static PetscErrorCode Create(Run *run, Frame *self) {
  Vec *const vector[] = {&self->U,    &self->rest,    &self->F,
                         &self->work, &self->from[0], &self->from[1]};
  PetscInt n;

  PetscFunctionBegin;
  *self = (Frame){.run = run, .rod = run->leg.rod};
  UserCheck(
      BlockLUCan(self->rod->last + 1, self->rod->model->fields), OptionsComm(),
      "-rod_cells: -task critical of several rods has a matrix of all, and there are too many "
      "cells for it; take fewer");
  PetscCall(TakeLoads(self));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vector); i++)
    PetscCall(VecDuplicate(run->leg.U, vector[i]));
  PetscCall(VecZeroEntries(self->rest));
  PetscCall(VecGetLocalSize(self->U, &n));
  PetscCall(CreateMatrix(self->rod, &self->A));
  PetscCall(CreateMatrix(self->rod, &self->twice));
  PetscCall(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, self, &self->B));
  PetscCall(MatShellSetOperation(self->B, MATOP_MULT, (void (*)(void))ApplyRates));
  PetscCall(KSPCreate(PETSC_COMM_SELF, &self->ksp));
  PetscCall(BlockLUSetSolver(self->ksp));
  PetscCall(SetMoves(self));
  PetscCall(ModesCreate(self->A, self->B, self->ksp, self->moves, &self->modes));
  PetscFunctionReturn(0);
}

static PetscErrorCode Destroy(Frame *self) {
  Vec *const vector[] = {&self->U,       &self->rest,    &self->F,     &self->work,
                         &self->from[0], &self->from[1], &self->moves, &self->mode};

  PetscFunctionBegin;
  PetscCall(ModesDestroy(&self->modes));
  PetscCall(KSPDestroy(&self->ksp));
  PetscCall(MatDestroy(&self->A));
  PetscCall(MatDestroy(&self->twice));
  PetscCall(MatDestroy(&self->B));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vector); i++) PetscCall(VecDestroy(vector[i]));
  PetscCall(PetscFree(self->given));
  PetscFunctionReturn(0);
}

/* ---- what is told ---- */

/* The rod whose places go farthest in the mode. */
static PetscErrorCode Farthest(const Frame *self, PetscInt *which) {
  const PetscInt fields = self->rod->model->fields;
  const PetscScalar *u;
  PetscReal most = -1;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(self->mode, &u));
  for (PetscInt k = 0; k < self->rod->rods; k++)
    for (PetscInt i = self->rod->at[k]; i < self->rod->at[k + 1]; i++) {
      PetscReal size = 0;
      for (int d = 0; d < 3; d++) size += PetscSqr(u[i * fields + d]);
      if (size > most) *which = k;
      most = PetscMax(size, most);
    }
  PetscCall(VecRestoreArrayRead(self->mode, &u));
  PetscFunctionReturn(0);
}

/* The mode as places go, the largest 1, and where the rods are then. */
static PetscErrorCode WriteMode(const Frame *self, HdfFile file) {
  const Rod rod = self->rod;
  const PetscInt n = rod->last + 1, fields = rod->model->fields, dims[] = {n, 3};
  PetscReal(*x)[3], (*moves)[3], most = 0, *first;
  const PetscScalar *u, *state;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(n, &x, n, &moves, rod->rods, &first));
  PetscCall(VecGetArrayRead(self->mode, &u));
  PetscCall(VecGetArrayRead(self->U, &state));
  for (PetscInt k = 0; k < rod->rods; k++)
    for (PetscInt i = rod->at[k]; i < rod->at[k + 1]; i++) {
      ScenePlaceToLab(rod->each[k]->scene, state + i * fields, x[i]);
      SceneToLab(rod->each[k]->scene, u + i * fields, moves[i]);
      for (int d = 0; d < 3; d++) most = PetscMax(most, PetscAbsReal(moves[i][d]));
    }
  for (PetscInt i = 0; i < n && most > 0; i++)
    for (int d = 0; d < 3; d++) moves[i][d] /= most;
  for (PetscInt k = 0; k < rod->rods; k++) first[k] = (PetscReal)rod->at[k];
  PetscCall(VecRestoreArrayRead(self->U, &state));
  PetscCall(VecRestoreArrayRead(self->mode, &u));
  PetscCall(HdfWrite(file, "/critical/first", 1, &rod->rods, first, "1",
                     "first node of each rod [rods]"));
  PetscCall(HdfWrite(file, "/critical/x", 2, dims, x[0], "l", "where the rods are then [n, 3]"));
  PetscCall(HdfWrite(file, "/critical/mode", 2, dims, moves[0], "1",
                     "how they begin to move, largest 1 [n, 3]"));
  PetscCall(PetscFree3(x, moves, first));
  PetscFunctionReturn(0);
}

typedef struct {
  PetscReal factor, error, frequency;
} Found;

static PetscErrorCode Write(const Frame *self, const Found *found, HdfFile file) {
  const struct {
    const char *name, *units, *text;
    PetscReal value;
  } numbers[] = {{"factor", "1", "factor of all loads", found->factor},
                 {"error", "1", "bound on its error", found->error},
                 {"frequency", "rad V/l", "of the flutter; 0: buckling", found->frequency}};
  char name[64], *names;
  size_t size = 1;

  PetscFunctionBegin;
  if (!file) PetscFunctionReturn(0);
  PetscCall(HdfGroup(file, "/critical"));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(numbers); i++) {
    (void)snprintf(name, sizeof(name), "/critical/%s", numbers[i].name);
    PetscCall(HdfWrite(file, name, 0, NULL, &numbers[i].value, numbers[i].units, numbers[i].text));
  }
  PetscCall(WriteMode(self, file));
  for (PetscInt k = 0; k < self->rod->rods; k++) size += ROD_NAME + 1;
  PetscCall(PetscCalloc1(size, &names));
  for (PetscInt k = 0; k < self->rod->rods; k++) {
    PetscCall(PetscStrlcat(names, k ? "\n" : "", size));
    PetscCall(PetscStrlcat(names, RodsName(self->run->rods, k), size));
  }
  PetscCall(HdfText(file, "/critical", "rods", names));
  PetscCall(PetscFree(names));
  PetscCall(OutputAttributes(file, PETSC_COMM_SELF, PETSC_TRUE));
  PetscFunctionReturn(0);
}

static PetscErrorCode Print(const Frame *self, const Found *found) {
  PetscInt which = 0;

  PetscFunctionBegin;
  PetscCall(Farthest(self, &which));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "critical factor of all loads: %.12g\nerror below %.1e\n",
                        (double)found->factor, (double)found->error));
  if (found->frequency > 0)
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "flutter, frequency %.6g per unit of t",
                          (double)found->frequency));
  else
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "buckling"));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "; of the rods %s moves most\n",
                        RodsName(self->run->rods, which)));
  PetscFunctionReturn(0);
}

/* ---- the task ---- */

/* What has no state at rest, or no modes of it. */
static PetscErrorCode Check(const Run *run) {
  const char *const about = "-task critical of several rods is about frames that stand";

  PetscFunctionBegin;
  for (PetscInt k = 0; k < run->n; k++) {
    const Scene scene = run->scene[k];
    PetscCall(RodsEnter(run->rods, k));
    UserCheck(!strcmp(scene->growth->type, "none"), OptionsComm(),
              "-growth_type %s: %s, and grow no more; give -growth_type none", scene->growth->type,
              about);
    UserCheck(scene->born == 0, OptionsComm(), "-born: %s, all rods from the start; take it out",
              about);
    UserCheck(!scene->contact.any, OptionsComm(), "-%s: %s and touch nothing; take it out",
              scene->contact.self || scene->contact.among ? "contact_rods" : "wall_file", about);
    UserCheck(!LoadSticks(&scene->load) && !scene->load.limit, OptionsComm(),
              "-friction_beta: %s, and what sticks has no modes; give a value above 0, or "
              "-friction_mu 0",
              about);
    UserCheck(!TipResists(&scene->tip), OptionsComm(),
              "-tip_law resistance: %s, and at rest there is none; take it out", about);
    PetscCall(RodsLeave(run->rods));
  }
  PetscFunctionReturn(0);
}

/* On the mesh as asked for, or with half the cells. */
static PetscErrorCode FindOn(Run *run, Frame *frame, Found *found) {
  PetscFunctionBegin;
  PetscCall(RunBegin(run));
  PetscCall(Check(run));
  PetscCall(Create(run, frame));
  PetscCall(Find(frame, &found->factor));
  found->frequency = frame->growing.frequency;
  PetscCall(VecDuplicate(frame->U, &frame->mode));
  PetscCall(EPSGetEigenvector(frame->modes.eps, frame->growing.which, frame->mode, NULL));
  PetscFunctionReturn(0);
}

static PetscErrorCode FindHalf(PetscReal *factor) {
  Run run = {.restart = "", .stopped_by = -1, .halved = PETSC_TRUE};
  PetscErrorCode error;
  Frame frame = {0};
  Found found = {0};

  PetscFunctionBegin;
  error = FindOn(&run, &frame, &found);
  PetscCall(Destroy(&frame));
  PetscCall(RunEnd(&run));
  PetscCall(error);
  *factor = found.factor;
  PetscFunctionReturn(0);
}

static PetscErrorCode FindAndStore(Run *run, Frame *frame, const char *output) {
  HdfFile file = NULL;
  PetscErrorCode error;
  Found found = {0};
  PetscReal half = 0;

  PetscFunctionBegin;
  PetscCall(FindOn(run, frame, &found));
  PetscCall(FindHalf(&half));
  found.error = PetscAbsReal(found.factor - half) + 1e-10 * found.factor;
  PetscCall(Print(frame, &found));
  if (output[0]) PetscCall(OutputNewFile("-output", output, PETSC_COMM_SELF, &file));
  error = Write(frame, &found, file);
  if (error) PetscCall(OutputDropFile(output, &file));
  PetscCall(error);
  if (output[0]) PetscCall(OutputEndFile("-output", output, PETSC_COMM_SELF, &file));
  PetscFunctionReturn(0);
}

/*
  FrameCritical - -task critical of several rods: finds the factor of all loads under which they
  stop being stable, prints it and stores it with its mode. On one rank.

  The error bound is the change from half the cells, and what modes are found to.
*/
PetscErrorCode FrameCritical(const Single *asked) {
  Run run = {.restart = "", .stopped_by = -1};
  PetscErrorCode error;
  Frame frame = {0};

  PetscFunctionBegin;
  error = FindAndStore(&run, &frame, asked->output);
  PetscCall(Destroy(&frame));
  PetscCall(RunEnd(&run));
  PetscCall(error);
  PetscFunctionReturn(0);
}
