#include "stepping/snap.h"
#include "base/signals.h"
#include "stepping/leg.h"
#include "stepping/vbdf.h"

/*
  Dry friction is 1 per length at most. Where a bent rod pulls harder, no velocity balances it: with
  mu = 1 the rod snaps, and where it comes to rest depends on the path. The path is that of a
  vanishing viscous share d: friction mu v/|v| + d v, of which d v is the finite velocity in the
  fast time t/d. So growth stands still, friction is dry and viscous of strength 1, and the rod is
  followed until it rests.
*/
static const PetscReal rest = 1e-6, long_after = 1e4; /* velocity at rest; fast time to get there */
/* Velocities in it have no unit, and times that of lengths: they are in the scene's. */
/* Friction of strength 1 lets a rod fall in about that: what bends it sharply moves in 1e-10 of
   it, and not to see that is to take the fall in one step. */
static const PetscReal falls_in = 1;
/* A rod that falls from rest begins slowly: it is at rest if it does not gain speed. Pressed
   against a wall it may be next to straight, and what disturbed it dies out before the bend grows
   by which it falls: there so much fast time is waited, too. (Where nothing can press, a rod that
   did not snap is let go at once.) */
static const PetscReal soonest = 100;
/* Steps need not be more accurate than the slack of LoadInFastTime(). Newton's method must be, in
   steps of any tolerance: what it leaves over is a force on the rod at rest, and beyond the slack
   makes it snap again at once. */
static const PetscReal least_rtol = 1e-6;

/* A snap takes some 150 steps, 1000 from one wave length to another, up to 2000 of a rod in space
   under exact friction. One that does not rest in so many, or in so many iterations, is being
   chased by a Newton iteration that fails, and must not hold up the run for ever. */
static const PetscInt most_steps = 5000, most_iterations = 20000;

/* A snap may take longer than its run: who wants that to end is heard here, too. (A signal may have
   reached one rank only.) */
static PetscErrorCode Hear(Leg *leg) {
  int number = SignalCaught();

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &number, 1, MPI_INT, MPI_MAX, leg->rod->scene->comm));
  leg->interrupted = number;
  if (number) PetscCall(TSSetConvergedReason(leg->ts, TS_DIVERGED_STEP_REJECTED));
  PetscFunctionReturn(0);
}

/* The largest rate of the fields whose names begin with one of these letters. */
static PetscReal Fastest(const RodModel *model, const char *letters,
                         const PetscReal speed[MAX_FIELDS]) {
  PetscReal fastest = 0;

  for (PetscInt f = 0; f < model->fields; f++)
    if (strchr(letters, model->field[f][0])) fastest = PetscMax(fastest, speed[f]);
  return fastest;
}

static PetscReal SpeedOfPlaces(const RodModel *model, const PetscReal speed[MAX_FIELDS]) {
  return Fastest(model, "xy", speed);
}

/* The rate at which a rod in space turns, at its fastest place: of its quaternions, twice. */
static PetscReal SpeedOfTurning(const RodModel *model, const PetscReal speed[MAX_FIELDS]) {
  return 2 * Fastest(model, "p", speed);
}

/* Where friction does not feel the spin a rod may turn over about its own tangent, as a bent one
   does that is turned in a bent duct. No viscous share holds that back, so it takes no time in the
   fast time either: rates of turning have no bound, while places, which friction feels, move
   little. The rate of such a turn, 0 of what turns with its places. (Of rods that came to rest none
   turned more than 324 times as fast as that, in a blow; one that starts far out of balance turns
   into line 1500 times as fast, slower with each step.) */
static PetscReal FreeTurning(const Rod rod, const PetscReal speed[MAX_FIELDS]) {
  const PetscReal far = 1e3, turning = SpeedOfTurning(rod->model, speed) * rod->scene->units.length;

  if (!rod->model->space || rod->scene->load.radius > 0) return 0;
  return turning > far * (1 + SpeedOfPlaces(rod->model, speed)) ? turning : 0;
}

/* Behind each step in the fast time: is the rod at rest, or can it not be followed there? */
static PetscErrorCode StopAtRest(TS ts) {
  Leg *leg;
  PetscReal speed[MAX_FIELDS], fastest = 0, turning, t, unit;
  PetscInt iterations;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &leg));
  unit = leg->rod->scene->units.length;
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetSNESIterations(ts, &iterations));
  if (iterations > most_iterations) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_ITS));
  PetscCall(RodFieldSizes(leg->rod, leg->newton.latest.U_t, speed));
  for (PetscInt f = 0; f < leg->rod->model->fields; f++)
    if (leg->rod->model->followed[f])
      fastest = PetscMax(fastest, speed[f] * unit / RodFieldUnit(leg->rod, f));
  if (fastest < rest && fastest <= leg->speed &&
      (t >= soonest * unit || !leg->rod->scene->contact.any))
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  leg->speed = fastest;
  turning = FreeTurning(leg->rod, speed);
  leg->spins = (PetscBool)(leg->turning > 0 && turning > leg->turning);
  leg->turning = turning;
  if (leg->spins) PetscCall(TSSetConvergedReason(ts, TS_DIVERGED_STEP_REJECTED));
  SceneAtSpeed(leg->rod->scene, SpeedOfPlaces(leg->rod->model, speed));
  PetscCall(Hear(leg));
  PetscFunctionReturn(0);
}

/* A rod that is asked too early rests where it is, within what steps tell (part of each field). It
   is left there, with its history: a state that is new, if by next to nothing, would cost some ten
   steps of next to nothing, and it is asked again. */
static const PetscReal stays = 1e-6;

/* Is V another state than U? */
static PetscErrorCode Moved(const Rod rod, Vec U, Vec V, PetscBool *moved) {
  PetscReal size[MAX_FIELDS], change[MAX_FIELDS];
  Vec D;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(U, &D));
  PetscCall(VecWAXPY(D, -1, U, V));
  PetscCall(RodFieldSizes(rod, D, change));
  PetscCall(RodFieldSizes(rod, V, size));
  PetscCall(VecDestroy(&D));
  *moved = PETSC_FALSE;
  for (PetscInt f = 0; f < rod->model->fields; f++)
    if (rod->model->followed[f] && change[f] > stays * size[f]) *moved = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/* What held places at rest before a snap holds them no more: the shifts of exact Coulomb friction
   (Newton's method remembers them) begin anew. */
static PetscErrorCode LetGo(Rod rod) {
  Vec none;
  DM da;

  PetscFunctionBegin;
  if (!rod->memory || !LoadSticks(&rod->scene->load)) PetscFunctionReturn(0);
  PetscCall(RodCreateMemory(rod, &da, &none));
  PetscCall(VecSet(none, 0));
  PetscCall(rod->model->recall(rod, none));
  PetscCall(VecDestroy(&none));
  PetscCall(DMDestroy(&da));
  PetscFunctionReturn(0);
}

/*
  SnapFollow - a VBDFSnap: takes a rod that dry friction cannot hold to where it rests. Collective.

  ts    of a leg          t, U  where the rod snaps; U is, on exit, where it rests
  done  false, U as it was: friction is not dry, the snap could not be followed, there is none, or a
        signal came meanwhile, or the rod spins with nothing to hold it, which the leg keeps: then
        ts ends, too
*/
PetscErrorCode SnapFollow(TS ts, PetscReal t, Vec U, PetscBool *done) {
  Scene fast;
  TSConvergedReason reason;
  PetscBool dry;
  PetscInt steps, iterations;
  Leg *slow, leg;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &slow));
  if (!slow->rod->scene->load.shared && LoadShareMore(&slow->rod->scene->load))
    PetscCall(PetscInfo(ts, "from here on a part of dry friction is viscous\n"));
  *done = PETSC_FALSE;
  PetscCall(SceneInFastTime(slow->rod->scene, t, &fast, &dry));
  if (!dry) {
    PetscCall(SceneLeaveFastTime(&fast));
    PetscFunctionReturn(0);
  }
  fast->end_time = long_after * fast->units.length;
  PetscCall(LegCreate(fast, slow->rod->model, PetscMax(slow->rtol, least_rtol), "snap_", &leg));
  NewtonToRest(&leg.newton, least_rtol, rest);
  PetscCall(VBDFSetScale(leg.ts, falls_in * fast->units.length));
  PetscCall(TSSetPostStep(leg.ts, StopAtRest));
  PetscCall(TSSetMaxSteps(leg.ts, most_steps));
  PetscCall(VecCopy(U, leg.U));
  PetscCall(TSSolve(leg.ts, leg.U));
  PetscCall(TSGetConvergedReason(leg.ts, &reason));
  *done = (PetscBool)(reason > 0 && reason != TS_CONVERGED_ITS);
  if (*done) PetscCall(Moved(slow->rod, U, leg.U, done));
  if (*done) {
    PetscCall(VecCopy(leg.U, U));
    PetscCall(LetGo(slow->rod));
  }
  slow->interrupted = leg.interrupted;
  slow->spins = leg.spins;
  if (leg.interrupted || leg.spins) PetscCall(TSSetConvergedReason(ts, TS_DIVERGED_STEP_REJECTED));
  PetscCall(TSGetStepNumber(leg.ts, &steps));
  PetscCall(LegIterations(&leg, &iterations));
  slow->nested += iterations;
  PetscCall(PetscInfo(ts, "snap at t = %g: %s after %d steps\n", (double)t,
                      TSConvergedReasons[reason], (int)steps));
  PetscCall(LegDestroy(&leg));
  slow->rod->scene->contact.firm = fast->contact.firm; /* it may have got so on the way */
  PetscCall(SceneLeaveFastTime(&fast));
  PetscFunctionReturn(0);
}
